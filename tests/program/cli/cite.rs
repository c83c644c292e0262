//! `cite`: the references of a study, from the store and from its file.

use crate::place::{Place, SMALL};

/// Returns a list of references without the program, whose commit differs from build to build.
fn without_program(text: &str) -> &str {
    let (program, rest) = text.split_once("\nequation").unwrap();
    assert!(program.starts_with("program\n  tribosweep "), "{program}");
    rest
}

#[test]
fn references_are_those_of_what_the_jobs_use() {
    let place = Place::run();
    let said = place.call("cite small");
    assert_eq!((said.code, said.err.as_str()), (0, ""));
    insta::assert_snapshot!(without_program(&said.out));
    let from_file = place.call("cite small.toml --store nowhere");
    assert_eq!((from_file.code, &from_file.out), (0, &said.out), "{}", from_file.err);
    let json = place.json("cite small --json");
    assert_eq!((&json["study"], &json["jobs"]), (&"small".into(), &6.into()));
    assert_eq!(json["program"]["build"]["version"], env!("CARGO_PKG_VERSION"));
    let subjects = json["subjects"].as_array().unwrap();
    for subject in subjects {
        let is_cited = !subject["works"].as_array().unwrap().is_empty();
        assert!(is_cited || subject["derived_here"].is_string(), "{subject}");
    }
    // No layer is in this study, and an effect more brings its source.
    assert!(!said.out.contains("layers"));
    let layer = "foundation.layers = [{ shear_modulus = \"8 GPa\", poisson = 0.3, thickness = \"0.1 mm\" \
                 }]\n";
    let [base, numerics] = ["foundation.base = ", "mesh = 6"];
    let layered = SMALL
        .replace(base, &format!("{layer}{base}"))
        .replace(numerics, &format!("{numerics}\nmethod = \"newton\""));
    place.write("layered.toml", layered);
    let layered = place.call("cite layered.toml").out;
    assert!(layered.contains("layers (all 6 jobs)\n  Talman"), "{layered}");
    let bibtex = place.call("cite layered.toml --format bibtex").out;
    assert!(bibtex.contains("doi = {10.1137/0907058}"), "{bibtex}");
}

#[test]
fn bibtex_has_each_work_once() {
    let place = Place::run();
    let said = place.call("cite small --format bibtex");
    assert_eq!(said.code, 0);
    let entries: Vec<&str> = said.out.lines().filter(|line| line.starts_with('@')).collect();
    insta::assert_snapshot!(entries.join("\n"));
}

#[test]
fn what_cannot_be_cited_is_refused_in_words() {
    let place = Place::run();
    place.write("broken.toml", "name = 3");
    insta::assert_snapshot!(place.transcript(&[
        &["cite", "large"],
        &["cite", "broken.toml"],
        &["cite", "small", "--store", "nowhere"],
        &["cite", "small", "--json", "--format", "bibtex"],
    ]));
}
