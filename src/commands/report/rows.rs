//! The jobs of a report: what it says of their columns, each of which passes by once.

use std::collections::{HashMap, HashSet};

use answers::{AnswerError, Results, StudyRows};
use anyhow::Result;
use identity::JobKey;
use report::{Cell, ColumnRoom, DataTable, FittedTable, JobColumn, JobTable, TableError};
use study::columns::Role;
use study::provenance::median;
use study::{Column, Figure};

use super::run_shares::RunShares;

/// The bytes of the table of jobs in a page.
const TABLE: usize = 1_300_000;

/// The most rows of a table that is not the table of jobs.
pub(super) const MOST_ROWS: usize = 200;

/// A row with the number that it has in a column.
type RowNumber = (usize, f64);

/// The jobs that a report is about.
pub(super) struct JobRows<'r> {
    pub(super) study: String,
    pub(super) results: &'r Results<'r>,
    pub(super) rows: StudyRows<'r>,
    /// The standing of the jobs.
    pub(super) standings: RowStandings,
    summaries: HashMap<String, ColumnSummary>,
    usual: Vec<String>,
}

/// The rows of jobs by how these have ended.
pub(super) struct RowStandings {
    /// The job of the row is that of no row before.
    pub(super) is_first: Vec<bool>,
    /// The row is the first of a job that is solved and has left fields.
    pub(super) has_fields: Vec<bool>,
    /// The number of rows whose jobs have failed, and the first of these.
    pub(super) failed: usize,
    pub(super) first_failed: Vec<usize>,
    /// The runs that computed the results, each of which counts once.
    pub(super) shares: RunShares,
    /// Half of each job's digest, which tells as many jobs apart as a store has.
    seen: HashSet<u128>,
}

impl RowStandings {
    /// The columns that tell of them.
    const COLUMNS: [&str; 2] = ["key", "status"];

    /// Reads how the jobs of some rows have ended.
    pub(super) fn of(results: &Results<'_>, rows: &StudyRows<'_>) -> Result<Self> {
        let mut standings = Self::of_none(results);
        let names = [&Self::COLUMNS[..], &RunShares::COLUMNS].concat();
        rows.visit(&names, &mut |first, block| {
            standings.add(results, first, block).map(|()| true)
        })?;
        standings.seen = HashSet::new();
        Ok(standings)
    }

    fn of_none(results: &Results<'_>) -> Self {
        Self {
            is_first: Vec::new(),
            has_fields: Vec::new(),
            failed: 0,
            first_failed: Vec::new(),
            shares: RunShares::of_none(results),
            seen: HashSet::new(),
        }
    }

    /// Adds the next rows, of which the first has a number.
    fn add(
        &mut self,
        results: &Results<'_>,
        first: usize,
        block: &DataTable,
    ) -> Result<(), AnswerError> {
        let column = |name: &str| block.column(name).map_err(TableError::from);
        let [key, status] = [column(Self::COLUMNS[0])?, column(Self::COLUMNS[1])?];
        let of_run: Vec<usize> =
            RunShares::COLUMNS.into_iter().map(column).collect::<Result<_, _>>()?;
        let mut solved = Vec::new();
        for (row, cells) in (first..).zip(block.rows()) {
            let key = key_of(&cells[key]);
            let is_first = key.is_none_or(|key| self.seen.insert(key.half()));
            self.is_first.push(is_first);
            self.has_fields.push(false);
            let Cell::Text(status) = &cells[status] else { continue };
            match status.as_str() {
                "certified" => solved.extend(key.filter(|_| is_first).map(|key| (row, key))),
                _ => {
                    self.failed += 1;
                    if self.first_failed.len() < MOST_ROWS {
                        self.first_failed.push(row);
                    }
                }
            }
            if let [run, worker, program, finished] = of_run[..]
                && is_first
            {
                self.shares.add([run, worker, program, finished].map(|column| &cells[column]));
            }
        }
        let keys: Vec<JobKey> = solved.iter().map(|(_, key)| *key).collect();
        let have_fields = match results.all_have_fields() {
            true => vec![true; keys.len()],
            false => results.have_fields(&keys)?,
        };
        for ((row, _), has_fields) in solved.iter().zip(have_fields) {
            self.has_fields[*row] = has_fields;
        }
        Ok(())
    }
}

/// Returns the key of a job in a cell.
fn key_of(cell: &Cell) -> Option<JobKey> {
    if let Cell::Text(key) = cell { key.parse().ok() } else { None }
}

/// The finite numbers of a column, or of some rows of it.
#[derive(Default)]
pub(super) struct NumberSummary {
    pub(super) count: usize,
    pub(super) sum: f64,
    /// The first of the least numbers, of the greatest, and of those farthest from 0.
    pub(super) least: Option<RowNumber>,
    pub(super) most: Option<RowNumber>,
    pub(super) largest: Option<RowNumber>,
}

impl NumberSummary {
    fn add(&mut self, row: usize, x: f64) {
        self.count += 1;
        self.sum += x;
        if self.least.is_none_or(|(_, least)| x.total_cmp(&least).is_lt()) {
            self.least = Some((row, x));
        }
        if self.most.is_none_or(|(_, most)| x.total_cmp(&most).is_gt()) {
            self.most = Some((row, x));
        }
        if self.largest.is_none_or(|(_, largest)| x.abs().total_cmp(&largest.abs()).is_gt()) {
            self.largest = Some((row, x));
        }
    }
}

/// The summary of a column.
#[derive(Default)]
pub(super) struct ColumnSummary {
    room: ColumnRoom,
    /// The numbers of all rows.
    pub(super) all: NumberSummary,
    /// The numbers of the first rows of jobs: what several points share was computed once.
    pub(super) of_jobs: NumberSummary,
    /// The numbers of the rows whose fields can be shown.
    pub(super) with_fields: NumberSummary,
    /// The median: of the magnitudes of estimated errors, and of work and times of jobs.
    pub(super) median: Option<f64>,
    /// The numbers, as long as they are needed for the median.
    numbers: Vec<f64>,
}

/// The part of a column that a report needs.
#[derive(Clone, Copy)]
struct ColumnNeeds {
    /// The room that it takes in the page.
    room: bool,
    /// The extreme numbers.
    extremes: bool,
    /// The median of the magnitudes of all numbers.
    magnitudes: bool,
    /// The median of the numbers of jobs.
    work: bool,
}

impl ColumnNeeds {
    fn are_numbers(self) -> bool {
        self.extremes || self.magnitudes || self.work
    }
}

impl ColumnSummary {
    fn add(&mut self, needs: ColumnNeeds, standings: &RowStandings, row: usize, cell: &Cell) {
        if needs.room || !self.room.is_filled() {
            self.room.add(cell);
        }
        if !needs.are_numbers() {
            return;
        }
        let Some(x) = cell.number().filter(|x| x.is_finite()) else { return };
        self.all.add(row, x);
        if standings.is_first[row] {
            self.of_jobs.add(row, x);
        }
        if standings.has_fields[row] {
            self.with_fields.add(row, x);
        }
        if needs.magnitudes {
            self.numbers.push(x.abs());
        } else if needs.work && standings.is_first[row] {
            self.numbers.push(x);
        }
    }

    fn end(&mut self) {
        let numbers = std::mem::take(&mut self.numbers);
        self.median = (!numbers.is_empty()).then(|| median(numbers));
    }
}

/// A column with what a report needs of it.
type NeededColumn<'c> = (&'c str, ColumnNeeds);

impl<'r> JobRows<'r> {
    /// Reads the jobs for which a filter holds: the columns one after the other, or all at once
    /// where the rows are made anew for each.
    pub(super) fn read(results: &'r Results<'r>, filter: Option<&str>) -> Result<Self> {
        let rows = results.rows(filter)?;
        let usual = results.usual_columns(false)?;
        let columns = needed_columns(results, &rows, &usual)?;
        let (standings, summaries) = if rows.are_made_anew() {
            let mut standings = RowStandings::of_none(results);
            let summaries = summaries(&rows, &columns, |first, block, made| {
                standings.add(results, first, block)?;
                add_block(&columns, &standings, first, block, made);
                Ok(true)
            })?;
            (standings, summaries.into_iter().collect())
        } else {
            let standings = RowStandings::of(results, &rows)?;
            let mut all = HashMap::new();
            for column in &columns {
                let column = std::slice::from_ref(column);
                all.extend(summaries(&rows, column, |first, block, made| {
                    Ok(add_block(column, &standings, first, block, made))
                })?);
            }
            (standings, all)
        };
        drop(columns);
        let study = results.study().name().to_owned();
        Ok(Self { study, results, rows, standings, summaries, usual })
    }

    /// Returns the number of rows.
    pub(super) fn len(&self) -> usize {
        self.rows.count()
    }

    /// Returns the columns that there are.
    pub(super) fn columns(&self) -> &[Column] {
        self.rows.columns()
    }

    /// Returns the summary of a column, if there is one with the name.
    pub(super) fn summary(&self, name: &str) -> Option<&ColumnSummary> {
        self.summaries.get(name)
    }

    /// Iterates over the columns of a role.
    pub(super) fn of_role(&self, role: Role) -> impl Iterator<Item = &Column> {
        self.columns().iter().filter(move |column| column.role == role)
    }

    /// Returns the names of the axes.
    pub(super) fn axes(&self) -> Vec<&str> {
        self.of_role(Role::Axis).map(|column| column.name.as_ref()).collect()
    }

    /// Returns the keys of the jobs in some rows, whose numbers ascend.
    pub(super) fn keys(&self, rows: &[usize]) -> Result<Vec<String>> {
        let text = |row: &Vec<Cell>| match &row[..] {
            [Cell::Text(key)] => key.clone(),
            _ => String::new(),
        };
        Ok(self.rows.at(&["key"], rows)?.rows().iter().map(text).collect())
    }

    /// Returns the values of the axes in a row, in words.
    pub(super) fn place(&self, row: usize) -> Result<String> {
        let words = |(column, cell): (&Column, &Cell)| {
            let text = match cell {
                Cell::Number(x) => report::quantity_words(*x, column.unit()),
                Cell::Integer(i) => i.to_string(),
                Cell::Flag(yes) => yes.to_string(),
                Cell::Text(text) => text.clone(),
                Cell::Missing => return None,
            };
            Some(format!("{} = {text}", column.name))
        };
        let cells = self.rows.at(&self.axes(), &[row])?;
        let cells = cells.rows().iter().flatten();
        Ok(self.of_role(Role::Axis).zip(cells).filter_map(words).collect::<Vec<_>>().join(", "))
    }

    /// Returns the columns that have a value in some row, except for the key.
    pub(super) fn filled_columns(&self) -> impl Iterator<Item = &str> {
        let is_filled = |name: &&str| {
            *name != "key" && self.summary(name).is_some_and(|summary| summary.room.is_filled())
        };
        self.columns().iter().map(|column| column.name.as_ref()).filter(is_filled)
    }

    /// Returns the table of jobs in the page, as far as there is room for it.
    pub(super) fn job_table(&self) -> Result<JobTable> {
        let room = |column: &JobColumn| {
            self.summary(&column.name).map(|summary| summary.room.clone()).unwrap_or_default()
        };
        let columns: Vec<(JobColumn, ColumnRoom)> = self
            .job_columns()
            .into_iter()
            .map(|column| {
                let room = room(&column);
                (column, room)
            })
            .collect();
        let FittedTable { columns, rows } = FittedTable::of(columns, self.len(), TABLE);
        let names: Vec<&str> =
            columns.iter().map(|column| column.name.as_str()).chain(["key"]).collect();
        let table: DataTable = self.rows.at(&names, &(0..rows).collect::<Vec<_>>())?;
        let table = JobTable::of_rows(&table, columns)?;
        // What is known already takes no record, for these take time and memory to open.
        let has_fields = |row: usize| self.standings.has_fields.get(row) == Some(&true);
        let keys = table.keys().iter().enumerate().filter(|(row, _)| !has_fields(*row));
        let unknown: Vec<(usize, JobKey)> =
            keys.filter_map(|(row, key)| Some((row, key.parse().ok()?))).collect();
        let keys: Vec<JobKey> = unknown.iter().map(|(_, key)| *key).collect();
        let have_fields = match keys.is_empty() {
            true => Vec::new(),
            false => self.results.have_fields(&keys)?,
        };
        let others = unknown.iter().zip(have_fields).filter(|(_, has_fields)| *has_fields);
        let others: HashSet<usize> = others.map(|((row, _), _)| *row).collect();
        Ok(table.with_fields(|row| has_fields(row) || others.contains(&row)))
    }

    /// Returns the columns of the table in the page: those that answer the question first.
    fn job_columns(&self) -> Vec<JobColumn> {
        let usual = &self.usual;
        let group = |role: Role| match role {
            Role::Axis => "axis",
            Role::Key => "setting",
            Role::Status => "status",
            Role::Place => "place",
            Role::Observable => "observable",
            Role::Certificate => "certificate",
            Role::Error => "estimated error",
            Role::Work => "work",
            Role::Provenance => "provenance",
        };
        let column = |column: &Column| JobColumn {
            name: column.name.to_string(),
            group: group(column.role),
            meaning: column.meaning.to_owned(),
            is_shown: usual.iter().any(|name| *name == column.name) && column.name != "key",
        };
        let mut columns: Vec<JobColumn> =
            self.columns().iter().filter(|column| column.name != "key").map(column).collect();
        let rank = |column: &JobColumn| {
            usual.iter().position(|name| *name == column.name).unwrap_or(usize::MAX)
        };
        columns.sort_by_key(rank);
        columns
    }
}

/// Returns every column with what a report needs of it.
fn needed_columns<'c>(
    results: &Results<'_>,
    rows: &'c StudyRows<'_>,
    usual: &[String],
) -> Result<Vec<NeededColumn<'c>>> {
    let of_figures: Vec<&String> = results.figures()?.iter().flat_map(Figure::shown).collect();
    let is_full = FittedTable::is_full(rows.count(), TABLE);
    let needs = |column: &Column| ColumnNeeds {
        room: !is_full || usual.iter().any(|name| *name == column.name),
        extremes: column.role == Role::Certificate
            || of_figures.iter().any(|name| **name == column.name),
        magnitudes: column.role == Role::Error,
        work: column.role == Role::Work || column.name == "seconds",
    };
    Ok(rows.columns().iter().map(|column| (column.name.as_ref(), needs(column))).collect())
}

/// Summarises some columns of rows, whose blocks are added to the summaries until that is enough.
fn summaries<F>(
    rows: &StudyRows<'_>,
    columns: &[NeededColumn<'_>],
    mut add: F,
) -> Result<Vec<(String, ColumnSummary)>>
where
    F: FnMut(usize, &DataTable, &mut [ColumnSummary]) -> Result<bool, AnswerError>,
{
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let mut made: Vec<ColumnSummary> = columns.iter().map(|_| ColumnSummary::default()).collect();
    rows.visit(&names, &mut |first, block| add(first, block, &mut made))?;
    made.iter_mut().for_each(ColumnSummary::end);
    Ok(names.into_iter().map(str::to_owned).zip(made).collect())
}

/// Adds a block of rows to the summaries of its columns, and returns whether these need more rows.
fn add_block(
    columns: &[NeededColumn<'_>],
    standings: &RowStandings,
    first: usize,
    block: &DataTable,
    made: &mut [ColumnSummary],
) -> bool {
    let mut needs_more = false;
    for (index, (summary, (_, needs))) in made.iter_mut().zip(columns).enumerate() {
        for (row, cells) in (first..).zip(block.rows()) {
            summary.add(*needs, standings, row, &cells[index]);
        }
        needs_more |= needs.room || needs.are_numbers() || !summary.room.is_filled();
    }
    needs_more
}
