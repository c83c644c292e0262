//! A drawn figure with what a page needs to answer a pointer.

/// A figure as SVG whose points are known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FigureSketch {
    /// The picture.
    pub svg: String,
    /// The labels of the legend's entries; an attribute `data-entry` holds an index among them.
    pub entries: Vec<String>,
    /// The horizontal and the vertical axis of each panel.
    pub axes: Vec<[SketchAxis; 2]>,
    /// Every point that is drawn.
    pub spots: Vec<FigureSpot>,
}

/// The meaning of the values along an axis.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SketchAxis {
    /// The name of the quantity.
    pub label: String,
    /// The unit with its prefix, as it is written at the axis.
    pub unit: String,
    /// The power of ten by which SI values are divided to be read in the unit.
    pub exponent: i32,
    /// The words of an axis of categories; empty for an axis of numbers.
    pub categories: Vec<String>,
}

/// A point of a figure in its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FigureSpot {
    /// The index of the panel.
    pub panel: usize,
    /// The index of the legend's entry that it belongs to.
    pub entry: usize,
    /// The place in the picture, in pixels from its upper left corner.
    pub place: (f64, f64),
    /// The values in SI units.
    pub values: (f64, f64),
    /// The row of the table that it comes from, if it comes from one.
    pub row: Option<usize>,
}
