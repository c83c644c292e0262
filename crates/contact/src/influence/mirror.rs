//! Planes of symmetry: fields that are determined by a half or a quarter of them.

use super::components::{Components, Direction};
use crate::common::parallel;
use crate::grid::{Grid, GridError};
use crate::model::PerDof;

/// The behaviour of a vector field under a reflection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Symmetry {
    /// The field is its own mirror image: the component across the plane of symmetry is odd, the
    /// two others are even.
    Symmetric,
    /// The field is its mirror image reversed: the component across the plane of symmetry is even,
    /// the two others are odd.
    Antisymmetric,
}

/// The planes of symmetry of a field, in the middle of the grid; `None` if there is none.
///
/// Along a mirrored direction only the elements beyond the middle are kept, x > 0 or y > 0 if the
/// origin lies there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Mirror {
    /// The behaviour under x → −x.
    pub x: Option<Symmetry>,
    /// The behaviour under y → −y.
    pub y: Option<Symmetry>,
}

/// The reason why a grid has no such planes of symmetry.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum MirrorError {
    /// The plane would go through elements.
    #[error(
        "{count} elements along {axis}: for a mirror plane between elements \
         there must be an even number of them"
    )]
    Odd {
        /// The number of elements along the mirrored direction.
        count: usize,
        /// The name of the mirrored direction.
        axis: char,
    },
    /// Ω is not symmetric.
    #[error("element {element:?} and its mirror image {image:?} must both belong to Ω or both not")]
    Mask {
        /// The (i, j) of an element.
        element: (usize, usize),
        /// The (i, j) of its image.
        image: (usize, usize),
    },
    /// The part is no grid.
    #[error(transparent)]
    Grid(#[from] GridError),
}

impl Mirror {
    /// The mirror without planes of symmetry.
    pub const NONE: Self = Self { x: None, y: None };

    /// Returns the symmetries along x and y.
    pub(crate) fn axes(&self) -> [Option<Symmetry>; 2] {
        [self.x, self.y]
    }

    /// Returns the sign of a component's image under x → −x and under y → −y; 1 if there is no
    /// mirror.
    pub(crate) fn parity(&self, direction: Direction) -> [f64; 2] {
        [(self.x, Direction::X), (self.y, Direction::Y)].map(|(symmetry, across)| match symmetry {
            Some(symmetry) if (symmetry == Symmetry::Symmetric) == (direction == across) => -1.0,
            _ => 1.0,
        })
    }

    /// Returns the half or quarter of a grid on which fields with these symmetries live, with its
    /// part of the mask.
    ///
    /// # Errors
    /// [`MirrorError::Odd`] if a mirrored direction has an odd number of elements,
    /// [`MirrorError::Mask`] if Ω is not symmetric, [`MirrorError::Grid`] if the part is no grid.
    pub(crate) fn part(&self, grid: &Grid) -> Result<Grid, MirrorError> {
        let counts = [(grid.nx(), self.x, 'x'), (grid.ny(), self.y, 'y')];
        if let Some(&(count, _, axis)) = counts
            .iter()
            .find(|(count, symmetry, _)| symmetry.is_some() && !count.is_multiple_of(2))
        {
            return Err(MirrorError::Odd { count, axis });
        }
        let [nx, ny] =
            counts.map(|(count, symmetry, _)| if symmetry.is_some() { count / 2 } else { count });
        let origin = grid.center(grid.index(grid.nx() - nx, grid.ny() - ny));
        let reduced = Grid::new(nx, ny, grid.hx(), grid.hy(), origin)?;
        let Some(mask) = grid.mask() else { return Ok(reduced) };
        for e in 0..grid.len() {
            for image in self.images(grid, e) {
                if mask[image] != mask[e] {
                    return Err(MirrorError::Mask {
                        element: grid.position(e),
                        image: grid.position(image),
                    });
                }
            }
        }
        Ok(reduced
            .clone()
            .with_mask((0..reduced.len()).map(|e| mask[self.whole(grid, &reduced, e)]).collect())?)
    }

    /// Extends a field from the half or quarter to all of `grid` by reflection, with the sign of
    /// each component.
    ///
    /// # Panics
    /// Unless `field` has a block of the part's length for each of these components.
    pub(crate) fn extend(&self, grid: &Grid, components: Components, field: &[f64]) -> Vec<f64> {
        let [nx, ny] = self.part_size(grid);
        let (len, k) = (nx * ny, grid.len());
        assert_eq!(field.len(), components.len() * len, "a field on another part");
        let mut out = vec![0.0; components.len() * k];
        for (block, direction) in components.directions().enumerate() {
            let [sign_x, sign_y] = self.parity(direction);
            parallel::rows(&mut out[block * k..][..k], grid.nx(), |j, row| {
                let (from_j, sign_y) = fold(j, grid.ny() - ny, sign_y);
                for (i, value) in row.iter_mut().enumerate() {
                    let (from_i, sign_x) = fold(i, grid.nx() - nx, sign_x);
                    *value = sign_x * sign_y * field[block * len + from_j * nx + from_i];
                }
            });
        }
        out
    }

    /// Restricts a field of whole blocks on `grid` to its part.
    ///
    /// # Panics
    /// Unless the length of `field` is a multiple of the grid's.
    pub(crate) fn restrict(&self, grid: &Grid, field: &[f64]) -> Vec<f64> {
        assert!(field.len().is_multiple_of(grid.len()), "a field on another grid");
        let [nx, ny] = self.part_size(grid);
        let mut out = vec![0.0; field.len() / grid.len() * nx * ny];
        parallel::rows(&mut out, nx, |index, row| {
            let (block, j) = (index / ny, index % ny + grid.ny() - ny);
            row.copy_from_slice(&field[block * grid.len() + (j + 1) * grid.nx() - nx..][..nx]);
        });
        out
    }

    /// Returns the numbers of elements along x and y of the grid whose part has this size.
    pub(crate) fn whole_size(&self, [nx, ny]: [usize; 2]) -> [usize; 2] {
        [if self.x.is_some() { 2 * nx } else { nx }, if self.y.is_some() { 2 * ny } else { ny }]
    }

    /// Returns the numbers of elements along x and y of the part of `grid`.
    fn part_size(&self, grid: &Grid) -> [usize; 2] {
        let size = |count: usize, symmetry: Option<Symmetry>| {
            if symmetry.is_some() { count / 2 } else { count }
        };
        [size(grid.nx(), self.x), size(grid.ny(), self.y)]
    }

    /// Returns the index in `grid` of an element of its part.
    fn whole(&self, grid: &Grid, reduced: &Grid, e: usize) -> usize {
        let (i, j) = reduced.position(e);
        grid.index(i + grid.nx() - reduced.nx(), j + grid.ny() - reduced.ny())
    }

    /// Returns the element's image in each plane.
    fn images(&self, grid: &Grid, e: usize) -> impl Iterator<Item = usize> {
        let (i, j) = grid.position(e);
        let in_x = self.x.map(|_| grid.index(grid.nx() - 1 - i, j));
        let in_y = self.y.map(|_| grid.index(i, grid.ny() - 1 - j));
        in_x.into_iter().chain(in_y)
    }
}

/// Returns the place of the i-th element in the part that begins at `first`, and its sign there.
fn fold(i: usize, first: usize, sign: f64) -> (usize, f64) {
    if i < first { (first - 1 - i, sign) } else { (i - first, 1.0) }
}

/// Returns the number of elements for which one on the positive sides of mirror planes stands.
pub(crate) fn images(mirror: &Mirror) -> f64 {
    [mirror.x, mirror.y].iter().map(|plane| if plane.is_some() { 2.0 } else { 1.0 }).product()
}

/// Returns the ratio of the sum over all elements to the sum over those on the positive sides, for
/// a component weighted with each rigid mode.
pub(crate) fn weighted_images(mirror: &Mirror, direction: Direction) -> PerDof<f64> {
    // The constants are the parities in x and y of the modes' functions 1, x and y, by degree of
    // freedom and component.
    const EVEN: [f64; 2] = [1.0, 1.0];
    const ODD_IN_X: [f64; 2] = [-1.0, 1.0];
    const ODD_IN_Y: [f64; 2] = [1.0, -1.0];
    let modes = match direction {
        Direction::N => PerDof::new([EVEN, EVEN, EVEN, ODD_IN_Y, ODD_IN_X, EVEN]),
        Direction::X => PerDof::new([EVEN, EVEN, EVEN, EVEN, EVEN, ODD_IN_Y]),
        Direction::Y => PerDof::new([EVEN, EVEN, EVEN, EVEN, EVEN, ODD_IN_X]),
    };
    let parity = mirror.parity(direction);
    modes.map(|mode| {
        let factor =
            |plane: bool, axis: usize| if plane { 1.0 + parity[axis] * mode[axis] } else { 1.0 };
        factor(mirror.x.is_some(), 0) * factor(mirror.y.is_some(), 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use Symmetry::{Antisymmetric, Symmetric};

    #[test]
    fn a_part_is_the_upper_half_or_quarter() {
        let grid = Grid::new(4, 6, 0.5, 1.0, [-0.75, -2.5])
            .unwrap()
            .masked_by(|x, y| x.abs() + y.abs() < 3.0);
        let mirror = Mirror { x: Some(Symmetric), y: Some(Antisymmetric) };
        let reduced = mirror.part(&grid).unwrap();
        assert_eq!((reduced.nx(), reduced.ny(), reduced.center(0)), (2, 3, [0.25, 0.5]));
        assert_eq!(reduced.active_len() * 4, grid.active_len());
        assert_eq!(Mirror::NONE.part(&grid), Ok(grid.clone()));
        let field: Vec<f64> = (0..3 * reduced.len()).map(|e| e as f64 + 1.0).collect();
        let whole = mirror.extend(&grid, Components::ALL, &field);
        assert_eq!(mirror.restrict(&grid, &whole), field);
        for e in 0..grid.len() {
            let (i, j) = grid.position(e);
            let (in_x, in_y) = (grid.index(3 - i, j), grid.index(i, 5 - j));
            for (block, [sx, sy]) in [[1.0, -1.0], [-1.0, -1.0], [1.0, 1.0]].into_iter().enumerate()
            {
                assert_eq!(whole[block * 24 + in_x], sx * whole[block * 24 + e]);
                assert_eq!(whole[block * 24 + in_y], sy * whole[block * 24 + e]);
            }
        }
    }

    #[test]
    fn refuses_what_is_not_symmetric() {
        let mirror = Mirror { x: Some(Symmetric), y: None };
        let odd = Grid::new(5, 4, 1.0, 1.0, [0.0; 2]).unwrap();
        assert_eq!(mirror.part(&odd), Err(MirrorError::Odd { count: 5, axis: 'x' }));
        assert!(Mirror { x: None, y: Some(Symmetric) }.part(&odd).is_ok());
        let skew = Grid::new(4, 4, 1.0, 1.0, [0.0; 2]).unwrap().masked_by(|x, _| x > 0.5);
        assert_eq!(mirror.part(&skew), Err(MirrorError::Mask { element: (0, 0), image: (3, 0) }));
    }
}
