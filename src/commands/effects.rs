//! `effects`: what leaving effects out saves, measured.

use std::io::Write;
use std::process::{Command, Stdio};

use answers::effects::Group;
use answers::rows::digits;
use anyhow::{Context, Result, bail};
use contact::forecast;
use contact::model::{Effect, Fields, Numerics, Status};
use contact::problem::Effects;
use contact::punch::Surfaces;
use report::{Cell, DataTable, TableColumn};
use serde::Serialize;
use study::provenance::median;
use study::record_format::decode_fields;
use study::{Adaptive, Case, Job};

use crate::cli::EffectsArgs;
use crate::job_list::Jobs;
use crate::output;
use crate::output::{Finish, layout};
use crate::study_file::read_study;
use crate::wire::{Measurement, order};

/// A job as it was solved with some effects asked for.
#[derive(Serialize)]
struct Run {
    /// Effects that were asked for.
    simulate: Vec<Effect>,
    unknowns: usize,
    /// Median time from the scene to the result \[s\].
    seconds: f64,
    /// Memory that solving took at most \[bytes\].
    bytes: Option<u64>,
    iterations: u64,
    /// Largest difference of the tractions from those of the first run, over its largest pressure.
    difference: Option<f64>,
    status: &'static str,
}

pub(crate) fn effects(args: &EffectsArgs) -> Result<Finish> {
    let study = read_study(&args.study)?;
    if let Some(Adaptive::Accuracy(_)) = study.adaptive() {
        bail!(
            "{}: its meshes follow from its results; give it a mesh in place of the accuracy",
            study.path()
        );
    }
    let jobs = Jobs::of(&study)?;
    let overview = jobs.effects(&study)?;
    if overview.groups.is_empty() {
        bail!(
            "{}: a study of kind \"{}\" simulates every effect; there is nothing to leave out",
            study.path(),
            study.kind().name()
        );
    }
    let mut listed = Vec::new();
    let mut text = String::new();
    for group in &overview.groups {
        let Some(case) = jobs.points[group.first].job.case() else { continue };
        let runs = runs(case, study.surfaces(), args.repeat)?;
        text += &format!("{}\n{}\n", title(study.name(), group), table(&runs)?.terminal(&layout()));
        listed.push(
            serde_json::json!({ "which": group.which, "jobs": group.jobs, "key": jobs.points[group.first].key.to_string(), "runs": runs }),
        );
    }
    let certified = listed
        .iter()
        .flat_map(|group| group["runs"].as_array())
        .flatten()
        .all(|run| run["status"] == "certified");
    if args.json {
        output::print_json(
            &serde_json::json!({ "study": study.name(), "repeat": args.repeat, "groups": listed }),
        )?;
    } else {
        output::print(text.trim_end_matches('\n'))?;
        output::print("\n")?;
    }
    Ok(if certified { Finish::AllDone } else { Finish::SomeFailed })
}

fn title(study: &str, group: &Group) -> String {
    let which = if group.which.is_empty() { String::new() } else { format!(", {}", group.which) };
    if group.jobs == 1 {
        format!("{study}{which}")
    } else {
        format!("{study}{which}: the first of {} jobs", group.jobs)
    }
}

/// Solves a job with every effect left out that can be, then with each of those, then with
/// everything.
fn runs(job: &Case, surfaces: &Surfaces, repeat: u32) -> Result<Vec<Run>> {
    let with = |simulate: &[Effect]| Case {
        numerics: Numerics { simulate: simulate.to_vec(), ..job.numerics.clone() },
        ..job.clone()
    };
    let bare = with(&[]);
    let elements = forecast(&bare.scene, &bare.numerics, surfaces)?.elements;
    let effects = Effects::of(&bare.scene, &bare.numerics, elements, surfaces)?;
    let off: Vec<Effect> =
        Effect::OPTIONAL.into_iter().filter(|effect| !effects.has(*effect)).collect();
    let mut asked = vec![Vec::new()];
    // without tangential tractions, what they would do is nothing
    let of_friction = [Effect::Coupling, Effect::TractionX, Effect::TractionY];
    let alone = |effect: &&Effect| effects.has(Effect::Friction) || !of_friction.contains(effect);
    asked.extend(off.iter().filter(alone).map(|effect| vec![*effect]));
    if off.len() > 1 {
        asked.push(off);
    }
    let mut first: Option<Fields> = None;
    let mut runs = Vec::new();
    for simulate in asked {
        let job = with(&simulate);
        let whole = Job::Solve(job.clone());
        let measurement = in_a_process(&order(&whole, whole.canonical(), surfaces)?, repeat)?;
        let fields = decode_fields(&measurement.fields)?;
        runs.push(Run {
            simulate,
            unknowns: forecast(&job.scene, &job.numerics, surfaces)?.unknowns,
            seconds: median(measurement.seconds),
            bytes: measurement.bytes,
            iterations: measurement.outcome.work().iterations,
            difference: first.as_ref().and_then(|first| first.difference(&fields)),
            status: match measurement.outcome.status {
                Status::Certified => "certified",
                Status::Failed { .. } => "failed",
            },
        });
        first.get_or_insert(fields);
    }
    Ok(runs)
}

fn table(runs: &[Run]) -> Result<DataTable> {
    let heads = [
        ("simulated too", ""),
        ("unknowns", ""),
        ("seconds", "s"),
        ("times", ""),
        ("memory", "MiB"),
        ("iterations", ""),
    ];
    let heads = heads.into_iter().chain([("difference", "1"), ("status", "")]);
    let fastest = runs.first().map_or(f64::NAN, |run| run.seconds);
    let number = |x: Option<f64>| x.map_or(Cell::Missing, Cell::Number);
    let integer = |n: u64| i64::try_from(n).map_or(Cell::Missing, Cell::Integer);
    // so few digits are not noise
    let rounded = |x: f64| digits(x, 2);
    let rows = runs.iter().map(|run| {
        let asked = match run.simulate[..] {
            [] => "nothing".to_owned(),
            [effect] => effect.name().to_owned(),
            _ => "everything".to_owned(),
        };
        vec![
            Cell::Text(asked),
            integer(run.unknowns as u64),
            Cell::Number(rounded(run.seconds)),
            Cell::Number(rounded(run.seconds / fastest)),
            number(run.bytes.map(|bytes| rounded(bytes as f64 / f64::from(1 << 20)))),
            integer(run.iterations),
            number(run.difference.map(rounded)),
            run.status.into(),
        ]
    });
    Ok(DataTable::new(
        heads.map(|(name, unit)| TableColumn::new(name, unit)).collect(),
        rows.collect(),
    )?)
}

/// Has a job solved `repeat` times by a process of its own, whose memory is that of the job.
fn in_a_process(order: &[u8], repeat: u32) -> Result<Measurement> {
    let program = std::env::current_exe().context("cannot find this program's own file")?;
    let mut child = Command::new(program)
        .args(["measured", &repeat.to_string()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start a process to solve in")?;
    // it reads everything before it answers, so that neither waits for the other
    let sent =
        child.stdin.take().context("the solving process has no standard input")?.write_all(order);
    let output = child.wait_with_output()?;
    if !output.status.success() {
        bail!("the process that solves ended with {}", output.status);
    }
    sent.context("cannot hand over the job")?;
    let (measurement, _) =
        bincode::serde::decode_from_slice(&output.stdout, bincode::config::standard())?;
    Ok(measurement)
}
