//! The circulant nearest to each diagonal block of A, and its inverse: the preconditioner of the Krylov iterations.
//!
//! T. Chan's optimal circulant of a Toeplitz matrix (SIAM J. Sci. Stat. Comput. 9 (1988) 766–771, doi:10.1137/0909051), in both
//! directions: it lives on a torus of the grid's own size, and is positive definite where the block is.

use std::fmt;
use std::sync::Arc;

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use crate::influence::{Component, InfluenceTable};

/// Inverse circulants of the blocks nn, xx and yy.
#[derive(Clone)]
pub struct Circulant {
    nx: usize,
    ny: usize,
    /// Eigenvalues of the circulants over their number, by wavenumber, x fastest, as [nn, xx, yy].
    eigenvalues: Vec<[f64; 3]>,
    forward: [Arc<dyn Fft<f64>>; 2],
    backward: [Arc<dyn Fft<f64>>; 2],
}

impl fmt::Debug for Circulant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Circulant").field("nx", &self.nx).field("ny", &self.ny).finish_non_exhaustive()
    }
}

impl Circulant {
    /// The circulants of these coefficients.
    pub fn new(table: &InfluenceTable) -> Self {
        let (nx, ny) = (table.grid().nx(), table.grid().ny());
        let mut planner = FftPlanner::new();
        let lengths = [nx, ny];
        let mut circulant = Self {
            nx,
            ny,
            eigenvalues: vec![[0.0; 3]; nx * ny],
            forward: lengths.map(|n| planner.plan_fft_forward(n)),
            backward: lengths.map(|n| planner.plan_fft_inverse(n)),
        };
        // both ways round the torus, each with its share
        let wraps = |i: usize, n: usize| {
            [(i, (n - i) as f64 / n as f64), (n - i, i as f64 / n as f64)].into_iter().filter(|(_, share)| *share > 0.0)
        };
        for (which, component) in [Component::Nn, Component::Xx, Component::Yy].into_iter().enumerate() {
            let mut first: Vec<Complex<f64>> = (0..nx * ny)
                .map(|at| {
                    let (i, j) = (at % nx, at / nx);
                    let mut sum = 0.0;
                    for (dj, wy) in wraps(j, ny) {
                        let row = table.row(component, dj as i64);
                        sum += wraps(i, nx).map(|(di, wx)| wx * wy * row[nx - 1 + di]).sum::<f64>();
                    }
                    Complex::new(sum, 0.0)
                })
                .collect();
            circulant.transform(&mut first, &circulant.forward);
            let largest = first.iter().map(|value| value.re).fold(0.0, f64::max);
            for (eigenvalues, value) in circulant.eigenvalues.iter_mut().zip(&first) {
                // collocation is not quite positive definite
                eigenvalues[which] = value.re.max(1e-6 * largest);
            }
        }
        circulant
    }

    /// `field` (blocks n | x | y) ↦ (C + `epsilon`)⁻¹ `field`, block by block, in place.
    pub fn solve(&self, field: &mut [f64], epsilon: f64) {
        let k = self.nx * self.ny;
        let count = k as f64;
        let (normal, tangential) = field.split_at_mut(k);
        let (along_x, along_y) = tangential.split_at_mut(k);
        let mut wave: Vec<Complex<f64>> = normal.iter().map(|x| Complex::new(*x, 0.0)).collect();
        self.transform(&mut wave, &self.forward);
        for (value, eigenvalues) in wave.iter_mut().zip(&self.eigenvalues) {
            *value /= count * (eigenvalues[0] + epsilon);
        }
        self.transform(&mut wave, &self.backward);
        normal.iter_mut().zip(&wave).for_each(|(x, value)| *x = value.re);

        if along_x.iter().chain(&*along_y).all(|x| *x == 0.0) {
            return;
        }
        // two real fields in one transform
        wave.iter_mut().zip(along_x.iter().zip(&*along_y)).for_each(|(value, (x, y))| *value = Complex::new(*x, *y));
        self.transform(&mut wave, &self.forward);
        for j in 0..self.ny {
            for i in 0..self.nx {
                let (at, mirrored) = (j * self.nx + i, ((self.ny - j) % self.ny) * self.nx + (self.nx - i) % self.nx);
                if mirrored < at {
                    continue;
                }
                let (here, there) = (wave[at], wave[mirrored].conj());
                let (x, iy) = ((here + there) * 0.5, (here - there) * 0.5);
                let [_, xx, yy] = self.eigenvalues[at];
                let (x, iy) = (x / (count * (xx + epsilon)), iy / (count * (yy + epsilon)));
                wave[at] = x + iy;
                wave[mirrored] = (x - iy).conj();
            }
        }
        self.transform(&mut wave, &self.backward);
        for (value, (x, y)) in wave.iter().zip(along_x.iter_mut().zip(along_y)) {
            (*x, *y) = (value.re, value.im);
        }
    }

    /// Transforms rows, then columns, without normalisation.
    fn transform(&self, wave: &mut [Complex<f64>], plans: &[Arc<dyn Fft<f64>>; 2]) {
        plans[0].process(wave);
        let mut column = vec![Complex::default(); self.ny];
        let mut scratch = vec![Complex::default(); plans[1].get_inplace_scratch_len()];
        for i in 0..self.nx {
            for (j, value) in column.iter_mut().enumerate() {
                *value = wave[j * self.nx + i];
            }
            plans[1].process_with_scratch(&mut column, &mut scratch);
            for (j, value) in column.iter().enumerate() {
                wave[j * self.nx + i] = *value;
            }
        }
    }

    /// Memory held, in bytes, the plans of the transforms left out.
    pub fn bytes(&self) -> usize {
        size_of_val(self.eigenvalues.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foundation::half_space::HalfSpace;
    use crate::grid::Grid;
    use crate::scene::{Material, Projection};

    /// On a torus of circulant coefficients the inverse is exact: C (C⁻¹ x) = x, C applied entry by entry.
    #[test]
    fn inverts_the_circulant_it_is_made_of() {
        let (nx, ny) = (6, 5);
        let grid = Grid::new(nx, ny, 0.3, 0.4, [0.0; 2]).unwrap();
        let bodies = HalfSpace::new(&Material { shear_modulus: 1.0, poisson: 0.3 }, None);
        let table = InfluenceTable::new(&grid, &bodies, Projection::Average);
        let circulant = Circulant::new(&table);
        let k = nx * ny;
        let field: Vec<f64> = (0..3 * k).map(|at| (1.7 * at as f64).sin()).collect();
        let epsilon = 0.01;
        let mut solved = field.clone();
        circulant.solve(&mut solved, epsilon);
        for (block, component) in [Component::Nn, Component::Xx, Component::Yy].into_iter().enumerate() {
            for at in 0..k {
                let (i, j) = (at % nx, at / nx);
                let mut sum = epsilon * solved[block * k + at];
                for other in 0..k {
                    let (di, dj) = ((i + nx - other % nx) % nx, (j + ny - other / nx) % ny);
                    let mut entry = 0.0;
                    for (dj, wy) in [(dj, ny - dj), (ny - dj, dj)].into_iter().filter(|(_, w)| *w > 0) {
                        for (di, wx) in [(di, nx - di), (nx - di, di)].into_iter().filter(|(_, w)| *w > 0) {
                            entry += (wx * wy) as f64 / k as f64 * table.row(component, dj as i64)[nx - 1 + di];
                        }
                    }
                    sum += entry * solved[block * k + other];
                }
                assert!((sum - field[block * k + at]).abs() < 1e-12, "{component:?} {at}");
            }
        }
    }
}
