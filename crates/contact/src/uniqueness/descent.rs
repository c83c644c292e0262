//! Local minimisation of F: the least μ under x₁y₁ ≤ 0 and x_t·y_t ≤ μ|x₁||y_t|, by an augmented
//! Lagrangian (J. Nocedal, S. J. Wright, Numerical Optimization, 2nd ed., section 17.4). The inner
//! method is a quasi-Newton method ([`lbfgs`]) or Newton's ([`newton`](super::newton)), which ends
//! lower and needs a matrix.
//!
//! The sum of the constraints with equal weights is Σ αx₁y₁ + x_t·y_t ≤ μ Σ|x₁||y_t| with α = 1, or
//! more for a weak coupling. So the ratio of the two sides is minimised first, which is a smooth
//! problem but for kinks. Where that ends, the equal weights are the first multipliers, and the
//! penalty grows slowly from there. This passes many a poor local minimum in which a start with
//! zero multipliers or a strong penalty ends.
//!
//! With few elements, random starts or fields far from a stripe the ratio says too little. There
//! multipliers and penalty begin low, and the inner method is Newton's.
//!
//! The first guess of the Hessian's inverse is the inverse of A's diagonal blocks. Without it, or
//! with another power of A, the same effort ends a tenth higher. The constraints are of second
//! degree in x, whose length a penalty keeps at xᵀAx = k.
//!
//! With a weak coupling κ pressures are of order κ and μ is of order 1/κ. So in this module x₁ is
//! in units of κ and y₁ in units of 1/κ (which leaves the operator symmetric), the normal
//! constraint is x₁y₁/κ², and μ is in units of 1/κ. All of these are of order one for every κ.

use faer::Mat;

use super::lbfgs::{self, Objective};
use super::system::{System, dot};
use crate::influence::{Circulant, Scratch};

/// The coupling κ below which it is weak.
const WEAK: f64 = 0.3;
/// The weight of the penalty on the length of x.
pub(super) const LENGTH: f64 = 10.0;

/// The number of elements up to which there is too little room for stripes to begin from their
/// ratio.
const FEW: usize = 16;

/// The first value of μκ with few elements.
const FIRST_MU: f64 = 5.0;

/// The limits of a minimisation.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// The number of updates of the multipliers.
    outer: usize,
    /// The number of steps between two updates.
    inner: usize,
    /// The factor by which the penalty grows where violations do not shrink. A slow growth passes
    /// many a poor local minimum.
    growth: f64,
    /// The largest violation, and the relative change of μ, at which the minimisation ends.
    tolerance: f64,
}

impl Limits {
    const NEWTON: Self = Self { outer: 60, inner: 20, growth: 1.3, tolerance: 1e-8 };

    fn of(elements: usize) -> Self {
        match elements {
            k if k <= 64 => Self { outer: 600, inner: 100, growth: 1.05, tolerance: 1e-7 },
            k if k <= 300 => Self { outer: 100, inner: 200, growth: 1.2, tolerance: 1e-6 },
            _ => Self { outer: 100, inner: 200, growth: 1.3, tolerance: 1e-6 },
        }
    }
}

/// A pattern that a minimisation is led towards: signs of x₁ and a direction of y_t.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    /// The sign ±1 of each element.
    pub(super) signs: Vec<f64>,
    /// The unit vector (x, y) of the direction.
    pub(super) direction: [f64; 2],
}

/// The gradients of an element's two constraints in (x, y, μ).
pub(super) struct Slopes {
    /// The gradient of the normal constraint.
    pub(super) normal: [f64; 7],
    /// The gradient of the tangential constraint.
    pub(super) tangential: [f64; 7],
}

/// A workspace for minimisations on one system.
pub(super) struct Descent<'a> {
    system: &'a System,
    scratch: Scratch,
    circulant: Circulant,
    circulant_scratch: Scratch,
    /// The inverse of the largest diagonal entry of the operator.
    scale: f64,
    /// The coupling κ.
    pub(super) coupling: f64,
    pub(super) k: usize,
    /// The margin by which the constraints must hold.
    margin: f64,
    /// The unit of μ in the Lagrangian's first term, μ²/2 over this unit.
    pub(super) unit: f64,
    pub(super) penalty: f64,
    /// The multipliers of the normal constraints, then of the tangential ones.
    pub(super) multipliers: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) values: Vec<f64>,
}

impl<'a> Descent<'a> {
    /// Creates a workspace. The `coupling` is κ, and `margin` says how strictly the constraints
    /// must hold.
    pub(super) fn new(system: &'a System, coupling: f64, margin: f64) -> Self {
        let k = system.elements();
        Self {
            scratch: system.scratch(),
            circulant: Circulant::new(system.table()),
            circulant_scratch: system.scratch(),
            scale: 1.0 / system.largest_diagonal(),
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

    /// Computes out = A x in the units of this module and of the largest diagonal entry.
    fn apply(&mut self, out: &mut [f64], x: &[f64]) {
        let mut x = x.to_vec();
        x[..self.k].iter_mut().for_each(|x| *x *= self.coupling);
        self.system.apply(out, &x, &mut self.scratch);
        out.iter_mut().for_each(|y| *y *= self.scale);
        out[..self.k].iter_mut().for_each(|y| *y *= self.coupling);
    }

    /// Returns A as a 3k × 3k matrix in the units of this module.
    fn matrix(&self) -> Mat<f64> {
        let mut matrix = self.system.matrix();
        let unit = |i: usize| if i < self.k { self.coupling } else { 1.0 };
        for j in 0..3 * self.k {
            for i in 0..3 * self.k {
                matrix[(i, j)] *= self.scale * unit(i) * unit(j);
            }
        }
        matrix
    }

    /// Computes y and the values of the constraints at a point, which is x followed by μ.
    pub(super) fn constrain(&mut self, point: &[f64]) {
        let k = self.k;
        let (x, mu) = (&point[..3 * k], point[3 * k]);
        let mut y = std::mem::take(&mut self.y);
        self.apply(&mut y, x);
        for e in 0..k {
            let work = x[k + e] * y[k + e] + x[2 * k + e] * y[2 * k + e];
            self.values[e] = x[e] * y[e] / (self.coupling * self.coupling) + self.margin;
            self.values[k + e] =
                work - mu * x[e].abs() * y[k + e].hypot(y[2 * k + e]) + self.margin;
        }
        self.y = y;
    }

    /// Returns the largest violation at the point last constrained.
    fn violation(&self) -> f64 {
        self.values.iter().fold(0.0, |most: f64, &c| most.max(c))
    }

    /// Computes the gradients of an element's two constraints.
    pub(super) fn slopes(&self, point: &[f64], e: usize) -> Slopes {
        let (k, mu) = (self.k, point[3 * self.k]);
        let [x1, x2, x3] = [0, 1, 2].map(|c| point[c * k + e]);
        let [y1, y2, y3] = [0, 1, 2].map(|c| self.y[c * k + e]);
        let slip = y2.hypot(y3);
        let n = if slip > 0.0 { [y2 / slip, y3 / slip] } else { [0.0; 2] };
        let (a, sign) = (x1.abs(), if x1 == 0.0 { 0.0 } else { x1.signum() });
        let unit = 1.0 / (self.coupling * self.coupling);
        Slopes {
            normal: [unit * y1, 0.0, 0.0, unit * x1, 0.0, 0.0, 0.0],
            tangential: [
                -mu * sign * slip,
                y2,
                y3,
                0.0,
                x2 - mu * a * n[0],
                x3 - mu * a * n[1],
                -a * slip,
            ],
        }
    }

    /// Computes (I A) v for numbers per element in (x, y, μ). It turns a derivative with respect to
    /// these into one with respect to the point.
    pub(super) fn collect(&mut self, locals: impl Iterator<Item = [f64; 7]>, out: &mut [f64]) {
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

    /// Returns a change of the point as changes in (x, y, μ) per element; `image` is A times its x.
    fn spread<'b>(k: usize, step: &'b [f64], image: &'b [f64]) -> impl Fn(usize) -> [f64; 7] + 'b {
        move |e| {
            [
                step[e],
                step[k + e],
                step[2 * k + e],
                image[e],
                image[k + e],
                image[2 * k + e],
                step[3 * k],
            ]
        }
    }

    /// Converts x and μ to a point in the units of this module.
    fn enter(&self, x: &[f64], mu: f64) -> Vec<f64> {
        let mut point = x.to_vec();
        point[..self.k].iter_mut().for_each(|x| *x /= self.coupling);
        point.push(mu * self.coupling);
        point
    }

    /// Reverses [`enter`](Self::enter): writes `x` and returns μ.
    fn leave(&self, point: &[f64], x: &mut [f64]) -> f64 {
        x.copy_from_slice(&point[..3 * self.k]);
        x[..self.k].iter_mut().for_each(|x| *x *= self.coupling);
        point[3 * self.k] / self.coupling
    }

    /// Minimises from `x`, towards a pattern if there is one. Without a pattern, 3k × 3k matrices
    /// are factored. It leaves x with xᵀAx near k and returns μ. The constraints hold up to a small
    /// violation.
    pub(super) fn minimise(&mut self, x: &mut [f64], pattern: Option<&Pattern>) -> f64 {
        let k = self.k;
        let mut point = self.enter(x, 0.0);
        if k > FEW && pattern.is_some() {
            self.begin(&mut point, pattern);
            self.approach(&mut point, Limits::of(k), None);
        } else {
            // The first minimisation is free to pass poor local minima; the second one stays where
            // the first one ended.
            let matrix = self.matrix();
            self.point_to_length(&mut point);
            (point[3 * k], self.unit) = (FIRST_MU, FIRST_MU * FIRST_MU);
            for penalty in [10.0, 1000.0] {
                self.multipliers.fill(0.0);
                self.penalty = penalty / k as f64;
                self.approach(&mut point, Limits::NEWTON, Some(&matrix));
                self.unit = point[3 * k] * point[3 * k];
            }
        }
        self.leave(&point, x)
    }

    /// Minimises the ratio, and takes multipliers and penalty from its minimum.
    fn begin(&mut self, point: &mut [f64], pattern: Option<&Pattern>) {
        let k = self.k;
        for pattern in pattern.into_iter().map(Some).chain([None]) {
            self.point_to_length(point);
            let ratio = lbfgs::minimise(
                &mut point[..3 * k],
                &mut Ratio { descent: self, pattern },
                RATIO_STEPS,
                STALLED,
            );
            point[3 * k] = ratio;
        }
        self.point_to_length(point);
        self.constrain(point);
        let mut weighted = point[..3 * k].to_vec();
        self.weight(&mut weighted);
        let first = point[3 * k] / dot(&weighted, &self.y);
        self.multipliers.fill(first);
        let normal = first * (self.coupling * self.normal_weight()).powi(2);
        self.multipliers[..k].fill(normal);
        self.unit = point[3 * k];
        self.penalty = first / (dot(&self.values, &self.values) / (2 * k) as f64).sqrt();
    }

    /// Runs the augmented Lagrangian's method, with Newton's method inside if A is given as a
    /// matrix.
    fn approach(&mut self, point: &mut [f64], limits: Limits, matrix: Option<&Mat<f64>>) {
        let k = self.k;
        let mut shift = 1.0 / k as f64;
        let (mut before, mut last) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..limits.outer {
            match matrix {
                Some(matrix) => self.descend(matrix, point, limits.inner, &mut shift),
                None => {
                    lbfgs::minimise(
                        point,
                        &mut Lagrangian { descent: self },
                        limits.inner,
                        STALLED,
                    );
                }
            }
            self.constrain(point);
            let (violation, mu) = (self.violation(), point[3 * k]);
            for (multiplier, c) in self.multipliers.iter_mut().zip(&self.values) {
                *multiplier = (*multiplier + self.penalty * c).max(0.0);
            }
            if violation < limits.tolerance && (mu - last).abs() < limits.tolerance * mu {
                break;
            }
            if violation > 0.7 * before {
                self.penalty *= limits.growth;
            }
            (before, last) = (violation, mu);
        }
    }

    /// Scales the point so that xᵀAx = k.
    fn point_to_length(&mut self, point: &mut [f64]) {
        self.constrain(point);
        let x = &mut point[..3 * self.k];
        let length = (self.k as f64 / dot(x, &self.y).max(f64::MIN_POSITIVE)).sqrt();
        x.iter_mut().for_each(|x| *x *= length);
    }

    /// Returns the root of the weight α of the normal constraints. It is 1, and in proportion to
    /// 1/κ for a weak coupling.
    fn normal_weight(&self) -> f64 {
        (WEAK / self.coupling).max(1.0)
    }

    /// Multiplies the normal block of a field by the weight.
    fn weight(&self, field: &mut [f64]) {
        let weight = self.normal_weight().powi(2);
        field[..self.k].iter_mut().for_each(|value| *value *= weight);
    }

    /// Applies the inverse circulants of A's diagonal blocks to a gradient in x.
    fn precondition(&mut self, gradient: &[f64], out: &mut [f64]) {
        let (k, n) = (self.k, self.system.grid().len());
        let (mut from, mut to) = (vec![0.0; 3 * n], vec![0.0; 3 * n]);
        self.system.onto_grid(&mut from, gradient);
        self.circulant.invert(&mut to, &from, self.system.epsilon(), &mut self.circulant_scratch);
        self.system.off_grid(&mut out[..3 * k], &to);
        out.iter_mut().for_each(|x| *x /= self.scale);
    }

    /// Restores the active constraints by a Gauss–Newton method with the least change of the point.
    /// Returns the μ reached, if all constraints hold with half of the margin.
    pub(super) fn restore(&mut self, x: &mut [f64], mu: f64) -> Option<f64> {
        let k = self.k;
        let mut point = self.enter(x, mu);
        for _ in 0..12 {
            self.constrain(&point);
            if self.violation() <= 0.5 * self.margin {
                return Some(self.leave(&point, x));
            }
            let slopes: Vec<Slopes> = (0..k).map(|e| self.slopes(&point, e)).collect();
            let active: Vec<bool> = self.values.iter().map(|&c| c > -10.0 * self.margin).collect();
            let mut residual: Vec<f64> =
                self.values.iter().zip(&active).map(|(&c, &a)| if a { -c } else { 0.0 }).collect();
            // Conjugate gradients solve the system with J Jᵀ.
            let mut p = residual.clone();
            let mut total = vec![0.0; 3 * k + 1];
            let mut step = vec![0.0; 3 * k + 1];
            let mut image = vec![0.0; 3 * k];
            let mut rr = dot(&residual, &residual);
            let target = rr * 1e-12;
            for _ in 0..400 {
                let pulled = slopes.iter().enumerate().map(|(e, Slopes { normal, tangential })| {
                    std::array::from_fn(|i| p[e] * normal[i] + p[k + e] * tangential[i])
                });
                let pulled: Vec<[f64; 7]> = pulled.collect();
                self.collect(pulled.into_iter(), &mut step);
                let norm = dot(&step, &step);
                if rr <= target || norm == 0.0 {
                    break;
                }
                let alpha = rr / norm;
                self.apply(&mut image, &step[..3 * k]);
                let of = Self::spread(k, &step, &image);
                for (e, Slopes { normal, tangential }) in slopes.iter().enumerate() {
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

/// The number of steps of the minimisation of the ratio.
const RATIO_STEPS: usize = 600;

/// The share of the value below which the gain of a step ends a minimisation.
const STALLED: f64 = 2e-9;

/// The ratio Σ (αx₁y₁ + x_t·y_t) / Σ|x₁||y_t|, or with a pattern the one with Σ ±x₁ (n·y_t) below.
struct Ratio<'a, 'b> {
    descent: &'a mut Descent<'b>,
    pattern: Option<&'a Pattern>,
}

impl Objective for Ratio<'_, '_> {
    fn value(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let k = self.descent.k;
        let mut y = vec![0.0; 3 * k];
        self.descent.apply(&mut y, x);
        // These are the sum, and its derivatives with respect to x₁ and y_t.
        let (mut sum, mut by_x, mut by_y) = (0.0, vec![0.0; k], vec![0.0; 3 * k]);
        for e in 0..k {
            let slip = y[k + e].hypot(y[2 * k + e]);
            let (sign, [nx, ny]) = match self.pattern {
                Some(pattern) => (pattern.signs[e], pattern.direction),
                None if slip > 0.0 => {
                    (if x[e] < 0.0 { -1.0 } else { 1.0 }, [y[k + e] / slip, y[2 * k + e] / slip])
                }
                None => (0.0, [0.0; 2]),
            };
            let along = nx * y[k + e] + ny * y[2 * k + e];
            sum += sign * x[e] * along;
            by_x[e] = sign * along;
            by_y[k + e] = sign * x[e] * nx;
            by_y[2 * k + e] = sign * x[e] * ny;
        }
        if sum.is_nan() || sum <= 0.0 {
            return f64::INFINITY;
        }
        let mut weighted = x.to_vec();
        self.descent.weight(&mut weighted);
        let ratio = dot(&weighted, &y) / sum;
        self.descent.weight(&mut y);
        by_y.iter_mut().zip(&weighted).for_each(|(by, w)| *by = w - ratio * *by);
        self.descent.apply(gradient, &by_y);
        by_x.resize(3 * k, 0.0);
        gradient
            .iter_mut()
            .zip(y.iter().zip(&by_x))
            .for_each(|(g, (y, by))| *g = (*g + y - ratio * by) / sum);
        ratio
    }

    fn precondition(&mut self, gradient: &[f64], out: &mut [f64]) {
        self.descent.precondition(gradient, out);
    }
}

/// The augmented Lagrangian as a function of x and μ.
struct Lagrangian<'a, 'b> {
    descent: &'a mut Descent<'b>,
}

impl Objective for Lagrangian<'_, '_> {
    fn value(&mut self, point: &[f64], gradient: &mut [f64]) -> f64 {
        let descent = &mut *self.descent;
        let (k, unit) = (descent.k, descent.unit);
        descent.constrain(point);
        let (x, mu) = (&point[..3 * k], point[3 * k]);
        let length = dot(x, &descent.y) / k as f64 - 1.0;
        let along: Vec<f64> =
            descent.y.iter().map(|y| 2.0 * LENGTH * length * y / k as f64).collect();
        let mut sum = 0.0;
        let forces: Vec<[f64; 7]> = (0..k)
            .map(|e| {
                let slopes = descent.slopes(point, e);
                let [normal, tangential] = [e, k + e].map(|i| {
                    let force =
                        (descent.multipliers[i] + descent.penalty * descent.values[i]).max(0.0);
                    sum += force * force - descent.multipliers[i] * descent.multipliers[i];
                    force
                });
                std::array::from_fn(|i| {
                    normal * slopes.normal[i] + tangential * slopes.tangential[i]
                })
            })
            .collect();
        descent.collect(forces.into_iter(), gradient);
        gradient.iter_mut().zip(&along).for_each(|(g, along)| *g += along);
        gradient[3 * k] += mu / unit;
        0.5 * (mu * mu / unit + sum / descent.penalty + LENGTH * length * length)
    }

    fn precondition(&mut self, gradient: &[f64], out: &mut [f64]) {
        let k = self.descent.k;
        self.descent.precondition(&gradient[..3 * k], &mut out[..3 * k]);
        out[3 * k] = gradient[3 * k];
    }
}
