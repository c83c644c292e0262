//! The columns of what theories foretell for a contact that rolls, beside those of what was
//! computed, and of what is proved about it.

use contact::assess::RollingTheory;
use contact::model::{Outcome, StepOutcome};
use contact::uniqueness::rolling::is_proved;

use crate::columns::column::{Column, ColumnSource};
use crate::columns::result_columns::result_columns;
use crate::job::Case;
use crate::value::Value;

/// Reads a number from what theories say of the last increment.
macro_rules! foretold {
    ($read:expr) => {
        ColumnSource::Solved(|case, outcome| {
            let theory = of_last(case, outcome).and_then($read);
            theory.map_or(Value::Missing, Value::Number)
        })
    };
}

/// The columns. Where the theories do not hold they are empty: for contacts that do not roll, are
/// layered, rough or flat, or have no friction.
pub(crate) const ROLLING_THEORY: &[Column] = result_columns! {
    Observable "linear_force_x" ("force along x, linear theory") Force
        "force along x of Kalker's linear theory of Hertz's ellipse, in which nothing slips and \
         pressure and traction do not couple"
        foretold!(|(theory, _)| Some(theory.linear.force_x));
    Observable "linear_force_y" ("force along y, linear theory") Force
        "force along y of Kalker's linear theory, likewise"
        foretold!(|(theory, _)| Some(theory.linear.force_y));
    Observable "linear_moment_z" ("moment about z, linear theory") Moment
        "moment about z of Kalker's linear theory, likewise"
        foretold!(|(theory, _)| Some(theory.linear.moment_z));
    Observable "force_x_over_linear" ("force along x over linear theory") Pure
        "force along x over that of Kalker's linear theory"
        foretold!(|(theory, end)| ratio(end.observables.force_x, theory.linear.force_x));
    Observable "force_y_over_linear" ("force along y over linear theory") Pure
        "force along y over that of Kalker's linear theory"
        foretold!(|(theory, end)| ratio(end.observables.force_y, theory.linear.force_y));
    Observable "moment_z_over_linear" ("moment about z over linear theory") Pure
        "moment about z over that of Kalker's linear theory"
        foretold!(|(theory, end)| ratio(end.observables.moment_z, theory.linear.moment_z));
    Observable "vermeulen_johnson_force_x" ("force along x, Vermeulen and Johnson") Force
        "force along x after Vermeulen and Johnson, who know no spin and no coupling"
        foretold!(|(theory, _)| Some(theory.vermeulen_johnson?[0]));
    Observable "vermeulen_johnson_force_y" ("force along y, Vermeulen and Johnson") Force
        "force along y after Vermeulen and Johnson, who know no spin and no coupling"
        foretold!(|(theory, _)| Some(theory.vermeulen_johnson?[1]));
    Observable "shen_hedrick_elkins_force_x" ("force along x, Shen, Hedrick and Elkins") Force
        "force along x after Shen, Hedrick and Elkins, without coupling"
        foretold!(|(theory, _)| Some(theory.shen_hedrick_elkins[0]));
    Observable "shen_hedrick_elkins_force_y" ("force along y, Shen, Hedrick and Elkins") Force
        "force along y after Shen, Hedrick and Elkins, without coupling"
        foretold!(|(theory, _)| Some(theory.shen_hedrick_elkins[1]));
    Certificate "only_solution" Text
        "proved if every increment has one solution, whatever the friction and the loads; open if \
         that is not known"
        ColumnSource::Solved(|case, _| {
            let is_proved = is_proved(&case.scene, case.numerics.projection);
            Value::Text(if is_proved { "proved" } else { "open" }.to_owned())
        });
};

/// Returns what theories say of the last increment, and that increment.
fn of_last<'a>(case: &Case, outcome: &'a Outcome) -> Option<(RollingTheory, &'a StepOutcome)> {
    let end = outcome.last()?;
    Some((RollingTheory::of(&case.scene, end, outcome.hertz.as_ref())?, end))
}

/// Returns `a`/`b` unless `b` is 0.
fn ratio(a: f64, b: f64) -> Option<f64> {
    (b != 0.0).then_some(a / b)
}

#[cfg(test)]
mod tests {
    use contact::model::Motion;
    use contact::theory::KalkerCoefficients;

    use super::*;
    use crate::job::Job;
    use crate::record::tests::solved;

    /// Returns a case with this material of the punch and this load step.
    fn case(material: &str, step: &str) -> Case {
        let job = format!(
            r#"{{"kind":"solve","scene":{{"foundation":{{"base":{{"shear_modulus":1.0,"poisson":0.25}}}},"punch":{{"shape":"sphere","radius":1.0,"material":{material}}},"friction":{{"mu":0.5}},"loading":{{"steps":[{step}]}}}},"numerics":{{"mesh":8,"projection":"average"}}}}"#
        );
        let job: Job = serde_json::from_str(&job).unwrap_or_else(|error| panic!("{job}: {error}"));
        job.case().unwrap().clone()
    }

    fn value(name: &str, case: &Case, motion: Motion) -> Value {
        let mut outcome = solved().outcome().unwrap().clone();
        let mut end = *outcome.last().unwrap();
        (end.step, end.motion, end.observables.load) = (0, motion, 1e-3);
        (end.observables.element_x, end.observables.force_x) = (0.5, -1e-6);
        outcome.steps = vec![end];
        let column = ROLLING_THEORY.iter().find(|column| column.name == name).unwrap();
        let ColumnSource::Solved(read) = column.source else { panic!("{name}") };
        read(case, &outcome)
    }

    const LIKE: &str = r#"{"shear_modulus":1.0,"poisson":0.25}"#;

    #[test]
    fn forces_are_those_of_the_theories() {
        let rolling = r#"{"normal_force":1e-3,"rolling":{"history":"steady"}}"#;
        // The creepage is 1e-6. Like bodies have E* = G/(1 − ν), and the radius a³ = 3PR/4E*.
        let motion = Motion { shift_x: -5e-7, ..Motion::default() };
        let square = (0.75 * 1e-3 * 0.75f64).cbrt().powi(2);
        let c11 = KalkerCoefficients::new(1.0, 0.25).unwrap().c11;
        let read = |name| value(name, &case(LIKE, rolling), motion).as_f64().unwrap();
        let linear = -square * c11 * 1e-6;
        assert!((read("linear_force_x") / linear - 1.0).abs() < 1e-12);
        assert!((read("force_x_over_linear") / (-1e-6 / linear) - 1.0).abs() < 1e-12);
        let u = -linear / 5e-4;
        let saturated = -5e-4 * (1.0 - (1.0 - u / 3.0).powi(3));
        for name in ["vermeulen_johnson_force_x", "shen_hedrick_elkins_force_x"] {
            assert!((read(name) / saturated - 1.0).abs() < 1e-12, "{name}");
        }
        // No force along y, and none to compare with.
        assert_eq!(read("shen_hedrick_elkins_force_y"), 0.0);
        let ratio = value("force_y_over_linear", &case(LIKE, rolling), motion);
        assert_eq!(ratio, Value::Missing);
        // With spin one of them has nothing to say.
        let turning = Motion { twist: 1e-6, ..motion };
        let with_spin = |name| value(name, &case(LIKE, rolling), turning);
        assert_eq!(with_spin("vermeulen_johnson_force_x"), Value::Missing);
        assert!(with_spin("shen_hedrick_elkins_force_x").as_f64().is_some());
    }

    #[test]
    fn contacts_that_do_not_roll_have_no_theory_of_rolling() {
        let still = case(LIKE, r#"{"normal_force":1e-3}"#);
        for column in ROLLING_THEORY.iter().filter(|column| column.name != "only_solution") {
            assert_eq!(value(&column.name, &still, Motion::default()), Value::Missing);
        }
    }

    #[test]
    fn one_solution_is_proved_without_coupling() {
        let rolling = r#"{"normal_force":1e-3,"rolling":{"history":"steady"}}"#;
        let of = |material| value("only_solution", &case(material, rolling), Motion::default());
        assert_eq!(of(LIKE), Value::Text("proved".to_owned()));
        assert_eq!(of("null"), Value::Text("open".to_owned()));
    }
}
