//! Studies that are right, and the points to which they expand.

use std::collections::HashSet;

use contact::model::{Base, Mesh, Punch, Shape, Side, Step, WheelRail};
use study::{Figure, NamedFile, Study, columns};

use crate::jobs::{RAIL, WHEEL, named, profiles, read_job};
use crate::sphere::SPHERE;

pub(crate) fn no_files(name: &str) -> Result<NamedFile, String> {
    Err(format!("{name}: no such file"))
}

fn read(text: &str) -> Study {
    Study::parse(text, "study.toml", &mut no_files).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the values of a column at every point, as shown.
fn shown(study: &Study, name: &str) -> Vec<String> {
    let columns = study.columns();
    let column = columns::find(&columns, name).unwrap_or_else(|| panic!("no column {name}"));
    study.points().iter().map(|point| column.value(point, None).to_string()).collect()
}

#[test]
fn a_study_without_axes_is_one_point() {
    let study = read(SPHERE);
    assert_eq!((study.len(), study.points().len(), study.figures()), (1, 1, &[][..]));
    assert!(study.point(1).is_none());
}

#[test]
fn units_spelling_and_order_leave_no_trace() {
    let plain = read(SPHERE).points()[0].key;
    let other = r#"
        name = "other"
        question = "?"
        numerics = { tolerance = 1e-8, mesh = 16, projection = "average" }
        [scene.loading]
        steps = [{ shift_x = 0, approach = 1e-6 }]
        [scene.friction]
        mu = 3e-1
        [scene.punch]
        radius = "1cm"
        shape = "sphere"
        [scene.foundation.base]
        poisson = 0.30
        shear_modulus = 80_000_000_000
    "#;
    assert_eq!(read(other).points()[0].key, plain);
    assert_ne!(read(&SPHERE.replace("10 mm", "11 mm")).points()[0].key, plain);
}

#[test]
fn the_last_axis_is_the_fastest() {
    let study = read(&format!(
        "{SPHERE}[sweep]\n\"numerics.mesh\" = [32, [8, 4]]\nfriction.mu = [0.1, 0.2, 0.3]\n"
    ));
    assert_eq!(shown(&study, "mesh"), ["32", "32", "32", "8x4", "8x4", "8x4"]);
    assert_eq!(shown(&study, "mu"), ["0.1", "0.2", "0.3", "0.1", "0.2", "0.3"]);
    assert_eq!(shown(&study, "scene.friction.mu"), shown(&study, "mu"));
    assert_eq!(study.points()[3].job.case().unwrap().numerics.mesh, Mesh::Exact([8, 4]));
    assert_eq!(study.points()[3].job.case().unwrap().scene.friction.mu, 0.1);
    let columns = study.columns();
    assert_eq!(
        columns.iter().take(2).map(|column| column.name.as_ref()).collect::<Vec<_>>(),
        ["mesh", "mu"]
    );
}

#[test]
fn axes_with_one_table_in_common_keep_their_places() {
    let sweep = "[sweep]\nfoundation.base.poisson = [0, 0.3]\nmesh = [8, 16]\nfoundation.base.shear_modulus = [\"8 GPa\", \"80 GPa\"]\n";
    let study = read(&format!("{SPHERE}{sweep}"));
    assert_eq!(
        study.axes().map(|axis| axis.column()).collect::<Vec<_>>(),
        ["poisson", "mesh", "shear_modulus"]
    );
}

#[test]
fn ranges_hold_their_ends_and_round_numbers_between() {
    let study =
        read(&format!("{SPHERE}[sweep]\nfriction.mu = {{ from = 0, to = 1, count = 11 }}\n"));
    assert_eq!(
        shown(&study, "mu"),
        ["0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9", "1"]
    );
    let study = read(&format!(
        "{SPHERE}[sweep]\n\"loading.steps[0].shift_x\" = {{ from = \"-0.1 mm\", to = \"0.3 mm\", count = 5 }}\n"
    ));
    assert_eq!(shown(&study, "shift_x"), ["-0.0001", "0", "0.0001", "0.0002", "0.0003"]);
    let study = read(&format!(
        "{SPHERE}[sweep]\npunch.radius = {{ log = true, from = \"1 um\", to = \"100 mm\", count = 6 }}\n"
    ));
    assert_eq!(shown(&study, "radius"), ["1e-6", "1e-5", "0.0001", "0.001", "0.01", "0.1"]);
    assert!(study.figures().iter().any(|figure| figure.log_x && figure.x == "radius"));
    let study =
        read(&format!("{SPHERE}[sweep]\nmesh = {{ log = true, from = 8, to = 64, count = 4 }}\n"));
    assert_eq!(shown(&study, "mesh"), ["8", "16", "32", "64"]);
    let study = read(&format!(
        "{SPHERE}[sweep]\n\"loading.steps[0].tilt_x\" = {{ from = \"5 deg\", to = \"-5 deg\", count = 3 }}\n"
    ));
    assert_eq!(shown(&study, "tilt_x")[1..], ["0", "-0.08726646259971647"]);
}

#[test]
fn zipped_axes_advance_together() {
    let sweep = "[sweep]\nmesh = [8, 16]\n[[sweep.zip]]\nfriction.mu = [0.1, 0.2]\npunch.radius = [\"1 mm\", \"2 mm\"]\n";
    let study = read(&format!("{SPHERE}{sweep}"));
    assert_eq!(shown(&study, "mesh"), ["8", "8", "16", "16"]);
    assert_eq!(shown(&study, "mu"), ["0.1", "0.2", "0.1", "0.2"]);
    assert_eq!(shown(&study, "radius"), ["0.001", "0.002", "0.001", "0.002"]);
    assert_eq!(study.groups().len(), 2);
}

#[test]
fn a_value_may_repeat_where_another_advances() {
    let sweep =
        "[[sweep.zip]]\nfriction.mu = [0.1, 0.1, 0.2]\nfoundation.base.poisson = [0, 0.3, 0.3]\n";
    let study = read(&format!("{SPHERE}{sweep}"));
    assert_eq!(shown(&study, "mu"), ["0.1", "0.1", "0.2"]);
    // No axis by itself tells the points apart, so the figure has both.
    assert!(study.figures().iter().all(|figure| figure.x == "mu" && figure.series == ["poisson"]));
    let sweep = "[[sweep.zip]]\nfriction.mu = [0.1, 0.1, 0.2]\nmesh = [8, 16, 32]\n";
    assert_eq!(read(&format!("{SPHERE}{sweep}")).figures()[0].x, "mesh");
    let refused = |sweep: &str| {
        let study = Study::parse(&format!("{SPHERE}{sweep}"), "study.toml", &mut no_files);
        study.expect_err(sweep).to_string()
    };
    let twice = refused("[[sweep.zip]]\nfriction.mu = [0.1, 0.2, 0.1]\nmesh = [8, 8, 8]\n");
    assert!(twice.contains("at their step 3 where they are at step 1"), "{twice}");
    let labels = refused(
        "[[sweep.zip]]\npunch = [{ shape = \"sphere\", radius = 1 }, { shape = \"sphere\", radius = 2 }]\nmesh = [8, 16]\n",
    );
    assert!(labels.contains("names two tables sphere"), "{labels}");
    let alone = refused("[sweep]\nfriction.mu = [0.1, 0.1]\n");
    assert!(alone.contains("names 0.1 twice"), "{alone}");
    let ladder = format!(
        "kind = \"convergence\"\n{SPHERE}[[sweep.zip]]\nmesh = [8, 8, 16]\nfriction.mu = [0, 1, 0]\n"
    );
    let ladder = Study::parse(&ladder, "study.toml", &mut no_files).unwrap_err().to_string();
    assert!(ladder.contains("a value of it repeats"), "{ladder}");
}

#[test]
fn a_table_replaces_a_table() {
    let punches = r#"[sweep]
        punch = [
            { shape = "cone", angle = "5 deg" },
            { label = "steel ball", shape = "sphere", radius = "1 mm", material = { shear_modulus = "80 GPa", poisson = 0.3 } },
        ]
        loading = [{ label = "shifted", steps = [{ approach = "1 um", shift_x = "1 um" }] }]
    "#;
    let study = read(&format!("{SPHERE}{punches}"));
    let jobs = study.points();
    assert_eq!(shown(&study, "punch"), ["cone", "steel ball"]);
    assert_eq!(shown(&study, "loading"), ["shifted", "shifted"]);
    assert_eq!(shown(&study, "radius"), ["", "0.001"]);
    assert!(matches!(
        jobs[0].job.case().unwrap().scene.punch,
        Punch { shape: Shape::Cone { .. }, material: None }
    ));
    assert!(jobs[1].job.case().unwrap().scene.punch.material.is_some());
    assert_eq!(jobs[0].job.case().unwrap().scene.loading.steps[0].shift_x, Some(1e-6));
    // A table may supply what the base leaves out.
    let bare = SPHERE.replace("punch = { shape = \"sphere\", radius = \"10 mm\" }\n", "");
    assert_eq!(read(&format!("{bare}{punches}")).len(), 2);
}

const PATH: &str = r#"
name = "path"
[scene]
foundation.base = "rigid"
foundation.layers = [
    { shear_modulus = "80 GPa", poisson = 0.3, thickness = "0.5 mm" },
    { shear_modulus = "8 GPa", poisson = 0.5, thickness = "2 mm" },
]
punch = { shape = "sphere", radius = "10 mm" }
friction.mu = 0.3
[[scene.loading.steps]]
normal_force = "1 kN"
[[scene.loading.steps]]
shift_x = "2 um"
increments = 4
[[scene.loading.steps]]
shift_x = "-2 um"
moment_z = "3 N mm"
increments = 8
[scene.loading]
cycle_from = 1
cycles = 2
[numerics]
mesh = 16
"#;

#[test]
fn layers_and_steps_have_keys_of_their_own() {
    let study = read(PATH);
    let scene = &study.point(0).unwrap().job.case().unwrap().scene.clone();
    assert_eq!((scene.foundation.base, scene.foundation.layers[1].poisson), (Base::Rigid, 0.5));
    assert_eq!(scene.loading.steps[0], Step { normal_force: Some(1000.0), ..Step::default() });
    assert_eq!(
        scene.loading.steps[2],
        Step { shift_x: Some(-2e-6), moment_z: Some(0.003), increments: 8, ..Step::default() }
    );
    assert_eq!((scene.loading.cycle_from, scene.loading.cycles), (Some(1), 2));
    for (column, value) in [
        ("base", "rigid"),
        ("layer1_thickness", "0.002"),
        ("foundation.layers[0].shear_modulus", "8e10"),
        ("normal_force", "1000"),
        ("step1_shift_x", "2e-6"),
        ("step2_increments", "8"),
        ("cycles", "2"),
    ] {
        assert_eq!(shown(&study, column), [value], "{column}");
    }
    let columns = study.columns();
    for absent in ["poisson", "shift_x", "step1_shift_y", "step3_shift_x", "layer2_poisson"] {
        assert!(columns::find(&columns, absent).is_none(), "{absent} is given nowhere");
    }
}

#[test]
fn axes_over_layers_and_steps() {
    let sweep = r#"
        [sweep]
        "foundation.layers[1].thickness" = { log = true, from = "0.1 mm", to = "10 mm", count = 3 }
        "loading.steps[1].increments" = [1, 2, 4]
        "loading.steps[2]" = [{ label = "back", shift_x = 0 }, { label = "hold" }]
    "#;
    let study = read(&format!("{PATH}{sweep}"));
    assert_eq!(study.len(), 18);
    assert_eq!(
        study.axes().map(|axis| axis.column()).collect::<Vec<_>>(),
        ["layer1_thickness", "step1_increments", "step2"]
    );
    assert_eq!(shown(&study, "step2")[..2], ["back", "hold"]);
    assert_eq!(shown(&study, "step2_shift_x")[..2], ["0", ""]);
    assert_eq!(
        study.points()[1].job.case().unwrap().scene.loading.steps[2],
        Step::default(),
        "the table replaces the step as a whole"
    );
    assert_eq!(shown(&study, "step1_increments")[..6], ["1", "1", "2", "2", "4", "4"]);
    assert_eq!(shown(&study, "layer1_thickness")[12], "0.01");
}

#[test]
fn axes_over_whole_lists_and_the_base() {
    let sweep = r#"
        [sweep]
        "foundation.layers" = [
            [{ shear_modulus = 1, poisson = 0, thickness = 1 }],
            { label = "soft", layers = [{ shear_modulus = 1, poisson = 0, thickness = 1 }, { shear_modulus = 2, poisson = 0, thickness = 2 }] },
        ]
        "foundation.base" = ["rigid", { label = "steel", shear_modulus = "80 GPa", poisson = 0.3 }]
        loading = [
            { label = "press", steps = [{ approach = "1 um" }] },
            { label = "press and shift", steps = [{ approach = "1 um" }, { shift_x = "1 um" }] },
        ]
    "#;
    let study = read(&format!("{PATH}{sweep}"));
    assert_eq!(
        shown(&study, "layers"),
        ["1 layer", "1 layer", "1 layer", "1 layer", "soft", "soft", "soft", "soft"]
    );
    assert_eq!(shown(&study, "base")[..4], ["rigid", "rigid", "steel", "steel"]);
    assert_eq!(shown(&study, "steps")[..2], ["1", "2"]);
    assert_eq!(shown(&study, "poisson")[..4], ["", "", "0.3", "0.3"]);
    assert_eq!(shown(&study, "step1_shift_x")[..2], ["", "1e-6"]);
    assert_eq!(shown(&study, "cycles")[..2], ["1", "1"], "the whole loading was replaced");
    assert_eq!(study.points()[4].job.case().unwrap().scene.foundation.layers.len(), 2);
}

#[test]
fn a_list_that_the_scene_leaves_out_is_made_of_the_axes() {
    let bare = SPHERE.replace("loading.steps = [{ approach = \"1 um\" }]\n", "");
    let sweep = "[sweep]\n\"loading.steps[0].approach\" = [1e-6, 2e-6]\n\"loading.steps[1].shift_x\" = [0, 1e-6]\n";
    let study = read(&format!("{bare}{sweep}"));
    assert_eq!(study.points()[3].job.case().unwrap().scene.loading.steps[1].shift_x, Some(1e-6));
    assert_eq!(study.points()[0].job.case().unwrap().scene.loading.steps.len(), 2);
}

#[test]
fn a_figure_of_increments_may_name_them() {
    let figure = "[figure]\nsteps = true\nx = \"increment\"\ny = \"force_x\"\n";
    let study = read(&format!("{PATH}{figure}"));
    assert!(study.figures().iter().any(|figure| figure.steps && figure.x == "increment"));
}

#[test]
fn points_that_coincide_share_their_key() {
    let sweep = "[sweep]\npunch = [{ label = \"a\", shape = \"sphere\", radius = 1 }, { label = \"b\", shape = \"sphere\", radius = \"1 m\" }]\n";
    let study = read(&format!("{SPHERE}{sweep}"));
    let points = study.points();
    assert_eq!(points[0].key, points[1].key);
    assert_ne!(points[0].values, points[1].values);
}

#[test]
fn height_maps_come_from_files_in_any_unit() {
    let map = r#"punch = { shape = "height-map", file = "rough.csv", unit = "um", width_x = "1 mm", width_y = "2 mm" }"#;
    let text = SPHERE.replace("punch = { shape = \"sphere\", radius = \"10 mm\" }", map);
    let mut asked = Vec::new();
    let mut files = |name: &str| {
        asked.push(name.to_owned());
        named(b"0, 1, 2\n3, 4, 5\n".to_vec())
    };
    let sweep = "[sweep]\nmesh = [8, 16]\npunch.file = [\"rough.csv\", \"rougher.csv\"]\n";
    let study = Study::parse(&format!("{text}{sweep}"), "study.toml", &mut files).unwrap();
    assert_eq!(asked, ["rough.csv", "rougher.csv"]);
    let points = study.points();
    let Shape::HeightMap { surface, width_y, .. } =
        &points[0].job.case().unwrap().scene.punch.shape
    else {
        panic!("not a height map")
    };
    assert_eq!(*width_y, 0.002);
    assert_eq!(
        study.surfaces().get(surface).unwrap().heights(),
        [0.0, 1e-6, 2e-6, 3e-6, 4e-6, 5e-6]
    );
    assert_eq!(shown(&study, "file")[..2], ["rough.csv", "rougher.csv"]);
    assert_eq!(points[0].key, points[1].key, "the content counts, not the name");
    // The definition needs no files any more.
    let again = Study::from_definition(&study.definition()).unwrap();
    assert_eq!(again.points(), points);
    // A job's own text finds its surface under its hash.
    let stored = study::surface::encode_surface(study.surfaces().get(surface).unwrap());
    let job = format!("name = \"job\"\n{}", points[0].job.to_toml());
    let alone = Study::parse(&job, "job.toml", &mut |name| {
        if name == surface { named(stored.clone()) } else { no_files(name) }
    })
    .unwrap();
    assert_eq!(alone.points()[0].job, points[0].job);
    assert!(
        Study::parse(&job, "job.toml", &mut |_| named(vec![1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0]))
            .is_err()
    );
}

#[test]
fn a_wheel_and_its_rail_come_from_files() {
    let punch = r#"punch = { shape = "wheel-on-rail", wheel = "w.prw", rail = "r.prr", side = "left", rolling_radius = "460 mm" }"#;
    let text = SPHERE.replace("punch = { shape = \"sphere\", radius = \"10 mm\" }", punch);
    let mut files = |name: &str| match name {
        "w.prw" => named(WHEEL.to_vec()),
        "r.prr" => named(RAIL.to_vec()),
        _ => no_files(name),
    };
    let sweep = "[sweep]\npunch.lateral = { from = 0, to = \"10 mm\", count = 3 }\npunch.yaw = [0, \"1 mrad\"]\n";
    let study = Study::parse(&format!("{text}{sweep}"), "study.toml", &mut files).unwrap();
    let points = study.points();
    let Shape::WheelOnRail(wheel) = &points[5].job.case().unwrap().scene.punch.shape else {
        panic!("not a wheel")
    };
    let [(wheel_name, _), (rail_name, _)] = profiles();
    assert_eq!((&wheel.wheel, &wheel.rail, wheel.side), (wheel_name, rail_name, Side::Left));
    assert_eq!(
        (wheel.lateral, wheel.yaw, wheel.roll, wheel.gauge),
        (0.01, 0.001, 0.0, WheelRail::GAUGE)
    );
    assert!(
        study.surfaces().profile(wheel_name).is_some()
            && study.surfaces().profile(rail_name).is_some()
    );
    assert_eq!(
        Study::from_definition(&study.definition()).unwrap().points(),
        points,
        "the files are in the definition"
    );
    assert_eq!(read_job(&points[5].job.to_toml()), points[5].job);
    let mut refused = |old: &str, new: &str| {
        Study::parse(&text.replace(old, new), "study.toml", &mut files).unwrap_err().to_string()
    };
    assert!(refused("\"w.prw\"", "\"r.prr\"").contains("cannot use this profile: it is a rail's"));
    assert!(refused("\"r.prr\"", "\"gone.prr\"").contains("gone.prr: no such file"));
    assert!(refused("side = \"left\", ", "").contains("`punch.side` is missing"));
    assert!(refused("side =", "radius = 1, side =").contains("a wheel-on-rail has no `radius`"));
}

#[test]
fn a_damaged_definition_is_an_error() {
    let bytes = read(SPHERE).definition();
    assert_eq!(Study::from_definition(&bytes).unwrap().text(), SPHERE);
    for length in 0..bytes.len() {
        assert!(Study::from_definition(&bytes[..length]).is_err());
    }
}

#[test]
fn figures() {
    let axes = "[sweep]\nfriction.mu = [0.1, 0.2, 0.3]\nmesh = [8, 16]\nprojection = [\"average\", \"midpoint\"]\n";
    let study = read(&format!("{SPHERE}{axes}"));
    let figure = |x: &str, y: &str, series: &[&str], log_y| Figure {
        series: series.iter().map(|name| (*name).to_owned()).collect(),
        panels: Some("projection".to_owned()),
        log_y,
        ..Figure::new(x.to_owned(), vec![y.to_owned()])
    };
    assert_eq!(study.figures(), [figure("mu", "stick_fraction", &["mesh"], false)]);
    let own = "[figure]\nx = \"numerics.mesh\"\ny = \"residual\"\nlog_y = true\npanels = \"projection\"\n";
    let study = read(&format!("{SPHERE}{axes}{own}"));
    assert_eq!(study.figures(), [figure("mesh", "residual", &["mu"], true)]);

    let several = r#"
        [[figure]]
        x = "numerics.mesh"
        y = ["residual", "tension"]
        panels = "projection"
        log_y = true
        [[figure]]
        name = "reach"
        title = "How far it reaches"
        x = "mu"
        y = "contact_radius"
        series = []
        [[figure]]
        x = "mu"
        y = "load"
    "#;
    let study = read(&format!("{SPHERE}{axes}{several}"));
    let [two, reach, load] = study.figures() else { panic!("{:?}", study.figures()) };
    assert_eq!(
        *two,
        Figure {
            y: vec!["residual".to_owned(), "tension".to_owned()],
            ..figure("mesh", "residual", &["mu"], true)
        }
    );
    assert_eq!((reach.title.as_deref(), &reach.series), (Some("How far it reaches"), &vec![]));
    assert_eq!(load.series, ["mesh", "projection"]);
    let stems = [two, reach, load].map(|figure| figure.stem(study.name()));
    assert_eq!(stems, ["base", "base-reach", "base-3"]);
    assert!(
        read(&format!("figure = []\n{SPHERE}{axes}")).figures().is_empty(),
        "an empty list is none"
    );
}

#[test]
fn the_stick_zone_study_is_what_it_says() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../sweeps/stick-zone.toml");
    let study = read(&std::fs::read_to_string(path).unwrap());
    let points = study.points();
    let keys: HashSet<_> = points.iter().map(|point| point.key).collect();
    assert_eq!((study.name(), study.len(), keys.len()), ("stick-zone", 120, 120));
    assert_eq!(shown(&study, "punch")[..2], ["flat disk", "sphere"]);
    assert_eq!(shown(&study, "approach")[..2], ["1e-6", "2e-5"]);
    assert!(points.iter().all(|point| point.job.case().unwrap().numerics.tolerance == 1e-8));
    assert!(
        study.figures().iter().any(|figure| figure.panels.as_deref() == Some("punch")
            && figure.series == ["poisson", "mesh"])
    );
}
