//! `answer`: the answers of a study beyond its rows.

use std::path::Path;

use answers::{Progress, Results, Selection};
use anyhow::Result;
use wording::one_line;

use crate::answer_text::{answers_json, answers_words};
use crate::cli::AnswerArgs;
use crate::labels;
use crate::output::{self, Finish, layout};
use crate::proposal;
use crate::stored_results::StoredResults;
use crate::summary::{warning_lines, warning_words};
use crate::table_file::{TableRows, write_table};
use crate::words::count;

/// Prints the answers of a study.
pub(crate) fn answer(args: &AnswerArgs) -> Result<Finish> {
    let stored = StoredResults::of(&args.store.store, &args.name)?;
    let results = stored.read()?;
    let labels = stored.labels();
    let about = match &args.column[..] {
        [] => None,
        columns => Some(results.about(columns)?),
    };
    let answers = match &about {
        Some(about) => about,
        None => results.answers()?,
    };
    if args.json {
        let progress = results.progress();
        let study = results.study();
        let mut answer = serde_json::json!({
            "study": study.name(),
            "question": study.question(),
            "progress": progress,
            "answers": answers_json(answers)?,
            "inaccurate": results.inaccurate(),
            "warnings": warning_words(&results),
        });
        labels::add_json(&mut answer, labels);
        return output::print_json(&answer);
    }
    let mut is_begun = false;
    // A line end in it could make a line that looks like one of ours.
    let mut text = format!("{}\n", one_line(results.study().question()));
    labels::lines(labels).iter().for_each(|line| text += &format!("{line}\n"));
    if answers.is_empty() {
        // The rows of the study are its answer.
        text += "\n";
        if stored.are_long() {
            output::print(text.trim_start())?;
            write_rows(&stored, &results)?;
            text.clear();
            is_begun = true;
        } else {
            text += &results.usual_table(usize::MAX)?.terminal(&layout());
        }
    } else {
        text += &answers_words(answers);
    }
    let directory = &args.store.store;
    text += &excluded(&results);
    text += &incomplete(&results, directory);
    warning_lines(&results, directory).iter().for_each(|line| text += line);
    output::print(if is_begun { &text } else { text.trim_start() })
}

/// Writes the usual columns of every point, block by block.
fn write_rows(stored: &StoredResults<'_>, results: &Results<'_>) -> Result<()> {
    let columns = results.usual_columns(false)?;
    let source = stored.rows(&columns);
    let selection = Selection { columns, ..Selection::default() };
    let (selection, study) = (&selection, stored.study());
    write_table(&TableRows::Selected { selection, study, source }, None).map(drop)
}

/// Says how many points the conditions of the study leave out; nothing if there are none.
fn excluded(results: &Results<'_>) -> String {
    let Progress { points, excluded, .. } = results.progress();
    match excluded {
        0 => String::new(),
        _ => {
            let studied = count(points, "point", "points");
            format!("\n{studied}; {excluded} more of the axes are excluded by the study\n")
        }
    }
}

/// Says how many points have no solution, and the command that lists them; nothing if all have.
fn incomplete(results: &Results<'_>, directory: &Path) -> String {
    let Progress { points, failed, left, .. } = results.progress();
    if failed + left == 0 {
        return String::new();
    }
    let of = count(points, "point", "points");
    let filter = if failed > 0 { "status != \"certified\"" } else { "status == null" };
    let query = ["query", results.study().name(), "--where", filter];
    format!("\n{failed} of {of} failed, {left} left: {}\n", proposal::command(directory, query))
}
