//! Places in a study: combinations of values of its axes.

use std::collections::HashMap;

use report::{Cell, TableColumn};
use study::{Study, StudyPoint, Value};

use crate::rows::cell;

/// A combination of values of some axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyPlace {
    /// The column of each axis, with its value in SI units.
    pub values: Vec<(String, Value)>,
}

impl StudyPlace {
    /// Returns the place of a point, by those axes for whose index `is_meant` holds.
    pub(crate) fn of(study: &Study, point: &StudyPoint, is_meant: impl Fn(usize) -> bool) -> Self {
        let axes = study.axes().zip(&point.values).enumerate().filter(|(axis, _)| is_meant(*axis));
        let values = axes.map(|(_, (axis, value))| (axis.column().into_owned(), value.clone()));
        Self { values: values.collect() }
    }

    /// Returns the heads of a table whose rows begin with a place like this one.
    pub(crate) fn heads(&self, study: &Study) -> Vec<TableColumn> {
        let columns = study.columns();
        let head = |(name, _): &(String, Value)| TableColumn::new(name, unit_of(&columns, name));
        self.values.iter().map(head).collect()
    }

    /// Returns the first cells of such a row.
    pub(crate) fn cells(&self) -> Vec<Cell> {
        self.values.iter().map(|(_, value)| cell(value.clone())).collect()
    }

    /// Names the scene at the place, to be read.
    pub(crate) fn scene(&self) -> String {
        let values: Vec<String> =
            self.values.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        if values.is_empty() {
            "the scene".to_owned()
        } else {
            format!("the scene with {}", values.join(", "))
        }
    }
}

/// Returns the unit of the column with this name, nothing for none.
pub(crate) fn unit_of(columns: &[study::Column], name: &str) -> &'static str {
    study::columns::find(columns, name).map_or("", study::Column::unit)
}

/// A value as an identity: numbers are equal if they have the same bits.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ValueKey<'v> {
    Number(u64),
    Integer(u64),
    Flag(bool),
    Text(&'v str),
    Missing,
}

impl<'v> From<&'v Value> for ValueKey<'v> {
    fn from(value: &'v Value) -> Self {
        match value {
            Value::Number(x) => ValueKey::Number(x.to_bits()),
            Value::Integer(n) => ValueKey::Integer(*n),
            Value::Flag(yes) => ValueKey::Flag(*yes),
            Value::Text(text) => ValueKey::Text(text),
            Value::Missing => ValueKey::Missing,
        }
    }
}

/// Points that share a place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PointGroup {
    pub(crate) place: StudyPlace,
    /// The indices of the points, in order.
    pub(crate) members: Vec<usize>,
}

/// Groups points by the values of the axes, those of the groups of axes for which `is_rung` holds
/// aside; in the order of the first points.
pub(crate) fn group_points(
    study: &Study,
    points: &[StudyPoint],
    is_rung: impl Fn(usize) -> bool,
) -> Vec<PointGroup> {
    let axes_of_rungs: Vec<bool> = study
        .groups()
        .iter()
        .enumerate()
        .flat_map(|(index, group)| std::iter::repeat_n(is_rung(index), group.axes().len()))
        .collect();
    let is_of_place = |axis: usize| axes_of_rungs.get(axis) == Some(&false);
    let mut groups: Vec<PointGroup> = Vec::new();
    let mut known: HashMap<Vec<ValueKey<'_>>, usize> = HashMap::new();
    for (index, point) in points.iter().enumerate() {
        let values = point.values.iter().enumerate().filter(|(axis, _)| is_of_place(*axis));
        let key = values.map(|(_, value)| ValueKey::from(value)).collect();
        let group = *known.entry(key).or_insert(groups.len());
        match groups.get_mut(group) {
            Some(group) => group.members.push(index),
            None => {
                let place = StudyPlace::of(study, point, is_of_place);
                groups.push(PointGroup { place, members: vec![index] });
            }
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::study;

    #[test]
    fn points_are_grouped_by_the_axes_that_make_no_rungs() {
        let study =
            study("[sweep]\n\"friction.mu\" = [0.1, 0.2]\n\"numerics.mesh\" = [8, 16, 32]\n");
        let points = study.points();
        let groups = group_points(&study, &points, |group| group == 1);
        let members: Vec<&[usize]> = groups.iter().map(|group| &group.members[..]).collect();
        assert_eq!(members, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(groups[1].place.scene(), "the scene with mu = 0.2");
        assert_eq!(group_points(&study, &points, |_| true)[0].place.scene(), "the scene");
        assert_eq!(group_points(&study, &points, |_| false).len(), 6);
    }
}
