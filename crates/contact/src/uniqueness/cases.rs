//! A lower bound of μ* by cases: every element is either open or closed.
//!
//! # Cases lose nothing
//! It follows from [`super`] that μ ≥ μ* if and only if there are numbers 0 ≤ c ≤ 1, |m| ≤ μ and
//! symmetric 2 × 2 matrices 0 ⪯ C ⪯ 1 at each element for which some x ≠ 0 meets
//!
//! ```text
//! (1 − c) x₁ + c y₁ = 0,    (1 − C)(x_t − m x₁) + C y_t = 0    with y = Ax:
//! ```
//!
//! the first says that x₁y₁ ≤ 0, and the second that y_t·(x_t − m x₁) ≤ 0 for some |m| ≤ μ. The
//! determinant of these rows is 1 where all of the numbers are 0 and nowhere 0 below μ*, so it is
//! positive there, and at μ* the least it takes is 0. A number c stands in one row, linearly. So
//! where the determinant is 0 for a c inside of its range, it is 0 at both ends, for it is affine
//! in c and nowhere negative. Element by element, each c can be moved to 0 or 1: at μ* there is an
//! x ≠ 0 with x₁ = 0 (open) or y₁ = 0 (closed) at every element.
//!
//! # The certificate
//! To show μ < μ* it is enough to exclude each combination of open and closed elements, for this μ
//! and every smaller one. In a case the form F(μ) of [`lower`] may be enlarged by the squares that
//! vanish in it,
//!
//! ```text
//! F(μ) + κ_u Σ y₁² over closed elements + κ_s Σ x₁² over open ones,    κ_u, κ_s ≥ 0,
//! ```
//!
//! and if that is positive definite there is no x with F(x) ≤ μ in the case. The weights are
//! those of the case. Where elements are left undecided, a proof holds for all their cases at
//! once, and for the images of all under the symmetries of Ω, so most of 2ᵏ combinations are
//! never looked at. The penalties κ are finite numbers and part of the proof: no limit is
//! taken. Weights are constant on the orbits of elements under the symmetries that keep the
//! case. The share of the rounding that is due to symmetry ([`lower`]) counts in every case, for
//! its images.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};

use super::barrier::{NormalPenalty, Program, Weights};
use super::cover::{self, CaseBits, CoverError, NormalCase, from_the_middle};
use super::lower::{self, Freedom, LowerBound, LowerError};
use super::symmetry::{Block, Symmetries};
use super::system::System;

/// A case and the weights that exclude it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExcludedCase {
    /// The state of each element of Ω.
    pub states: Vec<NormalCase>,
    /// The weight α ≥ 0 of each orbit of elements under the symmetries that keep the case.
    pub alpha: Vec<f64>,
    /// The weight β > 0 of each orbit.
    pub beta: Vec<f64>,
    /// The weight τ > 0 of each orbit, in units of cℓ.
    pub tau: Vec<f64>,
    /// The penalty κ_u ≥ 0 of displacements of closed elements, in units of 1/cℓ.
    pub displacement_penalty: f64,
    /// The penalty κ_s ≥ 0 of pressures of open elements, in units of cℓ.
    pub pressure_penalty: f64,
}

/// Cases that are excluded for a μ and leave none out, so that μ < μ*.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseBound {
    /// The friction coefficient μ.
    pub mu: f64,
    /// The excluded cases.
    pub cases: Vec<ExcludedCase>,
}

/// The reason why cases prove nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CaseError {
    /// The cases leave some out, or are none of Ω.
    #[error(transparent)]
    Cover(#[from] CoverError),
    /// The numbers of a case have no meaning.
    #[error("case {case}: {reason}")]
    Numbers {
        /// The index of the case.
        case: usize,
        /// The number and what it must be.
        reason: String,
    },
    /// The friction coefficient μ has no meaning.
    #[error("mu = {mu:e}: it must be finite and above 0")]
    Mu {
        /// The value of μ.
        mu: f64,
    },
    /// The form of a case is not positive definite, or not by more than rounding.
    #[error("case {case} is not excluded for mu = {mu}: its form has no Cholesky factor")]
    NotExcluded {
        /// The index of the case.
        case: usize,
        /// The friction coefficient μ.
        mu: f64,
    },
}

/// The largest number of cases that are tried for one μ.
const MOST_TRIED: usize = 3000;

/// The share by which the bound may stay below the one of the case in which all are closed, so that
/// the others take fewer cases.
const SLACK: f64 = 1e-3;

/// The penalties over the mean weight α of the root, in units of the operator's largest diagonal
/// entry.
const PENALTY: f64 = 300.0;

/// The relative accuracy to which weights are optimised.
const TOLERANCE: f64 = 1e-4;

/// A case with its operator.
struct DecidedCase {
    states: Vec<NormalCase>,
    /// The orbit of each element.
    orbit: Vec<usize>,
    /// The number of elements in each orbit.
    sizes: Vec<usize>,
    blocks: Vec<Block>,
}

impl DecidedCase {
    fn of(system: &System, states: Vec<NormalCase>) -> Self {
        let symmetries = Symmetries::of(system, |a, b| states[a] == states[b]);
        let orbit = symmetries.orbits(system);
        let mut sizes = vec![0; orbit.iter().max().map_or(0, |last| last + 1)];
        orbit.iter().for_each(|&o| sizes[o] += 1);
        let blocks = symmetries.blocks(system);
        Self { states, orbit, sizes, blocks }
    }

    /// Returns the penalty of each orbit.
    fn penalty(&self, displacement: f64, pressure: f64) -> NormalPenalty {
        let mut penalty = NormalPenalty {
            displacement: vec![0.0; self.sizes.len()],
            pressure: vec![0.0; self.sizes.len()],
        };
        for (state, &orbit) in self.states.iter().zip(&self.orbit) {
            match state {
                NormalCase::Undecided => {}
                NormalCase::Open => penalty.pressure[orbit] = pressure,
                NormalCase::Closed => penalty.displacement[orbit] = displacement,
            }
        }
        penalty
    }

    /// Returns one number for each orbit from one for each element.
    fn of_orbits(&self, of_elements: &[f64]) -> Vec<f64> {
        let mut of_orbits = vec![0.0; self.sizes.len()];
        self.orbit.iter().zip(of_elements).for_each(|(&orbit, &value)| of_orbits[orbit] = value);
        of_orbits
    }

    /// Returns one number for each element from one for each orbit.
    fn of_elements(&self, of_orbits: &[f64]) -> Vec<f64> {
        self.orbit.iter().map(|&orbit| of_orbits[orbit]).collect()
    }

    /// Says if weights exclude the case. The `asymmetry` is that of Ω, whatever the case's.
    fn is_excluded(
        &self,
        asymmetry: f64,
        weights: &LowerBound,
        penalties: [f64; 2],
        mu: f64,
    ) -> bool {
        lower::is_positive_in_case(
            &self.blocks,
            asymmetry,
            &LowerBound { mu, ..weights.clone() },
            Some(&self.penalty(penalties[0], penalties[1])),
        )
    }
}

/// The weights for each element that every case begins with. They have all symmetries of Ω, which
/// those of another case need not have.
struct CaseStart {
    alpha: Vec<f64>,
    beta: Vec<f64>,
    p: Vec<f64>,
    q: Vec<f64>,
}

/// The search for cases that exclude all.
struct CaseSearch<'a> {
    system: &'a System,
    asymmetry: f64,
    /// The images of all elements under the symmetries of Ω.
    images: Vec<Vec<usize>>,
    /// The cases looked at, each as the least of its images.
    seen: HashSet<CaseBits>,
    start: CaseStart,
    penalties: [f64; 2],
    /// The elements in the order in which they are decided: those in the middle come first.
    order: Vec<usize>,
    mu: f64,
    tried: usize,
    cases: Vec<ExcludedCase>,
}

impl CaseSearch<'_> {
    /// Finds the best weights of a case. It stops early where they exclude the case for `enough`.
    fn weights(&self, case: &DecidedCase, enough: f64) -> Option<LowerBound> {
        let weights = Weights {
            alpha: case.of_orbits(&self.start.alpha),
            beta: case.of_orbits(&self.start.beta),
            p: case.of_orbits(&self.start.p),
            q: case.of_orbits(&self.start.q),
        };
        let penalty = case.penalty(self.penalties[0], self.penalties[1]);
        let program = Program { blocks: &case.blocks, sizes: &case.sizes, penalty: Some(&penalty) };
        let found = program.maximise_until(weights, TOLERANCE, enough)?;
        Some(LowerBound {
            mu: 0.0,
            tau: found.tau(),
            alpha: found.alpha,
            beta: found.beta,
            verified: true,
        })
    }

    /// Excludes a case, or all cases that it falls into. It returns false where too many are tried.
    fn exclude(&mut self, states: Vec<NormalCase>) -> bool {
        let image = self.images.iter().map(|image| CaseBits::of_image(&states, image)).min();
        if image.is_some_and(|bits| !self.seen.insert(bits)) {
            // It is the image of a case that is excluded, or whose parts are.
            return true;
        }
        self.tried += 1;
        if self.tried > MOST_TRIED {
            return false;
        }
        let case = DecidedCase::of(self.system, states);
        // A little more than the bound leaves room for rounding.
        let Some(weights) = self.weights(&case, self.mu * (1.0 + 1e-4)) else {
            return false;
        };
        let undecided =
            self.order.iter().copied().find(|&e| case.states[e] == NormalCase::Undecided);
        let mut is_excluded = case.is_excluded(self.asymmetry, &weights, self.penalties, self.mu);
        while !is_excluded && undecided.is_none() {
            // Nothing is left to decide: the bound is that of this case.
            self.mu *= 1.0 - 1e-3;
            if self.mu < 1e-12 {
                return false;
            }
            is_excluded = case.is_excluded(self.asymmetry, &weights, self.penalties, self.mu);
        }
        if is_excluded {
            self.cases.push(ExcludedCase {
                states: case.states,
                alpha: weights.alpha,
                beta: weights.beta,
                tau: weights.tau,
                displacement_penalty: self.penalties[0],
                pressure_penalty: self.penalties[1],
            });
            return true;
        }
        let Some(element) = undecided else { return false };
        [NormalCase::Closed, NormalCase::Open].into_iter().all(|state| {
            let mut states = case.states.clone();
            states[element] = state;
            self.exclude(states)
        })
    }
}

/// Computes a lower bound by cases, of a coupled system of few elements.
///
/// # Errors
/// A [`LowerError`] says that the operator is not positive definite, or that the weights found
/// prove nothing.
pub(super) fn bound(system: &System) -> Result<CaseBound, LowerError> {
    let elements = system.elements();
    let useless = LowerError::Weights { elements };
    let root = match lower::lower(system, Freedom::PerOrbit)? {
        lower::Lower::Bound(root) => root,
        lower::Lower::Unbounded => return Err(useless),
    };
    let all = DecidedCase::of(system, vec![NormalCase::Undecided; elements]);
    // The weights of the root prove less of friction by a third all the more strictly.
    let mu = 0.7 * root.mu;
    let products = |of: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        root.beta.iter().zip(&root.tau).map(|(beta, tau)| mu * of(*beta, *tau)).collect()
    };
    let start = CaseStart {
        alpha: all.of_elements(&root.alpha),
        beta: all.of_elements(&root.beta),
        p: all.of_elements(&products(&|beta, tau| beta * tau)),
        q: all.of_elements(&products(&|beta, tau| beta / tau)),
    };
    let symmetries = Symmetries::of(system, |_, _| true);
    let asymmetry = lower::asymmetry_norm(system, symmetries);
    let diagonal = system.largest_diagonal();
    let alpha = start.alpha.iter().sum::<f64>() / elements as f64;
    let mut search = CaseSearch {
        system,
        asymmetry,
        images: symmetries.images(system),
        seen: HashSet::new(),
        start,
        penalties: [PENALTY * alpha / diagonal, PENALTY * alpha * diagonal],
        order: from_the_middle(system),
        mu: 0.0,
        tried: 0,
        cases: Vec::new(),
    };
    let closed = DecidedCase::of(system, vec![NormalCase::Closed; elements]);
    let weights = search.weights(&closed, f64::INFINITY).ok_or(useless)?;
    let proves = |mu: f64| closed.is_excluded(asymmetry, &weights, search.penalties, mu);
    let (mut low, mut high) = (root.mu, 4.0 * root.mu);
    for _ in 0..40 {
        let mu = 0.5 * (low + high);
        if proves(mu) { low = mu } else { high = mu }
    }
    let mut goal = low * (1.0 - SLACK);
    while goal > root.mu {
        (search.mu, search.tried) = (goal, 0);
        search.cases.clear();
        search.seen.clear();
        if search.exclude(vec![NormalCase::Undecided; elements]) {
            return Ok(CaseBound { mu: search.mu, cases: search.cases });
        }
        goal = if goal > 1.001 * root.mu { 0.5 * (goal + root.mu) } else { 0.0 };
    }
    // Without cases it is the bound of the root, with one case for all.
    search.cases = vec![ExcludedCase {
        states: all.states,
        alpha: root.alpha,
        beta: root.beta,
        tau: root.tau,
        displacement_penalty: 0.0,
        pressure_penalty: 0.0,
    }];
    Ok(CaseBound { mu: root.mu, cases: search.cases })
}

/// Shows that every case is excluded, rounding included.
///
/// # Errors
/// A [`CaseError`] says that numbers have no meaning, that cases are missing, or that one is not
/// excluded.
pub fn verify(system: &System, bound: &CaseBound) -> Result<(), CaseError> {
    if !(bound.mu.is_finite() && bound.mu > 0.0) {
        return Err(CaseError::Mu { mu: bound.mu });
    }
    let states: Vec<&[NormalCase]> = bound.cases.iter().map(|case| &case.states[..]).collect();
    cover::check_states(system, &states)?;
    for (index, case) in bound.cases.iter().enumerate() {
        let penalties = [case.displacement_penalty, case.pressure_penalty];
        if let Some(value) = penalties.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
            let reason = format!("a penalty is {value:e}: it must be finite and at least 0");
            return Err(CaseError::Numbers { case: index, reason });
        }
    }
    let symmetries = Symmetries::of(system, |_, _| true);
    cover::check_cover(system, symmetries, &states, &[])?;
    let asymmetry = lower::asymmetry_norm(system, symmetries);
    for (index, excluded) in bound.cases.iter().enumerate() {
        let case = DecidedCase::of(system, excluded.states.clone());
        let weights = LowerBound {
            mu: bound.mu,
            alpha: excluded.alpha.clone(),
            beta: excluded.beta.clone(),
            tau: excluded.tau.clone(),
            verified: false,
        };
        lower::check_weights(&weights, case.sizes.len())
            .map_err(|error| CaseError::Numbers { case: index, reason: error.to_string() })?;
        let penalties = [excluded.displacement_penalty, excluded.pressure_penalty];
        if !case.is_excluded(asymmetry, &weights, penalties, bound.mu) {
            return Err(CaseError::NotExcluded { case: index, mu: bound.mu });
        }
    }
    Ok(())
}
