//! Studies: what they are, and the result of one that is a single scene.

use std::collections::BTreeMap;

use ::study::{Column, Study};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use tribosweep::library::{self, StudyText};

use crate::fields::arrays;
use crate::threads::detached;

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
    outline.set_item("points", study.len())?;
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
    let result = detached(py, || library::solve(&StudyText { text, path, files }))?;
    let solved = PyDict::new(py);
    solved.set_item("json", result.json.to_string())?;
    solved.set_item("columns", described(py, &result.columns)?)?;
    solved.set_item("doubts", result.doubts)?;
    solved.set_item("fields", result.fields.map(|fields| arrays(py, fields)).transpose()?)?;
    Ok(solved)
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
