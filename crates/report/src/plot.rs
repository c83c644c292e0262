//! Line charts: what they are, and how they are made from a table.

mod draw;

use thiserror::Error;

use crate::si::significant;
use crate::table::{Cell, Table, UnknownColumn};

/// A row of panels with one legend; drawn by [`Figure::svg`].
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Above the panels; empty for none.
    pub title: String,
    /// Above the legend, e.g. the name of the column that tells the series apart; empty for none.
    pub legend: String,
    /// From left to right. Axes that are equal in all panels get the same range, and the vertical one is written once.
    pub panels: Vec<Panel>,
}

/// One chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Above the panel; empty for none.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The curves. Series with the same label look alike in all panels and have one entry in the legend.
    pub series: Vec<Series>,
}

/// What is drawn along one direction.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Axis {
    /// The quantity.
    pub label: String,
    /// Its SI unit; a prefix is chosen from the values. `"1"` for a ratio, empty for none.
    pub unit: String,
    /// Whether the axis is logarithmic. Values that are not positive are then left out, and the figure says so.
    pub log: bool,
    /// Words instead of numbers: the i-th stands at i. Empty for an axis of numbers.
    pub categories: Vec<String>,
}

/// One curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Its name in the legend; empty for none.
    pub label: String,
    /// Points (x, y) in SI units, in the order they are joined. A point that is not finite is a gap.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
}

/// How a series is drawn. Colour and marker follow from its place in the legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Style {
    /// A line through marked points; markers are thinned out when there are many.
    #[default]
    LineAndMarkers,
    /// A line alone, e.g. a closed form to compare with.
    Line,
    /// Marked points alone.
    Markers,
}

/// Which columns of a table a figure shows, for [`Figure::from_table`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FigureSpec<'a> {
    /// The column along the horizontal axis; a column of text makes an axis of categories.
    pub x: &'a str,
    /// The column of numbers along the vertical axis.
    pub y: &'a str,
    /// Columns whose values tell the series apart; none for a single series.
    pub series: &'a [&'a str],
    /// The column with a panel for each of its values.
    pub panels: Option<&'a str>,
    /// The column that counts along a path: points are then joined in the order of the rows and not by x, and where it does not
    /// grow another path begins.
    pub along: Option<&'a str>,
    /// Above the figure.
    pub title: &'a str,
    /// Whether x is logarithmic.
    pub log_x: bool,
    /// Whether y is logarithmic.
    pub log_y: bool,
}

/// Why a table could not be drawn.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FigureError {
    /// A column was asked for that is not there.
    #[error(transparent)]
    UnknownColumn(#[from] UnknownColumn),
    /// There is nothing to draw.
    #[error("no row has a value in both `{x}` and `{y}`, so there is nothing to draw ({rows} rows)")]
    NothingToDraw {
        /// The column along x.
        x: String,
        /// The column along y.
        y: String,
        /// The number of rows looked at.
        rows: usize,
    },
    /// The vertical axis has text.
    #[error("column `{column}` has text, such as {example:?}, and cannot be drawn along y; choose a column of numbers")]
    TextOnY {
        /// The column.
        column: String,
        /// One of its values.
        example: String,
    },
    /// Text has no logarithm.
    #[error("column `{column}` has text, such as {example:?}, so that its axis cannot be logarithmic")]
    TextOnLog {
        /// The column.
        column: String,
        /// One of its values.
        example: String,
    },
    /// Every value is zero or negative on a logarithmic axis.
    #[error("column `{column}` has no positive value, so that its axis cannot be logarithmic")]
    NothingPositive {
        /// The column.
        column: String,
    },
    /// More panels than can be read.
    #[error(
        "column `{column}` has {count} values, too many for a panel each; at most {MOST_PANELS} are drawn: filter the rows or make it a series"
    )]
    TooManyPanels {
        /// The column.
        column: String,
        /// Its number of distinct values.
        count: usize,
    },
    /// More series than can be told apart.
    #[error(
        "{columns} would make {count} series, too many to tell apart; at most {MOST_SERIES} are drawn: filter the rows or leave a column out"
    )]
    TooManySeries {
        /// The columns that tell the series apart.
        columns: String,
        /// Their number of distinct combinations.
        count: usize,
    },
}

const MOST_PANELS: usize = 16;
const MOST_SERIES: usize = 56;

/// A value that tells series or panels apart, as it is written.
fn written(cell: &Cell) -> String {
    match cell {
        Cell::Number(x) => significant(*x, 6),
        Cell::Integer(i) => i.to_string(),
        Cell::Text(text) => text.clone(),
        Cell::Missing => "none".to_owned(),
    }
}

/// The distinct combinations of the values of some columns, sorted, and which of them each row has.
fn groups(table: &Table, columns: &[usize]) -> (Vec<String>, Vec<usize>) {
    let names: Vec<String> = columns.iter().map(|&i| table.columns()[i].name.clone()).collect();
    // Sorted by value and not as text: 8 comes before 16.
    let sorted = table.sort(&names).unwrap_or_else(|_| table.clone());
    let label = |row: &[Cell]| columns.iter().map(|&i| written(&row[i])).collect::<Vec<_>>().join(", ");
    let mut labels: Vec<String> = Vec::new();
    let mut index = std::collections::HashMap::new();
    for row in sorted.rows() {
        let label = label(row);
        index.entry(label.clone()).or_insert_with(|| {
            labels.push(label);
            labels.len() - 1
        });
    }
    let of_row = table.rows().iter().map(|row| index.get(&label(row)).copied().unwrap_or(0)).collect();
    (labels, of_row)
}

impl Figure {
    /// A figure of two columns of a table.
    ///
    /// Rows are grouped into panels and series by value, to six significant digits; within a series the points are
    /// sorted by x, unless they lie along a path. A row without y is a gap in its curve, a row without x is left out. When several
    /// rows of a series have the same x (some other column varies), or x is text, points are not joined by lines.
    ///
    /// # Errors
    /// [`FigureError`].
    pub fn from_table(table: &Table, spec: &FigureSpec<'_>) -> Result<Figure, FigureError> {
        let (x, y) = (table.column(spec.x)?, table.column(spec.y)?);
        let series = spec.series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
        let panels = spec.panels.map(|name| table.column(name)).transpose()?;
        let along = spec.along.map(|name| table.column(name)).transpose()?;

        if let Some(example) = text_in(table, y) {
            return Err(FigureError::TextOnY { column: spec.y.to_owned(), example });
        }
        let x_text = text_in(table, x);
        if let (Some(example), true) = (&x_text, spec.log_x) {
            return Err(FigureError::TextOnLog { column: spec.x.to_owned(), example: example.clone() });
        }
        let (categories, category_of_row) = if x_text.is_some() {
            let present = table.keep(&table.cells(x).map(|cell| !cell.is_missing()).collect::<Vec<_>>());
            let categories = in_order_of_appearance(&present, x);
            let index = |cell: &Cell| categories.iter().position(|c| *c == written(cell)).map_or(f64::NAN, |i| i as f64);
            let of_row = table.cells(x).map(index).collect();
            (categories, of_row)
        } else {
            (Vec::new(), Vec::new())
        };
        let point = |row: usize| {
            let cells = &table.rows()[row];
            let x = category_of_row.get(row).copied().or_else(|| cells[x].number()).unwrap_or(f64::NAN);
            (x, cells[y].number().unwrap_or(f64::NAN))
        };
        let points: Vec<(f64, f64)> = (0..table.rows().len()).map(point).collect();
        let both: Vec<&(f64, f64)> = points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        if both.is_empty() {
            let (x, y) = (spec.x.to_owned(), spec.y.to_owned());
            return Err(FigureError::NothingToDraw { x, y, rows: points.len() });
        }
        if spec.log_x && both.iter().all(|p| p.0 <= 0.0) {
            return Err(FigureError::NothingPositive { column: spec.x.to_owned() });
        }
        if spec.log_y && both.iter().all(|p| p.1 <= 0.0) {
            return Err(FigureError::NothingPositive { column: spec.y.to_owned() });
        }

        let (panel_labels, panel_of_row) = groups(table, &panels.into_iter().collect::<Vec<_>>());
        if let (Some(column), true) = (spec.panels, panel_labels.len() > MOST_PANELS) {
            return Err(FigureError::TooManyPanels { column: column.to_owned(), count: panel_labels.len() });
        }
        let (series_labels, series_of_row) = groups(table, &series);
        if series_labels.len() > MOST_SERIES {
            let columns = spec.series.join(", ");
            return Err(FigureError::TooManySeries { columns, count: series_labels.len() });
        }

        let axis = |column: usize, log, categories| {
            let column = &table.columns()[column];
            Axis { label: readable(&column.name), unit: column.unit.clone(), log, categories }
        };
        let x_axis = axis(x, spec.log_x, categories);
        let y_axis = axis(y, spec.log_y, Vec::new());
        let panels = panel_labels.iter().enumerate().map(|(panel, panel_label)| {
            let series = series_labels.iter().enumerate().filter_map(|(series, label)| {
                let mine = |row: &usize| panel_of_row[*row] == panel && series_of_row[*row] == series;
                let rows = (0..points.len()).filter(mine).filter(|row| points[*row].0.is_finite());
                if let Some(along) = along {
                    let points = paths(rows.map(|row| (table.rows()[row][along].number(), points[row])));
                    let style = if x_text.is_some() { Style::Markers } else { Style::LineAndMarkers };
                    return (!points.is_empty()).then(|| Series { label: label.clone(), points, style });
                }
                let mut points: Vec<(f64, f64)> = rows.map(|row| points[row]).collect();
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                let repeated = points.windows(2).any(|p| p[0].0 == p[1].0);
                let style = if repeated || x_text.is_some() { Style::Markers } else { Style::LineAndMarkers };
                (!points.is_empty()).then(|| Series { label: label.clone(), points, style })
            });
            Panel {
                title: spec.panels.map_or(String::new(), |name| {
                    let unit = panels.map(|i| table.columns()[i].unit.as_str()).unwrap_or_default();
                    let unit = if unit.is_empty() || unit == "1" { String::new() } else { format!(" {unit}") };
                    format!("{} = {panel_label}{unit}", readable(name))
                }),
                x: x_axis.clone(),
                y: y_axis.clone(),
                series: series.collect(),
            }
        });
        let panels = panels.collect();
        let heading = |&i: &usize| {
            let column = &table.columns()[i];
            match column.unit.as_str() {
                "" | "1" => readable(&column.name),
                unit => format!("{} [{unit}]", readable(&column.name)),
            }
        };
        let legend = series.iter().map(heading).collect::<Vec<_>>().join(", ");
        Ok(Figure { title: spec.title.to_owned(), legend, panels })
    }
}

/// Points with what counts along their paths; a gap between two paths.
fn paths(points: impl Iterator<Item = (Option<f64>, (f64, f64))>) -> Vec<(f64, f64)> {
    let mut joined = Vec::new();
    let mut before = None;
    for (count, point) in points {
        if before.is_some_and(|before| count <= before) {
            joined.push((f64::NAN, f64::NAN));
        }
        before = Some(count);
        joined.push(point);
    }
    joined
}

/// The name of a column as words.
fn readable(name: &str) -> String {
    name.replace('_', " ")
}

fn text_in(table: &Table, column: usize) -> Option<String> {
    table.cells(column).find_map(|cell| match cell {
        Cell::Text(text) => Some(text.clone()),
        _ => None,
    })
}

fn in_order_of_appearance(table: &Table, column: usize) -> Vec<String> {
    let mut seen = Vec::new();
    for cell in table.cells(column) {
        let text = written(cell);
        if !seen.contains(&text) {
            seen.push(text);
        }
    }
    seen
}
