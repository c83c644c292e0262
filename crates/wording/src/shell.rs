//! Commands that can be pasted into a shell.

use std::borrow::Cow;
use std::ffi::OsStr;
use std::fmt::Write;
use std::path::Path;

use crate::shown::is_hidden;

/// Returns a command of this program with its arguments quoted.
pub fn command<Word: AsRef<OsStr>>(arguments: impl IntoIterator<Item = Word>) -> String {
    arguments.into_iter().fold("tribosweep".to_owned(), |command, argument| {
        format!("{command} {}", shell_word(argument))
    })
}

/// Returns the text as one word of a shell's command: as it is, if nothing in it is special, else
/// in quotes. What cannot be shown is written as bash, zsh and POSIX.1-2024 have it, `$'\033'`.
pub fn shell_word(text: impl AsRef<OsStr>) -> String {
    let text = text.as_ref();
    if let Some(plain) = text.to_str().filter(|plain| !plain.contains(is_hidden))
        && let Ok(quoted) = shlex::try_quote(plain)
    {
        return quoted.into_owned();
    }
    let mut word = "$'".to_owned();
    for chunk in text.as_encoded_bytes().utf8_chunks() {
        for c in chunk.valid().chars() {
            match c {
                '\\' | '\'' => word.extend(['\\', c]),
                c if is_hidden(c) => {
                    let mut bytes = [0; 4];
                    escape(&mut word, c.encode_utf8(&mut bytes).as_bytes());
                }
                c => word.push(c),
            }
        }
        escape(&mut word, chunk.invalid());
    }
    word + "'"
}

/// Returns the path of a file as an argument that no program takes for an option.
pub fn file_argument(path: &Path) -> Cow<'_, OsStr> {
    if path.as_os_str().as_encoded_bytes().starts_with(b"-") {
        Cow::Owned(Path::new(".").join(path).into_os_string())
    } else {
        Cow::Borrowed(path.as_os_str())
    }
}

/// Writes bytes as octal escapes, which end after three digits whatever follows.
fn escape(word: &mut String, bytes: &[u8]) {
    for byte in bytes {
        // Writing to a string does not fail.
        let _ = write!(word, "\\{byte:03o}");
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn words_that_need_it_are_quoted() {
        for (text, word) in [
            ("stick-zone", "stick-zone"),
            ("sweeps/a.toml", "sweeps/a.toml"),
            ("my study.toml", "'my study.toml'"),
            ("", "''"),
            ("a;rm -rf b", "'a;rm -rf b'"),
            ("$(x)`y`", "'$(x)`y`'"),
            ("it's", "\"it's\""),
            ("a\u{1b}b'c\\", "$'a\\033b\\'c\\\\'"),
        ] {
            assert_eq!(shell_word(text), word);
        }
        assert_eq!(file_argument(Path::new("-x.toml")).to_str(), Some("./-x.toml"));
        assert_eq!(
            command(["query", "s", "--where", "mu > 0"]),
            "tribosweep query s --where 'mu > 0'"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_path_that_is_no_text_is_a_word() {
        use std::os::unix::ffi::OsStrExt;
        assert_eq!(shell_word(OsStr::from_bytes(b"a\xff b")), "$'a\\377 b'");
    }

    proptest! {
        #[test]
        fn a_word_shows_nothing_hidden_and_reads_back(text in "[^\0]*") {
            let word = shell_word(&text);
            prop_assert!(!word.contains(is_hidden));
            if !word.starts_with('$') {
                prop_assert_eq!(shlex::split(&word), Some(vec![text]));
            }
        }
    }
}
