//! A wheel on a rail: the points at which the two touch, and the plane of their contact.
//!
//! In the coordinates of the [track](super::track) the rail is a cylinder along x. The wheel is a
//! surface of revolution about the axle. First the wheelset's yaw ψ about z and then its roll φ
//! about the track's x turn the axle out of the y-axis: the rotation is R_x(φ) R_z(ψ). Seen along
//! the rail, the wheel is bounded by its silhouette, the points whose normal has no x-component.
//! Each point of its profile has at most one of these, in closed form. The two bodies therefore
//! touch where, in the plane (y, z), the silhouette touches the rail's profile.

use super::curve::{Curve, CurvePoint, Graph};
use super::profile::Profile;
use super::track::{
    Frame, Position, Track, WheelRailError, Wheelset, check, placed, rotation, towards,
};
use crate::model::Side;

/// A point at which the gap along z between wheel and rail has a local minimum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Touch {
    /// The position on the rail, in track coordinates \[m\].
    pub position: [f64; 3],
    /// The inclination of the common tangent \[rad\], from y towards z.
    pub angle: f64,
    /// The gap along z \[m\], which is 0 where the bodies touch.
    pub gap: f64,
    /// The parameter of the wheel's curve \[m\].
    pub(crate) wheel: f64,
}

/// The curvatures of a gap where it is smallest: g₀ ≈ ½(xx x² + 2 xs x s + ss s²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curvatures {
    /// The curvature along x \[1/m\].
    pub xx: f64,
    /// The mixed curvature \[1/m\].
    pub xs: f64,
    /// The curvature along s \[1/m\].
    pub ss: f64,
}

impl Curvatures {
    /// Returns the smaller and the larger principal curvature \[1/m\], and the direction of the
    /// smaller one, from x towards s \[rad\]. Hertz's theory applies where both curvatures are
    /// above 0.
    pub fn principal(&self) -> ([f64; 2], f64) {
        let (mean, half) = (0.5 * (self.xx + self.ss), 0.5 * (self.xx - self.ss));
        let spread = half.hypot(self.xs);
        // The larger one has no cancellation; the smaller one follows from the determinant.
        let larger = mean + spread;
        let smaller = if mean > 0.0 {
            (self.xx * self.ss - self.xs * self.xs) / larger
        } else {
            mean - spread
        };
        ([smaller, larger], 0.5 * (-self.xs).atan2(-half))
    }
}

/// A wheel that just touches a rail.
#[derive(Clone, Debug)]
pub struct WheelOnRail {
    /// The profile of the wheel, turned to its side of the track, in the order of rising y along
    /// the tread.
    pub(crate) wheel: Curve,
    /// The coordinate y of the origin of the wheel's profile, along the axle \[m\].
    pub(crate) wheel_origin: f64,
    pub(crate) radius: f64,
    /// The rotation from the wheelset to the track.
    pub(crate) rotation: [[f64; 3]; 3],
    /// The middle of the axle, in track coordinates \[m\].
    pub(crate) center: [f64; 3],
    /// The profile of the rail, turned likewise, in track coordinates.
    pub(crate) rail: Curve,
    /// The coordinates y and z of the origin of the rail's profile \[m\].
    rail_origin: [f64; 2],
    /// The section of the rail that is seen from above.
    top: Graph,
    touches: Vec<Touch>,
}

/// A point of the silhouette.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Silhouette {
    /// The position in track coordinates \[m\].
    pub(crate) position: [f64; 3],
    /// The inclination in the plane (y, z) \[rad\].
    pub(crate) angle: f64,
}

/// The gap at a point of the silhouette.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clearance {
    /// The gap along z \[m\].
    pub(super) gap: f64,
    /// The point of the silhouette.
    pub(super) wheel: Silhouette,
    /// The point of the rail below it.
    pub(super) rail: CurvePoint,
}

impl WheelOnRail {
    /// Puts the wheel on the rail. The profiles are those of the right side; for the left they are
    /// mirrored.
    ///
    /// # Errors
    /// A [`WheelRailError`] names a profile, length or angle without meaning, or says why the two
    /// make no contact.
    pub fn new(
        wheel: &Profile,
        rail: &Profile,
        wheelset: &Wheelset,
        track: &Track,
        side: Side,
        position: &Position,
    ) -> Result<Self, WheelRailError> {
        check(wheel, rail, wheelset, track, position)?;
        let wheel = towards(wheel.curve(), side);
        let rail = towards(rail.curve(), side);
        let (rail, rail_origin) = placed(&rail, track, side)?;
        let wheel_origin =
            side.sign() * (0.5 * wheelset.flange_back_distance + wheelset.flange_back_to_origin);
        let samples = rail.samples(4).into_iter().map(|t| [t, rail.at(t).position[1]]);
        let highest = samples.min_by(|a, b| a[1].total_cmp(&b[1])).map_or(0.0, |sample| sample[0]);
        let top = Graph::new(&rail, [1.0, 0.0], highest);
        let mut pair = Self {
            wheel,
            wheel_origin,
            radius: wheelset.rolling_radius,
            rotation: rotation(position.yaw, position.roll),
            center: [0.0, position.lateral, -wheelset.rolling_radius],
            rail,
            rail_origin,
            top,
            touches: Vec::new(),
        };
        let mut touches = pair.smallest_gaps()?;
        touches.sort_by(|a, b| a.gap.total_cmp(&b.gap));
        let height = touches[0].gap;
        touches.iter_mut().for_each(|touch| touch.gap -= height);
        pair.center[2] += height;
        pair.touches = touches;
        Ok(pair)
    }

    /// Returns the height \[m\] of the middle of the axle, counted downwards from the one at which
    /// the rolling radius reaches the rails' tops.
    pub fn height(&self) -> f64 {
        self.center[2] + self.radius
    }

    /// Returns all points with a locally smallest gap, the touching one first.
    pub(crate) fn touches(&self) -> &[Touch] {
        &self.touches
    }

    /// Returns the frame whose origin is the touching point and whose plane is the common tangent
    /// plane.
    pub fn tangent_frame(&self) -> Frame {
        Frame { origin: self.touches[0].position, angle: self.touches[0].angle }
    }

    /// Returns the curvatures of the gap at the touching point, in the tangent frame.
    pub fn curvatures(&self) -> Curvatures {
        let touch = self.touches[0];
        let point = self.wheel.at(touch.wheel);
        let [dy, dz] = point.tangent.map(|v| v / point.tangent[0].hypot(point.tangent[1]));
        let position =
            self.silhouette(touch.wheel).map_or(touch.position, |silhouette| silhouette.position);
        // The transpose of the rotation gives the axes of the frame in the coordinates of the
        // wheelset.
        let back = |v: [f64; 3]| {
            [0, 1, 2].map(|c| {
                self.rotation[0][c] * v[0] + self.rotation[1][c] * v[1] + self.rotation[2][c] * v[2]
            })
        };
        let [x, _, z] = back([0, 1, 2].map(|c| position[c] - self.center[c]));
        let radius = x.hypot(z);
        let (sin, cos) = (x / radius, z / radius);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (rail_sin, rail_cos) = touch.angle.sin_cos();
        let axes = [back([1.0, 0.0, 0.0]), back([0.0, rail_cos, rail_sin])];
        let [mx, ms] = axes.map(|axis| dot(axis, [dz * sin, dy, dz * cos]));
        let [cx, cs] = axes.map(|axis| dot(axis, [cos, 0.0, -sin]));
        let rail = self.top.at(touch.position[1]).map_or(0.0, |point| point.curvature());
        // Towards n, the profile of the wheel bends with its own curvature, and its circle against
        // it.
        let (meridian, circle) = (point.curvature(), dy / radius);
        Curvatures {
            xx: circle * cx * cx - meridian * mx * mx,
            xs: circle * cx * cs - meridian * mx * ms,
            ss: circle * cs * cs - meridian * ms * ms + rail,
        }
    }

    /// Returns the point of the rail straight below or above a point in track coordinates \[m\], or
    /// the point itself if it is beside the rail.
    pub(crate) fn onto_rail(&self, position: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = position;
        [x, y, self.top.at(y).map_or(z, |point| point.position[1])]
    }

    /// Returns the inclination \[rad\] of the rail at y \[m\] in the track, or `None` beside it.
    pub(super) fn rail_angle(&self, y: f64) -> Option<f64> {
        self.top.at(y).map(|point| point.angle())
    }

    /// Returns the parameter \[m\] of the rail's curve at its sample that is nearest to the point
    /// of the silhouette with the parameter `wheel` \[m\] of the wheel's curve.
    pub(super) fn rail_below(&self, wheel: f64) -> f64 {
        let [_, y, z] = self.gap_at(wheel).map_or(self.touches[0].position, |clearance| {
            let [y, z] = clearance.rail.position;
            [0.0, y, z]
        });
        let distance = |t: f64| {
            let [rail_y, rail_z] = self.rail.at(t).position;
            (rail_y - y).hypot(rail_z - z)
        };
        let samples = self.rail.samples(4).into_iter().map(|t| [t, distance(t)]);
        samples.min_by(|a, b| a[1].total_cmp(&b[1])).map_or(0.0, |nearest| nearest[0])
    }

    /// Converts a point in track coordinates \[m\] to (y, z) \[m\] in the coordinates of the rail's
    /// profile, with y towards the right as in the track.
    pub fn to_rail(&self, position: [f64; 3]) -> [f64; 2] {
        [position[1] - self.rail_origin[0], position[2] - self.rail_origin[1]]
    }

    /// Returns the point of the silhouette that belongs to a parameter \[m\] of the wheel's curve.
    /// It is `None` where the curve goes back over y or is so steep that the yaw hides it.
    pub(crate) fn silhouette(&self, parameter: f64) -> Option<Silhouette> {
        let CurvePoint { position: [y, z], tangent: [dy, dz], .. } = self.wheel.at(parameter);
        let [rx, ry, rz] = self.rotation[0];
        let sine = ry * dz / (dy * rx.hypot(rz));
        if dy.is_nan() || dy <= 0.0 || sine.is_nan() || sine.abs() >= 1.0 {
            return None;
        }
        let (sin, cos) = (sine.asin() - rz.atan2(rx)).sin_cos();
        let radius = self.radius + z;
        let [_, ny, nz] = turned(&self.rotation, [dy * sin, -dz, dy * cos]);
        let position = turned(&self.rotation, [radius * sin, self.wheel_origin + y, radius * cos]);
        (radius > 0.0 && nz > 0.0).then(|| Silhouette {
            position: [0, 1, 2].map(|c| position[c] + self.center[c]),
            angle: (-ny).atan2(nz),
        })
    }

    /// Returns the gap along z \[m\] at a point of the silhouette, with that point and the point of
    /// the rail below it.
    pub(super) fn gap_at(&self, parameter: f64) -> Option<Clearance> {
        let wheel = self.silhouette(parameter)?;
        let rail = self.top.at(wheel.position[1])?;
        Some(Clearance { gap: rail.position[1] - wheel.position[2], wheel, rail })
    }

    /// Finds all local minima of the gap along z.
    fn smallest_gaps(&self) -> Result<Vec<Touch>, WheelRailError> {
        // The sign is that of the gap's derivative with respect to y.
        let opening =
            |t: f64| self.gap_at(t).map(|Clearance { wheel, rail, .. }| rail.angle() - wheel.angle);
        let samples: Vec<(f64, Option<f64>)> =
            self.wheel.samples(8).into_iter().map(|t| (t, opening(t))).collect();
        let mut touches = Vec::new();
        for pair in samples.windows(2) {
            let [(mut low, Some(before)), (mut high, Some(after))] = [pair[0], pair[1]] else {
                continue;
            };
            if !(before < 0.0 && after >= 0.0) {
                continue;
            }
            for _ in 0..60 {
                let half = 0.5 * (low + high);
                match opening(half) {
                    Some(slope) if slope < 0.0 => low = half,
                    _ => high = half,
                }
            }
            if let Some(Clearance { gap, wheel, rail }) = self.gap_at(high) {
                touches.push(Touch {
                    position: [wheel.position[0], rail.position[0], rail.position[1]],
                    angle: rail.angle(),
                    gap,
                    wheel: high,
                });
            }
        }
        let least = touches.iter().map(|touch| touch.gap).fold(f64::INFINITY, f64::min);
        let lowest = samples
            .iter()
            .filter_map(|(t, _)| self.gap_at(*t))
            .min_by(|a, b| a.gap.total_cmp(&b.gap));
        match lowest {
            // A sample beside a minimum may undercut it by rounding.
            Some(Clearance { gap, wheel, .. }) if gap < least - 1e-12 => {
                Err(WheelRailError::ProfileEnd { y: wheel.position[1] })
            }
            Some(_) => Ok(touches),
            None => {
                let ys: Vec<f64> = samples
                    .iter()
                    .filter_map(|(t, _)| self.silhouette(*t))
                    .map(|s| s.position[1])
                    .collect();
                let wheel = [
                    ys.iter().copied().fold(f64::INFINITY, f64::min),
                    ys.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                ];
                Err(WheelRailError::Beside {
                    wheel,
                    rail: self.top.range().unwrap_or([f64::NAN; 2]),
                })
            }
        }
    }
}

fn turned(rotation: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    rotation.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[cfg(test)]
pub(super) mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::punch::profile::ProfileKind;

    fn benchmark() -> [Profile; 2] {
        [
            include_str!("../../../../sweeps/profiles/MBench_S1002_v3.prw"),
            include_str!("../../../../sweeps/profiles/MBench_UIC60_v3.prr"),
        ]
        .map(|text| Profile::from_simpack(text).unwrap())
    }

    const WHEELSET: Wheelset =
        Wheelset { rolling_radius: 0.46, flange_back_distance: 1.36, flange_back_to_origin: 0.07 };
    const TRACK: Track = Track { gauge: 1.435, gauge_depth: 0.014 };

    pub(crate) fn placed(side: Side, position: &Position) -> Result<WheelOnRail, WheelRailError> {
        let [wheel, rail] = benchmark();
        WheelOnRail::new(&wheel, &rail, &WHEELSET, &TRACK, side, position)
    }

    /// Returns an arc of `radius` around (0, `center`), with the length `half` at either side of
    /// its topmost (−1) or lowest (1) point.
    fn arc(center: f64, radius: f64, direction: f64, half: f64) -> Vec<[f64; 2]> {
        (-400..=400)
            .map(|i| f64::from(i) / 400.0 * half / radius)
            .map(|a| [radius * a.sin(), center + direction * radius * a.cos()])
            .collect()
    }

    /// Returns a wheel with an arc of 0.3 m radius for a profile on a rail with one of 0.08 m, with
    /// their crowns above each other.
    fn barrel(side: Side, position: &Position) -> WheelOnRail {
        let wheel = Profile::from_points(ProfileKind::Wheel, arc(-0.3, 0.3, 1.0, 0.03)).unwrap();
        let rail = Profile::from_points(ProfileKind::Rail, arc(0.08, 0.08, -1.0, 0.06)).unwrap();
        // At a depth of 10 mm the arc is √(2·80·10 − 10²) mm wide to either side.
        let gauge = 1.5 - 2.0 * (2.0 * 0.08f64 * 0.01 - 1e-4).sqrt();
        let wheelset = Wheelset {
            rolling_radius: 0.5,
            flange_back_distance: 1.4,
            flange_back_to_origin: 0.05,
        };
        WheelOnRail::new(
            &wheel,
            &rail,
            &wheelset,
            &Track { gauge, gauge_depth: 0.01 },
            side,
            position,
        )
        .unwrap()
    }

    #[test]
    fn two_crowns_touch_between_their_tops_with_the_curvatures_of_their_arcs() {
        let pair = barrel(Side::Right, &Position::default());
        let [x, y, z] = pair.touches()[0].position;
        assert!(
            x == 0.0 && (y - 0.75).abs() < 1e-7 && z.abs() < 1e-12 && pair.height().abs() < 1e-12,
            "{x} {y} {z}"
        );
        assert_eq!(pair.touches().len(), 1);
        let curvatures = pair.curvatures();
        // The curvature of the spline errs by the square of its step.
        assert!((curvatures.xx * 0.5 - 1.0).abs() < 1e-9 && curvatures.xs.abs() < 1e-9);
        assert!((curvatures.ss / (1.0 / 0.3 + 1.0 / 0.08) - 1.0).abs() < 1e-5, "{}", curvatures.ss);
        // If the wheel is moved aside by v, the arcs, of radii 0.3 and 0.08 around their centres,
        // touch on the line between these.
        let moved = barrel(Side::Right, &Position { lateral: 0.01, ..Position::default() });
        let sine = 0.01 / (0.3 + 0.08);
        let touch = moved.touches()[0];
        assert!(
            (touch.position[1] - 0.75 - 0.08 * sine).abs() < 1e-7
                && (touch.angle - sine.asin()).abs() < 1e-6,
            "{touch:?}"
        );
    }

    #[test]
    fn a_yawed_barrel_keeps_its_principal_curvatures() {
        // The wheel has the radius of a sphere across: its surface has the principal curvatures
        // 1/0.5 and 1/0.3, turned with the yaw.
        let yaw = 0.05f64;
        let pair = barrel(Side::Left, &Position { yaw, ..Position::default() });
        let curvatures = pair.curvatures();
        let (sin, cos) = yaw.sin_cos();
        let (circle, across, rail) = (1.0 / 0.5, 1.0 / 0.3, 1.0 / 0.08);
        assert!(
            (curvatures.xx - circle * cos * cos - across * sin * sin).abs() < 1e-4,
            "{curvatures:?}"
        );
        assert!(
            (curvatures.ss - circle * sin * sin - across * cos * cos - rail).abs() < 1e-3,
            "{curvatures:?}"
        );
        assert!(
            (curvatures.xs.abs() - (across - circle) * sin * cos).abs() < 1e-4,
            "{curvatures:?}"
        );
        let ([small, large], direction) = curvatures.principal();
        assert!((small + large - curvatures.xx - curvatures.ss).abs() < 1e-12);
        let along = |a: f64| {
            curvatures.xx * a.cos().powi(2)
                + 2.0 * curvatures.xs * a.cos() * a.sin()
                + curvatures.ss * a.sin().powi(2)
        };
        assert!(
            (along(direction) - small).abs() < 1e-12
                && (along(direction + 0.5 * PI) - large).abs() < 1e-12
        );
    }

    #[test]
    fn a_wheelset_in_the_middle_touches_both_rails_alike() {
        let [left, right] =
            [Side::Left, Side::Right].map(|side| placed(side, &Position::default()).unwrap());
        let (a, b) = (left.touches()[0], right.touches()[0]);
        assert!(
            (a.position[1] + b.position[1]).abs() < 1e-9 && (a.angle + b.angle).abs() < 1e-12,
            "{a:?} {b:?}"
        );
        assert!(
            a.position[0] == 0.0
                && b.position[0] == 0.0
                && (left.height() - right.height()).abs() < 1e-15
        );
        // The gauge faces stand 1435 mm apart, 14 mm below the tops.
        let [y, z] = right.to_rail([0.0, 0.7175, 0.014]);
        assert!((y + 43.0325e-3).abs() < 1e-7 && (z - 0.014).abs() < 1e-6, "{y} {z}");
    }

    #[test]
    fn the_benchmarks_flange_comes_into_contact() {
        // At 6 mm with the benchmark's roll, the left wheel runs on its tread and the right one
        // towards its flange.
        let tread =
            placed(Side::Left, &Position { lateral: 6e-3, yaw: 1.44e-2, roll: -6.272e-4 }).unwrap();
        let flange =
            placed(Side::Right, &Position { lateral: 6e-3, yaw: 1.44e-2, roll: -6.272e-4 })
                .unwrap();
        assert!(tread.touches()[0].angle < 0.02);
        let angle = flange.touches()[0].angle;
        assert!(angle < -0.3, "{angle}");
        assert!(flange.touches()[0].position[2] > 2e-3);
    }

    #[test]
    fn refusals_name_what_is_wrong() {
        let [wheel, rail] = benchmark();
        let new = |wheel: &Profile, rail: &Profile, track: Track, lateral: f64, yaw: f64| {
            let position = Position { lateral, yaw, roll: 0.0 };
            WheelOnRail::new(wheel, rail, &WHEELSET, &track, Side::Left, &position)
                .map(|_| ())
                .unwrap_err()
                .to_string()
        };
        assert_eq!(
            new(&rail, &wheel, TRACK, 0.0, 0.0),
            "the wheel's profile is one of a rail; give a wheel's"
        );
        assert!(
            new(&wheel, &rail, TRACK, f64::NAN, 0.0)
                .contains("lateral = NaN: must be within ±10 m")
        );
        assert!(new(&wheel, &rail, TRACK, 0.0, 1.0).contains("yaw = 1e0: must be within ±π/6"));
        assert!(
            new(&wheel, &rail, Track { gauge: 0.0, ..TRACK }, 0.0, 0.0)
                .contains("gauge = 0e0: must be above 0")
        );
        assert!(
            new(&wheel, &rail, Track { gauge_depth: 0.04, ..TRACK }, 0.0, 0.0)
                .contains("the gauge is measured")
        );
        assert!(new(&wheel, &rail, TRACK, 1.0, 0.0).contains("one does not stand over the other"));
        assert!(new(&wheel, &rail, TRACK, 0.09, 0.0).contains("where a profile ends"));
        let unmirrored =
            Profile::from_points(ProfileKind::Wheel, wheel.curve().mirrored().points().to_vec())
                .unwrap();
        assert!(new(&unmirrored, &rail, TRACK, 0.0, 0.0).contains("mirror the profile"));
    }
}
