//! Stores that are read.

use std::path::PathBuf;

use answers::Selection;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use report::{Cell, CellType};
use tribosweep::library::{ReadStore, StoredFields, TypedTable};

use crate::fields::arrays;
use crate::study::{described, outline};
use crate::threads::detached;

/// A store that is read beside whatever run is writing it. Every question is answered from what is
/// there when it is asked.
#[pyclass(frozen, module = "tribosweep._native")]
pub(crate) struct Store {
    store: ReadStore,
}

#[pymethods]
impl Store {
    #[new]
    fn new(py: Python<'_>, directory: PathBuf) -> PyResult<Self> {
        Ok(Store { store: detached(py, || ReadStore::open(&directory))? })
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
        let table = detached(py, || self.store.table(name, selection))?;
        (0..table.columns.len()).map(|index| column(py, &table, index)).collect()
    }

    /// Returns the fields of the result whose key begins with some characters.
    fn fields<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyDict>> {
        let StoredFields { fields, key, is_certified } = detached(py, || self.store.fields(key))?;
        let named = arrays(py, fields)?;
        named.set_item("key", key)?;
        named.set_item("certified", is_certified)?;
        Ok(named)
    }

    /// Returns everything about the result whose key begins with some characters, as JSON.
    fn show(&self, py: Python<'_>, key: &str) -> PyResult<String> {
        detached(py, || Ok(self.store.show(key)?.to_string()))
    }
}

/// Returns a column with its values. Where a number is missing, `missing` is true, and there is 0
/// or NaN; a missing text is None.
fn column<'py>(py: Python<'py>, table: &TypedTable, index: usize) -> PyResult<Bound<'py, PyDict>> {
    let column = &table.columns[index];
    let cells = || table.rows.rows().iter().map(|row| &row[index]);
    let entry = PyDict::new(py);
    entry.set_item("name", &column.head.name)?;
    entry.set_item("unit", &column.head.unit)?;
    entry.set_item("meaning", &column.meaning)?;
    if column.cells != CellType::Text {
        let missing: Vec<bool> = cells().map(|cell| *cell == Cell::Missing).collect();
        entry.set_item("missing", missing.into_pyarray(py))?;
    }
    match column.cells {
        CellType::Integer => {
            let value = |cell: &Cell| match cell {
                Cell::Integer(value) => *value,
                _ => 0,
            };
            entry.set_item("values", cells().map(value).collect::<Vec<i64>>().into_pyarray(py))?;
        }
        CellType::Number => {
            let value = |cell: &Cell| match cell {
                Cell::Number(value) => *value,
                Cell::Integer(value) => *value as f64,
                _ => f64::NAN,
            };
            entry.set_item("values", cells().map(value).collect::<Vec<f64>>().into_pyarray(py))?;
        }
        CellType::Text => {
            let texts: Vec<Option<String>> =
                cells().map(|cell| Some(cell.exact()?.into_owned())).collect();
            entry.set_item("values", texts)?;
        }
    }
    Ok(entry)
}
