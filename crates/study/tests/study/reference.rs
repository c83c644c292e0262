//! The reference of the study file: whatever it says is what happens. What is in it is accepted,
//! what is not in it is refused, and its defaults and bounds are those of the code.

use study::columns::{Role, along_path};
use study::reference::{
    ReferenceColumn, ReferenceKey, columns, matching, matching_columns, nearest_key, reference,
    units,
};
use study::units::{Dimension, quantity};
use study::{Kind, Study};

use crate::jobs::stored;
use crate::scaffold::{Scaffold, keys_of, read};

/// Returns the example of a key. The hash of a surface is that of one which is there.
fn example(key: &ReferenceKey) -> String {
    match key.path.as_str() {
        "scene.punch.surface" => format!("\"{}\"", stored().0),
        _ => key.example.to_owned(),
    }
}

/// The findings that differ from what the reference says; all are told in the end.
#[derive(Default)]
struct Findings(Vec<String>);

impl Findings {
    fn accepted(&mut self, text: &str, what: &str) -> Option<Study> {
        let read = read(text).map_err(|error| self.0.push(format!("{what}\n{error}\n{text}")));
        read.ok()
    }

    fn refused(&mut self, text: &str, what: &str) {
        if read(text).is_ok() {
            self.0.push(format!("{what} was not refused:\n{text}"));
        }
    }

    /// Notes two texts that are not the same study.
    fn same(&mut self, first: &str, second: &str, what: &str) {
        let told = [first, second].map(|text| Some(told(&self.accepted(text, what)?)));
        if told[0] != told[1] {
            self.0.push(format!("{what}: two studies\n{first}\n{second}"));
        }
    }

    fn tell(self) {
        assert!(self.0.is_empty(), "{}", self.0.join("\n"));
    }
}

/// Returns everything by which studies differ but their texts.
fn told(study: &Study) -> String {
    let keys: Vec<String> = study.points().iter().map(|point| point.key.to_string()).collect();
    let (adaptive, figures) = (study.adaptive(), study.figures());
    format!("{keys:?} {adaptive:?} {figures:?} {:?} {:?}", study.cost(), study.sensitivity())
}

/// Returns values just inside of the bounds of a key and values just outside of them.
fn at_bounds(key: &ReferenceKey) -> [Vec<String>; 2] {
    let is_whole = key.values.starts_with("a whole number");
    let is_list = key.values.starts_with("a list");
    let written = |x: f64| match (is_list, is_whole) {
        (true, _) => entries(key, x as usize),
        (_, true) => format!("{x}"),
        _ => format!("{x:e}"),
    };
    let near = |x: f64, sign: f64| match is_whole || is_list {
        true => x + sign,
        false => x + sign * (x.abs() * 1e-9).max(1e-9),
    };
    let (mut inside, mut outside) = (Vec::new(), Vec::new());
    for (end, inwards) in [(key.bounds.lower, 1.0), (key.bounds.upper, -1.0)] {
        let Some(end) = end else { continue };
        // To check so many points takes long.
        let makes_points = is_list || key.path == "sweep.KEY.count" || key.path == "sample.count";
        if end.number < 1e5 || !makes_points {
            inside.push(if end.is_allowed { end.number } else { near(end.number, inwards) });
        }
        outside.push(if end.is_allowed { near(end.number, -inwards) } else { end.number });
    }
    if key.bounds.skips_zero {
        inside.extend([-1e-9, 1e-9]);
        outside.push(0.0);
    }
    [inside, outside].map(|values| values.into_iter().map(written).collect())
}

/// Returns a list of so many entries like that of the example.
fn entries(key: &ReferenceKey, count: usize) -> String {
    let inner = key.example.trim_start_matches('[').trim_end_matches(']');
    let entry = |index: usize| match key.example.starts_with("[[") {
        true => format!("[{}]", inner.split(']').next().unwrap_or_default()),
        false if inner.starts_with('{') => format!("{}}}", inner.split('}').next().unwrap()),
        false if inner.starts_with('"') => inner.split(',').next().unwrap_or_default().to_owned(),
        // Numbers that are drawn differ from each other.
        false => format!("0.{}1", index + 1),
    };
    let entries: Vec<String> = (0..count).map(entry).collect();
    format!("[{}]", entries.join(", "))
}

#[test]
fn every_key_of_a_scene_is_accepted_with_its_example_and_its_bounds() {
    let mut findings = Findings::default();
    for (_, key) in keys_of(true) {
        let scaffold = Scaffold::around(&key);
        let with = |value: &str| scaffold.with(&key.path, value);
        let what = |value: &str| format!("{} = {value}", key.path);
        findings.accepted(&with(&example(&key)), &what(&example(&key)));
        let [inside, outside] = at_bounds(&key);
        for value in inside {
            findings.accepted(&with(&value), &what(&value));
        }
        for value in outside {
            findings.refused(&with(&value), &what(&value));
        }
        if let Some(default) = &key.default {
            findings.same(&scaffold.text(), &with(default), &what(default));
            assert_ne!(*default, example(&key), "{}: the example shows nothing", key.path);
        } else if key.left_out == "must be given" {
            findings.refused(&scaffold.text(), &format!("nothing in the place of {}", key.path));
        }
    }
    findings.tell();
}

#[test]
fn defaults_that_depend_on_the_kind_are_those_of_the_kinds() {
    let mut findings = Findings::default();
    let mut count = 0;
    for (_, key) in keys_of(true) {
        for of_kind in &key.defaults_of_kinds {
            let scaffold = Scaffold::of_kind(of_kind.kind);
            let given = scaffold.with(&key.path, &of_kind.default.to_string());
            findings.same(&scaffold.text(), &given, &key.path);
            let other = scaffold.with(&key.path, &(of_kind.default + 1).to_string());
            assert_ne!(told(&read(&other).unwrap()), told(&read(&given).unwrap()));
            count += 1;
        }
    }
    assert_eq!(count, 4);
    findings.tell();
}

/// An axis sets a key that the scene leaves out, and so do a sample and a formula, where the
/// reference says that they may; elsewhere they are refused.
#[test]
fn keys_are_varied_where_the_reference_says_so() {
    let mut findings = Findings::default();
    for (_, key) in keys_of(true) {
        let scaffold = Scaffold::around(&key);
        // An entry must be there to be varied.
        let path = key.path.replace("[i]", "[0]");
        let mut text = scaffold.text();
        if path.contains("layers[0].") || path.contains("steps[0].") {
            let list = path.split("[0]").next().unwrap();
            if !text.contains(&format!("{list} = ")) {
                text += &format!("{list} = [{{}}]\n");
            }
        }
        let short = key.short.replace("[i]", "[0]");
        let value = example(&key);
        let formula = formula(&value);
        for (table, line) in [
            ("[sweep]", format!("[sweep]\n\"{short}\" = [{value}]\n")),
            (
                "[sample.keys]",
                format!(
                    "[sample]\nmethod = \"sobol\"\ncount = 1\n[sample.keys]\n\"{short}\" = {{ values = [{value}] }}\n"
                ),
            ),
            ("[derive]", format!("[derive]\n\"{short}\" = \"{formula}\"\n")),
        ] {
            let text = format!("{text}{line}");
            match key.varied_by.contains(&table) {
                true => drop(findings.accepted(&text, &format!("{} by {table}", key.path))),
                false => findings.refused(&text, &format!("{} by {table}", key.path)),
            }
        }
    }
    findings.tell();
}

/// Writes a value as a formula, which has one unit behind each number: `20 m / (1 s)`.
fn formula(value: &str) -> String {
    let text = value.trim_matches('"');
    let (number, unit) = text.split_once(' ').unwrap_or((text, ""));
    match (unit.split_once('/'), unit.split_once(' ')) {
        (Some(("1", below)), _) => format!("{number} / (1 {below})"),
        (Some((above, below)), _) => format!("{number} {above} / (1 {below})"),
        (None, Some((first, second))) => format!("{number} {first} * (1 {second})"),
        (None, None) => text.to_owned(),
    }
}

/// Returns the text of a study with a table that has some lines.
fn with_table(path: &str, name: &str, lines: &[String]) -> String {
    let scene = Scaffold::beside(path, name).text();
    let axis = "[sweep]\n\"friction.mu\" = [0.1, 0.2, 0.3]\n";
    let drawn = "[sample]\nmethod = \"sobol\"\ncount = 4\n[sample.keys]\n\"punch.radius\" = { from = 1e-3, to = 1e-2 }\n";
    let joined = lines.join("\n");
    let inline = lines.join(", ");
    match path {
        "" => format!("{joined}\n{}", scene.split_once('\n').unwrap().1),
        "sweep" | "sweep.zip" | "sample.keys" | "derive" => {
            let of = match path {
                "derive" => "loading.steps[0].shift_x",
                _ => "friction.mu",
            };
            let joined = joined.replace("KEY", &format!("\"{of}\""));
            let heading = match path {
                "sweep.zip" => "[[sweep.zip]]".to_owned(),
                "sample.keys" => {
                    "[sample]\nmethod = \"sobol\"\ncount = 4\n[sample.keys]".to_owned()
                }
                _ => format!("[{path}]"),
            };
            let scene = scene.replace("shift_x = 0", "twist = 0");
            format!("{scene}{heading}\n{joined}\n")
        }
        "sweep.KEY" => format!("{scene}[sweep]\n\"friction.mu\" = {{ {inline} }}\n"),
        "sample.keys.KEY" => format!(
            "{scene}[sample]\nmethod = \"sobol\"\ncount = 4\n[sample.keys]\n\"friction.mu\" = {{ {inline} }}\n"
        ),
        "convergence" | "cost" => {
            let scene = scene.replace("numerics.mesh = 16\n", "");
            format!("{scene}[sweep]\nmesh = [8, 16, 32]\n[{path}]\n{joined}\n")
        }
        "sensitivity" => {
            let method = if joined.contains("morris") { "random" } else { "sobol" };
            format!("{scene}{}[{path}]\n{joined}\n", drawn.replace("sobol", method))
        }
        "branch" => format!("{scene}[branch]\n{joined}\n"),
        "sample" => format!("{scene}[sample]\n{joined}\n"),
        "points" | "accuracy" => format!("{scene}[{path}]\n{joined}\n"),
        "exclude" | "keep" | "figure" => format!("{scene}{axis}[[{path}]]\n{joined}\n"),
        _ => format!("{scene}{axis}[{path}]\n{joined}\n"),
    }
}

/// Returns what stands beside a key of a table, as lines with the examples of other keys.
fn beside(path: &str, name: &str, keys: &[ReferenceKey]) -> Vec<String> {
    let named: &[&str] = match (path, name) {
        ("", _) => &["name"],
        ("fill", _) => &["column", "axis", "to"],
        ("figure", "band") => &["x"],
        ("figure", "bins" | "share") => &["x", "kind"],
        ("figure", _) => &["x", "y"],
        ("sample.keys.KEY", "distribution") => &["mean", "deviation"],
        ("sample.keys.KEY", "mode") => &["from", "to"],
        ("sample.keys.KEY", "from") => &["to"],
        ("sample.keys.KEY", "to") => &["from"],
        ("sample.keys.KEY", "mean" | "deviation") => &["distribution", "mean", "deviation"],
        ("sample.keys.KEY", "median" | "log_deviation") => &["median", "log_deviation"],
        ("sample.keys.KEY", "weights") => &["values"],
        ("sample.keys.KEY", "file" | "column") => &["file", "column"],
        ("sample.keys.KEY", _) => &[],
        ("sweep" | "sensitivity", _) => &[],
        _ => {
            let needed = keys.iter().filter(|key| key.left_out == "must be given");
            let others = needed.filter(|key| key.name != name);
            return others.map(|key| format!("{} = {}", key.name, key.example)).collect();
        }
    };
    let mut lines: Vec<String> = keys
        .iter()
        .filter(|key| named.contains(&key.name) && key.name != name)
        .map(|key| match (path, name, key.name) {
            ("figure", "bins" | "share", "kind") => "kind = \"histogram\"".to_owned(),
            _ => format!("{} = {}", key.name, key.example),
        })
        .collect();
    match (path, name) {
        ("sample.keys.KEY", "mode") => lines.push("distribution = \"triangular\"".to_owned()),
        ("sample.keys.KEY", "median" | "log_deviation") => {
            lines.push("distribution = \"log-normal\"".to_owned());
        }
        ("sensitivity", "levels") => lines.push("method = \"morris\"".to_owned()),
        _ => {}
    }
    lines
}

/// The keys without which others take their place, or which only some forms of their table need.
const NEEDED_BY_SOME: [&str; 7] = [
    "figure.x",
    "figure.y",
    "sample.keys.KEY.values",
    "sample.keys.KEY.mode",
    "sweep.KEY",
    "derive.KEY",
    "accuracy.of",
];

#[test]
fn every_key_of_the_other_tables_is_accepted_with_its_example_and_its_bounds() {
    let mut findings = Findings::default();
    for table in reference() {
        for key in table.keys.iter().filter(|key| key.column.is_none()) {
            let (path, lines) = (table.path, beside(table.path, key.name, &table.keys));
            let with = |value: &str| {
                let line = format!("{} = {value}", key.name);
                with_table(path, key.name, &[&lines[..], &[line]].concat())
            };
            let what = |value: &str| format!("{} = {value}", key.path);
            if (path, key.name) == ("", "kind") {
                let with = |kind| Scaffold::of_kind(kind).text();
                findings.accepted(&with("uniqueness"), &what("\"uniqueness\""));
                let default = key.default.as_deref().unwrap();
                let given = with("solve");
                let left_out = given.replace(&format!("kind = {default}\n"), "");
                assert!(left_out.len() < given.len());
                findings.same(&left_out, &given, &what(default));
                continue;
            }
            findings.accepted(&with(key.example), &what(key.example));
            let [inside, outside] = at_bounds(key);
            for value in inside {
                findings.accepted(&with(&value), &what(&value));
            }
            for value in outside {
                findings.refused(&with(&value), &what(&value));
            }
            let left_out = || with_table(path, key.name, &lines);
            match &key.default {
                Some(default) => findings.same(&left_out(), &with(default), &what(default)),
                None if key.left_out == "must be given"
                    && !NEEDED_BY_SOME.contains(&key.path.as_str()) =>
                {
                    findings.refused(&left_out(), &format!("nothing in the place of {}", key.path));
                }
                None => {}
            }
        }
    }
    findings.tell();
}

/// Whatever a reader accepts is in the lists by which it reads, and these are the reference.
#[test]
fn what_is_in_no_list_is_refused() {
    let mut findings = Findings::default();
    for table in reference() {
        for unknown in ["nothing", "KEY"] {
            let line = format!("{unknown} = 1");
            let text = match table.keys.first().and_then(|key| key.column.as_ref()) {
                Some(_) => {
                    let path = format!("{}.{unknown}", table.path);
                    Scaffold::around(&table.keys[0]).with(&path, "1")
                }
                None => {
                    let mut lines = beside(table.path, unknown, &table.keys);
                    lines.push(line);
                    match table.path {
                        "" => format!("{unknown} = 1\n{}", Scaffold::of_kind("solve").text()),
                        path => with_table(path, unknown, &lines)
                            .replace("\"friction.mu\" = 1", "KEY = 1"),
                    }
                }
            };
            findings.refused(&text, &format!("{unknown} in {}", table.heading));
        }
    }
    findings.tell();
}

#[test]
fn every_unit_of_a_key_is_accepted() {
    let mut findings = Findings::default();
    assert!(units().len() >= 8);
    for (_, key) in keys_of(true).into_iter().filter(|(_, key)| key.values.starts_with("a ")) {
        let is_number = !key.values.starts_with("a list") && !key.values.starts_with("a unit");
        for unit in key.units.iter().filter(|_| is_number) {
            let value = format!("\"1 {unit}\"");
            let scaffold = Scaffold::around(&key);
            // A degree is an angle of a cone, and a radian is none.
            if key.path != "scene.punch.angle" || *unit == "deg" {
                findings.accepted(&scaffold.with(&key.path, &value), &key.path);
            }
        }
    }
    findings.tell();
    assert!(quantity("1 parsec", Dimension::Length).is_err());
}

#[test]
fn keys_are_found_by_path_column_table_and_part() {
    let paths = |pattern: &str| {
        let tables = matching(pattern);
        let keys = tables.iter().flat_map(|table| &table.keys);
        keys.map(|key| key.path.clone()).collect::<Vec<_>>()
    };
    for name in ["friction.mu", "scene.friction.mu", "mu"] {
        assert_eq!(paths(name), ["scene.friction.mu"]);
    }
    assert_eq!(paths("loading.steps[3].shift_x"), ["scene.loading.steps[i].shift_x"]);
    for (column, path) in [
        ("shift_x", "scene.loading.steps[i].shift_x"),
        ("step1_shift_x", "scene.loading.steps[i].shift_x"),
        ("step0_increments", "scene.loading.steps[i].increments"),
        ("layer0_thickness", "scene.foundation.layers[i].thickness"),
        ("layer12_thickness", "scene.foundation.layers[i].thickness"),
    ] {
        assert_eq!(paths(column), [path], "{column}");
    }
    let columns = |path: &str| {
        let key = matching(path)[0].keys[0].clone();
        (key.column, key.second_column)
    };
    let named = |name: &str| Some(name.to_owned());
    assert_eq!(columns("friction.mu"), (named("mu"), None));
    assert_eq!(columns("loading.steps[0].shift_x"), (named("shift_x"), named("step1_shift_x")));
    assert_eq!(
        columns("foundation.layers[0].thickness"),
        (named("layer0_thickness"), named("layer1_thickness"))
    );
    assert_eq!(columns("bisect.to"), (None, None));
    assert_eq!(paths("bisect"), ["bisect.axis", "bisect.on", "bisect.to"]);
    assert!(paths("loading").len() > 20);
    assert!(paths("youngs").len() == 3);
    assert!(paths("nothing at all").is_empty());
    assert_eq!(nearest_key("friction coefficient").as_deref(), Some("friction.mu"));
}

/// The meanings in the list read as sentences, and no path stands twice.
#[test]
fn every_entry_says_something() {
    let mut seen = std::collections::HashSet::new();
    for table in reference() {
        assert!(!table.meaning.is_empty() && !table.keys.is_empty(), "{}", table.path);
        for key in table.keys {
            assert!(seen.insert(key.path.clone()), "{} is listed twice", key.path);
            assert!(!key.meaning.is_empty() && !key.values.is_empty(), "{}", key.path);
            assert!(!key.left_out.is_empty(), "{}", key.path);
        }
    }
}

/// The reference has every column of every kind of study and no other.
#[test]
fn every_column_of_every_kind_is_listed() {
    let listed = columns();
    for kind in Kind::ALL {
        for column in along_path(kind.columns([], [])).into_iter().chain(kind.columns([], [])) {
            let is_meant = |known: &&ReferenceColumn| {
                known.name == column.name
                    && known.meaning == column.meaning
                    && known.unit == column.unit()
                    && known.kinds.contains(&kind.name())
            };
            let is_key = matches!(column.role, Role::Axis | Role::Key);
            assert_eq!(listed.iter().filter(is_meant).count(), usize::from(!is_key), "{column:?}");
        }
    }
    assert_eq!(matching_columns("stick_fraction").len(), 1);
    assert_eq!(matching_columns("residual").len(), 2);
    assert!(matching_columns("von_mises").len() > 5);
}
