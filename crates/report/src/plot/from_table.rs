//! Figures of the columns of a table.

use super::error::{FigureError, MOST_SERIES};
use super::figure::{BandPoint, PlotAxis, PlotBand, PlotFigure, PlotPanel, Series, Style};
use super::groups::{Groups, numbers, text_in};
use super::histogram;
use super::spec::{FigureForm, FigureSpec};
use super::value_text::ValueFormat;
use crate::fit::{Fit, straight};
use crate::table::{Cell, DataTable, UnknownColumn};

impl PlotFigure {
    /// Makes a figure of columns of a table.
    ///
    /// Rows are grouped into panels and series by value, to at most six significant digits; within
    /// a series the points are sorted by x, unless they lie along a path. A row without y is a gap
    /// in its curve, a row without x is left out. When several rows of a series have the same x
    /// (some other column varies), or x is text, points are not joined by lines; those of a scatter
    /// never are. A histogram counts the rows by their value along x. Values in the
    /// legend and above panels have units, with one prefix for all values of a column. A band is
    /// joined as curves are, or else drawn as a bar at each x.
    ///
    /// # Errors
    /// [`FigureError`], which says what cannot be drawn and what to choose instead.
    pub fn from_table(table: &DataTable, spec: &FigureSpec<'_>) -> Result<PlotFigure, FigureError> {
        if let FigureForm::Histogram { bins, share } = spec.form {
            return histogram::figure(table, spec, bins, share);
        }
        let columns = Columns::find(table, spec)?;
        let y_unit = columns.unit_along_y(table)?;
        let coordinates = Coordinates::read(table, spec, &columns)?;
        let panels = Groups::panels(table, spec, columns.panels)?;
        let series = Groups::new(table, &columns.series);
        let count = series.labels.len() * (columns.y.len() + usize::from(spec.band.is_some()));
        if count > MOST_SERIES {
            let columns =
                if spec.series.is_empty() { names_along_y(spec) } else { spec.series.join(", ") };
            return Err(FigureError::TooManySeries { columns, count });
        }
        let x = PlotAxis {
            label: spec.label(spec.x),
            unit: table.columns()[columns.x].unit.clone(),
            log: spec.log_x,
            categories: coordinates.categories.clone(),
            from_zero: false,
        };
        let y = PlotAxis {
            label: spec.axis_of_y(),
            unit: y_unit,
            log: spec.log_y,
            categories: Vec::new(),
            from_zero: false,
        };
        let name_format =
            columns.names.map(|column| (column, ValueFormat::for_column(table, column)));
        let source =
            FigureSource { table, spec, columns, coordinates, panels, series, name_format };
        let panels = (0..source.panels.labels.len())
            .map(|panel| source.panel(panel, x.clone(), y.clone()))
            .collect();
        let legend = spec.series.iter().map(|name| spec.label(name)).collect::<Vec<_>>().join(", ");
        let notes = spec.notes.iter().map(|note| (*note).to_owned()).collect();
        Ok(PlotFigure { title: spec.title.to_owned(), legend, notes, panels })
    }
}

/// The largest number of points of a series of scattered points that have markers; more are dots.
const MOST_MARKERS: usize = 200;

/// Returns the names of all columns along y, separated by commas.
fn names_along_y(spec: &FigureSpec<'_>) -> String {
    spec.y.iter().copied().chain(spec.ends()).collect::<Vec<_>>().join(", ")
}

/// The indices of the columns that a figure shows.
struct Columns {
    x: usize,
    y: Vec<usize>,
    series: Vec<usize>,
    panels: Option<usize>,
    along: Option<usize>,
    /// The lower and the upper end of the band; empty without a band.
    ends: Vec<usize>,
    noise: Option<usize>,
    names: Option<usize>,
}

impl Columns {
    fn find(table: &DataTable, spec: &FigureSpec<'_>) -> Result<Columns, UnknownColumn> {
        let all = |names: &[&str]| {
            names.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()
        };
        let one = |name: Option<&str>| name.map(|name| table.column(name)).transpose();
        Ok(Columns {
            x: table.column(spec.x)?,
            y: all(spec.y)?,
            series: all(spec.series)?,
            panels: one(spec.panels)?,
            along: one(spec.along)?,
            ends: all(&spec.ends().collect::<Vec<_>>())?,
            noise: one(spec.noise)?,
            names: one(spec.names)?,
        })
    }

    /// Returns the unit that all columns along y share, after checking that none of them has text.
    fn unit_along_y(&self, table: &DataTable) -> Result<String, FigureError> {
        let all = [&self.y[..], &self.ends].concat();
        if let Some((y, example)) = all.iter().find_map(|&y| Some((y, text_in(table, y)?))) {
            return Err(FigureError::TextOnY { column: table.columns()[y].name.clone(), example });
        }
        common_unit(table, &all)
    }
}

/// The values that a figure shows, by row of the table; NaN where there is none.
struct Coordinates {
    /// The words along x, in order of appearance; empty if x is a number.
    categories: Vec<String>,
    /// The numbers along x, or the indices of the categories.
    x: Vec<f64>,
    /// The numbers of each column along y.
    y: Vec<Vec<f64>>,
    /// The numbers of the lower and the upper end of the band; empty without a band.
    ends: Vec<Vec<f64>>,
}

impl Coordinates {
    /// Reads the values, after checking that the axes and the marks can show them.
    fn read(
        table: &DataTable,
        spec: &FigureSpec<'_>,
        columns: &Columns,
    ) -> Result<Coordinates, FigureError> {
        let text_on_x = text_in(table, columns.x);
        spec.check_marks(text_on_x.as_deref())?;
        if let (Some(example), true) = (&text_on_x, spec.log_x) {
            return Err(FigureError::TextOnLog {
                column: spec.x.to_owned(),
                example: example.clone(),
            });
        }
        let all = |columns: &[usize]| columns.iter().map(|&y| numbers(table, y)).collect();
        let (categories, x) = if text_on_x.is_some() {
            categories(table, columns.x)
        } else {
            (Vec::new(), numbers(table, columns.x))
        };
        let coordinates =
            Coordinates { categories, x, y: all(&columns.y), ends: all(&columns.ends) };
        coordinates.check(spec)?;
        Ok(coordinates)
    }

    /// Refuses a figure without points, or without positive ones on a logarithmic axis.
    fn check(&self, spec: &FigureSpec<'_>) -> Result<(), FigureError> {
        let points = || {
            // A band has something to show if its lower end has.
            let along_y = self.y.iter().chain(self.ends.first());
            along_y
                .flat_map(|y| self.x.iter().zip(y))
                .filter(|(x, y)| x.is_finite() && y.is_finite())
        };
        if points().next().is_none() {
            return Err(FigureError::NothingToDraw {
                x: spec.x.to_owned(),
                y: names_along_y(spec),
                rows: self.x.len(),
            });
        }
        if spec.log_x && points().all(|(x, _)| *x <= 0.0) {
            return Err(FigureError::NothingPositive { column: spec.x.to_owned() });
        }
        if spec.log_y && points().all(|(_, y)| *y <= 0.0) {
            return Err(FigureError::NothingPositive { column: names_along_y(spec) });
        }
        Ok(())
    }

    fn has_categories(&self) -> bool {
        !self.categories.is_empty()
    }

    /// Says whether several of some rows, which are in order of x, have the same x.
    fn repeats(&self, rows: &[usize]) -> bool {
        rows.windows(2).any(|pair| self.x[pair[0]] == self.x[pair[1]])
    }
}

/// The data of a figure, which can be drawn.
struct FigureSource<'a> {
    table: &'a DataTable,
    spec: &'a FigureSpec<'a>,
    columns: Columns,
    coordinates: Coordinates,
    panels: Groups,
    series: Groups,
    /// The column of the names beside points, and how they are written.
    name_format: Option<(usize, ValueFormat)>,
}

impl FigureSource<'_> {
    /// Makes the panel of an index.
    fn panel(&self, panel: usize, x: PlotAxis, y: PlotAxis) -> PlotPanel {
        let (mut series, mut bands) = (Vec::new(), Vec::new());
        for (group, values) in self.series.labels.iter().enumerate() {
            let rows = self.rows(panel, group);
            if rows.is_empty() {
                continue;
            }
            for (y, name) in self.spec.y.iter().enumerate() {
                series.push(self.curve(&rows, group, y, self.spec.curve(values, name)));
            }
            bands.extend(
                self.spec.band.and_then(|ends| self.band(&rows, self.spec.band(values, ends))),
            );
        }
        let title = self.panels.panel_title(panel, self.table, self.spec, self.columns.panels);
        let (front, level) = (self.spec.front, self.spec.level);
        PlotPanel { title, x, y, series, bands, front, level }
    }

    /// Returns the rows of a series in a panel, in order of x unless they lie along a path.
    fn rows(&self, panel: usize, group: usize) -> Vec<usize> {
        let x = &self.coordinates.x;
        let belongs = |row: &usize| {
            self.panels.of_row[*row] == panel
                && self.series.of_row[*row] == group
                && x[*row].is_finite()
        };
        let mut rows: Vec<usize> = (0..x.len()).filter(belongs).collect();
        if self.columns.along.is_none() {
            rows.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
        }
        rows
    }

    /// Makes the curve of the column with index `y` among those along y.
    fn curve(&self, rows: &[usize], group: usize, y: usize, label: String) -> Series {
        let values = &self.coordinates.y[y];
        let drawn: Vec<Option<usize>> = match self.columns.along {
            Some(along) => {
                let count = |row: usize| self.table.rows()[row][along].number();
                paths(rows.iter().map(|&row| (count(row), row)))
            }
            None => rows.iter().copied().map(Some).collect(),
        };
        let point = |row: usize| (self.coordinates.x[row], values[row]);
        let points: Vec<(f64, f64)> =
            drawn.iter().map(|row| row.map_or((f64::NAN, f64::NAN), point)).collect();
        let fit = self.fit(&points);
        let style = match self.style(rows, y) {
            Style::Dots => Style::Dots,
            style => {
                if fit.is_some() {
                    Style::Markers
                } else {
                    style
                }
            }
        };
        // With several columns for several values, the colour tells the value and the line the
        // column.
        let related = self.columns.y.len() > 1
            && self.series.labels.len() > 1
            && style != Style::Markers
            && !self.spec.fit;
        let name = |(column, format): &(usize, ValueFormat)| {
            rows.iter().map(|&row| format.text(&self.table.rows()[row][*column])).collect()
        };
        let noise = |column: usize| {
            let cells = rows.iter().map(|&row| self.table.rows()[row][column].number());
            cells.map(|noise| noise.unwrap_or(0.0)).collect()
        };
        Series {
            label,
            points,
            style,
            kin: related.then_some(group),
            fit,
            noise: self.columns.noise.map(noise).unwrap_or_default(),
            names: self.name_format.as_ref().map(name).unwrap_or_default(),
            rows: drawn,
            ..Series::default()
        }
    }

    /// Returns the style of the curve of the column with index `y`, if no line is fitted to it.
    fn style(&self, rows: &[usize], y: usize) -> Style {
        if self.spec.form == FigureForm::Scatter {
            return if rows.len() > MOST_MARKERS { Style::Dots } else { Style::Markers };
        }
        match (self.columns.along, self.coordinates.has_categories()) {
            (Some(_), true) => Style::Markers,
            (Some(_), false) => Style::Path,
            (None, categories) if categories || self.coordinates.repeats(rows) => Style::Markers,
            (None, _) if y == 0 || self.spec.fit => Style::LineAndMarkers,
            (None, _) => Style::Line,
        }
    }

    fn band(&self, rows: &[usize], label: String) -> Option<PlotBand> {
        let [low, high] = &self.coordinates.ends[..] else { return None };
        let x = &self.coordinates.x;
        let points =
            rows.iter().map(|&row| BandPoint { x: x[row], low: low[row], high: high[row] });
        let fits = [low, high]
            .map(|end| self.fit(&rows.iter().map(|&row| (x[row], end[row])).collect::<Vec<_>>()));
        let joined = !self.coordinates.repeats(rows) && !self.coordinates.has_categories();
        let rows = rows.iter().copied().map(Some).collect();
        Some(PlotBand { label, points: points.collect(), joined, fits, rows })
    }

    /// Fits a line to points, if the figure has fitted lines.
    fn fit(&self, points: &[(f64, f64)]) -> Option<Fit> {
        self.spec.fit.then(|| straight(points, self.spec.log_x, self.spec.log_y)).flatten()
    }
}

/// Returns the unit of columns that share an axis.
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

/// Joins rows, each with its count along a path, and leaves a gap between two paths.
fn paths(rows: impl Iterator<Item = (Option<f64>, usize)>) -> Vec<Option<usize>> {
    let mut joined = Vec::new();
    let mut before = None;
    for (count, row) in rows {
        if before.is_some_and(|before| count <= before) {
            joined.push(None);
        }
        before = Some(count);
        joined.push(Some(row));
    }
    joined
}

/// Returns the distinct values of a column in order of appearance, and the index of the value that
/// each row has, NaN where there is none.
fn categories(table: &DataTable, column: usize) -> (Vec<String>, Vec<f64>) {
    let format = ValueFormat::for_column(table, column);
    let mut seen = Vec::new();
    let mut place = |cell: &Cell| {
        if cell.is_missing() {
            return f64::NAN;
        }
        let text = format.text(cell);
        let known = seen.iter().position(|other| *other == text);
        known.unwrap_or_else(|| {
            seen.push(text);
            seen.len() - 1
        }) as f64
    };
    let places = table.cells(column).map(&mut place).collect();
    (seen, places)
}
