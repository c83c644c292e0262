//! Operators kept between solves: jobs of a sweep that share a grid and elastic ratios share their coefficients.

use std::sync::Arc;

use crate::influence::{Influence, InfluenceTable, Scratch, Toeplitz};
use crate::problem::{OperatorKey, Problem};
use crate::solver::Circulant;

/// The operator of a problem, for its components and on its side of mirror planes, with the coefficients it is made of.
#[derive(Clone)]
pub struct Operator {
    /// Influence coefficients of every offset of the whole grid.
    pub table: Arc<InfluenceTable>,
    /// The operator.
    pub influence: Arc<dyn Influence>,
    /// Circulants near its diagonal blocks, for preconditioning.
    pub circulant: Arc<Circulant>,
}

impl Operator {
    /// out = A p.
    pub fn apply(&self, out: &mut [f64], p: &[f64], scratch: &mut Scratch) {
        self.influence.apply(out, p, scratch);
    }

    /// Memory for applications.
    pub fn scratch(&self) -> Scratch {
        Scratch::new(&*self.influence)
    }
}

/// The last operators used, within a budget of memory.
pub struct Operators {
    kept: Vec<Kept>,
    budget: usize,
}

struct Kept {
    key: OperatorKey,
    operator: Operator,
    bytes: usize,
}

impl Operators {
    /// Keeps operators of up to `budget` bytes in all; the one in use is kept whatever its size.
    pub fn new(budget: usize) -> Self {
        Self { kept: Vec::new(), budget }
    }

    /// The operator of `problem`, kept or made.
    pub fn of(&mut self, problem: &Problem) -> Operator {
        let key = problem.operator_key();
        if let Some(at) = self.kept.iter().position(|kept| kept.key == key) {
            let kept = self.kept.remove(at);
            let operator = kept.operator.clone();
            self.kept.push(kept);
            return operator;
        }
        let (components, mirror) = (problem.components, problem.mirror);
        let has = |kept: &&Kept| kept.key.shares_table(&key) && kept.operator.table.components().includes(components);
        let (table, table_bytes) = match self.kept.iter().find(has) {
            Some(kept) => (Arc::clone(&kept.operator.table), 0),
            None => {
                let table = InfluenceTable::of(problem.whole_grid(), &problem.elasticity, problem.projection, components);
                let bytes = table.bytes();
                (Arc::new(table), bytes)
            }
        };
        let toeplitz = Toeplitz::of(&table, components, mirror);
        let circulant = Circulant::of(&table, components, mirror);
        let bytes = table_bytes + toeplitz.bytes() + circulant.bytes();
        let operator = Operator { table, influence: Arc::new(toeplitz), circulant: Arc::new(circulant) };
        self.kept.push(Kept { key, operator: operator.clone(), bytes });
        let mut total: usize = self.kept.iter().map(|kept| kept.bytes).sum();
        while total > self.budget && self.kept.len() > 1 {
            total -= self.kept.remove(0).bytes;
        }
        operator
    }
}

impl Default for Operators {
    /// A budget of 512 MiB.
    fn default() -> Self {
        Self::new(512 << 20)
    }
}
