//! The sums of a plan.

use std::collections::{BTreeMap, HashSet};

use contact::Forecast;

/// The numbers of points and jobs, and the sums over the jobs that are left to run.
#[derive(Default)]
pub(super) struct PlanTally {
    pub(super) points: usize,
    /// The number of points that conditions leave out.
    pub(super) excluded: usize,
    /// The remarks on conditions of a study that is too large to be listed.
    pub(super) remarks: Vec<String>,
    /// The number of distinct jobs, those with a result included.
    pub(super) jobs: usize,
    /// The sum of the predictions for all of them, each by itself \[s\].
    pub(super) forecast: f64,
    pub(super) to_run: usize,
    pub(super) increments: u64,
    /// The time of all jobs, if each operator is computed once \[s\].
    pub(super) seconds: f64,
    /// The time of the longest job \[s\].
    pub(super) longest: f64,
    /// The memory of the largest job \[bytes\].
    pub(super) largest: u64,
    pub(super) operators: HashSet<u64>,
    /// The jobs on meshes of each size, by the numbers of elements along x and y.
    pub(super) meshes: BTreeMap<[usize; 2], MeshShare>,
}

/// The jobs on meshes of the same size.
#[derive(Default)]
pub(super) struct MeshShare {
    pub(super) jobs: usize,
    /// Their time \[s\].
    pub(super) seconds: f64,
}

impl PlanTally {
    /// Adds a job that is left to run.
    pub(super) fn add(&mut self, forecast: &Forecast) {
        self.to_run += 1;
        self.increments += forecast.increments;
        let is_first = self.operators.insert(forecast.operator);
        let seconds = match is_first {
            true => forecast.seconds,
            false => forecast.seconds - forecast.assembly,
        };
        self.seconds += seconds;
        self.longest = self.longest.max(seconds);
        self.largest = self.largest.max(forecast.memory);
        let share = self.meshes.entry(forecast.elements).or_default();
        share.jobs += 1;
        share.seconds += seconds;
    }
}
