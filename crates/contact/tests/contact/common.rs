//! Scenes and files that several modules share.

use contact::model::*;
use contact::punch::Surfaces;
use contact::uniqueness::{Question, Sole};
use contact::{Operators, solve};

/// Returns a scene of one step with a rigid punch on a homogeneous half-space.
pub(crate) fn scene(shape: Shape, shear_modulus: f64, poisson: f64, mu: f64, step: Step) -> Scene {
    Scene {
        foundation: Foundation::half_space(Material { shear_modulus, poisson }),
        punch: Punch { shape, material: None },
        friction: Friction { mu },
        wear: None,
        domain: None,
        loading: Loading::path(vec![step]),
        interior: None,
    }
}

/// Returns a square Ω of side `width` around the origin.
pub(crate) fn square(width: f64) -> Option<Domain> {
    Some(Domain { width_x: width, width_y: width, center_x: 0.0, center_y: 0.0 })
}

/// Returns the question for a rigid rectangle of two widths on a half-space.
pub(crate) fn rectangle_question(
    mesh: [u32; 2],
    [width_x, width_y]: [f64; 2],
    shear_modulus: f64,
    poisson: f64,
) -> Question {
    Question {
        foundation: Foundation::half_space(Material { shear_modulus, poisson }),
        punch: None,
        sole: Sole::Rectangle { width_x, width_y },
        mesh: Mesh::Exact(mesh),
        projection: Projection::Average,
        epsilon: 0.0,
        plane: false,
    }
}

pub(crate) fn numerics(mesh: Mesh, projection: Projection, tolerance: f64) -> Numerics {
    Numerics {
        mesh,
        projection,
        epsilon: 0.0,
        ceiling: None,
        method: Method::Newton,
        tolerance,
        max_iterations: 20_000,
        simulate: Vec::new(),
    }
}

/// Solves the scene, insists on a certificate and returns the end of the path.
pub(crate) fn certified(scene: &Scene, numerics: &Numerics) -> (StepOutcome, Fields) {
    certified_with(scene, numerics, &Surfaces::new())
}

pub(crate) fn certified_with(
    scene: &Scene,
    numerics: &Numerics,
    surfaces: &Surfaces,
) -> (StepOutcome, Fields) {
    let (outcome, fields) = solve(scene, numerics, surfaces, &mut Operators::default())
        .expect("a scene with a meaning");
    assert_eq!(outcome.status, Status::Certified, "{:?}", outcome.last());
    (*outcome.last().expect("a certified path has steps"), fields)
}

/// Solves the scene, insists on a certificate and returns every increment of the path.
pub(crate) fn certified_path(scene: &Scene, numerics: &Numerics) -> (Vec<StepOutcome>, Fields) {
    let (Outcome { status, steps, .. }, fields) =
        solve(scene, numerics, &Surfaces::new(), &mut Operators::default())
            .expect("a scene with a meaning");
    assert_eq!(status, Status::Certified, "{:?}", steps.last());
    (steps, fields)
}

/// Returns the largest difference of the tractions over the peak pressure; 0 between contacts
/// without pressure.
pub(crate) fn difference(a: &Fields, b: &Fields) -> f64 {
    let is_empty = |fields: &Fields| fields.pressure.iter().all(|p| *p == 0.0);
    if is_empty(a) && is_empty(b) {
        0.0
    } else {
        a.difference(b).expect("pressures on the same elements")
    }
}

/// Returns the text of a file of tests/reference.
pub(crate) fn reference(name: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}
