//! Stresses below the surface of bonded layers, in the Fourier plane.
//!
//! With x = kz and lengths in 1/k, the state (u_l, u_n, −σ_lz, −σ_zz) of a layer, of which u_l and
//! σ_lz go like sin and the others like cos, obeys y′ = S y, and (S² − 1)² = 0. What is below a
//! layer moves by C times the traction on it, so that the traction on its upper face is M times
//! that on its lower one, with
//!   M = (lower rows of e^{−Sx}) · (C over 1).
//! The traction at a depth is M⁻¹ of that above, from layer to layer. The entries of M are summed
//! here; its determinant, in which they cancel, is the positive `divisor` of `layered`, which is
//! summed without cancellation. So everything is good relative to e^{−kz}, for any kh.

use super::layered::{Face, Layered, upper_face};
use crate::model::{Base, Layer, Material};

/// The number of functions of the wavenumber that make all stresses at a depth.
pub(super) const FUNCTIONS: usize = 10;

/// The functions of the wavenumber, or their Hankel transforms: `HARMONICS` has the order of each.
pub(super) type Ten = [f64; FUNCTIONS];

/// The orders of the Bessel functions of the transforms of [`Cut::functions`].
pub(super) const HARMONICS: [f64; FUNCTIONS] = [0.0, 0.0, 2.0, 1.0, 1.0, 1.0, 1.0, 3.0, 0.0, 2.0];

/// The side of a depth at which two materials meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DepthSide {
    /// The upper material.
    Above,
    /// The lower material.
    Below,
}

impl DepthSide {
    /// Returns whether a depth lies above the lower face of a layer; the face itself does on the
    /// upper side.
    pub(crate) fn is_above(self, depth: f64, face: f64) -> bool {
        match self {
            Self::Above => depth <= face * (1.0 + 1e-14),
            Self::Below => depth < face * (1.0 - 1e-14),
        }
    }
}

/// The layers, cut at a depth.
#[derive(Clone, Debug)]
pub(super) struct Cut {
    /// The layers above the cut, from the surface down.
    pub(super) above: Vec<Layer>,
    /// The layers below it, from the cut down.
    pub(super) below: Vec<Layer>,
    base: Base,
    /// The material on the cut.
    material: Material,
}

impl Cut {
    /// Cuts the layers at a depth ≥ 0, in the material on this side of it. Returns `None` in a
    /// rigid base.
    pub(super) fn new(layered: &Layered, depth: f64, side: DepthSide) -> Option<Self> {
        let (layers, base) = (layered.layers(), layered.base());
        let (mut above, mut top) = (Vec::new(), 0.0);
        for (index, layer) in layers.iter().enumerate() {
            let bottom = top + layer.thickness;
            if side.is_above(depth, bottom) {
                let upper = (depth - top).clamp(0.0, layer.thickness);
                above.push(Layer { thickness: upper, ..*layer });
                let mut below = vec![Layer { thickness: layer.thickness - upper, ..*layer }];
                below.extend_from_slice(&layers[index + 1..]);
                return Some(Self { above, below, base, material: layer.material() });
            }
            above.push(*layer);
            top = bottom;
        }
        let Base::Elastic(material) = base else { return None };
        above.push(Layer {
            shear_modulus: material.shear_modulus,
            poisson: material.poisson,
            thickness: (depth - top).max(0.0),
        });
        Some(Self { above, below: Vec::new(), base, material })
    }

    /// Cuts a homogeneous half-space at a depth.
    pub(super) fn of_half_space(material: Material, depth: f64) -> Self {
        let layer = Layer {
            shear_modulus: material.shear_modulus,
            poisson: material.poisson,
            thickness: depth,
        };
        Self { above: vec![layer], below: Vec::new(), base: Base::Elastic(material), material }
    }

    /// Returns the ten functions at the wavenumber `k`. Under unit tractions n (pressure), l and t
    /// (along the wave vector and across it) the stresses are, with c and s for the cosine and sine
    /// of the wave vector's angle: zz and lz, ll and tt under n; zz, ll, tt and lz under l; tz and
    /// lt under t.
    pub(super) fn functions(&self, k: f64) -> Ten {
        // The face below each piece, from the base upwards.
        let mut face = Face::of_base(&self.base);
        for layer in self.below.iter().rev() {
            face = upper_face(layer, k * layer.thickness, face).face;
        }
        let on_cut = face.compliance;
        // The tractions on the cut: columns n and l of [l; n], and t.
        let mut sagittal = [[1.0, 0.0], [0.0, 1.0]];
        let mut across = 1.0;
        for layer in self.above.iter().rev() {
            let down = downwards(layer, k * layer.thickness, face);
            sagittal = product(sagittal, down.sagittal);
            across *= down.across;
            face = down.face;
        }
        let Material { shear_modulus: g, poisson: nu } = self.material;
        // Each column is the traction (l, n) under a unit traction l, n at the surface.
        let [[l_of_l, l_of_n], [n_of_l, n_of_n]] = sagittal;
        let strain = |l: f64, n: f64| g * (on_cut.ll * l + on_cut.ln * n);
        let along = |l: f64, n: f64| (2.0 * strain(l, n) - nu * n) / (1.0 - nu);
        let (ll_n, ll_l) = (along(l_of_n, n_of_n), along(l_of_l, n_of_l));
        let (tt_n, tt_l) = (nu * (ll_n - n_of_n), nu * (ll_l - n_of_l));
        let lt_t = g * on_cut.tt * across;
        [
            -n_of_n,
            0.5 * (ll_n + tt_n),
            0.5 * (ll_n - tt_n),
            l_of_n,
            n_of_l,
            0.5 * (ll_l + tt_l),
            0.25 * (ll_l - tt_l) + 0.5 * lt_t,
            0.25 * (ll_l - tt_l) - 0.5 * lt_t,
            -0.5 * (l_of_l + across),
            -0.5 * (l_of_l - across),
        ]
    }
}

/// The way through a layer.
struct Downwards {
    /// The traction (l, n) on the lower face per unit traction on the upper one.
    sagittal: [[f64; 2]; 2],
    /// The traction t on the lower face per unit traction on the upper one.
    across: f64,
    /// The upper face.
    face: Face,
}

/// Returns the way through a layer with x = kh on the face `below`.
fn downwards(layer: &Layer, x: f64, below: Face) -> Downwards {
    let (g, nu) = (layer.shear_modulus, layer.poisson);
    let (m, w) = (1.0 - nu, 1.0 - 2.0 * nu);
    let upper = upper_face(layer, x, below);
    // Farther down nothing is felt.
    let x = x.min(1e3);
    let c = below.compliance.map(|c| c * g);
    // The functions are times e^{−x}.
    let sinh = -0.5 * (-2.0 * x).exp_m1();
    let cosh = 0.5 * (1.0 + (-2.0 * x).exp());
    let (xs, xc) = (x * sinh, x * cosh);
    let less = if x < 0.5 {
        // The series x³/3 + x⁵/30 + …
        let (mut term, mut sum) = (x, 0.0);
        for n in 1..10 {
            let n = 2.0 * f64::from(n);
            term *= x * x / (n * (n + 1.0));
            sum += n * term;
        }
        (-x).exp() * sum
    } else {
        xc - sinh
    };
    let ll = (sinh + xc) * c.ll - xs * c.ln + m * cosh + 0.5 * xs;
    let ln = (sinh + xc) * c.ln - xs * c.nn + 0.5 * (w * sinh - xc);
    let nl = xs * c.ll - less * c.ln + 0.5 * (w * sinh + xc);
    let nn = xs * c.ln - less * c.nn + m * cosh - 0.5 * xs;
    let decay = (-x).exp();
    let factor = m * decay / upper.divisor;
    Downwards {
        sagittal: [[factor * nn, -factor * ln], [-factor * nl, factor * ll]],
        across: decay / (cosh + c.tt * sinh),
        face: upper.face,
    }
}

/// Returns the product of two matrices.
fn product(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}
