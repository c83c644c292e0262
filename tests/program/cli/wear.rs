//! Wear as a user meets it: its reason in a plan, its columns, its field, and a scene without it.

use std::fs;

use serde_json::Value;

use crate::place::Place;

/// A ball that frets in gross sliding, on the shape as it is and on the one that is left.
const FRETTING: &str = r#"
name = "fretting"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
friction.mu = 0.6
wear = { coefficient = "2e-7 1/MPa", repeat = 100 }
domain = { width_x = "0.5 mm", width_y = "0.5 mm" }
[scene.loading]
cycle_from = 2
cycles = 2
steps = [
    { normal_force = "50 N" },
    { shift_x = "4 um", increments = 2 },
    { shift_x = "-4 um", increments = 4 },
    { shift_x = "4 um", increments = 4 },
]
[numerics]
mesh = 12
[sweep]
"wear.update" = [false, true]
"#;

fn rows(place: &Place, line: &str) -> Vec<Value> {
    place.json(line)["rows"].as_array().unwrap_or_else(|| panic!("{line}")).clone()
}

fn number(row: &Value, column: &str) -> f64 {
    row[column].as_f64().unwrap_or_else(|| panic!("{column} in {row}"))
}

#[test]
fn wear_is_planned_computed_asked_for_and_drawn() {
    let place = Place::with("fretting.toml", FRETTING);
    let plan = place.call("plan fretting.toml");
    let reason = "wear.coefficient = 2e-13 1/Pa, 100 cycles in each, on the undeformed shape";
    assert!(plan.out.contains(reason), "{}", plan.out);
    let said = place.call("run fretting.toml --workers 2");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let columns = "key,wear_update,wear_depth,wear_volume,cycle_wear_depth,cycle_wear_volume,\
                   wear_per_length,cycle_dissipation,contact_area,hertz_a,status";
    let ends = rows(&place, &format!("query fretting --select {columns} --json"));
    assert_eq!(ends.len(), 2);
    for end in &ends {
        assert_eq!(end["status"], "certified");
        let volume = 100.0 * 2e-13 / 0.6 * number(end, "cycle_dissipation");
        assert!((number(end, "cycle_wear_volume") / volume - 1.0).abs() < 1e-6, "{end}");
        assert!(number(end, "cycle_wear_depth") < number(end, "wear_depth"), "{end}");
        assert!(end["wear_per_length"].is_null(), "nothing rolls");
        assert_eq!(end["hertz_a"].is_null(), end["wear_update"] == true, "{end}");
    }
    let [fixed, worn] = [&ends[0], &ends[1]];
    let shown = place.call(&format!("show {}", worn["key"].as_str().unwrap()));
    let reason = "100 cycles in each; the shape is updated after each increment";
    assert!(shown.out.contains(reason), "{}", shown.out);
    assert!(number(worn, "contact_area") > number(fixed, "contact_area"));
    assert!(number(worn, "wear_depth") < number(fixed, "wear_depth"));
    // Along the path the wear is that of the increments so far.
    let columns = "wear_update,increment,wear_depth,wear_volume";
    let along = rows(&place, &format!("query fretting --steps --select {columns} --json"));
    assert_eq!(along.len(), 2 * 19);
    let of_fixed: Vec<&Value> = along.iter().filter(|row| row["wear_update"] == false).collect();
    let volumes: Vec<f64> = of_fixed.iter().map(|row| number(row, "wear_volume")).collect();
    assert!(volumes.is_sorted() && volumes[0] < 0.1 * volumes[18], "{volumes:?}");
    assert_eq!(volumes[18], number(fixed, "wear_volume"));
    // The field has the same depth and, on the undeformed shape, the same volume.
    let key = fixed["key"].as_str().unwrap();
    for file in ["depth.npy", "depth.png", "all.vti", "all.csv"] {
        let field = if file.starts_with("depth") { "--field wear_depth " } else { "" };
        let said = place.call(&format!("show {key} {field}--output {file}"));
        assert_eq!(said.code, 0, "{}", said.err);
    }
    let npy = fs::read(place.path("depth.npy")).unwrap();
    let depth: Vec<f64> = npy[npy.len() - 144 * 8..]
        .chunks_exact(8)
        .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap()))
        .collect();
    assert_eq!(depth.iter().copied().fold(0.0, f64::max), number(fixed, "wear_depth"));
    let volume = depth.iter().sum::<f64>() * (5e-4_f64 / 12.0).powi(2);
    assert!((volume / number(fixed, "wear_volume") - 1.0).abs() < 1e-12, "{volume}");
    let text = |file: &str| fs::read_to_string(place.path(file)).unwrap();
    assert!(text("all.vti").contains("wear_depth") && text("all.csv").contains("wear_depth"));
    let said = place.call("store verify");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
}

#[test]
fn a_scene_without_wear_has_no_field_of_it() {
    let place = Place::run();
    let key = &place.keys()[0];
    let said = place.words(&["show", key, "--field", "wear_depth"]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("this scene has no field `wear_depth`"), "{}", said.err);
    let said = place.words(&["show", key, "--output", "all.csv"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(!fs::read_to_string(place.path("all.csv")).unwrap().contains("wear_depth"));
}
