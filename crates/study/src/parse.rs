//! Reads a study's text and checks every point of it.

use rayon::prelude::*;
use toml::de::{DeTable, DeValue};

use crate::adaptive::{self, Adaptive};
use crate::axis::{self, Group};
use crate::error::{Mistake, StudyError};
use crate::figure;
use crate::key::{Key, Table, nearest, one_of};
use crate::kind::Kind;
use crate::read::{self, Reader, entries};
use crate::sheet::{Given, TablePlaces};
use crate::study::Study;
use crate::study_files::{ReadFile, StudyFiles};
use crate::{accuracy, sweep};

/// The names at the top of a study before those of the tables of kinds.
const KEYS: &[&str] = &[
    "name", "question", "kind", "accuracy", "scene", "numerics", "search", "sweep", "refine",
    "bisect",
];

/// Returns the names that may stand at the top of a study.
fn names() -> Vec<&'static str> {
    KEYS.iter().copied().chain(Kind::table_names()).chain(["figure"]).collect()
}

impl Study {
    /// Reads a study's text. `path` is for messages. `files` reads a file that the study names (a
    /// height map), with the name as the study writes it, or a stored surface by its hash.
    ///
    /// # Errors
    ///
    /// Returns every mistake in the text, with its place.
    pub fn parse(text: &str, path: &str, files: &mut ReadFile<'_>) -> Result<Study, StudyError> {
        parse(text, path, files).map_err(|mistakes| StudyError::new(path, text, mistakes))
    }

    /// Reads the height maps and profiles that any point needs, each once.
    fn read_surfaces(&mut self, files: &mut ReadFile<'_>) -> Vec<Mistake> {
        let names_files = |key| matches!(key, Key::File | Key::Surface | Key::Wheel | Key::Rail);
        if !axis::keys(&self.base, &self.groups).any(names_files) {
            return Vec::new();
        }
        let mut mistakes = Vec::new();
        for index in 0..self.points {
            let steps = axis::steps(&self.groups, index);
            // The files are read into the study, from which a sheet borrows. One bad file is one
            // mistake, however many points use it.
            let needed = self.sheet(&steps).needed_files();
            mistakes
                .extend(needed.into_iter().filter_map(|file| self.files.read(file, files).err()));
        }
        mistakes
    }

    /// Assembles every point. First it goes along each axis with the others at their first value,
    /// which reports each bad value once. If those are good, it goes through all points.
    fn check(&self) -> Result<(), Vec<Mistake>> {
        let mut mistakes = Vec::new();
        for (varied, group) in self.groups.iter().enumerate().filter(|(_, group)| group.length > 1)
        {
            let mut steps = vec![0; self.groups.len()];
            for step in 0..group.length {
                steps[varied] = step;
                mistakes.extend(self.job(&steps).err().into_iter().flatten());
                if mistakes.len() > 1000 {
                    break;
                }
            }
        }
        if mistakes.is_empty() {
            let check = |index| self.job(&axis::steps(&self.groups, index)).err();
            mistakes = (0..self.points).into_par_iter().find_map_first(check).unwrap_or_default();
        }
        if mistakes.is_empty() { Ok(()) } else { Err(mistakes) }
    }
}

fn parse(text: &str, path: &str, files: &mut ReadFile<'_>) -> Result<Study, Vec<Mistake>> {
    let (root, errors) = DeTable::parse_recoverable(text);
    // What follows the first error is mostly its echo.
    if let Some(error) = errors.first() {
        let expected =
            if error.message() == "duplicate key" { "may be given only once" } else { "" };
        return Err(vec![Mistake::new(
            error.span().unwrap_or(0..0),
            format!("not valid TOML: {}", error.message()),
            expected,
        )]);
    }
    let root = root.into_inner();
    let mut mistakes = Vec::new();
    let names = names();
    for (name, _) in entries(&root) {
        if !names.contains(&name.get_ref().as_ref()) {
            mistakes.push(read::unknown(name.get_ref(), name.span(), "the study", &names));
        }
    }
    let name = read_name(&root, &mut mistakes);
    let question = read_text(&root, "question", &mut mistakes).unwrap_or_default();
    let kind = read_kind(&root, &mut mistakes);
    let (mut base, places) = read_base(text, &root, &mut mistakes);
    let groups = root
        .get("sweep")
        .map(|node| sweep::read_sweep(text, node, &mut mistakes))
        .unwrap_or_default();
    let accuracy = root
        .get("accuracy")
        .and_then(|node| accuracy::read(node, kind, &base, &groups, &mut mistakes));
    base.extend(accuracy.iter().map(accuracy::Accuracy::first_mesh));
    let kind_table = kind.read_table(&root, &groups, &mut mistakes);
    let before = mistakes.len();
    sweep::refuse_absent(&groups, &base, &mut mistakes);
    if mistakes.len() > before {
        // Entries have columns, and an index that is far off would make thousands of millions of
        // them.
        return Err(mistakes);
    }
    let columns = kind.columns(groups.iter().flat_map(Group::axes), axis::keys(&base, &groups));
    let figures = match root.get("figure") {
        Some(node) => figure::read_figures(node, &groups, &columns, &mut mistakes),
        None => kind.figure(&kind_table, &groups).into_iter().collect(),
    };
    let adaptive = adaptive::read(&root, &base, &groups, &columns, &mut mistakes);
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    let mut study = Study {
        adaptive: adaptive.or(accuracy.map(Adaptive::Accuracy)),
        kind_table,
        name,
        question,
        kind,
        figures,
        points: axis::count(&groups).unwrap_or(0),
        groups,
        base,
        places,
        files: StudyFiles::default(),
        path: path.to_owned(),
        text: text.to_owned(),
    };
    let unreadable = study.read_surfaces(files);
    if !unreadable.is_empty() {
        return Err(unreadable);
    }
    study.check()?;
    Ok(study)
}

fn read_base(
    text: &str,
    root: &DeTable<'_>,
    mistakes: &mut Vec<Mistake>,
) -> (Vec<(Key, Given)>, TablePlaces) {
    let mut reader = Reader::new(text, mistakes);
    for (name, node) in entries(root) {
        match (
            Table::find(name.get_ref()).filter(|table| table.path() == name.get_ref().as_ref()),
            node.get_ref(),
        ) {
            (Some(table), DeValue::Table(below)) => {
                reader.table(table, node.span(), entries(below))
            }
            (Some(table), _) => {
                reader.mistakes.push(read::mistyped(&table.path(), node, &table.expected()));
            }
            (None, _) => {}
        }
    }
    (reader.given, reader.places)
}

fn read_text(root: &DeTable<'_>, name: &str, mistakes: &mut Vec<Mistake>) -> Option<String> {
    read::text(name, root.get(name)?).map_err(|mistake| mistakes.push(mistake)).ok()
}

fn read_name(root: &DeTable<'_>, mistakes: &mut Vec<Mistake>) -> String {
    let Some(node) = root.get("name") else {
        mistakes.push(Mistake::new(
            0..0,
            "the study has no name",
            "needs name = \"…\", under which its results are kept",
        ));
        return String::new();
    };
    let name = read_text(root, "name", mistakes).unwrap_or_default();
    if matches!(node.get_ref(), DeValue::String(_)) {
        mistakes.extend(read::refuse_file_name(&name, "a study", node));
    }
    name
}

fn read_kind(root: &DeTable<'_>, mistakes: &mut Vec<Mistake>) -> Kind {
    let (Some(name), Some(node)) = (read_text(root, "kind", mistakes), root.get("kind")) else {
        return Kind::default();
    };
    Kind::find(&name).unwrap_or_else(|| {
        let names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
        let mistake = |expected: &str| {
            Mistake::new(node.span(), format!("unknown kind of study `{name}`"), expected)
        };
        let listed = format!("must be {}", one_of(&names));
        mistakes.push(match nearest(&name, names.iter().copied()) {
            Some(suggestion) => mistake(&format!("did you mean \"{suggestion}\"?")).help(listed),
            None => mistake(&listed),
        });
        Kind::default()
    })
}
