//! The fields converge: the distance between grids is a metric, errors in L₂ against closed forms
//! fall in order, and ε → 0 leads to the solution without regularisation.

use crate::common::*;
use contact::assess::{Errors, closed_form, norms};
use contact::model::*;
use contact::theory::{PowerLaw, hertz_sphere, power_law};
use proptest::prelude::*;

fn newton(mesh: u32, projection: Projection) -> Numerics {
    numerics(Mesh::Across(mesh), projection, 1e-8)
}

/// Builds fields from `values`, which holds the blocks of the pressure and of both tractions one
/// after the other.
fn fields(shape: [u32; 2], origin: [f64; 2], element: [f64; 2], values: &[f64]) -> Fields {
    let k = (shape[0] * shape[1]) as usize;
    let block = |c: usize| values[c * k..][..k].to_vec();
    Fields {
        shape,
        origin,
        element,
        pressure: block(0),
        traction_x: block(1),
        traction_y: block(2),
        ..Fields::default()
    }
}

fn any_fields() -> impl Strategy<Value = Fields> {
    ([1..7u32, 1..7u32], [-1.0..1.0f64, -1.0..1.0f64], [0.1..0.6f64, 0.1..0.6f64])
        .prop_flat_map(|(shape, origin, element)| {
            let values = prop::collection::vec(-1.0..1.0f64, 3 * (shape[0] * shape[1]) as usize);
            (Just(shape), Just(origin), Just(element), values)
        })
        .prop_map(|(shape, origin, element, values)| fields(shape, origin, element, &values))
}

/// Returns the same fields on a grid of `parts` times as many elements along each axis.
fn split(whole: &Fields, parts: [u32; 2]) -> Fields {
    let shape = [whole.shape[0] * parts[0], whole.shape[1] * parts[1]];
    let element = [0, 1].map(|axis| whole.element[axis] / f64::from(parts[axis]));
    let origin =
        [0, 1].map(|axis| whole.origin[axis] + 0.5 * (element[axis] - whole.element[axis]));
    let from =
        |e: u32| (e / shape[0] / parts[1] * whole.shape[0] + e % shape[0] / parts[0]) as usize;
    let values: Vec<f64> = [&whole.pressure, &whole.traction_x, &whole.traction_y]
        .into_iter()
        .flat_map(|block| (0..shape[0] * shape[1]).map(move |e| block[from(e)]))
        .collect();
    fields(shape, origin, element, &values)
}

fn distances(a: &Fields, b: &Fields) -> [f64; 2] {
    let norm = norms::distance(a, b).unwrap();
    [norm.pressure, norm.traction]
}

proptest! {
    #[test]
    fn the_distance_between_grids_is_a_metric(
        a in any_fields(),
        b in any_fields(),
        c in any_fields(),
    ) {
        let (ab, ba, bc, ac) =
            (distances(&a, &b), distances(&b, &a), distances(&b, &c), distances(&a, &c));
        prop_assert_eq!(ab, ba);
        prop_assert_eq!(distances(&a, &a), [0.0; 2]);
        for k in 0..2 {
            prop_assert!(ac[k] <= (ab[k] + bc[k]) * (1.0 + 1e-14));
            prop_assert!(ab[k] > 0.0);
        }
        let direct: f64 =
            a.pressure.iter().map(|p| p * p).sum::<f64>() * a.element[0] * a.element[1];
        prop_assert!((norms::norm(&a).unwrap().pressure / direct.sqrt() - 1.0).abs() < 1e-13);
    }

    #[test]
    fn splitting_elements_changes_nothing(
        a in any_fields(),
        b in any_fields(),
        parts in [1..5u32, 1..5u32],
    ) {
        let finer = split(&a, parts);
        prop_assert_eq!(distances(&a, &finer), [0.0; 2]);
        for (whole, parted) in distances(&a, &b).iter().zip(distances(&finer, &b)) {
            prop_assert!((whole / parted - 1.0).abs() < 1e-12, "{whole} {parted}");
        }
        for (whole, parted) in
            norms::resultants(&a).unwrap().iter().zip(norms::resultants(&finer).unwrap())
        {
            prop_assert!((whole - parted).abs() < 1e-13);
        }
    }

    /// Local means are a projection: they shorten distances and keep a field that is already
    /// constant on the parts.
    #[test]
    fn local_means_are_a_projection(
        a in any_fields(),
        b in any_fields(),
        nx in 1..6usize,
        ny in 1..6usize,
    ) {
        let onto = norms::parts(&b, [nx, ny]).unwrap();
        let (p, q) =
            (norms::local_means(&a, &onto).unwrap(), norms::local_means(&b, &onto).unwrap());
        for (means, whole) in distances(&p, &q).iter().zip(distances(&a, &b)) {
            prop_assert!(*means <= whole * (1.0 + 1e-12));
        }
        let again = norms::local_means(&p, &onto).unwrap();
        prop_assert!(distances(&p, &again).iter().all(|distance| *distance < 1e-14));
    }
}

/// Fits the power of the mesh size that a figure of the errors follows over a ladder of meshes.
fn order(errors: &[(f64, Errors)], figure: &str) -> PowerLaw {
    let ladder: Vec<(f64, f64)> =
        errors.iter().map(|(h, errors)| (*h, errors.get(figure).unwrap())).collect();
    let law = power_law(&ladder).unwrap();
    let shown: Vec<String> = ladder.iter().map(|(_, error)| format!("{error:.2e}")).collect();
    eprintln!(
        "{figure}: {shown:?}, order {:.3} ± {:.3} from rung {}",
        law.slope, law.standard_error, law.first
    );
    law
}

/// Returns the errors against the closed form of the scene, with the size of an element, on every
/// mesh.
fn against_closed_form(
    scene: &Scene,
    projection: Projection,
    meshes: &[u32],
) -> Vec<(f64, Errors)> {
    let exact = closed_form(scene).expect("a scene with a closed form");
    eprintln!("{} ({}), {projection:?}", exact.name, exact.source);
    let on_mesh = |n: &u32| {
        let (path, fields) = certified_path(scene, &newton(*n, projection));
        (
            fields.element[0],
            Errors::against_closed_form(path.last().unwrap(), &fields, &exact).unwrap(),
        )
    };
    meshes.iter().map(on_mesh).collect()
}

const MESHES: [u32; 5] = [12, 24, 48, 96, 192];

fn pressed(shape: Shape) -> Scene {
    scene(shape, 1.0, 0.3, 0.0, Step { approach: Some(1.0), ..Step::default() })
}

/// No piecewise constants do better than h (∫ |∇p|²)^½, and since p goes like the root of the
/// distance s from the edge, that integral of 1/s over s > h is a logarithm. The order is therefore
/// that of h √ln(1/h), a tenth below 1 on these meshes and rising.
#[test]
fn the_pressure_of_a_sphere_converges_with_first_order() {
    for projection in [Projection::Average, Projection::Midpoint] {
        let errors =
            against_closed_form(&pressed(Shape::Sphere { radius: 1.0 }), projection, &MESHES);
        let law = order(&errors, "pressure");
        assert!(
            (0.85..1.0).contains(&law.slope) && errors[4].1.figures.pressure.unwrap() < 2e-2,
            "{law:?}"
        );
        let logarithm = |h: f64| h * (1.0 / h).ln().sqrt();
        let corrected: Vec<(f64, f64)> = errors
            .iter()
            .map(|(h, errors)| (logarithm(0.5 * h), errors.figures.pressure.unwrap()))
            .collect();
        let law = power_law(&corrected).unwrap();
        eprintln!("over h √ln(1/h): {:.3} ± {:.3}", law.slope, law.standard_error);
        assert!((0.95..1.1).contains(&law.slope), "{law:?}");
        let local = order(&errors, "local_pressure");
        assert!(local.slope > 1.2, "{local:?}");
        for figure in ["load", "peak_pressure", "contact_area"] {
            order(&errors, figure);
        }
    }
}

#[test]
fn the_pressures_of_ellipsoid_and_cone_converge() {
    for shape in [Shape::Ellipsoid { radius_x: 2.0, radius_y: 0.5 }, Shape::Cone { angle: 0.3 }] {
        let errors = against_closed_form(&pressed(shape), Projection::Average, &MESHES[..4]);
        let law = order(&errors, "pressure");
        assert!((0.75..1.15).contains(&law.slope), "{law:?}");
        order(&errors, "load");
    }
}

/// Returns a scene of like spheres with ν = 0, pressed and then pulled.
fn like_spheres(pull: Step) -> Scene {
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 2.0, 0.0, 0.4, Step::default());
    scene.punch.material = Some(Material { shear_modulus: 2.0, poisson: 0.0 });
    scene.loading = Loading::path(vec![Step { approach: Some(1.0), ..Step::default() }, pull]);
    scene.domain = square(3.0);
    scene
}

#[test]
fn the_tractions_of_cattaneo_and_mindlin_converge() {
    let limit = 0.4 * hertz_sphere(2.0, 1.0, 1.0).load;
    for (x, y) in [(0.5, 0.0), (0.3, -0.4)] {
        let pull = Step { force_x: Some(x * limit), force_y: Some(y * limit), ..Step::default() };
        let errors = against_closed_form(&like_spheres(pull), Projection::Average, &MESHES[..4]);
        let law = order(&errors, "traction");
        assert!(
            (0.75..1.0).contains(&law.slope) && errors[3].1.figures.traction.unwrap() < 8e-2,
            "{law:?}"
        );
        assert!(order(&errors, "shift").slope > 1.2);
        order(&errors, "stick_area");
        order(&errors, "local_traction");
        assert!(
            errors.iter().all(|(_, errors)| errors.figures.tangential_force.is_none()),
            "it is prescribed"
        );
    }
}

/// The pressure of a flat punch is not in L₂; its local means converge all the same, with the first
/// order of the load.
#[test]
fn a_flat_punch_converges_in_the_mean() {
    let mut scene = scene(Shape::FlatDisk { radius: 1.0 }, 1.0, 0.5, 1.0, Step::default());
    scene.loading = Loading::path(vec![Step {
        approach: Some(1.0),
        shift_x: Some(0.2),
        tilt_y: Some(0.1),
        twist: Some(0.1),
        ..Step::default()
    }]);
    let errors = against_closed_form(&scene, Projection::Average, &MESHES[..4]);
    let unbounded = ["pressure", "traction", "peak_pressure"];
    assert!(
        errors.iter().all(|(_, errors)| unbounded.iter().all(|name| errors.get(name).is_none()))
    );
    for figure in ["load", "tangential_force", "moment", "local_pressure", "local_traction"] {
        let law = order(&errors, figure);
        assert!(law.slope > 0.8 && errors[3].1.local.pressure.unwrap() < 2e-2, "{figure}: {law:?}");
    }
}

/// Without a closed form the finest mesh stands in; its own error hides the order of the last rungs
/// before it.
#[test]
fn errors_against_a_finer_mesh_follow_those_against_the_closed_form() {
    let scene = pressed(Shape::Sphere { radius: 1.0 });
    let leg = *scene.loading.legs().last().unwrap();
    let (finest, finest_fields) = certified(&scene, &newton(192, Projection::Average));
    let exact = closed_form(&scene).unwrap();
    for n in [12, 24, 48] {
        let (end, fields) = certified(&scene, &newton(n, Projection::Average));
        let computed =
            Errors::against_solution(&end, &fields, &finest, &finest_fields, &leg).unwrap();
        let closed = Errors::against_closed_form(&end, &fields, &exact).unwrap();
        for ((name, computed), (_, closed)) in computed.named().zip(closed.named()) {
            assert_eq!(computed.is_some(), closed.is_some(), "{name}");
            if ["pressure", "load", "peak_pressure"].contains(&name) {
                let ratio = computed.unwrap() / closed.unwrap();
                assert!((0.8..1.2).contains(&ratio), "{name} at {n}: {ratio}");
            }
        }
    }
    let self_errors =
        Errors::against_solution(&finest, &finest_fields, &finest, &finest_fields, &leg).unwrap();
    assert!(
        self_errors.named().filter_map(|(_, error)| error).all(|error| error == 0.0),
        "{self_errors:?}"
    );
}

/// Returns the solutions of equation (3) for falling ε, and that of equation (1), on one mesh.
fn regularised(
    scene: &Scene,
    mesh: u32,
    epsilons: &[f64],
) -> (Vec<(StepOutcome, Fields)>, (StepOutcome, Fields)) {
    let solve =
        |epsilon: f64| certified(scene, &Numerics { epsilon, ..newton(mesh, Projection::Average) });
    (epsilons.iter().map(|epsilon| solve(*epsilon)).collect(), solve(0.0))
}

/// For ε → 0 under a sphere p* is in L₂, and the convergence is strong.
#[test]
fn the_regularised_pressure_of_a_sphere_converges_strongly() {
    let scene = scene(
        Shape::Sphere { radius: 1.0 },
        1.0,
        0.3,
        0.3,
        Step { approach: Some(1.0), ..Step::default() },
    );
    let epsilons = [0.3, 0.1, 0.03, 0.01, 0.003, 0.001];
    let (solutions, (_, limit)) = regularised(&scene, 64, &epsilons);
    let distances: Vec<_> = solutions
        .iter()
        .map(|(_, fields)| norms::relative_distance(fields, &limit).unwrap())
        .collect();
    for component in [
        |relative: &norms::Relative| relative.pressure,
        |relative: &norms::Relative| relative.traction,
    ] {
        let ladder: Vec<(f64, f64)> = epsilons
            .iter()
            .copied()
            .zip(distances.iter().map(|distance| component(distance).unwrap()))
            .collect();
        let law = power_law(&ladder).unwrap();
        eprintln!(
            "{ladder:?}: order {:.3} ± {:.3} from {}",
            law.slope, law.standard_error, law.first
        );
        assert!(ladder.windows(2).all(|pair| pair[1].1 < pair[0].1), "{ladder:?}");
        assert!(law.slope > 0.6 && ladder[5].1 < 2e-2, "{law:?}");
    }
}

/// For ε → 0 under a flat punch p* is not in L₂, so the norm grows beyond all bounds and only the
/// local means and the load converge. The mesh is fine against the layer at the edge into which ε
/// smears the singularity.
#[test]
fn the_regularised_pressure_of_a_flat_punch_converges_weakly() {
    let scene = scene(
        Shape::FlatDisk { radius: 1.0 },
        1.0,
        0.3,
        0.0,
        Step { approach: Some(1.0), ..Step::default() },
    );
    let exact = closed_form(&scene).unwrap();
    let epsilons = [0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625];
    let (solutions, _) = regularised(&scene, 128, &epsilons);
    let errors: Vec<(f64, Errors)> = epsilons
        .iter()
        .zip(&solutions)
        .map(|(epsilon, (end, fields))| {
            (*epsilon, Errors::against_closed_form(end, fields, &exact).unwrap())
        })
        .collect();
    for figure in ["load", "local_pressure"] {
        let law = order(&errors, figure);
        assert!(law.slope > 0.5, "{figure}: {law:?}");
    }
    let squares: Vec<f64> =
        solutions.iter().map(|(_, fields)| norms::norm(fields).unwrap().pressure.powi(2)).collect();
    let steps: Vec<f64> = squares.windows(2).map(|pair| pair[1] - pair[0]).collect();
    eprintln!("‖p‖² {squares:.3?}, steps {steps:.3?}");
    // The integral ∫ p² over all but a layer of width ε at the edge gains a constant for each
    // halving, and not less and less.
    assert!(steps.iter().all(|step| *step > 0.0) && steps[4] > 0.7 * steps[3], "{squares:?}");
}

/// A scene without a closed form says so.
#[test]
fn closed_forms_are_refused_where_a_condition_fails() {
    let step = Step { approach: Some(1.0), ..Step::default() };
    let sphere = |poisson: f64, mu: f64, step: Step| {
        scene(Shape::Sphere { radius: 1.0 }, 1.0, poisson, mu, step)
    };
    let name = |scene: &Scene| closed_form(scene).map(|exact| exact.name);
    assert_eq!(name(&sphere(0.3, 0.0, step)), Some("Hertz"));
    assert_eq!(
        name(&sphere(0.5, 0.3, step)),
        Some("Hertz"),
        "an incompressible body does not couple"
    );
    assert_eq!(name(&sphere(0.3, 0.3, step)), None, "coupling with friction");
    assert_eq!(name(&sphere(0.3, 0.0, Step { tilt_x: Some(0.1), ..step })), None);
    assert_eq!(
        name(&sphere(0.3, 0.0, Step { force_x: Some(0.1), ..step })),
        None,
        "no friction to carry it"
    );
    assert_eq!(name(&sphere(0.3, 0.0, Step { approach: Some(-1.0), ..step })), None);
    assert_eq!(
        name(&sphere(0.5, 0.3, Step { shift_x: Some(0.1), ..step })),
        None,
        "ν > 0 slips across"
    );
    let mut cut = sphere(0.3, 0.0, step);
    cut.domain = square(1.9);
    assert_eq!(name(&cut), None, "Ω cuts the contact");
    cut.domain = square(2.1);
    assert_eq!(name(&cut), Some("Hertz"));
    let mut layered = sphere(0.3, 0.0, step);
    layered.foundation.layers = vec![Layer { shear_modulus: 2.0, poisson: 0.3, thickness: 1.0 }];
    assert_eq!(name(&layered), None);
    layered.foundation.layers[0].shear_modulus = 1.0;
    assert_eq!(name(&layered), Some("Hertz"), "a layer of the base's material is none");
    let pull = Step { shift_x: Some(0.1), ..Step::default() };
    assert_eq!(name(&like_spheres(pull)), Some("Cattaneo and Mindlin"));
    assert_eq!(
        name(&like_spheres(Step { approach: Some(0.9), ..pull })),
        None,
        "the load changes while the punch is moved"
    );
    assert_eq!(
        name(&like_spheres(Step { force_x: Some(10.0), shift_x: None, ..pull })),
        None,
        "gross sliding"
    );
    assert_eq!(name(&like_spheres(Step { twist: Some(0.1), ..pull })), None);
    let mut back = like_spheres(pull);
    back.loading.steps.push(Step { shift_x: Some(0.0), ..Step::default() });
    assert_eq!(name(&back), None, "the path matters");
    let mut at_once = like_spheres(Step { approach: Some(1.0), ..pull });
    at_once.loading.steps.remove(0);
    assert_eq!(name(&at_once), Some("Cattaneo and Mindlin"));
    at_once.loading.steps[0].increments = 2;
    assert_eq!(name(&at_once), None);
    let disk = |poisson: f64, mu: f64, step: Step| {
        scene(Shape::FlatDisk { radius: 1.0 }, 1.0, poisson, mu, step)
    };
    assert_eq!(name(&disk(0.3, 0.0, step)), Some("Boussinesq's disk"));
    assert_eq!(
        name(&disk(0.3, 10.0, step)),
        None,
        "Mossakovskii's full stick needs infinite friction"
    );
    assert_eq!(name(&disk(0.5, 0.3, Step { shift_x: Some(0.1), ..step })), Some("Mindlin's disk"));
    assert_eq!(name(&disk(0.5, 0.3, Step { shift_x: Some(1.0), ..step })), None, "it slips");
    assert_eq!(
        name(&disk(0.5, 0.3, Step { tilt_x: Some(0.4), ..step })),
        Some("Boussinesq's disk, tilted")
    );
    assert_eq!(name(&disk(0.5, 0.3, Step { tilt_x: Some(0.6), ..step })), None, "it lifts off");
    assert_eq!(
        name(&scene(Shape::FlatRectangle { width_x: 1.0, width_y: 1.0 }, 1.0, 0.3, 0.0, step)),
        None
    );
}
