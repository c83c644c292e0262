//! The decompositions give the matrix back, and the inverse transforms the numbers.

use faer::{Accum, Mat};
use primitives::*;

fn matrix() -> Mat<f64> {
    let rows = [[4.0, 1.0, 0.5], [1.0, 3.0, -0.25], [0.5, -0.25, 2.0]];
    Mat::from_fn(3, 3, |i, j| rows[i][j])
}

fn distance(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (a - b).norm_l2()
}

#[test]
fn every_decomposition_gives_the_matrix_back() {
    let (a, identity) = (matrix(), Mat::<f64>::identity(3, 3));
    let lower = cholesky(a.clone()).unwrap();
    assert!(distance(&(&lower * lower.transpose()), &a) < 1e-14);
    assert!(distance(&(&cholesky_inverse(&lower) * &a), &identity) < 1e-14);
    let mut solved = a.clone();
    cholesky_solve(&lower, &mut solved);
    assert!(distance(&solved, &identity) < 1e-14);
    let mut solved = a.clone();
    solve_lower(lower.as_ref(), &mut solved);
    solve_upper(lower.transpose(), &mut solved);
    assert!(distance(&solved, &identity) < 1e-14);
    assert!(distance(&ColumnPivotLu::new(&a).solve(&a), &identity) < 1e-14);
    let mut solved = a.clone();
    FullPivotLu::new(&a).solve(&mut solved);
    assert!(distance(&solved, &identity) < 1e-14);
    let mut product = Mat::zeros(3, 3);
    multiply(product.as_mut(), Accum::Replace, a.as_ref(), identity.as_ref(), 2.0);
    assert!(distance(&product, &(&a + &a)) < 1e-14);
}

#[test]
fn singular_values_of_a_symmetric_matrix_are_its_eigenvalues() {
    let (a, values) = (matrix(), singular_values(&matrix()).unwrap());
    assert!(values.is_sorted_by(|a, b| a >= b));
    let vectors = eigenvectors(&a).unwrap();
    for (j, value) in values.iter().rev().enumerate() {
        let image = &a * vectors.col(j);
        assert!((image - vectors.col(j) * faer::Scale(*value)).norm_l2() < 1e-13);
    }
    let determinant: f64 = ColumnPivotLu::new(&a).pivots().iter().product();
    assert!((determinant.abs() - values.iter().product::<f64>()).abs() < 1e-12);
}

#[test]
fn inverse_transforms_give_the_numbers_back() {
    let numbers: Vec<f64> = (0..10).map(|i| f64::from(i * i % 7)).collect();
    let (forward, inverse) = (real_transform(10), real_inverse_transform(10));
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut numbers.clone(), &mut spectrum).unwrap();
    let mut back = inverse.make_output_vec();
    inverse.process(&mut spectrum, &mut back).unwrap();
    assert!(back.iter().zip(&numbers).all(|(back, x)| (back / 10.0 - x).abs() < 1e-14));
    let mut complex: Vec<_> =
        numbers.iter().map(|x| rustfft::num_complex::Complex::new(*x, -x)).collect();
    complex_transform(10).process(&mut complex);
    complex_inverse_transform(10).process(&mut complex);
    assert!(
        complex
            .iter()
            .zip(&numbers)
            .all(|(z, x)| { (z.re / 10.0 - x).abs() < 1e-14 && (z.im / 10.0 + x).abs() < 1e-14 })
    );
}

#[test]
fn what_is_not_positive_definite_has_no_factor() {
    assert!(cholesky(Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 2.0 })).is_none());
}
