//! The body of a profile, the points that a text gives of it, and the reasons why it gives none.

use super::words::LineFaults;

/// The body that a profile belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileKind {
    /// The cross-section of a rail.
    Rail,
    /// The cross-section of a wheel in a plane through its axis.
    Wheel,
}

impl ProfileKind {
    /// Returns the name of the body with its article.
    pub fn noun(self) -> &'static str {
        match self {
            ProfileKind::Rail => "a rail",
            ProfileKind::Wheel => "a wheel",
        }
    }
}

/// The points of a profile as a text gives them.
pub(super) struct ReadPoints {
    pub(super) kind: ProfileKind,
    /// The points (y, z) \[m\].
    pub(super) points: Vec<[f64; 2]>,
    /// The format and what was done to the points, in words.
    pub(super) note: String,
}

/// The reason why a text or a list of points is no profile.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// Lines cannot be read in this format.
    #[error("{0}")]
    Lines(LineFaults),
    /// Something that must be there is missing.
    #[error("there is no {missing}; {expected}")]
    Missing {
        /// The name of what is missing.
        missing: &'static str,
        /// The text that would be right.
        expected: &'static str,
    },
    /// The points make no curve.
    #[error("{count} different points are left; a profile needs at least 3, of which {expected}")]
    Points {
        /// The number of points in use.
        count: usize,
        /// The condition that the points must meet.
        expected: &'static str,
    },
    /// The points do not show what they are points of.
    #[error("{0}")]
    Unclear(&'static str),
    /// A point lies nowhere near a wheel or a rail.
    #[error(
        "point {index} (counted from 1) lies at ({y:e} m, {z:e} m); a profile lies within 10 m of its origin, check the unit of length"
    )]
    Far {
        /// The number of the point, counted from 1, in the order in use.
        index: usize,
        /// The coordinate y \[m\].
        y: f64,
        /// The coordinate z \[m\].
        z: f64,
    },
}
