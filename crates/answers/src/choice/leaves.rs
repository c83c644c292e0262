//! The cells between the points of a curve or a map, and which of them to divide.
//!
//! A cell is an interval of a curve or a rectangle of a map. It bends along an axis by what the
//! straight line between its ends is off there, by estimate: an eighth of its length times the sum
//! of the changes of slope at both ends. For a parabola that is twice what is true, for a kink at
//! least half of it. The height of the triangle that the line makes with the continued lines of
//! the neighbours is sharper for both, but nothing where a point lies just on the middle of a
//! steep step, which is where given values often lie. A map is interpolated between the four
//! corners of a cell, so what it is off by is the sum over both axes. Cells are halved along the
//! axis along which they bend more. The first and the last interval of a curve are halved in any
//! case: a neighbour on one side hides where the curve begins to bend.
//!
//! All cells that bend too much are halved at once, and what comes next is decided when all their
//! new points have values. So the points follow from the values alone, and neither the order nor
//! the number of those who compute them leaves a trace. If only so many points may be added, the
//! cells with the largest loss come first: what they are off by times their area, as in the
//! Learner2D of the package adaptive (Nijholt et al., doi:10.5281/zenodo.1182437). If no bound is
//! given, those are halved whose loss is at least half of the largest one, a rule of adaptive
//! finite elements (Babuška & Vogelius, 1984, doi:10.1007/BF01389757). That package triangulates
//! scattered points; halved cells take no predicates, their points are short decimals on the lines
//! of the given ones, and a map that bends along one axis gets points along that one alone.

use std::collections::BTreeMap;
use std::ops::Bound;

use super::column_value::ColumnValue;

/// The place of a point along both axes, of which a curve has one: the index of a given value and,
/// in the lower bits, the part of the way to the next one.
pub(super) type GridPlace = [u64; 2];

/// The bits of a place below the index of the given value.
const PART_BITS: u32 = 32;

/// The number of times that the interval between given values can be halved.
const MOST_HALVINGS: u32 = 24;

/// Returns the place of a given value.
pub(super) fn given_place(index: usize) -> u64 {
    (index as u64) << PART_BITS
}

/// Returns the index of the given value at or below a place, and the part of the way to the next.
pub(super) fn index_and_part(place: u64) -> (usize, f64) {
    let part = place & ((1 << PART_BITS) - 1);
    ((place >> PART_BITS) as usize, part as f64 / (1_u64 << PART_BITS) as f64)
}

/// The ends of filling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FillingEnds {
    /// The deviation that is small enough, relative to the range of the values; `None` to go on
    /// while there may be more points.
    pub(super) to: Option<f64>,
    /// The number of points that may be added.
    pub(super) at_most: usize,
    /// The change, relative to the largest value, below which values count as equal.
    pub(super) noise: f64,
}

/// The reason why no further point is added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FillingEnd {
    /// Values are not known yet.
    Pending,
    /// Nothing bends by more than it may.
    Smooth,
    /// Nothing varies.
    Flat,
    /// The cells that still bend are a part of the axis that is small enough.
    Steep,
    /// There is a cell beside a point without a value.
    Void,
    /// The number of points that may be added is reached.
    Full,
}

/// The cells between the points of a curve or a map.
#[derive(Clone, Debug)]
pub(super) struct Leaves {
    /// The given values of each axis, as the drawing measures them, from 0 to 1.
    given: [Vec<f64>; 2],
    leaves: Vec<Leaf>,
    /// The value at each point, as far as it is known.
    pub(super) values: BTreeMap<GridPlace, ColumnValue>,
    /// The values along each axis: by the place along the other one, then by that along it.
    lines: [BTreeMap<GridPlace, f64>; 2],
}

/// A cell that is not divided.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Leaf {
    low: GridPlace,
    high: GridPlace,
    /// The deviation along each axis where its own points do not tell: what its parent's told.
    assumed: [f64; 2],
    /// True if it lies between given values.
    is_given: bool,
}

/// A cell that is to be halved.
struct MarkedLeaf {
    index: usize,
    axis: usize,
    loss: f64,
}

/// The cells that are to be halved, or why there is none.
enum Marking {
    Leaves(Vec<MarkedLeaf>),
    End(FillingEnd),
}

impl Leaves {
    /// Returns the cells between given values of two axes, as the drawing measures them. A curve
    /// has a second axis of one value.
    pub(super) fn new(given: [&[f64]; 2]) -> Self {
        let scaled = given.map(|values| {
            let (first, last) = (values[0], values[values.len() - 1]);
            let length = if last > first { last - first } else { 1.0 };
            values.iter().map(|value| (value - first) / length).collect::<Vec<f64>>()
        });
        // An axis of one value has one cell without a length.
        let cells = |axis: usize| 0..given[axis].len().saturating_sub(1).max(1);
        let high = |axis: usize, index: usize| (index + 1).min(given[axis].len() - 1);
        let assumed = [0, 1].map(|axis| if given[axis].len() > 1 { f64::INFINITY } else { 0.0 });
        let leaf = |x: usize, y: usize| Leaf {
            low: [x, y].map(given_place),
            high: [high(0, x), high(1, y)].map(given_place),
            assumed,
            is_given: true,
        };
        let leaves = cells(0).flat_map(|x| cells(1).map(move |y| leaf(x, y))).collect();
        let lines = [BTreeMap::new(), BTreeMap::new()];
        Self { given: scaled, leaves, values: BTreeMap::new(), lines }
    }

    /// Adds points until an end is reached, by what `evaluate` knows of each place.
    ///
    /// # Errors
    /// A point cannot be evaluated.
    pub(super) fn fill<E>(
        &mut self,
        ends: &FillingEnds,
        mut evaluate: impl FnMut(GridPlace) -> Result<ColumnValue, E>,
    ) -> Result<FillingEnd, E> {
        let [xs, ys] = [0, 1].map(|axis| self.given[axis].len());
        for x in 0..xs {
            for y in 0..ys {
                let place = [x, y].map(given_place);
                self.insert(place, evaluate(place)?);
            }
        }
        let given = self.values.len();
        loop {
            if self.values.values().any(|value| *value == ColumnValue::Pending) {
                return Ok(FillingEnd::Pending);
            }
            let marked = match self.mark(ends) {
                Marking::Leaves(marked) => marked,
                Marking::End(end) => return Ok(end),
            };
            let mut halved = Vec::new();
            for MarkedLeaf { index, axis, .. } in marked {
                let leaf = self.leaves[index];
                let mut missing = leaf.middle(axis).to_vec();
                missing.dedup();
                missing.retain(|place| !self.values.contains_key(place));
                if self.values.len() + missing.len() > given + ends.at_most {
                    continue;
                }
                for place in missing {
                    self.insert(place, evaluate(place)?);
                }
                halved.push((index, axis));
            }
            if halved.is_empty() {
                return Ok(FillingEnd::Full);
            }
            for (index, axis) in halved {
                let leaf = self.leaves[index];
                let [first, second] = leaf.halves(axis, self.bend(&leaf));
                self.leaves[index] = first;
                self.leaves.push(second);
            }
        }
    }

    /// Returns the largest deviation of a cell that is known, relative to the range of the values.
    pub(super) fn deviation(&self) -> Option<f64> {
        let range = self.range();
        let known = self.leaves.iter().filter(|leaf| self.is_known(leaf));
        let bends = known.map(|leaf| self.bend(leaf).iter().sum::<f64>());
        let largest = bends.filter(|bend| bend.is_finite()).fold(0.0, f64::max);
        (range > 0.0).then_some(largest / range)
    }

    fn insert(&mut self, place: GridPlace, value: ColumnValue) {
        self.values.insert(place, value);
        if let ColumnValue::Value(value) = value {
            let [x, y] = place;
            self.lines[0].insert([y, x], value);
            self.lines[1].insert([x, y], value);
        }
    }

    fn known(&self) -> impl Iterator<Item = f64> {
        self.values.values().filter_map(|value| value.value())
    }

    fn range(&self) -> f64 {
        let least = self.known().fold(f64::INFINITY, f64::min);
        let most = self.known().fold(f64::NEG_INFINITY, f64::max);
        (most - least).max(0.0)
    }

    /// Tells whether the corners of a cell have values.
    fn is_known(&self, leaf: &Leaf) -> bool {
        let has_value =
            |place: &GridPlace| matches!(self.values.get(place), Some(ColumnValue::Value(_)));
        leaf.corners().iter().all(has_value)
    }

    /// Returns the cells that are to be halved, those with the largest loss first.
    fn mark(&self, ends: &FillingEnds) -> Marking {
        let noise = ends.noise * self.known().fold(0.0, |most: f64, value| most.max(value.abs()));
        let range = self.range();
        let floor = ends.to.map_or(noise, |to| noise.max(to * range));
        let shortest = ends.to.unwrap_or(0.0);
        let (mut marked, mut is_open, mut is_steep) = (Vec::new(), false, false);
        for (index, leaf) in self.leaves.iter().enumerate() {
            if !self.is_known(leaf) {
                is_open = true;
                continue;
            }
            let bend = self.bend(leaf);
            let deviation = bend[0] + bend[1];
            if deviation <= floor {
                continue;
            }
            let lengths = [0, 1].map(|axis| self.length(leaf, axis));
            let is_divisible = |axis: &usize| {
                lengths[*axis] > shortest && leaf.is_divisible(*axis) && bend[*axis] > 0.5 * floor
            };
            let axes = (0..2).filter(is_divisible);
            let Some(axis) = axes.max_by(|a, b| bend[*a].total_cmp(&bend[*b])) else {
                is_steep = true;
                continue;
            };
            // A curve has no width.
            let area: f64 = lengths.into_iter().filter(|length| *length > 0.0).product();
            marked.push(MarkedLeaf { index, axis, loss: deviation * area });
        }
        // The first of equal cells stay first.
        marked.sort_by(|a, b| {
            let places = [a, b].map(|marked| self.leaves[marked.index].low);
            b.loss.total_cmp(&a.loss).then(places[0].cmp(&places[1]))
        });
        if ends.to.is_none() {
            let largest = marked.first().map_or(0.0, |first| first.loss);
            marked.retain(|leaf| leaf.loss >= 0.5 * largest);
        }
        if !marked.is_empty() {
            return Marking::Leaves(marked);
        }
        Marking::End(match (is_open, is_steep) {
            (true, _) => FillingEnd::Void,
            (false, true) => FillingEnd::Steep,
            (false, false) if range <= noise => FillingEnd::Flat,
            (false, false) => FillingEnd::Smooth,
        })
    }

    /// Returns the place of a point along an axis, as the drawing measures it.
    fn measure(&self, axis: usize, place: u64) -> f64 {
        let (index, part) = index_and_part(place);
        let given = &self.given[axis];
        let (low, high) = (given[index], given[(index + 1).min(given.len() - 1)]);
        low + (high - low) * part
    }

    fn length(&self, leaf: &Leaf, axis: usize) -> f64 {
        self.measure(axis, leaf.high[axis]) - self.measure(axis, leaf.low[axis])
    }

    /// Returns the deviation of a cell along each axis.
    fn bend(&self, leaf: &Leaf) -> [f64; 2] {
        [0, 1].map(|axis| {
            let other = 1 - axis;
            let sides = [leaf.low[other], leaf.high[other]];
            let on_sides = sides.map(|side| self.side_bend(axis, side, leaf));
            on_sides.into_iter().flatten().reduce(f64::max).unwrap_or(leaf.assumed[axis])
        })
    }

    /// Returns the deviation along one side of a cell, which lies along an axis; `None` if it has
    /// no neighbours there.
    fn side_bend(&self, axis: usize, side: u64, leaf: &Leaf) -> Option<f64> {
        let line = &self.lines[axis];
        let [from, to] = [leaf.low[axis], leaf.high[axis]];
        let value = |along: u64| line.get(&[side, along]).copied();
        let slope = |a: u64, b: u64| {
            Some((value(b)? - value(a)?) / (self.measure(axis, b) - self.measure(axis, a)))
        };
        if from == to {
            return None;
        }
        let inner = slope(from, to)?;
        let before = line.range([side, 0]..[side, from]).next_back();
        let after = (Bound::Excluded([side, to]), Bound::Included([side, u64::MAX]));
        let after = line.range(after).next();
        let outer = [
            before.and_then(|([_, along], _)| slope(*along, from)),
            after.and_then(|([_, along], _)| slope(to, *along)),
        ];
        let [before, after] = outer.map(|slope| Some((slope? - inner).abs()));
        // A curve that bends before its first neighbour hides that from the estimate.
        let is_curve = self.given[1].len() == 1;
        if is_curve && leaf.is_given && before.is_some() != after.is_some() {
            return None;
        }
        // At the end of a line both ends of the cell are taken to bend alike.
        let (before, after) = (before.or(after)?, after.or(before)?);
        Some(self.length(leaf, axis) / 8.0 * (before + after))
    }
}

impl Leaf {
    fn corners(&self) -> [GridPlace; 4] {
        let Leaf { low: [x, y], high: [right, top], .. } = *self;
        [[x, y], [right, y], [x, top], [right, top]]
    }

    /// Tells whether it can be halved along an axis.
    fn is_divisible(&self, axis: usize) -> bool {
        self.high[axis] - self.low[axis] > 1 << (PART_BITS - MOST_HALVINGS)
    }

    fn middle_along(&self, axis: usize) -> u64 {
        self.low[axis] + (self.high[axis] - self.low[axis]) / 2
    }

    /// Returns the ends of the line that halves it across an axis; both are one for a curve.
    fn middle(&self, axis: usize) -> [GridPlace; 2] {
        let mut ends = [self.low, self.high];
        ends.iter_mut().for_each(|end| end[axis] = self.middle_along(axis));
        ends
    }

    /// Returns its halves across an axis, given its deviation along each: that of a half is a
    /// quarter along this axis.
    fn halves(&self, axis: usize, bend: [f64; 2]) -> [Leaf; 2] {
        let mut assumed = bend;
        assumed[axis] /= 4.0;
        let [mut first, mut second] = [Leaf { assumed, is_given: false, ..*self }; 2];
        let middle = self.middle_along(axis);
        first.high[axis] = middle;
        second.low[axis] = middle;
        [first, second]
    }
}

#[cfg(test)]
mod tests;
