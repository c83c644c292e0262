//! Narrows an interval in which a function changes its sign.
//!
//! The method is ITP (interpolate, truncate, project) of Oliveira & Takahashi, 2020, An
//! Enhancement of the Bisection Method Average Performance Preserving Minmax Optimality, ACM
//! Transactions on Mathematical Software 47, 5:1–24, doi:10.1145/3423597. Its projection lets no
//! function take more than three steps above bisection, with the rounding of abscissae. Here each
//! step is a job, `plan` says how many there can be, and columns that count elements are stairs:
//! Brent's method and Chandrupatla's alone bound the number of steps by a multiple of that of
//! bisection.
//!
//! The authors interpolate by a straight line, which stays on one side of the root where a
//! function is convex over a wide interval; the projection then makes of it no more than
//! bisection. So the interpolation here is inverse quadratic by the criterion of Chandrupatla,
//! 1997, Advances in Engineering Software 28, 145–149, doi:10.1016/S0965-9978(96)00051-8. Over
//! nineteen functions and tolerances of 1e-2, 1e-3 and 1e-6, as prototyped, straight lines took
//! 102, 134 and 227 steps, this 99, 118 and 198, bisection 133, 190 and 380; `1/x` to 1e-6 takes 7
//! steps in place of 21.
//!
//! The next abscissa follows from the values so far, so the search is the same whoever computes
//! them and however often it is begun again.

use super::column_value::ColumnValue;

/// A point of a function's curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GraphPoint {
    pub(super) x: f64,
    pub(super) y: f64,
}

/// An interval, with the values of a function at its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SignChange {
    pub(super) low: GraphPoint,
    pub(super) high: GraphPoint,
}

/// The end of an interval that the last step has replaced.
#[derive(Clone, Copy, Debug)]
struct ReplacedEnd {
    point: GraphPoint,
    /// True if it was the upper end.
    was_high: bool,
}

/// The reason why an interval is no longer narrowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NarrowingEnd {
    /// It is as short as it should be.
    Short,
    /// The next value is not known yet; so many steps may follow the next one.
    Pending { more: usize },
    /// The next point has no value.
    Void,
}

/// The search in one interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Narrowing {
    /// True if it goes by equal ratios in place of equal differences.
    is_log: bool,
    /// The length of a bracket that is short enough: relative to its upper end, or absolute.
    to: f64,
    is_relative: bool,
    /// The length that no bracket in this interval need fall below, as the search measures it: of
    /// logarithms, if it goes by ratios.
    tolerance: f64,
    /// The power of ten of which every abscissa is a multiple.
    exponent: i32,
    /// The length of the interval, as the search measures it.
    length: f64,
    /// The largest number of steps.
    steps: usize,
}

/// The part of the tolerance that the projection aims at. The rest is for the rounding of
/// abscissae, which takes less than a two-hundredth of the tolerance.
const AIM: f64 = 0.99;

/// The truncation κ₁ of the method, times the length of the interval; its exponent κ₂ is 2.
const TRUNCATION: f64 = 0.2;

/// The number of steps n₀ that the method may take more than bisection.
const SLACK: usize = 2;

/// The part of the tolerance that a step keeps from both ends of the interval.
const MARGIN: f64 = 0.25;

impl Narrowing {
    /// Returns the search between two values of an axis that spans a `range`, until a bracket is no
    /// longer than the part `to` of its upper end, or of the range if the interval begins at 0 or
    /// below.
    pub(super) fn new(low: f64, high: f64, is_log: bool, to: f64, range: f64) -> Self {
        let is_relative = low > 0.0;
        let to = if is_relative { to } else { to * range };
        // Every bracket ends above the lower end of the interval.
        let shortest = if is_relative { to * low } else { to };
        let (tolerance, length) = match is_log {
            true => (-(-to).ln_1p(), (high / low).ln()),
            false => (shortest, high - low),
        };
        let halvings = (length / (AIM * tolerance)).log2().ceil().max(0.0);
        let exponent = (shortest / 200.0).log10().floor() as i32;
        let steps = if halvings > 0.0 { halvings as usize + SLACK } else { 0 };
        Self { is_log, to, is_relative, tolerance, exponent, length, steps }
    }

    /// Returns the largest number of points that are evaluated.
    pub(super) fn steps(&self) -> usize {
        self.steps
    }

    /// Narrows the interval by what `evaluate` knows of the function, and says why it ends. An
    /// interval that ends at a root exactly has no length.
    ///
    /// # Errors
    /// A point cannot be evaluated.
    pub(super) fn narrow<E>(
        &self,
        change: &mut SignChange,
        mut evaluate: impl FnMut(f64) -> Result<ColumnValue, E>,
    ) -> Result<NarrowingEnd, E> {
        let mut replaced = None;
        for step in 0.. {
            let SignChange { low, high } = *change;
            let x = self.next(change, replaced, step);
            // Numbers have an end where an interval between neighbours cannot be divided.
            if self.is_short(change) || !(low.x < x && x < high.x) {
                break;
            }
            let y = match evaluate(x)? {
                ColumnValue::Value(y) => y,
                ColumnValue::Void => return Ok(NarrowingEnd::Void),
                ColumnValue::Pending => {
                    let more = self.steps.saturating_sub(step + 1);
                    return Ok(NarrowingEnd::Pending { more });
                }
            };
            let point = GraphPoint { x, y };
            if y == 0.0 {
                *change = SignChange { low: point, high: point };
            } else if (y > 0.0) == (high.y > 0.0) {
                change.high = point;
                replaced = Some(ReplacedEnd { point: high, was_high: true });
            } else {
                change.low = point;
                replaced = Some(ReplacedEnd { point: low, was_high: false });
            }
        }
        Ok(NarrowingEnd::Short)
    }

    /// Returns the root of the straight line through the ends of an interval, rounded as abscissae
    /// are.
    pub(super) fn root(&self, change: &SignChange) -> f64 {
        let root = self.rounded(self.value(self.secant(change)));
        root.clamp(change.low.x, change.high.x)
    }

    fn is_short(&self, SignChange { low, high }: &SignChange) -> bool {
        high.x - low.x <= self.to * if self.is_relative { high.x } else { 1.0 }
    }

    /// Returns a value of the axis as the search measures it.
    fn measure(&self, x: f64) -> f64 {
        if self.is_log { x.ln() } else { x }
    }

    fn value(&self, measure: f64) -> f64 {
        if self.is_log { measure.exp() } else { measure }
    }

    /// Returns the root of the straight line through the ends, as the search measures it.
    fn secant(&self, SignChange { low, high }: &SignChange) -> f64 {
        let (a, b) = (self.measure(low.x), self.measure(high.x));
        let part = low.y / (low.y - high.y);
        if part.is_finite() { a + (b - a) * part } else { 0.5 * (a + b) }
    }

    /// Returns the root of the function whose inverse is quadratic through both ends and the one
    /// that was replaced, as the search measures it. Where that would not be between them, or is
    /// not to be trusted, it is the middle.
    fn inverse_quadratic(&self, change: &SignChange, replaced: &ReplacedEnd) -> f64 {
        let SignChange { low, high } = *change;
        let (newest, other) = if replaced.was_high { (high, low) } else { (low, high) };
        let [x1, x2, x3] = [newest, other, replaced.point].map(|point| self.measure(point.x));
        let [f1, f2, f3] = [newest.y, other.y, replaced.point.y];
        let (xi, phi) = ((x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2));
        let is_trusted = phi * phi < xi && (1.0 - phi).powi(2) < 1.0 - xi;
        let part = f1 / (f2 - f1) * f3 / (f2 - f3)
            + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2);
        if is_trusted && part > 0.0 && part < 1.0 { x1 + part * (x2 - x1) } else { 0.5 * (x1 + x2) }
    }

    /// Returns the abscissa of a step, counted from 0.
    fn next(&self, change: &SignChange, replaced: Option<ReplacedEnd>, step: usize) -> f64 {
        let (a, b) = (self.measure(change.low.x), self.measure(change.high.x));
        let (middle, width) = (0.5 * (a + b), b - a);
        let interpolated = match replaced {
            Some(replaced) => self.inverse_quadratic(change, &replaced),
            None => self.secant(change),
        };
        // The sign of 0 is that of a number above it.
        let toward = (middle - interpolated).signum();
        let truncation = TRUNCATION / self.length * width * width;
        let truncated = match truncation <= (middle - interpolated).abs() {
            true => interpolated + toward * truncation,
            false => middle,
        };
        let left = self.steps.saturating_sub(step).min(1000) as i32;
        let reach = (0.5 * AIM * self.tolerance * 2f64.powi(left) - 0.5 * width).max(0.0);
        let projected = match (truncated - middle).abs() <= reach {
            true => truncated,
            false => middle - toward * reach,
        };
        let margin = (MARGIN * self.tolerance).min(0.5 * width);
        self.rounded(self.value(projected.clamp(a + margin, b - margin)))
    }

    /// Rounds a value to a decimal that is short and a small part of the tolerance away: the next
    /// job is then the same wherever the results so far agree but for their last digits.
    fn rounded(&self, x: f64) -> f64 {
        if x == 0.0 || !x.is_finite() {
            return x;
        }
        let digits = (x.abs().log10().floor() as i32 - self.exponent).clamp(0, 16) as usize;
        format!("{x:.digits$e}").parse::<f64>().unwrap_or(x) + 0.0
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    /// A search in an interval, and what it found.
    struct Search {
        change: SignChange,
        steps: usize,
        most: usize,
        halvings: usize,
    }

    fn search(f: impl Fn(f64) -> f64, [a, b]: [f64; 2], is_log: bool, to: f64) -> Search {
        let narrowing = Narrowing::new(a, b, is_log, to, b - a);
        let mut change =
            SignChange { low: GraphPoint { x: a, y: f(a) }, high: GraphPoint { x: b, y: f(b) } };
        let mut steps = 0;
        let end = narrowing.narrow(&mut change, |x| {
            assert!(a < x && x < b, "{x}");
            steps += 1;
            Ok::<_, Infallible>(ColumnValue::Value(f(x)))
        });
        assert_eq!(end, Ok(NarrowingEnd::Short));
        let (SignChange { low, high }, most) = (change, narrowing.steps());
        let length = to * if a > 0.0 { high.x } else { b - a };
        assert!(low == high || high.x - low.x <= length, "{change:?}");
        assert!(low == high && low.y == 0.0 || (low.y > 0.0) != (high.y > 0.0), "{change:?}");
        assert!(steps <= most, "{steps} > {most}");
        // The halvings of the whole interval until it is as short.
        let halvings = match is_log {
            true => ((b / a).ln() / -(-to).ln_1p()).log2().ceil(),
            false => ((b - a) / length).log2().ceil(),
        };
        Search { change, steps, most, halvings: halvings as usize }
    }

    /// A function that changes its sign between two values.
    struct SmoothFunction<'f> {
        f: &'f dyn Fn(f64) -> f64,
        ends: [f64; 2],
        is_log: bool,
    }

    #[test]
    fn smooth_functions_take_half_the_steps_of_bisection() {
        let linear = |f, ends| SmoothFunction { f, ends, is_log: false };
        let functions: [SmoothFunction<'_>; 8] = [
            linear(&|x| 1.0 / x - 3.0, [0.05, 0.8]),
            linear(&|x| 0.05 + (x - 0.6) * if x < 0.6 { 1.0 } else { 8.0 }, [0.0, 1.0]),
            linear(&|x| x.powi(3) - x - 2.0, [1.0, 2.0]),
            linear(&|x| x.exp() - 5.0, [0.0, 4.0]),
            linear(&|x| x.cos() - x, [0.0, 1.5]),
            linear(&|x| (50.0 * (x - 0.37)).atan(), [0.0, 1.0]),
            linear(&|x| 0.5 - (1.0 - x).powf(2.0 / 3.0), [0.0, 1.0]),
            SmoothFunction { f: &|x| x.powf(1.5) - 0.1, ends: [0.02, 1.0], is_log: true },
        ];
        for (i, SmoothFunction { f, ends, is_log }) in functions.iter().enumerate() {
            let Search { steps, halvings, .. } = search(f, *ends, *is_log, 1e-3);
            assert!(2 * steps <= halvings + 4, "{i}: {steps} and not {halvings}");
            let Search { steps, halvings, .. } = search(f, *ends, *is_log, 1e-6);
            assert!(2 * steps <= halvings + 1, "{i}: {steps} and not {halvings}");
        }
    }

    #[test]
    fn no_function_takes_more_than_three_steps_above_bisection() {
        let jump = |x: f64| if x < 0.3123 { -1.0 } else { 1e-9 };
        let stairs = |x: f64| (50.0 * x).round() / 50.0 - 0.401;
        let flat = |x: f64| (x - 0.3).powi(9);
        let root = |x: f64| (x - 0.3).signum() * (x - 0.3).abs().sqrt();
        let functions: [&dyn Fn(f64) -> f64; 4] = [&jump, &stairs, &flat, &root];
        for f in functions {
            for to in [0.1, 1e-2, 1e-3, 1e-6, 1e-9] {
                let Search { steps, most, halvings, .. } = search(f, [0.0, 1.0], false, to);
                assert!(steps <= most && most <= halvings + 3, "{to}: {steps}, {halvings}");
            }
        }
    }

    #[test]
    fn intervals_about_zero_and_next_to_it_have_an_end() {
        let Search { change, .. } = search(|x| x - 1e-9, [-1.0, 1.0], false, 1e-3);
        assert!(change.low.x <= 1e-9 && change.high.x >= 1e-9);
        let Search { change, .. } = search(|x| x + 1.0, [-3.0, -0.5], false, 1e-2);
        assert!(change.low.x <= -1.0 && change.high.x >= -1.0);
        // No numbers lie between the ends of the last bracket.
        search_to_the_end(|x| x * x - 2.0, [1.0, 2.0]);
    }

    fn search_to_the_end(f: impl Fn(f64) -> f64, [a, b]: [f64; 2]) {
        let narrowing = Narrowing::new(a, b, false, 1e-300, b - a);
        let mut change =
            SignChange { low: GraphPoint { x: a, y: f(a) }, high: GraphPoint { x: b, y: f(b) } };
        let end = narrowing.narrow(&mut change, |x| Ok::<_, Infallible>(ColumnValue::Value(f(x))));
        assert_eq!(end, Ok(NarrowingEnd::Short));
        assert!(change.high.x - change.low.x < 1e-13, "{change:?}");
    }

    #[test]
    fn abscissae_are_short_decimals() {
        let narrowing = Narrowing::new(0.1, 0.9, false, 1e-2, 0.8);
        let mut all = Vec::new();
        let mut change =
            SignChange { low: GraphPoint { x: 0.1, y: -0.2 }, high: GraphPoint { x: 0.9, y: 0.6 } };
        let noisy = |x: f64| x * (1.0 + 1e-13 * (1e5 * x).sin()) - 0.3;
        let end = narrowing.narrow(&mut change, |x| {
            all.push(x);
            Ok::<_, Infallible>(ColumnValue::Value(noisy(x)))
        });
        assert_eq!(end, Ok(NarrowingEnd::Short));
        assert!(!all.is_empty() && all.iter().all(|x| x.to_string().len() <= 8), "{all:?}");
    }

    #[test]
    fn what_is_missing_ends_the_search() {
        let narrowing = Narrowing::new(0.1, 0.9, false, 1e-3, 0.8);
        let start =
            SignChange { low: GraphPoint { x: 0.1, y: -0.2 }, high: GraphPoint { x: 0.9, y: 0.6 } };
        let mut change = start;
        let end = narrowing.narrow(&mut change, |_| Ok::<_, Infallible>(ColumnValue::Pending));
        assert_eq!(end, Ok(NarrowingEnd::Pending { more: narrowing.steps() - 1 }));
        let end = narrowing.narrow(&mut change, |_| Ok::<_, Infallible>(ColumnValue::Void));
        assert_eq!(end, Ok(NarrowingEnd::Void));
        assert_eq!(change, start);
        assert_eq!(narrowing.narrow(&mut change, |_| Err("no")), Err("no"));
    }
}
