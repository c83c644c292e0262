//! Elementary effects (Morris 1991, doi:10.1080/00401706.1991.10484804): what a step of one input
//! changes, where the other inputs are anywhere.
//!
//! A trajectory goes from point to point and moves each input once. The mean of the absolute
//! effects, μ* (Campolongo et al. 2007, doi:10.1016/j.envsoft.2006.10.004), ranks the inputs; their
//! deviation σ tells interactions and curvature.

use crate::statistics::ConfidenceInterval;
use crate::statistics::bootstrap;
use crate::statistics::moments::{Moments, moments};

/// The effects of an input over all trajectories.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct InputEffects {
    /// The mean μ of the effects.
    pub(crate) mean: f64,
    /// The mean μ* of the absolute effects.
    pub(crate) absolute: f64,
    /// The interval of μ*; `None` if the trajectories give none.
    pub(crate) interval: Option<ConfidenceInterval>,
    /// The deviation σ of the effects; `None` for one trajectory.
    pub(crate) deviation: Option<f64>,
}

/// Returns the elementary effect of each input along a trajectory, given its points in the unit
/// cube and its outputs: the change of the output over that of the input's place in the cube.
/// `None` if some input moves with another, twice or not at all.
pub(crate) fn elementary(points: &[Vec<f64>], outputs: &[f64]) -> Option<Vec<f64>> {
    let mut effects = vec![None; points.first()?.len()];
    for (points, outputs) in points.windows(2).zip(outputs.windows(2)) {
        let steps = points[0].iter().zip(&points[1]).map(|(from, to)| to - from);
        let mut moved = steps.enumerate().filter(|(_, step)| *step != 0.0);
        let (input, step) = moved.next()?;
        let effect = (outputs[1] - outputs[0]) / step;
        if moved.next().is_some() || effects[input].replace(effect).is_some() {
            return None;
        }
    }
    effects.into_iter().collect()
}

/// Returns the effects of each input, given its elementary effects, one for each trajectory; `None`
/// without trajectories.
pub(crate) fn effects(elementary: &[Vec<f64>]) -> Option<Vec<InputEffects>> {
    let trajectories = elementary.first().map(Vec::len).filter(|count| *count > 0)?;
    let absolute: Vec<Vec<f64>> =
        elementary.iter().map(|effects| effects.iter().map(|e| e.abs()).collect()).collect();
    let intervals = bootstrap::intervals(trajectories, |drawn| {
        absolute.iter().map(|effects| moments(effects, drawn).mean).collect()
    });
    let all = vec![1; trajectories];
    let of_input = |((effects, absolute), interval): ((&Vec<f64>, &Vec<f64>), _)| {
        let Moments { mean, deviation } = moments(effects, &all);
        InputEffects {
            mean,
            absolute: moments(absolute, &all).mean,
            interval: if trajectories > 1 { interval } else { None },
            deviation: deviation.is_finite().then_some(deviation),
        }
    };
    Some(elementary.iter().zip(&absolute).zip(intervals).map(of_input).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensitivity::references::{INPUTS, assert_close, references};

    #[test]
    fn effects_are_those_of_salib() {
        for reference in references("morris") {
            let points: Vec<Vec<f64>> =
                reference["points"].chunks(INPUTS).map(<[f64]>::to_vec).collect();
            let trajectories =
                points.chunks(INPUTS + 1).zip(reference["outputs"].chunks(INPUTS + 1));
            let all: Vec<Vec<f64>> = trajectories
                .map(|(points, outputs)| elementary(points, outputs).unwrap())
                .collect();
            let of_input = |input: usize| all.iter().map(|effects| effects[input]).collect();
            let effects = effects(&(0..INPUTS).map(of_input).collect::<Vec<_>>()).unwrap();
            let values =
                |of: fn(&InputEffects) -> f64| -> Vec<f64> { effects.iter().map(of).collect() };
            assert_close(&values(|effects| effects.mean), &reference["mu"]);
            assert_close(&values(|effects| effects.absolute), &reference["mu_star"]);
            assert_close(&values(|effects| effects.deviation.unwrap()), &reference["sigma"]);
        }
    }

    #[test]
    fn a_trajectory_moves_each_input_once() {
        let points = |places: [[f64; 2]; 3]| places.map(|place| place.to_vec());
        let sound = points([[0.0, 1.0], [0.5, 1.0], [0.5, 0.5]]);
        assert_eq!(elementary(&sound, &[1.0, 2.0, 5.0]), Some(vec![2.0, -6.0]));
        let twice = points([[0.0, 1.0], [0.5, 1.0], [0.0, 1.0]]);
        let together = points([[0.0, 1.0], [0.5, 0.5], [0.5, 1.0]]);
        for other in [twice, together] {
            assert_eq!(elementary(&other, &[1.0, 2.0, 5.0]), None);
        }
        assert_eq!(elementary(&[], &[]), None);
    }

    #[test]
    fn one_trajectory_has_effects_without_spread() {
        let effects = effects(&[vec![-2.0], vec![0.5]]).unwrap();
        assert_eq!(effects[0].mean, -2.0);
        assert_eq!(effects[0].absolute, 2.0);
        assert_eq!((effects[0].interval, effects[0].deviation), (None, None));
        assert!(super::effects(&[Vec::new()]).is_none() && super::effects(&[]).is_none());
    }
}
