//! `cite`: the references of what a study uses.

use std::path::Path;

use answers::Results;
use anyhow::Result;

use crate::citation_text::ReferenceList;
use crate::cli::{CitationFormat, CiteArgs};
use crate::output::{self, Finish};
use crate::stored::{StoreSource, read_store, stored_study};
use crate::study_file::read_study;

/// Prints the references of a study in the store, or of a study file.
pub(crate) fn cite(args: &CiteArgs) -> Result<Finish> {
    let file = Path::new(&args.name);
    let list = if file.is_file() {
        let study = read_study(file)?;
        let points = study.points();
        ReferenceList::of(&study, &points)?
    } else {
        let reader = read_store(&args.store.store)?;
        let source = StoreSource::Reader(&reader);
        let results = Results::read(stored_study(&reader, &args.name)?, &source)?;
        ReferenceList::of(results.study(), results.points())?
    };
    match args.format {
        _ if args.json => output::print_json(&list.json()),
        CitationFormat::Text => output::print(&list.text()),
        CitationFormat::Bibtex => output::print_raw(&list.bibtex()),
    }
}
