//! The figures of a study as files.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use answers::{FigureRows, Results};
use anyhow::{Context, Result, anyhow, bail};
use report::{DataTable, FigureError, FigureForm, FigureSpec, PlotFigure};
use study::columns::{Role, along_path, find};
use study::figure::FigureKind;
use study::label::{label, quantity_name};
use study::units::Dimension;
use study::{Adaptive, RootSearch, Study};

use crate::influence_figure;
use crate::written_file::{check_own, write};

/// The resolution of PNG files, in dots per inch.
pub(crate) const RESOLUTION: f64 = 300.0;

/// Returns the two files of a figure, given their name without ending.
fn figure_files(stem: &Path) -> Vec<PathBuf> {
    ["svg", "png"].map(|ending| PathBuf::from(format!("{}.{ending}", stem.display()))).to_vec()
}

/// Returns the two files of a figure whose name nobody has chosen, and refuses what is no file of
/// its own.
pub(crate) fn own_files(stem: &Path) -> Result<Vec<PathBuf>> {
    let files = figure_files(stem);
    files.iter().try_for_each(|file| check_own(file))?;
    Ok(files)
}

/// Draws a study's figure to files that end in .svg or .png, from the rows for which `filter`
/// holds, and says how many points are missing, if some are.
pub(crate) fn draw(
    results: &Results,
    figure: &study::Figure,
    filter: Option<&str>,
    files: &[PathBuf],
) -> Result<Option<String>> {
    let drawn = || -> Result<Option<String>> {
        let PicturedFigure { picture, missing, .. } = pictured(results, figure, filter)?;
        let svg = picture.svg();
        files.iter().try_for_each(|file| match file.extension().and_then(OsStr::to_str) {
            Some("svg") => write(file, svg.as_bytes()),
            Some("png") => write(file, &report::png(&svg, RESOLUTION)?),
            _ => bail!("{}: a figure is written as .svg or .png", file.display()),
        })?;
        Ok(missing)
    };
    match results.study().figures() {
        [_, _, ..] => drawn().with_context(|| format!("figure `{}`", figure.name)),
        _ => drawn(),
    }
}

/// A figure with the rows that it was made of.
pub(crate) struct PicturedFigure {
    pub(crate) picture: PlotFigure,
    pub(crate) table: DataTable,
    /// The sentence about points that are missing, if some are.
    pub(crate) missing: Option<String>,
}

/// Returns a study's figure of the rows for which `filter` holds.
pub(crate) fn pictured(
    results: &Results,
    figure: &study::Figure,
    filter: Option<&str>,
) -> Result<PicturedFigure> {
    if figure.kind == FigureKind::Sensitivity {
        return influence_pictured(results, figure, filter);
    }
    let FigureRows { table, undrawn } = results.figure_rows(figure, filter)?;
    let missing = undrawn.words();
    let picture = match (picture(results.study(), &table, figure, missing.as_deref()), &missing) {
        (Err(error @ FigureError::NothingToDraw { .. }), Some(missing)) => {
            return Err(anyhow!(error).context(missing.clone()));
        }
        (picture, _) => picture?,
    };
    Ok(PicturedFigure { picture, table, missing })
}

/// Returns a study's figure of the influence of its keys.
fn influence_pictured(
    results: &Results,
    figure: &study::Figure,
    filter: Option<&str>,
) -> Result<PicturedFigure> {
    if filter.is_some() {
        bail!("the influence of keys is of the whole design, and --where has no meaning for it");
    }
    let missing = results.undrawn(figure, None)?.words();
    let picture = influence_figure::picture(results, figure, missing.as_deref());
    let picture = match &missing {
        Some(missing) => picture.with_context(|| missing.clone())?,
        None => picture?,
    };
    let table = DataTable::new(Vec::new(), Vec::new())?;
    Ok(PicturedFigure { picture, table, missing })
}

/// Returns the figure of a table, with labels and units for its columns, and a note of what is
/// `missing` in it.
fn picture(
    study: &Study,
    table: &DataTable,
    figure: &study::Figure,
    missing: Option<&str>,
) -> Result<PlotFigure, FigureError> {
    let columns = if figure.steps { along_path(study.columns()) } else { study.columns() };
    let labels: Vec<(&str, String)> =
        columns.iter().map(|column| (column.name.as_ref(), label(column, &columns))).collect();
    let labels: Vec<(&str, &str)> =
        labels.iter().map(|(name, label)| (*name, label.as_str())).collect();
    let [y, series] = [&figure.y, &figure.series]
        .map(|names| names.iter().map(String::as_str).collect::<Vec<_>>());
    // The two ends of a band are one quantity.
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
    // Times are ranked as far as their noise tells them apart.
    let is_of_times = figure.front && figure.x == "seconds";
    let noise = find(&columns, "noise").filter(|_| is_of_times).map(|column| column.name.as_ref());
    let level = level(study, figure);
    let marks = "The dashed line is the value that is looked for; rings are where curves cross it.";
    let missing = missing.map(|missing| format!("{missing}."));
    let note = missing.into_iter().chain(level.map(|_| marks.to_owned()));
    let notes: Vec<String> = note.collect();
    let notes: Vec<&str> = notes.iter().map(String::as_str).collect();
    let form = match figure.kind {
        FigureKind::Curves => FigureForm::Curves,
        FigureKind::Scatter => FigureForm::Scatter,
        FigureKind::Histogram => {
            let bins = figure.bins.map(|bins| bins as usize);
            FigureForm::Histogram { bins, share: figure.share }
        }
        // Its columns are not those of points.
        FigureKind::Sensitivity => return Err(FigureError::NoY),
    };
    let spec = FigureSpec {
        form,
        x: &figure.x,
        notes: &notes,
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
        noise,
        level,
        names: figure.names.as_deref(),
    };
    PlotFigure::from_table(table, &spec)
}

/// Returns the value that a study looks for, where a figure shows the result over the axis along
/// which it looks.
fn level(study: &Study, figure: &study::Figure) -> Option<f64> {
    let Some(Adaptive::Find(RootSearch { column, value, axis, .. })) = study.adaptive() else {
        return None;
    };
    let axis = study.axes().nth(*axis)?.column();
    (!figure.steps && figure.x == axis && figure.y == [column.clone()]).then_some(*value)
}

/// Says why there is no figure of a study whose axes suggest some.
pub(crate) fn nothing_varies(study: &Study) -> String {
    let mut axes: Vec<&str> = Vec::new();
    for figure in study.suggestions() {
        if !axes.contains(&figure.x.as_str()) {
            axes.push(&figure.x);
        }
    }
    format!("nothing that the scenes leave free varies along {}", axes.join(" or "))
}
