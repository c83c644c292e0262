//! The tables of a study file beside those of the scene and its numerics: their keys, and what may
//! stand behind each. Readers, messages and the reference go by these lists.

use crate::bounds::Bounds;
use crate::fallback::Fallback;
use crate::quantity::one_of;

/// A table of a study file, or a list of such tables.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KeyTable {
    /// The path, as it stands in the heading: `sample.keys`.
    pub(crate) path: &'static str,
    /// True if the heading is written twice in brackets, for there may be several.
    pub(crate) is_list: bool,
    /// The meaning in words.
    pub(crate) meaning: &'static str,
    /// The keys, in the order in which messages list them.
    pub(crate) keys: &'static [TableKey],
}

/// A key of such a table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TableKey {
    /// The name; [`ANY_KEY`] stands for the path of a key of the scene or the numerics.
    pub(crate) name: &'static str,
    /// The values that may stand behind it.
    pub(crate) values: TableValue,
    /// The bounds of these; of a list, those of the number of its entries.
    pub(crate) bounds: Bounds,
    /// The value where a study leaves it out.
    pub(crate) fallback: Fallback,
    /// A value as a study file may have it.
    pub(crate) example: &'static str,
    /// The meaning in words.
    pub(crate) meaning: &'static str,
}

/// The values that may stand behind a key of such a table.
#[derive(Clone, Copy, Debug)]
pub(crate) enum TableValue {
    /// One of these words.
    Word(&'static [&'static str]),
    /// A whole number.
    Count,
    /// A column of numbers, or a list of such columns.
    Columns,
    /// A number without a unit.
    Number,
    /// True or false.
    Flag,
    /// Something else, in words with the article.
    Other(&'static str),
}

/// The name that stands for the path of a key of the scene or the numerics.
pub(crate) const ANY_KEY: &str = "KEY";

/// Values that keys of several tables have.
pub(crate) const TEXT: TableValue = TableValue::Other("a text");
pub(crate) const NAME: TableValue = TableValue::Other("a name for files");
pub(crate) const PART: TableValue = TableValue::Other("a part, like \"1%\" or 0.01,");
pub(crate) const AXIS: TableValue = TableValue::Other("the path of an axis");
pub(crate) const COLUMN: TableValue = TableValue::Other("the name of a column");
pub(crate) const CONDITION: TableValue =
    TableValue::Other("a condition, as of `query --where`, of at most 16384 bytes");

/// Makes a key of a table.
pub(crate) const fn table_key(
    name: &'static str,
    values: TableValue,
    bounds: Bounds,
    fallback: Fallback,
    example: &'static str,
    meaning: &'static str,
) -> TableKey {
    TableKey { name, values, bounds, fallback, example, meaning }
}

impl KeyTable {
    /// Returns the table as it stands in a file: `[sample]`, `[[figure]]`.
    pub(crate) fn heading(&self) -> String {
        if self.is_list { format!("[[{}]]", self.path) } else { format!("[{}]", self.path) }
    }

    /// Returns the names of its keys.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        names(self.keys)
    }
}

/// Returns the names of some keys.
pub(crate) fn names(keys: &[TableKey]) -> Vec<&'static str> {
    keys.iter().map(|key| key.name).collect()
}

impl TableValue {
    /// Describes the values with their article.
    pub(crate) fn noun(self) -> String {
        match self {
            TableValue::Word(words) => one_of(words),
            TableValue::Count => "a whole number".to_owned(),
            TableValue::Columns => "a column or a list of columns".to_owned(),
            TableValue::Number => "a number".to_owned(),
            TableValue::Flag => "true or false".to_owned(),
            TableValue::Other(words) => words.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_as_long_as_they_are_said_to_be() {
        let longest = format!("of at most {} bytes", condition::Condition::LONGEST);
        assert!(CONDITION.noun().ends_with(&longest), "{}", CONDITION.noun());
    }
}
