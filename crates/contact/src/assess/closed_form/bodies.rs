//! The modulus of two bodies, and controls that ask for nothing.

use crate::foundation::HalfSpace;
use crate::model::Control;

/// Returns E* = 2/Σ((1−ν)/G) \[Pa\].
pub(super) fn modulus(bodies: &HalfSpace) -> f64 {
    2.0 / bodies.direct
}

/// Returns whether a control prescribes no motion and no force.
pub(super) fn is_nothing(control: Control) -> bool {
    matches!(control, Control::Motion(0.0) | Control::Force(0.0))
}
