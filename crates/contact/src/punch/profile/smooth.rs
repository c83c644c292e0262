//! The smoothing spline through points of a plane curve.
//!
//! It is Reinsch's: of all curves whose weighted sum of squared distances from the points, at equal
//! parameters, does not exceed a bound, the one with the least integral of its squared second
//! derivative (C. H. Reinsch, Numer. Math. 10 (1967) 177, doi:10.1007/BF02162161).

/// Moves `points` onto the smoothing spline over the chord length. `weights` multiply the
/// distances, and `bound` is the largest weighted sum of their squares. Returns `None` if a
/// straight line keeps the bound, which then leaves nothing of the curve.
pub(super) fn smoothed(points: &[[f64; 2]], weights: &[f64], bound: f64) -> Option<Vec<[f64; 2]>> {
    let spline = Smoothing::new(points, weights)?;
    // The sum of squares grows with the stiffness; these bounds are beyond what it can be.
    let (mut low, mut high) = (-80.0_f64, 80.0_f64);
    if spline.at(points, high.exp()).sum <= bound {
        return None;
    }
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if spline.at(points, middle.exp()).sum > bound { high = middle } else { low = middle }
    }
    let smooth = spline.at(points, low.exp());
    // Points that are hardly off the curve leave it as it is.
    Some(if smooth.sum <= bound { smooth.points } else { points.to_vec() })
}

/// The equations of a smoothing spline. With the second differences Q and the matrix R of a natural
/// spline, the second derivatives γ solve (R + α QᵀW⁻²Q) γ = Qᵀy, and the points move to
/// y − α W⁻²Q γ.
struct Smoothing {
    /// The three coefficients of a second difference at each inner point.
    differences: Vec<[f64; 3]>,
    /// The diagonal of R and the one beside it.
    spline: Vec<[f64; 2]>,
    /// The inverse squares of the weights.
    give: Vec<f64>,
}

/// Smoothed points, and the weighted sum of the squares of their distances.
struct Smooth {
    points: Vec<[f64; 2]>,
    sum: f64,
}

impl Smoothing {
    fn new(points: &[[f64; 2]], weights: &[f64]) -> Option<Self> {
        if points.len() < 3 {
            return None;
        }
        let chord = |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        let chords: Vec<f64> = points.windows(2).map(chord).collect();
        // The mean chord is the unit, so that the stiffness is a pure number.
        let mean = chords.iter().sum::<f64>() / chords.len() as f64;
        let steps: Vec<f64> = chords.iter().map(|chord| chord / mean).collect();
        let differences =
            steps.windows(2).map(|h| [1.0 / h[0], -1.0 / h[0] - 1.0 / h[1], 1.0 / h[1]]).collect();
        let spline = steps.windows(2).map(|h| [(h[0] + h[1]) / 3.0, h[1] / 6.0]).collect();
        let give = weights.iter().map(|weight| 1.0 / (weight * weight)).collect();
        Some(Self { differences, spline, give })
    }

    /// Returns the points of the spline with the stiffness α.
    fn at(&self, points: &[[f64; 2]], stiffness: f64) -> Smooth {
        let q = &self.differences;
        let count = q.len();
        // The matrix has two diagonals on either side; it is symmetric and positive definite.
        let entry = |k: usize, offset: usize| {
            let mut sum = 0.0;
            for row in offset..3 {
                if let Some(other) = q.get(k + offset) {
                    sum += q[k][row] * other[row - offset] * self.give[k + row];
                }
            }
            let spline = if offset < 2 { self.spline[k][offset] } else { 0.0 };
            spline + stiffness * sum
        };
        let mut pivots = vec![0.0; count];
        let mut factors = vec![[0.0; 2]; count];
        for k in 0..count {
            let before = |back: usize, index: usize| match k.checked_sub(back) {
                Some(row) => factors[row][index],
                None => 0.0,
            };
            let pivot_before = |back: usize| k.checked_sub(back).map_or(0.0, |row| pivots[row]);
            let (near, far) = (before(1, 0), before(2, 1));
            let pivot = entry(k, 0) - near * near * pivot_before(1) - far * far * pivot_before(2);
            let first = (entry(k, 1) - near * before(1, 1) * pivot_before(1)) / pivot;
            pivots[k] = pivot;
            factors[k] = [first, entry(k, 2) / pivot];
        }
        let mut moved = points.to_vec();
        let mut sum = 0.0;
        for axis in 0..2 {
            let mut bends: Vec<f64> = (0..count)
                .map(|k| (0..3).map(|row| q[k][row] * points[k + row][axis]).sum())
                .collect();
            for k in 0..count {
                let near = if k >= 1 { factors[k - 1][0] * bends[k - 1] } else { 0.0 };
                let far = if k >= 2 { factors[k - 2][1] * bends[k - 2] } else { 0.0 };
                bends[k] -= near + far;
            }
            for k in (0..count).rev() {
                let near = if k + 1 < count { factors[k][0] * bends[k + 1] } else { 0.0 };
                let far = if k + 2 < count { factors[k][1] * bends[k + 2] } else { 0.0 };
                bends[k] = bends[k] / pivots[k] - near - far;
            }
            for (index, point) in moved.iter_mut().enumerate() {
                let pull: f64 = (0..3)
                    .filter_map(|row| {
                        let k = index.checked_sub(row)?;
                        Some(q.get(k)?[row] * bends[k])
                    })
                    .sum();
                let distance = stiffness * self.give[index] * pull;
                point[axis] -= distance;
                sum += distance * distance / self.give[index];
            }
        }
        Smooth { points: moved, sum }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noisy(noise: f64) -> Vec<[f64; 2]> {
        (0..80)
            .map(|k| {
                let angle = 0.02 * f64::from(k);
                let off = noise * f64::from(k * 7919 % 101 - 50) / 50.0;
                [angle.sin(), (1.0 + off) * angle.cos()]
            })
            .collect()
    }

    #[test]
    fn the_sum_of_squares_is_the_one_asked_for() {
        let points = noisy(1e-4);
        let smooth = smoothed(&points, &[1.0; 80], 1.2e-7).unwrap();
        let sum: f64 = points
            .iter()
            .zip(&smooth)
            .map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2))
            .sum();
        assert!((sum / 1.2e-7 - 1.0).abs() < 1e-6, "{sum}");
        let roughness = |points: &[[f64; 2]]| -> f64 {
            let fourth =
                |p: &[[f64; 2]]| p[0][1] - 4.0 * p[1][1] + 6.0 * p[2][1] - 4.0 * p[3][1] + p[4][1];
            points.windows(5).map(|p| fourth(p).powi(2)).sum()
        };
        let shares = roughness(&smooth) / roughness(&points);
        assert!(shares < 0.2, "{shares}");
        // A point that weighs much stays.
        let mut weights = [1.0; 80];
        weights[40] = 1e3;
        let held = smoothed(&points, &weights, 1.2e-7).unwrap();
        assert!((held[40][1] - points[40][1]).abs() < 1e-6);
    }

    #[test]
    fn nothing_changes_without_a_bound_and_nothing_is_left_with_a_large_one() {
        let points = noisy(1e-4);
        let same = smoothed(&points, &[1.0; 80], 1e-24).unwrap();
        assert!(points.iter().zip(&same).all(|(a, b)| (a[1] - b[1]).abs() < 1e-11));
        assert_eq!(smoothed(&points, &[1.0; 80], 1e3), None);
    }
}
