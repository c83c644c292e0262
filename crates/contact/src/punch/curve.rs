//! Smooth plane curves through points: the natural cubic spline over the chord length.

/// A curve that passes through given points with continuous curvature. Its parameter is the length
/// of the polygon through the points \[m\], which is the arc length up to the error of the polygon.
/// So the curve may turn back over either axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    parameters: Vec<f64>,
    points: Vec<[f64; 2]>,
    /// The second derivatives at the points \[1/m\].
    bends: Vec<[f64; 2]>,
}

/// A point of a [`Curve`] with its derivatives with respect to the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CurvePoint {
    /// The position (y, z) \[m\].
    pub position: [f64; 2],
    /// The tangent (y, z), whose length is 1 up to the difference between chord and arc.
    pub tangent: [f64; 2],
    /// The second derivative (y, z) \[1/m\].
    pub bend: [f64; 2],
}

impl CurvePoint {
    /// Returns the signed curvature \[1/m\], which is positive where the curve turns from y towards
    /// z.
    pub(crate) fn curvature(&self) -> f64 {
        let [y, z] = self.tangent;
        (y * self.bend[1] - z * self.bend[0]) / y.hypot(z).powi(3)
    }

    /// Returns the inclination of the tangent \[rad\], from y towards z.
    pub(crate) fn angle(&self) -> f64 {
        self.tangent[1].atan2(self.tangent[0])
    }
}

impl Curve {
    /// Creates the curve through `points` (y, z) \[m\] in their order. It is `None` if there are
    /// fewer than three points, if one is not finite, or if neighbours coincide.
    pub(crate) fn through(points: Vec<[f64; 2]>) -> Option<Self> {
        let count = points.len();
        if count < 3 || !points.iter().flatten().all(|v| v.is_finite()) {
            return None;
        }
        let mut parameters = vec![0.0; count];
        for i in 1..count {
            let chord = (points[i][0] - points[i - 1][0]).hypot(points[i][1] - points[i - 1][1]);
            parameters[i] = parameters[i - 1] + chord;
            if !(parameters[i].is_finite() && parameters[i] > parameters[i - 1]) {
                return None;
            }
        }
        let bends = second_derivatives(&parameters, &points);
        bends.iter().flatten().all(|v| v.is_finite()).then_some(Self { parameters, points, bends })
    }

    /// Returns the points (y, z) \[m\] that the curve passes through.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Returns the parameters \[m\] of the points, ascending from 0.
    #[cfg(test)]
    pub(crate) fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// Returns the largest parameter \[m\].
    pub(crate) fn length(&self) -> f64 {
        self.parameters[self.parameters.len() - 1]
    }

    /// Returns the point at a parameter \[m\], which is clamped to the range of the curve.
    pub(crate) fn at(&self, parameter: f64) -> CurvePoint {
        let t = parameter.clamp(0.0, self.length());
        let right = self.parameters.partition_point(|&p| p <= t).clamp(1, self.points.len() - 1);
        let left = right - 1;
        let h = self.parameters[right] - self.parameters[left];
        let (a, b) = ((self.parameters[right] - t) / h, (t - self.parameters[left]) / h);
        let (p, q, m, n) =
            (self.points[left], self.points[right], self.bends[left], self.bends[right]);
        // Profiles are evaluated some hundred thousand times for one scene.
        let sag = h * h / 6.0 * (a * b);
        let (of_m, of_n) = (sag * (1.0 + a), sag * (1.0 + b));
        let (slope_m, slope_n) = (h / 6.0 * (3.0 * a * a - 1.0), h / 6.0 * (3.0 * b * b - 1.0));
        CurvePoint {
            position: [0, 1].map(|c| a * p[c] + b * q[c] - (of_m * m[c] + of_n * n[c])),
            tangent: [0, 1].map(|c| (q[c] - p[c]) / h + slope_n * n[c] - slope_m * m[c]),
            bend: [0, 1].map(|c| a * m[c] + b * n[c]),
        }
    }

    /// Returns the curve with the sign of y changed, followed from its other end.
    pub(crate) fn mirrored(&self) -> Self {
        let length = self.length();
        let turned = |values: &[[f64; 2]]| values.iter().rev().map(|v| [-v[0], v[1]]).collect();
        Self {
            parameters: self.parameters.iter().rev().map(|t| length - t).collect(),
            points: turned(&self.points),
            bends: turned(&self.bends),
        }
    }

    /// Returns the curve moved by (y, z) \[m\].
    pub(crate) fn shifted(mut self, by: [f64; 2]) -> Self {
        self.points.iter_mut().for_each(|p| *p = [p[0] + by[0], p[1] + by[1]]);
        self
    }

    /// Returns parameters \[m\] that cut the curve into `pieces` equal steps between neighbouring
    /// given points, both ends included.
    pub(crate) fn samples(&self, pieces: usize) -> Vec<f64> {
        let mut samples: Vec<f64> = self
            .parameters
            .windows(2)
            .flat_map(|ends| {
                (0..pieces).map(move |i| ends[0] + (ends[1] - ends[0]) * i as f64 / pieces as f64)
            })
            .collect();
        samples.push(self.length());
        samples
    }
}

/// Computes the second derivatives of the natural cubic spline by elimination in the tridiagonal
/// system, which is diagonally dominant and needs no pivots.
fn second_derivatives(parameters: &[f64], points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let count = points.len();
    let step = |i: usize| parameters[i + 1] - parameters[i];
    let slope = |i: usize, c: usize| (points[i + 1][c] - points[i][c]) / step(i);
    let mut bends = vec![[0.0; 2]; count];
    let mut upper = vec![0.0; count];
    for i in 1..count - 1 {
        let diagonal = 2.0 * (step(i - 1) + step(i)) - step(i - 1) * upper[i - 1];
        upper[i] = step(i) / diagonal;
        bends[i] = [0, 1].map(|c| {
            (6.0 * (slope(i, c) - slope(i - 1, c)) - step(i - 1) * bends[i - 1][c]) / diagonal
        });
    }
    for i in (1..count - 1).rev() {
        bends[i] = [0, 1].map(|c| bends[i][c] - upper[i] * bends[i + 1][c]);
    }
    bends
}

/// The section of a curve that advances along a direction, and so is a graph over it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Graph {
    curve: Curve,
    direction: [f64; 2],
    /// Pairs of the distance along the direction and the parameter \[m\], both ascending.
    samples: Vec<[f64; 2]>,
}

impl Graph {
    /// Creates the section of `curve` around its parameter `around` that advances along the unit
    /// vector `direction`. It is empty if the curve does not advance there.
    pub(crate) fn new(curve: &Curve, direction: [f64; 2], around: f64) -> Self {
        let along = |v: [f64; 2]| v[0] * direction[0] + v[1] * direction[1];
        let advances = |t: &f64| along(curve.at(*t).tangent) > 0.0;
        let all = curve.samples(4);
        let middle = all.partition_point(|&t| t < around);
        let first = all[..middle].iter().rposition(|t| !advances(t)).map_or(0, |i| i + 1);
        let last =
            all[middle..].iter().position(|t| !advances(t)).map_or(all.len(), |i| middle + i);
        let mut samples: Vec<[f64; 2]> = Vec::with_capacity(last.saturating_sub(first));
        for &t in &all[first..last.max(first)] {
            let distance = along(curve.at(t).position);
            if samples.last().is_none_or(|[before, _]| distance > *before) {
                samples.push([distance, t]);
            }
        }
        Self { curve: curve.clone(), direction, samples }
    }

    /// Returns the smallest and the largest distance along the direction \[m\].
    pub(crate) fn range(&self) -> Option<[f64; 2]> {
        Some([self.samples.first()?[0], self.samples.last()?[0]])
    }

    /// Returns the parameter at a `distance` along the direction \[m\], or `None` beyond the ends.
    pub(crate) fn parameter(&self, distance: f64) -> Option<f64> {
        let right = self.samples.partition_point(|sample| sample[0] < distance);
        let end = self.samples.get(right)?;
        if right == 0 {
            return (end[0] == distance).then_some(end[1]);
        }
        let start = self.samples[right - 1];
        // Newton's method runs between two samples and halves the interval where it would leave it.
        let (mut low, mut high) = (start[1], end[1]);
        let mut t = low + (high - low) * (distance - start[0]) / (end[0] - start[0]);
        for _ in 0..60 {
            let point = self.curve.at(t);
            let excess = self.along(point.position) - distance;
            if excess > 0.0 {
                high = t;
            } else {
                low = t;
            }
            let newton = t - excess / self.along(point.tangent);
            let next = if (low..=high).contains(&newton) { newton } else { 0.5 * (low + high) };
            // The error after a step of Newton's is the square of the step times the curvature.
            let is_near = next == newton && (next - t).abs() <= 1e-10;
            if excess == 0.0 || is_near || high - low <= 1e-16 * (1.0 + t.abs()) {
                return Some(next.clamp(start[1], end[1]));
            }
            t = next;
        }
        Some(t)
    }

    /// Returns the point at a `distance` along the direction \[m\], or `None` beyond the ends.
    pub(crate) fn at(&self, distance: f64) -> Option<CurvePoint> {
        self.parameter(distance).map(|t| self.curve.at(t))
    }

    fn along(&self, v: [f64; 2]) -> f64 {
        v[0] * self.direction[0] + v[1] * self.direction[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns points of an arc of radius `radius` around (0, 0).
    fn arc(radius: f64, from: f64, to: f64, count: usize) -> Vec<[f64; 2]> {
        let angle = |i: usize| from + (to - from) * i as f64 / (count - 1) as f64;
        (0..count).map(|i| [radius * angle(i).cos(), radius * angle(i).sin()]).collect()
    }

    #[test]
    fn a_circle_keeps_its_radius_and_curvature_at_fourth_and_second_order() {
        let radius = 0.3;
        let errors: Vec<[f64; 2]> = [40, 80, 160]
            .map(|count| {
                let curve = Curve::through(arc(radius, 0.2, 4.0, count)).unwrap();
                // The ends are left out, for the natural spline is straight there.
                let middle: Vec<CurvePoint> = (0..101)
                    .map(|i| curve.at(curve.length() * (0.3 + 0.004 * f64::from(i))))
                    .collect();
                let off = |f: &dyn Fn(&CurvePoint) -> f64| middle.iter().map(f).fold(0.0, f64::max);
                [
                    off(&|p| (p.position[0].hypot(p.position[1]) / radius - 1.0).abs()),
                    off(&|p| (p.curvature() * radius - 1.0).abs()),
                ]
            })
            .to_vec();
        for pair in errors.windows(2) {
            assert!(pair[0][0] / pair[1][0] > 12.0, "{errors:?}");
            assert!(pair[0][1] / pair[1][1] > 3.0, "{errors:?}");
        }
        assert!(errors[2][0] < 1e-8 && errors[2][1] < 2e-3, "{errors:?}");
    }

    #[test]
    fn passes_through_its_points_with_continuous_derivatives() {
        let points = vec![[0.0, 0.0], [1.0, 0.5], [1.2, 1.5], [0.3, 1.7], [-0.5, 1.0], [0.1, 0.9]];
        let curve = Curve::through(points.clone()).unwrap();
        for (&t, point) in curve.parameters().iter().zip(&points) {
            let (below, above) = (curve.at(t - 1e-9), curve.at(t + 1e-9));
            for (c, expected) in point.iter().enumerate() {
                assert!((curve.at(t).position[c] - expected).abs() < 1e-14);
                assert!((below.tangent[c] - above.tangent[c]).abs() < 1e-6);
                assert!((below.bend[c] - above.bend[c]).abs() < 1e-6);
                let slope =
                    (curve.at(t + 1e-6).position[c] - curve.at(t - 1e-6).position[c]) / 2e-6;
                assert!(
                    t == 0.0
                        || t == curve.length()
                        || (slope - curve.at(t).tangent[c]).abs() < 1e-7
                );
            }
        }
        assert_eq!(curve.at(-1.0), curve.at(0.0));
        assert_eq!(curve.at(99.0), curve.at(curve.length()));
    }

    #[test]
    fn straight_points_make_a_straight_line() {
        let curve =
            Curve::through((0..5).map(|i| [f64::from(i * i), 2.0 * f64::from(i * i)]).collect())
                .unwrap();
        let point = curve.at(0.37 * curve.length());
        assert!(
            (point.position[1] / point.position[0] - 2.0).abs() < 1e-14
                && point.curvature().abs() < 1e-14
        );
        assert!((point.angle() - 2f64.atan()).abs() < 1e-14);
    }

    #[test]
    fn refuses_what_is_no_curve() {
        assert_eq!(Curve::through(vec![[0.0, 0.0], [1.0, 0.0]]), None);
        assert_eq!(Curve::through(vec![[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]]), None);
        assert_eq!(Curve::through(vec![[0.0, 0.0], [f64::NAN, 0.0], [1.0, 0.0]]), None);
    }

    #[test]
    fn a_graph_is_the_part_that_advances() {
        // On the way from 0.2 to 4.0 around a circle, −x advances between 0 and π.
        let curve = Curve::through(arc(1.0, 0.2, 4.0, 200)).unwrap();
        let graph = Graph::new(&curve, [-1.0, 0.0], 1.0);
        let [low, high] = graph.range().unwrap();
        assert!((low + 0.2f64.cos()).abs() < 1e-12 && (high - 1.0).abs() < 1e-4 && high < 1.0);
        for x in [-0.9, -0.3, 0.0, 0.77, 0.99] {
            let point = graph.at(x).unwrap();
            assert!(
                (point.position[0] + x).abs() < 1e-14
                    && (point.position[1] - (1.0 - x * x).sqrt()).abs() < 1e-8,
                "{x}: {point:?}"
            );
        }
        assert_eq!((graph.at(1.1), graph.at(-0.99)), (None, None));
        assert_eq!(Graph::new(&curve, [1.0, 0.0], 1.0).range(), None);
    }
}
