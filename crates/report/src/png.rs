//! SVG to PNG, with the embedded font alone.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg;
use thiserror::Error;

/// A reason why an SVG cannot become a PNG.
#[derive(Debug, Error)]
pub enum PngError {
    /// The text is not an SVG that can be drawn.
    #[error("the figure is not valid SVG: {0}")]
    Svg(#[from] usvg::Error),
    /// The picture would be too large.
    #[error(
        "a picture of {width}×{height} pixels is too large; at most {LARGEST} pixels a side are \
         drawn; ask for fewer dots per inch"
    )]
    Size {
        /// The number of pixels across.
        width: f64,
        /// The number of pixels down.
        height: f64,
    },
    /// The resolution is not a positive number.
    #[error("{0} dots per inch make no picture; 300 is usual for print")]
    Resolution(f64),
    /// The pixels could not be packed.
    #[error("the picture could not be encoded: {0}")]
    Encoding(#[from] png::EncodingError),
}

/// The largest side of a picture, in pixels.
const LARGEST: f64 = 20_000.0;

/// The embedded font and no other.
static FONTS: LazyLock<Arc<usvg::fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = usvg::fontdb::Database::new();
    fonts.load_font_data(crate::font::FONT.to_vec());
    Arc::new(fonts)
});

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
    let options = usvg::Options {
        font_family: "Arimo".to_owned(),
        fontdb: FONTS.clone(),
        ..Default::default()
    };
    let tree = usvg::Tree::from_str(svg, &options)?;
    let scale = dots_per_inch / 96.0;
    let (width, height) = (
        (f64::from(tree.size().width()) * scale).round(),
        (f64::from(tree.size().height()) * scale).round(),
    );
    let too_large = PngError::Size { width, height };
    if width.max(height) > LARGEST || width.min(height) < 1.0 {
        return Err(too_large);
    }
    let Some(mut pixmap) = Pixmap::new(width as u32, height as u32) else { return Err(too_large) };
    pixmap.fill(resvg::tiny_skia::Color::WHITE);
    resvg::render(&tree, Transform::from_scale(scale as f32, scale as f32), &mut pixmap.as_mut());
    // On white ground every pixel is opaque, so that alpha can be dropped.
    let rgb: Vec<u8> = pixmap.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    encode(width as u32, height as u32, png::ColorType::Rgb, &rgb, Some(dots_per_inch))
        .map_err(PngError::from)
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
