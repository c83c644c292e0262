//! The places on a rail that belong to points of Ω.

use super::gap::Gap;
use super::placement::PlacedWheel;
use super::surface::Surfaces;
use crate::model::{Scene, SceneError};

/// A place in the plane of contact between a wheel and a rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RailPlace {
    /// The point of the rail, in track coordinates \[m\].
    pub track: [f64; 3],
    /// The inclination of the rail there \[rad\], from y towards z.
    pub rail_angle: f64,
    /// The inclination of the plane of contact there \[rad\]; patches far apart have planes of
    /// their own.
    pub plane_angle: f64,
}

/// Returns the places on the rail of `points` (x, y) \[m\] in Ω. It is `None` if the punch of
/// `scene` is no wheel, or a point is beside the rail.
///
/// # Errors
/// A [`SceneError`] says that a profile is missing or that the wheel does not meet its rail.
pub fn rail_places(
    scene: &Scene,
    surfaces: &Surfaces,
    points: &[[f64; 2]],
) -> Result<Option<Vec<RailPlace>>, SceneError> {
    let gap = Gap::new(scene, surfaces)?;
    let Some(PlacedWheel { pair, plane, .. }) = gap.wheel_on_rail() else { return Ok(None) };
    let place = |[x, y]: &[f64; 2]| {
        let track = pair.onto_rail(plane.to_track(*x, *y));
        let rail_angle = pair.rail_angle(track[1])?;
        Some(RailPlace { track, rail_angle, plane_angle: plane.angle(*y) })
    };
    Ok(points.iter().map(place).collect())
}
