//! The figures that answer a study's question: the columns that are drawn over each other, the
//! curves and the panels.
//!
//! ```toml
//! [[figure]]                  # or [figure], if there is only one
//! x = "mu"
//! y = ["peak_pressure", "hertz_peak_pressure"]     # or one column
//! series = ["mesh"]           # one curve for each value; if left out, for each combination of
//!                             # the axes left over
//! panels = "punch"            # one panel for each value
//! where = "spin == 0"         # only the points for which this holds, as in query --where
//! log_x = true                # log_y likewise; neither if left out
//! band = ["mu_low", "mu_high"]  # shaded between two columns; y may then be left out
//! front = true                # marks the points that no other one is below and left of
//! names = "mesh"              # written beside points
//! fit = true                  # a straight line through each curve's later points, with its slope
//!
//! [[figure]]
//! name = "loop"               # in the name of its file; its number if left out
//! title = "A closed loop"     # above it; the study's question if left out
//! steps = true                # every increment is a point, joined along the loading path
//! x = "at_shift_x"
//! y = "force_x"
//!
//! [[figure]]
//! kind = "histogram"          # counts the points by the value of x; "scatter": points without
//!                             # lines, which a study with a [sample] has where nothing else is
//!                             # said; "curves"
//! x = "peak_pressure"
//! bins = 20                   # by the rule of Freedman and Diaconis if left out
//! share = true                # parts of the points in place of counts
//!
//! [[figure]]
//! kind = "sensitivity"        # bars of how much each drawn key moves y, in a study of this kind
//! y = ["peak_pressure", "contact_radius"]
//! ```

use std::cmp::Reverse;

use crate::axis::{Group, SweepAxis};

pub(crate) mod table;

/// The form of a figure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FigureKind {
    /// Curves through points in order of x, or along the loading path.
    #[default]
    Curves,
    /// Points that no line joins.
    Scatter,
    /// Points counted by their value along x.
    Histogram,
    /// Bars of how much each drawn key moves the columns along y, without a column along x.
    Sensitivity,
}

impl FigureKind {
    /// Every kind.
    pub const ALL: [FigureKind; 4] =
        [FigureKind::Curves, FigureKind::Scatter, FigureKind::Histogram, FigureKind::Sensitivity];

    /// The names by which a study file calls them.
    const NAMES: [&'static str; 4] =
        [Self::ALL[0].name(), Self::ALL[1].name(), Self::ALL[2].name(), Self::ALL[3].name()];

    /// Returns the name by which a study file calls it.
    pub const fn name(self) -> &'static str {
        match self {
            FigureKind::Curves => "curves",
            FigureKind::Scatter => "scatter",
            FigureKind::Histogram => "histogram",
            FigureKind::Sensitivity => "sensitivity",
        }
    }

    /// Returns the kind of a figure that does not say its own: the points of a sample lie on no
    /// curve.
    pub fn usual(groups: &[Group]) -> FigureKind {
        match groups.iter().any(|group| group.design().is_some()) {
            true => FigureKind::Scatter,
            false => FigureKind::Curves,
        }
    }
}

/// A figure. All names in it but that of the figure are names of columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// The name, unique in the study: the one that the file gives, else the number counted from 1.
    pub name: String,
    /// The title that stands above it in place of the study's question; empty for none.
    pub title: Option<String>,
    /// The form.
    pub kind: FigureKind,
    /// The column along the abscissa, which is numeric.
    pub x: String,
    /// The columns along the ordinate: numeric, of one unit, and at least one unless there is a
    /// band; none in a histogram.
    pub y: Vec<String>,
    /// The number of bins of a histogram, if it is not left to the values.
    pub bins: Option<u32>,
    /// True if a histogram shows parts of the points and no counts.
    pub share: bool,
    /// The columns of whose values each combination gets a curve.
    pub series: Vec<String>,
    /// The column of which each value gets a panel.
    pub panels: Option<String>,
    /// True if every increment is a point, joined along the loading path; else only the end of the
    /// path is one.
    pub steps: bool,
    /// The condition on columns that holds at the points which it shows; `None` shows all.
    pub condition: Option<String>,
    /// True if the abscissa is logarithmic.
    pub log_x: bool,
    /// True if the ordinate is logarithmic.
    pub log_y: bool,
    /// True if straight lines are fitted, with their slopes.
    pub fit: bool,
    /// The lower and the upper column of a band, numeric and of one unit.
    pub band: Option<[String; 2]>,
    /// True if those points are marked that no other point is below and left of.
    pub front: bool,
    /// The column whose values are written beside the points.
    pub names: Option<String>,
}

/// The name of the figure that stands for a study.
const FIRST: &str = "1";

impl Figure {
    /// Makes a figure of columns and nothing else.
    pub fn new(x: String, y: Vec<String>) -> Self {
        let (series, panels) = (Vec::new(), None);
        Figure {
            name: FIRST.to_owned(),
            title: None,
            kind: FigureKind::default(),
            x,
            y,
            bins: None,
            share: false,
            series,
            panels,
            steps: false,
            condition: None,
            log_x: false,
            log_y: false,
            fit: false,
            band: None,
            front: false,
            names: None,
        }
    }

    /// Makes a figure without an ordinate over each numeric axis, the longest axis first. It has a
    /// panel for each value of the first axis of tables or words, and a curve for each combination
    /// of the others'.
    pub(crate) fn over_axes(groups: &[Group]) -> Vec<Self> {
        let mut numeric: Vec<&SweepAxis> =
            telling(groups).filter(|axis| axis.is_numeric()).collect();
        // The sort is stable: of axes of one length the first stays first.
        numeric.sort_by_key(|axis| Reverse(axis.values().len()));
        let over = |x: &SweepAxis| {
            let figure = Figure::new(x.column().into_owned(), Vec::new());
            Figure { log_x: x.is_log(), ..figure }.telling_apart(groups)
        };
        numeric.into_iter().map(over).collect()
    }

    /// Makes a histogram of a column.
    pub(crate) fn histogram(x: String) -> Self {
        Figure { kind: FigureKind::Histogram, ..Figure::new(x, Vec::new()) }
    }

    /// Makes a figure without an ordinate over each number that a sample draws, whose points no
    /// line joins. Panels and series are those of the other axes.
    pub(crate) fn over_drawn(groups: &[Group]) -> Vec<Self> {
        let drawn = groups.iter().filter(|group| group.design().is_some()).flat_map(Group::axes);
        let numeric = drawn.filter(|axis| axis.is_numeric());
        let over = |axis: &SweepAxis| {
            let figure = Figure::new(axis.column().into_owned(), Vec::new());
            let figure = Figure { kind: FigureKind::Scatter, log_x: axis.is_log(), ..figure };
            figure.telling_apart(groups)
        };
        numeric.map(over).collect()
    }

    /// Tells the values of the axes apart that it does not draw: those of the first axis of tables
    /// or words by panels, those of the others by series.
    pub(crate) fn telling_apart(self, groups: &[Group]) -> Self {
        let others = || telling(groups).filter(|axis| axis.column() != self.x);
        let panels =
            others().find(|axis| !axis.is_numeric()).map(|axis| axis.column().into_owned());
        let series = others()
            .map(|axis| axis.column().into_owned())
            .filter(|name| Some(name) != panels.as_ref())
            .collect();
        Figure { series, panels, ..self }
    }

    /// Returns the columns of the quantities that it shows: those along the ordinate, or that of a
    /// histogram.
    pub fn shown(&self) -> impl Iterator<Item = &String> {
        let counted = (self.kind == FigureKind::Histogram).then_some(&self.x);
        self.y.iter().chain(self.band.iter().flatten()).chain(counted)
    }

    /// Returns the condition of the rows that it is made of, where only those count for which
    /// `filter` holds; `None` if all do.
    pub fn filtered(&self, filter: Option<&str>) -> Option<String> {
        match (&self.condition, filter) {
            (Some(condition), Some(filter)) => Some(format!("({condition}) && ({filter})")),
            (condition, filter) => condition.as_deref().or(filter).map(str::to_owned),
        }
    }

    /// Returns the name of its files without an ending: the name of the study, followed by that of
    /// the figure unless that is only the number of the first.
    pub fn stem(&self, study: &str) -> String {
        if self.name == FIRST { study.to_owned() } else { format!("{study}-{}", self.name) }
    }
}

/// Returns the axes that tell the steps of each group apart that varies: those that advance with
/// them say nothing more. The axes of a sample tell nothing: each of its points is another.
pub(crate) fn telling(groups: &[Group]) -> impl Iterator<Item = &SweepAxis> {
    let is_telling = |group: &&Group| group.len() > 1 && group.design().is_none();
    groups.iter().filter(is_telling).flat_map(Group::telling)
}
