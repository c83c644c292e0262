//! What happens in a run: one stream, from which progress bar, log and JSON are read.

use serde::{Serialize, Serializer};

use identity::JobKey;

/// Something that happened, when, and where the run stands after it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// Since the start of the run, in seconds.
    pub seconds: f64,
    /// What happened.
    #[serde(flatten)]
    pub kind: EventKind,
    /// Where the run stands now.
    pub counts: Counts,
}

/// Where a run stands; `waiting + running + saving + done + quarantined` is the number of jobs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Not handed out.
    pub waiting: usize,
    /// Handed out.
    pub running: usize,
    /// Finished, not yet durable.
    pub saving: usize,
    /// Durable, with a result.
    pub done: usize,
    /// Durable, set aside.
    pub quarantined: usize,
    /// Attempts that failed so far.
    pub failures: usize,
    /// Workers that live.
    pub workers: usize,
}

/// What happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum EventKind {
    /// The run begins.
    RunStarted,
    /// A worker asked for its first job.
    WorkerStarted {
        /// Its number; a replacement has a new one.
        worker: u32,
        /// Its process.
        pid: u32,
    },
    /// A worker is gone that was not told to leave.
    WorkerLost {
        /// Its number.
        worker: u32,
        /// Its process, if there ever was one.
        pid: Option<u32>,
        /// Signal or exit status, and why we killed it if we did.
        how: String,
    },
    /// A worker is started in the place of a lost one.
    WorkerReplaced {
        /// The lost one.
        lost: u32,
        /// The new one.
        by: u32,
    },
    /// A job was handed out.
    Leased {
        /// The job.
        #[serde(serialize_with = "as_text")]
        key: JobKey,
        /// To whom.
        worker: u32,
        /// Which attempt, from 1.
        attempt: u32,
    },
    /// A result is durable.
    Done {
        /// The job.
        #[serde(serialize_with = "as_text")]
        key: JobKey,
        /// Who computed it.
        worker: u32,
        /// How long that took, in seconds.
        #[serde(rename = "job_seconds")]
        seconds: f64,
        /// Attempts including the successful one.
        attempts: u32,
    },
    /// An attempt failed; the job goes back to the queue.
    Retried {
        /// The job.
        #[serde(serialize_with = "as_text")]
        key: JobKey,
        /// The attempt that failed, from 1.
        attempt: u32,
        /// Why it failed.
        reason: String,
    },
    /// A job is set aside, and that is durable.
    Quarantined {
        /// The job.
        #[serde(serialize_with = "as_text")]
        key: JobKey,
        /// Why the last attempt failed.
        reason: String,
        /// How many there were.
        attempts: u32,
    },
    /// A group of results is durable.
    Committed {
        /// How many.
        jobs: usize,
    },
    /// Somebody asked to stop.
    Interrupted {
        /// Asked twice: workers are killed.
        now: bool,
    },
    /// The run ends.
    Finished,
}

fn as_text<S: Serializer>(key: &JobKey, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_one_flat_json_object() {
        let kind =
            EventKind::Retried { key: JobKey([171; 32]), attempt: 1, reason: "signal 9".into() };
        let event = Event {
            seconds: 1.5,
            kind,
            counts: Counts { waiting: 1, failures: 1, ..Counts::default() },
        };
        let expected = format!(
            r#"{{"seconds":1.5,"event":"retried","key":"{}","attempt":1,"reason":"signal 9","counts":{{"waiting":1,"running":0,"saving":0,"done":0,"quarantined":0,"failures":1,"workers":0}}}}"#,
            "ab".repeat(32)
        );
        assert_eq!(serde_json::to_string(&event).unwrap(), expected);
    }
}
