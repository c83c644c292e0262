//! The regions in which a wheel would overlap its rail if it were lowered, and the frames that
//! belong to them.

use std::f64::consts::PI;

use super::track::Frame;
use super::wheel_rail::{Clearance, WheelOnRail};

/// The distance between two regions \[m\] up to which they share one plane of contact, as in
/// CONTACT (E.A.H. Vollebregt, User guide for CONTACT: the separation distance D_SEP).
const SHARED: f64 = 8e-3;

/// The number of points at which a region is integrated for its frame. The frame is then good to
/// 0.1 µm.
pub(super) const POINTS: usize = 200;

/// The number of points that suffices to estimate the load on a region.
pub(super) const FEW_POINTS: usize = 40;

/// A region in which the undeformed bodies would overlap.
#[derive(Clone, Debug)]
pub(super) struct Overlap {
    /// The ends of the region on the rail (y, z) \[m\], in the order of rising y.
    pub(super) ends: [[f64; 2]; 2],
    /// The parameter of the wheel's curve where the gap is smallest \[m\].
    pub(super) deepest: f64,
    /// The largest overlap along z \[m\].
    pub(super) depth: f64,
    /// The integral of the squared interpenetration, up to a factor that all regions share.
    weight: f64,
    /// The centre (x, y) in the track with that weight \[m\].
    center: [f64; 2],
    /// The mean inclination of the rail with that weight \[rad\].
    pub(super) angle: f64,
    /// The paraboloid that has the region's volume and widths.
    pub(super) paraboloid: Paraboloid,
}

/// The elliptic paraboloid that stands for the overlap in a region.
#[derive(Clone, Copy, Debug)]
pub(super) struct Paraboloid {
    /// The height, along the rail's normal \[m\].
    pub(super) height: f64,
    /// The semi-axis of its base along x \[m\].
    pub(super) semi_axis_x: f64,
    /// The semi-axis of its base across the track \[m\].
    pub(super) semi_axis_s: f64,
}

impl Overlap {
    /// Returns the gap between this region and one beside it, at higher y \[m\].
    fn distance_to(&self, next: &Self) -> f64 {
        let ([y0, z0], [y1, z1]) = (self.ends[1], next.ends[0]);
        (y1 - y0).hypot(z1 - z0)
    }
}

/// Neighbouring regions that share one plane of contact.
#[derive(Clone, Debug)]
pub(super) struct RailPatch {
    /// The frame of the plane.
    pub(super) frame: Frame,
    /// The regions, in the order of rising y.
    pub(super) overlaps: Vec<Overlap>,
    /// The integral of the squared interpenetration, up to a factor that all patches share.
    weight: f64,
}

impl RailPatch {
    /// Returns the parameter of the wheel's curve where the gap of the patch is smallest \[m\].
    pub(super) fn deepest(&self) -> f64 {
        self.overlaps
            .iter()
            .max_by(|a, b| a.depth.total_cmp(&b.depth))
            .map_or(0.0, |overlap| overlap.deepest)
    }

    /// Returns the coordinate s \[m\] of an end of the patch in its frame: the lower (0) or the
    /// higher one (1).
    pub(super) fn edge(&self, end: usize) -> f64 {
        let outermost = if end == 0 { self.overlaps.first() } else { self.overlaps.last() };
        outermost.map_or(0.0, |overlap| {
            let [y, z] = overlap.ends[end];
            self.frame.from_track([self.frame.origin[0], y, z])[1]
        })
    }
}

impl WheelOnRail {
    /// Returns the frame at the centre of the overlap that appears if the wheel is lowered by
    /// `depth` \[m\]. Its angle is the mean inclination of the rail there. Both are weighted with
    /// the square of the interpenetration, and regions less than 8 mm apart share a frame, as in
    /// CONTACT (E.A.H. Vollebregt, User guide for CONTACT). Of regions farther apart it is the
    /// frame of those with the largest weight. For no depth it is the tangent frame.
    pub fn overlap_frame(&self, depth: f64) -> Frame {
        self.patches(depth, POINTS)
            .iter()
            .max_by(|a, b| a.weight.total_cmp(&b.weight))
            .map_or_else(|| self.tangent_frame(), |patch| patch.frame)
    }

    /// Returns the patches of the wheel that is lowered by `depth` \[m\], in the order of rising y,
    /// with every region integrated at so many `points`.
    pub(super) fn patches(&self, depth: f64, points: usize) -> Vec<RailPatch> {
        let mut groups: Vec<Vec<Overlap>> = Vec::new();
        for overlap in self.overlaps(depth, points) {
            match groups.last_mut() {
                Some(group) if group[group.len() - 1].distance_to(&overlap) <= SHARED => {
                    group.push(overlap);
                }
                _ => groups.push(vec![overlap]),
            }
        }
        groups.into_iter().map(|overlaps| self.patch(overlaps)).collect()
    }

    /// Joins regions in one plane.
    pub(super) fn patch(&self, overlaps: Vec<Overlap>) -> RailPatch {
        let weight: f64 = overlaps.iter().map(|overlap| overlap.weight).sum();
        let mean = |value: fn(&Overlap) -> f64| {
            overlaps.iter().map(|overlap| overlap.weight * value(overlap)).sum::<f64>() / weight
        };
        let (x, y) = (mean(|overlap| overlap.center[0]), mean(|overlap| overlap.center[1]));
        let frame =
            Frame { origin: self.onto_rail([x, y, 0.0]), angle: mean(|overlap| overlap.angle) };
        RailPatch { frame, overlaps, weight }
    }

    /// Returns the regions in which the bodies overlap if the wheel is lowered by `depth` \[m\], in
    /// the order of rising y. Around each smallest gap a region reaches to the first sample without
    /// overlap.
    fn overlaps(&self, depth: f64, points: usize) -> Vec<Overlap> {
        let mut spans: Vec<[f64; 2]> = Vec::new();
        let mut overlaps = Vec::new();
        for touch in self.touches().iter().filter(|touch| touch.gap < depth) {
            if spans.iter().any(|[low, high]| (*low..=*high).contains(&touch.wheel)) {
                continue;
            }
            let span = self.span(depth, touch.wheel);
            spans.push(span);
            overlaps.extend(self.overlap(depth, span, touch.wheel, points));
        }
        overlaps.sort_by(|a: &Overlap, b| a.ends[0][0].total_cmp(&b.ends[0][0]));
        overlaps
    }

    /// Returns the ends of the region around the parameter `inside` of the wheel's curve \[m\].
    fn span(&self, depth: f64, inside: f64) -> [f64; 2] {
        let overlaps = |t: f64| self.gap_at(t).is_some_and(|clearance| clearance.gap < depth);
        let samples = self.wheel.samples(4);
        let middle = samples.partition_point(|&t| t < inside);
        let end = |outside: Option<&f64>, limit: f64| {
            let (mut inside, mut outside) = (inside, outside.copied().unwrap_or(limit));
            for _ in 0..60 {
                let half = 0.5 * (inside + outside);
                if overlaps(half) { inside = half } else { outside = half }
            }
            inside
        };
        [
            end(samples[..middle].iter().rev().find(|t| !overlaps(**t)), 0.0),
            end(samples[middle..].iter().find(|t| !overlaps(**t)), self.wheel.length()),
        ]
    }

    /// Measures a region between two parameters of the wheel's curve. It is `None` for a region
    /// that is too small to have a size.
    fn overlap(
        &self,
        depth: f64,
        [low, high]: [f64; 2],
        deepest: f64,
        points: usize,
    ) -> Option<Overlap> {
        // The overlap is a parabola along x, so that at a height h its length is proportional to
        // √h, its area to h^(3/2), and the integral of its square to h^(5/2). The points lie as
        // Chebyshev's do: a root at the ends then costs no accuracy.
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let (mut weight, mut center, mut angle) = (0.0, [0.0; 2], 0.0);
        let (mut length, mut volume, mut first, mut second) = (0.0, 0.0, 0.0, 0.0);
        let mut ends: Option<[[f64; 2]; 2]> = None;
        let mut last: Option<[f64; 2]> = None;
        let mut s = 0.0;
        let mut circle = 0.0;
        for i in 0..points {
            let (sin, cos) = (PI * ((i as f64 + 0.5) / points as f64 - 0.5)).sin_cos();
            let Some(Clearance { gap, wheel, rail }) = self.gap_at(middle + half * sin) else {
                continue;
            };
            if let Some([y, z]) = last {
                s += (rail.position[0] - y).hypot(rail.position[1] - z);
            }
            last = Some(rail.position);
            ends = Some([ends.map_or(rail.position, |ends| ends[0]), rail.position]);
            let h = (depth - gap).max(0.0);
            let inclination = rail.angle();
            // The step along the rail and the height along its normal.
            let step = cos * wheel.angle.cos() / inclination.cos();
            let normal = h * inclination.cos();
            let weighted = h.powf(2.5) * cos * wheel.angle.cos();
            weight += weighted;
            center[0] += weighted * wheel.position[0];
            center[1] += weighted * wheel.position[1];
            angle += weighted * inclination;
            let root = normal.sqrt() * step;
            length += root;
            volume += root * normal;
            first += root * s;
            second += root * s * s;
            circle += root * inclination.cos() / (wheel.position[2] - self.center[2]);
        }
        let ends = ends?;
        let mean = first / length;
        let semi_axis_s = 2.0 * (second / length - mean * mean).max(0.0).sqrt();
        // Weighted with the length along x, the mean height on the silhouette of a paraboloid is
        // ¾ of the largest one.
        let height = 4.0 / 3.0 * volume / length;
        let curvature = circle / length;
        let overlap = Overlap {
            ends,
            deepest,
            depth: depth - self.gap_at(deepest)?.gap,
            weight,
            center: center.map(|sum| sum / weight),
            angle: angle / weight,
            paraboloid: Paraboloid {
                height,
                semi_axis_x: (2.0 * height / curvature).sqrt(),
                semi_axis_s,
            },
        };
        (weight > 0.0 && semi_axis_s > 0.0 && height > 0.0).then_some(overlap)
    }
}
