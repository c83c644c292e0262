//! The largest stresses below the surface, and the answer to what a scene asks.

use rayon::prelude::*;

use super::balance::{larger, load_residual, point_residual, transform_residual};
use super::loaded::{PlaneStress, Subsurface};
use super::peak::climb;
use crate::common::Cancellation;
use crate::foundation::{DepthSide, interfaces};
use crate::model::{
    Fields, Foundation, Interior, InteriorQuestion, LargestStress, PlanePeaks, PointStress, Stress,
    StressPeak,
};

/// The ratio of one depth to the next in a search that chooses its depths.
const RATIO: f64 = 1.35;

/// The depth, in radii of the loaded area, down to which a search goes that chooses its depths.
const DEEPEST: f64 = 2.5;

/// The measures that are sought.
const MEASURES: [fn(&Stress) -> f64; 2] = [Stress::von_mises, Stress::tresca];

/// The depth, in radii of the loaded area, down to which interfaces are looked for.
const WITHIN_REACH: f64 = 10.0;

/// The largest number of points that are computed a second time.
const CHECKED_POINTS: usize = 16;

/// Depths in one material, from its upper end down.
#[derive(Clone, Debug, PartialEq)]
struct DepthSpan {
    depths: Vec<f64>,
    /// The flag is true if the first depth is the upper end of the material: its stresses are those
    /// below it.
    from_interface: bool,
    /// The flag is true if the material goes on above the first depth: a stress may be largest
    /// there only because the search begins there.
    open_above: bool,
    /// The flag is true if the material goes on below the last depth.
    open_below: bool,
}

impl DepthSpan {
    /// Returns the side of a depth on which the material lies.
    fn side(&self, depth: f64) -> DepthSide {
        if self.from_interface && self.depths.first() == Some(&depth) {
            DepthSide::Below
        } else {
            DepthSide::Above
        }
    }
}

/// The measures on a plane.
struct MeasuredPlane {
    values: [Vec<f64>; 2],
}

/// The largest residual that the checks of an answer have found; `None` without a check.
#[derive(Default)]
struct Residual(Option<f64>);

impl Residual {
    /// Takes in what a check found; one that could not be made counts for nothing.
    fn add(&mut self, found: Option<f64>) {
        if let Some(found) = found {
            self.0 = Some(larger(self.0.unwrap_or(0.0), found));
        }
    }
}

/// Answers what is asked of the stresses below the tractions of `fields`. Returns `None` if it is
/// cancelled.
pub fn examine(
    foundation: &Foundation,
    question: &InteriorQuestion,
    fields: &Fields,
    cancellation: &Cancellation,
) -> Option<Interior> {
    let goes_on = || (!cancellation.is_requested()).then_some(());
    let below = Subsurface::new(foundation, fields);
    let mut answer = Interior::default();
    let mut residual = Residual::default();
    for depth in &question.depths {
        goes_on()?;
        let Some(plane) = below.plane(*depth) else { continue };
        answer.planes.push(PlanePeaks {
            depth: *depth,
            von_mises: largest_on(&below, &plane, Stress::von_mises),
            tresca: largest_on(&below, &plane, Stress::tresca),
        });
        residual.add(transform_residual(&below, &plane));
    }
    answer.points = question
        .points
        .par_iter()
        .filter(|_| goes_on().is_some())
        .filter_map(|place| Some(PointStress { place: *place, stress: below.at(*place)? }))
        .collect();
    let apart = answer.points.len().div_ceil(CHECKED_POINTS).max(1);
    for PointStress { place, stress } in answer.points.iter().step_by(apart) {
        goes_on()?;
        residual.add(point_residual(&below, *place, stress));
    }
    if question.maximum {
        search(&below, &question.depths, cancellation, &mut answer, &mut residual)?;
    }
    let found = [answer.von_mises, answer.tresca].into_iter().flatten();
    let peaks = found.filter_map(|largest| largest.below).map(|peak| peak.place[2]);
    let points = answer.points.iter().step_by(apart).map(|point| point.place[2]);
    let mut depths: Vec<f64> = question.depths.iter().copied().chain(peaks).chain(points).collect();
    depths.retain(|depth| *depth > 0.0);
    depths.sort_by(f64::total_cmp);
    depths.dedup();
    let faces = interfaces(foundation);
    for depth in depths {
        goes_on()?;
        residual.add(load_residual(&below, depth, DepthSide::Above));
        // Where two materials meet there are two sets of kernels; a rigid base has none.
        if faces.contains(&depth) {
            residual.add(load_residual(&below, depth, DepthSide::Below));
        }
    }
    answer.residual = residual.0;
    goes_on()?;
    Some(answer)
}

/// Returns the depths at which a search for the largest stresses looks, for a loaded area of
/// `radius`, elements of a size, and the deepest plane that is asked for.
pub(crate) fn depths_searched(
    foundation: &Foundation,
    radius: f64,
    element: f64,
    deepest: f64,
) -> usize {
    let last = last_depth(foundation, radius, deepest);
    spans(foundation, element.min(0.2 * radius), last).iter().map(|span| span.depths.len()).sum()
}

/// Returns how deep a search goes: beyond the deepest interface within reach, and to the deepest
/// plane that is asked for.
fn last_depth(foundation: &Foundation, radius: f64, deepest: f64) -> f64 {
    let within = |face: &f64| *face <= WITHIN_REACH * radius;
    let faces = interfaces(foundation).into_iter().filter(within);
    faces.map(|face| face * RATIO * RATIO).fold(DEEPEST * radius, f64::max).max(deepest)
}

/// Finds the largest stress of each measure: on the surface at the elements' centres, and below it
/// as a function of the place, between the depths that suit the contact.
fn search(
    below: &Subsurface<'_>,
    given: &[f64],
    cancellation: &Cancellation,
    answer: &mut Interior,
    residual: &mut Residual,
) -> Option<()> {
    let goes_on = || (!cancellation.is_requested()).then_some(());
    let mut largest = [LargestStress::default(); 2];
    if let Some(surface) = below.plane(0.0) {
        for (largest, measure) in largest.iter_mut().zip(MEASURES) {
            largest.surface = largest_on(below, &surface, measure);
        }
        residual.add(transform_residual(below, &surface));
    }
    let spans = if below.loaded() == 0 {
        Vec::new()
    } else {
        let [hx, hy] = below.fields.element;
        let [columns, rows] = &below.window;
        let radius = (below.loaded() as f64 * hx * hy / std::f64::consts::PI).sqrt();
        let narrow = (0.5 * columns.len() as f64 * hx).min(0.5 * rows.len() as f64 * hy);
        let deepest = given.iter().copied().fold(0.0, f64::max);
        let last = last_depth(below.foundation, radius, deepest);
        // Nearer to the surface than an element's side, its steps would be felt.
        spans(below.foundation, hx.max(hy).min(0.2 * narrow), last)
    };
    for span in &spans {
        let mut planes = Vec::new();
        for depth in &span.depths {
            goes_on()?;
            let plane = below.plane_on(*depth, span.side(*depth))?;
            let values = MEASURES.map(|measure| plane.stresses.par_iter().map(measure).collect());
            planes.push(MeasuredPlane { values });
        }
        for (index, largest) in largest.iter_mut().enumerate() {
            let candidates = candidates(below, span, &planes, index);
            for (plane, element) in candidates {
                let peak = refine(below, span, [plane, element], MEASURES[index], cancellation);
                goes_on()?;
                if largest.below.is_none_or(|best| peak.stress > best.stress) {
                    largest.below = Some(peak);
                }
            }
        }
    }
    let ends =
        [spans.first().and_then(|s| s.depths.first()), spans.last().and_then(|s| s.depths.last())];
    if let [Some(first), Some(last)] = ends {
        answer.searched = Some([*first, *last]);
    }
    let [von_mises, tresca] = largest;
    (answer.von_mises, answer.tresca) = (Some(von_mises), Some(tresca));
    Some(())
}

/// Returns the largest value of a measure on a plane.
fn largest_on(
    below: &Subsurface<'_>,
    plane: &PlaneStress,
    measure: fn(&Stress) -> f64,
) -> StressPeak {
    let values: Vec<f64> = plane.stresses.par_iter().map(measure).collect();
    let mut best = 0;
    for (element, value) in values.iter().enumerate() {
        if *value > values[best] {
            best = element;
        }
    }
    let [x, y] = below.center(best);
    StressPeak { stress: values[best], place: [x, y, plane.depth] }
}

/// Returns depths in geometric progression between two depths, cut where materials meet; at least
/// three in each material. A material that ends above the first depth has none.
fn spans(foundation: &Foundation, first: f64, last: f64) -> Vec<DepthSpan> {
    let mut faces = interfaces(foundation);
    if foundation.depth().is_none() {
        faces.push(f64::INFINITY);
    }
    let mut spans = Vec::new();
    let mut top = 0.0;
    for face in faces {
        let bottom = face.min(last);
        let start = first.max(top);
        // Between depths that are nearly one there is nothing to be found.
        if bottom > start * (1.0 + 1e-9) {
            let from = start.max(1e-3 * bottom);
            let steps = (((bottom / from).ln() / RATIO.ln()).ceil() as usize).max(2);
            let mut depths: Vec<f64> = (0..=steps)
                .map(|step| from * (bottom / from).powf(step as f64 / steps as f64))
                .collect();
            (depths[0], depths[steps]) = (start, bottom);
            spans.push(DepthSpan {
                depths,
                from_interface: top > 0.0 && start == top,
                open_above: start > top,
                open_below: bottom < face,
            });
        }
        top = face;
    }
    spans
}

/// Returns the planes and elements of the highest local maxima of a measure, apart from each other
/// and no more than a twentieth below the highest. Where a material goes on beyond the depths, the
/// plane at that end has none.
fn candidates(
    below: &Subsurface<'_>,
    span: &DepthSpan,
    planes: &[MeasuredPlane],
    measure: usize,
) -> Vec<(usize, usize)> {
    /// The most maxima that are looked at.
    const MOST: usize = 4;
    let [nx, ny] = below.fields.shape.map(|n| n as usize);
    let value = |plane: usize, element: usize| planes[plane].values[measure][element];
    let around = |place: usize, length: usize| place.saturating_sub(1)..(place + 2).min(length);
    let first = usize::from(span.open_above);
    let end = planes.len() - usize::from(span.open_below);
    let mut maxima: Vec<(usize, usize)> = (first..end)
        .into_par_iter()
        .flat_map_iter(|plane| {
            let is_highest = move |element: &usize| {
                let here = value(plane, *element);
                here > 0.0
                    && around(plane, planes.len()).all(|other| {
                        around(element / nx, ny).all(|j| {
                            around(element % nx, nx).all(|i| value(other, j * nx + i) <= here)
                        })
                    })
            };
            (0..nx * ny).filter(is_highest).map(move |element| (plane, element))
        })
        .collect();
    maxima.sort_by(|a, b| value(b.0, b.1).total_cmp(&value(a.0, a.1)).then(a.cmp(b)));
    let mut kept: Vec<(usize, usize)> = Vec::new();
    for (plane, element) in maxima {
        let is_high =
            kept.first().is_none_or(|best| value(plane, element) >= 0.95 * value(best.0, best.1));
        let is_apart = kept.iter().all(|other| {
            plane.abs_diff(other.0) > 1
                || (element % nx).abs_diff(other.1 % nx) > 2
                || (element / nx).abs_diff(other.1 / nx) > 2
        });
        if is_high && is_apart && kept.len() < MOST {
            kept.push((plane, element));
        }
    }
    kept
}

/// Climbs to the maximum near an element of a plane, no farther than the planes beside it; what a
/// climb finds that is cancelled means nothing.
fn refine(
    below: &Subsurface<'_>,
    span: &DepthSpan,
    [plane, element]: [usize; 2],
    measure: fn(&Stress) -> f64,
    cancellation: &Cancellation,
) -> StressPeak {
    let depths = &span.depths;
    let [hx, hy] = below.fields.element;
    let [x, y] = below.center(element);
    let (upper, lower) =
        (depths[plane.saturating_sub(1)], depths[(plane + 1).min(depths.len() - 1)]);
    let measured = |places: &[[f64; 3]]| -> Vec<f64> {
        if cancellation.is_requested() {
            return vec![f64::NAN; places.len()];
        }
        let mut found: Vec<f64> = places.iter().map(|place| place[2]).collect();
        found.sort_by(f64::total_cmp);
        found.dedup();
        let kernels: Vec<_> = found
            .par_iter()
            .map(|depth| below.kernels(*depth, span.side(*depth), [x, y]))
            .collect();
        places
            .par_iter()
            .map(|[x, y, z]| {
                let index = found.partition_point(|depth| depth < z);
                let kernels = kernels.get(index).and_then(Option::as_ref);
                kernels.map_or(f64::NAN, |kernels| measure(&below.sum(kernels, [*x, *y])))
            })
            .collect()
    };
    let bounds = [[x - 1.5 * hx, y - 1.5 * hy, upper], [x + 1.5 * hx, y + 1.5 * hy, lower]];
    let climbed = climb([x, y, depths[plane]], [hx, hy, 0.5 * (lower - upper)], bounds, measured);
    StressPeak { stress: climbed.value, place: climbed.place }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Base, Layer, Material};

    fn coated(thickness: f64) -> Foundation {
        let mut foundation = Foundation::half_space(Material { shear_modulus: 1.0, poisson: 0.3 });
        foundation.layers = vec![Layer { shear_modulus: 3.0, poisson: 0.3, thickness }];
        foundation
    }

    #[test]
    fn depths_begin_where_steps_of_traction_are_not_felt() {
        let ends = |spans: &[DepthSpan]| -> Vec<[f64; 2]> {
            spans.iter().map(|span| [span.depths[0], *span.depths.last().unwrap()]).collect()
        };
        let within = spans(&coated(0.3), 0.1, 2.5);
        assert_eq!(ends(&within), [[0.1, 0.3], [0.3, 2.5]]);
        assert!(within[0].open_above && !within[0].open_below && !within[0].from_interface);
        assert!(within[1].from_interface && !within[1].open_above && within[1].open_below);
        // A coating thinner than an element is left out, and the base above an element's depth.
        let thin = spans(&coated(0.05), 0.1, 2.5);
        assert_eq!(ends(&thin), [[0.1, 2.5]]);
        assert!(thin[0].open_above && !thin[0].from_interface);
        assert_eq!(ends(&spans(&coated(0.1), 0.1, 2.5)), [[0.1, 2.5]]);
        let rigid = Foundation { base: Base::Rigid, ..coated(0.05) };
        assert_eq!(spans(&rigid, 0.1, 2.5), []);
    }

    #[test]
    fn a_search_goes_beyond_interfaces_within_reach() {
        assert_eq!(last_depth(&coated(0.3), 1.0, 0.0), DEEPEST);
        assert_eq!(last_depth(&coated(3.0), 1.0, 0.0), 3.0 * RATIO * RATIO);
        assert_eq!(last_depth(&coated(11.0), 1.0, 0.0), DEEPEST);
        assert_eq!(last_depth(&coated(0.3), 1.0, 7.0), 7.0);
    }
}
