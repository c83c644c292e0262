//! The figure that answers a study's question: which column over which, one curve for each of which, side by side.

use toml::de::DeValue;

use crate::axis::{Axis, Group};
use crate::columns::{Column, along_path, find};
use crate::error::Problem;
use crate::key::nearest;
use crate::read::{self, Node, entries};

/// A figure; all names are columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// The column along the abscissa; numeric.
    pub x: String,
    /// The column along the ordinate; numeric.
    pub y: String,
    /// One curve for each combination of these columns' values.
    pub series: Vec<String>,
    /// One panel for each value of this column.
    pub panels: Option<String>,
    /// Whether every increment is a point, joined along the loading path, and not only the end of it.
    pub steps: bool,
    /// Whether the abscissa is logarithmic.
    pub log_x: bool,
    /// Whether the ordinate is logarithmic.
    pub log_y: bool,
}

const KEYS: &[&str] = &["x", "y", "series", "panels", "steps", "log_x", "log_y"];

/// Reads `[figure]`; `columns` are the study's. Without `series` there is one curve for each combination of the axes left over.
pub(crate) fn read_figure(node: &Node<'_>, groups: &[Group], columns: &[Column], problems: &mut Vec<Problem>) -> Option<Figure> {
    let DeValue::Table(table) = node.get_ref() else {
        problems.push(read::mistyped("figure", node, &format!("a table with the keys `{}`", KEYS.join("`, `"))));
        return None;
    };
    for (name, _) in entries(table).into_iter().filter(|(name, _)| !KEYS.contains(&name.get_ref().as_ref())) {
        problems.push(read::unknown(name.get_ref(), name.span(), "`[figure]`", KEYS));
    }
    let mut switch = |name: &str| {
        let node = table.get(name)?;
        read::switch(&format!("figure.{name}"), node).map_err(|problem| problems.push(problem)).ok()
    };
    let (log_x, log_y, steps) = (switch("log_x"), switch("log_y"), switch("steps").unwrap_or(false));
    let columns = if steps { &along_path(columns.to_vec()) } else { columns };
    let mut column = |name: &str, numeric: bool| {
        let node = table.get(name)?;
        let read = column_name(&format!("figure.{name}"), node, columns, numeric);
        read.map_err(|problem| problems.push(problem)).ok()
    };
    let (x, y, panels) = (column("x", true), column("y", true), column("panels", false));
    let series = table.get("series").map(|node| match node.get_ref() {
        DeValue::Array(names) => {
            let read = names.iter().map(|node| column_name("figure.series", node, columns, false));
            read.filter_map(|name| name.map_err(|problem| problems.push(problem)).ok()).collect()
        }
        _ => {
            problems.push(read::mistyped("figure.series", node, "a list of columns like [\"mesh\"]"));
            Vec::new()
        }
    });
    let mut require = |name: &str, found: Option<String>| {
        if found.is_none() && !table.contains_key(name) {
            problems.push(Problem::new(
                node.span(),
                format!("the figure has no `{name}`"),
                format!("needs {name} = \"…\", a column of numbers"),
            ));
        }
        found
    };
    let (x, y) = (require("x", x)?, require("y", y)?);
    let others = firsts(groups).map(|axis| axis.column().into_owned()).filter(|name| *name != x && panels.as_ref() != Some(name));
    let series = series.unwrap_or_else(|| others.collect());
    Some(Figure { x, y, series, panels, steps, log_x: log_x.unwrap_or(false), log_y: log_y.unwrap_or(false) })
}

fn column_name(what: &str, node: &Node<'_>, columns: &[Column], numeric: bool) -> Result<String, Problem> {
    let name = read::text(what, node)?;
    match find(columns, &name) {
        Some(column) if numeric && !column.is_numeric() => {
            Err(Problem::new(node.span(), format!("`{what}`: the column `{name}` holds texts"), "must be a column of numbers"))
        }
        Some(column) => Ok(column.name.to_string()),
        None => {
            let message = format!("`{what}`: there is no column `{name}`");
            if along_path(Vec::new()).iter().any(|column| column.name == name) {
                return Err(Problem::new(node.span(), message, "only increments have it: add steps = true to the figure"));
            }
            Err(match nearest(&name, columns.iter().map(|column| column.name.as_ref())) {
                Some(meant) => Problem::new(node.span(), message, format!("did you mean \"{meant}\"?")),
                None => Problem::new(node.span(), message, "must be an axis, a key or an observable, like \"mu\" or \"peak_pressure\""),
            })
        }
    }
}

/// One axis for each group that varies: those that advance with it say nothing more.
fn firsts(groups: &[Group]) -> impl Iterator<Item = &Axis> {
    groups.iter().filter(|group| group.len() > 1).filter_map(|group| group.axes().first())
}

/// The figure of a study that asks for none: over its longest numeric axis the stick fraction, if that axis is friction,
/// else the load; a panel for each value of the first axis of tables or words, a curve for each of the others'.
/// `None` without a numeric axis.
pub(crate) fn default(groups: &[Group]) -> Option<Figure> {
    // the first of the longest: max_by_key would return the last
    let x = firsts(groups).filter(|axis| axis.is_numeric()).reduce(|a, b| if b.values().len() > a.values().len() { b } else { a })?;
    let others = || firsts(groups).filter(|axis| axis.column() != x.column());
    let panels = others().find(|axis| !axis.is_numeric()).map(|axis| axis.column().into_owned());
    let series = others().map(|axis| axis.column().into_owned()).filter(|name| Some(name) != panels.as_ref()).collect();
    let y = if x.column() == "mu" { "stick_fraction" } else { "load" };
    Some(Figure { x: x.column().into_owned(), y: y.to_owned(), series, panels, steps: false, log_x: x.is_log(), log_y: false })
}
