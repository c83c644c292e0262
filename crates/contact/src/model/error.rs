//! The refusal of a scene that has no mechanical meaning, and the checks that many keys share.

/// Returns whether a number is 0, so that a stored scene leaves it out.
pub(crate) fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// The reason why a scene or its numerics cannot mean anything.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} = {value}: {expected}")]
pub struct SceneError {
    /// The key as in a study file, below `scene` or `numerics`.
    pub key: String,
    /// The offending value.
    pub value: String,
    /// The condition that a right value meets.
    pub expected: String,
}

/// Makes the refusal of a value.
pub(crate) fn refuse(key: &str, value: impl ToString, expected: &str) -> SceneError {
    SceneError { key: key.to_owned(), value: value.to_string(), expected: expected.to_owned() }
}

/// Refuses a number that is infinite or not a number.
pub(crate) fn finite(key: &str, x: f64) -> Result<(), SceneError> {
    if x.is_finite() { Ok(()) } else { Err(refuse(key, x, "must be a finite number")) }
}

/// Refuses a number that is not finite or not above 0.
pub(crate) fn positive(key: &str, x: f64) -> Result<(), SceneError> {
    if x.is_finite() && x > 0.0 {
        Ok(())
    } else {
        Err(refuse(key, x, "must be a finite number above 0"))
    }
}
