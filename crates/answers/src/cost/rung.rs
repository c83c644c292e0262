//! The rungs of a scene: settings with their error and their time.

use contact::model::{Mesh, Numerics, StepOutcome};
use contact::theory::{PowerLaw, power_law};
use study::Record;

use crate::evidence::{Evidence, end_of};
use crate::rows::digits;

/// A rung: settings, their error and their time.
pub(super) struct CostRung<'a> {
    /// The index of the point.
    pub(super) point: usize,
    /// The tolerance of the solver.
    pub(super) tolerance: f64,
    /// The index of its family: rungs that differ in mesh and tolerance only.
    pub(super) family: usize,
    /// The diagonal of an element \[m\].
    pub(super) h: f64,
    /// The number of elements.
    pub(super) elements: f64,
    /// The last increment.
    pub(super) end: &'a StepOutcome,
    /// The median time \[s\].
    pub(super) seconds: f64,
    /// The longest time less the shortest, over the median.
    pub(super) spread: f64,
    /// The noise of the time on either side, relative to the time.
    pub(super) noise: f64,
    /// The relative error as it is measured; NaN until it is.
    pub(super) error: f64,
    /// The relative error that can be relied on; NaN until it is known.
    pub(super) claim: f64,
}

/// The laws by which the error and the time of a family of rungs go with the mesh, at the tightest
/// tolerance.
#[derive(Default)]
pub(super) struct Laws {
    /// The error over the diagonal of an element.
    pub(super) order: Option<PowerLaw>,
    /// The time over the number of elements.
    pub(super) growth: Option<PowerLaw>,
}

/// Returns the certified rungs among some points.
pub(super) fn rungs_of<'a>(evidence: &Evidence<'a>, points: &[usize]) -> Vec<CostRung<'a>> {
    let mut families: Vec<Numerics> = Vec::new();
    let mut rungs = Vec::new();
    for point in points {
        let (Some(case), Some(record)) = (evidence.case(*point), evidence.certified(*point)) else {
            continue;
        };
        let Some(end) = end_of(record) else { continue };
        let shared = Numerics { mesh: Mesh::Across(1), tolerance: 0.5, ..case.numerics.clone() };
        let family = families.iter().position(|known| *known == shared).unwrap_or(families.len());
        if family == families.len() {
            families.push(shared);
        }
        let observables = &end.observables;
        rungs.push(CostRung {
            point: *point,
            tolerance: case.numerics.tolerance,
            family,
            h: observables.element_x.hypot(observables.element_y),
            elements: observables.mesh_x as f64 * observables.mesh_y as f64,
            end,
            seconds: record.provenance.seconds,
            spread: spread(record),
            noise: noise(record),
            error: f64::NAN,
            claim: f64::NAN,
        });
    }
    rungs
}

/// Returns the longest time of a job less the shortest, over the median.
fn spread(record: &Record) -> f64 {
    let times = &record.provenance.times;
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    let most = times.iter().copied().fold(0.0, f64::max);
    (most - least).max(0.0) / record.provenance.seconds
}

/// The least noise of a time, relative to it: jobs that do the same differ by so much, however
/// little the repetitions of each do.
const LEAST_NOISE: f64 = 0.05;

/// The noise of a time that was measured once, relative to it.
const NOISE_OF_ONE: f64 = 0.25;

/// Returns the noise of a job's time on either side, relative to the time: half the range of its
/// repetitions.
fn noise(record: &Record) -> f64 {
    match record.provenance.times[..] {
        [_, _, ..] => (0.5 * spread(record)).max(LEAST_NOISE),
        _ => NOISE_OF_ONE,
    }
}

/// Returns the rungs that differ from the best in their mesh only: those of the smallest tolerance
/// and ε, with the method and the projection of the first one.
pub(super) fn tightest<'r, 'a>(
    evidence: &Evidence<'_>,
    rungs: &'r [CostRung<'a>],
) -> Vec<&'r CostRung<'a>> {
    let numerics = |rung: &CostRung<'_>| evidence.case(rung.point).map(|case| &case.numerics);
    let least = |read: fn(&Numerics) -> f64| {
        rungs.iter().filter_map(numerics).map(read).fold(f64::INFINITY, f64::min)
    };
    let tolerance = least(|numerics| numerics.tolerance);
    let epsilon = least(|numerics| numerics.epsilon);
    let Some(first) = rungs.iter().find_map(numerics) else { return Vec::new() };
    let is_tight = |numerics: &Numerics| {
        numerics.tolerance == tolerance
            && numerics.epsilon == epsilon
            && numerics.method == first.method
            && numerics.projection == first.projection
    };
    rungs.iter().filter(|rung| numerics(rung).is_some_and(is_tight)).collect()
}

impl Laws {
    /// Fits the laws of each family, to errors that the reference is certain enough to tell.
    pub(super) fn of_families(rungs: &[CostRung<'_>], uncertainty: f64) -> Vec<Laws> {
        let count = rungs.iter().map(|rung| rung.family + 1).max().unwrap_or(0);
        (0..count).map(|family| Laws::of(rungs, family, uncertainty)).collect()
    }

    fn of(rungs: &[CostRung<'_>], family: usize, uncertainty: f64) -> Self {
        let members = || rungs.iter().filter(|rung| rung.family == family);
        let least = members().map(|rung| rung.tolerance).fold(f64::INFINITY, f64::min);
        let mut line: Vec<&CostRung<'_>> =
            members().filter(|rung| rung.tolerance == least).collect();
        // From the coarsest mesh to the finest.
        line.sort_by(|a, b| b.h.total_cmp(&a.h));
        let errors: Vec<(f64, f64)> = line
            .iter()
            .filter(|rung| rung.error > uncertainty)
            .map(|rung| (rung.h, rung.error))
            .collect();
        let times: Vec<(f64, f64)> =
            line.iter().map(|rung| (rung.elements, rung.seconds)).collect();
        Laws { order: power_law(&errors).ok(), growth: power_law(&times).ok() }
    }
}

/// Sets the error that each rung may claim: the largest of its own error, the errors of all finer
/// and tighter rungs of its family (so that no rung looks good by chance) and the family's fitted
/// law at its mesh, plus the uncertainty of the reference.
pub(super) fn claim(rungs: &mut [CostRung<'_>], laws: &[Laws], uncertainty: f64) {
    let claims: Vec<f64> = rungs
        .iter()
        .map(|rung| {
            let is_finer = |other: &&CostRung<'_>| {
                other.family == rung.family
                    && other.h <= rung.h
                    && other.tolerance <= rung.tolerance
            };
            let largest =
                rungs.iter().filter(is_finer).map(|other| other.error).fold(0.0, f64::max);
            // A line that does not fall tells nothing.
            let law = laws[rung.family]
                .order
                .as_ref()
                .filter(|law| law.slope > 0.0 && rung.h <= law.range[0]);
            largest.max(law.map_or(0.0, |law| law.at(rung.h))) + uncertainty
        })
        .collect();
    rungs.iter_mut().zip(claims).for_each(|(rung, claim)| rung.claim = two_digits_up(claim));
}

/// Rounds up to two digits, so that no rung seems better for a third one.
fn two_digits_up(x: f64) -> f64 {
    if x <= 0.0 || !x.is_finite() {
        return x;
    }
    let unit = 10_f64.powi(x.log10().floor() as i32 - 1);
    // A number that has two digits already keeps them.
    digits((x / unit - 1e-9).ceil() * unit, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rungs of h, tolerance, family and error.
    fn rungs<'e>(end: &'e StepOutcome, of: &[(f64, f64, usize, f64)]) -> Vec<CostRung<'e>> {
        let rung = |(point, (h, tolerance, family, error)): (usize, &(f64, f64, usize, f64))| {
            let (h, tolerance, family, error) = (*h, *tolerance, *family, *error);
            let elements = (1.0 / h).powi(2);
            CostRung {
                point,
                tolerance,
                family,
                h,
                elements,
                end,
                seconds: 1e-6 * elements,
                spread: 0.0,
                noise: 0.05,
                error,
                claim: f64::NAN,
            }
        };
        of.iter().enumerate().map(rung).collect()
    }

    fn claims(of: &[(f64, f64, usize, f64)], families: usize, uncertainty: f64) -> Vec<f64> {
        let end = StepOutcome::default();
        let mut rungs = rungs(&end, of);
        let laws: Vec<Laws> =
            (0..families).map(|family| Laws::of(&rungs, family, uncertainty)).collect();
        claim(&mut rungs, &laws, uncertainty);
        rungs.iter().map(|rung| rung.claim).collect()
    }

    #[test]
    fn a_rung_that_is_good_by_chance_claims_what_finer_ones_have() {
        let claimed = claims(
            &[
                (0.4, 1e-8, 0, 0.1),
                (0.2, 1e-8, 0, 1e-6),
                (0.1, 1e-8, 0, 0.01),
                (0.05, 1e-8, 0, 0.004),
            ],
            1,
            1e-3,
        );
        assert!(
            claimed[0] >= 0.101 && claimed[1] >= 0.011,
            "the second error is one of a change of sign: {claimed:?}"
        );
        // a loose solve of a fine mesh does not tell of tight ones
        assert_eq!(claims(&[(0.2, 1e-8, 0, 0.01), (0.1, 1e-2, 0, 0.5)], 1, 0.0), [0.01, 0.5]);
        // another family is not told of
        assert_eq!(claims(&[(0.2, 1e-8, 0, 0.01), (0.1, 1e-8, 1, 0.5)], 2, 0.0), [0.01, 0.5]);
    }

    #[test]
    fn claims_have_two_digits() {
        assert_eq!(
            [0.01, 0.0101, 0.0999, 3.5e-5, 0.0].map(two_digits_up),
            [0.01, 0.011, 0.1, 3.5e-5, 0.0]
        );
    }

    #[test]
    fn nothing_below_the_uncertainty_of_the_reference_is_claimed() {
        let line: Vec<_> = [0.4_f64, 0.2, 0.1, 0.05, 0.025].map(|h| (h, 1e-8, 0, h * h)).to_vec();
        let claimed = claims(&line, 1, 0.1);
        assert!(claimed.iter().all(|claim| *claim >= 0.1), "{claimed:?}");
        let end = StepOutcome::default();
        assert!(
            Laws::of(&rungs(&end, &line), 0, 0.1).order.is_none(),
            "one error is left, no line"
        );
        let laws = Laws::of(&rungs(&end, &line), 0, 1e-9);
        assert!(
            (laws.order.unwrap().slope - 2.0).abs() < 1e-9
                && (laws.growth.unwrap().slope - 1.0).abs() < 1e-9
        );
    }

    #[test]
    fn the_finest_rung_is_not_better_than_its_law() {
        let mut line: Vec<_> =
            [0.4_f64, 0.2, 0.1, 0.05, 0.025].map(|h| (h, 1e-8, 0, h * h)).to_vec();
        line[4].3 *= 0.95;
        let claimed = claims(&line, 1, 0.0);
        assert!(claimed[4] > line[4].3, "{claimed:?}");
    }

    #[test]
    fn families_have_laws_of_their_own() {
        let of = |family: usize, order: i32| {
            [0.4_f64, 0.2, 0.1, 0.05].map(|h| (h, 1e-8, family, h.powi(order)))
        };
        let end = StepOutcome::default();
        let all = rungs(&end, &[of(0, 1), of(1, 2)].concat());
        let order = |family: usize| Laws::of(&all, family, 0.0).order.unwrap().slope;
        assert!((order(0) - 1.0).abs() < 1e-9 && (order(1) - 2.0).abs() < 1e-9);
    }
}
