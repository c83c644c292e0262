//! The reference of the study file: every table and every key, with the values that may stand
//! behind it, their bounds, what it is where it is left out, an example and its meaning.
//!
//! It says what the lists say by which a study is read: that of [`Key`]s for the scene and its
//! numerics, and that of each table beside them. It adds nothing of its own.

use contact::model::Effect;
use serde::Serialize;

use crate::assemble::shapes_of;
use crate::bounds::{Bound, Bounds};
use crate::derivation::is_derivable;
use crate::key::{Key, Table, short};
use crate::kind::Kind;
use crate::parse::{TOP, tables};
use crate::quantity::Quantity;
use crate::sample::is_drawable;
use crate::suggestion::nearest;
use crate::table_key::{ANY_KEY, KeyTable, TableKey, TableValue};
use crate::units::Dimension;

mod columns;

pub use columns::{ReferenceColumn, columns, matching_columns};

/// A table of a study file.
#[derive(Clone, Debug, Serialize)]
pub struct ReferenceTable {
    /// The path, with `[i]` for the index in a list; empty for the top of the file.
    pub path: &'static str,
    /// The heading as a file writes it; empty for the top of the file.
    pub heading: String,
    /// The meaning, in words.
    pub meaning: &'static str,
    /// The keys.
    pub keys: Vec<ReferenceKey>,
}

/// A key of a study file.
#[derive(Clone, Debug, Serialize)]
pub struct ReferenceKey {
    /// The name in its table; `KEY` stands for the path of a key of the scene or the numerics.
    pub name: &'static str,
    /// The path from the top of the file, with `[i]` for the index in a list.
    pub path: String,
    /// The path as axes and messages write it.
    pub short: String,
    /// The column that it fills, in a list that of the first entry; `None` for what is no key of
    /// the scene or its numerics.
    pub column: Option<String>,
    /// The column that it fills of the second entry of a list, from which those of later ones
    /// differ by the number.
    pub second_column: Option<String>,
    /// The values that may stand behind it, with their bounds, in words.
    pub values: String,
    /// The words among which it chooses.
    pub choices: Vec<&'static str>,
    /// The units in which its value may be written, that in which it is computed first; none for a
    /// pure number and for what is no number.
    pub units: Vec<&'static str>,
    /// The bounds of its values, or of the number of entries of a list.
    pub bounds: ReferenceBounds,
    /// The value that it has where it is left out, as a file would write it; `None` if it must be
    /// given, or depends on what else is given.
    pub default: Option<String>,
    /// The values that it has where it is left out, if they differ from one kind of study to
    /// another.
    pub defaults_of_kinds: Vec<KindDefault>,
    /// The consequence of leaving it out, in words.
    pub left_out: String,
    /// The value as a file may have it.
    pub example: &'static str,
    /// The meaning, in words.
    pub meaning: &'static str,
    /// The tables beside the scene in which it may be varied, by their headings.
    pub varied_by: Vec<&'static str>,
    /// The shapes of the punch that have it, with whether they need it; none if all have it.
    pub shapes: Vec<ShapeUse>,
    /// The kinds of study that have no use for it.
    pub refused_by: Vec<KindRefusal>,
}

/// The bounds of a key's values in SI units; an end that is missing does not bound them.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ReferenceBounds {
    /// The lower end.
    pub lower: Option<BoundEnd>,
    /// The upper end.
    pub upper: Option<BoundEnd>,
    /// True if 0 is no value.
    pub skips_zero: bool,
}

/// One end of bounds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BoundEnd {
    /// The number.
    pub number: f64,
    /// True if the number itself is a value.
    pub is_allowed: bool,
}

/// A shape of the punch that has a key.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ShapeUse {
    /// The shape.
    pub shape: &'static str,
    /// True if the shape needs the key.
    pub is_needed: bool,
}

/// A kind of study that has no use for a key.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct KindRefusal {
    /// The kind.
    pub kind: &'static str,
    /// The reason.
    pub reason: &'static str,
}

/// The default of a key in a kind of study.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct KindDefault {
    /// The kind.
    pub kind: &'static str,
    /// The default.
    pub default: u32,
}

/// A dimension, and the units in which its values may be written.
#[derive(Clone, Debug, Serialize)]
pub struct ReferenceUnits {
    /// The dimension, with its article.
    pub dimension: &'static str,
    /// The units, the SI unit first.
    pub units: Vec<&'static str>,
}

impl From<Bounds> for ReferenceBounds {
    fn from(bounds: Bounds) -> Self {
        let end = |bound: Bound| match bound {
            Bound::Free => None,
            Bound::Closed(number) => Some(BoundEnd { number, is_allowed: true }),
            Bound::Open(number) => Some(BoundEnd { number, is_allowed: false }),
        };
        ReferenceBounds {
            lower: end(bounds.lower),
            upper: end(bounds.upper),
            skips_zero: bounds.skips_zero,
        }
    }
}

/// Returns every table of a study file: the top of the file, the tables of the scene and the
/// numerics, and the others.
pub fn reference() -> Vec<ReferenceTable> {
    let of_scene = Table::ALL.iter().map(of_scene).filter(|table| !table.keys.is_empty());
    let others = tables();
    std::iter::once(of_table(&TOP)).chain(of_scene).chain(others.iter().map(of_table)).collect()
}

/// Returns the units of every dimension that a key has.
pub fn units() -> Vec<ReferenceUnits> {
    let mut dimensions: Vec<Dimension> = Vec::new();
    for dimension in Key::ALL.iter().map(|key| key.dimension()) {
        if dimension != Dimension::Pure && !dimensions.contains(&dimension) {
            dimensions.push(dimension);
        }
    }
    let of = |dimension: Dimension| ReferenceUnits {
        dimension: dimension.noun(),
        units: dimension.units().collect(),
    };
    dimensions.into_iter().map(of).collect()
}

/// Returns the tables with those of their keys that a pattern means: a path of a key, long or
/// short, or the name of its column; a table or the beginning of a path; or a part of a path.
pub fn matching(pattern: &str) -> Vec<ReferenceTable> {
    let pattern = with_index(pattern.trim());
    let of_column = Key::of_column(&pattern).map(Key::pattern);
    let is_key = |key: &ReferenceKey| {
        key.path == pattern || key.short == pattern || of_column == Some(key.path.as_str())
    };
    let is_within = |path: &str| {
        path.strip_prefix(&*pattern)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
    };
    let is_below = |key: &ReferenceKey| is_within(&key.path) || is_within(&key.short);
    let has_part = |key: &ReferenceKey| key.path.contains(&*pattern);
    let is_named = |key: &ReferenceKey| is_key(key) || is_below(key);
    let tests: [&dyn Fn(&ReferenceKey) -> bool; 2] = [&is_named, &has_part];
    for test in tests {
        let mut found = reference();
        found.iter_mut().for_each(|table| table.keys.retain(test));
        found.retain(|table| !table.keys.is_empty());
        if !found.is_empty() {
            return found;
        }
    }
    Vec::new()
}

/// Returns the path of the key that was probably meant by a pattern that means none.
pub fn nearest_key(pattern: &str) -> Option<String> {
    let tables = reference();
    let paths = || tables.iter().flat_map(|table| &table.keys).map(|key| key.short.as_str());
    nearest(pattern, paths()).map(str::to_owned)
}

/// Writes `[i]` for every index of a path.
fn with_index(path: &str) -> String {
    match path.split_once('[').and_then(|(list, rest)| Some((list, rest.split_once(']')?))) {
        Some((list, (_, rest))) => format!("{list}[i]{rest}"),
        None => path.to_owned(),
    }
}

/// Returns a table of the scene or the numerics.
fn of_scene(table: &Table) -> ReferenceTable {
    let is_direct = |key: &&Key| {
        let parent = key.pattern().rsplit_once('.').map_or("", |(parent, _)| parent);
        parent == table.pattern
    };
    let heading = match table.pattern.strip_suffix("[i]") {
        Some(list) => format!("[[{list}]]"),
        None => format!("[{}]", table.pattern),
    };
    ReferenceTable {
        path: table.pattern,
        heading,
        meaning: table.meaning,
        keys: Key::ALL.iter().filter(is_direct).map(|key| of_key(*key)).collect(),
    }
}

fn of_key(key: Key) -> ReferenceKey {
    let quantity = key.quantity();
    let (choices, units) = match quantity {
        Quantity::Choice(words) => (words.to_vec(), Vec::new()),
        Quantity::Effects => (Effect::OPTIONAL.map(Effect::name).to_vec(), Vec::new()),
        Quantity::Number(dimension) => (Vec::new(), dimension.units().collect()),
        Quantity::LengthUnit => (Dimension::Length.units().collect(), Vec::new()),
        Quantity::Lengths | Quantity::Places => (Vec::new(), Dimension::Length.units().collect()),
        _ => (Vec::new(), Vec::new()),
    };
    let unit = key.dimension().unit();
    // The base of a foundation is a word or a table.
    let is_table = !quantity.is_counted() && Table::find(key.pattern()).is_some();
    let noun = quantity.noun() + if is_table { " or a table" } else { "" };
    let table = Table::find(key.pattern().trim_end_matches("[i]"));
    // A list is a table too, and its meaning as a key is that of its column.
    let meaning = table.filter(Table::is_list).map_or(key.meaning(), |table| table.meaning);
    let mut varied_by = vec!["[sweep]"];
    varied_by.extend(is_drawable(key).then_some("[sample.keys]"));
    varied_by.extend(is_derivable(key).then_some("[derive]"));
    let refused = |kind: &Kind| {
        let reason = kind.refusal(key)?;
        Some(KindRefusal { kind: kind.name(), reason })
    };
    let shapes = shapes_of(key);
    ReferenceKey {
        name: key.name(),
        path: key.pattern().to_owned(),
        short: short(key.pattern()).to_owned(),
        column: Some(key.with_index(0).column().into_owned()),
        second_column: key.index().map(|_| key.with_index(1).column().into_owned()),
        values: bounded(&noun, &key.bounds().words(unit), quantity.is_counted()),
        choices,
        units,
        bounds: key.bounds().into(),
        default: key.fallback().written(unit),
        defaults_of_kinds: key
            .fallback()
            .of_kinds()
            .iter()
            .map(|(kind, default)| KindDefault { kind, default: *default })
            .collect(),
        left_out: key.fallback().words(unit),
        example: key.example(),
        meaning,
        varied_by,
        shapes: shapes
            .into_iter()
            .map(|(shape, is_needed)| ShapeUse { shape, is_needed })
            .collect(),
        refused_by: Kind::ALL.iter().filter_map(refused).collect(),
    }
}

/// Returns a table beside those of the scene and the numerics.
fn of_table(table: &KeyTable) -> ReferenceTable {
    let heading = match table.path {
        "" => String::new(),
        path if path.contains(ANY_KEY) => format!("{path} = {{ … }}"),
        _ => table.heading(),
    };
    ReferenceTable {
        path: table.path,
        heading,
        meaning: table.meaning,
        keys: table.keys.iter().map(|key| of_table_key(table, key)).collect(),
    }
}

fn of_table_key(table: &KeyTable, key: &TableKey) -> ReferenceKey {
    let path = match table.path {
        "" => key.name.to_owned(),
        path => format!("{path}.{}", key.name),
    };
    let choices = match key.values {
        TableValue::Word(words) => words.to_vec(),
        _ => Vec::new(),
    };
    let is_list = matches!(key.values, TableValue::Other(words) if words.starts_with("a list"));
    ReferenceKey {
        name: key.name,
        short: path.clone(),
        path,
        column: None,
        second_column: None,
        values: bounded(&key.values.noun(), &key.bounds.words(""), is_list),
        choices,
        units: Vec::new(),
        bounds: key.bounds.into(),
        default: key.fallback.written(""),
        defaults_of_kinds: Vec::new(),
        left_out: key.fallback.words(""),
        example: key.example,
        meaning: key.meaning,
        varied_by: Vec::new(),
        shapes: Vec::new(),
        refused_by: Vec::new(),
    }
}

/// Puts bounds behind a noun, or behind the number of the entries of a list.
fn bounded(noun: &str, bounds: &str, is_list: bool) -> String {
    match (bounds, is_list) {
        ("", _) => noun.trim_end_matches(',').to_owned(),
        (bounds, true) => format!("{noun}, {} of them", bounds.trim_start_matches("of ")),
        (bounds, false) => format!("{noun} {bounds}"),
    }
}
