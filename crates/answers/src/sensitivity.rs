//! Sensitivity: how much each input of a design moves an output.
//!
//! The files below are about numbers alone: `sobol` has the shares of the variance, `morris` the
//! elementary effects. They know statistics and no study.

pub(crate) mod morris;
#[cfg(test)]
mod references;
pub(crate) mod sobol;
