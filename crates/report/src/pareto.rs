//! The Pareto front: the points that no other point beats, the cheapest for their accuracy.

/// Returns the points for which no other is as small in both x and y (and smaller in one of them),
/// as indices into `points`, in order of x.
///
/// Points that are not finite do not take part; of equal points all or none are on the front.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&i| points[i].0.is_finite() && points[i].1.is_finite()).collect();
    // Numbers and not their bits are compared: −0 is 0.
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
