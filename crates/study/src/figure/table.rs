//! Reads the tables `[[figure]]` of a study file.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{Figure, FigureKind, telling};
use crate::axis::Group;
use crate::bounds::{ANY, Bounds, within};
use crate::column_name::column_name;
use crate::columns::{Column, along_path};
use crate::error::{Mistake, Span};
use crate::fallback::Fallback::{self, Follows, Needed};
use crate::read::{self, Node};
use crate::table_key::{COLUMN, CONDITION, KeyTable, NAME, TEXT, TableValue, table_key};

use form::{read_kind, refuse_foreign, refuse_plain};
use named::{read_condition, read_series, read_y};

mod form;
mod named;

/// The largest number of figures of one study.
const MOST_FIGURES: usize = 100;

/// The numbers of bins that a histogram may have.
const BINS: Bounds = within(1.0, 1000.0);

/// The table.
pub(crate) const TABLE: KeyTable = KeyTable {
    path: "figure",
    is_list: true,
    meaning: "a figure that answers the study's question; `[figure]`, if there is only one",
    keys: &[
        table_key("name", NAME, ANY, Follows("its number"), "\"loop\"", "name of its files"),
        table_key(
            "title",
            TEXT,
            ANY,
            Follows("the study's `question`"),
            "\"A closed loop\"",
            "title that stands above it",
        ),
        table_key(
            "kind",
            TableValue::Word(&FigureKind::NAMES),
            ANY,
            Follows("\"curves\"; \"scatter\" in a study with `[sample]`"),
            "\"scatter\"",
            "form: curves through points, points, counts, or bars of how much each key moves a result",
        ),
        table_key("x", COLUMN, ANY, Needed, "\"mu\"", "column of numbers along the abscissa"),
        table_key(
            "y",
            TableValue::Columns,
            ANY,
            Needed,
            "\"peak_pressure\"",
            "columns of one unit along the ordinate; may be left out beside `band`, and a \
             histogram has none",
        ),
        table_key(
            "series",
            TableValue::Other("a list of columns"),
            ANY,
            Follows("the axes that are left over"),
            "[\"mesh\"]",
            "columns of whose values each combination gets a curve",
        ),
        table_key(
            "panels",
            COLUMN,
            ANY,
            Follows("one panel"),
            "\"mesh\"",
            "column of which each value gets a panel",
        ),
        table_key(
            "steps",
            TableValue::Flag,
            ANY,
            Fallback::Flag(false),
            "true",
            "whether every increment is a point, joined along the loading path",
        ),
        table_key(
            "where",
            CONDITION,
            ANY,
            Follows("all points"),
            "\"mu > 0.1\"",
            "condition that holds at the points that are shown",
        ),
        table_key(
            "log_x",
            TableValue::Flag,
            ANY,
            Fallback::Flag(false),
            "true",
            "whether the abscissa is logarithmic",
        ),
        table_key(
            "log_y",
            TableValue::Flag,
            ANY,
            Fallback::Flag(false),
            "true",
            "whether the ordinate is logarithmic",
        ),
        table_key(
            "fit",
            TableValue::Flag,
            ANY,
            Fallback::Flag(false),
            "true",
            "whether a straight line is fitted to each curve's later points, with its slope",
        ),
        table_key(
            "band",
            TableValue::Other("a pair of columns"),
            ANY,
            Follows("no band"),
            "[\"stick_area\", \"contact_area\"]",
            "lower and upper column, of one unit, between which it is shaded",
        ),
        table_key(
            "front",
            TableValue::Flag,
            ANY,
            Fallback::Flag(false),
            "true",
            "whether those points are marked that no other one is below and left of",
        ),
        table_key(
            "names",
            COLUMN,
            ANY,
            Follows("no names"),
            "\"mesh\"",
            "column whose values are written beside the points",
        ),
        table_key(
            "bins",
            TableValue::Count,
            BINS,
            Follows("by the rule of Freedman and Diaconis"),
            "20",
            "bins of a histogram",
        ),
        table_key(
            "share",
            TableValue::Flag,
            ANY,
            Fallback::Flag(false),
            "true",
            "whether a histogram shows parts of the points in place of counts",
        ),
    ],
};

/// Reads `[figure]` or every `[[figure]]`; `columns` are the study's.
pub(crate) fn read_figures(
    node: &Node<'_>,
    groups: &[Group],
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Vec<Figure> {
    let nodes: Vec<&Node<'_>> = match node.get_ref() {
        DeValue::Array(figures) => figures.iter().collect(),
        _ => vec![node],
    };
    if nodes.len() > MOST_FIGURES {
        let message = format!("the study has {} figures", nodes.len());
        let expected = format!("must have at most {MOST_FIGURES}");
        mistakes.push(Mistake::new(node.span(), message, expected));
        return Vec::new();
    }
    let mut figures: Vec<Figure> = Vec::new();
    let mut places: Vec<(String, Span)> = Vec::new();
    for (index, node) in nodes.into_iter().enumerate() {
        let DeValue::Table(table) = node.get_ref() else {
            mistakes.push(read::mistyped(
                "figure",
                node,
                &format!(
                    "a table with the keys `{}`, or a list of such tables",
                    TABLE.names().join("`, `")
                ),
            ));
            continue;
        };
        let span = table.get("name").map_or(node.span(), Spanned::span);
        let name = match table.get("name") {
            None => Some((index + 1).to_string()),
            Some(node) => match read::text("figure.name", node) {
                Ok(name) => {
                    mistakes.extend(read::refuse_file_name(&name, "a figure", node));
                    Some(name)
                }
                Err(mistake) => {
                    mistakes.push(mistake);
                    None
                }
            },
        };
        if let Some(name) = &name {
            if let Some((_, first)) = places.iter().find(|(other, _)| other == name) {
                let mistake = Mistake::new(
                    span.clone(),
                    format!("two figures are called `{name}`"),
                    "needs a name of its own",
                );
                mistakes.push(mistake.context(first.clone(), "the first, by its name or number"));
            }
            places.push((name.clone(), span));
        }
        if let (Some(figure), Some(name)) =
            (read_figure(node.span(), table, groups, columns, mistakes), name)
        {
            figures.push(Figure { name, ..figure });
        }
    }
    figures
}

/// Reads one figure without its name. If `series` is left out, there is one curve for each
/// combination of the axes that are left over.
fn read_figure(
    span: Span,
    table: &DeTable<'_>,
    groups: &[Group],
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Option<Figure> {
    read::refuse_unknown(table, "`[figure]`", &TABLE.names(), mistakes);
    let mut switch = |name: &str| {
        let node = table.get(name)?;
        read::switch(&format!("figure.{name}"), node).map_err(|mistake| mistakes.push(mistake)).ok()
    };
    let (log_x, log_y, steps) =
        (switch("log_x"), switch("log_y"), switch("steps").unwrap_or(false));
    let (fit, front) = (switch("fit").unwrap_or(false), switch("front").unwrap_or(false));
    let share = switch("share").unwrap_or(false);
    let kind = match table.get("kind") {
        // Increments are joined along their path, and a band needs bars at least.
        None if steps || table.contains_key("band") => FigureKind::Curves,
        None => FigureKind::usual(groups),
        Some(node) => read_kind(node).map_err(|mistake| mistakes.push(mistake)).ok()?,
    };
    refuse_foreign(kind, table, mistakes);
    let is_of_sensitivity = kind == FigureKind::Sensitivity;
    if is_of_sensitivity {
        let place = table.get("kind").map_or(span.clone(), Spanned::span);
        refuse_plain(&place, groups, mistakes);
    }
    let bins = table.get("bins").and_then(|node| {
        read::count("figure.bins", "bins", BINS, node)
            .map_err(|mistake| mistakes.push(mistake))
            .ok()
    });
    let title = table.get("title").and_then(|node| {
        read::text("figure.title", node).map_err(|mistake| mistakes.push(mistake)).ok()
    });
    let columns = if steps { &along_path(columns.to_vec()) } else { columns };
    let mut column = |name: &str, numeric: bool| {
        let node = table.get(name)?;
        let read = column_name(&format!("figure.{name}"), node, columns, numeric);
        read.map_err(|mistake| mistakes.push(mistake)).ok()
    };
    let (x, panels, names) = (column("x", true), column("panels", false), column("names", false));
    let band = table.get("band").and_then(|node| read_y("band", node, columns, mistakes)).and_then(
        |band| match <[String; 2]>::try_from(band) {
            Ok(band) => Some(band),
            Err(_) => {
                let expected =
                    "must be the lower and the upper column, like [\"mu_low\", \"mu_high\"]";
                mistakes.push(Mistake::new(
                    table.get("band").map_or(span.clone(), Spanned::span),
                    "`figure.band` is no pair",
                    expected,
                ));
                None
            }
        },
    );
    let condition = table.get("where").and_then(|node| {
        read_condition(node, columns).map_err(|mistake| mistakes.push(mistake)).ok()
    });
    let y = table
        .get("y")
        .and_then(|node| read_y("y", node, columns, mistakes))
        .or_else(|| band.is_some().then(Vec::new));
    let series = table.get("series").map(|node| match node.get_ref() {
        DeValue::Array(names) => read_series(names, columns, mistakes),
        _ => {
            mistakes.push(read::mistyped(
                "figure.series",
                node,
                "a list of columns like [\"mesh\"]",
            ));
            Vec::new()
        }
    });
    let is_histogram = kind == FigureKind::Histogram;
    for name in ["x", "y"] {
        let may_lack = match name {
            "x" => is_of_sensitivity,
            _ => is_histogram || table.contains_key("band"),
        };
        if !table.contains_key(name) && !may_lack {
            let expected = format!("needs {name} = \"…\", a column of numbers");
            mistakes.push(Mistake::new(
                span.clone(),
                format!("the figure has no `{name}`"),
                expected,
            ));
        }
    }
    let x = if is_of_sensitivity { String::new() } else { x? };
    let y = if is_histogram { Vec::new() } else { y? };
    let others = telling(groups)
        .map(|axis| axis.column().into_owned())
        .filter(|name| *name != x && panels.as_ref() != Some(name));
    let series = match is_of_sensitivity {
        true => Vec::new(),
        false => series.unwrap_or_else(|| others.collect()),
    };
    let (log_x, log_y) = (log_x.unwrap_or(false), log_y.unwrap_or(false));
    Some(Figure {
        title,
        kind,
        bins,
        share,
        series,
        panels,
        steps,
        condition,
        log_x,
        log_y,
        fit,
        band,
        front,
        names,
        ..Figure::new(x, y)
    })
}
