//! The upper side of μ* meets the figures known and does not depend on units, turns and threads; a
//! witness that shows nothing is refused.

use contact::model::{Base, Foundation, Layer, Material, Mesh, Projection};
use contact::uniqueness::upper::{Upper, upper};
use contact::uniqueness::witness::{Witness, WitnessError};
use contact::uniqueness::{Bracket, Question, Sole, System, WitnessSearch, bracket, lower};

use crate::common::rectangle_question;

/// Returns the question for a rigid square on a half-space.
fn square(n: u32, poisson: f64) -> Question {
    rectangle_question([n, n], [0.01, 0.01], 80e9, poisson)
}

fn witness(question: &Question, search: WitnessSearch) -> Witness {
    match upper(question, &search) {
        Ok(Upper::Bound(witness)) => witness,
        other => panic!("{other:?}"),
    }
}

const BRIEF: WitnessSearch =
    WitnessSearch { starts: 6, kept: 2, seed: 1, cases: false, width: None };

#[test]
fn reaches_the_figures_known() {
    struct Known {
        n: u32,
        poisson: f64,
        mu: f64,
    }
    for Known { n, poisson, mu: known } in [
        Known { n: 2, poisson: 0.3, mu: 4.702_062 },
        Known { n: 2, poisson: 0.0, mu: 2.700_273 },
        Known { n: 3, poisson: 0.3, mu: 3.774_01 },
        Known { n: 3, poisson: 0.0, mu: 2.187_33 },
        Known { n: 4, poisson: 0.3, mu: 3.374_58 },
    ] {
        let question = square(n, poisson);
        let witness = witness(&question, BRIEF);
        let shown = witness.verify(&System::new(&question).unwrap()).unwrap();
        assert!(witness.mu < known + 1e-5, "{n} × {n}, ν = {poisson}: {}", witness.mu);
        // For 2 × 2 elements the two sides meet, so nothing can be below.
        assert!(n > 2 || witness.mu > known - 1e-6, "{}", witness.mu);
        assert!(shown.operator_mu <= witness.mu && shown.operator_mu > 0.99 * witness.mu);
        assert!(shown.singular_value.unwrap() < 1e-13 * shown.norm);
        assert!(shown.residual < 1e-11 * shown.norm);
    }
}

#[test]
fn the_operator_is_in_its_class_and_leaves_x_for_every_stiffness() {
    let question = square(3, 0.3);
    let system = System::new(&question).unwrap();
    let found = witness(&question, BRIEF);
    for factor in [1e-6, 1e-2, 1.0, 1e2] {
        let other = Witness { stiffness: found.stiffness * factor, ..found.clone() };
        let shown = other.verify(&system).unwrap();
        assert!(shown.operator_mu <= found.mu);
        for local in other.operator(&system) {
            assert!(
                local.c.iter().all(|c| (0.0..=1.0).contains(c)) && local.c[2] == 0.0,
                "{local:?}"
            );
            assert!(local.ab[0].hypot(local.ab[1]) <= found.mu, "{local:?}");
        }
    }
}

#[test]
fn refuses_what_shows_nothing() {
    let question = square(2, 0.3);
    let system = System::new(&question).unwrap();
    let found = witness(&question, BRIEF);
    assert!(found.verify(&system).is_ok());
    for entry in 0..found.x.len() {
        // Against x₁, the pressure of an element makes its x₁y₁ positive; a tangential traction
        // moves all y₁.
        let mut changed = found.clone();
        changed.x[entry] *= 1.0 + 1e-3;
        let mut other = found.clone();
        other.x[entry] *= 1.0 - 1e-3;
        let refused = [changed, other].map(|w| w.verify(&system));
        assert!(
            refused.iter().all(|r| matches!(
                r,
                Err(WitnessError::Normal { .. } | WitnessError::Tangential { .. })
            )),
            "{entry}: {refused:?}"
        );
    }
    let lower = Witness { mu: 0.999 * found.mu, ..found.clone() };
    assert!(matches!(lower.verify(&system), Err(WitnessError::Tangential { .. })));
    let short = Witness { x: found.x[1..].to_vec(), ..found.clone() };
    assert!(matches!(short.verify(&system), Err(WitnessError::Field { .. })));
    let nothing = Witness { x: vec![0.0; found.x.len()], ..found.clone() };
    assert!(matches!(nothing.verify(&system), Err(WitnessError::Field { .. })));
    let no_stiffness = Witness { stiffness: f64::NAN, ..found.clone() };
    assert!(matches!(
        no_stiffness.verify(&system),
        Err(WitnessError::Number { name: "stiffness", .. })
    ));
    let stiff = Witness { stiffness: 1e200, ..found.clone() };
    assert!(matches!(stiff.verify(&system), Err(WitnessError::Stiff { .. })));
    let elsewhere = System::new(&square(2, 0.2)).unwrap();
    assert!(found.verify(&elsewhere).is_err());
}

/// Numbers whose products underflow to zero show no more than others, and those of a witness show
/// no less.
#[test]
fn the_length_of_x_has_no_influence() {
    for n in [2, 11] {
        let question = square(n, 0.3);
        let system = System::new(&question).unwrap();
        let numbers = 3 * system.elements();
        let stiffness = 1.0 / system.largest_diagonal();
        for size in [1.0, 1e-200, 5e-324, 1e200] {
            let none = Witness { mu: 1e-6, stiffness, x: vec![size; numbers] };
            assert!(
                matches!(none.verify(&system), Err(WitnessError::Normal { .. })),
                "{size}: {:?}",
                none.verify(&system)
            );
        }
    }
    let question = square(2, 0.3);
    let system = System::new(&question).unwrap();
    let found = witness(&question, BRIEF);
    for power in [-1000, -600, 600, 1000] {
        let scaled =
            Witness { x: found.x.iter().map(|x| x * 2_f64.powi(power)).collect(), ..found.clone() };
        assert_eq!(scaled.verify(&system), found.verify(&system), "{power}");
    }
    // One number alone is small beside the others.
    let mut uneven = found.clone();
    uneven.x[0] *= -1e-200;
    assert!(uneven.verify(&system).is_err());
}

#[test]
fn moduli_and_lengths_have_no_influence() {
    let question = square(2, 0.3);
    let mut scaled = question.clone();
    scaled.foundation = Foundation::half_space(Material { shear_modulus: 80e21, poisson: 0.3 });
    scaled.sole = Sole::Rectangle { width_x: 1e-11, width_y: 1e-11 };
    assert_eq!(witness(&question, BRIEF), witness(&scaled, BRIEF), "to the last bit");
}

#[test]
fn a_quarter_turn_changes_nothing() {
    let mut long = square(2, 0.3);
    long.mesh = Mesh::Exact([3, 2]);
    long.sole = Sole::Rectangle { width_x: 0.03, width_y: 0.02 };
    let mut tall = long.clone();
    tall.mesh = Mesh::Exact([2, 3]);
    tall.sole = Sole::Rectangle { width_x: 0.02, width_y: 0.03 };
    let found = witness(&long, BRIEF);
    // The turn maps (x, y) → (−y, x).
    let mut turned = found.clone();
    for element in 0..6 {
        let (column, row) = (element % 3, element / 3);
        let image = column * 2 + (1 - row);
        turned.x[image] = found.x[element];
        turned.x[6 + image] = -found.x[12 + element];
        turned.x[12 + image] = found.x[6 + element];
    }
    assert!(turned.verify(&System::new(&tall).unwrap()).is_ok());
    let other = witness(&tall, BRIEF);
    assert!((found.mu - other.mu).abs() < 1e-6 * found.mu, "{} {}", found.mu, other.mu);
}

#[test]
fn without_coupling_there_is_no_end() {
    let steel = Material { shear_modulus: 80e9, poisson: 0.3 };
    for question in
        [square(4, 0.5), Question { punch: Some(steel), ..square(4, 0.3) }, square(1, 0.3)]
    {
        assert_eq!(upper(&question, &BRIEF), Ok(Upper::Unbounded));
    }
    // The weaker the coupling, the farther the end: μ* goes like one over it.
    let [weak, weaker] = [0.49, 0.499].map(|poisson| witness(&square(2, poisson), BRIEF).mu);
    assert!((weaker / weak - 10.0).abs() < 0.5, "{weak} {weaker}");
}

#[test]
fn disks_layers_and_midpoints_have_witnesses() {
    let layer = Layer { shear_modulus: 20e9, poisson: 0.2, thickness: 0.003 };
    let disk = Question { sole: Sole::Disk { radius: 0.005 }, ..square(4, 0.3) };
    assert_eq!(System::new(&disk).unwrap().elements(), 12);
    let layered = Question {
        foundation: Foundation { layers: vec![layer], base: Base::Rigid },
        ..square(2, 0.3)
    };
    let midpoint = Question { projection: Projection::Midpoint, ..square(2, 0.3) };
    let regular = Question { epsilon: 0.05, ..square(2, 0.3) };
    for question in [&disk, &layered, &midpoint, &regular] {
        let found = witness(question, BRIEF);
        assert!(found.verify(&System::new(question).unwrap()).is_ok());
    }
    // A positive ε takes from the share of the coupling.
    assert!(witness(&regular, BRIEF).mu > witness(&square(2, 0.3), BRIEF).mu);
}

/// The coupling is weak beside ε there: random starts have to find a witness that stripes do not
/// lead to.
#[test]
fn a_large_epsilon_has_witnesses_on_more_elements() {
    let question = Question { epsilon: 0.3, ..square(5, 0.3) };
    let found = witness(&question, WitnessSearch { starts: 2, ..BRIEF });
    assert!(found.verify(&System::new(&question).unwrap()).is_ok());
    assert!(found.mu < 13.5, "{}", found.mu);
}

#[test]
fn the_same_on_any_number_of_threads() {
    let found_on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| witness(&square(2, 0.3), BRIEF))
    };
    assert_eq!(found_on(1), found_on(3));
}

#[test]
fn refuses_a_question_without_meaning() {
    assert!(upper(&square(3, 0.7), &BRIEF).is_err());
    assert!(upper(&square(0, 0.3), &BRIEF).is_err());
}

#[test]
fn two_by_two_elements_close_the_bracket() {
    for poisson in [0.3, 0.0] {
        let question = square(2, poisson);
        let system = System::new(&question).unwrap();
        let Ok(Bracket::Bounded { lower, upper }) = bracket(&question, &BRIEF) else {
            panic!("no bracket")
        };
        lower::verify(&system, &lower, lower::FACTORED_ROWS).unwrap();
        upper.verify(&system).unwrap();
        assert!(
            lower.mu < upper.mu && upper.mu - lower.mu < 1e-5 * upper.mu,
            "{} … {}",
            lower.mu,
            upper.mu
        );
    }
    assert_eq!(bracket(&square(3, 0.5), &WitnessSearch::default()), Ok(Bracket::Unbounded));
}

/// Prints the witnesses of ever finer meshes, each from the two kinds of stripes that lead on a
/// section of it.
#[test]
#[ignore = "prints a table, in hours"]
fn table_of_ever_finer_meshes() {
    println!("| n | ν | upper end | times √n | seconds |");
    for n in [8, 16, 32, 64, 128, 256] {
        for poisson in [0.0, 0.3] {
            let question = square(n, poisson);
            let start = std::time::Instant::now();
            let found = witness(&question, BRIEF);
            let seconds = start.elapsed().as_secs_f64();
            found.verify(&System::new(&question).unwrap()).unwrap();
            let scaled = found.mu * f64::from(n).sqrt();
            println!("| {n} | {poisson} | {:.5} | {scaled:.3} | {seconds:.0} |", found.mu);
        }
    }
}
