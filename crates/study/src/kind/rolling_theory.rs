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
