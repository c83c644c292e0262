//! Ranges of values with equal steps or equal ratios.

use toml::de::{DeTable, DeValue};

use contact::model::Mesh;

use crate::axis::{Choice, MAX_POINTS};
use crate::bounds::{ANY, within};
use crate::error::Mistake;
use crate::fallback::Fallback::{self, Needed};
use crate::key::Key;
use crate::quantity::Quantity;
use crate::read::{self, Node};
use crate::sheet::Setting;
use crate::table_key::{KeyTable, TableValue, table_key};
use crate::units::Dimension;

/// Returns whether a table is a range.
pub(super) fn is_range(node: &Node<'_>) -> bool {
    let DeValue::Table(table) = node.get_ref() else { return false };
    RANGE.keys.iter().any(|key| table.contains_key(key.name))
}

/// The values of an axis, and whether they were given as a range of equal ratios.
#[derive(Default)]
pub(super) struct AxisValues {
    pub(super) choices: Vec<Choice>,
    pub(super) is_log: bool,
}

/// The keys of a range.
pub(crate) const RANGE: KeyTable = KeyTable {
    path: "sweep.KEY",
    is_list: false,
    meaning: "a range in place of a list of values, mostly written on one line; both ends are \
              included",
    keys: &[
        table_key("from", OF_THE_KEY, ANY, Needed, "0.1", "first value"),
        table_key("to", OF_THE_KEY, ANY, Needed, "0.5", "last value"),
        table_key(
            "count",
            TableValue::Count,
            within(2.0, MAX_POINTS as f64),
            Needed,
            "5",
            "number of values",
        ),
        table_key(
            "log",
            TableValue::Flag,
            ANY,
            Fallback::Flag(false),
            "true",
            "whether the values have equal ratios, and not equal steps",
        ),
    ],
};

const OF_THE_KEY: TableValue = TableValue::Other("a number of the key");

/// Reads the values of a range; `node` is the whole of `table`.
pub(super) fn read_range(
    key: Key,
    table: &DeTable<'_>,
    node: &Node<'_>,
    mistakes: &mut Vec<Mistake>,
) -> Result<AxisValues, Mistake> {
    let path = key.short();
    let dimension = match key.quantity() {
        Quantity::Number(dimension) => dimension,
        Quantity::Count | Quantity::Mesh => Dimension::Pure,
        _ => {
            let expected = format!("must be a list, each {}", key.quantity().expected());
            return Err(Mistake::new(node.span(), format!("`{path}` has no ranges"), expected));
        }
    };
    read::refuse_unknown(table, &format!("the range of `{path}`"), &RANGE.names(), mistakes);
    let required = |name: &str| {
        table.get(name).ok_or_else(|| {
            let message = format!("the range of `{path}` has no `{name}`");
            Mistake::new(
                node.span(),
                message,
                format!("needs `{name}`, as in {{ from = 0.1, to = 0.5, count = 5 }}"),
            )
        })
    };
    let (from_node, to_node, count_node) = (required("from")?, required("to")?, required("count")?);
    let from = read::number(&format!("{path}: from"), dimension, from_node)?;
    let to = read::number(&format!("{path}: to"), dimension, to_node)?;
    let count = match count_node.get_ref() {
        DeValue::Integer(n) => read::whole("count", n, count_node.span())? as usize,
        _ => {
            return Err(read::mistyped("count", count_node, "a whole number of values, 2 or more"));
        }
    };
    let log = match table.get("log") {
        Some(node) => read::switch("log", node)?,
        None => false,
    };
    if count < 2 {
        let message = format!("a range of {count}: both ends are included");
        return Err(Mistake::new(count_node.span(), message, "must be 2 or more")
            .help("a single value is written as a list, [0.3]"));
    }
    if count > MAX_POINTS {
        return Err(Mistake::new(
            count_node.span(),
            format!("a range of {count} values"),
            format!("must be {MAX_POINTS} or fewer"),
        ));
    }
    if log && !(from > 0.0 && to > 0.0) {
        let bad = if from > 0.0 { to_node } else { from_node };
        let message = format!("the range of `{path}` has equal ratios but does not stay above 0");
        return Err(Mistake::new(bad.span(), message, "must be above 0 when log = true"));
    }
    if from == to {
        let message = format!("the range of `{path}` begins where it ends");
        return Err(Mistake::new(to_node.span(), message, "must differ from `from`"));
    }
    let mut choices = Vec::with_capacity(count);
    for index in 0..count {
        let x = between(from, to, index, count, log);
        let setting = match key.quantity() {
            Quantity::Number(_) => Setting::Number(x),
            quantity => {
                if !(x.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&x)) {
                    let message =
                        format!("value {} of the range of `{path}` would be {x}", index + 1);
                    return Err(Mistake::new(
                        node.span(),
                        message,
                        "every value must be a whole number, 0 or above",
                    ));
                }
                // This is exact, for it is a whole number in the range of u32.
                let n = x as u32;
                if quantity == Quantity::Mesh {
                    Setting::Mesh(Mesh::Across(n))
                } else {
                    Setting::Count(n)
                }
            }
        };
        choices.push(Choice::of_key(key, setting, node.span(), Some(index + 1)));
    }
    Ok(AxisValues { choices, is_log: log })
}

/// Returns the `index`-th of `count` values from `from` to `to`. The ends are exact, the others are
/// rounded to 15 significant digits, to 13 with equal ratios.
fn between(from: f64, to: f64, index: usize, count: usize, log: bool) -> f64 {
    let last = count - 1;
    if index == 0 {
        return from;
    }
    if index == last {
        return to;
    }
    let t = index as f64 / last as f64;
    if log {
        // The logarithm and the exponential lose a few digits, and differ from one mathematical
        // library to the next.
        let x = (from.ln() * (1.0 - t) + to.ln() * t).exp();
        return format!("{x:.12e}").parse().unwrap_or(x);
    }
    let x = from * (1.0 - t) + to * t;
    // The remainder that cancellation leaves of a 0 is not a value.
    if x.abs() < 1e-14 * from.abs().max(to.abs()) {
        0.0
    } else {
        format!("{x:.14e}").parse().unwrap_or(x)
    }
}
