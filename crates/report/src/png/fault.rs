//! Faults of drawings that are to become pixels.

use thiserror::Error;

/// The largest side of a picture, in pixels.
pub(super) const LARGEST: f64 = 20_000.0;

/// A reason why an SVG cannot become a PNG.
#[derive(Debug, Error)]
pub enum PngError {
    /// The text is not an SVG that can be drawn.
    #[error("the figure is not valid SVG: {0}")]
    Svg(#[from] roxmltree::Error),
    /// The SVG has a part that figures and maps never have.
    #[error("the figure has {0}, which is not drawn as pixels")]
    Unknown(String),
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
