//! The cost of accuracy, in words.

use study::Value;
use study::key::Key;

use super::rung::CostRung;
use crate::evidence::Evidence;
use crate::rows::digits;

/// The relative errors whose price is told.
const TARGETS: [f64; 6] = [0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// A target and the cheapest rung that reaches it.
struct PricedTarget<'r, 'a> {
    target: f64,
    rung: &'r CostRung<'a>,
}

/// Says what digits cost: "1 % of the load costs 0.02 s (mesh 24, tolerance 1e-4); the next digit 9
/// times that."
pub(super) fn sentence(evidence: &Evidence<'_>, rungs: &[CostRung<'_>], on: &str) -> String {
    let priced = priced_targets(rungs);
    let quantity = on.replace('_', " ");
    let Some(first) = priced.first() else {
        return format!("no rung gives the {quantity} to {} %", TARGETS[0] * 100.0);
    };
    let mut said = Vec::new();
    let mut before = first.rung.seconds;
    for PricedTarget { target, rung } in &priced {
        let (price, settings) = (price(rung.seconds), settings(evidence, rung, |_| true));
        let percent = digits(target * 100.0, 3);
        said.push(match said.len() {
            0 => format!("{percent} % of the {quantity} costs {price} ({settings})"),
            _ => format!(
                "{percent} % costs {price}, {:.1} times that ({settings})",
                rung.seconds / before
            ),
        });
        before = rung.seconds;
    }
    said.join("; ")
}

/// Returns the cheapest rung of each target that some rung reaches; a rung that reaches several is
/// that of the smallest.
fn priced_targets<'r, 'a>(rungs: &'r [CostRung<'a>]) -> Vec<PricedTarget<'r, 'a>> {
    let mut priced: Vec<PricedTarget<'_, '_>> = Vec::new();
    for target in TARGETS {
        let reaching = rungs.iter().filter(|rung| rung.claim <= target);
        let Some(rung) = reaching.min_by(|a, b| a.seconds.total_cmp(&b.seconds)) else { break };
        // A rung that reaches the next target gives one more digit for nothing.
        priced.retain(|other| other.rung.point != rung.point);
        priced.push(PricedTarget { target, rung });
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
