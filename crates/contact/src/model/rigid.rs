//! The six rigid degrees of freedom: a motion, what controls each, and how they move a point of the
//! surface.

use serde::{Deserialize, Serialize};

/// Position of the punch from where it just touches at the origin, with the signs of
/// [`Step`](super::loading::Step).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Approach δ \[m\].
    pub approach: f64,
    /// Shift along x \[m\].
    pub shift_x: f64,
    /// Shift along y \[m\].
    pub shift_y: f64,
    /// Tilt about the x axis \[rad\].
    pub tilt_x: f64,
    /// Tilt about the y axis \[rad\].
    pub tilt_y: f64,
    /// Twist φ about the z axis \[rad\].
    pub twist: f64,
}

impl Motion {
    /// In the order of [`Step::NAMES`](super::loading::Step::NAMES).
    pub fn to_array(self) -> [f64; 6] {
        [self.approach, self.shift_x, self.shift_y, self.tilt_x, self.tilt_y, self.twist]
    }

    /// From the order of [`Step::NAMES`](super::loading::Step::NAMES).
    pub fn from_array([approach, shift_x, shift_y, tilt_x, tilt_y, twist]: [f64; 6]) -> Self {
        Self { approach, shift_x, shift_y, tilt_x, tilt_y, twist }
    }
}

/// What governs a rigid degree of freedom of the punch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// Its position is prescribed \[m or rad\].
    Motion(f64),
    /// Its force or moment is prescribed \[N or N m\].
    Force(f64),
}

/// Displacement of the punch at (x, y) under unit motion of each degree of freedom, as \[component
/// n, x, y\]\[degree of freedom\]. Its transpose sums tractions to resultants.
pub(crate) fn rigid_modes(x: f64, y: f64) -> [[f64; 6]; 3] {
    [[1.0, 0.0, 0.0, y, -x, 0.0], [0.0, 1.0, 0.0, 0.0, 0.0, -y], [0.0, 0.0, 1.0, 0.0, 0.0, x]]
}
