//! `show`: one result whole.

use anyhow::{Context, Result, bail};
use store::{Digest, Store};
use study::columns::{Kind, Value, columns};
use study::record::decode_fields;
use study::{JobKey, Point, Record};

use crate::cli::ShowArgs;
use crate::draw;
use crate::output::{self, Finish};
use crate::query::tell_origin;

pub(crate) fn show(args: &ShowArgs) -> Result<Finish> {
    let reader = Store::read(&args.store.store)?;
    tell_origin(&reader);
    let prefix = args.key.to_ascii_lowercase();
    let matching: Vec<JobKey> = reader.keys()?.into_iter().filter(|key| key.to_string().starts_with(&prefix)).collect();
    let key = match matching[..] {
        [key] => key,
        [] => bail!("no result has a key that begins with `{}`; `tribosweep query STUDY --select key` lists keys", args.key),
        _ => bail!("{} results have keys that begin with `{}`; give more of it", matching.len(), args.key),
    };
    let bytes = reader.get(&key)?.context("the record was removed while it was looked up")?;
    let record = Record::decode(&bytes).with_context(|| format!("the record of job {key}"))?;

    if let Some(name) = &args.field {
        let Some(digest) = record.fields else { bail!("job {key} left no fields: it is {}", record.status()) };
        let blob = reader
            .blobs()
            .get(&Digest(digest))?
            .context("the file with its fields is missing; `tribosweep store verify` says what else is")?;
        return draw::show_field(&decode_fields(&blob)?, name, args.output.as_deref());
    }
    if args.json {
        return output::print_json(&json(&record)?);
    }
    output::print(&words(&record)?)
}

/// Everything about a record by column, units aside.
pub(crate) fn json(record: &Record) -> Result<serde_json::Value> {
    let point = Point::of_record(record)?;
    let mut values = serde_json::Map::new();
    for column in columns([]).iter().filter(|column| column.kind != Kind::Key) {
        let value = match column.value(&point, Some(record)) {
            Value::Number(x) => serde_json::json!(x),
            Value::Integer(n) => serde_json::json!(n),
            Value::Text(text) => serde_json::json!(text),
            Value::Missing => continue,
        };
        values.insert(column.name.to_owned(), value);
    }
    Ok(serde_json::json!({ "job": serde_json::from_str::<serde_json::Value>(&record.job)?, "result": values }))
}

/// The same to be read: the job as it would stand in a study file, then the figures by kind.
pub(crate) fn words(record: &Record) -> Result<String> {
    let point = Point::of_record(record)?;
    let mut text = format!("{}\n\n", point.job.to_toml().trim_end());
    let columns = columns([]);
    let kinds = [
        (Kind::Status, "result"),
        (Kind::Observable, "observables"),
        (Kind::Certificate, "certificate (0 is exact)"),
        (Kind::Work, "work"),
        (Kind::Provenance, "provenance"),
    ];
    for (kind, title) in kinds {
        let lines: Vec<String> = columns
            .iter()
            .filter(|column| column.kind == kind)
            .filter_map(|column| {
                let shown = match column.value(&point, Some(record)) {
                    Value::Missing => return None,
                    Value::Number(x) if kind == Kind::Certificate => format!("{x:.1e}"),
                    value => value.to_string(),
                };
                Some(format!("  {:<20} {shown} {}", column.name, column.unit()).trim_end().to_owned() + "\n")
            })
            .collect();
        if !lines.is_empty() {
            text += &format!("{title}\n{}", lines.concat());
        }
    }
    Ok(text)
}
