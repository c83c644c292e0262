//! Groups of jobs that call for the same effects.

use std::collections::{HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;

use contact::model::Effect;
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
///
/// # Errors
/// A scene has no meaning, or its surfaces are missing.
pub fn overview(study: &Study, points: &[StudyPoint]) -> Result<Overview, AnswerError> {
    let mut draft = OverviewDraft::of(study);
    draft.add(points)?;
    Ok(draft.overview())
}

/// The effects of a study's jobs whose points pass by a few at a time.
pub struct OverviewDraft<'s> {
    study: &'s Study,
    /// The number of points so far.
    points: usize,
    all: JobSums,
    solvers: HashSet<Option<SolverChoice>>,
    groups: Vec<GroupDraft<'s>>,
    /// The group of the jobs with a method and with these effects simulated.
    known: HashMap<(Option<SolverChoice>, Vec<bool>), u32>,
    /// The group of each job so far; `None` if the job has no effects to leave out.
    jobs: HashMap<ShortKey, Option<u32>>,
}

/// The first half of a job's key, in bytes, which leave no gaps in a map.
type ShortKey = [u8; 16];

fn short_key(point: &StudyPoint) -> ShortKey {
    point.key.half().to_ne_bytes()
}

/// A group of jobs so far.
struct GroupDraft<'s> {
    /// The index of the first point.
    first: usize,
    /// The number of points.
    points: usize,
    solver: Option<SolverChoice>,
    jobs: JobSums,
    /// The values that its points take, for each group of axes.
    taken: Vec<TakenValues<'s>>,
}

impl<'s> OverviewDraft<'s> {
    /// Returns that of no point.
    pub fn of(study: &'s Study) -> Self {
        Self {
            study,
            points: 0,
            all: JobSums::default(),
            solvers: HashSet::new(),
            groups: Vec::new(),
            known: HashMap::new(),
            jobs: HashMap::new(),
        }
    }

    /// Returns the positions of those points whose jobs neither a point before them nor one that
    /// was added has.
    pub fn first_of_jobs(&self, points: &[StudyPoint]) -> Vec<usize> {
        let mut seen = HashSet::new();
        let mut is_first = |position: &usize| {
            let key = short_key(&points[*position]);
            !self.jobs.contains_key(&key) && seen.insert(key)
        };
        (0..points.len()).filter(|position| is_first(position)).collect()
    }

    /// Adds the next points. The effects of a job are found where it first comes.
    ///
    /// # Errors
    /// A scene has no meaning, or its surfaces are missing.
    pub fn add(&mut self, points: &[StudyPoint]) -> Result<(), AnswerError> {
        let surfaces = self.study.surfaces();
        let first = self.first_of_jobs(points);
        let listed: Vec<Option<JobEffects>> = first
            .par_iter()
            .map(|position| effects_of_job(&points[*position].job, surfaces).transpose())
            .collect::<Result<_, AnswerError>>()?;
        let mut new = first.into_iter().zip(listed).peekable();
        for (position, point) in points.iter().enumerate() {
            if let Some((_, job)) = new.next_if(|(first, _)| *first == position) {
                let group = job.map(|job| self.add_job(&job));
                self.jobs.insert(short_key(point), group);
            }
            let group = self.jobs.get(&short_key(point)).copied().flatten();
            if let Some(group) = group.and_then(|group| self.groups.get_mut(group as usize)) {
                group.points += 1;
                group.taken.iter_mut().for_each(|taken| taken.add(point));
            }
            self.points += 1;
        }
        Ok(())
    }

    /// Adds a job that the next point is the first to have, and returns its group.
    fn add_job(&mut self, job: &JobEffects) -> u32 {
        let simulated: Vec<bool> = job.lines.iter().map(|line| line.simulated).collect();
        let next = self.groups.len() as u32;
        let group = *self.known.entry((job.solver, simulated)).or_insert(next);
        if group == next {
            self.groups.push(GroupDraft {
                first: self.points,
                points: 0,
                solver: job.solver,
                jobs: JobSums::default(),
                taken: TakenValues::of(self.study),
            });
        }
        self.groups[group as usize].jobs.add(job);
        self.all.add(job);
        self.solvers.insert(job.solver);
        group
    }

    /// Returns the effects of all points that were added.
    pub fn overview(self) -> Overview {
        let is_only = self.groups.len() == 1;
        let group = |group: GroupDraft<'_>| EffectGroup {
            label: if is_only { String::new() } else { group.label() },
            first: group.first,
            solver: group.solver,
            jobs: group.jobs.count,
            cost: group.jobs.cost,
            effects: group.jobs.lines(),
        };
        let groups: Vec<EffectGroup> = self.groups.into_iter().map(group).collect();
        let only = self.solvers.iter().next().copied().filter(|_| self.solvers.len() == 1);
        Overview {
            common: common(self.all.lines(), &groups),
            solver: only.flatten(),
            cost: self.all.cost,
            jobs: self.all.count,
            groups,
        }
    }
}

/// Returns those of the effects of all jobs that are the same in all groups, if there are several.
fn common(all: Vec<EffectLine>, groups: &[EffectGroup]) -> Vec<EffectLine> {
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
    all.into_iter().filter(is_common).collect()
}

fn line_of(lines: &[EffectLine], effect: Effect) -> Option<&EffectLine> {
    lines.iter().find(|line| line.effect == effect)
}

/// The sums over several jobs, which are added one by one.
#[derive(Default)]
struct JobSums {
    count: usize,
    cost: Prediction,
    /// The effects of the first job, with the predictions of all.
    lines: Vec<EffectLine>,
    /// The digests of the reasons for each effect.
    reasons: Vec<HashSet<u128>>,
}

impl JobSums {
    fn add(&mut self, job: &JobEffects) {
        self.cost = self.cost + job.cost;
        self.count += 1;
        if self.count == 1 {
            self.lines.clone_from(&job.lines);
            self.reasons =
                job.lines.iter().map(|line| HashSet::from([digest(&line.reason)])).collect();
            return;
        }
        for ((line, reasons), other) in self.lines.iter_mut().zip(&mut self.reasons).zip(&job.lines)
        {
            line.with = line.with.zip(other.with).map(|(sum, with)| sum + with);
            if other.reason != line.reason {
                reasons.insert(digest(&other.reason));
            }
        }
    }

    /// Returns the effects of the jobs as one list.
    fn lines(&self) -> Vec<EffectLine> {
        let mut lines = self.lines.clone();
        for (line, reasons) in lines.iter_mut().zip(&self.reasons) {
            line.reasons = reasons.len();
        }
        lines
    }
}

/// Returns a digest by which very many values are told apart in little memory.
fn digest(value: &impl Hash) -> u128 {
    let half = |salt: u8| {
        let mut hasher = DefaultHasher::new();
        (salt, value).hash(&mut hasher);
        u128::from(hasher.finish())
    };
    half(0) << 64 | half(1)
}

/// The most values of an axis that are named one by one; more are a range or a number.
const NAMED_VALUES: usize = 4;

impl GroupDraft<'_> {
    /// Returns what tells the points from the study's others: the values of the axes, if every
    /// combination of them is there and no other; else the first point. Points that the study chose
    /// have values besides those of the axes.
    fn label(&self) -> String {
        let is_product =
            self.taken.iter().map(|taken| taken.known.len()).product::<usize>() == self.points;
        let mut said = Vec::new();
        for TakenValues { group, known, values, .. } in &self.taken {
            if group.design().is_some() {
                let (some, all) = (known.len(), group.len());
                said.extend((some < all).then(|| format!("{some} of {all} points of the sample")));
                continue;
            }
            // A group that does not vary tells nothing.
            let [axis, others @ ..] = group.telling() else { continue };
            if group.len() == 1 && known.len() == 1 {
                continue;
            }
            if !others.is_empty() {
                // Only their values together tell which steps these are.
                let names: Vec<_> = group.telling().iter().map(SweepAxis::column).collect();
                said.push(format!("{} steps of {}", known.len(), names.join(" with ")));
                continue;
            }
            if is_product {
                said.extend(axis_label(axis, values));
            } else {
                said.extend(values.first().map(|first| format!("{} = {first}", axis.column())));
            }
        }
        format!(
            "{}{}",
            if is_product || said.is_empty() { "" } else { "such as " },
            said.join("; ")
        )
    }
}

/// The values that the first [telling](Group::telling) axis of a group of axes takes at some
/// points, each once with those of the axes that go together with it.
struct TakenValues<'s> {
    group: &'s Group,
    /// The axes of the group among those of the study.
    axes: Range<usize>,
    /// The telling axis among them.
    telling: usize,
    /// The digests of the values of all axes of the group.
    known: HashSet<u128>,
    /// The values of the telling axis; none of a sample, whose points are only counted.
    values: Vec<Value>,
}

impl<'s> TakenValues<'s> {
    /// Returns those of no point, for each group of axes of a study.
    fn of(study: &'s Study) -> Vec<Self> {
        let mut first_axis = 0;
        let of_group = |group: &'s Group| {
            let axes = first_axis..first_axis + group.axes().len();
            first_axis = axes.end;
            let column = group.telling().first().map(SweepAxis::column);
            let telling =
                group.axes().iter().position(|axis| Some(axis.column()) == column).unwrap_or(0);
            TakenValues { group, axes, telling, known: HashSet::new(), values: Vec::new() }
        };
        study.groups().iter().map(of_group).collect()
    }

    fn add(&mut self, point: &StudyPoint) {
        let values = &point.values[self.axes.clone()];
        let key: Vec<ValueKey<'_>> = values.iter().map(ValueKey::from).collect();
        if self.known.insert(digest(&key)) && self.group.design().is_none() {
            self.values.extend(values.get(self.telling).cloned());
        }
    }
}

/// Names the values that an axis takes; `None` if it takes all of them.
fn axis_label(axis: &SweepAxis, values: &[Value]) -> Option<String> {
    let all: Vec<&Value> = axis.values().collect();
    let values: Vec<&Value> = values.iter().collect();
    let values = &values[..];
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
