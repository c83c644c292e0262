//! The subjects whose sources a study should cite: what its jobs use.

use std::collections::{BTreeMap, HashSet};

use contact::literature::CitedSubject;
use contact::model::{Effect, Numerics, Shape};
use contact::problem::Effects;
use contact::punch::Surfaces;
use rayon::prelude::*;
use study::kind::sensitivity::SensitivityMethod;
use study::{Adaptive, Case, Job, Kind, Study, StudyPoint};

use crate::effects::{JobMethod, effects};
use crate::error::AnswerError;
use crate::kind::forecast;

/// A subject, and the number of jobs that use it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UsedSubject {
    /// The subject.
    pub subject: CitedSubject,
    /// The number of jobs.
    pub jobs: usize,
}

/// The subjects of a study's jobs whose points pass by a few at a time.
pub struct SubjectCounts<'s> {
    study: &'s Study,
    jobs: HashSet<u128>,
    counts: BTreeMap<CitedSubject, usize>,
}

impl<'s> SubjectCounts<'s> {
    /// Returns those of no point.
    pub fn of(study: &'s Study) -> Self {
        Self { study, jobs: HashSet::new(), counts: BTreeMap::new() }
    }

    /// Adds the jobs of the next points.
    ///
    /// # Errors
    /// A scene has no meaning, or its surfaces are missing.
    pub fn add(&mut self, points: &[StudyPoint]) -> Result<(), AnswerError> {
        let is_first = |point: &&StudyPoint| self.jobs.insert(point.key.half());
        let jobs: Vec<&Job> = points.iter().filter(is_first).map(|point| &point.job).collect();
        let surfaces = self.study.surfaces();
        let of_jobs: Vec<Vec<CitedSubject>> =
            jobs.par_iter().map(|job| of_job(job, surfaces)).collect::<Result<_, _>>()?;
        for subject in of_jobs.into_iter().flatten() {
            *self.counts.entry(subject).or_default() += 1;
        }
        Ok(())
    }

    /// Returns the number of jobs.
    pub fn jobs(&self) -> usize {
        self.jobs.len()
    }

    /// Returns the subjects that the points use, in the order of [`CitedSubject::all`].
    pub fn used(mut self) -> Vec<UsedSubject> {
        let (study, jobs) = (self.study, self.jobs.len());
        if uses_ladder(study) {
            self.counts.insert(CitedSubject::Ladder, jobs);
        }
        let of_choice = match study.adaptive() {
            Some(Adaptive::Find(_)) => Some(CitedSubject::Roots),
            Some(Adaptive::Fill(_)) => Some(CitedSubject::Filling),
            _ => None,
        };
        self.counts.extend(of_choice.map(|subject| (subject, jobs)));
        for subject in of_sample(study) {
            self.counts.insert(subject, jobs);
        }
        let used = |subject: CitedSubject| {
            let jobs = *self.counts.get(&subject)?;
            Some(UsedSubject { subject, jobs })
        };
        CitedSubject::all().into_iter().filter_map(used).collect()
    }
}

/// Returns true if a study takes the limit of what meshes of several sizes give.
fn uses_ladder(study: &Study) -> bool {
    matches!(study.kind(), Kind::Convergence | Kind::Cost)
        || matches!(study.adaptive(), Some(Adaptive::Accuracy(_)))
}

/// Returns the subjects that say something of the points of a sample.
fn of_sample(study: &Study) -> Vec<CitedSubject> {
    let of_method = match study.sensitivity() {
        Some(SensitivityMethod::Sobol(_)) => Some(CitedSubject::SobolIndices),
        Some(SensitivityMethod::Morris) => Some(CitedSubject::ElementaryEffects),
        None => None,
    };
    let compares = matches!(study.kind(), Kind::Convergence | Kind::Cost);
    let intervals = study.sample().filter(|_| !compares).map(|_| CitedSubject::Bootstrap);
    intervals.into_iter().chain(of_method).collect()
}

/// Returns the subjects that a job uses, each once.
fn of_job(job: &Job, surfaces: &Surfaces) -> Result<Vec<CitedSubject>, AnswerError> {
    let mut used = vec![CitedSubject::Equation];
    match job {
        Job::Solve(case) | Job::Cost { case, .. } => {
            let listed = effects(case, surfaces)?;
            let is_left_out = |effect: Effect| {
                listed.lines.iter().any(|line| line.effect == effect && !line.simulated)
            };
            let asymmetries = [Effect::AsymmetryX, Effect::AsymmetryY];
            match listed.solver.map(|solver| solver.method) {
                Some(JobMethod::Seidel) => used.push(CitedSubject::Seidel),
                Some(JobMethod::Newton) => {
                    used.push(CitedSubject::Newton);
                    if asymmetries.into_iter().any(is_left_out) {
                        used.push(CitedSubject::MirrorPlanes);
                    }
                }
                // Of other methods are jobs that solve no scene.
                _ => {}
            }
            let simulated = listed.lines.iter().filter(|line| line.simulated);
            used.extend(simulated.map(|line| CitedSubject::Effect(line.effect)));
        }
        // A search leaves out nothing.
        Job::Multiplicity { case, .. } => {
            used.extend([CitedSubject::Newton, CitedSubject::Seidel, CitedSubject::Multiplicity]);
            let Case { scene, numerics, .. } = case;
            let elements = forecast(job, surfaces)?.elements;
            let numerics = Numerics { simulate: Effect::OPTIONAL.to_vec(), ..numerics.clone() };
            let effects = Effects::of(scene, &numerics, elements, surfaces)?;
            let simulated = effects.decisions().iter().filter(|decision| decision.on);
            used.extend(simulated.map(|decision| CitedSubject::Effect(decision.effect)));
        }
        Job::Uniqueness { question, .. } | Job::Branch { question, .. } => {
            used.push(CitedSubject::Uniqueness);
            used.extend(question.plane.then_some(CitedSubject::Strips));
            if !question.foundation.layers.is_empty() {
                used.push(CitedSubject::Effect(Effect::Layers));
            }
        }
    }
    match job.case().map(|case| &case.scene.punch.shape) {
        Some(Shape::HeightMap { .. }) => used.push(CitedSubject::HeightMap),
        Some(Shape::WheelOnRail(wheel)) => {
            used.push(CitedSubject::Profiles);
            used.extend(wheel.motion.map(|_| CitedSubject::WheelCreepages));
        }
        _ => {}
    }
    Ok(used)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::study;

    fn used(tables: &str) -> Vec<(&'static str, usize)> {
        let study = study(tables);
        let mut counts = SubjectCounts::of(&study);
        counts.add(&study.points()).unwrap();
        counts.used().into_iter().map(|used| (used.subject.title(), used.jobs)).collect()
    }

    #[test]
    fn a_study_cites_what_its_jobs_use() {
        let alike = [("equation", 1), ("newton", 1), ("friction", 1), ("coupling", 1)];
        let directions = [("traction-x", 1), ("traction-y", 1), ("mirror planes", 1)];
        assert_eq!(used(""), [&alike[..], &directions].concat());
        let frictionless = used("[sweep]\nfriction.mu = [0, 0.3]\n");
        assert!(frictionless.contains(&("equation", 2)) && frictionless.contains(&("friction", 1)));
        let axis = "[sweep]\nfriction.mu = [0.1, 0.3]\n";
        let find = "axis = \"mu\"\ncolumn = \"load\"\nvalue = 1\nto = \"1%\"\n";
        assert!(used(&format!("{axis}[find]\n{find}")).contains(&("finding roots", 2)));
        let fill = "axis = \"mu\"\ncolumn = \"load\"\nto = \"1%\"\n";
        assert!(
            used(&format!("{axis}[fill]\n{fill}")).contains(&("filling of curves and maps", 2))
        );
        let sample = "[sample]\nmethod = \"random\"\ncount = 3\n[sample.keys]\nfriction.mu = { from = 0.1, to = 0.4 }\n";
        assert!(used(sample).contains(&("intervals of samples", 3)));
        assert!(!used("").iter().any(|(title, _)| *title == "intervals of samples"));
        let seidel = used("method = \"seidel\"\n");
        assert!(seidel.contains(&("seidel", 1)), "{seidel:?}");
        assert!(!seidel.iter().any(|(title, _)| ["newton", "mirror planes"].contains(title)));
    }
}
