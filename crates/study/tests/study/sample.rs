//! Samples: what they draw, and what is refused of them.

use study::{NamedFile, Study, Value};

/// A good sample; every case below spoils it in one way.
const GOOD: &str = r#"name = "drawn"
[scene.foundation]
base = { shear_modulus = "80 GPa", poisson = 0.3 }
[scene.punch]
shape = "sphere"
radius = "10 mm"
[scene.friction]
mu = 0.3
[scene.loading]
steps = [{ approach = "1 um" }]

[numerics]
mesh = 16

[sample]
method = "sobol"
count = 8
seed = 3

[sample.keys]
"friction.mu" = { from = 0.1, to = 0.5 }
"punch.radius" = { distribution = "normal", mean = "10 mm", deviation = "0.5 mm" }
"foundation.base.shear_modulus" = { distribution = "log-uniform", from = "8 GPa", to = "80 GPa" }
"#;

const METHOD: &str = "method = \"sobol\"";
const KEYS: &str = "[sample.keys]\n";
const MU: &str = "{ from = 0.1, to = 0.5 }";
const NORMAL: &str = "{ distribution = \"normal\", mean = \"10 mm\", deviation = \"0.5 mm\" }";
const LOG: &str = "{ distribution = \"log-uniform\", from = \"8 GPa\", to = \"80 GPa\" }";

/// The name of each case, the text that is replaced, and its replacement.
const CASES: &[(&str, &str, &str)] = &[
    ("no method", METHOD, ""),
    ("unknown method", METHOD, "method = \"sobool\""),
    ("method by another name", METHOD, "method = \"LHS\""),
    ("method is a number", METHOD, "method = 3"),
    ("no count", "count = 8\n", ""),
    ("no points", "count = 8", "count = 0"),
    ("negative count", "count = 8", "count = -8"),
    ("count is a fraction", "count = 8", "count = 8.5"),
    ("too many points", "count = 8", "count = 300000"),
    ("seed is a text", "seed = 3", "seed = \"x\""),
    ("unknown key of the table", "seed = 3", "sed = 3"),
    ("keys beside the table", "seed = 3", "seed = 3\n\"friction.mu\" = { from = 0, to = 1 }"),
    ("unknown key to draw", "friction.mu", "friction.nu"),
    ("whole table", "\"friction.mu\"", "\"foundation.base\""),
    (
        "a shape",
        "\"friction.mu\" = { from = 0.1, to = 0.5 }",
        "\"punch.shape\" = { values = [\"sphere\"] }",
    ),
    ("a list of values", MU, "[0.1, 0.5]"),
    ("a single value", MU, "0.3"),
    ("a range of a sweep", MU, "{ from = 0.1, to = 0.5, count = 3 }"),
    ("no end", MU, "{ from = 0.1 }"),
    ("backwards", MU, "{ from = 0.5, to = 0.1 }"),
    ("nothing between", MU, "{ from = 0.5, to = 0.5 }"),
    ("wrong unit", MU, "{ from = \"1 mm\", to = 0.5 }"),
    ("below zero", MU, "{ from = -0.1, to = 0.5 }"),
    ("unknown distribution", MU, "{ distribution = \"gumbel\", from = 0.1, to = 0.5 }"),
    (
        "distribution by another name",
        MU,
        "{ distribution = \"gaussian\", mean = 1, deviation = 0.1 }",
    ),
    (
        "truncated by its name",
        MU,
        "{ distribution = \"truncated-normal\", mean = 0.3, deviation = 0.1, from = 0 }",
    ),
    ("no name of the distribution", MU, "{ mean = 0.3, deviation = 0.1 }"),
    ("normal without mean", NORMAL, "{ distribution = \"normal\", deviation = \"1 mm\" }"),
    ("no deviation", NORMAL, "{ distribution = \"normal\", mean = \"10 mm\", deviation = 0 }"),
    (
        "normal below zero",
        NORMAL,
        "{ distribution = \"normal\", mean = \"10 mm\", deviation = \"2 mm\" }",
    ),
    (
        "bounds backwards",
        NORMAL,
        "{ distribution = \"normal\", mean = 0.01, deviation = 0.001, from = 2, to = 1 }",
    ),
    (
        "bounds in the furthest tail",
        NORMAL,
        "{ distribution = \"normal\", mean = 0.01, deviation = 1e-6, from = 1 }",
    ),
    (
        "deviation without unit",
        NORMAL,
        "{ distribution = \"normal\", mean = \"10 mm\", deviation = \"1\" }",
    ),
    ("log-uniform from zero", LOG, "{ distribution = \"log-uniform\", from = 0, to = 1e9 }"),
    ("log-normal by both", LOG, "{ distribution = \"log-normal\", median = 1e9, deviation = 1e8 }"),
    (
        "log-normal of a negative median",
        LOG,
        "{ distribution = \"log-normal\", median = -1, log_deviation = 0.1 }",
    ),
    (
        "log-normal too wide",
        LOG,
        "{ distribution = \"log-normal\", median = 1e9, log_deviation = 100 }",
    ),
    ("mode beyond the ends", MU, "{ distribution = \"triangular\", from = 0, mode = 2, to = 1 }"),
    ("triangle without mode", MU, "{ distribution = \"triangular\", from = 0, to = 1 }"),
    ("no values", MU, "{ values = [] }"),
    ("a value twice", MU, "{ values = [0.1, 0.1] }"),
    ("weights for other values", MU, "{ values = [0.1, 0.2], weights = [1, 2, 3] }"),
    ("a weight of nothing", MU, "{ values = [0.1, 0.2], weights = [1, 0] }"),
    ("measured without a column", MU, "{ file = \"mu.csv\" }"),
    ("measured in no file", MU, "{ file = \"none.csv\", column = \"mu\" }"),
    ("measured in no such column", MU, "{ file = \"mu.csv\", column = \"nu\" }"),
    ("measured in another unit", NORMAL, "{ file = \"mu.csv\", column = \"E\" }"),
    ("measured words", MU, "{ file = \"mu.csv\", column = \"name\" }"),
    (
        "measured meshes",
        "\"friction.mu\" = { from = 0.1, to = 0.5 }",
        "mesh = { file = \"mu.csv\", column = \"mu\" }",
    ),
    ("a range of meshes", "\"friction.mu\" = { from", "mesh = { from"),
    ("no keys", KEYS, "[sample.others]\n"),
    ("swept as well", "[sample]\n", "[sweep]\n\"friction.mu\" = [0.1, 0.2]\n[sample]\n"),
    (
        "unknown kind of figure",
        "[sample]\n",
        "[figure]\nkind = \"histogramm\"\nx = \"load\"\n[sample]\n",
    ),
    (
        "histogram with y",
        "[sample]\n",
        "[figure]\nkind = \"histogram\"\nx = \"load\"\ny = \"mu\"\n[sample]\n",
    ),
    ("scatter with bins", "[sample]\n", "[figure]\nx = \"load\"\ny = \"mu\"\nbins = 3\n[sample]\n"),
    ("no bins", "[sample]\n", "[figure]\nkind = \"histogram\"\nx = \"load\"\nbins = 0\n[sample]\n"),
    ("modulus twice", "friction.mu", "foundation.base.youngs_modulus"),
    (
        "bisect what is drawn",
        "[sample]\n",
        "[bisect]\naxis = \"mu\"\non = \"stick_area > 0\"\nto = \"1%\"\n[sample]\n",
    ),
    ("a sample in the scene", "mesh = 16", "mesh = 16\nsample = 3"),
];

fn read(text: &str) -> Result<Study, study::StudyError> {
    Study::parse(text, "study.toml", &mut |name| match name {
        "mu.csv" => {
            let bytes = b"name,mu,E [GPa]\na,0.2,200\nb,0.3,210\n".to_vec();
            Ok(NamedFile { bytes, may_quote: true })
        }
        _ => Err("there is no such file".to_owned()),
    })
}

fn good(text: &str) -> Study {
    read(text).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn every_refusal_of_a_sample_is_clear() {
    let mut said = String::new();
    for (name, old, new) in CASES {
        assert!(GOOD.contains(old), "{name}");
        match read(&GOOD.replacen(old, new, 1)) {
            Ok(_) => panic!("{name}: was not refused"),
            Err(error) => said.push_str(&format!("## {name}\n{error}\n\n")),
        }
    }
    insta::assert_snapshot!(said);
}

#[test]
fn points_are_drawn_from_their_distributions() {
    let study = good(GOOD);
    assert_eq!(study.len(), 8);
    let numbers = |index: usize| -> Vec<f64> {
        study.point(index).unwrap().values.iter().filter_map(Value::as_f64).collect()
    };
    let mut halves = [[0; 2]; 3];
    for index in 0..8 {
        let [mu, radius, modulus] = numbers(index)[..] else { panic!("{index}") };
        assert!((0.1..0.5).contains(&mu) && (8e9..80e9).contains(&modulus), "{mu} {modulus}");
        assert!((0.008..0.012).contains(&radius), "{radius}");
        // Four points of eight lie on each side of each median.
        for (axis, is_upper) in
            [mu > 0.3, radius > 0.01, modulus > 640e18_f64.sqrt()].into_iter().enumerate()
        {
            halves[axis][usize::from(is_upper)] += 1;
        }
    }
    assert_eq!(halves, [[4; 2]; 3]);
    // The job has what the axes show.
    let point = study.point(5).unwrap();
    let case = point.job.case().unwrap();
    assert_eq!(Value::Number(case.scene.friction.mu), point.values[0]);
}

/// Keys follow from drawn ones, and conditions look at both.
#[test]
fn conditions_and_formulas_know_what_is_drawn() {
    let text = r#"
name = "x"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere" }
loading.steps = [{}]
[numerics]
mesh = 8
[sample]
method = "sobol"
count = 64
[sample.keys]
friction.mu = { from = 0.1, to = 0.5 }
punch.radius = { values = ["1 mm", "9 mm"] }
[derive]
"loading.steps[0].approach" = "1e-3 * punch.radius"
[[exclude]]
when = "radius == 0.001 && mu > 0.3"
[[exclude]]
when = "approach > 2e-6 && mu < 0.2"
"#;
    let study = good(text);
    let columns = study.columns();
    let approach = study::columns::find(&columns, "approach").unwrap();
    let (mut small, mut large) = (0, 0);
    for point in study.points() {
        let [Value::Number(mu), Value::Number(radius)] = point.values[..] else { panic!() };
        let is_small = radius == 1e-3;
        assert!(if is_small { mu <= 0.3 } else { mu >= 0.2 }, "{radius}: {mu}");
        let expected = if is_small { 1e-6 } else { 9e-6 };
        assert_eq!(approach.value(&point, None), Value::Number(expected));
        small += usize::from(is_small);
        large += usize::from(!is_small);
    }
    // Half of the range of μ is left to the small spheres, and three quarters to the large ones.
    assert!((14..=18).contains(&small) && (22..=26).contains(&large), "{small}, {large}");
    assert_eq!(study.excluded(), 64 - small - large);

    let derived = text.replace("[derive]\n", "[derive]\n\"friction.mu\" = \"0.2\"\n");
    let said = read(&derived).unwrap_err().to_string();
    assert!(said.contains("`friction.mu` is set by an axis, and derived as well"), "{said}");
    let whole = text.replace("name = \"x\"", "name = \"x\"\nkind = \"sensitivity\"");
    let said = read(&whole).unwrap_err().to_string();
    assert!(said.contains("a study of sensitivity needs every point of its design"), "{said}");
}

#[test]
fn raising_the_count_keeps_every_job() {
    let keys = |method: &str, count: usize| -> Vec<String> {
        let text = GOOD.replace("sobol", method).replace("count = 8", &format!("count = {count}"));
        good(&text).points().iter().map(|point| point.key.to_string()).collect()
    };
    for method in ["sobol", "halton", "random"] {
        let (few, many) = (keys(method, 8), keys(method, 11));
        assert_eq!(few[..], many[..8], "{method}");
    }
    let (few, many) = (keys("latin-hypercube", 6), keys("latin-hypercube", 12));
    assert_eq!(few[..], many[..6]);
    assert!(!keys("latin-hypercube", 7).contains(&few[0]));
}

#[test]
fn a_sample_beside_axes_is_the_same_for_each_combination() {
    let axes = "[sweep]\nmesh = [8, 16]\ntolerance = [1e-6, 1e-8, 1e-9]\n[sample]\n";
    let study = good(&GOOD.replace("[sample]\n", axes));
    assert_eq!((study.len(), study.groups().len()), (48, 3));
    let drawn = |index: usize| study.point(index).unwrap().values[2..].to_vec();
    assert!((0..48).all(|index| drawn(index) == drawn(index % 8)));
    // The order of the text and the spelling of keys count for nothing but columns.
    let dotted = GOOD.replace("\"friction.mu\" =", "friction.mu =");
    assert_eq!(good(&dotted).point(3).unwrap().key, good(GOOD).point(3).unwrap().key);
}

#[test]
fn discrete_values_come_by_their_weights() {
    let text = GOOD
        .replace(
            "\"friction.mu\" = { from = 0.1, to = 0.5 }",
            "mesh = { values = [8, [16, 8], 32], weights = [1, 2, 1] }",
        )
        .replace("count = 8", "count = 64");
    let study = good(&text);
    let shown: Vec<String> =
        study.points().iter().map(|point| point.values[0].to_string()).collect();
    let count = |name: &str| shown.iter().filter(|shown| *shown == name).count();
    assert_eq!([count("8"), count("16x8"), count("32")], [16, 32, 16]);
}

#[test]
fn points_can_be_made_of_parts() {
    let axes = "[sweep]\nmesh = [8, 16]\n[sample]\n";
    let study = good(&GOOD.replace("[sample]\n", axes));
    let point = study.point_drawn(9, &[0.25, 0.5, 0.5]).unwrap();
    let values: Vec<String> = point.values.iter().map(ToString::to_string).collect();
    assert_eq!(values[..3], ["16", "0.2", "0.01"]);
    assert_eq!(point.key, point.job.key());
    let sample = study.sample().unwrap();
    let design = sample.design().unwrap();
    let parts: Vec<f64> = (0..3).map(|dimension| design.coordinate(1, dimension)).collect();
    assert_eq!(study.point_drawn(9, &parts), study.point(9));
}

/// What follows from a drawn key follows from the part that stands in its place.
#[test]
fn keys_are_derived_from_the_parts_of_a_point() {
    let text = GOOD.replace("[{ approach = \"1 um\" }]", "[{}]");
    let text = format!("{text}[derive]\n\"loading.steps[0].approach\" = \"mu * 10 um\"\n");
    let study = good(&text);
    let columns = study.columns();
    let approach = study::columns::find(&columns, "approach").unwrap();
    let drawn = study.point_drawn(0, &[0.75, 0.5, 0.5]).unwrap();
    assert_eq!(approach.value(&drawn, None), Value::Number(4e-6));
}

/// The ends of a distribution are held against what follows from them, at points that the
/// conditions keep.
#[test]
fn the_ends_of_distributions_are_held_against_the_points_that_are_kept() {
    let wide = |text: &str, addition: &str| {
        let mu = "{ distribution = \"normal\", mean = 0.5, deviation = 0.05 }";
        read(&format!("{}{addition}", text.replace(MU, mu)))
    };
    let said = wide(GOOD, "[derive]\ntolerance = \"mu - 0.2\"\n").unwrap_err().to_string();
    assert!(said.contains("`friction.mu` may be drawn as small as 0.0895"), "{said}");
    let derived = "[[exclude]]\nwhen = \"mu < 0.3\"\n[derive]\ntolerance = \"mu - 0.2\"\n";
    assert!(wide(GOOD, derived).is_ok());

    // A radius below 0 is none, unless it is left out.
    let radius = |addition: &str| {
        read(&format!(
            "{}{addition}",
            GOOD.replace("deviation = \"0.5 mm\"", "deviation = \"2 mm\"")
        ))
    };
    assert!(radius("").is_err());
    assert!(radius("[[exclude]]\nwhen = \"radius <= 0\"\n").is_ok());

    // The first value of the axis makes no sense, and is left out.
    let axis =
        "[[exclude]]\nwhen = \"poisson > 0.5\"\n[sweep]\nfoundation.base.poisson = [0.9, 0.3]\n";
    assert!(read(&format!("{GOOD}{axis}")).is_ok());
    assert!(radius(axis).unwrap_err().to_string().contains("drawn as small as"));
}

#[test]
fn a_million_points_are_no_list() {
    let text = GOOD.replace("count = 8", "count = 1000000");
    let files = &mut |_: &str| Err(String::new());
    let study = Study::parse_sharded(&text, "study.toml", files).unwrap();
    assert!(!study.is_listed());
    assert_eq!(study.point(7).unwrap().key, good(GOOD).point(7).unwrap().key);
    let part = study.restricted(vec![999_999, 3]).unwrap();
    assert_eq!(part.points().len(), 2);
}

/// The values of all keys together are as many as those of the axes of a sweep may be.
#[test]
fn keys_share_a_bound_of_values_and_a_file_that_is_read_once() {
    let lines: String = (1..=120_000).map(|n| format!("{n}e-6\n")).collect();
    let text = |keys: &str| {
        let (before, _) = GOOD.split_once("[sample.keys]\n").unwrap();
        format!("{before}[sample.keys]\n{keys}")
    };
    let read = |keys: &str| {
        let bytes = format!("mu\n{lines}").into_bytes();
        let mut files = |_: &str| Ok(NamedFile { bytes: bytes.clone(), may_quote: true });
        Study::parse(&text(keys), "study.toml", &mut files)
    };
    let measured = "{ file = \"mu.csv\", column = \"mu\" }\n";
    let mu = format!("friction.mu = {measured}");
    assert!(read(&mu).is_ok());
    let both = format!("{mu}foundation.base.poisson = {measured}epsilon = {measured}");
    let said = read(&both).unwrap_err().to_string();
    assert!(said.contains("the sample draws from 240000 values up to here"), "{said}");
    assert_eq!(said.matches("error").count(), 1, "{said}");
}
