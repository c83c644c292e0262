//! Operations on long vectors. Sums are taken in chunks of fixed length, and the chunks are added
//! in order, so that a result has the same bytes on any number of threads.

use rayon::prelude::*;

use crate::common::parallel::is_worth_sharing;

/// The length of a chunk: with one chunk of another vector it fits in a core's first cache.
const CHUNK: usize = 2048;

/// Returns the products of `v` with every direction, and v·v, in one pass over the vectors.
pub(super) fn products(basis: &[Vec<f64>], v: &[f64]) -> (Vec<f64>, f64) {
    let count = basis.len() + 1;
    let mut chunk_sums = vec![0.0; v.len().div_ceil(CHUNK) * count];
    let work = |(chunk, (sums, v)): (usize, (&mut [f64], &[f64]))| {
        for (sum, direction) in sums.iter_mut().zip(basis) {
            *sum = chunk_dot(&direction[chunk * CHUNK..][..v.len()], v);
        }
        sums[basis.len()] = chunk_dot(v, v);
    };
    if is_worth_sharing(v.len() * count) {
        chunk_sums.par_chunks_mut(count).zip(v.par_chunks(CHUNK)).enumerate().for_each(work);
    } else {
        chunk_sums.chunks_mut(count).zip(v.chunks(CHUNK)).enumerate().for_each(work);
    }
    let mut sums = vec![0.0; count];
    for chunk in chunk_sums.chunks_exact(count) {
        sums.iter_mut().zip(chunk).for_each(|(sum, of_chunk)| *sum += of_chunk);
    }
    let square = sums.pop().unwrap_or(0.0);
    (sums, square)
}

/// Adds Σ weight · direction to `v`; returns v·v of the sum.
pub(super) fn add(v: &mut [f64], weights: &[f64], basis: &[Vec<f64>]) -> f64 {
    let work = |(chunk, v): (usize, &mut [f64])| {
        for (weight, direction) in weights.iter().zip(basis) {
            v.iter_mut().zip(&direction[chunk * CHUNK..]).for_each(|(v, d)| *v += weight * d);
        }
        chunk_dot(v, v)
    };
    let squares: Vec<f64> = if is_worth_sharing(v.len() * (1 + weights.len())) {
        v.par_chunks_mut(CHUNK).enumerate().map(work).collect()
    } else {
        v.chunks_mut(CHUNK).enumerate().map(work).collect()
    };
    squares.iter().sum()
}

/// Returns a·b.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let products: Vec<f64> = if is_worth_sharing(a.len()) {
        a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK)).map(|(a, b)| chunk_dot(a, b)).collect()
    } else {
        a.chunks(CHUNK).zip(b.chunks(CHUNK)).map(|(a, b)| chunk_dot(a, b)).collect()
    };
    products.iter().sum()
}

/// Returns √(a·a).
pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Multiplies `v` by `factor`.
pub(super) fn scale(v: &mut [f64], factor: f64) {
    let work = |v: &mut [f64]| v.iter_mut().for_each(|v| *v *= factor);
    if is_worth_sharing(v.len()) { v.par_chunks_mut(CHUNK).for_each(work) } else { work(v) }
}

/// Returns a·b of one chunk, in eight sums side by side, as the processor has room for.
fn chunk_dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_left), (b, b_left)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + a_left.iter().zip(b_left).map(|(a, b)| a * b).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::common::parallel::WORTH_SHARING;

    #[test]
    fn same_bytes_on_any_number_of_threads() {
        for n in [0, 5, 3 * WORTH_SHARING + 7] {
            let vector = |phase: f64| -> Vec<f64> {
                (0..n).map(|i| (0.37 * i as f64 + phase).sin()).collect()
            };
            let (basis, v) = ([vector(1.0), vector(2.0)], vector(3.0));
            let with = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| {
                    let mut sum = v.clone();
                    let square = add(&mut sum, &[0.5, -0.25], &basis);
                    scale(&mut sum, 0.1);
                    (products(&basis, &v), square, dot(&v, &basis[0]), sum)
                })
            };
            assert_eq!(with(1), with(3));
            let ((products, square), after, alone, sum) = with(2);
            let exact = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * (1.0 + n as f64);
            assert!(close(products[1], exact(&basis[1], &v)) && close(square, exact(&v, &v)));
            assert!(close(after, 100.0 * exact(&sum, &sum)) && alone == products[0]);
            assert!(
                (0..n).all(|i| (sum[i] - 0.1 * (v[i] + 0.5 * basis[0][i] - 0.25 * basis[1][i]))
                    .abs()
                    < 1e-15)
            );
        }
    }
}
