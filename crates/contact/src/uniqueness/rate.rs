//! The fields by which μ* of a half-space is shown to be at most C/√n on n × n elements.
//!
//! docs/book/src/measured/uniqueness.md has the proof ("On ever finer meshes") and its letters. Of the
//! stripes the fields here have the leading term only, and y₁ = −ηx₁ with a small η in place of 0,
//! so that rounding decides nothing.

use super::question::{Question, Sole};
use super::system::{System, dot};
use super::witness::Witness;
use crate::model::{Foundation, Material, Mesh};

/// The radius of the disk with stripes, over the side of Ω.
const RADIUS: f64 = 0.45;
/// The steepness of φ at the border of the disk, over the side of Ω.
const STEEPNESS: f64 = 0.05;
/// The value t₀ of φ above which tractions along the stripes may do positive work.
const THRESHOLD: f64 = 0.4;
/// The share θ of tractions against it below.
const AGAINST: f64 = 0.3;
/// K, the tractions along the stripes times √n.
const ALONG: f64 = 2.5;
/// η, over the largest diagonal entry of A.
const SHIFT: f64 = 1e-6;

/// An operator on square elements, with what builds the field.
struct StripedSquare {
    system: System,
    n: usize,
}

impl StripedSquare {
    fn new(n: u32, poisson: f64) -> Self {
        let side = f64::from(n);
        let question = Question {
            foundation: Foundation::half_space(Material { shear_modulus: 1.0, poisson }),
            punch: None,
            sole: Sole::Rectangle { width_x: side, width_y: side },
            mesh: Mesh::Exact([n, n]),
            projection: Default::default(),
            epsilon: 0.0,
            plane: false,
        };
        Self { system: System::new(&question).unwrap(), n: n as usize }
    }

    fn elements(&self) -> usize {
        self.n * self.n
    }

    /// Returns the place (i, j) of each element.
    fn places(&self) -> Vec<[usize; 2]> {
        let grid = self.system.grid();
        grid.active().map(|e| grid.position(e)).map(|(i, j)| [i, j]).collect()
    }

    fn apply(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        self.system.apply(&mut y, x, &mut self.system.scratch());
        y
    }

    /// Returns A times a pressure.
    fn of_pressure(&self, pressure: &[f64]) -> Vec<f64> {
        let mut x = pressure.to_vec();
        x.resize(3 * self.elements(), 0.0);
        self.apply(&x)
    }

    /// Returns a field of tractions in the plane, of a size along a direction for each element.
    fn in_plane(&self, size: &[f64], direction: impl Fn(usize) -> [f64; 2]) -> Vec<f64> {
        let k = self.elements();
        let mut x = vec![0.0; 3 * k];
        for e in 0..k {
            let [along_x, along_y] = direction(e);
            (x[k + e], x[2 * k + e]) = (size[e] * along_x, size[e] * along_y);
        }
        x
    }

    /// Adds the pressures with y₁ = −ηx₁ to tractions in the plane, by conjugate gradients.
    fn with_pressures(&self, mut x: Vec<f64>) -> Vec<f64> {
        let k = self.elements();
        let shift = SHIFT * self.system.largest_diagonal();
        let mut residual: Vec<f64> = self.apply(&x)[..k].iter().map(|y| -y).collect();
        let mut step = residual.clone();
        let mut square = dot(&residual, &residual);
        let target = 1e-28 * square;
        while square > target {
            let mut image = self.of_pressure(&step);
            image.truncate(k);
            image.iter_mut().zip(&step).for_each(|(image, step)| *image += shift * step);
            let length = square / dot(&step, &image);
            for e in 0..k {
                x[e] += length * step[e];
                residual[e] -= length * image[e];
            }
            let next = dot(&residual, &residual);
            step.iter_mut().zip(&residual).for_each(|(s, r)| *s = r + next / square * *s);
            square = next;
        }
        x
    }

    /// Returns the mean of the ratio of a response to a pattern of signs, in the middle of Ω.
    fn in_the_middle(&self, response: &[f64], signs: &[f64]) -> f64 {
        let is_middle = |i: usize| i.abs_diff(self.n / 2) < 3;
        let places = self.places();
        let ratios: Vec<f64> = (0..self.elements())
            .filter(|&e| places[e].into_iter().all(is_middle))
            .map(|e| response[e] / signs[e])
            .collect();
        ratios.iter().sum::<f64>() / ratios.len() as f64
    }

    /// Returns the field.
    fn field(&self) -> Vec<f64> {
        let (k, places) = (self.elements(), self.places());
        let height = |[i, j]: [usize; 2]| {
            let [x, y] = [i, j].map(|i| (i as f64 + 0.5) / self.n as f64 - 0.5);
            let depth = RADIUS - x.hypot(y);
            if depth <= 0.0 { 0.0 } else { (STEEPNESS / RADIUS - STEEPNESS / depth).exp() }
        };
        let heights: Vec<f64> = places.iter().map(|&place| height(place)).collect();
        let most = ALONG / (self.n as f64).sqrt();
        let along: Vec<f64> = heights.iter().map(|&phi| most * flow(phi)).collect();
        let root = std::f64::consts::FRAC_1_SQRT_2;
        // The signs of cos and sin of (i + j)π/2 + π/4.
        let signs = |pattern: [f64; 4]| -> Vec<f64> {
            places.iter().map(|[i, j]| pattern[(i + j) % 4]).collect()
        };
        let (even, odd) = (signs([1.0, -1.0, -1.0, 1.0]), signs([1.0, 1.0, -1.0, -1.0]));
        let mut x = self.in_plane(&along, |_| [root, -root]);
        let smooth = self.apply(&self.with_pressures(x.clone()));
        let stiffness = self.in_the_middle(&self.of_pressure(&even), &even);
        let coupled = self.apply(&self.in_plane(&odd, |_| [root, root]));
        let coupling = self.in_the_middle(&coupled, &even);
        // The direction m across the displacements.
        let across = |e: usize| {
            let [y2, y3] = [smooth[k + e], smooth[2 * k + e]];
            [-y3 / y2.hypot(y3), y2 / y2.hypot(y3)]
        };
        let amplitude = |e: usize| {
            let [m2, m3] = across(e);
            -stiffness / coupling * odd[e] * heights[e] / (root * (m2 + m3))
        };
        let stripes: Vec<f64> = (0..k).map(amplitude).collect();
        let stripes = self.in_plane(&stripes, across);
        x.iter_mut().zip(&stripes).for_each(|(x, stripes)| *x += stripes);
        self.with_pressures(x)
    }
}

/// Returns the tractions along the stripes over the largest ones, f(φ)/c.
fn flow(phi: f64) -> f64 {
    let part = (phi / THRESHOLD - 1.0).clamp(0.0, 1.0);
    let share = part.powi(3) * (10.0 - part * (15.0 - 6.0 * part));
    share - (1.0 - share) * AGAINST * phi.powf(0.25)
}

/// Returns the μ that the field on n × n elements needs, times √n.
fn scaled_need(n: u32, poisson: f64) -> f64 {
    let square = StripedSquare::new(n, poisson);
    let x = square.field();
    let stiffness = super::upper::STIFFNESS / square.system.largest_diagonal();
    let bound = Witness { mu: 1e3, stiffness, x };
    let mu = bound.verify(&square.system).unwrap().least_mu;
    mu * f64::from(n).sqrt()
}

#[test]
fn a_field_of_stripes_needs_a_friction_in_proportion_to_the_root_of_the_element() {
    for (poisson, most) in [(0.0, 7.0), (0.3, 10.5)] {
        let [coarse, fine] = [64, 128].map(|n| scaled_need(n, poisson));
        assert!(coarse < most && fine < coarse, "ν = {poisson}: {coarse}, {fine}");
    }
}

/// Prints what the fields need on ever finer meshes.
#[test]
#[ignore = "prints a table"]
fn table_of_fields_of_stripes() {
    println!("| n | ν = 0 | ν = 0.3 |");
    for n in [64, 128, 256, 512] {
        println!("| {n} | {:.3} | {:.3} |", scaled_need(n, 0.0), scaled_need(n, 0.3));
    }
}
