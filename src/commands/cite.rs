//! `cite`: the references of what a study uses.

use std::path::Path;

use anyhow::Result;

use crate::citation_text::ReferenceList;
use crate::cli::{CitationFormat, CiteArgs};
use crate::output::{self, Finish};
use crate::stored_results::StoredResults;
use crate::study_file::read_study;

/// Prints the references of a study in the store, or of a study file.
pub(crate) fn cite(args: &CiteArgs) -> Result<Finish> {
    let file = Path::new(&args.name);
    let list = if file.is_file() {
        let study = read_study(file)?;
        let points = study.points();
        ReferenceList::of(&study, &points)?
    } else {
        let stored = StoredResults::of(&args.store.store, &args.name)?;
        ReferenceList::of_results(&stored.read()?)?
    };
    match args.format {
        _ if args.json => output::print_json(&list.json()),
        CitationFormat::Text => output::print(&list.text()),
        CitationFormat::Bibtex => output::print_raw(&list.bibtex()),
    }
}
