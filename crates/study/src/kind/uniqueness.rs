//! Studies that bracket the end μ* of the uniqueness set of every point.

use contact::model::{Base, Material, SceneError, Shape};
use contact::uniqueness::branch;
use contact::uniqueness::cones::ConeNode;
use contact::uniqueness::strip::letters;
use contact::uniqueness::{Bracket, Question, Sole, WitnessSearch};
use contact::{Forecast, forecast_bracket};
use identity::STORED_LIMIT;

use super::solve;
use super::spec::{KindSpec, KindTable};
use crate::assemble::{Assembler, with_article};
use crate::axis::Group;
use crate::columns::column::{Column, ColumnSource};
use crate::columns::result_columns::result_columns;
use crate::error::Mistake;
use crate::figure::Figure;
use crate::job::Job;
use crate::key::Key;
use crate::record::{Bracketed, Branched};
use crate::value::Value;

/// The description of the kind.
pub(crate) const SPEC: KindSpec = KindSpec {
    name: "uniqueness",
    has_accuracy: false,
    refuses,
    assemble: |assembler, _| Job::Uniqueness {
        question: question(assembler),
        search: witness_search(assembler),
    },
    check: refuse_too_fine,
    columns: &[BRACKET],
    usual_columns: &["mu_low", "mu_high", "bracket_width", "unbounded", "status"],
    suggestions,
    ..solve::SPEC
};

/// Tells why a bracket has no use for a key; `None` if it has.
fn refuses(key: Key) -> Option<&'static str> {
    match key {
        Key::Mu => Some("it asks for the friction"),
        Key::Steps | Key::CycleFrom | Key::Cycles => {
            Some("uniqueness does not depend on the loading")
        }
        _ if key.is_of_wear() => Some("uniqueness does not depend on wear"),
        Key::DomainWidthX | Key::DomainWidthY | Key::DomainCenterX | Key::DomainCenterY => {
            Some("the flat sole of its punch is Ω")
        }
        _ if key.is_of_interior() => Some("no scene is solved whose stresses there would be"),
        Key::Ceiling | Key::Method | Key::Tolerance | Key::MaxIterations | Key::Simulate => {
            Some("no scene is solved")
        }
        _ if key.is_of_rolling() => Some(
            "uniqueness sets are of contacts that do not roll; of one that rolls, the column \
             only_solution says what is proved when it is solved",
        ),
        _ if key.list() == Some(Key::Steps) => Some("uniqueness does not depend on the loading"),
        _ => None,
    }
}

/// Returns the question about the uniqueness set.
fn question(assembler: &mut Assembler<'_>) -> Question {
    let foundation = assembler.foundation();
    let shape = assembler.shape();
    let sole = match shape {
        Shape::FlatRectangle { width_x, width_y } => Sole::Rectangle { width_x, width_y },
        Shape::FlatDisk { radius } => Sole::Disk { radius },
        _ => {
            if let (Some(given), Some(word)) =
                (assembler.sheet().get(Key::Shape), assembler.sheet().word(Key::Shape))
            {
                let message = format!(
                    "the uniqueness set of {} is not known beforehand: where it touches depends \
                     on the load",
                    with_article(word)
                );
                let expected = "must be \"flat-rectangle\" or \"flat-disk\", whose sole is Ω";
                assembler.note(Mistake::new(given.span.clone(), message, expected));
            }
            Sole::Disk { radius: f64::NAN }
        }
    };
    Question {
        foundation,
        punch: assembler.material(),
        sole,
        mesh: assembler.mesh(),
        projection: assembler.projection(),
        epsilon: assembler.number_or_default(Key::Epsilon),
        plane: is_plane(assembler),
    }
}

/// Returns whether the search is of tractions in a plane, which leaves nothing to chance.
fn is_plane(assembler: &mut Assembler<'_>) -> bool {
    let is_plane = assembler.sheet().flag(Key::Plane).unwrap_or(false);
    for key in [Key::Starts, Key::Seed] {
        if let (true, Some(given)) = (is_plane, assembler.sheet().get(key)) {
            let message = format!(
                "a search in a plane has no `{}`: it goes through every case of signs",
                key.name()
            );
            let expected = "leave it out, or leave out `plane`";
            assembler.note(Mistake::new(given.span.clone(), message, expected));
        }
    }
    is_plane
}

/// Returns the extent of the search for a witness.
fn witness_search(assembler: &Assembler<'_>) -> WitnessSearch {
    let default = WitnessSearch::default();
    let starts = assembler.sheet().count(Key::Starts).unwrap_or(default.starts);
    WitnessSearch {
        starts,
        seed: assembler.sheet().count(Key::Seed).map_or(default.seed, u64::from),
        cases: assembler.sheet().flag(Key::Cases).unwrap_or(default.cases),
        width: assembler.sheet().number(Key::Width),
        ..default
    }
}

/// Refuses a uniqueness set on so many elements that no record can hold the proof of its end.
fn refuse_too_fine(job: &Job) -> Result<(), SceneError> {
    let Job::Uniqueness { question, search } = job else { return Ok(()) };
    // If pressures and tangential displacements are not coupled, there is no end to prove.
    let mismatch = |material: Material| (1.0 - 2.0 * material.poisson) / material.shear_modulus;
    let of_punch = question.punch.map_or(0.0, mismatch);
    let is_uncoupled = match question.foundation.base {
        Base::Elastic(material) => {
            question.foundation.layers.is_empty() && mismatch(material) == of_punch
        }
        Base::Rigid => false,
    };
    // The layout itself says why a set cannot be laid out.
    let Ok(Forecast { elements: [nx, ny], .. }) = forecast_bracket(question, search) else {
        return Ok(());
    };
    // The witness has three numbers for each element. The certificate has three numbers for each
    // class of elements that are images of each other.
    let bytes = |[nx, ny]: [usize; 2]| {
        let (x, y) = (nx.div_ceil(2), ny.div_ceil(2));
        let numbers = 3 * nx * ny + 3 * if nx == ny { x * (x + 1) / 2 } else { x * y };
        let share = match question.sole {
            Sole::Rectangle { .. } => 1.0,
            Sole::Disk { .. } => std::f64::consts::FRAC_PI_4,
        };
        8.0 * share * numbers as f64
    };
    let limit = STORED_LIMIT as f64;
    if is_uncoupled || bytes([nx, ny]) <= limit {
        return Ok(());
    }
    let coarser = |n: usize| [n, ((n * ny) as f64 / nx as f64).round().max(1.0) as usize];
    let most =
        (1..=nx).rev().map(coarser).find(|elements| bytes(*elements) <= limit).unwrap_or([1; 2]);
    Err(SceneError {
        key: "numerics.mesh".to_owned(),
        value: format!("{nx} x {ny}"),
        expected: format!(
            "must give no more than {} x {} elements, for a record of {STORED_LIMIT} bytes to \
             hold the witness",
            most[0], most[1]
        ),
    })
}

/// Makes a figure of the bracket as a band over each axis; of a sample, as scattered ends over each
/// key that it draws.
fn suggestions(_: &KindTable, groups: &[Group], _: &[Job]) -> Vec<Figure> {
    let ends = ["mu_low", "mu_high"].map(str::to_owned);
    if groups.iter().any(|group| group.design().is_some()) {
        let of_key = |over: Figure| Figure { y: ends.to_vec(), ..over };
        return Figure::over_drawn(groups).into_iter().map(of_key).collect();
    }
    let band = Some(ends);
    let of_axis = |over: Figure| Figure { band: band.clone(), ..over };
    Figure::over_axes(groups).into_iter().map(of_axis).collect()
}

/// Reads a value from the result of a bracketing.
macro_rules! bracketed {
    (|$found:ident| $value:expr) => {
        ColumnSource::Record(|record| record.bracketed().map_or(Value::Missing, |$found| $value))
    };
}

/// The columns of brackets of uniqueness sets.
pub(crate) const BRACKET: &[Column] = result_columns! {
    Observable "mu_low" ("lower end of μ*") Pure
        "below this, every load has one solution at most: lower end of the bracket of μ*"
        bracketed!(|found| ends(found, |[low, _]| low));
    Observable "mu_high" ("upper end of μ*") Pure
        "from this on, the condition for uniqueness fails: upper end of the bracket of μ*"
        bracketed!(|found| ends(found, |[_, high]| high));
    Observable "bracket_width" Pure "length of the bracket over its upper end"
        bracketed!(|found| ends(found, |[low, high]| (high - low) / high));
    Observable "unbounded" Text "yes, if there is one solution at most whatever the friction"
        bracketed!(|found| match &found.bracket {
        Some(Bracket::Unbounded) => Value::Text("yes".to_owned()),
        Some(_) => Value::Text("no".to_owned()),
        None => Value::Missing,
    });
    Observable "critical_case" Text
        "case of each element of a strip at which uniqueness ends: o open, h open and held \
         sideways, s stick, f and b slip forward and backward"
        bracketed!(|found| match &found.bracket {
        Some(Bracket::Strip { lower, .. }) => Value::Text(letters(&lower.critical)),
        _ => Value::Missing,
    });
    Observable "excluded_mu" Pure
        "friction for which a part of the fields is excluded, but for what is left open; of the \
         jobs of `[branch]`"
        ColumnSource::Branch(|branch, _| Value::Number(branch.mu));
    Observable "excluded_case" Text
        "case of each element in that part: u undecided, o open, c closed"
        ColumnSource::Branch(|branch, _| Value::Text(branch::letters(&branch.states)));
    Observable "excluded_forms" Pure "number of forms that cut that part out of its case"
        ColumnSource::Branch(|branch, _| Value::Integer(branch.forms.len() as u64));
    Observable "excluded_cones" Pure "cones of that part that its job excluded"
        ColumnSource::Branch(|_, found| {
            count(found, |node| matches!(node, ConeNode::Excluded(_)))
        });
    Observable "open_cones" Pure "cones of that part that its job left to others"
        ColumnSource::Branch(|_, found| count(found, |node| *node == ConeNode::Open));
    Certificate "witness_residual" Pure "|B(I - EA)x - x| / |x| of the witness above"
        bracketed!(|found| {
            found.shown.map_or(Value::Missing, |shown| Value::Number(shown.residual))
        });
    Certificate "singular_value" Pure
        "smallest singular value of B(I - EA) - I over its norm, for few elements"
        bracketed!(|found| {
            found
                .shown
                .and_then(|shown| Some(shown.singular_value? / shown.norm))
                .map_or(Value::Missing, Value::Number)
        });
};

/// Counts nodes of the cones of a branch.
fn count(found: &Branched, is_counted: impl Fn(&ConeNode) -> bool) -> Value {
    let nodes = found.cases.iter().flat_map(|case| &case.nodes);
    Value::Integer(nodes.filter(|node| is_counted(node)).count() as u64)
}

/// Returns a figure of both ends of a bracket.
fn ends(found: &Bracketed, read: fn([f64; 2]) -> f64) -> Value {
    let ends = found.bracket.as_ref().and_then(Bracket::ends);
    ends.map_or(Value::Missing, |ends| Value::Number(read(ends)))
}
