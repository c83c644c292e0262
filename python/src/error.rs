//! Errors of Rust as exceptions of the package.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use tribosweep::library::{FaultKind, kind, places, words};

/// Returns the exception that says the words of an error; that of a study has its places.
pub(crate) fn exception(py: Python<'_>, error: &anyhow::Error) -> PyErr {
    let name = match kind(error) {
        FaultKind::Study => "StudyError",
        FaultKind::Store => "StoreError",
        FaultKind::Query => "QueryError",
        FaultKind::Other => "Error",
    };
    let raised = || -> PyResult<PyErr> {
        let class = py.import("tribosweep._errors")?.getattr(name)?;
        let raised = class.call1((words(error),))?;
        if kind(error) == FaultKind::Study {
            let places: Vec<(usize, usize, String)> = places(error)
                .into_iter()
                .map(|place| (place.line, place.column, place.message))
                .collect();
            raised.setattr("places", places)?;
        }
        Ok(PyErr::from_value(raised))
    };
    raised().unwrap_or_else(|_| PyRuntimeError::new_err(words(error)))
}
