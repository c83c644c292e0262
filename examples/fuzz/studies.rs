//! Mutated study files.

use contact::model::Shape;
use study::label::label;
use study::{Job, NamedFile, Study};

use crate::mutation::{Dice, mutated};

const GOOD: &[&str] = &[
    include_str!("../../sweeps/accuracy.toml"),
    include_str!("../../sweeps/cattaneo-loop.toml"),
    include_str!("../../sweeps/convergence.toml"),
    include_str!("../../sweeps/cost.toml"),
    include_str!("../../sweeps/effects.toml"),
    include_str!("../../sweeps/fine-enough.toml"),
    include_str!("../../sweeps/layers.toml"),
    include_str!("../../sweeps/multiplicity.toml"),
    include_str!("../../sweeps/regularisation.toml"),
    include_str!("../../sweeps/separation.toml"),
    include_str!("../../sweeps/sliding.toml"),
    include_str!("../../sweeps/spence.toml"),
    include_str!("../../sweeps/sphere.toml"),
    include_str!("../../sweeps/stick-zone.toml"),
    include_str!("../../sweeps/uniqueness.toml"),
    include_str!("../../sweeps/uniqueness-layer.toml"),
    include_str!("../../sweeps/wheel-on-rail.toml"),
    HEIGHT_MAP,
];

const HEIGHT_MAP: &str = r#"name = "map"
[scene]
foundation.base = { youngs_modulus = "210 GPa", poisson = 0.3 }
punch = { shape = "height-map", file = "map.csv", unit = "um", width_x = "1 mm", width_y = "1 mm" }
loading.steps = [{ normal_force = "1 N" }, { shift_x = "1 um", increments = 3 }]
[numerics]
mesh = [8, 16]
[[sweep.zip]]
friction.mu = [0, 0, 0.3]
"foundation.base.youngs_modulus" = [1, 2, 2]
"#;

const DICTIONARY: &[&str] = &[
    "name",
    "question",
    "kind",
    "accuracy",
    "scene",
    "numerics",
    "search",
    "sweep",
    "refine",
    "bisect",
    "find",
    "fill",
    "branch",
    "figure",
    "zip",
    "convergence",
    "cost",
    "foundation",
    "base",
    "layers",
    "punch",
    "material",
    "friction",
    "domain",
    "loading",
    "steps",
    "shear_modulus",
    "youngs_modulus",
    "poisson",
    "thickness",
    "shape",
    "radius",
    "radius_x",
    "width_x",
    "angle",
    "file",
    "unit",
    "surface",
    "wheel",
    "rail",
    "side",
    "mu",
    "approach",
    "normal_force",
    "shift_x",
    "force_y",
    "tilt_x",
    "moment_z",
    "twist",
    "increments",
    "cycle_from",
    "cycles",
    "mesh",
    "projection",
    "epsilon",
    "ceiling",
    "method",
    "tolerance",
    "max_iterations",
    "simulate",
    "starts",
    "seed",
    "from",
    "to",
    "count",
    "log",
    "label",
    "x",
    "y",
    "series",
    "panels",
    "band",
    "title",
    "on",
    "until",
    "at_most",
    "axis",
    "along",
    "reference",
    "repeat",
    "threads",
    "of",
    "is",
    "E",
    "nu",
    "\"sphere\"",
    "\"ellipsoid\"",
    "\"flat-rectangle\"",
    "\"flat-disk\"",
    "\"cone\"",
    "\"height-map\"",
    "\"wheel-on-rail\"",
    "\"rigid\"",
    "\"solve\"",
    "\"cost\"",
    "\"convergence\"",
    "\"multiplicity\"",
    "\"uniqueness\"",
    "\"newton\"",
    "\"seidel\"",
    "\"midpoint\"",
    "0",
    "-1",
    "1",
    "2",
    "64",
    "4096",
    "4097",
    "1e-300",
    "1e300",
    "1e999",
    "nan",
    "-inf",
    "-0.0",
    "0.5",
    "0.4999",
    "4294967295",
    "4294967296",
    "99999999999999999999",
    "0xff",
    "0b1",
    "1_000",
    "true",
    "1979-05-27",
    "\"1 um\"",
    "\"1e999 m\"",
    "\"1 kN\"",
    "\"1 kN/mm2\"",
    "\"90 deg\"",
    "\"0,5 mm\"",
    "\"10%\"",
    "\"\"",
    "\"\\u001b]0;x\\u0007\"",
    "'''",
    "\"\"\"",
    "[]",
    "{}",
    "[[]]",
    "[{}]",
    "[0, 1]",
    "[[8, 8], [16, 16]]",
    "= ",
    "\n",
    ", ",
    ".",
    "[",
    "]",
    "{",
    "}",
    "\n[sweep]\n",
    "\n[[sweep.zip]]\n",
    "\n[[figure]]\n",
    "\n[numerics]\n",
    "{ from = 1, to = 2, count = 3 }",
    "{ from = 1, to = 2, count = 1000000 }",
    "\"loading.steps[0].shift_x\"",
    "\"foundation.layers[0].thickness\"",
    "\"loading.steps[4294967295].twist\"",
    "# \u{202e}",
];

/// Makes a study file.
pub(crate) fn text(dice: &mut Dice) -> String {
    let good = dice.pick(GOOD);
    mutated(good, DICTIONARY, GOOD, dice)
}

/// The largest number of points of which every one is looked at.
const FEW_POINTS: usize = 200;

/// Reads a study as `plan` does, and returns whether it was accepted.
pub(crate) fn read(text: &str) -> bool {
    let study = match Study::parse(text, "study.toml", &mut file) {
        Ok(study) => study,
        Err(error) => {
            let said = error.to_string();
            assert!(!error.mistakes().is_empty(), "it was refused without a reason");
            assert!(said.len() < 1 << 17, "the message is too long");
            assert!(!said.contains(['\u{1b}', '\u{202e}']), "the message has escapes");
            return false;
        }
    };
    let columns = study.columns();
    for index in (0..study.len()).take(FEW_POINTS) {
        let point = study.point(index).expect("every point of a study can be made");
        let canonical = point.job.canonical();
        assert_eq!(Job::parse(&canonical).expect("a job reads its own text").key(), point.key);
        if index == 0 {
            for column in columns.iter().take(FEW_POINTS) {
                let (_, _) = (column.value(&point, None), label(column, &columns));
            }
            forecast(&study, &point.job);
        }
    }
    let stored = Study::from_definition(&study.definition()).expect("a study reads its definition");
    assert_eq!((stored.len(), stored.name()), (study.len(), study.name()));
    true
}

/// Forecasts a job, which lays out its grid. Wheels are left out: finding their contact takes long.
fn forecast(study: &Study, job: &Job) {
    if let Some(case) = job.case()
        && !matches!(case.scene.punch.shape, Shape::WheelOnRail(_))
    {
        // A scene may be refused here.
        let _ = contact::forecast(&case.scene, &case.numerics, study.surfaces());
    }
}

/// Gives out the files that studies name.
fn file(name: &str) -> Result<NamedFile, String> {
    let bytes = match name {
        "map.csv" => b"0 1 2\n3 4 5\n6 7 8\n".to_vec(),
        _ if name.ends_with(".prw") => {
            include_bytes!("../../sweeps/profiles/MBench_S1002_v3.prw").to_vec()
        }
        _ if name.ends_with(".prr") => {
            include_bytes!("../../sweeps/profiles/MBench_UIC60_v3.prr").to_vec()
        }
        _ => return Err("there is no such file".to_owned()),
    };
    Ok(NamedFile { bytes, may_quote: true })
}
