//! `solve`: one scene, in this process, nothing stored.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::time::Instant;

use answers::choice::{Found, choose};
use answers::perform::{Done, perform};
use answers::results::WARNINGS;
use anyhow::{Context, Result, bail};
use contact::Operators;
use contact::model::Fields;
use contact::punch::Surfaces;
use study::edit::with_settings;
use study::job::PHYSICS_VERSION;
use study::{Adaptive, Job, Kind, Provenance, Record, Study};

use crate::cli::SolveArgs;
use crate::output::{Finish, layout};
use crate::study_file::{edit_study, parse_study, read_study};
use crate::threads::share_among;
use crate::{fields, one_result, output};

pub(crate) fn solve(args: &SolveArgs) -> Result<Finish> {
    share_among(0)?;
    let study = if args.set.is_empty() {
        read_study(&args.scene)?
    } else {
        let text = std::fs::read_to_string(&args.scene)
            .with_context(|| format!("cannot read {}", args.scene.display()))?;
        let edited = edit_study(with_settings, &text, &args.scene, &args.set)?;
        parse_study(&edited, &args.scene)?
    };
    if study.len() != 1 {
        bail!(
            "{} describes {} points; fix its axes with --set KEY=VALUE ({}), or run them all with `tribosweep run`",
            args.scene.display(),
            study.len(),
            study.axes().map(|axis| axis.path()).collect::<Vec<_>>().join(", ")
        );
    }
    if let Some(name) = &args.field {
        fields::check_field(name, args.output.as_deref())?;
    }
    if study.kind() != Kind::Multiplicity {
        fields::only_of_a_search(args.solution)?;
    }
    let mut operators = Operators::default();
    let (record, fields, found) = match study.adaptive() {
        Some(Adaptive::Accuracy(_)) => accurate(&study, &mut operators)?,
        _ => {
            let job = study.point(0).context("the study's only point cannot be made")?.job;
            let (record, fields) = solved(&job, study.surfaces(), &mut operators)?;
            (record, fields, None)
        }
    };
    let missed = matches!(found, Some(Found::Beyond { .. }));
    let finish =
        if record.is_certified() && !missed { Finish::AllDone } else { Finish::SomeFailed };
    match &args.field {
        Some(name) => {
            let fields = match record.multiplicity() {
                Some(found) => Some(fields::solution_fields(found, args.solution)?),
                None => fields,
            };
            fields::show_field(&fields.context("it has no fields")?, name, args.output.as_deref())?;
        }
        None if args.json => {
            output::print_json(&one_result::json(&record, fields.as_ref(), study.surfaces())?)?;
        }
        None => {
            let mut text = one_result::words(&record, fields.as_ref(), study.surfaces())?;
            if record.outcome().is_some_and(|outcome| outcome.steps.len() > 1) {
                text += &format!("path\n{}", one_result::path(&record)?.terminal(&layout()));
            }
            output::print(&text)?;
        }
    }
    for warning in WARNINGS.iter().filter(|warning| warning.concerns(&record)) {
        output::say(&format!("warning: elements {}", warning.words));
    }
    if let (Some(Found::Beyond { error, why, .. }), true) = (found, record.is_certified()) {
        let reached =
            error.map_or(String::new(), |error| format!("; the estimated error is {error:.1e}"));
        output::say(&format!("the accuracy asked for was missed: {why}{reached}"));
    }
    if !record.is_certified() {
        let last = if record.outcome().is_some() {
            "; the figures are those of the last iterate"
        } else {
            ""
        };
        output::say(&format!(
            "not certified: {}{last}",
            record.ending.reason().map_or_else(|| record.standing().to_string(), str::to_owned)
        ));
    }
    if let Some(Adaptive::Refine { .. }) = study.adaptive() {
        output::say("solved on the study's first mesh; `tribosweep run` refines it");
    }
    // the process ends, and with it its memory; to hand back a gigabyte first takes a hundredth of
    // the time to solve for it
    std::mem::forget(operators);
    Ok(finish)
}

/// What a job leaves, and its fields.
fn solved(
    job: &Job,
    surfaces: &Surfaces,
    operators: &mut Operators,
) -> Result<(Record, Option<Fields>)> {
    let start = Instant::now();
    let Done { ending, fields, times } = perform(job, surfaces, operators)?;
    let provenance =
        Provenance::timed(env!("CARGO_PKG_VERSION"), start.elapsed().as_secs_f64(), times);
    // nothing is stored, so nothing is kept
    Ok((
        Record { physics: PHYSICS_VERSION, job: job.canonical(), ending, fields: None, provenance },
        fields,
    ))
}

/// Solves the only scene of a study on one mesh after the other until it is accurate enough, or no
/// mesh is left.
fn accurate(
    study: &Study,
    operators: &mut Operators,
) -> Result<(Record, Option<Fields>, Option<Found>)> {
    let (mut records, mut last) = (HashMap::new(), None);
    loop {
        let chosen = choose(study, &records)?;
        let point =
            chosen.points.into_iter().next().context("the study's only point cannot be made")?;
        let found = chosen.findings.first().map(|finding| finding.found);
        if let Entry::Vacant(unknown) = records.entry(point.key) {
            let (record, fields) = solved(&point.job, study.surfaces(), operators)?;
            unknown.insert(record);
            last = fields.map(|fields| (point.key, fields));
            continue;
        }
        // the fields of the finest are at hand, those of a better one before it are not
        let fields = match last {
            Some((key, fields)) if key == point.key => Some(fields),
            _ => solved(&point.job, study.surfaces(), operators)?.1,
        };
        let record = records.remove(&point.key).context("a result was lost")?;
        return Ok((record, fields, found));
    }
}
