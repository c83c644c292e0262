//! The lower side of μ*: weights that prove uniqueness, and the check of their proof by one
//! factorisation.
//!
//! # The certificate
//! The certificate consists of weights α ≥ 0, β > 0, τ > 0 per element, and the symmetric matrix
//!
//! ```text
//! F(μ) = S − μT,  S = sym(αΠ₁A) + sym(βΠ_tA),  T = ½(βτΠ₁ + AᵀΠ_t(β/τ)A).
//! ```
//!
//! If F(μ) is positive definite, then μ < μ*. For suppose μ ≥ μ*: then there is an x ≠ 0 with y =
//! Ax, x₁y₁ ≤ 0 and x_t·y_t ≤ μ|x₁||y_t| at every element ([`super`]), and as 2|x₁||y_t| ≤ τx₁² +
//! |y_t|²/τ,
//!
//! ```text
//! xᵀF(μ)x = Σ αx₁y₁ + β(x_t·y_t − ½μ(τx₁² + |y_t|²/τ)) ≤ Σ αx₁y₁ + β(x_t·y_t − μ|x₁||y_t|) ≤ 0.
//! ```
//!
//! As T is positive semidefinite, F(μ) ≻ 0 makes F ≻ 0 for every smaller μ too. Only ratios of α
//! and β matter, and τ is in units of cℓ. The best weights solve a convex problem (`barrier`), so
//! averaging over the symmetries of Ω loses nothing: the weights are constant on the orbits of
//! elements under them, in whose adapted basis F falls into blocks.
//!
//! Without normal–tangential coupling there is nothing to bound: μ* = ∞ exactly
//! ([`Lower::Unbounded`]).
//!
//! # Rounding
//! [`verify`] takes the coefficients of the table, as they are, for the operator, and shows F ≻ 0
//! in exact arithmetic. Let u = 2⁻⁵³ and γ = 4(m + 32)u for a block of size m (inner products of at
//! most m + 32 terms, with room to spare):
//! - The computed matrix differs from F by at most γB entrywise, B = |D||A| + |A||D| + P + |A|Q|A|
//!   with D = (α, β), P = μβτ, Q = μβ/τ, hence in the 2-norm by at most γ‖B‖∞.
//! - Cholesky's factor of a matrix C is the exact one of a C + E with |E| ≤ γ|L||Lᵀ|, hence ‖E‖₂ ≤
//!   γ‖L‖²_F ≤ 2γ tr C (Higham, Accuracy and Stability of Numerical Algorithms, theorem 10.3), and
//!   it exists only if C + E is positive definite.
//! - The table is symmetric under x → −x and y → −y to the last bit, and under x ↔ y to rounding.
//!   An entry of a block is a sum of up to eight coefficients of both signs, whose rounding goes by
//!   Σ|coefficients| and not by |entry|. Let d be the ∞-norm of the table's deviation from symmetry
//!   plus 16u times that of the matrix of Σ|coefficients|. Then the blocks are those of an operator
//!   A' at most d away, and their F is at most (max D + 2‖A‖∞ max Q) d away.
//! - Only ratios of α and β matter, and they are divided by the largest β: a number that underflows
//!   then is far below γ‖B‖∞. Where the coupling is weak, α is larger by many orders. So EFE stands
//!   for F, with E a power of two near 1/√(max α) on pressures and 1 on tangential tractions, which
//!   rounds nothing. EBE replaces B, and the share of the symmetry becomes max E (max ED + 2 max E
//!   ‖A‖∞ max Q) d.
//!
//! So F is positive definite if EFE − sI factorises, where s is the sum of the three. The outcome
//! is the same on any number of threads.

use faer::Mat;
use primitives::cholesky;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::barrier::{NormalPenalty, Program, Weights, form};
use super::ratio::{Parts, Smallest, smallest};
use super::symmetry::{Block, Symmetries, asymmetry};
use super::system::System;

/// The outcome of a search for a lower bound of μ*.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Lower {
    /// Pressures move nothing sideways, so μ* = ∞ exactly.
    Unbounded,
    /// μ* is above a number.
    Bound(LowerBound),
}

/// Weights for which F(μ) is positive definite, so that μ < μ*.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LowerBound {
    /// The friction coefficient μ.
    pub mu: f64,
    /// The weight α ≥ 0 of each orbit of elements, see [`orbits`].
    pub alpha: Vec<f64>,
    /// The weight β > 0 of each orbit.
    pub beta: Vec<f64>,
    /// The weight τ > 0 of each orbit, in units of cℓ.
    pub tau: Vec<f64>,
    /// True if a factorisation has shown it, as [`verify`] does. Otherwise it is no proof: μ is the
    /// result of an iteration, less its error estimate.
    pub verified: bool,
}

/// The freedom of the weights to vary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Freedom {
    /// All elements have one α and one τ, and β = 1.
    Global,
    /// Each orbit of elements under the symmetries of Ω has its own weights.
    #[default]
    PerOrbit,
}

/// The reason why there is no lower bound.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LowerError {
    /// The operator is not positive definite.
    #[error(
        "the operator εI + A of {elements} elements is not positive definite, so no weights can prove uniqueness: take the average \
         projection, or a larger epsilon"
    )]
    Indefinite {
        /// The number of elements of Ω.
        elements: usize,
    },
    /// The weights found prove nothing.
    #[error(
        "no weights were found that prove uniqueness on {elements} elements for any friction: take fewer elements"
    )]
    Weights {
        /// The number of elements of Ω.
        elements: usize,
    },
}

/// The reason why weights prove nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VerifyError {
    /// The number of weights is not the number of orbits.
    #[error(
        "{found} weights {name}, but the elements of Ω have {orbits} orbits under its symmetries: there must be one for each"
    )]
    Length {
        /// The name of the weights.
        name: &'static str,
        /// The number of weights.
        found: usize,
        /// The number of orbits.
        orbits: usize,
    },
    /// A weight is out of range.
    #[error("{name} of orbit {orbit} is {value:e}: it must be finite and {}", if *name == "alpha" { "at least 0" } else { "above 0" })]
    Weight {
        /// The name of the weight.
        name: &'static str,
        /// The number of the orbit.
        orbit: usize,
        /// The value of the weight.
        value: f64,
    },
    /// The matrix is too large to factor.
    #[error("too large to be checked here: there are {rows} rows to factor, at most {most} are")]
    TooLarge {
        /// The rows of the largest block.
        rows: usize,
        /// The most rows that are factored.
        most: usize,
    },
    /// The friction coefficient μ has no meaning.
    #[error("mu = {mu:e}: it must be finite and above 0")]
    Mu {
        /// The value of μ.
        mu: f64,
    },
    /// F(μ) is not positive definite, or not by more than rounding.
    #[error(
        "F(μ) for mu = {mu:e} minus its rounding margin has no Cholesky factor: the weights do not prove uniqueness"
    )]
    Indefinite {
        /// The friction coefficient μ.
        mu: f64,
    },
}

/// Returns the orbits of the elements of Ω under its symmetries: the number of its orbit for each
/// element, ascending. Orbits are numbered in the order of their first elements.
pub fn orbits(system: &System) -> Vec<usize> {
    Symmetries::of(system, |_, _| true).orbits(system)
}

/// The most rows of a block that is factored, which takes some 100 MB for each of a few matrices.
pub const FACTORED_ROWS: usize = 3600;

/// Shows in one factorisation (one for each block of symmetry) that F(μ) is positive definite,
/// rounding included. Blocks may have at most `most` rows, which take a few times 8·rows² bytes
/// each. A search for a bracket uses [`FACTORED_ROWS`].
///
/// # Errors
/// A [`VerifyError`] says that the weights or μ have no meaning, that a block is too large, or that
/// the weights prove nothing.
pub fn verify(system: &System, bound: &LowerBound, most: usize) -> Result<(), VerifyError> {
    let symmetries = Symmetries::of(system, |_, _| true);
    let orbits = symmetries.orbits(system).iter().max().map_or(0, |last| last + 1);
    check_weights(bound, orbits)?;
    if !(bound.mu.is_finite() && bound.mu > 0.0) {
        return Err(VerifyError::Mu { mu: bound.mu });
    }
    let rows = symmetries.rows(system);
    if rows > most {
        return Err(VerifyError::TooLarge { rows, most });
    }
    let blocks = symmetries.blocks(system);
    if is_positive(&blocks, asymmetry_norm(system, symmetries), bound) {
        Ok(())
    } else {
        Err(VerifyError::Indefinite { mu: bound.mu })
    }
}

/// Checks that there are weights for each orbit, and that they are in their range.
pub(super) fn check_weights(bound: &LowerBound, orbits: usize) -> Result<(), VerifyError> {
    for (name, weights) in [("alpha", &bound.alpha), ("beta", &bound.beta), ("tau", &bound.tau)] {
        if weights.len() != orbits {
            return Err(VerifyError::Length { name, found: weights.len(), orbits });
        }
        let wrong =
            |value: f64| !value.is_finite() || value < 0.0 || (value == 0.0 && name != "alpha");
        if let Some((orbit, &value)) = weights.iter().enumerate().find(|(_, value)| wrong(**value))
        {
            return Err(VerifyError::Weight { name, orbit, value });
        }
    }
    Ok(())
}

/// Computes the best lower bound that weights of this freedom give, by dense algebra. It takes the
/// memory and time of a few matrices and their factors of 3k/4 to 3k rows, depending on the
/// symmetry of Ω.
///
/// # Errors
/// A [`LowerError`] says that the operator is not positive definite, or that the weights found
/// prove nothing.
pub fn lower(system: &System, freedom: Freedom) -> Result<Lower, LowerError> {
    if !system.is_coupled() {
        return Ok(Lower::Unbounded);
    }
    let symmetries = Symmetries::of(system, |_, _| true);
    let orbit = symmetries.orbits(system);
    let mut sizes = vec![0; orbit.iter().max().map_or(0, |last| last + 1)];
    orbit.iter().for_each(|&o| sizes[o] += 1);
    let mut blocks = symmetries.blocks(system);
    let indefinite = LowerError::Indefinite { elements: system.elements() };
    let start = uniform_start(&blocks, sizes.len(), system.largest_diagonal()).ok_or(indefinite)?;
    let weights = match freedom {
        Freedom::PerOrbit => {
            Program { blocks: &blocks, sizes: &sizes, penalty: None }.maximise(start, TOLERANCE)
        }
        Freedom::Global => {
            let orbits: Vec<Vec<usize>> = blocks
                .iter_mut()
                .map(|block| {
                    let zeros = vec![0; block.len()];
                    std::mem::replace(&mut block.orbit, zeros)
                })
                .collect();
            let one =
                [start.alpha[0], start.beta[0], start.p[0], start.q[0]].map(|value| vec![value]);
            let [alpha, beta, p, q] = one;
            let found = Program { blocks: &blocks, sizes: &[system.elements()], penalty: None }
                .maximise(Weights { alpha, beta, p, q }, TOLERANCE);
            blocks.iter_mut().zip(orbits).for_each(|(block, orbit)| block.orbit = orbit);
            found
                .map(|w| Weights::uniform(sizes.len(), w.mu(0), w.alpha[0] / w.beta[0], w.tau()[0]))
        }
    };
    let useless = LowerError::Weights { elements: system.elements() };
    let weights = weights.ok_or_else(|| useless.clone())?;
    let mut bound = LowerBound {
        mu: 0.0,
        tau: weights.tau(),
        alpha: weights.alpha,
        beta: weights.beta,
        verified: true,
    };
    bound.mu = largest_mu(&blocks, asymmetry_norm(system, symmetries), &bound).ok_or(useless)?;
    Ok(Lower::Bound(bound))
}

/// Computes a lower bound for a mesh that is too fine for [`lower`]. The weights `bound` of a
/// coarser mesh of the same Ω, found there orbit by orbit, are carried over by the number of
/// elements to the edges. One factor for all α and one for all τ are fitted by iteration with the
/// FFT operator (`ratio`).
///
/// The bound is factorised if the blocks have at most `rows` rows (8·rows² bytes for each of a few
/// matrices). Otherwise μ is the one of the iteration, less [`UNVERIFIED`] and ten times its
/// residual, and is not verified, for the iteration can have missed a lower mode. If the weights
/// carried over prove nothing, uniform ones are tried.
///
/// # Errors
/// A [`LowerError`] says that the operator is not positive definite, or that the weights found
/// prove nothing.
pub fn lower_from(
    system: &System,
    coarse: &System,
    bound: &LowerBound,
    rows: usize,
) -> Result<Lower, LowerError> {
    if !system.is_coupled() {
        return Ok(Lower::Unbounded);
    }
    let symmetries = Symmetries::of(system, |_, _| true);
    let orbit = symmetries.orbits(system);
    let per_element = |weights: &LowerBound| {
        let of = |value: &dyn Fn(usize) -> f64| orbit.iter().map(|&o| value(o)).collect();
        Parts {
            alpha: of(&|o| weights.alpha[o]),
            beta: of(&|o| weights.beta[o]),
            p: of(&|o| weights.beta[o] * weights.tau[o]),
            q: of(&|o| weights.beta[o] / weights.tau[o]),
        }
    };
    // This is a vector with a share of every mode, always the same one. The vector found for other
    // weights is a good start, but it can lie in one class of symmetry altogether, and the lowest
    // mode in another.
    let generic: Vec<f64> = (0..3 * system.elements())
        .map(|i| ((i + 1) as f64 * 0.618_033_988_749_895).fract() - 0.5)
        .collect();
    let mut mode = generic.clone();
    let mut ratio = |weights: &LowerBound, tolerance: f64| {
        let size = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let share = 0.5 * size(&mode) / size(&generic);
        mode.iter_mut().zip(&generic).for_each(|(x, generic)| *x += share * generic);
        smallest(system, &per_element(weights), &mut mode, tolerance, 2000)
            .unwrap_or(Smallest { ratio: 0.0, residual: 1.0 })
    };
    let mut fitted = |weights| {
        let weights = fit(weights, |weights| ratio(weights, SEARCH_TOLERANCE));
        let found = ratio(&weights, ITERATION_TOLERANCE);
        (weights, found)
    };
    let carried = carry(system, &orbit, coarse, bound);
    let uniform = LowerBound {
        alpha: vec![1.0; carried.beta.len()],
        beta: vec![1.0; carried.beta.len()],
        ..mean_tau(&carried)
    };
    let most = rows;
    let rows = symmetries.rows(system);
    let matrices =
        (rows <= most).then(|| (symmetries.blocks(system), asymmetry_norm(system, symmetries)));
    // Weights that vary can make S indefinite. With α = β it is a multiple of the operator.
    for (last, weights) in [(false, carried), (true, uniform)] {
        let (weights, found) = fitted(weights);
        if found.ratio <= 0.0 {
            if last {
                return Err(LowerError::Indefinite { elements: system.elements() });
            }
            continue;
        }
        let shown = match &matrices {
            None => {
                let mu = found.ratio * (1.0 - UNVERIFIED - 10.0 * found.residual);
                (mu > 0.0).then_some(LowerBound { mu, verified: false, ..weights })
            }
            Some((blocks, asymmetry)) => (0..22)
                .map(|doublings| found.ratio * (1.0 - 1e-7 * 2_f64.powi(doublings)))
                .map(|mu| LowerBound { mu, verified: true, ..weights.clone() })
                .find(|bound| is_positive(blocks, *asymmetry, bound)),
        };
        if let Some(bound) = shown {
            return Ok(Lower::Bound(bound));
        }
    }
    Err(LowerError::Weights { elements: system.elements() })
}

/// Replaces τ of all orbits by their mean.
fn mean_tau(weights: &LowerBound) -> LowerBound {
    let mean = weights.tau.iter().sum::<f64>() / weights.tau.len() as f64;
    LowerBound { tau: vec![mean; weights.tau.len()], ..weights.clone() }
}

/// Finds the factors of α and of τ with the largest ratio, and returns the weights with them.
fn fit(weights: LowerBound, mut ratio: impl FnMut(&LowerBound) -> Smallest) -> LowerBound {
    let scaled = |weights: &LowerBound, [alpha, tau]: [f64; 2]| LowerBound {
        alpha: weights.alpha.iter().map(|a| a * alpha).collect(),
        tau: weights.tau.iter().map(|t| t * tau).collect(),
        ..weights.clone()
    };
    // The weights that prove a given μ are a convex set in α, p and q. So the ratio has one top
    // along log τ, and the tops have one along log α.
    let (mut best, mut largest) = (weights.clone(), ratio(&weights).ratio);
    let start = weights;
    golden(|alpha| {
        golden(|tau| {
            let trial = scaled(&start, [alpha.exp(), tau.exp()]);
            let value = ratio(&trial).ratio;
            if value > largest {
                (best, largest) = (trial, value);
            }
            value
        })
    });
    best
}

/// Returns the largest value of a function with one top between −ln 4 and ln 4, found by golden
/// sections to about 2 %.
fn golden(mut value: impl FnMut(f64) -> f64) -> f64 {
    const SECTION: f64 = 0.618_033_988_749_895;
    let (mut low, mut high) = (-(4_f64.ln()), 4_f64.ln());
    let mut inner = [high - SECTION * (high - low), low + SECTION * (high - low)];
    let mut values = inner.map(&mut value);
    for _ in 0..9 {
        if values[0] >= values[1] {
            high = inner[1];
            (inner[1], values[1]) = (inner[0], values[0]);
            inner[0] = high - SECTION * (high - low);
            values[0] = value(inner[0]);
        } else {
            low = inner[0];
            (inner[0], values[0]) = (inner[1], values[1]);
            inner[1] = low + SECTION * (high - low);
            values[1] = value(inner[1]);
        }
    }
    values[0].max(values[1])
}

/// Carries the weights of a coarser mesh of the same Ω over to the orbits of another. They are the
/// weights at as many elements from the edges, in the middle those of the middle, with τ in
/// proportion to the operators' diagonals. Near the edges weights vary by the element: carried over
/// by position instead they serve worse than constant ones (8 × 8 to 16 × 16 elements, ν = 0.3:
/// 1.278 by position, 1.312 constant, 1.341 by elements).
fn carry(system: &System, orbit: &[usize], coarse: &System, bound: &LowerBound) -> LowerBound {
    let (grid, from) = (system.grid(), coarse.grid());
    let of = orbits(coarse);
    let mut number = vec![None; from.len()];
    from.active().zip(&of).for_each(|(e, &o)| number[e] = Some(o));
    let count = orbit.iter().max().map_or(0, |last| last + 1);
    let mut carried = LowerBound {
        mu: 0.0,
        alpha: vec![0.0; count],
        beta: vec![0.0; count],
        tau: vec![0.0; count],
        verified: false,
    };
    let scale = system.largest_diagonal() / coarse.largest_diagonal();
    for (place, e) in grid.active().enumerate() {
        let orbit = orbit[place];
        if carried.beta[orbit] != 0.0 {
            continue;
        }
        // The place among the coarse elements is counted in elements.
        let along = |i: usize, n: usize, m: usize| {
            let (last, middle) = ((m - 1) as f64, 0.5 * (m - 1) as f64);
            let from_middle = (last - (n - 1 - i) as f64).max(middle);
            if 2 * i < n { (i as f64).min(middle) } else { from_middle }
        };
        let (i, j) = grid.position(e);
        let (x, y) = (along(i, grid.nx(), from.nx()), along(j, grid.ny(), from.ny()));
        let (mut sums, mut total) = ([0.0; 3], 0.0);
        for f in from.active() {
            let (k, l) = from.position(f);
            let share =
                (1.0 - (x - k as f64).abs()).max(0.0) * (1.0 - (y - l as f64).abs()).max(0.0);
            if let (true, Some(o)) = (share > 0.0, number[f]) {
                total += share;
                for (sum, values) in sums.iter_mut().zip([&bound.alpha, &bound.beta, &bound.tau]) {
                    *sum += share * values[o];
                }
            }
        }
        // At the edge of a mask there may be no coarse element beside it.
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let [alpha, beta, tau] = if total > 0.0 {
            sums.map(|sum| sum / total)
        } else {
            [&bound.alpha, &bound.beta, &bound.tau].map(|values| mean(values))
        };
        (carried.alpha[orbit], carried.beta[orbit], carried.tau[orbit]) =
            (alpha, beta, scale * tau);
    }
    carried
}

/// The relative residual at which the iteration stops.
const ITERATION_TOLERANCE: f64 = 1e-5;

/// The relative residual while weights are compared. The error of the ratio is of the order of its
/// square.
const SEARCH_TOLERANCE: f64 = 1e-3;

/// The relative margin of a μ that no factorisation has checked.
pub const UNVERIFIED: f64 = 1e-3;

/// Finds weights to start from, the same for all orbits and well inside the feasible set. It
/// doubles and halves α and τ until F(μ) stays positive definite up to the largest μ. It is `None`
/// if no μ > 0 does.
fn uniform_start(blocks: &[Block], orbits: usize, diagonal: f64) -> Option<Weights> {
    let of = |[alpha, tau]: [i32; 2], mu: f64| {
        Weights::uniform(orbits, mu, 2_f64.powi(alpha), diagonal * 2_f64.powi(tau))
    };
    let proves = |place: [i32; 2], mu: f64| {
        blocks.iter().all(|block| cholesky(form(block, &of(place, mu), None)).is_some())
    };
    // With α = β, S is a multiple of A.
    let mut place = [0, 3];
    let mut mu = (0..60).map(|halvings| 0.5_f64.powi(halvings)).find(|&mu| proves(place, mu))?;
    // A step counts if it allows a μ larger by a tenth.
    let climb = |place: [i32; 2], mut mu: f64| {
        let from = mu;
        while mu < MOST_MU && proves(place, 1.1 * mu) {
            mu *= 1.1;
        }
        (mu > from).then_some(mu)
    };
    mu = climb(place, mu).unwrap_or(mu);
    let mut moved = true;
    while moved {
        moved = false;
        for step in [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1], [1, -1], [-1, 1]] {
            let next = [place[0] + step[0], place[1] + step[1]];
            if let Some(better) = climb(next, mu) {
                (place, mu, moved) = (next, better, true);
            }
        }
    }
    Some(of(place, 0.7 * mu))
}

/// The relative accuracy to which weights are optimised.
const TOLERANCE: f64 = 1e-5;

/// Returns the ∞-norm of A's deviation from symmetry under x ↔ y, or zero where that symmetry is
/// not used.
pub(super) fn asymmetry_norm(system: &System, symmetries: Symmetries) -> f64 {
    if symmetries.swap { asymmetry(system) * system.largest_diagonal() } else { 0.0 }
}

/// The largest μ that is searched for.
const MOST_MU: f64 = 1e12;

/// Finds the largest μ, to 10⁻⁹, that the weights prove, by bisection of factorisations. It is
/// `None` if they prove none. Weights and μ written with 15 digits still prove it.
fn largest_mu(blocks: &[Block], asymmetry: f64, weights: &LowerBound) -> Option<f64> {
    let proves = |mu: f64| is_positive(blocks, asymmetry, &LowerBound { mu, ..weights.clone() });
    let mut low = (0..200).map(|halvings| 0.5_f64.powi(halvings - 20)).find(|&mu| proves(mu))?;
    let mut high = 2.0 * low;
    // The weaker the coupling, the larger μ is. Above the value where the search has begun nothing
    // is known yet.
    while high < MOST_MU && proves(high) {
        (low, high) = (high, 2.0 * high);
    }
    while high - low > 1e-10 * low {
        let mu = 0.5 * (low + high);
        if proves(mu) { low = mu } else { high = mu }
    }
    Some(low * (1.0 - 1e-9))
}

/// Says if F(μ) minus the rounding margin factorises in every block.
fn is_positive(blocks: &[Block], asymmetry: f64, bound: &LowerBound) -> bool {
    is_positive_in_case(blocks, asymmetry, bound, None)
}

/// Says if F(μ) with the squares of a case, minus the rounding margin, factorises in every block.
pub(super) fn is_positive_in_case(
    blocks: &[Block],
    asymmetry: f64,
    bound: &LowerBound,
    penalty: Option<&NormalPenalty>,
) -> bool {
    let largest = bound.beta.iter().copied().fold(0.0, f64::max);
    let [alpha, beta] = [&bound.alpha, &bound.beta]
        .map(|weights| weights.iter().map(|weight| weight / largest).collect::<Vec<f64>>());
    let product = |a: &f64, b: f64| bound.mu * a * b;
    let weights = Weights {
        p: beta.iter().zip(&bound.tau).map(|(beta, &tau)| product(beta, tau)).collect(),
        q: beta.iter().zip(&bound.tau).map(|(beta, &tau)| product(beta, tau.recip())).collect(),
        alpha,
        beta,
    };
    let penalty = penalty.map(|NormalPenalty { displacement, pressure }| {
        let [displacement, pressure] = [displacement, pressure]
            .map(|weights| weights.iter().map(|weight| weight / largest).collect());
        NormalPenalty { displacement, pressure }
    });
    let pressures = root(weights.alpha.iter().copied().fold(0.0, f64::max));
    blocks.par_iter().all(|block| {
        let mut form = form(block, &weights, penalty.as_ref());
        let scale: Vec<f64> =
            block.normal.iter().map(|&normal| if normal { pressures } else { 1.0 }).collect();
        (0..block.len())
            .for_each(|j| (0..block.len()).for_each(|i| form[(i, j)] *= scale[i] * scale[j]));
        let margin = margin(block, &weights, penalty.as_ref(), &scale, asymmetry, &form);
        (0..block.len()).for_each(|i| form[(i, i)] -= margin);
        cholesky(form).is_some()
    })
}

/// Returns a power of two near 1/√α.
fn root(alpha: f64) -> f64 {
    let exponent = ((alpha.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    if alpha > 0.0 { 2_f64.powi(-exponent.div_euclid(2)) } else { 1.0 }
}

/// Computes the margin s of the module's text, for the scaled `form`.
fn margin(
    block: &Block,
    weights: &Weights,
    penalty: Option<&NormalPenalty>,
    scale: &[f64],
    asymmetry: f64,
    form: &Mat<f64>,
) -> f64 {
    let size = block.len();
    let gamma = 4.0 * (size as f64 + 32.0) * 0.5 * f64::EPSILON;
    let matrix = &block.matrix;
    let times = |x: &[f64]| -> Vec<f64> {
        let mut y = vec![0.0; size];
        for (j, x) in x.iter().enumerate() {
            y.iter_mut().enumerate().for_each(|(i, y)| *y += matrix[(i, j)].abs() * x);
        }
        y
    };
    let product =
        |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
    let of = |normal: &[f64], tangential: &[f64], i: usize| {
        if block.normal[i] { normal[block.orbit[i]] } else { tangential[block.orbit[i]] }
    };
    let none = vec![0.0; weights.p.len()];
    // The squares of a case are no halves.
    let of_case = |weights: &Vec<f64>| weights.iter().map(|weight| 2.0 * weight).collect();
    let displacement: Vec<f64> = penalty.map_or(none.clone(), |p| of_case(&p.displacement));
    let pressure: Vec<f64> = penalty.map_or(none.clone(), |p| of_case(&p.pressure));
    let pressure: Vec<f64> = weights.p.iter().zip(&pressure).map(|(p, more)| p + more).collect();
    let linear: Vec<f64> = (0..size).map(|i| of(&weights.alpha, &weights.beta, i)).collect();
    let square: Vec<f64> = (0..size).map(|i| of(&displacement, &weights.q, i)).collect();
    let sums = times(scale);
    let weighted = times(&product(&linear, scale));
    let twice = times(&product(&square, &sums));
    let rows = (0..size).map(|i| {
        scale[i]
            * (linear[i] * sums[i] + weighted[i] + of(&pressure, &none, i) * scale[i] + twice[i])
    });
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let rows: Vec<f64> = rows.collect();
    let trace = (0..size).map(|i| form[(i, i)].abs()).sum::<f64>();
    let norm = largest(&times(&vec![1.0; size]));
    let top = largest(scale);
    let moved = top
        * (largest(&product(&linear, scale)) + 2.0 * top * norm * largest(&square))
        * (asymmetry + block.rounding);
    gamma * largest(&rows) + 2.0 * gamma * trace + moved
}
