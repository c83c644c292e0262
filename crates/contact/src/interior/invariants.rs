//! Principal stresses and the measures that are made of them.

use super::balance::largest;
use crate::model::Stress;

impl Stress {
    /// Makes a stress of its components xx, yy, zz, xy, yz, xz.
    pub(crate) fn from_components([xx, yy, zz, xy, yz, xz]: [f64; 6]) -> Self {
        Self { xx, yy, zz, xy, yz, xz }
    }

    /// Returns its components xx, yy, zz, xy, yz, xz.
    pub fn components(&self) -> [f64; 6] {
        [self.xx, self.yy, self.zz, self.xy, self.yz, self.xz]
    }

    /// Returns the von Mises stress √(3 J₂).
    pub fn von_mises(&self) -> f64 {
        // Squares of very small and very large stresses are no numbers.
        let size = largest(self.components());
        if size == 0.0 || !size.is_finite() {
            return size;
        }
        let [xx, yy, zz, xy, yz, xz] = self.components().map(|part| part / size);
        let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
        size * (0.5 * normal + 3.0 * (xy * xy + yz * yz + xz * xz)).sqrt()
    }

    /// Returns the principal stresses, the largest first, by Jacobi's rotations.
    pub fn principal(&self) -> [f64; 3] {
        let Self { xx, yy, zz, xy, yz, xz } = *self;
        // What all have in common is put aside, so that it costs no digits of the differences.
        let mean = (xx + yy + zz) / 3.0;
        let mut m = [[xx - mean, xy, xz], [xy, yy - mean, yz], [xz, yz, zz - mean]];
        let size = m.iter().flatten().fold(0.0_f64, |most, entry| most.max(entry.abs()));
        for _ in 0..8 {
            if m[0][1].abs().max(m[0][2].abs()).max(m[1][2].abs()) <= 1e-17 * size {
                break;
            }
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                if m[p][q] == 0.0 {
                    continue;
                }
                let theta = 0.5 * (m[q][q] - m[p][p]) / m[p][q];
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                let (s, r) = (t * c, 3 - p - q);
                let shift = t * m[p][q];
                m[p][p] -= shift;
                m[q][q] += shift;
                (m[p][q], m[q][p]) = (0.0, 0.0);
                let (a, b) = (m[r][p], m[r][q]);
                (m[r][p], m[r][q]) = (c * a - s * b, s * a + c * b);
                (m[p][r], m[q][r]) = (m[r][p], m[r][q]);
            }
        }
        let mut values = [m[0][0] + mean, m[1][1] + mean, m[2][2] + mean];
        values.sort_by(|a, b| b.total_cmp(a));
        values
    }

    /// Returns the Tresca stress, the largest difference of principal stresses.
    pub fn tresca(&self) -> f64 {
        let [largest, _, smallest] = self.principal();
        largest - smallest
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn simple_states_have_known_measures() {
        let pulled = Stress { yy: 2.0, ..Stress::default() };
        assert_eq!((pulled.von_mises(), pulled.tresca()), (2.0, 2.0));
        assert_eq!(pulled.principal(), [2.0, 0.0, 0.0]);
        let sheared = Stress { xz: -1.5, ..Stress::default() };
        assert_eq!((sheared.von_mises(), sheared.tresca()), (1.5 * 3.0_f64.sqrt(), 3.0));
        let faint = Stress { yy: 2e-300, ..Stress::default() };
        assert_eq!(faint.von_mises(), 2e-300);
        let strong = Stress { yy: 2e300, ..Stress::default() };
        assert_eq!((strong.von_mises(), strong.tresca()), (2e300, 2e300));
        let unknown = Stress::from_components([f64::NAN; 6]);
        assert!(!unknown.von_mises().is_finite() && !unknown.tresca().is_finite());
        let pressed = Stress { xx: -7.0, yy: -7.0, zz: -7.0, ..Stress::default() };
        assert_eq!((pressed.von_mises(), pressed.tresca()), (0.0, 0.0));
    }

    proptest! {
        /// The principal stresses have the invariants of the stress.
        #[test]
        fn invariants_are_kept(components in proptest::array::uniform6(-3.0..3.0f64)) {
            let stress = Stress::from_components(components);
            let Stress { xx, yy, zz, xy, yz, xz } = stress;
            let [a, b, c] = stress.principal();
            prop_assert!(a >= b && b >= c);
            prop_assert!((a + b + c - xx - yy - zz).abs() < 1e-13);
            let det = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz)
                + xz * (xy * yz - yy * xz);
            prop_assert!((a * b * c - det).abs() < 1e-12);
            let mises = (0.5 * ((a - b).powi(2) + (b - c).powi(2) + (c - a).powi(2))).sqrt();
            prop_assert!((mises - stress.von_mises()).abs() < 1e-13);
            prop_assert!(stress.tresca() >= stress.von_mises() * (1.0 - 1e-14));
        }
    }
}
