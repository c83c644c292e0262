//! What the crate promises, by kind of claim. One binary, so that the linear algebra is linked
//! once; `common` has the scenes and files that the modules share.

mod agreement;
mod beyond_uniqueness;
mod closed_forms;
mod common;
mod convergence;
mod effects;
mod estimate;
mod foundations;
mod hard_cases;
mod laws;
mod layered_influence;
mod multiplicity;
mod paths;
mod peers;
mod uniqueness_lower;
mod uniqueness_upper;
mod wheel_rail;
