//! `answer`: what a study says beyond its rows.

use anyhow::Result;
use store::Store;

use crate::cli::AnswerArgs;
use crate::output::{self, Finish, layout};
use crate::results::Results;
use crate::stored::{Source, stored_study, tell_origin};

pub(crate) fn answer(args: &AnswerArgs) -> Result<Finish> {
    let reader = Store::read(&args.store.store)?;
    tell_origin(&reader);
    let results = Results::read(Source::Reader(&reader), stored_study(&reader, &args.name)?)?;
    if args.json {
        let progress = results.progress();
        let study = &results.study;
        return output::print_json(&serde_json::json!({
            "study": study.name(), "question": study.question(), "progress": progress, "answers": results.answers_json()?,
        }));
    }
    if results.answers.is_empty() {
        // its rows are the answer
        let rows = results.table()?.select(&results.usual_columns(false))?;
        return output::print(
            format!("{}\n\n{}", results.study.question(), rows.terminal(&layout())).trim_start(),
        );
    }
    output::print(format!("{}\n{}", results.study.question(), results.answers_words()).trim_start())
}
