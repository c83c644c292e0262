//! Residuals of a claimed solution, by formulas and arithmetic of their own.
//!
//! Nothing here calls [`g_mu`](crate::problem::g_mu), [`crate::solver`] or
//! [`observables`](fn@super::observables): the conditions of contact and Coulomb's law are spelled
//! out again, and what the operator's transform gives is held against plain sums.

use std::ops::Range;

use rayon::prelude::*;

use crate::common::parallel;
use crate::grid::Grid;
use crate::influence::{Components, Diagonals, Direction, InfluenceTable};
use crate::model::{Certificate, Control, Dof, Observables, PerDof};
use crate::problem::Problem;

impl Certificate {
    /// Whether the residuals allow to call it a solution: the natural-map residual, tension, cone
    /// violation and the balance of forces within `tolerance`. Penetration, gap under pressure and
    /// the angle of slip are bounded by the natural-map residual; they are reported because they
    /// are what a reader can picture.
    pub fn meets(&self, tolerance: f64) -> bool {
        [self.residual, self.tension, self.cone_violation, self.force_imbalance]
            .iter()
            .all(|figure| *figure <= tolerance)
    }
}

/// Elements on which [`transform_error`] looks, and the one with the largest pressure.
const LOOKED_AT: usize = 7;

/// The largest difference, on some elements all over Ω, between the displacements A `p` as a
/// transform gave them and as the sum over all elements gives them, over the largest displacement:
/// what a solver that applies the same transform cannot hide. Both are blocks of `components`.
pub fn transform_error(
    table: &InfluenceTable,
    grid: &Grid,
    components: Components,
    p: &[f64],
    displacement: &[f64],
) -> f64 {
    let k = grid.len();
    let first = grid.active().max_by(|a, b| p[*a].total_cmp(&p[*b]));
    let looked_at: Vec<usize> = first
        .into_iter()
        .chain(grid.active().step_by(grid.active_len().div_ceil(LOOKED_AT).max(1)))
        .collect();
    let differences = looked_at.par_iter().map(|&e| {
        let summed = table.displacement_at(e, components, p);
        let off = |(block, to): (usize, Direction)| {
            (displacement[block * k + e] - summed[to as usize]).abs()
        };
        components.directions().enumerate().map(off).fold(0.0, larger)
    });
    let largest = parallel::bands(displacement.len(), |band| {
        displacement[band].iter().map(|u| u.abs()).fold(0.0, larger)
    });
    let difference = differences.collect::<Vec<_>>().into_iter().fold(0.0, larger);
    if difference == 0.0 {
        0.0
    } else {
        larger(0.0, difference / largest.into_iter().fold(0.0, larger))
    }
}

/// The larger of two numbers; infinite where one is none.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// What a band of elements adds.
struct Part {
    /// The largest figures; the residual and the imbalance are of the whole.
    certificate: Certificate,
    /// Sums of tractions and of their moments.
    force: PerDof<f64>,
    /// Sum of the largest components.
    magnitude: f64,
    /// The largest traction, and in units of it the squares of the defect and of the tractions.
    unit: f64,
    defect: f64,
    size: f64,
}

/// Certifies tractions `p` against `problem`. `displacement` is A p and `diagonal` the diagonal
/// entries of A, on all of Ω and without mirror planes; `claimed` are the observables \[SI\] that
/// go out with `p`, `asked` what was to govern the punch \[SI\].
pub fn certify(
    problem: &Problem,
    p: &[f64],
    displacement: &[f64],
    diagonal: impl Into<Diagonals>,
    claimed: &Observables,
    asked: &PerDof<Control>,
) -> Certificate {
    let k = problem.grid.len();
    let Diagonals { normal, tangential } = diagonal.into();
    let (mu, ceiling) = (problem.mu, problem.ceiling);
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, larger);
    let largest_of = |value: &(dyn Fn(usize) -> f64 + Sync)| {
        largest(
            &mut parallel::bands(k, |band| largest(&mut problem.grid.active_in(band).map(value)))
                .into_iter(),
        )
    };
    let peak = largest_of(&|e| p[e].abs());
    let deepest =
        largest_of(&|e| (displacement[e] + problem.epsilon * p[e]).abs()).max(f64::MIN_POSITIVE);
    let relative = |value: f64, to: f64| if value == 0.0 { 0.0 } else { value / to };

    // w of equation (3): what the regularised law sees as gap and slip
    let w = |e: usize, c: usize| {
        displacement[c * k + e] + problem.epsilon * p[c * k + e] - problem.f[c * k + e]
    };
    let largest_slip = largest_of(&|e| if p[e] > 0.0 { w(e, 1).hypot(w(e, 2)) } else { 0.0 });

    let of_band = |band: Range<usize>| {
        let mut certificate = Certificate::default();
        // tractions with their images, kept to be measured in units of the largest: squares leave
        // the range of doubles early
        let mut images: Vec<[[f64; 3]; 2]> = Vec::with_capacity(band.len());
        let (mut force, mut magnitude) = (PerDof::all(0.0), 0.0);
        for e in problem.grid.active_in(band) {
            let [pressure, px, py] = [p[e], p[k + e], p[2 * k + e]];
            let traction = px.hypot(py);
            let [gap, slip_x, slip_y] = [w(e, 0), w(e, 1), w(e, 2)];

            // the natural map, written as a nearest point of the truncated cone's section rather
            // than as G
            let (press, pull) =
                (1.0 / (normal + problem.epsilon), 1.0 / (tangential + problem.epsilon));
            let trial = (pressure - press * gap, px - pull * slip_x, py - pull * slip_y);
            let allowed = if trial.0 <= 0.0 {
                0.0
            } else if trial.0 >= ceiling {
                ceiling
            } else {
                trial.0
            };
            let radius = mu * allowed;
            let trial_traction = trial.1.hypot(trial.2);
            let shrink = if trial_traction > radius { radius / trial_traction } else { 1.0 };
            images.push([[pressure, px, py], [allowed, trial.1 * shrink, trial.2 * shrink]]);

            certificate.tension = certificate.tension.max(relative((-pressure).max(0.0), peak));
            // at the ceiling the law (3) lets the bodies overlap
            if pressure < ceiling {
                certificate.penetration =
                    certificate.penetration.max(relative((-gap).max(0.0), deepest));
            }
            certificate.gap_under_pressure = certificate
                .gap_under_pressure
                .max(relative((gap * pressure).max(0.0), peak * deepest));
            certificate.cone_violation =
                certificate.cone_violation.max(relative((traction - mu * pressure).max(0.0), peak));
            let slip = slip_x.hypot(slip_y);
            if pressure > 0.0 && slip > 1e-3 * largest_slip && traction > 1e-6 * mu * peak {
                let against = -(slip_x * px + slip_y * py);
                let across = slip_x * py - slip_y * px;
                // sticking elements do not slip beyond the residual; where slip is real, traction
                // must oppose it
                if traction >= mu * pressure * (1.0 - 1e-6) {
                    certificate.slip_angle =
                        certificate.slip_angle.max(across.abs().atan2(against));
                }
            }
            let [x, y] = problem.grid.center(e);
            for (total, part) in force.iter_mut().zip([
                pressure,
                px,
                py,
                y * pressure,
                -(x * pressure),
                x * py - y * px,
            ]) {
                *total += part;
            }
            magnitude += pressure.abs().max(px.abs()).max(py.abs());
        }
        let unit = largest(&mut images.iter().flatten().flatten().map(|t| t.abs()));
        let square = |a: f64, b: f64| if unit == 0.0 { 0.0 } else { ((a - b) / unit).powi(2) };
        let defect: f64 = images
            .iter()
            .flat_map(|[own, image]| own.iter().zip(image))
            .map(|(a, b)| square(*a, *b))
            .sum();
        let size: f64 = images.iter().flat_map(|[own, _]| own).map(|a| square(*a, 0.0)).sum();
        Part { certificate, force, magnitude, unit, defect, size }
    };
    let parts = parallel::bands(k, of_band);
    let mut certificate = Certificate::default();
    let unit = largest(&mut parts.iter().map(|part| part.unit));
    let (mut force, mut magnitude, mut defect, mut size) = (PerDof::all(0.0), 0.0, 0.0, 0.0);
    for part in parts {
        let own = part.certificate;
        certificate.tension = certificate.tension.max(own.tension);
        certificate.penetration = certificate.penetration.max(own.penetration);
        certificate.gap_under_pressure = certificate.gap_under_pressure.max(own.gap_under_pressure);
        certificate.cone_violation = certificate.cone_violation.max(own.cone_violation);
        certificate.slip_angle = certificate.slip_angle.max(own.slip_angle);
        force.iter_mut().zip(part.force).for_each(|(total, part)| *total += part);
        magnitude += part.magnitude;
        let ratio = if part.unit == 0.0 { 0.0 } else { (part.unit / unit).powi(2) };
        defect += part.defect * ratio;
        size += part.size * ratio;
    }
    certificate.residual = if unit == 0.0 {
        0.0
    } else {
        // 0/0 comes of tractions that are no numbers
        let residual = (defect / size).sqrt();
        if residual.is_nan() { f64::INFINITY } else { residual }
    };

    let area = problem.grid.element_area();
    let unit = problem.scale.traction() * problem.scale.length * problem.scale.length * area;
    let magnitude = magnitude * unit;
    let c = claimed;
    let claims = PerDof::new([c.load, c.force_x, c.force_y, c.moment_x, c.moment_y, c.moment_z]);
    // of forces below the range of doubles no digit is certain
    if peak > 0.0 && !magnitude.is_normal() {
        certificate.force_imbalance = f64::INFINITY;
    }
    for dof in Dof::ALL {
        let arm = if dof.is_rotation() { problem.scale.length } else { 1.0 };
        // `max` would pass over what is no number
        let off = |from: f64| relative((from - force[dof] * unit * arm).abs(), magnitude * arm);
        let asked = if let Control::Force(asked) = asked[dof] { off(asked) } else { 0.0 };
        for off in [off(claims[dof]), asked] {
            certificate.force_imbalance =
                if off.is_nan() { f64::INFINITY } else { certificate.force_imbalance.max(off) };
        }
    }
    certificate
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foundation::HalfSpace;
    use crate::influence::{Influence, Toeplitz};
    use crate::model::{Material, Projection};

    #[test]
    fn a_wrong_transform_shows_in_any_component() {
        let grid = Grid::new(9, 6, 0.5, 0.75, [0.0; 2]).unwrap();
        let table = |poisson: f64| {
            let bodies = HalfSpace::new(&Material { shear_modulus: 1.0, poisson }, None);
            InfluenceTable::new(&grid, &bodies, Projection::Average)
        };
        let (right, wrong) = (table(0.3), table(0.31));
        let operator = Toeplitz::new(&right);
        for components in [Components::ALL, Components::NORMAL] {
            let p: Vec<f64> =
                (0..components.len() * grid.len()).map(|i| (0.7 * i as f64).sin()).collect();
            let mut displacement = vec![0.0; 3 * grid.len()];
            let all: Vec<f64> =
                (0..3 * grid.len()).map(|i| p.get(i).copied().unwrap_or(0.0)).collect();
            operator.apply(&mut displacement, &all, &mut crate::influence::Scratch::new(&operator));
            displacement.truncate(p.len());
            let error = |table: &InfluenceTable, displacement: &[f64]| {
                transform_error(table, &grid, components, &p, displacement)
            };
            assert!(
                error(&right, &displacement) < 1e-15 * 10.0,
                "{}",
                error(&right, &displacement)
            );
            assert!(error(&wrong, &displacement) > 1e-3);
            displacement[0] = f64::NAN;
            assert_eq!(error(&right, &displacement), f64::INFINITY);
        }
        assert_eq!(transform_error(&right, &grid, Components::ALL, &[0.0; 162], &[0.0; 162]), 0.0);
    }
}
