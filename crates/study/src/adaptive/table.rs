//! Reads what the tables of all rules have in common: their keys, and the columns on results that
//! they name.

use toml::de::DeValue;

use crate::column_name::column_name;
use crate::columns::{Column, Role, find};
use crate::error::Mistake;
use crate::read::{self, Node};
use crate::table_key::KeyTable;

/// The advice for a column that is [unknown in choosing](Column::unknown_in_choosing).
pub const OF_ONE_JOB: &str = "must be of what one job leaves, like `load` or `estimate_load`";

/// Returns the values of the `needed` keys of a table, in this order. A missing or unknown key is a
/// mistake.
pub(super) fn fields<'t, 'i, const N: usize>(
    known: &KeyTable,
    node: &'t Node<'i>,
    needed: [&str; N],
    mistakes: &mut Vec<Mistake>,
) -> Option<[&'t Node<'i>; N]> {
    let name = known.path;
    let DeValue::Table(table) = node.get_ref() else {
        mistakes.push(read::mistyped(
            name,
            node,
            &format!("a table with the keys `{}`", known.names().join("`, `")),
        ));
        return None;
    };
    read::refuse_unknown(table, &format!("`[{name}]`"), &known.names(), mistakes);
    let found = needed.map(|key| table.get(key));
    for (key, _) in needed.iter().zip(&found).filter(|(_, found)| found.is_none()) {
        mistakes.push(Mistake::new(
            node.span(),
            format!("`{name}.{key}` is missing"),
            format!("`[{name}]` needs `{key}`"),
        ));
    }
    let found: Vec<&Node<'_>> = found.into_iter().flatten().collect();
    found.try_into().ok()
}

/// Reads the name of a column of numbers that has values while a study still chooses its points.
pub(super) fn result_column(
    path: &str,
    node: &Node<'_>,
    columns: &[Column],
) -> Result<String, Mistake> {
    let name = column_name(path, node, columns, true)?;
    match find(columns, &name).and_then(Column::unknown_in_choosing) {
        Some(why) => Err(Mistake::new(node.span(), why, OF_ONE_JOB)),
        None => Ok(name),
    }
}

/// Reads the name of a column of numbers that a study can be asked for: it follows from the scene
/// and is the same whoever computes it.
pub(super) fn caused_column(
    path: &str,
    node: &Node<'_>,
    columns: &[Column],
) -> Result<String, Mistake> {
    let name = result_column(path, node, columns)?;
    let why = match find(columns, &name).map(|column| column.role) {
        Some(Role::Axis | Role::Key) => "is given by the study and no result",
        Some(Role::Provenance) => "differs from run to run",
        _ => return Ok(name),
    };
    let message = format!("`{path}`: the column `{name}` {why}");
    Err(Mistake::new(node.span(), message, "must be of a result, like `load` or `stick_fraction`"))
}
