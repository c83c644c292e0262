//! The sequences of a study whose points can be listed.

use std::collections::{HashMap, HashSet};

use identity::JobKey;
use rayon::prelude::*;
use study::{Adaptive, Study};

use super::row::Piece;
use crate::error::AnswerError;
use crate::kind::forecast;

/// The sequences of a study, those of an operator side by side, and the points of each.
pub(super) struct SequenceList {
    pub(super) pieces: Vec<Piece>,
    pub(super) members: Vec<Vec<usize>>,
}

/// The part of a point that a partition needs.
struct ListedPoint {
    index: usize,
    key: JobKey,
    /// The scene, where points of the same scene learn from each other.
    scene: Option<String>,
    cost: u128,
    operator: u64,
}

/// The bond that makes points one sequence.
#[derive(PartialEq, Eq, Hash)]
enum Bond {
    Job(JobKey),
    Scene(String),
}

/// Lists the sequences of a study.
pub(super) fn list(study: &Study) -> Result<SequenceList, AnswerError> {
    let learns = matches!(study.adaptive(), Some(Adaptive::Accuracy(_)));
    let indices: Vec<usize> = study.indices().collect();
    let listed = |index: usize| {
        let point = study
            .point(index)
            .ok_or(AnswerError::Inconsistent("a point of the study cannot be made"))?;
        let forecast = forecast(&point.job, study.surfaces())
            .map_err(|error| AnswerError::from(study.refuse(index, &error)))?;
        let scene = point.job.scene_text().filter(|_| learns);
        let cost = nanoseconds(forecast.seconds);
        Ok(ListedPoint { index, key: point.key, scene, cost, operator: forecast.operator })
    };
    let points = indices.into_par_iter().map(listed).collect::<Result<Vec<_>, AnswerError>>()?;

    let first_of = FirstPoints::of(study);
    let mut seen = HashSet::new();
    let mut operators = HashMap::new();
    let (mut by_first, mut by_bond) = (HashMap::new(), HashMap::new());
    let mut pieces: Vec<Piece> = Vec::new();
    let mut members: Vec<Vec<usize>> = Vec::new();
    for ListedPoint { index, key, scene, cost, operator } in points {
        // Points of one sequence have the same first point; sequences whose first points share a
        // job are the same ones.
        let first = first_of.first(index);
        let number = *by_first.entry(first).or_insert_with(|| {
            let bond = scene.map_or(Bond::Job(key), Bond::Scene);
            *by_bond.entry(bond).or_insert_with(|| {
                pieces.push(Piece { cost: 0, count: 1, points: 0, operator });
                members.push(Vec::new());
                members.len() - 1
            })
        });
        let next = operators.len();
        operators.entry(operator).or_insert(next);
        members[number].push(index);
        pieces[number].points += 1;
        if seen.insert(key) {
            pieces[number].cost += cost;
        }
    }
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_by_key(|number| operators[&pieces[*number].operator]);
    let taken = |number: &usize| Piece { cost: pieces[*number].cost.max(1), ..pieces[*number] };
    Ok(SequenceList {
        pieces: order.iter().map(taken).collect(),
        members: order.iter().map(|number| std::mem::take(&mut members[*number])).collect(),
    })
}

/// Returns a time in whole nanoseconds, at least one.
pub(super) fn nanoseconds(seconds: f64) -> u128 {
    ((seconds * 1e9).round() as u128).max(1)
}

/// Finds the first point of the sequence of any point.
pub(super) struct FirstPoints {
    /// The number of steps and the distance of indices of each group that runs along a sequence.
    along: Vec<Stride>,
}

/// The steps of a group of axes in the indices of points.
#[derive(Clone, Copy)]
pub(super) struct Stride {
    pub(super) length: usize,
    pub(super) distance: usize,
}

impl FirstPoints {
    pub(super) fn of(study: &Study) -> FirstPoints {
        let strides = strides(study).into_iter().enumerate();
        let along = strides.filter(|(group, _)| study.is_sequence(*group));
        FirstPoints { along: along.map(|(_, stride)| stride).collect() }
    }

    fn first(&self, index: usize) -> usize {
        let steps = self
            .along
            .iter()
            .map(|Stride { length, distance }| index / distance % length * distance);
        index - steps.sum::<usize>()
    }
}

/// Returns the stride of every group of axes, the last of which is the fastest.
pub(super) fn strides(study: &Study) -> Vec<Stride> {
    let mut distance = 1;
    let mut strides: Vec<Stride> = study
        .groups()
        .iter()
        .rev()
        .map(|group| {
            let stride = Stride { length: group.len(), distance };
            distance *= group.len();
            stride
        })
        .collect();
    strides.reverse();
    strides
}
