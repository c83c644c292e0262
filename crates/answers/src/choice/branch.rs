//! Narrows the brackets of uniqueness sets by jobs that exclude parts of the fields.
//!
//! The bracket of a point comes first. Its upper end and the length that is asked for give the
//! friction that is to be shown to be below μ*, and the results of branches say which others there
//! are, generation by generation ([`contact::uniqueness::branch`]). A lower end is said only where
//! the cones of all branches together leave no field out.

use contact::uniqueness::branch::{self, Branch, BranchResult, Growth, GrowthEnd};
use contact::uniqueness::{Bracket, Question, System};
use identity::JobKey;
use study::job::PHYSICS_VERSION;
use study::{Job, Record, Study, StudyPoint, Value};

use super::found::{Discovery, Finding, PointChoice};
use crate::error::AnswerError;
use crate::place::StudyPlace;
use crate::records::RecordMap;

/// The rule of a study with `[branch]`.
pub(super) struct BracketNarrowing<'a> {
    pub(super) study: &'a Study,
    pub(super) records: &'a RecordMap,
    /// The length of a bracket, relative to its upper end, that is small enough.
    pub(super) to: f64,
    /// The number of cones of one length after which no further branches are made.
    pub(super) at_most: usize,
}

impl BracketNarrowing<'_> {
    /// Returns the bracket of the point with an index and its branches, as far as the records
    /// determine them.
    pub(super) fn choose(&self, index: usize) -> Result<PointChoice, AnswerError> {
        let first = self
            .study
            .point(index)
            .ok_or(AnswerError::Inconsistent("a point of the study cannot be made"))?;
        let place = StudyPlace::of(self.study, &first, |_| true);
        let mut points = vec![first.clone()];
        let discovery = self.follow(&first, &mut points);
        Ok(PointChoice { points, findings: vec![Finding { place, discovery }], more: None })
    }

    /// Follows the branches of the bracket of the `first` point and adds each to `points`.
    fn follow(&self, first: &StudyPoint, points: &mut Vec<StudyPoint>) -> Discovery {
        let Some(record) = self.records.get(&first.key) else { return Discovery::Pending };
        let Job::Uniqueness { question, .. } = &first.job else { return Discovery::Unsolved };
        let bracket = record.bracketed().filter(|_| record.is_certified());
        let Some(bracket) = bracket.and_then(|found| found.bracket.as_ref()) else {
            return Discovery::Unsolved;
        };
        let of_bracket = |reason: &'static str| Discovery::Branched {
            ends: bracket.ends(),
            jobs: 0,
            cones: 0,
            reason,
        };
        let [low, high] = match bracket {
            Bracket::Unbounded => return of_bracket("nothing couples pressures and tractions"),
            _ => bracket.ends().unwrap_or_default(),
        };
        if high - low <= self.to * high {
            return of_bracket("weights alone show it");
        }
        let Ok(system) = System::new(question) else { return Discovery::Unsolved };
        let (mut width, mut jobs, mut cones) = (self.to, 0, 0);
        let mut miss = None;
        loop {
            let mu = branch::goal(high, width);
            if mu <= low {
                let reason = miss.map_or("weights alone show it", NarrowingMiss::by_weights);
                return Discovery::Branched { ends: Some([low, high]), jobs, cones, reason };
            }
            let result = |branch: &Branch| self.result(question, branch);
            let Growth { branches, cones: looked_at, end } =
                branch::grow(&system, mu, self.at_most, result);
            (jobs, cones) = (jobs + branches.len(), cones + looked_at);
            points.extend(branches.into_iter().map(|branch| of_branch(first, question, branch)));
            miss = Some(match end {
                GrowthEnd::Pending => return Discovery::Pending,
                GrowthEnd::Whole(bound) => {
                    let ends = Some([bound.mu, high]);
                    let reason = miss.map_or("branches show it", NarrowingMiss::by_branches);
                    return Discovery::Branched { ends, jobs, cones, reason };
                }
                GrowthEnd::Full | GrowthEnd::GivenUp => NarrowingMiss::TooManyCones,
                GrowthEnd::Unsolved => NarrowingMiss::Unsolved,
                GrowthEnd::Unfit(_) => NarrowingMiss::Unfit,
            });
            width *= 2.0;
        }
    }

    /// Returns the result of a branch: what a certified record of just its job holds.
    fn result(&self, question: &Question, branch: &Branch) -> BranchResult<'_> {
        let text = job_of(question, branch.clone()).canonical();
        let record = self.records.get(&JobKey::of(PHYSICS_VERSION, &text));
        result_of(&text, record)
    }
}

/// The reason why a bracket is not as narrow as was asked for.
#[derive(Clone, Copy)]
enum NarrowingMiss {
    TooManyCones,
    Unsolved,
    /// The results leave fields out.
    Unfit,
}

impl NarrowingMiss {
    /// Returns the words for a wider bracket that branches show.
    fn by_branches(self) -> &'static str {
        match self {
            Self::TooManyCones => "branches show it; a narrower one takes too many cones",
            Self::Unsolved => "branches show it; of a narrower one a job was not solved",
            Self::Unfit => "branches show it; those of a narrower one leave fields out",
        }
    }

    /// Returns the words for a bracket that branches do not narrow.
    fn by_weights(self) -> &'static str {
        match self {
            Self::TooManyCones => "weights alone show it; a narrower one takes too many cones",
            Self::Unsolved => "weights alone show it; the job of a branch was not solved",
            Self::Unfit => "weights alone show it; branches leave fields out",
        }
    }
}

/// Returns what a record says of the branch whose job has a canonical text.
fn result_of<'r>(job: &str, record: Option<&'r Record>) -> BranchResult<'r> {
    let Some(record) = record else { return BranchResult::Missing };
    let is_of_job = record.job == job && record.is_certified();
    match record.branched().filter(|_| is_of_job) {
        Some(found) => BranchResult::Cases(&found.cases),
        None => BranchResult::Unsolved,
    }
}

fn job_of(question: &Question, branch: Branch) -> Job {
    Job::Branch { question: question.clone(), branch }
}

/// Returns the point of a branch, at the place of its bracket.
fn of_branch(first: &StudyPoint, question: &Question, branch: Branch) -> StudyPoint {
    let job = job_of(question, branch);
    let values: Vec<Value> = first.values.clone();
    StudyPoint { values, key: job.key(), job }
}
