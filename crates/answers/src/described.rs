//! Descriptions of what the points of a sample say: means, deviations and quantiles of columns, and
//! how many points failed.

use report::{Cell, DataTable, TableColumn};
use study::columns::Role;
use study::{Column, Record, SamplingMethod};

use crate::comparison::AnswerTable;
use crate::error::AnswerError;
use crate::evidence::Evidence;
use crate::place::{PointGroup, group_points};
use crate::statistics::ConfidenceInterval;
use crate::statistics::description::{Statistic, describe};
use crate::statistics::share::share;
use crate::variation::{DIMENSIONLESS, NOISE};

/// Describes columns of a study with a sample, for each combination of the other axes.
pub(crate) fn tables(
    evidence: &Evidence<'_>,
    columns: &[Column],
) -> Result<Vec<AnswerTable>, AnswerError> {
    let Evidence { study, points, .. } = *evidence;
    let Some(design) = study.sample().and_then(|group| group.design()) else {
        return Ok(Vec::new());
    };
    // Coarser meshes of a point are steps on the way to the last.
    let is_last = |point: usize| {
        let next = points.get(point + 1).filter(|_| study.adaptive().is_some());
        next.is_none_or(|next| next.values != points[point].values)
    };
    let is_of_sample = |group: usize| study.groups()[group].design().is_some();
    let mut groups = group_points(study, points, is_of_sample);
    groups.iter_mut().for_each(|group| group.members.retain(|point| is_last(*point)));
    let mut tables = Vec::new();
    for column in columns {
        tables.push(described(evidence, column, &groups)?);
    }
    tables.extend(failures(evidence, &groups)?);
    tables.push(sentence("independence", independence(design.method()))?);
    Ok(tables)
}

/// Returns a table of one cell.
pub(crate) fn sentence(
    title: &'static str,
    words: impl Into<String>,
) -> Result<AnswerTable, AnswerError> {
    let heads = vec![TableColumn::new("answer", "")];
    let table = DataTable::new(heads, vec![vec![Cell::Text(words.into())]])?;
    Ok(AnswerTable { title: title.into(), table })
}

/// Says what the intervals of a sample take for granted.
pub(crate) fn independence(method: SamplingMethod) -> String {
    let intervals = "intervals are of 95 %, by a bootstrap of 1000 resamples";
    match method {
        SamplingMethod::Random => intervals.to_owned(),
        SamplingMethod::Sobol | SamplingMethod::Halton | SamplingMethod::LatinHypercube => format!(
            "{intervals}, which takes points for independent; those of method \"{}\" are spread \
             more evenly, and most values are closer to the truth than their intervals say",
            method.name()
        ),
    }
}

/// Returns the value of a column at a point that has a certified result; `None` if it is no finite
/// number.
pub(crate) fn number(evidence: &Evidence<'_>, column: &Column, point: usize) -> Option<f64> {
    let record = evidence.certified(point)?;
    let account = None;
    let point = &evidence.points[point];
    let row = study::columns::Row { point, record: Some(record), compared: None, account };
    match column.value_of(&row) {
        study::Value::Number(x) => Some(x).filter(|x| x.is_finite()),
        study::Value::Integer(n) => Some(n as f64),
        study::Value::Flag(_) | study::Value::Text(_) | study::Value::Missing => None,
    }
}

/// Returns the change below which the values of a column are the same: the part [`NOISE`] of the
/// largest quantity of its unit among the results. A force that is 0 is some 10⁻¹³ N.
pub(crate) fn floor(evidence: &Evidence<'_>, column: &Column) -> f64 {
    let unit = column.unit();
    if DIMENSIONLESS.contains(&unit) {
        return 0.0;
    }
    let columns = evidence.study.columns();
    let alike: Vec<&Column> = columns
        .iter()
        .filter(|other| other.role == Role::Observable && other.unit() == unit)
        .collect();
    let sizes = (0..evidence.points.len())
        .flat_map(|point| alike.iter().filter_map(move |other| number(evidence, other, point)));
    NOISE * sizes.map(f64::abs).fold(0.0, f64::max)
}

fn described(
    evidence: &Evidence<'_>,
    column: &Column,
    groups: &[PointGroup],
) -> Result<AnswerTable, AnswerError> {
    let mut heads =
        groups.first().map(|group| group.place.heads(evidence.study)).unwrap_or_default();
    let unit = column.unit();
    heads.push(TableColumn::new("statistic", ""));
    heads.extend(["value", "low", "high"].map(|name| TableColumn::new(name, unit)));
    heads.extend(["points", "missing"].map(|name| TableColumn::new(name, "")));
    let mut rows = Vec::new();
    for PointGroup { place, members } in groups {
        let numbers: Vec<f64> =
            members.iter().filter_map(|point| number(evidence, column, *point)).collect();
        // The points that have ended and have no value, be it that they failed.
        let missing = ended(evidence, members).count() - numbers.len();
        let counts = [numbers.len(), missing].map(|count| Cell::Integer(count as i64));
        for Statistic { name, value, interval } in describe(numbers) {
            let mut row = place.cells();
            row.push(Cell::Text(name.to_owned()));
            row.push(value.map_or(Cell::Missing, Cell::Number));
            row.extend(ends(interval));
            row.extend(counts.clone());
            rows.push(row);
        }
    }
    let title = format!("statistics of {}", column.name).into();
    Ok(AnswerTable { title, table: DataTable::new(heads, rows)? })
}

/// Returns the ends of an interval as cells.
pub(crate) fn ends(interval: Option<ConfidenceInterval>) -> [Cell; 2] {
    match interval {
        Some(ConfidenceInterval { low, high }) => [low, high].map(Cell::Number),
        None => [Cell::Missing, Cell::Missing],
    }
}

/// Iterates over the records of those of some points that have ended.
fn ended<'e>(evidence: &'e Evidence<'_>, members: &'e [usize]) -> impl Iterator<Item = &'e Record> {
    members.iter().filter_map(|point| evidence.records.get(&evidence.points[*point].key))
}

/// Says how many of the points that have ended failed, and how many might, a row for each
/// combination of the other axes; nothing if none has ended.
fn failures(
    evidence: &Evidence<'_>,
    groups: &[PointGroup],
) -> Result<Option<AnswerTable>, AnswerError> {
    let mut rows = Vec::new();
    for PointGroup { place, members } in groups {
        let (mut failed, mut count) = (0, 0);
        for record in ended(evidence, members) {
            failed += usize::from(!record.is_certified());
            count += 1;
        }
        if count > 0 {
            let scene = match place.values.is_empty() {
                true => String::new(),
                false => format!("{}: ", place.scene()),
            };
            rows.push(vec![Cell::Text(scene + &failure_words(failed, count))]);
        }
    }
    if rows.is_empty() {
        return Ok(None);
    }
    let table = DataTable::new(vec![TableColumn::new("answer", "")], rows)?;
    Ok(Some(AnswerTable { title: "failed".into(), table }))
}

/// Says how many of some points failed, and how many might.
fn failure_words(failed: usize, count: usize) -> String {
    let ConfidenceInterval { low, high } = share(failed, count);
    let percent = |part: f64| format!("{} %", crate::rows::digits(100.0 * part, 1));
    match failed {
        0 => format!(
            "no point of {count} failed; with 95 % confidence fewer than {} do",
            percent(high)
        ),
        _ => format!(
            "{failed} of {count} points failed, {}; with 95 % confidence the share is {} to {}, and \
             what they would have said is missing above",
            percent(failed as f64 / count as f64),
            percent(low),
            percent(high)
        ),
    }
}
