//! The command as a user meets it: what it prints, what it leaves behind, with which code it ends.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_tribosweep");
/// Six points in two axes, each a matter of milliseconds.
const SMALL: &str = include_str!("studies/small.toml");
/// One point whose punch is a height map in a file.
const ONE: &str = include_str!("studies/one.toml");

/// A directory to stand in, with a study file or none.
struct Place(TempDir);

/// How a command ended.
struct Said {
    code: i32,
    out: String,
    err: String,
}

impl Place {
    fn empty() -> Self {
        Self(TempDir::new().unwrap())
    }

    fn with(file: &str, text: impl AsRef<[u8]>) -> Self {
        let place = Self::empty();
        place.write(file, text);
        place
    }

    /// The small study, run.
    fn run() -> Self {
        let place = Self::with("small.toml", SMALL);
        assert_eq!(place.call("run small.toml --workers 2").code, 0);
        place
    }

    fn path(&self, file: &str) -> PathBuf {
        self.0.path().join(file)
    }

    fn write(&self, file: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path(file), text).unwrap();
    }

    fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(PROGRAM);
        command.args(words).current_dir(self.0.path()).stdin(Stdio::null());
        for variable in ["TRIBOSWEEP_STORE", "COLUMNS", "NO_COLOR", "CLICOLOR_FORCE", "RUST_BACKTRACE"] {
            command.env_remove(variable);
        }
        command
    }

    fn words(&self, words: &[&str]) -> Said {
        let output = self.command(words).output().unwrap();
        let clean = |bytes: &[u8]| {
            let text = std::str::from_utf8(bytes).unwrap();
            text.replace(PROGRAM, "tribosweep").replace(self.0.path().to_str().unwrap(), "[directory]")
        };
        Said { code: output.status.code().expect("ended by itself"), out: clean(&output.stdout), err: clean(&output.stderr) }
    }

    /// Runs the command with words separated by blanks.
    fn call(&self, line: &str) -> Said {
        self.words(&line.split_whitespace().collect::<Vec<_>>())
    }

    fn json(&self, line: &str) -> Value {
        let said = self.call(line);
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{line}: {error}\n{}{}", said.out, said.err))
    }

    /// All of several commands as a transcript.
    fn transcript(&self, lines: &[&[&str]]) -> String {
        lines.iter().map(|words| format!("$ tribosweep {}\n{}\n", words.join(" "), self.words(words).transcript())).collect()
    }

    /// The small study's keys in the order of its points.
    fn keys(&self) -> Vec<String> {
        self.call("query small --select key --format csv").out.lines().skip(1).map(str::to_owned).collect()
    }

    /// Every file below the directory with its bytes.
    fn files(&self) -> Vec<(PathBuf, Vec<u8>)> {
        fn walk(directory: &Path, files: &mut Vec<(PathBuf, Vec<u8>)>) {
            for entry in fs::read_dir(directory).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() { walk(&path, files) } else { files.push((path.clone(), fs::read(&path).unwrap())) }
            }
        }
        let mut files = Vec::new();
        walk(self.0.path(), &mut files);
        files.sort();
        files
    }

    /// The files with the fields of results, and the file with the study's definition.
    fn blobs(&self) -> (Vec<PathBuf>, PathBuf) {
        let manifest = fs::read_to_string(self.path(".tribosweep/manifest.json")).unwrap();
        let digest = |path: &Path| {
            let stem = path.file_stem().unwrap().to_str().unwrap();
            format!("{}{stem}", path.parent().unwrap().file_name().unwrap().to_str().unwrap())
        };
        let blobs = self.files().into_iter().map(|(path, _)| path).filter(|path| path.extension().is_some_and(|e| e == "zst"));
        let (mut studies, fields): (Vec<_>, Vec<_>) = blobs.partition(|path| manifest.contains(&digest(path)));
        assert_eq!((studies.len(), fields.len()), (1, 6));
        (fields, studies.remove(0))
    }
}

impl Said {
    fn transcript(&self) -> String {
        let err: String = self.err.lines().map(|line| format!("! {line}\n")).collect();
        redacted(&format!("{}{err}= {}\n", self.out, self.code))
    }
}

/// A text without what differs from run to run: times, processes, hashes of floating-point fields, the version.
fn redacted(text: &str) -> String {
    let mut lines = Vec::new();
    for line in text.lines() {
        let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        for at in 0..words.len() {
            let bare = |word: &str| word.trim_matches(|c: char| "(),;:".contains(c)).to_owned();
            let next = words.get(at + 1).map(|word| bare(word)).unwrap_or_default();
            let word = bare(&words[at]);
            let before = at.checked_sub(1).map(|at| bare(&words[at])).unwrap_or_default();
            let number = word.parse::<f64>().is_ok();
            let new = match () {
                () if number && ["ms", "s", "min"].contains(&next.as_str()) => "[time]",
                () if number && next == "workers" => "[n]",
                () if number && before == "process" => "[pid]",
                () if word == env!("CARGO_PKG_VERSION") => "[version]",
                () => continue,
            };
            words[at] = words[at].replace(&word, new);
            if new == "[time]" {
                // the unit goes too, what follows it stays
                let rest = words[at + 1].replacen(&next, "", 1);
                words[at] += &rest;
                words[at + 1].clear();
            }
        }
        lines.push(words.join(" ").replace("[time]  ", "[time] ").replace("[time],  ", "[time], ").trim_end().to_owned() + "\n");
    }
    lines.concat()
}

/// The text with every hash in hexadecimal taken out.
fn without_hashes(text: &str) -> String {
    let is_hash = |word: &str| word.len() == 64 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
    text.split_inclusive(|c: char| !c.is_ascii_alphanumeric())
        .map(|word| {
            let bare = word.trim_end_matches(|c: char| !c.is_ascii_alphanumeric());
            if is_hash(bare) { word.replace(bare, "[hash]") } else { word.to_owned() }
        })
        .collect()
}

#[test]
fn help_says_what_can_be_asked() {
    let place = Place::empty();
    let commands = "run plan resume status query show plot solve store completions";
    let mut lines: Vec<Vec<&str>> = vec![vec!["--help"], vec!["--version"]];
    lines.extend(commands.split(' ').map(|command| vec![command, "--help"]));
    lines.extend(["verify", "salvage", "compact"].map(|command| vec!["store", command, "--help"]));
    let lines: Vec<&[&str]> = lines.iter().map(Vec::as_slice).collect();
    insta::assert_snapshot!(place.transcript(&lines));
    assert!(place.files().is_empty());
}

/// Files that the examples of the help name are in the repository.
#[test]
fn examples_in_the_help_exist() {
    let place = Place::empty();
    for command in ["run", "plan", "solve"] {
        let help = place.words(&[command, "--help"]).out;
        for file in help.split_whitespace().filter(|word| word.starts_with("sweeps/")) {
            assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join(file).is_file(), "{command} --help names {file}");
        }
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
    let output = place.command(&["status", "--json"]).env("TRIBOSWEEP_STORE", "kept").output().unwrap();
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
    assert!(loads["rows"].as_array().unwrap().iter().all(|row| row["load"].as_f64().unwrap() > 4000.0));
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
    // values that are rounding noise or provenance differ between machines; their names do not
    let from = shown.out.find("\nresult").unwrap();
    let names: String = shown.out[from..].lines().map(|line| format!("{}\n", line.get(..22).unwrap_or(line).trim_end())).collect();
    insta::assert_snapshot!(format!("{}{names}", &shown.out[..from]));
    insta::assert_snapshot!(
        "show_refuses",
        place.transcript(&[
            &["show", "zz"],
            &["show", ""],
            &["show", &"0".repeat(64)],
            &["show", &keys[0], "--field", "presure"],
            &["show", &keys[0], "--field", "pressure", "--output", "p.jpg"],
            &["show", &keys[0], "--field", "pressure", "--output", "p"],
            &["show", &keys[0], "--field", "pressure", "--output", "no/p.png"],
        ])
    );
}

#[test]
fn fields_are_drawn_and_written() {
    let place = Place::run();
    let key = &place.keys()[0];
    insta::assert_snapshot!(place.transcript(&[&["show", key, "--field", "pressure"], &["show", key, "--field", "state"]]));
    let begins: [(&str, &[u8]); 5] =
        [("png", b"\x89PNG\r\n\x1a\n"), ("svg", b"<svg"), ("npy", b"\x93NUMPY"), ("vti", b"<?xml"), ("csv", b"x")];
    for field in ["pressure", "traction_x", "traction_y", "traction", "gap", "slip_x", "slip_y", "state"] {
        for (ending, begin) in begins {
            let file = format!("{field}.{ending}");
            let said = place.words(&["show", key, "--field", field, "--output", &file]);
            assert_eq!((said.code, said.out), (0, format!("{file}\n")), "{}", said.err);
            let bytes = fs::read(place.path(&file)).unwrap();
            assert!(bytes.starts_with(begin), "{file} begins with {:?}", &bytes[..begin.len()]);
        }
    }
    // six by six elements, twelve of them pressed
    let csv = fs::read_to_string(place.path("pressure.csv")).unwrap();
    assert_eq!(csv.lines().count(), 37, "{csv}");
    let npy = fs::read(place.path("pressure.npy")).unwrap();
    let values: Vec<f64> = npy[npy.len() - 36 * 8..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(values.iter().filter(|value| **value > 0.0).count(), 12);
}

#[test]
fn plots_of_the_study_and_of_other_columns() {
    let place = Place::run();
    insta::assert_snapshot!(place.transcript(&[
        &["plot", "small"],
        &["plot", "small", "--x", "mu", "--y", "load", "--output", "load.svg"],
        &["plot", "small", "--x", "mu", "--y", "load", "--series", "poisson", "--log-x", "--output", "load.png"],
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
fn solve_takes_one_point_and_settings() {
    let place = Place::with("small.toml", SMALL);
    let both = ["solve", "small.toml", "--json", "--set", "friction.mu=0.4", "--set", "foundation.base.poisson=0.3"];
    let solved: Value = serde_json::from_str(&place.words(&both).out).unwrap();
    assert_eq!(solved["result"]["status"], "certified");
    assert_eq!((&solved["result"]["mu"], &solved["result"]["poisson"]), (&Value::Null, &Value::Null), "keys stand in the job");
    assert_eq!(solved["job"]["scene"]["friction"]["mu"], 0.4);

    let with = |more: &[&'static str]| [&both[..2], &both[3..], &["--field", "state"], more].concat();
    let finer = place.words(&with(&["--set", "mesh=8", "--set", "punch.radius=60 mm", "--set", "loading.steps[0].approach=10 um"]));
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
        &with(&["--set", "method=newton"]),
    ]));
    // settings are not written back, and nothing is stored
    assert_eq!(place.files().len(), 1);
    assert_eq!(fs::read_to_string(place.path("small.toml")).unwrap(), SMALL);

    let unsolved = place.words(&with(&["--set", "max_iterations=2"]));
    assert_eq!(unsolved.code, 2);
    assert!(unsolved.err.contains("not solved to its tolerance"), "{}", unsolved.err);
}

#[test]
fn json_is_json() {
    let place = Place::with("small.toml", SMALL);
    assert_eq!(place.json("plan small.toml --json")["to_run"], 6);
    let run = place.call("run small.toml --workers 1 --json");
    let events: Vec<Value> = run.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let named = |name: &str| events.iter().filter(|event| event["event"] == name).count();
    assert_eq!((named("run-started"), named("done"), named("finished"), named("summary")), (1, 6, 1, 1));
    let summary = events.last().unwrap();
    assert_eq!(summary["event"], "summary");
    assert_eq!((&summary["run"]["computing"], &summary["progress"]["done"]), (&6.into(), &6.into()));
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
    assert_eq!((code, &first["progress"]["failed"], &first["run"]["computing"]), (2, &6.into(), &6.into()));
    for failure in first["failures"].as_array().unwrap() {
        let command = failure["show"].as_str().unwrap().strip_prefix("tribosweep ").unwrap();
        let shown = place.call(command);
        assert_eq!(shown.code, 0, "{command}: {}", shown.err);
        assert!(shown.out.contains("status               failed"), "{}", shown.out);
    }
    let (code, cached) = summary("run small.toml --json");
    assert_eq!((code, &cached["run"]["cached"]), (2, &6.into()), "a failed job is not computed again unasked");
    let (code, again) = summary("run small.toml --json --retry-failed");
    assert_eq!((code, &again["run"]["computing"]), (2, &6.into()));
    let listed: String =
        place.call("run small.toml").out.lines().skip_while(|line| !line.starts_with("small:")).map(|l| l.to_owned() + "\n").collect();
    insta::assert_snapshot!(redacted(&listed));

    // the mended study has other jobs under the same name
    place.write("small.toml", SMALL);
    let (code, mended) = summary("run small.toml --json --retry-failed");
    assert_eq!((code, &mended["run"]["computing"], &mended["progress"]["done"]), (0, &6.into(), &6.into()));
}

/// Name, what is replaced in the small study, and by what.
const REFUSED: &[(&str, &str, &str)] = &[
    ("empty file", SMALL, ""),
    ("not TOML", "mesh = 6", "mesh = = 6"),
    ("unclosed text", "\"small\"", "\"small"),
    ("a NUL", "mesh = 6", "mesh = 6 \0"),
    ("key twice", "mesh = 6", "mesh = 6\nmesh = 7"),
    ("name that leaves the directory", "\"small\"", "\"../../small\""),
    ("empty name", "\"small\"", "\"\""),
    ("no name", "name = \"small\"\n", ""),
    ("unknown table", "[numerics]", "[numerik]"),
    ("misspelt key", "radius =", "raduis ="),
    ("wrong unit", "80 GPa", "80 mm"),
    ("unknown unit", "50 mm", "50 furlong"),
    ("unit in the wrong case", "80 GPa", "80 gpa"),
    ("number in quotes", "mu = 0.3", "mu = \"0.3\""),
    ("NaN", "\"50 mm\"", "nan"),
    ("infinity", "\"50 mm\"", "inf"),
    ("overflow", "\"50 mm\"", "\"1e999 mm\""),
    ("negative length", "\"50 mm\"", "\"-50 mm\""),
    ("Poisson above a half", "poisson = [0.0, 0.3]", "poisson = [0.0, 0.6]"),
    ("negative friction", "mu = [0.05, ", "mu = [-0.05, "),
    ("misspelt shape", "\"sphere\"", "\"spere\""),
    ("shape with the wrong keys", "\"sphere\"", "\"cone\""),
    ("missing radius", ", radius = \"50 mm\"", ""),
    ("no step", "[{ approach = \"20 um\" }]", "[]"),
    ("force as approach", "20 um", "20 kN"),
    ("mesh of 0", "mesh = 6", "mesh = 0"),
    ("broken mesh", "mesh = 6", "mesh = 6.5"),
    ("monstrous mesh", "mesh = 6", "mesh = 4000000000"),
    ("mesh beyond every integer", "mesh = 6", "mesh = 99999999999999999999"),
    ("tolerance of 1", "mesh = 6", "mesh = 6\ntolerance = 1"),
    ("unknown method", "mesh = 6", "mesh = 6\nmethod = \"newton\""),
    ("empty axis", "[0.05, 0.2, 0.6]", "[]"),
    ("axis that repeats itself", "[0.05, 0.2, 0.6]", "[0.05, 0.2, 0.20]"),
    ("axis of words", "[0.05, 0.2, 0.6]", "[\"low\", \"high\"]"),
    ("axis on nothing", "friction.mu = [", "friction.nu = ["),
    ("range without count", "[0.05, 0.2, 0.6]", "{ from = 0.1, to = 0.2 }"),
    ("logarithmic range from 0", "[0.05, 0.2, 0.6]", "{ log = true, from = 0, to = 0.2, count = 3 }"),
    ("more points than anybody waits for", "[0.05, 0.2, 0.6]", "{ from = 0.1, to = 0.2, count = 4000000000 }"),
    ("zip of unequal lengths", "friction.mu = [0.05, 0.2, 0.6]", "[[sweep.zip]]\nfriction.mu = [0.1, 0.2]\nmesh = [6]"),
    ("figure over an unknown column", "stick_fraction", "stick_fracton"),
    (
        "height map without its file",
        "shape = \"sphere\", radius = \"50 mm\"",
        "shape = \"height-map\", file = \"gone.npy\", width_x = 1, width_y = 1",
    ),
];

#[test]
fn refused_studies_say_where_and_leave_nothing() {
    let place = Place::empty();
    let sound = Place::run();
    let before = sound.call("query small --format csv").out;
    let mut said = String::new();
    for (name, old, new) in REFUSED {
        assert!(SMALL.contains(old), "{name}");
        let text = SMALL.replacen(old, new, 1);
        place.write("bad.toml", &text);
        for words in [&["run", "bad.toml"][..], &["plan", "bad.toml"], &["solve", "bad.toml"]] {
            let refused = place.words(words);
            assert_eq!((refused.code, refused.out.as_str()), (1, ""), "{name}: {words:?}");
            let position = refused.err.split_once("--> bad.toml:").map(|(_, rest)| rest.lines().next().unwrap().split(':'));
            let position: Vec<u32> = position.unwrap_or_else(|| panic!("{name}: {}", refused.err)).map(|n| n.parse().unwrap()).collect();
            assert_eq!(position.len(), 2, "{name}");
            if words[0] == "run" {
                said += &format!("## {name}\n{}\n", refused.err);
            } else if words[0] == "plan" {
                assert!(said.ends_with(&format!("{}\n", refused.err)), "{name}: run and plan disagree");
            }
        }
        assert_eq!(place.files(), [(place.path("bad.toml"), text.as_bytes().to_vec())], "{name}");
        sound.write("bad.toml", &text);
        assert_eq!(sound.call("run bad.toml").code, 1);
    }
    insta::assert_snapshot!(said);
    assert_eq!(sound.call("query small --format csv").out, before);
    assert_eq!(sound.json("store verify --json")["sound"], true);
}

#[test]
fn files_that_are_no_study_at_all() {
    let place = Place::empty();
    place.write("latin1.toml", b"name = \"caf\xe9\"");
    place.write("deep.toml", "a = ".to_owned() + &"[".repeat(100_000));
    place.write("twice.toml", SMALL.replace("mesh = 6", "mesh = [6, 7, 8]"));
    fs::create_dir(place.path("folder.toml")).unwrap();
    let files = place.files();
    let names = ["gone.toml", "folder.toml", "latin1.toml", "deep.toml", "twice.toml"];
    let mut said = String::new();
    for name in names {
        let refused = place.words(&["run", name]);
        assert_eq!(refused.code, 1, "{name}: {}", refused.err);
        let short: String = refused.err.lines().map(|line| line.chars().take(200).collect::<String>() + "\n").collect();
        said += &format!("## {name}\n{short}\n");
    }
    insta::assert_snapshot!(said);
    assert_eq!(place.files(), files);
}

#[test]
fn damage_to_a_file_of_fields_is_found() {
    let place = Place::run();
    assert_eq!(place.call("store verify").code, 0);
    let (fields, _) = place.blobs();
    let mut bytes = fs::read(&fields[0]).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&fields[0], bytes).unwrap();
    fs::remove_file(&fields[1]).unwrap();
    let verified = place.call("store verify");
    assert_eq!(verified.code, 2);
    insta::assert_snapshot!(without_hashes(&verified.out));
    assert_eq!(place.json("store verify --json")["faults"].as_array().map(Vec::len), Some(2));
    // exactly the two results concerned have no field to show any more, and say so
    let shown: Vec<Said> = place.keys().iter().map(|key| place.words(&["show", key, "--field", "gap"])).collect();
    let mut errors: Vec<String> = shown.iter().filter(|said| said.code == 1).map(|said| without_hashes(&said.err)).collect();
    errors.sort();
    insta::assert_snapshot!("fields_that_are_lost", errors.concat());
    assert_eq!(errors.len(), 2);
}

#[test]
fn a_damaged_study_is_found() {
    let place = Place::run();
    let (_, study) = place.blobs();
    fs::write(&study, b"rubbish").unwrap();
    let verified = place.call("store verify");
    assert_eq!(verified.code, 2);
    let queried = place.call("query small");
    assert_eq!(queried.code, 1);
    insta::assert_snapshot!(without_hashes(&format!("{}{}", verified.transcript(), queried.transcript())));
    // the study file is still there and the results are too
    let again = place.call("run small.toml --json");
    assert_eq!(again.code, 0, "{}", again.err);
    assert_eq!(serde_json::from_str::<Value>(&again.out).unwrap()["run"]["cached"], 6);
    assert_eq!(place.json("store verify --json")["sound"], true);
}

#[test]
fn a_truncated_database_is_never_read_as_a_smaller_one() {
    let place = Place::run();
    let database = place.path(".tribosweep/records/db");
    let whole = fs::metadata(&database).unwrap().len();
    fs::File::options().write(true).open(&database).unwrap().set_len(whole / 2).unwrap();
    for line in ["store verify", "store compact", "status", "query small", "plan small.toml", "run small.toml", "resume small"] {
        let refused = place.call(line);
        assert_eq!(refused.code, 1, "{line}: {}", refused.out);
        assert!(refused.err.contains("is damaged") && refused.err.contains("salvage"), "{line}: {}", refused.err);
    }
    let salvaged = place.json("store salvage --json");
    assert_eq!(salvaged["studies"], 1);
    assert!(place.path(salvaged["damaged"].as_str().unwrap()).exists());
    let run = place.call("run small.toml --workers 1 --json");
    assert_eq!(run.code, 0, "{}", run.err);
    let summary: Value = serde_json::from_str(run.out.lines().last().unwrap()).unwrap();
    assert_eq!(summary["run"]["cached"], salvaged["kept"]);
    assert_eq!(place.json("store verify --json")["sound"], true);
}

#[test]
fn compact_removes_what_nothing_refers_to() {
    let place = Place::run();
    let before = place.call("query small --format csv").out;
    assert_eq!(place.call("run small.toml --workers 1").code, 0);
    // an edited study leaves its former definition behind
    place.write("small.toml", SMALL.replace("Does it slip?", "Does it stick?"));
    assert_eq!(place.call("run small.toml").code, 0);
    insta::assert_snapshot!(place.transcript(&[
        &["store", "verify"],
        &["store", "compact"],
        &["store", "compact"],
        &["store", "verify"],
        &["store", "salvage"],
        &["store", "verify"],
    ]));
    assert_eq!(place.call("query small --format csv").out, before);
}

#[test]
fn a_directory_of_other_things_is_not_a_store() {
    let place = Place::with("small.toml", SMALL);
    fs::create_dir(place.path("holiday")).unwrap();
    place.write("holiday/photo.jpg", b"beach");
    let before = place.files();
    let lines: Vec<Vec<&str>> = [
        &["run", "small.toml"][..],
        &["resume", "small"],
        &["status"],
        &["query", "small"],
        &["store", "verify"],
        &["store", "compact"],
        &["store", "salvage"],
    ]
    .iter()
    .flat_map(|words| ["holiday", "small.toml"].map(|store| [words, &["--store", store][..]].concat()))
    .collect();
    let lines: Vec<&[&str]> = lines.iter().map(Vec::as_slice).collect();
    insta::assert_snapshot!(place.transcript(&lines));
    for words in lines {
        assert_eq!(place.words(words).code, 1, "{words:?}");
    }
    assert_eq!(place.files(), before);
}

/// A process that does not outlive its test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_store_in_use_is_read_through_the_run() {
    // far more work than the test waits for: it is the test that ends the run
    let many = SMALL.replace("mesh = 6", "mesh = 32").replace("[0.05, 0.2, 0.6]", "{ from = 0.05, to = 0.6, count = 2000 }");
    let place = Place::with("many.toml", many.replace("\"small\"", "\"many\""));
    place.write("small.toml", SMALL);
    let log = place.path("events.jsonl");
    let words = ["run", "many.toml", "--workers", "1", "--json"];
    let mut run = Running(place.command(&words).stdout(fs::File::create(&log).unwrap()).stderr(Stdio::piped()).spawn().unwrap());
    let deadline = Instant::now() + Duration::from_secs(60);
    while !fs::read_to_string(&log).unwrap().contains("\"committed\"") {
        assert!(Instant::now() < deadline && run.0.try_wait().unwrap().is_none(), "the run commits nothing");
        std::thread::sleep(Duration::from_millis(10));
    }
    insta::assert_snapshot!(place.transcript(&[&["run", "small.toml"], &["resume", "many"], &["store", "verify"], &["store", "salvage"]]));

    let served = format!("served by the running process {} (", run.0.id());
    let status = place.call("status --json");
    assert!(status.err.starts_with(&served), "{}", status.err);
    let listed: Value = serde_json::from_str(&status.out).unwrap();
    assert_eq!((&listed[0]["study"], &listed[0]["progress"]["points"]), (&"many".into(), &4000.into()));
    assert!(listed[0]["progress"]["done"].as_u64().unwrap() > 0);
    let query = place.words(&["query", "many", "--where", "status == \"certified\"", "--select", "key", "--format", "csv"]);
    assert!(query.err.starts_with(&served), "{}", query.err);
    let key = query.out.lines().nth(1).expect("one result is there").to_owned();
    let shown = place.words(&["show", &key, "--field", "pressure"]);
    assert_eq!((shown.code, shown.err.starts_with(&served)), (0, true), "{}", shown.err);
    assert_eq!(place.json("plan many.toml --json")["points"], 4000);

    rustix::process::kill_process(rustix::process::Pid::from_child(&run.0), rustix::process::Signal::INT).unwrap();
    assert_eq!(run.0.wait().unwrap().code(), Some(130));
    let mut err = String::new();
    run.0.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert_eq!(err, "");
    let text = fs::read_to_string(&log).unwrap();
    let summary: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
    assert_eq!((&summary["event"], &summary["run"]["interrupted"]), (&"summary".into(), &true.into()));
    // what was reported done is there, and the store is free again
    let done = text.lines().filter(|line| line.contains("\"event\":\"done\"")).count();
    assert_eq!(place.json("status --json")[0]["progress"]["done"], done);
    assert_eq!(place.json("plan many.toml --json")["cached"], done);
    assert_eq!(place.json("store verify --json")["sound"], true);
}

/// A matrix of heights as an NPY file.
fn npy(rows: usize, columns: usize, heights: &[f64]) -> Vec<u8> {
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    header += &" ".repeat(63 - (header.len() + 10) % 64);
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.bytes());
    heights.iter().for_each(|height| bytes.extend(height.to_le_bytes()));
    bytes
}

#[test]
fn height_maps_stand_beside_the_study_and_are_kept() {
    let heights = [0.0, 0.25, 0.5, 0.25, 0.5, 0.75, 0.5, 0.75, 1.0];
    let text: String = heights.chunks(3).map(|row| format!("{}, {}, {}\n", row[0], row[1], row[2])).collect();
    let place = Place::empty();
    fs::create_dir(place.path("studies")).unwrap();
    place.write("studies/one.toml", ONE.replace("mesh = 6", "mesh = 6\nmax_iterations = 1"));
    let gone = place.call("run studies/one.toml");
    place.write("studies/rough.csv", "1, 2\n3\n");
    let ragged = place.call("run studies/one.toml");
    assert!(!place.path(".tribosweep").exists());

    place.write("studies/rough.csv", &text);
    assert_eq!(place.call("run studies/one.toml").code, 2, "one iteration is not enough");
    // the same heights under another name and in another format are the same job
    place.write("studies/other.toml", ONE.replace("rough.csv", "rough.npy").replace("\"one\"", "\"other\""));
    place.write("studies/rough.npy", npy(3, 3, &heights));
    place.write("studies/one.toml", ONE);
    assert_eq!(place.call("run studies/other.toml").code, 0);
    assert_eq!(place.json("plan studies/one.toml --json")["to_run"], 0);

    // `one` in the store is still the study of one iteration; without any file it is computed again from its kept heights
    fs::remove_dir_all(place.path("studies")).unwrap();
    let resumed = place.call("resume one --retry-failed --json");
    let summary: Value = serde_json::from_str(resumed.out.lines().last().unwrap()).unwrap();
    assert_eq!((resumed.code, &summary["run"]["computing"]), (2, &1.into()), "{}", resumed.err);
    let kept = place.json("query other --json --select load,status");
    assert_eq!(kept["rows"][0]["status"], "certified");
    assert_eq!(place.call("store compact").code, 0);
    assert_eq!(place.call("resume one --retry-failed").code, 2, "compacting keeps the heights");
    insta::assert_snapshot!(gone.err + "\n" + &ragged.err);
}
