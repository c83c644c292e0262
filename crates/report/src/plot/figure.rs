//! The parts of a line chart.

use crate::fit::Fit;

/// A row of panels with one legend; [`PlotFigure::svg`] draws it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotFigure {
    /// The title above the panels; empty for none.
    pub title: String,
    /// The heading of the legend, e.g. the name of the column that tells the series apart; empty
    /// for none.
    pub legend: String,
    /// Sentences that stand below the panels, e.g. about points that are missing.
    pub notes: Vec<String>,
    /// The panels from left to right. Axes that are equal in all panels get the same range, and the
    /// vertical one is written once.
    pub panels: Vec<PlotPanel>,
}

/// One chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlotPanel {
    /// The title above the panel; empty for none.
    pub title: String,
    /// The horizontal axis.
    pub x: PlotAxis,
    /// The vertical axis.
    pub y: PlotAxis,
    /// The curves. Series with the same label look alike in all panels and have one entry in the
    /// legend.
    pub series: Vec<Series>,
    /// The bands behind the curves. Bands with the same label look alike and have one entry in the
    /// legend, as series do.
    pub bands: Vec<PlotBand>,
    /// True if the Pareto front is marked: the points of all series that no other one beats within
    /// the noise of x ([`pareto_front_within`](crate::pareto_front_within)).
    pub front: bool,
    /// The value along y, in SI units, at which a level is drawn, with a mark wherever a curve
    /// crosses it.
    pub level: Option<f64>,
}

/// The quantity along one direction.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PlotAxis {
    /// The name of the quantity.
    pub label: String,
    /// The SI unit; a prefix is chosen from the values. `"1"` for a ratio, empty for none.
    pub unit: String,
    /// True if the axis is logarithmic. Values that are not positive are then left out, and the
    /// figure says so.
    pub log: bool,
    /// The words of an axis of categories: the i-th stands at i. Empty for an axis of numbers.
    pub categories: Vec<String>,
    /// True if an axis of numbers, none of which is negative, begins at 0.
    pub from_zero: bool,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// The name in the legend; empty for none.
    pub label: String,
    /// The points (x, y) in SI units, in the order in which they are joined. A point that is not
    /// finite is a gap.
    pub points: Vec<(f64, f64)>,
    /// The style of the line and its markers.
    pub style: Style,
    /// The number of a family of series: series with the same number share a colour, and differ in
    /// style or dashes. A series without a number has a colour to itself.
    pub kin: Option<usize>,
    /// A line fitted to the points, drawn over its range. Its slope stands in the legend, or above
    /// each of several panels.
    pub fit: Option<Fit>,
    /// The noise of x on either side, relative to x, by the index of the point; empty for none.
    pub noise: Vec<f64>,
    /// The names beside points, by their index, as far as there is room: beside those of the front,
    /// or beside every point if there is no front. Empty for no name.
    pub names: Vec<String>,
    /// The width of the bars in SI units, or in categories; for [`Style::WhiskerBars`] alone.
    pub bar_width: f64,
    /// The lower and the upper end of the whisker of each bar, NaN for none; empty without
    /// whiskers.
    pub whiskers: Vec<[f64; 2]>,
    /// The row of the table that each point comes from, by the index of the point, `None` at a gap;
    /// empty if there is no table.
    pub rows: Vec<Option<usize>>,
}

/// The area between two curves, e.g. between a lower and an upper bound.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlotBand {
    /// The name in the legend; empty for none.
    pub label: String,
    /// The ends at each x, in the order in which they are joined.
    pub points: Vec<BandPoint>,
    /// True if neighbouring points are joined; otherwise each point is a bar by itself.
    pub joined: bool,
    /// The lines fitted to the lower and to the upper ends, as for a series.
    pub fits: [Option<Fit>; 2],
    /// The row of the table that each point comes from, as for a series.
    pub rows: Vec<Option<usize>>,
}

/// The two ends of a band at one x, all in SI units.
///
/// A point whose upper end is infinite or NaN is open upwards and marked by an arrow. A point
/// without a finite x or a finite lower end is a gap.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BandPoint {
    /// The abscissa.
    pub x: f64,
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

/// The style of a series. Colour, marker and, if markers do not tell lines apart, dashes follow
/// from its place in the legend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// A line through marked points; markers are thinned out when there are many.
    #[default]
    LineAndMarkers,
    /// A line alone, e.g. a closed form to compare with.
    Line,
    /// A line with a marker at its end, e.g. a loading path.
    Path,
    /// Marked points alone.
    Markers,
    /// Bars from zero to the points, with whiskers.
    WhiskerBars,
    /// Points alone that are very many.
    Dots,
    /// The outline of bars that stand side by side, filled.
    Bars,
}
