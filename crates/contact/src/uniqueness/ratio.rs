//! The smallest ratio xᵀSx / xᵀTx of the two terms of F(μ) = S − μT. It is the μ at which F ceases
//! to be positive definite, found by iteration with the operator as it is applied by FFT.
//!
//! Locally optimal conjugate gradients minimise the ratio: each step takes the best combination of
//! x, of the gradient and of the step before (Knyazev, SIAM J. Sci. Comput. 23, 2001). The ratio of
//! any x is an *upper* bound of that μ, and is close to it by the square of what x lacks. The
//! residual tells how close, as long as the iteration has not missed the lowest mode altogether.
//! Only a factorisation can tell that.

use super::system::{System, dot};
use crate::influence::Scratch;

/// The weights α, β, P = βτ and Q = β/τ per element of Ω.
pub(super) struct Parts {
    pub(super) alpha: Vec<f64>,
    pub(super) beta: Vec<f64>,
    pub(super) p: Vec<f64>,
    pub(super) q: Vec<f64>,
}

/// The result of the iteration.
pub(super) struct Smallest {
    /// The ratio xᵀSx / xᵀTx.
    pub(super) ratio: f64,
    /// The residual ‖Sx − ratio·Tx‖ / ‖Sx‖.
    pub(super) residual: f64,
}

/// A vector with its images under S and T.
#[derive(Clone)]
struct Mode {
    /// The vector x.
    x: Vec<f64>,
    /// The image Sx.
    s: Vec<f64>,
    /// The image Tx.
    t: Vec<f64>,
}

impl Mode {
    fn of(system: &System, parts: &Parts, x: Vec<f64>, scratch: &mut Scratch) -> Self {
        let k = system.elements();
        let times = |normal: &[f64], tangential: &[f64], x: &[f64]| -> Vec<f64> {
            x.iter()
                .enumerate()
                .map(|(i, x)| x * if i < k { normal[i] } else { tangential[i % k] })
                .collect()
        };
        let mut image = |x: &[f64]| {
            let mut y = vec![0.0; 3 * k];
            system.apply(&mut y, x, scratch);
            y
        };
        let none = vec![0.0; k];
        let y = image(&x);
        let (left, right) =
            (times(&parts.alpha, &parts.beta, &y), image(&times(&parts.alpha, &parts.beta, &x)));
        let (square, twice) = (times(&parts.p, &none, &x), image(&times(&none, &parts.q, &y)));
        let mean = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
        let (s, t) = (mean(&left, &right), mean(&square, &twice));
        Self { x, s, t }
    }

    fn add(&mut self, factor: f64, other: &Self) {
        for (field, other) in
            [(&mut self.x, &other.x), (&mut self.s, &other.s), (&mut self.t, &other.t)]
        {
            field.iter_mut().zip(other).for_each(|(value, other)| *value += factor * other);
        }
    }

    fn scale(&mut self, factor: f64) {
        for field in [&mut self.x, &mut self.s, &mut self.t] {
            field.iter_mut().for_each(|value| *value *= factor);
        }
    }
}

/// Finds the smallest ratio, from `x`, which becomes the vector that has it. It ends when the
/// residual is below `tolerance` or after `steps` steps. It is `None` if S turns out to be
/// indefinite.
pub(super) fn smallest(
    system: &System,
    parts: &Parts,
    x: &mut Vec<f64>,
    tolerance: f64,
    steps: usize,
) -> Option<Smallest> {
    let mut scratch = system.scratch();
    let mut mode = Mode::of(system, parts, std::mem::take(x), &mut scratch);
    let mut before: Option<Mode> = None;
    let mut found = Smallest { ratio: f64::INFINITY, residual: f64::INFINITY };
    for step in 0..=steps {
        mode.scale(dot(&mode.x, &mode.x).sqrt().recip());
        let (s, t) = (&mode.s, &mode.t);
        let form = dot(&mode.x, s);
        if form.is_nan() || form <= 0.0 {
            *x = std::mem::take(&mut mode.x);
            return None;
        }
        let ratio = form / dot(&mode.x, t);
        let gradient: Vec<f64> = s.iter().zip(t).map(|(s, t)| s - ratio * t).collect();
        found = Smallest { ratio, residual: (dot(&gradient, &gradient) / dot(s, s)).sqrt() };
        if found.residual <= tolerance || step == steps {
            break;
        }
        let mut basis = vec![mode.clone(), Mode::of(system, parts, gradient, &mut scratch)];
        basis.extend(before.take());
        let Some(factors) = best(&mut basis) else {
            *x = std::mem::take(&mut mode.x);
            return None;
        };
        let mut next = basis[0].clone();
        next.scale(factors[0]);
        let mut moved = basis[1].clone();
        moved.scale(factors[1]);
        if let (Some(third), Some(&factor)) = (basis.get(2), factors.get(2)) {
            moved.add(factor, third);
        }
        next.add(1.0, &moved);
        before = Some(moved);
        mode = next;
    }
    *x = std::mem::take(&mut mode.x);
    Some(found)
}

/// Makes the vectors orthonormal, and returns the combination of them with the smallest ratio.
fn best(basis: &mut Vec<Mode>) -> Option<Vec<f64>> {
    let mut next = 0;
    while next < basis.len() {
        let before = dot(&basis[next].x, &basis[next].x);
        for _ in 0..2 {
            for other in 0..next {
                let (done, rest) = basis.split_at_mut(next);
                let along = dot(&done[other].x, &rest[0].x);
                rest[0].add(-along, &done[other]);
            }
        }
        let size = dot(&basis[next].x, &basis[next].x);
        if size > 1e-24 * before {
            basis[next].scale(size.sqrt().recip());
            next += 1;
        } else {
            basis.remove(next);
        }
    }
    let size = basis.len();
    if size < 2 {
        return Some(vec![1.0, 0.0][..size].to_vec());
    }
    let gram = |image: fn(&Mode) -> &[f64]| {
        faer::Mat::from_fn(size, size, |i, j| {
            0.5 * (dot(&basis[i].x, image(&basis[j])) + dot(&basis[j].x, image(&basis[i])))
        })
    };
    // The combination belongs to the largest eigenvalue of L⁻¹TL⁻ᵀ, where S = LLᵀ.
    let lower = primitives::cholesky(gram(|mode| &mode.s))?;
    let solve = |mut right: faer::Mat<f64>| {
        primitives::solve_lower(lower.as_ref(), &mut right);
        right
    };
    let half = solve(gram(|mode| &mode.t));
    let pencil = solve(half.transpose().to_owned());
    let vectors = primitives::eigenvectors(&pencil)?;
    let mut factors = faer::Mat::from_fn(size, 1, |i, _| vectors[(i, size - 1)]);
    primitives::solve_upper(lower.transpose(), &mut factors);
    Some((0..size).map(|i| factors[(i, 0)]).collect())
}
