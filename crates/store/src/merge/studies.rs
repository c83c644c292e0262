//! This file compares the definitions of studies that sources of a merge have.

use std::collections::BTreeMap;
use std::path::Path;

use crate::digest::Digest;
use crate::merge::report::{MergeError, MergeReport};
use crate::merge::source::MergeInput;
use crate::merge::target::MergeTarget;
use crate::store::Store;

/// The definition of a study that will be in the target.
pub(super) struct ChosenStudy {
    digest: Digest,
    /// The digest of what machines must agree on.
    said: Digest,
    /// The number of the first source that has the study; the target has none.
    source: Option<usize>,
}

/// Compares the definitions of studies and returns those that the target must get.
pub(super) fn compare(
    input: &MergeInput,
    target: Option<&Store>,
    report: &mut MergeReport,
) -> Result<BTreeMap<String, ChosenStudy>, MergeError> {
    let mut chosen: BTreeMap<String, ChosenStudy> = BTreeMap::new();
    let place = target.map_or(Path::new(""), |store| store.blobs().store());
    if let Some(store) = target {
        for name in store.study_names() {
            // A definition that is damaged is healed by any other.
            if let Ok(Some(bytes)) = store.study(&name) {
                let (digest, said) = (Digest::of(&bytes), (input.rules.definition)(&bytes));
                chosen.insert(name, ChosenStudy { digest, said, source: None });
            }
        }
    }
    for (number, source) in input.sources.iter().enumerate() {
        for (name, digest) in source.studies()? {
            let names = input.study_names(source);
            if names.is_some_and(|names| !names.contains(&name)) {
                continue;
            }
            if chosen.get(&name).is_some_and(|known| known.digest == digest) {
                continue;
            }
            let said = match source.reader.blobs().definition(&name, &digest) {
                Ok(bytes) => (input.rules.definition)(&bytes),
                Err(error) => {
                    let path = source.path.display();
                    report.faults.push(format!("study {name} of {path}: {error}"));
                    continue;
                }
            };
            let found = ChosenStudy { digest, said, source: Some(number) };
            match chosen.get_mut(&name) {
                None => drop(chosen.insert(name, found)),
                Some(known) if known.said != said => {
                    return Err(MergeError::StudiesDiffer {
                        name,
                        first: match known.source {
                            Some(number) => input.sources[number].path.clone(),
                            None => place.to_owned(),
                        },
                        second: source.path.clone(),
                    });
                }
                // Only the path of its file differs.
                Some(known) if known.digest > digest => *known = found,
                Some(_) => {}
            }
        }
    }
    chosen.retain(|_, study| study.source.is_some());
    Ok(chosen)
}

/// Names the studies in the target.
pub(super) fn put(
    input: &MergeInput,
    studies: BTreeMap<String, ChosenStudy>,
    target: &mut MergeTarget,
    report: &mut MergeReport,
) -> Result<(), MergeError> {
    let mut definitions = BTreeMap::new();
    for (name, ChosenStudy { digest, source, .. }) in studies {
        let Some(source) = source.map(|number| &input.sources[number]) else { continue };
        let bytes = source.reader.blobs().definition(&name, &digest)?;
        match target {
            MergeTarget::Store(_) => drop(definitions.insert(name, bytes)),
            MergeTarget::Export(writer) => writer.put_study(&name, &bytes)?,
        }
        report.studies += usize::from(!source.is_target);
    }
    if let MergeTarget::Store(store) = target {
        store.put_studies(&definitions)?;
    }
    Ok(())
}
