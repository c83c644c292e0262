//! Fields as arrays.

use contact::model::Fields;
use numpy::{Element, IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Returns fields as a dictionary of arrays: `x` and `y` are the centres of the elements \[m\], the
/// others have the shape (y, x).
pub(crate) fn arrays<'py>(py: Python<'py>, fields: Fields) -> PyResult<Bound<'py, PyDict>> {
    let Fields { shape, origin, element, .. } = fields;
    let shape = shape.map(|n| n as usize);
    let centres = |axis: usize| -> Vec<f64> {
        (0..shape[axis]).map(|index| origin[axis] + index as f64 * element[axis]).collect()
    };
    let named = PyDict::new(py);
    named.set_item("x", centres(0).into_pyarray(py))?;
    named.set_item("y", centres(1).into_pyarray(py))?;
    set(&named, "pressure", fields.pressure, shape)?;
    set(&named, "traction_x", fields.traction_x, shape)?;
    set(&named, "traction_y", fields.traction_y, shape)?;
    set(&named, "gap", fields.gap, shape)?;
    set(&named, "slip_x", fields.slip_x, shape)?;
    set(&named, "slip_y", fields.slip_y, shape)?;
    set(&named, "state", fields.state, shape)?;
    Ok(named)
}

fn set<T: Element>(
    named: &Bound<'_, PyDict>,
    name: &str,
    values: Vec<T>,
    [nx, ny]: [usize; 2],
) -> PyResult<()> {
    named.set_item(name, values.into_pyarray(named.py()).reshape([ny, nx])?)
}
