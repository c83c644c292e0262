//! The geometry of the punch: the initial gap g₀, its mean over an element, the sole, and the Ω
//! that a shape calls for.
//!
//! Knows [`model`](crate::model), [`theory`](crate::theory) and [`foundation`](crate::foundation);
//! no grid and no operator. In reading order:
//! - `interpolant`: the smooth surface through the pixels of a height map;
//! - `surface`: height maps, and the collection of all height maps and profiles;
//! - `curve`: smooth plane curves and their graphs over a direction;
//! - `profile`: cross-sections of rails and wheels, and the text formats in which they come;
//! - `track`: positions of rails and wheelsets, and the frame of the plane of contact;
//! - `wheel_rail`: the points at which a wheel touches a rail;
//! - `contact_plane`: the gap between the two along the normal of a plane;
//! - `gap`: g₀ of every shape, at a point and as a mean over an element;
//! - `domain`: the Ω of a scene.

mod contact_plane;
mod curve;
mod domain;
mod gap;
mod interpolant;
mod profile;
mod surface;
mod track;
mod wheel_rail;

pub use contact_plane::{ContactPlane, Extent};
pub use curve::Curve;
pub use domain::domain;
pub(crate) use gap::Gap;
pub use profile::{LineFaults, Profile, ProfileError, ProfileKind, ReadProfile};
pub use surface::{Surface, SurfaceError, Surfaces};
pub use track::{Frame, Position, Track, WheelRailError, Wheelset};
pub use wheel_rail::{Curvatures, WheelOnRail};
