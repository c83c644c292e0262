//! The words and signs of an expression: names, numbers, texts, operators.

use crate::error::FilterError;
use crate::quoted::quoted;
use crate::syntax::syntax_error;

/// The operators and brackets; of two that begin alike the longer one stands first.
const SIGNS: [&str; 24] = [
    "==", "!=", "<=", ">=", "&&", "||", "<", ">", "[", "]", "{", "}", "(", ")", ".", ",", "-", "!",
    "?", ":", "+", "*", "/", "%",
];
/// The characters of operators, which a message about one that does not exist shows together.
const OPERATOR_CHARACTERS: [char; 6] = ['=', '<', '>', '&', '|', '!'];

/// A word or sign of an expression.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Token<'t> {
    /// The end of the expression.
    End,
    /// An operator, a bracket, or one of `in`, `true`, `false`, `null`.
    Sign(&'static str),
    /// A name without dots.
    Name(&'t str),
    /// A whole number: decimal digits, or `0x` with hexadecimal digits.
    Whole(&'t str),
    /// A whole number that is marked with `u`, without the mark.
    Unsigned(&'t str),
    /// A number with a fraction or an exponent.
    Fraction(&'t str),
    /// A text in quotes with its escapes resolved.
    Text(String),
    /// Bytes in quotes, which are no value of a condition.
    Bytes,
}

/// A word or sign with its place.
#[derive(Clone, Debug)]
pub(crate) struct PlacedToken<'t> {
    pub(crate) token: Token<'t>,
    /// The offset of its first byte.
    pub(crate) start: usize,
    /// The offset behind its last byte.
    pub(crate) end: usize,
}

/// Reads the word or sign that comes at or after an offset, behind blanks and comments.
///
/// # Errors
/// [`FilterError::Syntax`], if nothing that the grammar has begins there.
pub(crate) fn token_at(text: &str, offset: usize) -> Result<PlacedToken<'_>, FilterError> {
    let start = offset + blank(&text[offset..]);
    let rest = &text[start..];
    let found = match quoted(text, start)? {
        Some(found) if found.is_bytes => Some((Token::Bytes, found.length)),
        Some(found) => Some((Token::Text(found.content), found.length)),
        None => number(rest).or_else(|| word(rest)).or_else(|| sign(rest)),
    };
    let (token, length) = found.ok_or_else(|| unknown(text, start))?;
    Ok(PlacedToken { token, start, end: start + length })
}

/// Returns the length of the blanks and comments that a text begins with.
fn blank(text: &str) -> usize {
    let mut rest = text;
    loop {
        let trimmed = rest.trim_start_matches([' ', '\t', '\r', '\n', '\u{c}']);
        rest = match trimmed.strip_prefix("//") {
            Some(comment) => comment.trim_start_matches(|c| c != '\n'),
            None => return text.len() - trimmed.len(),
        };
    }
}

/// Reports what nothing of the grammar begins with.
fn unknown(text: &str, start: usize) -> FilterError {
    let rest = &text[start..];
    let operator = leading(rest, |c| OPERATOR_CHARACTERS.contains(&c));
    let length = operator.max(rest.chars().next().map_or(0, char::len_utf8));
    syntax_error(text, start, &format!("unexpected '{}'", &rest[..length]))
}

/// Returns the length of the longest beginning of a text that has such characters alone.
fn leading(text: &str, is_part: impl Fn(char) -> bool) -> usize {
    text.len() - text.trim_start_matches(is_part).len()
}

fn digits(text: &str) -> usize {
    leading(text, |c| c.is_ascii_digit())
}

/// Reads a number with its length.
fn number(rest: &str) -> Option<(Token<'_>, usize)> {
    let hexadecimal =
        rest.strip_prefix("0x").map_or(0, |rest| leading(rest, |c| c.is_ascii_hexdigit()));
    let whole = if hexadecimal > 0 { 2 + hexadecimal } else { digits(rest) };
    let mut length = whole;
    if hexadecimal == 0 {
        length +=
            rest[length..].strip_prefix('.').map(digits).filter(|&n| n > 0).map_or(0, |n| n + 1);
        length += if length > 0 { exponent(&rest[length..]) } else { 0 };
    }
    match &rest[..length] {
        "" => None,
        number if length > whole => Some((Token::Fraction(number), length)),
        number if rest[length..].starts_with(['u', 'U']) => {
            Some((Token::Unsigned(number), length + 1))
        }
        number => Some((Token::Whole(number), length)),
    }
}

/// Returns the length of the exponent that a text begins with.
fn exponent(rest: &str) -> usize {
    let Some(behind) = rest.strip_prefix(['e', 'E']) else { return 0 };
    let behind = behind.strip_prefix(['+', '-']).unwrap_or(behind);
    match digits(behind) {
        0 => 0,
        count => rest.len() - behind.len() + count,
    }
}

/// Reads a name or a keyword with its length. A number does not stand here.
fn word(rest: &str) -> Option<(Token<'_>, usize)> {
    let length = leading(rest, |c| c.is_ascii_alphanumeric() || c == '_');
    let token = match &rest[..length] {
        "" => return None,
        "in" => Token::Sign("in"),
        "true" => Token::Sign("true"),
        "false" => Token::Sign("false"),
        "null" => Token::Sign("null"),
        name => Token::Name(name),
    };
    Some((token, length))
}

/// Reads an operator, a bracket or the end with its length.
fn sign(rest: &str) -> Option<(Token<'_>, usize)> {
    if rest.is_empty() {
        return Some((Token::End, 0));
    }
    SIGNS
        .into_iter()
        .find(|sign| rest.starts_with(sign))
        .map(|sign| (Token::Sign(sign), sign.len()))
}
