//! L-BFGS: minimisation of a smooth function of many variables with memory of a few steps (J.
//! Nocedal, S. J. Wright, Numerical Optimization, 2nd ed., section 7.2). A preconditioner is its
//! first guess of the inverse Hessian. The line search finds Wolfe's weak conditions by bisection,
//! which also serves at kinks (A. S. Lewis, M. L. Overton, Math. Program. 141, 2013).

use std::collections::VecDeque;

use super::system::dot;

/// A function to minimise.
pub(super) trait Objective {
    /// Returns the value at a point, infinite or NaN where there is none, and writes its gradient.
    fn value(&mut self, point: &[f64], gradient: &mut [f64]) -> f64;

    /// Computes out = an approximate inverse of the Hessian, symmetric and positive definite, times
    /// `gradient`. Its scale does not matter.
    fn precondition(&mut self, gradient: &[f64], out: &mut [f64]);
}

/// The number of steps that are remembered.
const MEMORY: usize = 20;
/// The least decrease in Wolfe's conditions, as a share of the one that the slope predicts.
const DECREASE: f64 = 1e-4;
/// The largest share of the slope that may remain in Wolfe's conditions.
const SLOPE: f64 = 0.9;
/// The most evaluations along one direction.
const TRIALS: usize = 25;

/// A step with the change of the gradient along it.
struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    /// The inverse 1 / step · change.
    inverse: f64,
}

/// A point with its value and gradient.
struct Place {
    point: Vec<f64>,
    value: f64,
    gradient: Vec<f64>,
}

impl Place {
    fn go(&mut self, from: &[f64], direction: &[f64], length: f64, objective: &mut impl Objective) {
        self.point
            .iter_mut()
            .zip(from.iter().zip(direction))
            .for_each(|(to, (x, d))| *to = x + length * d);
        self.value = objective.value(&self.point, &mut self.gradient);
    }
}

/// Minimises from `point`, which becomes the best point found, in at most `steps` steps. It ends
/// when a step wins less than the relative `tolerance`, and returns the value reached.
pub(super) fn minimise(
    point: &mut [f64],
    objective: &mut impl Objective,
    steps: usize,
    tolerance: f64,
) -> f64 {
    let nowhere =
        || Place { point: point.to_vec(), value: f64::INFINITY, gradient: vec![0.0; point.len()] };
    let [mut here, mut trial, mut best] = [nowhere(), nowhere(), nowhere()];
    here.value = objective.value(&here.point, &mut here.gradient);
    let mut pairs: VecDeque<Pair> = VecDeque::with_capacity(MEMORY);
    let mut direction = vec![0.0; point.len()];
    let mut taken = 0;
    while taken < steps {
        towards(&here.gradient, &pairs, objective, &mut direction);
        let slope = dot(&here.gradient, &direction);
        // Without memory the length of the direction means nothing.
        let mut length = if pairs.is_empty() {
            dot(&direction, &direction).sqrt().recip().min(1.0)
        } else {
            1.0
        };
        let (mut low, mut high) = (0.0, f64::INFINITY);
        for _ in 0..if slope < 0.0 { TRIALS } else { 0 } {
            trial.go(&here.point, &direction, length, objective);
            if trial.value <= here.value + DECREASE * length * slope {
                std::mem::swap(&mut best, &mut trial);
                low = length;
                if dot(&best.gradient, &direction) >= SLOPE * slope {
                    break;
                }
            } else {
                high = length;
            }
            length = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * length };
        }
        if low == 0.0 {
            if pairs.is_empty() {
                break;
            }
            pairs.clear();
            continue;
        }
        let won = here.value - best.value;
        if pairs.len() == MEMORY {
            pairs.pop_front();
        }
        pairs.extend(Pair::between(&here, &best));
        std::mem::swap(&mut here, &mut best);
        if won <= tolerance * here.value.abs() {
            break;
        }
        taken += 1;
    }
    point.copy_from_slice(&here.point);
    here.value
}

impl Pair {
    /// Creates the pair of a step, or `None` if the curvature along the step is not positive.
    fn between(from: &Place, to: &Place) -> Option<Self> {
        let difference =
            |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let (step, change) =
            (difference(&to.point, &from.point), difference(&to.gradient, &from.gradient));
        let curvature = dot(&step, &change);
        let sizes = (dot(&step, &step) * dot(&change, &change)).sqrt();
        (curvature > f64::EPSILON * sizes).then(|| Self { step, change, inverse: 1.0 / curvature })
    }
}

/// Computes minus the approximate inverse of the Hessian times the gradient.
fn towards(
    gradient: &[f64],
    pairs: &VecDeque<Pair>,
    objective: &mut impl Objective,
    direction: &mut [f64],
) {
    let mut rest: Vec<f64> = gradient.iter().map(|g| -g).collect();
    let mut shares = Vec::with_capacity(pairs.len());
    for pair in pairs.iter().rev() {
        let share = pair.inverse * dot(&pair.step, &rest);
        rest.iter_mut().zip(&pair.change).for_each(|(rest, y)| *rest -= share * y);
        shares.push(share);
    }
    objective.precondition(&rest, direction);
    if let Some(last) = pairs.back() {
        // This is the scale that the last step measured.
        let mut image = vec![0.0; rest.len()];
        objective.precondition(&last.change, &mut image);
        let scale = 1.0 / (last.inverse * dot(&last.change, &image));
        direction.iter_mut().for_each(|d| *d *= scale);
    }
    for (pair, share) in pairs.iter().zip(shares.iter().rev()) {
        let correction = share - pair.inverse * dot(&pair.change, direction);
        direction.iter_mut().zip(&pair.step).for_each(|(d, s)| *d += correction * s);
    }
}
