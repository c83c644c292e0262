//! Operators kept between solves: jobs of a sweep that share a grid and elastic ratios share their coefficients.

use std::sync::Arc;

use crate::influence::{InfluenceTable, Toeplitz};
use crate::problem::{OperatorKey, Problem};
use crate::solver::Circulant;

/// The coefficients of a problem and the operator made of them.
#[derive(Clone)]
pub struct Operator {
    /// Influence coefficients of every offset.
    pub table: Arc<InfluenceTable>,
    /// The FFT operator.
    pub toeplitz: Arc<Toeplitz>,
    /// Circulants near its diagonal blocks, for preconditioning.
    pub circulant: Arc<Circulant>,
}

/// The last operators used, within a budget of memory.
pub struct Operators {
    kept: Vec<(OperatorKey, Operator, usize)>,
    budget: usize,
}

impl Operators {
    /// Keeps operators of up to `budget` bytes in all; the one in use is kept whatever its size.
    pub fn new(budget: usize) -> Self {
        Self { kept: Vec::new(), budget }
    }

    /// The operator of `problem`, kept or made.
    pub fn of(&mut self, problem: &Problem) -> Operator {
        let key = problem.operator_key();
        if let Some(at) = self.kept.iter().position(|(kept, ..)| *kept == key) {
            let entry = self.kept.remove(at);
            let operator = entry.1.clone();
            self.kept.push(entry);
            return operator;
        }
        let table = InfluenceTable::new(&problem.grid, &problem.elasticity, problem.projection);
        let toeplitz = Toeplitz::new(&table);
        let circulant = Circulant::new(&table);
        let bytes = table.bytes() + toeplitz.bytes() + circulant.bytes();
        let operator = Operator { table: Arc::new(table), toeplitz: Arc::new(toeplitz), circulant: Arc::new(circulant) };
        self.kept.push((key, operator.clone(), bytes));
        let mut total: usize = self.kept.iter().map(|(.., bytes)| bytes).sum();
        while total > self.budget && self.kept.len() > 1 {
            total -= self.kept.remove(0).2;
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
