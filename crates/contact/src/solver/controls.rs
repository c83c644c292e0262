//! The controls of the punch: the forces that cannot be, the distance of an iterate from the
//! prescribed ones, and an approach to begin with.

use super::iterate::{Iterate, Stop};
use crate::influence::images;
use crate::model::{Control, Dof, PerDof, rigid_displacement};
use crate::problem::Problem;

/// Returns the degrees of freedom that a force governs.
pub(super) fn governed(controls: &PerDof<Control>) -> Vec<Dof> {
    Dof::ALL.into_iter().filter(|dof| matches!(controls[*dof], Control::Force(_))).collect()
}

/// Returns the value that a control prescribes.
pub(super) fn target(control: Control) -> f64 {
    match control {
        Control::Force(value) | Control::Motion(value) => value,
    }
}

/// Checks controls that no contact can satisfy: a tangential force beyond the friction limit (|Q| ≥
/// μP, gross sliding), a resultant whose line of action passes the sole by, or a moment about a
/// single row of elements, which leaves the tilt undetermined.
pub(super) fn impossible(problem: &Problem, controls: &PerDof<Control>) -> Option<Stop> {
    let force = |dof: Dof| if let Control::Force(force) = controls[dof] { force } else { 0.0 };
    if let Some(dof) =
        Dof::TANGENTIAL.into_iter().find(|dof| problem.mu == 0.0 && force(*dof) != 0.0)
    {
        return Some(Stop::Slides { dof });
    }
    let centers = || problem.grid.active().map(|e| problem.grid.center(e));
    // The coordinate along x or y that all centres have in common, if they do.
    let row = |axis: usize| {
        let first = centers().next()?[axis];
        centers().all(|center| center[axis] == first).then_some(first)
    };
    let is_governed = |dof: Dof| matches!(controls[dof], Control::Force(_));
    // Centres with the same x lie in a row along y, and a tilt about y moves none of them.
    let one_row = [0, 1]
        .into_iter()
        .map(|axis| (Dof::tilt_about(1 - axis), axis))
        .find(|&(dof, axis)| is_governed(dof) && row(axis).is_some());
    let one_row = one_row.map(|(dof, _)| Stop::OneRow { dof });
    let Control::Force(normal) = controls[Dof::Approach] else { return one_row };
    if let Some(dof) = beyond_friction(problem.mu * normal, Dof::SHIFTS.map(force)) {
        return Some(Stop::Slides { dof });
    }
    // The points Σ x p₁ and Σ y p₁ over Σ p₁ lie in the convex hull of the elements' centres.
    let arm = |dof: Dof, sign: f64| {
        if let Control::Force(moment) = controls[dof] { Some(sign * moment / normal) } else { None }
    };
    let (x, y) = (arm(Dof::TiltY, -1.0), arm(Dof::TiltX, 1.0));
    let beside = |place: Option<f64>, axis: usize| {
        place.zip(row(axis)).is_some_and(|(place, row)| {
            (place - row).abs() > 1e-9 * [problem.grid.hx(), problem.grid.hy()][axis]
        })
    };
    if let Some(stop) = one_row
        && !beside(x, 0)
        && !beside(y, 1)
    {
        return Some(stop);
    }
    let reaches = |direction: [f64; 2], arm: f64| {
        centers().map(|[x, y]| x * direction[0] + y * direction[1]).fold(f64::MIN, f64::max) > arm
    };
    let directions: Vec<[f64; 2]> = match (x, y) {
        (None, None) => Vec::new(),
        (Some(_), None) => vec![[1.0, 0.0], [-1.0, 0.0]],
        (None, Some(_)) => vec![[0.0, 1.0], [0.0, -1.0]],
        (Some(_), Some(_)) => (0..64)
            .map(|i| (f64::from(i) * std::f64::consts::TAU / 64.0).sin_cos().into())
            .collect(),
    };
    let (x, y) = (x.unwrap_or(0.0), y.unwrap_or(0.0));
    let passes_by = directions.into_iter().any(|d| !reaches(d, x * d[0] + y * d[1]));
    passes_by.then_some(Stop::Unbalanced {
        dof: if x.abs() >= y.abs() { Dof::TiltY } else { Dof::TiltX },
    })
}

/// Returns the larger component of a tangential force that is not below `bound`.
fn beyond_friction(bound: f64, [x, y]: [f64; 2]) -> Option<Dof> {
    let size = x.hypot(y);
    (size > 0.0 && size >= bound).then_some(if x.abs() >= y.abs() {
        Dof::ShiftX
    } else {
        Dof::ShiftY
    })
}

/// Says why an iterate is no solution. It is sliding if the iterate's pressure shows that friction
/// cannot carry the prescribed force; otherwise it is what the solver said.
pub(super) fn explain(problem: &Problem, controls: &PerDof<Control>, iterate: &Iterate) -> Stop {
    let force = |dof: Dof| if let Control::Force(force) = controls[dof] { force } else { 0.0 };
    let normal = problem.resultants(&iterate.p)[Dof::Approach];
    let touches = problem.grid.active().any(|e| iterate.p[e] > 0.0 || problem.f[e] > 0.0);
    // A tilt that a moment governs could still bring them together.
    let settled = [Dof::Approach, Dof::TiltX, Dof::TiltY]
        .iter()
        .all(|dof| matches!(controls[*dof], Control::Motion(_)));
    if !touches
        && settled
        && let Some(dof) = Dof::TANGENTIAL.into_iter().find(|dof| force(*dof) != 0.0)
    {
        return Stop::Slides { dof };
    }
    if normal > 0.0 && normal.is_finite() {
        if let Some(dof) = beyond_friction(problem.mu * normal, Dof::SHIFTS.map(force)) {
            return Stop::Slides { dof };
        }
        // About any centre the tractions μp₁ across the radius have the moment Σ μ p₁ r, which is
        // least about the centre of pressure, nearly.
        let resultants = problem.resultants(&iterate.p);
        let center = [-resultants[Dof::TiltY] / normal, resultants[Dof::TiltX] / normal];
        let arm = |[x, y]: [f64; 2]| (x - center[0]).hypot(y - center[1]);
        let carried: f64 = problem
            .grid
            .active()
            .map(|e| iterate.p[e].max(0.0) * arm(problem.grid.center(e)))
            .sum::<f64>()
            * problem.grid.element_area()
            * problem.mu;
        if force(Dof::Twist).abs() >= carried && force(Dof::Twist) != 0.0 {
            return Stop::Slides { dof: Dof::Twist };
        }
    }
    iterate.stop
}

/// Returns the differences between the `targets` and the resultants of `p` for the `governed`
/// degrees of freedom, over Σ|p||e| (moments in units of ℓ). In a scene that rolls, tangential
/// forces and the twisting moment are measured in the tangential tractions, or in what the
/// increment starts from.
pub(super) fn imbalances(
    problem: &Problem,
    p: &[f64],
    targets: &PerDof<f64>,
    governed: &[Dof],
) -> Vec<f64> {
    if governed.is_empty() {
        return Vec::new();
    }
    let resultants = problem.resultants(p);
    let sum = |first: usize| {
        let largest = |e: usize| {
            let traction = problem.traction(p, e);
            traction[first..].iter().fold(0.0, |a: f64, b| a.max(b.abs()))
        };
        problem.grid.active().map(largest).sum::<f64>()
    };
    let unit = problem.grid.element_area() * images(&problem.mirror);
    let size = sum(0) * unit;
    let tangential = problem.past.map_or(size, |past| sum(1).max(past) * unit);
    // Nothing is in balance with nothing.
    let relative = |dof: Dof, difference: f64| {
        let size = if Dof::TANGENTIAL.contains(&dof) { tangential } else { size };
        if difference == 0.0 { 0.0 } else { difference / size }
    };
    governed.iter().map(|&dof| relative(dof, (resultants[dof] - targets[dof]).abs())).collect()
}

/// Returns an approach at which springs under each element, as stiff together as a half-space under
/// their area, carry the load.
pub(super) fn first_approach(problem: &Problem, motion: &PerDof<f64>, load: f64) -> f64 {
    let mut rigid = *motion;
    rigid[Dof::Approach] = 0.0;
    let heights: Vec<f64> = problem
        .grid
        .active()
        .map(|e| {
            let [x, y] = problem.grid.center(e);
            problem.unmoved(e) + rigid_displacement(x, y, &rigid)[0]
        })
        .collect();
    let area = problem.grid.element_area() * images(&problem.mirror);
    let carried = |approach: f64| {
        let (mut sum, mut count) = (0.0, 0.0);
        for height in heights.iter().filter(|height| **height + approach > 0.0) {
            sum += height + approach;
            count += 1.0;
        }
        // A flat disk carries 2E*aδ on πa², with E* = 2/c: a mean pressure of 4δ/πac.
        if count == 0.0 {
            0.0
        } else {
            4.0 * sum * area / (std::f64::consts::PI * count * area).sqrt()
        }
    };
    let top = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // The approach that one element alone needs is nearly enough.
    let mut step = load * (std::f64::consts::PI * area).sqrt() / (4.0 * area);
    while carried(-top + step) < load && step < f64::MAX / 4.0 {
        step *= 2.0;
    }
    let (mut low, mut high) = (-top, -top + step);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if carried(middle) < load { low = middle } else { high = middle }
    }
    high
}
