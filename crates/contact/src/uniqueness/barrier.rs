//! The weights that make the lower bound of μ* largest, by an interior-point method.
//!
//! With p = μβτ and q = μβ/τ the form F = sym(αΠ₁A) + sym(βΠ_tA) − ½(pΠ₁ + AᵀqΠ_tA) is linear in
//! the weights, and μβ ≤ √(pq) is a cone. So for fixed μ the weights that serve are a convex set,
//! and the largest μ is a quasi-convex program. The interior-point method maximises t at a given μ,
//! subject to F ≻ 0 and μβ ≤ √((p − tp₀)(q − tq₀)), with logarithmic barriers and Newton's method.
//! It follows the path a little, takes the gain of t into μ, and goes on. The derivatives need no
//! more than F⁻¹, F⁻¹A and AF⁻¹A. No proof relies on this method, for [`super::lower`] checks the
//! outcome.

use faer::{Accum, Mat};
use primitives::{cholesky, cholesky_inverse, cholesky_solve, multiply};
use rayon::prelude::*;

use super::symmetry::Block;

/// Weights: one number for each orbit of elements, p = μβτ and q = μβ/τ.
#[derive(Clone, Debug)]
pub(super) struct Weights {
    pub(super) alpha: Vec<f64>,
    pub(super) beta: Vec<f64>,
    pub(super) p: Vec<f64>,
    pub(super) q: Vec<f64>,
}

impl Weights {
    /// Creates weights with the same α and τ everywhere, and β = 1.
    pub(super) fn uniform(orbits: usize, mu: f64, alpha: f64, tau: f64) -> Self {
        Self {
            alpha: vec![alpha; orbits],
            beta: vec![1.0; orbits],
            p: vec![mu * tau; orbits],
            q: vec![mu / tau; orbits],
        }
    }

    /// Returns √(pq)/β, the μ that an orbit allows.
    pub(super) fn mu(&self, orbit: usize) -> f64 {
        (self.p[orbit] * self.q[orbit]).sqrt() / self.beta[orbit]
    }

    pub(super) fn tau(&self) -> Vec<f64> {
        self.p.iter().zip(&self.q).map(|(p, q)| (p / q).sqrt()).collect()
    }
}

/// The squares that a case adds to the form of an orbit, with these weights.
#[derive(Clone, Debug)]
pub(super) struct NormalPenalty {
    /// The weight κ_u of y₁² for each orbit.
    pub(super) displacement: Vec<f64>,
    /// The weight κ_s of x₁² for each orbit.
    pub(super) pressure: Vec<f64>,
}

impl NormalPenalty {
    /// Adds the squares of a block to its form.
    fn add_to(&self, form: &mut Mat<f64>, block: &Block) {
        let normals = block.normal.iter().filter(|&&normal| normal).count();
        for n in 0..normals {
            let orbit = block.orbit[n];
            form[(n, n)] += self.pressure[orbit];
            let weight = self.displacement[orbit];
            if weight > 0.0 {
                for j in 0..block.len() {
                    for i in 0..block.len() {
                        form[(i, j)] += weight * block.matrix[(i, n)] * block.matrix[(j, n)];
                    }
                }
            }
        }
    }
}

/// Computes the form F of a block, with the squares of a case if there is one.
pub(super) fn form(block: &Block, weights: &Weights, penalty: Option<&NormalPenalty>) -> Mat<f64> {
    let size = block.len();
    let normals = block.normal.iter().filter(|&&normal| normal).count();
    // The basis vectors of pressures come first.
    let roots = Mat::from_fn(size - normals, size, |i, j| {
        weights.q[block.orbit[normals + i]].sqrt() * block.matrix[(normals + i, j)]
    });
    let diagonal: Vec<f64> =
        (0..size)
            .map(|i| {
                if i < normals {
                    weights.alpha[block.orbit[i]]
                } else {
                    weights.beta[block.orbit[i]]
                }
            })
            .collect();
    let mut form =
        Mat::from_fn(size, size, |i, j| 0.5 * (diagonal[i] + diagonal[j]) * block.matrix[(i, j)]);
    for i in 0..normals {
        form[(i, i)] -= 0.5 * weights.p[block.orbit[i]];
    }
    multiply(form.as_mut(), Accum::Add, roots.transpose(), roots.as_ref(), -0.5);
    if let Some(penalty) = penalty {
        penalty.add_to(&mut form, block);
    }
    form
}

/// Returns log det of LLᵀ.
fn log_det(lower: &Mat<f64>) -> f64 {
    (0..lower.nrows()).map(|i| 2.0 * lower[(i, i)].ln()).sum()
}

/// Derivatives of −log det F with respect to α, β, p, q of all m orbits, in this order.
struct Derivatives {
    /// The 4m first derivatives.
    gradient: Vec<f64>,
    /// The 4m × 4m second derivatives.
    hessian: Mat<f64>,
}

/// Computes the derivatives of −log det F for a block with the factor `lower`.
fn derivatives(block: &Block, lower: &Mat<f64>, orbits: usize) -> Derivatives {
    let size = block.len();
    let inverse = cholesky_inverse(lower);
    let product = |a: &Mat<f64>, b: &Mat<f64>| {
        let mut out = Mat::zeros(size, size);
        multiply(out.as_mut(), Accum::Replace, a.as_ref(), b.as_ref(), 1.0);
        out
    };
    let once = product(&inverse, &block.matrix);
    let twice = product(&block.matrix, &once);
    // The derivative dF for basis vector i is ½(eaᵀ + aeᵀ) for α or β, −½eeᵀ for p and −½aaᵀ for q,
    // with a = Ae.
    let place = |i: usize| {
        let (linear, square) = if block.normal[i] { (0, 2) } else { (1, 3) };
        (linear * orbits + block.orbit[i], square * orbits + block.orbit[i])
    };
    let mut gradient = vec![0.0; 4 * orbits];
    let mut hessian = Mat::zeros(4 * orbits, 4 * orbits);
    for j in 0..size {
        let (linear_j, square_j) = place(j);
        gradient[linear_j] -= once[(j, j)];
        gradient[square_j] += 0.5 * if block.normal[j] { inverse[(j, j)] } else { twice[(j, j)] };
        for i in 0..size {
            let (linear_i, square_i) = place(i);
            let (g, h, ht, k) = (inverse[(i, j)], once[(i, j)], once[(j, i)], twice[(i, j)]);
            hessian[(linear_i, linear_j)] += 0.5 * (h * ht + k * g);
            let mixed = -0.5 * if block.normal[j] { ht * g } else { h * k };
            hessian[(linear_i, square_j)] += mixed;
            hessian[(square_j, linear_i)] += mixed;
            let root = match (block.normal[i], block.normal[j]) {
                (true, true) => g,
                (true, false) => h,
                (false, true) => ht,
                (false, false) => k,
            };
            hessian[(square_i, square_j)] += 0.25 * root * root;
        }
    }
    Derivatives { gradient, hessian }
}

/// A program for the largest μ: the blocks of the operator, and the orbits that share weights.
pub(super) struct Program<'a> {
    /// The blocks, whose orbits number the weights.
    pub(super) blocks: &'a [Block],
    /// The number of elements in each orbit.
    pub(super) sizes: &'a [usize],
    /// The squares of a case.
    pub(super) penalty: Option<&'a NormalPenalty>,
}

/// A point of Newton's method: the weights, of which p and q contain t p₀ and t q₀, and t.
struct Point {
    weights: Weights,
    t: f64,
}

/// One problem along the path: the data of −t/κ + barriers besides the weights.
struct BarrierStage<'a> {
    mu: f64,
    kappa: f64,
    p: &'a [f64],
    q: &'a [f64],
}

/// The value of −t/κ + barriers at a point, with the factors of the blocks there.
struct Evaluation {
    /// The value.
    value: f64,
    /// The lower triangular factors of F, one for each block.
    factors: Vec<Mat<f64>>,
}

/// A step of Newton's method.
struct NewtonStep {
    /// The direction in (α, β, p, q, t): m numbers for each of the weights and one for t.
    direction: Vec<f64>,
    /// The squared decrement, above 0.
    decrement: f64,
}

impl Program<'_> {
    /// Returns weights whose μ no others exceed by much more than the relative `tolerance`. The
    /// `start` must be feasible, or else the result is `None`.
    pub(super) fn maximise(&self, start: Weights, tolerance: f64) -> Option<Weights> {
        self.maximise_until(start, tolerance, f64::INFINITY)
    }

    /// Returns weights like [`maximise`](Self::maximise), or the first ones with which μ is
    /// `enough`.
    pub(super) fn maximise_until(
        &self,
        start: Weights,
        tolerance: f64,
        enough: f64,
    ) -> Option<Weights> {
        let orbits = self.sizes.len();
        let degree = (self.blocks.iter().map(Block::len).sum::<usize>() + 6 * orbits + 1) as f64;
        let least =
            |weights: &Weights| (0..orbits).map(|o| weights.mu(o)).fold(f64::INFINITY, f64::min);
        let mut mu = 0.9 * least(&start);
        let mut kappa = 3.0 / degree;
        let mut point = Point { weights: start, t: 0.0 };
        self.factors(&point.weights)?;
        loop {
            let tau = point.weights.tau();
            let p: Vec<f64> =
                point.weights.beta.iter().zip(&tau).map(|(beta, tau)| beta * tau).collect();
            let q: Vec<f64> =
                point.weights.beta.iter().zip(&tau).map(|(beta, tau)| beta / tau).collect();
            let stage = BarrierStage { mu, kappa: kappa * mu, p: &p, q: &q };
            self.center(&stage, &mut point);

            point.t = 0.0;
            let next = least(&point.weights);
            if kappa * degree < tolerance || next >= enough || !next.is_finite() {
                return Some(point.weights);
            }
            // While κ is large, the barriers may push back below the start.
            mu = if next > mu { mu + 0.9 * (next - mu) } else { 0.9 * next };
            kappa *= 0.3;
        }
    }

    fn factors(&self, weights: &Weights) -> Option<Vec<Mat<f64>>> {
        self.blocks.par_iter().map(|block| cholesky(form(block, weights, self.penalty))).collect()
    }

    /// Computes −t/κ + barriers and the factors of the blocks, or `None` outside of the feasible
    /// set.
    fn value(&self, stage: &BarrierStage, point: &Point) -> Option<Evaluation> {
        let Weights { alpha, beta, p, q } = &point.weights;
        let mut value = -point.t / stage.kappa;
        let mut left = self.budget();
        for o in 0..self.sizes.len() {
            let (less_p, less_q) = (p[o] - point.t * stage.p[o], q[o] - point.t * stage.q[o]);
            let cone = less_p * less_q - (stage.mu * beta[o]).powi(2);
            left -= self.sizes[o] as f64 * beta[o];
            let positive = [alpha[o], beta[o], p[o], q[o]];
            if !(positive.iter().all(|&value| value > 0.0)
                && less_p > 0.0
                && less_q > 0.0
                && cone > 0.0)
            {
                return None;
            }
            value -= cone.ln() + positive.iter().map(|value| value.ln()).sum::<f64>();
        }
        if left.is_nan() || left <= 0.0 {
            return None;
        }
        value -= left.ln();
        let factors = self.factors(&point.weights)?;
        value -= factors.iter().map(log_det).sum::<f64>();
        value.is_finite().then_some(Evaluation { value, factors })
    }

    /// Returns the bound on the sum of β over all elements. F is homogeneous in the weights, and
    /// this bound fixes their scale.
    fn budget(&self) -> f64 {
        2.0 * self.sizes.iter().sum::<usize>() as f64
    }

    /// Finds the minimum of [`Self::value`] by Newton's method.
    fn center(&self, stage: &BarrierStage, point: &mut Point) {
        let m = self.sizes.len();
        let Some(mut here) = self.value(stage, point) else { return };
        for _ in 0..60 {
            let Some(step) = self.step(stage, point, &here.factors) else { return };
            let NewtonStep { direction, decrement } = step;
            let mut length = 1.0;
            let moved = loop {
                let shift = |values: &[f64], weight: usize| {
                    let direction = &direction[weight * m..];
                    values.iter().zip(direction).map(|(v, d)| v + length * d).collect()
                };
                let trial = Point {
                    weights: Weights {
                        alpha: shift(&point.weights.alpha, 0),
                        beta: shift(&point.weights.beta, 1),
                        p: shift(&point.weights.p, 2),
                        q: shift(&point.weights.q, 3),
                    },
                    t: point.t + length * direction[4 * m],
                };
                if let Some(there) = self.value(stage, &trial)
                    && there.value <= here.value - 0.1 * length * decrement
                {
                    *point = trial;
                    break Some(there);
                }
                length *= 0.5;
                if length < 1e-6 {
                    break None;
                }
            };
            match moved {
                Some(there) => here = there,
                None => {
                    return;
                }
            }

            if decrement < 0.1 {
                return;
            }
        }
    }

    /// Computes Newton's direction and its squared decrement.
    fn step(
        &self,
        stage: &BarrierStage,
        point: &Point,
        factors: &[Mat<f64>],
    ) -> Option<NewtonStep> {
        let m = self.sizes.len();
        let blocks: Vec<Derivatives> = self
            .blocks
            .par_iter()
            .zip(factors)
            .map(|(block, lower)| derivatives(block, lower, m))
            .collect();
        let mut gradient = vec![0.0; 4 * m + 1];
        let mut hessian = Mat::<f64>::zeros(4 * m + 1, 4 * m + 1);
        for block in &blocks {
            for j in 0..4 * m {
                gradient[j] += block.gradient[j];
                for i in 0..4 * m {
                    hessian[(i, j)] += block.hessian[(i, j)];
                }
            }
        }
        let Weights { alpha, beta, p, q } = &point.weights;
        gradient[4 * m] -= 1.0 / stage.kappa;
        let left = self.budget()
            - self.sizes.iter().zip(beta).map(|(&size, beta)| size as f64 * beta).sum::<f64>();
        for o in 0..m {
            for (weight, value) in [alpha[o], beta[o], p[o], q[o]].into_iter().enumerate() {
                let place = weight * m + o;
                gradient[place] -= 1.0 / value;
                hessian[(place, place)] += value.powi(-2);
            }
            gradient[m + o] += self.sizes[o] as f64 / left;
            for other in 0..m {
                hessian[(m + o, m + other)] +=
                    (self.sizes[o] * self.sizes[other]) as f64 / (left * left);
            }
            // The term is −log(PQ − μ²β²) with P = p − tp₀ and Q = q − tq₀, and the places are
            // those of β, p, q, t.
            let (p0, q0, mu2) = (stage.p[o], stage.q[o], stage.mu * stage.mu);
            let (p, q) = (p[o] - point.t * p0, q[o] - point.t * q0);
            let cone = p * q - mu2 * beta[o] * beta[o];
            let places = [m + o, 2 * m + o, 3 * m + o, 4 * m];
            let first = [-2.0 * mu2 * beta[o], q, p, -(p0 * q + q0 * p)];
            let mut second = [[0.0; 4]; 4];
            second[0][0] = -2.0 * mu2;
            second[1][2] = 1.0;
            second[1][3] = -q0;
            second[2][3] = -p0;
            second[3][3] = 2.0 * p0 * q0;
            for a in 0..4 {
                gradient[places[a]] -= first[a] / cone;
                for b in 0..4 {
                    let curvature = if a <= b { second[a][b] } else { second[b][a] };
                    hessian[(places[a], places[b])] +=
                        (first[a] * first[b] / cone - curvature) / cone;
                }
            }
        }
        // The matrix is scaled to a unit diagonal, for p and q differ by the square of a length.
        let scale: Vec<f64> = (0..4 * m + 1).map(|i| hessian[(i, i)].sqrt().recip()).collect();
        let lower = cholesky(Mat::from_fn(4 * m + 1, 4 * m + 1, |i, j| {
            scale[i] * hessian[(i, j)] * scale[j] + if i == j { 1e-13 } else { 0.0 }
        }))?;
        let mut direction = Mat::from_fn(4 * m + 1, 1, |i, _| -scale[i] * gradient[i]);
        cholesky_solve(&lower, &mut direction);
        let direction: Vec<f64> = (0..4 * m + 1).map(|i| scale[i] * direction[(i, 0)]).collect();
        let decrement = -direction.iter().zip(&gradient).map(|(d, g)| d * g).sum::<f64>();
        (decrement.is_finite() && decrement > 0.0).then_some(NewtonStep { direction, decrement })
    }
}
