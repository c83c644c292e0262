//! `diff`: the results of two studies, or of one study in two stores, side by side.

use std::collections::BTreeMap;
use std::path::Path;

use answers::{Difference, Results};
use anyhow::{Context, Result, bail};
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
                "same": found.is_none() && !found.is_void(),
                "tolerance": args.tolerance,
                "noise": found.noise,
                "common": found.common,
                "without_results": found.open,
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
    if found.is_void() {
        bail!("nothing was compared: {}", nothing(&found));
    }
    Ok(if found.is_none() { Finish::AllDone } else { Finish::Differs })
}

/// Says why nothing could be compared.
fn nothing(found: &Difference) -> String {
    match found.common {
        0 => "the studies have no point in common (points are matched by the values of their axes)"
            .to_owned(),
        common if common == found.open => {
            format!("{} no result in either", count(common, "point has", "points have"))
        }
        _ => "no column that is compared has a value at a point that both have".to_owned(),
    }
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
    if found.open > 0 {
        let points = count(found.open, "point has", "points have");
        text += &format!("{points} no result in either\n");
    }
    let same = same_words(found, args.tolerance);
    if found.is_none_at_common_points() && found.compared > 0 {
        let compared = found.columns.filter("points > 0")?;
        let columns = count(compared.rows().len(), "column", "columns");
        text += &format!("{columns} compared: all {same}\n");
    } else if found.compared > 0 {
        let differing = found.columns.filter("differing > 0")?;
        let others = found.columns.filter("points > 0")?.rows().len() - differing.rows().len();
        text += &format!("\n{}", differing.terminal(&layout()));
        if others > 0 {
            let others = count(others, "other column is", "other columns are");
            text += &format!("{others} {same}\n");
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

/// Says what counts as the same.
fn same_words(found: &Difference, tolerance: f64) -> String {
    if found.noise == 0.0 {
        return "exactly the same".to_owned();
    }
    format!(
        "the same to a part of {tolerance:e}, and numbers below {:e} of the largest one of their \
         unit at a point count as 0",
        found.noise
    )
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
