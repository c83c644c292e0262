//! The columns of contacts that wear.

use contact::model::{Outcome, Worn};

use super::rolling::last_distance;
use crate::columns::column::{Column, ColumnSource};
use crate::columns::result_columns::result_columns;
use crate::job::Case;
use crate::value::Value;

/// The columns. Depths and volumes are those that both surfaces lose together.
pub(crate) const WEAR: &[Column] = result_columns! {
    Observable "wear_depth" ("depth of wear") Length
        "largest depth worn away along the path; of steady rolling, in one pass"
        ColumnSource::Outcome(|outcome| last(outcome, |worn| worn.depth));
    Observable "wear_volume" ("volume worn away") Volume
        "volume worn away along the whole path; of steady rolling, over the distance `dq`"
        ColumnSource::Outcome(volume);
    Observable "cycle_wear_depth" ("depth of wear per cycle") Length
        "growth of the largest depth of wear in the last cycle of the path"
        ColumnSource::Outcome(cycle_depth);
    Observable "cycle_wear_volume" ("volume worn away per cycle") Volume
        "volume worn away in the last cycle of the path"
        ColumnSource::Outcome(cycle_volume);
    Observable "wear_per_length" ("volume worn away per length rolled") Area
        "volume worn away in the last increment over the distance that it rolls"
        ColumnSource::Solved(per_length);
};

/// Reads a number from the wear of the last increment, if the scene wears.
fn last(outcome: &Outcome, read: fn(&Worn) -> f64) -> Value {
    outcome.further.wear.last().map_or(Value::Missing, |worn| Value::Number(read(worn)))
}

fn per_length(case: &Case, outcome: &Outcome) -> Value {
    match (last_distance(case, outcome), outcome.further.wear.last()) {
        (Some(distance), Some(worn)) => Value::Number(worn.volume / distance),
        _ => Value::Missing,
    }
}

fn volume(outcome: &Outcome) -> Value {
    let wear = &outcome.further.wear;
    if wear.is_empty() {
        return Value::Missing;
    }
    Value::Number(wear.iter().map(|worn| worn.volume).sum())
}

/// Returns the wear of the increments before the last cycle, and that of its own; `None` for a path
/// that does not wear or ends outside of a cycle.
fn of_last_cycle(outcome: &Outcome) -> Option<[&[Worn]; 2]> {
    let cycle = outcome.last()?.cycle;
    let before = outcome.steps.iter().take_while(|step| step.cycle < cycle).count();
    let (before, during) = outcome.further.wear.split_at_checked(before)?;
    (cycle > 0 && !during.is_empty()).then_some([before, during])
}

fn cycle_depth(outcome: &Outcome) -> Value {
    of_last_cycle(outcome).map_or(Value::Missing, |[before, during]| {
        let depth = |wear: &[Worn]| wear.last().map_or(0.0, |worn| worn.depth);
        Value::Number(depth(during) - depth(before))
    })
}

fn cycle_volume(outcome: &Outcome) -> Value {
    of_last_cycle(outcome).map_or(Value::Missing, |[_, during]| {
        Value::Number(during.iter().map(|worn| worn.volume).sum())
    })
}
