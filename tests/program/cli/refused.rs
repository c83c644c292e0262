//! Studies that are refused, which leave nothing behind.

use std::fs;

use crate::place::{Place, SMALL};

/// The name of a case, a text in the small study, and its replacement.
const REFUSED: &[(&str, &str, &str)] = &[
    ("empty file", SMALL, ""),
    ("not TOML", "mesh = 6", "mesh = = 6"),
    ("unclosed text", "\"small\"", "\"small"),
    ("a NUL", "mesh = 6", "mesh = 6 \0"),
    ("key twice", "mesh = 6", "mesh = 6\nmesh = 7"),
    ("name that leaves the directory", "\"small\"", "\"../../small\""),
    ("empty name", "\"small\"", "\"\""),
    ("no name", "name = \"small\"\n", ""),
    ("unknown table", "[numerics]", "[numerik]"),
    ("misspelt key", "radius =", "raduis ="),
    ("wrong unit", "80 GPa", "80 mm"),
    ("unknown unit", "50 mm", "50 furlong"),
    ("unit in the wrong case", "80 GPa", "80 gpa"),
    ("number in quotes", "mu = 0.3", "mu = \"0.3\""),
    ("NaN", "\"50 mm\"", "nan"),
    ("infinity", "\"50 mm\"", "inf"),
    ("overflow", "\"50 mm\"", "\"1e999 mm\""),
    ("negative length", "\"50 mm\"", "\"-50 mm\""),
    ("Poisson above a half", "poisson = [0.0, 0.3]", "poisson = [0.0, 0.6]"),
    ("negative friction", "mu = [0.05, ", "mu = [-0.05, "),
    ("misspelt shape", "\"sphere\"", "\"spere\""),
    ("shape with the wrong keys", "\"sphere\"", "\"cone\""),
    ("missing radius", ", radius = \"50 mm\"", ""),
    ("no step", "[{ approach = \"20 um\" }]", "[]"),
    ("force as approach", "20 um", "20 kN"),
    ("mesh of 0", "mesh = 6", "mesh = 0"),
    ("broken mesh", "mesh = 6", "mesh = 6.5"),
    ("monstrous mesh", "mesh = 6", "mesh = 4000000000"),
    ("mesh beyond every integer", "mesh = 6", "mesh = 99999999999999999999"),
    ("tolerance of 1", "mesh = 6", "mesh = 6\ntolerance = 1"),
    ("unknown method", "mesh = 6", "mesh = 6\nmethod = \"krylov\""),
    ("empty axis", "[0.05, 0.2, 0.6]", "[]"),
    ("axis that repeats itself", "[0.05, 0.2, 0.6]", "[0.05, 0.2, 0.20]"),
    ("axis of words", "[0.05, 0.2, 0.6]", "[\"low\", \"high\"]"),
    ("axis on nothing", "friction.mu = [", "friction.nu = ["),
    ("range without count", "[0.05, 0.2, 0.6]", "{ from = 0.1, to = 0.2 }"),
    (
        "logarithmic range from 0",
        "[0.05, 0.2, 0.6]",
        "{ log = true, from = 0, to = 0.2, count = 3 }",
    ),
    (
        "more points than anybody waits for",
        "[0.05, 0.2, 0.6]",
        "{ from = 0.1, to = 0.2, count = 4000000000 }",
    ),
    (
        "zip of unequal lengths",
        "friction.mu = [0.05, 0.2, 0.6]",
        "[[sweep.zip]]\nfriction.mu = [0.1, 0.2]\nmesh = [6]",
    ),
    ("figure over an unknown column", "stick_fraction", "stick_fracton"),
    (
        "height map without its file",
        "shape = \"sphere\", radius = \"50 mm\"",
        "shape = \"height-map\", file = \"gone.npy\", width_x = 1, width_y = 1",
    ),
];

#[test]
fn refused_studies_say_where_and_leave_nothing() {
    let place = Place::empty();
    let sound = Place::run();
    let before = sound.call("query small --format csv").out;
    let mut said = String::new();
    for (name, old, new) in REFUSED {
        assert!(SMALL.contains(old), "{name}");
        let text = SMALL.replacen(old, new, 1);
        place.write("bad.toml", &text);
        for words in [&["run", "bad.toml"][..], &["plan", "bad.toml"], &["solve", "bad.toml"]] {
            let refused = place.words(words);
            assert_eq!((refused.code, refused.out.as_str()), (1, ""), "{name}: {words:?}");
            let position = refused
                .err
                .split_once("--> bad.toml:")
                .map(|(_, rest)| rest.lines().next().unwrap().split(':'));
            let position: Vec<u32> = position
                .unwrap_or_else(|| panic!("{name}: {}", refused.err))
                .map(|n| n.parse().unwrap())
                .collect();
            assert_eq!(position.len(), 2, "{name}");
            if words[0] == "run" {
                said += &format!("## {name}\n{}\n", refused.err);
            } else if words[0] == "plan" {
                assert!(
                    said.ends_with(&format!("{}\n", refused.err)),
                    "{name}: run and plan disagree"
                );
            }
        }
        assert_eq!(place.files(), [(place.path("bad.toml"), text.as_bytes().to_vec())], "{name}");
        sound.write("bad.toml", &text);
        assert_eq!(sound.call("run bad.toml").code, 1);
    }
    insta::assert_snapshot!(said);
    assert_eq!(sound.call("query small --format csv").out, before);
    assert_eq!(sound.json("store verify --json")["sound"], true);
}

#[test]
fn files_that_are_no_study_at_all() {
    let place = Place::empty();
    place.write("latin1.toml", b"name = \"caf\xe9\"");
    place.write("deep.toml", "a = ".to_owned() + &"[".repeat(100_000));
    place.write("twice.toml", SMALL.replace("mesh = 6", "mesh = [6, 7, 8]"));
    fs::create_dir(place.path("folder.toml")).unwrap();
    let files = place.files();
    let names = ["gone.toml", "folder.toml", "latin1.toml", "deep.toml", "twice.toml"];
    let mut said = String::new();
    for name in names {
        let refused = place.words(&["run", name]);
        assert_eq!(refused.code, 1, "{name}: {}", refused.err);
        let short: String = refused
            .err
            .lines()
            .map(|line| line.chars().take(200).collect::<String>() + "\n")
            .collect();
        said += &format!("## {name}\n{short}\n");
    }
    insta::assert_snapshot!(said);
    assert_eq!(place.files(), files);
}

/// Mistakes that show only when a scene is bound to its grid are refused before anything runs, too.
#[test]
fn scenes_that_fit_no_grid_are_refused_at_their_place() {
    let flat = SMALL.replace(
        "shape = \"sphere\", radius = \"50 mm\"",
        "shape = \"flat-rectangle\", width_x = \"1 mm\", width_y = \"1 mm\"",
    );
    let missed = flat.replace(
        "mu = 0.3",
        "mu = 0.3\ndomain = { width_x = \"1 um\", width_y = \"1 um\", center_x = \"1 m\" }",
    );
    let stiff =
        SMALL.replace("base = {", "layers = [{ shear_modulus = \"1e30 Pa\", poisson = 0.3, thickness = \"1 mm\" }]\nfoundation.base = {");
    for (text, words) in [(&missed, "`domain` cannot be"), (&stiff, "`foundation.base` cannot be")]
    {
        assert_ne!(text, SMALL);
        let place = Place::with("bad.toml", text);
        for command in ["run", "plan"] {
            let refused = place.words(&[command, "bad.toml"]);
            assert_eq!((refused.code, refused.out.as_str()), (1, ""), "{command}: {}", refused.err);
            assert!(
                refused.err.contains(words) && refused.err.contains("--> bad.toml:"),
                "{}",
                refused.err
            );
            assert!(
                refused.err.contains("it is so at mu = 0.05, poisson = 0"),
                "the first point: {}",
                refused.err
            );
        }
        assert_eq!(place.files().len(), 1, "nothing is left");
        // A store that is there does not change either.
        let place = Place::run();
        place.write("bad.toml", text.replace("\"small\"", "\"bad\""));
        assert_eq!(place.call("run bad.toml").code, 1);
        assert_eq!(place.json("status --json").as_array().map(Vec::len), Some(1));
    }
}
