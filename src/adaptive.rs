//! The points of a study as far as its results determine them: those of its axes, and those it
//! chooses.

use std::collections::HashMap;

use anyhow::{Context, Result};
use contact::numerics::Mesh;
use report::{Cell, DataTable, TableColumn};
use serde::Serialize;
use study::adaptive::OF_ONE_JOB;
use study::{Adaptive, JobKey, Point, Record, Study};

use crate::accuracy::{self, Learnt};
use crate::compare::digits;
use crate::results;

/// What is known of the points of a study.
pub(crate) struct Chosen {
    /// In order; what has no record yet is wanted.
    pub(crate) points: Vec<Point>,
    /// Of a study that chooses points, what it found so far at each combination of its axes.
    pub(crate) findings: Vec<Finding>,
}

/// What a study that chooses points found at one combination of its axes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Finding {
    /// The values of the axes, without the one that is halved.
    #[serde(skip)]
    pub(crate) at: Vec<(String, study::Value)>,
    pub(crate) found: Found,
}

/// How far the choice of points has come.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Found {
    /// Jobs are left.
    Pending,
    /// A job that the choice depends on was not solved.
    Unsolved,
    /// The result held still: its value on the finest mesh, and by how much it changed to there.
    Still { mesh: [u32; 2], value: f64, change: f64 },
    /// The finest mesh that is allowed came first; from the only one there is no change.
    NotStill { mesh: [u32; 2], value: f64, change: Option<f64> },
    /// The condition changes between these values, in this direction.
    Changes { from: f64, to: f64, becomes: bool },
    /// It holds, or does not, at every value tried.
    Everywhere { holds: bool },
    /// These settings are to be tried next.
    Next { mesh: [u32; 2], tolerance: f64 },
    /// These settings are accurate enough, by the estimate of the relative error with them.
    Within { mesh: [u32; 2], tolerance: f64, error: f64 },
    /// No settings were; these came closest.
    Beyond { mesh: [u32; 2], tolerance: f64, error: Option<f64>, why: &'static str },
}

/// Chooses a study's points by the records that there are.
pub(crate) fn choose(study: &Study, records: &HashMap<JobKey, Record>) -> Result<Chosen> {
    match study.adaptive() {
        None => Ok(Chosen { points: study.points(), findings: Vec::new() }),
        Some(Adaptive::Refine { on, until, at_most }) => {
            let mut chosen = Chosen { points: Vec::new(), findings: Vec::new() };
            for index in 0..study.len() {
                refine(study, records, index, (on, *until, *at_most), &mut chosen)?;
            }
            Ok(chosen)
        }
        Some(Adaptive::Bisect { axis, on, to, .. }) => bisect(study, records, (*axis, on, *to)),
        Some(Adaptive::Accuracy(accuracy)) => {
            let (columns, learnt) = (study.columns(), Learnt::of(records));
            let mut chosen = Chosen { points: Vec::new(), findings: Vec::new() };
            for index in 0..study.len() {
                let settings = accuracy::choose(study, accuracy, &columns, &learnt, index);
                let (point, found) = settings.context("a point of the study cannot be made")?;
                chosen.findings.push(Finding { at: values(study, &point, None), found });
                chosen.points.push(point);
            }
            Ok(chosen)
        }
    }
}

/// Refuses a condition that cannot be evaluated, before anything runs.
pub(crate) fn check(study: &Study) -> Result<()> {
    let Some(Adaptive::Bisect { on, .. }) = study.adaptive() else { return Ok(()) };
    let columns = study.columns();
    // along each axis with the others at their first value: what is a number for one mesh is a text
    // for another
    let mut points = vec![0];
    let mut stride = study.len();
    for group in study.groups() {
        stride /= group.len();
        points.extend((1..group.len()).map(|step| step * stride));
    }
    for point in points.into_iter().filter_map(|index| study.point(index)) {
        let sample = sample(&columns, &point)?;
        sample.filter(on).map_err(|error| {
            study.refuse_condition("`bisect.on` is no condition on the results", &error.to_string())
        })?;
        for (late, why) in
            columns.iter().filter_map(|column| Some((column, column.unknown_in_choosing()?)))
        {
            let others: Vec<&str> = columns
                .iter()
                .map(|column| column.name.as_ref())
                .filter(|name| *name != late.name)
                .collect();
            if sample.select(&others)?.filter(on).is_err() {
                return Err(study.refuse_condition(why, OF_ONE_JOB).into());
            }
        }
    }
    Ok(())
}

/// A row of a point as its job will leave it: what it is not known to say has its type, and no
/// value if it is a number.
fn sample(columns: &[study::Column], point: &Point) -> Result<DataTable> {
    let heads = columns.iter().map(|column| TableColumn::new(column.name.as_ref(), column.unit()));
    let cells = columns.iter().map(|column| match results::cell(column.value(point, None)) {
        Cell::Missing if column.is_numeric() => Cell::Number(f64::NAN),
        Cell::Missing => Cell::Text(String::new()),
        known => known,
    });
    Ok(DataTable::new(heads.collect(), vec![cells.collect()])?)
}

fn refine(
    study: &Study,
    records: &HashMap<JobKey, Record>,
    index: usize,
    (on, until, at_most): (&str, f64, u32),
    chosen: &mut Chosen,
) -> Result<()> {
    let columns = study.columns();
    let column = study::columns::find(&columns, on).context("the column of [refine] is gone")?;
    let first = study.point(index).context("a point of the study cannot be made")?;
    let at = values(study, &first, None);
    let mut sides = match first.job.mesh() {
        Mesh::Across(n) => [n, n],
        Mesh::Exact(sides) => sides,
    };
    let (mut point, mut last) = (first, None);
    let found = loop {
        let record = records.get(&point.key);
        let value = column.value(&point, record).as_f64();
        let (solved, mesh) = (record.map(Record::is_certified), point.job.mesh());
        chosen.points.push(point);
        let value = match (solved, value) {
            (None, _) => break Found::Pending,
            (Some(true), Some(value)) => value,
            _ => break Found::Unsolved,
        };
        let change = last
            .map(|last: f64| if value == last { 0.0 } else { (value - last).abs() / value.abs() });
        if let Some(change) = change.filter(|change| *change <= until) {
            break Found::Still { mesh: sides, value, change };
        }
        let doubled = sides.map(|n| n.saturating_mul(2));
        let finer = if matches!(mesh, Mesh::Across(_)) {
            Mesh::Across(doubled[0])
        } else {
            Mesh::Exact(doubled)
        };
        let is_last = doubled.iter().any(|n| *n > at_most);
        // what is fine enough for some jobs is too fine for others
        match study.point_on_mesh(index, finer).filter(|_| !is_last) {
            Some(next) => (last, sides, point) = (Some(value), doubled, next),
            None => break Found::NotStill { mesh: sides, value, change },
        }
    };
    chosen.findings.push(Finding { at, found });
    Ok(())
}

fn bisect(
    study: &Study,
    records: &HashMap<JobKey, Record>,
    (axis, on, to): (usize, &str, f64),
) -> Result<Chosen> {
    let columns = study.columns();
    let which = study.axes().nth(axis).context("the axis of [bisect] is gone")?;
    let group = study.groups().iter().position(|group| group.axes().contains(which)).unwrap_or(0);
    let length = study.groups()[group].len();
    let stride: usize = study.groups()[group + 1..].iter().map(study::axis::Group::len).product();
    // whether the condition holds; None where it is not known
    let holds = |point: &Point| -> Result<Option<bool>> {
        match records.get(&point.key) {
            Some(record) if record.is_certified() => {
                let table = results::table(&columns, point, Some(record))?;
                Ok(Some(!table.filter(on)?.rows().is_empty()))
            }
            _ => Ok(None),
        }
    };
    let value =
        |point: &Point| point.values.get(axis).and_then(study::Value::as_f64).unwrap_or(f64::NAN);
    // a part of the upper end; where that could never be, since the interval begins at 0 or below,
    // of the whole axis
    let ends: Vec<f64> = which.values().filter_map(study::Value::as_f64).collect();
    let range = ends.last().zip(ends.first()).map_or(f64::NAN, |(last, first)| last - first);
    let is_short = |low: f64, high: f64| high - low <= to * if low > 0.0 { high } else { range };
    let middle =
        |low: f64, high: f64| if which.is_log() { (low * high).sqrt() } else { 0.5 * (low + high) };
    let mut chosen = Chosen { points: Vec::new(), findings: Vec::new() };
    for index in (0..study.len()).filter(|index| (index / stride).is_multiple_of(length)) {
        let mut line: Vec<Point> =
            (0..length).filter_map(|step| study.point(index + step * stride)).collect();
        let at = line.first().map(|first| values(study, first, Some(axis))).unwrap_or_default();
        let mut known: Vec<Option<bool>> = line.iter().map(&holds).collect::<Result<_>>()?;
        let mut changes = Vec::new();
        let mut from = 0;
        while from + 1 < line.len() {
            let (low, high) = (value(&line[from]), value(&line[from + 1]));
            let (Some(before), Some(after)) = (known[from], known[from + 1]) else {
                from += 1;
                continue;
            };
            let between = middle(low, high);
            if before == after {
                from += 1;
            } else if is_short(low, high) || !(low < between && between < high) {
                changes.push(Found::Changes { from: low, to: high, becomes: after });
                from += 1;
            } else {
                let point = study
                    .point_at(index, axis, between)
                    .context("a value between two of the study cannot be made a job")?;
                known.insert(from + 1, holds(&point)?);
                line.insert(from + 1, point);
            }
        }
        let is_pending = line.iter().any(|point| !records.contains_key(&point.key));
        let found = match (is_pending, known.iter().copied().collect::<Option<Vec<bool>>>()) {
            (true, _) => vec![Found::Pending],
            (false, None) if changes.is_empty() => vec![Found::Unsolved],
            (false, Some(all)) if changes.is_empty() => vec![Found::Everywhere { holds: all[0] }],
            _ => changes,
        };
        chosen.findings.extend(found.into_iter().map(|found| Finding { at: at.clone(), found }));
        chosen.points.append(&mut line);
    }
    Ok(chosen)
}

/// The values of a point's axes, one of them left out.
fn values(study: &Study, point: &Point, without: Option<usize>) -> Vec<(String, study::Value)> {
    let axes =
        study.axes().zip(&point.values).enumerate().filter(|(index, _)| Some(*index) != without);
    axes.map(|(_, (axis, value))| (axis.column().into_owned(), value.clone())).collect()
}

/// What was found as a table.
pub(crate) fn table(study: &Study, findings: &[Finding]) -> Result<DataTable> {
    let axes = findings.first().map(|finding| finding.at.clone()).unwrap_or_default();
    let columns = study.columns();
    let unit = |name: &str| study::columns::find(&columns, name).map_or("", study::Column::unit);
    let mut heads: Vec<TableColumn> =
        axes.iter().map(|(name, _)| TableColumn::new(name.as_str(), unit(name))).collect();
    let own: Vec<(String, String)> = match study.adaptive() {
        Some(Adaptive::Refine { on, .. }) => {
            vec![
                ("mesh".into(), String::new()),
                (on.clone(), unit(on).into()),
                ("change".into(), "1".into()),
            ]
        }
        Some(Adaptive::Bisect { axis, .. }) => {
            let name =
                study.axes().nth(*axis).map(|axis| axis.column().into_owned()).unwrap_or_default();
            ["from", "to"].map(|end| (format!("{name}_{end}"), unit(&name).to_owned())).to_vec()
        }
        Some(Adaptive::Accuracy(_)) => ["mesh", "tolerance", "estimated error"]
            .map(|name| (name.to_owned(), String::new()))
            .to_vec(),
        None => Vec::new(),
    };
    heads.extend(own.iter().map(|(name, unit)| TableColumn::new(name.as_str(), unit.as_str())));
    heads.push(TableColumn::new("found", ""));
    let rows = findings.iter().map(|Finding { at, found }| {
        let mesh =
            |[x, y]: [u32; 2]| Cell::Text(if x == y { x.to_string() } else { format!("{x}x{y}") });
        let (cells, words) = match *found {
            Found::Pending => (Vec::new(), "jobs are left"),
            Found::Unsolved => (Vec::new(), "a job was not solved"),
            Found::Still { mesh: sides, value, change } => (
                vec![mesh(sides), Cell::Number(value), Cell::Number(digits(change, 1))],
                "holds still",
            ),
            Found::NotStill { mesh: sides, value, change } => {
                let change = change.map_or(Cell::Missing, |change| Cell::Number(digits(change, 1)));
                (
                    vec![mesh(sides), Cell::Number(value), change],
                    "still changes on the finest mesh allowed",
                )
            }
            Found::Changes { from, to, becomes } => (
                vec![Cell::Number(from), Cell::Number(to)],
                if becomes { "begins to hold" } else { "ceases to hold" },
            ),
            Found::Everywhere { holds } => {
                (Vec::new(), if holds { "holds everywhere" } else { "holds nowhere" })
            }
            Found::Next { mesh: sides, tolerance } => {
                (vec![mesh(sides), Cell::Number(tolerance)], "to be tried next")
            }
            Found::Within { mesh: sides, tolerance, error } => (
                vec![mesh(sides), Cell::Number(tolerance), Cell::Number(digits(error, 1))],
                "accurate enough",
            ),
            Found::Beyond { mesh: sides, tolerance, error, why } => {
                let error = error.map_or(Cell::Missing, |error| Cell::Number(digits(error, 1)));
                (vec![mesh(sides), Cell::Number(tolerance), error], why)
            }
        };
        let missing = own.len() - cells.len();
        let axes = at.iter().map(|(_, value)| results::cell(value.clone()));
        axes.chain(cells)
            .chain(std::iter::repeat_n(Cell::Missing, missing))
            .chain([Cell::Text(words.to_owned())])
            .collect()
    });
    Ok(DataTable::new(heads, rows.collect())?)
}
