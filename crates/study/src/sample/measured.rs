//! The columns of measured values from which keys are drawn.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use crate::axis::MAX_POINTS;
use crate::units::Dimension;

/// A reader of a column of a file: it gets the names of both, and what the values measure.
pub(crate) type ReadColumn<'f> = dyn FnMut(&str, &str, Dimension) -> Result<Vec<f64>, String> + 'f;

/// The columns of measured values, each of which is read once, however many keys are drawn from it.
pub(super) struct MeasuredColumns<'f, 'r> {
    pub(super) read: &'r mut ReadColumn<'f>,
    pub(super) known: HashMap<MeasuredColumn, Vec<MeasuredValue>>,
}

/// A column of a file, and what its values measure.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) struct MeasuredColumn {
    file: String,
    column: String,
    dimension: Dimension,
}

/// A value that was measured, and how often it was.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasuredValue {
    pub(super) value: f64,
    pub(super) count: f64,
}

impl MeasuredColumns<'_, '_> {
    /// Returns the different values of a column, in ascending order, so that neighbouring parts of
    /// their distribution are neighbouring values.
    ///
    /// # Errors
    /// The column cannot be read, or has more than [`MAX_POINTS`] values, in words.
    pub(super) fn values(
        &mut self,
        file: &str,
        column: &str,
        dimension: Dimension,
    ) -> Result<&[MeasuredValue], String> {
        let meant = MeasuredColumn { file: file.to_owned(), column: column.to_owned(), dimension };
        let values = match self.known.entry(meant) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let mut all = (self.read)(file, column, dimension)?;
                all.sort_by(f64::total_cmp);
                let runs = all.chunk_by(|a, b| a == b);
                let value = |run: &[f64]| MeasuredValue { value: run[0], count: run.len() as f64 };
                let values: Vec<MeasuredValue> = runs.map(value).collect();
                if values.len() > MAX_POINTS {
                    let found = values.len();
                    return Err(format!(
                        "the column has {found} different values, more than {MAX_POINTS}"
                    ));
                }
                place.insert(values)
            }
        };
        Ok(values)
    }
}
