//! The operator as a matrix: the oracle for small grids.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::{Influence, InfluenceTable, Scratch, ScratchSize};
use crate::grid::Grid;

/// A as one matrix over the elements of Ω; 72·k² bytes for k of them.
#[derive(Clone, Debug)]
pub struct Dense {
    grid: Grid,
    active: Vec<usize>,
    matrix: Mat<f64>,
}

impl Dense {
    /// The matrix of these coefficients on Ω of the table's grid.
    pub fn new(table: &InfluenceTable) -> Self {
        let grid = table.grid().clone();
        let active: Vec<usize> = grid.active().collect();
        let k = active.len();
        let mut matrix = Mat::zeros(3 * k, 3 * k);
        for (column, &source) in active.iter().enumerate() {
            let (si, sj) = grid.position(source);
            for (row, &receiver) in active.iter().enumerate() {
                let (ri, rj) = grid.position(receiver);
                let block = table.coefficient(ri as i64 - si as i64, rj as i64 - sj as i64).block();
                for (c, entries) in block.iter().enumerate() {
                    for (d, &entry) in entries.iter().enumerate() {
                        matrix[(c * k + row, d * k + column)] = entry;
                    }
                }
            }
        }
        Self { grid, active, matrix }
    }

    /// The matrix: blocks n | x | y over the elements of Ω in ascending order, masked ones left out.
    pub fn matrix(&self) -> MatRef<'_, f64> {
        self.matrix.as_ref()
    }

    fn apply_blocks(&self, blocks: usize, out: &mut [f64], p: &[f64], scratch: &mut Scratch) {
        let (k, n) = (self.active.len(), self.grid.len());
        assert_eq!((out.len(), p.len()), (blocks * n, blocks * n), "fields on another grid");
        let (real, _) = scratch.take(self.scratch_size(1));
        let (from, to) = real.split_at_mut(3 * k);
        let (from, to) = (&mut from[..blocks * k], &mut to[..blocks * k]);
        for block in 0..blocks {
            for (at, &e) in self.active.iter().enumerate() {
                from[block * k + at] = p[block * n + e];
            }
        }
        matmul(
            MatMut::from_column_major_slice_mut(to, blocks * k, 1),
            Accum::Replace,
            self.matrix.as_ref().submatrix(0, 0, blocks * k, blocks * k),
            MatRef::from_column_major_slice(from, blocks * k, 1),
            1.0,
            Par::Seq,
        );
        out.fill(0.0);
        for block in 0..blocks {
            for (at, &e) in self.active.iter().enumerate() {
                out[block * n + e] = to[block * k + at];
            }
        }
    }
}

impl Influence for Dense {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn scratch_size(&self, _threads: usize) -> ScratchSize {
        ScratchSize { real: 6 * self.active.len(), complex: 0 }
    }

    fn apply(&self, out: &mut [f64], p: &[f64], scratch: &mut Scratch) {
        self.apply_blocks(3, out, p, scratch);
    }

    fn apply_normal(&self, out: &mut [f64], pressure: &[f64], scratch: &mut Scratch) {
        self.apply_blocks(1, out, pressure, scratch);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foundation::half_space::HalfSpace;
    use crate::influence::laws;
    use crate::scene::{Material, Projection};

    #[test]
    fn obeys_the_laws() {
        laws::hold(|table| Box::new(Dense::new(table)));
    }

    #[test]
    fn averaged_operator_is_positive_definite() {
        for poisson in [0.0, 0.3, 0.5] {
            for (hx, hy) in [(1.0, 1.0), (0.1, 1.0), (30.0, 1.0)] {
                let grid = Grid::new(6, 5, hx, hy, [0.0; 2]).unwrap().masked_by(|x, y| x > 0.5 * hx || y > 0.5 * hy);
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
