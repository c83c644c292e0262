//! A semismooth Newton method on the natural map p − Gᵘ_μ(p − E v), v = εp + Ap − f, with the rigid
//! motions that forces govern among the unknowns.
//!
//! With x = p − E v an element is open where x₁ ≤ 0, and then p = 0; in contact v₁ = 0, or p₁ = u
//! where x₁ ≥ u. It sticks where |x_t| ≤ μ h_u(x₁), and then v_t = 0. It slips elsewhere: along n =
//! x_t/|x_t| the traction follows the pressure, p_t·n = μ p₁, and across it the linearised
//! projection demands σ (p + δp)_⊥ + (v + δv)_⊥ = 0 with κ = μ h_u(x₁)/|x_t| and σ = (1 − κ)/κE,
//! which is |w_t|/μp₁ at a solution. This leaves a linear system for the free components. GMRES
//! solves it with the inverse circulants of A's diagonal blocks as preconditioner, W C⁻¹ W with W =
//! 1/√(1 + σ/2a) on p_⊥ and a the diagonal entry. In steady rolling the operator is nearly A times
//! the difference of tractions to those [ahead](super::trail), and so is the preconditioner. The
//! map is that of Christensen, Klarbring, Pang and Strömberg 1998,
//! doi:10.1002/(SICI)1097-0207(19980515)42:1<145::AID-NME358>3.0.CO;2-L; the reduction and the
//! preconditioners are this project's.

use std::ops::Range;

use primitives::FullPivotLu;

use super::free::{ContactElement, ContactState, Free};
use super::gmres::{self, KrylovSolution, LinearSystem, Memory};
use super::iterate::{Conditions, Iterate, Stop, StopRule};
use super::trail::Ahead;
use super::{controls, vector};
use crate::common::{Cancellation, parallel};
use crate::influence::{Components, Diagonals, Direction, Scratch, Window, weighted_images};
use crate::model::{Dof, PerDof, Route, rigid_modes};
use crate::problem::{Operator, Problem, h_u};

/// The number of Newton steps without a new smallest residual after which the iteration counts as
/// stalled. Close to a solution every step but the first few at least halves the residual.
const PATIENCE: u64 = 12;

/// The number of applications after which the answer of a linear solve is taken as it is.
const MOST_APPLICATIONS: u64 = 400;

/// The relative residual to which a linear system is solved at least. With a looser one, Newton's
/// method under a flat disk of 200 or more elements across goes round in circles: with 0.1 it took
/// 411 applications under a pull at 200², and found nothing at 224²; with 0.01 it took 92 and 45.
/// Under spheres both take about as many, 0.01 in fewer steps.
const LOOSEST: f64 = 0.01;

/// The number of Newton steps without a new smallest residual after which all that is in contact is
/// taken to stick, once. A contact that begins to be pulled can go in circles between slip
/// everywhere to one side and to the other; slip then eats in from the edges of what sticks.
const CIRCLING: u64 = 3;

/// Solves `problem` under the `conditions`; leaves it placed at the motion found. If no solution is
/// found, the result is the iterate nearest to one.
pub(crate) fn solve(
    problem: &mut Problem,
    operator: &Operator,
    conditions: &Conditions<'_>,
) -> Iterate {
    let Conditions { controls, start, rule } = *conditions;
    let governed = controls::governed(controls);
    let targets = controls.map(controls::target);
    let initial = |dof: Dof| if governed.contains(&dof) { start.motion[dof] } else { targets[dof] };
    let mut motion = PerDof::from_fn(initial);
    let mut p = start.p.clone();
    let diagonals = operator.diagonals();
    // The certificate measures along another path of rounding.
    let target = 0.5 * rule.tolerance;
    let mut iterate = Iterate {
        p: Vec::new(),
        motion,
        stop: Stop::Diverged,
        iterations: 0,
        operator_applications: 0,
        route: Route::Newton,
    };
    if governed.contains(&Dof::Approach) && p.iter().all(|p| *p == 0.0) {
        motion[Dof::Approach] = controls::first_approach(problem, &motion, targets[Dof::Approach]);
    }

    let mut scratch = operator.scratch();
    let mut w = vec![0.0; p.len()];
    let mut memory = Memory::default();
    // The operator of the linear systems acts on the window of the grid that the contact needs.
    let mut local: Option<(Window, Operator)> = None;
    // The iterate nearest to a solution is kept with its figure and its iteration. It goes out if
    // no solution is found.
    let (mut best, mut best_iteration, mut best_iterate) = (f64::INFINITY, 0, (p.clone(), motion));
    iterate.stop = loop {
        problem.place(&motion);
        operator.apply(&mut w, &p, &mut scratch);
        iterate.operator_applications += 1;
        w.iter_mut().zip(&problem.f).for_each(|(w, f)| *w -= f);
        let residual = problem.residual(&p, &w, diagonals);
        let imbalance = controls::imbalances(problem, &p, &targets, &governed);
        let mut worst = imbalance.iter().copied().fold(residual, f64::max);
        if residual <= target && worst <= target {
            worst = problem.violation(&p).max(worst);
            if worst <= target {
                break Stop::Converged;
            }
        }
        if worst.is_nan() {
            break Stop::Diverged;
        }
        if worst < best {
            (best, best_iteration) = (worst, iterate.iterations);
            best_iterate.0.copy_from_slice(&p);
            best_iterate.1 = motion;
        } else if iterate.iterations - best_iteration > PATIENCE {
            break Stop::Stalled { residual: best };
        }
        if iterate.iterations >= u64::from(rule.max_iterations) || rule.is_cancelled() {
            break Stop::OutOfIterations { residual: worst };
        }
        // p − E v of a new f is far from the states, for E is the inverse of the diagonal alone and
        // too large for displacements of the whole contact. In ten increments that roll, at 64²,
        // the states of the increment before took 26 applications in each in place of 56.
        let past = start.w.as_ref().filter(|_| iterate.iterations == 0);
        let mut contact = Contact::of(problem, &p, past.unwrap_or(&w), diagonals);
        if iterate.iterations - best_iteration == CIRCLING {
            contact.stick(problem.mu);
        }
        let (window, inner) = contact.surroundings(problem, operator, &mut local);
        let mut linear = Linear::new(problem, inner, window, &contact, scratch);
        linear.cancellation = rule.cancellation;
        let forcing = (0.5 * worst.min(1.0).sqrt()).clamp(1e-6, LOOSEST).max(0.1 * target / worst);
        let changes = linear.step(&mut p, &w, &targets, &governed, forcing, &mut memory);
        iterate.operator_applications += linear.applications;
        scratch = linear.scratch;
        for (dof, change) in governed.iter().zip(changes) {
            motion[*dof] += change;
        }
        iterate.iterations += 1;
    };
    if iterate.stop != Stop::Converged {
        (p, motion) = best_iterate;
        problem.place(&motion);
    }
    Iterate { p, motion, ..iterate }
}

/// Returns the derivative of the resultants of the motions `governed` with respect to these motions
/// at the solution `p`, w = A p − f, with everything else in equilibrium; and the number of
/// applications spent.
pub(super) fn stiffness(
    problem: &Problem,
    operator: &Operator,
    [p, w]: [&[f64]; 2],
    governed: &[Dof],
    rule: &StopRule<'_>,
) -> (faer::Mat<f64>, u64) {
    let contact = Contact::of(problem, p, w, operator.diagonals());
    let mut local = None;
    let (window, inner) = contact.surroundings(problem, operator, &mut local);
    let mut linear = Linear::new(problem, inner, window, &contact, operator.scratch());
    linear.cancellation = rule.cancellation;
    let resultants: Vec<Vec<f64>> = governed.iter().map(|&dof| linear.resultant(dof)).collect();
    let mut memory = Memory::default();
    let mut stiffness = faer::Mat::zeros(governed.len(), governed.len());
    for (j, &dof) in governed.iter().enumerate() {
        let rows = linear.rigid(dof);
        let KrylovSolution { x, figures } =
            gmres::solve(&rows, 1e-4, MOST_APPLICATIONS, &mut linear, &mut memory);
        linear.applications += figures.applications;
        for (i, resultant) in resultants.iter().enumerate() {
            stiffness[(i, j)] = vector::dot(resultant, &x);
        }
    }
    (stiffness, linear.applications)
}

/// The factor by which the preconditioner enlarges the compliance of a slipping element alone,
/// because the transverse tractions of the element and its neighbours give way to each other. The
/// value took the fewest applications of ½, 1, 2, 3 and 4.
const COMPLIANCE: f64 = 2.0;

/// The states of the elements under the map linearised about an iterate.
struct Contact {
    /// The elements in contact, in order.
    elements: Vec<ContactElement>,
    /// The first and last column and row of all that is in contact or has a traction to lose;
    /// `None` where nothing is.
    bounds: Option<[[usize; 2]; 2]>,
}

impl Contact {
    /// Makes all elements in contact stick, where there is friction.
    fn stick(&mut self, mu: f64) {
        if mu > 0.0 {
            self.elements.iter_mut().for_each(|element| element.state = ContactState::Stick);
        }
    }

    /// Linearises the map about `p` with w = A p − f.
    fn of(problem: &Problem, p: &[f64], w: &[f64], diagonals: Diagonals) -> Self {
        let nx = problem.grid.nx();
        // With one tangential direction there is no transverse component.
        let is_plane = problem.components.includes(Components::TANGENTIAL);
        let band = |band: Range<usize>| {
            let mut contact = Self { elements: Vec::new(), bounds: None };
            let [first, last] = [band.start, band.end - 1].map(|e| e / nx);
            for j in first..=last {
                let row = band.start.max(j * nx)..band.end.min((j + 1) * nx);
                for (i, e) in
                    row.map(|e| (e - j * nx, e)).filter(|(_, e)| problem.grid.is_active(*e))
                {
                    let (tractions, w) = (problem.traction(p, e), problem.gather(w, e));
                    let mut x = problem.trial(tractions, w, diagonals);
                    if problem.pressure.is_some() {
                        x[0] = tractions[0];
                    }
                    if x[0] <= 0.0 {
                        if tractions != [0.0; 3] {
                            contact.reach([[i, j]; 2]);
                        }
                        continue;
                    }
                    let bound = problem.mu * h_u(x[0], problem.ceiling);
                    let tangential = x[1].hypot(x[2]);
                    let state = if tangential <= bound && problem.mu > 0.0 {
                        ContactState::Stick
                    } else {
                        let n = if tangential > 0.0 {
                            [x[1] / tangential, x[2] / tangential]
                        } else {
                            [1.0, 0.0]
                        };
                        let kappa = bound / tangential;
                        // Without friction the transverse component is not free, as with an
                        // infinite σ.
                        let sigma = if kappa > 0.0 && is_plane {
                            (1.0 - kappa) / kappa * (problem.epsilon + diagonals.tangential)
                        } else {
                            f64::INFINITY
                        };
                        ContactState::Slip { n, sigma }
                    };
                    let pressed = x[0] < problem.ceiling && problem.pressure.is_none();
                    contact.reach([[i, j]; 2]);
                    contact.elements.push(ContactElement {
                        i: i as u32,
                        j: j as u32,
                        pressed,
                        state,
                    });
                }
            }
            contact
        };
        let bands = parallel::bands(problem.grid.len(), band);
        let mut whole = Self {
            elements: Vec::with_capacity(bands.iter().map(|band| band.elements.len()).sum()),
            bounds: None,
        };
        for band in bands {
            whole.elements.extend(band.elements);
            band.bounds.into_iter().for_each(|bounds| whole.reach(bounds));
        }
        whole
    }

    /// Extends the bounds to the columns and rows from `low` to `high`.
    fn reach(&mut self, [low, high]: [[usize; 2]; 2]) {
        let [first, last] = self.bounds.get_or_insert([low, high]);
        for axis in 0..2 {
            first[axis] = first[axis].min(low[axis]);
            last[axis] = last[axis].max(high[axis]);
        }
    }

    /// Returns the window that holds the contact, and the operator there. Both are kept in `local`
    /// as long as the contact fits.
    fn surroundings<'a>(
        &self,
        problem: &Problem,
        whole: &'a Operator,
        local: &'a mut Option<(Window, Operator)>,
    ) -> (Window, &'a Operator) {
        let all = Window::whole(&problem.grid);
        let Some(bounds) = self.bounds else { return (all, whole) };
        if local.as_ref().is_none_or(|(window, _)| !window.holds(bounds)) {
            let window = Window::around(bounds, &problem.grid, &problem.mirror);
            *local = if window == all {
                None
            } else {
                Some((window, whole.within(window.size, problem.mirror)))
            };
        }
        local.as_ref().map_or((all, whole), |(window, operator)| (*window, operator))
    }
}

/// The natural map linearised about an iterate.
struct Linear<'a> {
    problem: &'a Problem,
    operator: &'a Operator,
    free: Free,
    /// The diagonal entry of the tangential blocks of εI + A, in steady rolling too.
    diagonal: f64,
    /// The borders, one for each rigid degree of freedom that a force governs.
    borders: Borders,
    /// The tractions on the window, zero where there is no contact.
    field: Vec<f64>,
    /// The displacements on the window.
    image: Vec<f64>,
    /// The way to what is ahead, in steady rolling.
    ahead: Option<Ahead>,
    /// The tractions on the window, summed from the leading edge.
    sums: Vec<[f64; 2]>,
    scratch: Scratch,
    applications: u64,
    /// The request to give up, if somebody can make one.
    cancellation: Option<&'a Cancellation>,
}

/// The rows and columns that the motions under forces add to the linear system.
#[derive(Default)]
struct Borders {
    /// The displacements of the free components by the motions, by one unit each.
    rows: Vec<Vec<f64>>,
    /// The vectors whose products with the free components are the resultants.
    resultants: Vec<Vec<f64>>,
    /// The images of the displacements under the preconditioner.
    answers: Vec<Vec<f64>>,
    /// The factored matrix of the resultants of the images.
    factors: Option<FullPivotLu>,
}

impl<'a> Linear<'a> {
    fn new(
        problem: &'a Problem,
        operator: &'a Operator,
        window: Window,
        contact: &Contact,
        scratch: Scratch,
    ) -> Self {
        let free = Free::new(problem, window, &contact.elements);
        let coefficient = operator.table.coefficient(0, 0);
        let len = free.field_len();
        Self {
            problem,
            operator,
            free,
            diagonal: coefficient.xx.max(coefficient.yy) + problem.epsilon,
            borders: Borders::default(),
            field: vec![0.0; len],
            image: vec![0.0; len],
            ahead: problem.steady.map(|distance| Ahead::new(distance / problem.grid.hx())),
            sums: Vec::new(),
            scratch,
            applications: 0,
            cancellation: None,
        }
    }

    /// Returns the displacement by a rigid motion in the rows of the free components.
    fn rigid(&self, dof: Dof) -> Vec<f64> {
        let mut rows = vec![0.0; self.free.len()];
        self.free.restrict(
            &mut rows,
            0.0,
            |element, _| self.modes(element).map(|modes| modes[dof]),
            |_, row, _| row,
        );
        rows
    }

    /// Returns the rigid modes at an element's centre, for the components (n, x, y).
    fn modes(&self, element: &ContactElement) -> [PerDof<f64>; 3] {
        let [x, y] = self.problem.grid.center_of(element.i as usize, element.j as usize);
        rigid_modes(x, y)
    }

    /// Returns the vector whose product with the free components is a resultant.
    fn resultant(&self, dof: Dof) -> Vec<f64> {
        let weights = self.weights(dof);
        let mut rows = vec![0.0; self.free.len()];
        let values = |element: &ContactElement, _| {
            let modes = self.modes(element);
            [0, 1, 2].map(|c| modes[c][dof] * weights[c])
        };
        self.free.restrict(&mut rows, self.problem.mu, values, |_, row, _| row);
        rows
    }

    /// Returns the area of an element with its images, for each component in one resultant.
    fn weights(&self, dof: Dof) -> [f64; 3] {
        Direction::ALL.map(|direction| {
            weighted_images(&self.problem.mirror, direction)[dof] * self.problem.grid.element_area()
        })
    }

    /// Makes the Newton step in `p`, solved to the relative residual `forcing`; returns the changes
    /// of the motions `governed`.
    fn step(
        &mut self,
        p: &mut [f64],
        w: &[f64],
        targets: &PerDof<f64>,
        governed: &[Dof],
        forcing: f64,
        memory: &mut Memory,
    ) -> Vec<f64> {
        let (mu, epsilon) = (self.problem.mu, self.problem.epsilon);
        let (window, grid) = (*self.free.window(), &self.problem.grid);
        // The known tractions are those after the step, the unknown ones are as they are.
        let mut total = vec![0.0; self.free.field_len()];
        self.free.write(&mut total, |element, place| {
            let tractions = self.problem.traction(p, window.element(place, grid));
            let normal = if element.pressed || self.problem.pressure.is_some() {
                tractions[0]
            } else {
                self.problem.ceiling
            };
            let tangential = match element.state {
                ContactState::Stick => [tractions[1], tractions[2]],
                ContactState::Slip { n, sigma } => {
                    let across = if sigma.is_finite() {
                        tractions[2] * n[0] - tractions[1] * n[1]
                    } else {
                        0.0
                    };
                    [mu * normal * n[0] - across * n[1], mu * normal * n[1] + across * n[0]]
                }
            };
            [normal, tangential[0], tangential[1]]
        });
        let mut known = total.clone();
        window.each_row(grid, known.len() / window.len(), |of_window, of_grid| {
            known[of_window].iter_mut().zip(&p[of_grid]).for_each(|(known, p)| *known -= p);
        });
        if known.iter().any(|x| *x != 0.0) {
            self.operator.apply(&mut self.image, &known, &mut self.scratch);
            self.applications += 1;
        }
        let mut rhs = vec![0.0; self.free.len()];
        let (image, free) = (&self.image, &self.free);
        let defect = |_: &ContactElement, place: usize| {
            let (image, total, w) = (
                free.at(image, place),
                free.at(&total, place),
                self.problem.gather(w, window.element(place, grid)),
            );
            [0, 1, 2].map(|c| -(image[c] + epsilon * total[c] + w[c]))
        };
        let mut total_rows = vec![0.0; self.free.len()];
        self.free.rows_of(&mut total_rows, &total);
        let across = |sigma: f64, row: f64, index: usize| row - sigma * total_rows[index];
        self.free.restrict(&mut rhs, 0.0, defect, across);
        drop(total_rows);
        self.border(governed);
        for &dof in governed {
            let weights = self.weights(dof);
            let contribution = |(element, place): (&ContactElement, usize)| {
                let (modes, total) = (self.modes(element), self.free.at(&total, place));
                (0..3).map(|c| modes[c][dof] * weights[c] * total[c]).sum::<f64>()
            };
            rhs.push(targets[dof] - self.free.elements().map(contribution).sum::<f64>());
        }
        drop(total);
        let KrylovSolution { x, figures } =
            gmres::solve(&rhs, forcing, MOST_APPLICATIONS, self, memory);
        self.applications += figures.applications;
        let (unknowns, changes) = x.split_at(self.free.len());
        self.free.expand(&mut self.field, unknowns, mu, |_| 1.0);
        window.each_row(grid, known.len() / window.len(), |of_window, of_grid| {
            let change = self.field[of_window.clone()].iter().zip(&known[of_window]);
            p[of_grid].iter_mut().zip(change).for_each(|(p, (field, known))| *p += field + known);
        });
        changes.to_vec()
    }

    /// Prepares the linear system for the motions among its unknowns.
    fn border(&mut self, governed: &[Dof]) {
        if governed.is_empty() {
            return;
        }
        let mut borders = Borders::default();
        for &dof in governed {
            let rows = self.rigid(dof);
            let mut answer = vec![0.0; rows.len()];
            self.elastic_inverse(&mut answer, &rows);
            borders.rows.push(rows);
            borders.answers.push(answer);
            borders.resultants.push(self.resultant(dof));
        }
        let size = governed.len();
        let matrix = faer::Mat::from_fn(size, size, |i, j| {
            vector::dot(&borders.resultants[i], &borders.answers[j])
        });
        borders.factors = Some(FullPivotLu::new(&matrix));
        self.borders = borders;
    }

    /// Applies about the inverse of the elastic system to the free components alone.
    fn elastic_inverse(&mut self, unknowns: &mut [f64], rows: &[f64]) {
        match self.ahead {
            None => self.still_inverse(unknowns, rows),
            Some(ahead) => self.rolling_inverse(ahead, unknowns, rows),
        }
    }

    /// Applies W C⁻¹ W.
    fn still_inverse(&mut self, unknowns: &mut [f64], rows: &[f64]) {
        let diagonal = self.diagonal;
        let weight = |sigma: f64| 1.0 / (1.0 + sigma / (COMPLIANCE * diagonal)).sqrt();
        self.circulant_inverse(rows, weight);
        let (free, image) = (&self.free, &self.image);
        free.restrict(
            unknowns,
            0.0,
            |_, place| free.at(image, place),
            |sigma, row, _| weight(sigma) * row,
        );
    }

    /// Applies C⁻¹, which gives the differences of tractions to those ahead, and sums them from the
    /// leading edge. An element that slips fast has the traction that its own row asks for, and has
    /// little part in the rest.
    fn rolling_inverse(&mut self, ahead: Ahead, unknowns: &mut [f64], rows: &[f64]) {
        let diagonal = self.diagonal;
        self.circulant_inverse(rows, |sigma| 1.0 / (1.0 + sigma / diagonal));
        let yielding = |sigma: f64| sigma / diagonal;
        ahead.sum(&self.free, self.problem.mu, &self.image, yielding, &mut self.sums);
        let (free, image, sums) = (&self.free, &self.image, &self.sums);
        let tractions = |_: &ContactElement, place: usize| {
            let ([normal, _, _], [x, y]) = (free.at(image, place), sums[place]);
            [normal, x, y]
        };
        let alone = |sigma: f64| sigma / (sigma + diagonal).powi(2);
        free.restrict(unknowns, 0.0, tractions, |sigma, row, index| {
            row + alone(sigma) * rows[index]
        });
    }

    /// Applies C⁻¹ to the rows of the free components, those of transverse ones times `weight`(σ),
    /// and leaves the result in the image.
    fn circulant_inverse(&mut self, rows: &[f64], weight: impl Fn(f64) -> f64 + Sync) {
        self.free.expand(&mut self.field, rows, 0.0, weight);
        self.operator.circulant.invert(
            &mut self.image,
            &self.field,
            self.problem.epsilon,
            &mut self.scratch,
        );
    }
}

impl LinearSystem for Linear<'_> {
    /// Maps free components and free motions to rows and resultants.
    fn apply(&mut self, image: &mut [f64], x: &[f64]) {
        let (unknowns, motions) = x.split_at(self.free.len());
        let (rows, resultants) = image.split_at_mut(self.free.len());
        self.free.expand(&mut self.field, unknowns, self.problem.mu, |_| 1.0);
        self.operator.apply(&mut self.image, &self.field, &mut self.scratch);
        let (free, field, image, epsilon) =
            (&self.free, &self.field, &self.image, self.problem.epsilon);
        let values = |_: &ContactElement, place: usize| {
            let (image, tractions) = (
                free.at(image, place),
                if epsilon > 0.0 { free.at(field, place) } else { [0.0; 3] },
            );
            [0, 1, 2].map(|c| image[c] + epsilon * tractions[c])
        };
        free.restrict(rows, 0.0, values, |sigma, row, index| row + sigma * unknowns[index]);
        if !motions.is_empty() {
            let minus: Vec<f64> = motions.iter().map(|motion| -motion).collect();
            vector::add(rows, &minus, &self.borders.rows);
            for (resultant, row) in resultants.iter_mut().zip(&self.borders.resultants) {
                *resultant = vector::dot(row, unknowns);
            }
        }
    }

    /// Applies the elastic inverse, with the resultants exactly right.
    fn precondition(&mut self, x: &mut [f64], rows: &[f64]) {
        let (rows, resultants) = rows.split_at(self.free.len());
        let (unknowns, motions) = x.split_at_mut(self.free.len());
        self.elastic_inverse(unknowns, rows);
        if let Some(factors) = &self.borders.factors {
            let mut missing = faer::Mat::from_fn(resultants.len(), 1, |i, _| {
                resultants[i] - vector::dot(&self.borders.resultants[i], unknowns)
            });
            factors.solve(&mut missing);
            motions.iter_mut().enumerate().for_each(|(i, motion)| *motion = missing[(i, 0)]);
            vector::add(unknowns, motions, &self.borders.answers);
        }
    }
}
