//! The files that a study names: height maps and profiles.

use std::collections::BTreeMap;
use std::sync::Arc;

use contact::punch::{ProfileKind, Surfaces};

use crate::error::Mistake;
use crate::key::Key;
use crate::sheet::{FileContent, NeededFile, SurfaceNames};
use crate::{profile, surface};

/// Reads a file that a study names, and says in words why it cannot.
pub type ReadFile<'f> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'f;

/// The files that a study has read.
#[derive(Clone, Debug, Default)]
pub(crate) struct StudyFiles {
    pub(crate) surfaces: Surfaces,
    pub(crate) names: SurfaceNames,
    /// The bytes of each file, by the name that the study gives it.
    pub(crate) bytes: BTreeMap<String, Vec<u8>>,
}

impl StudyFiles {
    /// Reads a file that a point needs, unless it is read already.
    pub(crate) fn read(
        &mut self,
        needed: NeededFile,
        files: &mut ReadFile<'_>,
    ) -> Result<(), Mistake> {
        let NeededFile { key, span, content } = needed;
        let result = match content {
            FileContent::Map { file, unit } => self.read_height_map(file, unit, files),
            FileContent::StoredMap(name) => self.read_stored_surface(name, files),
            FileContent::Profile(file) => self.read_profile(key, file, files),
        };
        result.map_err(|reason| {
            let (noun, expected) = match key {
                Key::File => ("height map", "must be an NPY file or a matrix of text"),
                Key::Surface => ("height map", "must be the hash of a stored surface"),
                Key::Wheel => ("profile", "must be a wheel's profile in SIMPACK's format (.prw)"),
                _ => ("profile", "must be a rail's profile in SIMPACK's format (.prr)"),
            };
            Mistake::new(span, format!("cannot use this {noun}: {reason}"), expected)
        })
    }

    /// Returns the bytes of a file that the study names, which is read once.
    fn file(&mut self, name: &str, files: &mut ReadFile<'_>) -> Result<&[u8], String> {
        if !self.bytes.contains_key(name) {
            self.bytes.insert(name.to_owned(), files(name)?);
        }
        Ok(self.bytes.get(name).map_or(&[], Vec::as_slice))
    }

    fn read_height_map(
        &mut self,
        file: String,
        unit: String,
        files: &mut ReadFile<'_>,
    ) -> Result<(), String> {
        if self.names.maps.contains_key(&(file.clone(), unit.clone())) {
            return Ok(());
        }
        let surface =
            surface::read(self.file(&file, files)?, &unit).map_err(|error| error.to_string())?;
        let name = surface::name(&surface);
        self.surfaces.insert(name.clone(), Arc::new(surface));
        self.names.maps.insert((file, unit), name);
        Ok(())
    }

    fn read_stored_surface(
        &mut self,
        name: String,
        files: &mut ReadFile<'_>,
    ) -> Result<(), String> {
        if self.surfaces.get(&name).is_some() {
            return Ok(());
        }
        let surface =
            surface::decode_surface(self.file(&name, files)?).map_err(|error| error.to_string())?;
        if surface::name(&surface) != name {
            return Err("its content does not have this hash".to_owned());
        }
        self.surfaces.insert(name, Arc::new(surface));
        Ok(())
    }

    fn read_profile(
        &mut self,
        key: Key,
        file: String,
        files: &mut ReadFile<'_>,
    ) -> Result<(), String> {
        if !self.names.profiles.contains_key(&file) {
            let profile =
                profile::read(self.file(&file, files)?).map_err(|error| error.to_string())?;
            let name = profile::name(&profile);
            self.surfaces.insert_profile(name.clone(), Arc::new(profile));
            self.names.profiles.insert(file.clone(), name);
        }
        let profile = self.names.profiles.get(&file).and_then(|name| self.surfaces.profile(name));
        match (key, profile.map(|profile| profile.kind())) {
            (Key::Wheel, Some(ProfileKind::Rail)) => Err("it is a rail's".to_owned()),
            (Key::Rail, Some(ProfileKind::Wheel)) => Err("it is a wheel's".to_owned()),
            _ => Ok(()),
        }
    }
}
