//! The influence operator A: tractions on Ω to displacements of Ω, p ↦ A p.
//!
//! - [`InfluenceTable`]: the coefficients, one block per offset (Δi, Δj);
//! - [`Influence`]: an operator made of them, [`Dense`] (the oracle, small grids) or [`Toeplitz`]
//!   (FFT, all others), on some [`Components`] only, and on the half or quarter of the grid that a
//!   [`Mirror`] leaves.

mod circulant;
mod components;
mod convolution;
mod dense;
#[cfg(test)]
mod laws;
mod mirror;
mod operator;
mod symbols;
mod table;
mod toeplitz;
mod torus;
mod window;

pub use circulant::Circulant;
pub use components::{Components, Direction, Entry};
pub use dense::Dense;
pub use mirror::{Mirror, MirrorError, Symmetry};
pub(crate) use mirror::{images, weighted_images};
pub use operator::{Influence, Scratch, ScratchSize};
pub use table::{Diagonals, InfluenceTable};
pub use toeplitz::Toeplitz;
pub(crate) use window::Window;
