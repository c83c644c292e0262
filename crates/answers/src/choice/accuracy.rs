//! Accuracy in place of a mesh: the cheapest settings that reach it, by what is known of the same
//! scene on any mesh.
//!
//! Of what was solved, the coarsest mesh counts whose own estimates are within the accuracy, and on
//! it the loosest tolerance. Where there is none yet, meshes are tried: 8 and 16 elements across Ω,
//! then what the order with which the estimates fall predicts, but no more than twice as many at a
//! time, four times from the third mesh on.

use std::collections::{HashMap, HashSet};

use contact::model::{Mesh, Numerics};
use contact::theory::power_law;
use identity::JobKey;
use study::accuracy::FIRST;
use study::columns::find;
use study::{Accuracy, Case, Column, Job, Record, Study, StudyPoint};

use super::found::Found;

/// What was solved of a scene with some settings.
struct Rung<'a> {
    case: Case,
    record: &'a Record,
    /// Elements of the grid.
    elements: [u32; 2],
    /// Estimated relative error by which the mesh is too coarse; `None` where there is none.
    coarse: Option<f64>,
    /// Estimated relative error that the solver left.
    left: f64,
}

impl Rung<'_> {
    fn error(&self) -> Option<f64> {
        Some(self.coarse? + self.left)
    }

    fn across(&self) -> Option<u32> {
        match self.case.numerics.mesh {
            Mesh::Across(n) => Some(n),
            Mesh::Exact(_) => None,
        }
    }
}

/// What is known of the scenes of a study, on any mesh.
pub(super) struct Learnt<'a>(HashMap<&'a str, Vec<&'a Record>>);

impl<'a> Learnt<'a> {
    /// Sorts records by their scenes.
    pub(super) fn of(records: &'a HashMap<JobKey, Record>) -> Self {
        let mut known: HashMap<&str, Vec<&Record>> = HashMap::new();
        for record in records.values() {
            if let Some(scene) = Job::scene_in(&record.job) {
                known.entry(scene).or_default().push(record);
            }
        }
        Self(known)
    }
}

/// The scenes of a study, as their jobs' canonical texts have them.
pub(super) fn scenes(study: &Study) -> HashSet<String> {
    study.points().iter().filter_map(|point| point.job.scene_text()).collect()
}

/// Whether the canonical text of a job solves one of these scenes.
pub(super) fn solves(scenes: &HashSet<String>, job: &str) -> bool {
    Job::scene_in(job).is_some_and(|scene| scenes.contains(scene))
}

/// The settings for the point with an index: those to use, or those to try next.
pub(super) fn choose(
    study: &Study,
    accuracy: &Accuracy,
    columns: &[Column],
    learnt: &Learnt<'_>,
    index: usize,
) -> Option<(StudyPoint, Found)> {
    let first = study.point(index)?;
    let Job::Solve(wanted) = &first.job else { return None };
    let tolerance = accuracy.tolerance(&first.job);
    // the study's own, if it has one
    let tolerance =
        study.point_as_exact(index, Mesh::Across(FIRST), tolerance)?.job.case()?.numerics.tolerance;
    let is_given = study
        .point_as_exact(index, Mesh::Across(FIRST), 0.5 * tolerance)?
        .job
        .case()?
        .numerics
        .tolerance
        == tolerance;
    let estimate = find(columns, &format!("estimate_{}", accuracy.of(&first.job)))?;
    let scene = first.job.scene_text()?;
    let mut rungs: Vec<Rung<'_>> = Vec::new();
    for record in learnt.0.get(&scene[..]).into_iter().flatten() {
        let Ok(Job::Solve(case) | Job::Cost { case, .. }) = record.parse_job() else { continue };
        let own = Numerics {
            mesh: wanted.numerics.mesh,
            tolerance: wanted.numerics.tolerance,
            ..case.numerics.clone()
        };
        if own != wanted.numerics
            || is_given && case.numerics.tolerance != tolerance
            || !record.is_current()
        {
            continue;
        }
        let end = record.outcome().and_then(|outcome| outcome.last()).map(|end| &end.observables);
        let elements = end
            .map_or([0; 2], |o| [o.mesh_x, o.mesh_y].map(|n| u32::try_from(n).unwrap_or(u32::MAX)));
        let is_solved = record.is_certified();
        let coarse = estimate.value(&first, Some(record)).as_f64().filter(|_| is_solved);
        let left = record
            .outcome()
            .and_then(|outcome| outcome.estimate)
            .map_or(0.0, |estimate| estimate.solver);
        rungs.push(Rung { case, record, elements, coarse, left });
    }
    // the cheapest first: the time is as the number of elements, and a looser tolerance saves some
    // of it
    let product = |[x, y]: [u32; 2]| u64::from(x) * u64::from(y);
    rungs.sort_by(|a, b| {
        let by_settings = product(a.elements)
            .cmp(&product(b.elements))
            .then(b.case.numerics.tolerance.total_cmp(&a.case.numerics.tolerance));
        by_settings.then_with(|| a.record.job.cmp(&b.record.job))
    });
    let at = |mesh: Mesh, tolerance: f64| study.point_as_exact(index, mesh, tolerance);
    if let Some(rung) =
        rungs.iter().find(|rung| rung.error().is_some_and(|error| error <= accuracy.is))
    {
        let point = at(rung.case.numerics.mesh, rung.case.numerics.tolerance)?;
        let found = Found::Within {
            mesh: rung.elements,
            tolerance: rung.case.numerics.tolerance,
            error: rung.error()?,
        };
        // a study of cost may have solved it without leaving what a study of solutions wants
        let is_there = rungs.iter().any(|rung| rung.record.key() == point.key);
        return Some(if is_there {
            (point, found)
        } else {
            (point, next(rung.case.numerics.mesh, rung.case.numerics.tolerance))
        });
    }

    let (exact, loose): (Vec<&Rung<'_>>, Vec<&Rung<'_>>) = rungs
        .iter()
        .filter(|rung| rung.across().is_some())
        .partition(|rung| rung.case.numerics.tolerance <= tolerance);
    let tried = exact.iter().filter_map(|rung| rung.across()).max();
    // what a loose solve tells of a mesh, for which the solver is to leave a tenth
    let (enough, too_few): (Vec<&&Rung<'_>>, Vec<&&Rung<'_>>) = loose
        .iter()
        .filter(|rung| rung.coarse.is_some())
        .partition(|rung| rung.coarse.is_some_and(|coarse| coarse <= 0.9 * accuracy.is));
    let finest = too_few.iter().filter_map(|rung| rung.across()).chain(tried).max();
    let hint = enough.iter().filter_map(|rung| rung.across());
    let hint =
        hint.filter(|n| finest.is_none_or(|finest| *n > finest) && *n <= accuracy.at_most).min();
    let ended = |why: &'static str| {
        let best = exact
            .iter()
            .filter(|rung| rung.error().is_some())
            .min_by(|a, b| a.error().unwrap_or(f64::NAN).total_cmp(&b.error().unwrap_or(f64::NAN)));
        let rung = best.or(exact.last())?;
        let settings = &rung.case.numerics;
        let found = Found::Beyond {
            mesh: rung.elements,
            tolerance: settings.tolerance,
            error: rung.error(),
            why,
        };
        let point = at(settings.mesh, settings.tolerance)?;
        let is_there = rungs.iter().any(|rung| rung.record.key() == point.key);
        Some(if is_there {
            (point, found)
        } else {
            (point, next(settings.mesh, settings.tolerance))
        })
    };
    let last = |n: usize, is: fn(&&&Rung<'_>) -> bool| {
        exact.len() >= n && exact.iter().rev().take(n).filter(is).count() == n
    };
    if last(2, |rung| !rung.record.is_certified()) {
        return ended("a job was not solved");
    }
    if last(3, |rung| rung.record.is_certified() && rung.coarse.is_none()) {
        return ended("no error of it is estimated");
    }
    if exact.last().is_some_and(|rung| rung.left >= accuracy.is) {
        return ended("the solver leaves more than that");
    }
    if tried.is_some_and(|tried| tried >= accuracy.at_most) {
        return ended("not reached on the finest mesh allowed");
    }
    let known: Vec<(f64, f64)> = {
        let all = exact
            .iter()
            .chain(&loose)
            .filter_map(|rung| Some((f64::from(rung.across()?), rung.coarse?)));
        let mut all: Vec<(f64, f64)> = all.filter(|(_, coarse)| *coarse > 0.0).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.dedup_by_key(|(n, _)| *n);
        all
    };
    let mesh = hint.unwrap_or_else(|| further(finest, &known, accuracy.is)).min(accuracy.at_most);
    let point = at(Mesh::Across(mesh), tolerance)?;
    Some((point, next(Mesh::Across(mesh), tolerance)))
}

fn next(mesh: Mesh, tolerance: f64) -> Found {
    let mesh = match mesh {
        Mesh::Across(n) => [n, n],
        Mesh::Exact(sides) => sides,
    };
    Found::Next { mesh, tolerance }
}

/// Elements across Ω to try after the `finest`, by the estimates on meshes so far, coarse to fine.
fn further(finest: Option<u32>, known: &[(f64, f64)], accuracy: f64) -> u32 {
    let Some(finest) = finest else { return FIRST };
    let twice = finest.saturating_mul(2);
    let (Some((from, _)), Ok(law)) = (known.last(), power_law(known)) else { return twice };
    let order = (-law.slope).clamp(0.5, 3.0);
    // on the fitted line, for estimates go up and down with where the edges of elements lie, and
    // with a fifth to spare
    let predicted = from * (law.at(*from) / (0.8 * accuracy)).powf(1.0 / order);
    round_up(predicted, finest).min(finest.saturating_mul(4))
}

/// The next of 8, 12, 16, 24, 32, … from `n` on that is more than `finest`: they halve well, and
/// other studies have them too.
fn round_up(n: f64, finest: u32) -> u32 {
    let powers = (3..24).map(|k| 1_u32 << k);
    let mut meshes = powers.flat_map(|n| [n, n / 2 * 3]);
    meshes.find(|mesh| *mesh > finest && f64::from(*mesh) >= n).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_mesh_follows_from_the_order() {
        assert_eq!(further(None, &[], 1e-3), FIRST);
        assert_eq!(further(Some(8), &[(8.0, 0.1)], 1e-3), 16, "one mesh has no order");
        let second: Vec<(f64, f64)> = [8.0_f64, 16.0, 32.0].map(|n| (n, n.powi(-2))).to_vec();
        assert_eq!(
            further(Some(16), &second[..2], 1e-3),
            32,
            "two meshes are not trusted further than twice"
        );
        // 0.8 · 3e-4 on 65 elements
        assert_eq!(further(Some(32), &second, 3e-4), 96);
        assert_eq!(further(Some(32), &second, 1e-9), 128);
        assert_eq!(further(Some(32), &second, 0.1), 48, "always finer than what failed");
    }
}
