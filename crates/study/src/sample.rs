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

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};

use toml::de::{DeTable, DeValue};

use crate::axis::{Choice, Group, MAX_POINTS, SweepAxis, Target};
use crate::design::{Design, MOST_DIMENSIONS, SamplingMethod};
use crate::distribution::{BoundedNormal, CumulativeWeights, Distribution};
use crate::error::{Mistake, are_enough};
use crate::key::{Key, Table};
use crate::quantity::{Quantity, one_of};
use crate::read::{self, Name, Node, entries};
use crate::sheet::Setting;
use crate::suggestion::{nearest, nearest_path};
use crate::sweep::refuse_repeats;
use crate::units::Dimension;

const KEYS: &[&str] = &["method", "count", "seed", "keys"];

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

/// A reader of a column of a file: it gets the names of both, and what the values measure.
pub(crate) type ReadColumn<'f> = dyn FnMut(&str, &str, Dimension) -> Result<Vec<f64>, String> + 'f;

/// The columns of measured values, each of which is read once, however many keys are drawn from it.
struct MeasuredColumns<'f, 'r> {
    read: &'r mut ReadColumn<'f>,
    known: HashMap<(String, String, Dimension), Vec<MeasuredValue>>,
}

/// A value that was measured, and how often it was.
#[derive(Clone, Copy, Debug)]
struct MeasuredValue {
    value: f64,
    count: f64,
}

impl MeasuredColumns<'_, '_> {
    /// Returns the different values of a column, in ascending order, so that neighbouring parts of
    /// their distribution are neighbouring values.
    ///
    /// # Errors
    /// The column cannot be read, or has more than [`MAX_POINTS`] values, in words.
    fn values(
        &mut self,
        file: &str,
        column: &str,
        dimension: Dimension,
    ) -> Result<&[MeasuredValue], String> {
        let values = match self.known.entry((file.to_owned(), column.to_owned(), dimension)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let mut all = (self.read)(file, column, dimension)?;
                all.sort_by(f64::total_cmp);
                let runs = all.chunk_by(|a, b| a == b);
                let value = |run: &[f64]| MeasuredValue { value: run[0], count: run.len() as f64 };
                let values: Vec<MeasuredValue> = runs.map(value).collect();
                if values.len() > MAX_POINTS {
                    let found = values.len();
                    return Err(format!(
                        "the column has {found} different values, more than {MAX_POINTS}"
                    ));
                }
                place.insert(values)
            }
        };
        Ok(values)
    }
}

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

/// The largest standard normal number that a design draws, and some more.
const FURTHEST: f64 = 8.3;

/// Reads `[sample]` into a group whose steps are the points of a design.
pub(crate) fn read_sample(
    node: &Node<'_>,
    column: &mut ReadColumn<'_>,
    mistakes: &mut Vec<Mistake>,
) -> Option<Group> {
    let DeValue::Table(table) = node.get_ref() else {
        let expected = format!("a table with the keys `{}`", KEYS.join("`, `"));
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
    let is_unknown = |(name, _): &(&Name<'_>, _)| !KEYS.contains(&name.get_ref().as_ref());
    for (name, _) in entries(table).into_iter().filter(is_unknown) {
        if are_enough(mistakes) {
            return;
        }
        let word = name.get_ref().as_ref();
        let mistake = read::unknown(word, name.span(), "`[sample]`", KEYS);
        mistakes.push(match Key::find(word).is_some() || Table::find(word).is_some() {
            true => mistake.help("what is drawn stands below [sample.keys]"),
            false => mistake,
        });
    }
}

fn read_method(table: &DeTable<'_>, whole: &Node<'_>) -> Result<SamplingMethod, Mistake> {
    let names = SamplingMethod::ALL.map(SamplingMethod::name);
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

/// Makes the mistake of a word that is not among those known.
fn unknown_word(
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

/// Returns whether a table says how values are drawn, and does not hold keys.
fn is_distribution(table: &DeTable<'_>) -> bool {
    let names = SHAPES.iter().flat_map(|(_, names)| *names);
    table.contains_key("distribution") || names.into_iter().any(|name| table.contains_key(*name))
}

/// A distribution, and its values if it is discrete.
struct DrawnValues {
    distribution: Distribution,
    choices: Vec<Choice>,
}

/// Reads how a key is drawn; `node` is the whole of `table`.
fn read_drawn(
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

/// Returns the name of a distribution, which need not be said where what it has tells it.
fn read_shape(key: Key, table: &DeTable<'_>, node: &Node<'_>) -> Result<&'static str, Mistake> {
    let path = key.short();
    let is_choosing = matches!(key.quantity(), Quantity::Choice(_)) && key != Key::Shape;
    if !is_choosing
        && !matches!(key.quantity(), Quantity::Number(_) | Quantity::Count | Quantity::Mesh)
    {
        let message = format!("a sample cannot draw `{path}`");
        return Err(Mistake::new(node.span(), message, "must be an axis below [sweep]"));
    }
    let names: Vec<&'static str> = SHAPES.iter().map(|(name, _)| *name).collect();
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

/// The numbers that stand in the table of a distribution, with their places.
struct Numbers<'n> {
    path: &'n str,
    node: &'n Node<'n>,
    read: BTreeMap<&'static str, (f64, crate::error::Span)>,
}

impl<'n> Numbers<'n> {
    fn read(
        path: &'n str,
        dimension: Dimension,
        table: &DeTable<'_>,
        node: &'n Node<'n>,
    ) -> Result<Self, Mistake> {
        let mut read = BTreeMap::new();
        for name in ["from", "to", "mean", "deviation", "median", "mode", "log_deviation"] {
            let Some(node) = table.get(name) else { continue };
            let dimension = if name == "log_deviation" { Dimension::Pure } else { dimension };
            let number = read::number(&format!("{path}: {name}"), dimension, node)?;
            read.insert(name, (number, node.span()));
        }
        Ok(Numbers { path, node, read })
    }

    fn has(&self, name: &str) -> bool {
        self.read.contains_key(name)
    }

    fn required(&self, name: &str) -> Result<f64, Mistake> {
        self.read.get(name).map(|(number, _)| *number).ok_or_else(|| {
            let message = format!("the distribution of `{}` has no `{name}`", self.path);
            Mistake::new(self.node.span(), message, format!("needs `{name}`"))
        })
    }

    fn or(&self, name: &str, default: f64) -> f64 {
        self.read.get(name).map_or(default, |(number, _)| *number)
    }

    /// Makes a mistake at the place of a number, or at the whole table.
    fn mistake(&self, name: &str, message: String, expected: &str) -> Mistake {
        let span = self.read.get(name).map_or(self.node.span(), |(_, span)| span.clone());
        Mistake::new(span, message, expected)
    }

    fn require_positive(&self, name: &str) -> Result<(), Mistake> {
        match self.read.get(name) {
            Some((number, _)) if *number <= 0.0 => {
                let message = format!("`{}: {name}` cannot be {number}", self.path);
                Err(self.mistake(name, message, "must be above 0"))
            }
            _ => Ok(()),
        }
    }

    /// Returns both ends of a range.
    fn range(&self) -> Result<[f64; 2], Mistake> {
        let (from, to) = (self.required("from")?, self.required("to")?);
        self.check_order("from", "to")?;
        Ok([from, to])
    }

    /// Refuses bounds of which the second is not above the first; bounds that are left out are no
    /// mistake.
    fn check_order(&self, lower: &str, upper: &str) -> Result<(), Mistake> {
        let (Some((from, place)), Some((to, _))) = (self.read.get(lower), self.read.get(upper))
        else {
            return Ok(());
        };
        if from < to {
            return Ok(());
        }
        let message = format!("the distribution of `{}` ends where it begins or before", self.path);
        let mistake = self.mistake(upper, message, &format!("must be above `{lower}`"));
        Err(mistake.context(place.clone(), format!("`{lower}` is here")))
    }

    fn triangular(&self) -> Result<Distribution, Mistake> {
        let ([from, to], mode) = (self.range()?, self.required("mode")?);
        if mode < from || mode > to {
            let message = format!("the mode of `{}` lies beyond its ends", self.path);
            return Err(self.mistake("mode", message, "must be from `from` to `to`"));
        }
        if !(to - from).is_finite() {
            return Err(self.too_wide());
        }
        Ok(Distribution::Triangular { from, mode, to })
    }

    fn too_wide(&self) -> Mistake {
        let message = format!("the distribution of `{}` reaches beyond all numbers", self.path);
        Mistake::new(self.node.span(), message, "must be narrower")
    }

    fn normal(&self) -> Result<BoundedNormal, Mistake> {
        let (mean, deviation) = (self.required("mean")?, self.required("deviation")?);
        self.require_positive("deviation")?;
        self.check_order("from", "to")?;
        let (from, to) = (self.or("from", f64::NEG_INFINITY), self.or("to", f64::INFINITY));
        self.bounded(BoundedNormal { mean, deviation, from, to })
    }

    /// Refuses a normal distribution that is empty between its bounds, or wider than doubles.
    fn bounded(&self, normal: BoundedNormal) -> Result<BoundedNormal, Mistake> {
        let reach = FURTHEST * normal.deviation;
        if !(normal.mean - reach).is_finite() || !(normal.mean + reach).is_finite() {
            return Err(self.too_wide());
        }
        if normal.share() < f64::MIN_POSITIVE {
            let message = format!("the distribution of `{}` is nothing there", self.path);
            let bound = if self.has("from") { "from" } else { "to" };
            let expected = "must leave more of the distribution than its furthest tail";
            return Err(self.mistake(bound, message, expected));
        }
        Ok(normal)
    }

    fn log_normal(&self) -> Result<Distribution, Mistake> {
        for name in ["mean", "deviation", "median", "log_deviation", "from", "to"] {
            self.require_positive(name)?;
        }
        self.check_order("from", "to")?;
        let of_logarithm = ["median", "log_deviation"].into_iter().find(|name| self.has(name));
        let of_value = ["mean", "deviation"].into_iter().find(|name| self.has(name));
        if let (Some(name), Some(other)) = (of_logarithm, of_value) {
            let message = format!("`{}` has `{other}` and `{name}`", self.path);
            let expected = "needs mean and deviation, or median and log_deviation";
            return Err(self.mistake(name, message, expected));
        }
        let (mean, deviation) = match of_logarithm {
            Some(_) => (libm::log(self.required("median")?), self.required("log_deviation")?),
            None => {
                let (mean, deviation) = (self.required("mean")?, self.required("deviation")?);
                // The variance of the logarithm is ln(1 + (s/m)²).
                let variance = libm::log1p((deviation / mean) * (deviation / mean));
                (libm::log(mean) - 0.5 * variance, variance.sqrt())
            }
        };
        let bound =
            |name: &str, default: f64| self.read.get(name).map_or(default, |(x, _)| libm::log(*x));
        let (from, to) = (bound("from", f64::NEG_INFINITY), bound("to", f64::INFINITY));
        let normal = self.bounded(BoundedNormal { mean, deviation, from, to })?;
        let [least, most] = [-FURTHEST, FURTHEST]
            .map(|reach| libm::exp((mean + reach * deviation).clamp(from, to)));
        if deviation <= 0.0 || !most.is_finite() || least < f64::MIN_POSITIVE {
            return Err(self.too_wide());
        }
        let (from, to) = (self.or("from", 0.0), self.or("to", f64::INFINITY));
        Ok(Distribution::LogNormal { logarithm: normal, from, to })
    }
}
