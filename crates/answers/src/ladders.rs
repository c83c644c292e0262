//! The points of a study that differ in their rung only.

use std::collections::HashMap;

use study::{Study, StudyPoint, Value};

/// A combination of values of axes, and the points that have it.
pub(crate) type Members = (Vec<(String, Value)>, Vec<usize>);

/// The points of each ladder, by the values of the axes in groups that make no rungs.
pub(crate) fn members(
    study: &Study,
    is_rung: impl Fn(usize) -> bool,
    points: &[StudyPoint],
) -> Vec<Members> {
    let own: Vec<bool> = study
        .groups()
        .iter()
        .enumerate()
        .flat_map(|(at, group)| std::iter::repeat_n(is_rung(at), group.axes().len()))
        .collect();
    let mut all: Vec<Members> = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    for (index, point) in points.iter().enumerate() {
        let others = study.axes().zip(&point.values).zip(&own).filter(|(_, own)| !**own);
        let at: Vec<(String, Value)> =
            others.map(|((axis, value), _)| (axis.column().into_owned(), value.clone())).collect();
        let ladder = *known.entry(format!("{at:?}")).or_insert(all.len());
        match all.get_mut(ladder) {
            Some((_, members)) => members.push(index),
            None => all.push((at, vec![index])),
        }
    }
    all
}

pub(crate) fn place(at: &[(String, Value)]) -> String {
    let values: Vec<String> = at.iter().map(|(name, value)| format!("{name} = {value}")).collect();
    if values.is_empty() {
        "the scene".to_owned()
    } else {
        format!("the scene with {}", values.join(", "))
    }
}
