//! Starting points of a search, in the problem's units.

use std::f64::consts::TAU;

use super::natural_map::ElementState;
use crate::common::random::SplitMix64;
use crate::grid::Grid;
use crate::problem::{Problem, g_mu};

/// Returns the `stream`-th generator of a seed.
pub(super) fn generator(seed: u64, stream: u64) -> SplitMix64 {
    SplitMix64(SplitMix64(seed).next() ^ stream.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

fn direction(generator: &mut SplitMix64) -> [f64; 2] {
    let (y, x) = (TAU * generator.unit()).sin_cos();
    [x, y]
}

/// Estimates the traction that f leads to: the largest value of f, with the displacement by unit
/// traction on Ω taken for 1.
fn size(problem: &Problem) -> f64 {
    problem
        .grid
        .active()
        .flat_map(|e| problem.gather(&problem.f, e))
        .fold(0.0, |a: f64, f| a.max(f.abs()))
}

/// Returns the half-widths and the centre of the grid.
fn extent(grid: &Grid) -> ([f64; 2], [f64; 2]) {
    let [first, last] = [grid.center(0), grid.center(grid.len() - 1)];
    let center = [0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1])];
    ([0.5 * grid.nx() as f64 * grid.hx(), 0.5 * grid.ny() as f64 * grid.hy()], center)
}

/// Returns a half ellipsoid of pressure over the grid, without tangential tractions.
pub(super) fn hertz(problem: &Problem) -> Vec<f64> {
    let ([a, b], [x0, y0]) = extent(&problem.grid);
    let size = size(problem);
    let mut p = vec![0.0; problem.f.len()];
    for e in problem.grid.active() {
        let [x, y] = problem.grid.center(e);
        p[e] = size * (1.0 - ((x - x0) / a).powi(2) - ((y - y0) / b).powi(2)).max(0.0).sqrt();
    }
    p
}

/// Draws random tractions inside the friction cone, of a random size and with a random share of
/// elements open.
pub(super) fn tractions(problem: &Problem, generator: &mut SplitMix64) -> Vec<f64> {
    let k = problem.grid.len();
    let size = size(problem) * 10_f64.powf(generator.signed());
    let open = 0.8 * generator.unit();
    let mut p = vec![0.0; problem.f.len()];
    for e in problem.grid.active() {
        let (chance, pressure, share, n) = (
            generator.unit(),
            size * generator.unit(),
            generator.unit().sqrt(),
            direction(generator),
        );
        if chance >= open {
            [p[e], p[k + e], p[2 * k + e]] = [
                pressure,
                share * problem.mu * pressure * n[0],
                share * problem.mu * pressure * n[1],
            ];
        }
    }
    p
}

/// Draws a random pattern: every element by itself, or by the regions between two random lines. In
/// a region, slip then has one direction, or goes towards or away from a point.
pub(super) fn pattern(
    grid: &Grid,
    is_independent: bool,
    generator: &mut SplitMix64,
) -> Vec<ElementState> {
    let shares = [generator.unit(), generator.unit(), generator.unit()];
    let total: f64 = shares.iter().sum();
    let draw = |generator: &mut SplitMix64| {
        let chance = total * generator.unit();
        let n = direction(generator);
        if chance < shares[0] {
            ElementState::Open
        } else if chance < shares[0] + shares[1] {
            ElementState::Stick
        } else {
            ElementState::Slip(n)
        }
    };
    if is_independent {
        return (0..grid.len()).map(|_| draw(generator)).collect();
    }
    let ([a, b], [x0, y0]) = extent(grid);
    let inside =
        |generator: &mut SplitMix64| [x0 + a * generator.signed(), y0 + b * generator.signed()];
    let lines = [0, 1].map(|_| (inside(generator), direction(generator)));
    let regions = [0, 1, 2, 3].map(|_| draw(generator));
    let (middle, chance) = (inside(generator), generator.unit());
    (0..grid.len())
        .map(|e| {
            let [x, y] = grid.center(e);
            let side = |&(on, n): &([f64; 2], [f64; 2])| {
                usize::from((x - on[0]) * n[0] + (y - on[1]) * n[1] > 0.0)
            };
            match regions[2 * side(&lines[0]) + side(&lines[1])] {
                ElementState::Slip(_) if chance < 0.5 => {
                    let (dx, dy) = (x - middle[0], y - middle[1]);
                    let sign = if chance < 0.25 { 1.0 } else { -1.0 }
                        / dx.hypot(dy).max(f64::MIN_POSITIVE);
                    ElementState::Slip([sign * dx, sign * dy])
                }
                piece => piece,
            }
        })
        .collect()
}

/// Disturbs every component of a solution by up to `size` times its largest traction, or the size
/// that f leads to if it has none, and puts it back into the cone.
pub(super) fn disturbed(
    problem: &Problem,
    p: &[f64],
    size: f64,
    generator: &mut SplitMix64,
) -> Vec<f64> {
    let k = problem.grid.len();
    let largest = p.iter().fold(0.0, |a: f64, p| a.max(p.abs()));
    let unit = size * if largest > 0.0 { largest } else { self::size(problem) };
    let mut disturbed = vec![0.0; p.len()];
    for e in problem.grid.active() {
        let traction = [p[e], p[k + e], p[2 * k + e]].map(|p| p + unit * generator.signed());
        [disturbed[e], disturbed[k + e], disturbed[2 * k + e]] =
            g_mu(traction, problem.mu, problem.ceiling);
    }
    disturbed
}

/// Returns the images of tractions under the symmetries of the grid: mirrored in x, in y, in both,
/// and on a square grid of square elements with x and y exchanged as well.
pub(super) fn images(grid: &Grid, p: &[f64]) -> Vec<Vec<f64>> {
    let k = grid.len();
    let is_square = grid.nx() == grid.ny() && (grid.hx() / grid.hy() - 1.0).abs() < 1e-12;
    (1..if is_square { 8 } else { 4 })
        .map(|symmetry| {
            let [mirror_x, mirror_y, exchange] = [1, 2, 4].map(|bit| symmetry & bit != 0);
            let mut image = vec![0.0; p.len()];
            for e in grid.active() {
                let mut traction = [p[k + e], p[2 * k + e]];
                let (mut i, mut j) = grid.position(e);
                if mirror_x {
                    (i, traction[0]) = (grid.nx() - 1 - i, -traction[0]);
                }
                if mirror_y {
                    (j, traction[1]) = (grid.ny() - 1 - j, -traction[1]);
                }
                if exchange {
                    (i, j, traction) = (j, i, [traction[1], traction[0]]);
                }
                let to = grid.index(i, j);
                if grid.is_active(to) {
                    [image[to], image[k + to], image[2 * k + to]] =
                        [p[e], traction[0], traction[1]];
                }
            }
            image
        })
        .collect()
}
