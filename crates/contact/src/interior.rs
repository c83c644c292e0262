//! The stresses below the surface of the foundation, from the tractions on it.
//!
//! The folder uses the [`foundation`](crate::foundation) for the stresses under one element, the
//! data of [`model`](crate::model) and the tools of `common` and of `influence`; it knows no
//! solver: tractions go in, stresses come out. In reading order:
//! - `invariants`: principal stresses and what is made of them;
//! - `loaded`: the elements that carry tractions, and direct sums over them ([`Subsurface`]);
//! - `plane`: the stresses on a whole plane by Fourier transforms;
//! - `section`: the stresses on a section down from the surface;
//! - `balance`: residuals of stresses, by other ways to the same numbers;
//! - `peak`: a place where a function of the place is largest;
//! - `search`: the largest stresses ([`examine`]).

mod balance;
mod invariants;
mod loaded;
mod peak;
mod plane;
mod search;
mod section;

pub use loaded::{PlaneStress, Subsurface};
pub(crate) use search::depths_searched;
pub use search::examine;
pub use section::SectionStress;
