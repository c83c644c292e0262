//! The places along a line at which a result takes a value, as far as given values of the axis tell
//! them apart.

use super::column_value::ColumnValue;
use super::found::{Discovery, Passage};
use super::narrowing::{GraphPoint, Narrowing, NarrowingEnd, SignChange};

/// The search along one line.
pub(super) struct RootLine {
    /// The given values of the axis, in ascending order.
    pub(super) xs: Vec<f64>,
    /// True if the search goes by equal ratios.
    pub(super) is_log: bool,
    /// The value that the result takes.
    pub(super) value: f64,
    /// The length of a bracket that is short enough, as [`Narrowing`] has it.
    pub(super) to: f64,
}

/// The result of a search along a line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LineRoots {
    /// The findings, in the order of the axis.
    pub(super) discoveries: Vec<Discovery>,
    /// The largest number of points that may follow those that were evaluated.
    pub(super) more: usize,
}

/// The largest part of the change over an interval that counts as no jump in a short bracket.
const LARGEST_PART: f64 = 0.5;

/// The largest part of an interval that is short beside it.
const SHORT: f64 = 0.1;

impl RootLine {
    /// Searches the line, given what is known at its values, by what `evaluate` knows between them.
    ///
    /// # Errors
    /// A point cannot be evaluated.
    pub(super) fn search<E>(
        &self,
        given: &[ColumnValue],
        mut evaluate: impl FnMut(f64) -> Result<ColumnValue, E>,
    ) -> Result<LineRoots, E> {
        let ys: Vec<ColumnValue> = given.iter().map(|value| self.relative(*value)).collect();
        let mut roots = LineRoots { discoveries: Vec::new(), more: 0 };
        for step in 0..ys.len() {
            roots.discoveries.extend(self.run_from(&ys, step));
            if step + 1 < ys.len() {
                let ys = [ys[step], ys[step + 1]];
                self.follow([self.xs[step], self.xs[step + 1]], ys, &mut evaluate, &mut roots)?;
            }
        }
        if ys.contains(&ColumnValue::Pending) {
            roots.discoveries.push(Discovery::Pending);
        }
        if roots.discoveries.is_empty() {
            roots.discoveries.extend(self.apart(&ys));
        }
        Ok(roots)
    }

    /// Narrows an interval if the result lies on different sides at its ends.
    fn follow<E>(
        &self,
        xs: [f64; 2],
        ys: [ColumnValue; 2],
        evaluate: &mut impl FnMut(f64) -> Result<ColumnValue, E>,
        roots: &mut LineRoots,
    ) -> Result<(), E> {
        let range = self.xs.last().zip(self.xs.first()).map_or(0.0, |(last, first)| last - first);
        let narrowing = Narrowing::new(xs[0], xs[1], self.is_log, self.to, range);
        let Some(start) = sign_change(xs, ys) else {
            let has = |wanted: ColumnValue| ys.contains(&wanted);
            if has(ColumnValue::Pending) && !has(ColumnValue::Void) {
                roots.more += narrowing.steps();
            }
            return Ok(());
        };
        let mut change = start;
        let end = narrowing.narrow(&mut change, |x| Ok(self.relative(evaluate(x)?)))?;
        roots.discoveries.push(match end {
            NarrowingEnd::Short if change.low == change.high => {
                let passage = if rises(&start) { Passage::Rises } else { Passage::Falls };
                Discovery::Met { from: change.low.x, to: change.low.x, passage }
            }
            NarrowingEnd::Short => Discovery::Root {
                root: narrowing.root(&change),
                from: change.low.x,
                to: change.high.x,
                values: self.ends(&change),
                rises: rises(&change),
                jumps: jumps(&start, &change),
            },
            NarrowingEnd::Pending { more } => {
                roots.more += more;
                self.open(&change, "crosses between; jobs are left")
            }
            NarrowingEnd::Void => {
                self.open(&change, "crosses between; a job between was not solved")
            }
        });
        Ok(())
    }

    /// Returns a value less the one that is looked for.
    fn relative(&self, value: ColumnValue) -> ColumnValue {
        match value {
            ColumnValue::Value(value) => ColumnValue::Value(value - self.value),
            unknown => unknown,
        }
    }

    /// Returns the values of the result at the ends of an interval.
    fn ends(&self, SignChange { low, high }: &SignChange) -> [f64; 2] {
        [low.y + self.value, high.y + self.value]
    }

    fn open(&self, change: &SignChange, reason: &'static str) -> Discovery {
        let [from, to] = [change.low.x, change.high.x].map(Some);
        Discovery::Open { from, to, values: self.ends(change).map(Some), reason }
    }

    /// Returns the finding about a run of values that begins at an index: of points at which the
    /// result is just the value, or of jobs that were not solved.
    fn run_from(&self, ys: &[ColumnValue], step: usize) -> Option<Discovery> {
        let before = step.checked_sub(1).map(|step| ys[step]);
        let y = ys[step];
        if !matches!(y, ColumnValue::Value(0.0) | ColumnValue::Void) || before == Some(y) {
            return None;
        }
        let length = ys[step..].iter().take_while(|other| **other == y).count();
        let after = ys.get(step + length).copied();
        let sides = [before, after].map(|side| side.and_then(ColumnValue::value));
        if y == ColumnValue::Void {
            let from = step.checked_sub(1).map(|step| self.xs[step]);
            let to = self.xs.get(step + length).copied();
            let values = sides.map(|side| side.map(|y| y + self.value));
            let reason = match sides {
                [Some(a), Some(b)] if a * b < 0.0 => {
                    "crosses between; a job between was not solved"
                }
                _ => "not known between; a job was not solved",
            };
            return Some(Discovery::Open { from, to, values, reason });
        }
        let passage = match sides {
            [Some(a), Some(b)] if a < 0.0 && b > 0.0 => Passage::Rises,
            [Some(a), Some(b)] if a > 0.0 && b < 0.0 => Passage::Falls,
            [Some(_), Some(_)] => Passage::Touches,
            _ => Passage::Meets,
        };
        let (from, to) = (self.xs[step], self.xs[step + length - 1]);
        Some(Discovery::Met { from, to, passage })
    }

    /// Returns the finding of a line along which nothing was found.
    fn apart(&self, ys: &[ColumnValue]) -> Option<Discovery> {
        let known = self.xs.iter().zip(ys);
        let known = known.filter_map(|(x, y)| Some(GraphPoint { x: *x, y: y.value()? }));
        let GraphPoint { x, y } = known.min_by(|a, b| a.y.abs().total_cmp(&b.y.abs()))?;
        Some(Discovery::Apart { nearest: x, value: y + self.value, is_above: y > 0.0 })
    }
}

/// Returns an interval if the signs at its ends differ.
fn sign_change(xs: [f64; 2], ys: [ColumnValue; 2]) -> Option<SignChange> {
    let [low, high] = [ys[0].value()?, ys[1].value()?];
    let differs = low != 0.0 && high != 0.0 && (low > 0.0) != (high > 0.0);
    let (low, high) = (GraphPoint { x: xs[0], y: low }, GraphPoint { x: xs[1], y: high });
    differs.then_some(SignChange { low, high })
}

fn rises(change: &SignChange) -> bool {
    change.high.y > 0.0
}

/// Tells whether a function jumps in a short bracket within an interval.
fn jumps(interval: &SignChange, bracket: &SignChange) -> bool {
    let length = |SignChange { low, high }: &SignChange| high.x - low.x;
    let change = |SignChange { low, high }: &SignChange| (high.y - low.y).abs();
    length(bracket) <= SHORT * length(interval) && change(bracket) > LARGEST_PART * change(interval)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::convert::Infallible;

    use super::*;

    /// The findings along a line, and how many points were evaluated between the given ones.
    struct Search {
        found: Vec<Discovery>,
        steps: usize,
    }

    /// Searches in rounds as a study does: in each, what the last one asked for is known. In every
    /// round no more points follow than it said.
    fn search(line: &RootLine, f: impl Fn(f64) -> ColumnValue) -> Search {
        let mut known: BTreeSet<u64> = BTreeSet::new();
        let pending = vec![ColumnValue::Pending; line.xs.len()];
        let begun = line.search(&pending, |_| -> Result<_, Infallible> { unreachable!() });
        let Ok(LineRoots { mut more, discoveries }) = begun;
        assert_eq!(discoveries, [Discovery::Pending]);
        let given: Vec<ColumnValue> = line.xs.iter().map(|x| f(*x)).collect();
        loop {
            let mut wanted = Vec::new();
            let roots = line.search(&given, |x| {
                if known.contains(&x.to_bits()) {
                    return Ok::<_, Infallible>(f(x));
                }
                wanted.push(x.to_bits());
                Ok(ColumnValue::Pending)
            });
            let Ok(LineRoots { discoveries: found, more: left }) = roots;
            assert!(
                left + wanted.len() <= more,
                "{left} and {} are more than {more}",
                wanted.len()
            );
            more = left;
            if wanted.is_empty() {
                assert_eq!(more, 0);
                return Search { found, steps: known.len() };
            }
            known.extend(wanted);
        }
    }

    fn line(xs: &[f64], value: f64) -> RootLine {
        RootLine { xs: xs.to_vec(), is_log: false, value, to: 1e-3 }
    }

    /// Returns the roots, each with whether the function rises there and whether it jumps.
    fn roots(found: &[Discovery]) -> Vec<(f64, [bool; 2])> {
        let root = |discovery: &Discovery| match *discovery {
            Discovery::Root { root, from, to, rises, jumps, .. } => {
                assert!(from <= root && root <= to && to - from <= 2e-3, "{discovery:?}");
                (root, [rises, jumps])
            }
            _ => panic!("{discovery:?}"),
        };
        found.iter().map(root).collect()
    }

    #[test]
    fn every_root_of_a_cubic_is_found() {
        let exact = [0.213_777_777_1, 0.521_313_131_3, 0.907_171_717_1];
        let f =
            |x: f64| ColumnValue::Value(exact.iter().map(|root| x - root).product::<f64>() + 7.0);
        let Search { found, steps } = search(&line(&[0.05, 0.3, 0.6, 0.7, 1.0], 7.0), f);
        let roots = roots(&found);
        assert_eq!(
            roots.iter().map(|root| root.1).collect::<Vec<_>>(),
            [[true, false], [false, false], [true, false]]
        );
        for ((root, _), exact) in roots.iter().zip(exact) {
            assert!((root - exact).abs() < 1e-3, "{root}, not {exact}");
        }
        // Bisection takes nine or ten steps for each.
        assert!(steps <= 16, "{steps}");
        // Two roots between given values are none.
        let Search { found, steps } = search(&line(&[0.05, 0.3, 1.0], 7.0), f);
        assert_eq!((found.len(), steps > 0), (1, true), "{found:?}");
        let Search { found, steps } = search(&line(&[0.3, 0.4, 0.45], 7.0), f);
        let [Discovery::Apart { nearest, value, is_above: true }] = found[..] else {
            panic!("{found:?}")
        };
        assert_eq!((steps, nearest), (0, 0.45));
        assert!((value - 7.0).abs() < 0.01);
    }

    #[test]
    fn a_jump_is_no_crossing() {
        let f = |x: f64| ColumnValue::Value(if x < 0.3123 { 1.0 } else { -3.0 + x });
        let Search { found, steps } = search(&line(&[0.0, 1.0], 0.0), f);
        assert_eq!(roots(&found)[0].1, [false, true]);
        assert!(steps <= 12, "{steps}");
    }

    #[test]
    fn what_is_just_the_value_is_said_and_not_claimed_to_cross() {
        let met = |value: f64, f: fn(f64) -> f64| {
            let xs = [0.0, 0.25, 0.5, 0.75, 1.0];
            let Search { found, steps } = search(&line(&xs, value), |x| ColumnValue::Value(f(x)));
            assert_eq!(steps, 0, "{found:?}");
            found
        };
        let met_at = |from, to, passage| [Discovery::Met { from, to, passage }];
        assert_eq!(met(0.0, |x| (x - 0.5).powi(2)), met_at(0.5, 0.5, Passage::Touches));
        assert_eq!(met(0.0, |x| x - 0.5), met_at(0.5, 0.5, Passage::Rises));
        assert_eq!(met(1.0, |x| (2.0 - 2.0 * x).clamp(0.9, 1.0)), met_at(0.0, 0.5, Passage::Meets));
        let plateau = |x: f64| {
            if (0.2..0.8).contains(&x) {
                4.0
            } else if x < 0.5 {
                5.0
            } else {
                3.0
            }
        };
        assert_eq!(met(4.0, plateau), met_at(0.25, 0.75, Passage::Falls));
        assert_eq!(met(3.0, |_| 3.0), met_at(0.0, 1.0, Passage::Meets));
        let flat = met(2.0, |_| 3.0);
        assert_eq!(flat, [Discovery::Apart { nearest: 0.0, value: 3.0, is_above: true }]);
    }

    #[test]
    fn intervals_beside_failed_jobs_stay_open() {
        let f = |x: f64| match x {
            0.5 => ColumnValue::Void,
            x => ColumnValue::Value(x - 0.4),
        };
        let Search { found, .. } = search(&line(&[0.0, 0.25, 0.5, 0.75], 0.0), f);
        let [Discovery::Open { from: Some(0.25), to: Some(0.75), reason, .. }] = found[..] else {
            panic!("{found:?}")
        };
        assert!(reason.starts_with("crosses between"), "{reason}");
        let Search { found, .. } = search(&line(&[0.3, 0.35, 0.5], 0.0), f);
        let [Discovery::Open { from: Some(0.35), to: None, reason, .. }] = found[..] else {
            panic!("{found:?}")
        };
        assert!(reason.starts_with("not known"), "{reason}");
        // A job that fails on the way leaves the bracket so far.
        let inner = |x: f64| match x {
            x if (0.39..0.41).contains(&x) => ColumnValue::Void,
            x => ColumnValue::Value((x - 0.4).powi(3)),
        };
        let Search { found, .. } = search(&line(&[0.0, 1.0], 0.0), inner);
        assert!(
            matches!(found[..], [Discovery::Open { values: [Some(_), Some(_)], .. }]),
            "{found:?}"
        );
        let all = search(&line(&[0.0, 1.0], 0.0), |_| ColumnValue::Void).found;
        assert!(matches!(all[..], [Discovery::Open { from: None, to: None, .. }]), "{all:?}");
    }
}
