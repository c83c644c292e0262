//! The product with symbols in a torus's Fourier space.
//!
//! A convolution consists of real transforms of the rows that are not padding; then, for each
//! column of the spectrum, a transform along y, the product, and the transform back; then the
//! transforms of the rows back. The steps run in parallel over pieces of which each is written by
//! one thread only: the rows, then tiles of a few columns, then the rows of the result.

use std::ops::Range;

use rayon::prelude::*;
use realfft::num_complex::Complex;
use realfft::num_traits::Zero;

use super::components::Direction;
use super::matrix_symbols::MatrixSymbols;
use super::operator::Scratch;
use super::symbols::{Symbols, entry_at};
use super::torus::{TILE, Torus};

impl Torus {
    /// Divides the memory for a convolution of `fields` fields.
    fn work<'a>(&self, fields: usize, scratch: &'a mut Scratch) -> Work<'a> {
        let rows = fields * self.y.elements;
        let [columns, transform] = self.slot_size(fields);
        let size = self.scratch_size(fields, scratch.threads);
        let (real, complex) = scratch.take(size);
        let (spectrum, complex) = complex.split_at_mut(rows * self.columns());
        let (tiles, complex) = complex.split_at_mut(rows * self.tiles() * TILE);
        let slots = real
            .chunks_exact_mut(self.x.length)
            .zip(complex.chunks_exact_mut(columns + transform))
            .map(|(row, complex)| {
                let (columns, transform) = complex.split_at_mut(columns);
                Slot { row, columns, transform }
            })
            .collect();
        Work { spectrum, tiles, slots }
    }

    /// Computes out = the convolution of F fields, one for each of `symbols.directions`, with the
    /// symbols, of which there are S = F·(F+1)/2 for each wavenumber. `entries` turns the packed
    /// symbols of a wavenumber into those to multiply with. With a `mask` only its elements count.
    pub(crate) fn convolve<const F: usize, const S: usize>(
        &self,
        symbols: &Symbols,
        entries: impl Fn([f64; S]) -> [f64; S] + Sync,
        mask: Option<&[bool]>,
        out: &mut [f64],
        p: &[f64],
        scratch: &mut Scratch,
    ) {
        debug_assert_eq!((symbols.directions.len(), S), (F, F * (F + 1) / 2));
        let directions: [Direction; F] = std::array::from_fn(|block| symbols.directions[block]);
        let mut work = self.work(F, scratch);
        self.forward(p, mask, &directions, &mut work);
        self.multiply(&directions, &mut work, |column, wave| match self.x.symmetry {
            None => {
                let symbols = symbols.column::<S, 1>(wave);
                let matrix = |k: usize| Packed(adapted(&symbols[k], &entries));
                self.multiply_column::<F, 1, _>(&directions, column, matrix);
            }
            Some(_) => {
                let symbols = symbols.column::<S, 2>(wave);
                let matrix = |k: usize| Packed(adapted(&symbols[k], &entries));
                self.multiply_column::<F, 2, _>(&directions, column, matrix);
            }
        });
        self.backward(out, mask, &directions, &mut work);
    }

    /// Computes out = the convolution of F fields, one for each of `symbols.directions`, with the
    /// symbols, a matrix for each wavenumber. With a `mask` only its elements count.
    pub(crate) fn convolve_by_matrices<const F: usize>(
        &self,
        symbols: &MatrixSymbols,
        mask: Option<&[bool]>,
        out: &mut [f64],
        p: &[f64],
        scratch: &mut Scratch,
    ) {
        debug_assert_eq!(symbols.directions.len(), F);
        let directions: [Direction; F] = std::array::from_fn(|block| symbols.directions[block]);
        let mut work = self.work(F, scratch);
        self.forward(p, mask, &directions, &mut work);
        self.multiply(&directions, &mut work, |column, wave| {
            let matrix = |k: usize| symbols.matrix::<F>(wave, k);
            self.multiply_column::<F, 1, _>(&directions, column, matrix);
        });
        self.backward(out, mask, &directions, &mut work);
    }

    /// Transforms the rows.
    fn forward(
        &self,
        p: &[f64],
        mask: Option<&[bool]>,
        directions: &[Direction],
        work: &mut Work<'_>,
    ) {
        let (nx, ny) = (self.x.elements, self.y.elements);
        assert_eq!(p.len(), directions.len() * self.field_len(), "fields on another grid");
        share(work.spectrum, self.columns(), &mut work.slots, |index, waves, slot| {
            let (block, j) = (index / ny, index % ny);
            let source = &p[index * nx..(index + 1) * nx];
            let inside = mask.map(|mask| &mask[j * nx..(j + 1) * nx]);
            let sign = self.x.sign(directions[block], Direction::X);
            // Rows without contact have no waves.
            if source.iter().all(|value| *value == 0.0) {
                waves.fill(Complex::zero());
                return;
            }
            slot.row[self.x.padding()].fill(0.0);
            if self.x.symmetry.is_none() {
                slot.row[..nx].copy_from_slice(source);
            } else {
                for (i, pair) in source.chunks(2).enumerate() {
                    slot.row[i] = pair[0];
                    if let [_, odd] = pair {
                        slot.row[self.x.length - 1 - i] = sign * odd;
                    }
                }
            }
            if let Some(inside) = inside {
                for (i, _) in inside.iter().enumerate().filter(|(_, inside)| !**inside) {
                    slot.row[self.x.place(i)] = 0.0;
                }
            }
            let done = self.row_forward.process_with_scratch(slot.row, waves, slot.transform);
            debug_assert!(done.is_ok());
            waves.iter_mut().zip(&self.x.turns).for_each(|(wave, turn)| *wave *= turn);
        });
    }

    /// Transforms the columns, multiplies each by its symbols, transforms back. `by_symbols` gets a
    /// column of every block, a stride apart, and its number.
    fn multiply<const F: usize>(
        &self,
        directions: &[Direction; F],
        work: &mut Work<'_>,
        by_symbols: impl Fn(&mut [Complex<f64>], usize) + Sync,
    ) {
        let (spectrum, rows) = (&*work.spectrum, F * self.y.elements);
        share(work.tiles, rows * TILE, &mut work.slots, |index, tile, slot| {
            let columns = index * TILE..self.columns().min((index + 1) * TILE);
            let buffer = &mut slot.columns[..F * columns.len() * self.stride()];
            self.load(directions, columns.clone(), spectrum, buffer);
            for column in buffer.chunks_exact_mut(self.stride()) {
                self.column_forward
                    .process_with_scratch(&mut column[..self.y.length], slot.transform);
            }
            for (column, wave) in buffer.chunks_exact_mut(F * self.stride()).zip(columns.clone()) {
                by_symbols(column, wave);
            }
            for column in buffer.chunks_exact_mut(self.stride()) {
                self.column_backward
                    .process_with_scratch(&mut column[..self.y.length], slot.transform);
            }
            self.store(directions, columns.len(), buffer, tile);
        });
    }

    /// Copies columns of the spectrum, which has a row for each row of each block, to the places
    /// from which the transform takes them.
    fn load(
        &self,
        directions: &[Direction],
        columns: Range<usize>,
        spectrum: &[Complex<f64>],
        buffer: &mut [Complex<f64>],
    ) {
        let (ny, stride) = (self.y.elements, self.stride());
        for column in buffer.chunks_exact_mut(stride) {
            column[self.y.padding()].fill(Complex::zero());
        }
        for (block, &direction) in directions.iter().enumerate() {
            let odd = self.y.sign(direction, Direction::Y);
            for j in 0..ny {
                let row = &spectrum[(block * ny + j) * self.columns()..][columns.clone()];
                let (place, sign) = (self.y.place(j), if j.is_multiple_of(2) { 1.0 } else { odd });
                for (c, value) in row.iter().enumerate() {
                    buffer[(c * directions.len() + block) * stride + place] = value * sign;
                }
            }
        }
    }

    /// Copies the columns in `buffer` back, the reverse of `load`, to a tile with TILE numbers for
    /// each row of each block.
    fn store(
        &self,
        directions: &[Direction],
        width: usize,
        buffer: &[Complex<f64>],
        tile: &mut [Complex<f64>],
    ) {
        let (ny, stride) = (self.y.elements, self.stride());
        for (block, &direction) in directions.iter().enumerate() {
            let odd = self.y.sign(direction, Direction::Y);
            for j in 0..ny {
                let (place, sign) = (self.y.place(j), if j.is_multiple_of(2) { 1.0 } else { odd });
                for (c, value) in tile[(block * ny + j) * TILE..][..width].iter_mut().enumerate() {
                    *value = buffer[(c * directions.len() + block) * stride + place] * sign;
                }
            }
        }
    }

    /// Multiplies one column (of every block, a stride apart) by its symbols, two wavenumbers along
    /// y at a time.
    ///
    /// With the component along a direction turned by i, as sines are against cosines, every symbol
    /// of A is real and symmetric: see [`Symbols`] for their order and signs.
    fn multiply_column<const F: usize, const LANES: usize, M: Matrix<F>>(
        &self,
        directions: &[Direction; F],
        column: &mut [Complex<f64>],
        matrix: impl Fn(usize) -> M,
    ) {
        let my = self.y.length;
        let mut chunks = column.chunks_exact_mut(self.stride());
        let blocks: [&mut [Complex<f64>]; F] = std::array::from_fn(|_| {
            chunks.next().map_or(Default::default(), |chunk| &mut chunk[..my])
        });
        let along = |direction: Direction| directions.map(|d| d == direction);
        let (x, y) = (along(Direction::X), directions.map(|d| d == Direction::Y));
        for k in 0..=my / 2 {
            let m = if k == 0 { 0 } else { my - k };
            let (mut low, mut high) = ([Complex::zero(); F], [Complex::zero(); F]);
            for c in 0..F {
                (low[c], high[c]) = (blocks[c][k], blocks[c][m]);
                if x[c] {
                    (low[c], high[c]) = (turned(low[c]), turned(high[c]));
                }
            }
            if self.y.symmetry.is_some() {
                // These are cosine transforms at k and length − k, or sine transforms at length − k
                // and k.
                let turn = self.y.turns[k];
                for c in 0..F {
                    let (a, b) = (turn * low[c], turn.conj() * high[c]);
                    let (u, w) = (0.5 * (a + b), 0.5 * turned(a - b));
                    (low[c], high[c]) = if y[c] { (w, u) } else { (u, w) };
                }
                low = matrix(k).times(low);
                high = matrix(my - k).times(high);
                for c in 0..F {
                    let (u, w) = if y[c] { (high[c], low[c]) } else { (low[c], high[c]) };
                    let w = turned(w);
                    (low[c], high[c]) = (turn.conj() * (u - w), turn * (u + w));
                }
            } else {
                for c in 0..F {
                    if y[c] {
                        (low[c], high[c]) = (turned(low[c]), turned_back(high[c]));
                    }
                }
                let matrix = matrix(k);
                if LANES == 1 {
                    (low, high) = (matrix.times(low), matrix.times(high));
                } else {
                    // Each number holds the spectra a, b of two real columns: a + ib at k, and at
                    // −k their conjugates.
                    let high_conjugate = high.map(|z| z.conj());
                    let a: [Complex<f64>; F] =
                        std::array::from_fn(|c| 0.5 * (low[c] + high_conjugate[c]));
                    let ib: [Complex<f64>; F] =
                        std::array::from_fn(|c| 0.5 * (low[c] - high_conjugate[c]));
                    let (a, ib) = (matrix.lane_times(0, a), matrix.lane_times(LANES - 1, ib));
                    for c in 0..F {
                        (low[c], high[c]) = (a[c] + ib[c], (a[c] - ib[c]).conj());
                    }
                }
                for c in 0..F {
                    if y[c] {
                        (low[c], high[c]) = (turned_back(low[c]), turned(high[c]));
                    }
                }
            }
            for c in 0..F {
                if x[c] {
                    (low[c], high[c]) = (turned_back(low[c]), turned_back(high[c]));
                }
                (blocks[c][k], blocks[c][m]) = (low[c], high[c]);
            }
        }
    }

    /// Transforms the rows back.
    fn backward(
        &self,
        out: &mut [f64],
        mask: Option<&[bool]>,
        directions: &[Direction],
        work: &mut Work<'_>,
    ) {
        let (nx, ny, columns) = (self.x.elements, self.y.elements, self.columns());
        assert_eq!(out.len(), directions.len() * self.field_len(), "fields on another grid");
        let (tiles, rows) = (&*work.tiles, directions.len() * ny);
        share(out, nx, &mut work.slots, |index, row, slot| {
            let (block, j) = (index / ny, index % ny);
            let waves = &mut slot.columns[..columns];
            for (chunk, tile) in waves.chunks_mut(TILE).zip(tiles.chunks_exact(rows * TILE)) {
                chunk.copy_from_slice(&tile[index * TILE..][..chunk.len()]);
            }
            waves.iter_mut().zip(&self.x.turns).for_each(|(wave, turn)| *wave *= turn.conj());
            // The imaginary part is zero except for rounding, as a real field's must be.
            waves[0].im = 0.0;
            if self.x.length.is_multiple_of(2) {
                waves[columns - 1].im = 0.0;
            }
            let done = self.row_backward.process_with_scratch(waves, slot.row, slot.transform);
            debug_assert!(done.is_ok());
            if self.x.symmetry.is_none() {
                row.copy_from_slice(&slot.row[..nx]);
            } else {
                let sign = self.x.sign(directions[block], Direction::X);
                for (i, pair) in row.chunks_mut(2).enumerate() {
                    pair[0] = slot.row[i];
                    if let [_, odd] = pair {
                        *odd = sign * slot.row[self.x.length - 1 - i];
                    }
                }
            }
            if let Some(mask) = mask {
                for (value, _) in
                    row.iter_mut().zip(&mask[j * nx..]).filter(|(_, inside)| !**inside)
                {
                    *value = 0.0;
                }
            }
        });
    }
}

/// Returns i z.
fn turned(z: Complex<f64>) -> Complex<f64> {
    Complex::new(-z.im, z.re)
}

/// Returns −i z.
fn turned_back(z: Complex<f64>) -> Complex<f64> {
    Complex::new(z.im, -z.re)
}

/// Returns the symbols to multiply with, lane by lane.
fn adapted<const S: usize, const LANES: usize>(
    symbols: &[[f64; LANES]; S],
    entries: &impl Fn([f64; S]) -> [f64; S],
) -> [[f64; LANES]; S] {
    let mut out = [[0.0; LANES]; S];
    for lane in 0..LANES {
        let lane_entries = entries(symbols.map(|symbol| symbol[lane]));
        for (value, entry) in out.iter_mut().zip(lane_entries) {
            value[lane] = entry;
        }
    }
    out
}

/// The symbols of a wavenumber, as a matrix.
trait Matrix<const F: usize> {
    /// Returns the product with a vector; the first lane is for the real part, the last for the
    /// imaginary one.
    fn times(&self, v: [Complex<f64>; F]) -> [Complex<f64>; F];

    /// Returns the product of one lane with a vector.
    fn lane_times(&self, lane: usize, v: [Complex<f64>; F]) -> [Complex<f64>; F];
}

/// A real symmetric matrix, the upper triangle of which is packed.
struct Packed<const S: usize, const LANES: usize>([[f64; LANES]; S]);

impl<const S: usize, const LANES: usize> Packed<S, LANES> {
    /// Returns the product with a vector, with one lane for each part of its numbers.
    #[inline]
    fn product<const F: usize>(
        &self,
        [real, imaginary]: [usize; 2],
        v: [Complex<f64>; F],
    ) -> [Complex<f64>; F] {
        std::array::from_fn(|row| {
            let mut sum = Complex::zero();
            for (column, v) in v.iter().enumerate() {
                let entry = &self.0[entry_at(F, row, column)];
                sum += Complex::new(entry[real] * v.re, entry[imaginary] * v.im);
            }
            sum
        })
    }
}

impl<const F: usize, const S: usize, const LANES: usize> Matrix<F> for Packed<S, LANES> {
    #[inline]
    fn times(&self, v: [Complex<f64>; F]) -> [Complex<f64>; F] {
        self.product([0, LANES - 1], v)
    }

    #[inline]
    fn lane_times(&self, lane: usize, v: [Complex<f64>; F]) -> [Complex<f64>; F] {
        self.product([lane, lane], v)
    }
}

impl<const F: usize> Matrix<F> for [[Complex<f64>; F]; F] {
    #[inline]
    fn times(&self, v: [Complex<f64>; F]) -> [Complex<f64>; F] {
        self.map(|row| row.iter().zip(&v).map(|(entry, v)| entry * v).sum())
    }

    #[inline]
    fn lane_times(&self, _lane: usize, v: [Complex<f64>; F]) -> [Complex<f64>; F] {
        self.times(v)
    }
}

/// The memory of one convolution.
struct Work<'a> {
    /// A row of columns for each row of each field.
    spectrum: &'a mut [Complex<f64>],
    /// The spectrum in tiles of TILE columns.
    tiles: &'a mut [Complex<f64>],
    /// The memory of each thread.
    slots: Vec<Slot<'a>>,
}

/// The memory in which one thread works.
struct Slot<'a> {
    /// One row of a field.
    row: &'a mut [f64],
    /// The columns of a tile.
    columns: &'a mut [Complex<f64>],
    /// The transforms' own memory.
    transform: &'a mut [Complex<f64>],
}

/// Calls `work` on every `unit` of `field`; each thread works through the neighbouring units of a
/// slot. The result of a unit depends on its index only.
fn share<T: Send>(
    field: &mut [T],
    unit: usize,
    slots: &mut [Slot<'_>],
    work: impl Fn(usize, &mut [T], &mut Slot<'_>) + Sync,
) {
    if let [slot] = slots {
        field
            .chunks_exact_mut(unit)
            .enumerate()
            .for_each(|(index, values)| work(index, values, slot));
        return;
    }
    let per_slot = (field.len() / unit).div_ceil(slots.len());
    field.par_chunks_mut(per_slot * unit).zip(slots).enumerate().for_each(
        |(chunk, (units, slot))| {
            for (place, values) in units.chunks_exact_mut(unit).enumerate() {
                work(chunk * per_slot + place, values, slot);
            }
        },
    );
}
