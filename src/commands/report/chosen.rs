//! The jobs of a report whose fields are in the page.

use std::collections::BTreeSet;

use answers::{AnswerError, Results};
use anyhow::{Result, anyhow, bail};
use contact::model::Fields;
use identity::JobKey;
use report::{Cell, JobMaps, PageBlock, PageSection};
use study::{Figure, Record};

use super::rows::JobRows;
use crate::cli::FieldChoice;
use crate::fields::{page_fields, solution_fields};
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
    results: &Results<'_>,
    rows: &JobRows<'_>,
    room: &FieldsRoom<'_>,
) -> Result<ChosenFields> {
    let (wanted, bytes, is_asked) = match room.choice {
        Some(FieldChoice::Keys(beginnings)) => (found(rows, beginnings)?, MOST_BYTES, true),
        Some(FieldChoice::Count(most)) => (telling(rows, *most, *most)?, room.bytes, false),
        None => (telling(rows, MOST, FEW)?, room.bytes, false),
    };
    let mut chosen = ChosenFields::default();
    let (mut used, mut too_large) = (0, 0);
    for key in wanted {
        if chosen.keys.contains(&key) {
            continue;
        }
        let records = results.records_of(&key.parse::<JobKey>().into_iter().collect::<Vec<_>>())?;
        let Some(record) = records.values().next() else {
            bail!("job {key} has no result yet, and so no fields");
        };
        let read = match read_fields(results, record) {
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

/// Reads the fields of a record; of a search, those of the first solution.
fn read_fields(results: &Results<'_>, record: &Record) -> Result<Fields> {
    match record.multiplicity() {
        Some(found) => solution_fields(found, None),
        None => Ok(results.fields_of(record).map_err(AnswerError::Records)?),
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

/// Returns for each of some beginnings the only key that begins so.
fn found(rows: &JobRows<'_>, beginnings: &[String]) -> Result<Vec<String>> {
    // The number of keys that begin so, and one of them.
    let mut found: Vec<(usize, String)> = vec![(0, String::new()); beginnings.len()];
    rows.rows.visit(&["key"], &mut |first, block| {
        for (row, cells) in (first..).zip(block.rows()) {
            let [Cell::Text(key)] = &cells[..] else { continue };
            for (beginning, (count, one)) in beginnings.iter().zip(&mut found) {
                if rows.standings.is_first[row] && key.starts_with(beginning) {
                    *count += 1;
                    one.clone_from(key);
                }
            }
        }
        Ok::<bool, AnswerError>(true)
    })?;
    let only = |((count, key), beginning): ((usize, String), &String)| match count {
        0 => Err(anyhow!(
            "no job of the report has a key that begins with `{beginning}`; `{}` lists them",
            wording::command(["query", &rows.study, "--select", "key"])
        )),
        1 => Ok(key),
        _ => Err(anyhow!("{count} jobs have keys that begin with `{beginning}`; give more of it")),
    };
    found.into_iter().zip(beginnings).map(only).collect()
}

/// Chooses at most `most` of the jobs that have certified fields: the extremes of the figures, the
/// first and the last, then some evenly between them up to `few`. They are in the order of the
/// rows.
fn telling(rows: &JobRows<'_>, most: usize, few: usize) -> Result<Vec<String>> {
    let has_fields = rows.standings.has_fields.iter().enumerate();
    let candidates: Vec<usize> =
        has_fields.filter(|(_, has_fields)| **has_fields).map(|(row, _)| row).collect();
    let mut ranked: Vec<usize> = candidates.first().into_iter().copied().collect();
    ranked.extend(candidates.last());
    let figures = rows.results.figures().unwrap_or_default();
    for summary in figures.iter().flat_map(Figure::shown).filter_map(|name| rows.summary(name)) {
        // Of equal values the first counts, whether they are least or largest.
        let ends = [summary.with_fields.least, summary.with_fields.most];
        ranked.extend(ends.into_iter().flatten().map(|(row, _)| row));
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
    rows.keys(&chosen.into_iter().collect::<Vec<_>>())
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
