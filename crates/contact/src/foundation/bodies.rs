//! The elasticity of both bodies as it is felt in the plane of contact.

use super::coefficient::Coefficient;
use super::half_space::HalfSpace;
use super::layered::Layered;
use super::radial::Radial;
use crate::model::{Base, Layer, Material, Projection};

/// A foundation, layered or not, and the punch on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bodies {
    /// The material at the foundation's surface, as a half-space, and the punch: all there is
    /// without layers, and what is felt close to a load with them.
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
    /// Layers from the surface down, what they rest on, and the punch (`None`: rigid). The layers'
    /// thicknesses are in the unit of length of the grid that the bodies will be used with. Layers
    /// of one material are one layer, and those of the base's material none.
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

    /// The same bodies in another unit of compliance.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            surface: self.surface.scaled(factor),
            layers: self.layers.as_ref().map(|layers| layers.scaled(factor)),
        }
    }

    /// c = Σ (1−ν)/G of the materials that touch.
    pub fn reference_compliance(&self) -> f64 {
        self.surface.direct
    }

    /// The surface kernels, prepared for distances up to `reach` between any point of the source
    /// and any of the receiver.
    pub fn kernels(&self, reach: f64) -> Kernels {
        match &self.layers {
            None => Kernels(Form::Closed(self.surface)),
            Some(layered) => {
                Kernels(Form::Tabulated(Box::new(Radial::new(layered, &self.surface, reach))))
            }
        }
    }
}

/// The surface kernels of [`Bodies`].
#[derive(Clone, Debug)]
pub struct Kernels(Form);

#[derive(Clone, Debug)]
enum Form {
    Closed(HalfSpace),
    Tabulated(Box<Radial>),
}

impl Kernels {
    /// Displacement of an element of size hx × hy, `offset` (Δi, Δj) elements away from the loaded
    /// one, receiver minus source, per unit traction; its unit is length × compliance.
    ///
    /// A half-space's is as good as [`kernel::element`](super::kernel::element) says. A layered
    /// foundation's is good to 1e-12 of the largest of nn, xx and yy, for layers of any thickness
    /// against the element and Ω down to 1e-6 of them; measured: 1e-14, and 4e-13 at a contrast of
    /// stiffness of 1e8. Where a thin layer on a rigid base makes the coupling much smaller than
    /// those, it is no better than they are in absolute terms.
    pub fn influence(
        &self,
        offset: [i64; 2],
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
