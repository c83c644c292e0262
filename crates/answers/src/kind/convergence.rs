//! Studies that compare every point with the limit of its ladder.

use super::solve;
use super::spec::KindAnswers;
use crate::comparison::Comparison;
use crate::convergence;

/// The kind.
pub(super) const ANSWERS: KindAnswers = KindAnswers {
    check: |study, points| match &study.ladder() {
        Some(ladder) => convergence::check(study, ladder, points),
        None => Ok(()),
    },
    compare: |evidence| match &evidence.study.ladder() {
        Some(ladder) => convergence::compare(evidence, ladder),
        None => Ok(Comparison::of_points(evidence.points.len())),
    },
    about: None,
    ..solve::ANSWERS
};
