//! Residuals of stresses: the same numbers by other ways.

use super::loaded::{PlaneStress, Subsurface};
use crate::common::gauss;
use crate::foundation::{DepthSide, StressKernels, longest_length};
use crate::model::Stress;

/// Returns the larger one of two residuals; what is not a number is infinitely wrong.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// Returns the size of the largest of some numbers, or infinity if one is not a number.
pub(super) fn largest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers.into_iter().fold(0.0, |most, number| larger(most, number.abs()))
}

/// Returns the largest difference of components.
fn difference(a: &Stress, b: &Stress) -> f64 {
    largest(a.components().into_iter().zip(b.components()).map(|(a, b)| a - b))
}

/// Returns the largest difference between the stresses of a plane, which transforms made, and
/// direct sums at a few elements, relative to the largest stress on the plane.
pub(super) fn transform_residual(below: &Subsurface<'_>, plane: &PlaneStress) -> Option<f64> {
    let size_of = |element: &usize| largest(plane.stresses[*element].components());
    let count = plane.stresses.len();
    let worst = (0..count).max_by(|a, b| size_of(a).total_cmp(&size_of(b)))?;
    let size = size_of(&worst);
    if size == 0.0 {
        return Some(0.0);
    }
    let kernels = below.kernels(plane.depth, DepthSide::Above, below.fields.origin)?;
    let differences = [worst, 0, count / 2, count - 1].into_iter().map(|element| {
        difference(&below.sum(&kernels, below.center(element)), &plane.stresses[element])
    });
    Some(largest(differences) / size)
}

/// Returns the difference between the stress at a point and the sum over quarters of elements,
/// whose corners and rules are others; on the surface also that between stresses and tractions.
/// Both are relative to the largest stress there.
pub(super) fn point_residual(
    below: &Subsurface<'_>,
    [x, y, z]: [f64; 3],
    stress: &Stress,
) -> Option<f64> {
    let size = largest(stress.components());
    let kernels = below.kernels(z, DepthSide::Above, [x, y])?;
    // Stresses that are infinite, or jump, on an edge do so on the edges of quarters too.
    let places = [x, y];
    let halves =
        [0, 1].map(|i| 2.0 * (places[i] - below.fields.origin[i]) / below.fields.element[i]);
    let is_on_edge = z == 0.0 && halves.iter().any(|half| (half - half.round()).abs() < 1e-6);
    let mut residual = 0.0;
    if !is_on_edge && size > 0.0 {
        residual = difference(stress, &below.sum_of_quarters(&kernels, places)) / size;
    }
    if z == 0.0
        && let Some([pressure, along_x, along_y]) = below.tractions_inside(places)
    {
        let beside = [stress.zz + pressure, stress.xz + along_x, stress.yz + along_y];
        let size = size.max(largest([pressure, along_x, along_y]));
        if size > 0.0 {
            residual = larger(residual, largest(beside) / size);
        }
    }
    Some(residual)
}

/// Returns the largest difference, relative to the load, between what a plane at a depth > 0
/// carries below a small loaded square and the load on that: the forces under pressure and under
/// both tangential tractions, and the moment of these about the square.
pub(super) fn load_residual(below: &Subsurface<'_>, depth: f64, side: DepthSide) -> Option<f64> {
    /// The number of angles in a quarter of the circle.
    const ANGLES: usize = 8;
    /// The number of points of a rule along the radius.
    const POINTS: usize = 10;
    /// The ratio of the ends of a piece of the radius.
    const RATIO: f64 = 2.0;
    /// The radius, in the longest of all lengths, beyond which what is left of the forces falls
    /// like 1/r.
    const FARTHEST: f64 = 1e4;
    let longest = depth.max(longest_length(below.foundation));
    let farthest = FARTHEST * longest;
    // The last piece of the radius may end beyond.
    let reach = 1.01 * RATIO * farthest;
    let kernels = StressKernels::new(below.foundation, depth, side, reach)?;
    let half_side = 0.25 * depth;
    let area = 4.0 * half_side * half_side;
    let (mut inner, mut outer) = (0.0, 0.2 * depth);
    // The forces along z, x and y under loads along them, and the moments under those along x and
    // y; in the unit of the load, and of the load times the longest length: rounding of stresses
    // that are far away has that arm, and more.
    let (mut sums, mut before) = ([0.0; 5], [0.0; 5]);
    while inner < farthest {
        before = sums;
        for &(u, weight) in &gauss::uniform()[POINTS] {
            let r = 0.5 * (inner + outer) + 0.5 * (outer - inner) * u;
            let ring =
                weight * (outer - inner) * std::f64::consts::TAU * r / (ANGLES as f64 * area);
            for angle in 0..ANGLES {
                let turn = std::f64::consts::FRAC_PI_2 * (angle as f64 + 0.5) / ANGLES as f64;
                let [x, y] = [r * turn.cos(), r * turn.sin()];
                let [_, _, zz, _, yz, xz] = kernels.stresses([x, y], [half_side; 2]);
                let parts = [zz[0], xz[1], yz[2], zz[1] * (x / longest), zz[2] * (y / longest)];
                for (sum, part) in sums.iter_mut().zip(parts) {
                    *sum += ring * part;
                }
            }
        }
        (inner, outer) = (outer, outer * RATIO);
    }
    // What is left beyond halves from the last radius but one to the last, but for the pressure.
    let rest = |i: usize| if i == 0 { 0.0 } else { (sums[i] - before[i]) / (RATIO - 1.0) };
    let exact = |i: usize| if i < 3 { -1.0 } else { -depth / longest };
    Some(largest((0..5).map(|i| sums[i] + rest(i) - exact(i))))
}
