//! The largest stresses below the surface, and the answer to what a scene asks.

use rayon::prelude::*;

use super::balance::{load_residual, transform_residual};
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

/// Depths in one material, from its upper end down.
#[derive(Clone, Debug)]
struct DepthSpan {
    depths: Vec<f64>,
    /// The flag is true if the first depth is the upper end of the material: its stresses are those
    /// below it.
    from_interface: bool,
    /// The flag is true if a stress may be largest at the first depth only because it grows towards
    /// the surface.
    open_above: bool,
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

/// Answers what is asked of the stresses below the tractions of `fields`. Returns `None` if it is
/// cancelled.
pub fn examine(
    foundation: &Foundation,
    question: &InteriorQuestion,
    fields: &Fields,
    cancellation: &Cancellation,
) -> Option<Interior> {
    let below = Subsurface::new(foundation, fields);
    let mut answer = Interior::default();
    for depth in &question.depths {
        if cancellation.is_requested() {
            return None;
        }
        let Some(plane) = below.plane(*depth) else { continue };
        answer.planes.push(PlanePeaks {
            depth: *depth,
            von_mises: largest_on(&below, &plane, Stress::von_mises),
            tresca: largest_on(&below, &plane, Stress::tresca),
        });
        answer.residual = answer.residual.max(transform_residual(&below, &plane));
    }
    answer.points = question
        .points
        .par_iter()
        .filter_map(|place| Some(PointStress { place: *place, stress: below.at(*place)? }))
        .collect();
    if question.maximum {
        search(&below, &question.depths, cancellation, &mut answer)?;
    }
    let searched = answer.von_mises.and_then(|largest| largest.below);
    let depths = searched.map(|peak| peak.place[2]).into_iter();
    let given = question.depths.iter().copied().chain(question.points.iter().map(|point| point[2]));
    if let Some(depth) = depths.chain(given).find(|depth| *depth > 0.0) {
        answer.residual = answer.residual.max(load_residual(&below, depth, DepthSide::Above));
    }
    Some(answer)
}

/// Returns the depths at which a search for the largest stresses looks that is given no depths, for
/// a loaded area of `radius` and elements of a size.
pub(crate) fn depths_searched(foundation: &Foundation, radius: f64, element: f64) -> usize {
    spans(foundation, element.min(0.2 * radius), DEEPEST * radius)
        .iter()
        .map(|span| span.depths.len())
        .sum()
}

/// Finds the largest stress of each measure: on the surface at the elements' centres, and below it
/// as a function of the place, in the depths given or between those that suit the contact.
fn search(
    below: &Subsurface<'_>,
    given: &[f64],
    cancellation: &Cancellation,
    answer: &mut Interior,
) -> Option<()> {
    let mut largest = [LargestStress::default(); 2];
    if let Some(surface) = below.plane(0.0) {
        for (largest, measure) in largest.iter_mut().zip(MEASURES) {
            largest.surface = largest_on(below, &surface, measure);
        }
        answer.residual = answer.residual.max(transform_residual(below, &surface));
    }
    let spans = if below.loaded() == 0 {
        Vec::new()
    } else if given.is_empty() {
        let [hx, hy] = below.fields.element;
        let [columns, rows] = &below.window;
        let radius = (below.loaded() as f64 * hx * hy / std::f64::consts::PI).sqrt();
        let narrow = (0.5 * columns.len() as f64 * hx).min(0.5 * rows.len() as f64 * hy);
        // Nearer to the surface than an element's side, its steps would be felt.
        spans(below.foundation, hx.max(hy).min(0.2 * narrow), DEEPEST * radius)
    } else {
        given_spans(below.foundation, given)
    };
    for span in &spans {
        let mut planes = Vec::new();
        for depth in &span.depths {
            if cancellation.is_requested() {
                return None;
            }
            let plane = below.plane_on(*depth, span.side(*depth))?;
            let values = MEASURES.map(|measure| plane.stresses.par_iter().map(measure).collect());
            planes.push(MeasuredPlane { values });
        }
        for (index, largest) in largest.iter_mut().enumerate() {
            let candidates = candidates(below, span, &planes, index);
            for (plane, element) in candidates {
                let peak = refine(below, span, [plane, element], MEASURES[index]);
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
/// three in each material.
fn spans(foundation: &Foundation, first: f64, last: f64) -> Vec<DepthSpan> {
    let mut faces = interfaces(foundation);
    if foundation.depth().is_none() {
        faces.push(f64::INFINITY);
    }
    let mut spans = Vec::new();
    let mut top = 0.0;
    for (index, face) in faces.into_iter().enumerate() {
        let bottom = face.min(last);
        if bottom <= top {
            break;
        }
        let start = if index > 0 {
            top
        } else if first < 0.5 * bottom {
            first
        } else {
            bottom / 3.0
        };
        let from = start.max(1e-3 * bottom);
        let steps = (((bottom / from).ln() / RATIO.ln()).ceil() as usize).max(2);
        let mut depths: Vec<f64> = (0..=steps)
            .map(|step| from * (bottom / from).powf(step as f64 / steps as f64))
            .collect();
        (depths[0], depths[steps]) = (start, bottom);
        spans.push(DepthSpan { depths, from_interface: index > 0, open_above: index == 0 });
        top = bottom;
    }
    spans
}

/// Returns the given depths below the surface by material.
fn given_spans(foundation: &Foundation, given: &[f64]) -> Vec<DepthSpan> {
    let mut depths: Vec<f64> = given.iter().copied().filter(|depth| *depth > 0.0).collect();
    depths.sort_by(f64::total_cmp);
    depths.dedup();
    let faces = interfaces(foundation);
    let material =
        |depth: f64| faces.iter().filter(|face| !DepthSide::Above.is_above(depth, **face)).count();
    depths
        .chunk_by(|a, b| material(*a) == material(*b))
        .map(|depths| DepthSpan {
            depths: depths.to_vec(),
            from_interface: false,
            open_above: false,
        })
        .collect()
}

/// Returns the planes and elements of the highest local maxima of a measure, apart from each other
/// and no more than a twentieth below the highest.
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
    let mut maxima: Vec<(usize, usize)> = (first..planes.len())
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

/// Climbs to the maximum near an element of a plane, no farther than the planes beside it.
fn refine(
    below: &Subsurface<'_>,
    span: &DepthSpan,
    [plane, element]: [usize; 2],
    measure: fn(&Stress) -> f64,
) -> StressPeak {
    let depths = &span.depths;
    let [hx, hy] = below.fields.element;
    let [x, y] = below.center(element);
    let (upper, lower) =
        (depths[plane.saturating_sub(1)], depths[(plane + 1).min(depths.len() - 1)]);
    let measured = |places: &[[f64; 3]]| -> Vec<f64> {
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
