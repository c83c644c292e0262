//! The plane of contact between a wheel and a rail, and the gap above it.
//!
//! Patches of contact that lie close together share one plane. Where a wheel meets its rail in
//! patches that lie far apart, each has a plane of its own with its own contact angle. The planes
//! are laid side by side in one plane of contact, at the distance that they have in space.

use super::facet::{Extent, Facet};
use super::overlap::RailPatch;
use super::track::Frame;
use super::wheel_rail::WheelOnRail;

/// A wheel and a rail seen along the normal of their plane of contact. It gives the gap between the
/// two as they just touch: the wheel is lowered vertically, and then drawn back along the normal.
#[derive(Clone, Debug)]
pub struct ContactPlane {
    /// The plane of each patch, in the order of rising s.
    planes: Vec<PatchPlane>,
    /// The depth by which the wheel is lowered \[m\].
    depth: f64,
    /// The approach at that depth \[m\].
    approach: f64,
}

/// The part of the plane of contact that belongs to one patch.
#[derive(Clone, Debug)]
struct PatchPlane {
    facet: Facet,
    /// The coordinate s in the plane of contact of the facet's origin \[m\].
    shift: f64,
    /// The range of s in the plane of contact that belongs to it \[m\].
    range: [f64; 2],
}

/// The three-point Gauss rule on (−½, ½): abscissas and weights.
const GAUSS: [(f64, f64); 3] = [
    (-0.387_298_334_620_741_7, 5.0 / 18.0),
    (0.0, 8.0 / 18.0),
    (0.387_298_334_620_741_7, 5.0 / 18.0),
];

impl PatchPlane {
    /// Returns the range of the facet's own s that belongs to the plane \[m\].
    fn own_range(&self) -> [f64; 2] {
        self.range.map(|s| s - self.shift)
    }
}

impl ContactPlane {
    /// Creates the plane of `frame` between the two bodies of `pair`, with the wheel lowered by
    /// `depth` \[m\] from where the two just touch.
    pub fn new(pair: &WheelOnRail, frame: Frame, depth: f64) -> Self {
        let facet = Facet::new(pair, frame, depth, pair.touches()[0].wheel);
        let range = [f64::NEG_INFINITY, f64::INFINITY];
        Self::of_planes(vec![PatchPlane { facet, shift: 0.0, range }], depth)
    }

    /// Creates the plane of the `patches` of a wheel that is lowered by `depth` \[m\], in the order
    /// of rising y. Without patches it is the tangent plane. The coordinates x and s have their
    /// origin in that of the first patch.
    pub(super) fn of_patches(pair: &WheelOnRail, patches: &[RailPatch], depth: f64) -> Self {
        let Some(first) = patches.first() else {
            return Self::new(pair, pair.tangent_frame(), depth);
        };
        let x = first.frame.origin[0];
        let mut planes: Vec<PatchPlane> = Vec::with_capacity(patches.len());
        let mut shift = 0.0;
        for (i, patch) in patches.iter().enumerate() {
            let [_, y, z] = patch.frame.origin;
            let frame = Frame { origin: [x, y, z], ..patch.frame };
            let mut low = f64::NEG_INFINITY;
            if let Some((before, plane)) =
                i.checked_sub(1).map(|i| &patches[i]).zip(planes.last_mut())
            {
                let [_, y0, z0] = before.frame.origin;
                shift = plane.shift + (y - y0).hypot(z - z0);
                // The planes meet midway between the patches.
                low = 0.5 * (plane.shift + before.edge(1) + shift + patch.edge(0));
                plane.range[1] = low;
            }
            let facet = Facet::new(pair, frame, depth, patch.deepest());
            planes.push(PatchPlane { facet, shift, range: [low, f64::INFINITY] });
        }
        Self::of_planes(planes, depth)
    }

    fn of_planes(planes: Vec<PatchPlane>, depth: f64) -> Self {
        let least = planes
            .iter()
            .map(|plane| plane.facet.least_distance(plane.own_range()))
            .fold(f64::INFINITY, f64::min);
        let approach = if least.is_finite() { -least } else { 0.0 };
        Self { planes, depth, approach }
    }

    /// Returns the frames of the planes of all patches, in the order of rising s.
    pub fn frames(&self) -> impl Iterator<Item = Frame> + '_ {
        self.planes.iter().map(|plane| plane.facet.frame())
    }

    /// Returns the approach \[m\] at which the wheel has the lateral position of its wheelset: the
    /// largest overlap along the normal of the lowered wheel.
    pub fn approach(&self) -> f64 {
        self.approach
    }

    /// Returns the depth \[m\] by which the wheel is lowered for an `approach` \[m\].
    pub(crate) fn depth(&self, approach: f64) -> f64 {
        if self.approach > 0.0 {
            self.depth * approach / self.approach
        } else {
            let angle = self.frames().next().map_or(0.0, |frame| frame.angle);
            approach / angle.cos()
        }
    }

    /// Returns the point (x, s) \[m\] of the plane in track coordinates \[m\].
    pub fn to_track(&self, x: f64, s: f64) -> [f64; 3] {
        let plane = self.plane(s);
        plane.facet.frame().to_track([x, s - plane.shift, 0.0])
    }

    /// Returns the contact angle \[rad\] of the plane at s \[m\].
    pub fn angle(&self, s: f64) -> f64 {
        self.plane(s).facet.frame().angle
    }

    /// Returns the plane to which s belongs.
    fn plane(&self, s: f64) -> &PatchPlane {
        let index = self.planes.partition_point(|plane| plane.range[1] <= s);
        &self.planes[index.min(self.planes.len() - 1)]
    }

    /// Returns the gap \[m\] along n at (x, s) \[m\]. It is 0 where the two bodies just touch, and
    /// `None` where one body is not above the other.
    pub fn gap(&self, x: f64, s: f64) -> Option<f64> {
        // A negative gap is rounding at the touching point and no penetration.
        Some((self.distance(x, s)? + self.approach).max(0.0))
    }

    /// Returns the distance \[m\] from the lowered wheel to the rail along n at (x, s) \[m\],
    /// negative where the undeformed bodies overlap.
    pub(super) fn distance(&self, x: f64, s: f64) -> Option<f64> {
        let plane = self.plane(s);
        plane.facet.distance(x, s - plane.shift)
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

    /// Returns the [mean gaps](Self::mean_gap) \[m\] of a row of elements hx × hs \[m\] centred at
    /// s \[m\] and each of the ascending `xs` \[m\].
    pub(crate) fn mean_gaps(&self, xs: &[f64], s: f64, hx: f64, hs: f64) -> Vec<Option<f64>> {
        let points: Vec<f64> =
            xs.iter().flat_map(|x| GAUSS.map(|(along, _)| x + along * hx)).collect();
        let mut means = vec![Some(0.0); xs.len()];
        for (across, weight) in GAUSS {
            let s = s + across * hs;
            let plane = self.plane(s);
            let distances = plane.facet.distances(&points, s - plane.shift);
            for (mean, distances) in means.iter_mut().zip(distances.chunks_exact(GAUSS.len())) {
                for (distance, (_, other)) in distances.iter().zip(GAUSS) {
                    *mean = mean.zip(*distance).map(|(mean, distance)| {
                        mean + weight * other * (distance + self.approach).max(0.0)
                    });
                }
            }
        }
        means
    }

    /// Returns the rectangle around all regions in which the undeformed bodies would overlap after
    /// an `approach` \[m\], with a margin of a twentieth of its widths at each side. It is `None`
    /// if nothing would overlap.
    pub fn overlap(&self, approach: f64) -> Option<Extent> {
        if approach <= 0.0 {
            return None;
        }
        let extents = self.planes.iter().filter_map(|plane| {
            let Extent { x, s } =
                plane.facet.overlap(approach - self.approach, plane.own_range())?;
            Some(Extent { x, s: s.map(|s| s + plane.shift) })
        });
        extents.reduce(Extent::with).map(|Extent { x, s }| {
            let wider =
                |[low, high]: [f64; 2]| [low - 0.05 * (high - low), high + 0.05 * (high - low)];
            Extent { x: wider(x), s: wider(s) }
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::model::Side;
    use crate::punch::overlap::POINTS;
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
                let plane = ContactPlane::new(&pair, frame, 0.0);
                let [x, s, _] = frame.from_track(pair.touches()[0].position);
                assert!(
                    plane.gap(x, s).unwrap() < 1e-12,
                    "{side:?} {frame:?}: {:?}",
                    plane.gap(x, s)
                );
                // This check is made without the clamp, for the surfaces themselves must not cross.
                let facet = &plane.planes[0].facet;
                for i in -60..=60 {
                    for j in -60..=60 {
                        let (x, s) = (x + 1e-4 * f64::from(i), s + 1e-4 * f64::from(j));
                        assert!(facet.distance(x, s).unwrap() > -1e-12, "{x} {s}");
                    }
                }
            }
        }
    }

    #[test]
    fn near_the_touching_point_the_gap_is_the_paraboloid_of_its_curvatures() {
        for (side, position) in
            [(Side::Left, YAWED), (Side::Right, Position { lateral: -4e-3, ..YAWED })]
        {
            let pair = benchmark(side, &position);
            let plane = ContactPlane::new(&pair, pair.tangent_frame(), 0.0);
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
        let plane = ContactPlane::new(&pair, pair.tangent_frame(), 0.0);
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
            let row: Vec<f64> = (-20..=20).map(|i| x + hx * f64::from(i)).collect();
            let in_row = plane.mean_gaps(&row, s, hx, hs)[20].unwrap();
            for mean in [plane.mean_gap(x, s, hx, hs).unwrap(), in_row] {
                assert!((mean - fine).abs() < 1e-6 * fine + midpoint, "{x} {s}: {mean:e} {fine:e}");
            }
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
            let plane = ContactPlane::new(&pair, pair.tangent_frame(), 0.0);
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
        assert_eq!(ContactPlane::new(&pair, pair.tangent_frame(), 0.0).overlap(0.0), None);
    }

    #[test]
    fn regions_on_tread_and_flange_root_fit_one_rectangle() {
        let pair = benchmark(Side::Right, &Position { lateral: 4.8e-3, ..Position::default() });
        let [tread, root] = pair.touches() else { panic!("{:?}", pair.touches()) };
        assert!(
            root.gap < 4e-5 && (tread.position[1] - root.position[1]) > 0.01,
            "{tread:?} {root:?}"
        );
        let plane = ContactPlane::new(&pair, pair.tangent_frame(), 0.0);
        let s = pair.tangent_frame().from_track(root.position)[1];
        let reach = plane.gap(0.0, s).unwrap() + 1e-6;
        let [one, both] = [0.5e-5, reach].map(|approach| plane.overlap(approach).unwrap().s);
        assert!(one[0] > s && both[0] < s, "{one:?} {both:?} {s}");
        // Nothing overlaps somewhere between the two.
        assert!((1..20).any(|i| plane.gap(0.0, s * f64::from(i) / 20.0).unwrap() > reach));
    }

    #[test]
    fn planes_of_their_own_stand_side_by_side_at_the_distance_in_space() {
        let pair = benchmark(Side::Right, &Position { lateral: 4.8e-3, ..Position::default() });
        let depth = 5e-5;
        let overlaps = pair.patches(depth, POINTS).into_iter().flat_map(|patch| patch.overlaps);
        let patches: Vec<RailPatch> = overlaps.map(|overlap| pair.patch(vec![overlap])).collect();
        assert_eq!(patches.len(), 2, "{patches:?}");
        let plane = ContactPlane::of_patches(&pair, &patches, depth);
        let frames: Vec<Frame> = plane.frames().collect();
        assert!((frames[0].angle - frames[1].angle).abs() > 0.1, "{frames:?}");
        let [a, b] = [0, 1].map(|i| frames[i].origin);
        let apart = (a[1] - b[1]).hypot(a[2] - b[2]);
        for (patch, s) in patches.iter().zip([0.0, apart]) {
            assert_eq!(plane.angle(s), patch.frame.angle);
            let [_, y, z] = plane.to_track(0.0, s);
            assert!((y - patch.frame.origin[1]).hypot(z - patch.frame.origin[2]) < 1e-12);
            // Beside the shift of the approach, the gap is the distance along the patch's normal.
            let facet = Facet::new(&pair, patch.frame, depth, patch.deepest());
            let x = frames[0].origin[0] - patch.frame.origin[0];
            for off in [-1e-3, 0.0, 5e-4] {
                let distance = facet.distance(x, off).unwrap();
                let gap = plane.gap(0.0, s + off).unwrap();
                assert!((gap - distance - plane.approach()).abs() < 1e-13, "{gap} {distance}");
            }
        }
        let deepest = patches
            .iter()
            .map(|patch| patch.overlaps[0].depth * patch.frame.angle.cos())
            .fold(0.0, f64::max);
        assert!((plane.approach() / deepest - 1.0).abs() < 1e-2);
        let Extent { s, .. } = plane.overlap(plane.approach()).unwrap();
        assert!(s[0] < 0.0 && s[1] > apart, "{s:?} {apart}");
    }

    #[test]
    fn there_is_no_gap_beside_the_bodies() {
        let pair = benchmark(Side::Left, &Position::default());
        let plane = ContactPlane::new(&pair, pair.tangent_frame(), 0.0);
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
            let (plane, mirror) = (ContactPlane::new(&left, left.tangent_frame(), 0.0), ContactPlane::new(&right, right.tangent_frame(), 0.0));
            match (plane.gap(x, s), mirror.gap(x, -s)) {
                (Some(a), Some(b)) => prop_assert!((a - b).abs() < 1e-9, "{} {}", a, b),
                (a, b) => prop_assert!(a.is_none() == b.is_none()),
            }
        }

        #[test]
        fn no_position_is_too_odd(lateral in -0.2f64..0.2, yaw in -0.5f64..0.5, roll in -0.5f64..0.5) {
            if let Ok(pair) = placed(Side::Right, &Position { lateral, yaw, roll }) {
                let plane = ContactPlane::new(&pair, pair.tangent_frame(), 0.0);
                prop_assert!(plane.gap(0.0, 0.0).is_none_or(|gap| gap < 1e-9));
                prop_assert!(pair.touches().iter().all(|touch| touch.gap >= 0.0));
                let _ = plane.overlap(1e-5);
            }
        }
    }
}
