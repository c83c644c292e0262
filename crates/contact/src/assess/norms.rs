//! Norms of tractions that are constant on the elements of uniform grids, and distances between
//! those of different grids.
//!
//! Two grids have a common refinement: along x and along y, the intervals between neighbouring
//! edges of either. Both fields are constant on it, so every integral here is a sum without a
//! discretisation error, at the cost of about the elements of both grids together. Outside its grid
//! a field is zero. The grids may lie anywhere and cover different rectangles.
//!
//! Edges that differ by rounding only are one edge: otherwise the slivers between them would make
//! equal fields √(1e-16) apart.

use crate::common::parallel;
use crate::grid::Grid;
use crate::model::{Fields, PerDof, rigid_modes};

/// The L₂ norms of tractions, or of a difference of them \[Pa m\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Norm {
    /// The norm of the pressure, (∫ p₁²)^½.
    pub pressure: f64,
    /// The norm of the tangential traction, (∫ p₂² + p₃²)^½.
    pub traction: f64,
}

/// A [`Norm`] over another \[1\]; `None` where that is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Relative {
    /// The ratio of the pressures' norms.
    pub pressure: Option<f64>,
    /// The ratio of the tangential tractions' norms.
    pub traction: Option<f64>,
}

impl Norm {
    /// Returns this norm in units of `reference`.
    pub(crate) fn over(self, reference: Norm) -> Relative {
        let ratio = |norm: f64, unit: f64| (unit > 0.0).then(|| norm / unit);
        Relative {
            pressure: ratio(self.pressure, reference.pressure),
            traction: ratio(self.traction, reference.traction),
        }
    }
}

/// Returns the norms of a solution; `None` if a field does not have one value per element.
pub fn norm(fields: &Fields) -> Option<Norm> {
    distance(fields, &Fields::default())
}

/// Returns the norms of the difference of two solutions, each on its own grid; `None` if a field
/// does not have one value per element. A metric: symmetric, zero for equal fields, and the
/// triangle inequality holds.
pub fn distance(a: &Fields, b: &Fields) -> Option<Norm> {
    let intervals = Refinement::of(&Sides::of(a)?, &Sides::of(b)?);
    let largest = |fields: &Fields| {
        let of_band = |values: &[f64]| values.iter().fold(0.0, |most: f64, p| most.max(p.abs()));
        let of_block = |values: &[f64]| {
            parallel::bands(values.len(), |band| of_band(&values[band]))
                .into_iter()
                .fold(0.0, f64::max)
        };
        blocks(fields).into_iter().map(of_block).fold(0.0, f64::max)
    };
    let unit = largest(a).max(largest(b));
    if unit == 0.0 {
        return Some(Norm::default());
    }
    let (values, others) = (blocks(a), blocks(b));
    let mut rows = vec![[0.0; 3]; intervals.y.len()];
    parallel::each(
        intervals.x.len() * intervals.y.len(),
        rows.iter_mut().zip(&intervals.y).collect(),
        |(row, y)| {
            for x in &intervals.x {
                let first = element_index(x.first, y.first, a.shape);
                let second = element_index(x.second, y.second, b.shape);
                for (sum, (p, q)) in row.iter_mut().zip(values.iter().zip(&others)) {
                    // Squares of tractions in Pa leave the range of doubles before the tractions
                    // do.
                    let difference =
                        first.map_or(0.0, |e| p[e] / unit) - second.map_or(0.0, |e| q[e] / unit);
                    *sum += difference * difference * x.length;
                }
            }
            row.iter_mut().for_each(|sum| *sum *= y.length);
        },
    );
    let squares = [0, 1, 2].map(|c| rows.iter().map(|row| row[c]).sum::<f64>());
    Some(Norm {
        pressure: unit * squares[0].sqrt(),
        traction: unit * (squares[1] + squares[2]).sqrt(),
    })
}

/// Returns the distance of a solution from a reference, in the reference's norm; `None` if a field
/// does not have one value per element.
pub fn relative_distance(fields: &Fields, reference: &Fields) -> Option<Relative> {
    Some(distance(fields, reference)?.over(norm(reference)?))
}

/// Returns the local means of a solution's tractions over the elements of `onto`, on that grid and
/// without gap, slip and states; `None` if a field does not have one value per element. A sequence
/// that converges weakly converges in every local mean, so the distance of its means on `onto` goes
/// to 0.
pub fn local_means(fields: &Fields, onto: &Grid) -> Option<Fields> {
    let target = Fields {
        shape: [onto.nx() as u32, onto.ny() as u32],
        origin: onto.center(0),
        element: [onto.hx(), onto.hy()],
        ..Fields::default()
    };
    let intervals = Refinement::of(
        &Sides::of(fields)?,
        &Sides { shape: target.shape, origin: target.origin, element: target.element },
    );
    let mean = |values: &[f64]| {
        let mut means = vec![0.0; onto.len()];
        for y in &intervals.y {
            for x in &intervals.x {
                if let (Some(from), Some(to)) = (
                    element_index(x.first, y.first, fields.shape),
                    element_index(x.second, y.second, target.shape),
                ) {
                    means[to] += values[from] * ((x.length / onto.hx()) * (y.length / onto.hy()));
                }
            }
        }
        means
    };
    let [pressure, traction_x, traction_y] = blocks(fields).map(mean);
    Some(Fields { pressure, traction_x, traction_y, ..target })
}

/// Returns the rectangle that fields lie on, in nx × ny equal parts; `None` if there are none.
pub fn parts(fields: &Fields, [nx, ny]: [usize; 2]) -> Option<Grid> {
    let [width_x, width_y] =
        [0, 1].map(|axis| f64::from(fields.shape[axis]) * fields.element[axis]);
    let size = [width_x / nx as f64, width_y / ny as f64];
    let origin = [0, 1].map(|axis| fields.origin[axis] + 0.5 * (size[axis] - fields.element[axis]));
    Grid::new(nx, ny, size[0], size[1], origin).ok()
}

/// Returns the forces and moments of the punch on the foundation \[N, N m\], summed from the
/// fields; `None` if a field does not have one value per element. The sums are continuous in the
/// weak topology.
pub fn resultants(fields: &Fields) -> Option<PerDof<f64>> {
    Sides::of(fields)?;
    let [nx, area] = [fields.shape[0] as f64, fields.element[0] * fields.element[1]];
    let tractions = blocks(fields);
    let mut sums = PerDof::all(0.0);
    for e in 0..fields.pressure.len() {
        let (j, i) = ((e as f64 / nx).floor(), e % fields.shape[0] as usize);
        let modes = rigid_modes(
            fields.origin[0] + i as f64 * fields.element[0],
            fields.origin[1] + j * fields.element[1],
        );
        for (modes, values) in modes.iter().zip(&tractions) {
            for (sum, mode) in sums.iter_mut().zip(modes) {
                *sum += mode * values[e] * area;
            }
        }
    }
    Some(sums)
}

/// Returns the three components of the tractions.
fn blocks(fields: &Fields) -> [&[f64]; 3] {
    [&fields.pressure, &fields.traction_x, &fields.traction_y]
}

/// Returns the index of element (i, j), if there is one.
fn element_index(i: Option<usize>, j: Option<usize>, shape: [u32; 2]) -> Option<usize> {
    Some(j? * shape[0] as usize + i?)
}

/// The place of a grid.
struct Sides {
    shape: [u32; 2],
    origin: [f64; 2],
    element: [f64; 2],
}

impl Sides {
    /// Returns the grid of these fields, if they have a value for each of its elements.
    fn of(fields: &Fields) -> Option<Self> {
        let elements = fields.shape[0] as usize * fields.shape[1] as usize;
        let is_placed = fields.origin.iter().all(|x| x.is_finite())
            && fields.element.iter().all(|h| h.is_finite() && *h > 0.0);
        if blocks(fields).iter().any(|block| block.len() != elements)
            || (elements > 0 && !is_placed)
        {
            return None;
        }
        let shape = if elements == 0 { [0; 2] } else { fields.shape };
        Some(Self { shape, origin: fields.origin, element: fields.element })
    }

    /// Returns the edges of the elements along an axis, ascending \[m\].
    fn edges(&self, axis: usize) -> Vec<f64> {
        let n = self.shape[axis];
        if n == 0 {
            return Vec::new();
        }
        (0..=n).map(|i| self.origin[axis] + (f64::from(i) - 0.5) * self.element[axis]).collect()
    }
}

/// An interval between neighbouring edges of two grids, and the row or column of each grid that it
/// lies in.
struct Interval {
    length: f64,
    first: Option<usize>,
    second: Option<usize>,
}

/// The intervals of the common refinement of two grids along x and y.
struct Refinement {
    x: Vec<Interval>,
    y: Vec<Interval>,
}

impl Refinement {
    /// Refines two grids.
    fn of(a: &Sides, b: &Sides) -> Self {
        let along = |axis: usize| refine(&a.edges(axis), &b.edges(axis));
        Self { x: along(0), y: along(1) }
    }
}

/// Returns the intervals between ascending edges `a` and `b`.
fn refine(a: &[f64], b: &[f64]) -> Vec<Interval> {
    let farthest = a.iter().chain(b).fold(0.0, |most: f64, x| most.max(x.abs()));
    // An edge is a sum of two products of rounded lengths in another unit.
    let slack = 32.0 * f64::EPSILON * farthest;
    let inside =
        |passed: usize, edges: &[f64]| (1..edges.len()).contains(&passed).then(|| passed - 1);
    let mut intervals = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    let mut last = f64::NEG_INFINITY;
    while i < a.len() || j < b.len() {
        let next_a = a.get(i).copied().unwrap_or(f64::INFINITY);
        let next_b = b.get(j).copied().unwrap_or(f64::INFINITY);
        let next = next_a.min(next_b);
        let (first, second) = (inside(i, a), inside(j, b));
        if first.is_some() || second.is_some() {
            intervals.push(Interval { length: next - last, first, second });
        }
        last = next;
        i += usize::from(next_a <= next + slack);
        j += usize::from(next_b <= next + slack);
    }
    intervals
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Dof;

    /// Returns fields of these pressures on a row of elements of size h × 1, with the first one's
    /// centre at x.
    fn row(x: f64, h: f64, pressure: &[f64]) -> Fields {
        Fields {
            shape: [pressure.len() as u32, 1],
            origin: [x, 0.0],
            element: [h, 1.0],
            pressure: pressure.to_vec(),
            traction_x: vec![0.0; pressure.len()],
            traction_y: vec![0.0; pressure.len()],
            ..Fields::default()
        }
    }

    #[test]
    fn overlaps_are_exact() {
        // On [0, 2) the values 1, 3 in steps of 1 meet 2, 5 in steps of 1.5 on [0.5, 3.5).
        let (a, b) = (row(0.5, 1.0, &[1.0, 3.0]), row(1.25, 1.5, &[2.0, 5.0]));
        // The integral is ½·1² + ½·(−1)² + 1·1² + 1.5·5².
        let expected: f64 = 0.5 + 0.5 + 1.0 + 1.5 * 25.0;
        assert!((distance(&a, &b).unwrap().pressure - expected.sqrt()).abs() < 1e-15);
        assert!((norm(&b).unwrap().pressure - 43.5_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn grids_apart_have_nothing_in_common() {
        let (a, b) = (row(0.0, 1.0, &[3.0]), row(10.0, 1.0, &[4.0]));
        assert_eq!(distance(&a, &b).unwrap().pressure, 5.0);
    }

    #[test]
    fn tractions_beyond_the_range_of_squares_have_norms() {
        for p in [1e-300, 1e300] {
            assert!(
                (norm(&row(0.0, 1e-3, &[3.0 * p, 4.0 * p])).unwrap().pressure
                    / (5.0 * p * 1e-3_f64.sqrt())
                    - 1.0)
                    .abs()
                    < 1e-14
            );
        }
    }

    #[test]
    fn means_keep_the_resultants() {
        let mut fields = row(0.25, 0.5, &[1.0, 2.0, 4.0, 1.0]);
        fields.traction_y = vec![0.5, 0.0, -1.0, 0.25];
        let onto = Grid::new(3, 3, 1.0, 0.4, [0.3, -0.4]).unwrap();
        let means = local_means(&fields, &onto).unwrap();
        let (exact, own) = (resultants(&fields).unwrap(), resultants(&means).unwrap());
        assert!(
            (exact[Dof::Approach] - 4.0).abs() < 1e-15
                && (exact[Dof::ShiftY] + 0.125).abs() < 1e-15
        );
        // These are −Σ x p₁ |e| and Σ x p₃ |e|.
        assert!((exact[Dof::TiltY] + 0.5 * (0.25 + 1.5 + 5.0 + 1.75)).abs() < 1e-14);
        assert!((exact[Dof::Twist] - 0.5 * (0.125 - 1.25 + 0.4375)).abs() < 1e-14);
        for dof in [Dof::Approach, Dof::ShiftY] {
            assert!((own[dof] - exact[dof]).abs() < 1e-14, "{own:?} {exact:?}");
        }
    }

    #[test]
    fn fields_without_a_grid_have_no_norm() {
        let mut fields = row(0.0, 1.0, &[1.0, 2.0]);
        fields.traction_x.pop();
        assert_eq!(norm(&fields), None);
        assert_eq!(distance(&row(0.0, f64::NAN, &[1.0]), &Fields::default()), None);
        assert_eq!(resultants(&row(0.0, 0.0, &[1.0])), None);
        assert_eq!(norm(&Fields::default()), Some(Norm::default()));
    }
}
