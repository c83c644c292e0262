//! A study with what its jobs left, as a table.

use std::collections::{HashMap, HashSet};

use anyhow::{Context, Result, bail};
use contact::loading::Step;
use contact::outcome::{Fields, Observables};
use report::{Cell, DataTable};
use store::{Blobs, ReadError, Reader, Store};
use study::columns::{Compared, Role, Row, Value, along_path};
use study::record::decode_fields;
use study::{Adaptive, Column, JobKey, Kind, Point, Record, Study};

use crate::adaptive::{self, Chosen, Found, choose};
use crate::compare::{self, compare};
use crate::{accuracy, cost};

/// A record as a store gives it.
type Fetched = (JobKey, Result<Vec<u8>, ReadError>);

/// Where records come from.
#[derive(Clone, Copy)]
pub(crate) enum Source<'a> {
    /// The store that this process writes.
    Store(&'a Store),
    /// One that it reads.
    Reader(&'a Reader),
}

impl<'a> Source<'a> {
    /// The records of those of `keys` that have one.
    fn select(self, keys: Vec<JobKey>) -> Vec<Fetched> {
        match self {
            Source::Store(store) => keys
                .into_iter()
                .filter_map(|key| store.get(&key).transpose().map(|record| (key, record)))
                .collect(),
            Source::Reader(reader) => reader.select(keys).collect(),
        }
    }

    /// Every record.
    fn all(self) -> Result<Box<dyn Iterator<Item = Fetched> + 'a>, ReadError> {
        Ok(match self {
            Source::Store(store) => Box::new(store.records()),
            Source::Reader(reader) => Box::new(reader.records()?),
        })
    }

    fn blobs(self) -> &'a Blobs {
        match self {
            Source::Store(store) => store.blobs(),
            Source::Reader(reader) => reader.blobs(),
        }
    }
}

/// Rows of a study: every point, with the record of its job if there is one.
pub(crate) struct Results {
    pub(crate) study: Study,
    pub(crate) points: Vec<Point>,
    pub(crate) records: HashMap<JobKey, Record>,
    /// How far each point is from what it is compared with, if the study compares.
    compared: Vec<Option<Compared>>,
    /// What the study says beyond its rows: a title and a table.
    pub(crate) answers: Vec<(&'static str, DataTable)>,
    /// Points whose accuracy was asked for and not reached.
    pub(crate) inaccurate: usize,
}

/// How far a study is; counts are of points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub(crate) struct Progress {
    pub(crate) points: usize,
    pub(crate) done: usize,
    pub(crate) failed: usize,
    pub(crate) left: usize,
}

impl Progress {
    /// How far a study is, by what a store has of it.
    pub(crate) fn read(source: Source<'_>, study: &Study) -> Result<Self> {
        let (Chosen { points, .. }, records) = chosen(study, source)?;
        Ok(Self::of(&points, &records))
    }

    fn of(points: &[Point], records: &HashMap<JobKey, Record>) -> Self {
        let mut progress = Self { points: points.len(), ..Self::default() };
        for point in points {
            match records.get(&point.key).map(Record::status) {
                None => progress.left += 1,
                Some("certified") => progress.done += 1,
                Some(_) => progress.failed += 1,
            }
        }
        progress
    }
}

impl Results {
    /// Reads what a study's jobs left in a store.
    pub(crate) fn read(source: Source<'_>, study: Study) -> Result<Self> {
        let (Chosen { points, findings }, records) = chosen(&study, source)?;
        let blobs = source.blobs();
        let inaccurate =
            findings.iter().filter(|finding| matches!(finding.found, Found::Beyond { .. })).count();
        let mut answers = Vec::new();
        if !findings.is_empty() {
            answers.push(("found", adaptive::table(&study, &findings)?));
        }
        let mut compared = points.iter().map(|_| None).collect();
        if let Some(ladder) = study.ladder() {
            let (ladders, all) =
                compare(&study, ladder, &points, &records, &|record| fields(blobs, record))?;
            answers.push(("orders", compare::orders(&study, &ladders, &all)?));
            answers.extend(compare::limits(&study, &ladders)?.map(|limits| ("limits", limits)));
            compared = all;
        }
        if let Some(cost) = study.cost() {
            let found =
                cost::compare(&study, cost, &points, &records, &|record| fields(blobs, record))?;
            (answers, compared) = (found.answers, found.compared);
        }
        Ok(Self { study, points, records, compared, answers, inaccurate })
    }

    /// The points of a study as far as its results determine them, and what they say of the choice.
    pub(crate) fn chosen(study: &Study, source: Source<'_>) -> Result<Chosen> {
        Ok(chosen(study, source)?.0)
    }

    pub(crate) fn record(&self, point: &Point) -> Option<&Record> {
        self.records.get(&point.key)
    }

    pub(crate) fn progress(&self) -> Progress {
        Progress::of(&self.points, &self.records)
    }

    /// What the study says beyond its rows, each table under its title.
    pub(crate) fn answers_words(&self) -> String {
        let words = |(title, table): &(&str, DataTable)| match (table.columns(), table.rows()) {
            // a sentence
            ([_], [row]) => format!("\n{}\n", row.iter().map(words_of).collect::<String>()),
            _ => format!("\n{title}\n{}", table.terminal(&crate::query::layout())),
        };
        self.answers.iter().map(words).collect()
    }

    /// The same as rows by column, by title.
    pub(crate) fn answers_json(&self) -> Result<serde_json::Value> {
        let rows = self
            .answers
            .iter()
            .map(|(title, table)| Ok(((*title).to_owned(), serde_json::from_str(&table.json())?)));
        Ok(serde_json::Value::Object(rows.collect::<Result<_>>()?))
    }

    /// Every column of every point.
    pub(crate) fn table(&self) -> Result<DataTable> {
        let columns = self.study.columns();
        let rows = self.points.iter().zip(&self.compared).map(|(point, compared)| {
            row(&columns, &Row { point, record: self.record(point), compared: compared.as_ref() })
        });
        Ok(DataTable::new(heads(&columns), rows.collect())?)
    }

    /// Every column of every increment that was computed.
    pub(crate) fn increments(&self) -> Result<DataTable> {
        let computed = self.points.iter().filter_map(|point| Some((point, self.record(point)?)));
        increments(&along_path(self.study.columns()), computed)
    }

    /// What the study's figures are drawn from: the points, or their increments; one at which a
    /// path failed is no solution.
    pub(crate) fn figure_table(&self, steps: bool) -> Result<DataTable> {
        if steps { Ok(self.increments()?.filter("status == \"certified\"")?) } else { self.table() }
    }

    /// The columns that answer the question at a glance: the axes, the figures', the usual
    /// observables, and how it ended.
    pub(crate) fn usual_columns(&self, steps: bool) -> Vec<String> {
        let columns = self.study.columns();
        let mut names: Vec<String> = columns
            .iter()
            .filter(|column| column.role == Role::Axis)
            .map(|column| column.name.to_string())
            .collect();
        let figures = self.study.figures().iter().filter(|figure| steps || !figure.steps);
        let usual = match steps {
            true => path_columns(&self.points),
            false => match self.study.kind() {
                Kind::Solve => {
                    &["load", "contact_radius", "stick_fraction", "peak_pressure", "status"][..]
                }
                Kind::Cost => &["seconds", "spread", "iterations", "status"],
                Kind::Convergence => &["load", "peak_pressure", "status"],
                Kind::Uniqueness => &["mu_low", "mu_high", "bracket_width", "unbounded", "status"],
                Kind::Multiplicity => &["solutions", "index_sum", "largest_distance", "status"],
            }
            .iter()
            .map(|name| (*name).to_owned())
            .collect(),
        };
        let own: Vec<String> = figures
            .flat_map(|figure| {
                std::iter::once(&figure.x).chain(&figure.y).chain(figure.band.iter().flatten())
            })
            .cloned()
            .collect();
        // on a path it comes first where one is
        let (first, then) = if steps { (usual, own) } else { (own, usual) };
        for name in first.into_iter().chain(then) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }
}

/// The columns that show loading paths at a glance: the place, the motions and forces that some
/// step mentions, what they do, and how it ended.
pub(crate) fn path_columns(points: &[Point]) -> Vec<String> {
    let paths = || points.iter().filter_map(|point| Some(&point.job.case()?.scene.loading));
    let cycle = paths().any(|path| path.cycle_from.is_some()).then_some("cycle");
    let mut names: Vec<String> =
        ["step"].into_iter().chain(cycle).chain(["increment"]).map(str::to_owned).collect();
    for (which, [motion, force]) in Step::NAMES.into_iter().enumerate() {
        if which == 0
            || paths().flat_map(|path| &path.steps).any(|step| step.given()[which] != [None, None])
        {
            names.extend([
                format!("at_{motion}"),
                if force == "normal_force" { "load".to_owned() } else { force.to_owned() },
            ]);
        }
    }
    names.extend(["contact_radius", "stick_fraction", "dissipation", "status"].map(str::to_owned));
    names
}

/// A count that should be 0, and what it means when it is not.
pub(crate) struct Warning {
    pub(crate) column: &'static str,
    pub(crate) words: &'static str,
    count: fn(&Observables) -> u64,
}

pub(crate) const WARNINGS: [Warning; 2] = [
    Warning {
        column: "edge_elements",
        words: "touch the edge of Ω although the punch goes on beyond it; give a larger `domain`",
        count: |observables| observables.edge_elements,
    },
    Warning {
        column: "ceiling_elements",
        words: "reach the pressure ceiling and so solve the regularised equation only; raise `ceiling`",
        count: |observables| observables.ceiling_elements,
    },
];

impl Warning {
    pub(crate) fn concerns(&self, record: &Record) -> bool {
        record.outcome().is_some_and(|outcome| {
            outcome.steps.iter().any(|step| (self.count)(&step.observables) > 0)
        })
    }
}

/// The points of a study with what its jobs left, and what it found in choosing them.
fn chosen(study: &Study, source: Source<'_>) -> Result<(Chosen, HashMap<JobKey, Record>)> {
    let mut records = HashMap::new();
    if let Some(Adaptive::Accuracy(_)) = study.adaptive() {
        // whatever study left them
        let scenes = accuracy::scenes(study);
        for (key, bytes) in source.all()? {
            // what is damaged teaches nothing; where it is a point's own, it is met below
            let Ok(bytes) = bytes else { continue };
            if accuracy::tells(&scenes, &bytes)
                && let Ok(record) = Record::decode(&bytes)
            {
                records.insert(key, record);
            }
        }
    }
    let mut asked: HashSet<JobKey> = records.keys().copied().collect();
    loop {
        let chosen = choose(study, &records)?;
        let mut keys: Vec<JobKey> =
            chosen.points.iter().map(|point| point.key).filter(|key| asked.insert(*key)).collect();
        keys.sort_unstable();
        let before = records.len();
        for (key, bytes) in source.select(keys) {
            let bytes = bytes.context("run `tribosweep store verify` to see the whole damage")?;
            records.insert(
                key,
                Record::decode(&bytes).with_context(|| format!("the record of job {key}"))?,
            );
        }
        // what is chosen depends on what is there
        if study.adaptive().is_none() || records.len() == before {
            return Ok((chosen, records));
        }
    }
}

/// The fields that a record left.
pub(crate) fn fields(blobs: &Blobs, record: &Record) -> Result<Fields> {
    let kept = record.fields.as_ref().with_context(|| {
        format!("job {} left no fields: it is {}", record.key(), record.status())
    })?;
    let blob = blobs.kept(kept)?.context(
        "the file with its fields is missing; `tribosweep store verify` says what else is",
    )?;
    Ok(decode_fields(&blob)?)
}

/// One row by itself, as a table.
pub(crate) fn table(
    columns: &[Column],
    point: &Point,
    record: Option<&Record>,
) -> Result<DataTable> {
    Ok(DataTable::new(heads(columns), vec![row(columns, &Row { point, record, compared: None })])?)
}

/// A table of the increments of results.
pub(crate) fn increments<'r>(
    columns: &[Column],
    results: impl IntoIterator<Item = (&'r Point, &'r Record)>,
) -> Result<DataTable> {
    let mut rows = Vec::new();
    for (point, record) in results {
        record.along_path(|increment| {
            rows.push(row(columns, &Row { point, record: Some(increment), compared: None }))
        });
    }
    Ok(DataTable::new(heads(columns), rows)?)
}

fn heads(columns: &[Column]) -> Vec<report::TableColumn> {
    columns
        .iter()
        .map(|column| report::TableColumn::new(column.name.as_ref(), column.unit()))
        .collect()
}

fn row(columns: &[Column], row: &Row<'_>) -> Vec<Cell> {
    columns.iter().map(|column| cell(column.value_of(row))).collect()
}

fn words_of(cell: &Cell) -> &str {
    if let Cell::Text(words) = cell { words } else { "" }
}

pub(crate) fn cell(value: Value) -> Cell {
    match value {
        Value::Number(x) => Cell::Number(x),
        Value::Integer(n) => i64::try_from(n).map_or(Cell::Number(n as f64), Cell::Integer),
        Value::Text(text) => Cell::Text(text),
        Value::Missing => Cell::Missing,
    }
}

/// The study of this name in a store; if there is none, says which there are.
pub(crate) fn stored_study(reader: &Reader, name: &str) -> Result<Study> {
    let damaged = || {
        format!(
            "the definition of the study `{name}` is damaged; `tribosweep run` of its file writes it anew"
        )
    };
    if let Some(definition) = reader.study(name).with_context(damaged)? {
        return Study::from_definition(&definition)
            .with_context(|| format!("the stored study `{name}`"));
    }
    let names = reader.study_names()?;
    if std::path::Path::new(name).is_file() {
        bail!(
            "`{name}` is a file; name a study in the store instead ({}), or start it with `tribosweep run {name}`",
            list(&names)
        );
    }
    bail!("there is no study `{name}` in the store; it has {}", list(&names))
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none so far".to_owned() } else { names.join(", ") }
}
