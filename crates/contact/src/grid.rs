//! The boundary elements that cover Ω: equal rectangles, some of them masked out, and the one index
//! law.

use std::ops::Range;

use crate::common::parallel;

/// A grid of nx × ny equal rectangular boundary elements of size hx × hy, some of them masked out.
///
/// Element (i, j), 0 ≤ i < nx, 0 ≤ j < ny, has the index j·nx + i: x is fastest. Lengths are in the
/// caller's unit; a grid has none of its own. Masked elements keep their index but are no part of
/// Ω.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    nx: usize,
    ny: usize,
    hx: f64,
    hy: f64,
    /// The centre of element (0, 0).
    origin: [f64; 2],
    /// One flag per element, true if it belongs to Ω; `None` if all elements do.
    mask: Option<Vec<bool>>,
}

/// The reason why a grid cannot exist.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridError {
    /// There are no elements along one side, or more than an index can count.
    #[error(
        "{nx} × {ny} elements: there must be at least 1 along each side, \
         and no more in all than memory can index"
    )]
    Count {
        /// The number of elements along x.
        nx: usize,
        /// The number of elements along y.
        ny: usize,
    },
    /// An element has no area, or its area is no number.
    #[error("elements of {hx} × {hy}: both sides must be finite and above 0")]
    Size {
        /// The extent of an element along x.
        hx: f64,
        /// The extent of an element along y.
        hy: f64,
    },
    /// The grid has no finite position.
    #[error("element (0, 0) at ({x}, {y}): both coordinates must be finite")]
    Origin {
        /// The x of the centre of element (0, 0).
        x: f64,
        /// The y of the centre of element (0, 0).
        y: f64,
    },
    /// The mask belongs to another grid.
    #[error("a mask of {found} flags for {expected} elements: there must be one per element")]
    Mask {
        /// The number of flags given.
        found: usize,
        /// The number of elements of the grid.
        expected: usize,
    },
}

impl Grid {
    /// Makes a grid of nx × ny elements of size hx × hy, all of them in Ω; `origin` is the centre
    /// of element (0, 0).
    ///
    /// # Errors
    /// [`GridError::Count`] without elements along a side or with too many of them,
    /// [`GridError::Size`] if a side of an element is not finite and above 0, [`GridError::Origin`]
    /// if a coordinate is not finite.
    pub fn new(
        nx: usize,
        ny: usize,
        hx: f64,
        hy: f64,
        origin: [f64; 2],
    ) -> Result<Self, GridError> {
        // The operators hold arrays of a small multiple of nx·ny numbers.
        if nx == 0 || ny == 0 || nx.checked_mul(ny).is_none_or(|k| k > usize::MAX / 1024) {
            return Err(GridError::Count { nx, ny });
        }
        if !(hx.is_finite() && hy.is_finite() && hx > 0.0 && hy > 0.0) {
            return Err(GridError::Size { hx, hy });
        }
        if !origin.iter().all(|x| x.is_finite()) {
            return Err(GridError::Origin { x: origin[0], y: origin[1] });
        }
        Ok(Self { nx, ny, hx, hy, origin, mask: None })
    }

    /// Keeps only those elements in Ω whose flag in `inside` is true (one flag per element, in
    /// index order); an earlier mask is replaced.
    ///
    /// # Errors
    /// [`GridError::Mask`] if the number of flags is not the number of elements.
    pub(crate) fn with_mask(mut self, inside: Vec<bool>) -> Result<Self, GridError> {
        if inside.len() != self.len() {
            return Err(GridError::Mask { found: inside.len(), expected: self.len() });
        }
        self.mask = if inside.iter().all(|&a| a) { None } else { Some(inside) };
        Ok(self)
    }

    /// Keeps only those elements in Ω whose centre (x, y) is `inside`; an earlier mask is replaced.
    #[cfg(test)]
    pub(crate) fn masked_by(mut self, inside: impl Fn(f64, f64) -> bool) -> Self {
        let flags: Vec<bool> =
            (0..self.len()).map(|e| self.center(e)).map(|[x, y]| inside(x, y)).collect();
        self.mask = if flags.iter().all(|&a| a) { None } else { Some(flags) };
        self
    }

    /// Returns the number of elements along x.
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Returns the number of elements along y.
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// Returns the extent of an element along x.
    pub(crate) fn hx(&self) -> f64 {
        self.hx
    }

    /// Returns the extent of an element along y.
    pub(crate) fn hy(&self) -> f64 {
        self.hy
    }

    /// Returns the number of elements nx·ny, masked ones included: the length of a scalar field.
    #[allow(clippy::len_without_is_empty)] // There is no empty grid.
    pub fn len(&self) -> usize {
        self.nx * self.ny
    }

    /// Returns the index of element (i, j).
    pub(crate) fn index(&self, i: usize, j: usize) -> usize {
        debug_assert!(i < self.nx && j < self.ny);
        j * self.nx + i
    }

    /// Returns the (i, j) of the element with this index.
    pub(crate) fn position(&self, index: usize) -> (usize, usize) {
        (index % self.nx, index / self.nx)
    }

    /// Returns the centre (x, y) of the element with this index.
    pub(crate) fn center(&self, index: usize) -> [f64; 2] {
        let (i, j) = self.position(index);
        self.center_of(i, j)
    }

    /// Returns the centre (x, y) of element (i, j).
    pub(crate) fn center_of(&self, i: usize, j: usize) -> [f64; 2] {
        [self.origin[0] + i as f64 * self.hx, self.origin[1] + j as f64 * self.hy]
    }

    /// Returns the area hx·hy of one element.
    pub(crate) fn element_area(&self) -> f64 {
        self.hx * self.hy
    }

    /// Samples a field of three blocks on this grid at the elements of another grid over the same
    /// Ω. Each element takes the value of the element in which its centre lies; masked elements
    /// take zero.
    pub(crate) fn sample(&self, field: &[f64], other: &Grid) -> Vec<f64> {
        let (k, others) = (self.len(), other.len());
        let mut out = vec![0.0; 3 * others];
        let [x0, y0] = self.center(0);
        let nearest = |x: f64, x0: f64, h: f64, n: usize| {
            (((x - x0) / h).round().max(0.0) as usize).min(n - 1)
        };
        let columns: Vec<usize> = (0..other.nx)
            .map(|i| nearest(other.center_of(i, 0)[0], x0, self.hx(), self.nx()))
            .collect();
        for (out, field) in out.chunks_exact_mut(others).zip(field.chunks_exact(k)) {
            parallel::rows(out, other.nx, |j, row| {
                let source = &field
                    [self.index(0, nearest(other.center_of(0, j)[1], y0, self.hy(), self.ny()))..]
                    [..self.nx];
                for (i, value) in
                    row.iter_mut().enumerate().filter(|(i, _)| other.is_active(j * other.nx + i))
                {
                    *value = source[columns[i]];
                }
            });
        }
        out
    }

    /// Returns whether an element belongs to Ω.
    pub(crate) fn is_active(&self, index: usize) -> bool {
        self.mask.as_ref().is_none_or(|mask| mask[index])
    }

    /// Returns one flag per element, true if it belongs to Ω; `None` if all elements do.
    pub(crate) fn mask(&self) -> Option<&[bool]> {
        self.mask.as_deref()
    }

    /// Returns the indices of the elements of Ω in ascending order.
    pub fn active(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).filter(|&e| self.is_active(e))
    }

    /// Returns the indices of the elements of Ω in a range of indices, in ascending order.
    pub(crate) fn active_in(&self, range: Range<usize>) -> impl Iterator<Item = usize> + '_ {
        range.filter(|&e| self.is_active(e))
    }

    /// Returns the number of elements of Ω.
    pub(crate) fn active_len(&self) -> usize {
        self.mask.as_ref().map_or(self.len(), |mask| mask.iter().filter(|&&a| a).count())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn x_is_fastest_and_centres_follow() {
        let grid = Grid::new(3, 2, 0.5, 2.0, [-1.0, 10.0]).unwrap();
        assert_eq!(grid.len(), 6);
        assert_eq!(grid.index(2, 1), 5);
        for e in 0..grid.len() {
            let (i, j) = grid.position(e);
            assert_eq!(grid.index(i, j), e);
        }
        assert_eq!(grid.center(1), [-0.5, 10.0]);
        assert_eq!(grid.center(5), [0.0, 12.0]);
        assert_eq!(grid.element_area(), 1.0);
    }

    #[test]
    fn mask_by_centre_and_by_flags_agree() {
        let grid = Grid::new(4, 4, 1.0, 1.0, [-1.5, -1.5]).unwrap();
        let disk = grid.clone().masked_by(|x, y| x.hypot(y) < 2.0);
        let inside = (0..16).map(|e| ![0, 3, 12, 15].contains(&e)).collect();
        assert_eq!(disk, grid.clone().with_mask(inside).unwrap());
        assert_eq!(disk.active_len(), 12);
        assert_eq!(disk.active().count(), 12);
        assert!(!disk.is_active(0) && disk.is_active(5));
        assert_eq!(
            grid.clone().masked_by(|_, _| true),
            grid,
            "a mask that hides nothing is no mask"
        );
        assert_eq!(grid.clone().masked_by(|_, _| false).active_len(), 0);
    }

    #[test]
    fn refuses_what_is_no_grid() {
        assert_eq!(Grid::new(0, 2, 1.0, 1.0, [0.0; 2]), Err(GridError::Count { nx: 0, ny: 2 }));
        assert!(Grid::new(usize::MAX, 2, 1.0, 1.0, [0.0; 2]).is_err());
        assert!(Grid::new(1, 2, 0.0, 1.0, [0.0; 2]).is_err());
        assert!(Grid::new(1, 2, 1.0, f64::NAN, [0.0; 2]).is_err());
        assert!(Grid::new(1, 2, 1.0, 1.0, [0.0, f64::INFINITY]).is_err());
        let short = Grid::new(2, 2, 1.0, 1.0, [0.0; 2]).unwrap().with_mask(vec![true; 3]);
        assert_eq!(short, Err(GridError::Mask { found: 3, expected: 4 }));
    }
}
