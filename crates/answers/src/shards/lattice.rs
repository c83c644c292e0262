//! The sequences of a study that has too many points to list them.
//!
//! Most axes do not change what a job takes. Those that do are found by forecasts along each axis,
//! with the others at three places; their steps fall into classes of equal forecasts. A combination
//! of classes is a piece of the row, of which one forecast is made and the sequences are counted.
//! The steps of the axes with most classes fall into classes of similar cost, whatever their
//! operators, where there are too many combinations. The points of a large sample are one class, of
//! which some points tell the mean cost: any run of them takes about as long as any other.

use std::collections::HashMap;

use rayon::prelude::*;
use study::Study;

use super::listed::{Stride, nanoseconds, strides};
use super::row::Piece;
use crate::error::AnswerError;
use crate::kind::forecast;

/// The largest number of pieces.
const MOST_PIECES: usize = 100_000;

/// The ratio of costs that count as similar.
const SIMILAR: f64 = 1.2;

/// The largest number of points of a sample that are weighed.
const MOST_WEIGHED: usize = 10_000;

/// A group of axes, its steps in classes.
struct ClassedGroup {
    stride: Stride,
    classes: Vec<StepClass>,
    /// The costs of the steps of each class, with the other groups at three places.
    costs: Vec<[u128; 3]>,
    /// The number of times that classes were merged since there were too many.
    blurs: usize,
}

/// Steps of a group that stand for each other.
enum StepClass {
    /// Steps in order, of which the middle one stands for the others.
    Listed(Vec<usize>),
    /// All the steps of a sample.
    Sample(WeighedSample),
}

/// A sample of which some points were weighed.
struct WeighedSample {
    length: usize,
    /// The step whose cost comes closest to the mean.
    usual: usize,
    /// The cost of that step.
    usual_cost: u128,
    /// The mean cost.
    mean_cost: u128,
}

impl StepClass {
    fn len(&self) -> usize {
        match self {
            StepClass::Listed(steps) => steps.len(),
            StepClass::Sample(sample) => sample.length,
        }
    }

    /// Returns one of its steps, counted from 0.
    fn step(&self, number: usize) -> usize {
        match self {
            StepClass::Listed(steps) => steps[number],
            StepClass::Sample(_) => number,
        }
    }

    /// Returns the step that stands for all of them.
    fn usual(&self) -> usize {
        match self {
            StepClass::Listed(steps) => steps[steps.len() / 2],
            StepClass::Sample(sample) => sample.usual,
        }
    }

    /// Returns the mean cost of its steps where the usual one has a cost.
    fn mean(&self, cost: u128) -> u128 {
        match self {
            StepClass::Listed(_) => cost,
            StepClass::Sample(sample) => {
                (cost * sample.mean_cost / sample.usual_cost.max(1)).max(1)
            }
        }
    }
}

/// The sequences of a study by the classes of their steps.
pub(super) struct Lattice {
    /// The groups that tell sequences apart, first those whose classes were merged, so that what
    /// they change changes as rarely as it can.
    groups: Vec<ClassedGroup>,
    /// The groups along the sequences.
    along: Vec<Stride>,
    /// The class of each group in each piece.
    pieces: Vec<Vec<u32>>,
}

/// The part of a forecast that a partition needs.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Weight {
    cost: u128,
    operator: u64,
}

impl Lattice {
    /// Finds the classes of a study, and the row of its pieces.
    pub(super) fn of(study: &Study) -> Result<(Lattice, Vec<Piece>), AnswerError> {
        let strides = strides(study);
        let is_along = |group: &usize| study.is_sequence(*group);
        let along: Vec<Stride> =
            (0..strides.len()).filter(is_along).map(|group| strides[group]).collect();
        let mut groups = (0..strides.len())
            .filter(|group| !is_along(group))
            .map(|group| classed(study, &strides, group))
            .collect::<Result<Vec<_>, _>>()?;
        blur(&mut groups);
        groups.sort_by_key(|group| group.blurs == 0);

        let count = groups.iter().map(|group| group.classes.len()).product::<usize>();
        let combination = |number: usize| {
            let mut rest = number;
            let mut classes = vec![0; groups.len()];
            for (class, group) in classes.iter_mut().zip(&groups).rev() {
                *class = (rest % group.classes.len()) as u32;
                rest /= group.classes.len();
            }
            classes
        };
        let mut pieces: Vec<Vec<u32>> = (0..count).map(combination).collect();
        let first = |classes: &Vec<u32>| {
            let steps = groups
                .iter()
                .zip(classes)
                .map(|(group, class)| group.class(*class).usual() * group.stride.distance);
            let Weight { cost, operator } = weight(study, steps.sum())?;
            let of_classes = groups.iter().zip(classes);
            let cost = of_classes.fold(cost, |cost, (group, class)| group.class(*class).mean(cost));
            Ok::<_, AnswerError>(Weight { cost, operator })
        };
        let weights = pieces.par_iter().map(first).collect::<Result<Vec<_>, _>>()?;
        let mut operators = HashMap::new();
        for Weight { operator, .. } in &weights {
            let next = operators.len();
            operators.entry(*operator).or_insert(next);
        }
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|piece| operators[&weights[*piece].operator]);
        let points = along.iter().map(|stride| stride.length as u64).product::<u64>();
        let row = order.iter().map(|piece| {
            let sizes = groups.iter().zip(&pieces[*piece]);
            let count = sizes.map(|(group, class)| group.class(*class).len() as u64).product();
            let Weight { cost, operator } = weights[*piece];
            let cost = cost * u128::from(points);
            Piece { cost, weight: cost, count, points, operator }
        });
        let row = row.collect();
        pieces = order.iter().map(|piece| std::mem::take(&mut pieces[*piece])).collect();
        Ok((Lattice { groups, along, pieces }, row))
    }

    /// Adds the indices of the points of a sequence of a piece.
    pub(super) fn extend(&self, indices: &mut Vec<usize>, piece: usize, sequence: u64) {
        let mut rest = sequence as usize;
        let mut first = 0;
        for (group, class) in self.groups.iter().zip(&self.pieces[piece]).rev() {
            let class = group.class(*class);
            first += class.step(rest % class.len()) * group.stride.distance;
            rest /= class.len();
        }
        let begin = indices.len();
        indices.push(first);
        for Stride { length, distance } in &self.along {
            for known in begin..indices.len() {
                let index = indices[known];
                indices.extend((1..*length).map(|step| index + step * distance));
            }
        }
    }
}

/// Sorts the steps of a group into classes whose forecasts are the same with the other groups at
/// their first, middle and last steps.
fn classed(study: &Study, strides: &[Stride], group: usize) -> Result<ClassedGroup, AnswerError> {
    let stride = strides[group];
    let place = |part: usize| {
        let others = strides.iter().enumerate().filter(|(other, _)| *other != group);
        others.map(|(_, other)| (other.length - 1) * part / 2 * other.distance).sum::<usize>()
    };
    let places = [0, 1, 2].map(place);
    let weights = |step: usize| {
        let of = |place: usize| weight(study, place + step * stride.distance);
        let first = of(places[0])?;
        // Without other groups the three places are one.
        if places == [places[0]; 3] {
            return Ok([first; 3]);
        }
        Ok::<_, AnswerError>([first, of(places[1])?, of(places[2])?])
    };
    if study.groups()[group].design().is_some() {
        // Each point of a sample has an operator to itself, so that only costs make classes.
        let count = stride.length.min(MOST_WEIGHED);
        let weighed = |number: usize| number * (stride.length - 1) / (count - 1).max(1);
        let costs = (0..count)
            .into_par_iter()
            .map(|number| Ok(weights(weighed(number))?.map(|weight| weight.cost)))
            .collect::<Result<Vec<_>, AnswerError>>()?;
        if count == stride.length {
            let classes = (0..count).map(|step| StepClass::Listed(vec![step])).collect();
            let mut group = ClassedGroup { stride, classes, costs, blurs: 0 };
            group.blur();
            return Ok(group);
        }
        let sums: Vec<u128> = costs.iter().map(|costs| costs.iter().sum()).collect();
        let mean_cost = sums.iter().sum::<u128>() / sums.len() as u128;
        let closest = (0..count).min_by_key(|number| sums[*number].abs_diff(mean_cost));
        let closest = closest.unwrap_or_default();
        let sample = WeighedSample {
            length: stride.length,
            usual: weighed(closest),
            usual_cost: sums[closest],
            mean_cost,
        };
        let (classes, costs) = (vec![StepClass::Sample(sample)], vec![costs[closest]]);
        return Ok(ClassedGroup { stride, classes, costs, blurs: 0 });
    }
    let weights =
        (0..stride.length).into_par_iter().map(weights).collect::<Result<Vec<_>, AnswerError>>()?;
    let mut known = HashMap::new();
    let (mut classes, mut costs): (Vec<Vec<usize>>, Vec<[u128; 3]>) = (Vec::new(), Vec::new());
    for (step, weights) in weights.into_iter().enumerate() {
        let class = *known.entry(weights).or_insert(classes.len());
        match classes.get_mut(class) {
            Some(steps) => steps.push(step),
            None => {
                costs.push(weights.map(|weight| weight.cost));
                classes.push(vec![step]);
            }
        }
    }
    let classes = classes.into_iter().map(StepClass::Listed).collect();
    Ok(ClassedGroup { stride, classes, costs, blurs: 0 })
}

/// Merges classes of the groups that have most until there are few enough pieces.
fn blur(groups: &mut [ClassedGroup]) {
    loop {
        let product = groups
            .iter()
            .try_fold(1usize, |product, group| product.checked_mul(group.classes.len()));
        if product.is_some_and(|product| product <= MOST_PIECES) {
            return;
        }
        let Some(most) = groups.iter_mut().max_by_key(|group| group.classes.len()) else { return };
        most.blur();
    }
}

impl ClassedGroup {
    fn class(&self, class: u32) -> &StepClass {
        &self.classes[class as usize]
    }

    /// Merges classes of similar cost; the more often it was done, the less similar they need be.
    fn blur(&mut self) {
        let ratio = SIMILAR.powi(1 << self.blurs.min(20));
        let bin = |cost: u128| ((cost as f64).ln() / ratio.ln()).floor() as i64;
        let mut known = HashMap::new();
        let (mut classes, mut costs): (Vec<Vec<usize>>, Vec<[u128; 3]>) = (Vec::new(), Vec::new());
        for (steps, cost) in std::mem::take(&mut self.classes).into_iter().zip(&self.costs) {
            let steps = match steps {
                StepClass::Listed(steps) => steps,
                // A sample is one class already.
                sample => {
                    self.classes.push(sample);
                    return;
                }
            };
            let class = *known.entry(cost.map(bin)).or_insert(classes.len());
            match classes.get_mut(class) {
                Some(known) => known.extend(steps),
                None => {
                    classes.push(steps);
                    costs.push(*cost);
                }
            }
        }
        classes.iter_mut().for_each(|steps| steps.sort_unstable());
        let classes = classes.into_iter().map(StepClass::Listed).collect();
        (self.classes, self.costs, self.blurs) = (classes, costs, self.blurs + 1);
    }
}

/// Forecasts the point with an index.
fn weight(study: &Study, index: usize) -> Result<Weight, AnswerError> {
    let Some(point) = study.point(index) else {
        // What the conditions leave out need not make sense, and takes nothing.
        if study.has_conditions() && study.restricted(vec![index])?.indices().next().is_none() {
            return Ok(Weight { cost: 1, operator: 0 });
        }
        // What is wrong with it is said at its place.
        study.restricted(vec![index])?;
        return Err(AnswerError::Inconsistent("a point of the study cannot be made"));
    };
    let forecast = forecast(&point.job, study.surfaces())
        .map_err(|error| AnswerError::from(study.refuse(index, &error)))?;
    Ok(Weight { cost: nanoseconds(forecast.seconds), operator: forecast.operator })
}
