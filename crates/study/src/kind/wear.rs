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
        "largest depth worn away along the path from material that is within Ω at its end; of steady \
         rolling, in one pass"
        ColumnSource::Outcome(|outcome| last(outcome, |worn| worn.depth));
    Observable "wear_volume" ("volume worn away") Volume
        "volume worn away along the whole path; of steady rolling, over the distance `dq`"
        ColumnSource::Outcome(volume);
    Observable "cycle_wear_depth" ("depth of wear per cycle") Length
        "growth of the largest depth of wear in the last cycle of the path, if no step of it rolls"
        ColumnSource::Solved(cycle_depth);
    Observable "cycle_wear_volume" ("volume worn away per cycle") Volume
        "volume worn away in the last cycle of the path; a step that rolls steadily counts for its \
         distance dq"
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

/// Reads the growth of the depth in the last cycle. Where a step of it rolls, other material stands
/// in Ω after it than before.
fn cycle_depth(case: &Case, outcome: &Outcome) -> Value {
    let loading = &case.scene.loading;
    let cycle = loading.cycle_from.map_or(0, |from| from as usize);
    if loading.steps.iter().skip(cycle).any(|step| step.rolling.is_some()) {
        return Value::Missing;
    }
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

#[cfg(test)]
mod tests {
    use contact::model::StepOutcome;

    use super::*;
    use crate::job::Job;
    use crate::record::tests::solved;

    const SHIFT: &str = r#"{"shift_x":1e-3}"#;
    const ROLL: &str = r#"{"rolling":{"creepage_x":1e-3,"history":"steady"}}"#;

    /// Returns a figure of a path of three steps, the last two of them in two cycles.
    fn figure(name: &str, steps: [&str; 2]) -> Value {
        let job = format!(
            r#"{{"kind":"solve","scene":{{"foundation":{{"base":{{"shear_modulus":1.0,"poisson":0.3}}}},"punch":{{"shape":"sphere","radius":1.0}},"friction":{{"mu":0.5}},"wear":{{"coefficient":1e-3}},"loading":{{"steps":[{{"approach":0.1}},{}],"cycle_from":1,"cycles":2}}}},"numerics":{{"mesh":8}}}}"#,
            steps.join(",")
        );
        let job: Job = serde_json::from_str(&job).unwrap_or_else(|error| panic!("{job}: {error}"));
        let mut outcome = solved().outcome().unwrap().clone();
        let end = *outcome.last().unwrap();
        let places = [(0, 0), (1, 1), (2, 1), (1, 2), (2, 2)];
        outcome.steps = places
            .iter()
            .map(|(step, cycle)| StepOutcome { step: *step, cycle: *cycle, ..end })
            .collect();
        let worn = [(0.0, 0.0), (1.0, 10.0), (2.0, 20.0), (4.0, 40.0), (8.0, 80.0)];
        outcome.further.wear =
            worn.iter().map(|(depth, volume)| Worn { depth: *depth, volume: *volume }).collect();
        let column = WEAR.iter().find(|column| column.name == name).unwrap();
        match column.source {
            ColumnSource::Solved(read) => read(job.case().unwrap(), &outcome),
            ColumnSource::Outcome(read) => read(&outcome),
            _ => panic!("{name}"),
        }
    }

    /// The material after a cycle that rolls is not that before it, so that there is no growth.
    #[test]
    fn a_depth_grows_in_a_cycle_that_does_not_roll() {
        assert_eq!(figure("cycle_wear_depth", [SHIFT; 2]), Value::Number(6.0));
        for steps in [[ROLL, SHIFT], [SHIFT, ROLL], [ROLL, ROLL]] {
            assert_eq!(figure("cycle_wear_depth", steps), Value::Missing);
            assert_eq!(figure("cycle_wear_volume", steps), Value::Number(120.0));
            assert_eq!(figure("wear_volume", steps), Value::Number(150.0));
        }
        assert_eq!(figure("wear_depth", [SHIFT; 2]), Value::Number(8.0));
    }
}
