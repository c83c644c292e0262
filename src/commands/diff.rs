//! `diff`: the results of two studies, or of one study in two stores, side by side.

use std::collections::BTreeMap;
use std::path::Path;

use answers::{Difference, Results};
use anyhow::{Context, Result};
use report::{DataTable, TableError};
use study::job::PHYSICS_VERSION;
use wording::escaped_json;

use crate::cli::{DiffArgs, DifferenceFormat};
use crate::earlier_results::EarlierResults;
use crate::output::{self, Finish, layout};
use crate::stored::{StoreSource, read_store, stored_study};
use crate::words::count;

/// The most values and points that are printed to be read.
const MOST_ROWS: usize = 20;

/// Compares two studies.
pub(crate) fn diff(args: &DiffArgs) -> Result<Finish> {
    let here: &Path = &args.store.store;
    let there: &Path = args.other.as_deref().unwrap_or(here);
    let readers = [read_store(here)?, read_store(there)?];
    let names = [&args.first, args.second.as_ref().unwrap_or(&args.first)];
    let sources = readers.each_ref().map(|reader| EarlierResults::of(StoreSource::Reader(reader)));
    let read = |side: usize| -> Result<Results<'_>> {
        let study = stored_study(&readers[side], names[side])
            .with_context(|| format!("in {}", readers[side].blobs().store().display()))?;
        Results::read(study, &sources[side]).with_context(|| format!("study `{}`", names[side]))
    };
    let results = [read(0)?, read(1)?];
    let mut found = Difference::of(&results[0], &results[1], &args.select, args.tolerance)?;
    let counts = [found.only_first.rows().len(), found.only_second.rows().len()];
    if args.common {
        for only in [&mut found.only_first, &mut found.only_second] {
            *only = DataTable::new(only.columns().to_vec(), Vec::new())?;
        }
    }
    let labels = [0, 1].map(|side| match names[0] == names[1] {
        true => format!("{} of {}", names[side], readers[side].blobs().store().display()),
        false => names[side].clone(),
    });
    let notes: Vec<String> =
        results.iter().zip(&labels).flat_map(|(results, label)| earlier(results, label)).collect();
    let format = if args.json { DifferenceFormat::Json } else { args.format };
    match format {
        DifferenceFormat::Table => {
            let mut text = format!("first: {}\nsecond: {}\n", labels[0], labels[1]);
            notes.iter().for_each(|note| text += &format!("{note}\n"));
            text += &words(&found, counts, args)?;
            output::print(&text)?;
        }
        DifferenceFormat::Csv => {
            notes.iter().for_each(|note| output::say(note));
            for (only, side) in [&found.only_first, &found.only_second].into_iter().zip(&labels) {
                if !only.rows().is_empty() {
                    let points = count(only.rows().len(), "point", "points");
                    output::say(&format!("{points} only in {side}"));
                }
            }
            output::print_raw(&found.values.csv())?;
        }
        DifferenceFormat::Json => {
            let json = |table: &DataTable| serde_json::from_str::<serde_json::Value>(&table.json());
            let value = serde_json::json!({
                "first": labels[0],
                "second": labels[1],
                "same": found.is_none(),
                "tolerance": args.tolerance,
                "common": found.common,
                "columns": json(&found.columns)?,
                "values": json(&found.values)?,
                "only_first": json(&found.only_first)?,
                "only_second": json(&found.only_second)?,
                "notes": notes,
            });
            let text = serde_json::to_string_pretty(&value)? + "\n";
            output::print_raw(&escaped_json(&text))?;
        }
    }
    Ok(if found.is_none() { Finish::AllDone } else { Finish::Differs })
}

/// Says which results of a study are of an earlier version of the physics.
fn earlier(results: &Results<'_>, label: &str) -> Vec<String> {
    let mut versions: BTreeMap<u32, usize> = BTreeMap::new();
    let records = results.points().iter().filter_map(|point| results.record(point));
    for record in records.filter(|record| !record.is_current()) {
        *versions.entry(record.physics).or_default() += 1;
    }
    let said = |(physics, points): (u32, usize)| {
        let points = count(points, "point", "points");
        format!(
            "{label}: {points} with results of version {physics} of the physics; this program has \
             version {PHYSICS_VERSION}"
        )
    };
    versions.into_iter().map(said).collect()
}

/// Says what differs, to be read.
fn words(found: &Difference, counts: [usize; 2], args: &DiffArgs) -> Result<String> {
    let [first, second] = counts;
    let mut text = format!(
        "{} in both, {first} only in the first, {second} only in the second\n",
        count(found.common, "point", "points")
    );
    if found.is_none_at_common_points() && found.common > 0 {
        let columns = count(found.columns.rows().len(), "column", "columns");
        text += &format!("{columns} compared: all the same to a part of {:e}\n", args.tolerance);
    } else if found.common > 0 {
        let differing = found.columns.filter("differing > 0")?;
        let same = found.columns.rows().len() - differing.rows().len();
        text += &format!("\n{}", differing.terminal(&layout()));
        if same > 0 {
            text += &format!(
                "{} the same to a part of {:e}\n",
                count(same, "other column is", "other columns are"),
                args.tolerance
            );
        }
        text += &format!("\n{}", beginning(&found.values, "values that differ")?);
    }
    for (only, side) in [(&found.only_first, "first"), (&found.only_second, "second")] {
        if !only.rows().is_empty() && !only.columns().is_empty() {
            text += &format!("\nonly in the {side}:\n{}", beginning(only, "points")?);
        }
    }
    Ok(text)
}

/// Returns the first rows of a table, and how many more of what it has.
fn beginning(table: &DataTable, what: &str) -> Result<String, TableError> {
    let rows = table.rows();
    let first =
        DataTable::new(table.columns().to_vec(), rows[..rows.len().min(MOST_ROWS)].to_vec())?;
    let more = rows.len() - first.rows().len();
    let end = match more {
        0 => String::new(),
        more => format!("… and {more} more {what}; --format csv or json has all\n"),
    };
    Ok(first.terminal(&layout()) + &end)
}
