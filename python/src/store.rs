//! Stores that are read.

use std::path::PathBuf;
use std::sync::Arc;

use answers::Selection;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use report::TypedColumn;
use tribosweep::library::{ReadStore, StoredFields, TypedTable, TypedValues};

use crate::fields::{arrays, path_arrays};
use crate::study::{described, outline, problem_arrays};
use crate::threads::{detached, interruptible};

/// A store that is read beside whatever run is writing it. Every question is answered from what is
/// there when it is asked.
#[pyclass(name = "Store", frozen, module = "tribosweep._native")]
pub(crate) struct StoreObject {
    store: Arc<ReadStore>,
}

#[pymethods]
impl StoreObject {
    #[new]
    fn new(py: Python<'_>, directory: PathBuf) -> PyResult<Self> {
        Ok(StoreObject { store: Arc::new(detached(py, || ReadStore::open(&directory))?) })
    }

    /// Returns what is to be said of the place from which records are read.
    fn notes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        detached(py, || self.store.notes())
    }

    /// Returns the names of the studies.
    fn names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        detached(py, || self.store.names())
    }

    /// Returns what a study is.
    fn study<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyDict>> {
        let study = detached(py, || self.store.study(name))?;
        outline(py, &study)
    }

    /// Returns the columns of a study.
    #[pyo3(signature = (name, steps))]
    fn columns<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        steps: bool,
    ) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let study = detached(py, || self.store.study(name))?;
        described(py, &Selection { steps, ..Selection::default() }.all_columns(&study))
    }

    /// Returns what is chosen of a study: a dictionary for each column.
    #[pyo3(signature = (name, filter, columns, sort, steps))]
    fn table<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        filter: Option<String>,
        columns: Vec<String>,
        sort: Vec<String>,
        steps: bool,
    ) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let selection = Selection { filter, sort, columns, steps };
        let TypedTable { columns, values } = detached(py, || self.store.table(name, selection))?;
        columns.into_iter().zip(values).map(|(head, values)| column(py, head, values)).collect()
    }

    /// Returns the key in full that begins with some characters.
    fn key(&self, py: Python<'_>, beginning: &str) -> PyResult<String> {
        detached(py, || self.store.key(beginning))
    }

    /// Returns the fields of the result whose key begins with some characters.
    fn fields<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyDict>> {
        let StoredFields { fields, key, is_certified } = detached(py, || self.store.fields(key))?;
        let named = arrays(py, fields)?;
        named.set_item("key", key)?;
        named.set_item("certified", is_certified)?;
        Ok(named)
    }

    /// Returns the fields of all increments of the result whose key begins with some characters.
    fn path_fields<'py>(&self, py: Python<'py>, key: String) -> PyResult<Bound<'py, PyDict>> {
        let store = Arc::clone(&self.store);
        let fields = interruptible(py, move |cancellation| store.path_fields(&key, cancellation))?;
        path_arrays(py, fields)
    }

    /// Returns the discrete friction problem of an increment of the result whose key begins with
    /// some characters.
    #[pyo3(signature = (key, increment))]
    fn friction_problem<'py>(
        &self,
        py: Python<'py>,
        key: String,
        increment: Option<u64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let store = Arc::clone(&self.store);
        let problem = interruptible(py, move |cancellation| {
            store.friction_problem(&key, increment, cancellation)
        })?;
        problem_arrays(py, problem)
    }

    /// Returns everything about the result whose key begins with some characters, as JSON.
    fn show(&self, py: Python<'_>, key: &str) -> PyResult<String> {
        detached(py, || Ok(self.store.show(key)?.to_string()))
    }
}

/// Returns a column with its values. Where a number or a flag is missing, `missing` is true, and
/// there is 0, NaN or false; a missing text is None.
fn column<'py>(
    py: Python<'py>,
    column: TypedColumn,
    values: TypedValues,
) -> PyResult<Bound<'py, PyDict>> {
    let entry = PyDict::new(py);
    entry.set_item("name", column.head.name)?;
    entry.set_item("unit", column.head.unit)?;
    entry.set_item("meaning", column.meaning)?;
    match values {
        TypedValues::Flag { values, missing } => {
            entry.set_item("values", values.into_pyarray(py))?;
            entry.set_item("missing", missing.into_pyarray(py))?;
        }
        TypedValues::Integer { values, missing } => {
            entry.set_item("values", values.into_pyarray(py))?;
            entry.set_item("missing", missing.into_pyarray(py))?;
        }
        TypedValues::Number { values, missing } => {
            entry.set_item("values", values.into_pyarray(py))?;
            entry.set_item("missing", missing.into_pyarray(py))?;
        }
        TypedValues::Text(values) => entry.set_item("values", values)?,
    }
    Ok(entry)
}
