//! The smooth surface through the pixels of a height map.
//!
//! It is Akima's: a bicubic polynomial between each four centres of pixels, with continuous slopes,
//! through the pixels' values (H. Akima, J. ACM 17 (1970) 589, doi:10.1145/321607.321609, for a
//! row; Comm. ACM 17 (1974) 18, doi:10.1145/360767.360779, for a surface). Each slope depends on
//! the two pixels on either side only, and leans to the side where the surface is straighter. The
//! surface is exact for a paraboloid in any position, it does not bulge beside a step, and its
//! curvature is bounded, so that pressures converge as the mesh is refined. A bilinear surface has
//! an edge at every row of pixels, under each of which the pressure grows without bound; a spline
//! whose mean over each pixel is the pixel's value bulges by a sixth of a step on either side of
//! it.

use crate::common::parallel;

/// The weight that a straight piece which is not level has in comparison with a bent one. It
/// decides between two straight pieces, of which the level one wins: the rim of a plateau stays
/// level. It is too small to be felt elsewhere.
const SLANT: f64 = 1e-9;

/// A surface through the pixels, of which one more is thought beyond each edge.
#[derive(Clone, Debug)]
pub(super) struct Interpolant {
    /// The number of nodes along x and y: the centres of the pixels, and one beyond either end.
    nodes: [usize; 2],
    /// The gap below the highest pixel and its derivatives at each node, x fastest.
    states: Vec<NodeState>,
    /// The smallest gap of the surface below the highest pixel \[m\], at most 0.
    least: f64,
}

/// The gap at a node and its derivatives by the coordinates in pixels \[m\].
#[derive(Clone, Copy, Debug, Default)]
struct NodeState {
    gap: f64,
    along_x: f64,
    along_y: f64,
    twist: f64,
}

impl Interpolant {
    /// Lays the surface through pixels that lie `gaps` \[m\] below the highest one, `columns` in a
    /// row. The smallest gap is looked for where `counts` holds for one of the pixels around.
    pub(super) fn new(columns: usize, gaps: &[f64], counts: impl Fn(usize) -> bool + Sync) -> Self {
        let rows = gaps.len() / columns;
        let nodes = [columns + 2, rows + 2];
        let padded = padded(columns, rows, gaps);
        let mut states = vec![NodeState::default(); padded.len()];
        parallel::rows(&mut states, nodes[0], |j, row| {
            row.iter_mut().enumerate().for_each(|(i, state)| {
                *state = node_state(&padded, nodes, i, j);
            });
        });
        let mut interpolant = Self { nodes, states, least: 0.0 };
        interpolant.least = interpolant.smallest(|i, j| {
            let pixel = |k: usize, count: usize| k.saturating_sub(1).min(count - 1);
            [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)]
                .iter()
                .any(|(i, j)| counts(pixel(*j, rows) * columns + pixel(*i, columns)))
        });
        interpolant
    }

    /// Returns the smallest gap of the surface below the highest pixel \[m\], at most 0.
    pub(super) fn least(&self) -> f64 {
        self.least
    }

    /// Returns the gap \[m\] at a place in pixels, the first centre at 0.
    pub(super) fn at(&self, x: f64, y: f64) -> f64 {
        self.sum(&NodeWeights::at(x, self.nodes[0]), &NodeWeights::at(y, self.nodes[1]))
    }

    /// Returns the mean gap \[m\] over a rectangle in pixels, the first centre at 0.
    pub(super) fn mean(&self, x: [f64; 2], y: [f64; 2]) -> f64 {
        self.sum(&NodeWeights::over(x, self.nodes[0]), &NodeWeights::over(y, self.nodes[1]))
    }

    fn sum(&self, x: &NodeWeights, y: &NodeWeights) -> f64 {
        let mut sum = 0.0;
        for (j, [value_y, slope_y]) in y.weights.iter().enumerate() {
            let start = (y.first + j) * self.nodes[0] + x.first;
            for ([value_x, slope_x], state) in x.weights.iter().zip(&self.states[start..]) {
                sum += value_y * (value_x * state.gap + slope_x * state.along_x)
                    + slope_y * (value_x * state.along_y + slope_x * state.twist);
            }
        }
        sum
    }

    /// Finds the smallest gap \[m\] over the cells that count. The control points of a patch lie
    /// below it at most by the square of its size, and those of its quarters are nearer.
    fn smallest(&self, counts: impl Fn(usize, usize) -> bool + Sync) -> f64 {
        /// The number of times that a patch is quartered: then it is known to 10⁻⁹ of its bend.
        const DEPTH: usize = 15;
        /// The number of patches that are quartered at once, beyond which the others are left.
        const MOST: usize = 1 << 16;
        let width = self.nodes[0] - 1;
        let below = |level: f64| {
            move |patch: &CubicPatch| patch.lowest() < level && patch.lowest().is_finite()
        };
        let found = parallel::bands(width * (self.nodes[1] - 1), |cells| {
            let low = cells.filter(|cell| counts(cell % width, cell / width)).filter_map(|cell| {
                let lowest = self.patch_on_map(cell % width, cell / width).lowest();
                (lowest < 0.0 && lowest.is_finite()).then_some((lowest, cell))
            });
            low.collect::<Vec<(f64, usize)>>()
        });
        let mut cells = found.concat();
        if cells.len() > MOST {
            cells.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            cells.truncate(MOST);
        }
        let patch = |(_, cell): &(f64, usize)| self.patch_on_map(cell % width, cell / width);
        let mut patches: Vec<CubicPatch> = cells.iter().map(patch).collect();
        let mut least = 0.0;
        for _ in 0..DEPTH {
            least = patches.iter().map(CubicPatch::corner).fold(least, f64::min);
            patches.retain(below(least));
            keep_lowest(&mut patches, MOST);
            patches = patches.iter().flat_map(CubicPatch::quarters).collect();
        }
        patches.iter().map(CubicPatch::corner).fold(least, f64::min)
    }

    /// Returns the control points of what the map has of the patch between four nodes: it ends
    /// halfway to the outermost ones.
    fn patch_on_map(&self, i: usize, j: usize) -> CubicPatch {
        let CubicPatch(mut points) = self.patch(i, j);
        let inner = |cell: usize, count: usize| match cell {
            0 => Some(1),
            _ => (cell + 2 == count).then_some(0),
        };
        if let Some(half) = inner(i, self.nodes[0]) {
            points = points.map(|row| halves(row)[half]);
        }
        if let Some(half) = inner(j, self.nodes[1]) {
            points = halves(points)[half];
        }
        CubicPatch(points)
    }

    /// Returns the control points of the patch between four nodes.
    fn patch(&self, i: usize, j: usize) -> CubicPatch {
        let mut points = [[0.0; 4]; 4];
        for (b, side_y) in [(0, 1.0), (3, -1.0)] {
            for (a, side_x) in [(0, 1.0), (3, -1.0)] {
                let state = self.states[(j + b / 3) * self.nodes[0] + i + a / 3];
                let (inner_a, inner_b) = (1 + a / 3, 1 + b / 3);
                let (x, y) = (side_x / 3.0, side_y / 3.0);
                points[b][a] = state.gap;
                points[b][inner_a] = state.gap + x * state.along_x;
                points[inner_b][a] = state.gap + y * state.along_y;
                points[inner_b][inner_a] =
                    state.gap + x * state.along_x + y * state.along_y + x * y * state.twist;
            }
        }
        CubicPatch(points)
    }
}

/// Keeps the patches that reach lowest, `most` of them.
fn keep_lowest(patches: &mut Vec<CubicPatch>, most: usize) {
    if patches.len() > most {
        patches.sort_by(|a, b| a.lowest().total_cmp(&b.lowest()));
        patches.truncate(most);
    }
}

/// The control points of a bicubic polynomial over a square, in whose hull it lies.
#[derive(Clone, Copy, Debug)]
struct CubicPatch([[f64; 4]; 4]);

impl CubicPatch {
    /// Returns a bound below the polynomial.
    fn lowest(&self) -> f64 {
        self.0.as_flattened().iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Returns the smallest value at a corner.
    fn corner(&self) -> f64 {
        let [low, .., high] = &self.0;
        low[0].min(low[3]).min(high[0]).min(high[3])
    }

    /// Returns the same polynomial over the four quarters of the square.
    fn quarters(&self) -> [CubicPatch; 4] {
        let split = halves(self.0.map(halves));
        [[0, 0], [0, 1], [1, 0], [1, 1]]
            .map(|[y, x]| CubicPatch(split[y].map(|row: [_; 2]| row[x])))
    }
}

/// Values that can be averaged: a number, or several at once.
trait Averaged: Copy {
    fn average(self, other: Self) -> Self;
}

impl Averaged for f64 {
    fn average(self, other: Self) -> Self {
        0.5 * self + 0.5 * other
    }
}

impl<T: Averaged, const N: usize> Averaged for [T; N] {
    fn average(self, other: Self) -> Self {
        std::array::from_fn(|k| self[k].average(other[k]))
    }
}

/// Splits the control points of a cubic polynomial into those of its two halves.
fn halves<T: Averaged>([a, b, c, d]: [T; 4]) -> [[T; 4]; 2] {
    let (ab, bc, cd) = (a.average(b), b.average(c), c.average(d));
    let (abc, bcd) = (ab.average(bc), bc.average(cd));
    let middle = abc.average(bcd);
    [[a, ab, abc, middle], [middle, bcd, cd, d]]
}

/// The weights of values and of slopes at successive nodes of a row.
struct NodeWeights {
    /// The index of the first node.
    first: usize,
    /// The weight of the value and that of the slope at each node.
    weights: Vec<[f64; 2]>,
}

impl NodeWeights {
    /// Returns the weights of the value at a place in pixels, the first centre at 0. There are
    /// `count` nodes, the first one at −1; beyond the last ones the surface is level.
    fn at(place: f64, count: usize) -> Self {
        let last = (count - 1) as f64;
        let place = (place + 1.0).clamp(0.0, last);
        let first = (place.floor() as usize).min(count - 2);
        let mut weights = vec![[0.0; 2]; 2];
        add_hermite(&mut weights, place - first as f64, 1.0);
        Self { first, weights }
    }

    /// Returns the weights of the mean over an interval in pixels, likewise.
    fn over([low, high]: [f64; 2], count: usize) -> Self {
        let (low, high, last) = (low + 1.0, high + 1.0, (count - 1) as f64);
        let width = high - low;
        if width.is_nan() || width <= 0.0 {
            return Self::at(0.5 * (low + high) - 1.0, count);
        }
        let node = |place: f64| (place.clamp(0.0, last) as usize).min(count - 2);
        let (first, end) = (node(low), node(high));
        let mut weights = vec![[0.0; 2]; end + 2 - first];
        for cell in first..=end {
            let start = cell as f64;
            let (from, to) = (low.max(start) - start, high.min(start + 1.0) - start);
            if to > from {
                // Gauss's rule with two points is exact for a cubic polynomial.
                let (middle, offset) = (0.5 * (from + to), (to - from) / 12f64.sqrt());
                for place in [middle - offset, middle + offset] {
                    add_hermite(&mut weights[cell - first..], place, 0.5 * (to - from) / width);
                }
            }
        }
        weights[0][0] += (high.min(0.0) - low).max(0.0) / width;
        weights[end + 1 - first][0] += (high - low.max(last)).max(0.0) / width;
        Self { first, weights }
    }
}

/// Adds the weights of the value at a place between two nodes, from 0 to 1, `share` times.
fn add_hermite(weights: &mut [[f64; 2]], place: f64, share: f64) {
    let rest = 1.0 - place;
    let [[value_low, slope_low], [value_high, slope_high], ..] = weights else { return };
    *value_low += share * rest * rest * (1.0 + 2.0 * place);
    *slope_low += share * rest * rest * place;
    *value_high += share * place * place * (1.0 + 2.0 * rest);
    *slope_high -= share * place * place * rest;
}

/// Returns the pixels with one node more beyond each edge.
fn padded(columns: usize, rows: usize, gaps: &[f64]) -> Vec<f64> {
    let width = columns + 2;
    let mut padded = vec![0.0; width * (rows + 2)];
    for (row, line) in padded.chunks_mut(width).skip(1).zip(gaps.chunks(columns)) {
        row[1..=columns].copy_from_slice(line);
        row[0] = beyond(columns, |k| line[k]);
        row[columns + 1] = beyond(columns, |k| line[columns - 1 - k]);
    }
    for i in 0..width {
        let (low, high) = (i, (rows + 1) * width + i);
        padded[low] = beyond(rows, |k| padded[(k + 1) * width + i]);
        padded[high] = beyond(rows, |k| padded[(rows - k) * width + i]);
    }
    // A corner is beyond a row and beyond a column; neither goes before the other.
    for row in [0, rows + 1] {
        for (corner, next) in [(0, 1), (columns + 1, -1)] {
            let along = |k: usize| {
                let i = corner as isize + next * (k as isize + 1);
                padded[row * width + i as usize]
            };
            let by_row = beyond(columns, along);
            let place = &mut padded[row * width + corner];
            *place = 0.5 * *place + 0.5 * by_row;
        }
    }
    padded
}

/// Returns the value at the node before the first of a row of `count` values.
fn beyond(count: usize, value: impl Fn(usize) -> f64) -> f64 {
    match count {
        0 | 1 => value(0),
        2 => value(0) - (value(1) - value(0)),
        _ => value(0) - step_beyond(value(1) - value(0), value(2) - value(1)),
    }
}

/// Returns the step that comes before the steps `first` and `second` of a row. It is that of a
/// parabola, unless the parabola turns there or bends so much that the edge cannot be resolved.
fn step_beyond(first: f64, second: f64) -> f64 {
    let (parabola, bound) = (2.0 * first - second, 3.0 * second);
    if parabola * bound.signum() <= 0.0 || second == 0.0 {
        0.0
    } else if parabola.abs() < bound.abs() {
        parabola
    } else {
        bound
    }
}

/// The slope at a node of a row, and what the steps to its left and its right contribute to it.
struct RowSlope {
    slope: f64,
    shares: [f64; 2],
}

impl RowSlope {
    /// Finds the slope at a node of a row of `count` values.
    fn at(node: usize, count: usize, value: impl Fn(usize) -> f64) -> Self {
        let step = |k: usize| value(k + 1) - value(k);
        let last = count - 2;
        // The two steps before the node, from the nearer one on.
        let before = match node {
            0 => {
                let one = step_beyond(step(0), step(1));
                [one, step_beyond(one, step(0))]
            }
            1 => [step(0), step_beyond(step(0), step(1))],
            _ => [step(node - 1), step(node - 2)],
        };
        let after = match last + 1 - node {
            0 => {
                let one = step_beyond(step(last), step(last - 1));
                [one, step_beyond(one, step(last))]
            }
            1 => [step(last), step_beyond(step(last), step(last - 1))],
            _ => [step(node), step(node + 1)],
        };
        let bend = |[near, far]: [f64; 2]| (near - far).abs() + SLANT * (near + far).abs();
        let (left, right) = (bend(after), bend(before));
        let sum = left + right;
        let shares = if sum > 0.0 { [left / sum, right / sum] } else { [0.5; 2] };
        Self { slope: shares[0] * before[0] + shares[1] * after[0], shares }
    }
}

/// Returns the gap and its derivatives at a node of the padded pixels.
fn node_state(padded: &[f64], nodes: [usize; 2], i: usize, j: usize) -> NodeState {
    let value = |i: usize, j: usize| padded[j * nodes[0] + i];
    let x = RowSlope::at(i, nodes[0], |k| value(k, j));
    let y = RowSlope::at(j, nodes[1], |k| value(i, k));
    let cells = |node: usize, count: usize| [node.saturating_sub(1), node.min(count - 2)];
    let mut twist = 0.0;
    for (b, share_y) in cells(j, nodes[1]).into_iter().zip(y.shares) {
        for (a, share_x) in cells(i, nodes[0]).into_iter().zip(x.shares) {
            let upper = value(a + 1, b + 1) - value(a, b + 1);
            twist += share_x * share_y * (upper - (value(a + 1, b) - value(a, b)));
        }
    }
    NodeState { gap: value(i, j), along_x: x.slope, along_y: y.slope, twist }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lays the surface through samples of a function at the centres of pixels.
    fn sampled(columns: usize, rows: usize, gap: impl Fn(f64, f64) -> f64) -> Interpolant {
        let gaps: Vec<f64> =
            (0..columns * rows).map(|s| gap((s % columns) as f64, (s / columns) as f64)).collect();
        Interpolant::new(columns, &gaps, |_| true)
    }

    #[test]
    fn paraboloids_are_exact_up_to_the_edge() {
        let gap = |x: f64, y: f64| {
            let (u, v) = (x - 6.3, y - 7.6);
            0.7 * u * u - 0.4 * u * v + 0.3 * v * v
        };
        let surface = sampled(14, 17, gap);
        for k in 0..40 * 40 {
            let (x, y) =
                (-0.5 + (k % 40) as f64 / 40.0 * 14.0, -0.5 + (k / 40) as f64 / 40.0 * 17.0);
            assert!((surface.at(x, y) - gap(x, y)).abs() < 1e-6, "{x} {y}: {}", surface.at(x, y));
        }
        // The lowest point lies between the pixels.
        assert!(surface.least().abs() < 1e-6 && surface.least() <= 0.0, "{}", surface.least());
        let exact = gap(3.2, 5.1) + 0.7 * 0.4 * 0.4 / 12.0 + 0.3 * 0.04 / 12.0;
        assert!((surface.mean([3.0, 3.4], [5.0, 5.2]) - exact).abs() < 1e-6);
    }

    #[test]
    fn nothing_bulges_beside_a_step_or_on_the_rim_of_a_plateau() {
        let plateau = |x: f64, y: f64| if x < 4.0 || y < 3.0 { 1.0 } else { 0.0 };
        let frustum = |x: f64, _: f64| (x - 5.0).max(0.0);
        for surface in [sampled(9, 8, plateau), sampled(9, 8, frustum)] {
            assert!(surface.least() > -1e-8, "{}", surface.least());
            let highest =
                |k: usize| surface.at(-0.5 + (k % 64) as f64 / 8.0, -0.5 + (k / 64) as f64 / 8.0);
            assert!((0..64 * 64).map(highest).fold(0.0, f64::max) < 4.0);
        }
        assert_eq!(sampled(9, 8, plateau).at(4.5, 5.0), 0.0);
    }

    #[test]
    fn planes_and_single_rows_are_straight() {
        let plane = |x: f64, y: f64| 0.5 * x - 0.25 * y;
        for (columns, rows) in [(2, 2), (3, 2), (7, 5)] {
            let surface = sampled(columns, rows, plane);
            for (x, y) in [(-0.5, -0.5), (0.3, 0.8), (columns as f64 - 0.5, rows as f64 - 0.5)] {
                assert!((surface.at(x, y) - plane(x, y)).abs() < 1e-12);
            }
            let corner = plane(-0.5, rows as f64 - 0.5);
            assert!((surface.least() - corner).abs() < 1e-8, "{} {corner}", surface.least());
        }
        let row = sampled(6, 1, |x, _| x * x);
        assert_eq!((row.at(2.0, -0.5), row.at(2.0, 0.3)), (4.0, 4.0));
        assert_eq!(sampled(1, 1, |_, _| 0.0).mean([-9.0, 9.0], [-9.0, 9.0]), 0.0);
    }

    #[test]
    fn turned_and_mirrored_maps_have_turned_and_mirrored_surfaces() {
        let height = |x: f64, y: f64| ((x * 7.0 + y * 13.0) * 29.0) % 11.0;
        let (n, m) = (6.0, 9.0);
        let plain = sampled(6, 9, height);
        let mirrored = sampled(6, 9, |x, y| height(n - 1.0 - x, y));
        let turned = sampled(9, 6, |x, y| height(y, x));
        assert!((plain.least() - mirrored.least()).abs() < 1e-9);
        assert!((plain.least() - turned.least()).abs() < 1e-9);
        for k in 0..400 {
            let (x, y) = (-0.5 + (k % 20) as f64 / 20.0 * n, -0.5 + (k / 20) as f64 / 20.0 * m);
            assert!((plain.at(x, y) - mirrored.at(n - 1.0 - x, y)).abs() < 1e-12);
            assert!((plain.at(x, y) - turned.at(y, x)).abs() < 1e-12);
        }
    }
}
