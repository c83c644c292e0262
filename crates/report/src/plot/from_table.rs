//! Figures of the columns of a table.

use thiserror::Error;

use super::written::Written;
use super::{Axis, Figure, Panel, Series, Style};
use crate::table::{Cell, Table, UnknownColumn};

/// Which columns of a table a figure shows, for [`Figure::from_table`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FigureSpec<'a> {
    /// The column along the horizontal axis; a column of text makes an axis of categories.
    pub x: &'a str,
    /// The columns of numbers along the vertical axis, all in one unit; a curve for each of them. The points of the first are
    /// marked, the others are lines alone, so that curves which agree do not hide each other.
    pub y: &'a [&'a str],
    /// What several columns of `y` measure, for their axis; with nothing here it lists them.
    pub y_label: &'a str,
    /// Columns whose values tell the series apart; none for a single series.
    pub series: &'a [&'a str],
    /// The column with a panel for each of its values.
    pub panels: Option<&'a str>,
    /// The column that counts along a path: points are then joined in the order of the rows and not by x, and where it does not
    /// grow another path begins.
    pub along: Option<&'a str>,
    /// What columns are called in the picture, by their names; one that is not here is called by the words of its name.
    pub labels: &'a [(&'a str, &'a str)],
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
    /// No column is drawn along the vertical axis.
    #[error("the figure has no column along y; name at least one column of numbers")]
    NoY,
    /// The vertical axis has columns of different units.
    #[error("columns `{a}` [{a_unit}] and `{b}` [{b_unit}] cannot share an axis; choose columns of one unit")]
    DifferentUnits {
        /// The first column.
        a: String,
        /// Its unit, `1` for a pure number.
        a_unit: String,
        /// The first column with another unit.
        b: String,
        /// Its unit.
        b_unit: String,
    },
    /// There is nothing to draw.
    #[error("no row has a value in both `{x}` and `{y}`, so there is nothing to draw ({rows} rows)")]
    NothingToDraw {
        /// The column along x.
        x: String,
        /// The columns along y, separated by commas.
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

/// The distinct combinations of the values of some columns, sorted, and which of them each row has.
fn groups(table: &Table, columns: &[usize]) -> (Vec<String>, Vec<usize>) {
    let names: Vec<String> = columns.iter().map(|&i| table.columns()[i].name.clone()).collect();
    let written: Vec<(usize, Written)> = columns.iter().map(|&i| (i, Written::of(table, i))).collect();
    // Sorted by value and not as text: 8 comes before 16.
    let sorted = table.sort(&names).unwrap_or_else(|_| table.clone());
    let label = |row: &[Cell]| written.iter().map(|(i, written)| written.text(&row[*i])).collect::<Vec<_>>().join(", ");
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

impl FigureSpec<'_> {
    /// What a column is called.
    fn label(&self, name: &str) -> String {
        let own = self.labels.iter().find(|(column, _)| *column == name);
        own.map_or_else(|| name.replace('_', " "), |(_, label)| (*label).to_owned())
    }

    /// What the vertical axis is called.
    fn axis_of_y(&self) -> String {
        match self.y {
            [_, _, ..] if !self.y_label.is_empty() => self.y_label.to_owned(),
            all => all.iter().map(|name| self.label(name)).collect::<Vec<_>>().join(", "),
        }
    }

    /// What a curve is called: the values that tell it apart, then its column if there are several.
    fn curve(&self, values: &str, y: &str) -> String {
        match (self.y.len(), values) {
            (0 | 1, values) => values.to_owned(),
            (_, "") => self.label(y),
            (_, values) => format!("{values}, {}", self.label(y)),
        }
    }
}

impl Figure {
    /// A figure of columns of a table.
    ///
    /// Rows are grouped into panels and series by value, to at most six significant digits; within a series the points are
    /// sorted by x, unless they lie along a path. A row without y is a gap in its curve, a row without x is left out. When several
    /// rows of a series have the same x (some other column varies), or x is text, points are not joined by lines. Values in the
    /// legend and above panels have units, with one prefix for all values of a column.
    ///
    /// # Errors
    /// [`FigureError`].
    pub fn from_table(table: &Table, spec: &FigureSpec<'_>) -> Result<Figure, FigureError> {
        let x = table.column(spec.x)?;
        let ys = spec.y.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
        let series = spec.series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
        let panels = spec.panels.map(|name| table.column(name)).transpose()?;
        let along = spec.along.map(|name| table.column(name)).transpose()?;

        if let Some((y, example)) = ys.iter().find_map(|&y| Some((y, text_in(table, y)?))) {
            return Err(FigureError::TextOnY { column: table.columns()[y].name.clone(), example });
        }
        let y_unit = common_unit(table, &ys)?;
        let x_text = text_in(table, x);
        if let (Some(example), true) = (&x_text, spec.log_x) {
            return Err(FigureError::TextOnLog { column: spec.x.to_owned(), example: example.clone() });
        }
        let (categories, places) = if x_text.is_some() { categories(table, x) } else { (Vec::new(), numbers(table, x)) };
        let values: Vec<Vec<f64>> = ys.iter().map(|&y| numbers(table, y)).collect();
        let both = || values.iter().flat_map(|y| places.iter().zip(y)).filter(|(x, y)| x.is_finite() && y.is_finite());
        if both().next().is_none() {
            return Err(FigureError::NothingToDraw { x: spec.x.to_owned(), y: spec.y.join(", "), rows: places.len() });
        }
        if spec.log_x && both().all(|(x, _)| *x <= 0.0) {
            return Err(FigureError::NothingPositive { column: spec.x.to_owned() });
        }
        if spec.log_y && both().all(|(_, y)| *y <= 0.0) {
            return Err(FigureError::NothingPositive { column: spec.y.join(", ") });
        }

        let (panel_labels, panel_of_row) = groups(table, &panels.into_iter().collect::<Vec<_>>());
        if let (Some(column), true) = (spec.panels, panel_labels.len() > MOST_PANELS) {
            return Err(FigureError::TooManyPanels { column: column.to_owned(), count: panel_labels.len() });
        }
        let (series_labels, series_of_row) = groups(table, &series);
        let count = series_labels.len() * ys.len();
        if count > MOST_SERIES {
            let columns = if spec.series.is_empty() { spec.y } else { spec.series }.join(", ");
            return Err(FigureError::TooManySeries { columns, count });
        }

        let x_axis = Axis { label: spec.label(spec.x), unit: table.columns()[x].unit.clone(), log: spec.log_x, categories };
        let y_axis = Axis { label: spec.axis_of_y(), unit: y_unit, log: spec.log_y, categories: Vec::new() };
        let curve = |rows: &[usize], which: usize, y: &[f64]| -> (Vec<(f64, f64)>, Style) {
            let points = rows.iter().map(|&row| (places[row], y[row]));
            if let Some(along) = along {
                let count = |row: usize| table.rows()[row][along].number();
                let points = paths(rows.iter().map(|&row| count(row)).zip(points));
                return (points, if x_text.is_some() { Style::Markers } else { Style::Path });
            }
            let mut points: Vec<(f64, f64)> = points.collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let repeated = points.windows(2).any(|p| p[0].0 == p[1].0);
            let style = match which {
                _ if repeated || x_text.is_some() => Style::Markers,
                0 => Style::LineAndMarkers,
                _ => Style::Line,
            };
            (points, style)
        };
        let panel = |(panel, value): (usize, &String)| {
            let mut curves = Vec::new();
            for (index, values_label) in series_labels.iter().enumerate() {
                let mine = |row: &usize| panel_of_row[*row] == panel && series_of_row[*row] == index && places[*row].is_finite();
                let rows: Vec<usize> = (0..places.len()).filter(mine).collect();
                for (which, (name, y)) in spec.y.iter().zip(&values).enumerate().filter(|_| !rows.is_empty()) {
                    let (points, style) = curve(&rows, which, y);
                    // of several columns for several values, a colour tells the value and a line the column
                    let kin = (ys.len() > 1 && series_labels.len() > 1 && style != Style::Markers).then_some(index);
                    curves.push(Series { label: spec.curve(values_label, name), points, style, kin });
                }
            }
            let title = match (spec.panels, panels.and_then(|column| text_in(table, column))) {
                (None, _) => String::new(),
                (Some(name), None) => format!("{} = {value}", spec.label(name)),
                (Some(name), Some(_)) => format!("{}: {value}", spec.label(name)),
            };
            Panel { title, x: x_axis.clone(), y: y_axis.clone(), series: curves }
        };
        let panels = panel_labels.iter().enumerate().map(panel).collect();
        let legend = spec.series.iter().map(|name| spec.label(name)).collect::<Vec<_>>().join(", ");
        Ok(Figure { title: spec.title.to_owned(), legend, panels })
    }
}

/// The unit of columns that share an axis.
fn common_unit(table: &Table, columns: &[usize]) -> Result<String, FigureError> {
    let mut columns = columns.iter().map(|&i| &table.columns()[i]);
    let first = columns.next().ok_or(FigureError::NoY)?;
    let written = |unit: &str| if unit.is_empty() { "1".to_owned() } else { unit.to_owned() };
    match columns.find(|other| written(&other.unit) != written(&first.unit)) {
        None => Ok(first.unit.clone()),
        Some(other) => Err(FigureError::DifferentUnits {
            a: first.name.clone(),
            a_unit: written(&first.unit),
            b: other.name.clone(),
            b_unit: written(&other.unit),
        }),
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

/// The numbers of a column; NaN where there is none.
fn numbers(table: &Table, column: usize) -> Vec<f64> {
    table.cells(column).map(|cell| cell.number().unwrap_or(f64::NAN)).collect()
}

/// The distinct values of a column in order of appearance, and which of them each row has; NaN where there is none.
fn categories(table: &Table, column: usize) -> (Vec<String>, Vec<f64>) {
    let written = Written::of(table, column);
    let mut seen = Vec::new();
    let mut place = |cell: &Cell| {
        if cell.is_missing() {
            return f64::NAN;
        }
        let text = written.text(cell);
        let known = seen.iter().position(|other| *other == text);
        known.unwrap_or_else(|| {
            seen.push(text);
            seen.len() - 1
        }) as f64
    };
    let places = table.cells(column).map(&mut place).collect();
    (seen, places)
}

fn text_in(table: &Table, column: usize) -> Option<String> {
    table.cells(column).find_map(|cell| match cell {
        Cell::Text(text) => Some(text.clone()),
        _ => None,
    })
}
