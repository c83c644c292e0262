//! The columns of contacts that roll. Creepages and distances follow from the motion of the punch
//! and the step that rolls, so that nothing of them is stored.

use contact::model::{Outcome, Rolled, Rolling, RollingHistory, StepOutcome};

use crate::columns::column::{Column, ColumnSource};
use crate::columns::result_columns::result_columns;
use crate::job::Case;
use crate::value::Value;

/// The columns.
pub(crate) const ROLLING: &[Column] = result_columns! {
    Observable "at_creepage_x" Pure "longitudinal creepage of the last increment, if it rolls"
        ColumnSource::Solved(|case, outcome| of_roll(case, outcome, |roll| roll.rolled.creepage_x));
    Observable "at_creepage_y" Pure "lateral creepage of the last increment, if it rolls"
        ColumnSource::Solved(|case, outcome| of_roll(case, outcome, |roll| roll.rolled.creepage_y));
    Observable "at_spin" AnglePerLength "spin of the last increment, if it rolls"
        ColumnSource::Solved(|case, outcome| of_roll(case, outcome, |roll| roll.rolled.spin));
    Observable "increment_distance" Length "distance of the last increment, if it rolls"
        ColumnSource::Solved(|case, outcome| of_roll(case, outcome, |roll| roll.distance()));
    Observable "leading_edge" ("x of the leading edge") Length
        "x of the outer side of the foremost element in contact, in the direction of rolling, after \
         the last increment, if it rolls"
        ColumnSource::Outcome(|outcome| {
            let edge = outcome.further.leading_edges.last().copied().flatten();
            edge.map_or(Value::Missing, Value::Number)
        });
    Observable "rolled_distance" Length "distance that was rolled along the path"
        ColumnSource::Solved(rolled_distance);
    Observable "force_x_ratio" ("force along x over μP") Pure
        "tangential force along x over the friction times the normal force"
        ColumnSource::Solved(|case, outcome| over_limit(case, outcome, |end| end.observables.force_x));
    Observable "force_y_ratio" ("force along y over μP") Pure
        "tangential force along y over the friction times the normal force"
        ColumnSource::Solved(|case, outcome| over_limit(case, outcome, |end| end.observables.force_y));
    Observable "force_ratio" ("tangential force over μP") Pure
        "size of the tangential force over the friction times the normal force"
        ColumnSource::Solved(|case, outcome| {
            over_limit(case, outcome, |end| end.observables.force_x.hypot(end.observables.force_y))
        });
    Observable "dissipation_per_length" ("energy lost per length rolled") EnergyPerLength
        "energy lost to friction in the last increment over the distance that it rolls"
        ColumnSource::Solved(|case, outcome| {
            of_roll(case, outcome, |roll| roll.end.observables.dissipation / roll.distance())
        });
};

/// An increment that rolls.
struct RolledIncrement<'a> {
    rolling: &'a Rolling,
    end: &'a StepOutcome,
    rolled: Rolled,
}

impl<'a> RolledIncrement<'a> {
    /// Returns the increment of a case as one that rolls, if it does.
    fn of(case: &'a Case, end: &'a StepOutcome) -> Option<Self> {
        let rolling = case.scene.loading.steps.get(end.step as usize)?.rolling.as_ref()?;
        let rolled = rolling.rolled(&end.motion, end.observables.element_x);
        Some(RolledIncrement { rolling, end, rolled })
    }

    /// Returns the distance \[m\].
    fn distance(&self) -> f64 {
        self.rolled.distance
    }
}

/// Reads a number from the last increment, if it rolls.
fn of_roll(case: &Case, outcome: &Outcome, read: fn(&RolledIncrement<'_>) -> f64) -> Value {
    let roll = outcome.last().and_then(|end| RolledIncrement::of(case, end));
    roll.map_or(Value::Missing, |roll| Value::Number(read(&roll)))
}

/// Returns the distance that the last increment rolls \[m\], if it does.
pub(super) fn last_distance(case: &Case, outcome: &Outcome) -> Option<f64> {
    outcome.last().and_then(|end| RolledIncrement::of(case, end)).map(|roll| roll.distance())
}

/// Returns the distance that was rolled since the path began, if a step of it rolls so.
fn rolled_distance(case: &Case, outcome: &Outcome) -> Value {
    let is_passing = |rolling: &Rolling| rolling.history == RollingHistory::Transient;
    if !case.scene.loading.steps.iter().filter_map(|step| step.rolling.as_ref()).any(is_passing) {
        return Value::Missing;
    }
    // A step's increments are counted, so that its distance comes out as it was given.
    let mut rolled = vec![(0.0, 0.0); case.scene.loading.steps.len()];
    for roll in outcome.steps.iter().filter_map(|end| RolledIncrement::of(case, end)) {
        if is_passing(roll.rolling) {
            let (distance, count) = &mut rolled[roll.end.step as usize];
            *distance = roll.distance();
            *count += 1.0;
        }
    }
    Value::Number(rolled.into_iter().fold(0.0, |sum, (distance, count)| sum + distance * count))
}

/// Reads a force from the last increment, over the largest that friction bears.
fn over_limit(case: &Case, outcome: &Outcome, read: fn(&StepOutcome) -> f64) -> Value {
    let Some(end) = outcome.last() else { return Value::Missing };
    let limit = case.scene.friction.mu * end.observables.load;
    // The sum turns −0 into 0.
    if limit > 0.0 { Value::Number(read(end) / limit + 0.0) } else { Value::Missing }
}

#[cfg(test)]
mod tests {
    use contact::model::Motion;

    use super::*;
    use crate::job::Job;
    use crate::record::tests::solved;

    /// Returns a case with these load steps.
    fn case(steps: &str) -> Case {
        let job = format!(
            r#"{{"kind":"solve","scene":{{"foundation":{{"base":{{"shear_modulus":1.0,"poisson":0.3}}}},"punch":{{"shape":"sphere","radius":1.0}},"friction":{{"mu":0.5}},"loading":{{"steps":[{steps}]}}}},"numerics":{{"mesh":8}}}}"#
        );
        let job: Job = serde_json::from_str(&job).unwrap_or_else(|error| panic!("{job}: {error}"));
        job.case().unwrap().clone()
    }

    /// Returns the outcome of increments of these steps of a case, each with this motion, the load
    /// 4 and the forces 1 and −1.
    fn outcome(steps: &[u32], motion: Motion) -> Outcome {
        let mut outcome = solved().outcome().unwrap().clone();
        let mut end = *outcome.last().unwrap();
        (end.motion, end.observables.element_x) = (motion, 0.5);
        (end.observables.load, end.observables.dissipation) = (4.0, 3.0);
        (end.observables.force_x, end.observables.force_y) = (1.0, -1.0);
        outcome.steps = steps.iter().map(|step| StepOutcome { step: *step, ..end }).collect();
        outcome
    }

    fn value(name: &str, case: &Case, outcome: &Outcome) -> Value {
        let column = ROLLING.iter().find(|column| column.name == name).unwrap();
        let ColumnSource::Solved(read) = column.source else { panic!("{name}") };
        read(case, outcome)
    }

    #[test]
    fn creepages_are_given_or_those_of_the_motion() {
        let motion = Motion { shift_x: -1e-3, shift_y: 2e-3, twist: -5e-3, ..Motion::default() };
        let of = |rolling: &str| {
            let case =
                case(&format!(r#"{{"approach":0.1,"rolling":{{{rolling}"history":"steady"}}}}"#));
            let read = |name| value(name, &case, &outcome(&[0], motion));
            [read("at_creepage_x"), read("at_creepage_y"), read("at_spin")]
        };
        // An element is 0.5 long.
        assert_eq!(of(""), [2e-3, -4e-3, 1e-2].map(Value::Number));
        assert_eq!(of(r#""dq":0.25,"#), [4e-3, -8e-3, 2e-2].map(Value::Number));
        assert_eq!(
            of(r#""creepage_x":7e-3,"spin":3e-2,"spin_center":0.1,"#),
            [7e-3, 3e-2 * 0.1 - 4e-3, 3e-2].map(Value::Number)
        );
        let pressed = case(r#"{"approach":0.1}"#);
        assert_eq!(value("at_spin", &pressed, &outcome(&[0], motion)), Value::Missing);
    }

    #[test]
    fn the_distance_adds_up_along_the_path() {
        let case = case(
            r#"{"approach":0.1},{"increments":3,"rolling":{"dq":0.25,"history":"transient"}},{"rolling":{"history":"steady"}}"#,
        );
        for (steps, distance, per_length) in [
            (&[0][..], 0.0, None),
            (&[0, 1], 0.25, Some(12.0)),
            (&[0, 1, 1, 1], 0.75, Some(12.0)),
            (&[0, 1, 1, 1, 2], 0.75, Some(6.0)),
        ] {
            let outcome = outcome(steps, Motion::default());
            let read = |name| value(name, &case, &outcome);
            assert_eq!(read("rolled_distance"), Value::Number(distance));
            let expected = per_length.map_or(Value::Missing, Value::Number);
            assert_eq!(read("dissipation_per_length"), expected);
        }
        let steady = self::case(r#"{"approach":0.1,"rolling":{"history":"steady"}}"#);
        let outcome = outcome(&[0], Motion::default());
        assert_eq!(value("rolled_distance", &steady, &outcome), Value::Missing);
    }

    #[test]
    fn forces_are_compared_with_those_that_friction_bears() {
        let mut case = case(r#"{"approach":0.1}"#);
        let outcome = outcome(&[0], Motion::default());
        let read = |case: &Case| {
            ["force_x_ratio", "force_y_ratio", "force_ratio"]
                .map(|name| value(name, case, &outcome))
        };
        assert_eq!(read(&case), [0.5, -0.5, 0.5f64.sqrt()].map(Value::Number));
        case.scene.friction.mu = 0.0;
        assert_eq!(read(&case), [Value::Missing, Value::Missing, Value::Missing]);
    }
}
