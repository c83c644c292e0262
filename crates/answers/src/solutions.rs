//! The solutions that a search has found, as a table.

use contact::multiplicity::{Multiplicity, Origin, Solution};
use report::{Cell, DataTable, TableColumn};

use crate::error::AnswerError;
use crate::rows::digits;

/// Returns a table with a row for each solution.
pub(crate) fn table(found: &Multiplicity) -> Result<DataTable, AnswerError> {
    let heads = [
        ("solution", ""),
        ("load", "N"),
        ("force_x", "N"),
        ("force_y", "N"),
        ("contact_area", "m²"),
        ("stick_area", "m²"),
        ("distance", "1"),
        ("index", ""),
        ("error", "1"),
        ("residual", "1"),
        ("reached", ""),
        ("first from", ""),
    ];
    let row = |(index, solution): (usize, &Solution)| {
        let o = &solution.observables;
        vec![
            Cell::Integer(index as i64),
            Cell::Number(o.load),
            Cell::Number(o.force_x),
            Cell::Number(o.force_y),
            Cell::Number(o.contact_area),
            Cell::Number(o.stick_area),
            solution.distances.first().map_or(Cell::Missing, |distance| Cell::Number(*distance)),
            solution.index.map_or(Cell::Missing, Cell::Integer),
            Cell::Number(digits(solution.error, 1)),
            Cell::Number(digits(solution.certificate.residual, 1)),
            i64::try_from(solution.reached).map_or(Cell::Missing, Cell::Integer),
            Cell::Text(origin(solution.origin)),
        ]
    };
    let rows = found.solutions.iter().enumerate().map(row).collect();
    Ok(DataTable::new(heads.map(|(name, unit)| TableColumn::new(name, unit)).to_vec(), rows)?)
}

/// Says where a start comes from.
fn origin(origin: Origin) -> String {
    match origin {
        Origin::Before => "the end of the increment before".to_owned(),
        Origin::Nothing => "nothing".to_owned(),
        Origin::Hertz => "a half ellipsoid of pressure".to_owned(),
        Origin::Stick => "stick everywhere".to_owned(),
        Origin::Slip(eighths) => format!("slip everywhere, at {}°", 45 * eighths),
        Origin::Tractions(n) => format!("random tractions {n}"),
        Origin::Pattern(n) => format!("random pattern {n}"),
        Origin::FrictionFromAbove => "a larger μ".to_owned(),
        Origin::FrictionFromBelow => "a smaller μ".to_owned(),
        Origin::Image(solution) => format!("an image of solution {solution}"),
        Origin::Disturbed(solution) => format!("solution {solution}, disturbed"),
        Origin::FrictionLoopAbove(solution) => format!("solution {solution}, over a larger μ"),
        Origin::FrictionLoopBelow(solution) => format!("solution {solution}, over a smaller μ"),
        Origin::Deflated(last) => format!("deflation of all up to solution {last}"),
        Origin::Between([a, b]) => format!("between solutions {a} and {b}"),
    }
}
