//! The commit of a package that was unpacked, as Cargo noted it there.

/// Returns the commit that a note names, with the words that say whether files differed from it.
pub(crate) fn packed_commit(note: &str) -> Option<(String, &'static str)> {
    let (_, rest) = note.split_once("\"sha1\"")?;
    let commit = rest.trim_start_matches([':', ' ']).strip_prefix('"')?.split('"').next()?;
    let is_commit = commit.len() >= 40 && commit.bytes().all(|byte| byte.is_ascii_hexdigit());
    let is_dirty = note.replace(' ', "").contains("\"dirty\":true");
    is_commit.then(|| (commit.to_owned(), if is_dirty { "true" } else { "false" }))
}
