//! The rules by which studies choose points.

use crate::accuracy::Accuracy;
use crate::error::Span;

/// The rule by which a study chooses points.
#[derive(Clone, Debug, PartialEq)]
pub enum Adaptive {
    /// The mesh makes each point accurate enough.
    Accuracy(Accuracy),
    /// The mesh is doubled.
    Refine {
        /// The column that is to hold still.
        on: String,
        /// The relative change from a mesh to the next that is small enough.
        until: f64,
        /// The number of elements across Ω beyond which the doubling stops.
        at_most: u32,
    },
    /// Intervals of an axis are halved.
    Bisect {
        /// The index of the axis among [`Study::axes`](crate::Study::axes); it is the only axis of
        /// its group.
        axis: usize,
        /// The condition on columns that holds on one side and not on the other.
        on: String,
        /// The place of the condition in the file.
        span: Span,
        /// The length of an interval, relative to its upper end, that is small enough. An interval
        /// that begins at 0 or below can be as long as its upper end whatever its length, and is
        /// measured against the whole axis.
        to: f64,
    },
}
