//! These tests hold the crate to its promises. Each module holds one kind of claim. They are one
//! binary, so that the linear algebra is linked once.
//!
//! A change in a layer of `src` is held by these modules, beside the tests in the source itself:
//!
//! | layer | modules |
//! |---|---|
//! | `model` | `hard_cases` (refusals of scenes and numerics), `effects` (the list of effects) |
//! | `theory` | `closed_forms`, `convergence` (orders from ladders), `paths` |
//! | `common` | the tests on any number of threads in `agreement`, `multiplicity`, `uniqueness_*` |
//! | `foundation` | `layered_influence`, `foundations` |
//! | `grid` | `layered_influence`, `convergence` (distances between grids) |
//! | `punch` | `wheel_rail`, `wheel_creepage`, `height_maps`, `closed_forms` (shapes), `hard_cases` (chosen Ω) |
//! | `influence` | `layered_influence`, `peers` (coefficients of layers) |
//! | `problem` | `effects` (reductions), `laws` (units, shared operators), `hard_cases` (range) |
//! | `solver` | `agreement`, `beyond_uniqueness`, `peers`, `rolling`, `hard_cases` |
//! | `assess` | `laws` (the certificate), `convergence` (norms, errors), `estimate` |
//! | `interior` | `interior` |
//! | `path` | `paths`, `watched`, `peers`, `rolling`, `wear`, `hard_cases` (a cycle of 200 steps) |
//! | `uniqueness` | `uniqueness_lower`, `uniqueness_upper` |
//! | `multiplicity` | `multiplicity` |
//! | `forecast` | `laws` (a forecast refuses what the problem refuses) |

/// Different methods and controls lead to the same solution.
mod agreement;
/// Large friction ends in a solution or in words and figures, within the limits of a solve.
mod beyond_uniqueness;
/// Figures meet closed forms and tables, with the observed order of convergence.
mod closed_forms;
/// The scenes, solves and files that the modules share.
mod common;
/// Fields converge with the mesh and with ε, measured in norms.
mod convergence;
/// A reduced problem has the solution of the full one.
mod effects;
/// Estimates cover the true errors.
mod estimate;
/// Layered foundations meet solutions without boundary elements, and obey the laws of layers.
mod foundations;
/// Scenes at the limits of double precision and of mechanics are solved, or refused in words.
mod hard_cases;
/// A height map is one smooth surface for every mesh and projection.
mod height_maps;
/// Stresses below the surface meet closed forms and references, and obey the laws of elasticity.
mod interior;
/// Laws hold of every solution, and the certificate notices every kind of wrong answer.
mod laws;
/// Influence coefficients of layers meet reference values and limits.
mod layered_influence;
/// A search finds one solution where theory has one, and several where it allows them.
mod multiplicity;
/// Loading paths meet theory, balance energy, and say where they end.
mod paths;
/// Other programs have the same solutions of the same discrete problem.
mod peers;
/// Two other programs have the same states and paths of contacts that roll.
mod rolling;
/// Lower ends by cones come as near to witnesses as is asked for, and wrong ones are refused.
mod uniqueness_branches;
/// Lower ends by cases come nearer to witnesses, and wrong ones are refused.
mod uniqueness_cases;
mod uniqueness_cones;
/// Lower ends of the bracket of μ* meet a prototype, and their proofs stand.
mod uniqueness_lower;
/// μ* of strips is exact, and wrong brackets of it are refused.
mod uniqueness_strip;
/// Upper ends of the bracket of μ* are as low as known, and wrong witnesses are refused.
mod uniqueness_upper;
/// A path that is watched shows its increments, their discrete problems, and ends on request.
mod watched;
/// Wear obeys Archard's law, on the shape as it is and on the shape that is left.
mod wear;
/// The creepages of a wheel meet CONTACT, and so do its creep forces.
mod wheel_creepage;
/// A wheel on a rail meets CONTACT's benchmark and Hertz.
mod wheel_rail;
