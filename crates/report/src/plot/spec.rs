//! What a figure of a table shows, and what its parts are called.

use super::error::FigureError;

/// Which columns of a table a figure shows, for [`PlotFigure::from_table`](crate::PlotFigure::from_table).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FigureSpec<'a> {
    /// The column along the horizontal axis; a column of text makes an axis of categories.
    pub x: &'a str,
    /// The columns of numbers along the vertical axis, all in one unit; a curve for each of them.
    /// The points of the first are marked, the others are lines alone, so that curves which agree
    /// do not hide each other.
    pub y: &'a [&'a str],
    /// What several columns of `y` measure, for their axis; with nothing here it lists them.
    pub y_label: &'a str,
    /// Columns whose values tell the series apart; none for a single series.
    pub series: &'a [&'a str],
    /// The column with a panel for each of its values.
    pub panels: Option<&'a str>,
    /// The column that counts along a path: points are then joined in the order of the rows and not
    /// by x, and where it does not grow another path begins.
    pub along: Option<&'a str>,
    /// What columns are called in the picture, by their names; one that is not here is called by
    /// the words of its name.
    pub labels: &'a [(&'a str, &'a str)],
    /// Above the figure.
    pub title: &'a str,
    /// Whether x is logarithmic.
    pub log_x: bool,
    /// Whether y is logarithmic.
    pub log_y: bool,
    /// Two columns of numbers in the unit of `y`, a lower and an upper end: a band between them for
    /// every series. Where there is a lower end and no upper one, or an infinite one, the band is
    /// open upwards. With a band, `y` may be empty.
    pub band: Option<(&'a str, &'a str)>,
    /// Whether a straight line is fitted to each curve and each end of a band, by the rule of
    /// [`straight`](crate::fit::straight): a power law on logarithmic axes. What it is fitted to is drawn as points that
    /// are not joined.
    pub fit: bool,
    /// Whether the points of all curves of a panel are marked for which no other has both a smaller
    /// x and a smaller y.
    pub front: bool,
    /// The column whose value is written beside each point of the front, without a front beside
    /// each point, where there is room.
    pub names: Option<&'a str>,
}

impl FigureSpec<'_> {
    /// What a column is called.
    pub(super) fn label(&self, name: &str) -> String {
        let own = self.labels.iter().find(|(column, _)| *column == name);
        own.map_or_else(|| name.replace('_', " "), |(_, label)| (*label).to_owned())
    }

    /// What the vertical axis is called.
    pub(super) fn axis_of_y(&self) -> String {
        let all: Vec<&str> = self.y.iter().copied().chain(self.ends()).collect();
        match &all[..] {
            [_, _, ..] if !self.y_label.is_empty() => self.y_label.to_owned(),
            all => all.iter().map(|name| self.label(name)).collect::<Vec<_>>().join(", "),
        }
    }

    /// The columns of the band.
    pub(super) fn ends(&self) -> impl Iterator<Item = &str> {
        self.band.into_iter().flat_map(|(low, high)| [low, high])
    }

    /// What a band is called: the values that tell it apart, its columns if there is nothing else
    /// or if there are curves too.
    pub(super) fn band(&self, values: &str, (low, high): (&str, &str)) -> String {
        let (low, high) = (self.label(low), self.label(high));
        // of "lower end" and "upper end" it is enough to say "lower to upper end"
        let same =
            low.split(' ').rev().zip(high.split(' ').rev()).take_while(|(a, b)| a == b).count();
        let own: Vec<&str> = low.split(' ').collect();
        let ends = format!("{} to {high}", own[..own.len().saturating_sub(same).max(1)].join(" "));
        match (self.y.len(), values) {
            (_, "") => ends,
            (0, values) => values.to_owned(),
            (_, values) => format!("{values}, {ends}"),
        }
    }

    /// What only points with numbers along x can have.
    pub(super) fn check_marks(&self, text_on_x: Option<&str>) -> Result<(), FigureError> {
        let ordered = [
            (self.fit, "a fitted line"),
            (self.front, "a front"),
            (self.band.is_some(), "a band"),
            (self.names.is_some(), "names"),
        ];
        let refuse = |what, why| Err(FigureError::NotAlong { what, x: self.x.to_owned(), why });
        match (self.along, ordered.iter().find(|(asked, _)| *asked), text_on_x) {
            (Some(along), Some((_, what)), _) => {
                refuse(what, format!("whose points are joined in the order of `{along}`"))
            }
            (None, Some(_), Some(example)) if self.fit || self.front => refuse(
                if self.fit { ordered[0].1 } else { ordered[1].1 },
                format!("which has text, such as {example:?}"),
            ),
            // a front and names are of points, which a band has not
            _ if self.y.is_empty() && (self.front || self.names.is_some()) => Err(FigureError::NoY),
            _ => Ok(()),
        }
    }

    /// What a curve is called: the values that tell it apart, then its column if there are several
    /// or a band.
    pub(super) fn curve(&self, values: &str, y: &str) -> String {
        match (self.y.len() + usize::from(self.band.is_some()), values) {
            (0 | 1, values) => values.to_owned(),
            (_, "") => self.label(y),
            (_, values) => format!("{values}, {}", self.label(y)),
        }
    }
}
