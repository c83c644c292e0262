//! The symbols of an operator without symmetry along x: one complex matrix for each wavenumber.

use rayon::prelude::*;
use realfft::num_complex::Complex;
use realfft::num_traits::Zero;

use super::components::Direction;
use super::mirror::Symmetry;
use super::torus::Torus;

/// The symbols of a group of directions on a torus, the transforms' normalisation included, for
/// coefficients that are even or odd in Δj and anything in Δi. There is no mirror along x.
///
/// The components along x and y are turned by i as those of [`Symbols`](super::symbols::Symbols)
/// are. Coefficients with the symmetries of those have the same symbols here.
#[derive(Clone, Debug)]
pub(crate) struct MatrixSymbols {
    /// The directions of the group.
    pub(super) directions: Vec<Direction>,
    /// The count of numbers per column of the spectrum.
    stride: usize,
    /// The symbols by column, then wavenumber along y from 0 to half the torus, then row and
    /// column of the matrix.
    numbers: Vec<Complex<f64>>,
}

impl MatrixSymbols {
    /// Transforms the coefficients `value`(\[displaced, loaded\], place, Δj), where the place along
    /// x is Δi, or Δi plus the length of the torus, and 0 ≤ Δj ≤ half the torus; they are zero from
    /// `extent` on along y.
    ///
    /// # Panics
    /// If x is mirrored.
    pub(crate) fn new(
        torus: &Torus,
        directions: &[Direction],
        extent: usize,
        value: impl Fn([Direction; 2], usize, usize) -> f64 + Sync,
    ) -> Self {
        assert!(torus.x.symmetry.is_none(), "what rolls has no mirror across the way that it goes");
        let (size, columns, waves_y) = (directions.len(), torus.columns(), torus.y.torus / 2 + 1);
        let stride = waves_y * size * size;
        let mut numbers = vec![Complex::zero(); columns * stride];
        let turn = |direction: Direction| match direction {
            Direction::N => Complex::new(1.0, 0.0),
            Direction::X | Direction::Y => Complex::new(0.0, 1.0),
        };
        for (row, &displaced) in directions.iter().enumerate() {
            for (column, &loaded) in directions.iter().enumerate() {
                let odd = (displaced == Direction::Y) != (loaded == Direction::Y);
                let half = half_plane(torus, odd, extent, |place, dj| {
                    value([displaced, loaded], place, dj)
                });
                let turned = turn(displaced) * turn(loaded).conj();
                numbers.par_chunks_mut(stride).enumerate().for_each(|(kx, numbers)| {
                    for ky in 0..waves_y {
                        // The wavenumbers of antisymmetric fields are in reverse, as in `Symbols`.
                        let (wave, sign) = match torus.y.symmetry {
                            Some(Symmetry::Antisymmetric) => {
                                (waves_y - 1 - ky, if odd { -1.0 } else { 1.0 })
                            }
                            _ => (ky, 1.0),
                        };
                        numbers[(ky * size + row) * size + column] =
                            turned * half[kx * waves_y + wave] * sign;
                    }
                });
            }
        }
        Self { directions: directions.to_vec(), stride, numbers }
    }

    /// Returns the matrix of a wavenumber: that of a column of the spectrum, and one along y.
    pub(super) fn matrix<const F: usize>(
        &self,
        column: usize,
        wave: usize,
    ) -> [[Complex<f64>; F]; F] {
        let numbers = &self.numbers[column * self.stride + wave * F * F..][..F * F];
        std::array::from_fn(|row| std::array::from_fn(|entry| numbers[row * F + entry]))
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

/// Returns the symbol by wavenumber along x, then y, 0 to half the torus, over the product of the
/// transforms' lengths, of coefficients that are `odd` in Δj or even.
fn half_plane(
    torus: &Torus,
    odd: bool,
    extent: usize,
    value: impl Fn(usize, usize) -> f64 + Sync,
) -> Vec<Complex<f64>> {
    let [mx, my] = [torus.x.torus, torus.y.torus];
    let [waves_x, waves_y] = [mx / 2 + 1, my / 2 + 1];
    let [along_x, along_y] = [mx, my].map(primitives::real_transform);
    let mut rows = vec![Complex::zero(); extent * waves_x];
    rows.par_chunks_mut(waves_x).enumerate().for_each_init(
        || (along_x.make_input_vec(), along_x.make_scratch_vec()),
        |(line, scratch), (dj, row)| {
            line.iter_mut().enumerate().for_each(|(place, number)| *number = value(place, dj));
            let done = along_x.process_with_scratch(line, row, scratch);
            debug_assert!(done.is_ok());
        },
    );
    let normalisation = 1.0 / (torus.x.length * torus.y.length) as f64;
    let mut half = vec![Complex::zero(); waves_x * waves_y];
    half.par_chunks_mut(waves_y).enumerate().for_each_init(
        || (along_y.make_input_vec(), along_y.make_output_vec(), along_y.make_scratch_vec()),
        |(line, waves, scratch), (kx, symbols)| {
            // Both parts of the number that stands before the wave are transformed for themselves.
            for part in [Complex::new(1.0, 0.0), Complex::new(0.0, 1.0)] {
                line.fill(0.0);
                for dj in 0..extent {
                    let row = rows[dj * waves_x + kx];
                    let number = if part.re > 0.0 { row.re } else { row.im };
                    line[(my - dj) % my] = if odd { -number } else { number };
                    line[dj] = number;
                }
                let done = along_y.process_with_scratch(line, waves, scratch);
                debug_assert!(done.is_ok());
                for (symbol, wave) in symbols.iter_mut().zip(waves.iter()) {
                    // The transform of an even sequence is real, that of an odd one imaginary.
                    let along =
                        if odd { Complex::new(0.0, wave.im) } else { Complex::new(wave.re, 0.0) };
                    *symbol += part * along * normalisation;
                }
            }
        },
    );
    half
}
