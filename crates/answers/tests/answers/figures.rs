//! The figures that studies suggest, and the points that no figure draws.

use answers::{AnswerTable, FigureRows, Results, Undrawn};
use report::Cell;
use study::{Figure, Study};

use crate::shelf::Shelf;
use crate::{SPHERES, parse};

const SHAPES: [&str; 5] = [
    r#"{ shape = "sphere", radius = "50 mm" }"#,
    r#"{ shape = "ellipsoid", radius_x = "50 mm", radius_y = "20 mm" }"#,
    r#"{ shape = "cone", angle = "1 deg" }"#,
    r#"{ shape = "flat-disk", radius = "1 mm" }"#,
    r#"{ shape = "flat-rectangle", width_x = "2 mm", width_y = "1 mm" }"#,
];

/// A way of loading with an axis, and the columns that it prescribes.
struct SweptLoading {
    steps: &'static str,
    axis: &'static str,
    prescribed: &'static [&'static str],
}

const LOADINGS: [SweptLoading; 12] = [
    SweptLoading {
        steps: r#"[{ approach = "10 um" }]"#,
        axis: r#""loading.steps[0].approach" = ["5 um", "10 um", "20 um"]"#,
        prescribed: &["at_approach"],
    },
    SweptLoading {
        steps: r#"[{ normal_force = "1 kN" }]"#,
        axis: r#""loading.steps[0].normal_force" = ["0.5 kN", "1 kN", "2 kN"]"#,
        prescribed: &["load"],
    },
    SweptLoading {
        steps: r#"[{ normal_force = "1 kN" }]"#,
        axis: "friction.mu = [0.05, 0.2, 0.4]",
        prescribed: &["load"],
    },
    SweptLoading {
        steps: r#"[{ normal_force = "1 kN" }]"#,
        axis: "foundation.base.poisson = [0.1, 0.3]",
        prescribed: &["load"],
    },
    SweptLoading {
        steps: r#"[{ normal_force = "1 kN" }]"#,
        axis: r#"foundation.base.shear_modulus = ["40 GPa", "80 GPa", "160 GPa"]"#,
        prescribed: &["load"],
    },
    SweptLoading {
        steps: r#"[{ normal_force = "1 kN" }]"#,
        axis: "mesh = [4, 6, 8]",
        prescribed: &["load"],
    },
    SweptLoading {
        steps: r#"[{ normal_force = "1 kN" }, { force_x = "100 N" }]"#,
        axis: r#""loading.steps[1].force_x" = ["50 N", "100 N", "200 N"]"#,
        prescribed: &["load", "force_x"],
    },
    SweptLoading {
        steps: r#"[{ approach = "10 um" }, { shift_x = "1 um" }]"#,
        axis: r#""loading.steps[1].shift_x" = ["0.5 um", "1 um", "2 um"]"#,
        prescribed: &["at_approach", "at_shift_x"],
    },
    SweptLoading {
        steps: r#"[{ normal_force = "1 kN" }, { twist = "0.1 mrad" }]"#,
        axis: r#""loading.steps[1].twist" = ["0.1 mrad", "0.2 mrad"]"#,
        prescribed: &["load", "at_twist"],
    },
    SweptLoading {
        steps: r#"[{ normal_force = "1 kN", shift_y = "0.5 um" }]"#,
        axis: r#""loading.steps[0].shift_y" = ["0.5 um", "1 um"]"#,
        prescribed: &["load", "at_shift_y"],
    },
    SweptLoading {
        steps: r#"[{ normal_force = "1 kN", steady = true, creepage_x = 1e-3 }]"#,
        axis: r#""loading.steps[0].creepage_x" = [1e-3, 2e-3]"#,
        prescribed: &["load", "at_shift_x", "at_creepage_x"],
    },
    SweptLoading {
        steps: r#"[{ normal_force = "1 kN" }, { distance = "0.2 mm", increments = 2, force_y = "20 N" }]"#,
        axis: r#""loading.steps[1].force_y" = ["20 N", "50 N"]"#,
        prescribed: &["load", "force_y"],
    },
];

fn swept(shape: &str, SweptLoading { steps, axis, .. }: &SweptLoading) -> Study {
    parse(&format!(
        "name = \"test\"\n[scene]\nfoundation.base = {{ shear_modulus = \"80 GPa\", poisson = 0.3 }}
         punch = {shape}\nfriction.mu = 0.3\nloading.steps = {steps}
         [numerics]\nmesh = 6\n[sweep]\n{axis}\n"
    ))
}

#[test]
fn a_suggested_figure_draws_what_the_scene_leaves_free_and_what_varies() {
    for shape in SHAPES {
        // What has an edge or a tip does not roll.
        let rolls = ["sphere", "ellipsoid"].iter().any(|round| shape.contains(round));
        let is_rolling = |loading: &&SweptLoading| {
            ["steady", "distance"].iter().any(|key| loading.steps.contains(key))
        };
        for loading in LOADINGS.iter().filter(|loading| rolls || !is_rolling(loading)) {
            let study = swept(shape, loading);
            let mut shelf = Shelf::default();
            shelf.run(&study);
            let results = Results::read(study, &shelf).unwrap();
            let named = format!("{shape}, {}, {}", loading.steps, loading.axis);
            let [Figure { x, y, .. }] = results.figures().unwrap() else {
                panic!("{named}: no figure")
            };
            let [y] = &y[..] else { panic!("{named}: {y:?}") };
            assert!(!loading.prescribed.contains(&&y[..]), "{named}: {y} over {x}");
            let table = results.table(&[y]).unwrap().select(&[y]).unwrap();
            let values: Vec<f64> = table.rows().iter().filter_map(|row| row[0].number()).collect();
            let (least, most) =
                values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| {
                    (least.min(*value), most.max(*value))
                });
            assert!(
                values.len() > 1 && most - least > 1e-5 * most.abs(),
                "{named}: {y} {values:?}"
            );
            assert!(results.usual_columns(false).unwrap().contains(y), "{named}");
        }
    }
}

#[test]
fn an_axis_along_which_nothing_varies_is_no_abscissa() {
    let of = |axes: &str| {
        let study = parse(&format!(
            "name = \"test\"\n{SPHERES}
             loading.steps = [{{ normal_force = \"1 kN\" }}]
             [numerics]\nmesh = 6\n[sweep]\n{axes}\n"
        ));
        let mut shelf = Shelf::default();
        shelf.run(&study);
        let results = Results::read(study, &shelf).unwrap();
        results.figures().unwrap().iter().map(|figure| figure.x.clone()).collect::<Vec<_>>()
    };
    // Bodies of one material do not couple, so that friction changes nothing.
    let mu = "friction.mu = [0.1, 0.2, 0.3, 0.4]";
    let radius = "punch.radius = [\"10 mm\", \"20 mm\"]";
    assert_eq!(of(&format!("{mu}\n{radius}")), ["radius"]);
    assert!(of(mu).is_empty());
}

fn pressed(more: &str) -> Study {
    parse(&format!(
        "name = \"test\"\n{more}\n{SPHERES}
         loading.steps = [{{ approach = \"1 um\" }}]
         [numerics]\nmesh = 4\n[sweep]\n\"loading.steps[0].approach\" = [1e-6, 2e-6, 3e-6, 4e-6]\n"
    ))
}

#[test]
fn points_without_a_certified_result_are_counted_and_not_drawn() {
    let study = pressed("");
    let mut shelf = Shelf::default();
    let choice = shelf.run(&study);
    let key = |point: usize| choice.points[point].key;
    shelf.fail(&key(0));
    shelf.set_aside(&key(1));
    shelf.make_older(&key(2));
    let results = Results::read(study, &shelf).unwrap();
    let rows = |y: &str, filter: Option<&str>| {
        let figure = Figure::new("approach".to_owned(), vec![y.to_owned()]);
        let rows = results.figure_rows(&figure, filter).unwrap();
        let values = rows.table.select(&[y]).unwrap().rows().concat();
        let drawn = values.iter().filter(|cell| **cell != Cell::Missing).count();
        (drawn, rows.undrawn)
    };
    let undrawn = |points, failed, left| Undrawn { points, failed, left, steps: false };
    for y in ["load", "iterations", "seconds", "approach"] {
        assert_eq!(rows(y, None), (1, undrawn(4, 2, 1)), "{y}");
    }
    assert_eq!(rows("load", Some("approach > 1.5e-6")), (1, undrawn(3, 1, 1)));
    assert_eq!(rows("load", Some("load > 0.0")), (1, undrawn(4, 2, 1)), "they may be meant");
    assert_eq!(rows("load", Some("status == \"certified\"")).1, undrawn(2, 0, 1));
}

#[test]
fn answers_say_what_they_leave_out() {
    let study = parse(&format!(
        "name = \"test\"\nkind = \"convergence\"\n{SPHERES}
         loading.steps = [{{ approach = \"1 um\" }}]
         [convergence]\nreference = \"finest\"\n[numerics]\nmesh = 4\n[sweep]\nmesh = [4, 8, 12, 16]\n"
    ));
    let mut shelf = Shelf::default();
    let choice = shelf.run(&study);
    shelf.fail(&choice.points[3].key);
    let results = Results::read(study, &shelf).unwrap();
    let answers = results.answers().unwrap();
    let table = |title: &str| &answers.iter().find(|answer| answer.title == title).unwrap().table;
    let orders = table("orders");
    let cell = |name: &str| &orders.rows()[0][orders.column(name).unwrap()];
    assert_eq!(cell("rungs"), &Cell::Text("3 of 4".to_owned()));
    assert_eq!(cell("reference"), &Cell::Text("mesh 12 x 12, the finest solved".to_owned()));
    let missing = "this leaves out 1 of 4 points: 1 failed, 0 have no result yet";
    assert_eq!(table("missing").rows(), [[Cell::Text(missing.to_owned())]]);
    assert_eq!(results.progress().failed, 1);
    assert!(answers.iter().all(|AnswerTable { table, .. }| !table.rows().is_empty()));
}

#[test]
fn a_study_of_solutions_and_one_of_brackets_hide_no_failure() {
    let search = parse(&format!(
        "name = \"test\"\nkind = \"multiplicity\"\n{SPHERES}
         loading.steps = [{{ approach = \"1 um\" }}]
         [numerics]\nmesh = 2\n[search]\nstarts = 2\n[sweep]\nfriction.mu = [0.1, 0.2]\n"
    ));
    let bracket = parse(
        "name = \"test\"\nkind = \"uniqueness\"
         [scene]\nfoundation.base = { shear_modulus = \"80 GPa\", poisson = 0.3 }
         punch = { shape = \"flat-rectangle\", width_x = \"2 mm\", width_y = \"2 mm\" }
         [numerics]\nmesh = 2\n[search]\nstarts = 1\n[sweep]\nfoundation.base.poisson = [0.1, 0.3]\n",
    );
    for (study, column) in [(search, "solutions"), (bracket, "mu_low")] {
        let mut shelf = Shelf::default();
        let choice = shelf.run(&study);
        shelf.fail(&choice.points[0].key);
        let results = Results::read(study, &shelf).unwrap();
        let table = results.table(&[column]).unwrap();
        let values = table.select(&[column]).unwrap().rows().concat();
        assert!(values[0] == Cell::Missing && values[1] != Cell::Missing, "{values:?}");
    }
}

/// A figure of one block of axes shows that block alone, and a filter narrows it further.
#[test]
fn a_figure_shows_the_points_of_its_condition() {
    let study = parse(&format!(
        "name = \"test\"\n{SPHERES}
         loading.steps = [{{ normal_force = \"1 kN\" }}]
         [numerics]\nmesh = 6\n[[sweep]]\nfriction.mu = [0.1, 0.3, 0.5]\n[[sweep]]\nmesh = [6, 8, 10]
         [figure]\nx = \"mesh\"\ny = \"load\"\nwhere = \"mu == 0.3\"\n"
    ));
    let mut shelf = Shelf::default();
    shelf.run(&study);
    let results = Results::read(study, &shelf).unwrap();
    let [figure] = results.figures().unwrap() else { panic!("one figure") };
    for (filter, points) in [(None, 3), (Some("mesh > 6"), 2), (Some("mu == 0.1"), 0)] {
        let FigureRows { table, undrawn } = results.figure_rows(figure, filter).unwrap();
        assert_eq!((table.rows().len(), undrawn.points), (points, points), "{filter:?}");
    }
}
