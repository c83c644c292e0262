//! Rolling contact against two independent programs, which solved the same discrete problems
//! (midpoint projection): steady states and paths, of like and unlike bodies, with creepages and
//! spin. Numbers of elements agree exactly, resultants to 1e-8 of μP and fields to 1e-8 of their
//! peaks. `inverse` gives forces instead of creepages; `laws` and `theory` need no other program;
//! `limits` goes to the ends of what rolls, `refused` beyond them, `random` has scenes of all kinds,
//! and `uniqueness` says what else could be a solution.

mod inverse;
mod laws;
mod limits;
mod random;
mod refused;
mod theory;
mod uniqueness;

use std::ops::ControlFlow;

use crate::common::*;
use contact::model::*;
use contact::punch::Surfaces;
use contact::{Operators, solve_watched};
use serde_json::Value;

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("a number {key} in {value}"))
}

/// The values of ν of two like bodies.
const PAIR: [f64; 2] = [0.28; 2];

/// Returns rolling without creepages and spin, by an element in each increment.
fn rolling(history: RollingHistory) -> Rolling {
    Rolling {
        creepage_x: Some(0.0),
        creepage_y: Some(0.0),
        spin: Some(0.0),
        spin_center: 0.0,
        direction: RollingDirection::Forward,
        dq: None,
        distance: None,
        history,
        imposed: ImposedCreepages::default(),
    }
}

/// Returns a sphere that is pressed and rolls, with G = 1 and these ν of the foundation and the
/// punch; the contact has a radius of about 1.
fn sphere(poisson: [f64; 2], rolling: Rolling) -> Scene {
    let step = Step { normal_force: Some(0.20943951), rolling: Some(rolling), ..Step::default() };
    let radius = 0.5 / 0.056548668;
    let mut scene = scene(Shape::Sphere { radius }, 1.0, poisson[0], 0.3, step);
    scene.punch.material = Some(Material { shear_modulus: 1.0, poisson: poisson[1] });
    scene.domain = square(2.4);
    scene
}

/// Returns the case of this `id` in a list of the file.
pub(crate) fn case(list: &str, id: &str) -> Value {
    let file: Value = serde_json::from_str(&reference("rolling_cases.json")).unwrap();
    let cases = file[list].as_array().unwrap();
    cases.iter().find(|case| case["id"] == id).expect("a case of that id").clone()
}

/// Returns the step of a case; its punch and the foundation are on the other sides of the signs.
pub(crate) fn step(case: &Value, step: &Value) -> Step {
    let load = if step["load"].is_object() { &step["load"] } else { &case["load"] };
    let given = Step {
        normal_force: load["normal_force"].as_f64(),
        approach: load["approach"].as_f64(),
        ..Step::default()
    };
    let history = match step["kind"].as_str().unwrap() {
        "shift" => {
            let minus = |key: &str| Some(-number(step, key));
            let (shift_x, shift_y, twist) = (minus("wx"), minus("wy"), minus("wphi"));
            return Step { shift_x, shift_y, twist, ..given };
        }
        "steady" => RollingHistory::Steady,
        "transient" => RollingHistory::Transient,
        other => panic!("unknown kind {other}"),
    };
    let direction = match number(step, "direction") {
        1.0 => RollingDirection::Forward,
        _ => RollingDirection::Backward,
    };
    let rolling = Rolling {
        creepage_x: Some(number(step, "xi")),
        creepage_y: Some(number(step, "eta")),
        spin: Some(number(step, "phi")),
        spin_center: number(step, "x0"),
        direction,
        dq: Some(number(step, "dq")),
        distance: None,
        history,
        imposed: ImposedCreepages::default(),
    };
    Step { rolling: Some(rolling), ..given }
}

/// Returns the scene and the numerics of a case with these steps.
pub(crate) fn problem(case: &Value, steps: Vec<Step>) -> (Scene, Numerics) {
    let material = |body: u32| Material {
        shear_modulus: number(&case["material"], &format!("G{body}")),
        poisson: number(&case["material"], &format!("nu{body}")),
    };
    let mesh = &case["mesh"];
    let [nx, ny] = ["nx", "ny"].map(|key| number(mesh, key));
    let (width_x, width_y) = (nx * number(mesh, "dx"), ny * number(mesh, "dy"));
    let scene = Scene {
        foundation: Foundation::half_space(material(1)),
        punch: Punch {
            shape: Shape::Ellipsoid {
                radius_x: 0.5 / number(&case["geometry"], "A"),
                radius_y: 0.5 / number(&case["geometry"], "B"),
            },
            material: Some(material(2)),
        },
        friction: Friction { mu: number(case, "mu") },
        wear: None,
        domain: Some(Domain {
            width_x,
            width_y,
            center_x: number(mesh, "x_left") + 0.5 * width_x,
            center_y: number(mesh, "y_bottom") + 0.5 * width_y,
        }),
        loading: Loading::path(steps),
        interior: None,
    };
    let mesh = Mesh::Exact([nx as u32, ny as u32]);
    (scene, numerics(mesh, Projection::Midpoint, 1e-10))
}

/// Compares a solved increment with the result of a case.
fn meets(
    place: &str,
    case: &Value,
    expected: &Value,
    distance: Option<f64>,
    outcome: &StepOutcome,
    fields: &Fields,
) {
    let o = &outcome.observables;
    for (name, count) in [
        ("n_contact", o.contact_elements),
        ("n_stick", o.stick_elements),
        ("n_slip", o.slip_elements),
    ] {
        assert_eq!(Some(count), expected[name].as_u64(), "{place}: {name}");
    }
    let [nx, ny] = fields.shape.map(|n| n as usize);
    let area = fields.element[0] * fields.element[1];
    let (mu, peak) = (number(case, "mu"), number(expected, "max_pressure"));
    let bound = mu * number(expected, "normal_force");
    let reach = 0.5 * nx as f64 * fields.element[0];
    let close = |name: &str, value: f64, unit: f64| {
        let exact = number(expected, name);
        let error = (value - exact).abs() / unit;
        assert!(error <= 1e-8, "{place}: {name} = {value:e}, expected {exact:e}, off by {error:e}");
    };
    let sum = |value: &dyn Fn(usize) -> f64| (0..nx * ny).map(value).sum::<f64>() * area;
    let x = |e: usize| fields.origin[0] + (e % nx) as f64 * fields.element[0];
    let (px, py) = (&fields.traction_x, &fields.traction_y);
    close("normal_force", o.load, bound / mu);
    close("approach", outcome.motion.approach, number(expected, "approach"));
    close("force_x", o.force_x, bound);
    close("force_y", o.force_y, bound);
    close("moment_z", o.moment_z, bound * reach);
    close("max_pressure", o.peak_pressure, peak);
    close("max_traction", o.peak_traction, peak);
    close("sum_x_px", sum(&|e| x(e) * px[e]), bound * reach);
    close("sum_x_py", sum(&|e| x(e) * py[e]), bound * reach);
    close("sum_px2", sum(&|e| px[e] * px[e]), bound * mu * peak);
    close("sum_py2", sum(&|e| py[e] * py[e]), bound * mu * peak);
    // Slips are over the rolled distance.
    let unit = distance.unwrap_or(1.0);
    let slips = |e: usize| [fields.slip_x[e] / unit, fields.slip_y[e] / unit];
    let slipping = |e: usize| fields.state[e] == State::Slip as u8;
    let square = |e: usize| slips(e).iter().map(|s| s * s).sum::<f64>();
    let most = (0..nx * ny).filter(|e| slipping(*e)).map(square).fold(0.0, f64::max).sqrt();
    if most > 0.0 {
        close("dissipation", o.dissipation / unit, bound * most);
        let squares = sum(&|e| if slipping(e) { square(e) } else { 0.0 });
        close("sum_slip2", squares, most * most * reach * reach);
    }
    for sample in expected["samples"].as_array().unwrap() {
        let [i, j] = ["ix", "iy"].map(|key| sample[key].as_u64().unwrap() as usize);
        let e = j * nx + i;
        let got = [fields.pressure[e], px[e], py[e]];
        for (name, value) in ["pn", "px", "py"].into_iter().zip(got) {
            let error = (value - number(sample, name)).abs() / peak;
            assert!(error <= 1e-8, "{place}: {name} of {sample} is {value:e}, off by {error:e}");
        }
        let state = if fields.pressure[e] <= 0.0 {
            "open"
        } else if slipping(e) {
            "slip"
        } else {
            "stick"
        };
        // Where nothing touches the name does not matter.
        if state != "open" {
            assert_eq!(sample["state"], state, "{place}: {sample}");
            for (name, value) in ["sx", "sy"].into_iter().zip(slips(e)) {
                let error = (value - number(sample, name)).abs() / most.max(f64::MIN_POSITIVE);
                assert!(most == 0.0 || error <= 1e-8, "{place}: {name} of {sample}: {value:e}");
            }
        }
    }
}

fn steady(id: &str) {
    let case = case("steady", id);
    let (scene, numerics) = problem(&case, vec![step(&case, &case["step"])]);
    let (outcome, fields) = certified(&scene, &numerics);
    assert_eq!(outcome.route, Route::Newton, "{id}");
    let distance = number(&case["step"], "dq");
    meets(id, &case, &case["result"], Some(distance), &outcome, &fields);
}

macro_rules! steady_cases {
    ($($name:ident: $id:literal),+ $(,)?) => {
        mod steady_cases {
            $(#[test] fn $name() { super::steady($id) })+
        }

        const STEADY: &[&str] = &[$($id),+];
    };
}

steady_cases! {
    long_small: "long_small",
    long_quarter: "long_quarter",
    long_mid: "long_mid",
    long_mid_mesh64: "long_mid_mesh64",
    long_large: "long_large",
    long_saturated: "long_saturated",
    long_reversed: "long_reversed",
    lat_mid: "lat_mid",
    lat_ellipse: "lat_ellipse",
    spin_small: "spin_small",
    spin_large: "spin_large",
    spin_offset: "spin_offset",
    long_lat: "long_lat",
    lat_spin_wide: "lat_spin_wide",
    all_slender: "all_slender",
    all_slender_reversed: "all_slender_reversed",
    approach_circle: "approach_circle",
    approach_ellipse: "approach_ellipse",
    half_step: "half_step",
    double_step: "double_step",
    nu_zero: "nu_zero",
    nu_half: "nu_half",
    unlike_k_zero: "unlike_K_zero",
    rigid_counterbody: "rigid_counterbody",
    rigid_counterbody_free: "rigid_counterbody_free",
    aluminium_steel: "aluminium_steel",
    aluminium_steel_reversed: "aluminium_steel_reversed",
    unlike_approach: "unlike_approach",
    wheel_rail: "wheel_rail",
}

/// Follows the path of a case.
fn transient(id: &str) {
    let case = case("transient", id);
    let steps = case["steps"].as_array().unwrap();
    let (scene, numerics) = problem(&case, steps.iter().map(|s| step(&case, s)).collect());
    let results = case["results"].as_array().unwrap();
    let mut compared = 0;
    let (outcome, _) = solve_watched(
        &scene,
        &numerics,
        &Surfaces::new(),
        &mut Operators::default(),
        &mut |solved| {
            assert!(solved.is_certified, "{id}, increment {}", solved.number);
            let index = solved.number - 1;
            if let Some(expected) = results.iter().find(|result| result["step"] == index) {
                let distance = steps[index as usize]["dq"].as_f64();
                let place = format!("{id}, step {index}");
                meets(&place, &case, expected, distance, solved.outcome, solved.fields);
                compared += 1;
            }
            ControlFlow::Continue(())
        },
    )
    .expect("a scene with a meaning");
    assert_eq!(outcome.status, Status::Certified);
    assert_eq!(compared, results.len(), "{id}");
}

macro_rules! transient_cases {
    ($($name:ident: $id:literal),+ $(,)?) => {
        mod transient_cases {
            $(#[test] fn $name() { super::transient($id) })+
        }

        const TRANSIENT: &[&str] = &[$($id),+];
    };
}

transient_cases! {
    tr_rest_long: "tr_rest_long",
    tr_cattaneo_then_roll: "tr_cattaneo_then_roll",
    tr_lat_spin_ellipse: "tr_lat_spin_ellipse",
    tr_half_step: "tr_half_step",
    tr_reversed: "tr_reversed",
    tr_growing_load: "tr_growing_load",
    tr_unlike: "tr_unlike",
    tr_long_way: "tr_long_way",
}

#[test]
fn every_case_has_its_test() {
    let file: Value = serde_json::from_str(&reference("rolling_cases.json")).unwrap();
    for (list, tested) in [("steady", STEADY), ("transient", TRANSIENT)] {
        let ids: Vec<&str> = file[list]
            .as_array()
            .unwrap()
            .iter()
            .map(|case| case["id"].as_str().unwrap())
            .collect();
        assert_eq!(ids, tested);
    }
}
