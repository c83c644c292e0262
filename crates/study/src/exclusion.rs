//! The points of the axes that a study leaves out.
//!
//! ```toml
//! [[exclude]]                 # points for which one of these holds are left out
//! when = "layer0_thickness > 0.1 * radius"
//!
//! [[keep]]                    # only points for which one of these holds are kept
//! when = "mu <= 0.3 || shape == 'sphere'"
//! ```
//!
//! The conditions are those of `query --where`, over the axes and the keys that the study gives, by
//! the names of their columns or by their paths; values are in SI units. A key that a point does
//! not give is `null`. What is left out need not make sense: it is decided before a point becomes a
//! job. Points keep their indices, whatever is left out.

use std::borrow::Cow;

use toml::de::{DeTable, DeValue};

use condition::{Condition, ConditionNames, FilterError, FilterValue, UnknownColumn, ValueKind};
use contact::model::Mesh;

use crate::axis::{Group, Target};
use crate::bounds::ANY;
use crate::columns::Column;
use crate::error::{Mistake, Span, are_enough};
use crate::fallback::Fallback::Needed;
use crate::key::Key;
use crate::read::{self, Node, entries};
use crate::sheet::{Given, Setting, Sheet};
use crate::suggestion::nearest;
use crate::table_key::{CONDITION, KeyTable, TableKey, table_key};
use crate::value::{Value, ValueType};

/// The tables of conditions: those that exclude points, and those that keep them.
pub(crate) const TABLES: [KeyTable; 2] = [
    KeyTable {
        path: "exclude",
        is_list: true,
        meaning: "points that are left out: those for which one of these holds",
        keys: &[WHEN],
    },
    KeyTable {
        path: "keep",
        is_list: true,
        meaning: "points that are kept: only those for which one of these holds",
        keys: &[WHEN],
    },
];

const WHEN: TableKey = table_key(
    "when",
    CONDITION,
    ANY,
    Needed,
    "\"mu > 0.1\"",
    "condition on the axes and the keys that the study gives, in SI units",
);

/// The conditions that decide which points of the axes a study has.
#[derive(Clone, Debug)]
pub(crate) struct Exclusion {
    rules: Vec<ExclusionRule>,
    names: PointNames,
}

/// One condition.
#[derive(Clone, Debug)]
struct ExclusionRule {
    /// True if the condition keeps points, false if it excludes them.
    keeps: bool,
    condition: Condition,
    /// The text of the condition.
    text: String,
    span: Span,
}

/// The names of a point's axes and keys.
#[derive(Clone, Debug)]
struct PointNames(Vec<PointName>);

#[derive(Clone, Debug)]
struct PointName {
    column: Cow<'static, str>,
    /// The path, short and from the top; a label has none but its own.
    paths: [Cow<'static, str>; 2],
    kind: ValueKind,
    source: NameSource,
}

/// The place where the value of a name stands.
#[derive(Clone, Copy, Debug)]
enum NameSource {
    /// The label of the table that an axis sets, by the indices of the group and of the axis in it.
    Label { group: usize, axis: usize },
    /// A key of the sheet.
    Key(Key),
}

/// The number of points at which each condition of a study holds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HoldingCounts(Vec<usize>);

/// The decision of the conditions of a study about a point.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PointDecision {
    /// True if the point is left out.
    pub is_excluded: bool,
    /// The conditions that hold at it.
    pub holding: HoldingCounts,
}

impl HoldingCounts {
    /// Returns the counts with those of other points.
    pub fn with(mut self, other: HoldingCounts) -> HoldingCounts {
        self.0.resize(self.0.len().max(other.0.len()), 0);
        self.0.iter_mut().zip(other.0).for_each(|(count, other)| *count += other);
        self
    }
}

impl PointNames {
    /// Returns the names of the axes of some groups, and of the keys that a study gives.
    fn of(groups: &[Group], given: &[(Key, Given)], keys: impl Iterator<Item = Key>) -> Self {
        let mut names: Vec<PointName> = Vec::new();
        for (group, axes) in groups.iter().enumerate() {
            for (axis, swept) in axes.axes().iter().enumerate() {
                let Target::Table(table) = swept.target else { continue };
                names.push(PointName {
                    column: table.column(),
                    paths: [table.short(), table.path()],
                    kind: ValueKind::Text,
                    source: NameSource::Label { group, axis },
                });
            }
        }
        let has_pairs = given
            .iter()
            .chain(
                groups
                    .iter()
                    .flat_map(Group::axes)
                    .flat_map(|axis| &axis.choices)
                    .flat_map(|choice| &choice.given),
            )
            .any(|(_, given)| matches!(given.setting, Setting::Mesh(Mesh::Exact(_))));
        let mut seen = std::collections::HashSet::new();
        for key in keys.filter(|key| seen.insert(*key)) {
            let kind = match key.quantity().values() {
                ValueType::Text => ValueKind::Text,
                ValueType::Flag => ValueKind::Truth,
                // A mesh that is a pair is a text.
                _ if key == Key::Mesh && has_pairs => ValueKind::Unknown,
                ValueType::Number | ValueType::Integer => ValueKind::Number,
            };
            let paths = [key.short(), key.path()];
            names.push(PointName {
                column: key.column(),
                paths,
                kind,
                source: NameSource::Key(key),
            });
        }
        PointNames(names)
    }

    /// Returns the value of a name at a point.
    fn value(
        &self,
        index: usize,
        groups: &[Group],
        steps: &[usize],
        sheet: &Sheet<'_>,
    ) -> FilterValue<'static> {
        let value = self.0.get(index).and_then(|name| match name.source {
            NameSource::Label { group, axis } => {
                let choice = groups.get(group)?.choices(*steps.get(group)?).nth(axis)?;
                Some(choice.into_owned().shown)
            }
            NameSource::Key(key) => Some(Value::from(&sheet.get(key)?.setting)),
        });
        match value {
            Some(Value::Number(x)) => FilterValue::Number(x),
            Some(Value::Integer(n)) => {
                i64::try_from(n).map_or(FilterValue::Number(n as f64), FilterValue::Integer)
            }
            Some(Value::Flag(yes)) => FilterValue::Truth(yes),
            Some(Value::Text(text)) => FilterValue::Text(Cow::Owned(text)),
            Some(Value::Missing) | None => FilterValue::Missing,
        }
    }
}

impl ConditionNames for PointNames {
    fn find(&self, name: &str) -> Result<usize, UnknownColumn> {
        let is_meant =
            |known: &PointName| known.column == name || known.paths.iter().any(|path| path == name);
        self.0.iter().position(is_meant).ok_or_else(|| UnknownColumn {
            name: name.to_owned(),
            close: Vec::new(),
            columns: self.0.iter().map(|known| known.column.to_string()).collect(),
        })
    }

    fn kind(&self, index: usize) -> ValueKind {
        self.0.get(index).map_or(ValueKind::Unknown, |name| name.kind)
    }
}

impl Exclusion {
    /// Tells whether a point is left out, and at which conditions it counts.
    ///
    /// # Errors
    ///
    /// Returns the mistake of a condition that has no meaning at the point.
    pub(crate) fn excludes(
        &self,
        groups: &[Group],
        steps: &[usize],
        sheet: &Sheet<'_>,
    ) -> Result<PointDecision, Mistake> {
        let value = |index: usize| self.names.value(index, groups, steps, sheet);
        let mut holding = HoldingCounts(vec![0; self.rules.len()]);
        let (mut is_excluded, mut has_keep, mut is_kept) = (false, false, false);
        for (rule, count) in self.rules.iter().zip(&mut holding.0) {
            let truth = rule.condition.truth(&value).map_err(|message| {
                let expected = "must be a condition at every point";
                Mistake::new(rule.span.clone(), message, expected)
            })?;
            let holds = truth == Some(true);
            *count = usize::from(holds);
            has_keep |= rule.keeps;
            is_kept |= rule.keeps && holds;
            is_excluded |= !rule.keeps && holds;
        }
        Ok(PointDecision { is_excluded: is_excluded || (has_keep && !is_kept), holding })
    }

    /// Returns the mistake of conditions that leave no point.
    pub(crate) fn leaves_none(&self, points: usize) -> Mistake {
        let span = self.rules.first().map_or(0..0, |rule| rule.span.clone());
        let message = format!("the conditions leave none of the study's {points} points");
        let mistake = Mistake::new(span, message, "must leave at least one point");
        mistake.help("values in conditions are in SI units: 10 mm are 0.01")
    }

    /// Says which conditions change nothing, in the order of the file.
    pub(crate) fn idle(&self, points: usize, holding: &HoldingCounts) -> Vec<String> {
        let words = |(rule, count): (&ExclusionRule, &usize)| {
            let (table, text) =
                (TABLES[usize::from(rule.keeps)].path, wording::one_line(&rule.text));
            match (rule.keeps, *count) {
                (_, 0) => Some(format!("[[{table}]] `{text}` holds at no point")),
                (true, count) if count == points => {
                    Some(format!("[[{table}]] `{text}` holds at every point"))
                }
                _ => None,
            }
        };
        self.rules.iter().zip(&holding.0).filter_map(words).collect()
    }

    /// Returns the place of the first condition.
    pub(crate) fn place(&self) -> Span {
        self.rules.first().map_or(0..0, |rule| rule.span.clone())
    }

    /// Returns the place of the first condition that uses a key for which something holds.
    pub(crate) fn using(&self, is_meant: impl Fn(Key) -> bool) -> Option<Span> {
        let meant = |rule: &&ExclusionRule| {
            self.names.0.iter().enumerate().any(|(index, name)| match name.source {
                NameSource::Key(key) => is_meant(key) && rule.condition.uses(index),
                NameSource::Label { .. } => false,
            })
        };
        self.rules.iter().find(meant).map(|rule| rule.span.clone())
    }
}

/// Reads `[[exclude]]` and `[[keep]]` at the `root` of a study. `base` and `groups` are its own,
/// `keys` are all that it gives, and `columns` are those of its results as well.
pub(crate) fn read(
    root: &DeTable<'_>,
    base: &[(Key, Given)],
    groups: &[Group],
    keys: impl Iterator<Item = Key>,
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Option<Exclusion> {
    if TABLES.iter().all(|table| root.get(table.path).is_none()) {
        return None;
    }
    let names = PointNames::of(groups, base, keys);
    let mut rules = Vec::new();
    for (keeps, known) in [false, true].into_iter().zip(TABLES) {
        let table = known.path;
        let Some(node) = root.get(table) else { continue };
        let expected = format!("written [[{table}]], with when = \"…\" below it");
        let DeValue::Array(all) = node.get_ref() else {
            mistakes.push(read::mistyped(table, node, &expected));
            continue;
        };
        for node in all.iter() {
            if are_enough(mistakes) {
                break;
            }
            let DeValue::Table(below) = node.get_ref() else {
                mistakes.push(read::mistyped(table, node, &expected));
                continue;
            };
            read::refuse_unknown(below, &format!("`[[{table}]]`"), &known.names(), mistakes);
            let when = entries(below).into_iter().find(|(name, _)| name.get_ref() == "when");
            let Some((_, when)) = when else {
                let message = format!("a `[[{table}]]` without a condition");
                let mistake = Mistake::new(node.span(), message, "needs when = \"mu > 0.3\"");
                mistakes.push(mistake);
                continue;
            };
            match read_condition(&format!("{table}.when"), when, &names, columns) {
                Ok((text, condition)) => {
                    rules.push(ExclusionRule { keeps, condition, text, span: when.span() });
                }
                Err(mistake) => mistakes.push(mistake),
            }
        }
    }
    Some(Exclusion { rules, names }).filter(|exclusion| !exclusion.rules.is_empty())
}

fn read_condition(
    path: &str,
    node: &Node<'_>,
    names: &PointNames,
    columns: &[Column],
) -> Result<(String, Condition), Mistake> {
    let text = read::condition(path, node)?;
    match Condition::new(&text, names) {
        Ok(condition) => Ok((text, condition)),
        Err(FilterError::UnknownColumn(unknown)) => {
            Err(unknown_name(path, node, &unknown, columns))
        }
        Err(error) => {
            let words = error.to_string();
            let (first, rest) = words.split_once('\n').unwrap_or((&words, ""));
            Err(Mistake::new(node.span(), format!("`{path}` is no condition"), first).help(rest))
        }
    }
}

/// Makes the mistake of a name that no axis and no key has.
fn unknown_name(
    path: &str,
    node: &Node<'_>,
    UnknownColumn { name, columns: known, .. }: &UnknownColumn,
    columns: &[Column],
) -> Mistake {
    let mistake =
        |message: String, expected: &str| Mistake::new(node.span(), message, expected.to_owned());
    let key = Key::find(name).or_else(|| Key::of_column(name));
    if let Some(other) = key.and_then(Key::alternative)
        && known.iter().any(|known| *known == other.column())
    {
        let message = format!("`{path}`: the study gives no `{name}`");
        return mistake(message, &format!("the study gives `{}` in its place", other.column()));
    }
    if key.is_some() {
        let message = format!("`{path}`: the study gives no `{name}`");
        return mistake(message, "must be an axis or a key that the study gives")
            .help(format!("the study gives {}", known.join(", ")));
    }
    if columns.iter().any(|column| column.name == *name) {
        let message = format!(
            "`{path}`: `{name}` is a result, and the points are chosen before any is known"
        );
        return mistake(message, "must be an axis or a key that the study gives")
            .help("`query --where` selects by results");
    }
    let message = format!("`{path}`: there is no axis and no key `{name}`");
    match nearest(name, known.iter().map(String::as_str)) {
        Some(near) => mistake(message, &format!("did you mean `{near}`?"))
            .help(format!("the study gives {}", known.join(", "))),
        None => mistake(message, "must be an axis or a key that the study gives")
            .help(format!("the study gives {}", known.join(", "))),
    }
}
