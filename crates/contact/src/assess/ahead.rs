//! The displacement at the place that lies a rolled distance ahead of an element, added up from the
//! kernels of the bodies.
//!
//! A contact that rolls has the displacements a distance ahead in its slip, those of the same
//! tractions or of those before. A solver has them from coefficients of what is rolled, by
//! transforms. Nothing of that is used here: by reciprocity, what a traction on an element does to
//! a place is what a traction at the place does to the element, so each term is the influence of an
//! element around the place on the loaded one, computed for the distance between the two.

use std::sync::Arc;

use rayon::prelude::*;

use crate::foundation::{Coefficient, Kernels};
use crate::grid::Grid;
use crate::influence::Components;
use crate::model::Projection;

/// Sums over the loaded elements of the displacement ahead of some elements. The influences are
/// kept, for the next increment that rolls as far has nearly the same loaded elements.
pub(crate) struct AheadSums {
    kernels: Arc<Kernels>,
    projection: Projection,
    /// The distance along x, with its sign, in the grid's unit.
    distance: f64,
    /// The elements ahead of which the sums are taken: the one that first had the largest traction,
    /// and another that first had the largest tangential one. Each is there as soon as an element
    /// has such a traction, for what is only pressed at first may have no tangential ones.
    receivers: Vec<Receiver>,
}

/// An element ahead of which a sum is taken.
struct Receiver {
    element: usize,
    /// The influences of the loaded elements, as far as one was loaded.
    influences: Vec<Option<Coefficient>>,
}

impl AheadSums {
    /// Prepares sums for a distance. The kernels have to reach as far.
    pub(crate) fn new(kernels: Arc<Kernels>, projection: Projection, distance: f64) -> Self {
        Self { kernels, projection, distance, receivers: Vec::new() }
    }

    /// Returns the distance along x, with its sign, in the grid's unit.
    pub(crate) fn distance(&self) -> f64 {
        self.distance
    }

    /// Returns the largest difference between the tangential displacements `ahead` and the sums
    /// under the tractions `p`, over `unit`. Both fields are blocks of `components` on `grid`. The
    /// sums are those ahead of the elements that first had the largest traction and the largest
    /// tangential one.
    pub(crate) fn error(
        &mut self,
        grid: &Grid,
        components: Components,
        [p, ahead]: [&[f64]; 2],
        unit: f64,
    ) -> f64 {
        let k = grid.len();
        let mut blocks = [None; 3];
        components
            .directions()
            .enumerate()
            .for_each(|(block, to)| blocks[to as usize] = Some(block));
        let part = |field: &[f64], c: usize, e: usize| blocks[c].map(|block| field[block * k + e]);
        let traction = |e: usize| [0, 1, 2].map(|c| part(p, c, e).unwrap_or(0.0));
        let size = |e: usize, first: usize| {
            traction(e)[first..].iter().map(|t| t.abs()).fold(0.0, f64::max)
        };
        for first in self.receivers.len()..2 {
            let is_new = |element: &usize| self.receivers.iter().all(|one| one.element != *element);
            let largest = grid
                .active()
                .filter(is_new)
                .max_by(|a, b| size(*a, first).total_cmp(&size(*b, first)));
            if let Some(element) = largest.filter(|element| size(*element, first) > 0.0) {
                self.receivers.push(Receiver { element, influences: vec![None; k] });
            }
        }
        let Self { kernels, projection, distance, receivers } = self;
        let mut worst: f64 = 0.0;
        for Receiver { element, influences } in receivers {
            let [x, y] = grid.center(*element);
            let place = [x + *distance, y];
            influences.par_iter_mut().enumerate().for_each(|(e, influence)| {
                if influence.is_none() && traction(e) != [0.0; 3] {
                    let [x, y] = grid.center(e);
                    let offset = [(x - place[0]) / grid.hx(), (y - place[1]) / grid.hy()];
                    let whole = offset.map(near_whole);
                    *influence = Some(kernels.influence(whole, grid.hx(), grid.hy(), *projection));
                }
            });
            let mut sum = [0.0; 2];
            for (e, Coefficient { xx, yy, xy, nx, ny, .. }) in
                influences.iter().enumerate().filter_map(|(e, one)| Some((e, (*one)?)))
            {
                let [pn, px, py] = traction(e);
                sum[0] += nx * pn + xx * px + xy * py;
                sum[1] += ny * pn + xy * px + yy * py;
            }
            for c in 1..3 {
                let Some(claimed) = part(ahead, c, *element) else { continue };
                let difference = (claimed - sum[c - 1]).abs();
                // What is not a number is infinitely far, and no difference is nothing of 0 too.
                let error = if difference == 0.0 { 0.0 } else { difference / unit };
                worst = if error.is_nan() { f64::INFINITY } else { worst.max(error) };
            }
        }
        worst
    }
}

/// Returns a number of elements without what centres of elements have of rounding, for kernels
/// between two elements are exactly symmetric at whole numbers.
fn near_whole(elements: f64) -> f64 {
    let nearest = elements.round();
    if (elements - nearest).abs() <= 1e-10 { nearest } else { elements }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foundation::Bodies;
    use crate::influence::{Direction, InfluenceTable};
    use crate::model::{Base, Layer, Material};

    /// The displacement ahead is that of the elements less what is rolled, for distances of whole
    /// elements and others; any wrong coefficient of what is rolled shows.
    #[test]
    fn coefficients_of_what_is_rolled_agree_and_wrong_ones_show() {
        let grid = Grid::new(9, 6, 0.3, 0.2, [-1.2, -0.5]).unwrap();
        let material = Material { shear_modulus: 1.0, poisson: 0.3 };
        let layer = Layer { shear_modulus: 3.0, poisson: 0.4, thickness: 0.7 };
        let k = grid.len();
        let p: Vec<f64> = (0..3 * k).map(|i| ((i * i) as f64 * 0.37).sin()).collect();
        for layers in [vec![], vec![layer]] {
            let bodies = Bodies::new(&layers, &Base::Elastic(material), None);
            for projection in [Projection::Average, Projection::Midpoint] {
                let still = InfluenceTable::new(&grid, &bodies, projection);
                for distance in [0.3, -0.6, 0.07, -0.5] {
                    let kernels = Arc::new(still.kernels_ahead(&bodies, distance));
                    let ahead = |distance: f64| {
                        let rolled = still.rolled(&kernels, projection, distance);
                        let mut ahead = vec![0.0; 3 * k];
                        for e in 0..k {
                            let [here, rolled] = [&still, &rolled]
                                .map(|table| table.displacement_at(e, Components::ALL, &p));
                            for c in [Direction::X as usize, Direction::Y as usize] {
                                ahead[c * k + e] = here[c] - rolled[c];
                            }
                        }
                        ahead
                    };
                    let error = |ahead: &[f64]| {
                        let mut sums = AheadSums::new(Arc::clone(&kernels), projection, distance);
                        sums.error(&grid, Components::ALL, [&p, ahead], 1.0)
                    };
                    let right = ahead(distance);
                    assert!(error(&right) < 1e-13, "{distance}: {:e}", error(&right));
                    assert!(error(&ahead(-distance)) > 1e-3, "{distance}");
                    assert!(error(&ahead(0.9 * distance)) > 1e-5, "{distance}");
                    assert_eq!(error(&vec![f64::NAN; 3 * k]), f64::INFINITY);
                }
            }
        }
    }

    /// A contact that is pressed first and rolls then is watched at a second element from its first
    /// tangential tractions on, and an error there shows.
    #[test]
    fn tangential_tractions_that_come_later_have_an_element_of_their_own() {
        let grid = Grid::new(5, 4, 0.3, 0.2, [0.0; 2]).unwrap();
        let k = grid.len();
        let material = Material { shear_modulus: 1.0, poisson: 0.3 };
        let bodies = Bodies::new(&[], &Base::Elastic(material), None);
        let kernels = Arc::new(bodies.kernels(2.0));
        let mut sums = AheadSums::new(kernels, Projection::Average, 0.3);
        let mut p = vec![0.0; 3 * k];
        let mut ahead = vec![0.0; 3 * k];
        let watched = |sums: &AheadSums| -> Vec<usize> {
            sums.receivers.iter().map(|receiver| receiver.element).collect()
        };
        (p[7], p[8]) = (2.0, 1.0);
        sums.error(&grid, Components::ALL, [&p, &ahead], 1.0);
        assert_eq!(watched(&sums), [7]);
        (p[k + 7], p[k + 12], p[2 * k + 13]) = (0.4, 0.2, -0.3);
        let before = sums.error(&grid, Components::ALL, [&p, &ahead], 1.0);
        assert_eq!(watched(&sums), [7, 13]);
        ahead[2 * k + 13] = 1e3;
        let error = sums.error(&grid, Components::ALL, [&p, &ahead], 1.0);
        assert!(error > 900.0 && before < 100.0, "{before:e} {error:e}");
    }

    /// A component that is not there is none, and nothing loaded is nothing wrong.
    #[test]
    fn without_tractions_there_is_no_error() {
        let grid = Grid::new(4, 3, 0.3, 0.2, [0.0; 2]).unwrap();
        let material = Material { shear_modulus: 1.0, poisson: 0.3 };
        let bodies = Bodies::new(&[], &Base::Elastic(material), None);
        let kernels = Arc::new(bodies.kernels(2.0));
        let mut sums = AheadSums::new(kernels, Projection::Average, 0.3);
        let nothing = [0.0; 12];
        assert_eq!(sums.error(&grid, Components::X, [&nothing, &nothing], 0.0), 0.0);
        let mut p = nothing;
        p[5] = 1.0;
        assert!(sums.error(&grid, Components::X, [&p, &nothing], 1.0) > 0.01);
    }
}
