//! The message about an expression that does not follow the grammar.

use crate::error::FilterError;

/// Reports a fault at an offset of an expression.
pub(crate) fn syntax_error(expression: &str, offset: usize, message: &str) -> FilterError {
    let flat = |text: &str| -> String {
        text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
    };
    let position = expression[..offset].chars().count() + 1;
    let expression = flat(expression);
    FilterError::Syntax { message: flat(message), position, hint: hint(&expression), expression }
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
