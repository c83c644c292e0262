//! The record that a job leaves.

use std::fmt;

use serde::{Deserialize, Serialize};

use contact::model::{Further, Outcome, Status};
use contact::multiplicity::Multiplicity;
use contact::uniqueness::Bracket;
use contact::uniqueness::cones::ConeCase;
use contact::uniqueness::witness::Shown;
use identity::{JobKey, KeptFields};

use crate::job::{Job, JobError, PHYSICS_VERSION};
use crate::provenance::Provenance;

/// The way in which a job ended.
#[expect(clippy::large_enum_variant, reason = "nearly every record is of the large one")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Ending {
    /// The job was computed. [`Outcome::status`] says whether it counts as solved.
    Finished(Outcome),
    /// The job was searched for solutions. [`Multiplicity::status`] says whether any was found.
    Searched(Multiplicity),
    /// The end of the job's uniqueness set was looked for.
    Bracketed(Box<Bracketed>),
    /// The job killed or outlived its workers and was set aside.
    Quarantined {
        /// The event that set it aside: a signal, a deadline, memory.
        reason: String,
        /// The number of attempts.
        attempts: u32,
    },
    /// A part of the fields of a uniqueness set was excluded, or cut.
    Branched(Box<Branched>),
}

impl Ending {
    /// Returns the status of the solution; `None` for a job that was set aside.
    pub fn status(&self) -> Option<&Status> {
        match self {
            Ending::Finished(outcome) => Some(&outcome.status),
            Ending::Searched(found) => Some(&found.status),
            Ending::Bracketed(found) => Some(&found.status),
            Ending::Branched(found) => Some(&found.status),
            Ending::Quarantined { .. } => None,
        }
    }

    /// Returns the results that only some scenes ask for; none for other endings.
    pub(crate) fn further(&self) -> Further {
        match self {
            Ending::Finished(outcome) => outcome.further.clone(),
            Ending::Searched(_)
            | Ending::Bracketed(_)
            | Ending::Branched(_)
            | Ending::Quarantined { .. } => Further::default(),
        }
    }

    /// Takes in the results that only some scenes ask for, which are stored apart.
    pub(crate) fn take_further(&mut self, further: Further) {
        if let Ending::Finished(outcome) = self {
            outcome.further = further;
        }
    }

    /// Returns the reason why there is no solution.
    pub fn reason(&self) -> Option<&str> {
        match (self, self.status()) {
            (Ending::Quarantined { reason, .. }, _) | (_, Some(Status::Failed { reason })) => {
                Some(reason)
            }
            _ => None,
        }
    }
}

/// The standing of a job: its end in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Standing {
    /// The job was computed, and the result is certified.
    Certified,
    /// The job was computed, and the result is not certified.
    Failed,
    /// The job was set aside without a result.
    Quarantined,
}

impl fmt::Display for Standing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Standing::Certified => "certified",
            Standing::Failed => "failed",
            Standing::Quarantined => "quarantined",
        })
    }
}

impl From<&Status> for Standing {
    fn from(status: &Status) -> Self {
        match status {
            Status::Certified => Standing::Certified,
            Status::Failed { .. } => Standing::Failed,
        }
    }
}

/// The result of looking for the end μ* of a uniqueness set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bracketed {
    /// The status, which is certified if code of its own verified both sides.
    pub status: Status,
    /// Both sides, with everything that it takes to verify them again.
    pub bracket: Option<Bracket>,
    /// The figures that verifying the upper witness has shown.
    pub shown: Option<Shown>,
}

/// The result of excluding a part of the fields of a uniqueness set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Branched {
    /// The status, which is certified if code of its own verified what is said to be excluded.
    pub status: Status,
    /// The cases and cones, excluded or left open.
    pub cases: Vec<ConeCase>,
}

/// The record that a job leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// The version of the physics that computed it; it is part of the job's key.
    pub physics: u32,
    /// The job's canonical text ([`Job::canonical`]).
    pub job: String,
    /// The way in which the job ended.
    pub ending: Ending,
    /// The bytes of its fields ([`encode_fields`](crate::record_format::encode_fields)), if it left
    /// some.
    pub fields: Option<KeptFields>,
    /// The worker, the time and the speed of the computation, and its run.
    pub provenance: Provenance,
}

impl Record {
    /// Returns the identity of the job that left it.
    pub fn key(&self) -> JobKey {
        JobKey::of(self.physics, &self.job)
    }

    /// Returns the job that left it.
    ///
    /// # Errors
    ///
    /// Returns an error if the text of the job is none.
    pub fn parse_job(&self) -> Result<Job, JobError> {
        Job::parse(&self.job)
    }

    /// Returns what came of the job, in a word.
    pub fn standing(&self) -> Standing {
        self.ending.status().map_or(Standing::Quarantined, Standing::from)
    }

    /// Returns whether the record holds a certified result.
    pub fn is_certified(&self) -> bool {
        self.standing() == Standing::Certified
    }

    /// Returns the outcome of a scene, solved or not.
    pub fn outcome(&self) -> Option<&Outcome> {
        match &self.ending {
            Ending::Finished(outcome) => Some(outcome),
            _ => None,
        }
    }

    /// Returns the result of a search for solutions.
    pub fn multiplicity(&self) -> Option<&Multiplicity> {
        match &self.ending {
            Ending::Searched(found) => Some(found),
            _ => None,
        }
    }

    /// Returns the result of looking for the end of a uniqueness set.
    pub fn bracketed(&self) -> Option<&Bracketed> {
        match &self.ending {
            Ending::Bracketed(found) => Some(found),
            _ => None,
        }
    }

    /// Returns the result of excluding a part of the fields of a uniqueness set.
    pub fn branched(&self) -> Option<&Branched> {
        match &self.ending {
            Ending::Branched(found) => Some(found),
            _ => None,
        }
    }

    /// Visits the records that there would be if the path had ended after its first increment, its
    /// second and so on. The last visit sees the record itself. Increments before the one at which
    /// a path failed are certified.
    pub fn along_path(&self, mut visit: impl FnMut(&Record)) {
        let Some(outcome) = self.outcome() else { return };
        let (physics, fields, provenance) =
            (self.physics, self.fields.clone(), self.provenance.clone());
        let steps = Vec::with_capacity(outcome.steps.len());
        let path = Outcome {
            status: Status::Certified,
            levels: outcome.levels.clone(),
            steps,
            estimate: None,
            hertz: None,
            rail: None,
            further: Further::default(),
        };
        let mut partial = Record {
            physics,
            job: self.job.clone(),
            ending: Ending::Finished(path),
            fields,
            provenance,
        };
        for (index, step) in outcome.steps.iter().enumerate() {
            let Ending::Finished(path) = &mut partial.ending else { return };
            path.steps.push(*step);
            path.further.wear.extend(outcome.further.wear.get(index));
            path.further.leading_edges.extend(outcome.further.leading_edges.get(index));
            path.hertz = outcome.hertz.zip(outcome.last()).and_then(|(hertz, last)| {
                let [load, of_last] = [step, last].map(|step| step.observables.load);
                (load > 0.0 && of_last > 0.0).then(|| hertz.under(load / of_last))
            });
            if index + 1 == outcome.steps.len() {
                path.status = outcome.status.clone();
                (path.estimate, path.hertz, path.rail) =
                    (outcome.estimate, outcome.hertz, outcome.rail);
                path.further = outcome.further.clone();
            }
            visit(&partial);
        }
    }

    /// Returns the record that there would be if a path that failed had ended at the last increment
    /// that was solved; `None` for a path that did not fail, or at its first increment.
    pub fn before_failure(&self) -> Option<Record> {
        let is_failed = self.standing() == Standing::Failed;
        let steps = &self.outcome().filter(|_| is_failed)?.steps;
        let (mut index, mut before) = (0, None);
        self.along_path(|increment| {
            index += 1;
            if index + 1 == steps.len() {
                before = Some(increment.clone());
            }
        });
        before
    }

    /// Returns whether the physics of this program computed it.
    pub fn is_current(&self) -> bool {
        self.physics == PHYSICS_VERSION
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use contact::model::{
        Certificate, Fields, Hertz, Level, Method, Motion, Observables, RailContact, StepOutcome,
        WorkDone,
    };
    use contact::multiplicity::{Origin, Solution};

    use super::*;
    use crate::job::PHYSICS_VERSION;

    fn record(ending: Ending) -> Record {
        let provenance = Provenance {
            program: "0.1.0".into(),
            seconds: 0.25,
            times: vec![0.25, 0.5],
            worker: 1,
            attempt: 1,
            finished: 1_700_000_000,
            run: Some([9; 32]),
        };
        Record {
            physics: PHYSICS_VERSION,
            job: crate::job::tests::job().canonical(),
            ending,
            fields: Some(KeptFields::Blob([7; 32])),
            provenance,
        }
    }

    /// Every figure of the last increment differs from every other, so that no two columns can be
    /// mistaken for each other.
    fn outcome(status: Status) -> Outcome {
        let first = StepOutcome {
            observables: Observables { load: 0.5, dissipation: 0.25, ..Observables::default() },
            work: WorkDone { iterations: 7, operator_applications: 8 },
            ..StepOutcome::default()
        };
        let last = StepOutcome {
            step: 1,
            cycle: 2,
            motion: Motion {
                approach: 31.0,
                shift_x: 32.0,
                shift_y: 33.0,
                tilt_x: 34.0,
                tilt_y: 35.0,
                twist: 36.0,
            },
            observables: Observables {
                load: 1.0,
                force_x: 2.0,
                force_y: 3.0,
                moment_x: 4.0,
                moment_y: 5.0,
                moment_z: 6.0,
                contact_area: 8.0,
                stick_area: 2.0,
                slip_area: 7.5,
                contact_elements: 9,
                stick_elements: 10,
                slip_elements: 11,
                patches: 24,
                sole_area: 10.0,
                largest_gap: 25.0,
                peak_pressure: 12.0,
                peak_traction: 13.0,
                energy: 14.0,
                dissipation: 15.0,
                external_work: 26.0,
                ceiling_elements: 16,
                edge_elements: 17,
                mesh_x: 18,
                mesh_y: 19,
                element_x: 20.0,
                element_y: 21.0,
            },
            certificate: Certificate {
                residual: 0.1,
                tension: 0.2,
                penetration: 0.3,
                gap_under_pressure: 0.4,
                cone_violation: 0.5,
                slip_angle: 0.6,
                force_imbalance: 0.7,
            },
            work: WorkDone { iterations: 22, operator_applications: 23 },
            route: contact::model::Route::NewtonAndSeidel,
        };
        let hertz = Hertz {
            semi_axis_a: 41.0,
            semi_axis_b: 42.0,
            area: 43.0,
            peak_pressure: 44.0,
            approach: 45.0,
        };
        let rail = RailContact {
            track: [51.0, 52.0, 53.0],
            rail: [54.0, 55.0],
            angle: 56.0,
            pressure_center: [57.0, 58.0, 59.0],
            wheelset_height: 60.0,
        };
        let coarse =
            Level { elements: [9, 10], work: WorkDone { iterations: 0, operator_applications: 5 } };
        let figures = contact::model::FigureErrors {
            load: Some(71.0),
            approach: Some(72.0),
            tangential_force: Some(73.0),
            shift: Some(74.0),
            moment: Some(75.0),
            rotation: Some(76.0),
            peak_pressure: Some(77.0),
            contact_area: Some(78.0),
            stick_area: Some(79.0),
            pressure: Some(80.0),
            traction: Some(81.0),
        };
        let estimate = contact::model::Estimate { figures, solver: 90.0 };
        Outcome {
            status,
            levels: vec![coarse],
            steps: vec![first, last],
            estimate: Some(estimate),
            hertz: Some(hertz),
            rail: Some(rail),
            further: Further::default(),
        }
    }

    pub(crate) fn solved() -> Record {
        record(Ending::Finished(outcome(Status::Certified)))
    }

    pub(crate) fn failed() -> Record {
        record(Ending::Finished(outcome(Status::Failed {
            reason: "residual 0.1 after 22 iterations".into(),
        })))
    }

    pub(crate) fn quarantined() -> Record {
        record(Ending::Quarantined { reason: "killed by SIGKILL".into(), attempts: 3 })
    }

    /// Returns a record of two solutions.
    pub(crate) fn searched() -> Record {
        let solution = |distances: [f64; 2], origin: Origin| Solution {
            motion: Motion { approach: 1.0, ..Motion::default() },
            observables: Observables { load: 2.0, ..Observables::default() },
            certificate: Certificate { residual: 3.0, ..Certificate::default() },
            origin,
            method: Method::Newton,
            reached: 4,
            error: 5.0,
            index: Some(-1),
            distances: distances.to_vec(),
            fields: fields(),
        };
        record(Ending::Searched(Multiplicity {
            status: Status::Certified,
            before: vec![StepOutcome::default()],
            solutions: vec![
                solution([0.0, 6.0], Origin::Hertz),
                solution([6.0, 0.0], Origin::Between([0, 1])),
            ],
            starts: 7,
            failed: 8,
            beyond: 9,
            index_sum: Some(-2),
            work: WorkDone { iterations: 10, operator_applications: 11 },
            factorisations: 12,
        }))
    }

    pub(crate) fn fields() -> Fields {
        let list = |x: f64| vec![x; 6];
        Fields {
            shape: [3, 2],
            origin: [-1.0, -2.0],
            element: [0.5, 0.25],
            pressure: list(1.0),
            traction_x: list(2.0),
            traction_y: list(3.0),
            gap: list(4.0),
            slip_x: list(5.0),
            slip_y: list(6.0),
            state: vec![0, 1, 2, 3, 1, 0],
            ..Fields::default()
        }
    }

    /// The semi-axes go with the cube root of the load, and what is further asked for is there as
    /// far as the path.
    #[test]
    fn an_increment_has_what_holds_under_its_own_load() {
        let mut record = solved();
        let edges = vec![None, Some(0.5)];
        record.ending.take_further(Further { leading_edges: edges.clone(), ..Further::default() });
        let mut seen = Vec::new();
        record.along_path(|increment| seen.push(increment.outcome().unwrap().clone()));
        let [first, last] = &seen[..] else { panic!("{} increments", seen.len()) };
        let (hertz, of_end) = (first.hertz.unwrap(), last.hertz.unwrap());
        assert_eq!(Some(of_end), record.outcome().unwrap().hertz);
        assert!((hertz.semi_axis_a / of_end.semi_axis_a - 0.5f64.cbrt()).abs() < 1e-12);
        assert!((hertz.peak_pressure / of_end.peak_pressure - 0.5f64.cbrt()).abs() < 1e-12);
        assert!((hertz.area / of_end.area - 0.25f64.cbrt()).abs() < 1e-12);
        assert!((hertz.approach / of_end.approach - 0.25f64.cbrt()).abs() < 1e-12);
        assert_eq!(first.further.leading_edges, edges[..1]);
        assert_eq!(last.further.leading_edges, edges);
    }
}
