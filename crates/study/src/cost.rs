//! What a study of what accuracy costs measures.
//!
//! ```toml
//! kind = "cost"               # every point is solved alone on the machine, by one worker, several times over
//!
//! [cost]                      # may be left out
//! on = "load"                 # the error that counts: load, approach, peak_pressure, contact_area, stick_area, and where the scene
//!                             # has a closed form pressure or traction, in L2; the load or the approach, whichever is not given
//! repeat = 5                  # times
//! threads = 1                 # threads of the worker
//!
//! [sweep]                     # the rungs: every axis of numerics
//! mesh = [8, 16, 32, 64]
//! tolerance = [1e-3, 1e-8]
//! ```
//! Axes of the scene make ladders of their own. Errors are measured against the scene's closed
//! form, else against the limit that the meshes with the tightest other settings extrapolate to.

use toml::de::DeValue;

use crate::axis::Group;
use crate::error::Mistake;
use crate::key::{Key, one_of};
use crate::read::{self, Node, entries};

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cost {
    /// The error that counts, one of [`ON`]; `None` is the load or the approach.
    pub on: Option<&'static str>,
    /// How often every point is solved.
    pub repeat: u32,
    /// Threads of the worker.
    pub threads: u32,
}

/// The errors that can count.
pub const ON: [&str; 7] =
    ["load", "approach", "peak_pressure", "contact_area", "stick_area", "pressure", "traction"];

const KEYS: &[&str] = &["on", "repeat", "threads"];

/// Repetitions without being asked.
const REPEAT: u32 = 5;

/// Whether a group of axes makes rungs: one of its axes is of the numerics.
pub fn is_rung(group: &Group) -> bool {
    group
        .axes()
        .iter()
        .any(|axis| axis.key().is_some_and(|key| key.path().starts_with("numerics.")))
}

/// Reads `[cost]`.
pub(crate) fn read(
    node: Option<&Node<'_>>,
    groups: &[Group],
    mistakes: &mut Vec<Mistake>,
) -> Option<Cost> {
    let mut cost = Cost { on: None, repeat: REPEAT, threads: 1 };
    if let Some(node) = node {
        let DeValue::Table(table) = node.get_ref() else {
            mistakes.push(read::mistyped(
                "cost",
                node,
                &format!("a table with the keys `{}`", KEYS.join("`, `")),
            ));
            return None;
        };
        for (name, _) in
            entries(table).into_iter().filter(|(name, _)| !KEYS.contains(&name.get_ref().as_ref()))
        {
            mistakes.push(read::unknown(name.get_ref(), name.span(), "`[cost]`", KEYS));
        }
        if let Some(node) = table.get("on") {
            match read::text("cost.on", node) {
                Ok(word) => match ON.into_iter().find(|known| *known == word) {
                    Some(on) => cost.on = Some(on),
                    None => {
                        let message = format!("`cost.on` cannot be `{word}`");
                        mistakes.push(Mistake::new(
                            node.span(),
                            message,
                            format!("must be {}", one_of(&ON)),
                        ));
                    }
                },
                Err(mistake) => mistakes.push(mistake),
            }
        }
        let mut count = |name: &str, most: u32| -> Option<u32> {
            let node = table.get(name)?;
            let what = format!("cost.{name}");
            let read = match node.get_ref() {
                DeValue::Integer(n) => read::whole(&what, n, node.span()).and_then(|n| match n {
                    1.. if n <= most => Ok(n),
                    _ => Err(Mistake::new(
                        node.span(),
                        format!("`{what}` cannot be {n}"),
                        format!("must be from 1 to {most}"),
                    )),
                }),
                _ => Err(read::mistyped(&what, node, "a whole number")),
            };
            read.map_err(|mistake| mistakes.push(mistake)).ok()
        };
        cost.repeat = count("repeat", 1000).unwrap_or(cost.repeat);
        cost.threads = count("threads", 1024).unwrap_or(cost.threads);
    }
    let meshes = groups
        .iter()
        .flat_map(Group::axes)
        .find(|axis| axis.key() == Some(Key::Mesh))
        .map_or(0, |axis| axis.values().len());
    if meshes < 3 {
        let span = node.map_or(0..0, |node| node.span());
        let mistake = Mistake::new(
            span,
            "a study of cost needs at least three meshes",
            "needs for example mesh = [8, 16, 32, 64] below [sweep]",
        );
        mistakes.push(mistake);
    }
    Some(cost)
}
