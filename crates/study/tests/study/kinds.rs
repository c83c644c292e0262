//! Studies of every kind: what they ask for, and that a job of each kind survives being written and
//! read.

use contact::model::Mesh;
use contact::uniqueness::Sole;
use study::{Adaptive, Filling, Job, Kind, RootSearch, Study, columns};

use crate::sphere::sphere;

fn read(text: &str) -> Study {
    Study::parse(text, "kinds.toml", &mut |file| Err(format!("no file {file}")))
        .unwrap_or_else(|error| panic!("{text}\n{error}"))
}

/// Returns the study of a sphere of a kind, with lines after its tables.
fn of_kind(kind: &str, more: &str) -> Study {
    read(&sphere(&format!("kind = \"{kind}\"\n"), more))
}

const UNIQUENESS: &str = r#"
name = "x"
kind = "uniqueness"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
foundation.layers = [{ shear_modulus = "8 GPa", poisson = 0.4, thickness = "0.1 mm" }]
punch = { shape = "flat-disk", radius = "1 mm", material = { shear_modulus = "8 GPa", poisson = 0.1 } }
[numerics]
mesh = 4
epsilon = 0.1
[search]
starts = 7
seed = 3
"#;

#[test]
fn a_uniqueness_study_asks_about_bodies_and_sole_alone() {
    let study = read(UNIQUENESS);
    assert_eq!(study.kind(), Kind::Uniqueness);
    let Job::Uniqueness { question, search } = study.point(0).unwrap().job else {
        panic!("another kind of job")
    };
    assert_eq!(
        (question.sole, question.mesh, question.epsilon),
        (Sole::Disk { radius: 1e-3 }, Mesh::Across(4), 0.1)
    );
    assert_eq!(
        (question.foundation.layers.len(), question.punch.map(|m| m.poisson)),
        (1, Some(0.1))
    );
    assert_eq!((search.starts, search.seed), (7, 3));
    let columns = study.columns();
    let has = |name: &str| columns::find(&columns, name).is_some();
    assert!(has("mu_low") && has("mu_high") && has("starts") && has("layer0_poisson"));
    assert!(!has("mu") && !has("load") && !has("tolerance") && !has("solutions"));
    assert_eq!(study.figures()[..], [], "without an axis there is nothing to draw");
    let swept = read(&format!("{UNIQUENESS}[sweep]\nmesh = [2, 3]\nstarts = [1, 2]\n"));
    assert_eq!(swept.figures()[0].band, Some(["mu_low", "mu_high"].map(str::to_owned)));
    assert_eq!(swept.len(), 4);
}

const STRIP: &str = r#"
name = "x"
kind = "uniqueness"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "flat-rectangle", width_x = "3 mm", width_y = "1 m" }
[numerics]
mesh = [3, 1]
[search]
plane = true
"#;

#[test]
fn a_strip_is_a_row_of_a_few_elements_in_which_nothing_is_left_to_chance() {
    let study = read(STRIP);
    let job = study.point(0).unwrap().job;
    let Job::Uniqueness { question, .. } = &job else { panic!("another kind of job") };
    assert!(question.plane);
    let canonical = job.canonical();
    assert!(canonical.contains(r#""plane":true"#), "{canonical}");
    let space = read(&STRIP.replace("true", "false")).point(0).unwrap().job;
    assert!(!space.canonical().contains("plane"), "the text of other jobs is what it was");
    for job in [job, space] {
        let back = read(&format!("name = \"y\"\n{}", job.to_toml()));
        assert_eq!(back.point(0).unwrap().job.canonical(), job.canonical());
    }
    let columns = study.columns();
    assert!(columns::find(&columns, "critical_case").is_some());
    assert!(columns::find(&columns, "plane").is_some());
    let refused = |text: &str| {
        let study = Study::parse(text, "x.toml", &mut |_| Err(String::new()));
        study.err().map(|error| error.to_string()).unwrap()
    };
    for (other, place, said) in [
        (STRIP.replace("[3, 1]", "[3, 2]"), "--> x.toml:8:8", "must be [n, 1], one row"),
        (STRIP.replace("[3, 1]", "[13, 1]"), "--> x.toml:8:8", "1 to 12 elements along x"),
        (format!("{STRIP}starts = 3\n"), "--> x.toml:11:10", "no `starts`"),
        (format!("{STRIP}seed = 3\n"), "--> x.toml:11:8", "no `seed`"),
        (
            STRIP.replace(
                "\"flat-rectangle\", width_x = \"3 mm\", width_y = \"1 m\"",
                "\"flat-disk\", radius = 1",
            ),
            "--> x.toml:10:9",
            "must be false for a disk",
        ),
    ] {
        let error = refused(&other);
        assert!(error.contains(place) && error.contains(said), "{error}");
    }
}

#[test]
fn cases_are_of_few_elements_and_part_of_what_is_asked() {
    let cases = UNIQUENESS.replace("seed = 3", "seed = 3\ncases = true");
    let [with, without] = [&cases, UNIQUENESS].map(|text| read(text).point(0).unwrap().job);
    assert_ne!(with.key(), without.key());
    assert!(with.canonical().contains(r#""cases":true"#) && !without.canonical().contains("cases"));
    let back = read(&format!("name = \"y\"\n{}", with.to_toml()));
    assert_eq!(back.point(0).unwrap().job, with);
    let strip = STRIP.replace("plane = true", "plane = true\ncases = true");
    for (text, said) in [
        (cases.replace("mesh = 4", "mesh = 5"), "cases are of at most 16"),
        (strip, "must be false in a plane"),
    ] {
        let error = Study::parse(&text, "x.toml", &mut |_| Err(String::new())).unwrap_err();
        assert!(error.to_string().contains(said), "{error}");
    }
}

#[test]
fn branches_are_of_brackets_of_few_elements_that_nothing_else_narrows() {
    let branch = format!("{UNIQUENESS}[sweep]\n\"punch.radius\" = [1, 2]\n[branch]\n");
    let study = read(&format!("{branch}to = \"1%\"\n"));
    assert_eq!(study.adaptive(), Some(&Adaptive::Branch { to: 0.01, at_most: 20_000 }));
    // A figure of columns would have what weights alone show.
    assert!(study.figures().is_empty() && study.suggestions().is_empty());
    assert!(!study.is_sequence(0));
    // The bracket is the one of a study without branches.
    let plain = read(UNIQUENESS).point(0).unwrap().job;
    assert_eq!(read(&format!("{UNIQUENESS}[branch]\nto = 0.5\n")).point(0).unwrap().job, plain);
    let few = read(&format!("{branch}to = 0.001\nat_most = 7\n"));
    assert_eq!(few.adaptive(), Some(&Adaptive::Branch { to: 0.001, at_most: 7 }));
    let to = "to = \"1%\"\n";
    let with = |of_search: &str| {
        format!("{branch}{to}").replace("seed = 3", &format!("seed = 3\n{of_search}"))
    };
    let strip = STRIP.replace("plane = true", "starts = 3");
    for (text, said) in [
        (branch.clone(), "`branch.to` is missing"),
        (format!("{branch}to = \"90%\"\n"), "must be from 0.001 to 0.5"),
        (format!("{branch}to = 2\n"), "must be a part like"),
        (format!("{branch}to = 0.0001\n"), "must be from 0.001 to 0.5"),
        (format!("{branch}{to}at_most = 0\n"), "must be from 1 to 50000 cones"),
        (format!("{branch}{to}at_most = 50001\n"), "must be from 1 to 50000 cones"),
        (format!("{branch}{to}at_most = 2.5\n"), "must be a whole number of cones"),
        (format!("{branch}{to}most = 7\n"), "at_most"),
        (with("cases = true"), "no `cases`: `[branch]` goes through the cases"),
        (with("cases = false"), "no `cases`"),
        (with("width = 0.1"), "no `width`: `branch.to` says"),
        (with("plane = true"), "no `plane`: in a plane the end is exact"),
        (
            format!("{branch}{to}").replace("[sweep]\n", "[sweep]\nsearch.cases = [true, false]\n"),
            "no `cases`",
        ),
        (format!("{branch}{to}").replace("mesh = 4", "mesh = 5"), "cases are of at most 16"),
        (
            format!("{branch}{to}").replace("[sweep]\n", "[sweep]\nmesh = [2, 5]\n"),
            "cases are of at most 16",
        ),
        (format!("{strip}[branch]\n{to}[refine]\non = \"mu_low\"\nuntil = 0.1\n"), "in one way"),
    ] {
        let error = Study::parse(&text, "x.toml", &mut |_| Err(String::new())).unwrap_err();
        assert!(error.to_string().contains(said), "{said}: {error}");
    }
}

#[test]
fn a_width_is_of_cases_and_part_of_what_is_asked() {
    let cases = UNIQUENESS.replace("seed = 3", "seed = 3\ncases = true");
    let wide = cases.replace("cases = true", "cases = true\nwidth = 0.02");
    let [with, without] = [&wide, &cases].map(|text| read(text).point(0).unwrap().job);
    assert_ne!(with.key(), without.key());
    assert!(with.canonical().contains(r#""width":0.02"#), "{}", with.canonical());
    assert!(!without.canonical().contains("\"width\""), "{}", without.canonical());
    let back = read(&format!("name = \"y\"\n{}", with.to_toml()));
    assert_eq!(back.point(0).unwrap().job, with);
    for (text, said) in [
        (wide.replace("cases = true\n", ""), "must be left out without `cases = true`"),
        (wide.replace("0.02", "0.6"), "width"),
        (wide.replace("0.02", "0"), "width"),
    ] {
        let error = Study::parse(&text, "x.toml", &mut |_| Err(String::new())).unwrap_err();
        assert!(error.to_string().contains(said), "{error}");
    }
}

#[test]
fn a_uniqueness_set_too_fine_for_a_record_is_refused() {
    let refused = |mesh: &str, poisson: f64| {
        let text = format!(
            "name = \"x\"\nkind = \"uniqueness\"\n[scene]\nfoundation.base = {{ shear_modulus = 1, poisson = {poisson} }}\n\
             punch = {{ shape = \"flat-rectangle\", width_x = 1, width_y = 1 }}\n[numerics]\nmesh = {mesh}\n"
        );
        Study::parse(&text, "x.toml", &mut |_| Err(String::new()))
            .err()
            .map(|error| error.to_string())
    };
    for (mesh, most) in [("197", "196 x 196"), ("4096", "196 x 196"), ("[4096, 10]", "3798 x 9")] {
        let said = refused(mesh, 0.3).unwrap();
        assert!(
            said.contains(&format!("no more than {most} elements"))
                && said.contains("--> x.toml:7:8"),
            "{said}"
        );
    }
    assert_eq!((refused("196", 0.3), refused("[3798, 9]", 0.3)), (None, None));
    assert_eq!(refused("512", 0.5), None, "μ* = ∞ needs no witness");
}

/// The keys of a sample, of which a study of sensitivity makes its design.
const SAMPLE: &str = "[sample]\nmethod = \"sobol\"\ncount = 4\n[sample.keys]\n\
                      friction.mu = { from = 0.1, to = 0.5 }\n[sensitivity]\nof = \"load\"\n";

#[test]
fn jobs_of_every_kind_are_written_and_read() {
    let ladder = "[sweep]\nmesh = [8, 16, 32]\n";
    let studies = [
        of_kind("solve", ""),
        of_kind("convergence", ladder),
        of_kind("cost", &format!("{ladder}[cost]\nrepeat = 2\nthreads = 2\non = \"load\"\n")),
        of_kind("multiplicity", "[search]\nstarts = 5\nseed = 9\n"),
        read(UNIQUENESS),
        of_kind("sensitivity", SAMPLE),
    ];
    assert_eq!(studies.len(), Kind::ALL.len());
    let mut keys = std::collections::HashSet::new();
    for study in &studies {
        let job = study.point(study.len() - 1).unwrap().job;
        assert_eq!(Job::parse(&job.canonical()).unwrap(), job, "{}", study.kind().name());
        // A job that is timed stands among other meshes.
        let sweep =
            if matches!(job, Job::Cost { .. }) { "[sweep]\nmesh = [32, 64, 128]\n" } else { "" };
        let back = read(&format!("name = \"y\"\n{}{sweep}", job.to_toml()));
        assert_eq!(back.point(0).unwrap().job.canonical(), job.canonical());
        keys.insert(job.key());
    }
    assert_eq!(keys.len(), studies.len(), "what is asked of a scene is part of the identity");
}

#[test]
fn a_search_counts_neither_method_nor_effects() {
    let canonical = of_kind("multiplicity", "").point(0).unwrap().job.canonical();
    assert!(
        canonical.contains(r#""search":{"starts":60,"seed":0}"#)
            && canonical.contains(r#""method":"auto""#),
        "{canonical}"
    );
    assert!(!of_kind("multiplicity", "").columns().iter().any(|column| column.name == "method"));
}

#[test]
fn adaptive_studies() {
    let refine = of_kind("solve", "[refine]\non = \"load\"\nuntil = \"0.1%\"\n");
    assert_eq!(
        refine.adaptive(),
        Some(&Adaptive::Refine { on: "load".to_owned(), until: 1e-3, at_most: 1024 })
    );
    let finer = refine.point_on_mesh(0, Mesh::Across(32)).unwrap();
    assert_eq!(finer.job.mesh(), Mesh::Across(32));
    let bisect = of_kind(
        "solve",
        "[sweep]\nfriction.mu = [0.1, 0.5]\n[bisect]\naxis = \"mu\"\non = \"stick_area > 0\"\nto = 0.01\n",
    );
    let Some(Adaptive::Bisect { axis: 0, on, span, to: 0.01 }) = bisect.adaptive() else {
        panic!("{:?}", bisect.adaptive())
    };
    assert_eq!(
        (on.as_str(), &bisect.text()[span.clone()]),
        ("stick_area > 0", "\"stick_area > 0\"")
    );
    let axes = "[sweep]\nfriction.mu = [0.1, 0.5]\npunch.radius = [\"1 mm\", \"2 mm\"]\n";
    let find = of_kind(
        "solve",
        &format!(
            "{axes}[find]\naxis = \"radius\"\ncolumn = \"load\"\nvalue = \"2 kN\"\nto = 0.01\n"
        ),
    );
    let search = RootSearch { column: "load".to_owned(), value: 2000.0, axis: 1, to: 0.01 };
    assert_eq!(find.adaptive(), Some(&Adaptive::Find(search)));
    assert_eq!([0, 1].map(|group| find.is_sequence(group)), [false, true]);
    let figure = &find.figures()[0];
    assert_eq!(
        (&figure.x[..], &figure.y[..], &figure.series[..]),
        ("radius", &["load".to_owned()][..], &["mu".to_owned()][..])
    );
    let fill = of_kind(
        "solve",
        &format!(
            "{axes}[fill]\naxis = [\"friction.mu\", \"radius\"]\ncolumn = \"load\"\nat_most = 40\n"
        ),
    );
    let filling = Filling { column: "load".to_owned(), axes: vec![0, 1], to: None, at_most: 40 };
    assert_eq!(fill.adaptive(), Some(&Adaptive::Fill(filling)));
    assert_eq!([0, 1].map(|group| fill.is_sequence(group)), [true; 2]);
    let figure = &fill.figures()[0];
    assert_eq!((&figure.x[..], &figure.y[..]), ("mu", &["radius".to_owned()][..]));
    let moved = fill.point_at(0, &[(0, 0.25), (1, 0.0015)]).unwrap();
    assert_eq!(
        moved.values.iter().filter_map(|value| value.as_f64()).collect::<Vec<_>>(),
        [0.25, 0.0015]
    );
    let between = bisect.point_at(0, &[(0, 0.25)]).unwrap();
    assert_eq!(between.job.case().unwrap().scene.friction.mu, 0.25);
    assert_eq!(between.values[0].as_f64(), Some(0.25));
    assert_eq!(
        between.job.key(),
        of_kind("solve", "").point_at(0, &[(0, 0.25)]).map_or(between.key, |other| other.key)
    );
    assert!(bisect.point_at(0, &[(0, f64::NAN)]).is_none(), "no job");
}

#[test]
fn an_accuracy_stands_for_mesh_and_tolerance() {
    let with = |accuracy: &str, more: &str| {
        let scene = "[scene]\nfoundation.base = { shear_modulus = \"80 GPa\", poisson = 0.3 }\npunch = { shape = \"sphere\", radius = \"10 mm\" }";
        read(&format!("name = \"x\"\naccuracy = {accuracy}\n{scene}\nfriction.mu = 0.3\n{more}"))
    };
    let steps = "loading.steps = [{ approach = \"1 um\" }]\n";
    let study = with("\"0.1%\"", steps);
    let Some(Adaptive::Accuracy(accuracy)) = study.adaptive() else { panic!("chooses no mesh") };
    assert_eq!((accuracy.of, accuracy.is, accuracy.at_most), (None, 1e-3, 1024));
    let job = study.point(0).unwrap().job;
    assert_eq!(
        (job.mesh(), accuracy.of(&job), accuracy.tolerance(&job)),
        (Mesh::Across(8), "load", 1e-5)
    );
    let exact = |study: &Study| {
        let numerics = study
            .point_as_exact(0, Mesh::Across(24), 1e-5)
            .unwrap()
            .job
            .case()
            .unwrap()
            .numerics
            .clone();
        (numerics.mesh, numerics.tolerance)
    };
    assert_eq!(exact(&study), (Mesh::Across(24), 1e-5));
    // What the study gives stays.
    assert_eq!(
        exact(&with("0.001", &format!("{steps}[numerics]\ntolerance = 1e-9\n"))),
        (Mesh::Across(24), 1e-9)
    );

    // If the load is given, the approach is left. A path of many increments must be solved to less
    // in each.
    let path = "loading.steps = [{ normal_force = \"10 N\", increments = 50 }, { shift_x = \"10 nm\", increments = 50 }]\n";
    let study = with("{ is = 0.01, at_most = 64 }", path);
    let Some(Adaptive::Accuracy(accuracy)) = study.adaptive() else { panic!("chooses no mesh") };
    let job = study.point(0).unwrap().job;
    assert_eq!(
        (accuracy.of(&job), accuracy.tolerance(&job), accuracy.at_most),
        ("approach", 1e-6, 64)
    );
    let force = with("{ of = \"tangential_force\", is = 0.01 }", path);
    assert!(
        matches!(force.adaptive(), Some(Adaptive::Accuracy(accuracy)) if accuracy.of == Some("tangential_force"))
    );
}
