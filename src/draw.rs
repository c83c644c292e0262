//! Figures and fields as files: `plot`, and the fields of `show` and `solve`.

use std::ffi::OsStr;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use contact::outcome::Fields;
use report::{
    DataTable, Field, FieldGrid, FigureSpec, PlotFigure, TerminalInk, Values, field_csv, vti,
};
use store::Store;
use study::Study;
use study::columns::{Role, along_path, find};
use study::label::{label, quantity_name};
use study::units::Dimension;

use crate::cli::PlotArgs;
use crate::output::{self, Finish};
use crate::query::tell_origin;
use crate::results::{Results, Source, stored_study};

/// Dots per inch of PNG files.
const RESOLUTION: f64 = 300.0;

/// The two files of a figure, by their name without ending.
pub(crate) fn figure_files(stem: &Path) -> Vec<PathBuf> {
    ["svg", "png"].map(|ending| PathBuf::from(format!("{}.{ending}", stem.display()))).to_vec()
}

/// Draws a study's figure to files that end in .svg or .png, from the rows for which `filter`
/// holds.
pub(crate) fn draw(
    results: &Results,
    figure: &study::Figure,
    filter: Option<&str>,
    files: &[PathBuf],
) -> Result<()> {
    let drawn = || -> Result<()> {
        let mut table = results.figure_table(figure.steps)?;
        if let Some(expression) = filter {
            table = table.filter(expression)?;
        }
        let svg = picture(&results.study, &table, figure)?.svg();
        files.iter().try_for_each(|file| match file.extension().and_then(OsStr::to_str) {
            Some("svg") => write(file, svg.as_bytes()),
            Some("png") => write(file, &report::png(&svg, RESOLUTION)?),
            _ => bail!("{}: a figure is written as .svg or .png", file.display()),
        })
    };
    match results.study.figures() {
        [_, _, ..] => drawn().with_context(|| format!("figure `{}`", figure.name)),
        _ => drawn(),
    }
}

fn picture(study: &Study, table: &DataTable, figure: &study::Figure) -> Result<PlotFigure> {
    let columns = if figure.steps { along_path(study.columns()) } else { study.columns() };
    let labels: Vec<(&str, String)> =
        columns.iter().map(|column| (column.name.as_ref(), label(column, &columns))).collect();
    let labels: Vec<(&str, &str)> =
        labels.iter().map(|(name, label)| (*name, label.as_str())).collect();
    let [y, series] = [&figure.y, &figure.series]
        .map(|names| names.iter().map(String::as_str).collect::<Vec<_>>());
    // a pair of ends is one quantity
    let is_end = |names: &[String; 2]| names.iter().map(String::as_str).eq(["mu_low", "mu_high"]);
    let quantity =
        figure.y.first().and_then(|name| find(&columns, name)).map(|column| column.dimension);
    let is_error =
        |name: &String| find(&columns, name).is_some_and(|column| column.role == Role::Error);
    let y_label = match quantity.filter(|dimension| *dimension != Dimension::Pure) {
        Some(dimension) => quantity_name(dimension),
        None if figure.y.iter().all(is_error) => "relative error",
        None => "",
    };
    let spec = FigureSpec {
        x: &figure.x,
        y: &y,
        y_label: if figure.band.as_ref().is_some_and(is_end) {
            "end μ* of the uniqueness set"
        } else {
            y_label
        },
        series: &series,
        panels: figure.panels.as_deref(),
        along: figure.steps.then_some("increment"),
        labels: &labels,
        title: figure.title.as_deref().unwrap_or_else(|| study.question()),
        log_x: figure.log_x,
        log_y: figure.log_y,
        fit: figure.fit,
        band: figure.band.as_ref().map(|[low, high]| (low.as_str(), high.as_str())),
        front: figure.front,
        names: figure.names.as_deref(),
    };
    Ok(PlotFigure::from_table(table, &spec)?)
}

fn write(file: &Path, bytes: &[u8]) -> Result<()> {
    std::fs::write(file, bytes).with_context(|| format!("cannot write {}", file.display()))
}

pub(crate) fn plot(args: &PlotArgs) -> Result<Finish> {
    let reader = Store::read(&args.store.store)?;
    tell_origin(&reader);
    let results = Results::read(Source::Reader(&reader), stored_study(&reader, &args.name)?)?;
    let figures = chosen(args, &results.study)?;
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
        let stem = figure.stem(results.study.name());
        let files =
            args.output.clone().map_or_else(|| figure_files(Path::new(&stem)), |file| vec![file]);
        match draw(&results, figure, args.filter.as_deref(), &files) {
            Ok(()) => written.extend(files),
            // one that cannot be drawn hinders no other
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

/// The study's figures, or the one of a name; changed as asked, in which case it is one.
fn chosen(args: &PlotArgs, study: &Study) -> Result<Vec<study::Figure>> {
    let own = match &args.figure {
        None => study.figures().to_vec(),
        Some(name) => {
            let names = || {
                study
                    .figures()
                    .iter()
                    .map(|figure| format!("`{}`", figure.name))
                    .collect::<Vec<_>>()
                    .join(", ")
            };
            match study.figures().iter().find(|figure| figure.name == *name) {
                Some(figure) => vec![figure.clone()],
                None if study.figures().is_empty() => {
                    bail!("the study has no figure `{name}`; it has none")
                }
                None => bail!("the study has no figure `{name}`; it has {}", names()),
            }
        }
    };
    let PlotArgs { x, y, series, panels, steps, log_x, log_y, .. } = args;
    let as_it_is = x.is_none()
        && y.is_empty()
        && series.is_none()
        && panels.is_none()
        && !(*steps || *log_x || *log_y);
    if as_it_is && !own.is_empty() {
        return Ok(own);
    }
    let own = own.into_iter().next();
    let other_columns = x.is_some() || !y.is_empty();
    let mut figure = match (own, x, y.is_empty()) {
        (Some(figure), ..) => figure,
        (None, Some(x), false) => study::Figure::new(x.clone(), y.clone()),
        _ => {
            bail!(
                "the study suggests no figure; name its columns with --x and --y (`tribosweep query {} --columns` lists them)",
                args.name
            )
        }
    };
    if let Some(x) = x {
        // who asks for another abscissa asks for another figure
        (figure.x, figure.steps) = (x.clone(), false);
    }
    if !y.is_empty() {
        figure.y.clone_from(y);
    }
    if other_columns {
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
    // a column cannot be drawn along x and tell the curves apart at once
    figure.series.retain(|name| *name != figure.x);
    figure.panels = figure.panels.filter(|name| *name != figure.x);
    Ok(vec![figure])
}

/// The fields by name.
const FIELDS: [&str; 8] =
    ["pressure", "traction_x", "traction_y", "traction", "gap", "slip_x", "slip_y", "state"];

/// The endings of files that a field is written to.
const ENDINGS: [&str; 5] = ["png", "svg", "npy", "vti", "csv"];

/// Refuses a field that there is not, or a file of which nobody can tell what it is to be; before
/// it is computed.
pub(crate) fn check_field(name: &str, file: Option<&Path>) -> Result<()> {
    if !FIELDS.contains(&name) {
        bail!("there is no field `{name}`; there are {}", FIELDS.join(", "));
    }
    match file {
        Some(file)
            if !file
                .extension()
                .and_then(OsStr::to_str)
                .is_some_and(|ending| ENDINGS.contains(&ending)) =>
        {
            bail!("{}: a field is written as .{}", file.display(), ENDINGS.join(", ."))
        }
        _ => Ok(()),
    }
}

/// One of the fields of a result; masked elements have no value.
pub(crate) fn field(fields: &Fields, name: &str) -> Result<Field> {
    let [nx, ny] = fields.shape.map(|n| n as usize);
    let corner = [0, 1].map(|c| fields.origin[c] - 0.5 * fields.element[c]);
    let grid = FieldGrid { nx, ny, origin: corner, element: fields.element };
    let on_sole = |values: &[f64]| -> Values {
        Values::Number(
            values
                .iter()
                .zip(&fields.state)
                .map(|(value, state)| if *state == 0 { f64::NAN } else { *value })
                .collect(),
        )
    };
    let traction: Vec<f64>;
    let (unit, values) = match name {
        "pressure" => ("Pa", on_sole(&fields.pressure)),
        "traction_x" => ("Pa", on_sole(&fields.traction_x)),
        "traction_y" => ("Pa", on_sole(&fields.traction_y)),
        "traction" => {
            traction = fields
                .traction_x
                .iter()
                .zip(&fields.traction_y)
                .map(|(x, y)| x.hypot(*y))
                .collect();
            ("Pa", on_sole(&traction))
        }
        "gap" => ("m", on_sole(&fields.gap)),
        "slip_x" => ("m", on_sole(&fields.slip_x)),
        "slip_y" => ("m", on_sole(&fields.slip_y)),
        "state" => {
            let names = ["outside", "open", "stick", "slip"].map(str::to_owned).to_vec();
            ("", Values::Category { states: fields.state.clone(), names })
        }
        other => bail!("there is no field `{other}`"),
    };
    Ok(Field::new(name, unit, grid, values)?)
}

/// Draws a field on standard output or writes it to a file by its ending.
pub(crate) fn show_field(fields: &Fields, name: &str, file: Option<&Path>) -> Result<Finish> {
    check_field(name, file)?;
    let field = field(fields, name)?;
    let Some(file) = file else {
        let ink = if std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none() {
            TerminalInk::Color
        } else {
            TerminalInk::Ascii
        };
        return output::print(&field.terminal(output::terminal_width().unwrap_or(80), ink));
    };
    let bytes = match file.extension().and_then(OsStr::to_str) {
        Some("png") => report::png(&field.svg(), RESOLUTION)?,
        Some("svg") => field.svg().into_bytes(),
        Some("npy") => field.npy()?,
        Some("vti") => vti(&[&field])?.into_bytes(),
        Some("csv") => field_csv(&[&field])?.into_bytes(),
        _ => bail!("{}: a field is not written so", file.display()),
    };
    write(file, &bytes)?;
    output::print(&format!("{}\n", file.display()))
}
