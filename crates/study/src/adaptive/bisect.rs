//! Reads `[bisect]`, which halves the intervals of an axis.

use super::axis::ascending_axis;
use super::rule::Adaptive;
use super::table::fields;
use crate::axis::Group;
use crate::bounds::{ANY, inside};
use crate::error::Mistake;
use crate::fallback::Fallback::Needed;
use crate::read::{self, Node};
use crate::table_key::{AXIS, CONDITION, KeyTable, PART, table_key};

/// The table.
pub(crate) const BISECT: KeyTable = KeyTable {
    path: "bisect",
    is_list: false,
    meaning: "halves the intervals of an axis in which a condition begins or ceases to hold",
    keys: &[
        table_key("axis", AXIS, ANY, Needed, "\"friction.mu\"", "axis of numbers by itself"),
        table_key("on", CONDITION, ANY, Needed, "\"stick_area > 0\"", "condition on the results"),
        table_key(
            "to",
            PART,
            inside(0.0, 1.0),
            Needed,
            "\"1%\"",
            "length of an interval, over its upper end, that is short enough; over the whole axis \
             where the axis begins at 0 or below",
        ),
    ],
};

/// Reads the table.
pub(super) fn read_bisect(
    node: &Node<'_>,
    groups: &[Group],
    mistakes: &mut Vec<Mistake>,
) -> Option<Adaptive> {
    let [axis, on, to] = fields(&BISECT, node, ["axis", "on", "to"], mistakes)?;
    let span = on.span();
    let on = read::condition("bisect.on", on).map_err(|mistake| mistakes.push(mistake)).ok();
    let to = read::proportion("bisect.to", to).map_err(|mistake| mistakes.push(mistake)).ok();
    let axis = ascending_axis("bisect.axis", axis, groups, "halved", mistakes);
    Some(Adaptive::Bisect { axis: axis?, on: on?, span, to: to? })
}
