//! The columns that every record has, and those that give the place of an increment on its path.

use std::time::{Duration, SystemTime};

use contact::model::Outcome;

use super::column::{Column, ColumnSource};
use super::result_columns::{integer, result_columns};
use crate::account::run_name;
use crate::record::Record;
use crate::value::Value;

/// The columns that only tables of increments have.
pub(crate) const PLACE: &[Column] = result_columns! {
    Place "step" ("load step") Count "index of the load step" integer!(step);
    Place "cycle" Count "which time the cycle is run through, counted from 1; 0 outside of one"
        integer!(cycle);
    Place "increment" Count "number of the increment along the path, counted from 1"
        ColumnSource::Outcome(increments);
};

/// The columns with which the results of every record begin.
pub(crate) const ENDING: &[Column] = result_columns! {
    Status "key" Text "identity of the job" ColumnSource::JobKey;
    Status "status" Text "certified, failed or quarantined"
        ColumnSource::Record(|record| Value::Text(record.standing().to_string()));
    Status "reason" Text "why it failed" ColumnSource::Record(reason);
};

/// The columns with which the results of every record end.
pub(crate) const PROVENANCE: &[Column] = result_columns! {
    Provenance "seconds" ("solving time") Time
        "time that solving took; of several times, the median"
        ColumnSource::Record(|record| Value::Number(record.provenance.seconds));
    Provenance "spread" Pure
        "of a job that is solved several times, the range of its times over their median"
        ColumnSource::Record(spread);
    Provenance "attempt" Count "attempt that succeeded, counted from 1"
        ColumnSource::Record(|record| of_run(record, record.provenance.attempt));
    Provenance "worker" Count "worker that computed it"
        ColumnSource::Record(|record| of_run(record, record.provenance.worker));
    Provenance "finished" ("time of finishing") Text "when it was finished, UTC"
        ColumnSource::Record(finished);
    Provenance "program" Text "version of the program"
        ColumnSource::Record(|record| Value::Text(record.provenance.program.clone()));
    Provenance "run" Text "run that computed it, by the first digits of its account's digest"
        ColumnSource::Record(|record| record.provenance.run.as_ref()
            .map_or(Value::Missing, |digest| Value::Text(run_name(digest))));
    Provenance "commit" Text
        "commit of the program's source, with -dirty if the source differed from it"
        ColumnSource::Account(|account| given(account.program.short_commit().as_deref()));
    Provenance "host" Text "host on which it was computed"
        ColumnSource::Account(|account| given(Some(&account.machine.host)));
    Provenance "processor" Text "model of that host's processor"
        ColumnSource::Account(|account| given(Some(&account.machine.processor)));
};

/// Returns a text that may not be known.
fn given(text: Option<&str>) -> Value {
    match text {
        None | Some("") => Value::Missing,
        Some(text) => Value::Text(text.to_owned()),
    }
}

/// Returns a count that only jobs of a run have.
fn of_run(record: &Record, count: u32) -> Value {
    if record.provenance.attempt == 0 { Value::Missing } else { Value::Integer(u64::from(count)) }
}

fn finished(record: &Record) -> Value {
    // The last second of the year 9999 is the last that can be written.
    let seconds = record.provenance.finished.min(253_402_300_799);
    let time =
        SystemTime::UNIX_EPOCH.checked_add(Duration::from_secs(seconds)).filter(|_| seconds > 0);
    time.map_or(Value::Missing, |time| {
        Value::Text(humantime::format_rfc3339_seconds(time).to_string())
    })
}

fn spread(record: &Record) -> Value {
    let times = &record.provenance.times;
    let extreme = |of: fn(f64, f64) -> f64| times.iter().copied().reduce(of);
    match (extreme(f64::min), extreme(f64::max)) {
        (Some(least), Some(most)) if record.provenance.seconds > 0.0 => {
            Value::Number((most - least) / record.provenance.seconds)
        }
        _ => Value::Missing,
    }
}

fn reason(record: &Record) -> Value {
    record.ending.reason().map_or(Value::Missing, |reason| Value::Text(reason.to_owned()))
}

pub(crate) fn increments(outcome: &Outcome) -> Value {
    Value::Integer(outcome.steps.len() as u64)
}
