//! Lists of x, y and z, one point on a line, whose points lie on a grid.

use super::heights::{HeightMatrix, MAX_HEIGHTS};

/// The part of a step by which a coordinate may miss the grid: what rounding to few digits does.
const OFF_GRID: f64 = 0.05;

/// The kind of list that columns of numbers are.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum PointList {
    /// They are no list of points, as far as their numbers tell.
    None,
    /// They look like a list of points, which is none of a map for this reason.
    Unusable(String),
    /// The points lie on a grid.
    Grid(PointGrid),
}

/// A map made of a list of points.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PointGrid {
    /// The heights \[m\]; NaN where there is no point.
    pub(super) matrix: HeightMatrix,
    /// The extents along x and y, half a step beyond the outermost points on either side \[m\].
    pub(super) widths: [f64; 2],
    /// The middle of the points \[m\].
    pub(super) centre: [f64; 2],
    /// The number of places of the grid without a point.
    pub(super) vacant: usize,
}

/// The places of a grid along one axis.
struct GridAxis {
    lowest: f64,
    step: f64,
    count: usize,
    /// Every coordinate lies on one of the places.
    is_even: bool,
    /// The number of different coordinates.
    different: usize,
}

impl PointList {
    /// Tells whether rows begin with the x, y and z of points, in any order. `is_titled` says that
    /// the file calls them so.
    pub(super) fn of(numbers: &HeightMatrix, is_titled: bool) -> Self {
        let HeightMatrix { rows, columns, heights: numbers } = numbers;
        let unusable = |is_list: bool, reason: &str| match is_list {
            true => Self::Unusable(format!("it looks like a list of x, y and z, but {reason}")),
            false => Self::None,
        };
        if *columns < 3 {
            return unusable(is_titled, "its rows have fewer than three numbers");
        }
        let coordinates = |axis: usize| numbers.iter().skip(axis).step_by(*columns).copied();
        let (Some(x), Some(y)) = (GridAxis::of(coordinates(0)), GridAxis::of(coordinates(1)))
        else {
            return unusable(is_titled, "a coordinate is missing, or there are too few points");
        };
        // The points of a grid have few different coordinates, and hardly more pairs of them than
        // points.
        let pairs = x.different * y.different;
        let is_list = is_titled || *rows >= 9 && 10 * pairs >= 9 * rows && pairs <= 2 * rows;
        if x.count < 2 || y.count < 2 {
            let is_line = *columns == 3
                && (x.count < 2) != (y.count < 2)
                && x.different.max(y.different) == *rows
                && x.is_even
                && y.is_even;
            return unusable(is_titled || is_line, "all points lie on one line");
        }
        if !x.is_even || !y.is_even {
            let reason = "the points are not evenly spaced; sample them on a grid";
            return unusable(is_list, reason);
        }
        let vacant_reason = "the points leave most of their grid vacant";
        let places = x.count.checked_mul(y.count);
        let Some(places) = places.filter(|places| *places <= MAX_HEIGHTS.min(4 * rows)) else {
            return unusable(is_titled, vacant_reason);
        };
        let mut heights = vec![f64::NAN; places];
        let mut is_taken = vec![false; places];
        for (index, point) in numbers.chunks_exact(*columns).enumerate() {
            let place = y.place(point[1]) * x.count + x.place(point[0]);
            if is_taken[place] {
                let reason = format!("point {} lies where another one lies", index + 1);
                return unusable(is_titled || is_list && 2 * rows > places, &reason);
            }
            (is_taken[place], heights[place]) = (true, point[2]);
        }
        let vacant = places - rows;
        let most_vacant = match (is_titled, *columns) {
            (true, _) => places / 2,
            (false, 3) => places / 4,
            (false, _) => 0,
        };
        if vacant > most_vacant {
            return unusable(is_titled, vacant_reason);
        }
        Self::Grid(PointGrid {
            matrix: HeightMatrix { rows: y.count, columns: x.count, heights },
            widths: [x.width(), y.width()],
            centre: [x.centre(), y.centre()],
            vacant,
        })
    }
}

impl GridAxis {
    /// Finds the places of coordinates; `None` if one is missing.
    fn of(coordinates: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = coordinates.collect();
        if sorted.len() < 4 || sorted.iter().any(|x| !x.is_finite()) {
            return None;
        }
        sorted.sort_unstable_by(f64::total_cmp);
        let (lowest, highest) = (*sorted.first()?, *sorted.last()?);
        let span = highest - lowest;
        let steps =
            sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 1e-7 * span);
        let (mut smallest, mut different) = (f64::INFINITY, 1);
        for step in steps {
            smallest = smallest.min(step);
            different += 1;
        }
        if span == 0.0 || !span.is_finite() {
            return Some(Self { lowest, step: 0.0, count: 1, is_even: true, different: 1 });
        }
        let of_count = |count: usize| {
            let step = span / (count - 1) as f64;
            let off = |x: &f64| {
                let place = (x - lowest) / step;
                (place - place.round()).abs()
            };
            let is_even = sorted.iter().all(|x| off(x) <= OFF_GRID);
            Self { lowest, step, count, is_even, different }
        };
        // Whole rows of points may be missing; then there are more places than coordinates.
        let full = of_count(different);
        let sparse = ((span / smallest).round() + 1.0).min(MAX_HEIGHTS as f64) as usize;
        Some(if full.is_even || sparse <= different { full } else { of_count(sparse) })
    }

    fn place(&self, coordinate: f64) -> usize {
        (((coordinate - self.lowest) / self.step).round() as usize).min(self.count - 1)
    }

    fn width(&self) -> f64 {
        tidy(self.step * self.count as f64)
    }

    fn centre(&self) -> f64 {
        tidy(self.lowest + 0.5 * self.step * (self.count - 1) as f64)
    }
}

/// Returns a number to twelve digits, without the rounding of the steps that led to it.
fn tidy(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}
