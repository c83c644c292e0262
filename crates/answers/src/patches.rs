//! The separate regions of a contact, read from its fields.

use contact::assess;
use contact::model::{Fields, Scene, SceneError, State};
use contact::punch::{RailPlace, Surfaces, rail_places};
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
    /// The place of the centre of pressure on a rail.
    #[serde(flatten)]
    rail: Option<PatchOnRail>,
}

/// The place of a patch on a rail, in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PatchOnRail {
    /// The coordinate y in the track \[m\], positive to the right.
    track_y: f64,
    /// The coordinate z in the track \[m\], positive downwards.
    track_z: f64,
    /// The inclination of the rail under the patch \[rad\], from y towards z.
    angle: f64,
    /// The inclination of the plane in which the patch was computed \[rad\], from y towards z.
    plane_angle: f64,
}

/// Puts the patches of a wheel on their rail. Those of another punch stay as they are.
///
/// # Errors
/// A [`SceneError`] says that a profile is missing or that the wheel does not meet its rail.
pub fn place_on_rail(
    patches: &mut [Patch],
    scene: &Scene,
    surfaces: &Surfaces,
) -> Result<(), SceneError> {
    let centers: Vec<[f64; 2]> = patches.iter().map(|patch| [patch.x, patch.y]).collect();
    let places = rail_places(scene, surfaces, &centers)?.unwrap_or_default();
    for (patch, RailPlace { track: [_, track_y, track_z], rail_angle, plane_angle }) in
        patches.iter_mut().zip(places)
    {
        patch.rail = Some(PatchOnRail { track_y, track_z, angle: rail_angle, plane_angle });
    }
    Ok(())
}

/// The inclination of a patch to its plane of contact from which on it is worth a warning \[rad\].
/// The plane then shows the gap's curvature across the rail larger by 1/cos³, 1.5 %.
const INCLINED: f64 = 0.1;

/// Says how the patches of a wheel are inclined, and what the plane of contact makes of it.
pub fn inclination_words(patches: &[Patch]) -> Option<String> {
    let angles = |angle: fn(&PatchOnRail) -> f64| -> Vec<f64> {
        patches.iter().filter_map(|patch| patch.rail.as_ref().map(angle)).collect()
    };
    let (rail, plane) = (angles(|rail| rail.angle), angles(|rail| rail.plane_angle));
    if rail.len() < 2 {
        return None;
    }
    let list = |angles: &[f64]| {
        angles.iter().map(|angle| format!("{angle:.3}")).collect::<Vec<_>>().join(", ")
    };
    let is_shared = plane.windows(2).all(|two| two[0] == two[1]);
    let planes = if is_shared {
        format!("they share one plane of contact, inclined by {:.3} rad", plane[0])
    } else {
        format!("each has a plane of contact of its own, inclined by {} rad", list(&plane))
    };
    let off = rail.iter().zip(&plane).map(|(rail, plane)| (rail - plane).abs()).fold(0.0, f64::max);
    let doubt = if off > INCLINED {
        format!(
            "\n  a patch is inclined to its plane by up to {off:.3} rad: the plane shows its gap \
             steeper and its width smaller, and `normal_force` is along the normal of the plane"
        )
    } else {
        String::new()
    };
    Some(format!(
        "  the rail is inclined by {} rad under the patches; {planes}{doubt}\n",
        list(&rail)
    ))
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
        rail: None,
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
    let on_rail = [("track_y", "m"), ("track_z", "m"), ("angle", "rad"), ("plane_angle", "rad")];
    let is_on_rail = patches.iter().any(|patch| patch.rail.is_some());
    let heads = heads.chain(on_rail.into_iter().filter(|_| is_on_rail));
    let rows = patches.iter().enumerate().map(|(index, p)| {
        let numbers =
            [p.area, p.load, p.peak_pressure, p.x, p.y, p.x_from, p.x_to, p.y_from, p.y_to];
        let place = p.rail.map(|rail| [rail.track_y, rail.track_z, rail.angle, rail.plane_angle]);
        [Cell::Integer(index as i64 + 1)]
            .into_iter()
            .chain(numbers.into_iter().chain(place.into_iter().flatten()).map(Cell::Number))
            .collect()
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
                    y_to: 4.0,
                    rail: None,
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
                    y_to: 4.0,
                    rail: None,
                },
            ]
        );
        assert_eq!(table(&found).unwrap().rows().len(), 2);
        assert!(patches(&Fields::default()).is_empty());
    }
}
