//! GMRES with right preconditioning (Saad and Schultz 1986, doi:10.1137/0907058), restarted.

/// Largest number of directions kept before a restart.
const RESTART: usize = 80;

/// What an iteration came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Figures {
    /// Residual over the right-hand side.
    pub(crate) residual: f64,
    /// Applications of the operator.
    pub(crate) applications: u64,
}

/// Solves `operator`·x = `rhs` from x = 0 to the relative residual `tolerance`, with `precondition` an approximate inverse.
/// Sums run in a fixed order, so that the result does not depend on the number of threads.
pub(crate) fn solve(
    rhs: &[f64],
    tolerance: f64,
    max_applications: u64,
    mut operator: impl FnMut(&[f64]) -> Vec<f64>,
    mut precondition: impl FnMut(&[f64]) -> Vec<f64>,
) -> (Vec<f64>, Figures) {
    let size = norm(rhs);
    let mut x = vec![0.0; rhs.len()];
    let mut figures = Figures { residual: 0.0, applications: 0 };
    if size == 0.0 {
        return (x, figures);
    }
    let mut residual = rhs.to_vec();
    loop {
        let start = norm(&residual);
        figures.residual = start / size;
        if figures.residual <= tolerance || figures.applications >= max_applications || !start.is_finite() {
            return (x, figures);
        }
        let mut basis = vec![residual.iter().map(|r| r / start).collect::<Vec<f64>>()];
        // the triangular factor column by column, and the rotations that made it
        let (mut columns, mut rotations): (Vec<Vec<f64>>, Vec<(f64, f64)>) = (Vec::new(), Vec::new());
        let mut rest = vec![start];
        while columns.len() < RESTART && figures.applications < max_applications {
            let mut v = operator(&precondition(&basis[columns.len()]));
            figures.applications += 1;
            let mut column = Vec::with_capacity(basis.len() + 1);
            for direction in &basis {
                let along = dot(direction, &v);
                v.iter_mut().zip(direction).for_each(|(v, d)| *v -= along * d);
                column.push(along);
            }
            let height = norm(&v);
            for (i, (c, s)) in rotations.iter().enumerate() {
                (column[i], column[i + 1]) = (c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]);
            }
            let last = column.len() - 1;
            let length = column[last].hypot(height);
            if length == 0.0 || !length.is_finite() {
                break;
            }
            let (c, s) = (column[last] / length, height / length);
            column[last] = length;
            rotations.push((c, s));
            columns.push(column);
            let carried = rest[last];
            rest[last] = c * carried;
            rest.push(-s * carried);
            if height == 0.0 || rest[last + 1].abs() <= tolerance * size {
                break;
            }
            v.iter_mut().for_each(|v| *v /= height);
            basis.push(v);
        }
        let mut weights = vec![0.0; columns.len()];
        for i in (0..columns.len()).rev() {
            let known: f64 = (i + 1..columns.len()).map(|j| columns[j][i] * weights[j]).sum();
            weights[i] = (rest[i] - known) / columns[i][i];
        }
        if columns.is_empty() {
            return (x, figures);
        }
        // the preconditioner once more is cheaper than keeping every preconditioned direction
        let mut sum = vec![0.0; rhs.len()];
        for (weight, direction) in weights.iter().zip(&basis) {
            sum.iter_mut().zip(direction).for_each(|(sum, v)| *sum += weight * v);
        }
        x.iter_mut().zip(precondition(&sum)).for_each(|(x, z)| *x += z);
        if rest[columns.len()].abs() <= tolerance * size || figures.applications >= max_applications {
            figures.residual = rest[columns.len()].abs() / size;
            return (x, figures);
        }
        let image = operator(&x);
        figures.applications += 1;
        residual = rhs.iter().zip(&image).map(|(b, a)| b - a).collect();
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_an_unsymmetric_system_with_restarts_and_without() {
        for n in [3, 40, 200] {
            let apply = |x: &[f64]| -> Vec<f64> {
                (0..n)
                    .map(|i| {
                        (2.0 + i as f64) * x[i] + if i + 1 < n { 0.7 * x[i + 1] } else { 0.0 } - if i > 0 { 0.2 * x[i - 1] } else { 0.0 }
                    })
                    .collect()
            };
            let rhs: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            let (x, figures) = solve(&rhs, 1e-11, 2000, apply, |r| r.to_vec());
            let back = apply(&x);
            let defect = norm(&back.iter().zip(&rhs).map(|(a, b)| a - b).collect::<Vec<_>>()) / norm(&rhs);
            assert!(defect <= 1.1e-11 && figures.residual <= 1e-11, "{n}: {defect:e} {figures:?}");
            let (_, preconditioned) =
                solve(&rhs, 1e-11, 2000, apply, |r| r.iter().enumerate().map(|(i, r)| r / (2.0 + i as f64)).collect());
            assert!(preconditioned.applications <= figures.applications);
        }
        assert_eq!(solve(&[0.0; 4], 1e-8, 10, |x| x.to_vec(), |x| x.to_vec()).0, [0.0; 4]);
    }
}
