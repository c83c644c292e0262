//! `answer`: the answers of a study beyond its rows.

use answers::Results;
use anyhow::Result;
use store::Store;
use wording::one_line;

use crate::answer_text::{answers_json, answers_words};
use crate::cli::AnswerArgs;
use crate::output::{self, Finish, layout};
use crate::stored::{StoreSource, stored_study, tell_origin};

/// Prints the answers of a study.
pub(crate) fn answer(args: &AnswerArgs) -> Result<Finish> {
    let reader = Store::read(&args.store.store)?;
    tell_origin(&reader);
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
    // A line end in it could make a line that looks like one of ours.
    let question = one_line(results.study().question());
    if results.answers()?.is_empty() {
        // The rows of the study are its answer.
        let rows = results.usual_table()?;
        return output::print(format!("{question}\n\n{}", rows.terminal(&layout())).trim_start());
    }
    output::print(format!("{question}\n{}", answers_words(results.answers()?)).trim_start())
}
