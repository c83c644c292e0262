//! Refuses axes that are too many, that repeat themselves, or that do not fit each other or the
//! scene.

use std::collections::HashMap;

use toml::de::{DeTable, DeValue};

use super::range::is_range;
use crate::axis::{
    Choice, ChoiceIdentity, Group, MAX_AXES, MAX_ENTRIES, MAX_POINTS, SweepAxis, Target, entries,
};
use crate::error::{Mistake, are_enough};
use crate::key::Key;
use crate::read::Node;
use crate::sheet::{Given, Setting, Sheet};

/// The size of a `[sweep]`, counted before anything is made of it.
#[derive(Default)]
struct Amount {
    axes: usize,
    values: usize,
}

impl Amount {
    /// Adds what stands below a table or a value of `[sweep]`.
    fn add(&mut self, node: &Node<'_>) {
        match node.get_ref() {
            DeValue::Table(below) if !is_range(node) => {
                below.iter().for_each(|(_, node)| self.add(node));
            }
            DeValue::Table(range) => {
                self.axes += 1;
                let count = match range.get("count").map(|count| count.get_ref()) {
                    Some(DeValue::Integer(n)) => usize::from_str_radix(n.as_str(), n.radix()).ok(),
                    _ => None,
                };
                // A range that is too long by itself is refused at its place.
                let counted = count.filter(|count| *count <= MAX_POINTS).unwrap_or(0);
                self.values = self.values.saturating_add(counted);
            }
            DeValue::Array(values) => {
                self.axes += 1;
                self.values = self.values.saturating_add(values.len());
            }
            _ => self.axes += 1,
        }
    }
}

/// Refuses a `[sweep]` of more axes or values than a study may have, before any of them is read.
pub(super) fn refuse_excess(table: &DeTable<'_>, node: &Node<'_>) -> Option<Mistake> {
    let mut amount = Amount::default();
    for (name, node) in table.iter() {
        match node.get_ref() {
            DeValue::Array(zips) if name.get_ref() == "zip" => {
                zips.iter().for_each(|zip| amount.add(zip));
            }
            _ => amount.add(node),
        }
    }
    let mistake = |message: String, expected: String| Mistake::new(node.span(), message, expected);
    if amount.axes > MAX_AXES {
        let message = format!("the sweep has {} axes", amount.axes);
        return Some(mistake(message, format!("must have at most {MAX_AXES}")));
    }
    (amount.values > MAX_POINTS).then(|| {
        let message = format!("the axes have {} values in all", amount.values);
        mistake(message, format!("must have at most {MAX_POINTS}"))
    })
}

/// Refuses an axis by itself that names a value twice.
pub(crate) fn refuse_repeats(axis: &SweepAxis, mistakes: &mut Vec<Mistake>) {
    let mut seen: HashMap<ChoiceIdentity, &Choice> = HashMap::new();
    for choice in &axis.choices {
        if let Some(first) = seen.insert(choice.identity(), choice) {
            let message = format!("the axis `{}` names {} twice", axis.path(), choice.shown);
            let expected = match choice.given.as_slice() {
                [(_, given)] if given.span == choice.span => "the values of an axis must differ",
                _ => "needs a `label` of its own",
            };
            mistakes.push(
                Mistake::new(choice.span.clone(), message, expected)
                    .context(first.span.clone(), "first here"),
            );
            return;
        }
    }
}

/// Refuses axes that advance together if two of their steps are the same, or if a label stands for
/// two tables. A value may occur as often as others change beside it.
pub(super) fn refuse_repeated_rows(axes: &[SweepAxis], mistakes: &mut Vec<Mistake>) {
    let before = mistakes.len();
    for axis in axes.iter().filter(|axis| matches!(axis.target, Target::Table(_))) {
        let mut labelled: HashMap<ChoiceIdentity, &Choice> = HashMap::new();
        for choice in &axis.choices {
            let first = *labelled.entry(choice.identity()).or_insert(choice);
            if !choice.sets_the_same(first) {
                let message =
                    format!("the axis `{}` names two tables {}", axis.path(), choice.shown);
                let mistake =
                    Mistake::new(choice.span.clone(), message, "needs a `label` of its own");
                mistakes.push(mistake.context(first.span.clone(), "the other one"));
                break;
            }
        }
    }
    let (Some(first), true) = (axes.first(), mistakes.len() == before) else { return };
    let mut seen: HashMap<Vec<ChoiceIdentity>, usize> = HashMap::new();
    for (step, choice) in first.choices.iter().enumerate() {
        let row = axes.iter().filter_map(|axis| Some(axis.choices.get(step)?.identity()));
        if let Some(earlier) = seen.insert(row.collect(), step) {
            let message = format!(
                "axes that advance together are at their step {} where they are at step {}",
                step + 1,
                earlier + 1
            );
            let mistake = Mistake::new(choice.span.clone(), message, "must differ on one axis");
            let place = first.choices.get(earlier).map_or(0..0, |choice| choice.span.clone());
            mistakes.push(mistake.context(place, "first here"));
            return;
        }
    }
}

pub(crate) fn refuse_overlaps(groups: &[Group], mistakes: &mut Vec<Mistake>) {
    let axes: Vec<&SweepAxis> = groups.iter().flat_map(|group| &group.axes).collect();
    for (index, axis) in axes.iter().enumerate() {
        if are_enough(mistakes) {
            return;
        }
        if let Some(owner) = axes[..index].iter().find(|owner| owner.target.overlaps(axis.target)) {
            let message = match owner.path() == axis.path() {
                true => format!("two axes vary `{}`", axis.path()),
                false => {
                    format!("two axes, `{}` and `{}`, set the same keys", owner.path(), axis.path())
                }
            };
            mistakes.push(
                Mistake::new(axis.span.clone(), message, "only one axis may set a key")
                    .context(owner.span.clone(), "the other one"),
            );
        }
    }
}

/// Returns the mistake of so many points whose load steps, layers, and planes and points below the
/// surface are too many in all, although each has no more than it may.
pub(crate) fn too_many_entries(
    groups: &[Group],
    base: &[(Key, Given)],
    points: usize,
) -> Option<Mistake> {
    let choices = groups.iter().flat_map(|group| &group.axes).flat_map(|axis| &axis.choices);
    let given = || base.iter().chain(choices.clone().flat_map(|choice| &choice.given));
    let longest = |list: Key| {
        let lengths = given().filter_map(|(key, given)| match given.setting {
            Setting::Count(length) if *key == list => Some(length as usize),
            Setting::Lengths(ref depths) if *key == list => Some(depths.len()),
            Setting::Places(ref places) if *key == list => Some(places.len()),
            _ => None,
        });
        lengths.max().unwrap_or(0)
    };
    let lists = [Key::Layers, Key::Steps, Key::InteriorDepths, Key::InteriorPoints];
    let below = longest(Key::InteriorDepths) + longest(Key::InteriorPoints);
    let entries = lists.into_iter().map(longest).sum::<usize>();
    let place = groups.iter().flat_map(|group| &group.axes).max_by_key(|axis| axis.choices.len());
    (points.saturating_mul(entries) > MAX_ENTRIES).then(|| {
        Mistake::new(
            place.map_or(0..0, |axis| axis.span.clone()),
            match below {
                0 => format!("{points} points with up to {entries} load steps and layers each"),
                _ => format!(
                    "{points} points with up to {entries} load steps, layers, and planes and \
                     points below the surface each"
                ),
            },
            format!("must be at most {MAX_ENTRIES} in all"),
        )
    })
}

/// Refuses axes over a key in whose place the scene gives another.
pub(crate) fn refuse_alternatives(
    groups: &[Group],
    base: &[(Key, Given)],
    mistakes: &mut Vec<Mistake>,
) {
    for axis in groups.iter().flat_map(|group| &group.axes) {
        let Some(other) = axis.key().and_then(Key::alternative) else { continue };
        if let Some((_, given)) = base.iter().find(|(key, _)| *key == other) {
            let message = format!(
                "the axis `{}` cannot stand beside `{}`: each follows from the other",
                axis.path(),
                other.short()
            );
            let mistake = Mistake::new(axis.span.clone(), message, "give one of the two");
            mistakes.push(mistake.context(given.span.clone(), "the other is here"));
        }
    }
}

/// Refuses axes over entries that a list of the scene does not have.
pub(crate) fn refuse_absent(groups: &[Group], base: &[(Key, Given)], mistakes: &mut Vec<Mistake>) {
    for list in [Key::Layers, Key::Steps] {
        let axes = || {
            groups
                .iter()
                .flat_map(|group| &group.axes)
                .filter_map(|axis| Some((axis, axis.target.entry()?)))
        };
        let in_list =
            || axes().filter(|(_, (of, _))| *of == list).map(|(axis, (_, index))| (axis, index));
        let scene = Sheet::new(base.iter().map(|(key, given)| (*key, given)));
        let length = entries(list, base, groups);
        let has = match scene.get(list) {
            Some(_) => "has",
            None => "is missing and would have",
        };
        for (axis, index) in in_list().filter(|(_, index)| *index >= length) {
            let found = match length {
                0 => "no entries".to_owned(),
                1 => "one entry, [0]".to_owned(),
                n => format!("{n} entries, [0] to [{}]", n - 1),
            };
            let message = format!(
                "there is no `{}[{index}]`: the scene's `{}` {has} {found}",
                list.short(),
                list.name()
            );
            let mistake = Mistake::new(
                axis.span.clone(),
                message,
                format!("needs an entry of `scene.{}` to vary", list.short()),
            );
            mistakes.push(match scene.get(list) {
                Some(given) => mistake.context(given.span.clone(), "the entries are here"),
                None => mistake,
            });
        }
    }
}
