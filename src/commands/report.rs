//! `report`: one page of HTML that holds a study.
//!
//! The page names no store and no directory, so the same results give the same bytes wherever they
//! are kept. `rows` reads the jobs as a table, `pictures` draws the figures, `chosen` picks the
//! jobs whose fields the page has, `provenance` says what computed them, and `facts` says
//! everything else. `research_object` puts the page into an RO-Crate.

mod chosen;
mod facts;
mod pictures;
mod provenance;
mod research_object;
mod rows;
mod run_shares;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use answers::Results;
use anyhow::{Result, bail};
use report::{JobTable, Page, PageBlock, PageSection};
use serde::Serialize;

use crate::cli::{FieldChoice, ReportArgs};
use crate::output::{self, Finish};
use crate::stored_results::StoredResults;
use crate::words::count;
use crate::written_file;
use chosen::FieldsRoom;
use rows::JobRows;

/// The bytes that a page has, unless more fields are asked for by key.
const PAGE: usize = 2_900_000;

/// The end of the command.
#[derive(Serialize)]
struct WrittenPage {
    file: PathBuf,
    bytes: usize,
    /// The rows of the table of jobs.
    rows: usize,
    /// The jobs whose fields the page has.
    fields: Vec<String>,
    /// The sentences about what the page leaves out.
    left_out: Vec<String>,
}

/// The end of the command that writes an RO-Crate.
#[derive(Serialize)]
struct WrittenCrate<'a> {
    directory: &'a Path,
    /// The files in it.
    files: Vec<String>,
    /// The sentences about what it leaves out.
    left_out: Vec<String>,
}

/// A page about a study.
struct StudyPage {
    html: String,
    /// The rows of the table of jobs.
    rows: usize,
    /// The jobs whose fields the page has.
    fields: Vec<String>,
    /// The sentences about what the page leaves out.
    left_out: Vec<String>,
}

/// Writes the page of a study, or its RO-Crate.
pub(crate) fn report(args: &ReportArgs) -> Result<Finish> {
    match &args.research_object {
        Some(directory) => write_crate(args, directory),
        None => write_page(args),
    }
}

/// Writes the RO-Crate of a study.
fn write_crate(args: &ReportArgs, directory: &Path) -> Result<Finish> {
    research_object::check(directory)?;
    let stored = StoredResults::with_every_column(&args.store.store, &args.name)?;
    let results = stored.read()?;
    let page = page(args, &stored, &results)?;
    let statement =
        research_object::Statement { authors: &args.authors, license: args.license.as_deref() };
    let written = research_object::write(directory, &stored, &results, &page.html, &statement)?;
    let mut left_out = page.left_out;
    for sentence in written.left_out {
        if !left_out.contains(&sentence) {
            left_out.push(sentence);
        }
    }
    let written = WrittenCrate { directory, files: written.files, left_out };
    if args.json {
        return output::print_json(&written);
    }
    written.left_out.iter().for_each(|sentence| output::say(sentence));
    output::print(&format!("{}\n", directory.display()))
}

/// Writes the page of a study.
fn write_page(args: &ReportArgs) -> Result<Finish> {
    let file = args.output.clone().unwrap_or_else(|| usual_file(args));
    match args.output {
        Some(_) => written_file::check_regular(&file)?,
        None => written_file::check_own(&file)?,
    }
    let stored = StoredResults::with_every_column(&args.store.store, &args.name)?;
    let results = stored.read()?;
    let StudyPage { html, rows, fields, left_out } = page(args, &stored, &results)?;
    written_file::write(&file, html.as_bytes())?;
    let written = WrittenPage { file, bytes: html.len(), rows, fields, left_out };
    if args.json {
        return output::print_json(&written);
    }
    written.left_out.iter().for_each(|sentence| output::say(sentence));
    output::print(&format!("{}\n", written.file.display()))
}

/// Makes the page of a study.
fn page(args: &ReportArgs, stored: &StoredResults<'_>, results: &Results<'_>) -> Result<StudyPage> {
    // One file of fields that is lost must not take the whole page with it.
    let doubt = results.forgone_comparison().map(|error| {
        format!(
            "The points are not compared, and the columns and answers that come of it are \
             missing: {error:#}.",
            error = anyhow::Error::from(error)
        )
    });
    let filter = args.filter.as_deref();
    let rows = JobRows::read(results, filter)?;
    if rows.len() == 0 {
        bail!(
            "no job is left to report on; the condition `{}` holds for none",
            filter.unwrap_or_default()
        );
    }

    let mut left_out: Vec<String> = doubt.into_iter().collect();
    let table = rows.job_table()?;
    let mut page = Page {
        name: results.study().name().to_owned(),
        question: results.study().question().to_owned(),
        command: wording::command(words_of_page(args)),
        footer: "The page was written by `tribosweep report` from stored results. It holds \
                 everything that it shows and asks no other place for anything."
            .to_owned(),
        sections: facts::before(results, &rows, filter, &left_out)?,
    };
    page.sections[0].blocks.splice(0..0, facts::labels(stored.labels()));
    page.sections.push(pictures::section(results, &rows, table.keys(), filter, &mut left_out)?);
    page.sections.push(jobs_section(&rows, table.clone(), &mut left_out));
    let place = page.sections.len();
    page.sections.extend(facts::after(results, &rows, &words_with_fields(args))?);

    let room = FieldsRoom { bytes: PAGE.saturating_sub(page.html().len()), choice: &args.fields };
    let fields = chosen::fields(results, &rows, &room)?;
    left_out.extend(fields.left_out.clone());
    let keys = fields.keys.clone();
    page.sections.insert(place, fields.section(rows.len()));

    Ok(StudyPage { html: page.html(), rows: table.rows(), fields: keys, left_out })
}

/// Returns the name of the page unless another one is chosen.
fn usual_file(args: &ReportArgs) -> PathBuf {
    PathBuf::from(format!("{}.html", args.name))
}

/// Returns the words of the command that writes the page, but for the choice of fields. They name
/// no directory, since the page is the same wherever it is written.
fn words_of_page(args: &ReportArgs) -> Vec<OsString> {
    let mut words: Vec<OsString> = ["report".into(), args.name.clone().into()].to_vec();
    if let Some(filter) = &args.filter {
        words.extend(["--where".into(), filter.into()]);
    }
    let name = args.output.as_deref().and_then(Path::file_name);
    if let Some(name) = name.filter(|name| *name != usual_file(args).as_os_str()) {
        let file = wording::file_argument(Path::new(name)).into_owned();
        words.extend(["--output".into(), file]);
    }
    words
}

/// Returns the words of the command that writes the page.
fn words_with_fields(args: &ReportArgs) -> Vec<OsString> {
    let mut words = words_of_page(args);
    let choice = match &args.fields {
        Some(FieldChoice::Keys(beginnings)) => beginnings.join(","),
        Some(FieldChoice::Count(most)) => most.to_string(),
        None => return words,
    };
    words.extend(["--fields".into(), choice.into()]);
    words
}

/// Returns the section with the table of jobs.
fn jobs_section(rows: &JobRows<'_>, table: JobTable, left_out: &mut Vec<String>) -> PageSection {
    let mut blocks = vec![PageBlock::Words(
        "A click on the head of a column sorts, a click on a row chooses its job everywhere on \
         this page. Units are SI, as in `tribosweep query`."
            .to_owned(),
    )];
    let mut sentences = Vec::new();
    if table.rows() < rows.len() {
        sentences.push(format!(
            "The table has the first {} of {} rows; the page has no room for more.",
            table.rows(),
            rows.len()
        ));
    }
    let names: Vec<&str> = table.names().collect();
    let missing = rows.filled_columns().filter(|name| !names.contains(name)).count();
    if missing > 0 {
        sentences.push(format!(
            "The table lacks {}, for which the page has no room; `{}` lists all.",
            count(missing, "column", "columns"),
            wording::command(["query", &rows.study, "--columns"])
        ));
    }
    blocks.extend(sentences.iter().cloned().map(PageBlock::Words));
    left_out.extend(sentences);
    blocks.push(PageBlock::Jobs(table));
    PageSection { id: "jobs", title: "Jobs", blocks }
}
