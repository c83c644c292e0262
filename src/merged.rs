//! The report of a merge: what was added, what contradicts, and what is missing with the command
//! that computes it.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use serde::Serialize;
use store::{LostCompanion, MergeReport, ShardState, StoreReader};
use study::Study;

use crate::merge_rules::ShardNote;
use crate::output::{self, Finish};
use crate::words::count;

/// The number of missing shards whose commands are printed; JSON has all of them.
const COMMANDS: usize = 8;

/// A study of which shards were merged.
#[derive(Debug, PartialEq, Serialize)]
struct ShardedStudy {
    study: String,
    shards: u32,
    present: usize,
    missing: Vec<ShardToRun>,
    unfinished: Vec<ShardToRun>,
}

/// A shard that is to be run.
#[derive(Debug, PartialEq, Serialize)]
struct ShardToRun {
    shard: u32,
    /// The progress in words, if the shard has left any.
    #[serde(skip_serializing_if = "Option::is_none")]
    progress: Option<String>,
    command: String,
}

/// The places that a command to run a shard names.
struct ShardPlaces<'r> {
    readers: &'r [StoreReader],
    exports: PathBuf,
}

impl ShardPlaces<'_> {
    /// Returns the path of the file of a study, as somebody gave it to a run.
    fn file(&self, study: &str, states: &[&ShardState]) -> PathBuf {
        let note = |state: &&ShardState| ShardNote::of(state.note.as_deref()?)?.file;
        if let Some(file) = states.iter().find_map(note) {
            return PathBuf::from(file);
        }
        let defined = self.readers.iter().find_map(|reader| {
            let definition = reader.study(study).ok()??;
            Some(PathBuf::from(Study::from_definition(&definition).ok()?.path()))
        });
        defined.unwrap_or_else(|| PathBuf::from(format!("{study}.toml")))
    }

    fn command(&self, file: &Path, shard: u32, count: u32) -> String {
        let shard = format!("{shard}/{count}");
        let words: [&OsStr; 6] = [
            "run".as_ref(),
            &wording::file_argument(file),
            "--shard".as_ref(),
            shard.as_ref(),
            "--export".as_ref(),
            &wording::file_argument(&self.exports),
        ];
        wording::command(words)
    }
}

/// Says for every study that came in shards which are missing or unfinished.
fn sharded(shards: &[ShardState], places: &ShardPlaces) -> Vec<ShardedStudy> {
    let mut studies: BTreeMap<&str, Vec<&ShardState>> = BTreeMap::new();
    for state in shards {
        studies.entry(&state.shard.study).or_default().push(state);
    }
    let of_study = |(study, states): (&str, Vec<&ShardState>)| {
        let count = states.first().map_or(0, |state| state.shard.count);
        let file = places.file(study, &states);
        let to_run = |shard: u32, progress: Option<String>| ShardToRun {
            shard,
            progress,
            command: places.command(&file, shard, count),
        };
        let partition = |state: &ShardState| ShardNote::of(state.note.as_deref()?)?.partition;
        let first = states.iter().find_map(|state| partition(state));
        let there: BTreeSet<u32> = states.iter().map(|state| state.shard.index).collect();
        let unfinished = states.iter().filter_map(|state| {
            let note = state.note.as_deref().and_then(ShardNote::of);
            let progress = match note {
                Some(note) if note.partition.is_some() && note.partition != first => {
                    "it was cut by another partition than the first, so that points may be missing; \
                     remove its export"
                        .to_owned()
                }
                Some(note) if note.finished => return None,
                Some(ShardNote { jobs, done, failed, left, .. }) => {
                    let lost = match left {
                        0 => ", but its end or some of its results are not here",
                        _ => "",
                    };
                    format!("{done} of {jobs} jobs solved, {failed} failed and {left} left{lost}")
                }
                None => "it has not said how far it is".to_owned(),
            };
            Some(to_run(state.shard.index, Some(progress)))
        });
        ShardedStudy {
            study: study.to_owned(),
            shards: count,
            present: states.len(),
            missing: (1..=count).filter(|i| !there.contains(i)).map(|i| to_run(i, None)).collect(),
            unfinished: unfinished.collect(),
        }
    };
    studies.into_iter().map(of_study).collect()
}

/// Lists numbers in words, as in "3, 7 and 9 to 12".
fn listed(numbers: impl IntoIterator<Item = u32>) -> String {
    let mut ranges: Vec<(u32, u32)> = Vec::new();
    for number in numbers {
        match ranges.last_mut() {
            Some((_, last)) if *last + 1 == number => *last = number,
            _ => ranges.push((number, number)),
        }
    }
    let words: Vec<String> = ranges
        .into_iter()
        .flat_map(|(first, last)| match last - first {
            0 => vec![first.to_string()],
            1 => vec![first.to_string(), last.to_string()],
            _ => vec![format!("{first} to {last}")],
        })
        .collect();
    match words.split_last() {
        None => String::new(),
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
    }
}

impl ShardedStudy {
    fn words(&self) -> String {
        let ShardedStudy { study, shards, present, missing, unfinished } = self;
        let mut text = format!("`{study}`: {present} of {shards} shards");
        match &missing[..] {
            [] if unfinished.is_empty() => return text + ", all finished\n",
            [] => {}
            [one] => text += &format!("; missing is {}", one.shard),
            _ => text += &format!("; missing are {}", listed(missing.iter().map(|one| one.shard))),
        }
        text += "\n";
        for one in missing.iter().take(COMMANDS) {
            text += &format!("  missing {}: `{}`\n", one.shard, one.command);
        }
        if missing.len() > COMMANDS {
            let more = count(missing.len() - COMMANDS, "other", "others");
            text += &format!("  and {more}, likewise\n");
        }
        for one in unfinished {
            let progress = one.progress.as_deref().unwrap_or_default();
            text += &format!("  unfinished {}: {progress}; `{}`\n", one.shard, one.command);
        }
        text
    }
}

/// Returns the directory of the first export that is named, where the missing ones would be sought.
fn directory_of(readers: &[StoreReader]) -> PathBuf {
    let first = readers.iter().flat_map(StoreReader::exports).next().map(|export| export.path);
    let above = first.as_deref().and_then(Path::parent);
    let above = above.filter(|above| !above.as_os_str().is_empty());
    above.unwrap_or(Path::new(".")).to_owned()
}

/// Says in words where exports are of another version of the program.
fn versions(readers: &[StoreReader]) -> Vec<String> {
    let mut others: BTreeMap<String, usize> = BTreeMap::new();
    for export in readers.iter().flat_map(StoreReader::exports) {
        let program = export.header.program;
        if !program.is_empty() && program != env!("CARGO_PKG_VERSION") {
            *others.entry(program).or_default() += 1;
        }
    }
    let words = |(version, number): (String, usize)| {
        format!(
            "{} by version {version} of the program: results of another version of the physics lie \
             beside those of this one and are not used",
            count(number, "export is", "exports are")
        )
    };
    others.into_iter().map(words).collect()
}

/// Says in words which accounts of runs are lost. The results are whole without them.
pub(crate) fn lost_accounts(lost: &[LostCompanion]) -> Vec<String> {
    let words = |LostCompanion { digest, records, reason }: &LostCompanion| {
        format!(
            "the account of a run, file {digest}, cannot be read ({reason}): {} what computed them; \
             they are whole all the same",
            count(*records, "result does not say", "results do not say")
        )
    };
    lost.iter().map(words).collect()
}

/// Says in words of which shards nothing is remembered any more.
fn forgotten(report: &MergeReport) -> Vec<String> {
    let mut divisions: BTreeMap<(&str, u32), usize> = BTreeMap::new();
    for shard in &report.forgotten {
        *divisions.entry((&shard.study, shard.count)).or_default() += 1;
    }
    let words = |((study, shards), number): ((&str, u32), usize)| {
        let known = report.shards.iter().find(|state| state.shard.study == study);
        let now = known.map_or(0, |state| state.shard.count);
        format!(
            "`{study}`: {} that were remembered of {shards} are forgotten, because it is in {} \
             now; their results stay",
            count(number, "shard", "shards"),
            count(now as usize, "shard", "shards")
        )
    };
    divisions.into_iter().map(words).collect()
}

/// Prints the report of a merge of what `readers` read into `target`, and says what is missing of
/// studies that came in shards.
pub(crate) fn print_report(
    report: &MergeReport,
    readers: &[StoreReader],
    target: &Path,
    json: bool,
) -> anyhow::Result<Finish> {
    let places = ShardPlaces { readers, exports: directory_of(readers) };
    print(report, readers, target, json, &sharded(&report.shards, &places))
}

/// Prints the report of an export, which is of what is there.
pub(crate) fn print_export(
    report: &MergeReport,
    reader: StoreReader,
    target: &Path,
    json: bool,
) -> anyhow::Result<Finish> {
    print(report, &[reader], target, json, &[])
}

fn print(
    report: &MergeReport,
    readers: &[StoreReader],
    target: &Path,
    json: bool,
    sharded: &[ShardedStudy],
) -> anyhow::Result<Finish> {
    let versions = versions(readers);
    let is_whole =
        sharded.iter().all(|study| study.missing.is_empty() && study.unfinished.is_empty());
    let damage: Vec<String> = readers
        .iter()
        .flat_map(StoreReader::exports)
        .flat_map(|export| {
            let path = export.path.display().to_string();
            export.damage.into_iter().map(move |reason| format!("{path}: {reason}"))
        })
        .collect();
    let incomplete = &report.incomplete;
    let faults: Vec<&String> = damage.iter().chain(&report.faults).chain(incomplete).collect();
    if json {
        let conflicts = report.conflicts.iter().map(|conflict| {
            serde_json::json!({
                "key": conflict.key.to_string(),
                "sources": [&conflict.first, &conflict.second],
            })
        });
        output::print_json(&serde_json::json!({
            "added": report.added,
            "replaced": report.replaced,
            "already_there": report.already_there,
            "of_other_versions": report.foreign,
            "files": report.blobs,
            "studies": report.studies,
            "conflicts": conflicts.collect::<Vec<_>>(),
            "faults": faults,
            "versions": versions,
            "forgotten": report.forgotten,
            "sharded": sharded,
            "provenance_notes": lost_accounts(&report.lost_companions),
        }))?;
    } else {
        let mut text = format!(
            "{}: added {}, {} and {}; {} already there\n",
            target.display(),
            count(report.added, "record", "records"),
            count(report.blobs, "file", "files"),
            count(report.studies, "study", "studies"),
            count(report.already_there, "record was", "records were"),
        );
        if report.replaced > 0 {
            let jobs = count(report.replaced, "job", "jobs");
            text += &format!("{jobs} that had been set aside got a result\n");
        }
        if report.foreign > 0 {
            let records = count(report.foreign, "record is", "records are");
            text += &format!("{records} of another version of this program, and not used\n");
        }
        versions.iter().for_each(|words| text += &format!("{words}\n"));
        forgotten(report).iter().for_each(|words| text += &format!("{words}\n"));
        for conflict in &report.conflicts {
            text += &format!(
                "conflict: job {} has different results in {} and {}; nothing of it was changed\n",
                conflict.key,
                conflict.first.display(),
                conflict.second.display()
            );
        }
        damage.iter().for_each(|fault| text += &format!("damaged: {fault}\n"));
        let left_out = &report.faults;
        left_out.iter().for_each(|fault| text += &format!("left out: {fault}\n"));
        incomplete
            .iter()
            .for_each(|fault| text += &format!("merged without its file of fields: {fault}\n"));
        let notes = lost_accounts(&report.lost_companions);
        notes.iter().for_each(|note| text += &format!("note: {note}\n"));
        sharded.iter().for_each(|study| text += &study.words());
        output::print(&text)?;
    }
    Ok(match () {
        () if !report.conflicts.is_empty() => Finish::Mistake,
        () if !is_whole || !faults.is_empty() => Finish::SomeFailed,
        () => Finish::AllDone,
    })
}

#[cfg(test)]
mod tests {
    use super::listed;

    #[test]
    fn numbers_are_listed_in_words() {
        assert_eq!(listed([3]), "3");
        assert_eq!(listed([3, 7]), "3 and 7");
        assert_eq!(listed([3, 4, 9, 10, 11, 12]), "3, 4 and 9 to 12");
        assert_eq!(listed([1, 2, 3]), "1 to 3");
        assert_eq!(listed([]), "");
    }
}
