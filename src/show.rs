//! `show`: one result whole.

use anyhow::{Context, Result, bail};
use contact::outcome::{Fields, Outcome};
use contact::punch::Surfaces;
use report::DataTable;
use store::{Reader, Store};
use study::columns::{Role, Value, along_path, columns};
use study::{Case, Job, JobKey, Kind, Point, Record};

use crate::cli::ShowArgs;
use crate::launch::increments;
use crate::output::{self, Finish, count};
use crate::patches::{self, patches};
use crate::query::{layout, tell_origin};
use crate::{draw, effects, results, solutions};

pub(crate) fn show(args: &ShowArgs) -> Result<Finish> {
    let reader = Store::read(&args.store.store)?;
    tell_origin(&reader);
    let prefix = args.key.to_ascii_lowercase();
    let matching: Vec<JobKey> =
        reader.keys()?.into_iter().filter(|key| key.to_string().starts_with(&prefix)).collect();
    let key = match matching[..] {
        [key] => key,
        [] => bail!(
            "no result has a key that begins with `{}`; `tribosweep query STUDY --select key` lists keys",
            args.key
        ),
        _ => bail!(
            "{} results have keys that begin with `{}`; give more of it",
            matching.len(),
            args.key
        ),
    };
    let bytes = reader.get(&key)?.context("the record was removed while it was looked up")?;
    let record = Record::decode(&bytes).with_context(|| format!("the record of job {key}"))?;

    if args.steps {
        let path = path(&record)?;
        return output::print(&if args.json { path.json() } else { path.terminal(&layout()) });
    }
    if let Some(name) = &args.field {
        draw::check_field(name, args.output.as_deref())?;
        let fields = match record.multiplicity() {
            Some(found) => solutions::fields(found, args.solution)?,
            None => {
                solutions::only_of_a_search(args.solution)?;
                results::fields(reader.blobs(), &record)?
            }
        };
        return draw::show_field(&fields, name, args.output.as_deref());
    }
    let patches = record.outcome().and_then(Outcome::last).map_or(0, |end| end.observables.patches);
    // the numbers are there without them
    let fields = (patches > 1)
        .then(|| {
            results::fields(reader.blobs(), &record).map_err(|error| output::complain(&error)).ok()
        })
        .flatten();
    let surfaces = stored_surfaces(&reader, &record)?;
    if args.json {
        return output::print_json(&json(&record, fields.as_ref(), &surfaces)?);
    }
    output::print(&words(&record, fields.as_ref(), &surfaces)?)
}

/// The height map or the profiles that a result's scene names, as far as some study of the store
/// holds them.
fn stored_surfaces(reader: &Reader, record: &Record) -> Result<Surfaces> {
    let job = record.parse_job()?;
    if effects::missing_surface(&job, &Surfaces::new()).is_none() {
        return Ok(Surfaces::new());
    }
    for name in reader.study_names()? {
        // a damaged study is no reason to show nothing
        let Ok(study) = results::stored_study(reader, &name) else { continue };
        if effects::missing_surface(&job, study.surfaces()).is_none() {
            return Ok(study.surfaces().clone());
        }
    }
    Ok(Surfaces::new())
}

/// The increments of a result's loading path.
pub(crate) fn path(record: &Record) -> Result<DataTable> {
    let point = Point::of_record(record)?;
    let table = results::increments(&along_path(columns(Kind::Solve, [], [])), [(&point, record)])?;
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
    let point = Point::of_record(record)?;
    let mut values = serde_json::Map::new();
    for column in columns(point.job.kind(), [], []).iter().filter(|column| column.role != Role::Key)
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
    let point = Point::of_record(record)?;
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
            format!("effects\n{}", effects::words(Some(listed.solver), &listed.lines, listed.cost))
        }
        (Job::Multiplicity { .. } | Job::Uniqueness { .. }, _) => String::new(),
        (Job::Solve(_) | Job::Cost { .. }, Some(missing)) => {
            format!("effects\n  not known: the store's studies do not hold {missing}\n")
        }
    };
    let columns = columns(point.job.kind(), [], []);
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
