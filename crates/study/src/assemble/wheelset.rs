//! The motion of a wheelset, whose keys stand beside its position.

use contact::model::WheelsetMotion;

use super::{Assembler, WHEELSET_MOTION};
use crate::error::Mistake;
use crate::key::Key;

impl Assembler<'_> {
    /// Assembles the motion of a wheelset, if its speed is given. Another velocity without it is a
    /// mistake, which is noted.
    pub(super) fn motion(&mut self) -> Option<WheelsetMotion> {
        let number = |key| self.sheet.number(key);
        if let Some(speed) = number(Key::Speed) {
            return Some(WheelsetMotion {
                speed,
                angular_speed: number(Key::AngularSpeed),
                lateral_velocity: self.number_or_default(Key::LateralVelocity),
                yaw_rate: self.number_or_default(Key::YawRate),
                roll_rate: self.number_or_default(Key::RollRate),
            });
        }
        let given = WHEELSET_MOTION.iter().find_map(|key| Some((key, self.sheet.get(*key)?)));
        if let Some((key, given)) = given {
            let message = format!("`{}` is a part of no motion", key.short());
            let expected = "needs `speed` beside it, the velocity of the wheelset along the track";
            self.mistakes.push(Mistake::new(given.span.clone(), message, expected));
        }
        None
    }
}
