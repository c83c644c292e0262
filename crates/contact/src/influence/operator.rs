//! The trait of an influence operator, and the memory that an application needs.

use realfft::num_complex::Complex;

use super::components::Components;
use crate::common::parallel;
use crate::grid::Grid;

/// A discretised influence operator. A is self-adjoint, and positive definite on Ω in the average
/// projection; the operator of steady rolling is not self-adjoint.
///
/// Fields have one block as long as the grid for each of the operator's components, in the order n,
/// x, y. The operator is M A M, where M is the restriction to Ω: tractions on masked elements are
/// ignored, and the displacement there is set to zero. With mirror planes the mirror images act
/// too. The same operator and input give the same bytes for any number of threads.
pub trait Influence: Send + Sync {
    /// Returns the grid on which the fields live.
    fn grid(&self) -> &Grid;

    /// Returns the components on which the operator acts.
    fn components(&self) -> Components;

    /// Returns the memory that an application on `threads` threads needs.
    fn scratch_size(&self, threads: usize) -> ScratchSize;

    /// Computes out = A p, both with as many blocks as components; the unit of `out` is that of `p`
    /// times that of the coefficients.
    ///
    /// # Panics
    /// If a field has another length.
    fn apply(&self, out: &mut [f64], p: &[f64], scratch: &mut Scratch);
}

/// Applies the operators of `groups` of components that do not couple, each given with its number
/// of components, one after the other to their blocks of length `k`.
///
/// # Panics
/// If a field has another length than all of them together.
pub(super) fn group_by_group<Group>(
    groups: impl Iterator<Item = (Group, usize)>,
    k: usize,
    out: &mut [f64],
    p: &[f64],
    mut apply: impl FnMut(Group, &mut [f64], &[f64]),
) {
    let (mut out_left, mut p_left) = (out, p);
    for (group, components) in groups {
        let fits = out_left.len().min(p_left.len()) >= components * k;
        assert!(fits, "fields on another grid");
        let (out, p);
        (out, out_left) = std::mem::take(&mut out_left).split_at_mut(components * k);
        (p, p_left) = p_left.split_at(components * k);
        apply(group, out, p);
    }
    assert!(out_left.is_empty() && p_left.is_empty(), "fields on another grid");
}

/// The memory to set aside for an application.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ScratchSize {
    /// The count of real numbers.
    pub real: usize,
    /// The count of complex numbers.
    pub complex: usize,
}

/// Memory for applications of an operator, owned by the caller so that an iteration allocates once.
/// It carries nothing from one application to the next, and grows when used for an operator that
/// needs more.
#[derive(Clone, Debug)]
pub struct Scratch {
    /// The number of threads that an application uses.
    pub(super) threads: usize,
    real: Vec<f64>,
    complex: Vec<Complex<f64>>,
}

impl Scratch {
    /// Allocates enough for `operator` on as many threads as the current rayon pool has, or on one
    /// if that is faster.
    pub fn new<I: Influence + ?Sized>(operator: &I) -> Self {
        let mut scratch = Self::for_elements(operator.grid().len());
        scratch.take(operator.scratch_size(scratch.threads));
        scratch
    }

    /// Prepares memory for operators on so many elements; it grows with the first application.
    pub(crate) fn for_elements(elements: usize) -> Self {
        // Below this an application takes about as long as waking a second thread.
        const WORTH_A_THREAD: usize = 4096;
        let threads = (elements / WORTH_A_THREAD).clamp(1, rayon::current_num_threads());
        Self::on_threads(threads)
    }

    /// Prepares memory for so many threads (at least one); it grows with the first application.
    pub(crate) fn on_threads(threads: usize) -> Self {
        Self { threads: threads.max(1), real: Vec::new(), complex: Vec::new() }
    }

    /// Allocates enough for `operator` on `threads` threads (at least one).
    pub fn with_threads<I: Influence + ?Sized>(operator: &I, threads: usize) -> Self {
        let mut scratch = Self::on_threads(threads);
        scratch.take(operator.scratch_size(scratch.threads));
        scratch
    }

    /// Returns the memory, which grows if it is too small; its content is arbitrary.
    pub(super) fn take(&mut self, size: ScratchSize) -> (&mut [f64], &mut [Complex<f64>]) {
        if self.real.len() < size.real {
            self.real = parallel::filled(size.real, 0.0);
        }
        if self.complex.len() < size.complex {
            self.complex = parallel::filled(size.complex, Complex::default());
        }
        (&mut self.real[..size.real], &mut self.complex[..size.complex])
    }
}
