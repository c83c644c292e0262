//! The bottom of the crate: classical formulas with their sources, and the laws that a ladder of
//! values follows. Numbers go in, numbers come out.
//!
//! The folder knows no grid, no scene and no other part of the crate.
//!
//! In reading order:
//! - `formulas`: the classical solutions of contact on a half-space, from Hertz to Reissner and
//!   Sagoci;
//! - `kalker`: the coefficients of the linear theory of rolling;
//! - `creep`: forces from creepages and back, linear and saturating;
//! - `carter`: the rolling line contact;
//! - `ladder`: the limit of a ladder of values by Richardson extrapolation, and a power law through
//!   it.

mod carter;
mod creep;
mod formulas;
mod kalker;
mod ladder;

pub use carter::Carter;
pub use creep::{CreepForces, LinearCreep, saturated, unsaturated};
pub use formulas::{
    HertzEllipse, Indentation, cattaneo_shift, cattaneo_stick_ratio, cone, flat_disk,
    full_stick_load_ratio, hertz_curvatures, hertz_ellipse, hertz_sphere, mindlin_deresiewicz_loss,
    shifted_disk, tilted_disk, twisted_disk,
};
pub use kalker::KalkerCoefficients;
pub use ladder::{LadderError, Limit, PowerLaw, Trend, power_law, richardson};
