//! The operator as a block-Toeplitz matrix, applied by FFT.
//!
//! A coefficient depends on the offset only, so A p is a convolution. It is cyclic on a torus of at
//! least (2nx − 1) × (2ny − 1) elements, where Fourier's transform makes it a product with the
//! symbol of each entry.

use super::components::{Components, Direction, Entry};
use super::mirror::Mirror;
use super::operator::{Influence, Scratch, ScratchSize, group_by_group};
use super::symbols::Symbols;
use super::table::InfluenceTable;
use super::torus::Torus;
use crate::grid::Grid;

/// The operator A by FFT: it takes memory O(k), and an application takes O(k log k). With fewer
/// components or with mirror planes both shrink in proportion.
#[derive(Clone, Debug)]
pub struct Toeplitz {
    grid: Grid,
    components: Components,
    torus: Torus,
    /// The symbols of each group of components that couple.
    symbols: Vec<Symbols>,
}

impl Toeplitz {
    /// Makes the operator of all of the table's components on Ω of its grid.
    pub fn new(table: &InfluenceTable) -> Self {
        Self::of(table, table.components(), Mirror::NONE)
    }

    /// Makes the operator on these components of fields with these symmetries; it lives on the part
    /// of the table's grid on the positive sides of the mirror planes.
    ///
    /// # Panics
    /// If the table does not hold the coefficients, or its grid is not symmetric.
    pub fn of(table: &InfluenceTable, components: Components, mirror: Mirror) -> Self {
        assert!(
            table.components().includes(components),
            "{components:?} of a table of {:?}",
            table.components()
        );
        let grid = mirror.part(table.grid()).unwrap_or_else(|error| panic!("{error}"));
        Self::on(grid, table, components, mirror)
    }

    /// Makes the operator on a window of so many elements of such a part, without a mask; the
    /// window begins at the mirror planes.
    ///
    /// # Panics
    /// If the table does not hold the coefficients, or is smaller.
    pub(crate) fn within(
        table: &InfluenceTable,
        components: Components,
        mirror: Mirror,
        size: [usize; 2],
    ) -> Self {
        assert!(
            table.components().includes(components),
            "{components:?} of a table of {:?}",
            table.components()
        );
        let grid = Grid::new(size[0], size[1], table.grid().hx(), table.grid().hy(), [0.0; 2])
            .unwrap_or_else(|error| panic!("{error}"));
        Self::on(grid, table, components, mirror)
    }

    /// Makes the operator on `grid`, which is a part of the table's grid or a window of it.
    fn on(grid: Grid, table: &InfluenceTable, components: Components, mirror: Mirror) -> Self {
        let extent = mirror.whole_size([grid.nx(), grid.ny()]);
        let torus = Torus::new(extent, mirror, true);
        let middle = table.grid().nx() - 1;
        let value = |entry: Entry, di: usize, dj: usize| table.row(entry, dj as i64)[middle + di];
        let symbols = components
            .groups()
            .map(|group: Vec<Direction>| Symbols::new(&torus, &group, extent, value))
            .collect();
        Self { grid, components, torus, symbols }
    }

    /// Returns the memory held, in bytes, the plans of the transforms left out.
    pub(crate) fn bytes(&self) -> usize {
        self.symbols.iter().map(Symbols::bytes).sum()
    }
}

impl Influence for Toeplitz {
    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn components(&self) -> Components {
        self.components
    }

    fn scratch_size(&self, threads: usize) -> ScratchSize {
        let largest = self.symbols.iter().map(Symbols::fields).max().unwrap_or(0);
        self.torus.scratch_size(largest, threads)
    }

    fn apply(&self, out: &mut [f64], p: &[f64], scratch: &mut Scratch) {
        let (k, mask) = (self.grid.len(), self.grid.mask());
        let groups = self.symbols.iter().map(|symbols| (symbols, symbols.fields()));
        group_by_group(groups, k, out, p, |symbols, out, p| match symbols.fields() {
            1 => self.torus.convolve::<1, 1>(symbols, |s| s, mask, out, p, scratch),
            2 => self.torus.convolve::<2, 3>(symbols, |s| s, mask, out, p, scratch),
            _ => self.torus.convolve::<3, 6>(symbols, |s| s, mask, out, p, scratch),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foundation::HalfSpace;
    use crate::influence::dense::Dense;
    use crate::influence::laws;
    use crate::model::{Material, Projection};

    #[test]
    fn obeys_the_laws() {
        laws::hold(|table, components, mirror| Box::new(Toeplitz::of(table, components, mirror)));
    }

    #[test]
    fn same_bytes_on_any_number_of_threads() {
        laws::same_on_any_number_of_threads(|table, components, mirror| {
            Box::new(Toeplitz::of(table, components, mirror))
        });
    }

    #[test]
    fn both_operators_agree() {
        for (nx, ny, hx, hy) in
            [(24, 24, 1.0, 1.0), (7, 30, 0.2, 1.0), (31, 4, 1.0, 90.0), (1, 1, 1.0, 1.0)]
        {
            for projection in [Projection::Average, Projection::Midpoint] {
                let (cx, cy) = (0.5 * nx as f64 * hx, 0.5 * ny as f64 * hy);
                let grid = Grid::new(nx, ny, hx, hy, [0.5 * hx - cx, 0.5 * hy - cy]).unwrap();
                let disk = grid.masked_by(|x, y| (x / cx).powi(2) + (y / cy).powi(2) < 0.9);
                let bodies = HalfSpace::new(&Material { shear_modulus: 1.0, poisson: 0.3 }, None);
                let table = InfluenceTable::new(&disk, &bodies, projection);
                let p: Vec<f64> =
                    (0..3 * disk.len()).map(|e| ((e * e) as f64 * 0.37).sin()).collect();
                let dense = laws::apply(&Dense::new(&table), &p);
                let size = dense.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
                laws::close("dense = FFT", &laws::apply(&Toeplitz::new(&table), &p), &dense, size);
            }
        }
    }
}
