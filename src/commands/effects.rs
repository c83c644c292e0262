//! `effects`: measures the savings of leaving effects out.

use std::io::Write;
use std::process::{Command, Stdio};

use answers::effects::{EffectGroup, variants};
use answers::rows::digits;
use anyhow::{Context, Result, bail};
use contact::forecast;
use contact::model::{Effect, Fields, Numerics};
use contact::punch::Surfaces;
use report::{Cell, DataTable, TableColumn};
use serde::{Serialize, Serializer};
use study::provenance::median;
use study::record_format::decode_fields;
use study::{Adaptive, Case, Job, Standing};

use crate::cli::EffectsArgs;
use crate::execution::own_program;
use crate::job_list::JobList;
use crate::output::{self, Finish, layout};
use crate::study_file::read_study;
use crate::wire::{Measurement, decode_measurement, order};

/// A job as it was solved with some effects simulated that could be left out.
#[derive(Serialize)]
struct EffectRun {
    /// The effects that were asked for.
    simulate: Vec<Effect>,
    unknowns: usize,
    /// The median time from the scene to the result \[s\].
    seconds: f64,
    /// The most memory that solving took \[bytes\].
    bytes: Option<u64>,
    iterations: u64,
    /// The largest difference of the tractions from those of the first run, over its largest
    /// pressure.
    difference: Option<f64>,
    #[serde(serialize_with = "as_text")]
    status: Standing,
}

fn as_text<S: Serializer>(
    standing: &Standing,
    serializer: S,
) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_str(standing)
}

/// Measures the first job of each group of jobs that call for the same effects.
pub(crate) fn effects(args: &EffectsArgs) -> Result<Finish> {
    let study = read_study(&args.study)?;
    if let Some(Adaptive::Accuracy(_)) = study.adaptive() {
        bail!(
            "{}: its meshes follow from its results; give it a mesh in place of the accuracy",
            study.path()
        );
    }
    let jobs = JobList::of(&study)?;
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
    let mut are_certified = true;
    for group in &overview.groups {
        let point = &jobs.points[group.first];
        let Some(case) = point.job.case() else { continue };
        let runs = runs(case, study.surfaces(), args.repeat)?;
        are_certified &= runs.iter().all(|run| run.status == Standing::Certified);
        text += &format!("{}\n{}\n", title(study.name(), group), table(&runs)?.terminal(&layout()));
        listed.push(serde_json::json!({
            "which": group.label, "jobs": group.jobs, "key": point.key.to_string(), "runs": runs,
        }));
    }
    if args.json {
        output::print_json(
            &serde_json::json!({ "study": study.name(), "repeat": args.repeat, "groups": listed }),
        )?;
    } else {
        output::print(text.trim_end_matches('\n'))?;
        output::print("\n")?;
    }
    Ok(if are_certified { Finish::AllDone } else { Finish::SomeFailed })
}

fn title(study: &str, group: &EffectGroup) -> String {
    let label = if group.label.is_empty() { String::new() } else { format!(", {}", group.label) };
    if group.jobs == 1 {
        format!("{study}{label}")
    } else {
        format!("{study}{label}: the first of {} jobs", group.jobs)
    }
}

/// Solves a case with every effect left out that can be, then with each of those, then with all.
fn runs(case: &Case, surfaces: &Surfaces, repeat: u32) -> Result<Vec<EffectRun>> {
    let mut first: Option<Fields> = None;
    let mut runs = Vec::new();
    for simulate in variants(case, surfaces)? {
        let numerics = Numerics { simulate: simulate.clone(), ..case.numerics.clone() };
        let unknowns = forecast(&case.scene, &numerics, surfaces)?.unknowns;
        let job = Job::Solve(Case { scene: case.scene.clone(), numerics });
        let measurement = measure(&order(Some(&job), job.canonical(), surfaces)?, repeat)?;
        let fields = decode_fields(&measurement.fields)?;
        let status = Standing::from(&measurement.outcome.status);
        // Two iterates that are no solutions do not tell what an effect changes.
        let is_solved = status == Standing::Certified
            && runs.iter().all(|run: &EffectRun| run.status == Standing::Certified);
        runs.push(EffectRun {
            simulate,
            unknowns,
            seconds: median(measurement.seconds),
            bytes: measurement.bytes,
            iterations: measurement.outcome.work().iterations,
            difference: first
                .as_ref()
                .filter(|_| is_solved)
                .and_then(|first| first.difference(&fields)),
            status,
        });
        first.get_or_insert(fields);
    }
    Ok(runs)
}

fn table(runs: &[EffectRun]) -> Result<DataTable> {
    let heads = [
        ("simulated too", ""),
        ("unknowns", ""),
        ("seconds", "s"),
        ("times", ""),
        ("memory", "MiB"),
        ("iterations", ""),
        ("difference", "1"),
        ("status", ""),
    ];
    let fastest = runs.first().map_or(f64::NAN, |run| run.seconds);
    let number = |x: Option<f64>| x.map_or(Cell::Missing, |x| Cell::Number(digits(x, 2)));
    let integer = |n: u64| i64::try_from(n).map_or(Cell::Missing, Cell::Integer);
    let rows = runs.iter().map(|run| {
        let simulated = match run.simulate[..] {
            [] => "nothing".to_owned(),
            [effect] => effect.name().to_owned(),
            _ => "everything".to_owned(),
        };
        vec![
            Cell::Text(simulated),
            integer(run.unknowns as u64),
            number(Some(run.seconds)),
            number(Some(run.seconds / fastest)),
            number(run.bytes.map(|bytes| bytes as f64 / f64::from(1 << 20))),
            integer(run.iterations),
            number(run.difference),
            Cell::Text(run.status.to_string()),
        ]
    });
    let heads = heads.map(|(name, unit)| TableColumn::new(name, unit)).to_vec();
    Ok(DataTable::new(heads, rows.collect())?)
}

/// Has a job solved `repeat` times by another process, so that its memory is that of the job.
fn measure(order: &[u8], repeat: u32) -> Result<Measurement> {
    let program = own_program()?;
    let mut child = Command::new(program)
        .args(["measured", &repeat.to_string()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start a process to solve in")?;
    // The process reads everything before it answers, so that neither waits for the other.
    let sent =
        child.stdin.take().context("the solving process has no standard input")?.write_all(order);
    let output = child.wait_with_output()?;
    if !output.status.success() {
        bail!("the process that solves ended with {}", output.status);
    }
    sent.context("cannot hand over the job")?;
    decode_measurement(&output.stdout)
}
