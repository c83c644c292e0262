//! Reads `[find]`, which finds where a result takes a value along an axis.

use super::axis::ascending_axis;
use super::rule::{Adaptive, RootSearch};
use super::table::{caused_column, fields};
use crate::axis::Group;
use crate::columns::{Column, find};
use crate::error::Mistake;
use crate::read::{self, Node};

const FIND: &[&str] = &["column", "value", "axis", "to"];

/// Reads the table.
pub(super) fn read_find(
    node: &Node<'_>,
    groups: &[Group],
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Option<Adaptive> {
    let needed = ["column", "value", "axis", "to"];
    let [column, value, axis, to] = fields("find", node, FIND, needed, mistakes)?;
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
