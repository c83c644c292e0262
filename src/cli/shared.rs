//! The arguments that many commands share.

use std::path::PathBuf;

use clap::Args;

use crate::proposal::{STORE_VARIABLE, USUAL_STORE};

#[derive(Args, Clone)]
pub(crate) struct StoreArgs {
    /// Directory of the store
    #[arg(long, env = STORE_VARIABLE, default_value = USUAL_STORE, value_name = "DIR")]
    pub(crate) store: PathBuf,
}

/// Parses a size in bytes: a number with an optional unit k, M, G (binary, with or without iB or
/// B).
pub(super) fn memory_size(text: &str) -> Result<u64, String> {
    let split = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let number: f64 = text[..split]
        .parse()
        .map_err(|_| "must be a number with a unit, for example 8GiB".to_owned())?;
    let unit = match text[split..]
        .trim()
        .to_ascii_lowercase()
        .trim_end_matches("ib")
        .trim_end_matches('b')
    {
        "" => 1.0,
        "k" => 1024.0,
        "m" => 1024.0 * 1024.0,
        "g" => 1024.0 * 1024.0 * 1024.0,
        _ => return Err(format!("unknown unit `{}`; use KiB, MiB or GiB", &text[split..])),
    };
    let bytes = number * unit;
    if bytes >= 1.0 && bytes < u64::MAX as f64 {
        Ok(bytes as u64)
    } else {
        Err("must be at least one byte and below 16 EiB".to_owned())
    }
}
