//! Studies that search every point for all of its solutions.

use contact::model::Observables;
use contact::multiplicity::{Multiplicity, Search, Solution};

use super::solve;
use super::spec::{KindSpec, KindTable};
use crate::assemble::Assembler;
use crate::axis::Group;
use crate::columns::column::{Column, ColumnSource};
use crate::columns::result_columns::result_columns;
use crate::figure::Figure;
use crate::job::Job;
use crate::key::Key;
use crate::value::Value;

/// The description of the kind.
pub(crate) const SPEC: KindSpec = KindSpec {
    name: "multiplicity",
    has_accuracy: false,
    refuses,
    assemble: |assembler, _| Job::Multiplicity {
        case: assembler.case(),
        search: search(assembler),
    },
    columns: &[SEARCH],
    usual_columns: &["solutions", "index_sum", "largest_distance", "status"],
    suggestions,
    ..solve::SPEC
};

/// Tells why a search has no use for a key; `None` if it has.
fn refuses(key: Key) -> Option<&'static str> {
    match key {
        Key::Simulate => Some("a search simulates every effect"),
        _ if key.is_of_interior() => {
            Some("a search for every solution looks at no stresses below the surface")
        }
        Key::Cases | Key::Width => {
            Some("cases and widths are of searches for the end of a uniqueness set")
        }
        Key::Plane => Some("a search for every solution has tractions in all directions"),
        Key::Method => Some("a search tries every method"),
        _ if key.is_of_rolling() => Some("a search knows no step that rolls"),
        Key::Speed | Key::AngularSpeed | Key::LateralVelocity | Key::YawRate | Key::RollRate => {
            Some("a search knows no step that rolls, and so no wheelset that moves")
        }
        _ if key.is_of_wear() => {
            Some("a search looks for solutions of one shape, and counts none of its wear")
        }
        _ => None,
    }
}

/// Returns the extent of the search.
fn search(assembler: &Assembler<'_>) -> Search {
    let default = Search::default();
    Search {
        starts: assembler.sheet().count(Key::Starts).unwrap_or(default.starts),
        seed: assembler.sheet().count(Key::Seed).map_or(default.seed, u64::from),
    }
}

/// Makes a figure of the number of solutions over each axis, first over those of a sample.
fn suggestions(_: &KindTable, groups: &[Group], _: &[Job]) -> Vec<Figure> {
    let of_axis = |over: Figure| Figure { y: vec!["solutions".to_owned()], ..over };
    let over = Figure::over_drawn(groups).into_iter().chain(Figure::over_axes(groups));
    over.map(of_axis).collect()
}

/// Reads a value from the result of a search.
macro_rules! searched {
    (|$found:ident| $value:expr) => {
        ColumnSource::Record(|record| record.multiplicity().map_or(Value::Missing, |$found| $value))
    };
}

/// The columns of searches for every solution.
pub(crate) const SEARCH: &[Column] = result_columns! {
    Observable "solutions" Count "distinct certified solutions that were found"
        searched!(|found| Value::Integer(found.solutions.len() as u64));
    Observable "index_sum" Pure
        "sum of the solutions' indices; anything but 1 says that one was missed"
        searched!(|found| found.index_sum.map_or(Value::Missing, |sum| Value::Number(sum as f64)));
    Observable "largest_distance" Pure "largest relative L2 distance between two solutions"
        searched!(|found| found.furthest().map_or(Value::Missing, |[i, j]| {
            Value::Number(found.solutions[i].distances[j])
        }));
    Observable "smallest_load" Force "smallest normal force among the solutions"
        searched!(|found| extreme(found, |o| o.load, f64::min));
    Observable "largest_load" Force "largest normal force among the solutions"
        searched!(|found| extreme(found, |o| o.load, f64::max));
    Observable "smallest_stick_area" Area "smallest stick area among the solutions"
        searched!(|found| extreme(found, |o| o.stick_area, f64::min));
    Observable "largest_stick_area" Area "largest stick area among the solutions"
        searched!(|found| extreme(found, |o| o.stick_area, f64::max));
    Certificate "residual" Pure "largest relative natural-map residual of a solution"
        searched!(|found| largest(found, |solution| solution.certificate.residual));
    Certificate "error" Pure
        "largest distance of a solution from the exact one, relative, to first order"
        searched!(|found| largest(found, |solution| solution.error));
    Work "tried" Count "starts tried, one for each method"
        searched!(|found| Value::Integer(found.starts));
    Work "failed_starts" Count "starts that led to no certified solution"
        searched!(|found| Value::Integer(found.failed));
    Work "beyond" Count "starts that led to solutions beyond the ones kept"
        searched!(|found| Value::Integer(found.beyond));
    Work "iterations" Count "iterations of all solvers"
        searched!(|found| Value::Integer(found.work.iterations));
    Work "operator_applications" Count "applications of the operator by all solvers"
        searched!(|found| Value::Integer(found.work.operator_applications));
    Work "factorisations" Count "dense matrices factored"
        searched!(|found| Value::Integer(found.factorisations));
};

/// Returns the smallest or the largest value of a quantity among the solutions.
fn extreme(found: &Multiplicity, read: fn(&Observables) -> f64, of: fn(f64, f64) -> f64) -> Value {
    found
        .solutions
        .iter()
        .map(|solution| read(&solution.observables))
        .reduce(of)
        .map_or(Value::Missing, Value::Number)
}

fn largest(found: &Multiplicity, read: fn(&Solution) -> f64) -> Value {
    found.solutions.iter().map(read).reduce(f64::max).map_or(Value::Missing, Value::Number)
}
