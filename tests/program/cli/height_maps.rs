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

/// A bump on a grid of 4 × 4, as a list of x, y [mm] and z [µm] and as a matrix [µm].
fn bump() -> [String; 2] {
    let place = |k: usize| -0.375 + 0.25 * k as f64;
    let height = |i: usize, j: usize| -50.0 * (place(i).powi(2) + place(j).powi(2));
    let rows = |line: &dyn Fn(usize, usize) -> String, end: &str| -> String {
        let row = |j: usize| (0..4).map(|i| line(i, j)).collect::<String>() + end;
        (0..4).map(row).collect()
    };
    [
        rows(&|i, j| format!("{} {} {}\n", place(i), place(j), height(i, j)), ""),
        rows(&|i, j| format!("{} ", height(i, j)), "\n"),
    ]
}

#[test]
fn a_list_of_points_is_the_map_of_its_matrix_and_plan_says_what_was_read() {
    let [list, matrix] = bump();
    let place = Place::with("matrix.toml", ONE.replace("rough.csv", "bump.txt"));
    place.write("list.toml", ONE.replace("rough.csv", "bump.xyz"));
    place.write("bump.txt", matrix);
    place.write("bump.xyz", list);
    assert_eq!(place.call("run matrix.toml").code, 0);
    assert_eq!(place.json("plan list.toml --json")["to_run"], 0, "it is the same job");
    let plan = place.call("plan list.toml").out;
    let said = "height map bump.xyz: 4 × 4 pixels, 250 um × 250 um each, heights from -14.06 um to \
                -1.563 um; a list of x, y and z, whose middle at (0 m, 0 m) becomes the origin; \
                heights in um";
    assert!(plan.contains(said), "{plan}");
    let said = "; a matrix of text, its first line at the lowest y; heights in um\n";
    assert!(place.call("plan matrix.toml").out.contains(said));
    let listed = place.call("query one --select key --format csv").out;
    let key = listed.lines().nth(1).unwrap();
    let finer = "are finer than the map: what is between the pixels is interpolated\n";
    for command in
        ["plan list.toml".to_owned(), "solve matrix.toml".to_owned(), format!("show {key}")]
    {
        let out = place.call(&command).out;
        assert!(out.contains("4 × 4 pixels") && out.contains(finer), "{command}: {out}");
    }
    // Without widths those of the list hold; others are refused.
    let bare = ONE.replace("rough.csv\"", "bump.xyz\", lateral_unit = \"mm\"");
    place.write("list.toml", bare.replace(", width_x = \"1 mm\", width_y = \"1 mm\"", ""));
    assert_eq!(place.json("plan list.toml --json")["to_run"], 0);
    place.write("list.toml", bare.replace("width_x = \"1 mm\"", "width_x = \"2 mm\""));
    let refused = place.call("plan list.toml");
    assert!(refused.err.contains("half a step on either side, 0.001 m"), "{}", refused.err);
}

/// A study from a stranger shows nothing of files that lie elsewhere, and waits for none.
#[test]
fn files_outside_of_the_study_are_not_quoted_and_special_ones_are_refused() {
    let place = Place::empty();
    fs::create_dir(place.path("studies")).unwrap();
    place.write("secret", "root:secret word\n");
    std::os::unix::fs::symlink(place.path("secret"), place.path("studies/link")).unwrap();
    place.write("studies/near", "root:secret word\n");
    let absolute = place.path("secret").display().to_string();
    for (file, is_quoted) in
        [("../secret", false), ("link", false), (&*absolute, false), ("near", true)]
    {
        for text in [
            ONE.replace("rough.csv", file),
            ONE.replace("{ shape = \"height-map\", file = \"rough.csv\", unit = \"um\", width_x = \"1 mm\", width_y = \"1 mm\" }",
                &format!("{{ shape = \"wheel-on-rail\", wheel = \"{file}\", rail = \"{file}\", side = \"left\", rolling_radius = 0.46 }}")),
        ] {
            place.write("studies/one.toml", text);
            let said = place.call("plan studies/one.toml");
            assert_eq!(said.code, 1);
            assert_eq!(said.err.contains("secret word"), is_quoted, "{file}: {}", said.err);
            assert!(said.err.contains("line 1"), "{}", said.err);
        }
    }
    for (file, says) in [
        ("/dev/zero", "it is a device, not a regular file"),
        ("/", "it is a directory, not a regular file"),
        ("large", "it may have at most 256.00 MiB"),
    ] {
        fs::File::create(place.path("studies/large")).unwrap().set_len(1 << 36).unwrap();
        place.write("studies/one.toml", ONE.replace("rough.csv", file));
        let said = place.call("plan studies/one.toml");
        assert!(said.code == 1 && said.err.contains(says), "{file}: {}", said.err);
    }
    let said = place.call("plan /dev/zero");
    assert!(said.err.contains("it is a device, not a regular file"), "{}", said.err);
}

/// Wheels in circulation say where their flanges are measured.
#[test]
fn headers_of_profiles_may_speak_of_measuring() {
    let profiles = concat!(env!("CARGO_MANIFEST_DIR"), "/sweeps/profiles/");
    let wheel = fs::read_to_string(format!("{profiles}MBench_S1002_v3.prw")).unwrap();
    let place = Place::empty();
    place.write("w.prw", wheel.replace("  header.end", "    meas.pos.e = +1.0e-02\n  HEADER.end"));
    place.write("plain.prw", wheel);
    fs::copy(format!("{profiles}MBench_UIC60_v3.prr"), place.path("r.prr")).unwrap();
    let line = ONE.lines().find(|line| line.starts_with("punch")).unwrap();
    let punch = r#"punch = { shape = "wheel-on-rail", wheel = "w.prw", rail = "r.prr", side = "left", rolling_radius = "460 mm" }"#;
    let study = ONE.replace(line, punch).replace("approach = \"1 um\"", "normal_force = \"20 kN\"");
    place.write("one.toml", &study);
    place.write("plain.toml", study.replace("w.prw", "plain.prw"));
    assert_eq!(place.call("run plain.toml").code, 0);
    assert_eq!(place.json("plan one.toml --json")["to_run"], 0);
    let plan = place.call("plan one.toml").out;
    let said = "profile w.prw: a wheel, 399 points, y from -69.61 mm to 60 mm, z from -2.636 mm to 28 \
                mm; in SIMPACK's format, mirrored in y; read past meas.pos.e\n";
    assert!(plan.contains(said), "{plan}");
}

/// Two bumps that are far apart are a patch each, and carry the load together.
#[test]
fn separate_patches_are_listed() {
    let place = Place::with("one.toml", ONE.replace("1 um", "1.5 um"));
    place.write(
        "rough.csv",
        "0,0,0,0,0,0\n0,2.9,0,0,0,0\n0,0,0,0,0,0\n0,0,0,0,0,0\n0,0,0,0,4,0\n0,0,0,0,0,0\n",
    );
    assert_eq!(place.call("run one.toml --workers 1").code, 0);
    let key =
        place.call("query one --select key --format csv").out.lines().nth(1).unwrap().to_owned();
    // An approach of 1.5 µm reaches only the higher bump: over an element, its mean height is two
    // thirds of that at its centre.
    assert_eq!(place.json(&format!("show {key} --json"))["result"]["patches"], 1);
    assert!(!place.call(&format!("show {key}")).out.contains("\npatches\n"));
    let deeper = ["solve", "one.toml", "--set", "approach=2.6 um"];
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
    place.add_profiles();
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
