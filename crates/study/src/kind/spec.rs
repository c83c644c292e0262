//! The description of a kind of study, and of the table that a study file may have for it.

use toml::de::DeValue;

use contact::model::SceneError;

use crate::assemble::Assembler;
use crate::axis::Group;
use crate::column_name::column_name;
use crate::columns::column::Column;
use crate::design::arrangement::Arrangement;
use crate::error::{Mistake, Span, are_enough};
use crate::figure::Figure;
use crate::job::Job;
use crate::key::Key;
use crate::quantity::one_of;
use crate::read;
use crate::read::Node;
use crate::table_key::{KeyTable, TableKey, TableValue};

/// Everything that the crate knows of one kind of study. A kind that has much in common with the
/// solving of scenes takes that from there.
pub(crate) struct KindSpec {
    /// The name by which a study file calls the kind.
    pub(crate) name: &'static str,
    /// The table at the top of a study file that no other kind has.
    pub(crate) table: Option<TableSpec>,
    /// True if meshes may be chosen by the accuracy of the results.
    pub(crate) has_accuracy: bool,
    /// Chooses the rows in which a sample's points are compared; `None` if each stands for itself.
    pub(crate) arrange: Option<fn(&KindTable) -> Arrangement>,
    /// Tells why the jobs have no use for a key; `None` if they have.
    pub(crate) refuses: fn(Key) -> Option<&'static str>,
    /// Makes the job of a point.
    pub(crate) assemble: fn(&mut Assembler<'_>, &KindTable) -> Job,
    /// Refuses a job that is valid by itself and still none of this kind.
    pub(crate) check: fn(&Job) -> Result<(), SceneError>,
    /// Writes the keys that only this kind has, as a study file gives them.
    pub(crate) to_toml: fn(&Job) -> String,
    /// The columns of the results, list after list.
    pub(crate) columns: &'static [&'static [Column]],
    /// The columns that follow those and are this kind's own.
    pub(crate) further_columns: &'static [&'static [Column]],
    /// The columns of results that a query shows if none are named.
    pub(crate) usual_columns: &'static [&'static str],
    /// Makes the figures that may answer a study that asks for none, the preferred one first. Some
    /// of the study's jobs tell what its scenes prescribe.
    pub(crate) suggestions: fn(&KindTable, &[Group], &[Job]) -> Vec<Figure>,
}

/// The table of a kind.
pub(crate) struct TableSpec {
    /// The table; every key may be left out.
    pub(crate) table: KeyTable,
    /// Refuses a table, at a place, that does not fit the axes. It is called without a table as
    /// well.
    pub(crate) check: fn(&KindTable, &Span, &[Group], &mut Vec<Mistake>),
    /// The advice for a study of another kind that has the table.
    pub(crate) advice: &'static str,
}

/// The content of a kind's table in a study file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct KindTable {
    words: Vec<(&'static str, &'static str)>,
    counts: Vec<(&'static str, u32)>,
    columns: Vec<(&'static str, Vec<String>)>,
}

impl KindTable {
    /// Returns the word behind a key, if it is given.
    pub(crate) fn word(&self, name: &str) -> Option<&'static str> {
        self.words.iter().find(|(key, _)| *key == name).map(|(_, word)| *word)
    }

    /// Returns the columns behind a key; none if it is not given.
    pub(crate) fn columns(&self, name: &str) -> &[String] {
        self.columns.iter().find(|(key, _)| *key == name).map_or(&[], |(_, columns)| columns)
    }

    /// Returns whether a word or a number stands behind a key.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.word(name).is_some() || self.count(name).is_some()
    }

    /// Returns the number behind a key, if it is given.
    pub(crate) fn count(&self, name: &str) -> Option<u32> {
        self.counts.iter().find(|(key, _)| *key == name).map(|(_, count)| *count)
    }
}

impl TableSpec {
    /// Returns the table as messages name it.
    fn quoted(&self) -> String {
        format!("`{}`", self.table.heading())
    }

    /// Reads the table, or the content that a study without it has.
    pub(crate) fn read(
        &self,
        node: Option<&Node<'_>>,
        groups: &[Group],
        mistakes: &mut Vec<Mistake>,
    ) -> KindTable {
        let mut read = KindTable::default();
        if let Some(node) = node {
            let (KeyTable { path: name, keys, .. }, names) = (self.table, self.table.names());
            let DeValue::Table(table) = node.get_ref() else {
                let expected = format!("a table with the keys `{}`", names.join("`, `"));
                mistakes.push(read::mistyped(name, node, &expected));
                return read;
            };
            read::refuse_unknown(table, &self.quoted(), &names, mistakes);
            for TableKey { name, values, bounds, .. } in keys {
                let Some(node) = table.get(*name) else { continue };
                let path = format!("{}.{name}", self.table.path);
                let result = match values {
                    TableValue::Word(words) => {
                        read_word(&path, words, node).map(|word| read.words.push((name, word)))
                    }
                    TableValue::Count => read::count(&path, "", *bounds, node)
                        .map(|count| read.counts.push((name, count))),
                    // Columns are read when those of the study are known.
                    _ => Ok(()),
                };
                mistakes.extend(result.err());
            }
        }
        (self.check)(&read, &node.map_or(0..0, |node| node.span()), groups, mistakes);
        read
    }

    /// Reads the columns that the table names, of those that the study has.
    pub(crate) fn read_columns(
        &self,
        node: Option<&Node<'_>>,
        columns: &[Column],
        read: &mut KindTable,
        mistakes: &mut Vec<Mistake>,
    ) {
        let Some(DeValue::Table(table)) = node.map(|node| node.get_ref()) else { return };
        for TableKey { name, values, .. } in self.table.keys {
            let (TableValue::Columns, Some(node)) = (values, table.get(*name)) else { continue };
            let path = format!("{}.{name}", self.table.path);
            let named = match node.get_ref() {
                DeValue::Array(names) => names.iter().collect(),
                _ => vec![node],
            };
            if named.is_empty() {
                let expected = "must be a column or a list of columns of numbers";
                mistakes.push(Mistake::new(
                    node.span(),
                    format!("`{path}` is an empty list"),
                    expected,
                ));
            }
            let mut names: Vec<String> = Vec::new();
            for node in named {
                match column_name(&path, node, columns, true) {
                    Ok(name) if names.contains(&name) => {
                        let message = format!("`{path}`: `{name}` is listed twice");
                        mistakes.push(Mistake::new(node.span(), message, "once is enough"));
                    }
                    Ok(name) => names.push(name),
                    Err(mistake) => mistakes.push(mistake),
                }
                if are_enough(mistakes) {
                    return;
                }
            }
            read.columns.push((name, names));
        }
    }
}

fn read_word(
    path: &str,
    words: &'static [&'static str],
    node: &Node<'_>,
) -> Result<&'static str, Mistake> {
    let word = read::text(path, node)?;
    words.iter().copied().find(|known| *known == word).ok_or_else(|| {
        let message = format!("`{path}` cannot be `{word}`");
        Mistake::new(node.span(), message, format!("must be {}", one_of(words)))
    })
}
