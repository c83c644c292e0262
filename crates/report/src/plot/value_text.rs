//! The text of values that tell curves and panels apart: `8 GPa`, `0.1 mm`.

use std::collections::HashSet;

use crate::number::{decade, exact, power_of_ten, trim_zeros};
use crate::table::{Cell, DataTable};
use crate::unit::PrefixedUnit;

/// The significant digits that are written at least, and at most so that no two values look alike.
const DIGITS: [usize; 2] = [4, 6];

/// The way to write the values of one column: all in one unit, and as short as tells them apart.
pub(super) struct ValueFormat {
    unit: PrefixedUnit,
    digits: usize,
}

impl ValueFormat {
    /// Fits the unit and the digits to the values of a column.
    pub(super) fn for_column(table: &DataTable, column: usize) -> ValueFormat {
        let numbers = || table.cells(column).filter_map(Cell::number).filter(|x| x.is_finite());
        let texts = table.cells(column).any(|cell| matches!(cell, Cell::Flag(_) | Cell::Text(_)));
        let largest = numbers().map(f64::abs).fold(0.0, f64::max);
        let unit = if texts {
            PrefixedUnit::plain("")
        } else {
            PrefixedUnit::fitting(&table.columns()[column].unit, largest)
        };
        let distinct = |digits: usize| {
            numbers().map(|x| short(unit.of_si(x), digits)).collect::<HashSet<_>>().len()
        };
        let [least, most] = DIGITS;
        let all = distinct(most);
        let digits = (least..most).find(|digits| distinct(*digits) == all).unwrap_or(most);
        ValueFormat { unit, digits }
    }

    /// Writes a value of the column with its unit.
    pub(super) fn text(&self, cell: &Cell) -> String {
        let number = match cell {
            Cell::Flag(yes) => return yes.to_string(),
            Cell::Text(text) => return text.clone(),
            Cell::Missing => return "none".to_owned(),
            Cell::Integer(i) if self.unit.of_si(1.0) == 1.0 => i.to_string().replace('-', "−"),
            Cell::Integer(i) => short(self.unit.of_si(*i as f64), self.digits),
            Cell::Number(x) => short(self.unit.of_si(*x), self.digits),
        };
        match self.unit.name.as_str() {
            "" | "1" => number,
            unit => format!("{number} {unit}"),
        }
    }
}

/// Rounds a number to so many significant digits: `25.3`, `0.0001`, `2.5·10⁻⁷`.
fn short(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".to_owned() } else { exact(x) };
    }
    let leading = decade(x, digits);
    let number = if (-4..6).contains(&leading) {
        let decimals = usize::try_from(digits as i32 - 1 - leading).unwrap_or(0);
        trim_zeros(&format!("{x:.decimals$}")).to_owned()
    } else {
        let scientific = format!("{x:.*e}", digits - 1);
        match trim_zeros(
            scientific.split_once('e').map_or(scientific.as_str(), |(mantissa, _)| mantissa),
        ) {
            "1" => power_of_ten(leading),
            "-1" => format!("-{}", power_of_ten(leading)),
            mantissa => format!("{mantissa}·{}", power_of_ten(leading)),
        }
    };
    number.replacen('-', "−", 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::TableColumn;

    fn written(unit: &str, cells: &[Cell]) -> Vec<String> {
        let rows = cells.iter().map(|cell| vec![cell.clone()]).collect();
        let table = DataTable::new(vec![TableColumn::new("a", unit)], rows).unwrap();
        let written = ValueFormat::for_column(&table, 0);
        cells.iter().map(|cell| written.text(cell)).collect()
    }

    #[test]
    fn one_prefix_for_all_and_no_more_digits_than_needed() {
        let numbers =
            |numbers: &[f64]| numbers.iter().copied().map(Cell::Number).collect::<Vec<_>>();
        let cases: &[(&str, &[f64], &[&str])] = &[
            ("Pa", &[8e9, 25.298_221e9, 800e9], &["8 GPa", "25.3 GPa", "800 GPa"]),
            ("m", &[1e-4, 5e-4], &["100 µm", "500 µm"]),
            ("m", &[1e-4, 2e-3], &["0.1 mm", "2 mm"]),
            ("m", &[0.010_25, 0.02], &["10.25 mm", "20 mm"]),
            ("N", &[-150.0, 0.0, 150.0], &["−150 N", "0 N", "150 N"]),
            ("N", &[1.000_01, 1.000_02], &["1.00001 N", "1.00002 N"]),
            ("", &[1e-6, 1e-8, 2.5e-8, -1e-8], &["10⁻⁶", "10⁻⁸", "2.5·10⁻⁸", "−10⁻⁸"]),
            ("1", &[0.05, 1.0 / 3.0, 123_456.0], &["0.05", "0.3333", "123456"]),
            ("rad", &[2.4e-3], &["0.0024 rad"]),
        ];
        for (unit, values, texts) in cases {
            assert_eq!(written(unit, &numbers(values)), *texts);
        }
        assert_eq!(written("", &[16_i64.into(), 1_234_567_i64.into()]), ["16", "1234567"]);
        assert_eq!(written("s", &[2_i64.into(), Cell::Number(f64::INFINITY)]), ["2 s", "inf s"]);
        assert_eq!(
            written("Pa", &["soft".into(), 1e9.into(), Cell::Missing]),
            ["soft", "10⁹", "none"]
        );
    }
}
