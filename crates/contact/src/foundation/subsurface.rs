//! Stresses at a depth of the foundation under a uniform traction on a rectangle of its surface.
//!
//! The half-space's are in closed form (`rectangle`). Those of layers are Hankel transforms of the
//! functions of `layered_stress`, tabulated over the distance from a point load and integrated over
//! the rectangle by Gauss rules, just as the displacements of the surface are in `radial`: there is
//! no period whose images could matter. In the top layer the tables hold only what its half-space
//! lacks, so that depths far below an element's size are as good as others.

use rayon::prelude::*;

use super::hankel::{LogGrid, Transform};
use super::layered::Layered;
use super::layered_stress::{Cut, DepthSide, FUNCTIONS, HARMONICS, Ten};
use super::radial::{DEGREE, PANEL, chebyshev, clenshaw, longest_feature};
use super::rectangle::{self, StressBlock};
use crate::common::gauss;
use crate::model::{Foundation, Material};

/// The stresses at one depth.
#[derive(Clone, Debug)]
pub(crate) struct StressKernels {
    /// The depth.
    depth: f64,
    /// Poisson's ratio of the half-space whose stresses are a part of these; `None` if there is
    /// none.
    half_space: Option<f64>,
    /// The rest, under layers.
    layers: Option<Box<DepthTable>>,
}

impl StressKernels {
    /// Prepares the stresses at a depth ≥ 0, on this side of it, for distances up to `reach` along
    /// the surface, in the unit of the layers' thicknesses. Returns `None` in a rigid base.
    ///
    /// In a half-space they are good to 1e-12 of the largest, in layers to 1e-10.
    pub(crate) fn new(
        foundation: &Foundation,
        depth: f64,
        side: DepthSide,
        reach: f64,
    ) -> Option<Self> {
        let Some(layered) = Layered::new(&foundation.layers, &foundation.base) else {
            let Material { poisson, .. } = foundation.surface()?;
            return Some(Self { depth, half_space: Some(poisson), layers: None });
        };
        // Stresses depend on ratios of moduli, and squares of moduli may be no numbers.
        let layered = layered.scaled(layered.layers()[0].shear_modulus);
        let cut = Cut::new(&layered, depth, side)?;
        let top = layered.layers()[0];
        let is_in_top = side.is_above(depth, top.thickness);
        // The distance at which the nearest images of a load seem to lie.
        let clear = if is_in_top { 2.0 * top.thickness - depth } else { depth };
        let top_alone = is_in_top.then(|| Cut::of_half_space(top.material(), depth));
        let longest = longest_feature(&layered).max(reach).max(depth);
        let table = DepthTable::new(&cut, top_alone.as_ref(), [clear, longest], reach);
        Some(Self {
            depth,
            half_space: is_in_top.then_some(top.poisson),
            layers: Some(Box::new(table)),
        })
    }

    /// Returns the stresses at (x, y) from the middle of a rectangle with these half-sides, under
    /// unit tractions on it.
    pub(crate) fn stresses(&self, receiver: [f64; 2], half_sides: [f64; 2]) -> StressBlock {
        let mut sum = match self.half_space {
            Some(nu) => rectangle::stresses(receiver, self.depth, half_sides, nu),
            None => StressBlock::default(),
        };
        if let Some(layers) = &self.layers {
            layers.add_rectangle(receiver, half_sides, &mut sum);
        }
        sum
    }
}

/// Returns the depths at which materials meet, from the surface down, the rigid base's included.
pub(crate) fn interfaces(foundation: &Foundation) -> Vec<f64> {
    let Some(layered) = Layered::new(&foundation.layers, &foundation.base) else {
        return Vec::new();
    };
    let mut bottom = 0.0;
    layered
        .layers()
        .iter()
        .map(|layer| {
            bottom += layer.thickness;
            bottom
        })
        .collect()
}

/// Returns the largest length over which the stresses vary that layers make; 0 in a half-space.
pub(crate) fn longest_length(foundation: &Foundation) -> f64 {
    Layered::new(&foundation.layers, &foundation.base)
        .map_or(0.0, |layers| longest_feature(&layers))
}

/// The Hankel transforms of the ten functions at one depth, over the distance.
#[derive(Clone, Debug)]
struct DepthTable {
    /// The distance at which the nearest images of a load seem to lie.
    clear: f64,
    /// The transforms over (r/s)ⁿ, n the order, in t = 2(r/s)² − 1, s half of that distance.
    near: [Ten; DEGREE],
    /// The transforms times r², from s outwards.
    panels: Vec<[Ten; DEGREE]>,
}

impl DepthTable {
    /// Tabulates the functions of `cut`, less those of a half-space, if one is given, for r ≤
    /// `reach`. The lengths between which they vary are the nearest images' distance and the
    /// longest feature.
    fn new(cut: &Cut, less: Option<&Cut>, [clear, longest]: [f64; 2], reach: f64) -> Self {
        /// The product of wavenumber and distance of the nearest images beyond which nothing is
        /// left.
        const DEEPEST: f64 = 45.0;
        /// The logarithm of the range in which the weights let the smallest wavenumbers fade like
        /// √k.
        const FADED: f64 = 80.0;
        /// The step in ln k, which is halved until it is small enough.
        const STEP: f64 = 0.08;
        let scale = 0.5 * clear;
        let mut grid = LogGrid::new([(-FADED).exp() / longest, DEEPEST / clear], 1.0 / clear, STEP);
        let mut coarser = f64::INFINITY;
        let weighted = loop {
            let samples: Vec<Ten> = grid
                .wavenumbers()
                .map(|k| {
                    let whole = cut.functions(k);
                    let part = less.map_or([0.0; FUNCTIONS], |less| less.functions(k));
                    std::array::from_fn(|i| k * (whole[i] - part[i]))
                })
                .collect();
            let transforms = [0.5, -0.5].map(|weight| {
                (0..FUNCTIONS)
                    .map(|i| {
                        let of_one = samples.iter().map(|ten| ten[i]);
                        Transform::new(&grid, of_one, HARMONICS[i], weight)
                    })
                    .collect::<Vec<_>>()
            });
            let unresolved =
                transforms.iter().flatten().fold(0.0_f64, |most, t| most.max(t.unresolved));
            // What no longer falls is rounding.
            if unresolved < 1e-13 || unresolved > 0.01 * coarser {
                break transforms;
            }
            coarser = unresolved;
            grid = grid.refined();
        };
        let [inner, outer] = weighted;
        let times_r = |i: usize, r: f64| {
            let quieter = if inner[i].noise(r) <= outer[i].noise(r) { &inner } else { &outer };
            quieter[i].times_r(r)
        };
        let near = chebyshev(|t| {
            let ratio = (0.5 * (1.0 + t)).sqrt();
            let r = ratio * scale;
            std::array::from_fn(|i| times_r(i, r) / r / ratio.powf(HARMONICS[i]))
        });
        let count = ((reach / scale).ln() / PANEL).ceil().max(0.0) as usize;
        let panels = (0..count)
            .into_par_iter()
            .map(|panel| {
                chebyshev(|t| {
                    let r = scale * (PANEL * (panel as f64 + 0.5 * (1.0 + t))).exp();
                    std::array::from_fn(|i| r * times_r(i, r))
                })
            })
            .collect();
        Self { clear, near, panels }
    }

    /// Returns the transforms at a distance.
    fn at(&self, r: f64) -> Ten {
        let ratio = 2.0 * r / self.clear;
        if ratio < 1.0 || self.panels.is_empty() {
            let ten = clenshaw(&self.near, 2.0 * ratio * ratio - 1.0);
            let powers = [1.0, ratio, ratio * ratio, ratio * ratio * ratio];
            return std::array::from_fn(|i| ten[i] * powers[HARMONICS[i] as usize]);
        }
        let place = ratio.ln() / PANEL;
        let panel = (place as usize).min(self.panels.len() - 1);
        let by_r2 = 1.0 / (r * r);
        clenshaw(&self.panels[panel], 2.0 * (place - panel as f64) - 1.0).map(|g| g * by_r2)
    }

    /// Returns the stresses at (x, y) from a point load, times 2π.
    fn block(&self, x: f64, y: f64) -> StressBlock {
        let r = (x * x + y * y).sqrt();
        let (c, s) = if r > 0.0 { (x / r, y / r) } else { (1.0, 0.0) };
        let (c2, s2) = ((c - s) * (c + s), 2.0 * c * s);
        let (c3, s3) = (c * c2 - s * s2, s * c2 + c * s2);
        let [zz_n, mean_n, half_n, lz_n, zz_l, mean_l, first_l, third_l, shear, twice] = self.at(r);
        [
            [
                mean_n - half_n * c2,
                third_l * c3 - (mean_l + first_l) * c,
                third_l * s3 - (mean_l - first_l) * s,
            ],
            [
                mean_n + half_n * c2,
                -third_l * c3 - (mean_l - first_l) * c,
                -third_l * s3 - (mean_l + first_l) * s,
            ],
            [zz_n, zz_l * c, zz_l * s],
            [-half_n * s2, third_l * s3 - first_l * s, -third_l * c3 - first_l * c],
            [-lz_n * s, -twice * s2, shear + twice * c2],
            [-lz_n * c, shear - twice * c2, -twice * s2],
        ]
    }

    /// Adds the integrals over the rectangle |x| ≤ a, |y| ≤ b.
    fn add_rectangle(&self, [x, y]: [f64; 2], [a, b]: [f64; 2], sum: &mut StressBlock) {
        let (gap_x, gap_y) = ((x.abs() - a).max(0.0), (y.abs() - b).max(0.0));
        // The functions are analytic within the images' distance of real r, and for |arg r| < 30°.
        let squared = |middle: f64, gap: f64, half: f64| {
            (0.25 * (middle * middle + gap * gap)).max(self.clear * self.clear) / (half * half)
        };
        let points_x = gauss::points(squared(x, gap_y, a));
        let points_y = gauss::points(squared(y, gap_x, b));
        let (Some(points_x), Some(points_y)) = (points_x, points_y) else {
            let (halves, offset) = if points_y.is_some() || (points_x.is_none() && a >= b) {
                ([0.5 * a, b], [0.5 * a, 0.0])
            } else {
                ([a, 0.5 * b], [0.0, 0.5 * b])
            };
            for side in [-1.0, 1.0] {
                let from = [x + side * offset[0], y + side * offset[1]];
                self.add_rectangle(from, halves, sum);
            }
            return;
        };
        let rules = gauss::uniform();
        let area = 4.0 * a * b / std::f64::consts::TAU;
        for &(v, weight_y) in &rules[points_y] {
            for &(u, weight_x) in &rules[points_x] {
                let point = self.block(x - a * u, y - b * v);
                let weight = area * weight_x * weight_y;
                for (row, stresses) in sum.iter_mut().zip(point) {
                    for (total, stress) in row.iter_mut().zip(stresses) {
                        *total += weight * stress;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Layer;

    fn layer(material: Material, thickness: f64) -> Layer {
        Layer { shear_modulus: material.shear_modulus, poisson: material.poisson, thickness }
    }

    fn largest(block: &StressBlock) -> f64 {
        block.iter().flatten().fold(0.0_f64, |most, stress| most.max(stress.abs()))
    }

    fn differ(a: &StressBlock, b: &StressBlock) -> f64 {
        a.iter()
            .flatten()
            .zip(b.iter().flatten())
            .fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
            / largest(b)
    }

    /// Returns the cut of a half-space into equal layers, which nothing simplifies.
    fn sliced(material: Material, depth: f64, thickness: f64) -> Cut {
        let mut cut = Cut::of_half_space(material, depth);
        cut.above = Vec::new();
        let mut left = depth;
        while left > thickness {
            cut.above.push(layer(material, thickness));
            left -= thickness;
        }
        cut.above.push(layer(material, left));
        cut.below = vec![layer(material, 0.3 * thickness), layer(material, 7.0)];
        cut
    }

    #[test]
    fn equal_layers_are_a_half_space_in_the_fourier_plane() {
        for nu in [0.0, 0.3, 0.5] {
            let material = Material { shear_modulus: 3.0, poisson: nu };
            for depth in [1e-3, 0.2, 1.0, 4.0] {
                for k in [1e-6, 0.01, 0.3, 1.0, 5.0, 20.0] {
                    let whole = Cut::of_half_space(material, depth).functions(k);
                    let cut = sliced(material, depth, 0.3).functions(k);
                    // The exponent itself is rounded.
                    let size = (1.0 + k * depth).powi(2) * (-k * depth).exp();
                    for (a, b) in whole.iter().zip(cut) {
                        assert!(
                            (a - b).abs() <= 1e-13 * size,
                            "{nu} {depth} {k} {whole:?} {cut:?}"
                        );
                    }
                }
            }
        }
    }

    /// The tables of a half-space, made without its closed form, give the closed form.
    #[test]
    fn transforms_and_closed_forms_agree() {
        for nu in [0.0, 0.3, 0.5] {
            let material = Material { shear_modulus: 3.0, poisson: nu };
            for depth in [0.05, 1.0, 3.0] {
                let cut = sliced(material, depth, 0.4);
                let table = DepthTable::new(&cut, None, [depth, 100.0], 100.0);
                for receiver in
                    [[0.0, 0.0], [0.3, 0.1], [-1.0, 0.7], [2.0, -3.0], [0.0, 9.0], [-60.0, 60.0]]
                {
                    let mut got = StressBlock::default();
                    table.add_rectangle(receiver, [0.5, 0.4], &mut got);
                    let exact = rectangle::stresses(receiver, depth, [0.5, 0.4], nu);
                    let error = differ(&got, &exact);
                    assert!(
                        error < 1e-10,
                        "{nu} {depth} {receiver:?}: {error:e}\n{got:?}\n{exact:?}"
                    );
                }
            }
        }
    }
}
