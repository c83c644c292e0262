//! Reads a parsed TOML tree, which still knows its places, into typed settings.

use std::borrow::Cow;

use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

use contact::model::{Effect, Mesh};

use crate::bounds::Bounds;
use crate::error::{Mistake, Span, are_enough};
use crate::key::{Key, Table};
use crate::quantity::{Quantity, one_of};
use crate::sheet::{Given, Setting, TablePlaces};
use crate::suggestion::{nearest, standing_elsewhere};
use crate::units::{Dimension, QuantityError, quantity};

/// A value of the tree with its place.
pub(crate) type Node<'i> = Spanned<DeValue<'i>>;

/// A key of the tree with its place.
pub(crate) type Name<'i> = Spanned<Cow<'i, str>>;

/// Returns the entries of a table in the order of the file.
pub(crate) fn entries<'t, 'i>(table: &'t DeTable<'i>) -> Vec<(&'t Name<'i>, &'t Node<'i>)> {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    entries
}

/// Returns the type of a value with its article, for messages.
pub(crate) fn noun(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

/// Notes the keys of a table that are not among those `known`.
pub(crate) fn refuse_unknown(
    table: &DeTable<'_>,
    place: &str,
    known: &[&str],
    mistakes: &mut Vec<Mistake>,
) {
    let is_unknown = |(name, _): &(&Name<'_>, _)| !known.contains(&name.get_ref().as_ref());
    for (name, _) in entries(table).into_iter().filter(is_unknown) {
        if are_enough(mistakes) {
            return;
        }
        mistakes.push(unknown(name.get_ref(), name.span(), place, known));
    }
}

/// Makes the mistake of an unknown key, with the key that was probably meant.
pub(crate) fn unknown(name: &str, span: Span, place: &str, known: &[&str]) -> Mistake {
    let listed = known.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let mistake = |expected: String| {
        Mistake::new(span.clone(), format!("unknown key `{name}` in {place}"), expected)
    };
    match nearest(name, known.iter().copied()) {
        Some(suggestion) => mistake(format!("did you mean `{suggestion}`?"))
            .help(format!("the keys here are {listed}")),
        None => mistake(format!("the keys here are {listed}")),
    }
}

/// Makes the mistake of a value of the wrong type.
pub(crate) fn mistyped(name: &str, node: &Node<'_>, expected: &str) -> Mistake {
    Mistake::new(
        node.span(),
        format!("`{name}` cannot be {}", noun(node.get_ref())),
        format!("must be {expected}"),
    )
}

/// Reads every key below a table. Whatever cannot be read is a mistake, and is left out.
pub(crate) struct Reader<'p> {
    text: &'p str,
    pub(crate) given: Vec<(Key, Given)>,
    pub(crate) places: TablePlaces,
    pub(crate) mistakes: &'p mut Vec<Mistake>,
}

impl<'p> Reader<'p> {
    pub(crate) fn new(text: &'p str, mistakes: &'p mut Vec<Mistake>) -> Self {
        Reader { text, given: Vec::new(), places: TablePlaces::default(), mistakes }
    }

    /// Reads `entries`, which stand in `table`, at `span`.
    pub(crate) fn table<'t, 'i: 't>(
        &mut self,
        table: Table,
        span: Span,
        entries: impl IntoIterator<Item = (&'t Name<'i>, &'t Node<'i>)>,
    ) {
        // A table that only the dots of its keys imply has no place.
        if self.text.get(span.clone()).is_some_and(|written| written.starts_with(['[', '{'])) {
            self.places.add(table, span);
        }
        for (name, node) in entries {
            if are_enough(self.mistakes) {
                return;
            }
            let path = format!("{}.{}", table.path(), name.get_ref());
            // An index is no part of a name.
            let (inner, key) = if name.get_ref().contains('[') {
                (None, None)
            } else {
                (Table::find(&path), Key::find(&path))
            };
            match (inner, key, node.get_ref()) {
                (Some(inner), Some(list), _) if inner.is_list() => self.list(list, node),
                (Some(inner), _, DeValue::Table(below)) => {
                    self.table(inner, node.span(), self::entries(below))
                }
                (Some(_), Some(key), DeValue::String(_)) | (None, Some(key), _) => {
                    self.key(key, node)
                }
                (Some(inner), ..) => {
                    self.mistakes.push(mistyped(&inner.short(), node, &inner.expected()))
                }
                (None, None, _) => self.unknown(table, name),
            }
        }
    }

    /// Notes a key that the table does not have.
    fn unknown(&mut self, table: Table, name: &Name<'_>) {
        let place = format!("`{}`", table.path());
        let word = name.get_ref().as_ref();
        let mistake = unknown(word, name.span(), &place, &table.names());
        self.mistakes.push(match word {
            top @ ("accuracy" | "sample" | "refine" | "bisect" | "find" | "fill" | "branch") => {
                mistake.help(format!("`{top}` stands at the top of the study"))
            }
            _ => match standing_elsewhere(word, table.pattern) {
                // A name that is near in this table was suggested already.
                Some(path) if mistake.help.is_empty() => mistake.instead(&path),
                _ => mistake,
            },
        });
    }

    /// Reads the value of a key.
    pub(crate) fn key(&mut self, key: Key, node: &Node<'_>) {
        match setting(key, node) {
            Ok(setting) => self.given.push((key, Given { setting, span: node.span(), nth: None })),
            Err(mistake) => self.mistakes.push(mistake),
        }
    }

    /// Reads a list of tables, [`Key::Layers`] or [`Key::Steps`]; its length counts as a key of its
    /// own.
    pub(crate) fn list(&mut self, list: Key, node: &Node<'_>) {
        let DeValue::Array(tables) = node.get_ref() else {
            return self.mistakes.push(mistyped(&list.short(), node, &list.quantity().expected()));
        };
        let length = u32::try_from(tables.len()).unwrap_or(u32::MAX);
        self.given
            .push((list, Given { setting: Setting::Count(length), span: node.span(), nth: None }));
        if length > list.longest() {
            // Nothing in a list that is too long is looked at.
            let name = list.name();
            return self.mistakes.push(Mistake::new(
                node.span(),
                format!("`{}` has {length} {name}", list.short()),
                format!("must be at most {} {name}", list.longest()),
            ));
        }
        for (index, entry) in (0..length).zip(tables.iter()) {
            let Some(table) = Table::entry(list, index) else { continue };
            match entry.get_ref() {
                DeValue::Table(below) => self.table(table, entry.span(), entries(below)),
                _ => self.mistakes.push(mistyped(&table.short(), entry, &table.expected())),
            }
        }
    }
}

/// Reads a key's value.
pub(crate) fn setting(key: Key, node: &Node<'_>) -> Result<Setting, Mistake> {
    let wrong = || mistyped(&key.short(), node, &key.quantity().expected());
    match key.quantity() {
        // Lists are read as a whole, by the reader.
        Quantity::List(_) => Err(wrong()),
        Quantity::Number(dimension) => number(&key.short(), dimension, node).map(Setting::Number),
        Quantity::Count => match node.get_ref() {
            DeValue::Integer(n) => whole(&key.short(), n, node.span()).map(Setting::Count),
            DeValue::Float(x) => Err(fraction(&key.short(), x.as_str(), node.span())),
            _ => Err(wrong()),
        },
        Quantity::Mesh => mesh(key, node).map(Setting::Mesh),
        Quantity::Choice(words) => match node.get_ref() {
            DeValue::String(word) if words.contains(&word.as_ref()) => {
                Ok(Setting::Word(word.to_string()))
            }
            DeValue::String(word) => {
                Err(unknown_word(key.name(), word, node.span(), words, &key.expected()))
            }
            _ => Err(wrong()),
        },
        Quantity::Flag => switch(&key.short(), node).map(Setting::Flag),
        Quantity::Effects => match node.get_ref() {
            DeValue::Array(names) => {
                let mut effects =
                    names.iter().map(|name| effect(key, name)).collect::<Result<Vec<_>, _>>()?;
                effects.sort();
                effects.dedup();
                Ok(Setting::Effects(effects))
            }
            _ => Err(wrong()),
        },
        Quantity::Lengths => match node.get_ref() {
            DeValue::Array(lengths) => lengths_of(key, lengths.iter()).map(Setting::Lengths),
            _ => Err(wrong()),
        },
        Quantity::Places => match node.get_ref() {
            DeValue::Array(places) => places
                .iter()
                .map(|place| place_of(key, place))
                .collect::<Result<_, _>>()
                .map(Setting::Places),
            _ => Err(wrong()),
        },
        Quantity::Text => match node.get_ref() {
            DeValue::String(text) if text.chars().nth(LONGEST_TEXT).is_some() => {
                Err(too_long(&key.short(), node))
            }
            DeValue::String(text) if !text.trim().is_empty() => Ok(Setting::Word(text.to_string())),
            DeValue::String(_) => Err(Mistake::new(
                node.span(),
                format!("`{}` is empty", key.short()),
                format!("the {}", key.meaning()),
            )),
            _ => Err(wrong()),
        },
        Quantity::LengthUnit => match node.get_ref() {
            DeValue::String(unit) if crate::units::LengthUnit::find(unit).is_some() => {
                Ok(Setting::Word(unit.to_string()))
            }
            DeValue::String(unit) => {
                let expected = format!("must be {}", key.quantity().expected());
                Err(Mistake::new(
                    node.span(),
                    format!("`{unit}` is not a unit of length"),
                    expected,
                ))
            }
            _ => Err(wrong()),
        },
    }
}

/// Reads a number of elements across Ω, or a pair of numbers of elements along the sides.
fn mesh(key: Key, node: &Node<'_>) -> Result<Mesh, Mistake> {
    let wrong = || mistyped(&key.short(), node, &key.quantity().expected());
    let elements = |side: &Node<'_>| match side.get_ref() {
        DeValue::Integer(n) => whole(&key.short(), n, side.span()),
        DeValue::Float(x) => Err(fraction(&key.short(), x.as_str(), side.span())),
        _ => Err(wrong()),
    };
    let DeValue::Array(sides) = node.get_ref() else { return elements(node).map(Mesh::Across) };
    let sides: Vec<u32> = sides.iter().map(elements).collect::<Result<_, _>>()?;
    match sides[..] {
        [x, y] => Ok(Mesh::Exact([x, y])),
        _ => {
            let message = format!("`{}` is a list of {}", key.short(), sides.len());
            let expected = format!("must be {}", key.quantity().expected());
            Err(Mistake::new(node.span(), message, expected))
        }
    }
}

/// Reads lengths.
fn lengths_of<'t, 'i: 't>(
    key: Key,
    nodes: impl Iterator<Item = &'t Node<'i>>,
) -> Result<Vec<f64>, Mistake> {
    nodes.map(|node| number(&key.short(), Dimension::Length, node)).collect()
}

/// Reads a place of three coordinates.
fn place_of(key: Key, node: &Node<'_>) -> Result<[f64; 3], Mistake> {
    let DeValue::Array(coordinates) = node.get_ref() else {
        return Err(mistyped(&key.short(), node, &key.quantity().expected()));
    };
    let coordinates = lengths_of(key, coordinates.iter())?;
    let count = coordinates.len();
    coordinates.try_into().map_err(|_| {
        let message = format!("a point of `{}` has {count} coordinates", key.short());
        Mistake::new(node.span(), message, "must have three: [x, y, z], with z into the foundation")
    })
}

/// Reads the name of an effect. The scene's numerics decide whether it can be simulated.
fn effect(key: Key, node: &Node<'_>) -> Result<Effect, Mistake> {
    let DeValue::String(name) = node.get_ref() else {
        return Err(mistyped(&key.short(), node, &key.quantity().expected()));
    };
    let optional = Effect::OPTIONAL.map(Effect::name);
    let known = Effect::ALL.into_iter().find(|effect| effect.name() == name.as_ref());
    known.ok_or_else(|| unknown_word("effect", name, node.span(), &optional, &one_of(&optional)))
}

/// Makes the mistake of a word that is not among those known, with the word that was probably
/// meant.
fn unknown_word(name: &str, word: &str, span: Span, known: &[&str], expected: &str) -> Mistake {
    let mistake =
        |expected: String| Mistake::new(span, format!("unknown {name} `{word}`"), expected);
    let expected = format!("must be {expected}");
    match nearest(word, known.iter().copied()) {
        Some(suggestion) => mistake(format!("did you mean \"{suggestion}\"?")).help(expected),
        None => mistake(expected),
    }
}

/// Reads a number in SI units or a text with a unit.
pub(crate) fn number(name: &str, dimension: Dimension, node: &Node<'_>) -> Result<f64, Mistake> {
    let expected = || format!("must be {}", Quantity::Number(dimension).expected());
    let bare = match node.get_ref() {
        DeValue::Integer(n) if n.radix() == 10 => n.as_str().parse::<f64>().ok(),
        DeValue::Integer(n) => u64::from_str_radix(n.as_str(), n.radix()).ok().map(|n| n as f64),
        DeValue::Float(x) => x.as_str().parse::<f64>().ok(),
        DeValue::String(text) => {
            return quantity(text, dimension)
                .map_err(|error| not_a_quantity(name, dimension, error, node.span()));
        }
        _ => return Err(mistyped(name, node, &Quantity::Number(dimension).expected())),
    };
    // −0 becomes 0, so that the two are one job.
    bare.filter(|x| x.is_finite()).map(|x| x + 0.0).ok_or_else(|| {
        Mistake::new(node.span(), format!("`{name}` is not a finite number"), expected())
    })
}

fn not_a_quantity(name: &str, dimension: Dimension, error: QuantityError, span: Span) -> Mistake {
    let message = format!("`{name}`: {error}");
    let units =
        || dimension.units().map(|unit| format!("\"{unit}\"")).collect::<Vec<_>>().join(", ");
    if dimension == Dimension::Pure {
        let expected = match error {
            QuantityError::NoUnit { .. } => "must be a number, without quotes",
            _ => "must be a number without unit, and without quotes",
        };
        return Mistake::new(span, message, expected);
    }
    match error {
        QuantityError::UnknownUnit { nearest: Some(nearest), .. } => Mistake::new(
            span,
            message,
            format!("did you mean \"{nearest}\"?"),
        )
        .help(format!("units of {} are {}", dimension.noun(), units())),
        QuantityError::Comma { .. } => {
            Mistake::new(span, message, "write a point before decimals, and nothing in thousands")
        }
        QuantityError::NoUnit { text } => {
            let expected =
                format!("write \"{text} {}\", or {text} without quotes for {0}", dimension.unit());
            Mistake::new(span, message, expected).help(format!(
                "units of {} are {}",
                dimension.noun(),
                units()
            ))
        }
        _ => Mistake::new(
            span,
            message,
            format!("must be {}", Quantity::Number(dimension).expected()),
        )
        .help(format!("units of {} are {}", dimension.noun(), units())),
    }
}

/// Reads a whole number that counts something.
pub(crate) fn whole(name: &str, n: &DeInteger<'_>, span: Span) -> Result<u32, Mistake> {
    u32::from_str_radix(n.as_str(), n.radix()).map_err(|_| {
        let message = format!("`{name}` = {n} cannot count anything");
        Mistake::new(span, message, format!("must be a whole number from 0 to {}", u32::MAX))
    })
}

/// Reads a whole number within some bounds. Messages say what it counts, unless `counted` is empty.
pub(crate) fn count(
    name: &str,
    counted: &str,
    bounds: Bounds,
    node: &Node<'_>,
) -> Result<u32, Mistake> {
    let DeValue::Integer(n) = node.get_ref() else {
        let of = if counted.is_empty() { "" } else { " of " };
        return Err(mistyped(name, node, &format!("a whole number{of}{counted}")));
    };
    match whole(name, n, node.span())? {
        n if bounds.hold(f64::from(n)) => Ok(n),
        n => {
            let message = format!("`{name}` cannot be {n}");
            let expected = format!("must be {} {counted}", bounds.words(""));
            Err(Mistake::new(node.span(), message, expected.trim_end()))
        }
    }
}

fn fraction(name: &str, text: &str, span: Span) -> Mistake {
    Mistake::new(
        span,
        format!("`{name}` = {text} is not a whole number"),
        "must be a whole number, without a decimal point",
    )
}

/// The length of the longest text, in characters.
const LONGEST_TEXT: usize = 2000;

/// Reads a text.
pub(crate) fn text(name: &str, node: &Node<'_>) -> Result<String, Mistake> {
    match node.get_ref() {
        DeValue::String(text) if text.chars().nth(LONGEST_TEXT).is_some() => {
            Err(too_long(name, node))
        }
        DeValue::String(text) => Ok(text.to_string()),
        _ => Err(mistyped(name, node, "a text")),
    }
}

/// Reads the text of a condition, whose length the condition itself bounds.
pub(crate) fn condition(name: &str, node: &Node<'_>) -> Result<String, Mistake> {
    match node.get_ref() {
        DeValue::String(text) => Ok(text.to_string()),
        _ => Err(mistyped(name, node, "a text")),
    }
}

/// Makes the mistake of a text that is too long.
fn too_long(name: &str, node: &Node<'_>) -> Mistake {
    let message = format!("`{name}` is a text of more than {LONGEST_TEXT} characters");
    Mistake::new(node.span(), message, "must be shorter")
}

/// Reads true or false.
pub(crate) fn switch(name: &str, node: &Node<'_>) -> Result<bool, Mistake> {
    match node.get_ref() {
        DeValue::Boolean(yes) => Ok(*yes),
        _ => Err(mistyped(name, node, "true or false")),
    }
}

/// Reads a number between 0 and 1: `"0.1%"` or `0.001`.
pub(crate) fn proportion(name: &str, node: &Node<'_>) -> Result<f64, Mistake> {
    const EXPECTED: &str = "must be a part like \"0.1%\" or 0.001, above 0 and below 1";
    let value = match node.get_ref() {
        DeValue::String(text) => text
            .trim()
            .strip_suffix('%')
            .and_then(|number| number.trim().parse::<f64>().ok())
            .map(|x| x / 100.0),
        DeValue::Float(x) => x.as_str().parse::<f64>().ok(),
        DeValue::Integer(n) => n.as_str().parse::<f64>().ok(),
        _ => None,
    };
    value
        .filter(|x| *x > 0.0 && *x < 1.0)
        .ok_or_else(|| Mistake::new(node.span(), format!("`{name}` is no such part"), EXPECTED))
}

/// Makes the mistake of a name that is not fit for a file; `None` if it is fit. `owner` is what the
/// name is for, with its article.
pub(crate) fn refuse_file_name(name: &str, owner: &str, node: &Node<'_>) -> Option<Mistake> {
    let legal = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    let is_name = name.starts_with(|c: char| c.is_ascii_alphanumeric())
        && name.chars().all(legal)
        && name.len() <= 64;
    let expected =
        "must be 1 to 64 letters, digits, `-`, `_` or `.`, the first a letter or a digit";
    (!is_name).then(|| Mistake::new(node.span(), format!("`{name}` cannot name {owner}"), expected))
}
