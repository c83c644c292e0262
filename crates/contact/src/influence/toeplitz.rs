//! The operator as a block-Toeplitz matrix, applied by FFT.
//!
//! A coefficient depends on the offset only, so A p is a convolution. It is cyclic on a torus of at least
//! (2nx − 1) × (2ny − 1) elements, where Fourier's transform makes it a product with the symbol of each component. A
//! coefficient is even or odd in each offset, so its symbol is real or imaginary and one quadrant of it is kept.
//!
//! One application: real transforms of the ny rows that are not padding; then for each wavenumber along x a transform
//! along y, the product, and back; then the rows back. Each step writes what only it owns, in parallel: the rows, then
//! tiles of a few columns, then the rows of the result.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use realfft::num_complex::Complex;
use realfft::num_traits::Zero;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

use super::{Component, Influence, InfluenceTable, Scratch, ScratchSize};
use crate::grid::Grid;

/// Columns of the spectrum that are transformed together; four complex numbers fill a cache line.
const TILE: usize = 4;

/// A by FFT: memory O(k), an application O(k log k).
#[derive(Clone)]
pub struct Toeplitz {
    grid: Grid,
    /// Elements of the torus along x and y.
    torus: [usize; 2],
    /// By wavenumber, along y fastest, 0 … half the torus each way: the symbol of each [`Component`] or, where that is
    /// imaginary (nx, ny), its imaginary part; the transforms' normalisation included.
    symbols: Vec<[f64; 6]>,
    row_forward: Arc<dyn RealToComplex<f64>>,
    row_backward: Arc<dyn ComplexToReal<f64>>,
    column_forward: Arc<dyn Fft<f64>>,
    column_backward: Arc<dyn Fft<f64>>,
}

impl fmt::Debug for Toeplitz {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Toeplitz").field("grid", &self.grid).field("torus", &self.torus).finish_non_exhaustive()
    }
}

/// The smallest length ≥ 2n − 1 that has no prime factor above 5, even unless it is 1.
fn torus_length(n: usize) -> usize {
    let smooth = |mut m: usize| {
        for factor in [2, 3, 5] {
            while m.is_multiple_of(factor) {
                m /= factor;
            }
        }
        m == 1
    };
    if n == 1 {
        return 1;
    }
    let mut half = n;
    while !smooth(half) {
        half += 1;
    }
    2 * half
}

impl Toeplitz {
    /// The operator of these coefficients on Ω of the table's grid.
    pub fn new(table: &InfluenceTable) -> Self {
        let grid = table.grid().clone();
        let torus = [torus_length(grid.nx()), torus_length(grid.ny())];
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        let row_forward = real.plan_fft_forward(torus[0]);
        let symbols = symbols(table, torus, &*row_forward, &*real.plan_fft_forward(torus[1]));
        Self {
            symbols,
            row_forward,
            row_backward: real.plan_fft_inverse(torus[0]),
            column_forward: complex.plan_fft_forward(torus[1]),
            column_backward: complex.plan_fft_inverse(torus[1]),
            grid,
            torus,
        }
    }

    /// Memory held, in bytes, the plans of the transforms left out.
    pub fn bytes(&self) -> usize {
        size_of_val(self.symbols.as_slice())
    }

    /// Wavenumbers along x of a real field.
    fn waves(&self) -> usize {
        self.torus[0] / 2 + 1
    }

    fn tiles(&self) -> usize {
        self.waves().div_ceil(TILE)
    }

    /// Complex numbers that one thread needs for `fields` fields: columns of a tile, and what the transforms ask for.
    fn slot_size(&self, fields: usize) -> [usize; 2] {
        let transforms = [
            self.row_forward.get_scratch_len(),
            self.row_backward.get_scratch_len(),
            self.column_forward.get_inplace_scratch_len(),
            self.column_backward.get_inplace_scratch_len(),
        ];
        let columns = (fields * TILE * self.torus[1]).max(self.waves());
        [columns, transforms.into_iter().max().unwrap_or(0)]
    }

    fn size(&self, fields: usize, threads: usize) -> ScratchSize {
        let spectrum = fields * self.grid.ny() * self.waves();
        let tiles = fields * self.grid.ny() * self.tiles() * TILE;
        let slot: usize = self.slot_size(fields).iter().sum();
        ScratchSize { real: threads * self.torus[0], complex: spectrum + tiles + threads * slot }
    }

    /// Convolves F fields (3: all, 1: normal only).
    fn convolve<const F: usize>(&self, out: &mut [f64], p: &[f64], scratch: &mut Scratch) {
        let (nx, ny, k) = (self.grid.nx(), self.grid.ny(), self.grid.len());
        assert_eq!((out.len(), p.len()), (F * k, F * k), "fields on another grid");
        let (waves, rows) = (self.waves(), F * ny);
        let [columns, transform] = self.slot_size(F);
        let threads = scratch.threads;
        let (real, complex) = scratch.take(self.size(F, threads));
        let (spectrum, complex) = complex.split_at_mut(rows * waves);
        let (tiles, complex) = complex.split_at_mut(rows * self.tiles() * TILE);
        let mut slots: Vec<Slot<'_>> = real
            .chunks_exact_mut(self.torus[0])
            .zip(complex.chunks_exact_mut(columns + transform))
            .map(|(row, complex)| {
                let (columns, transform) = complex.split_at_mut(columns);
                Slot { row, columns, transform }
            })
            .collect();

        share(spectrum, waves, &mut slots, |at, waves, slot| {
            let (block, j) = (at / ny, at % ny);
            let elements = j * nx..(j + 1) * nx;
            slot.row[nx..].fill(0.0);
            slot.row[..nx].copy_from_slice(&p[block * k + elements.start..block * k + elements.end]);
            self.clear_masked(&mut slot.row[..nx], elements);
            let done = self.row_forward.process_with_scratch(slot.row, waves, slot.transform);
            debug_assert!(done.is_ok());
        });

        share(tiles, rows * TILE, &mut slots, |at, tile, slot| {
            self.convolve_columns::<F>(at * TILE..waves.min((at + 1) * TILE), spectrum, tile, slot);
        });

        share(out, nx, &mut slots, |at, row, slot| {
            let wave_row = &mut slot.columns[..waves];
            for (part, tile) in wave_row.chunks_mut(TILE).zip(tiles.chunks_exact(rows * TILE)) {
                part.copy_from_slice(&tile[at * TILE..][..part.len()]);
            }
            // Zero but for rounding, as a real field's must be.
            wave_row[0].im = 0.0;
            if self.torus[0].is_multiple_of(2) {
                wave_row[waves - 1].im = 0.0;
            }
            let done = self.row_backward.process_with_scratch(wave_row, slot.row, slot.transform);
            debug_assert!(done.is_ok());
            row.copy_from_slice(&slot.row[..nx]);
            let j = at % ny;
            self.clear_masked(row, j * nx..(j + 1) * nx);
        });
    }

    /// Transforms columns of the spectrum (blocks of ny rows) along y, multiplies, transforms back: tile = rows × TILE.
    fn convolve_columns<const F: usize>(
        &self,
        waves: Range<usize>,
        spectrum: &[Complex<f64>],
        tile: &mut [Complex<f64>],
        slot: &mut Slot<'_>,
    ) {
        let (ny, my, stride) = (self.grid.ny(), self.torus[1], self.waves());
        let width = waves.len();
        let buffer = &mut slot.columns[..F * width * my];
        for block in 0..F {
            let columns = &mut buffer[block * width * my..(block + 1) * width * my];
            for column in columns.chunks_exact_mut(my) {
                column[ny..].fill(Complex::zero());
            }
            for j in 0..ny {
                let from = &spectrum[(block * ny + j) * stride..][waves.clone()];
                for (c, &value) in from.iter().enumerate() {
                    columns[c * my + j] = value;
                }
            }
        }
        self.column_forward.process_with_scratch(buffer, slot.transform);
        let kept = my / 2 + 1;
        for (c, wave) in waves.enumerate() {
            let symbols = &self.symbols[wave * kept..(wave + 1) * kept];
            for ky in 0..my {
                let (at, mirror) = if ky < kept { (ky, 1.0) } else { (my - ky, -1.0) };
                let [nn, xx, yy, xy, n_x, n_y] = symbols[at];
                let (xy, n_y) = (mirror * xy, mirror * n_y);
                let index = |block: usize| (block * width + c) * my + ky;
                if F == 1 {
                    buffer[index(0)] *= nn;
                    continue;
                }
                let [pn, px, py] = [0, 1, 2].map(|block| buffer[index(block)]);
                let i = |z: Complex<f64>| Complex::new(-z.im, z.re);
                buffer[index(0)] = pn * nn + i(px * n_x + py * n_y);
                buffer[index(1)] = px * xx + py * xy - i(pn * n_x);
                buffer[index(2)] = px * xy + py * yy - i(pn * n_y);
            }
        }
        self.column_backward.process_with_scratch(buffer, slot.transform);
        for (at, to) in tile.chunks_exact_mut(TILE).enumerate() {
            let (block, j) = (at / ny, at % ny);
            for (c, value) in to[..width].iter_mut().enumerate() {
                *value = buffer[(block * width + c) * my + j];
            }
        }
    }

    fn clear_masked(&self, row: &mut [f64], elements: Range<usize>) {
        if let Some(mask) = self.grid.mask() {
            for (value, &inside) in row.iter_mut().zip(&mask[elements]) {
                if !inside {
                    *value = 0.0;
                }
            }
        }
    }
}

/// What one thread works in.
struct Slot<'a> {
    row: &'a mut [f64],
    columns: &'a mut [Complex<f64>],
    transform: &'a mut [Complex<f64>],
}

/// Works on every `unit` of `whole`, a slot's worth of neighbours each on its own thread. What a unit becomes depends on
/// its number only.
fn share<T: Send>(whole: &mut [T], unit: usize, slots: &mut [Slot<'_>], work: impl Fn(usize, &mut [T], &mut Slot<'_>) + Sync) {
    if let [slot] = slots {
        whole.chunks_exact_mut(unit).enumerate().for_each(|(at, part)| work(at, part, slot));
        return;
    }
    let each = (whole.len() / unit).div_ceil(slots.len());
    whole.par_chunks_mut(each * unit).zip(slots).enumerate().for_each(|(chunk, (parts, slot))| {
        for (at, part) in parts.chunks_exact_mut(unit).enumerate() {
            work(chunk * each + at, part, slot);
        }
    });
}

/// One quadrant of the symbols, along y fastest, divided by the number of elements of the torus.
fn symbols(table: &InfluenceTable, torus: [usize; 2], along_x: &dyn RealToComplex<f64>, along_y: &dyn RealToComplex<f64>) -> Vec<[f64; 6]> {
    let (nx, ny) = (table.grid().nx(), table.grid().ny());
    let [waves_x, waves_y] = torus.map(|m| m / 2 + 1);
    let normalisation = 1.0 / (torus[0] * torus[1]) as f64;
    // The transform of an even sequence is real, of an odd one imaginary.
    let part = |odd: bool, z: Complex<f64>| if odd { z.im } else { z.re };
    let mut symbols = vec![[0.0; 6]; waves_x * waves_y];
    let mut rows = vec![0.0; ny * waves_x];
    for component in Component::ALL {
        rows.par_chunks_mut(waves_x).enumerate().for_each_init(
            || (along_x.make_input_vec(), along_x.make_output_vec(), along_x.make_scratch_vec()),
            |(line, waves, scratch), (dj, row)| {
                let coefficients = table.row(component, dj as i64);
                line.fill(0.0);
                line[..nx].copy_from_slice(&coefficients[nx - 1..]);
                line[torus[0] - (nx - 1)..].copy_from_slice(&coefficients[..nx - 1]);
                let done = along_x.process_with_scratch(line, waves, scratch);
                debug_assert!(done.is_ok());
                for (value, &wave) in row.iter_mut().zip(waves.iter()) {
                    *value = part(component.odd_in_x(), wave);
                }
            },
        );
        let mirror = if component.odd_in_y() { -1.0 } else { 1.0 };
        // i · i where the component is odd in both.
        let sign = if component == Component::Xy { -normalisation } else { normalisation };
        symbols.par_chunks_mut(waves_y).enumerate().for_each_init(
            || (along_y.make_input_vec(), along_y.make_output_vec(), along_y.make_scratch_vec()),
            |(line, waves, scratch), (kx, symbols)| {
                line.fill(0.0);
                for dj in (0..ny).rev() {
                    let value = rows[dj * waves_x + kx];
                    line[(torus[1] - dj) % torus[1]] = mirror * value;
                    line[dj] = value;
                }
                let done = along_y.process_with_scratch(line, waves, scratch);
                debug_assert!(done.is_ok());
                for (symbol, &wave) in symbols.iter_mut().zip(waves.iter()) {
                    symbol[component as usize] = sign * part(component.odd_in_y(), wave);
                }
            },
        );
    }
    symbols
}

impl Influence for Toeplitz {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn scratch_size(&self, threads: usize) -> ScratchSize {
        self.size(3, threads)
    }

    fn apply(&self, out: &mut [f64], p: &[f64], scratch: &mut Scratch) {
        self.convolve::<3>(out, p, scratch);
    }

    fn apply_normal(&self, out: &mut [f64], pressure: &[f64], scratch: &mut Scratch) {
        self.convolve::<1>(out, pressure, scratch);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::influence::laws;

    #[test]
    fn obeys_the_laws() {
        laws::hold(|table| Box::new(Toeplitz::new(table)));
    }

    #[test]
    fn torus_leaves_room_for_every_offset_and_suits_the_transform() {
        assert_eq!([1, 2, 3, 4, 7, 11, 512].map(torus_length), [1, 4, 6, 8, 16, 24, 1024]);
    }

    #[test]
    fn same_bytes_on_any_number_of_threads() {
        laws::same_on_any_number_of_threads(|table| Box::new(Toeplitz::new(table)));
    }
}
