//! `plot`: the figures of a study as files.

use std::path::Path;

use answers::Results;
use anyhow::{Result, bail};
use study::figure::FigureKind;

use crate::cli::PlotArgs;
use crate::figures::{draw, nothing_varies, own_files};
use crate::output::{self, Finish};
use crate::proposal;
use crate::stored_results::StoredResults;
use crate::written_file;

/// Draws figures of a study to files.
pub(crate) fn plot(args: &PlotArgs) -> Result<Finish> {
    args.output.as_deref().map_or(Ok(()), written_file::check)?;
    let stored = StoredResults::of(&args.store.store, &args.name)?;
    let results = stored.read()?;
    let figures = chosen(args, &results)?;
    if let (Some(file), [_, _, ..]) = (&args.output, &figures[..]) {
        let names =
            figures.iter().map(|figure| figure.name.as_str()).collect::<Vec<_>>().join(", ");
        bail!(
            "{} holds one figure and the study has {names}; choose one with --figure",
            file.display()
        );
    }
    let (mut written, mut failed) = (Vec::new(), None);
    for figure in &figures {
        let stem = figure.stem(results.study().name());
        let files = match &args.output {
            Some(file) => Ok(vec![file.clone()]),
            None => own_files(Path::new(&stem)),
        };
        let drawn = files
            .and_then(|files| Ok((draw(&results, figure, args.filter.as_deref(), &files)?, files)));
        match drawn {
            Ok((missing, files)) => {
                for (file, missing) in files.iter().zip(missing.iter().cycle()) {
                    output::say(&format!("{}: {missing}", file.display()));
                }
                written.extend(files);
            }
            // A figure that cannot be drawn hinders no other.
            Err(error) => failed.replace(error).iter().for_each(output::complain),
        }
    }
    if args.json && !written.is_empty() {
        output::print_json(&written)?;
    } else {
        output::print(
            &written.iter().map(|file| format!("{}\n", file.display())).collect::<String>(),
        )?;
    }
    failed.map_or(Ok(Finish::AllDone), Err)
}

/// Returns the study's figures or the one that is named, as they are or, with columns or axes
/// given, the first of them changed.
fn chosen(args: &PlotArgs, results: &Results<'_>) -> Result<Vec<study::Figure>> {
    let study = results.study();
    let figures = named_figures(args, results.figures()?)?;
    let PlotArgs { x, y, series, panels, steps, log_x, log_y, .. } = args;
    let kind = FigureKind::ALL.into_iter().find(|kind| args.kind.as_deref() == Some(kind.name()));
    let is_counted = kind == Some(FigureKind::Histogram) || args.bins.is_some() || args.share;
    if is_counted && !y.is_empty() {
        bail!("a histogram counts the points along --x and has no --y");
    }
    let is_unchanged = x.is_none()
        && kind.is_none()
        && !is_counted
        && y.is_empty()
        && series.is_none()
        && panels.is_none()
        && !(*steps || *log_x || *log_y);
    if is_unchanged && !figures.is_empty() {
        return Ok(figures);
    }
    let has_other_columns = x.is_some() || !y.is_empty();
    let mut figure = match (figures.into_iter().next(), x, y.is_empty()) {
        (Some(figure), ..) => figure,
        (None, Some(x), is_empty) if !is_empty || is_counted => {
            study::Figure::new(x.clone(), y.clone())
        }
        _ => {
            let why = match study.suggestions() {
                [] => "the study suggests no figure".to_owned(),
                _ => format!("the study suggests no figure: {}", nothing_varies(study)),
            };
            bail!(
                "{why}; name its columns with --x and --y (`{}` lists them)",
                proposal::command(&args.store.store, ["query", &args.name, "--columns"])
            )
        }
    };
    if is_counted {
        (figure.kind, figure.band, figure.front, figure.fit) =
            (FigureKind::Histogram, None, false, false);
        (figure.y, figure.names, figure.log_y) = (Vec::new(), None, false);
        (figure.bins, figure.share) = (args.bins.or(figure.bins), figure.share || args.share);
    } else if let Some(kind) = kind {
        figure.kind = kind;
    } else if has_other_columns
        && !*steps
        && (!y.is_empty() || figure.kind != FigureKind::Histogram)
        && (x.is_some() || figure.kind != FigureKind::Sensitivity)
    {
        figure.kind = FigureKind::usual(study.groups());
    }
    if *steps {
        figure.kind = FigureKind::Curves;
    }
    if figure.kind != FigureKind::Histogram
        && figure.y.is_empty()
        && figure.band.is_none()
        && y.is_empty()
    {
        bail!("the study's figure is a histogram; name columns for another one with --y");
    }
    if let Some(x) = x {
        // A figure over another abscissa is another figure.
        (figure.x, figure.steps) = (x.clone(), false);
    }
    if figure.kind == FigureKind::Sensitivity
        && (series.is_some() || panels.is_some() || *steps || *log_x || *log_y)
    {
        bail!(
            "the figure shows the influence of keys on results, which --y names; --series, --panels, \
             --steps, --log-x and --log-y are of figures of points, whose abscissa --x names"
        );
    }
    if !y.is_empty() {
        figure.y.clone_from(y);
    }
    if has_other_columns {
        figure.title = Some(study.name().to_owned());
    }
    if let Some(series) = series {
        figure.series.clone_from(series);
    }
    if let Some(panels) = panels {
        figure.panels = Some(panels.clone());
    }
    figure.steps |= steps;
    figure.log_x |= log_x;
    figure.log_y |= log_y;
    // A column cannot be drawn along x and tell the curves apart at once.
    figure.series.retain(|name| *name != figure.x);
    figure.panels = figure.panels.filter(|name| *name != figure.x);
    Ok(vec![figure])
}

/// Returns the study's figures, or the one with the name that the arguments give.
fn named_figures(args: &PlotArgs, figures: &[study::Figure]) -> Result<Vec<study::Figure>> {
    let Some(name) = &args.figure else { return Ok(figures.to_vec()) };
    if let Some(figure) = figures.iter().find(|figure| figure.name == *name) {
        return Ok(vec![figure.clone()]);
    }
    if figures.is_empty() {
        bail!("the study has no figure `{name}`; it has none");
    }
    let names: Vec<String> = figures.iter().map(|figure| format!("`{}`", figure.name)).collect();
    bail!("the study has no figure `{name}`; it has {}", names.join(", "))
}
