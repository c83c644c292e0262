//! `report`: the page that it writes, from every form of a store, and what it refuses.

use std::fs;

use serde_json::{Value, json};

use super::kinds::HERTZ;
use crate::place::{Place, SMALL};

/// Returns the page with a name.
fn page(place: &Place, file: &str) -> String {
    fs::read_to_string(place.path(file)).unwrap()
}

/// Returns the data that the script of a page reads.
fn data(html: &str) -> Value {
    let (_, rest) = html.split_once("<script type=\"application/json\" id=\"data\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

/// Rounds every number to four digits.
fn rounded(value: &Value) -> Value {
    match value {
        Value::Number(x) if x.is_f64() => {
            let x = x.as_f64().unwrap();
            json!(format!("{x:.3e}").parse::<f64>().unwrap())
        }
        Value::Array(list) => list.iter().map(rounded).collect(),
        other => other.clone(),
    }
}

/// Returns the rows of a page, of the columns that are shown.
fn shown_rows(data: &Value) -> Vec<Vec<Value>> {
    let columns = data["jobs"]["columns"].as_array().unwrap();
    let shown: Vec<&Value> = columns.iter().filter(|column| column["shown"] == true).collect();
    let rows = data["jobs"]["rows"].as_array().unwrap();
    let cell = |row: &Value, column: &Value| match column["slot"].as_u64() {
        Some(slot) => rounded(&row[slot as usize]),
        None => rounded(&column["same"]),
    };
    rows.iter().map(|row| shown.iter().map(|column| cell(row, column)).collect()).collect()
}

#[test]
fn the_data_of_a_page() {
    let place = Place::run();
    assert_eq!(place.call("report small").transcript(), "small.html\n= 0\n");
    let data = data(&page(&place, "small.html"));
    let columns = data["jobs"]["columns"].as_array().unwrap();
    let column = |column: &Value| {
        let [name, unit, group] = ["name", "unit", "group"].map(|of| column[of].as_str().unwrap());
        let star = if column["shown"] == true { "*" } else { "" };
        format!("{group}: {name}{star} [{unit}]\n")
    };
    let listed: String = columns.iter().map(column).collect();
    let figure = &data["figures"][0];
    let spots: Vec<Value> = figure["spots"]
        .as_array()
        .unwrap()
        .iter()
        .map(|spot| json!([spot[0], spot[1], rounded(&spot[4]), rounded(&spot[5]), spot[6]]))
        .collect();
    let maps = &data["fields"][0]["maps"];
    let names: Vec<&Value> = maps.as_array().unwrap().iter().map(|map| &map["name"]).collect();
    let sizes = (&data["fields"][0]["nx"], &data["fields"][0]["ny"]);
    let lines = |rows: Vec<Value>| rows.iter().map(|row| format!("{row}\n")).collect::<String>();
    let rows = lines(shown_rows(&data).into_iter().map(Value::from).collect());
    insta::assert_snapshot!(format!(
        "{listed}\n{rows}\n{}\n{}\n{}\n{names:?} {sizes:?}\n",
        figure["axes"],
        figure["entries"],
        lines(spots)
    ));
    let keys: Vec<&str> =
        data["jobs"]["keys"].as_array().unwrap().iter().map(|key| key.as_str().unwrap()).collect();
    assert_eq!(keys, place.keys());
}

#[test]
fn numbers_of_a_page_are_those_of_a_query() {
    let place = Place::run();
    assert_eq!(place.call("report small").code, 0);
    let data = data(&page(&place, "small.html"));
    let loads = place.json("query small --select load,peak_pressure,stick_fraction --json");
    let columns = data["jobs"]["columns"].as_array().unwrap();
    for name in ["load", "peak_pressure", "stick_fraction"] {
        let column = columns.iter().find(|column| column["name"] == name).unwrap();
        for row in 0..6 {
            let held = match column["slot"].as_u64() {
                Some(slot) => &data["jobs"]["rows"][row][slot as usize],
                None => &column["same"],
            };
            assert_eq!(*held, loads["rows"][row][name], "{name} of row {row}");
        }
    }
}

#[test]
fn the_same_results_give_the_same_page_wherever_they_are() {
    let place = Place::run();
    assert_eq!(place.call("report small").code, 0);
    let first = page(&place, "small.html");
    assert_eq!(place.call("store export kept/small.tribosweep").code, 0);
    assert_eq!(place.call("store merge .tribosweep --into merged").code, 0);
    fs::create_dir(place.path("other")).unwrap();
    for store in [".tribosweep", "kept/small.tribosweep", "kept", "merged"] {
        let said = place.call(&format!("report small --store {store} --output other/small.html"));
        assert_eq!((said.code, said.out.as_str()), (0, "other/small.html\n"), "{}", said.err);
        assert!(page(&place, "other/small.html") == first, "{store}");
    }
    let directory = place.path("");
    assert!(!first.contains(directory.to_str().unwrap().trim_end_matches('/')));
}

#[test]
fn a_report_writes_its_file_and_nothing_else() {
    let place = Place::run();
    let before = place.files();
    assert_eq!(place.call("report small").code, 0);
    let after = place.files();
    let new: Vec<_> = after.iter().filter(|file| !before.contains(file)).collect();
    assert_eq!(new.len(), 1);
    assert!(new[0].0.ends_with("small.html"));
    assert_eq!(after.len(), before.len() + 1);
    // A second page takes the place of the first.
    assert_eq!(place.call("report small --where mu>0.1").code, 0);
    assert_eq!(place.files().len(), after.len());
    assert_eq!(data(&page(&place, "small.html"))["jobs"]["keys"].as_array().unwrap().len(), 4);
}

#[test]
fn fields_are_those_that_are_asked_for() {
    let place = Place::run();
    let keys = place.keys();
    let fields = |line: &str| -> Vec<String> {
        let written = place.json(&format!("report small --json {line}"));
        let said: Vec<String> = serde_json::from_value(written["fields"].clone()).unwrap();
        let html = page(&place, "small.html");
        assert_eq!(written["bytes"], html.len());
        let held = data(&html)["fields"].as_array().unwrap().len();
        assert_eq!(held, said.len());
        said
    };
    assert_eq!(fields(""), keys, "all of six jobs");
    assert!(fields("--fields 0").is_empty());
    assert_eq!(fields("--fields 2").len(), 2);
    let (a, b) = (&keys[4], &keys[1]);
    assert_eq!(fields(&format!("--fields {},{}", &a[..10], &b.to_uppercase()[..12])), [&**a, b]);
}

#[test]
fn what_a_page_cannot_show_is_refused_in_words() {
    let place = Place::run();
    fs::create_dir(place.path("taken.html")).unwrap();
    insta::assert_snapshot!(place.transcript(&[
        &["report", "large"],
        &["report", "small", "--output", "nowhere/small.html"],
        &["report", "small", "--output", "taken.html"],
        &["report", "small", "--where", "mu > 7"],
        &["report", "small", "--where", "mu >"],
        &["report", "small", "--where", "wind > 7"],
        &["report", "small", "--fields", "ffffffffffffffff"],
        &["report", "small", "--fields", "12,nothing"],
    ]));
    assert!(!place.path("small.html").exists());
}

#[test]
fn failures_stand_in_the_page_with_their_reasons() {
    let study = SMALL.replace("mesh = 6", "mesh = 6\nmax_iterations = 1");
    let place = Place::with("small.toml", study);
    assert_eq!(place.call("run small.toml --workers 2").code, 2);
    assert_eq!(place.call("report small").code, 0);
    let html = page(&place, "small.html");
    let failed = place.json("query small --json --select key,status,reason");
    let row = &failed["rows"][0];
    assert_eq!(row["status"], "failed");
    let (_, section) = html.split_once("<section id=\"failures\">").unwrap();
    let (section, _) = section.split_once("</section>").unwrap();
    for words in [row["reason"].as_str().unwrap(), "6 jobs left no certified solution."] {
        assert!(section.contains(words), "{words}");
    }
    assert!(section.contains(&format!("tribosweep show {}", &row["key"].as_str().unwrap()[..12])));
    // The fields of a last iterate are there for who asks for them, and say what they are.
    assert!(data(&html)["fields"].as_array().unwrap().is_empty());
}

#[test]
fn the_study_stands_in_the_page_as_it_was_written() {
    let study = SMALL.replace("Does it slip?", "Does <b>it</b> slip & 'stick'?");
    let place = Place::with("small.toml", &study);
    assert_eq!(place.call("run small.toml --workers 2").code, 0);
    assert_eq!(place.call("report small").code, 0);
    let html = page(&place, "small.html");
    assert!(html.contains("<h1>Does &lt;b&gt;it&lt;/b&gt; slip &amp; &#39;stick&#39;?</h1>"));
    let (_, section) = html.split_once("<section id=\"reproduce\">").unwrap();
    let (_, text) = section.rsplit_once("<pre>\n").unwrap();
    let (text, _) = text.split_once("</pre>").unwrap();
    assert_eq!(unescaped(text), study);
}

/// Returns a page's text with what HTML escapes as it was.
fn unescaped(text: &str) -> String {
    [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&amp;", "&")]
        .into_iter()
        .fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
}

#[test]
fn tabs_and_ends_of_lines_of_a_study_stay_what_they_are() {
    let study = SMALL.replace("mesh = 6", "\tmesh = 6 # six").replace('\n', "\r\n");
    let place = Place::with("small.toml", &study);
    assert_eq!(place.call("run small.toml --workers 2").code, 0);
    assert_eq!(place.call("report small").code, 0);
    let html = page(&place, "small.html");
    let (_, text) = html.rsplit_once("<pre>\n").unwrap();
    let (text, _) = text.split_once("</pre>").unwrap();
    assert_eq!(unescaped(text), study.replace("\r\n", "\n"));
}

#[test]
fn the_commands_of_a_page_write_it_again() {
    let place = Place::run();
    let key = &place.keys()[3][..12];
    let said = place.words(&[
        "report",
        "small",
        "--where",
        "mu > 0.1",
        "--output",
        "./rough.html",
        "--fields",
        key,
    ]);
    assert_eq!(said.code, 0, "{}", said.err);
    let html = page(&place, "rough.html");
    let command = "tribosweep report small --where 'mu > 0.1' --output rough.html";
    assert_eq!(data(&html)["report"], command);
    assert!(unescaped(&html).contains(&format!(">{command} --fields {key}</pre>")));
    // The ranges are of the rows for which the condition holds, like everything else.
    assert!(html.contains("Over 4 points"), "{html}");
    assert!(html.contains("The number of points that are solved, the warnings and effects are of"));
    assert!(html.contains("written by <code>tribosweep report</code>"));
}

#[test]
fn a_page_knows_which_jobs_have_fields() {
    let study = SMALL.replace("[0.05, 0.2, 0.6]", "[0.05, 0.2, 0.6]\nmax_iterations = [1, 200]");
    let place = Place::with("small.toml", study);
    assert_eq!(place.call("run small.toml --workers 2").code, 2);
    assert_eq!(place.call("report small").code, 0);
    let data = data(&page(&place, "small.html"));
    let rows = place.json("query small --json --select key,status");
    let keys = data["jobs"]["keys"].as_array().unwrap();
    assert_eq!(keys.len(), 12);
    for (row, key) in keys.iter().enumerate() {
        let has_fields = place
            .words(&["show", key.as_str().unwrap(), "--field", "pressure", "--output", "p.npy"])
            .code
            == 0;
        let fieldless = data["jobs"]["fieldless"].as_array().unwrap();
        assert_eq!(fieldless.contains(&json!(row)), !has_fields, "{}", rows["rows"][row]);
    }
}

#[test]
fn a_file_of_fields_that_is_lost_does_not_take_the_page_with_it() {
    let text = HERTZ.replace("KIND", "convergence") + "[convergence]\nreference = \"finest\"\n";
    let place = Place::with("hertz.toml", text);
    assert_eq!(place.call("run hertz.toml --workers 2").code, 0);
    fs::remove_file(&place.blobs().0[0]).unwrap();
    let written = place.json("report hertz --json");
    let left_out = written["left_out"].to_string();
    assert!(left_out.contains("The points are not compared"), "{left_out}");
    assert!(left_out.contains("is missing"), "{left_out}");
    let html = page(&place, "hertz.html");
    assert!(html.contains("<p class=\"warning\">The points are not compared"));
    assert!(!data(&html)["jobs"]["keys"].as_array().unwrap().is_empty());
}

#[test]
fn a_thousand_jobs_fit_into_three_megabytes() {
    let study = SMALL
        .replace("mesh = 6", "mesh = 5")
        .replace("[0.05, 0.2, 0.6]", "{ from = 0.05, to = 0.8, count = 50 }")
        .replace("[0.0, 0.3]", "{ from = 0.0, to = 0.4, count = 20 }")
        .replace("name = \"small\"", "name = \"many\"");
    let place = Place::with("many.toml", study);
    assert!([0, 2].contains(&place.call("run many.toml --workers 2").code));
    let written = place.json("report many --json");
    assert_eq!(written["rows"], 1000);
    let bytes = fs::metadata(place.path("many.html")).unwrap().len();
    assert!(bytes < 3_000_000, "{bytes}");
    assert!((2..=12).contains(&written["fields"].as_array().unwrap().len()));
    let html = page(&place, "many.html");
    let jobs = format!("fields of {} of 1000 rows", written["fields"].as_array().unwrap().len());
    assert!(html.contains(&jobs));
    for sentence in written["left_out"].as_array().unwrap() {
        assert!(sentence.as_str().unwrap().ends_with('.'), "{sentence}");
    }
}

#[test]
fn fields_that_have_no_room_are_said_and_come_when_they_are_asked_for() {
    let study = SMALL
        .replace("mesh = 6", "mesh = 900\ntolerance = 1e-3")
        .replace("friction.mu = 0.3\n", "")
        .replace("friction.mu = [0.05, 0.2, 0.6]\n", "")
        .replace("[0.0, 0.3]", "[0.3]")
        .replace("x = \"mu\"", "x = \"poisson\"")
        .replace("series = [\"poisson\"]", "")
        .replace("y = \"stick_fraction\"", "y = \"load\"");
    let place = Place::with("small.toml", study);
    assert_eq!(place.call("run small.toml --workers 1").code, 0);
    let usual = place.json("report small --json");
    assert_eq!(usual["fields"], json!([]));
    assert_eq!(usual["left_out"], json!(["The page has no room for the fields of 1 more job."]));
    assert!(page(&place, "small.html").contains("no room for the fields of 1 more job."));
    assert!(usual["bytes"].as_u64().unwrap() < 3_000_000);
    let asked = place.json(&format!("report small --json --fields {}", &place.keys()[0][..8]));
    assert_eq!(asked["fields"], json!(place.keys()));
    assert_eq!(asked["left_out"], json!([]));
}
