//! The keys and texts of points that are enumerated are those of the jobs at the points.

use std::path::Path;

use proptest::prelude::*;
use study::{NamedFile, PointKeys, Study};

/// Holds the enumerated texts and keys of a study against its jobs.
fn check(study: &Study) {
    let keys = PointKeys::of(study);
    // Two passes: the second finds every text of a part where the first has left it.
    for _ in 0..2 {
        for index in study.indices() {
            let point = study.point(index).unwrap();
            assert_eq!(keys.text(index).as_ref(), Some(&point.job.canonical()), "{index}");
            assert_eq!(keys.key(index), Some(point.key), "{index}");
        }
    }
    assert_eq!((keys.text(study.len()), keys.key(study.len())), (None, None));
}

#[test]
fn the_studies_of_the_program_have_the_same_keys_enumerated() {
    let sweeps = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../sweeps"));
    let mut names: Vec<_> = std::fs::read_dir(sweeps)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .collect();
    names.sort();
    let mut count = 0;
    for path in names {
        let text = std::fs::read_to_string(&path).unwrap();
        let mut file = |name: &str| {
            let bytes = std::fs::read(sweeps.join(name)).map_err(|error| error.to_string())?;
            Ok(NamedFile { bytes, may_quote: true })
        };
        // Some are there to be refused.
        let Ok(study) = Study::parse(&text, "study.toml", &mut file) else { continue };
        check(&study);
        count += 1;
    }
    assert!(count > 30, "{count}");
}

/// Axes of which a study has some, each with other parts of a job that it changes.
const AXES: [(&str, &str); 11] = [
    ("friction.mu", "[0.0, 0.1, 0.3]"),
    ("loading.steps[0].approach", "{ log = true, from = \"1 um\", to = \"10 um\", count = 3 }"),
    ("loading.steps[0].shift_x", "[0.0, \"1 um\", \"-1 um\"]"),
    ("loading.steps[1].shift_x", "[0.0, \"1 um\", \"2 um\"]"),
    (
        "punch",
        "[{ shape = \"flat-disk\", radius = \"1 mm\" }, { shape = \"sphere\", radius = \"50 mm\", \
         material = { shear_modulus = \"80 GPa\", poisson = 0.25 } }]",
    ),
    (
        "foundation.layers",
        "[[], [{ shear_modulus = \"8 GPa\", poisson = 0.3, thickness = \"1 mm\" }]]",
    ),
    ("foundation.base.poisson", "[0.0, 0.25, 0.5]"),
    ("domain.center_x", "[0.0, \"1 mm\"]"),
    ("mesh", "[8, [16, 12], 24]"),
    ("tolerance", "[1e-6, 1e-8]"),
    ("interior.depth", "[\"0.1 mm\", \"0.2 mm\"]"),
];

/// Tables that may stand beside the axes, each with the axis that it does not go with.
const BESIDE: [(&str, &str); 6] = [
    ("[derive]\ntolerance = \"1e-7 * punch.radius / (1 m) + 1e-9\"\n", "tolerance"),
    ("[derive]\n\"foundation.base.poisson\" = \"mu / 2\"\n", "foundation.base.poisson"),
    ("[[exclude]]\nwhen = \"mu > 0.2 && mesh == 8\"\n", ""),
    ("[[keep]]\nwhen = \"mu > 0.05 || poisson < 0.3\"\n", ""),
    (
        "[sample]\ncount = 5\nkeys.\"foundation.base.poisson\" = { from = 0.1, to = 0.4 }\n",
        "foundation.base.poisson",
    ),
    ("[[sweep.zip]]\nepsilon = [0.0, 1e-3]\nmethod = [\"auto\", \"newton\"]\n", ""),
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn studies_made_at_random_have_the_same_keys_enumerated(
        axes in proptest::sample::subsequence(AXES.to_vec(), 2..=5),
        beside in proptest::option::of(proptest::sample::select(BESIDE.to_vec())),
    ) {
        let lines = axes.iter().map(|(path, values)| format!("\"{path}\" = {values}\n"));
        let beside = beside.filter(|(_, without)| axes.iter().all(|(path, _)| path != without));
        let text = format!(
            "name = \"made\"\n[scene]\n\
             foundation.base = {{ shear_modulus = \"80 GPa\", {} }}\n\
             punch = {{ shape = \"sphere\", radius = \"10 mm\" }}\n\
             friction.mu = 0.2\n\
             domain = {{ width_x = \"5 mm\", width_y = \"5 mm\" }}\n\
             loading.steps = [{{ approach = \"1 um\" }}, {{ shift_x = \"1 um\" }}]\n\
             [numerics]\nmesh = 16\n[sweep]\n{}{}",
            match beside {
                Some((_, "foundation.base.poisson")) => "",
                _ => "poisson = 0.3",
            },
            lines.collect::<String>(),
            beside.map_or("", |(text, _)| text),
        );
        match Study::parse(&text, "study.toml", &mut |_| Err("there is none".to_owned())) {
            Ok(study) => check(&study),
            // A formula or a condition may have no meaning beside some axes.
            Err(error) => {
                prop_assert!(beside.is_some(), "{}\n{}", error, text);
                prop_assume!(false);
            }
        }
    }
}
