//! The influence coefficients of a grid, one block per offset.

use rayon::prelude::*;

use super::components::{Components, Direction, Entry};
use crate::foundation::{Bodies, Coefficient, Kernels};
use crate::grid::Grid;
use crate::model::Projection;

/// The influence coefficients of every offset that occurs on a grid, |Δi| < nx and |Δj| < ny:
/// displacement of the receiver per unit traction on the source, Δ = receiver − source. Their unit
/// is the grid's length times the bodies' compliance.
///
/// Entries that are even in Δj keep the rows Δj ≥ 0 only, so all six have 16·nx·ny numbers instead
/// of 24·nx·ny; those that the table's components do not need are not kept.
#[derive(Clone, Debug)]
pub struct InfluenceTable {
    grid: Grid,
    components: Components,
    /// For each [`Entry`], rows of 2nx − 1 numbers, from Δj = 0 or, if odd in Δj, from Δj = −(ny −
    /// 1); empty if not kept.
    rows: [Vec<f64>; 6],
}

impl InfluenceTable {
    /// Computes the coefficients of all components on the threads of the current rayon pool; the
    /// numbers do not depend on how many there are.
    pub fn new(grid: &Grid, bodies: impl Into<Bodies>, projection: Projection) -> Self {
        Self::of(grid, bodies, projection, Components::ALL)
    }

    /// Computes the coefficients that an operator on these components needs, on the threads of the
    /// current rayon pool; the numbers do not depend on how many there are.
    pub(crate) fn of(
        grid: &Grid,
        bodies: impl Into<Bodies>,
        projection: Projection,
        components: Components,
    ) -> Self {
        let (nx, ny) = (grid.nx(), grid.ny());
        let kernels = bodies.into().kernels((nx as f64 * grid.hx()).hypot(ny as f64 * grid.hy()));
        // With square elements the coefficient of (Δi, Δj) is that of (Δj, Δi) with x and y
        // exchanged.
        let square = grid.hx() == grid.hy();
        let exchanged = |di: usize, dj: usize| square && di < dj && dj < nx;
        let coefficient = |index: usize| {
            let (di, dj) = (index % nx, index / nx);
            if exchanged(di, dj) {
                return Coefficient::default();
            }
            kernels.influence([di as f64, dj as f64], grid.hx(), grid.hy(), projection)
        };
        let quadrant: Vec<Coefficient> =
            (0..grid.len()).into_par_iter().with_min_len(nx).map(coefficient).collect();
        let width = 2 * nx - 1;
        let needed: Vec<Entry> = components.entries().collect();
        let rows = Entry::ALL.map(|entry| {
            if !needed.contains(&entry) {
                return Vec::new();
            }
            let stored = if entry.odd_in_y() { 2 * ny - 1 } else { ny };
            let mut values = vec![0.0; stored * width];
            values.par_chunks_exact_mut(width).enumerate().for_each(|(index, row)| {
                let dj = (index + ny).abs_diff(stored);
                let sign_y = if entry.odd_in_y() && index + ny < stored { -1.0 } else { 1.0 };
                let sign_x = if entry.odd_in_x() { -sign_y } else { sign_y };
                for di in 0..nx {
                    let value = if exchanged(di, dj) {
                        entry.exchanged().value(&quadrant[di * nx + dj])
                    } else {
                        entry.value(&quadrant[dj * nx + di])
                    };
                    row[nx - 1 - di] = sign_x * value;
                    row[nx - 1 + di] = sign_y * value;
                }
            });
            values
        });
        Self { grid: grid.clone(), components, rows }
    }

    /// Returns the kernels of `bodies`, for distances up to those between the elements of this grid
    /// and the places that lie `distance` ahead of them along x, in the grid's unit.
    pub(crate) fn kernels_ahead(&self, bodies: impl Into<Bodies>, distance: f64) -> Kernels {
        let (nx, ny) = (self.grid.nx() as f64, self.grid.ny() as f64);
        let (hx, hy) = (self.grid.hx(), self.grid.hy());
        bodies.into().kernels(((nx + whole(distance / hx).abs()) * hx).hypot(ny * hy))
    }

    /// Computes the coefficients of what rolls by `distance` along x, in the grid's unit: the
    /// displacement of the receiver minus that of the point so far ahead of it, per unit traction
    /// on the source. They have the symmetries in Δj of this table's, and none in Δi. The
    /// [kernels](Self::kernels_ahead) are those of this table's bodies, and `projection` is its
    /// own. A point ahead by whole elements is the centre of one, whose coefficients are known.
    pub(crate) fn rolled(&self, kernels: &Kernels, projection: Projection, distance: f64) -> Self {
        let (nx, ny) = (self.grid.nx(), self.grid.ny());
        let (hx, hy) = (self.grid.hx(), self.grid.hy());
        let ahead = whole(distance / hx);
        let width = 2 * nx - 1;
        let middle = (nx - 1) as f64;
        let known = |column: usize| -> Option<usize> {
            let there = column as f64 + ahead;
            let is_known = ahead.fract() == 0.0 && (0.0..width as f64).contains(&there);
            is_known.then_some(there as usize)
        };
        let there: Vec<Coefficient> = (0..width * ny)
            .into_par_iter()
            .with_min_len(nx)
            .map(|index| {
                let (column, row) = (index % width, index / width);
                if known(column).is_some() {
                    return Coefficient::default();
                }
                let offset = [column as f64 - middle + ahead, row as f64];
                kernels.influence(offset, hx, hy, projection)
            })
            .collect();
        let rows = Entry::ALL.map(|entry| {
            let here = &self.rows[entry as usize];
            let mut values = here.clone();
            let stored = here.len() / width;
            values.par_chunks_exact_mut(width).enumerate().for_each(|(index, row)| {
                let dj = (index + ny).abs_diff(stored);
                let sign = if entry.odd_in_y() && index + ny < stored { -1.0 } else { 1.0 };
                let of_table = &here[index * width..][..width];
                for (column, value) in row.iter_mut().enumerate() {
                    *value -= match known(column) {
                        Some(there) => of_table[there],
                        None => sign * entry.value(&there[dj * width + column]),
                    };
                }
            });
            values
        });
        Self { grid: self.grid.clone(), components: self.components, rows }
    }

    /// Returns the grid, with its mask; the coefficients do not depend on the mask.
    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Returns the components for which the coefficients are kept.
    pub(crate) fn components(&self) -> Components {
        self.components
    }

    /// Returns one entry at offset Δj, contiguous over Δi = −(nx − 1) … nx − 1.
    ///
    /// # Panics
    /// Unless |Δj| < ny and the entry is kept.
    pub(crate) fn row(&self, entry: Entry, dj: i64) -> &[f64] {
        let (width, ny) = (2 * self.grid.nx() - 1, self.grid.ny() as i64);
        assert!(dj.abs() < ny, "offset {dj} on {ny} rows of elements");
        let index = if entry.odd_in_y() { dj + ny - 1 } else { dj.abs() } as usize;
        &self.rows[entry as usize][index * width..(index + 1) * width]
    }

    /// Returns the coefficient of offset (Δi, Δj), zero in the entries that are not kept.
    ///
    /// # Panics
    /// Unless |Δi| < nx and |Δj| < ny.
    pub fn coefficient(&self, di: i64, dj: i64) -> Coefficient {
        let column = (di + self.grid.nx() as i64 - 1) as usize;
        let value = |entry| {
            if self.rows[entry as usize].is_empty() { 0.0 } else { self.row(entry, dj)[column] }
        };
        Coefficient {
            nn: value(Entry::Nn),
            xx: value(Entry::Xx),
            yy: value(Entry::Yy),
            xy: value(Entry::Xy),
            nx: value(Entry::Nx),
            ny: value(Entry::Ny),
        }
    }

    /// Returns the diagonal entries by which a natural map divides.
    pub(crate) fn diagonals(&self) -> Diagonals {
        let diagonal = self.coefficient(0, 0);
        let tangential = diagonal.xx.max(diagonal.yy);
        // A component that is not kept has no entry.
        let kept = |entry: f64, other: f64| if entry > 0.0 { entry } else { other };
        Diagonals {
            normal: kept(diagonal.nn, tangential),
            tangential: kept(tangential, diagonal.nn),
        }
    }

    /// Returns the largest coefficient of a tangential displacement under a traction in its own
    /// direction. In a table of what rolls that is not always the one of the element itself, which
    /// vanishes first when the distance does.
    pub(crate) fn largest_tangential(&self) -> f64 {
        [Entry::Xx, Entry::Yy]
            .iter()
            .flat_map(|entry| &self.rows[*entry as usize])
            .fold(0.0, |largest: f64, value| largest.max(value.abs()))
    }

    /// Returns the largest diagonal entry of the operator on the components that are kept.
    pub fn largest_diagonal(&self) -> f64 {
        let diagonal = self.coefficient(0, 0);
        diagonal.nn.max(diagonal.xx).max(diagonal.yy)
    }

    /// Adds the displacement under the traction (n, x, y) on the element `source` to `displacement`
    /// (blocks n | x | y). Masked receivers get theirs too: the caller skips them when it reads.
    ///
    /// # Panics
    /// Unless `source` is an element, `displacement` has the length 3·len of the grid, and every
    /// entry is kept.
    pub fn add_column(&self, source: usize, traction: [f64; 3], displacement: &mut [f64]) {
        let (nx, k) = (self.grid.nx(), self.grid.len());
        assert!(source < k && displacement.len() == 3 * k);
        let (i, j) = self.grid.position(source);
        let [tn, tx, ty] = traction;
        let (un, tangential) = displacement.split_at_mut(k);
        let (ux, uy) = tangential.split_at_mut(k);
        for receiver_row in 0..self.grid.ny() {
            let dj = receiver_row as i64 - j as i64;
            let column = |entry| &self.row(entry, dj)[nx - 1 - i..][..nx];
            let receivers = receiver_row * nx..(receiver_row + 1) * nx;
            let (un, ux, uy) =
                (&mut un[receivers.clone()], &mut ux[receivers.clone()], &mut uy[receivers]);
            let (nn, xx, yy) = (column(Entry::Nn), column(Entry::Xx), column(Entry::Yy));
            let (xy, n_x, n_y) = (column(Entry::Xy), column(Entry::Nx), column(Entry::Ny));
            for e in 0..nx {
                un[e] += nn[e] * tn + n_x[e] * tx + n_y[e] * ty;
                ux[e] += xx[e] * tx + xy[e] * ty - n_x[e] * tn;
                uy[e] += xy[e] * tx + yy[e] * ty - n_y[e] * tn;
            }
        }
    }

    /// Returns the displacement (n, x, y) of the element `receiver` under the tractions `p`, blocks
    /// of `components`, added up element by element; faster implementations of the operator are
    /// compared with it. It is zero in the components that are left out.
    ///
    /// # Panics
    /// Unless `receiver` is an element, `p` has a block of the grid's length for each component,
    /// and their entries are kept.
    pub(crate) fn displacement_at(
        &self,
        receiver: usize,
        components: Components,
        p: &[f64],
    ) -> [f64; 3] {
        let (nx, k) = (self.grid.nx(), self.grid.len());
        assert!(receiver < k && p.len() == components.len() * k);
        let (i, j) = self.grid.position(receiver);
        let mut displacement = [0.0; 3];
        for displaced in components.directions() {
            for (loaded, p) in components.directions().zip(p.chunks_exact(k)) {
                let entry = Entry::between(displaced, loaded);
                let rows = p.chunks_exact(nx).enumerate().map(|(source_row, p)| {
                    // Δi falls as the source's column rises.
                    let row = &self.row(entry, j as i64 - source_row as i64)[i..i + nx];
                    row.iter().rev().zip(p).map(|(coefficient, p)| coefficient * p).sum::<f64>()
                });
                // The displacement along x or y under pressure is the negative of the normal one
                // under traction.
                let sign =
                    if loaded == Direction::N && displaced != Direction::N { -1.0 } else { 1.0 };
                displacement[displaced as usize] += sign * rows.sum::<f64>();
            }
        }
        displacement
    }

    /// Returns the memory held, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.rows.iter().map(|values| size_of_val(values.as_slice())).sum()
    }
}

#[cfg(test)]
impl InfluenceTable {
    /// Computes the coefficients of what [rolls](Self::rolled) over these bodies.
    pub(super) fn rolled_of(
        &self,
        bodies: impl Into<Bodies>,
        projection: Projection,
        distance: f64,
    ) -> Self {
        self.rolled(&self.kernels_ahead(bodies, distance), projection, distance)
    }
}

/// Returns a number of elements, which is whole if it is so up to rounding.
fn whole(elements: f64) -> f64 {
    const ROUNDING: f64 = 1e-12;
    let nearest = elements.round();
    if (elements - nearest).abs() <= ROUNDING * nearest.abs() { nearest } else { elements }
}

/// The diagonal entries of A, by which residuals become tractions. On a thin incompressible layer
/// one is a millionth of the other, and in the units of the larger one the residual of the smaller
/// one would be nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diagonals {
    /// The normal displacement by the element's own pressure per unit pressure.
    pub normal: f64,
    /// The larger one of both tangential displacements by the element's own traction in their
    /// direction, per unit traction.
    pub tangential: f64,
}

impl From<f64> for Diagonals {
    /// Takes one entry for all directions.
    fn from(diagonal: f64) -> Self {
        Self { normal: diagonal, tangential: diagonal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foundation::HalfSpace;
    use crate::model::{Base, Layer, Material};

    fn bodies() -> HalfSpace {
        HalfSpace::new(&Material { shear_modulus: 1.0, poisson: 0.3 }, None)
    }

    #[test]
    fn holds_the_coefficient_of_every_offset() {
        for (nx, ny) in [(1, 1), (1, 4), (5, 1), (4, 3)] {
            let grid = Grid::new(nx, ny, 0.5, 0.75, [0.0; 2]).unwrap();
            for projection in [Projection::Average, Projection::Midpoint] {
                let table = InfluenceTable::new(&grid, &bodies(), projection);
                for dj in 1 - ny as i64..ny as i64 {
                    for di in 1 - nx as i64..nx as i64 {
                        assert_eq!(
                            table.coefficient(di, dj),
                            bodies().influence([di as f64, dj as f64], 0.5, 0.75, projection)
                        );
                    }
                    assert_eq!(table.row(Entry::Xy, dj).len(), 2 * nx - 1);
                }
            }
        }
    }

    #[test]
    fn keeps_what_its_components_need() {
        let grid = Grid::new(4, 3, 0.5, 0.75, [0.0; 2]).unwrap();
        let all = InfluenceTable::new(&grid, &bodies(), Projection::Average);
        for (components, numbers) in [
            (Components::ALL, 4 * 3 + 2 * 5),
            (Components::NORMAL, 3),
            (Components::X, 3),
            (Components::TANGENTIAL, 3 + 3 + 5),
            (Components::ALL.uncoupled(), 3 + 3 + 3 + 5),
        ] {
            let table = InfluenceTable::of(&grid, &bodies(), Projection::Average, components);
            let kept: Vec<Entry> = components.entries().collect();
            for entry in Entry::ALL {
                for dj in -2..=2 {
                    if kept.contains(&entry) {
                        assert_eq!(table.row(entry, dj), all.row(entry, dj));
                    } else {
                        assert_eq!(entry.value(&table.coefficient(1, dj)), 0.0);
                    }
                }
            }
            assert_eq!(table.bytes(), numbers * 7 * 8);
        }
    }

    #[test]
    fn a_column_is_the_displacement_under_one_element() {
        let grid = Grid::new(4, 3, 0.5, 0.75, [0.0; 2]).unwrap();
        let table = InfluenceTable::new(&grid, &bodies(), Projection::Average);
        let traction = [0.3, -1.0, 0.6];
        for source in 0..grid.len() {
            let mut got = vec![1.0; 3 * grid.len()];
            table.add_column(source, traction, &mut got);
            let (si, sj) = grid.position(source);
            for receiver in 0..grid.len() {
                let (ri, rj) = grid.position(receiver);
                let block = table.coefficient(ri as i64 - si as i64, rj as i64 - sj as i64).block();
                for c in 0..3 {
                    let expected = 1.0 + (0..3).map(|d| block[c][d] * traction[d]).sum::<f64>();
                    assert!((got[c * grid.len() + receiver] - expected).abs() < 1e-15);
                }
            }
        }
    }

    /// Rolling by whole elements takes the difference of two coefficients of the same table.
    #[test]
    fn rolled_by_whole_elements_it_is_a_difference_of_its_own_coefficients() {
        let (nx, ny) = (9, 4);
        let layer = Layer { shear_modulus: 4.0, poisson: 0.1, thickness: 0.7 };
        for bodies in [Bodies::from(&bodies()), Bodies::new(&[layer], &Base::Rigid, None)] {
            for projection in [Projection::Average, Projection::Midpoint] {
                let grid = Grid::new(nx, ny, 0.3, 0.4, [0.0; 2]).unwrap();
                let table = InfluenceTable::new(&grid, &bodies, projection);
                for ahead in [1_i64, -1, 3] {
                    // The distance is a multiple of the element up to rounding only.
                    let rolled = table.rolled_of(&bodies, projection, 0.1 * 3.0 * ahead as f64);
                    for dj in 1 - ny as i64..ny as i64 {
                        for di in (1 - nx as i64).max(1 - nx as i64 - ahead)
                            ..(nx as i64).min(nx as i64 - ahead)
                        {
                            let (got, here, there) = (
                                rolled.coefficient(di, dj).block(),
                                table.coefficient(di, dj).block(),
                                table.coefficient(di + ahead, dj).block(),
                            );
                            for c in 0..3 {
                                for d in 0..3 {
                                    let exact = here[c][d] - there[c][d];
                                    assert!(
                                        (got[c][d] - exact).abs()
                                            <= 1e-14 * here[1][1].abs().max(0.1),
                                        "{projection:?} {ahead} {di} {dj}: {} {exact}",
                                        got[c][d]
                                    );
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    /// Rolling from one place between elements to another adds up.
    #[test]
    fn rolled_distances_add_up() {
        let bodies = bodies();
        let grid = Grid::new(6, 3, 0.3, 0.4, [0.0; 2]).unwrap();
        for projection in [Projection::Average, Projection::Midpoint] {
            let table = InfluenceTable::new(&grid, &bodies, projection);
            let part = table.rolled_of(&bodies, projection, 0.06);
            let back = table.rolled_of(&bodies, projection, -0.24);
            // The point 0.06 ahead of one element is 0.24 behind the next.
            for dj in -2..=2 {
                for di in -5..5 {
                    let step = table.coefficient(di, dj).xy - part.coefficient(di, dj).xy;
                    let next = table.coefficient(di + 1, dj).xy - back.coefficient(di + 1, dj).xy;
                    assert!((step - next).abs() < 1e-15, "{di} {dj}: {step} {next}");
                }
            }
        }
    }

    #[test]
    fn does_not_depend_on_the_number_of_threads() {
        let grid = Grid::new(40, 30, 1.0, 0.3, [0.0; 2]).unwrap();
        let layer = Layer { shear_modulus: 4.0, poisson: 0.1, thickness: 0.2 };
        for bodies in [Bodies::from(&bodies()), Bodies::new(&[layer], &Base::Rigid, None)] {
            let with = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| InfluenceTable::new(&grid, &bodies, Projection::Average).rows)
            };
            assert_eq!(with(1), with(3));
        }
    }
}
