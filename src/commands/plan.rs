//! `plan`: the jobs that a study would run.

use std::ffi::OsStr;
use std::io::IsTerminal;

use answers::RecordMap;
use answers::choice::{self, PointChoice};
use answers::effects::{EffectGroup, Overview};
use answers::shards::{Partition, Shard, ShardLoad};
use anyhow::{Result, bail};
use indicatif::BinaryBytes;
use report::{Cell, DataTable, TableColumn};
use serde::Serialize;
use store::{OpenError, StoreReader};
use study::{MOST_POINTS, Study};

use crate::cli::PlanArgs;
use crate::effect_text::overview_words;
use crate::execution::workers;
use crate::job_list::JobList;
use crate::output::{self, Finish, layout};
use crate::proposal;
use crate::stored::{StoreSource, read_store};
use crate::study_file::{StudyShard, read_large_study, read_shard};
use crate::words::{count, duration, excluded_words};

use stream::{PlanFacts, PlanSurvey};
use tally::{MeshShare, PlanTally};

mod stream;
mod tally;

/// The counts and predictions of a plan.
#[derive(Serialize)]
struct Plan<'a> {
    study: &'a str,
    question: &'a str,
    /// The part of the study, if it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    shard: Option<String>,
    points: usize,
    /// The points of the axes that the conditions of the study leave out.
    #[serde(skip_serializing_if = "Option::is_none")]
    excluded: Option<usize>,
    jobs: usize,
    cached: usize,
    to_run: usize,
    /// The largest number of points that may follow; nothing where it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    more_at_most: Option<usize>,
    increments: u64,
    operators: usize,
    predicted_worker_seconds: f64,
    predicted_seconds: f64,
    workers: usize,
    largest_job_bytes: u64,
    /// The number of jobs whose effects these are, if it is not all.
    #[serde(skip_serializing_if = "Option::is_none")]
    effects_of: Option<usize>,
    effects: &'a [EffectGroup],
    /// The words about the files that the study names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    files: Vec<String>,
    /// The note about the number of points of a sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
    /// The remarks on what the file says without effect.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    remarks: Vec<&'a String>,
    /// The findings so far of a study that chooses points.
    #[serde(skip_serializing_if = "Option::is_none")]
    chosen: Option<serde_json::Value>,
}

/// Says what a study would run; runs nothing.
pub(crate) fn plan(args: &PlanArgs) -> Result<Finish> {
    if let Some(shards) = args.shards {
        return plan_shards(&read_large_study(&args.study)?, shards, args.json);
    }
    let whole = match args.shard {
        Some(_) => None,
        None => Some(read_large_study(&args.study)?),
    };
    if let Some(study) = whole.as_ref().filter(|study| !study.is_listed()) {
        return plan_streamed(args, study);
    }
    let StudyShard { study, shard, .. } = match whole {
        Some(study) => StudyShard::whole(study)?,
        None => read_shard(&args.study, args.shard, &mut |_| false)?,
    };
    let reader = opened(args)?;
    let mut survey = PlanSurvey::of(&study, reader.as_ref());
    let (mut found, mut more) = (None, None);
    if study.adaptive().is_some() {
        JobList::of(&study)?;
        let PointChoice { points, findings, more: bound } = choice_so_far(&study, reader.as_ref())?;
        survey.add(&points)?;
        survey.tally.excluded = study.excluded();
        more = bound;
        found = Some(choice::table(&study, &findings)?);
    } else {
        choice::check(&study)?;
        survey.add_all()?;
    }
    let PlanFacts { tally, overview, files } = survey.facts();
    let mut plan = Plan::of(&study, &tally, &overview, files);
    plan.chosen = found.as_ref().map(|table| serde_json::from_str(&table.json())).transpose()?;
    plan.more_at_most = more;
    plan.shard = args.shard.map(|_| shard.to_string());
    if args.json {
        return output::print_json(&plan);
    }
    let mut text = plan.beginning(&tally);
    if let Some(table) = found {
        text += &plan.following(&tally);
        text += &format!("\nfound so far\n{}", table.terminal(&layout()));
    }
    text += &format!("\n{}", overview_words(&overview));
    text += &proposed(args, &plan);
    output::print(&text)
}

/// Opens the store of a plan; there may be none.
fn opened(args: &PlanArgs) -> Result<Option<StoreReader>> {
    match read_store(&args.store.store) {
        Ok(reader) => Ok(Some(reader)),
        Err(OpenError::Missing { .. }) => Ok(None),
        Err(error) => bail!(error),
    }
}

/// Says what the jobs of a study take that has too many points to list them. Its effects are those
/// of some points.
fn plan_streamed(args: &PlanArgs, study: &Study) -> Result<Finish> {
    choice::check(study)?;
    let reader = opened(args)?;
    let mut survey = PlanSurvey::of(study, reader.as_ref());
    let looked_at = survey.add_streamed()?;
    let PlanFacts { tally, overview, files } = survey.facts();
    let mut plan = Plan::of(study, &tally, &overview, files);
    plan.effects_of = Some(looked_at);
    if args.json {
        return output::print_json(&plan);
    }
    let mut text = plan.beginning(&tally);
    if study.adaptive().is_some() {
        text += "more follow, as the results demand\n";
    }
    let looked_at = count(looked_at, "job that was", "jobs that were");
    text += &format!("\nof the effects, by {looked_at} looked at\n{}", overview_words(&overview));
    text += &proposed(args, &plan);
    output::print(&text)
}

/// Says on a terminal how the study is run; nothing if there is nothing to run.
fn proposed(args: &PlanArgs, plan: &Plan<'_>) -> String {
    if !std::io::stdout().is_terminal() || plan.to_run == 0 {
        return String::new();
    }
    let file = wording::file_argument(&args.study);
    let shards = plan.points.div_ceil(MOST_POINTS);
    let part = plan.shard.clone().or((shards > 1).then(|| format!("1/{shards}")));
    let mut run = vec![OsStr::new("run"), &file];
    run.extend(part.iter().flat_map(|shard| ["--shard".as_ref(), OsStr::new(shard)]));
    let all = if plan.shard.is_none() && shards > 1 { ", and its other shards" } else { "" };
    format!("run it with: {}{all}\n", proposal::command(&args.store.store, run))
}

/// Says how many points are in how many shards.
fn placed(points: u64, shards: u32) -> String {
    format!(
        "{} in {}",
        count(points as usize, "point", "points"),
        count(shards as usize, "shard", "shards")
    )
}

/// The most shards that are listed; the JSON lists all.
const MOST_SHARDS_LISTED: u32 = 24;

/// Says what each shard of a study would have.
fn plan_shards(study: &Study, count_of_shards: u32, json: bool) -> Result<Finish> {
    let partition = Partition::of(study, count_of_shards)?;
    let shards = || {
        (1..=u64::from(count_of_shards))
            .filter_map(|index| Shard::new(index, count_of_shards.into()).ok())
    };
    let loads: Vec<ShardLoad> = shards().map(|shard| partition.load(shard)).collect();
    for load in &loads {
        study.require_possible(load.points)?;
    }
    let points: u64 = loads.iter().map(|load| load.points).sum();
    let seconds: f64 = loads.iter().map(|load| load.seconds).sum();
    let mean = seconds / f64::from(count_of_shards);
    let fullest = loads.iter().map(|load| load.seconds).fold(0.0, f64::max);
    let empty = loads.iter().filter(|load| load.points == 0).count();
    if json {
        let listed = shards().zip(&loads).map(|(shard, load)| {
            serde_json::json!({
                "shard": shard.to_string(), "points": load.points, "sequences": load.sequences,
                "operators": load.operators, "predicted_worker_seconds": load.seconds,
            })
        });
        return output::print_json(&serde_json::json!({
            "study": study.name(), "points": points, "predicted_worker_seconds": seconds,
            "fullest_to_mean": fullest / mean, "empty": empty,
            "shards": listed.collect::<Vec<_>>(),
        }));
    }
    let mut text = format!(
        "{}\n\n{}, {} of work each on average; ",
        study.name(),
        placed(points, count_of_shards),
        duration(mean)
    );
    text += &match 100.0 * (fullest / mean - 1.0) {
        0.5.. => format!("the fullest has {:.0} % more than that", 100.0 * (fullest / mean - 1.0)),
        _ => "they are even".to_owned(),
    };
    // The sums differ in rounding.
    if partition.longest() > 0.99 * fullest && fullest > 1.005 * mean {
        text += ", for it has the longest sequence, which stays whole";
    }
    text += "\n";
    if study.adaptive().is_some() {
        text += "more points follow in every shard, as the results demand\n";
    }
    text += &excluded_of_shards(study);
    if empty > 0 {
        text += &format!("{} no points\n", count(empty, "shard has", "shards have"));
    }
    let heads =
        [("shard", ""), ("points", ""), ("sequences", ""), ("operators", ""), ("work", "s")];
    let rows = shards().zip(&loads).take(MOST_SHARDS_LISTED as usize).map(|(shard, load)| {
        vec![
            Cell::Text(shard.to_string()),
            Cell::Integer(load.points as i64),
            Cell::Integer(load.sequences as i64),
            Cell::Integer(load.operators as i64),
            Cell::Number(load.seconds),
        ]
    });
    let heads = heads.map(|(name, unit)| TableColumn::new(name, unit)).to_vec();
    text += &DataTable::new(heads, rows.collect())?.terminal(&layout());
    if count_of_shards > MOST_SHARDS_LISTED {
        let rest = count_of_shards - MOST_SHARDS_LISTED;
        text += &format!("and {rest} more; --json lists all\n");
    }
    output::print(&text)
}

/// Says what the conditions of a study leave out of its shards; nothing if it has none.
fn excluded_of_shards(study: &Study) -> String {
    match (study.has_conditions(), study.is_listed()) {
        (false, _) => String::new(),
        (true, true) => match study.excluded() {
            0 => "no points are excluded\n".to_owned(),
            excluded => {
                format!("{}\n", count(excluded, "point is excluded", "points are excluded"))
            }
        },
        (true, false) => {
            "these are the points of the axes, fewer after the conditions of the study, which each \
             shard decides for its own\n"
                .to_owned()
        }
    }
}

/// Chooses the points of a study by the results of a store, if there is one.
fn choice_so_far(study: &Study, reader: Option<&StoreReader>) -> Result<PointChoice> {
    Ok(match reader {
        Some(reader) => choice::gather(study, &StoreSource::Reader(reader))?.choice,
        None => choice::choose(study, &RecordMap::new())?,
    })
}

impl<'a> Plan<'a> {
    fn of(
        study: &'a Study,
        tally: &'a PlanTally,
        overview: &'a Overview,
        files: Vec<String>,
    ) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let workers = workers(study, cores, tally.to_run);
        Plan {
            study: study.name(),
            question: study.question(),
            shard: None,
            points: tally.points,
            excluded: study.has_conditions().then_some(tally.excluded),
            remarks: study.remarks().iter().chain(&tally.remarks).collect(),
            jobs: tally.jobs,
            cached: tally.jobs - tally.to_run,
            to_run: tally.to_run,
            more_at_most: None,
            increments: tally.increments,
            operators: tally.operators.len(),
            predicted_worker_seconds: tally.seconds,
            predicted_seconds: tally.longest.max(tally.seconds / workers as f64),
            workers,
            largest_job_bytes: tally.largest,
            effects_of: None,
            effects: &overview.groups,
            files,
            note: study.sample_note(),
            chosen: None,
        }
    }

    /// Returns the counts, and what the jobs that are left will take.
    fn beginning(&self, tally: &PlanTally) -> String {
        match self.to_run {
            0 => self.counts(),
            _ => self.counts() + &self.predictions() + &meshes(tally),
        }
    }

    /// Returns the question and the numbers of points and jobs.
    fn counts(&self) -> String {
        let mut text = match &self.shard {
            Some(shard) => format!("{}, shard {shard}\n", self.study),
            None => format!("{}\n", self.study),
        };
        if !self.question.is_empty() {
            // A line end in it could make a line that looks like one of ours.
            text += &format!("{}\n", wording::one_line(self.question));
        }
        text += &format!(
            "\n{}{}, {}: {} in the store, {} to run",
            count(self.points, "point", "points"),
            excluded_words(self.excluded.unwrap_or(0)),
            count(self.jobs, "distinct job", "distinct jobs"),
            self.cached,
            self.to_run
        );
        if self.increments > self.to_run as u64 {
            text += &format!(" with {} increments", self.increments);
        }
        text += "\n";
        let remarks =
            self.remarks.iter().copied().chain(&self.files).map(|line| format!("{line}\n"));
        text += &self.note.iter().map(|note| format!("note: {note}\n")).collect::<String>();
        text + &remarks.collect::<String>()
    }

    /// Says how many jobs may follow those that are known, and how long they would take: as long as
    /// these do on average.
    fn following(&self, tally: &PlanTally) -> String {
        let mean = tally.forecast / tally.jobs.max(1) as f64;
        match self.more_at_most {
            _ if self.to_run == 0 => String::new(),
            None => "more follow, as the results demand\n".to_owned(),
            Some(0) => "no more follow\n".to_owned(),
            Some(more) => format!(
                "more follow, as the results demand: at most {}, {} of work\n",
                count(more, "point", "points"),
                duration(more as f64 * mean)
            ),
        }
    }

    fn predictions(&self) -> String {
        format!(
            "about {} on {} ({} of work), {}, up to {} per job\n",
            duration(self.predicted_seconds),
            count(self.workers, "worker", "workers"),
            duration(self.predicted_worker_seconds),
            count(self.operators, "operator", "operators"),
            BinaryBytes(self.largest_job_bytes)
        )
    }
}

/// Returns a line for each size of mesh.
fn meshes(tally: &PlanTally) -> String {
    let line = |([nx, ny], MeshShare { jobs, seconds }): (&[usize; 2], &MeshShare)| {
        format!(
            "  {nx} x {ny} elements: {}, {} of work\n",
            count(*jobs, "job", "jobs"),
            duration(*seconds)
        )
    };
    tally.meshes.iter().map(line).collect()
}
