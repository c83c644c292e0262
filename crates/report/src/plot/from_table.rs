//! Figures of the columns of a table.

use super::error::{FigureError, MOST_PANELS, MOST_SERIES};
use super::figure::{PlotAxis, PlotBand, PlotFigure, PlotPanel, Series, Style};
use super::spec::FigureSpec;
use super::value_text::ValueFormat;
use crate::fit::straight;
use crate::table::{Cell, DataTable};

/// The distinct combinations of the values of some columns, sorted, and which of them each row has.
fn groups(table: &DataTable, columns: &[usize]) -> (Vec<String>, Vec<usize>) {
    let names: Vec<String> = columns.iter().map(|&i| table.columns()[i].name.clone()).collect();
    let written: Vec<(usize, ValueFormat)> =
        columns.iter().map(|&i| (i, ValueFormat::of(table, i))).collect();
    // Sorted by value and not as text: 8 comes before 16.
    let sorted = table.sort(&names).unwrap_or_else(|_| table.clone());
    let label = |row: &[Cell]| {
        written.iter().map(|(i, written)| written.text(&row[*i])).collect::<Vec<_>>().join(", ")
    };
    let mut labels: Vec<String> = Vec::new();
    let mut index = std::collections::HashMap::new();
    for row in sorted.rows() {
        let label = label(row);
        index.entry(label.clone()).or_insert_with(|| {
            labels.push(label);
            labels.len() - 1
        });
    }
    let of_row =
        table.rows().iter().map(|row| index.get(&label(row)).copied().unwrap_or(0)).collect();
    (labels, of_row)
}

impl PlotFigure {
    /// A figure of columns of a table.
    ///
    /// Rows are grouped into panels and series by value, to at most six significant digits; within
    /// a series the points are sorted by x, unless they lie along a path. A row without y is a gap
    /// in its curve, a row without x is left out. When several rows of a series have the same x
    /// (some other column varies), or x is text, points are not joined by lines. Values in the
    /// legend and above panels have units, with one prefix for all values of a column. A band is
    /// joined as curves are, or else drawn as a bar at each x.
    ///
    /// # Errors
    /// [`FigureError`].
    pub fn from_table(table: &DataTable, spec: &FigureSpec<'_>) -> Result<PlotFigure, FigureError> {
        let x = table.column(spec.x)?;
        let ys = spec.y.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
        let series =
            spec.series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
        let panels = spec.panels.map(|name| table.column(name)).transpose()?;
        let along = spec.along.map(|name| table.column(name)).transpose()?;

        let ends = spec.ends().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
        let names = spec.names.map(|name| table.column(name)).transpose()?;

        let upright = [&ys[..], &ends].concat();
        if let Some((y, example)) = upright.iter().find_map(|&y| Some((y, text_in(table, y)?))) {
            return Err(FigureError::TextOnY { column: table.columns()[y].name.clone(), example });
        }
        let y_unit = common_unit(table, &upright)?;
        let x_text = text_in(table, x);
        spec.check_marks(x_text.as_deref())?;
        if let (Some(example), true) = (&x_text, spec.log_x) {
            return Err(FigureError::TextOnLog {
                column: spec.x.to_owned(),
                example: example.clone(),
            });
        }
        let (categories, places) =
            if x_text.is_some() { categories(table, x) } else { (Vec::new(), numbers(table, x)) };
        let values: Vec<Vec<f64>> = ys.iter().map(|&y| numbers(table, y)).collect();
        let ends: Vec<Vec<f64>> = ends.iter().map(|&end| numbers(table, end)).collect();
        let both = || {
            // of a band the lower end says whether there is anything
            let all = values.iter().chain(ends.first());
            all.flat_map(|y| places.iter().zip(y)).filter(|(x, y)| x.is_finite() && y.is_finite())
        };
        let all_y = spec.y.iter().copied().chain(spec.ends()).collect::<Vec<_>>().join(", ");
        if both().next().is_none() {
            return Err(FigureError::NothingToDraw {
                x: spec.x.to_owned(),
                y: all_y,
                rows: places.len(),
            });
        }
        if spec.log_x && both().all(|(x, _)| *x <= 0.0) {
            return Err(FigureError::NothingPositive { column: spec.x.to_owned() });
        }
        if spec.log_y && both().all(|(_, y)| *y <= 0.0) {
            return Err(FigureError::NothingPositive { column: all_y });
        }

        let (panel_labels, panel_of_row) = groups(table, &panels.into_iter().collect::<Vec<_>>());
        if let (Some(column), true) = (spec.panels, panel_labels.len() > MOST_PANELS) {
            return Err(FigureError::TooManyPanels {
                column: column.to_owned(),
                count: panel_labels.len(),
            });
        }
        let (series_labels, series_of_row) = groups(table, &series);
        let count = series_labels.len() * (ys.len() + usize::from(spec.band.is_some()));
        if count > MOST_SERIES {
            let columns = if spec.series.is_empty() { all_y } else { spec.series.join(", ") };
            return Err(FigureError::TooManySeries { columns, count });
        }

        let x_axis = PlotAxis {
            label: spec.label(spec.x),
            unit: table.columns()[x].unit.clone(),
            log: spec.log_x,
            categories,
        };
        let y_axis = PlotAxis {
            label: spec.axis_of_y(),
            unit: y_unit,
            log: spec.log_y,
            categories: Vec::new(),
        };
        let fit = |points: &[(f64, f64)]| {
            spec.fit.then(|| straight(points, spec.log_x, spec.log_y)).flatten()
        };
        let written = names.map(|column| (column, ValueFormat::of(table, column)));
        let name = |row: usize| {
            written.as_ref().map(|(column, written)| written.text(&table.rows()[row][*column]))
        };
        // `rows` are in order of x, unless they lie along a path
        let curve =
            |rows: &[usize], which: usize, y: &[f64], label: String, kin: usize| -> Series {
                let points = rows.iter().map(|&row| (places[row], y[row]));
                let (points, style) = if let Some(along) = along {
                    let count = |row: usize| table.rows()[row][along].number();
                    (
                        paths(rows.iter().map(|&row| count(row)).zip(points)),
                        if x_text.is_some() { Style::Markers } else { Style::Path },
                    )
                } else {
                    let style = match which {
                        _ if repeated(rows, &places) || x_text.is_some() => Style::Markers,
                        _ if which == 0 || spec.fit => Style::LineAndMarkers,
                        _ => Style::Line,
                    };
                    (points.collect(), style)
                };
                let fit = fit(&points);
                let style = if fit.is_some() { Style::Markers } else { style };
                // of several columns for several values, a colour tells the value and a line the
                // column
                let kin = (ys.len() > 1
                    && series_labels.len() > 1
                    && style != Style::Markers
                    && !spec.fit)
                    .then_some(kin);
                Series {
                    label,
                    points,
                    style,
                    kin,
                    fit,
                    names: rows.iter().filter_map(|&row| name(row)).collect(),
                }
            };
        let band = |rows: &[usize], label: String| -> Option<PlotBand> {
            let [low, high] = &ends[..] else { return None };
            let points = rows.iter().map(|&row| (places[row], low[row], high[row])).collect();
            let fits = [low, high].map(|end| {
                fit(&rows.iter().map(|&row| (places[row], end[row])).collect::<Vec<_>>())
            });
            Some(PlotBand {
                label,
                points,
                joined: !repeated(rows, &places) && x_text.is_none(),
                fits,
            })
        };
        let panel = |(panel, value): (usize, &String)| {
            let (mut series, mut bands) = (Vec::new(), Vec::new());
            for (index, values_label) in series_labels.iter().enumerate() {
                let mine = |row: &usize| {
                    panel_of_row[*row] == panel
                        && series_of_row[*row] == index
                        && places[*row].is_finite()
                };
                let mut rows: Vec<usize> = (0..places.len()).filter(mine).collect();
                if rows.is_empty() {
                    continue;
                }
                if along.is_none() {
                    rows.sort_by(|a, b| places[*a].total_cmp(&places[*b]));
                }
                for (which, (name, y)) in spec.y.iter().zip(&values).enumerate() {
                    series.push(curve(&rows, which, y, spec.curve(values_label, name), index));
                }
                bands.extend(spec.band.and_then(|ends| band(&rows, spec.band(values_label, ends))));
            }
            let title = match (spec.panels, panels.and_then(|column| text_in(table, column))) {
                (None, _) => String::new(),
                (Some(name), None) => format!("{} = {value}", spec.label(name)),
                (Some(name), Some(_)) => format!("{}: {value}", spec.label(name)),
            };
            PlotPanel {
                title,
                x: x_axis.clone(),
                y: y_axis.clone(),
                series,
                bands,
                front: spec.front,
            }
        };
        let panels = panel_labels.iter().enumerate().map(panel).collect();
        let legend = spec.series.iter().map(|name| spec.label(name)).collect::<Vec<_>>().join(", ");
        Ok(PlotFigure { title: spec.title.to_owned(), legend, panels })
    }
}

/// The unit of columns that share an axis.
fn common_unit(table: &DataTable, columns: &[usize]) -> Result<String, FigureError> {
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

/// Whether several of some rows, which are in order of x, have the same x.
fn repeated(rows: &[usize], x: &[f64]) -> bool {
    rows.windows(2).any(|pair| x[pair[0]] == x[pair[1]])
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
fn numbers(table: &DataTable, column: usize) -> Vec<f64> {
    table.cells(column).map(|cell| cell.number().unwrap_or(f64::NAN)).collect()
}

/// The distinct values of a column in order of appearance, and which of them each row has; NaN
/// where there is none.
fn categories(table: &DataTable, column: usize) -> (Vec<String>, Vec<f64>) {
    let written = ValueFormat::of(table, column);
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

fn text_in(table: &DataTable, column: usize) -> Option<String> {
    table.cells(column).find_map(|cell| match cell {
        Cell::Text(text) => Some(text.clone()),
        _ => None,
    })
}
