//! The columns of a suggested figure that vary along its abscissa.

use std::collections::HashMap;

use report::{Cell, DataTable, TableError};
use study::figure::FigureKind;
use study::{Figure, StudyPoint};

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
enum CellIdentity<'c> {
    Number(u64),
    Integer(i64),
    Flag(bool),
    Text(&'c str),
    Missing,
}

impl CellIdentity<'_> {
    fn of(cell: &Cell) -> CellIdentity<'_> {
        match cell {
            Cell::Number(number) => CellIdentity::Number(number.to_bits()),
            Cell::Integer(integer) => CellIdentity::Integer(*integer),
            Cell::Flag(yes) => CellIdentity::Flag(*yes),
            Cell::Text(text) => CellIdentity::Text(text),
            Cell::Missing => CellIdentity::Missing,
        }
    }
}

/// Looks for columns of a figure that vary by more than a relative `noise` along some curve. The
/// rows of the table are certified results.
pub(crate) fn variation(
    table: &DataTable,
    figure: &Figure,
    noise: f64,
) -> Result<Variation, AnswerError> {
    let index = |name: &String| table.column(name).map_err(TableError::from);
    let x = index(&figure.x)?;
    if figure.kind == FigureKind::Histogram {
        return Ok(spread(table, figure, x, noise));
    }
    let apart = figure.series.iter().chain(&figure.panels);
    let apart = apart.map(index).collect::<Result<Vec<usize>, _>>()?;
    let mut curves: HashMap<Vec<CellIdentity<'_>>, Vec<&[Cell]>> = HashMap::new();
    for row in table.rows().iter().filter(|row| row[x].number().is_some()) {
        let curve = apart.iter().map(|column| CellIdentity::of(&row[*column])).collect();
        curves.entry(curve).or_default().push(row);
    }
    let has_two = |rows: &&Vec<&[Cell]>| rows.iter().any(|row| row[x] != rows[0][x]);
    let curves: Vec<&Vec<&[Cell]>> = curves.values().filter(has_two).collect();
    if curves.is_empty() {
        return Ok(Variation::Unknown);
    }
    let varies = |name: &String| -> Result<bool, AnswerError> {
        let y = index(name)?;
        Ok(curves.iter().any(|rows| {
            let values = || rows.iter().filter_map(|row| row[y].number()).filter(|v| v.is_finite());
            let (least, most) = (
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            );
            most - least > noise * least.abs().max(most.abs())
        }))
    };
    let mut shown = Vec::new();
    for name in &figure.y {
        if varies(name)? {
            shown.push(name.clone());
        }
    }
    let has_band = match &figure.band {
        Some([low, high]) => varies(low)? || varies(high)?,
        None => false,
    };
    if shown.is_empty() && !has_band {
        return Ok(Variation::Constant);
    }
    let band = figure.band.clone().filter(|_| has_band);
    Ok(Variation::Varies(Box::new(Figure { y: shown, band, ..figure.clone() })))
}

/// Looks for variation among the values that a histogram counts, which are those of column `x`.
fn spread(table: &DataTable, figure: &Figure, x: usize, noise: f64) -> Variation {
    let values = table.rows().iter().filter_map(|row| row[x].number()).filter(|x| x.is_finite());
    let values: Vec<f64> = values.collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    match values.len() {
        0 | 1 => Variation::Unknown,
        _ if most - least > noise * least.abs().max(most.abs()) => {
            Variation::Varies(Box::new(figure.clone()))
        }
        _ => Variation::Constant,
    }
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
        variation(&table, &Figure { series: vec!["s".to_owned()], ..figure }, 1e-6).unwrap()
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
