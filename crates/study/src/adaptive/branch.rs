//! Reads `[branch]`, which narrows brackets of uniqueness sets.

use toml::de::DeValue;

use contact::model::SceneError;
use contact::uniqueness::WitnessSearch;
use contact::uniqueness::branch::MOST_BRANCHED_CONES;

use super::rule::Adaptive;
use super::table::fields;
use crate::axis::{self, Group};
use crate::bounds::{Bounds, within};
use crate::error::Mistake;
use crate::fallback::Fallback::{self, Needed};
use crate::job::Job;
use crate::key::Key;
use crate::kind::Kind;
use crate::read::{self, Node};
use crate::sheet::Given;
use crate::table_key::{KeyTable, PART, TableValue, table_key};

/// The table.
pub(crate) const BRANCH: KeyTable = KeyTable {
    path: "branch",
    is_list: false,
    meaning: "narrows the bracket of μ* at every point by jobs that exclude parts of its fields; \
              only of `kind = \"uniqueness\"`",
    keys: &[
        table_key(
            "to",
            PART,
            within(WitnessSearch::WIDTHS[0], WitnessSearch::WIDTHS[1]),
            Needed,
            "\"1%\"",
            "length of the bracket over its upper end that is small enough; where it takes too \
             many cones, twice that, and so on",
        ),
        table_key(
            "at_most",
            TableValue::Count,
            CONES,
            Fallback::Count(AT_MOST),
            "5000",
            "cones of one length of the bracket at one point after which no further jobs are made",
        ),
    ],
};

/// The number of cones if the study does not say.
const AT_MOST: u32 = 20_000;

/// The numbers of cones that can be asked for.
const CONES: Bounds = within(1.0, MOST_BRANCHED_CONES as f64);

/// Reads the table.
pub(super) fn read_branch(
    node: &Node<'_>,
    kind: Kind,
    base: &[(Key, Given)],
    groups: &[Group],
    mistakes: &mut Vec<Mistake>,
) -> Option<Adaptive> {
    if kind != Kind::Uniqueness {
        let message = "only a study of kind \"uniqueness\" has `[branch]`";
        mistakes.push(Mistake::new(node.span(), message, "leave this out"));
        return None;
    }
    let [to] = fields(&BRANCH, node, ["to"], mistakes)?;
    let DeValue::Table(table) = node.get_ref() else { return None };
    let to = read_width(to).map_err(|mistake| mistakes.push(mistake)).ok();
    let at_most = match table.get("at_most") {
        Some(count) => read::count("branch.at_most", "cones", CONES, count)
            .map_err(|mistake| mistakes.push(mistake))
            .ok(),
        None => Some(AT_MOST),
    };
    let of_axes = groups.iter().flat_map(Group::axes).flat_map(|axis| &axis.choices);
    let given = base.iter().chain(of_axes.flat_map(|choice| &choice.given));
    let refused = [
        (Key::Cases, "`[branch]` goes through the cases by itself"),
        (Key::Width, "`branch.to` says how narrow the bracket is to be"),
        (Key::Plane, "in a plane the end is exact, and nothing is left to narrow"),
    ];
    for (key, reason) in refused {
        let mut of_key = given.clone().filter(|(other, _)| *other == key);
        let derived = || axis::keys(base, groups).any(|other| other == key);
        if let Some((_, given)) = of_key.next() {
            let message = format!("a study with `[branch]` has no `{}`: {reason}", key.short());
            let mistake = Mistake::new(given.span.clone(), message, "leave this out");
            mistakes.push(mistake.context(node.span(), "`[branch]` is here"));
        } else if derived() {
            let message = format!("a study with `[branch]` has no `{}`: {reason}", key.short());
            mistakes.push(Mistake::new(node.span(), message, "leave one of the two out"));
        }
    }
    Some(Adaptive::Branch { to: to?, at_most: at_most? as usize })
}

fn read_width(node: &Node<'_>) -> Result<f64, Mistake> {
    let [least, most] = WitnessSearch::WIDTHS;
    match read::proportion("branch.to", node)? {
        to if (least..=most).contains(&to) => Ok(to),
        to => {
            let message = format!("`branch.to` cannot be {to}");
            Err(Mistake::new(node.span(), message, format!("must be from {least} to {most}")))
        }
    }
}

/// Refuses the bracket of a point whose cases are not looked at.
pub(crate) fn check_branched(job: &Job) -> Result<(), SceneError> {
    let Job::Uniqueness { question, search } = job else { return Ok(()) };
    if question.plane || search.cases {
        let key = if question.plane { "search.plane" } else { "search.cases" };
        let expected = "must be left out beside `[branch]`".to_owned();
        return Err(SceneError { key: key.to_owned(), value: "true".to_owned(), expected });
    }
    // The cases are of as many elements as those of a search in one job.
    let refused = WitnessSearch { cases: true, ..*search }.suits(question).err();
    refused.map_or(Ok(()), |SceneError { value: _, expected, .. }| {
        let [nx, ny] = question.mesh.sides();
        let most = expected.split_once(": ").map_or("", |(_, most)| most);
        Err(SceneError {
            key: "numerics.mesh".to_owned(),
            value: format!("{nx} x {ny}"),
            expected: format!("must give fewer elements beside `[branch]`: {most}"),
        })
    })
}
