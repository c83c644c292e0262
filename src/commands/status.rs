//! `status`: how far the studies of a store are.

use answers::{Progress, Results};
use anyhow::{Context, Result};
use report::{Cell, DataTable, TableColumn};
use store::{Glance, StoreReader, StudyLabels};

use crate::cli::StatusArgs;
use crate::kept_study::KeptStudy;
use crate::labels::{self, add_json};
use crate::output::{self, Finish, layout};
use crate::shard_states::StudyShards;
use crate::stored::{StoreSource, read_store, stored_large_study};
use crate::study_table::StudyTable;

/// Lists studies with their numbers of points.
pub(crate) fn status(args: &StatusArgs) -> Result<Finish> {
    let glance = Glance::at(&args.store.store);
    if let Some(glance) = &glance
        && let Some(list) = known_list(args, glance)
    {
        return list.shown(args.json);
    }
    let reader = read_store(&args.store.store)?;
    let names = match &args.name {
        Some(name) => vec![name.clone()],
        None => reader.study_names()?,
    };
    let source = StoreSource::Reader(&reader);
    let mut list = StatusList { is_empty: names.is_empty(), ..StatusList::default() };
    let exports = reader.exports();
    let all_labels = reader.labels()?;
    for name in &names {
        let labels = all_labels.get(name).cloned().unwrap_or_default();
        if let Some(counts) = glance.as_ref().and_then(|glance| StudyCounts::known(glance, name)) {
            list.add_known(name, &counts, labels);
            continue;
        }
        let large = stored_large_study(&reader, name).ok().filter(|study| !study.is_listed());
        if let Some(study) = large.filter(|study| !study.is_one_run() || !study.is_plain()) {
            // Only its shards say how far it is.
            let shards = StudyShards::of(name, &exports);
            let listed_shards: Vec<_> = shards.iter().flat_map(|shards| &shards.rows).collect();
            let mut entry = serde_json::json!({
                "study": name, "question": study.question(),
                "progress": { "points": study.len() },
                "shards": listed_shards,
            });
            add_json(&mut entry, &labels);
            let mut row = vec![Cell::Text(name.clone()), Cell::Integer(study.len() as i64)];
            row.resize(6, Cell::Missing);
            row.push(Cell::Text(study.question().to_owned()));
            list.add(entry, row, labels);
            list.sharded.extend(shards);
            continue;
        }
        let counted = match counted(&reader, name, &source) {
            Ok(counted) => counted,
            // One damaged study must not hide the others, nor pass for one that is not there.
            Err(error) if args.name.is_none() => {
                output::complain(&error);
                list.has_mistakes = true;
                continue;
            }
            Err(error) => return Err(error),
        };
        let (mut entry, row) = counted.listed(name);
        let shards = StudyShards::of(name, &exports);
        if !shards.is_empty() {
            let all: Vec<_> = shards.iter().flat_map(|shards| &shards.rows).collect();
            entry["shards"] = serde_json::to_value(all)?;
        }
        add_json(&mut entry, &labels);
        list.add(entry, row, labels);
        list.sharded.extend(shards);
    }
    list.shown(args.json)
}

/// Lists the studies by what is kept of them; `None` if that does not tell the counts of one.
fn known_list(args: &StatusArgs, glance: &Glance) -> Option<StatusList> {
    let names: Vec<&str> = match &args.name {
        Some(name) => vec![name],
        None => glance.study_names().collect(),
    };
    let mut list = StatusList { is_empty: names.is_empty(), ..StatusList::default() };
    for name in names {
        list.add_known(name, &StudyCounts::known(glance, name)?, glance.labels(name));
    }
    Some(list)
}

/// The counts of a study.
struct StudyCounts {
    progress: Progress,
    inaccurate: usize,
    question: String,
}

impl StudyCounts {
    /// Returns the counts of a study that are kept in words, or else those of its table.
    fn known(glance: &Glance, name: &str) -> Option<Self> {
        if let Some(kept) = KeptStudy::at_a_glance(glance, name) {
            return Some(StudyCounts {
                progress: kept.progress(),
                inaccurate: kept.inaccurate(),
                question: kept.question().to_owned(),
            });
        }
        let (table, study) = StudyTable::at_a_glance(glance, name)?;
        // What a study chooses, and whether it is as accurate as was asked, is more than its rows.
        let is_one = study.is_listed() || study.is_one_run() && study.is_plain();
        if study.adaptive().is_some() || !is_one {
            return None;
        }
        let progress = table.progress(&study)?;
        Some(StudyCounts { progress, inaccurate: 0, question: study.question().to_owned() })
    }

    /// Returns the entry and the row of a list of studies.
    fn listed(&self, name: &str) -> (serde_json::Value, Vec<Cell>) {
        let StudyCounts { progress, inaccurate, question } = self;
        let entry = serde_json::json!({
            "study": name, "question": question, "progress": progress, "inaccurate": inaccurate,
        });
        let mut row = vec![Cell::Text(name.to_owned())];
        row.extend(
            [progress.points, progress.done, progress.failed, progress.left, *inaccurate]
                .map(|count| Cell::Integer(count as i64)),
        );
        row.push(Cell::Text(question.clone()));
        (entry, row)
    }
}

/// The list of studies.
#[derive(Default)]
struct StatusList {
    /// There is no study.
    is_empty: bool,
    /// Some study could not be read.
    has_mistakes: bool,
    entries: Vec<serde_json::Value>,
    rows: Vec<Vec<Cell>>,
    labels: Vec<StudyLabels>,
    sharded: Vec<StudyShards>,
}

impl StatusList {
    fn add(&mut self, entry: serde_json::Value, row: Vec<Cell>, labels: StudyLabels) {
        self.entries.push(entry);
        self.rows.push(row);
        self.labels.push(labels);
    }

    /// Adds a study of which no shards are known.
    fn add_known(&mut self, name: &str, counts: &StudyCounts, labels: StudyLabels) {
        let (mut entry, row) = counts.listed(name);
        add_json(&mut entry, &labels);
        self.add(entry, row, labels);
    }

    /// Prints the list.
    fn shown(mut self, json: bool) -> Result<Finish> {
        let finish = if self.has_mistakes { Finish::Mistake } else { Finish::AllDone };
        if json {
            output::print_json(&self.entries)?;
            return Ok(finish);
        }
        if self.is_empty {
            return output::print("no studies so far\n");
        }
        if self.rows.is_empty() {
            return Ok(finish);
        }
        let names = ["study", "points", "certified", "failed", "left", "inaccurate", "question"];
        let mut heads = names.map(|name| TableColumn::new(name, "")).to_vec();
        let (label_heads, cells) = labels::columns(&self.labels);
        heads.extend(label_heads);
        self.rows.iter_mut().zip(cells).for_each(|(row, cells)| row.extend(cells));
        let mut text = DataTable::new(heads, self.rows)?.terminal(&layout());
        for shards in self.sharded {
            text += &format!("\n{}", shards.words()?);
        }
        output::print(&text)?;
        Ok(finish)
    }
}

/// Counts the results of a study.
fn counted(reader: &StoreReader, name: &str, source: &StoreSource<'_>) -> Result<StudyCounts> {
    let study = stored_large_study(reader, name)?;
    let results = Results::in_blocks(study, source).with_context(|| format!("study `{name}`"))?;
    Ok(StudyCounts {
        progress: results.progress(),
        inaccurate: results.inaccurate(),
        question: results.study().question().to_owned(),
    })
}
