//! A job: one scene with one set of numerics, and the identity under which its result is kept.

use contact::scene::{Numerics, Scene};
use serde::{Deserialize, Serialize};

/// Changes whenever the same job would give different numbers; part of every [`JobKey`].
pub const PHYSICS_VERSION: u32 = 1;

/// One point of a study: everything that determines its result, and nothing else.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// What is asked.
    pub scene: Scene,
    /// How exactly it is answered.
    pub numerics: Numerics,
}

impl Job {
    /// The canonical text of the job: JSON with the fields in their declared order, defaults left out, numbers in SI
    /// units in their shortest exact form. Spelling, order and units of the study file leave no trace in it.
    pub fn canonical(&self) -> String {
        let mut job = self.clone();
        job.normalise_zeros();
        serde_json::to_string(&job).expect("a job is plain data with finite numbers")
    }

    /// The identity of the job: BLAKE3 of the physics version and the canonical text.
    pub fn key(&self) -> JobKey {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"tribosweep job ");
        hasher.update(&PHYSICS_VERSION.to_le_bytes());
        hasher.update(self.canonical().as_bytes());
        JobKey(*hasher.finalize().as_bytes())
    }

    fn normalise_zeros(&mut self) {
        for step in &mut self.scene.loading.steps {
            for x in [&mut step.approach, &mut step.shift_x, &mut step.shift_y, &mut step.tilt_x, &mut step.tilt_y, &mut step.twist] {
                *x += 0.0; // −0 becomes 0
            }
        }
        self.scene.friction.mu += 0.0;
        self.scene.foundation.base.poisson += 0.0;
        self.numerics.epsilon += 0.0;
    }
}

/// The identity of a job: 32 bytes, shown as hexadecimal.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct JobKey(pub [u8; 32]);

impl std::fmt::Display for JobKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl std::fmt::Debug for JobKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "JobKey({self})")
    }
}
