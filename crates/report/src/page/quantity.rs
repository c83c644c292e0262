//! Numbers in sentences.

use crate::number::significant;
use crate::unit::PrefixedUnit;

/// Writes a number in an SI unit with a prefix that suits it, to four digits: `2.5 GPa`.
pub fn quantity_words(x: f64, unit: &str) -> String {
    let unit = PrefixedUnit::fitting(unit, x.abs());
    let number = significant(unit.of_si(x), 4);
    match unit.name.as_str() {
        "" | "1" => number,
        name => format!("{number} {name}"),
    }
}
