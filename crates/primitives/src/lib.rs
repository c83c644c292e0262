//! Products and decompositions of dense real matrices, and plans of Fourier transforms.
//!
//! All of them are faer's and rustfft's. They stand in a crate of their own because these libraries
//! are generic: whoever calls them compiles them, with everything that lies beneath. A change of
//! `contact`, which is compiled as a library and again for its tests, compiled them twice; now it
//! links them. Matrices are stored by columns, and sizes that do not fit are a panic of faer.
#![forbid(unsafe_code)]

use std::sync::Arc;

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::linalg::solvers::{FullPivLu, PartialPivLu, Solve};
use faer::linalg::{matmul, svd, triangular_solve};
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

/// Computes `out` = `factor`·A B, or adds it, as `accum` says, on one thread.
pub fn multiply(
    out: MatMut<'_, f64>,
    accum: Accum,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    factor: f64,
) {
    matmul::matmul(out, accum, a, b, factor, Par::Seq);
}

/// Returns the lower triangular factor L with LLᵀ = `matrix`, or `None` unless the matrix is
/// positive definite to rounding. It uses one thread, so that the result is the same on any number
/// of threads.
pub fn cholesky(mut matrix: Mat<f64>) -> Option<Mat<f64>> {
    let size = matrix.nrows();
    let mut memory = MemBuffer::new(llt::factor::cholesky_in_place_scratch::<f64>(
        size,
        Par::Seq,
        Default::default(),
    ));
    llt::factor::cholesky_in_place(
        matrix.as_mut(),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .ok()?;
    for j in 0..size {
        if !(matrix[(j, j)].is_finite() && matrix[(j, j)] > 0.0) {
            return None;
        }
        for i in 0..j {
            matrix[(i, j)] = 0.0;
        }
    }
    Some(matrix)
}

/// Returns the inverse of LLᵀ from its factor L, on one thread.
pub fn cholesky_inverse(lower: &Mat<f64>) -> Mat<f64> {
    let size = lower.nrows();
    let mut inverse = Mat::zeros(size, size);
    let mut memory = MemBuffer::new(llt::inverse::inverse_scratch::<f64>(size, Par::Seq));
    llt::inverse::inverse(inverse.as_mut(), lower.as_ref(), Par::Seq, MemStack::new(&mut memory));
    for j in 0..size {
        for i in 0..j {
            inverse[(i, j)] = inverse[(j, i)];
        }
    }
    inverse
}

/// Solves LLᵀ x = `right` in place from the factor L, on one thread.
pub fn cholesky_solve(lower: &Mat<f64>, right: &mut Mat<f64>) {
    let scratch = llt::solve::solve_in_place_scratch::<f64>(lower.nrows(), right.ncols(), Par::Seq);
    let mut memory = MemBuffer::new(scratch);
    llt::solve::solve_in_place(
        lower.as_ref(),
        right.as_mut(),
        Par::Seq,
        MemStack::new(&mut memory),
    );
}

/// Solves L x = `right` in place for a lower triangular L, on one thread.
pub fn solve_lower(lower: MatRef<'_, f64>, right: &mut Mat<f64>) {
    triangular_solve::solve_lower_triangular_in_place(lower, right.as_mut(), Par::Seq);
}

/// Solves U x = `right` in place for an upper triangular U, on one thread.
pub fn solve_upper(upper: MatRef<'_, f64>, right: &mut Mat<f64>) {
    triangular_solve::solve_upper_triangular_in_place(upper, right.as_mut(), Par::Seq);
}

/// Returns the eigenvectors of a symmetric matrix as columns, in ascending order of their
/// eigenvalues, or `None` if the decomposition fails.
pub fn eigenvectors(symmetric: &Mat<f64>) -> Option<Mat<f64>> {
    Some(symmetric.self_adjoint_eigen(Side::Lower).ok()?.U().to_owned())
}

/// Returns the singular values of a square matrix in descending order, or `None` if the
/// decomposition fails. It uses one thread, so that the result is the same on any number of
/// threads.
pub fn singular_values(matrix: &Mat<f64>) -> Option<Vec<f64>> {
    let size = matrix.nrows();
    let none = svd::ComputeSvdVectors::No;
    let mut memory = MemBuffer::new(svd::svd_scratch::<f64>(
        size,
        size,
        none,
        none,
        Par::Seq,
        Default::default(),
    ));
    let mut values = Diag::zeros(size);
    svd::svd(
        matrix.as_ref(),
        values.as_mut(),
        None,
        None,
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .ok()?;
    Some(values.column_vector().iter().copied().collect())
}

/// A square matrix, factored with pivots chosen in columns.
pub struct ColumnPivotLu(PartialPivLu<f64>);

impl ColumnPivotLu {
    /// Factors a matrix.
    pub fn new(matrix: &Mat<f64>) -> Self {
        Self(matrix.partial_piv_lu())
    }

    /// Returns the x of A x = `right`. It is not finite if the matrix is singular.
    pub fn solve(&self, right: &Mat<f64>) -> Mat<f64> {
        self.0.solve(right)
    }

    /// Returns the pivots: the diagonal of the upper triangular factor.
    pub fn pivots(&self) -> Vec<f64> {
        let upper = self.0.U();
        (0..upper.nrows()).map(|i| upper[(i, i)]).collect()
    }

    /// Returns for each row of the factors the row of the matrix that it came from.
    pub fn permutation(&self) -> &[usize] {
        self.0.P().arrays().0
    }
}

/// A square matrix, factored with pivots chosen anywhere.
pub struct FullPivotLu(FullPivLu<f64>);

impl FullPivotLu {
    /// Factors a matrix.
    pub fn new(matrix: &Mat<f64>) -> Self {
        Self(matrix.full_piv_lu())
    }

    /// Solves A x = `right` in place. The x is not finite if the matrix is singular.
    pub fn solve(&self, right: &mut Mat<f64>) {
        self.0.solve_in_place(right.as_mut());
    }
}

/// Plans the transform of `length` real numbers to half of their spectrum.
pub fn real_transform(length: usize) -> Arc<dyn RealToComplex<f64>> {
    RealFftPlanner::new().plan_fft_forward(length)
}

/// Plans the transform of half a spectrum to `length` real numbers, `length` times too large.
pub fn real_inverse_transform(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    RealFftPlanner::new().plan_fft_inverse(length)
}

/// Plans the transform of `length` complex numbers to their spectrum.
pub fn complex_transform(length: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_forward(length)
}

/// Plans the transform of a spectrum to `length` complex numbers, `length` times too large.
pub fn complex_inverse_transform(length: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_inverse(length)
}
