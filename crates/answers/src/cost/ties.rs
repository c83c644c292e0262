//! The cheapest rungs, where times within the noise of each other are ties.

use std::cmp::Ordering;

use report::{NoisyPoint, pareto_front_within};

use super::rung::CostRung;

/// A rung that is as cheap as any other for what it is chosen for.
pub(super) struct CheapestRung<'r, 'a> {
    pub(super) rung: &'r CostRung<'a>,
    /// The other rungs that are as cheap within the noise, and do no better.
    pub(super) ties: Vec<&'r CostRung<'a>>,
}

/// Returns the rungs that no other one beats in both error and time, from the largest error to the
/// smallest. Of rungs that are tied in both, one stands for all.
pub(super) fn cheapest_for_their_error<'r, 'a>(
    rungs: &'r [CostRung<'a>],
) -> Vec<CheapestRung<'r, 'a>> {
    let points: Vec<NoisyPoint> = rungs.iter().map(spot).collect();
    let mut front: Vec<&CostRung<'_>> =
        pareto_front_within(&points).into_iter().map(|index| &rungs[index]).collect();
    front.sort_by(|a, b| b.claim.total_cmp(&a.claim).then(by_effort(a, b)));
    front.dedup_by_key(|rung| rung.claim);
    let mut choices: Vec<CheapestRung<'_, '_>> =
        front.iter().map(|rung| CheapestRung { rung, ties: Vec::new() }).collect();
    let is_chosen = |rung: &CostRung<'_>| front.iter().any(|chosen| chosen.point == rung.point);
    let mut others: Vec<&CostRung<'_>> =
        rungs.iter().filter(|rung| !is_chosen(rung) && !is_clearly_beaten(rung, rungs)).collect();
    others.sort_by(|a, b| by_effort(a, b));
    for other in others {
        // What is tied with several is named beside the one whose error is the closest.
        let is_alike = |choice: &&mut CheapestRung<'_, '_>| {
            choice.rung.claim <= other.claim && spot(choice.rung).is_tied(&spot(other))
        };
        if let Some(choice) = choices.iter_mut().find(is_alike) {
            choice.ties.push(other);
        }
    }
    choices
}

/// Returns the cheapest rung whose error is within a target; of those that are tied, the one with
/// the smallest error. `None` if no rung reaches it.
pub(super) fn cheapest_within<'r, 'a>(
    rungs: &'r [CostRung<'a>],
    target: f64,
) -> Option<CheapestRung<'r, 'a>> {
    let reaching: Vec<&CostRung<'_>> = rungs.iter().filter(|rung| rung.claim <= target).collect();
    let is_cheapest =
        |rung: &&&CostRung<'_>| reaching.iter().all(|other| !is_clearly_cheaper(other, rung));
    let mut cheapest: Vec<&CostRung<'_>> = reaching.iter().filter(is_cheapest).copied().collect();
    cheapest.sort_by(|a, b| a.claim.total_cmp(&b.claim).then(by_effort(a, b)));
    let (rung, ties) = cheapest.split_first()?;
    Some(CheapestRung { rung, ties: ties.to_vec() })
}

/// Returns whether two times cannot be told apart.
pub(super) fn is_tied(a: &CostRung<'_>, b: &CostRung<'_>) -> bool {
    spot(a).is_tied(&spot(b))
}

fn spot(rung: &CostRung<'_>) -> NoisyPoint {
    NoisyPoint { x: rung.seconds, noise: rung.noise, y: rung.claim }
}

fn is_clearly_cheaper(rung: &CostRung<'_>, other: &CostRung<'_>) -> bool {
    rung.seconds < other.seconds && !is_tied(rung, other)
}

/// Returns whether some rung is clearly cheaper and does no worse.
fn is_clearly_beaten(rung: &CostRung<'_>, rungs: &[CostRung<'_>]) -> bool {
    rungs.iter().any(|other| other.claim <= rung.claim && is_clearly_cheaper(other, rung))
}

/// Orders rungs by the effort that their settings ask for, whatever the noise makes of it: few
/// elements before many, a loose tolerance before a tight one.
fn by_effort(a: &CostRung<'_>, b: &CostRung<'_>) -> Ordering {
    a.elements
        .total_cmp(&b.elements)
        .then(b.tolerance.total_cmp(&a.tolerance))
        .then(a.point.cmp(&b.point))
}

#[cfg(test)]
mod tests {
    use contact::model::StepOutcome;

    use super::*;

    /// The elements along a side, the tolerance, the time and the claim of a rung.
    struct Rung(f64, f64, f64, f64);

    /// Makes rungs of these, with a noise of 10 %, and returns what `choose` says of them: the
    /// indices of each choice, then those of its ties.
    fn chosen(
        rungs: &[Rung],
        choose: impl for<'r, 'a> Fn(&'r [CostRung<'a>]) -> Vec<CheapestRung<'r, 'a>>,
    ) -> Vec<Vec<usize>> {
        let end = StepOutcome::default();
        let rung = |(point, Rung(side, tolerance, seconds, claim)): (usize, &Rung)| CostRung {
            point,
            tolerance: *tolerance,
            family: 0,
            h: 1.0 / side,
            elements: side * side,
            end: &end,
            seconds: *seconds,
            spread: 0.2,
            noise: 0.1,
            error: *claim,
            claim: *claim,
        };
        let rungs: Vec<CostRung<'_>> = rungs.iter().enumerate().map(rung).collect();
        let points = |CheapestRung { rung, ties }: CheapestRung<'_, '_>| {
            [rung].into_iter().chain(ties).map(|rung| rung.point).collect()
        };
        choose(&rungs).into_iter().map(points).collect()
    }

    #[test]
    fn a_tight_solve_is_not_cheaper_than_a_loose_one_by_noise() {
        let rungs = [
            Rung(12.0, 1e-8, 0.99e-3, 0.01),
            Rung(12.0, 1e-2, 1.00e-3, 0.01),
            Rung(24.0, 1e-8, 9e-3, 0.002),
            Rung(8.0, 1e-2, 1.05e-3, 0.03),
            Rung(16.0, 1e-2, 2e-3, 0.04),
        ];
        assert_eq!(
            chosen(&rungs, cheapest_for_their_error),
            [vec![1, 3, 0], vec![2]],
            "the loose one stands for both, and the clearly dearer one is left out"
        );
        let mut swapped = rungs;
        (swapped[0].2, swapped[1].2) = (swapped[1].2, swapped[0].2);
        assert_eq!(
            chosen(&swapped, cheapest_for_their_error),
            [vec![1, 3, 0], vec![2]],
            "the order does not hang on the noise"
        );
    }

    #[test]
    fn the_cheapest_for_a_target_is_the_best_of_the_ties() {
        let rungs = [
            Rung(8.0, 1e-2, 1.00e-3, 0.09),
            Rung(12.0, 1e-2, 1.05e-3, 0.02),
            Rung(24.0, 1e-2, 5e-3, 0.001),
        ];
        let within = |target: f64| {
            chosen(&rungs, |rungs| cheapest_within(rungs, target).into_iter().collect())
        };
        assert_eq!(within(0.1), [[1, 0]]);
        assert_eq!(within(0.01), [[2]]);
        assert!(within(1e-4).is_empty());
    }
}
