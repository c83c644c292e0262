//! The table of orders: error ~ h^order.

use contact::assess::Errors;
use contact::theory::{PowerLaw, power_law};
use report::{Cell, DataTable, TableColumn};
use study::Study;
use study::columns::Compared;
use study::key::Key;
use study::kind::convergence::Ladder;

use super::ladder::LadderRungs;
use crate::error::AnswerError;
use crate::rows::digits;

/// Returns how each error falls along each ladder; `compared` has an entry for each point.
pub(super) fn table(
    study: &Study,
    ladder: &Ladder,
    ladders: &[LadderRungs<'_>],
    compared: &[Option<Compared>],
) -> Result<DataTable, AnswerError> {
    let mut heads = ladders.first().map(|rungs| rungs.place.heads(study)).unwrap_or_default();
    let (along, unit) = if ladder.along == Key::Epsilon { ("epsilon", "") } else { ("h", "m") };
    heads.extend(["error", "order", "±"].map(|name| TableColumn::new(name, "")));
    heads.extend(["from", "to"].map(|end| TableColumn::new(format!("{along} {end}"), unit)));
    heads.extend(["finest error", "reference", "rungs"].map(|name| TableColumn::new(name, "")));
    let names: Vec<&str> = Errors::default().named().map(|(name, _)| name).collect();
    let rows = ladders
        .iter()
        .flat_map(|rungs| names.iter().filter_map(|name| row(rungs, name, compared)))
        .collect();
    Ok(DataTable::new(heads, rows)?)
}

/// Returns the row of an error, `None` if no rung has one above the solver's.
fn row(
    ladder: &LadderRungs<'_>,
    name: &'static str,
    compared: &[Option<Compared>],
) -> Option<Vec<Cell>> {
    let error =
        |point: usize| compared[point].as_ref().and_then(|compared| compared.errors.get(name));
    let errors: Vec<(f64, f64)> =
        ladder.rungs.iter().filter_map(|rung| Some((rung.height, error(rung.point)?))).collect();
    let (_, finest) = errors.last().copied()?;
    // ε = 0 is no point on a logarithmic axis.
    let line: Vec<(f64, f64)> =
        errors.into_iter().filter(|(h, error)| *h > 0.0 && *error > ladder.noise).collect();
    if line.is_empty() {
        return None;
    }
    let mut row = ladder.place.cells();
    row.push(Cell::Text(name.to_owned()));
    row.extend(match power_law(if finest == 0.0 { &[] } else { &line }) {
        Ok(PowerLaw { slope, standard_error, range, .. }) => {
            [slope, standard_error, range[0], range[1]].map(|x| Cell::Number(digits(x, 2)))
        }
        Err(_) => [const { Cell::Missing }; 4],
    });
    row.extend([
        Cell::Number(digits(finest, 1)),
        Cell::Text(ladder.reference.clone()),
        Cell::Text(ladder.solved()),
    ]);
    Some(row)
}
