//! The bounds of the numbers that may stand behind a key. A test holds those of every key against
//! what is refused.

use std::f64::consts::FRAC_PI_2;

use crate::units::Compact;

/// One end of a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bound {
    /// No end.
    Free,
    /// An end that is allowed itself.
    Closed(f64),
    /// An end that is not allowed itself.
    Open(f64),
}

/// The numbers that have a meaning behind a key, in SI units; of a list, the numbers of entries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) lower: Bound,
    pub(crate) upper: Bound,
    /// True if 0 is not allowed although it lies within.
    pub(crate) skips_zero: bool,
}

/// All numbers.
pub(crate) const ANY: Bounds = Bounds { lower: Bound::Free, upper: Bound::Free, skips_zero: false };

/// All numbers but 0.
pub(crate) const NOT_ZERO: Bounds = Bounds { skips_zero: true, ..ANY };

/// The numbers above 0.
pub(crate) const POSITIVE: Bounds = Bounds { lower: Bound::Open(0.0), ..ANY };

/// Returns the numbers that are not below one.
pub(crate) const fn from(least: f64) -> Bounds {
    Bounds { lower: Bound::Closed(least), ..ANY }
}

/// Returns the numbers that are not above one.
pub(crate) const fn up_to(most: f64) -> Bounds {
    Bounds { upper: Bound::Closed(most), ..ANY }
}

/// Returns the numbers between two and those two.
pub(crate) const fn within(least: f64, most: f64) -> Bounds {
    Bounds { upper: Bound::Closed(most), ..from(least) }
}

/// Returns the numbers between two without those two.
pub(crate) const fn inside(lower: f64, upper: f64) -> Bounds {
    Bounds { lower: Bound::Open(lower), upper: Bound::Open(upper), skips_zero: false }
}

impl Bounds {
    /// Returns whether a number lies within.
    pub(crate) fn hold(self, x: f64) -> bool {
        let is_above = match self.lower {
            Bound::Free => true,
            Bound::Closed(least) => x >= least,
            Bound::Open(lower) => x > lower,
        };
        let is_below = match self.upper {
            Bound::Free => true,
            Bound::Closed(most) => x <= most,
            Bound::Open(upper) => x < upper,
        };
        is_above && is_below && !(self.skips_zero && x == 0.0)
    }

    /// Describes them, to stand behind a noun: `above 0`, `from 0 to 0.5`; empty without bounds.
    pub(crate) fn words(self, unit: &str) -> String {
        let shown = |x: f64| {
            let number = if x == FRAC_PI_2 { "π/2".to_owned() } else { Compact(x).to_string() };
            if x == 0.0 || unit.is_empty() { number } else { format!("{number} {unit}") }
        };
        match (self.lower, self.upper) {
            _ if self.skips_zero => "other than 0".to_owned(),
            (Bound::Free, Bound::Free) => String::new(),
            (Bound::Closed(a), Bound::Closed(b)) => format!("from {} to {}", shown(a), shown(b)),
            (Bound::Open(a), Bound::Open(b)) => format!("above {}, below {}", shown(a), shown(b)),
            (Bound::Closed(a), Bound::Open(b)) => format!("from {}, below {}", shown(a), shown(b)),
            (Bound::Open(a), Bound::Closed(b)) => {
                format!("above {}, at most {}", shown(a), shown(b))
            }
            (Bound::Closed(a), Bound::Free) => format!("of {} or more", shown(a)),
            (Bound::Open(a), Bound::Free) => format!("above {}", shown(a)),
            (Bound::Free, Bound::Closed(b)) => format!("up to {}", shown(b)),
            (Bound::Free, Bound::Open(b)) => format!("below {}", shown(b)),
        }
    }
}
