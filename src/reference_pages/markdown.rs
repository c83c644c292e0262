//! The notation of the pages.

/// The command that writes the pages, in words for whoever would edit them.
pub(super) const WRITTEN: &str = "<!-- This page is written by \
    `tribosweep reference docs/book/src/reference`: the program holds what it says. -->\n\n";

/// Writes a row of a table.
pub(super) fn row(cells: &[&str]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    format!("| {} |\n", cells.join(" | "))
}

/// Writes the head of a table.
pub(super) fn head(names: &[&str]) -> String {
    row(names) + &row(&vec!["---"; names.len()])
}

/// Writes a text as code.
pub(super) fn code(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("`{text}`") }
}

/// Makes a fragment a sentence: with a capital and a full stop.
pub(super) fn sentence(fragment: &str) -> String {
    let mut letters = fragment.chars();
    let first = letters.next().map(|c| c.to_uppercase().to_string()).unwrap_or_default();
    let stop = if fragment.ends_with(['.', '?', '!']) { "" } else { "." };
    format!("{first}{}{stop}", letters.as_str())
}

/// Returns a text cut to so many characters.
pub(super) fn shortened(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{} …", text[..end].trim_end()),
        None => text.to_owned(),
    }
}
