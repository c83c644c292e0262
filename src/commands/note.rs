//! `note`: a remark that is put to a study.

use anyhow::Result;

use crate::cli::NoteArgs;
use crate::output::{self, Finish};
use crate::stored::{change_labels, study_labels};

/// Puts a remark to a study or takes it away, and prints the one that it has.
pub(crate) fn note(args: &NoteArgs) -> Result<Finish> {
    let NoteArgs { name, text, remove, .. } = args;
    let labels = if text.is_none() && !remove {
        study_labels(&args.store.store, name)?
    } else {
        change_labels(&args.store.store, name, |labels| {
            labels.note.clone_from(text);
            Ok(())
        })?
    };
    if args.json {
        return output::print_json(&serde_json::json!({ "study": name, "note": labels.note }));
    }
    output::print(&labels.note.map_or_else(String::new, |note| format!("{note}\n")))
}
