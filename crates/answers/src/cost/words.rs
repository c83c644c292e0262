//! The cost of accuracy, in words.

use study::Value;
use study::key::Key;

use super::rung::CostRung;
use super::ties::{CheapestRung, cheapest_within, is_tied};
use crate::evidence::Evidence;
use crate::rows::digits;

/// The relative errors whose price is told.
const TARGETS: [f64; 6] = [0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// A target and the cheapest rung that reaches it.
struct PricedTarget<'r, 'a> {
    target: f64,
    cheapest: CheapestRung<'r, 'a>,
}

/// The most settings that are named one by one.
const MOST_NAMED: usize = 3;

/// Says what digits cost: "1 % of the load costs 0.02 s (mesh 24, tolerance 1e-4); the next digit 9
/// times that."
pub(super) fn sentence(evidence: &Evidence<'_>, rungs: &[CostRung<'_>], on: &str) -> String {
    let priced = priced_targets(rungs);
    let quantity = on.replace('_', " ");
    let Some(first) = priced.first() else {
        return format!("no rung gives the {quantity} to {} %", TARGETS[0] * 100.0);
    };
    let mut said = Vec::new();
    let mut before = first.cheapest.rung;
    for PricedTarget { target, cheapest: CheapestRung { rung, ties } } in &priced {
        let (price, mut settings) = (price(rung.seconds), settings(evidence, rung, |_| true));
        if !ties.is_empty() {
            settings += "; as cheap within the noise: ";
            settings += &several_settings(evidence, ties);
        }
        let percent = digits(target * 100.0, 3);
        said.push(if said.is_empty() {
            format!("{percent} % of the {quantity} costs {price} ({settings})")
        } else if is_tied(rung, before) {
            format!("{percent} % costs {price}, the same within the noise ({settings})")
        } else {
            let times = rung.seconds / before.seconds;
            format!("{percent} % costs {price}, {times:.1} times that ({settings})")
        });
        before = rung;
    }
    said.join("; ")
}

/// Returns the cheapest rung of each target that some rung reaches; a rung that reaches several is
/// that of the smallest.
fn priced_targets<'r, 'a>(rungs: &'r [CostRung<'a>]) -> Vec<PricedTarget<'r, 'a>> {
    let mut priced: Vec<PricedTarget<'_, '_>> = Vec::new();
    for target in TARGETS {
        let Some(cheapest) = cheapest_within(rungs, target) else { break };
        // A rung that reaches the next target gives one more digit for nothing.
        priced.retain(|other| other.cheapest.rung.point != cheapest.rung.point);
        priced.push(PricedTarget { target, cheapest });
    }
    priced
}

/// Names the settings of a rung that differ along the ladder, those of some keys.
pub(super) fn settings(
    evidence: &Evidence<'_>,
    rung: &CostRung<'_>,
    is_meant: fn(Key) -> bool,
) -> String {
    let is_shown = |key: Key| key.path().starts_with("numerics.") && is_meant(key);
    let values = evidence.study.axes().zip(&evidence.points[rung.point].values);
    let said: Vec<String> = values
        .filter(|(axis, _)| axis.key().is_some_and(is_shown))
        .map(|(axis, value)| format!("{} {}", axis.column(), shown(value)))
        .collect();
    said.join(", ")
}

/// Names the settings of several rungs, the first of them one by one.
pub(super) fn several_settings(evidence: &Evidence<'_>, rungs: &[&CostRung<'_>]) -> String {
    let named = rungs.iter().take(MOST_NAMED).map(|rung| settings(evidence, rung, |_| true));
    let mut said = named.collect::<Vec<_>>().join("; ");
    if let Some(more @ 1..) = rungs.len().checked_sub(MOST_NAMED) {
        said += &format!("; and {more} more");
    }
    said
}

fn shown(value: &Value) -> String {
    match value {
        Value::Number(x) if *x != 0.0 && x.abs() < 1e-3 => format!("{x:e}"),
        value => value.to_string(),
    }
}

/// Writes a time with two digits.
fn price(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 1e-3 => (s * 1e6, "µs"),
        s if s < 1.0 => (s * 1e3, "ms"),
        s => (s, "s"),
    };
    format!("{} {unit}", digits(value, 1))
}
