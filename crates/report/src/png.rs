//! SVG to PNG, with the embedded font alone.
//!
//! The crates that draw any SVG bring styles, filters, masks, languages that are written from the
//! right and the formats of other pictures; figures and maps need lines, areas, text and a picture
//! of pixels. So their few elements are read here and drawn by `tiny_skia`, on which those crates
//! stand too, and a part that is not known here is refused.

mod allowed;
mod attribute;
mod fault;
mod glyphs;
mod path_data;
mod pixel_canvas;

use attribute::{SVG, number};
use fault::LARGEST;
pub use fault::PngError;
use pixel_canvas::PixelCanvas;

/// Draws an SVG made by this crate as an opaque 8-bit RGB picture.
///
/// The SVG's pixel is 1/96 inch, so that a figure 480 wide becomes 1500 pixels wide at 300 dots per
/// inch; the file notes the resolution. Text is set in the embedded font, whatever fonts the
/// machine has.
///
/// # Errors
/// [`PngError`], if the SVG is not valid, if the resolution is not a positive number, or if the
/// picture would be too large or empty.
pub fn png(svg: &str, dots_per_inch: f64) -> Result<Vec<u8>, PngError> {
    if !(dots_per_inch.is_finite() && dots_per_inch > 0.0) {
        return Err(PngError::Resolution(dots_per_inch));
    }
    let document = roxmltree::Document::parse(svg)?;
    let root = document.root_element();
    if !root.has_tag_name((SVG, "svg")) {
        return Err(PngError::Unknown(format!("a root `{}`", root.tag_name().name())));
    }
    let scale = dots_per_inch / 96.0;
    let pixels = |side| Ok::<f64, PngError>((f64::from(number(root, side)?) * scale).round());
    let (width, height) = (pixels("width")?, pixels("height")?);
    let too_large = PngError::Size { width, height };
    if width.max(height) > LARGEST || width.min(height) < 1.0 {
        return Err(too_large);
    }
    let size = (width as u32, height as u32);
    let Some(mut canvas) = PixelCanvas::new(root, size, scale as f32)? else {
        return Err(too_large);
    };
    for node in root.children().filter(roxmltree::Node::is_element) {
        canvas.add(node)?;
    }
    // On white ground every pixel is opaque, so that alpha can be dropped.
    let rgb: Vec<u8> =
        canvas.pixmap.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    encode(size.0, size.1, png::ColorType::Rgb, &rgb, Some(dots_per_inch)).map_err(PngError::from)
}

/// Packs 8-bit pixels, row by row from the top, as a PNG.
pub(crate) fn encode(
    width: u32,
    height: u32,
    color: png::ColorType,
    pixels: &[u8],
    dots_per_inch: Option<f64>,
) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    if let Some(dpi) = dots_per_inch {
        let per_metre = (dpi / 0.0254).round() as u32;
        encoder.set_pixel_dims(Some(png::PixelDimensions {
            xppu: per_metre,
            yppu: per_metre,
            unit: png::Unit::Meter,
        }));
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
}
