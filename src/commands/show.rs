//! `show`: one result whole.

use answers::warnings;
use anyhow::Result;
use contact::model::Outcome;
use store::StoreReader;
use study::{Record, Study};
use wording::escaped_json;

use crate::below_surface::{self, WantedPlane};
use crate::cli::ShowArgs;
use crate::increments::PathJob;
use crate::one_result::{UsedFiles, json, path, words};
use crate::output::{Finish, layout};
use crate::series::write_series;
use crate::stored::{find_key, read_store, study_with_files};
use crate::threads::share_among;
use crate::{fields, output, stored};

/// Shows one result, its path or one of its fields.
pub(crate) fn show(args: &ShowArgs) -> Result<Finish> {
    let (name, file) = (args.field.as_deref(), args.output.as_deref());
    if let Some(plane) = &args.plane {
        let wanted = WantedPlane::parse(plane, args.down_to.as_deref())?;
        below_surface::check(name, file)?;
        let reader = read_store(&args.store.store)?;
        let record = stored::record(&reader, &find_key(&reader, &args.key)?)?;
        share_among(0)?;
        let fields = stored::fields(reader.blobs(), &record)?;
        let chosen = below_surface::fields(&record.parse_job()?, &fields, &wanted, name)?;
        if !record.is_certified() {
            output::say("not certified: these are the stresses of the last iterate");
        }
        return fields::show_fields(&chosen, file);
    }
    fields::check_field(name, file)?;
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
    if name.is_some() || file.is_some() {
        let say_doubt = || {
            if !record.is_certified() {
                output::say(
                    "not certified: the field is that of the last iterate, which is no solution",
                );
            }
        };
        if let Some(file) = file.filter(|_| fields::is_series(file)) {
            share_among(0)?;
            fields::only_of_a_search(args.solution)?;
            let job = record.parse_job()?;
            let study = study_with_files(&reader, &job)?;
            let surfaces = study.as_ref().map(Study::surfaces).cloned().unwrap_or_default();
            let path = PathJob { job, surfaces: &surfaces, record: Some(&record) };
            let finish = write_series(&path, name, file)?;
            say_doubt();
            return Ok(finish);
        }
        let fields = match record.multiplicity() {
            Some(found) => fields::solution_fields(found, args.solution)?,
            None => {
                fields::only_of_a_search(args.solution)?;
                stored::fields(reader.blobs(), &record)?
            }
        };
        say_doubt();
        return fields::show_field(&fields, name, file);
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
    let study = study_with_files(reader, &job)?;
    Ok(study.map(|study| UsedFiles::of(&study, &job)).unwrap_or_default())
}
