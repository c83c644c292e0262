//! The wear along a path: Archard's law in each increment, the depth on the material as it stands
//! or passes through, and the shape that is left, as I. R. McColl, J. Ding and S. B. Leen follow it
//! for fretting (Wear 256, 1114–1127, 2004, doi:10.1016/j.wear.2003.07.001).

use super::worn_material::WornMaterial;
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
    /// The material with what it has lost.
    material: WornMaterial,
    /// The wear of each increment so far.
    pub(crate) increments: Vec<Worn>,
}

impl Wearing {
    /// Returns wear that begins on so many elements along x and y.
    pub(crate) fn new(wear: Wear, elements: [usize; 2]) -> Self {
        Self { wear, material: WornMaterial::new(elements), increments: Vec::new() }
    }

    /// Returns the depth at each element \[m\].
    pub(crate) fn depth(&self) -> Vec<f64> {
        self.material.depth()
    }

    /// Adds what an increment with these `fields` wears, in the cycle of this number. The pressure
    /// is that at its end, as in the law of friction, so that the volume is k/μ times the energy
    /// lost. If the shape is updated, the gap of `problem` becomes the one that the increment
    /// leaves. `least` is about the smallest eigenvalue of the normal block of A: the pressure
    /// answers to a depth by the inverse, so that up to this compliance no mode of it overshoots.
    ///
    /// # Errors
    /// A reason in words says why what is worn away leaves no shape that a path could go on with.
    pub(crate) fn add(
        &mut self,
        problem: &mut Problem,
        fields: &Fields,
        cycle: u32,
        motion: MaterialMotion,
        least: f64,
    ) -> Result<(), String> {
        let Wear { coefficient, .. } = self.wear;
        let repeated = coefficient * self.wear.repetitions(cycle);
        let slip = sliding(problem, fields);
        let worn: Vec<f64> =
            slip.iter().zip(&fields.pressure).map(|(slip, p)| repeated * p * slip).collect();
        let [width, height] = fields.element;
        let volume = worn.iter().sum::<f64>() * (width * height);
        match motion {
            MaterialMotion::Still => self.material.wear_still(&worn),
            MaterialMotion::Transient(distance) => {
                self.material.wear_passing(&worn, distance / width);
            }
            MaterialMotion::Steady(distance) => {
                self.material.wear_steadily(&worn, distance / width);
            }
        }
        self.increments.push(Worn { depth: self.material.largest(), volume });
        if !(self.material.is_finite() && volume.is_finite()) {
            return Err(format!(
                "what is worn away is beyond the range of double precision: wear.coefficient = \
                 {coefficient:e} 1/Pa is too large"
            ));
        }
        if !self.wear.changes_shape() {
            return Ok(());
        }
        let unit = problem.scale.length / problem.scale.traction();
        let most = (least + problem.epsilon) * unit;
        let yielding = repeated * slip.iter().copied().fold(0.0, f64::max);
        if yielding > most {
            return Err(format!(
                "the shape would yield to pressure by {yielding:.1e} m/Pa in the increment, and the \
                 pressure follows it up to {most:.1e} m/Pa, the mesh's smallest \
                 compliance: take more increments, a smaller `wear.repeat`, or a coarser mesh"
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
