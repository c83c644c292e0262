//! Studies that are too large, or that somebody wrote to do harm: each is refused in words, quickly.

use study::{Study, StudyError};

use crate::sphere::{SPHERE, sphere};

/// The size of a large file, in bytes.
const LARGE: usize = 1 << 18;

fn parse(text: &str) -> Result<Study, StudyError> {
    Study::parse(text, "study.toml", &mut |name| Err(format!("no file {name}")))
}

/// Returns what is said of a study that must be refused, with its size bounded as well.
fn refused(text: &str) -> String {
    let error = match parse(text) {
        Ok(_) => panic!("was not refused: {}…", &text[..200.min(text.len())]),
        Err(error) => error,
    };
    let said = error.to_string();
    assert!(error.mistakes().len() < 2000, "{} mistakes", error.mistakes().len());
    assert!(said.len() < 100_000, "{} bytes are said", said.len());
    said
}

/// Repeats what a function writes until the text is large.
fn large(mut write: impl FnMut(usize) -> String) -> String {
    let mut text = String::with_capacity(LARGE + 1000);
    let mut count = 0;
    while text.len() < LARGE {
        text += &write(count);
        count += 1;
    }
    text
}

#[test]
fn lists_that_are_too_long_are_counted_first() {
    let layer = "{ shear_modulus = 1, poisson = 0.3, thickness = 1 }, ";
    let layers = SPHERE.replacen(
        "foundation.base",
        &format!("foundation.layers = [{}]\nfoundation.base", large(|_| layer.to_owned())),
        1,
    );
    let said = refused(&layers);
    assert!(said.contains("layers` has") && said.contains("at most 64 layers"), "{said}");
    let steps = large(|_| "{ approach = 1 }, ".to_owned());
    let said = refused(&SPHERE.replacen("{ approach = \"1 um\" }", &steps, 1));
    assert!(said.contains("steps` has") && said.contains("at most 1000 steps"), "{said}");
}

#[test]
fn as_many_steps_as_are_allowed_are_read() {
    let steps: String = (0..1000).map(|i| format!("{{ approach = {}e-9, shift_x = {i}e-9, shift_y = 0, tilt_x = 0, tilt_y = 0, twist = 0 }}, ", i + 1)).collect();
    let study = parse(&SPHERE.replacen("{ approach = \"1 um\" }", &steps, 1)).unwrap();
    assert_eq!(
        study.columns().iter().filter(|column| column.name.ends_with("shift_x")).count(),
        1001
    );
}

#[test]
fn a_sweep_of_too_much_is_refused_before_it_is_read() {
    for (sweep, words) in [
        ("friction.mu = { from = 0, to = 1, count = 4000000000 }", "a range of 4000000000"),
        ("friction.mu = { from = 0, to = 1, count = 999999999999999999999 }", "cannot count"),
        (
            "friction.mu = { from = 0, to = 1, count = 200000 }\npunch.radius = { from = 1, to = 2, count = 200000 }",
            "values in all",
        ),
        (
            "friction.mu = { from = 0, to = 1, count = 10000 }\npunch.radius = { from = 1, to = 2, count = 10000 }\nfoundation.base.poisson = { from = 0, to = 0.5, count = 10000 }",
            "10000 × 10000 × 10000 points",
        ),
    ] {
        let said = refused(&sphere("", &format!("[sweep]\n{sweep}\n")));
        assert!(said.contains(words), "{said}");
    }
    let steps = "{ approach = 1 }, ".repeat(1000);
    let long = SPHERE.replacen("{ approach = \"1 um\" }", &steps, 1);
    let said =
        refused(&format!("{long}[sweep]\nfriction.mu = {{ from = 0, to = 1, count = 2001 }}\n"));
    assert!(said.contains("2001 points with up to 1000 load steps"), "{said}");
    let axes = large(|i| format!("\"loading.steps[{i}].shift_x\" = [0]\n"));
    let said = refused(&sphere("", &format!("[sweep]\n{axes}")));
    assert!(said.contains("axes") && said.contains("at most 1000"), "{said}");
    let zips = large(|i| format!("[[sweep.zip]]\n\"loading.steps[{i}].shift_x\" = [0]\n"));
    assert!(refused(&sphere("", &zips)).contains("at most 1000"));
}

#[test]
fn many_mistakes_are_counted_only_up_to_a_number() {
    for text in [
        large(|i| format!("a{i} = 1\n")),
        sphere("", &large(|i| format!("a{i} = 1\n"))),
        sphere("", &format!("[scene.domain]\n{}", large(|i| format!("a{i} = 1\n")))),
        sphere("", &format!("[figure]\n{}", large(|i| format!("a{i} = 1\n")))),
        sphere("", &format!("[sweep]\nfriction.mu = [{}]\n", large(|_| "true, ".to_owned()))),
        sphere("", &format!("[sweep]\npunch = [{}]\n", large(|_| "{ a = 1 }, ".to_owned()))),
        sphere(
            "",
            &format!("[sweep]\n\"foundation.layers\" = [{}]\n", large(|_| "[3], ".to_owned())),
        ),
        sphere("", &large(|_| "[[figure]]\na = 1\n".to_owned())),
        sphere(
            "",
            &format!("[figure]\nx = \"mu\"\ny = [{}]\n", large(|_| "\"load\", ".to_owned())),
        ),
        sphere(
            "",
            &format!(
                "[figure]\nx = \"mu\"\ny = \"load\"\nseries = [{}]\n",
                large(|_| "\"laod\", ".to_owned())
            ),
        ),
        sphere("", &format!("simulate = [{}]\n", large(|_| "\"weather\", ".to_owned()))),
    ] {
        refused(&text);
    }
}

#[test]
fn long_names_and_texts_are_cut_in_what_is_said() {
    let long = "ä".repeat(LARGE / 2);
    for text in [
        format!("name = \"{long}\"\n"),
        format!("kind = \"{long}\"\n{SPHERE}"),
        format!("\"{long}\" = 1\n{SPHERE}"),
        sphere("", &format!("\"{long}\" = 1\n")),
        SPHERE.replacen("10 mm", &long, 1),
        SPHERE.replacen("10 mm", &format!("10 {long}"), 1),
        SPHERE.replacen("10 mm", &"1".repeat(LARGE), 1),
        SPHERE.replacen("\"sphere\"", &format!("\"{long}\""), 1),
        sphere("", &format!("[sweep]\n\"{long}\" = [1]\n")),
        sphere("", &format!("[sweep]\npunch = [{{ label = \"{long}\" }}]\n")),
        sphere("", &format!("[figure]\nx = \"{long}\"\ny = \"load\"\n")),
        sphere("", &format!("[bisect]\naxis = \"{long}\"\non = \"load > 0\"\nto = 0.1\n")),
        sphere(&format!("question = \"{long}\"\n"), ""),
        sphere("", &format!("[figure]\nx = \"mu\"\ny = \"load\"\ntitle = \"{long}\"\n")),
    ] {
        refused(&text);
    }
}

#[test]
fn deep_nesting_and_broken_files_are_refused() {
    for text in [
        format!("a = {}", "[".repeat(LARGE)),
        format!("a = {}", "{ a = ".repeat(LARGE / 6)),
        format!("{} = 1", "a.".repeat(LARGE / 2)),
        format!("[{}]", "a.".repeat(LARGE / 2)),
        large(|i| format!("[a{i}]\n")),
        large(|_| "a = 1\n".to_owned()),
        large(|_| "= \u{1} ] \" \n".to_owned()),
        "\"".repeat(LARGE),
        "\u{feff}".repeat(LARGE / 3),
        "a\n".repeat(LARGE / 2),
    ] {
        refused(&text);
    }
}

#[test]
fn what_a_terminal_would_obey_is_escaped_in_what_is_said() {
    let escapes = r"\u001b]0;x\u0007\u202e\u009b2J\n\r";
    for text in [
        format!("name = \"{escapes}\"\n"),
        format!("kind = \"{escapes}\"\n{SPHERE}"),
        format!("\"{escapes}\" = 1\n{SPHERE}"),
        SPHERE.replacen("10 mm", escapes, 1),
        sphere("", &format!("[sweep]\n\"{escapes}\" = [1]\n")),
        sphere("", &format!("[figure]\nx = \"{escapes}\"\ny = \"load\"\n")),
        "name = \"\u{202e}\u{9b}2J\u{2066}\" # \u{1b}]0;x\u{7}".to_owned(),
        "name = \u{1b}]0;x\u{7}".to_owned(),
    ] {
        let said = refused(&text);
        let hidden =
            |c: char| c != '\n' && c.is_control() || ('\u{202a}'..='\u{202e}').contains(&c);
        assert!(!said.contains(hidden), "{said:?}");
    }
    let said = refused("name = \"a\u{202e}b\"\nquestion = 3");
    assert!(said.contains("a\\u{202e}b"), "{said}");
}
