//! Texts in quotes: `"…"`, `'…'`, over several lines in three quotes, without escapes behind `r`,
//! and bytes behind `b`.

use crate::error::FilterError;
use crate::syntax::syntax_error;

/// A text in quotes.
pub(crate) struct QuotedText {
    /// The text with its escapes resolved.
    pub(crate) content: String,
    /// True if the text stands for bytes.
    pub(crate) is_bytes: bool,
    /// The length with its quotes and what stands before them, in bytes.
    pub(crate) length: usize,
}

/// Reads the text in quotes that begins at an offset, if one does.
///
/// # Errors
/// [`FilterError::Syntax`], if the text is not closed or has an escape that does not exist.
pub(crate) fn quoted(text: &str, start: usize) -> Result<Option<QuotedText>, FilterError> {
    let rest = &text[start..];
    let behind_bytes = rest.strip_prefix(['b', 'B']);
    let behind_raw = behind_bytes.unwrap_or(rest).strip_prefix(['r', 'R']);
    let body = behind_raw.or(behind_bytes).unwrap_or(rest);
    let Some(quote) = ["\"\"\"", "'''", "\"", "'"].into_iter().find(|q| body.starts_with(q)) else {
        return Ok(None);
    };
    let mut content = String::new();
    let mut offset = text.len() - body.len() + quote.len();
    loop {
        let rest = &text[offset..];
        if rest.starts_with(quote) {
            break;
        }
        let (c, length) = match rest.chars().next() {
            Some('\\') if behind_raw.is_none() => escape(&rest[1..]).ok_or_else(|| {
                let shown: String = rest.chars().take(2).collect();
                syntax_error(text, offset, &format!("unknown escape '{shown}'"))
            })?,
            // Line ends of all systems are one in a text of several lines.
            Some('\r') if quote.len() == 3 => ('\n', if rest.starts_with("\r\n") { 2 } else { 1 }),
            Some(c) if quote.len() == 3 || !matches!(c, '\n' | '\r') => (c, c.len_utf8()),
            _ => {
                let message = format!("missing {quote} for the text that begins");
                return Err(syntax_error(text, start, &message));
            }
        };
        content.push(c);
        offset += length;
    }
    let length = offset + quote.len() - start;
    Ok(Some(QuotedText { content, is_bytes: behind_bytes.is_some(), length }))
}

/// Returns the character that an escape stands for, and the length of the escape with its
/// backslash; `rest` comes behind the backslash.
fn escape(rest: &str) -> Option<(char, usize)> {
    let first = rest.chars().next()?;
    let (radix, digits) = match first {
        'a' => return Some(('\u{7}', 2)),
        'b' => return Some(('\u{8}', 2)),
        'f' => return Some(('\u{c}', 2)),
        'n' => return Some(('\n', 2)),
        'r' => return Some(('\r', 2)),
        't' => return Some(('\t', 2)),
        'v' => return Some(('\u{b}', 2)),
        '\\' | '\'' | '"' | '`' | '?' => return Some((first, 2)),
        'x' | 'X' => (16, rest.get(1..3)?),
        'u' => (16, rest.get(1..5)?),
        'U' => (16, rest.get(1..9)?),
        '0'..='3' => (8, rest.get(..3)?),
        _ => return None,
    };
    if !digits.chars().all(|digit| digit.is_digit(radix)) {
        return None;
    }
    let c = char::from_u32(u32::from_str_radix(digits, radix).ok()?)?;
    Some((c, digits.len() + if radix == 8 { 1 } else { 2 }))
}
