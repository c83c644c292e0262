//! The operators that are kept between solves: jobs of a sweep that share a grid and elastic ratios
//! share their coefficients.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::equation::{OperatorKey, Problem};
use crate::common::Cancellation;
use crate::foundation::Kernels;
use crate::influence::{
    Circulant, Components, Diagonals, Influence, InfluenceTable, Mirror, RollingTables,
    RollingToeplitz, Scratch, Toeplitz,
};

/// The operator of a problem, for its components and on its side of mirror planes, with the
/// coefficients of which it is made: A, or in steady rolling the operator whose tangential rows are
/// those of A minus the same a rolled distance ahead.
#[derive(Clone)]
pub struct Operator {
    /// The influence coefficients of every offset of the whole grid.
    pub table: Arc<InfluenceTable>,
    /// The coefficients of the tangential rows in steady rolling, and what they are made of.
    pub(crate) rolled: Option<RolledCoefficients>,
    /// The operator as a product with a field.
    pub influence: Arc<dyn Influence>,
    /// The circulants near the diagonal blocks of A, for preconditioning.
    pub circulant: Arc<Circulant>,
}

/// The coefficients of what rolls by a distance, and the kernels by which they were computed.
#[derive(Clone)]
pub(crate) struct RolledCoefficients {
    /// The coefficients.
    table: Arc<InfluenceTable>,
    /// The kernels of the bodies, for the places that lie the distance ahead of elements.
    pub(crate) kernels: Arc<Kernels>,
}

impl Operator {
    /// Makes the operator of these tables on a window, or on all of a problem's part of the grid.
    fn new(
        table: Arc<InfluenceTable>,
        rolled: Option<RolledCoefficients>,
        components: Components,
        mirror: Mirror,
        window: Option<[usize; 2]>,
    ) -> (Self, usize) {
        let (influence, circulant, bytes): (Arc<dyn Influence>, Circulant, usize);
        match (&rolled, window) {
            (None, None) => {
                let toeplitz = Toeplitz::of(&table, components, mirror);
                circulant = Circulant::of(&table, components, mirror);
                (bytes, influence) = (toeplitz.bytes(), Arc::new(toeplitz));
            }
            (None, Some(size)) => {
                let toeplitz = Toeplitz::within(&table, components, mirror, size);
                circulant = Circulant::within(&table, components, mirror, size);
                (bytes, influence) = (toeplitz.bytes(), Arc::new(toeplitz));
            }
            (Some(rolled), _) => {
                let tables = RollingTables { still: &table, rolled: &rolled.table };
                let rolling = match window {
                    None => RollingToeplitz::of(tables, components, mirror),
                    Some(size) => RollingToeplitz::within(tables, components, mirror, size),
                };
                let size = [rolling.grid().nx(), rolling.grid().ny()];
                circulant = Circulant::within(&table, components, mirror, size);
                (bytes, influence) = (rolling.bytes(), Arc::new(rolling));
            }
        }
        let bytes = bytes + circulant.bytes();
        (Self { table, rolled, influence, circulant: Arc::new(circulant) }, bytes)
    }

    /// Returns the diagonal entries by which a natural map divides. In steady rolling the
    /// tangential one is the largest of its coefficients.
    pub fn diagonals(&self) -> Diagonals {
        let diagonals = self.table.diagonals();
        match &self.rolled {
            None => diagonals,
            Some(rolled) => {
                Diagonals { tangential: rolled.table.largest_tangential(), ..diagonals }
            }
        }
    }

    /// Returns the displacement (n, x, y) of the element `receiver` under the tractions `p`, added
    /// up element by element, on a grid without mirror planes.
    pub(crate) fn displacement_at(&self, receiver: usize, p: &[f64]) -> [f64; 3] {
        let components = self.influence.components();
        match &self.rolled {
            None => self.table.displacement_at(receiver, components, p),
            Some(rolled) => RollingTables { still: &self.table, rolled: &rolled.table }
                .displacement_at(receiver, components, p),
        }
    }

    /// Computes out = A p.
    pub(crate) fn apply(&self, out: &mut [f64], p: &[f64], scratch: &mut Scratch) {
        self.influence.apply(out, p, scratch);
    }

    /// Returns this operator on a window of `size` elements along x and y, on which it knows no
    /// mask. If there are mirror planes, the window must begin at them.
    pub(crate) fn within(&self, size: [usize; 2], mirror: Mirror) -> Self {
        let components = self.influence.components();
        let (table, rolled) = (Arc::clone(&self.table), self.rolled.clone());
        Self::new(table, rolled, components, mirror, Some(size)).0
    }

    /// Returns the operator A of the same components on the same part of the grid; `mirror` are its
    /// planes.
    pub(crate) fn still(&self, mirror: Mirror) -> Self {
        let components = self.influence.components();
        Self::new(Arc::clone(&self.table), None, components, mirror, None).0
    }

    /// Makes the memory for applications.
    pub(crate) fn scratch(&self) -> Scratch {
        Scratch::new(&*self.influence)
    }
}

/// The operators that were used last, within a budget of memory.
pub struct Operators {
    /// The operators, the one used last at the end.
    kept: Vec<KeptOperator>,
    /// The budget \[bytes\].
    budget: usize,
    /// The request to give up the solves that use them.
    cancellation: Cancellation,
}

/// An operator that is kept, with its key.
struct KeptOperator {
    key: OperatorKey,
    operator: Operator,
    /// The memory without the table, which others may share \[bytes\].
    bytes: usize,
}

impl Operators {
    /// The memory of operators that are kept by [`default`](Self::default) \[bytes\].
    pub(crate) const BUDGET: usize = 512 << 20;

    /// Keeps operators of up to `budget` bytes in all. The one in use is kept whatever its size.
    pub(crate) fn new(budget: usize) -> Self {
        Self { kept: Vec::new(), budget, cancellation: Cancellation::default() }
    }

    /// Makes operators for solves that end early when `cancellation` is requested.
    pub fn cancelled_by(cancellation: &Cancellation) -> Self {
        Self { cancellation: cancellation.clone(), ..Self::default() }
    }

    /// Returns the request to give up the solves that use them.
    pub fn cancellation(&self) -> &Cancellation {
        &self.cancellation
    }

    /// Returns the operator of `problem`, which is made if it is not kept.
    pub fn of(&mut self, problem: &Problem) -> Operator {
        let key = problem.operator_key();
        if let Some(index) = self.kept.iter().position(|kept| kept.key == key) {
            let kept = self.kept.remove(index);
            let operator = kept.operator.clone();
            self.kept.push(kept);
            return operator;
        }
        let (components, mirror) = (problem.components, problem.mirror);
        let has = |kept: &&KeptOperator| {
            kept.key.shares_table(&key) && kept.operator.table.components().includes(components)
        };
        let table = match self.kept.iter().find(has) {
            Some(kept) => Arc::clone(&kept.operator.table),
            None => Arc::new(InfluenceTable::of(
                problem.whole_grid(),
                &problem.elasticity,
                problem.projection,
                components,
            )),
        };
        let rolled = key.steady().map(|distance| {
            let has = |kept: &KeptOperator| {
                kept.key.shares_table(&key)
                    && kept.key.steady() == Some(distance)
                    && Arc::ptr_eq(&kept.operator.table, &table)
            };
            let kept = self.kept.iter().find(|kept| has(kept));
            kept.and_then(|kept| kept.operator.rolled.clone()).unwrap_or_else(|| {
                let kernels = Arc::new(table.kernels_ahead(&problem.elasticity, distance));
                let table = Arc::new(table.rolled(&kernels, problem.projection, distance));
                RolledCoefficients { table, kernels }
            })
        });
        let (operator, bytes) = Operator::new(table, rolled, components, mirror, None);
        self.kept.push(KeptOperator { key, operator: operator.clone(), bytes });
        while self.bytes() > self.budget && self.kept.len() > 1 {
            self.kept.remove(0);
        }
        operator
    }

    /// Returns the memory of all operators that are kept; each table counts once \[bytes\].
    fn bytes(&self) -> usize {
        let tables: BTreeMap<_, usize> = self
            .kept
            .iter()
            .flat_map(|kept| {
                let rolled = kept.operator.rolled.as_ref().map(|rolled| &rolled.table);
                std::iter::once(&kept.operator.table).chain(rolled)
            })
            .map(|table| (Arc::as_ptr(table), table.bytes()))
            .collect();
        self.kept.iter().map(|kept| kept.bytes).sum::<usize>() + tables.into_values().sum::<usize>()
    }
}

impl Default for Operators {
    /// Keeps up to 512 MiB.
    fn default() -> Self {
        Self::new(Self::BUDGET)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foundation::HalfSpace;
    use crate::grid::Grid;
    use crate::influence::{Components, Symmetry, Window};
    use crate::model::{Material, Projection};

    /// On a window around the tractions the operator has the products that it has on the grid.
    #[test]
    fn within_a_window_it_is_the_same() {
        let bodies = HalfSpace::new(&Material { shear_modulus: 1.0, poisson: 0.3 }, None);
        let grid = Grid::new(120, 96, 0.3, 0.4, [0.0; 2]).unwrap();
        let table = Arc::new(InfluenceTable::new(&grid, &bodies, Projection::Average));
        for mirror in [
            Mirror::NONE,
            Mirror { x: Some(Symmetry::Antisymmetric), y: None },
            Mirror { x: None, y: Some(Symmetry::Symmetric) },
        ] {
            for components in [Components::ALL, Components::NORMAL] {
                let influence = Toeplitz::of(&table, components, mirror);
                let grid = influence.grid().clone();
                let circulant = Arc::new(Circulant::of(&table, components, mirror));
                let operator = Operator {
                    table: Arc::clone(&table),
                    rolled: None,
                    influence: Arc::new(influence),
                    circulant,
                };
                let window = Window::around([[9, 7], [30, 33]], &grid, &mirror);
                assert!(
                    window.holds([[9, 7], [30, 33]]) && 3 * window.len() < grid.len(),
                    "{window:?}"
                );
                assert!(mirror.x.is_none() || window.first[0] == 0);
                let part = operator.within(window.size, mirror);
                let blocks = components.len();
                let tractions: Vec<f64> =
                    (0..blocks * window.len()).map(|index| (1.7 * index as f64).sin()).collect();
                let mut p = vec![0.0; blocks * grid.len()];
                window.each_row(&grid, blocks, |of_window, of_grid| {
                    p[of_grid].copy_from_slice(&tractions[of_window])
                });
                let (mut whole, mut got) = (vec![0.0; p.len()], vec![0.0; tractions.len()]);
                operator.apply(&mut whole, &p, &mut operator.scratch());
                part.apply(&mut got, &tractions, &mut part.scratch());
                let size = whole.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
                window.each_row(&grid, blocks, |of_window, of_grid| {
                    for (got, exact) in got[of_window].iter().zip(&whole[of_grid]) {
                        assert!(
                            (got - exact).abs() <= 1e-14 * size,
                            "{mirror:?} {components:?}: {got} {exact}"
                        );
                    }
                });
            }
        }
    }
}
