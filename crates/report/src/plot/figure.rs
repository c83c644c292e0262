//! Line charts: what they are.

use crate::fit::Fit;

/// A row of panels with one legend; drawn by [`PlotFigure::svg`].
#[derive(Debug, Clone, PartialEq)]
pub struct PlotFigure {
    /// Above the panels; empty for none.
    pub title: String,
    /// Above the legend, e.g. the name of the column that tells the series apart; empty for none.
    pub legend: String,
    /// From left to right. Axes that are equal in all panels get the same range, and the vertical
    /// one is written once.
    pub panels: Vec<PlotPanel>,
}

/// One chart.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlotPanel {
    /// Above the panel; empty for none.
    pub title: String,
    /// The horizontal axis.
    pub x: PlotAxis,
    /// The vertical axis.
    pub y: PlotAxis,
    /// The curves. Series with the same label look alike in all panels and have one entry in the
    /// legend.
    pub series: Vec<Series>,
    /// The bands behind the curves, alike and in the legend by their labels as series are.
    pub bands: Vec<PlotBand>,
    /// Whether the points of all series are marked for which no other has both a smaller x and a
    /// smaller y ([`pareto_front`](crate::pareto_front)).
    pub front: bool,
}

/// What is drawn along one direction.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PlotAxis {
    /// The quantity.
    pub label: String,
    /// Its SI unit; a prefix is chosen from the values. `"1"` for a ratio, empty for none.
    pub unit: String,
    /// Whether the axis is logarithmic. Values that are not positive are then left out, and the
    /// figure says so.
    pub log: bool,
    /// Words instead of numbers: the i-th stands at i. Empty for an axis of numbers.
    pub categories: Vec<String>,
}

/// One curve.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Its name in the legend; empty for none.
    pub label: String,
    /// Points (x, y) in SI units, in the order they are joined. A point that is not finite is a
    /// gap.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
    /// Series with the same number here share a colour, and differ in style or dashes; without one
    /// a series has its own colour.
    pub kin: Option<usize>,
    /// A line fitted to the points, drawn over its range; its slope stands in the legend, or above
    /// each of several panels.
    pub fit: Option<Fit>,
    /// What is written beside the i-th point where there is room: beside those of the front,
    /// without one beside every point. Empty for nothing.
    pub names: Vec<String>,
}

/// What lies between two curves, e.g. between a lower and an upper bound.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlotBand {
    /// Its name in the legend; empty for none.
    pub label: String,
    /// Points (x, lower end, upper end) in SI units, in the order they are joined. One whose upper
    /// end is infinite or NaN is open upwards and marked by an arrow; one without a finite x or
    /// lower end is a gap.
    pub points: Vec<(f64, f64, f64)>,
    /// Whether neighbouring points are joined; else each is a bar of its own.
    pub joined: bool,
    /// Lines fitted to the lower and to the upper ends, as for a series.
    pub fits: [Option<Fit>; 2],
}

/// How a series is drawn. Colour, marker and, where markers do not tell lines apart, dashes follow
/// from its place in the legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Style {
    /// A line through marked points; markers are thinned out when there are many.
    #[default]
    LineAndMarkers,
    /// A line alone, e.g. a closed form to compare with.
    Line,
    /// A line with a marker where it ends, e.g. a loading path.
    Path,
    /// Marked points alone.
    Markers,
}
