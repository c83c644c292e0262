//! Formulas with their sources, and what a ladder of values tells: numbers in, numbers out.
//!
//! Knows no grid and no scene, and nothing of the crate above it.

mod formulas;
mod ladder;

pub use formulas::{
    HertzEllipse, Indentation, cattaneo_shift, cattaneo_stick_ratio, cone, flat_disk,
    full_stick_load_ratio, hertz_ellipse, hertz_sphere, mindlin_deresiewicz_loss, shifted_disk,
    tilted_disk, twisted_disk,
};
pub use ladder::{LadderError, Limit, PowerLaw, Trend, power_law, richardson};
