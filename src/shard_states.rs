//! The state of the shards of a study, by what they last exported.

use std::collections::BTreeMap;
use std::time::{Duration, SystemTime};

use anyhow::Result;
use report::{Cell, DataTable, TableColumn};
use serde::Serialize;
use store::ExportSummary;

use crate::merge_rules::ShardNote;
use crate::output::layout;
use crate::words::{count, duration};

/// The most shards that are listed; the JSON lists all.
const MOST_LISTED: usize = 24;

/// The shards of a study.
pub(crate) struct StudyShards {
    study: String,
    pub(crate) rows: Vec<ShardRow>,
}

/// The state of one shard.
#[derive(Serialize)]
pub(crate) struct ShardRow {
    shard: String,
    state: ShardStanding,
    /// The note that it last left, if it has exported anything.
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<ShardNote>,
    /// The time since its file last changed \[s\].
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds_since_export: Option<f64>,
}

/// The standing of a shard.
#[derive(Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum ShardStanding {
    Finished,
    Unfinished,
    Missing,
}

/// A note and the age of the file from which it is.
struct AgedNote {
    note: Option<ShardNote>,
    age: Option<Duration>,
}

impl StudyShards {
    /// Returns the shards of a study among exports; `None` if it has none.
    pub(crate) fn of(study: &str, exports: &[ExportSummary]) -> Option<Self> {
        let mut count_of_shards = 0;
        let mut known: BTreeMap<u32, AgedNote> = BTreeMap::new();
        let now = SystemTime::now();
        for export in exports {
            let age = export.changed.and_then(|changed| now.duration_since(changed).ok());
            let whole = export.header.shard.iter().map(|shard| (shard, export.note.as_ref(), age));
            // How old a part was when it was merged is not known.
            let parts = export.parts.iter().map(|part| (&part.shard, part.note.as_ref(), None));
            for (shard, note, age) in whole.chain(parts) {
                if shard.study != study {
                    continue;
                }
                count_of_shards = count_of_shards.max(shard.count);
                let note = note.and_then(|note| ShardNote::of(note));
                let further = |known: &AgedNote| {
                    let done = |note: &Option<ShardNote>| {
                        note.as_ref().map(|note| (note.finished, note.done + note.failed))
                    };
                    done(&note) > done(&known.note)
                };
                if known.get(&shard.index).is_none_or(further) {
                    known.insert(shard.index, AgedNote { note, age });
                }
            }
        }
        let mut row = |index: u32| {
            let found = known.remove(&index);
            let state = match &found {
                None => ShardStanding::Missing,
                Some(AgedNote { note: Some(note), .. }) if note.finished => ShardStanding::Finished,
                Some(_) => ShardStanding::Unfinished,
            };
            let (note, age) = found.map_or((None, None), |found| (found.note, found.age));
            let seconds_since_export = age.map(|age| age.as_secs_f64());
            let shard = format!("{index}/{count_of_shards}");
            ShardRow { shard, state, note, seconds_since_export }
        };
        let rows: Vec<ShardRow> = (1..=count_of_shards).map(&mut row).collect();
        (!rows.is_empty()).then(|| Self { study: study.to_owned(), rows })
    }

    /// Says how many shards are finished, and lists the others.
    pub(crate) fn words(&self) -> Result<String> {
        let number = |state| self.rows.iter().filter(|row| row.state == state).count();
        let finished = number(ShardStanding::Finished);
        let mut text = format!(
            "{}: {} of {} finished, {} unfinished, {} missing\n",
            self.study,
            finished,
            count(self.rows.len(), "shard", "shards"),
            number(ShardStanding::Unfinished),
            number(ShardStanding::Missing)
        );
        let sum = |part: fn(&ShardNote) -> u64| {
            self.rows.iter().filter_map(|row| row.note.as_ref()).map(part).sum::<u64>() as usize
        };
        text += &format!(
            "{} certified, {} failed, {} left in the shards that have exported\n",
            count(sum(|note| note.done), "job", "jobs"),
            sum(|note| note.failed),
            sum(|note| note.left)
        );
        if finished == self.rows.len() {
            return Ok(text);
        }
        let others = self.rows.iter().filter(|row| row.state != ShardStanding::Finished);
        let rows = others.take(MOST_LISTED).map(ShardRow::cells).collect();
        let heads = ["shard", "jobs", "certified", "failed", "left", "last export"];
        let heads = heads.map(|name| TableColumn::new(name, "")).to_vec();
        text += &DataTable::new(heads, rows)?.terminal(&layout());
        let listed = MOST_LISTED.min(self.rows.len() - finished);
        if self.rows.len() - finished > listed {
            text +=
                &format!("and {} more; --json lists all\n", self.rows.len() - finished - listed);
        }
        Ok(text)
    }
}

impl ShardRow {
    fn cells(&self) -> Vec<Cell> {
        let number = |value: fn(&ShardNote) -> u64| match &self.note {
            Some(note) => Cell::Integer(value(note) as i64),
            None => Cell::Missing,
        };
        let last = match (self.state, self.seconds_since_export) {
            (ShardStanding::Missing, _) => "missing".to_owned(),
            (_, Some(seconds)) => format!("{} ago", duration(seconds)),
            (_, None) => String::new(),
        };
        vec![
            Cell::Text(self.shard.clone()),
            number(|note| note.jobs),
            number(|note| note.done),
            number(|note| note.failed),
            number(|note| note.left),
            Cell::Text(last),
        ]
    }
}
