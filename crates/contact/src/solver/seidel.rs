//! Alexandrov's nonlinear Seidel iteration, the project's reference solver.
//!
//! It goes element by element: α, β, γ solve the element's three rows of (εI + A)p = f with the
//! newest values of all others; then p₁ = h_u(α), and (p₂, p₃) is (β, γ) projected onto the disk of
//! radius μ p₁. The source divides β and γ by their own diagonals. Where hx ≠ hy those differ, and
//! the fixed point would not have slip opposite to traction, against Coulomb's law. One scalar for
//! both rows, the larger, keeps the fixed point exact.
//!
//! The displacements of all elements are kept up to date as tractions change, so that an element
//! that is open and stays open costs nothing. They are summed afresh before convergence is
//! believed. The memory is O(k), a sweep O(k × elements in contact).

use super::iterate::{Iterate, Stop, StopRule};
use crate::influence::InfluenceTable;
use crate::model::{PerDof, Route};
use crate::problem::{Problem, g_mu};

/// The number of sweeps without a new smallest residual after which the iteration counts as
/// stalled. The residual of a convergent run falls in every sweep but for a few while the contact
/// area settles.
const PATIENCE: u64 = 200;

/// Solves `problem`, as it is placed, from the tractions `start` (three blocks [n | x | y] in the
/// problem's units, zero where masked) with the coefficients `table` of its own grid. The motion of
/// the result is zero.
pub fn solve(
    problem: &Problem,
    table: &InfluenceTable,
    start: Vec<f64>,
    rule: &StopRule<'_>,
) -> Iterate {
    let diagonal = table.coefficient(0, 0);
    let diagonals = table.diagonals();
    let normal = diagonal.nn + problem.epsilon;
    let tangential = diagonal.xx.max(diagonal.yy) + problem.epsilon;
    // The certificate measures the same residual along another path of rounding.
    let target = 0.5 * rule.tolerance;

    let elements: Vec<usize> = problem.grid.active().collect();
    let k = problem.grid.len();
    let mut p = start;
    let mut w = displacements(problem, table, &p);
    let mut sweeps = 0;
    let (mut best, mut best_sweep) = (f64::INFINITY, 0);
    let mut applications = 1;
    let stop = loop {
        let mut residual = problem.residual(&p, &w, diagonals);
        if residual <= target {
            w = displacements(problem, table, &p);
            applications += 1;
            residual = problem.residual(&p, &w, diagonals);
            if residual <= target {
                break Stop::Converged;
            }
        }
        if residual.is_nan() {
            break Stop::Diverged;
        }
        if residual < best {
            (best, best_sweep) = (residual, sweeps);
        } else if sweeps - best_sweep > PATIENCE {
            break Stop::Stalled { residual: best };
        }
        if sweeps >= u64::from(rule.max_iterations) || rule.is_cancelled() {
            break Stop::OutOfIterations { residual };
        }
        for &e in elements.iter().take_while(|_| !rule.is_cancelled()) {
            let old = [p[e], p[k + e], p[2 * k + e]];
            let v = [0, 1, 2].map(|c| w[c * k + e] + problem.epsilon * old[c]);
            let new = g_mu(
                [old[0] - v[0] / normal, old[1] - v[1] / tangential, old[2] - v[2] / tangential],
                problem.mu,
                problem.ceiling,
            );
            let change = [new[0] - old[0], new[1] - old[1], new[2] - old[2]];
            if change != [0.0; 3] {
                table.add_column(e, change, &mut w);
                [p[e], p[k + e], p[2 * k + e]] = new;
            }
        }
        sweeps += 1;
        applications += 1;
    };
    Iterate {
        p,
        motion: PerDof::all(0.0),
        stop,
        iterations: sweeps,
        operator_applications: applications,
        route: Route::Seidel,
    }
}

/// Returns w = A p − f, summed column by column.
fn displacements(problem: &Problem, table: &InfluenceTable, p: &[f64]) -> Vec<f64> {
    let k = problem.grid.len();
    let mut w: Vec<f64> = problem.f.iter().map(|f| -f).collect();
    for e in problem.grid.active() {
        let traction = [p[e], p[k + e], p[2 * k + e]];
        if traction != [0.0; 3] {
            table.add_column(e, traction, &mut w);
        }
    }
    w
}
