//! A torus of elements: its size, the transforms of a field on it, and the memory for them.
//!
//! A field on nx × ny elements is padded to the torus, or fills it. Along a mirrored direction it
//! is the half of an even or odd field that repeats after twice the length of the transform: a
//! cosine or sine transform, made of a Fourier transform of half the torus (J. Makhoul, IEEE Trans.
//! ASSP 28 (1980) 27–34, doi:10.1109/TASSP.1980.1163351).

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealToComplex};
use rustfft::Fft;

use super::components::Direction;
use super::mirror::{Mirror, Symmetry};
use super::operator::ScratchSize;

/// The number of columns of the spectrum that are transformed together; four complex numbers fill a
/// cache line.
pub(super) const TILE: usize = 4;

/// A torus, the field on a part of it, and the transforms.
#[derive(Clone)]
pub(crate) struct Torus {
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) row_forward: Arc<dyn RealToComplex<f64>>,
    pub(super) row_backward: Arc<dyn ComplexToReal<f64>>,
    pub(super) column_forward: Arc<dyn Fft<f64>>,
    pub(super) column_backward: Arc<dyn Fft<f64>>,
}

impl fmt::Debug for Torus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Torus").field("x", &self.x).field("y", &self.y).finish_non_exhaustive()
    }
}

/// One direction of a torus.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// The number of elements of the field.
    pub(super) elements: usize,
    /// The number of elements of the torus.
    pub(super) torus: usize,
    /// The length of the transform: the torus, or half of it if mirrored.
    pub(super) length: usize,
    /// The symmetry, if mirrored.
    pub(super) symmetry: Option<Symmetry>,
    /// The numbers e^(−iπk/2·length) for k up to the middle, if mirrored.
    pub(super) turns: Vec<Complex<f64>>,
}

impl Axis {
    /// Makes the direction for `whole` elements, mirror images included.
    fn new(whole: usize, symmetry: Option<Symmetry>, padded: bool) -> Self {
        let torus = if padded { torus_length(whole, symmetry.is_some()) } else { whole };
        if symmetry.is_none() {
            return Self { elements: whole, torus, length: torus, symmetry, turns: Vec::new() };
        }
        let length = torus / 2;
        let angle = |k: usize| -0.5 * std::f64::consts::PI * k as f64 / length as f64;
        let turns = (0..=length / 2).map(|k| Complex::from_polar(1.0, angle(k))).collect();
        Self { elements: whole / 2, torus, length, symmetry, turns }
    }

    /// Returns the place from which the transform takes the j-th element. If mirrored, the even
    /// ones come in order, then the odd ones backwards.
    pub(super) fn place(&self, j: usize) -> usize {
        match self.symmetry {
            None => j,
            Some(_) if j.is_multiple_of(2) => j / 2,
            Some(_) => self.length - 1 - j / 2,
        }
    }

    /// Returns the places to which no element goes.
    pub(super) fn padding(&self) -> Range<usize> {
        match self.symmetry {
            None => self.elements..self.length,
            Some(_) => self.elements.div_ceil(2)..self.length - self.elements / 2,
        }
    }

    /// Returns the sign with which odd elements enter the transform: a sine transform is the cosine
    /// transform of alternating signs, with the wavenumbers in reverse.
    pub(super) fn sign(&self, direction: Direction, across: Direction) -> f64 {
        let odd = self
            .symmetry
            .is_some_and(|symmetry| (symmetry == Symmetry::Symmetric) == (direction == across));
        if odd { -1.0 } else { 1.0 }
    }
}

/// Returns the smallest length ≥ 2n − 1 that has no prime factor above 5, is even unless it is 1,
/// and is twice an even number if it is to be halved.
fn torus_length(n: usize, halved: bool) -> usize {
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
    while !smooth(half) || (halved && !half.is_multiple_of(2)) {
        half += 1;
    }
    2 * half
}

/// Returns the smallest number of elements, `n` or more, that fills such a torus; if mirrored, the
/// number on one side of the mirror.
pub(crate) fn suitable_length(n: usize, mirrored: bool) -> usize {
    if mirrored { torus_length(2 * n, true) / 4 } else { torus_length(n, false).div_ceil(2) }
}

impl Torus {
    /// Plans the transforms for fields on `whole` elements, or on the part that `mirror` leaves of
    /// them. A padded torus has room for every offset between two of them; otherwise it is of their
    /// size.
    pub(crate) fn new(whole: [usize; 2], mirror: Mirror, padded: bool) -> Self {
        let [x, y] = [0, 1].map(|axis| Axis::new(whole[axis], mirror.axes()[axis], padded));
        Self {
            row_forward: primitives::real_transform(x.length),
            row_backward: primitives::real_inverse_transform(x.length),
            column_forward: primitives::complex_transform(y.length),
            column_backward: primitives::complex_inverse_transform(y.length),
            x,
            y,
        }
    }

    /// Returns the number of columns of the spectrum, complex numbers each: one wavenumber or, if x
    /// is mirrored, two, k and length − k.
    pub(super) fn columns(&self) -> usize {
        self.x.length / 2 + 1
    }

    /// Returns the distance from one column of a tile to the next: off powers of two, where they
    /// would all compete for the same lines of the cache.
    pub(super) fn stride(&self) -> usize {
        self.y.length + TILE
    }

    /// Returns the number of tiles of the spectrum.
    pub(super) fn tiles(&self) -> usize {
        self.columns().div_ceil(TILE)
    }

    /// Returns the length of a scalar field.
    pub(crate) fn field_len(&self) -> usize {
        self.x.elements * self.y.elements
    }

    /// Returns the factor by which the transforms there and back multiply a field.
    pub(crate) fn gain(&self) -> f64 {
        (self.x.length * self.y.length) as f64
    }

    /// Returns the counts of complex numbers that one thread needs for `fields` fields: for the
    /// columns of a tile, and for the transforms' own use.
    pub(super) fn slot_size(&self, fields: usize) -> [usize; 2] {
        let transforms = [
            self.row_forward.get_scratch_len(),
            self.row_backward.get_scratch_len(),
            self.column_forward.get_inplace_scratch_len(),
            self.column_backward.get_inplace_scratch_len(),
        ];
        let columns = (fields * TILE * self.stride()).max(self.columns());
        [columns, transforms.into_iter().max().unwrap_or(0)]
    }

    /// Returns the memory that a convolution of `fields` fields on `threads` threads needs.
    pub(crate) fn scratch_size(&self, fields: usize, threads: usize) -> ScratchSize {
        let rows = fields * self.y.elements;
        let slot: usize = self.slot_size(fields).iter().sum();
        ScratchSize {
            real: threads * self.x.length,
            complex: rows * (self.columns() + self.tiles() * TILE) + threads * slot,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torus_leaves_room_for_every_offset_and_suits_the_transform() {
        assert_eq!(
            [1, 2, 3, 4, 7, 11, 512].map(|n| torus_length(n, false)),
            [1, 4, 6, 8, 16, 24, 1024]
        );
        assert_eq!(
            [2, 4, 6, 14, 22, 26, 512].map(|n| torus_length(n, true)),
            [4, 8, 12, 32, 48, 60, 1024]
        );
    }
}
