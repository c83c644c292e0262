//! The one list of columns. A name means the same in a study file's `[figure]`, in a query, in an
//! export and in a plot.
//!
//! A column is named by an identifier: for a key of the scene or the numerics the one that
//! [`Key::column`] gives, whatever else the study varies. An axis over a whole table has the
//! table's column and shows the labels.
//!
//! Results are those at the end of the loading path, except where a column's meaning says that it
//! is of the whole path. In a table of increments ([`along_path`], [`Record::along_path`]) each row
//! is what the result would be if the path ended there.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashSet};
use std::fmt;

use contact::assess::Errors;
use contact::model::{Mesh, Observables, Outcome, StepOutcome};
use contact::multiplicity::Multiplicity;

use crate::axis::Axis;
use crate::file::Point;
use crate::key::Key;
use crate::kind::Kind;
use crate::record::{Bracketed, Record};
use crate::settings;
use crate::sheet::Setting;
use crate::units::{Compact, Dimension};

mod results;

use results::{BRACKET, CLAIM, ENDING, ERRORS, PLACE, PROVENANCE, SEARCH, SOLUTION, TEXTS};

/// A cell of a table, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A whole number.
    Integer(u64),
    /// A text.
    Text(String),
    /// Nothing: the job has no such key, or it left no such figure.
    Missing,
}

impl Value {
    /// The number, whole or not; `None` for texts and where it is missing.
    pub fn as_f64(&self) -> Option<f64> {
        match self {
            Value::Number(x) => Some(*x),
            Value::Integer(n) => Some(*n as f64),
            Value::Text(_) | Value::Missing => None,
        }
    }
}

/// Numbers in their shortest exact form; nothing for what is missing.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Number(x) => write!(f, "{}", Compact(*x)),
            Value::Integer(n) => write!(f, "{n}"),
            Value::Text(text) => f.write_str(text),
            Value::Missing => Ok(()),
        }
    }
}

impl From<&Setting> for Value {
    fn from(setting: &Setting) -> Self {
        match setting {
            Setting::Number(x) => Value::Number(*x),
            Setting::Count(n) | Setting::Mesh(Mesh::Across(n)) => Value::Integer(u64::from(*n)),
            Setting::Mesh(Mesh::Exact([x, y])) => Value::Text(format!("{x}x{y}")),
            Setting::Word(word) => Value::Text(word.clone()),
            Setting::Effects(effects) if effects.is_empty() => Value::Missing,
            Setting::Effects(effects) => Value::Text(
                effects.iter().map(|effect| effect.name()).collect::<Vec<_>>().join(" "),
            ),
        }
    }
}

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
    source: Source,
}

/// What a row of a table is made of.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// The point.
    pub point: &'a Point,
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
enum Source {
    Axis { index: usize, is_numeric: bool },
    Key(Key),
    JobKey,
    Record(fn(&Record) -> Value),
    Outcome(fn(&Outcome) -> Value),
    End(fn(&StepOutcome) -> Value),
    Observed(fn(&Observables) -> Value),
    Multiplicity(fn(&Multiplicity) -> Value),
    Bracketed(fn(&Bracketed) -> Value),
    Error(fn(&Errors) -> Option<f64>),
    Claim,
    Reference,
}

impl Column {
    /// Symbol of the SI unit of its values; empty for pure numbers and texts.
    pub fn unit(&self) -> &'static str {
        self.dimension.unit()
    }

    /// Its value for a point and the record that the point's job left, if it left one yet.
    pub fn value(&self, point: &Point, record: Option<&Record>) -> Value {
        self.value_of(&Row { point, record, compared: None })
    }

    /// Its value for a row.
    pub fn value_of(&self, Row { point, record, compared }: &Row<'_>) -> Value {
        let record = *record;
        let end = || record.and_then(Record::outcome).and_then(Outcome::last);
        match self.source {
            Source::Axis { index, .. } => {
                point.values.get(index).cloned().unwrap_or(Value::Missing)
            }
            Source::Key(key) => settings::setting(&point.job, key)
                .map_or(Value::Missing, |setting| Value::from(&setting)),
            Source::JobKey => Value::Text(point.key.to_string()),
            Source::Record(read) => record.map_or(Value::Missing, read),
            Source::Outcome(read) => record.and_then(Record::outcome).map_or(Value::Missing, read),
            Source::End(read) => end().map_or(Value::Missing, read),
            Source::Observed(read) => end().map_or(Value::Missing, |end| read(&end.observables)),
            Source::Error(read) => compared
                .and_then(|compared| read(&compared.errors))
                .map_or(Value::Missing, Value::Number),
            Source::Claim => {
                compared.and_then(|compared| compared.claim).map_or(Value::Missing, Value::Number)
            }
            Source::Reference => {
                compared.map_or(Value::Missing, |compared| Value::Text(compared.reference.clone()))
            }
            Source::Bracketed(read) => {
                record.and_then(Record::bracketed).map_or(Value::Missing, read)
            }
            Source::Multiplicity(read) => {
                record.and_then(Record::multiplicity).map_or(Value::Missing, read)
            }
        }
    }

    /// Why it has no values while a study still chooses its points; `None` if it has.
    pub fn unknown_in_choosing(&self) -> Option<String> {
        let is_compared =
            matches!(self.source, Source::Error(_) | Source::Claim | Source::Reference);
        is_compared.then(|| format!("`{}` is known only when the study's points are compared, after all of them are chosen", self.name))
    }

    /// Whether its values are numbers, apart from missing ones.
    pub fn is_numeric(&self) -> bool {
        match self.source {
            Source::Key(key) => key.quantity().is_numeric(),
            Source::Axis { is_numeric, .. } => is_numeric,
            Source::JobKey | Source::Reference => false,
            Source::Error(_) | Source::Claim => true,
            Source::Record(_)
            | Source::Outcome(_)
            | Source::End(_)
            | Source::Observed(_)
            | Source::Multiplicity(_)
            | Source::Bracketed(_) => !TEXTS.contains(&self.name.as_ref()),
        }
    }
}

/// The columns of a study of this kind with these axes, in order: the axes, the other keys, then
/// what the records hold. Without axes and keys, the columns of any record. `keys` are those that
/// the study gives; those of the numerics, which have defaults, have columns anyway.
pub fn columns<'a>(
    kind: Kind,
    axes: impl IntoIterator<Item = &'a Axis>,
    keys: impl IntoIterator<Item = Key>,
) -> Vec<Column> {
    let mut columns: Vec<Column> = Vec::new();
    for (index, axis) in axes.into_iter().enumerate() {
        let (dimension, meaning) =
            axis.key().map_or((Dimension::Pure, "label of the table"), |key| {
                (key.dimension(), key.meaning())
            });
        let is_numeric = axis.key().is_some_and(|key| key.quantity().is_numeric());
        columns.push(Column {
            name: axis.column(),
            dimension,
            role: Role::Axis,
            meaning,
            source: Source::Axis { index, is_numeric },
        });
    }
    let listed: HashSet<Key> = keys.into_iter().collect();
    // not every index up to the largest, which may be any number
    let indices = |list| {
        listed
            .iter()
            .filter(|key| key.list() == Some(list))
            .filter_map(|key| key.index())
            .collect::<BTreeSet<u32>>()
    };
    for key in Key::of_entries(indices) {
        // a height map is given as a file, a job has its hash
        let is_given = listed.contains(&key) || key == Key::Surface && listed.contains(&Key::File);
        let has_default =
            ["numerics.", "search."].iter().any(|table| key.path().starts_with(table));
        let is_there = (is_given || has_default) && kind.refuses(key).is_none();
        let is_input = matches!(key, Key::File | Key::HeightUnit);
        if is_there && !is_input && !columns.iter().any(|column| column.name == key.column()) {
            let (name, dimension, meaning) = (key.column(), key.dimension(), key.meaning());
            columns.push(Column {
                name,
                dimension,
                role: Role::Key,
                meaning,
                source: Source::Key(key),
            });
        }
    }
    columns.extend_from_slice(ENDING);
    columns.extend_from_slice(match kind {
        Kind::Solve | Kind::Convergence | Kind::Cost => SOLUTION,
        Kind::Multiplicity => SEARCH,
        Kind::Uniqueness => BRACKET,
    });
    if matches!(kind, Kind::Convergence | Kind::Cost) {
        columns.extend_from_slice(ERRORS);
    }
    if kind == Kind::Cost {
        columns.extend_from_slice(CLAIM);
    }
    columns.extend_from_slice(PROVENANCE);
    columns
}

/// The columns of a table of increments, one row for each ([`Record::along_path`]): the axes, where
/// on the path it stands, and the rest.
pub fn along_path(columns: Vec<Column>) -> Vec<Column> {
    let (axes, mut rest): (Vec<Column>, Vec<Column>) =
        columns.into_iter().partition(|column| column.role == Role::Axis);
    // here a number of increments is the number of the increment
    rest.retain(|column| column.name != "increments");
    axes.into_iter().chain(PLACE.iter().cloned()).chain(rest).collect()
}

/// The column of this name, or of the key with this path, short or from the top.
pub fn find<'a>(columns: &'a [Column], name: &str) -> Option<&'a Column> {
    let of_path = Key::find(name).map(Key::column);
    columns
        .iter()
        .find(|column| column.name == name)
        .or_else(|| columns.iter().find(|column| Some(&column.name) == of_path.as_ref()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::{failed, quarantined, solved};

    #[test]
    fn names_are_identifiers_and_unique() {
        let of = |kind: &Kind| columns(*kind, [], Key::all(|_| 12));
        let paths = along_path(of(&Kind::Solve));
        for columns in Kind::ALL.iter().map(of).chain([paths]) {
            let mut seen = HashSet::new();
            for column in &columns {
                assert!(seen.insert(column.name.clone()), "{}", column.name);
                assert!(
                    column
                        .name
                        .chars()
                        .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_'),
                    "{}",
                    column.name
                );
            }
            // an axis over a table hides no other column
            for table in crate::key::Table::ALL {
                let key = Key::find(&table.path());
                assert!(
                    !seen.contains(&table.column())
                        || key.is_some_and(|key| key.column() == table.column()),
                    "{table:?}"
                );
            }
        }
    }

    #[test]
    fn entries_far_apart_cost_no_more_than_near_ones() {
        let far = [Key::Approach(0), Key::LayerThickness(4_000_000_000), Key::ShiftX(u32::MAX)];
        let columns = columns(Kind::Solve, [], far);
        let names: Vec<&str> = columns
            .iter()
            .filter(|column| column.role == Role::Key)
            .map(|column| column.name.as_ref())
            .collect();
        assert_eq!(names[..3], ["layer4000000000_thickness", "approach", "step4294967295_shift_x"]);
    }

    #[test]
    fn every_figure_of_an_outcome_has_its_column() {
        let record = solved();
        let outcome = record.outcome().unwrap();
        let point = Point::of_record(&record).unwrap();
        let columns = along_path(columns(Kind::Solve, [], []));
        let value = |name: &str| {
            let column = find(&columns, name).unwrap_or_else(|| panic!("no column {name}"));
            column.value(&point, Some(&record)).as_f64()
        };
        let end = serde_json::to_value(outcome.last().unwrap()).unwrap();
        for part in ["observables", "certificate"] {
            for (name, figure) in end[part].as_object().unwrap() {
                assert_eq!(value(name), figure.as_f64(), "{name}");
            }
        }
        for (name, figure) in end["motion"].as_object().unwrap() {
            assert_eq!(value(&format!("at_{name}")), figure.as_f64(), "{name}");
        }
        let estimate = outcome.estimate.unwrap();
        for (name, figure) in
            estimate.figures.named().into_iter().chain([("solver", Some(estimate.solver))])
        {
            assert_eq!(value(&format!("estimate_{name}")), figure, "{name}");
        }
        for (name, figure) in serde_json::to_value(outcome.work()).unwrap().as_object().unwrap() {
            assert_eq!(value(name), figure.as_f64(), "{name}");
        }
        let whole = serde_json::to_value(outcome).unwrap();
        for (name, figure) in whole["hertz"].as_object().unwrap() {
            assert_eq!(
                value(&format!("hertz_{}", name.trim_start_matches("semi_axis_"))),
                figure.as_f64(),
                "{name}"
            );
        }
        let names = [
            "track_x",
            "track_y",
            "track_z",
            "rail_y",
            "rail_z",
            "contact_angle",
            "track_pressure_x",
            "track_pressure_y",
            "track_pressure_z",
            "wheelset_height",
        ];
        assert_eq!(
            names.map(|name| value(name).unwrap()),
            [51.0, 52.0, 53.0, 54.0, 55.0, 56.0, 57.0, 58.0, 59.0, 60.0]
        );
        assert_eq!((value("step"), value("cycle")), (end["step"].as_f64(), end["cycle"].as_f64()));
    }

    #[test]
    fn every_error_has_its_column() {
        let record = solved();
        let figures = record.outcome().unwrap().estimate.unwrap().figures;
        let errors = Errors {
            figures,
            local: contact::assess::norms::Relative { pressure: Some(82.0), traction: Some(83.0) },
        };
        let compared = Compared { errors, reference: String::new(), claim: None };
        let row = Row {
            point: &Point::of_record(&record).unwrap(),
            record: Some(&record),
            compared: Some(&compared),
        };
        for (name, error) in errors.named() {
            assert_eq!(
                find(ERRORS, &format!("error_{name}")).unwrap().value_of(&row).as_f64(),
                error,
                "{name}"
            );
        }
    }

    #[test]
    fn an_increment_is_what_the_path_would_be_if_it_ended_there() {
        let record = failed();
        let point = Point::of_record(&record).unwrap();
        let columns = along_path(columns(Kind::Solve, [], []));
        let mut rows = Vec::new();
        record.along_path(|partial| {
            let names = [
                "step",
                "cycle",
                "increment",
                "status",
                "load",
                "dissipation",
                "total_dissipation",
                "cycle_dissipation",
                "iterations",
            ];
            rows.push(
                names
                    .map(|name| {
                        find(&columns, name).unwrap().value(&point, Some(partial)).to_string()
                    })
                    .join(" "),
            );
        });
        assert_eq!(rows, ["0 0 1 certified 0.5 0.25 0.25  7", "1 2 2 failed 1 15 15.25 15 29"]);
        let mut increments = 0;
        quarantined().along_path(|_| increments += 1);
        assert_eq!(increments, 0);
    }

    #[test]
    fn every_column_is_of_the_type_it_claims() {
        let record = solved();
        let point = Point::of_record(&record).unwrap();
        for column in columns(Kind::Solve, [], []) {
            let value = column.value(&point, Some(&record));
            if value != Value::Missing {
                assert_eq!(value.as_f64().is_some(), column.is_numeric(), "{}", column.name);
            }
        }
    }

    #[test]
    fn what_is_not_there_is_missing() {
        let columns = columns(Kind::Solve, [], [Key::Approach(0), Key::Mu, Key::PunchPoisson]);
        let value = |record: &Record, name: &str| {
            find(&columns, name).unwrap().value(&Point::of_record(record).unwrap(), Some(record))
        };
        assert_eq!(value(&quarantined(), "load"), Value::Missing);
        assert_eq!(value(&quarantined(), "status"), Value::Text("quarantined".into()));
        assert_eq!(value(&quarantined(), "reason"), Value::Text("killed by SIGKILL".into()));
        assert_eq!(value(&failed(), "status"), Value::Text("failed".into()));
        assert_eq!(value(&solved(), "reason"), Value::Missing);
        assert_eq!(value(&solved(), "friction.mu"), Value::Number(0.3));
        assert_eq!(value(&solved(), "punch_poisson"), Value::Missing);
        assert_eq!(value(&solved(), "stick_fraction"), Value::Number(0.25));
        assert_eq!(value(&solved(), "loading.steps[0].approach"), Value::Number(2e-5));
        assert_eq!(
            (value(&solved(), "contact_x"), value(&solved(), "contact_y")),
            (Value::Number(-5.0), Value::Number(4.0))
        );
        assert_eq!(
            (value(&solved(), "separated_area"), value(&solved(), "separated_fraction")),
            (Value::Number(2.0), Value::Number(0.2))
        );
        assert!(find(&columns, "colour").is_none());
    }

    #[test]
    fn who_computed_a_record_is_told_of_runs_only() {
        let columns = columns(Kind::Solve, [], []);
        let values = |record: &Record| {
            let point = Point::of_record(record).unwrap();
            ["attempt", "worker", "finished"]
                .map(|name| find(&columns, name).unwrap().value(&point, Some(record)).to_string())
        };
        assert_eq!(values(&solved()), ["1", "1", "2023-11-14T22:13:20Z"]);
        let mut alone = solved();
        (alone.provenance.attempt, alone.provenance.worker, alone.provenance.finished) = (0, 0, 0);
        assert_eq!(values(&alone), ["", "", ""]);
        alone.provenance.finished = u64::MAX;
        assert_eq!(values(&alone)[2], "9999-12-31T23:59:59Z", "whatever a damaged record says");
    }
}
