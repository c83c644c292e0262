//! Fields as arrays.

use contact::model::Fields;
use numpy::{Element, IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Returns fields as a dictionary of arrays: `x` and `y` are the centres of the elements \[m\], the
/// others have the shape (y, x). `friction_work` is computed of them. Only a scene that wears has
/// `wear_depth`.
pub(crate) fn arrays<'py>(py: Python<'py>, fields: Fields) -> PyResult<Bound<'py, PyDict>> {
    let [nx, ny] = fields.shape.map(|n| n as usize);
    stacked(py, vec![fields], &[ny, nx])
}

/// Returns the fields of all increments as a dictionary of arrays: `x` and `y` are the centres of
/// the elements \[m\], the others have the shape (increment, y, x).
pub(crate) fn path_arrays<'py>(py: Python<'py>, path: Vec<Fields>) -> PyResult<Bound<'py, PyDict>> {
    let [nx, ny] = path.first().map_or([0; 2], |fields| fields.shape.map(|n| n as usize));
    let shape = [path.len(), ny, nx];
    stacked(py, path, &shape)
}

fn stacked<'py>(
    py: Python<'py>,
    mut path: Vec<Fields>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyDict>> {
    let named = PyDict::new(py);
    let Some(Fields { shape: elements, origin, element, .. }) = path.first() else {
        return Ok(named);
    };
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        let centre = |index: u32| origin[axis] + f64::from(index) * element[axis];
        let centres: Vec<f64> = (0..elements[axis]).map(centre).collect();
        named.set_item(name, centres.into_pyarray(py))?;
    }
    let work: Vec<f64> = path.iter().flat_map(Fields::friction_work).collect();
    named.set_item("friction_work", work.into_pyarray(py).reshape(shape)?)?;
    let numbers: [FieldOf<f64>; 6] = [
        ("pressure", |fields| &mut fields.pressure),
        ("traction_x", |fields| &mut fields.traction_x),
        ("traction_y", |fields| &mut fields.traction_y),
        ("gap", |fields| &mut fields.gap),
        ("slip_x", |fields| &mut fields.slip_x),
        ("slip_y", |fields| &mut fields.slip_y),
    ];
    let wears = path.iter().all(|fields| !fields.further.wear_depth.is_empty());
    let wear: FieldOf<f64> = ("wear_depth", |fields| &mut fields.further.wear_depth);
    for number in numbers.into_iter().chain(wears.then_some(wear)) {
        set(&named, &mut path, number, shape)?;
    }
    set(&named, &mut path, ("state", |fields| &mut fields.state), shape)?;
    Ok(named)
}

/// A field with its name.
type FieldOf<T> = (&'static str, fn(&mut Fields) -> &mut Vec<T>);

/// Takes a field out of all increments, one after the other.
fn set<T: Element + Clone>(
    named: &Bound<'_, PyDict>,
    path: &mut [Fields],
    (name, field): FieldOf<T>,
    shape: &[usize],
) -> PyResult<()> {
    let values = match path {
        [only] => std::mem::take(field(only)),
        _ => path.iter_mut().flat_map(|fields| std::mem::take(field(fields))).collect(),
    };
    named.set_item(name, values.into_pyarray(named.py()).reshape(shape)?)
}
