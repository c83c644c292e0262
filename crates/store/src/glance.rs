//! A glance at a store: its studies and what is kept of them in words and tables, without its
//! records.

use std::collections::BTreeMap;
use std::path::Path;

use crate::access;
use crate::blob::Blobs;
use crate::digest::Digest;
use crate::exports::exports_at;
use crate::kept::{self, KeptWords};
use crate::lock;
use crate::manifest::{Manifest, StudyLabels};
use crate::table::KeptTable;

/// The studies of a store that no process is writing, and the words about them and the tables of
/// them that hold.
#[derive(Clone, Debug)]
pub struct Glance {
    manifest: Manifest,
    blobs: Blobs,
    words: BTreeMap<String, KeptWords>,
    /// The words about tables.
    tables: BTreeMap<String, KeptWords>,
}

impl Glance {
    /// Looks at the store in `directory`; `None` if nothing is kept that holds, or if there is more
    /// to say: there is no such store, its manifest is damaged, exports lie beside it, or it is
    /// another user's.
    pub fn at(directory: &Path) -> Option<Glance> {
        let words = kept::read(directory, kept::FILE);
        let tables = kept::read(directory, kept::TABLES);
        let has_exports = || match exports_at(directory) {
            Ok(paths) => paths.is_some_and(|paths| !paths.is_empty()),
            Err(_) => true,
        };
        let is_own = || access::is_writable(directory) && lock::hidden_owner(directory).is_none();
        if words.is_empty() && tables.is_empty() || has_exports() || !is_own() {
            return None;
        }
        let manifest = Manifest::read(directory).ok()?;
        Some(Glance { manifest, words, tables, blobs: Blobs::of(directory) })
    }

    /// Returns the names of all studies in alphabetical order.
    pub fn study_names(&self) -> impl Iterator<Item = &str> {
        self.manifest.studies.keys().map(String::as_str)
    }

    /// Returns the name of the blob that holds the definition of a study, if that is sound.
    pub fn definition(&self, study: &str) -> Option<&Digest> {
        let digest = self.manifest.studies.get(study)?;
        self.blobs.definition(study, digest).is_ok().then_some(digest)
    }

    /// Returns the blobs, which are plain files.
    pub fn blobs(&self) -> &Blobs {
        &self.blobs
    }

    /// Returns the table of a study, if it means the same: `meaning` is the digest of all that it
    /// depends on beside the records.
    pub fn table(&self, study: &str, meaning: &Digest) -> Option<KeptTable> {
        KeptTable::of(self.blobs.store(), self.tables.get(study)?, meaning)
    }

    /// Returns the labels of a study.
    pub fn labels(&self, study: &str) -> StudyLabels {
        self.manifest.labels.get(study).cloned().unwrap_or_default()
    }

    /// Returns the words that are kept about a study.
    pub fn words(&self, study: &str) -> Option<&[u8]> {
        Some(&self.words.get(study)?.words)
    }
}
