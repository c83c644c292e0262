//! The message about an expression that does not follow the grammar.

use crate::error::FilterError;

/// Reports the first of the parser's errors in words of our own, with its place.
pub(crate) fn syntax_error(expression: &str, errors: &cel::ParseErrors) -> FilterError {
    let flat: String = expression.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let first = errors.errors.first();
    // CEL counts lines from 1 and columns from 0 or 1, in characters.
    let (line, column) = first.map_or((1, 1), |e| e.pos);
    let before: usize = expression
        .split('\n')
        .take(usize::try_from(line - 1).unwrap_or(0))
        .map(|l| l.chars().count() + 1)
        .sum();
    let position =
        (before + usize::try_from(column).unwrap_or(0)).clamp(1, flat.chars().count() + 1);
    let message = first.map_or("syntax error", |e| e.msg.as_str());
    let message = message.strip_prefix("Syntax error: ").unwrap_or(message);
    // The list of every token that could have stood there helps nobody, nor do the words of a
    // parser.
    let mut message =
        message.split(" expecting ").next().unwrap_or(message).replace(['\n', '\r'], " ");
    for (theirs, ours) in [
        ("token recognition error at:", "unexpected"),
        ("mismatched input", "unexpected"),
        ("extraneous input", "unexpected"),
        ("no viable alternative at input", "unexpected"),
        ("'<EOF>'", "end of the expression"),
    ] {
        message = message.replace(theirs, ours);
    }
    // Two errors of the parser have texts for its programmers.
    if message.contains("Recursion limit") {
        message = "too many brackets inside each other".to_owned();
    } else if message.starts_with("Incomplete") {
        message = "something is missing".to_owned();
    }
    FilterError::Syntax { message, position, hint: hint(&flat), expression: flat }
}

/// Guesses what people mean who know another language; empty if nothing comes to mind.
fn hint(expression: &str) -> String {
    let padded = format!(" {} ", expression.to_lowercase());
    let single_equals = expression.char_indices().any(|(i, c)| {
        c == '='
            && !expression[..i].ends_with(['=', '!', '<', '>'])
            && !expression[i + 1..].starts_with('=')
    });
    let advice = if ["=>", "=<"].iter().any(|wrong| expression.contains(wrong)) {
        "at least, at most are written >=, <="
    } else if single_equals {
        "equality is written =="
    } else if [" and ", " or ", " not "].iter().any(|word| padded.contains(word)) {
        "and, or, not are written &&, ||, !"
    } else if expression.replace("&&", "").contains('&')
        || expression.replace("||", "").contains('|')
    {
        "and, or are written &&, ||"
    } else {
        return String::new();
    };
    format!("\n  {advice}")
}
