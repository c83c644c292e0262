//! Which effects scenes call for, in groups of jobs that call for the same ones, and what leaving
//! the others out saves.

use std::collections::{HashMap, HashSet};
use std::ops::Add;

use anyhow::Result;
use contact::model::{ChosenMethod, Effect, Method, Numerics, Shape};
use contact::problem::Effects;
use contact::punch::Surfaces;
use contact::{Forecast, forecast};
use rayon::prelude::*;
use serde::Serialize;
use study::axis::Group as Axes;
use study::{Case, Job, JobKey, Point, Study, Value};

use crate::output::count;
use crate::progress::duration;

/// What solving takes, predicted; of several jobs, the sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Cost {
    pub(crate) unknowns: usize,
    pub(crate) seconds: f64,
}

impl From<Forecast> for Cost {
    fn from(forecast: Forecast) -> Self {
        Self { unknowns: forecast.unknowns, seconds: forecast.seconds }
    }
}

impl Add for Cost {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { unknowns: self.unknowns + other.unknowns, seconds: self.seconds + other.seconds }
    }
}

/// An effect of one or several jobs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Line {
    pub(crate) effect: Effect,
    pub(crate) simulated: bool,
    /// The reason, that of the first job if they differ.
    pub(crate) reason: String,
    /// How many reasons there are.
    pub(crate) reasons: usize,
    /// What solving would take with it, for an effect that is left out and could be asked for.
    pub(crate) with: Option<Cost>,
}

/// The method that solves, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub(crate) struct Solver {
    method: Method,
    reason: &'static str,
}

/// The effects of one job.
pub(crate) struct Listed {
    pub(crate) solver: Solver,
    pub(crate) cost: Cost,
    pub(crate) lines: Vec<Line>,
}

/// Lists the effects of a case.
pub(crate) fn effects(job: &Case, surfaces: &Surfaces) -> Result<Listed> {
    let with = |simulate: Vec<Effect>| {
        forecast(&job.scene, &Numerics { simulate, ..job.numerics.clone() }, surfaces)
    };
    let decided = with(job.numerics.simulate.clone())?;
    let decisions = Effects::of(&job.scene, &job.numerics, decided.elements, surfaces)?;
    let ChosenMethod { method, reason } =
        job.numerics.method.chosen(&job.scene.loading, decided.elements);
    let mut lines = Vec::new();
    for decision in decisions.decisions() {
        let asked = [&job.numerics.simulate[..], &[decision.effect]].concat();
        let optional = !decision.on && Effect::OPTIONAL.contains(&decision.effect);
        lines.push(Line {
            effect: decision.effect,
            simulated: decision.on,
            reason: decision.reason.clone(),
            reasons: 1,
            with: if optional { Some(Cost::from(with(asked)?)) } else { None },
        });
    }
    Ok(Listed { solver: Solver { method, reason }, cost: decided.into(), lines })
}

/// What a scene needs that `surfaces` does not hold, in words.
pub(crate) fn missing_surface(job: &Job, surfaces: &Surfaces) -> Option<String> {
    match &job.case()?.scene.punch.shape {
        Shape::HeightMap { surface, .. } if surfaces.get(surface).is_none() => {
            Some(format!("the height map {surface}"))
        }
        Shape::WheelOnRail(wheel) => {
            let name = [&wheel.wheel, &wheel.rail]
                .into_iter()
                .find(|name| surfaces.profile(name).is_none())?;
            Some(format!("the profile {name}"))
        }
        _ => None,
    }
}

/// Jobs of a study of which the same effects are simulated, by the same method.
#[derive(Serialize)]
pub(crate) struct Group {
    /// Index of the first point.
    #[serde(skip)]
    pub(crate) first: usize,
    /// Which values of the axes they have, in words; of a study without axes, nothing.
    pub(crate) which: String,
    pub(crate) jobs: usize,
    pub(crate) solver: Solver,
    /// Predicted, of all its jobs.
    pub(crate) cost: Cost,
    pub(crate) effects: Vec<Line>,
}

/// The effects of a study's jobs.
pub(crate) struct Overview {
    /// What holds for all jobs alike.
    common: Vec<Line>,
    solver: Option<Solver>,
    cost: Cost,
    jobs: usize,
    pub(crate) groups: Vec<Group>,
}

/// Groups a study's jobs, of one kind all of them; those that solve no scene have no effects.
/// `first` are the indices of the points with which each of them first occurs.
pub(crate) fn overview(study: &Study, points: &[Point], first: &[usize]) -> Result<Overview> {
    let cases = first.par_iter().filter_map(|index| match &points[*index].job {
        Job::Solve(case) | Job::Cost { case, .. } => Some(effects(case, study.surfaces())),
        Job::Multiplicity { .. } | Job::Uniqueness { .. } => None,
    });
    let listed: Vec<Listed> = cases.collect::<Result<_>>()?;
    let mut order: Vec<Vec<usize>> = Vec::new();
    let mut known: HashMap<(Solver, Vec<bool>), usize> = HashMap::new();
    for (at, job) in listed.iter().enumerate() {
        let simulated: Vec<bool> = job.lines.iter().map(|line| line.simulated).collect();
        let group = *known.entry((job.solver, simulated)).or_insert(order.len());
        match order.get_mut(group) {
            Some(jobs) => jobs.push(at),
            None => order.push(vec![at]),
        }
    }
    // points whose jobs coincide are in the same group
    let mut group_of: HashMap<JobKey, usize> = HashMap::new();
    for (group, jobs) in order.iter().enumerate() {
        group_of.extend(jobs.iter().map(|at| (points[first[*at]].key, group)));
    }
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); order.len()];
    for (index, point) in points.iter().enumerate() {
        if let Some(group) = group_of.get(&point.key) {
            members[*group].push(index);
        }
    }
    let groups: Vec<Group> = order
        .iter()
        .zip(&members)
        .filter_map(|(jobs, members)| {
            let jobs: Vec<&Listed> = jobs.iter().map(|at| &listed[*at]).collect();
            Some(Group {
                solver: jobs.first()?.solver,
                first: members.first().copied().unwrap_or(0),
                which: if order.len() == 1 { String::new() } else { which(study, points, members) },
                jobs: jobs.len(),
                cost: total(jobs.iter().map(|job| job.cost)),
                effects: merged(&jobs),
            })
        })
        .collect();
    let all: Vec<&Listed> = listed.iter().collect();
    let is_common = |line: &Line| {
        let mut own = groups
            .iter()
            .filter_map(|group| group.effects.iter().find(|own| own.effect == line.effect));
        own.all(|own| {
            own.simulated == line.simulated
                && own.reasons == line.reasons
                && own.reason == line.reason
        })
    };
    let common =
        merged(&all).into_iter().filter(|line| groups.len() > 1 && is_common(line)).collect();
    let solvers: HashSet<Solver> = listed.iter().map(|job| job.solver).collect();
    let solver = solvers.iter().next().copied().filter(|_| solvers.len() == 1);
    Ok(Overview {
        common,
        solver,
        cost: total(listed.iter().map(|job| job.cost)),
        jobs: listed.len(),
        groups,
    })
}

fn total(costs: impl Iterator<Item = Cost>) -> Cost {
    costs.fold(Cost::default(), Add::add)
}

/// The effects of several jobs as one list.
fn merged(jobs: &[&Listed]) -> Vec<Line> {
    let Some((first, rest)) = jobs.split_first() else { return Vec::new() };
    let mut lines = first.lines.clone();
    for (at, line) in lines.iter_mut().enumerate() {
        let mut reasons = HashSet::from([&first.lines[at].reason]);
        for other in rest {
            let Some(own) = other.lines.get(at) else { continue };
            line.with = line.with.zip(own.with).map(|(sum, own)| sum + own);
            reasons.insert(&own.reason);
        }
        line.reasons = reasons.len();
    }
    lines
}

/// Values of an axis that are named one by one; more are a range or a number.
const NAMED_VALUES: usize = 4;

/// What tells these points from the study's others: the values of the axes, if every combination of
/// them is there and no other; else the first point. Points that the study chose have values
/// besides the axes' own.
fn which(study: &Study, points: &[Point], members: &[usize]) -> String {
    let mut taken: Vec<(&Axes, Vec<&Value>)> = Vec::new();
    let mut at = 0;
    for group in study.groups() {
        // a group's axes go together
        let own = |point: &Point| format!("{:?}", &point.values[at..at + group.axes().len()]);
        let mut known = HashSet::new();
        let values =
            members.iter().map(|member| &points[*member]).filter(|point| known.insert(own(point)));
        taken.push((group, values.map(|point| &point.values[at]).collect()));
        at += group.axes().len();
    }
    let is_product =
        taken.iter().map(|(_, values)| values.len()).product::<usize>() == members.len();
    let mut said = Vec::new();
    for (group, values) in &taken {
        let Some(axis) = group.axes().first().filter(|_| group.len() > 1 || values.len() > 1)
        else {
            continue;
        };
        if !is_product {
            said.push(format!("{} = {}", axis.column(), values[0]));
            continue;
        }
        let all: Vec<&Value> = axis.values().collect();
        match values.len() {
            n if n == all.len() && *values == all => {}
            n if n <= NAMED_VALUES => said.push(format!(
                "{} = {}",
                axis.column(),
                values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
            )),
            n if all.windows(n).any(|range| range == &values[..]) => {
                said.push(format!("{} = {} … {}", axis.column(), values[0], values[n - 1]));
            }
            n => said.push(format!("{n} values of {}", axis.column())),
        }
    }
    format!("{}{}", if is_product || said.is_empty() { "" } else { "such as " }, said.join("; "))
}

/// Groups that are printed; the others are in the JSON.
const PRINTED_GROUPS: usize = 5;

impl Overview {
    /// The overview to be read: what all jobs have in common, then each group's own.
    pub(crate) fn words(&self) -> String {
        if self.groups.is_empty() {
            return String::new();
        }
        if let [only] = &self.groups[..] {
            let jobs =
                if only.jobs == 1 { String::new() } else { format!(" of all {} jobs", only.jobs) };
            return format!(
                "effects{jobs}\n{}",
                words(Some(only.solver), &only.effects, only.cost)
            );
        }
        let mut text = String::new();
        if self.solver.is_some() || !self.common.is_empty() {
            text += &format!(
                "effects of all {} jobs\n{}",
                self.jobs,
                words(self.solver, &self.common, self.cost)
            );
        }
        for group in self.groups.iter().take(PRINTED_GROUPS) {
            let own: Vec<Line> = group
                .effects
                .iter()
                .filter(|line| !self.common.iter().any(|common| common.effect == line.effect))
                .cloned()
                .collect();
            text += &format!(
                "effects of {}{}\n{}",
                count(group.jobs, "job", "jobs"),
                if group.which.is_empty() { String::new() } else { format!(": {}", group.which) },
                words(self.solver.xor(Some(group.solver)), &own, group.cost)
            );
        }
        if let Some(rest) = self.groups.len().checked_sub(PRINTED_GROUPS).filter(|rest| *rest > 0) {
            text += &format!(
                "{} more: --json lists them\n",
                count(rest, "group of jobs", "groups of jobs")
            );
        }
        text
    }
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
