//! Studies that bracket the end μ* of the uniqueness set of every point.

use contact::model::{SceneError, Status};
use contact::uniqueness::branch::{self, Branch};
use contact::uniqueness::lower::{self, VerifyError};
use contact::uniqueness::witness::Shown;
use contact::uniqueness::{self, Bracket, BracketError, Question, System, WitnessSearch};
use contact::uniqueness::{cases, cones, strip};
use study::record::{Bracketed, Branched};
use study::{Ending, Job, Record};

use super::size::RecordSize;
use super::solve;
use super::spec::KindAnswers;
use crate::perform::{PerformResult, Performed};

/// The kind.
pub(super) const ANSWERS: KindAnswers = solve::ANSWERS;

/// Brackets μ* and verifies both ends.
pub(super) fn perform(question: &Question, search: &WitnessSearch) -> PerformResult {
    let bracketed = bracketed(question, search)?;
    Ok(Performed::ended(Ending::Bracketed(Box::new(bracketed))))
}

fn bracketed(question: &Question, search: &WitnessSearch) -> Result<Bracketed, SceneError> {
    let bracket = match uniqueness::bracket(question, search) {
        Ok(bracket) => bracket,
        Err(BracketError::Scene(error)) => return Err(error),
        Err(error) => {
            let status = Status::Failed { reason: error.to_string() };
            return Ok(Bracketed { status, bracket: None, shown: None });
        }
    };
    let (status, shown) = match verify(question, &bracket)? {
        Proof::Holds(shown) => (Status::Certified, shown),
        Proof::TooLarge(reason) | Proof::Wrong(reason) => (Status::Failed { reason }, None),
    };
    Ok(Bracketed { status, bracket: Some(bracket), shown })
}

/// Excludes as much of a branch as a job does, and verifies what it says.
pub(super) fn perform_branch(question: &Question, branch: &Branch) -> PerformResult {
    let cases = branch::exclude(question, branch)?;
    let (status, cases) = match branch::verify(&System::new(question)?, branch, &cases) {
        Ok(()) => (Status::Certified, cases),
        Err(error) => (Status::Failed { reason: error.to_string() }, Vec::new()),
    };
    Ok(Performed::ended(Ending::Branched(Box::new(Branched { status, cases }))))
}

/// The result of verifying a bracket; reasons are in words.
#[derive(Clone, Debug, PartialEq)]
pub enum Proof {
    /// The bracket holds; with what its witness shows, if it has one.
    Holds(Option<Shown>),
    /// The bracket takes too large a matrix to check: it may hold.
    TooLarge(String),
    /// The bracket carries something that does not show it.
    Wrong(String),
}

/// Proves anew what a record claims to have proved, from what it carries and its job alone; `None`
/// for a record that claims nothing of the kind.
pub fn proof(record: &Record) -> Option<Proof> {
    if let Some(found) = record.branched().filter(|_| record.is_certified()) {
        let Ok(Job::Branch { question, branch }) = record.parse_job() else {
            return Some(Proof::Wrong("it excludes nothing that was asked".to_owned()));
        };
        return Some(match System::new(&question) {
            Err(error) => Proof::Wrong(error.to_string()),
            Ok(system) => match branch::verify(&system, &branch, &found.cases) {
                Ok(()) => Proof::Holds(None),
                Err(error) => Proof::Wrong(error.to_string()),
            },
        });
    }
    let bracket = record.bracketed().filter(|_| record.is_certified())?.bracket.as_ref()?;
    let Ok(Job::Uniqueness { question, .. }) = record.parse_job() else {
        return Some(Proof::Wrong("it brackets nothing that was asked".to_owned()));
    };
    let proof = verify(&question, bracket);
    Some(proof.unwrap_or_else(|error| Proof::Wrong(error.to_string())))
}

/// Returns the question of a record and the ends of the bracket that it claims; `None` for a record
/// that claims none.
pub fn bracket_ends(record: &Record) -> Option<(Question, [f64; 2])> {
    let bracket = record.bracketed().filter(|_| record.is_certified())?.bracket.as_ref()?;
    let Ok(Job::Uniqueness { question, .. }) = record.parse_job() else { return None };
    Some((question, bracket.ends()?))
}

/// Verifies both ends of a bracket, from what it carries and the question alone.
fn verify(question: &Question, bracket: &Bracket) -> Result<Proof, SceneError> {
    let system = System::new(question)?;
    if question.plane != matches!(bracket, Bracket::Strip { .. })
        && !matches!(bracket, Bracket::Unbounded)
    {
        let reason = "the tractions are not those that were asked for, in a plane or in space";
        return Ok(Proof::Wrong(reason.to_owned()));
    }
    let (lower, upper) = match bracket {
        Bracket::Unbounded if system.is_coupled() => {
            let reason = "pressures move the surface sideways, so that μ* is finite";
            return Ok(Proof::Wrong(reason.to_owned()));
        }
        Bracket::Unbounded => return Ok(Proof::Holds(None)),
        Bracket::Bounded { lower, upper } => {
            let shown = lower::verify(&system, lower, lower::FACTORED_ROWS).map_err(|error| {
                let reason = not_shown(lower.mu, &error);
                match error {
                    VerifyError::TooLarge { .. } => Proof::TooLarge(reason),
                    _ => Proof::Wrong(reason),
                }
            });
            (LowerEnd { mu: lower.mu, shown }, upper)
        }
        Bracket::Cases { lower, upper } => {
            let shown = cases::verify(&system, lower)
                .map_err(|error| Proof::Wrong(not_shown(lower.mu, &error)));
            (LowerEnd { mu: lower.mu, shown }, upper)
        }
        Bracket::Cones { lower, upper } => {
            let shown = cones::verify(&system, lower)
                .map_err(|error| Proof::Wrong(not_shown(lower.mu, &error)));
            (LowerEnd { mu: lower.mu, shown }, upper)
        }
        Bracket::Strip { lower, upper } => {
            let shown = strip::verify(&system, lower, upper.mu)
                .map_err(|error| Proof::Wrong(not_shown(lower.mu, &error)));
            (LowerEnd { mu: lower.mu, shown }, upper)
        }
    };
    Ok(match (upper.verify(&system), lower.shown) {
        (Err(error), _) => {
            Proof::Wrong(format!("the upper end {} is not shown: {error}", upper.mu))
        }
        (_, Err(proof)) => proof,
        (Ok(_), Ok(())) if lower.mu >= upper.mu => Proof::Wrong(format!(
            "the lower end {} is not below the upper end {}",
            lower.mu, upper.mu
        )),
        (Ok(shown), Ok(())) => Proof::Holds(Some(shown)),
    })
}

/// The lower end of a bracket, with what came of its proof.
struct LowerEnd {
    mu: f64,
    shown: Result<(), Proof>,
}

/// Says that a lower end is not shown.
fn not_shown(mu: f64, error: &impl std::fmt::Display) -> String {
    format!("the lower end {mu} is not shown: {error}")
}

/// Returns a bracket that fails for the size of its witness.
pub(super) fn too_large(found: &Bracketed, size: RecordSize) -> Bracketed {
    let witness = found.bracket.as_ref().and_then(Bracket::witness);
    let elements = witness.map_or(0, |witness| witness.x.len() / 3);
    let content = format!("a bracket of μ* with its witness on {elements} elements");
    Bracketed { status: size.failure(&content, elements), bracket: None, shown: None }
}
