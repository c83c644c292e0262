//! Newton's method for the augmented Lagrangian of few elements, whose Hessian is a matrix.
//!
//! The Lagrangian is a sum of functions of seven numbers: x and y = Ax at one element, and μ. With
//! their 7 × 7 Hessians as blocks of M its Hessian is (I A) M (I A)ᵀ. It is not definite. So much
//! of the identity is added that the step is one of descent and the value falls as predicted
//! (Levenberg and Marquardt).

use faer::{Accum, Mat};
use primitives::{cholesky, multiply, solve_lower, solve_upper};

use super::descent::{Descent, LENGTH};
use super::system::dot;

/// The |y_t| that replaces a smaller one in curvatures, which would be unbounded.
const STICK: f64 = 0.03;

/// The gradient and the Hessian of one element's term in (x, y, μ).
struct ElementDerivatives {
    gradient: [f64; 7],
    hessian: [[f64; 7]; 7],
}

impl Descent<'_> {
    /// Computes the term of an element in the Lagrangian, at the point last constrained.
    fn local(&self, point: &[f64], e: usize) -> ElementDerivatives {
        let (k, mu) = (self.k, point[3 * self.k]);
        let [normal, tangential] =
            [e, k + e].map(|i| (self.multipliers[i] + self.penalty * self.values[i]).max(0.0));
        let slopes = self.slopes(point, e);
        let mut local = ElementDerivatives { gradient: [0.0; 7], hessian: [[0.0; 7]; 7] };
        let mut add = |i: usize, j: usize, value: f64| {
            local.hessian[i][j] += value;
            if i != j {
                local.hessian[j][i] += value;
            }
        };
        if normal > 0.0 {
            add(0, 3, normal / (self.coupling * self.coupling));
        }
        if tangential > 0.0 {
            let (x1, y2, y3) = (point[e], self.y[k + e], self.y[2 * k + e]);
            let slip = y2.hypot(y3).max(f64::MIN_POSITIVE);
            let n = [y2 / slip, y3 / slip];
            let (a, sign) = (x1.abs(), if x1 == 0.0 { 0.0 } else { x1.signum() });
            let bend = tangential * mu * a / slip.max(STICK);
            for (c, n) in n.into_iter().enumerate() {
                add(1 + c, 4 + c, tangential);
                add(0, 4 + c, -tangential * mu * sign * n);
                add(4 + c, 6, -tangential * a * n);
                add(4 + c, 4 + c, -bend * (1.0 - n * n));
            }
            add(4, 5, bend * n[0] * n[1]);
            add(0, 6, -tangential * sign * slip);
        }
        for (force, by) in [(normal, slopes.normal), (tangential, slopes.tangential)] {
            if force > 0.0 {
                for i in 0..7 {
                    local.gradient[i] += force * by[i];
                    for j in 0..7 {
                        local.hessian[i][j] += self.penalty * by[i] * by[j];
                    }
                }
            }
        }
        local
    }

    /// Computes the augmented Lagrangian.
    fn lagrangian(&mut self, point: &[f64]) -> f64 {
        self.constrain(point);
        let length = dot(&point[..3 * self.k], &self.y) / self.k as f64 - 1.0;
        let mu = point[3 * self.k];
        let forces = self.multipliers.iter().zip(&self.values);
        let sum: f64 = forces.map(|(l, c)| (l + self.penalty * c).max(0.0).powi(2) - l * l).sum();
        0.5 * (mu * mu / self.unit + sum / self.penalty) + 0.5 * LENGTH * length * length
    }

    /// Runs at most `steps` steps of Newton's method from `point`. The `shift` is the multiple of
    /// the identity that is added, kept from step to step.
    pub(super) fn descend(
        &mut self,
        a: &Mat<f64>,
        point: &mut [f64],
        steps: usize,
        shift: &mut f64,
    ) {
        let (k, n) = (self.k, point.len());
        let mut value = self.lagrangian(point);
        let mut gradient = vec![0.0; n];
        for _ in 0..steps {
            let locals: Vec<ElementDerivatives> = (0..k).map(|e| self.local(point, e)).collect();
            self.collect(locals.iter().map(|local| local.gradient), &mut gradient);
            let length = dot(&point[..3 * k], &self.y) / k as f64 - 1.0;
            let along: Vec<f64> = self.y.iter().map(|y| 2.0 * y / k as f64).collect();
            gradient.iter_mut().zip(&along).for_each(|(g, y)| *g += LENGTH * length * y);
            gradient[3 * k] += point[3 * k] / self.unit;
            let size = dot(&gradient, &gradient).sqrt();
            if size < 1e-10 {
                return;
            }
            let matrix = self.hessian(a, &locals, &along, length);
            let mut done = false;
            for _ in 0..12 {
                let step = newton_step(&matrix, &gradient, *shift);
                let Some(PredictedStep { step, predicted }) = step else {
                    *shift = (4.0 * *shift).max(1e-6);
                    continue;
                };
                let next: Vec<f64> = point.iter().zip(&step).map(|(x, d)| x + d).collect();
                let there = self.lagrangian(&next);
                let ratio = (value - there) / predicted;
                if there < value && ratio > 0.01 {
                    done = value - there < 1e-13 * value;
                    point.copy_from_slice(&next);
                    value = there;
                    if ratio > 0.7 {
                        *shift *= 0.3;
                    } else if ratio < 0.2 {
                        *shift *= 3.0;
                    }
                    break;
                }
                *shift = (4.0 * *shift).max(1e-6);
                done = *shift > 1e12;
                if done {
                    break;
                }
            }
            if done {
                self.constrain(point);
                return;
            }
            self.constrain(point);
        }
    }

    /// Computes the Hessian as a matrix.
    fn hessian(
        &self,
        a: &Mat<f64>,
        locals: &[ElementDerivatives],
        along: &[f64],
        length: f64,
    ) -> Mat<f64> {
        let k = self.k;
        // The matrix `left` collects M_yy A and M_xy A.
        let mut left = Mat::zeros(3 * k, 3 * k);
        let mut out = Mat::zeros(3 * k + 1, 3 * k + 1);
        for j in 0..3 * k {
            for e in 0..k {
                let column = [0, 1, 2].map(|c| a[(c * k + e, j)]);
                let h = &locals[e].hessian;
                for c in 0..3 {
                    // Half of M_yy makes the sum with its transpose the whole.
                    left[(c * k + e, j)] = 0.5
                        * (0..3).map(|d| h[3 + c][3 + d] * column[d]).sum::<f64>()
                        + h[3 + c][j / k] * f64::from(u8::from(j % k == e));
                }
            }
        }
        let half = {
            let mut half = Mat::zeros(3 * k, 3 * k);
            multiply(half.as_mut(), Accum::Replace, a.as_ref(), left.as_ref(), 1.0);
            half
        };
        for j in 0..3 * k {
            for i in 0..=j {
                let local = if i % k == j % k { locals[i % k].hessian[i / k][j / k] } else { 0.0 };
                let value = half[(i, j)]
                    + half[(j, i)]
                    + local
                    + LENGTH * (along[i] * along[j] + length * 2.0 * a[(i, j)] / k as f64);
                out[(i, j)] = value;
                out[(j, i)] = value;
            }
        }
        let mut mixed = vec![0.0; 3 * k];
        for (e, local) in locals.iter().enumerate() {
            out[(3 * k, 3 * k)] += local.hessian[6][6];
            for c in 0..3 {
                mixed[c * k + e] = local.hessian[6][3 + c];
            }
        }
        for j in 0..3 * k {
            let value = locals[j % k].hessian[6][j / k]
                + (0..3 * k).map(|i| a[(i, j)] * mixed[i]).sum::<f64>();
            out[(3 * k, j)] = value;
            out[(j, 3 * k)] = value;
        }
        out[(3 * k, 3 * k)] += 1.0 / self.unit;
        out
    }
}

/// A step with the decrease that the quadratic model predicts for it.
struct PredictedStep {
    /// The change of the point.
    step: Vec<f64>,
    /// The predicted decrease of the Lagrangian.
    predicted: f64,
}

/// Computes −(H + shift I)⁻¹ g and the decrease that the quadratic model predicts, if that matrix
/// is positive definite.
fn newton_step(matrix: &Mat<f64>, gradient: &[f64], shift: f64) -> Option<PredictedStep> {
    let n = gradient.len();
    let mut shifted = matrix.clone();
    for i in 0..n {
        shifted[(i, i)] += shift;
    }
    let lower = cholesky(shifted)?;
    let mut step = Mat::from_fn(n, 1, |i, _| -gradient[i]);
    solve_lower(lower.as_ref(), &mut step);
    solve_upper(lower.transpose(), &mut step);
    let step: Vec<f64> = (0..n).map(|i| step[(i, 0)]).collect();
    // The prediction uses H s = −g − shift s.
    let predicted = -0.5 * dot(gradient, &step) + 0.5 * shift * dot(&step, &step);
    Some(PredictedStep { step, predicted })
}
