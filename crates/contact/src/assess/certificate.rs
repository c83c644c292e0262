//! Residuals of a claimed solution, by formulas and arithmetic of their own.
//!
//! Nothing here calls [`g_mu`](crate::problem::g_mu), [`crate::solver`] or
//! [`observables`](fn@super::observables): the conditions of contact and Coulomb's law are spelled
//! out again, and the result of the operator's transform is compared with plain sums.

use std::ops::Range;

use rayon::prelude::*;

use crate::common::parallel;
use crate::grid::Grid;
use crate::influence::{Components, Diagonals, Direction};
use crate::model::{Certificate, Control, Dof, Observables, PerDof};
use crate::problem::Problem;

impl Certificate {
    /// Returns whether the residuals allow to call it a solution: the natural-map residual,
    /// tension, cone violation and the balance of forces within `tolerance`. Penetration, gap under
    /// pressure and the angle of slip are bounded by the natural-map residual; they are reported
    /// because a reader can picture them.
    pub fn meets(&self, tolerance: f64) -> bool {
        [self.residual, self.tension, self.cone_violation, self.force_imbalance]
            .iter()
            .all(|figure| *figure <= tolerance)
    }
}

/// The number of elements that [`transform_error`] samples, in addition to the one with the largest
/// pressure.
const SAMPLED_ELEMENTS: usize = 7;

/// Returns the largest difference, on some elements all over Ω, between the displacements A `p` as
/// a transform gave them and as the sum over all elements gives them, over the largest
/// displacement. A solver that applies the same transform cannot hide it. Both fields are blocks of
/// `components`, and `sum` adds up the displacement (n, x, y) of an element. Normal and tangential
/// displacements are measured `apart`, or all in the largest.
pub(crate) fn transform_error(
    sum: impl Fn(usize) -> [f64; 3] + Sync,
    grid: &Grid,
    components: Components,
    apart: bool,
    [p, displacement]: [&[f64]; 2],
) -> f64 {
    let k = grid.len();
    let first = grid.active().max_by(|a, b| p[*a].total_cmp(&p[*b]));
    let sampled: Vec<usize> = first
        .into_iter()
        .chain(grid.active().step_by(grid.active_len().div_ceil(SAMPLED_ELEMENTS).max(1)))
        .collect();
    // Each sum is of the normal displacements, and of the tangential ones if they are apart.
    let place = |to: Direction| usize::from(apart && to != Direction::N);
    let larger_of = |a: [f64; 2], b: [f64; 2]| [larger(a[0], b[0]), larger(a[1], b[1])];
    let alone =
        |place: usize, value: f64| [0, 1].map(|index| if index == place { value } else { 0.0 });
    let differences = sampled.par_iter().map(|&e| {
        let summed = sum(e);
        let error = |(block, to): (usize, Direction)| {
            alone(place(to), (displacement[block * k + e] - summed[to as usize]).abs())
        };
        components.directions().enumerate().map(error).fold([0.0; 2], larger_of)
    });
    let differences = differences.collect::<Vec<_>>().into_iter().fold([0.0; 2], larger_of);
    let largest_of = |(block, to): (usize, Direction)| {
        let displacement = &displacement[block * k..][..k];
        let bands = parallel::bands(k, |band| largest(displacement[band].iter().map(|u| u.abs())));
        alone(place(to), largest(bands.into_iter()))
    };
    let sizes = components.directions().enumerate().map(largest_of).fold([0.0; 2], larger_of);
    largest((0..2).map(|place| relative(differences[place], sizes[place])))
}

/// Returns the larger of two numbers, or infinity if one is not a number.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// Returns the largest of some numbers, at least 0, or infinity if one is not a number.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, larger)
}

/// Returns a number over another, and 0 for 0 over anything.
fn relative(value: f64, unit: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value / unit }
}

/// A claimed solution, in the problem's units.
struct Claim<'a> {
    problem: &'a Problem,
    /// The tractions, three blocks [n | x | y].
    p: &'a [f64],
    /// The displacements A p.
    displacement: &'a [f64],
    /// The diagonal entries of A.
    diagonals: Diagonals,
}

/// The sizes that residuals are measured in, in the problem's units.
struct Sizes {
    /// The largest |p₁|.
    peak: f64,
    /// The largest |u₁ + ε p₁|.
    deepest: f64,
    /// The largest |w_t| of an element under pressure.
    slip: f64,
}

/// The figures and sums over the elements of a band, or over all.
struct Sums {
    /// The largest figures. The residual and the imbalance are not among them: they are of the
    /// whole.
    certificate: Certificate,
    /// The sums of tractions and of their moments.
    force: PerDof<f64>,
    /// The sum over the elements of the largest |component|.
    magnitude: f64,
    /// The sum over the elements of the larger tangential |component|.
    pull: f64,
    /// The squares of all components.
    all: Squares,
    /// The squares of the tangential components.
    tangential: Squares,
    /// The squares of the tangential components where the pressure itself bounds friction, and not
    /// its image, in a scene that rolls.
    under_pressure: Squares,
}

/// The sums of squares of tractions and of their images under the natural map.
#[derive(Clone, Copy)]
struct Squares {
    /// The largest |component| of tractions and of their images.
    unit: f64,
    /// The sum of squares of the natural map's defect, in units of `unit`.
    defect: f64,
    /// The sum of squares of the tractions, in units of `unit`.
    size: f64,
    /// The sum of squares of the images, in units of `unit`.
    image: f64,
}

/// Certifies tractions `p` (three blocks [n | x | y]) against `problem`, both in the problem's
/// units. `displacement` is A p and `diagonal` the diagonal entries of A, or those of the operator
/// of steady rolling, on all of Ω and without mirror planes. `claimed` are the observables \[SI\]
/// that go out with `p`, and `target` the controls that were to govern the punch \[SI\].
pub fn certify(
    problem: &Problem,
    p: &[f64],
    displacement: &[f64],
    diagonal: impl Into<Diagonals>,
    claimed: &Observables,
    target: &PerDof<Control>,
) -> Certificate {
    let claim = Claim { problem, p, displacement, diagonals: diagonal.into() };
    let sizes = claim.sizes();
    let bands = parallel::bands(problem.grid.len(), |band| claim.band(&sizes, band));
    let sums = Sums::over(bands);
    let force_imbalance = force_imbalance(problem, sizes.peak, &sums, claimed, target);
    Certificate { residual: sums.residual(problem.past), force_imbalance, ..sums.certificate }
}

impl Claim<'_> {
    /// Returns component `c` of w of equation (3) on an element: the gap or the slip that the
    /// regularised law sees.
    fn w(&self, e: usize, c: usize) -> f64 {
        let Self { problem, p, displacement, .. } = self;
        let k = problem.grid.len();
        displacement[c * k + e] + problem.epsilon * p[c * k + e] - problem.f[c * k + e]
    }

    /// Returns the sizes that residuals are measured in.
    fn sizes(&self) -> Sizes {
        let Self { problem, p, displacement, .. } = self;
        let largest_of = |value: &(dyn Fn(usize) -> f64 + Sync)| {
            let of_band = |band| largest(problem.grid.active_in(band).map(value));
            largest(parallel::bands(problem.grid.len(), of_band).into_iter())
        };
        Sizes {
            peak: largest_of(&|e| p[e].abs()),
            deepest: largest_of(&|e| (displacement[e] + problem.epsilon * p[e]).abs())
                .max(f64::MIN_POSITIVE),
            slip: largest_of(&|e| if p[e] > 0.0 { self.w(e, 1).hypot(self.w(e, 2)) } else { 0.0 }),
        }
    }

    /// Returns the figures and sums of a band of elements.
    fn band(&self, sizes: &Sizes, band: Range<usize>) -> Sums {
        let Self { problem, p, .. } = self;
        let k = problem.grid.len();
        let mut certificate = Certificate::default();
        // Tractions are kept with their images to be measured in units of the largest, because
        // squares leave the range of doubles early.
        let mut images: Vec<[[f64; 3]; 2]> = Vec::with_capacity(band.len());
        let mut under_pressure: Vec<[[f64; 3]; 2]> = Vec::new();
        let (mut force, mut magnitude, mut pull) = (PerDof::all(0.0), 0.0, 0.0);
        for e in problem.grid.active_in(band) {
            let tractions = [p[e], p[k + e], p[2 * k + e]];
            let w = [self.w(e, 0), self.w(e, 1), self.w(e, 2)];
            images.push([tractions, self.image(tractions, w, None)]);
            if problem.past.is_some() {
                under_pressure.push([tractions, self.image(tractions, w, Some(p[e]))]);
            }
            self.measure(&mut certificate, sizes, tractions, w);
            let [pressure, px, py] = tractions;
            let [x, y] = problem.grid.center(e);
            for (total, term) in force.iter_mut().zip([
                pressure,
                px,
                py,
                y * pressure,
                -(x * pressure),
                x * py - y * px,
            ]) {
                *total += term;
            }
            magnitude += pressure.abs().max(px.abs()).max(py.abs());
            pull += px.abs().max(py.abs());
        }
        let [all, tangential] = [0, 1].map(|first| Squares::of(&images, first));
        let under_pressure = Squares::of(&under_pressure, 1);
        Sums { certificate, force, magnitude, pull, all, tangential, under_pressure }
    }

    /// Returns the natural map of an element's tractions, written as a nearest point of the
    /// truncated cone's section rather than as G. Friction is bounded by the image of the pressure,
    /// or by a pressure that is given.
    fn image(
        &self,
        [pressure, px, py]: [f64; 3],
        [gap, slip_x, slip_y]: [f64; 3],
        bound: Option<f64>,
    ) -> [f64; 3] {
        let Self { problem, diagonals: Diagonals { normal, tangential }, .. } = self;
        let (mu, ceiling) = (problem.mu, problem.ceiling);
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
        let radius = mu * bound.map_or(allowed, |bound| bound.max(0.0).min(ceiling));
        let trial_traction = trial.1.hypot(trial.2);
        let shrink = if trial_traction > radius { radius / trial_traction } else { 1.0 };
        [allowed, trial.1 * shrink, trial.2 * shrink]
    }

    /// Raises the figures of `certificate` to those of an element.
    fn measure(
        &self,
        certificate: &mut Certificate,
        Sizes { peak, deepest, slip: largest_slip }: &Sizes,
        [pressure, px, py]: [f64; 3],
        [gap, slip_x, slip_y]: [f64; 3],
    ) {
        let mu = self.problem.mu;
        let traction = px.hypot(py);
        certificate.tension = certificate.tension.max(relative((-pressure).max(0.0), *peak));
        // At the ceiling the law (3) lets the bodies overlap.
        if pressure < self.problem.ceiling {
            certificate.penetration =
                certificate.penetration.max(relative((-gap).max(0.0), *deepest));
        }
        certificate.gap_under_pressure =
            certificate.gap_under_pressure.max(relative((gap * pressure).max(0.0), peak * deepest));
        certificate.cone_violation =
            certificate.cone_violation.max(relative((traction - mu * pressure).max(0.0), *peak));
        let slip = slip_x.hypot(slip_y);
        if pressure > 0.0 && slip > 1e-3 * largest_slip && traction > 1e-6 * mu * peak {
            let against = -(slip_x * px + slip_y * py);
            let across = slip_x * py - slip_y * px;
            // Sticking elements do not slip beyond the residual; where slip is real, traction must
            // oppose it.
            if traction >= mu * pressure * (1.0 - 1e-6) {
                certificate.slip_angle = certificate.slip_angle.max(across.abs().atan2(against));
            }
        }
    }
}

impl Squares {
    /// Sums the squares of tractions and their images, of the components from the `first` on.
    fn of(images: &[[[f64; 3]; 2]], first: usize) -> Self {
        let unit = largest(
            images.iter().flatten().flat_map(|components| &components[first..]).map(|t| t.abs()),
        );
        let square = |a: f64, b: f64| if unit == 0.0 { 0.0 } else { ((a - b) / unit).powi(2) };
        let sum = |square: &dyn Fn(f64, f64) -> f64| {
            images
                .iter()
                .flat_map(|[tractions, image]| tractions[first..].iter().zip(&image[first..]))
                .map(|(a, b)| square(*a, *b))
                .sum()
        };
        Self {
            unit,
            defect: sum(&square),
            size: sum(&|traction, _| square(traction, 0.0)),
            image: sum(&|_, image| square(image, 0.0)),
        }
    }

    /// Adds up those of bands, in order.
    fn over(bands: impl Iterator<Item = Self> + Clone) -> Self {
        let unit = largest(bands.clone().map(|band| band.unit));
        let mut total = Self { unit, defect: 0.0, size: 0.0, image: 0.0 };
        for band in bands {
            let ratio = if band.unit == 0.0 { 0.0 } else { (band.unit / unit).powi(2) };
            total.defect += band.defect * ratio;
            total.size += band.size * ratio;
            total.image += band.image * ratio;
        }
        total
    }

    /// Returns the root of the defect's square over that of a size, in units of `unit`.
    fn residual(&self, size: f64) -> f64 {
        if self.unit == 0.0 {
            return 0.0;
        }
        // A quotient 0/0 comes of tractions that are no numbers.
        let residual = (self.defect / size).sqrt();
        if residual.is_nan() { f64::INFINITY } else { residual }
    }
}

impl Sums {
    /// Adds up the bands, in order.
    fn over(bands: Vec<Sums>) -> Self {
        let mut total = Self {
            certificate: Certificate::default(),
            force: PerDof::all(0.0),
            magnitude: 0.0,
            pull: 0.0,
            all: Squares::over(bands.iter().map(|band| band.all)),
            tangential: Squares::over(bands.iter().map(|band| band.tangential)),
            under_pressure: Squares::over(bands.iter().map(|band| band.under_pressure)),
        };
        for band in bands {
            let (most, figures) = (&mut total.certificate, band.certificate);
            most.tension = most.tension.max(figures.tension);
            most.penetration = most.penetration.max(figures.penetration);
            most.gap_under_pressure = most.gap_under_pressure.max(figures.gap_under_pressure);
            most.cone_violation = most.cone_violation.max(figures.cone_violation);
            most.slip_angle = most.slip_angle.max(figures.slip_angle);
            total.force.iter_mut().zip(band.force).for_each(|(total, force)| *total += force);
            total.magnitude += band.magnitude;
            total.pull += band.pull;
        }
        total
    }

    /// Returns the relative residual of the natural map. Where tangential components are measured
    /// for themselves, because the scene rolls, `past` is the least size that they count as. Their
    /// law holds for the image of the pressure or for the pressure itself, which differ by what the
    /// residual of the normal law counts: small tractions would otherwise answer for it.
    fn residual(&self, past: Option<f64>) -> f64 {
        let residual = self.all.residual(self.all.size);
        let Some(past) = past else { return residual };
        let [one, other] = [&self.tangential, &self.under_pressure].map(|squares| {
            let Squares { unit, size, image, .. } = *squares;
            let past = if unit == 0.0 { 0.0 } else { (past / unit).powi(2) };
            squares.residual(larger(larger(size, image), past))
        });
        larger(residual, if other < one { other } else { one })
    }
}

/// Returns the largest difference between the forces and moments that the tractions sum up to and
/// those that are claimed or prescribed, over the sum of their magnitudes. In a scene that rolls,
/// tangential ones are over the sum of tangential magnitudes, or what the increment starts from.
fn force_imbalance(
    problem: &Problem,
    peak: f64,
    sums: &Sums,
    claimed: &Observables,
    target: &PerDof<Control>,
) -> f64 {
    let area = problem.grid.element_area();
    let unit = problem.scale.traction() * problem.scale.length * problem.scale.length * area;
    let magnitude = sums.magnitude * unit;
    let pull = problem.past.map_or(magnitude, |past| sums.pull.max(past) * unit);
    let c = claimed;
    let claims = PerDof::new([c.load, c.force_x, c.force_y, c.moment_x, c.moment_y, c.moment_z]);
    // No digit is certain of forces below the range of doubles.
    let mut imbalance: f64 = if peak > 0.0 && !magnitude.is_normal() { f64::INFINITY } else { 0.0 };
    for dof in Dof::ALL {
        let arm = if dof.is_rotation() { problem.scale.length } else { 1.0 };
        let size = arm * if Dof::TANGENTIAL.contains(&dof) { pull } else { magnitude };
        // The function `max` would pass over what is not a number.
        let difference = |force: f64| relative((force - sums.force[dof] * unit * arm).abs(), size);
        let missed = if let Control::Force(force) = target[dof] { difference(force) } else { 0.0 };
        for difference in [difference(claims[dof]), missed] {
            imbalance = if difference.is_nan() { f64::INFINITY } else { imbalance.max(difference) };
        }
    }
    imbalance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foundation::HalfSpace;
    use crate::influence::{Influence, InfluenceTable, Toeplitz};
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
                let sum = |e: usize| table.displacement_at(e, components, &p);
                transform_error(sum, &grid, components, false, [&p, displacement])
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
        let nothing = [0.0; 162];
        let sum = |e: usize| right.displacement_at(e, Components::ALL, &nothing);
        for apart in [false, true] {
            let error = transform_error(sum, &grid, Components::ALL, apart, [&nothing, &nothing]);
            assert_eq!(error, 0.0);
        }
    }

    /// Tangential displacements that are small next to the normal ones are right only if they are
    /// measured in their own size.
    #[test]
    fn small_components_show_if_they_are_apart() {
        let grid = Grid::new(9, 6, 0.5, 0.75, [0.0; 2]).unwrap();
        let bodies = HalfSpace::new(&Material { shear_modulus: 1.0, poisson: 0.5 }, None);
        let table = InfluenceTable::new(&grid, &bodies, Projection::Average);
        let k = grid.len();
        let p: Vec<f64> = (0..3 * k).map(|i| if i < k { 1.0 } else { 1e-9 }).collect();
        let sum = |e: usize| table.displacement_at(e, Components::ALL, &p);
        let mut displacement = vec![0.0; 3 * k];
        for e in 0..k {
            let [normal, x, y] = sum(e);
            (displacement[e], displacement[k + e]) = (normal, 1.001 * x);
            displacement[2 * k + e] = y;
        }
        let error =
            |apart| transform_error(sum, &grid, Components::ALL, apart, [&p, &displacement]);
        assert!(error(false) < 1e-11 && error(true) > 5e-4, "{} {}", error(false), error(true));
    }
}
