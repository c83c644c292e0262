//! Loading paths at a glance.

use contact::model::{Dof, Rolling, RollingHistory, Step};
use study::StudyPoint;

/// Returns the columns that show loading paths at a glance: the place, the motions and forces that
/// some step mentions, what they do, and how it ended.
pub fn path_columns(points: &[StudyPoint]) -> Vec<String> {
    let scenes = || points.iter().filter_map(|point| Some(&point.job.case()?.scene));
    let paths = || scenes().map(|scene| &scene.loading);
    let cycle = paths().any(|path| path.cycle_from.is_some()).then_some("cycle");
    let mut names: Vec<String> =
        ["step"].into_iter().chain(cycle).chain(["increment"]).map(str::to_owned).collect();
    let is_passing = |rolling: Rolling| rolling.history == RollingHistory::Transient;
    if paths().flat_map(|path| &path.steps).any(|step| step.rolling.is_some_and(is_passing)) {
        names.push("rolled_distance".to_owned());
    }
    for dof in Dof::ALL {
        let [motion, force] = Step::NAMES[dof];
        let steps = || paths().flat_map(|path| &path.steps);
        // The approach and the load are always there.
        if dof == Dof::Approach || scenes().any(|scene| scene.moves(dof)) {
            let force = if force == "normal_force" { "load" } else { force };
            // Where a step rolls, its creepages stand for the shifts.
            let creepage =
                Rolling::name(dof).filter(|_| steps().any(|step| step.rolling.is_some()));
            let motion = (creepage.is_none() || steps().any(|step| step.rolling.is_none()))
                .then(|| format!("at_{motion}"));
            names.extend(motion.into_iter().chain(creepage.map(|name| format!("at_{name}"))));
            names.push(force.to_owned());
        }
    }
    names.extend(["contact_radius", "stick_fraction", "dissipation", "status"].map(str::to_owned));
    names
}
