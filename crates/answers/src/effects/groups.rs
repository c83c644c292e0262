//! Groups of jobs that call for the same effects.

use std::collections::{HashMap, HashSet};
use std::ops::Add;

use contact::model::Effect;
use identity::JobKey;
use rayon::prelude::*;
use serde::Serialize;
use study::axis::{Group, SweepAxis};
use study::{Study, StudyPoint, Value};

use super::job::{EffectLine, JobEffects, Prediction, SolverChoice, effects_of_job};
use crate::error::AnswerError;
use crate::place::ValueKey;

/// The jobs of a study for which the same effects are simulated, by the same method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectGroup {
    /// The index of the first point.
    #[serde(skip)]
    pub first: usize,
    /// The values of the axes that the jobs have, in words; empty for the only group.
    #[serde(rename = "which")]
    pub label: String,
    /// The number of jobs.
    pub jobs: usize,
    /// The method that solves them; `None` where no scene is solved.
    pub solver: Option<SolverChoice>,
    /// The prediction for all jobs of the group.
    pub cost: Prediction,
    /// Every effect.
    pub effects: Vec<EffectLine>,
}

/// The effects of a study's jobs.
#[derive(Clone, Debug, PartialEq)]
pub struct Overview {
    /// The effects that are the same in all groups, if there are several.
    pub common: Vec<EffectLine>,
    /// The method, if all jobs are solved by the same.
    pub solver: Option<SolverChoice>,
    /// The prediction for all jobs.
    pub cost: Prediction,
    /// The number of jobs.
    pub jobs: usize,
    /// The groups, in the order of their first points.
    pub groups: Vec<EffectGroup>,
}

/// Groups a study's jobs, which are all of one kind; searches for solutions have no effects to
/// leave out.
/// `first` holds the indices of the points with which each job first occurs.
///
/// # Errors
/// A scene has no meaning, or its surfaces are missing.
pub fn overview(
    study: &Study,
    points: &[StudyPoint],
    first: &[usize],
) -> Result<Overview, AnswerError> {
    let listed: Vec<JobEffects> = first
        .par_iter()
        .filter_map(|index| effects_of_job(&points[*index].job, study.surfaces()))
        .collect::<Result<_, AnswerError>>()?;
    let groups_of_jobs = alike(&listed);
    let members = members(points, first, &groups_of_jobs);
    let groups: Vec<EffectGroup> = groups_of_jobs
        .iter()
        .zip(&members)
        .filter_map(|(jobs, members)| {
            let jobs: Vec<&JobEffects> = jobs.iter().map(|job| &listed[*job]).collect();
            let is_only = groups_of_jobs.len() == 1;
            Some(EffectGroup {
                solver: jobs.first()?.solver,
                first: members.first().copied().unwrap_or(0),
                label: if is_only { String::new() } else { label(study, points, members) },
                jobs: jobs.len(),
                cost: total(jobs.iter().map(|job| job.cost)),
                effects: merged(&jobs),
            })
        })
        .collect();
    let solvers: HashSet<Option<SolverChoice>> = listed.iter().map(|job| job.solver).collect();
    Ok(Overview {
        common: common(&listed, &groups),
        solver: solvers.iter().next().copied().filter(|_| solvers.len() == 1).flatten(),
        cost: total(listed.iter().map(|job| job.cost)),
        jobs: listed.len(),
        groups,
    })
}

/// Groups the indices of jobs for which the same effects are simulated by the same method.
fn alike(listed: &[JobEffects]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut known: HashMap<(Option<SolverChoice>, Vec<bool>), usize> = HashMap::new();
    for (index, job) in listed.iter().enumerate() {
        let simulated: Vec<bool> = job.lines.iter().map(|line| line.simulated).collect();
        let group = *known.entry((job.solver, simulated)).or_insert(groups.len());
        match groups.get_mut(group) {
            Some(jobs) => jobs.push(index),
            None => groups.push(vec![index]),
        }
    }
    groups
}

/// Returns the indices of the points in each group; points whose jobs coincide are in the same.
fn members(
    points: &[StudyPoint],
    first: &[usize],
    groups_of_jobs: &[Vec<usize>],
) -> Vec<Vec<usize>> {
    let mut group_of: HashMap<JobKey, usize> = HashMap::new();
    for (group, jobs) in groups_of_jobs.iter().enumerate() {
        group_of.extend(jobs.iter().map(|job| (points[first[*job]].key, group)));
    }
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); groups_of_jobs.len()];
    for (index, point) in points.iter().enumerate() {
        if let Some(group) = group_of.get(&point.key) {
            members[*group].push(index);
        }
    }
    members
}

/// Returns the effects that are the same in all groups, if there are several.
fn common(listed: &[JobEffects], groups: &[EffectGroup]) -> Vec<EffectLine> {
    if groups.len() <= 1 {
        return Vec::new();
    }
    let is_common = |line: &EffectLine| {
        let of_groups = groups.iter().filter_map(|group| line_of(&group.effects, line.effect));
        of_groups.into_iter().all(|other| {
            other.simulated == line.simulated
                && other.reasons == line.reasons
                && other.reason == line.reason
        })
    };
    merged(&listed.iter().collect::<Vec<_>>()).into_iter().filter(is_common).collect()
}

fn line_of(lines: &[EffectLine], effect: Effect) -> Option<&EffectLine> {
    lines.iter().find(|line| line.effect == effect)
}

fn total(costs: impl Iterator<Item = Prediction>) -> Prediction {
    costs.fold(Prediction::default(), Add::add)
}

/// Returns the effects of several jobs as one list.
fn merged(jobs: &[&JobEffects]) -> Vec<EffectLine> {
    let Some((first, rest)) = jobs.split_first() else { return Vec::new() };
    let mut lines = first.lines.clone();
    for (index, line) in lines.iter_mut().enumerate() {
        let mut reasons = HashSet::from([&first.lines[index].reason]);
        for other in rest.iter().filter_map(|job| job.lines.get(index)) {
            line.with = line.with.zip(other.with).map(|(sum, with)| sum + with);
            reasons.insert(&other.reason);
        }
        line.reasons = reasons.len();
    }
    lines
}

/// The most values of an axis that are named one by one; more are a range or a number.
const NAMED_VALUES: usize = 4;

/// Returns what tells some points from the study's others: the values of the axes, if every
/// combination of them is there and no other; else the first point. Points that the study chose
/// have values besides those of the axes.
fn label(study: &Study, points: &[StudyPoint], members: &[usize]) -> String {
    let taken = taken_values(study, points, members);
    let is_product =
        taken.iter().map(|(_, values)| values.len()).product::<usize>() == members.len();
    let mut said = Vec::new();
    for (group, values) in &taken {
        if group.design().is_some() {
            let (some, all) = (values.len(), group.len());
            said.extend((some < all).then(|| format!("{some} of {all} points of the sample")));
            continue;
        }
        // A group that does not vary tells nothing.
        let [axis, others @ ..] = group.telling() else { continue };
        if group.len() == 1 && values.len() == 1 {
            continue;
        }
        if !others.is_empty() {
            // Only their values together tell which steps these are.
            let names: Vec<_> = group.telling().iter().map(SweepAxis::column).collect();
            said.push(format!("{} steps of {}", values.len(), names.join(" with ")));
            continue;
        }
        if is_product {
            said.extend(axis_label(axis, values));
        } else {
            said.push(format!("{} = {}", axis.column(), values[0]));
        }
    }
    format!("{}{}", if is_product || said.is_empty() { "" } else { "such as " }, said.join("; "))
}

/// Returns the values that the first [telling](Group::telling) axis of each group takes at some
/// points, each once with those of the axes that go together with it.
fn taken_values<'s>(
    study: &'s Study,
    points: &'s [StudyPoint],
    members: &[usize],
) -> Vec<(&'s Group, Vec<&'s Value>)> {
    let mut taken = Vec::new();
    let mut first_axis = 0;
    for group in study.groups() {
        let axes = first_axis..first_axis + group.axes().len();
        let mut known = HashSet::new();
        let column = group.telling().first().map(SweepAxis::column);
        let telling =
            group.axes().iter().position(|axis| Some(axis.column()) == column).unwrap_or(0);
        let values = members.iter().filter_map(|member| {
            let values = &points[*member].values[axes.clone()];
            let is_new = known.insert(values.iter().map(ValueKey::from).collect::<Vec<_>>());
            values.get(telling).filter(|_| is_new)
        });
        taken.push((group, values.collect()));
        first_axis = axes.end;
    }
    taken
}

/// Names the values that an axis takes; `None` if it takes all of them.
fn axis_label(axis: &SweepAxis, values: &[&Value]) -> Option<String> {
    let all: Vec<&Value> = axis.values().collect();
    let column = axis.column();
    match values {
        _ if values == all => None,
        [first, .., last]
            if values.len() > NAMED_VALUES
                && all.windows(values.len()).any(|range| range == values) =>
        {
            Some(format!("{column} = {first} … {last}"))
        }
        _ if values.len() > NAMED_VALUES => Some(format!("{} values of {column}", values.len())),
        _ => {
            let named: Vec<String> = values.iter().map(ToString::to_string).collect();
            Some(format!("{column} = {}", named.join(", ")))
        }
    }
}
