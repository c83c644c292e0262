//! The program says names, paths and reasons that come from foreign hands, and proposes commands
//! with them.

use std::process::{Command, Stdio};

use crate::place::{Place, SMALL};

/// Escape sequences, a C1 control and a sign that turns text around, as TOML spells them.
const ESCAPES: &str = r"\u001b]0;x\u0007 \u009b2J \u202egnp.\u2066\nrun it with: rm";

fn assert_harmless(text: &str) {
    let obeyed = |c: char| {
        c != '\n' && c.is_control() || ('\u{202a}'..='\u{202e}').contains(&c) || c == '\u{2066}'
    };
    assert!(!text.contains(obeyed), "{text:?}");
}

#[test]
fn a_terminal_gets_nothing_to_obey() {
    let kept = SMALL.lines().filter(|line| !line.starts_with("question"));
    let study = format!("question = \"{ESCAPES}\"\n{}\n", kept.collect::<Vec<_>>().join("\n"));
    let place = Place::with("small.toml", study);
    for line in [
        "plan small.toml",
        "run small.toml",
        "status",
        "answer small",
        "query small",
        "query small --json",
        "status --json",
        "plan small.toml --json",
        "query small --where x",
    ] {
        let said = place.call(line);
        assert_harmless(&said.out);
        assert_harmless(&said.err);
        assert!(!said.out.lines().any(|line| line.trim_start().starts_with("run it with: rm")));
    }
    assert!(place.call("status").out.contains(r"\u{1b}]0;x\u{7}"));
    // JSON means what the study says.
    let json = place.json("status --json");
    let question = json[0]["question"].as_str().unwrap();
    assert!(question.starts_with("\u{1b}]0;x\u{7} \u{9b}2J \u{202e}"), "{question:?}");
    for words in [
        ["query", "no\u{1b}[2Jne"],
        ["plan", "no\u{1b}[2Jne.toml"],
        ["show", "\u{1b}[2J"],
        ["plot", "--x=\u{1b}[2J"],
        ["solve", "--\u{1b}[2J"],
    ] {
        let said = place.words(&words);
        assert_eq!(said.code, 1);
        assert_harmless(&said.err);
    }
    let said = place.words(&["query", "small", "--where", "\"\u{1b}[2J\u{202e}\" == mu"]);
    assert_harmless(&said.err);
}

/// Runs a command in a shell, as if it had been pasted.
fn pasted(place: &Place, command: &str) -> i32 {
    let program = env!("CARGO_BIN_EXE_tribosweep");
    let script = format!("tribosweep() {{ \"$PROGRAM\" \"$@\"; }}; {command}");
    let mut shell = Command::new("bash");
    shell.args(["-c", &script]).env("PROGRAM", program).current_dir(place.path("."));
    let status = shell.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status();
    status.unwrap().code().unwrap()
}

/// Returns the command that a line with some words proposes at its end.
fn proposed<'t>(text: &'t str, words: &str) -> &'t str {
    let line = text.lines().find(|line| line.contains(words));
    let line = line.unwrap_or_else(|| panic!("no `{words}` in {text}"));
    &line[line.find("tribosweep ").expect("a command is proposed")..]
}

#[test]
fn commands_that_are_proposed_can_be_pasted() {
    let place = Place::empty();
    let folder = "a b';$(touch x)&\t";
    std::fs::create_dir(place.path(folder)).unwrap();
    let failing = SMALL.replace("mesh = 6", "mesh = 6\nmax_iterations = 2");
    let file = format!("{folder}/-s t.toml");
    place.write(&file, failing);
    let store = format!("{folder}/store");
    let said = place.words(&["run", &file, "--store", &store]);
    assert_eq!(said.code, 2);
    let show = proposed(&said.out, "6 failed, the first: not converged in 2 iterations");
    assert!(show.contains(" --store "), "{show}");
    assert_eq!(pasted(&place, show), 0, "{show}");
    let query = proposed(&said.out, "all 6 failed jobs");
    assert_eq!(pasted(&place, query), 0, "{query}");
    let said = place.words(&["solve", &file]);
    let command = said.err.split_once("with `").unwrap().1.trim_end();
    let run = command.strip_suffix('`').unwrap();
    assert_eq!(pasted(&place, run), 2, "{run}");
    assert!(!place.path("x").exists() && !place.path(folder).join("x").exists());
    // The store that a variable names is not the one that a command finds by itself.
    let mut command = place.command(&["run", &file, "--store", ".tribosweep"]);
    let output = command.env("TRIBOSWEEP_STORE", "elsewhere").output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(proposed(&said, "6 failed, the first").ends_with(" --store .tribosweep"), "{said}");
}
