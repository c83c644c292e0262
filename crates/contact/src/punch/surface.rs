//! Height maps: a surface sampled on a rectangle of equal pixels.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use super::interpolant::Interpolant;
use super::placement::PlacedWheels;
use super::profile::Profile;

/// A sampled surface. A pixel's value is the surface's height at the centre of that pixel, positive
/// towards the foundation; between the centres the surface is smooth, see `interpolant.rs`.
#[derive(Clone, Debug)]
pub struct Surface {
    columns: usize,
    rows: usize,
    heights: Vec<f64>,
    /// The pixels that are no part of the sole; empty if all of them are part of it.
    absent: Vec<bool>,
    highest: f64,
    /// The surface between the pixels, which is laid when it is needed first.
    interpolant: OnceLock<Interpolant>,
}

impl PartialEq for Surface {
    fn eq(&self, other: &Self) -> bool {
        (self.columns, self.rows, &self.heights, &self.absent)
            == (other.columns, other.rows, &other.heights, &other.absent)
    }
}

/// The reason why heights are no surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// The number of heights does not fill the rectangle.
    #[error(
        "{count} heights do not fill {columns} columns × {rows} rows; it must be a full rectangle of at least 1 × 1"
    )]
    Shape {
        /// The number of columns asked for.
        columns: usize,
        /// The number of rows asked for.
        rows: usize,
        /// The number of heights given.
        count: usize,
    },
    /// A height is NaN or infinite.
    #[error("height {value} in row {row}, column {column} (counted from 0) is not a finite number")]
    NotFinite {
        /// The row, counted from 0.
        row: usize,
        /// The column, counted from 0.
        column: usize,
        /// The height \[m\].
        value: f64,
    },
    /// The sole has no pixel.
    #[error("every pixel is excluded; at least one must be part of the sole")]
    Empty,
}

/// Height maps and profiles, by the names under which scenes mention them.
#[derive(Clone, Debug, Default)]
pub struct Surfaces {
    maps: BTreeMap<String, Arc<Surface>>,
    profiles: BTreeMap<String, Arc<Profile>>,
    placed: Arc<PlacedWheels>,
}

impl Surfaces {
    /// Creates an empty collection.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns true if there is neither a height map nor a profile.
    pub fn is_empty(&self) -> bool {
        self.maps.is_empty() && self.profiles.is_empty()
    }

    /// Adds a height map, or replaces the one of this name.
    pub fn insert(&mut self, name: String, map: Arc<Surface>) {
        self.maps.insert(name, map);
    }

    /// Returns the height map of this name.
    pub fn get(&self, name: &str) -> Option<&Arc<Surface>> {
        self.maps.get(name)
    }

    /// Adds a profile, or replaces the one of this name.
    pub fn insert_profile(&mut self, name: String, profile: Arc<Profile>) {
        self.profiles.insert(name, profile);
    }

    /// Returns the profile of this name.
    pub fn profile(&self, name: &str) -> Option<&Arc<Profile>> {
        self.profiles.get(name)
    }

    /// Returns the wheels that were last placed with these profiles.
    pub(super) fn placed(&self) -> &PlacedWheels {
        &self.placed
    }
}

impl Surface {
    /// Creates a surface of `columns` pixels along x by `rows` along y. The `heights` \[m\] come
    /// row by row, x fastest, the first row at the lowest y.
    ///
    /// # Errors
    /// A [`SurfaceError`] reports heights that do not fill the rectangle, or the first one that is
    /// not finite.
    pub fn new(columns: usize, rows: usize, heights: Vec<f64>) -> Result<Self, SurfaceError> {
        if columns == 0 || rows == 0 || columns.checked_mul(rows) != Some(heights.len()) {
            return Err(SurfaceError::Shape { columns, rows, count: heights.len() });
        }
        if let Some(index) = heights.iter().position(|height| !height.is_finite()) {
            return Err(SurfaceError::NotFinite {
                row: index / columns,
                column: index % columns,
                value: heights[index],
            });
        }
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (absent, interpolant) = (Vec::new(), OnceLock::new());
        Ok(Self { columns, rows, heights, absent, highest, interpolant })
    }

    /// Takes pixels out of the sole: there the punch cannot touch. Their heights still shape the
    /// surface beside them.
    ///
    /// # Errors
    /// A [`SurfaceError`] reports that `absent` has not a value for each pixel, or that no pixel is
    /// left.
    pub fn excluding(mut self, absent: Vec<bool>) -> Result<Self, SurfaceError> {
        if absent.len() != self.heights.len() {
            let Self { columns, rows, .. } = self;
            return Err(SurfaceError::Shape { columns, rows, count: absent.len() });
        }
        let present = self.heights.iter().zip(&absent).filter(|(_, absent)| !**absent);
        self.highest =
            present.map(|(height, _)| *height).reduce(f64::max).ok_or(SurfaceError::Empty)?;
        self.absent = if absent.contains(&true) { absent } else { Vec::new() };
        self.interpolant = OnceLock::new();
        Ok(self)
    }

    /// Returns the number of pixels along x.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Returns the number of pixels along y.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the heights \[m\], row by row, x fastest.
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }

    /// Returns whether each pixel is no part of the sole; empty if all of them are part of it.
    pub fn absent(&self) -> &[bool] {
        &self.absent
    }

    /// Returns whether the sole has the pixel that holds the fractions (s, t) of the map's widths.
    /// On the edge between two pixels one of the two is enough.
    pub(crate) fn has_sole(&self, s: f64, t: f64) -> bool {
        if self.absent.is_empty() {
            return true;
        }
        let pixels = |fraction: f64, count: usize| {
            let place = fraction * count as f64;
            [place - 1e-9, place + 1e-9].map(|place| (place.max(0.0) as usize).min(count - 1))
        };
        let (columns, rows) = (pixels(s, self.columns), pixels(t, self.rows));
        rows.iter().any(|j| columns.iter().any(|i| !self.absent[j * self.columns + i]))
    }

    /// Returns the gap below the highest point of the surface \[m\] at the fractions (s, t) of the
    /// map's widths.
    pub(crate) fn gap_at(&self, s: f64, t: f64) -> f64 {
        let interpolant = self.interpolant();
        interpolant.at(self.along_x(s), self.along_y(t)) - interpolant.least()
    }

    /// Returns the mean gap below the highest point of the surface \[m\] over a rectangle in
    /// fractions of the map's widths.
    pub(crate) fn mean_gap(&self, s: [f64; 2], t: [f64; 2]) -> f64 {
        let interpolant = self.interpolant();
        let mean = interpolant.mean(s.map(|s| self.along_x(s)), t.map(|t| self.along_y(t)));
        mean - interpolant.least()
    }

    fn along_x(&self, fraction: f64) -> f64 {
        fraction * self.columns as f64 - 0.5
    }

    fn along_y(&self, fraction: f64) -> f64 {
        fraction * self.rows as f64 - 0.5
    }

    fn interpolant(&self) -> &Interpolant {
        self.interpolant.get_or_init(|| {
            let gaps: Vec<f64> = self.heights.iter().map(|height| self.highest - height).collect();
            Interpolant::new(self.columns, &gaps, |pixel| {
                self.absent.get(pixel).is_none_or(|absent| !absent)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn refuses_what_is_no_surface() {
        assert!(matches!(
            Surface::new(2, 2, vec![0.0; 3]),
            Err(SurfaceError::Shape { count: 3, .. })
        ));
        assert!(matches!(Surface::new(0, 2, vec![]), Err(SurfaceError::Shape { .. })));
        assert!(matches!(
            Surface::new(2, 2, vec![0.0, 0.0, f64::NAN, 0.0]),
            Err(SurfaceError::NotFinite { row: 1, column: 0, .. })
        ));
    }

    #[test]
    fn excluded_pixels_are_no_part_of_the_sole() {
        let surface = Surface::new(2, 1, vec![3.0, 1.0]).unwrap();
        assert_eq!(
            surface.clone().excluding(vec![true]),
            Err(SurfaceError::Shape { columns: 2, rows: 1, count: 1 })
        );
        assert_eq!(surface.clone().excluding(vec![true; 2]), Err(SurfaceError::Empty));
        assert_eq!(surface.clone().excluding(vec![false; 2]).as_ref(), Ok(&surface));
        let half = surface.clone().excluding(vec![true, false]).unwrap();
        assert_ne!(half, surface);
        assert_eq!([0.1, 0.5, 0.9].map(|s| half.has_sole(s, 0.5)), [false, true, true]);
        assert_eq!([0.1, 0.5, 0.9].map(|s| surface.has_sole(s, 0.5)), [true; 3]);
    }

    /// Returns a map of `columns` × `rows` pixels of heights that a seed scatters over 0 … 1012.
    fn scattered(columns: usize, rows: usize, seed: u64) -> Surface {
        let height = |s: usize| ((s as u64 * 2654435761 + seed) % 1013) as f64;
        Surface::new(columns, rows, (0..columns * rows).map(height).collect()).unwrap()
    }

    proptest! {
        #[test]
        fn the_centres_of_pixels_have_their_heights(columns in 1usize..20, rows in 1usize..20, seed in 0u64..1000) {
            let surface = scattered(columns, rows, seed);
            let gap = |i: usize, j: usize| surface.gap_at((i as f64 + 0.5) / columns as f64, (j as f64 + 0.5) / rows as f64);
            for j in 0..rows {
                for i in 0..columns {
                    let expected = surface.heights[0] - surface.heights[j * columns + i];
                    prop_assert!((gap(i, j) - gap(0, 0) - expected).abs() < 1e-9 * 1013.0);
                }
            }
        }

        /// The highest point is where the gap vanishes, and nowhere is it below.
        #[test]
        fn the_gap_is_counted_from_the_highest_point(columns in 1usize..8, rows in 1usize..8, seed in 0u64..1000) {
            let surface = scattered(columns, rows, seed);
            let samples = 16 * columns.max(rows);
            let mut least = f64::INFINITY;
            for k in 0..(samples + 1) * (samples + 1) {
                let place = |k: usize| k as f64 / samples as f64;
                least = least.min(surface.gap_at(place(k % (samples + 1)), place(k / (samples + 1))));
            }
            prop_assert!((-1e-9 * 1013.0..0.02 * 1013.0).contains(&least), "{least}");
        }

        /// The mean over an element is that of the surface at its points, so that both projections
        /// have one limit.
        #[test]
        fn means_are_those_of_the_same_surface(
            columns in 1usize..6, rows in 1usize..6, seed in 0u64..1000,
            s in -0.1..1.0f64, width in 0.01..0.8f64, t in -0.1..1.0f64, height in 0.01..0.8f64,
        ) {
            let surface = scattered(columns, rows, seed);
            let n = 200;
            let place = |k: usize, low: f64, width: f64| low + (k as f64 + 0.5) / n as f64 * width;
            let sum: f64 = (0..n * n).map(|k| surface.gap_at(place(k % n, s, width), place(k / n, t, height))).sum();
            let mean = surface.mean_gap([s, s + width], [t, t + height]);
            prop_assert!((sum / (n * n) as f64 - mean).abs() < 1e-3 * 1013.0, "{mean} {}", sum / (n * n) as f64);
        }

        #[test]
        fn the_mean_is_conservative(columns in 1usize..12, rows in 1usize..12, nx in 1usize..15, ny in 1usize..15) {
            let surface = scattered(columns, rows, 7);
            let whole = surface.mean_gap([0.0, 1.0], [0.0, 1.0]);
            let edge = |i: usize, n: usize| [i as f64 / n as f64, (i + 1) as f64 / n as f64];
            let mean = |k: usize| surface.mean_gap(edge(k % nx, nx), edge(k / nx, ny));
            let mean = (0..nx * ny).map(mean).sum::<f64>() / (nx * ny) as f64;
            prop_assert!((mean - whole).abs() < 1e-9 * 1013.0);
        }
    }
}
