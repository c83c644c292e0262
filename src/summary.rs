//! The summary at the end of a run.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use answers::shards::Shard;
use answers::{Results, Warning};
use anyhow::{Context, Result};
use serde::Serialize;
use store::Digest;
use study::Study;
use wording::{escaped_json, excerpt};

use crate::answer_text::{answers_json, answers_words};
use crate::figures;
use crate::kept_study::{DrawnFigure, ShownFailure, SummaryFacts};
use crate::output::{self, Finish, layout};
use crate::proposal;
use crate::words::{count, duration, excluded_words};

/// The most rows of the table at the end of a run; `query` shows more.
const SUMMARY_ROWS: usize = 24;

/// The most reasons of failures that are listed at the end of a run; `query` lists more.
const LISTED_FAILURES: usize = 10;

/// The length of the longest reason at the end of a run, in characters; `show` has it whole.
const LONGEST_REASON: usize = 300;

/// The counts of a run.
#[derive(Default, Serialize)]
pub(crate) struct RunTally {
    /// The distinct jobs of the study.
    pub(crate) jobs: usize,
    /// The jobs that the store had results of.
    pub(crate) cached: usize,
    /// The jobs that were given out.
    pub(crate) computing: usize,
    /// The jobs that were given out and have ended.
    #[serde(skip)]
    pub(crate) computed: usize,
    /// The duration \[s\].
    pub(crate) seconds: f64,
    /// The run was interrupted.
    pub(crate) interrupted: bool,
    /// The run stopped within its time or its number of jobs, with jobs left.
    pub(crate) stopped_in_time: bool,
    /// The limit by which the run stopped before its end, as on the command line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) stopped_by: Option<String>,
    /// More jobs failed than were allowed.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(crate) too_many_failed: bool,
    /// The estimate of the time that the jobs left would take \[s\], if the run stopped early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) seconds_left: Option<f64>,
}

impl RunTally {
    /// Returns true if jobs are left.
    pub(crate) fn is_partial(&self) -> bool {
        self.interrupted || self.stopped_in_time || self.too_many_failed
    }
}

/// A job that has ended without a solution.
#[derive(Serialize)]
struct FailedJob {
    key: String,
    status: String,
    /// The reason, if it left one.
    reason: Option<String>,
    /// The command that shows it.
    show: String,
}

impl FailedJob {
    /// Returns the reason up to the details of it.
    fn words(&self) -> &str {
        let reason = self.reason.as_deref().unwrap_or("no reason is known");
        reason.split(';').next().unwrap_or(reason)
    }
}

/// The end of a run.
pub(crate) struct RunEnd {
    pub(crate) tally: RunTally,
    /// The command that goes on with it.
    pub(crate) continuation: String,
    /// The shard, if it is the run of one. A figure of a part of a study misleads, so none is
    /// drawn.
    pub(crate) shard: Option<Shard>,
}

/// Draws the figures of a study and returns what is to be said of it after a run of so many jobs.
/// A figure of a part of a study would mislead, so none is drawn.
pub(crate) fn gathered(
    results: &Results<'_>,
    directory: &Path,
    jobs: usize,
    is_part: bool,
) -> Result<SummaryFacts> {
    let first = results.usual_table(SUMMARY_ROWS)?;
    let all = results.progress().points.max(results.points().len());
    let more = all.saturating_sub(SUMMARY_ROWS);
    let mut facts = SummaryFacts::of(results, jobs, first, more)?;
    facts.answers = results.answers()?.to_vec();
    if !is_part && facts.progress().done > 0 {
        facts.figures = draw_figures(results, directory)?;
    }
    Ok(facts)
}

/// Says what came of a run.
pub(crate) fn summarise(
    facts: &SummaryFacts,
    directory: &Path,
    json: bool,
    ending: RunEnd,
) -> Result<Finish> {
    let RunEnd { tally, continuation, shard } = ending;
    let summary = RunSummary { facts, directory, tally, continuation, shard };
    if json {
        output::print_raw(&escaped_json(&format!("{}\n", summary.json()?)))?;
    } else {
        output::print(&summary.words()?)?;
    }
    let RunTally { interrupted, stopped_in_time, too_many_failed, .. } = summary.tally;
    Ok(match facts.progress().failed + facts.inaccurate {
        _ if interrupted => Finish::Interrupted,
        _ if too_many_failed => Finish::TooManyFailed,
        _ if stopped_in_time => Finish::StoppedInTime,
        0 => Finish::AllDone,
        _ => Finish::SomeFailed,
    })
}

/// Everything that a summary tells.
struct RunSummary<'r> {
    facts: &'r SummaryFacts,
    /// The directory of the store.
    directory: &'r Path,
    tally: RunTally,
    /// The command that goes on with it.
    continuation: String,
    shard: Option<Shard>,
}

impl RunSummary<'_> {
    fn json(&self) -> Result<serde_json::Value> {
        let SummaryFacts { study, answers, warnings, inaccurate, .. } = self.facts;
        let drawn = || self.facts.figures.iter().flatten();
        let files: Vec<PathBuf> = drawn().flat_map(|figure| self.files_of(figure)).collect();
        let undrawn: Vec<&String> = drawn().filter_map(|figure| figure.missing.as_ref()).collect();
        let warnings: Vec<&String> = warnings.iter().map(|warning| &warning.words).collect();
        let mut summary = serde_json::json!({
            "event": "summary",
            "study": study,
            "shard": self.shard.map(|shard| shard.to_string()),
            "progress": self.facts.progress(),
            "run": self.tally,
            "failures": self.failures(),
            "figures": files,
            "undrawn": undrawn,
            "answers": answers_json(answers)?,
            "warnings": warnings,
            "inaccurate": inaccurate,
        });
        let more = self.facts.failed_jobs - self.facts.failures.len();
        if more > 0 {
            summary["failures_not_listed"] = more.into();
        }
        Ok(summary)
    }

    /// Returns the paths of the files of a figure.
    fn files_of<'f>(&'f self, figure: &'f DrawnFigure) -> impl Iterator<Item = PathBuf> + 'f {
        figure.files.iter().map(|(name, _)| self.directory.join(FIGURES).join(name))
    }

    fn words(&self) -> Result<String> {
        let mut text = self.rows();
        text += &answers_words(&self.facts.answers);
        text += &self.counts();
        for figure in &self.facts.figures {
            match figure {
                Ok(drawn) => {
                    let missing = drawn.missing.iter().map(|words| format!(" ({words})"));
                    let missing = missing.collect::<String>();
                    for file in self.files_of(drawn) {
                        text += &format!("figure: {}{missing}\n", file.display());
                    }
                }
                Err(error) => text += &format!("no figure: {error}\n"),
            }
        }
        for warning in &self.facts.warnings {
            text += &warning_line(warning, self.name(), self.directory);
        }
        text += &self.missed_accuracy();
        text += &self.listed_failures();
        if self.tally.interrupted {
            text += &format!("interrupted; continue with: {}\n", self.continuation);
        }
        text += &self.stopped();
        Ok(text)
    }

    /// Says that the run stopped early, if it did, what is left and how long that would take.
    fn stopped(&self) -> String {
        let RunTally { jobs, cached, computed, too_many_failed, seconds_left, .. } = &self.tally;
        let Some(stopped_by) = &self.tally.stopped_by else { return String::new() };
        let how = if *too_many_failed { "stopped" } else { "stopped in time" };
        let left = jobs.saturating_sub(cached + computed);
        let verb = if left == 1 { "is" } else { "are" };
        let jobs = count(*jobs, "job", "jobs");
        // A study that chooses its points has more jobs than it knows of.
        let known = if self.facts.is_adaptive { " known so far" } else { "" };
        let time = seconds_left.map_or(String::new(), |seconds| {
            format!("the jobs left take about {}\n", duration(seconds))
        });
        let advice = if *computed == 0 { ", but no job ended in this time" } else { "" };
        format!(
            "{time}{how} ({stopped_by}): {left} of {jobs}{known} {verb} left; the same command goes \
             on{advice}\n"
        )
    }

    /// Returns the first rows of the results.
    fn rows(&self) -> String {
        let rows = self.facts.rows.terminal(&layout());
        match self.facts.more_rows {
            0 => rows,
            more => {
                let more = count(more, "more row", "more rows");
                format!("{rows}… {more}: {}\n", self.command(["query", self.name()]))
            }
        }
    }

    /// Returns the name of the study.
    fn name(&self) -> &str {
        &self.facts.study
    }

    /// Returns a command on the store, ready to be pasted.
    fn command<'w>(&self, words: impl IntoIterator<Item = &'w str>) -> String {
        proposal::command(self.directory, words)
    }

    fn counts(&self) -> String {
        let RunSummary { facts, tally, .. } = self;
        let progress = facts.progress();
        format!(
            "\n{}{}: {}{}, {} certified, {} failed, {} left; {} of {} computed in {}, {} from the \
             store\n",
            facts.study,
            self.shard.map_or(String::new(), |shard| format!(", shard {shard}")),
            count(progress.points, "point", "points"),
            excluded_words(progress.excluded),
            progress.done,
            progress.failed,
            progress.left,
            tally.computed,
            count(tally.jobs, "job", "jobs"),
            duration(tally.seconds),
            tally.cached,
        )
    }

    fn missed_accuracy(&self) -> String {
        let inaccurate = self.facts.inaccurate;
        if inaccurate == 0 {
            return String::new();
        }
        let points = count(inaccurate, "point misses", "points miss");
        let command = self.command(["answer", self.name()]);
        format!("warning: {points} the accuracy asked for: {command}\n")
    }

    /// Returns the jobs that have ended without a solution, each once; of very many the first.
    fn failures(&self) -> Vec<FailedJob> {
        let failure = |ShownFailure { key, status, reason }: &ShownFailure| {
            let show = self.command(["show", &key[..12]]);
            FailedJob { key: key.clone(), status: status.clone(), reason: reason.clone(), show }
        };
        self.facts.failures.iter().map(failure).collect()
    }

    /// Says why jobs have failed, each reason once, with the command that shows the first of them.
    fn listed_failures(&self) -> String {
        let failures = self.failures();
        let mut alike: Vec<Vec<&FailedJob>> = Vec::new();
        let mut known: HashMap<(&str, String), usize> = HashMap::new();
        for failure in &failures {
            let kind = (failure.status.as_str(), without_numbers(failure.words()));
            let group = *known.entry(kind).or_insert(alike.len());
            match alike.get_mut(group) {
                Some(jobs) => jobs.push(failure),
                None => alike.push(vec![failure]),
            }
        }
        let listed = alike.iter().take(LISTED_FAILURES);
        let mut text: String = listed.map(|jobs| failure_words(jobs)).collect();
        let all = self.facts.failed_jobs;
        if all > alike.len().min(LISTED_FAILURES) {
            let filter = ["--where", "status != \"certified\"", "--select", "key,status,reason"];
            let query = ["query", self.name()].into_iter().chain(filter);
            text += &format!(
                "all {}: {}\n",
                count(all, "failed job", "failed jobs"),
                self.command(query)
            );
        }
        text
    }
}

/// Returns a line for each doubt about a study's results, with the command that shows the rows.
pub(crate) fn warning_lines(results: &Results<'_>, directory: &Path) -> Vec<String> {
    let name = results.study().name();
    results.warnings().iter().map(|warning| warning_line(warning, name, directory)).collect()
}

/// Returns the line about a doubt, with the command that shows the rows.
fn warning_line(warning: &Warning, study: &str, directory: &Path) -> String {
    // A row of `query` without `--steps` is the end of a path.
    let steps = warning.steps.then_some("--steps");
    let query = ["query", study].into_iter().chain(steps);
    let command = proposal::command(directory, query.chain(["--where", &warning.filter]));
    format!("warning: {}: {command}\n", warning.words)
}

/// Returns the doubts about a study's results.
pub(crate) fn warning_words(results: &Results<'_>) -> Vec<String> {
    results.warnings().into_iter().map(|warning| warning.words).collect()
}

/// Returns the line about jobs that have failed for the same reason.
fn failure_words(jobs: &[&FailedJob]) -> String {
    let Some(first) = jobs.first() else { return String::new() };
    let reason = excerpt(first.words(), LONGEST_REASON);
    let FailedJob { status, show, .. } = first;
    match jobs.len() {
        1 => format!("{status}: {reason}: {show}\n"),
        n => format!("{n} {status}, the first: {reason}: {show}\n"),
    }
}

/// Returns a reason in which every number is the same, so that jobs that have failed alike are told
/// together.
fn without_numbers(reason: &str) -> String {
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+');
    let mut words = String::new();
    for piece in reason.split_inclusive(|c: char| !c.is_ascii_alphanumeric() && !is_part(c)) {
        let is_number = piece.starts_with(is_part) && piece.contains(|c: char| c.is_ascii_digit());
        if is_number {
            words.push('0');
            words.extend(piece.chars().last().filter(|c| !c.is_ascii_alphanumeric()));
        } else {
            words += piece;
        }
    }
    words
}

/// The folder of figures in a store.
pub(crate) const FIGURES: &str = "figures";

/// Draws each of the study's figures to files in the store's folder of figures. A figure that
/// cannot be drawn hinders no other.
fn draw_figures(
    results: &Results<'_>,
    directory: &Path,
) -> Result<Vec<Result<DrawnFigure, String>>> {
    let folder = directory.join(FIGURES);
    let draw = |figure: &study::Figure| -> Result<DrawnFigure> {
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("cannot make {}", folder.display()))?;
        let files = figures::own_files(&folder.join(figure.stem(results.study().name())))?;
        let missing = figures::draw(results, figure, None, &files)?;
        let named = files.iter().map(|file| {
            let bytes = std::fs::read(file)?;
            let name = file.file_name().map(PathBuf::from).unwrap_or_default();
            Ok((name, Digest::of(&bytes).0))
        });
        Ok(DrawnFigure { files: named.collect::<Result<_>>()?, missing })
    };
    let in_words = |drawn: Result<DrawnFigure>| drawn.map_err(|error| format!("{error:#}"));
    let study = results.study();
    if !study.is_listed() {
        let most = count(study::MOST_POINTS, "point", "points");
        let advice = "`query` with --format parquet writes their rows to a file";
        return Ok(vec![Err(format!("figures have at most {most}; {advice}"))]);
    }
    let figures = results.figures()?;
    if figures.is_empty() && !study.suggestions().is_empty() {
        return Ok(vec![Err(figures::nothing_varies(study))]);
    }
    Ok(figures.iter().map(draw).map(in_words).collect())
}

/// Returns the command that continues a run.
pub(crate) fn resume_command(study: &Study, directory: &Path) -> String {
    proposal::command(directory, ["resume", study.name()])
}

#[cfg(test)]
mod tests {
    use super::without_numbers;

    #[test]
    fn reasons_that_differ_in_numbers_alone_are_alike() {
        let reason = without_numbers("not converged in 2 iterations (residual 2.5e-1)");
        assert_eq!(reason, without_numbers("not converged in 17 iterations (residual -3e+10)"));
        assert_ne!(reason, without_numbers("not converged in 2 steps (residual 2.5e-1)"));
        assert_eq!(without_numbers("steps[1]: x = 0.5"), "steps[0]: x = 0");
    }
}
