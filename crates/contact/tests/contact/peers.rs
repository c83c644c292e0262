//! Other programs solved these cases on the same discrete problem (midpoint projection). CONTACT's
//! half-space cases of one step meet resultants, peaks, energy and sampled tractions to 1e-6
//! relative, and numbers of elements in contact, sticking and slipping exactly. Its loading paths
//! meet the same figures after every step.

use std::sync::Arc;

use crate::common::*;
use contact::model::*;
use contact::punch::{Surface, Surfaces};
use serde_json::Value;

fn case(id: &str) {
    let file: Value = serde_json::from_str(&reference("peer_cases.json")).unwrap();
    let case = file["one_step_cases"]
        .as_array()
        .unwrap()
        .iter()
        .find(|case| case["id"] == id)
        .expect("a case of that id");
    let number = |key: &str| case["params"][key].as_f64().unwrap_or(0.0);
    let (n, width) = (number("n") as usize, number("L"));

    let mut surfaces = Surfaces::new();
    let shape = match case["shape"]["type"].as_str().unwrap() {
        // The gap is b1 x² + b3 y².
        "quadratic" => Shape::Ellipsoid {
            radius_x: 0.5 / case["shape"]["b1"].as_f64().unwrap(),
            radius_y: 0.5 / case["shape"]["b3"].as_f64().unwrap(),
        },
        "flat" => Shape::FlatRectangle { width_x: width, width_y: width },
        // The shape is the lower envelope of two paraboloids, as a height map whose pixels are the
        // elements.
        "two_spheres" => {
            let (d, radius) =
                (case["shape"]["d"].as_f64().unwrap(), case["shape"]["R"].as_f64().unwrap());
            let coordinate = |i: usize| ((i as f64 + 0.5) / n as f64 - 0.5) * width;
            let gap = |x: f64, y: f64| ((x.abs() - d).powi(2) + y * y) / (2.0 * radius);
            let heights: Vec<f64> =
                (0..n * n).map(|s| -gap(coordinate(s % n), coordinate(s / n))).collect();
            surfaces
                .insert("two spheres".to_owned(), Arc::new(Surface::new(n, n, heights).unwrap()));
            Shape::HeightMap { surface: "two spheres".to_owned(), width_x: width, width_y: width }
        }
        other => panic!("unknown shape {other}"),
    };
    // Load-controlled cases come with the approach that their solution has.
    let approach = case["expected"]["delta"].as_f64().unwrap();
    let step = Step {
        approach: Some(approach),
        shift_x: Some(number("wx")),
        shift_y: Some(number("wy")),
        twist: Some(number("phi")),
        ..Step::default()
    };
    let mut scene = scene(shape, number("G"), number("nu"), number("mu"), step);
    scene.domain = square(width);
    for method in [Method::Seidel, Method::Newton] {
        let numerics =
            Numerics { method, ..numerics(Mesh::Across(n as u32), Projection::Midpoint, 1e-10) };
        let (outcome, fields) = certified_with(&scene, &numerics, &surfaces);
        meets(
            &format!("{id}, {method:?}"),
            &case["expected"],
            &outcome.observables,
            &fields,
            width,
        );
    }
}

fn meets(id: &str, expected: &Value, o: &Observables, fields: &Fields, width: f64) {
    let n = fields.shape[0] as usize;

    let near = |name: &str, value: f64, scale: f64| {
        if let Some(reference) = expected[name].as_f64() {
            assert!(
                (value - reference).abs() <= 1e-6 * reference.abs().max(scale),
                "{id}: {name} {value:e} against {reference:e}"
            );
        }
    };
    near("P", o.load, 0.0);
    near("Qx", o.force_x, 1e-3 * o.load);
    near("Qy", o.force_y, 1e-3 * o.load);
    near("Mz", o.moment_z, 1e-3 * o.load * width);
    near("pz_max", o.peak_pressure, 0.0);
    near("pt_max", o.peak_traction, 0.0);
    near("energy", o.energy, 0.0);
    for (name, count) in [
        ("n_contact", o.contact_elements),
        ("n_stick", o.stick_elements),
        ("n_slip", o.slip_elements),
    ] {
        if let Some(reference) = expected[name].as_u64() {
            assert_eq!(count, reference, "{id}: {name}");
        }
    }
    for sample in expected["samples"].as_array().into_iter().flatten() {
        let e =
            sample["iy"].as_u64().unwrap() as usize * n + sample["ix"].as_u64().unwrap() as usize;
        for (name, field) in
            [("pz", &fields.pressure), ("px", &fields.traction_x), ("py", &fields.traction_y)]
        {
            let reference = sample[name].as_f64().unwrap();
            assert!(
                (field[e] - reference).abs() <= 1e-6 * o.peak_pressure,
                "{id}: {name} of {sample}: {}",
                field[e]
            );
        }
    }
}

macro_rules! cases {
    ($($name:ident: $id:literal),+ $(,)?) => { $(#[test] fn $name() { case($id) })+ };
}

cases! {
    hertz_at_given_approach: "hertz_pen_n32",
    hertz_at_given_load: "hertz_load_n64",
    two_spheres: "two_spheres_pen_n64",
    sphere_coupled_64: "sphere_coupled_nu0.3_mu0.3_n64",
    sphere_coupled_compressible: "sphere_coupled_nu0_mu0.5_n64",
    sphere_coupled_16: "sphere_coupled_nu0.3_mu0.3_n16",
    sphere_coupled_32: "sphere_coupled_nu0.3_mu0.3_n32",
    sphere_shifted: "sphere_shift_coupled_nu0.3_mu0.3_n32",
    sphere_twisted: "sphere_torsion_nu0.3_mu0.3_n64",
    sphere_in_gross_slip: "sphere_gross_slip_nu0.3_mu0.2_n64",
    ellipsoid_shifted_across: "ellipse_shift_y_nu0.25_mu0.4_n64",
    flat_square: "flat_square_nu0.3_mu0.3_n16",
}

#[test]
fn every_one_step_case_has_its_test() {
    let file: Value = serde_json::from_str(&reference("peer_cases.json")).unwrap();
    assert_eq!(file["one_step_cases"].as_array().unwrap().len(), 12);
}

/// Checks a path of a sphere, with approach and shift given as motions. The names of the resultants
/// are those of the one-step cases.
fn history(id: &str) {
    let file: Value = serde_json::from_str(&reference("peer_cases.json")).unwrap();
    let case = file["history_cases"]
        .as_array()
        .unwrap()
        .iter()
        .find(|case| case["id"] == id)
        .expect("a case of that id");
    let number = |key: &str| case["params"][key].as_f64().unwrap();
    let steps = case["steps"].as_array().unwrap();
    let path = steps.iter().map(|step| Step {
        approach: step["delta"].as_f64(),
        shift_x: step["wx"].as_f64(),
        ..Step::default()
    });
    assert_eq!(
        (case["shape"]["b1"].as_f64(), case["shape"]["b3"].as_f64()),
        (Some(0.5), Some(0.5))
    );
    let mut scene = scene(
        Shape::Sphere { radius: 1.0 },
        number("G"),
        number("nu"),
        number("mu"),
        Step::default(),
    );
    scene.loading = Loading::path(path.collect());
    scene.domain = square(number("L"));
    for method in [Method::Seidel, Method::Newton] {
        let numerics = Numerics {
            method,
            ..numerics(Mesh::Across(number("n") as u32), Projection::Midpoint, 1e-10)
        };
        let (path, fields) = certified_path(&scene, &numerics);
        assert_eq!(path.len(), steps.len());
        for (solved, expected) in path.iter().zip(steps) {
            meets(
                &format!("{id}, {method:?}, step {}", expected["step"]),
                expected,
                &solved.observables,
                &fields,
                number("L"),
            );
        }
    }
}

#[test]
fn pressed_then_shifted() {
    history("history_load_then_shift");
}

#[test]
fn pressed_in_eight_steps() {
    history("history_load_8_steps");
}

/// Checks a layered foundation, which others solved with influence coefficients of their own.
fn layered(id: &str) {
    let file: Value = serde_json::from_str(&reference("peer_cases.json")).unwrap();
    let case = file["layered_cases"]
        .as_array()
        .unwrap()
        .iter()
        .find(|case| case["id"] == id)
        .expect("a case of that id");
    let params = &case["params"];
    let number = |key: &str| params[key].as_f64().unwrap();
    let entry = |value: &Value, key: &str| value[key].as_f64().unwrap();
    let layer = |l: &Value| Layer {
        shear_modulus: entry(l, "G"),
        poisson: entry(l, "nu"),
        thickness: entry(l, "h"),
    };
    let base = &params["base"];
    let step =
        Step { approach: Some(number("delta")), shift_x: Some(number("wx")), ..Step::default() };
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.3, number("mu"), step);
    scene.foundation = Foundation {
        layers: params["layers"].as_array().unwrap().iter().map(layer).collect(),
        base: match base.as_str() {
            Some("rigid") => Base::Rigid,
            _ => Base::Elastic(Material {
                shear_modulus: entry(base, "G"),
                poisson: entry(base, "nu"),
            }),
        },
    };
    scene.domain = square(number("L"));
    for method in [Method::Seidel, Method::Newton] {
        let numerics = Numerics {
            method,
            ..numerics(Mesh::Across(number("n") as u32), Projection::Midpoint, 1e-10)
        };
        let (end, fields) = certified(&scene, &numerics);
        let expected = &case["expected"];
        meets(&format!("{id}, {method:?}"), expected, &end.observables, &fields, number("L"));
        let problem = contact::problem::Problem::new(&scene, &numerics, &Surfaces::new()).unwrap();
        let table = contact::influence::InfluenceTable::new(
            &problem.grid,
            &problem.elasticity,
            problem.projection,
        );
        let unit = problem.scale.length * problem.scale.compliance;
        let (diagonal, neighbour) = (table.coefficient(0, 0), table.coefficient(1, 0));
        for (name, value) in [("A0zz", diagonal.nn), ("A0xx", diagonal.xx), ("A1xz", -neighbour.nx)]
        {
            let expected = entry(expected, name);
            assert!(
                (value * unit - expected).abs() < 1e-9 * diagonal.nn * unit,
                "{id}: {name} {:e} {expected:e}",
                value * unit
            );
        }
    }
}

macro_rules! layered_cases {
    ($($name:ident: $id:literal),+ $(,)?) => { $(#[test] fn $name() { layered($id) })+ };
}

layered_cases! {
    layer_on_rigid_base: "layer_bonded_rigid_mu0.0_wx0.0_n24",
    layer_on_rigid_base_with_friction: "layer_bonded_rigid_mu0.3_wx0.0_n24",
    nearly_incompressible_layer: "layer_incompressible_rigid_mu0.0_wx0.0_n24",
    stiff_coating_shifted: "coating_stiff_on_halfspace_mu0.3_wx0.04_n24",
    layer_of_the_bases_material: "same_material_check_mu0.3_wx0.0_n24",
}

#[test]
fn every_case_has_its_test() {
    let file: Value = serde_json::from_str(&reference("peer_cases.json")).unwrap();
    let count = |kind: &str| file[kind].as_array().unwrap().len();
    assert_eq!(
        (count("one_step_cases"), count("history_cases"), count("layered_cases")),
        (12, 2, 5)
    );
}
