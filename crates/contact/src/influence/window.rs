//! The part of a grid around a contact, on which a solver can work with smaller transforms.

use std::ops::Range;

use super::mirror::Mirror;
use super::torus::suitable_length;
use crate::grid::Grid;

/// A rectangle of elements of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window {
    /// The column and row of its first element.
    pub(crate) first: [usize; 2],
    /// The numbers of elements along x and y.
    pub(crate) size: [usize; 2],
}

impl Window {
    /// Returns the window that is all of a grid.
    pub(crate) fn whole(grid: &Grid) -> Self {
        Self { first: [0; 2], size: [grid.nx(), grid.ny()] }
    }

    /// Returns a window around the elements from `low` to `high`, of a size that suits the
    /// transforms, or all of the grid if there is little to save. It begins at a mirror plane if
    /// there is one.
    pub(crate) fn around([low, high]: [[usize; 2]; 2], grid: &Grid, mirror: &Mirror) -> Self {
        let whole = Self::whole(grid);
        let mut window = whole;
        for (axis, plane) in mirror.axes().into_iter().enumerate() {
            let first = if plane.is_some() { 0 } else { low[axis] };
            // There is one element more on each side, because contacts grow.
            let needed = high[axis] + 1 - first;
            let size =
                suitable_length(needed + if plane.is_some() { 1 } else { 2 }, plane.is_some());
            if size < whole.size[axis] {
                let before = if plane.is_some() { 0 } else { (size - needed) / 2 };
                window.size[axis] = size;
                window.first[axis] = first.saturating_sub(before).min(whole.size[axis] - size);
            }
        }
        if 4 * window.len() > 3 * whole.len() || whole.len() < WORTH_A_WINDOW {
            whole
        } else {
            window
        }
    }

    /// Returns whether the elements from `low` to `high` lie in the window.
    pub(crate) fn holds(&self, [low, high]: [[usize; 2]; 2]) -> bool {
        (0..2).all(|axis| {
            self.first[axis] <= low[axis] && high[axis] < self.first[axis] + self.size[axis]
        })
    }

    /// Returns the number of elements.
    pub(crate) fn len(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Returns the grid's index of the element at a place of the window.
    pub(crate) fn element(&self, place: usize, grid: &Grid) -> usize {
        grid.index(self.first[0] + place % self.size[0], self.first[1] + place / self.size[0])
    }

    /// Calls `work` with the places of each row of each of `blocks` blocks, first in a field on the
    /// window, then in a field on the grid.
    pub(crate) fn each_row(
        &self,
        grid: &Grid,
        blocks: usize,
        mut work: impl FnMut(Range<usize>, Range<usize>),
    ) {
        for block in 0..blocks {
            for row in 0..self.size[1] {
                let width = self.size[0];
                let in_window = block * self.len() + row * width;
                let in_grid = block * grid.len() + grid.index(self.first[0], self.first[1] + row);
                work(in_window..in_window + width, in_grid..in_grid + width);
            }
        }
    }
}

/// The number of elements of a grid below which the operator of a window costs more than it saves.
const WORTH_A_WINDOW: usize = 4096;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_that_saves_little_is_the_grid() {
        let grid = Grid::new(100, 100, 1.0, 1.0, [0.0; 2]).unwrap();
        for bounds in [[[0, 0], [99, 99]], [[5, 5], [92, 92]]] {
            assert_eq!(Window::around(bounds, &grid, &Mirror::NONE), Window::whole(&grid));
        }
        let corner = Window::around([[80, 0], [99, 20]], &grid, &Mirror::NONE);
        assert!(
            corner.holds([[80, 0], [99, 20]])
                && corner.first[0] + corner.size[0] <= 100
                && corner.first[1] == 0
        );
        let small = Grid::new(20, 20, 1.0, 1.0, [0.0; 2]).unwrap();
        assert_eq!(Window::around([[3, 3], [4, 4]], &small, &Mirror::NONE), Window::whole(&small));
    }
}
