//! The upper side of μ*: a search for an x with small F(x).
//!
//! The problem is not convex and has many local minima, the more the finer the mesh. Minimisations start from random fields, with and
//! without the symmetries of Ω, and from the best fields of a mesh half as fine. Every start has its own random numbers,
//! so the result depends on the seed and the effort alone, not on the number of threads.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::descent::{Descent, Limits, dot};
use super::witness::{Witness, least_mu};
use super::{Question, System};
use crate::influence::Entry;
use crate::numerics::Mesh;
use crate::random::SplitMix64;
use crate::scene::SceneError;

/// How long to search for a witness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Search {
    /// Random starts on meshes of up to 16 elements, at least one; on finer ones, which also start from coarser ones' results, fewer
    /// in inverse proportion to the elements, and none on more than 100.
    pub starts: u32,
    /// How many of a mesh's best fields the next finer one starts from, at least one; on more than 100 elements at most two.
    pub kept: u32,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Default for Search {
    fn default() -> Self {
        Self { starts: 24, kept: 4, seed: 1 }
    }
}

/// The upper side of μ*.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Upper {
    /// μ* = ∞, exactly: pressures move nothing sideways, and no x ≠ 0 is admissible.
    Unbounded,
    /// μ* is at most a witness's μ.
    Bound(Witness),
}

/// Why there is no upper bound.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UpperError {
    /// The question has no meaning.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// No start led to a field that meets the conditions.
    #[error("no witness found from {starts} starts with {elements} elements: try more starts or another seed")]
    NotFound {
        /// Starts on the question's own mesh.
        starts: usize,
        /// Elements of Ω.
        elements: usize,
    },
}

/// The `stream`-th generator of a seed.
fn generator(seed: u64, stream: u64) -> SplitMix64 {
    SplitMix64(SplitMix64(seed).next() ^ SplitMix64(stream).next().rotate_left(17))
}

/// A random field: white, or smoothed by the operator; of no symmetry, or with a sign under reflections.
fn start(system: &System, random: &mut SplitMix64) -> Vec<f64> {
    let k = system.elements();
    let kind = random.next();
    let mut x: Vec<f64> = (0..3 * k).map(|_| random.signed()).collect();
    for _ in 0..kind % 3 {
        let mut y = vec![0.0; 3 * k];
        system.apply(&mut y, &x, &mut system.scratch());
        x = y;
    }
    let sign = |bit: u64| if (kind >> bit) & 1 == 0 { 1.0 } else { -1.0 };
    for (axis, which) in [(0, 8), (1, 16)] {
        if (kind >> which) & 1 == 1 {
            x = reflected(system, &x, axis, sign(which + 1));
        }
    }
    x
}

/// The part of a field that changes by `sign` under the reflection of x (axis 0) or y (axis 1).
fn reflected(system: &System, x: &[f64], axis: usize, sign: f64) -> Vec<f64> {
    let (grid, k) = (system.grid(), system.elements());
    let mut number = vec![None; grid.len()];
    for (at, e) in grid.active().enumerate() {
        number[e] = Some(at);
    }
    let mut out = x.to_vec();
    for (at, e) in grid.active().enumerate() {
        let (i, j) = grid.position(e);
        let image = if axis == 0 { grid.index(grid.nx() - 1 - i, j) } else { grid.index(i, grid.ny() - 1 - j) };
        if let Some(image) = number[image] {
            for c in 0..3 {
                let sign = if c == axis + 1 { -sign } else { sign };
                out[c * k + at] += sign * x[c * k + image];
            }
        }
    }
    out
}

/// A field of a mesh as one of another: each element takes the value of the one that its centre lies in.
fn prolonged(coarse: &System, x: &[f64], fine: &System) -> Vec<f64> {
    let mut full = vec![0.0; 3 * coarse.grid().len()];
    let k = coarse.elements();
    for block in 0..3 {
        for (at, e) in coarse.grid().active().enumerate() {
            full[block * coarse.grid().len() + e] = x[block * k + at];
        }
    }
    let all = coarse.grid().sample(&full, fine.grid());
    (0..3).flat_map(|block| fine.grid().active().map(move |e| (block, e))).map(|(block, e)| all[block * fine.grid().len() + e]).collect()
}

/// A field of a smaller mesh on some of the elements of a larger one, from element `corner` on, and zero on the others. Between
/// half-spaces it needs the same μ there: what is zero meets every condition.
fn embedded(coarse: &System, x: &[f64], fine: &System, corner: [usize; 2]) -> Vec<f64> {
    let (from, to, k) = (coarse.grid(), fine.grid(), fine.elements());
    let mut number = vec![None; to.len()];
    for (at, e) in to.active().enumerate() {
        number[e] = Some(at);
    }
    let mut out = vec![0.0; 3 * k];
    for (at, e) in from.active().enumerate() {
        let (i, j) = from.position(e);
        if let Some(place) = number[to.index(i + corner[0], j + corner[1])] {
            for c in 0..3 {
                out[c * k + place] = x[c * coarse.elements() + at];
            }
        }
    }
    out
}

/// A field and the μ that it needs.
#[derive(Clone)]
struct Found {
    mu: f64,
    x: Vec<f64>,
}

/// μ κ to start from.
const FIRST_MU: f64 = 5.0;

/// Up to so many elements random starts are worth their time.
const FEW: usize = 100;

/// How strictly a witness meets its conditions, in units of those of a typical element: far above the rounding of an application.
const MARGIN: f64 = 1e-9;

/// Minimises from a start and makes the result strict. A `firm` minimisation stays near the start.
fn improve(system: &System, mut x: Vec<f64>, guess: f64, firm: bool) -> Option<Found> {
    let mut limits = match system.elements() {
        k if k <= FEW => Limits { outer: 60, inner: 20, ..Limits::default() },
        k if k <= 300 => Limits { outer: 40, inner: 10, ..Limits::default() },
        _ => Limits { outer: 20, inner: 5, first_penalty: 300.0, ..Limits::default() },
    };
    if firm {
        limits.first_penalty *= 100.0;
    }
    let mut descent = Descent::new(system, coupling(system), MARGIN);
    let mu = descent.minimise(&mut x, guess, limits);
    descent.restore(&mut x, mu)?;
    needed(system, x)
}

/// The better one of a field and what a firm minimisation from it finds.
fn polished(system: &System, found: Found) -> Found {
    match improve(system, found.x.clone(), found.mu, true) {
        Some(polished) if polished.mu < found.mu => polished,
        _ => found,
    }
}

/// A field with the μ that it needs, if it is a witness for any.
fn needed(system: &System, x: Vec<f64>) -> Option<Found> {
    let mut y = vec![0.0; x.len()];
    system.apply(&mut y, &x, &mut system.scratch());
    let mu = least_mu(&x, &y).ok()?;
    (mu > 0.0 && mu.is_finite()).then_some(Found { mu, x })
}

/// How weak the coupling is: κ = 1 about where the bodies are compressible and only one of them deforms, 0 without coupling.
fn coupling(system: &System) -> f64 {
    let table = system.table();
    let ny = system.grid().ny() as i64;
    let rows = [Entry::Nx, Entry::Ny].into_iter().flat_map(|entry| (1 - ny..ny).map(move |dj| table.row(entry, dj)));
    let most = rows.flatten().fold(0.0, |most: f64, c| most.max(c.abs()));
    (10.0 * most / system.largest_diagonal()).min(1.0)
}

/// The best fields of a mesh, from random starts and from seeds with the μ that they need elsewhere.
fn best(system: &System, seeds: &[Found], search: &Search) -> Vec<Found> {
    let fresh = match system.elements() {
        k if k <= FEW => (search.starts.max(1) as usize * 16 / k.max(16)).max(1),
        _ => usize::from(seeds.is_empty()),
    };
    let coupling = coupling(system);
    let mut found: Vec<Found> = (0..fresh + seeds.len())
        .into_par_iter()
        .filter_map(|stream| {
            let mut random = generator(search.seed, stream as u64);
            let Some(seed) = stream.checked_sub(fresh).map(|at| &seeds[at]) else {
                let mut x = start(system, &mut random);
                x[..system.elements()].iter_mut().for_each(|x| *x *= coupling);
                return improve(system, x, FIRST_MU / coupling, false);
            };
            let as_it_is = needed(system, seed.x.clone());
            if as_it_is.is_some() && system.elements() > FEW {
                return as_it_is; // set into a part of Ω, from where the way to a better one is long
            }
            // Exact zeros and exact symmetry are saddle points as often as not.
            let size = 0.05 * (dot(&seed.x, &seed.x) / seed.x.len() as f64).sqrt();
            let shaken = seed.x.iter().map(|x| x + size * random.signed()).collect();
            improve(system, shaken, seed.mu, false).into_iter().chain(as_it_is).min_by(|a, b| a.mu.total_cmp(&b.mu))
        })
        .collect();
    found.sort_by(|a, b| a.mu.total_cmp(&b.mu));
    found.truncate(if system.elements() <= FEW { 2 * search.kept.max(1) as usize } else { 1 });
    found = found.into_par_iter().map(|found| polished(system, found)).collect();
    found.sort_by(|a, b| a.mu.total_cmp(&b.mu));
    // Images of one field under the symmetries of Ω need the same μ; one of them is enough.
    found.dedup_by(|a, b| a.mu - b.mu < 1e-5 * b.mu);
    found
}

/// The best fields of a mesh and all coarser ones that lead to it.
fn ladder(question: &Question, system: &System, search: &Search) -> Result<Vec<Found>, UpperError> {
    let (nx, ny) = (system.grid().nx(), system.grid().ny());
    let mut seeds = Vec::new();
    if system.elements() > 9 {
        let small = [nx.div_ceil(2), ny.div_ceil(2)];
        let coarse_question = Question { mesh: Mesh::Exact(small.map(|n| n as u32)), ..question.clone() };
        let coarse = System::new(&coarse_question)?;
        let kept = if system.elements() <= FEW { search.kept.max(1) } else { search.kept.clamp(1, 2) } as usize;
        for found in ladder(&coarse_question, &coarse, search)?.into_iter().take(kept) {
            let middle = [(nx - small[0]) / 2, (ny - small[1]) / 2];
            let fields = [
                prolonged(&coarse, &found.x, system),
                embedded(&coarse, &found.x, system, [0, 0]),
                embedded(&coarse, &found.x, system, middle),
            ];
            seeds.extend(fields.into_iter().map(|x| Found { x, ..found }));
        }
    }
    Ok(if system.is_coupled() { best(system, &seeds, search) } else { Vec::new() })
}

/// Searches for a witness: on coarse meshes first, whose fields, spread over Ω or set into a corner or the middle of it, are where finer
/// ones start. The result is a valid witness but need not be the best one that there is.
pub fn upper(question: &Question, search: &Search) -> Result<Upper, UpperError> {
    let system = System::new(question)?;
    if !system.is_coupled() {
        return Ok(Upper::Unbounded);
    }
    let found = ladder(question, &system, search)?.into_iter().next();
    let elements = system.elements();
    let Found { mu, x } = found.ok_or(UpperError::NotFound { starts: search.starts as usize, elements })?;
    let largest = x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let x = x.into_iter().map(|x| x / largest).collect();
    // room for the rounding of that division and of other ways to apply the operator
    let mu = mu * (1.0 + 1e-12);
    Ok(Upper::Bound(Witness { mu, stiffness: STIFFNESS / system.largest_diagonal(), x }))
}

/// E of a witness's operator, over the largest diagonal entry of A: large enough for √(a² + b²) to come near μ.
const STIFFNESS: f64 = 100.0;
