//! `keys`: what a study file may have.

use anyhow::{Result, bail};
use study::reference::{matching, nearest_key, reference};
use wording::one_line;

use crate::cli::KeysArgs;
use crate::output::{self, Finish};
use crate::reference_pages::{key_text, keys_text};

/// Prints the keys that a pattern means, or all.
pub(crate) fn keys(args: &KeysArgs) -> Result<Finish> {
    let tables = match &args.pattern {
        None => reference(),
        Some(pattern) => matching(pattern),
    };
    if let (true, Some(pattern)) = (tables.is_empty(), &args.pattern) {
        match nearest_key(pattern) {
            Some(near) => bail!("no key is like `{}`; did you mean {near}?", one_line(pattern)),
            None => {
                bail!("no key is like `{}`; `tribosweep keys` lists all of them", one_line(pattern))
            }
        }
    }
    if args.json {
        return output::print_json(&tables);
    }
    output::print(&match &tables[..] {
        [table] if args.pattern.is_some() && table.keys.len() == 1 => {
            key_text(table, &table.keys[0])
        }
        _ => keys_text(&tables),
    })
}
