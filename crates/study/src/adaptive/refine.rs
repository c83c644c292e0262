//! Reads `[refine]`, which doubles meshes.

use toml::de::DeValue;

use contact::model::Mesh;

use super::rule::Adaptive;
use super::table::{fields, result_column};
use crate::accuracy::{AT_MOST, at_most};
use crate::axis::Group;
use crate::bounds::{ANY, inside, within};
use crate::columns::Column;
use crate::error::{Mistake, Span};
use crate::fallback::Fallback::{self, Needed};
use crate::key::Key;
use crate::read::{self, Node};
use crate::sheet::{Given, Setting};
use crate::table_key::{COLUMN, KeyTable, PART, TableValue, table_key};

/// The table.
pub(crate) const REFINE: KeyTable = KeyTable {
    path: "refine",
    is_list: false,
    meaning: "doubles `numerics.mesh` at every point until a result holds still",
    keys: &[
        table_key("on", COLUMN, ANY, Needed, "\"peak_pressure\"", "column of a result"),
        table_key(
            "until",
            PART,
            inside(0.0, 1.0),
            Needed,
            "\"0.1%\"",
            "relative change of it from a mesh to the next that is small enough",
        ),
        table_key(
            "at_most",
            TableValue::Count,
            within(2.0, Mesh::MAX_SIDE as f64),
            Fallback::Count(AT_MOST),
            "512",
            "elements across Ω beyond which the doubling stops, no less than twice `numerics.mesh`",
        ),
    ],
};

/// Reads the table.
pub(super) fn read_refine(
    node: &Node<'_>,
    base: &[(Key, Given)],
    groups: &[Group],
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Option<Adaptive> {
    let [on, until] = fields(&REFINE, node, ["on", "until"], mistakes)?;
    let found =
        result_column("refine.on", on, columns).map_err(|mistake| mistakes.push(mistake)).ok();
    let until =
        read::proportion("refine.until", until).map_err(|mistake| mistakes.push(mistake)).ok();
    let at_most =
        read_at_most(node, finest(base, groups)).map_err(|mistake| mistakes.push(mistake)).ok();
    let of_mesh = groups.iter().flat_map(Group::axes).find(|axis| axis.key() == Some(Key::Mesh));
    if let Some(axis) = of_mesh {
        let mistake = Mistake::new(
            axis.span.clone(),
            "`mesh` cannot be an axis of a study that refines",
            "leave this out",
        );
        mistakes.push(mistake.context(node.span(), "which chooses meshes from numerics.mesh on"));
    }
    Some(Adaptive::Refine { on: found?, until: until?, at_most: at_most? })
}

/// Returns the largest number of elements along a side among the meshes that are given, with its
/// place.
fn finest(base: &[(Key, Given)], groups: &[Group]) -> Option<(u32, Span)> {
    let of_axes = groups
        .iter()
        .flat_map(Group::axes)
        .flat_map(|axis| &axis.choices)
        .flat_map(|choice| &choice.given);
    let sides = base.iter().chain(of_axes).filter_map(|(_, given)| match &given.setting {
        Setting::Mesh(Mesh::Across(n)) => Some((*n, given.span.clone())),
        Setting::Mesh(Mesh::Exact(sides)) => Some((sides[0].max(sides[1]), given.span.clone())),
        _ => None,
    });
    sides.max_by_key(|(side, _)| *side)
}

/// Reads `refine.at_most`. At least two meshes are needed: the given one and one that is twice as
/// fine.
fn read_at_most(refine: &Node<'_>, finest: Option<(u32, Span)>) -> Result<u32, Mistake> {
    let given = match refine.get_ref() {
        DeValue::Table(table) => table.get("at_most"),
        _ => None,
    };
    // A mesh that is missing or has no elements is refused elsewhere.
    let (side, place) = finest.map_or((1, None), |(side, place)| (side, Some(place)));
    let twice = side.saturating_mul(2).max(2);
    let beside_mesh = |mistake: Mistake| match &place {
        Some(place) => mistake.context(place.clone(), "the mesh is given here"),
        None => mistake,
    };
    if twice > Mesh::MAX_SIDE {
        let message = format!(
            "`refine` doubles meshes, and {side} elements are more than half of {}",
            Mesh::MAX_SIDE
        );
        return Err(beside_mesh(Mistake::new(
            refine.span(),
            message,
            format!("needs a mesh of at most {}", Mesh::MAX_SIDE / 2),
        )));
    }
    match given {
        Some(node) => {
            at_most("refine.at_most", node, twice, "twice numerics.mesh").map_err(beside_mesh)
        }
        None if twice > AT_MOST => {
            let message = format!("`refine.at_most` is missing, and left out it is {AT_MOST}");
            let expected =
                format!("needs at_most, from {twice}, twice numerics.mesh, to {}", Mesh::MAX_SIDE);
            Err(beside_mesh(Mistake::new(refine.span(), message, expected)))
        }
        None => Ok(AT_MOST),
    }
}
