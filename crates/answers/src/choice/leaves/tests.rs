use std::convert::Infallible;

use super::*;

/// The points that were added, and why there are no more.
struct Filled {
    leaves: Leaves,
    added: usize,
    generations: usize,
    end: FillingEnd,
}

const NOISE: f64 = 1e-8;

/// Fills a function of two variables on equal steps from 0 to 1, in generations as a study does: the
/// values of one are known before the next is chosen.
fn filled(
    steps: [usize; 2],
    to: Option<f64>,
    at_most: usize,
    f: impl Fn(f64, f64) -> ColumnValue,
) -> Filled {
    let values =
        steps.map(|n| (0..n).map(|i| i as f64 / (n.max(2) - 1) as f64).collect::<Vec<_>>());
    let given = [&values[0][..], &values[1][..]];
    let mut known = std::collections::BTreeSet::new();
    for generations in 0.. {
        let mut leaves = Leaves::new(given);
        let probe = leaves.clone();
        let mut wanted = Vec::new();
        let end = leaves.fill(&FillingEnds { to, at_most, noise: NOISE }, |place| {
            if !known.contains(&place) {
                wanted.push(place);
                return Ok::<_, Infallible>(ColumnValue::Pending);
            }
            let [x, y] = [0, 1].map(|axis| probe.measure(axis, place[axis]));
            Ok(f(x, y))
        });
        let Ok(end) = end;
        if end != FillingEnd::Pending {
            let added = known.len() - steps[0] * steps[1];
            assert_eq!(known.len(), leaves.values.len(), "nothing is computed for nothing");
            assert!(added <= at_most);
            return Filled { leaves, added, generations, end };
        }
        known.extend(wanted);
    }
    unreachable!()
}

fn curve(n: usize, to: Option<f64>, at_most: usize, f: impl Fn(f64) -> f64) -> Filled {
    filled([n, 1], to, at_most, |x, _| ColumnValue::Value(f(x)))
}

/// Returns the largest distance of a function from the lines between its points, relative to its
/// range.
fn distance(filled: &Filled, f: impl Fn(f64) -> f64) -> f64 {
    let points: Vec<(f64, f64)> = filled
        .leaves
        .values
        .iter()
        .map(|(place, value)| (filled.leaves.measure(0, place[0]), value.value().unwrap()))
        .collect();
    let off = points.windows(2).flat_map(|pair| {
        let [(a, ya), (b, yb)] = [pair[0], pair[1]];
        let f = &f;
        (0..=20).map(move |i| {
            let t = f64::from(i) / 20.0;
            (f(a + (b - a) * t) - (ya + (yb - ya) * t)).abs()
        })
    });
    off.fold(0.0, f64::max) / filled.leaves.range()
}

#[test]
fn curves_are_as_near_as_asked() {
    let functions: [fn(f64) -> f64; 5] = [
        |x| (6.0 * x).sin(),
        |x| 1.0 / (1.0 + 400.0 * (x - 0.3).powi(2)),
        |x| (40.0 * (x - 0.6)).tanh(),
        |x| (x - 0.37).abs(),
        |x| (x + 0.01).sqrt(),
    ];
    for (i, f) in functions.into_iter().enumerate() {
        let mut before = 0;
        for to in [0.1, 0.01, 0.001] {
            let filled = curve(9, Some(to), 1000, f);
            // The estimate may be half of what is true at a kink, and less at a steep end.
            let distance = distance(&filled, f);
            assert!(distance <= 2.5 * to, "{i}: {distance} > {to}");
            assert!(filled.leaves.deviation().unwrap() <= to || filled.end == FillingEnd::Steep);
            assert!(filled.added >= before && filled.added < 150, "{i}: {}", filled.added);
            assert!(filled.generations < 16, "{i}: {}", filled.generations);
            before = filled.added;
        }
    }
}

#[test]
fn points_stand_where_the_curve_bends() {
    let f = |x: f64| (60.0 * (x - 0.6)).tanh();
    let filled = curve(11, Some(0.01), 1000, f);
    let equal = (1..).find(|n| distance(&curve(11 * n, None, 1, f), f) <= 0.02).unwrap();
    assert!(2 * (11 + filled.added) < 11 * equal, "{} and not {}", 11 + filled.added, 11 * equal);
    let bent = filled.leaves.values.keys().map(|place| filled.leaves.measure(0, place[0]));
    let near = bent.filter(|x| (x - 0.6).abs() < 0.15).count();
    assert!(near > filled.added / 2, "{near} of {}", filled.added);
}

#[test]
fn a_jump_is_found_to_a_part_of_the_axis() {
    let f = |x: f64| if x < 0.3123 { 0.0 } else { 1.0 };
    let filled = curve(6, Some(0.01), 1000, f);
    assert_eq!(filled.end, FillingEnd::Steep);
    let below = filled.leaves.values.iter().filter(|(_, value)| value.value() == Some(0.0));
    let last = below.map(|(place, _)| filled.leaves.measure(0, place[0])).fold(0.0, f64::max);
    assert!(last < 0.3123 && last > 0.3023, "{last}");
    assert!(filled.added < 30, "{}", filled.added);
}

#[test]
fn flat_functions_and_straight_lines_get_few_points() {
    let flat = curve(5, Some(0.01), 1000, |x| 3.0 + 1e-12 * (50.0 * x).sin());
    assert_eq!((flat.added, flat.end), (2, FillingEnd::Flat));
    let flat = curve(5, None, 40, |_| 0.0);
    assert_eq!((flat.added, flat.end), (2, FillingEnd::Flat));
    let line = curve(5, Some(0.01), 1000, |x| 2.0 * x + 1.0);
    assert_eq!((line.added, line.end), (2, FillingEnd::Smooth));
    // A curve that bends in its first interval alone.
    let hidden = curve(4, Some(0.01), 1000, |x| if x < 0.2 { 0.0 } else { 1.0 - 0.2 / x });
    assert!(distance(&hidden, |x| if x < 0.2 { 0.0 } else { 1.0 - 0.2 / x }) < 0.02);
    // Two points tell of no bend; the middle between them does.
    let two = curve(2, Some(0.01), 1000, |x| (std::f64::consts::PI * x).sin());
    assert!(two.added > 5 && two.end == FillingEnd::Smooth, "{}", two.added);
    let two = curve(2, Some(0.01), 1000, |x| x);
    assert_eq!((two.added, two.end), (1, FillingEnd::Smooth));
}

#[test]
fn a_count_is_kept_and_goes_where_it_helps_most() {
    let f = |x: f64| (60.0 * (x - 0.6)).tanh();
    for at_most in [1, 2, 7, 40] {
        let filled = curve(6, None, at_most, f);
        assert_eq!((filled.added, filled.end), (at_most, FillingEnd::Full));
    }
    let few = curve(11, Some(0.001), 20, f);
    assert_eq!((few.added, few.end), (20, FillingEnd::Full));
    assert!(distance(&few, f) < 0.25 * distance(&curve(31, None, 1, f), f));
    // A jump does not take all of them.
    let jump = |x: f64| if x < 0.2 { 0.0 } else { (8.0 * x).sin() };
    let filled = curve(6, None, 40, jump);
    let beyond = filled.leaves.values.keys().map(|place| filled.leaves.measure(0, place[0]));
    assert!(beyond.filter(|x| *x > 0.3).count() > 15);
}

#[test]
fn beside_a_point_without_a_value_nothing_is_added() {
    let f = |x: f64, _: f64| match x {
        0.5 => ColumnValue::Void,
        x => ColumnValue::Value((9.0 * x).sin()),
    };
    let filled = filled([5, 1], Some(0.01), 1000, f);
    assert_eq!(filled.end, FillingEnd::Void);
    let places = filled.leaves.values.keys().map(|place| filled.leaves.measure(0, place[0]));
    let (beside, apart): (Vec<f64>, Vec<f64>) = places.partition(|x| (0.25..=0.75).contains(x));
    assert_eq!(beside, [0.25, 0.5, 0.75]);
    assert!(apart.len() > 10);
}

#[test]
fn maps_bend_along_the_axis_that_bends_them() {
    let count = |filled: &Filled, axis: usize| {
        let places: std::collections::BTreeSet<u64> =
            filled.leaves.values.keys().map(|place| place[axis]).collect();
        places.len()
    };
    let value = ColumnValue::Value;
    let along_x = filled([5, 5], Some(0.01), 1000, |x, y| value((6.0 * x).sin() + 0.5 * y));
    assert_eq!((count(&along_x, 1), along_x.end), (5, FillingEnd::Smooth));
    assert!(count(&along_x, 0) > 10);
    let twisted = filled([5, 5], Some(0.01), 1000, |x, y| value(x * y));
    assert_eq!(twisted.added, 0, "cells are interpolated between four corners");
    let ridge = |x: f64, y: f64| (20.0 * (x + y - 0.9)).tanh();
    let filled = filled([5, 5], Some(0.02), 2000, |x, y| value(ridge(x, y)));
    assert_eq!(filled.end, FillingEnd::Smooth);
    // The cells that are left interpolate it.
    let leaves = &filled.leaves;
    let mut worst = 0.0_f64;
    for leaf in &leaves.leaves {
        let at = |axis: usize, part: f64| {
            leaves.measure(axis, leaf.low[axis]) + part * leaves.length(leaf, axis)
        };
        let corner = |t: f64, u: f64| ridge(at(0, t), at(1, u));
        for (t, u) in [0.25, 0.5, 0.75].into_iter().flat_map(|t| [0.25, 0.5, 0.75].map(|u| (t, u)))
        {
            let low = corner(0.0, 0.0) * (1.0 - t) + corner(1.0, 0.0) * t;
            let high = corner(0.0, 1.0) * (1.0 - t) + corner(1.0, 1.0) * t;
            worst = worst.max((corner(t, u) - low * (1.0 - u) - high * u).abs() / leaves.range());
        }
    }
    assert!(worst < 0.06, "{worst}");
    let at_ridge = leaves.values.keys().filter(|place| {
        let [x, y] = [0, 1].map(|axis| leaves.measure(axis, place[axis]));
        (x + y - 0.9).abs() < 0.2
    });
    assert!(2 * at_ridge.count() > leaves.values.len());
}
