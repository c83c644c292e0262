//! Stresses in a half-space under a uniform traction on a rectangle of its surface.
//!
//! All stresses follow from three potentials of the rectangle, with ϱ the distance from a point of
//! it (Boussinesq, Cerruti; K. L. Johnson, Contact Mechanics, 1985, section 3.2):
//!   V = ∫ 1/ϱ, Λ = ∫ ln(ϱ + z), Θ = ∫ (z ln(ϱ + z) − ϱ), with Θ_z = Λ and Λ_z = V.
//! A derivative once along x and once along y is the sum of an elementary function over the four
//! corners; for normal tractions these are the formulas of A. E. H. Love, Phil. Trans. R. Soc. A
//! 228 (1929) 377–420, doi:10.1098/rsta.1929.0009. The explicit factors z of the solutions stay
//! beside the derivatives, so that nothing is lost at depths far below the element's size.
//!
//! The sum over corners loses the square of the distance in digits. Farther away than some element
//! sizes, a Gauss rule integrates the same derivatives of a point load instead.

use crate::common::gauss;

/// The stresses (rows xx, yy, zz, xy, yz, xz; tension is positive) under unit tractions (columns
/// pressure, and traction along x and y of the punch on the foundation).
pub(crate) type StressBlock = [[f64; 3]; 6];

/// The distance in half-widths within which the corners are summed; it costs two digits there.
const NEAR: f64 = 12.0;

/// The ratio of the sides up to which the corners are summed.
const ELONGATED: f64 = 4.0;

/// The distance, relative to the rectangle, within which an edge on the surface counts as reached.
const ON_EDGE: f64 = 1e-12;

/// The derivatives of the potentials that make all stresses; the rest follows, since each potential
/// is harmonic. Those of third order come times z.
#[derive(Clone, Copy, Debug, Default)]
struct PotentialDerivatives {
    v_x: f64,
    v_y: f64,
    v_z: f64,
    l_xx: f64,
    l_xy: f64,
    t_xxy: f64,
    t_xyy: f64,
    zv_xx: f64,
    zv_yy: f64,
    zv_xy: f64,
    zv_xz: f64,
    zv_yz: f64,
    zl_xxy: f64,
    zl_xyy: f64,
}

impl PotentialDerivatives {
    /// Adds `factor` times `other`.
    fn add(&mut self, other: &Self, factor: f64) {
        self.v_x += factor * other.v_x;
        self.v_y += factor * other.v_y;
        self.v_z += factor * other.v_z;
        self.l_xx += factor * other.l_xx;
        self.l_xy += factor * other.l_xy;
        self.t_xxy += factor * other.t_xxy;
        self.t_xyy += factor * other.t_xyy;
        self.zv_xx += factor * other.zv_xx;
        self.zv_yy += factor * other.zv_yy;
        self.zv_xy += factor * other.zv_xy;
        self.zv_xz += factor * other.zv_xz;
        self.zv_yz += factor * other.zv_yz;
        self.zl_xxy += factor * other.zl_xxy;
        self.zl_xyy += factor * other.zl_xyy;
    }

    /// Returns the derivatives of the potentials of a point, at (x, y, z) from it, z ≥ 0.
    fn of_point(x: f64, y: f64, z: f64) -> Self {
        let by_r = 1.0 / (x * x + y * y + z * z).sqrt();
        let by_r2 = by_r * by_r;
        let by_r3 = by_r * by_r2;
        // The first two derivatives of ln(ϱ + z) and of x/(ϱ + z) have these in common.
        let g = 1.0 / (1.0 / by_r + z);
        let g2 = g * g;
        let k = g2 * by_r2 + g * by_r3;
        let m = -(2.0 * g2 * g * by_r3 + 3.0 * g2 * by_r2 * by_r2 + 3.0 * g * by_r3 * by_r2);
        let t = g2 * by_r;
        let t_slope = g2 * by_r2 * (2.0 * g + by_r);
        let third = 3.0 * by_r3 * by_r2;
        Self {
            v_x: -x * by_r3,
            v_y: -y * by_r3,
            v_z: -z * by_r3,
            l_xx: g * by_r - x * x * k,
            l_xy: -x * y * k,
            t_xxy: y * (t - x * x * t_slope),
            t_xyy: x * (t - y * y * t_slope),
            zv_xx: z * (third * x * x - by_r3),
            zv_yy: z * (third * y * y - by_r3),
            zv_xy: z * third * x * y,
            zv_xz: z * third * x * z,
            zv_yz: z * third * y * z,
            zl_xxy: -z * y * (k + x * x * m),
            zl_xyy: -z * x * (k + y * y * m),
        }
    }

    /// Returns the functions at one corner, (x, y, z) from it to the receiver, whose signed sum is
    /// an integral over the rectangle. Lengths are relative to the rectangle's.
    fn of_corner(x: f64, y: f64, z: f64) -> Self {
        let (x2, y2, z2) = (x * x + z * z, y * y + z * z, z * z);
        let r = (x * x + y2).sqrt();
        let sum = r + z;
        // A stress that is infinite on an edge is that beside it.
        let log = |along: f64, across2: f64| {
            let across = across2.sqrt().max(ON_EDGE);
            ((r.max(across) + along.abs()) / across).ln().copysign(along)
        };
        let by_sum = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        let below = (x * x + y * y) * by_sum; // r − z
        let mut out = Self {
            v_x: log(y, x2),
            v_y: log(x, y2),
            v_z: -(x * y).atan2(z * r),
            l_xx: (x * y * below).atan2(x * x * r + z * y * y),
            l_xy: sum.max(ON_EDGE).ln(),
            t_xxy: -x * by_sum,
            t_xyy: -y * by_sum,
            ..Self::default()
        };
        if z2 > 0.0 {
            let z_by_r = z / r;
            out.zv_xx = -x * y * z_by_r / x2;
            out.zv_yy = -x * y * z_by_r / y2;
            out.zv_xy = z_by_r;
            out.zv_xz = -z * y * z_by_r / x2;
            out.zv_yz = -z * x * z_by_r / y2;
            out.zl_xxy = x * by_sum * z_by_r;
            out.zl_xyy = y * by_sum * z_by_r;
        }
        out
    }

    /// Returns the integrals over the rectangle |x| ≤ a, |y| ≤ b.
    fn of_rectangle(receiver: [f64; 2], z: f64, [a, b]: [f64; 2]) -> Self {
        let [x, y] = receiver;
        let gaps = [(x.abs() - a).max(0.0), (y.abs() - b).max(0.0)];
        let mut sum = Self::default();
        let (short, long) = (a.min(b), a.max(b));
        let distance2 = x * x + y * y + z * z;
        if long <= ELONGATED * short && distance2 <= NEAR * NEAR * short * short {
            for (corner_x, sign_x) in [(x + a, 1.0), (x - a, -1.0)] {
                for (corner_y, sign_y) in [(y + b, 1.0), (y - b, -1.0)] {
                    sum.add(&Self::of_corner(corner_x, corner_y, z), sign_x * sign_y);
                }
            }
            return sum;
        }
        let points_x = gauss::points((x * x + gaps[1] * gaps[1] + z * z) / (a * a));
        let points_y = gauss::points((y * y + gaps[0] * gaps[0] + z * z) / (b * b));
        if let (Some(points_x), Some(points_y)) = (points_x, points_y) {
            let rules = gauss::uniform();
            for &(v, weight_y) in &rules[points_y] {
                for &(u, weight_x) in &rules[points_x] {
                    let point = Self::of_point(x - a * u, y - b * v, z);
                    sum.add(&point, 4.0 * a * b * weight_x * weight_y);
                }
            }
            return sum;
        }
        let (halves, offset) =
            if a >= b { ([0.5 * a, b], [0.5 * a, 0.0]) } else { ([a, 0.5 * b], [0.0, 0.5 * b]) };
        for side in [-1.0, 1.0] {
            let from = [x + side * offset[0], y + side * offset[1]];
            sum.add(&Self::of_rectangle(from, z, halves), 1.0);
        }
        sum
    }

    /// Returns the stresses under unit tractions, with Poisson's ratio `nu`.
    fn stresses(&self, nu: f64) -> StressBlock {
        let Self { v_x, v_y, v_z, l_xx, l_xy, t_xxy, t_xyy, .. } = *self;
        let Self { zv_xx, zv_yy, zv_xy, zv_xz, zv_yz, zl_xxy, zl_xyy, .. } = *self;
        let (w, nu2) = (1.0 - 2.0 * nu, 2.0 * nu);
        // What is left of each potential follows from its equation of Laplace.
        let (l_yy, zv_zz) = (-v_z - l_xx, -zv_xx - zv_yy);
        let (zl_xxx, zl_yyy) = (-zl_xyy - zv_xz, -zl_xxy - zv_yz);
        let block = [
            [
                nu2 * v_z - w * l_xx - zv_xx,
                2.0 * v_x - nu2 * t_xyy - zl_xxx,
                nu2 * (v_y + t_xxy) - zl_xxy,
            ],
            [
                nu2 * v_z - w * l_yy - zv_yy,
                nu2 * (v_x + t_xyy) - zl_xyy,
                2.0 * v_y - nu2 * t_xxy - zl_yyy,
            ],
            [v_z - zv_zz, -zv_xz, -zv_yz],
            [-w * l_xy - zv_xy, v_y + nu2 * t_xxy - zl_xxy, v_x + nu2 * t_xyy - zl_xyy],
            [-zv_yz, -zv_xy, v_z - zv_yy],
            [-zv_xz, v_z - zv_xx, -zv_xy],
        ];
        block.map(|row| row.map(|stress| stress / std::f64::consts::TAU))
    }
}

/// Returns the stresses at (x, y, depth), x and y from the middle of a rectangle with these
/// half-sides, under unit tractions on it, in a half-space with Poisson's ratio `nu`.
///
/// They are good to 1e-12 of the largest, at any depth, up to distances of 1e60 half-sides; farther
/// away their powers are no numbers. At depth 0 a stress that jumps
/// on an edge is the mean of both sides, and one that is infinite there is that at a distance of
/// 1e-12 of the longer half-side.
pub(super) fn stresses([x, y]: [f64; 2], depth: f64, [a, b]: [f64; 2], nu: f64) -> StressBlock {
    let unit = a.max(b);
    let z = depth / unit;
    // Products of smaller depths would vanish.
    let z = if z < 1e-100 { 0.0 } else { z };
    PotentialDerivatives::of_rectangle([x / unit, y / unit], z, [a / unit, b / unit]).stresses(nu)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_and_points_agree_where_they_meet() {
        for nu in [0.0, 0.3, 0.5] {
            for [x, y, z] in
                [[9.0, 3.0, 1.0], [0.5, 0.2, 11.0], [7.0, -8.0, 0.01], [-8.0, 0.0, 5.0]]
            {
                let (a, b) = (1.0, 0.9);
                let near = stresses([x, y], z, [a, b], nu);
                // Two hundred strips are elongated, and so far enough for Gauss rules.
                let mut far = [[0.0; 3]; 6];
                for strip in 0..200 {
                    let middle = -a + (2.0 * f64::from(strip) + 1.0) * a / 200.0;
                    let part = stresses([x - middle, y], z, [a / 200.0, b], nu);
                    for (row, part) in far.iter_mut().zip(part) {
                        for (sum, part) in row.iter_mut().zip(part) {
                            *sum += part;
                        }
                    }
                }
                let size = near.iter().flatten().fold(0.0_f64, |most, s| most.max(s.abs()));
                for (near, far) in near.iter().flatten().zip(far.iter().flatten()) {
                    assert!((near - far).abs() < 1e-12 * size, "{nu} {x} {y} {z}: {near} {far}");
                }
            }
        }
    }

    #[test]
    fn the_traction_on_the_surface_is_the_load() {
        for [x, y] in [[0.0, 0.0], [0.99, -0.49], [0.3, 0.2]] {
            let block = stresses([x, y], 0.0, [1.0, 0.5], 0.3);
            for (row, column) in [(2, 0), (5, 1), (4, 2)] {
                for other in 0..3 {
                    let expected = if other == column { -1.0 } else { 0.0 };
                    assert!((block[row][other] - expected).abs() < 1e-15, "{x} {y} {block:?}");
                }
            }
        }
        let outside = stresses([1.01, 0.3], 0.0, [1.0, 0.5], 0.3);
        assert!([2, 4, 5].iter().all(|row| outside[*row].iter().all(|s| s.abs() < 1e-15)));
    }

    /// On an edge a stress that jumps is the mean of both sides, and nothing is infinite.
    #[test]
    fn edges_and_corners_have_finite_values() {
        for [x, y] in [[1.0, 0.0], [0.0, 0.5], [1.0, 0.5], [-1.0, 0.5], [1.0, 3.0]] {
            let block = stresses([x, y], 0.0, [1.0, 0.5], 0.3);
            assert!(block.iter().flatten().all(|stress| stress.is_finite()), "{x} {y} {block:?}");
        }
        let edge = stresses([1.0, 0.0], 0.0, [1.0, 0.5], 0.3);
        assert_eq!((edge[2][0], edge[5][1]), (-0.5, -0.5));
        let corner = stresses([1.0, 0.5], 0.0, [1.0, 0.5], 0.3);
        assert_eq!(corner[2][0], -0.25);
    }
}
