//! The search for cases and cones that exclude all fields for a given μ.
//!
//! Elements are decided one after the other, those in the middle first, as long as the weights of
//! the case alone exclude nothing. A case that is decided and not excluded is cut: the program of
//! [`super::exclusion`] leaves a mixture of fields there, and the next form passes through its mean
//! and divides it where it is widest. So few cuts are needed as long as mixtures are of few fields.

use std::collections::HashSet;

use faer::Mat;

use super::cases::{CaseBits, NormalCase, from_the_middle};
use super::cones::{ConeBound, ConeCase, ConeCheck, ConeNode, ConeWeights};
use super::exclusion::{CaseFields, CaseWeights, ExclusionOutcome};
use super::lower::{self, Freedom, LowerError};
use super::symmetry::Symmetries;
use super::system::{System, dot};

/// The largest number of cones that are looked at for one μ.
const MOST_NODES: usize = 6000;

/// The largest number of forms of a cone. Up to 4 × 4 elements no more than ten are needed, and
/// their products are weights of the program. Where μ is above μ*, a cone about the critical field
/// stays however often it is cut.
const MOST_CUTS: usize = 16;

/// The most numbers of a bound, so that a record has room for them.
const MOST_NUMBERS: usize = 220_000;

/// The penalties that are tried, in units of the mean β and of the operator's largest diagonal
/// entry to the power that gives them their units.
const PENALTIES: [f64; 6] = [1e3, 1e4, 1e5, 1e6, 1e7, 1e8];

struct ConeSearch<'a> {
    system: &'a System,
    matrix: Mat<f64>,
    check: ConeCheck,
    /// The images of all elements under the symmetries of Ω.
    images: Vec<Vec<usize>>,
    /// The cases looked at, each as the least of its images.
    seen: HashSet<CaseBits>,
    /// The elements in the order in which they are decided.
    order: Vec<usize>,
    mu: f64,
    tried: usize,
    /// The numbers of all cases so far.
    numbers: usize,
    cases: Vec<ConeCase>,
}

/// A cone that is to be looked at.
struct OpenCone {
    /// The forms in coordinates of the case's fields.
    forms: Vec<Vec<f64>>,
    /// The mixture of fields in it if it is known already.
    mixture: Option<Mat<f64>>,
}

impl ConeSearch<'_> {
    /// Returns the weights of a certificate if those found exclude the cone.
    fn certified(
        &self,
        states: &[NormalCase],
        fields: &CaseFields,
        forms: &[Vec<f64>],
        found: &CaseWeights,
    ) -> Option<ConeWeights> {
        let forms: Vec<Vec<f32>> =
            forms.iter().map(|form| fields.form_of_tractions(form)).collect();
        let single = |values: &[f64]| values.iter().map(|value| *value as f32).collect();
        let diagonal = self.system.largest_diagonal();
        let mean = found.beta.iter().sum::<f64>() / found.beta.len() as f64;
        PENALTIES.into_iter().find_map(|penalty| {
            let weights = ConeWeights {
                alpha: single(&found.alpha),
                beta: single(&found.beta),
                tau: single(&found.tau),
                products: single(&found.products),
                displacement_penalty: (penalty * mean / diagonal) as f32,
                pressure_penalty: (penalty * mean * diagonal) as f32,
            };
            self.check.is_excluded(states, &forms, &weights, self.mu).then_some(weights)
        })
    }

    /// Looks for weights that exclude a cone, and returns a mixture of fields if there are none.
    fn look(
        &mut self,
        states: &[NormalCase],
        fields: &CaseFields,
        forms: &[Vec<f64>],
    ) -> Option<Result<ConeWeights, Mat<f64>>> {
        self.tried += 1;
        if self.tried > MOST_NODES || self.numbers > MOST_NUMBERS {
            return None;
        }
        match fields.exclude(forms, self.mu)? {
            ExclusionOutcome::Mixture(mixture) => Some(Err(mixture)),
            ExclusionOutcome::Excluded(found) => {
                // The numbers are those of the weights and of one form, for there are about as
                // many cuts as cones.
                self.numbers += 4 * states.len() + found.products.len() + found.alpha.len() + 8;
                self.certified(states, fields, forms, &found).map(Ok)
            }
        }
    }

    /// Excludes a case, or all cases that it falls into. It returns false where too much is tried.
    fn exclude(&mut self, states: Vec<NormalCase>) -> bool {
        let image = self.images.iter().map(|image| CaseBits::of_image(&states, image)).min();
        if image.is_some_and(|bits| !self.seen.insert(bits)) {
            // It is the image of a case that is excluded, or whose parts are.
            return true;
        }
        let Some(fields) = CaseFields::new(&self.matrix, &states) else { return false };
        let mixture = match self.look(&states, &fields, &[]) {
            None => return false,
            Some(Ok(weights)) => {
                self.cases.push(ConeCase { states, nodes: vec![ConeNode::Excluded(weights)] });
                return true;
            }
            Some(Err(mixture)) => mixture,
        };
        let undecided = self.order.iter().copied().find(|&e| states[e] == NormalCase::Undecided);
        let Some(element) = undecided else {
            let nodes = self.cut(&states, &fields, mixture);
            return nodes.map(|nodes| self.cases.push(ConeCase { states, nodes })).is_some();
        };
        [NormalCase::Closed, NormalCase::Open].into_iter().all(|state| {
            let mut states = states.clone();
            states[element] = state;
            self.exclude(states)
        })
    }

    /// Cuts the fields of a case until all cones are excluded, and returns the tree.
    fn cut(
        &mut self,
        states: &[NormalCase],
        fields: &CaseFields,
        mixture: Mat<f64>,
    ) -> Option<Vec<ConeNode>> {
        let first = dominant(&mixture);
        let mut nodes = vec![ConeNode::Cut { form: fields.form_of_tractions(&first) }];
        let mut open = vec![OpenCone { forms: vec![first], mixture: Some(mixture) }];
        while let Some(OpenCone { forms, mixture }) = open.pop() {
            let mixture = match mixture {
                Some(mixture) => mixture,
                None => match self.look(states, fields, &forms)? {
                    Ok(weights) => {
                        nodes.push(ConeNode::Excluded(weights));
                        continue;
                    }
                    Err(mixture) => mixture,
                },
            };
            if forms.len() == MOST_CUTS {
                return None;
            }
            let form = divide(&mixture, &forms);
            nodes.push(ConeNode::Cut { form: fields.form_of_tractions(&form) });
            let opposite: Vec<f64> = form.iter().map(|value| -value).collect();
            for form in [opposite, form] {
                open.push(OpenCone { forms: [&forms[..], &[form]].concat(), mixture: None });
            }
        }
        Some(nodes)
    }
}

/// Returns the form that passes through the mean of a mixture in a cone and divides it where it is
/// widest. Fields are compared where the sum of the cone's forms is 1.
fn divide(mixture: &Mat<f64>, forms: &[Vec<f64>]) -> Vec<f64> {
    let d = mixture.nrows();
    let mut sum = vec![0.0; d];
    for form in forms {
        sum.iter_mut().zip(form).for_each(|(sum, value)| *sum += value);
    }
    let mean = times(mixture, &sum);
    let weight = dot(&sum, &mean);
    let spread = Mat::from_fn(d, d, |i, j| mixture[(i, j)] - mean[i] * mean[j] / weight);
    let widest = dominant(&spread);
    let share = dot(&widest, &mean) / weight;
    let form: Vec<f64> = widest.iter().zip(&sum).map(|(w, s)| w - share * s).collect();
    let length = length(&form);
    form.into_iter().map(|value| value / length).collect()
}

/// Returns a vector of length 1 in the dominant directions of a positive semidefinite matrix, by
/// iteration from always the same vector.
fn dominant(matrix: &Mat<f64>) -> Vec<f64> {
    let d = matrix.nrows();
    let mut vector: Vec<f64> =
        (0..d).map(|i| ((i + 1) as f64 * 0.618_033_988_749_895).fract() - 0.5).collect();
    for _ in 0..200 {
        let next = times(matrix, &vector);
        let length = length(&next);
        if !length.is_normal() {
            break;
        }
        vector = next.into_iter().map(|value| value / length).collect();
    }
    vector
}

fn times(matrix: &Mat<f64>, vector: &[f64]) -> Vec<f64> {
    let row = |i: usize| (0..vector.len()).map(|j| matrix[(i, j)] * vector[j]).sum();
    (0..matrix.nrows()).map(row).collect()
}

fn length(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

/// Computes a lower bound of a coupled system of few elements that is by the share `width` below
/// the upper one, or by twice, four times ... that share if that takes too many cones.
///
/// # Errors
/// A [`LowerError`] says that the operator is not positive definite, or that nothing was shown.
pub(super) fn bound(system: &System, upper: f64, width: f64) -> Result<ConeBound, LowerError> {
    let elements = system.elements();
    let useless = LowerError::Weights { elements };
    let root = match lower::lower(system, Freedom::PerOrbit)? {
        lower::Lower::Bound(root) => root,
        lower::Lower::Unbounded => return Err(useless),
    };
    let symmetries = Symmetries::of(system, |_, _| true);
    let mut search = ConeSearch {
        system,
        matrix: system.matrix(),
        check: ConeCheck::new(system, symmetries),
        images: symmetries.images(system),
        seen: HashSet::new(),
        order: from_the_middle(system),
        mu: 0.0,
        tried: 0,
        numbers: 0,
        cases: Vec::new(),
    };
    // A little less than the width leaves room for rounding.
    let mut width = (1.0 - 1e-3) * width;
    loop {
        let goal = upper * (1.0 - width);
        let is_last = goal <= root.mu;
        search.mu = if is_last { (1.0 - 1e-4) * root.mu } else { goal };
        (search.tried, search.numbers) = (0, 0);
        search.cases.clear();
        search.seen.clear();
        if search.exclude(vec![NormalCase::Undecided; elements]) {
            return Ok(ConeBound { mu: search.mu, cases: search.cases });
        }
        if is_last {
            return Err(useless);
        }
        width *= 2.0;
    }
}

#[cfg(test)]
mod tests {
    use super::super::cones;
    use super::super::question::{Question, Sole};
    use super::*;
    use crate::model::{Foundation, Material, Mesh, Projection};

    #[test]
    fn a_width_that_cannot_be_had_is_doubled() {
        for (elements, width, end) in [([2, 2], 0.1, 2.70027), ([3, 3], 0.04, 2.18733)] {
            let [width_x, width_y] = elements.map(f64::from);
            let question = Question {
                foundation: Foundation::half_space(Material { shear_modulus: 1.0, poisson: 0.0 }),
                punch: None,
                sole: Sole::Rectangle { width_x, width_y },
                mesh: Mesh::Exact(elements),
                projection: Projection::Average,
                epsilon: 0.0,
                plane: false,
            };
            let system = System::new(&question).unwrap();
            // What is said to be the upper end is above it by so much that the width begins there.
            let found = bound(&system, 1.06 * end, width).unwrap();
            assert!(found.mu > 0.97 * end && found.mu < end, "{}", found.mu);
            assert_eq!(cones::verify(&system, &found), Ok(()));
        }
    }

    #[test]
    fn a_form_divides_a_mixture_at_its_mean_where_it_is_widest() {
        // The fields are (1, ±1, 0) and (1, 0, ±0.1) in equal shares.
        let mixture = Mat::from_fn(3, 3, |i, j| if i == j { [1.0, 0.5, 0.005][i] } else { 0.0 });
        let form = divide(&mixture, &[vec![1.0, 0.0, 0.0]]);
        let expected = [0.0, 1.0, 0.0];
        let sign = form[1].signum();
        form.iter().zip(expected).for_each(|(f, e)| assert!((sign * f - e).abs() < 1e-9));
    }
}
