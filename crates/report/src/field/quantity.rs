//! A quantity on a uniform rectangular grid: pressure, gap, contact state.

use thiserror::Error;

use super::cut::CutPlane;

/// A uniform grid of rectangular elements. Element (i, j) is the i-th along x and the j-th along y,
/// both from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldGrid {
    /// The number of elements along x.
    pub nx: usize,
    /// The number of elements along y.
    pub ny: usize,
    /// The corner of the first element with the least x and y, in metres.
    pub origin: [f64; 2],
    /// The sides of an element along x and y, in metres.
    pub element: [f64; 2],
}

impl FieldGrid {
    /// Returns the number of elements.
    pub(super) fn elements(&self) -> usize {
        self.nx * self.ny
    }

    /// Returns the centre of element (i, j), in metres.
    pub(super) fn centre(&self, i: usize, j: usize) -> [f64; 2] {
        [
            self.origin[0] + (i as f64 + 0.5) * self.element[0],
            self.origin[1] + (j as f64 + 0.5) * self.element[1],
        ]
    }

    /// Returns the lengths of the sides of the whole grid along x and y, in metres.
    pub(super) fn lengths(&self) -> [f64; 2] {
        [self.nx as f64 * self.element[0], self.ny as f64 * self.element[1]]
    }
}

/// The values of a field, one per element; element (i, j) has index `j · nx + i`.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// A quantity in SI units; NaN for an element that has none, e.g. outside a mask.
    Number(Vec<f64>),
    /// A state, e.g. stick or slip. The first state is drawn as ground, the second light grey, the
    /// others in colours.
    Category {
        /// The state of each element, as its index in `names`.
        states: Vec<u8>,
        /// The names of the states.
        names: Vec<String>,
    },
}

/// A reason why a field cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FieldError {
    /// The grid has no elements, or more than can be counted.
    #[error(
        "field `{name}` has a grid of {nx}×{ny} elements; both numbers must be at least 1 and \
         their product a size in memory"
    )]
    Grid {
        /// The name of the field.
        name: String,
        /// The number of elements along x.
        nx: usize,
        /// The number of elements along y.
        ny: usize,
    },
    /// The grid does not lie in the plane.
    #[error(
        "field `{name}` lies at {origin:?} m with elements of {element:?} m; coordinates must be \
         finite and sides positive"
    )]
    Geometry {
        /// The name of the field.
        name: String,
        /// The corner with the least x and y, in metres.
        origin: [f64; 2],
        /// The sides of an element, in metres.
        element: [f64; 2],
    },
    /// There are too few or too many values.
    #[error("field `{name}` has {found} values for a grid of {expected} elements")]
    Length {
        /// The name of the field.
        name: String,
        /// The number of values.
        found: usize,
        /// The number of elements.
        expected: usize,
    },
    /// A state has no name.
    #[error(
        "field `{name}` has state {state} in element {element}, but names only for states below \
         {names}"
    )]
    UnknownState {
        /// The name of the field.
        name: String,
        /// The state.
        state: u8,
        /// The index of the element.
        element: usize,
        /// The number of names.
        names: usize,
    },
}

/// A quantity on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    pub(super) name: String,
    pub(super) unit: String,
    pub(super) grid: FieldGrid,
    pub(super) values: Values,
    pub(super) cut: CutPlane,
}

impl Field {
    /// Makes a field, after checking that the values fit the grid.
    ///
    /// `unit` is the SI unit of the values; it has no meaning for states.
    ///
    /// # Errors
    /// [`FieldError`], if the grid has no elements or no place in the plane, if the number of
    /// values is not that of the elements, or if a state has no name.
    pub fn new(
        name: impl Into<String>,
        unit: impl Into<String>,
        grid: FieldGrid,
        values: Values,
    ) -> Result<Field, FieldError> {
        let name = name.into();
        let expected = match grid.nx.checked_mul(grid.ny) {
            Some(elements) if elements > 0 => elements,
            _ => return Err(FieldError::Grid { name, nx: grid.nx, ny: grid.ny }),
        };
        let ends = [0, 1].map(|k| grid.origin[k] + grid.lengths()[k]);
        // A side that vanishes beside the coordinates leaves no room to draw in.
        let sound = (0..2)
            .all(|k| grid.element[k] > 0.0 && ends[k].abs() < 1e280 && ends[k] > grid.origin[k])
            && grid.origin.iter().all(|x| x.is_finite());
        if !sound {
            return Err(FieldError::Geometry { name, origin: grid.origin, element: grid.element });
        }
        let found = match &values {
            Values::Number(values) => values.len(),
            Values::Category { states, .. } => states.len(),
        };
        if found != expected {
            return Err(FieldError::Length { name, found, expected });
        }
        if let Values::Category { states, names } = &values
            && let Some(element) =
                states.iter().position(|&state| usize::from(state) >= names.len())
        {
            return Err(FieldError::UnknownState {
                name,
                state: states[element],
                element,
                names: names.len(),
            });
        }
        Ok(Field { name, unit: unit.into(), grid, values, cut: CutPlane::Z(0.0) })
    }

    /// Puts the field on another plane than z = 0. The grid's x and y are the plane's own two
    /// coordinates, in the order of x, y and z.
    pub fn on(self, cut: CutPlane) -> Field {
        Field { cut, ..self }
    }

    /// Returns the field with its rows in reverse, on the plane z = 0.
    pub(super) fn upside_down(&self) -> Field {
        let nx = self.grid.nx;
        let values = match &self.values {
            Values::Number(values) => {
                Values::Number(values.chunks(nx).rev().flatten().copied().collect())
            }
            Values::Category { states, names } => Values::Category {
                states: states.chunks(nx).rev().flatten().copied().collect(),
                names: names.clone(),
            },
        };
        Field { values, cut: CutPlane::Z(0.0), ..self.clone() }
    }

    /// Returns the name as words.
    pub(super) fn title(&self) -> String {
        self.name.replace('_', " ")
    }
}
