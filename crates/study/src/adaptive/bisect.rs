//! Reads `[bisect]`, which halves the intervals of an axis.

use super::axis::ascending_axis;
use super::rule::Adaptive;
use super::table::fields;
use crate::axis::Group;
use crate::error::Mistake;
use crate::read::{self, Node};

const BISECT: &[&str] = &["axis", "on", "to"];

/// Reads the table.
pub(super) fn read_bisect(
    node: &Node<'_>,
    groups: &[Group],
    mistakes: &mut Vec<Mistake>,
) -> Option<Adaptive> {
    let [axis, on, to] = fields("bisect", node, BISECT, ["axis", "on", "to"], mistakes)?;
    let span = on.span();
    let on = read::text("bisect.on", on).map_err(|mistake| mistakes.push(mistake)).ok();
    let to = read::proportion("bisect.to", to).map_err(|mistake| mistakes.push(mistake)).ok();
    let axis = ascending_axis("bisect.axis", axis, groups, "halved", mistakes);
    Some(Adaptive::Bisect { axis: axis?, on: on?, span, to: to? })
}
