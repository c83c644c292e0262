//! The loading path: the steps that a scene prescribes, and the controls of each increment.

use serde::{Deserialize, Serialize};

use super::error::{SceneError, finite, positive, refuse};
use super::rigid::{Control, Dof, Motion, PerDof};
use super::rolling::{Rolling, RollingHistory};

/// The loading path: steps that follow one another. The last ones are repeated if they make a
/// cycle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Loading {
    /// The load steps, in order, from zero traction.
    pub steps: Vec<Step>,
    /// The index of the step with which a cycle begins; the cycle ends with the last step. `None`
    /// is a path without cycles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycle_from: Option<u32>,
    /// The number of times that the cycle is run through.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub cycles: u32,
}

impl Loading {
    /// Makes a path of these steps, without cycles.
    pub fn path(steps: Vec<Step>) -> Self {
        Self { steps, cycle_from: None, cycles: 1 }
    }
}

/// One load step. Each of the punch's six rigid degrees of freedom is either prescribed or governed
/// by its force or moment; one that is not mentioned stays under the control, and at the value, of
/// the step before. Before the first step the punch just touches at the origin, unshifted and
/// untilted, and nothing is mentioned; so the first step must give the approach or the normal
/// force.
///
/// A rotation vector (tilt_x, tilt_y, twist) moves a point (x, y, 0) of the punch by (−twist·y,
/// twist·x, tilt_x·y − tilt_y·x), with z into the foundation. Forces and moments are those of the
/// punch on the foundation, with the signs of [`Observables`](super::outcome::Observables).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// The approach δ, positive into the foundation \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub approach: Option<f64>,
    /// The normal force P > 0 \[N\] instead of the approach.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_force: Option<f64>,
    /// The shift along x \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shift_x: Option<f64>,
    /// The tangential force along x \[N\] instead of the shift.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_x: Option<f64>,
    /// The shift along y \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shift_y: Option<f64>,
    /// The tangential force along y \[N\] instead of the shift.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_y: Option<f64>,
    /// The tilt about the x axis \[rad\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt_x: Option<f64>,
    /// The moment about the x axis \[N m\] instead of the tilt.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment_x: Option<f64>,
    /// The tilt about the y axis \[rad\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt_y: Option<f64>,
    /// The moment about the y axis \[N m\] instead of the tilt.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment_y: Option<f64>,
    /// The twist φ about the z axis \[rad\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub twist: Option<f64>,
    /// The moment about the z axis \[N m\] instead of the twist.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment_z: Option<f64>,
    /// The number of equal increments in which the step is taken, each solved after the one before.
    /// A prescribed motion or force goes evenly from its value at the end of the step before to its
    /// value here.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub increments: u32,
    /// The rolling, if the step rolls. Each increment then travels the same distance at the same
    /// creepages.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolling: Option<Rolling>,
}

impl Default for Step {
    /// Makes a step that changes nothing.
    fn default() -> Self {
        Self {
            approach: None,
            normal_force: None,
            shift_x: None,
            force_x: None,
            shift_y: None,
            force_y: None,
            tilt_x: None,
            moment_x: None,
            tilt_y: None,
            moment_y: None,
            twist: None,
            moment_z: None,
            increments: 1,
            rolling: None,
        }
    }
}

impl Step {
    /// The names of each rigid degree of freedom: as a motion, and as the force or moment that is
    /// its work-conjugate.
    pub const NAMES: PerDof<[&'static str; 2]> = PerDof::new([
        ["approach", "normal_force"],
        ["shift_x", "force_x"],
        ["shift_y", "force_y"],
        ["tilt_x", "moment_x"],
        ["tilt_y", "moment_y"],
        ["twist", "moment_z"],
    ]);

    /// Returns the values that the step gives for each degree of freedom, as a motion and as a
    /// force ([`Step::NAMES`]).
    pub fn given(&self) -> PerDof<[Option<f64>; 2]> {
        PerDof::new([
            [self.approach, self.normal_force],
            [self.shift_x, self.force_x],
            [self.shift_y, self.force_y],
            [self.tilt_x, self.moment_x],
            [self.tilt_y, self.moment_y],
            [self.twist, self.moment_z],
        ])
    }

    /// Returns whether the step rolls with a given creepage or spin in a degree of freedom.
    pub fn creeps(&self, dof: Dof) -> bool {
        self.rolling.is_some_and(|rolling| rolling.rate(dof).is_some())
    }
}

/// Returns the count that a study file need not mention.
fn one() -> u32 {
    1
}

/// Returns whether a count need not be mentioned.
fn is_one(n: &u32) -> bool {
    *n == 1
}

/// One step of a path whose cycles are unrolled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// The index of the step in the scene.
    pub step: u32,
    /// The number of the cycle, counted from 1; it is 0 outside of a cycle.
    pub cycle: u32,
    /// The number of equal increments in which the step is taken.
    pub increments: u32,
    /// The control of each degree of freedom at the end of the step. In a leg that rolls a
    /// prescribed tangential motion is one per distance travelled \[1 or rad/m\].
    pub target: PerDof<Control>,
    /// The rolling, if the leg rolls.
    pub rolling: Option<Rolling>,
}

impl Loading {
    /// The largest number of increments of a path; cycles count as often as they are run through.
    pub const MAX_INCREMENTS: u32 = 1000;

    /// Refuses a path that cannot be followed, with the first offence in the order of the steps.
    pub(crate) fn validate(&self) -> Result<(), SceneError> {
        let steps = &self.steps;
        let Some(first) = steps.first() else {
            return Err(refuse("loading.steps", "no steps", "needs at least one load step"));
        };
        for (i, step) in steps.iter().enumerate() {
            for (given, [motion, force]) in step.given().iter().zip(Step::NAMES) {
                let key = |name: &str| format!("loading.steps[{i}].{name}");
                for (value, name) in given.iter().zip([motion, force]) {
                    if let Some(value) = value {
                        finite(&key(name), *value)?;
                    }
                }
                if let [Some(_), Some(value)] = given {
                    return Err(refuse(
                        &key(force),
                        value,
                        &format!("cannot stand beside `{motion}`: give one of the two"),
                    ));
                }
            }
            if let Some(force) = step.normal_force {
                positive(&format!("loading.steps[{i}].normal_force"), force)?;
            }
            if step.increments == 0 {
                return Err(refuse(
                    &format!("loading.steps[{i}].increments"),
                    0,
                    "must be at least 1",
                ));
            }
            if let Some(rolling) = &step.rolling {
                let given = Dof::TANGENTIAL.map(|dof| step.given()[dof]);
                let names = Dof::TANGENTIAL.map(|dof| Step::NAMES[dof]);
                rolling.validate(&format!("loading.steps[{i}]"), step.increments, given, names)?;
            }
        }
        if first.approach.is_none() && first.normal_force.is_none() {
            return Err(refuse(
                "loading.steps[0].approach",
                "missing",
                "the first step needs `approach` or `normal_force`",
            ));
        }
        if self.cycles == 0 {
            return Err(refuse("loading.cycles", 0, "must be at least 1"));
        }
        match self.cycle_from {
            Some(from) if from as usize >= steps.len() => {
                let last = steps.len() - 1;
                return Err(refuse(
                    "loading.cycle_from",
                    from,
                    &format!("must be the index of a step, 0 to {last}"),
                ));
            }
            None if self.cycles > 1 => {
                return Err(refuse(
                    "loading.cycles",
                    self.cycles,
                    "needs `cycle_from`, the index of the step with which a cycle begins",
                ));
            }
            _ => {}
        }
        let total = self.increments();
        if total > u64::from(Self::MAX_INCREMENTS) {
            return Err(refuse(
                "loading.steps",
                format!("{total} increments in all"),
                "must be at most 1000",
            ));
        }
        Ok(())
    }
}

impl Loading {
    /// Returns the number of increments of the path; cycles count as often as they are run through.
    /// A step whose distance the elements divide counts for one until it is bound to a grid.
    pub fn increments(&self) -> u64 {
        let count =
            |steps: &[Step]| steps.iter().map(|step| u64::from(step.increments)).sum::<u64>();
        let (lead, cycle) = self.steps.split_at(self.cycle_start());
        count(lead).saturating_add(count(cycle).saturating_mul(u64::from(self.cycles)))
    }

    /// Returns whether the length of the elements decides on the number of increments.
    pub fn is_divided_by_elements(&self) -> bool {
        self.steps.iter().filter_map(|step| step.rolling).any(|rolling| rolling.distance.is_some())
    }

    /// Returns the path on elements of this length along x \[m\], with as many increments as they
    /// make of its distances.
    ///
    /// # Errors
    /// A [`SceneError`] says that there are too many of them.
    pub(crate) fn divided(&self, element: f64) -> Result<Self, SceneError> {
        let mut loading = self.clone();
        let refused = |index: usize, count: f64| {
            let expected = format!(
                "must leave at most {} increments on the path: elements of {element:.3e} m divide \
                 it into {count:.3e}; give `dq` or `increments`",
                Self::MAX_INCREMENTS
            );
            let key = format!("loading.steps[{index}].distance");
            let value = self.steps[index].rolling.and_then(|rolling| rolling.distance);
            refuse(&key, value.unwrap_or_default(), &expected)
        };
        let mut last = None;
        for (index, step) in loading.steps.iter_mut().enumerate() {
            let Some(rolling) = &mut step.rolling else { continue };
            let Some(parts) = rolling.parts(element) else { continue };
            if parts > f64::from(Self::MAX_INCREMENTS) {
                return Err(refused(index, parts));
            }
            step.increments = parts as u32;
            rolling.dq = Some(rolling.travelled(element));
            rolling.distance = None;
            last = Some(index);
        }
        let total = loading.increments();
        match last {
            Some(index) if total > u64::from(Self::MAX_INCREMENTS) => {
                Err(refused(index, f64::from(loading.steps[index].increments)))
            }
            _ => Ok(loading),
        }
    }

    /// Returns whether a step rolls.
    pub(crate) fn rolls(&self) -> bool {
        self.steps.iter().any(|step| step.rolling.is_some())
    }

    /// Returns the index of the step with which the cycle begins; without a cycle it is the number
    /// of steps.
    fn cycle_start(&self) -> usize {
        self.cycle_from.map_or(self.steps.len(), |from| from as usize).min(self.steps.len())
    }

    /// Returns the path with its cycles unrolled. Every degree of freedom that a step does not
    /// mention is under the control of the step before.
    pub fn legs(&self) -> Vec<Leg> {
        let mut target = PerDof::all(Control::Motion(0.0));
        let from = self.cycle_start();
        let lead = (0..from).map(|step| (step, 0));
        let cycles = (1..=self.cycles)
            .flat_map(|cycle| (from..self.steps.len()).map(move |step| (step, cycle)));
        lead.chain(cycles)
            .map(|(index, cycle)| {
                let step = &self.steps[index];
                let after = step.from(target);
                target = step.left(after);
                let (increments, rolling) = (step.increments, step.rolling);
                Leg { step: index as u32, cycle, increments, target: after, rolling }
            })
            .collect()
    }

    /// Returns a path with the same legs that omits the controls that repeat the step before, and
    /// has 0 in place of −0. Creepages of 0 that no force would govern are omitted as well, unless
    /// the motion of a wheelset imposes others (`is_imposed`).
    pub fn normalised(&self, is_imposed: bool) -> Self {
        let is_pulled = Dof::TANGENTIAL
            .map(|dof| self.steps.iter().any(|step| matches!(step.given()[dof], [None, Some(_)])));
        let mut before = PerDof::all(Control::Motion(0.0));
        let mut loading = self.clone();
        for (index, step) in loading.steps.iter_mut().enumerate() {
            let after = step.from(before);
            // A control that a step of a cycle repeats the first time may be a change the second.
            let is_once =
                self.cycles == 1 || self.cycle_from.is_none_or(|from| index < from as usize);
            for (dof, given) in Dof::ALL.into_iter().zip(step.given_mut()) {
                let says_nothing =
                    is_once && after[dof] == before[dof] && !(index == 0 && dof == Dof::Approach);
                for value in given {
                    match value {
                        Some(_) if says_nothing => *value = None,
                        Some(x) => *x += 0.0, // This turns −0 into 0.
                        None => {}
                    }
                }
            }
            let zero_unless_given = std::array::from_fn(|tangential| {
                let is_governed = match before[Dof::TANGENTIAL[tangential]] {
                    Control::Force(_) => true,
                    Control::Motion(_) => is_pulled[tangential] && !is_once,
                };
                !is_imposed && !is_governed
            });
            step.rolling = step.rolling.map(|rolling| rolling.normalised(zero_unless_given));
            before = step.left(after);
        }
        loading
    }
}

impl Step {
    /// Returns the controls after this step, given those before it.
    fn from(&self, mut target: PerDof<Control>) -> PerDof<Control> {
        for (control, given) in target.iter_mut().zip(self.given()) {
            match given {
                [Some(motion), _] => *control = Control::Motion(motion),
                [None, Some(force)] => *control = Control::Force(force),
                [None, None] => {}
            }
        }
        let Some(rolling) = self.rolling else { return target };
        for dof in Dof::TANGENTIAL {
            target[dof] = match (rolling.rate(dof), target[dof]) {
                (None, Control::Force(force)) => Control::Force(force),
                (None, Control::Motion(_)) => Control::Motion(rolling.default_rate(dof)),
                (Some(rate), _) => Control::Motion(rate),
            };
        }
        target
    }

    /// Returns the controls that hold on after this step, given those at its end. Where a step has
    /// rolled, shifts and twists count anew.
    fn left(&self, mut end: PerDof<Control>) -> PerDof<Control> {
        for dof in Dof::TANGENTIAL.into_iter().filter(|_| self.rolling.is_some()) {
            if let Control::Motion(_) = end[dof] {
                end[dof] = Control::Motion(0.0);
            }
        }
        end
    }

    /// Returns the values of [`given`](Self::given), to change them.
    fn given_mut(&mut self) -> PerDof<[&mut Option<f64>; 2]> {
        PerDof::new([
            [&mut self.approach, &mut self.normal_force],
            [&mut self.shift_x, &mut self.force_x],
            [&mut self.shift_y, &mut self.force_y],
            [&mut self.tilt_x, &mut self.moment_x],
            [&mut self.tilt_y, &mut self.moment_y],
            [&mut self.twist, &mut self.moment_z],
        ])
    }
}

impl Leg {
    /// Returns the controls of increment `number`, counted from 1, if the step
    /// before left the punch at `motion` \[m or rad\] with these `resultants` \[N or N m\]. Every
    /// control goes evenly from there to its target, except for the motions of a leg that rolls:
    /// each of its increments makes those of the `distance` travelled \[m\].
    pub(crate) fn increment(
        &self,
        number: u32,
        motion: &Motion,
        resultants: &PerDof<f64>,
        distance: f64,
    ) -> PerDof<Control> {
        let mut controls = self.even_increment(number, motion, resultants);
        for dof in Dof::TANGENTIAL.into_iter().filter(|_| self.rolling.is_some()) {
            if let Control::Motion(rate) = self.target[dof] {
                controls[dof] = Control::Motion(rate * distance);
            }
        }
        controls
    }

    /// Returns whether the leg rolls steadily.
    pub(crate) fn is_steady(&self) -> bool {
        self.rolling.is_some_and(|rolling| rolling.history == RollingHistory::Steady)
    }

    /// Returns the controls of increment `number`, each between its start and its target.
    fn even_increment(
        &self,
        number: u32,
        motion: &Motion,
        resultants: &PerDof<f64>,
    ) -> PerDof<Control> {
        let mut controls = self.target;
        if number >= self.increments {
            return controls; // The last increment meets the target without rounding.
        }
        let share = f64::from(number) / f64::from(self.increments);
        let motion = motion.per_dof();
        for (dof, control) in Dof::ALL.into_iter().zip(controls.iter_mut()) {
            let between = |from: f64, to: f64| from + share * (to - from);
            *control = match *control {
                Control::Motion(to) => Control::Motion(between(motion[dof], to)),
                Control::Force(to) => Control::Force(between(resultants[dof], to)),
            };
        }
        controls
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{ImposedCreepages, RollingDirection};

    #[test]
    fn what_is_not_mentioned_stays_as_it_was() {
        let press = Step { normal_force: Some(10.0), ..Step::default() };
        let pull = Step { force_x: Some(2.0), increments: 4, ..Step::default() };
        let hold = Step { shift_x: Some(1e-6), approach: Some(1e-5), ..Step::default() };
        let legs =
            Loading { steps: vec![press, pull, hold], cycle_from: Some(1), cycles: 2 }.legs();
        let order: Vec<_> = legs.iter().map(|leg| (leg.step, leg.cycle)).collect();
        assert_eq!(order, [(0, 0), (1, 1), (2, 1), (1, 2), (2, 2)]);
        assert_eq!(legs[1].target.to_array()[..2], [Control::Force(10.0), Control::Force(2.0)]);
        assert_eq!(legs[2].target.to_array()[..2], [Control::Motion(1e-5), Control::Motion(1e-6)]);
        assert_eq!(
            legs[3].target.to_array()[..2],
            [Control::Motion(1e-5), Control::Force(2.0)],
            "the second cycle begins where the first ended"
        );
        let halfway = legs[1].increment(
            2,
            &Motion::default(),
            &PerDof::new([8.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
            0.0,
        );
        assert_eq!(
            halfway.to_array()[..3],
            [Control::Force(9.0), Control::Force(1.5), Control::Motion(0.0)]
        );
        assert_eq!(
            legs[1].increment(
                4,
                &Motion::default(),
                &PerDof::new([8.0, 0.3, 0.0, 0.0, 0.0, 0.0]),
                0.0
            ),
            legs[1].target
        );
    }

    #[test]
    fn creepages_are_motions_per_distance_and_leave_no_shift_behind() {
        let rolling = Rolling {
            creepage_x: Some(1e-3),
            creepage_y: Some(2e-3),
            spin: Some(0.5),
            spin_center: 0.01,
            direction: RollingDirection::Forward,
            dq: Some(0.2),
            distance: None,
            history: RollingHistory::Transient,
            imposed: ImposedCreepages::default(),
        };
        let shift = Step {
            approach: Some(1e-5),
            shift_x: Some(1e-6),
            force_y: Some(3.0),
            ..Step::default()
        };
        let roll = Step { rolling: Some(rolling), increments: 2, ..Step::default() };
        let pulled = Rolling { creepage_y: None, spin: None, ..rolling };
        let pull = Step { rolling: Some(pulled), force_y: Some(1.0), ..Step::default() };
        let legs = Loading::path(vec![shift, roll, pull, Step::default()]).legs();
        let tangential = |leg: &Leg| Dof::TANGENTIAL.map(|dof| leg.target[dof]);
        assert_eq!(tangential(&legs[1]), [-1e-3, -(2e-3 - 0.5 * 0.01), -0.5].map(Control::Motion));
        assert_eq!(
            tangential(&legs[2]),
            [Control::Motion(-1e-3), Control::Force(1.0), Control::Motion(0.0)]
        );
        assert_eq!(
            tangential(&legs[3]),
            [Control::Motion(0.0), Control::Force(1.0), Control::Motion(0.0)]
        );
        let nothing = (Motion::default(), PerDof::all(0.0));
        for number in 1..=2 {
            let controls = legs[1].increment(number, &nothing.0, &nothing.1, 0.2);
            assert_eq!(controls[Dof::ShiftX], Control::Motion(-1e-3 * 0.2));
            assert_eq!(controls[Dof::Twist], Control::Motion(-0.5 * 0.2));
        }
        let refused = |step: Step| {
            Loading::path(vec![shift, step]).validate().map_err(|error| error.key).unwrap_err()
        };
        assert_eq!(refused(Step { shift_x: Some(0.0), ..roll }), "loading.steps[1].shift_x");
        assert_eq!(refused(Step { force_y: Some(0.0), ..roll }), "loading.steps[1].force_y");
        let steady = Rolling { history: RollingHistory::Steady, ..rolling };
        assert_eq!(refused(Step { rolling: Some(steady), ..roll }), "loading.steps[1].increments");
        let nowhere = Rolling { dq: Some(0.0), ..rolling };
        assert_eq!(refused(Step { rolling: Some(nowhere), ..roll }), "loading.steps[1].dq");
        let endless = Rolling { spin: Some(f64::NAN), ..rolling };
        assert_eq!(refused(Step { rolling: Some(endless), ..roll }), "loading.steps[1].spin");
    }

    #[test]
    fn paths_that_are_the_same_become_equal() {
        let short = Loading::path(vec![
            Step { approach: Some(1.0), ..Step::default() },
            Step { force_x: Some(2.0), ..Step::default() },
        ]);
        let wordy = Loading::path(vec![
            Step { approach: Some(1.0), shift_y: Some(-0.0), ..Step::default() },
            Step { approach: Some(1.0), shift_y: Some(0.0), force_x: Some(2.0), ..Step::default() },
        ]);
        assert_eq!(wordy.normalised(false), short);
        assert_eq!(short.legs(), wordy.legs());
        let cycle = Loading {
            steps: vec![
                short.steps[0],
                Step { shift_x: Some(0.0), ..Step::default() },
                short.steps[1],
            ],
            cycle_from: Some(1),
            cycles: 2,
        };
        assert_eq!(
            cycle.normalised(false),
            cycle,
            "a step of a cycle comes after its last as well"
        );
        assert_eq!(cycle.normalised(false).legs(), cycle.legs());
    }

    #[test]
    fn increments_are_those_of_the_legs() {
        let press = Step { normal_force: Some(10.0), increments: 3, ..Step::default() };
        let pull = Step { force_x: Some(2.0), increments: 4, ..Step::default() };
        for (cycle_from, cycles, count) in [(None, 1, 7), (Some(1), 5, 23), (Some(0), 2, 14)] {
            let loading = Loading { steps: vec![press, pull], cycle_from, cycles };
            let sum: u32 = loading.legs().iter().map(|leg| leg.increments).sum();
            assert_eq!((loading.increments(), u64::from(sum)), (count, count));
        }
    }
}
