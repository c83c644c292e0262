//! Forces of rolling from creepages by theory: linear, and saturating by formulas.

use super::kalker::KalkerCoefficients;

/// The forces and the moment of a rolling contact on the foundation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CreepForces {
    /// The force along x, the way of rolling \[N\].
    pub force_x: f64,
    /// The force along y \[N\].
    pub force_y: f64,
    /// The moment about z \[N m\].
    pub moment_z: f64,
}

/// Kalker's linear theory of an elliptic contact in which nothing slips, without coupling of
/// pressure and traction. With c = √(ab) and a contact that travels towards +x
///
/// ```text
/// force_x = −Gc² C₁₁ ξ, force_y = −Gc² C₂₂ η − Gc³ C₂₃ φ, moment_z = Gc³ C₂₃ η − Gc⁴ C₃₃ φ.
/// ```
///
/// Creepages and spin are those of the foundation against the punch, over the rolling speed, at the
/// middle of the contact. Towards −x it is the mirror image, in which C₂₃ has the other sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearCreep {
    coefficients: KalkerCoefficients,
    /// The combined modulus G, 2/Σ(1/G) \[Pa\].
    modulus: f64,
    /// The mean semi-axis c \[m\].
    size: f64,
    /// The sign of the way along x.
    direction: f64,
}

impl LinearCreep {
    /// Makes the theory of an ellipse with these semi-axes along x and y \[m\] for the combined G =
    /// 2/Σ(1/G) \[Pa\] and ν = ½ G Σ(ν/G), which travels towards +x, or −x if `backward`. It is
    /// `None` where there are no [coefficients](KalkerCoefficients::new).
    pub fn new(semi_axes: [f64; 2], modulus: f64, poisson: f64, backward: bool) -> Option<Self> {
        let [a, b] = semi_axes;
        let coefficients = KalkerCoefficients::new(a / b, poisson)?;
        let direction = if backward { -1.0 } else { 1.0 };
        Some(Self { coefficients, modulus, size: (a * b).sqrt(), direction })
    }

    /// Returns the forces of the creepages ξ and η \[1\] and the spin φ \[rad/m\].
    pub fn forces(&self, creepage: [f64; 2], spin: f64) -> CreepForces {
        let KalkerCoefficients { c11, c22, c23, c33 } = self.coefficients;
        let square = self.modulus * self.size * self.size;
        let turning = self.direction * self.size * c23;
        CreepForces {
            force_x: 0.0 - square * c11 * creepage[0],
            force_y: 0.0 - square * (c22 * creepage[1] + turning * spin),
            moment_z: square * (turning * creepage[1] - self.size * self.size * c33 * spin),
        }
    }

    /// Returns the creepages that make these forces along x and y, beside the spin φ.
    pub fn creepages(&self, force: [f64; 2], spin: f64) -> [f64; 2] {
        let KalkerCoefficients { c11, c22, c23, .. } = self.coefficients;
        let square = self.modulus * self.size * self.size;
        let of_spin = self.direction * self.size * c23 * spin;
        [0.0 - force[0] / (square * c11), 0.0 - (force[1] / square + of_spin) / c22]
    }
}

/// Returns a force of the linear theory as friction lets it grow, by the law of Vermeulen and
/// Johnson: in its direction, with F = μP (1 − (1 − u/3)³) for u = |F linear|/μP ≤ 3, and μP above.
///
/// Without spin these are the forces of P. J. Vermeulen and K. L. Johnson, J. Appl. Mech. 31 (1964)
/// 338–340, doi:10.1115/1.3629610, with Kalker's coefficients. With the spin in the linear theory
/// they are those of Z. Y. Shen, J. K. Hedrick and J. A. Elkins, Vehicle System Dynamics 12 (1983)
/// 79–83, doi:10.1080/00423118308968725.
pub fn saturated(linear: [f64; 2], limit: f64) -> [f64; 2] {
    let size = linear[0].hypot(linear[1]);
    let u = size / limit;
    // For u ↓ 0 the factor is 1, and a limit of 0 leaves nothing.
    let factor = if u > 3.0 { limit / size } else { 1.0 - u / 3.0 + u * u / 27.0 };
    if limit > 0.0 { linear.map(|force| force * factor) } else { [0.0; 2] }
}

/// Returns the force of the linear theory of which friction leaves this one, the inverse of
/// [`saturated`]; `None` from |F| = μP on.
pub fn unsaturated(force: [f64; 2], limit: f64) -> Option<[f64; 2]> {
    let part = force[0].hypot(force[1]) / limit;
    if part == 0.0 {
        return Some(force);
    }
    // This is 3(1 − root), without its cancellation for small forces.
    let root = (1.0 - part).cbrt();
    let u = 3.0 * part / (1.0 + root + root * root);
    (part < 1.0).then(|| force.map(|component| component * u / part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_and_creepages_are_inverse() {
        for backward in [false, true] {
            let theory = LinearCreep::new([2.0, 1.0], 3.0, 0.25, backward).unwrap();
            let creepage = [1e-3, -2e-3];
            let forces = theory.forces(creepage, 4e-4);
            let back = theory.creepages([forces.force_x, forces.force_y], 4e-4);
            for (back, creepage) in back.into_iter().zip(creepage) {
                assert!((back / creepage - 1.0).abs() < 1e-14);
            }
        }
    }

    /// Seen in a mirror across x, the contact rolls the other way with −ξ and −φ.
    #[test]
    fn backward_is_the_mirror_image() {
        let [forward, backward] =
            [false, true].map(|back| LinearCreep::new([2.0, 1.0], 3.0, 0.25, back).unwrap());
        let (one, other) =
            (forward.forces([1e-3, 2e-3], 3e-3), backward.forces([-1e-3, 2e-3], -3e-3));
        assert_eq!(one.force_x, -other.force_x);
        assert_eq!(one.force_y, other.force_y);
        assert_eq!(one.moment_z, -other.moment_z);
    }

    #[test]
    fn saturation_has_its_inverse_and_its_end() {
        for part in [1e-12, 0.3, 0.9, 0.999] {
            let force = [0.6 * part * 2.0, -0.8 * part * 2.0];
            let back = saturated(unsaturated(force, 2.0).unwrap(), 2.0);
            for (back, force) in back.into_iter().zip(force) {
                assert!((back / force - 1.0).abs() < 1e-12, "{part}");
            }
        }
        assert_eq!(unsaturated([2.0, 0.0], 2.0), None);
        let end = saturated([-6.0, 8.0], 2.0);
        assert!((end[0] + 1.2).abs() < 1e-15 && (end[1] - 1.6).abs() < 1e-15, "{end:?}");
        assert_eq!(saturated([1.0, 0.0], 0.0), [0.0; 2]);
        // At three times the limit it has come to its end.
        assert!((saturated([6.0, 0.0], 2.0)[0] - 2.0).abs() < 1e-15);
        assert_eq!(saturated([0.0; 2], 2.0), [0.0; 2]);
    }
}
