//! `answer`: the answers of a study beyond its rows.

use std::path::Path;

use answers::{Progress, Results};
use anyhow::Result;
use wording::one_line;

use crate::answer_text::{answers_json, answers_words};
use crate::cli::AnswerArgs;
use crate::labels;
use crate::output::{self, Finish, layout};
use crate::proposal;
use crate::stored::{StoreSource, read_store, stored_study};
use crate::summary::{warning_lines, warning_words};
use crate::words::count;

/// Prints the answers of a study.
pub(crate) fn answer(args: &AnswerArgs) -> Result<Finish> {
    let reader = read_store(&args.store.store)?;
    let source = StoreSource::Reader(&reader);
    let results = Results::read(stored_study(&reader, &args.name)?, &source)?;
    let labels = reader.labels()?.remove(&args.name).unwrap_or_default();
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
        labels::add_json(&mut answer, &labels);
        return output::print_json(&answer);
    }
    // A line end in it could make a line that looks like one of ours.
    let mut text = format!("{}\n", one_line(results.study().question()));
    labels::lines(&labels).iter().for_each(|line| text += &format!("{line}\n"));
    if answers.is_empty() {
        // The rows of the study are its answer.
        text += &format!("\n{}", results.usual_table()?.terminal(&layout()));
    } else {
        text += &answers_words(answers);
    }
    let directory = &args.store.store;
    text += &incomplete(&results, directory);
    warning_lines(&results, directory).iter().for_each(|line| text += line);
    output::print(text.trim_start())
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
