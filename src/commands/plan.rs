//! `plan`: what a study would run.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::io::IsTerminal;

use answers::choice;
use answers::effects::Group;
use anyhow::{Result, bail};
use contact::Forecast;
use identity::JobKey;
use indicatif::BinaryBytes;
use serde::Serialize;
use store::{OpenError, Store};

use crate::cli::PlanArgs;
use crate::effect_text::overview_words;
use crate::execution::workers;
use crate::job_list::{Jobs, increments};
use crate::output;
use crate::output::{Finish, layout};
use crate::stored::{Source, store_option};
use crate::study_file::read_study;
use crate::words::{count, duration};

/// What a plan says.
#[derive(Serialize)]
struct Plan<'a> {
    study: &'a str,
    question: &'a str,
    points: usize,
    jobs: usize,
    cached: usize,
    to_run: usize,
    increments: u64,
    operators: usize,
    predicted_worker_seconds: f64,
    predicted_seconds: f64,
    workers: usize,
    largest_job_bytes: u64,
    effects: &'a [Group],
    /// Of a study that chooses points, what it found so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    chosen: Option<serde_json::Value>,
}

pub(crate) fn plan(args: &PlanArgs) -> Result<Finish> {
    let study = read_study(&args.study)?;
    let mut jobs = Jobs::of(&study)?;
    let reader = match Store::read(&args.store.store) {
        Ok(reader) => Some(reader),
        Err(OpenError::Missing { .. }) => None,
        Err(error) => bail!(error),
    };
    let mut chosen = None;
    if study.adaptive().is_some() {
        let known = match &reader {
            Some(reader) => choice::gather(&study, &Source::Reader(reader))?.chosen,
            None => choice::choose(&study, &HashMap::new())?,
        };
        jobs = Jobs::of_points(&study, known.points)?;
        chosen = Some(choice::table(&study, &known.findings)?);
    }
    let keys = jobs.keys();
    let overview = jobs.effects(&study)?;
    let cached = match &reader {
        Some(reader) => reader.contains(&keys)?,
        None => vec![false; keys.len()],
    };
    let done: HashSet<JobKey> =
        keys.iter().zip(&cached).filter(|(_, cached)| **cached).map(|(key, _)| *key).collect();
    jobs.bind(&study, |key| done.contains(key))?;
    let left: Vec<&(usize, Forecast)> = jobs
        .distinct
        .iter()
        .zip(&cached)
        .filter(|(_, cached)| !**cached)
        .map(|(job, _)| job)
        .collect();
    let seconds: f64 = left.iter().map(|(_, forecast)| forecast.seconds).sum();
    let longest = left.iter().map(|(_, forecast)| forecast.seconds).fold(0.0, f64::max);
    let workers =
        workers(&study, std::thread::available_parallelism().map_or(1, usize::from), left.len());
    let operators: BTreeSet<u64> = left.iter().map(|(_, forecast)| forecast.operator).collect();
    let plan = Plan {
        study: study.name(),
        question: study.question(),
        points: jobs.points.len(),
        jobs: keys.len(),
        cached: keys.len() - left.len(),
        to_run: left.len(),
        increments: left.iter().map(|(index, _)| increments(&jobs.points[*index].job)).sum(),
        operators: operators.len(),
        predicted_worker_seconds: seconds,
        predicted_seconds: longest.max(seconds / workers as f64),
        workers,
        largest_job_bytes: left.iter().map(|(_, forecast)| forecast.memory).max().unwrap_or(0),
        effects: &overview.groups,
        chosen: chosen.as_ref().map(|table| serde_json::from_str(&table.json())).transpose()?,
    };
    if args.json {
        return output::print_json(&plan);
    }
    let mut text = format!("{}\n", plan.study);
    if !plan.question.is_empty() {
        text += &format!("{}\n", plan.question);
    }
    let (points, distinct) =
        (count(plan.points, "point", "points"), count(plan.jobs, "distinct job", "distinct jobs"));
    text +=
        &format!("\n{points}, {distinct}: {} in the store, {} to run", plan.cached, plan.to_run);
    text += &if plan.increments > plan.to_run as u64 {
        format!(" with {} increments\n", plan.increments)
    } else {
        "\n".to_owned()
    };
    if plan.to_run > 0 {
        text += &format!(
            "about {} on {} ({} of work), {}, up to {} per job\n",
            duration(plan.predicted_seconds),
            count(plan.workers, "worker", "workers"),
            duration(plan.predicted_worker_seconds),
            count(plan.operators, "operator", "operators"),
            BinaryBytes(plan.largest_job_bytes)
        );
        let mut by_mesh: BTreeMap<[usize; 2], (usize, f64)> = BTreeMap::new();
        for (_, forecast) in &left {
            let entry = by_mesh.entry(forecast.elements).or_default();
            entry.0 += 1;
            entry.1 += forecast.seconds;
        }
        for ([nx, ny], (jobs, seconds)) in by_mesh {
            text += &format!(
                "  {nx} x {ny} elements: {}, {} of work\n",
                count(jobs, "job", "jobs"),
                duration(seconds)
            );
        }
    }
    if let Some(table) = chosen {
        text += if plan.to_run > 0 { "more follow, as the results demand\n" } else { "" };
        text += &format!("\nfound so far\n{}", table.terminal(&layout()));
    }
    text += &format!("\n{}", overview_words(&overview));
    if std::io::stdout().is_terminal() && plan.to_run > 0 {
        text += &format!(
            "run it with: tribosweep run {}{}\n",
            args.study.display(),
            store_option(&args.store.store)
        );
    }
    output::print(&text)
}
