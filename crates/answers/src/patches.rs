//! The separate regions of a contact, read from its fields.

use contact::assess;
use contact::model::{Fields, State};
use report::{Cell, DataTable, TableColumn};
use serde::Serialize;

use crate::error::AnswerError;

/// A separate region in contact, in SI units; elements that share a corner belong to the same
/// region.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Patch {
    area: f64,
    load: f64,
    peak_pressure: f64,
    /// The centre of pressure.
    x: f64,
    y: f64,
    /// The rectangle around it.
    x_from: f64,
    x_to: f64,
    y_from: f64,
    y_to: f64,
}

/// Returns the patches of a contact, the one that carries most first.
pub fn patches(fields: &Fields) -> Vec<Patch> {
    let in_contact = |element: usize| {
        fields.state.get(element).is_some_and(|state| *state >= State::Stick as u8)
    };
    let regions = assess::patches(fields.shape.map(|n| n as usize), in_contact);
    let mut patches: Vec<Patch> = regions.iter().map(|region| patch(fields, region)).collect();
    patches.sort_by(|a, b| b.load.total_cmp(&a.load));
    patches
}

fn patch(fields: &Fields, region: &[usize]) -> Patch {
    let nx = fields.shape[0] as usize;
    let [hx, hy] = fields.element;
    let element = hx * hy;
    let mut patch = Patch {
        area: region.len() as f64 * element,
        load: 0.0,
        peak_pressure: 0.0,
        x: 0.0,
        y: 0.0,
        x_from: f64::INFINITY,
        x_to: f64::NEG_INFINITY,
        y_from: f64::INFINITY,
        y_to: f64::NEG_INFINITY,
    };
    for &index in region {
        let pressure = fields.pressure.get(index).copied().unwrap_or(0.0);
        let (x, y) = (
            fields.origin[0] + (index % nx) as f64 * hx,
            fields.origin[1] + (index / nx) as f64 * hy,
        );
        patch.load += pressure * element;
        patch.peak_pressure = patch.peak_pressure.max(pressure);
        patch.x += pressure * element * x;
        patch.y += pressure * element * y;
        patch.x_from = patch.x_from.min(x - 0.5 * hx);
        patch.x_to = patch.x_to.max(x + 0.5 * hx);
        patch.y_from = patch.y_from.min(y - 0.5 * hy);
        patch.y_to = patch.y_to.max(y + 0.5 * hy);
    }
    // An element in contact has positive pressure, so the load is not zero.
    patch.x /= patch.load;
    patch.y /= patch.load;
    patch
}

/// Returns the patches as a table, in order, counted from 1.
///
/// # Errors
/// None is possible with patches: the error is of the table, which checks its rows.
pub fn table(patches: &[Patch]) -> Result<DataTable, AnswerError> {
    let heads =
        [("patch", "")].into_iter().chain([("area", "m²"), ("load", "N"), ("peak_pressure", "Pa")]);
    let heads = heads.chain(["x", "y", "x_from", "x_to", "y_from", "y_to"].map(|name| (name, "m")));
    let rows = patches.iter().enumerate().map(|(index, p)| {
        let numbers =
            [p.area, p.load, p.peak_pressure, p.x, p.y, p.x_from, p.x_to, p.y_from, p.y_to];
        [Cell::Integer(index as i64 + 1)].into_iter().chain(numbers.map(Cell::Number)).collect()
    });
    Ok(DataTable::new(
        heads.map(|(name, unit)| TableColumn::new(name, unit)).collect(),
        rows.collect(),
    )?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_that_touch_at_a_corner_are_one() {
        let state = vec![
            3, 0, 1, 2, //
            1, 2, 1, 2, //
            1, 1, 1, 1,
        ];
        let pressure = vec![
            1.0, 9.0, 0.0, 4.0, //
            0.0, 2.0, 0.0, 4.0, //
            0.0, 0.0, 0.0, 0.0,
        ];
        let fields = Fields {
            shape: [4, 3],
            origin: [0.5, 1.0],
            element: [1.0, 2.0],
            pressure,
            state,
            ..Fields::default()
        };
        let found = patches(&fields);
        assert_eq!(
            found,
            [
                Patch {
                    area: 4.0,
                    load: 16.0,
                    peak_pressure: 4.0,
                    x: 3.5,
                    y: 2.0,
                    x_from: 3.0,
                    x_to: 4.0,
                    y_from: 0.0,
                    y_to: 4.0
                },
                Patch {
                    area: 4.0,
                    load: 6.0,
                    peak_pressure: 2.0,
                    x: 7.0 / 6.0,
                    y: 7.0 / 3.0,
                    x_from: 0.0,
                    x_to: 2.0,
                    y_from: 0.0,
                    y_to: 4.0
                },
            ]
        );
        assert_eq!(table(&found).unwrap().rows().len(), 2);
        assert!(patches(&Fields::default()).is_empty());
    }
}
