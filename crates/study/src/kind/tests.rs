//! Tests of the columns of every kind of study.

use std::collections::HashSet;

use contact::assess::Errors;

use super::convergence::ERRORS;
use super::*;
use crate::columns::{Compared, Role, Row, along_path, find};
use crate::point::StudyPoint;
use crate::record::Record;
use crate::record::tests::{failed, quarantined, solved};
use crate::value::{Value, ValueType};

#[test]
fn names_are_identifiers_and_unique() {
    let of = |kind: &Kind| kind.columns([], Key::all(|_| 12));
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
        // An axis over a table hides no other column.
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
    let columns = Kind::Solve.columns([], far);
    let names: Vec<&str> = columns
        .iter()
        .filter(|column| column.role == Role::Key)
        .map(|column| column.name.as_ref())
        .collect();
    assert_eq!(
        names[..4],
        ["layer4000000000_thickness", "mu", "approach", "step4294967295_shift_x"]
    );
}

#[test]
fn every_figure_of_an_outcome_has_its_column() {
    let record = solved();
    let outcome = record.outcome().unwrap();
    let point = StudyPoint::of_record(&record).unwrap();
    let columns = along_path(Kind::Solve.columns([], []));
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
    let compared = Compared { errors, reference: String::new(), claim: None, noise: None };
    let row = Row {
        point: &StudyPoint::of_record(&record).unwrap(),
        record: Some(&record),
        compared: Some(&compared),
        account: None,
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
    let columns = along_path(Kind::Solve.columns([], []));
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
                .map(|name| find(&columns, name).unwrap().value(&point, Some(partial)).to_string())
                .join(" "),
        );
    });
    assert_eq!(rows, ["0 0 1 certified 0.5 0.25 0.25  7", "1 2 2 failed     29"]);
    let before = record.before_failure().unwrap();
    assert_eq!((before.outcome().unwrap().steps.len(), before.is_certified()), (1, true));
    assert_eq!((solved().before_failure(), quarantined().before_failure()), (None, None));
    let mut increments = 0;
    quarantined().along_path(|_| increments += 1);
    assert_eq!(increments, 0);
}

#[test]
fn a_result_that_is_not_certified_is_no_solution_in_any_column() {
    let columns = Kind::ALL.iter().flat_map(|kind| kind.columns([], []));
    for column in columns.filter(|column| column.role.is_of_solutions()) {
        for record in [failed(), quarantined()] {
            let point = StudyPoint::of_record(&record).unwrap();
            assert_eq!(column.value(&point, Some(&record)), Value::Missing, "{}", column.name);
        }
    }
    let (record, columns) = (failed(), Kind::Solve.columns([], []));
    let point = StudyPoint::of_record(&record).unwrap();
    let load = find(&columns, "load").unwrap().value_left(&point, &record);
    assert_eq!(load, Value::Number(1.0), "it can be looked at all the same");
}

#[test]
fn every_column_is_of_the_type_it_claims() {
    let record = solved();
    let point = StudyPoint::of_record(&record).unwrap();
    for column in Kind::Solve.columns([], []) {
        let kind = match column.value(&point, Some(&record)) {
            Value::Number(_) => ValueType::Number,
            Value::Integer(_) => ValueType::Integer,
            Value::Flag(_) => ValueType::Flag,
            Value::Text(_) => ValueType::Text,
            Value::Missing => continue,
        };
        assert_eq!(kind, column.values(), "{}", column.name);
    }
}

#[test]
fn what_is_not_there_is_missing() {
    let columns = Kind::Solve.columns([], [Key::Approach(0), Key::Mu, Key::PunchPoisson]);
    let value = |record: &Record, name: &str| {
        find(&columns, name).unwrap().value(&StudyPoint::of_record(record).unwrap(), Some(record))
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
fn a_run_is_told_by_its_account() {
    let (record, account) = (solved(), crate::account::tests::account());
    let point = StudyPoint::of_record(&record).unwrap();
    let columns = Kind::Solve.columns([], []);
    let values = |account: Option<&crate::RunAccount>| {
        let row = Row { point: &point, record: Some(&record), compared: None, account };
        ["run", "commit", "host", "processor"]
            .map(|name| find(&columns, name).unwrap().value_of(&row).to_string())
    };
    let known = ["090909090909", "0123456789ab-dirty", "node7", "A Processor"];
    assert_eq!(values(Some(&account)), known);
    assert_eq!(values(Some(&crate::RunAccount::default())), ["090909090909", "", "", ""]);
    assert_eq!(values(None), ["090909090909", "", "", ""]);
    // What a study chooses must not depend on the machine.
    let refused = ["commit", "host", "processor"]
        .map(|name| find(&columns, name).unwrap().unknown_in_choosing().is_some());
    assert_eq!(refused, [true; 3]);
}

#[test]
fn who_computed_a_record_is_told_of_runs_only() {
    let columns = Kind::Solve.columns([], []);
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
