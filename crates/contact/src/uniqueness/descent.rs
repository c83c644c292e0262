//! Local minimisation of F: least μ under x₁y₁ ≤ 0 and x_t·y_t ≤ μ|x₁||y_t|, by an augmented Lagrangian (J. Nocedal, S. J. Wright, Numerical
//! Optimization, 2nd ed., section 17.4) with Newton's method inside.
//!
//! The Lagrangian is a sum of functions of seven numbers, x and y = Ax at one element and μ. With their 7 × 7 Hessians as blocks of M its
//! Hessian is (I A) M (I A)ᵀ: a matrix for few elements, for many a product with two applications of the operator.
//! It is not definite; as much of the identity is added as makes the step one of descent and the value fall as
//! predicted (Levenberg and Marquardt). The constraints are of second degree in x, whose length a penalty keeps at xᵀAx = k.
//!
//! With a weak coupling κ pressures are of order κ and μ of order 1/κ. So in here x₁ is in units of κ, y₁ in units of 1/κ (which leaves
//! the operator symmetric), the normal constraint is x₁y₁/κ² and μ in units of 1/κ: all are of order one for every κ.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::System;
use super::barrier::cholesky;
use crate::influence::Scratch;

/// Largest number of elements for which Hessians are matrices.
const DENSE: usize = 300;
/// The last penalty, times k, and its growth.
const LAST_PENALTY: f64 = 1e6;
const GROWTH: f64 = 1.3;
/// Weight of the penalty on the length of x.
const LENGTH: f64 = 10.0;
/// Below this |y_t| counts as this in curvatures, which would be unbounded.
const STICK: f64 = 0.03;

/// How far a minimisation is taken.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Updates of the multipliers.
    pub(super) outer: usize,
    /// Newton steps between two of them.
    pub(super) inner: usize,
    /// Largest violation, and relative change of μ, that end it.
    pub(super) tolerance: f64,
    /// The first penalty, times k. A weak one that grows slowly lets a minimisation pass many a poor local minimum.
    pub(super) first_penalty: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { outer: 60, inner: 20, tolerance: 1e-8, first_penalty: 10.0 }
    }
}

/// Value, gradient and Hessian of one element's part in (x, y, μ).
struct Local {
    gradient: [f64; 7],
    hessian: [[f64; 7]; 7],
}

/// Minimisations on one system.
pub(super) struct Descent<'a> {
    system: &'a System,
    scratch: Scratch,
    /// The operator of unit size, for few elements.
    matrix: Option<Mat<f64>>,
    /// 1 over the largest diagonal entry.
    scale: f64,
    /// κ.
    coupling: f64,
    k: usize,
    /// How strictly the constraints are asked for.
    margin: f64,
    /// What μ is measured in.
    unit: f64,
    penalty: f64,
    /// Of the normal constraints, then of the tangential ones.
    multipliers: Vec<f64>,
    y: Vec<f64>,
    values: Vec<f64>,
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl<'a> Descent<'a> {
    /// `coupling` is κ, `margin` how strictly the constraints are asked for.
    pub(super) fn new(system: &'a System, coupling: f64, margin: f64) -> Self {
        let k = system.elements();
        let scale = 1.0 / system.largest_diagonal();
        let matrix = (k <= DENSE).then(|| {
            let mut matrix = system.matrix();
            let unit = |i: usize| if i < k { coupling } else { 1.0 };
            for j in 0..3 * k {
                for i in 0..3 * k {
                    matrix[(i, j)] *= scale * unit(i) * unit(j);
                }
            }
            matrix
        });
        Self {
            scratch: system.scratch(),
            matrix,
            scale,
            coupling,
            k,
            system,
            margin,
            unit: 1.0,
            penalty: 1.0,
            multipliers: vec![0.0; 2 * k],
            y: vec![0.0; 3 * k],
            values: vec![0.0; 2 * k],
        }
    }

    /// out = A x in the units of this module and of the largest diagonal entry.
    fn apply(&mut self, out: &mut [f64], x: &[f64]) {
        match &self.matrix {
            Some(matrix) => {
                let n = x.len();
                let out = faer::MatMut::from_column_major_slice_mut(out, n, 1);
                matmul(out, Accum::Replace, matrix.as_ref(), MatRef::from_column_major_slice(x, n, 1), 1.0, Par::Seq);
            }
            None => {
                let mut x = x.to_vec();
                x[..self.k].iter_mut().for_each(|x| *x *= self.coupling);
                self.system.apply(out, &x, &mut self.scratch);
                out.iter_mut().for_each(|y| *y *= self.scale);
                out[..self.k].iter_mut().for_each(|y| *y *= self.coupling);
            }
        }
    }

    /// y, and the values of the constraints, at a point: x and then μ.
    fn constrain(&mut self, point: &[f64]) {
        let k = self.k;
        let (x, mu) = (&point[..3 * k], point[3 * k]);
        let mut y = std::mem::take(&mut self.y);
        self.apply(&mut y, x);
        for e in 0..k {
            let work = x[k + e] * y[k + e] + x[2 * k + e] * y[2 * k + e];
            self.values[e] = x[e] * y[e] / (self.coupling * self.coupling) + self.margin;
            self.values[k + e] = work - mu * x[e].abs() * y[k + e].hypot(y[2 * k + e]) + self.margin;
        }
        self.y = y;
    }

    /// The largest violation at the point last constrained.
    fn violation(&self) -> f64 {
        self.values.iter().fold(0.0, |most: f64, &c| most.max(c))
    }

    /// The augmented Lagrangian.
    fn value(&mut self, point: &[f64]) -> f64 {
        self.constrain(point);
        let length = dot(&point[..3 * self.k], &self.y) / self.k as f64 - 1.0;
        let mu = point[3 * self.k] / self.unit;
        let forces = self.multipliers.iter().zip(&self.values);
        let sum: f64 = forces.map(|(l, c)| (l + self.penalty * c).max(0.0).powi(2) - l * l).sum();
        0.5 * (mu * mu + LENGTH * length * length + sum / self.penalty)
    }

    /// The gradients of an element's two constraints.
    fn slopes(&self, point: &[f64], e: usize) -> ([f64; 7], [f64; 7]) {
        let (k, mu) = (self.k, point[3 * self.k]);
        let [x1, x2, x3] = [0, 1, 2].map(|c| point[c * k + e]);
        let [y1, y2, y3] = [0, 1, 2].map(|c| self.y[c * k + e]);
        let slip = y2.hypot(y3);
        let n = if slip > 0.0 { [y2 / slip, y3 / slip] } else { [0.0; 2] };
        let (a, sign) = (x1.abs(), if x1 == 0.0 { 0.0 } else { x1.signum() });
        let unit = 1.0 / (self.coupling * self.coupling);
        let normal = [unit * y1, 0.0, 0.0, unit * x1, 0.0, 0.0, 0.0];
        (normal, [-mu * sign * slip, y2, y3, 0.0, x2 - mu * a * n[0], x3 - mu * a * n[1], -a * slip])
    }

    /// An element's part of the Lagrangian, at the point last constrained.
    fn local(&self, point: &[f64], e: usize) -> Local {
        let (k, mu) = (self.k, point[3 * self.k]);
        let [normal, tangential] = [e, k + e].map(|i| (self.multipliers[i] + self.penalty * self.values[i]).max(0.0));
        let (by_normal, by_tangential) = self.slopes(point, e);
        let mut local = Local { gradient: [0.0; 7], hessian: [[0.0; 7]; 7] };
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
        for (force, by) in [(normal, by_normal), (tangential, by_tangential)] {
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

    /// (I A) v for numbers per element in (x, y, μ): what a derivative in those is in the point.
    fn collect(&mut self, locals: impl Iterator<Item = [f64; 7]>, out: &mut [f64]) {
        let k = self.k;
        let mut by_y = vec![0.0; 3 * k];
        let mut by_x = vec![0.0; 3 * k + 1];
        for (e, local) in locals.enumerate() {
            for c in 0..3 {
                by_x[c * k + e] = local[c];
                by_y[c * k + e] = local[3 + c];
            }
            by_x[3 * k] += local[6];
        }
        self.apply(&mut out[..3 * k], &by_y);
        out[3 * k] = 0.0;
        out.iter_mut().zip(&by_x).for_each(|(out, x)| *out += x);
    }

    /// A change of the point as changes in (x, y, μ) per element; `image` is A times its x.
    fn spread<'b>(k: usize, step: &'b [f64], image: &'b [f64]) -> impl Fn(usize) -> [f64; 7] + 'b {
        move |e| [step[e], step[k + e], step[2 * k + e], image[e], image[k + e], image[2 * k + e], step[3 * k]]
    }

    /// Newton's method with as much of the identity as it needs.
    fn descend(&mut self, point: &mut [f64], steps: usize, shift: &mut f64) {
        let (k, n) = (self.k, point.len());
        let mut value = self.value(point);
        let mut gradient = vec![0.0; n];
        for _ in 0..steps {
            let locals: Vec<Local> = (0..k).map(|e| self.local(point, e)).collect();
            self.collect(locals.iter().map(|local| local.gradient), &mut gradient);
            let length = dot(&point[..3 * k], &self.y) / k as f64 - 1.0;
            let along: Vec<f64> = self.y.iter().map(|y| 2.0 * y / k as f64).collect();
            gradient.iter_mut().zip(&along).for_each(|(g, y)| *g += LENGTH * length * y);
            gradient[3 * k] += point[3 * k] / (self.unit * self.unit);
            let size = dot(&gradient, &gradient).sqrt();
            if size < 1e-10 {
                return;
            }
            let matrix = self.matrix.is_some().then(|| self.hessian(&locals, &along, length));
            let mut done = false;
            for _ in 0..12 {
                let step = match &matrix {
                    Some(matrix) => newton_step(matrix, &gradient, *shift),
                    None => Some(self.truncated_step(&locals, &along, length, &gradient, *shift)),
                };
                let Some((step, predicted)) = step else {
                    *shift = (4.0 * *shift).max(1e-6);
                    continue;
                };
                let next: Vec<f64> = point.iter().zip(&step).map(|(x, d)| x + d).collect();
                let there = self.value(&next);
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

    /// The Hessian as a matrix.
    fn hessian(&self, locals: &[Local], along: &[f64], length: f64) -> Mat<f64> {
        let k = self.k;
        let Some(a) = &self.matrix else { return Mat::new() };
        // M_yy A and M_xy A
        let mut left = Mat::zeros(3 * k, 3 * k);
        let mut out = Mat::zeros(3 * k + 1, 3 * k + 1);
        for j in 0..3 * k {
            for e in 0..k {
                let column = [0, 1, 2].map(|c| a[(c * k + e, j)]);
                let h = &locals[e].hessian;
                for c in 0..3 {
                    // half of M_yy, so that the sum with its transpose is the whole
                    left[(c * k + e, j)] =
                        0.5 * (0..3).map(|d| h[3 + c][3 + d] * column[d]).sum::<f64>() + h[3 + c][j / k] * f64::from(u8::from(j % k == e));
                }
            }
        }
        let half = {
            let mut half = Mat::zeros(3 * k, 3 * k);
            matmul(half.as_mut(), Accum::Replace, a.as_ref(), left.as_ref(), 1.0, Par::Seq);
            half
        };
        for j in 0..3 * k {
            for i in 0..=j {
                let own = if i % k == j % k { locals[i % k].hessian[i / k][j / k] } else { 0.0 };
                let value = half[(i, j)] + half[(j, i)] + own + LENGTH * (along[i] * along[j] + length * 2.0 * a[(i, j)] / k as f64);
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
            let value = locals[j % k].hessian[6][j / k] + (0..3 * k).map(|i| a[(i, j)] * mixed[i]).sum::<f64>();
            out[(3 * k, j)] = value;
            out[(j, 3 * k)] = value;
        }
        out[(3 * k, 3 * k)] += 1.0 / (self.unit * self.unit);
        out
    }

    /// Hessian times a change of the point.
    fn curve(&mut self, locals: &[Local], along: &[f64], length: f64, step: &[f64]) -> Vec<f64> {
        let k = self.k;
        let mut image = vec![0.0; 3 * k];
        self.apply(&mut image, &step[..3 * k]);
        let mut out = vec![0.0; 3 * k + 1];
        let of = Self::spread(k, step, &image);
        let product = |(e, local): (usize, &Local)| {
            let v = of(e);
            local.hessian.map(|row| dot(&row, &v))
        };
        let products: Vec<[f64; 7]> = locals.iter().enumerate().map(product).collect();
        self.collect(products.into_iter(), &mut out);
        let across = LENGTH * dot(along, &step[..3 * k]);
        for i in 0..3 * k {
            out[i] += across * along[i] + LENGTH * length * 2.0 * image[i] / k as f64;
        }
        out[3 * k] += step[3 * k] / (self.unit * self.unit);
        out
    }

    /// Conjugate gradients on the shifted Hessian, ended by a direction of negative curvature. With the decrease predicted.
    fn truncated_step(&mut self, locals: &[Local], along: &[f64], length: f64, gradient: &[f64], shift: f64) -> (Vec<f64>, f64) {
        let n = gradient.len();
        let mut step = vec![0.0; n];
        let mut image = vec![0.0; n];
        let mut residual: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let mut p = residual.clone();
        let mut rr = dot(&residual, &residual);
        let target = rr * 1e-4;
        for at in 0..60 {
            let mut hp = self.curve(locals, along, length, &p);
            let own = hp.clone();
            hp.iter_mut().zip(&p).for_each(|(h, p)| *h += shift * p);
            let curvature = dot(&p, &hp);
            if curvature <= 1e-12 * dot(&p, &p) {
                if at == 0 {
                    let length = 1.0 / (shift + 1.0);
                    step.iter_mut().zip(&p).for_each(|(s, p)| *s = length * p);
                    image.iter_mut().zip(&own).for_each(|(s, p)| *s = length * p);
                }
                break;
            }
            let alpha = rr / curvature;
            for i in 0..n {
                step[i] += alpha * p[i];
                image[i] += alpha * own[i];
                residual[i] -= alpha * hp[i];
            }
            let next = dot(&residual, &residual);
            if next < target {
                break;
            }
            p.iter_mut().zip(&residual).for_each(|(p, r)| *p = r + next / rr * *p);
            rr = next;
        }
        let predicted = -dot(gradient, &step) - 0.5 * dot(&step, &image);
        (step, predicted)
    }

    /// x and μ as a point in the units of this module.
    fn enter(&self, x: &[f64], mu: f64) -> Vec<f64> {
        let mut point = x.to_vec();
        point[..self.k].iter_mut().for_each(|x| *x /= self.coupling);
        point.push(mu * self.coupling);
        point
    }

    /// The reverse of [`enter`](Self::enter).
    fn leave(&self, point: &[f64], x: &mut [f64]) -> f64 {
        x.copy_from_slice(&point[..3 * self.k]);
        x[..self.k].iter_mut().for_each(|x| *x *= self.coupling);
        point[3 * self.k] / self.coupling
    }

    /// Minimises from `x`, guessing μ; returns x with xᵀAx near k, and μ. The constraints hold up to a small violation.
    pub(super) fn minimise(&mut self, x: &mut [f64], mu: f64, limits: Limits) -> f64 {
        let k = self.k as f64;
        let mut point = self.enter(x, mu);
        self.constrain(&point);
        let length = (k / dot(&point[..x.len()], &self.y).max(f64::MIN_POSITIVE)).sqrt();
        point[..x.len()].iter_mut().for_each(|x| *x *= length);
        self.multipliers.fill(0.0);
        self.unit = point[x.len()];
        self.penalty = limits.first_penalty / k;
        let mut shift = 1.0 / k;
        let (mut before, mut last) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..limits.outer {
            self.descend(&mut point, limits.inner, &mut shift);
            self.constrain(&point);
            let (violation, mu) = (self.violation(), point[x.len()]);
            for (multiplier, c) in self.multipliers.iter_mut().zip(&self.values) {
                *multiplier = (*multiplier + self.penalty * c).max(0.0);
            }
            if violation < limits.tolerance && (mu - last).abs() < limits.tolerance * mu {
                break;
            }
            if violation > 0.5 * before {
                self.penalty = (GROWTH * self.penalty).min(LAST_PENALTY / k);
            }
            (before, last) = (violation, mu);
        }
        self.leave(&point, x)
    }

    /// Gauss–Newton onto the active constraints, with the least change of the point. The μ reached, if all of them hold
    /// with half of the margin.
    pub(super) fn restore(&mut self, x: &mut [f64], mu: f64) -> Option<f64> {
        let k = self.k;
        let mut point = self.enter(x, mu);
        for _ in 0..12 {
            self.constrain(&point);
            if self.violation() <= 0.5 * self.margin {
                return Some(self.leave(&point, x));
            }
            let slopes: Vec<([f64; 7], [f64; 7])> = (0..k).map(|e| self.slopes(&point, e)).collect();
            let active: Vec<bool> = self.values.iter().map(|&c| c > -10.0 * self.margin).collect();
            let mut residual: Vec<f64> = self.values.iter().zip(&active).map(|(&c, &a)| if a { -c } else { 0.0 }).collect();
            // conjugate gradients on J Jᵀ
            let mut p = residual.clone();
            let mut total = vec![0.0; 3 * k + 1];
            let mut step = vec![0.0; 3 * k + 1];
            let mut image = vec![0.0; 3 * k];
            let mut rr = dot(&residual, &residual);
            let target = rr * 1e-12;
            for _ in 0..400 {
                let pulled = slopes.iter().enumerate().map(|(e, (g, h))| std::array::from_fn(|i| p[e] * g[i] + p[k + e] * h[i]));
                let pulled: Vec<[f64; 7]> = pulled.collect();
                self.collect(pulled.into_iter(), &mut step);
                let norm = dot(&step, &step);
                if rr <= target || norm == 0.0 {
                    break;
                }
                let alpha = rr / norm;
                self.apply(&mut image, &step[..3 * k]);
                let of = Self::spread(k, &step, &image);
                for (e, (normal, tangential)) in slopes.iter().enumerate() {
                    let v = of(e);
                    for (i, slope) in [(e, normal), (k + e, tangential)] {
                        if active[i] {
                            residual[i] -= alpha * dot(slope, &v);
                        }
                    }
                }
                total.iter_mut().zip(&step).for_each(|(t, s)| *t += alpha * s);
                let next = dot(&residual, &residual);
                p.iter_mut().zip(&residual).for_each(|(p, r)| *p = r + next / rr * *p);
                rr = next;
            }
            point.iter_mut().zip(&total).for_each(|(x, d)| *x += d);
        }
        None
    }
}

/// −(H + shift I)⁻¹ g and the decrease that the quadratic model predicts, if that matrix is positive definite.
fn newton_step(matrix: &Mat<f64>, gradient: &[f64], shift: f64) -> Option<(Vec<f64>, f64)> {
    let n = gradient.len();
    let mut shifted = matrix.clone();
    for i in 0..n {
        shifted[(i, i)] += shift;
    }
    let lower = cholesky(shifted)?;
    let mut step = Mat::from_fn(n, 1, |i, _| -gradient[i]);
    lower.solve_lower_triangular_in_place(step.as_mut());
    lower.transpose().solve_upper_triangular_in_place(step.as_mut());
    let step: Vec<f64> = (0..n).map(|i| step[(i, 0)]).collect();
    // with H s = −g − shift s
    let predicted = -0.5 * dot(gradient, &step) + 0.5 * shift * dot(&step, &step);
    Some((step, predicted))
}
