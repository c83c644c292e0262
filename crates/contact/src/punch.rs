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
//! - `overlap`: the regions in which a lowered wheel would overlap its rail, and their frames;
//! - `facet`: the distance between the two along the normal of one plane;
//! - `contact_plane`: the gap between the two, with a plane for each patch;
//! - `placement`: the depth to which a scene lowers its wheel;
//! - `gap`: g₀ of every shape, at a point and as a mean over an element;
//! - `domain`: the Ω of a scene;
//! - `rail_place`: the places on a rail that belong to points of Ω;
//! - `wheel_creepage`: the creepages of a wheel, from the motion of its wheelset.

mod contact_plane;
mod curve;
mod domain;
mod facet;
mod gap;
mod interpolant;
mod overlap;
mod placement;
mod profile;
mod rail_place;
mod surface;
mod track;
mod wheel_creepage;
mod wheel_rail;

pub use contact_plane::ContactPlane;
pub use curve::Curve;
pub use domain::domain;
pub(crate) use domain::domain_under;
pub use facet::Extent;
pub(crate) use gap::Gap;
pub(crate) use placement::PlacedWheel;
pub use profile::{LineFaults, Profile, ProfileError, ProfileKind, ReadProfile};
pub use rail_place::{RailPlace, rail_places};
pub use surface::{Surface, SurfaceError, Surfaces};
pub use track::{Frame, Position, Track, WheelRailError, Wheelset};
pub(crate) use wheel_creepage::with_creepages;
pub use wheel_creepage::{WheelCreepages, wheel_creepages};
pub use wheel_rail::{Curvatures, WheelOnRail};
