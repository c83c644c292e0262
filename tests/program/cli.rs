//! The command as a user meets it: its output, the files that it leaves and its exit codes.

mod accuracy;
mod adaptive;
mod below_surface;
mod budgets;
mod cite;
mod doctor;
mod effects;
mod failed;
mod height_maps;
mod in_time;
mod kinds;
mod merges;
mod paths;
mod points;
mod proposed;
mod provenance;
mod reference;
mod refused;
mod report;
mod research_object;
mod said;
mod samples;
mod sensitivity;
mod shards;
mod store;
mod submit;
mod tables;
mod upkeep;
mod wear;
mod wheel;

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::place::{Place, SMALL, redacted, skip};

#[test]
fn help_says_what_can_be_asked() {
    let place = Place::empty();
    let commands = "run submit plan effects cost resume status answer query show plot report cite diff tag note rm solve store doctor keys columns completions";
    let mut lines: Vec<Vec<&str>> = vec![vec!["--help"], vec!["--version"]];
    lines.extend(commands.split(' ').map(|command| vec![command, "--help"]));
    lines.extend(
        ["verify", "salvage", "compact", "gc", "export", "import", "merge"]
            .map(|command| vec!["store", command, "--help"]),
    );
    let lines: Vec<&[&str]> = lines.iter().map(Vec::as_slice).collect();
    insta::assert_snapshot!(place.transcript(&lines));
    assert!(place.files().is_empty());
}

/// The files that the examples of the help name are in the repository.
#[test]
fn examples_in_the_help_exist() {
    let place = Place::empty();
    for command in ["run", "submit", "plan", "effects", "cost", "solve"] {
        let help = place.words(&[command, "--help"]).out;
        for file in help.split_whitespace().filter(|word| word.starts_with("sweeps/")) {
            assert!(
                Path::new(env!("CARGO_MANIFEST_DIR")).join(file).is_file(),
                "{command} --help names {file}"
            );
        }
    }
}

/// Every study of the repository can be planned, but for the one of what is refused.
#[test]
fn every_sweep_can_be_planned() {
    let place = Place::empty();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("sweeps");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let sweeps: Vec<_> =
        files.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    assert!(sweeps.len() > 30);
    for sweep in sweeps {
        let said = place.words(&["plan", sweep.to_str().unwrap()]);
        let is_refused = sweep.ends_with("hard-cases-refused.toml");
        assert_eq!(said.code, i32::from(is_refused), "{}\n{}", sweep.display(), said.err);
    }
}

#[test]
fn mistakes_on_the_command_line_end_with_1() {
    let place = Place::empty();
    let lines: &[&[&str]] = &[
        &[],
        &["frobnicate"],
        &["rnu", "x.toml"],
        &["run"],
        &["run", "x.toml", "--workers", "0"],
        &["run", "x.toml", "--workers", "many"],
        &["run", "x.toml", "--memory", "8 apples"],
        &["run", "x.toml", "--memory", "0"],
        &["run", "x.toml", "--until", "0s"],
        &["run", "x.toml", "--until", "55"],
        &["run", "x.toml", "--until", "5 apples"],
        &["resume", "x", "--until", "soon"],
        &["cost", "x.toml", "--until", ""],
        &["run", "x.toml"],
        &["query", "x", "--format", "xml"],
        &["show", "00", "--output", "x.png"],
        &["store"],
        &["completions", "cmd.exe"],
        &["status"],
        &["resume", "x"],
        &["query", "x"],
        &["show", "00"],
        &["plot", "x"],
        &["report", "x"],
        &["report", "x", "--fields", "wrong"],
        &["store", "verify"],
        &["store", "compact"],
    ];
    insta::assert_snapshot!(place.transcript(lines));
    for words in lines {
        assert_eq!(place.words(words).code, 1, "{words:?}");
    }
    assert!(place.files().is_empty(), "a mistake left something behind");
    assert_eq!(place.call("completions bash").code, 0);
}

#[test]
fn a_study_from_plan_to_status() {
    let place = Place::with("small.toml", SMALL);
    let lines: &[&[&str]] = &[
        &["plan", "small.toml"],
        &["run", "small.toml", "--workers", "2"],
        &["plan", "small.toml"],
        &["run", "small.toml"],
        &["resume", "small"],
        &["status"],
        &["status", "small"],
        &["status", "large"],
    ];
    insta::assert_snapshot!(place.transcript(lines));
    assert!(fs::read(place.path(".tribosweep/figures/small.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(fs::read(place.path(".tribosweep/figures/small.svg")).unwrap().starts_with(b"<svg"));
}

#[test]
fn the_store_can_be_elsewhere() {
    let place = Place::with("small.toml", SMALL);
    assert_eq!(place.call("run small.toml --store kept --workers 1").code, 0);
    assert!(!place.path(".tribosweep").exists());
    let output =
        place.command(&["status", "--json"]).env("TRIBOSWEEP_STORE", "kept").output().unwrap();
    let listed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(listed[0]["progress"]["done"], 6);
}

#[test]
fn query_selects_sorts_and_keeps() {
    let place = Place::run();
    let lines: &[&[&str]] = &[
        &["query", "small"],
        &["query", "small", "--where", "mu > 0.1 && poisson == 0.3", "--select", "mu,load,key"],
        &["query", "small", "--sort=-mu,poisson", "--select", "mu,poisson,stick_elements"],
        &["query", "small", "--sort", "-mu", "--select", "mu,poisson,slip_elements"],
        &["query", "small", "--where", "mu > 7"],
        &["query", "small", "--select", "mu,status", "--format", "csv"],
        &["query", "small", "--select", "mu,stick_elements,status", "--json"],
        &["query", "small", "--columns"],
        &["query", "small", "--select", "mu,stick_fracton"],
        &["query", "small", "--sort", "wind"],
        &["query", "small", "--where", "mu >"],
        &["query", "small", "--where", "nu > 1"],
        &["query", "small", "--where", "mu"],
        &["query", "small", "--where", "status > 3"],
        &["query", "large"],
        &["query", "small.toml"],
    ];
    insta::assert_snapshot!(place.transcript(lines));
    let loads = place.json("query small --select mu,load --json");
    assert_eq!(loads["units"]["load"], "N");
    assert!(
        loads["rows"].as_array().unwrap().iter().all(|row| row["load"].as_f64().unwrap() > 4000.0)
    );
}

/// A table in a file does not depend on the terminal from which it is written.
#[test]
fn a_table_in_a_file_is_that_of_a_pipe() {
    let place = Place::run();
    let printed = place.succeed("query small");
    assert_eq!(place.succeed("query small --output piped.txt"), "piped.txt\n");
    assert_eq!(fs::read_to_string(place.path("piped.txt")).unwrap(), printed);
    let line = "stty cols 40; exec tribosweep query small --output narrow.txt";
    let mut terminal =
        place.shell(&format!("command -v script || exit 9; script -qec '{line}' log"));
    let said = place.said(&mut terminal);
    if said.code == 9 {
        return skip("there is no `script`, which makes a terminal");
    }
    assert_eq!(said.code, 0, "{}", said.out);
    assert_eq!(fs::read_to_string(place.path("narrow.txt")).unwrap(), printed);
}

#[test]
fn a_table_is_written_to_a_file_when_it_is_whole() {
    let place = Place::run();
    // The first is written row by row, the second is sorted as it is already.
    let by_row = place.call("query small --select mu,poisson,load --format csv");
    let whole = place.call("query small --select mu,poisson,load --format csv --sort mu,poisson");
    assert_eq!((by_row.code, by_row.out.lines().count()), (0, 7));
    let sorted = |text: &str| {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines.sort();
        lines
    };
    assert_eq!(sorted(&by_row.out), sorted(&whole.out));
    let said = place.call("query small --select mu,poisson,load --format csv --output loads.csv");
    assert_eq!((said.code, said.out.as_str()), (0, "loads.csv\n"));
    assert_eq!(fs::read_to_string(place.path("loads.csv")).unwrap(), by_row.out);
    let said = place.call("query small --format parquet --output loads.parquet");
    assert_eq!(said.code, 0);
    assert!(fs::read(place.path("loads.parquet")).unwrap().ends_with(b"PAR1"));
    let refused = place.call("query small --format parquet");
    assert_eq!(refused.code, 1);
    assert!(refused.err.contains("--output small.parquet"), "{}", refused.err);
    let refused = place.call("query small --format parquet --select lod --output no.parquet");
    assert_eq!(refused.code, 1);
    assert!(refused.err.contains("did you mean load?"), "{}", refused.err);
    let left = fs::read_dir(place.path(".")).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(left.into_iter().all(|name| !name.to_string_lossy().contains("no.parquet")));
}

#[test]
fn what_is_there_and_no_file_is_not_replaced() {
    let place = Place::run();
    let csv = place.call("query small --select mu,load --format csv").out;
    fs::write(place.path("loads.csv.part"), "of somebody else").unwrap();
    std::os::unix::fs::symlink("loads.csv", place.path("link.csv")).unwrap();
    std::os::unix::fs::symlink("/dev/null", place.path("null.csv")).unwrap();
    fs::create_dir(place.path("folder")).unwrap();
    assert_eq!(place.call("query small --select mu,load --format csv --output link.csv").code, 0);
    assert_eq!(fs::read_to_string(place.path("loads.csv")).unwrap(), csv);
    assert_eq!(fs::read(place.path("loads.csv.part")).unwrap(), b"of somebody else");
    for file in ["null.csv", "/dev/null"] {
        for format in ["csv --select mu", "csv", "json", "table"] {
            let said = place.call(&format!("query small --format {format} --output {file}"));
            assert_eq!(said.code, 0, "{}", said.err);
        }
    }
    for link in ["link.csv", "null.csv"] {
        assert!(fs::symlink_metadata(place.path(link)).unwrap().is_symlink());
    }
    insta::assert_snapshot!(place.transcript(&[
        &["query", "small", "--format", "parquet", "--output", "null.csv"],
        &["query", "small", "--format", "csv", "--output", "folder"],
        &["query", "small", "--json", "--output", "no/small.json"],
        &["plot", "small", "--output", "no/small.png"],
        &["report", "small", "--output", "null.csv"],
    ]));
}

/// A mistake in a question is no fault of the file or the terminal.
#[test]
fn a_question_that_makes_no_sense_is_not_a_failure_to_write() {
    let place = Place::run();
    for format in ["csv", "csv --output no.csv", "parquet --output no.parquet"] {
        for question in
            ["--select wind", "--select mu --where wind>3", "--select mu --where status>3"]
        {
            let said = place.call(&format!("query small --format {format} {question}"));
            assert_eq!(said.code, 1, "{}", said.err);
            assert!(!said.err.contains("cannot write"), "{}", said.err);
        }
    }
    assert!(!place.path("no.csv").exists() && !place.path("no.parquet").exists());
}

#[test]
fn show_finds_a_result_by_the_beginning_of_its_key() {
    let place = Place::run();
    let keys = place.keys();
    assert_eq!(keys.len(), 6);
    for key in &keys {
        for prefix in [key.as_str(), &key[..8], &key[..8].to_uppercase()] {
            let shown = place.json(&format!("show {prefix} --json"));
            assert_eq!(shown["result"]["key"], key.as_str());
            assert_eq!(shown["result"]["status"], "certified");
        }
    }
    let shown = place.words(&["show", &keys[0]]);
    assert_eq!(shown.code, 0);
    // Values that are rounding noise or provenance differ between machines; their names do not.
    let from = shown.out.find("\nresult").unwrap();
    let name = |line: &str| match line.strip_prefix("  ") {
        Some(entry) => format!("  {}\n", entry.split(' ').next().unwrap_or_default()),
        None => format!("{line}\n"),
    };
    let names: String = shown.out[from..].lines().map(name).collect();
    insta::assert_snapshot!(format!("{}{names}", redacted(&shown.out[..from])));
    insta::assert_snapshot!(
        "show_refuses",
        place.transcript(&[
            &["show", "zz"],
            &["show", ""],
            &["show", &"0".repeat(64)],
            &["show", &keys[0], "--field", "presure"],
            &["show", &keys[0], "--field", "pressure", "--output", "p.jpg"],
            &["show", &keys[0], "--field", "pressure", "--output", "p"],
            &["show", &keys[0], "--output", "p.npy"],
            &["show", &keys[0], "--field", "pressure", "--output", "no/p.png"],
        ])
    );
}

#[test]
fn fields_are_drawn_and_written() {
    let place = Place::run();
    let key = &place.keys()[0];
    insta::assert_snapshot!(
        place.transcript(&[
            &["show", key, "--field", "pressure"],
            &["show", key, "--field", "state"]
        ])
    );
    let begins: [(&str, &[u8]); 5] = [
        ("png", b"\x89PNG\r\n\x1a\n"),
        ("svg", b"<svg"),
        ("npy", b"\x93NUMPY"),
        ("vti", b"<?xml"),
        ("csv", b"x"),
    ];
    let fields = "pressure traction_x traction_y traction gap slip_x slip_y friction_work state";
    for field in fields.split(' ') {
        for (ending, begin) in begins {
            let file = format!("{field}.{ending}");
            let said = place.words(&["show", key, "--field", field, "--output", &file]);
            assert_eq!((said.code, said.out), (0, format!("{file}\n")), "{}", said.err);
            let bytes = fs::read(place.path(&file)).unwrap();
            assert!(bytes.starts_with(begin), "{file} begins with {:?}", &bytes[..begin.len()]);
        }
    }
    // The mesh has six by six elements, of which twelve are pressed.
    let csv = fs::read_to_string(place.path("pressure.csv")).unwrap();
    assert_eq!(csv.lines().count(), 37, "{csv}");
    let npy = fs::read(place.path("pressure.npy")).unwrap();
    let values: Vec<f64> = npy[npy.len() - 36 * 8..]
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
        .collect();
    assert_eq!(values.iter().filter(|value| **value > 0.0).count(), 12);
}

#[test]
fn plots_of_the_study_and_of_other_columns() {
    let place = Place::run();
    insta::assert_snapshot!(place.transcript(&[
        &["plot", "small"],
        &["plot", "small", "--x", "mu", "--y", "load", "--output", "load.svg"],
        &[
            "plot", "small", "--x", "mu", "--y", "load", "--series", "poisson", "--log-x",
            "--output", "load.png"
        ],
        &["plot", "small", "--where", "poisson == 0.3", "--output", "kept.svg", "--json"],
        &["plot", "small", "--y", "lod"],
        &["plot", "small", "--series", "colour"],
        &["plot", "small", "--y", "status"],
        &["plot", "small", "--where", "mu > 7"],
        &["plot", "small", "--output", "figure.pdf"],
        &["plot", "small", "--output", "no/figure.svg"],
        &["plot", "large"],
    ]));
    for file in ["small.svg", "load.svg", "kept.svg"] {
        assert!(fs::read(place.path(file)).unwrap().starts_with(b"<svg"), "{file}");
    }
    for file in ["small.png", "load.png"] {
        assert!(fs::read(place.path(file)).unwrap().starts_with(b"\x89PNG"), "{file}");
    }
    assert!(!place.path("figure.pdf").exists());
}

#[test]
fn studies_have_several_figures() {
    let figure = SMALL.find("[figure]").unwrap();
    let figures = r#"
[[figure]]
x = "mu"
y = "stick_fraction"
[[figure]]
name = "peak"
title = "Is it Hertz's?"
x = "mu"
y = ["peak_pressure", "hertz_peak_pressure"]
series = ["poisson"]
[[figure]]
x = "mu"
y = "at_twist"
log_y = true
"#;
    let place = Place::with("small.toml", format!("{}{figures}", &SMALL[..figure]));
    let ran = place.call("run small.toml --workers 1");
    assert_eq!(ran.code, 0, "{}", ran.err);
    let said: Vec<&str> = ran.out.lines().filter(|line| line.contains("figure")).collect();
    insta::assert_snapshot!(said.join("\n"));
    assert!(!place.path(".tribosweep/figures/small-3.svg").exists());
    insta::assert_snapshot!(
        "one_of_several_figures",
        place.transcript(&[
            &["plot", "small", "--figure", "peak"],
            &["plot", "small", "--figure", "1", "--output", "first.svg"],
            &["plot", "small", "--log-x", "--output", "log.svg"],
            &["plot", "small", "--y", "contact_radius,hertz_a", "--output", "radius.svg"],
            &["plot", "small"],
            &["plot", "small", "--output", "all.svg"],
            &["plot", "small", "--figure", "weak"],
            &["plot", "small", "--y", "contact_radius,load"],
        ])
    );
    let svg = |file: &str| fs::read_to_string(place.path(file)).unwrap();
    let peak = svg("small-peak.svg");
    for text in [
        "Is it Hertz's?",
        "pressure [GPa]",
        "0.3, peak pressure",
        "Poisson's ratio",
        "coefficient of friction",
    ] {
        assert!(peak.contains(&format!(">{text}</text>")), "{text}: {peak}");
    }
    assert!(
        svg("radius.svg").contains(">length [mm]</text>")
            && svg("radius.svg").contains(">small</text>")
    );
    assert!(svg("first.svg").contains("Does it slip?"));
}

#[test]
fn solve_takes_one_point_and_settings() {
    let place = Place::with("small.toml", SMALL);
    let both = [
        "solve",
        "small.toml",
        "--json",
        "--set",
        "friction.mu=0.4",
        "--set",
        "foundation.base.poisson=0.3",
    ];
    let solved: Value = serde_json::from_str(&place.words(&both).out).unwrap();
    assert_eq!(solved["result"]["status"], "certified");
    assert_eq!(
        (&solved["result"]["mu"], &solved["result"]["poisson"]),
        (&Value::Null, &Value::Null),
        "keys stand in the job"
    );
    assert_eq!(solved["job"]["scene"]["friction"]["mu"], 0.4);

    let with =
        |more: &[&'static str]| [&both[..2], &both[3..], &["--field", "state"], more].concat();
    let finer = place.words(&with(&[
        "--set",
        "mesh=8",
        "--set",
        "punch.radius=60 mm",
        "--set",
        "loading.steps[0].approach=10 um",
    ]));
    assert_eq!(finer.code, 0, "{}", finer.err);
    insta::assert_snapshot!(place.transcript(&[
        &["solve", "small.toml"],
        &["solve", "small.toml", "--set", "friction.mu=0.4"],
        &with(&["--set", "frction.mu=0.4"]),
        &with(&["--set", "mu=0.4"]),
        &with(&["--set", "weather=0.4"]),
        &with(&["--set", "mesh"]),
        &with(&["--set", "mesh=0"]),
        &with(&["--set", "punch.radius=5 MPa"]),
        &with(&["--set", "punch.angle=5 deg"]),
        &with(&["--set", "loading.steps[1].approach=1 um"]),
        &with(&["--set", "method=krylov"]),
    ]));
    // Settings are not written back, and nothing is stored.
    assert_eq!(place.files().len(), 1);
    assert_eq!(fs::read_to_string(place.path("small.toml")).unwrap(), SMALL);

    let unsolved = place.words(&with(&["--set", "max_iterations=2"]));
    assert_eq!(unsolved.code, 2);
    assert!(
        unsolved.err.contains("not certified: not converged in 2 iterations")
            && unsolved.err.contains("the last iterate"),
        "{}",
        unsolved.err
    );
}

#[test]
fn json_is_json() {
    let place = Place::with("small.toml", SMALL);
    assert_eq!(place.json("plan small.toml --json")["to_run"], 6);
    let run = place.call("run small.toml --workers 1 --json");
    let events: Vec<Value> =
        run.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let named = |name: &str| events.iter().filter(|event| event["event"] == name).count();
    assert_eq!(
        (named("run-started"), named("done"), named("finished"), named("summary")),
        (1, 6, 1, 1)
    );
    let summary = events.last().unwrap();
    assert_eq!(summary["event"], "summary");
    assert_eq!(
        (&summary["run"]["computing"], &summary["progress"]["done"]),
        (&6.into(), &6.into())
    );
    assert_eq!(run.err, "");
    let again = place.call("run small.toml --json");
    assert_eq!(again.out.lines().count(), 1, "{}", again.out);
    assert_eq!(place.json("run small.toml --json")["run"]["cached"], 6);
    assert_eq!(place.json("resume small --json")["run"]["cached"], 6);
    assert_eq!(place.json("plan small.toml --json")["to_run"], 0);
    assert_eq!(place.json("status --json")[0]["study"], "small");
    assert_eq!(place.json("status small --json")[0]["progress"]["done"], 6);
    assert_eq!(place.json("query small --json")["rows"].as_array().map(Vec::len), Some(6));
    assert_eq!(place.json("query small --columns --json")["rows"][0]["column"], "mu");
    assert_eq!(place.json("plot small --json").as_array().map(Vec::len), Some(2));
    assert_eq!(place.json("store verify --json")["sound"], true);
    assert_eq!(place.json("store compact --json")["files"], 0);
    assert_eq!(place.json("store salvage --json")["kept"], 6);
}

#[test]
fn failed_jobs_are_listed_and_can_be_tried_again() {
    let failing = SMALL.replace("mesh = 6", "mesh = 6\nmax_iterations = 2");
    let place = Place::with("small.toml", failing);
    let summary = |line: &str| -> (i32, Value) {
        let said = place.call(line);
        (said.code, serde_json::from_str(said.out.lines().last().unwrap()).unwrap())
    };
    let (code, first) = summary("run small.toml --workers 2 --json");
    assert_eq!(
        (code, &first["progress"]["failed"], &first["run"]["computing"]),
        (2, &6.into(), &6.into())
    );
    for failure in first["failures"].as_array().unwrap() {
        let command = failure["show"].as_str().unwrap().strip_prefix("tribosweep ").unwrap();
        let shown = place.call(command);
        assert_eq!(shown.code, 0, "{command}: {}", shown.err);
        assert!(shown.out.contains("status               failed"), "{}", shown.out);
    }
    let (code, cached) = summary("run small.toml --json");
    assert_eq!(
        (code, &cached["run"]["cached"]),
        (2, &6.into()),
        "a failed job is not computed again unasked"
    );
    let (code, again) = summary("run small.toml --json --retry-failed");
    assert_eq!((code, &again["run"]["computing"]), (2, &6.into()));
    let listed: String = place
        .call("run small.toml")
        .out
        .lines()
        .skip_while(|line| !line.starts_with("small:"))
        .map(|l| l.to_owned() + "\n")
        .collect();
    insta::assert_snapshot!(redacted(&listed));

    // The mended study has other jobs under the same name.
    place.write("small.toml", SMALL);
    let (code, mended) = summary("run small.toml --json --retry-failed");
    assert_eq!(
        (code, &mended["run"]["computing"], &mended["progress"]["done"]),
        (0, &6.into(), &6.into())
    );
}

/// The same job gives the same bytes on any number of workers and of threads in each; two threads
/// share an operator from 64² elements on.
#[test]
fn the_number_of_workers_and_threads_changes_no_byte() {
    let study = SMALL.replace("mesh = 6", "mesh = 72\nmax_iterations = 3");
    assert_ne!(study, SMALL);
    let place = Place::with("small.toml", study);
    let results = |workers: &str| {
        let said = place.words(&["run", "small.toml", "--workers", workers, "--store", workers]);
        assert_eq!(
            said.code, 2,
            "three sweeps solve nothing, but leave their figures: {}",
            said.err
        );
        let columns = place.json(&format!("query small --store {workers} --columns --json"));
        let columns = columns["rows"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|column| column["kind"] != "provenance");
        let columns: Vec<&str> = columns.map(|column| column["column"].as_str().unwrap()).collect();
        let table = place
            .words(&[
                "query",
                "small",
                "--store",
                workers,
                "--select",
                &columns.join(","),
                "--format",
                "csv",
            ])
            .out;
        let store = place.path(workers);
        let accounts = place.accounts_in(workers);
        assert_eq!(accounts.len(), 1);
        let blobs =
            place.files().into_iter().filter(|(path, _)| !accounts.contains(path)).filter_map(
                |(path, bytes)| Some((path.strip_prefix(&store).ok()?.to_owned(), bytes)),
            );
        let blobs: Vec<_> = blobs
            .filter(|(path, _)| path.extension().is_some_and(|ending| ending == "zst"))
            .collect();
        assert!(table.lines().count() == 7 && blobs.len() == 7, "{table}");
        (table, blobs)
    };
    assert!(results("1") == results("3"));
}

/// A dot in a name begins no ending: both files of the figure are written beside each other.
#[test]
fn a_study_named_with_a_dot_gets_its_figure() {
    let place = Place::with("dotted.toml", SMALL.replace("\"small\"", "\"small-v1.2\""));
    assert_eq!(place.call("run dotted.toml").code, 0);
    let said = place.call("plot small-v1.2 --json");
    assert_eq!(
        serde_json::from_str::<Value>(&said.out).unwrap(),
        serde_json::json!(["small-v1.2.svg", "small-v1.2.png"]),
        "{}",
        said.err
    );
    for file in [
        "small-v1.2.svg",
        "small-v1.2.png",
        ".tribosweep/figures/small-v1.2.svg",
        ".tribosweep/figures/small-v1.2.png",
    ] {
        assert!(place.path(file).exists(), "{file}");
    }
}
