//! An estimate of a solution's distance from the limit of ever finer meshes.
//!
//! The same path is followed on a grid of half as many elements each way, and the difference of the
//! figures estimates the remaining error. With d the relative difference of a figure, D that of the
//! pressures in L₂, T that of the tangential tractions, h the mean side of an element, a the radius
//! of a disk as large as the contact and r ≈ 2 the ratio of both grids' h, the estimates are:
//! - for forces, moments and motions, the larger of 1.5 d/(r − 1) and ½ D² h/a, and of 0.3 T² h/a
//!   too for those that tangential tractions take part in. The factor 1.5 becomes 2 where the
//!   contact reaches the edge of its sole: there they are of first order only and, with the
//!   staircase of a disk, irregular. In steady rolling by an element q of the mesh, 0.6 q/a times
//!   the root of the share of the contact that sticks is the least for those that tangential
//!   tractions take part in, because slip is a difference over q, of first order too, and goes up
//!   and down with the front. Where q is given, and less than an element h, it is h − q in this:
//!   the mesh does not see where within an element the material is;
//! - for the largest pressure, the larger of d/(r − 1) and 0.2 D²;
//! - for areas, the larger of d/(r − 1) and 0.4 of the elements at the rim, for an area is counted
//!   in whole elements. Where all up to the edge of the sole sticks, that is a rim too, for a ring
//!   of slip may be narrower than an element;
//! - for tractions in L₂, 1.1 D/(r − 1) and 1.1 T/(r − 1).
//!
//! A difference alone tells too little, for a figure may come out the same on two grids by
//! accident. Differences of fields do not: D is the error in L₂ times a factor between 1 and 2.3.
//! The other bounds follow from it. The error of a Galerkin solution's energy is quadratic in that
//! of its tractions, whose energy at the scale of elements is their square in L₂ times h. Where a
//! pressure has a smooth peak, the mean over an element misses it by the square of the pressure's
//! variation on the element. The factors are chosen such that the estimate is rarely below the
//! error; `tests/estimate.rs` prints how rarely, and how far above it lies otherwise. Extrapolation
//! from three grids ([`richardson`](crate::theory::richardson)) was tried instead on the closed
//! forms of that test: figures go up and down with the places where the edges of elements happen to
//! lie, and it covers 82 of 100 errors of the load.
//!
//! The limit is that of ever finer meshes of the same Ω, with the same ε, ceiling and projection,
//! along the same increments. In steady rolling by a given distance q it has the same q, which the
//! coarser grid rolls too; where none is given, q is an element of every mesh, and part of what
//! becomes finer. The estimate knows nothing of the changes by ε, the ceiling, an Ω that is too
//! small or increments that are too large.

use super::errors::Errors;
use crate::model::{Estimate, Fields, FigureErrors, Numerics, Scene, Shape, State, StepOutcome};
use crate::problem::LEAST_DISTANCE;

/// The number of elements along a side with less than which there is no estimate.
pub(crate) const FEWEST: u32 = 4;

/// The relative residual to which the coarser grid is solved: well below the difference of the two
/// grids.
pub(crate) const TOLERANCE: f64 = 1e-5;

/// Returns the elements of the grid to compare with.
pub(crate) fn coarser(elements: [u32; 2]) -> Option<[u32; 2]> {
    elements.iter().all(|n| *n >= FEWEST).then(|| elements.map(|n| n.div_ceil(2)))
}

/// Returns the distance that a coarser grid with elements of length `coarse` along x rolls
/// steadily, where the grid that was asked for, with elements of length `fine`, rolls by the given
/// `distance`. The grid to compare with rolls the same. A mesh does not see distances below a tenth
/// of its elements, though, and has a tenth of them in their place: from less than two tenths of an
/// element on both grids the difference of the distances is small next to that of the elements.
/// Still coarser grids roll as many elements as the grid to compare with.
pub(crate) fn coarser_distance(distance: f64, fine: f64, coarse: f64) -> f64 {
    let share = (coarse / (2.0 * fine)).max(1.0);
    (share * distance).max(LEAST_DISTANCE * coarse)
}

/// The factor of the rolled distance, or of what an element has more than it, over the radius of
/// the contact by which a force is off at most, where all sticks. Under spheres it was 0.1 to 0.6.
const LAG: f64 = 0.6;

/// The solution of a path.
pub(crate) struct PathSolution<'a> {
    /// The outcomes of its increments.
    pub(crate) steps: &'a [StepOutcome],
    /// The fields of the last increment.
    pub(crate) fields: &'a Fields,
    /// The distance \[m\] that it has rolled in the last increment, if it rolls.
    pub(crate) rolled: Option<f64>,
}

/// Estimates the errors at the end of a path from that of the same path on a coarser grid; `None`
/// if a path has no end that was solved, or no contact there.
pub(crate) fn estimate(
    scene: &Scene,
    numerics: &Numerics,
    PathSolution { steps, fields, rolled }: PathSolution<'_>,
    coarse: PathSolution<'_>,
) -> Option<Estimate> {
    let (end, coarse_end) = (steps.last()?, coarse.steps.last()?);
    let leg = *scene.loading.legs().last()?;
    let steadily = leg.rolling.filter(|_| leg.is_steady());
    let unseen = steadily.map(|rolling| fields.element[0] - rolling.dq.unwrap_or(0.0));
    let share = rolled.zip(coarse.rolled).map_or(1.0, |(fine, coarse)| fine / coarse);
    let difference =
        Errors::at_share(coarse_end, coarse.fields, end, fields, &leg.target, share)?.figures;
    let size = |fields: &Fields| (fields.element[0] * fields.element[1]).sqrt();
    // The differences of first-order figures are errors times this.
    let gain = size(coarse.fields) / size(fields) - 1.0;
    let bound = |difference: Option<f64>, factor: f64, least: f64| {
        difference.map(|d| (factor * d / gain).max(least))
    };
    let squares = |distance: Option<f64>| distance.map_or(0.0, |distance| distance * distance);
    let (normal, tangential) = (squares(difference.pressure), squares(difference.traction));
    let contact = end.observables.contact_area;
    if contact == 0.0 {
        return None;
    }
    let radius = (contact / std::f64::consts::PI).sqrt();
    let energy = 0.5 * size(fields) / radius;
    let sticking = (end.observables.stick_area / contact).sqrt();
    let lag = unseen.map_or(0.0, |unseen| LAG * unseen.max(0.0) / radius * sticking);
    let is_at_edge = reaches_an_edge(fields);
    let order = if is_at_edge { 2.0 } else { 1.5 };
    let along = |difference: Option<f64>| bound(difference, order, energy * normal);
    let least = lag.max(energy * normal.max(0.6 * tangential));
    let across = |difference: Option<f64>| bound(difference, order, least);
    // A sole whose staircase has another area on another grid has an uncertain edge too.
    let is_staircase =
        (end.observables.sole_area / coarse_end.observables.sole_area - 1.0).abs() > 1e-9;
    let area = |difference: Option<f64>, states: &[State], with_sole: bool| {
        let uncertain =
            0.4 * rim(fields, states, with_sole) as f64 * fields.element[0] * fields.element[1];
        bound(difference, 1.0, uncertain / contact)
    };
    let is_limited = end.observables.ceiling_elements > 0 || resolves(numerics.epsilon, fields);
    let is_bounded = is_limited || !is_at_edge;
    let has_peak = is_limited || !matches!(scene.punch.shape, Shape::Cone { .. });
    let figures = FigureErrors {
        load: along(difference.load),
        approach: along(difference.approach),
        tangential_force: across(difference.tangential_force),
        shift: across(difference.shift),
        moment: across(difference.moment),
        rotation: across(difference.rotation),
        peak_pressure: bound(difference.peak_pressure, 1.0, 0.2 * normal)
            .filter(|_| is_bounded && has_peak),
        contact_area: area(difference.contact_area, &CONTACT, is_staircase),
        stick_area: area(difference.stick_area, &[State::Stick], true),
        pressure: bound(difference.pressure, 1.1, 0.0).filter(|_| is_bounded),
        traction: bound(difference.traction, 1.1, 0.0).filter(|_| is_bounded),
    };
    let solver = 4.0
        * steps
            .iter()
            .map(|step| step.certificate.residual.max(step.certificate.force_imbalance))
            .sum::<f64>();
    Some(Estimate { figures, solver })
}

/// The states of elements in contact.
const CONTACT: [State; 2] = [State::Stick, State::Slip];

/// Returns whether the grid is fine enough to see the smoothing by ε of what is unbounded without
/// it, over lengths of about ε times half the diameter of Ω.
fn resolves(epsilon: f64, fields: &Fields) -> bool {
    let [width_x, width_y] =
        [0, 1].map(|axis| f64::from(fields.shape[axis]) * fields.element[axis]);
    epsilon * 0.5 * width_x.hypot(width_y) >= fields.element[0].max(fields.element[1])
}

/// Returns whether an element in contact lies at the edge of the sole or of Ω.
fn reaches_an_edge(fields: &Fields) -> bool {
    let is_edge =
        |neighbour: Option<u8>| neighbour.is_none_or(|state| state == State::Outside as u8);
    elements_in(fields, &CONTACT).any(|neighbours| neighbours.into_iter().any(is_edge))
}

/// Counts the elements in one of the states `inside` with a neighbour of Ω that is in none of them;
/// with or without those at the edge of the sole.
fn rim(fields: &Fields, inside: &[State], with_sole: bool) -> usize {
    let is_beyond = |state: u8| {
        inside.iter().all(|inner| *inner as u8 != state)
            && (with_sole || state != State::Outside as u8)
    };
    elements_in(fields, inside)
        .filter(|neighbours| neighbours.iter().flatten().any(|state| is_beyond(*state)))
        .count()
}

/// Returns the states of the four neighbours of every element in one of the states `inside`, `None`
/// beyond Ω.
fn elements_in(fields: &Fields, inside: &[State]) -> impl Iterator<Item = [Option<u8>; 4]> {
    let [nx, ny] = fields.shape.map(|n| n as usize);
    let state = move |i: usize, j: usize| {
        (i < nx && j < ny).then(|| fields.state.get(j * nx + i).copied()).flatten()
    };
    let is_inside = move |element: &usize| {
        inside.iter().any(|inner| fields.state.get(*element) == Some(&(*inner as u8)))
    };
    (0..nx * ny).filter(is_inside).map(move |element| {
        let (i, j) = (element % nx, element / nx);
        [state(i.wrapping_sub(1), j), state(i + 1, j), state(i, j.wrapping_sub(1)), state(i, j + 1)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns fields with a column that is left out, and three elements in contact of which the
    /// last two lie next to open ones.
    fn fields() -> Fields {
        let [outside, open, stick, slip] =
            [State::Outside, State::Open, State::Stick, State::Slip].map(|state| state as u8);
        let state = vec![
            outside, open, open, open, open, //
            outside, stick, slip, open, open, //
            outside, open, open, open, slip,
        ];
        Fields { shape: [5, 3], element: [1.0, 2.0], state, ..Fields::default() }
    }

    #[test]
    fn rims_are_where_an_area_ends_on_the_sole() {
        assert_eq!(rim(&fields(), &CONTACT, false), 3);
        assert_eq!(rim(&fields(), &[State::Stick], false), 1);
        let mut full = fields();
        full.state = [0, 2, 2, 2, 2].repeat(3);
        assert_eq!([false, true].map(|with_sole| rim(&full, &CONTACT, with_sole)), [0, 3]);
    }

    #[test]
    fn a_contact_reaches_the_edge_of_its_sole_or_of_the_grid() {
        assert!(reaches_an_edge(&fields()));
        let mut inside = fields();
        inside.state[5 + 1] = State::Open as u8;
        assert!(reaches_an_edge(&inside), "the last element has no neighbour");
        inside.state[2 * 5 + 4] = State::Open as u8;
        assert!(!reaches_an_edge(&inside));
    }

    #[test]
    fn grids_of_less_than_four_elements_have_none_to_compare_with() {
        assert_eq!(coarser([4, 75]), Some([2, 38]));
        assert_eq!(coarser([3, 64]), None);
    }
}
