//! Mutated filters.

use report::{Cell, DataTable, TableColumn};

use crate::mutation::{Dice, mutated};

const GOOD: &[&str] = &[
    "mu > 0.3 && mesh == 64",
    "status == \"certified\" || !(load != null)",
    "abs(load - 3.5e-2) <= 1e-6 * load ? mu in [0.1, 0.2] : punch.contains('x')",
    "punch.startsWith(\"a\") && friction.mu % 2 == 1",
    "-mu * 3 + mesh / 2 < 1 && punch.endsWith('é')",
];

const DICTIONARY: &[&str] = &[
    "mu",
    "mesh",
    "load",
    "status",
    "punch",
    "friction.mu",
    "null",
    "true",
    "false",
    "&&",
    "||",
    "!",
    "==",
    "!=",
    "<=",
    ">",
    "+",
    "-",
    "*",
    "/",
    "%",
    "?",
    ":",
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    "in",
    "abs(",
    ".contains(",
    ".startsWith(",
    ".matches(",
    "has(",
    "size(",
    "\"",
    "'",
    "\"a\"",
    "0",
    "-1",
    "1e308",
    "1e999",
    "9223372036854775807",
    "9223372036854775808",
    "-9223372036854775808",
    "0x1F",
    "1u",
    "0.1",
    ".5",
    "5.",
    "NaN",
    "inf",
    "b\"a\"",
    "r\"a\"",
    "\"\\u0000\"",
    "\"\\x41\"",
    "// c",
    "\n",
    "\u{1b}[2J",
    "\u{202e}",
    "é",
    "[].all(x, x)",
    "[1].map(x, x + 1)",
    "{1: 2}",
    "a.b.c.d",
    "a[0]",
    "type(1)",
    "duration('1s')",
];

/// Makes a filter.
pub(crate) fn text(dice: &mut Dice) -> String {
    let good = dice.pick(GOOD);
    mutated(good, DICTIONARY, GOOD, dice)
}

/// Filters a table, and returns whether the filter was accepted.
pub(crate) fn read(text: &str) -> bool {
    let columns = ["mu", "mesh", "load", "status", "punch", "friction.mu"]
        .map(|name| TableColumn::new(name, ""))
        .to_vec();
    let rows = vec![
        vec![0.1.into(), 64.into(), 3.5e-2.into(), "certified".into(), "ax".into(), 0.1.into()],
        vec![0.4.into(), 8.into(), Cell::Missing, "failed".into(), "é".into(), 1.into()],
        vec![
            f64::NAN.into(),
            i64::MIN.into(),
            f64::INFINITY.into(),
            "".into(),
            "x".into(),
            0.into(),
        ],
    ];
    let table = DataTable::new(columns, rows).expect("the table is sound");
    match table.filter(text) {
        Ok(_) => true,
        Err(error) => {
            assert!(error.to_string().len() < 1 << 16, "the message is too long");
            false
        }
    }
}
