//! A column: its name, what it measures, and the way in which its value is read from a row.

use std::borrow::Cow;

use contact::assess::Errors;
use contact::model::{Observables, Outcome, StepOutcome};
use contact::uniqueness::branch::Branch;

use crate::account::RunAccount;
use crate::job::{Case, Job};
use crate::key::Key;
use crate::point::StudyPoint;
use crate::record::{Branched, Record};
use crate::settings;
use crate::units::Dimension;
use crate::value::{Value, ValueType};

/// The origin of a column's values, by which tables group their columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// An axis of the study.
    Axis,
    /// A key of the scene or the numerics that the study does not vary.
    Key,
    /// The way in which the job ended.
    Status,
    /// The place of an increment on its loading path; only tables of increments have it.
    Place,
    /// A quantity of the solution.
    Observable,
    /// A residual of the solution.
    Certificate,
    /// The distance of the result from what it is compared with.
    Error,
    /// The work that solving took, in deterministic counts.
    Work,
    /// The worker, the time and the speed of the computation, which differ from run to run.
    Provenance,
}

impl Role {
    /// Returns the word by which tables of columns call it.
    pub fn name(self) -> &'static str {
        match self {
            Role::Axis => "axis",
            Role::Key => "key",
            Role::Status => "status",
            Role::Place => "place",
            Role::Observable => "observable",
            Role::Certificate => "certificate",
            Role::Error => "error",
            Role::Work => "work",
            Role::Provenance => "provenance",
        }
    }

    /// Returns whether the column tells of a solution, so that it is empty where there is none.
    pub fn is_of_solutions(self) -> bool {
        match self {
            Role::Observable | Role::Certificate | Role::Error => true,
            Role::Axis | Role::Key | Role::Status | Role::Place | Role::Work | Role::Provenance => {
                false
            }
        }
    }
}

/// A column.
#[derive(Clone, Debug)]
pub struct Column {
    /// The name, an identifier.
    pub name: Cow<'static, str>,
    /// The dimension; the values are in [`Dimension::unit`].
    pub dimension: Dimension,
    /// The origin of the values.
    pub role: Role,
    /// The meaning, in words.
    pub meaning: &'static str,
    /// The name in pictures, if that is not made of the words of `name`.
    pub(crate) label: Option<&'static str>,
    pub(crate) values: ValueType,
    pub(crate) source: ColumnSource,
}

/// The input from which a row of a table is made.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// The point.
    pub point: &'a StudyPoint,
    /// The record that the point's job left, if it left one yet.
    pub record: Option<&'a Record>,
    /// The comparison of the record, if there is one.
    pub compared: Option<&'a Compared>,
    /// The account of the run that computed the record, if it is known.
    pub account: Option<&'a RunAccount>,
}

/// The distance of a solution from what it is compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// The relative errors.
    pub errors: Errors,
    /// The reference of the errors, in words.
    pub reference: String,
    /// The relative error that can be relied on, in a study of cost.
    pub claim: Option<f64>,
    /// The noise of the time on either side, relative to the time, in a study of cost: times that
    /// lie within it are ties.
    pub noise: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum ColumnSource {
    Axis(usize),
    Key(Key),
    JobKey,
    Record(fn(&Record) -> Value),
    Outcome(fn(&Outcome) -> Value),
    Solved(fn(&Case, &Outcome) -> Value),
    End(fn(&StepOutcome) -> Value),
    Observed(fn(&Observables) -> Value),
    Branch(fn(&Branch, &Branched) -> Value),
    Compared(fn(&Compared) -> Value),
    Account(fn(&RunAccount) -> Value),
}

impl Column {
    /// Returns the symbol of the SI unit of its values; empty for pure numbers and texts.
    pub fn unit(&self) -> &'static str {
        self.dimension.unit()
    }

    /// Returns its value for a point and the record that the point's job left, if it left one yet.
    pub fn value(&self, point: &StudyPoint, record: Option<&Record>) -> Value {
        self.value_of(&Row { point, record, compared: None, account: None })
    }

    /// Returns its value for a row. A column that tells of solutions is empty where the result is
    /// not certified: the figures of the last iterate belong to no solution at the row's
    /// parameters.
    pub fn value_of(&self, row: &Row<'_>) -> Value {
        let is_solved = row.record.is_some_and(Record::is_certified);
        if self.role.is_of_solutions() && !is_solved { Value::Missing } else { self.left_in(row) }
    }

    /// Returns its value for a record as the job left it, solution or not: where a job has failed,
    /// that of the last iterate.
    pub fn value_left(&self, point: &StudyPoint, record: &Record) -> Value {
        self.left_in(&Row { point, record: Some(record), compared: None, account: None })
    }

    fn left_in(&self, Row { point, record, compared, account }: &Row<'_>) -> Value {
        let record = *record;
        let end = || record.and_then(Record::outcome).and_then(Outcome::last);
        match self.source {
            ColumnSource::Axis(index) => point.values.get(index).cloned().unwrap_or(Value::Missing),
            ColumnSource::Key(key) => settings::setting(&point.job, key)
                .map_or(Value::Missing, |setting| Value::from(&setting)),
            ColumnSource::JobKey => Value::Text(point.key.to_string()),
            ColumnSource::Record(read) => record.map_or(Value::Missing, read),
            ColumnSource::Outcome(read) => {
                record.and_then(Record::outcome).map_or(Value::Missing, read)
            }
            ColumnSource::Solved(read) => {
                match (point.job.case(), record.and_then(Record::outcome)) {
                    (Some(case), Some(outcome)) => read(case, outcome),
                    _ => Value::Missing,
                }
            }
            ColumnSource::Branch(read) => match (&point.job, record.and_then(Record::branched)) {
                (Job::Branch { branch, .. }, Some(found)) => read(branch, found),
                _ => Value::Missing,
            },
            ColumnSource::End(read) => end().map_or(Value::Missing, read),
            ColumnSource::Observed(read) => {
                end().map_or(Value::Missing, |end| read(&end.observables))
            }
            ColumnSource::Compared(read) => compared.map_or(Value::Missing, read),
            ColumnSource::Account(read) => account.map_or(Value::Missing, read),
        }
    }

    /// Returns whether its values come from comparing the points of a study.
    pub fn is_compared(&self) -> bool {
        matches!(self.source, ColumnSource::Compared(_))
    }

    /// Returns whether its values come from the account of the run that computed a result.
    pub fn is_of_account(&self) -> bool {
        matches!(self.source, ColumnSource::Account(_))
    }

    /// Returns the value of a column [of accounts](Column::is_of_account) for results that a run
    /// with this account computed.
    pub fn value_of_account(&self, account: Option<&RunAccount>) -> Value {
        match (self.source, account) {
            (ColumnSource::Account(read), Some(account)) => read(account),
            _ => Value::Missing,
        }
    }

    /// Tells why it has no values while a study still chooses its points; `None` if it has.
    pub fn unknown_in_choosing(&self) -> Option<String> {
        let name = &self.name;
        match self.source {
            ColumnSource::Compared(_) => Some(format!(
                "`{name}` is known only when the study's points are compared, after all of them \
                 are chosen"
            )),
            ColumnSource::Account(_) => Some(format!(
                "`{name}` says by whom a result was computed, and what a study chooses follows \
                 from its results alone"
            )),
            _ => None,
        }
    }

    /// Returns whether its values are numbers, apart from missing ones.
    pub fn is_numeric(&self) -> bool {
        matches!(self.values, ValueType::Number | ValueType::Integer)
    }

    /// Returns the kind of its values. A mesh is a whole number, or a text where it is a pair.
    pub fn values(&self) -> ValueType {
        self.values
    }
}
