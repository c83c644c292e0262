//! The search for cases and cones that exclude all fields for a given μ.
//!
//! Elements are decided one after the other, those in the middle first, as long as the weights of
//! the case alone exclude nothing. A case that is decided and not excluded is cut: the program of
//! [`super::exclusion`] leaves a mixture of fields there, and the next form passes through its mean
//! and divides it where it is widest. So few cuts are needed as long as mixtures are of few fields.

use std::collections::{HashSet, VecDeque};

use faer::Mat;

use super::cones::{ConeBound, ConeCase, ConeCheck, ConeNode, ConeWeights};
use super::cover::{CaseBits, NormalCase, from_the_middle};
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

/// The order in which the cases are looked at that a case falls into.
#[derive(Clone, Copy)]
pub(super) enum CaseOrder {
    /// All that a case falls into comes before its neighbours.
    Depth,
    /// The neighbours come first: what is left open has few elements that are decided.
    Breadth,
}

/// The search for cones that exclude the fields of cases.
pub(super) struct ConeSearch<'a> {
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
    /// The largest number of cones that are looked at.
    most: usize,
    tried: usize,
    /// The numbers of all cases so far.
    numbers: usize,
    /// True if nothing was left open or given up.
    is_whole: bool,
    /// True if a cone was given up: then there is nothing to gain from others.
    is_given_up: bool,
    cases: Vec<ConeCase>,
}

/// A form in coordinates of a case's fields and of its tangential tractions.
#[derive(Clone)]
struct CutForm {
    coordinates: Vec<f64>,
    tractions: Vec<f32>,
}

impl CutForm {
    fn opposite(&self) -> Self {
        Self {
            coordinates: self.coordinates.iter().map(|value| -value).collect(),
            tractions: self.tractions.iter().map(|value| -value).collect(),
        }
    }
}

/// A cone that is to be looked at.
struct OpenCone {
    forms: Vec<CutForm>,
    /// The mixture of fields in it if it is known already.
    mixture: Option<Mat<f64>>,
}

impl OpenCone {
    fn coordinates(&self) -> Vec<Vec<f64>> {
        self.forms.iter().map(|form| form.coordinates.clone()).collect()
    }
}

/// The outcome of a look at a cone.
enum ConeOutcome {
    Excluded(ConeWeights),
    /// The mixture of fields that no weights exclude.
    Mixture(Mat<f64>),
    GivenUp,
}

impl<'a> ConeSearch<'a> {
    /// Makes a search that looks at no more than `most` cones.
    pub(super) fn new(system: &'a System, mu: f64, most: usize) -> Self {
        Self {
            system,
            matrix: system.matrix(),
            check: ConeCheck::of_domain(system),
            images: Symmetries::of(system, |_, _| true).images(system),
            seen: HashSet::new(),
            order: from_the_middle(system),
            mu,
            most,
            tried: 0,
            numbers: 0,
            is_whole: true,
            is_given_up: false,
            cases: Vec::new(),
        }
    }

    /// Returns the cases with their cones, some of which may be left open.
    pub(super) fn into_cases(self) -> Vec<ConeCase> {
        self.cases
    }

    /// Says if one more cone may be looked at.
    fn has_room(&self) -> bool {
        !self.is_given_up && self.tried < self.most && self.numbers <= MOST_NUMBERS
    }

    fn leave_open(&mut self) -> ConeNode {
        self.is_whole = false;
        ConeNode::Open
    }

    fn give_up(&mut self) -> ConeNode {
        (self.is_whole, self.is_given_up) = (false, true);
        ConeNode::GivenUp
    }

    /// Returns the weights of a certificate if those found exclude the cone.
    fn certified(
        &self,
        states: &[NormalCase],
        forms: &[CutForm],
        found: &CaseWeights,
    ) -> Option<ConeWeights> {
        let forms: Vec<Vec<f32>> = forms.iter().map(|form| form.tractions.clone()).collect();
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

    /// Looks for weights that exclude a cone, or for a mixture of fields if there are none.
    fn look(&mut self, states: &[NormalCase], fields: &CaseFields, cone: &OpenCone) -> ConeOutcome {
        self.tried += 1;
        match fields.exclude(&cone.coordinates(), self.mu) {
            None => ConeOutcome::GivenUp,
            Some(ExclusionOutcome::Mixture(mixture)) => ConeOutcome::Mixture(mixture),
            Some(ExclusionOutcome::Excluded(found)) => {
                // The numbers are those of the weights and of one form, for there are about as
                // many cuts as cones.
                self.numbers += 4 * states.len() + found.products.len() + found.alpha.len() + 8;
                let weights = self.certified(states, &cone.forms, &found);
                weights.map_or(ConeOutcome::GivenUp, ConeOutcome::Excluded)
            }
        }
    }

    /// Excludes a case, or all cases that it falls into, as far as there is room.
    pub(super) fn exclude(&mut self, states: Vec<NormalCase>, order: CaseOrder) {
        let mut waiting = VecDeque::from([states]);
        let next = |waiting: &mut VecDeque<_>| match order {
            CaseOrder::Depth => waiting.pop_back(),
            CaseOrder::Breadth => waiting.pop_front(),
        };
        while let Some(states) = next(&mut waiting) {
            // The image of a case that is excluded, or whose parts are, is passed over.
            let image = self.images.iter().map(|image| CaseBits::of_image(&states, image)).min();
            if image.is_none_or(|bits| self.seen.insert(bits)) {
                waiting.extend(self.exclude_or_split(states));
            }
        }
    }

    /// Excludes a case, or returns the cases that it falls into, the one to begin with last.
    fn exclude_or_split(&mut self, states: Vec<NormalCase>) -> Vec<Vec<NormalCase>> {
        if !self.has_room() {
            let nodes = vec![self.leave_open()];
            self.cases.push(ConeCase { states, nodes });
            return Vec::new();
        }
        let nodes = match CaseFields::new(&self.matrix, &states) {
            None => vec![self.give_up()],
            Some(fields) => {
                let case = OpenCone { forms: Vec::new(), mixture: None };
                match self.look(&states, &fields, &case) {
                    ConeOutcome::Excluded(weights) => vec![ConeNode::Excluded(weights)],
                    ConeOutcome::GivenUp => vec![self.give_up()],
                    ConeOutcome::Mixture(mixture) => {
                        let undecided =
                            self.order.iter().find(|&&e| states[e] == NormalCase::Undecided);
                        if let Some(&element) = undecided {
                            let with = |state: NormalCase| {
                                let mut states = states.clone();
                                states[element] = state;
                                states
                            };
                            return [NormalCase::Open, NormalCase::Closed].map(with).to_vec();
                        }
                        self.cut(&states, &fields, OpenCone { mixture: Some(mixture), ..case })
                    }
                }
            }
        };
        self.cases.push(ConeCase { states, nodes });
        Vec::new()
    }

    /// Excludes the cone of these forms of the tangential tractions in a decided case, as far as
    /// there is room.
    pub(super) fn exclude_cone(&mut self, states: Vec<NormalCase>, forms: &[Vec<f32>]) {
        let nodes = match CaseFields::new(&self.matrix, &states) {
            None => vec![self.give_up()],
            Some(fields) => {
                let form = |form: &Vec<f32>| CutForm {
                    coordinates: fields.form_of_coordinates(form),
                    tractions: form.clone(),
                };
                let forms = forms.iter().map(form).collect();
                self.cut(&states, &fields, OpenCone { forms, mixture: None })
            }
        };
        self.cases.push(ConeCase { states, nodes });
    }

    /// Cuts a cone until all that it is cut into are excluded, and returns the tree.
    fn cut(&mut self, states: &[NormalCase], fields: &CaseFields, cone: OpenCone) -> Vec<ConeNode> {
        let mut nodes = Vec::new();
        let mut open = vec![cone];
        while let Some(mut cone) = open.pop() {
            let mixture = match cone.mixture.take() {
                Some(mixture) => mixture,
                None if !self.has_room() => {
                    nodes.push(self.leave_open());
                    continue;
                }
                None => match self.look(states, fields, &cone) {
                    ConeOutcome::Mixture(mixture) if cone.forms.len() < MOST_CUTS => mixture,
                    ConeOutcome::Excluded(weights) => {
                        nodes.push(ConeNode::Excluded(weights));
                        continue;
                    }
                    ConeOutcome::Mixture(_) | ConeOutcome::GivenUp => {
                        nodes.push(self.give_up());
                        continue;
                    }
                },
            };
            let is_case = cone.forms.is_empty();
            let coordinates = match is_case {
                true => dominant(&mixture),
                false => divide(&mixture, &cone.coordinates()),
            };
            let form = CutForm { tractions: fields.form_of_tractions(&coordinates), coordinates };
            nodes.push(ConeNode::Cut { form: form.tractions.clone() });
            if is_case {
                // The mixture in a half of the fields is that of all.
                open.push(OpenCone { forms: vec![form], mixture: Some(mixture) });
            } else {
                for form in [form.opposite(), form] {
                    let forms = [&cone.forms[..], &[form]].concat();
                    open.push(OpenCone { forms, mixture: None });
                }
            }
        }
        nodes
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

/// Returns the μ to be shown for a bracket that ends at `upper` and is to have a relative width. A
/// little less than the width leaves room for rounding.
pub(super) fn goal(upper: f64, width: f64) -> f64 {
    upper * (1.0 - (1.0 - 1e-3) * width)
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
    let mut width = width;
    loop {
        let goal = goal(upper, width);
        let is_last = goal <= root.mu;
        let mu = if is_last { (1.0 - 1e-4) * root.mu } else { goal };
        let mut search = ConeSearch::new(system, mu, MOST_NODES);
        search.exclude(vec![NormalCase::Undecided; elements], CaseOrder::Depth);
        if search.is_whole {
            return Ok(ConeBound { mu, cases: search.cases });
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
