//! The punch's geometry: initial gap g₀, its mean over an element, the sole, and the Ω that a shape
//! calls for.

mod contact_plane;
mod curve;
mod domain;
mod gap;
mod profile;
mod surface;
mod track;
mod wheel_rail;

pub use contact_plane::{ContactPlane, Extent};
pub use curve::{Curve, CurvePoint};
pub use domain::domain;
pub use gap::Gap;
pub use profile::{Profile, ProfileError, ProfileKind};
pub use surface::{Surface, SurfaceError, Surfaces};
pub use track::{Frame, Position, Track, WheelRailError, Wheelset};
pub use wheel_rail::{Curvatures, Touch, WheelOnRail};
