//! The module `tribosweep._native`: scenes are solved and stores are read in this process, and
//! arrays come back. The Python files beside it make of that what people use.
//!
//! Python's lock is released while anything is computed or read.

mod error;
mod fields;
mod store;
mod study;
mod threads;

use pyo3::prelude::*;

#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::store::StoreObject;
    #[pymodule_export]
    use crate::study::{check, friction_problem, path_fields, solve};
}
