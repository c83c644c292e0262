//! Loading paths at a glance.

use contact::model::{Dof, Step};
use study::{Job, StudyPoint};

/// Returns the columns that show loading paths at a glance: the place, the motions and forces that
/// some step mentions, what they do, and how it ended.
pub fn path_columns(points: &[StudyPoint]) -> Vec<String> {
    let paths = || points.iter().filter_map(|point| Some(&point.job.case()?.scene.loading));
    let cycle = paths().any(|path| path.cycle_from.is_some()).then_some("cycle");
    let mut names: Vec<String> =
        ["step"].into_iter().chain(cycle).chain(["increment"]).map(str::to_owned).collect();
    for dof in Dof::ALL {
        let [motion, force] = Step::NAMES[dof];
        let mut steps = paths().flat_map(|path| &path.steps);
        // The approach and the load are always there.
        if dof == Dof::Approach || steps.any(|step| step.given()[dof] != [None, None]) {
            let force = if force == "normal_force" { "load" } else { force };
            names.extend([format!("at_{motion}"), force.to_owned()]);
        }
    }
    names.extend(["contact_radius", "stick_fraction", "dissipation", "status"].map(str::to_owned));
    names
}

/// Returns the increments of a job's loading path.
pub fn increments_of(job: &Job) -> u64 {
    job.case().map_or(0, |case| case.scene.loading.increments())
}
