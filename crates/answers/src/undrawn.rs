//! The points of a figure that have no certified result: they are no points of a curve.

use report::{Cell, DataTable, TableError};
use study::Standing;

use crate::error::AnswerError;

/// The condition that a row has a certified result.
pub(crate) const IS_CERTIFIED: &str = "status == \"certified\"";

/// The numbers of points that a figure does not draw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Undrawn {
    /// The points that the figure is about.
    pub points: usize,
    /// The points among them whose job has ended without a solution.
    pub failed: usize,
    /// The points among them that have no result yet.
    pub left: usize,
    /// The figure is of increments, so that a path that failed is drawn as far as it was solved.
    pub steps: bool,
}

impl Undrawn {
    /// Says how many points are missing; `None` if all are drawn.
    pub fn words(&self) -> Option<String> {
        let Undrawn { points, failed, left, steps } = *self;
        let whole = format!(
            "{points} {}",
            match (steps, points) {
                (false, 1) => "point",
                (false, _) => "points",
                (true, 1) => "path",
                (true, _) => "paths",
            }
        );
        let are = |count: usize| if count == 1 { "is" } else { "are" };
        match (failed, left, steps) {
            (0, 0, _) => None,
            (0, left, _) => {
                let have = if left == 1 { "has" } else { "have" };
                Some(format!("{left} of {whole} {have} no result yet and {} not drawn", are(left)))
            }
            (failed, 0, false) => {
                Some(format!("{failed} of {whole} failed and {} not drawn", are(failed)))
            }
            (failed, left, false) => Some(format!(
                "{failed} of {whole} failed and {left} {} no result yet; they are not drawn",
                if left == 1 { "has" } else { "have" }
            )),
            (failed, 0, true) => Some(format!(
                "{failed} of {whole} failed and {} drawn as far as solved",
                are(failed)
            )),
            (failed, left, true) => Some(format!(
                "{failed} of {whole} failed and {} drawn as far as solved; {left} {} no result yet",
                are(failed),
                if left == 1 { "has" } else { "have" }
            )),
        }
    }
}

/// Returns a table of results whose columns of these names are empty in rows that are not
/// certified.
pub(crate) fn only_certified<'n>(
    table: &DataTable,
    names: impl Iterator<Item = &'n String>,
) -> Result<DataTable, AnswerError> {
    let status = table.column("status").map_err(TableError::from)?;
    // Whoever draws the figure says which column is not there.
    let emptied: Vec<usize> = names.filter_map(|name| table.column(name).ok()).collect();
    let certified = Cell::Text(Standing::Certified.to_string());
    let rows = table.rows().iter().map(|row| {
        let mut row = row.clone();
        if row.get(status) != Some(&certified) {
            emptied.iter().for_each(|column| row[*column] = Cell::Missing);
        }
        row
    });
    Ok(DataTable::new(table.columns().to_vec(), rows.collect())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(points: usize, failed: usize, left: usize, steps: bool) -> Option<String> {
        Undrawn { points, failed, left, steps }.words()
    }

    #[test]
    fn what_is_missing_is_said_in_a_sentence() {
        let said = |points, failed, left| words(points, failed, left, false).unwrap();
        assert_eq!(words(5, 0, 0, false), None);
        assert_eq!(said(5, 2, 0), "2 of 5 points failed and are not drawn");
        assert_eq!(said(1, 1, 0), "1 of 1 point failed and is not drawn");
        assert_eq!(said(5, 0, 1), "1 of 5 points has no result yet and is not drawn");
        assert_eq!(
            said(9, 1, 3),
            "1 of 9 points failed and 3 have no result yet; they are not drawn"
        );
        assert_eq!(
            words(3, 1, 0, true).unwrap(),
            "1 of 3 paths failed and is drawn as far as solved"
        );
        assert_eq!(
            words(3, 1, 1, true).unwrap(),
            "1 of 3 paths failed and is drawn as far as solved; 1 has no result yet"
        );
    }
}
