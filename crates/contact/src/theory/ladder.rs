//! Laws that a ladder of ever finer solutions follows: the limit of a figure by Richardson
//! extrapolation with the uncertainty of that limit, and the order of an error, or the exponent of
//! a cost, by a straight line in logarithms.

/// A limit that is extrapolated from a ladder of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The limit, in the unit of the values.
    pub value: f64,
    /// The half-width of the interval around `value` in which the limit lies; a careful estimate,
    /// not a bound.
    pub uncertainty: f64,
    /// The order p, if the values follow L + C hᵖ.
    pub order: Option<f64>,
    /// The behaviour of the values.
    pub trend: Trend,
}

/// The behaviour of the values of a ladder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trend {
    /// The three finest values are equal up to rounding.
    Settled,
    /// Successive threes of values show the same order.
    Asymptotic,
    /// The three finest values show an order, and there are no others, or those before them show
    /// another order.
    Converging,
    /// The three finest values or the three before them show no order: they go up and down, as
    /// counted areas do, or do not draw nearer to each other.
    Scattered,
}

/// The reason why a ladder yields no law.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LadderError {
    /// There are too few rungs.
    #[error("{found} rungs: at least 3 are needed")]
    Short {
        /// The number of rungs given.
        found: usize,
    },
    /// A rung has no place on the ladder.
    #[error("rung {rung} = ({x:e}, {y:e}): {expected}")]
    Rung {
        /// The index of the rung.
        rung: usize,
        /// The first figure of the rung.
        x: f64,
        /// The second figure of the rung.
        y: f64,
        /// The condition that the rung breaks.
        expected: &'static str,
    },
}

/// The range of credible orders; orders outside are those of noise.
const ORDERS: [f64; 2] = [0.25, 6.0];

/// The largest difference between the orders of successive threes that count as the same, relative
/// to the larger of both.
const SAME_ORDER: f64 = 0.25;

/// Returns the limit of a figure whose error goes like an unknown power of h, from rungs (h, value)
/// in the order of falling h > 0.
///
/// The three finest rungs determine value = L + C hᵖ. The uncertainty of L is, with the finest
/// value v and the one before it u:
/// - [`Trend::Asymptotic`]: 1.25 |L − L′|/(r − 1), and at least a tenth of |L − v|. L′ is the same
///   extrapolation from the next coarser three. The last step's ratio of mesh sizes r counts as at
///   most 2, for the error of L falls at least like h;
/// - [`Trend::Converging`]: 1.25 |L − v| from three rungs only, the grid convergence index; with a
///   fourth that shows another order the larger of 3 |L − v| and |v − u|;
/// - [`Trend::Scattered`]: the limit is the mean of the last four values (of three on a ladder of
///   three), and its uncertainty is one and a half times their range, on a ladder of three twice
///   their range.
///
/// The factors 1.25 and 3 are Roache's (Annu. Rev. Fluid Mech. 29 (1997) 123–160,
/// doi:10.1146/annurev.fluid.29.1.123), and so is their use for orders that can be trusted and
/// orders that cannot; the range of scattered values is used as Eça and Hoekstra do (J. Comput.
/// Phys. 262 (2014) 104–130, doi:10.1016/j.jcp.2014.01.006).
///
/// # Errors
/// [`LadderError::Short`] with fewer than three rungs; [`LadderError::Rung`] if an h is not finite
/// and above 0 or does not fall from rung to rung, or if a value is not finite.
pub fn richardson(ladder: &[(f64, f64)]) -> Result<Limit, LadderError> {
    let rungs = ladder.len();
    if rungs < 3 {
        return Err(LadderError::Short { found: rungs });
    }
    for (rung, &(x, y)) in ladder.iter().enumerate() {
        let expected = if !(x.is_finite() && x > 0.0 && y.is_finite()) {
            "h must be finite and above 0, the value finite"
        } else if rung > 0 && x >= ladder[rung - 1].0 {
            "h must fall from rung to rung"
        } else {
            continue;
        };
        return Err(LadderError::Rung { rung, x, y, expected });
    }
    let three = |end: usize| [ladder[end - 3], ladder[end - 2], ladder[end - 1]];
    let finest = three(rungs);
    let [_, (_, before), (_, last)] = finest;
    let range = |rungs: &[(f64, f64)]| {
        let values = || rungs.iter().map(|rung| rung.1);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let spread = range(&finest);
    if spread <= 16.0 * f64::EPSILON * last.abs() {
        return Ok(Limit { value: last, uncertainty: spread, order: None, trend: Trend::Settled });
    }
    let earlier = (rungs > 3).then(|| extrapolate(three(rungs - 1)));
    let (Some(Extrapolation { limit: value, order }), None | Some(Some(_))) =
        (extrapolate(finest), earlier)
    else {
        let tail = &ladder[rungs.saturating_sub(4)..];
        let mean = tail.iter().map(|rung| rung.1).sum::<f64>() / tail.len() as f64;
        let factor = if tail.len() > 3 { 1.5 } else { 2.0 };
        return Ok(Limit {
            value: mean,
            uncertainty: factor * range(tail),
            order: None,
            trend: Trend::Scattered,
        });
    };
    let distance = (value - last).abs();
    let (uncertainty, trend) = match earlier.flatten() {
        None => (1.25 * distance, Trend::Converging),
        Some(other) if (order - other.order).abs() <= SAME_ORDER * order.max(other.order) => (
            (1.25 * (value - other.limit).abs() / (finest[1].0 / finest[2].0 - 1.0).min(1.0))
                .max(0.1 * distance),
            Trend::Asymptotic,
        ),
        Some(_) => ((3.0 * distance).max((last - before).abs()), Trend::Converging),
    };
    Ok(Limit { value, uncertainty, order: Some(order), trend })
}

/// The law L + C hᵖ through three rungs.
#[derive(Clone, Copy)]
struct Extrapolation {
    /// The limit L.
    limit: f64,
    /// The order p.
    order: f64,
}

/// Fits L + C hᵖ to three rungs (h, value) of falling h; `None` if there is no such law with a
/// credible p.
fn extrapolate([coarse, middle, fine]: [(f64, f64); 3]) -> Option<Extrapolation> {
    let (first, second) = (coarse.1 - middle.1, middle.1 - fine.1);
    let ratio = first / second;
    // The ratio (h₁ᵖ − h₂ᵖ)/(h₂ᵖ − h₃ᵖ) rises with p.
    let of_order = |p: f64| {
        ((p * (coarse.0 / middle.0).ln()).exp_m1()) / -(-p * (middle.0 / fine.0).ln()).exp_m1()
    };
    let [mut low, mut high] = ORDERS;
    // The condition also refuses NaN, which a second difference of 0 makes of a first one of 0.
    if !(ratio >= of_order(low) && ratio <= of_order(high)) {
        return None;
    }
    while high - low > 1e-13 * high {
        let p = 0.5 * (low + high);
        if p <= low || p >= high {
            break;
        }
        if of_order(p) < ratio { low = p } else { high = p }
    }
    let order = 0.5 * (low + high);
    // The finest value's error is its distance to the middle one over (h₂/h₃)ᵖ − 1.
    let limit = fine.1 - second / (order * (middle.0 / fine.0).ln()).exp_m1();
    Some(Extrapolation { limit, order })
}

/// A straight line through the logarithms of a ladder's later rungs, y = e^intercept · x^slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// The exponent.
    pub slope: f64,
    /// The standard error of the exponent.
    pub standard_error: f64,
    /// The value of ln y at x = 1.
    pub intercept: f64,
    /// The root mean square of the residuals of ln y, over the degrees of freedom left.
    pub scatter: f64,
    /// The index of the first rung on the line; those before it are left out.
    pub first: usize,
    /// The x of the first and the last rung on the line.
    pub range: [f64; 2],
}

impl PowerLaw {
    /// Returns y at x.
    pub fn at(&self, x: f64) -> f64 {
        (self.intercept + self.slope * x.ln()).exp()
    }
}

/// The relative distance, a tenth, up to which a rung belongs to the line of the later ones
/// whatever their scatter.
const CLOSE: f64 = 0.1;

/// Student's t that 99 of 100 values stay below, for 1, 2, … degrees of freedom.
const STUDENT: [f64; 10] = [63.66, 9.925, 5.841, 4.604, 4.032, 3.707, 3.499, 3.355, 3.250, 3.169];

/// Returns the power law in which a ladder (x, y), x, y > 0, ends, by least squares in logarithms.
///
/// Rungs are given in the order in which the law comes to hold: errors with falling mesh size or ε,
/// costs with a rising number of elements. The line starts with the last three rungs and is
/// extended backwards rung by rung, as long as the next one lies within a tenth of the line's
/// prediction, or within the range in which the line's scatter lets 99 of 100 points lie. The first
/// rung that does not, and everything before it, is taken to be pre-asymptotic and left out.
///
/// # Errors
/// [`LadderError::Short`] with fewer than three rungs; [`LadderError::Rung`] if a figure is not
/// finite and above 0, or if an x comes twice.
pub fn power_law(ladder: &[(f64, f64)]) -> Result<PowerLaw, LadderError> {
    if ladder.len() < 3 {
        return Err(LadderError::Short { found: ladder.len() });
    }
    for (rung, &(x, y)) in ladder.iter().enumerate() {
        let is_positive = |x: f64| x.is_finite() && x > 0.0;
        let expected = if !(is_positive(x) && is_positive(y)) {
            "both figures must be finite and above 0"
        } else if ladder[..rung].iter().any(|other| other.0 == x) {
            "x must not come twice"
        } else {
            continue;
        };
        return Err(LadderError::Rung { rung, x, y, expected });
    }
    let points: Vec<(f64, f64)> = ladder.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mut first = points.len() - 3;
    let mut line = Line::through(&points[first..]);
    while first > 0 {
        let (x, y) = points[first - 1];
        if (y - line.at(x)).abs() > line.reach_of_prediction(x).max(CLOSE.ln_1p()) {
            break;
        }
        first -= 1;
        line = Line::through(&points[first..]);
    }
    Ok(PowerLaw {
        slope: line.slope,
        standard_error: line.scatter / line.variation.sqrt(),
        intercept: line.at(0.0),
        scatter: line.scatter,
        first,
        range: [ladder[first].0, ladder[ladder.len() - 1].0],
    })
}

/// A least-squares line y = ȳ + slope (x − x̄).
struct Line {
    slope: f64,
    /// The centre of gravity (x̄, ȳ) of the points.
    center: (f64, f64),
    /// The sum Σ (x − x̄)².
    variation: f64,
    /// The root mean square of the residuals, over the degrees of freedom left.
    scatter: f64,
    /// The number of points.
    points: f64,
}

impl Line {
    /// Fits the line to at least three points.
    fn through(points: &[(f64, f64)]) -> Self {
        let n = points.len() as f64;
        let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
        let center = (mean(|p| p.0), mean(|p| p.1));
        let variation = points.iter().map(|p| (p.0 - center.0).powi(2)).sum::<f64>();
        let slope =
            points.iter().map(|p| (p.0 - center.0) * (p.1 - center.1)).sum::<f64>() / variation;
        let residuals =
            points.iter().map(|p| (p.1 - center.1 - slope * (p.0 - center.0)).powi(2)).sum::<f64>();
        Self { slope, center, variation, scatter: (residuals / (n - 2.0)).sqrt(), points: n }
    }

    /// Returns y at x.
    fn at(&self, x: f64) -> f64 {
        self.center.1 + self.slope * (x - self.center.0)
    }

    /// Returns the distance from the line within which 99 of 100 further points at x lie.
    fn reach_of_prediction(&self, x: f64) -> f64 {
        let student = STUDENT[(self.points as usize - 3).min(STUDENT.len() - 1)];
        student
            * self.scatter
            * (1.0 + 1.0 / self.points + (x - self.center.0).powi(2) / self.variation).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn ladder(meshes: &[f64], value: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        meshes.iter().map(|n| (1.0 / n, value(1.0 / n))).collect()
    }

    #[test]
    fn a_pure_power_is_extrapolated_exactly_for_any_ratios() {
        for order in [0.5, 1.0, 1.37, 2.0, 4.0] {
            for meshes in [&[8.0, 16.0, 32.0, 64.0][..], &[10.0, 13.0, 31.0, 40.0, 41.0]] {
                let limit = richardson(&ladder(meshes, |h| 3.0 - 0.7 * h.powf(order))).unwrap();
                assert_eq!(limit.trend, Trend::Asymptotic);
                assert!(
                    (limit.value - 3.0).abs() < 1e-9 && (limit.order.unwrap() - order).abs() < 1e-4,
                    "{order}: {limit:?}"
                );
                assert!((limit.value - 3.0).abs() <= limit.uncertainty);
            }
        }
        let three = richardson(&ladder(&[8.0, 16.0, 32.0], |h| 1.0 + h)).unwrap();
        assert_eq!(three.trend, Trend::Converging);
        assert!((three.uncertainty / (1.25 / 32.0) - 1.0).abs() < 1e-9, "{three:?}");
    }

    /// Two powers: the uncertainty covers the error whatever the sign and size of the second one,
    /// except for h^½ followed closely by the next power, which for opposite signs turns round only
    /// beyond the ladder.
    #[test]
    fn the_uncertainty_covers_what_a_second_power_does() {
        let (mut all, mut covered) = (0, 0);
        for order in [0.5, 1.0, 1.5, 2.0] {
            for next in [0.5, 1.0, 2.0] {
                for share in [-3.0, -1.0, -0.3, 0.3, 1.0, 3.0, 10.0] {
                    for meshes in [
                        &[12.0, 24.0, 48.0, 96.0][..],
                        &[16.0, 24.0, 36.0, 54.0, 81.0],
                        &[12.0, 24.0, 48.0],
                    ] {
                        let limit = richardson(&ladder(meshes, |h| {
                            2.0 + h.powf(order) * (1.0 + share * h.powf(next))
                        }))
                        .unwrap();
                        all += 1;
                        covered += usize::from((limit.value - 2.0).abs() <= limit.uncertainty);
                    }
                }
            }
        }
        eprintln!("{covered} of {all}");
        assert!(covered * 100 >= all * 93, "{covered} of {all}");
    }

    /// Areas of disks that are counted in elements jump about π; the uncertainty must cover that
    /// and must not be far too large.
    #[test]
    fn counted_areas_are_honest() {
        let area = |n: f64, radius: f64| {
            let h = 3.0 / n;
            let center = |i: usize| (i as f64 + 0.5) * h - 1.5;
            let count = (0..(n * n) as usize)
                .filter(|s| center(s % n as usize).hypot(center(s / n as usize)) < radius)
                .count();
            count as f64 * h * h
        };
        let (mut covered, mut widest, all) = (0, 0.0_f64, 200);
        for k in 0..all {
            let radius = 0.8 + 0.5 * k as f64 / all as f64;
            let rungs: Vec<(f64, f64)> = [24.0, 34.0, 48.0, 68.0, 96.0]
                .iter()
                .map(|n| (1.0 / n, area(*n, radius)))
                .collect();
            let limit = richardson(&rungs).unwrap();
            let exact = PI * radius * radius;
            covered += usize::from((limit.value - exact).abs() <= limit.uncertainty);
            widest = widest.max(limit.uncertainty / exact);
        }
        eprintln!("{covered} of {all}, widest {widest:.1e}");
        assert!(covered >= all * 95 / 100 && widest < 0.1, "{covered} of {all}, widest {widest}");
    }

    #[test]
    fn what_does_not_converge_has_no_order() {
        let apart = richardson(&[(0.4, 1.0), (0.2, 2.0), (0.1, 4.0)]).unwrap();
        assert_eq!((apart.trend, apart.order), (Trend::Scattered, None));
        assert!(apart.uncertainty >= 4.0 - apart.value);
        let swinging = richardson(&[(0.4, 1.0), (0.2, 0.5), (0.1, 0.75)]).unwrap();
        assert_eq!(swinging.trend, Trend::Scattered);
        let settled = richardson(&[(0.4, 0.0), (0.2, 0.0), (0.1, 0.0)]).unwrap();
        assert_eq!((settled.value, settled.uncertainty, settled.trend), (0.0, 0.0, Trend::Settled));
        // Two equal values at the end say nothing about an order.
        assert_eq!(
            richardson(&[(0.4, 1.0), (0.2, 0.5), (0.1, 0.5)]).unwrap().trend,
            Trend::Scattered
        );
    }

    #[test]
    fn ladders_that_are_none_are_refused() {
        assert_eq!(richardson(&[(1.0, 1.0); 2]), Err(LadderError::Short { found: 2 }));
        let rung = |ladder: &[(f64, f64)]| match richardson(ladder) {
            Err(LadderError::Rung { rung, .. }) => rung,
            other => panic!("{other:?}"),
        };
        assert_eq!(rung(&[(1.0, 1.0), (1.0, 1.0), (0.5, 1.0)]), 1);
        assert_eq!(rung(&[(1.0, 1.0), (0.5, f64::NAN), (0.25, 1.0)]), 1);
        assert_eq!(rung(&[(0.0, 1.0), (0.5, 1.0), (0.25, 1.0)]), 0);
        assert!(matches!(
            power_law(&[(1.0, 1.0), (0.5, 0.0), (0.25, 1.0)]),
            Err(LadderError::Rung { rung: 1, .. })
        ));
        assert!(matches!(
            power_law(&[(1.0, 1.0), (0.5, 1.0), (1.0, 1.0)]),
            Err(LadderError::Rung { rung: 2, .. })
        ));
    }

    #[test]
    fn a_line_leaves_out_what_comes_before_the_law() {
        // The values follow y = 2 x^1.5 from the third rung on and lie far above it before.
        let rungs: Vec<(f64, f64)> =
            (0..7).map(|k| 0.5_f64.powi(k)).map(|x| (x, 2.0 * x.powf(1.5))).collect();
        let mut bent = rungs.clone();
        (bent[0].1, bent[1].1) = (bent[0].1 * 3.0, bent[1].1 * 1.5);
        let law = power_law(&bent).unwrap();
        assert_eq!((law.first, law.range), (2, [0.25, 0.5_f64.powi(6)]));
        assert!(
            (law.slope - 1.5).abs() < 1e-12
                && law.standard_error < 1e-12
                && (law.at(0.1) / rungs_at(0.1) - 1.0).abs() < 1e-12
        );
        assert_eq!(power_law(&rungs).unwrap().first, 0);
    }

    fn rungs_at(x: f64) -> f64 {
        2.0 * x.powf(1.5)
    }

    /// With 10 % of noise the slope lies within its standard errors as often as it should.
    #[test]
    fn standard_errors_are_those_of_the_slopes() {
        let mut seed = 1u64;
        let mut uniform = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        let (trials, mut within, mut whole) = (400, 0, 0);
        for _ in 0..trials {
            let rungs: Vec<(f64, f64)> = (3..11)
                .map(|k| 2f64.powi(k))
                .map(|n| (n, n.powf(2.2) * (0.2 * (uniform() - 0.5)).exp()))
                .collect();
            let law = power_law(&rungs).unwrap();
            within += usize::from((law.slope - 2.2).abs() <= 2.45 * law.standard_error);
            whole += usize::from(law.first == 0);
        }
        eprintln!("{within} of {trials} within the 95 % interval, {whole} whole");
        // Student's t for 6 degrees of freedom is 2.45.
        assert!(
            within * 100 >= trials * 88 && whole * 100 >= trials * 85,
            "{within}, {whole} of {trials}"
        );
    }
}
