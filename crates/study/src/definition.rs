//! The definition of a study: everything that is needed to read it again when its files are gone.

use std::collections::BTreeMap;

use crate::encoding::{BLOB_LIMIT, DecodeError, decode, encode};
use crate::error::StudyError;
use crate::study::Study;
use crate::study_files::{NamedFile, ReadFile};

/// The reason why a stored definition is no study.
#[derive(Debug, thiserror::Error)]
pub enum DefinitionError {
    /// The bytes do not decode.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The text in the bytes is refused, for example by a newer version of the program.
    #[error(transparent)]
    Study(#[from] StudyError),
}

impl Study {
    /// Returns the bytes of everything that is needed to read the study again when its files are
    /// gone: its path, its text and the files that it names.
    pub fn definition(&self) -> Vec<u8> {
        encode(&(&self.path, &self.text, &self.files.bytes))
    }

    /// Returns the files that the study names, each as its name in the study and its bytes.
    pub fn named_files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.files.bytes.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
    }

    /// Returns the bytes of what a definition says beside the path of its file, which differs from
    /// machine to machine; `None` if the bytes do not decode.
    pub fn definition_content(bytes: &[u8]) -> Option<Vec<u8>> {
        let stored = decode::<(String, String, BTreeMap<String, Vec<u8>>), BLOB_LIMIT>(
            "the study's definition",
            bytes,
        );
        let (_, text, files) = stored.ok()?;
        Some(encode(&(text, files)))
    }

    /// Reads a [`definition`](Study::definition).
    ///
    /// # Errors
    ///
    /// Returns an error if the bytes do not decode, or if the text in them is no study.
    pub fn from_definition(bytes: &[u8]) -> Result<Study, DefinitionError> {
        read(bytes, Study::parse)
    }

    /// Reads a [`definition`](Study::definition) of a study that may have more points than one run
    /// takes ([`parse_sharded`](Study::parse_sharded)).
    ///
    /// # Errors
    ///
    /// Returns an error if the bytes do not decode, or if the text in them is no study.
    pub fn from_large_definition(bytes: &[u8]) -> Result<Study, DefinitionError> {
        read(bytes, Study::parse_sharded)
    }

    /// Reads a [`definition`](Study::definition) that may be
    /// [large](Study::from_large_definition). This version of the program has found before that all
    /// its points make sense, so they are not assembled again.
    ///
    /// # Errors
    ///
    /// Returns an error if the bytes do not decode, or if the text in them is no study.
    pub fn from_sound_definition(bytes: &[u8]) -> Result<Study, DefinitionError> {
        read(bytes, Study::parse_found_sound)
    }
}

/// A reader of a study's text, which gets its path and a reader of the files that it names.
type Parse = fn(&str, &str, &mut ReadFile<'_>) -> Result<Study, StudyError>;

fn read(bytes: &[u8], parse: Parse) -> Result<Study, DefinitionError> {
    let (path, text, files) = decode::<(String, String, BTreeMap<String, Vec<u8>>), BLOB_LIMIT>(
        "the study's definition",
        bytes,
    )?;
    let mut file = |name: &str| {
        let bytes = files.get(name).cloned();
        let bytes = bytes.ok_or_else(|| "it is not in the study's definition".to_owned())?;
        Ok(NamedFile { bytes, may_quote: false })
    };
    Ok(parse(&text, &path, &mut file)?)
}
