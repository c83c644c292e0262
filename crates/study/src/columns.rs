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

use std::collections::{BTreeSet, HashSet};

use crate::axis::SweepAxis;
use crate::key::Key;
use crate::kind::Kind;
use crate::units::Dimension;

mod column;
mod results;

use column::Source;
pub use column::{Column, Compared, Role, Row};
use results::{BRACKET, CLAIM, ENDING, ERRORS, PLACE, PROVENANCE, SEARCH, SOLUTION};

/// The columns of a study of this kind with these axes, in order: the axes, the other keys, then
/// what the records hold. Without axes and keys, the columns of any record. `keys` are those that
/// the study gives; those of the numerics, which have defaults, have columns anyway.
pub fn columns<'a>(
    kind: Kind,
    axes: impl IntoIterator<Item = &'a SweepAxis>,
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
            is_text: false,
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
                is_text: false,
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
    use contact::reference::Errors;

    use super::*;
    use crate::point::StudyPoint;
    use crate::record::Record;
    use crate::record::tests::{failed, quarantined, solved};
    use crate::value::Value;

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
        let point = StudyPoint::of_record(&record).unwrap();
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
            local: contact::norms::Relative { pressure: Some(82.0), traction: Some(83.0) },
        };
        let compared = Compared { errors, reference: String::new(), claim: None };
        let row = Row {
            point: &StudyPoint::of_record(&record).unwrap(),
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
        let point = StudyPoint::of_record(&record).unwrap();
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
        let point = StudyPoint::of_record(&record).unwrap();
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
            find(&columns, name)
                .unwrap()
                .value(&StudyPoint::of_record(record).unwrap(), Some(record))
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
            let point = StudyPoint::of_record(record).unwrap();
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
