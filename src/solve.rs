//! `solve`: one scene, in this process, nothing stored.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use contact::Operators;
use contact::model::Fields;
use contact::punch::Surfaces;
use study::job::PHYSICS_VERSION;
use study::key::Key;
use study::{Adaptive, Job, Kind, Provenance, Record, Study};
use toml_edit::{DocumentMut, Item, Table, TableLike, Value};

use crate::adaptive::{Found, choose};
use crate::cli::SolveArgs;
use crate::measure::median;
use crate::output::{self, Finish};
use crate::work::{Done, perform, share_among};
use crate::{draw, launch, results, show, solutions};

pub(crate) fn solve(args: &SolveArgs) -> Result<Finish> {
    share_among(0)?;
    let study = if args.set.is_empty() {
        launch::read_study(&args.scene)?
    } else {
        let text = std::fs::read_to_string(&args.scene)
            .with_context(|| format!("cannot read {}", args.scene.display()))?;
        let edited = with_settings(&text, &args.scene, &args.set)?;
        launch::parse_study(&edited, &args.scene)?
    };
    if study.len() != 1 {
        bail!(
            "{} describes {} points; fix its axes with --set KEY=VALUE ({}), or run them all with `tribosweep run`",
            args.scene.display(),
            study.len(),
            study.axes().map(|axis| axis.path()).collect::<Vec<_>>().join(", ")
        );
    }
    if let Some(name) = &args.field {
        draw::check_field(name, args.output.as_deref())?;
    }
    if study.kind() != Kind::Multiplicity {
        solutions::only_of_a_search(args.solution)?;
    }
    let mut operators = Operators::default();
    let (record, fields, found) = match study.adaptive() {
        Some(Adaptive::Accuracy(_)) => accurate(&study, &mut operators)?,
        _ => {
            let job = study.point(0).context("the study's only point cannot be made")?.job;
            let (record, fields) = solved(&job, study.surfaces(), &mut operators)?;
            (record, fields, None)
        }
    };
    let missed = matches!(found, Some(Found::Beyond { .. }));
    let finish = if record.status() == "certified" && !missed {
        Finish::AllDone
    } else {
        Finish::SomeFailed
    };
    match &args.field {
        Some(name) => {
            let fields = match record.multiplicity() {
                Some(found) => Some(solutions::fields(found, args.solution)?),
                None => fields,
            };
            draw::show_field(&fields.context("it has no fields")?, name, args.output.as_deref())?;
        }
        None if args.json => {
            output::print_json(&show::json(&record, fields.as_ref(), study.surfaces())?)?;
        }
        None => {
            let mut text = show::words(&record, fields.as_ref(), study.surfaces())?;
            if record.outcome().is_some_and(|outcome| outcome.steps.len() > 1) {
                text +=
                    &format!("path\n{}", show::path(&record)?.terminal(&crate::query::layout()));
            }
            output::print(&text)?;
        }
    }
    for warning in results::WARNINGS.iter().filter(|warning| warning.concerns(&record)) {
        output::say(&format!("warning: elements {}", warning.words));
    }
    if let (Some(Found::Beyond { error, why, .. }), true) = (found, record.is_certified()) {
        let reached =
            error.map_or(String::new(), |error| format!("; the estimated error is {error:.1e}"));
        output::say(&format!("the accuracy asked for was missed: {why}{reached}"));
    }
    if !record.is_certified() {
        let last = if record.outcome().is_some() {
            "; the figures are those of the last iterate"
        } else {
            ""
        };
        output::say(&format!(
            "not certified: {}{last}",
            record.ending.reason().unwrap_or_else(|| record.status())
        ));
    }
    if let Some(Adaptive::Refine { .. }) = study.adaptive() {
        output::say("solved on the study's first mesh; `tribosweep run` refines it");
    }
    // the process ends, and with it its memory; to hand back a gigabyte first takes a hundredth of
    // the time to solve for it
    std::mem::forget(operators);
    Ok(finish)
}

/// What a job leaves, and its fields.
fn solved(
    job: &Job,
    surfaces: &Surfaces,
    operators: &mut Operators,
) -> Result<(Record, Option<Fields>)> {
    let start = Instant::now();
    let Done { ending, fields, times } = perform(job, surfaces, operators)?;
    let provenance = Provenance {
        program: env!("CARGO_PKG_VERSION").to_owned(),
        seconds: if times.is_empty() {
            start.elapsed().as_secs_f64()
        } else {
            median(times.clone())
        },
        times,
        ..Provenance::default()
    };
    // nothing is stored, so nothing is kept
    Ok((
        Record { physics: PHYSICS_VERSION, job: job.canonical(), ending, fields: None, provenance },
        fields,
    ))
}

/// Solves the only scene of a study on one mesh after the other until it is accurate enough, or no
/// mesh is left.
fn accurate(
    study: &Study,
    operators: &mut Operators,
) -> Result<(Record, Option<Fields>, Option<Found>)> {
    let (mut records, mut last) = (HashMap::new(), None);
    loop {
        let chosen = choose(study, &records)?;
        let point =
            chosen.points.into_iter().next().context("the study's only point cannot be made")?;
        let found = chosen.findings.first().map(|finding| finding.found);
        if let Entry::Vacant(unknown) = records.entry(point.key) {
            let (record, fields) = solved(&point.job, study.surfaces(), operators)?;
            unknown.insert(record);
            last = fields.map(|fields| (point.key, fields));
            continue;
        }
        // the fields of the finest are at hand, those of a better one before it are not
        let fields = match last {
            Some((key, fields)) if key == point.key => Some(fields),
            _ => solved(&point.job, study.surfaces(), operators)?.1,
        };
        let record = records.remove(&point.key).context("a result was lost")?;
        return Ok((record, fields, found));
    }
}

/// The study's text with keys set, each taken out of the axes.
fn with_settings(text: &str, path: &Path, settings: &[String]) -> Result<String> {
    let Ok(mut document) = text.parse::<DocumentMut>() else {
        // the study's own reader says what is wrong, with its place
        launch::parse_study(text, path)?;
        bail!("{} cannot be edited", path.display());
    };
    for setting in settings {
        let (name, value) = setting.split_once('=').with_context(|| {
            format!("--set {setting}: must be KEY=VALUE, for example friction.mu=0.5")
        })?;
        let name = name.trim();
        let key = Key::find(name).or_else(|| Key::of_column(name)).with_context(|| {
            let said = match study::key::nearest_path(name) {
                // a table of keys, or a list of them
                Some(same) if same == name => {
                    format!("`{name}` holds several keys; set one of them, or edit the file")
                }
                Some(near) => format!("there is no key `{name}`; did you mean `{near}`?"),
                None => format!("there is no key `{name}`"),
            };
            format!("--set {setting}: {said}")
        })?;
        // what is no TOML value is a text: punch.radius=2mm, method=seidel
        let value: Value = value.trim().parse().unwrap_or_else(|_| Value::from(value.trim()));
        if let Some(sweep) = document.get_mut("sweep").and_then(Item::as_table_like_mut) {
            remove_axis(sweep, key);
        }
        if key == Key::Mesh {
            // who says the mesh does not leave it to the accuracy
            document.remove("accuracy");
        }
        set(document.as_item_mut(), &key.path(), value)
            .with_context(|| format!("--set {setting}: {} has no place for it", path.display()))?;
    }
    Ok(document.to_string())
}

/// Meshes of the ladder that is made for a scene, and tolerances.
const LADDER: ([i64; 9], [f64; 3]) = ([8, 12, 16, 24, 32, 48, 64, 96, 128], [1e-2, 1e-4, 1e-8]);

/// The text of a study of what accuracy costs, for the only scene of another study.
pub(crate) fn with_cost_ladder(text: &str, path: &Path, settings: &[String]) -> Result<String> {
    let study = launch::parse_study(text, path)?;
    if study.kind() == Kind::Cost {
        return with_settings(text, path, settings);
    }
    if !matches!(study.kind(), Kind::Solve | Kind::Convergence) {
        bail!(
            "{}: a study of kind \"{}\" solves no scene whose accuracy could be priced",
            path.display(),
            study.kind().name()
        );
    }
    let mut document = text
        .parse::<DocumentMut>()
        .with_context(|| format!("{} cannot be edited", path.display()))?;
    for table in ["figure", "refine", "bisect", "convergence", "kind"] {
        document.remove(table);
    }
    if document.remove("accuracy").is_some() {
        set(document.as_item_mut(), &Key::Mesh.path(), LADDER.0[0].into())?;
    }
    document["name"] = toml_edit::value(format!("{}-cost", study.name()));
    let is_rung = |setting: &&String| {
        let name = setting.split('=').next().unwrap_or_default().trim();
        matches!(Key::find(name).or_else(|| Key::of_column(name)), Some(Key::Mesh | Key::Tolerance))
    };
    if let Some(setting) = settings.iter().find(is_rung) {
        bail!(
            "--set {setting}: the ladder has meshes and tolerances of its own; a study of kind \"cost\" can have others"
        );
    }
    let text = with_settings(&document.to_string(), path, settings)?;
    let study = launch::parse_study(&text, path)?;
    let left: Vec<String> = study
        .axes()
        .filter(|axis| !matches!(axis.key(), Some(Key::Mesh | Key::Tolerance)))
        .map(|axis| axis.path().into_owned())
        .collect();
    if !left.is_empty() {
        bail!(
            "{} varies {}; fix that with --set KEY=VALUE, so that one scene is left",
            path.display(),
            left.join(", ")
        );
    }
    let mut document = text
        .parse::<DocumentMut>()
        .with_context(|| format!("{} cannot be edited", path.display()))?;
    document["kind"] = toml_edit::value("cost");
    for key in [Key::Mesh, Key::Tolerance] {
        if let Some(sweep) = document.get_mut("sweep").and_then(Item::as_table_like_mut) {
            remove_axis(sweep, key);
        }
    }
    if document.get("sweep").is_none() {
        document["sweep"] = Item::Table(Table::new());
    }
    let sweep = document["sweep"].as_table_like_mut().context("`sweep` is no table")?;
    sweep.insert("mesh", Item::Value(LADDER.0.into_iter().collect::<toml_edit::Array>().into()));
    sweep.insert(
        "tolerance",
        Item::Value(LADDER.1.into_iter().collect::<toml_edit::Array>().into()),
    );
    Ok(document.to_string())
}

/// Removes a key, and what is part of it, from the axes, spelled as one name or as nested tables,
/// on its own or in a group.
fn remove_axis(sweep: &mut dyn TableLike, key: Key) {
    fn is_part(path: &str, key: Key) -> bool {
        // lists and the base are tables as well
        let of = study::key::Table::find(&key.path());
        let under = |of: &study::key::Table| {
            Key::find(path).is_some_and(|key| key.is_under(of))
                || study::key::Table::find(path).is_some_and(|table| table.is_under(of))
        };
        Key::find(path) == Some(key) || of.as_ref().is_some_and(under)
    }
    fn remove(table: &mut dyn TableLike, prefix: &str, key: Key) {
        let names: Vec<String> = table.iter().map(|(name, _)| name.to_owned()).collect();
        for name in names {
            let path = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
            if is_part(&path, key) {
                table.remove(&name);
            } else if let Some(inner) = table.get_mut(&name).and_then(Item::as_table_like_mut) {
                remove(inner, &path, key);
                if inner.is_empty() {
                    table.remove(&name);
                }
            }
        }
    }
    remove(sweep, "", key);
    let emptied = match sweep.get_mut("zip") {
        Some(Item::ArrayOfTables(groups)) => {
            groups.iter_mut().for_each(|group| remove(group, "", key));
            groups.retain(|group| !group.is_empty());
            groups.is_empty()
        }
        Some(Item::Value(Value::Array(groups))) => {
            groups
                .iter_mut()
                .filter_map(Value::as_inline_table_mut)
                .for_each(|group| remove(group, "", key));
            groups.retain(|group| group.as_inline_table().is_none_or(|group| !group.is_empty()));
            groups.is_empty()
        }
        _ => false,
    };
    if emptied {
        sweep.remove("zip");
    }
}

/// Sets a path such as `scene.loading.steps[0].approach`.
fn set(mut at: &mut Item, path: &str, value: Value) -> Result<()> {
    let mut parts = path.split('.').peekable();
    while let Some(part) = parts.next() {
        let (name, index) = match part.strip_suffix(']').and_then(|part| part.split_once('[')) {
            Some((name, index)) => (name, Some(index.parse::<usize>()?)),
            None => (part, None),
        };
        let table = at
            .as_table_like_mut()
            .with_context(|| format!("`{name}` would have to stand in a table"))?;
        if parts.peek().is_none() && index.is_none() {
            table.insert(name, Item::Value(value));
            return Ok(());
        }
        if !table.contains_key(name) {
            // an inline table has no room for a standard one
            let implied = if index.is_some() {
                bail!("there is no `{name}`")
            } else {
                Item::Table(Table::new())
            };
            table.insert(name, implied.into_value().map_or_else(|item| item, Item::Value));
        }
        at = table.get_mut(name).with_context(|| format!("there is no `{name}`"))?;
        if let Some(index) = index {
            at = at.get_mut(index).with_context(|| format!("`{name}` has no entry {index}"))?;
        }
    }
    Ok(())
}
