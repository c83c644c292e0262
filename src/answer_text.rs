//! The answers of a study beyond its rows, to be read and as JSON.

use answers::AnswerTable;
use anyhow::Result;
use report::Cell;

use crate::output::layout;

/// Returns the answers to be read, each table under its title.
pub(crate) fn answers_words(answers: &[AnswerTable]) -> String {
    let words = |AnswerTable { title, table }: &AnswerTable| match (table.columns(), table.rows()) {
        // A table of one cell is a sentence.
        ([_], [row]) => format!("\n{}\n", row.iter().map(words_of).collect::<String>()),
        _ => format!("\n{title}\n{}", table.terminal(&layout())),
    };
    answers.iter().map(words).collect()
}

/// Returns the answers by title, as rows by column.
pub(crate) fn answers_json(answers: &[AnswerTable]) -> Result<serde_json::Value> {
    let rows = answers.iter().map(|AnswerTable { title, table }| {
        Ok((title.to_string(), serde_json::from_str(&table.json())?))
    });
    Ok(serde_json::Value::Object(rows.collect::<Result<_>>()?))
}

fn words_of(cell: &Cell) -> &str {
    if let Cell::Text(words) = cell { words } else { "" }
}
