//! An increment as it is shown to who watches a path, and its discrete friction problem.

use rayon::prelude::*;
use thiserror::Error;

use crate::influence::InfluenceTable;
use crate::model::{Fields, StepOutcome};
use crate::problem::Problem;

/// An increment of a path that has just been solved and certified.
pub struct SolvedIncrement<'a> {
    /// The number of the increment along the whole path, counted from 1.
    pub number: u64,
    /// True for a solution, false for a solver's last iterate.
    pub is_certified: bool,
    /// The figures of the increment.
    pub outcome: &'a StepOutcome,
    /// The fields at its end.
    pub fields: &'a Fields,
    pub(super) problem: &'a Problem,
    /// The tractions in the problem's units, three blocks [n | x | y].
    pub(super) tractions: &'a [f64],
}

/// The discrete friction problem of one increment, which consists of forces r and displacements u
/// of n elements.
///
/// The problem is u = W r + q with 0 ≤ u_N ⊥ r_N ≥ 0 and ‖r_T‖ ≤ μ r_N, and with r_T =
/// −μ r_N u_T / ‖u_T‖ where there is slip. Vectors have 3n entries, (N, x, y) of each element after
/// the other. r_N is positive in compression and (r_x, r_y) is the force of the punch on the
/// foundation \[N\]; u_N is the gap, and (u_x, u_y) the slip of the foundation's surface
/// relative to the punch since the increment before \[m\].
///
/// W = (A + ε) / |e| with the area |e| of an element, and q = −f, which are the gap and the slip
/// that there would be without any force, at the motion of the punch that the solution has. It is
/// the local problem of FCLIB (Acary, Brémond and Huber 2018,
/// <https://github.com/FrictionalContactLibrary>).
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionProblem {
    /// The elements of Ω that the punch has a sole above, as indices of the [`Fields`], ascending.
    pub elements: Vec<usize>,
    /// The compliances W, row by row \[m/N\].
    pub compliance: Vec<f64>,
    /// The displacements q without force \[m\].
    pub free: Vec<f64>,
    /// The friction coefficient μ \[1\].
    pub mu: f64,
    /// The forces r of the solution \[N\].
    pub forces: Vec<f64>,
    /// The displacements u = W r + q of the solution \[m\].
    pub displacements: Vec<f64>,
}

/// A reason why an increment has no discrete friction problem to hand out.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FrictionProblemError {
    /// The matrix is too large.
    #[error(
        "the matrix of {elements} elements has ({rows})² entries, {have} GiB, and at most {most} \
         GiB are written; a mesh of {fits} × {fits} fits"
    )]
    TooLarge {
        /// The number of elements.
        elements: usize,
        /// The number of rows.
        rows: usize,
        /// The size of the matrix \[GiB\], rounded up.
        have: usize,
        /// The size up to which it is made \[GiB\].
        most: usize,
        /// The number of elements along each side of a square mesh that can be made.
        fits: usize,
    },
    /// The law of the increment is not Coulomb's alone.
    #[error(
        "the ceiling on the pressure is active at {elements} elements, and a problem of friction \
         knows none; raise `ceiling`, or leave it out"
    )]
    Ceiling {
        /// The number of elements at the ceiling.
        elements: u64,
    },
    /// The compliances of the increment are not those of the bodies alone.
    #[error(
        "increment {number} rolls steadily: its slip depends on what lies ahead, for which a \
         problem of friction has no compliances"
    )]
    Steady {
        /// The number of the increment.
        number: u64,
    },
    /// The increment has no solution.
    #[error("increment {number} is not certified, so that there is no solution to write")]
    Uncertified {
        /// The number of the increment.
        number: u64,
    },
}

impl FrictionProblem {
    /// The size up to which a matrix is made \[GiB\].
    pub const MOST_GIB: usize = 4;

    /// Refuses a matrix that is too large, over `elements` of the `len` elements of a grid.
    fn check_size(elements: usize, len: usize) -> Result<(), FrictionProblemError> {
        let rows = 3 * elements;
        let most_rows = ((Self::MOST_GIB << 30) / size_of::<f64>()).isqrt();
        if rows <= most_rows {
            return Ok(());
        }
        let bytes = (rows as f64).powi(2) * size_of::<f64>() as f64;
        // The sole takes the same share of every mesh, but for its edge.
        let share = elements as f64 / len as f64;
        Err(FrictionProblemError::TooLarge {
            elements,
            rows,
            have: (bytes / f64::from(1 << 30)).ceil() as usize,
            most: Self::MOST_GIB,
            fits: ((most_rows / 3) as f64 / share).sqrt() as usize,
        })
    }
}

impl SolvedIncrement<'_> {
    /// Returns the discrete friction problem of this increment with its solution. All components
    /// are in it, whatever effects were left out on the way to the solution.
    ///
    /// # Errors
    /// [`FrictionProblemError`], if the increment is no solution of such a problem, or if the
    /// matrix would take more than 4 GiB.
    pub fn friction_problem(&self) -> Result<FrictionProblem, FrictionProblemError> {
        let Self { problem, tractions, .. } = *self;
        if !self.is_certified {
            return Err(FrictionProblemError::Uncertified { number: self.number });
        }
        if problem.steady.is_some() {
            return Err(FrictionProblemError::Steady { number: self.number });
        }
        let capped = self.outcome.observables.ceiling_elements;
        if capped > 0 {
            return Err(FrictionProblemError::Ceiling { elements: capped });
        }
        let grid = &problem.grid;
        FrictionProblem::check_size(grid.active_len(), grid.len())?;
        let elements: Vec<usize> = grid.active().collect();
        let (k, rows) = (grid.len(), 3 * elements.len());
        let length = problem.scale.length;
        let force = problem.scale.traction() * grid.element_area() * length * length;
        let interleaved = |field: &[f64], unit: f64| -> Vec<f64> {
            elements.iter().flat_map(|&e| [0, 1, 2].map(|c| field[c * k + e] * unit)).collect()
        };
        let free = interleaved(&problem.f, -length);
        let forces = interleaved(tractions, force);
        let table = InfluenceTable::new(grid, problem.elasticity.clone(), problem.projection);
        let unit = length / force;
        let mut compliance = vec![0.0; rows * rows];
        compliance.par_chunks_exact_mut(3 * rows).zip(&elements).for_each(|(band, &receiver)| {
            let (ri, rj) = grid.position(receiver);
            for (column, &source) in elements.iter().enumerate() {
                let (si, sj) = grid.position(source);
                let mut block =
                    table.coefficient(ri as i64 - si as i64, rj as i64 - sj as i64).block();
                if source == receiver {
                    (0..3).for_each(|c| block[c][c] += problem.epsilon);
                }
                for (c, row) in band.chunks_exact_mut(rows).enumerate() {
                    for (d, entry) in row[3 * column..][..3].iter_mut().enumerate() {
                        *entry = block[c][d] * unit;
                    }
                }
            }
        });
        let product = |(row, free): (&[f64], &f64)| {
            free + row.iter().zip(&forces).map(|(entry, force)| entry * force).sum::<f64>()
        };
        let displacements =
            compliance.par_chunks_exact(rows.max(1)).zip(&free).map(product).collect();
        Ok(FrictionProblem { elements, compliance, free, mu: problem.mu, forces, displacements })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_that_is_too_large_names_a_mesh_that_fits() {
        assert_eq!(FrictionProblem::check_size(87 * 87, 87 * 87), Ok(()));
        let error = FrictionProblem::check_size(128 * 128, 128 * 128).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the matrix of 16384 elements has (49152)² entries, 18 GiB, and at most 4 GiB are \
             written; a mesh of 87 × 87 fits"
        );
        let half = FrictionProblem::check_size(64 * 128, 128 * 128).unwrap_err();
        assert!(half.to_string().ends_with("a mesh of 124 × 124 fits"), "{half}");
    }
}
