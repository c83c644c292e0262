//! Materials that are given by Young's modulus, and scenes without friction.

use proptest::prelude::*;

use contact::model::{Base, Material};
use study::edit::with_settings;
use study::{Study, StudyError, Value, columns};

use crate::sphere::SPHERE;

fn parse(text: &str) -> Result<Study, StudyError> {
    Study::parse(text, "study.toml", &mut |name| Err(format!("no file {name}")))
}

fn read(text: &str) -> Study {
    parse(text).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the study with another base and lines after its tables.
fn with_base(base: &str, after: &str) -> String {
    let old = "{ shear_modulus = \"80 GPa\", poisson = 0.3 }";
    assert!(SPHERE.contains(old));
    format!("{}{after}", SPHERE.replacen(old, base, 1))
}

fn values(study: &Study, name: &str) -> Vec<Value> {
    let columns = study.columns();
    let column = columns::find(&columns, name).unwrap_or_else(|| panic!("no column {name}"));
    study.points().iter().map(|point| column.value(point, None)).collect()
}

fn numbers(values: &[f64]) -> Vec<Value> {
    values.iter().copied().map(Value::Number).collect()
}

#[test]
fn youngs_modulus_is_the_same_material_as_its_shear_modulus() {
    let young = read(&with_base("{ youngs_modulus = \"210 GPa\", poisson = 0.3 }", ""));
    let shear = format!("{{ shear_modulus = {:e}, poisson = 0.3 }}", 210e9 / 2.6);
    let shear = read(&with_base(&shear, ""));
    assert_eq!(young.points()[0].job.canonical(), shear.points()[0].job.canonical());
    assert_eq!(young.points()[0].key, shear.points()[0].key);
    assert!(!young.points()[0].job.to_toml().contains("youngs"));
    // The columns show what was given, to the last digit, and what the job has.
    assert_eq!(values(&young, "youngs_modulus"), numbers(&[210e9]));
    assert_eq!(values(&young, "shear_modulus"), numbers(&[210e9 / 2.6]));
    assert!(columns::find(&shear.columns(), "youngs_modulus").is_none());
}

#[test]
fn youngs_modulus_stands_wherever_a_material_does() {
    let scene = with_base(
        "\"rigid\"\nfoundation.layers = [{ youngs_modulus = \"70 GPa\", poisson = 0.25, thickness = \"1 mm\" }]",
        "",
    );
    let scene = scene.replacen(
        "radius = \"10 mm\" }",
        "radius = \"10 mm\", material = { youngs_modulus = \"600 kN/mm2\", poisson = 0.2 } }",
        1,
    );
    let study = read(&scene);
    let scene = &study.points()[0].job.case().unwrap().scene.clone();
    assert_eq!(
        scene.foundation.layers[0].material(),
        Material { shear_modulus: 28e9, poisson: 0.25 }
    );
    assert_eq!(scene.punch.material, Some(Material { shear_modulus: 250e9, poisson: 0.2 }));
    assert_eq!(values(&study, "layer0_youngs_modulus"), numbers(&[70e9]));
    assert_eq!(values(&study, "punch_youngs_modulus"), numbers(&[600e9]));
}

#[test]
fn youngs_modulus_is_an_axis_and_stays_where_it_is_along_another() {
    let base = "{ youngs_modulus = 200e9, poisson = 0.25 }";
    let along_poisson =
        read(&with_base(base, "[sweep]\nfoundation.base.poisson = [0, 0.25, 0.5]\n"));
    assert_eq!(values(&along_poisson, "shear_modulus"), numbers(&[100e9, 80e9, 200e9 / 3.0]));
    assert_eq!(values(&along_poisson, "youngs_modulus"), numbers(&[200e9; 3]));
    let along_young = read(&with_base(
        "{ poisson = 0.25 }",
        "[sweep]\nfoundation.base.youngs_modulus = { from = \"100 GPa\", to = \"200 GPa\", count = 3 }\n",
    ));
    assert_eq!(values(&along_young, "shear_modulus"), numbers(&[40e9, 60e9, 80e9]));
    assert_eq!(along_young.figures()[0].x, "youngs_modulus");
    let zipped = read(&with_base(
        "{ poisson = 0.25 }",
        "[[sweep.zip]]\nfoundation.base.youngs_modulus = [1, 1, 2]\nfoundation.base.poisson = [0, 0.5, 0.5]\n",
    ));
    assert_eq!(values(&zipped, "shear_modulus"), numbers(&[0.5, 1.0 / 3.0, 2.0 / 3.0]));
    let tables = read(&with_base(
        base,
        "[sweep]\n\"foundation.base\" = [{ label = \"a\", youngs_modulus = 3, poisson = 0.5 }, { label = \"b\", shear_modulus = 2, poisson = 0.5 }]\n",
    ));
    assert_eq!(values(&tables, "shear_modulus"), numbers(&[1.0, 2.0]));
    assert_eq!(values(&tables, "youngs_modulus"), numbers(&[3.0, 6.0]));
}

#[test]
fn one_of_the_two_moduli_is_given() {
    let twice = [
        with_base(
            "{ shear_modulus = \"80 GPa\", youngs_modulus = \"208 GPa\", poisson = 0.3 }",
            "",
        ),
        with_base(
            "{ shear_modulus = \"80 GPa\", poisson = 0.3 }",
            "[sweep]\nfoundation.base.youngs_modulus = [1, 2]\n",
        ),
        SPHERE.replacen(
            "radius = \"10 mm\" }",
            "radius = 1, material = { youngs_modulus = 1, shear_modulus = 1, poisson = 0 } }",
            1,
        ),
        with_base(
            "{ poisson = 0.3 }",
            "[sweep]\nfoundation.base.youngs_modulus = [1, 2]\nfoundation.base.shear_modulus = [1, 2]\n",
        ),
        with_base("{ poisson = 0.3 }", ""),
        with_base("{ youngs_modulus = \"210 GPa\" }", ""),
        with_base("{ youngs_modulus = \"210 GPa\", poisson = -1 }", ""),
        with_base("{ youngs_modulus = \"-210 GPa\", poisson = 0.3 }", ""),
        with_base("{ youngs_modulus = 210, poisson = 0.3, E = 3 }", ""),
        with_base("\"rigid\"\nfoundation.layers = [{ E = 1, nu = 0.3, h = 1 }]", ""),
        with_base("\"rigid\"\nfoundation.layers = [{ E = 1, nu = 0.3, h = 1, G = 3 }]", ""),
    ];
    let said = twice.map(|text| match parse(&text) {
        Ok(_) => panic!("was not refused: {text}"),
        Err(error) => format!("{error}\n"),
    });
    insta::assert_snapshot!(said.join("\n"));
}

#[test]
fn what_others_call_a_key_is_suggested() {
    let said = [
        ("foundation.base =", "E = \"210 GPa\"\nfoundation.base ="),
        ("foundation.base =", "mu = 0.3\nfoundation.base ="),
        ("name =", "friction.mu = 0.3\nname ="),
        ("name =", "description = \"?\"\nname ="),
        ("radius = \"10 mm\"", "R = \"10 mm\", E = \"210 GPa\""),
        ("approach = \"1 um\"", "F = \"1 kN\""),
        ("approach = \"1 um\"", "indentation = \"1 micron\""),
        ("approach = \"1 um\"", "approach = \"1 micron\""),
        ("mesh = 16", "mesh = 16\ntol = 1e-6"),
        ("mesh = 16", "mesh = 16\n[sweep]\nfoundation.base.nu = [0, 0.1]"),
    ];
    let said = said.map(|(old, new)| {
        assert!(SPHERE.contains(old), "{old}");
        format!("{}\n", parse(&SPHERE.replacen(old, new, 1)).expect_err(new))
    });
    insta::assert_snapshot!(said.join("\n"));
}

#[test]
fn a_modulus_that_is_set_takes_the_place_of_the_other() {
    let set = |text: &str, setting: &str| {
        let files = &mut |name: &str| Err(format!("no file {name}"));
        read(&with_settings(text, "edited.toml", &[setting.to_owned()], files).unwrap())
    };
    let young = set(SPHERE, "foundation.base.youngs_modulus=210GPa");
    assert_eq!(values(&young, "youngs_modulus"), numbers(&[210e9]));
    let layered = with_base(
        "\"rigid\"\nfoundation.layers = [{ youngs_modulus = 3, poisson = 0.5, thickness = 1 }]",
        "[sweep]\n\"foundation.layers[0].youngs_modulus\" = [3, 6]\n",
    );
    // The layer's own modulus and the axis both give way.
    let shear = set(&layered, "layer0_shear_modulus = 2");
    assert_eq!(values(&shear, "layer0_shear_modulus"), numbers(&[2.0]));
}

#[test]
fn a_scene_without_friction_is_frictionless() {
    let without = SPHERE.replacen("friction.mu = 0.3\n", "", 1);
    let zero = SPHERE.replacen("friction.mu = 0.3", "friction.mu = 0", 1);
    let (without_friction, zero) = (read(&without), read(&zero));
    assert_eq!(without_friction.points()[0].job.canonical(), zero.points()[0].job.canonical());
    assert_eq!(values(&without_friction, "mu"), numbers(&[0.0]));
    let search = read(&format!("kind = \"multiplicity\"\n{without}"));
    assert_eq!(search.points()[0].job.case().unwrap().scene.friction.mu, 0.0);
    // A table that was begun and holds nothing has lost something.
    let begun = without.replacen("loading", "friction = {}\nloading", 1);
    assert!(parse(&begun).unwrap_err().to_string().contains("`friction.mu` is missing"));
}

proptest! {
    /// The column shows the modulus that was given whatever it was, although the job keeps another.
    #[test]
    fn the_modulus_that_was_given_is_shown(digits in 1u64..10_000, exponent in -3..10i32, poisson in 0u32..=50) {
        let modulus: f64 = format!("{digits}e{exponent}").parse().unwrap();
        let poisson = f64::from(poisson) / 100.0;
        let study = read(&with_base(&format!("{{ youngs_modulus = {modulus:e}, poisson = {poisson} }}"), ""));
        prop_assert_eq!(values(&study, "youngs_modulus"), numbers(&[modulus]));
        let scene = study.points()[0].job.case().unwrap().scene.clone();
        let Base::Elastic(material) = scene.foundation.base else { panic!("the base is rigid") };
        prop_assert_eq!(material.shear_modulus, modulus / (2.0 * (1.0 + poisson)));
    }
}
