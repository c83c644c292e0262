//! The arguments of the commands that say what studies and results may have.

use clap::Args;

#[derive(Args)]
pub(crate) struct KeysArgs {
    /// A key by its path, short or long, or by its column; a table; or a part of a path [default:
    /// all keys]
    pub(crate) pattern: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct ColumnsArgs {
    /// A column, or a part of the names of some [default: all columns of results]
    pub(crate) pattern: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}
