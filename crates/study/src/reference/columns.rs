//! The reference of the columns: what a table of results may have beside its axes and keys.

use serde::Serialize;

use crate::columns::{Column, Role, along_path};
use crate::kind::Kind;
use crate::value::ValueType;

/// A column of results.
#[derive(Clone, Debug, Serialize)]
pub struct ReferenceColumn {
    /// The name.
    pub name: String,
    /// The symbol of the unit; empty for pure numbers and for what is no number.
    pub unit: &'static str,
    /// The kind of the values: number, whole number, true or false, text.
    pub values: &'static str,
    /// The origin of the values, a word.
    pub role: &'static str,
    /// The meaning, in words.
    pub meaning: &'static str,
    /// The kinds of study that have it.
    pub kinds: Vec<&'static str>,
    /// True if only tables of increments have it.
    pub is_of_increments: bool,
}

/// Returns the columns of the results of every kind of study. A name that means one thing in one
/// kind and another in another is there for each.
pub fn columns() -> Vec<ReferenceColumn> {
    let mut all: Vec<ReferenceColumn> = Vec::new();
    for kind in Kind::ALL {
        let whole = kind.columns([], []);
        let is_of_increments = |column: &Column| column.role == Role::Place;
        let of_path = along_path(whole.clone()).into_iter().filter(is_of_increments);
        for column in of_path.chain(whole) {
            if matches!(column.role, Role::Axis | Role::Key) {
                continue;
            }
            let is_same = |known: &&mut ReferenceColumn| {
                known.name == column.name && known.meaning == column.meaning
            };
            match all.iter_mut().find(is_same) {
                Some(known) => known.kinds.push(kind.name()),
                None => all.push(ReferenceColumn {
                    unit: column.unit(),
                    values: noun(column.values()),
                    role: column.role.name(),
                    meaning: column.meaning,
                    kinds: vec![kind.name()],
                    is_of_increments: is_of_increments(&column),
                    name: column.name.into_owned(),
                }),
            }
        }
    }
    all
}

/// Returns the columns of this name, else those whose names have this part.
pub fn matching_columns(pattern: &str) -> Vec<ReferenceColumn> {
    let (pattern, all) = (pattern.trim(), columns());
    let found = |is_meant: &dyn Fn(&ReferenceColumn) -> bool| {
        all.iter().filter(|column| is_meant(column)).cloned().collect::<Vec<_>>()
    };
    match found(&|column| column.name == pattern) {
        none if none.is_empty() => found(&|column| column.name.contains(pattern)),
        some => some,
    }
}

fn noun(values: ValueType) -> &'static str {
    match values {
        ValueType::Number => "number",
        ValueType::Integer => "whole number",
        ValueType::Flag => "true or false",
        ValueType::Text => "text",
    }
}
