//! A table as columns of values of one type each.

use report::{Cell, CellType, DataTable, TypedColumn};

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum TypedValues {
    /// True or false; a missing one is false, and `missing` says where.
    Flag {
        /// The values.
        values: Vec<bool>,
        /// The fact that a value is missing, for each of them.
        missing: Vec<bool>,
    },
    /// Whole numbers; a missing one is 0, and `missing` says where.
    Integer {
        /// The numbers.
        values: Vec<i64>,
        /// The fact that a number is missing, for each of them.
        missing: Vec<bool>,
    },
    /// Numbers; a missing one is NaN, and `missing` says where.
    Number {
        /// The numbers.
        values: Vec<f64>,
        /// The fact that a number is missing, for each of them.
        missing: Vec<bool>,
    },
    /// Texts.
    Text(Vec<Option<String>>),
}

impl TypedValues {
    fn of(cells: CellType) -> Self {
        match cells {
            CellType::Flag => TypedValues::Flag { values: Vec::new(), missing: Vec::new() },
            CellType::Integer => TypedValues::Integer { values: Vec::new(), missing: Vec::new() },
            CellType::Number => TypedValues::Number { values: Vec::new(), missing: Vec::new() },
            CellType::Text => TypedValues::Text(Vec::new()),
        }
    }

    /// Adds a cell; one that the type cannot hold widens it.
    fn push(&mut self, cell: &Cell) {
        match (&mut *self, cell) {
            (TypedValues::Flag { values, missing }, Cell::Flag(value)) => {
                values.push(*value);
                missing.push(false);
            }
            (TypedValues::Flag { values, missing }, Cell::Missing) => {
                values.push(false);
                missing.push(true);
            }
            (TypedValues::Integer { values, missing }, Cell::Integer(value)) => {
                values.push(*value);
                missing.push(false);
            }
            (TypedValues::Integer { values, missing }, Cell::Missing) => {
                values.push(0);
                missing.push(true);
            }
            (TypedValues::Number { values, missing }, Cell::Number(value)) => {
                values.push(*value);
                missing.push(false);
            }
            (TypedValues::Number { values, missing }, Cell::Integer(value)) => {
                values.push(*value as f64);
                missing.push(false);
            }
            (TypedValues::Number { values, missing }, Cell::Missing) => {
                values.push(f64::NAN);
                missing.push(true);
            }
            (TypedValues::Text(values), cell) => {
                values.push(cell.exact().map(std::borrow::Cow::into_owned));
            }
            (TypedValues::Integer { .. }, Cell::Number(_)) => {
                self.widen(CellType::Number);
                self.push(cell);
            }
            (TypedValues::Flag { .. }, _) | (_, Cell::Flag(_) | Cell::Text(_)) => {
                // A mesh may be a pair at some point, which is a text.
                self.widen(CellType::Text);
                self.push(cell);
            }
        }
    }

    fn widen(&mut self, cells: CellType) {
        let mut wider = TypedValues::of(cells);
        match self {
            TypedValues::Flag { values, missing } => {
                for (value, missing) in values.iter().zip(missing) {
                    wider.push(&if *missing { Cell::Missing } else { Cell::Flag(*value) });
                }
            }
            TypedValues::Integer { values, missing } => {
                for (value, missing) in values.iter().zip(missing) {
                    wider.push(&if *missing { Cell::Missing } else { Cell::Integer(*value) });
                }
            }
            TypedValues::Number { values, missing } => {
                for (value, missing) in values.iter().zip(missing) {
                    wider.push(&if *missing { Cell::Missing } else { Cell::Number(*value) });
                }
            }
            TypedValues::Text(_) => return,
        }
        *self = wider;
    }
}

/// A table with the meaning of each column.
pub struct TypedTable {
    /// The columns.
    pub columns: Vec<TypedColumn>,
    /// The values of each.
    pub values: Vec<TypedValues>,
}

impl TypedTable {
    /// Makes a table without rows.
    pub(crate) fn new(columns: Vec<TypedColumn>) -> Self {
        let values = columns.iter().map(|column| TypedValues::of(column.cells)).collect();
        Self { columns, values }
    }

    /// Adds the rows of a table that has the same columns.
    pub(crate) fn add(&mut self, rows: &DataTable) {
        for row in rows.rows() {
            self.values.iter_mut().zip(row).for_each(|(values, cell)| values.push(cell));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use report::TableColumn;

    #[test]
    fn a_column_widens_to_what_its_cells_are() {
        let head = || TableColumn::new("mesh", "");
        let column =
            TypedColumn { head: head(), meaning: "elements".to_owned(), cells: CellType::Integer };
        let mut table = TypedTable::new(vec![column.clone()]);
        let mut add = |cells: Vec<Cell>| {
            let rows = cells.into_iter().map(|cell| vec![cell]).collect();
            table.add(&DataTable::new(vec![head()], rows).unwrap());
            table.values[0].clone()
        };
        assert_eq!(
            add(vec![Cell::Integer(8), Cell::Missing]),
            TypedValues::Integer { values: vec![8, 0], missing: vec![false, true] }
        );
        let flags = TypedColumn { cells: CellType::Flag, ..column.clone() };
        let mut of_flags = TypedTable::new(vec![flags]);
        let rows = [Cell::Flag(true), Cell::Missing].map(|cell| vec![cell]).to_vec();
        of_flags.add(&DataTable::new(vec![head()], rows).unwrap());
        let expected = TypedValues::Flag { values: vec![true, false], missing: vec![false, true] };
        assert_eq!(of_flags.values, [expected]);
        of_flags.add(&DataTable::new(vec![head()], vec![vec![Cell::Integer(1)]]).unwrap());
        let texts = ["true", "", "1"].map(|text| (!text.is_empty()).then(|| text.to_owned()));
        assert_eq!(of_flags.values, [TypedValues::Text(texts.to_vec())]);
        let TypedValues::Number { values, missing } = add(vec![Cell::Number(0.5)]) else {
            panic!("numbers")
        };
        assert!(values[0] == 8.0 && values[1].is_nan() && values[2] == 0.5);
        assert_eq!(missing, [false, true, false]);
        let texts = add(vec![Cell::Text("8x12".to_owned())]);
        let expected = [Some("8.0"), None, Some("0.5"), Some("8x12")];
        assert_eq!(texts, TypedValues::Text(expected.map(|text| text.map(str::to_owned)).to_vec()));
    }
}
