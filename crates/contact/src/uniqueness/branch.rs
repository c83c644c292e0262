//! Branches of a search for cones, each of which is a job of its own.
//!
//! A search that cuts the fields of all cases into cones ([`super::cones`]) can take hours. Here it
//! is a tree of branches: a branch has the fields of a case in a cone, and its job looks at no more
//! than [`BRANCH_CONES`] cones of it. What the job excludes it proves, and what it leaves open are
//! further branches, which follow from its result alone. So the branches of a search are the same
//! whoever does their jobs, in whatever order.
//!
//! # Proof
//! [`verify`] shows for the result of one branch that every cone that it excludes is excluded, and
//! that it leaves out no field without saying so; it needs no other result. [`grow`] follows the
//! tree. Where nothing is open it puts the cones of all branches together, and shows that the
//! cases and cones leave no field out, by the same code that checks a bound of one job, which knows
//! of no branches.
//!
//! Cases that are images of each other under the symmetries of Ω are one branch.

use std::collections::{HashMap, HashSet};

use serde::{Deserialize, Serialize};

use super::cone_search::{self, CaseOrder, ConeSearch};
use super::cones::{self, ConeBound, ConeCase, ConeCheck, ConeError, ConeNode, TreeRules};
use super::cover::{self, NormalCase};
use super::question::{MOST_CASE_ELEMENTS, Question};
use super::symmetry::Symmetries;
use super::system::System;
use crate::model::SceneError;

/// The largest number of cones that the job of a branch looks at.
pub const BRANCH_CONES: usize = 32;

/// The largest number of cones after which a search may be asked to begin no further generation.
pub const MOST_BRANCHED_CONES: usize = 50_000;

/// The fields of a case in a cone that are to be excluded for a friction coefficient.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Branch {
    /// The friction coefficient μ.
    pub mu: f64,
    /// The state of each element of Ω.
    pub states: Vec<NormalCase>,
    /// The forms l of the 2k tangential tractions that are at least 0 in the cone. There are none
    /// where an element is undecided.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub forms: Vec<Vec<f32>>,
}

impl Branch {
    /// Checks that the branch has a meaning, as far as that can be told without the operator.
    ///
    /// # Errors
    /// A [`SceneError`] names the part that has none.
    pub fn validate(&self, question: &Question) -> Result<(), SceneError> {
        let error = |key: &str, value: String, expected: String| {
            Err(SceneError { key: key.to_owned(), value, expected })
        };
        if question.plane {
            let expected = "must be false, as cases of a strip are not cut".to_owned();
            return error("search.plane", "true".to_owned(), expected);
        }
        if !cones::is_size(self.mu) {
            let expected = "must be within 1e-30 and 1e30".to_owned();
            return error("branch.mu", format!("{:e}", self.mu), expected);
        }
        let elements = self.states.len();
        if !(1..=MOST_CASE_ELEMENTS).contains(&elements) {
            let expected = format!("must be of 1 to {MOST_CASE_ELEMENTS} elements");
            return error("branch.states", format!("{elements} elements"), expected);
        }
        if self.forms.is_empty() {
            return Ok(());
        }
        if self.states.contains(&NormalCase::Undecided) {
            let expected = "must be empty where an element is undecided".to_owned();
            return error("branch.forms", format!("{} forms", self.forms.len()), expected);
        }
        if self.forms.len() > cones::MOST_FORMS {
            let expected = format!("must be at most {}", cones::MOST_FORMS);
            return error("branch.forms", format!("{} forms", self.forms.len()), expected);
        }
        for form in &self.forms {
            if let Err(reason) = cones::check_form(form, elements) {
                let expected = format!("must be of {} finite numbers", 2 * elements);
                return error("branch.forms", format!("a form that {reason}"), expected);
            }
        }
        Ok(())
    }

    /// Returns a number for each part, by which branches are told apart to the last bit.
    fn identity(&self) -> Vec<u32> {
        let states = self.states.iter().map(|state| *state as u32);
        states.chain(self.forms.iter().flatten().map(|value| value.to_bits())).collect()
    }
}

/// Returns the μ that branches have to show for a bracket that ends at `upper` and is to have a
/// relative width.
pub fn goal(upper: f64, width: f64) -> f64 {
    cone_search::goal(upper, width)
}

/// Excludes as much of a branch as a job does.
///
/// # Errors
/// A [`SceneError`] says that the question or the branch has no meaning.
pub fn exclude(question: &Question, branch: &Branch) -> Result<Vec<ConeCase>, SceneError> {
    branch.validate(question)?;
    let system = System::new(question)?;
    let (states, elements) = (branch.states.clone(), system.elements());
    if states.len() != elements {
        return Err(SceneError {
            key: "branch.states".to_owned(),
            value: format!("{} elements", states.len()),
            expected: format!("must be of the {elements} elements of Ω"),
        });
    }
    let mut search = ConeSearch::new(&system, branch.mu, BRANCH_CONES);
    if branch.forms.is_empty() {
        search.exclude(states, CaseOrder::Breadth);
    } else {
        search.exclude_cone(states, &branch.forms);
    }
    Ok(search.into_cases())
}

/// The reason why the result of a branch, or of all branches, proves nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BranchError {
    /// A case or a cone is wrong.
    #[error(transparent)]
    Cone(#[from] ConeError),
    /// A case is none of the branch.
    #[error("case {case} is not one of the branch")]
    Foreign {
        /// The index of the case.
        case: usize,
    },
    /// The branch itself is left open.
    #[error("the branch is left as open as it was")]
    Idle,
    /// The result of a branch is missing, is none of a cone, or was put in another place already.
    #[error("a branch has no result of its own: case {states} with {forms} forms")]
    Missing {
        /// The states of the case, in letters.
        states: String,
        /// The number of forms.
        forms: usize,
    },
}

/// Returns the states of a case as letters: u undecided, o open, c closed.
pub fn letters(states: &[NormalCase]) -> String {
    let letter = |state: &NormalCase| match state {
        NormalCase::Undecided => 'u',
        NormalCase::Open => 'o',
        NormalCase::Closed => 'c',
    };
    states.iter().map(letter).collect()
}

/// Shows that the result of a branch excludes what it says, rounding included, and that it is open
/// about all else.
///
/// # Errors
/// A [`BranchError`] says that cases are missing or foreign, that cones are no tree, or that one is
/// not excluded.
pub fn verify(system: &System, branch: &Branch, cases: &[ConeCase]) -> Result<(), BranchError> {
    let mut states: Vec<&[NormalCase]> = vec![&branch.states];
    states.extend(cases.iter().map(|case| &case.states[..]));
    cones::check_states(system, branch.mu, &states)?;
    let is_part = |states: &[NormalCase]| {
        let mut pairs = branch.states.iter().zip(states);
        pairs.all(|(of, state)| of == state || *of == NormalCase::Undecided)
    };
    for (index, case) in cases.iter().enumerate() {
        if !is_part(&case.states) || (!branch.forms.is_empty() && index > 0) {
            return Err(BranchError::Foreign { case: index });
        }
        if case.states == branch.states && case.nodes.first() == Some(&ConeNode::Open) {
            return Err(BranchError::Idle);
        }
    }
    let symmetries = Symmetries::of(system, |_, _| true);
    cover::check_cover(system, symmetries, &states[1..], &branch.states)
        .map_err(ConeError::from)?;
    let check = ConeCheck::of_domain(system);
    let rules =
        TreeRules { check: Some(&check), mu: branch.mu, first: &branch.forms, allows_open: true };
    let mut numbered = cases.iter().enumerate();
    Ok(numbered.try_for_each(|(index, case)| rules.check_case(index, case))?)
}

/// The result of a branch, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BranchResult<'a> {
    /// The cases and cones that its job left.
    Cases(&'a [ConeCase]),
    /// The job was not done yet.
    Missing,
    /// The job was done, and showed nothing.
    Unsolved,
}

/// The branches of a search as far as their results determine them.
#[derive(Clone, Debug, PartialEq)]
pub struct Growth {
    /// The branches, generation by generation.
    pub branches: Vec<Branch>,
    /// The number of cones that their jobs looked at.
    pub cones: usize,
    /// The state of the search.
    pub end: GrowthEnd,
}

/// The state of a search by branches.
#[derive(Clone, Debug, PartialEq)]
pub enum GrowthEnd {
    /// Results are missing.
    Pending,
    /// The job of a branch showed nothing.
    Unsolved,
    /// A cone was given up.
    GivenUp,
    /// A further generation would begin after as many cones as there may be before one.
    Full,
    /// All fields are excluded, and the cones of all branches leave none out.
    Whole(ConeBound),
    /// The results do not fit together.
    Unfit(BranchError),
}

/// Follows the branches of a search for `mu` by the results that `result` knows. No generation is
/// begun if its branches and the cones before it are more than `most`. Branches come generation by
/// generation, and a generation follows from all results of the one before, so they do not depend
/// on the order in which results arrive.
pub fn grow<'a>(
    system: &System,
    mu: f64,
    most: usize,
    mut result: impl FnMut(&Branch) -> BranchResult<'a>,
) -> Growth {
    let images = Symmetries::of(system, |_, _| true).images(system);
    let states = vec![NormalCase::Undecided; system.elements()];
    let root = Branch { mu, states, forms: Vec::new() };
    let mut seen = HashSet::from([root.identity()]);
    let mut generation = vec![root];
    let mut results: Vec<KeptResult<'a>> = Vec::new();
    // Cases are looked at by several jobs where parts overlap with images of others. The first one
    // counts.
    let mut looked_at: HashSet<Vec<u8>> = HashSet::new();
    let mut growth = Growth { branches: Vec::new(), cones: 0, end: GrowthEnd::Pending };
    loop {
        growth.branches.extend_from_slice(&generation);
        let known: Vec<BranchResult<'a>> = generation.iter().map(&mut result).collect();
        let mut children = Vec::new();
        let mut is_given_up = false;
        for (branch, result) in generation.iter().zip(&known) {
            let BranchResult::Cases(cases) = result else { continue };
            growth.cones += cases.iter().map(cones_of).sum::<usize>();
            let mut kept = Vec::new();
            for case in *cases {
                let is_open = case.nodes == [ConeNode::Open];
                let image = || letters(&cover::least_image(&case.states, &images)).into_bytes();
                let is_known = branch.forms.is_empty()
                    && match is_open {
                        true => looked_at.contains(&image()),
                        false => !looked_at.insert(image()),
                    };
                if !is_known {
                    is_given_up |= case.nodes.contains(&ConeNode::GivenUp);
                    children.extend(open_branches(branch, case, &images));
                    kept.push(case);
                }
            }
            results.push(KeptResult { branch: branch.clone(), cases: kept });
        }
        growth.end = match () {
            () if known.contains(&BranchResult::Missing) => GrowthEnd::Pending,
            () if known.contains(&BranchResult::Unsolved) => GrowthEnd::Unsolved,
            () if is_given_up => GrowthEnd::GivenUp,
            () => {
                children.retain(|branch| seen.insert(branch.identity()));
                if children.is_empty() {
                    growth.end = match whole(system, mu, &results) {
                        Ok(bound) => GrowthEnd::Whole(bound),
                        Err(error) => GrowthEnd::Unfit(error),
                    };
                    return growth;
                }
                if growth.cones + children.len() <= most {
                    generation = children;
                    continue;
                }
                GrowthEnd::Full
            }
        };
        return growth;
    }
}

/// The result of a branch without the cases that others have as well.
struct KeptResult<'a> {
    branch: Branch,
    cases: Vec<&'a ConeCase>,
}

/// Returns the number of cones of a case that its job looked at.
fn cones_of(case: &ConeCase) -> usize {
    case.nodes.iter().filter(|node| **node != ConeNode::Open).count()
}

/// Returns the branches that the result of a branch leaves open in a case.
fn open_branches(branch: &Branch, case: &ConeCase, images: &[Vec<usize>]) -> Vec<Branch> {
    let of = |forms: Vec<Vec<f32>>| Branch {
        mu: branch.mu,
        states: match forms.is_empty() {
            true => cover::least_image(&case.states, images),
            false => case.states.clone(),
        },
        forms,
    };
    let mut open = Vec::new();
    visit_cones(&branch.forms, &case.nodes, |forms, node| {
        if *node == ConeNode::Open {
            open.push(of(forms.to_vec()));
        }
    });
    open
}

/// Visits the nodes of a tree of cones with the forms of each, as far as the tree goes.
fn visit_cones(
    first: &[Vec<f32>],
    nodes: &[ConeNode],
    mut visitor: impl FnMut(&[Vec<f32>], &ConeNode),
) {
    let mut cones = vec![first.to_vec()];
    for node in nodes {
        let Some(forms) = cones.pop() else { return };
        visitor(&forms, node);
        if let ConeNode::Cut { form } = node {
            if forms.len() == cones::MOST_FORMS {
                return;
            }
            cones.extend(cones::cut(&forms, form));
        }
    }
}

/// Puts the cones of all branches together, and shows that they leave no field out.
///
/// # Errors
/// A [`BranchError`] says that a result is missing, or that cases and cones leave fields out.
fn whole(system: &System, mu: f64, results: &[KeptResult<'_>]) -> Result<ConeBound, BranchError> {
    let mut by_branch: HashMap<Vec<u32>, &[&ConeCase]> =
        results.iter().map(|kept| (kept.branch.identity(), &kept.cases[..])).collect();
    let mut bound = ConeBound { mu, cases: Vec::new() };
    for KeptResult { branch, cases } in results.iter().filter(|kept| kept.branch.forms.is_empty()) {
        for case in cases.iter().filter(|case| case.nodes != [ConeNode::Open]) {
            let mut nodes = Vec::new();
            join(branch, case, &mut by_branch, &mut nodes)?;
            bound.cases.push(ConeCase { states: case.states.clone(), nodes });
        }
    }
    cones::complete(system, &bound)?;
    Ok(bound)
}

/// Appends the nodes of a case with those of the branches that it leaves open in their places. Each
/// branch is taken out of `results`, so that none is in two places.
fn join(
    branch: &Branch,
    case: &ConeCase,
    results: &mut HashMap<Vec<u32>, &[&ConeCase]>,
    nodes: &mut Vec<ConeNode>,
) -> Result<(), BranchError> {
    let mut places = Vec::new();
    visit_cones(&branch.forms, &case.nodes, |forms, node| {
        places.push((forms.to_vec(), node.clone()));
    });
    // What is in no cone stays, to be refused.
    let rest = case.nodes[places.len()..].to_vec();
    for (forms, node) in places {
        if node != ConeNode::Open {
            nodes.push(node);
            continue;
        }
        let open = Branch { mu: branch.mu, states: case.states.clone(), forms };
        match results.remove(&open.identity()) {
            Some([only]) if only.states == open.states => join(&open, only, results, nodes)?,
            _ => {
                let (states, forms) = (letters(&open.states), open.forms.len());
                return Err(BranchError::Missing { states, forms });
            }
        }
    }
    nodes.extend(rest);
    Ok(())
}
