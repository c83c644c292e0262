//! Punches from files of heights.

use std::fs;

use serde_json::Value;

use crate::place::{ONE, Place};

/// A matrix of heights as an NPY file.
fn npy(rows: usize, columns: usize, heights: &[f64]) -> Vec<u8> {
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
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
    let text: String = heights.chunks(3).map(|row| format!("{}, {}, {}\n", row[0], row[1], row[2])).collect();
    let place = Place::empty();
    fs::create_dir(place.path("studies")).unwrap();
    place.write("studies/one.toml", ONE.replace("mesh = 6", "mesh = 6\nmax_iterations = 1"));
    let gone = place.call("run studies/one.toml");
    place.write("studies/rough.csv", "1, 2\n3\n");
    let ragged = place.call("run studies/one.toml");
    assert!(!place.path(".tribosweep").exists());

    place.write("studies/rough.csv", &text);
    assert_eq!(place.call("run studies/one.toml").code, 2, "one iteration is not enough");
    // the same heights under another name and in another format are the same job
    place.write("studies/other.toml", ONE.replace("rough.csv", "rough.npy").replace("\"one\"", "\"other\""));
    place.write("studies/rough.npy", npy(3, 3, &heights));
    place.write("studies/one.toml", ONE);
    assert_eq!(place.call("run studies/other.toml").code, 0);
    assert_eq!(place.json("plan studies/one.toml --json")["to_run"], 0);

    // `one` in the store is still the study of one iteration; without any file it is computed again from its kept heights
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
