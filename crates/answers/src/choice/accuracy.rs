//! Chooses a mesh for an accuracy: the cheapest settings that reach it, by what is known of the
//! same scene on any mesh.
//!
//! Among the meshes that were solved, the coarsest one counts whose estimates are within the
//! accuracy, and on it the loosest tolerance. Where there is none yet, meshes are tried: 8 and 16
//! elements across Ω, then what the order with which the estimates fall predicts, but no more than
//! twice as many at a time, four times from the third mesh on.

use std::collections::{HashMap, HashSet};

use contact::model::{Mesh, Numerics};
use contact::theory::power_law;
use study::accuracy::FIRST;
use study::columns::find;
use study::{Accuracy, Case, Column, Job, Record, Study, StudyPoint};

use super::found::{Discovery, Finding, PointChoice};
use crate::error::AnswerError;
use crate::evidence::end_of;
use crate::place::StudyPlace;
use crate::records::RecordMap;

/// Returns the scenes of a study, as their jobs' canonical texts have them.
pub(super) fn scenes(study: &Study) -> HashSet<String> {
    study.points().iter().filter_map(|point| point.job.scene_text()).collect()
}

/// Tells whether the job with a canonical text solves one of these scenes.
pub(super) fn solves(scenes: &HashSet<String>, job: &str) -> bool {
    Job::scene_in(job).is_some_and(|scene| scenes.contains(scene))
}

/// Chooses the settings of every point of a study.
pub(super) fn choose(
    study: &Study,
    accuracy: &Accuracy,
    records: &RecordMap,
) -> Result<PointChoice, AnswerError> {
    let columns = study.columns();
    let mut known: HashMap<&str, Vec<&Record>> = HashMap::new();
    for record in records.values() {
        if let Some(scene) = Job::scene_in(&record.job) {
            known.entry(scene).or_default().push(record);
        }
    }
    let mut choice = PointChoice::default();
    for index in study.indices() {
        let chosen = MeshSearch::new(study, accuracy, &columns, index)
            .and_then(|search| search.choose(&known))
            .ok_or(AnswerError::Inconsistent("a point of the study cannot be made"))?;
        let place = StudyPlace::of(study, &chosen.point, |_| true);
        choice.findings.push(Finding { place, discovery: chosen.discovery });
        choice.points.push(chosen.point);
    }
    Ok(choice)
}

/// A point with the settings that were chosen for it, and the reason.
struct ChosenSettings {
    point: StudyPoint,
    discovery: Discovery,
}

/// The result of a scene with some settings.
struct SolvedSettings<'a> {
    case: Case,
    record: &'a Record,
    /// The elements of the grid along x and y.
    elements: [u32; 2],
    /// The estimated relative error by which the mesh is too coarse, if there is an estimate.
    mesh_error: Option<f64>,
    /// The estimated relative error that the solver has left.
    solver_error: f64,
}

impl SolvedSettings<'_> {
    fn error(&self) -> Option<f64> {
        Some(self.mesh_error? + self.solver_error)
    }

    /// Returns the elements across Ω, if that is how the mesh is given.
    fn across(&self) -> Option<u32> {
        match self.case.numerics.mesh {
            Mesh::Across(n) => Some(n),
            Mesh::Exact(_) => None,
        }
    }

    fn count(&self) -> u64 {
        let [x, y] = self.elements;
        u64::from(x) * u64::from(y)
    }
}

/// The search for the settings of one point.
struct MeshSearch<'a> {
    study: &'a Study,
    accuracy: &'a Accuracy,
    index: usize,
    /// The point on the mesh that stands in the study until another one is chosen.
    first: StudyPoint,
    /// The column of the estimated error that counts.
    estimate: &'a Column,
    /// The tolerance that the accuracy takes, or the study's if it gives one.
    tolerance: f64,
    is_tolerance_given: bool,
}

impl<'a> MeshSearch<'a> {
    /// Returns the search for the point with an index; `None` for a point that cannot be made.
    fn new(
        study: &'a Study,
        accuracy: &'a Accuracy,
        columns: &'a [Column],
        index: usize,
    ) -> Option<Self> {
        let first = study.point(index)?;
        let with_tolerance = |tolerance: f64| {
            let point = study.point_as_exact(index, Mesh::Across(FIRST), tolerance)?;
            Some(point.job.case()?.numerics.tolerance)
        };
        let tolerance = with_tolerance(accuracy.tolerance(&first.job))?;
        let is_tolerance_given = with_tolerance(0.5 * tolerance)? == tolerance;
        let estimate = find(columns, &format!("estimate_{}", accuracy.of(&first.job)))?;
        Some(Self { study, accuracy, index, first, estimate, tolerance, is_tolerance_given })
    }

    /// Returns the settings to use, or those to try next; `known` holds records by their scenes.
    fn choose(&self, known: &HashMap<&str, Vec<&Record>>) -> Option<ChosenSettings> {
        let solved = self.solved(known)?;
        let is_within = |settings: &&SolvedSettings<'_>| {
            settings.error().is_some_and(|error| error <= self.accuracy.is)
        };
        if let Some(settings) = solved.iter().find(is_within) {
            let discovery = Discovery::Within {
                mesh: settings.elements,
                tolerance: settings.case.numerics.tolerance,
                error: settings.error()?,
            };
            return self.settle(&solved, settings, discovery);
        }
        let trials = Trials::of(&solved, self.tolerance);
        if let Some(reason) = trials.end(self.accuracy) {
            let settings = trials.best()?;
            let discovery = Discovery::Beyond {
                mesh: settings.elements,
                tolerance: settings.case.numerics.tolerance,
                error: settings.error(),
                reason,
            };
            return self.settle(&solved, settings, discovery);
        }
        let mesh = Mesh::Across(trials.next_mesh(self.accuracy));
        Some(ChosenSettings {
            point: self.point(mesh, self.tolerance)?,
            discovery: next(mesh, self.tolerance),
        })
    }

    fn point(&self, mesh: Mesh, tolerance: f64) -> Option<StudyPoint> {
        self.study.point_as_exact(self.index, mesh, tolerance)
    }

    /// Returns settings that are final, or to be tried next where no record has the point's own
    /// job: a study of cost may have solved the scene without leaving what a study of solutions
    /// wants.
    fn settle(
        &self,
        solved: &[SolvedSettings<'_>],
        settings: &SolvedSettings<'_>,
        discovery: Discovery,
    ) -> Option<ChosenSettings> {
        let Numerics { mesh, tolerance, .. } = settings.case.numerics;
        let point = self.point(mesh, tolerance)?;
        let is_there = solved.iter().any(|settings| settings.record.key() == point.key);
        let discovery = if is_there { discovery } else { next(mesh, tolerance) };
        Some(ChosenSettings { point, discovery })
    }

    /// Returns the results of the point's scene that differ from it in mesh and tolerance only, the
    /// cheapest first.
    fn solved<'r>(
        &self,
        known: &HashMap<&str, Vec<&'r Record>>,
    ) -> Option<Vec<SolvedSettings<'r>>> {
        let Job::Solve(wanted) = &self.first.job else { return None };
        let scene = self.first.job.scene_text()?;
        let records = known.get(&scene[..]).into_iter().flatten();
        let mut solved: Vec<SolvedSettings<'_>> =
            records.filter_map(|record| self.settings_of(wanted, record)).collect();
        // The time is as the number of elements, and a looser tolerance saves some of it.
        solved.sort_by(|a, b| {
            let [loose, tight] = [b, a].map(|settings| settings.case.numerics.tolerance);
            let by_settings = a.count().cmp(&b.count()).then(loose.total_cmp(&tight));
            by_settings.then_with(|| a.record.job.cmp(&b.record.job))
        });
        Some(solved)
    }

    fn settings_of<'r>(&self, wanted: &Case, record: &'r Record) -> Option<SolvedSettings<'r>> {
        let Ok(Job::Solve(case) | Job::Cost { case, .. }) = record.parse_job() else { return None };
        let Numerics { mesh, tolerance, .. } = wanted.numerics;
        let is_alike = Numerics { mesh, tolerance, ..case.numerics.clone() } == wanted.numerics;
        let is_loose = self.is_tolerance_given && case.numerics.tolerance != self.tolerance;
        if !is_alike || is_loose || !record.is_current() {
            return None;
        }
        let elements = end_of(record).map_or([0; 2], |end| {
            [end.observables.mesh_x, end.observables.mesh_y]
                .map(|n| u32::try_from(n).unwrap_or(u32::MAX))
        });
        let estimate = self.estimate.value(&self.first, Some(record)).as_f64();
        let solver_error = record
            .outcome()
            .and_then(|outcome| outcome.estimate)
            .map_or(0.0, |estimate| estimate.solver);
        let mesh_error = estimate.filter(|_| record.is_certified());
        Some(SolvedSettings { case, record, elements, mesh_error, solver_error })
    }
}

/// The meshes across Ω that have been tried for a point, the coarsest first.
struct Trials<'s, 'a> {
    /// Results to the tolerance that the accuracy takes.
    tight: Vec<&'s SolvedSettings<'a>>,
    /// Results to a looser one.
    loose: Vec<&'s SolvedSettings<'a>>,
}

impl<'s, 'a> Trials<'s, 'a> {
    fn of(solved: &'s [SolvedSettings<'a>], tolerance: f64) -> Self {
        let (tight, loose) = solved
            .iter()
            .filter(|settings| settings.across().is_some())
            .partition(|settings| settings.case.numerics.tolerance <= tolerance);
        Self { tight, loose }
    }

    /// Returns the reason to try no further mesh.
    fn end(&self, accuracy: &Accuracy) -> Option<&'static str> {
        let are_last = |count: usize, is_such: fn(&SolvedSettings<'_>) -> bool| {
            self.tight.len() >= count
                && self.tight.iter().rev().take(count).all(|settings| is_such(settings))
        };
        if are_last(2, |settings| !settings.record.is_certified()) {
            return Some("a job was not solved");
        }
        if are_last(3, |settings| settings.record.is_certified() && settings.mesh_error.is_none()) {
            return Some("no error of it is estimated");
        }
        if self.tight.last().is_some_and(|settings| settings.solver_error >= accuracy.is) {
            return Some("the solver leaves more than that");
        }
        if self.finest_tight().is_some_and(|finest| finest >= accuracy.at_most) {
            return Some("not reached on the finest mesh allowed");
        }
        None
    }

    /// Returns the result with the smallest error, or the finest without one.
    fn best(&self) -> Option<&'s SolvedSettings<'a>> {
        let with_error = self.tight.iter().filter(|settings| settings.error().is_some());
        let error = |settings: &SolvedSettings<'_>| settings.error().unwrap_or(f64::NAN);
        let best = with_error.min_by(|a, b| error(a).total_cmp(&error(b)));
        best.or(self.tight.last()).copied()
    }

    fn finest_tight(&self) -> Option<u32> {
        self.tight.iter().filter_map(|settings| settings.across()).max()
    }

    /// Returns the elements across Ω to try next.
    fn next_mesh(&self, accuracy: &Accuracy) -> u32 {
        // A loose solve tells enough of a mesh if it leaves the solver a tenth of the accuracy.
        let estimated = self.loose.iter().copied().filter(|settings| settings.mesh_error.is_some());
        let (enough, too_few): (Vec<&SolvedSettings<'_>>, Vec<&SolvedSettings<'_>>) = estimated
            .partition(|settings| {
                settings.mesh_error.is_some_and(|error| error <= 0.9 * accuracy.is)
            });
        let too_few = too_few.iter().filter_map(|settings| settings.across());
        let finest = too_few.chain(self.finest_tight()).max();
        let is_open = |n: &u32| finest.is_none_or(|finest| *n > finest) && *n <= accuracy.at_most;
        let hint = enough.iter().filter_map(|settings| settings.across()).filter(is_open).min();
        hint.unwrap_or_else(|| further(finest, &self.estimates(), accuracy.is))
            .min(accuracy.at_most)
    }

    /// Returns the estimated errors over the elements across Ω, coarse to fine.
    fn estimates(&self) -> Vec<(f64, f64)> {
        let all = self.tight.iter().chain(&self.loose);
        let mut estimates: Vec<(f64, f64)> = all
            .filter_map(|settings| Some((f64::from(settings.across()?), settings.mesh_error?)))
            .filter(|(_, error)| *error > 0.0)
            .collect();
        estimates.sort_by(|a, b| a.0.total_cmp(&b.0));
        estimates.dedup_by_key(|(n, _)| *n);
        estimates
    }
}

fn next(mesh: Mesh, tolerance: f64) -> Discovery {
    Discovery::Next { mesh: mesh.sides(), tolerance }
}

/// Returns the elements across Ω to try after the `finest`, by the estimates on meshes so far,
/// coarse to fine.
fn further(finest: Option<u32>, known: &[(f64, f64)], accuracy: f64) -> u32 {
    let Some(finest) = finest else { return FIRST };
    let twice = finest.saturating_mul(2);
    let (Some((from, _)), Ok(law)) = (known.last(), power_law(known)) else { return twice };
    let order = (-law.slope).clamp(0.5, 3.0);
    // The prediction starts on the fitted line, for estimates go up and down with where the edges
    // of elements lie, and has a fifth to spare.
    let predicted = from * (law.at(*from) / (0.8 * accuracy)).powf(1.0 / order);
    round_up(predicted, finest).min(finest.saturating_mul(4))
}

/// Returns the next of 8, 12, 16, 24, 32, … from `n` on that is more than `finest`: these halve
/// well, and other studies have them too.
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
