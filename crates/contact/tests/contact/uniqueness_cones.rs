//! Lower bounds by cones come as near to the witnesses as is asked for, and each part of a wrong one
//! is refused.

use contact::model::{Foundation, Material, Mesh, Projection};
use contact::uniqueness::cones::{ConeBound, verify};
use contact::uniqueness::{Bracket, Question, Sole, System, WitnessSearch, bracket};

/// Returns the question for a rigid rectangle of square elements on a half-space.
fn rectangle([nx, ny]: [u32; 2], poisson: f64) -> Question {
    Question {
        foundation: Foundation::half_space(Material { shear_modulus: 80e9, poisson }),
        punch: None,
        sole: Sole::Rectangle { width_x: 0.01 * f64::from(nx), width_y: 0.01 * f64::from(ny) },
        mesh: Mesh::Exact([nx, ny]),
        projection: Projection::Average,
        epsilon: 0.0,
        plane: false,
    }
}

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
