//! Bonded isotropic layers on a half-space or a rigid base, in the Fourier plane.
//!
//! Under a surface traction of wavenumber k the surface moves by C(k) times the traction: normal
//! (N), along the wave vector (L) and across it (T). T stands alone; the other two are coupled:
//!   half-space: C_NN = C_LL = (1−ν)/(Gk), C_LN = −(1−2ν)/(2Gk), C_TT = 1/(Gk).
//!
//! A layer turns the compliance of what is below it into that of its own upper face. That map is
//! fractional linear in the matrix C, hence *linear* in (1, C_LL, C_NN, C_LN, det C) up to a common
//! factor: the second compound of the layer's transfer matrix. Its entries are elementary functions
//! of kh, each computed here without cancellation, and all that multiply the positive quantities
//! are positive. Only C_LN has a sign of its own, and it is bounded by √(C_LL C_NN), so a step
//! loses about a digit at worst, for any kh, any ν up to ½ and any contrast of stiffness. Solving
//! for the amplitudes of exponentials instead has the condition number (kh)⁻³.

use crate::model::{Base, Layer, Material};

/// The surface compliance at one wavenumber: displacement per unit traction, in the unit of
/// length/modulus.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Compliance {
    /// The normal displacement under pressure.
    pub nn: f64,
    /// The displacement along the wave vector under traction along it.
    pub ll: f64,
    /// The normal displacement under traction along the wave vector, a quarter of a wave apart;
    /// also the reverse.
    pub ln: f64,
    /// The displacement across the wave vector under traction across it.
    pub tt: f64,
}

impl Compliance {
    /// Returns the compliance of a half-space times the wavenumber, which is the same at all
    /// wavenumbers.
    pub(crate) fn half_space(material: &Material) -> Self {
        let (g, nu) = (material.shear_modulus, material.poisson);
        let direct = (1.0 - nu) / g;
        Self { nn: direct, ll: direct, ln: (nu - 0.5) / g, tt: 1.0 / g }
    }

    /// Combines each entry with that of `other`.
    pub(crate) fn zip(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            nn: f(self.nn, other.nn),
            ll: f(self.ll, other.ll),
            ln: f(self.ln, other.ln),
            tt: f(self.tt, other.tt),
        }
    }

    /// Maps each entry.
    pub(crate) fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        self.zip(self, |c, _| f(c))
    }
}

/// Layers of at least two different materials, or at least one on a rigid base.
#[derive(Clone, Debug, PartialEq)]
pub struct Layered {
    /// The layers from the surface down; neighbours differ, and the last differs from the base.
    layers: Vec<Layer>,
    base: Base,
}

/// Compliances times the wavenumber, so that they stay between those of the materials.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response {
    /// The compliance at the surface.
    pub(crate) surface: Compliance,
    /// The compliance at the surface minus that of the base; its rounding error, too, vanishes with
    /// k.
    pub(crate) above_base: Compliance,
}

impl Layered {
    /// Puts these layers, from the surface down, on `base`; `None` if they are one homogeneous
    /// half-space.
    pub(crate) fn new(layers: &[Layer], base: &Base) -> Option<Self> {
        let mut distinct: Vec<Layer> = Vec::with_capacity(layers.len());
        for layer in layers {
            match distinct.last_mut() {
                Some(above) if above.material() == layer.material() => {
                    above.thickness += layer.thickness
                }
                _ => distinct.push(*layer),
            }
        }
        if distinct.last().is_some_and(|lowest| Base::Elastic(lowest.material()) == *base) {
            distinct.pop();
        }
        (!distinct.is_empty()).then_some(Self { layers: distinct, base: *base })
    }

    /// Returns the layers from the surface down; neighbours of the same material are one layer.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Returns the base on which the layers rest.
    pub(crate) fn base(&self) -> Base {
        self.base
    }

    /// Returns the same layers in another unit of compliance: all compliances times `factor`.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        let softer = |shear_modulus: f64| shear_modulus / factor;
        let layers = self
            .layers
            .iter()
            .map(|layer| Layer { shear_modulus: softer(layer.shear_modulus), ..*layer })
            .collect();
        let base = match self.base {
            Base::Rigid => Base::Rigid,
            Base::Elastic(m) => {
                Base::Elastic(Material { shear_modulus: softer(m.shear_modulus), ..m })
            }
        };
        Self { layers, base }
    }

    /// Returns the compliance at the wavenumber `k` > 0 (1/length, in the unit of length of the
    /// layers' thicknesses). Each entry is good to 3e-15 of itself, the coupling to 3e-15 of √(C_NN
    /// C_LL).
    pub(crate) fn compliance(&self, k: f64) -> Compliance {
        self.response(k).surface.map(|c| c / k)
    }

    /// Returns the compliance of the base alone, times the wavenumber.
    pub(crate) fn base_times_k(&self) -> Compliance {
        match &self.base {
            Base::Rigid => Compliance::default(),
            Base::Elastic(material) => Compliance::half_space(material),
        }
    }

    /// Returns the compliances times the wavenumber `k` > 0.
    pub(crate) fn response(&self, k: f64) -> Response {
        let base = self.base_times_k();
        let mut below = Face::of_base(&self.base);
        let mut above_base = Compliance::default();
        for layer in self.layers.iter().rev() {
            let upper = upper_face(layer, k * layer.thickness, below);
            below = upper.face;
            above_base = above_base.zip(&upper.gain, |sum, gain| sum + gain);
        }
        // Far from the base's compliance the plain difference is the better one, because the gains
        // of the layers may cancel.
        let surface = below.compliance;
        let far = surface.zip(&base, |top, base| {
            if (top - base).abs() > 0.5 * base.abs() { top - base } else { f64::NAN }
        });
        let above_base = far.zip(&above_base, |far, sum| if far.is_nan() { sum } else { far });
        Response { surface, above_base }
    }
}

/// The upper or lower face of a layer.
#[derive(Clone, Copy)]
pub(super) struct Face {
    /// The compliance times k of all that lies below.
    pub(super) compliance: Compliance,
    /// The determinant of the compliance times k.
    determinant: f64,
}

impl Face {
    /// Returns the upper face of a base.
    pub(super) fn of_base(base: &Base) -> Self {
        // The determinant is carried along on its own, because the difference of products would
        // cancel where both columns are nearly parallel.
        match base {
            Base::Rigid => Self { compliance: Compliance::default(), determinant: 0.0 },
            Base::Elastic(m) => Self {
                compliance: Compliance::half_space(m),
                determinant: (0.75 - m.poisson) / (m.shear_modulus * m.shear_modulus),
            },
        }
    }
}

/// The upper face of a layer.
pub(super) struct UpperFace {
    /// The face.
    pub(super) face: Face,
    /// The compliance times k in excess of that of the lower face.
    gain: Compliance,
    /// The determinant of the matrix that turns tractions on the lower face into those on the upper
    /// one, times (1−ν)² e^{−2kh}.
    pub(super) divisor: f64,
}

/// Returns the upper face of a layer with x = kh on the lower face `below`.
pub(super) fn upper_face(layer: &Layer, x: f64, below: Face) -> UpperFace {
    let (g, nu) = (layer.shear_modulus, layer.poisson);
    let c = below.compliance.map(|c| c * g);
    let det = below.determinant * g * g;
    let f = Hyperbolic::new(x);
    // Here m = 1−ν, w = 1−2ν, κ = 3−4ν; products with 1 ∓ … are written so that ν = 0 and ν = ½ do
    // not cancel.
    let (m, w, kappa) = (1.0 - nu, 1.0 - 2.0 * nu, 3.0 - 4.0 * nu);
    let w_less = f.sinh_cosh_less_x - 2.0 * nu * f.sinh_cosh; // w sinh cosh − x
    let w_more = w * f.sinh_cosh + f.x;
    let kappa_less = f.sinh_cosh_less_x + 2.0 * w * f.sinh_cosh; // κ sinh cosh − x
    let kappa_more = kappa * f.sinh_cosh + f.x;
    let plus = f.sinh_cosh + f.x;
    let minus = f.sinh_cosh_less_x;
    let coupling = w * f.sinh2 + f.x2;
    let twist = f.sinh2_less_x2 + (kappa * w - 1.0) * f.sinh2; // κ w sinh² − x²
    let identity = m * m * f.one;
    let closed = 0.25 * (kappa * f.sinh2 + f.x2);

    let divisor_less =
        m * (plus * c.ll + minus * c.nn) - coupling * c.ln + f.sinh2_less_x2 * det + closed;
    let divisor = identity + divisor_less;
    let ll = m * (m * f.sinh2 * (c.ll + c.nn) - w_more * c.ln + minus * det + 0.25 * kappa_more);
    let nn = m * (m * f.sinh2 * (c.ll + c.nn) - w_less * c.ln + plus * det + 0.25 * kappa_less);
    let ln = -0.5 * m * (w_less * c.ll + w_more * c.nn) + 0.5 * (w * w * f.sinh2 - f.x2) * c.ln
        - 0.5 * coupling * det
        - 0.125 * twist;
    let det_more = 0.25 * m * (kappa_less * c.ll + kappa_more * c.nn) - 0.25 * twist * c.ln
        + closed * det
        + 0.0625 * (f.sinh2_less_x2 + 8.0 * m * w * f.sinh2); // κ² sinh² − x², as κ² − 1 = 8mw

    let tanh = x.tanh();
    let across = 1.0 + c.tt * tanh;
    let more = Compliance { nn, ll, ln, tt: tanh };
    let top = Compliance {
        tt: (c.tt + tanh) / across,
        ..c.zip(&more, |c, more| (identity * c + more) / divisor)
    };
    let gain = Compliance {
        tt: tanh * (1.0 - c.tt * c.tt) / across,
        ..c.zip(&more, |c, more| (more - c * divisor_less) / divisor)
    };
    let top_det = (identity * det + det_more) / divisor;
    UpperFace {
        face: Face { compliance: top.map(|c| c / g), determinant: top_det / (g * g) },
        gain: gain.map(|c| c / g),
        divisor,
    }
}

/// Functions of x = kh, all times e^{−2x}.
struct Hyperbolic {
    one: f64,
    x: f64,
    x2: f64,
    sinh_cosh: f64,
    sinh2: f64,
    /// The difference sinh x cosh x − x.
    sinh_cosh_less_x: f64,
    /// The difference sinh² x − x².
    sinh2_less_x2: f64,
}

impl Hyperbolic {
    /// Returns the functions of x ≥ 0.
    fn new(x: f64) -> Self {
        // Farther down nothing is felt; the bound keeps an infinite x from making 0 · ∞.
        let x = x.min(1e3);
        let one = (-2.0 * x).exp();
        let sinh_cosh = -0.25 * (-4.0 * x).exp_m1();
        let sinh2 = 0.25 * (-2.0 * x).exp_m1().powi(2);
        let (sinh_cosh_less_x, sinh2_less_x2) = if x < 1.0 {
            // The series sum (sinh 2x − 2x)/2 and (cosh 2x − 1 − 2x²)/2.
            let t = 4.0 * x * x;
            let tail = |first: f64| {
                let (mut term, mut sum) = (1.0, 0.0);
                for n in 0..14 {
                    sum += term;
                    let n = first + 2.0 * f64::from(n);
                    term *= t / ((n + 1.0) * (n + 2.0));
                }
                sum
            };
            (one * t * x / 6.0 * tail(3.0), one * t * t / 48.0 * tail(4.0))
        } else {
            (sinh_cosh - x * one, sinh2 - x * x * one)
        };
        Self { one, x: x * one, x2: x * x * one, sinh_cosh, sinh2, sinh_cosh_less_x, sinh2_less_x2 }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Reads the layers "G;ν;h G;ν;h …" and the base "G;ν" or "rigid" of a reference table.
    pub(crate) fn stack(layers: &str, base: &str) -> (Vec<Layer>, Base) {
        let numbers = |text: &str| -> Vec<f64> {
            text.split(';').map(|cell| cell.parse().unwrap()).collect()
        };
        let layers = layers.split_whitespace().map(|layer| match numbers(layer)[..] {
            [shear_modulus, poisson, thickness] => Layer { shear_modulus, poisson, thickness },
            _ => panic!("{layer}"),
        });
        let base = if base == "rigid" {
            Base::Rigid
        } else {
            let [shear_modulus, poisson] = numbers(base)[..] else { panic!("{base}") };
            Base::Elastic(Material { shear_modulus, poisson })
        };
        (layers.collect(), base)
    }

    fn meets(reference: &str, tolerance: f64) -> usize {
        let mut worst = (0.0, String::new());
        let mut rows = 0;
        for line in reference.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let [k, ll, ln, nn, tt] =
                [3, 4, 5, 6, 7].map(|column| cells[column].parse::<f64>().unwrap());
            let (layers, base) = stack(cells[1], cells[2]);
            let got = match Layered::new(&layers, &base) {
                Some(layered) => layered.compliance(k),
                None => match &base {
                    Base::Elastic(material) => Compliance::half_space(material).map(|c| c / k),
                    Base::Rigid => panic!("{line}"),
                },
            };
            let errors = [
                (got.ll - ll) / ll,
                (got.nn - nn) / nn,
                (got.tt - tt) / tt,
                (got.ln - ln) / (nn * ll).sqrt(),
            ]
            .map(|error: f64| error.abs());
            for error in errors {
                if error > worst.0 || error.is_nan() {
                    worst = (error, line.to_owned());
                }
            }
            rows += 1;
        }
        assert!(worst.0 <= tolerance, "{:e} at {}", worst.0, worst.1);
        rows
    }

    #[test]
    fn compliance_meets_the_reference() {
        // The rounding of ν = 0.49999 to a double costs 7e-13; the random rows are for the doubles
        // themselves.
        assert_eq!(meets(include_str!("../../tests/reference/layer_compliance.csv"), 1e-12), 112);
        assert_eq!(
            meets(include_str!("../../tests/reference/layer_compliance_random.csv"), 3e-15),
            240
        );
    }

    #[test]
    fn equal_neighbours_are_one_body() {
        let (hard, soft) = (
            Material { shear_modulus: 7.0, poisson: 0.2 },
            Material { shear_modulus: 0.3, poisson: 0.5 },
        );
        let layer = |m: Material, thickness| Layer {
            shear_modulus: m.shear_modulus,
            poisson: m.poisson,
            thickness,
        };
        assert_eq!(Layered::new(&[layer(hard, 0.5), layer(hard, 2.0)], &Base::Elastic(hard)), None);
        assert_eq!(Layered::new(&[], &Base::Rigid), None);
        let whole =
            Layered::new(&[layer(hard, 0.5), layer(soft, 2.0)], &Base::Elastic(hard)).unwrap();
        let cut = Layered::new(
            &[layer(hard, 0.25), layer(hard, 0.25), layer(soft, 2.0), layer(hard, 3.0)],
            &Base::Elastic(hard),
        )
        .unwrap();
        assert_eq!(whole, cut);
        // The arithmetic without the shortcut says the same.
        let uncut = Layered { layers: vec![layer(hard, 0.5); 5], base: Base::Elastic(hard) };
        let thick = Layered::new(&[layer(hard, 2.5)], &Base::Rigid).unwrap();
        let sliced = Layered { layers: vec![layer(hard, 0.5); 5], base: Base::Rigid };
        for k in [1e-9, 1e-3, 0.1, 1.0, 3.0, 1e3, 1e300] {
            let half_space = Compliance::half_space(&hard).map(|c| c / k);
            for (got, exact) in
                [(uncut.compliance(k), half_space), (sliced.compliance(k), thick.compliance(k))]
            {
                let difference = got.zip(&exact, |a, b| (a - b).abs());
                assert!(
                    difference.nn <= 4e-15 * exact.nn
                        && difference.ll <= 4e-15 * exact.ll
                        && difference.tt <= 4e-15 * exact.tt,
                    "{k} {got:?} {exact:?}"
                );
                assert!(
                    difference.ln <= 4e-15 * exact.nn.sqrt() * exact.ll.sqrt(),
                    "{k} {got:?} {exact:?}"
                );
            }
        }
    }

    #[test]
    fn excess_over_the_base_vanishes_with_the_wavenumber() {
        let (layers, base) = stack("5;0.2;0.1 0.5;0.4;0.3 2;0.3;0.05", "1;0.35");
        let layered = Layered::new(&layers, &base).unwrap();
        let slope = |k: f64| layered.response(k).above_base.map(|c| c / k);
        let limit = slope(1e-12);
        // The limit of ll at k → 0 is the reference table's 64999999.9199… − 65000000 at k = 1e-8.
        assert!((limit.tt - -0.105).abs() < 1e-11, "{limit:?}");
        for k in [1e-30, 1e-20, 1e-14, 1e-13] {
            let difference = slope(k).zip(&limit, |a, b| ((a - b) / b).abs());
            assert!(
                difference.nn < 1e-9
                    && difference.ll < 1e-9
                    && difference.ln < 1e-9
                    && difference.tt < 1e-9,
                "{k}: {difference:?}"
            );
        }
        for k in [1e-6, 1e-3, 0.3, 30.0] {
            let Response { surface, above_base } = layered.response(k);
            let difference = surface
                .zip(&layered.base_times_k(), |a, b| a - b)
                .zip(&above_base, |a, b| (a - b).abs());
            assert!(
                difference.nn < 1e-15
                    && difference.ll < 1e-15
                    && difference.ln < 1e-15
                    && difference.tt < 1e-15,
                "{k}: {difference:?}"
            );
        }
    }
}
