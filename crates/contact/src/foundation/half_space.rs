//! The homogeneous isotropic half-space, or two of them pressed together.

use super::coefficient::Coefficient;
use super::kernel;
use crate::model::{Material, Projection};

/// The elasticity of one half-space, or of two summed: it enters the plane of contact through three
/// compliances only. Their unit is 1/shear modulus, \[1/Pa\] in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// The sum Σ (1−ν)/G > 0.
    pub direct: f64,
    /// The sum Σ ν/G ≥ 0.
    pub cross: f64,
    /// The normal–tangential coupling, (1−2ν)/2G of the foundation minus that of the punch; it has
    /// either sign.
    pub coupling: f64,
}

impl HalfSpace {
    /// Sums a foundation and the punch on it; a rigid punch (`None`) adds nothing.
    pub fn new(foundation: &Material, punch: Option<&Material>) -> Self {
        let alone = |material: &Material| {
            let (g, nu) = (material.shear_modulus, material.poisson);
            Self {
                direct: material.compliance(),
                cross: nu / g,
                coupling: (1.0 - 2.0 * nu) / (2.0 * g),
            }
        };
        let below = alone(foundation);
        let above = punch.map_or(Self { direct: 0.0, cross: 0.0, coupling: 0.0 }, alone);
        Self {
            direct: below.direct + above.direct,
            cross: below.cross + above.cross,
            coupling: below.coupling - above.coupling,
        }
    }

    /// Returns the same bodies in another unit of compliance: all compliances times `factor`.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self {
            direct: self.direct * factor,
            cross: self.cross * factor,
            coupling: self.coupling * factor,
        }
    }

    /// Returns the displacement per unit traction for integrals of [`kernel`]'s six functions,
    /// after Boussinesq and Cerruti (K. L. Johnson, Contact Mechanics, 1985, chapter 3). With r² =
    /// x² + y² the kernels are nn: direct/2π · 1/r, xx: 1/2π · (direct/r + cross x²/r³), xy:
    /// cross/2π · xy/r³, nx: coupling/2π · x/r².
    pub(crate) fn coefficient(&self, geometry: &Coefficient) -> Coefficient {
        let [direct, cross, coupling] =
            [self.direct, self.cross, self.coupling].map(|c| c / std::f64::consts::TAU);
        Coefficient {
            nn: direct * geometry.nn,
            xx: direct * geometry.nn + cross * geometry.xx,
            yy: direct * geometry.nn + cross * geometry.yy,
            xy: cross * geometry.xy,
            nx: coupling * geometry.nx,
            ny: coupling * geometry.ny,
        }
    }

    /// Returns the displacement of an element of size hx × hy, `offset` (Δi, Δj) elements away from
    /// the loaded one, receiver minus source, per unit traction; its unit is length × compliance.
    /// Its accuracy is that of `kernel::element`.
    pub fn influence(
        &self,
        offset: [f64; 2],
        hx: f64,
        hy: f64,
        projection: Projection,
    ) -> Coefficient {
        self.coefficient(&kernel::element(offset, hx, hy, projection))
    }

    /// Returns the displacement at the point `receiver` (x, y) under unit traction on the rectangle
    /// |x| ≤ a, |y| ≤ b with the `half_sides` (a, b); its unit is length × compliance.
    #[cfg(test)]
    pub(crate) fn influence_at(&self, receiver: [f64; 2], half_sides: [f64; 2]) -> Coefficient {
        self.coefficient(&kernel::point(receiver, half_sides))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(shear_modulus: f64, poisson: f64) -> Material {
        Material { shear_modulus, poisson }
    }

    #[test]
    fn displacement_at_a_point_meets_the_reference() {
        let reference = include_str!("../../tests/reference/half_space_point_influence.csv");
        let mut rows = 0;
        for line in reference.lines().skip(1) {
            let v: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            let [x, y, a, b, nu, axx, ayy, azz, axy, azx, azy] = v[..] else { panic!("{line}") };
            let got = HalfSpace::new(&material(1.0, nu), None).influence_at([x, y], [a, b]);
            for (got, exact) in [
                (got.xx, axx),
                (got.yy, ayy),
                (got.nn, azz),
                (got.xy, axy),
                (got.nx, azx),
                (got.ny, azy),
            ] {
                assert!((got - exact).abs() <= 1e-13 * exact.abs(), "{got} {exact} {line}");
            }
            rows += 1;
        }
        assert!(rows > 70);
    }

    #[test]
    fn compliances_of_two_bodies_add_and_their_couplings_subtract() {
        let (steel, rubber) = (material(80e9, 0.3), material(1e6, 0.5));
        let alone = HalfSpace::new(&steel, None);
        assert_eq!(alone.coupling, (1.0 - 0.6) / 160e9);
        let pair = HalfSpace::new(&steel, Some(&rubber));
        assert_eq!(pair.direct, 0.7 / 80e9 + 0.5 / 1e6);
        assert_eq!(pair.cross, 0.3 / 80e9 + 0.5 / 1e6);
        assert_eq!(pair.coupling, alone.coupling, "an incompressible body does not couple");
        assert_eq!(HalfSpace::new(&steel, Some(&steel)).coupling, 0.0);
        assert_eq!(HalfSpace::new(&rubber, Some(&steel)).coupling, -alone.coupling);
    }

    #[test]
    fn pressure_pushes_down_and_surface_points_inwards() {
        let block = HalfSpace::new(&material(1.0, 0.25), None)
            .influence([2.0, 1.0], 1.0, 1.0, Projection::Average)
            .block();
        assert!(block[0][0] > 0.0);
        // Pressure at the origin draws a point at x, y > 0 towards it; reciprocity gives the
        // opposite sign to normal displacement under tangential traction.
        assert!(block[1][0] < 0.0 && block[2][0] < 0.0);
        assert_eq!(block[0][1], -block[1][0]);
        assert_eq!(block[1][2], block[2][1]);
    }
}
