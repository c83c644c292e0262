//! One result whole, to be read or as JSON: for `show` and `solve`.

use answers::effects::{effects_of_job, missing_surface};
use answers::patches::{self, Patch, inclination_words, patches, place_on_rail};
use answers::{Accounts, AnswerTable, forecast, path_columns, rows, tables_of, warnings};
use anyhow::Result;
use contact::model::Fields;
use contact::punch::Surfaces;
use report::DataTable;
use study::columns::{Role, Row, along_path};
use study::job::PHYSICS_VERSION;
use study::{Case, Column, Job, Kind, Record, RunAccount, Study, StudyPoint, Value};

use crate::account::{account_lines, unknown_account};
use crate::effect_text::effect_lines;
use crate::output::layout;
use crate::words::count;

/// Returns the increments of a result's loading path as a table.
pub(crate) fn path(record: &Record) -> Result<DataTable> {
    let point = StudyPoint::of_record(record)?;
    let columns = along_path(Kind::Solve.columns([], []));
    let table = rows::increments(&columns, &Accounts::default(), [(&point, record)])?;
    let mut names = path_columns(&[point]);
    names.extend(["peak_pressure", "residual", "iterations"].map(str::to_owned));
    Ok(table.select(&names)?)
}

/// Returns the patches of a contact that has several; those of a wheel have their place on the
/// rail.
fn several_patches(
    point: &StudyPoint,
    record: &Record,
    fields: Option<&Fields>,
    surfaces: &Surfaces,
) -> Result<Option<Vec<Patch>>> {
    let Some(mut patches) = fields.map(patches).filter(|patches| patches.len() > 1) else {
        return Ok(None);
    };
    // Another physics may have had another plane of contact.
    let is_known =
        record.physics == PHYSICS_VERSION && missing_surface(&point.job, surfaces).is_none();
    if let Some(Case { scene, .. }) = point.job.case().filter(|_| is_known) {
        place_on_rail(&mut patches, scene, surfaces)?;
    }
    Ok(Some(patches))
}

/// The files of a result's job.
#[derive(Default)]
pub(crate) struct UsedFiles {
    /// The height map or the profiles.
    pub(crate) surfaces: Surfaces,
    /// The words about what was read, a line for each file.
    pub(crate) words: Vec<String>,
}

impl UsedFiles {
    /// Returns the files of a job from a study that has them.
    pub(crate) fn of(study: &Study, job: &Job) -> Self {
        let elements = forecast(job, study.surfaces()).map(|forecast| forecast.elements);
        let words = elements.map(|elements| study.file_words(job, elements)).unwrap_or_default();
        Self { surfaces: study.surfaces().clone(), words }
    }
}

/// Returns everything about a record by column, without units; with its fields also its patches, if
/// there are several.
pub(crate) fn json(
    record: &Record,
    fields: Option<&Fields>,
    UsedFiles { surfaces, words }: &UsedFiles,
    account: Option<&RunAccount>,
) -> Result<serde_json::Value> {
    let point = StudyPoint::of_record(record)?;
    let columns = point.job.kind().columns([], []);
    let values = |is_meant: fn(Role) -> bool, value: &dyn Fn(&Column) -> Value| {
        let meant = columns.iter().filter(|column| is_meant(column.role));
        let given = meant.filter_map(|column| {
            let value = match value(column) {
                Value::Number(x) => serde_json::json!(x),
                Value::Integer(n) => serde_json::json!(n),
                Value::Flag(yes) => serde_json::json!(yes),
                Value::Text(text) => serde_json::json!(text),
                Value::Missing => return None,
            };
            Some((column.name.to_string(), value))
        });
        given.collect::<serde_json::Map<_, _>>()
    };
    let row = Row { point: &point, record: Some(record), compared: None, account };
    let result = values(|role| role != Role::Key, &|column| column.value_of(&row));
    let job: serde_json::Value = serde_json::from_str(&record.job)?;
    let mut said = serde_json::json!({ "job": job, "result": result });
    said["provenance"] = match account {
        Some(account) => serde_json::json!(account),
        None => serde_json::json!({ "unknown": unknown_account(record) }),
    };
    if !words.is_empty() {
        said["files"] = serde_json::json!(words);
    }
    if !record.is_certified() {
        // What a failed path came through is no result at the end that was asked for.
        if let Some(before) = record.before_failure() {
            let reached =
                values(Role::is_of_solutions, &|column| column.value(&point, Some(&before)));
            said["reached"] = serde_json::json!(reached);
        }
        let left = values(Role::is_of_solutions, &|column| column.value_left(&point, record));
        said["uncertified"] = serde_json::json!(left);
    }
    let is_known = missing_surface(&point.job, surfaces).is_none();
    if let Some(listed) = effects_of_job(&point.job, surfaces).filter(|_| is_known) {
        let listed = listed?;
        said["effects"] = serde_json::json!(listed.lines);
        said["method"] = serde_json::json!(listed.solver);
        said["predicted"] = serde_json::json!(listed.cost);
    }
    let doubts: Vec<String> = warnings(record).into_iter().map(|doubt| doubt.words).collect();
    if !doubts.is_empty() {
        said["warnings"] = serde_json::json!(doubts);
    }
    for AnswerTable { title, table } in tables_of(record)? {
        said[title.as_ref()] = serde_json::from_str(&table.json())?;
    }
    if let Some(patches) = several_patches(&point, record, fields, surfaces)? {
        said["patches"] = serde_json::json!(patches);
    }
    Ok(said)
}

/// Returns everything about a record to be read: the job as it would stand in a study file, how far
/// its path goes, then the figures by kind.
pub(crate) fn words(
    record: &Record,
    fields: Option<&Fields>,
    UsedFiles { surfaces, words }: &UsedFiles,
    account: Option<&RunAccount>,
) -> Result<String> {
    let point = StudyPoint::of_record(record)?;
    let mut text = format!("{}\n\n", point.job.to_toml().trim_end());
    text += &words.iter().map(|line| format!("{line}\n")).collect::<String>();
    text += if words.is_empty() { "" } else { "\n" };
    text += &path_words(&point, record, surfaces);
    text += &effect_words(&point, surfaces)?;
    let columns = point.job.kind().columns([], []);
    for section in SECTIONS {
        if record.is_certified() || !section.role.is_of_solutions() {
            let row = Row { point: &point, record: Some(record), compared: None, account };
            text += &section.words("", &columns, |column| column.value_of(&row));
            if section.role == Role::Provenance {
                text += &account_words(record, account);
            }
            continue;
        }
        if let Some(before) = record.before_failure() {
            let value = |column: &Column| column.value(&point, Some(&before));
            text += &section.words(" at the last increment that was solved", &columns, value);
        }
        let value = |column: &Column| column.value_left(&point, record);
        let of = match record.outcome() {
            Some(_) => " of the last iterate, which is no solution",
            None => ", not certified",
        };
        text += &section.words(of, &columns, value);
    }
    for AnswerTable { title, table } in tables_of(record)? {
        text += &format!("{title}\n{}", table.terminal(&layout()));
    }
    if let Some(patches) = several_patches(&point, record, fields, surfaces)? {
        text += &format!("patches\n{}", patches::table(&patches)?.terminal(&layout()));
        text += &inclination_words(&patches).unwrap_or_default();
    }
    Ok(text)
}

/// Says how far a path of several increments goes.
fn path_words(point: &StudyPoint, record: &Record, surfaces: &Surfaces) -> String {
    let all = forecast(&point.job, surfaces).map_or(0, |forecast| forecast.increments);
    let Some(Case { scene, .. }) = point.job.case().filter(|_| all > 1) else {
        return String::new();
    };
    let loading = &scene.loading;
    let mut text = match record.outcome().map(|outcome| outcome.steps.len() as u64) {
        Some(followed) if followed < all || !record.is_certified() => {
            format!("the path ended at its increment {followed} of {all}")
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
    text + "; --steps shows each\n\n"
}

/// Lists the effects of a job that can leave some out.
fn effect_words(point: &StudyPoint, surfaces: &Surfaces) -> Result<String> {
    let Some(listed) = effects_of_job(&point.job, surfaces) else { return Ok(String::new()) };
    if let Some(missing) = missing_surface(&point.job, surfaces) {
        return Ok(format!("effects\n  not known: the store's studies do not hold {missing}\n"));
    }
    let listed = listed?;
    let lines = effect_lines(listed.solver, &listed.lines, listed.cost);
    Ok(format!("effects\n{lines}"))
}

/// Says what the columns of the provenance do not.
fn account_words(record: &Record, account: Option<&RunAccount>) -> String {
    let line = |[name, value]: [String; 2]| format!("  {name:<20} {value}\n");
    match account {
        Some(account) => account_lines(account).into_iter().map(line).collect(),
        None => line(["account".to_owned(), unknown_account(record)]),
    }
}

/// The columns of a role under a title.
struct RoleSection {
    role: Role,
    title: &'static str,
    /// Numbers are shown with two digits.
    is_rounded: bool,
}

const SECTIONS: [RoleSection; 6] = [
    RoleSection { role: Role::Status, title: "result", is_rounded: false },
    RoleSection { role: Role::Observable, title: "observables", is_rounded: false },
    RoleSection { role: Role::Error, title: "estimated errors", is_rounded: true },
    RoleSection { role: Role::Certificate, title: "certificate (0 is exact)", is_rounded: true },
    RoleSection { role: Role::Work, title: "work", is_rounded: false },
    RoleSection { role: Role::Provenance, title: "provenance", is_rounded: false },
];

impl RoleSection {
    /// Lists the values of the columns of the role; `of` follows the title and says where they
    /// hold.
    fn words(&self, of: &str, columns: &[Column], value: impl Fn(&Column) -> Value) -> String {
        let shown = columns.iter().filter(|column| column.role == self.role).filter_map(|column| {
            let value = match value(column) {
                Value::Missing => return None,
                Value::Number(x) if self.is_rounded => format!("{x:.1e}"),
                value => value.to_string(),
            };
            Some((column.name.as_ref(), format!("{value} {}", column.unit())))
        });
        let shown: Vec<(&str, String)> = shown.collect();
        if shown.is_empty() {
            return String::new();
        }
        let width = shown.iter().map(|(name, _)| name.len()).max().unwrap_or(0).max(20);
        let line = |(name, value): &(&str, String)| {
            format!("  {name:<width$} {value}").trim_end().to_owned() + "\n"
        };
        format!("{}{of}\n{}", self.title, shown.iter().map(line).collect::<String>())
    }
}
