//! The figures of a report.

use std::collections::HashMap;

use answers::Results;
use anyhow::Result;
use report::{PageBlock, PageFigure, PageSection};
use study::MOST_POINTS;
use study::figure::FigureKind;

use super::rows::JobRows;
use crate::figures::{PicturedFigure, nothing_varies, pictured};

/// The bytes of a figure, and of all together, that answer the pointer; others are pictures.
const SKETCH: usize = 350_000;
const ALL_SKETCHES: usize = 700_000;
/// The bytes that one point takes in a page.
const POINT: usize = 60;
/// The resolution of the others, in dots per inch.
const RESOLUTION: f64 = 144.0;

/// Returns the section with the figures of a study, of the rows for which a filter holds. The jobs
/// of the `listed` keys are in the page's table. A figure that cannot be drawn hinders no other.
pub(super) fn section(
    results: &Results<'_>,
    rows: &JobRows<'_>,
    listed: &[String],
    filter: Option<&str>,
    left_out: &mut Vec<String>,
) -> Result<PageSection> {
    let mut blocks = Vec::new();
    let places = places(listed);
    let figures = results.figures()?;
    if figures.is_empty() {
        let why = match results.study().suggestions() {
            _ if !results.study().is_listed() => {
                format!("There is no figure: figures have at most {MOST_POINTS} points.")
            }
            [] => "The study has no figure.".to_owned(),
            _ => format!("There is no figure: {}.", nothing_varies(results.study())),
        };
        blocks.push(PageBlock::Words(why));
    }
    let (mut used, mut has_sketch) = (0, false);
    for figure in figures {
        let PicturedFigure { mut picture, table, .. } =
            match pictured(results, figure, filter_of(figure, filter)) {
                Ok(pictured) => pictured,
                Err(error) => {
                    let sentence = format!("The figure {} is missing: {error:#}.", figure.name);
                    blocks.push(PageBlock::Warning(sentence.clone()));
                    left_out.push(sentence);
                    continue;
                }
            };
        let title = picture.title.clone();
        if title == results.study().question() {
            // The question stands above all.
            picture.title.clear();
        }
        let sketch = picture.sketch();
        let size = sketch.svg.len() + sketch.spots.len() * POINT;
        if size <= SKETCH && used + size <= ALL_SKETCHES {
            used += size;
            has_sketch = true;
            let is_of_rows = sketch.spots.iter().any(|spot| spot.row.is_some());
            let keys = match is_of_rows {
                true => results.figure_keys(figure, filter_of(figure, filter), &table)?,
                false => Vec::new(),
            };
            let job = |key: &report::Cell| match key {
                report::Cell::Text(key) => places.get(key.as_str()).copied(),
                _ => None,
            };
            let jobs = keys.iter().map(job).collect();
            blocks.push(PageBlock::Figure(PageFigure::Sketch { sketch, jobs }));
        } else {
            let sentence = format!(
                "The figure {} has {} points and is a picture, without values under the pointer; \
                 `{}` draws it.",
                figure.name,
                sketch.spots.len(),
                wording::command(["plot", &rows.study, "--figure", &figure.name])
            );
            let png = report::png(&picture.svg(), RESOLUTION)?;
            blocks.push(PageBlock::Figure(PageFigure::Picture { png, title }));
            blocks.push(PageBlock::Words(sentence.clone()));
            left_out.push(sentence);
        }
    }
    if has_sketch {
        blocks.insert(
            0,
            PageBlock::Words(
                "The values of the point nearest to the pointer are shown, a click chooses its \
                 job, and a click on an entry of the legend takes its curve away or brings it \
                 back. With a keyboard: Tab and the arrow keys."
                    .to_owned(),
            ),
        );
    }
    Ok(PageSection { id: "figures", title: "Figures", blocks })
}

/// Returns the filter of a figure; the influence of keys is of the whole design.
fn filter_of<'f>(figure: &study::Figure, filter: Option<&'f str>) -> Option<&'f str> {
    filter.filter(|_| figure.kind != FigureKind::Sensitivity)
}

/// Returns the row of each job in the page's table, which has these keys. Of several rows the first
/// counts.
fn places(keys: &[String]) -> HashMap<&str, usize> {
    let mut places = HashMap::new();
    for (row, key) in keys.iter().enumerate() {
        places.entry(key.as_str()).or_insert(row);
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_that_is_cut_from_the_table_has_no_place_in_it() {
        let listed = ["a", "b", "a"].map(str::to_owned);
        let places = places(&listed);
        assert_eq!(["a", "b", "c"].map(|key| places.get(key).copied()), [Some(0), Some(1), None]);
    }
}
