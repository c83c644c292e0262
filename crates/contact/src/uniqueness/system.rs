//! The operator εI + A on the elements of Ω.

use faer::Mat;

use super::question::Question;
use crate::grid::Grid;
use crate::influence::{Dense, Entry, Influence, InfluenceTable, Scratch, Toeplitz};
use crate::model::SceneError;
use crate::problem::Problem;
use crate::punch::Surfaces;

/// The operator εI + A on the elements of Ω.
#[derive(Clone, Debug)]
pub struct System {
    table: InfluenceTable,
    toeplitz: Toeplitz,
    epsilon: f64,
}

impl System {
    /// Creates the operator of a question: that of the contact problem of a flat punch with this
    /// sole.
    ///
    /// # Errors
    /// A [`SceneError`] is one of [`Scene::validate`](crate::model::Scene::validate) or
    /// [`Numerics::validate`](crate::model::Numerics::validate), or says that the problem cannot be
    /// made.
    pub fn new(question: &Question) -> Result<Self, SceneError> {
        let (scene, numerics) = question.flat_punch();
        let problem = Problem::new(&scene, &numerics, &Surfaces::default())?;
        let table = InfluenceTable::new(&problem.grid, problem.elasticity, problem.projection);
        let toeplitz = Toeplitz::new(&table);
        Ok(Self { table, toeplitz, epsilon: problem.epsilon })
    }

    /// Returns the grid of the elements, in units of ℓ.
    pub(crate) fn grid(&self) -> &Grid {
        self.table.grid()
    }

    /// Returns the influence coefficients of A, without ε.
    pub(crate) fn table(&self) -> &InfluenceTable {
        &self.table
    }

    /// Returns ε.
    pub(crate) fn epsilon(&self) -> f64 {
        self.epsilon
    }

    /// Returns k, the number of elements of Ω. A field has 3k numbers.
    pub fn elements(&self) -> usize {
        self.grid().active_len()
    }

    /// Returns the largest diagonal entry of εI + A.
    pub fn largest_diagonal(&self) -> f64 {
        self.epsilon + self.table.largest_diagonal()
    }

    /// Says if pressures move any element sideways, to the last bit. If not, μ* = ∞.
    pub fn is_coupled(&self) -> bool {
        let (nx, ny) = (self.grid().nx() as i64, self.grid().ny() as i64);
        let some =
            |entry: Entry, dj: i64| self.table.row(entry, dj).iter().any(|&value| value != 0.0);
        self.elements() > 1
            && nx * ny > 1
            && (1 - ny..ny).any(|dj| some(Entry::Nx, dj) || some(Entry::Ny, dj))
    }

    /// Returns εI + A as a 3k × 3k matrix, which takes 72 k² bytes.
    pub fn matrix(&self) -> Mat<f64> {
        let mut matrix = Dense::new(&self.table).matrix().to_owned();
        for row in 0..matrix.nrows() {
            matrix[(row, row)] += self.epsilon;
        }
        matrix
    }

    /// Allocates the memory for applications.
    pub(crate) fn scratch(&self) -> Scratch {
        Scratch::new(&self.toeplitz)
    }

    /// Computes y = (εI + A) x by FFT.
    ///
    /// # Panics
    /// It panics unless both have 3k numbers.
    pub(crate) fn apply(&self, y: &mut [f64], x: &[f64], scratch: &mut Scratch) {
        let (k, n) = (self.elements(), self.grid().len());
        assert_eq!((y.len(), x.len()), (3 * k, 3 * k), "fields on another grid");
        if k == n {
            self.toeplitz.apply(y, x, scratch);
        } else {
            let (mut from, mut to) = (vec![0.0; 3 * n], vec![0.0; 3 * n]);
            self.onto_grid(&mut from, x);
            self.toeplitz.apply(&mut to, &from, scratch);
            self.off_grid(y, &to);
        }
        for (y, x) in y.iter_mut().zip(x) {
            *y += self.epsilon * x;
        }
    }

    /// Writes a field on Ω into one on the whole grid, whose other elements keep their values.
    pub(super) fn onto_grid(&self, whole: &mut [f64], field: &[f64]) {
        let (k, n) = (self.elements(), self.grid().len());
        for block in 0..3 {
            for (place, e) in self.grid().active().enumerate() {
                whole[block * n + e] = field[block * k + place];
            }
        }
    }

    /// Reverses [`onto_grid`](Self::onto_grid).
    pub(super) fn off_grid(&self, field: &mut [f64], whole: &[f64]) {
        let (k, n) = (self.elements(), self.grid().len());
        for block in 0..3 {
            for (place, e) in self.grid().active().enumerate() {
                field[block * k + place] = whole[block * n + e];
            }
        }
    }
}

/// Returns Σ aᵢbᵢ.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
