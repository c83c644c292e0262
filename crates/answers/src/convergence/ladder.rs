//! One ladder: its rungs, and how far each is from the reference.

use std::collections::HashSet;

use contact::assess::{ClosedForm, Errors, closed_form};
use contact::model::{Fields, Outcome, StepOutcome};
use identity::JobKey;
use study::columns::Compared;
use study::key::Key;
use study::kind::convergence::{Ladder, Reference};
use study::{Case, Job, Record};

use crate::error::AnswerError;
use crate::evidence::{Evidence, end_of};
use crate::place::{PointGroup, StudyPlace};

/// Returns the closed form that the rungs of a ladder tend to. Closed forms hold for ε = 0.
pub(super) fn exact(ladder: &Ladder, case: &Case) -> Option<ClosedForm> {
    if ladder.along == Key::Epsilon || case.numerics.epsilon != 0.0 {
        None
    } else {
        closed_form(&case.scene)
    }
}

/// The rungs of one ladder.
pub(super) struct LadderRungs<'a> {
    /// The values of the other axes.
    pub(super) place: StudyPlace,
    /// The name of what the rungs are compared with.
    pub(super) reference: String,
    /// The relative error below which errors are the solver's.
    pub(super) noise: f64,
    /// The rungs, from the coarsest to the finest.
    pub(super) rungs: Vec<LadderRung<'a>>,
    /// The number of rungs that the study has; those without a certified result are missing.
    pub(super) wanted: usize,
}

/// A rung that was solved.
pub(super) struct LadderRung<'a> {
    /// The diagonal of an element \[m\], or ε; a smaller one is finer.
    pub(super) height: f64,
    /// The index of the point.
    pub(super) point: usize,
    /// The result.
    pub(super) outcome: &'a Outcome,
    record: &'a Record,
    case: &'a Case,
}

/// The reference that the rungs of a ladder are compared with.
enum LadderLimit<'a> {
    Exact(ClosedForm),
    /// The finest rung, which has no error against itself.
    Finest {
        point: usize,
        end: &'a StepOutcome,
        fields: Fields,
    },
    /// The finest rung, which has no increment.
    Nothing,
}

impl LadderRungs<'_> {
    /// Says how many of the study's rungs were solved.
    pub(super) fn solved(&self) -> String {
        format!("{} of {}", self.rungs.len(), self.wanted)
    }
}

impl LadderRung<'_> {
    fn errors(
        &self,
        evidence: &Evidence<'_>,
        limit: &LadderLimit<'_>,
    ) -> Result<Option<Errors>, AnswerError> {
        let Some(end) = end_of(self.record) else { return Ok(None) };
        Ok(match limit {
            LadderLimit::Exact(exact) => {
                Errors::against_closed_form(end, &evidence.fields(self.record)?, exact)
            }
            LadderLimit::Finest { point, end: finest, fields } if *point != self.point => {
                let legs = self.case.scene.loading.legs();
                let rung_fields = evidence.fields(self.record)?;
                legs.last().and_then(|leg| {
                    Errors::against_solution(end, &rung_fields, finest, fields, leg)
                })
            }
            LadderLimit::Finest { .. } | LadderLimit::Nothing => None,
        })
    }
}

/// Gathers the rungs of a ladder and writes how far each is from the reference to `compared`, which
/// has an entry for each point; `None` if no rung is solved.
pub(super) fn compare<'a>(
    evidence: &Evidence<'a>,
    ladder: &Ladder,
    PointGroup { place, members }: PointGroup,
    compared: &mut [Option<Compared>],
) -> Result<Option<LadderRungs<'a>>, AnswerError> {
    let keys: HashSet<JobKey> = members.iter().map(|point| evidence.points[*point].key).collect();
    let wanted = keys.len();
    let rungs = solved_rungs(evidence, ladder, members);
    let Some(finest) = rungs.last() else { return Ok(None) };
    let limit = match ladder.reference {
        Some(Reference::Finest) => None,
        Some(Reference::ClosedForm) | None => exact(ladder, finest.case),
    };
    let (limit, name, source) = match limit {
        Some(exact) => {
            let (name, source) = (exact.name.to_owned(), format!(" ({})", exact.source));
            (LadderLimit::Exact(exact), name, source)
        }
        None => {
            let limit = match end_of(finest.record) {
                Some(end) => {
                    let fields = evidence.fields(finest.record)?;
                    LadderLimit::Finest { point: finest.point, end, fields }
                }
                None => LadderLimit::Nothing,
            };
            let name = finest.name(ladder.along);
            let name = if rungs.len() < wanted { name + ", the finest solved" } else { name };
            (limit, name, String::new())
        }
    };
    for rung in &rungs {
        compared[rung.point] = rung.errors(evidence, &limit)?.map(|errors| Compared {
            errors,
            reference: format!("{name}{source}"),
            claim: None,
            noise: None,
        });
    }
    let noise = 10.0 * finest.case.numerics.tolerance;
    Ok(Some(LadderRungs { place, reference: name, noise, rungs, wanted }))
}

/// Returns the certified rungs among some points, from the coarsest to the finest; points whose
/// jobs coincide count once.
fn solved_rungs<'a>(
    evidence: &Evidence<'a>,
    ladder: &Ladder,
    members: Vec<usize>,
) -> Vec<LadderRung<'a>> {
    let mut rungs: Vec<LadderRung<'_>> = Vec::new();
    for point in members {
        let (Job::Solve(case), Some(record)) =
            (&evidence.points[point].job, evidence.certified(point))
        else {
            continue;
        };
        let Some(outcome) = record.outcome() else { continue };
        let key = evidence.points[point].key;
        if rungs.iter().all(|rung| evidence.points[rung.point].key != key) {
            let height = height(ladder.along, case, record);
            rungs.push(LadderRung { height, point, outcome, record, case });
        }
    }
    rungs.sort_by(|a, b| b.height.total_cmp(&a.height));
    rungs
}

/// Returns how fine a rung is: the diagonal of its elements \[m\], or ε.
fn height(along: Key, case: &Case, record: &Record) -> f64 {
    match (along, end_of(record)) {
        (Key::Epsilon, _) | (_, None) => case.numerics.epsilon,
        (_, Some(end)) => end.observables.element_x.hypot(end.observables.element_y),
    }
}

impl LadderRung<'_> {
    /// Names the rung as the reference of its ladder.
    fn name(&self, along: Key) -> String {
        if along == Key::Epsilon {
            return format!("epsilon = {}", self.case.numerics.epsilon);
        }
        let [x, y] = self
            .outcome
            .last()
            .map_or([0; 2], |end| [end.observables.mesh_x, end.observables.mesh_y]);
        format!("mesh {x} x {y}")
    }
}
