//! What travels between coordinator and worker, and what a worker does with it.

use std::time::Instant;

use anyhow::{Context, Result};
use contact::multiplicity;
use contact::outcome::{Fields, Status};
use contact::punch::Surfaces;
use contact::scene::{SceneError, Shape};
use contact::uniqueness::lower::VerifyError;
use contact::uniqueness::witness::Shown;
use contact::uniqueness::{self, Bracket, BracketError, Effort, Question, System, lower};
use contact::{Forecast, Operators};
use runner::{WorkerArguments, work};
use serde::{Deserialize, Serialize};
use study::profile::{decode_profile, encode_profile};
use study::record::{Bracketed, encode_fields};
use study::surface::{decode_surface, encode_surface};
use study::{Case, Ending, Job};

use crate::output::Finish;

/// A job on its way to a worker: its canonical text and what it names.
#[derive(Serialize, Deserialize)]
struct Order {
    job: String,
    height_maps: Vec<(String, Vec<u8>)>,
    profiles: Vec<(String, Vec<u8>)>,
}

/// What a worker sends back.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Answer {
    /// What came of it, the bytes of the fields if it has some of its own, and how long each time
    /// took if that is asked.
    Ended { ending: Box<Ending>, fields: Option<Vec<u8>>, times: Vec<f64> },
    /// The scene cannot be bound to its grid.
    Refused(String),
}

/// Encodes a job for a worker.
pub(crate) fn order(job: &Job, canonical: String, surfaces: &Surfaces) -> Result<Vec<u8>> {
    let map = |name: &String| Some((name.clone(), encode_surface(surfaces.get(name)?)));
    let profile = |name: &String| Some((name.clone(), encode_profile(surfaces.profile(name)?)));
    let (height_maps, profiles) = match job.case().map(|case| &case.scene.punch.shape) {
        Some(Shape::HeightMap { surface, .. }) => (map(surface).into_iter().collect(), Vec::new()),
        Some(Shape::WheelOnRail(wheel)) => {
            (Vec::new(), [&wheel.wheel, &wheel.rail].into_iter().filter_map(profile).collect())
        }
        _ => (Vec::new(), Vec::new()),
    };
    encode(&Order { job: canonical, height_maps, profiles })
}

/// What a job will take.
pub(crate) fn forecast(job: &Job, surfaces: &Surfaces) -> Result<Forecast, SceneError> {
    match job {
        Job::Solve(Case { scene, numerics }) => contact::forecast(scene, numerics, surfaces),
        Job::Cost { case: Case { scene, numerics }, repeat, .. } => {
            let once = contact::forecast(scene, numerics, surfaces)?;
            Ok(Forecast { seconds: once.seconds * f64::from(*repeat), ..once })
        }
        Job::Uniqueness { question, effort } => contact::forecast_bracket(question, effort),
        Job::Multiplicity { case: Case { scene, numerics }, search } => {
            contact::forecast_search(scene, numerics, surfaces, search)
        }
    }
}

/// What came of a job.
pub(crate) struct Done {
    pub(crate) ending: Ending,
    /// If it has some of its own.
    pub(crate) fields: Option<Fields>,
    /// How long each time took, if that is asked \[s\].
    pub(crate) times: Vec<f64>,
}

/// Does a job.
pub(crate) fn perform(
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
        Job::Uniqueness { question, effort } => {
            (Ending::Bracketed(Box::new(bracketed(question, effort)?)), None)
        }
        Job::Multiplicity { case: Case { scene, numerics }, search } => (
            Ending::Searched(multiplicity::search(scene, numerics, surfaces, operators, search)?),
            None,
        ),
    };
    Ok(Done { ending, fields, times })
}

/// Brackets μ* and verifies both sides.
fn bracketed(question: &Question, effort: &Effort) -> Result<Bracketed, SceneError> {
    let failed = |reason: String| Bracketed {
        status: Status::Failed { reason },
        bracket: None,
        shown: None,
    };
    let bracket = match uniqueness::bracket(question, effort) {
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
pub(crate) enum Unshown {
    /// It takes too large a matrix to check: it may hold.
    TooLarge(String),
    /// It carries what does not show it.
    Wrong(String),
}

/// Shows that a bracket holds, from what it carries and the question alone; else says what is not
/// shown.
pub(crate) fn verify(
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

/// Decodes an [`order`].
pub(crate) fn ordered(payload: &[u8]) -> Result<(Job, Surfaces)> {
    let (order, _): (Order, usize) =
        bincode::serde::decode_from_slice(payload, bincode::config::standard())?;
    let job = Job::parse(&order.job)?;
    let mut surfaces = Surfaces::new();
    for (name, bytes) in order.height_maps {
        surfaces.insert(name, decode_surface(&bytes)?.into());
    }
    for (name, bytes) in order.profiles {
        surfaces.insert_profile(name, decode_profile(&bytes)?.into());
    }
    Ok((job, surfaces))
}

/// Decodes what a worker sent.
pub(crate) fn answer(bytes: &[u8]) -> Result<Answer> {
    let (answer, _) = bincode::serde::decode_from_slice(bytes, bincode::config::standard())
        .context("a worker's answer does not decode")?;
    Ok(answer)
}

fn encode(value: &impl Serialize) -> Result<Vec<u8>> {
    Ok(bincode::serde::encode_to_vec(value, bincode::config::standard())?)
}

/// Solves jobs, keeping operators between them.
#[derive(Default)]
struct Solver {
    operators: Operators,
}

impl Solver {
    fn run(&mut self, payload: &[u8]) -> Result<Answer> {
        let (job, surfaces) = ordered(payload)?;
        let Done { ending, fields, times } = perform(&job, &surfaces, &mut self.operators)?;
        Ok(Answer::Ended {
            ending: Box::new(ending),
            fields: fields.map(|fields| encode_fields(&fields)),
            times,
        })
    }
}

impl runner::Executor for Solver {
    fn run(&mut self, payload: &[u8]) -> Vec<u8> {
        let answer = Solver::run(self, payload)
            .unwrap_or_else(|error| Answer::Refused(format!("{error:#}")));
        encode(&answer).expect("an answer is plain data")
    }
}

/// Makes this thread one of those that share the work, `count` of them or, for 0, as many as the
/// machine or RAYON_NUM_THREADS has. It works itself: to hand over to another and wait takes as
/// long as a small solve's smallest parts.
pub(crate) fn share_among(count: usize) -> Result<()> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .use_current_thread()
        .build_global()
        .context("cannot start threads")
}

/// The hidden command `worker`.
pub(crate) fn run(threads: usize, argument: &str) -> Result<Finish> {
    share_among(threads)?;
    work(&WorkerArguments::parse(argument)?, Solver::default)?;
    Ok(Finish::AllDone)
}
