//! The files that a study names: height maps and profiles.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use contact::punch::{ProfileKind, Surface, Surfaces};

use crate::error::Mistake;
use crate::file_fault::FileFaults;
use crate::key::Key;
use crate::sheet::{FileContent, MapFile, NamedMap, NeededFile, ProfileFile, SurfaceNames};
use crate::surface::{MapReading, MissingRule};
use crate::units::Dimension;
use crate::{column_file, profile, surface};

/// Reads a file that a study names, and says in words why it cannot.
pub type ReadFile<'f> = dyn FnMut(&str) -> Result<NamedFile, String> + 'f;

/// A file that a study names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NamedFile {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// The permission for messages to repeat what stands in the file. They may not if it lies
    /// outside the study's directory: a study could name any file, and have it shown.
    pub may_quote: bool,
}

/// The files that a study has read.
#[derive(Clone, Debug, Default)]
pub(crate) struct StudyFiles {
    pub(crate) surfaces: Surfaces,
    pub(crate) names: SurfaceNames,
    /// The bytes of each file, by the name that the study gives it.
    pub(crate) bytes: BTreeMap<String, Vec<u8>>,
    /// The words about what was read, by the names of surfaces and profiles.
    pub(crate) notes: BTreeMap<String, FileNote>,
    /// The names of files of which messages may repeat nothing.
    secret: HashSet<String>,
    /// The contents that cannot be read, so that they are tried once.
    refused: HashSet<FileContent>,
}

/// The words about a file that was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FileNote {
    /// The name of the file as the study gives it.
    pub(crate) file: String,
    /// The layout of the file and what was done, in words.
    pub(crate) words: String,
}

impl StudyFiles {
    /// Reads a file that a point needs, unless it was read or refused already.
    pub(crate) fn read(
        &mut self,
        needed: NeededFile,
        files: &mut ReadFile<'_>,
    ) -> Result<(), Mistake> {
        let NeededFile { key, span, content } = needed;
        if self.refused.contains(&content) {
            return Ok(());
        }
        let result = match &content {
            FileContent::Map(map) => self.read_height_map(map, files),
            FileContent::StoredMap(name) => self.read_stored_surface(name, files),
            FileContent::Profile(file) => self.read_profile(file, files),
        };
        result.map_err(|reason| {
            self.refused.insert(content);
            let (noun, expected) = match key {
                Key::File => ("height map", "must be an NPY file, a matrix of text, or a list of x, y and z"),
                Key::Surface => ("height map", "must be the hash of a stored surface"),
                Key::Wheel => ("profile", "must be a wheel's profile of SIMPACK (.prw), of MiniProf (.whl), or a list of y and z"),
                _ => ("profile", "must be a rail's profile of SIMPACK (.prr), of MiniProf (.ban), or a list of y and z"),
            };
            Mistake::new(span, format!("cannot use this {noun}: {reason}"), expected)
        })
    }

    /// Reads a file that the study names, once.
    pub(crate) fn load(&mut self, name: &str, files: &mut ReadFile<'_>) -> Result<(), String> {
        if !self.bytes.contains_key(name) {
            let NamedFile { bytes, may_quote } = files(name)?;
            if !may_quote {
                self.secret.insert(name.to_owned());
            }
            self.bytes.insert(name.to_owned(), bytes);
        }
        Ok(())
    }

    /// Returns the bytes of a file that was loaded.
    pub(crate) fn loaded(&self, name: &str) -> &[u8] {
        self.bytes.get(name).map_or(&[], Vec::as_slice)
    }

    /// Says the faults of a file as far as they may be said.
    pub(crate) fn words(&self, file: &str, faults: &FileFaults) -> String {
        faults.words(!self.secret.contains(file))
    }

    /// Reads a column of a file of measured values.
    ///
    /// # Errors
    /// The file cannot be read or has no such column, in words.
    pub(crate) fn read_column(
        &mut self,
        name: &str,
        column: &str,
        dimension: Dimension,
        files: &mut ReadFile<'_>,
    ) -> Result<Vec<f64>, String> {
        self.load(name, files)?;
        column_file::read(self.loaded(name), column, dimension)
            .map_err(|faults| self.words(name, &faults))
    }

    fn read_height_map(&mut self, map: &MapFile, files: &mut ReadFile<'_>) -> Result<(), String> {
        if self.names.maps.contains_key(map) {
            return Ok(());
        }
        self.load(&map.file, files)?;
        let reading = MapReading {
            unit: map.unit.as_deref(),
            lateral_unit: map.lateral_unit.as_deref(),
            missing: map.missing,
            missing_value: map.missing_value.map(f64::from_bits),
        };
        let read = surface::read(self.loaded(&map.file), &reading)
            .map_err(|faults| self.words(&map.file, &faults))?;
        let name = surface::name(&read.surface);
        // Who says that all numbers are heights has been asked already.
        let relief = if map.missing == MissingRule::Keep { 0.0 } else { relief(&read.surface) };
        let named = NamedMap { name: name.clone(), extents: read.extents, relief };
        let note = FileNote { file: map.file.clone(), words: read.note };
        self.notes.insert(name.clone(), note);
        self.surfaces.insert(name, Arc::new(read.surface));
        self.names.maps.insert(map.clone(), named);
        Ok(())
    }

    fn read_stored_surface(&mut self, name: &str, files: &mut ReadFile<'_>) -> Result<(), String> {
        if self.surfaces.get(name).is_some() {
            return Ok(());
        }
        self.load(name, files)?;
        let surface =
            surface::decode_surface(self.loaded(name)).map_err(|error| error.to_string())?;
        if surface::name(&surface) != name {
            return Err("its content does not have this hash".to_owned());
        }
        let note = FileNote { file: String::new(), words: "as it was stored".to_owned() };
        self.notes.insert(name.to_owned(), note);
        self.surfaces.insert(name.to_owned(), Arc::new(surface));
        Ok(())
    }

    fn read_profile(
        &mut self,
        named: &ProfileFile,
        files: &mut ReadFile<'_>,
    ) -> Result<(), String> {
        if self.names.profiles.contains_key(named) {
            return Ok(());
        }
        self.load(&named.file, files)?;
        let kind = if named.is_wheel { ProfileKind::Wheel } else { ProfileKind::Rail };
        let read = profile::read(self.loaded(&named.file), kind)
            .map_err(|faults| self.words(&named.file, &faults))?;
        let name = profile::name(&read.profile);
        let note = FileNote { file: named.file.clone(), words: read.note };
        self.notes.insert(name.clone(), note);
        self.surfaces.insert_profile(name.clone(), Arc::new(read.profile));
        self.names.profiles.insert(named.clone(), name);
        Ok(())
    }
}

/// Returns the height of a surface's highest pixel above its lowest one \[m\].
fn relief(surface: &Surface) -> f64 {
    let heights = || surface.heights().iter().copied();
    heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min)
}
