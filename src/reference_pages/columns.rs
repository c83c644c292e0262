//! The columns of results.

use study::reference::{ReferenceColumn, columns};

use super::markdown::{WRITTEN, code, head, row, sentence};

/// The titles of the sections, by the role of their columns.
const SECTIONS: [(&str, &str, &str); 7] = [
    ("status", "How jobs ended", "Every result has these."),
    ("place", "Place on the path", "Only tables of increments have these: `query --steps`."),
    ("observable", "Quantities of solutions", "They are those at the end of the loading path."),
    (
        "certificate",
        "Certificates",
        "Residuals that code computes which shares nothing with the solver.",
    ),
    ("error", "Errors", "Estimates, and distances from closed forms or finer meshes."),
    ("work", "Work", "Counts that are the same on every machine."),
    ("provenance", "Provenance", "These differ from run to run."),
];

/// Writes the page of the columns.
pub(crate) fn columns_page() -> String {
    let mut page = format!("{WRITTEN}# Columns of results\n\n");
    page += "What a table of results may have. `query --select`, `--where` and `--sort`, `plot`, \
             `[figure]`, `[find]`, `[fill]`, `[refine]` and exports call columns by these names. \
             `tribosweep columns` prints this in the shell, and `tribosweep query NAME --columns` \
             the columns of one study. Beside these a study has a column for each axis and for each \
             key that it gives: see [its keys](keys.md); `tribosweep keys friction.mu` names it.\n\n\
             A column is empty where a scene has no such quantity, and where a job has no certified \
             solution. Values are in SI units. Where no kinds are named, every kind of study that \
             solves scenes has the column.\n";
    let all = columns();
    let solving = kinds_of(&all, "load");
    for (role, title, about) in SECTIONS {
        page += &format!("\n## {title}\n\n{about}\n\n");
        page += &head(&["column", "unit", "meaning"]);
        for column in all.iter().filter(|column| column.role == role) {
            page += &row(&[&code(&column.name), unit(column), &meaning(column, &solving)]);
        }
    }
    page
}

/// Returns the kinds of study that have a column.
fn kinds_of(all: &[ReferenceColumn], name: &str) -> Vec<&'static str> {
    all.iter().find(|column| column.name == name).map_or(Vec::new(), |column| column.kinds.clone())
}

/// Returns the unit of a column, or what stands there in place of a number.
fn unit(column: &ReferenceColumn) -> &'static str {
    match (column.values, column.unit) {
        ("number", "") => "1",
        ("number", unit) => unit,
        (values, _) => values,
    }
}

/// Returns the meaning, with the kinds of study that have the column if not all have that solve.
fn meaning(column: &ReferenceColumn, solving: &[&str]) -> String {
    let said = sentence(column.meaning);
    let has = |kind: &&str| column.kinds.contains(kind);
    match solving.iter().all(has) {
        true => said,
        false => format!("{said} Kinds: {}.", column.kinds.join(", ")),
    }
}

/// Writes columns for the terminal.
pub(crate) fn columns_text(columns: &[ReferenceColumn]) -> String {
    let width = |of: &dyn Fn(&ReferenceColumn) -> usize| columns.iter().map(of).max().unwrap_or(0);
    let name = width(&|column| column.name.chars().count());
    let units = width(&|column| unit(column).chars().count());
    let solving = kinds_of(&study::reference::columns(), "load");
    let line = |column: &ReferenceColumn| {
        let (unit, said) = (unit(column), meaning(column, &solving));
        format!("{:name$}  {unit:units$}  {said}\n", column.name)
    };
    columns.iter().map(line).collect()
}
