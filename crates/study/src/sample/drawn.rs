//! Reads how a key is drawn: by a distribution, from a list, or from measured values.

use toml::de::{DeTable, DeValue};

use super::measured::{MeasuredColumns, MeasuredValue};
use super::numbers::Numbers;
use crate::axis::{Choice, MAX_POINTS};
use crate::bounds::{ANY, POSITIVE, within};
use crate::distribution::{CumulativeWeights, Distribution};
use crate::error::Mistake;
use crate::fallback::Fallback::{Follows, Needed};
use crate::key::{Key, Table};
use crate::quantity::{Quantity, one_of};
use crate::read::{self, Node};
use crate::sheet::Setting;
use crate::suggestion::nearest;
use crate::table_key::{KeyTable, TEXT, TableValue, table_key};
use crate::units::Dimension;

/// The keys of a distribution, those of all kinds of them.
pub(crate) const DISTRIBUTION: KeyTable = KeyTable {
    path: "sample.keys.KEY",
    is_list: false,
    meaning: "how a key is drawn, mostly written on one line; each distribution has keys of its own",
    keys: &[
        table_key(
            "distribution",
            TableValue::Word(&NAMES),
            ANY,
            Follows("as the other keys tell, else \"uniform\""),
            "\"log-normal\"",
            "name of the distribution",
        ),
        table_key(
            "from",
            OF_THE_KEY,
            ANY,
            Follows("no bound of a normal or log-normal one; others need it"),
            "0.1",
            "lower end, or bound",
        ),
        table_key(
            "to",
            OF_THE_KEY,
            ANY,
            Follows("no bound of a normal or log-normal one; others need it"),
            "0.5",
            "upper end, or bound, above `from`",
        ),
        table_key("mode", OF_THE_KEY, ANY, Needed, "0.3", "most likely value, of a triangular one"),
        table_key(
            "mean",
            OF_THE_KEY,
            ANY,
            Needed,
            "0.3",
            "mean of a normal one; of a log-normal one that of the value, above 0",
        ),
        table_key(
            "deviation",
            OF_THE_KEY,
            POSITIVE,
            Needed,
            "0.05",
            "standard deviation of a normal one; of a log-normal one that of the value",
        ),
        table_key(
            "median",
            OF_THE_KEY,
            POSITIVE,
            Follows("given by `mean` and `deviation`"),
            "0.3",
            "median of a log-normal one",
        ),
        table_key(
            "log_deviation",
            TableValue::Number,
            POSITIVE,
            Follows("given by `mean` and `deviation`"),
            "0.1",
            "standard deviation of the logarithm of a log-normal one",
        ),
        table_key(
            "values",
            TableValue::Other("a list of values of the key"),
            within(1.0, MAX_POINTS as f64),
            Needed,
            "[0.1, 0.3]",
            "values of a discrete one",
        ),
        table_key(
            "weights",
            TableValue::Other("a list of numbers above 0"),
            ANY,
            Follows("equal weights"),
            "[3, 1]",
            "weight of each of the values",
        ),
        table_key(
            "file",
            TEXT,
            ANY,
            Needed,
            "\"measured.csv\"",
            "file with the measured values of an empirical one, beside the study",
        ),
        table_key("column", TEXT, ANY, Needed, "\"friction\"", "head of their column"),
    ],
};

const OF_THE_KEY: TableValue = TableValue::Other("a value of the key");

/// The names of the distributions.
const NAMES: [&str; 7] =
    [SHAPES[0].0, SHAPES[1].0, SHAPES[2].0, SHAPES[3].0, SHAPES[4].0, SHAPES[5].0, SHAPES[6].0];

/// The names of the numbers and lists that a distribution may have beside its name.
const SHAPES: &[(&str, &[&str])] = &[
    ("uniform", &["from", "to"]),
    ("log-uniform", &["from", "to"]),
    ("normal", &["mean", "deviation", "from", "to"]),
    ("log-normal", &["mean", "deviation", "median", "log_deviation", "from", "to"]),
    ("triangular", &["from", "mode", "to"]),
    ("discrete", &["values", "weights"]),
    ("empirical", &["file", "column"]),
];

/// The other names that a distribution has elsewhere, each with its name here.
const SYNONYMS: &[(&str, &str)] = &[
    ("unif", "uniform"),
    ("gaussian", "normal"),
    ("gauss", "normal"),
    ("norm", "normal"),
    ("lognormal", "log-normal"),
    ("lognorm", "log-normal"),
    ("loguniform", "log-uniform"),
    ("logunif", "log-uniform"),
    ("reciprocal", "log-uniform"),
    ("triang", "triangular"),
    ("userdefined", "discrete"),
    ("histogrampoint", "discrete"),
    ("choice", "discrete"),
];

/// Returns whether a table says how values are drawn, and does not hold keys.
pub(super) fn is_distribution(table: &DeTable<'_>) -> bool {
    let names = SHAPES.iter().flat_map(|(_, names)| *names);
    table.contains_key("distribution") || names.into_iter().any(|name| table.contains_key(*name))
}

/// A distribution, and its values if it is discrete.
pub(super) struct DrawnValues {
    pub(super) distribution: Distribution,
    pub(super) choices: Vec<Choice>,
}

/// Reads how a key is drawn; `node` is the whole of `table`.
pub(super) fn read_drawn(
    key: Key,
    table: &DeTable<'_>,
    node: &Node<'_>,
    columns: &mut MeasuredColumns<'_, '_>,
    mistakes: &mut Vec<Mistake>,
) -> Result<DrawnValues, Mistake> {
    let shape = read_shape(key, table, node)?;
    let path = key.short();
    let known = SHAPES.iter().find(|(name, _)| *name == shape).map_or(&[][..], |(_, names)| names);
    let known = [&["distribution"], known].concat();
    read::refuse_unknown(table, &format!("the {shape} distribution of `{path}`"), &known, mistakes);
    if shape == "discrete" {
        return read_discrete(key, table, node);
    }
    let Quantity::Number(dimension) = key.quantity() else {
        let message = format!("`{path}` has only single values, and \"{shape}\" draws no such");
        let expected = "needs { values = [ … ] }, and weights where they differ";
        return Err(Mistake::new(node.span(), message, expected));
    };
    if shape == "empirical" {
        return read_empirical(key, dimension, table, node, columns);
    }
    let numbers = Numbers::read(&path, dimension, table, node)?;
    let distribution = match shape {
        "uniform" => {
            let [from, to] = numbers.range()?;
            Distribution::Uniform { from, to }
        }
        "log-uniform" => {
            let [from, to] = numbers.range()?;
            numbers.require_positive("from")?;
            Distribution::LogUniform { from, to }
        }
        "triangular" => numbers.triangular()?,
        "normal" => Distribution::Normal(numbers.normal()?),
        _ => numbers.log_normal()?,
    };
    Ok(DrawnValues { distribution, choices: Vec::new() })
}

/// Returns whether a sample may draw a key. What is a table as well is no single value.
pub(crate) fn is_drawable(key: Key) -> bool {
    match key.quantity() {
        Quantity::Number(_) | Quantity::Count | Quantity::Mesh => true,
        Quantity::Choice(_) => key != Key::Shape && Table::find(key.pattern()).is_none(),
        _ => false,
    }
}

/// Returns the name of a distribution, which need not be said where what it has tells it.
fn read_shape(key: Key, table: &DeTable<'_>, node: &Node<'_>) -> Result<&'static str, Mistake> {
    let path = key.short();
    if !is_drawable(key) {
        let message = format!("a sample cannot draw `{path}`");
        return Err(Mistake::new(node.span(), message, "must be an axis below [sweep]"));
    }
    let names = NAMES;
    let Some(name_node) = table.get("distribution") else {
        if table.contains_key("values") {
            return Ok("discrete");
        }
        if table.contains_key("file") {
            return Ok("empirical");
        }
        let others = ["mean", "deviation", "median", "log_deviation", "mode"];
        if !others.iter().any(|other| table.contains_key(*other)) {
            return Ok("uniform");
        }
        let message = format!("`{path}` does not say its distribution");
        let expected = format!("needs distribution = \"…\", {}", one_of(&names));
        return Err(Mistake::new(node.span(), message, expected));
    };
    let path = format!("{path}: distribution");
    let name = read::text(&path, name_node)?;
    if let Some(known) = names.iter().find(|known| **known == name) {
        return Ok(known);
    }
    let lower = name.to_lowercase().replace(['-', ' '], "_");
    if let Some(kind) = lower.strip_prefix("trunc").map(|rest| rest.trim_start_matches("ated")) {
        let message = format!("`{path}` cannot be `{name}`");
        let meant = if kind.contains("log") { "log-normal" } else { "normal" };
        let expected = format!("write distribution = \"{meant}\", with `from`, `to` or both");
        return Err(Mistake::new(name_node.span(), message, expected));
    }
    let synonym = SYNONYMS.iter().find(|(others, _)| lower.replace('_', "") == *others);
    let meant = synonym.map(|(_, name)| *name).or_else(|| nearest(&name, names.iter().copied()));
    Err(unknown_word(&path, &name, name_node, meant, &names))
}

/// Reads the values of a column, of which each is drawn as often as it stands there.
fn read_empirical(
    key: Key,
    dimension: Dimension,
    table: &DeTable<'_>,
    node: &Node<'_>,
    columns: &mut MeasuredColumns<'_, '_>,
) -> Result<DrawnValues, Mistake> {
    let path = key.short();
    let word = |name: &str| {
        let missing = || {
            let message = format!("the measured values of `{path}` have no `{name}`");
            let expected = "needs { file = \"….csv\", column = \"…\" }";
            Mistake::new(node.span(), message, expected)
        };
        let node = table.get(name).ok_or_else(missing)?;
        read::text(&format!("{path}: {name}"), node)
    };
    let (file, name) = (word("file")?, word("column")?);
    let place = table.get("file").map_or(node.span(), |node| node.span());
    let values = columns.values(&file, &name, dimension).map_err(|reason| {
        let message = format!("cannot draw `{path}` from this file: {reason}");
        Mistake::new(place, message, "must be a text with a head for each column")
    })?;
    let weights: Vec<f64> = values.iter().map(|measured| measured.count).collect();
    let choice = |measured: &MeasuredValue| {
        Choice::of_key(key, Setting::Number(measured.value), node.span(), None)
    };
    Ok(DrawnValues {
        distribution: Distribution::Discrete(CumulativeWeights::new(&weights)),
        choices: values.iter().map(choice).collect(),
    })
}

fn read_discrete(key: Key, table: &DeTable<'_>, node: &Node<'_>) -> Result<DrawnValues, Mistake> {
    let path = key.short();
    let list = |name: &str, expected: &str| match table.get(name).map(|node| (node, node.get_ref()))
    {
        None => Ok(None),
        Some((node, DeValue::Array(items))) => Ok(Some((node.span(), items))),
        Some((node, _)) => Err(read::mistyped(&format!("{path}: {name}"), node, expected)),
    };
    let expected = format!("a list, each {}", key.quantity().expected());
    let Some((place, values)) = list("values", &expected)? else {
        let message = format!("the discrete distribution of `{path}` has no `values`");
        return Err(Mistake::new(node.span(), message, format!("needs {expected}")));
    };
    if values.is_empty() || values.len() > MAX_POINTS {
        let message = format!("`{path}` is drawn from {} values", values.len());
        return Err(Mistake::new(place, message, format!("must be from 1 to {MAX_POINTS}")));
    }
    let mut choices = Vec::with_capacity(values.len());
    for value in values.iter() {
        choices.push(Choice::of_key(key, read::setting(key, value)?, value.span(), None));
    }
    let weights = match list("weights", "a list of numbers above 0")? {
        None => vec![1.0; choices.len()],
        Some((place, weights)) if weights.len() != choices.len() => {
            let message = format!("{} weights for {} values", weights.len(), choices.len());
            return Err(Mistake::new(place, message, "needs a weight for each value"));
        }
        Some((_, nodes)) => {
            let path = format!("{path}: weights");
            let mut weights = Vec::with_capacity(nodes.len());
            for node in nodes.iter() {
                let weight = read::number(&path, Dimension::Pure, node)?;
                if weight <= 0.0 {
                    let message = format!("a weight cannot be {weight}");
                    let expected = "must be above 0; leave out what is never drawn";
                    return Err(Mistake::new(node.span(), message, expected));
                }
                weights.push(weight);
            }
            weights
        }
    };
    Ok(DrawnValues {
        distribution: Distribution::Discrete(CumulativeWeights::new(&weights)),
        choices,
    })
}

/// Makes the mistake of a word that is not among those known.
pub(super) fn unknown_word(
    path: &str,
    word: &str,
    node: &Node<'_>,
    meant: Option<&str>,
    known: &[&str],
) -> Mistake {
    let message = format!("`{path}` cannot be `{word}`");
    let listed = format!("must be {}", one_of(known));
    match meant {
        Some(meant) => {
            Mistake::new(node.span(), message, format!("did you mean \"{meant}\"?")).help(listed)
        }
        None => Mistake::new(node.span(), message, listed),
    }
}
