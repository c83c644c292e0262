//! The elasticity of both bodies as it is felt in the plane of contact.

use std::hash::{Hash, Hasher};

use super::coefficient::Coefficient;
use super::half_space::HalfSpace;
use super::layered::Layered;
use super::radial::Radial;
use crate::model::{Base, Layer, Material, Projection, Scene};

/// A foundation, layered or not, and the punch on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bodies {
    /// The material at the foundation's surface, as a half-space, and the punch. Without layers
    /// that is all there is; with layers it is what is felt close to a load.
    pub surface: HalfSpace,
    /// The foundation, unless it is a homogeneous half-space.
    pub layers: Option<Layered>,
}

impl From<&HalfSpace> for Bodies {
    fn from(surface: &HalfSpace) -> Self {
        Self { surface: *surface, layers: None }
    }
}

impl From<&Self> for Bodies {
    fn from(bodies: &Self) -> Self {
        bodies.clone()
    }
}

impl Bodies {
    /// Makes the bodies from the layers from the surface down, the base on which they rest, and the
    /// punch (`None`: rigid). The layers' thicknesses are in the unit of length of the grid that
    /// the bodies will be used with. Neighbouring layers of one material are one layer, and layers
    /// of the base's material on the base belong to it.
    pub fn new(layers: &[Layer], base: &Base, punch: Option<&Material>) -> Self {
        let foundation = match (layers.first(), base) {
            (Some(layer), _) => Some(layer.material()),
            (None, Base::Elastic(material)) => Some(*material),
            (None, Base::Rigid) => None,
        };
        let surface = match foundation {
            Some(material) => HalfSpace::new(&material, punch),
            None => punch.map_or(HalfSpace { direct: 0.0, cross: 0.0, coupling: 0.0 }, |punch| {
                let alone = HalfSpace::new(punch, None);
                HalfSpace { coupling: -alone.coupling, ..alone }
            }),
        };
        Self { surface, layers: Layered::new(layers, base) }
    }

    /// Returns the same bodies in another unit of compliance: all compliances times `factor`.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self {
            surface: self.surface.scaled(factor),
            layers: self.layers.as_ref().map(|layers| layers.scaled(factor)),
        }
    }

    /// Returns c = Σ (1−ν)/G of the materials that touch.
    pub fn reference_compliance(&self) -> f64 {
        self.surface.direct
    }

    /// Returns the surface kernels, prepared for distances up to `reach` between any point of the
    /// source and any of the receiver.
    pub fn kernels(&self, reach: f64) -> Kernels {
        match &self.layers {
            None => Kernels(Form::Closed(self.surface)),
            Some(layered) => {
                Kernels(Form::Tabulated(Box::new(Radial::new(layered, &self.surface, reach))))
            }
        }
    }

    /// Feeds every number that tells these bodies from others to `hasher`, bit for bit.
    pub(crate) fn hash_numbers(&self, hasher: &mut impl Hasher) {
        let HalfSpace { direct, cross, coupling } = self.surface;
        [direct, cross, coupling].map(f64::to_bits).hash(hasher);
        let Some(layered) = &self.layers else { return };
        for Layer { shear_modulus, poisson, thickness } in layered.layers() {
            [shear_modulus, poisson, thickness].map(|number| number.to_bits()).hash(hasher);
        }
        match layered.base() {
            Base::Rigid => {}
            Base::Elastic(Material { shear_modulus, poisson }) => {
                [shear_modulus, poisson].map(|number| number.to_bits()).hash(hasher);
            }
        }
    }
}

/// The surface kernels of [`Bodies`].
#[derive(Clone, Debug)]
pub struct Kernels(Form);

#[derive(Clone, Debug)]
enum Form {
    /// The closed form of a half-space.
    Closed(HalfSpace),
    /// The tables of a layered foundation.
    Tabulated(Box<Radial>),
}

impl Kernels {
    /// Returns the displacement of an element of size hx × hy, `offset` (Δi, Δj) elements away from
    /// the loaded one, receiver minus source, per unit traction; its unit is length × compliance.
    ///
    /// For a half-space it is as accurate as [`kernel::element`](super::kernel::element) says. For
    /// a layered foundation it is good to 1e-12 of the largest of nn, xx and yy, for layers of any
    /// thickness against the element and Ω down to 1e-6 of them; measured: 1e-14, and 4e-13 at a
    /// contrast of stiffness of 1e8. If a thin layer on a rigid base makes the coupling much
    /// smaller than those, the coupling is no better than they are in absolute terms.
    pub(crate) fn influence(
        &self,
        offset: [f64; 2],
        hx: f64,
        hy: f64,
        projection: Projection,
    ) -> Coefficient {
        match &self.0 {
            Form::Closed(bodies) => bodies.influence(offset, hx, hy, projection),
            Form::Tabulated(radial) => radial.influence(offset, hx, hy, projection),
        }
    }
}

/// Returns the bodies with moduli in units of that of the foundation's surface and lengths in units
/// of ℓ = `length`. The ratios to the surface's modulus, like the ratios of lengths to the width of
/// Ω in the layout of the mesh, are formed first, so that jobs that differ only in a modulus or a
/// size get the same operator to the last bit and can share it.
pub(crate) fn relative_bodies(scene: &Scene, length: f64) -> Bodies {
    let modulus = surface(scene).shear_modulus;
    let relative = |material: Material| Material {
        shear_modulus: material.shear_modulus / modulus,
        poisson: material.poisson,
    };
    let foundation = &scene.foundation;
    let layers: Vec<Layer> = foundation
        .layers
        .iter()
        .map(|layer| Layer {
            shear_modulus: layer.shear_modulus / modulus,
            thickness: layer.thickness / length,
            poisson: layer.poisson,
        })
        .collect();
    let base = match foundation.base {
        Base::Rigid => Base::Rigid,
        Base::Elastic(material) => Base::Elastic(relative(material)),
    };
    Bodies::new(&layers, &base, scene.punch.material.map(relative).as_ref())
}

/// Returns the material at the foundation's surface, whose modulus is the unit of moduli.
pub(crate) fn surface(scene: &Scene) -> Material {
    scene.foundation.surface().expect("Scene::validate refuses a rigid base without layers")
}

/// Returns Σ(1−ν)/G of the materials that touch \[1/Pa\].
pub(crate) fn surface_compliance(scene: &Scene) -> f64 {
    [scene.foundation.surface(), scene.punch.material]
        .iter()
        .flatten()
        .map(Material::compliance)
        .sum()
}

/// Returns the size of a contact whose dependence on the bodies' compliance Σ(1−ν)/G is `size`.
/// With layers, the compliance is the one that is felt at this size, k C_NN(k) at k = 1/size, and
/// the result is a fifth larger to be on the safe side of a rough guess.
pub(crate) fn contact_size(scene: &Scene, size: impl Fn(f64) -> f64) -> f64 {
    let mut contact = size(surface_compliance(scene));
    let foundation = &scene.foundation;
    let Some(layered) = Layered::new(&foundation.layers, &foundation.base) else { return contact };
    let punch = scene.punch.material.map_or(0.0, |material| material.compliance());
    for _ in 0..60 {
        let compliance = layered.compliance(1.0 / contact).nn / contact + punch;
        contact = (contact * size(compliance)).sqrt();
    }
    layered_margin(scene) * contact
}

/// Returns the factor by which [`contact_size`] is larger than its guess: 1 without layers.
pub(crate) fn layered_margin(scene: &Scene) -> f64 {
    let foundation = &scene.foundation;
    Layered::new(&foundation.layers, &foundation.base).map_or(1.0, |_| 1.2)
}
