//! Doubts about results that are certified: counts of elements that should be 0, and errors of the
//! mesh that are not estimated or large.

use contact::model::{FigureErrors, Observables, StepOutcome};
use study::Record;

use crate::evidence::end_of;
use crate::rows::digits;

/// A doubt about some results.
#[derive(Clone, Debug, PartialEq, Eq)]
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
    let warning = |ElementCount { column, words, read }: &ElementCount| {
        let is_counted = |step: &StepOutcome| read(&step.observables) > 0;
        // The columns of a failed point are empty, so that no filter finds it.
        let is_shown = |record: &Record| subject == Subject::OneResult || record.is_certified();
        let concerned: Vec<&&Record> = records
            .iter()
            .filter(|record| is_shown(record) && steps_of(record).iter().any(is_counted))
            .collect();
        (!concerned.is_empty()).then(|| Warning {
            words: format!("elements{} {words}", subject.of(concerned.len())),
            filter: format!("{column} > 0"),
            steps: concerned.iter().any(|record| steps_of(record).len() > 1),
        })
    };
    COUNTS.iter().filter_map(warning).collect()
}

/// Warns of certified results whose stresses below the surface two ways do not agree on.
pub(crate) fn of_interiors(records: &[&Record], subject: Subject) -> Option<Warning> {
    let residual = |record: &&&Record| {
        let outcome = record.outcome().filter(|_| record.is_certified())?;
        let residual = outcome.further.interior.as_ref()?.residual?;
        // What is not a number is not small.
        (residual.is_nan() || residual > LARGE_RESIDUAL).then_some(residual)
    };
    let concerned: Vec<f64> = records.iter().filter_map(|record| residual(&record)).collect();
    let worst = concerned.iter().copied().reduce(f64::max)?;
    Some(Warning {
        words: format!(
            "stresses below the surface{} differ by up to {} between two ways to them: the \
             foundation or the places are beyond what doubles resolve",
            subject.of(concerned.len()),
            percent(worst)
        ),
        filter: format!("interior_residual > {LARGE_RESIDUAL:e}"),
        steps: false,
    })
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
    let is_meant = |record: &&&Record| {
        record.is_certified()
            && end_of(record).is_some_and(|end| end.observables.contact_area > 0.0)
    };
    let meant: Vec<&&Record> = records.iter().filter(is_meant).collect();
    let mut warnings = Vec::new();
    warnings.extend(missing(&meant, subject, required));
    warnings.extend(large(&meant, subject, required));
    warnings
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

fn missing(records: &[&&Record], subject: Subject, required: &RequiredError) -> Option<Warning> {
    let has_none = |record: &&&&Record| match (estimates(record), required.figure) {
        (None, _) => true,
        (Some(errors), Some(figure)) => error(&errors, figure).is_none(),
        (Some(_), None) => false,
    };
    let concerned: Vec<&&&Record> = records.iter().filter(has_none).collect();
    let first = concerned.first()?;
    let is_coarse = |record: &&&&Record| {
        let fewest = |end: &StepOutcome| end.observables.mesh_x.min(end.observables.mesh_y);
        end_of(record).is_some_and(|end| fewest(end) < FEWEST)
    };
    let why = if concerned.iter().all(is_coarse) {
        format!(": there are fewer than {FEWEST} elements along a side; give a finer `mesh`")
    } else if estimates(first).is_some() {
        "; its limit may not be a number".to_owned()
    } else {
        ": half as many elements along each side did not do".to_owned()
    };
    let what = required.figure.map_or(String::new(), |figure| format!(" in the {}", noun(figure)));
    let column = required.figure.unwrap_or("solver");
    Some(Warning {
        words: format!("no error{what}{} is estimated{why}", subject.of(concerned.len())),
        filter: format!("status == \"certified\" && estimate_{column} == null"),
        steps: false,
    })
}

/// The number of elements along a side below which there is no estimate.
const FEWEST: u64 = 4;

fn large(records: &[&&Record], subject: Subject, required: &RequiredError) -> Option<Warning> {
    let above = |record: &Record, figure: &str| {
        estimates(record).and_then(|errors| error(&errors, figure)).filter(|e| *e > required.limit)
    };
    let figures = required.figures();
    let concerned = records
        .iter()
        .filter(|record| figures.iter().any(|figure| above(record, figure).is_some()));
    let count = concerned.count();
    let worst = |figure: &&'static str| {
        let largest = records.iter().filter_map(|record| above(record, figure)).reduce(f64::max)?;
        Some((*figure, largest))
    };
    let worst: Vec<(&str, f64)> = figures.iter().filter_map(worst).collect();
    if worst.is_empty() {
        return None;
    }
    let listed: Vec<String> = worst
        .iter()
        .map(|(figure, error)| format!("{} up to {}", noun(figure), percent(*error)))
        .collect();
    let conditions: Vec<String> =
        worst.iter().map(|(figure, _)| format!("estimate_{figure} > {}", required.limit)).collect();
    let of = subject.of(count);
    let is = percent(required.limit);
    let (is, advice) = match required.figure {
        Some(_) => (format!("the {is} asked for"), "a smaller `until`"),
        None => (is, "a finer `mesh`"),
    };
    let words = format!(
        "estimated errors{of} are above {is}: {}; give {advice}, or an `accuracy` in place of it",
        listed.join(", ")
    );
    Some(Warning { words, filter: conditions.join(" || "), steps: false })
}

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
