//! The plane of contact between a wheel and a rail, and the gap above it.

use super::curve::{Curve, Graph};
use super::track::Frame;
use super::wheel_rail::WheelOnRail;

/// A rectangle of the plane of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// The ends of the range along x, lower one first \[m\].
    pub x: [f64; 2],
    /// The ends of the range along s, lower one first \[m\].
    pub s: [f64; 2],
}

/// A wheel and a rail seen along the normal of their plane of contact. It gives the gap between the
/// two as they just touch.
#[derive(Clone, Debug)]
pub struct ContactPlane {
    frame: Frame,
    wheel: Curve,
    radius: f64,
    /// The origin of the frame, in the coordinates of the wheel \[m\]. These have their origin on
    /// the axle at the profile's y = 0; `axes` are the frame's axes x, s, n in them.
    origin: [f64; 3],
    axes: [[f64; 3]; 3],
    rail: Graph,
    /// The wheel's silhouette where it is a graph over s, in the order of rising s.
    silhouette: Vec<Outline>,
    /// The coordinates s \[m\] of the points with a locally smallest gap.
    touches: Vec<f64>,
}

/// A point of the silhouette in contact coordinates \[m\].
#[derive(Clone, Copy, Debug)]
struct Outline {
    x: f64,
    s: f64,
    n: f64,
    /// The parameter of the wheel's curve \[m\].
    parameter: f64,
}

/// The deepest point of the overlap of the undeformed bodies on a line s = const.
#[derive(Clone, Copy, Debug)]
struct Deepest {
    /// The coordinate x \[m\].
    x: f64,
    /// The coordinate s \[m\].
    s: f64,
    /// The depth of the overlap \[m\], above 0.
    depth: f64,
}

/// The three-point Gauss rule on (−½, ½): abscissas and weights.
const GAUSS: [(f64, f64); 3] = [
    (-0.387_298_334_620_741_7, 5.0 / 18.0),
    (0.0, 8.0 / 18.0),
    (0.387_298_334_620_741_7, 5.0 / 18.0),
];

impl ContactPlane {
    /// Creates the plane of `frame` between the two bodies of `pair`.
    pub fn new(pair: &WheelOnRail, frame: Frame) -> Self {
        let (sin, cos) = frame.angle.sin_cos();
        // The transpose of the rotation leads from the track to the wheel.
        let back = |v: [f64; 3]| {
            [0, 1, 2].map(|c| {
                pair.rotation[0][c] * v[0] + pair.rotation[1][c] * v[1] + pair.rotation[2][c] * v[2]
            })
        };
        let mut origin = back([0, 1, 2].map(|c| frame.origin[c] - pair.center[c]));
        origin[1] -= pair.wheel_origin;
        let touch = &pair.touches()[0];
        let rail_parameters = pair.rail.samples(4);
        let nearest = |t: f64| {
            let [y, z] = pair.rail.at(t).position;
            (y - touch.position[1]).hypot(z - touch.position[2])
        };
        let around = rail_parameters
            .into_iter()
            .min_by(|a, b| nearest(*a).total_cmp(&nearest(*b)))
            .unwrap_or(0.0);
        let rail = Graph::new(
            &pair.rail.clone().shifted([-frame.origin[1], -frame.origin[2]]),
            [cos, sin],
            around,
        );
        Self {
            frame,
            wheel: pair.wheel.clone(),
            radius: pair.radius,
            origin,
            axes: [back([1.0, 0.0, 0.0]), back([0.0, cos, sin]), back([0.0, -sin, cos])],
            rail,
            silhouette: outline(pair, &frame, touch.wheel),
            touches: pair
                .touches()
                .iter()
                .map(|touch| frame.from_track(touch.position)[1])
                .collect(),
        }
    }

    /// Returns the frame of the plane.
    pub(crate) fn frame(&self) -> Frame {
        self.frame
    }

    /// Returns the gap \[m\] along n at (x, s) \[m\]. It is 0 where the two bodies just touch, and
    /// `None` where one body is not above the other.
    pub fn gap(&self, x: f64, s: f64) -> Option<f64> {
        let (sin, cos) = self.frame.angle.sin_cos();
        let [y, z] = self.rail.at(s)?.position;
        // A negative gap is rounding at the touching point and no penetration.
        Some((cos * z - sin * y - self.wheel_height(x, s)?).max(0.0))
    }

    /// Returns the mean gap \[m\] over the element hx × hs \[m\] centred at (x, s) \[m\], or `None`
    /// if one body is not above the other in all of the element.
    pub(crate) fn mean_gap(&self, x: f64, s: f64, hx: f64, hs: f64) -> Option<f64> {
        let mut mean = 0.0;
        for (along, weight) in GAUSS {
            for (across, other) in GAUSS {
                mean += weight * other * self.gap(x + along * hx, s + across * hs)?;
            }
        }
        Some(mean)
    }

    /// Returns the rectangle around all regions in which the undeformed bodies would overlap after
    /// an `approach` \[m\], with a margin of a twentieth of its widths at each side. It is `None`
    /// if nothing would overlap.
    pub fn overlap(&self, approach: f64) -> Option<Extent> {
        let deepest = |s: f64| -> Option<Deepest> {
            let x = self.outline_at(s)?.x;
            let depth = approach - self.gap(x, s)?;
            (depth > 0.0).then_some(Deepest { x, s, depth })
        };
        let mut stations: Vec<f64> = self
            .silhouette
            .iter()
            .map(|outline| outline.s)
            .chain(self.touches.iter().copied())
            .collect();
        stations.sort_by(f64::total_cmp);
        let mut extent: Option<Extent> = None;
        let mut take = |x: f64, s: f64| {
            let extent = extent.get_or_insert(Extent { x: [x; 2], s: [s; 2] });
            extent.x = [extent.x[0].min(x), extent.x[1].max(x)];
            extent.s = [extent.s[0].min(s), extent.s[1].max(s)];
        };
        for (i, &s) in stations.iter().enumerate() {
            let Some(point) = deepest(s) else { continue };
            for direction in [-1.0, 1.0] {
                take(point.x + direction * self.half_length(&point, direction, approach), s);
            }
            for neighbour in [i.checked_sub(1), Some(i + 1)]
                .into_iter()
                .flatten()
                .filter_map(|index| stations.get(index))
            {
                let (mut inside, mut outside) = (s, *neighbour);
                for _ in 0..40 {
                    let half = 0.5 * (inside + outside);
                    if deepest(half).is_some() { inside = half } else { outside = half }
                }
                take(point.x, inside);
            }
        }
        extent.map(|Extent { x, s }| {
            let wider =
                |[low, high]: [f64; 2]| [low - 0.05 * (high - low), high + 0.05 * (high - low)];
            Extent { x: wider(x), s: wider(s) }
        })
    }

    /// Returns the length \[m\] by which the overlap after an `approach` \[m\] reaches from its
    /// `deepest` point on a line s = const, along x in the `direction` ±1.
    fn half_length(&self, deepest: &Deepest, direction: f64, approach: f64) -> f64 {
        let &Deepest { x, s, depth } = deepest;
        let overlaps =
            |reach: f64| self.gap(x + direction * reach, s).is_some_and(|gap| gap < approach);
        let (mut inside, mut outside) = (0.0, (2.0 * self.radius * depth).sqrt());
        while outside < self.radius && overlaps(outside) {
            (inside, outside) = (outside, 1.5 * outside);
        }
        for _ in 0..40 {
            let half = 0.5 * (inside + outside);
            if overlaps(half) { inside = half } else { outside = half }
        }
        inside
    }

    /// Returns the silhouette at s, interpolated between its samples.
    fn outline_at(&self, s: f64) -> Option<Outline> {
        let right = self.silhouette.partition_point(|outline| outline.s < s);
        let end = self.silhouette.get(right)?;
        let Some(start) = right.checked_sub(1).map(|left| self.silhouette[left]) else {
            return (end.s == s).then_some(*end);
        };
        let fraction = (s - start.s) / (end.s - start.s);
        let mix = |a: f64, b: f64| a + fraction * (b - a);
        Some(Outline {
            x: mix(start.x, end.x),
            s,
            n: mix(start.n, end.n),
            parameter: mix(start.parameter, end.parameter),
        })
    }

    /// Returns n of the wheel's surface on the line (x, s). Newton's method for n and the parameter
    /// of the wheel's curve starts from the silhouette at s and a circle of the wheel's radius
    /// along x.
    fn wheel_height(&self, x: f64, s: f64) -> Option<f64> {
        let start = self.outline_at(s)?;
        let [low, high] = [self.silhouette.first()?.parameter, self.silhouette.last()?.parameter];
        let foot = [0, 1, 2].map(|c| self.origin[c] + x * self.axes[0][c] + s * self.axes[1][c]);
        let normal = self.axes[2];
        let mut n = start.n - 0.5 * (x - start.x).powi(2) / self.radius;
        let mut t = start.parameter;
        for _ in 0..40 {
            let q = [0, 1, 2].map(|c| foot[c] + n * normal[c]);
            let point = self.wheel.at(t);
            let distance = q[0].hypot(q[2]);
            let (off_y, off_r) =
                (q[1] - point.position[0], distance - self.radius - point.position[1]);
            let outward = (q[0] * normal[0] + q[2] * normal[2]) / distance;
            let [dy, dz] = point.tangent;
            // The cosine between the two normals is |outward·dy − normal_y·dz|. The expression is
            // negative where the surface turns away.
            let facing = outward * dy - normal[1] * dz;
            if facing.is_nan() || facing <= 0.0 {
                return None;
            }
            let (step_n, step_t) = (
                (off_y * dz - off_r * dy) / facing,
                (outward * off_y - normal[1] * off_r) / facing,
            );
            n += step_n;
            let next = (t + step_t).clamp(low, high);
            let settled = step_n.abs() <= 1e-15 && (next - t).abs() <= 1e-12;
            if settled {
                // The parameter is held at an end although the step would go on: the line passes
                // the wheel.
                return (step_t.abs() <= 1e-9).then_some(n);
            }
            t = next;
        }
        // The last steps only shuffle the rounding.
        let q = [0, 1, 2].map(|c| foot[c] + n * normal[c]);
        let point = self.wheel.at(t);
        let off =
            (q[1] - point.position[0]).hypot(q[0].hypot(q[2]) - self.radius - point.position[1]);
        (off <= 1e-13).then_some(n)
    }
}

/// Samples the silhouette in contact coordinates, around the parameter `around` of the wheel's
/// curve as far as s rises.
fn outline(pair: &WheelOnRail, frame: &Frame, around: f64) -> Vec<Outline> {
    let point_at = |t: f64| {
        let [x, s, n] = frame.from_track(pair.silhouette(t)?.position);
        Some(Outline { x, s, n, parameter: t })
    };
    let Some(start) = point_at(around) else { return Vec::new() };
    let mut samples = pair.wheel.samples(4);
    let above = samples.split_off(samples.partition_point(|&t| t < around));
    let mut outline = vec![start];
    for t in samples.into_iter().rev() {
        match point_at(t) {
            Some(point) if point.s < outline[outline.len() - 1].s => outline.push(point),
            _ => break,
        }
    }
    outline.reverse();
    for t in above.into_iter().filter(|&t| t > around) {
        match point_at(t) {
            Some(point) if point.s > outline[outline.len() - 1].s => outline.push(point),
            _ => break,
        }
    }
    outline
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::model::Side;
    use crate::punch::profile::Profile;
    use crate::punch::track::{Position, Track, Wheelset};
    use crate::punch::wheel_rail::tests::placed;

    fn benchmark(side: Side, position: &Position) -> WheelOnRail {
        let wheel =
            Profile::from_simpack(include_str!("../../../../sweeps/profiles/MBench_S1002_v3.prw"))
                .unwrap();
        let rail =
            Profile::from_simpack(include_str!("../../../../sweeps/profiles/MBench_UIC60_v3.prr"))
                .unwrap();
        let wheelset = Wheelset {
            rolling_radius: 0.46,
            flange_back_distance: 1.36,
            flange_back_to_origin: 0.07,
        };
        WheelOnRail::new(
            &wheel,
            &rail,
            &wheelset,
            &Track { gauge: 1.435, gauge_depth: 0.014 },
            side,
            position,
        )
        .unwrap()
    }

    const YAWED: Position = Position { lateral: 4e-3, yaw: 9.6e-3, roll: -2.557e-4 };

    #[test]
    fn the_gap_is_zero_where_the_two_touch_and_nowhere_negative() {
        for (side, position) in
            [(Side::Left, YAWED), (Side::Left, Position::default()), (Side::Right, YAWED)]
        {
            let pair = benchmark(side, &position);
            for frame in [pair.tangent_frame(), pair.overlap_frame(2e-5)] {
                let plane = ContactPlane::new(&pair, frame);
                let [x, s, _] = frame.from_track(pair.touches()[0].position);
                assert!(
                    plane.gap(x, s).unwrap() < 1e-12,
                    "{side:?} {frame:?}: {:?}",
                    plane.gap(x, s)
                );
                // This check is made without the clamp, for the surfaces themselves must not cross.
                let (sin, cos) = frame.angle.sin_cos();
                for i in -60..=60 {
                    for j in -60..=60 {
                        let (x, s) = (x + 1e-4 * f64::from(i), s + 1e-4 * f64::from(j));
                        let [y, z] = plane.rail.at(s).unwrap().position;
                        assert!(
                            cos * z - sin * y - plane.wheel_height(x, s).unwrap() > -1e-12,
                            "{x} {s}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn the_wheels_height_lies_on_its_surface() {
        // The check is independent: the point found, turned back to the wheelset, has the profile's
        // radius at its y.
        let pair = benchmark(Side::Left, &YAWED);
        let frame = pair.tangent_frame();
        let plane = ContactPlane::new(&pair, frame);
        let profile = Graph::new(&pair.wheel, [1.0, 0.0], pair.touches()[0].wheel);
        for (x, s) in [(0.0, 0.0), (4e-3, -3e-3), (-7e-3, 6e-3), (0.0, 1e-2), (1e-2, 0.0)] {
            let n = plane.wheel_height(x, s).unwrap();
            let track = frame.to_track([x, s, n]);
            let v = [0, 1, 2].map(|c| track[c] - pair.center[c]);
            let point = [0, 1, 2].map(|c| (0..3).map(|r| pair.rotation[r][c] * v[r]).sum::<f64>());
            let z = profile.at(point[1] - pair.wheel_origin).unwrap().position[1];
            assert!((point[0].hypot(point[2]) - 0.46 - z).abs() < 1e-13, "{x} {s}");
        }
    }

    #[test]
    fn near_the_touching_point_the_gap_is_the_paraboloid_of_its_curvatures() {
        for (side, position) in
            [(Side::Left, YAWED), (Side::Right, Position { lateral: -4e-3, ..YAWED })]
        {
            let pair = benchmark(side, &position);
            let plane = ContactPlane::new(&pair, pair.tangent_frame());
            let c = pair.curvatures();
            assert!(c.principal().0[0] > 0.0);
            for (x, s) in [(1e-4, 0.0), (0.0, 5e-5), (8e-5, 5e-5), (8e-5, -5e-5)] {
                let paraboloid = 0.5 * (c.xx * x * x + 2.0 * c.xs * x * s + c.ss * s * s);
                let gap = plane.gap(x, s).unwrap();
                assert!((gap / paraboloid - 1.0).abs() < 2e-2, "{x} {s}: {gap:e} {paraboloid:e}");
            }
        }
    }

    #[test]
    fn element_means_meet_a_fine_quadrature() {
        let pair = benchmark(Side::Left, &YAWED);
        let plane = ContactPlane::new(&pair, pair.tangent_frame());
        for (x, s, hx, hs) in [
            (0.0, 0.0, 2e-4, 2e-4),
            (2e-3, -3e-3, 2e-4, 2e-4),
            (-4e-3, 3e-3, 5e-4, 5e-4),
            (1e-3, 6e-3, 2e-4, 4e-4),
        ] {
            let count = 60;
            let offset = |i: usize, h: f64| ((i as f64 + 0.5) / count as f64 - 0.5) * h;
            let fine: f64 = (0..count * count)
                .map(|e| plane.gap(x + offset(e % count, hx), s + offset(e / count, hs)).unwrap())
                .sum();
            let fine = fine / (count * count) as f64;
            // The error of the midpoint rule itself is h²/24 of the second derivative over its
            // steps.
            let midpoint = (hx * hx * 2.2 + hs * hs * 5.0) / 24.0 / (count * count) as f64;
            let mean = plane.mean_gap(x, s, hx, hs).unwrap();
            assert!((mean - fine).abs() < 1e-6 * fine + midpoint, "{x} {s}: {mean:e} {fine:e}");
        }
    }

    #[test]
    fn the_overlap_lies_in_its_rectangle_and_reaches_its_sides() {
        for (side, position, approach) in [
            (Side::Left, YAWED, 2e-5),
            (Side::Left, Position::default(), 1.6e-5),
            (Side::Left, YAWED, 1e-9),
            (Side::Right, YAWED, 5e-5),
        ] {
            let pair = benchmark(side, &position);
            let plane = ContactPlane::new(&pair, pair.tangent_frame());
            let Extent { x, s } = plane.overlap(approach).unwrap();
            let (wx, ws) = (x[1] - x[0], s[1] - s[0]);
            // The grid reaches beyond the rectangle: nothing overlaps outside of it, and something
            // does in the outer tenth at each side.
            let mut reached = [false; 4];
            for i in -20..=120 {
                for j in -20..=120 {
                    let (u, v) = (f64::from(i) / 100.0, f64::from(j) / 100.0);
                    if plane.gap(x[0] + u * wx, s[0] + v * ws).is_some_and(|gap| gap < approach) {
                        assert!((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v), "{u} {v}");
                        for (side, there) in
                            reached.iter_mut().zip([u < 0.1, u > 0.9, v < 0.1, v > 0.9])
                        {
                            *side |= there;
                        }
                    }
                }
            }
            assert_eq!(reached, [true; 4], "{side:?} {approach}");
        }
        let pair = benchmark(Side::Left, &YAWED);
        assert_eq!(ContactPlane::new(&pair, pair.tangent_frame()).overlap(0.0), None);
    }

    #[test]
    fn regions_on_tread_and_flange_root_fit_one_rectangle() {
        let pair = benchmark(Side::Right, &Position { lateral: 4.8e-3, ..Position::default() });
        let [tread, root] = pair.touches() else { panic!("{:?}", pair.touches()) };
        assert!(
            root.gap < 4e-5 && (tread.position[1] - root.position[1]) > 0.01,
            "{tread:?} {root:?}"
        );
        let plane = ContactPlane::new(&pair, pair.tangent_frame());
        let s = plane.frame().from_track(root.position)[1];
        let reach = plane.gap(0.0, s).unwrap() + 1e-6;
        let [one, both] = [0.5e-5, reach].map(|approach| plane.overlap(approach).unwrap().s);
        assert!(one[0] > s && both[0] < s, "{one:?} {both:?} {s}");
        // Nothing overlaps somewhere between the two.
        assert!((1..20).any(|i| plane.gap(0.0, s * f64::from(i) / 20.0).unwrap() > reach));
    }

    #[test]
    fn there_is_no_gap_beside_the_bodies() {
        let pair = benchmark(Side::Left, &Position::default());
        let plane = ContactPlane::new(&pair, pair.tangent_frame());
        assert!(plane.gap(0.0, 0.01).is_some());
        assert_eq!(
            (plane.gap(0.0, 0.5), plane.gap(0.0, -0.5), plane.mean_gap(0.0, 0.5, 1e-3, 1e-3)),
            (None, None, None)
        );
        assert_eq!(plane.gap(0.5, 0.0), None, "the wheel is 0.46 m high");
    }

    proptest! {
        #[test]
        fn the_left_is_the_mirror_of_the_right(lateral in -8e-3f64..8e-3, yaw in -0.03f64..0.03, roll in -0.01f64..0.01, x in -5e-3f64..5e-3, s in -5e-3f64..5e-3) {
            let left = placed(Side::Left, &Position { lateral, yaw, roll }).unwrap();
            let right = placed(Side::Right, &Position { lateral: -lateral, yaw: -yaw, roll: -roll }).unwrap();
            prop_assert!((left.height() - right.height()).abs() < 1e-13);
            // With two nearly equal gaps either may be the smallest.
            prop_assume!((left.touches()[0].position[1] + right.touches()[0].position[1]).abs() < 1e-6);
            let (a, b) = (left.curvatures(), right.curvatures());
            prop_assert!((a.xx - b.xx).abs() < 1e-3 && (a.xs + b.xs).abs() < 1e-3);
            let (plane, mirror) = (ContactPlane::new(&left, left.tangent_frame()), ContactPlane::new(&right, right.tangent_frame()));
            match (plane.gap(x, s), mirror.gap(x, -s)) {
                (Some(a), Some(b)) => prop_assert!((a - b).abs() < 1e-9, "{} {}", a, b),
                (a, b) => prop_assert!(a.is_none() == b.is_none()),
            }
        }

        #[test]
        fn no_position_is_too_odd(lateral in -0.2f64..0.2, yaw in -0.5f64..0.5, roll in -0.5f64..0.5) {
            if let Ok(pair) = placed(Side::Right, &Position { lateral, yaw, roll }) {
                let plane = ContactPlane::new(&pair, pair.tangent_frame());
                prop_assert!(plane.gap(0.0, 0.0).is_none_or(|gap| gap < 1e-9));
                prop_assert!(pair.touches().iter().all(|touch| touch.gap >= 0.0));
                let _ = plane.overlap(1e-5);
            }
        }
    }
}
