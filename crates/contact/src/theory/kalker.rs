//! The coefficients of the linear theory of rolling: the forces of an elliptic contact that rolls
//! so little off its course that nothing slips.
//!
//! # Method
//! The displacements are known where nothing slips, up to those at the leading edge: with the
//! coordinates X = x/a, Y = y/b they are u_x = (ξ − φy)x + k_x(y), u_y = (η + φx/2)x + k_y(y),
//! where k is such that the tractions are 0 at the leading edge X = √(1 − Y²), and only there
//! (J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990,
//! doi:10.1007/978-94-015-7889-9).
//!
//! The tractions are sought as t/√(1 − X² − Y²) with polynomials t. On the unit sphere above the
//! ellipse a polynomial is a sum of spherical harmonics that are even in Z. For the direction ν in
//! the plane the integral of H/√(1 − X² − Y²), with H a harmonic of degree n, along the chord at
//! the distance h from the middle is π P_n(h) H(ν), half the integral over a circle on the sphere.
//! A displacement is an integral over the directions of the chords through its point, so that by
//! the addition theorem of P_n a harmonic of degree n makes one of degree n, by a small matrix:
//!
//! ```text
//! u = (4π ab/(2n+1)) Σ_m H_m(X, Y) ∫₀^π H_m(ν) K(ν) H(ν) / (G D(ν)) dα,
//! ν = (sin α, cos α), D² = a² cos² α + b² sin² α,
//! ```
//!
//! where K = (1 − ν) + ν d dᵀ for the direction d = (a cos α, −b sin α)/D of the chord. With the
//! polar axis along Y the harmonics of order 0 are the functions of Y, so the unknown k are their
//! coefficients, and all others are given. Gauss points on the leading edge hold as many equations.
//!
//! The error falls like N⁻⁴ with the degree N, since the tractions are singular where the leading
//! edge meets the trailing one. Two degrees give the limit.

use std::cell::Cell;
use std::f64::consts::PI;

use faer::Mat;
use primitives::{ColumnPivotLu, cholesky, cholesky_solve};

/// The largest ratio of the semi-axes for which there are coefficients.
const LONGEST: f64 = 1e3;
/// The degrees of which the limit is made.
const DEGREES: [usize; 2] = [16, 24];
/// The shift of the degree with which the error is closest to its fourth power.
const SHIFT: f64 = 1.0;

/// Kalker's creepage and spin coefficients of an elliptic contact \[1\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KalkerCoefficients {
    /// The longitudinal force for the longitudinal creepage, C₁₁.
    pub c11: f64,
    /// The lateral force for the lateral creepage, C₂₂.
    pub c22: f64,
    /// The lateral force for the spin, and the moment for the lateral creepage, C₂₃.
    pub c23: f64,
    /// The moment for the spin, C₃₃.
    pub c33: f64,
}

impl KalkerCoefficients {
    /// Returns the coefficients of an ellipse whose semi-axis along the rolling direction is
    /// `ratio` = a/b times that across, for bodies with this combined ν. It is `None` outside
    /// 10⁻³ ≤ a/b ≤ 10³ and 0 ≤ ν ≤ ½.
    ///
    /// The relative errors, against degrees of 64 and 96, are below 3e-6 for ½ ≤ a/b ≤ 10, below
    /// 6e-5 at a/b = 0.1, 8e-4 at 0.01, and 3e-3 down to 0.001, where ν = ½ is the worst; C₂₃ is
    /// 4/3 for the circle with ν = 0.
    pub fn new(ratio: f64, poisson: f64) -> Option<Self> {
        let in_range = (1.0 / LONGEST..=LONGEST).contains(&ratio) && (0.0..=0.5).contains(&poisson);
        if !in_range {
            return None;
        }
        let arguments = [ratio, poisson].map(f64::to_bits);
        if let Some((_, coefficients)) = LAST.get().filter(|(last, _)| *last == arguments) {
            return Some(coefficients);
        }
        let [coarse, fine] = DEGREES.map(|degree| of_degree(ratio, poisson, degree));
        let (coarse, fine) = (coarse?, fine?);
        let [n, m] = DEGREES.map(|degree| degree as f64 + SHIFT);
        let weight = 1.0 / ((m / n).powi(4) - 1.0);
        let limit = |c: fn(&Self) -> f64| c(&fine) + weight * (c(&fine) - c(&coarse));
        let coefficients = Self {
            c11: limit(|c| c.c11),
            c22: limit(|c| c.c22),
            c23: limit(|c| c.c23),
            c33: limit(|c| c.c33),
        };
        LAST.set(Some((arguments, coefficients)));
        Some(coefficients)
    }
}

thread_local! {
    /// The bits of the last arguments and their coefficients. They take milliseconds, and a table
    /// of a sweep asks for the same ones in many rows and columns.
    static LAST: Cell<Option<([u64; 2], KalkerCoefficients)>> = const { Cell::new(None) };
}

/// Returns the coefficients with polynomials up to this degree, for ab = 1 and G = 1.
fn of_degree(ratio: f64, poisson: f64, degree: usize) -> Option<KalkerCoefficients> {
    let (a, b) = (ratio.sqrt(), 1.0 / ratio.sqrt());
    let chords = Chords::new(ratio, poisson, degree);
    let edge: Vec<Vec<f64>> =
        gauss_nodes(degree + 1).into_iter().map(|y| harmonics(degree, y)).collect();
    // The unknowns are the k of both components, degree by degree, and the equations both tractions
    // at the edge.
    let points = degree + 1;
    let mut at_edge = Mat::<f64>::zeros(2 * points, 2 * points);
    let mut right = Mat::<f64>::zeros(2 * points, 3);
    let mut tractions: Vec<Mat<f64>> = Vec::with_capacity(points);
    for n in 0..=degree {
        // The columns are the tractions of ξ, η and φ, and of a k of 1 along x and along y.
        let mut solved = Mat::<f64>::zeros(2 * (n + 1), 5);
        for harmonic in prescribed(n, [a, b]) {
            let row = harmonic.component * (n + 1) + harmonic.order;
            solved[(row, harmonic.creepage)] = harmonic.value;
        }
        (solved[(0, 3)], solved[(n + 1, 4)]) = (1.0, 1.0);
        cholesky_solve(&cholesky(chords.displacements(n))?, &mut solved);
        for (point, values) in edge.iter().enumerate() {
            let values = &values[start(n)..=start(n) + n];
            for component in 0..2 {
                let row = component * points + point;
                let traction = |column: usize| -> f64 {
                    let of_order = |m: usize| solved[(component * (n + 1) + m, column)];
                    values.iter().enumerate().map(|(m, value)| value * of_order(m)).sum()
                };
                (at_edge[(row, 2 * n)], at_edge[(row, 2 * n + 1)]) = (traction(3), traction(4));
                for motion in 0..3 {
                    right[(row, motion)] -= traction(motion);
                }
            }
        }
        tractions.push(solved);
    }
    let free = ColumnPivotLu::new(&at_edge).solve(&right);
    let traction = |n: usize, component: usize, order: usize, motion: usize| {
        let (solved, row) = (&tractions[n], component * (n + 1) + order);
        solved[(row, motion)]
            + solved[(row, 3)] * free[(2 * n, motion)]
            + solved[(row, 4)] * free[(2 * n + 1, motion)]
    };
    // The forces are integrals of H over half a sphere, where only degree 0 is left, and with x and
    // y only degree 1.
    let force = |component: usize, motion: usize| PI.sqrt() * traction(0, component, 0, motion);
    let third = (PI / 3.0).sqrt();
    let moment =
        |motion: usize| third * (a * traction(1, 1, 1, motion) - b * traction(1, 0, 0, motion));
    let coefficients = KalkerCoefficients {
        c11: -force(0, 0),
        c22: -force(1, 1),
        c23: -force(1, 2),
        c33: -moment(2),
    };
    coefficients.c33.is_finite().then_some(coefficients)
}

/// A coefficient of a harmonic in the displacements that the rolling prescribes.
struct PrescribedHarmonic {
    /// The index of the creepage ξ or η, or the spin φ.
    creepage: usize,
    /// The component of the displacement, x or y.
    component: usize,
    /// The order, above 0.
    order: usize,
    value: f64,
}

/// Returns what is prescribed of harmonics of degree `n` under unit creepages and spin.
fn prescribed(n: usize, [a, b]: [f64; 2]) -> Vec<PrescribedHarmonic> {
    let harmonic = |creepage, component, order, value| PrescribedHarmonic {
        creepage,
        component,
        order,
        value,
    };
    match n {
        // X is (4π/3)^½ H₁₁.
        1 => {
            let x = a * (4.0 * PI / 3.0).sqrt();
            vec![harmonic(0, 0, 1, x), harmonic(1, 1, 1, x)]
        }
        // XY is (4π/15)^½ H₂₁, and X² is (4π/15)^½ H₂₂ and a function of Y.
        2 => {
            let root = (4.0 * PI / 15.0).sqrt();
            vec![harmonic(2, 0, 1, -a * b * root), harmonic(2, 1, 2, 0.5 * a * a * root)]
        }
        _ => Vec::new(),
    }
}

/// The directions of the chords, with the harmonics there.
struct Chords {
    /// The harmonics at ν.
    harmonics: Vec<Vec<f64>>,
    /// The xx, xy and yy of K/D with the weight of the direction.
    kernels: Vec<[f64; 3]>,
}

impl Chords {
    /// Makes the directions α of a rule for the integral from 0 to π. With an elliptic integral of
    /// the first kind in place of α the integrand is analytic in a strip that narrows like the
    /// logarithm of the ratio, and the trapezoidal rule converges geometrically.
    fn new(ratio: f64, poisson: f64, degree: usize) -> Self {
        let (a, b) = (ratio.sqrt(), 1.0 / ratio.sqrt());
        let slenderness = ratio.min(1.0 / ratio);
        let points = ((2 * degree + 40) as f64 * (1.0 - 0.2 * slenderness.ln())) as usize;
        let amplitude = Amplitude::new(slenderness);
        let step = 2.0 * amplitude.quarter / points as f64;
        let mut chords = Self { harmonics: Vec::new(), kernels: Vec::new() };
        for index in 0..points {
            let u = (index as f64 + 0.5) * step;
            // The shorter axis is met where the amplitude is a right angle.
            let (sin, cos) = if ratio < 1.0 {
                let (sin, cos) = amplitude.at(u - amplitude.quarter).sin_cos();
                (cos, sin)
            } else {
                amplitude.at(u).sin_cos()
            };
            let length = (a * cos).hypot(b * sin);
            let direction = [a * cos / length, -b * sin / length];
            let weight = step / a.max(b);
            chords.harmonics.push(harmonics(degree, cos));
            chords.kernels.push([
                weight * (1.0 - poisson + poisson * direction[0] * direction[0]),
                weight * poisson * direction[0] * direction[1],
                weight * (1.0 - poisson + poisson * direction[1] * direction[1]),
            ]);
        }
        chords
    }

    /// Returns the matrix by which harmonics of degree `n` in the tractions make those in the
    /// displacements, x before y and orders ascending.
    fn displacements(&self, n: usize) -> Mat<f64> {
        let mut matrix = Mat::<f64>::zeros(2 * (n + 1), 2 * (n + 1));
        for m in 0..=n {
            for k in 0..=n {
                let mut sums = [0.0; 3];
                for (values, kernel) in self.harmonics.iter().zip(&self.kernels) {
                    let product = values[start(n) + m] * values[start(n) + k];
                    for (sum, kernel) in sums.iter_mut().zip(kernel) {
                        *sum += product * kernel;
                    }
                }
                let [xx, xy, yy] = sums.map(|sum| 4.0 * PI / (2 * n + 1) as f64 * sum);
                matrix[(m, k)] = xx;
                matrix[(m, n + 1 + k)] = xy;
                matrix[(n + 1 + m, k)] = xy;
                matrix[(n + 1 + m, n + 1 + k)] = yy;
            }
        }
        matrix
    }
}

/// Jacobi's amplitude for a complementary modulus, by the arithmetic–geometric mean (NIST Digital
/// Library of Mathematical Functions, 22.20.3).
struct Amplitude {
    /// The complete elliptic integral of the first kind, a quarter of the period.
    quarter: f64,
    /// The limit of the means, times a power of two.
    scale: f64,
    /// The ratios c/a of the means, from the last one back to the first.
    ratios: Vec<f64>,
}

impl Amplitude {
    fn new(complementary_modulus: f64) -> Self {
        let (mut mean, mut other) = (1.0, complementary_modulus);
        let mut ratios = Vec::new();
        // The convergence is quadratic: a distance of 1e-9 becomes 1e-18 in the next mean.
        while (mean - other).abs() > 1e-9 * mean {
            let half = 0.5 * (mean - other);
            (mean, other) = (0.5 * (mean + other), (mean * other).sqrt());
            ratios.push(half / mean);
        }
        let scale = mean * 2f64.powi(ratios.len() as i32);
        ratios.reverse();
        Self { quarter: 0.5 * PI / mean, scale, ratios }
    }

    /// Returns the amplitude of u.
    fn at(&self, u: f64) -> f64 {
        self.ratios
            .iter()
            .fold(self.scale * u, |angle, ratio| 0.5 * (angle + (ratio * angle.sin()).asin()))
    }
}

/// Returns the index of the first harmonic of degree `n` in [`harmonics`].
fn start(n: usize) -> usize {
    n * (n + 1) / 2
}

/// Returns the spherical harmonics H_nm(θ, 0) of all degrees up to `degree`, where `y` is cos θ;
/// those with cos mφ, of the norm 1 on the sphere.
fn harmonics(degree: usize, y: f64) -> Vec<f64> {
    let sin = ((1.0 - y) * (1.0 + y)).max(0.0).sqrt();
    let mut values = vec![0.0; start(degree + 1)];
    let mut sectoral = 0.5f64.sqrt();
    for m in 0..=degree {
        if m > 0 {
            sectoral *= sin * ((2 * m + 1) as f64 / (2 * m) as f64).sqrt();
        }
        let (mut before, mut value) = (0.0, sectoral);
        let azimuth = (if m == 0 { 2.0 * PI } else { PI }).sqrt();
        let mut factor_before = 0.0;
        for n in m..=degree {
            values[start(n) + m] = value / azimuth;
            let next = (n + 1) as f64;
            let order = m as f64;
            let factor = ((4.0 * next * next - 1.0) / (next * next - order * order)).sqrt();
            let after = if n == m { 0.0 } else { before / factor_before };
            (before, value) = (value, factor * (y * value - after));
            factor_before = factor;
        }
    }
    values
}

/// Returns the zeros of the Legendre polynomial of a degree.
fn gauss_nodes(degree: usize) -> Vec<f64> {
    let zero = |index: usize| {
        let mut y = (PI * (index as f64 + 0.75) / (degree as f64 + 0.5)).cos();
        // Newton's method from here is at rounding after four steps.
        for _ in 0..6 {
            let (mut before, mut value) = (1.0, y);
            for k in 1..degree {
                let k = k as f64;
                (before, value) = (value, ((2.0 * k + 1.0) * y * value - k * before) / (k + 1.0));
            }
            y -= value * (y * y - 1.0) / (degree as f64 * (y * value - before));
        }
        y
    };
    (0..degree).map(zero).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(ratio: f64, poisson: f64) -> KalkerCoefficients {
        KalkerCoefficients::new(ratio, poisson).unwrap()
    }

    fn array(c: KalkerCoefficients) -> [f64; 4] {
        [c.c11, c.c22, c.c23, c.c33]
    }

    /// Compares with values that another program computed, up to the error that these claim, and
    /// with the published ones of three digits.
    #[test]
    fn coefficients_are_those_of_the_table() {
        let text = include_str!("../../tests/reference/kalker_coefficients.csv");
        let mut rows = 0;
        for line in text.lines().skip(1) {
            let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            let found = array(of(row[0], row[1]));
            // The axes' ratio has ten digits there, and each value six or seven.
            let claimed = row[6] + 2e-6 + if row[0] < 0.5 { 6e-5 } else { 2e-6 };
            for (c, found) in found.into_iter().enumerate() {
                let error = (found / row[2 + c] - 1.0).abs();
                assert!(error <= claimed, "{line}: {found} {error:e}");
                assert!((found / row[7 + c] - 1.0).abs() < 0.011, "{line}: {found}");
            }
            rows += 1;
        }
        assert_eq!(rows, 36);
    }

    #[test]
    fn the_limit_is_as_good_as_it_says() {
        for (ratio, claimed) in
            [(1e-3, 3e-3), (0.01, 8e-4), (0.1, 6e-5), (0.5, 3e-6), (1.0, 3e-6), (10.0, 3e-6)]
        {
            for poisson in [0.0, 0.3, 0.5] {
                let [coarse, fine] =
                    [48, 64].map(|degree| array(of_degree(ratio, poisson, degree).unwrap()));
                for (c, found) in array(of(ratio, poisson)).into_iter().enumerate() {
                    let rest = 1.0 / ((65.0f64 / 49.0).powi(4) - 1.0);
                    let exact = fine[c] + rest * (fine[c] - coarse[c]);
                    let error = (found / exact - 1.0).abs();
                    assert!(error <= claimed, "{ratio} {poisson} C{c}: {error:e}");
                }
            }
        }
    }

    /// The error of a degree falls with the fourth power of the next degree.
    #[test]
    fn the_error_has_its_order() {
        for poisson in [0.0, 0.25] {
            let exact = array(of(1.0, poisson));
            let error = |degree| {
                let found = array(of_degree(1.0, poisson, degree).unwrap());
                (found[0] / exact[0] - 1.0).abs()
            };
            let order = (error(12) / error(24)).ln() / (25.0f64 / 13.0).ln();
            assert!((order - 4.0).abs() < 0.2, "{order}");
        }
    }

    /// The circle without ν has 4/3.
    #[test]
    fn the_coupling_of_a_circle_is_exact() {
        assert!((of(1.0, 0.0).c23 - 4.0 / 3.0).abs() < 1e-13);
    }

    /// A contact that is short along the way is a line contact in each of its sections: C₁₁ comes
    /// to π²/4(1−ν), C₂₂ to π²/4, and C₃₃ a/b to π²/16(1−ν).
    #[test]
    fn short_contacts_are_line_contacts() {
        for poisson in [0.0, 0.3] {
            let c = of(1e-3, poisson);
            let strip = PI * PI / 4.0;
            for (found, exact) in [
                (c.c11, strip / (1.0 - poisson)),
                (c.c22, strip),
                (c.c33 * 1e-3, 0.25 * strip / (1.0 - poisson)),
            ] {
                assert!((found / exact - 1.0).abs() < 2e-3, "{found} {exact}");
            }
        }
    }

    #[test]
    fn outside_there_are_none() {
        for (ratio, poisson) in
            [(0.9e-3, 0.3), (1.1e3, 0.3), (1.0, -0.1), (1.0, 0.51), (f64::NAN, 0.3)]
        {
            assert_eq!(KalkerCoefficients::new(ratio, poisson), None);
        }
        assert!(KalkerCoefficients::new(1.0, f64::NAN).is_none());
        for ratio in [1e-3, 1e3] {
            assert!(array(of(ratio, 0.5)).iter().all(|c| *c > 0.0));
        }
    }
}
