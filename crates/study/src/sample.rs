//! Reads `[sample]`: keys that are drawn from ranges and distributions, all at once for each point.
//!
//! ```toml
//! [sample]
//! method = "sobol"            # or "halton", "latin-hypercube", "random"; see `design`
//! count = 256                 # points
//! seed = 1                    # chooses another sample of the same kind; 0 if left out
//!
//! [sample.keys]               # any key that a [sweep] may vary; its units stand in every number
//! "friction.mu" = { from = 0.1, to = 0.5 }                   # uniform, if nothing else is said
//! "loading.steps[0].approach" = { distribution = "log-uniform", from = "1 um", to = "1 mm" }
//! "punch.radius" = { distribution = "normal", mean = "50 mm", deviation = "1 mm" }
//! # what lies between two bounds, or above or below one; a log-normal one may be bounded likewise
//! "foundation.base.poisson" = { distribution = "normal", mean = 0.3, deviation = 0.05, to = 0.5 }
//! # the mean and the deviation of the value itself, or its median and the deviation of its
//! # logarithm: { distribution = "log-normal", median = "80 GPa", log_deviation = 0.1 }
//! "foundation.base.shear_modulus" = { distribution = "log-normal", mean = "80 GPa",
//!                                     deviation = "8 GPa" }
//! "punch.material.poisson" = { distribution = "triangular", from = 0.2, mode = 0.3, to = 0.4 }
//! mesh = { values = [16, 32], weights = [3, 1] }             # discrete; equal weights if left out
//! # the values that were measured, as often as they were; see `column_file`
//! "foundation.layers[0].thickness" = { file = "coating.csv", column = "thickness" }
//! ```
//!
//! Beside `[sweep]`, the sample is drawn for each combination of the axes, the same for all. A key
//! that is drawn may be any that an axis may vary, except those that choose a shape or a file.

use std::collections::HashMap;

use toml::de::{DeTable, DeValue};

use crate::axis::{Group, MAX_POINTS, SweepAxis, Target};
use crate::bounds::{ANY, from};
use crate::design::{Design, MOST_DIMENSIONS, SamplingMethod};
use crate::error::{Mistake, are_enough};
use crate::fallback::Fallback::{self, Needed};
use crate::key::{Key, Table};
use crate::quantity::one_of;
use crate::read::{self, Name, Node, entries};
use crate::suggestion::{nearest, nearest_path};
use crate::sweep::refuse_repeats;
use crate::table_key::{ANY_KEY, KeyTable, TableValue, table_key};

mod drawn;
mod measured;
mod numbers;

pub(crate) use drawn::{DISTRIBUTION, is_drawable};
use drawn::{DrawnValues, is_distribution, read_drawn, unknown_word};
use measured::MeasuredColumns;
pub(crate) use measured::ReadColumn;

/// The table.
pub(crate) const TABLE: KeyTable = KeyTable {
    path: "sample",
    is_list: false,
    meaning: "points that are drawn, all keys at once for each",
    keys: &[
        table_key(
            "method",
            TableValue::Word(&SamplingMethod::NAMES),
            ANY,
            Needed,
            "\"sobol\"",
            "way in which points are spread",
        ),
        table_key("count", TableValue::Count, from(1.0), Needed, "256", "points, or rows of them"),
        table_key(
            "seed",
            TableValue::Count,
            ANY,
            Fallback::Count(0),
            "1",
            "choice of another sample of the same kind",
        ),
        table_key(
            "keys",
            TableValue::Other("a table with a line for each key"),
            ANY,
            Needed,
            "{ \"friction.mu\" = { from = 0.1, to = 0.5 } }",
            "keys that are drawn",
        ),
    ],
};

/// The table of what is drawn.
pub(crate) const DRAWN: KeyTable = KeyTable {
    path: "sample.keys",
    is_list: false,
    meaning: "the keys that are drawn, a line for each",
    keys: &[table_key(
        ANY_KEY,
        TableValue::Other("a distribution"),
        ANY,
        Needed,
        "{ from = 0.1, to = 0.5 }",
        "how the values of the key at this path are drawn",
    )],
};

/// Reads `[sample]` into a group whose steps are the points of a design.
pub(crate) fn read_sample(
    node: &Node<'_>,
    column: &mut ReadColumn<'_>,
    mistakes: &mut Vec<Mistake>,
) -> Option<Group> {
    let DeValue::Table(table) = node.get_ref() else {
        let expected = format!("a table with the keys `{}`", TABLE.names().join("`, `"));
        mistakes.push(read::mistyped("sample", node, &expected));
        return None;
    };
    refuse_unknown(table, mistakes);
    let mut note = |result: Result<_, Mistake>| result.map_err(|mistake| mistakes.push(mistake));
    let method = note(read_method(table, node).map(Some)).ok().flatten();
    let mut count = |name: &str| read_whole(table, name).map_err(|mistake| mistakes.push(mistake));
    let (length, seed) = (count("count"), count("seed"));
    let length = match length {
        Ok(None) => {
            let expected = "needs count = 256 or another number of points";
            mistakes.push(Mistake::new(node.span(), "`sample.count` is missing", expected));
            None
        }
        Ok(Some(0)) => {
            let span = table.get("count").map_or(node.span(), |node| node.span());
            mistakes.push(Mistake::new(span, "a sample of 0 points", "must be 1 or more"));
            None
        }
        length => length.ok().flatten(),
    };
    let mut columns = MeasuredColumns { read: column, known: HashMap::new() };
    let axes = read_keys(table, node, &mut columns, mistakes);
    let (method, length, seed) = (method?, length?, seed.ok()?.unwrap_or(0));
    if axes.is_empty() {
        return None;
    }
    let design = Design::new(method, length, seed, axes.len());
    let count = table.get("count").map_or(node.span(), |node| node.span());
    Some(Group { length: length as usize, axes, design: Some(design), count })
}

/// Notes the names in `[sample]` that mean nothing there.
fn refuse_unknown(table: &DeTable<'_>, mistakes: &mut Vec<Mistake>) {
    let known = TABLE.names();
    let is_unknown = |(name, _): &(&Name<'_>, _)| !known.contains(&name.get_ref().as_ref());
    for (name, _) in entries(table).into_iter().filter(is_unknown) {
        if are_enough(mistakes) {
            return;
        }
        let word = name.get_ref().as_ref();
        let mistake = read::unknown(word, name.span(), "`[sample]`", &known);
        mistakes.push(match Key::find(word).is_some() || Table::find(word).is_some() {
            true => mistake.help("what is drawn stands below [sample.keys]"),
            false => mistake,
        });
    }
}

fn read_method(table: &DeTable<'_>, whole: &Node<'_>) -> Result<SamplingMethod, Mistake> {
    let names = SamplingMethod::NAMES;
    let Some(node) = table.get("method") else {
        let expected = format!("needs method = \"…\", {}", one_of(&names));
        return Err(Mistake::new(whole.span(), "`sample.method` is missing", expected));
    };
    let name = read::text("sample.method", node)?;
    let known = SamplingMethod::ALL.into_iter().find(|method| method.name() == name);
    known.ok_or_else(|| {
        let meant = match name.to_lowercase().as_str() {
            "lhs" | "lhc" | "latin" => Some("latin-hypercube"),
            "monte-carlo" | "mc" | "uniform" => Some("random"),
            _ => nearest(&name, names),
        };
        unknown_word("sample.method", &name, node, meant, &names)
    })
}

fn read_whole(table: &DeTable<'_>, name: &str) -> Result<Option<u32>, Mistake> {
    let path = format!("sample.{name}");
    match table.get(name).map(|node| (node, node.get_ref())) {
        None => Ok(None),
        Some((node, DeValue::Integer(n))) => read::whole(&path, n, node.span()).map(Some),
        Some((node, _)) => Err(read::mistyped(&path, node, "a whole number")),
    }
}

/// Reads `[sample.keys]` into an axis for each key, in the order of the file.
fn read_keys(
    sample: &DeTable<'_>,
    whole: &Node<'_>,
    columns: &mut MeasuredColumns<'_, '_>,
    mistakes: &mut Vec<Mistake>,
) -> Vec<SweepAxis> {
    let example = "\"friction.mu\" = { from = 0.1, to = 0.5 }";
    let Some(node) = sample.get("keys") else {
        let expected = format!("needs [sample.keys] with a line for each key, like {example}");
        mistakes.push(Mistake::new(whole.span(), "the sample draws no key", expected));
        return Vec::new();
    };
    let DeValue::Table(table) = node.get_ref() else {
        let expected = format!("a table with a line for each key, like {example}");
        mistakes.push(read::mistyped("sample.keys", node, &expected));
        return Vec::new();
    };
    let before = mistakes.len();
    let mut axes = Vec::new();
    for (name, node) in entries(table) {
        read_axes("", name, node, columns, &mut axes, mistakes);
    }
    // Keys that are written with dots arrive gathered by their tables, but their places count.
    axes.sort_by_key(|axis: &SweepAxis| axis.span.start);
    if axes.is_empty() && mistakes.len() == before {
        let expected = format!("needs a line for each key, like {example}");
        mistakes.push(Mistake::new(node.span(), "the sample draws no key", expected));
    }
    if let Some(axis) = axes.get(MOST_DIMENSIONS) {
        let message = format!("the sample draws {} keys", axes.len());
        let expected = format!("must be at most {MOST_DIMENSIONS}");
        mistakes.push(Mistake::new(axis.span.clone(), message, expected));
        axes.truncate(MOST_DIMENSIONS);
    }
    axes
}

/// Reads an entry below `[sample.keys]`. An entry without quotes, `friction.mu = …`, arrives as
/// nested tables.
fn read_axes(
    prefix: &str,
    name: &Name<'_>,
    node: &Node<'_>,
    columns: &mut MeasuredColumns<'_, '_>,
    axes: &mut Vec<SweepAxis>,
    mistakes: &mut Vec<Mistake>,
) {
    if are_enough(mistakes) || count_values(axes) > MAX_POINTS {
        return;
    }
    let path = match prefix {
        "" => name.get_ref().to_string(),
        _ => format!("{prefix}.{}", name.get_ref()),
    };
    match (Table::find(&path), Key::find(&path), node.get_ref()) {
        (Some(_), _, DeValue::Table(below)) if !below.is_empty() && !is_distribution(below) => {
            for (name, node) in entries(below) {
                read_axes(&path, name, node, columns, axes, mistakes);
            }
        }
        (Some(_), ..) => {
            let message = format!("`{path}` is a whole table, and a sample draws single keys");
            let mistake = Mistake::new(name.span(), message, "must be a key");
            mistakes.push(mistake.help("tables are the values of axes, below [sweep]"));
        }
        (None, Some(key), DeValue::Table(table)) => {
            match read_drawn(key, table, node, columns, mistakes) {
                Ok(DrawnValues { distribution, choices }) => {
                    let log = distribution.is_log();
                    let axis = SweepAxis {
                        target: Target::Key(key),
                        choices,
                        distribution: Some(distribution),
                        log,
                        span: node.span(),
                    };
                    refuse_repeats(&axis, mistakes);
                    let span = axis.span.clone();
                    axes.push(axis);
                    let values = count_values(axes);
                    if values > MAX_POINTS {
                        let message = format!("the sample draws from {values} values up to here");
                        let expected = format!("must be at most {MAX_POINTS} over all keys");
                        mistakes.push(Mistake::new(span, message, expected));
                    }
                }
                Err(mistake) => mistakes.push(mistake),
            }
        }
        (None, Some(key), _) => {
            let expected = "a range or a distribution, like { from = 0.1, to = 0.5 }";
            let mistake = read::mistyped(&key.short(), node, expected);
            mistakes.push(match node.get_ref() {
                DeValue::Array(_) => mistake.help("a list is drawn from by { values = [ … ] }"),
                _ => mistake,
            });
        }
        (None, None, _) => {
            let mistake = |expected: &str| {
                Mistake::new(name.span(), format!("there is no key `{path}` to draw"), expected)
            };
            mistakes.push(match nearest_path(&path) {
                Some(suggestion) => mistake(&format!("did you mean \"{suggestion}\"?")),
                None => mistake(
                    "must be a key of the scene or the numerics, like \"friction.mu\" or mesh",
                ),
            });
        }
    }
}

/// Returns the number of values that some axes list.
fn count_values(axes: &[SweepAxis]) -> usize {
    axes.iter().map(|axis| axis.choices.len()).sum()
}
