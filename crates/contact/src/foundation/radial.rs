//! The surface kernels of a layered foundation as functions of the distance r, tabulated.
//!
//! With F = k·C(k) and θ the angle of receiver minus source, the kernels are
//!   nn = N/2π, xx, yy = (A ∓ B cos 2θ)/2π, xy = −B sin 2θ/2π, nx = −M cos θ/2π, ny = −M sin θ/2π,
//!   N = ∫ F_NN J₀(kr) dk, A = ∫ ½(F_LL+F_TT) J₀ dk, B = ∫ ½(F_LL−F_TT) J₂ dk, M = ∫ F_LN J₁ dk.
//! Where r is less than the top layer's thickness h₁ they are its half-space's, in closed form,
//! plus a correction that is smooth in (r/h₁)²; beyond, r times the whole kernel is tabulated on
//! panels of equal length in ln r. So neither a layer much thinner than an element nor one much
//! thicker than Ω loses digits to the difference of large numbers, and the number of Hankel
//! transforms grows with the logarithm of the ratio of lengths only.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::coefficient::Coefficient;
use super::half_space::HalfSpace;
use super::hankel::{LogGrid, Transform};
use super::kernel::{self, Kernel, Panel};
use super::layered::{Compliance, Layered};
use crate::model::{Base, Projection};

/// The four functions N, A, B, M, or quantities derived from them.
type Four = [f64; 4];

/// The orders of the Bessel functions.
const ORDERS: Four = [0.0, 0.0, 2.0, 1.0];

/// The number of Chebyshev coefficients of the first panel and of those in ln r.
pub(super) const DEGREE: usize = 16;

/// The length of a panel in ln r. The kernels are analytic for |arg r| < 30° at least: poles of
/// C(k) at an angle of 30° belong to a stiff plate on a thin incompressible layer on a rigid base,
/// k⁶ = −1, the nearest that are known.
pub(super) const PANEL: f64 = 0.25;

/// The number of points per direction that integrate the correction over a panel shorter than the
/// top layer's thickness.
const NEAR_POINTS: usize = 12;

/// The tabulated kernels up to a distance.
#[derive(Clone, Debug)]
pub(super) struct Radial {
    /// The top layer's half-space and the punch.
    surface: HalfSpace,
    /// The values r·(N, A, B, M) of the top layer's half-space and the punch.
    surface_four: Four,
    /// The thickness h₁ of the top layer.
    top_thickness: f64,
    /// The correction of (N, A, B/(r/h₁)², M/(r/h₁)) in t = 2(r/h₁)² − 1.
    correction: [Four; DEGREE],
    /// The values r·(N, A, B, M) from h₁ outwards.
    panels: Vec<[Four; DEGREE]>,
}

/// Returns the functions at one wavenumber of which N, A, B and M are transforms.
fn four(c: &Compliance) -> Four {
    [c.nn, 0.5 * (c.ll + c.tt), 0.5 * (c.ll - c.tt), c.ln]
}

/// Returns r·(N, A, B, M) of a half-space.
fn of_half_space(bodies: &HalfSpace) -> Four {
    [bodies.direct, bodies.direct + 0.5 * bodies.cross, -0.5 * bodies.cross, -bodies.coupling]
}

impl Radial {
    /// Tabulates the kernels of these layers and of `surface`, the top layer's half-space and the
    /// punch's, for 0 < r ≤ `reach`.
    pub(super) fn new(layered: &Layered, surface: &HalfSpace, reach: f64) -> Self {
        let top_thickness = layered.layers()[0].thickness;
        let transforms = Transforms::new(layered, reach);
        let surface_four = of_half_space(surface);
        let top_four = of_half_space(&HalfSpace::new(&layered.layers()[0].material(), None));
        // This is exactly zero for a rigid punch: over a thin layer, rounding here would be a
        // half-space as large as an element.
        let punch: Four = std::array::from_fn(|i| surface_four[i] - top_four[i]);
        let correction = chebyshev(|t| {
            let ratio = (0.5 * (1.0 + t)).sqrt();
            let four = transforms.correction(ratio * top_thickness);
            [0, 1, 2, 3].map(|i| four[i] / ratio.powf(ORDERS[i]) / (ratio * top_thickness))
        });
        let count = ((reach / top_thickness).ln() / PANEL).ceil().max(0.0) as usize;
        let panels = (0..count)
            .into_par_iter()
            .map(|panel| {
                chebyshev(|t| {
                    let layers = transforms
                        .whole(top_thickness * (PANEL * (panel as f64 + 0.5 * (1.0 + t))).exp());
                    std::array::from_fn(|i| layers[i] + punch[i])
                })
            })
            .collect();
        Self { surface: *surface, surface_four, top_thickness, correction, panels }
    }

    /// Returns r·(N, A, B, M).
    fn times_r(&self, r: f64) -> Four {
        let ratio = r / self.top_thickness;
        if ratio < 1.0 {
            let correction = self.correction_at(ratio);
            return [0, 1, 2, 3].map(|i| self.surface_four[i] + r * correction[i]);
        }
        let place = ratio.ln() / PANEL;
        let panel = (place as usize).min(self.panels.len().saturating_sub(1));
        clenshaw(&self.panels[panel], 2.0 * (place - panel as f64) - 1.0)
    }

    /// Returns the correction of (N, A, B, M) at r = ratio · h₁.
    fn correction_at(&self, ratio: f64) -> Four {
        let [n, a, b, m] = clenshaw(&self.correction, 2.0 * ratio * ratio - 1.0);
        [n, a, b * ratio * ratio, m * ratio]
    }

    /// Returns the coefficient of the receiver at `offset`; see [`kernel::element`].
    pub(super) fn influence(
        &self,
        offset: [f64; 2],
        hx: f64,
        hy: f64,
        projection: Projection,
    ) -> Coefficient {
        kernel::element_of(InUnits { radial: self, unit: 1.0 }, offset, hx, hy, projection)
    }
}

/// Returns the kernels in the direction (cos θ, sin θ), given (N, A, B, M).
#[inline]
fn at_angle([n, a, b, m]: Four, cos: f64, sin: f64) -> Coefficient {
    let [n, a, b, m] = [n, a, b, m].map(|f| f / TAU);
    let b_cos = b * (cos - sin) * (cos + sin);
    Coefficient {
        nn: n,
        xx: a - b_cos,
        yy: a + b_cos,
        xy: -2.0 * b * cos * sin,
        nx: -m * cos,
        ny: -m * sin,
    }
}

/// A [`Kernel`] whose coordinates are counted in `unit`.
#[derive(Clone, Copy)]
struct InUnits<'a> {
    radial: &'a Radial,
    unit: f64,
}

impl Kernel for InUnits<'_> {
    /// The value is (sin 30°)²; see [`PANEL`].
    const CLEARANCE: f64 = 0.25;

    fn in_units_of(self, unit: f64) -> Self {
        Self { unit: self.unit * unit, ..self }
    }

    #[inline]
    fn at(&self, x: f64, y: f64) -> Coefficient {
        let r = (x * x + y * y).sqrt();
        let inv_r = 1.0 / r;
        at_angle(self.radial.times_r(r * self.unit).map(|f| f * inv_r), x * inv_r, y * inv_r)
    }

    fn corner(&self, px: Panel, py: Panel) -> Option<Coefficient> {
        // The correction's singularities lie at r = ± 2i h₁: ten half-lengths away, or six from a
        // corner.
        if 2.0 * px.half().hypot(py.half()) * self.unit > self.radial.top_thickness {
            return None;
        }
        let mut sum = self.radial.surface.coefficient(&kernel::weighted_corner(px, py));
        let correction = kernel::panel_by_gauss(&px, &py, [NEAR_POINTS; 2], |x, y| {
            let r = (x * x + y * y).sqrt();
            at_angle(
                self.radial.correction_at(r * self.unit / self.radial.top_thickness),
                x / r,
                y / r,
            )
        });
        sum.add(&correction, self.unit);
        Some(sum)
    }
}

/// Returns the Chebyshev coefficients of f on (−1, 1), in the order of [`clenshaw`].
pub(super) fn chebyshev<const N: usize>(f: impl Fn(f64) -> [f64; N]) -> [[f64; N]; DEGREE] {
    let angle = |node: usize| PI * (node as f64 + 0.5) / DEGREE as f64;
    let values: [[f64; N]; DEGREE] = std::array::from_fn(|node| f(angle(node).cos()));
    std::array::from_fn(|n| {
        let scale = if n == 0 { 1.0 } else { 2.0 } / DEGREE as f64;
        std::array::from_fn(|i| {
            (0..DEGREE).map(|node| scale * values[node][i] * (n as f64 * angle(node)).cos()).sum()
        })
    })
}

/// Sums a Chebyshev series at t in (−1, 1).
#[inline]
pub(super) fn clenshaw<const N: usize>(coefficients: &[[f64; N]; DEGREE], t: f64) -> [f64; N] {
    let (mut next, mut last) = ([0.0; N], [0.0; N]);
    for c in coefficients[1..].iter().rev() {
        let current = std::array::from_fn(|i| c[i] + 2.0 * t * next[i] - last[i]);
        last = next;
        next = current;
    }
    std::array::from_fn(|i| coefficients[0][i] + t * next[i] - last[i])
}

/// The Hankel transforms, in two forms that lose their digits at opposite ends: of F − F(∞), whose
/// error relative to 1/r grows like √r, and of F with its limits at both ends taken out, which may
/// be weighted the other way round.
struct Transforms {
    /// The limit of F at k → ∞, which is the top layer's half-space.
    top: Four,
    /// The value of F at k = 0, which is the base's.
    base: Four,
    /// The length l of the function e^{−kl} that joins the two.
    length: f64,
    /// The transforms of F − F(∞).
    from_top: [Transform; 4],
    /// The transforms of F without its limits at both ends.
    from_both: [Transform; 4],
}

/// The functions to be transformed at one wavenumber.
struct FourAtWavenumber {
    /// The wavenumber.
    k: f64,
    /// The value of F at the surface.
    surface: Four,
    /// The value of F at the surface minus that of the base.
    above_base: Four,
}

impl Transforms {
    /// Transforms the layers' functions for distances up to `reach`.
    fn new(layered: &Layered, reach: f64) -> Self {
        /// The kh₁ beyond which the correction is below 1e-18.
        const DEEPEST: f64 = 25.0;
        /// The logarithm of the range in which both weights let the smallest wavenumbers fade like
        /// √k.
        const FADED: f64 = 80.0;
        /// The step in ln k. It resolves what is analytic for |arg k| < 30° to 1e-17; it is halved
        /// if that is not enough.
        const STEP: f64 = 0.08;
        let thickness = layered.layers()[0].thickness;
        let (top, base) = (
            four(&Compliance::half_space(&layered.layers()[0].material())),
            four(&layered.base_times_k()),
        );
        let length = 2.0 * thickness;
        let smallest = (-FADED).exp() / longest_feature(layered).max(reach);
        let mut grid = LogGrid::new([smallest, DEEPEST / thickness], 1.0 / thickness, STEP);
        let mut coarser = f64::INFINITY;
        loop {
            let responses: Vec<FourAtWavenumber> = grid
                .wavenumbers()
                .map(|k| {
                    let response = layered.response(k);
                    FourAtWavenumber {
                        k,
                        surface: four(&response.surface),
                        above_base: four(&response.above_base),
                    }
                })
                .collect();
            let from_top = [0, 1, 2, 3].map(|i| {
                let samples = responses.iter().map(|at_k| at_k.surface[i] - top[i]);
                Transform::new(&grid, samples, ORDERS[i], 0.5)
            });
            let from_both = [0, 1, 2, 3].map(|i| {
                let samples = responses.iter().map(|at_k| {
                    at_k.above_base[i] + (top[i] - base[i]) * (-at_k.k * length).exp_m1()
                });
                Transform::new(&grid, samples, ORDERS[i], -0.5)
            });
            let unresolved =
                from_top.iter().chain(&from_both).fold(0.0_f64, |m, t| m.max(t.unresolved));
            // The spectrum is below the wanted accuracy, or no longer falls: what is left is
            // rounding.
            if unresolved < 1e-14 || unresolved > 0.01 * coarser {
                return Self { top, base, length, from_top, from_both };
            }
            coarser = unresolved;
            grid = grid.refined();
        }
    }

    /// Returns r times the correction: the layers' kernels minus those of the top layer's
    /// half-space.
    fn correction(&self, r: f64) -> Four {
        [0, 1, 2, 3].map(|i| self.from_top[i].times_r(r))
    }

    /// Returns r times the layers' kernels.
    fn whole(&self, r: f64) -> Four {
        [0, 1, 2, 3].map(|i| {
            if self.from_top[i].noise(r) <= self.from_both[i].noise(r) {
                return self.top[i] + self.from_top[i].times_r(r);
            }
            // The shares are r ∫ e^{−kl} J_n(kr) dk and its complement to 1.
            let (l, s) = (self.length, r.hypot(self.length));
            let (base_share, top_share) = match ORDERS[i] as usize {
                0 => (r / s, l * l / (s * (s + r))),
                1 => (r * r / (s * (s + l)), l / s),
                _ => (r * (r / (s + l)).powi(2) / s, l * (2.0 * s - l - s * l / (r + s)) / (r * s)),
            };
            self.top[i] * top_share + self.base[i] * base_share + self.from_both[i].times_r(r)
        })
    }
}

/// Returns a length whose inverse lies below all features of C(k): the whole stack's thickness
/// times its contrast of stiffness.
pub(super) fn longest_feature(layered: &Layered) -> f64 {
    let base = match layered.base() {
        Base::Rigid => None,
        Base::Elastic(material) => Some(material.shear_modulus),
    };
    let moduli = || layered.layers().iter().map(|layer| layer.shear_modulus).chain(base);
    let (softest, stiffest) =
        (moduli().fold(f64::INFINITY, f64::min), moduli().fold(0.0, f64::max));
    layered.layers().iter().map(|layer| layer.thickness).sum::<f64>() * (stiffest / softest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foundation::layered::tests::stack;

    fn radial(layers: &str, base: &str, reach: f64) -> Radial {
        let (layers, base) = stack(layers, base);
        Radial::new(
            &Layered::new(&layers, &base).unwrap(),
            &HalfSpace::new(&layers[0].material(), None),
            reach,
        )
    }

    #[test]
    fn kernels_meet_the_reference() {
        let mut rows = 0;
        for line in include_str!("../../tests/reference/layer_kernels.csv").lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |column: usize| cells[column].parse::<f64>().unwrap();
            let r = number(3);
            let radial = radial(cells[1], cells[2], 10.0);
            let got = radial.times_r(r);
            let exact = [4, 5, 6, 7].map(number);
            // A and B stand side by side, M beside both; many orders below the top layer's own
            // value, rounding remains.
            let unit = [
                exact[0].abs(),
                exact[1].abs(),
                exact[1].abs(),
                (exact[0] * exact[1]).abs().sqrt(),
            ];
            let rounding = 1e-15 * radial.surface_four[0];
            let met = (0..4).all(|i| (got[i] - exact[i]).abs() <= 1e-12 * unit[i] + rounding);
            assert!(met, "{got:?} {line}");
            rows += 1;
        }
        assert!(rows > 20);
    }

    #[test]
    fn both_forms_agree_where_they_meet() {
        for (layers, base) in [
            ("5;0.2;0.1 0.5;0.4;0.3 2;0.3;0.05", "1;0.35"),
            ("1;0.5;0.3", "rigid"),
            ("1e3;0.1;0.1 1;0.5;0.01", "rigid"),
        ] {
            let radial = radial(layers, base, 3.0);
            for r in [
                radial.top_thickness,
                radial.top_thickness * PANEL.exp(),
                radial.top_thickness * (4.0 * PANEL).exp(),
            ] {
                let (below, above) =
                    (radial.times_r(r * (1.0 - 1e-15)), radial.times_r(r * (1.0 + 1e-15)));
                for i in 0..4 {
                    assert!(
                        (below[i] - above[i]).abs() <= 1e-13 * radial.surface_four[0],
                        "{layers} at {r}: {below:?} {above:?}"
                    );
                }
            }
        }
    }
}
