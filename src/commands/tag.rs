//! `tag`: words that are put to a study.

use anyhow::{Result, bail};

use crate::cli::TagArgs;
use crate::labels;
use crate::output::{self, Finish};
use crate::stored::{change_labels, study_labels};

/// Puts words to a study or takes them away, and prints those that it has.
pub(crate) fn tag(args: &TagArgs) -> Result<Finish> {
    let TagArgs { name, words, remove, .. } = args;
    let labels = if words.is_empty() && !remove {
        study_labels(&args.store.store, name)?
    } else {
        change_labels(&args.store.store, name, |labels| {
            if *remove {
                if let Some(unknown) = words.iter().find(|word| !labels.tags.contains(*word)) {
                    let tags = match labels::tag_words(labels) {
                        none if none.is_empty() => "none".to_owned(),
                        tags => tags,
                    };
                    bail!("the study `{name}` has no tag `{unknown}`; it has {tags}");
                }
                labels.tags.retain(|tag| !words.is_empty() && !words.contains(tag));
            } else {
                labels.tags.extend(words.iter().cloned());
            }
            labels::check(labels)
        })?
    };
    if args.json {
        return output::print_json(&serde_json::json!({ "study": name, "tags": labels.tags }));
    }
    let lines = labels.tags.iter().map(|tag| format!("{tag}\n"));
    output::print(&lines.collect::<String>())
}
