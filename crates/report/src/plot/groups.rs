//! Rows of a table by the values that tell panels and series apart.

use std::collections::HashMap;

use super::error::{FigureError, MOST_PANELS};
use super::spec::FigureSpec;
use super::value_text::ValueFormat;
use crate::table::{Cell, DataTable};

/// The distinct combinations of the values of some columns.
pub(super) struct Groups {
    /// The combinations as text, sorted by value.
    pub(super) labels: Vec<String>,
    /// The index of the combination that each row has.
    pub(super) of_row: Vec<usize>,
}

impl Groups {
    pub(super) fn new(table: &DataTable, columns: &[usize]) -> Groups {
        let names: Vec<String> = columns.iter().map(|&i| table.columns()[i].name.clone()).collect();
        let formats: Vec<(usize, ValueFormat)> =
            columns.iter().map(|&i| (i, ValueFormat::for_column(table, i))).collect();
        // Sorted by value and not as text: 8 comes before 16.
        let sorted = table.sort(&names).unwrap_or_else(|_| table.clone());
        let label = |row: &[Cell]| {
            formats.iter().map(|(i, format)| format.text(&row[*i])).collect::<Vec<_>>().join(", ")
        };
        let mut labels: Vec<String> = Vec::new();
        let mut index = HashMap::new();
        for row in sorted.rows() {
            let label = label(row);
            index.entry(label.clone()).or_insert_with(|| {
                labels.push(label);
                labels.len() - 1
            });
        }
        let of_row =
            table.rows().iter().map(|row| index.get(&label(row)).copied().unwrap_or(0)).collect();
        Groups { labels, of_row }
    }

    /// Groups the rows by the panels of a figure, of which `column` tells them apart.
    pub(super) fn panels(
        table: &DataTable,
        spec: &FigureSpec<'_>,
        column: Option<usize>,
    ) -> Result<Groups, FigureError> {
        let panels = Groups::new(table, column.as_slice());
        match spec.panels {
            Some(name) if panels.labels.len() > MOST_PANELS => Err(FigureError::TooManyPanels {
                column: name.to_owned(),
                count: panels.labels.len(),
            }),
            _ => Ok(panels),
        }
    }

    /// Returns the title of the panel of an index, of which `column` tells the panels apart.
    pub(super) fn panel_title(
        &self,
        panel: usize,
        table: &DataTable,
        spec: &FigureSpec<'_>,
        column: Option<usize>,
    ) -> String {
        let value = &self.labels[panel];
        let text = column.and_then(|column| text_in(table, column));
        match (spec.panels, text) {
            (None, _) => String::new(),
            (Some(name), None) => format!("{} = {value}", spec.label(name)),
            (Some(name), Some(_)) => format!("{}: {value}", spec.label(name)),
        }
    }
}

/// Returns the numbers of a column, NaN where there is none.
pub(super) fn numbers(table: &DataTable, column: usize) -> Vec<f64> {
    table.cells(column).map(|cell| cell.number().unwrap_or(f64::NAN)).collect()
}

/// Returns the first text in a column, if it has any.
pub(super) fn text_in(table: &DataTable, column: usize) -> Option<String> {
    table.cells(column).find_map(|cell| match cell {
        Cell::Flag(yes) => Some(yes.to_string()),
        Cell::Text(text) => Some(text.clone()),
        _ => None,
    })
}
