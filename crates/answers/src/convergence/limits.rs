//! The table of limits, by Richardson's extrapolation.

use contact::model::Observables;
use contact::theory::{Trend, richardson};
use report::{Cell, DataTable, TableColumn};
use study::Study;
use study::key::Key;
use study::kind::convergence::Ladder;

use super::ladder::LadderRungs;
use crate::error::AnswerError;
use crate::rows::{digits, rounded};

/// A quantity whose limit is estimated.
struct LimitQuantity {
    name: &'static str,
    /// Its SI unit.
    unit: &'static str,
    read: fn(&Observables) -> f64,
}

const QUANTITIES: [LimitQuantity; 6] = [
    LimitQuantity { name: "load", unit: "N", read: |o| o.load },
    LimitQuantity { name: "tangential_force", unit: "N", read: Observables::tangential_force },
    LimitQuantity { name: "peak_pressure", unit: "Pa", read: |o| o.peak_pressure },
    LimitQuantity { name: "contact_area", unit: "m²", read: |o| o.contact_area },
    LimitQuantity { name: "stick_area", unit: "m²", read: |o| o.stick_area },
    LimitQuantity { name: "energy", unit: "J", read: |o| o.energy },
];

/// The least number of rungs that an extrapolation takes.
const LEAST_RUNGS: usize = 3;

/// Returns what the quantities of each ladder of meshes tend to; `None` for other ladders and for
/// ladders that are all too short.
pub(super) fn table(
    study: &Study,
    ladder: &Ladder,
    ladders: &[LadderRungs<'_>],
) -> Result<Option<DataTable>, AnswerError> {
    if ladder.along != Key::Mesh || ladders.iter().all(|rungs| rungs.rungs.len() < LEAST_RUNGS) {
        return Ok(None);
    }
    let mut heads = ladders.first().map(|rungs| rungs.place.heads(study)).unwrap_or_default();
    heads.extend(
        ["quantity", "unit", "finest", "limit", "± (estimated)", "order", "values", "rungs"]
            .map(|name| TableColumn::new(name, "")),
    );
    let rows = ladders
        .iter()
        .flat_map(|rungs| QUANTITIES.iter().filter_map(|quantity| row(rungs, quantity)))
        .collect();
    Ok(Some(DataTable::new(heads, rows)?))
}

/// Returns the row of a quantity, `None` if it has no limit or is prescribed.
fn row(ladder: &LadderRungs<'_>, quantity: &LimitQuantity) -> Option<Vec<Cell>> {
    let values: Vec<(f64, f64)> = ladder
        .rungs
        .iter()
        .filter_map(|rung| Some((rung.height, (quantity.read)(&rung.outcome.last()?.observables))))
        .collect();
    let limit = richardson(&values).ok()?;
    let (_, finest) = values.last()?;
    let is_prescribed =
        values.iter().all(|(_, value)| (value - finest).abs() <= ladder.noise * finest.abs());
    if is_prescribed {
        return None;
    }
    let mut row = ladder.place.cells();
    row.extend([
        Cell::Text(quantity.name.to_owned()),
        Cell::Text(quantity.unit.to_owned()),
        Cell::Number(*finest),
        Cell::Number(limit.value),
        Cell::Number(digits(limit.uncertainty, 1)),
        rounded(limit.order, 2),
        Cell::Text(in_words(limit.trend).to_owned()),
        Cell::Text(ladder.solved()),
    ]);
    Some(row)
}

fn in_words(trend: Trend) -> &'static str {
    match trend {
        Trend::Settled => "the same to rounding",
        Trend::Asymptotic => "one order",
        Trend::Converging => "converging",
        Trend::Scattered => "scattered",
    }
}
