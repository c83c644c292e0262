//! What samples say, and how much each key moves a result.

use serde_json::Value;

use crate::place::Place;

/// Returns a study of what moves the pressure below a sphere; each point takes milliseconds.
fn study(table: &str, sample: &str) -> String {
    format!(
        r#"name = "moved"
question = "What moves the pressure?"
kind = "sensitivity"
[scene]
foundation.base = {{ shear_modulus = "80 GPa", poisson = 0.3 }}
punch = {{ shape = "sphere", radius = "50 mm" }}
friction.mu = 0
loading.steps = [{{ normal_force = "20 N" }}]
[numerics]
mesh = 8
[sensitivity]
of = "hertz_peak_pressure"
{table}
[sample]
{sample}
[sample.keys]
"loading.steps[0].normal_force" = {{ distribution = "log-uniform", from = "4 N", to = "40 N" }}
"punch.radius" = {{ distribution = "log-uniform", from = "30 mm", to = "60 mm" }}
"foundation.base.shear_modulus" = {{ distribution = "log-uniform", from = "40 GPa", to = "90 GPa" }}
"#
    )
}

fn sobol(count: usize) -> String {
    study("", &format!("method = \"sobol\"\ncount = {count}\nseed = 1"))
}

/// Returns the rows of a table of the answer.
fn rows(answer: &Value, title: &str) -> Vec<Value> {
    let rows = answer["answers"][title]["rows"].as_array();
    rows.unwrap_or_else(|| panic!("no {title}: {answer}")).clone()
}

fn number(row: &Value, name: &str) -> f64 {
    row[name].as_f64().unwrap_or_else(|| panic!("no {name}: {row}"))
}

/// Hertz's pressure grows as F^(1/3) E*^(2/3) R^(-2/3), and E* as the shear modulus. The output is a
/// product of independent factors: with their relative variances c the indices are c and
/// c Π/(1 + c) over Π − 1, where Π is the product of all 1 + c.
fn hertz() -> Vec<(&'static str, [f64; 2])> {
    let inputs = [
        ("normal_force", 1.0 / 3.0, 10.0_f64),
        ("radius", -2.0 / 3.0, 2.0),
        ("shear_modulus", 2.0 / 3.0, 2.25),
    ];
    let relative = inputs.map(|(_, exponent, ratio)| {
        let raw = |power: f64| (power * ratio.ln()).exp_m1() / (power * ratio.ln());
        raw(2.0 * exponent) / raw(exponent).powi(2) - 1.0
    });
    let product: f64 = relative.iter().map(|c| 1.0 + c).product();
    let index = |c: f64| [c / (product - 1.0), c * product / ((1.0 + c) * (product - 1.0))];
    inputs.iter().zip(relative).map(|((name, ..), c)| (*name, index(c))).collect()
}

#[test]
fn indices_are_those_of_the_closed_form_and_more_rows_keep_the_jobs() {
    let place = Place::with("moved.toml", sobol(64));
    let said = place.call("run moved.toml --workers 2 --json");
    assert_eq!(said.code, 0, "{}", said.err);
    let answer = place.json("answer moved --json");
    let found = rows(&answer, "sensitivity of hertz_peak_pressure");
    let names: Vec<&str> = found.iter().filter_map(|row| row["input"].as_str()).collect();
    assert_eq!(names, ["normal_force", "shear_modulus", "radius"], "the most influential first");
    for (name, [first, total]) in hertz() {
        let row = found.iter().find(|row| row["input"] == name).unwrap();
        // Of 64 rows, means of products are noisier than means of squared differences.
        for (index, expected, error) in [("S1", first, 0.1), ("ST", total, 0.05)] {
            let [low, high] = ["low", "high"].map(|end| number(row, &format!("{index}_{end}")));
            assert!(low <= expected && expected <= high, "{expected}: {row}");
            assert!((number(row, index) - expected).abs() < error, "{expected}: {row}");
        }
    }

    place.write("moved.toml", sobol(80));
    let plan = place.json("plan moved.toml --json");
    assert_eq!((&plan["cached"], &plan["to_run"]), (&(64 * 5).into(), &(16 * 5).into()));
    let other = "estimator = \"jansen\"";
    place.write("moved.toml", sobol(64).replace("[sample]\n", &format!("{other}\n[sample]\n")));
    let plan = place.json("plan moved.toml --json");
    assert_eq!(plan["to_run"], 0, "another estimator takes no other points");
    assert_eq!(place.call("run moved.toml").code, 0);
    let jansen = place.json("answer moved --json");
    let others = rows(&jansen, "sensitivity of hertz_peak_pressure");
    assert_ne!(others[0]["S1"], found[0]["S1"]);
    assert_eq!(others[0]["ST"], found[0]["ST"], "both are by squared differences");
}

/// A power law of logarithms that move in steps has effects of one sign.
#[test]
fn trajectories_rank_the_keys_and_know_the_direction() {
    let text = study("method = \"morris\"", "method = \"random\"\ncount = 6");
    let place = Place::with("moved.toml", text);
    assert_eq!(place.call("run moved.toml --workers 2").code, 0);
    let answer = place.json("answer moved --json");
    let found = rows(&answer, "sensitivity of hertz_peak_pressure");
    let names: Vec<&str> = found.iter().filter_map(|row| row["input"].as_str()).collect();
    assert_eq!(names, ["normal_force", "shear_modulus", "radius"]);
    for row in &found {
        let (mean, absolute) = (number(row, "mu"), number(row, "mu_star"));
        let sign = if row["input"] == "radius" { -1.0 } else { 1.0 };
        assert!(
            (sign * mean / absolute - 1.0).abs() < 1e-12 && number(row, "sigma") > 0.0,
            "{row}"
        );
    }
}

#[test]
fn a_study_of_sensitivity_from_plan_to_figure() {
    let place = Place::with("moved.toml", sobol(8));
    assert_eq!(place.call("run moved.toml --workers 2").code, 0);
    let said = place.transcript(&[
        &["answer", "moved"],
        &["answer", "moved", "--column", "contact_radius,poisson"],
        &["answer", "moved", "--column", "status"],
        &["answer", "moved", "--column", "peak_presure"],
        &["plot", "moved", "--y", "peak_pressure", "--output", "one.svg"],
        &["plot", "moved", "--y", "peak_pressure", "--series", "mu"],
        &["plot", "moved", "--where", "load > 0"],
        &["plot", "moved", "--x", "radius", "--y", "peak_pressure", "--output", "points.svg"],
    ]);
    insta::assert_snapshot!(said);
    let cited = place.call("cite moved").out;
    assert!(["Efron", "Saltelli", "Jansen"].iter().all(|name| cited.contains(name)), "{cited}");
    assert!(place.call("answer moved --column seconds").code == 0, "any number can be asked for");
    let svg = std::fs::read_to_string(place.path("one.svg")).unwrap();
    assert!(svg.contains(">first order<") && svg.contains(">peak pressure<"), "{svg}");
    assert!(place.path("points.svg").is_file());
    let page = place.call("report moved");
    assert_eq!(page.code, 0, "{}", page.err);
    let page = std::fs::read_to_string(place.path("moved.html")).unwrap();
    assert!(page.contains("share of the variance") && !page.contains("is missing:"));
}

/// A sphere carries 300 N by friction at most: beyond, it slides, and the point fails.
const PULLED: &str = r#"name = "pulled"
question = "How much does a drawn force leave sticking?"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "50 mm" }
friction.mu = 0.3
loading.steps = [{ normal_force = "1 kN" }, { force_x = "100 N" }]
[numerics]
mesh = 8
[sample]
method = "random"
count = 40
seed = 2
[sample.keys]
"loading.steps[1].force_x" = { from = "0 N", to = "350 N" }
"friction.mu" = { from = 0.3, to = 0.32 }
"#;

#[test]
fn a_sample_is_described_and_its_failures_are_counted() {
    let place = Place::with("pulled.toml", PULLED);
    assert_eq!(place.call("run pulled.toml --workers 2").code, 2);
    let said = place.transcript(&[
        &["answer", "pulled", "--column", "stick_fraction"],
        &["answer", "pulled", "--column", "mu"],
    ]);
    insta::assert_snapshot!(said);
    let answer = place.json("answer pulled --column stick_fraction --json");
    let described = rows(&answer, "statistics of stick_fraction");
    let query = "query pulled --select stick_fraction --where status=='certified' --format csv";
    let mut numbers: Vec<f64> =
        place.call(query).out.lines().skip(1).map(|line| line.parse().unwrap()).collect();
    numbers.sort_by(f64::total_cmp);
    let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
    let row = |name: &str| described.iter().find(|row| row["statistic"] == name).unwrap();
    assert!((number(row("mean"), "value") - mean).abs() < 1e-12);
    assert_eq!(number(row("largest"), "value"), *numbers.last().unwrap());
    assert_eq!(row("mean")["points"], numbers.len());
    assert!(number(row("mean"), "low") < mean && mean < number(row("mean"), "high"));
    // Without columns it is those of the figure.
    assert!(place.json("answer pulled --json")["answers"].as_object().unwrap().len() >= 3);
}

#[test]
fn failures_are_counted_at_each_combination_of_the_axes() {
    let text = PULLED
        .replace("[sample]\n", "[sweep]\n\"foundation.base.poisson\" = [0.2, 0.3]\n[sample]\n")
        .replace(", poisson = 0.3", "")
        .replace("count = 40", "count = 12");
    let place = Place::with("pulled.toml", text);
    assert_eq!(place.call("run pulled.toml --workers 2").code, 2);
    let answer = place.json("answer pulled --column stick_fraction --json");
    let failed = rows(&answer, "failed");
    let described = rows(&answer, "statistics of stick_fraction");
    assert_eq!(failed.len(), 2, "{answer}");
    for (said, poisson) in failed.iter().zip([0.2, 0.3]) {
        let said = said["answer"].as_str().unwrap();
        assert!(said.starts_with(&format!("the scene with poisson = {poisson}: ")), "{said}");
        let row = described.iter().find(|row| row["poisson"] == poisson).unwrap();
        assert_eq!(number(row, "points") + number(row, "missing"), 12.0);
        let missing = number(row, "missing");
        assert!(
            missing > 0.0 && said.contains(&format!(": {missing} of 12 points failed")),
            "{said}"
        );
    }
}

/// A row with a point that failed says nothing, and is counted.
#[test]
fn rows_with_a_point_that_failed_are_left_out() {
    let text = PULLED
        .replace("[sample]\n", "[sensitivity]\nof = \"stick_fraction\"\n[sample]\n")
        .replace("name = \"pulled\"\n", "name = \"pulled\"\nkind = \"sensitivity\"\n")
        .replace("count = 40", "count = 12");
    let place = Place::with("pulled.toml", text);
    assert_eq!(place.call("run pulled.toml --workers 2").code, 2);
    let answer = place.json("answer pulled --json");
    let words = rows(&answer, "rows of stick_fraction")[0]["answer"].as_str().unwrap().to_owned();
    let said = place.call("query pulled --select status --format csv").out;
    let ends: Vec<&str> = said.lines().skip(1).collect();
    assert_eq!(ends.len(), 12 * 4);
    let failed = ends.chunks(4).filter(|row| row.contains(&"failed")).count();
    assert!((1..12).contains(&failed), "{failed}");
    let start = format!(
        "{} of 12 rows count for stick_fraction; {failed} with a point that failed or has no \
         stick_fraction are left out; ",
        12 - failed
    );
    assert!(words.starts_with(&start), "{words}");
}

#[test]
fn columns_of_a_study_without_a_sample_are_not_described() {
    let place = Place::run();
    let said = place.call("answer small --column load");
    assert_eq!(said.code, 1);
    insta::assert_snapshot!(said.err);
}

#[test]
fn each_combination_of_the_axes_has_a_design_of_its_own() {
    let sweep = "[sweep]\n\"friction.mu\" = [0, 0.3]\n[sample]\n";
    let text = sobol(8).replace("[sample]\n", sweep).replace("friction.mu = 0\n", "");
    let place = Place::with("moved.toml", text);
    // Half of the study: the second design is not complete.
    assert_eq!(place.call("run moved.toml --shard 1/2 --workers 2").code, 0);
    let answer = place.json("answer moved --json");
    let words = rows(&answer, "rows of hertz_peak_pressure")[0]["answer"].to_string();
    assert!(words.contains("are not complete yet"), "{words}");

    assert_eq!(place.call("run moved.toml --workers 2").code, 0);
    let answer = place.json("answer moved --json");
    let found = rows(&answer, "sensitivity of hertz_peak_pressure");
    let at = |mu: f64| -> Vec<Value> {
        found.iter().filter(|row| number(row, "mu") == mu).cloned().collect()
    };
    assert_eq!((at(0.0).len(), at(0.3).len()), (3, 3));
    // Hertz's theory knows no friction.
    assert_eq!(number(&at(0.0)[0], "ST"), number(&at(0.3)[0], "ST"));
    assert_eq!(place.call("plot moved --output moved.svg").code, 0);
    let svg = std::fs::read_to_string(place.path("moved.svg")).unwrap();
    assert!(svg.contains("mu = 0.3<") && svg.contains("mu = 0<"), "{svg}");
}

#[test]
fn a_sample_without_failures_says_how_many_there_might_be() {
    let text = sobol(8)
        .replace("kind = \"sensitivity\"\n", "")
        .replace("[sensitivity]\nof = \"hertz_peak_pressure\"\n", "");
    let place = Place::with("moved.toml", text);
    assert_eq!(place.call("run moved.toml --workers 2").code, 0);
    let said = place.call("answer moved").out;
    let words = "no point of 8 failed; with 95 % confidence fewer than 32 % do\n";
    assert!(said.contains(words) && said.contains("statistics of "), "{said}");
}
