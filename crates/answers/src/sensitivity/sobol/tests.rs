//! Indices hold against SALib and against closed forms.

use contact::SplitMix64;

use super::*;
use crate::sensitivity::references::{INPUTS, assert_close, references};
use crate::statistics::LEVEL;

/// The estimators of SALib.
const USUAL: Estimators =
    Estimators { first: EstimatorForm::Products, total: EstimatorForm::Differences };

fn all_forms() -> [Estimators; 3] {
    let of = |form| Estimators { first: form, total: form };
    [USUAL, of(EstimatorForm::Products), of(EstimatorForm::Differences)]
}

#[test]
fn indices_are_those_of_salib() {
    for reference in references("sobol") {
        let rows: Vec<&[f64]> = reference["outputs"].chunks(INPUTS + 2).collect();
        let column = |member: usize| rows.iter().map(|row| row[member]).collect();
        let outputs = SaltelliOutputs {
            a: column(0),
            b: column(INPUTS + 1),
            ab: (1..=INPUTS).map(column).collect(),
        };
        let indices = indices(&outputs, USUAL).unwrap();
        let values = |of: fn(&SobolIndices) -> IndexEstimate| -> Vec<f64> {
            indices.iter().map(|indices| of(indices).value).collect()
        };
        assert_close(&values(|indices| indices.first), &reference["S1"]);
        assert_close(&values(|indices| indices.total), &reference["ST"]);
    }
}

/// A power law of inputs whose logarithms are uniform: Hertz's peak pressure below a sphere, which
/// grows as F^(1/3) E*^(2/3) R^(-2/3).
struct PowerLaw {
    /// The exponent of each input, and the ratio of its largest value to its smallest.
    inputs: Vec<(f64, f64)>,
}

impl PowerLaw {
    fn hertz() -> Self {
        let third = 1.0 / 3.0;
        PowerLaw { inputs: vec![(third, 10.0), (2.0 * third, 2.0), (-2.0 * third, 3.0)] }
    }

    fn output(&self, point: &[f64]) -> f64 {
        let terms = self.inputs.iter().zip(point);
        terms.map(|((exponent, ratio), u)| exponent * ratio.ln() * u).sum::<f64>().exp()
    }

    /// Returns the first and the total index of each input. The output is a product of independent
    /// factors. With the relative variances c of these, that of the output is Π (1 + c) − 1.
    fn indices(&self) -> Vec<[f64; 2]> {
        let relative = self.inputs.iter().map(|(exponent, ratio)| {
            let raw = |power: f64| (power * ratio.ln()).exp_m1() / (power * ratio.ln());
            raw(2.0 * exponent) / raw(*exponent).powi(2) - 1.0
        });
        let relative: Vec<f64> = relative.collect();
        let product: f64 = relative.iter().map(|c| 1.0 + c).product();
        let of = |c: &f64| [c / (product - 1.0), c * product / ((1.0 + c) * (product - 1.0))];
        relative.iter().map(of).collect()
    }

    /// Returns the outputs of a design of independent random points.
    fn design(&self, rows: usize, seed: u64) -> SaltelliOutputs {
        let inputs = self.inputs.len();
        let mut random = SplitMix64(seed);
        let mut outputs =
            SaltelliOutputs { ab: vec![Vec::new(); inputs], ..SaltelliOutputs::default() };
        for _ in 0..rows {
            let [a, b] = [(); 2].map(|()| (0..inputs).map(|_| random.unit()).collect::<Vec<_>>());
            outputs.a.push(self.output(&a));
            outputs.b.push(self.output(&b));
            for (input, ab) in outputs.ab.iter_mut().enumerate() {
                let mut mixed = a.clone();
                mixed[input] = b[input];
                ab.push(self.output(&mixed));
            }
        }
        outputs
    }
}

#[test]
fn indices_converge_to_their_closed_form() {
    let law = PowerLaw::hertz();
    for estimators in all_forms() {
        let indices = indices(&law.design(20_000, 3), estimators).unwrap();
        for (found, [first, total]) in indices.iter().zip(law.indices()) {
            for (found, expected) in [(found.first, first), (found.total, total)] {
                assert!((found.value - expected).abs() < 0.02, "{found:?}: {expected}");
            }
        }
    }
}

/// A share of 95 % of 200 intervals lies within four of its standard errors.
#[test]
fn intervals_cover_the_closed_form_at_their_level() {
    let law = PowerLaw::hertz();
    let truth: Vec<f64> = law.indices().concat();
    let four = 4.0 * (LEVEL * (1.0 - LEVEL) * 200.0).sqrt();
    for estimators in all_forms() {
        let mut covered = vec![0; truth.len()];
        for seed in 0..200 {
            let scaled = law.design(200, seed << 32).scaled().unwrap();
            let intervals =
                bootstrap::resampled(200, 200, seed, |drawn| scaled.estimates(estimators, drawn));
            for ((interval, truth), covered) in intervals.iter().zip(&truth).zip(&mut covered) {
                let ConfidenceInterval { low, high } = interval.unwrap();
                *covered += usize::from(low <= *truth && *truth <= high);
            }
        }
        let deviates = |covered: &&usize| (**covered as f64 - LEVEL * 200.0).abs() > four;
        assert_eq!(covered.iter().find(deviates), None, "{estimators:?}: {covered:?} of 200");
    }
}

#[test]
fn an_output_that_does_not_vary_has_no_indices() {
    let constant = |output: f64| SaltelliOutputs {
        a: vec![output; 4],
        b: vec![output; 4],
        ab: vec![vec![output; 4]; 2],
    };
    assert_eq!(indices(&constant(0.1), USUAL), None);
    let single = PowerLaw::hertz().design(1, 1);
    assert_eq!(indices(&single, USUAL), None);
    // It varies, but neither between the A nor between the B.
    let only_mixed = SaltelliOutputs { ab: vec![vec![1.0, 2.0, 3.0, 4.0]; 2], ..constant(0.1) };
    assert_eq!(indices(&only_mixed, USUAL), None);
    assert_eq!(indices(&SaltelliOutputs::default(), USUAL), None);
}

#[test]
fn the_size_of_an_output_and_a_constant_in_it_change_nothing() {
    let law = PowerLaw::hertz();
    let of = |scale: f64, constant: f64| {
        let mut outputs = law.design(64, 5);
        let all = outputs.a.iter_mut().chain(&mut outputs.b);
        all.chain(outputs.ab.iter_mut().flatten()).for_each(|x| *x = scale * *x + constant);
        let indices = indices(&outputs, USUAL).unwrap();
        indices.iter().flat_map(|of| [of.first.value, of.total.value]).collect::<Vec<f64>>()
    };
    assert_close(&of(1e250, 0.0), &of(1.0, 0.0));
    assert_close(&of(1e-250, 0.0), &of(1.0, 0.0));
    // Of 16 digits, 6 are spent on the constant.
    for (found, expected) in of(1.0, 1e6).iter().zip(of(1.0, 0.0)) {
        assert!((found - expected).abs() < 1e-8, "{found} is not {expected}");
    }
}
