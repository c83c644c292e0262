//! A lower bound of μ* by cases of open and closed elements, whose fields are cut into cones.
//!
//! # What weights alone cannot exclude
//! The weights of a case ([`super::cases`]) speak of means: they cannot exclude a mixture of fields
//! that meets every condition in the mean, although none of its fields does. Where all of 3 × 3
//! elements are closed, the worst mixture is one of three fields, which trade their violations
//! between elements and directions.
//!
//! # The certificate
//! A cone is the set of fields x with l·x ≥ 0 for each of some forms l, here of the tangential
//! tractions. In it all products of two forms are at least 0. So if with numbers N ≥ 0
//!
//! ```text
//! F(μ) + κ_u Σ y₁² over closed elements + κ_s Σ x₁² over open ones − Σ N_ab (l_a·x)(l_b·x)
//! ```
//!
//! is positive definite, where F(μ) is the form of [`lower`], no x ≠ 0 with F(x) ≤ μ is in the
//! case and in the cone. Where an element is open, F(μ) has only its β x_t·y_t, for x₁ = 0
//! makes the condition x_t·y_t ≤ 0; where it is closed there is no α. In a narrow cone a mixture is
//! nearly one field.
//!
//! A form l cuts a cone in two, l·x ≥ 0 and −l·x ≥ 0. The first form of a case takes only the
//! first, as −x needs the same friction as x. So a tree of cuts leaves no field out, whatever its
//! forms are. Cases are excluded with all their images under the symmetries of Ω, as in
//! [`super::cases`], and for every smaller μ too: F(μ) falls with μ, and nothing else depends on
//! it.
//!
//! # Rounding
//! The matrix of an end of the tree is formed entry by entry in the basis of tractions, as a sum of
//! at most T = 3k + 2P + 4 terms with P products. With u = 2⁻⁵³, γ = 4(T + 32)u and B the same sums
//! of absolute values, it differs from the exact one by at most γ‖B‖∞ in the 2-norm. The numbers of
//! a certificate have single precision, exactly, and are computed with in double precision, so that
//! nothing underflows. Rows and columns are scaled by powers of two, which rounds nothing, to
//! diagonal entries near 1. The share of the factorisation and that of images of the case are those
//! of [`lower`].

use faer::Mat;
use primitives::cholesky;
use serde::{Deserialize, Serialize};

use super::cover::{self, CoverError, NormalCase};
use super::lower;
use super::symmetry::Symmetries;
use super::system::System;

/// Cases and cones that are excluded for a μ and leave no field out, so that μ < μ*.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConeBound {
    /// The friction coefficient μ.
    pub mu: f64,
    /// The excluded cases.
    pub cases: Vec<ConeCase>,
}

/// A case with the cones that its fields are cut into.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConeCase {
    /// The state of each element of Ω.
    pub states: Vec<NormalCase>,
    /// The tree of cones: each cut is followed by all of its first cone, then by all of its second.
    pub nodes: Vec<ConeNode>,
}

/// A cone of fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum ConeNode {
    /// The cone is cut in two.
    Cut {
        /// The form l of the 2k tangential tractions: the first cone has l·x ≥ 0, the second −l·x ≥
        /// 0. The first cut of a case has no second.
        form: Vec<f32>,
    },
    /// The cone is excluded.
    Excluded(ConeWeights),
    /// The cone was not looked at. It is a [branch](super::branch) of its own.
    Open,
    /// The cone was cut as often as it may be, or rounding stopped the search: nothing excludes it.
    GivenUp,
}

/// The weights that exclude a cone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConeWeights {
    /// The weight α ≥ 0 of each undecided element.
    pub alpha: Vec<f32>,
    /// The weight β ≥ 0 of each element.
    pub beta: Vec<f32>,
    /// The weight τ > 0 of each element that is not open, in units of cℓ.
    pub tau: Vec<f32>,
    /// The weight N ≥ 0 of each product of two forms: 01, 02, 12, 03 and so on.
    pub products: Vec<f32>,
    /// The penalty κ_u ≥ 0 of displacements of closed elements, in units of 1/cℓ.
    pub displacement_penalty: f32,
    /// The penalty κ_s ≥ 0 of pressures of open elements, in units of cℓ.
    pub pressure_penalty: f32,
}

/// The reason why cones prove nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConeError {
    /// The cases leave some out, or are none of Ω.
    #[error(transparent)]
    Cover(#[from] CoverError),
    /// The numbers of a case have no meaning.
    #[error("case {case}: {reason}")]
    Numbers {
        /// The index of the case.
        case: usize,
        /// The number and what it must be.
        reason: String,
    },
    /// The cones of a case are no tree, or are cut too often.
    #[error("case {case}: {reason}")]
    Tree {
        /// The index of the case.
        case: usize,
        /// The place and what is wrong with it.
        reason: String,
    },
    /// The friction coefficient μ has no meaning.
    #[error("mu = {mu:e}: it must be within 1e-30 and 1e30")]
    Mu {
        /// The value of μ.
        mu: f64,
    },
    /// The matrix of a cone is not positive definite, or not by more than rounding.
    #[error(
        "node {node} of case {case} is not excluded for mu = {mu}: its matrix has no Cholesky factor"
    )]
    NotExcluded {
        /// The index of the case.
        case: usize,
        /// The index of the node.
        node: usize,
        /// The friction coefficient μ.
        mu: f64,
    },
    /// A cone is neither cut nor excluded.
    #[error("node {node} of case {case} is neither cut nor excluded")]
    Open {
        /// The index of the case.
        case: usize,
        /// The index of the node.
        node: usize,
    },
}

/// The largest number of forms of a cone.
pub(super) const MOST_FORMS: usize = 40;

/// The sizes of μ that a certificate may have.
const SIZES: [f64; 2] = [1e-30, 1e30];

/// The operator as a check needs it.
pub(super) struct ConeCheck {
    matrix: Mat<f64>,
    /// The ∞-norm of the operator.
    norm: f64,
    /// The ∞-norm of its deviation from symmetry under x ↔ y.
    asymmetry: f64,
}

impl ConeCheck {
    /// Makes a check of cases that stand for their images under all symmetries of Ω.
    pub(super) fn of_domain(system: &System) -> Self {
        Self::new(system, Symmetries::of(system, |_, _| true))
    }

    fn new(system: &System, symmetries: Symmetries) -> Self {
        let matrix = system.matrix();
        let sizes = (0..matrix.nrows())
            .map(|i| (0..matrix.nrows()).map(|j| matrix[(i, j)].abs()).sum::<f64>());
        let norm = sizes.fold(0.0, f64::max);
        Self { matrix, norm, asymmetry: lower::asymmetry_norm(system, symmetries) }
    }

    /// Says if weights exclude the cone of the forms in a case, rounding included. All lengths must
    /// fit, and numbers must be in their ranges.
    pub(super) fn is_excluded(
        &self,
        states: &[NormalCase],
        forms: &[Vec<f32>],
        weights: &ConeWeights,
        mu: f64,
    ) -> bool {
        let (k, size) = (states.len(), 3 * states.len());
        // The weights of x_r y_r, of y_r² and of x_r² for each component r.
        let (mut linear, mut of_displacement) = (vec![0.0; size], vec![0.0; size]);
        let mut of_traction = vec![0.0; size];
        let (mut alpha, mut tau) = (weights.alpha.iter(), weights.tau.iter());
        for (e, state) in states.iter().enumerate() {
            let beta = f64::from(weights.beta[e]);
            (linear[k + e], linear[2 * k + e]) = (beta, beta);
            match state {
                NormalCase::Undecided => {
                    linear[e] = alpha.next().map_or(0.0, |&alpha| f64::from(alpha));
                }
                NormalCase::Open => of_traction[e] = weights.pressure_penalty.into(),
                NormalCase::Closed => of_displacement[e] = weights.displacement_penalty.into(),
            }
            if *state != NormalCase::Open {
                let tau = tau.next().map_or(f64::NAN, |&tau| f64::from(tau));
                of_traction[e] = -0.5 * (mu * beta * tau);
                of_displacement[k + e] = -0.5 * (mu * beta / tau);
                of_displacement[2 * k + e] = of_displacement[k + e];
            }
        }
        let a = &self.matrix;
        let (mut form, mut sizes) = (Mat::<f64>::zeros(size, size), Mat::<f64>::zeros(size, size));
        for j in 0..size {
            for i in j..size {
                let (mut sum, mut absolute) = (0.0, 0.0);
                let mut add = |term: f64| {
                    sum += term;
                    absolute += term.abs();
                };
                add(0.5 * linear[i] * a[(i, j)]);
                add(0.5 * linear[j] * a[(i, j)]);
                for (r, weight) in of_displacement.iter().enumerate() {
                    add(weight * a[(r, i)] * a[(r, j)]);
                }
                if i == j {
                    add(of_traction[i]);
                }
                // The forms are of tangential tractions.
                let mut products = weights.products.iter();
                let forms = if j < k { &[] } else { forms };
                for (number, second) in forms.iter().enumerate() {
                    for (first, &product) in forms[..number].iter().zip(&mut products) {
                        let of = |form: &[f32], row: usize| f64::from(form[row - k]);
                        let product = -0.5 * f64::from(product);
                        add(product * of(first, i) * of(second, j));
                        add(product * of(first, j) * of(second, i));
                    }
                }
                (form[(i, j)], form[(j, i)]) = (sum, sum);
                (sizes[(i, j)], sizes[(j, i)]) = (absolute, absolute);
            }
        }
        let scale: Vec<f64> = (0..size).map(|i| inverse_root(form[(i, i)])).collect();
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let rounding = 4.0 * (size + 2 * weights.products.len() + 36) as f64 * 0.5 * f64::EPSILON;
        let row = |i: usize| (0..size).map(|j| sizes[(i, j)] * scale[j]).sum::<f64>() * scale[i];
        let rows = largest(&mut (0..size).map(row));
        let trace: f64 = (0..size).map(|i| form[(i, i)].abs() * scale[i] * scale[i]).sum();
        let top = largest(&mut scale.iter().copied());
        let moved = top
            * (largest(&mut (0..size).map(|i| linear[i] * scale[i]))
                + 2.0 * top * self.norm * largest(&mut of_displacement.iter().map(|w| w.abs())))
            * self.asymmetry;
        let margin = rounding * rows + 2.0 * rounding * trace + moved;
        cholesky(Mat::from_fn(size, size, |i, j| {
            form[(i, j)] * scale[i] * scale[j] - if i == j { margin } else { 0.0 }
        }))
        .is_some()
    }
}

/// Returns a power of two near 1/√value, and 1 where the value is not above 0.
fn inverse_root(value: f64) -> f64 {
    if value > 0.0 && value.is_finite() {
        2_f64.powi(-(0.5 * value.log2()).round() as i32)
    } else {
        1.0
    }
}

/// Shows that every field of every case is excluded, rounding included.
///
/// # Errors
/// A [`ConeError`] says that numbers have no meaning, that cases are missing, that cones are no
/// tree, or that one is not excluded.
pub fn verify(system: &System, bound: &ConeBound) -> Result<(), ConeError> {
    check_whole(system, bound, Some(&ConeCheck::of_domain(system)))
}

/// Shows that cases and cones leave no field out, and takes it that weights exclude their cones.
///
/// # Errors
/// A [`ConeError`] says that numbers have no meaning, that cases are missing, or that cones are no
/// tree or left open.
pub(super) fn complete(system: &System, bound: &ConeBound) -> Result<(), ConeError> {
    check_whole(system, bound, None)
}

/// Checks that cases and cones leave no field out, and with a check of weights that all are
/// excluded.
fn check_whole(
    system: &System,
    bound: &ConeBound,
    check: Option<&ConeCheck>,
) -> Result<(), ConeError> {
    let states: Vec<&[NormalCase]> = bound.cases.iter().map(|case| &case.states[..]).collect();
    check_states(system, bound.mu, &states)?;
    cover::check_cover(system, Symmetries::of(system, |_, _| true), &states, &[])?;
    let rules = TreeRules { check, mu: bound.mu, first: &[], allows_open: false };
    bound.cases.iter().enumerate().try_for_each(|(index, case)| rules.check_case(index, case))
}

/// Checks the size of μ, the number of elements, and that each case has a state for each.
pub(super) fn check_states(
    system: &System,
    mu: f64,
    cases: &[&[NormalCase]],
) -> Result<(), ConeError> {
    if !is_size(mu) {
        return Err(ConeError::Mu { mu });
    }
    Ok(cover::check_states(system, cases)?)
}

/// Says if μ has a size that a certificate may have.
pub(super) fn is_size(mu: f64) -> bool {
    (SIZES[0]..=SIZES[1]).contains(&mu)
}

/// The rules that the cones of a case must keep.
pub(super) struct TreeRules<'a> {
    /// The check that weights exclude their cones; without it that is taken for shown.
    pub(super) check: Option<&'a ConeCheck>,
    /// The friction coefficient μ.
    pub(super) mu: f64,
    /// The forms of the cone that is cut, the case itself without any.
    pub(super) first: &'a [Vec<f32>],
    /// True if cones may be left open or given up.
    pub(super) allows_open: bool,
}

impl TreeRules<'_> {
    /// Shows that the cones of a case leave out none of its fields, and that all are excluded.
    pub(super) fn check_case(&self, index: usize, case: &ConeCase) -> Result<(), ConeError> {
        let tree = |reason: String| ConeError::Tree { case: index, reason };
        let numbers = |reason: String| ConeError::Numbers { case: index, reason };
        let mut cones = vec![self.first.to_vec()];
        let mut nodes = case.nodes.iter().enumerate();
        while let Some(forms) = cones.pop() {
            let Some((node, content)) = nodes.next() else {
                return Err(tree(format!("the tree ends before {} of its cones", cones.len() + 1)));
            };
            match content {
                ConeNode::Cut { form } => {
                    if forms.len() == MOST_FORMS {
                        return Err(tree(format!("node {node} cuts more than {MOST_FORMS} times")));
                    }
                    check_form(form, case.states.len())
                        .map_err(|reason| numbers(format!("the form of node {node} {reason}")))?;
                    cones.extend(cut(&forms, form));
                }
                ConeNode::Excluded(weights) => {
                    check_numbers(&case.states, forms.len(), weights)
                        .map_err(|reason| numbers(format!("node {node}: {reason}")))?;
                    let is_excluded = |check: &ConeCheck| {
                        check.is_excluded(&case.states, &forms, weights, self.mu)
                    };
                    if !self.check.is_none_or(is_excluded) {
                        return Err(ConeError::NotExcluded { case: index, node, mu: self.mu });
                    }
                }
                ConeNode::Open | ConeNode::GivenUp => {
                    if !self.allows_open {
                        return Err(ConeError::Open { case: index, node });
                    }
                }
            }
        }
        match nodes.next() {
            Some((node, _)) => Err(tree(format!("node {node} and what follows is in no cone"))),
            None => Ok(()),
        }
    }
}

/// Returns the forms of the cones into which a form cuts one, the last one first. A case is cut
/// into one, as −x needs the same friction as x.
pub(super) fn cut(forms: &[Vec<f32>], form: &[f32]) -> Vec<Vec<Vec<f32>>> {
    let with = |form: Vec<f32>| [forms, &[form]].concat();
    let opposite = || form.iter().map(|value| -value).collect();
    let second = (!forms.is_empty()).then(|| with(opposite()));
    second.into_iter().chain([with(form.to_vec())]).collect()
}

/// Checks that a form has a finite number for each tangential traction.
pub(super) fn check_form(form: &[f32], elements: usize) -> Result<(), String> {
    if form.len() != 2 * elements {
        return Err(format!("has {} numbers", form.len()));
    }
    match form.iter().all(|value| value.is_finite()) {
        true => Ok(()),
        false => Err("has a number that is not finite".to_owned()),
    }
}

/// Checks that there are as many weights as there must be, and that they are in their ranges.
fn check_numbers(states: &[NormalCase], forms: usize, weights: &ConeWeights) -> Result<(), String> {
    let count = |state: NormalCase| states.iter().filter(|&&other| other == state).count();
    let penalties = vec![weights.displacement_penalty, weights.pressure_penalty];
    for (name, values, expected, may_vanish) in [
        ("alpha", &weights.alpha, count(NormalCase::Undecided), true),
        ("beta", &weights.beta, states.len(), true),
        ("tau", &weights.tau, states.len() - count(NormalCase::Open), false),
        ("products", &weights.products, forms * forms.saturating_sub(1) / 2, true),
        ("penalties", &penalties, 2, true),
    ] {
        if values.len() != expected {
            return Err(format!("{name} has {} numbers in place of {expected}", values.len()));
        }
        let is_wrong =
            |value: f32| !value.is_finite() || value < 0.0 || (value == 0.0 && !may_vanish);
        if let Some(value) = values.iter().find(|value| is_wrong(**value)) {
            let least = if may_vanish { "at least 0" } else { "above 0" };
            return Err(format!("{name} has the number {value:e}: it must be finite and {least}"));
        }
    }
    Ok(())
}
