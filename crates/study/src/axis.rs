//! Axes: which keys a study varies, through which values, and how the axes combine into points.
//!
//! Under `[sweep]`, in the order of the file, the last one fastest:
//!
//! ```toml
//! [sweep]
//! "friction.mu" = [0.1, 0.3, 0.5]                                # a list
//! mesh = { from = 16, to = 64, count = 4 }                       # equal steps, both ends included
//! "loading.steps[0].approach" = { log = true, from = "1 um", to = "1 mm", count = 7 }   # equal ratios
//!
//! [[sweep.zip]]                                                  # axes that advance together count as one
//! punch = [                                                      # a whole table; `label` names it in the results
//!     { shape = "flat-disk", radius = "1 mm", label = "disk" },
//!     { shape = "sphere", radius = "50 mm" },                    # without a label, the punch's shape names it
//! ]
//! "foundation.base.shear_modulus" = ["80 GPa", "8 GPa"]
//! ```
//!
//! A table that is a value of an axis replaces the table of the file as a whole. An axis over a list (`foundation.layers`,
//! `loading.steps`) has lists as values, `[[], [{ … }], [{ … }, { … }]]`, or tables that give them a name,
//! `{ label = "coated", layers = [{ … }] }`; one over `foundation.base` has tables and the word `"rigid"`. An axis over an
//! entry of a list, `"loading.steps[1].shift_x"`, needs the entry in the scene; only a list that the scene leaves out
//! altogether is made of what the axes set.
//! The values between the ends of a range
//! are rounded to 15 significant digits (13 with equal ratios), so that `{ from = 0, to = 1, count = 11 }` holds 0.3 and not
//! 0.30000000000000004, and shares its results with a list that says 0.3. No axis names a value twice.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use contact::numerics::Mesh;
use toml::de::DeValue;

use crate::columns::Value;
use crate::error::{Problem, Span};
use crate::key::{Key, Quantity, Table, nearest_path};
use crate::read::{self, Name, Node, Reader, entries};
use crate::sheet::{Given, Setting, Sheet};
use crate::units::Dimension;

/// The largest number of points of one study.
pub const MAX_POINTS: usize = 10_000_000;

/// One axis of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    pub(crate) target: Target,
    pub(crate) choices: Vec<Choice>,
    pub(crate) log: bool,
    pub(crate) span: Span,
}

/// What an axis sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Target {
    Key(Key),
    Table(Table),
}

impl Target {
    /// The key or table, as short as a study file may write it.
    fn path(self) -> Cow<'static, str> {
        match self {
            Target::Key(key) => key.short(),
            Target::Table(table) => table.short(),
        }
    }

    /// Whether the two set a key in common.
    fn overlaps(self, other: Target) -> bool {
        match (self, other) {
            (Target::Key(a), Target::Key(b)) => a == b,
            (Target::Key(key), Target::Table(table)) | (Target::Table(table), Target::Key(key)) => key.is_under(&table),
            (Target::Table(a), Target::Table(b)) => a.is_under(&b) || b.is_under(&a),
        }
    }

    /// The list in which it is an entry or a key of one, and the entry's index.
    fn entry(self) -> Option<(Key, u32)> {
        match self {
            Target::Key(key) => Some((key.list()?, key.index()?)),
            Target::Table(table) => Some((table.list()?, table.index()?)),
        }
    }
}

/// One value of an axis: how it is shown, and the keys it sets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Choice {
    pub(crate) shown: Value,
    pub(crate) given: Vec<(Key, Given)>,
    span: Span,
}

impl Axis {
    /// The key or table that it sets, as short as a study file may write it.
    pub fn path(&self) -> Cow<'static, str> {
        self.target.path()
    }

    /// The column that shows it.
    pub fn column(&self) -> Cow<'static, str> {
        match self.target {
            Target::Key(key) => key.column(),
            Target::Table(table) => table.column(),
        }
    }

    /// The key that it sets, unless that is a whole table.
    pub fn key(&self) -> Option<Key> {
        match self.target {
            Target::Key(key) => Some(key),
            Target::Table(_) => None,
        }
    }

    /// Its values, in order.
    pub fn values(&self) -> impl ExactSizeIterator<Item = &Value> {
        self.choices.iter().map(|choice| &choice.shown)
    }

    /// Whether it was given as a range of equal ratios.
    pub fn is_log(&self) -> bool {
        self.log
    }

    /// Whether its values are numbers.
    pub fn is_numeric(&self) -> bool {
        self.values().all(|value| matches!(value, Value::Number(_) | Value::Integer(_)))
    }

    /// Writes its `index`-th value on a sheet.
    pub(crate) fn apply<'a>(&'a self, index: usize, sheet: &mut Sheet<'a>) {
        if let Target::Table(table) = &self.target {
            sheet.clear(table);
        }
        if let Some(choice) = self.choices.get(index) {
            choice.given.iter().for_each(|(key, given)| sheet.set(*key, given));
        }
    }
}

/// Axes that advance together; one axis by itself is a group of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    pub(crate) axes: Vec<Axis>,
    pub(crate) length: usize,
}

impl Group {
    /// The axes in the order of the file, at least one, all with [`len`](Group::len) values.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// How many steps it makes, at least one.
    #[expect(clippy::len_without_is_empty, reason = "a group is never empty")]
    pub fn len(&self) -> usize {
        self.length
    }
}

/// How many points the groups make; `None` beyond [`MAX_POINTS`].
pub(crate) fn count(groups: &[Group]) -> Option<usize> {
    groups.iter().try_fold(1usize, |product, group| product.checked_mul(group.length).filter(|count| *count <= MAX_POINTS))
}

/// The step of each group at a point; the last group is the fastest.
pub(crate) fn steps(groups: &[Group], mut point: usize) -> Vec<usize> {
    let mut steps = vec![0; groups.len()];
    for (step, group) in steps.iter_mut().zip(groups).rev() {
        *step = point % group.length;
        point /= group.length;
    }
    steps
}

/// Reads `[sweep]`.
pub(crate) fn read_sweep(text: &str, node: &Node<'_>, problems: &mut Vec<Problem>) -> Vec<Group> {
    let DeValue::Table(table) = node.get_ref() else {
        problems.push(read::mistyped("sweep", node, "a table of axes"));
        return Vec::new();
    };
    let before = problems.len();
    let mut groups = Vec::new();
    for (name, node) in entries(table) {
        if name.get_ref() == "zip" {
            read_zips(text, node, &mut groups, problems);
        } else {
            let mut axes = Vec::new();
            read_axes(text, "", name, node, &mut axes, problems);
            groups.extend(axes.into_iter().map(|axis| Group { length: axis.choices.len(), axes: vec![axis] }));
        }
    }
    // keys written with dots arrive gathered by their tables; what counts is where they stand
    groups.sort_by_key(|group| group.axes.first().map(|axis| axis.span.start));
    refuse_overlaps(&groups, problems);
    if problems.len() == before && count(&groups).is_none() {
        let factors = groups.iter().map(|group| group.length.to_string()).collect::<Vec<_>>().join(" × ");
        let message = format!("the axes make {factors} points, more than {MAX_POINTS}");
        let span =
            groups.iter().max_by_key(|group| group.length).and_then(|group| group.axes.first()).map_or(0..0, |axis| axis.span.clone());
        problems.push(Problem::new(span, message, "needs fewer values, here or on another axis"));
    }
    groups
}

fn read_zips(text: &str, node: &Node<'_>, groups: &mut Vec<Group>, problems: &mut Vec<Problem>) {
    let expected = "written [[sweep.zip]], with axes that advance together below it";
    let DeValue::Array(zips) = node.get_ref() else {
        return problems.push(read::mistyped("zip", node, expected));
    };
    for zip in zips.iter() {
        let DeValue::Table(table) = zip.get_ref() else {
            problems.push(read::mistyped("zip", zip, expected));
            continue;
        };
        let mut axes = Vec::new();
        let before = problems.len();
        for (name, node) in entries(table) {
            read_axes(text, "", name, node, &mut axes, problems);
        }
        axes.sort_by_key(|axis| axis.span.start);
        let Some(first) = axes.first() else {
            if problems.len() == before {
                problems.push(Problem::new(zip.span(), "a zip without axes", "needs axes that advance together"));
            }
            continue;
        };
        let length = first.choices.len();
        for other in axes.iter().filter(|axis| axis.choices.len() != length) {
            let values = |axis: &Axis| match axis.choices.len() {
                1 => format!("`{}` has 1 value", axis.path()),
                n => format!("`{}` has {n} values", axis.path()),
            };
            let message = format!("{}, {}: axes that advance together need equally many", values(first), values(other));
            problems
                .push(Problem::new(other.span.clone(), message, format!("needs {length}")).context(first.span.clone(), "as many as here"));
        }
        axes.retain(|axis| axis.choices.len() == length);
        groups.push(Group { axes, length });
    }
}

/// Reads one entry below `[sweep]`; an entry without quotes, `friction.mu = …`, arrives as nested tables.
fn read_axes(text: &str, prefix: &str, name: &Name<'_>, node: &Node<'_>, axes: &mut Vec<Axis>, problems: &mut Vec<Problem>) {
    let path = if prefix.is_empty() { name.get_ref().to_string() } else { format!("{prefix}.{}", name.get_ref()) };
    let span = name.span();
    if let Some(table) = Table::find(&path) {
        match node.get_ref() {
            DeValue::Table(below) if !below.is_empty() && !is_range(node) => {
                entries(below).into_iter().for_each(|(name, node)| read_axes(text, &path, name, node, axes, problems));
            }
            _ => {
                let choices = read_table_choices(text, table, node, problems);
                if !choices.is_empty() {
                    refuse_repeats(&path, &choices, problems);
                    axes.push(Axis { target: Target::Table(table), choices, log: false, span });
                }
            }
        }
    } else if let Some(key) = Key::find(&path) {
        let (choices, log) = read_key_choices(key, node, problems);
        if !choices.is_empty() {
            refuse_repeats(&path, &choices, problems);
            axes.push(Axis { target: Target::Key(key), choices, log, span });
        }
    } else {
        let problem = |expected: &str| Problem::new(span.clone(), format!("there is no key `{path}` to vary"), expected);
        problems.push(match nearest_path(&path) {
            Some(meant) => problem(&format!("did you mean \"{meant}\"?")),
            None => problem("must be a key of the scene or the numerics, like \"friction.mu\" or mesh"),
        });
    }
}

fn is_range(node: &Node<'_>) -> bool {
    matches!(node.get_ref(), DeValue::Table(table) if RANGE.iter().any(|key| table.contains_key(*key)))
}

const RANGE: &[&str] = &["from", "to", "count", "log"];

fn read_key_choices(key: Key, node: &Node<'_>, problems: &mut Vec<Problem>) -> (Vec<Choice>, bool) {
    match node.get_ref() {
        DeValue::Array(values) => {
            if values.is_empty() {
                problems.push(empty(&key.short(), node));
            }
            let mut choices = Vec::new();
            for value in values.iter() {
                match read::setting(key, value) {
                    Ok(setting) => choices.push(choice(key, setting, value.span(), None)),
                    Err(problem) => problems.push(problem),
                }
            }
            (choices, false)
        }
        DeValue::Table(_) => match read_range(key, node, problems) {
            Ok(range) => range,
            Err(problem) => {
                problems.push(problem);
                (Vec::new(), false)
            }
        },
        _ => {
            let expected = format!("a list of values or a range {{ from, to, count }}: each {}", key.quantity().expected());
            problems.push(read::mistyped(&key.short(), node, &expected).help(format!("one value alone is written [{}]", node_text(node))));
            (Vec::new(), false)
        }
    }
}

fn node_text(node: &Node<'_>) -> String {
    match node.get_ref() {
        DeValue::String(text) => format!("\"{text}\""),
        DeValue::Integer(n) => n.to_string(),
        DeValue::Float(x) => x.to_string(),
        _ => "…".to_owned(),
    }
}

fn empty(path: &str, node: &Node<'_>) -> Problem {
    Problem::new(node.span(), format!("the axis `{path}` is empty"), "needs at least one value")
}

fn choice(key: Key, setting: Setting, span: Span, nth: Option<usize>) -> Choice {
    let shown = match Value::from(&setting) {
        // every value of an axis has a name
        Value::Missing => Value::Text("none".to_owned()),
        value => value,
    };
    Choice { shown, given: vec![(key, Given { setting, span: span.clone(), nth })], span }
}

fn read_range(key: Key, node: &Node<'_>, problems: &mut Vec<Problem>) -> Result<(Vec<Choice>, bool), Problem> {
    let DeValue::Table(table) = node.get_ref() else { return Ok((Vec::new(), false)) };
    let what = key.short();
    let dimension = match key.quantity() {
        Quantity::Number(dimension) => dimension,
        Quantity::Count | Quantity::Mesh => Dimension::Pure,
        _ => {
            let expected = format!("must be a list, each {}", key.quantity().expected());
            return Err(Problem::new(node.span(), format!("`{what}` has no ranges"), expected));
        }
    };
    for (name, _) in entries(table).into_iter().filter(|(name, _)| !RANGE.contains(&name.get_ref().as_ref())) {
        problems.push(read::unknown(name.get_ref(), name.span(), &format!("the range of `{what}`"), RANGE));
    }
    let part = |name: &str| {
        table.get(name).ok_or_else(|| {
            let message = format!("the range of `{what}` has no `{name}`");
            Problem::new(node.span(), message, format!("needs `{name}`, as in {{ from = 0.1, to = 0.5, count = 5 }}"))
        })
    };
    let (from_node, to_node, count_node) = (part("from")?, part("to")?, part("count")?);
    let from = read::number(&format!("{what}: from"), dimension, from_node)?;
    let to = read::number(&format!("{what}: to"), dimension, to_node)?;
    let count = match count_node.get_ref() {
        DeValue::Integer(n) => read::whole("count", n, count_node.span())? as usize,
        _ => return Err(read::mistyped("count", count_node, "a whole number of values, 2 or more")),
    };
    let log = match table.get("log") {
        Some(node) => read::switch("log", node)?,
        None => false,
    };
    if count < 2 {
        let message = format!("a range of {count}: both ends are included");
        return Err(Problem::new(count_node.span(), message, "must be 2 or more").help("a single value is written as a list, [0.3]"));
    }
    if count > MAX_POINTS {
        return Err(Problem::new(count_node.span(), format!("a range of {count} values"), format!("must be {MAX_POINTS} or fewer")));
    }
    if log && !(from > 0.0 && to > 0.0) {
        let bad = if from > 0.0 { to_node } else { from_node };
        let message = format!("the range of `{what}` has equal ratios but does not stay above 0");
        return Err(Problem::new(bad.span(), message, "must be above 0 when log = true"));
    }
    if from == to {
        let message = format!("the range of `{what}` begins where it ends");
        return Err(Problem::new(to_node.span(), message, "must differ from `from`"));
    }
    let mut choices = Vec::with_capacity(count);
    for index in 0..count {
        let x = between(from, to, index, count, log);
        let setting = match key.quantity() {
            Quantity::Number(_) => Setting::Number(x),
            quantity => {
                if !(x.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&x)) {
                    let message = format!("value {} of the range of `{what}` would be {x}", index + 1);
                    return Err(Problem::new(node.span(), message, "every value must be a whole number, 0 or above"));
                }
                // exact: a whole number in the range of u32
                let n = x as u32;
                if quantity == Quantity::Mesh { Setting::Mesh(Mesh::Across(n)) } else { Setting::Count(n) }
            }
        };
        choices.push(choice(key, setting, node.span(), Some(index + 1)));
    }
    Ok((choices, log))
}

/// The `index`-th of `count` values from `from` to `to`: the ends exact, the others to 15 significant digits, 13 with equal ratios.
fn between(from: f64, to: f64, index: usize, count: usize, log: bool) -> f64 {
    let last = count - 1;
    if index == 0 {
        return from;
    }
    if index == last {
        return to;
    }
    let t = index as f64 / last as f64;
    if log {
        // ln and exp lose a few digits, and differ from one mathematical library to the next
        let x = (from.ln() * (1.0 - t) + to.ln() * t).exp();
        return format!("{x:.12e}").parse().unwrap_or(x);
    }
    let x = from * (1.0 - t) + to * t;
    // what cancellation leaves of a 0 is not a value
    if x.abs() < 1e-14 * from.abs().max(to.abs()) { 0.0 } else { format!("{x:.14e}").parse().unwrap_or(x) }
}

fn read_table_choices(text: &str, table: Table, node: &Node<'_>, problems: &mut Vec<Problem>) -> Vec<Choice> {
    let path = table.short();
    let DeValue::Array(values) = node.get_ref() else {
        problems.push(read::mistyped(&path, node, &format!("a list, each {}", each(&table))));
        return Vec::new();
    };
    if values.is_empty() {
        problems.push(empty(&path, node));
    }
    values.iter().filter_map(|value| read_table_choice(text, table, value, problems)).collect()
}

/// What each value of an axis over a table must be, for messages.
fn each(table: &Table) -> String {
    match table.is_list() {
        true => format!("{}, or with a name {{ label = \"…\", {} = [ … ] }}", table.expected(), table.name()),
        false => table.expected(),
    }
}

fn read_table_choice(text: &str, table: Table, value: &Node<'_>, problems: &mut Vec<Problem>) -> Option<Choice> {
    let path = table.short();
    let mut reader = Reader::new(text, problems);
    let mut label = None;
    match (table.list().filter(|_| table.is_list()), Key::find(&table.path()), value.get_ref()) {
        (Some(list), _, DeValue::Array(_)) => {
            reader.list(list, value);
            let length = reader.given.first().map(|(_, given)| given.setting.to_string()).unwrap_or_default();
            label = Some(match length.as_str() {
                "0" => format!("no {}", table.name()),
                "1" => format!("1 {}", table.name().trim_end_matches('s')),
                _ => format!("{length} {}", table.name()),
            });
        }
        (Some(list), _, DeValue::Table(below)) if below.contains_key(table.name()) => {
            let names = ["label", table.name()];
            for (name, node) in entries(below) {
                match name.get_ref().as_ref() {
                    "label" => {}
                    name if name == table.name() => reader.list(list, node),
                    other => reader.problems.push(read::unknown(other, name.span(), &format!("this value of `{path}`"), &names)),
                }
            }
        }
        (None, Some(key), DeValue::String(word)) => {
            reader.key(key, value);
            label = Some(word.to_string());
        }
        (None, _, DeValue::Table(below)) => {
            let keys = entries(below).into_iter().filter(|(name, _)| name.get_ref() != "label");
            reader.table(table, value.span(), keys);
        }
        _ => {
            reader.problems.push(read::mistyped(&path, value, &each(&table)));
            return None;
        }
    }
    let given = reader.given;
    let label = match value.get_ref() {
        DeValue::Table(below) => below.get("label").map(|node| read::text("label", node).and_then(|text| checked_label(text, node.span()))),
        _ => label.map(Ok),
    };
    let label = label.or_else(|| shape_of(&given).map(Ok)).unwrap_or_else(|| {
        Err(Problem::new(value.span(), format!("this value of `{path}` has no label"), "needs label = \"…\" to name it in the results"))
    });
    label.map(|label| Choice { shown: Value::Text(label), given, span: value.span() }).map_err(|problem| problems.push(problem)).ok()
}

fn checked_label(text: String, span: Span) -> Result<String, Problem> {
    if text.trim().is_empty() || text.chars().count() > 64 || text.chars().any(char::is_control) {
        return Err(Problem::new(span, "a label that cannot name anything", "must be 1 to 64 visible characters"));
    }
    Ok(text)
}

fn shape_of(given: &[(Key, Given)]) -> Option<String> {
    given.iter().find_map(|(key, given)| match (key, &given.setting) {
        (Key::Shape, Setting::Word(shape)) => Some(shape.clone()),
        _ => None,
    })
}

fn refuse_repeats(path: &str, choices: &[Choice], problems: &mut Vec<Problem>) {
    let mut seen: HashMap<String, &Choice> = HashMap::new();
    for choice in choices {
        // bits, not digits: two values are the same when they make the same job
        let identity = match &choice.shown {
            Value::Number(x) => format!("{:x}", (x + 0.0).to_bits()),
            value => value.to_string(),
        };
        if let Some(first) = seen.insert(identity, choice) {
            let message = format!("the axis `{path}` names {} twice", choice.shown);
            let expected = match choice.given.as_slice() {
                [(_, given)] if given.span == choice.span => "the values of an axis must differ",
                _ => "needs a `label` of its own",
            };
            problems.push(Problem::new(choice.span.clone(), message, expected).context(first.span.clone(), "first here"));
            return;
        }
    }
}

fn refuse_overlaps(groups: &[Group], problems: &mut Vec<Problem>) {
    let axes: Vec<&Axis> = groups.iter().flat_map(|group| &group.axes).collect();
    for (index, axis) in axes.iter().enumerate() {
        if let Some(owner) = axes[..index].iter().find(|owner| owner.target.overlaps(axis.target)) {
            let message = match owner.path() == axis.path() {
                true => format!("two axes vary `{}`", axis.path()),
                false => format!("two axes, `{}` and `{}`, set the same keys", owner.path(), axis.path()),
            };
            problems
                .push(Problem::new(axis.span.clone(), message, "only one axis may set a key").context(owner.span.clone(), "the other one"));
        }
    }
}

/// Refuses axes over entries that a list of the scene has not.
pub(crate) fn refuse_absent(groups: &[Group], base: &[(Key, Given)], problems: &mut Vec<Problem>) {
    for list in [Key::Layers, Key::Steps] {
        let axes = || groups.iter().flat_map(|group| &group.axes).filter_map(|axis| Some((axis, axis.target.entry()?)));
        let in_list = || axes().filter(|(_, (of, _))| *of == list).map(|(axis, (_, index))| (axis, index));
        let scene = Sheet::new(base.iter().map(|(key, given)| (*key, given)));
        let (length, has) = match scene.get(list) {
            Some(_) => (scene.length(list), "has"),
            None => {
                let set: HashSet<u32> = in_list().map(|(_, index)| index).collect();
                ((0..).find(|index| !set.contains(index)).unwrap_or(0), "is missing and would have")
            }
        };
        for (axis, index) in in_list().filter(|(_, index)| *index >= length) {
            let entries = match length {
                0 => "no entries".to_owned(),
                1 => "one entry, [0]".to_owned(),
                n => format!("{n} entries, [0] to [{}]", n - 1),
            };
            let message = format!("there is no `{}[{index}]`: the scene's `{}` {has} {entries}", list.short(), list.name());
            let problem = Problem::new(axis.span.clone(), message, format!("needs an entry of `scene.{}` to vary", list.short()));
            problems.push(match scene.get(list) {
                Some(given) => problem.context(given.span.clone(), "the entries are here"),
                None => problem,
            });
        }
    }
}
