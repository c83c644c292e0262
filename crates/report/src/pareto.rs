//! The Pareto front: the points that no other point beats, the cheapest for their accuracy.

/// Returns the points for which no other is as small in both x and y (and smaller in one of them),
/// as indices into `points`, in order of x.
///
/// Points that are not finite do not take part; of equal points all or none are on the front.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let exact: Vec<NoisyPoint> =
        points.iter().map(|&(x, y)| NoisyPoint { x, noise: 0.0, y }).collect();
    pareto_front_within(&exact)
}

/// A point whose x was measured with some noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NoisyPoint {
    /// The measured value.
    pub x: f64,
    /// The noise of x on either side, relative to x.
    pub noise: f64,
    /// The value of the other coordinate, which has no noise.
    pub y: f64,
}

impl NoisyPoint {
    /// Returns the ends of the interval that x may lie in.
    fn ends(&self) -> [f64; 2] {
        // Numbers and not their bits are compared: −0 is 0.
        [self.x - self.noise * self.x.abs(), self.x + self.noise * self.x.abs()].map(|x| x + 0.0)
    }

    /// Returns whether x of both cannot be told apart, since their intervals overlap.
    pub fn is_tied(&self, other: &NoisyPoint) -> bool {
        let ([low, high], [other_low, other_high]) = (self.ends(), other.ends());
        low <= other_high && other_low <= high
    }
}

/// Returns the points that no other one on the front beats, as indices into `points`, in order of
/// falling y and, for equal y, of x. Values of x that lie within the noise of each other are ties:
/// a point is beaten by one on the front that has a smaller y and no clearly larger x, and by any
/// that has an equal y and a clearly smaller x. What is left out is tied with a point of the front
/// or clearly beaten, since a chain of ties ends at the front and goes no further.
///
/// Points that are not finite do not take part; of equal points all or none are on the front.
pub fn pareto_front_within(points: &[NoisyPoint]) -> Vec<usize> {
    let is_finite = |&i: &usize| points[i].x.is_finite() && points[i].y.is_finite();
    let mut order: Vec<usize> = (0..points.len()).filter(is_finite).collect();
    let by_value = |a: f64, b: f64| (a + 0.0).total_cmp(&(b + 0.0));
    order.sort_by(|&a, &b| {
        by_value(points[a].y, points[b].y).then(by_value(points[a].x, points[b].x))
    });
    // The least lower end of the points of the front that are lower in y.
    let mut least = f64::INFINITY;
    let mut unbeaten: Vec<Vec<usize>> = Vec::new();
    for level in order.chunk_by(|&a, &b| by_value(points[a].y, points[b].y).is_eq()) {
        let ends = |i: usize| points[i].ends();
        let smallest = level.iter().map(|&i| ends(i)[1]).fold(f64::INFINITY, f64::min);
        let is_unbeaten = |&i: &usize| ends(i)[1] < least && ends(i)[0] <= smallest;
        let chosen: Vec<usize> = level.iter().copied().filter(is_unbeaten).collect();
        least = chosen.iter().map(|&i| ends(i)[0]).fold(least, f64::min);
        unbeaten.push(chosen);
    }
    unbeaten.into_iter().rev().flatten().collect()
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

    #[test]
    fn values_within_the_noise_of_each_other_are_ties() {
        let front = |points: &[(f64, f64, f64)]| {
            let noisy = points.iter().map(|&(x, noise, y)| NoisyPoint { x, noise, y });
            pareto_front_within(&noisy.collect::<Vec<_>>())
        };
        assert_eq!(
            front(&[(1.1, 0.1, 3.0), (1.0, 0.1, 3.0), (1.5, 0.1, 3.0)]),
            [1, 0],
            "of ties with one y none is beaten"
        );
        assert_eq!(
            front(&[(1.0, 0.1, 3.0), (1.1, 0.1, 2.0)]),
            [1],
            "what is not clearly dearer and better beats"
        );
        assert_eq!(front(&[(1.0, 0.1, 3.0), (1.3, 0.1, 2.0)]), [0, 1], "clearly dearer");
        assert_eq!(
            front(&[(1.0, 0.1, 3.0), (1.2, 0.1, 2.0), (1.4, 0.1, 1.0)]),
            [0, 2],
            "a chain of ties does not beat what is clearly cheaper than its end"
        );
        let of = |x, noise| NoisyPoint { x, noise, y: 0.0 };
        assert!(of(1.0, 0.1).is_tied(&of(1.2, 0.1)) && !of(1.0, 0.0).is_tied(&of(1.2, 0.1)));
    }
}
