//! Studies of what accuracy costs, which solve every point several times over and compare its error
//! with its time.
//!
//! ```toml
//! kind = "cost"               # every point is solved alone on the machine, by one worker, several
//!                             # times over
//!
//! [cost]                      # may be left out
//! on = "load"                 # the error that counts: load, tangential_force, approach,
//!                             # peak_pressure, contact_area, stick_area, and where the scene has a
//!                             # closed form pressure or traction, in L2; the load or the approach,
//!                             # whichever is not given
//! repeat = 5                  # times
//! threads = 1                 # threads of the worker
//!
//! [sweep]                     # the rungs: every axis of numerics
//! mesh = [8, 16, 32, 64]
//! tolerance = [1e-3, 1e-8]
//! ```
//!
//! Axes of the scene make ladders of their own. Errors are measured against the scene's closed
//! form, else against the limit to which the meshes with the tightest other settings extrapolate.

use super::convergence::ERRORS;
use super::solve;
use super::spec::{KindSpec, KindTable, TableSpec};
use crate::axis::{Group, SweepAxis};
use crate::bounds::{ANY, within};
use crate::columns::column::{Column, ColumnSource};
use crate::columns::result_columns::result_columns;
use crate::error::{Mistake, Span};
use crate::fallback::Fallback::{self, Follows};
use crate::figure::{self, Figure};
use crate::job::Job;
use crate::key::Key;
use crate::table_key::{KeyTable, TableValue, table_key};
use crate::value::Value;

/// The description of the kind.
pub(crate) const SPEC: KindSpec = KindSpec {
    name: "cost",
    table: Some(TableSpec {
        table: KeyTable {
            path: "cost",
            is_list: false,
            meaning: "the measurement of a study of kind \"cost\"",
            keys: &[
                table_key(
                    "on",
                    TableValue::Word(&ON),
                    ANY,
                    Follows("the load or the approach, whichever is not given"),
                    "\"peak_pressure\"",
                    "error that counts; pressure and traction need a closed form",
                ),
                table_key(
                    "repeat",
                    TableValue::Count,
                    within(1.0, 1000.0),
                    Fallback::Count(REPEAT),
                    "9",
                    "times that every point is solved",
                ),
                table_key(
                    "threads",
                    TableValue::Count,
                    within(1.0, 1024.0),
                    Fallback::Count(THREADS),
                    "2",
                    "threads of the worker",
                ),
            ],
        },
        check,
        advice: "",
    }),
    has_accuracy: false,
    assemble: |assembler, table| {
        let Cost { repeat, threads, .. } = Cost::of(table);
        Job::Cost { case: assembler.case(), repeat, threads }
    },
    to_toml,
    further_columns: &[ERRORS, CLAIM],
    usual_columns: &["seconds", "spread", "iterations", "status"],
    suggestions,
    ..solve::SPEC
};

/// The measurement that a study of cost makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cost {
    /// The error that counts, by the name that `[cost]` has for it; `None` stands for the load or
    /// the approach.
    pub on: Option<&'static str>,
    /// The number of times that every point is solved.
    pub repeat: u32,
    /// The number of threads of the worker.
    pub threads: u32,
}

/// The errors that can count.
pub(crate) const ON: [&str; 8] = [
    "load",
    "tangential_force",
    "approach",
    "peak_pressure",
    "contact_area",
    "stick_area",
    "pressure",
    "traction",
];

/// The number of repetitions if the study does not say.
const REPEAT: u32 = 5;

/// The number of threads if the study does not say.
const THREADS: u32 = 1;

/// Returns whether a group of axes makes rungs, which it does if one of its axes is a key of the
/// numerics.
pub fn is_rung(group: &Group) -> bool {
    let is_of_numerics =
        |axis: &SweepAxis| axis.key().is_some_and(|key| key.path().starts_with("numerics."));
    group.design().is_none() && group.axes().iter().any(is_of_numerics)
}

impl Cost {
    /// Returns what `[cost]` says, with the defaults of what it leaves out.
    pub(crate) fn of(table: &KindTable) -> Cost {
        Cost {
            on: table.word("on"),
            repeat: table.count("repeat").unwrap_or(REPEAT),
            threads: table.count("threads").unwrap_or(THREADS),
        }
    }
}

/// Refuses fewer than three meshes.
fn check(_: &KindTable, span: &Span, groups: &[Group], mistakes: &mut Vec<Mistake>) {
    let meshes = groups
        .iter()
        .flat_map(Group::axes)
        .find(|axis| axis.key() == Some(Key::Mesh))
        .map_or(0, SweepAxis::distinct);
    if meshes < 3 {
        mistakes.push(Mistake::new(
            span.clone(),
            "a study of cost needs at least three meshes",
            "needs for example mesh = [8, 16, 32, 64] below [sweep]",
        ));
    }
}

/// Writes the number of repetitions and of threads of a job.
fn to_toml(job: &Job) -> String {
    match job {
        Job::Cost { repeat, threads, .. } => {
            format!("cost.repeat = {repeat}\ncost.threads = {threads}\n")
        }
        _ => String::new(),
    }
}

/// Makes the figure of the claimed error over the time, with its front.
fn suggestions(_: &KindTable, groups: &[Group], _: &[Job]) -> Vec<Figure> {
    let is_mesh = |axis: &&SweepAxis| axis.key() == Some(Key::Mesh);
    let series = figure::telling(groups)
        .filter(|axis| !is_mesh(axis))
        .map(|axis| axis.column().into_owned())
        .collect();
    let figure = Figure::new("seconds".to_owned(), vec!["claimed_error".to_owned()]);
    let names = Some("mesh".to_owned());
    vec![Figure { series, front: true, names, log_x: true, log_y: true, ..figure }]
}

/// The columns that only studies of cost have.
pub(crate) const CLAIM: &[Column] = result_columns! {
    Error "claimed_error" ("error that finer rungs confirm") Pure
        "the error that counts, as rungs as fine or finer confirm it, with the reference's uncertainty"
        ColumnSource::Compared(|compared| compared.claim.map_or(Value::Missing, Value::Number));
    Error "noise" ("noise of the time") Pure
        "noise of the time on either side, relative: times that lie within it are ties"
        ColumnSource::Compared(|compared| compared.noise.map_or(Value::Missing, Value::Number));
};
