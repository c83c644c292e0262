//! Edits the text of a study: sets keys, and turns a study of a scene into a study of what accuracy
//! costs. Everything that is not edited keeps its place, its spelling and its comments.

use toml_edit::{DocumentMut, Item, Table as TomlTable, TableLike, Value as TomlValue};

use crate::axis::SweepAxis;
use crate::error::StudyError;
use crate::key::{Key, Table};
use crate::kind::Kind;
use crate::study::Study;
use crate::study_files::ReadFile;
use crate::suggestion::nearest_path;

/// The meshes of the ladder that is made for a scene, in elements across Ω.
const LADDER_MESHES: [i64; 9] = [8, 12, 16, 24, 32, 48, 64, 96, 128];

/// The tolerances of the ladder that is made for a scene.
const LADDER_TOLERANCES: [f64; 3] = [1e-2, 1e-4, 1e-8];

/// The reason why a study's text cannot be edited.
#[derive(Debug, thiserror::Error)]
pub enum EditError {
    /// The text is no study.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The text is a study, but cannot be edited.
    #[error("{path} cannot be edited")]
    Document {
        /// The path from which the text came.
        path: String,
    },
    /// A setting cannot be made.
    #[error("--set {setting}: {reason}")]
    Setting {
        /// The setting as it was given.
        setting: String,
        /// The reason.
        reason: String,
    },
    /// The place of a setting in the text is taken by something else.
    #[error("--set {setting}: {path} has no place for it")]
    Occupied {
        /// The setting as it was given.
        setting: String,
        /// The path from which the text came.
        path: String,
        /// The obstacle.
        source: PlaceError,
    },
    /// A place that the ladder needs is taken by something else.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// The jobs of the study do not solve a scene once.
    #[error("{path}: a study of kind \"{kind}\" solves no scene whose accuracy could be priced")]
    Unpriced {
        /// The path from which the text came.
        path: String,
        /// The name of the study's kind.
        kind: &'static str,
    },
    /// The study varies more than the ladder does.
    #[error("{path} varies {axes}; fix that with --set KEY=VALUE, so that one scene is left")]
    Varies {
        /// The path from which the text came.
        path: String,
        /// The axes, separated by commas.
        axes: String,
    },
}

/// The reason why a text has no place for a key.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlaceError {
    /// Something that holds no keys stands where a table would have to stand.
    #[error("`{0}` would have to stand in a table")]
    NoTable(String),
    /// A list is missing.
    #[error("there is no `{0}`")]
    Missing(String),
    /// A list has too few entries.
    #[error("`{name}` has no entry {index}")]
    NoEntry {
        /// The name of the list.
        name: String,
        /// The index, counted from 0.
        index: usize,
    },
    /// `sweep` is no table.
    #[error("`sweep` is no table")]
    Sweep,
}

/// Returns the text of a study in which each `KEY=VALUE` of `settings` is set and no longer an
/// axis, nor derived. `path` and `files` are those of [`Study::parse`].
///
/// # Errors
///
/// Returns an error if the text is no study, if a setting is not `KEY=VALUE` with a known key, or
/// if its place in the text is taken.
pub fn with_settings(
    text: &str,
    path: &str,
    settings: &[String],
    files: &mut ReadFile<'_>,
) -> Result<String, EditError> {
    let mut document = parse(text, path, files)?;
    let axes: Vec<Key> = match document.contains_key("points") && !settings.is_empty() {
        true => Study::parse(text, path, files)?.axes().filter_map(SweepAxis::key).collect(),
        false => Vec::new(),
    };
    for setting in settings {
        let refuse = |reason: String| EditError::Setting { setting: setting.clone(), reason };
        let (name, value) = setting
            .split_once('=')
            .ok_or_else(|| refuse("must be KEY=VALUE, for example friction.mu=0.5".to_owned()))?;
        let name = name.trim();
        let key = key_of(name).ok_or_else(|| {
            refuse(match nearest_path(name) {
                // The name is that of a table or of a list.
                Some(same) if same == name => {
                    format!("`{name}` holds several keys; set one of them, or edit the file")
                }
                Some(near) => format!("there is no key `{name}`; did you mean `{near}`?"),
                None => format!("there is no key `{name}`"),
            })
        })?;
        // A value that is no TOML is a text: punch.radius=2mm, method=seidel.
        let value = value.trim();
        let value: TomlValue = value.parse().unwrap_or_else(|_| TomlValue::from(value));
        let sweep = |document: &DocumentMut| document.get("sweep").map(ToString::to_string);
        let swept = sweep(&document);
        for table in ["sweep", "derive"] {
            let Some(item) = document.get_mut(table) else { continue };
            let keys = || std::iter::once(key).chain(key.alternative());
            match item {
                Item::ArrayOfTables(blocks) => {
                    for block in blocks.iter_mut() {
                        keys().for_each(|key| remove_axis(block, key));
                    }
                    // Blocks without axes are the scene, several times over.
                    if blocks.iter().all(TomlTable::is_empty) {
                        document.remove(table);
                    }
                }
                item => {
                    if let Some(table) = item.as_table_like_mut() {
                        keys().for_each(|key| remove_axis(table, key));
                    }
                }
            }
        }
        let is_set = axes.iter().any(|axis| *axis == key || key.alternative() == Some(*axis));
        if is_set && sweep(&document) == swept {
            return Err(refuse(
                "the file of [points] gives it; leave it out of `columns`".to_owned(),
            ));
        }
        for key in std::iter::once(key).chain(key.alternative()) {
            remove_drawn(&mut document, key);
        }
        if let Some(other) = key.alternative() {
            // One of the two moduli takes the place of the other.
            unset(document.as_item_mut(), &other.path());
        }
        if key == Key::Mesh {
            // A given mesh takes the place of the accuracy.
            document.remove("accuracy");
        }
        set(document.as_item_mut(), &key.path(), value).map_err(|source| EditError::Occupied {
            setting: setting.clone(),
            path: path.to_owned(),
            source,
        })?;
    }
    Ok(document.to_string())
}

/// Returns the text of a study of what accuracy costs, for the only scene of another study, with
/// keys set as [`with_settings`] does. A study of kind "cost" keeps its ladder.
///
/// # Errors
///
/// Returns an error if [`with_settings`] does, if the study solves no scene or more than one, or if
/// a setting gives what the ladder varies.
pub fn with_cost_ladder(
    text: &str,
    path: &str,
    settings: &[String],
    files: &mut ReadFile<'_>,
) -> Result<String, EditError> {
    let study = Study::parse(text, path, files)?;
    if study.kind() == Kind::Cost {
        return with_settings(text, path, settings, files);
    }
    if study.point(0).is_none_or(|point| point.job.kind() != Kind::Solve) {
        return Err(EditError::Unpriced { path: path.to_owned(), kind: study.kind().name() });
    }
    let mut document = parse(text, path, files)?;
    // The scene is chosen, and the ladder has points of its own.
    for table in ["figure", "refine", "bisect", "find", "fill", "branch", "exclude", "keep", "kind"]
        .into_iter()
        .chain(Kind::tables().map(|table| table.path))
    {
        document.remove(table);
    }
    if document.remove("accuracy").is_some() {
        set(document.as_item_mut(), &Key::Mesh.path(), LADDER_MESHES[0].into())?;
    }
    for (key, value) in
        [(Key::Mesh, LADDER_MESHES[0].into()), (Key::Tolerance, LADDER_TOLERANCES[0].into())]
    {
        if remove_derived(&mut document, key) {
            set(document.as_item_mut(), &key.path(), value)?;
        }
    }
    document["name"] = toml_edit::value(format!("{}-cost", study.name()));
    // The ladder does not answer the question of the study that it is made from.
    document["question"] =
        toml_edit::value(format!("What does accuracy cost in the scene of {}?", study.name()));
    let is_rung = |setting: &&String| {
        let name = setting.split('=').next().unwrap_or_default().trim();
        matches!(key_of(name), Some(Key::Mesh | Key::Tolerance))
    };
    if let Some(setting) = settings.iter().find(is_rung) {
        return Err(EditError::Setting {
            setting: setting.clone(),
            reason: "the ladder has meshes and tolerances of its own; a study of kind \"cost\" \
                     can have others"
                .to_owned(),
        });
    }
    let text = with_settings(&document.to_string(), path, settings, files)?;
    let study = Study::parse(&text, path, files)?;
    let axes: Vec<String> = study
        .axes()
        .filter(|axis| !matches!(axis.key(), Some(Key::Mesh | Key::Tolerance)))
        .map(|axis| axis.path().into_owned())
        .collect();
    if !axes.is_empty() {
        return Err(EditError::Varies { path: path.to_owned(), axes: axes.join(", ") });
    }
    let mut document = parse(&text, path, files)?;
    document["kind"] = toml_edit::value("cost");
    for key in [Key::Mesh, Key::Tolerance] {
        if let Some(sweep) = document.get_mut("sweep").and_then(Item::as_table_like_mut) {
            remove_axis(sweep, key);
        }
    }
    if document.get("sweep").is_none() {
        document["sweep"] = Item::Table(TomlTable::new());
    }
    let sweep = document["sweep"].as_table_like_mut().ok_or(PlaceError::Sweep)?;
    let meshes: toml_edit::Array = LADDER_MESHES.into_iter().collect();
    sweep.insert("mesh", Item::Value(meshes.into()));
    let tolerances: toml_edit::Array = LADDER_TOLERANCES.into_iter().collect();
    sweep.insert("tolerance", Item::Value(tolerances.into()));
    Ok(document.to_string())
}

/// Parses a text that is to be edited.
fn parse(text: &str, path: &str, files: &mut ReadFile<'_>) -> Result<DocumentMut, EditError> {
    if let Ok(document) = text.parse() {
        return Ok(document);
    }
    // The study's reader says what is wrong, with its place.
    Study::parse(text, path, files)?;
    Err(EditError::Document { path: path.to_owned() })
}

/// Returns the key with this path or column.
fn key_of(name: &str) -> Option<Key> {
    Key::find(name).or_else(|| Key::of_column(name))
}

/// Removes a key, and everything inside it, from the axes. The key may be spelled as one name or as
/// nested tables, by itself or in a group.
fn remove_axis(sweep: &mut dyn TableLike, key: Key) {
    remove_from(sweep, "", key);
    let is_emptied = match sweep.get_mut("zip") {
        Some(Item::ArrayOfTables(groups)) => {
            groups.iter_mut().for_each(|group| remove_from(group, "", key));
            groups.retain(|group| !group.is_empty());
            groups.is_empty()
        }
        Some(Item::Value(TomlValue::Array(groups))) => {
            groups
                .iter_mut()
                .filter_map(TomlValue::as_inline_table_mut)
                .for_each(|group| remove_from(group, "", key));
            groups.retain(|group| group.as_inline_table().is_none_or(|group| !group.is_empty()));
            groups.is_empty()
        }
        _ => false,
    };
    if is_emptied {
        sweep.remove("zip");
    }
}

/// Removes a key from those that are derived, and returns whether it was one of them.
fn remove_derived(document: &mut DocumentMut, key: Key) -> bool {
    let text = |document: &DocumentMut| document.get("derive").map(ToString::to_string);
    let before = text(document);
    if let Some(derive) = document.get_mut("derive").and_then(Item::as_table_like_mut) {
        remove_from(derive, "", key);
    }
    text(document) != before
}

/// Removes a key from those that a sample draws, and a sample that draws nothing else. A study of
/// sensitivity is about what is drawn, and solves what is left.
fn remove_drawn(document: &mut DocumentMut, key: Key) {
    let Some(sample) = document.get_mut("sample").and_then(Item::as_table_like_mut) else { return };
    let Some(keys) = sample.get_mut("keys").and_then(Item::as_table_like_mut) else { return };
    remove_from(keys, "", key);
    if !keys.is_empty() {
        return;
    }
    document.remove("sample");
    if document.get("kind").and_then(Item::as_str) == Some(Kind::Sensitivity.name()) {
        let name = Kind::Sensitivity.name();
        document.remove("kind");
        document.remove(name);
        remove_figures(document, name);
    }
}

/// Removes the figures of a kind.
fn remove_figures(document: &mut DocumentMut, kind: &str) {
    let is_of_kind = |figure: &dyn TableLike| {
        figure.get("kind").and_then(Item::as_str).is_some_and(|found| found == kind)
    };
    let is_emptied = match document.get_mut("figure") {
        Some(Item::ArrayOfTables(figures)) => {
            figures.retain(|figure| !is_of_kind(figure));
            figures.is_empty()
        }
        Some(figure) => figure.as_table_like().is_some_and(is_of_kind),
        None => false,
    };
    if is_emptied {
        document.remove("figure");
    }
}

/// Removes a key, and everything inside it, from a table that stands at the path `prefix`.
fn remove_from(table: &mut dyn TableLike, prefix: &str, key: Key) {
    let names: Vec<String> = table.iter().map(|(name, _)| name.to_owned()).collect();
    for name in names {
        let path = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
        if is_inside(&path, key) {
            table.remove(&name);
        } else if let Some(inner) = table.get_mut(&name).and_then(Item::as_table_like_mut) {
            remove_from(inner, &path, key);
            if inner.is_empty() {
                table.remove(&name);
            }
        }
    }
}

/// Returns whether a path leads to a key or into it: lists and the base of a foundation are tables
/// as well.
fn is_inside(path: &str, key: Key) -> bool {
    let is_under = |table: &Table| {
        Key::find(path).is_some_and(|key| key.is_under(table))
            || Table::find(path).is_some_and(|inner| inner.is_under(table))
    };
    Key::find(path) == Some(key) || Table::find(&key.path()).as_ref().is_some_and(is_under)
}

/// Sets a path such as `scene.loading.steps[0].approach` below `root`.
fn set(root: &mut Item, path: &str, value: TomlValue) -> Result<(), PlaceError> {
    let mut item = root;
    let mut segments = path.split('.').peekable();
    while let Some(segment) = segments.next() {
        let (name, index) = split_index(segment);
        let table = item.as_table_like_mut().ok_or_else(|| PlaceError::NoTable(name.to_owned()))?;
        if segments.peek().is_none() && index.is_none() {
            table.insert(name, Item::Value(value));
            return Ok(());
        }
        let missing = || PlaceError::Missing(name.to_owned());
        if !table.contains_key(name) {
            if index.is_some() {
                return Err(missing());
            }
            // An inline table has no room for a standard one.
            let implied = Item::Table(TomlTable::new());
            table.insert(name, implied.into_value().map_or_else(|item| item, Item::Value));
        }
        item = table.get_mut(name).ok_or_else(missing)?;
        if let Some(index) = index {
            let no_entry = || PlaceError::NoEntry { name: name.to_owned(), index };
            item = item.get_mut(index).ok_or_else(no_entry)?;
        }
    }
    Ok(())
}

/// Removes what stands at a path such as `scene.foundation.layers[0].poisson` below `root`, if
/// anything does.
fn unset(root: &mut Item, path: &str) -> Option<Item> {
    let (front, last) = path.rsplit_once('.')?;
    let mut item = root;
    for segment in front.split('.') {
        let (name, index) = split_index(segment);
        item = item.as_table_like_mut()?.get_mut(name)?;
        if let Some(index) = index {
            item = item.get_mut(index)?;
        }
    }
    item.as_table_like_mut()?.remove(last)
}

/// Splits `steps[0]` into `steps` and 0.
fn split_index(segment: &str) -> (&str, Option<usize>) {
    let indexed = segment.strip_suffix(']').and_then(|segment| segment.split_once('['));
    match indexed.and_then(|(name, index)| Some((name, index.parse().ok()?))) {
        Some((name, index)) => (name, Some(index)),
        None => (segment, None),
    }
}
