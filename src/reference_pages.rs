//! The reference of keys, columns and commands, as Markdown and for the terminal. What it says is
//! in the lists of the crate `study` and in the arguments of the command line.

mod columns;
mod commands;
mod keys;
mod markdown;

pub(crate) use columns::{columns_page, columns_text};
pub(crate) use commands::commands_page;
pub(crate) use keys::{key_text, keys_page, keys_text};
