//! The influence operator A: tractions on Ω to displacements of Ω, p ↦ A p.
//!
//! The folder uses the [`foundation`](crate::foundation) for coefficients, the
//! [`grid`](crate::grid), the data of [`model`](crate::model) and the tools of `common`; it knows
//! no scene, no punch and no solver.
//!
//! In reading order:
//! - `components`: the components of traction and displacement on which an operator acts
//!   ([`Components`], `Direction`);
//! - `mirror`: planes of symmetry, and the half or quarter of a grid that a [`Mirror`] leaves;
//! - `table`: the coefficients, one block per offset (Δi, Δj) ([`InfluenceTable`]);
//! - `operator`: the trait [`Influence`] of an operator made of them, and its memory ([`Scratch`]);
//! - `dense`: the operator as a matrix ([`Dense`]), the oracle for small grids;
//! - `torus`: a torus of elements and the transforms of a field on it;
//! - `symbols`: the transform of a coefficient on a torus;
//! - `convolution`: the product with symbols in a torus's Fourier space;
//! - `toeplitz`: the operator by FFT ([`Toeplitz`]), for all other grids;
//! - `matrix_symbols`: the transform of a coefficient that has no symmetry along x;
//! - `rolling`: the operator of a contact that rolls steadily (`RollingToeplitz`), by FFT;
//! - `circulant`: the preconditioner of the Krylov iterations ([`Circulant`]);
//! - `window`: the part of a grid around a contact;
//! - `laws`: the laws that every operator obeys, as tests.

mod circulant;
mod components;
mod convolution;
mod dense;
#[cfg(test)]
mod laws;
mod matrix_symbols;
mod mirror;
mod operator;
mod rolling;
mod symbols;
mod table;
mod toeplitz;
mod torus;
mod window;

pub use circulant::Circulant;
pub use components::Components;
pub(crate) use components::{Direction, Entry};
pub use dense::Dense;
pub(crate) use mirror::MirrorError;
pub use mirror::{Mirror, Symmetry};
pub(crate) use mirror::{images, weighted_images};
pub use operator::{Influence, Scratch, ScratchSize};
pub(crate) use rolling::{RollingTables, RollingToeplitz};
pub use table::{Diagonals, InfluenceTable};
pub use toeplitz::Toeplitz;
pub(crate) use torus::suitable_length;
pub(crate) use window::Window;
