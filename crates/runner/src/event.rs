//! Everything that happens in a run is one stream of events, from which progress bar, log and JSON
//! are made.

use serde::{Serialize, Serializer};

use identity::JobKey;

/// An event, with its time and the counts after it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// The time since the start of the run \[s\], without that in which the process stood still,
    /// stopped by a signal or a debugger.
    pub seconds: f64,
    /// The kind of the event.
    #[serde(flatten)]
    pub kind: EventKind,
    /// The number of jobs in every state after the event.
    pub counts: Counts,
}

/// The number of jobs in every state. `waiting + running + saving + done + quarantined +
/// postponed` is the number of jobs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// The number of jobs that are not handed out.
    pub waiting: usize,
    /// The number of jobs that are handed out.
    pub running: usize,
    /// The number of jobs that are finished and not yet durable.
    pub saving: usize,
    /// The number of jobs with a durable result.
    pub done: usize,
    /// The number of jobs that are durably set aside.
    pub quarantined: usize,
    /// The number of jobs that this run cannot do, although they may be sound. Nothing is recorded
    /// of them.
    pub postponed: usize,
    /// The number of attempts that failed so far.
    pub failures: usize,
    /// The number of live workers.
    pub workers: usize,
}

/// The kind of an event.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum EventKind {
    /// The run begins.
    RunStarted,
    /// The run has fewer workers than were asked for.
    WorkersLimited {
        /// The number of workers that the run has at a time.
        workers: usize,
        /// The reason why it does not have more.
        reason: String,
    },
    /// A worker asked for its first job.
    WorkerStarted {
        /// The number of the worker. A replacement has a new one.
        worker: u32,
        /// The process id of the worker.
        pid: u32,
    },
    /// A worker is gone that was not told to leave.
    WorkerLost {
        /// The number of the worker.
        worker: u32,
        /// The process id of the worker, if there ever was a process.
        pid: Option<u32>,
        /// The signal or exit status, and the reason if the coordinator killed it.
        how: String,
    },
    /// A worker is started in the place of a lost one.
    WorkerReplaced {
        /// The number of the lost worker.
        lost: u32,
        /// The number of the new worker.
        by: u32,
    },
    /// A job was handed out.
    Leased {
        /// The key of the job.
        #[serde(serialize_with = "as_text")]
        key: JobKey,
        /// The number of the worker that got it.
        worker: u32,
        /// The number of the attempt, counted from 1.
        attempt: u32,
        /// The predicted time of the job \[s\].
        #[serde(skip)]
        predicted: f64,
    },
    /// A result is durable.
    Done {
        /// The key of the job.
        #[serde(serialize_with = "as_text")]
        key: JobKey,
        /// The number of the worker that computed it.
        worker: u32,
        /// The time that the job took \[s\].
        #[serde(rename = "job_seconds")]
        seconds: f64,
        /// The number of attempts, including the successful one.
        attempts: u32,
    },
    /// An attempt failed, and the job goes back to the queue.
    Retried {
        /// The key of the job.
        #[serde(serialize_with = "as_text")]
        key: JobKey,
        /// The number of the attempt that failed, counted from 1.
        attempt: u32,
        /// The reason why it failed.
        reason: String,
    },
    /// A job goes back to the queue, and nothing counts against it.
    Returned {
        /// The key of the job.
        #[serde(serialize_with = "as_text")]
        key: JobKey,
        /// The reason why it was not finished.
        reason: String,
    },
    /// A job is left for another run, and nothing is recorded of it.
    Postponed {
        /// The key of the job.
        #[serde(serialize_with = "as_text")]
        key: JobKey,
        /// The predicted time of the job \[s\].
        #[serde(skip)]
        predicted: f64,
        /// The reason why this run cannot do it.
        reason: String,
    },
    /// A job is durably set aside.
    Quarantined {
        /// The key of the job.
        #[serde(serialize_with = "as_text")]
        key: JobKey,
        /// The reason why the last attempt failed.
        reason: String,
        /// The number of attempts.
        attempts: u32,
    },
    /// A group of results is durable.
    Committed {
        /// The number of results.
        jobs: usize,
    },
    /// Somebody asked to stop.
    Interrupted {
        /// It is true if it was asked twice; then workers are killed.
        now: bool,
    },
    /// The time of the run is up, or somebody asked for an end in time.
    TimeUp {
        /// It is true if the jobs in flight are given up; otherwise no further job is begun.
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
            r#"{{"seconds":1.5,"event":"retried","key":"{}","attempt":1,"reason":"signal 9","counts":{{"waiting":1,"running":0,"saving":0,"done":0,"quarantined":0,"postponed":0,"failures":1,"workers":0}}}}"#,
            "ab".repeat(32)
        );
        assert_eq!(serde_json::to_string(&event).unwrap(), expected);
    }
}
