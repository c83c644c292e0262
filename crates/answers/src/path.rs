//! Loading paths at a glance.

use contact::model::{Dof, Rolling, RollingHistory, Step};
use study::StudyPoint;

/// The columns that show loading paths at a glance, of points that are added one by one.
#[derive(Default)]
pub(crate) struct PathColumns {
    has_cycle: bool,
    /// Some step rolls through a transient.
    passes: bool,
    /// Some step rolls.
    rolls: bool,
    /// Some step does not roll.
    stays: bool,
    /// The degrees of freedom that some scene moves.
    moved: Vec<Dof>,
}

impl PathColumns {
    /// Adds the path of a point.
    pub(crate) fn add(&mut self, point: &StudyPoint) {
        let Some(case) = point.job.case() else { return };
        let path = &case.scene.loading;
        self.has_cycle |= path.cycle_from.is_some();
        for step in &path.steps {
            match step.rolling {
                Some(rolling) => {
                    self.rolls = true;
                    self.passes |= rolling.history == RollingHistory::Transient;
                }
                None => self.stays = true,
            }
        }
        for dof in Dof::ALL {
            if !self.moved.contains(&dof) && case.scene.moves(dof) {
                self.moved.push(dof);
            }
        }
    }

    /// Returns the columns: the place, the motions and forces that some step mentions, what they
    /// do, and how it ended.
    pub(crate) fn names(&self) -> Vec<String> {
        let cycle = self.has_cycle.then_some("cycle");
        let place = ["step"].into_iter().chain(cycle).chain(["increment"]);
        let mut names: Vec<String> = place.map(str::to_owned).collect();
        if self.passes {
            names.push("rolled_distance".to_owned());
        }
        for dof in Dof::ALL {
            let [motion, force] = Step::NAMES[dof];
            // The approach and the load are always there.
            if dof == Dof::Approach || self.moved.contains(&dof) {
                let force = if force == "normal_force" { "load" } else { force };
                // Where a step rolls, its creepages stand for the shifts.
                let creepage = Rolling::name(dof).filter(|_| self.rolls);
                let motion = (creepage.is_none() || self.stays).then(|| format!("at_{motion}"));
                names.extend(motion.into_iter().chain(creepage.map(|name| format!("at_{name}"))));
                names.push(force.to_owned());
            }
        }
        names.extend(
            ["contact_radius", "stick_fraction", "dissipation", "status"].map(str::to_owned),
        );
        names
    }
}

/// Returns the columns that show loading paths at a glance: the place, the motions and forces that
/// some step mentions, what they do, and how it ended.
pub fn path_columns(points: &[StudyPoint]) -> Vec<String> {
    let mut columns = PathColumns::default();
    points.iter().for_each(|point| columns.add(point));
    columns.names()
}
