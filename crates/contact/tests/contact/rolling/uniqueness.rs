//! The symmetric part of the operator of steady rolling is positive definite on contacts, so that
//! without coupling the steady state is unique.

use super::{PAIR, rolling, sphere};
use crate::common::*;
use contact::model::*;
use contact::uniqueness::rolling::{SymmetricPart, is_proved};

/// Returns the contact on so many elements across.
fn contact(n: u32, projection: Projection) -> (Scene, Fields) {
    let mut scene = sphere(PAIR, rolling(RollingHistory::Steady));
    scene.friction.mu = 0.0;
    scene.loading.steps[0].rolling = None;
    let fields = certified(&scene, &numerics(Mesh::Across(n), projection, 1e-8)).1;
    (scene, fields)
}

#[test]
fn the_symmetric_part_is_positive_on_contacts() {
    for projection in [Projection::Average, Projection::Midpoint] {
        let (scene, fields) = contact(16, projection);
        let mut before = 0.0;
        for part in [0.1, 0.25, 0.5, 1.0, 1.3] {
            let found = SymmetricPart::of(&scene, projection, &fields, part * fields.element[0])
                .unwrap()
                .unwrap_or_else(|| panic!("{projection:?} {part}"));
            assert!(found.elements > 100 && found.smallest < 1.0);
            // The longer the way up to an element, the more of A is left.
            let smallest = found.smallest * found.largest;
            assert!(part > 1.0 || smallest > before, "{projection:?} {part}: {found:?}");
            assert!(smallest > 0.0);
            before = smallest;
        }
    }
}

/// A factorisation shows for one contact on layers the law that is proved for all contacts.
#[test]
fn the_symmetric_part_of_layers_is_positive() {
    let (mut scene, fields) = contact(12, Projection::Average);
    scene.foundation.layers = vec![Layer { shear_modulus: 0.01, poisson: 0.5, thickness: 0.1 }];
    let found = SymmetricPart::of(&scene, Projection::Average, &fields, 0.3).unwrap().unwrap();
    assert!(found.smallest > 0.0, "{found:?}");
}

/// Its time and memory are bounded: what is larger is refused before anything is evaluated.
#[test]
fn the_symmetric_part_of_many_elements_is_refused() {
    let (scene, mut fields) = contact(12, Projection::Midpoint);
    fields.shape = [46, 46];
    fields.pressure = vec![1.0; 46 * 46];
    let error = SymmetricPart::of(&scene, Projection::Midpoint, &fields, 0.1).unwrap_err();
    assert_eq!(
        error.to_string(),
        "numerics.mesh = 2116 elements in contact: must be coarser: the factorisation is for at \
         most 2048 of them"
    );
    fields.pressure = vec![0.0; 46 * 46];
    assert_eq!(SymmetricPart::of(&scene, Projection::Midpoint, &fields, 0.1), Ok(None));
}

#[test]
fn uniqueness_is_proved_without_coupling_only() {
    let like = sphere(PAIR, rolling(RollingHistory::Steady));
    assert!(is_proved(&like, Projection::Average));
    assert!(!is_proved(&like, Projection::Midpoint));
    let mut unlike = sphere([0.2, 0.4], rolling(RollingHistory::Steady));
    assert!(!is_proved(&unlike, Projection::Average));
    unlike.friction.mu = 0.0;
    assert!(is_proved(&unlike, Projection::Average));
    let mut layered = like;
    layered.foundation.layers = vec![Layer { shear_modulus: 3.0, poisson: 0.4, thickness: 0.3 }];
    assert!(!is_proved(&layered, Projection::Average));
}

/// Prints the table of the book's page uniqueness.md.
#[test]
#[ignore = "a table for the documentation, some minutes"]
fn table_of_smallest_eigenvalues() {
    for projection in [Projection::Average, Projection::Midpoint] {
        for n in [8, 16, 32, 48] {
            let (scene, fields) = contact(n, projection);
            let cell = |part: f64| {
                let started = std::time::Instant::now();
                let distance = part * fields.element[0];
                let found = SymmetricPart::of(&scene, projection, &fields, distance).unwrap();
                let text = found.map_or("none".to_owned(), |f| format!("{:.2e}", f.smallest));
                format!("{text} ({:.1} s)", started.elapsed().as_secs_f64())
            };
            let cells: Vec<String> = [0.1, 0.25, 0.5, 1.0, 2.0, 4.0].map(cell).to_vec();
            println!("| {projection:?} | {n} | {} |", cells.join(" | "));
        }
    }
}
