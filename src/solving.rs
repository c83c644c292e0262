//! The way from the only scene of a study to its result, in this process.

use std::collections::hash_map::Entry;
use std::time::Instant;

use answers::choice::{Discovery, choose};
use answers::{Performed, RecordMap, forecast, perform, warnings};
use anyhow::{Context, Result, bail};
use contact::model::Fields;
use contact::punch::Surfaces;
use contact::{Cancellation, Operators};
use indicatif::BinaryBytes;
use study::account::HashedFile;
use study::job::PHYSICS_VERSION;
use study::{Adaptive, Job, Provenance, Record, RunAccount, Study};

use crate::account::this_run;

/// The result of solving.
pub(crate) struct SolvedScene {
    pub(crate) record: Record,
    pub(crate) fields: Option<Fields>,
    /// The account of this process.
    pub(crate) account: RunAccount,
    /// The state of the choice of a mesh, if the study leaves it to an accuracy.
    pub(crate) discovery: Option<Discovery>,
}

impl SolvedScene {
    /// Returns true if the accuracy that was asked for was missed.
    pub(crate) fn is_missed(&self) -> bool {
        matches!(self.discovery, Some(Discovery::Beyond { .. }))
    }

    /// Returns what is to be doubted in the result, in words.
    pub(crate) fn doubts(&self) -> Vec<String> {
        let SolvedScene { record, discovery, .. } = self;
        let mut doubts: Vec<String> =
            warnings(record).iter().map(|doubt| format!("warning: {}", doubt.words)).collect();
        if let (Some(Discovery::Beyond { error, reason, .. }), true) =
            (discovery, record.is_certified())
        {
            let reached = error
                .map_or(String::new(), |error| format!("; the estimated error is {error:.1e}"));
            doubts.push(format!("the accuracy asked for was missed: {reason}{reached}"));
        }
        if !record.is_certified() {
            let last = match record.outcome() {
                Some(_) => "; the figures are those of the last iterate",
                None => "",
            };
            let reason = record.ending.reason().map(str::to_owned);
            let reason = reason.unwrap_or_else(|| record.standing().to_string());
            doubts.push(format!("not certified: {reason}{last}"));
        }
        doubts
    }
}

/// Solves the only scene of a study, read from a file or from nowhere; one that refines its mesh,
/// on the first.
pub(crate) fn solve_scene(
    study: &Study,
    file: Option<HashedFile>,
    operators: &mut Operators,
) -> Result<SolvedScene> {
    let account = this_run(study, file);
    let SolvedJob { record, fields, discovery } = match study.adaptive() {
        Some(Adaptive::Accuracy(_)) => solve_accurately(study, operators)?,
        Some(
            Adaptive::Refine { .. }
            | Adaptive::Bisect { .. }
            | Adaptive::Find(_)
            | Adaptive::Fill(_)
            | Adaptive::Branch { .. },
        )
        | None => {
            let job = study.point(0).context("the study's only point cannot be made")?.job;
            solve_job(&job, study.surfaces(), operators)?
        }
    };
    Ok(SolvedScene { record, fields, account, discovery })
}

/// The result of a job.
struct SolvedJob {
    record: Record,
    fields: Option<Fields>,
    /// The state of the choice of a mesh, if the study leaves it to an accuracy.
    discovery: Option<Discovery>,
}

/// Refuses to go on with what nobody wants any more.
pub(crate) fn require_wanted(cancellation: &Cancellation) -> Result<()> {
    if cancellation.is_requested() {
        bail!("the solve was given up");
    }
    Ok(())
}

/// Refuses a job that needs more memory than there is, by prediction: the system would kill the
/// process.
pub(crate) fn require_memory(job: &Job, surfaces: &Surfaces) -> Result<()> {
    let needed = forecast(job, surfaces)?.memory;
    match usable_memory().filter(|&limit| needed > limit) {
        Some(limit) => bail!(
            "the scene needs {} of memory by prediction, and this process may use {}: choose a \
             coarser mesh, or a machine or container with more memory (or `ulimit -v`)",
            BinaryBytes(needed),
            BinaryBytes(limit)
        ),
        None => Ok(()),
    }
}

/// Returns the memory that this process may use, as far as that is known \[bytes\].
pub(crate) fn usable_memory() -> Option<u64> {
    let limits = [runner::memory_within_limits(), runner::available_memory()];
    limits.into_iter().flatten().min()
}

fn solve_job(job: &Job, surfaces: &Surfaces, operators: &mut Operators) -> Result<SolvedJob> {
    require_memory(job, surfaces)?;
    let start = Instant::now();
    let Performed { ending, fields, times } = perform(job, surfaces, operators)?;
    let provenance =
        Provenance::timed(env!("CARGO_PKG_VERSION"), start.elapsed().as_secs_f64(), times);
    let (physics, job) = (PHYSICS_VERSION, job.canonical());
    // Nothing is stored, so the record refers to no fields.
    let record = Record { physics, job, ending, fields: None, provenance };
    Ok(SolvedJob { record, fields, discovery: None })
}

/// Solves the only scene of a study on one mesh after the other until it is accurate enough, or no
/// mesh is left.
fn solve_accurately(study: &Study, operators: &mut Operators) -> Result<SolvedJob> {
    let (mut records, mut last) = (RecordMap::new(), None);
    loop {
        let choice = choose(study, &records)?;
        require_wanted(operators.cancellation())?;
        let point =
            choice.points.into_iter().next().context("the study's only point cannot be made")?;
        let discovery = choice.findings.first().map(|finding| finding.discovery);
        if let Entry::Vacant(unknown) = records.entry(point.key) {
            let solution = solve_job(&point.job, study.surfaces(), operators)?;
            unknown.insert(solution.record);
            last = solution.fields.map(|fields| (point.key, fields));
            continue;
        }
        // The fields of the last mesh are at hand; those of a better one before it are not.
        let fields = match last {
            Some((key, fields)) if key == point.key => Some(fields),
            _ => solve_job(&point.job, study.surfaces(), operators)?.fields,
        };
        let record = records.remove(&point.key).context("a result was lost")?;
        return Ok(SolvedJob { record, fields, discovery });
    }
}
