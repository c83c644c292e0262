//! Studies of sensitivity, which solve the points of a design and tell how much each key that the
//! sample draws moves a result.
//!
//! ```toml
//! kind = "sensitivity"
//!
//! [sensitivity]               # may be left out
//! method = "sobol"            # shares of the variance; or "morris": elementary effects
//! of = ["peak_pressure"]      # the results; if left out, some that the scenes leave free
//! estimator = "jansen"        # of method "sobol": both indices by squared differences, or by
//!                             # products ("saltelli"); if left out, the first by products and the
//!                             # total by squared differences
//! levels = 4                  # of method "morris": values of each key, an even number
//!
//! [sample]                    # see `sample`
//! method = "sobol"            # "random" for method "morris", whose trajectories are
//! count = 64                  # rows of k + 2 points for k keys, or trajectories of k + 1 points
//! ```
//!
//! The points of a row are compared with each other. A larger `count` keeps them, as far as the
//! method of the sample does.

use super::freedom::ScenesFreedom;
use super::solve;
use super::spec::{KindSpec, KindTable, TableSpec};
use crate::axis::Group;
use crate::bounds::{ANY, within};
use crate::design::arrangement::Arrangement;
use crate::design::{Design, SamplingMethod};
use crate::distribution::Distribution;
use crate::error::{Mistake, Span};
use crate::fallback::Fallback::{self, Follows};
use crate::figure::{Figure, FigureKind};
use crate::job::Job;
use crate::table_key::{KeyTable, TableValue, table_key};

/// The description of the kind.
pub(crate) const SPEC: KindSpec = KindSpec {
    name: "sensitivity",
    table: Some(TableSpec {
        table: KeyTable {
            path: "sensitivity",
            is_list: false,
            meaning: "the question of a study of kind \"sensitivity\", which needs `[sample]`",
            keys: &[
                table_key(
                    "method",
                    TableValue::Word(&METHODS),
                    ANY,
                    Fallback::Word(METHODS[0]),
                    "\"morris\"",
                    "shares of the variance, or elementary effects",
                ),
                table_key(
                    "of",
                    TableValue::Columns,
                    ANY,
                    Follows("some that the scenes leave free"),
                    "[\"peak_pressure\"]",
                    "results whose dependence is asked for",
                ),
                table_key(
                    "estimator",
                    TableValue::Word(&ESTIMATORS),
                    ANY,
                    Follows("the first order by products, the total by squared differences"),
                    "\"jansen\"",
                    "of method \"sobol\": products, or squared differences",
                ),
                table_key(
                    "levels",
                    TableValue::Count,
                    within(2.0, MOST_LEVELS as f64),
                    Fallback::Count(LEVELS),
                    "8",
                    "of method \"morris\": values of each key, an even number",
                ),
            ],
        },
        check,
        advice: "or say kind = \"sensitivity\" at the top",
    }),
    has_accuracy: false,
    arrange: Some(arrange),
    suggestions,
    ..solve::SPEC
};

/// A way to tell how much each key moves a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensitivityMethod {
    /// Shares of the variance.
    Sobol(SobolEstimators),
    /// Elementary effects.
    Morris,
}

/// The estimators of the shares of the variance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SobolEstimators {
    /// Products for the first order and squared differences for the total, as SALib has them.
    #[default]
    Usual,
    /// Products for both, as Saltelli et al. list them.
    Saltelli,
    /// Squared differences for both, as Jansen proposed.
    Jansen,
}

const METHODS: [&str; 2] = ["sobol", "morris"];
const ESTIMATORS: [&str; 2] = ["saltelli", "jansen"];
const LEVELS: u32 = 4;
const MOST_LEVELS: u32 = 10_000;

/// The number of results that a study has which names none.
const USUAL_RESULTS: usize = 3;

impl SensitivityMethod {
    /// Returns the method that `[sensitivity]` chooses.
    pub(crate) fn of(table: &KindTable) -> SensitivityMethod {
        if is_morris(table) {
            return SensitivityMethod::Morris;
        }
        SensitivityMethod::Sobol(match table.word("estimator") {
            Some("saltelli") => SobolEstimators::Saltelli,
            Some("jansen") => SobolEstimators::Jansen,
            _ => SobolEstimators::Usual,
        })
    }
}

/// Returns the columns of the results that `[sensitivity]` names.
pub(crate) fn named_results(table: &KindTable) -> &[String] {
    table.columns("of")
}

fn is_morris(table: &KindTable) -> bool {
    table.word("method") == Some("morris")
}

fn arrange(table: &KindTable) -> Arrangement {
    match is_morris(table) {
        true => Arrangement::Trajectories { levels: table.count("levels").unwrap_or(LEVELS) },
        false => Arrangement::Saltelli,
    }
}

/// Refuses a study without a sample, and one whose sample does not suit the method.
fn check(table: &KindTable, span: &Span, groups: &[Group], mistakes: &mut Vec<Mistake>) {
    let mut refuse = |span: Span, message: String, expected: &str, help: &str| {
        mistakes.push(Mistake::new(span, message, expected).help(help));
    };
    let (other, why) = match is_morris(table) {
        true => ("estimator", "effects are means, and nothing is estimated by products"),
        false => ("levels", "points of method \"sobol\" lie on no grid"),
    };
    if table.has(other) {
        let message = format!("`sensitivity.{other}` has no meaning here: {why}");
        refuse(span.clone(), message, "leave it out", "");
    }
    if let Some(odd) = table.count("levels").filter(|levels| levels % 2 == 1) {
        let message = format!("`sensitivity.levels` cannot be {odd}");
        let help = "with an even number, steps up and down reach every level equally often";
        refuse(span.clone(), message, "must be even, like 4 or 8", help);
    }
    let sample = groups.iter().find_map(|group| Some((group, group.design()?)));
    let Some((group, design)) = sample else {
        let message = "a study of sensitivity draws its points, and has no sample".to_owned();
        let expected = "needs [sample], with the keys whose influence is asked for";
        return refuse(span.clone(), message, expected, "");
    };
    let most = Design::most_dimensions(arrange(table));
    if let Some(axis) = group.axes().get(most) {
        let message = format!("the sample draws {} keys", group.axes().len());
        let expected = format!("must be at most {most}");
        let help = "each key takes two dimensions of the sequence";
        refuse(axis.span.clone(), message, &expected, help);
    }
    if !is_morris(table) {
        return;
    }
    if design.method() != SamplingMethod::Random {
        let message = format!(
            "the trajectories of Morris are random, and the sample is {}",
            of(design.method())
        );
        refuse(span.clone(), message, "needs method = \"random\" in [sample]", "");
    }
    for axis in group.axes() {
        if axis.distribution().is_some_and(|distribution| !is_bounded(distribution)) {
            let message = format!(
                "Morris steps from end to end, and the distribution of `{}` has none",
                axis.path()
            );
            refuse(axis.span.clone(), message, "needs `from` and `to`", "");
        }
    }
}

/// Names a sample by its method.
fn of(method: SamplingMethod) -> String {
    format!("of method \"{}\"", method.name())
}

fn is_bounded(distribution: &Distribution) -> bool {
    match distribution {
        Distribution::Normal(normal) | Distribution::LogNormal { logarithm: normal, .. } => {
            normal.from.is_finite() && normal.to.is_finite()
        }
        _ => true,
    }
}

/// Makes the figure of the influence of each key on the results.
fn suggestions(table: &KindTable, _: &[Group], jobs: &[Job]) -> Vec<Figure> {
    let results = match named_results(table) {
        [] => {
            let mut free = ScenesFreedom::of(jobs).quantities("");
            free.truncate(USUAL_RESULTS);
            free
        }
        named => named.to_vec(),
    };
    vec![Figure { kind: FigureKind::Sensitivity, ..Figure::new(String::new(), results) }]
}
