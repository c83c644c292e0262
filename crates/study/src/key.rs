//! The one list of the keys of a scene and its numerics: the place of each in a study file, what it
//! measures and the column that it fills. The reader, the axes, the columns, the messages and the
//! reference of the study file all go by this list.
//!
//! Layers and load steps are lists, and a key of one of them carries its index, counted from 0:
//! `foundation.layers[1].thickness` fills the column `layer1_thickness`, and
//! `loading.steps[2].shift_x` the column `step2_shift_x`. Most studies have one step, and its keys
//! do without the index: the motions, the normal force and the rolling of `steps[0]` fill
//! `approach`, `normal_force`, `shift_x`, `creepage_x` … Its tangential forces and moments do not,
//! because `force_x` is a result.

use std::borrow::Cow;

use contact::model::{Foundation, Loading};

use crate::quantity::Quantity;
use crate::units::Dimension;

mod list;

pub use list::Key;

impl Key {
    /// Returns every key of a scene, in the order of the fields. `length` gives the lengths of its
    /// lists, [`Key::Layers`] and [`Key::Steps`].
    pub fn all(length: impl Fn(Key) -> u32) -> Vec<Key> {
        Key::of_entries(|list| 0..length(list))
    }

    /// Returns every key of a scene of whose lists only the entries with these indices count.
    pub(crate) fn of_entries<Indices: IntoIterator<Item = u32>>(
        indices: impl Fn(Key) -> Indices,
    ) -> Vec<Key> {
        let mut keys = Vec::new();
        for run in Key::ALL.chunk_by(|a, b| a.list() == b.list()) {
            match run.first().and_then(|key| key.list()) {
                None => keys.extend_from_slice(run),
                Some(list) => keys.extend(
                    indices(list)
                        .into_iter()
                        .flat_map(|index| run.iter().map(move |key| key.with_index(index))),
                ),
            }
        }
        keys
    }

    /// Returns the key that may be given in its place: a material has a shear modulus or Young's
    /// modulus.
    pub(crate) fn alternative(self) -> Option<Key> {
        Some(match self {
            Key::ShearModulus => Key::YoungsModulus,
            Key::YoungsModulus => Key::ShearModulus,
            Key::LayerShearModulus(index) => Key::LayerYoungsModulus(index),
            Key::LayerYoungsModulus(index) => Key::LayerShearModulus(index),
            Key::PunchShearModulus => Key::PunchYoungsModulus,
            Key::PunchYoungsModulus => Key::PunchShearModulus,
            _ => return None,
        })
    }

    /// Returns whether a job has its value only by way of another key: a job keeps shear moduli.
    pub(crate) fn is_derived(self) -> bool {
        matches!(self, Key::YoungsModulus | Key::LayerYoungsModulus(_) | Key::PunchYoungsModulus)
    }

    /// Returns whether it says how a step rolls.
    pub(crate) fn is_of_rolling(self) -> bool {
        matches!(
            self,
            Key::CreepageX(_)
                | Key::CreepageY(_)
                | Key::Spin(_)
                | Key::SpinCenter(_)
                | Key::Direction(_)
                | Key::Distance(_)
                | Key::Dq(_)
                | Key::Steady(_)
        )
    }

    /// Returns whether it asks for something of the wear.
    pub(crate) fn is_of_wear(self) -> bool {
        self.pattern().starts_with("scene.wear.")
    }

    /// Returns whether it asks for stresses below the surface.
    pub(crate) fn is_of_interior(self) -> bool {
        self.pattern().starts_with("interior.")
    }

    /// Returns the largest number of entries of the list that it is.
    pub(crate) fn longest(self) -> u32 {
        match self {
            Key::Layers => Foundation::MAX_LAYERS as u32,
            // Each step has an increment at least.
            _ => Loading::MAX_INCREMENTS,
        }
    }

    /// Returns the list in which it stands.
    pub(crate) fn list(self) -> Option<Key> {
        match self.pattern().split_once("[i]")?.0 {
            "scene.foundation.layers" => Some(Key::Layers),
            _ => Some(Key::Steps),
        }
    }

    /// Returns its path in a study file, from the top: `scene.friction.mu`.
    pub fn path(self) -> Cow<'static, str> {
        indexed(self.pattern(), self.index())
    }

    /// Returns the path without `scene.`, `numerics.` or `search.`, as axes and messages write it.
    pub fn short(self) -> Cow<'static, str> {
        indexed(short(self.pattern()), self.index())
    }

    /// Returns the last segment of the path.
    pub(crate) fn name(self) -> &'static str {
        self.pattern().rsplit('.').next().unwrap_or_default()
    }

    /// Returns the column that it fills, an identifier that is unique among all columns.
    pub fn column(self) -> Cow<'static, str> {
        match self {
            Key::Approach(0)
            | Key::NormalForce(0)
            | Key::ShiftX(0)
            | Key::ShiftY(0)
            | Key::TiltX(0)
            | Key::TiltY(0)
            | Key::Twist(0)
            | Key::CreepageX(0)
            | Key::CreepageY(0)
            | Key::Spin(0)
            | Key::SpinCenter(0)
            | Key::Direction(0)
            | Key::Distance(0)
            | Key::Dq(0)
            | Key::Steady(0) => Cow::Borrowed(self.name()),
            _ => match self.index() {
                Some(index) => Cow::Owned(self.column_pattern().replace("[i]", &index.to_string())),
                None => Cow::Borrowed(self.column_pattern()),
            },
        }
    }

    /// Describes the values that may stand behind it, for messages.
    pub(crate) fn expected(self) -> String {
        match Table::find(self.pattern()) {
            Some(table) => table.expected(),
            None => self.quantity().expected(),
        }
    }

    /// Returns the dimension of its values.
    pub(crate) fn dimension(self) -> Dimension {
        match self.quantity() {
            Quantity::Number(dimension) => dimension,
            _ => Dimension::Pure,
        }
    }

    /// Returns the key with this path, short or from the top.
    pub(crate) fn find(path: &str) -> Option<Key> {
        let (pattern, index) = pattern_of(path)?;
        let key = Key::ALL
            .iter()
            .find(|key| key.pattern() == pattern || short(key.pattern()) == pattern)?;
        Some(key.with_index(index))
    }

    /// Returns the key that fills this column.
    pub(crate) fn of_column(column: &str) -> Option<Key> {
        let index = column
            .trim_start_matches(|c: char| c.is_ascii_lowercase())
            .split('_')
            .next()
            .and_then(|digits| digits.parse().ok());
        let candidates = Key::ALL.iter().flat_map(|key| [*key, key.with_index(index.unwrap_or(0))]);
        candidates.into_iter().find(|key| key.column() == column)
    }

    /// Returns whether the table holds the key, or is what the key says in a word or a number.
    pub(crate) fn is_under(self, table: &Table) -> bool {
        is_inside(self.pattern(), table.pattern)
            && (!table.has_index() || self.index() == Some(table.index))
    }
}

/// A table of a study file whose keys are [`Key`]s, or a list of such tables; an axis may replace
/// it as a whole. Lists and the base of a foundation are keys as well: what these say fits into a
/// number or a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Table {
    pub(crate) pattern: &'static str,
    column: &'static str,
    /// The meaning in words.
    pub(crate) meaning: &'static str,
    index: u32,
}

const fn table(pattern: &'static str, column: &'static str, meaning: &'static str) -> Table {
    Table { pattern, column, meaning, index: 0 }
}

impl Table {
    /// Every such table, the outer ones first; tables of lists have index 0.
    pub(crate) const ALL: &'static [Table] = &[
        table(
            "scene",
            "scene",
            "one case: two bodies, the friction between them, and the path along which one is moved",
        ),
        table(
            "scene.foundation",
            "foundation",
            "body below the plane of contact: layers on a base",
        ),
        table(
            "scene.foundation.layers",
            "layers",
            "layers from the surface down, bonded to each other and to the base",
        ),
        table(
            "scene.foundation.layers[i]",
            "layer[i]",
            "a layer; the first one, `[0]`, is at the surface",
        ),
        table("scene.foundation.base", "base", "elastic half-space below the layers, or \"rigid\""),
        table("scene.punch", "punch", "body that is pressed onto the foundation, and its shape"),
        table(
            "scene.punch.material",
            "punch_material",
            "material of an elastic punch; without it the punch is rigid",
        ),
        table(
            "scene.friction",
            "friction",
            "Coulomb friction between the bodies; without it there is none",
        ),
        table("scene.wear", "wear", "wear by Archard's law; without it nothing is worn away"),
        table(
            "scene.domain",
            "domain",
            "rectangle Ω that is meshed; without it the punch and its approach choose it",
        ),
        table("scene.loading", "loading", "path along which the punch is moved"),
        table("scene.loading.steps", "steps", "load steps, one after the other"),
        table(
            "scene.loading.steps[i]",
            "step[i]",
            "a load step: where each motion or force ends; what is not given stays",
        ),
        table(
            "interior",
            "interior",
            "stresses below the surface that are wanted at the end of the path",
        ),
        table("numerics", "numerics", "mesh and solver"),
        table(
            "search",
            "search",
            "extent of a search for all solutions, or for the end of a uniqueness set",
        ),
    ];

    fn has_index(&self) -> bool {
        self.pattern.ends_with(']')
    }

    /// Returns its index if it stands in a list.
    pub(crate) fn index(&self) -> Option<u32> {
        self.has_index().then_some(self.index)
    }

    /// Returns the list that it is or in which it stands: [`Key::Layers`] or [`Key::Steps`].
    pub(crate) fn list(&self) -> Option<Key> {
        [Key::Layers, Key::Steps]
            .into_iter()
            .find(|list| self.pattern.split('[').next() == Some(list.pattern()))
    }

    /// Returns whether it is a list of tables.
    pub(crate) fn is_list(&self) -> bool {
        self.list().is_some() && !self.has_index()
    }

    /// Returns the table with an index in a list, [`Key::Layers`] or [`Key::Steps`].
    pub(crate) fn entry(list: Key, index: u32) -> Option<Table> {
        let entry =
            Table::ALL.iter().find(|table| table.has_index() && table.list() == Some(list))?;
        Some(Table { index, ..*entry })
    }

    /// Returns its path, from the top.
    pub(crate) fn path(&self) -> Cow<'static, str> {
        indexed(self.pattern, self.index())
    }

    /// Returns the path without `scene.`, as axes and messages write it.
    pub(crate) fn short(&self) -> Cow<'static, str> {
        indexed(short(self.pattern), self.index())
    }

    /// Returns the last segment of the path.
    pub(crate) fn name(&self) -> &'static str {
        self.pattern.rsplit('.').next().unwrap_or_default()
    }

    /// Returns the column that an axis over it fills.
    pub(crate) fn column(&self) -> Cow<'static, str> {
        match self.has_index() {
            true => Cow::Owned(self.column.replace("[i]", &self.index.to_string())),
            false => Cow::Borrowed(self.column),
        }
    }

    /// Returns the table with this path, short or from the top.
    pub(crate) fn find(path: &str) -> Option<Table> {
        let (pattern, index) = pattern_of(path)?;
        let table = Table::ALL
            .iter()
            .find(|table| table.pattern == pattern || short(table.pattern) == pattern)?;
        Some(Table { index, ..*table })
    }

    /// Returns the table whose labels fill this column.
    pub(crate) fn of_column(column: &str) -> Option<Table> {
        let digits = column.trim_start_matches(|c: char| !c.is_ascii_digit());
        let index = digits.split('_').next().and_then(|digits| digits.parse().ok()).unwrap_or(0);
        let mut tables = Table::ALL.iter().map(|table| Table { index, ..*table });
        tables.find(|table| table.column() == column)
    }

    /// Returns whether the other table holds it or is the same.
    pub(crate) fn is_under(&self, other: &Table) -> bool {
        is_inside(self.pattern, other.pattern)
            && (!other.has_index() || self.index() == Some(other.index))
    }

    /// Returns the names that may stand directly in it.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let mut names = Vec::new();
        for key in Key::ALL {
            let inner =
                key.pattern().strip_prefix(self.pattern).and_then(|rest| rest.strip_prefix('.'));
            let name = inner.and_then(|inner| inner.split(['.', '[']).next());
            names.extend(name.filter(|name| !names.contains(name)));
        }
        names
    }

    /// Describes what may stand in its place, for messages.
    pub(crate) fn expected(&self) -> String {
        let key = Key::find(self.pattern).map(|key| key.quantity());
        let names = self.names().join("`, `");
        match key {
            Some(quantity @ Quantity::List(_)) => quantity.expected(),
            Some(quantity) => format!("{} or a table with the keys `{names}`", quantity.expected()),
            None => format!("a table with the keys `{names}`"),
        }
    }
}

/// Returns whether the path `inner` leads to something inside `outer`.
fn is_inside(inner: &str, outer: &str) -> bool {
    inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

pub(crate) fn short(path: &str) -> &str {
    ["scene.", "numerics.", "search."]
        .iter()
        .find_map(|table| path.strip_prefix(table))
        .unwrap_or(path)
}

fn indexed(pattern: &'static str, index: Option<u32>) -> Cow<'static, str> {
    match index {
        Some(index) => Cow::Owned(pattern.replace("[i]", &format!("[{index}]"))),
        None => Cow::Borrowed(pattern),
    }
}

/// Replaces the index in a path by `[i]`, and returns the index as well; `None` if the index is not
/// written as a number.
pub(crate) fn pattern_of(path: &str) -> Option<(Cow<'_, str>, u32)> {
    let Some((list, rest)) = path.split_once('[') else { return Some((Cow::Borrowed(path), 0)) };
    let (digits, rest) = rest.split_once(']')?;
    let index: u32 = digits.parse().ok().filter(|index: &u32| index.to_string() == digits)?;
    Some((Cow::Owned(format!("{list}[i]{rest}")), index))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_and_columns_are_unique() {
        let mut seen = std::collections::HashSet::new();
        let mut columns = std::collections::HashSet::new();
        let all = Key::all(|_| 12);
        assert_eq!(all.len(), Key::ALL.len() + 11 * (4 + 21));
        for key in &all {
            // A key that stands outside of the scene has no shorter name.
            let is_new = key.short() == key.path() || seen.insert(key.short());
            assert!(seen.insert(key.path()) && is_new, "{key:?}");
            assert_eq!(Key::find(&key.path()), Some(*key));
            assert_eq!(Key::find(&key.short()), Some(*key));
            assert!(columns.insert(key.column()), "{key:?}");
            assert_eq!(Key::of_column(&key.column()), Some(*key));
        }
        for table in
            (0..3).flat_map(|index| Table::ALL.iter().map(move |table| Table { index, ..*table }))
        {
            assert_eq!(Table::find(&table.path()).map(|found| found.path()), Some(table.path()));
            // A list and the base are keys too, under the same name.
            let is_key = Key::find(&table.path()).is_some_and(|key| key.column() == table.column());
            assert!(
                columns.insert(table.column()) || is_key || table.index > 0 && !table.has_index(),
                "{table:?}"
            );
        }
    }

    #[test]
    fn columns_of_steps_and_layers() {
        let column = |path: &str| Key::find(path).unwrap().column();
        assert_eq!(column("loading.steps[0].shift_x"), "shift_x");
        assert_eq!(column("loading.steps[0].force_x"), "step0_force_x");
        assert_eq!(column("loading.steps[12].shift_x"), "step12_shift_x");
        assert_eq!(column("foundation.layers[0].poisson"), "layer0_poisson");
        assert_eq!(Key::of_column("step0_shift_x"), None);
        for path in [
            "loading.steps[i].twist",
            "loading.steps[01].twist",
            "loading.steps[-1].twist",
            "loading.steps[].twist",
            "loading.steps.twist",
        ] {
            assert_eq!(Key::find(path), None, "{path}");
        }
    }

    #[test]
    fn every_table_holds_keys() {
        for table in Table::ALL.iter().filter(|table| !table.is_list()) {
            assert!(!table.names().is_empty(), "{table:?}");
        }
        assert_eq!(
            Table::find("loading").map(|t| t.names()),
            Some(vec!["steps", "cycle_from", "cycles"])
        );
        assert_eq!(Table::find("foundation").map(|t| t.names()), Some(vec!["layers", "base"]));
        assert_eq!(Table::find("loading.steps[3]").map(|t| t.names().len()), Some(21));
        let inside =
            |key: &str, table: &str| Key::find(key).unwrap().is_under(&Table::find(table).unwrap());
        assert!(
            inside("loading.steps[3].twist", "loading.steps[3]")
                && inside("loading.steps[3].twist", "loading.steps")
        );
        assert!(
            !inside("loading.steps[3].twist", "loading.steps[2]")
                && !inside("loading.steps", "loading.steps[0]")
        );
        assert!(
            inside("foundation.base", "foundation.base")
                && inside("foundation.layers", "foundation")
        );
    }
}
