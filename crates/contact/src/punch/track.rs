//! The positions of wheel and rail in the track, and the checks that they make sense.
//!
//! The track coordinates are x along the track, y to the right and z down. Their origin is in the
//! middle of the track at the height of the rails' tops.

use std::f64::consts::PI;

use super::curve::Curve;
use super::profile::{Profile, ProfileKind};
use crate::model::Side;

/// The position of the rails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track {
    /// The distance between the rails' gauge faces \[m\].
    pub gauge: f64,
    /// The depth below the rails' tops down to which the gauge is measured \[m\].
    pub gauge_depth: f64,
}

/// The position of the wheels on their axle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheelset {
    /// The radius of the wheel at its profile's z = 0 \[m\].
    pub rolling_radius: f64,
    /// The distance between the backs of the flanges \[m\].
    pub flange_back_distance: f64,
    /// The distance from the back of the flange to the profile's y = 0 \[m\].
    pub flange_back_to_origin: f64,
}

/// The position of the wheelset. Its height follows, for the wheel just touches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Position {
    /// The lateral displacement of the middle of the axle along y \[m\].
    pub lateral: f64,
    /// The yaw ψ about z \[rad\]: a positive one turns x towards y.
    pub yaw: f64,
    /// The roll φ about the track's x \[rad\], after the yaw: a positive one lowers the right
    /// wheel.
    pub roll: f64,
}

/// The reason why a wheel and a rail make no contact.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WheelRailError {
    /// A profile is one of the other kind.
    #[error("the {role}'s profile is one of a {found}; give a {role}'s")]
    Kind {
        /// The body that it was given for.
        role: &'static str,
        /// The body that it is a profile of.
        found: &'static str,
    },
    /// A length or an angle has no meaning.
    #[error("{name} = {value:e}: {expected}")]
    Value {
        /// The name of the quantity.
        name: &'static str,
        /// Its value \[m\] or \[rad\].
        value: f64,
        /// The range that would be right.
        expected: &'static str,
    },
    /// A profile lies the wrong way round.
    #[error(
        "the lowest point of the wheel's profile, at y = {y:e} m, is on the field side; the flange must lie at negative y, mirror the profile"
    )]
    Flange {
        /// The coordinate y of the lowest point \[m\].
        y: f64,
    },
    /// The gauge cannot be measured.
    #[error(
        "the rail's profile ends {depth:e} m below its top on the gauge side (negative y); it must reach down {gauge_depth:e} m, where the gauge is measured"
    )]
    Shallow {
        /// The depth that the profile reaches \[m\].
        depth: f64,
        /// The depth asked for \[m\].
        gauge_depth: f64,
    },
    /// The wheel passes the rail.
    #[error(
        "the wheel covers y = {wheel:?} m and the rail y = {rail:?} m: one does not stand over the other; the lateral position must bring them together"
    )]
    Beside {
        /// The smallest and the largest y of the wheel \[m\].
        wheel: [f64; 2],
        /// The smallest and the largest y of the rail \[m\].
        rail: [f64; 2],
    },
    /// The wheel stands on the end of a profile, although the body does not end there.
    #[error(
        "at y = {y:e} m the wheel first meets the rail where a profile ends; the profiles must go on there, or the lateral position must be less extreme"
    )]
    ProfileEnd {
        /// The coordinate y in the track \[m\].
        y: f64,
    },
}

/// Refuses profiles, lengths and angles without meaning.
pub(super) fn check(
    wheel: &Profile,
    rail: &Profile,
    wheelset: &Wheelset,
    track: &Track,
    position: &Position,
) -> Result<(), WheelRailError> {
    if wheel.kind() != ProfileKind::Wheel {
        return Err(WheelRailError::Kind { role: "wheel", found: "rail" });
    }
    if rail.kind() != ProfileKind::Rail {
        return Err(WheelRailError::Kind { role: "rail", found: "wheel" });
    }
    for (name, value) in [
        ("rolling_radius", wheelset.rolling_radius),
        ("flange_back_distance", wheelset.flange_back_distance),
        ("gauge", track.gauge),
        ("gauge_depth", track.gauge_depth),
    ] {
        if value.is_nan() || value <= 0.0 || value > 10.0 {
            return Err(WheelRailError::Value {
                name,
                value,
                expected: "must be above 0 and at most 10 m",
            });
        }
    }
    for (name, value) in
        [("flange_back_to_origin", wheelset.flange_back_to_origin), ("lateral", position.lateral)]
    {
        if value.is_nan() || value.abs() > 10.0 {
            return Err(WheelRailError::Value { name, value, expected: "must be within ±10 m" });
        }
    }
    for (name, value) in [("yaw", position.yaw), ("roll", position.roll)] {
        if value.is_nan() || value.abs() > PI / 6.0 {
            return Err(WheelRailError::Value {
                name, value, expected: "must be within ±π/6 rad"
            });
        }
    }
    let points = wheel.curve().points();
    let lowest = points.iter().max_by(|a, b| a[1].total_cmp(&b[1])).copied().unwrap_or_default();
    let gauge_side =
        points.iter().filter(|p| p[0] < 0.0).map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max);
    // A wheel without a flange may have its lowest point anywhere, but not by the height of a
    // flange.
    if lowest[0] > 0.0 && lowest[1] > gauge_side + 0.01 {
        return Err(WheelRailError::Flange { y: lowest[0] });
    }
    Ok(())
}

/// Returns the curve of a right-hand profile on its side of the track, in the order of rising y.
pub(super) fn towards(curve: &Curve, side: Side) -> Curve {
    match side {
        Side::Right => curve.clone(),
        Side::Left => curve.mirrored(),
    }
}

/// Places the rail where the gauge puts it, with its top at z = 0. Returns its curve and the (y, z)
/// of its origin \[m\].
pub(super) fn placed(
    rail: &Curve,
    track: &Track,
    side: Side,
) -> Result<(Curve, [f64; 2]), WheelRailError> {
    let points: Vec<[f64; 2]> = rail.samples(8).into_iter().map(|t| rail.at(t).position).collect();
    let (highest, top) = points
        .iter()
        .enumerate()
        .min_by(|a, b| a.1[1].total_cmp(&b.1[1]))
        .map_or((0, 0.0), |(i, p)| (i, p[1]));
    // The points go from the top to the gauge side.
    let descent: Vec<[f64; 2]> = match side {
        Side::Right => points[..=highest].iter().rev().copied().collect(),
        Side::Left => points[highest..].to_vec(),
    };
    let limit = top + track.gauge_depth;
    let below = descent.iter().position(|p| p[1] >= limit);
    let Some(below) = below else {
        let depth = descent.iter().map(|p| p[1] - top).fold(0.0, f64::max);
        return Err(WheelRailError::Shallow { depth, gauge_depth: track.gauge_depth });
    };
    let inward = |y: f64| -side.sign() * y;
    let mut face = descent[..below].iter().map(|p| inward(p[0])).fold(f64::NEG_INFINITY, f64::max);
    if below > 0 {
        let (above, below) = (descent[below - 1], descent[below]);
        face = face.max(inward(
            above[0] + (below[0] - above[0]) * (limit - above[1]) / (below[1] - above[1]),
        ));
    }
    let origin = [side.sign() * (0.5 * track.gauge + face), -top];
    Ok((rail.clone().shifted(origin), origin))
}

/// Returns the rotation R_x(roll) R_z(yaw), row by row.
pub(super) fn rotation(yaw: f64, roll: f64) -> [[f64; 3]; 3] {
    let ((sy, cy), (sr, cr)) = (yaw.sin_cos(), roll.sin_cos());
    [[cy, -sy, 0.0], [sy * cr, cy * cr, -sr], [sy * sr, cy * sr, cr]]
}

/// The frame of the contact coordinates (x, s, n): x along the track, s across it in the plane of
/// contact, n into the rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The origin of the frame in track coordinates \[m\].
    pub origin: [f64; 3],
    /// The angle by which s is turned out of y towards z \[rad\], that is, the contact angle.
    pub angle: f64,
}

impl Frame {
    /// Converts (x, s, n) \[m\] to track coordinates \[m\].
    pub fn to_track(&self, [x, s, n]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = self.angle.sin_cos();
        [self.origin[0] + x, self.origin[1] + cos * s - sin * n, self.origin[2] + sin * s + cos * n]
    }

    /// Converts a point in track coordinates \[m\] to (x, s, n) \[m\].
    pub fn from_track(&self, position: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = self.angle.sin_cos();
        let [x, y, z] = [0, 1, 2].map(|c| position[c] - self.origin[c]);
        [x, cos * y + sin * z, cos * z - sin * y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_go_there_and_back() {
        let frame = Frame { origin: [0.1, -0.7, 0.02], angle: 0.4 };
        let back = frame.from_track(frame.to_track([1.0, 2.0, 3.0]));
        assert!(
            back.iter().zip([1.0, 2.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-15 * 10.0),
            "{back:?}"
        );
        // The axis s is turned from y towards z: the plane falls to the right.
        assert!(frame.to_track([0.0, 1.0, 0.0])[2] > 0.02);
    }
}
