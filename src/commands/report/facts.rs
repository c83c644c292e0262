//! The sentences and tables of a report.

use std::ffi::OsString;

use answers::effects::{Overview, OverviewDraft, missing_surface};
use answers::{AnswerTable, Progress, Results};
use anyhow::Result;
use contact::punch::Surfaces;
use report::{Cell, DataTable, PageBlock, PageSection, TableColumn, TableError, quantity_words};
use store::StudyLabels;
use study::columns::Role;
use study::job::PHYSICS_VERSION;
use study::{Figure, StudyPoint};

use super::provenance;
use super::rows::{JobRows, MOST_ROWS};
use crate::effect_text::effect_table;
use crate::labels::tag_words;
use crate::one_result::UsedFiles;
use crate::words::{count, duration};

/// Returns the section that comes first: how far the study is, what it says, and what is to be
/// doubted of it.
pub(super) fn before(
    results: &Results<'_>,
    rows: &JobRows<'_>,
    filter: Option<&str>,
    doubts: &[String],
) -> Result<Vec<PageSection>> {
    let Progress { points, done, failed, left, excluded } = results.progress();
    let mut blocks = Vec::new();
    let mut said =
        format!("{done} of {} are solved and certified", count(points, "point", "points"));
    if failed > 0 {
        said += &format!(", {failed} failed");
    }
    if left > 0 {
        said += &format!(", {left} have no result yet");
    }
    if excluded > 0 {
        said += &format!("; {excluded} more of the axes are excluded by the study");
    }
    blocks.push(PageBlock::Words(said + "."));
    blocks.extend(doubts.iter().cloned().map(PageBlock::Warning));
    let mut answers = answers(results)?;
    if let Some(filter) = filter {
        let whole = if answers.is_empty() { "" } else { " answers," };
        blocks.push(PageBlock::Words(format!(
            "The number of points that are solved, the{whole} warnings and effects are of the whole \
             study; everything else is of the {} for which {filter} holds.",
            count(rows.len(), "point", "points")
        )));
    }
    if answers.is_empty() {
        answers.extend(ranges(results, rows)?.into_iter().map(PageBlock::Words));
    }
    blocks.extend(answers);
    for warning in results.warnings() {
        blocks.push(PageBlock::Warning(format!("Warning: {}.", warning.words)));
        let steps = warning.steps.then_some("--steps");
        let query = ["query", &rows.study].into_iter().chain(steps);
        let command = wording::command(query.chain(["--where", &warning.filter]));
        blocks.push(PageBlock::Command(command));
    }
    Ok(vec![PageSection { id: "answer", title: "Answer", blocks }])
}

/// Returns the tags and the remark that people have put to the study.
pub(super) fn labels(labels: &StudyLabels) -> Vec<PageBlock> {
    let tags = (!labels.tags.is_empty()).then(|| format!("Tags: {}.", tag_words(labels)));
    let note = labels.note.as_ref().map(|note| format!("Note: {note}"));
    tags.into_iter().chain(note).map(PageBlock::Words).collect()
}

/// Returns what a study says beyond its rows.
fn answers(results: &Results<'_>) -> Result<Vec<PageBlock>> {
    let mut blocks = Vec::new();
    for AnswerTable { title, table } in results.answers()? {
        match (table.columns(), table.rows()) {
            // A table of one cell is a sentence.
            ([_], [row]) => {
                let [Cell::Text(words)] = &row[..] else { continue };
                blocks.push(PageBlock::Words(sentence(words)));
            }
            _ => {
                blocks.push(PageBlock::Heading(title.to_string()));
                blocks.extend(shortened(table)?);
            }
        }
    }
    Ok(blocks)
}

/// Returns words as a sentence, with a capital letter and a full stop.
fn sentence(words: &str) -> String {
    let mut letters = words.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    let end = if words.ends_with(['.', '!', '?']) { "" } else { "." };
    format!("{first}{}{end}", letters.as_str())
}

/// Says between which values the quantities of the figures lie.
fn ranges(results: &Results<'_>, rows: &JobRows<'_>) -> Result<Vec<String>> {
    let mut named: Vec<&String> = Vec::new();
    let figures = results.figures()?.iter().filter(|figure| !figure.steps);
    for name in figures.flat_map(Figure::shown) {
        if !named.contains(&name) {
            named.push(name);
        }
    }
    let mut said = Vec::new();
    for name in named {
        let column = rows.columns().iter().find(|column| column.name == name.as_str());
        let (Some(column), Some(summary)) = (column, rows.summary(name)) else { continue };
        let (Some(least), Some(most)) = (summary.all.least, summary.all.most) else { continue };
        let name = study::label::label(column, rows.columns());
        let of = count(summary.all.count, "point", "points");
        if least.1 == most.1 {
            let value = quantity_words(least.1, column.unit());
            said.push(format!("The {name} is {value} at all of {of}."));
            continue;
        }
        let end = |(row, x): (usize, f64)| -> Result<String> {
            let place = rows.place(row)?;
            let place = if place.is_empty() { place } else { format!(" at {place}") };
            Ok(format!("{}{place}", quantity_words(x, column.unit())))
        };
        said.push(format!("Over {of} the {name} runs from {} to {}.", end(least)?, end(most)?));
    }
    Ok(said)
}

/// Returns the beginning of a table, and how much is cut off.
fn shortened(table: &DataTable) -> Result<Vec<PageBlock>, TableError> {
    let rows = table.rows().iter().take(MOST_ROWS).cloned().collect();
    let first = DataTable::new(table.columns().to_vec(), rows)?;
    Ok(beginning(first, table.rows().len()))
}

/// Returns the first rows of a table of so many, and how many are cut off.
fn beginning(first: DataTable, rows: usize) -> Vec<PageBlock> {
    let left_out = rows - first.rows().len();
    let more = format!("{left_out} more rows are left out here.");
    let more = (left_out > 0).then_some(PageBlock::Words(more));
    [PageBlock::Table(first)].into_iter().chain(more).collect()
}

/// Returns the sections that come after the jobs. The words of a command write the page.
pub(super) fn after(
    results: &Results<'_>,
    rows: &JobRows<'_>,
    command: &[OsString],
) -> Result<Vec<PageSection>> {
    Ok(vec![
        failures(rows)?,
        effects(results)?,
        PageSection {
            id: "certificates",
            title: "Certificates and estimated errors",
            blocks: [certificates(rows)?, estimates(rows)?].concat(),
        },
        cost(rows)?,
        provenance::section(results, rows)?,
        reproduction(results, command)?,
    ])
}

/// Lists the jobs that failed, with the reason and the command that shows each.
fn failures(rows: &JobRows<'_>) -> Result<PageSection> {
    let standings = &rows.standings;
    let mut blocks = Vec::new();
    if standings.failed == 0 {
        blocks.push(PageBlock::Words("No job failed.".to_owned()));
    } else {
        let names: Vec<&str> = rows.axes().into_iter().chain(["status", "reason"]).collect();
        let told = rows.rows.at(&names, &standings.first_failed)?;
        let keys = rows.keys(&standings.first_failed)?;
        let mut columns = told.columns().to_vec();
        columns.push(TableColumn::new("command", ""));
        let lines = told.rows().iter().zip(&keys).map(|(told, key)| {
            let command = Cell::Text(wording::command(["show", key.get(..12).unwrap_or(key)]));
            told.iter().cloned().chain([command]).collect()
        });
        let table = DataTable::new(columns, lines.collect())?;
        blocks.push(PageBlock::Words(format!(
            "{} left no certified solution.",
            count(standings.failed, "job", "jobs")
        )));
        blocks.extend(beginning(table, standings.failed));
        let query = ["query", &rows.study, "--where", "status != \"certified\""];
        let query = query.into_iter().chain(["--select", "key,status,reason"]);
        blocks.push(PageBlock::Command(wording::command(query)));
    }
    Ok(PageSection { id: "failures", title: "Failures", blocks })
}

/// Lists the effects that are simulated and left out, with the reasons.
fn effects(results: &Results<'_>) -> Result<PageSection> {
    let mut blocks = Vec::new();
    match overview(results) {
        Ok(overview) if overview.groups.is_empty() => blocks.push(PageBlock::Words(
            "The jobs of this kind of study solve no single scene, so no effects are chosen for \
             them."
                .to_owned(),
        )),
        Ok(overview) => {
            blocks.push(PageBlock::Words(format!(
                "The effects that each of {} calls for, as this version of the program decides \
                 them (physics {PHYSICS_VERSION}).",
                count(overview.jobs, "job", "jobs")
            )));
            for group in overview.groups.iter().take(MOST_GROUPS) {
                let jobs = count(group.jobs, "job", "jobs");
                let of = if group.label.is_empty() { "" } else { ": " };
                blocks.push(PageBlock::Heading(format!("{jobs}{of}{}", group.label)));
                blocks.push(PageBlock::Table(effect_table(group)?));
            }
            if let Some(more) = overview.groups.len().checked_sub(MOST_GROUPS).filter(|n| *n > 0) {
                blocks.push(PageBlock::Words(format!(
                    "{} left out here; `tribosweep plan --json` lists all.",
                    count(more, "more group of jobs is", "more groups of jobs are")
                )));
            }
        }
        // A page about results is worth having without them.
        Err(error) => {
            blocks.push(PageBlock::Warning(format!("The effects are not known: {error:#}.")))
        }
    }
    Ok(PageSection { id: "effects", title: "Effects", blocks })
}

/// Returns the effects of all jobs, whose points pass by in blocks.
fn overview(results: &Results<'_>) -> Result<Overview> {
    let mut draft = OverviewDraft::of(results.study());
    results.visit_points(&mut |points| draft.add(points))?;
    Ok(draft.overview())
}

/// The most groups of jobs whose effects are listed.
const MOST_GROUPS: usize = 12;

/// Returns a table of texts.
fn texts<const N: usize>(
    names: [&str; N],
    rows: Vec<[String; N]>,
) -> Result<DataTable, TableError> {
    let columns = names.map(|name| TableColumn::new(name, "")).to_vec();
    let cells = rows.into_iter().map(|row| row.map(Cell::Text).to_vec());
    DataTable::new(columns, cells.collect())
}

/// Returns a residual or an error with two digits.
fn rounded(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.1e}") }
}

/// Lists the largest figure of each certificate.
fn certificates(rows: &JobRows<'_>) -> Result<Vec<PageBlock>> {
    let mut lines = Vec::new();
    for column in rows.of_role(Role::Certificate) {
        let summary = rows.summary(&column.name);
        let Some((row, x)) = summary.and_then(|summary| summary.all.largest) else { continue };
        lines.push([
            column.name.to_string(),
            column.meaning.to_owned(),
            format!("{} {}", rounded(x), column.unit()).trim_end().to_owned(),
            rows.place(row)?,
        ]);
    }
    if lines.is_empty() {
        return Ok(vec![PageBlock::Words("No result has a certificate.".to_owned())]);
    }
    Ok(vec![
        PageBlock::Words(
            "Every certified result was checked by code that shares nothing with the solver. \
             These are the largest figures of all results; 0 is exact."
                .to_owned(),
        ),
        PageBlock::Table(texts(["figure", "meaning", "largest", "at"], lines)?),
    ])
}

/// Lists the estimated errors.
fn estimates(rows: &JobRows<'_>) -> Result<Vec<PageBlock>> {
    let mut lines = Vec::new();
    for column in rows.of_role(Role::Error) {
        let Some(summary) = rows.summary(&column.name) else { continue };
        let (Some((row, x)), Some(middle)) = (summary.all.largest, summary.median) else {
            continue;
        };
        lines.push([
            column.name.to_string(),
            column.meaning.to_owned(),
            rounded(middle),
            rounded(x),
            rows.place(row)?,
        ]);
    }
    if lines.is_empty() {
        return Ok(vec![PageBlock::Words("No error is estimated.".to_owned())]);
    }
    Ok(vec![
        PageBlock::Heading("Estimated errors".to_owned()),
        PageBlock::Table(texts(["error", "meaning", "median", "largest", "at"], lines)?),
    ])
}

/// Says what the jobs took.
fn cost(rows: &JobRows<'_>) -> Result<PageSection> {
    let mut blocks = Vec::new();
    let seconds = rows.summary("seconds");
    let known = seconds.and_then(|seconds| Some((seconds, seconds.of_jobs.largest?)));
    if let Some((seconds, (row, most))) = known {
        let place = rows.place(row)?;
        let place = if place.is_empty() { place } else { format!(" at {place}") };
        blocks.push(PageBlock::Words(format!(
            "Solving {} took {} of one worker in all; the median is {}, the largest {}{place}.",
            count(seconds.of_jobs.count, "job", "jobs"),
            duration(seconds.of_jobs.sum),
            duration(seconds.median.unwrap_or(f64::NAN)),
            duration(most)
        )));
    } else {
        blocks.push(PageBlock::Words("No job has a time.".to_owned()));
    }
    let mut lines = Vec::new();
    for column in rows.of_role(Role::Work) {
        let Some(summary) = rows.summary(&column.name) else { continue };
        let (Some((row, most)), Some(middle)) = (summary.of_jobs.largest, summary.median) else {
            continue;
        };
        lines.push([
            column.name.to_string(),
            column.meaning.to_owned(),
            quantity_words(middle, column.unit()),
            quantity_words(most, column.unit()),
            rows.place(row)?,
        ]);
    }
    if !lines.is_empty() {
        let table = texts(["work", "meaning", "median", "largest", "at"], lines)?;
        blocks.push(PageBlock::Table(table));
    }
    Ok(PageSection { id: "cost", title: "Cost", blocks })
}

/// Returns the words about the files that the jobs read.
fn used_files(results: &Results<'_>) -> Result<Vec<String>> {
    let study = results.study();
    let mut files: Vec<String> = Vec::new();
    if study.named_files().next().is_none() {
        return Ok(files);
    }
    // Most jobs name no file, and to lay out each of many takes its time.
    let names_file = |point: &&StudyPoint| missing_surface(&point.job, &Surfaces::new()).is_some();
    results.visit_points(&mut |points| {
        for point in points.iter().filter(names_file) {
            if files.len() >= MOST_ROWS {
                break;
            }
            for words in UsedFiles::of(study, &point.job).words {
                if !files.contains(&words) {
                    files.push(words);
                }
            }
        }
        Ok::<(), anyhow::Error>(())
    })?;
    Ok(files)
}

/// Says how the results can be computed again.
fn reproduction(results: &Results<'_>, command: &[OsString]) -> Result<PageSection> {
    let study = results.study();
    let name = study.name();
    let file = format!("{name}.toml");
    let argument = wording::file_argument(std::path::Path::new(&file));
    let run = wording::command([std::ffi::OsStr::new("run"), &argument]);
    let mut blocks = vec![
        PageBlock::Words(format!(
            "The study is the text below, kept as {file}. These commands compute it, draw its \
             figures and write this page; where a store has the results already, they are not \
             computed again. The same version gives the same results, byte for byte, on any \
             number of workers. The commands read the store .tribosweep in the current directory; \
             --store names another one."
        )),
        PageBlock::Command(run),
        PageBlock::Command(wording::command(["plot", name])),
        PageBlock::Command(wording::command(command)),
    ];
    let files = used_files(results)?;
    if !files.is_empty() {
        blocks.push(PageBlock::Words(
            "It reads files that are not in this page. The store holds them, so that `tribosweep \
             resume` needs none of them:"
                .to_owned(),
        ));
        blocks.push(PageBlock::Source(files.join("\n")));
        blocks.push(PageBlock::Command(wording::command(["resume", name])));
    }
    blocks.push(PageBlock::Heading(file));
    blocks.push(PageBlock::Source(study.text().to_owned()));
    Ok(PageSection { id: "reproduce", title: "How to reproduce it", blocks })
}
