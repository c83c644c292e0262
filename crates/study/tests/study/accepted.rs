//! Studies that are right: the points to which they expand, and the way of every part of a job
//! through a file.

use std::collections::HashSet;
use std::sync::OnceLock;

use proptest::prelude::*;

use contact::model::{
    Base, Domain, Effect, Foundation, Friction, InteriorQuestion, Layer, Loading, Material, Mesh,
    Method, Numerics, Projection, Punch, Rolling, RollingDirection, RollingHistory, Scene, Shape,
    Side, Step, Wear, WheelRail, WheelsetMotion,
};
use contact::punch::ProfileKind;
use study::key::Key;
use study::surface::MapReading;
use study::{Case, Figure, Job, NamedFile, Study, Value, columns};

use crate::sphere::SPHERE;

fn no_files(name: &str) -> Result<NamedFile, String> {
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

prop_compose! {
    fn material()(shear_modulus in 1e-3..1e15f64, poisson in 0.0..=0.5f64) -> Material {
        Material { shear_modulus, poisson }
    }
}

fn length() -> impl Strategy<Value = f64> {
    (1e-12..1e3f64).prop_union(1e-9..1e-3f64).boxed()
}

fn shape() -> impl Strategy<Value = Shape> {
    prop_oneof![
        length().prop_map(|radius| Shape::Sphere { radius }),
        length().prop_map(|radius| Shape::FlatDisk { radius }),
        (length(), length())
            .prop_map(|(radius_x, radius_y)| Shape::Ellipsoid { radius_x, radius_y }),
        (length(), length())
            .prop_map(|(width_x, width_y)| Shape::FlatRectangle { width_x, width_y }),
        (1e-6..1.5f64).prop_map(|angle| Shape::Cone { angle }),
        (length(), length()).prop_map(|(width_x, width_y)| Shape::HeightMap {
            surface: stored().0,
            width_x,
            width_y
        }),
        wheel_on_rail().prop_map(Shape::WheelOnRail),
    ]
}

prop_compose! {
    fn wheel_on_rail()(
        left: bool,
        lengths in prop::array::uniform5(length()),
        [lateral, yaw, roll] in prop::array::uniform3(-0.1..0.1f64),
    ) -> WheelRail {
        let [wheel, rail] = [&profiles()[0], &profiles()[1]].map(|(name, _)| name.clone());
        let [rolling_radius, gauge, gauge_depth, flange_back_distance, flange_back_to_origin] = lengths;
        let side = if left { Side::Left } else { Side::Right };
        WheelRail { wheel, rail, side, rolling_radius, gauge, gauge_depth, flange_back_distance, flange_back_to_origin, lateral, yaw, roll, motion: None }
    }
}

const WHEEL: &[u8] = include_bytes!("../../../../sweeps/profiles/MBench_S1002_v3.prw");
const RAIL: &[u8] = include_bytes!("../../../../sweeps/profiles/MBench_UIC60_v3.prr");

/// Returns the names and the bytes of a wheel's and a rail's profile.
fn profiles() -> &'static [(String, Vec<u8>); 2] {
    static PROFILES: OnceLock<[(String, Vec<u8>); 2]> = OnceLock::new();
    PROFILES.get_or_init(|| {
        [(WHEEL, ProfileKind::Wheel), (RAIL, ProfileKind::Rail)].map(|(file, kind)| {
            let profile = study::profile::read(file, kind).unwrap().profile;
            (study::profile::name(&profile), study::profile::encode_profile(&profile))
        })
    })
}

/// Gives out what is stored here.
fn from_store(name: &str) -> Result<NamedFile, String> {
    let found = profiles().iter().cloned().chain([stored()]).find(|(stored, _)| stored == name);
    named(found.map(|(_, bytes)| bytes).ok_or_else(|| format!("{name}: no such file"))?)
}

/// Gives out a file of which messages may repeat something.
fn named(bytes: Vec<u8>) -> Result<NamedFile, String> {
    Ok(NamedFile { bytes, may_quote: true })
}

/// Returns the name and the bytes of a surface.
fn stored() -> (String, Vec<u8>) {
    let reading = MapReading { unit: Some("nm"), ..MapReading::default() };
    let surface = study::surface::read(b"0 1\n2 3", &reading).unwrap().surface;
    (study::surface::name(&surface), study::surface::encode_surface(&surface))
}

prop_compose! {
    fn layer()(material in material(), thickness in length()) -> Layer {
        Layer { shear_modulus: material.shear_modulus, poisson: material.poisson, thickness }
    }
}

prop_compose! {
    fn foundation()(layers in prop::collection::vec(layer(), 0..5), material in material(), rigid: bool) -> Foundation {
        let base = if rigid && !layers.is_empty() { Base::Rigid } else { Base::Elastic(material) };
        Foundation { layers, base }
    }
}

/// Makes a degree of freedom of a step: left alone, moved, or governed by its force.
fn control() -> impl Strategy<Value = [Option<f64>; 2]> {
    prop_oneof![
        2 => Just([None, None]),
        1 => (-1e-3..1e-3f64).prop_map(|motion| [Some(motion), None]),
        1 => (-1e6..1e6f64).prop_map(|force| [None, Some(force)]),
    ]
}

prop_compose! {
    fn step()(normal in control(), shift in prop::array::uniform2(control()), turn in prop::array::uniform3(control()), increments in 1u32..20) -> Step {
        let [approach, normal_force] = normal;
        let [[shift_x, force_x], [shift_y, force_y]] = shift;
        let [[tilt_x, moment_x], [tilt_y, moment_y], [twist, moment_z]] = turn;
        let normal_force = normal_force.map(|force: f64| force.abs() + 1e-3);
        Step { approach, normal_force, shift_x, force_x, shift_y, force_y, tilt_x, moment_x, tilt_y, moment_y, twist, moment_z, increments, rolling: None }
    }
}

prop_compose! {
    fn loading()(
        first in prop_oneof![(-1e-3..1e-3f64).prop_map(|x| [Some(x), None]), (1e-3..1e6f64).prop_map(|x| [None, Some(x)])],
        mut steps in prop::collection::vec(step(), 1..12),
        from in prop::option::of(any::<prop::sample::Index>()),
        cycles in 1u32..4,
    ) -> Loading {
        [steps[0].approach, steps[0].normal_force] = first;
        let cycle_from = from.map(|from| from.index(steps.len()) as u32);
        Loading { steps, cycle_from, cycles: if cycle_from.is_some() { cycles } else { 1 } }
    }
}

prop_compose! {
    fn domain()(width_x in length(), width_y in length(), center_x in -1.0..1.0f64, center_y in prop_oneof![Just(0.0), -1.0..1.0f64]) -> Domain {
        Domain { width_x, width_y, center_x, center_y }
    }
}

prop_compose! {
    fn numerics()(
        mesh in prop_oneof![(1u32..4096).prop_map(Mesh::Across), [1u32..4096, 1u32..4096].prop_map(Mesh::Exact)],
        projection in prop_oneof![Just(Projection::Average), Just(Projection::Midpoint)],
        epsilon in prop_oneof![Just(0.0), 0.0..1.0f64],
        ceiling in prop::option::of(1.0..1e12f64),
        method in prop_oneof![Just(Method::Auto), Just(Method::Seidel), Just(Method::Newton)],
        tolerance in 1e-15..0.9f64,
        max_iterations in 1u32..,
        simulate in prop::sample::subsequence(Effect::OPTIONAL.to_vec(), 0..=Effect::OPTIONAL.len()),
    ) -> Numerics {
        Numerics { mesh, projection, epsilon, ceiling, method, tolerance, max_iterations, simulate }
    }
}

prop_compose! {
    /// Depths are in parts of that of a rigid base.
    fn interior()(
        maximum: bool,
        depths in prop::collection::vec(0.0..1.0f64, 0..3),
        points in prop::collection::vec([-1.0..1.0f64, -1.0..1.0f64, 0.0..1.0f64], 0..3),
    ) -> InteriorQuestion {
        InteriorQuestion { maximum: maximum || depths.is_empty(), depths, points }.normalised()
    }
}

prop_compose! {
    /// Makes a rolling, and the increments of its step.
    fn rolling()(
        creepages in prop::array::uniform3(prop::option::of(prop_oneof![Just(0.0), -1e-2..1e-2f64])),
        center in prop_oneof![Just(0.0), -1e-2..1e-2f64],
        is_backward: bool,
        distance in 1e-6..10.0f64,
        dq in prop::option::of(1e-6..1.0f64),
        (history, is_divided) in prop_oneof![
            Just((RollingHistory::Steady, false)),
            Just((RollingHistory::Transient, false)),
            Just((RollingHistory::Transient, true)),
        ],
        increments in 1u32..20,
    ) -> (Rolling, u32) {
        let [creepage_x, creepage_y, spin] = creepages;
        let parts = if is_divided { increments } else { 1 };
        let (dq, distance) = match history {
            RollingHistory::Steady => (dq, None),
            RollingHistory::Transient if is_divided => (Some(distance / f64::from(parts)), None),
            RollingHistory::Transient => (None, Some(distance)),
        };
        let direction = if is_backward { RollingDirection::Backward } else { RollingDirection::Forward };
        let spin_center = if spin.is_some() { center } else { 0.0 };
        let imposed = Default::default();
        (Rolling { creepage_x, creepage_y, spin, spin_center, direction, dq, distance, history, imposed }, parts)
    }
}

prop_compose! {
    fn motion()(speed in 1.0..100.0f64, angular_speed in prop::option::of(1.0..200.0f64), rates in prop::array::uniform3(0.1..1.0f64)) -> WheelsetMotion {
        let [lateral_velocity, yaw_rate, roll_rate] = rates;
        WheelsetMotion { speed, angular_speed, lateral_velocity, yaw_rate, roll_rate }
    }
}

/// Lets a step roll, at creepages that no force governs and that no wheelset imposes.
fn roll(step: &mut Step, (rolling, increments): (Rolling, u32), is_imposed: bool) {
    let keep = |creepage: Option<f64>, force: Option<f64>| {
        creepage.filter(|_| force.is_none() && !is_imposed)
    };
    let spin = keep(rolling.spin, step.moment_z);
    step.rolling = Some(Rolling {
        creepage_x: keep(rolling.creepage_x, step.force_x),
        creepage_y: keep(rolling.creepage_y, step.force_y),
        spin,
        spin_center: if spin.is_some() { rolling.spin_center } else { 0.0 },
        ..rolling
    });
    (step.shift_x, step.shift_y, step.twist, step.increments) = (None, None, None, increments);
}

prop_compose! {
    /// Makes a job that also has what rolls, moves and wears.
    fn solved_job()(
        job in plain_job(),
        rolling in prop::collection::vec(prop::option::of(rolling()), 12),
        motion in prop::option::of(motion()),
    ) -> Job {
        let Job::Solve(mut case) = job else { unreachable!("a plain job solves a scene") };
        let Scene { loading, punch, wear, .. } = &mut case.scene;
        // What has an edge or a tip does not roll.
        let is_round = !matches!(
            punch.shape,
            Shape::FlatRectangle { .. } | Shape::FlatDisk { .. } | Shape::Cone { .. }
        );
        let rolling: Vec<_> = rolling.into_iter().filter(|_| is_round).collect();
        let rolls = rolling.iter().zip(&loading.steps).any(|(rolling, _)| rolling.is_some());
        let is_turned = loading.steps.iter().any(|step| step.moment_z.is_some());
        let motion = motion.filter(|_| rolls && !is_turned);
        let mut is_imposed = false;
        if let Shape::WheelOnRail(wheel) = &mut punch.shape {
            let is_pulled = loading.steps.iter().any(|step| step.force_x.is_some());
            let is_pulled_aside = loading.steps.iter().any(|step| step.force_y.is_some());
            let aside = |velocity: f64| if is_pulled_aside { 0.0 } else { velocity };
            wheel.motion = motion.map(|motion| WheelsetMotion {
                angular_speed: motion.angular_speed.filter(|_| !is_pulled),
                lateral_velocity: aside(motion.lateral_velocity),
                roll_rate: aside(motion.roll_rate),
                ..motion
            });
            is_imposed = motion.is_some();
        }
        for (step, rolling) in loading.steps.iter_mut().zip(rolling) {
            rolling.into_iter().for_each(|rolling| roll(step, rolling, is_imposed));
        }
        if rolls {
            *wear = wear.map(|wear| Wear { update: false, repeat: 1, ..wear });
            case.numerics.epsilon = 0.0;
            case.numerics.method = Method::Auto;
        }
        Job::Solve(case)
    }
}

/// Makes a job of any kind that follows a path.
fn job() -> impl Strategy<Value = Job> {
    prop_oneof![
        3 => solved_job(),
        1 => (solved_job(), 1u32..1000, 1u32..64).prop_map(|(job, repeat, threads)| {
            Job::Cost { case: job.case().unwrap().clone(), repeat, threads }
        }),
    ]
}

prop_compose! {
    /// Makes a job without rolling.
    fn plain_job()(
        foundation in foundation(),
        shape in shape(),
        material in prop::option::of(material()),
        mu in 0.0..10.0f64,
        domain in prop::option::of(domain()),
        loading in loading(),
        interior in prop::option::of(interior()),
        numerics in numerics(),
        wear in prop::option::of((0.0..1e-9f64, any::<bool>(), 1u32..1000)),
    ) -> Job {
        let mut interior = interior;
        if let Some(InteriorQuestion { depths, points, .. }) = &mut interior {
            let deepest = foundation.depth().unwrap_or(1.0);
            let below = depths.iter_mut().chain(points.iter_mut().map(|point| &mut point[2]));
            below.for_each(|depth| *depth *= deepest);
        }
        let scene = Scene {
            foundation,
            punch: Punch { shape, material },
            friction: Friction { mu: if wear.is_some() { mu + 0.1 } else { mu } },
            wear: wear.map(|(coefficient, update, repeat)| Wear {
                coefficient,
                update,
                repeat: if loading.cycle_from.is_some() { repeat } else { 1 },
            }),
            domain,
            loading,
            interior,
        };
        Job::Solve(Case { scene, numerics })
    }
}

/// Returns the only job of a study, or the first of several.
fn read_job(text: &str) -> Job {
    let text = format!("name = \"job\"\n{text}");
    let study = Study::parse(&text, "job.toml", &mut from_store);
    study.unwrap_or_else(|error| panic!("{text}\n{error}")).points()[0].job.clone()
}

/// Returns the text of a study that has a job as its first: one of cost compares three meshes.
fn written(job: &Job) -> String {
    let text = job.to_toml();
    let Job::Cost { case, .. } = job else { return text };
    let [x, y] = case.numerics.mesh.sides();
    let first = match case.numerics.mesh {
        Mesh::Across(n) => n.to_string(),
        Mesh::Exact(_) => format!("[{x}, {y}]"),
    };
    let others: Vec<u32> = (1..5).filter(|n| *n != x && *n != y).take(2).collect();
    format!("{text}[sweep]\nnumerics.mesh = [{first}, {}, {}]\n", others[0], others[1])
}

proptest! {
    /// Serde's names are the file's names, but those of what rolls, which stand deeper: what serde writes
    /// as TOML is read as the same job.
    #[test]
    fn what_serde_writes_is_read(job in plain_job()) {
        let written = toml::to_string(&job).unwrap();
        prop_assert_eq!(read_job(&written), job);
    }

    #[test]
    fn what_a_job_writes_is_read(job in job()) {
        prop_assert_eq!(read_job(&written(&job)), job.clone());
        let mut plain = job.clone();
        let (Job::Solve(case) | Job::Cost { case, .. }) = &mut plain else { panic!("{job:?}") };
        let is_imposed = matches!(&case.scene.punch.shape, Shape::WheelOnRail(wheel) if wheel.motion.is_some());
        case.scene.loading = case.scene.loading.normalised(is_imposed);
        prop_assert_eq!(plain.key(), job.key());
        prop_assert_eq!(read_job(&written(&plain)).canonical(), job.canonical());
        prop_assert_eq!(Job::parse(&job.canonical()).ok(), Some(plain));
    }

    /// Every key that a study gives has a column, with the value that was given, under its name and
    /// under its path.
    #[test]
    fn every_key_of_a_job_fills_its_column(job in solved_job()) {
        let study = Study::parse(&format!("name = \"job\"\n{}", job.to_toml()), "job.toml", &mut from_store).unwrap();
        let point = study.point(0).unwrap();
        let columns = study.columns();
        let value = |name: &str| columns::find(&columns, name).map(|column| column.value(&point, None));
        let json = serde_json::to_value(&job).unwrap();
        let scene = &job.case().unwrap().scene;
        for key in Key::all(|list| if list == Key::Layers { scene.foundation.layers.len() as u32 } else { scene.loading.steps.len() as u32 }) {
            let mut path = key.path().replace('[', ".").replace(']', "");
            // A distance is written with the increments that divide it.
            let is_passing = |step: &Step| step.rolling.is_some_and(|rolling| rolling.history == RollingHistory::Transient);
            if matches!(key, Key::Dq(step) if is_passing(&scene.loading.steps[step as usize])) {
                continue;
            }
            let is_of_rolling = matches!(key, Key::CreepageX(_) | Key::CreepageY(_) | Key::Spin(_) | Key::Dq(_));
            let is_of_motion = matches!(key, Key::Speed | Key::AngularSpeed | Key::LateralVelocity | Key::YawRate | Key::RollRate);
            if is_of_rolling || is_of_motion {
                let (table, name) = path.rsplit_once('.').unwrap();
                path = format!("{table}.{}.{name}", if is_of_rolling { "rolling" } else { "motion" });
            }
            let given = path.split('.').try_fold(&json, |at, name| match name.parse::<usize>() {
                Ok(index) => at.get(index),
                Err(_) => at.get(name),
            });
            let expected = match given {
                Some(serde_json::Value::Number(x)) => Some(x.to_string().parse().unwrap()),
                Some(serde_json::Value::Array(list)) if !matches!(key, Key::Mesh | Key::Simulate | Key::InteriorDepths | Key::InteriorPoints) => Some(list.len() as f64),
                _ => None,
            };
            if let Some(expected) = expected {
                for name in [key.column(), key.path(), key.short()] {
                    prop_assert_eq!(value(&name).and_then(|value| value.as_f64()), Some(expected), "{}", name);
                }
            } else if given.is_none() && !matches!(key, Key::InteriorDepth | Key::Layers | Key::Cycles | Key::Increments(_) | Key::Distance(_) | Key::Steady(_) | Key::Direction(_) | Key::SpinCenter(_) | Key::WearUpdate | Key::WearRepeat | Key::Epsilon | Key::DomainCenterX | Key::DomainCenterY) {
                // A key without a default is missing, if there is a column for it at all.
                prop_assert_eq!(value(&key.column()).unwrap_or(Value::Missing), Value::Missing, "{}", key.column());
            }
        }
    }

    #[test]
    fn any_text_is_a_study_or_an_error(text in "\\PC*", at in any::<prop::sample::Index>()) {
        let _ = Study::parse(&text, "x.toml", &mut no_files).map_err(|error| error.to_string());
        // The same is true of any text inside a good study.
        let good = include_str!("../../../../sweeps/stick-zone.toml");
        let at = (0..=at.index(good.len())).rev().find(|at| good.is_char_boundary(*at)).unwrap();
        let (before, after) = good.split_at(at);
        for spoilt in [format!("{before}{text}{after}"), before.to_owned(), after.to_owned()] {
            let _ = Study::parse(&spoilt, "x.toml", &mut no_files).map_err(|error| error.to_string());
        }
    }
}
