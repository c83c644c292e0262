//! `solve`: one scene, in this process; nothing is stored.

use std::collections::hash_map::Entry;
use std::ffi::OsStr;
use std::time::Instant;

use answers::choice::{Discovery, choose};
use answers::{Performed, RecordMap, forecast, perform, warnings};
use anyhow::{Context, Result, bail};
use contact::Operators;
use contact::model::Fields;
use contact::punch::Surfaces;
use indicatif::BinaryBytes;
use study::edit::with_settings;
use study::job::PHYSICS_VERSION;
use study::{Adaptive, Job, Kind, Provenance, Record, Study};

use crate::cli::SolveArgs;
use crate::one_result::UsedFiles;
use crate::output::{Finish, layout};
use crate::study_file::{edit_study, parse_study, read_study, read_text};
use crate::threads::share_among;
use crate::{fields, one_result, output};

/// Solves the only scene of a study file and shows the result.
pub(crate) fn solve(args: &SolveArgs) -> Result<Finish> {
    share_among(0)?;
    let study = single_scene(args)?;
    if let Some(name) = &args.field {
        fields::check_field(name, args.output.as_deref())?;
    }
    if study.kind() != Kind::Multiplicity {
        fields::only_of_a_search(args.solution)?;
    }
    let mut operators = Operators::default();
    let solution = match study.adaptive() {
        Some(Adaptive::Accuracy(_)) => solve_accurately(&study, &mut operators)?,
        Some(Adaptive::Refine { .. } | Adaptive::Bisect { .. }) | None => {
            let job = study.point(0).context("the study's only point cannot be made")?.job;
            solve_job(&job, study.surfaces(), &mut operators)?
        }
    };
    let is_missed = matches!(solution.discovery, Some(Discovery::Beyond { .. }));
    let is_good = solution.record.is_certified() && !is_missed;
    show(args, &study, &solution)?;
    say_doubts(args, &study, &solution);
    // The process ends, and with it its memory: to hand back a gigabyte first would take a
    // hundredth of the time to solve for it.
    std::mem::forget(operators);
    Ok(if is_good { Finish::AllDone } else { Finish::SomeFailed })
}

/// The result of solving.
struct SolvedScene {
    record: Record,
    fields: Option<Fields>,
    /// The state of the choice of a mesh, if the study leaves it to an accuracy.
    discovery: Option<Discovery>,
}

/// Reads the study with its keys set, and refuses one of several points.
fn single_scene(args: &SolveArgs) -> Result<Study> {
    let study = if args.set.is_empty() {
        read_study(&args.scene)?
    } else {
        let text = read_text(&args.scene)?;
        let edited = edit_study(with_settings, &text, &args.scene, &args.set)?;
        parse_study(&edited, &args.scene)?
    };
    if study.len() != 1 {
        bail!(
            "{} describes {} points; fix its axes with --set KEY=VALUE ({}), or run them all with \
             `{}`",
            args.scene.display(),
            study.len(),
            study.axes().map(|axis| axis.path()).collect::<Vec<_>>().join(", "),
            run_command(args)
        );
    }
    Ok(study)
}

/// Returns the command that runs the study instead.
fn run_command(args: &SolveArgs) -> String {
    wording::command([OsStr::new("run"), &wording::file_argument(&args.scene)])
}

/// Refuses a job that needs more memory than there is, by prediction: the system would kill the
/// process.
fn require_memory(job: &Job, surfaces: &Surfaces) -> Result<()> {
    let needed = forecast(job, surfaces)?.memory;
    let limits = [runner::memory_within_limits(), runner::available_memory()];
    match limits.into_iter().flatten().min().filter(|&limit| needed > limit) {
        Some(limit) => bail!(
            "the scene needs {} of memory by prediction, and this process may use {}: choose a \
             coarser mesh, or a machine or container with more memory (or `ulimit -v`)",
            BinaryBytes(needed),
            BinaryBytes(limit)
        ),
        None => Ok(()),
    }
}

fn solve_job(job: &Job, surfaces: &Surfaces, operators: &mut Operators) -> Result<SolvedScene> {
    require_memory(job, surfaces)?;
    let start = Instant::now();
    let Performed { ending, fields, times } = perform(job, surfaces, operators)?;
    let provenance =
        Provenance::timed(env!("CARGO_PKG_VERSION"), start.elapsed().as_secs_f64(), times);
    let (physics, job) = (PHYSICS_VERSION, job.canonical());
    // Nothing is stored, so the record refers to no fields.
    let record = Record { physics, job, ending, fields: None, provenance };
    Ok(SolvedScene { record, fields, discovery: None })
}

/// Solves the only scene of a study on one mesh after the other until it is accurate enough, or no
/// mesh is left.
fn solve_accurately(study: &Study, operators: &mut Operators) -> Result<SolvedScene> {
    let (mut records, mut last) = (RecordMap::new(), None);
    loop {
        let choice = choose(study, &records)?;
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
        return Ok(SolvedScene { record, fields, discovery });
    }
}

/// Shows the result in the form that the arguments ask for.
fn show(args: &SolveArgs, study: &Study, solution: &SolvedScene) -> Result<()> {
    let SolvedScene { record, fields, .. } = solution;
    let files = UsedFiles::of(study, &record.parse_job()?);
    if let Some(name) = &args.field {
        let of_search = record
            .multiplicity()
            .map(|found| fields::solution_fields(found, args.solution))
            .transpose()?;
        let fields = of_search.as_ref().or(fields.as_ref()).context("it has no fields")?;
        fields::show_field(fields, name, args.output.as_deref())?;
    } else if args.json {
        output::print_json(&one_result::json(record, fields.as_ref(), &files)?)?;
    } else {
        let mut text = one_result::words(record, fields.as_ref(), &files)?;
        if record.outcome().is_some_and(|outcome| outcome.steps.len() > 1) {
            text += &format!("path\n{}", one_result::path(record)?.terminal(&layout()));
        }
        output::print(&text)?;
    }
    Ok(())
}

/// Says on standard error what is to be doubted in the result.
fn say_doubts(
    args: &SolveArgs,
    study: &Study,
    SolvedScene { record, discovery, .. }: &SolvedScene,
) {
    for warning in warnings(record) {
        output::say(&format!("warning: {}", warning.words));
    }
    if let (Some(Discovery::Beyond { error, reason, .. }), true) =
        (discovery, record.is_certified())
    {
        let reached =
            error.map_or(String::new(), |error| format!("; the estimated error is {error:.1e}"));
        output::say(&format!("the accuracy asked for was missed: {reason}{reached}"));
    }
    if !record.is_certified() {
        let last = match record.outcome() {
            Some(_) => "; the figures are those of the last iterate",
            None => "",
        };
        let reason = record.ending.reason().map(str::to_owned);
        let reason = reason.unwrap_or_else(|| record.standing().to_string());
        output::say(&format!("not certified: {reason}{last}"));
    }
    if let Some(Adaptive::Refine { .. }) = study.adaptive() {
        let run = run_command(args);
        output::say(&format!("solved on the study's first mesh; `{run}` refines it"));
    }
}
