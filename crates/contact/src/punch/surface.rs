//! Height maps: a surface sampled on a rectangle of equal pixels.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::placement::PlacedWheels;
use super::profile::Profile;

/// A sampled surface. A pixel's value is the surface's mean height over that pixel, positive
/// towards the foundation.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    columns: usize,
    rows: usize,
    heights: Vec<f64>,
    highest: f64,
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
        Ok(Self { columns, rows, heights, highest })
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

    /// Returns the gap below the highest pixel \[m\] at the fractions (s, t) of the map's widths.
    /// It is bilinear between the centres of pixels and constant beyond the outermost ones.
    pub(crate) fn gap_at(&self, s: f64, t: f64) -> f64 {
        let locate = |fraction: f64, count: usize| {
            let place = (fraction * count as f64 - 0.5).clamp(0.0, (count - 1) as f64);
            let low = (place.floor() as usize).min(count - 1);
            (low, (low + 1).min(count - 1), place - low as f64)
        };
        let (i0, i1, a) = locate(s, self.columns);
        let (j0, j1, b) = locate(t, self.rows);
        let gap = |i: usize, j: usize| self.highest - self.heights[j * self.columns + i];
        let along_x =
            |j: usize| if a == 0.0 { gap(i0, j) } else { gap(i0, j) * (1.0 - a) + gap(i1, j) * a };
        if b == 0.0 { along_x(j0) } else { along_x(j0) * (1.0 - b) + along_x(j1) * b }
    }

    /// Returns the mean gap below the highest pixel \[m\] over a rectangle in fractions of the
    /// map's widths, each pixel weighted with its share. An element that coincides with a pixel
    /// gets the value of that pixel.
    pub(crate) fn mean_gap(&self, s: [f64; 2], t: [f64; 2]) -> f64 {
        let (columns, rows) = (shares(s, self.columns), shares(t, self.rows));
        let mut sum = 0.0;
        for &(j, share_y) in &rows {
            for &(i, share_x) in &columns {
                sum += share_y * share_x * (self.highest - self.heights[j * self.columns + i]);
            }
        }
        sum
    }
}

/// Returns the pixels of a row that an interval covers, with their shares of it, which sum to 1.
/// Overlaps of less than 1e-9 of a pixel are rounding and left out. Beyond the map its outermost
/// pixel goes on.
fn shares(interval: [f64; 2], count: usize) -> Vec<(usize, f64)> {
    let [low, high] = interval.map(|fraction| fraction * count as f64);
    let last = count as f64 - 1.0;
    let first_pixel = low.floor().clamp(0.0, last);
    let last_pixel = (high.ceil() - 1.0).clamp(first_pixel, last);
    let mut covered = Vec::new();
    for pixel in first_pixel as usize..=last_pixel as usize {
        let from = if pixel as f64 == first_pixel { low } else { pixel as f64 };
        let to = if pixel as f64 == last_pixel { high } else { pixel as f64 + 1.0 };
        if to - from > 1e-9 {
            covered.push((pixel, to - from));
        }
    }
    if covered.is_empty() {
        return vec![(first_pixel as usize, 1.0)];
    }
    let total: f64 = covered.iter().map(|(_, share)| share).sum();
    covered.iter_mut().for_each(|(_, share)| *share /= total);
    covered
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

    proptest! {
        #[test]
        fn coincident_elements_get_the_pixels(columns in 1usize..40, rows in 1usize..40, seed in 0u64..1000) {
            let heights: Vec<f64> = (0..columns * rows).map(|s| ((s as u64 * 2654435761 + seed) % 1013) as f64).collect();
            let surface = Surface::new(columns, rows, heights.clone()).unwrap();
            for j in 0..rows {
                for i in 0..columns {
                    let expected = surface.highest - heights[j * columns + i];
                    let s = [i as f64 / columns as f64, (i + 1) as f64 / columns as f64];
                    let t = [j as f64 / rows as f64, (j + 1) as f64 / rows as f64];
                    prop_assert!((surface.mean_gap(s, t) - expected).abs() < 1e-6 * 1013.0);
                    prop_assert!((surface.gap_at(0.5 * (s[0] + s[1]), 0.5 * (t[0] + t[1])) - expected).abs() < 1e-9 * 1013.0);
                }
            }
        }

        #[test]
        fn the_mean_is_conservative(columns in 1usize..12, rows in 1usize..12, nx in 1usize..15, ny in 1usize..15) {
            let heights: Vec<f64> = (0..columns * rows).map(|s| ((s * 7919) % 101) as f64).collect();
            let surface = Surface::new(columns, rows, heights.clone()).unwrap();
            let whole = surface.highest - heights.iter().sum::<f64>() / heights.len() as f64;
            let mut mean = 0.0;
            for j in 0..ny {
                for i in 0..nx {
                    let edge = |i: usize, n: usize| [i as f64 / n as f64, (i + 1) as f64 / n as f64];
                    mean += surface.mean_gap(edge(i, nx), edge(j, ny)) / (nx * ny) as f64;
                }
            }
            prop_assert!((mean - whole).abs() < 1e-6 * 101.0);
        }
    }
}
