//! The set US(A) of friction coefficients for which the contact problem has at most one solution
//! whatever the loads, and its end μ*.
//!
//! Knows [`model`](crate::model), [`grid`](crate::grid), [`influence`](crate::influence),
//! [`punch`](crate::punch) and [`problem`](crate::problem), which gives the operator; no solver and
//! no certificate of a contact. In reading order:
//! - `question`: the data that μ* depends on, and the effort of a search;
//! - `system`: the operator εI + A on the elements of Ω;
//! - `symmetry`: the symmetries of Ω, and the operator in a basis adapted to them;
//! - `barrier`: the weights that make the lower bound largest;
//! - `ratio`: the largest μ of given weights, by iteration;
//! - [`lower`]: the lower bound of μ*, and the check of its proof;
//! - [`cases`]: the lower bound by cases of open and closed elements;
//! - [`cones`]: the lower bound by cases whose fields are cut into cones;
//! - `exclusion`: the weights that exclude a cone for one μ, or a mixture of fields in it;
//! - `cone_search`: the search for cases and cones;
//! - [`branch`]: branches of that search, each with a proof of its own;
//! - [`witness`]: a field that shows an upper bound, and the check of it;
//! - `lbfgs`: minimisation of smooth functions of many variables;
//! - `descent`: local minimisation of F, for a witness;
//! - `newton`: Newton's method in it, for few elements;
//! - [`upper`]: the search for a witness, from many starts;
//! - `rate`: fields that need a friction in proportion to 1/√n, a test of the proof of that rate;
//! - `ball`: numbers with a bound of their error;
//! - [`strip`]: exact μ* of one row of elements in the plane of x and z;
//! - `bracket`: both sides of μ* at once;
//! - [`monotony`]: brackets held against those of larger domains;
//! - [`rolling`]: what is proved where nothing couples, in rolling too.
//!
//! # Definition
//! The source is A. I. Alexandrov, "The solution of elastic contact problems with the use of
//! nonlinear integral equations". There 𝔅_μ is the class of operators B that act at each point of Ω
//! as a 3×3 matrix with
//!
//! ```text
//! b₁₁ = c₁, b₂₁ = c₁a, b₃₁ = c₁b, b₁₂ = b₁₃ = 0, tangential block T(φ) diag(c₂, c₃) T(φ)ᵀ,
//! 0 ≤ c₁, c₂, c₃ ≤ 1, √(a² + b²) ≤ μ, c₃ (a² + b²) = 0,
//! US(A) = { μ > 0 : for some E > 0, Ker(B(I − EA) − I) = {0} for every B in 𝔅_μ }.
//! ```
//!
//! Two solutions of p = G_μ(p − E(Ap − f)) differ by an x with x = B(I − EA)x and B in 𝔅_μ. So for
//! μ in US(A) there is at most one, for every f. Here A is the discrete operator εI + A on the 3k
//! tractions of k elements, which is symmetric. It has no loads, no punch shape and no friction in
//! it, so μ* depends on the elastic bodies, Ω and its mesh alone.
//!
//! # A form without B and without E
//! Let y = Ax and z = x − Ey. At one element x = Bz is equivalent to two conditions:
//! - x₁ = c₁z₁ for some 0 ≤ c₁ ≤ 1, that is, x₁y₁ ≤ 0;
//! - x_t = x₁(a, b) + Tz_t. The vectors Tz_t are those d with |d|² ≤ d·z_t, since T is firmly
//!   nonexpansive; they fill the disk with diameter \[0, z_t\]. A T of rank one, c₃ = 0, reaches
//!   all of them, which is why c₃(a² + b²) = 0 takes nothing away. So x_t is at most μ|x₁| away
//!   from that disk: |x_t − z_t/2| ≤ |z_t|/2 + μ|x₁|, or |x_t + Ey_t| − |x_t − Ey_t| ≤ 2μ|x₁|.
//!
//! The left side is 4 x_t·y_t / (|x_t/E + y_t| + |x_t/E − y_t|). It has the sign of x_t·y_t, and
//! where that is positive it grows with E, to 2 x_t·y_t/|y_t|. Hence the least μ that an x needs,
//! whatever E is, is F(x) with
//!
//! ```text
//! F(x) = max over elements with x_t·y_t > 0 of x_t·y_t / (|x₁| |y_t|)
//!        (∞ where x₁ = 0 there, 0 without such elements),
//! μ* = min { F(x) : x ≠ 0, x₁y₁ ≤ 0 at every element }.
//! ```
//!
//! The derivation has to mind the following points, all of which are checked:
//! - For finite E the least μ of an x is *smaller* than F(x), F_E(x) ↑ F(x). So an x with F(x) = μ
//!   has a B in 𝔅_μ for *every* E > 0, which is what it takes to show μ ∉ US(A). A B for one E
//!   alone shows nothing, since US(A) asks for some E only.
//! - F_E is lower semicontinuous on the compact set of admissible unit x, and so is their supremum
//!   F: the minimum is attained (or +∞), and min F_E ↑ min F. US(A) is the open interval (0, μ*),
//!   to which μ* itself does not belong. For the operator on L₂ the minimum is an infimum only.
//! - y_t = 0 (stick) imposes nothing, and F jumps there: near it x_t·y_t/|y_t| takes any value up
//!   to |x_t|. A field computed in floating point must stay on the side x_t·y_t < 0.
//! - x₁ = 0 leaves no term μ|x₁|: such an element needs x_t·y_t ≤ 0, whatever μ is.
//! - Where A is positive definite (always in the average projection, or for ε > 0 large enough)
//!   F(x) = 0 is impossible, for it would make xᵀAx ≤ 0. So μ* > 0.
//! - Without normal–tangential coupling x₁ᵀA₁₁x₁ ≤ 0 forces x₁ = 0, hence x_tᵀA_tt x_t ≤ 0 and x =
//!   0. There is no admissible x at all, and μ* = ∞ exactly ([`Bracket::Unbounded`]).
//!
//! # Both sides
//! - The lower side is [`lower`]. If for weights α, β, τ > 0 per element the matrix sym(αΠ₁A) +
//!   sym(βΠ_tA) − (μ/2)(βτΠ₁ + AᵀΠ_t(β/τ)A) is positive definite, then μ < μ*: its form is at most
//!   Σ α x₁y₁ + β(x_t·y_t − μ|x₁||y_t|), and x ≠ 0 with F(x) ≤ μ would make that ≤ 0. This is the
//!   S-procedure; it is not lossless, so a gap may remain.
//! - The upper side is [`upper`]: an x with F(x) = μ. It is exact in itself, and turned into an
//!   explicit B for an explicit E. The best fields known are stripes.
//!
//! # Fields and units
//! Fields have three blocks n | x | y, each with one number per element *of Ω*, ascending; masked
//! elements have none. Everything is dimensionless as in [`crate::problem`]: lengths are in ℓ and
//! compliances in c, so E is in units of 1/cℓ and μ* has no unit.

mod ball;
mod barrier;
mod bracket;
pub mod branch;
pub mod cases;
mod cone_search;
pub mod cones;
pub mod cover;
mod descent;
mod exclusion;
mod lbfgs;
pub mod lower;
pub mod monotony;
mod newton;
mod question;
#[cfg(test)]
mod rate;
mod ratio;
pub mod rolling;
pub mod strip;
mod symmetry;
mod system;
pub mod upper;
pub mod witness;

pub use bracket::{Bracket, BracketError, bracket};
pub use question::{Question, Sole, WitnessSearch};
pub use system::System;
