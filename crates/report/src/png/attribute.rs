//! Attributes of the elements of a drawing.

use roxmltree::Node;

use super::fault::PngError;

/// The name space of SVG.
pub(super) const SVG: &str = "http://www.w3.org/2000/svg";

/// Returns the fault that a drawing has a part that is not drawn.
pub(super) fn unknown_part(what: impl Into<String>) -> PngError {
    PngError::Unknown(what.into())
}

/// Returns the value of an attribute that must be there.
pub(super) fn attribute<'n>(node: Node<'n, '_>, name: &str) -> Result<&'n str, PngError> {
    let lacking =
        || unknown_part(format!("an element `{}` without `{name}`", node.tag_name().name()));
    node.attribute(name).ok_or_else(lacking)
}

/// Reads an attribute that must be a number.
pub(super) fn number(node: Node<'_, '_>, name: &str) -> Result<f32, PngError> {
    let text = attribute(node, name)?;
    coordinate(text).ok_or_else(|| unknown_part(format!("a length `{text}`")))
}

/// Reads an attribute that is a number where it is there.
pub(super) fn optional_number(
    node: Node<'_, '_>,
    name: &str,
    otherwise: f32,
) -> Result<f32, PngError> {
    match node.attribute(name) {
        Some(_) => number(node, name),
        None => Ok(otherwise),
    }
}

/// Reads a number. One that single precision cannot hold lies as far outside of every picture as
/// the largest that is drawn.
pub(super) fn coordinate(text: &str) -> Option<f32> {
    const FAR: f64 = 1e9;
    let number: f64 = text.parse().ok().filter(|x: &f64| x.is_finite())?;
    Some(number.clamp(-FAR, FAR) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_far_outside_stay_numbers_and_words_are_none() {
        assert_eq!(coordinate("2.5"), Some(2.5));
        assert_eq!(coordinate("-1e268"), Some(-1e9));
        assert_eq!(coordinate("1cm"), None);
        assert_eq!(coordinate("inf"), None);
    }
}
