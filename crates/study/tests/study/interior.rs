//! Stresses below the surface, in a study file: what `[interior]` becomes, what a job writes, and
//! what is refused.

use contact::model::InteriorQuestion;
use study::{Job, NamedFile, Study, StudyError, Value, columns};

fn no_files(name: &str) -> Result<NamedFile, String> {
    Err(format!("{name}: no such file"))
}

/// Returns a study of a sphere on a coated base with these further lines; the base is rigid at a
/// depth of 2 mm.
fn text(more: &str) -> String {
    // Keys of the top stand before the tables.
    let (top, tables) = match more.split_once("\n[") {
        _ if more.starts_with('[') => ("", more.to_owned()),
        Some((top, tables)) => (top, format!("[{tables}")),
        None => (more, String::new()),
    };
    format!(
        "name = \"below\"\n{top}\n[scene]\nfoundation = {{ layers = [{{ youngs_modulus = \"210 GPa\", \
         poisson = 0.3, thickness = \"2 mm\" }}], base = \"rigid\" }}\npunch = {{ shape = \
         \"sphere\", radius = \"50 mm\" }}\nloading.steps = [{{ approach = \"20 um\" }}]\n\
         [numerics]\nmesh = 16\n{tables}\n"
    )
}

fn read(text: &str) -> Result<Study, StudyError> {
    Study::parse(text, "study.toml", &mut no_files)
}

/// Returns what the points of a study ask.
fn asked(more: &str) -> Vec<Option<InteriorQuestion>> {
    let study = read(&text(more)).unwrap_or_else(|error| panic!("{error}"));
    let question = |job: &Job| job.case().unwrap().scene.interior.clone();
    study.points().iter().map(|point| question(&point.job)).collect()
}

#[test]
fn the_table_makes_the_question() {
    assert_eq!(asked(""), [None]);
    assert_eq!(asked("interior.maximum = false"), [None]);
    let sought = InteriorQuestion { maximum: true, ..InteriorQuestion::default() };
    assert_eq!(asked("[interior]\nmaximum = true"), [Some(sought)]);
    let whole = "[interior]\nmaximum = true\ndepths = [\"0.1 mm\", 0.0002]\npoints = [[0, \
                 \"-1 um\", \"0.1 mm\"], [0, 0, 0]]";
    let question = InteriorQuestion {
        maximum: true,
        depths: vec![1e-4, 2e-4],
        points: vec![[0.0, -1e-6, 1e-4], [0.0; 3]],
    };
    assert_eq!(asked(whole), [Some(question)]);
}

#[test]
fn a_depth_is_an_axis_and_a_column() {
    let more =
        "[sweep]\ninterior.depth = { from = \"0.1 mm\", to = \"1 mm\", count = 3, log = true }";
    let study = read(&text(more)).unwrap_or_else(|error| panic!("{error}"));
    let columns = study.columns();
    let column = columns::find(&columns, "interior_depth").expect("a column of the axis");
    assert_eq!((column.unit(), study.points().len()), ("m", 3));
    let depths: Vec<Value> = study.points().iter().map(|point| column.value(point, None)).collect();
    assert_eq!(depths[0], Value::Number(1e-4));
    assert_eq!(depths[2], Value::Number(1e-3));
    assert!(columns::find(&columns, "von_mises_max").is_some());
    assert_eq!(study.figures()[0].y, ["plane_von_mises"], "nothing else varies with the depth");
}

/// A job is written as it is asked for, and a list of one depth has its column.
#[test]
fn a_list_of_one_depth_is_written_and_shown() {
    for (more, column) in [
        ("interior.depths = [\"0.1 mm\"]", "interior_depths"),
        ("interior.depth = \"0.1 mm\"", "interior_depth"),
        ("interior.depths = [\"0.1 mm\", \"0.2 mm\"]", "interior_depths"),
    ] {
        let study = read(&text(more)).unwrap_or_else(|error| panic!("{error}"));
        let point = &study.points()[0];
        let columns = study.columns();
        let found = columns::find(&columns, column).unwrap_or_else(|| panic!("no {column}"));
        assert_ne!(found.value(point, None), Value::Missing, "{more}");
        let written = point.job.to_toml();
        let again = read(&format!("name = \"again\"\n{written}"));
        let again = again.unwrap_or_else(|error| panic!("{error}\n{written}"));
        assert_eq!(again.points()[0].job.key(), point.job.key(), "{written}");
    }
}

/// Planes and points of all jobs count like layers and steps: each is stored for each job.
#[test]
fn too_many_points_in_all_are_refused() {
    let points: Vec<String> = (0..1000).map(|i| format!("[0, 0, {i}e-6]")).collect();
    let more = format!(
        "interior.points = [{}]\n[sweep]\nfriction.mu = {{ from = 0, to = 1, count = 2001 }}",
        points.join(", ")
    );
    let said = read(&text(&more)).expect_err("two million points").to_string();
    assert!(said.contains("2001 points with up to 1002 load steps, layers, and planes"), "{said}");
}

/// Keys of jobs that ask for nothing are those of before, and those that ask have others.
#[test]
fn a_question_is_part_of_the_job() {
    let key = |more: &str| read(&text(more)).unwrap().points()[0].job.key();
    let canonical = |more: &str| read(&text(more)).unwrap().points()[0].job.canonical();
    assert!(!canonical("").contains("interior"));
    assert_ne!(key(""), key("interior.maximum = true"));
    assert_ne!(key("interior.depth = 1e-4"), key("interior.depth = 2e-4"));
    assert_eq!(key("interior.depth = 1e-4"), key("interior.depths = [1e-4]"));
    assert!(canonical("interior.depth = 1e-4").contains(r#""interior":{"depths":[0.0001]}"#));
    // What is named twice, or in another order, asks for the same.
    assert_eq!(key("interior.depths = [1e-4, 2e-4]"), key("interior.depths = [2e-4, 1e-4, 2e-4]"));
    let points = "interior.points = [[1e-4, 0, 0], [0, 0, 1e-4]";
    assert_eq!(key(&format!("{points}]")), key(&format!("{points}, [1e-4, -0.0, 0]]")));
}

#[test]
fn questions_without_meaning_are_refused() {
    let mut said = String::new();
    for (name, more) in [
        ("nothing", "[interior]"),
        ("a depth above the surface", "interior.depth = \"-0.1 mm\""),
        ("a depth in the rigid base", "interior.depth = \"2.1 mm\""),
        ("one of several depths in the rigid base", "interior.depths = [\"0.1 mm\", \"3 mm\"]"),
        ("a depth in another unit", "interior.depth = \"1 N\""),
        ("a depth without a unit", "interior.depth = \"0.1\""),
        ("a list as one depth", "interior.depth = [\"0.1 mm\"]"),
        ("one depth as a list", "interior.depths = \"0.1 mm\""),
        ("a word among depths", "interior.depths = [\"0.1 mm\", \"deep\"]"),
        ("too many depths", &format!("interior.depths = [{}]", "1e-4, ".repeat(65))),
        ("depth and depths", "interior = { depth = \"0.1 mm\", depths = [\"0.2 mm\"] }"),
        ("a point of two coordinates", "interior.points = [[0, \"0.1 mm\"]]"),
        ("a point that is no list", "interior.points = [\"0.1 mm\"]"),
        ("a point above the surface", "interior.points = [[0, 0, \"-1 um\"]]"),
        ("a point that is infinite", "interior.points = [[0, inf, \"1 um\"]]"),
        ("a word for a switch", "interior.maximum = \"yes\""),
        ("a misspelt key", "interior.depht = \"0.1 mm\""),
        ("a question in the scene", "[scene.interior]\nmaximum = true"),
        ("a question in a search", "interior.maximum = true\n[search]\nstarts = 3"),
    ] {
        let kind = if name.ends_with("search") { "kind = \"multiplicity\"\n" } else { "" };
        said +=
            &format!("## {name}\n{}\n", read(&(kind.to_owned() + &text(more))).expect_err(name));
    }
    insta::assert_snapshot!(said);
}
