//! Punches from files: heights, and the profiles of a wheel and its rail.

use std::fs;

use serde_json::Value;

use crate::place::{ONE, Place};

/// Returns a matrix of heights as the bytes of an NPY file.
fn npy(rows: usize, columns: usize, heights: &[f64]) -> Vec<u8> {
    let mut header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    header += &" ".repeat(63 - (header.len() + 10) % 64);
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.bytes());
    heights.iter().for_each(|height| bytes.extend(height.to_le_bytes()));
    bytes
}

#[test]
fn height_maps_stand_beside_the_study_and_are_kept() {
    let heights = [0.0, 0.25, 0.5, 0.25, 0.5, 0.75, 0.5, 0.75, 1.0];
    let text: String =
        heights.chunks(3).map(|row| format!("{}, {}, {}\n", row[0], row[1], row[2])).collect();
    let place = Place::empty();
    fs::create_dir(place.path("studies")).unwrap();
    place.write("studies/one.toml", ONE.replace("mesh = 6", "mesh = 6\nmax_iterations = 1"));
    let gone = place.call("run studies/one.toml");
    place.write("studies/rough.csv", "1, 2\n3\n");
    let ragged = place.call("run studies/one.toml");
    assert!(!place.path(".tribosweep").exists());

    place.write("studies/rough.csv", &text);
    assert_eq!(place.call("run studies/one.toml").code, 2, "one iteration is not enough");
    // The same heights under another name and in another format are the same job.
    place.write(
        "studies/other.toml",
        ONE.replace("rough.csv", "rough.npy").replace("\"one\"", "\"other\""),
    );
    place.write("studies/rough.npy", npy(3, 3, &heights));
    place.write("studies/one.toml", ONE);
    assert_eq!(place.call("run studies/other.toml").code, 0);
    assert_eq!(place.json("plan studies/one.toml --json")["to_run"], 0);

    // The study `one` in the store is still that of one iteration; without any file it is computed
    // again from the heights that the store keeps.
    fs::remove_dir_all(place.path("studies")).unwrap();
    let resumed = place.call("resume one --retry-failed --json");
    let summary: Value = serde_json::from_str(resumed.out.lines().last().unwrap()).unwrap();
    assert_eq!((resumed.code, &summary["run"]["computing"]), (2, &1.into()), "{}", resumed.err);
    let kept = place.json("query other --json --select load,status");
    assert_eq!(kept["rows"][0]["status"], "certified");
    assert_eq!(place.call("store compact").code, 0);
    assert_eq!(place.call("resume one --retry-failed").code, 2, "compacting keeps the heights");
    insta::assert_snapshot!(gone.err + "\n" + &ragged.err);
}

/// Two bumps that are far apart are a patch each, and carry the load together.
#[test]
fn separate_patches_are_listed() {
    let place = Place::with("one.toml", ONE);
    place.write(
        "rough.csv",
        "0,0,0,0,0,0\n0,2.9,0,0,0,0\n0,0,0,0,0,0\n0,0,0,0,0,0\n0,0,0,0,4,0\n0,0,0,0,0,0\n",
    );
    assert_eq!(place.call("run one.toml --workers 1").code, 0);
    let key =
        place.call("query one --select key --format csv").out.lines().nth(1).unwrap().to_owned();
    // An approach of 1 µm reaches only the higher bump.
    assert_eq!(place.json(&format!("show {key} --json"))["result"]["patches"], 1);
    assert!(!place.call(&format!("show {key}")).out.contains("\npatches\n"));
    let deeper = ["solve", "one.toml", "--set", "approach=2 um"];
    let said = place.words(&deeper);
    assert!(said.out.contains("\npatches\n"), "{}{}", said.out, said.err);
    let solved: Value =
        serde_json::from_str(&place.words(&[&deeper[..], &["--json"]].concat()).out).unwrap();
    let patches = solved["patches"].as_array().unwrap();
    assert_eq!((patches.len(), &solved["result"]["patches"]), (2, &2.into()));
    let load: f64 = patches.iter().map(|patch| patch["load"].as_f64().unwrap()).sum();
    assert!((load / solved["result"]["load"].as_f64().unwrap() - 1.0).abs() < 1e-12);
    assert!(
        patches[0]["load"].as_f64() > patches[1]["load"].as_f64()
            && patches[0]["x_from"].as_f64() > patches[1]["x_to"].as_f64()
    );
}

/// Profiles go the whole way, from files beside the study through a worker to the store; in the end
/// the files are no longer needed.
#[test]
fn a_wheel_on_a_rail_is_run_and_resumed() {
    let punch = r#"punch = { shape = "wheel-on-rail", wheel = "w.prw", rail = "r.prr", side = "left", rolling_radius = "460 mm" }"#;
    let line = ONE.lines().find(|line| line.starts_with("punch")).unwrap();
    let study = ONE
        .replace(line, punch)
        .replace("approach = \"1 um\"", "normal_force = \"20 kN\"")
        .replace("mesh = 6", "mesh = 16");
    let place = Place::with("one.toml", &study);
    let profiles = concat!(env!("CARGO_MANIFEST_DIR"), "/sweeps/profiles/");
    for (file, from) in [("w.prw", "MBench_S1002_v3.prw"), ("r.prr", "MBench_UIC60_v3.prr")] {
        fs::copy(format!("{profiles}{from}"), place.path(file)).unwrap();
    }
    let said = place.call("run one.toml --workers 1");
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    for file in ["w.prw", "r.prr", "one.toml"] {
        fs::remove_file(place.path(file)).unwrap();
    }
    let row = &place.json(
        "query one --json --select track_y,rail_y,load,hertz_peak_pressure,peak_pressure,status",
    )["rows"][0];
    let number = |name: &str| row[name].as_f64().unwrap();
    assert!(number("track_y") < -0.7 && number("track_y") > -0.8, "{row}");
    assert!((number("load") / 20e3 - 1.0).abs() < 1e-6);
    assert!(
        (0.5..2.0).contains(&(number("peak_pressure") / number("hertz_peak_pressure"))),
        "{row}"
    );
    assert_eq!(place.json("resume one --json")["run"]["cached"], 1);
}
