//! The operator of a contact that rolls steadily, by FFT.
//!
//! Its normal rows are those of A. A tangential row is the displacement of an element minus that of
//! the point that lies the rolled distance ahead of it, under the same tractions. The operator is
//! not symmetric, because what is ahead is not what is behind.

use super::components::{Components, Direction, Entry};
use super::matrix_symbols::MatrixSymbols;
use super::mirror::Mirror;
use super::operator::{Influence, Scratch, ScratchSize, group_by_group};
use super::table::InfluenceTable;
use super::torus::Torus;
use crate::grid::Grid;

/// The coefficients of a contact that rolls steadily: A for the normal rows, and what is
/// [rolled](InfluenceTable::rolled) for the tangential ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RollingTables<'a> {
    /// The coefficients of A.
    pub(crate) still: &'a InfluenceTable,
    /// The coefficients of what is rolled.
    pub(crate) rolled: &'a InfluenceTable,
}

impl RollingTables<'_> {
    /// Returns the displacement in one direction under unit traction in another at an offset.
    fn coefficient(&self, [displaced, loaded]: [Direction; 2], di: i64, dj: i64) -> f64 {
        let table = if displaced == Direction::N { self.still } else { self.rolled };
        let sign = if loaded == Direction::N && displaced != Direction::N { -1.0 } else { 1.0 };
        let column = (di + table.grid().nx() as i64 - 1) as usize;
        sign * table.row(Entry::between(displaced, loaded), dj)[column]
    }

    /// Returns the displacement (n, x, y) of the element `receiver`, as
    /// [`InfluenceTable::displacement_at`] does.
    pub(crate) fn displacement_at(
        &self,
        receiver: usize,
        components: Components,
        p: &[f64],
    ) -> [f64; 3] {
        let [normal, _, _] = self.still.displacement_at(receiver, components, p);
        let [_, x, y] = self.rolled.displacement_at(receiver, components, p);
        [normal, x, y]
    }
}

/// The operator of a contact that rolls steadily, by FFT.
#[derive(Clone, Debug)]
pub(crate) struct RollingToeplitz {
    grid: Grid,
    components: Components,
    torus: Torus,
    /// The symbols of each group of components that couple.
    symbols: Vec<MatrixSymbols>,
}

impl RollingToeplitz {
    /// Makes the operator on these components of fields with these symmetries, none of them along
    /// x; it lives on the part of the tables' grid on the positive side of the mirror plane.
    ///
    /// # Panics
    /// If the tables do not hold the coefficients, x is mirrored, or the grid is not symmetric.
    pub(crate) fn of(tables: RollingTables<'_>, components: Components, mirror: Mirror) -> Self {
        let grid = mirror.part(tables.still.grid()).unwrap_or_else(|error| panic!("{error}"));
        Self::on(grid, tables, components, mirror)
    }

    /// Makes the operator on a window of so many elements of such a part, without a mask; the
    /// window begins at the mirror plane.
    ///
    /// # Panics
    /// If the tables do not hold the coefficients, or are smaller.
    pub(crate) fn within(
        tables: RollingTables<'_>,
        components: Components,
        mirror: Mirror,
        size: [usize; 2],
    ) -> Self {
        let (hx, hy) = (tables.still.grid().hx(), tables.still.grid().hy());
        let grid =
            Grid::new(size[0], size[1], hx, hy, [0.0; 2]).unwrap_or_else(|error| panic!("{error}"));
        Self::on(grid, tables, components, mirror)
    }

    /// Makes the operator on `grid`, which is a part of the tables' grid or a window of it.
    fn on(grid: Grid, tables: RollingTables<'_>, components: Components, mirror: Mirror) -> Self {
        let extent = mirror.whole_size([grid.nx(), grid.ny()]);
        let torus = Torus::new(extent, mirror, true);
        let length = torus.x.torus;
        let value = |directions: [Direction; 2], place: usize, dj: usize| {
            if place < extent[0] {
                tables.coefficient(directions, place as i64, dj as i64)
            } else if place + extent[0] > length {
                tables.coefficient(directions, place as i64 - length as i64, dj as i64)
            } else {
                0.0
            }
        };
        let symbols = components
            .groups()
            .map(|group: Vec<Direction>| MatrixSymbols::new(&torus, &group, extent[1], value))
            .collect();
        Self { grid, components, torus, symbols }
    }

    /// Returns the memory held, in bytes, the plans of the transforms left out.
    pub(crate) fn bytes(&self) -> usize {
        self.symbols.iter().map(MatrixSymbols::bytes).sum()
    }
}

impl Influence for RollingToeplitz {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn components(&self) -> Components {
        self.components
    }

    fn scratch_size(&self, threads: usize) -> ScratchSize {
        let largest = self.symbols.iter().map(MatrixSymbols::fields).max().unwrap_or(0);
        self.torus.scratch_size(largest, threads)
    }

    fn apply(&self, out: &mut [f64], p: &[f64], scratch: &mut Scratch) {
        let (k, mask) = (self.grid.len(), self.grid.mask());
        let groups = self.symbols.iter().map(|symbols| (symbols, symbols.fields()));
        group_by_group(groups, k, out, p, |symbols, out, p| match symbols.fields() {
            1 => self.torus.convolve_by_matrices::<1>(symbols, mask, out, p, scratch),
            2 => self.torus.convolve_by_matrices::<2>(symbols, mask, out, p, scratch),
            _ => self.torus.convolve_by_matrices::<3>(symbols, mask, out, p, scratch),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foundation::Bodies;
    use crate::influence::{Symmetry, laws};
    use crate::model::{Base, Layer, Material, Projection};

    fn bodies() -> Bodies {
        let material = Material { shear_modulus: 1.0, poisson: 0.3 };
        let layer = Layer { shear_modulus: 3.0, poisson: 0.4, thickness: 0.7 };
        Bodies::new(&[layer], &Base::Elastic(material), None)
    }

    fn wave(len: usize) -> Vec<f64> {
        (0..len).map(|e| ((e * e) as f64 * 0.37).sin()).collect()
    }

    #[test]
    fn by_transforms_it_is_the_sum_over_sources() {
        for (nx, ny) in [(12, 9), (7, 20), (20, 3), (1, 1), (1, 6)] {
            let (cx, cy) = (0.5 * nx as f64 * 0.3, 0.5 * ny as f64 * 0.2);
            let grid = Grid::new(nx, ny, 0.3, 0.2, [0.15 - cx, 0.1 - cy]).unwrap();
            let grid = grid.masked_by(|x, y| (x / cx).powi(2) + (y / cy).powi(2) < 0.95);
            for projection in [Projection::Average, Projection::Midpoint] {
                let still = InfluenceTable::new(&grid, bodies(), projection);
                for distance in [0.3, -0.3, 0.075, 0.85, -0.03] {
                    let rolled = still.rolled_of(bodies(), projection, distance);
                    let tables = RollingTables { still: &still, rolled: &rolled };
                    for components in [Components::ALL, Components::TANGENTIAL, Components::X] {
                        let mut p = wave(components.len() * grid.len());
                        for (e, p) in p.iter_mut().enumerate() {
                            if !grid.is_active(e % grid.len()) {
                                *p = 0.0;
                            }
                        }
                        let got =
                            laws::apply(&RollingToeplitz::of(tables, components, Mirror::NONE), &p);
                        let mut expected = vec![0.0; p.len()];
                        for e in grid.active() {
                            let sum = tables.displacement_at(e, components, &p);
                            for (block, direction) in components.directions().enumerate() {
                                expected[block * grid.len() + e] = sum[direction as usize];
                            }
                        }
                        let size = still.largest_diagonal();
                        laws::close("direct sums", &got, &expected, size);
                    }
                }
            }
        }
    }

    #[test]
    fn on_a_part_it_is_that_of_the_whole_on_symmetric_fields() {
        let grid = Grid::new(9, 12, 0.3, 0.2, [0.0, -1.1]).unwrap();
        let still = InfluenceTable::new(&grid, bodies(), Projection::Midpoint);
        let rolled = still.rolled_of(bodies(), Projection::Midpoint, 0.2);
        let tables = RollingTables { still: &still, rolled: &rolled };
        for y in [Symmetry::Symmetric, Symmetry::Antisymmetric] {
            let mirror = Mirror { x: None, y: Some(y) };
            for components in [
                Components::ALL,
                Components::ALL.uncoupled(),
                Components::TANGENTIAL,
                Components::Y,
            ] {
                let part = RollingToeplitz::of(tables, components, mirror);
                let p = wave(components.len() * part.grid().len());
                let whole = mirror.extend(&grid, components, &p);
                let expected =
                    laws::apply(&RollingToeplitz::of(tables, components, Mirror::NONE), &whole);
                let got = laws::apply(&part, &p);
                let size = still.largest_diagonal();
                laws::close("part", &got, &mirror.restrict(&grid, &expected), size);
            }
        }
    }

    #[test]
    fn same_bytes_on_any_number_of_threads() {
        let grid = Grid::new(33, 20, 0.3, 0.2, [0.0, -1.9]).unwrap();
        let still = InfluenceTable::new(&grid, bodies(), Projection::Average);
        let rolled = still.rolled_of(bodies(), Projection::Average, 0.1);
        let tables = RollingTables { still: &still, rolled: &rolled };
        for mirror in [Mirror::NONE, Mirror { x: None, y: Some(Symmetry::Symmetric) }] {
            let operator = RollingToeplitz::of(tables, Components::ALL, mirror);
            let p = wave(3 * operator.grid().len());
            let displacement = |threads| {
                let mut out = vec![f64::NAN; p.len()];
                operator.apply(&mut out, &p, &mut Scratch::with_threads(&operator, threads));
                out
            };
            let single = displacement(1);
            assert!(single.iter().all(|u| u.is_finite()));
            assert!([2, 3, 7].into_iter().all(|threads| displacement(threads) == single));
        }
    }

    #[test]
    fn on_a_window_it_is_the_same() {
        let grid = Grid::new(14, 12, 0.3, 0.2, [0.0; 2]).unwrap();
        let still = InfluenceTable::new(&grid, bodies(), Projection::Average);
        let rolled = still.rolled_of(bodies(), Projection::Average, -0.3);
        let tables = RollingTables { still: &still, rolled: &rolled };
        let size = [6, 5];
        let part = RollingToeplitz::within(tables, Components::ALL, Mirror::NONE, size);
        let p = wave(3 * 30);
        let mut whole = vec![0.0; 3 * grid.len()];
        let place = |e: usize| (e / 30) * grid.len() + grid.index(4 + e % 6, 3 + e % 30 / 6);
        (0..p.len()).for_each(|e| whole[place(e)] = p[e]);
        let all = laws::apply(&RollingToeplitz::of(tables, Components::ALL, Mirror::NONE), &whole);
        let expected: Vec<f64> = (0..p.len()).map(|e| all[place(e)]).collect();
        laws::close("window", &laws::apply(&part, &p), &expected, still.largest_diagonal());
    }
}
