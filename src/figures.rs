//! The figures of a study as files.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use answers::Results;
use anyhow::{Context, Result, bail};
use report::{DataTable, FigureSpec, PlotFigure};
use study::Study;
use study::columns::{Role, along_path, find};
use study::label::{label, quantity_name};
use study::units::Dimension;

/// The resolution of PNG files, in dots per inch.
pub(crate) const RESOLUTION: f64 = 300.0;

/// Returns the two files of a figure, given their name without ending.
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
        let table = results.figure_table(figure, filter)?;
        let svg = picture(results.study(), &table, figure)?.svg();
        files.iter().try_for_each(|file| match file.extension().and_then(OsStr::to_str) {
            Some("svg") => write(file, svg.as_bytes()),
            Some("png") => write(file, &report::png(&svg, RESOLUTION)?),
            _ => bail!("{}: a figure is written as .svg or .png", file.display()),
        })
    };
    match results.study().figures() {
        [_, _, ..] => drawn().with_context(|| format!("figure `{}`", figure.name)),
        _ => drawn(),
    }
}

/// Returns the figure of a table, with labels and units for its columns.
fn picture(study: &Study, table: &DataTable, figure: &study::Figure) -> Result<PlotFigure> {
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

/// Writes a file whole.
pub(crate) fn write(file: &Path, bytes: &[u8]) -> Result<()> {
    std::fs::write(file, bytes).with_context(|| format!("cannot write {}", file.display()))
}
