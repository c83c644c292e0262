//! Reads `[find]`, which finds where a result takes a value along an axis.

use super::axis::ascending_axis;
use super::rule::{Adaptive, RootSearch};
use super::table::{caused_column, fields};
use crate::axis::Group;
use crate::bounds::{ANY, inside};
use crate::columns::{Column, find};
use crate::error::Mistake;
use crate::fallback::Fallback::Needed;
use crate::read::{self, Node};
use crate::table_key::{AXIS, COLUMN, KeyTable, PART, TableValue, table_key};

/// The table.
pub(crate) const FIND: KeyTable = KeyTable {
    path: "find",
    is_list: false,
    meaning: "finds every value of an axis at which a result takes a value",
    keys: &[
        table_key("column", COLUMN, ANY, Needed, "\"stick_fraction\"", "column of a result"),
        table_key("value", IN_ITS_UNIT, ANY, Needed, "0.5", "value that it is to take"),
        table_key("axis", AXIS, ANY, Needed, "\"friction.mu\"", "axis of numbers by itself"),
        table_key(
            "to",
            PART,
            inside(0.0, 1.0),
            Needed,
            "\"0.1%\"",
            "length of a bracket, over its upper end, that is short enough; over the whole axis \
             where the axis begins at 0 or below",
        ),
    ],
};

const IN_ITS_UNIT: TableValue =
    TableValue::Other("a number in the column's unit, or a text with a unit");

/// Reads the table.
pub(super) fn read_find(
    node: &Node<'_>,
    groups: &[Group],
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Option<Adaptive> {
    let needed = ["column", "value", "axis", "to"];
    let [column, value, axis, to] = fields(&FIND, node, needed, mistakes)?;
    let mut note = |mistake: Mistake| mistakes.push(mistake);
    let column = caused_column("find.column", column, columns).map_err(&mut note).ok();
    let value = column.as_ref().and_then(|column| {
        let dimension = find(columns, column)?.dimension;
        read::number("find.value", dimension, value).map_err(&mut note).ok()
    });
    let to = read::proportion("find.to", to).map_err(&mut note).ok();
    let axis = ascending_axis("find.axis", axis, groups, "searched", mistakes);
    Some(Adaptive::Find(RootSearch { column: column?, value: value?, axis: axis?, to: to? }))
}
