//! The summary at the end of a run.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use answers::{Results, Warning};
use anyhow::{Context, Result, anyhow};
use report::DataTable;
use serde::Serialize;
use study::{Record, Study};

use crate::answer_text::{answers_json, answers_words};
use crate::figures;
use crate::output::{self, Finish, layout};
use crate::stored::store_option;
use crate::words::{count, duration};

/// The most rows of the table at the end of a run; `query` shows more.
const SUMMARY_ROWS: usize = 24;

/// The most failed jobs that are listed at the end of a run; `query` lists more.
const LISTED_FAILURES: usize = 10;

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
}

/// A job that has ended without a solution.
#[derive(Serialize)]
struct FailedJob {
    key: String,
    status: String,
    /// The command that shows it.
    show: String,
}

/// A figure that was drawn.
struct DrawnFigure {
    files: Vec<PathBuf>,
    /// The sentence about points that are missing, if some are.
    missing: Option<String>,
}

/// Draws the figures of a study and says what came of a run.
pub(crate) fn summarise(
    results: &Results<'_>,
    directory: &Path,
    json: bool,
    tally: RunTally,
) -> Result<Finish> {
    let progress = results.progress();
    let figures = if progress.done > 0 { draw_figures(results, directory)? } else { Vec::new() };
    let summary = RunSummary { results, store_option: store_option(directory), tally, figures };
    if json {
        output::print(&format!("{}\n", summary.json()?))?;
    } else {
        output::print(&summary.words()?)?;
    }
    Ok(match (summary.tally.interrupted, progress.failed + results.inaccurate()) {
        (true, _) => Finish::Interrupted,
        (false, 0) => Finish::AllDone,
        (false, _) => Finish::SomeFailed,
    })
}

/// Everything that a summary tells.
struct RunSummary<'r> {
    results: &'r Results<'r>,
    /// The option that names the store.
    store_option: String,
    tally: RunTally,
    /// The figures, or why each was not drawn.
    figures: Vec<Result<DrawnFigure>>,
}

impl RunSummary<'_> {
    fn json(&self) -> Result<serde_json::Value> {
        let drawn = || self.figures.iter().flatten();
        let files: Vec<&PathBuf> = drawn().flat_map(|figure| &figure.files).collect();
        let undrawn: Vec<&String> = drawn().filter_map(|figure| figure.missing.as_ref()).collect();
        Ok(serde_json::json!({
            "event": "summary",
            "study": self.results.study().name(),
            "progress": self.results.progress(),
            "run": self.tally,
            "failures": self.failures(),
            "figures": files,
            "undrawn": undrawn,
            "answers": answers_json(self.results.answers()?)?,
            "warnings": warning_words(self.results),
            "inaccurate": self.results.inaccurate(),
        }))
    }

    fn words(&self) -> Result<String> {
        let mut text = self.rows()?;
        text += &answers_words(self.results.answers()?);
        text += &self.counts();
        for figure in &self.figures {
            match figure {
                Ok(DrawnFigure { files, missing }) => {
                    let missing =
                        missing.iter().map(|words| format!(" ({words})")).collect::<String>();
                    for file in files {
                        text += &format!("figure: {}{missing}\n", file.display());
                    }
                }
                Err(error) => text += &format!("no figure: {error:#}\n"),
            }
        }
        for line in warning_lines(self.results, &self.store_option) {
            text += &line;
        }
        text += &self.missed_accuracy();
        text += &self.listed_failures();
        if self.tally.interrupted {
            let RunSummary { results, store_option, .. } = self;
            let command = resume(results.study(), store_option);
            text += &format!("interrupted; continue with: {command}\n");
        }
        Ok(text)
    }

    /// Returns the first rows of the results.
    fn rows(&self) -> Result<String> {
        let RunSummary { results, store_option, .. } = self;
        let table = results.usual_table()?;
        let rows = table.rows();
        let Some(rest) = rows.len().checked_sub(SUMMARY_ROWS).filter(|rest| *rest > 0) else {
            return Ok(table.terminal(&layout()));
        };
        let first = DataTable::new(table.columns().to_vec(), rows[..SUMMARY_ROWS].to_vec())?;
        let more = count(rest, "more row", "more rows");
        let name = results.study().name();
        Ok(format!(
            "{}… {more}: tribosweep query {name}{store_option}\n",
            first.terminal(&layout())
        ))
    }

    fn counts(&self) -> String {
        let RunSummary { results, tally, .. } = self;
        let progress = results.progress();
        format!(
            "\n{}: {}, {} certified, {} failed, {} left; {} of {} computed in {}, {} from the \
             store\n",
            results.study().name(),
            count(progress.points, "point", "points"),
            progress.done,
            progress.failed,
            progress.left,
            tally.computed,
            count(tally.jobs, "job", "jobs"),
            duration(tally.seconds),
            tally.cached,
        )
    }

    /// Returns the record of every point that has one.
    fn records(&self) -> impl Iterator<Item = &Record> {
        self.results.points().iter().filter_map(|point| self.results.record(point))
    }

    fn missed_accuracy(&self) -> String {
        let inaccurate = self.results.inaccurate();
        if inaccurate == 0 {
            return String::new();
        }
        let points = count(inaccurate, "point misses", "points miss");
        let (name, store_option) = (self.results.study().name(), &self.store_option);
        format!(
            "warning: {points} the accuracy asked for: tribosweep answer {name}{store_option}\n"
        )
    }

    /// Returns the jobs that have ended without a solution, each once.
    fn failures(&self) -> Vec<FailedJob> {
        let mut listed = BTreeSet::new();
        self.records()
            .filter(|record| !record.is_certified() && listed.insert(record.key()))
            .map(|record| {
                let key = record.key().to_string();
                let show = format!("tribosweep show {}{}", &key[..12], self.store_option);
                FailedJob { key, status: record.standing().to_string(), show }
            })
            .collect()
    }

    fn listed_failures(&self) -> String {
        let failures = self.failures();
        let listed = failures.iter().take(LISTED_FAILURES);
        let mut text: String =
            listed.map(|failure| format!("{}: {}\n", failure.status, failure.show)).collect();
        if failures.len() > LISTED_FAILURES {
            text += &format!(
                "… {} more: tribosweep query {} --where 'status != \"certified\"'{}\n",
                failures.len() - LISTED_FAILURES,
                self.results.study().name(),
                self.store_option
            );
        }
        text
    }
}

/// Returns a line for each doubt about a study's results, with the command that shows the rows.
pub(crate) fn warning_lines(results: &Results<'_>, store_option: &str) -> Vec<String> {
    let name = results.study().name();
    let line = |warning: Warning| {
        // A row of `query` without `--steps` is the end of a path.
        let steps = if warning.steps { " --steps" } else { "" };
        format!(
            "warning: {}: tribosweep query {name}{steps} --where '{}'{store_option}\n",
            warning.words, warning.filter
        )
    };
    results.warnings().into_iter().map(line).collect()
}

/// Returns the doubts about a study's results.
pub(crate) fn warning_words(results: &Results<'_>) -> Vec<String> {
    results.warnings().into_iter().map(|warning| warning.words).collect()
}

/// Draws each of the study's figures to files in the store's folder of figures. A figure that
/// cannot be drawn hinders no other.
fn draw_figures(results: &Results<'_>, directory: &Path) -> Result<Vec<Result<DrawnFigure>>> {
    let folder = directory.join("figures");
    let draw = |figure: &study::Figure| {
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("cannot make {}", folder.display()))?;
        let files = figures::figure_files(&folder.join(figure.stem(results.study().name())));
        let missing = figures::draw(results, figure, None, &files)?;
        Ok(DrawnFigure { files, missing })
    };
    let figures = results.figures()?;
    if figures.is_empty() && !results.study().suggestions().is_empty() {
        return Ok(vec![Err(anyhow!(figures::nothing_varies(results.study())))]);
    }
    Ok(figures.iter().map(draw).collect())
}

/// Returns the command that continues a run.
pub(crate) fn resume_command(study: &Study, directory: &Path) -> String {
    resume(study, &store_option(directory))
}

fn resume(study: &Study, store_option: &str) -> String {
    format!("tribosweep resume {}{store_option}", study.name())
}
