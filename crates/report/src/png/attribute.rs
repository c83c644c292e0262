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
    let number = text.parse().ok().filter(|x: &f32| x.is_finite());
    number.ok_or_else(|| unknown_part(format!("a length `{text}`")))
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
