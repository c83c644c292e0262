//! Texts of studies that are edited: keys that are set, and ladders that are made.

use study::edit::{with_cost_ladder, with_settings};
use study::{Kind, Study};

use crate::sphere::{SPHERE, sphere};

fn read(text: &str) -> Study {
    Study::parse(text, "edited.toml", &mut |name| Err(format!("no file {name}"))).unwrap()
}

/// Sets keys in a text; an error in words with its cause.
fn set(text: &str, settings: &[&str]) -> Result<String, String> {
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    with_settings(text, "edited.toml", &settings, &mut |name| Err(format!("no file {name}")))
        .map_err(|error| {
            let cause = std::error::Error::source(&error);
            cause.map_or(error.to_string(), |cause| format!("{error}: {cause}"))
        })
}

#[test]
fn a_key_that_is_set_is_no_axis() {
    let swept = sphere("", "[sweep]\nfriction.mu = [0.1, 0.2]\nmesh = [8, 16]\n");
    let text = set(&swept, &["mu=0.4", "loading.steps[0].approach = 2um"]).unwrap();
    let study = read(&text);
    assert_eq!(study.axes().map(|axis| axis.column()).collect::<Vec<_>>(), ["mesh"]);
    let scene = &study.points()[0].job.case().unwrap().scene.clone();
    assert_eq!((scene.friction.mu, scene.loading.steps[0].approach), (0.4, Some(2e-6)));
    let exact = sphere("accuracy = \"1%\"\n", "").replace("mesh = 16\n", "");
    assert!(read(&set(&exact, &["mesh=8"]).unwrap()).adaptive().is_none());
}

#[test]
fn a_setting_that_cannot_be_made_says_why() {
    let refused = |setting: &str| set(SPHERE, &[setting]).unwrap_err();
    assert_eq!(refused("mu"), "--set mu: must be KEY=VALUE, for example friction.mu=0.5");
    assert_eq!(
        refused("friction.nu=1"),
        "--set friction.nu=1: there is no key `friction.nu`; did you mean `friction.mu`?"
    );
    assert_eq!(
        refused("loading.steps[1].shift_x=0"),
        "--set loading.steps[1].shift_x=0: edited.toml has no place for it: `steps` has no entry 1"
    );
    assert!(set("name = 3", &["mesh"]).unwrap_err().contains("must be KEY=VALUE"));
    assert!(set("name = ", &["mesh=8"]).unwrap_err().contains("not valid TOML"));
}

#[test]
fn a_scene_gets_a_ladder_of_costs() {
    let ladder = |text: &str, settings: &[String]| {
        with_cost_ladder(text, "edited.toml", settings, &mut |_| Err(String::new()))
    };
    let study = read(&ladder(SPHERE, &[]).unwrap());
    assert_eq!((study.kind(), study.name(), study.len()), (Kind::Cost, "base-cost", 27));
    let swept = sphere("", "[sweep]\nfriction.mu = [0.1, 0.2]\n");
    assert!(ladder(&swept, &[]).unwrap_err().to_string().contains("varies friction.mu"));
    assert_eq!(read(&ladder(&swept, &["mu=0.1".to_owned()]).unwrap()).len(), 27);
    assert!(ladder(SPHERE, &["mesh=8".to_owned()]).is_err());
    let search = sphere("kind = \"multiplicity\"\n", "");
    assert!(ladder(&search, &[]).unwrap_err().to_string().contains("solves no scene"));
}

/// A ladder is of one scene, and has meshes and tolerances of its own.
#[test]
fn a_ladder_takes_neither_conditions_nor_formulas_of_its_rungs() {
    let ladder = |text: &str, settings: &[String]| {
        with_cost_ladder(text, "edited.toml", settings, &mut |_| Err(String::new())).unwrap()
    };
    let swept = sphere(
        "",
        "[sweep]\nfriction.mu = [0.1, 0.2]\n[[exclude]]\nwhen = \"mu < 0.15\"\n\
         [[keep]]\nwhen = \"mesh == 16\"\n",
    );
    assert_eq!(read(&ladder(&swept, &["mu=0.1".to_owned()])).len(), 27);
    let derived = sphere(
        "",
        "[derive]\nmesh = \"round(radius / 1 mm)\"\ntolerance = \"1e-8 * mu\"\n\
         epsilon = \"tolerance / mesh\"\n",
    );
    let study = read(&ladder(&derived.replace("mesh = 16\n", ""), &[]));
    assert_eq!((study.len(), study.kind()), (27, Kind::Cost));
}

/// Without drawn keys nothing is left whose influence could be asked for.
#[test]
fn a_study_of_sensitivity_whose_keys_are_set_solves() {
    let text = sphere(
        "kind = \"sensitivity\"\n[sensitivity]\nof = \"load\"\n[figure]\nkind = \"sensitivity\"\n\
         y = \"load\"\n",
        "[sample]\nmethod = \"sobol\"\ncount = 4\n[sample.keys]\nfriction.mu = { from = 0.1, to = 0.3 }\n\
         punch.radius = { from = \"1 mm\", to = \"3 mm\" }\n",
    );
    let one = read(&set(&text, &["mu=0.2"]).unwrap());
    assert_eq!(one.kind(), Kind::Sensitivity);
    let none = read(&set(&text, &["mu=0.2", "radius=2mm"]).unwrap());
    assert_eq!((none.kind(), none.len()), (Kind::Solve, 1));
}
