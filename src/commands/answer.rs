//! `answer`: the answers of a study beyond its rows.

use answers::Results;
use anyhow::Result;

use crate::answer_text::{answers_json, answers_words};
use crate::cli::AnswerArgs;
use crate::output::{self, Finish, layout};
use crate::stored::{StoreSource, read_store, stored_study};

/// Prints the answers of a study.
pub(crate) fn answer(args: &AnswerArgs) -> Result<Finish> {
    let reader = read_store(&args.store.store)?;
    let source = StoreSource::Reader(&reader);
    let results = Results::read(stored_study(&reader, &args.name)?, &source)?;
    if args.json {
        let progress = results.progress();
        let study = results.study();
        return output::print_json(&serde_json::json!({
            "study": study.name(),
            "question": study.question(),
            "progress": progress,
            "answers": answers_json(results.answers()?)?,
        }));
    }
    if results.answers()?.is_empty() {
        // The rows of the study are its answer.
        let rows = results.usual_table()?;
        return output::print(
            format!("{}\n\n{}", results.study().question(), rows.terminal(&layout())).trim_start(),
        );
    }
    output::print(
        format!("{}\n{}", results.study().question(), answers_words(results.answers()?))
            .trim_start(),
    )
}
