//! Residuals of stresses: the same numbers by other ways.

use super::loaded::{PlaneStress, Subsurface};
use crate::common::gauss;
use crate::foundation::{DepthSide, StressKernels};

/// Returns the largest difference between the stresses of a plane, which transforms made, and
/// direct sums at a few elements, relative to the largest stress on the plane.
pub(super) fn transform_residual(below: &Subsurface<'_>, plane: &PlaneStress) -> f64 {
    let largest = |stress: &crate::model::Stress| {
        stress.components().into_iter().fold(0.0_f64, |most, part| most.max(part.abs()))
    };
    let count = plane.stresses.len();
    let by_size = |a: &usize, b: &usize| {
        largest(&plane.stresses[*a]).total_cmp(&largest(&plane.stresses[*b]))
    };
    let Some(worst) = (0..count).max_by(by_size) else { return 0.0 };
    let size = largest(&plane.stresses[worst]);
    let Some(kernels) = below.kernels(plane.depth, DepthSide::Above, below.fields.origin) else {
        return 0.0;
    };
    if size == 0.0 {
        return 0.0;
    }
    [worst, 0, count / 2, count - 1]
        .into_iter()
        .map(|element| {
            let direct = below.sum(&kernels, below.center(element)).components();
            let transformed = plane.stresses[element].components();
            direct.iter().zip(transformed).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
        })
        .fold(0.0, f64::max)
        / size
}

/// Returns the difference between the load that a plane at a depth > 0 carries below a small loaded
/// square and the load on the square, relative to that: ∫ σ_zz over the plane must be −P.
pub(super) fn load_residual(below: &Subsurface<'_>, depth: f64, side: DepthSide) -> f64 {
    /// The number of angles in an eighth of the circle.
    const ANGLES: usize = 4;
    /// The number of points of a rule along the radius.
    const POINTS: usize = 10;
    /// The ratio of the ends of a piece of the radius.
    const RATIO: f64 = 1.6;
    /// The radius, in depths, beyond which nothing is left.
    const FARTHEST: f64 = 1e4;
    let layers: f64 = below.foundation.layers.iter().map(|layer| layer.thickness).sum();
    let farthest = FARTHEST * depth.max(layers);
    let Some(kernels) = StressKernels::new(below.foundation, depth, side, 1.1 * farthest) else {
        return 0.0;
    };
    let half_side = 0.25 * depth;
    let area = 4.0 * half_side * half_side;
    let (mut inner, mut outer, mut sum) = (0.0, 0.2 * depth, 0.0);
    while inner < farthest {
        for &(u, weight) in &gauss::uniform()[POINTS] {
            let r = 0.5 * (inner + outer) + 0.5 * (outer - inner) * u;
            let mean = (0..ANGLES)
                .map(|angle| {
                    let turn = std::f64::consts::FRAC_PI_4 * (angle as f64 + 0.5) / ANGLES as f64;
                    kernels.stresses([r * turn.cos(), r * turn.sin()], [half_side; 2])[2][0]
                })
                .sum::<f64>()
                / ANGLES as f64;
            sum += weight * (outer - inner) * std::f64::consts::TAU * r * mean;
        }
        (inner, outer) = (outer, outer * RATIO);
    }
    (sum / area + 1.0).abs()
}
