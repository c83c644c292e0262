//! The one list of columns. A name means the same in a study file's `[figure]`, in a query, in an
//! export and in a plot.
//!
//! A column is named by an identifier. The column of a key of the scene or the numerics has the
//! name that [`Key::column`] gives, whatever else the study varies. An axis over a whole table has
//! the table's column and shows the labels.
//!
//! Results are those at the end of the loading path, unless a column's meaning says that it is
//! about the whole path. In a table of increments ([`along_path`],
//! [`Record::along_path`](crate::Record::along_path)) each row is what the result would be if the
//! path ended there.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashSet};

use crate::assemble::HEIGHT_MAP;
use crate::axis::SweepAxis;
use crate::key::Key;
use crate::suggestion::nearest;
use crate::units::Dimension;
use crate::value::ValueType;

pub(crate) mod column;
pub(crate) mod common;
pub(crate) mod result_columns;

use column::ColumnSource;
pub use column::{Column, Compared, Role, Row};
use common::{ENDING, PLACE, PROVENANCE};

/// Returns the columns of a study with these axes, in order: the axes, the other keys, then the
/// results, of which `results` are those that depend on the kind of the study. `keys` are the keys
/// that the study gives. The keys of the numerics, which have defaults, have columns anyway, unless
/// the kind of the study `refuses` them.
pub(crate) fn columns<'a>(
    axes: impl IntoIterator<Item = &'a SweepAxis>,
    keys: impl IntoIterator<Item = Key>,
    refuses: impl Fn(Key) -> bool,
    results: &[&[Column]],
) -> Vec<Column> {
    let mut columns: Vec<Column> = Vec::new();
    for (index, axis) in axes.into_iter().enumerate() {
        let (dimension, meaning) =
            axis.key().map_or((Dimension::Pure, "label of the table"), |key| {
                (key.dimension(), key.meaning())
            });
        let values = axis.key().map_or(ValueType::Text, |key| key.quantity().values());
        columns.push(Column {
            name: axis.column(),
            dimension,
            role: Role::Axis,
            meaning,
            label: None,
            values,
            source: ColumnSource::Axis(index),
        });
    }
    let axes_columns: HashSet<Cow<'static, str>> =
        columns.iter().map(|column| column.name.clone()).collect();
    let listed: HashSet<Key> = keys.into_iter().collect();
    // These are only the indices that occur, for the largest one may be any number.
    let indices = |list| {
        listed
            .iter()
            .filter(|key| key.list() == Some(list))
            .filter_map(|key| key.index())
            .collect::<BTreeSet<u32>>()
    };
    for key in Key::of_entries(indices) {
        // A study gives a height map as a file, while a job has its hash; and it may give Young's
        // modulus, while a job has the shear modulus.
        let is_given = listed.contains(&key)
            || key == Key::Surface && listed.contains(&Key::File)
            || !key.is_derived() && key.alternative().is_some_and(|key| listed.contains(&key));
        // A scene without friction has μ = 0.
        let has_default = key == Key::Mu
            || ["numerics.", "search."].iter().any(|table| key.pattern().starts_with(table));
        let is_there = (is_given || has_default) && !refuses(key);
        let is_input = key == Key::File || HEIGHT_MAP.contains(&key);
        if is_there && !is_input && !axes_columns.contains(&key.column()) {
            let (name, dimension, meaning) = (key.column(), key.dimension(), key.meaning());
            columns.push(Column {
                name,
                dimension,
                role: Role::Key,
                meaning,
                label: None,
                values: key.quantity().values(),
                source: ColumnSource::Key(key),
            });
        }
    }
    columns.extend_from_slice(ENDING);
    results.iter().for_each(|results| columns.extend_from_slice(results));
    columns.extend_from_slice(PROVENANCE);
    columns
}

/// Returns the columns of a table of increments, which has one row for each
/// ([`Record::along_path`](crate::Record::along_path)): the axes, the place on the path, and the
/// rest.
pub fn along_path(columns: Vec<Column>) -> Vec<Column> {
    let (axes, mut rest): (Vec<Column>, Vec<Column>) =
        columns.into_iter().partition(|column| column.role == Role::Axis);
    // In such a table the number of increments is the number of the increment.
    rest.retain(|column| column.name != "increments");
    axes.into_iter().chain(PLACE.iter().cloned()).chain(rest).collect()
}

/// Returns the column of this name, or of the key with this path, short or from the top.
pub fn find<'a>(columns: &'a [Column], name: &str) -> Option<&'a Column> {
    let of_path = Key::find(name).map(Key::column);
    columns
        .iter()
        .find(|column| column.name == name)
        .or_else(|| columns.iter().find(|column| Some(&column.name) == of_path.as_ref()))
}

/// Returns the name of the column that was probably meant by one that is not there: others call it
/// so, or spell it like this.
pub fn nearest_name<'a>(columns: &'a [Column], name: &str) -> Option<&'a str> {
    nearest(name, columns.iter().map(|column| column.name.as_ref()))
}
