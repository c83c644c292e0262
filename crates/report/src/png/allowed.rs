//! The attributes and contents that elements may have; what stands beside them is refused.

use roxmltree::Node;

use super::attribute::{SVG, number, unknown_part};
use super::fault::PngError;
use crate::font::FAMILIES;

/// The attributes by which a shape or a text is painted.
const PAINT: [&str; 7] = [
    "fill",
    "fill-opacity",
    "stroke",
    "stroke-width",
    "stroke-dasharray",
    "stroke-linejoin",
    "paint-order",
];

/// An element that figures and maps have.
struct KnownElement {
    name: &'static str,
    attributes: &'static [&'static str],
    is_painted: bool,
    /// True if other elements may stand inside.
    has_children: bool,
}

const fn plain(name: &'static str, attributes: &'static [&'static str]) -> KnownElement {
    KnownElement { name, attributes, is_painted: false, has_children: false }
}

const fn painted(name: &'static str, attributes: &'static [&'static str]) -> KnownElement {
    KnownElement { is_painted: true, ..plain(name, attributes) }
}

const fn group(name: &'static str, attributes: &'static [&'static str]) -> KnownElement {
    KnownElement { has_children: true, ..plain(name, attributes) }
}

const KNOWN: [KnownElement; 12] = [
    group("svg", &["role", "width", "height", "viewBox", "font-family", "fill"]),
    group("defs", &[]),
    group("linearGradient", &["id", "x1", "y1", "x2", "y2"]),
    plain("stop", &["offset", "stop-color"]),
    plain("title", &[]),
    plain(
        "image",
        &["x", "y", "width", "height", "href", "preserveAspectRatio", "image-rendering"],
    ),
    painted("text", &["x", "y", "font-size", "text-anchor", "transform"]),
    painted("path", &["d"]),
    painted("rect", &["x", "y", "width", "height"]),
    painted("circle", &["cx", "cy", "r"]),
    painted("line", &["x1", "y1", "x2", "y2"]),
    painted("polygon", &["points"]),
];

/// Refuses an element that is none of SVG's that are known, and what it has beside its attributes
/// and contents.
///
/// # Errors
/// [`PngError::Unknown`], with what is not known.
pub(super) fn require_known(node: Node<'_, '_>) -> Result<(), PngError> {
    let name = node.tag_name().name();
    let known = KNOWN.iter().find(|known| node.has_tag_name((SVG, known.name)));
    let Some(known) = known else { return Err(unknown_part(format!("an element `{name}`"))) };
    let is_known = |attribute: &str| {
        known.attributes.contains(&attribute) || known.is_painted && PAINT.contains(&attribute)
    };
    if let Some(unknown) = node.attributes().find(|found| !is_known(found.name())) {
        return Err(unknown_part(format!("an attribute `{}` of `{name}`", unknown.name())));
    }
    let inner = node.children().find(Node::is_element).filter(|_| !known.has_children);
    match inner {
        Some(inner) => {
            Err(unknown_part(format!("an element `{}` in `{name}`", inner.tag_name().name())))
        }
        None => Ok(()),
    }
}

/// Refuses a root that asks for another section of the drawing or another font than is drawn.
///
/// # Errors
/// [`PngError::Unknown`], with what is not known.
pub(super) fn require_root(root: Node<'_, '_>) -> Result<(), PngError> {
    require_known(root)?;
    require_value(root, "font-family", FAMILIES)?;
    let whole = [0.0, 0.0, number(root, "width")?, number(root, "height")?];
    match root.attribute("viewBox") {
        Some(section) if !section.split(' ').map(|part| part.parse().ok()).eq(whole.map(Some)) => {
            Err(unknown_part(format!("a section `{section}`")))
        }
        _ => Ok(()),
    }
}

/// Refuses an attribute that has another value than the one that is drawn.
///
/// # Errors
/// [`PngError::Unknown`], with the value.
pub(super) fn require_value(node: Node<'_, '_>, name: &str, drawn: &str) -> Result<(), PngError> {
    match node.attribute(name) {
        Some(value) if value != drawn => {
            Err(unknown_part(format!("an attribute `{name}` that is `{value}`")))
        }
        _ => Ok(()),
    }
}
