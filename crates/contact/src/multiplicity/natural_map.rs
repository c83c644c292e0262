//! The natural map F(p) = p − Gᵘ_μ(p − E(εp + Ap − f)) of a problem with a prescribed motion, and
//! its linearisation, as dense matrices over the elements of Ω.

use faer::{Mat, MatRef};
use primitives::ColumnPivotLu;

use crate::problem::{Problem, g_mu, h_u};

/// The state that an element is taken to have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ElementState {
    /// The element is open: p = 0.
    Open,
    /// The element sticks: w = 0.
    Stick,
    /// The element slips: w₁ = 0 and p_t = μ p₁ n, with n = (x, y).
    Slip([f64; 2]),
}

pub(super) struct NaturalMap<'a> {
    problem: &'a Problem,
    /// The matrix A over the elements of Ω, in blocks n, x, y.
    matrix: MatRef<'a, f64>,
    active: Vec<usize>,
    /// The inverse E⁻¹, which is the largest diagonal entry of A.
    diagonal: f64,
}

/// The largest number of steps of the deflated iteration.
const STEPS: usize = 40;

/// The ratio to the largest pivot below which a pivot is rounding.
const SINGULAR: f64 = 1e-13;

/// The distance from a kink of G, over the largest |x|, that is rounding.
const KINK: f64 = 1e-10;

impl<'a> NaturalMap<'a> {
    pub(super) fn new(problem: &'a Problem, matrix: MatRef<'a, f64>, diagonal: f64) -> Self {
        Self { problem, matrix, active: problem.grid.active().collect(), diagonal }
    }

    fn size(&self) -> usize {
        self.matrix.nrows()
    }

    /// Returns a field on the grid as a column over the elements of Ω.
    fn column(&self, field: &[f64]) -> Mat<f64> {
        let (m, k) = (self.active.len(), self.problem.grid.len());
        Mat::from_fn(self.size(), 1, |row, _| field[row / m * k + self.active[row % m]])
    }

    fn field(&self, column: MatRef<'_, f64>) -> Vec<f64> {
        let (m, k) = (self.active.len(), self.problem.grid.len());
        let mut field = vec![0.0; 3 * k];
        for row in 0..self.size() {
            field[row / m * k + self.active[row % m]] = column[(row, 0)];
        }
        field
    }

    /// Computes x = p − E(εp + Ap − f).
    fn argument(&self, p: MatRef<'_, f64>) -> Mat<f64> {
        let f = self.column(&self.problem.f);
        let displacement = self.matrix * p;
        Mat::from_fn(self.size(), 1, |row, _| {
            p[(row, 0)]
                - (self.problem.epsilon * p[(row, 0)] + displacement[(row, 0)] - f[(row, 0)])
                    / self.diagonal
        })
    }

    /// Computes F(p) and J = I − G′(x)(I − E(εI + A)), where G′ is an element of the generalised
    /// derivative.
    fn linearised(&self, p: MatRef<'_, f64>) -> (Mat<f64>, Mat<f64>) {
        let (m, size) = (self.active.len(), self.size());
        let x = self.argument(p);
        let mut value = p.to_owned();
        let mut jacobian = Mat::<f64>::identity(size, size);
        for a in 0..m {
            let argument = [0, 1, 2].map(|c| x[(c * m + a, 0)]);
            let mapped = g_mu(argument, self.problem.mu, self.problem.ceiling);
            let derivative = self.derivative(argument);
            for c in 0..3 {
                value[(c * m + a, 0)] -= mapped[c];
            }
            if derivative == [[0.0; 3]; 3] {
                continue;
            }
            for column in 0..size {
                let through = [0, 1, 2].map(|c| {
                    let (row, unit) = (c * m + a, if c * m + a == column { 1.0 } else { 0.0 });
                    unit - (self.problem.epsilon * unit + self.matrix[(row, column)])
                        / self.diagonal
                });
                for c in 0..3 {
                    jacobian[(c * m + a, column)] -=
                        (0..3).map(|d| derivative[c][d] * through[d]).sum::<f64>();
                }
            }
        }
        (value, jacobian)
    }

    /// Computes G′ at one element.
    fn derivative(&self, x: [f64; 3]) -> [[f64; 3]; 3] {
        if x[0] <= 0.0 {
            return [[0.0; 3]; 3];
        }
        let normal = if x[0] < self.problem.ceiling { 1.0 } else { 0.0 };
        let bound = self.problem.mu * h_u(x[0], self.problem.ceiling);
        let length = x[1].hypot(x[2]);
        if bound == 0.0 {
            return [[normal, 0.0, 0.0], [0.0; 3], [0.0; 3]];
        }
        if length <= bound {
            return [[normal, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        }
        let n = [x[1] / length, x[2] / length];
        let (along, across) = (self.problem.mu * normal, bound / length);
        [
            [normal, 0.0, 0.0],
            [along * n[0], across * n[1] * n[1], -across * n[0] * n[1]],
            [along * n[1], -across * n[0] * n[1], across * n[0] * n[0]],
        ]
    }

    /// Computes ‖J⁻¹F‖/‖p‖ and sign det J at a solution. They are infinite and 0 if J is singular
    /// to rounding. The sign is also 0 on a kink of F, where J is not unique.
    pub(super) fn error_and_index(&self, p: &[f64]) -> (f64, i64) {
        let p = self.column(p);
        let (value, jacobian) = self.linearised(p.as_ref());
        let factors = ColumnPivotLu::new(&jacobian);
        let sign = sign_of_determinant(&factors);
        if sign == 0 {
            return (f64::INFINITY, 0);
        }
        let (left, size) = (factors.solve(&value).norm_l2(), p.norm_l2());
        (
            if left == 0.0 { 0.0 } else { left / size },
            if self.is_on_kink(p.as_ref()) { 0 } else { sign },
        )
    }

    /// Says if an element is between two states: about to open, to reach the ceiling, or to slip.
    fn is_on_kink(&self, p: MatRef<'_, f64>) -> bool {
        let m = self.active.len();
        let x = self.argument(p);
        let near = KINK * x.norm_max();
        (0..m).any(|a| {
            let x = [0, 1, 2].map(|c| x[(c * m + a, 0)]);
            let bound = self.problem.mu * h_u(x[0], self.problem.ceiling);
            let slides =
                x[0] > 0.0 && self.problem.mu > 0.0 && (x[1].hypot(x[2]) - bound).abs() <= near;
            x[0].abs() <= near || (x[0] - self.problem.ceiling).abs() <= near || slides
        })
    }

    /// Returns the tractions in equilibrium if every element has the state in `pattern` (one entry
    /// per element of the grid). Signs and bounds are left out of account. The tractions are zero
    /// if the equations are singular.
    pub(super) fn equilibrium(&self, pattern: &[ElementState]) -> Vec<f64> {
        let (m, size) = (self.active.len(), self.size());
        let f = self.column(&self.problem.f);
        let epsilon = self.problem.epsilon;
        let unit = |row: usize, column: usize| if row == column { 1.0 } else { 0.0 };
        let elastic =
            |row: usize, column: usize| self.matrix[(row, column)] + epsilon * unit(row, column);
        let piece = |row: usize| pattern[self.active[row % m]];
        let system = Mat::from_fn(size, size, |row, column| match (piece(row), row / m) {
            (ElementState::Open, _) => unit(row, column),
            (ElementState::Stick, _) | (ElementState::Slip(_), 0) => elastic(row, column),
            (ElementState::Slip(n), c) => {
                unit(row, column) - self.problem.mu * n[c - 1] * unit(row % m, column)
            }
        });
        let right = Mat::from_fn(size, 1, |row, _| match (piece(row), row / m) {
            (ElementState::Stick, _) | (ElementState::Slip(_), 0) => f[(row, 0)],
            _ => 0.0,
        });
        let solved = self.field(ColumnPivotLu::new(&system).solve(&right).as_ref());
        if solved.iter().all(|p| p.is_finite()) { solved } else { vec![0.0; solved.len()] }
    }

    /// Runs Newton's method from `start` on M F with M = Π (1/‖p − pᵢ‖² + 1) over the `known`
    /// solutions. Lengths are in units of the largest of these, or of a tenth of the size that f
    /// leads to. It returns the tractions and the number of matrices factored. The step J⁻¹F of F
    /// itself is scaled by 1/(1 − ∇M·J⁻¹F/M) (Sherman–Morrison).
    pub(super) fn deflated<'s>(
        &self,
        start: &[f64],
        known: impl Iterator<Item = &'s [f64]>,
    ) -> (Vec<f64>, u64) {
        let known: Vec<Mat<f64>> = known.map(|p| self.column(p)).collect();
        let reach = self.column(&self.problem.f).norm_l2() / self.diagonal;
        let unit = known.iter().map(|p| p.norm_l2()).fold(0.1 * reach, f64::max);
        let mut p = self.column(start);
        let mut factored = 0;
        for _ in 0..STEPS {
            let (value, jacobian) = self.linearised(p.as_ref());
            if value.norm_l2() <= 1e-8 * p.norm_l2() {
                break;
            }
            let step = ColumnPivotLu::new(&jacobian).solve(&value);
            factored += 1;
            // The slope is ∇ log M · step.
            let mut slope = 0.0;
            for other in &known {
                let away = &p - other;
                let squared = (away.norm_l2() / unit).powi(2);
                let inner =
                    (0..self.size()).map(|row| away[(row, 0)] * step[(row, 0)]).sum::<f64>()
                        / (unit * unit);
                slope -= 2.0 * inner / (squared * (1.0 + squared));
            }
            let scale = 1.0 / (1.0 - slope);
            // Too long a step is of no use, for it leaves the range of tractions that f can cause.
            let longest = 10.0 * unit / step.norm_l2();
            let scale = scale.clamp(-longest, longest);
            if !scale.is_finite() {
                break;
            }
            p = &p - step * faer::Scale(scale);
        }
        (self.field(p.as_ref()), factored)
    }
}

fn sign_of_determinant(factors: &ColumnPivotLu) -> i64 {
    let pivots = factors.pivots();
    let largest = pivots.iter().map(|pivot| pivot.abs()).fold(0.0, f64::max);
    if pivots.iter().any(|pivot| pivot.is_nan() || pivot.abs() <= SINGULAR * largest) {
        return 0;
    }
    let negative = pivots.iter().filter(|pivot| **pivot < 0.0).count();
    // A permutation of n elements in c cycles takes n − c transpositions.
    let forward = factors.permutation();
    let mut seen = vec![false; forward.len()];
    let mut cycles = 0;
    for from in 0..forward.len() {
        if seen[from] {
            continue;
        }
        cycles += 1;
        let mut index = from;
        while !seen[index] {
            seen[index] = true;
            index = forward[index];
        }
    }
    if (negative + forward.len() - cycles).is_multiple_of(2) { 1 } else { -1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::influence::{Dense, InfluenceTable};
    use crate::model::{Mesh, Method, Numerics, PerDof, Projection, sphere_on_half_space};
    use crate::punch::Surfaces;

    #[test]
    fn signs_of_determinants_are_those_of_their_permutations() {
        let sign = |rows: [[f64; 3]; 3]| {
            sign_of_determinant(&ColumnPivotLu::new(&Mat::from_fn(3, 3, |i, j| rows[i][j])))
        };
        assert_eq!(sign([[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 1.0]]), 1);
        assert_eq!(sign([[0.0, 2.0, 0.0], [3.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), -1);
        assert_eq!(sign([[0.0, 2.0, 0.0], [0.0, 0.0, 1.0], [3.0, 0.0, 0.0]]), 1);
        assert_eq!(sign([[0.0, 2.0, 0.0], [0.0, 0.0, 1.0], [-3.0, 0.0, 0.0]]), -1);
        assert_eq!(sign([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 0.0, 1.0]]), 0);
    }

    #[test]
    fn the_jacobian_is_the_derivative_and_a_pattern_that_is_right_gives_the_solution() {
        for ceiling in [None, Some(2e9)] {
            let mut scene = sphere_on_half_space();
            scene.friction.mu = 0.7;
            let numerics = Numerics {
                mesh: Mesh::Exact([3, 4]),
                projection: Projection::Average,
                epsilon: 1e-3,
                ceiling,
                method: Method::Newton,
                tolerance: 1e-8,
                max_iterations: 100,
                simulate: Vec::new(),
            };
            let mut problem = Problem::new(&scene, &numerics, &Surfaces::new()).unwrap();
            problem.place(&PerDof::new([0.05, 0.02, -0.01, 0.0, 0.0, 0.01]));
            let table = InfluenceTable::new(&problem.grid, &problem.elasticity, problem.projection);
            let dense = Dense::new(&table);
            let map = NaturalMap::new(&problem, dense.matrix(), table.largest_diagonal());
            let k = problem.grid.len();
            // The elements are open, sticking, slipping and, under the ceiling, bounded.
            let p: Vec<f64> = (0..3 * k)
                .map(|row| {
                    if row < k {
                        0.03 * ((row * 7) % 5) as f64
                    } else {
                        0.02 * (((row * 5) % 7) as f64 - 3.0)
                    }
                })
                .collect();
            let p = map.column(&p);
            let (value, jacobian) = map.linearised(p.as_ref());
            let change = Mat::from_fn(3 * k, 1, |row, _| 1e-7 * ((row as f64).sin()));
            let (moved, _) = map.linearised((&p + &change).as_ref());
            let predicted = &jacobian * &change;
            assert!((&moved - &value - &predicted).norm_l2() < 1e-5 * predicted.norm_l2());

            let pattern: Vec<ElementState> = (0..k)
                .map(|e| {
                    [ElementState::Open, ElementState::Stick, ElementState::Slip([0.6, 0.8])][e % 3]
                })
                .collect();
            let p = map.equilibrium(&pattern);
            let x = map.argument(map.column(&p).as_ref());
            for e in 0..k {
                // The argument x is p where w = 0.
                match pattern[e] {
                    ElementState::Open => assert_eq!([p[e], p[k + e], p[2 * k + e]], [0.0; 3]),
                    ElementState::Stick => {
                        assert!((0..3).all(|c| (x[(c * k + e, 0)] - p[c * k + e]).abs() < 1e-12))
                    }
                    ElementState::Slip(n) => {
                        assert!((x[(e, 0)] - p[e]).abs() < 1e-12);
                        assert!(
                            (0..2).all(|c| (p[(c + 1) * k + e] - 0.7 * n[c] * p[e]).abs() < 1e-12)
                        );
                    }
                }
            }
        }
    }
}
