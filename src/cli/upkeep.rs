//! The arguments of the commands that keep a store in order, hold studies against each other, and
//! look at the machine.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};

use super::shared::{StoreArgs, memory_size};
use crate::labels;

#[derive(Args)]
pub(crate) struct DoctorArgs {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct RmArgs {
    /// Names of studies
    #[arg(required = true, value_name = "STUDY")]
    pub(crate) names: Vec<String>,
    /// Say what would be removed, and remove nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct TagArgs {
    /// Name of the study
    pub(crate) name: String,
    /// Words to put to it [default: none; those that it has are printed]
    #[arg(value_name = "WORD", value_parser = labels::tag)]
    pub(crate) words: Vec<String>,
    /// Take the words away instead; all of them if none is named
    #[arg(long)]
    pub(crate) remove: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct NoteArgs {
    /// Name of the study
    pub(crate) name: String,
    /// Text to put to it, in place of an earlier one [default: none; the one that it has is
    /// printed]
    #[arg(value_name = "TEXT", value_parser = labels::note)]
    pub(crate) text: Option<String>,
    /// Take the text away
    #[arg(long, conflicts_with = "text")]
    pub(crate) remove: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

/// The formats of a difference.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum DifferenceFormat {
    /// A text for reading: each column, and the first values that differ
    Table,
    /// A row for each value that differs
    Csv,
    /// Everything
    Json,
}

#[derive(Args)]
pub(crate) struct DiffArgs {
    /// Name of the first study
    pub(crate) first: String,
    /// Name of the second study [default: that of the first, in the other store]
    #[arg(required_unless_present = "other")]
    pub(crate) second: Option<String>,
    /// Store or exports that have the second study [default: the store of the first]
    #[arg(long, value_name = "DIR")]
    pub(crate) other: Option<PathBuf>,
    /// Relative difference up to which two numbers count as the same, for example 1e-3 or 0.1%
    #[arg(long, value_name = "PART", default_value = "1e-6", value_parser = part)]
    pub(crate) tolerance: f64,
    /// Columns to compare, separated by commas [default: the quantities of the solutions, and how
    /// jobs ended]
    #[arg(long, value_delimiter = ',', value_name = "COLUMNS")]
    pub(crate) select: Vec<String>,
    /// Compare only the points that both studies have
    #[arg(long)]
    pub(crate) common: bool,
    /// Print it in this form
    #[arg(long, value_enum, default_value = "table")]
    pub(crate) format: DifferenceFormat,
    /// Print JSON, as --format json does
    #[arg(long, conflicts_with = "format")]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct GcArgs {
    /// Say what would be removed, and remove nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Remove only what was computed or written longer ago than this, for example 30d or 12h
    #[arg(long, value_name = "DURATION", value_parser = age)]
    pub(crate) older_than: Option<Duration>,
    /// Remove only results and files that take more space than this, for example 10MB
    #[arg(long, value_name = "SIZE", value_parser = memory_size)]
    pub(crate) larger_than: Option<u64>,
    /// Remove also results of earlier versions of the physics whose jobs studies have, which `diff`
    /// compares
    #[arg(long)]
    pub(crate) earlier_physics: bool,
    /// Print JSON, with every result and file
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

/// Parses a relative difference, as a number or in per cent.
fn part(text: &str) -> Result<f64, String> {
    let (digits, unit) = match text.trim().strip_suffix('%') {
        Some(digits) => (digits.trim_end(), 0.01),
        None => (text.trim(), 1.0),
    };
    let number = digits.parse::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
    number
        .map(|number| number * unit)
        .ok_or_else(|| "must be a number that is not negative, for example 1e-3 or 0.1%".to_owned())
}

/// Parses an age.
fn age(text: &str) -> Result<Duration, String> {
    humantime::parse_duration(text)
        .map_err(|error| format!("{error}; write for example 30d, 12h or 1year"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_and_ages_are_read_as_people_write_them() {
        assert_eq!(
            ["1e-3", "0.1%", "0", " 5 % "].map(|text| part(text).ok()),
            [Some(1e-3), Some(1e-3), Some(0.0), Some(0.05)]
        );
        for wrong in ["-1", "nan", "inf", "", "%", "much"] {
            part(wrong).unwrap_err();
        }
        assert_eq!(age("30d").unwrap().as_secs(), 30 * 86_400);
        assert!(age("30").unwrap_err().contains("30d, 12h"));
    }
}
