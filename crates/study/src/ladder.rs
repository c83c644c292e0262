//! The ladder of a convergence study: the axis along which its points come closer to what they are
//! compared with.
//!
//! ```toml
//! kind = "convergence"
//!
//! [convergence]               # may be left out
//! along = "mesh"              # or "epsilon"; the mesh if it is an axis
//! reference = "closed-form"   # or "finest"; the closed form along meshes, where every scene has one
//! ```
//! Along meshes, solutions for ε = 0 converge to the closed form and those for ε > 0 to a limit of
//! their own, which is not known: the finest mesh stands for it. Along ε, the solution for the
//! smallest ε on the same mesh stands for the limit, that for ε = 0 if it is there.

use toml::de::DeValue;

use crate::axis::Group;
use crate::error::Mistake;
use crate::key::{Key, one_of};
use crate::read::{self, Node, entries};

/// The ladder of a convergence study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ladder {
    /// Index of the group of axes that makes its rungs.
    pub group: usize,
    /// [`Key::Mesh`] or [`Key::Epsilon`], an axis of that group.
    pub along: Key,
    /// What its rungs are compared with; `None` leaves it to the scene.
    pub reference: Option<Reference>,
}

/// What the rungs of a ladder are compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The closed form of their scene.
    ClosedForm,
    /// The finest rung.
    Finest,
}

const KEYS: &[&str] = &["along", "reference"];
const ALONG: [&str; 2] = ["mesh", "epsilon"];
const REFERENCES: [&str; 2] = ["closed-form", "finest"];

/// Reads `[convergence]`; without it the ladder is the axis of meshes, else that of ε.
pub(crate) fn read(
    node: Option<&Node<'_>>,
    groups: &[Group],
    mistakes: &mut Vec<Mistake>,
) -> Option<Ladder> {
    let (mut along, mut reference) = (None, None);
    let span = node.map_or(0..0, |node| node.span());
    if let Some(node) = node {
        let DeValue::Table(table) = node.get_ref() else {
            mistakes.push(read::mistyped(
                "convergence",
                node,
                &format!("a table with the keys `{}`", KEYS.join("`, `")),
            ));
            return None;
        };
        for (name, _) in
            entries(table).into_iter().filter(|(name, _)| !KEYS.contains(&name.get_ref().as_ref()))
        {
            mistakes.push(read::unknown(name.get_ref(), name.span(), "`[convergence]`", KEYS));
        }
        let mut word = |name: &str, words: &[&'static str]| -> Option<usize> {
            let node = table.get(name)?;
            let what = format!("convergence.{name}");
            let read = read::text(&what, node).and_then(|word| {
                match words.iter().position(|known| *known == word) {
                    Some(at) => Ok(at),
                    None => Err(Mistake::new(
                        node.span(),
                        format!("`{what}` cannot be `{word}`"),
                        format!("must be {}", one_of(words)),
                    )),
                }
            });
            read.map_err(|mistake| mistakes.push(mistake)).ok()
        };
        along = word("along", &ALONG).map(|at| [Key::Mesh, Key::Epsilon][at]);
        reference =
            word("reference", &REFERENCES).map(|at| [Reference::ClosedForm, Reference::Finest][at]);
    }
    let group_of = |key: Key| {
        groups.iter().position(|group| group.axes().iter().any(|axis| axis.key() == Some(key)))
    };
    let wanted: &[Key] = match &along {
        Some(key) => std::slice::from_ref(key),
        None => &[Key::Mesh, Key::Epsilon],
    };
    let found = wanted.iter().find_map(|key| Some((*key, group_of(*key)?)));
    match found {
        Some((key, group)) if groups[group].len() >= 2 => {
            if (key, reference) == (Key::Epsilon, Some(Reference::ClosedForm)) {
                let mistake = Mistake::new(
                    span,
                    "along ε the closed form is no reference: the mesh keeps the solutions away from it",
                    "",
                );
                mistakes.push(mistake.help("leave `reference` out, or converge along the mesh"));
            }
            Some(Ladder { group, along: key, reference })
        }
        _ => {
            let names: Vec<String> = wanted.iter().map(|key| format!("`{}`", key.name())).collect();
            let message = format!(
                "a convergence study needs {} as an axis, of at least two values",
                names.join(" or ")
            );
            mistakes.push(Mistake::new(
                span,
                message,
                "needs for example mesh = [8, 16, 32, 64] below [sweep]",
            ));
            None
        }
    }
}
