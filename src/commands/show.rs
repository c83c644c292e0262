//! `show`: one result whole.

use answers::{effects, warnings};
use anyhow::Result;
use contact::model::Outcome;
use contact::punch::Surfaces;
use store::StoreReader;
use study::Record;
use wording::escaped_json;

use crate::cli::ShowArgs;
use crate::one_result::{UsedFiles, json, path, words};
use crate::output::{Finish, layout};
use crate::stored::{find_key, read_store, stored_study};
use crate::{fields, output, stored};

/// Shows one result, its path or one of its fields.
pub(crate) fn show(args: &ShowArgs) -> Result<Finish> {
    let reader = read_store(&args.store.store)?;
    let key = find_key(&reader, &args.key)?;
    let record = stored::record(&reader, &key)?;

    if args.steps {
        let path = path(&record)?;
        return if args.json {
            output::print_raw(&escaped_json(&path.json()))
        } else {
            output::print(&path.terminal(&layout()))
        };
    }
    if let Some(name) = &args.field {
        fields::check_field(name, args.output.as_deref())?;
        let fields = match record.multiplicity() {
            Some(found) => fields::solution_fields(found, args.solution)?,
            None => {
                fields::only_of_a_search(args.solution)?;
                stored::fields(reader.blobs(), &record)?
            }
        };
        if !record.is_certified() {
            output::say(
                "not certified: the field is that of the last iterate, which is no solution",
            );
        }
        return fields::show_field(&fields, name, args.output.as_deref());
    }
    let end = record.outcome().filter(|_| record.is_certified()).and_then(Outcome::last);
    let patches = end.map_or(0, |end| end.observables.patches);
    // The numbers can be shown without the fields.
    let fields = (patches > 1)
        .then(|| {
            stored::fields(reader.blobs(), &record).map_err(|error| output::complain(&error)).ok()
        })
        .flatten();
    let files = stored_files(&reader, &record)?;
    let run = record.provenance.run.as_ref();
    let account = run.and_then(|run| stored::account(reader.blobs(), run));
    if args.json {
        return output::print_json(&json(&record, fields.as_ref(), &files, account.as_ref())?);
    }
    let mut text = words(&record, fields.as_ref(), &files, account.as_ref())?;
    warnings(&record).iter().for_each(|warning| text += &format!("warning: {}\n", warning.words));
    output::print(&text)
}

/// Returns the height map or the profiles that a result's scene names, if some study of the store
/// holds them.
fn stored_files(reader: &StoreReader, record: &Record) -> Result<UsedFiles> {
    let job = record.parse_job()?;
    if effects::missing_surface(&job, &Surfaces::new()).is_none() {
        return Ok(UsedFiles::default());
    }
    for name in reader.study_names()? {
        // A damaged study is no reason to show nothing.
        let Ok(study) = stored_study(reader, &name) else { continue };
        if effects::missing_surface(&job, study.surfaces()).is_none() {
            return Ok(UsedFiles::of(&study, &job));
        }
    }
    Ok(UsedFiles::default())
}
