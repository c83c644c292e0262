//! `store gc`: removes what no study refers to.

use std::collections::{HashMap, HashSet};

use anyhow::Result;
use indicatif::BinaryBytes;
use report::{Cell, DataTable, TableColumn};
use store::{Blobs, Collection, OpenError, Store};

use crate::account::command_words;
use crate::cli::GcArgs;
use crate::garbage::{FoundGarbage, GarbageLimits, UnusedFile, UnusedResult};
use crate::output::{self, Finish, layout};
use crate::stored::{account, open_to_read, read_store};
use crate::words::{count, time_words};

/// The most runs that are listed.
const MOST_RUNS: usize = 20;

/// Lists what no study refers to, and removes it.
pub(super) fn gc(args: &GcArgs) -> Result<Finish> {
    let directory = &args.store.store;
    let limits = GarbageLimits {
        older_than: args.older_than,
        larger_than: args.larger_than,
        earlier_physics: args.earlier_physics,
    };
    if args.dry_run {
        let reader = read_store(directory)?;
        if !reader.exports().is_empty() {
            return Err(OpenError::OnlyRead { path: directory.clone() }.into());
        }
        let found = FoundGarbage::find(&reader, &limits)?;
        return say(args, &found, reader.blobs(), None);
    }
    // Nobody adds a result from here on. The store answers its own process like any other.
    let store = Store::open_existing(directory)?;
    let reader = open_to_read(directory)?;
    let found = FoundGarbage::find(&reader, &limits)?;
    let blobs = reader.blobs().clone();
    if !args.json {
        output::print(&list(&found, &blobs)?)?;
    }
    drop(reader);
    let done = store.collect(&found.garbage())?;
    say(args, &found, &blobs, Some(done))
}

/// Says what is garbage, or what became of it.
fn say(
    args: &GcArgs,
    found: &FoundGarbage,
    blobs: &Blobs,
    done: Option<Collection>,
) -> Result<Finish> {
    if args.json {
        return output::print_json(&serde_json::json!({
            "removed": done.is_some(),
            "results": found.results,
            "files_of_results": found.files_of_results,
            "files": found.files,
            "bytes": bytes(found),
            "kept_of_earlier_physics": found.comparable,
            "kept_for_unfinished_studies": found.awaited,
            "unread_records": found.unread,
            "unfinished_files": done.map(|done| done.unfinished),
            "database_bytes_before": done.map(|done| done.database_before),
            "database_bytes_after": done.map(|done| done.database_after),
            "in_place": done.map(|done| done.is_in_place),
        }));
    }
    let text = match done {
        None if found.is_empty() => list(found, blobs)?,
        None => list(found, blobs)? + "nothing was removed, as --dry-run asks\n",
        Some(done) if found.is_empty() && done.unfinished == 0 => String::new(),
        Some(Collection {
            records,
            blobs,
            unfinished,
            database_before,
            database_after,
            is_in_place,
            is_old_left,
            ..
        }) => {
            let mut text = format!(
                "removed {} and {}; the database takes {}, where it took {}\n",
                count(records, "result", "results"),
                count(blobs + unfinished, "file", "files"),
                BinaryBytes(database_after),
                BinaryBytes(database_before)
            );
            if is_in_place {
                text += "the disk has no room for a smaller copy of the database; later results \
                         use the space in it that is free now\n";
            }
            if is_old_left {
                text += "the old database could not be removed (`records.replaced` in the store); \
                         the next command that writes tries again\n";
            }
            text
        }
    };
    output::print(&text)
}

/// Returns the size of all garbage \[bytes\].
fn bytes(found: &FoundGarbage) -> u64 {
    // A file of fields is counted with its result, and an account of a run with none.
    let runs: HashSet<[u8; 32]> = found.results.iter().filter_map(|result| result.run).collect();
    let is_account = |file: &&UnusedFile| runs.contains(&file.digest.0);
    let results = found.results.iter().map(|result| result.bytes);
    let accounts = found.files_of_results.iter().filter(is_account);
    results.chain(accounts.chain(&found.files).map(|file| file.bytes)).sum()
}

/// Lists the garbage: results by the runs that computed them, and files.
fn list(found: &FoundGarbage, blobs: &Blobs) -> Result<String> {
    let mut text = String::new();
    if found.unread > 0 {
        let records = count(found.unread, "record", "records");
        text += &format!(
            "{records} cannot be read by this version of the program, or at all; no files are \
             removed, which they may need (`store verify` and `store salvage` say more)\n"
        );
    }
    for (name, kept) in &found.awaited {
        text += &format!(
            "the study `{name}` is not finished: {}, {}, stay, which it may yet refer to\n",
            count(kept.results, "result", "results"),
            BinaryBytes(kept.bytes)
        );
    }
    if found.comparable.results > 0 {
        text += &format!(
            "{} of earlier versions of the physics, {}, stay for `diff` (--earlier-physics removes \
             them)\n",
            count(found.comparable.results, "result", "results"),
            BinaryBytes(found.comparable.bytes)
        );
    }
    if found.is_empty() {
        return Ok(text + "nothing to remove\n");
    }
    let (comparable, others): (Vec<_>, Vec<_>) =
        found.results.iter().partition(|result| result.is_comparable);
    for (results, what) in [
        (others, "that no study refers to"),
        (comparable, "of earlier versions of the physics, which `diff` can no more compare then"),
    ] {
        if !results.is_empty() {
            text += &runs(&results, what, blobs)?;
        }
    }
    if !found.files_of_results.is_empty() {
        let files = count(found.files_of_results.len(), "file goes", "files go");
        text += &format!("{files} with them\n");
    }
    if let Some(last) = found.files.last() {
        let size: u64 = found.files.iter().map(|file| file.bytes).sum();
        text += &format!(
            "{} that nothing refers to, {}, the newest of {}\n",
            count(found.files.len(), "file", "files"),
            BinaryBytes(size),
            time_words(last.changed)
        );
    }
    Ok(text)
}

/// Lists the runs that computed some results, the oldest first; `what` says which these are.
fn runs(results: &[&UnusedResult], what: &str, blobs: &Blobs) -> Result<String> {
    let mut runs: HashMap<Option<[u8; 32]>, Vec<&UnusedResult>> = HashMap::new();
    for &result in results {
        runs.entry(result.run).or_default().push(result);
    }
    let last = |results: &[&UnusedResult]| results.iter().map(|result| result.finished).max();
    let mut runs: Vec<_> = runs.into_iter().collect();
    runs.sort_by_key(|(run, results)| (last(results), *run));
    let more = runs.len().saturating_sub(MOST_RUNS);
    runs.truncate(MOST_RUNS);
    let rows = runs.iter().map(|(run, results)| {
        let size: u64 = results.iter().map(|result| result.bytes).sum();
        let finished = last(results).filter(|seconds| *seconds > 0);
        let account = run.and_then(|run| account(blobs, &run));
        vec![
            finished.map_or(Cell::Missing, |seconds| Cell::Text(time_words(seconds))),
            Cell::Integer(results.len() as i64),
            Cell::Text(BinaryBytes(size).to_string()),
            account.map_or(Cell::Missing, |account| Cell::Text(command_words(&account.command))),
        ]
    });
    let heads = ["computed", "results", "size", "by"].map(|name| TableColumn::new(name, ""));
    let size: u64 = results.iter().map(|result| result.bytes).sum();
    let mut text = format!(
        "{} {what}, {}:\n{}",
        count(results.len(), "result", "results"),
        BinaryBytes(size),
        DataTable::new(heads.to_vec(), rows.collect())?.terminal(&layout())
    );
    if more > 0 {
        text += &format!("… and of {}\n", count(more, "later run", "later runs"));
    }
    Ok(text)
}
