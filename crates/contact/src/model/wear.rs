//! The wear that a scene asks for.

use serde::{Deserialize, Serialize};

use super::error::{SceneError, refuse};
use super::loading::Loading;

/// The wear of the surfaces by Archard's law: where they slip, they lose the depth k p |s| together
/// over the distance s, under the pressure p. A body with a coefficient k₁ of its own loses the
/// share k₁/k of every depth and volume.
///
/// Source: J. F. Archard, J. Appl. Phys. 24, 981–988 (1953), DOI 10.1063/1.1721448.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wear {
    /// The wear coefficient k ≥ 0 \[1/Pa\], the sum of those of both bodies. In the form K/H it is
    /// a pure number K over a hardness H.
    pub coefficient: f64,
    /// True if what is worn away changes the gap, so that each increment meets the shape that those
    /// before have left; false if the shape stays as it is.
    #[serde(default, skip_serializing_if = "is_false")]
    pub update: bool,
    /// The number of cycles that each cycle of the path stands for: it wears so many times as much.
    /// It is 1 where a cycle rolls.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub repeat: u32,
}

impl Wear {
    /// The largest number of cycles that one stands for.
    pub const MAX_CYCLES: u32 = 1_000_000;

    /// Returns whether the wear changes the shape that the path meets.
    pub(crate) fn changes_shape(&self) -> bool {
        self.update && self.coefficient > 0.0
    }

    /// Returns how often an increment of a cycle (0 is outside of one) counts.
    pub(crate) fn repetitions(&self, cycle: u32) -> f64 {
        if cycle > 0 { f64::from(self.repeat) } else { 1.0 }
    }

    /// Refuses wear without a mechanical meaning under the friction coefficient `mu`, along the
    /// path `loading`.
    pub(super) fn validate(&self, mu: f64, loading: &Loading) -> Result<(), SceneError> {
        let Self { coefficient, update, repeat } = *self;
        if !(coefficient.is_finite() && coefficient >= 0.0) {
            return Err(refuse(
                "wear.coefficient",
                coefficient,
                "must be a finite number, 0 or above",
            ));
        }
        if mu == 0.0 {
            return Err(refuse(
                "friction.mu",
                mu,
                "must be above 0 in a scene that wears: without friction no slip is computed",
            ));
        }
        let rolls = loading.steps.iter().position(|step| step.rolling.is_some());
        if let Some(step) = rolls.filter(|_| update) {
            let expected = format!(
                "must be false where loading.steps[{step}] rolls: the shape of a body that rolls \
                 changes all along its way, not only where the contact ends"
            );
            return Err(refuse("wear.update", true, &expected));
        }
        if !(1..=Self::MAX_CYCLES).contains(&repeat) {
            let expected = format!("must lie between 1 and {}", Self::MAX_CYCLES);
            return Err(refuse("wear.repeat", repeat, &expected));
        }
        if repeat > 1 && loading.cycle_from.is_none() {
            return Err(refuse(
                "wear.repeat",
                repeat,
                "needs a cycle: `loading.cycle_from` is the index of the step with which it begins",
            ));
        }
        let in_cycle = |step: &usize| loading.cycle_from.is_some_and(|from| *step >= from as usize);
        let steps = loading.steps.iter().enumerate();
        let mut rolling = steps.filter(|(_, step)| step.rolling.is_some()).map(|(index, _)| index);
        if let Some(step) = rolling.find(in_cycle).filter(|_| repeat > 1) {
            let expected = format!(
                "must be 1 where loading.steps[{step}] of the cycle rolls: the material goes on in \
                 each cycle, and meets none of those that one would stand for"
            );
            return Err(refuse("wear.repeat", repeat, &expected));
        }
        Ok(())
    }

    /// Returns the same wear with 0 in place of −0.
    pub fn normalised(self) -> Self {
        Self { coefficient: self.coefficient + 0.0, ..self }
    }
}

/// Returns whether a stored scene leaves out a choice.
fn is_false(choice: &bool) -> bool {
    !choice
}

/// Returns the count that a study file need not mention.
fn one() -> u32 {
    1
}

/// Returns whether a count need not be mentioned.
fn is_one(n: &u32) -> bool {
    *n == 1
}
