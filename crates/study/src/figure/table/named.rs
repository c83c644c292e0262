//! Reads the columns that a figure names: along its axes, in its series, in its condition.

use condition::{Condition, ConditionNames, UnknownColumn, ValueKind};
use toml::de::{DeArray, DeValue};

use crate::column_name::column_name;
use crate::columns::{Column, find, nearest_name};
use crate::error::{Mistake, Span, are_enough};
use crate::read::{self, Node};
use crate::value::ValueType;

/// The names of columns in a condition.
struct ColumnNames<'a>(&'a [Column]);

impl ConditionNames for ColumnNames<'_> {
    fn find(&self, name: &str) -> Result<usize, UnknownColumn> {
        let found = find(self.0, name).map(|column| column.name.as_ref());
        let place = self.0.iter().position(|column| Some(column.name.as_ref()) == found);
        place.ok_or_else(|| UnknownColumn {
            name: name.to_owned(),
            close: nearest_name(self.0, name).map(str::to_owned).into_iter().collect(),
            columns: self.0.iter().map(|column| column.name.to_string()).collect(),
        })
    }

    fn kind(&self, index: usize) -> ValueKind {
        match self.0.get(index).map(|column| (column.values(), column.name.as_ref())) {
            // A mesh that is a pair is a text.
            None | Some((_, "mesh")) => ValueKind::Unknown,
            Some((ValueType::Number | ValueType::Integer, _)) => ValueKind::Number,
            Some((ValueType::Flag, _)) => ValueKind::Truth,
            Some((ValueType::Text, _)) => ValueKind::Text,
        }
    }
}

/// Reads the condition of the points that a figure shows.
pub(super) fn read_condition(node: &Node<'_>, columns: &[Column]) -> Result<String, Mistake> {
    let text = read::condition("figure.where", node)?;
    match Condition::new(&text, &ColumnNames(columns)) {
        Ok(_) => Ok(text),
        Err(error) => {
            let words = error.to_string();
            let (first, rest) = words.split_once('\n').unwrap_or((&words, ""));
            let message = "`figure.where` is no condition on the study's columns";
            Err(Mistake::new(node.span(), message, first).help(rest))
        }
    }
}

/// Reads the columns that tell curves apart.
pub(super) fn read_series(
    nodes: &DeArray<'_>,
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for node in nodes.iter() {
        if are_enough(mistakes) {
            break;
        }
        match column_name("figure.series", node, columns, false) {
            Ok(name) if names.contains(&name) => mistakes.push(Mistake::new(
                node.span(),
                format!("`figure.series`: `{name}` is listed twice"),
                "once is enough",
            )),
            Ok(name) => names.push(name),
            Err(mistake) => mistakes.push(mistake),
        }
    }
    names
}

/// Reads a column or a list of columns of one unit; `None` if none of them can be used.
pub(super) fn read_y(
    key: &str,
    node: &Node<'_>,
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Option<Vec<String>> {
    let nodes: Vec<&Node<'_>> = match node.get_ref() {
        DeValue::Array(names) => names.iter().collect(),
        _ => vec![node],
    };
    if nodes.is_empty() {
        mistakes.push(Mistake::new(
            node.span(),
            format!("`figure.{key}` is an empty list"),
            "must be a column or a list of columns of numbers",
        ));
    }
    let mut names: Vec<(String, Span)> = Vec::new();
    for node in nodes {
        if are_enough(mistakes) {
            break;
        }
        let name = match column_name(&format!("figure.{key}"), node, columns, true) {
            Ok(name) => name,
            Err(mistake) => {
                mistakes.push(mistake);
                continue;
            }
        };
        let unit = |name: &str| find(columns, name).map_or("", Column::unit);
        let in_words = |unit: &str| {
            if unit.is_empty() { "a pure number".to_owned() } else { format!("in {unit}") }
        };
        if let Some((first, place)) = names.first() {
            let (wanted, found) = (unit(first), unit(&name));
            if names.iter().any(|(other, _)| *other == name) {
                mistakes.push(Mistake::new(
                    node.span(),
                    format!("`figure.{key}`: `{name}` is listed twice"),
                    "once is enough",
                ));
            } else if wanted != found {
                let message =
                    format!("`figure.{key}`: `{first}` and `{name}` cannot share an axis");
                let mistake = Mistake::new(node.span(), message, format!("is {}", in_words(found)));
                mistakes.push(
                    mistake
                        .context(place.clone(), format!("is {}", in_words(wanted)))
                        .help("give each unit a [[figure]] of its own"),
                );
            }
        }
        names.push((name, node.span()));
    }
    (!names.is_empty()).then(|| names.into_iter().map(|(name, _)| name).collect())
}
