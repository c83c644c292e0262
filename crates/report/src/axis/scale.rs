//! The range of an axis and the position of a value in it.

/// The largest magnitude that is drawn: differences of larger values would overflow.
pub(crate) const LARGEST: f64 = 1e290;

/// Says whether a value has a position on an axis at all.
pub(crate) fn drawable(x: f64, log: bool) -> bool {
    x.abs() <= LARGEST && (!log || x > 1.0 / LARGEST)
}

/// The range of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisScale {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) log: bool,
}

impl AxisScale {
    /// Makes the range that runs exactly from `low` to `high`, widened if they are equal.
    pub(crate) fn exact(low: f64, high: f64) -> AxisScale {
        let magnitude = low.abs().max(high.abs());
        if high - low > 1e-9 * magnitude && high - low > 1.0 / LARGEST {
            AxisScale { low, high, log: false }
        } else if magnitude > 1.0 / LARGEST {
            AxisScale { low: low - 0.1 * magnitude, high: high + 0.1 * magnitude, log: false }
        } else {
            AxisScale { low: -1.0, high: 1.0, log: false }
        }
    }

    /// Makes a range with room around the values. Without any drawable value it runs from 0 to 1,
    /// or from 1 to 10 if it is logarithmic.
    pub(crate) fn around(values: impl Iterator<Item = f64>, log: bool) -> AxisScale {
        let (low, high) = values
            .filter(|x| drawable(*x, log))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        if log {
            if low > high {
                return AxisScale { low: 1.0, high: 10.0, log };
            }
            let decades = high.log10() - low.log10();
            // Two values a factor 1 + 10⁻⁹ apart are one value; ten decades of room do not
            // overflow.
            let room = if decades > 1e-9 { 10f64.powf((0.05 * decades).min(10.0)) } else { 2.0 };
            return AxisScale { low: low / room, high: high * room, log };
        }
        if low > high {
            return AxisScale { low: 0.0, high: 1.0, log };
        }
        let tight = AxisScale::exact(low, high);
        let room = if tight.low == low { 0.05 * (high - low) } else { 0.0 };
        // An axis that nearly reaches zero shows it.
        let low = if low > 0.0 && low < 0.35 * high { 0.0 } else { tight.low - room };
        AxisScale { low, high: tight.high + room, log }
    }

    /// Returns the position of a value: 0 at the low end, 1 at the high end.
    pub(crate) fn fraction(&self, x: f64) -> f64 {
        if self.log {
            (x.ln() - self.low.ln()) / (self.high.ln() - self.low.ln())
        } else {
            (x - self.low) / (self.high - self.low)
        }
    }
}
