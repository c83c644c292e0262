//! A search by branches shows what a search in one job shows, and no bound is claimed with a hole.

use std::collections::HashMap;

use contact::model::{Foundation, Layer};
use contact::uniqueness::branch::{
    BRANCH_CONES, Branch, BranchError, BranchResult, Growth, GrowthEnd, exclude, goal, grow, verify,
};
use contact::uniqueness::cones::{self, ConeCase, ConeError, ConeNode};
use contact::uniqueness::cover::{CoverError, NormalCase};
use contact::uniqueness::{Question, Sole, System, WitnessSearch, bracket};

use super::uniqueness_cases::rectangle;

/// The upper end of 3 × 3 elements, ν = 0.
const UPPER: f64 = 2.187_33;

/// The results of all branches of a search, in the order in which they came.
struct Search {
    question: Question,
    system: System,
    mu: f64,
    results: Vec<(Branch, Vec<ConeCase>)>,
}

impl Search {
    /// Does the jobs of a search. The last one of those that are wanted comes first if it is told
    /// to go `backwards`, and one alone is done before the search is asked again.
    fn run(question: Question, mu: f64, most: usize, backwards: bool) -> (Search, Growth) {
        let system = System::new(&question).unwrap();
        let mut search = Search { question, system, mu, results: Vec::new() };
        loop {
            let growth = search.growth(most);
            let known: Vec<&Branch> = search.results.iter().map(|(branch, _)| branch).collect();
            let mut wanted: Vec<Branch> =
                growth.branches.iter().filter(|branch| !known.contains(branch)).cloned().collect();
            if wanted.is_empty() {
                return (search, growth);
            }
            if backwards {
                wanted = wanted.split_off(wanted.len() - 1);
            }
            for branch in wanted {
                let cases = exclude(&search.question, &branch).unwrap();
                assert_eq!(verify(&search.system, &branch, &cases), Ok(()));
                search.results.push((branch, cases));
            }
        }
    }

    fn growth(&self, most: usize) -> Growth {
        grow(&self.system, self.mu, most, |branch| {
            let found = self.results.iter().find(|(other, _)| other == branch);
            found.map_or(BranchResult::Missing, |(_, cases)| BranchResult::Cases(cases))
        })
    }

    /// Returns the end of the search with some results changed.
    fn end_with(&self, change: impl FnOnce(&mut Vec<(Branch, Vec<ConeCase>)>)) -> GrowthEnd {
        let mut results = self.results.clone();
        change(&mut results);
        let changed = Search {
            question: self.question.clone(),
            system: self.system.clone(),
            mu: self.mu,
            results,
        };
        changed.growth(usize::MAX).end
    }
}

#[test]
fn branches_show_three_by_three_elements_to_a_per_cent() {
    let mu = goal(UPPER, 0.01);
    let (search, growth) = Search::run(rectangle([3, 3], 0.0), mu, 1000, false);
    let GrowthEnd::Whole(bound) = &growth.end else { panic!("{:?}", growth.end) };
    assert!(search.results.len() > 5, "{}", search.results.len());
    assert_eq!(bound.mu, mu);
    // The check of a bound of one job knows nothing of branches.
    assert_eq!(cones::verify(&search.system, bound), Ok(()));
    let looked = |cases: &[ConeCase]| {
        let nodes = cases.iter().flat_map(|case| &case.nodes);
        nodes.filter(|node| **node != ConeNode::Open).count()
    };
    assert!(search.results.iter().all(|(_, cases)| looked(cases) <= BRANCH_CONES + 1));
    // The order in which results arrive leaves no trace.
    let (backwards, same) = Search::run(rectangle([3, 3], 0.0), mu, 1000, true);
    assert_eq!(same, growth);
    assert!(backwards.results.iter().all(|result| search.results.contains(result)));
}

/// A cone goes from job to job by forms in single precision, whatever the sizes of pressures and
/// tractions are.
#[test]
fn branches_narrow_brackets_of_hard_bodies() {
    let layer = Layer { shear_modulus: 8e9, poisson: 0.3, thickness: 0.002 };
    let base = rectangle([3, 2], 0.3);
    let layered = Foundation { layers: vec![layer], ..base.foundation.clone() };
    let brief = WitnessSearch { starts: 1, kept: 1, seed: 1, ..WitnessSearch::default() };
    for (question, width) in [
        (rectangle([4, 1], 0.0), 0.02),
        (Question { epsilon: 0.1, ..rectangle([3, 3], 0.3) }, 0.05),
        // The weaker the coupling, the farther apart are the sizes of pressures and tractions.
        (rectangle([3, 2], 0.499), 0.02),
        (Question { foundation: layered, ..base }, 0.05),
        (Question { sole: Sole::Disk { radius: 0.01 }, ..rectangle([4, 4], 0.0) }, 0.1),
    ] {
        let bracket = bracket(&question, &brief).unwrap();
        let mu = goal(bracket.ends().unwrap()[1], width);
        let (search, growth) = Search::run(question, mu, 2000, false);
        let GrowthEnd::Whole(bound) = growth.end else {
            panic!("{} branches: {:?}", growth.branches.len(), search.question)
        };
        assert_eq!(cones::verify(&search.system, &bound), Ok(()));
    }
}

#[test]
fn a_search_that_may_not_go_on_says_so() {
    let mu = goal(UPPER, 0.01);
    let (search, growth) = Search::run(rectangle([3, 3], 0.0), mu, 60, false);
    assert!(growth.end == GrowthEnd::Full, "{} cones", growth.cones);
    assert!(growth.branches.len() == search.results.len());
    // No generation is begun after so many cones.
    let (_, longer) = Search::run(rectangle([3, 3], 0.0), mu, 1000, false);
    assert!(growth.cones < longer.cones && longer.branches.starts_with(&growth.branches));
    // Above μ* a cone about the critical field stays however often it is cut.
    let (_, growth) = Search::run(rectangle([3, 3], 0.0), 1.01 * UPPER, 5000, false);
    assert!(growth.end == GrowthEnd::GivenUp, "{} cones", growth.cones);
}

#[test]
fn no_bound_has_a_hole() {
    let (search, growth) = Search::run(rectangle([3, 3], 0.0), goal(UPPER, 0.01), 1000, false);
    assert!(matches!(growth.end, GrowthEnd::Whole(_)));
    let with_forms =
        search.results.iter().position(|(branch, _)| !branch.forms.is_empty()).unwrap();
    // Each result is needed.
    for index in 0..search.results.len() {
        let end = search.end_with(|results| drop(results.remove(index)));
        assert_eq!(end, GrowthEnd::Pending, "{index}");
    }
    // The result of a branch does not serve for another one.
    let mut others = HashMap::new();
    for index in 1..search.results.len() {
        let end = search.end_with(|results| {
            let cases = results[index - 1].1.clone();
            results[index].1 = cases;
        });
        let name = match end {
            GrowthEnd::Pending => "asks for others",
            GrowthEnd::Unfit(_) => "is unfit",
            // It stands in a cone with as many forms, which its weights seldom exclude. Where they
            // do, they are a proof as good as any.
            GrowthEnd::Whole(bound) => match cones::verify(&search.system, &bound) {
                Err(ConeError::NotExcluded { .. }) => "is not excluded",
                Ok(()) => "is excluded by both",
                Err(error) => panic!("{index}: {error}"),
            },
            _ => panic!("{index} serves for another"),
        };
        *others.entry(name).or_insert(0) += 1;
    }
    let is_seen = |name: &&str| others.contains_key(*name);
    assert!(["is unfit", "is not excluded"].iter().all(is_seen), "{others:?}");
    // A case that is not there, a tree without its end, and what is in no cone are missed.
    let end = search.end_with(|results| drop(results[0].1.remove(0)));
    assert!(
        matches!(
            end,
            GrowthEnd::Pending
                | GrowthEnd::Unfit(BranchError::Cone(ConeError::Cover(CoverError::Missing { .. })))
        ),
        "{end:?}"
    );
    let end = search.end_with(|results| drop(results[with_forms].1[0].nodes.pop()));
    assert!(matches!(end, GrowthEnd::Unfit(_)), "{end:?}");
    let end = search.end_with(|results| results[with_forms].1.clear());
    assert!(matches!(end, GrowthEnd::Unfit(BranchError::Missing { .. })), "{end:?}");
    let end = search.end_with(|results| {
        let twice = results[with_forms].1[0].clone();
        results[with_forms].1.push(twice);
    });
    assert!(matches!(end, GrowthEnd::Unfit(BranchError::Missing { .. })), "{end:?}");
    // A branch that stays as open as it was ends nothing, and does not go on for ever.
    let end = search.end_with(|results| results[with_forms].1[0].nodes = vec![ConeNode::Open]);
    assert!(matches!(end, GrowthEnd::Unfit(_)), "{end:?}");
    let end = search.end_with(|results| {
        let states = results[0].0.states.clone();
        results[0].1 = vec![ConeCase { states, nodes: vec![ConeNode::Open] }];
    });
    assert!(matches!(end, GrowthEnd::Unfit(_)), "{end:?}");
}

/// Parts overlap with images of others, so that several jobs may look at one case.
#[test]
fn a_case_that_several_branches_have_is_taken_once() {
    let (search, _) = Search::run(rectangle([3, 3], 0.0), goal(UPPER, 0.003), 1000, false);
    let is_cut = |case: &&ConeCase| case.nodes.len() > 1 && case.nodes.contains(&ConeNode::Open);
    let mut of_cases = search.results.iter().filter(|(branch, _)| branch.forms.is_empty());
    let cut = of_cases.find_map(|(_, cases)| cases.iter().find(is_cut)).unwrap().clone();
    let of_cases = |(branch, _): &(Branch, Vec<ConeCase>)| branch.forms.is_empty();
    let last = search.results.iter().rposition(of_cases).unwrap();
    for place in [0, last] {
        let end = search.end_with(|results| results[place].1.push(cut.clone()));
        let GrowthEnd::Whole(bound) = end else { panic!("{place}: no bound") };
        assert_eq!(cones::verify(&search.system, &bound), Ok(()));
    }
}

#[test]
fn a_wrong_result_of_a_branch_is_refused_in_each_of_its_parts() {
    let (search, _) = Search::run(rectangle([3, 3], 0.0), goal(UPPER, 0.01), 1000, false);
    let find = |is_wanted: &dyn Fn(&Branch, &[ConeCase]) -> bool| {
        let mut results = search.results.iter();
        results.find(|(branch, cases)| is_wanted(branch, cases)).unwrap().clone()
    };
    let (root, of_root) = search.results[0].clone();
    let (cone, of_cone) = find(&|branch, cases| {
        let excluded = |node: &&ConeNode| matches!(node, ConeNode::Excluded(_));
        !branch.forms.is_empty() && cases[0].nodes.iter().filter(excluded).count() > 1
    });
    let error = |branch: &Branch, cases: &[ConeCase]| {
        verify(&search.system, branch, cases).expect_err("a wrong result")
    };
    let missing =
        |error| matches!(error, BranchError::Cone(ConeError::Cover(CoverError::Missing { .. })));
    let mut fewer = of_root.clone();
    fewer.remove(0);
    assert!(missing(error(&root, &fewer)));
    assert!(missing(error(&cone, &[])));
    // The proof is that of the branch's friction, states and forms alone.
    let other = Branch { mu: 1.02 * cone.mu, ..cone.clone() };
    assert!(matches!(error(&other, &of_cone), BranchError::Cone(ConeError::NotExcluded { .. })));
    let mut states = cone.states.clone();
    states[0] = match states[0] {
        NormalCase::Open => NormalCase::Closed,
        _ => NormalCase::Open,
    };
    let other = Branch { states, ..cone.clone() };
    assert_eq!(error(&other, &of_cone), BranchError::Foreign { case: 0 });
    let mut forms = cone.forms.clone();
    forms.pop();
    let other = Branch { forms, ..cone.clone() };
    assert!(matches!(error(&other, &of_cone), BranchError::Cone(_)));
    // The first case of two is enough.
    let twice = [of_cone.clone(), of_cone.clone()].concat();
    assert_eq!(error(&cone, &twice), BranchError::Foreign { case: 1 });
    let mut idle = of_cone.clone();
    idle[0].nodes = vec![ConeNode::Open];
    assert_eq!(error(&cone, &idle), BranchError::Idle);
    let mut heavier = of_cone.clone();
    for node in &mut heavier[0].nodes {
        if let ConeNode::Excluded(weights) = node {
            weights.products.iter_mut().for_each(|product| *product *= 3.0);
        }
    }
    assert!(matches!(error(&cone, &heavier), BranchError::Cone(ConeError::NotExcluded { .. })));
    let mut longer = of_cone.clone();
    longer[0].nodes.push(ConeNode::Open);
    assert!(matches!(error(&cone, &longer), BranchError::Cone(ConeError::Tree { .. })));
}

#[test]
fn a_branch_without_a_meaning_is_refused() {
    let question = rectangle([3, 3], 0.0);
    let root = Branch { mu: 2.0, states: vec![NormalCase::Undecided; 9], forms: Vec::new() };
    assert_eq!(root.validate(&question), Ok(()));
    let closed = vec![NormalCase::Closed; 9];
    let refused = |branch: Branch| exclude(&question, &branch).expect_err("a wrong branch").key;
    assert_eq!(refused(Branch { mu: f64::NAN, ..root.clone() }), "branch.mu");
    assert_eq!(refused(Branch { states: closed[1..].to_vec(), ..root.clone() }), "branch.states");
    assert_eq!(
        refused(Branch { states: vec![NormalCase::Open; 17], ..root.clone() }),
        "branch.states"
    );
    for forms in [vec![vec![1.0; 17]], vec![vec![f32::NAN; 18]], vec![vec![1.0; 18]; 41]] {
        assert_eq!(
            refused(Branch { states: closed.clone(), forms, ..root.clone() }),
            "branch.forms"
        );
    }
    assert_eq!(refused(Branch { forms: vec![vec![1.0; 18]], ..root.clone() }), "branch.forms");
    let plane = Question { plane: true, ..rectangle([3, 1], 0.0) };
    assert!(exclude(&plane, &root).is_err());
}
