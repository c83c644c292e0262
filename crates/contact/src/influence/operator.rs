//! What an influence operator is, and the memory that applying it needs.

use realfft::num_complex::Complex;

use super::components::Components;
use crate::common::parallel;
use crate::grid::Grid;

/// A discretised influence operator: self-adjoint, and positive definite on Ω in the average
/// projection.
///
/// Fields have one block as long as the grid for each of the operator's components, in the order n,
/// x, y. The operator is M A M, M the restriction to Ω: what is given on masked elements is
/// ignored, and the displacement there is set to zero. With mirror planes the mirror images act
/// too. Same operator and input, same bytes, for any number of threads.
pub trait Influence: Send + Sync {
    /// The grid that the fields live on.
    fn grid(&self) -> &Grid;

    /// The components that it acts on.
    fn components(&self) -> Components;

    /// Memory that an application on `threads` threads needs.
    fn scratch_size(&self, threads: usize) -> ScratchSize;

    /// out = A p, both as many blocks as components.
    ///
    /// # Panics
    /// If a field has another length.
    fn apply(&self, out: &mut [f64], p: &[f64], scratch: &mut Scratch);
}

/// Numbers to set aside for an application.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ScratchSize {
    /// Real numbers.
    pub real: usize,
    /// Complex numbers.
    pub complex: usize,
}

/// Memory for applications of an operator, owned by the caller so that an iteration allocates once.
/// It carries nothing from one application to the next, and grows when used for an operator that
/// needs more.
#[derive(Clone, Debug)]
pub struct Scratch {
    pub(super) threads: usize,
    real: Vec<f64>,
    complex: Vec<Complex<f64>>,
}

impl Scratch {
    /// Enough for `operator` on as many threads as the current rayon pool has, or on one where that
    /// is faster.
    pub fn new<I: Influence + ?Sized>(operator: &I) -> Self {
        let mut scratch = Self::for_elements(operator.grid().len());
        scratch.take(operator.scratch_size(scratch.threads));
        scratch
    }

    /// For operators on so many elements; grows with the first application.
    pub(crate) fn for_elements(elements: usize) -> Self {
        // Below this an application takes about as long as waking a second thread.
        const WORTH_A_THREAD: usize = 4096;
        let threads = (elements / WORTH_A_THREAD).clamp(1, rayon::current_num_threads());
        Self::on_threads(threads)
    }

    /// For so many threads; grows with the first application.
    pub(crate) fn on_threads(threads: usize) -> Self {
        Self { threads: threads.max(1), real: Vec::new(), complex: Vec::new() }
    }

    /// Enough for `operator` on `threads` threads (at least one).
    pub fn with_threads<I: Influence + ?Sized>(operator: &I, threads: usize) -> Self {
        let mut scratch = Self::on_threads(threads);
        scratch.take(operator.scratch_size(scratch.threads));
        scratch
    }

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
