//! Semismooth Newton on the natural map p − Gᵘ_μ(p − E v), v = εp + Ap − f, with the rigid motions that a force governs among
//! the unknowns.
//!
//! With x = p − E v an element is open where x₁ ≤ 0 and then p = 0; in contact v₁ = 0, or p₁ = u where x₁ ≥ u. It sticks where
//! |x_t| ≤ μ h_u(x₁) and then v_t = 0. It slips elsewhere: along n = x_t/|x_t| the traction follows the pressure, p_t·n = μ p₁, and
//! across it the linearised projection asks σ (p + δp)_⊥ + (v + δv)_⊥ = 0 with κ = μ h_u(x₁)/|x_t| and σ = (1 − κ)/κE, which is
//! |w_t|/μp₁ at a solution. What is left is a linear system for the free components, solved by GMRES with the inverse
//! circulants of A's diagonal blocks as preconditioner, W C⁻¹ W with W = 1/√(1 + σ/a) on p_⊥ and a the diagonal entry (Christensen,
//! Klarbring, Pang and Strömberg 1998, doi:10.1002/(SICI)1097-0207(19980515)42:1<145::AID-NME358>3.0.CO;2-L, for the map;
//! the reduction and the preconditioner are this project's).

use faer::linalg::solvers::Solve;

use super::{Iterate, Limits, Start, Stop, balance, gmres};
use crate::friction::h_u;
use crate::influence::{Components, Scratch};
use crate::loading::{Control, rigid_modes};
use crate::operators::Operator;
use crate::outcome::Way;
use crate::problem::Problem;

/// Newton steps without a new smallest residual after which the iteration counts as stalled. Close to a solution every
/// step but the first few at least halves it.
const PATIENCE: u64 = 12;

/// Applications after which the answer of a linear solve is taken as it is.
const MOST_APPLICATIONS: u64 = 400;

/// What an element does under the linearised map.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Piece {
    /// p is known: zero, or at the ceiling with a traction that follows.
    Open,
    /// p₁ and both tangential components are free.
    Stick,
    /// p₁ and the transverse component are free; n is the direction of the traction.
    Slip { n: [f64; 2], sigma: f64 },
}

/// The natural map linearised about an iterate.
struct Linear<'a> {
    problem: &'a Problem,
    operator: &'a Operator,
    pieces: Vec<Piece>,
    /// Elements whose pressure is free: in contact below the ceiling.
    pressed: Vec<bool>,
    /// Rigid degrees of freedom that a force governs.
    free: Vec<usize>,
    /// Diagonal entry of the tangential blocks.
    diagonal: f64,
    scratch: Scratch,
    applications: u64,
}

/// Solves `problem` under `controls` (in the problem's units) from `start`; leaves the problem placed at the motion found.
pub fn solve(problem: &mut Problem, operator: &Operator, controls: &[Control; 6], start: &Start, limits: &Limits) -> Iterate {
    let free: Vec<usize> = (0..6).filter(|which| matches!(controls[*which], Control::Force(_))).collect();
    let asked = controls.map(|control| match control {
        Control::Force(value) | Control::Motion(value) => value,
    });
    let mut motion: [f64; 6] = std::array::from_fn(|which| if free.contains(&which) { start.motion[which] } else { asked[which] });
    let mut p = start.p.clone();
    let largest = operator.table.largest_diagonal();
    let target = 0.5 * limits.tolerance; // the certificate measures along another path of rounding
    let mut iterate = Iterate { p: Vec::new(), motion, stop: Stop::Diverged, iterations: 0, operator_applications: 0, way: Way::Newton };
    if free.contains(&0) && p.iter().all(|p| *p == 0.0) {
        motion[0] = balance::first_approach(problem, &motion, asked[0]);
    }

    let mut scratch = operator.scratch();
    let mut w = vec![0.0; p.len()];
    // the iterate nearest to a solution, its figure and when it was: what goes out if no solution is found
    let (mut best, mut best_at, mut best_iterate) = (f64::INFINITY, 0, (p.clone(), motion));
    iterate.stop = loop {
        problem.place(&motion);
        operator.apply(&mut w, &p, &mut scratch);
        iterate.operator_applications += 1;
        w.iter_mut().zip(&problem.f).for_each(|(w, f)| *w -= f);
        let residual = problem.residual(&p, &w, largest);
        let imbalance = balance::imbalances(problem, &p, &asked, &free);
        let worst = imbalance.iter().copied().fold(residual, f64::max);
        if residual <= target && worst <= target {
            break Stop::Converged;
        }
        if worst.is_nan() {
            break Stop::Diverged;
        }
        if worst < best {
            (best, best_at, best_iterate) = (worst, iterate.iterations, (p.clone(), motion));
        } else if iterate.iterations - best_at > PATIENCE {
            break Stop::Stalled { residual: best };
        }
        if iterate.iterations >= u64::from(limits.max_iterations) {
            break Stop::OutOfIterations { residual: worst };
        }
        let mut linear = Linear::new(problem, operator, &p, &w, free.clone(), scratch);
        let forcing = (0.5 * worst.min(1.0).sqrt()).clamp(1e-6, 0.1).max(0.1 * target / worst);
        let (change, moved) = linear.step(&p, &w, &asked, forcing);
        iterate.operator_applications += linear.applications;
        scratch = linear.scratch;
        p.iter_mut().zip(&change).for_each(|(p, d)| *p += d);
        for (which, moved) in free.iter().zip(moved) {
            motion[*which] += moved;
        }
        iterate.iterations += 1;
    };
    if iterate.stop != Stop::Converged {
        (p, motion) = best_iterate;
        problem.place(&motion);
    }
    Iterate { p, motion, ..iterate }
}

/// How the resultants of the motions `free` change with these motions at the solution `p`, w = A p − f, with applications spent.
pub(super) fn stiffness(problem: &Problem, operator: &Operator, p: &[f64], w: &[f64], free: &[usize]) -> (faer::Mat<f64>, u64) {
    let scratch = operator.scratch();
    let mut linear = Linear::new(problem, operator, p, w, free.to_vec(), scratch);
    let stiffness = linear.stiffness(1e-4);
    (stiffness, linear.applications)
}

impl<'a> Linear<'a> {
    fn new(problem: &'a Problem, operator: &'a Operator, p: &[f64], w: &[f64], free: Vec<usize>, scratch: Scratch) -> Self {
        let k = problem.grid.len();
        let own = operator.table.coefficient(0, 0);
        let largest = operator.table.largest_diagonal();
        // with one tangential direction there is no transverse component
        let is_plane = problem.components.includes(Components::TANGENTIAL);
        let mut pieces = vec![Piece::Open; k];
        let mut pressed = vec![false; k];
        for e in problem.grid.active() {
            let (own, w) = (problem.traction(p, e), problem.gather(w, e));
            let mut x = [0, 1, 2].map(|c| own[c] - (problem.epsilon * own[c] + w[c]) / largest);
            if problem.pressure.is_some() {
                x[0] = own[0];
            }
            if x[0] <= 0.0 {
                continue;
            }
            pressed[e] = x[0] < problem.ceiling && problem.pressure.is_none();
            let bound = problem.mu * h_u(x[0], problem.ceiling);
            let traction = x[1].hypot(x[2]);
            pieces[e] = if traction <= bound && problem.mu > 0.0 {
                Piece::Stick
            } else {
                let n = if traction > 0.0 { [x[1] / traction, x[2] / traction] } else { [1.0, 0.0] };
                let kappa = bound / traction;
                // without friction the transverse component is not free, as with an infinite σ
                let sigma = if kappa > 0.0 && is_plane { (1.0 - kappa) / kappa * largest } else { f64::INFINITY };
                Piece::Slip { n, sigma }
            };
        }
        Self { problem, operator, pieces, pressed, free, diagonal: own.xx.max(own.yy), scratch, applications: 0 }
    }

    /// Values of a field of the problem's components.
    fn len(&self) -> usize {
        self.problem.components.len() * self.problem.grid.len()
    }

    /// Writes the components of an element into a field; those that the problem has not are dropped.
    fn scatter(&self, field: &mut [f64], element: usize, values: [f64; 3]) {
        for (block, c) in self.problem.blocks() {
            field[block * self.problem.grid.len() + element] = values[c];
        }
    }

    /// Where the free transverse component of a slipping element is kept, in the place of its traction along x; `None` where it is
    /// not free.
    fn across(&self, element: usize) -> Option<(usize, f64)> {
        match self.pieces[element] {
            Piece::Slip { sigma, .. } if sigma.is_finite() => {
                let (block, _) = self.problem.blocks().find(|(_, c)| *c == 1)?;
                Some((block * self.problem.grid.len() + element, sigma))
            }
            _ => None,
        }
    }

    /// The displacement by one rigid motion as a field.
    fn rigid(&self, which: usize) -> Vec<f64> {
        let mut field = vec![0.0; self.len()];
        for e in self.problem.grid.active() {
            let [x, y] = self.problem.grid.center(e);
            self.scatter(&mut field, e, rigid_modes(x, y).map(|modes| modes[which]));
        }
        field
    }

    /// The Newton step (δp, change of the free motions), solved to the relative residual `forcing`.
    fn step(&mut self, p: &[f64], w: &[f64], asked: &[f64; 6], forcing: f64) -> (Vec<f64>, Vec<f64>) {
        // what is known of δp
        let mut known = vec![0.0; self.len()];
        for e in self.problem.grid.active() {
            let own = self.problem.traction(p, e);
            let normal = if self.pressed[e] || self.problem.pressure.is_some() { 0.0 } else { self.problem.ceiling - own[0] };
            let change = match self.pieces[e] {
                Piece::Open => own.map(|p| -p),
                Piece::Stick => [normal, 0.0, 0.0],
                Piece::Slip { n, sigma } => {
                    let along = self.problem.mu * (own[0] + normal) - (own[1] * n[0] + own[2] * n[1]);
                    let across = if sigma.is_finite() { 0.0 } else { own[1] * n[1] - own[2] * n[0] };
                    [normal, along * n[0] - across * n[1], along * n[1] + across * n[0]]
                }
            };
            self.scatter(&mut known, e, change);
        }
        let mut rows = vec![0.0; self.len()];
        if known.iter().any(|x| *x != 0.0) {
            self.apply(&mut rows, &known);
        }
        for ((row, w), (p, known)) in rows.iter_mut().zip(w).zip(p.iter().zip(&known)) {
            *row = -(*row + self.problem.epsilon * (p + known) + w);
        }
        let mut rhs = self.restrict(&rows);
        for e in self.problem.grid.active() {
            if let (Piece::Slip { n, .. }, Some((at, sigma))) = (self.pieces[e], self.across(e)) {
                let own = self.problem.gather(p, e);
                rhs[at] -= sigma * (own[2] * n[0] - own[1] * n[1]);
            }
        }
        let total: Vec<f64> = p.iter().zip(&known).map(|(p, d)| p + d).collect();
        let resultants = self.problem.resultants(&total);
        rhs.extend(self.free.iter().map(|&which| asked[which] - resultants[which]));

        let borders = self.borders();
        let (solution, figures) = {
            let this = std::cell::RefCell::new(&mut *self);
            gmres::solve(&rhs, forcing, MOST_APPLICATIONS, |x| this.borrow_mut().matrix(x), |r| this.borrow_mut().precondition(r, &borders))
        };
        self.applications += figures.applications;
        let (free, moved) = solution.split_at(self.len());
        let mut change = self.expand(free);
        change.iter_mut().zip(&known).for_each(|(change, known)| *change += known);
        (change, moved.to_vec())
    }

    /// ∂(resultants of the free motions)/∂(free motions) with everything else in equilibrium.
    fn stiffness(&mut self, forcing: f64) -> faer::Mat<f64> {
        let free = std::mem::take(&mut self.free);
        let mut columns = Vec::new();
        for &which in &free {
            let rows = self.restrict(&self.rigid(which));
            let borders = Borders { answers: Vec::new(), factors: None };
            let (solution, figures) = {
                let this = std::cell::RefCell::new(&mut *self);
                gmres::solve(
                    &rows,
                    forcing,
                    MOST_APPLICATIONS,
                    |x| this.borrow_mut().matrix(x),
                    |r| this.borrow_mut().precondition(r, &borders),
                )
            };
            self.applications += figures.applications;
            columns.push(self.problem.resultants(&self.expand(&solution)));
        }
        self.free = free;
        faer::Mat::from_fn(columns.len(), columns.len(), |i, j| columns[j][self.free[i]])
    }

    /// out = A field, counted.
    fn apply(&mut self, out: &mut [f64], field: &[f64]) {
        self.operator.apply(out, field, &mut self.scratch);
        self.applications += 1;
    }

    /// Free components to a field: on sticking elements they are the components, on slipping ones p₁ and p_⊥, with p_t·n = μ p₁.
    fn expand(&self, free: &[f64]) -> Vec<f64> {
        let mut field = vec![0.0; self.len()];
        for e in self.problem.grid.active() {
            let own = self.problem.gather(free, e);
            let normal = if self.pressed[e] { own[0] } else { 0.0 };
            let tangential = match self.pieces[e] {
                Piece::Open => continue,
                Piece::Stick => [own[1], own[2]],
                Piece::Slip { n, sigma } => {
                    let along = self.problem.mu * normal;
                    let across = if sigma.is_finite() { own[1] } else { 0.0 };
                    [along * n[0] - across * n[1], along * n[1] + across * n[0]]
                }
            };
            self.scatter(&mut field, e, [normal, tangential[0], tangential[1]]);
        }
        field
    }

    /// The rows of the free components; on slipping elements the one across the traction.
    fn restrict(&self, field: &[f64]) -> Vec<f64> {
        let mut rows = vec![0.0; self.len()];
        for e in self.problem.grid.active() {
            let own = self.problem.gather(field, e);
            let normal = if self.pressed[e] { own[0] } else { 0.0 };
            let tangential = match self.pieces[e] {
                Piece::Open => continue,
                Piece::Stick => [own[1], own[2]],
                Piece::Slip { n, sigma } if sigma.is_finite() => [own[2] * n[0] - own[1] * n[1], 0.0],
                Piece::Slip { .. } => [0.0, 0.0],
            };
            self.scatter(&mut rows, e, [normal, tangential[0], tangential[1]]);
        }
        rows
    }

    /// The linear system: free components and free motions to rows and resultants.
    fn matrix(&mut self, x: &[f64]) -> Vec<f64> {
        let k = self.problem.grid.len();
        let (free, moved) = x.split_at(self.len());
        let field = self.expand(free);
        let mut image = vec![0.0; self.len()];
        self.operator.apply(&mut image, &field, &mut self.scratch);
        image.iter_mut().zip(&field).for_each(|(image, p)| *image += self.problem.epsilon * p);
        if !moved.is_empty() {
            for e in self.problem.grid.active() {
                let [x, y] = self.problem.grid.center(e);
                let modes = rigid_modes(x, y);
                for (block, c) in self.problem.blocks() {
                    image[block * k + e] -= self.free.iter().zip(moved).map(|(&which, moved)| modes[c][which] * moved).sum::<f64>();
                }
            }
        }
        let mut rows = self.restrict(&image);
        for e in self.problem.grid.active() {
            if let Some((at, sigma)) = self.across(e) {
                rows[at] += sigma * free[at];
            }
        }
        if !self.free.is_empty() {
            let resultants = self.problem.resultants(&field);
            rows.extend(self.free.iter().map(|&which| resultants[which]));
        }
        rows
    }

    /// W C⁻¹ W on the free components alone.
    fn elastic_inverse(&mut self, rows: &[f64]) -> Vec<f64> {
        let weight = |sigma: f64| 1.0 / (1.0 + sigma / self.diagonal).sqrt();
        let mut field = vec![0.0; self.len()];
        for e in self.problem.grid.active() {
            let own = self.problem.gather(rows, e);
            let normal = if self.pressed[e] { own[0] } else { 0.0 };
            let tangential = match self.pieces[e] {
                Piece::Open => continue,
                Piece::Stick => [own[1], own[2]],
                Piece::Slip { n, sigma } if sigma.is_finite() => {
                    let across = weight(sigma) * own[1];
                    [-across * n[1], across * n[0]]
                }
                Piece::Slip { .. } => [0.0, 0.0],
            };
            self.scatter(&mut field, e, [normal, tangential[0], tangential[1]]);
        }
        self.operator.circulant.invert(&mut field, self.problem.epsilon, &mut self.scratch);
        let mut free = self.restrict(&field);
        for e in self.problem.grid.active() {
            if let Some((at, sigma)) = self.across(e) {
                free[at] *= weight(sigma);
            }
        }
        free
    }

    /// For each free motion its rows B and P⁻¹B, and the factored matrix of the resultants of the latter.
    fn borders(&mut self) -> Borders {
        let rows: Vec<Vec<f64>> = self.free.iter().map(|&which| self.restrict(&self.rigid(which))).collect();
        let answers: Vec<Vec<f64>> = rows.iter().map(|rows| self.elastic_inverse(rows)).collect();
        let size = self.free.len();
        let columns: Vec<[f64; 6]> = answers.iter().map(|answer| self.problem.resultants(&self.expand(answer))).collect();
        let matrix = faer::Mat::from_fn(size, size, |i, j| columns[j][self.free[i]]);
        Borders { answers, factors: (size > 0).then(|| matrix.full_piv_lu()) }
    }

    /// The preconditioner: the elastic inverse, with the resultants exactly right.
    fn precondition(&mut self, rows: &[f64], borders: &Borders) -> Vec<f64> {
        let (rows, asked) = rows.split_at(self.len());
        let mut free = self.elastic_inverse(rows);
        if let Some(factors) = &borders.factors {
            let resultants = self.problem.resultants(&self.expand(&free));
            let mut missing = faer::Mat::from_fn(self.free.len(), 1, |i, _| asked[i] - resultants[self.free[i]]);
            factors.solve_in_place(missing.as_mut());
            for (i, answer) in borders.answers.iter().enumerate() {
                free.iter_mut().zip(answer).for_each(|(free, answer)| *free += missing[(i, 0)] * answer);
            }
            free.extend((0..self.free.len()).map(|i| missing[(i, 0)]));
        }
        free
    }
}

/// What the preconditioner needs to meet the resultants.
struct Borders {
    answers: Vec<Vec<f64>>,
    factors: Option<faer::linalg::solvers::FullPivLu<f64>>,
}
