//! Studies: what they are, and the result of one that is a single scene.

use std::collections::BTreeMap;

use ::study::{Column, Study};
use contact::FrictionProblem;
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use tribosweep::library::{self, StudyText};

use crate::fields::{arrays, path_arrays};
use crate::threads::{detached, interruptible};

/// Returns what a study is, after checking it.
#[pyfunction]
#[pyo3(signature = (text, path, files))]
pub(crate) fn check<'py>(
    py: Python<'py>,
    text: Option<String>,
    path: String,
    files: BTreeMap<String, Vec<u8>>,
) -> PyResult<Bound<'py, PyDict>> {
    let study = detached(py, || StudyText { text, path, files }.study())?;
    let checked = outline(py, &study)?;
    let files = PyDict::new(py);
    for (name, bytes) in study.read_files() {
        files.set_item(name, PyBytes::new(py, bytes))?;
    }
    checked.set_item("files", files)?;
    Ok(checked)
}

/// Returns what a study is.
pub(crate) fn outline<'py>(py: Python<'py>, study: &Study) -> PyResult<Bound<'py, PyDict>> {
    let outline = PyDict::new(py);
    outline.set_item("name", study.name())?;
    outline.set_item("question", study.question())?;
    outline.set_item("kind", study.kind().name())?;
    outline.set_item("points", study.len() - study.excluded())?;
    let axes: Vec<String> = study.axes().map(|axis| axis.column().into_owned()).collect();
    outline.set_item("axes", axes)?;
    outline.set_item("text", study.text())?;
    Ok(outline)
}

/// Solves the only scene of a study.
#[pyfunction]
#[pyo3(signature = (text, path, files))]
pub(crate) fn solve<'py>(
    py: Python<'py>,
    text: Option<String>,
    path: String,
    files: BTreeMap<String, Vec<u8>>,
) -> PyResult<Bound<'py, PyDict>> {
    let text = StudyText { text, path, files };
    let result = interruptible(py, move |cancellation| library::solve(&text, cancellation))?;
    let solved = PyDict::new(py);
    solved.set_item("json", result.json.to_string())?;
    solved.set_item("job", result.job)?;
    solved.set_item("columns", described(py, &result.columns)?)?;
    solved.set_item("doubts", result.doubts)?;
    solved.set_item("fields", result.fields.map(|fields| arrays(py, fields)).transpose()?)?;
    Ok(solved)
}

/// Returns the fields of all increments of a job of a study, whose path is solved for them.
#[pyfunction]
#[pyo3(signature = (text, path, files, job))]
pub(crate) fn path_fields<'py>(
    py: Python<'py>,
    text: Option<String>,
    path: String,
    files: BTreeMap<String, Vec<u8>>,
    job: String,
) -> PyResult<Bound<'py, PyDict>> {
    let text = StudyText { text, path, files };
    let fields = interruptible(py, move |cancellation| {
        library::path_fields(&text.study()?, &job, cancellation)
    })?;
    path_arrays(py, fields)
}

/// Returns the discrete friction problem of an increment of a job of a study.
#[pyfunction]
#[pyo3(signature = (text, path, files, job, increment))]
pub(crate) fn friction_problem<'py>(
    py: Python<'py>,
    text: Option<String>,
    path: String,
    files: BTreeMap<String, Vec<u8>>,
    job: String,
    increment: Option<u64>,
) -> PyResult<Bound<'py, PyDict>> {
    let text = StudyText { text, path, files };
    let problem = interruptible(py, move |cancellation| {
        library::friction_problem(&text.study()?, &job, increment, cancellation)
    })?;
    problem_arrays(py, problem)
}

/// Returns a discrete friction problem as a dictionary.
pub(crate) fn problem_arrays<'py>(
    py: Python<'py>,
    problem: FrictionProblem,
) -> PyResult<Bound<'py, PyDict>> {
    let FrictionProblem { elements, compliance, free, mu, forces, displacements } = problem;
    let rows = free.len();
    let named = PyDict::new(py);
    let elements: Vec<i64> = elements.into_iter().map(|element| element as i64).collect();
    named.set_item("elements", elements.into_pyarray(py))?;
    named.set_item("W", compliance.into_pyarray(py).reshape([rows, rows])?)?;
    named.set_item("q", free.into_pyarray(py))?;
    named.set_item("mu", mu)?;
    named.set_item("r", forces.into_pyarray(py))?;
    named.set_item("u", displacements.into_pyarray(py))?;
    Ok(named)
}

/// Returns columns as a list of dictionaries.
pub(crate) fn described<'py>(
    py: Python<'py>,
    columns: &[Column],
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let described = |column: &Column| {
        let entry = PyDict::new(py);
        entry.set_item("name", column.name.as_ref())?;
        entry.set_item("unit", column.unit())?;
        entry.set_item("kind", column.role.name())?;
        entry.set_item("meaning", column.meaning)?;
        Ok(entry)
    };
    columns.iter().map(described).collect()
}
