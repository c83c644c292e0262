//! `rm`: removes studies from a store.

use std::collections::BTreeSet;

use answers::Progress;
use anyhow::Result;
use store::{Store, StoreReader};

use crate::cli::RmArgs;
use crate::output::{self, Finish};
use crate::proposal;
use crate::stored::{StoreSource, no_such_study, read_store, stored_large_study};
use crate::words::count;

/// Removes studies, or says what would be removed.
pub(crate) fn rm(args: &RmArgs) -> Result<Finish> {
    let names: BTreeSet<String> = args.names.iter().cloned().collect();
    let require = |known: &[String]| match names.iter().find(|name| !known.contains(name)) {
        Some(unknown) => Err(no_such_study(unknown, known)),
        None => Ok(()),
    };
    let directory = &args.store.store;
    let mut text = String::new();
    if args.dry_run {
        let reader = read_store(directory)?;
        require(&reader.study_names()?)?;
        for name in &names {
            text += &format!("would remove the study `{name}`: {}\n", words(&reader, name));
        }
    } else {
        let store = Store::open_existing(directory)?;
        require(&store.study_names())?;
        store.remove_studies(&names)?;
        names.iter().for_each(|name| text += &format!("removed the study `{name}`\n"));
        text += &format!(
            "figures and pages that were made stay; results stay until `{}` removes those that no other study has\n",
            proposal::command(directory, ["store", "gc"])
        );
    }
    if args.json {
        let removed = !args.dry_run;
        return output::print_json(&serde_json::json!({ "studies": names, "removed": removed }));
    }
    output::print(&text)
}

/// Says how far a study is. One that cannot be read can be removed all the same.
fn words(reader: &StoreReader, name: &str) -> String {
    let study = match stored_large_study(reader, name) {
        Ok(study) => study,
        Err(_) => return "its definition cannot be read".to_owned(),
    };
    let points = count(study.len(), "point", "points");
    if !study.is_listed() {
        return points;
    }
    match Progress::read(&study, &StoreSource::Reader(reader)) {
        Ok(Progress { points, done, failed, left, .. }) => {
            let points = count(points, "point", "points");
            format!("{points}, {done} certified, {failed} failed, {left} left")
        }
        Err(_) => format!("{points}, and results that cannot be read"),
    }
}
