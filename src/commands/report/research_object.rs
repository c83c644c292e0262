//! A study as an RO-Crate 1.1: a directory with its file, its inputs, its results, its figures and
//! its page, and a description of all of them and of the runs for machines to read.
//!
//! The specification is at <https://w3id.org/ro/crate/1.1>. The directory takes its place when it
//! is whole. Nothing in it depends on the time or the place of writing.

use std::borrow::Cow;
use std::fs::{self, File, Permissions};
use std::io::ErrorKind;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use answers::{ComputingRun, Results, Selection};
use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use study::account::{ProgramBuild, RunAccount, run_name};

use super::rows::RowStandings;
use super::run_shares::RunShares;
use crate::account::{command_words, program_words};
use crate::citation_text::{REPOSITORY, ReferenceList};
use crate::figures::draw;
use crate::frozen_study;
use crate::machine::this_program;
use crate::stored_results::StoredResults;
use crate::table_file::{TableRows, write_csv, write_parquet};
use crate::words::{count, time_words};

/// The description of an RO-Crate.
const METADATA: &str = "ro-crate-metadata.json";

/// The words in place of a licence that nobody has stated.
const NO_LICENSE: &str = "No licence is stated; ask the authors before you use it.";

/// The directory of the study file and of the files that it names.
const STUDY: &str = "study";

/// The place of files that the study names by absolute paths, in that directory.
const FIXED: &str = "fixed";

/// The people and the licence that are stated for an RO-Crate.
pub(super) struct Statement<'a> {
    /// The authors, each as a name with an ORCID after a comma, or without.
    pub(super) authors: &'a [String],
    /// The address of the licence.
    pub(super) license: Option<&'a str>,
}

/// Refuses a place where no directory can be made, before anything is read.
pub(super) fn check(directory: &Path) -> Result<()> {
    match fs::read_dir(directory) {
        Ok(mut entries) => {
            if entries.next().is_some() {
                bail!("{} is not empty; name a directory that is not there", directory.display());
            }
        }
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let above = above(directory);
            if !above.is_dir() {
                bail!(
                    "cannot write {}: there is no directory {}",
                    directory.display(),
                    above.display()
                );
            }
        }
        Err(_) => bail!(
            "{} is something else than a directory; name one that is not there",
            directory.display()
        ),
    }
    Ok(())
}

fn above(directory: &Path) -> &Path {
    match directory.parent() {
        Some(above) if above != Path::new("") => above,
        _ => Path::new("."),
    }
}

/// Writes the RO-Crate of a study with its page, and returns the names of its files and the
/// sentences about what it leaves out.
pub(super) fn write(
    directory: &Path,
    stored: &StoredResults<'_>,
    results: &Results<'_>,
    page: &str,
    statement: &Statement<'_>,
) -> Result<CrateFiles> {
    let unwritten = || format!("cannot write {}", directory.display());
    let unfinished = tempfile::Builder::new()
        .prefix(".unfinished-")
        // The umask is subtracted, as for any directory.
        .permissions(Permissions::from_mode(0o777))
        .tempdir_in(above(directory))
        .with_context(unwritten)?;
    let mut contents =
        Contents { root: unfinished.path(), parts: Vec::new(), left_out: Vec::new() };
    contents.add_study(results)?;
    contents.add_results(stored, results)?;
    contents.add_figures(results);
    contents.add_text("report.html", "text/html", "The page of the study", page)?;
    let references = ReferenceList::of_results(results)?;
    contents.add_text(
        "references.bib",
        "application/x-bibtex",
        "The references of the method and of the effects that the study uses",
        &references.bibtex(),
    )?;
    let shares = RowStandings::of(results, &results.rows(None)?)?.shares;
    let description =
        serde_json::to_string_pretty(&contents.description(results, &shares, statement))?;
    fs::write(contents.root.join(METADATA), description + "\n").with_context(unwritten)?;
    let mut files: Vec<String> = contents.parts.iter().map(|part| part.path.clone()).collect();
    files.push(METADATA.to_owned());
    files.sort();
    let left_out = contents.left_out;
    let settled = || -> std::io::Result<()> {
        make_durable(unfinished.path())?;
        fs::rename(unfinished.path(), directory)?;
        File::open(above(directory))?.sync_all()
    };
    settled().with_context(unwritten)?;
    // It has another name now, under which it stays.
    let _ = unfinished.keep();
    Ok(CrateFiles { files, left_out })
}

/// The files of an RO-Crate that was written.
pub(super) struct CrateFiles {
    /// The paths in the directory.
    pub(super) files: Vec<String>,
    /// The sentences about what is missing.
    pub(super) left_out: Vec<String>,
}

/// A file of an RO-Crate.
struct CratePart {
    path: String,
    format: &'static str,
    name: String,
    bytes: u64,
    role: PartRole,
}

/// The part that a file plays in the runs.
#[derive(Clone, Copy, PartialEq, Eq)]
enum PartRole {
    /// A run has read it.
    Input,
    /// It holds what the runs computed.
    Result,
    /// It was made of the results.
    Product,
}

/// An RO-Crate that is being written.
struct Contents<'d> {
    root: &'d Path,
    parts: Vec<CratePart>,
    left_out: Vec<String>,
}

impl Contents<'_> {
    /// Notes a file that was written.
    fn note(
        &mut self,
        path: &Path,
        format: &'static str,
        name: String,
        role: PartRole,
    ) -> Result<()> {
        let bytes = fs::metadata(self.root.join(path))?.len();
        let path = path.to_str().context("the name of a file is no text")?.to_owned();
        self.parts.push(CratePart { path, format, name, bytes, role });
        Ok(())
    }

    fn add_text(&mut self, path: &str, format: &'static str, name: &str, text: &str) -> Result<()> {
        fs::write(self.root.join(path), text)?;
        self.note(Path::new(path), format, name.to_owned(), PartRole::Product)
    }

    /// Adds the study file, and the files that it names.
    fn add_study(&mut self, results: &Results<'_>) -> Result<()> {
        let study = results.study();
        let place = self.root.join(STUDY);
        frozen_study::freeze(study, &place)?;
        let file = Path::new(STUDY).join(frozen_study::place(study));
        let name = format!("The study file: {}", study.question());
        self.note(&file, "application/toml", name, PartRole::Input)?;
        let beside = file.parent().unwrap_or(Path::new(STUDY)).to_owned();
        for (name, bytes) in study.named_files() {
            let path = if Path::new(name).is_absolute() {
                let file = Path::new(name).file_name().unwrap_or_default();
                let digest = store::Digest::of(bytes).to_string();
                let path = Path::new(STUDY).join(FIXED).join(&digest[..12]).join(file);
                let place = self.root.join(&path);
                fs::create_dir_all(place.parent().unwrap_or(self.root))?;
                fs::write(&place, bytes)?;
                path
            } else {
                normal(&beside.join(name))
            };
            let name = format!("The file that the study names {name}");
            self.note(&path, format_of(&path), name, PartRole::Input)?;
        }
        Ok(())
    }

    /// Adds every column of every point as Parquet and as CSV, and every increment if there are
    /// paths of several.
    fn add_results(&mut self, stored: &StoredResults<'_>, results: &Results<'_>) -> Result<()> {
        let mut tables = vec![("results", "Every point", false)];
        if results.have_paths() {
            tables.push(("increments", "Every increment of every loading path", true));
        }
        for (stem, what, steps) in tables {
            let mut selection = Selection { steps, ..Selection::default() };
            let all = selection.all_columns(results.study()).into_iter();
            selection.columns = all.map(|column| column.name.into_owned()).collect();
            let study = results.study();
            let rows = match study.has_independent_points() {
                // They are the same whether they come of a table or of records.
                true => TableRows::Selected {
                    selection: &selection,
                    study,
                    source: stored.rows_of(&selection),
                },
                false => TableRows::Whole {
                    table: selection.of(results)?,
                    accounts: Cow::Borrowed(results.accounts()),
                },
            };
            let columns = selection.typed_columns(results.study())?;
            let [parquet, csv] =
                ["parquet", "csv"].map(|end| PathBuf::from(format!("{stem}.{end}")));
            write_parquet(&rows, columns, &self.root.join(&parquet))?;
            write_csv(&rows, Some(&self.root.join(&csv)))?;
            let name = format!("{what} with every column, its unit and its meaning");
            self.note(&parquet, "application/vnd.apache.parquet", name, PartRole::Result)?;
            let name = format!("{what} with every column, as text in SI units");
            self.note(&csv, "text/csv", name, PartRole::Result)?;
        }
        Ok(())
    }

    /// Adds the figures. One that cannot be drawn hinders no other.
    fn add_figures(&mut self, results: &Results<'_>) {
        let drawn = |contents: &mut Self, figure: &study::Figure| -> Result<()> {
            let path =
                Path::new("figures").join(format!("{}.svg", figure.stem(results.study().name())));
            fs::create_dir_all(contents.root.join("figures"))?;
            draw(results, figure, None, &[contents.root.join(&path)])?;
            let title = figure.title.as_deref().unwrap_or(results.study().question());
            contents.note(&path, "image/svg+xml", title.to_owned(), PartRole::Product)
        };
        let figures = results.figures().map(<[_]>::to_vec).unwrap_or_default();
        for figure in &figures {
            if let Err(error) = drawn(self, figure) {
                let sentence = format!("The figure {} is missing: {error:#}.", figure.name);
                self.left_out.push(sentence);
            }
        }
    }

    /// Returns the description of everything.
    fn description(
        &self,
        results: &Results<'_>,
        shares: &RunShares,
        statement: &Statement<'_>,
    ) -> Value {
        let study = results.study();
        let runs = shares.runs(results);
        let parts = |role: PartRole| -> Vec<Value> {
            self.parts.iter().filter(|part| part.role == role).map(|part| id(&part.path)).collect()
        };
        let all: Vec<Value> = self.parts.iter().map(|part| id(&part.path)).collect();
        let mut graph = vec![json!({
            "@id": METADATA,
            "@type": "CreativeWork",
            "conformsTo": { "@id": "https://w3id.org/ro/crate/1.1" },
            "about": { "@id": "./" },
        })];
        let mut programs: Vec<ProgramBuild> = vec![this_program()];
        let mut actions = Vec::new();
        for (run, digest) in runs.iter().filter_map(|run| Some((run, run.digest?))) {
            let Some(account) = run.account else { continue };
            if !programs.contains(&account.program) {
                programs.push(account.program.clone());
            }
            let mut action = action(run, account, &digest, &shares.last_finished(Some(&digest)));
            action["object"] = parts(PartRole::Input).into();
            action["result"] = parts(PartRole::Result).into();
            actions.push(action);
        }
        actions.push(json!({
            "@id": "#report",
            "@type": "CreateAction",
            "name": "tribosweep report: the page, the figures and the tables of stored results",
            "instrument": { "@id": program_id(&this_program()) },
            "object": parts(PartRole::Result),
            "result": parts(PartRole::Product),
        }));
        let progress = results.progress();
        let question = match study.question() {
            "" => study.name(),
            question => question,
        };
        let mut root = json!({
            "@id": "./",
            "@type": "Dataset",
            "name": study.name(),
            "description": format!(
                "{question} A parameter study of elastic contact with friction: {} of {} solved and \
                 certified.",
                progress.done,
                count(progress.points, "point", "points")
            ),
            "datePublished": shares.last_finished(None),
            "hasPart": all,
            "mentions": actions.iter().map(|action| json!({ "@id": action["@id"] }))
                .collect::<Vec<_>>(),
        });
        let people = people(statement.authors);
        if !people.is_empty() {
            root["author"] = people.iter().map(|person| json!({ "@id": person["@id"] })).collect();
        }
        // The format demands one, if only in words.
        root["license"] = match statement.license {
            Some(license) => json!({ "@id": license }),
            None => json!(NO_LICENSE),
        };
        graph.push(root);
        graph.extend(self.parts.iter().map(|part| {
            json!({
                "@id": encoded(&part.path),
                "@type": "File",
                "name": part.name,
                "encodingFormat": part.format,
                "contentSize": part.bytes.to_string(),
            })
        }));
        graph.extend(actions);
        graph.extend(programs.iter().map(|program| {
            json!({
                "@id": program_id(program),
                "@type": "SoftwareApplication",
                "name": "tribosweep",
                "description": program_words(program),
                "softwareVersion": program.version,
                "version": program.commit.as_deref().unwrap_or(&program.version),
                "url": REPOSITORY,
            })
        }));
        graph.extend(people);
        if let Some(license) = statement.license {
            graph.push(json!({ "@id": license, "@type": "CreativeWork", "name": license }));
        }
        json!({ "@context": "https://w3id.org/ro/crate/1.1/context", "@graph": graph })
    }
}

/// Returns a run as the action that created the results.
fn action(run: &ComputingRun<'_>, account: &RunAccount, digest: &[u8; 32], ended: &str) -> Value {
    let RunAccount { program, machine, command, started, .. } = account;
    json!({
        "@id": format!("#run-{}", run_name(digest)),
        "@type": "CreateAction",
        "name": command_words(command),
        "description": format!(
            "Computed {} on {}: {}, {}, {}.",
            count(run.records, "job", "jobs"),
            machine.host,
            machine.processor,
            count(machine.cores as usize, "core", "cores"),
            machine.system
        ),
        "startTime": time_words(*started),
        "endTime": ended,
        "instrument": { "@id": program_id(program) },
    })
}

/// Returns the name of a program in the description.
fn program_id(program: &ProgramBuild) -> String {
    let commit = program.short_commit().map_or(String::new(), |commit| format!("-{commit}"));
    format!("#tribosweep-{}{commit}", encoded(&program.version))
}

/// Returns the authors as people; one whose ORCID is stated is named by it.
fn people(authors: &[String]) -> Vec<Value> {
    let person = |(number, author): (usize, &String)| {
        let stated = author.rsplit_once(',').map(|(name, orcid)| (name.trim(), orcid.trim()));
        let (name, id) = match stated.filter(|(_, orcid)| orcid.starts_with("https://orcid.org/")) {
            Some((name, orcid)) => (name, orcid.to_owned()),
            None => (author.trim(), format!("#author-{}", number + 1)),
        };
        json!({ "@id": id, "@type": "Person", "name": name })
    };
    authors.iter().enumerate().map(person).collect()
}

fn id(path: &str) -> Value {
    json!({ "@id": encoded(path) })
}

/// Returns a path as part of an address, with everything escaped that may not stand there.
fn encoded(path: &str) -> String {
    let byte = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
            char::from(byte).to_string()
        }
        _ => format!("%{byte:02X}"),
    };
    path.bytes().map(byte).collect()
}

/// Returns a path without `.` and `..`.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            std::path::Component::ParentDir => drop(normal.pop()),
            std::path::Component::CurDir => {}
            other => normal.push(other),
        }
    }
    normal
}

/// Returns the media type of an input.
fn format_of(path: &Path) -> &'static str {
    match path.extension().and_then(|end| end.to_str()) {
        Some("csv") => "text/csv",
        Some("npy") => "application/octet-stream",
        _ => "text/plain",
    }
}

/// Brings a directory and everything in it to the disk.
fn make_durable(directory: &Path) -> std::io::Result<()> {
    for entry in fs::read_dir(directory)? {
        let path = entry?.path();
        match path.is_dir() {
            true => make_durable(&path)?,
            false => File::open(&path)?.sync_all()?,
        }
    }
    File::open(directory)?.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_escaped_and_made_normal() {
        assert_eq!(encoded("a b/µ%.csv"), "a%20b/%C2%B5%25.csv");
        assert_eq!(normal(Path::new("study/in/./../maps/a.npy")), Path::new("study/maps/a.npy"));
    }

    #[test]
    fn people_are_named_by_their_orcid_or_by_number() {
        let people =
            people(&["A. Person, https://orcid.org/0000-0001".to_owned(), "Person, B.".to_owned()]);
        assert_eq!(people[0]["@id"], "https://orcid.org/0000-0001");
        assert_eq!(people[0]["name"], "A. Person");
        assert_eq!(
            (&people[1]["@id"], &people[1]["name"]),
            (&json!("#author-2"), &json!("Person, B."))
        );
    }
}
