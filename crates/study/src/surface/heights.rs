//! The matrix of heights that a file holds.

/// The largest number of heights of one file: 4096 × 4096.
pub(super) const MAX_HEIGHTS: usize = 1 << 24;

/// The heights of a file \[m\], row after row from the lowest y, x fastest; a missing one is NaN.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HeightMatrix {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) heights: Vec<f64>,
}
