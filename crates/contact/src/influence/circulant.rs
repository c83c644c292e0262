//! The circulant nearest to each diagonal block of A, and its inverse: the preconditioner of the
//! Krylov iterations.
//!
//! It is T. Chan's optimal circulant of a Toeplitz matrix (SIAM J. Sci. Stat. Comput. 9 (1988)
//! 766–771, doi:10.1137/0909051), in both directions: it lives on a torus of the grid's own size,
//! and is positive definite where the block is.

use super::components::{Components, Direction, Entry};
use super::mirror::Mirror;
use super::operator::Scratch;
use super::symbols::Symbols;
use super::table::InfluenceTable;
use super::torus::Torus;

/// The inverse circulants of the diagonal blocks of A on some components, and on the part of the
/// grid that mirror planes leave.
#[derive(Clone, Debug)]
pub struct Circulant {
    torus: Torus,
    /// The eigenvalues of the circulant of each component.
    eigenvalues: Vec<Symbols>,
}

impl Circulant {
    /// Computes the circulants of all of the table's components.
    pub(crate) fn new(table: &InfluenceTable) -> Self {
        Self::of(table, table.components(), Mirror::NONE)
    }

    /// Computes the circulants of these components, for fields with these symmetries.
    ///
    /// # Panics
    /// If the table does not hold the coefficients, or a mirrored direction has an odd number of
    /// elements.
    pub fn of(table: &InfluenceTable, components: Components, mirror: Mirror) -> Self {
        assert!(
            table.components().includes(components.uncoupled()),
            "{components:?} of a table of {:?}",
            table.components()
        );
        assert!(
            mirror.part(table.grid()).is_ok(),
            "a mirror plane through elements, or a mask without symmetry"
        );
        Self::on([table.grid().nx(), table.grid().ny()], table, components, mirror)
    }

    /// Computes the circulants for a window of so many elements of the part that mirror planes
    /// leave; the window begins at the planes.
    ///
    /// # Panics
    /// If the table does not hold the coefficients, or is smaller.
    pub(crate) fn within(
        table: &InfluenceTable,
        components: Components,
        mirror: Mirror,
        size: [usize; 2],
    ) -> Self {
        Self::on(mirror.whole_size(size), table, components, mirror)
    }

    /// Computes the circulants on a torus of `whole` elements, mirror images included.
    fn on(
        whole: [usize; 2],
        table: &InfluenceTable,
        components: Components,
        mirror: Mirror,
    ) -> Self {
        let torus = Torus::new(whole, mirror, false);
        // Both ways round the torus count, each with its share.
        let wraps = |i: usize, n: usize| {
            [(i, (n - i) as f64 / n as f64), (n - i, i as f64 / n as f64)]
                .into_iter()
                .filter(|(_, share)| *share > 0.0)
        };
        let value = |entry: Entry, i: usize, j: usize| {
            wraps(j, whole[1])
                .map(|(dj, wy)| {
                    let row = table.row(entry, dj as i64);
                    wy * wraps(i, whole[0])
                        .map(|(di, wx)| wx * row[table.grid().nx() - 1 + di])
                        .sum::<f64>()
                })
                .sum::<f64>()
        };
        let extent = whole.map(|n| n / 2 + 1);
        let eigenvalues = components
            .directions()
            .map(|direction: Direction| {
                let mut eigenvalues = Symbols::new(&torus, &[direction], extent, value);
                // Collocation is not quite positive definite.
                eigenvalues.raise_to(1e-6);
                eigenvalues
            })
            .collect();
        Self { torus, eigenvalues }
    }

    /// Computes out = (C + `epsilon`)⁻¹ `field`, block by block (one per component).
    ///
    /// # Panics
    /// If a field has another length.
    pub fn invert(&self, out: &mut [f64], field: &[f64], epsilon: f64, scratch: &mut Scratch) {
        let (size, blocks) = (self.torus.field_len(), self.eigenvalues.len());
        assert_eq!(
            (out.len(), field.len()),
            (blocks * size, blocks * size),
            "fields on another grid"
        );
        // The transforms there and back multiply a field by the gain.
        let gain = self.torus.gain();
        for ((out, block), eigenvalues) in
            out.chunks_exact_mut(size).zip(field.chunks_exact(size)).zip(&self.eigenvalues)
        {
            let inverse = |[c]: [f64; 1]| [1.0 / (gain * (gain * c + epsilon))];
            self.torus.convolve::<1, 1>(eigenvalues, inverse, None, out, block, scratch);
        }
    }

    /// Returns the smallest eigenvalue of the circulant near the normal block, which has about the
    /// smallest one of the block itself; 0 if the normal component is not among those here.
    pub(crate) fn least_normal(&self) -> f64 {
        let mut normal = self.eigenvalues.iter().filter(|of| of.directions == [Direction::N]);
        normal.next().map_or(0.0, |of| self.torus.gain() * of.least())
    }

    /// Returns the memory held, in bytes, the plans of the transforms left out.
    pub(crate) fn bytes(&self) -> usize {
        self.eigenvalues.iter().map(Symbols::bytes).sum()
    }
}

#[cfg(test)]
mod tests {
    use faer::Side;

    use super::*;
    use crate::foundation::{Bodies, HalfSpace};
    use crate::grid::Grid;
    use crate::influence::dense::Dense;
    use crate::influence::mirror::Symmetry;
    use crate::model::{Base, Layer, Material, Projection};

    const SOFT: Material = Material { shear_modulus: 1.0, poisson: 0.3 };

    /// On a torus of circulant coefficients the inverse is exact: C (C⁻¹ x) = x, C applied entry by
    /// entry.
    #[test]
    fn inverts_the_circulant_it_is_made_of() {
        let (nx, ny) = (6, 5);
        let grid = Grid::new(nx, ny, 0.3, 0.4, [0.0; 2]).unwrap();
        let bodies = HalfSpace::new(&Material { shear_modulus: 1.0, poisson: 0.3 }, None);
        let table = InfluenceTable::new(&grid, &bodies, Projection::Average);
        let circulant = Circulant::new(&table);
        let k = nx * ny;
        let field: Vec<f64> = (0..3 * k).map(|e| (1.7 * e as f64).sin()).collect();
        let epsilon = 0.01;
        let mut solved = vec![0.0; 3 * k];
        circulant.invert(&mut solved, &field, epsilon, &mut Scratch::for_elements(k));
        for (block, entry) in [Entry::Nn, Entry::Xx, Entry::Yy].into_iter().enumerate() {
            for e in 0..k {
                let (i, j) = (e % nx, e / nx);
                let mut sum = epsilon * solved[block * k + e];
                for source in 0..k {
                    let (di, dj) = ((i + nx - source % nx) % nx, (j + ny - source / nx) % ny);
                    let mut share = 0.0;
                    for (dj, wy) in
                        [(dj, ny - dj), (ny - dj, dj)].into_iter().filter(|(_, w)| *w > 0)
                    {
                        for (di, wx) in
                            [(di, nx - di), (nx - di, di)].into_iter().filter(|(_, w)| *w > 0)
                        {
                            share += (wx * wy) as f64 / k as f64
                                * table.row(entry, dj as i64)[nx - 1 + di];
                        }
                    }
                    sum += share * solved[block * k + source];
                }
                assert!((sum - field[block * k + e]).abs() < 1e-12, "{entry:?} {e}");
            }
        }
    }

    /// The smallest eigenvalue of the circulant is not below that of the block, and close to it,
    /// whatever the shape of the elements and the coating that they are on.
    #[test]
    fn its_least_eigenvalue_is_near_that_of_the_block() {
        let coating = |shear_modulus: f64| {
            let layer = Layer { shear_modulus, poisson: 0.3, thickness: 0.1 };
            Bodies::new(&[layer], &Base::Elastic(SOFT), None)
        };
        let soft = Bodies::new(&[], &Base::Elastic(SOFT), None);
        for (name, bodies, size, [hx, hy]) in [
            ("squares", soft.clone(), [16, 16], [0.1, 0.1]),
            ("few squares", soft.clone(), [6, 6], [0.1, 0.1]),
            ("10 : 1", soft.clone(), [16, 16], [1.0, 0.1]),
            ("100 : 1", soft, [16, 16], [10.0, 0.1]),
            ("5 times as stiff", coating(5.0), [16, 16], [0.1, 0.1]),
            ("10 times as stiff", coating(10.0), [16, 16], [0.1, 0.1]),
            ("100 times as stiff", coating(100.0), [16, 16], [0.1, 0.1]),
            ("10 times as soft", coating(0.1), [16, 16], [0.1, 0.1]),
        ] {
            let grid = Grid::new(size[0], size[1], hx, hy, [0.0; 2]).unwrap();
            let table = InfluenceTable::of(&grid, bodies, Projection::Average, Components::NORMAL);
            let circulant = Circulant::of(&table, Components::NORMAL, Mirror::NONE);
            let block = Dense::of(&table, Components::NORMAL, Mirror::NONE);
            let least = block.matrix().self_adjoint_eigenvalues(Side::Lower).unwrap()[0];
            let ratio = circulant.least_normal() / least;
            assert!((1.0 - 1e-9..1.2).contains(&ratio), "{name}: {ratio}");
        }
    }

    #[test]
    fn on_a_part_it_is_that_of_the_whole_on_symmetric_fields() {
        let each = [None, Some(Symmetry::Symmetric), Some(Symmetry::Antisymmetric)];
        for (nx, ny) in [(2, 2), (4, 6), (6, 10), (14, 2), (16, 12)] {
            let grid = Grid::new(nx, ny, 0.3, 0.4, [0.0; 2]).unwrap();
            let bodies = HalfSpace::new(&Material { shear_modulus: 1.0, poisson: 0.3 }, None);
            let table = InfluenceTable::new(&grid, &bodies, Projection::Average);
            for mirror in each.into_iter().flat_map(|x| each.map(|y| Mirror { x, y })) {
                for components in
                    [Components::ALL, Components::NORMAL, Components::TANGENTIAL, Components::Y]
                {
                    let k = mirror.part(&grid).unwrap().len();
                    let field: Vec<f64> =
                        (0..components.len() * k).map(|e| (1.7 * e as f64).sin()).collect();
                    let whole = mirror.extend(&grid, components, &field);
                    let invert = |mirror, field: &[f64], threads| {
                        let mut out = vec![0.0; field.len()];
                        Circulant::of(&table, components, mirror).invert(
                            &mut out,
                            field,
                            0.01,
                            &mut Scratch::on_threads(threads),
                        );
                        out
                    };
                    let solved = invert(mirror, &field, 1);
                    assert_eq!(solved, invert(mirror, &field, 3), "threads");
                    let whole = invert(Mirror::NONE, &whole, 1);
                    let size = whole.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
                    for (got, expected) in
                        mirror.extend(&grid, components, &solved).iter().zip(&whole)
                    {
                        assert!(
                            (got - expected).abs() <= 1e-13 * size,
                            "{nx} × {ny} {components:?} {mirror:?}"
                        );
                    }
                }
            }
        }
    }
}
