//! The columns that a figure of a table shows, and the names of its curves and bands.

use super::error::FigureError;

/// The form in which a figure draws the rows of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FigureForm {
    /// Curves through the points, in order of x.
    #[default]
    Curves,
    /// Points that no line joins.
    Scatter,
    /// Bars that count the rows by their value along x; no column is drawn along y.
    Histogram {
        /// The number of bins; `None` leaves the choice to the values.
        bins: Option<usize>,
        /// True if bars are parts of all rows and not counts.
        share: bool,
    },
}

/// The columns of a table that a figure shows, for
/// [`PlotFigure::from_table`](crate::PlotFigure::from_table).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FigureSpec<'a> {
    /// The form in which the rows are drawn.
    pub form: FigureForm,
    /// The column along the horizontal axis. A column of text makes an axis of categories.
    pub x: &'a str,
    /// The columns of numbers along the vertical axis, all in one unit; each is a curve. The points
    /// of the first are marked, the others are lines alone, so that curves that agree do not hide
    /// each other.
    pub y: &'a [&'a str],
    /// The label of the vertical axis if `y` has several columns. If it is empty, the axis lists
    /// them.
    pub y_label: &'a str,
    /// The columns whose values tell the series apart; none for a single series.
    pub series: &'a [&'a str],
    /// The column that has a panel for each of its values.
    pub panels: Option<&'a str>,
    /// The column that counts along a path. The points are then joined in the order of the rows and
    /// not by x, and a new path begins wherever the count does not grow.
    pub along: Option<&'a str>,
    /// The labels of columns in the picture, as pairs of name and label. A column that is not
    /// listed is called by the words of its name.
    pub labels: &'a [(&'a str, &'a str)],
    /// The title above the figure.
    pub title: &'a str,
    /// Sentences that stand below the figure.
    pub notes: &'a [&'a str],
    /// True if the horizontal axis is logarithmic.
    pub log_x: bool,
    /// True if the vertical axis is logarithmic.
    pub log_y: bool,
    /// Two columns of numbers in the unit of `y`, a lower and an upper end; every series gets a
    /// band between them. The band is open upwards at a row that has a lower end and no upper one,
    /// or an infinite one. With a band, `y` may be empty.
    pub band: Option<(&'a str, &'a str)>,
    /// True if a straight line is fitted to each curve and to each end of a band, by the rule of
    /// [`straight`](crate::fit::straight): a power law on logarithmic axes. The fitted data are
    /// drawn as points that are not joined.
    pub fit: bool,
    /// True if the Pareto front of each panel is marked: the points of all its curves that no other
    /// one beats within the noise of x.
    pub front: bool,
    /// The value along y at which a level is drawn, with a mark wherever a curve crosses it.
    pub level: Option<f64>,
    /// The column of the noise of x on either side, relative to x: on a front, points whose x lie
    /// within it are ties, of which none beats the other.
    pub noise: Option<&'a str>,
    /// The column whose value is written beside each point of the front, or beside each point if
    /// there is no front, as far as there is room.
    pub names: Option<&'a str>,
}

impl FigureSpec<'_> {
    /// Returns the label of a column.
    pub(super) fn label(&self, name: &str) -> String {
        let listed = self.labels.iter().find(|(column, _)| *column == name);
        listed.map_or_else(|| name.replace('_', " "), |(_, label)| (*label).to_owned())
    }

    /// Returns the label of the vertical axis.
    pub(super) fn axis_of_y(&self) -> String {
        let all: Vec<&str> = self.y.iter().copied().chain(self.ends()).collect();
        match &all[..] {
            [_, _, ..] if !self.y_label.is_empty() => self.y_label.to_owned(),
            all => all.iter().map(|name| self.label(name)).collect::<Vec<_>>().join(", "),
        }
    }

    /// Iterates over the two columns of the band, if there is one.
    pub(super) fn ends(&self) -> impl Iterator<Item = &str> {
        self.band.into_iter().flat_map(|(low, high)| [low, high])
    }

    /// Returns the label of a curve: the values that tell it apart, followed by its column if there
    /// are several columns or a band.
    pub(super) fn curve(&self, values: &str, y: &str) -> String {
        match (self.y.len() + usize::from(self.band.is_some()), values) {
            (0 | 1, values) => values.to_owned(),
            (_, "") => self.label(y),
            (_, values) => format!("{values}, {}", self.label(y)),
        }
    }

    /// Returns the label of a band: the values that tell it apart, and its columns if there are no
    /// such values or if there are curves too.
    pub(super) fn band(&self, values: &str, (low, high): (&str, &str)) -> String {
        let (low, high) = (self.label(low), self.label(high));
        // For "lower end" and "upper end" it is enough to say "lower to upper end".
        let shared =
            low.split(' ').rev().zip(high.split(' ').rev()).take_while(|(a, b)| a == b).count();
        let words: Vec<&str> = low.split(' ').collect();
        let distinct = &words[..words.len().saturating_sub(shared).max(1)];
        let ends = format!("{} to {high}", distinct.join(" "));
        match (self.y.len(), values) {
            (_, "") => ends,
            (0, values) => values.to_owned(),
            (_, values) => format!("{values}, {ends}"),
        }
    }

    /// Refuses marks that need points in order of x, along a path or along text, and marks of
    /// points, a front and names, for a figure of a band alone. `text_on_x` is an example of the
    /// text along x, if there is any.
    pub(super) fn check_marks(&self, text_on_x: Option<&str>) -> Result<(), FigureError> {
        const LINE: &str = "a fitted line";
        const FRONT: &str = "a front";
        let marks = [
            (self.fit, LINE),
            (self.front, FRONT),
            (self.band.is_some(), "a band"),
            (self.names.is_some(), "names"),
        ];
        let first = marks.iter().find(|(wanted, _)| *wanted).map(|(_, mark)| *mark);
        let refuse = |what, why| Err(FigureError::NotAlong { what, x: self.x.to_owned(), why });
        match (self.along, first, text_on_x) {
            (Some(along), Some(mark), _) => {
                refuse(mark, format!("whose points are joined in the order of `{along}`"))
            }
            (None, Some(_), Some(example)) if self.fit || self.front => refuse(
                if self.fit { LINE } else { FRONT },
                format!("which has text, such as {example:?}"),
            ),
            _ if self.y.is_empty() && (self.front || self.names.is_some()) => Err(FigureError::NoY),
            _ => Ok(()),
        }
    }
}
