//! Integrals of surface kernels over loaded rectangles, (x, y) being receiver minus source. The
//! kernels are any with the symmetries of a [`Coefficient`], in particular the half-space's six,
//! which know geometry only ([`HalfSpace`](super::half_space::HalfSpace) adds the material):
//!   nn: 1/r, xx: x²/r³, yy: y²/r³, xy: xy/r³, nx: x/r², ny: y/r².
//!
//! Everything is reduced to the quadrant x, y ≥ 0, where these are ≥ 0, so that nothing but the
//! signs of the quadrants can cancel:
//! - far from the source, one Gauss rule for the projection's own density, in as few points as the
//!   distance allows;
//! - near it, panels on which that density is linear, bisected until each is far enough for its own
//!   Gauss rule;
//! - the panel that touches the origin in closed form (`corner`).
//!
//! Second differences of antiderivatives, the textbook method, lose about d⁴ of 16 digits at d
//! elements' distance, and as many again as the element's sides differ.

use super::coefficient::Coefficient;
use crate::common::gauss;
use crate::model::Projection;

/// Six functions of (x, y) with the symmetries of a [`Coefficient`] that behave like 1/r at the
/// origin.
pub(super) trait Kernel: Copy {
    /// The square of the distance of the nearest singularity in the complex plane of x or y,
    /// relative to that of the origin.
    const CLEARANCE: f64;

    /// Returns the functions of coordinates that are counted in `unit`, times `unit`.
    fn in_units_of(self, unit: f64) -> Self;

    /// Returns the six values at (x, y) ≠ 0.
    fn at(&self, x: f64, y: f64) -> Coefficient;

    /// Returns the integrals over the product of two panels that both begin at the origin; `None`
    /// if it must be cut up first.
    fn corner(&self, px: Panel, py: Panel) -> Option<Coefficient>;
}

/// The half-space's six kernels.
#[derive(Clone, Copy, Debug)]
struct Geometric;

impl Kernel for Geometric {
    /// The kernels are singular where r = 0, that is x = ± i y.
    const CLEARANCE: f64 = 1.0;

    fn in_units_of(self, _unit: f64) -> Self {
        self
    }

    #[inline]
    fn at(&self, x: f64, y: f64) -> Coefficient {
        let inv_r2 = 1.0 / (x * x + y * y);
        let by_r = inv_r2.sqrt();
        let by_r3 = by_r * inv_r2;
        Coefficient {
            nn: by_r,
            xx: x * x * by_r3,
            yy: y * y * by_r3,
            xy: x * y * by_r3,
            nx: x * inv_r2,
            ny: y * inv_r2,
        }
    }

    fn corner(&self, px: Panel, py: Panel) -> Option<Coefficient> {
        Some(weighted_corner(px, py))
    }
}

/// Returns the integrals of the half-space's kernels for the receiver `offset` (Δi, Δj) elements of
/// size hx × hy away from the source, receiver minus source: the mean over the receiving element,
/// or the value at its centre. Their unit is length. The offset need not be whole: what rolls comes
/// from a place between elements.
///
/// Each is good to 1e-12 of itself (∫ x²/r³ and ∫ y²/r³, which only ever stand beside ∫ 1/r, to
/// 1e-12 of that) up to 4096 elements away in either direction for 1e-3 ≤ hx/hy ≤ 1e3; measured:
/// 1e-13. They are exactly zero where symmetry says so, and exactly (anti)symmetric in Δi, in Δj,
/// and under an exchange of x and y.
pub(crate) fn element(offset: [f64; 2], hx: f64, hy: f64, projection: Projection) -> Coefficient {
    element_of(Geometric, offset, hx, hy, projection)
}

/// Returns the integrals that [`element`] describes, for any kernel.
pub(super) fn element_of<K: Kernel>(
    kernel: K,
    offset: [f64; 2],
    hx: f64,
    hy: f64,
    projection: Projection,
) -> Coefficient {
    let [i, j] = offset.map(f64::abs);
    let quadrant = if hx == hy && i == j {
        let diagonal = ordered_element(kernel.in_units_of(hx), [i, j], 1.0, projection).scaled(hx);
        // Both are equal except for the order of summation.
        let (squares, linear) =
            (0.5 * (diagonal.xx + diagonal.yy), 0.5 * (diagonal.nx + diagonal.ny));
        Coefficient { xx: squares, yy: squares, nx: linear, ny: linear, ..diagonal }
    } else if (hx, i) >= (hy, j) {
        ordered_element(kernel.in_units_of(hx), [i, j], hy / hx, projection).scaled(hx)
    } else {
        ordered_element(kernel.in_units_of(hy), [j, i], hx / hy, projection).scaled(hy).transposed()
    };
    let mut signed = Coefficient::default();
    let sign = |offset: f64| if offset == 0.0 { 0.0 } else { offset.signum() };
    signed.add_mirrored(&quadrant, 1.0, offset.map(sign));
    signed
}

/// Returns the integrals for offsets (i, j) ≥ 0 and elements of size 1 × hy, hy ≤ 1. Kernels that
/// are odd in a zero offset are not defined.
fn ordered_element<K: Kernel>(
    kernel: K,
    [i, j]: [f64; 2],
    hy: f64,
    projection: Projection,
) -> Coefficient {
    let (rules, half) = match projection {
        Projection::Average => (gauss::tent(), 1.0),
        Projection::Midpoint => (gauss::uniform(), 0.5),
    };
    let (x, y, half_y) = (i, j * hy, half * hy);
    let (gap_x, gap_y) = ((x - half).max(0.0), (y - half_y).max(0.0));
    let points_x = gauss::points(K::CLEARANCE * (x * x + gap_y * gap_y) / (half * half));
    let points_y = gauss::points(K::CLEARANCE * (y * y + gap_x * gap_x) / (half_y * half_y));
    let mut sum = Coefficient::default();
    if let (Some(nx), Some(ny)) = (points_x, points_y) {
        for &(v, wy) in &rules[ny] {
            for &(u, wx) in &rules[nx] {
                sum.add(&kernel.at(x + half * u, y + half_y * v), wx * wy);
            }
        }
        return sum.scaled(hy);
    }
    for (py, sy) in panels(j, hy, projection) {
        for (px, sx) in panels(i, 1.0, projection) {
            sum.add_mirrored(&panel(kernel, px, py), 1.0, [sx, sy]);
        }
    }
    sum
}

/// Returns the integrals for the receiver at (x, y) and a source rectangle with half-sides a, b > 0
/// centred at the origin: displacement at a point, without averaging. The receiver may lie
/// anywhere. The unit of the integrals is length.
#[cfg(test)]
pub(crate) fn point([x, y]: [f64; 2], [a, b]: [f64; 2]) -> Coefficient {
    let unit = a.max(b);
    let (x, y, a, b) = (x / unit, y / unit, a / unit, b / unit);
    let mut sum = Coefficient::default();
    for (py, sy) in folded(y, b).into_iter().flatten() {
        for (px, sx) in folded(x, a).into_iter().flatten() {
            sum.add_mirrored(&panel(Geometric, px, py), 1.0, [sx, sy]);
        }
    }
    sum.scaled(unit)
}

/// An interval of the positive half-axis with a linear density on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panel {
    /// The middle, ≥ `half`; equal to it exactly when the panel begins at the origin.
    middle: f64,
    /// Half the width.
    half: f64,
    /// The density in the middle.
    density: f64,
    /// The density at the far end minus the density in the middle.
    slope: f64,
}

impl Panel {
    /// Returns half the width.
    pub(super) fn half(&self) -> f64 {
        self.half
    }

    /// Returns whether the panel begins at the origin.
    fn touches_origin(&self) -> bool {
        self.middle <= self.half
    }

    /// Cuts the panel in the middle.
    fn halves(&self) -> [Self; 2] {
        let (half, slope) = (0.5 * self.half, 0.5 * self.slope);
        [-1.0, 1.0].map(|side| Self {
            middle: self.middle + side * half,
            half,
            density: self.density + side * slope,
            slope,
        })
    }
}

/// Returns the density that a projection puts on receiver minus source, `offset` ≥ 0 elements of
/// width h away. What lies beyond the origin is folded to x ≥ 0; its sign of −1 is that of a kernel
/// that is odd.
fn panels(
    offset: f64,
    h: f64,
    projection: Projection,
) -> impl Iterator<Item = (Panel, f64)> + Clone {
    let piece = |middle: f64, half: f64, density: f64, slope: f64| {
        Some((Panel { middle: middle * h, half: half * h, density, slope }, 1.0))
    };
    // The piece begins at the origin.
    let folded = |half: f64, density: f64, slope: f64| {
        Some((Panel { middle: half * h, half: half * h, density, slope }, -1.0))
    };
    let pieces = match projection {
        Projection::Average if offset == 0.0 => [piece(0.5, 0.5, 1.0, -1.0), None, None],
        Projection::Average if offset >= 1.0 => {
            [piece(offset - 0.5, 0.5, 0.5, 0.5), piece(offset + 0.5, 0.5, 0.5, -0.5), None]
        }
        Projection::Average => {
            let (rising, beyond) = (0.5 * offset, 0.5 * (1.0 - offset));
            [
                piece(rising, rising, 1.0 - rising, rising),
                piece(offset + 0.5, 0.5, 0.5, -0.5),
                folded(beyond, beyond, -beyond),
            ]
        }
        Projection::Midpoint if offset == 0.0 => [piece(0.25, 0.25, 2.0, 0.0), None, None],
        Projection::Midpoint if offset >= 0.5 => [piece(offset, 0.5, 1.0, 0.0), None, None],
        Projection::Midpoint => {
            let near = 0.5 * (0.5 + offset);
            [piece(near, near, 1.0, 0.0), folded(0.5 * (0.5 - offset), 1.0, 0.0), None]
        }
    };
    pieces.into_iter().flatten()
}

/// Cuts the interval x − a … x + a at the origin and folds it to the positive half-axis; each piece
/// comes with its sign.
#[cfg(test)]
fn folded(x: f64, a: f64) -> [Option<(Panel, f64)>; 2] {
    let piece = |middle: f64, half: f64, sign: f64| {
        Some((Panel { middle, half, density: 1.0, slope: 0.0 }, sign))
    };
    if x.abs() >= a {
        return [piece(x.abs(), a, x.signum()), None];
    }
    let (below, above) = (0.5 * (a - x), 0.5 * (a + x));
    [piece(below, below, -1.0), piece(above, above, 1.0)]
}

/// Integrates over the product of two panels.
fn panel<K: Kernel>(kernel: K, px: Panel, py: Panel) -> Coefficient {
    if px.touches_origin() && py.touches_origin() {
        return kernel.corner(px, py).unwrap_or_else(|| {
            let [first, second] = if px.half >= py.half {
                px.halves().map(|px| [px, py])
            } else {
                py.halves().map(|py| [px, py])
            };
            let mut sum = panel(kernel, first[0], first[1]);
            sum.add(&panel(kernel, second[0], second[1]), 1.0);
            sum
        });
    }
    let squared = |middle: f64, gap: f64, half: f64| {
        K::CLEARANCE * (middle * middle + gap * gap) / (half * half)
    };
    let (gap_x, gap_y) = ((px.middle - px.half).max(0.0), (py.middle - py.half).max(0.0));
    let points_x = gauss::points(squared(px.middle, gap_y, px.half));
    let points_y = gauss::points(squared(py.middle, gap_x, py.half));
    let mut sum = Coefficient::default();
    match (points_x, points_y) {
        (Some(nx), Some(ny)) => {
            sum = panel_by_gauss(&px, &py, [nx, ny], |x, y| kernel.at(x, y));
        }
        // One direction is halved at a time, because the other may already be smooth.
        (None, _) => px.halves().iter().for_each(|&p| sum.add(&panel(kernel, p, py), 1.0)),
        (_, None) => py.halves().iter().for_each(|&p| sum.add(&panel(kernel, px, p), 1.0)),
    }
    sum
}

/// Integrates over the product of two panels by Gauss rules of `points` points along x and y.
pub(super) fn panel_by_gauss(
    px: &Panel,
    py: &Panel,
    points: [usize; 2],
    kernel: impl Fn(f64, f64) -> Coefficient,
) -> Coefficient {
    let mut sum = Coefficient::default();
    for &(v, wy) in &gauss::uniform()[points[1]] {
        let wy = wy * (py.density + py.slope * v);
        for &(u, wx) in &gauss::uniform()[points[0]] {
            let wx = wx * (px.density + px.slope * u);
            sum.add(&kernel(px.middle + px.half * u, py.middle + py.half * v), wx * wy);
        }
    }
    sum.scaled(4.0 * px.half * py.half)
}

/// Integrates the half-space's kernels over the product of two panels that both begin at the
/// origin.
pub(super) fn weighted_corner(px: Panel, py: Panel) -> Coefficient {
    let [one, x, y, xy] = corner(2.0 * px.half, 2.0 * py.half);
    // The density is its value at the origin plus the slope per unit of length times the distance
    // from it.
    let (x0, x1) = (px.density - px.slope, px.slope / px.half);
    let (y0, y1) = (py.density - py.slope, py.slope / py.half);
    let mut sum = Coefficient::default();
    for (moment, factor) in [(one, x0 * y0), (x, x1 * y0), (y, x0 * y1), (xy, x1 * y1)] {
        sum.add(&moment, factor);
    }
    sum
}

/// Returns the integrals of the kernels times 1, x, y, xy over 0 … X, 0 … Y, in closed form.
///
/// A function f that is homogeneous of degree m satisfies div(f·(x, y)) = (m + 2) f, so its
/// integral over the rectangle is [X ∫ f(X, y) dy + Y ∫ f(x, Y) dx]/(m + 2): the singular corner
/// drops out and two elementary integrals remain.
fn corner(xe: f64, ye: f64) -> [Coefficient; 4] {
    let r = xe.hypot(ye);
    let (tx, ty) = (xe / ye, ye / xe);
    // These are r − X and r − Y without cancellation.
    let (r_x, r_y) = (ye * ye / (r + xe), xe * xe / (r + ye));
    let (along_x, along_y) = (ye * tx.asinh(), xe * ty.asinh()); // ∫ x²/r³, ∫ y²/r³
    let (log_x, log_y) = ((tx * tx).ln_1p(), (ty * ty).ln_1p());
    let (x2, y2) = (xe * xe, ye * ye);
    let (x3, y3) = (x2 * xe, y2 * ye);
    // These are ∫ x²y/r³ and ∫ xy²/r³.
    let xxy = 0.5 * (x2 * r_x / r + y2 * asinh_defect(tx));
    let xyy = 0.5 * (y2 * r_y / r + x2 * asinh_defect(ty));
    let x_by_r2 = 0.5 * (x2 * ty.atan() + y2 * atan_defect(tx)); // ∫ x²/r²
    let y_by_r2 = 0.5 * (y2 * tx.atan() + x2 * atan_defect(ty));
    let product_by_r2 = 0.25 * (x2 * log_y + y2 * log_x); // ∫ xy/r²
    [
        Coefficient {
            nn: along_x + along_y,
            xx: along_x,
            yy: along_y,
            xy: 2.0 * xe * ye / (xe + ye + r),
            nx: 0.5 * ye * log_x + xe * ty.atan(),
            ny: 0.5 * xe * log_y + ye * tx.atan(),
        },
        Coefficient {
            nn: 0.5 * (xe * along_y + ye * r_y),
            xx: 0.5 * ye * (x2 + r_y * r_y) / r,
            yy: xyy,
            xy: xxy,
            nx: x_by_r2,
            ny: product_by_r2,
        },
        Coefficient {
            nn: 0.5 * (ye * along_x + xe * r_x),
            xx: xxy,
            yy: 0.5 * xe * (y2 + r_x * r_x) / r,
            xy: xyy,
            nx: product_by_r2,
            ny: y_by_r2,
        },
        Coefficient {
            nn: (x2 * r_x + y2 * r_y) / 3.0,
            xx: (x3 * r_x + y2 * r_y * r_y) / (3.0 * r),
            yy: (y3 * r_y + x2 * r_x * r_x) / (3.0 * r),
            xy: (x3 * asinh_defect(ty) + y3 * asinh_defect(tx)) / 3.0,
            nx: (0.5 * x3 * log_y + y3 * atan_defect(tx)) / 3.0,
            ny: (0.5 * y3 * log_x + x3 * atan_defect(ty)) / 3.0,
        },
    ]
}

/// The argument below which a defect is summed as a series; above, the difference costs at most two
/// digits.
const SERIES: f64 = 0.3;

/// Returns ∫₀ᵗ s²/(1+s²)^{3/2} ds = asinh t − t/√(1+t²), t ≥ 0.
fn asinh_defect(t: f64) -> f64 {
    if t > SERIES {
        return t.asinh() - t / t.hypot(1.0);
    }
    let mut binomial = 1.0; // (−3/2 over k) t²ᵏ
    let mut sum = 0.0;
    for k in 0..18 {
        let k = f64::from(k);
        sum += binomial / (2.0 * k + 3.0);
        binomial *= -(k + 1.5) / (k + 1.0) * t * t;
    }
    sum * t * t * t
}

/// Returns ∫₀ᵗ s²/(1+s²) ds = t − atan t, t ≥ 0.
fn atan_defect(t: f64) -> f64 {
    if t > SERIES {
        return t - t.atan();
    }
    let mut power = 1.0;
    let mut sum = 0.0;
    for k in 0..18 {
        sum += power / (2.0 * f64::from(k) + 3.0);
        power *= -t * t;
    }
    sum * t * t * t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the largest error of each kernel over rows of
    /// projection,hx,hy,di,dj,inv_r,xx,yy,xy,x,y, relative to itself except for x²/r³ and y²/r³,
    /// whose errors are relative to 1/r.
    fn worst(reference: &str) -> [(f64, String); 6] {
        let mut worst: [(f64, String); 6] = Default::default();
        for line in reference.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |k: usize| cells[k].parse::<f64>().unwrap();
            let projection = match cells[0] {
                "average" => Projection::Average,
                "midpoint" => Projection::Midpoint,
                other => panic!("{other}"),
            };
            let offset = [3, 4].map(|k| cells[k].parse::<f64>().unwrap());
            let got = element(offset, number(1), number(2), projection);
            for (k, got) in [got.nn, got.xx, got.yy, got.xy, got.nx, got.ny].into_iter().enumerate()
            {
                let exact = number(5 + k);
                let unit = if k == 1 || k == 2 { number(5) } else { exact };
                let error = if exact == 0.0 { got.abs() } else { ((got - exact) / unit).abs() };
                if error > worst[k].0 || error.is_nan() {
                    worst[k] = (error, line.to_owned());
                }
            }
        }
        worst
    }

    #[test]
    fn every_kernel_meets_the_high_precision_reference() {
        let reference = include_str!("../../tests/reference/half_space_integrals.csv");
        assert!(reference.lines().count() > 900);
        for (k, (error, line)) in worst(reference).into_iter().enumerate() {
            assert!(error < 1e-13, "kernel {k}: {error:e} at {line}");
        }
    }

    #[test]
    fn the_mean_over_an_element_is_the_mean_of_its_points() {
        for (hx, hy) in [(1.0, 1.0), (0.6, 1.0), (0.2, 0.1)] {
            for (i, j) in
                [(4, 0), (0, 4), (3, 3), (-2, 3), (5, -9), (40, 1), (-17, -200), (900, 901)]
                    .map(|(i, j)| (f64::from(i), f64::from(j)))
            {
                let average = element([i, j], hx, hy, Projection::Average);
                let mut mean = Coefficient::default();
                for &(v, wy) in &gauss::uniform()[gauss::MAX_POINTS] {
                    for &(u, wx) in &gauss::uniform()[gauss::MAX_POINTS] {
                        let (x, y) = ((i + 0.5 * u) * hx, (j + 0.5 * v) * hy);
                        mean.add_mirrored(&point([x, y], [0.5 * hx, 0.5 * hy]), wx * wy, [1.0; 2]);
                    }
                }
                let difference = |a: f64, b: f64| (a - b).abs() / average.nn;
                assert!(difference(average.nn, mean.nn) < 1e-12, "{i} {j}");
                assert!(
                    difference(average.xx, mean.xx) < 1e-12
                        && difference(average.yy, mean.yy) < 1e-12,
                    "{i} {j}"
                );
                assert!(difference(average.xy, mean.xy) < 1e-12, "{i} {j}");
                assert!(
                    difference(average.nx, mean.nx) < 1e-12
                        && difference(average.ny, mean.ny) < 1e-12,
                    "{i} {j}"
                );
            }
        }
    }

    #[test]
    fn symmetries_are_exact() {
        for projection in [Projection::Average, Projection::Midpoint] {
            for (hx, hy) in [(1.0, 1.0), (0.7, 1.0), (1e3, 1.0)] {
                for (i, j) in
                    [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (2.0, 1.0), (1.0, 7.0), (30.0, 400.0)]
                {
                    let right = element([i, j], hx, hy, projection);
                    let left = element([-i, j], hx, hy, projection);
                    assert_eq!(left, Coefficient { xy: -right.xy, nx: -right.nx, ..right });
                    let down = element([i, -j], hx, hy, projection);
                    assert_eq!(down, Coefficient { xy: -right.xy, ny: -right.ny, ..right });
                    assert_eq!(element([j, i], hy, hx, projection), right.transposed());
                }
            }
        }
    }

    #[test]
    fn a_midpoint_coefficient_is_the_displacement_at_a_point() {
        for i in [0.0, 1.0, 3.0, -60.0, 0.25, -0.5, 0.75, -1.4, 17.125, 1e-9, -0.1] {
            for j in [0.0, 1.0, -4.0, 30.0] {
                let coefficient = element([i, j], 0.5, 2.0, Projection::Midpoint);
                let at_point = point([i * 0.5, j * 2.0], [0.25, 1.0]);
                let close = |a: f64, b: f64| (a - b).abs() <= 2e-14 * at_point.nn;
                assert!(close(coefficient.nn, at_point.nn), "{i} {j}");
                assert!(close(coefficient.xx, at_point.xx), "{i} {j}");
                assert!(close(coefficient.yy, at_point.yy), "{i} {j}");
                assert!(close(coefficient.xy, at_point.xy), "{i} {j}");
                assert!(close(coefficient.nx, at_point.nx), "{i} {j}");
                assert!(close(coefficient.ny, at_point.ny), "{i} {j}");
            }
        }
    }

    /// The mean over an element is also the mean of the values at points of two halves of it, which
    /// lie a quarter of an element to both sides.
    #[test]
    fn the_mean_over_an_element_between_others_is_that_of_its_halves() {
        let (hx, hy) = (0.6, 0.5);
        for i in [0.0, 0.3, -0.5, 0.75, 1.0, -1.6, 4.25, 1e-7] {
            for j in [0.0, 1.0, -2.0] {
                let whole = element([i, j], hx, hy, Projection::Average);
                // Source and receiver are cut in two along x.
                let mut halves = Coefficient::default();
                for shift in [-1.0, 0.0, 0.0, 1.0] {
                    let part = element([2.0 * i + shift, j], 0.5 * hx, hy, Projection::Average);
                    halves.add(&part, 0.5);
                }
                let close = |a: f64, b: f64| (a - b).abs() <= 2e-14 * whole.nn;
                assert!(close(whole.nn, halves.nn), "{i} {j}");
                assert!(close(whole.xx, halves.xx), "{i} {j}");
                assert!(close(whole.xy, halves.xy), "{i} {j}");
                assert!(close(whole.nx, halves.nx), "{i} {j}");
                assert!(close(whole.ny, halves.ny), "{i} {j}");
            }
        }
    }

    #[test]
    fn extreme_elements_stay_finite() {
        for (hx, hy) in [(1e-150, 1e-150), (1e150, 1e150), (1e-12, 1.0), (1.0, 1e-12)] {
            for offset in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [4096.0, 4096.0]] {
                let got = element(offset, hx, hy, Projection::Average);
                assert!(got.nn.is_finite() && got.nn > 0.0, "{hx} {hy} {offset:?} {got:?}");
                assert!((got.xx + got.yy - got.nn).abs() <= 1e-12 * got.nn);
            }
        }
    }
}
