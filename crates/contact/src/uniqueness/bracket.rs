//! The bracket: both sides of μ* at once.

use serde::{Deserialize, Serialize};

use super::cases::{self, CaseBound};
use super::cone_search;
use super::cones::ConeBound;
use super::lower::{self, LowerBound};
use super::question::{Question, WitnessSearch};
use super::strip::{self, StripBound, StripError};
use super::system::System;
use super::upper;
use super::witness::Witness;
use crate::model::{Mesh, SceneError};

/// The bracket of μ*.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Bracket {
    /// Pressures move nothing sideways, so μ* = ∞ exactly.
    Unbounded,
    /// μ* is between two numbers.
    Bounded {
        /// The lower bound: US(A) holds its μ, if it is [verified](LowerBound::verified).
        lower: LowerBound,
        /// The upper bound: US(A) does not hold its μ.
        upper: Witness,
    },
    /// μ* of a strip is between two numbers that are next to each other.
    Strip {
        /// The lower bound.
        lower: StripBound,
        /// The upper bound, a field in the plane of x and z.
        upper: Witness,
    },
    /// μ* is between two numbers, of which the lower one is shown by cases.
    Cases {
        /// The lower bound.
        lower: CaseBound,
        /// The upper bound.
        upper: Witness,
    },
    /// μ* is between two numbers, of which the lower one is shown by cases and cones.
    Cones {
        /// The lower bound.
        lower: ConeBound,
        /// The upper bound.
        upper: Witness,
    },
}

impl Bracket {
    /// Returns the lower and the upper end; `None` if there are none.
    pub fn ends(&self) -> Option<[f64; 2]> {
        match self {
            Bracket::Unbounded => None,
            Bracket::Bounded { lower, upper } => Some([lower.mu, upper.mu]),
            Bracket::Strip { lower, upper } => Some([lower.mu, upper.mu]),
            Bracket::Cases { lower, upper } => Some([lower.mu, upper.mu]),
            Bracket::Cones { lower, upper } => Some([lower.mu, upper.mu]),
        }
    }

    /// Returns the witness of the upper end; `None` if there is none.
    pub fn witness(&self) -> Option<&Witness> {
        match self {
            Bracket::Unbounded => None,
            Bracket::Bounded { upper, .. }
            | Bracket::Strip { upper, .. }
            | Bracket::Cases { upper, .. }
            | Bracket::Cones { upper, .. } => Some(upper),
        }
    }
}

/// The reason why there is no bracket.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BracketError {
    /// The question has no meaning.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// There is no certificate.
    #[error("no lower bound: {0}")]
    Lower(#[from] lower::LowerError),
    /// There is no witness.
    #[error("no upper bound: {0}")]
    Upper(#[from] upper::UpperError),
    /// There is no bracket of a strip.
    #[error("no bracket of the strip: {0}")]
    Strip(#[from] StripError),
}

/// The most elements for which every orbit gets weights of its own. Beyond, the weights are carried
/// over from a coarser mesh.
const DENSE_ELEMENTS: usize = 256;

/// Brackets μ* by a certificate with weights below and a witness above. Each side can be checked by
/// itself, by [`lower::verify`] and [`Witness::verify`]. A certificate with more than
/// [`lower::FACTORED_ROWS`] rows to factor is not checked, and proves nothing
/// ([`LowerBound::verified`]).
///
/// # Errors
/// A [`BracketError`] says that the question has no meaning, or that a side was not found.
pub fn bracket(question: &Question, search: &WitnessSearch) -> Result<Bracket, BracketError> {
    question.validate()?;
    search.suits(question)?;
    let system = System::new(question)?;
    if question.plane {
        return Ok(if system.is_coupled() {
            let (lower, upper) = strip::bracket(&system)?;
            Bracket::Strip { lower, upper }
        } else {
            Bracket::Unbounded
        });
    }
    if search.cases {
        if !system.is_coupled() {
            return Ok(Bracket::Unbounded);
        }
        if let Some(width) = search.width {
            return Ok(match upper::upper(question, search)? {
                upper::Upper::Bound(upper) => {
                    let lower = cone_search::bound(&system, upper.mu, width)?;
                    Bracket::Cones { lower, upper }
                }
                upper::Upper::Unbounded => Bracket::Unbounded,
            });
        }
        let lower = cases::bound(&system)?;
        return Ok(match upper::upper(question, search)? {
            upper::Upper::Bound(upper) => Bracket::Cases { lower, upper },
            upper::Upper::Unbounded => Bracket::Unbounded,
        });
    }
    match (lower_side(question, &system)?, upper::upper(question, search)?) {
        (lower::Lower::Bound(lower), upper::Upper::Bound(upper)) => {
            Ok(Bracket::Bounded { lower, upper })
        }
        _ => Ok(Bracket::Unbounded),
    }
}

fn lower_side(question: &Question, system: &System) -> Result<lower::Lower, BracketError> {
    let mut elements = [system.grid().nx(), system.grid().ny()];
    if system.elements() <= DENSE_ELEMENTS {
        return Ok(lower::lower(system, lower::Freedom::PerOrbit)?);
    }
    while elements[0] * elements[1] > DENSE_ELEMENTS {
        elements = elements.map(|n| n.div_ceil(2));
    }
    let coarse = System::new(&Question {
        mesh: Mesh::Exact(elements.map(|n| n as u32)),
        ..question.clone()
    })?;
    match lower::lower(&coarse, lower::Freedom::PerOrbit)? {
        lower::Lower::Unbounded => Ok(lower::Lower::Unbounded),
        lower::Lower::Bound(bound) => {
            Ok(lower::lower_from(system, &coarse, &bound, lower::FACTORED_ROWS)?)
        }
    }
}
