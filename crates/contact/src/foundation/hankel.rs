//! Hankel transforms g(r) = ∫ f(k) J_n(kr) dk over all wavenumbers, for f that vary with ln k
//! smoothly at every scale.
//!
//! With k = e^u, r = e^v and a(u) = k^q f(k) the transform is a convolution, r^{1−q} g = ∫ a(u)
//! w(u+v) du with w(s) = e^{(1−q)s} J_n(e^s). So a Fourier series of a(u) turns into one of r^{1−q}
//! g(r), term by term times the Mellin transform of J_n, which is known (Gradshteyn & Ryzhik
//! 6.561.14; the method: Talman, J. Comput. Phys. 29, 1978, and Hamilton's FFTLog):
//!   ∫ x^{μ−1} J_n(x) dx = 2^{μ−1} Γ((n+μ)/2) / Γ(1+(n−μ)/2).
//! The function a(u) is analytic in a strip about the real axis, so its spectrum falls
//! exponentially and equally spaced samples are as good as exact. The rounding error of g is of the
//! order of max|a| r^{q−1}, which determines the choice of the weight q.

use std::f64::consts::{PI, TAU};

use realfft::num_complex::Complex;

/// Wavenumbers in geometric progression, k_j = middle · e^{j·step}.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogGrid {
    middle: f64,
    step: f64,
    /// The number of wavenumbers, even.
    len: usize,
    /// The index j of the largest wavenumber.
    last: i64,
}

impl LogGrid {
    /// Makes a grid that reaches from below `smallest` to above `largest`. Phases are counted from
    /// `middle`, and are most accurate there.
    pub(super) fn new([smallest, largest]: [f64; 2], middle: f64, step: f64) -> Self {
        let last = ((largest / middle).ln() / step).ceil() as i64;
        let first = ((smallest / middle).ln() / step).floor() as i64;
        Self { middle, step, len: ((last - first + 2) as usize).next_multiple_of(8), last }
    }

    /// Returns the grid of the same range with half the step.
    pub(super) fn refined(&self) -> Self {
        Self { step: 0.5 * self.step, len: 2 * self.len, last: 2 * self.last, ..*self }
    }

    /// Returns all wavenumbers, in the cyclic order that begins with the middle one and continues
    /// after the largest with the smallest.
    pub(super) fn wavenumbers(&self) -> impl Iterator<Item = f64> + Clone + use<> {
        let Self { middle, step, len, last } = *self;
        (0..len as i64).map(move |index| {
            middle * (step * (if index <= last { index } else { index - len as i64 }) as f64).exp()
        })
    }
}

/// The transform of one function, as a Fourier series in ln r.
#[derive(Clone, Debug)]
pub(super) struct Transform {
    /// The weight q.
    weight: f64,
    /// The wavenumber from which phases are counted.
    middle: f64,
    /// The lowest frequency of the series in ln r.
    frequency: f64,
    /// The coefficients of the series, from frequency 0 up.
    terms: Vec<Complex<f64>>,
    /// The largest |k^q f(k)|: the error of r·g(r) is a small multiple of ε times this times r^q.
    pub(super) size: f64,
    /// The size of the highest frequencies relative to the largest one.
    pub(super) unresolved: f64,
}

impl Transform {
    /// Transforms the samples f(k) at the grid's wavenumbers with J of the given order, for a
    /// weight −½ ≤ q < 1.
    pub(super) fn new(
        grid: &LogGrid,
        samples: impl Iterator<Item = f64>,
        order: f64,
        weight: f64,
    ) -> Self {
        let mut weighted: Vec<f64> = samples
            .zip(grid.wavenumbers())
            .map(|(f, k)| f * (k / grid.middle).powf(weight))
            .collect();
        let size = weighted.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
        let forward = primitives::real_transform(weighted.len());
        let mut spectrum = forward.make_output_vec();
        let done = forward.process(&mut weighted, &mut spectrum);
        debug_assert!(done.is_ok());
        let peak = spectrum.iter().fold(0.0_f64, |m, a| m.max(a.norm()));
        let high = spectrum[spectrum.len() * 7 / 8..].iter().fold(0.0_f64, |m, a| m.max(a.norm()));
        // The highest frequency has no sine of its own.
        spectrum.pop();
        let frequency = TAU / (grid.len as f64 * grid.step);
        let terms = spectrum.iter().enumerate().map(|(m, a)| {
            let twice = if m == 0 { 1.0 } else { 2.0 };
            let mu = Complex::new(1.0 - weight, frequency * m as f64);
            a * mellin_bessel(order, mu) * (twice / grid.len as f64)
        });
        let unresolved = if peak > 0.0 { high / peak } else { 0.0 };
        Self { weight, middle: grid.middle, frequency, terms: terms.collect(), size, unresolved }
    }

    /// Returns r·g(r).
    pub(super) fn times_r(&self, r: f64) -> f64 {
        let v = (self.middle * r).ln();
        let turn = Complex::cis(-self.frequency * v);
        let sum =
            self.terms.iter().rev().fold(Complex::new(0.0, 0.0), |sum, term| sum * turn + term);
        (self.middle * r).powf(self.weight) * sum.re
    }

    /// Returns the order of magnitude of the rounding error of [`times_r`](Self::times_r), over ε.
    pub(super) fn noise(&self, r: f64) -> f64 {
        self.size * (self.middle * r).powf(self.weight)
    }
}

/// Returns ∫ x^{μ−1} J_n(x) dx over x > 0, continued analytically.
fn mellin_bessel(order: f64, mu: Complex<f64>) -> Complex<f64> {
    let rising = (mu + order) * 0.5;
    let falling = (-mu + order) * 0.5 + 1.0;
    (ln_gamma(rising) - ln_gamma(falling) + (mu - 1.0) * 2.0_f64.ln()).exp()
}

/// Returns ln Γ(z) for Re z > 0, up to a multiple of 2πi, by Stirling's series after moving z to
/// where it converges.
fn ln_gamma(mut z: Complex<f64>) -> Complex<f64> {
    /// The coefficients B_{2j}/(2j(2j−1)).
    const STIRLING: [f64; 7] = [
        1.0 / 12.0,
        -1.0 / 360.0,
        1.0 / 1260.0,
        -1.0 / 1680.0,
        1.0 / 1188.0,
        -691.0 / 360360.0,
        1.0 / 156.0,
    ];
    let mut product = Complex::new(1.0, 0.0);
    while z.norm() < 10.0 {
        product *= z;
        z += 1.0;
    }
    let inverse = z.inv();
    let square = inverse * inverse;
    let series = STIRLING.iter().rev().fold(Complex::new(0.0, 0.0), |sum, &b| sum * square + b);
    (z - 0.5) * z.ln() - z + 0.5 * (2.0 * PI).ln() + series * inverse - product.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gamma_of_a_complex_number() {
        // Γ(½) is √π; Γ(1+i) comes from mpmath.
        let close = |z: Complex<f64>, exact: Complex<f64>| {
            let got = ln_gamma(z).exp();
            assert!((got - exact).norm() <= 1e-14 * exact.norm(), "{z}: {got} {exact}");
        };
        close(Complex::new(0.5, 0.0), Complex::new(PI.sqrt(), 0.0));
        close(Complex::new(5.0, 0.0), Complex::new(24.0, 0.0));
        close(
            Complex::new(1.0, 1.0),
            Complex::new(0.498_015_668_118_356, -0.154_949_828_301_810_68),
        );
        // The reflection formula is Γ(½+iy)Γ(½−iy) = π/cosh πy.
        for y in [0.3, 4.0, 30.0] {
            let product = (ln_gamma(Complex::new(0.5, y)) + ln_gamma(Complex::new(0.5, -y))).exp();
            let exact = PI / (PI * y).cosh();
            assert!((product - exact).norm() <= 2e-14 * exact, "{y}");
        }
    }

    #[test]
    fn transform_of_an_exponential_is_known_in_closed_form() {
        let grid = LogGrid::new([1e-36, 60.0], 1.0, 0.08);
        for weight in [0.5, -0.5] {
            // The function f must vanish with k if the weight is negative.
            let f = |k: f64| if weight < 0.0 { k * (-k).exp() } else { (-k).exp() };
            for order in [0.0, 1.0, 2.0] {
                let transform = Transform::new(&grid, grid.wavenumbers().map(f), order, weight);
                assert!(transform.unresolved < 1e-15, "{}", transform.unresolved);
                for exponent in -30..60 {
                    let r = 10_f64.powf(0.1 * f64::from(exponent));
                    let s = r.hypot(1.0);
                    let tail = r / (s + 1.0); // (s−1)/r
                    // The integral is ∫ e^{−kl} J_n(kr) dk at l = 1, or minus its derivative with
                    // respect to l.
                    let exact = match (weight < 0.0, order as usize) {
                        (false, n) => tail.powi(n as i32) / s,
                        (true, n) => tail.powi(n as i32) * (1.0 + n as f64 * s) / (s * s * s),
                    };
                    let error = transform.times_r(r) - r * exact;
                    assert!(
                        error.abs() <= 32.0 * f64::EPSILON * transform.noise(r),
                        "{weight} {order} {r}: {error}"
                    );
                }
            }
        }
    }
}
