//! The motion of a wheelset, from which the creepages of its wheels follow.

use serde::{Deserialize, Serialize};

use super::error::{SceneError, finite, is_zero, refuse};
use super::loading::{Leg, Loading, Step};
use super::rigid::{Control, Dof};
use super::rolling::Rolling;

/// The motion of a wheelset at its position in the track. A step that rolls takes from it the
/// creepages and the spin that no force governs. The vertical velocity follows, for the wheel stays
/// on its rail. The rails rest; in a curve of radius R the yaw rate is therefore the speed over R.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelsetMotion {
    /// The velocity of the middle of the axle along the track, not 0 \[m/s\].
    pub speed: f64,
    /// The angular speed about the axle, positive as in rolling towards +x \[rad/s\]. `None` is the
    /// speed over the rolling radius.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angular_speed: Option<f64>,
    /// The velocity of the middle of the axle along y \[m/s\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lateral_velocity: f64,
    /// The rate of the yaw, about the wheelset's z \[rad/s\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub yaw_rate: f64,
    /// The rate of the roll, about the track's x \[rad/s\].
    #[serde(default, skip_serializing_if = "is_zero")]
    pub roll_rate: f64,
}

impl WheelsetMotion {
    /// Returns the angular speed about the axle \[rad/s\] of a wheelset whose wheels have this
    /// nominal `rolling_radius` \[m\].
    pub fn angular_speed(&self, rolling_radius: f64) -> f64 {
        self.angular_speed.unwrap_or(self.speed / rolling_radius)
    }

    /// Refuses a motion without meaning, and one that contradicts the path `loading`, which is
    /// known to be valid.
    pub(super) fn validate(&self, loading: &Loading) -> Result<(), SceneError> {
        for (key, value) in [
            ("punch.speed", Some(self.speed)),
            ("punch.angular_speed", self.angular_speed),
            ("punch.lateral_velocity", Some(self.lateral_velocity)),
            ("punch.yaw_rate", Some(self.yaw_rate)),
            ("punch.roll_rate", Some(self.roll_rate)),
        ] {
            value.map_or(Ok(()), |value| finite(key, value))?;
        }
        if self.speed == 0.0 {
            return Err(refuse("punch.speed", self.speed, "must not be 0: nothing rolls then"));
        }
        if loading.steps.iter().all(|step| step.rolling.is_none()) {
            let expected = "is of no use without a step that rolls: leave it out, or let one roll";
            return Err(refuse("punch.speed", self.speed, expected));
        }
        for (index, rolling) in
            loading.steps.iter().enumerate().filter_map(|(i, step)| Some((i, step.rolling?)))
        {
            for (value, name) in rolling.given().into_iter().zip(Rolling::NAMES) {
                if let Some(value) = value {
                    let key = format!("loading.steps[{index}].{name}");
                    let expected = "cannot stand beside `punch.speed`: the motion of the wheelset \
                                    says what it is, so leave out one of the two";
                    return Err(refuse(&key, value, expected));
                }
            }
        }
        // The velocities that say nothing but what a force governs, and the spin, which a wheel has
        // from its wheelset alone.
        let moves = |velocity: f64| (velocity != 0.0).then_some(velocity);
        let (along, across) = ("the creepage along the rail", "the creepage across the rail");
        let legs = loading.legs();
        for (key, value, dof, governed) in [
            ("punch.angular_speed", self.angular_speed, Dof::ShiftX, along),
            ("punch.lateral_velocity", moves(self.lateral_velocity), Dof::ShiftY, across),
            ("punch.roll_rate", moves(self.roll_rate), Dof::ShiftY, across),
            ("punch.speed", Some(self.speed), Dof::Twist, "the spin"),
        ] {
            let governs =
                |leg: &&Leg| leg.rolling.is_some() && matches!(leg.target[dof], Control::Force(_));
            if let (Some(value), Some(leg)) = (value, legs.iter().find(governs)) {
                let [_, force] = Step::NAMES[dof];
                let expected = format!(
                    "cannot be given where `{force}` governs {governed}, as in \
                     loading.steps[{}]: leave out one of the two",
                    leg.step
                );
                return Err(refuse(key, value, &expected));
            }
        }
        Ok(())
    }
}
