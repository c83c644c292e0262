//! What a run says at its end.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use answers::Results;
use answers::results::WARNINGS;
use anyhow::{Context, Result};
use report::DataTable;
use serde::Serialize;
use study::{Record, Study};

use crate::answer_text::{answers_json, answers_words};
use crate::figures;
use crate::output::{self, Finish, layout};
use crate::stored::store_option;
use crate::words::{count, duration};

/// Rows of the table at the end of a run; more are for `query`.
const SUMMARY_ROWS: usize = 24;

/// Failed jobs listed at the end of a run; more are for `query`.
const LISTED_FAILURES: usize = 10;

/// What a run did.
#[derive(Serialize)]
pub(crate) struct Tally {
    pub(crate) jobs: usize,
    pub(crate) cached: usize,
    pub(crate) computing: usize,
    /// Of these, the jobs that ended.
    #[serde(skip)]
    pub(crate) computed: usize,
    pub(crate) seconds: f64,
    pub(crate) interrupted: bool,
}

/// Says at the end of a run what came of it.
pub(crate) fn report(
    results: &Results,
    directory: &Path,
    json: bool,
    tally: Tally,
) -> Result<Finish> {
    let study = results.study();
    let progress = results.progress();
    let figures = if progress.done > 0 { draw_figures(results, directory) } else { Vec::new() };
    let finish = match (tally.interrupted, progress.failed + results.inaccurate()) {
        (true, _) => Finish::Interrupted,
        (_, 0) => Finish::AllDone,
        _ => Finish::SomeFailed,
    };
    let store_option = store_option(directory);
    let mut failures = Vec::new();
    let mut listed = BTreeSet::new();
    for record in results
        .points()
        .iter()
        .filter_map(|point| results.record(point))
        .filter(|record| !record.is_certified())
    {
        if listed.insert(record.key()) {
            let key = record.key().to_string();
            failures.push(serde_json::json!({ "key": key, "status": record.standing().to_string(), "show": format!("tribosweep show {}{store_option}", &key[..12]) }));
        }
    }
    if json {
        let files: Vec<_> = figures.iter().flatten().flatten().collect();
        let line = serde_json::json!({
            "event": "summary", "study": study.name(), "progress": progress, "run": tally, "failures": failures, "figures": files,
            "answers": answers_json(results.answers()?)?, "inaccurate": results.inaccurate(),
        });
        output::print(&format!("{line}\n"))?;
        return Ok(finish);
    }

    let mut text = String::new();
    let mut table = results.usual_table()?;
    let all = table.rows().len();
    if all > SUMMARY_ROWS {
        table = DataTable::new(table.columns().to_vec(), table.rows()[..SUMMARY_ROWS].to_vec())?;
    }
    text += &table.terminal(&layout());
    if all > SUMMARY_ROWS {
        let more = count(all - SUMMARY_ROWS, "more row", "more rows");
        text += &format!("… {more}: tribosweep query {}{store_option}\n", study.name());
    }
    text += &answers_words(results.answers()?);
    text += &format!(
        "\n{}: {}, {} certified, {} failed, {} left; {} of {} computed in {}, {} from the store\n",
        study.name(),
        count(progress.points, "point", "points"),
        progress.done,
        progress.failed,
        progress.left,
        tally.computed,
        count(tally.jobs, "job", "jobs"),
        duration(tally.seconds),
        tally.cached,
    );
    for figure in figures {
        match figure {
            Ok(files) => {
                files.iter().for_each(|file| text += &format!("figure: {}\n", file.display()))
            }
            Err(error) => text += &format!("no figure: {error:#}\n"),
        }
    }
    for warning in &WARNINGS {
        let concerned: Vec<&Record> = results
            .points()
            .iter()
            .filter_map(|point| results.record(point))
            .filter(|record| warning.concerns(record))
            .collect();
        if !concerned.is_empty() {
            let (name, column, words) = (study.name(), warning.column, warning.words);
            let points = count(concerned.len(), "point", "points");
            // a row without them is the end of a path
            let is_path = concerned
                .iter()
                .any(|record| record.outcome().is_some_and(|outcome| outcome.steps.len() > 1));
            let steps = if is_path { " --steps" } else { "" };
            text += &format!(
                "warning: elements of {points} {words}: tribosweep query {name}{steps} --where '{column} > 0'{store_option}\n"
            );
        }
    }
    if results.inaccurate() > 0 {
        let (points, name) =
            (count(results.inaccurate(), "point misses", "points miss"), study.name());
        text += &format!(
            "warning: {points} the accuracy asked for: tribosweep answer {name}{store_option}\n"
        );
    }
    for failure in failures.iter().take(LISTED_FAILURES) {
        text += &format!(
            "{}: {}\n",
            failure["status"].as_str().unwrap_or_default(),
            failure["show"].as_str().unwrap_or_default()
        );
    }
    if failures.len() > LISTED_FAILURES {
        text += &format!(
            "… {} more: tribosweep query {} --where 'status != \"certified\"'{store_option}\n",
            failures.len() - LISTED_FAILURES,
            study.name()
        );
    }
    if tally.interrupted {
        text += &format!("interrupted; continue with: {}\n", again(study, directory));
    }
    output::print(&text)?;
    Ok(finish)
}

/// Each of the study's figures as files in the store's own folder of figures; one that cannot be
/// drawn hinders no other.
fn draw_figures(results: &Results, directory: &Path) -> Vec<Result<Vec<PathBuf>>> {
    let folder = directory.join("figures");
    let draw = |figure: &study::Figure| {
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("cannot make {}", folder.display()))?;
        let files = figures::figure_files(&folder.join(figure.stem(results.study().name())));
        figures::draw(results, figure, None, &files).map(|()| files)
    };
    results.study().figures().iter().map(draw).collect()
}

pub(crate) fn again(study: &Study, directory: &Path) -> String {
    format!("tribosweep resume {}{}", study.name(), store_option(directory))
}
