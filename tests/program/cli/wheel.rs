//! A wheel that stands on two patches of its rail.

use crate::place::{ONE, Place};

/// The right wheel of the Manchester benchmark, 5 mm aside, stands on its tread and on the root of
/// its flange. What is shown of the two depends on their plane of contact, so it is said.
#[test]
fn patches_of_a_wheel_are_shown_with_their_angles() {
    let punch = r#"punch = { shape = "wheel-on-rail", wheel = "w.prw", rail = "r.prr", side = "right", rolling_radius = "460 mm", lateral = "5 mm", yaw = 0.012, roll = -3.554e-4, material = { shear_modulus = "82 GPa", poisson = 0.28 } }"#;
    let line = ONE.lines().find(|line| line.starts_with("punch")).unwrap();
    let base = ONE.lines().find(|line| line.starts_with("foundation")).unwrap();
    let study = ONE
        .replace(line, punch)
        .replace(base, "foundation.base = { shear_modulus = \"82 GPa\", poisson = 0.28 }")
        .replace("approach = \"1 um\"", "normal_force = \"9619 N\"")
        .replace("mesh = 6", "mesh = 32");
    let place = Place::with("one.toml", &study);
    place.add_profiles();
    let said = place.call("run one.toml --workers 1");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let key = place.json("query one --json --select key")["rows"][0]["key"].clone();
    let key = key.as_str().unwrap();
    let words = place.call(&format!("show {key}"));
    assert!(
        words.out.contains("under the patches; they share one plane of contact")
            && words.out.contains("a patch is inclined to its plane by up to 0.1"),
        "{}{}",
        words.out,
        words.err
    );
    for said in [place.json(&format!("show {key} --json")), place.json("solve one.toml --json")] {
        let patches = said["patches"].as_array().unwrap();
        let of = |patch: usize, name: &str| patches[patch][name].as_f64().unwrap();
        assert_eq!(patches.len(), 2, "{said}");
        // The flange carries more than the tread.
        assert!(of(0, "track_y") < 0.73 && of(1, "track_y") > 0.73, "{said}");
        assert!((of(0, "angle") + 0.3).abs() < 0.03 && (of(1, "angle") + 0.13).abs() < 0.03);
        assert!((of(0, "plane_angle") + 0.29).abs() < 0.02, "{said}");
        assert_eq!(of(0, "plane_angle"), of(1, "plane_angle"));
    }
}
