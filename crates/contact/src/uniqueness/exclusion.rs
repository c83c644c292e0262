//! The weights that exclude the fields of a case in a cone for one μ, or the mixture of fields that
//! no weights exclude.
//!
//! The fields of a decided case are a subspace: x₁ = 0 at its open elements, and y₁ = 0 determines
//! x₁ at its closed ones. In a basis of it with x·Ax = |z|² the form of [`super::cones`] is linear
//! in the weights β, α of undecided elements, p = μβτ, q = μβ/τ and N, with the cone (μβ)² ≤ pq.
//! The method maximises t such that the form exceeds t|z|², with Σ β = k, logarithmic barriers and
//! Newton's method. As soon as t is above 0 the weights serve. Where the largest t is not, the
//! multiplier of the form is a mixture of fields, E zzᵀ, that meets all conditions in the mean.
//! No proof relies on this method, for [`super::cones`] checks the outcome.

use faer::{Accum, Mat};
use primitives::{cholesky, cholesky_inverse, cholesky_solve, multiply, solve_lower, solve_upper};

use super::cover::NormalCase;

/// The fields of a case, in a basis of coordinates z with x·Ax = |z|².
pub(super) struct CaseFields {
    states: Vec<NormalCase>,
    /// The tractions x of the basis, 3k × d.
    traction: Mat<f64>,
    /// The displacements y = Ax of the basis, 3k × d.
    displacement: Mat<f64>,
    /// The factor L with z = Lᵀc for the free tractions c, the 2k tangential ones first.
    lower: Mat<f64>,
}

/// Weights for one μ, with p = μβτ and q = μβ/τ in place of τ.
pub(super) struct CaseWeights {
    /// The weight α of each undecided element.
    pub(super) alpha: Vec<f64>,
    /// The weight β of each element.
    pub(super) beta: Vec<f64>,
    /// The ratio τ = √(p/q) of each element that is not open.
    pub(super) tau: Vec<f64>,
    /// The weight of each product of two forms of the cone.
    pub(super) products: Vec<f64>,
}

/// The outcome of a search for weights.
pub(super) enum ExclusionOutcome {
    /// The weights exclude the fields.
    Excluded(CaseWeights),
    /// The mixture of fields E zzᵀ, a d × d matrix of trace 1.
    Mixture(Mat<f64>),
}

impl CaseFields {
    /// Makes a basis of the fields of a case. It is `None` if A is not positive definite.
    pub(super) fn new(matrix: &Mat<f64>, states: &[NormalCase]) -> Option<Self> {
        let k = states.len();
        let of = |state: NormalCase| (0..k).filter(move |&e| states[e] == state);
        let closed: Vec<usize> = of(NormalCase::Closed).collect();
        let free: Vec<usize> = (k..3 * k).chain(of(NormalCase::Undecided)).collect();
        let mut traction = Mat::<f64>::zeros(3 * k, free.len());
        free.iter().enumerate().for_each(|(column, &row)| traction[(row, column)] = 1.0);
        if !closed.is_empty() {
            let normal =
                Mat::from_fn(closed.len(), closed.len(), |i, j| matrix[(closed[i], closed[j])]);
            let mut solved =
                Mat::from_fn(closed.len(), free.len(), |i, j| -matrix[(closed[i], free[j])]);
            cholesky_solve(&cholesky(normal)?, &mut solved);
            for (i, &row) in closed.iter().enumerate() {
                (0..free.len()).for_each(|j| traction[(row, j)] = solved[(i, j)]);
            }
        }
        let displacement = product(matrix, &traction);
        let energy = product(&traction.transpose().to_owned(), &displacement);
        let lower = cholesky(energy)?;
        // With z = Lᵀ(coordinates) the basis is that of before times L⁻ᵀ.
        let changed = |basis: &Mat<f64>| {
            let mut transposed = basis.transpose().to_owned();
            solve_lower(lower.as_ref(), &mut transposed);
            transposed.transpose().to_owned()
        };
        let (traction, displacement) = (changed(&traction), changed(&displacement));
        Some(Self { states: states.to_vec(), traction, displacement, lower })
    }

    /// Returns d, the number of coordinates.
    pub(super) fn dimension(&self) -> usize {
        self.traction.ncols()
    }

    /// Returns the form l of the 2k tangential tractions with l·x_t = f·z for all fields of the
    /// case, in which no element is undecided.
    pub(super) fn form_of_tractions(&self, form: &[f64]) -> Vec<f32> {
        (0..2 * self.states.len())
            .map(|row| (0..=row).map(|j| self.lower[(row, j)] * form[j]).sum::<f64>() as f32)
            .collect()
    }

    /// Returns the form f with f·z = l·x_t for all fields of the case, in which no element is
    /// undecided: the opposite of [`form_of_tractions`](Self::form_of_tractions).
    pub(super) fn form_of_coordinates(&self, form: &[f32]) -> Vec<f64> {
        let k = self.states.len();
        let sum = |column: usize| {
            let terms = form.iter().enumerate();
            terms.map(|(row, l)| self.traction[(k + row, column)] * f64::from(*l)).sum()
        };
        (0..self.dimension()).map(sum).collect()
    }

    /// Looks for weights that exclude the fields in the cone of `forms` for `mu`. Forms have the
    /// length 1 in coordinates. It is `None` where rounding stops the search.
    pub(super) fn exclude(&self, forms: &[Vec<f64>], mu: f64) -> Option<ExclusionOutcome> {
        ExclusionProgram::new(self, forms, mu).solve()
    }
}

/// A term c·sym(a bᵀ) of the matrix of a weight, of the vectors with these indices.
#[derive(Clone, Copy)]
struct Term {
    a: usize,
    b: usize,
    factor: f64,
}

/// The friction of an element that is not open: the places of β, p and q.
struct FrictionCone {
    beta: usize,
    p: usize,
    q: usize,
}

/// The largest t for which the form exceeds t|z|².
struct ExclusionProgram {
    mu: f64,
    elements: usize,
    /// The vectors that terms refer to, as columns.
    vectors: Mat<f64>,
    /// The terms of each weight. The last unknown is t, whose matrix is −I.
    terms: Vec<Vec<Term>>,
    cones: Vec<FrictionCone>,
    /// The number of weights that stand for α.
    undecided: usize,
    /// The number of weights of products.
    products: usize,
}

/// Weights and t, and what was computed at them.
struct ExclusionPoint {
    values: Vec<f64>,
    objective: f64,
    lower: Mat<f64>,
}

/// The first value of the factor κ in −t/κ + barriers.
const FIRST_KAPPA: f64 = 1.0;

/// The value of t that counts as above 0, where Σ β = k. Weights in single precision still serve.
const ENOUGH: f64 = 2e-5;

/// The value of κ times the number of barriers at which the search gives up.
const LAST_GAP: f64 = 1e-3;

/// The largest number of Newton's steps for one κ.
const MOST_STEPS: usize = 50;

impl ExclusionProgram {
    fn new(fields: &CaseFields, forms: &[Vec<f64>], mu: f64) -> Self {
        let (k, d) = (fields.states.len(), fields.dimension());
        // The vectors are the rows of tractions, those of displacements, and the forms.
        let vectors = Mat::from_fn(d, 6 * k + forms.len(), |i, j| match j {
            j if j < 3 * k => fields.traction[(j, i)],
            j if j < 6 * k => fields.displacement[(j - 3 * k, i)],
            j => forms[j - 6 * k][i],
        });
        let term = |a: usize, b: usize, factor: f64| Term { a, b, factor };
        let traction = |e: usize, component: usize| component * k + e;
        let displacement = |e: usize, component: usize| (3 + component) * k + e;
        let not_open: Vec<usize> =
            (0..k).filter(|&e| fields.states[e] != NormalCase::Open).collect();
        let undecided: Vec<usize> =
            (0..k).filter(|&e| fields.states[e] == NormalCase::Undecided).collect();
        let mut terms: Vec<Vec<Term>> = (0..k)
            .map(|e| [1, 2].map(|c| term(traction(e, c), displacement(e, c), 1.0)).to_vec())
            .collect();
        terms.extend(not_open.iter().map(|&e| vec![term(traction(e, 0), traction(e, 0), -0.5)]));
        terms.extend(
            not_open.iter().map(|&e| {
                [1, 2].map(|c| term(displacement(e, c), displacement(e, c), -0.5)).to_vec()
            }),
        );
        terms
            .extend(undecided.iter().map(|&e| vec![term(traction(e, 0), displacement(e, 0), 1.0)]));
        for b in 0..forms.len() {
            terms.extend((0..b).map(|a| vec![term(6 * k + a, 6 * k + b, -1.0)]));
        }
        let cones = not_open.iter().enumerate().map(|(place, &e)| FrictionCone {
            beta: e,
            p: k + place,
            q: k + not_open.len() + place,
        });
        Self {
            mu,
            elements: k,
            vectors,
            terms,
            cones: cones.collect(),
            undecided: undecided.len(),
            products: forms.len() * forms.len().saturating_sub(1) / 2,
        }
    }

    /// Returns the place of the first weight α.
    fn first_alpha(&self) -> usize {
        self.elements + 2 * self.cones.len()
    }

    /// Returns the place of the first weight of a product.
    fn first_product(&self) -> usize {
        self.first_alpha() + self.undecided
    }

    /// Returns the place of t.
    fn place_of_t(&self) -> usize {
        self.terms.len()
    }

    /// Computes the form at values of the weights and t.
    fn form(&self, values: &[f64]) -> Mat<f64> {
        let d = self.vectors.nrows();
        let count = self.terms.iter().map(Vec::len).sum();
        let (mut left, mut right) = (Mat::zeros(d, count), Mat::zeros(count, d));
        let mut column = 0;
        for (terms, value) in self.terms.iter().zip(values) {
            for term in terms {
                for i in 0..d {
                    left[(i, column)] = term.factor * value * self.vectors[(i, term.a)];
                    right[(column, i)] = self.vectors[(i, term.b)];
                }
                column += 1;
            }
        }
        let half = product(&left, &right);
        let t = values[self.place_of_t()];
        Mat::from_fn(d, d, |i, j| {
            0.5 * (half[(i, j)] + half[(j, i)]) - if i == j { t } else { 0.0 }
        })
    }

    /// Returns pq − μ²β², which is above 0 inside.
    fn slack(&self, cone: &FrictionCone, values: &[f64]) -> f64 {
        values[cone.p] * values[cone.q] - (self.mu * values[cone.beta]).powi(2)
    }

    /// Computes the objective at values, or `None` outside of the feasible set.
    fn evaluate(&self, values: Vec<f64>, kappa: f64) -> Option<ExclusionPoint> {
        let weights = &values[..self.place_of_t()];
        let slacks: Vec<f64> = self.cones.iter().map(|cone| self.slack(cone, &values)).collect();
        if weights.iter().chain(&slacks).any(|value| value.is_nan() || *value <= 0.0) {
            return None;
        }
        let lower = cholesky(self.form(&values))?;
        let mut objective = -values[self.place_of_t()] / kappa;
        objective -= (0..lower.nrows()).map(|i| 2.0 * lower[(i, i)].ln()).sum::<f64>();
        objective -= slacks.iter().map(|slack| slack.ln()).sum::<f64>();
        let alone = (0..self.elements).chain(self.first_alpha()..self.place_of_t());
        objective -= alone.map(|place| values[place].ln()).sum::<f64>();
        objective.is_finite().then_some(ExclusionPoint { values, objective, lower })
    }

    /// Returns values inside of the feasible set, with t below the least eigenvalue of the form.
    fn start(&self) -> Option<ExclusionPoint> {
        let square =
            |j: usize| (0..self.vectors.nrows()).map(|i| self.vectors[(i, j)].powi(2)).sum::<f64>();
        let k = self.elements;
        let mut values = vec![1.0; self.terms.len() + 1];
        for cone in &self.cones {
            let e = cone.beta;
            let tau = ((square(4 * k + e) + square(5 * k + e)) / square(e).max(1e-300)).sqrt();
            (values[cone.p], values[cone.q]) = (1.3 * self.mu * tau, 1.3 * self.mu / tau);
        }
        values[self.first_product()..self.place_of_t()].fill(0.01);
        values[self.place_of_t()] = 0.0;
        // The sum of absolute values in a row bounds the eigenvalues.
        let form = self.form(&values);
        let rows = (0..form.nrows()).map(|i| (0..form.nrows()).map(|j| form[(i, j)].abs()).sum());
        values[self.place_of_t()] = -1.0 - rows.fold(0.0, f64::max);
        self.evaluate(values, FIRST_KAPPA)
    }

    /// Maximises t until it is above 0 or cannot be.
    fn solve(&self) -> Option<ExclusionOutcome> {
        let barriers = (self.vectors.nrows()
            + 2 * self.cones.len()
            + self.elements
            + self.undecided
            + self.products) as f64;
        let mut here = self.start()?;
        let mut kappa = FIRST_KAPPA;
        loop {
            let mut decrement = f64::INFINITY;
            for _ in 0..MOST_STEPS {
                if here.values[self.place_of_t()] > ENOUGH {
                    return Some(ExclusionOutcome::Excluded(self.weights(&here.values)));
                }
                if decrement < 0.2 {
                    break;
                }
                let Some(direction) = self.direction(&here, kappa) else { break };
                decrement = direction.decrement;
                let Some(there) = self.search_along(&here, &direction, kappa) else { break };
                here = there;
            }
            let gap = kappa * barriers;
            let cannot = decrement < 1.0 && here.values[self.place_of_t()] + 1.5 * gap < 0.0;
            if cannot || gap < LAST_GAP {
                let inverse = cholesky_inverse(&here.lower);
                let trace: f64 = (0..inverse.nrows()).map(|i| inverse[(i, i)]).sum();
                let d = inverse.nrows();
                return Some(ExclusionOutcome::Mixture(Mat::from_fn(d, d, |i, j| {
                    inverse[(i, j)] / trace
                })));
            }
            kappa *= 0.2;
            here = self.evaluate(here.values, kappa)?;
        }
    }

    fn weights(&self, values: &[f64]) -> CaseWeights {
        CaseWeights {
            alpha: values[self.first_alpha()..self.first_product()].to_vec(),
            beta: values[..self.elements].to_vec(),
            tau: self.cones.iter().map(|cone| (values[cone.p] / values[cone.q]).sqrt()).collect(),
            products: values[self.first_product()..self.place_of_t()].to_vec(),
        }
    }

    /// Finds a point along the direction at which the objective is smaller.
    fn search_along(
        &self,
        here: &ExclusionPoint,
        direction: &ExclusionStep,
        kappa: f64,
    ) -> Option<ExclusionPoint> {
        let mut length = 1.0;
        while length > 1e-9 {
            let values =
                here.values.iter().zip(&direction.step).map(|(v, d)| v + length * d).collect();
            if let Some(there) = self.evaluate(values, kappa)
                && there.objective <= here.objective - 0.05 * length * direction.decrement
            {
                return Some(there);
            }
            length *= 0.5;
        }
        None
    }

    /// Computes Newton's direction among those that keep Σ β.
    fn direction(&self, here: &ExclusionPoint, kappa: f64) -> Option<ExclusionStep> {
        let count = self.terms.len() + 1;
        let t = self.place_of_t();
        let values = &here.values;
        // With the factor L, the vectors are L⁻¹v and (LLᵀ)⁻¹v.
        let mut once = self.vectors.clone();
        solve_lower(here.lower.as_ref(), &mut once);
        let mut twice = once.clone();
        solve_upper(here.lower.transpose(), &mut twice);
        let gram = product(&once.transpose().to_owned(), &once);
        let inverse = cholesky_inverse(&here.lower);
        let d = inverse.nrows();
        let mut gradient = vec![0.0; count];
        let mut hessian = Mat::<f64>::zeros(count, count);
        for (l, terms) in self.terms.iter().enumerate() {
            for right in terms {
                gradient[l] -= right.factor * gram[(right.a, right.b)];
                let both: f64 = (0..d).map(|i| twice[(i, right.a)] * twice[(i, right.b)]).sum();
                hessian[(t, l)] -= right.factor * both;
            }
            for (m, others) in self.terms.iter().enumerate().skip(l) {
                let mut sum = 0.0;
                for right in terms {
                    for left in others {
                        let straight = gram[(right.a, left.a)] * gram[(right.b, left.b)];
                        let crossed = gram[(right.a, left.b)] * gram[(right.b, left.a)];
                        sum += right.factor * left.factor * 0.5 * (straight + crossed);
                    }
                }
                hessian[(m, l)] = sum;
            }
        }
        gradient[t] = (0..d).map(|i| inverse[(i, i)]).sum::<f64>() - 1.0 / kappa;
        hessian[(t, t)] = (0..d)
            .flat_map(|j| (0..d).map(move |i| (i, j)))
            .map(|place| inverse[place].powi(2))
            .sum();
        for place in (0..self.elements).chain(self.first_alpha()..t) {
            gradient[place] -= 1.0 / values[place];
            hessian[(place, place)] += values[place].powi(-2);
        }
        let square = self.mu * self.mu;
        for cone in &self.cones {
            let slack = self.slack(cone, values);
            let places = [cone.beta, cone.p, cone.q];
            let first = [-2.0 * square * values[cone.beta], values[cone.q], values[cone.p]];
            let second = [[-2.0 * square, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
            for a in 0..3 {
                gradient[places[a]] -= first[a] / slack;
                for b in 0..=a {
                    let (row, column) = (places[a].max(places[b]), places[a].min(places[b]));
                    hessian[(row, column)] += (first[a] * first[b] / slack - second[a][b]) / slack;
                }
            }
        }
        let scale: Vec<f64> = (0..count).map(|i| hessian[(i, i)].sqrt().recip()).collect();
        let lower = cholesky(Mat::from_fn(count, count, |i, j| {
            let value = hessian[(i.max(j), i.min(j))];
            scale[i] * value * scale[j] + if i == j { 1e-12 } else { 0.0 }
        }))?;
        let normal = |i: usize| if i < self.elements { 1.0 } else { 0.0 };
        let mut solved =
            Mat::from_fn(count, 2, |i, j| scale[i] * if j == 0 { -gradient[i] } else { normal(i) });
        cholesky_solve(&lower, &mut solved);
        let sum = |j: usize| (0..self.elements).map(|i| scale[i] * solved[(i, j)]).sum::<f64>();
        let left = self.elements as f64 - values[..self.elements].iter().sum::<f64>();
        let multiplier = (left - sum(0)) / sum(1);
        let step: Vec<f64> =
            (0..count).map(|i| scale[i] * (solved[(i, 0)] + multiplier * solved[(i, 1)])).collect();
        let decrement = -step.iter().zip(&gradient).map(|(s, g)| s * g).sum::<f64>();
        (decrement.is_finite() && decrement > 0.0).then_some(ExclusionStep { step, decrement })
    }
}

/// A direction of Newton's method.
struct ExclusionStep {
    step: Vec<f64>,
    /// The squared decrement, above 0.
    decrement: f64,
}

fn product(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let mut out = Mat::zeros(a.nrows(), b.ncols());
    multiply(out.as_mut(), Accum::Replace, a.as_ref(), b.as_ref(), 1.0);
    out
}
