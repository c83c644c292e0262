//! `columns`: what tables of results may have.

use anyhow::{Result, bail};
use study::reference::{columns as all_columns, matching_columns};
use wording::one_line;

use crate::cli::ColumnsArgs;
use crate::output::{self, Finish};
use crate::reference_pages::columns_text;

/// Prints the columns that a pattern means, or all.
pub(crate) fn columns(args: &ColumnsArgs) -> Result<Finish> {
    let columns = match &args.pattern {
        None => all_columns(),
        Some(pattern) => matching_columns(pattern),
    };
    match &args.pattern {
        Some(pattern) if columns.is_empty() => bail!(
            "no column of results is like `{}`; `tribosweep columns` lists all of them, and \
             `tribosweep keys` the keys, which have columns of their own",
            one_line(pattern)
        ),
        _ if args.json => output::print_json(&columns),
        _ => output::print(&columns_text(&columns)),
    }
}
