//! A column: its name, what it measures, and how its value is read from a row.

use std::borrow::Cow;

use contact::assess::Errors;
use contact::model::{Observables, Outcome, StepOutcome};

use crate::key::Key;
use crate::point::StudyPoint;
use crate::record::Record;
use crate::settings;
use crate::units::Dimension;
use crate::value::Value;

/// Where a column's values come from, which is also how tables group them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// An axis of the study.
    Axis,
    /// A key of the scene or the numerics that the study does not vary.
    Key,
    /// Whether and how the job ended.
    Status,
    /// Where on its loading path an increment stands; only tables of increments have it.
    Place,
    /// A quantity of the solution.
    Observable,
    /// A residual of the solution.
    Certificate,
    /// How far it is from what it is compared with.
    Error,
    /// What solving took, in deterministic counts.
    Work,
    /// Who computed it, when and how fast; differs from run to run.
    Provenance,
}

/// A column.
#[derive(Clone, Debug)]
pub struct Column {
    /// Its name, an identifier.
    pub name: Cow<'static, str>,
    /// What it measures; the values are in [`Dimension::unit`].
    pub dimension: Dimension,
    /// Where its values come from.
    pub role: Role,
    /// What it means, in words.
    pub meaning: &'static str,
    /// What it is called in pictures, if that is not the words of its name.
    pub(crate) label: Option<&'static str>,
    pub(crate) is_numeric: bool,
    pub(crate) source: ColumnSource,
}

/// What a row of a table is made of.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// The point.
    pub point: &'a StudyPoint,
    /// What its job left, if it left something yet.
    pub record: Option<&'a Record>,
    /// How far that is from what it is compared with.
    pub compared: Option<&'a Compared>,
}

/// How far a solution is from what it is compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// Relative errors.
    pub errors: Errors,
    /// What they are measured against, in words.
    pub reference: String,
    /// Of a study of cost, the relative error that can be relied on.
    pub claim: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum ColumnSource {
    Axis(usize),
    Key(Key),
    JobKey,
    Record(fn(&Record) -> Value),
    Outcome(fn(&Outcome) -> Value),
    End(fn(&StepOutcome) -> Value),
    Observed(fn(&Observables) -> Value),
    Compared(fn(&Compared) -> Value),
}

impl Column {
    /// Symbol of the SI unit of its values; empty for pure numbers and texts.
    pub fn unit(&self) -> &'static str {
        self.dimension.unit()
    }

    /// Its value for a point and the record that the point's job left, if it left one yet.
    pub fn value(&self, point: &StudyPoint, record: Option<&Record>) -> Value {
        self.value_of(&Row { point, record, compared: None })
    }

    /// Its value for a row.
    pub fn value_of(&self, Row { point, record, compared }: &Row<'_>) -> Value {
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
            ColumnSource::End(read) => end().map_or(Value::Missing, read),
            ColumnSource::Observed(read) => {
                end().map_or(Value::Missing, |end| read(&end.observables))
            }
            ColumnSource::Compared(read) => compared.map_or(Value::Missing, read),
        }
    }

    /// Why it has no values while a study still chooses its points; `None` if it has.
    pub fn unknown_in_choosing(&self) -> Option<String> {
        matches!(self.source, ColumnSource::Compared(_)).then(|| {
            format!(
                "`{}` is known only when the study's points are compared, after all of them are \
                 chosen",
                self.name
            )
        })
    }

    /// Whether its values are numbers, apart from missing ones.
    pub fn is_numeric(&self) -> bool {
        self.is_numeric
    }
}
