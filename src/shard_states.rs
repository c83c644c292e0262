//! The state of the shards of a study, by what they last exported.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, SystemTime};

use anyhow::Result;
use report::{Cell, DataTable, TableColumn};
use serde::Serialize;
use store::{ExportSummary, ShardName};

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

/// The knowledge of one shard.
#[derive(Default)]
struct SeenShard {
    note: Option<ShardNote>,
    age: Option<Duration>,
    is_finished: bool,
}

impl SeenShard {
    /// Returns how far the shard is; a larger one is further.
    fn progress(&self) -> (bool, u64) {
        let ended = self.note.as_ref().map(|note| note.done.saturating_add(note.failed));
        (self.is_finished, ended.unwrap_or(0))
    }
}

impl StudyShards {
    /// Returns the shards of a study among exports, for each number of shards that it came in.
    pub(crate) fn of(study: &str, exports: &[ExportSummary]) -> Vec<Self> {
        let mut known: BTreeMap<(u32, u32), SeenShard> = BTreeMap::new();
        let now = SystemTime::now();
        let mut add = |shard: &ShardName, found: SeenShard| {
            if shard.study != study {
                return;
            }
            let entry = known.entry((shard.count, shard.index)).or_default();
            if entry.note.is_none() || found.progress() > entry.progress() {
                *entry = found;
            }
        };
        for export in exports {
            let age = export.changed.and_then(|changed| now.duration_since(changed).ok());
            if let Some(shard) = &export.header.shard {
                let note = export.note.as_deref().and_then(ShardNote::of);
                // What is finished is closed; a file that has lost its end is not.
                let is_finished =
                    export.is_closed && note.as_ref().is_some_and(|note| note.finished);
                add(shard, SeenShard { note, age, is_finished });
            }
            for part in &export.parts {
                let note = part.note.as_deref().and_then(ShardNote::of);
                let is_finished = note.as_ref().is_some_and(|note| note.finished);
                // How old a part was when it was merged is not known.
                add(&part.shard, SeenShard { note, age: None, is_finished });
            }
        }
        let counts: BTreeSet<u32> = known.keys().map(|(count, _)| *count).collect();
        let of_count = |count: u32| {
            let row = |index: u32| ShardRow::of(index, count, known.remove(&(count, index)));
            let rows = (1..=count).map(row).collect();
            Self { study: study.to_owned(), rows }
        };
        counts.into_iter().map(of_count).collect()
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
            self.rows
                .iter()
                .filter_map(|row| row.note.as_ref())
                .map(part)
                .fold(0, u64::saturating_add) as usize
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
    /// Returns the row of a shard of which something is known, or nothing.
    fn of(index: u32, count: u32, found: Option<SeenShard>) -> Self {
        let state = match &found {
            None => ShardStanding::Missing,
            Some(SeenShard { is_finished: true, .. }) => ShardStanding::Finished,
            Some(_) => ShardStanding::Unfinished,
        };
        let SeenShard { note, age, .. } = found.unwrap_or_default();
        let seconds_since_export = age.map(|age| age.as_secs_f64());
        Self { shard: format!("{index}/{count}"), state, note, seconds_since_export }
    }

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
