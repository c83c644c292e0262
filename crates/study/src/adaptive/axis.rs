//! Reads the axis along which a rule adds points.

use crate::axis::Group;
use crate::error::Mistake;
use crate::key::Key;
use crate::quantity::Quantity;
use crate::read::{self, Node};
use crate::value::Value;

/// Reads the name of an axis of ascending numbers that advances by itself, and returns its index
/// among all axes. `done` says what is done to it in the message for one that is not.
pub(super) fn ascending_axis(
    path: &str,
    node: &Node<'_>,
    groups: &[Group],
    done: &str,
    mistakes: &mut Vec<Mistake>,
) -> Option<usize> {
    let name = read::text(path, node).map_err(|mistake| mistakes.push(mistake)).ok()?;
    let axes =
        || groups.iter().flat_map(|group| group.axes().iter().map(move |axis| (group, axis)));
    let is_meant = |key: Option<Key>| {
        key.is_some() && key == Key::find(&name).or_else(|| Key::of_column(&name))
    };
    let Some(index) = axes().position(|(_, axis)| is_meant(axis.key())) else {
        let known: Vec<String> = axes().map(|(_, axis)| format!("\"{}\"", axis.path())).collect();
        let expected = if known.is_empty() {
            "needs [sweep] with it".to_owned()
        } else {
            format!("must be one of {}", known.join(", "))
        };
        let message = format!("`{path}`: there is no axis `{name}`");
        mistakes.push(Mistake::new(node.span(), message, expected));
        return None;
    };
    let (group, axis) = axes().nth(index)?;
    if group.design().is_some() {
        let message = format!("`{path}`: `{name}` is drawn by [sample]");
        mistakes.push(Mistake::new(node.span(), message, "must be an axis of [sweep]"));
        return None;
    }
    let continuous = matches!(axis.key().map(Key::quantity), Some(Quantity::Number(_)));
    if !continuous || group.axes().len() > 1 {
        let why = if continuous {
            "advances together with others"
        } else {
            "has nothing between its values"
        };
        let message = format!("`{path}`: `{name}` {why}");
        let expected = "must be an axis of numbers by itself";
        mistakes.push(Mistake::new(node.span(), message, expected));
    }
    let is_ascending = |values: &[f64]| values.windows(2).all(|pair| pair[0] < pair[1]);
    let values: Vec<f64> = axis.values().filter_map(Value::as_f64).collect();
    if continuous && (values.len() < 2 || !is_ascending(&values)) {
        let expected = "needs at least two values, the smaller ones first";
        let message = format!("`{name}` cannot be {done}");
        mistakes.push(Mistake::new(axis.span.clone(), message, expected));
    }
    Some(index)
}
