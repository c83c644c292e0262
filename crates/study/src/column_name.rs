//! Reads the names of columns.

use crate::columns::{Column, along_path, find};
use crate::error::Mistake;
use crate::read::{self, Node};
use crate::suggestion::nearest;

/// Reads the name of a column, which must hold numbers if it is to be `numeric`.
pub(crate) fn column_name(
    path: &str,
    node: &Node<'_>,
    columns: &[Column],
    numeric: bool,
) -> Result<String, Mistake> {
    let name = read::text(path, node)?;
    match find(columns, &name) {
        Some(column) if numeric && !column.is_numeric() => Err(Mistake::new(
            node.span(),
            format!("`{path}`: the column `{name}` holds texts"),
            "must be a column of numbers",
        )),
        Some(column) => Ok(column.name.to_string()),
        None => {
            let message = format!("`{path}`: there is no column `{name}`");
            if along_path(Vec::new()).iter().any(|column| column.name == name) {
                return Err(Mistake::new(
                    node.span(),
                    message,
                    "only increments have it: add steps = true to the figure",
                ));
            }
            Err(match nearest(&name, columns.iter().map(|column| column.name.as_ref())) {
                Some(suggestion) => {
                    Mistake::new(node.span(), message, format!("did you mean \"{suggestion}\"?"))
                }
                None => Mistake::new(
                    node.span(),
                    message,
                    "must be an axis, a key or an observable, like \"mu\" or \"peak_pressure\"",
                ),
            })
        }
    }
}
