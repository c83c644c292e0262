//! The wear along a path: Archard's law in each increment, the depth on the material as it stands
//! or passes through, and the shape that is left.

use crate::influence::Diagonals;
use crate::model::{Fields, State, Wear, Worn};
use crate::problem::Problem;

/// The way that the material of the foundation goes through Ω in an increment, with the distance
/// along x that the contact goes on, positive towards +x \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MaterialMotion {
    /// The material stays where it is.
    Still,
    /// The material passes, and brings along what it has lost.
    Transient(f64),
    /// The material passes and has always passed in the same way.
    Steady(f64),
}

/// The wear of a path on one grid, as far as it has been followed.
#[derive(Clone, Debug)]
pub(crate) struct Wearing {
    wear: Wear,
    /// The depth at each element \[m\].
    pub(crate) depth: Vec<f64>,
    /// The wear of each increment so far.
    pub(crate) increments: Vec<Worn>,
}

/// The largest part of an element's own compliance by which the shape may yield to its pressure in
/// an increment. The pressure answers to a depth by A⁻¹, whose largest eigenvalue is about 3.2 over
/// A's diagonal entry in the average projection (a chequerboard). Below this part no mode of the
/// pressure overshoots.
const MOST: f64 = 0.3;

impl Wearing {
    pub(crate) fn new(wear: Wear) -> Self {
        Self { wear, depth: Vec::new(), increments: Vec::new() }
    }

    /// Adds what an increment with these `fields` wears, in the cycle of this number. The pressure
    /// is that at its end, as in the law of friction, so that the volume is k/μ times the energy
    /// lost. If the shape is updated, the gap of `problem` becomes the one that the increment
    /// leaves. `diagonal` has the diagonal entries of A.
    ///
    /// # Errors
    /// A reason in words says why what is worn away leaves no shape that a path could go on with.
    pub(crate) fn add(
        &mut self,
        problem: &mut Problem,
        fields: &Fields,
        cycle: u32,
        motion: MaterialMotion,
        diagonal: Diagonals,
    ) -> Result<(), String> {
        let Wear { coefficient, update, .. } = self.wear;
        let repeated = coefficient * self.wear.repetitions(cycle);
        let slip = sliding(problem, fields);
        let worn: Vec<f64> =
            slip.iter().zip(&fields.pressure).map(|(slip, p)| repeated * p * slip).collect();
        let [width, height] = fields.element;
        let nx = fields.shape[0] as usize;
        let volume = worn.iter().sum::<f64>() * (width * height);
        self.depth.resize(worn.len(), 0.0);
        match motion {
            MaterialMotion::Still => {}
            MaterialMotion::Transient(distance) => {
                self.depth = carried(&self.depth, nx, distance / width);
            }
            MaterialMotion::Steady(distance) => {
                self.depth = passed(&worn, nx, distance.is_sign_positive());
                self.depth.iter_mut().for_each(|depth| *depth *= width / distance.abs());
            }
        }
        if !matches!(motion, MaterialMotion::Steady(_)) {
            self.depth.iter_mut().zip(&worn).for_each(|(depth, worn)| *depth += worn);
        }
        let deepest = self.depth.iter().copied().fold(0.0, f64::max);
        self.increments.push(Worn { depth: deepest, volume });
        if !(self.depth.iter().all(|depth| depth.is_finite()) && volume.is_finite()) {
            return Err(format!(
                "what is worn away is beyond the range of double precision: wear.coefficient = \
                 {coefficient:e} 1/Pa is too large"
            ));
        }
        if !update {
            return Ok(());
        }
        let most = MOST * diagonal.normal * problem.scale.length / problem.scale.traction();
        let yielding = repeated * slip.iter().copied().fold(0.0, f64::max);
        if yielding > most {
            return Err(format!(
                "the shape would yield to pressure by {yielding:.1e} m/Pa in the increment, and the \
                 pressure follows it up to {most:.1e} m/Pa, {MOST} of the compliance of an element: \
                 take more increments, a smaller `wear.repeat`, or a coarser mesh"
            ));
        }
        problem.wear_off(&worn);
        Ok(())
    }
}

/// Returns the distance over which each element slides in an increment \[m\]: that against which
/// its traction works. Elements that stick, whose slip is what the solver has left of 0, slide over
/// none.
fn sliding(problem: &Problem, fields: &Fields) -> Vec<f64> {
    let regularised = problem.epsilon * problem.scale.length / problem.scale.traction();
    let slip = |e: usize| {
        let [x, y] = [
            fields.slip_x[e] + regularised * fields.traction_x[e],
            fields.slip_y[e] + regularised * fields.traction_y[e],
        ];
        x.hypot(y)
    };
    let of_element =
        |(e, state): (usize, &u8)| if *state == State::Slip as u8 { slip(e) } else { 0.0 };
    fields.state.iter().enumerate().map(of_element).collect()
}

/// Returns the depths at the elements of rows of `nx`, of material that stood so many `elements`
/// towards +x before. Between elements it is shared by the two, so that the volume stays; what
/// comes from outside of Ω is unworn.
fn carried(depth: &[f64], nx: usize, elements: f64) -> Vec<f64> {
    let nearest = elements.round();
    let is_whole = (elements - nearest).abs() <= 1e-9 * nearest.abs().max(1.0);
    let elements = if is_whole { nearest } else { elements };
    let share = elements - elements.floor();
    let mut moved = vec![0.0; depth.len()];
    for (row, moved) in depth.chunks_exact(nx.max(1)).zip(moved.chunks_exact_mut(nx.max(1))) {
        let of = |column: f64| {
            if (0.0..nx as f64).contains(&column) { row[column as usize] } else { 0.0 }
        };
        for (i, moved) in moved.iter_mut().enumerate() {
            let from = i as f64 + elements.floor();
            *moved = (1.0 - share) * of(from) + share * of(from + 1.0);
        }
    }
    moved
}

/// Returns the sums of `worn` over each element and those ahead of it, row by row.
fn passed(worn: &[f64], nx: usize, is_forward: bool) -> Vec<f64> {
    let mut sums = worn.to_vec();
    for row in sums.chunks_exact_mut(nx.max(1)) {
        if is_forward {
            row.reverse();
        }
        let mut sum = 0.0;
        for depth in row.iter_mut() {
            sum += *depth;
            *depth = sum;
        }
        if is_forward {
            row.reverse();
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows of four elements.
    const DEPTH: [f64; 8] = [0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 4.0, 0.0];

    #[test]
    fn material_passes_with_its_wear_and_keeps_the_volume() {
        let volume = |depth: &[f64]| depth.iter().sum::<f64>();
        assert_eq!(carried(&DEPTH, 4, 1.0), [1.0, 2.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
        assert_eq!(carried(&DEPTH, 4, -1.0), [0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 4.0]);
        assert_eq!(carried(&DEPTH, 4, 1.0 + 1e-13), carried(&DEPTH, 4, 1.0));
        assert_eq!(carried(&DEPTH, 4, 0.25), [0.25, 1.25, 1.5, 0.0, 0.0, 1.0, 3.0, 0.0]);
        for elements in [0.25, 0.5, -0.75, 0.0, -1.0, 1.0] {
            assert_eq!(volume(&carried(&DEPTH, 4, elements)), volume(&DEPTH), "{elements}");
        }
        // Whatever leaves Ω is gone, however far the contact goes.
        for elements in [4.0, -4.0, 1e300, -1e300, f64::MAX] {
            assert_eq!(carried(&DEPTH, 4, elements), [0.0; 8], "{elements}");
        }
    }

    #[test]
    fn steady_wear_sums_from_the_leading_edge() {
        assert_eq!(passed(&DEPTH, 4, true), [3.0, 3.0, 2.0, 0.0, 4.0, 4.0, 4.0, 0.0]);
        assert_eq!(passed(&DEPTH, 4, false), [0.0, 1.0, 3.0, 3.0, 0.0, 0.0, 4.0, 4.0]);
    }
}
