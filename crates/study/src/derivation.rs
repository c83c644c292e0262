//! Keys that follow from others.
//!
//! ```toml
//! [derive]                    # a key as a formula of others, computed at every point
//! "foundation.layers[0].thickness" = "0.1 * punch.radius"
//! "loading.steps[0].approach" = "2 um + 1e-3 * radius"
//! ```
//!
//! The module [`formula`](crate::formula) tells what a formula may say. A key is given in one place
//! only: by the scene, by an axis or by a formula. Formulas may use each other, in any order,
//! without going in circles. A key of a layer or a step that a point does not have is not derived
//! there.

use std::borrow::Cow;

use toml::de::DeValue;

use contact::model::Mesh;

use crate::axis::{self, Group, SweepAxis, Target};
use crate::bounds::ANY;
use crate::error::{Mistake, Span, are_enough};
use crate::fallback::Fallback::Needed;
use crate::formula::{Formula, FormulaFault, UnitPowers};
use crate::key::Key;
use crate::quantity::Quantity;
use crate::read::{self, Node, entries};
use crate::sheet::{Given, Setting, Sheet};
use crate::suggestion::{nearest, nearest_path};
use crate::table_key::{ANY_KEY, KeyTable, TableValue, table_key};

/// The table.
pub(crate) const TABLE: KeyTable = KeyTable {
    path: "derive",
    is_list: false,
    meaning: "keys as formulas of others, computed at every point",
    keys: &[table_key(
        ANY_KEY,
        TableValue::Other("a formula"),
        ANY,
        Needed,
        "\"0.1 * punch.radius\"",
        "formula of the key at this path: + - * / ^, numbers with units, keys, and min, max, sqrt, \
         round … of them",
    )],
};

/// The keys that a study derives, those first that others are derived from.
#[derive(Clone, Debug, Default)]
pub(crate) struct Derivation(Vec<DerivedKey>);

#[derive(Clone, Debug)]
struct DerivedKey {
    key: Key,
    formula: Formula,
    /// The place of the name, and of the formula.
    name_span: Span,
    span: Span,
}

impl Derivation {
    /// Returns the keys that are derived.
    pub(crate) fn keys(&self) -> impl Iterator<Item = Key> + '_ {
        self.0.iter().map(|derived| derived.key)
    }

    /// Returns whether a formula stands at a place.
    pub(crate) fn has_place(&self, place: &Span) -> bool {
        self.0.iter().any(|derived| derived.span == *place)
    }

    /// Returns the place of the formula of a key.
    pub(crate) fn place(&self, key: Key) -> Option<Span> {
        self.0.iter().find(|derived| derived.key == key).map(|derived| derived.span.clone())
    }

    /// Returns whether a key follows from another one, directly or not.
    pub(crate) fn follows(&self, key: Key, from: Key) -> bool {
        let derived = self.0.iter().find(|derived| derived.key == key);
        derived.is_some_and(|derived| {
            derived.formula.keys().iter().any(|used| *used == from || self.follows(*used, from))
        })
    }

    /// Writes the derived keys on the sheet of a point, except those for which `is_given` holds.
    /// What cannot be derived is a mistake.
    pub(crate) fn apply(
        &self,
        sheet: &mut Sheet<'_>,
        is_given: impl Fn(Key) -> bool,
    ) -> Vec<Mistake> {
        let mut mistakes = Vec::new();
        for DerivedKey { key, formula, span, .. } in &self.0 {
            let is_absent = key.list().is_some_and(|list| key.index() >= Some(sheet.length(list)));
            if is_given(*key) || is_absent {
                continue;
            }
            match derived(*key, formula, sheet) {
                Ok(setting) => {
                    let given = Given { setting, span: span.clone(), nth: None };
                    sheet.set(*key, Cow::Owned(given));
                }
                Err(FormulaFault { message, expected }) => {
                    mistakes.push(Mistake::new(span.clone(), message, expected));
                }
            }
        }
        mistakes
    }
}

/// Returns the setting of a key by its formula.
fn derived(key: Key, formula: &Formula, sheet: &Sheet<'_>) -> Result<Setting, FormulaFault> {
    let fault =
        |message: String, expected: &str| FormulaFault { message, expected: expected.to_owned() };
    let value = formula.value(sheet).map_err(|missing| {
        let message = format!(
            "`{}` is derived from `{}`, which has no number at this point",
            key.short(),
            missing.short()
        );
        fault(message, "needs it at every point")
    })?;
    if !value.is_finite() {
        let message = format!("`{}` would be {value}", key.short());
        return Err(fault(message, "must be a finite number at every point"));
    }
    let is_count = value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value);
    match key.quantity() {
        // −0 becomes 0, so that the two are one job.
        Quantity::Number(_) => Ok(Setting::Number(value + 0.0)),
        Quantity::Mesh if is_count => Ok(Setting::Mesh(Mesh::Across(value as u32))),
        _ if is_count => Ok(Setting::Count(value as u32)),
        _ => {
            let message = format!("`{}` would be {value}", key.short());
            Err(fault(message, "must be a whole number, 0 or above: round(…), floor(…), ceil(…)"))
        }
    }
}

/// Reads `[derive]`. `base` and `groups` are the study's, and formulas may use the keys that it has
/// `chosen` as well.
pub(crate) fn read(
    node: &Node<'_>,
    base: &[(Key, Given)],
    chosen: &[Key],
    groups: &[Group],
    mistakes: &mut Vec<Mistake>,
) -> Derivation {
    let mut written = Vec::new();
    collect("", node, &mut written, mistakes);
    written.sort_by_key(|written: &WrittenKey<'_, '_>| written.name_span.start);
    let of_formulas = written.iter().map(|written| written.key);
    let given: Vec<Key> =
        axis::keys(base, groups).chain(chosen.iter().copied()).chain(of_formulas).collect();
    let find = |name: &str| find(name, &given);
    let mut all: Vec<DerivedKey> = Vec::new();
    for WrittenKey { key, name_span, node } in written {
        if are_enough(mistakes) {
            break;
        }
        let before = mistakes.len();
        mistakes.extend(refuse_place(key, &name_span, base, groups));
        if let Some(other) =
            all.iter().find(|other| other.key == key || other.key.alternative() == Some(key))
        {
            let message = format!("`{}` is derived twice", key.short());
            let mistake = Mistake::new(name_span.clone(), message, "may be derived only once");
            mistakes.push(mistake.context(other.name_span.clone(), "first here"));
        }
        if mistakes.len() > before {
            continue;
        }
        match read_formula(key, node, &find) {
            Ok(formula) => {
                all.push(DerivedKey { key, formula, name_span, span: node.span() });
            }
            Err(mistake) => mistakes.push(mistake),
        }
    }
    ordered(all).unwrap_or_else(|mistake| {
        mistakes.push(mistake);
        Derivation::default()
    })
}

/// An entry of `[derive]`.
struct WrittenKey<'t, 'i> {
    key: Key,
    name_span: Span,
    node: &'t Node<'i>,
}

/// Collects the entries of `[derive]`. A key without quotes, `punch.radius = …`, arrives as nested
/// tables.
fn collect<'t, 'i>(
    prefix: &str,
    node: &'t Node<'i>,
    written: &mut Vec<WrittenKey<'t, 'i>>,
    mistakes: &mut Vec<Mistake>,
) {
    let DeValue::Table(table) = node.get_ref() else {
        let expected = "a table of keys with their formulas";
        return mistakes.push(read::mistyped("derive", node, expected));
    };
    for (name, node) in entries(table) {
        if are_enough(mistakes) {
            return;
        }
        let path = match prefix {
            "" => name.get_ref().to_string(),
            prefix => format!("{prefix}.{}", name.get_ref()),
        };
        match (Key::find(&path), node.get_ref()) {
            (_, DeValue::Table(_)) if crate::key::Table::find(&path).is_some() => {
                collect(&path, node, written, mistakes);
            }
            (Some(key), _) => written.push(WrittenKey { key, name_span: name.span(), node }),
            (None, _) => {
                let message = format!("there is no key `{path}` to derive");
                let expected = match nearest_path(crate::key::short(&path)) {
                    Some(near) => format!("did you mean \"{near}\"?"),
                    None => "must be a key of the scene or the numerics".to_owned(),
                };
                mistakes.push(Mistake::new(name.span(), message, expected));
            }
        }
    }
}

/// Returns the key of those that are given that a name means.
fn find(name: &str, given: &[Key]) -> Result<Key, FormulaFault> {
    let fault = |message: String, expected: String| FormulaFault { message, expected };
    match Key::find(name).or_else(|| Key::of_column(name)) {
        Some(key) if given.contains(&key) => Ok(key),
        Some(key) => {
            let other = key.alternative().filter(|other| given.contains(other));
            Err(fault(
                format!("the study gives no `{name}`"),
                match other {
                    Some(other) => format!("the study gives `{}` in its place", other.short()),
                    None => "must be a key that the study gives".to_owned(),
                },
            ))
        }
        None => {
            let names: Vec<_> = given.iter().flat_map(|key| [key.short(), key.column()]).collect();
            Err(fault(
                format!("there is no key `{name}`"),
                match nearest(name, names.iter().map(|name| name.as_ref())) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => "must be a key that the study gives".to_owned(),
                },
            ))
        }
    }
}

/// Returns whether a key may be a formula of others.
pub(crate) fn is_derivable(key: Key) -> bool {
    let is_number =
        matches!(key.quantity(), Quantity::Number(_) | Quantity::Count | Quantity::Mesh);
    is_number && key != Key::MissingValue
}

/// Refuses to derive a key that is given elsewhere, that is no number, or that stands in a list
/// which does not have it.
fn refuse_place(key: Key, span: &Span, base: &[(Key, Given)], groups: &[Group]) -> Option<Mistake> {
    let mistake = |message: String, expected: &str| Mistake::new(span.clone(), message, expected);
    let path = key.short();
    if key == Key::MissingValue {
        let message = format!("`{path}` says how a file is read, before anything is derived");
        return Some(mistake(message, "must be given by the scene"));
    }
    if !is_derivable(key) {
        let message = format!("`{path}` is no number");
        return Some(mistake(message, "only numbers are derived"));
    }
    let is_same = |other: Key| other == key || key.alternative() == Some(other);
    if let Some((_, given)) = base.iter().find(|(other, _)| is_same(*other)) {
        let message = format!("`{path}` is given, and derived as well");
        return Some(
            mistake(message, "give one of the two").context(given.span.clone(), "given here"),
        );
    }
    let axes = || groups.iter().flat_map(Group::axes);
    let sets = |axis: &&SweepAxis| {
        let mut given = axis.choices.iter().flat_map(|choice| &choice.given);
        axis.key().is_some_and(is_same) || given.any(|(other, _)| is_same(*other))
    };
    if let Some(axis) = axes().find(sets) {
        let message = format!("`{path}` is set by an axis, and derived as well");
        let mistake = mistake(message, "give one of the two");
        return Some(mistake.context(axis.span.clone(), "the axis is here"));
    }
    let list = key.list()?;
    let is_varied = axes().any(|axis| axis.target.overlaps(Target::Key(list)));
    if is_varied || key.index() < Some(axis::entries(list, base, groups)) {
        return None;
    }
    let message = format!("there is no `{path}`: the scene's `{}` has no such entry", list.name());
    Some(mistake(message, "needs the entry in the scene"))
}

fn read_formula(
    key: Key,
    node: &Node<'_>,
    find: &dyn Fn(&str) -> Result<Key, FormulaFault>,
) -> Result<Formula, Mistake> {
    let path = key.short();
    if !matches!(node.get_ref(), DeValue::String(_)) {
        let expected = "a formula like \"0.1 * punch.radius\"; what is fixed stands in the scene";
        return Err(read::mistyped(&path, node, expected));
    }
    let text = read::text(&path, node)?;
    let formula = Formula::read(&text, find).map_err(|FormulaFault { message, expected }| {
        Mistake::new(node.span(), format!("`{path}`: {message}"), expected)
    })?;
    let wanted = UnitPowers::of(key.dimension());
    if !formula.dimension().fits(wanted) {
        let found = formula.dimension().noun();
        let message =
            format!("`{path}` is {}, and its formula gives {found}", key.dimension().noun());
        let unit = key.dimension().unit();
        let mistake =
            Mistake::new(node.span(), message, format!("must give {}", key.dimension().noun()));
        return Err(match unit {
            "" => mistake,
            unit => mistake.help(format!("a number gets a unit as in 0.002 {unit}")),
        });
    }
    Ok(formula)
}

/// Sorts derived keys, those first that others are derived from; keys that go in a circle are a
/// mistake.
fn ordered(mut all: Vec<DerivedKey>) -> Result<Derivation, Mistake> {
    let mut sorted: Vec<DerivedKey> = Vec::new();
    while !all.is_empty() {
        let is_free = |derived: &DerivedKey| {
            derived.formula.keys().iter().all(|used| all.iter().all(|other| other.key != *used))
        };
        match all.iter().position(is_free) {
            Some(free) => sorted.push(all.remove(free)),
            None => return Err(circle(&all)),
        }
    }
    Ok(Derivation(sorted))
}

/// Makes the mistake of keys of which each uses another of them.
fn circle(all: &[DerivedKey]) -> Mistake {
    let next = |of: &DerivedKey| {
        of.formula.keys().iter().find_map(|used| all.iter().position(|other| other.key == *used))
    };
    let mut path = vec![0];
    while let Some(index) = next(&all[path[path.len() - 1]]) {
        if let Some(first) = path.iter().position(|known| *known == index) {
            path.drain(..first);
            path.push(index);
            break;
        }
        path.push(index);
    }
    let names: Vec<String> =
        path.iter().map(|index| format!("`{}`", all[*index].key.short())).collect();
    let message = format!("a key is derived from itself: {}", names.join(" from "));
    Mistake::new(all[path[0]].span.clone(), message, "must not lead back to the key")
}
