//! Fields as small integers, for pages.

use super::color::{Shade, state_color};
use super::quantity::{Field, FieldGrid, Values};
use crate::axis::drawable;

/// The values of a field as small integers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FieldCodes {
    /// A quantity. Code 0 is an element without a value; the codes from 1 to the largest one stand
    /// for equal steps from the least to the largest value.
    Number {
        /// The least value, in the SI unit of the field.
        low: f64,
        /// The largest value.
        high: f64,
        /// The values at the ends of the scale of colours.
        shade: [f64; 2],
        /// True if the colours tell positive from negative values.
        is_signed: bool,
        /// The codes, of two bytes the lower one first; empty if all values are equal.
        codes: Vec<u8>,
    },
    /// States, as they are.
    Category {
        /// The state of each element.
        states: Vec<u8>,
        /// The names of the states.
        names: Vec<String>,
    },
}

impl Field {
    /// Returns the name.
    pub fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn unit(&self) -> &str {
        &self.unit
    }

    pub(crate) fn grid(&self) -> FieldGrid {
        self.grid
    }

    /// Codes the values with 8 or 16 bits each.
    pub(crate) fn codes(&self, bits: u32) -> FieldCodes {
        let numbers = match &self.values {
            Values::Category { states, names } => {
                return FieldCodes::Category { states: states.clone(), names: names.clone() };
            }
            Values::Number(numbers) => numbers,
        };
        let shade = Shade::for_values(numbers);
        let drawn = || numbers.iter().copied().filter(|x| drawable(*x, false));
        let (low, high) = drawn()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        let (low, high) = if low > high { (0.0, 0.0) } else { (low, high) };
        let largest = f64::from((1u32 << bits) - 2);
        let code = |x: &f64| -> u16 {
            if drawable(*x, false) {
                1 + ((x - low) / (high - low) * largest).round() as u16
            } else {
                0
            }
        };
        let mut codes = Vec::new();
        if high > low {
            let pairs = numbers.iter().map(code);
            match bits {
                8 => codes.extend(pairs.map(|code| code as u8)),
                _ => codes.extend(pairs.flat_map(u16::to_le_bytes)),
            }
        }
        let is_signed = shade.is_signed();
        FieldCodes::Number { low, high, shade: [shade.low, shade.high], is_signed, codes }
    }
}

/// The number of colours of a scale.
const COLORS: usize = 64;

/// Returns the scales of colours as RGB in hexadecimal digits: of values of one sign, of values of
/// both, and of states, of which the first is no colour.
pub(crate) fn scales() -> [Vec<String>; 3] {
    let hex = |[r, g, b]: [u8; 3]| format!("{r:02x}{g:02x}{b:02x}");
    let scale = |values: &[f64]| {
        let shade = Shade::for_values(values);
        (0..COLORS).map(|i| hex(shade.color(i as f64 / (COLORS - 1) as f64))).collect()
    };
    let states =
        (0..8).map(|state| if state == 0 { String::new() } else { hex(state_color(state)) });
    [scale(&[0.0, 1.0]), scale(&[-1.0, 1.0]), states.collect()]
}
