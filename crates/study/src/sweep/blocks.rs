//! The blocks of `[[sweep]]`, whose points are joined.

use std::collections::HashSet;

use crate::axis::{
    Choice, ChoiceIdentity, Group, MAX_ENTRIES, MAX_POINTS, SweepAxis, Target, count, steps,
};
use crate::error::{Mistake, Span};
use crate::key::Key;
use crate::sheet::Given;
use crate::value::Value;

/// The blocks of a study: one group whose axes are those of all blocks, and which has the points of
/// the first block, then those of the second, and so on.
#[derive(Default)]
pub(crate) struct JoinedBlocks {
    /// The group; `None` if no block has an axis.
    pub(crate) group: Option<Group>,
    /// The remarks on points that count once, in sentences.
    pub(crate) remarks: Vec<String>,
}

/// A block: its axes, and its place in the file.
pub(super) struct AxisBlock {
    pub(super) groups: Vec<Group>,
    pub(super) span: Span,
}

/// Joins the points of some blocks. A key that a block does not vary has the scene's value there,
/// which `base` gives.
pub(super) fn join(
    blocks: &[AxisBlock],
    base: &[(Key, Given)],
    mistakes: &mut Vec<Mistake>,
) -> Option<JoinedBlocks> {
    let mut points = 0_usize;
    for block in blocks {
        points = points.saturating_add(count(&block.groups).unwrap_or(usize::MAX));
        if points > MAX_POINTS {
            let message = format!("the blocks of [[sweep]] make more than {MAX_POINTS} points");
            let expected = "needs fewer values, here or before";
            mistakes.push(Mistake::new(block.span.clone(), message, expected));
            return None;
        }
    }
    let axes = joined_axes(blocks, mistakes)?;
    if axes.len().saturating_mul(points) > MAX_ENTRIES {
        let message = format!(
            "{points} points of {} axes in the blocks of [[sweep]] have more than {MAX_ENTRIES} \
             values",
            axes.len()
        );
        let span = axes.first().map_or(0..0, |axis| axis.span.clone());
        mistakes.push(Mistake::new(span, message, "needs fewer points, or fewer axes"));
        return None;
    }
    Some(joined(axes, blocks, base))
}

/// Returns the axes of all blocks without their values, each once. Axes of two blocks that set the
/// same keys must be the same.
fn joined_axes(blocks: &[AxisBlock], mistakes: &mut Vec<Mistake>) -> Option<Vec<SweepAxis>> {
    let mut joined: Vec<SweepAxis> = Vec::new();
    for axis in blocks.iter().flat_map(|block| &block.groups).flat_map(|group| &group.axes) {
        match joined.iter_mut().find(|other| other.target.overlaps(axis.target)) {
            None => joined.push(SweepAxis { choices: Vec::new(), ..axis.clone() }),
            Some(other) if other.target == axis.target => other.log &= axis.log,
            Some(other) => {
                let message = format!(
                    "`{}` and `{}`, in two blocks, set the same keys",
                    other.path(),
                    axis.path()
                );
                let mistake = Mistake::new(axis.span.clone(), message, "must vary the same key");
                mistakes.push(mistake.context(other.span.clone(), "the other one"));
                return None;
            }
        }
    }
    Some(joined)
}

/// Gives the axes the values of every point of the blocks.
fn joined(mut axes: Vec<SweepAxis>, blocks: &[AxisBlock], base: &[(Key, Given)]) -> JoinedBlocks {
    let of_scene: Vec<Choice> = axes.iter().map(|axis| scene_choice(axis, base)).collect();
    let mut seen: HashSet<Vec<ChoiceIdentity>> = HashSet::new();
    let (mut length, mut repeated) = (0, 0);
    for AxisBlock { groups, .. } in blocks {
        let varied: Vec<&SweepAxis> = groups.iter().flat_map(|group| &group.axes).collect();
        let place = |axis: &SweepAxis| varied.iter().position(|other| other.target == axis.target);
        let places: Vec<Option<usize>> = axes.iter().map(place).collect();
        for point in 0..count(groups).unwrap_or(0) {
            let steps = steps(groups, point);
            let of_axes: Vec<&Choice> = groups
                .iter()
                .zip(&steps)
                .flat_map(|(group, step)| group.axes.iter().map(|axis| &axis.choices[*step]))
                .collect();
            let row = places.iter().zip(&of_scene);
            let row: Vec<&Choice> =
                row.map(|(place, scene)| place.map_or(scene, |p| of_axes[p])).collect();
            if !seen.insert(row.iter().map(|choice| choice.identity()).collect()) {
                repeated += 1;
                continue;
            }
            length += 1;
            axes.iter_mut().zip(row).for_each(|(axis, choice)| axis.choices.push(choice.clone()));
        }
    }
    let remarks = match repeated {
        0 => Vec::new(),
        1 => vec![
            "1 point of a block of [[sweep]] is one of an earlier block, and counts once"
                .to_owned(),
        ],
        n => vec![format!(
            "{n} points of blocks of [[sweep]] are those of earlier blocks, and count once"
        )],
    };
    let group = (!axes.is_empty()).then(|| Group::listed(axes, length));
    JoinedBlocks { group, remarks }
}

/// Returns what the scene gives in the place of an axis.
fn scene_choice(axis: &SweepAxis, base: &[(Key, Given)]) -> Choice {
    let is_set = |key: Key| match axis.target {
        Target::Key(target) => key == target,
        Target::Table(table) => key.is_under(&table),
    };
    let given: Vec<(Key, Given)> = base.iter().filter(|(key, _)| is_set(*key)).cloned().collect();
    let shown = match (axis.target, given.first()) {
        (Target::Key(_), Some((_, given))) => Value::from(&given.setting),
        (_, None) => Value::Text("none".to_owned()),
        (Target::Table(_), Some(_)) => Value::Text("scene".to_owned()),
    };
    Choice { shown, given, span: axis.span.clone() }
}
