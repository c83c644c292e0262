//! Reads the form of a figure, and refuses the keys that figures of another form have.

use toml::de::DeTable;

use crate::axis::Group;
use crate::design::arrangement::Arrangement;
use crate::error::{Mistake, Span};
use crate::figure::FigureKind;
use crate::quantity::one_of;
use crate::read::{self, Node};
use crate::suggestion::nearest;

/// Reads the form.
pub(super) fn read_kind(node: &Node<'_>) -> Result<FigureKind, Mistake> {
    let name = read::text("figure.kind", node)?;
    let known = FigureKind::ALL.into_iter().find(|kind| kind.name() == name);
    known.ok_or_else(|| {
        let names = FigureKind::NAMES;
        let message = format!("`figure.kind` cannot be `{name}`");
        let listed = format!("must be {}", one_of(&names));
        match nearest(&name, names) {
            Some(meant) => {
                let expected = format!("did you mean \"{meant}\"?");
                Mistake::new(node.span(), message, expected).help(listed)
            }
            None => Mistake::new(node.span(), message, listed),
        }
    })
}

/// The keys of figures of points.
const OF_POINTS: &[&str] = &[
    "x", "series", "panels", "steps", "where", "log_x", "log_y", "fit", "band", "front", "names",
    "bins", "share",
];

/// Refuses a figure of sensitivity in a study that has none.
pub(super) fn refuse_plain(span: &Span, groups: &[Group], mistakes: &mut Vec<Mistake>) {
    let is_arranged = |group: &Group| {
        group.design().is_some_and(|design| design.arrangement() != Arrangement::Plain)
    };
    if !groups.iter().any(is_arranged) {
        let message = "only a study of kind \"sensitivity\" has a figure of it";
        let expected = format!("must be {}", one_of(&["curves", "scatter", "histogram"]));
        mistakes.push(Mistake::new(span.clone(), message, expected));
    }
}

/// Notes the keys that a figure of another kind has.
pub(super) fn refuse_foreign(kind: FigureKind, table: &DeTable<'_>, mistakes: &mut Vec<Mistake>) {
    let (names, owner): (&[&str], &str) = match kind {
        FigureKind::Histogram => {
            (&["y", "band", "steps", "fit", "front", "names", "log_y"], "a histogram")
        }
        FigureKind::Scatter => (&["band", "steps", "bins", "share"], "a scatter"),
        FigureKind::Sensitivity => (OF_POINTS, "a figure of sensitivity"),
        FigureKind::Curves => (&["bins", "share"], "a figure of curves"),
    };
    for node in names.iter().filter_map(|name| Some((name, table.get(*name)?))) {
        let (name, node) = node;
        let mistake =
            Mistake::new(node.span(), format!("{owner} has no `{name}`"), "leave this out");
        mistakes.push(match *name {
            "bins" | "share" => mistake.help("or say kind = \"histogram\""),
            _ => mistake,
        });
    }
}
