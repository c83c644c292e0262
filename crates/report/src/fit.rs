//! Straight lines through the points of a curve, for the slopes that a figure shows.

/// A straight line through points by least squares, as it lies on the axes of a figure. On a
/// logarithmic axis x stands for log₁₀ x, and y likewise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The rise of y over x: the exponent of a power law, or decades over the unit of x if y alone
    /// is logarithmic.
    pub slope: f64,
    /// The standard error of the slope, from the scatter of the points about the line, with points
    /// − 2 as the degrees of freedom.
    pub standard_error: f64,
    /// The value of y at x = 0, or at x = 1 on a logarithmic axis; log₁₀ y if y is logarithmic.
    pub intercept: f64,
    /// The least x that the line was fitted to.
    pub from: f64,
    /// The largest x that the line was fitted to.
    pub to: f64,
    /// The number of points that the line was fitted to.
    pub points: usize,
    /// True if x is logarithmic.
    pub log_x: bool,
    /// True if y is logarithmic.
    pub log_y: bool,
}

/// The largest difference between the slopes at the ends of a run, relative to the steeper one,
/// that a reader takes for one slope.
const STRAIGHT: f64 = 0.1;
/// The largest slope: no physical quantity has a larger one, and written in another unit it might
/// overflow.
const LARGEST: f64 = 1e200;
/// The largest such difference in a piece of a curve that bends as a whole.
const NEARLY_STRAIGHT: f64 = 0.2;
/// Values of Student's t for a probability of 95 % on both sides, for 1, 2, … degrees of freedom.
const STUDENT: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];

/// Fits the power law y = 10^intercept · x^slope to the straight part of a curve; the same as
/// [`straight`] on logarithmic axes.
pub fn power_law(points: &[(f64, f64)]) -> Option<Fit> {
    straight(points, true, true)
}

/// Fits a line to the straight part of a curve. Returns `None` if the curve has no straight part of
/// three points with different x.
///
/// Points without a place on the axes are left out. All others enter unless they clearly bend:
/// unless the slopes at the two ends of the parabola through them differ by more than a tenth of
/// the steeper one, and by more than scatter explains (95 %). Then points are dropped one by one,
/// each time the first or the last, whichever leaves the rest with less of a bend, until the rest
/// does not clearly bend and its slopes differ by no more than a fifth. This leaves out points that
/// are not yet asymptotic as well as a floor of rounding, and keeps every point of a curve that
/// merely scatters: its standard error says so.
pub fn straight(points: &[(f64, f64)], log_x: bool, log_y: bool) -> Option<Fit> {
    let place = |x: f64, log: bool| if log { x.log10() } else { x };
    let placed = |&(x, y): &(f64, f64)| (place(x, log_x), place(y, log_y));
    let finite = |point: &&(f64, f64)| {
        let (x, y) = placed(point);
        x.is_finite() && y.is_finite()
    };
    let mut sorted: Vec<(f64, f64)> = points.iter().filter(finite).copied().collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let on_axes: Vec<(f64, f64)> = sorted.iter().map(placed).collect();

    let mut run = FittedRun::new(&on_axes, 0, on_axes.len())?;
    while run.parabola.clearly_bends()
        || (run.end - run.first < on_axes.len() && run.parabola.bends(NEARLY_STRAIGHT))
    {
        let without_first = FittedRun::new(&on_axes, run.first + 1, run.end);
        let without_last = FittedRun::new(&on_axes, run.first, run.end - 1);
        run = match (without_first, without_last) {
            (Some(one), Some(other)) => {
                let straighter = one.parabola.bend().abs() <= other.parabola.bend().abs();
                Some(if straighter { one } else { other })
            }
            (one, other) => one.or(other),
        }?;
    }
    let FittedRun { first, end, parabola } = run;
    let Parabola { slope, standard_error, intercept, .. } = parabola;
    let fit = Fit {
        slope,
        standard_error,
        intercept,
        from: sorted[first].0,
        to: sorted[end - 1].0,
        points: end - first,
        log_x,
        log_y,
    };
    [slope, standard_error, intercept].iter().all(|x| x.abs() < LARGEST).then_some(fit)
}

impl Fit {
    /// Returns the ordinate of the line at an abscissa, both as values and not as logarithms.
    pub fn at(&self, x: f64) -> f64 {
        let y = self.intercept + self.slope * if self.log_x { x.log10() } else { x };
        if self.log_y { 10f64.powf(y) } else { y }
    }
}

/// Some neighbouring points of a curve in order of x, from `first` to before `end`, and the
/// parabola through them.
struct FittedRun {
    first: usize,
    end: usize,
    parabola: Parabola,
}

impl FittedRun {
    fn new(points: &[(f64, f64)], first: usize, end: usize) -> Option<FittedRun> {
        Some(FittedRun { first, end, parabola: Parabola::through(&points[first..end])? })
    }
}

/// The line and the parabola through some points by least squares.
struct Parabola {
    slope: f64,
    standard_error: f64,
    intercept: f64,
    /// The slopes of the parabola at the first and the last point.
    slopes: [f64; 2],
    /// The error of the difference of the two slopes (95 %).
    error_of_bend: f64,
}

impl Parabola {
    /// Fits both to points in order of x. Returns `None` without three different x.
    fn through(points: &[(f64, f64)]) -> Option<Parabola> {
        let [first, .., last] = points else { return None };
        if !points.iter().any(|p| first.0 < p.0 && p.0 < last.0) {
            return None;
        }
        let count = points.len() as f64;
        let sum =
            |term: &dyn Fn(f64, f64) -> f64| points.iter().map(|&(x, y)| term(x, y)).sum::<f64>();
        let (mean_x, mean_y) = (sum(&|x, _| x) / count, sum(&|_, y| y) / count);
        // Three polynomials that are orthogonal on the points: 1, u and q(u) = u² − a·u − b, with u
        // = x − mean.
        let squares = sum(&|x, _| (x - mean_x).powi(2));
        let slope = sum(&|x, y| (x - mean_x) * (y - mean_y)) / squares;
        let (a, b) = (sum(&|x, _| (x - mean_x).powi(3)) / squares, squares / count);
        let q = |x: f64| (x - mean_x) * (x - mean_x - a) - b;
        let squares_of_q = sum(&|x, _| q(x).powi(2));
        let curvature = sum(&|x, y| q(x) * (y - mean_y)) / squares_of_q;
        let beside_line = sum(&|x, y| (y - mean_y - slope * (x - mean_x)).powi(2));
        let beside_parabola =
            sum(&|x, y| (y - mean_y - slope * (x - mean_x) - curvature * q(x)).powi(2));
        let error_of_curvature = match points.len() {
            // Through three points there always is a parabola.
            3 => f64::INFINITY,
            n => {
                (beside_parabola / (n - 3) as f64 / squares_of_q).sqrt()
                    * STUDENT.get(n - 4).copied().unwrap_or(2.0)
            }
        };
        Some(Parabola {
            slope,
            standard_error: (beside_line / (count - 2.0) / squares).sqrt(),
            intercept: mean_y - slope * mean_x,
            slopes: [first.0, last.0].map(|x| slope + curvature * (2.0 * (x - mean_x) - a)),
            error_of_bend: 2.0 * (last.0 - first.0) * error_of_curvature,
        })
    }

    /// Returns the difference of the slopes at the ends of the parabola.
    fn bend(&self) -> f64 {
        self.slopes[1] - self.slopes[0]
    }

    /// Says whether the slopes at both ends differ by more than a share of the steeper one.
    fn bends(&self, share: f64) -> bool {
        self.bend().abs() > share * self.slopes[0].abs().max(self.slopes[1].abs())
    }

    /// Says whether a reader would see more than one slope, and not because the points scatter.
    fn clearly_bends(&self) -> bool {
        self.bends(STRAIGHT) && self.bend().abs() > self.error_of_bend
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MESHES: [f64; 7] = [4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0];

    fn on(law: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        MESHES.iter().map(|&n| (n, law(n))).collect()
    }

    /// Returns slope, standard error, range and number of points of the power law, rounded for the
    /// comparison.
    fn fitted(points: &[(f64, f64)]) -> Option<(String, f64, f64, usize)> {
        power_law(points).map(|fit| {
            (format!("{:.3} ± {:.3}", fit.slope, fit.standard_error), fit.from, fit.to, fit.points)
        })
    }

    #[test]
    fn a_power_law_is_found_whatever_the_order_of_its_points() {
        let mut points = on(|n| 3.0 / n.sqrt());
        points.reverse();
        points.extend([(0.0, 1.0), (512.0, f64::NAN), (1024.0, -1.0), (f64::INFINITY, 1.0)]);
        let fit = power_law(&points).unwrap();
        assert!((fit.slope + 0.5).abs() < 1e-14 && fit.standard_error < 1e-14, "{fit:?}");
        assert!(
            (fit.intercept - 3f64.log10()).abs() < 1e-14 && (fit.at(100.0) - 0.3).abs() < 1e-14,
            "{fit:?}"
        );
        assert_eq!((fit.from, fit.to, fit.points), (4.0, 256.0, 7));
    }

    /// By hand: the slope through (0, 0), (1, 1), (2, 5) is 5/2, the residuals of y are 1/2, −1,
    /// 1/2, and the variance of the slope is 3/2 over 1 degree of freedom and over 2.
    #[test]
    fn a_line_on_linear_axes_has_the_error_of_the_textbook() {
        let fit = straight(&[(0.0, 0.0), (1.0, 1.0), (2.0, 5.0)], false, false).unwrap();
        assert!((fit.slope - 2.5).abs() < 1e-15 && (fit.intercept + 0.5).abs() < 1e-15, "{fit:?}");
        assert!((fit.standard_error - 0.75f64.sqrt()).abs() < 1e-15, "{fit:?}");
        let decay = straight(&on(|n| 10f64.powf(2.0 - 0.1 * n)), false, true).unwrap();
        assert!(
            (decay.slope + 0.1).abs() < 1e-12 && (decay.at(10.0) - 10.0).abs() < 1e-11,
            "{decay:?}"
        );
    }

    #[test]
    fn what_is_not_yet_asymptotic_is_left_out() {
        let (slope, from, to, _) = fitted(&on(|n| 1.0 / n + 3.0 / n / n)).unwrap();
        assert_eq!((slope.as_str(), from, to), ("-1.037 ± 0.007", 32.0, 256.0));
    }

    #[test]
    fn a_floor_is_left_out() {
        let (slope, from, to, points) = fitted(&on(|n| (1.0 / n / n).max(1e-4))).unwrap();
        assert_eq!((slope.as_str(), from, to, points), ("-2.000 ± 0.000", 4.0, 64.0, 5));
    }

    #[test]
    fn scatter_is_kept_and_shows_in_the_error() {
        let up_and_down = [0.2, -0.15, 0.1, -0.2, 0.05, 0.15, -0.1];
        let points: Vec<_> =
            MESHES.iter().zip(up_and_down).map(|(&n, up)| (n, 10f64.powf(up) / n)).collect();
        let fit = power_law(&points).unwrap();
        assert_eq!(fit.points, 7);
        assert!(
            (fit.slope + 1.0).abs() < 2.0 * fit.standard_error && fit.standard_error > 0.05,
            "{fit:?}"
        );
    }

    #[test]
    fn a_curve_without_a_straight_part_has_no_slope() {
        assert_eq!(power_law(&on(|n| (-0.1 * n).exp())), None, "an exponential");
        assert_eq!(power_law(&[]), None);
        assert_eq!(power_law(&[(1.0, 1.0), (2.0, 2.0)]), None, "two points");
        assert_eq!(
            power_law(&[(1.0, 1.0), (2.0, 2.0), (2.0, 3.0), (2.0, 4.0)]),
            None,
            "two abscissas"
        );
        assert_eq!(
            straight(&[(0.0, 1e300), (1e-300, -1e300), (1e300, 1e308)], false, false),
            None,
            "beyond doubles"
        );
    }
}
