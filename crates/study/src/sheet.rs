//! A sheet, which holds the value that is given for every [`Key`], and its place. The base and the
//! axes fill the sheet of each point. A job is [assembled](crate::assemble) from a sheet, so that
//! every complaint about a job can point at the text that caused it.

use std::borrow::Cow;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use contact::model::{Effect, Mesh};

use crate::error::Span;
use crate::key::{Key, Table};
use crate::surface::{MapExtent, MissingRule};
use crate::units::Compact;
use crate::value::Value;

/// A value of the type that its key's [`Quantity`](crate::key::Quantity) calls for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Setting {
    /// A number in SI units.
    Number(f64),
    Count(u32),
    Mesh(Mesh),
    Word(String),
    Flag(bool),
    /// Effects in their order, each once.
    Effects(Vec<Effect>),
    /// Lengths in metres.
    Lengths(Vec<f64>),
    /// Places in metres.
    Places(Vec<[f64; 3]>),
}

impl std::fmt::Display for Setting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Setting::Number(x) => write!(f, "{}", Compact(*x)),
            Setting::Count(n) | Setting::Mesh(Mesh::Across(n)) => write!(f, "{n}"),
            Setting::Mesh(Mesh::Exact([x, y])) => write!(f, "[{x}, {y}]"),
            Setting::Word(word) => write!(f, "\"{word}\""),
            Setting::Flag(yes) => write!(f, "{yes}"),
            Setting::Effects(effects) => {
                let names: Vec<String> =
                    effects.iter().map(|effect| format!("\"{}\"", effect.name())).collect();
                write!(f, "[{}]", names.join(", "))
            }
            Setting::Lengths(lengths) => write!(f, "{}", listed(lengths)),
            Setting::Places(places) => {
                let places: Vec<String> = places.iter().map(|place| listed(place)).collect();
                write!(f, "[{}]", places.join(", "))
            }
        }
    }
}

/// Writes numbers as a list.
fn listed(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(|x| Compact(*x).to_string()).collect();
    format!("[{}]", numbers.join(", "))
}

impl From<&Setting> for Value {
    fn from(setting: &Setting) -> Self {
        match setting {
            Setting::Number(x) => Value::Number(*x),
            Setting::Count(n) | Setting::Mesh(Mesh::Across(n)) => Value::Integer(u64::from(*n)),
            Setting::Mesh(Mesh::Exact([x, y])) => Value::Text(format!("{x}x{y}")),
            Setting::Word(word) => Value::Text(word.clone()),
            Setting::Flag(yes) => Value::Flag(*yes),
            Setting::Lengths(_) | Setting::Places(_) => Value::Text(setting.to_string()),
            Setting::Effects(effects) if effects.is_empty() => Value::Missing,
            Setting::Effects(effects) => Value::Text(
                effects.iter().map(|effect| effect.name()).collect::<Vec<_>>().join(" "),
            ),
        }
    }
}

/// A value and the place where it was given.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Given {
    pub(crate) setting: Setting,
    pub(crate) span: Span,
    /// The number of the value, counted from 1, if it is one of a range.
    pub(crate) nth: Option<usize>,
}

/// The value that was given for each key: one that stands in the file is borrowed from the base or
/// an axis, and one that was computed for the point belongs to its sheet.
#[derive(Clone, Default)]
pub(crate) struct Sheet<'a>(HashMap<Key, Cow<'a, Given>, BuildHasherDefault<KeyHasher>>);

/// A hasher of keys, which are small numbers that no one chooses: the multiplication of Fx. A sheet
/// is filled for every point.
#[derive(Clone, Default)]
struct KeyHasher(u64);

impl Hasher for KeyHasher {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u64(u64::from(*byte)));
    }

    fn write_u32(&mut self, number: u32) {
        self.write_u64(u64::from(number));
    }

    fn write_isize(&mut self, number: isize) {
        self.write_u64(number as u64);
    }

    fn write_u64(&mut self, number: u64) {
        self.0 = (self.0.rotate_left(5) ^ number).wrapping_mul(0x517c_c1b7_2722_0a95);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

/// The surfaces that were read from files.
#[derive(Clone, Debug, Default)]
pub(crate) struct SurfaceNames {
    /// The height maps, by file and the way to read it.
    pub(crate) maps: HashMap<MapFile, NamedMap>,
    /// The names of profiles, by file name and kind.
    pub(crate) profiles: HashMap<ProfileFile, String>,
}

/// A file of heights, and what a point says about it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct MapFile {
    pub(crate) file: String,
    pub(crate) unit: Option<String>,
    pub(crate) lateral_unit: Option<String>,
    pub(crate) missing: MissingRule,
    /// The bits of the number that marks a missing pixel.
    pub(crate) missing_value: Option<u64>,
}

/// A height map that was read.
#[derive(Clone, Debug)]
pub(crate) struct NamedMap {
    /// The name of the surface.
    pub(crate) name: String,
    /// The extents along x and y that the file states.
    pub(crate) extents: [Option<MapExtent>; 2],
    /// The height of the highest pixel above the lowest one \[m\].
    pub(crate) relief: f64,
}

/// A file with a profile, and the body whose profile it must be.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ProfileFile {
    pub(crate) file: String,
    pub(crate) is_wheel: bool,
}

/// A file that a point needs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NeededFile {
    /// The key that names the file.
    pub(crate) key: Key,
    /// The place where the key is given.
    pub(crate) span: Span,
    pub(crate) content: FileContent,
}

/// The content that a file must have.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum FileContent {
    /// A height map.
    Map(MapFile),
    /// A stored height map of this name.
    StoredMap(String),
    /// A profile, or a stored one.
    Profile(ProfileFile),
}

impl<'a> Sheet<'a> {
    pub(crate) fn new(given: impl IntoIterator<Item = (Key, &'a Given)>) -> Self {
        Sheet(given.into_iter().map(|(key, given)| (key, Cow::Borrowed(given))).collect())
    }

    pub(crate) fn set(&mut self, key: Key, given: Cow<'a, Given>) {
        self.0.insert(key, given);
    }

    /// Removes everything that stands in a table.
    pub(crate) fn clear(&mut self, table: &Table) {
        self.0.retain(|key, _| !key.is_under(table));
    }

    /// Returns those keys that are given for which something holds, by their places.
    pub(crate) fn keys(&self, is_meant: impl Fn(Key) -> bool) -> Vec<Key> {
        let meant = self.0.iter().filter(|(key, _)| is_meant(**key));
        let mut given: Vec<(usize, Key)> =
            meant.map(|(key, given)| (given.span.start, *key)).collect();
        given.sort_by_cached_key(|(start, key)| (*start, key.path()));
        given.into_iter().map(|(_, key)| key).collect()
    }

    pub(crate) fn get(&self, key: Key) -> Option<&Given> {
        self.0.get(&key).map(Cow::as_ref)
    }

    /// Returns the length of [`Key::Layers`] or [`Key::Steps`]: the one that was given, else the
    /// one with which every key has its entry.
    pub(crate) fn length(&self, list: Key) -> u32 {
        match self.count(list) {
            Some(length) => length,
            None => {
                let indices = self
                    .0
                    .keys()
                    .filter(|key| key.list() == Some(list))
                    .filter_map(|key| key.index());
                indices.max().map_or(0, |index| index.saturating_add(1))
            }
        }
    }

    pub(crate) fn count(&self, key: Key) -> Option<u32> {
        match self.get(key)?.setting {
            Setting::Count(n) => Some(n),
            _ => None,
        }
    }

    pub(crate) fn word(&self, key: Key) -> Option<&str> {
        match &self.get(key)?.setting {
            Setting::Word(word) => Some(word),
            _ => None,
        }
    }

    pub(crate) fn flag(&self, key: Key) -> Option<bool> {
        match self.get(key)?.setting {
            Setting::Flag(yes) => Some(yes),
            _ => None,
        }
    }

    pub(crate) fn number(&self, key: Key) -> Option<f64> {
        match self.get(key)?.setting {
            Setting::Number(x) => Some(x),
            _ => None,
        }
    }

    /// Returns the files that the punch needs.
    pub(crate) fn needed_files(&self) -> Vec<NeededFile> {
        let needed = |key, content: &dyn Fn(String) -> FileContent| {
            let span = self.get(key)?.span.clone();
            Some(NeededFile { key, span, content: content(self.word(key)?.to_owned()) })
        };
        let files = match self.word(Key::Shape) {
            Some("height-map") => {
                let stored = || needed(Key::Surface, &FileContent::StoredMap);
                [needed(Key::File, &|file| self.map(file)).or_else(stored), None]
            }
            Some("wheel-on-rail") => {
                [(Key::Wheel, true), (Key::Rail, false)].map(|(key, is_wheel)| {
                    needed(key, &|file| FileContent::Profile(ProfileFile { file, is_wheel }))
                })
            }
            _ => [None, None],
        };
        files.into_iter().flatten().collect()
    }

    fn map(&self, file: String) -> FileContent {
        let word = |key| self.word(key).map(str::to_owned);
        FileContent::Map(MapFile {
            file,
            unit: word(Key::HeightUnit),
            lateral_unit: word(Key::LateralUnit),
            missing: match self.word(Key::Missing) {
                Some("fill") => MissingRule::Fill,
                Some("exclude") => MissingRule::Exclude,
                Some("none") => MissingRule::Keep,
                _ => MissingRule::Refuse,
            },
            missing_value: self.number(Key::MissingValue).map(f64::to_bits),
        })
    }
}

/// The places of the tables of a file, for keys that are missing from them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct TablePlaces(HashMap<Table, Span>);

impl TablePlaces {
    pub(crate) fn add(&mut self, table: Table, span: Span) {
        self.0.entry(table).or_insert(span);
    }

    /// Returns whether the file has begun the table.
    pub(crate) fn has(&self, table: &Table) -> bool {
        self.0.contains_key(table)
    }

    /// Returns the place of the innermost table in the file that holds the key, else the start of
    /// the file.
    pub(crate) fn around(&self, key: Key) -> Span {
        let innermost = self
            .0
            .iter()
            .filter(|(table, _)| key.is_under(table))
            .max_by_key(|(table, _)| table.pattern.len());
        innermost.map_or(0..0, |(_, span)| span.clone())
    }
}
