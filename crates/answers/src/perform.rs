//! What is done with a job.

use std::time::Instant;

use contact::model::{Fields, SceneError, Status};
use contact::punch::Surfaces;
use contact::uniqueness::lower::VerifyError;
use contact::uniqueness::witness::Shown;
use contact::uniqueness::{Bracket, BracketError, Question, System, WitnessSearch, lower};
use contact::{Forecast, Operators, multiplicity, uniqueness};
use study::record::Bracketed;
use study::{Case, Ending, Job};

/// What a job will take.
pub fn forecast(job: &Job, surfaces: &Surfaces) -> Result<Forecast, SceneError> {
    match job {
        Job::Solve(Case { scene, numerics }) => contact::forecast(scene, numerics, surfaces),
        Job::Cost { case: Case { scene, numerics }, repeat, .. } => {
            let once = contact::forecast(scene, numerics, surfaces)?;
            Ok(Forecast { seconds: once.seconds * f64::from(*repeat), ..once })
        }
        Job::Uniqueness { question, search } => contact::forecast_bracket(question, search),
        Job::Multiplicity { case: Case { scene, numerics }, search } => {
            contact::forecast_search(scene, numerics, surfaces, search)
        }
    }
}

/// What came of a job.
pub struct Done {
    /// How it ended.
    pub ending: Ending,
    /// If it has some of its own.
    pub fields: Option<Fields>,
    /// How long each time took, if that is asked \[s\].
    pub times: Vec<f64>,
}

/// Does a job.
pub fn perform(
    job: &Job,
    surfaces: &Surfaces,
    operators: &mut Operators,
) -> Result<Done, SceneError> {
    let mut times = Vec::new();
    let (ending, fields) = match job {
        Job::Solve(Case { scene, numerics }) => {
            let (outcome, fields) = contact::solve(scene, numerics, surfaces, operators)?;
            (Ending::Finished(outcome), Some(fields))
        }
        Job::Cost { case: Case { scene, numerics }, repeat, threads } => {
            // from the scene to the result: nothing is kept from one time to the next
            let pool = rayon::ThreadPoolBuilder::new().num_threads(*threads as usize).build();
            let pool = pool.map_err(|error| SceneError {
                key: "cost.threads".to_owned(),
                value: threads.to_string(),
                expected: format!("must be so many threads as can be started: {error}"),
            })?;
            let mut once = || {
                let start = Instant::now();
                let solved = pool.install(|| {
                    contact::solve(scene, numerics, surfaces, &mut Operators::default())
                });
                times.push(start.elapsed().as_secs_f64());
                solved
            };
            for _ in 1..*repeat {
                once()?;
            }
            let (outcome, fields) = once()?;
            (Ending::Finished(outcome), Some(fields))
        }
        Job::Uniqueness { question, search } => {
            (Ending::Bracketed(Box::new(bracketed(question, search)?)), None)
        }
        Job::Multiplicity { case: Case { scene, numerics }, search } => (
            Ending::Searched(multiplicity::search(scene, numerics, surfaces, operators, search)?),
            None,
        ),
    };
    Ok(Done { ending, fields, times })
}

/// Brackets μ* and verifies both sides.
fn bracketed(question: &Question, search: &WitnessSearch) -> Result<Bracketed, SceneError> {
    let failed = |reason: String| Bracketed {
        status: Status::Failed { reason },
        bracket: None,
        shown: None,
    };
    let bracket = match uniqueness::bracket(question, search) {
        Ok(bracket) => bracket,
        Err(BracketError::Scene(error)) => return Err(error),
        Err(error) => return Ok(failed(error.to_string())),
    };
    let verified = verify(question, &bracket)?;
    let (status, shown) = match verified {
        Ok(shown) => (Status::Certified, shown),
        Err(Unshown::TooLarge(reason) | Unshown::Wrong(reason)) => {
            (Status::Failed { reason }, None)
        }
    };
    Ok(Bracketed { status, bracket: Some(bracket), shown })
}

/// Why a bracket is not shown to hold, in words.
pub enum Unshown {
    /// It takes too large a matrix to check: it may hold.
    TooLarge(String),
    /// It carries what does not show it.
    Wrong(String),
}

/// Shows that a bracket holds, from what it carries and the question alone; else says what is not
/// shown.
pub fn verify(
    question: &Question,
    bracket: &Bracket,
) -> Result<Result<Option<Shown>, Unshown>, SceneError> {
    let system = System::new(question)?;
    let wrong = |reason: String| Err(Unshown::Wrong(reason));
    Ok(match bracket {
        Bracket::Unbounded if system.is_coupled() => {
            wrong("pressures move the surface sideways, so that μ* is finite".to_owned())
        }
        Bracket::Unbounded => Ok(None),
        Bracket::Bounded { lower, upper } => {
            match (lower::verify(&system, lower, lower::FACTORED_ROWS), upper.verify(&system)) {
                (_, Err(error)) => {
                    wrong(format!("the upper end {} is not shown: {error}", upper.mu))
                }
                (Err(error), _) => {
                    let reason = format!("the lower end {} is not shown: {error}", lower.mu);
                    Err(if matches!(error, VerifyError::TooLarge { .. }) {
                        Unshown::TooLarge(reason)
                    } else {
                        Unshown::Wrong(reason)
                    })
                }
                (Ok(()), Ok(_)) if lower.mu >= upper.mu => wrong(format!(
                    "the lower end {} is not below the upper end {}",
                    lower.mu, upper.mu
                )),
                (Ok(()), Ok(shown)) => Ok(Some(shown)),
            }
        }
    })
}
