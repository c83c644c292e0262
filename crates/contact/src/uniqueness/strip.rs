//! Exact μ* of a strip: one row of elements along x, with tractions in the plane of x and z that
//! are uniform along y.
//!
//! There are two tractions for each element here, the pressure s and the traction t along x, and
//! two displacements u and v with (u, v) = A(s, t). The mirror plane along the strip keeps
//! everything in the plane of x and z, so this is the operator of [`System`] on a space that it
//! maps into itself. Elements that are long along y are those of plane strain, but for a
//! displacement that is the same everywhere and grows with the logarithm of their length.
//!
//! # Cases of signs
//! It follows from [`super`] that μ ≥ μ* if and only if some (s, t) ≠ 0 has su ≤ 0 and tv ≤ μ|s||v|
//! at every element. The first says that (1 − c)s + cu = 0 for some 0 ≤ c ≤ 1. The second says that
//! v = 0, or that t − as is 0 or has the other sign than v for some |a| ≤ μ, which is the same as
//! (1 − d)(t − as) + dv = 0 for some 0 ≤ d ≤ 1. These are two rows for each element,
//! R(c, a, d)(s, t) = 0, and
//!
//! ```text
//! μ < μ*  if and only if  det R(c, a, d) ≠ 0 for all 0 ≤ c, d ≤ 1 and |a| ≤ μ at each element.
//! ```
//!
//! Each of these numbers stands in one row, linearly, so the determinant is affine in each of them
//! alone. It is 1 where all are 0. So it vanishes nowhere if and only if it is positive wherever
//! each number is at an end of its range: an affine function is smallest at an end. That leaves
//! five cases for each element ([`ElementCase`]) and 5ⁿ determinants, whose signs decide whether
//! μ < μ*. Without friction all are principal minors of A, which are positive if A is positive
//! definite.
//!
//! This argument for c holds in three dimensions as well: nothing is lost there by asking that
//! every element has x₁ = 0 or y₁ = 0.
//!
//! # Elimination
//! The elements are eliminated one by one. A determinant for the first few, the others open, is
//! itself one of the 5ⁿ. So μ < μ* if and only if every pivot of every elimination is positive, and
//! eliminations that begin alike share their beginning: the last of n elements takes a few
//! operations for each of 5ⁿ⁻¹ cases of the others. Pivots are computed as balls (`ball.rs`), and a
//! pivot that may be 0 is computed once more, with all that comes before and after it, in twice the
//! precision. The table is symmetric under x → −x to the last bit, so of two cases that are mirror
//! images of each other one is looked at.
//!
//! [`verify`] looks at all cases anew. It takes the coefficients of the table, as they are, for the
//! operator, and shows the sign of every determinant in exact arithmetic.
//!
//! # Both sides
//! The smallest μ at which the determinant of some case vanishes is μ*. A local search over cases
//! finds a small one for a strip of two elements, then three and so on; where the proof of a lower
//! bound fails it has found a case with a smaller one. The witness is the field that the case's R
//! maps to 0, with numbers c and d a little within their ranges, so that it keeps its inequalities
//! strictly.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::ball::{Ball, Narrow, Sign, Wide};
use super::question::{MOST_STRIP_ELEMENTS, is_strip};
use super::system::System;
use super::upper::{STIFFNESS, needed};
use super::witness::Witness;

/// The case of an element of a strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ElementCase {
    /// The element bears nothing: s = t = 0.
    Open,
    /// The element bears no pressure, and is held sideways: s = 0 and v = 0.
    Held,
    /// The element is closed and sticks: u = v = 0.
    Stick,
    /// The element is closed, and its traction is that of slip: u = 0 and t = μs.
    SlipForward,
    /// The element is closed, and its traction is that of slip the other way: u = 0 and t = −μs.
    SlipBackward,
}

impl ElementCase {
    /// Every case.
    pub const ALL: [Self; 5] =
        [Self::Open, Self::Held, Self::Stick, Self::SlipForward, Self::SlipBackward];

    /// Returns the case of the element's mirror image.
    fn mirrored(self) -> Self {
        match self {
            Self::SlipForward => Self::SlipBackward,
            Self::SlipBackward => Self::SlipForward,
            Self::Open | Self::Held | Self::Stick => self,
        }
    }
}

/// The lower end of a strip's μ*: every determinant is positive for this μ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StripBound {
    /// The friction coefficient μ.
    pub mu: f64,
    /// The case of each element along x whose determinant vanishes at μ*. At the upper end of the
    /// bracket it is negative.
    pub critical: Vec<ElementCase>,
}

/// The reason why there is no bracket of a strip's μ*.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StripError {
    /// The operator is not positive definite.
    #[error(
        "the operator εI + A of {elements} elements is not positive definite, so that no friction \
         makes a solution unique: take the average projection, or a larger epsilon"
    )]
    Indefinite {
        /// The number of elements.
        elements: usize,
    },
    /// The coupling is too weak.
    #[error("no determinant vanishes for any friction up to {most:e}: the coupling is too weak")]
    Weak {
        /// The largest friction that was tried.
        most: f64,
    },
    /// No field was found that shows the upper end.
    #[error("no witness was found for the case of {elements} elements whose determinant vanishes")]
    NoWitness {
        /// The number of elements.
        elements: usize,
    },
}

/// The reason why a bound of a strip's μ* is not shown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StripVerifyError {
    /// The mesh is no row of a few elements.
    #[error("Ω has {found} elements: it must be one row of at most {MOST_STRIP_ELEMENTS} along x")]
    Mesh {
        /// The elements along x and y.
        found: String,
    },
    /// The number of cases is not the number of elements.
    #[error("there are {found} cases for {elements} elements: there must be one for each")]
    Length {
        /// The number of cases.
        found: usize,
        /// The number of elements.
        elements: usize,
    },
    /// The friction coefficient μ has no meaning.
    #[error("mu = {mu:e}: it must be finite and above 0")]
    Mu {
        /// The value of μ.
        mu: f64,
    },
    /// A determinant is not positive.
    #[error("the determinant of the case {case} is not shown to be positive for mu = {mu}")]
    NotPositive {
        /// The friction coefficient μ.
        mu: f64,
        /// The case of the elements in a letter each.
        case: String,
    },
    /// The determinant that is said to vanish is not negative above.
    #[error("the determinant of the case {case}, said to vanish, is not negative for mu = {mu}")]
    NotNegative {
        /// The friction coefficient μ.
        mu: f64,
        /// The case of the elements in a letter each.
        case: String,
    },
}

/// The relative distance of the lower end from the friction at which a determinant vanishes.
const MARGIN: f64 = 1e-7;

/// The largest friction at which a determinant is looked for that is not positive.
const MOST_MU: f64 = 1e12;

/// Returns a letter for each element: `o` open, `h` held, `s` stick, `f` and `b` slip forward and
/// backward.
pub fn letters(cases: &[ElementCase]) -> String {
    let letter = |case: &ElementCase| match case {
        ElementCase::Open => 'o',
        ElementCase::Held => 'h',
        ElementCase::Stick => 's',
        ElementCase::SlipForward => 'f',
        ElementCase::SlipBackward => 'b',
    };
    cases.iter().map(letter).collect()
}

/// The operator of a strip: a 2n × 2n matrix, row by row, with s and t of an element side by side.
#[derive(Clone, Debug)]
struct Strip {
    elements: usize,
    matrix: Vec<f64>,
}

impl Strip {
    /// Creates the operator of the first `elements` elements, in units of the largest diagonal
    /// entry of the system.
    fn of(system: &System, elements: usize) -> Self {
        let k = system.elements();
        let whole = system.matrix();
        let place = |i: usize| (i % 2) * k + i / 2;
        let size = 2 * elements;
        let scale = 2_f64.powi(-(system.largest_diagonal().log2().round() as i32));
        let matrix = (0..size * size)
            .map(|entry| scale * whole[(place(entry / size), place(entry % size))])
            .collect();
        Self { elements, matrix }
    }

    /// Returns the operator with its elements in the order of elimination: the two ends come first,
    /// which a mirror image exchanges.
    fn ends_first(&self) -> Self {
        let (n, size) = (self.elements, 2 * self.elements);
        let place = |i: usize| 2 * ends_first(i / 2, n) + i % 2;
        let matrix = (0..size * size)
            .map(|entry| self.matrix[place(entry / size) * size + place(entry % size)])
            .collect();
        Self { elements: n, matrix }
    }
}

/// Returns the number of the element that is eliminated at a place of the order.
fn ends_first(place: usize, elements: usize) -> usize {
    match place {
        0 => 0,
        1 => elements - 1,
        _ => place - 1,
    }
}

/// Returns cases in the order of the strip from those in the order of elimination.
fn along_strip(cases: &[ElementCase], elements: usize) -> Vec<ElementCase> {
    let mut along = vec![ElementCase::Open; elements];
    for (place, &case) in cases.iter().enumerate() {
        along[ends_first(place, elements)] = case;
    }
    along
}

/// Eliminates the first element of a matrix with `size` rows in a case, and writes the matrix of
/// the others to `rest`. It returns the sign of the pivots' product.
fn eliminate<B: Ball>(matrix: &[B], size: usize, mu: B, case: ElementCase, rest: &mut [B]) -> Sign {
    let left = size - 2;
    let of = |i: usize, j: usize| matrix[i * size + j];
    match case {
        ElementCase::Open => {
            for i in 0..left {
                for j in 0..left {
                    rest[i * left + j] = of(i + 2, j + 2);
                }
            }
            Sign::Positive
        }
        ElementCase::Held => {
            let pivot = of(1, 1);
            for i in 0..left {
                let factor = of(i + 2, 1).over(pivot);
                for j in 0..left {
                    rest[i * left + j] = of(i + 2, j + 2).minus(factor.times(of(1, j + 2)));
                }
            }
            pivot.sign()
        }
        ElementCase::Stick => {
            let pivot = of(1, 1);
            let factor = of(0, 1).over(pivot);
            let second = of(0, 0).minus(factor.times(of(1, 0)));
            for i in 0..left {
                let first = of(i + 2, 1).over(pivot);
                let then = of(i + 2, 0).minus(first.times(of(1, 0))).over(second);
                for j in 0..left {
                    let row = of(0, j + 2).minus(factor.times(of(1, j + 2)));
                    rest[i * left + j] =
                        of(i + 2, j + 2).minus(first.times(of(1, j + 2))).minus(then.times(row));
                }
            }
            match (pivot.sign(), second.sign()) {
                (Sign::Unclear, _) | (_, Sign::Unclear) => Sign::Unclear,
                (first, then) if first == then => Sign::Positive,
                _ => Sign::Negative,
            }
        }
        ElementCase::SlipForward | ElementCase::SlipBackward => {
            let column = |i: usize| {
                let sideways = mu.times(of(i, 1));
                if case == ElementCase::SlipForward {
                    of(i, 0).plus(sideways)
                } else {
                    of(i, 0).minus(sideways)
                }
            };
            let pivot = column(0);
            for i in 0..left {
                let factor = column(i + 2).over(pivot);
                for j in 0..left {
                    rest[i * left + j] = of(i + 2, j + 2).minus(factor.times(of(0, j + 2)));
                }
            }
            pivot.sign()
        }
    }
}

/// An elimination that goes through cases, with a matrix for each number of elements left.
struct Elimination<B> {
    mu: B,
    /// The matrices, that of all elements first.
    matrices: Vec<Vec<B>>,
    /// The cases of the elements that are eliminated.
    cases: Vec<ElementCase>,
}

impl<B: Ball> Elimination<B> {
    fn new(strip: &Strip, mu: f64) -> Self {
        let n = strip.elements;
        let mut matrices: Vec<Vec<B>> =
            (0..=n).map(|gone| vec![B::exact(0.0); 4 * (n - gone) * (n - gone)]).collect();
        matrices[0] = strip.matrix.iter().map(|&entry| B::exact(entry)).collect();
        Self { mu: B::exact(mu), matrices, cases: Vec::with_capacity(n) }
    }

    fn elements(&self) -> usize {
        self.matrices.len() - 1
    }

    /// Eliminates one more element, and returns the sign of its pivots.
    fn push(&mut self, case: ElementCase) -> Sign {
        let gone = self.cases.len();
        let (before, after) = self.matrices.split_at_mut(gone + 1);
        self.cases.push(case);
        let size = 2 * (before.len() + after.len() - 1 - gone);
        eliminate(&before[gone], size, self.mu, case, &mut after[0])
    }

    /// Eliminates elements in these cases, and says if every pivot is positive.
    fn follow(&mut self, cases: &[ElementCase]) -> bool {
        cases.iter().all(|&case| self.push(case) == Sign::Positive)
    }

    /// Goes through all cases of the elements that are left, and calls `unclear` with the cases so
    /// far where a pivot may not be positive. It stops where that is an error.
    fn descend(
        &mut self,
        unclear: &impl Fn(&[ElementCase]) -> Result<(), Vec<ElementCase>>,
    ) -> Result<(), Vec<ElementCase>> {
        if self.cases.len() == self.elements() {
            return Ok(());
        }
        for case in ElementCase::ALL {
            if self.push(case) == Sign::Positive {
                self.descend(unclear)?;
            } else {
                unclear(&self.cases)?;
            }
            self.cases.pop();
        }
        Ok(())
    }
}

/// Shows that the determinants of all cases are positive.
///
/// # Errors
/// The case of each element along the strip in which the determinant is not shown to be positive,
/// the same one whatever the number of threads.
fn prove(strip: &Strip, mu: f64) -> Result<(), Vec<ElementCase>> {
    let n = strip.elements;
    let ordered = strip.ends_first();
    // The mirror image of ends in the cases (a, b) are ends in the cases (b', a').
    let number = |case: ElementCase| case as usize;
    let ends: Vec<[ElementCase; 2]> = ElementCase::ALL
        .into_iter()
        .flat_map(|a| ElementCase::ALL.map(|b| [a, b]))
        .filter(|[a, b]| {
            let image = [b.mirrored(), a.mirrored()];
            [a, b].map(|case| number(*case)) <= image.map(number)
        })
        .collect();
    let wide = |cases: &[ElementCase]| {
        let mut elimination = Elimination::<Wide>::new(&ordered, mu);
        if !elimination.follow(cases) {
            return Err(elimination.cases);
        }
        elimination.descend(&|cases| Err(cases.to_vec()))
    };
    let failed = ends.into_par_iter().find_map_first(|ends| {
        let mut elimination = Elimination::<Narrow>::new(&ordered, mu);
        let shown = if elimination.follow(&ends[..n.min(2)]) {
            elimination.descend(&wide)
        } else {
            wide(&ends[..n.min(2)])
        };
        shown.err()
    });
    match failed {
        None => Ok(()),
        Some(cases) => Err(along_strip(&cases, n)),
    }
}

/// Says if all pivots of a case are positive, as far as doubles tell.
fn is_positive(strip: &Strip, cases: &[ElementCase], mu: f64) -> bool {
    Elimination::<Wide>::new(strip, mu).follow(cases)
}

/// Returns the friction below `high` at which a pivot of a case ceases to be positive; `None` if
/// that happens at `high` or above.
fn critical_mu(strip: &Strip, cases: &[ElementCase], mut high: f64) -> Option<f64> {
    if is_positive(strip, cases, high) {
        return None;
    }
    let mut low = 0.0;
    for _ in 0..60 {
        let mu = 0.5 * (low + high);
        if is_positive(strip, cases, mu) { low = mu } else { high = mu }
    }
    Some(high)
}

/// A case with the friction at which its determinant vanishes.
#[derive(Clone, Debug)]
struct Critical {
    mu: f64,
    cases: Vec<ElementCase>,
}

/// Changes the cases of one or two neighbouring elements as long as that makes the friction
/// smaller.
fn improve(strip: &Strip, mut best: Critical) -> Critical {
    let n = strip.elements;
    let pairs: Vec<[ElementCase; 2]> =
        ElementCase::ALL.into_iter().flat_map(|a| ElementCase::ALL.map(|b| [a, b])).collect();
    loop {
        let before = best.mu;
        for first in 0..n.saturating_sub(1) {
            for pair in &pairs {
                let mut cases = best.cases.clone();
                cases[first..first + 2].copy_from_slice(pair);
                if let Some(mu) = critical_mu(strip, &cases, best.mu * (1.0 - 0.1 * MARGIN)) {
                    best = Critical { mu, cases };
                }
            }
        }
        if best.mu == before {
            return best;
        }
    }
}

/// Finds μ* from below and the case that ends it.
fn search(system: &System) -> Result<StripBound, StripError> {
    let elements = system.elements();
    let two = Strip::of(system, 2.min(elements));
    let first = (0..)
        .map(|doublings| 2_f64.powi(doublings))
        .take_while(|&mu| mu <= MOST_MU)
        .find_map(|mu| prove(&two, mu).err().map(|cases| Critical { mu, cases }))
        .ok_or(StripError::Weak { most: MOST_MU })?;
    let mut best = first;
    for n in two.elements..=elements {
        let strip = Strip::of(system, n);
        if !is_positive(&strip, &vec![ElementCase::Stick; n], 0.0) {
            return Err(StripError::Indefinite { elements });
        }
        // A shorter strip at either end of this one has the same determinants.
        let missing = n - best.cases.len();
        best.cases.extend(std::iter::repeat_n(ElementCase::Open, missing));
        if let Some(mu) = critical_mu(&strip, &best.cases, best.mu) {
            best.mu = mu;
        }
        let shorter = best.clone();
        for shift in 0..=missing {
            let mut moved = shorter.clone();
            moved.cases.rotate_right(shift);
            let found = improve(&strip, moved);
            if found.mu < best.mu {
                best = found;
            }
        }
        while let Err(cases) = prove(&strip, best.mu * (1.0 - MARGIN)) {
            let mu = best.mu * (1.0 - MARGIN);
            let mu = critical_mu(&strip, &cases, mu).unwrap_or(mu);
            best = improve(&strip, Critical { mu, cases });
        }
    }
    Ok(StripBound { mu: best.mu * (1.0 - MARGIN), critical: best.cases })
}

/// Brackets μ* of a strip, of a system for which [`System::is_coupled`] holds.
///
/// # Errors
/// A [`StripError`] says that the operator is not positive definite, that its coupling is too weak,
/// or that there is no witness.
pub(super) fn bracket(system: &System) -> Result<(StripBound, Witness), StripError> {
    let bound = search(system)?;
    let witness =
        witness(system, &bound).ok_or(StripError::NoWitness { elements: system.elements() })?;
    Ok((bound, witness))
}

/// Shows that every determinant of a strip is positive for the μ of a bound, and that the one of
/// its critical case is negative for the friction `high`, so that μ* is between the two.
///
/// # Errors
/// A [`StripVerifyError`] says that the bound has no meaning, or which determinant does not have
/// its sign.
pub fn verify(system: &System, bound: &StripBound, high: f64) -> Result<(), StripVerifyError> {
    let elements = [system.grid().nx(), system.grid().ny()];
    if !is_strip(elements) || system.elements() != elements[0] {
        let found = format!("{} × {}", elements[0], elements[1]);
        return Err(StripVerifyError::Mesh { found });
    }
    let (found, elements) = (bound.critical.len(), elements[0]);
    if found != elements {
        return Err(StripVerifyError::Length { found, elements });
    }
    if let Some(mu) = [bound.mu, high].into_iter().find(|mu| !(mu.is_finite() && *mu > 0.0)) {
        return Err(StripVerifyError::Mu { mu });
    }
    let strip = Strip::of(system, elements);
    let mut elimination = Elimination::<Wide>::new(&strip, high);
    let mut is_negative = false;
    for &case in &bound.critical {
        match elimination.push(case) {
            Sign::Positive => {}
            Sign::Negative => is_negative = !is_negative,
            Sign::Unclear => {
                is_negative = false;
                break;
            }
        }
    }
    if !is_negative {
        return Err(StripVerifyError::NotNegative { mu: high, case: letters(&bound.critical) });
    }
    prove(&strip, bound.mu)
        .map_err(|cases| StripVerifyError::NotPositive { mu: bound.mu, case: letters(&cases) })
}

/// The distances of c and d from the ends of their ranges that are tried for a witness. The nearer
/// the witness is to its case, the less friction it needs, and the nearer to rounding are the
/// numbers whose signs it needs.
const DISTANCES: [f64; 4] = [1e-6, 1e-7, 1e-8, 1e-9];

/// Finds the field of the critical case that keeps the inequalities strictly with the least
/// friction.
fn witness(system: &System, bound: &StripBound) -> Option<Witness> {
    let strip = Strip::of(system, system.elements());
    let fields = DISTANCES.into_iter().filter_map(|distance| {
        let field = kernel(&strip, &bound.critical, bound.mu, distance)?;
        let across = std::iter::repeat_n(0.0, strip.elements);
        let normal = field.iter().step_by(2).copied();
        let along = field.iter().skip(1).step_by(2).copied();
        needed(system, normal.chain(along).chain(across).collect())
    });
    let found = fields.min_by(|a, b| a.mu.total_cmp(&b.mu))?;
    let largest = found.x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    Some(Witness {
        // The factor leaves room for the rounding of the division and of other ways to apply the
        // operator.
        mu: found.mu * (1.0 + 1e-12),
        stiffness: STIFFNESS / system.largest_diagonal(),
        x: found.x.into_iter().map(|x| x / largest).collect(),
    })
}

/// Returns the matrix R of a case, with c and d at a distance from the ends of their ranges.
fn rows(strip: &Strip, cases: &[ElementCase], mu: f64, distance: f64) -> Vec<f64> {
    let size = 2 * strip.elements;
    let mut rows = vec![0.0; size * size];
    for (element, case) in cases.iter().enumerate() {
        let (closed, held, a) = match case {
            ElementCase::Open => (false, false, 0.0),
            ElementCase::Held => (false, true, 0.0),
            ElementCase::Stick => (true, true, 0.0),
            ElementCase::SlipForward => (true, false, mu),
            ElementCase::SlipBackward => (true, false, -mu),
        };
        let near = |end: bool| if end { 1.0 - distance } else { distance };
        for (row, share) in [(2 * element, near(closed)), (2 * element + 1, near(held))] {
            for j in 0..size {
                rows[row * size + j] = share * strip.matrix[row * size + j];
            }
            rows[row * size + row] += 1.0 - share;
            if row % 2 == 1 {
                rows[row * size + row - 1] -= (1.0 - share) * a;
            }
        }
    }
    rows
}

/// Finds the field that R maps to 0, for the friction near `mu` at which there is one.
fn kernel(strip: &Strip, cases: &[ElementCase], mu: f64, distance: f64) -> Option<Vec<f64>> {
    let size = 2 * strip.elements;
    let is_positive = |mu: f64| {
        Factors::of(rows(strip, cases, mu, distance), size).is_some_and(|factors| factors.positive)
    };
    if !is_positive(mu) {
        return None;
    }
    let mut low = mu;
    let mut high =
        (0..40).map(|doublings| mu * (1.0 + distance * 2_f64.powi(doublings))).find(|&mu| {
            let positive = is_positive(mu);
            if positive {
                low = mu;
            }
            !positive
        })?;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if is_positive(middle) { low = middle } else { high = middle }
    }
    let factors = [low, high]
        .into_iter()
        .find_map(|mu| Factors::of(rows(strip, cases, mu, distance), size))?;
    // Inverse iteration from a vector with a share of every other.
    let mut field: Vec<f64> =
        (0..size).map(|i| ((i + 1) as f64 * 0.618_033_988_749_895).fract() + 0.1).collect();
    for _ in 0..3 {
        field = factors.solve(&field);
        let largest = field.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        field.iter_mut().for_each(|x| *x /= largest);
    }
    field.iter().all(|x| x.is_finite()).then_some(field)
}

/// Triangular factors of a small matrix, with rows exchanged.
struct Factors {
    size: usize,
    factors: Vec<f64>,
    order: Vec<usize>,
    /// True if the determinant is positive.
    positive: bool,
}

impl Factors {
    /// Factors a matrix, row by row; `None` if it is singular.
    fn of(mut matrix: Vec<f64>, size: usize) -> Option<Self> {
        let mut order: Vec<usize> = (0..size).collect();
        let mut positive = true;
        for j in 0..size {
            let largest = (j..size)
                .max_by(|&a, &b| matrix[a * size + j].abs().total_cmp(&matrix[b * size + j].abs()))
                .unwrap_or(j);
            if largest != j {
                for column in 0..size {
                    matrix.swap(largest * size + column, j * size + column);
                }
                order.swap(largest, j);
                positive = !positive;
            }
            let pivot = matrix[j * size + j];
            if pivot == 0.0 || !pivot.is_finite() {
                return None;
            }
            if pivot < 0.0 {
                positive = !positive;
            }
            for i in j + 1..size {
                let factor = matrix[i * size + j] / pivot;
                matrix[i * size + j] = factor;
                for column in j + 1..size {
                    matrix[i * size + column] -= factor * matrix[j * size + column];
                }
            }
        }
        Some(Self { size, factors: matrix, order, positive })
    }

    /// Solves for a right side.
    fn solve(&self, right: &[f64]) -> Vec<f64> {
        let size = self.size;
        let mut x: Vec<f64> = self.order.iter().map(|&row| right[row]).collect();
        for i in 0..size {
            for j in 0..i {
                x[i] -= self.factors[i * size + j] * x[j];
            }
        }
        for i in (0..size).rev() {
            for j in i + 1..size {
                x[i] -= self.factors[i * size + j] * x[j];
            }
            x[i] /= self.factors[i * size + i];
        }
        x
    }
}
