//! The free components of a contact whose elements are known to be open, to stick or to slip: the
//! unknowns of Newton's method.
//!
//! They are kept without gaps, element after element: first p₁ if it is free, then both tangential
//! components if the element sticks, or the one across its traction if it slips. The fields that
//! they come from and go to live on a [`Window`], which holds the contact.

use crate::common::parallel::{self, BAND};
use crate::influence::Window;
use crate::problem::Problem;

/// The state of the tangential tractions of an element in contact under the linearised map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ContactState {
    /// Both components are free.
    Stick,
    /// Only the component across n, the direction of the traction, is free, and not even this one
    /// if σ is infinite.
    Slip { n: [f64; 2], sigma: f64 },
}

/// An element in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ContactElement {
    /// The column of the problem's grid.
    pub(super) i: u32,
    /// The row of the problem's grid.
    pub(super) j: u32,
    /// True if p₁ is free, that is, below the ceiling.
    pub(super) pressed: bool,
    /// The state of its tangential tractions.
    pub(super) state: ContactState,
}

/// The elements in contact, their free components, and the window around them.
#[derive(Debug)]
pub(super) struct Free {
    window: Window,
    /// The block of a field that holds each of the components n, x, y.
    blocks: [Option<usize>; 3],
    /// The bands of whole rows of the window, each with its elements and its unknowns.
    bands: Vec<Band>,
    /// The number of rows of a band.
    rows: usize,
    unknowns: usize,
}

/// A band of whole rows of the window: its elements in contact, and the number of their unknowns.
#[derive(Debug)]
struct Band {
    elements: Vec<ContactElement>,
    unknowns: usize,
}

impl Free {
    /// Takes elements in the order of the grid, all of them in the window.
    pub(super) fn new(problem: &Problem, window: Window, elements: &[ContactElement]) -> Self {
        let mut blocks = [None; 3];
        problem.blocks().for_each(|(block, c)| blocks[c] = Some(block));
        let rows = BAND.div_ceil(window.size[0]);
        let mut free = Self { window, blocks, bands: Vec::new(), rows, unknowns: 0 };
        let mut left = elements;
        for band in 0..window.size[1].div_ceil(rows) {
            let end = window.first[1] + (band + 1) * rows;
            let (elements, others) =
                left.split_at(left.partition_point(|element| (element.j as usize) < end));
            left = others;
            let unknowns = elements.iter().map(|element| free.unknowns_of(element)).sum();
            free.unknowns += unknowns;
            free.bands.push(Band { elements: elements.to_vec(), unknowns });
        }
        free
    }

    /// Returns the number of unknowns.
    pub(super) fn len(&self) -> usize {
        self.unknowns
    }

    /// Returns the number of values of a field on the window.
    pub(super) fn field_len(&self) -> usize {
        self.blocks.iter().flatten().count() * self.window.len()
    }

    /// Returns the number of unknowns of an element.
    fn unknowns_of(&self, element: &ContactElement) -> usize {
        usize::from(element.pressed)
            + match element.state {
                ContactState::Stick => self.blocks[1..].iter().flatten().count(),
                ContactState::Slip { sigma, .. } => usize::from(sigma.is_finite()),
            }
    }

    /// Returns the place of an element in a block of the window.
    fn place(&self, element: &ContactElement) -> usize {
        (element.j as usize - self.window.first[1]) * self.window.size[0] + element.i as usize
            - self.window.first[0]
    }

    /// Writes the tractions of the free components `unknowns` into `field`. On slipping elements
    /// p_t·n = `mu` p₁, and the transverse component is multiplied by `weight`(σ).
    ///
    /// The function writes `field` only where there are elements.
    pub(super) fn expand(
        &self,
        field: &mut [f64],
        unknowns: &[f64],
        mu: f64,
        weight: impl Fn(f64) -> f64 + Sync,
    ) {
        let mut blocks: Vec<_> = field
            .chunks_exact_mut(self.window.len())
            .map(|block| block.chunks_mut(self.rows * self.window.size[0]))
            .collect();
        let mut left = unknowns;
        let mut bands = Vec::with_capacity(self.bands.len());
        for (number, band) in self.bands.iter().enumerate() {
            let (unknowns, others) = left.split_at(band.unknowns);
            left = others;
            let components: [&mut [f64]; 3] = self
                .blocks
                .map(|block| block.and_then(|block| blocks[block].next()).unwrap_or_default());
            let start = number * self.rows * self.window.size[0];
            bands.push((start, &band.elements, unknowns, components));
        }
        parallel::each(self.unknowns, bands, |(start, elements, unknowns, mut components)| {
            let mut unknowns = unknowns.iter().copied();
            let mut next = || unknowns.next().unwrap_or(0.0);
            for element in elements {
                let normal = if element.pressed { next() } else { 0.0 };
                let tangential = match element.state {
                    ContactState::Stick => {
                        [1, 2].map(|c| if self.blocks[c].is_some() { next() } else { 0.0 })
                    }
                    ContactState::Slip { n, sigma } => {
                        let along = mu * normal;
                        let across = if sigma.is_finite() { weight(sigma) * next() } else { 0.0 };
                        [along * n[0] - across * n[1], along * n[1] + across * n[0]]
                    }
                };
                let place = self.place(element) - start;
                let tractions = [normal, tangential[0], tangential[1]];
                for (component, value) in components.iter_mut().zip(tractions) {
                    if let Some(entry) = component.get_mut(place) {
                        *entry = value;
                    }
                }
            }
        });
    }

    /// Writes the tractions of the elements in contact into a field on the window. `values` gives
    /// the (n, x, y) tractions of an element from its place in the window.
    pub(super) fn write(
        &self,
        field: &mut [f64],
        values: impl Fn(&ContactElement, usize) -> [f64; 3] + Sync,
    ) {
        let size = self.window.size[0] * self.rows;
        let mut blocks: Vec<_> =
            field.chunks_exact_mut(self.window.len()).map(|block| block.chunks_mut(size)).collect();
        let bands = self.bands.iter().enumerate().map(|(number, band)| {
            let components: [&mut [f64]; 3] = self
                .blocks
                .map(|block| block.and_then(|block| blocks[block].next()).unwrap_or_default());
            (number * size, &band.elements, components)
        });
        parallel::each(self.unknowns, bands.collect(), |(start, elements, mut components)| {
            for element in elements {
                let place = self.place(element);
                for (component, value) in components.iter_mut().zip(values(element, place)) {
                    if let Some(entry) = component.get_mut(place - start) {
                        *entry = value;
                    }
                }
            }
        });
    }

    /// Projects a vector per element onto the free components. `values` gives the (n, x, y) vector
    /// of an element from its place in the window. On a slipping element the row of p₁ receives the
    /// normal component plus `mu` times the component along the traction; the row of the transverse
    /// traction is `across`(σ, transverse component, row index).
    pub(super) fn restrict(
        &self,
        rows: &mut [f64],
        mu: f64,
        values: impl Fn(&ContactElement, usize) -> [f64; 3] + Sync,
        across: impl Fn(f64, f64, usize) -> f64 + Sync,
    ) {
        let (mut left, mut first) = (rows, 0);
        let mut bands = Vec::with_capacity(self.bands.len());
        for band in &self.bands {
            let (rows, others) = left.split_at_mut(band.unknowns);
            bands.push((first, &band.elements, rows));
            (left, first) = (others, first + band.unknowns);
        }
        parallel::each(self.unknowns, bands, |(first, elements, rows)| {
            let mut next = 0;
            for element in elements {
                let vector = values(element, self.place(element));
                if element.pressed {
                    rows[next] = match element.state {
                        ContactState::Slip { n, .. } => {
                            vector[0] + mu * (vector[1] * n[0] + vector[2] * n[1])
                        }
                        ContactState::Stick => vector[0],
                    };
                    next += 1;
                }
                match element.state {
                    ContactState::Stick => {
                        for c in [1, 2].into_iter().filter(|c| self.blocks[*c].is_some()) {
                            rows[next] = vector[c];
                            next += 1;
                        }
                    }
                    ContactState::Slip { n, sigma } if sigma.is_finite() => {
                        let transverse = vector[2] * n[0] - vector[1] * n[1];
                        rows[next] = across(sigma, transverse, first + next);
                        next += 1;
                    }
                    ContactState::Slip { .. } => {}
                }
            }
        });
    }

    /// Projects a field on the window onto the free components, as it is.
    pub(super) fn rows_of(&self, rows: &mut [f64], field: &[f64]) {
        self.restrict(rows, 0.0, |_, place| self.at(field, place), |_, row, _| row);
    }

    /// Returns the components (n, x, y) of a field on the window at a place; those that the field
    /// does not have are zero.
    pub(super) fn at(&self, field: &[f64], place: usize) -> [f64; 3] {
        self.blocks.map(|block| block.map_or(0.0, |block| field[block * self.window.len() + place]))
    }

    /// Returns the elements in contact with their places in the window.
    pub(super) fn elements(&self) -> impl DoubleEndedIterator<Item = (&ContactElement, usize)> {
        self.bands
            .iter()
            .flat_map(|band| &band.elements)
            .map(|element| (element, self.place(element)))
    }

    /// Returns the window around the contact.
    pub(super) fn window(&self) -> &Window {
        &self.window
    }
}
