//! The points of a study as far as its results determine them: those of its axes, and those it
//! chooses.

use std::collections::HashSet;

use contact::model::Mesh;
use identity::JobKey;
use report::{Cell, DataTable, TableColumn};
use study::adaptive::OF_ONE_JOB;
use study::{Adaptive, Record, Study, StudyPoint};

use crate::error::AnswerError;
use crate::records::{RecordMap, Records};
use crate::rows;

mod accuracy;
mod found;

use accuracy::Learnt;
pub use found::{Chosen, Finding, Found, table};

/// Chooses a study's points by the records that there are.
pub fn choose(study: &Study, records: &RecordMap) -> Result<Chosen, AnswerError> {
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
                let (point, found) = settings
                    .ok_or(AnswerError::Inconsistent("a point of the study cannot be made"))?;
                chosen.findings.push(Finding { at: values(study, &point, None), found });
                chosen.points.push(point);
            }
            Ok(chosen)
        }
    }
}

/// Refuses a condition that cannot be evaluated, before anything runs.
pub fn check(study: &Study) -> Result<(), AnswerError> {
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
fn sample(columns: &[study::Column], point: &StudyPoint) -> Result<DataTable, AnswerError> {
    let heads = columns.iter().map(|column| TableColumn::new(column.name.as_ref(), column.unit()));
    let cells = columns.iter().map(|column| match rows::cell(column.value(point, None)) {
        Cell::Missing if column.is_numeric() => Cell::Number(f64::NAN),
        Cell::Missing => Cell::Text(String::new()),
        known => known,
    });
    Ok(DataTable::new(heads.collect(), vec![cells.collect()])?)
}

fn refine(
    study: &Study,
    records: &RecordMap,
    index: usize,
    (on, until, at_most): (&str, f64, u32),
    chosen: &mut Chosen,
) -> Result<(), AnswerError> {
    let columns = study.columns();
    let column = study::columns::find(&columns, on)
        .ok_or(AnswerError::Inconsistent("the column of [refine] is gone"))?;
    let first = study
        .point(index)
        .ok_or(AnswerError::Inconsistent("a point of the study cannot be made"))?;
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
    records: &RecordMap,
    (axis, on, to): (usize, &str, f64),
) -> Result<Chosen, AnswerError> {
    let columns = study.columns();
    let which =
        study.axes().nth(axis).ok_or(AnswerError::Inconsistent("the axis of [bisect] is gone"))?;
    let group = study.groups().iter().position(|group| group.axes().contains(which)).unwrap_or(0);
    let length = study.groups()[group].len();
    let stride: usize = study.groups()[group + 1..].iter().map(study::axis::Group::len).product();
    // whether the condition holds; None where it is not known
    let holds = |point: &StudyPoint| -> Result<Option<bool>, AnswerError> {
        match records.get(&point.key) {
            Some(record) if record.is_certified() => {
                let table = rows::table(&columns, point, Some(record))?;
                Ok(Some(!table.filter(on)?.rows().is_empty()))
            }
            _ => Ok(None),
        }
    };
    let value = |point: &StudyPoint| {
        point.values.get(axis).and_then(study::Value::as_f64).unwrap_or(f64::NAN)
    };
    // a part of the upper end; where that could never be, since the interval begins at 0 or below,
    // of the whole axis
    let ends: Vec<f64> = which.values().filter_map(study::Value::as_f64).collect();
    let range = ends.last().zip(ends.first()).map_or(f64::NAN, |(last, first)| last - first);
    let is_short = |low: f64, high: f64| high - low <= to * if low > 0.0 { high } else { range };
    let middle =
        |low: f64, high: f64| if which.is_log() { (low * high).sqrt() } else { 0.5 * (low + high) };
    let mut chosen = Chosen { points: Vec::new(), findings: Vec::new() };
    for index in (0..study.len()).filter(|index| (index / stride).is_multiple_of(length)) {
        let mut line: Vec<StudyPoint> =
            (0..length).filter_map(|step| study.point(index + step * stride)).collect();
        let at = line.first().map(|first| values(study, first, Some(axis))).unwrap_or_default();
        let mut known: Vec<Option<bool>> = line.iter().map(&holds).collect::<Result<_, _>>()?;
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
                let point =
                    study.point_at(index, axis, between).ok_or(AnswerError::Inconsistent(
                        "a value between two of the study cannot be made a job",
                    ))?;
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
fn values(
    study: &Study,
    point: &StudyPoint,
    without: Option<usize>,
) -> Vec<(String, study::Value)> {
    let axes =
        study.axes().zip(&point.values).enumerate().filter(|(index, _)| Some(*index) != without);
    axes.map(|(_, (axis, value))| (axis.column().into_owned(), value.clone())).collect()
}

/// The points of a study as far as its results determine them, with these results.
pub struct Gathered {
    /// The points, and what was found in choosing them.
    pub chosen: Chosen,
    /// The records that the points have, and those that the choice has learnt from.
    pub records: RecordMap,
}

/// Chooses a study's points by the results that `source` keeps, as far as these go.
///
/// # Errors
/// A record cannot be read, or a condition cannot be evaluated.
pub fn gather(study: &Study, source: &dyn Records) -> Result<Gathered, AnswerError> {
    let mut records = RecordMap::new();
    if let Some(Adaptive::Accuracy(_)) = study.adaptive() {
        // whatever study left them
        let scenes = accuracy::scenes(study);
        let is_wanted = |job: &str| accuracy::solves(&scenes, job);
        // what is damaged teaches nothing; where it is a point's own, it is met below
        records = source.matching(&is_wanted).map_err(AnswerError::Records)?;
    }
    let mut asked: HashSet<JobKey> = records.keys().copied().collect();
    loop {
        let chosen = choose(study, &records)?;
        let mut keys: Vec<JobKey> =
            chosen.points.iter().map(|point| point.key).filter(|key| asked.insert(*key)).collect();
        keys.sort_unstable();
        let before = records.len();
        records.extend(source.select(&keys).map_err(AnswerError::Records)?);
        // what is chosen depends on what is there
        if study.adaptive().is_none() || records.len() == before {
            return Ok(Gathered { chosen, records });
        }
    }
}
