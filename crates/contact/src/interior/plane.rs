//! The stresses on a whole plane z = const, at the elements' centres, by Fourier transforms.
//!
//! The stress of an element depends on the distance alone, so a plane is a convolution. The torus
//! has room for every distance between a loaded element and a receiver, so nothing is periodic.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealToComplex};
use rustfft::Fft;

use super::loaded::{PlaneStress, Subsurface};
use crate::foundation::{DepthSide, StressBlock, StressKernels};
use crate::influence::suitable_length;
use crate::model::Stress;

/// The axes, x = 0, y = 1, z = 2, of each stress and of each traction.
const STRESS_AXES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]];
const TRACTION_AXES: [usize; 3] = [2, 0, 1];

impl Subsurface<'_> {
    /// Returns the stresses at a depth \[m\] at the centres of all elements; `None` inside a rigid
    /// base. Where materials meet they are those of the upper one.
    pub fn plane(&self, depth: f64) -> Option<PlaneStress> {
        self.plane_on(depth, DepthSide::Above)
    }

    /// Returns the stresses at a depth, on this side of it.
    pub(super) fn plane_on(&self, depth: f64, side: DepthSide) -> Option<PlaneStress> {
        let kernels = self.kernels(depth, side, self.fields.origin)?;
        let shape = self.fields.shape.map(|n| n as usize);
        let [columns, rows] = self.window.clone();
        if columns.is_empty() {
            let stresses = vec![Stress::default(); shape[0] * shape[1]];
            return Some(PlaneStress { depth, stresses });
        }
        let torus = TorusTransform::new([
            2 * suitable_length((shape[0] + columns.len()).div_ceil(2), false),
            2 * suitable_length((shape[1] + rows.len()).div_ceil(2), false),
        ]);
        let first = [columns.start, rows.start];
        let table = QuadrantTable::new(&kernels, self, [&columns, &rows]);
        let tractions = [&self.fields.pressure, &self.fields.traction_x, &self.fields.traction_y];
        let loads: Vec<Option<Vec<Complex<f64>>>> = tractions
            .par_iter()
            .map(|field| {
                let is_loaded = field.iter().any(|traction| *traction != 0.0);
                is_loaded.then(|| {
                    torus.forward(|y, row| {
                        if y < rows.len() {
                            let start = (rows.start + y) * shape[0] + columns.start;
                            row[..columns.len()].copy_from_slice(&field[start..][..columns.len()]);
                        }
                    })
                })
            })
            .collect();
        let components: Vec<Vec<f64>> = (0..6)
            .into_par_iter()
            .map(|stress| {
                let mut sum = vec![Complex::new(0.0, 0.0); torus.spectrum_len()];
                for (traction, load) in loads.iter().enumerate() {
                    let Some(load) = load else { continue };
                    let kernel = table.transform(&torus, stress, traction, first, shape);
                    for ((sum, kernel), load) in sum.iter_mut().zip(&kernel).zip(load) {
                        *sum += kernel * load;
                    }
                }
                torus.backward(sum, first, shape)
            })
            .collect();
        let stresses = (0..shape[0] * shape[1])
            .map(|e| Stress::from_components(std::array::from_fn(|stress| components[stress][e])))
            .collect();
        Some(PlaneStress { depth, stresses })
    }
}

/// The stresses at distances of whole elements, in the quadrant of x, y ≥ 0.
struct QuadrantTable {
    size: [usize; 2],
    blocks: Vec<StressBlock>,
}

impl QuadrantTable {
    /// Computes the stresses at every distance between a loaded element and a receiver.
    fn new(
        kernels: &StressKernels,
        below: &Subsurface<'_>,
        window: [&std::ops::Range<usize>; 2],
    ) -> Self {
        let fields = below.fields;
        let size =
            [0, 1].map(|i| window[i].end.max(fields.shape[i] as usize - window[i].start).max(1));
        let half_sides = fields.element.map(|side| 0.5 * side);
        let blocks = (0..size[0] * size[1])
            .into_par_iter()
            .with_min_len(16)
            .map(|index| {
                let offset = [index % size[0], index / size[0]];
                let receiver = [0, 1].map(|i| offset[i] as f64 * fields.element[i]);
                kernels.stresses(receiver, half_sides)
            })
            .collect();
        Self { size, blocks }
    }

    /// Transforms the kernel of a stress under a traction: from the first loaded element to the
    /// receivers, which begin `first` elements before it.
    fn transform(
        &self,
        torus: &TorusTransform,
        stress: usize,
        traction: usize,
        first: [usize; 2],
        shape: [usize; 2],
    ) -> Vec<Complex<f64>> {
        let is_odd = |axis: usize| {
            let count = STRESS_AXES[stress].iter().filter(|of| **of == axis).count()
                + usize::from(TRACTION_AXES[traction] == axis);
            count % 2 == 1
        };
        // A place on the torus stands for a distance, or for one less a period.
        let distance = |axis: usize, place: usize| {
            let behind = torus.lengths[axis] - place;
            if place < shape[axis] - first[axis] {
                Some((place, 1.0))
            } else if behind < self.size[axis] {
                Some((behind, if is_odd(axis) { -1.0 } else { 1.0 }))
            } else {
                None
            }
        };
        torus.forward(|y, row| {
            let Some((dy, sign_y)) = distance(1, y) else { return };
            let blocks = &self.blocks[dy * self.size[0]..][..self.size[0]];
            for (x, value) in row.iter_mut().enumerate() {
                if let Some((dx, sign_x)) = distance(0, x) {
                    *value = sign_x * sign_y * blocks[dx][stress][traction];
                }
            }
        })
    }
}

/// Transforms of real fields on a torus; a spectrum is stored by columns.
struct TorusTransform {
    lengths: [usize; 2],
    row_forward: Arc<dyn RealToComplex<f64>>,
    row_backward: Arc<dyn ComplexToReal<f64>>,
    column_forward: Arc<dyn Fft<f64>>,
    column_backward: Arc<dyn Fft<f64>>,
}

impl TorusTransform {
    fn new(lengths: [usize; 2]) -> Self {
        Self {
            lengths,
            row_forward: primitives::real_transform(lengths[0]),
            row_backward: primitives::real_inverse_transform(lengths[0]),
            column_forward: primitives::complex_transform(lengths[1]),
            column_backward: primitives::complex_inverse_transform(lengths[1]),
        }
    }

    fn spectrum_len(&self) -> usize {
        (self.lengths[0] / 2 + 1) * self.lengths[1]
    }

    /// Transforms a field whose rows `fill` writes into zeros.
    fn forward(&self, fill: impl Fn(usize, &mut [f64])) -> Vec<Complex<f64>> {
        let [width, height] = self.lengths;
        let mut spectrum = vec![Complex::new(0.0, 0.0); self.spectrum_len()];
        let mut row = vec![0.0; width];
        let mut waves = self.row_forward.make_output_vec();
        for y in 0..height {
            row.fill(0.0);
            fill(y, &mut row);
            if row.iter().all(|value| *value == 0.0) {
                continue;
            }
            let done = self.row_forward.process(&mut row, &mut waves);
            debug_assert!(done.is_ok());
            for (x, wave) in waves.iter().enumerate() {
                spectrum[x * height + y] = *wave;
            }
        }
        self.column_forward.process(&mut spectrum);
        spectrum
    }

    /// Transforms a spectrum back, and returns the receivers' rows, which begin `first` elements
    /// before the torus does.
    fn backward(
        &self,
        mut spectrum: Vec<Complex<f64>>,
        first: [usize; 2],
        shape: [usize; 2],
    ) -> Vec<f64> {
        let [width, height] = self.lengths;
        self.column_backward.process(&mut spectrum);
        let gain = (width * height) as f64;
        let mut out = vec![0.0; shape[0] * shape[1]];
        let mut row = vec![0.0; width];
        let mut waves = self.row_backward.make_input_vec();
        for (j, out) in out.chunks_exact_mut(shape[0]).enumerate() {
            let y = (j + height - first[1]) % height;
            for (x, wave) in waves.iter_mut().enumerate() {
                *wave = spectrum[x * height + y];
            }
            // The imaginary part is zero except for rounding, as a real field's must be.
            waves[0].im = 0.0;
            if width.is_multiple_of(2) {
                waves[width / 2].im = 0.0;
            }
            let done = self.row_backward.process(&mut waves, &mut row);
            debug_assert!(done.is_ok());
            for (i, out) in out.iter_mut().enumerate() {
                *out = row[(i + width - first[0]) % width] / gain;
            }
        }
        out
    }
}
