//! Checks the condition of a study that halves an axis.

use report::{Cell, DataTable};
use study::adaptive::OF_ONE_JOB;
use study::{Adaptive, Column, Study, StudyPoint, ValueType};

use crate::error::AnswerError;
use crate::rows::{cell, heads};

/// Refuses a condition that cannot be evaluated, before anything runs.
///
/// # Errors
/// The condition does not fit the columns, at its place in the file.
pub fn check(study: &Study) -> Result<(), AnswerError> {
    let Some(Adaptive::Bisect { on, .. }) = study.adaptive() else { return Ok(()) };
    let columns = study.columns();
    for point in samples(study).into_iter().filter_map(|index| study.point(index)) {
        let row = placeholder(&columns, &point)?;
        row.filter(on).map_err(|error| {
            study.refuse_condition("`bisect.on` is no condition on the results", &error.to_string())
        })?;
        for column in &columns {
            let Some(reason) = column.unknown_in_choosing() else { continue };
            let names = columns.iter().map(|column| column.name.as_ref());
            let others: Vec<&str> = names.filter(|name| *name != column.name).collect();
            if row.select(&others)?.filter(on).is_err() {
                return Err(study.refuse_condition(reason, OF_ONE_JOB).into());
            }
        }
    }
    Ok(())
}

/// Returns the indices of points along each axis, the other axes at their first value: a column
/// that is a number for one mesh is a text for another.
fn samples(study: &Study) -> Vec<usize> {
    let mut points = vec![0];
    let mut stride = study.len();
    for group in study.groups() {
        stride /= group.len();
        // What holds for the columns of some points of a sample holds for all.
        let most = if group.design().is_some() { 64 } else { usize::MAX };
        points.extend((1..group.len().min(most)).map(|step| step * stride));
    }
    points
}

/// Returns a placeholder row with the types that the job's results will have: unknown numbers are
/// NaN, unknown texts are empty.
fn placeholder(columns: &[Column], point: &StudyPoint) -> Result<DataTable, AnswerError> {
    let cells = columns.iter().map(|column| match cell(column.value(point, None)) {
        Cell::Missing if column.is_numeric() => Cell::Number(f64::NAN),
        Cell::Missing if column.values() == ValueType::Flag => Cell::Flag(false),
        Cell::Missing => Cell::Text(String::new()),
        known => known,
    });
    Ok(DataTable::new(heads(columns), vec![cells.collect()])?)
}
