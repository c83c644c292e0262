//! Studies that choose points as they go. Meshes are refined until a result holds still or is
//! [accurate](crate::accuracy), or one axis is halved.
//!
//! ```toml
//! [refine]                    # doubles numerics.mesh, at every point of the axes, until
//! on = "peak_pressure"        # this result
//! until = "0.1%"              # changes by no more than this
//! at_most = 512               # or the mesh would be finer than this; 1024 if left out, and no
//!                             # less than twice numerics.mesh
//! ```
//! ```toml
//! [bisect]                    # halves the intervals of an axis (equal ratios, if logarithmic)
//! axis = "friction.mu"        # on which
//! on = "stick_area > 0"       # this, as in `query --where`, begins or ceases to hold
//! to = "1%"                   # until they are no longer than this part of their upper end; of the
//!                             # whole axis, where they begin at 0 or below
//! ```
//!
//! The choice follows from the results alone. A study that was killed therefore goes on where it
//! was, and its points are the same on any number of workers.

use toml::de::{DeTable, DeValue};

use contact::model::Mesh;

use crate::accuracy::{AT_MOST, Accuracy, at_most};
use crate::axis::Group;
use crate::column_name::column_name;
use crate::columns::{Column, find};
use crate::error::{Mistake, Span};
use crate::key::Key;
use crate::quantity::Quantity;
use crate::read::{self, Node};
use crate::sheet::{Given, Setting};
use crate::value::Value;

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

const REFINE: &[&str] = &["on", "until", "at_most"];
const BISECT: &[&str] = &["axis", "on", "to"];

/// The advice for a column that is [unknown in choosing](Column::unknown_in_choosing).
pub const OF_ONE_JOB: &str = "must be of what one job leaves, like `load` or `estimate_load`";

/// Reads `[refine]` or `[bisect]` at the `root` of a study, which exclude each other and
/// `accuracy`. `base`, `groups` and `columns` are the study's.
pub(crate) fn read(
    root: &DeTable<'_>,
    base: &[(Key, Given)],
    groups: &[Group],
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Option<Adaptive> {
    let before = mistakes.len();
    let [accuracy, refine, bisect] = ["accuracy", "refine", "bisect"].map(|name| root.get(name));
    if let (Some(accuracy), Some(other)) = (accuracy, refine.or(bisect)) {
        let mistake = Mistake::new(
            other.span(),
            "a study chooses its points in one way only",
            "needs one of the two",
        );
        mistakes.push(mistake.context(accuracy.span(), "the other is here"));
    }
    let read = match (refine, bisect) {
        (Some(refine), Some(bisect)) => {
            let mistake = Mistake::new(
                bisect.span(),
                "a study cannot both refine and bisect",
                "needs one of the two",
            );
            mistakes.push(mistake.context(refine.span(), "the other is here"));
            None
        }
        (Some(node), None) => read_refine(node, base, groups, columns, mistakes),
        (None, Some(node)) => read_bisect(node, groups, mistakes),
        (None, None) => None,
    };
    read.filter(|_| mistakes.len() == before)
}

/// Returns the values of the `needed` keys of a table, in this order. A missing or unknown key is a
/// mistake.
fn fields<'t, 'i, const N: usize>(
    name: &str,
    node: &'t Node<'i>,
    keys: &[&str],
    needed: [&str; N],
    mistakes: &mut Vec<Mistake>,
) -> Option<[&'t Node<'i>; N]> {
    let DeValue::Table(table) = node.get_ref() else {
        mistakes.push(read::mistyped(
            name,
            node,
            &format!("a table with the keys `{}`", keys.join("`, `")),
        ));
        return None;
    };
    read::refuse_unknown(table, &format!("`[{name}]`"), keys, mistakes);
    let found = needed.map(|key| table.get(key));
    for (key, _) in needed.iter().zip(&found).filter(|(_, found)| found.is_none()) {
        mistakes.push(Mistake::new(
            node.span(),
            format!("`{name}.{key}` is missing"),
            format!("`[{name}]` needs `{key}`"),
        ));
    }
    let found: Vec<&Node<'_>> = found.into_iter().flatten().collect();
    found.try_into().ok()
}

fn read_refine(
    node: &Node<'_>,
    base: &[(Key, Given)],
    groups: &[Group],
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Option<Adaptive> {
    let [on, until] = fields("refine", node, REFINE, ["on", "until"], mistakes)?;
    let found = column_name("refine.on", on, columns, true).and_then(|name| {
        let why = find(columns, &name).and_then(Column::unknown_in_choosing);
        why.map_or(Ok(name), |why| Err(Mistake::new(on.span(), why, OF_ONE_JOB)))
    });
    let found = found.map_err(|mistake| mistakes.push(mistake)).ok();
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

fn read_bisect(node: &Node<'_>, groups: &[Group], mistakes: &mut Vec<Mistake>) -> Option<Adaptive> {
    let [axis, on, to] = fields("bisect", node, BISECT, ["axis", "on", "to"], mistakes)?;
    let name = read::text("bisect.axis", axis).map_err(|mistake| mistakes.push(mistake)).ok()?;
    let span = on.span();
    let on = read::text("bisect.on", on).map_err(|mistake| mistakes.push(mistake)).ok();
    let to = read::proportion("bisect.to", to).map_err(|mistake| mistakes.push(mistake)).ok();
    let axes =
        || groups.iter().flat_map(|group| group.axes().iter().map(move |axis| (group, axis)));
    let is_meant = |key: Option<Key>| {
        key.is_some() && key == Key::find(&name).or_else(|| Key::of_column(&name))
    };
    let mistake = |message: String, expected: &str| Mistake::new(axis.span(), message, expected);
    match axes().position(|(_, axis)| is_meant(axis.key())) {
        None => {
            let known: Vec<String> =
                axes().map(|(_, axis)| format!("\"{}\"", axis.path())).collect();
            let expected = if known.is_empty() {
                "needs [sweep] with it".to_owned()
            } else {
                format!("must be one of {}", known.join(", "))
            };
            mistakes.push(mistake(format!("`bisect.axis`: there is no axis `{name}`"), &expected));
            None
        }
        Some(index) => {
            let (group, axis) = axes().nth(index)?;
            if group.design().is_some() {
                let message = format!("`bisect.axis`: `{name}` is drawn by [sample]");
                mistakes.push(mistake(message, "must be an axis of [sweep]"));
                return None;
            }
            let continuous = matches!(axis.key().map(Key::quantity), Some(Quantity::Number(_)));
            if !continuous || group.axes().len() > 1 {
                let why = if continuous {
                    "advances together with others"
                } else {
                    "has nothing between its values"
                };
                mistakes.push(mistake(
                    format!("`bisect.axis`: `{name}` {why}"),
                    "must be an axis of numbers by itself",
                ));
            }
            let is_ascending = |values: &[f64]| values.windows(2).all(|pair| pair[0] < pair[1]);
            let values: Vec<f64> = axis.values().filter_map(Value::as_f64).collect();
            if continuous && (values.len() < 2 || !is_ascending(&values)) {
                let expected = "needs at least two values, the smaller ones first";
                mistakes.push(Mistake::new(
                    axis.span.clone(),
                    format!("`{name}` cannot be halved"),
                    expected,
                ));
            }
            Some(Adaptive::Bisect { axis: index, on: on?, span, to: to? })
        }
    }
}
