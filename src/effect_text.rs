//! Which effects are simulated, to be read.

use answers::effects::{Cost, Line, Overview, Solver};
use contact::model::Method;

use crate::words::{count, duration};

/// Groups that are printed; the others are in the JSON.
const PRINTED_GROUPS: usize = 5;

/// The overview to be read: what all jobs have in common, then each group's own.
pub(crate) fn overview_words(overview: &Overview) -> String {
    if overview.groups.is_empty() {
        return String::new();
    }
    if let [only] = &overview.groups[..] {
        let jobs =
            if only.jobs == 1 { String::new() } else { format!(" of all {} jobs", only.jobs) };
        return format!("effects{jobs}\n{}", words(Some(only.solver), &only.effects, only.cost));
    }
    let mut text = String::new();
    if overview.solver.is_some() || !overview.common.is_empty() {
        text += &format!(
            "effects of all {} jobs\n{}",
            overview.jobs,
            words(overview.solver, &overview.common, overview.cost)
        );
    }
    for group in overview.groups.iter().take(PRINTED_GROUPS) {
        let own: Vec<Line> = group
            .effects
            .iter()
            .filter(|line| !overview.common.iter().any(|common| common.effect == line.effect))
            .cloned()
            .collect();
        text += &format!(
            "effects of {}{}\n{}",
            count(group.jobs, "job", "jobs"),
            if group.which.is_empty() { String::new() } else { format!(": {}", group.which) },
            words(overview.solver.xor(Some(group.solver)), &own, group.cost)
        );
    }
    if let Some(rest) = overview.groups.len().checked_sub(PRINTED_GROUPS).filter(|rest| *rest > 0) {
        text += &format!(
            "{} more: --json lists them\n",
            count(rest, "group of jobs", "groups of jobs")
        );
    }
    text
}

/// Effects as lines of text, after the method; `cost` is what solving takes as it is.
pub(crate) fn words(solver: Option<Solver>, lines: &[Line], cost: Cost) -> String {
    let solver = solver.map(|Solver { method, reason }| match method {
        Method::Seidel => format!("  {:<15} seidel, {reason}; it leaves out nothing\n", "method"),
        Method::Newton | Method::Auto => format!("  {:<15} newton, {reason}\n", "method"),
    });
    let line = |line: &Line| {
        let mut text = format!(
            "  {:<15} {:<4} {}",
            line.effect.name(),
            if line.simulated { "on" } else { "off" },
            line.reason
        );
        if line.reasons > 1 {
            text += &format!(" (and {})", count(line.reasons - 1, "other reason", "other reasons"));
        }
        let saved = |with: f64, without: f64| {
            (with > without && with > 0.0)
                .then(|| format!("{:.0} %", 100.0 * (1.0 - without / with)))
        };
        if let Some(with) = line.with {
            let unknowns = saved(with.unknowns as f64, cost.unknowns as f64)
                .map(|part| format!("{part} of the unknowns"));
            let spared = with.seconds - cost.seconds;
            let spared =
                if spared < 1e-3 { String::new() } else { format!(" ({})", duration(spared)) };
            let seconds =
                saved(with.seconds, cost.seconds).map(|part| format!("{part} of the time{spared}"));
            let parts: Vec<String> = unknowns.into_iter().chain(seconds).collect();
            if !parts.is_empty() {
                text += &format!("; saves {}", parts.join(", "));
            }
        }
        text + "\n"
    };
    solver.into_iter().chain(lines.iter().map(line)).collect()
}
