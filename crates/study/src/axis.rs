//! The axes of a study: the keys that it varies, the values that they take, and the points that the
//! axes make together.
//!
//! The axes stand under `[sweep]`, in the order of the file, the fastest one last:
//!
//! ```toml
//! [sweep]
//! "friction.mu" = [0.1, 0.3, 0.5]            # a list
//! mesh = { from = 16, to = 64, count = 4 }   # equal steps, both ends included
//! # equal ratios
//! "loading.steps[0].approach" = { log = true, from = "1 um", to = "1 mm", count = 7 }
//!
//! [[sweep.zip]]                              # axes that advance together count as one
//! punch = [                                  # a whole table; `label` names it in the results
//!     { shape = "flat-disk", radius = "1 mm", label = "disk" },
//!     { shape = "sphere", radius = "50 mm" },    # without a label, its shape names the punch
//! ]
//! "foundation.base.shear_modulus" = ["80 GPa", "8 GPa"]
//! ```
//!
//! Several blocks `[[sweep]]` in the place of `[sweep]` have their points joined: those of the axes
//! of the first, then those of the second, and so on. A key that a block does not vary has the
//! scene's value there, and a point of two blocks counts once.
//!
//! A table that is a value of an axis replaces the table of the file as a whole. An axis over a
//! list (`foundation.layers`, `loading.steps`) has lists as values, `[[], [{ … }], [{ … }, { …
//! }]]`, or tables that give them a name, `{ label = "coated", layers = [{ … }] }`. An axis over
//! `foundation.base` has tables and the word `"rigid"`. An axis over an entry of a list,
//! `"loading.steps[1].shift_x"`, needs the entry in the scene; only a list that the scene leaves
//! out altogether is made of what the axes set. The values between the ends of a range are rounded
//! to 15 significant digits (13 with equal ratios). The range `{ from = 0, to = 1, count = 11 }`
//! therefore holds 0.3 and not 0.30000000000000004, and shares its results with a list that says
//! 0.3. No axis by itself names a value twice. Of axes that advance together, no
//! two steps are the same.
//!
//! The axes of `[sample]` (see [`sample`](crate::sample)) advance together as well, but no text
//! lists their values: each step is a point of a [`Design`], and an axis turns a coordinate of it
//! into a value by its [`Distribution`].

use std::borrow::Cow;
use std::collections::HashSet;

use crate::design::Design;
use crate::distribution::Distribution;
use crate::error::{Mistake, Span};
use crate::key::{Key, Table};
use crate::sheet::{Given, Setting, Sheet};
use crate::units::Compact;
use crate::value::Value;

/// The largest number of points that are in memory at a time, and of the values of all axes of a
/// study.
pub(crate) const MAX_POINTS: usize = 200_000;

/// The largest number of points of one run. They must be those of the axes alone: what is drawn,
/// chosen, left out by a condition or compared is in memory.
pub(crate) const MAX_RUN_POINTS: usize = 1_000_000;

/// The largest number of shards of a study.
pub(crate) const MAX_SHARDS: u32 = 65_536;

/// The largest number of points of a study that is run in shards.
pub(crate) const MAX_SHARDED_POINTS: usize = MAX_POINTS * MAX_SHARDS as usize;

/// The largest number of load steps and layers of all points together. Each takes some 250 bytes.
pub(crate) const MAX_ENTRIES: usize = 2_000_000;

/// The largest number of axes of one study.
pub(crate) const MAX_AXES: usize = 1000;

/// One axis of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepAxis {
    pub(crate) target: Target,
    /// Its values; for an axis of a sample those of a discrete distribution.
    pub(crate) choices: Vec<Choice>,
    /// The distribution from which a sample draws its values.
    pub(crate) distribution: Option<Distribution>,
    pub(crate) log: bool,
    pub(crate) span: Span,
}

/// The key or table that an axis sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Target {
    Key(Key),
    Table(Table),
}

impl Target {
    /// Returns the path of the key or table, as short as a study file may write it.
    fn path(self) -> Cow<'static, str> {
        match self {
            Target::Key(key) => key.short(),
            Target::Table(table) => table.short(),
        }
    }

    /// Returns whether the two set a key in common, or keys of which one stands for the other.
    pub(crate) fn overlaps(self, other: Target) -> bool {
        match (self, other) {
            (Target::Key(a), Target::Key(b)) => a == b || a.alternative() == Some(b),
            (Target::Key(key), Target::Table(table)) | (Target::Table(table), Target::Key(key)) => {
                key.is_under(&table)
            }
            (Target::Table(a), Target::Table(b)) => a.is_under(&b) || b.is_under(&a),
        }
    }

    /// Returns the list in which it is an entry, or a key of an entry, and the index of the entry.
    pub(crate) fn entry(self) -> Option<(Key, u32)> {
        match self {
            Target::Key(key) => Some((key.list()?, key.index()?)),
            Target::Table(table) => Some((table.list()?, table.index()?)),
        }
    }
}

/// One value of an axis: the cell that shows it, and the keys that it sets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Choice {
    pub(crate) shown: Value,
    pub(crate) given: Vec<(Key, Given)>,
    pub(crate) span: Span,
}

/// The part of a value that makes it differ from others of its axis. Bits count, not digits: two
/// values are the same if they make the same job.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(crate) enum ChoiceIdentity {
    Number(u64),
    Word(String),
}

impl Choice {
    /// Returns the value of an axis over a key. `nth` counts the values of a range from 1.
    pub(crate) fn of_key(key: Key, setting: Setting, span: Span, nth: Option<usize>) -> Self {
        let shown = match Value::from(&setting) {
            // Every value of an axis has a name.
            Value::Missing => Value::Text("none".to_owned()),
            value => value,
        };
        Choice { shown, given: vec![(key, Given { setting, span: span.clone(), nth })], span }
    }

    /// Returns what makes the value differ from others of its axis.
    pub(crate) fn identity(&self) -> ChoiceIdentity {
        match &self.shown {
            Value::Number(x) => ChoiceIdentity::Number((x + 0.0).to_bits()),
            value => ChoiceIdentity::Word(value.to_string()),
        }
    }

    /// Returns whether it sets the same keys to the same values as another.
    pub(crate) fn sets_the_same(&self, other: &Choice) -> bool {
        self.given.len() == other.given.len()
            && self.given.iter().zip(&other.given).all(|((key, given), (other_key, other))| {
                key == other_key && given.setting == other.setting
            })
    }
}

impl SweepAxis {
    /// Returns the path of the key or table that it sets, as short as a study file may write it.
    pub fn path(&self) -> Cow<'static, str> {
        self.target.path()
    }

    /// Returns the name of the column that shows it.
    pub fn column(&self) -> Cow<'static, str> {
        match self.target {
            Target::Key(key) => key.column(),
            Target::Table(table) => table.column(),
        }
    }

    /// Returns the key that it sets; `None` if it sets a whole table.
    pub fn key(&self) -> Option<Key> {
        match self.target {
            Target::Key(key) => Some(key),
            Target::Table(_) => None,
        }
    }

    /// Returns the distribution from which a sample draws its values; `None` if they are listed.
    pub fn distribution(&self) -> Option<&Distribution> {
        self.distribution.as_ref()
    }

    /// Returns its values, in order; none if they are numbers that a sample draws.
    pub fn values(&self) -> impl ExactSizeIterator<Item = &Value> {
        self.choices.iter().map(|choice| &choice.shown)
    }

    /// Returns whether it was given as a range of equal ratios, or is drawn by its logarithm.
    pub fn is_log(&self) -> bool {
        self.log
    }

    /// Returns whether its values are numbers.
    pub(crate) fn is_numeric(&self) -> bool {
        // A drawn number has no values that are listed.
        self.values().all(|value| matches!(value, Value::Number(_) | Value::Integer(_)))
    }

    /// Returns the number of different values. Values may repeat if the axis advances with others.
    pub(crate) fn distinct(&self) -> usize {
        self.choices.iter().map(Choice::identity).collect::<HashSet<_>>().len()
    }

    /// Returns whether no value repeats.
    pub(crate) fn is_distinct(&self) -> bool {
        self.distinct() == self.choices.len()
    }

    /// Returns the value at a part of its distribution, above 0 and below 1; `None` if its values
    /// are listed.
    fn drawn(&self, part: f64) -> Option<Cow<'_, Choice>> {
        match self.distribution.as_ref()? {
            Distribution::Discrete(weights) => {
                self.choices.get(weights.index(part)).map(Cow::Borrowed)
            }
            distribution => {
                let setting = Setting::Number(distribution.quantile(part));
                let choice = Choice::of_key(self.key()?, setting, self.span.clone(), None);
                Some(Cow::Owned(choice))
            }
        }
    }

    /// Turns a mistake about the value at a part of its distribution, which is near one of the
    /// ends, into a mistake about the distribution.
    pub(crate) fn beyond(&self, part: f64, mistake: Mistake) -> Mistake {
        let Some(distribution) = &self.distribution else { return mistake };
        let value = match self.drawn(part).map(|choice| choice.into_owned().shown) {
            Some(Value::Number(value)) => value,
            _ => return mistake,
        };
        let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
        let size = if part < 0.5 { "small" } else { "large" };
        let drawn = format!("`{}` may be drawn as {size} as {}", self.path(), Compact(rounded));
        if mistake.span != self.span {
            // Something that follows from the key has no meaning there.
            return match mistake.help.is_empty() {
                true => mistake.help(drawn),
                false => mistake,
            };
        }
        let mistake = Mistake { message: drawn, ..mistake };
        match distribution {
            Distribution::Normal(_) | Distribution::LogNormal { .. } => {
                mistake.help("`from` and `to` bound the distribution")
            }
            _ => mistake,
        }
    }

    /// Writes one of its values on a sheet.
    fn apply<'a>(&self, choice: Cow<'a, Choice>, sheet: &mut Sheet<'a>) {
        if let Target::Table(table) = &self.target {
            sheet.clear(table);
        }
        match choice {
            Cow::Borrowed(choice) => {
                for (key, given) in &choice.given {
                    sheet.set(*key, Cow::Borrowed(given));
                }
            }
            Cow::Owned(choice) => {
                for (key, given) in choice.given {
                    sheet.set(key, Cow::Owned(given));
                }
            }
        }
    }
}

/// Axes that advance together; an axis that advances alone is a group of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    pub(crate) axes: Vec<SweepAxis>,
    pub(crate) length: usize,
    /// The design whose points are the steps of a sample, with a dimension for each axis.
    pub(crate) design: Option<Design>,
    /// The place of the number of points of a sample.
    pub(crate) count: Span,
}

impl Group {
    /// Makes a group of axes whose values are listed; each has `length` of them.
    pub(crate) fn listed(axes: Vec<SweepAxis>, length: usize) -> Group {
        Group { axes, length, design: None, count: 0..0 }
    }

    /// Returns the design whose points are the steps, if the axes are those of a sample.
    pub fn design(&self) -> Option<&Design> {
        self.design.as_ref()
    }

    /// Returns the value of each axis at a step.
    pub(crate) fn choices(&self, step: usize) -> impl Iterator<Item = Cow<'_, Choice>> {
        self.axes.iter().enumerate().filter_map(move |(dimension, axis)| match &self.design {
            Some(design) => axis.drawn(design.coordinate(step as u32, dimension)),
            None => axis.choices.get(step).map(Cow::Borrowed),
        })
    }

    /// Writes the values of a step on a sheet.
    pub(crate) fn apply<'a>(&'a self, step: usize, sheet: &mut Sheet<'a>) {
        for (axis, choice) in self.axes.iter().zip(self.choices(step)) {
            axis.apply(choice, sheet);
        }
    }

    /// Returns the value of each axis of a sample at a point of the unit cube.
    pub(crate) fn drawn_values(&self, parts: &[f64]) -> Vec<Value> {
        let drawn = self.axes.iter().zip(parts).filter_map(|(axis, part)| axis.drawn(*part));
        drawn.map(|choice| choice.into_owned().shown).collect()
    }

    /// Writes the values of a sample at a point of the unit cube on a sheet.
    pub(crate) fn draw<'a>(&'a self, parts: &[f64], sheet: &mut Sheet<'a>) {
        for (axis, part) in self.axes.iter().zip(parts) {
            axis.drawn(*part).into_iter().for_each(|choice| axis.apply(choice, sheet));
        }
    }

    /// Returns the axes in the order of the file. There is at least one, and all have
    /// [`len`](Group::len) values.
    pub fn axes(&self) -> &[SweepAxis] {
        &self.axes
    }

    /// Returns the axes that tell its steps apart: the first that does so by itself, else all, as
    /// in a sample.
    pub fn telling(&self) -> &[SweepAxis] {
        let is_telling = |axis: &SweepAxis| self.design.is_none() && axis.is_distinct();
        // Of one axis nothing needs to be asked, and it may have many values.
        let telling = match self.axes.len() {
            1 => None,
            _ => self.axes.iter().position(is_telling),
        };
        telling.map_or(&self.axes[..], |axis| &self.axes[axis..=axis])
    }

    /// Returns the number of steps that the group makes, at least one.
    #[expect(clippy::len_without_is_empty, reason = "a group is never empty")]
    pub fn len(&self) -> usize {
        self.length
    }
}

/// Returns the number of points that the groups make; `None` beyond [`MAX_SHARDED_POINTS`].
pub(crate) fn count(groups: &[Group]) -> Option<usize> {
    groups.iter().try_fold(1usize, |product, group| {
        product.checked_mul(group.length).filter(|count| *count <= MAX_SHARDED_POINTS)
    })
}

/// Returns the step of each group at a point; the last group is the fastest.
pub(crate) fn steps(groups: &[Group], mut point: usize) -> Vec<usize> {
    let mut steps = vec![0; groups.len()];
    for (step, group) in steps.iter_mut().zip(groups).rev() {
        *step = point % group.length;
        point /= group.length;
    }
    steps
}

/// Returns the level of a step among `length` of them: 0 for both ends, 1 for the middle, and one
/// more for each halving that leads to it. The steps up to any level are a coarse grid.
fn level(step: usize, length: usize) -> u32 {
    let last = length.saturating_sub(1).max(1) as u128;
    let is_on = |level: &u32| {
        let parts = 1u128 << level;
        let part = (step as u128 * parts).div_ceil(last);
        step as u128 == part * last / parts
    };
    (0..u64::BITS).find(is_on).unwrap_or(u64::BITS)
}

/// The levels of the points of a study. The points up to any level are a coarse grid of all axes,
/// and the first half, quarter and so on of a sample.
pub struct PointLevels<'s> {
    groups: &'s [Group],
    /// Some axis of each group is of numbers, which is seen of all of its values.
    are_numeric: Vec<bool>,
}

impl<'s> PointLevels<'s> {
    pub(crate) fn of(groups: &'s [Group]) -> Self {
        let is_numeric = |group: &Group| group.axes.iter().any(SweepAxis::is_numeric);
        PointLevels { groups, are_numeric: groups.iter().map(is_numeric).collect() }
    }

    /// Returns the level of the `index`-th point: that of its finest step along an axis of numbers.
    pub fn level(&self, index: usize) -> u32 {
        let steps = steps(self.groups, index);
        let levels = self.groups.iter().zip(&self.are_numeric).zip(steps);
        let levels = levels.map(|((group, is_numeric), step)| match group.design {
            Some(_) => usize::BITS - step.leading_zeros(),
            None if *is_numeric => level(step, group.length),
            None => 0,
        });
        levels.max().unwrap_or(0)
    }
}

/// Returns the number of entries that [`Key::Layers`] or [`Key::Steps`] has in the scene: those
/// that the base gives, else those that axes make, from the first one on without a gap.
pub(crate) fn entries(list: Key, base: &[(Key, Given)], groups: &[Group]) -> u32 {
    let scene = Sheet::new(base.iter().map(|(key, given)| (*key, given)));
    if scene.get(list).is_some() {
        return scene.length(list);
    }
    let made = groups.iter().flat_map(Group::axes).filter_map(|axis| axis.target.entry());
    let made: HashSet<u32> = made.filter_map(|(of, index)| (of == list).then_some(index)).collect();
    (0..).find(|index| !made.contains(index)).unwrap_or(0)
}

/// Returns every key that a base or an axis gives; some are returned more than once.
pub(crate) fn keys<'a>(
    base: &'a [(Key, Given)],
    groups: &'a [Group],
) -> impl Iterator<Item = Key> + 'a {
    let axes = || groups.iter().flat_map(Group::axes);
    let drawn = axes().filter(|axis| axis.distribution.is_some()).filter_map(SweepAxis::key);
    let choices = axes().flat_map(|axis| &axis.choices);
    base.iter().chain(choices.flat_map(|choice| &choice.given)).map(|(key, _)| *key).chain(drawn)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_coarse_grids() {
        let levels =
            |length: usize| (0..length).map(|step| level(step, length)).collect::<Vec<_>>();
        assert_eq!(levels(1), [0]);
        assert_eq!(levels(2), [0, 0]);
        assert_eq!(levels(3), [0, 1, 0]);
        assert_eq!(levels(9), [0, 3, 2, 3, 1, 3, 2, 3, 0]);
        for length in [5, 16, 40, 100, 1001] {
            let levels = levels(length);
            for level in 0..=12 {
                let grid: Vec<usize> = (0..length).filter(|step| levels[*step] <= level).collect();
                assert_eq!(grid.len(), length.min((1 << level) + 1), "{length}, {level}");
                let gaps = grid.windows(2).map(|pair| pair[1] - pair[0]);
                let gaps: Vec<usize> = gaps.collect();
                assert!(gaps.iter().max().unwrap() - gaps.iter().min().unwrap() <= 1);
            }
        }
    }
}
