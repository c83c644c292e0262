//! The keys of a study file.

use study::reference::{ReferenceKey, ReferenceTable, ShapeUse, reference, units};

use super::markdown::{WRITTEN, code, head, row, sentence, shortened};

/// The length of the longest example in a table, in characters.
const LONGEST_EXAMPLE: usize = 44;

/// Writes the page of the keys.
pub(crate) fn keys_page() -> String {
    let mut page = format!("{WRITTEN}# Keys of a study file\n\n");
    page += "Every table and every key that a study file may have. `tribosweep keys` prints this in \
             the shell, `tribosweep keys friction.mu` all there is to say about one key.\n\n\
             - A number that measures something is a text with a [unit](#units), `\"5 mm\"`, or a \
             bare number in SI units, `0.005`. Bounds and defaults are in SI units.\n\
             - Paths may be written with dots or as tables: `friction.mu = 0.3` below `[scene]` and \
             `mu = 0.3` below `[scene.friction]` are the same. Axes, formulas and conditions leave \
             `scene.`, `numerics.` and `search.` out: `friction.mu`, `mesh`.\n\
             - Layers and load steps are lists; a key of one has its index, counted from 0: \
             `foundation.layers[0].thickness`.\n\
             - `KEY` stands for the path of any key of the scene or the numerics: `\"friction.mu\"`.\n\
             - Every key of the scene and the numerics may be an axis of `[sweep]`, and so may a \
             table. [What cannot be drawn or derived](#what-cannot-be-drawn-or-derived) is at the \
             end, and so is [what a kind of study has no use \
             for](#what-a-kind-of-study-has-no-use-for).\n";
    let tables = reference();
    for table in &tables {
        page += &table_section(table);
    }
    page + &units_section() + &varied_section(&tables) + &refused_section(&tables)
}

/// Writes the section of a table.
fn table_section(table: &ReferenceTable) -> String {
    let title = match table.heading.as_str() {
        "" => "The top of the file".to_owned(),
        heading => code(heading),
    };
    let mut section = format!("\n## {title}\n\n");
    if !table.heading.is_empty() {
        section += &format!("{}\n\n", sentence(table.meaning));
    }
    section += &head(&["key", "values", "unless given", "example", "meaning"]);
    for key in &table.keys {
        section += &row(&[
            &code(key.name),
            &key.values,
            &unless_given(key),
            &code(&shortened(key.example, LONGEST_EXAMPLE)),
            &sentence(key.meaning),
        ]);
    }
    section
}

/// Says what a key is where it is left out; of a key of some shapes, which of them have it.
fn unless_given(key: &ReferenceKey) -> String {
    let default = key.default.as_ref().map_or(key.left_out.clone(), |value| code(value));
    let names = |is_meant: &dyn Fn(&&ShapeUse) -> bool| {
        let names: Vec<&str> = key.shapes.iter().filter(is_meant).map(|with| with.shape).collect();
        names.join(", ")
    };
    let needed = names(&|with| with.is_needed);
    match (key.shapes.is_empty(), needed.as_str()) {
        (true, _) => default,
        (false, "") => format!("{default}; only of {}", names(&|_| true)),
        (false, needed) if key.left_out == "must be given" => format!("needed by {needed}"),
        (false, needed) => format!("needed by {needed}; {default}"),
    }
}

fn units_section() -> String {
    let mut section = "\n## Units\n\n".to_owned() + &head(&["what", "units, that of SI first"]);
    for of in units() {
        let units: Vec<String> = of.units.iter().map(|unit| code(unit)).collect();
        section += &row(&[of.dimension, &units.join(", ")]);
    }
    section
        + "\nPowers may be written with or without `^`, `µ` stands for `u`, and `·` or `*` for \
               the blank between two units.\n"
}

fn varied_section(tables: &[ReferenceTable]) -> String {
    let without = |heading: &str| {
        let keys = tables.iter().flat_map(|table| &table.keys);
        let keys = keys.filter(|key| !key.varied_by.is_empty());
        let names = keys.filter(|key| !key.varied_by.contains(&heading));
        names.map(|key| code(&key.short)).collect::<Vec<_>>().join(", ")
    };
    format!(
        "\n## What cannot be drawn or derived\n\nNo sample draws {}.\n\nNo formula gives {}.\n",
        without("[sample.keys]"),
        without("[derive]")
    )
}

fn refused_section(tables: &[ReferenceTable]) -> String {
    let mut rows: Vec<(&str, &str, Vec<String>)> = Vec::new();
    for key in tables.iter().flat_map(|table| &table.keys) {
        for refused in &key.refused_by {
            let is_same = |(kind, reason, _): &&mut (&str, &str, Vec<String>)| {
                *kind == refused.kind && *reason == refused.reason
            };
            match rows.iter_mut().find(is_same) {
                Some((_, _, keys)) => keys.push(code(&key.short)),
                None => rows.push((refused.kind, refused.reason, vec![code(&key.short)])),
            }
        }
    }
    rows.sort_by_key(|(kind, _, _)| *kind);
    let mut section = "\n## What a kind of study has no use for\n\n".to_owned();
    section += &head(&["kind", "keys", "for"]);
    for (kind, reason, keys) in rows {
        section += &row(&[kind, &keys.join(", "), reason]);
    }
    section
}

/// Writes tables with their keys for the terminal.
pub(crate) fn keys_text(tables: &[ReferenceTable]) -> String {
    let mut text = String::new();
    for table in tables {
        let title = if table.heading.is_empty() { "" } else { table.heading.as_str() };
        text +=
            &format!("{}{}{}\n", title, if title.is_empty() { "" } else { "  " }, table.meaning);
        let width = table.keys.iter().map(|key| key.name.chars().count()).max().unwrap_or(0);
        for key in &table.keys {
            let indent = " ".repeat(width + 4);
            text += &format!("  {:width$}  {}\n", key.name, sentence(key.meaning));
            text += &format!("{indent}{}; {}\n", key.values, in_words(key));
        }
        text += "\n";
    }
    text.trim_end().to_owned() + "\n"
}

/// Says in words what a key is where it is left out.
fn in_words(key: &ReferenceKey) -> String {
    let said = unless_given(key).replace('`', "");
    match said.starts_with("must be") || said.starts_with("needed") {
        true => said,
        false => format!("unless given: {said}"),
    }
}

/// Writes all there is to say about one key.
pub(crate) fn key_text(table: &ReferenceTable, key: &ReferenceKey) -> String {
    let mut text = format!("{}\n  {}\n\n", key.path, sentence(key.meaning));
    let mut line = |name: &str, value: &str| {
        if !value.is_empty() {
            text += &format!("  {name:<13} {value}\n");
        }
    };
    line("values", &key.values);
    line("units", &key.units.join(", "));
    let has_words = !key.choices.is_empty() && !key.values.starts_with("one of");
    line("words", &if has_words { key.choices.join(", ") } else { String::new() });
    line("unless given", &unless_given(key).replace('`', ""));
    let shapes: Vec<&str> = key.shapes.iter().map(|with| with.shape).collect();
    line("shapes", &shapes.join(", "));
    let place = if table.heading.is_empty() { "at the top" } else { table.heading.as_str() };
    line("stands in", place);
    line("example", &format!("{} = {}", key.name, key.example));
    let varied = !key.varied_by.is_empty();
    let name = format!(" as \"{}\"", key.short);
    line("may vary by", &if varied { key.varied_by.join(", ") + &name } else { String::new() });
    let column = key.column.as_deref().unwrap_or_default();
    line(
        "column",
        &match &key.second_column {
            Some(second) => format!("{column}; of later entries like {second}"),
            None => column.to_owned(),
        },
    );
    for refused in &key.refused_by {
        line("not in kind", &format!("\"{}\": {}", refused.kind, refused.reason));
    }
    text
}
