//! Reads `[sweep]`, whose format [`axis`](crate::axis) describes, and refuses axes that do not fit
//! each other or the scene.

use toml::de::DeValue;

use crate::axis::{Choice, Group, MAX_POINTS, SweepAxis, Target, count};
use crate::bounds::ANY;
use crate::error::{Mistake, Span, are_enough};
use crate::fallback::Fallback::{Follows, Needed};
use crate::key::{Key, Table};
use crate::read::{self, Name, Node, Reader, entries};
use crate::sheet::{Given, Setting};
use crate::suggestion::nearest_path;
use crate::table_key::{ANY_KEY, KeyTable, TableKey, TableValue, table_key};
use crate::value::Value;

mod blocks;
mod fit;
mod range;

pub(crate) use blocks::JoinedBlocks;
use blocks::{AxisBlock, join};
pub(crate) use fit::{
    refuse_absent, refuse_alternatives, refuse_overlaps, refuse_repeats, too_many_entries,
};
use fit::{refuse_excess, refuse_repeated_rows};
pub(crate) use range::RANGE;
use range::{AxisValues, is_range, read_range};

/// The table. Several blocks `[[sweep]]` have their points joined.
pub(crate) const TABLE: KeyTable = KeyTable {
    path: "sweep",
    is_list: false,
    meaning: "the axes of the study, whose values are combined in all ways; the points of several \
              blocks `[[sweep]]` are joined",
    keys: &[AXIS_VALUES, ZIPPED],
};

/// The table of axes that advance together.
pub(crate) const ZIP: KeyTable = KeyTable {
    path: "sweep.zip",
    is_list: true,
    meaning: "axes that advance together and count as one: each has as many values as the others",
    keys: &[AXIS_VALUES],
};

const AXIS_VALUES: TableKey = table_key(
    ANY_KEY,
    TableValue::Other("a list of values, or a range"),
    ANY,
    Needed,
    "[0.1, 0.3, 0.5]",
    "values of the key or the table at this path; a table may have a `label` that names it in the \
     results",
);

const ZIPPED: TableKey = table_key(
    "zip",
    TableValue::Other("a list of tables of axes"),
    ANY,
    Follows("each axis advances by itself"),
    "[{ friction.mu = [0.1, 0.3], mesh = [8, 16] }]",
    "axes that advance together",
);

/// Reads the axes of `[sweep]`.
pub(crate) fn read_sweep(text: &str, node: &Node<'_>, mistakes: &mut Vec<Mistake>) -> Vec<Group> {
    let DeValue::Table(table) = node.get_ref() else {
        mistakes.push(read::mistyped("sweep", node, "a table of axes"));
        return Vec::new();
    };
    let mut groups = Vec::new();
    if let Some(mistake) = refuse_excess(table, node) {
        mistakes.push(mistake);
        return groups;
    }
    for (name, node) in entries(table) {
        if name.get_ref() == ZIPPED.name {
            read_zips(text, node, &mut groups, mistakes);
        } else {
            let mut axes = Vec::new();
            read_axes(text, "", name, node, &mut axes, mistakes);
            axes.iter().for_each(|axis| refuse_repeats(axis, mistakes));
            groups.extend(axes.into_iter().map(|axis| {
                let length = axis.choices.len();
                Group::listed(vec![axis], length)
            }));
        }
    }
    groups
}

/// Reads the blocks of `[[sweep]]` and joins their points. `base` is what the scene gives.
pub(crate) fn read_blocks<'i>(
    text: &str,
    blocks: impl IntoIterator<Item = &'i Node<'i>>,
    base: &[(Key, Given)],
    mistakes: &mut Vec<Mistake>,
) -> Option<JoinedBlocks> {
    let before = mistakes.len();
    let mut read = Vec::new();
    for block in blocks {
        let mut groups = read_sweep(text, block, mistakes);
        groups.sort_by_key(|group| group.axes.first().map(|axis| axis.span.start));
        refuse_overlaps(&groups, mistakes);
        read.push(AxisBlock { groups, span: block.span() });
    }
    if mistakes.len() > before { None } else { join(&read, base, mistakes) }
}

/// Returns the mistake of groups that make more points than `most`.
pub(crate) fn too_many_points(groups: &[Group], most: usize) -> Option<Mistake> {
    let points = count(groups);
    if points.is_some_and(|points| points <= most) {
        return None;
    }
    let factors =
        groups.iter().map(|group| group.length.to_string()).collect::<Vec<_>>().join(" × ");
    let makers = match (groups.len(), groups.iter().any(|group| group.design.is_some())) {
        (1, true) => "the sample makes",
        (_, true) => "the axes and the sample make",
        (_, false) => "the axes make",
    };
    let message = format!("{makers} {factors} points, more than {most}");
    let help = points.map(|points| {
        let shards = points.div_ceil(MAX_POINTS);
        format!("or run the study in {shards} shards or more: `run … --shard 1/{shards}`")
    });
    let largest = groups.iter().max_by_key(|group| group.length);
    let (span, expected) = match largest {
        Some(sample) if sample.design.is_some() => {
            (sample.count.clone(), "needs fewer points, or fewer values on other axes")
        }
        group => {
            let axis = group.and_then(|group| group.axes.first());
            let expected = "needs fewer values, here or on another axis";
            (axis.map_or(0..0, |axis| axis.span.clone()), expected)
        }
    };
    let mistake = Mistake::new(span, message, expected);
    Some(mistake.help(help.unwrap_or_default()))
}

fn read_zips(text: &str, node: &Node<'_>, groups: &mut Vec<Group>, mistakes: &mut Vec<Mistake>) {
    let expected = "written [[sweep.zip]], with axes that advance together below it";
    let DeValue::Array(zips) = node.get_ref() else {
        return mistakes.push(read::mistyped("zip", node, expected));
    };
    for zip in zips.iter() {
        if are_enough(mistakes) {
            return;
        }
        let DeValue::Table(table) = zip.get_ref() else {
            mistakes.push(read::mistyped("zip", zip, expected));
            continue;
        };
        let mut axes = Vec::new();
        let before = mistakes.len();
        for (name, node) in entries(table) {
            read_axes(text, "", name, node, &mut axes, mistakes);
        }
        axes.sort_by_key(|axis| axis.span.start);
        let Some(first) = axes.first() else {
            if mistakes.len() == before {
                mistakes.push(Mistake::new(
                    zip.span(),
                    "a zip without axes",
                    "needs axes that advance together",
                ));
            }
            continue;
        };
        let length = first.choices.len();
        for other in axes.iter().filter(|axis| axis.choices.len() != length) {
            let values = |axis: &SweepAxis| match axis.choices.len() {
                1 => format!("`{}` has 1 value", axis.path()),
                n => format!("`{}` has {n} values", axis.path()),
            };
            let message = format!(
                "{}, {}: axes that advance together need equally many",
                values(first),
                values(other)
            );
            mistakes.push(
                Mistake::new(other.span.clone(), message, format!("needs {length}"))
                    .context(first.span.clone(), "as many as here"),
            );
        }
        // Rows are told apart only where each has all its values.
        if axes.iter().all(|axis| axis.choices.len() == length) {
            refuse_repeated_rows(&axes, mistakes);
        }
        axes.retain(|axis| axis.choices.len() == length);
        groups.push(Group::listed(axes, length));
    }
}

/// Reads one entry below `[sweep]`. An entry without quotes, `friction.mu = …`, arrives as nested
/// tables.
fn read_axes(
    text: &str,
    prefix: &str,
    name: &Name<'_>,
    node: &Node<'_>,
    axes: &mut Vec<SweepAxis>,
    mistakes: &mut Vec<Mistake>,
) {
    let path = if prefix.is_empty() {
        name.get_ref().to_string()
    } else {
        format!("{prefix}.{}", name.get_ref())
    };
    let span = name.span();
    if let Some(table) = Table::find(&path) {
        match node.get_ref() {
            DeValue::Table(below) if !below.is_empty() && !is_range(node) => {
                entries(below)
                    .into_iter()
                    .for_each(|(name, node)| read_axes(text, &path, name, node, axes, mistakes));
            }
            _ => {
                let choices = read_table_choices(text, table, node, mistakes);
                if !choices.is_empty() {
                    axes.push(SweepAxis {
                        target: Target::Table(table),
                        choices,
                        distribution: None,
                        log: false,
                        span,
                    });
                }
            }
        }
    } else if let Some(key) = Key::find(&path) {
        let AxisValues { choices, is_log } = read_key_choices(key, node, mistakes);
        if !choices.is_empty() {
            let (target, distribution) = (Target::Key(key), None);
            axes.push(SweepAxis { target, choices, distribution, log: is_log, span });
        }
    } else {
        let mistake = |expected: &str| {
            Mistake::new(span.clone(), format!("there is no key `{path}` to vary"), expected)
        };
        mistakes.push(match nearest_path(&path) {
            Some(suggestion) => mistake(&format!("did you mean \"{suggestion}\"?")),
            None => {
                mistake("must be a key of the scene or the numerics, like \"friction.mu\" or mesh")
            }
        });
    }
}

fn read_key_choices(key: Key, node: &Node<'_>, mistakes: &mut Vec<Mistake>) -> AxisValues {
    match node.get_ref() {
        DeValue::Array(values) => {
            if values.is_empty() {
                mistakes.push(empty(&key.short(), node));
            }
            let mut choices = Vec::new();
            for value in values.iter() {
                if are_enough(mistakes) {
                    break;
                }
                match read::setting(key, value) {
                    Ok(setting) => choices.push(Choice::of_key(key, setting, value.span(), None)),
                    Err(mistake) => mistakes.push(mistake),
                }
            }
            AxisValues { choices, is_log: false }
        }
        DeValue::Table(table) => match read_range(key, table, node, mistakes) {
            Ok(range) => range,
            Err(mistake) => {
                mistakes.push(mistake);
                AxisValues::default()
            }
        },
        _ => {
            let expected = format!(
                "a list of values or a range {{ from, to, count }}: each {}",
                key.quantity().expected()
            );
            mistakes.push(
                read::mistyped(&key.short(), node, &expected)
                    .help(format!("one value alone is written [{}]", node_text(node))),
            );
            AxisValues::default()
        }
    }
}

fn node_text(node: &Node<'_>) -> String {
    match node.get_ref() {
        DeValue::String(text) => format!("\"{text}\""),
        DeValue::Integer(n) => n.to_string(),
        DeValue::Float(x) => x.to_string(),
        _ => "…".to_owned(),
    }
}

fn empty(path: &str, node: &Node<'_>) -> Mistake {
    Mistake::new(node.span(), format!("the axis `{path}` is empty"), "needs at least one value")
}

fn read_table_choices(
    text: &str,
    table: Table,
    node: &Node<'_>,
    mistakes: &mut Vec<Mistake>,
) -> Vec<Choice> {
    let path = table.short();
    let DeValue::Array(values) = node.get_ref() else {
        mistakes.push(read::mistyped(&path, node, &format!("a list, each {}", each(&table))));
        return Vec::new();
    };
    if values.is_empty() {
        mistakes.push(empty(&path, node));
    }
    let mut choices = Vec::new();
    for value in values.iter() {
        if are_enough(mistakes) {
            break;
        }
        choices.extend(read_table_choice(text, table, value, mistakes));
    }
    choices
}

/// Describes the values of an axis over a table, for messages.
fn each(table: &Table) -> String {
    match table.is_list() {
        true => format!(
            "{}, or with a name {{ label = \"…\", {} = [ … ] }}",
            table.expected(),
            table.name()
        ),
        false => table.expected(),
    }
}

fn read_table_choice(
    text: &str,
    table: Table,
    value: &Node<'_>,
    mistakes: &mut Vec<Mistake>,
) -> Option<Choice> {
    let path = table.short();
    let mut reader = Reader::new(text, mistakes);
    let mut label = None;
    match (table.list().filter(|_| table.is_list()), Key::find(&table.path()), value.get_ref()) {
        (Some(list), _, DeValue::Array(_)) => {
            reader.list(list, value);
            let length = reader
                .given
                .first()
                .map(|(_, given)| given.setting.to_string())
                .unwrap_or_default();
            label = Some(match length.as_str() {
                "0" => format!("no {}", table.name()),
                "1" => format!("1 {}", table.name().trim_end_matches('s')),
                _ => format!("{length} {}", table.name()),
            });
        }
        (Some(list), _, DeValue::Table(below)) if below.contains_key(table.name()) => {
            let names = ["label", table.name()];
            for (name, node) in entries(below) {
                match name.get_ref().as_ref() {
                    "label" => {}
                    name if name == table.name() => reader.list(list, node),
                    other => reader.mistakes.push(read::unknown(
                        other,
                        name.span(),
                        &format!("this value of `{path}`"),
                        &names,
                    )),
                }
            }
        }
        (None, Some(key), DeValue::String(word)) => {
            reader.key(key, value);
            label = Some(word.to_string());
        }
        (None, _, DeValue::Table(below)) => {
            let keys = entries(below).into_iter().filter(|(name, _)| name.get_ref() != "label");
            reader.table(table, value.span(), keys);
        }
        _ => {
            reader.mistakes.push(read::mistyped(&path, value, &each(&table)));
            return None;
        }
    }
    let given = reader.given;
    let label = match value.get_ref() {
        DeValue::Table(below) => below.get("label").map(|node| {
            read::text("label", node).and_then(|text| checked_label(text, node.span()))
        }),
        _ => label.map(Ok),
    };
    let label = label.or_else(|| shape_of(&given).map(Ok)).unwrap_or_else(|| {
        Err(Mistake::new(
            value.span(),
            format!("this value of `{path}` has no label"),
            "needs label = \"…\" to name it in the results",
        ))
    });
    label
        .map(|label| Choice { shown: Value::Text(label), given, span: value.span() })
        .map_err(|mistake| mistakes.push(mistake))
        .ok()
}

fn checked_label(text: String, span: Span) -> Result<String, Mistake> {
    if text.trim().is_empty() || text.chars().count() > 64 || text.chars().any(char::is_control) {
        return Err(Mistake::new(
            span,
            "a label that cannot name anything",
            "must be 1 to 64 visible characters",
        ));
    }
    Ok(text)
}

fn shape_of(given: &[(Key, Given)]) -> Option<String> {
    given.iter().find_map(|(key, given)| match (key, &given.setting) {
        (Key::Shape, Setting::Word(shape)) => Some(shape.clone()),
        _ => None,
    })
}
