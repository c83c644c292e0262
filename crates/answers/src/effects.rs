//! Which effects scenes call for, in groups of jobs that call for the same ones, and what leaving
//! the others out saves.
use std::collections::{HashMap, HashSet};
use std::ops::Add;

use contact::model::{Effect, Method, Numerics, Shape};
use contact::problem::Effects;
use contact::punch::Surfaces;
use contact::{Forecast, forecast};
use identity::JobKey;
use rayon::prelude::*;
use serde::Serialize;
use study::axis::Group as Axes;
use study::{Case, Job, Study, StudyPoint, Value};

use crate::error::AnswerError;

/// What solving takes, predicted; of several jobs, the sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// The number of unknowns.
    pub unknowns: usize,
    /// The time \[s\].
    pub seconds: f64,
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
pub struct Line {
    /// The effect.
    pub effect: Effect,
    /// It is simulated, and not left out.
    pub simulated: bool,
    /// The reason, that of the first job if they differ.
    pub reason: String,
    /// How many reasons there are.
    pub reasons: usize,
    /// What solving would take with it, for an effect that is left out and could be asked for.
    pub with: Option<Cost>,
}

/// The method that solves, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Solver {
    /// The method.
    pub method: Method,
    /// The reason to choose it.
    pub reason: &'static str,
}

/// The effects of one job.
pub struct Listed {
    /// The method that solves it.
    pub solver: Solver,
    /// Predicted, with the effects as they are.
    pub cost: Cost,
    /// Every effect.
    pub lines: Vec<Line>,
}

/// Lists the effects of a case.
pub fn effects(job: &Case, surfaces: &Surfaces) -> Result<Listed, AnswerError> {
    let with = |simulate: Vec<Effect>| {
        forecast(&job.scene, &Numerics { simulate, ..job.numerics.clone() }, surfaces)
    };
    let decided = with(job.numerics.simulate.clone())?;
    let decisions = Effects::of(&job.scene, &job.numerics, decided.elements, surfaces)?;
    let (method, reason) = job.numerics.method.chosen(&job.scene.loading, decided.elements);
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
pub fn missing_surface(job: &Job, surfaces: &Surfaces) -> Option<String> {
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
pub struct Group {
    /// Index of the first point.
    #[serde(skip)]
    pub first: usize,
    /// Which values of the axes they have, in words; of a study without axes, nothing.
    pub which: String,
    /// The number of jobs.
    pub jobs: usize,
    /// The method that solves them.
    pub solver: Solver,
    /// Predicted, of all its jobs.
    pub cost: Cost,
    /// Every effect.
    pub effects: Vec<Line>,
}

/// The effects of a study's jobs.
pub struct Overview {
    /// What holds for all jobs alike.
    pub common: Vec<Line>,
    /// The method, if all jobs are solved by the same.
    pub solver: Option<Solver>,
    /// Predicted, of all jobs.
    pub cost: Cost,
    /// The number of jobs.
    pub jobs: usize,
    /// The groups, in the order of their first points.
    pub groups: Vec<Group>,
}

/// Groups a study's jobs, of one kind all of them; those that solve no scene have no effects.
/// `first` are the indices of the points with which each of them first occurs.
pub fn overview(
    study: &Study,
    points: &[StudyPoint],
    first: &[usize],
) -> Result<Overview, AnswerError> {
    let cases = first.par_iter().filter_map(|index| match &points[*index].job {
        Job::Solve(case) | Job::Cost { case, .. } => Some(effects(case, study.surfaces())),
        Job::Multiplicity { .. } | Job::Uniqueness { .. } => None,
    });
    let listed: Vec<Listed> = cases.collect::<Result<_, AnswerError>>()?;
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
fn which(study: &Study, points: &[StudyPoint], members: &[usize]) -> String {
    let mut taken: Vec<(&Axes, Vec<&Value>)> = Vec::new();
    let mut at = 0;
    for group in study.groups() {
        // a group's axes go together
        let own = |point: &StudyPoint| format!("{:?}", &point.values[at..at + group.axes().len()]);
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
