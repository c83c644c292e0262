//! The transform of a coefficient, as the factors by which a spectrum on a torus is multiplied.

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::components::{Direction, Entry};
use super::mirror::Symmetry;
use super::torus::{Axis, Torus};

/// The symbols of a group of directions on a torus, the transforms' normalisation included.
///
/// A coefficient is even or odd in each offset, so its symbol is real or imaginary and one quadrant
/// of it determines all. With the component along x turned by i in the spectrum's x, and that along
/// y in its y, as sines are against cosines, the matrix of symbols of a wavenumber is real and
/// symmetric.
///
/// Along a mirrored x each column of the spectrum holds the wavenumbers k and length − k as real
/// and imaginary part, so there are two lanes of symbols. An odd component has them the other way
/// round, which the factor i corrects except for the sign of one of them: that sign goes into the
/// odd entries. Antisymmetric fields have odd and even components exchanged, hence the wavenumbers
/// in reverse and, as an odd entry turns a cosine into the negative of a sine, a sign on the odd
/// entries.
#[derive(Clone, Debug)]
pub(crate) struct Symbols {
    /// The directions of the group.
    pub(super) directions: Vec<Direction>,
    /// The count of numbers per column of the spectrum.
    stride: usize,
    /// The symbols by column, then wavenumber along y from 0 to half the torus, then entry of the
    /// packed upper triangle, then lane.
    numbers: Vec<f64>,
}

/// Returns the place of an entry of a symmetric matrix of `size` rows in its packed upper triangle.
pub(super) const fn entry_at(size: usize, row: usize, column: usize) -> usize {
    let (a, b) = if row < column { (row, column) } else { (column, row) };
    a * (2 * size - 1 - a) / 2 + b
}

impl Symbols {
    /// Transforms the coefficients `value`(entry, Δi, Δj) for 0 ≤ Δ ≤ half the torus; they are zero
    /// from `extent` on.
    pub(crate) fn new(
        torus: &Torus,
        directions: &[Direction],
        extent: [usize; 2],
        value: impl Fn(Entry, usize, usize) -> f64 + Sync,
    ) -> Self {
        let size = directions.len();
        let (lanes, columns) = (if torus.x.symmetry.is_some() { 2 } else { 1 }, torus.columns());
        let (waves_y, count) = (torus.y.torus / 2 + 1, size * (size + 1) / 2);
        let stride = waves_y * count * lanes;
        let mut numbers = vec![0.0; columns * stride];
        for row in 0..size {
            for column in row..size {
                let entry = Entry::between(directions[row], directions[column]);
                let packed = entry_at(size, row, column);
                let quadrant = quadrant(torus, entry, extent, |i, j| value(entry, i, j));
                numbers.par_chunks_mut(stride).enumerate().for_each(|(kx, numbers)| {
                    for lane in 0..lanes {
                        let (wave_x, sign_x) = wave_along_x(&torus.x, kx, lane, entry.odd_in_x());
                        for ky in 0..waves_y {
                            let (wave_y, sign_y) = match torus.y.symmetry {
                                Some(Symmetry::Antisymmetric) => {
                                    (waves_y - 1 - ky, if entry.odd_in_y() { -1.0 } else { 1.0 })
                                }
                                _ => (ky, 1.0),
                            };
                            numbers[(ky * count + packed) * lanes + lane] =
                                sign_x * sign_y * quadrant[wave_x * waves_y + wave_y];
                        }
                    }
                });
            }
        }
        Self { directions: directions.to_vec(), stride, numbers }
    }

    /// Returns the symbols of one column of the spectrum, by wavenumber along y.
    pub(super) fn column<const S: usize, const LANES: usize>(
        &self,
        column: usize,
    ) -> &[[[f64; LANES]; S]] {
        self.numbers[column * self.stride..(column + 1) * self.stride]
            .as_chunks::<LANES>()
            .0
            .as_chunks::<S>()
            .0
    }

    /// Raises every symbol to at least `share` of the largest.
    pub(crate) fn raise_to(&mut self, share: f64) {
        let least = share * self.numbers.iter().copied().fold(0.0, f64::max);
        self.numbers.iter_mut().for_each(|value| *value = value.max(least));
    }

    /// Returns the smallest symbol.
    pub(crate) fn least(&self) -> f64 {
        self.numbers.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Returns the number of directions.
    pub(crate) fn fields(&self) -> usize {
        self.directions.len()
    }

    /// Returns the memory held, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.numbers.as_slice())
    }
}

/// Returns the wavenumber along x of a lane of a column, and the sign of an entry there.
fn wave_along_x(x: &Axis, column: usize, lane: usize, odd: bool) -> (usize, f64) {
    let Some(symmetry) = x.symmetry else { return (column, 1.0) };
    let first = (lane == 0) == (symmetry == Symmetry::Symmetric);
    if first { (column, 1.0) } else { (x.length - column, if odd { -1.0 } else { 1.0 }) }
}

/// Returns the entry's symbol by wavenumber along x, then y, 0 to half the torus, over the product
/// of the transforms' lengths; it is the imaginary part if the entry is odd in one direction.
fn quadrant(
    torus: &Torus,
    entry: Entry,
    extent: [usize; 2],
    value: impl Fn(usize, usize) -> f64 + Sync,
) -> Vec<f64> {
    let [mx, my] = [torus.x.torus, torus.y.torus];
    let [waves_x, waves_y] = [mx / 2 + 1, my / 2 + 1];
    let [along_x, along_y] = [mx, my].map(primitives::real_transform);
    // The transform of an even sequence is real, that of an odd one imaginary.
    let nonzero = |odd: bool, z: Complex<f64>| if odd { z.im } else { z.re };
    let sign = |odd: bool| if odd { -1.0 } else { 1.0 };
    let mut rows = vec![0.0; extent[1] * waves_x];
    rows.par_chunks_mut(waves_x).enumerate().for_each_init(
        || (along_x.make_input_vec(), along_x.make_output_vec(), along_x.make_scratch_vec()),
        |(line, waves, scratch), (dj, row)| {
            line.fill(0.0);
            for di in 0..extent[0] {
                let value = value(di, dj);
                line[(mx - di) % mx] = sign(entry.odd_in_x()) * value;
                line[di] = value;
            }
            let done = along_x.process_with_scratch(line, waves, scratch);
            debug_assert!(done.is_ok());
            row.iter_mut()
                .zip(waves.iter())
                .for_each(|(value, &wave)| *value = nonzero(entry.odd_in_x(), wave));
        },
    );
    // The sign is i · i if the entry is odd in both directions.
    let normalisation =
        sign(entry.odd_in_x() && entry.odd_in_y()) / (torus.x.length * torus.y.length) as f64;
    let mut quadrant = vec![0.0; waves_x * waves_y];
    quadrant.par_chunks_mut(waves_y).enumerate().for_each_init(
        || (along_y.make_input_vec(), along_y.make_output_vec(), along_y.make_scratch_vec()),
        |(line, waves, scratch), (kx, symbols)| {
            line.fill(0.0);
            for dj in 0..extent[1] {
                let value = rows[dj * waves_x + kx];
                line[(my - dj) % my] = sign(entry.odd_in_y()) * value;
                line[dj] = value;
            }
            let done = along_y.process_with_scratch(line, waves, scratch);
            debug_assert!(done.is_ok());
            symbols.iter_mut().zip(waves.iter()).for_each(|(symbol, &wave)| {
                *symbol = normalisation * nonzero(entry.odd_in_y(), wave)
            });
        },
    );
    quadrant
}
