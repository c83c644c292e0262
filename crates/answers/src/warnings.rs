//! Doubts about results that are certified: counts of elements that should be 0, and errors of the
//! mesh that are not estimated or large.

use contact::model::{FigureErrors, Observables, StepOutcome};
use serde::{Deserialize, Serialize};
use study::Record;

use crate::evidence::end_of;
use crate::rows::digits;

/// A doubt about some results.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Warning {
    /// The doubt, in words.
    pub words: String,
    /// The filter that finds the rows that it concerns.
    pub filter: String,
    /// The rows are those of increments: the end of some path does not show it.
    pub steps: bool,
}

/// The relative error above which an estimate is large if nobody has asked for less.
const LARGE: f64 = 0.1;

/// The estimated errors that are looked at if nobody has asked for one. Moments and rotations are
/// often small differences, whose relative errors are large and mean little.
const FIGURES: [&str; 5] = ["load", "approach", "tangential_force", "shift", "peak_pressure"];

/// The relative difference between two ways to the stresses below the surface above which neither
/// is trusted.
const LARGE_RESIDUAL: f64 = 1e-5;

/// The errors that an estimate is held against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RequiredError {
    /// The figure whose error counts; `None` for any scalar.
    pub(crate) figure: Option<&'static str>,
    /// The largest relative error.
    pub(crate) limit: f64,
}

impl RequiredError {
    /// The error that is large whatever the study asks.
    pub(crate) const LARGE: RequiredError = RequiredError { figure: None, limit: LARGE };

    /// Returns the error of the figure that tells of a column, if it is to change by less than
    /// `until`; `None` for a column whose error nothing estimates.
    pub(crate) fn of_column(column: &str, until: f64) -> Option<Self> {
        let figure = match column {
            "load" => "load",
            "at_approach" => "approach",
            "peak_pressure" => "peak_pressure",
            "contact_area" | "contact_radius" => "contact_area",
            "stick_area" | "stick_fraction" => "stick_area",
            _ => return None,
        };
        Some(Self { figure: Some(figure), limit: until })
    }

    fn figures(&self) -> &[&'static str] {
        self.figure.as_ref().map_or(&FIGURES, std::slice::from_ref)
    }
}

/// A count of elements that should be 0.
struct ElementCount {
    /// The column of the count.
    column: &'static str,
    /// The meaning of another count, after the word "elements".
    words: &'static str,
    read: fn(&Observables) -> u64,
}

const COUNTS: [ElementCount; 2] = [
    ElementCount {
        column: "edge_elements",
        words: "touch the edge of Ω although the punch goes on beyond it; give a larger `domain`",
        read: |observables| observables.edge_elements,
    },
    ElementCount {
        column: "ceiling_elements",
        words: "reach the pressure ceiling and so solve the regularised equation only; \
                raise `ceiling`",
        read: |observables| observables.ceiling_elements,
    },
];

/// Returns the doubts about one result of a scene, whatever its study asks.
pub fn warnings(record: &Record) -> Vec<Warning> {
    let mut warnings = of_elements(&[record], Subject::OneResult);
    warnings.extend(of_interiors(&[record], Subject::OneResult));
    warnings.extend(of_estimates(&[record], Subject::OneResult, &RequiredError::LARGE));
    warnings
}

/// Warns of counts of elements of some results.
pub(crate) fn of_elements(records: &[&Record], subject: Subject) -> Vec<Warning> {
    let mut doubts = ElementDoubts::new(subject);
    records.iter().for_each(|record| doubts.add(record));
    doubts.warnings()
}

/// Warns of certified results whose stresses below the surface two ways do not agree on.
pub(crate) fn of_interiors(records: &[&Record], subject: Subject) -> Option<Warning> {
    let mut doubts = InteriorDoubts::new(subject);
    records.iter().for_each(|record| doubts.add(record));
    doubts.warning()
}

/// The doubts about counts of elements, which results are added to one by one.
pub(crate) struct ElementDoubts {
    subject: Subject,
    /// For each count the number of results that it concerns, and whether some of them have several
    /// increments.
    concerned: [(usize, bool); COUNTS.len()],
}

impl ElementDoubts {
    pub(crate) fn new(subject: Subject) -> Self {
        Self { subject, concerned: Default::default() }
    }

    pub(crate) fn add(&mut self, record: &Record) {
        // The columns of a failed point are empty, so that no filter finds it.
        if self.subject != Subject::OneResult && !record.is_certified() {
            return;
        }
        let steps = steps_of(record);
        for (count, (concerned, has_steps)) in COUNTS.iter().zip(&mut self.concerned) {
            if steps.iter().any(|step| (count.read)(&step.observables) > 0) {
                *concerned += 1;
                *has_steps |= steps.len() > 1;
            }
        }
    }

    pub(crate) fn warnings(&self) -> Vec<Warning> {
        let counted =
            COUNTS.iter().zip(self.concerned).filter(|(_, (concerned, _))| *concerned > 0);
        let warning = |(ElementCount { column, words, .. }, (concerned, steps)): (&_, _)| Warning {
            words: format!("elements{} {words}", self.subject.of(concerned)),
            filter: format!("{column} > 0"),
            steps,
        };
        counted.map(warning).collect()
    }
}

/// The doubts about stresses below the surface, which results are added to one by one.
pub(crate) struct InteriorDoubts {
    subject: Subject,
    concerned: usize,
    worst: Option<f64>,
}

impl InteriorDoubts {
    pub(crate) fn new(subject: Subject) -> Self {
        Self { subject, concerned: 0, worst: None }
    }

    pub(crate) fn add(&mut self, record: &Record) {
        let outcome = record.outcome().filter(|_| record.is_certified());
        let interior = outcome.and_then(|outcome| outcome.further.interior.as_ref());
        // What is not a number is not small.
        let is_large = |residual: &f64| residual.is_nan() || *residual > LARGE_RESIDUAL;
        if let Some(residual) = interior.and_then(|interior| interior.residual).filter(is_large) {
            self.concerned += 1;
            self.worst = Some(self.worst.map_or(residual, |worst| worst.max(residual)));
        }
    }

    pub(crate) fn warning(&self) -> Option<Warning> {
        Some(Warning {
            words: format!(
                "stresses below the surface{} differ by up to {} between two ways to them: the \
                 foundation or the places are beyond what doubles resolve",
                self.subject.of(self.concerned),
                percent(self.worst?)
            ),
            filter: format!("interior_residual > {LARGE_RESIDUAL:e}"),
            steps: false,
        })
    }
}

fn steps_of(record: &Record) -> &[StepOutcome] {
    record.outcome().map_or(&[], |outcome| &outcome.steps)
}

/// Warns of certified results in contact whose error is not estimated, or is larger than the
/// limit.
pub(crate) fn of_estimates(
    records: &[&Record],
    subject: Subject,
    required: &RequiredError,
) -> Vec<Warning> {
    let mut doubts = EstimateDoubts::new(subject, *required);
    records.iter().for_each(|record| doubts.add(record));
    doubts.warnings()
}

/// The doubts about estimated errors, which results are added to one by one.
pub(crate) struct EstimateDoubts {
    subject: Subject,
    required: RequiredError,
    /// The number of results without an estimate.
    missing: usize,
    /// All results without an estimate are of coarse meshes.
    are_coarse: bool,
    /// The first result without an estimate has estimates of other figures.
    has_others: bool,
    /// The number of results whose estimates are above the limit.
    large: usize,
    /// The largest estimate above the limit of each figure.
    worst: Vec<Option<f64>>,
}

impl EstimateDoubts {
    pub(crate) fn new(subject: Subject, required: RequiredError) -> Self {
        let worst = vec![None; required.figures().len()];
        Self { subject, required, missing: 0, are_coarse: true, has_others: false, large: 0, worst }
    }

    pub(crate) fn add(&mut self, record: &Record) {
        let end = end_of(record).filter(|end| end.observables.contact_area > 0.0);
        let Some(end) = end.filter(|_| record.is_certified()) else { return };
        let estimates = estimates(record);
        let is_missing = match (&estimates, self.required.figure) {
            (None, _) => true,
            (Some(errors), Some(figure)) => error(errors, figure).is_none(),
            (Some(_), None) => false,
        };
        if is_missing {
            if self.missing == 0 {
                self.has_others = estimates.is_some();
            }
            self.missing += 1;
            self.are_coarse &= end.observables.mesh_x.min(end.observables.mesh_y) < FEWEST;
        }
        let Some(errors) = estimates else { return };
        let mut is_large = false;
        for (figure, worst) in self.required.figures().iter().zip(&mut self.worst) {
            let above = error(&errors, figure).filter(|error| *error > self.required.limit);
            is_large |= above.is_some();
            *worst = match (*worst, above) {
                (Some(worst), Some(above)) => Some(worst.max(above)),
                (worst, above) => worst.or(above),
            };
        }
        self.large += usize::from(is_large);
    }

    pub(crate) fn warnings(&self) -> Vec<Warning> {
        self.missing_words().into_iter().chain(self.large_words()).collect()
    }

    fn missing_words(&self) -> Option<Warning> {
        if self.missing == 0 {
            return None;
        }
        let why = if self.are_coarse {
            format!(": there are fewer than {FEWEST} elements along a side; give a finer `mesh`")
        } else if self.has_others {
            "; its limit may not be a number".to_owned()
        } else {
            ": half as many elements along each side did not do".to_owned()
        };
        let figure = self.required.figure;
        let what = figure.map_or(String::new(), |figure| format!(" in the {}", noun(figure)));
        let column = figure.unwrap_or("solver");
        let of = self.subject.of(self.missing);
        Some(Warning {
            words: format!("no error{what}{of} is estimated{why}"),
            filter: format!("status == \"certified\" && estimate_{column} == null"),
            steps: false,
        })
    }

    fn large_words(&self) -> Option<Warning> {
        let figures = self.required.figures().iter().zip(&self.worst);
        let worst: Vec<(&str, f64)> =
            figures.filter_map(|(figure, worst)| Some((*figure, (*worst)?))).collect();
        if worst.is_empty() {
            return None;
        }
        let listed: Vec<String> = worst
            .iter()
            .map(|(figure, error)| format!("{} up to {}", noun(figure), percent(*error)))
            .collect();
        let limit = self.required.limit;
        let conditions: Vec<String> =
            worst.iter().map(|(figure, _)| format!("estimate_{figure} > {limit}")).collect();
        let of = self.subject.of(self.large);
        let is = percent(limit);
        let (is, advice) = match self.required.figure {
            Some(_) => (format!("the {is} asked for"), "a smaller `until`"),
            None => (is, "a finer `mesh`"),
        };
        let words = format!(
            "estimated errors{of} are above {is}: {}; give {advice}, or an `accuracy` in place of \
             it",
            listed.join(", ")
        );
        Some(Warning { words, filter: conditions.join(" || "), steps: false })
    }
}

/// The results that a warning is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subject {
    /// The only result that there is.
    OneResult,
    /// The points of a study.
    Points,
}

impl Subject {
    /// Says how many of them are concerned, after a noun.
    fn of(self, count: usize) -> String {
        match (self, count) {
            (Subject::OneResult, _) => String::new(),
            (Subject::Points, 1) => " of 1 point".to_owned(),
            (Subject::Points, count) => format!(" of {count} points"),
        }
    }
}

/// The number of elements along a side below which there is no estimate.
const FEWEST: u64 = 4;

/// Returns the estimated errors of a result.
fn estimates(record: &Record) -> Option<FigureErrors> {
    Some(record.outcome()?.estimate?.figures)
}

fn error(errors: &FigureErrors, figure: &str) -> Option<f64> {
    errors.named().into_iter().find(|(name, _)| *name == figure).and_then(|(_, error)| error)
}

fn noun(figure: &str) -> String {
    figure.replace('_', " ")
}

/// Writes a relative error in percent, with two digits.
fn percent(error: f64) -> String {
    format!("{} %", digits(100.0 * error, 1))
}
