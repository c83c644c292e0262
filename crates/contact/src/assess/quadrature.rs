//! Integrals over rectangles of functions that are smooth but for concentric ellipses and their
//! centre.
//!
//! At the edge of a contact the pressure goes like the root of the distance (under a flat sole like
//! its inverse), at that of a stick zone the traction has such a root too, and under a cone's tip
//! the pressure goes like a logarithm. Rectangles that an ellipse cuts are therefore swept along
//! chords that end on it, in the variable t of 3t² − 2t³, whose square-root ends make those roots
//! analytic. Rectangles at the centre are halved towards it.

use crate::common::gauss::{self, MAX_POINTS};

/// The places where a function is not smooth.
pub(crate) struct Kinks {
    /// The semi-axes along x and y of ellipses around the origin.
    pub(super) ellipses: Vec<[f64; 2]>,
    /// True if the origin is such a place.
    pub(super) center: bool,
}

/// A rectangle [x₀, x₁] × [y₀, y₁].
#[derive(Clone, Copy)]
pub(super) struct Rectangle {
    /// The interval along x.
    pub(super) x: [f64; 2],
    /// The interval along y.
    pub(super) y: [f64; 2],
}

/// The number of points of the rule along a chord, and across the chords.
const EDGE_POINTS: usize = MAX_POINTS;
/// The number of points each way for a rectangle at least its own size away from every kink.
const FAR_POINTS: usize = 6;
/// The number of times that a rectangle at the centre is halved. The rest then holds 1e-12 of its
/// area.
const HALVINGS: u32 = 40;

impl Kinks {
    /// Integrates `f` over the rectangle. The relative error is below 1e-9 for roots at the
    /// ellipses, for their squares and for logarithms at the centre. It is below 1e-6 for inverse
    /// roots, which lose digits in telling a point next to the ellipse from one on it.
    pub(super) fn integrate<const N: usize>(
        &self,
        rectangle: Rectangle,
        f: &impl Fn(f64, f64) -> [f64; N],
    ) -> [f64; N] {
        self.halved(rectangle, f, HALVINGS)
    }

    /// Integrates `f` over the rectangle, which is halved up to so many times towards the centre.
    fn halved<const N: usize>(
        &self,
        rectangle: Rectangle,
        f: &impl Fn(f64, f64) -> [f64; N],
        halvings: u32,
    ) -> [f64; N] {
        let Rectangle { x, y } = rectangle;
        let size = [x[1] - x[0], y[1] - y[0]];
        let longest = size[0].max(size[1]);
        let distance = |[low, high]: [f64; 2]| low.max(-high).max(0.0);
        // Three quarters are taken, for a part that lies its own size away is far enough.
        if halvings == 0 || !self.center || distance(x).max(distance(y)) >= 0.75 * longest {
            return self.without_center(rectangle, f);
        }
        let halves = |[low, high]: [f64; 2]| {
            let middle = if low < 0.0 && high > 0.0 { 0.0 } else { 0.5 * (low + high) };
            [[low, middle], [middle, high]]
        };
        let mut sum = [0.0; N];
        if size[0] == longest {
            halves(x).into_iter().for_each(|x| {
                add(&mut sum, self.halved(Rectangle { x, ..rectangle }, f, halvings - 1), 1.0)
            });
        } else {
            halves(y).into_iter().for_each(|y| {
                add(&mut sum, self.halved(Rectangle { y, ..rectangle }, f, halvings - 1), 1.0)
            });
        }
        sum
    }

    /// Integrates `f` over a rectangle on which the centre is no kink.
    fn without_center<const N: usize>(
        &self,
        rectangle: Rectangle,
        f: &impl Fn(f64, f64) -> [f64; N],
    ) -> [f64; N] {
        if self.ellipses.iter().all(|semi_axes| !is_near(rectangle, *semi_axes)) {
            let line = |y: f64| gauss_legendre(rectangle.x, FAR_POINTS, &|x| f(x, y));
            return gauss_legendre(rectangle.y, FAR_POINTS, &line);
        }
        // At these y a chord's end jumps from an ellipse to a side of the rectangle, or the chord
        // ends altogether.
        let turns = self.ellipses.iter().flat_map(|&[a, b]| {
            rectangle
                .x
                .map(|x| (x / a).abs())
                .into_iter()
                .chain([0.0])
                .map(move |x| b * cathetus(x))
        });
        let line = |y: f64| {
            let ends = self.ellipses.iter().map(|&[a, b]| a * cathetus((y / b).abs()));
            pieces(rectangle.x, ends, &|x| f(x, y))
        };
        pieces(rectangle.y, turns, &line)
    }
}

/// Returns √(1 − s²), 0 beyond s = 1.
fn cathetus(s: f64) -> f64 {
    ((1.0 - s) * (1.0 + s)).max(0.0).sqrt()
}

/// Returns whether an ellipse passes through the rectangle or less than its size beside it.
fn is_near(rectangle: Rectangle, [a, b]: [f64; 2]) -> bool {
    let Rectangle { x, y } = rectangle;
    let (width, height) = (x[1] - x[0], y[1] - y[0]);
    let range = |[low, high]: [f64; 2], margin: f64| {
        let (low, high) = (low - margin, high + margin);
        let nearest = if low < 0.0 && high > 0.0 { 0.0 } else { low.abs().min(high.abs()) };
        [nearest, low.abs().max(high.abs())]
    };
    let (x, y) = (range(x, width), range(y, height));
    (x[0] / a).hypot(y[0] / b) < 1.0 && (x[1] / a).hypot(y[1] / b) > 1.0
}

/// Integrates `f` over an interval, cut at ± each of `points`, by a rule for roots at the ends of
/// each piece.
fn pieces<const N: usize>(
    [low, high]: [f64; 2],
    points: impl Iterator<Item = f64>,
    f: &impl Fn(f64) -> [f64; N],
) -> [f64; N] {
    let mut cuts: Vec<f64> =
        points.flat_map(|x| [-x, x]).filter(|x| *x > low && *x < high).chain([low, high]).collect();
    cuts.sort_unstable_by(f64::total_cmp);
    let mut sum = [0.0; N];
    for piece in cuts.windows(2) {
        let length = piece[1] - piece[0];
        let rooted = |t: f64| {
            // The distance is taken from the nearer end, so that a root's argument keeps its
            // digits.
            let s = t.min(1.0 - t);
            let distance = length * s * s * (3.0 - 2.0 * s);
            let mut value = f(if t < 0.5 { piece[0] + distance } else { piece[1] - distance });
            value.iter_mut().for_each(|v| *v *= 6.0 * length * t * (1.0 - t));
            value
        };
        add(&mut sum, gauss_legendre([0.0, 1.0], EDGE_POINTS, &rooted), 1.0);
    }
    sum
}

/// Integrates `f` over an interval by Gauss and Legendre's rule of so many points.
fn gauss_legendre<const N: usize>(
    [low, high]: [f64; 2],
    points: usize,
    f: &impl Fn(f64) -> [f64; N],
) -> [f64; N] {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let mut sum = [0.0; N];
    for &(u, weight) in &gauss::uniform()[points] {
        add(&mut sum, f(middle + half * u), weight * (high - low));
    }
    sum
}

/// Adds `weight` times `term` to `sum`.
fn add<const N: usize>(sum: &mut [f64; N], term: [f64; N], weight: f64) {
    for (sum, term) in sum.iter_mut().zip(term) {
        *sum += weight * term;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Returns sums over the elements of an n × m grid on [−1.37, 1.31] × [−1.25, 1.2].
    fn over_grid<const N: usize>(
        kinks: &Kinks,
        [n, m]: [usize; 2],
        f: &impl Fn(f64, f64) -> [f64; N],
    ) -> [f64; N] {
        let edge =
            |i: usize, n: usize, low: f64, high: f64| low + (high - low) * i as f64 / n as f64;
        let mut sum = [0.0; N];
        for j in 0..m {
            for i in 0..n {
                let x = [edge(i, n, -1.37, 1.31), edge(i + 1, n, -1.37, 1.31)];
                let y = [edge(j, m, -1.25, 1.2), edge(j + 1, m, -1.25, 1.2)];
                add(&mut sum, kinks.integrate(Rectangle { x, y }, f), 1.0);
            }
        }
        sum
    }

    #[test]
    fn roots_inverse_roots_and_logarithms_are_integrated_whatever_the_grid() {
        let (a, b, c) = (1.1, 0.7, 0.45);
        let below = |x: f64, y: f64, scale: f64| {
            1.0 - ((x / (a * scale)).powi(2) + (y / (b * scale)).powi(2))
        };
        let f = |x: f64, y: f64| {
            let (outer, inner) = (below(x, y, 1.0), below(x, y, c));
            let root = outer.max(0.0).sqrt();
            let difference = root - c * inner.max(0.0).sqrt();
            let inverse = if outer > 0.0 { 1.0 / root } else { 0.0 };
            let cosh = if outer > 0.0 { (1.0 / (x / a).hypot(y / b)).acosh() } else { 0.0 };
            [root, root * root, inverse, difference, cosh, cosh * cosh]
        };
        let kinks = Kinks { ellipses: vec![[a, b], [a * c, b * c]], center: true };
        let unit = PI * a * b;
        // The integral ∫ 2s acosh(1/s)² ds over (0, 1) is 2 ln 2.
        let exact = [2.0 / 3.0, 0.5, 2.0, 2.0 / 3.0 * (1.0 - c * c * c), 1.0, 2.0 * 2f64.ln()];
        for n in [[1, 1], [2, 3], [7, 7], [16, 5], [40, 31]] {
            let sums = over_grid(&kinks, n, &f);
            for (k, (sum, exact)) in sums.iter().zip(exact).enumerate() {
                let error = sum / (unit * exact) - 1.0;
                assert!(error.abs() < if k == 2 { 1e-6 } else { 1e-9 }, "{n:?}, {k}: {error:.1e}");
            }
        }
    }
}
