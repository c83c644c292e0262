//! One increment of a path: from what is asked, by way of a solver's iterate, to a certified
//! outcome.

use crate::assess::{certify, fields, observables, states, transform_error};
use crate::common::parallel;
use crate::model::{
    Certificate, Control, Dof, Fields, Motion, Observables, PerDof, Status, Step, StepOutcome,
    WorkDone,
};
use crate::problem::{Operator, Problem};
use crate::solver::{Iterate, Stop};

/// The state that an increment starts from, in SI units.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Departure {
    pub(crate) motion: Motion,
    pub(crate) resultants: PerDof<f64>,
}

/// A certified increment.
pub(crate) struct Increment {
    /// Whether it counts as solved.
    pub(crate) status: Status,
    /// Its figures.
    pub(crate) outcome: StepOutcome,
    pub(crate) fields: Fields,
    /// w = A p − f, the gap and the slip, in the problem's units.
    pub(crate) slip: Vec<f64>,
}

/// The controls in the problem's units.
pub(crate) fn in_units(asked: &PerDof<Control>, problem: &Problem) -> PerDof<Control> {
    let (motions, forces) = (problem.scale.motions(), problem.scale.forces());
    PerDof::from_fn(|dof| match asked[dof] {
        Control::Motion(value) => Control::Motion(value / motions[dof]),
        Control::Force(value) => Control::Force(value / forces[dof]),
    })
}

/// Certifies an iterate with `operator`, which has no mirror planes, against `asked` \[SI\] too,
/// and derives what goes out: whether it counts as solved, its figures, its fields and w = A p − f.
pub(crate) fn certify_increment(
    problem: &Problem,
    operator: &Operator,
    iterate: &Iterate,
    asked: &PerDof<Control>,
    departure: &Departure,
    tolerance: f64,
) -> Increment {
    let p = &iterate.p;
    let diagonal = operator.table.diagonals();
    // what the operator has no components for does not move against the punch
    let mut displacement = problem.f.clone();
    let acting = operator.influence.components().len() * problem.grid.len();
    operator.apply(&mut displacement[..acting], &p[..acting], &mut operator.scratch());
    let k = problem.grid.len();
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
    let (now, was) = (motion.per_dof(), departure.motion.per_dof());
    let (forces, forces_before) = (observables.resultants(), departure.resultants);
    observables.external_work = Dof::ALL
        .into_iter()
        .map(|dof| 0.5 * (forces[dof] + forces_before[dof]) * (now[dof] - was[dof]))
        .sum();
    let mut certificate = certify(problem, p, &displacement, diagonal, &observables, asked);
    let components = operator.influence.components();
    let unsure = transform_error(
        &operator.table,
        &problem.grid,
        components,
        &p[..acting],
        &displacement[..acting],
    );
    certificate.residual = certificate.residual.max(unsure);
    let status = if iterate.stop.is_solution() && certificate.meets(tolerance) {
        Status::Certified
    } else {
        Status::Failed {
            reason: failure(problem.mu, iterate, asked, &observables, &certificate, tolerance),
        }
    };
    let outcome = StepOutcome {
        motion,
        observables,
        certificate,
        work: work(iterate),
        route: iterate.way,
        ..StepOutcome::default()
    };
    Increment { status, outcome, fields: fields(problem, p, &w, &states), slip: w }
}

/// Why an iterate is no solution, in words with figures.
fn failure(
    mu: f64,
    iterate: &Iterate,
    asked: &PerDof<Control>,
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
            let (Control::Force(asked) | Control::Motion(asked)) = asked[dof];
            let Observables { load, force_x, force_y, .. } = observables;
            return format!(
                "gross sliding: the contact cannot carry {} = {asked:.6e}; friction carries at most μP = {:.6e} N (where it was given up: P = {load:.6e}, Qx = {force_x:.6e}, Qy = {force_y:.6e} N)",
                name(dof),
                mu * load
            );
        }
        Stop::Unbalanced { dof } => {
            let (Control::Force(asked) | Control::Motion(asked)) = asked[dof];
            return format!(
                "no pressure under the sole has {} = {asked:.6e} N m: its line of action passes the sole by",
                name(dof)
            );
        }
        Stop::OneRow { dof } => {
            let (Control::Force(asked) | Control::Motion(asked)) = asked[dof];
            let [tilt, moment] = Step::NAMES[dof];
            return format!(
                "{moment} = {asked:.6e} N m governs {tilt}, which moves nothing in the middle of a single row of elements: prescribe {tilt}, or take at least two rows"
            );
        }
    };
    // what the contact does not carry, most of all, where everything else is right
    let solved = [certificate.residual, certificate.tension, certificate.cone_violation]
        .iter()
        .all(|figure| *figure <= tolerance);
    let reached = observables.resultants();
    let missed = Dof::ALL.into_iter().filter_map(|dof| match asked[dof] {
        Control::Force(asked) if asked != reached[dof] => {
            Some((dof, asked, (asked - reached[dof]).abs() / asked.abs().max(reached[dof].abs())))
        }
        _ => None,
    });
    let difficulty = match missed.max_by(|a, b| a.2.total_cmp(&b.2)).filter(|_| solved) {
        Some((dof, asked, _)) if observables.contact_elements == 0 => {
            format!(
                ": where the punch was moved to nothing touches, and nothing carries {} = {asked:.6e} {}",
                name(dof),
                unit(dof)
            )
        }
        Some((dof, asked, _)) => format!(
            ": no motion of the punch was found at which the contact carries {} = {asked:.6e} {}; at the nearest it carries {:.6e}",
            name(dof),
            unit(dof),
            reached[dof]
        ),
        None => String::new(),
    };
    format!(
        "{stop}{difficulty}; the certificate has residual {:.1e}, tension {:.1e}, cone violation {:.1e}, force imbalance {:.1e} where {tolerance:.1e} was asked",
        certificate.residual,
        certificate.tension,
        certificate.cone_violation,
        certificate.force_imbalance
    )
}

pub(super) fn work(iterate: &Iterate) -> WorkDone {
    WorkDone {
        iterations: iterate.iterations,
        operator_applications: iterate.operator_applications,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Way;

    #[test]
    fn a_failure_names_the_force_that_is_not_carried() {
        let iterate = Iterate {
            p: Vec::new(),
            motion: PerDof::all(0.0),
            stop: Stop::Stalled { residual: 0.2 },
            iterations: 17,
            operator_applications: 0,
            way: Way::Newton,
        };
        let mut asked = PerDof::all(Control::Motion(0.0));
        (asked[Dof::Approach], asked[Dof::ShiftX], asked[Dof::TiltY]) =
            (Control::Force(2.0), Control::Force(0.5), Control::Force(-0.25));
        let observables = Observables {
            load: 2.0,
            force_x: 0.5,
            moment_y: -0.2,
            contact_elements: 9,
            ..Observables::default()
        };
        let say = |observables: &Observables, certificate: &Certificate| {
            failure(0.3, &iterate, &asked, observables, certificate, 1e-8)
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
        // where more is wrong than that, it is not the difficulty
        let unsolved = say(&observables, &Certificate { residual: 1e-3, ..unbalanced });
        assert!(
            unsolved.starts_with(
                "stalled after 17 iterations (smallest residual 2.0e-1); the certificate"
            ),
            "{unsolved}"
        );
    }
}
