//! The load, areas, peaks and energies of a solution, and its fields, in SI units.

use std::ops::Range;

use crate::common::parallel;
use crate::influence::Diagonals;
use crate::model::{Fields, Observables, PerDof, State};
use crate::problem::{Problem, h_u};

/// Reads the state of every element off the natural map x = p − E v: an element in contact sticks
/// when the projection onto its friction disk leaves x_t as it is. `p` and `w` = A p − f are three
/// blocks [n | x | y] in the problem's units, `diagonal` the diagonal entries of A. Without
/// friction everything in contact slips.
pub fn states(
    problem: &Problem,
    p: &[f64],
    w: &[f64],
    diagonal: impl Into<Diagonals>,
) -> Vec<State> {
    let diagonal = diagonal.into();
    let k = problem.grid.len();
    let mut states = vec![State::Outside; k];
    parallel::rows(&mut states, problem.grid.nx(), |j, row| {
        let first = problem.grid.index(0, j);
        for (i, state) in
            row.iter_mut().enumerate().filter(|(i, _)| problem.grid.is_active(first + i))
        {
            let e = first + i;
            let x = problem.trial(
                [p[e], p[k + e], p[2 * k + e]],
                [w[e], w[k + e], w[2 * k + e]],
                diagonal,
            );
            *state = if p[e] <= 0.0 {
                State::Open
            } else if x[1].hypot(x[2]) < problem.mu * h_u(x[0], problem.ceiling) {
                State::Stick
            } else {
                State::Slip
            };
        }
    });
    states
}

/// Returns the integral quantities of the tractions `p` with w = A p − f, in SI units. `p` and `w`
/// are three blocks [n | x | y] in the problem's units.
pub fn observables(problem: &Problem, p: &[f64], w: &[f64], states: &[State]) -> Observables {
    let grid = &problem.grid;
    let k = grid.len();
    let length = problem.scale.length;
    let traction = problem.scale.traction();
    let area = grid.element_area() * length * length;
    let mut total = Observables {
        mesh_x: grid.nx() as u64,
        mesh_y: grid.ny() as u64,
        element_x: grid.hx() * length,
        element_y: grid.hy() * length,
        patches: patches([grid.nx(), grid.ny()], |e| {
            matches!(states[e], State::Stick | State::Slip)
        })
        .len() as u64,
        sole_area: grid.active_len() as f64 * area,
        ..Observables::default()
    };
    total.energy = elastic_energy(problem, p, |row| w[row] + problem.f[row]);
    // A band's figures are in the problem's units.
    let of_band = |band: Range<usize>| {
        let mut sums = Observables::default();
        for e in grid.active_in(band) {
            let [pn, px, py] = [p[e], p[k + e], p[2 * k + e]];
            if states[e] == State::Slip {
                sums.dissipation -= px * (problem.epsilon * px + w[k + e])
                    + py * (problem.epsilon * py + w[2 * k + e]);
            }
            sums.largest_gap = sums.largest_gap.max(w[e]);
            sums.peak_pressure = sums.peak_pressure.max(pn);
            sums.peak_traction = sums.peak_traction.max(px.hypot(py));
            sums.ceiling_elements += u64::from(pn >= problem.ceiling);
            sums.contact_elements += u64::from(matches!(states[e], State::Stick | State::Slip));
            sums.stick_elements += u64::from(states[e] == State::Stick);
            let (i, j) = grid.position(e);
            let at_edge = i == 0 || j == 0 || i + 1 == grid.nx() || j + 1 == grid.ny();
            sums.edge_elements += u64::from(problem.open_edge && at_edge && pn > 0.0);
        }
        sums
    };
    for band in parallel::bands(k, of_band) {
        total.dissipation += band.dissipation;
        total.largest_gap = total.largest_gap.max(band.largest_gap);
        total.peak_pressure = total.peak_pressure.max(band.peak_pressure);
        total.peak_traction = total.peak_traction.max(band.peak_traction);
        total.ceiling_elements += band.ceiling_elements;
        total.contact_elements += band.contact_elements;
        total.stick_elements += band.stick_elements;
        total.edge_elements += band.edge_elements;
    }
    total.slip_elements = total.contact_elements - total.stick_elements;
    let force = traction * area;
    let units = problem.scale.forces();
    let resultants = problem.resultants(p);
    [total.load, total.force_x, total.force_y, total.moment_x, total.moment_y, total.moment_z] =
        PerDof::from_fn(|dof| resultants[dof] * units[dof]).to_array();
    total.contact_area = total.contact_elements as f64 * area;
    total.stick_area = total.stick_elements as f64 * area;
    total.slip_area = total.slip_elements as f64 * area;
    total.largest_gap *= length;
    total.peak_pressure *= traction;
    total.peak_traction *= traction;
    total.dissipation = total.dissipation * force * length;
    total
}

/// Returns the elastic energy ½ Σ p·(A p) |e| \[J\], where `displacement` gives A p row by row, in
/// the problem's units.
pub(crate) fn elastic_energy(
    problem: &Problem,
    p: &[f64],
    displacement: impl Fn(usize) -> f64 + Sync,
) -> f64 {
    let (grid, k, length) = (&problem.grid, problem.grid.len(), problem.scale.length);
    let of_band = |band: Range<usize>| {
        let of_element =
            |e: usize| (0..3).map(|c| p[c * k + e] * displacement(c * k + e)).sum::<f64>();
        grid.active_in(band).map(of_element).fold(0.0, |sum, energy| sum + energy)
    };
    let sum = parallel::bands(k, of_band).into_iter().fold(0.0, |sum, energy| sum + energy);
    let area = grid.element_area() * length * length;
    0.5 * sum * (problem.scale.traction() * area) * length
}

/// Returns the regions in contact of a grid of nx × ny elements that do not touch each other, not
/// even at a corner. The elements of each are in order; the region with the smallest element comes
/// first.
pub fn patches([nx, ny]: [usize; 2], in_contact: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
    let mut seen = vec![false; nx * ny];
    let mut patches = Vec::new();
    for start in 0..nx * ny {
        if seen[start] || !in_contact(start) {
            continue;
        }
        seen[start] = true;
        let mut patch = vec![start];
        let mut next = 0;
        while let Some(&e) = patch.get(next) {
            next += 1;
            let (i, j) = (e % nx, e / nx);
            for j in j.saturating_sub(1)..(j + 2).min(ny) {
                for i in i.saturating_sub(1)..(i + 2).min(nx) {
                    let other = j * nx + i;
                    if !seen[other] && in_contact(other) {
                        seen[other] = true;
                        patch.push(other);
                    }
                }
            }
        }
        patch.sort_unstable();
        patches.push(patch);
    }
    patches
}

/// Returns the fields in SI units, from `p` and w = A p − f in the problem's units.
pub(crate) fn fields(problem: &Problem, p: &[f64], w: &[f64], states: &[State]) -> Fields {
    let grid = &problem.grid;
    let k = grid.len();
    let (length, traction) = (problem.scale.length, problem.scale.traction());
    let block = |field: &[f64], c: usize, unit: f64| -> Vec<f64> {
        let mut values = vec![0.0; k];
        parallel::rows(&mut values, grid.nx(), |j, row| {
            let first = grid.index(0, j);
            let from = &field[c * k + first..][..row.len()];
            for (_, (value, from)) in
                row.iter_mut().zip(from).enumerate().filter(|(i, _)| grid.is_active(first + i))
            {
                *value = from * unit;
            }
        });
        values
    };
    Fields {
        shape: [grid.nx() as u32, grid.ny() as u32],
        origin: grid.center(0).map(|x| x * length),
        element: [grid.hx() * length, grid.hy() * length],
        pressure: block(p, 0, traction),
        traction_x: block(p, 1, traction),
        traction_y: block(p, 2, traction),
        gap: block(w, 0, length),
        slip_x: block(w, 1, length),
        slip_y: block(w, 2, length),
        state: states.iter().map(|state| *state as u8).collect(),
        ..Fields::default()
    }
}
