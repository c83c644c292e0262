//! The colours of values and of states.

use super::quantity::Values;
use crate::axis::{AxisScale, drawable};
use crate::palette::COLORS;

/// The colours of values between two limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shade {
    pub(super) low: f64,
    pub(super) high: f64,
    /// True if zero lies in the middle and has a colour of its own.
    signed: bool,
}

impl Shade {
    /// Fits the limits to the finite values. They are symmetrical about zero if both signs matter.
    pub(super) fn for_values(values: &[f64]) -> Shade {
        let (low, high) = values
            .iter()
            .filter(|x| drawable(**x, false))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
        let largest = low.abs().max(high.abs());
        if low > high {
            Shade { low: 0.0, high: 1.0, signed: false }
        } else if low < -0.02 * largest && high > 0.02 * largest {
            Shade { low: -largest, high: largest, signed: true }
        } else {
            let widened = AxisScale::exact(low, high);
            Shade { low: widened.low, high: widened.high, signed: false }
        }
    }

    /// Returns true if zero has a colour of its own.
    pub(super) fn is_signed(&self) -> bool {
        self.signed
    }

    /// Returns the position of a value: 0 at the low limit, 1 at the high one.
    pub(super) fn fraction(&self, x: f64) -> f64 {
        ((x - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// Returns the RGB colour of a position between the limits.
    pub(super) fn color(&self, fraction: f64) -> [u8; 3] {
        // Values of both signs run from blue for negative to red for positive ones, others from
        // dark to bright.
        let c = if self.signed {
            colorous::RED_BLUE.eval_continuous(1.0 - fraction)
        } else {
            colorous::VIRIDIS.eval_continuous(fraction)
        };
        [c.r, c.g, c.b]
    }
}

/// The colour of elements without a value.
pub(super) const NOTHING: [u8; 3] = [255, 255, 255];

/// Returns the colour of a state.
pub(super) fn state_color(state: usize) -> [u8; 3] {
    match state {
        0 => NOTHING,
        1 => [0xd9, 0xd9, 0xd9],
        _ => {
            let hex = COLORS[(state - 2) % COLORS.len()];
            [1, 3, 5].map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap_or(0))
        }
    }
}

/// Returns the colours of all elements, in the order of the values.
pub(super) fn colors(values: &Values) -> Vec<[u8; 3]> {
    match values {
        Values::Number(numbers) => {
            let shade = Shade::for_values(numbers);
            let color = |x: &f64| {
                if drawable(*x, false) { shade.color(shade.fraction(*x)) } else { NOTHING }
            };
            numbers.iter().map(color).collect()
        }
        Values::Category { states, .. } => {
            states.iter().map(|&state| state_color(usize::from(state))).collect()
        }
    }
}
