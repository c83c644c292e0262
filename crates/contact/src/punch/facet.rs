//! A wheel and a rail seen along the normal of one plane.

use std::f64::consts::PI;

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

impl Extent {
    /// Returns the smallest rectangle that holds both.
    pub(super) fn with(self, other: Self) -> Self {
        let join = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self { x: join(self.x, other.x), s: join(self.s, other.s) }
    }
}

/// A lowered wheel and a rail, seen along the normal of a plane. It gives the distance between
/// their surfaces along the normal, which is negative where they overlap.
#[derive(Clone, Debug)]
pub(super) struct Facet {
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
    /// The places with a locally smallest distance.
    minima: Vec<Minimum>,
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

/// A locally smallest distance.
#[derive(Clone, Copy, Debug)]
struct Minimum {
    /// The coordinate s \[m\].
    s: f64,
    /// The distance along n \[m\].
    distance: f64,
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

impl Facet {
    /// Lowers the wheel of `pair` by `depth` \[m\] and looks along the normal of `frame`, around
    /// the parameter `around` of the wheel's curve \[m\].
    pub(super) fn new(pair: &WheelOnRail, frame: Frame, depth: f64, around: f64) -> Self {
        let (sin, cos) = frame.angle.sin_cos();
        // The transpose of the rotation leads from the track to the wheel.
        let back = |v: [f64; 3]| {
            [0, 1, 2].map(|c| {
                pair.rotation[0][c] * v[0] + pair.rotation[1][c] * v[1] + pair.rotation[2][c] * v[2]
            })
        };
        let center = [pair.center[0], pair.center[1], pair.center[2] + depth];
        let mut origin = back([0, 1, 2].map(|c| frame.origin[c] - center[c]));
        origin[1] -= pair.wheel_origin;
        let rail = Graph::new(
            &pair.rail.clone().shifted([-frame.origin[1], -frame.origin[2]]),
            [cos, sin],
            pair.rail_below(around),
        );
        let mut facet = Self {
            frame,
            wheel: pair.wheel.clone(),
            radius: pair.radius,
            origin,
            axes: [back([1.0, 0.0, 0.0]), back([0.0, cos, sin]), back([0.0, -sin, cos])],
            rail,
            silhouette: outline(pair, &frame, depth, around),
            minima: Vec::new(),
        };
        facet.minima = facet.local_minima();
        facet
    }

    /// Returns the frame of the plane.
    pub(super) fn frame(&self) -> Frame {
        self.frame
    }

    /// Returns the smallest distance \[m\] for s within `range` \[m\]. It is infinite where one
    /// body is not above the other.
    pub(super) fn least_distance(&self, range: [f64; 2]) -> f64 {
        self.minima
            .iter()
            .filter(|minimum| (range[0]..=range[1]).contains(&minimum.s))
            .map(|minimum| minimum.distance)
            .fold(f64::INFINITY, f64::min)
    }

    /// Returns the distance \[m\] along n at (x, s) \[m\], or `None` where one body is not above
    /// the other.
    pub(super) fn distance(&self, x: f64, s: f64) -> Option<f64> {
        Some(self.rail_height(s)? - self.wheel_height(x, s)?)
    }

    /// Returns a row of distances \[m\] along n: at s \[m\], for each of the ascending `xs` \[m\].
    /// The wheel is nearly a circle along x, of which a polynomial through a few of its points is
    /// as good as the points themselves.
    pub(super) fn distances(&self, xs: &[f64], s: f64) -> Vec<Option<f64>> {
        let Some(rail) = self.rail_height(s) else { return vec![None; xs.len()] };
        let each = || xs.iter().map(|x| Some(rail - self.wheel_height(*x, s)?)).collect();
        let (Some(low), Some(high)) = (xs.first(), xs.last()) else { return Vec::new() };
        let is_worth_it = xs.len() > 2 * NODES && high - low < SMOOTH * self.radius;
        match is_worth_it.then(|| Chebyshev::new([*low, *high], |x| self.wheel_height(x, s))) {
            Some(Some(wheel)) => xs.iter().map(|x| Some(rail - wheel.at(*x))).collect(),
            Some(None) | None => each(),
        }
    }

    /// Returns n of the rail at s.
    fn rail_height(&self, s: f64) -> Option<f64> {
        let (sin, cos) = self.frame.angle.sin_cos();
        let [y, z] = self.rail.at(s)?.position;
        Some(cos * z - sin * y)
    }

    /// Finds the places on the silhouette with a locally smallest distance. On a line s = const the
    /// distance is smallest on the silhouette.
    fn local_minima(&self) -> Vec<Minimum> {
        let distance = |s: f64| {
            self.outline_at(s)
                .and_then(|outline| self.distance(outline.x, s))
                .unwrap_or(f64::INFINITY)
        };
        let distances: Vec<f64> = self
            .silhouette
            .iter()
            .map(|outline| self.rail_height(outline.s).map_or(f64::INFINITY, |n| n - outline.n))
            .collect();
        let mut minima = Vec::new();
        for (i, three) in distances.windows(3).enumerate() {
            if !(three[1] < three[0] && three[1] <= three[2]) {
                continue;
            }
            let [mut low, mut high] = [i, i + 2].map(|index| self.silhouette[index].s);
            // The search by the golden section stops where the distance no longer tells two places
            // apart.
            const SECTION: f64 = 0.618_033_988_749_894_9;
            let (mut left, mut right) =
                (high - SECTION * (high - low), low + SECTION * (high - low));
            let (mut at_left, mut at_right) = (distance(left), distance(right));
            for _ in 0..40 {
                if at_left < at_right {
                    (high, right, at_right) = (right, left, at_left);
                    left = high - SECTION * (high - low);
                    at_left = distance(left);
                } else {
                    (low, left, at_left) = (left, right, at_right);
                    right = low + SECTION * (high - low);
                    at_right = distance(right);
                }
            }
            let s = 0.5 * (low + high);
            minima.push(Minimum { s, distance: distance(s) });
        }
        minima
    }

    /// Returns the rectangle around all regions with a distance below `limit` \[m\] whose s lies in
    /// `range` \[m\]. It is `None` if there are none.
    pub(super) fn overlap(&self, limit: f64, range: [f64; 2]) -> Option<Extent> {
        let deepest = |s: f64| -> Option<Deepest> {
            let x = self.outline_at(s)?.x;
            let depth = limit - self.distance(x, s)?;
            (depth > 0.0).then_some(Deepest { x, s, depth })
        };
        let mut stations: Vec<f64> = self
            .silhouette
            .iter()
            .map(|outline| outline.s)
            .chain(self.minima.iter().map(|minimum| minimum.s))
            .filter(|s| (range[0]..=range[1]).contains(s))
            .collect();
        stations.sort_by(f64::total_cmp);
        let points: Vec<Option<Deepest>> = stations.iter().map(|s| deepest(*s)).collect();
        let mut extent: Option<Extent> = None;
        let mut take = |point: Extent| {
            extent = Some(extent.map_or(point, |extent| extent.with(point)));
            extent.unwrap_or(point)
        };
        for (i, point) in points.iter().enumerate() {
            let Some(point) = point else { continue };
            let so_far = take(Extent { x: [point.x; 2], s: [point.s; 2] });
            for (direction, farthest) in [(-1.0, so_far.x[0]), (1.0, so_far.x[1])] {
                let reach = self.half_length(point, direction, (farthest - point.x).abs(), limit);
                let x = point.x + direction * reach;
                take(Extent { x: [x; 2], s: [point.s; 2] });
            }
            for neighbour in [i.checked_sub(1), Some(i + 1)].into_iter().flatten() {
                let (Some(None), Some(outside)) = (points.get(neighbour), stations.get(neighbour))
                else {
                    continue;
                };
                let (mut inside, mut outside) = (point.s, *outside);
                for _ in 0..40 {
                    let half = 0.5 * (inside + outside);
                    if deepest(half).is_some() { inside = half } else { outside = half }
                }
                take(Extent { x: [point.x; 2], s: [inside; 2] });
            }
        }
        extent
    }

    /// Returns the length \[m\] by which the region with a distance below `limit` \[m\] reaches
    /// from its `deepest` point on a line s = const, along x in the `direction` ±1, or `known`
    /// \[m\] if it does not reach farther than that.
    fn half_length(&self, deepest: &Deepest, direction: f64, known: f64, limit: f64) -> f64 {
        let &Deepest { x, s, depth } = deepest;
        let overlaps = |reach: f64| {
            self.distance(x + direction * reach, s).is_some_and(|distance| distance < limit)
        };
        if known > 0.0 && !overlaps(known) {
            return known;
        }
        let (mut inside, mut outside) = (known, known.max((2.0 * self.radius * depth).sqrt()));
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

/// Samples the silhouette of a wheel that is lowered by `depth` \[m\] in contact coordinates,
/// around the parameter `around` of the wheel's curve as far as s rises.
fn outline(pair: &WheelOnRail, frame: &Frame, depth: f64, around: f64) -> Vec<Outline> {
    let point_at = |t: f64| {
        let [x, y, z] = pair.silhouette(t)?.position;
        let [x, s, n] = frame.from_track([x, y, z + depth]);
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

/// The number of points through which the wheel's height is interpolated along x.
const NODES: usize = 10;

/// The length over the wheel's radius up to which it is interpolated. The coefficients of the
/// polynomial then fall by a factor of 40 from one to the next but one.
const SMOOTH: f64 = 0.3;

/// The largest error of the interpolation that is taken \[m\], far below the error of any profile.
const ROUGH: f64 = 1e-11;

/// A polynomial through the values of a function at Chebyshev's points.
struct Chebyshev {
    /// The middle and the half length of the range.
    range: [f64; 2],
    /// The coefficients of Chebyshev's polynomials.
    coefficients: [f64; NODES],
}

impl Chebyshev {
    /// Interpolates `of` between the `ends`. It is `None` if the function has no value at a point,
    /// or the polynomial is not good between its points.
    fn new([low, high]: [f64; 2], of: impl Fn(f64) -> Option<f64>) -> Option<Self> {
        let range = [0.5 * (low + high), 0.5 * (high - low)];
        let angle = |i: usize| PI * (i as f64 + 0.5) / NODES as f64;
        let mut values = [0.0; NODES];
        for (i, value) in values.iter_mut().enumerate() {
            *value = of(range[0] + range[1] * angle(i).cos())?;
        }
        let mut coefficients = [0.0; NODES];
        for (k, coefficient) in coefficients.iter_mut().enumerate() {
            let sum: f64 = values
                .iter()
                .enumerate()
                .map(|(i, value)| value * (k as f64 * angle(i)).cos())
                .sum();
            *coefficient = sum * if k == 0 { 1.0 } else { 2.0 } / NODES as f64;
        }
        let interpolant = Self { range, coefficients };
        for x in [low, range[0] + 0.3 * range[1], range[0] - 0.55 * range[1], high] {
            if (interpolant.at(x) - of(x)?).abs() > ROUGH {
                return None;
            }
        }
        Some(interpolant)
    }

    /// Returns the value at x, by Clenshaw's recurrence.
    fn at(&self, x: f64) -> f64 {
        let [middle, half] = self.range;
        let t = (x - middle) / half;
        let (mut next, mut after) = (0.0, 0.0);
        for coefficient in self.coefficients[1..].iter().rev() {
            (next, after) = (2.0 * t * next - after + coefficient, next);
        }
        t * next - after + self.coefficients[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Side;
    use crate::punch::track::Position;
    use crate::punch::wheel_rail::tests::placed;

    #[test]
    fn the_wheels_height_lies_on_its_surface() {
        // The check is independent: the point found, turned back to the wheelset, has the profile's
        // radius at its y.
        let yawed = Position { lateral: 4e-3, yaw: 9.6e-3, roll: -2.557e-4 };
        let pair = placed(Side::Left, &yawed).unwrap();
        let (frame, around, depth) = (pair.tangent_frame(), pair.touches()[0].wheel, 1e-4);
        let facet = Facet::new(&pair, frame, depth, around);
        let profile = Graph::new(&pair.wheel, [1.0, 0.0], around);
        for (x, s) in [(0.0, 0.0), (4e-3, -3e-3), (-7e-3, 6e-3), (0.0, 1e-2), (1e-2, 0.0)] {
            let n = facet.wheel_height(x, s).unwrap();
            let mut track = frame.to_track([x, s, n]);
            track[2] -= depth;
            let v = [0, 1, 2].map(|c| track[c] - pair.center[c]);
            let point = [0, 1, 2].map(|c| (0..3).map(|r| pair.rotation[r][c] * v[r]).sum::<f64>());
            let z = profile.at(point[1] - pair.wheel_origin).unwrap().position[1];
            assert!((point[0].hypot(point[2]) - 0.46 - z).abs() < 1e-13, "{x} {s}");
        }
    }

    #[test]
    fn a_row_of_distances_is_the_distances_one_by_one() {
        let yawed = Position { lateral: 7e-3, yaw: 1.68e-2, roll: -6.393e-3 };
        for side in [Side::Left, Side::Right] {
            let pair = placed(side, &yawed).unwrap();
            let facet = Facet::new(&pair, pair.tangent_frame(), 2e-5, pair.touches()[0].wheel);
            let xs: Vec<f64> = (-120..=120).map(|i| 1e-4 * f64::from(i)).collect();
            for j in -60..=60 {
                let s = 5e-5 * f64::from(j);
                for (x, row) in xs.iter().zip(facet.distances(&xs, s)) {
                    let one = facet.distance(*x, s).unwrap();
                    assert!((row.unwrap() - one).abs() < 1e-10, "{side:?} {x} {s}: {row:?} {one}");
                }
            }
            // Beside the wheel there is none.
            let beside: Vec<f64> = (0..40).map(|i| 0.4 + 5e-3 * f64::from(i)).collect();
            let row = facet.distances(&beside, 0.0);
            assert!(row.iter().zip(&beside).all(|(row, x)| *row == facet.distance(*x, 0.0)));
            assert_eq!(row[39], None);
        }
    }
}
