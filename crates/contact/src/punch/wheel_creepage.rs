//! The creepages of a wheel on its rail, from the motion of its wheelset.
//!
//! The wheelset is a rigid body. The middle of its axle moves with (V, ẏ, ż) in the track; the
//! axle turns with Ω = φ̇ e_x + ψ̇ R e_z, where R = R_x(φ) R_z(ψ) is the rotation from the wheelset
//! to the track; and the wheelset turns about its axle R e_y with −ω. A point of the wheel at r
//! from the middle of the axle therefore has the velocity
//!
//! w = (V, ẏ, ż) + Ω × r − ω R e_y × r.
//!
//! The rail rests. The wheel is a surface of revolution, which its turning leaves where it is: it
//! stays on the rail if (V, ẏ, ż) + Ω × r has no component along the normal n, and ż follows. Of −w
//! the components along x and s, and of ω R e_y − Ω the one along n, over the rolling speed, are
//! the creepages and the spin. The rolling speed is the mean of those with which rail and wheel run
//! through the contact, |V + (Ω × r)_x| and |ω (R e_y × r)_x|, as in CONTACT (E.A.H. Vollebregt,
//! Detailed wheel/rail geometry processing using the planar contact approach, 2022,
//! doi:10.1080/00423114.2020.1853180). No angle is taken for small.

use std::borrow::Cow;

use super::gap::Gap;
use super::placement::PlacedWheel;
use super::surface::Surfaces;
use crate::model::{
    ImposedCreepages, RollingDirection, Scene, SceneError, Shape, WheelRail, WheelsetMotion, refuse,
};

/// The rigid motion of a wheel on its rail at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelCreepages {
    /// The creepages and the spin: the motion of the rail relative to the wheel.
    pub creepages: ImposedCreepages,
    /// The mean speed with which rail and wheel run through the contact, above 0 \[m/s\]. Both are
    /// taken to run at it; where the wheel is locked or turns back, everything slips, and the
    /// tractions do not depend on it but for the strains beside the creepage.
    pub rolling_speed: f64,
    /// The velocity of the contact along x \[m/s\].
    pub contact_velocity: f64,
    /// The vertical velocity of the wheelset with which the wheel stays on its rail \[m/s\].
    pub vertical_velocity: f64,
}

/// A point of a wheel that touches a rail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WheelPoint {
    /// The position from the middle of the axle, in the axes of the track \[m\].
    pub(crate) arm: [f64; 3],
    /// The contact angle \[rad\], from y towards z.
    pub(crate) angle: f64,
    /// The rotation from the wheelset to the track, row by row.
    pub(crate) rotation: [[f64; 3]; 3],
}

impl WheelPoint {
    /// Returns the creepages there under the `motion` of a wheelset whose wheels have this nominal
    /// `rolling_radius` \[m\].
    pub(crate) fn creepages(&self, motion: &WheelsetMotion, rolling_radius: f64) -> WheelCreepages {
        let (sin, cos) = self.angle.sin_cos();
        let (along, normal) = ([0.0, cos, sin], [0.0, -sin, cos]);
        let column = |c: usize| self.rotation.map(|row| row[c]);
        let turning = [0, 1, 2].map(|c| motion.yaw_rate * column(2)[c]);
        let turning = [turning[0] + motion.roll_rate, turning[1], turning[2]];
        let about_axle = column(1).map(|c| motion.angular_speed(rolling_radius) * c);
        let turned = cross(turning, self.arm);
        let level = [motion.speed + turned[0], motion.lateral_velocity + turned[1], turned[2]];
        let vertical_velocity = -dot(level, normal) / cos;
        let frame = [level[0], level[1], level[2] + vertical_velocity];
        let spun = cross(about_axle, self.arm);
        let wheel = [0, 1, 2].map(|c| frame[c] - spun[c]);
        let rolling_speed = 0.5 * (frame[0].abs() + spun[0].abs());
        let spin = dot(about_axle, normal) - dot(turning, normal);
        WheelCreepages {
            creepages: ImposedCreepages {
                creepage_x: -wheel[0] / rolling_speed,
                creepage_y: -dot(wheel, along) / rolling_speed,
                spin: spin / rolling_speed,
            },
            rolling_speed,
            contact_velocity: frame[0],
            vertical_velocity,
        }
    }
}

/// Returns the creepages that the motion of the wheelset of `scene` imposes at the reference point
/// of its contact, which is the origin of Ω's coordinates. It is `None` without such a motion.
///
/// # Errors
/// A [`SceneError`] says that a profile is missing, that the wheel does not meet its rail, that it
/// meets it in planes of different creepages, or that the motion leaves its contact where it is.
pub fn wheel_creepages(
    scene: &Scene,
    surfaces: &Surfaces,
) -> Result<Option<WheelCreepages>, SceneError> {
    let Shape::WheelOnRail(WheelRail { motion: Some(motion), rolling_radius, .. }) =
        &scene.punch.shape
    else {
        return Ok(None);
    };
    let gap = Gap::new(scene, surfaces)?;
    let Some(wheel) = gap.wheel_on_rail() else { return Ok(None) };
    let found = wheel.point()?.creepages(motion, *rolling_radius);
    let key = "punch.speed";
    if found.contact_velocity == 0.0 {
        let expected = "must move the contact along the rail, which the yaw rate undoes here";
        return Err(refuse(key, motion.speed, expected));
    }
    let ImposedCreepages { creepage_x, creepage_y, spin } = found.creepages;
    if ![creepage_x, creepage_y, spin].iter().all(|creepage| creepage.is_finite()) {
        let expected = "must be in the range of double precision, with the other velocities";
        return Err(refuse(key, motion.speed, expected));
    }
    Ok(Some(found))
}

/// Returns a scene with the creepages that the motion of its wheelset imposes on its steps; one
/// without such a motion stays as it is.
///
/// # Errors
/// A [`SceneError`] says what [`wheel_creepages`] does, or that a step rolls the other way than
/// the wheelset.
pub(crate) fn with_creepages<'a>(
    scene: &'a Scene,
    surfaces: &Surfaces,
) -> Result<Cow<'a, Scene>, SceneError> {
    let Some(found) = wheel_creepages(scene, surfaces)? else { return Ok(Cow::Borrowed(scene)) };
    let direction = if found.contact_velocity > 0.0 {
        RollingDirection::Forward
    } else {
        RollingDirection::Backward
    };
    let mut scene = scene.clone();
    for (index, step) in scene.loading.steps.iter_mut().enumerate() {
        let Some(rolling) = &mut step.rolling else { continue };
        if rolling.direction != direction {
            return Err(SceneError {
                key: format!("loading.steps[{index}].direction"),
                value: rolling.direction.words().to_owned(),
                expected: format!(
                    "must be \"{}\", as the contact travels with {:e} m/s along the rail",
                    direction.words(),
                    found.contact_velocity
                ),
            });
        }
        rolling.imposed = found.creepages;
    }
    Ok(Cow::Owned(scene))
}

impl PlacedWheel {
    /// Returns the point of the undeformed wheel at the origin of the plane of contact.
    ///
    /// # Errors
    /// A [`SceneError`] says that there are several planes, or that there is no wheel.
    fn point(&self) -> Result<WheelPoint, SceneError> {
        let refused = |value: String, expected: &str| {
            Err(SceneError { key: "punch.speed".to_owned(), value, expected: expected.to_owned() })
        };
        let planes = self.plane.frames().count();
        if planes > 1 {
            return refused(
                format!("{planes} patches, each in a plane of its own"),
                "cannot say the creepages: they differ from plane to plane. Take the position of \
                 the wheelset where one patch bears, or leave out the speed and give the creepages",
            );
        }
        let (Some(frame), Some(distance)) =
            (self.plane.frames().next(), self.plane.distance(0.0, 0.0))
        else {
            return refused(
                "no wheel above the reference point".to_owned(),
                "needs a wheel and a rail that lie above each other there",
            );
        };
        let depth = self.plane.depth(self.plane.approach());
        let point = frame.to_track([0.0, 0.0, -distance]);
        let [x, y, z] = self.pair.center;
        Ok(WheelPoint {
            arm: [point[0] - x, point[1] - y, point[2] - z - depth],
            angle: frame.angle,
            rotation: self.pair.rotation,
        })
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::model::Side;
    use crate::punch::contact_plane::ContactPlane;
    use crate::punch::profile::{Profile, ProfileKind};
    use crate::punch::track::{Frame, Position, Track, Wheelset, rotation};
    use crate::punch::wheel_rail::WheelOnRail;
    use crate::punch::wheel_rail::tests::placed;

    const RADIUS: f64 = 0.46;

    const STILL: WheelsetMotion = WheelsetMotion {
        speed: 2.0,
        angular_speed: None,
        lateral_velocity: 0.0,
        yaw_rate: 0.0,
        roll_rate: 0.0,
    };

    /// Returns the point at which the two bodies just touch.
    fn touching(pair: &WheelOnRail) -> WheelPoint {
        let Frame { origin, angle } = pair.tangent_frame();
        let arm = [0, 1, 2].map(|c| origin[c] - pair.center[c]);
        WheelPoint { arm, angle, rotation: pair.rotation }
    }

    fn on_benchmark(side: Side, position: &Position, motion: &WheelsetMotion) -> WheelCreepages {
        touching(&placed(side, position).unwrap()).creepages(motion, RADIUS)
    }

    /// Returns creepages and spin as numbers.
    fn numbers(found: &WheelCreepages) -> [f64; 3] {
        let ImposedCreepages { creepage_x, creepage_y, spin } = found.creepages;
        [creepage_x, creepage_y, spin]
    }

    fn near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
        let off = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < tolerance);
        assert!(off, "{found:?} {expected:?}");
    }

    #[test]
    fn a_centred_wheelset_has_equal_and_opposite_spin() {
        let [left, right] =
            [Side::Left, Side::Right].map(|side| on_benchmark(side, &Position::default(), &STILL));
        let ([x, y, spin], [other_x, other_y, other_spin]) = (numbers(&left), numbers(&right));
        assert!((x - other_x).abs() < 1e-15 && y == 0.0 && other_y == 0.0, "{left:?} {right:?}");
        assert!((spin + other_spin).abs() < 1e-12 && spin < -0.01, "{left:?} {right:?}");
        assert_eq!(left.vertical_velocity, 0.0);
    }

    #[test]
    fn at_the_nominal_radius_a_wheel_rolls_without_creepage_and_spins_by_its_angle() {
        for (angle, backwards) in [(0.0, 1.0), (-0.05, 1.0), (-1.2, 1.0), (0.3, -1.0)] {
            let point =
                WheelPoint { arm: [0.0, 0.75, RADIUS], angle, rotation: rotation(0.0, 0.0) };
            let speed = backwards * 35.0;
            let found = point.creepages(&WheelsetMotion { speed, ..STILL }, RADIUS);
            // The spin is sin δ over the radius, and changes its sign with the direction.
            near(numbers(&found), [0.0, 0.0, -backwards * angle.sin() / RADIUS], 1e-15);
            assert!((found.rolling_speed - 35.0).abs() < 1e-13, "{found:?}");
            assert!((found.contact_velocity - speed).abs() < 1e-13, "{found:?}");
        }
    }

    #[test]
    fn yaw_and_lateral_velocity_make_the_lateral_creepage_over_the_cosine_of_the_angle() {
        let angle = -1.1_f64;
        let slide = |yaw: f64, lateral_velocity: f64| {
            // The point of a yawed wheel with the normal n lies ahead of the axle by this.
            let ahead = -yaw * (0.75 + RADIUS * angle.tan());
            let point =
                WheelPoint { arm: [ahead, 0.75, RADIUS], angle, rotation: rotation(yaw, 0.0) };
            let motion = WheelsetMotion { lateral_velocity, ..STILL };
            numbers(&point.creepages(&motion, RADIUS))[1]
        };
        for (yaw, lateral_velocity) in [(1e-4, 0.0), (0.0, 2e-4), (1e-4, -2e-4)] {
            let expected = (yaw - lateral_velocity / STILL.speed) / angle.cos();
            let found = slide(yaw, lateral_velocity);
            assert!((found / expected - 1.0).abs() < 2e-3, "{found:e} {expected:e}");
        }
        // A wheelset that moves as it points does not creep sideways.
        assert!(slide(1e-4, 2e-4).abs() < 1e-6);
    }

    /// The linear formulas of the literature (A.H. Wickens, Fundamentals of Rail Vehicle Dynamics,
    /// 2003; J.J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990) hold for small
    /// angles and velocities; the error falls with the square of these.
    #[test]
    fn small_motions_have_the_linear_creepages() {
        let errors = [1e-2, 1e-3].map(|small: f64| {
            let (yaw, roll, angle) = (0.5 * small, -0.3 * small, -0.8 * small);
            let (radius_change, y) = (0.6 * small * RADIUS, 0.75);
            // The roll lowers the wheel, which keeps its radius.
            let arm = [-yaw * y, y, RADIUS + radius_change + roll * y];
            let motion = WheelsetMotion {
                speed: 20.0,
                angular_speed: None,
                lateral_velocity: 20.0 * 0.4 * small,
                yaw_rate: 20.0 * 0.9 * small,
                roll_rate: 20.0 * 0.7 * small,
            };
            let point = WheelPoint { arm, angle, rotation: rotation(yaw, roll) };
            let found = numbers(&point.creepages(&motion, RADIUS));
            // The roll moves the wheel sideways by its rate times the radius.
            let linear = [
                radius_change / RADIUS + motion.yaw_rate * y / motion.speed,
                yaw - (motion.lateral_velocity - motion.roll_rate * RADIUS) / motion.speed,
                -(angle - roll) / RADIUS - motion.yaw_rate / motion.speed,
            ];
            [0, 1, 2].map(|i| (found[i] - linear[i]).abs())
        });
        for (large, small) in errors[0].iter().zip(errors[1]) {
            assert!(*large < 3e-4 && small < 0.02 * large + 1e-15, "{errors:?}");
        }
    }

    /// A cone of the angle λ on a rail with a round top meets it always at the same point of the
    /// rail, so that the radii differ by 2 y tan λ.
    #[test]
    fn a_conical_wheelset_creeps_by_its_cone() {
        let slope = 0.05_f64;
        let points = |z: fn(f64, f64) -> f64, half: f64| -> Vec<[f64; 2]> {
            (-200..=200).map(|i| half * f64::from(i) / 200.0).map(|y| [y, z(y, 0.05)]).collect()
        };
        let wheel =
            Profile::from_points(ProfileKind::Wheel, points(|y, slope| -slope * y, 0.05)).unwrap();
        let crown = |y: f64, _: f64| y * y / (0.3 + (0.09 - y * y).sqrt());
        let rail = Profile::from_points(ProfileKind::Rail, points(crown, 0.035)).unwrap();
        let wheelset = Wheelset {
            rolling_radius: RADIUS,
            flange_back_distance: 1.36,
            flange_back_to_origin: 0.07,
        };
        let track = Track { gauge: 1.45, gauge_depth: 0.001 };
        let meeting = |side: Side, lateral: f64| {
            let position = Position { lateral, ..Position::default() };
            let pair = WheelOnRail::new(&wheel, &rail, &wheelset, &track, side, &position).unwrap();
            let point = touching(&pair);
            (point.arm[2], point.creepages(&STILL, RADIUS))
        };
        for lateral in [0.0, 2e-3, -6e-3] {
            let ((left_radius, left), (right_radius, right)) =
                (meeting(Side::Left, lateral), meeting(Side::Right, lateral));
            let difference = 2.0 * slope * lateral;
            assert!((right_radius - left_radius - difference).abs() < 1e-9, "{lateral}");
            for (side, radius, found) in [(-1.0, left_radius, left), (1.0, right_radius, right)] {
                let centred = meeting(Side::Right, 0.0).0;
                // Over the forward speed this is λ y/r₀, beside what the centred wheel has.
                let [x, y, spin] = numbers(&found);
                let forward = x * found.rolling_speed / STILL.speed;
                let expected = (centred + side * slope * lateral) / RADIUS - 1.0;
                assert!((forward - expected).abs() < 1e-9 && y.abs() < 1e-12, "{found:?}");
                let angle = side * slope.atan().sin();
                assert!((spin - angle / RADIUS).abs() < 1e-4 * spin.abs() + spin.abs() * x.abs());
                assert!((radius - (1.0 + forward) * RADIUS).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_locked_wheel_slides_at_twice_the_rolling_speed() {
        let point =
            WheelPoint { arm: [0.0, 0.75, RADIUS], angle: 0.0, rotation: rotation(0.0, 0.0) };
        for angular_speed in [0.0, -7.0] {
            let motion = WheelsetMotion { angular_speed: Some(angular_speed), ..STILL };
            near(numbers(&point.creepages(&motion, RADIUS)), [-2.0, 0.0, 0.0], 1e-15);
        }
        let spun = WheelsetMotion { angular_speed: Some(1e6), ..STILL };
        let found = point.creepages(&spun, RADIUS);
        assert!((numbers(&found)[0] - 2.0).abs() < 1e-4, "{found:?}");
    }

    /// The height at which the wheel touches its rail changes as the vertical velocity says.
    #[test]
    fn the_wheel_stays_on_its_rail() {
        let motion =
            WheelsetMotion { lateral_velocity: 0.03, yaw_rate: 0.2, roll_rate: -0.02, ..STILL };
        for (side, position) in [
            (Side::Left, Position { lateral: 3e-3, yaw: 7e-3, roll: -2e-4 }),
            (Side::Right, Position { lateral: 8e-3, yaw: 1.92e-2, roll: -8.606e-3 }),
            (Side::Right, Position { lateral: 6e-3, yaw: -1.44e-2, roll: 0.0 }),
        ] {
            let step = 1e-4;
            let height = |time: f64| {
                let moved = Position {
                    lateral: position.lateral + time * motion.lateral_velocity,
                    yaw: position.yaw + time * motion.yaw_rate,
                    roll: position.roll + time * motion.roll_rate,
                };
                placed(side, &moved).unwrap().height()
            };
            let expected = (height(step) - height(-step)) / (2.0 * step);
            let found = on_benchmark(side, &position, &motion).vertical_velocity;
            assert!((found - expected).abs() < 1e-5 + 1e-4 * expected.abs(), "{found} {expected}");
        }
    }

    #[test]
    fn the_reference_point_lies_on_the_lowered_wheel() {
        let position = Position { lateral: 8e-3, yaw: 1.92e-2, roll: -8.606e-3 };
        let pair = placed(Side::Right, &position).unwrap();
        let depth = 4e-5;
        let plane = ContactPlane::new(&pair, pair.overlap_frame(depth), depth);
        // The wheel overlaps its rail there, so that it rolls on a larger radius than it touches.
        let overlap = -plane.distance(0.0, 0.0).unwrap();
        assert!(overlap > 0.3 * plane.approach() && overlap <= plane.approach() + 1e-12);
        assert!((plane.depth(plane.approach()) - depth).abs() < 1e-18);
    }

    fn cube(low: f64, high: f64) -> [std::ops::Range<f64>; 3] {
        [low..high, low..high, low..high]
    }

    proptest! {
        /// Two material points of a wheelset that moves by finite angles have, over a short time,
        /// the velocity and the spin that the formulas say.
        #[test]
        fn material_points_move_as_the_creepages_say(arm in cube(-1.0, 1.0), angles in cube(-0.5, 0.5), rates in cube(-3.0, 3.0), angular_speed in -50.0f64..50.0, speed in 1.0f64..40.0) {
            let ([yaw, roll, angle], [lateral_velocity, yaw_rate, roll_rate]) = (angles, rates);
            let motion = WheelsetMotion { speed, angular_speed: Some(angular_speed), lateral_velocity, yaw_rate, roll_rate };
            let found = WheelPoint { arm, angle, rotation: rotation(yaw, roll) }.creepages(&motion, RADIUS);
            let product = |m: &[[f64; 3]; 3], v: [f64; 3]| m.map(|row| dot(row, v));
            let back = |m: &[[f64; 3]; 3], v: [f64; 3]| [0, 1, 2].map(|c| m[0][c] * v[0] + m[1][c] * v[1] + m[2][c] * v[2]);
            // The place at a time of the material point that is at `arm` now.
            let place = |arm: [f64; 3], time: f64| {
                let (sin, cos) = (-angular_speed * time).sin_cos();
                let [x, y, z] = back(&rotation(yaw, roll), arm);
                let turned = [cos * x + sin * z, y, cos * z - sin * x];
                let [x, y, z] = product(&rotation(yaw + time * yaw_rate, roll + time * roll_rate), turned);
                [x + time * speed, y + time * lateral_velocity, z + time * found.vertical_velocity]
            };
            let step = 1e-5;
            let velocity = |arm: [f64; 3]| {
                let (after, before) = (place(arm, step), place(arm, -step));
                [0, 1, 2].map(|c| (after[c] - before[c]) / (2.0 * step))
            };
            let (sin, cos) = angle.sin_cos();
            let along = [0.0, cos, sin];
            let here = velocity(arm);
            let aside = velocity([0, 1, 2].map(|c| arm[c] + along[c]));
            let speed = found.rolling_speed;
            let expected = [-here[0] / speed, -dot(here, along) / speed, (aside[0] - here[0]) / speed];
            for (found, expected) in numbers(&found).into_iter().zip(expected) {
                prop_assert!((found - expected).abs() < 1e-4 * (1.0 + expected.abs()), "{} {}", found, expected);
            }
        }

        #[test]
        fn the_left_creeps_as_the_mirror_of_the_right(lateral in -6e-3f64..6e-3, yaw in -0.03f64..0.03, roll in -0.01f64..0.01, rates in cube(-1.0, 1.0), omega in 0.0f64..9.0) {
            let [lateral_velocity, yaw_rate, roll_rate] = rates;
            let motion = WheelsetMotion { speed: 2.0, angular_speed: Some(omega), lateral_velocity, yaw_rate, roll_rate };
            let mirrored = WheelsetMotion { lateral_velocity: -lateral_velocity, yaw_rate: -yaw_rate, roll_rate: -roll_rate, ..motion };
            let image = Position { lateral: -lateral, yaw: -yaw, roll: -roll };
            let pairs = [(Side::Left, Position { lateral, yaw, roll }), (Side::Right, image)]
                .map(|(side, position)| touching(&placed(side, &position).unwrap()));
            // With two nearly equal gaps either may be the smallest.
            prop_assume!((pairs[0].arm[1] + pairs[1].arm[1]).abs() < 1e-6);
            let ([x, y, spin], [other_x, other_y, other_spin]) = (
                numbers(&pairs[0].creepages(&motion, RADIUS)),
                numbers(&pairs[1].creepages(&mirrored, RADIUS)),
            );
            prop_assert!((x - other_x).abs() < 1e-5 && (y + other_y).abs() < 1e-5 && (spin + other_spin).abs() < 1e-2, "{} {} {}", x - other_x, y + other_y, spin + other_spin);
        }

        /// Neither the unit of length nor that of time matters, and a motion that runs backwards
        /// has the same creepages with the other sign.
        #[test]
        fn creepages_know_no_units_and_turn_round_with_the_motion(arm in cube(-1.0, 1.0), angles in cube(-0.5, 0.5), rates in cube(-1.0, 1.0), speed in 1.0f64..40.0) {
            let ([yaw, roll, angle], [lateral_velocity, yaw_rate, roll_rate]) = (angles, rates);
            let found = |length: f64, time: f64| {
                let motion = WheelsetMotion {
                    speed: speed * length / time,
                    angular_speed: None,
                    lateral_velocity: lateral_velocity * length / time,
                    yaw_rate: yaw_rate / time,
                    roll_rate: roll_rate / time,
                };
                let arm = arm.map(|arm| length * arm);
                let point = WheelPoint { arm, angle, rotation: rotation(yaw, roll) };
                let [x, y, spin] = numbers(&point.creepages(&motion, length * RADIUS));
                [x, y, spin * length]
            };
            let metres = found(1.0, 1.0);
            for (length, time, sign) in [(1e3, 1.0, 1.0), (1.0, 1e-3, 1.0), (1.0, -1.0, -1.0)] {
                for (a, b) in found(length, time).into_iter().zip(metres) {
                    prop_assert!((a - sign * b).abs() < 1e-12 * (1.0 + b.abs()));
                }
            }
        }
    }
}
