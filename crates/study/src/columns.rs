//! The one list of columns. A name means the same in a study file's `[figure]`, in a query, in an export and in a plot.
//!
//! A column is named by an identifier: for a key of the scene or the numerics the one that [`Key::column`] gives,
//! whatever else the study varies. An axis over a whole table has the table's column and shows the labels.

use std::fmt;

use contact::outcome::{Outcome, Status};
use contact::scene::Mesh;

use crate::axis::Axis;
use crate::file::Point;
use crate::key::{Key, Quantity};
use crate::record::{Ending, Record};
use crate::sheet::{self, Setting};
use crate::units::{Compact, Dimension};

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
        }
    }
}

/// Where a column's values come from, which is also how tables group them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// An axis of the study.
    Axis,
    /// A key of the scene or the numerics that the study does not vary.
    Key,
    /// Whether and how the job ended.
    Status,
    /// A quantity of the solution.
    Observable,
    /// A residual of the solution.
    Certificate,
    /// What solving took, in deterministic counts.
    Work,
    /// Who computed it, when and how fast; differs from run to run.
    Provenance,
}

/// A column.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Its name, an identifier.
    pub name: &'static str,
    /// What it measures; the values are in [`Dimension::unit`].
    pub dimension: Dimension,
    /// Where its values come from.
    pub kind: Kind,
    /// What it means, in words.
    pub meaning: &'static str,
    source: Source,
}

#[derive(Clone, Copy, Debug)]
enum Source {
    Axis(usize),
    Key(Key),
    JobKey,
    Record(fn(&Record) -> Value),
    Outcome(fn(&Outcome) -> Value),
}

impl Column {
    /// Symbol of the SI unit of its values; empty for pure numbers and texts.
    pub fn unit(&self) -> &'static str {
        self.dimension.unit()
    }

    /// Its value for a point and the record that the point's job left, if it left one yet.
    pub fn value(&self, point: &Point, record: Option<&Record>) -> Value {
        match self.source {
            Source::Axis(index) => point.values.get(index).cloned().unwrap_or(Value::Missing),
            Source::Key(key) => sheet::setting(&point.job, key).map_or(Value::Missing, |setting| Value::from(&setting)),
            Source::JobKey => Value::Text(point.key.to_string()),
            Source::Record(read) => record.map_or(Value::Missing, read),
            Source::Outcome(read) => match record.map(|record| &record.ending) {
                Some(Ending::Finished(outcome)) => read(outcome),
                Some(Ending::Quarantined { .. }) | None => Value::Missing,
            },
        }
    }

    /// Whether its values are numbers, apart from missing ones.
    pub fn is_numeric(&self) -> bool {
        match self.source {
            Source::Key(key) => matches!(key.quantity(), Quantity::Number(_) | Quantity::Count | Quantity::Mesh),
            Source::Axis(_) => Key::ALL
                .iter()
                .any(|key| key.column() == self.name && matches!(key.quantity(), Quantity::Number(_) | Quantity::Count | Quantity::Mesh)),
            Source::JobKey => false,
            Source::Record(_) | Source::Outcome(_) => !TEXTS.contains(&self.name),
        }
    }
}

/// The columns of a study with these axes, in order: the axes, the other keys, then what the records hold.
/// Without axes, the columns of any record.
pub fn columns<'a>(axes: impl IntoIterator<Item = &'a Axis>) -> Vec<Column> {
    let mut columns = Vec::new();
    for (index, axis) in axes.into_iter().enumerate() {
        let meaning = Key::find(axis.path()).map_or("label of the table", Key::meaning);
        let (name, dimension) = (axis.column(), axis.dimension());
        columns.push(Column { name, dimension, kind: Kind::Axis, meaning, source: Source::Axis(index) });
    }
    for key in Key::ALL.iter().filter(|key| !matches!(key, Key::File | Key::HeightUnit)) {
        if !columns.iter().any(|column| column.name == key.column()) {
            let dimension = match key.quantity() {
                Quantity::Number(dimension) => dimension,
                _ => Dimension::Pure,
            };
            columns.push(Column { name: key.column(), dimension, kind: Kind::Key, meaning: key.meaning(), source: Source::Key(*key) });
        }
    }
    columns.extend_from_slice(RESULTS);
    columns
}

/// The column of this name, or of the key with this path, short or from the top.
pub fn find<'a>(columns: &'a [Column], name: &str) -> Option<&'a Column> {
    let of_path = Key::find(name).map(Key::column);
    columns.iter().find(|column| column.name == name).or_else(|| columns.iter().find(|column| Some(column.name) == of_path))
}

/// The columns of [`RESULTS`] whose values are texts.
const TEXTS: &[&str] = &["status", "reason", "program"];

macro_rules! results {
    ($($kind:ident $name:literal $dimension:ident $meaning:literal $source:expr;)*) => {
        /// The columns that every record has.
        const RESULTS: &[Column] = &[
            Column { name: "key", dimension: Dimension::Pure, kind: Kind::Status, meaning: "identity of the job", source: Source::JobKey },
            $(Column { name: $name, dimension: Dimension::$dimension, kind: Kind::$kind, meaning: $meaning, source: $source },)*
        ];
    };
}

const fn outcome(read: fn(&Outcome) -> Value) -> Source {
    Source::Outcome(read)
}

macro_rules! number {
    ($part:ident . $field:ident) => {
        outcome(|outcome| Value::Number(outcome.$part.$field))
    };
}

macro_rules! integer {
    ($part:ident . $field:ident) => {
        outcome(|outcome| Value::Integer(outcome.$part.$field))
    };
}

results! {
    Status "status" Pure "certified, failed or quarantined" Source::Record(|record| Value::Text(record.status().to_owned()));
    Status "reason" Pure "why it failed" Source::Record(reason);
    Observable "load" Force "normal force" number!(observables.load);
    Observable "force_x" Force "tangential force along x" number!(observables.force_x);
    Observable "force_y" Force "tangential force along y" number!(observables.force_y);
    Observable "moment_x" Moment "moment about x" number!(observables.moment_x);
    Observable "moment_y" Moment "moment about y" number!(observables.moment_y);
    Observable "moment_z" Moment "moment about z" number!(observables.moment_z);
    Observable "contact_area" Area "area in contact" number!(observables.contact_area);
    Observable "stick_area" Area "area in contact that sticks" number!(observables.stick_area);
    Observable "slip_area" Area "area in contact that slips" number!(observables.slip_area);
    Observable "stick_fraction" Pure "stick area over contact area" outcome(stick_fraction);
    Observable "contact_radius" Length "radius of the disk of the contact area" outcome(contact_radius);
    Observable "contact_elements" Pure "elements in contact" integer!(observables.contact_elements);
    Observable "stick_elements" Pure "elements that stick" integer!(observables.stick_elements);
    Observable "slip_elements" Pure "elements that slip" integer!(observables.slip_elements);
    Observable "peak_pressure" Pressure "largest pressure" number!(observables.peak_pressure);
    Observable "peak_traction" Pressure "largest tangential traction" number!(observables.peak_traction);
    Observable "energy" Energy "elastic energy" number!(observables.energy);
    Observable "dissipation" Energy "energy lost to friction" number!(observables.dissipation);
    Observable "ceiling_elements" Pure "elements at the pressure ceiling" integer!(observables.ceiling_elements);
    Observable "edge_elements" Pure "elements in contact at the edge of Ω; above 0, Ω is too small" integer!(observables.edge_elements);
    Observable "mesh_x" Pure "elements along x" integer!(observables.mesh_x);
    Observable "mesh_y" Pure "elements along y" integer!(observables.mesh_y);
    Observable "element_x" Length "element size along x" number!(observables.element_x);
    Observable "element_y" Length "element size along y" number!(observables.element_y);
    Certificate "residual" Pure "relative natural-map residual" number!(certificate.residual);
    Certificate "tension" Pure "largest tension over the largest pressure" number!(certificate.tension);
    Certificate "penetration" Pure "largest penetration over the largest displacement" number!(certificate.penetration);
    Certificate "gap_under_pressure" Pure "largest gap under pressure, relative" number!(certificate.gap_under_pressure);
    Certificate "cone_violation" Pure "largest excess of traction over friction, relative" number!(certificate.cone_violation);
    Certificate "slip_angle" Angle "largest angle between slip and opposite traction" number!(certificate.slip_angle);
    Certificate "force_imbalance" Pure "imbalance of forces over the load" number!(certificate.force_imbalance);
    Work "iterations" Pure "iterations of the solver" integer!(work.iterations);
    Work "operator_applications" Pure "applications of the operator" integer!(work.operator_applications);
    Provenance "seconds" Time "time that solving took" Source::Record(|record| Value::Number(record.provenance.seconds));
    Provenance "attempt" Pure "attempt that succeeded, counted from 1" Source::Record(|record| Value::Integer(u64::from(record.provenance.attempt)));
    Provenance "worker" Pure "worker that computed it" Source::Record(|record| Value::Integer(u64::from(record.provenance.worker)));
    Provenance "finished" Time "when it was finished, since 1970-01-01 UTC" Source::Record(|record| Value::Integer(record.provenance.finished));
    Provenance "program" Pure "version of the program" Source::Record(|record| Value::Text(record.provenance.program.clone()));
}

fn reason(record: &Record) -> Value {
    match &record.ending {
        Ending::Finished(Outcome { status: Status::Certified, .. }) => Value::Missing,
        Ending::Finished(Outcome { status: Status::Failed { reason }, .. }) | Ending::Quarantined { reason, .. } => {
            Value::Text(reason.clone())
        }
    }
}

fn stick_fraction(outcome: &Outcome) -> Value {
    let observables = &outcome.observables;
    if observables.contact_area > 0.0 { Value::Number(observables.stick_area / observables.contact_area) } else { Value::Missing }
}

fn contact_radius(outcome: &Outcome) -> Value {
    Value::Number((outcome.observables.contact_area / std::f64::consts::PI).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::{failed, quarantined, solved};

    #[test]
    fn names_are_identifiers_and_unique() {
        let mut seen = std::collections::HashSet::new();
        for column in columns([]) {
            assert!(seen.insert(column.name), "{}", column.name);
            assert!(column.name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_'), "{}", column.name);
        }
        assert!(crate::key::TABLES.iter().all(|table| seen.insert(table.column)));
    }

    #[test]
    fn every_figure_of_an_outcome_has_its_column() {
        let record = solved();
        let Ending::Finished(outcome) = &record.ending else { panic!("solved") };
        let point = Point::of_record(&record).unwrap();
        let columns = columns([]);
        for part in ["observables", "certificate", "work"] {
            let figures = serde_json::to_value(outcome).unwrap()[part].clone();
            for (name, figure) in figures.as_object().unwrap() {
                let column = find(&columns, name).unwrap_or_else(|| panic!("no column {name}"));
                assert_eq!(column.value(&point, Some(&record)).as_f64(), figure.as_f64(), "{name}");
            }
        }
    }

    #[test]
    fn every_column_is_of_the_type_it_claims() {
        let record = solved();
        let point = Point::of_record(&record).unwrap();
        for column in columns([]) {
            let value = column.value(&point, Some(&record));
            if value != Value::Missing {
                assert_eq!(value.as_f64().is_some(), column.is_numeric(), "{}", column.name);
            }
        }
    }

    #[test]
    fn what_is_not_there_is_missing() {
        let columns = columns([]);
        let value = |record: &Record, name: &str| find(&columns, name).unwrap().value(&Point::of_record(record).unwrap(), Some(record));
        assert_eq!(value(&quarantined(), "load"), Value::Missing);
        assert_eq!(value(&quarantined(), "status"), Value::Text("quarantined".into()));
        assert_eq!(value(&quarantined(), "reason"), Value::Text("killed by SIGKILL".into()));
        assert_eq!(value(&failed(), "status"), Value::Text("failed".into()));
        assert_eq!(value(&solved(), "reason"), Value::Missing);
        assert_eq!(value(&solved(), "friction.mu"), Value::Number(0.3));
        assert_eq!(value(&solved(), "punch_poisson"), Value::Missing);
        assert_eq!(value(&solved(), "stick_fraction"), Value::Number(0.25));
        assert!(find(&columns, "colour").is_none());
    }
}
