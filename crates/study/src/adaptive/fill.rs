//! Reads `[fill]`, which adds points where a curve or a map bends most.

use toml::de::DeValue;

use super::axis::ascending_axis;
use super::rule::{Adaptive, Filling};
use super::table::{caused_column, fields};
use crate::axis::Group;
use crate::bounds::{ANY, Bounds, inside, within};
use crate::columns::Column;
use crate::error::Mistake;
use crate::fallback::Fallback::{self, Follows, Needed};
use crate::read::{self, Node};
use crate::table_key::{COLUMN, KeyTable, PART, TableValue, table_key};

/// The table.
pub(crate) const FILL: KeyTable = KeyTable {
    path: "fill",
    is_list: false,
    meaning: "adds points along an axis, or on a map of two, where a result bends most",
    keys: &[
        table_key("column", COLUMN, ANY, Needed, "\"stick_fraction\"", "column of a result"),
        table_key(
            "axis",
            TableValue::Other("the path of an axis, or a list of two"),
            ANY,
            Needed,
            "\"friction.mu\"",
            "axis of numbers by itself, or two of them for a map",
        ),
        table_key(
            "to",
            PART,
            inside(0.0, 1.0),
            Follows("`at_most` alone ends it; one of the two must be given"),
            "\"1%\"",
            "distance of straight lines from the result, by estimate, over the range of the \
             column that is small enough; or of points from each other, over the axis",
        ),
        table_key(
            "at_most",
            TableValue::Count,
            POINTS,
            Fallback::Count(AT_MOST),
            "40",
            "points that may be added at each combination of the other axes",
        ),
    ],
};

/// The number of points that are added at each combination of the other axes if the study does not
/// say.
const AT_MOST: u32 = 1000;

/// The numbers of points that can be asked for.
const POINTS: Bounds = within(1.0, 10_000.0);

/// Reads the table.
pub(super) fn read_fill(
    node: &Node<'_>,
    groups: &[Group],
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Option<Adaptive> {
    let [column, axis] = fields(&FILL, node, ["column", "axis"], mistakes)?;
    let DeValue::Table(table) = node.get_ref() else { return None };
    let before = mistakes.len();
    let mut note = |mistake: Mistake| mistakes.push(mistake);
    let column = caused_column("fill.column", column, columns).map_err(&mut note).ok();
    let to = table.get("to").and_then(|to| read::proportion("fill.to", to).map_err(&mut note).ok());
    let at_most = table
        .get("at_most")
        .and_then(|count| {
            read::count("fill.at_most", "points", POINTS, count).map_err(&mut note).ok()
        })
        .unwrap_or(AT_MOST) as usize;
    if !table.contains_key("to") && !table.contains_key("at_most") {
        mistakes.push(
            Mistake::new(node.span(), "`[fill]` has no end", "needs `to`, `at_most` or both").help(
                "to = \"1%\" is a part of the range of the column; at_most = 40 counts the \
                     points that are added",
            ),
        );
    }
    let axes = read_axes(axis, groups, mistakes);
    let filling = Filling { column: column?, axes: axes?, to, at_most };
    (mistakes.len() == before).then_some(Adaptive::Fill(filling))
}

/// Reads the name of one axis, or a list of two.
fn read_axes(node: &Node<'_>, groups: &[Group], mistakes: &mut Vec<Mistake>) -> Option<Vec<usize>> {
    const EXPECTED: &str = "must be an axis, or a list of two for a map";
    let nodes: Vec<&Node<'_>> = match node.get_ref() {
        DeValue::Array(names) => names.iter().collect(),
        _ => vec![node],
    };
    if !(1..=2).contains(&nodes.len()) {
        let message = format!("`fill.axis` is a list of {}", nodes.len());
        mistakes.push(Mistake::new(node.span(), message, EXPECTED));
        return None;
    }
    let read =
        nodes.iter().map(|node| ascending_axis("fill.axis", node, groups, "filled", mistakes));
    let axes = read.collect::<Vec<_>>().into_iter().collect::<Option<Vec<usize>>>()?;
    if let ([first, second], [_, twice]) = (&axes[..], &nodes[..])
        && first == second
    {
        mistakes.push(Mistake::new(twice.span(), "`fill.axis` names an axis twice", EXPECTED));
    }
    Some(axes)
}
