//! `store verify`, `salvage`, `compact`, `export`, `import` and `merge`. `store gc` has a file of
//! its own.

mod gc;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use answers::{AnswerError, Proof, Results, RowSource, Selection, bracket_ends, proof, survey};
use anyhow::{Context, Result, anyhow};
use contact::uniqueness::Question;
use contact::uniqueness::monotony::{Contradiction, contradictions};
use identity::JobKey;
use indicatif::BinaryBytes;
use store::{
    Digest, Glance, MergeSelection, OpenError, RecordOrigin, References, Store, StoreReader,
    merge_into_export, require_mergeable,
};
use study::encoding::DecodeError;
use study::{PointKeys, Record, Study};

use crate::cli::StoreCommand;
use crate::kept_study::KeptStudy;
use crate::merge_rules::{RULES, references};
use crate::output::{self, Finish};
use crate::stored::{StoreSource, read_store, stored_large_study};
use crate::study_table::StudyTable;
use crate::table_proof::TableProof;
use crate::words::count;
use crate::{merged, proposal};

/// Checks a store, tidies it or copies it.
pub(crate) fn store(command: &StoreCommand) -> Result<Finish> {
    match command {
        StoreCommand::Verify { deep, json, store } => {
            verify(&read_store(&store.store)?, *deep, *json)
        }
        StoreCommand::Salvage { json, store } => salvage(&store.store, *json),
        StoreCommand::Compact { json, store } => {
            compact(&Store::open_existing(&store.store)?, *json)
        }
        StoreCommand::Gc(args) => gc::gc(args),
        StoreCommand::Export { file, studies, json, store } => {
            export(read_store(&store.store)?, file, studies, *json)
        }
        StoreCommand::Import { sources, json, store } => import(sources, &store.store, *json),
        StoreCommand::Merge { sources, into, json } => import(sources, into, *json),
    }
}

/// Returns the files that an encoded record needs. A record that cannot be decoded needs none that
/// are known.
fn needed_by(bytes: &[u8]) -> Vec<Digest> {
    Record::decode(bytes).map_or_else(|_| Vec::new(), |record| references(&record).needed)
}

/// Returns the brackets that contradict one on a part of their domain, with the reason.
fn contradicted(brackets: Vec<(JobKey, (Question, [f64; 2]))>) -> Vec<(JobKey, String)> {
    let (keys, brackets): (Vec<JobKey>, Vec<(Question, [f64; 2])>) = brackets.into_iter().unzip();
    let reason = |Contradiction { smaller, larger }: Contradiction| {
        let ([low, _], [_, high]) = (brackets[larger].1, brackets[smaller].1);
        let reason = format!(
            "its lower end {low} is above the upper end {high} of record {}, whose domain is a \
             part of its own: one of the two is wrong",
            keys[smaller]
        );
        (keys[larger], reason)
    };
    contradictions(&brackets).into_iter().map(reason).collect()
}

fn verify(store: &StoreReader, deep: bool, json: bool) -> Result<Finish> {
    let mut undecodable: Vec<(JobKey, String)> = Vec::new();
    let mut too_large: Vec<(JobKey, String)> = Vec::new();
    let mut brackets: Vec<(JobKey, (Question, [f64; 2]))> = Vec::new();
    let (mut foreign, mut proved, mut excluded) = (0, 0, 0);
    let found = store.verify(|key, bytes| match Record::decode(bytes) {
        Ok(record) if record.key() == *key => {
            match deep.then(|| proof(&record)).flatten() {
                Some(Proof::Holds(_)) if record.branched().is_some() => excluded += 1,
                Some(Proof::Holds(_)) => {
                    proved += 1;
                    brackets.extend(bracket_ends(&record).map(|ends| (*key, ends)));
                }
                Some(Proof::TooLarge(reason)) => too_large.push((*key, reason)),
                Some(Proof::Wrong(reason)) => undecodable.push((*key, reason)),
                None => {}
            }
            references(&record)
        }
        Ok(_) => {
            undecodable.push((*key, "it is the record of another job".to_owned()));
            References::default()
        }
        // The record is sound for the version of the program that wrote it.
        Err(DecodeError::Version { .. }) => {
            foreign += 1;
            References::default()
        }
        Err(error) => {
            undecodable.push((*key, error.to_string()));
            References::default()
        }
    })?;
    undecodable.extend(contradicted(brackets));
    let sound = found.is_sound() && undecodable.is_empty();
    let mut faults = Vec::new();
    let records = found.corrupt_records.iter().chain(&undecodable);
    faults.extend(records.map(|(key, reason)| format!("record {key}: {reason}")));
    faults.extend(
        found.corrupt_blobs.iter().map(|(digest, reason)| format!("file {digest}: {reason}")),
    );
    faults.extend(
        found
            .missing_blobs
            .iter()
            .map(|(digest, key)| format!("file {digest} is missing, job {key} refers to it")),
    );
    faults
        .extend(found.lost_studies.iter().map(|(name, reason)| format!("study {name}: {reason}")));
    faults.extend(found.damaged_exports);
    // No run brings these back, and no result is lost with them: they are said, and the code stays.
    let notes = merged::lost_accounts(&found.lost_companions);
    let tables = prove_tables(store);
    let kept = prove_kept(store, sound && tables.notes.is_empty());
    let is_exports = !store.exports().is_empty();
    if json {
        output::print_json(&serde_json::json!({
            "sound": sound,
            "records": found.records,
            "files": found.blobs,
            "file_bytes": found.blob_bytes,
            "studies": found.studies,
            "kept_counts": { "proved": kept.proved, "notes": kept.notes },
            "kept_tables": { "proved": tables.proved, "notes": tables.notes },
            "brackets_proved": deep.then_some(proved),
            "branches_proved": deep.then_some(excluded),
            "brackets_too_large": deep.then_some(too_large.len()),
            "records_of_other_versions": foreign,
            "unreferenced_files": found.unreferenced_blobs,
            "stray_files": found.stray_files,
            "open_exports": found.open_exports,
            "faults": faults,
            "provenance_notes": notes,
        }))?;
    } else {
        let mut text = format!(
            "{}, {} ({}), {}",
            count(found.records, "record", "records"),
            count(found.blobs, "file", "files"),
            BinaryBytes(found.blob_bytes),
            count(found.studies, "study", "studies")
        );
        text += if sound { ": all sound\n" } else { "\n" };
        if deep {
            text += &format!(
                "{} of uniqueness sets proved anew\n",
                count(proved, "bracket", "brackets")
            );
            if excluded > 0 {
                let branches = count(excluded, "branch", "branches");
                text += &format!("{branches} of their fields proved anew\n");
            }
            too_large.iter().for_each(|(key, reason)| {
                text += &format!("not checked: record {key}: {reason}\n")
            });
        }
        faults.iter().for_each(|fault| text += &format!("damaged: {fault}\n"));
        let kept_notes = kept.notes.iter().chain(&tables.notes);
        notes.iter().chain(kept_notes).for_each(|note| text += &format!("note: {note}\n"));
        if !sound && is_exports {
            text += "to run their shards again computes what is damaged, and keeps the rest\n";
        } else if !sound {
            text += "`tribosweep run` of the studies concerned computes again what they need; \
                     `tribosweep store salvage` gives up what no study needs any more\n";
        }
        if foreign > 0 {
            text += &format!(
                "{} of another version of this program, and not used\n",
                count(foreign, "record is", "records are")
            );
        }
        if found.unreferenced_blobs > 0 && foreign == 0 && !is_exports {
            let files = count(found.unreferenced_blobs, "file is", "files are");
            text += &format!(
                "{files} referred to by nothing; `{}` removes what is\n",
                proposal::command(store.blobs().store(), ["store", "compact"])
            );
        }
        found
            .stray_files
            .iter()
            .for_each(|file| text += &format!("not the store's: {}\n", file.display()));
        for file in &found.open_exports {
            text += &format!(
                "no end: {} is being written, or its run was stopped, or it was cut short\n",
                file.display()
            );
        }
        output::print(&text)?;
    }
    Ok(if sound { Finish::AllDone } else { Finish::SomeFailed })
}

/// The outcome of proving what is kept about studies.
#[derive(Default)]
struct KeptProof {
    /// The number of studies of which it is right.
    proved: usize,
    notes: Vec<String>,
}

/// Makes the tables that are kept of studies anew, and compares them.
fn prove_tables(store: &StoreReader) -> KeptProof {
    let mut found = KeptProof::default();
    let Some(glance) = Glance::at(store.blobs().store()) else { return found };
    for name in glance.study_names() {
        let Some((table, study)) = StudyTable::at_a_glance(&glance, name) else { continue };
        match has_rows_of(&table, study, &StoreSource::Reader(store)) {
            Ok(true) => found.proved += 1,
            Ok(false) | Err(_) => found.notes.push(format!(
                "the table that was kept of `{name}` is not right, and is forgotten"
            )),
        }
    }
    found
}

/// Returns whether a table has the rows that are made of the records of a study.
fn has_rows_of(table: &StudyTable, study: Study, source: &StoreSource<'_>) -> Result<bool> {
    let proof = TableProof::of(table);
    let is_usual = |results: &Results<'_>| -> Result<bool> {
        let Some(usual) = table.usual_columns() else { return Ok(true) };
        Ok(results.usual_columns(false)? == usual)
    };
    if study.has_independent_points() {
        survey(&study, source, Some(&proof))?;
        return Ok(proof.holds());
    }
    if study.adaptive().is_some() || table.usual_columns().is_some() {
        let results = Results::read(study, source)?;
        results.keep_rows(&proof);
        return Ok(is_usual(&results)? && proof.holds());
    }
    // No row is shown.
    let none = Selection { filter: Some("false".to_owned()), ..Selection::default() };
    let rows = RowSource::Records { records: source, keeper: Some(&proof) };
    none.visit(&study, rows, |_| Ok::<(), AnswerError>(()))?;
    Ok(proof.holds())
}

/// Counts the results of the studies about which words are kept, and forgets all words if some are
/// wrong, or if the store is not `sound`: the next run then examines every record.
fn prove_kept(store: &StoreReader, sound: bool) -> KeptProof {
    let directory = store.blobs().store();
    let mut proof = KeptProof::default();
    let Some(glance) = Glance::at(directory) else { return proof };
    let source = StoreSource::Reader(store);
    let mut are_wrong = !sound;
    for name in glance.study_names() {
        let Some(kept) = KeptStudy::at_a_glance(&glance, name) else { continue };
        let counted = stored_large_study(store, name)
            .and_then(|study| Ok(Results::in_blocks(study, &source)?))
            .map(|results| (results.progress(), results.inaccurate()));
        match counted {
            Ok((progress, inaccurate))
                if progress == kept.progress() && inaccurate == kept.inaccurate() =>
            {
                proof.proved += 1;
            }
            _ => {
                are_wrong = true;
                proof.notes.push(format!(
                    "the counts that were kept of `{name}` are not right, and are forgotten"
                ));
            }
        }
    }
    // Without them the next run and `status` count anew. A process that has the store open has
    // taken them already.
    if are_wrong && let Err(error) = Store::forget_words(directory) {
        proof.notes.push(format!("the kept counts cannot be forgotten: {error}"));
    }
    proof
}

fn salvage(directory: &Path, json: bool) -> Result<Finish> {
    let salvaged = Store::salvage(directory, |_, bytes| needed_by(bytes))?;
    if json {
        return output::print_json(&serde_json::json!({
            "kept": salvaged.kept,
            "promised": salvaged.promised,
            "without_their_file": salvaged.incomplete,
            "damaged_files": salvaged.damaged_blobs,
            "studies": salvaged.studies,
            "lost_studies": salvaged.lost_studies,
            "former_database": salvaged.damaged,
        }));
    }
    let promised =
        salvaged.promised.map_or(String::new(), |promised| format!(" of at least {promised}"));
    let mut text = format!(
        "kept {}{promised}, and {}\n",
        count(salvaged.kept, "record", "records"),
        count(salvaged.studies, "study", "studies")
    );
    if let Some(damaged) = &salvaged.damaged {
        text += &format!(
            "the former database is in {}; delete it when nothing is missed\n",
            damaged.display()
        );
    }
    if salvaged.damaged_blobs > 0 {
        let files = count(salvaged.damaged_blobs, "damaged file", "damaged files");
        text += &format!(
            "put aside {files} (their names end in .damaged-1); delete them when nothing is \
             missed\n"
        );
    }
    if salvaged.incomplete > 0 {
        let records = count(salvaged.incomplete, "record", "records");
        text += &format!(
            "gave up {records} whose file of fields is lost; the next run computes them again\n"
        );
    }
    for name in &salvaged.lost_studies {
        text += &format!(
            "the definition of the study `{name}` was damaged; to run its file again brings it \
             back\n"
        );
    }
    output::print(&text)
}

fn compact(store: &Store, json: bool) -> Result<Finish> {
    let mut referenced = BTreeSet::new();
    for (key, bytes) in store.records() {
        // A record that cannot be read might refer to any file, so nothing is removed then.
        let bytes = bytes.context("nothing was removed")?;
        let record = Record::decode(&bytes)
            .with_context(|| format!("the record of job {key}; nothing was removed"))?;
        let References { needed, companions } = references(&record);
        referenced.extend(needed.into_iter().chain(companions));
    }
    let done = store.compact(&referenced)?;
    if json {
        return output::print_json(&serde_json::json!({
            "files": done.blobs, "unfinished_files": done.unfinished, "bytes": done.bytes,
        }));
    }
    let (files, unfinished) = (
        count(done.blobs, "file", "files"),
        count(done.unfinished, "unfinished one", "unfinished ones"),
    );
    output::print(&format!("removed {files} and {unfinished}, {}\n", BinaryBytes(done.bytes)))
}

fn export(store: StoreReader, file: &Path, studies: &[String], json: bool) -> Result<Finish> {
    let mut selection = MergeSelection::default();
    if !studies.is_empty() {
        let source = StoreSource::Reader(&store);
        let mut keys = BTreeSet::new();
        for name in studies {
            let study = stored_large_study(&store, name)?;
            if study.adaptive().is_none() {
                let of_points = PointKeys::of(&study);
                keys.extend(study.indices().filter_map(|index| of_points.key(index)));
                continue;
            }
            let results =
                Results::read(study, &source).with_context(|| format!("study `{name}`"))?;
            keys.extend(results.points().iter().map(|point| point.key));
        }
        selection.studies = Some(studies.iter().cloned().collect());
        selection.keys = Some(keys);
    }
    let program = env!("CARGO_PKG_VERSION");
    let done = merge_into_export(file, program, &[&store], &RULES, &selection)?;
    merged::print_export(&done, store, file, json)
}

/// Merges stores and exports into the store or the export `target`.
fn import(sources: &[PathBuf], target: &Path, json: bool) -> Result<Finish> {
    let mut readers = Vec::new();
    for source in sources {
        let reader = Store::read_by(source, &RULES)?;
        match reader.origin() {
            RecordOrigin::Disk | RecordOrigin::Exports { .. } => {}
            origin => output::say(&format!("{}: {origin}", source.display())),
        }
        readers.push(reader);
    }
    let opened: Vec<&StoreReader> = readers.iter().collect();
    let is_file = target.extension().is_some_and(|extension| extension == "tribosweep");
    let done = if is_file && !target.is_dir() {
        let (program, all) = (env!("CARGO_PKG_VERSION"), MergeSelection::default());
        merge_into_export(target, program, &opened, &RULES, &all)?
    } else {
        // A merge that is refused leaves no store behind.
        require_mergeable(&opened, &RULES)?;
        let store = Store::open(target).map_err(|error| match error {
            OpenError::NetworkFileSystem { .. } => anyhow!(
                "{error}, or merge into one file, which may lie there: --into {}.tribosweep",
                target.display()
            ),
            error => error.into(),
        })?;
        store.import(&opened, &RULES)?
    };
    merged::print_report(&done, &readers, target, json)
}

#[cfg(test)]
mod tests {
    use contact::model::{Foundation, Material, Mesh, Projection};
    use contact::uniqueness::Sole;

    use super::*;

    /// Both ends of a bracket are proved, so no store that this program writes has two that
    /// contradict each other.
    #[test]
    fn a_bracket_above_that_of_a_part_of_its_domain_is_reported_with_both_ends() {
        let question = |n: u32| Question {
            foundation: Foundation::half_space(Material { shear_modulus: 1.0, poisson: 0.3 }),
            punch: None,
            sole: Sole::Rectangle { width_x: 1.0, width_y: 1.0 },
            mesh: Mesh::Exact([n, n]),
            projection: Projection::Average,
            epsilon: 0.0,
            plane: false,
        };
        let [part, whole] = [2, 3].map(|n| (JobKey::of(1, &n.to_string()), question(n)));
        let found = |low: f64| {
            contradicted(vec![
                (part.0, (part.1.clone(), [2.0, 3.0])),
                (whole.0, (whole.1.clone(), [low, 4.0])),
            ])
        };
        assert_eq!(found(2.9), []);
        let [(key, reason)] = &found(3.5)[..] else { panic!("one contradiction") };
        assert_eq!(*key, whole.0);
        assert!(
            reason.contains("its lower end 3.5 is above the upper end 3 of record")
                && reason.contains(&part.0.to_string()),
            "{reason}"
        );
    }
}
