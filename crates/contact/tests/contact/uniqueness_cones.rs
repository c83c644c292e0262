//! Lower bounds by cones come as near to the witnesses as is asked for, and each part of a wrong one
//! is refused.

use contact::model::{Foundation, Layer};
use contact::uniqueness::cones::{ConeBound, ConeError, ConeNode, ConeWeights, verify};
use contact::uniqueness::cover::{CoverError, NormalCase};
use contact::uniqueness::{Bracket, BracketError, Question, Sole, System, WitnessSearch, bracket};

use super::uniqueness_cases::rectangle;

/// Returns the effort of a search that is brief about the upper end.
fn brief(width: f64) -> WitnessSearch {
    WitnessSearch { starts: 1, kept: 1, seed: 1, cases: true, width: Some(width) }
}

fn by_cones(question: &Question, width: f64) -> (ConeBound, f64) {
    match bracket(question, &brief(width)) {
        Ok(Bracket::Cones { lower, upper }) => (lower, upper.mu),
        other => panic!("{other:?}"),
    }
}

#[test]
fn three_by_three_elements_are_known_to_a_per_cent() {
    for (poisson, known) in [(0.0, 2.187_33), (0.3, 3.774_01)] {
        let question = rectangle([3, 3], poisson);
        let (bound, upper) = by_cones(&question, 0.01);
        assert!(bound.mu >= 0.99 * upper && bound.mu < known, "{} {upper}", bound.mu);
        assert_eq!(verify(&System::new(&question).unwrap(), &bound), Ok(()));
    }
}

#[test]
fn a_bracket_has_the_width_that_is_asked_for_whatever_the_bodies() {
    let layer = Layer { shear_modulus: 8e9, poisson: 0.3, thickness: 0.002 };
    let base = rectangle([3, 2], 0.3);
    let layered = Foundation { layers: vec![layer], ..base.foundation.clone() };
    for (question, width) in [
        (rectangle([3, 2], 0.2), 0.02),
        (rectangle([4, 1], 0.0), 0.02),
        (Question { epsilon: 0.1, ..rectangle([2, 2], 0.45) }, 0.1),
        // The weaker the coupling, the farther apart are the sizes of pressures and tractions.
        (rectangle([3, 2], 0.499), 0.02),
        (Question { foundation: layered, ..base }, 0.05),
        (Question { sole: Sole::Disk { radius: 0.01 }, ..rectangle([4, 4], 0.0) }, 0.1),
    ] {
        let (bound, upper) = by_cones(&question, width);
        let found = 1.0 - bound.mu / upper;
        assert!(found > 0.0 && found <= width, "{found}: {question:?}");
        assert_eq!(verify(&System::new(&question).unwrap(), &bound), Ok(()));
    }
}

/// Returns the first leaf of a case that is cut, and the case.
fn leaf(bound: &mut ConeBound) -> &mut ConeWeights {
    let nodes = cut_case(bound);
    let leaf = nodes.iter_mut().find_map(|node| match node {
        ConeNode::Excluded(weights) => Some(weights),
        _ => None,
    });
    leaf.expect("a cone that is excluded")
}

/// Returns the nodes of the first case that is cut.
fn cut_case(bound: &mut ConeBound) -> &mut Vec<ConeNode> {
    let cut = bound.cases.iter_mut().find(|case| case.nodes.len() > 1);
    &mut cut.expect("a case that is cut").nodes
}

#[test]
fn a_wrong_bound_is_refused_in_each_of_its_parts() {
    let question = rectangle([3, 3], 0.0);
    let system = System::new(&question).unwrap();
    let (bound, upper) = by_cones(&question, 0.03);
    assert_eq!(verify(&system, &bound), Ok(()));
    let change = |change: &dyn Fn(&mut ConeBound)| {
        let mut changed = bound.clone();
        change(&mut changed);
        match verify(&system, &changed).expect_err("a wrong bound") {
            ConeError::Cover(CoverError::Missing { .. }) => "missing",
            ConeError::Cover(CoverError::States { .. }) => "states",
            ConeError::Numbers { .. } => "numbers",
            ConeError::Tree { .. } => "tree",
            ConeError::Mu { .. } => "mu",
            ConeError::NotExcluded { .. } => "not excluded",
            ConeError::Cover(CoverError::Elements { .. }) => "elements",
            ConeError::Open { .. } => "open",
        }
    };
    // No weights exclude the field of the witness for its own μ.
    assert_eq!(change(&|bound| bound.mu = upper), "not excluded");
    for mu in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
        assert_eq!(change(&|bound| bound.mu = mu), "mu");
    }
    // Cases that are images of parts of others may be left out, but not one that is cut.
    assert_eq!(change(&|bound| bound.cases.clear()), "missing");
    assert_eq!(change(&|bound| bound.cases.retain(|case| case.nodes.len() == 1)), "missing");
    let undecided = |bound: &mut ConeBound| {
        let cut = bound.cases.iter_mut().find(|case| case.nodes.len() > 1).unwrap();
        cut.states[0] = NormalCase::Undecided;
    };
    assert_eq!(change(&undecided), "numbers");
    assert_eq!(change(&|bound| bound.cases[0].states.truncate(8)), "states");

    assert_eq!(change(&|bound| drop(cut_case(bound).pop())), "tree");
    assert_eq!(change(&|bound| cut_case(bound).clear()), "tree");
    let twice = |bound: &mut ConeBound| {
        let nodes = cut_case(bound);
        nodes.push(nodes.last().unwrap().clone());
    };
    assert_eq!(change(&twice), "tree");
    // Cuts without end are refused before anything is made of them.
    let deep = |bound: &mut ConeBound| {
        let nodes = cut_case(bound);
        *nodes = vec![nodes[0].clone(); 100];
    };
    assert_eq!(change(&deep), "tree");
    let form = |change: fn(&mut Vec<f32>)| {
        move |bound: &mut ConeBound| match &mut cut_case(bound)[1] {
            ConeNode::Cut { form } => change(form),
            _ => panic!("no cut"),
        }
    };
    // The weights fit the forms that they were made for.
    assert_eq!(change(&form(|form| form.reverse())), "not excluded");
    assert_eq!(change(&form(|form| form.fill(0.0))), "not excluded");
    assert_eq!(change(&form(|form| form.truncate(17))), "numbers");
    assert_eq!(change(&form(|form| form[3] = f32::NAN)), "numbers");
    assert_eq!(change(&form(|form| form[3] = f32::INFINITY)), "numbers");

    assert_eq!(change(&|bound| leaf(bound).beta.fill(0.0)), "not excluded");
    assert_eq!(change(&|bound| leaf(bound).tau[0] *= 1e-6), "not excluded");
    assert_eq!(change(&|bound| leaf(bound).products.fill(0.0)), "not excluded");
    assert_eq!(change(&|bound| leaf(bound).products[0] *= 1e3), "not excluded");
    assert_eq!(change(&|bound| leaf(bound).displacement_penalty = 0.0), "not excluded");
    assert_eq!(change(&|bound| leaf(bound).beta[0] = -1.0), "numbers");
    assert_eq!(change(&|bound| leaf(bound).tau[0] = 0.0), "numbers");
    assert_eq!(change(&|bound| leaf(bound).products[0] = f32::NAN), "numbers");
    assert_eq!(change(&|bound| leaf(bound).products.truncate(1)), "numbers");
    assert_eq!(change(&|bound| leaf(bound).alpha.push(1.0)), "numbers");
    assert_eq!(change(&|bound| leaf(bound).pressure_penalty = -1.0), "numbers");
    assert_eq!(change(&|bound| leaf(bound).displacement_penalty = f32::INFINITY), "numbers");
    // On another Ω the same numbers show nothing.
    let other = System::new(&rectangle([4, 3], 0.0)).unwrap();
    assert!(matches!(verify(&other, &bound), Err(ConeError::Cover(CoverError::States { .. }))));
}

#[test]
fn a_width_without_a_meaning_is_refused() {
    let question = rectangle([2, 2], 0.0);
    for width in [0.0, 1e-4, 0.6, -0.1, f64::NAN] {
        match bracket(&question, &brief(width)) {
            Err(BracketError::Scene(error)) => assert_eq!(error.key, "search.width"),
            other => panic!("{other:?}"),
        }
    }
    let without_cases = WitnessSearch { cases: false, ..brief(0.1) };
    assert!(matches!(bracket(&question, &without_cases), Err(BracketError::Scene(_))));
    assert_eq!(bracket(&rectangle([3, 3], 0.5), &brief(0.1)), Ok(Bracket::Unbounded));
}

/// The bounds of squares, and their times.
#[test]
#[ignore = "takes minutes"]
fn table_of_cones() {
    for (n, poisson, width) in [
        (2, 0.0, 0.01),
        (3, 0.0, 0.03),
        (3, 0.0, 0.01),
        (3, 0.0, 0.003),
        (3, 0.3, 0.03),
        (3, 0.3, 0.01),
        (3, 0.3, 0.003),
        (4, 0.0, 0.06),
        (4, 0.0, 0.03),
        (4, 0.3, 0.06),
        (4, 0.3, 0.03),
    ] {
        let question = rectangle([n, n], poisson);
        let system = System::new(&question).unwrap();
        let start = std::time::Instant::now();
        let (bound, upper) = by_cones(&question, width);
        let searched = start.elapsed().as_secs_f64();
        let start = std::time::Instant::now();
        assert_eq!(verify(&system, &bound), Ok(()));
        let nodes: usize = bound.cases.iter().map(|case| case.nodes.len()).sum();
        println!(
            "{n} ν = {poisson}, {width}: {:.6} {upper:.6} {:.4}, {} cases, {nodes} nodes, {searched:.2} s, {:.2} s",
            bound.mu,
            1.0 - bound.mu / upper,
            bound.cases.len(),
            start.elapsed().as_secs_f64()
        );
    }
}

/// The bounds of layers and of ε, and their times.
#[test]
#[ignore = "takes minutes"]
fn table_of_bodies() {
    let layered = |n: u32, shear_modulus: f64| {
        let question = rectangle([n, n], 0.3);
        let layer = Layer { shear_modulus, poisson: 0.3, thickness: 0.003 * f64::from(n) };
        let foundation = Foundation { layers: vec![layer], ..question.foundation.clone() };
        Question { foundation, ..question }
    };
    for n in [2, 3] {
        for (name, question) in [
            ("ε = 0.1", Question { epsilon: 0.1, ..rectangle([n, n], 0.3) }),
            ("ε = 1", Question { epsilon: 1.0, ..rectangle([n, n], 0.3) }),
            ("stiff", layered(n, 80e11)),
            ("soft", layered(n, 80e7)),
        ] {
            let root = match bracket(
                &question,
                &WitnessSearch { cases: false, width: None, ..brief(0.1) },
            ) {
                Ok(Bracket::Bounded { lower, .. }) => lower.mu,
                other => panic!("{other:?}"),
            };
            let cases = match bracket(&question, &WitnessSearch { width: None, ..brief(0.1) }) {
                Ok(Bracket::Cases { lower, .. }) => lower.mu,
                other => panic!("{other:?}"),
            };
            for starts in [1, 24] {
                for width in [0.03, 0.01] {
                    let start = std::time::Instant::now();
                    let search = WitnessSearch { starts, ..brief(width) };
                    let Ok(Bracket::Cones { lower, upper }) = bracket(&question, &search) else {
                        panic!("no cones")
                    };
                    let nodes: usize = lower.cases.iter().map(|case| case.nodes.len()).sum();
                    println!(
                        "{n} {name} {starts}, {width}: {root:.5} {cases:.5} {:.5} {:.5} {:.4}, {nodes} nodes, {:.1} s",
                        lower.mu,
                        upper.mu,
                        1.0 - lower.mu / upper.mu,
                        start.elapsed().as_secs_f64()
                    );
                }
            }
        }
    }
}
