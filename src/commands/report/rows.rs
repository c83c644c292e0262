//! The jobs of a report as a table with every column.

use answers::Results;
use anyhow::Result;
use report::{Cell, DataTable, JobColumn};
use study::Column;
use study::columns::Role;

/// The jobs that a report is about, with every column.
pub(super) struct JobRows<'r> {
    pub(super) study: String,
    pub(super) results: &'r Results<'r>,
    pub(super) columns: Vec<Column>,
    pub(super) table: DataTable,
}

impl<'r> JobRows<'r> {
    /// Reads the jobs for which a filter holds.
    pub(super) fn read(results: &'r Results<'r>, filter: Option<&str>) -> Result<Self> {
        let columns = results.study().columns();
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_ref()).collect();
        let mut table = results.table(&names)?;
        if let Some(expression) = filter {
            table = table.filter(expression)?;
        }
        Ok(Self { study: results.study().name().to_owned(), results, columns, table })
    }

    /// Returns the number of rows.
    pub(super) fn len(&self) -> usize {
        self.table.rows().len()
    }

    /// Returns the cells of a column, from top to bottom; none if there is no such column.
    pub(super) fn cells(&self, name: &str) -> impl Iterator<Item = &Cell> {
        let column = self.table.column(name).ok();
        self.table.rows().iter().filter_map(move |row| row.get(column?))
    }

    /// Returns the numbers of a column with their rows.
    pub(super) fn numbers(&self, name: &str) -> Vec<(usize, f64)> {
        let finite =
            |(row, cell): (usize, &Cell)| Some((row, cell.number().filter(|x| x.is_finite())?));
        self.cells(name).enumerate().filter_map(finite).collect()
    }

    /// Returns the texts in a column by row, empty where there is none.
    pub(super) fn texts(&self, name: &str) -> Vec<&str> {
        fn text(cell: &Cell) -> &str {
            if let Cell::Text(text) = cell { text } else { "" }
        }
        self.cells(name).map(text).collect()
    }

    /// Returns the keys of the jobs by row.
    pub(super) fn keys(&self) -> Vec<&str> {
        self.texts("key")
    }

    /// Iterates over the columns of a role.
    pub(super) fn of_role(&self, role: Role) -> impl Iterator<Item = &Column> {
        self.columns.iter().filter(move |column| column.role == role)
    }

    /// Returns the values of the axes in a row, in words.
    pub(super) fn place(&self, row: usize) -> String {
        let words = |column: &Column| {
            let cell = self.cells(&column.name).nth(row)?;
            let text = match cell {
                Cell::Number(x) => report::quantity_words(*x, column.unit()),
                Cell::Integer(i) => i.to_string(),
                Cell::Flag(yes) => yes.to_string(),
                Cell::Text(text) => text.clone(),
                Cell::Missing => return None,
            };
            Some(format!("{} = {text}", column.name))
        };
        self.of_role(Role::Axis).filter_map(words).collect::<Vec<_>>().join(", ")
    }

    /// Returns the columns that have a value in some row, except for the key.
    pub(super) fn filled_columns(&self) -> impl Iterator<Item = &str> {
        let is_filled =
            |name: &&str| *name != "key" && self.cells(name).any(|cell| !cell.is_missing());
        self.columns.iter().map(|column| column.name.as_ref()).filter(is_filled)
    }

    /// Returns the columns of the table in the page: those that answer the question first.
    pub(super) fn job_columns(&self, results: &Results<'_>) -> Result<Vec<JobColumn>> {
        let usual = results.usual_columns(false)?;
        let group = |role: Role| match role {
            Role::Axis => "axis",
            Role::Key => "setting",
            Role::Status => "status",
            Role::Place => "place",
            Role::Observable => "observable",
            Role::Certificate => "certificate",
            Role::Error => "estimated error",
            Role::Work => "work",
            Role::Provenance => "provenance",
        };
        let column = |column: &Column| JobColumn {
            name: column.name.to_string(),
            group: group(column.role),
            meaning: column.meaning.to_owned(),
            is_shown: usual.iter().any(|name| *name == column.name) && column.name != "key",
        };
        let mut columns: Vec<JobColumn> =
            self.columns.iter().filter(|column| column.name != "key").map(column).collect();
        let rank = |column: &JobColumn| {
            usual.iter().position(|name| *name == column.name).unwrap_or(usize::MAX)
        };
        columns.sort_by_key(rank);
        Ok(columns)
    }
}
