//! GMRES with right preconditioning (Saad and Schultz 1986, doi:10.1137/0907058), restarted.
//!
//! A new direction is made orthogonal to all others at once, which reads their memory twice. It is
//! done a second time where the first has cancelled much (Daniel, Gragg, Kaufman and Stewart 1976,
//! doi:10.1090/S0025-5718-1976-0431641-8).

use super::vector::{add, norm, products, scale};

/// The largest number of directions kept before a restart.
const RESTART: usize = 80;

/// The share of its length below which a direction, made orthogonal, has lost too many digits.
const CANCELLED: f64 = 0.1;

/// A linear system with an approximate inverse.
pub(crate) trait LinearSystem {
    /// Sets `image` to A `x`.
    fn apply(&mut self, image: &mut [f64], x: &[f64]);

    /// Sets `x` to about A⁻¹ `rows`.
    fn precondition(&mut self, x: &mut [f64], rows: &[f64]);

    /// Returns whether the answer is taken as it is, because nobody wants it any more.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// The directions of earlier solves, whose memory the next one uses again. They are no more than
/// one solve has at once.
#[derive(Debug, Default)]
pub(crate) struct Memory(Vec<Vec<f64>>);

impl Memory {
    /// Returns a vector of this length, with arbitrary contents.
    fn vector(&mut self, len: usize) -> Vec<f64> {
        match self.0.pop() {
            Some(mut vector) => {
                vector.resize(len, 0.0);
                vector
            }
            // The memory is not touched before the threads that write it do so.
            None => vec![0.0; len],
        }
    }
}

/// The figures of a linear solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KrylovFigures {
    /// The norm of the residual over that of the right-hand side.
    pub(crate) residual: f64,
    /// The number of applications of the operator.
    pub(crate) applications: u64,
}

/// The answer of a linear solve.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct KrylovSolution {
    /// The unknowns.
    pub(crate) x: Vec<f64>,
    /// The residual that is left, and the work.
    pub(crate) figures: KrylovFigures,
}

/// Solves `system`·x = `rhs` from x = 0 to the relative residual `tolerance`, or until
/// `max_applications` are spent. The result does not depend on the number of threads.
pub(crate) fn solve(
    rhs: &[f64],
    tolerance: f64,
    max_applications: u64,
    system: &mut impl LinearSystem,
    memory: &mut Memory,
) -> KrylovSolution {
    let size = norm(rhs);
    let mut x = vec![0.0; rhs.len()];
    let mut figures = KrylovFigures { residual: 0.0, applications: 0 };
    if size == 0.0 {
        return KrylovSolution { x, figures };
    }
    let mut residual = rhs.to_vec();
    let mut prepared = vec![0.0; rhs.len()];
    loop {
        let start = norm(&residual);
        figures.residual = start / size;
        if figures.residual <= tolerance
            || figures.applications >= max_applications
            || system.is_cancelled()
            || !start.is_finite()
        {
            return KrylovSolution { x, figures };
        }
        scale(&mut residual, 1.0 / start);
        let mut basis = vec![residual];
        // The triangular factor is kept column by column, with the rotations that made it.
        let (mut columns, mut rotations): (Vec<Vec<f64>>, Vec<(f64, f64)>) =
            (Vec::new(), Vec::new());
        let mut rest = vec![start];
        while columns.len() < RESTART
            && figures.applications < max_applications
            && !system.is_cancelled()
        {
            let mut v = memory.vector(rhs.len());
            system.precondition(&mut prepared, &basis[columns.len()]);
            system.apply(&mut v, &prepared);
            figures.applications += 1;
            let (mut column, height) = orthogonalise(&mut v, &basis);
            for (i, (c, s)) in rotations.iter().enumerate() {
                (column[i], column[i + 1]) =
                    (c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]);
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
            scale(&mut v, 1.0 / height);
            basis.push(v);
        }
        let mut weights = vec![0.0; columns.len()];
        for i in (0..columns.len()).rev() {
            let known: f64 = (i + 1..columns.len()).map(|j| columns[j][i] * weights[j]).sum();
            weights[i] = (rest[i] - known) / columns[i][i];
        }
        if columns.is_empty() {
            return KrylovSolution { x, figures };
        }
        // Another use of the preconditioner is cheaper than keeping every preconditioned direction.
        let mut sum = vec![0.0; rhs.len()];
        add(&mut sum, &weights, &basis);
        memory.0.append(&mut basis);
        // One of them did not come from the memory.
        memory.0.truncate(RESTART + 1);
        system.precondition(&mut prepared, &sum);
        x.iter_mut().zip(&prepared).for_each(|(x, z)| *x += z);
        if rest[columns.len()].abs() <= tolerance * size || figures.applications >= max_applications
        {
            figures.residual = rest[columns.len()].abs() / size;
            return KrylovSolution { x, figures };
        }
        residual = sum;
        system.apply(&mut residual, &x);
        figures.applications += 1;
        residual.iter_mut().zip(rhs).for_each(|(image, b)| *image = b - *image);
    }
}

/// Subtracts from `v` its components along the directions; returns these components, and the length
/// that is left.
fn orthogonalise(v: &mut [f64], basis: &[Vec<f64>]) -> (Vec<f64>, f64) {
    let (mut along, square) = products(basis, v);
    let minus: Vec<f64> = along.iter().map(|a| -a).collect();
    let mut left = add(v, &minus, basis);
    if left <= CANCELLED * CANCELLED * square {
        let (again, _) = products(basis, v);
        let minus: Vec<f64> = again.iter().map(|a| -a).collect();
        left = add(v, &minus, basis);
        along.iter_mut().zip(again).for_each(|(along, again)| *along += again);
    }
    (along, left.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix of three diagonals, with the middle one or nothing as preconditioner.
    struct Tridiagonal {
        preconditioned: bool,
    }

    impl LinearSystem for Tridiagonal {
        fn apply(&mut self, image: &mut [f64], x: &[f64]) {
            for i in 0..x.len() {
                let (above, below) = (
                    if i + 1 < x.len() { x[i + 1] } else { 0.0 },
                    if i > 0 { x[i - 1] } else { 0.0 },
                );
                image[i] = (2.0 + i as f64) * x[i] + 0.7 * above - 0.2 * below;
            }
        }

        fn precondition(&mut self, x: &mut [f64], rows: &[f64]) {
            for (i, (x, r)) in x.iter_mut().zip(rows).enumerate() {
                *x = if self.preconditioned { r / (2.0 + i as f64) } else { *r };
            }
        }
    }

    #[test]
    fn solves_an_unsymmetric_system_with_restarts_and_without() {
        let mut memory = Memory::default();
        for n in [3, 40, 200] {
            let rhs: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            let KrylovSolution { x, figures } =
                solve(&rhs, 1e-11, 2000, &mut Tridiagonal { preconditioned: false }, &mut memory);
            let mut back = vec![0.0; n];
            Tridiagonal { preconditioned: false }.apply(&mut back, &x);
            let defect =
                norm(&back.iter().zip(&rhs).map(|(a, b)| a - b).collect::<Vec<_>>()) / norm(&rhs);
            assert!(defect <= 1.1e-11 && figures.residual <= 1e-11, "{n}: {defect:e} {figures:?}");
            let KrylovSolution { figures: preconditioned, .. } =
                solve(&rhs, 1e-11, 2000, &mut Tridiagonal { preconditioned: true }, &mut memory);
            assert!(preconditioned.applications <= figures.applications);
        }
        // The system is large enough to restart again and again.
        let rhs: Vec<f64> = (0..2000).map(|i| (i as f64).cos()).collect();
        for _ in 0..3 {
            let KrylovSolution { figures, .. } =
                solve(&rhs, 1e-13, 400, &mut Tridiagonal { preconditioned: false }, &mut memory);
            assert!(
                figures.applications > 2 * RESTART as u64 && memory.0.len() <= RESTART + 1,
                "{} kept",
                memory.0.len()
            );
        }
        assert_eq!(
            solve(&[0.0; 4], 1e-8, 10, &mut Tridiagonal { preconditioned: false }, &mut memory).x,
            [0.0; 4]
        );
    }

    #[test]
    fn directions_are_orthogonal_though_nearly_all_cancels() {
        let first: Vec<f64> = (0..500).map(|i| (0.3 * i as f64).cos()).collect();
        let mut basis = vec![first.clone()];
        scale(&mut basis[0], 1.0 / norm(&first));
        let mut v: Vec<f64> = first.iter().enumerate().map(|(i, x)| x + 1e-9 * i as f64).collect();
        let (along, left) = orthogonalise(&mut v, &basis);
        assert!(
            (left - norm(&v)).abs() <= 1e-12 * left && (along[0] / norm(&first) - 1.0).abs() < 1e-6
        );
        assert!(products(&basis, &v).0[0].abs() <= 1e-15 * norm(&first).max(left));
    }
}
