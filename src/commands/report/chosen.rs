//! The jobs of a report whose fields are in the page.

use std::collections::{BTreeSet, HashMap};

use answers::Results;
use anyhow::{Result, anyhow, bail};
use contact::model::Fields;
use report::{JobMaps, PageBlock, PageSection};
use store::StoreReader;
use study::{Figure, Record, StudyPoint};

use super::rows::JobRows;
use crate::cli::FieldChoice;
use crate::fields::{page_fields, solution_fields};
use crate::stored;
use crate::words::count;

/// The number of jobs that are chosen unless it is given: the first, the last, the extremes of the
/// figures, and some between them if these are few.
const MOST: usize = 12;
const FEW: usize = 6;
/// The bytes of fields that are asked for by key, so that a page can still be opened.
const MOST_BYTES: usize = 64_000_000;

/// The room for fields, and the jobs that are asked for.
pub(super) struct FieldsRoom<'a> {
    pub(super) bytes: usize,
    pub(super) choice: &'a Option<FieldChoice>,
}

/// The fields of some jobs.
#[derive(Default)]
pub(super) struct ChosenFields {
    maps: Vec<JobMaps>,
    pub(super) keys: Vec<String>,
    /// The sentences about jobs whose fields are not there.
    pub(super) left_out: Vec<String>,
}

/// Reads the fields of the jobs that are asked for, or of those that tell most, as far as there is
/// room.
pub(super) fn fields(
    reader: &StoreReader,
    results: &Results<'_>,
    rows: &JobRows<'_>,
    room: &FieldsRoom<'_>,
) -> Result<ChosenFields> {
    let points: HashMap<String, &StudyPoint> =
        results.points().iter().map(|point| (point.key.to_string(), point)).collect();
    let record = |key: &str| points.get(key).and_then(|point| results.record(point));
    let keys = rows.keys();
    let (wanted, bytes, is_asked) = match room.choice {
        Some(FieldChoice::Keys(beginnings)) => {
            let keys = beginnings
                .iter()
                .map(|beginning| found(&keys, beginning, &rows.study))
                .collect::<Result<Vec<_>>>()?;
            (keys, MOST_BYTES, true)
        }
        Some(FieldChoice::Count(most)) => (telling(rows, &record, *most, *most), room.bytes, false),
        None => (telling(rows, &record, MOST, FEW), room.bytes, false),
    };
    let mut chosen = ChosenFields::default();
    let (mut used, mut too_large) = (0, 0);
    for key in wanted {
        if chosen.keys.contains(&key) {
            continue;
        }
        let Some(record) = record(&key) else {
            bail!("job {key} has no result yet, and so no fields");
        };
        let read = match read_fields(reader, record) {
            Ok(read) => read,
            // What was asked for by name must be there; the rest of a page is worth having anyway.
            Err(error) if is_asked => return Err(error),
            Err(error) => {
                chosen.left_out.push(format!("Fields are missing: {error:#}."));
                continue;
            }
        };
        let maps = JobMaps::new(&key, &notes(record), &page_fields(&read)?);
        if used + maps.size() > bytes {
            too_large += 1;
            continue;
        }
        used += maps.size();
        chosen.maps.push(maps);
        chosen.keys.push(key);
    }
    if too_large > 0 {
        chosen.left_out.push(format!(
            "The page has no room for the fields of {}.",
            count(too_large, "more job", "more jobs")
        ));
    }
    Ok(chosen)
}

/// Says for each row whether its job has left fields.
pub(super) fn with_fields(results: &Results<'_>, rows: &JobRows<'_>) -> Vec<bool> {
    let fields: HashMap<String, bool> = results
        .points()
        .iter()
        .map(|point| (point.key.to_string(), results.record(point).is_some_and(leaves_fields)))
        .collect();
    rows.keys().into_iter().map(|key| fields.get(key).copied().unwrap_or(false)).collect()
}

/// Returns true if a record has fields: its own, or those of a solution that a search has found.
fn leaves_fields(record: &Record) -> bool {
    match record.multiplicity() {
        Some(found) => !found.solutions.is_empty(),
        None => record.fields.is_some(),
    }
}

/// Reads the fields of a record; of a search, those of the first solution.
fn read_fields(reader: &StoreReader, record: &Record) -> Result<Fields> {
    match record.multiplicity() {
        Some(found) => solution_fields(found, None),
        None => stored::fields(reader.blobs(), record),
    }
}

/// Returns the sentences above the maps of a record.
fn notes(record: &Record) -> Vec<String> {
    let mut notes = Vec::new();
    if !record.is_certified() {
        notes.push(
            "The job is not certified: the fields are those of the last iterate, which is no \
             solution."
                .to_owned(),
        );
    }
    match record.multiplicity().map_or(0, |found| found.solutions.len()) {
        0 | 1 => {}
        n => notes.push(format!("The maps are of the first of {n} solutions that were found.")),
    }
    notes
}

/// Returns the only key that begins with some characters.
fn found(keys: &[&str], beginning: &str, study: &str) -> Result<String> {
    let matching: BTreeSet<&str> =
        keys.iter().copied().filter(|key| key.starts_with(beginning)).collect();
    let mut matching = matching.into_iter();
    match (matching.next(), matching.len()) {
        (Some(key), 0) => Ok(key.to_owned()),
        (None, _) => Err(anyhow!(
            "no job of the report has a key that begins with `{beginning}`; `{}` lists them",
            wording::command(["query", study, "--select", "key"])
        )),
        (_, more) => Err(anyhow!(
            "{} jobs have keys that begin with `{beginning}`; give more of it",
            more + 1
        )),
    }
}

/// Chooses at most `most` of the jobs that have certified fields: the extremes of the figures, the
/// first and the last, then some evenly between them up to `few`. They are in the order of the
/// rows.
fn telling<'a>(
    rows: &JobRows<'_>,
    record: &impl Fn(&str) -> Option<&'a Record>,
    most: usize,
    few: usize,
) -> Vec<String> {
    let keys = rows.keys();
    let has_fields = |row: &usize| {
        record(keys[*row]).is_some_and(|record| record.is_certified() && leaves_fields(record))
    };
    let mut seen = BTreeSet::new();
    let candidates: Vec<usize> =
        (0..keys.len()).filter(|row| has_fields(row) && seen.insert(keys[*row])).collect();
    let mut ranked: Vec<usize> = candidates.first().into_iter().copied().collect();
    ranked.extend(candidates.last());
    let figures = rows.results.figures().unwrap_or_default();
    let is_candidate: BTreeSet<usize> = candidates.iter().copied().collect();
    for name in figures.iter().flat_map(Figure::shown) {
        let numbers: Vec<(usize, f64)> =
            rows.numbers(name).into_iter().filter(|(row, _)| is_candidate.contains(row)).collect();
        let by_value = |a: &&(usize, f64), b: &&(usize, f64)| a.1.total_cmp(&b.1);
        // Of equal values the first counts, whether they are least or largest.
        ranked.extend(numbers.iter().min_by(by_value).map(|(row, _)| *row));
        ranked.extend(numbers.iter().rev().max_by(by_value).map(|(row, _)| *row));
    }
    let between = few.min(candidates.len());
    ranked.extend(
        (0..between).map(|i| {
            candidates[(i * (candidates.len() - 1)).checked_div(between - 1).unwrap_or(0)]
        }),
    );
    let mut chosen = BTreeSet::new();
    for row in ranked {
        let is_extra = chosen.len() >= few.max(2 * figures.len() + 2);
        if chosen.len() < most && !is_extra {
            chosen.insert(row);
        }
    }
    chosen.into_iter().map(|row| keys[row].to_owned()).collect()
}

impl ChosenFields {
    /// Returns the section about one job, of a page with so many rows.
    pub(super) fn section(self, rows: usize) -> PageSection {
        let keys: Vec<&str> = self.keys.iter().map(|key| key.get(..8).unwrap_or(key)).collect();
        let with = if keys.is_empty() { String::new() } else { format!(" ({})", keys.join(", ")) };
        let mut blocks = vec![PageBlock::Words(format!(
            "The job that is chosen in a figure or in the table is shown here. The page has the \
             fields of {} of {}{with}; for another job the command that adds its fields is shown.",
            keys.len(),
            count(rows, "row", "rows")
        ))];
        blocks.extend(self.left_out.into_iter().map(PageBlock::Words));
        blocks.push(PageBlock::Maps(self.maps));
        PageSection { id: "job", title: "One job", blocks }
    }
}
