//! Figures of bars with whiskers, of the columns of a table.

use super::error::{FigureError, MOST_PANELS, MOST_SERIES};
use super::figure::{PlotAxis, PlotFigure, PlotPanel, Series, Style};
use super::value_text::ValueFormat;
use crate::table::{Cell, DataTable, UnknownColumn};

/// The columns of a table that a figure of bars shows, for
/// [`PlotFigure::bars_from_table`](crate::PlotFigure::bars_from_table).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BarsSpec<'a> {
    /// The column whose words stand along the horizontal axis, in the order of the rows.
    pub x: &'a str,
    /// The label of the horizontal axis.
    pub x_label: &'a str,
    /// The bars that stand side by side above each word.
    pub bars: &'a [BarColumns<'a>],
    /// The label of the vertical axis.
    pub y_label: &'a str,
    /// The columns that have a panel for each combination of their values, in the order of the
    /// rows.
    pub panels: &'a [&'a str],
    /// The title above the figure.
    pub title: &'a str,
    /// Sentences that stand below the figure.
    pub notes: &'a [&'a str],
}

/// The columns of a bar and of its whisker, all in one unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BarColumns<'a> {
    /// The label in the legend.
    pub label: &'a str,
    /// The column of the tops.
    pub value: &'a str,
    /// The columns of the lower and of the upper ends of the whiskers.
    pub ends: Option<[&'a str; 2]>,
}

/// The part of a category that its bars fill.
const FILLED: f64 = 0.76;

impl PlotFigure {
    /// Makes a figure of bars from columns of a table.
    ///
    /// # Errors
    /// [`FigureError`], if there is no such column, or if there are too many bars or panels or
    /// none.
    pub fn bars_from_table(
        table: &DataTable,
        spec: &BarsSpec<'_>,
    ) -> Result<PlotFigure, FigureError> {
        let words = words(table, &[spec.x])?;
        let places = titles(table, spec.panels)?;
        let mut panels: Vec<PlotPanel> = Vec::new();
        if spec.bars.len() > MOST_SERIES {
            let columns = spec.bars.iter().map(|bars| bars.label).collect::<Vec<_>>().join(", ");
            return Err(FigureError::TooManySeries { columns, count: spec.bars.len() });
        }
        for title in distinct(&places) {
            let rows: Vec<usize> = (0..places.len()).filter(|row| places[*row] == title).collect();
            panels.push(panel(table, spec, title, &rows, &words)?);
        }
        if panels.len() > MOST_PANELS {
            let column = spec.panels.join(", ");
            return Err(FigureError::TooManyPanels { column, count: panels.len() });
        }
        let tops = || panels.iter().flat_map(|panel| &panel.series).flat_map(|s| &s.points);
        if !tops().any(|(_, top)| top.is_finite()) {
            return Err(FigureError::NothingToDraw {
                x: spec.x.to_owned(),
                y: spec.bars.iter().map(|bars| bars.value).collect::<Vec<_>>().join(", "),
                rows: table.rows().len(),
            });
        }
        Ok(PlotFigure {
            title: spec.title.to_owned(),
            legend: String::new(),
            notes: spec.notes.iter().map(|note| (*note).to_owned()).collect(),
            panels,
        })
    }
}

/// Makes the panel of some rows.
fn panel(
    table: &DataTable,
    spec: &BarsSpec<'_>,
    title: &str,
    rows: &[usize],
    words: &[String],
) -> Result<PlotPanel, FigureError> {
    let slot = FILLED / spec.bars.len().max(1) as f64;
    let middle = (spec.bars.len() as f64 - 1.0) / 2.0;
    let mut unit = String::new();
    let mut series = Vec::new();
    for (index, bars) in spec.bars.iter().enumerate() {
        let value = table.column(bars.value)?;
        unit.clone_from(&table.columns()[value].unit);
        let numbers = |column: usize| {
            let number = move |row: &usize| table.rows()[*row][column].number();
            rows.iter().map(move |row| number(row).unwrap_or(f64::NAN))
        };
        let place = |(row, top): (usize, f64)| (row as f64 + (index as f64 - middle) * slot, top);
        let whiskers = match bars.ends {
            None => Vec::new(),
            Some([low, high]) => {
                let (low, high) = (table.column(low)?, table.column(high)?);
                numbers(low).zip(numbers(high)).map(|(low, high)| [low, high]).collect()
            }
        };
        series.push(Series {
            label: bars.label.to_owned(),
            points: numbers(value).enumerate().map(place).collect(),
            style: Style::WhiskerBars,
            bar_width: slot,
            whiskers,
            rows: rows.iter().copied().map(Some).collect(),
            ..Series::default()
        });
    }
    let categories = rows.iter().map(|row| words[*row].clone()).collect();
    let x = PlotAxis { label: spec.x_label.to_owned(), categories, ..PlotAxis::default() };
    let y = PlotAxis { label: spec.y_label.to_owned(), unit, ..PlotAxis::default() };
    Ok(PlotPanel {
        title: title.to_owned(),
        x,
        y,
        series,
        bands: Vec::new(),
        front: false,
        level: None,
    })
}

/// Returns the values of some columns in each row, as text.
fn words(table: &DataTable, names: &[&str]) -> Result<Vec<String>, UnknownColumn> {
    let columns = names.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    let formats: Vec<(usize, ValueFormat)> =
        columns.iter().map(|&column| (column, ValueFormat::for_column(table, column))).collect();
    let row = |row: &Vec<Cell>| {
        formats.iter().map(|(column, format)| format.text(&row[*column])).collect::<Vec<_>>()
    };
    Ok(table.rows().iter().map(|cells| row(cells).join(", ")).collect())
}

/// Returns the title of the panel of each row.
fn titles(table: &DataTable, names: &[&str]) -> Result<Vec<String>, UnknownColumn> {
    let mut titles = vec![String::new(); table.rows().len()];
    for name in names {
        for (title, value) in titles.iter_mut().zip(words(table, &[name])?) {
            let before = if title.is_empty() { "" } else { ", " };
            *title += &format!("{before}{} = {value}", name.replace('_', " "));
        }
    }
    Ok(titles)
}

/// Returns each of some texts once, in order.
fn distinct(texts: &[String]) -> Vec<&str> {
    let mut distinct: Vec<&str> = Vec::new();
    for text in texts {
        if !distinct.contains(&text.as_str()) {
            distinct.push(text);
        }
    }
    distinct
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::TableColumn;

    fn table() -> DataTable {
        let heads = ["mu", "input", "total", "low", "high"];
        let row = |mu: f64, input: &str, numbers: [f64; 3]| {
            let mut row = vec![Cell::Number(mu), Cell::Text(input.to_owned())];
            row.extend(numbers.map(Cell::Number));
            row
        };
        let rows = vec![
            row(0.1, "radius", [0.6, 0.5, 0.7]),
            row(0.1, "load", [0.3, -0.1, 0.4]),
            row(0.2, "load", [0.9, 0.8, 1.1]),
        ];
        DataTable::new(heads.map(|head| TableColumn::new(head, "")).to_vec(), rows).unwrap()
    }

    fn spec<'a>(bars: &'a [BarColumns<'a>], panels: &'a [&'a str]) -> BarsSpec<'a> {
        BarsSpec { x: "input", bars, panels, ..BarsSpec::default() }
    }

    #[test]
    fn bars_stand_side_by_side_in_the_order_of_the_rows() {
        let total = BarColumns { label: "total", value: "total", ends: Some(["low", "high"]) };
        let bare = BarColumns { label: "bare", value: "low", ends: None };
        let figure = PlotFigure::bars_from_table(&table(), &spec(&[total, bare], &["mu"])).unwrap();
        let titles: Vec<&str> = figure.panels.iter().map(|panel| panel.title.as_str()).collect();
        assert_eq!(titles, ["mu = 0.1", "mu = 0.2"]);
        assert_eq!(figure.panels[0].x.categories, ["radius", "load"]);
        let [first, second] = &figure.panels[0].series[..] else { panic!("two series") };
        assert_eq!(first.whiskers, [[0.5, 0.7], [-0.1, 0.4]]);
        assert_eq!((first.points[1].1, second.points[1].1), (0.3, -0.1));
        assert!(first.points[1].0 + 0.9 * first.bar_width <= second.points[1].0);
        assert!(first.points[1].0 > 0.5 && second.points[1].0 < 1.5);
        // The second is below zero: its bar hangs, and the axis shows where it ends.
        let svg = figure.svg();
        assert_eq!(svg.matches("fill-opacity=\"0.25\"").count(), 6 + 2, "bars and legend");
        assert_eq!(figure.sketch().spots.len(), 6);
    }

    #[test]
    fn bars_without_a_column_or_a_number_are_refused() {
        let missing = [BarColumns { label: "", value: "none", ends: None }];
        let refused = PlotFigure::bars_from_table(&table(), &spec(&missing, &[])).unwrap_err();
        assert!(matches!(refused, FigureError::UnknownColumn(_)), "{refused:?}");
        let empty = table().without_rows();
        let total = [BarColumns { label: "", value: "total", ends: None }];
        let refused = PlotFigure::bars_from_table(&empty, &spec(&total, &[])).unwrap_err();
        assert!(matches!(refused, FigureError::NothingToDraw { rows: 0, .. }), "{refused:?}");
    }
}
