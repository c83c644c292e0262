//! Cases of open and closed elements, and whether some of them leave no combination out.

use serde::{Deserialize, Serialize};

use super::question::MOST_CASE_ELEMENTS;
use super::symmetry::Symmetries;
use super::system::System;

/// The state of an element in a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NormalCase {
    /// The case says nothing of the element: x₁y₁ ≤ 0.
    Undecided,
    /// The element bears no pressure: x₁ = 0.
    Open,
    /// The element is not displaced along the normal: y₁ = 0.
    Closed,
}

/// The reason why cases are not all that there are.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CoverError {
    /// There are too many elements.
    #[error("Ω has {elements} elements: cases are of at most {MOST_CASE_ELEMENTS}")]
    Elements {
        /// The number of elements.
        elements: usize,
    },
    /// A case is of other elements than those of Ω.
    #[error("case {case}: {states} states for {elements} elements")]
    States {
        /// The index of the case.
        case: usize,
        /// The number of its states.
        states: usize,
        /// The number of elements.
        elements: usize,
    },
    /// The cases leave some out.
    #[error("the {cases} excluded cases are not all: {missing}")]
    Missing {
        /// The number of cases.
        cases: usize,
        /// The combination that they leave out, a letter for each element: o open, c closed.
        missing: String,
    },
}

/// The states of a case as bits, one for each element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct CaseBits {
    /// The elements that are decided.
    decided: u32,
    /// The elements that are closed.
    closed: u32,
}

impl CaseBits {
    const NONE: Self = Self { decided: 0, closed: 0 };

    fn with(self, element: usize, state: NormalCase) -> Self {
        let bit = 1 << element;
        match state {
            NormalCase::Undecided => self,
            NormalCase::Open => Self { decided: self.decided | bit, ..self },
            NormalCase::Closed => Self { decided: self.decided | bit, closed: self.closed | bit },
        }
    }

    /// Returns the image of a case, with the image of each element.
    pub(super) fn of_image(states: &[NormalCase], image: &[usize]) -> Self {
        let pairs = states.iter().zip(image);
        pairs.fold(Self::NONE, |bits, (state, &element)| bits.with(element, *state))
    }

    /// Says if every combination of the other case is one of this.
    fn covers(self, other: Self) -> bool {
        self.decided & !other.decided == 0 && (self.closed ^ other.closed) & self.decided == 0
    }
}

/// Returns the image of a case that comes first of all, with the images of each element.
pub(super) fn least_image(states: &[NormalCase], images: &[Vec<usize>]) -> Vec<NormalCase> {
    let of_image = |image: &Vec<usize>| {
        let mut moved = states.to_vec();
        states.iter().zip(image).for_each(|(state, &element)| moved[element] = *state);
        moved
    };
    let least = images.iter().min_by_key(|image| CaseBits::of_image(states, image));
    least.map_or_else(|| states.to_vec(), of_image)
}

/// Returns the elements of Ω by their distance from its middle.
pub(super) fn from_the_middle(system: &System) -> Vec<usize> {
    let grid = system.grid();
    let distance = |e: usize| {
        let (i, j) = grid.position(e);
        let [x, y] = [(i, grid.nx()), (j, grid.ny())]
            .map(|(place, count)| (2 * place + 1).abs_diff(count) as u64);
        x * x + y * y
    };
    let elements: Vec<usize> = grid.active().collect();
    let mut order: Vec<usize> = (0..elements.len()).collect();
    order.sort_by_key(|&place| distance(elements[place]));
    order
}

/// Checks the number of elements, and that each case has a state for each.
pub(super) fn check_states(system: &System, cases: &[&[NormalCase]]) -> Result<(), CoverError> {
    let elements = system.elements();
    if elements > MOST_CASE_ELEMENTS {
        return Err(CoverError::Elements { elements });
    }
    match cases.iter().position(|states| states.len() != elements) {
        Some(case) => Err(CoverError::States { case, states: cases[case].len(), elements }),
        None => Ok(()),
    }
}

/// Checks that each combination of open and closed elements is one of the cases or of their images.
/// Those are looked at that have the states `of`, all of them without any.
pub(super) fn check_cover(
    system: &System,
    symmetries: Symmetries,
    cases: &[&[NormalCase]],
    of: &[NormalCase],
) -> Result<(), CoverError> {
    let images = symmetries.images(system);
    let covered: Vec<CaseBits> = cases
        .iter()
        .flat_map(|states| images.iter().map(|image| CaseBits::of_image(states, image)))
        .collect();
    let places: Vec<usize> = (0..of.len()).collect();
    let mut order = from_the_middle(system);
    order.retain(|&element| of.get(element).is_none_or(|state| *state == NormalCase::Undecided));
    cover(&covered, &order, CaseBits::of_image(of, &places)).map_err(|missing| {
        let letter = |element: usize| if missing.closed >> element & 1 == 1 { 'c' } else { 'o' };
        let missing = (0..system.elements()).map(letter).collect();
        CoverError::Missing { cases: cases.len(), missing }
    })
}

/// Shows that every combination of a case is one of those that are covered. It decides one element
/// after the other in the order given. The error is a combination that is left out.
fn cover(covered: &[CaseBits], order: &[usize], case: CaseBits) -> Result<(), CaseBits> {
    if covered.iter().any(|other| other.covers(case)) {
        return Ok(());
    }
    let Some((&element, rest)) = order.split_first() else { return Err(case) };
    cover(covered, rest, case.with(element, NormalCase::Closed))?;
    cover(covered, rest, case.with(element, NormalCase::Open))
}
