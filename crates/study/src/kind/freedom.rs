//! The quantities that scenes leave free, in the order in which a figure is likely to want them.

use std::collections::HashSet;

use contact::model::{Control, Dof, Rolling, Step};

use crate::job::Job;

/// Quantities of a solution that any scene may leave free, the most telling first. The motions and
/// forces of the degrees of freedom stand before them.
const QUANTITIES: [&str; 9] = [
    "peak_pressure",
    "contact_area",
    "stick_fraction",
    "separated_fraction",
    "largest_gap",
    "patches",
    "total_dissipation",
    "energy",
    "peak_traction",
];

const WEAR_DEPTH: &str = "wear_depth";
const PLANE_VON_MISES: &str = "plane_von_mises";
const VON_MISES_MAX: &str = "von_mises_max";

/// The columns of what only some scenes ask for.
const ASKED: [&str; 3] = [WEAR_DEPTH, VON_MISES_MAX, PLANE_VON_MISES];

/// Returns the columns of what a job's scene asks for beyond what every scene has.
pub(super) fn asked_of(job: &Job) -> Vec<&'static str> {
    let Some(scene) = job.case().map(|case| &case.scene) else { return Vec::new() };
    let interior = scene.interior.as_ref();
    let asked = [
        (WEAR_DEPTH, scene.wear.is_some()),
        (VON_MISES_MAX, interior.is_some_and(|question| question.maximum)),
        (PLANE_VON_MISES, interior.is_some_and(|question| !question.depths.is_empty())),
    ];
    asked.into_iter().filter_map(|(name, is_asked)| is_asked.then_some(name)).collect()
}

/// The columns that scenes prescribe at the ends of their paths, and the degrees of freedom that
/// they move.
#[derive(Default)]
pub(super) struct ScenesFreedom {
    prescribed: HashSet<String>,
    moved: Vec<Dof>,
    /// True if all paths end in rolling, where creepages stand for shifts.
    rolls: bool,
    /// The columns of what all scenes ask for.
    asked: Vec<&'static str>,
}

impl ScenesFreedom {
    /// Returns the freedom that all of some jobs leave.
    pub(super) fn of(jobs: &[Job]) -> Self {
        let paths = || jobs.iter().filter_map(|job| job.case()?.scene.loading.steps.last());
        let is_asked = |name: &&str| jobs.iter().all(|job| asked_of(job).contains(name));
        let mut freedom = Self {
            rolls: paths().count() > 0 && paths().all(|end| end.rolling.is_some()),
            asked: ASKED.into_iter().filter(is_asked).collect(),
            ..Self::default()
        };
        for scene in jobs.iter().filter_map(|job| Some(&job.case()?.scene)) {
            let legs = scene.loading.legs();
            let Some(end) = legs.last() else { continue };
            for dof in Dof::ALL {
                let [motion, force] = columns(dof, end.rolling.is_some());
                let prescribed = match end.target[dof] {
                    Control::Motion(_) => motion,
                    Control::Force(_) => force,
                };
                freedom.prescribed.insert(prescribed);
                if (dof == Dof::Approach || scene.moves(dof)) && !freedom.moved.contains(&dof) {
                    freedom.moved.push(dof);
                }
            }
        }
        freedom
    }

    /// Returns the columns of the quantities that are left free, in the order in which they are
    /// wanted over the column `x`.
    pub(super) fn quantities(&self, x: &str) -> Vec<String> {
        let answering = match without_step(x) {
            "mu" => Some("stick_fraction".to_owned()),
            "wear_coefficient" | "wear_repeat" => Some(WEAR_DEPTH.to_owned()),
            "interior_depth" => Some(PLANE_VON_MISES.to_owned()),
            key => answer_to(key, self.rolls),
        };
        let both = |dof: &Dof| {
            let [motion, force] = columns(*dof, self.rolls);
            [force, motion]
        };
        fn named(names: &[&str]) -> impl Iterator<Item = String> {
            names.iter().map(|name| (*name).to_owned())
        }
        // Every scene moves the normal direction, which comes first.
        let (normal, others) = self.moved.split_at(self.moved.len().min(1));
        let (common, special) = QUANTITIES.split_at(3);
        let listed = answering
            .into_iter()
            .chain(normal.iter().flat_map(both))
            .chain(named(common))
            .chain(others.iter().flat_map(both))
            .chain(named(special))
            .chain(named(&self.asked));
        let mut wanted: Vec<String> = Vec::new();
        for name in listed.filter(|name| !self.prescribed.contains(name) && name != x) {
            if !wanted.contains(&name) {
                wanted.push(name);
            }
        }
        wanted
    }
}

/// Returns the columns of a degree of freedom: its motion, which is a creepage where the path ends
/// in rolling, and the force that is its work-conjugate.
fn columns(dof: Dof, rolls: bool) -> [String; 2] {
    let [motion, force] = Step::NAMES[dof];
    let motion = match Rolling::name(dof) {
        Some(creepage) if rolls => creepage,
        _ => motion,
    };
    let force = if dof == Dof::Approach { "load" } else { force };
    [format!("at_{motion}"), force.to_owned()]
}

/// Returns the column that answers to a motion or a force that is prescribed: the other one of the
/// two.
fn answer_to(key: &str, rolls: bool) -> Option<String> {
    Dof::ALL.into_iter().find_map(|dof| {
        let [motion_key, force_key] = Step::NAMES[dof];
        let [motion, force] = columns(dof, rolls);
        match key {
            key if key == motion_key || Rolling::name(dof) == Some(key) => Some(force),
            key if key == force_key => Some(motion),
            _ => None,
        }
    })
}

/// Returns the name of a column of a key of a load step without the step: `shift_x` for
/// `step1_shift_x`.
fn without_step(name: &str) -> &str {
    let index_and_key = name.strip_prefix("step").and_then(|rest| rest.split_once('_'));
    index_and_key
        .filter(|(index, _)| index.bytes().all(|byte| byte.is_ascii_digit()))
        .map_or(name, |(_, key)| key)
}
