//! The figures that show what a rule has found.

use super::rule::{Adaptive, Filling, RootSearch};
use crate::axis::{Group, SweepAxis};
use crate::figure::Figure;

impl Adaptive {
    /// Makes the figure of what the rule looks at: the result over the axis along which points are
    /// added, or the points on the map of two axes. `None` for a rule that has none of its own.
    pub(crate) fn figure(&self, groups: &[Group]) -> Option<Figure> {
        let (column, axes) = match self {
            Adaptive::Find(RootSearch { column, axis, .. }) => (column, std::slice::from_ref(axis)),
            Adaptive::Fill(Filling { column, axes, .. }) => (column, &axes[..]),
            Adaptive::Accuracy(_)
            | Adaptive::Refine { .. }
            | Adaptive::Bisect { .. }
            | Adaptive::Branch { .. } => return None,
        };
        let name = |axis: &usize| {
            let axis = groups.iter().flat_map(Group::axes).nth(*axis);
            axis.map(SweepAxis::column)
        };
        let over = name(axes.first()?)?;
        let figure = Figure::over_axes(groups).into_iter().find(|figure| figure.x == over)?;
        Some(match axes.get(1).and_then(name) {
            None => Figure { y: vec![column.clone()], ..figure },
            Some(second) => {
                let series = figure.series.into_iter().filter(|name| *name != second).collect();
                Figure { y: vec![second.into_owned()], series, ..figure }
            }
        })
    }
}
