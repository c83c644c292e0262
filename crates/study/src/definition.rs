//! The definition of a study: everything that is needed to read it again when its files are gone.

use std::collections::BTreeMap;

use crate::encoding::{BLOB_LIMIT, DecodeError, decode, encode};
use crate::error::StudyError;
use crate::study::Study;

/// Why a stored definition is no study.
#[derive(Debug, thiserror::Error)]
pub enum DefinitionError {
    /// The bytes do not decode.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The text in it is refused, by a newer version of the program.
    #[error(transparent)]
    Study(#[from] StudyError),
}

impl Study {
    /// Everything that is needed to read the study again when its files are gone: text, path and
    /// the files it names.
    pub fn definition(&self) -> Vec<u8> {
        encode(&(&self.path, &self.text, &self.files.bytes))
    }

    /// Reads a [`definition`](Study::definition).
    pub fn from_definition(bytes: &[u8]) -> Result<Study, DefinitionError> {
        let (path, text, files) = decode::<(String, String, BTreeMap<String, Vec<u8>>), BLOB_LIMIT>(
            "the study's definition",
            bytes,
        )?;
        let mut read = |name: &str| {
            files.get(name).cloned().ok_or_else(|| "it is not in the study's definition".to_owned())
        };
        Ok(Study::parse(&text, &path, &mut read)?)
    }
}
