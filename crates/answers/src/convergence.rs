//! How far solutions are from what they converge to, and what that says: orders and limits.

use contact::assess::{ClosedForm, Errors, closed_form};
use contact::model::{Observables, Outcome};
use contact::theory::{PowerLaw, Trend, power_law, richardson};
use report::{Cell, DataTable, TableColumn};
use study::columns::Compared;
use study::key::Key;
use study::kind::convergence::{Ladder, Reference};
use study::{Case, Job, Record, Study, StudyPoint, Value};

use crate::comparison::{AnswerTable, Comparison};
use crate::error::AnswerError;
use crate::ladders::{members, place};
use crate::records::{RecordMap, Records};
use crate::rows::{cell, digits};

/// One ladder: the points that differ in their rung only.
struct Rungs<'a> {
    /// The values of the other axes.
    at: Vec<(String, Value)>,
    /// What its rungs are compared with, by its name.
    reference: String,
    /// Relative errors below this are the solver's.
    noise: f64,
    /// From the coarsest to the finest: how fine, h or ε, the point's index and what it left.
    rungs: Vec<(f64, usize, &'a Outcome)>,
}

/// The closed form that the rungs of a ladder tend to: the source's are for ε = 0.
fn exact(ladder: &Ladder, case: &Case) -> Option<ClosedForm> {
    if ladder.along == Key::Epsilon || case.numerics.epsilon != 0.0 {
        None
    } else {
        closed_form(&case.scene)
    }
}

/// Refuses a study that asks for a closed form where there is none, before anything is solved.
pub fn check(study: &Study, ladder: &Ladder, points: &[StudyPoint]) -> Result<(), AnswerError> {
    if ladder.reference != Some(Reference::ClosedForm) {
        return Ok(());
    }
    for (at, members) in members(study, |group| group == ladder.group, points) {
        if members
            .iter()
            .filter_map(|index| case(&points[*index]))
            .any(|case| exact(ladder, case).is_none())
        {
            return Err(AnswerError::Refused(format!(
                "{}: {} has no closed form; leave `reference` out of [convergence] to compare with the finest",
                study.path(),
                place(&at)
            )));
        }
    }
    Ok(())
}

/// Gathers the ladders of a convergence study from what was solved, and compares each rung; one
/// entry for each point.
pub fn compare(
    study: &Study,
    ladder: &Ladder,
    points: &[StudyPoint],
    records: &RecordMap,
    source: &dyn Records,
) -> Result<Comparison, AnswerError> {
    let fields = |record: &Record| source.fields(record).map_err(AnswerError::Records);
    let mut compared: Vec<Option<Compared>> = points.iter().map(|_| None).collect();
    let mut ladders = Vec::new();
    for (at, members) in members(study, |group| group == ladder.group, points) {
        let mut rungs: Vec<(f64, usize, &Record)> = Vec::new();
        for index in members {
            let (Job::Solve(case), Some(record)) =
                (&points[index].job, records.get(&points[index].key))
            else {
                continue;
            };
            if record.is_certified()
                && rungs.iter().all(|(_, other, _)| points[*other].key != points[index].key)
            {
                rungs.push((height(ladder.along, case, record), index, record));
            }
        }
        rungs.sort_by(|a, b| b.0.total_cmp(&a.0));
        let Some((_, finest, last)) = rungs.last().copied() else { continue };
        let exact = match ladder.reference {
            Some(Reference::Finest) => None,
            _ => case(&points[finest]).and_then(|case| exact(ladder, case)),
        };
        let (last_fields, last_end) = (fields(last)?, last.outcome().and_then(Outcome::last));
        let (reference, source) = match &exact {
            Some(exact) => (exact.name.to_owned(), format!(" ({})", exact.source)),
            None => {
                let [x, y] =
                    last_end.map_or([0; 2], |end| [end.observables.mesh_x, end.observables.mesh_y]);
                let epsilon = case(&points[finest]).map_or(0.0, |case| case.numerics.epsilon);
                (
                    if ladder.along == Key::Epsilon {
                        format!("epsilon = {epsilon}")
                    } else {
                        format!("mesh {x} x {y}")
                    },
                    String::new(),
                )
            }
        };
        for (_, index, record) in &rungs {
            let (Some(end), Some(case)) =
                (record.outcome().and_then(Outcome::last), case(&points[*index]))
            else {
                continue;
            };
            let errors = match (&exact, last_end) {
                (Some(exact), _) => Errors::against_closed_form(end, &fields(record)?, exact),
                // the finest has no error against itself
                (None, Some(last)) if *index != finest => {
                    let controls = case.scene.loading.legs().last().map(|leg| leg.target);
                    let own = fields(record)?;
                    controls.and_then(|controls| {
                        Errors::against_solution(end, &own, last, &last_fields, &controls)
                    })
                }
                _ => None,
            };
            compared[*index] = errors.map(|errors| Compared {
                errors,
                reference: format!("{reference}{source}"),
                claim: None,
            });
        }
        let rungs = rungs
            .iter()
            .filter_map(|(height, index, record)| Some((*height, *index, record.outcome()?)))
            .collect();
        let noise = points[finest].job.case().map_or(0.0, |case| 10.0 * case.numerics.tolerance);
        ladders.push(Rungs { at, reference, noise, rungs });
    }
    let mut answers =
        vec![AnswerTable { title: "orders", table: orders(study, &ladders, &compared)? }];
    answers.extend(limits(study, &ladders)?.map(|table| AnswerTable { title: "limits", table }));
    Ok(Comparison { compared, answers })
}

fn case(point: &StudyPoint) -> Option<&Case> {
    point.job.case()
}

/// How fine a rung is: the diagonal of its elements, or ε; smaller is finer.
fn height(along: Key, case: &Case, record: &Record) -> f64 {
    match (along, record.outcome().and_then(Outcome::last)) {
        (Key::Epsilon, _) | (_, None) => case.numerics.epsilon,
        (_, Some(end)) => end.observables.element_x.hypot(end.observables.element_y),
    }
}

/// How each error falls along each ladder: error ~ h^order.
fn orders(
    study: &Study,
    ladders: &[Rungs<'_>],
    compared: &[Option<Compared>],
) -> Result<DataTable, AnswerError> {
    let along = study
        .ladder()
        .map_or("h", |ladder| if ladder.along == Key::Epsilon { "epsilon" } else { "h" });
    let mut heads = axes(study, ladders);
    let own = ["error", "order", "±", "from", "to", "finest error", "reference"];
    let unit = |name: &str| if along == "h" && matches!(name, "from" | "to") { "m" } else { "" };
    heads.extend(own.map(|name| match name {
        "from" | "to" => TableColumn::new(format!("{along} {name}"), unit(name)),
        _ => TableColumn::new(name, ""),
    }));
    let mut rows = Vec::new();
    for ladder in ladders {
        for (name, _) in Errors::default().named() {
            let error = |index: usize| {
                compared[index].as_ref().and_then(|compared| compared.errors.get(name))
            };
            let rungs: Vec<(f64, f64)> = ladder
                .rungs
                .iter()
                .filter_map(|(h, index, _)| Some((*h, error(*index)?)))
                .collect();
            let Some((_, finest)) = rungs.last().copied() else { continue };
            // ε = 0 is no point in logarithms
            let line: Vec<(f64, f64)> =
                rungs.into_iter().filter(|(h, error)| *h > 0.0 && *error > ladder.noise).collect();
            if line.is_empty() {
                continue;
            }
            let mut row: Vec<Cell> =
                ladder.at.iter().map(|(_, value)| cell(value.clone())).collect();
            row.push(Cell::Text(name.to_owned()));
            row.extend(match power_law(if finest == 0.0 { &[] } else { &line }) {
                Ok(PowerLaw { slope, standard_error, range, .. }) => {
                    [slope, standard_error, range[0], range[1]].map(|x| Cell::Number(digits(x, 2)))
                }
                Err(_) => [const { Cell::Missing }; 4],
            });
            row.extend([Cell::Number(digits(finest, 1)), Cell::Text(ladder.reference.clone())]);
            rows.push(row);
        }
    }
    Ok(DataTable::new(heads, rows)?)
}

/// A quantity with its unit.
type Quantity = (&'static str, &'static str, fn(&Observables) -> f64);

/// Quantities whose limit is estimated.
const LIMITS: [Quantity; 5] = [
    ("load", "N", |o| o.load),
    ("peak_pressure", "Pa", |o| o.peak_pressure),
    ("contact_area", "m²", |o| o.contact_area),
    ("stick_area", "m²", |o| o.stick_area),
    ("energy", "J", |o| o.energy),
];

/// What the quantities of each ladder of meshes tend to, by Richardson's extrapolation.
fn limits(study: &Study, ladders: &[Rungs<'_>]) -> Result<Option<DataTable>, AnswerError> {
    if study.ladder().is_none_or(|ladder| ladder.along != Key::Mesh)
        || ladders.iter().all(|ladder| ladder.rungs.len() < 3)
    {
        return Ok(None);
    }
    let mut heads = axes(study, ladders);
    heads.extend(
        ["quantity", "unit", "finest", "limit", "± (estimated)", "order", "values"]
            .map(|name| TableColumn::new(name, "")),
    );
    let mut rows = Vec::new();
    for ladder in ladders {
        for (name, unit, read) in LIMITS {
            let values = ladder
                .rungs
                .iter()
                .filter_map(|(h, _, outcome)| Some((*h, read(&outcome.last()?.observables))));
            let values: Vec<(f64, f64)> = values.collect();
            let (Ok(limit), Some((_, finest))) = (richardson(&values), values.last()) else {
                continue;
            };
            // what is prescribed
            if values.iter().all(|(_, value)| (value - finest).abs() <= ladder.noise * finest.abs())
            {
                continue;
            }
            let mut row: Vec<Cell> =
                ladder.at.iter().map(|(_, value)| cell(value.clone())).collect();
            let trend = match limit.trend {
                Trend::Settled => "the same to rounding",
                Trend::Asymptotic => "one order",
                Trend::Converging => "converging",
                Trend::Scattered => "scattered",
            };
            row.extend([
                Cell::Text(name.to_owned()),
                Cell::Text(unit.to_owned()),
                Cell::Number(*finest),
                Cell::Number(limit.value),
                Cell::Number(digits(limit.uncertainty, 1)),
                limit.order.map_or(Cell::Missing, |order| Cell::Number(digits(order, 2))),
                Cell::Text(trend.to_owned()),
            ]);
            rows.push(row);
        }
    }
    Ok(Some(DataTable::new(heads, rows)?))
}

/// The axes besides the ladder's.
fn axes(study: &Study, ladders: &[Rungs<'_>]) -> Vec<TableColumn> {
    let columns = study.columns();
    let unit = |name: &str| study::columns::find(&columns, name).map_or("", study::Column::unit);
    let names = ladders
        .first()
        .map(|ladder| ladder.at.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>())
        .unwrap_or_default();
    names.into_iter().map(|name| TableColumn::new(name, unit(name))).collect()
}
