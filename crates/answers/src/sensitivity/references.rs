//! The numbers that SALib makes of small designs: `references.csv`, which
//! `scripts/sensitivity_references.py` writes.

use std::collections::BTreeMap;

/// The numbers of one function by what they are.
pub(crate) type Reference = BTreeMap<&'static str, Vec<f64>>;

/// The number of inputs of every function.
pub(crate) const INPUTS: usize = 3;

/// Returns the numbers of each function for a method.
pub(crate) fn references(method: &str) -> Vec<Reference> {
    let mut functions: BTreeMap<&str, Reference> = BTreeMap::new();
    for line in include_str!("references.csv").lines() {
        let cells: Vec<&'static str> = line.split(',').collect();
        if let [of, function, name, numbers @ ..] = &cells[..]
            && *of == method
        {
            let numbers = numbers.iter().map(|number| number.parse().unwrap()).collect();
            functions.entry(function).or_default().insert(name, numbers);
        }
    }
    assert_eq!(functions.len(), 2, "{method}");
    functions.into_values().collect()
}

/// Fails if numbers differ by more than rounding from the expected ones, of which the largest is
/// the scale.
#[track_caller]
pub(crate) fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().map(|x| x.abs()).fold(0.0, f64::max);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-13 * scale, "{found} is not {expected}");
    }
}
