//! The columns of a suggested figure that vary along its abscissa.

use std::collections::HashMap;

use report::{Cell, DataTable, TableError};
use study::figure::FigureKind;
use study::{Figure, Study, StudyPoint};

use crate::error::AnswerError;

/// The result of looking for variation in a figure.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Variation {
    /// Something varies; the figure shows that and nothing else.
    Varies(Box<Figure>),
    /// Nothing varies.
    Constant,
    /// No curve has two points.
    Unknown,
}

/// The part of the largest quantity of its unit below which a value is taken for noise around 0.
pub(crate) const NOISE: f64 = 1e-9;

/// The units of numbers that have no scale in common.
pub(crate) const DIMENSIONLESS: [&str; 3] = ["", "1", "%"];

/// The largest relative change that a loose tolerance makes of a constant.
const MOST_NOISE: f64 = 0.02;

/// Returns the relative change below which a quantity counts as constant: what the loosest
/// tolerance of some points leaves.
pub(crate) fn noise(points: &[StudyPoint]) -> f64 {
    let tolerances = points.iter().filter_map(|point| Some(point.job.case()?.numerics.tolerance));
    (10.0 * tolerances.fold(1e-9, f64::max)).min(MOST_NOISE)
}

/// The value of a cell, by which rows are told apart. Numbers are the same if all their bits are.
#[derive(PartialEq, Eq, Hash)]
enum CellIdentity {
    Number(u64),
    Integer(i64),
    Flag(bool),
    Text(String),
    Missing,
}

impl CellIdentity {
    fn of(cell: &Cell) -> CellIdentity {
        match cell {
            Cell::Number(number) => CellIdentity::Number(number.to_bits()),
            Cell::Integer(integer) => CellIdentity::Integer(*integer),
            Cell::Flag(yes) => CellIdentity::Flag(*yes),
            Cell::Text(text) => CellIdentity::Text(text.clone()),
            Cell::Missing => CellIdentity::Missing,
        }
    }
}

/// The range of some finite values.
#[derive(Clone, Copy)]
struct Range {
    least: f64,
    most: f64,
    count: usize,
}

impl Range {
    const EMPTY: Range = Range { least: f64::INFINITY, most: f64::NEG_INFINITY, count: 0 };

    fn add(&mut self, cell: &Cell) {
        if let Some(value) = cell.number().filter(|value| value.is_finite()) {
            self.least = self.least.min(value);
            self.most = self.most.max(value);
            self.count += 1;
        }
    }

    /// Returns whether the values differ by more than a relative `noise`.
    fn varies(&self, noise: f64) -> bool {
        self.most - self.least > noise * self.least.abs().max(self.most.abs())
    }
}

/// The rows of a curve.
struct CurveRanges {
    /// The abscissa of the first row.
    first: Cell,
    /// Another row has another abscissa.
    has_two: bool,
    /// The ranges of the columns along y, and of the ends of the band.
    ranges: Vec<Range>,
}

/// The ranges of what a figure shows along its curves, of rows that are added a few at a time.
pub(crate) struct FigureRanges<'f> {
    figure: &'f Figure,
    /// The range of the abscissa.
    x: Range,
    curves: HashMap<Vec<CellIdentity>, CurveRanges>,
}

impl<'f> FigureRanges<'f> {
    /// Returns those of no row.
    pub(crate) fn of(figure: &'f Figure) -> Self {
        FigureRanges { figure, x: Range::EMPTY, curves: HashMap::new() }
    }

    /// Adds rows, which are certified results.
    pub(crate) fn add(&mut self, table: &DataTable) -> Result<(), AnswerError> {
        let figure = self.figure;
        let index = |name: &String| table.column(name).map_err(TableError::from);
        let indices = |names: &mut dyn Iterator<Item = &String>| {
            names.map(index).collect::<Result<Vec<usize>, _>>()
        };
        let x = index(&figure.x)?;
        if figure.kind == FigureKind::Histogram {
            table.rows().iter().for_each(|row| self.x.add(&row[x]));
            return Ok(());
        }
        let apart = indices(&mut figure.series.iter().chain(&figure.panels))?;
        let shown = indices(&mut figure.y.iter().chain(figure.band.iter().flatten()))?;
        for row in table.rows().iter().filter(|row| row[x].number().is_some()) {
            let curve = apart.iter().map(|column| CellIdentity::of(&row[*column])).collect();
            let curve = self.curves.entry(curve).or_insert_with(|| CurveRanges {
                first: row[x].clone(),
                has_two: false,
                ranges: vec![Range::EMPTY; shown.len()],
            });
            curve.has_two |= row[x] != curve.first;
            let values = shown.iter().map(|column| &row[*column]);
            curve.ranges.iter_mut().zip(values).for_each(|(range, value)| range.add(value));
        }
        Ok(())
    }

    /// Returns what varies by more than a relative `noise` along some curve.
    pub(crate) fn variation(&self, noise: f64) -> Variation {
        let figure = self.figure;
        if figure.kind == FigureKind::Histogram {
            return match self.x.count {
                0 | 1 => Variation::Unknown,
                _ if self.x.varies(noise) => Variation::Varies(Box::new(figure.clone())),
                _ => Variation::Constant,
            };
        }
        let curves = || self.curves.values().filter(|curve| curve.has_two);
        if curves().next().is_none() {
            return Variation::Unknown;
        }
        let varies = |place: usize| curves().any(|curve| curve.ranges[place].varies(noise));
        let names = figure.y.iter().enumerate();
        let shown = names.filter(|(place, _)| varies(*place)).map(|(_, name)| name.clone());
        let shown: Vec<String> = shown.collect();
        let ends = figure.band.iter().flatten().enumerate();
        let has_band = ends.map(|(end, _)| figure.y.len() + end).any(varies);
        if shown.is_empty() && !has_band {
            return Variation::Constant;
        }
        let band = figure.band.clone().filter(|_| has_band);
        Variation::Varies(Box::new(Figure { y: shown, band, ..figure.clone() }))
    }
}

/// Returns the first of some figures that shows something that varies, without columns that do not;
/// the first of all as long as no curve has two points. `ranges` are theirs.
pub(crate) fn first_varying(ranges: &[FigureRanges<'_>], noise: f64) -> Option<Figure> {
    let mut is_known = false;
    for of_figure in ranges {
        match of_figure.variation(noise) {
            Variation::Varies(figure) => return Some(*figure),
            Variation::Constant => is_known = true,
            Variation::Unknown => {}
        }
    }
    ranges.first().filter(|_| !is_known).map(|of_figure| of_figure.figure.clone())
}

/// Returns the figures that answer a study's question: those of its file, else the one that
/// `varying` chooses of those that are suggested. There is none if nothing varies.
pub(crate) fn answering_figures(
    study: &Study,
    varying: impl FnOnce(&[Figure]) -> Result<Option<Figure>, AnswerError>,
) -> Result<Vec<Figure>, AnswerError> {
    Ok(match study.suggestions() {
        // So many points make no figure.
        _ if !study.is_listed() => Vec::new(),
        [] => study.figures().to_vec(),
        // What moves nothing is an answer as well.
        suggestions if suggestions.iter().all(|figure| figure.kind == FigureKind::Sensitivity) => {
            suggestions.to_vec()
        }
        suggestions => varying(suggestions)?.into_iter().collect(),
    })
}

/// Returns the names of the columns from which it follows what some figures show.
pub(crate) fn columns_of(figures: &[Figure]) -> Vec<&str> {
    let names = figures.iter().flat_map(|figure| {
        let apart = figure.series.iter().chain(&figure.panels).chain(&figure.names);
        figure.shown().chain([&figure.x]).chain(apart)
    });
    names.map(String::as_str).chain(["status"]).collect()
}

#[cfg(test)]
mod tests {
    use report::TableColumn;

    use super::*;

    /// Looks for variation in columns over `x`, with a curve for each `s`.
    fn found(rows: &[[Cell; 4]]) -> Variation {
        let heads = ["x", "s", "a", "b"].map(|name| TableColumn::new(name, "")).to_vec();
        let table = DataTable::new(heads, rows.iter().map(|row| row.to_vec()).collect()).unwrap();
        let figure = Figure::new("x".to_owned(), vec!["a".to_owned(), "b".to_owned()]);
        let figure = Figure { series: vec!["s".to_owned()], ..figure };
        let mut ranges = FigureRanges::of(&figure);
        // The rows come one at a time.
        for row in table.rows() {
            let one = DataTable::new(table.columns().to_vec(), vec![row.clone()]).unwrap();
            ranges.add(&one).unwrap();
        }
        ranges.variation(1e-6)
    }

    fn row(x: f64, s: &str, a: f64, b: Option<f64>) -> [Cell; 4] {
        [x.into(), s.into(), a.into(), b.map_or(Cell::Missing, Cell::Number)]
    }

    #[test]
    fn only_what_varies_along_a_curve_is_shown() {
        let shown = |rows: &[[Cell; 4]]| match found(rows) {
            Variation::Varies(figure) => figure.y,
            other => panic!("{other:?}"),
        };
        let apart = [row(1.0, "u", 5.0, Some(1.0)), row(2.0, "u", 5.0 + 1e-7, Some(3.0))];
        assert_eq!(shown(&apart), ["b"], "the rest is the solver's noise");
        let several =
            [row(1.0, "u", 5.0, None), row(2.0, "u", 5.0, None), row(2.0, "v", 6.0, None)];
        assert_eq!(found(&several), Variation::Constant, "curves that differ may each be flat");
        assert_eq!(
            found(&[row(1.0, "u", 1.0, None), row(1.0, "v", 2.0, None)]),
            Variation::Unknown
        );
        assert_eq!(found(&[]), Variation::Unknown);
        let zero = [row(1.0, "u", 0.0, None), row(2.0, "u", 0.0, None)];
        assert_eq!(found(&zero), Variation::Constant);
    }
}
