//! `reference`: the pages of keys, columns and commands.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use crate::output::{self, Finish};
use crate::reference_pages::{columns_page, commands_page, keys_page};
use crate::written_file;

/// Writes the pages into a directory.
pub(crate) fn reference(directory: &Path) -> Result<Finish> {
    fs::create_dir_all(directory)
        .with_context(|| format!("cannot make the directory {}", directory.display()))?;
    let pages = [
        ("keys.md", keys_page()),
        ("columns.md", columns_page()),
        ("commands.md", commands_page()),
    ];
    let mut said = String::new();
    for (name, page) in pages {
        let file = directory.join(name);
        written_file::write(&file, page.as_bytes())?;
        said += &format!("{}\n", file.display());
    }
    output::print(&said)
}
