//! The effects that are simulated and left out, to be read.

use answers::effects::{EffectGroup, EffectLine, JobMethod, Overview, Prediction, SolverChoice};

use report::{Cell, DataTable, TableColumn, TableError};

use crate::words::{count, duration};

/// The most groups that are printed; the JSON has all.
const PRINTED_GROUPS: usize = 5;

/// Returns the overview of a study to be read: what all jobs have in common, then what each group
/// has besides.
pub(crate) fn overview_words(overview: &Overview) -> String {
    if overview.groups.is_empty() {
        return String::new();
    }
    if let [only] = &overview.groups[..] {
        let jobs =
            if only.jobs == 1 { String::new() } else { format!(" of all {} jobs", only.jobs) };
        let lines = effect_lines(only.solver, &only.effects, only.cost);
        return format!("effects{jobs}\n{lines}");
    }
    let mut text = String::new();
    if overview.solver.is_some() || !overview.common.is_empty() {
        text += &format!(
            "effects of all {} jobs\n{}",
            overview.jobs,
            effect_lines(overview.solver, &overview.common, overview.cost)
        );
    }
    for group in overview.groups.iter().take(PRINTED_GROUPS) {
        text += &group_words(overview, group);
    }
    if let Some(rest) = overview.groups.len().checked_sub(PRINTED_GROUPS).filter(|rest| *rest > 0) {
        text += &format!(
            "{} more: --json lists them\n",
            count(rest, "group of jobs", "groups of jobs")
        );
    }
    text
}

/// Returns what a group has besides what all jobs have in common.
fn group_words(overview: &Overview, group: &EffectGroup) -> String {
    let is_common =
        |line: &&EffectLine| overview.common.iter().any(|common| common.effect == line.effect);
    let lines: Vec<EffectLine> =
        group.effects.iter().filter(|line| !is_common(line)).cloned().collect();
    format!(
        "effects of {}{}\n{}",
        count(group.jobs, "job", "jobs"),
        if group.label.is_empty() { String::new() } else { format!(": {}", group.label) },
        effect_lines(group.solver.filter(|_| overview.solver.is_none()), &lines, group.cost)
    )
}

/// Returns effects as lines of text, after the method; `cost` is the prediction with the effects as
/// they are.
pub(crate) fn effect_lines(
    solver: Option<SolverChoice>,
    lines: &[EffectLine],
    cost: Prediction,
) -> String {
    let solver = solver.map(|choice| {
        format!("  {:<15} {}, {}\n", "method", choice.method.name(), method_reason(choice))
    });
    solver.into_iter().chain(lines.iter().map(|line| effect_line(line, cost))).collect()
}

/// Returns the reason for a method, and what it does without.
fn method_reason(SolverChoice { method, reason }: SolverChoice) -> String {
    if method == JobMethod::Seidel {
        format!("{reason}; it leaves out nothing")
    } else {
        reason.to_owned()
    }
}

fn effect_line(line: &EffectLine, cost: Prediction) -> String {
    format!("  {:<15} {:<4} {}\n", line.effect.name(), on_or_off(line), why(line, cost))
}

fn on_or_off(line: &EffectLine) -> &'static str {
    if line.simulated { "on" } else { "off" }
}

/// Returns the reason for an effect, and what leaving it out saves.
fn why(line: &EffectLine, cost: Prediction) -> String {
    let mut text = line.reason.clone();
    if line.reasons > 1 {
        text += &format!(" (and {})", count(line.reasons - 1, "other reason", "other reasons"));
    }
    if let Some(with) = line.with {
        let savings = savings(cost, with);
        if !savings.is_empty() {
            text += &format!("; saves {}", savings.join(", "));
        }
    }
    text
}

/// Returns the effects of a group of jobs as a table, after the method.
pub(crate) fn effect_table(group: &EffectGroup) -> Result<DataTable, TableError> {
    let row = |texts: [&str; 3]| texts.map(Cell::from).to_vec();
    let solver =
        group.solver.map(|choice| row(["method", choice.method.name(), &method_reason(choice)]));
    let effects = group
        .effects
        .iter()
        .map(|line| row([line.effect.name(), on_or_off(line), &why(line, group.cost)]));
    let columns = ["effect", "simulated", "reason"].map(|name| TableColumn::new(name, ""));
    DataTable::new(columns.to_vec(), solver.into_iter().chain(effects).collect())
}

/// Returns what is saved by leaving an effect out, of the prediction `with` it.
fn savings(cost: Prediction, with: Prediction) -> Vec<String> {
    let saved = |with: f64, without: f64| {
        (with > without && with > 0.0).then(|| format!("{:.0} %", 100.0 * (1.0 - without / with)))
    };
    let unknowns = saved(with.unknowns as f64, cost.unknowns as f64)
        .map(|share| format!("{share} of the unknowns"));
    let spared = with.seconds - cost.seconds;
    let spared = if spared < 1e-3 { String::new() } else { format!(" ({})", duration(spared)) };
    let seconds =
        saved(with.seconds, cost.seconds).map(|share| format!("{share} of the time{spared}"));
    unknowns.into_iter().chain(seconds).collect()
}
