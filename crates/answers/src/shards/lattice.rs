//! The sequences of a study that has too many points to list them.
//!
//! Most axes do not change what a job takes. Those that do are found by forecasts along each axis,
//! with the others at three places; their steps fall into classes of equal forecasts. A combination
//! of classes is a piece of the row, of which one forecast is made and the sequences are counted.

use std::collections::HashMap;

use rayon::prelude::*;
use study::Study;

use super::listed::{Stride, nanoseconds, strides};
use super::row::Piece;
use crate::error::AnswerError;
use crate::kind::forecast;

/// The largest number of pieces. The axis with most classes does without them as long as there are
/// more, and its points are taken to be alike.
const MOST_PIECES: usize = 100_000;

/// A group of axes, its steps in classes.
struct ClassedGroup {
    stride: Stride,
    /// The steps of each class, in order.
    classes: Vec<Vec<usize>>,
    /// True if the steps differ, and there were too many classes to keep them apart.
    is_blurred: bool,
}

/// The sequences of a study by the classes of their steps.
pub(super) struct Lattice {
    /// The groups that tell sequences apart, the blurred ones first, so that what they change
    /// changes as rarely as it can.
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
        groups.sort_by_key(|group| !group.is_blurred);

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
                .map(|(group, class)| group.classes[*class as usize][0] * group.stride.distance);
            weight(study, steps.sum())
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
            let count =
                sizes.map(|(group, class)| group.classes[*class as usize].len() as u64).product();
            let Weight { cost, operator } = weights[*piece];
            Piece { cost: cost * u128::from(points), count, points, operator }
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
            let steps = &group.classes[*class as usize];
            first += steps[rest % steps.len()] * group.stride.distance;
            rest /= steps.len();
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
        Ok::<_, AnswerError>([of(places[0])?, of(places[1])?, of(places[2])?])
    };
    let weights =
        (0..stride.length).into_par_iter().map(weights).collect::<Result<Vec<_>, AnswerError>>()?;
    let mut known = HashMap::new();
    let mut classes: Vec<Vec<usize>> = Vec::new();
    for (step, weights) in weights.into_iter().enumerate() {
        let class = *known.entry(weights).or_insert(classes.len());
        match classes.get_mut(class) {
            Some(steps) => steps.push(step),
            None => classes.push(vec![step]),
        }
    }
    Ok(ClassedGroup { stride, classes, is_blurred: false })
}

/// Gives up the classes of the groups that have most until there are few enough pieces.
fn blur(groups: &mut [ClassedGroup]) {
    loop {
        let product = groups
            .iter()
            .try_fold(1usize, |product, group| product.checked_mul(group.classes.len()));
        if product.is_some_and(|product| product <= MOST_PIECES) {
            return;
        }
        let Some(most) = groups.iter_mut().max_by_key(|group| group.classes.len()) else { return };
        most.classes = vec![(0..most.stride.length).collect()];
        most.is_blurred = true;
    }
}

/// Forecasts the point with an index.
fn weight(study: &Study, index: usize) -> Result<Weight, AnswerError> {
    let Some(point) = study.point(index) else {
        // What is wrong with it is said at its place.
        study.restricted(vec![index])?;
        return Err(AnswerError::Inconsistent("a point of the study cannot be made"));
    };
    let forecast = forecast(&point.job, study.surfaces())
        .map_err(|error| AnswerError::from(study.refuse(index, &error)))?;
    Ok(Weight { cost: nanoseconds(forecast.seconds), operator: forecast.operator })
}
