//! A witness against uniqueness: an x with F(x) ≤ μ, and the operator B in 𝔅_μ that belongs to it.
//!
//! With z = x − Ey, element by element: c₁ = x₁/z₁; d is the point nearest to x_t of the disk with
//! diameter \[0, z_t\]; it is c₂ t (t·z_t) with t along d and c₂ = |d|²/d·z_t; (a, b) = (x_t −
//! d)/x₁; c₃ = 0. If rounding takes c₁ or c₂ out of \[0, 1\] or √(a² + b²) above μ, the excess is
//! cut off. So B is in 𝔅_μ exactly, and the rounding shows in B(I − EA)x − x.

use faer::Mat;
use serde::{Deserialize, Serialize};

use super::system::System;

/// A field x that shows μ* ≤ μ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Witness {
    /// The friction μ ≥ F(x). It does not belong to US(A), nor does anything above it.
    pub mu: f64,
    /// The stiffness E of the operator B that is made of x, in units of 1/cℓ. For every other E > 0
    /// there is a B in 𝔅_μ for x too.
    pub stiffness: f64,
    /// The field x: blocks n | x | y over the elements of Ω, of any length.
    pub x: Vec<f64>,
}

/// The operator B at one element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// The eigenvalues 0 ≤ c₁, c₂, c₃ ≤ 1.
    pub c: [f64; 3],
    /// The ratios b₂₁/c₁ and b₃₁/c₁.
    pub ab: [f64; 2],
    /// The angle of the eigenvector to c₂ \[rad\].
    pub phi: f64,
}

impl Local {
    /// Returns the 3×3 matrix b, row by row.
    pub(crate) fn block(&self) -> [[f64; 3]; 3] {
        let ([c1, c2, c3], [a, b], (sin, cos)) = (self.c, self.ab, self.phi.sin_cos());
        let cross = (c2 - c3) * sin * cos;
        [
            [c1, 0.0, 0.0],
            [c1 * a, c2 * cos * cos + c3 * sin * sin, cross],
            [c1 * b, cross, c2 * sin * sin + c3 * cos * cos],
        ]
    }

    /// Returns B z.
    pub(crate) fn apply(&self, z: [f64; 3]) -> [f64; 3] {
        self.block().map(|row| row[0] * z[0] + row[1] * z[1] + row[2] * z[2])
    }

    /// Creates the operator with x = B(x − Ey) for one element and the least √(a² + b²).
    fn of(x: [f64; 3], y: [f64; 3], stiffness: f64) -> Self {
        let z = [0, 1, 2].map(|c| x[c] - stiffness * y[c]);
        let c1 = if x[0] == 0.0 { 0.0 } else { (x[0] / z[0]).clamp(0.0, 1.0) };
        let center = [0.5 * z[1], 0.5 * z[2]];
        // The radius is a few roundings smaller: near the ends of the disk d·z_t ≥ |d|² would not
        // survive a rounding outwards.
        let radius = 0.5 * z[1].hypot(z[2]) * (1.0 - 64.0 * f64::EPSILON);
        let from = [x[1] - center[0], x[2] - center[1]];
        let distance = from[0].hypot(from[1]);
        let nearest = if distance <= radius {
            [x[1], x[2]]
        } else {
            [0, 1].map(|c| center[c] + radius * from[c] / distance)
        };
        let size = nearest[0] * nearest[0] + nearest[1] * nearest[1];
        let c2 = if size == 0.0 {
            0.0
        } else {
            (size / (nearest[0] * z[1] + nearest[1] * z[2])).clamp(0.0, 1.0)
        };
        let ab = if distance <= radius || x[0] == 0.0 {
            [0.0; 2]
        } else {
            [0, 1].map(|c| (x[c + 1] - nearest[c]) / x[0])
        };
        Self {
            c: [c1, if c2.is_nan() { 0.0 } else { c2 }, 0.0],
            ab,
            phi: nearest[1].atan2(nearest[0]),
        }
    }
}

/// The figures that the check of a witness has shown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shown {
    /// The least μ that x is a witness for, F(x).
    pub least_mu: f64,
    /// The largest √(a² + b²) in B. It is below F(x), which it tends to with E.
    pub operator_mu: f64,
    /// The residual ‖B(I − EA)x − x‖ / ‖x‖, an upper bound of the smallest singular value.
    pub residual: f64,
    /// The smallest singular value of B(I − EA) − I itself, for few elements ([`Witness::DENSE`]).
    pub singular_value: Option<f64>,
    /// A lower bound of the norm of B(I − EA) − I, to which the two have to be compared. It is the
    /// norm itself for few elements.
    pub norm: f64,
}

/// The reason why a field shows nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WitnessError {
    /// The numbers are no field on Ω.
    #[error(
        "a field of {found} numbers for {elements} elements: there must be 3 finite ones per element, not all of them 0"
    )]
    Field {
        /// The count of numbers given.
        found: usize,
        /// The number of elements of Ω.
        elements: usize,
    },
    /// E or μ makes no sense.
    #[error("{name} = {value}: must be a finite number above 0")]
    Number {
        /// The name of the number.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// E is too large for the residual to show anything.
    #[error(
        "the stiffness times the operator's largest diagonal entry is {product:e}: must be at most {most:e}, or rounding hides all"
    )]
    Stiff {
        /// The product of E and the largest diagonal entry of A.
        product: f64,
        /// The largest product that is allowed.
        most: f64,
    },
    /// A normal condition fails.
    #[error("element {element} has x₁y₁ = {product:e}: must not be positive")]
    Normal {
        /// The index among the elements of Ω.
        element: usize,
        /// The product x₁y₁.
        product: f64,
    },
    /// A tangential condition fails.
    #[error("element {element} needs μ = {needed}: must be at most the witness's {mu}")]
    Tangential {
        /// The index among the elements of Ω.
        element: usize,
        /// The μ that the element needs, x_t·y_t/(|x₁||y_t|).
        needed: f64,
        /// The μ of the witness.
        mu: f64,
    },
    /// B(I − EA)x is not x.
    #[error(
        "‖B(I − EA)x − x‖/‖x‖ = {residual:e} where the operator's norm is {norm:e}: must vanish to rounding"
    )]
    Residual {
        /// The residual.
        residual: f64,
        /// A lower bound of the operator's norm.
        norm: f64,
    },
}

/// Returns the three components (n, x, y) at an element.
fn components(field: &[f64], element: usize) -> [f64; 3] {
    let k = field.len() / 3;
    [0, 1, 2].map(|c| field[c * k + element])
}

/// Returns x_t·y_t/(|x₁||y_t|) where x_t·y_t > 0, and 0 elsewhere. No product in it underflows,
/// whatever the sizes.
fn needed(x: [f64; 3], y: [f64; 3]) -> f64 {
    let [large_x, large_y] = [x, y].map(|v| v[1].abs().max(v[2].abs()));
    if large_x == 0.0 || large_y == 0.0 {
        return 0.0;
    }
    let (x_t, y_t) = ([x[1] / large_x, x[2] / large_x], [y[1] / large_y, y[2] / large_y]);
    let work = x_t[0] * y_t[0] + x_t[1] * y_t[1];
    if work <= 0.0 { 0.0 } else { work / y_t[0].hypot(y_t[1]) * (large_x / x[0].abs()) }
}

/// Returns F(x).
///
/// # Errors
/// The first condition that fails whatever μ is.
pub(super) fn least_mu(x: &[f64], y: &[f64]) -> Result<f64, WitnessError> {
    let mut least: f64 = 0.0;
    for element in 0..x.len() / 3 {
        let (x, y) = (components(x, element), components(y, element));
        let product = x[0] * y[0];
        // The signs decide, for a product of small numbers is 0.
        let is_positive = (x[0] > 0.0 && y[0] > 0.0) || (x[0] < 0.0 && y[0] < 0.0);
        if is_positive || product.is_nan() {
            return Err(WitnessError::Normal { element, product });
        }
        let needed = needed(x, y);
        if !needed.is_finite() {
            return Err(WitnessError::Tangential { element, needed, mu: f64::INFINITY });
        }
        least = least.max(needed);
    }
    Ok(least)
}

impl Witness {
    /// The largest number of elements for which [`verify`](Self::verify) computes all singular
    /// values.
    pub const DENSE: usize = 100;

    /// The largest value that E times the largest diagonal entry of A may have.
    const MOST_STIFF: f64 = 1e6;

    /// The largest residual over the operator's norm that counts as rounding.
    const ROUNDING: f64 = 1e-11;

    /// Returns B, element by element of Ω, in 𝔅_μ.
    ///
    /// # Panics
    /// It panics unless x has 3 numbers per element of the system.
    pub fn operator(&self, system: &System) -> Vec<Local> {
        let mut y = vec![0.0; self.x.len()];
        system.apply(&mut y, &self.x, &mut system.scratch());
        self.operator_at(&self.x, &y)
    }

    /// Returns B from x, of any length, and y = Ax.
    fn operator_at(&self, x: &[f64], y: &[f64]) -> Vec<Local> {
        (0..x.len() / 3)
            .map(|element| {
                let (x, y) = (components(x, element), components(y, element));
                let mut local = Local::of(x, y, self.stiffness);
                let size = local.ab[0].hypot(local.ab[1]);
                if size > self.mu {
                    // The next number down is taken, for the rounded length must not be above μ
                    // either.
                    local.ab = local.ab.map(|c| c * (self.mu / size) * (1.0 - f64::EPSILON));
                }
                local
            })
            .collect()
    }

    /// Shows that μ does not belong to US(A): F(x) ≤ μ, for which there is a B in 𝔅_μ for every E,
    /// and the B for this E leaves x where it is.
    ///
    /// # Errors
    /// A [`WitnessError`] says that the numbers have no meaning, that a condition fails at an
    /// element, or that the residual is not rounding.
    pub fn verify(&self, system: &System) -> Result<Shown, WitnessError> {
        let k = system.elements();
        if self.x.len() != 3 * k
            || !self.x.iter().all(|x| x.is_finite())
            || self.x.iter().all(|&x| x == 0.0)
        {
            return Err(WitnessError::Field { found: self.x.len(), elements: k });
        }
        for (name, value) in [("stiffness", self.stiffness), ("mu", self.mu)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(WitnessError::Number { name, value });
            }
        }
        let (product, most) = (self.stiffness * system.largest_diagonal(), Self::MOST_STIFF);
        if product > most {
            return Err(WitnessError::Stiff { product, most });
        }
        // The field is scaled, so that no length of x makes its squares vanish or overflow.
        let largest = self.x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let field: Vec<f64> = self.x.iter().map(|x| x / largest).collect();
        let mut y = vec![0.0; 3 * k];
        system.apply(&mut y, &field, &mut system.scratch());
        let least_mu = least_mu(&field, &y)?;
        for element in 0..k {
            let needed = needed(components(&field, element), components(&y, element));
            if needed > self.mu {
                return Err(WitnessError::Tangential { element, needed, mu: self.mu });
            }
        }
        let operator = self.operator_at(&field, &y);
        let (mut defect, mut size, mut moved) = (0.0, 0.0, 0.0);
        for (element, local) in operator.iter().enumerate() {
            let (x, y) = (components(&field, element), components(&y, element));
            let mapped = local.apply([0, 1, 2].map(|c| x[c] - self.stiffness * y[c]));
            for c in 0..3 {
                defect += (mapped[c] - x[c]).powi(2);
                size += x[c] * x[c];
                moved += (self.stiffness * y[c]).powi(2);
            }
        }
        let residual = (defect / size).sqrt();
        let operator_mu =
            operator.iter().map(|local| local.ab[0].hypot(local.ab[1])).fold(0.0, f64::max);
        let dense = (k <= Self::DENSE)
            .then(|| singular_values(system, &operator, self.stiffness))
            .flatten();
        let norm = dense.as_ref().map_or(1f64.max((moved / size).sqrt()), |values| values.largest);
        let smallest = dense.map(|values| values.smallest);
        let shown = Shown { least_mu, operator_mu, residual, singular_value: smallest, norm };
        // The smallest singular value is at most the residual. A larger one is a failure of one of
        // the two computations.
        let is_finite = [least_mu, operator_mu, residual, norm, smallest.unwrap_or(0.0)]
            .iter()
            .all(|figure| figure.is_finite());
        let vanishes = is_finite && residual.max(smallest.unwrap_or(0.0)) <= Self::ROUNDING * norm;
        if vanishes { Ok(shown) } else { Err(WitnessError::Residual { residual, norm }) }
    }
}

/// The ends of the range of a matrix's singular values.
struct SingularValues {
    /// The smallest one.
    smallest: f64,
    /// The largest one.
    largest: f64,
}

/// Computes the smallest and the largest singular value of B(I − EA) − I, or `None` if the
/// decomposition fails.
fn singular_values(system: &System, operator: &[Local], stiffness: f64) -> Option<SingularValues> {
    let k = operator.len();
    let a = system.matrix();
    let inner =
        Mat::from_fn(3 * k, 3 * k, |i, j| f64::from(u8::from(i == j)) - stiffness * a[(i, j)]);
    let blocks: Vec<[[f64; 3]; 3]> = operator.iter().map(Local::block).collect();
    let matrix = Mat::from_fn(3 * k, 3 * k, |i, j| {
        let row = blocks[i % k][i / k];
        (0..3).map(|c| row[c] * inner[(c * k + i % k, j)]).sum::<f64>()
            - f64::from(u8::from(i == j))
    });
    let values = primitives::singular_values(&matrix)?;
    Some(SingularValues { smallest: values[3 * k - 1], largest: values[0] })
}
