//! The upper side of μ*: a search for an x with small F(x).
//!
//! # What good fields look like
//! On fine meshes the tangential displacements y_t of the best fields known are one smooth field
//! along some direction n, with ripples. The pressures are stripes of alternating sign some two
//! elements wide, with y₁ = 0 nearly everywhere, and all elements need the same μ. Such an x has
//! x_t = u + p, where u is along n and the same at all elements, and p is across n and alternating.
//! Let Y ~ u times the elements across be the displacement by u, and |x₁| in proportion to p. Then
//! an element needs about (uY + p²)/(|x₁|Y), which is least where p² ~ uY, and falls like 1/√Y
//! there.
//!
//! So minimisations start from stripes of several wavelengths and directions; diagonal ones with a
//! period of four elements lead to the best fields on half-spaces. The stripes that serve depend on
//! what elements do to their neighbours. So where elements are many, all stripes are tried on a
//! section of Ω with at most 8 × 8 elements of the same size, and the best ones on the whole of it.
//! Few elements have too little room for stripes, and a large ε or a thin layer makes others best.
//! So up to 100 elements minimisations start from random fields too. The problem is not convex and
//! has many local minima, most of them with few elements.
//!
//! Every start has its own random numbers, so the result depends on the seed and the effort alone,
//! and not on the number of threads.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::descent::{Descent, Pattern};
use super::question::{Question, Sole, WitnessSearch};
use super::system::System;
use super::witness::{Witness, least_mu};
use crate::common::random::SplitMix64;
use crate::influence::Entry;
use crate::model::{Mesh, SceneError};

/// The outcome of a search for an upper bound of μ*.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Upper {
    /// Pressures move nothing sideways, and no x ≠ 0 is admissible, so μ* = ∞ exactly.
    Unbounded,
    /// μ* is at most the μ of a witness.
    Bound(Witness),
}

/// The reason why there is no upper bound.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UpperError {
    /// The question has no meaning.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// No start led to a field that meets the conditions.
    #[error(
        "no witness found from {starts} starts with {elements} elements: try more starts or another seed"
    )]
    NotFound {
        /// The number of starts on the question's own mesh.
        starts: usize,
        /// The number of elements of Ω.
        elements: usize,
    },
}

/// Returns the `stream`-th generator of a seed.
fn generator(seed: u64, stream: u64) -> SplitMix64 {
    SplitMix64(SplitMix64(seed).next() ^ SplitMix64(stream).next().rotate_left(17))
}

/// Draws a random field, smoothed by the operator up to twice, and with or without a symmetry,
/// which minimisations keep.
fn start(system: &System, random: &mut SplitMix64) -> Vec<f64> {
    let k = system.elements();
    let kind = random.next();
    let mut x: Vec<f64> = (0..3 * k).map(|_| random.signed()).collect();
    for _ in 0..kind % 3 {
        let mut y = vec![0.0; 3 * k];
        system.apply(&mut y, &x, &mut system.scratch());
        x = y;
    }
    let bit = |number: u32| (kind >> number) & 1 == 1;
    for (axis, first) in [(0, 8), (1, 16)] {
        if bit(first) {
            x = reflected(system, &x, axis, if bit(first + 1) { -1.0 } else { 1.0 });
        }
    }
    x
}

/// Returns the component of a field that changes by `sign` under the reflection of x (axis 0) or y
/// (axis 1).
fn reflected(system: &System, x: &[f64], axis: usize, sign: f64) -> Vec<f64> {
    let (grid, n) = (system.grid(), system.grid().len());
    let mut whole = vec![0.0; 3 * n];
    system.onto_grid(&mut whole, x);
    let mut sum = whole.clone();
    for e in grid.active() {
        let (i, j) = grid.position(e);
        let image = if axis == 0 {
            grid.index(grid.nx() - 1 - i, j)
        } else {
            grid.index(i, grid.ny() - 1 - j)
        };
        for block in 0..3 {
            let sign = if block == axis + 1 { -sign } else { sign };
            sum[block * n + e] += sign * whole[block * n + image];
        }
    }
    let mut field = vec![0.0; x.len()];
    system.off_grid(&mut field, &sum);
    field
}

/// The waves along x and y per element, and a phase, in units of full turns.
const STRIPES: [[f64; 3]; 12] = [
    [0.25, 0.25, 0.125],
    [0.25, 0.25, 0.375],
    [0.22, 0.22, 0.125],
    [0.3, 0.3, 0.125],
    [0.33, 0.33, 0.375],
    [0.2, 0.2, 0.125],
    [0.2, 0.3, 0.375],
    [0.33, 0.25, 0.375],
    [0.25, 0.125, 0.375],
    [0.25, 0.0, 0.125],
    [0.25, 0.0, 0.375],
    [0.33, 0.0, 0.375],
];

/// Returns the waves to try. Unless x and y are alike, on a square of square elements, they include
/// the same waves with the two exchanged.
fn waves(system: &System) -> Vec<[f64; 3]> {
    let grid = system.grid();
    let alike = grid.nx() == grid.ny() && grid.hx() == grid.hy();
    let exchanged =
        STRIPES.into_iter().filter(|[x, y, _]| !alike && x != y).map(|[x, y, phase]| [y, x, phase]);
    STRIPES.into_iter().chain(exchanged).collect()
}

/// Returns the stripes of a wave, with displacements along them.
fn stripes(system: &System, [along_x, along_y, phase]: [f64; 3]) -> Pattern {
    let grid = system.grid();
    let wave = |e: usize| {
        let (i, j) = grid.position(e);
        (std::f64::consts::TAU * (along_x * i as f64 + along_y * j as f64 + phase)).cos()
    };
    let across = [along_y / grid.hy(), -along_x / grid.hx()];
    let length = across[0].hypot(across[1]);
    let signs = grid.active().map(|e| if wave(e) < 0.0 { -1.0 } else { 1.0 }).collect();
    Pattern { signs, direction: across.map(|c| c / length) }
}

/// A field and the μ that it needs.
pub(super) struct Found {
    pub(super) mu: f64,
    pub(super) x: Vec<f64>,
}

/// The margin by which a witness meets its conditions, in units of those of a typical element. It
/// is far above the rounding of an application.
const MARGIN: f64 = 1e-9;

/// The number of elements up to which random starts are worth their time, and all stripes are
/// tried.
const FEW: usize = 100;

/// The number of elements across the section of Ω on which stripes are tried.
const SECTION: usize = 8;

/// Minimises from a start and makes the result strict.
fn improve(system: &System, mut x: Vec<f64>, pattern: Option<&Pattern>) -> Option<Found> {
    let mut descent = Descent::new(system, coupling(system), MARGIN);
    let mu = descent.minimise(&mut x, pattern);
    MORE.into_iter().find_map(|more| descent.restore(&mut x, more * mu))?;
    needed(system, x)
}

/// The factors of μ, in turn, until a field can be made strict. A minimisation that is cut short
/// needs a little more friction.
const MORE: [f64; 4] = [1.0, 1.003, 1.01, 1.03];

/// Returns a field with the μ that it needs, if it is a witness for any μ.
pub(super) fn needed(system: &System, x: Vec<f64>) -> Option<Found> {
    let mut y = vec![0.0; x.len()];
    system.apply(&mut y, &x, &mut system.scratch());
    let mu = least_mu(&x, &y).ok()?;
    (mu > 0.0 && mu.is_finite()).then_some(Found { mu, x })
}

/// Returns the coupling κ. It is 1 about where the bodies are compressible and only one of them
/// deforms, and 0 without coupling.
fn coupling(system: &System) -> f64 {
    let table = system.table();
    let ny = system.grid().ny() as i64;
    let rows = [Entry::Nx, Entry::Ny]
        .into_iter()
        .flat_map(|entry| (1 - ny..ny).map(move |dj| table.row(entry, dj)));
    let most = rows.flatten().fold(0.0, |most: f64, c| most.max(c.abs()));
    (10.0 * most / system.largest_diagonal()).min(1.0)
}

/// Minimises from a pattern.
fn from_pattern(system: &System, pattern: &Pattern) -> Option<Found> {
    let coupling = coupling(system);
    let pressures = pattern.signs.iter().map(|sign| coupling * sign);
    let along =
        pattern.direction.into_iter().flat_map(|c| std::iter::repeat_n(c, system.elements()));
    improve(system, pressures.chain(along).collect(), Some(pattern))
}

/// Minimises from the `stream`-th random start.
fn from_random(system: &System, search: &WitnessSearch, stream: u64) -> Option<Found> {
    let mut x = start(system, &mut generator(search.seed, stream));
    let coupling = coupling(system);
    x[..system.elements()].iter_mut().for_each(|x| *x *= coupling);
    improve(system, x, None)
}

/// Returns a section of Ω with at most [`SECTION`] elements across, of the same size.
fn section(question: &Question, system: &System) -> Result<System, SceneError> {
    let [nx, ny] = [system.grid().nx(), system.grid().ny()];
    let [width_x, width_y] = match question.sole {
        Sole::Rectangle { width_x, width_y } => [width_x, width_y],
        Sole::Disk { radius } => [2.0 * radius; 2],
    };
    let [mx, my] = [nx, ny].map(|n| n.min(SECTION));
    let sole = Sole::Rectangle {
        width_x: width_x * mx as f64 / nx as f64,
        width_y: width_y * my as f64 / ny as f64,
    };
    System::new(&Question { sole, mesh: Mesh::Exact([mx as u32, my as u32]), ..question.clone() })
}

/// Chooses the stripes to start from.
fn chosen(
    question: &Question,
    system: &System,
    search: &WitnessSearch,
) -> Result<Vec<Pattern>, SceneError> {
    let waves = waves(system);
    if system.elements() <= FEW {
        return Ok(waves.into_iter().map(|wave| stripes(system, wave)).collect());
    }
    let section = section(question, system)?;
    let needed = |wave: [f64; 3]| {
        from_pattern(&section, &stripes(&section, wave)).map_or(f64::INFINITY, |found| found.mu)
    };
    let mut ranked: Vec<(f64, [f64; 3])> =
        waves.into_par_iter().map(|wave| (needed(wave), wave)).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(ranked
        .into_iter()
        .take(search.kept.max(1) as usize)
        .map(|(_, wave)| stripes(system, wave))
        .collect())
}

/// Searches for a witness. The result is a valid witness but need not be the best one that there
/// is.
///
/// # Errors
/// An [`UpperError`] says that the question or the search has no meaning, or that no start led to a
/// witness.
pub fn upper(question: &Question, search: &WitnessSearch) -> Result<Upper, UpperError> {
    search.validate()?;
    let system = System::new(question)?;
    if !system.is_coupled() {
        return Ok(Upper::Unbounded);
    }
    let elements = system.elements();
    let patterns = chosen(question, &system, search)?;
    let random = if elements <= FEW { search.starts as usize * 36 / elements.max(36) } else { 0 };
    let starts = patterns.len() + random;
    let found = (0..starts).into_par_iter().filter_map(|start| match patterns.get(start) {
        Some(pattern) => from_pattern(&system, pattern),
        None => from_random(&system, search, start as u64),
    });
    let found: Vec<Found> = found.collect();
    let best = found.into_iter().min_by(|a, b| a.mu.total_cmp(&b.mu));
    let Found { mu, x } = best.ok_or(UpperError::NotFound { starts, elements })?;
    let largest = x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let x = x.into_iter().map(|x| x / largest).collect();
    // The factor leaves room for the rounding of that division and of other ways to apply the
    // operator.
    let mu = mu * (1.0 + 1e-12);
    Ok(Upper::Bound(Witness { mu, stiffness: STIFFNESS / system.largest_diagonal(), x }))
}

/// The stiffness E of a witness's operator, over the largest diagonal entry of A. It is large
/// enough for √(a² + b²) to come near μ.
pub(super) const STIFFNESS: f64 = 100.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Foundation, Material};

    #[test]
    fn both_directions_are_tried_unless_they_are_alike() {
        let of = |mesh: [u32; 2]| {
            let sole = Sole::Rectangle { width_x: f64::from(mesh[0]), width_y: f64::from(mesh[1]) };
            let foundation = Foundation::half_space(Material { shear_modulus: 1.0, poisson: 0.3 });
            let mesh = Mesh::Exact(mesh);
            let question = Question {
                foundation,
                punch: None,
                sole,
                mesh,
                projection: Default::default(),
                epsilon: 0.0,
                plane: false,
            };
            let system = System::new(&question).unwrap();
            waves(&system).len()
        };
        assert_eq!((of([9, 9]), of([13, 8]), of([8, 13])), (12, 18, 18));
    }
}
