//! The points that no other point beats: what is cheapest for its accuracy.

use std::fmt::Write;

use super::draw::{Canvas, Point, Segment};
use crate::axis::INK;
use crate::svg::{Drawing, n};

/// The points than which no other is both as small in x and in y (and smaller in one of them), by
/// their places in `points`, in order of x. Points that are not finite do not take part; of equal
/// points all or none are on the front.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&i| points[i].0.is_finite() && points[i].1.is_finite()).collect();
    // numbers and not their bits are compared: −0 is 0
    let by_value = |a: f64, b: f64| (a + 0.0).total_cmp(&(b + 0.0));
    order.sort_by(|&a, &b| {
        by_value(points[a].0, points[b].0).then(by_value(points[a].1, points[b].1))
    });
    let mut front: Vec<usize> = Vec::new();
    for i in order {
        if front
            .last()
            .is_none_or(|&last| points[i].1 < points[last].1 || points[i] == points[last])
        {
            front.push(i);
        }
    }
    front
}

/// How the stairs between the points of a front look.
const STAIRS: &str = r##"fill="none" stroke="#1a1a1a" stroke-width="0.9" stroke-dasharray="3 2""##;
pub(super) const RING: f64 = 6.0;

/// The stairs along the front, the least y that is reached at each x, as segments.
pub(super) fn stairs(canvas: &Canvas<'_>, front: &[Point]) -> Vec<Segment> {
    let places: Vec<(f64, f64)> = front.iter().filter_map(|&point| canvas.place(point)).collect();
    let steps = places.windows(2).flat_map(|pair| {
        let corner = (pair[1].0, pair[0].1);
        [(pair[0], corner), (corner, pair[1])]
    });
    steps.collect()
}

/// Joins the points of a front by stairs and puts a ring around each.
pub(super) fn draw(drawing: &mut Drawing, stairs: &[Segment], places: &[Point]) {
    let mut path = String::new();
    for (i, ((x1, y1), (x2, y2))) in stairs.iter().enumerate() {
        let start = if i == 0 { format!("M{} {}", n(*x1), n(*y1)) } else { String::new() };
        // Writing to a string does not fail.
        let _ = write!(path, "{start}L{} {}", n(*x2), n(*y2));
    }
    if !path.is_empty() {
        drawing.push(&format!(r#"<path d="{path}" {STAIRS}/>"#));
    }
    for &(x, y) in places {
        ring(drawing, x, y);
    }
}

fn ring(drawing: &mut Drawing, x: f64, y: f64) {
    drawing.push(&format!(
        r#"<circle cx="{}" cy="{}" r="{RING}" fill="none" stroke="{INK}" stroke-width="1.1"/>"#,
        n(x),
        n(y)
    ));
}

/// A stair with its ring, for the legend; `x` at the left, `y` in the middle.
pub(super) fn sample(drawing: &mut Drawing, x: f64, y: f64, width: f64) {
    drawing.push(&format!(r#"<path d="M{} {}h{}" {STAIRS}/>"#, n(x), n(y), n(width)));
    ring(drawing, x + width / 2.0, y);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_on_the_front_is_beaten_and_everything_else_is() {
        let points = [
            (3.0, 1.0),
            (1.0, 5.0),
            (2.0, 5.0),
            (2.0, 3.0),
            (3.0, 4.0),
            (4.0, 1.0),
            (f64::NAN, 0.0),
            (0.5, f64::INFINITY),
        ];
        assert_eq!(
            pareto_front(&points),
            [1, 3, 0],
            "as cheap but worse, or as good but dearer, is beaten"
        );
        let front = pareto_front(&points);
        let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
        for (i, &p) in points.iter().enumerate().filter(|(_, p)| p.0.is_finite() && p.1.is_finite())
        {
            assert_eq!(front.contains(&i), !points.iter().any(|&q| beats(q, p)), "{p:?}");
        }
        assert_eq!(
            pareto_front(&[(1.0, 1.0), (0.0, 2.0), (1.0, 1.0), (-0.0, 2.0)]),
            [1, 3, 0, 2],
            "equal ones"
        );
        assert!(pareto_front(&[]).is_empty());
    }
}
