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
    /// Points are added where a result takes a value.
    Find(RootSearch),
    /// Points are added where a curve or a map of a result bends most.
    Fill(Filling),
    /// The bracket of a uniqueness set is narrowed by jobs that exclude parts of its fields.
    Branch {
        /// The length of a bracket, relative to its upper end, that is small enough.
        to: f64,
        /// The number of cones of one length at one point after which no further jobs are made.
        at_most: usize,
    },
}

/// The search for every place along an axis at which a result takes a value.
#[derive(Clone, Debug, PartialEq)]
pub struct RootSearch {
    /// The column of the result.
    pub column: String,
    /// The value that it takes, in the unit of the column.
    pub value: f64,
    /// The index of the axis among [`Study::axes`](crate::Study::axes); it is the only axis of its
    /// group.
    pub axis: usize,
    /// The length of a bracket, relative to its upper end, that is small enough. Where an interval
    /// of the given values begins at 0 or below, brackets in it are measured against the whole
    /// axis.
    pub to: f64,
}

/// The adding of points to a curve or a map of a result.
#[derive(Clone, Debug, PartialEq)]
pub struct Filling {
    /// The column of the result.
    pub column: String,
    /// The indices of one or two axes among [`Study::axes`](crate::Study::axes); each is the only
    /// axis of its group.
    pub axes: Vec<usize>,
    /// The distance between the result and what is interpolated, relative to the range of the
    /// column, that is small enough; `None` to add as many points as there may be.
    pub to: Option<f64>,
    /// The number of points that may be added at each combination of the other axes.
    pub at_most: usize,
}

impl Adaptive {
    /// Returns the indices of the axes along which it adds points.
    pub fn axes(&self) -> &[usize] {
        match self {
            Adaptive::Accuracy(_) | Adaptive::Refine { .. } | Adaptive::Branch { .. } => &[],
            Adaptive::Bisect { axis, .. } => std::slice::from_ref(axis),
            Adaptive::Find(RootSearch { axis, .. }) => std::slice::from_ref(axis),
            Adaptive::Fill(Filling { axes, .. }) => axes,
        }
    }
}
