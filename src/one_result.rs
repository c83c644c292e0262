//! One result whole, to be read or as JSON.

use answers::patches::patches;
use answers::{effects, patches, results, rows, solutions};
use anyhow::Result;
use contact::model::Fields;
use contact::punch::Surfaces;
use report::DataTable;
use study::columns::{Role, along_path};
use study::{Case, Job, Kind, Record, StudyPoint, Value};

use crate::effect_text;
use crate::job_list::increments;
use crate::output::layout;
use crate::words::count;

/// The increments of a result's loading path.
pub(crate) fn path(record: &Record) -> Result<DataTable> {
    let point = StudyPoint::of_record(record)?;
    let table = rows::increments(&along_path(Kind::Solve.columns([], [])), [(&point, record)])?;
    let mut names = results::path_columns(&[point]);
    names.extend(["peak_pressure", "residual", "iterations"].map(str::to_owned));
    Ok(table.select(&names)?)
}

/// Everything about a record by column, units aside; with its fields also its patches, if there are
/// several.
pub(crate) fn json(
    record: &Record,
    fields: Option<&Fields>,
    surfaces: &Surfaces,
) -> Result<serde_json::Value> {
    let point = StudyPoint::of_record(record)?;
    let mut values = serde_json::Map::new();
    for column in point.job.kind().columns([], []).iter().filter(|column| column.role != Role::Key)
    {
        let value = match column.value(&point, Some(record)) {
            Value::Number(x) => serde_json::json!(x),
            Value::Integer(n) => serde_json::json!(n),
            Value::Text(text) => serde_json::json!(text),
            Value::Missing => continue,
        };
        values.insert(column.name.to_string(), value);
    }
    let mut said = serde_json::json!({ "job": serde_json::from_str::<serde_json::Value>(&record.job)?, "result": values });
    if let (Job::Solve(case) | Job::Cost { case, .. }, None) =
        (&point.job, effects::missing_surface(&point.job, surfaces))
    {
        let listed = effects::effects(case, surfaces)?;
        said["effects"] = serde_json::json!(listed.lines);
        said["method"] = serde_json::json!(listed.solver);
        said["predicted"] = serde_json::json!(listed.cost);
    }
    if let Some(found) = record.multiplicity() {
        said["solutions"] = serde_json::from_str(&solutions::table(found)?.json())?;
    }
    let patches = fields.map(patches).unwrap_or_default();
    if patches.len() > 1 {
        said["patches"] = serde_json::json!(patches);
    }
    Ok(said)
}

/// The same to be read: the job as it would stand in a study file, how far its path goes, then the
/// figures by kind.
pub(crate) fn words(
    record: &Record,
    fields: Option<&Fields>,
    surfaces: &Surfaces,
) -> Result<String> {
    let point = StudyPoint::of_record(record)?;
    let mut text = format!("{}\n\n", point.job.to_toml().trim_end());
    let all = increments(&point.job);
    if let (Some(Case { scene, .. }), true) = (point.job.case(), all > 1) {
        let loading = &scene.loading;
        text += &match record.outcome().map(|outcome| outcome.steps.len() as u64) {
            Some(solved) if solved < all => {
                format!("the path ended at its increment {solved} of {all}")
            }
            _ => format!("a path of {all} increments"),
        };
        text += &format!(": {}", count(loading.steps.len(), "step", "steps"));
        if let Some(from) = loading.cycle_from {
            text += &format!(
                ", from the one with index {from} on {}",
                count(loading.cycles as usize, "cycle", "cycles")
            );
        }
        text += "; --steps shows each\n\n";
    }
    text += &match (&point.job, effects::missing_surface(&point.job, surfaces)) {
        (Job::Solve(case) | Job::Cost { case, .. }, None) => {
            let listed = effects::effects(case, surfaces)?;
            format!(
                "effects\n{}",
                effect_text::words(Some(listed.solver), &listed.lines, listed.cost)
            )
        }
        (Job::Multiplicity { .. } | Job::Uniqueness { .. }, _) => String::new(),
        (Job::Solve(_) | Job::Cost { .. }, Some(missing)) => {
            format!("effects\n  not known: the store's studies do not hold {missing}\n")
        }
    };
    let columns = point.job.kind().columns([], []);
    let kinds = [
        (Role::Status, "result"),
        (Role::Observable, "observables"),
        (Role::Error, "estimated errors"),
        (Role::Certificate, "certificate (0 is exact)"),
        (Role::Work, "work"),
        (Role::Provenance, "provenance"),
    ];
    for (kind, title) in kinds {
        let shown = columns.iter().filter(|column| column.role == kind).filter_map(|column| {
            let value = match column.value(&point, Some(record)) {
                Value::Missing => return None,
                Value::Number(x) if matches!(kind, Role::Certificate | Role::Error) => {
                    format!("{x:.1e}")
                }
                value => value.to_string(),
            };
            Some((column.name.as_ref(), format!("{value} {}", column.unit())))
        });
        let shown: Vec<(&str, String)> = shown.collect();
        let width = shown.iter().map(|(name, _)| name.len()).max().unwrap_or(0).max(20);
        let lines: Vec<String> = shown
            .iter()
            .map(|(name, value)| format!("  {name:<width$} {value}").trim_end().to_owned() + "\n")
            .collect();
        if !lines.is_empty() {
            text += &format!("{title}\n{}", lines.concat());
        }
    }
    if let Some(found) = record.multiplicity() {
        text += &format!("solutions\n{}", solutions::table(found)?.terminal(&layout()));
    }
    let patches = fields.map(patches).unwrap_or_default();
    if patches.len() > 1 {
        text += &format!("patches\n{}", patches::table(&patches)?.terminal(&layout()));
    }
    Ok(text)
}
