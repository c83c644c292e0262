//! The elasticity of the bodies as seen from the plane of contact: displacement under a loaded
//! boundary element.
//!
//! The folder uses the data of [`model`](crate::model) and the tools of `common`; it knows no grid
//! and no operator.
//!
//! In reading order:
//! - `coefficient`: the six different entries of a 3 × 3 block of surface kernels;
//! - `kernel`: integrals of surface kernels over loaded rectangles;
//! - `half_space`: the homogeneous half-space, or two of them pressed together;
//! - `layered`: bonded layers in the Fourier plane;
//! - `hankel`: Hankel transforms on a logarithmic grid of wavenumbers;
//! - `radial`: the tabulated kernels of a layered foundation;
//! - `bodies`: foundation and punch together, and their scales;
//! - `rectangle`: stresses in a half-space under a loaded rectangle;
//! - `layered_stress`: stresses in bonded layers in the Fourier plane;
//! - `subsurface`: stresses at a depth under a loaded rectangle, in any foundation.

mod bodies;
mod coefficient;
mod half_space;
mod hankel;
mod kernel;
mod layered;
mod layered_stress;
mod radial;
mod rectangle;
mod subsurface;

pub use bodies::{Bodies, Kernels};
pub(crate) use bodies::{
    contact_size, layered_margin, relative_bodies, surface, surface_compliance,
};
pub use coefficient::Coefficient;
pub use half_space::HalfSpace;
pub use layered::Layered;
pub(crate) use layered_stress::DepthSide;
pub(crate) use rectangle::StressBlock;
pub(crate) use subsurface::{StressKernels, interfaces, longest_length};
