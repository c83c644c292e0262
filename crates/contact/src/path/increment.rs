//! One increment of a path: from the controls, by way of a solver's iterate, to a certified
//! outcome.

use crate::assess::{
    AheadSums, certify, elastic_energy, fields, observables, states, transform_error,
};
use crate::common::parallel;
use crate::influence::{Components, Direction};
use crate::model::{
    Certificate, Control, Dof, Fields, Motion, Observables, PerDof, Status, Step, StepOutcome,
    WorkDone,
};
use crate::problem::{Operator, Problem};
use crate::solver::{Iterate, Stop};

/// The state that an increment starts from, in SI units.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Departure {
    /// The motion of the punch.
    pub(crate) motion: Motion,
    /// The forces \[N\] and moments \[N m\] of the punch on the foundation.
    pub(crate) resultants: PerDof<f64>,
}

/// A certified increment.
pub(crate) struct Increment {
    /// Says whether the increment counts as solved.
    pub(crate) status: Status,
    /// The figures of the increment, in SI units.
    pub(crate) outcome: StepOutcome,
    /// The fields at its end, in SI units.
    pub(crate) fields: Fields,
    /// The displacements (εI + A) p, in the problem's units, three blocks [n | x | y].
    pub(crate) left: Vec<f64>,
    /// The differences w = A p − f, in the problem's units, three blocks [n | x | y].
    pub(crate) w: Vec<f64>,
}

/// The means that certify an increment. Their operators know no mirror planes.
pub(crate) struct Certifying<'a> {
    /// The operator A.
    pub(crate) elastic: &'a Operator,
    /// The operator of an increment that rolls steadily, and sums for the distance.
    pub(crate) steady: Option<(&'a Operator, &'a mut AheadSums)>,
    /// The relative error of the displacements that the material has had, if it comes from ahead.
    pub(crate) history: f64,
}

/// Converts controls from SI units to the problem's units.
pub(crate) fn in_units(target: &PerDof<Control>, problem: &Problem) -> PerDof<Control> {
    let (motions, forces) = (problem.scale.motions(), problem.scale.forces());
    PerDof::from_fn(|dof| match target[dof] {
        Control::Motion(value) => Control::Motion(value / motions[dof]),
        Control::Force(value) => Control::Force(value / forces[dof]),
    })
}

/// Certifies an iterate, also against `target` \[SI\], and derives the results: the status, the
/// figures, the fields and the displacements.
pub(crate) fn certify_increment(
    problem: &Problem,
    Certifying { elastic, steady, history }: Certifying<'_>,
    iterate: &Iterate,
    target: &PerDof<Control>,
    departure: &Departure,
    tolerance: f64,
) -> Increment {
    let p = &iterate.p;
    let components = elastic.influence.components();
    let acting = components.len() * problem.grid.len();
    let mut transform = history;
    let mut apply = |operator: &Operator| {
        // A component that the operator does not have does not move against the punch.
        let mut displacement = problem.f.clone();
        operator.apply(&mut displacement[..acting], &p[..acting], &mut operator.scratch());
        let sum = |e: usize| operator.displacement_at(e, &p[..acting]);
        let (apart, fields) = (problem.past.is_some(), [&p[..acting], &displacement[..acting]]);
        let error = transform_error(sum, &problem.grid, components, apart, fields);
        transform = f64::max(transform, error);
        displacement
    };
    let still = apply(elastic);
    let rolled = steady.as_ref().map(|(steady, _)| apply(steady));
    let displacement = rolled.as_ref().unwrap_or(&still);
    let diagonal = steady.as_ref().map_or(elastic, |(steady, _)| steady).diagonals();
    let k = problem.grid.len();
    let is_steady = steady.is_some();
    if let (Some((_, sums)), Some(rolled)) = (steady, &rolled) {
        let ahead: Vec<f64> =
            still.iter().zip(rolled).map(|(still, rolled)| still - rolled).collect();
        let unit = largest_tangential(problem, components, rolled);
        let fields = [&p[..acting], &ahead[..acting]];
        transform = f64::max(transform, sums.error(&problem.grid, components, fields, unit));
    }
    let mut w = vec![0.0; p.len()];
    let nx = problem.grid.nx();
    parallel::rows(&mut w, nx, |row, w| {
        let (first, of_field) = ((row * nx) % k, row * nx);
        for (i, w) in w.iter_mut().enumerate().filter(|(i, _)| problem.grid.is_active(first + i)) {
            *w = displacement[of_field + i] - problem.f[of_field + i];
        }
    });
    let states = states(problem, p, &w, diagonal);
    let mut observables = observables(problem, p, &w, &states);
    let units = problem.scale.motions();
    let motion = Motion::from_per_dof(PerDof::from_fn(|dof| iterate.motion[dof] * units[dof]));
    let (motions, motions_before) = (motion.per_dof(), departure.motion.per_dof());
    let (forces, mut forces_before) = (observables.resultants(), departure.resultants);
    if is_steady {
        observables.energy = elastic_energy(problem, p, |row| still[row]);
        Dof::TANGENTIAL.into_iter().for_each(|dof| forces_before[dof] = forces[dof]);
    }
    observables.external_work = Dof::ALL
        .into_iter()
        .map(|dof| 0.5 * (forces[dof] + forces_before[dof]) * (motions[dof] - motions_before[dof]))
        .sum();
    let mut certificate = certify(problem, p, displacement, diagonal, &observables, target);
    certificate.residual = certificate.residual.max(transform);
    let status = if iterate.stop.is_solution() && certificate.meets(tolerance) {
        Status::Certified
    } else {
        Status::Failed {
            reason: failure(problem.mu, iterate, target, &observables, &certificate, tolerance),
        }
    };
    let outcome = StepOutcome {
        motion,
        observables,
        certificate,
        work: work(iterate),
        route: iterate.route,
        ..StepOutcome::default()
    };
    let fields = fields(problem, p, &w, &states);
    // What rolls has no ε, and its w is not of A.
    let left = if rolled.is_some() {
        still
    } else {
        let row = |((p, w), f): ((&f64, &f64), &f64)| problem.epsilon * p + w + f;
        p.iter().zip(&w).zip(&problem.f).map(row).collect()
    };
    Increment { status, outcome, fields, left, w }
}

/// Returns the largest tangential component of a field on Ω, blocks of `components`.
pub(crate) fn largest_tangential(problem: &Problem, components: Components, field: &[f64]) -> f64 {
    components
        .directions()
        .zip(field.chunks_exact(problem.grid.len()))
        .filter(|(direction, _)| *direction != Direction::N)
        .flat_map(|(_, block)| problem.grid.active().map(move |element| block[element]))
        .fold(0.0, |largest: f64, value| largest.max(value.abs()))
}

/// Says why an iterate is no solution, in words with figures.
fn failure(
    mu: f64,
    iterate: &Iterate,
    target: &PerDof<Control>,
    observables: &Observables,
    certificate: &Certificate,
    tolerance: f64,
) -> String {
    let iterations = iterate.iterations;
    let unit = |dof: Dof| if dof.is_rotation() { "N m" } else { "N" };
    let name = |dof: Dof| Step::NAMES[dof][1];
    let stop = match iterate.stop {
        Stop::Converged => "the solver took it for converged".to_owned(),
        Stop::OutOfIterations { residual } => {
            format!("not converged in {iterations} iterations (residual {residual:.1e})")
        }
        Stop::Stalled { residual } => {
            format!("stalled after {iterations} iterations (smallest residual {residual:.1e})")
        }
        Stop::Diverged => format!("diverged after {iterations} iterations"),
        Stop::Slides { dof } => {
            let (Control::Force(value) | Control::Motion(value)) = target[dof];
            let Observables { load, force_x, force_y, .. } = observables;
            return format!(
                "gross sliding: the contact cannot carry {} = {value:.6e}; friction carries at \
                 most μP = {:.6e} N (where it was given up: P = {load:.6e}, Qx = {force_x:.6e}, \
                 Qy = {force_y:.6e} N)",
                name(dof),
                mu * load
            );
        }
        Stop::Unbalanced { dof } => {
            let (Control::Force(value) | Control::Motion(value)) = target[dof];
            return format!(
                "no pressure under the sole has {} = {value:.6e} N m: its line of action passes \
                 the sole by",
                name(dof)
            );
        }
        Stop::OneRow { dof } => {
            let (Control::Force(value) | Control::Motion(value)) = target[dof];
            let [tilt, moment] = Step::NAMES[dof];
            return format!(
                "{moment} = {value:.6e} N m governs {tilt}, which moves nothing in the middle of a \
                 single row of elements: prescribe {tilt}, or take at least two rows"
            );
        }
    };
    // Where everything else is right, the difficulty is the force that the contact misses most.
    let solved = [certificate.residual, certificate.tension, certificate.cone_violation]
        .iter()
        .all(|figure| *figure <= tolerance);
    let reached = observables.resultants();
    let missed = Dof::ALL.into_iter().filter_map(|dof| match target[dof] {
        Control::Force(force) if force != reached[dof] => {
            let miss = (force - reached[dof]).abs() / force.abs().max(reached[dof].abs());
            Some((dof, force, miss))
        }
        _ => None,
    });
    let difficulty = match missed.max_by(|a, b| a.2.total_cmp(&b.2)).filter(|_| solved) {
        Some((dof, force, _)) if observables.contact_elements == 0 => {
            format!(
                ": where the punch was moved to nothing touches, and nothing carries {} = \
                 {force:.6e} {}",
                name(dof),
                unit(dof)
            )
        }
        Some((dof, force, _)) => format!(
            ": no motion of the punch was found at which the contact carries {} = {force:.6e} {}; \
             at the nearest it carries {:.6e}",
            name(dof),
            unit(dof),
            reached[dof]
        ),
        None => String::new(),
    };
    format!(
        "{stop}{difficulty}; the certificate has residual {:.1e}, tension {:.1e}, cone violation \
         {:.1e}, force imbalance {:.1e} where {tolerance:.1e} was asked",
        certificate.residual,
        certificate.tension,
        certificate.cone_violation,
        certificate.force_imbalance
    )
}

/// Returns the work of an iterate.
fn work(iterate: &Iterate) -> WorkDone {
    WorkDone {
        iterations: iterate.iterations,
        operator_applications: iterate.operator_applications,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Numerics, Route, Shape, sphere_on_half_space};
    use crate::punch::Surfaces;

    /// The surface outside a disk is no part of the scale of the displacements under it.
    #[test]
    fn the_largest_component_is_one_on_the_sole() {
        let mut scene = sphere_on_half_space();
        scene.punch.shape = Shape::FlatDisk { radius: 1e-3 };
        let numerics: Numerics = serde_json::from_str(r#"{"mesh": 8}"#).unwrap();
        let problem = Problem::new(&scene, &numerics, &Surfaces::new()).unwrap();
        let k = problem.grid.len();
        let inside = problem.grid.active().next().unwrap();
        assert!(!problem.grid.is_active(0), "the corner lies outside");
        let mut field = vec![0.0; 3 * k];
        (field[inside], field[k], field[k + inside], field[2 * k + inside]) = (9.0, 7.0, 2.0, -3.0);
        assert_eq!(largest_tangential(&problem, Components::ALL, &field), 3.0);
        assert_eq!(largest_tangential(&problem, Components::NORMAL, &field[..k]), 0.0);
    }

    #[test]
    fn a_failure_names_the_force_that_is_not_carried() {
        let iterate = Iterate {
            p: Vec::new(),
            motion: PerDof::all(0.0),
            stop: Stop::Stalled { residual: 0.2 },
            iterations: 17,
            operator_applications: 0,
            route: Route::Newton,
        };
        let mut controls = PerDof::all(Control::Motion(0.0));
        (controls[Dof::Approach], controls[Dof::ShiftX], controls[Dof::TiltY]) =
            (Control::Force(2.0), Control::Force(0.5), Control::Force(-0.25));
        let observables = Observables {
            load: 2.0,
            force_x: 0.5,
            moment_y: -0.2,
            contact_elements: 9,
            ..Observables::default()
        };
        let say = |observables: &Observables, certificate: &Certificate| {
            failure(0.3, &iterate, &controls, observables, certificate, 1e-8)
        };
        let unbalanced = Certificate { force_imbalance: 0.1, ..Certificate::default() };
        assert_eq!(
            say(&observables, &unbalanced),
            "stalled after 17 iterations (smallest residual 2.0e-1): no motion of the punch was found at which the contact carries \
             moment_y = -2.500000e-1 N m; at the nearest it carries -2.000000e-1; the certificate has residual 0.0e0, tension 0.0e0, \
             cone violation 0.0e0, force imbalance 1.0e-1 where 1.0e-8 was asked"
        );
        let apart = say(&Observables::default(), &unbalanced);
        assert!(
            apart.contains("nothing touches, and nothing carries moment_y = -2.500000e-1 N m;"),
            "{apart}"
        );
        // Where more is wrong than that, it is not the difficulty.
        let unsolved = say(&observables, &Certificate { residual: 1e-3, ..unbalanced });
        assert!(
            unsolved.starts_with(
                "stalled after 17 iterations (smallest residual 2.0e-1); the certificate"
            ),
            "{unsolved}"
        );
    }
}
