//! Stresses below the surface: columns, plans, planes and sections of a stored result.

use crate::place::Place;

/// A sphere with a contact radius of some 10 µm.
const SPHERE: &str = r#"name = "one"

[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "1 mm" }
loading.steps = [{ approach = "0.1 um" }]

[numerics]
mesh = 16
"#;

fn below() -> Place {
    let asked =
        "[interior]\nmaximum = true\ndepth = \"5 um\"\npoints = [[0, 0, \"5 um\"], [0, 0, 0]]\n";
    Place::with("one.toml", SPHERE.to_owned() + asked)
}

#[test]
fn a_study_that_asks_has_columns_a_reason_and_a_residual() {
    let place = below();
    let plan = place.succeed("plan one.toml");
    assert!(plan.contains("`[interior]` asks for the largest stresses and one plane"), "{plan}");
    place.write("silent.toml", SPHERE);
    let silent = place.succeed("plan silent.toml");
    assert!(silent.contains("no stress below the surface is computed"), "{silent}");
    place.succeed("run one.toml --workers 1");
    let columns = "von_mises_max,von_mises_z,von_mises_below_over_pressure,plane_von_mises,\
                   stress_zz,interior_residual";
    let said = place.json(&format!("query one --json --select {columns}"));
    let row = &said["rows"][0];
    let number = |name: &str| row[name].as_f64().unwrap_or_else(|| panic!("{name} in {row}"));
    assert!(number("von_mises_max") >= number("plane_von_mises"), "{row}");
    assert!((number("von_mises_below_over_pressure") - 0.62).abs() < 0.06, "{row}");
    assert!(number("stress_zz") < 0.0 && number("interior_residual") < 1e-7, "{row}");
}

#[test]
fn planes_and_sections_are_computed_from_what_is_stored() {
    let place = below();
    place.succeed("run one.toml --workers 1");
    let key = place.json("query one --json --select key")["rows"][0]["key"].clone();
    let key = key.as_str().unwrap();
    // All planes and points are listed, to be read and as JSON.
    let said = place.json(&format!("show {key} --json"));
    let rows = |table: &str| said[table]["rows"].as_array().unwrap().clone();
    let depths: Vec<_> = rows("planes").iter().map(|plane| plane["depth"].as_f64()).collect();
    assert_eq!(depths, [Some(5e-6)]);
    assert_eq!(rows("points").len(), 2, "{said}");
    let on_surface = rows("points")[1]["zz"].as_f64().unwrap();
    let peak = said["result"]["peak_pressure"].as_f64().unwrap();
    assert!((on_surface / peak + 1.0).abs() < 0.05, "{said}");
    let text = place.succeed(&format!("show {key}"));
    assert!(text.contains("planes\n") && text.contains("points\n"), "{text}");
    let show = |plane: &str, more: &[&str]| {
        place.words(&[&["show", key, "--plane", plane], more].concat())
    };
    let plane = show("z=5 um", &["--field", "von_mises"]);
    assert!(plane.code == 0 && plane.out.starts_with("von mises"), "{}{}", plane.out, plane.err);
    let section = ["--down-to", "30 um", "--field", "von_mises", "--output", "s.svg"];
    assert_eq!(show("y=0 mm", &section).code, 0);
    let svg = std::fs::read_to_string(place.path("s.svg")).unwrap();
    assert!(svg.contains("−z") && svg.contains("von mises"), "{svg}");
    assert_eq!(show("x=0", &["--output", "s.vti"]).code, 0);
    let vti = std::fs::read_to_string(place.path("s.vti")).unwrap();
    assert!(vti.contains("WholeExtent=\"0 0 0 16 0 "), "{}", &vti[..400]);
    assert!(vti.contains("Name=\"tresca\"") && vti.contains("Name=\"stress_third\""));
    assert_eq!(show("z=5e-6", &["--field", "stress_xx", "--output", "p.npy"]).code, 0);
    assert_eq!(show("z=5e-6", &["--output", "p.csv"]).code, 0);
    for (plane, more, words) in [
        ("5 um", &[][..], "a section \"x=0 mm\" or \"y=0 mm\""),
        ("w=5 um", &[], "a section \"x=0 mm\" or \"y=0 mm\""),
        ("z=five", &[], "does not begin with a number"),
        ("z=-5 um", &[], "a depth must be 0 or above"),
        ("z=5 N", &[], "is a force, not a length"),
        ("z=5 um", &["--down-to", "1 um"], "only a section goes down"),
        ("x=0", &["--down-to=-1 um"], "must be above 0"),
        ("x=1 m", &[], "must be in Ω, from -"),
        ("y=-1 m", &[], "a section goes through its elements"),
        ("x=0", &["--field", "pressure"], "there are von_mises, tresca"),
        ("x=0", &["--output", "s.png"], "name it by --field (von_mises"),
        ("x=0", &["--output", "s.pvd"], "holds the fields of all increments"),
    ] {
        let answer = show(plane, more);
        assert_eq!(answer.code, 1, "{plane} {more:?}: {}", answer.out);
        assert!(answer.err.contains(words), "{plane} {more:?}: {}", answer.err);
    }
}
