//! Studies that tell how much each key moves a result.

use super::solve;
use super::spec::KindAnswers;
use crate::influence;

/// The kind.
pub(super) const ANSWERS: KindAnswers =
    KindAnswers { about: Some(influence::tables), ..solve::ANSWERS };
