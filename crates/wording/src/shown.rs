//! Text with its hidden characters made visible.

use std::borrow::Cow;
use std::fmt::Write;

/// Returns the text with every character escaped that a terminal would obey, or that would hide or
/// reorder what stands around it: `\u{1b}`. Ends of lines are kept.
pub fn visible(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c != '\n' && is_hidden(c))
}

/// Returns the text on one line: as [`visible`] does, with ends of lines escaped as well.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, is_hidden)
}

/// Returns the beginning of a text, of at most so many characters, on [one line](one_line). If
/// something is cut off, the last character is `…`.
pub fn excerpt(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        None => one_line(text).into_owned(),
        Some(_) => {
            let kept = text.char_indices().nth(most.saturating_sub(1)).map_or(0, |(end, _)| end);
            format!("{}…", one_line(&text[..kept]))
        }
    }
}

/// Returns JSON that means the same, with the [hidden](visible) characters escaped that JSON itself
/// leaves as they are.
pub fn escaped_json(json: &str) -> Cow<'_, str> {
    let is_left = |c: char| c != '\n' && is_hidden(c);
    if !json.contains(is_left) {
        return Cow::Borrowed(json);
    }
    let mut out = String::with_capacity(json.len() + 16);
    for c in json.chars() {
        if is_left(c) {
            let mut units = [0; 2];
            for unit in c.encode_utf16(&mut units) {
                // Writing to a string does not fail.
                let _ = write!(out, "\\u{unit:04x}");
            }
        } else {
            out.push(c);
        }
    }
    Cow::Owned(out)
}

fn escaped(text: &str, is_escaped: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_escaped(c) {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    Cow::Owned(out)
}

/// Returns whether a character is a control, or an invisible one that hides or reorders others.
/// Joiners are none of these: scripts and emoji need them.
pub(crate) fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{ad}'
                | '\u{61c}'
                | '\u{180e}'
                | '\u{200b}'
                | '\u{200e}'
                | '\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2060}'..='\u{206f}'
                | '\u{feff}'
                | '\u{fff9}'..='\u{fffb}'
                | '\u{e0000}'..='\u{e007f}'
        )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn what_a_terminal_obeys_is_shown() {
        for (text, shown) in [
            ("plain, µm ≤ 3 °", "plain, µm ≤ 3 °"),
            ("\u{1b}[2J", r"\u{1b}[2J"),
            ("\u{9b}2J", r"\u{9b}2J"),
            ("a\u{202e}b\u{2066}c", r"a\u{202e}b\u{2066}c"),
            ("a\r\tb\0\u{7f}", r"a\r\tb\u{0}\u{7f}"),
            ("zero\u{200b}width\u{feff}", r"zero\u{200b}width\u{feff}"),
        ] {
            assert_eq!(visible(text), shown);
            assert_eq!(one_line(text), shown);
        }
        assert_eq!(visible("two\nlines"), "two\nlines");
        assert_eq!(one_line("two\nlines"), r"two\nlines");
    }

    #[test]
    fn an_excerpt_is_no_longer_than_asked_for() {
        assert_eq!(excerpt("abc", 3), "abc");
        assert_eq!(excerpt("abcd", 3), "ab…");
        assert_eq!(excerpt("ééééé", 3), "éé…");
        assert_eq!(excerpt("ab", 0), "…");
        assert_eq!(excerpt("", 0), "");
    }

    #[test]
    fn json_keeps_its_meaning() {
        assert_eq!(escaped_json("{\"a\": \"b\"}\n"), "{\"a\": \"b\"}\n");
        assert_eq!(escaped_json("\"\u{9b}\u{202e}\u{e0001}\""), r#""\u009b\u202e\udb40\udc01""#);
    }

    proptest! {
        #[test]
        fn nothing_hidden_is_left(text in any::<String>()) {
            prop_assert!(!one_line(&text).contains(is_hidden));
            prop_assert!(!visible(&text).contains(|c| c != '\n' && is_hidden(c)));
            prop_assert!(!escaped_json(&text).contains(|c| c != '\n' && is_hidden(c)));
        }
    }
}
