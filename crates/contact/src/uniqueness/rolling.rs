//! The uniqueness of the solution where nothing couples pressures and tangential tractions, in
//! rolling too.
//!
//! # What is proved
//! Without coupling, K = 0, the pressures of an increment solve a problem of their own. It is a
//! variational inequality with the symmetric, positive definite A₁₁ on a convex set, and has one
//! solution. With the pressures p₁ known, the tangential tractions lie in the convex set |p_t| ≤
//! μp₁, further narrowed by the forces that are prescribed, and solve
//!
//! ```text
//! (B p_t − f)·(q − p_t) ≥ 0 for every q in the set.
//! ```
//!
//! B is A_tt on an ordinary increment and on a transient one that rolls, and A_tt − A_tt(· + dq) in
//! steady rolling. If two solve it, the difference d of them has d·Bd ≤ 0. So there is exactly one,
//! whatever μ and the loads, if the symmetric part of B is positive definite on the elements in
//! contact. The motions that forces govern do no work on d, and need not be unique: where
//! everything slips, any larger creepage will do.
//!
//! In the average projection d·Bd is an integral over all wave vectors k. In it are the transform
//! d̂ of the field d of constant tractions on elements, and the compliance C(k) of the bodies, a
//! positive definite matrix because the elastic energy is positive:
//!
//! ```text
//! d·A_tt d = ∫ d̂* C d̂ dk,   d·Bd = ∫ d̂* C d̂ (1 − cos k_x dq) dk.
//! ```
//!
//! The second factor vanishes on lines only, and d̂ is analytic, so the integral is positive for
//! every d ≠ 0: on every mesh, for every contact, every dq and every μ. That is [`is_proved`]. It
//! needs no computation, and says nothing for K ≠ 0 with friction, where nothing is proved beyond
//! what [`super`] says of increments that do not roll.
//!
//! In the midpoint projection the integral has d̂* times another function, which need not be
//! positive. Nothing is proved there for every contact, and results in that projection are not
//! called the only ones: their uniqueness is open. [`SymmetricPart`] can show it for a given
//! contact, by a factorisation that no solve makes, since it takes longer than the solve.

use faer::Mat;
use primitives::{cholesky, cholesky_solve};
use rayon::prelude::*;

use crate::foundation::{Coefficient, relative_bodies};
use crate::model::{Fields, Projection, Scene, SceneError, refuse};

/// Returns whether it is proved that the tractions of every increment of a scene's path are the
/// only ones, given those before it.
pub fn is_proved(scene: &Scene, projection: Projection) -> bool {
    let relative = relative_bodies(scene, 1.0);
    let is_uncoupled = relative.layers.is_none() && relative.surface.coupling == 0.0;
    projection == Projection::Average && (is_uncoupled || scene.friction.mu == 0.0)
}

/// The symmetric part of the operator of steady rolling on the tangential tractions of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymmetricPart {
    /// The number of elements in contact.
    pub elements: usize,
    /// A number below its smallest eigenvalue, over `largest`. If it is positive and nothing
    /// couples pressures and tractions, the steady state is unique.
    pub smallest: f64,
    /// A number above its largest eigenvalue, in an arbitrary unit.
    pub largest: f64,
}

impl SymmetricPart {
    /// The largest number of elements in contact. That many take some 0.5 GB.
    pub const MAX_ELEMENTS: usize = 2048;

    /// Bounds the eigenvalues for the elements in contact and a rolled distance dq \[m\]. The time
    /// grows with the cube of their number, and the memory with its square.
    ///
    /// The coefficients are those of the elements, evaluated one by one and not taken from the
    /// operator of a solver. As they are, with their rounding, the bound holds in exact arithmetic:
    /// Cholesky's factor of C is the exact one of a C + E with ‖E‖₂ ≤ 2γ tr C, γ = 4(m + 32)u for a
    /// matrix of size m (see [`super::lower`]), which is taken off. `None` without contact, or if
    /// the symmetric part is not positive definite.
    ///
    /// # Errors
    /// A [`SceneError`] says that more than [`MAX_ELEMENTS`](Self::MAX_ELEMENTS) are in contact.
    pub fn of(
        scene: &Scene,
        projection: Projection,
        fields: &Fields,
        distance: f64,
    ) -> Result<Option<Self>, SceneError> {
        let [nx, ny] = fields.shape.map(|n| n as usize);
        let active: Vec<usize> =
            (0..nx * ny).filter(|element| fields.pressure[*element] > 0.0).collect();
        let elements = active.len();
        if elements > Self::MAX_ELEMENTS {
            let most = Self::MAX_ELEMENTS;
            return Err(refuse(
                "numerics.mesh",
                format!("{elements} elements in contact"),
                &format!("must be coarser: the factorisation is for at most {most} of them"),
            ));
        }
        if elements == 0 {
            return Ok(None);
        }
        let unit = fields.element[0];
        let (height, step) = (fields.element[1] / unit, distance / unit);
        let reach = (nx as f64 + step).hypot(ny as f64 * height);
        let kernels = relative_bodies(scene, unit).kernels(reach);
        let kernel = |di: f64, dj: f64| {
            let Coefficient { xx, xy, yy, .. } =
                kernels.influence([di, dj], 1.0, height, projection);
            [xx, xy, yy]
        };
        // The block of an offset d is A(d) − ½(A(d + dq) + A(d − dq)), since A(−d) = A(d).
        let offsets: Vec<[f64; 3]> = (0..(2 * nx - 1) * ny)
            .into_par_iter()
            .map(|index| {
                let di = (index % (2 * nx - 1)) as f64 - (nx as f64 - 1.0);
                let dj = (index / (2 * nx - 1)) as f64;
                let [here, ahead, behind] =
                    [kernel(di, dj), kernel(di + step, dj), kernel(di - step, dj)];
                std::array::from_fn(|c| here[c] - 0.5 * (ahead[c] + behind[c]))
            })
            .collect();
        let size = 2 * elements;
        let mut matrix = Mat::<f64>::zeros(size, size);
        for (row, &receiver) in active.iter().enumerate() {
            for (column, &source) in active.iter().enumerate() {
                let dj = (receiver / nx) as i64 - (source / nx) as i64;
                let sign = if dj < 0 { -1 } else { 1 };
                let di = sign * ((receiver % nx) as i64 - (source % nx) as i64);
                let place =
                    (di + nx as i64 - 1) as usize + (2 * nx - 1) * dj.unsigned_abs() as usize;
                let [xx, xy, yy] = offsets[place];
                matrix[(row, column)] = xx;
                matrix[(row, elements + column)] = xy;
                matrix[(elements + row, column)] = xy;
                matrix[(elements + row, elements + column)] = yy;
            }
        }
        let largest = (0..size)
            .map(|row| (0..size).map(|column| matrix[(row, column)].abs()).sum::<f64>())
            .fold(0.0, f64::max);
        let rounding = 0.5 * f64::EPSILON * 4.0 * (size as f64 + 32.0) * 2.0;
        let trace: f64 = (0..size).map(|row| matrix[(row, row)]).sum();
        let shifted = |shift: f64| {
            let mut shifted = matrix.clone();
            for row in 0..size {
                shifted[(row, row)] -= shift + rounding * trace;
            }
            cholesky(shifted)
        };
        let Some(factor) = shifted(0.0) else { return Ok(None) };
        let estimate = smallest_by_iteration(&factor, size);
        // The estimate is above the eigenvalue. A part of it is shown.
        let proved =
            [0.99, 0.9, 0.5, 0.0].into_iter().find(|part| shifted(part * estimate).is_some());
        Ok(proved.map(|part| Self { elements, smallest: part * estimate / largest, largest }))
    }
}

/// Returns an estimate from above of the smallest eigenvalue of LLᵀ, by inverse iteration.
fn smallest_by_iteration(factor: &Mat<f64>, size: usize) -> f64 {
    // A start without symmetry has a part along every eigenvector.
    let mut vector = Mat::from_fn(size, 1, |row, _| 1.0 + 0.5 * (row as f64 * 1.7).sin());
    let mut estimate = f64::INFINITY;
    for _ in 0..200 {
        let norm = (0..size).map(|row| vector[(row, 0)].powi(2)).sum::<f64>().sqrt();
        for row in 0..size {
            vector[(row, 0)] /= norm;
        }
        let before = vector.clone();
        cholesky_solve(factor, &mut vector);
        let quotient = (0..size).map(|row| vector[(row, 0)] * before[(row, 0)]).sum::<f64>();
        let next = 1.0 / quotient;
        if (estimate - next).abs() <= 1e-4 * next {
            return next;
        }
        estimate = next;
    }
    estimate
}
