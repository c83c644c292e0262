//! Gauss quadrature for the two densities that a projection puts on a boundary element: the uniform
//! one and the tent.

use std::sync::LazyLock;

/// The number of points of the largest rule.
pub(crate) const MAX_POINTS: usize = 16;

/// The nodes in (−1, 1) and the weights of a Gauss rule for a density of mass 1.
pub(crate) type Rule = Vec<(f64, f64)>;

/// Returns the rules of 0 (empty) to [`MAX_POINTS`] points for the density ½ on (−1, 1).
pub(crate) fn uniform() -> &'static [Rule] {
    static RULES: LazyLock<Vec<Rule>> = LazyLock::new(|| rules(&legendre(MAX_POINTS)));
    &RULES
}

/// Returns the rules of 0 (empty) to [`MAX_POINTS`] points for the density 1 − |u| on (−1, 1).
pub(crate) fn tent() -> &'static [Rule] {
    static RULES: LazyLock<Vec<Rule>> = LazyLock::new(|| rules(&tent_recurrence()));
    &RULES
}

/// Returns the index of the smallest rule that integrates a function with a relative error of about
/// 1e-15, if the function's nearest singularity in the complex plane lies `distance` half-widths
/// from the middle of the interval; `None` if no rule does. The argument is the square of that
/// distance.
///
/// The error of n points falls like ϱ⁻²ⁿ, where ϱ is the sum of the semi-axes of the ellipse with
/// foci ±1 through the singularity. For a given distance ϱ is smallest on the real axis, where
/// distance = (ϱ + 1/ϱ)/2.
pub(crate) fn points(distance_squared: f64) -> Option<usize> {
    /// Half the natural logarithm of the reduction of the error.
    const HALF_LOG: f64 = 17.3;
    static REACH: LazyLock<Vec<f64>> =
        LazyLock::new(|| (2..=MAX_POINTS).map(|n| (HALF_LOG / n as f64).cosh().powi(2)).collect());
    REACH.iter().position(|&reach| distance_squared >= reach).map(|i| i + 2)
}

/// Returns the recurrence coefficients β₁ … of the monic Legendre polynomials, π_{k+1} = x π_k −
/// β_k π_{k−1}.
fn legendre(degree: usize) -> Vec<f64> {
    (1..=degree).map(|k| (k * k) as f64 / (4 * k * k - 1) as f64).collect()
}

/// Returns the recurrence coefficients for the tent by Stieltjes' procedure: β_k =
/// ‖π_k‖²/‖π_{k−1}‖², the norms by a Legendre rule on either half that is exact for them.
fn tent_recurrence() -> Vec<f64> {
    let exact = MAX_POINTS + 2;
    let half = rules(&legendre(exact)).pop().unwrap_or_default();
    let nodes: Vec<(f64, f64)> = half
        .iter()
        // A node holds x and twice the tent, because the mirrored half gives the same sum.
        .map(|&(u, w)| (0.5 * (1.0 + u), w * (1.0 - u)))
        .collect();
    let mut beta = Vec::with_capacity(MAX_POINTS);
    let mut previous = vec![0.0; nodes.len()];
    let mut current = vec![1.0; nodes.len()];
    let mut norm = 1.0;
    for k in 0..MAX_POINTS {
        let beta_k = if k == 0 { 0.0 } else { beta[k - 1] };
        let next: Vec<f64> =
            (0..nodes.len()).map(|i| nodes[i].0 * current[i] - beta_k * previous[i]).collect();
        let next_norm: f64 = nodes.iter().zip(&next).map(|(&(_, w), &p)| w * p * p).sum();
        beta.push(next_norm / norm);
        norm = next_norm;
        previous = std::mem::replace(&mut current, next);
    }
    beta
}

/// Returns the Gauss rules of 0 to `beta.len()` points of an even density of mass 1 with these
/// recurrence coefficients.
///
/// The zeros of successive orthogonal polynomials interlace, which brackets each one for bisection.
/// The weight at a zero x is 1/Σ p_k(x)² over the orthonormal polynomials of lower degree.
fn rules(beta: &[f64]) -> Vec<Rule> {
    let value = |n: usize, x: f64| {
        let (mut previous, mut current) = (0.0, 1.0);
        for k in 0..n {
            let beta_k = if k == 0 { 0.0 } else { beta[k - 1] };
            (previous, current) = (current, x * current - beta_k * previous);
        }
        current
    };
    let weight = |n: usize, x: f64| {
        let (mut previous, mut current, mut norm, mut sum) = (0.0, 1.0, 1.0, 0.0);
        for k in 0..n {
            sum += current * current / norm;
            let beta_k = if k == 0 { 0.0 } else { beta[k - 1] };
            (previous, current) = (current, x * current - beta_k * previous);
            norm *= beta[k];
        }
        1.0 / sum
    };
    let mut all: Vec<Rule> = vec![Rule::new()];
    for n in 1..=beta.len() {
        let inner = &all[n - 1];
        let mut nodes: Vec<f64> = (0..n)
            .map(|i| {
                let mut lo = if i == 0 { -1.0 } else { inner[i - 1].0 };
                let mut hi = if i == n - 1 { 1.0 } else { inner[i].0 };
                let below = value(n, lo) < 0.0;
                while hi - lo > f64::EPSILON {
                    let middle = 0.5 * (lo + hi);
                    if middle <= lo || middle >= hi {
                        break;
                    }
                    if (value(n, middle) < 0.0) == below { lo = middle } else { hi = middle }
                }
                0.5 * (lo + hi)
            })
            .collect();
        for i in 0..n.div_ceil(2) {
            let half = 0.5 * (nodes[n - 1 - i] - nodes[i]);
            (nodes[i], nodes[n - 1 - i]) = (-half, half);
        }
        all.push(nodes.into_iter().map(|x| (x, weight(n, x))).collect());
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_up_to_their_degree_and_no_further() {
        for n in 1..=MAX_POINTS {
            for (rule, moment) in [
                (&uniform()[n], (|k| 1.0 / (k + 1.0)) as fn(f64) -> f64),
                (&tent()[n], |k| 2.0 / ((k + 1.0) * (k + 2.0))),
            ] {
                assert_eq!(rule.len(), n);
                for k in 0..=2 * n {
                    let sum: f64 = rule.iter().map(|&(x, w)| w * x.powi(k as i32)).sum();
                    let exact = if k % 2 == 1 { 0.0 } else { moment(k as f64) };
                    if k < 2 * n {
                        assert!((sum - exact).abs() < 4e-15, "{n} points, x^{k}: {sum} {exact}");
                    } else if n < 12 {
                        assert!((sum - exact).abs() > 1e-8, "{n} points, x^{k}: {sum} {exact}");
                    }
                }
            }
        }
    }

    #[test]
    fn fewer_points_farther_away() {
        assert_eq!(points(1.0), None);
        assert_eq!(points(f64::INFINITY), Some(2));
        let mut last = MAX_POINTS;
        for k in 0..400 {
            let distance = 1.7 * 1.03_f64.powi(k);
            let n = points(distance * distance).unwrap();
            assert!(n <= last);
            last = n;
        }
    }
}
