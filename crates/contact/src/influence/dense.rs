//! The operator as a matrix: the oracle for small grids.

use faer::{Accum, Mat, MatMut, MatRef};
use primitives::multiply;

use super::components::{Components, Direction, Entry};
use super::mirror::Mirror;
use super::operator::{Influence, Scratch, ScratchSize};
use super::table::InfluenceTable;
use crate::grid::Grid;

/// The operator A as one matrix over the elements of Ω; 8·(ck)² bytes for c components and k
/// elements.
#[derive(Clone, Debug)]
pub struct Dense {
    grid: Grid,
    components: Components,
    /// The indices of the elements of Ω, ascending.
    active: Vec<usize>,
    matrix: Mat<f64>,
}

impl Dense {
    /// Makes the matrix of all of the table's components on Ω of its grid.
    pub fn new(table: &InfluenceTable) -> Self {
        Self::of(table, table.components(), Mirror::NONE)
    }

    /// Makes the matrix on these components of fields with these symmetries; it lives on the part
    /// of the table's grid that [`Mirror::part`] gives.
    ///
    /// # Panics
    /// If the table does not hold the coefficients, or its grid is not symmetric.
    pub(crate) fn of(table: &InfluenceTable, components: Components, mirror: Mirror) -> Self {
        assert!(
            table.components().includes(components),
            "{components:?} of a table of {:?}",
            table.components()
        );
        let grid = mirror.part(table.grid()).unwrap_or_else(|error| panic!("{error}"));
        let active: Vec<usize> = grid.active().collect();
        let k = active.len();
        let directions: Vec<Direction> = components.directions().collect();
        let entries: Vec<Entry> = components.entries().collect();
        let mut matrix = Mat::zeros(directions.len() * k, directions.len() * k);
        for (column, &source) in active.iter().enumerate() {
            let (si, sj) = grid.position(source);
            for (image_x, image_y) in [(false, false), (true, false), (false, true), (true, true)] {
                if (image_x && mirror.x.is_none()) || (image_y && mirror.y.is_none()) {
                    continue;
                }
                let place = |index: usize, image: bool| {
                    if image { -1 - index as i64 } else { index as i64 }
                };
                let (si, sj) = (place(si, image_x), place(sj, image_y));
                for (row, &receiver) in active.iter().enumerate() {
                    let (ri, rj) = grid.position(receiver);
                    let block = table.coefficient(ri as i64 - si, rj as i64 - sj).block();
                    for (c, &displaced) in directions.iter().enumerate() {
                        for (d, &loaded) in directions.iter().enumerate() {
                            if entries.contains(&Entry::between(displaced, loaded)) {
                                let [sign_x, sign_y] = mirror.parity(loaded);
                                let sign = if image_x { sign_x } else { 1.0 }
                                    * if image_y { sign_y } else { 1.0 };
                                matrix[(c * k + row, d * k + column)] +=
                                    sign * block[displaced as usize][loaded as usize];
                            }
                        }
                    }
                }
            }
        }
        Self { grid, components, active, matrix }
    }

    /// Returns the matrix: blocks of the components over the elements of Ω in ascending order,
    /// masked ones left out.
    pub fn matrix(&self) -> MatRef<'_, f64> {
        self.matrix.as_ref()
    }
}

impl Influence for Dense {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn components(&self) -> Components {
        self.components
    }

    fn scratch_size(&self, _threads: usize) -> ScratchSize {
        ScratchSize { real: 2 * self.matrix.nrows(), complex: 0 }
    }

    fn apply(&self, out: &mut [f64], p: &[f64], scratch: &mut Scratch) {
        let (k, n, size) = (self.active.len(), self.grid.len(), self.matrix.nrows());
        let blocks = self.components.len();
        assert_eq!((out.len(), p.len()), (blocks * n, blocks * n), "fields on another grid");
        let (real, _) = scratch.take(self.scratch_size(1));
        let (traction, displacement) = real.split_at_mut(size);
        for block in 0..blocks {
            for (place, &e) in self.active.iter().enumerate() {
                traction[block * k + place] = p[block * n + e];
            }
        }
        multiply(
            MatMut::from_column_major_slice_mut(displacement, size, 1),
            Accum::Replace,
            self.matrix.as_ref(),
            MatRef::from_column_major_slice(traction, size, 1),
            1.0,
        );
        out.fill(0.0);
        for block in 0..blocks {
            for (place, &e) in self.active.iter().enumerate() {
                out[block * n + e] = displacement[block * k + place];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foundation::HalfSpace;
    use crate::influence::laws;
    use crate::model::{Material, Projection};

    #[test]
    fn obeys_the_laws() {
        laws::hold(|table, components, mirror| Box::new(Dense::of(table, components, mirror)));
    }

    #[test]
    fn averaged_operator_is_positive_definite() {
        for poisson in [0.0, 0.3, 0.5] {
            for (hx, hy) in [(1.0, 1.0), (0.1, 1.0), (30.0, 1.0)] {
                let grid = Grid::new(6, 5, hx, hy, [0.0; 2])
                    .unwrap()
                    .masked_by(|x, y| x > 0.5 * hx || y > 0.5 * hy);
                let bodies = HalfSpace::new(&Material { shear_modulus: 1.0, poisson }, None);
                let dense = Dense::new(&InfluenceTable::new(&grid, &bodies, Projection::Average));
                let matrix = dense.matrix();
                assert_eq!(matrix.nrows(), 3 * grid.active_len());
                assert_eq!((matrix - matrix.transpose()).norm_max(), 0.0);
                assert!(matrix.llt(faer::Side::Lower).is_ok(), "ν = {poisson}, {hx} × {hy}");
            }
        }
    }
}
