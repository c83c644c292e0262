//! A page followed literally: the files that it makes, the commands that it types.

use std::fs;
use std::path::Path;

use clap::error::{ContextKind, ErrorKind};

use super::expected::is_met;
use super::page::{Block, Page};
use super::{ROOT, files_below};
use crate::place::{Place, redacted};

/// A command with what the page says that it prints.
struct Typed<'page> {
    command: String,
    expected: Vec<&'page str>,
}

/// Follows a page from an empty directory, and returns where it is not true.
pub(super) fn follow(page: &Page) -> Vec<String> {
    let place = Place::empty();
    // A page that names the repository's studies is read in the repository.
    if page.blocks.iter().any(|block| block.text.contains("sweeps/")) {
        copy(&Path::new(ROOT).join("sweeps"), &place.path("sweeps"));
    }
    let mut findings = Vec::new();
    let mut written = page.text.clone();
    let mut grown = 0;
    for block in &page.blocks {
        let before = findings.len();
        if let Some(file) = block.marked("# file:") {
            place.write(file, &block.text);
            if block.language == "toml"
                && let Some(said) = unplanned(&place, file)
                && !is_shown(page, file, &said)
            {
                findings.push(said);
            }
        } else if let Some(file) = block.marked("# change:") {
            findings.extend(change(&place, file, block));
        } else if block.language == "console" {
            let (printed, wrong) = session(&place, block);
            if std::env::var_os("UPDATE_BOOK").is_some() {
                let at = |index: usize| (index as isize + grown) as usize;
                written.replace_range(at(block.range.start)..at(block.range.end), &printed);
                grown += printed.len() as isize - block.text.len() as isize;
            } else {
                findings.extend(wrong);
            }
        } else if let Some(study) = block.language.strip_prefix("toml into ") {
            findings.extend(unfit(&place, study, block));
        } else if block.language == "toml" {
            findings.push("the study has no name: `# file: NAME` in its first line".to_owned());
        }
        for finding in &mut findings[before..] {
            *finding = format!("{}: {finding}", page.place(block.line));
        }
    }
    if written != page.text {
        fs::write(&page.path, written).unwrap();
    }
    findings
}

fn copy(from: &Path, to: &Path) {
    for file in files_below(from) {
        let target = to.join(file.strip_prefix(from).unwrap());
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::copy(&file, target).unwrap();
    }
}

/// Types the commands of a block, and returns the block with what was printed now, and what differs.
fn session(place: &Place, block: &Block) -> (String, Vec<String>) {
    let mut printed = String::new();
    let mut findings = Vec::new();
    let mut code = 0;
    let commands = typed(&block.text);
    for (index, Typed { command, expected }) in commands.iter().enumerate() {
        let said = place.said(&mut place.shell(&format!("(exit {code})\n{command}")));
        code = said.code;
        printed.push_str(&format!("$ {}\n", command.replace('\n', "\n> ")));
        // A line `...` by itself would be met by anything.
        let is_compared = expected[..] != ["..."];
        if is_compared && is_met(expected, &said.out.lines().collect::<Vec<_>>()) {
            printed.extend(expected.iter().map(|line| format!("{line}\n")));
        } else {
            printed.push_str(&hidden(&said.out));
            findings.push(format!(
                "$ {command}\nprints\n{}instead of\n{}\n",
                said.out,
                expected.join("\n")
            ));
        }
        // A failure is what a reader sees as one: an error, or the code that is asked for next.
        let is_shown = expected.first().is_some_and(|line| line.starts_with("error:"))
            || commands.get(index + 1).is_some_and(|next| next.command == "echo $?");
        if code != 0 && !is_shown {
            findings.push(format!("$ {command}\nends with {code}\n{}", said.out));
        }
    }
    (printed, findings)
}

/// Returns the commands of a block: lines after `$`, gone on with after `>`, and what stands below.
fn typed(block: &str) -> Vec<Typed<'_>> {
    let mut commands: Vec<Typed> = Vec::new();
    for line in block.lines() {
        match (line.strip_prefix("$ "), commands.last_mut()) {
            (Some(command), _) => {
                commands.push(Typed { command: command.to_owned(), expected: Vec::new() });
            }
            (None, Some(last)) => match line.strip_prefix("> ") {
                Some(more) if last.expected.is_empty() => {
                    last.command += "\n";
                    last.command += more;
                }
                _ => last.expected.push(line),
            },
            (None, None) => panic!("a session begins with a command: {line}"),
        }
    }
    commands
}

/// Returns an output with wildcards for what differs from run to run.
fn hidden(output: &str) -> String {
    let mut text = redacted(output);
    for name in ["[time]", "[n]", "[part]", "[pid]", "[size]", "[version]"] {
        text = text.replace(name, "[..]");
    }
    text
}

/// Returns why a study cannot be planned.
fn unplanned(place: &Place, file: &str) -> Option<String> {
    let said = place.call(&format!("plan {file} --store nowhere"));
    (said.code != 0).then_some(said.err)
}

/// Tells whether a page plans a file itself and shows just this error, because the mistake in it is
/// there to be seen.
fn is_shown(page: &Page, file: &str, error: &str) -> bool {
    let mut sessions = page.blocks.iter().filter(|block| block.language == "console");
    sessions.any(|session| {
        typed(&session.text).iter().any(|Typed { command, expected }| {
            let is_of_file = command.split_whitespace().any(|word| word == file);
            let is_error = expected.first().is_some_and(|line| line.starts_with("error:"));
            is_of_file && is_error && is_met(expected, &error.lines().collect::<Vec<_>>())
        })
    })
}

/// Makes a change of a file that a page asks for: pairs of lines `# from:` and `# to:`.
fn change(place: &Place, file: &str, block: &Block) -> Option<String> {
    let mut text = fs::read_to_string(place.path(file)).ok()?;
    let mut from = None;
    for line in block.text.lines().skip(1) {
        if let Some(old) = line.strip_prefix("# from: ") {
            from = Some(old);
        } else if let (Some(new), Some(old)) = (line.strip_prefix("# to: "), from.take()) {
            if text.matches(old).count() != 1 {
                return Some(format!("`{old}` does not stand in {file} once"));
            }
            text = text.replace(old, new);
        } else {
            return Some(format!("no change: {line}"));
        }
    }
    place.write(file, text);
    None
}

/// Returns why a part of a study does not fit into the study that it is meant for.
fn unfit(place: &Place, study: &str, block: &Block) -> Option<String> {
    let text = fs::read_to_string(place.path(study)).ok()?;
    let mut whole: toml::Table = text.parse().unwrap();
    let part: toml::Table = match block.text.parse() {
        Ok(part) => part,
        Err(error) => return Some(error.to_string()),
    };
    merge(&mut whole, part);
    // Beside the study, because it may name files.
    let file = Path::new(study).with_file_name("with-part.toml");
    place.write(file.to_str().unwrap(), toml::to_string(&whole).unwrap());
    let finding = unplanned(place, file.to_str().unwrap());
    place.remove(file.to_str().unwrap());
    finding
}

fn merge(whole: &mut toml::Table, part: toml::Table) {
    for (key, value) in part {
        match (whole.get_mut(&key), value) {
            (Some(toml::Value::Table(there)), toml::Value::Table(more)) => merge(there, more),
            (_, value) => {
                whole.insert(key, value);
            }
        }
    }
}

/// Returns the commands of a page outside of its sessions that the program does not understand.
pub(super) fn misunderstood(page: &Page) -> Vec<String> {
    let mut findings = Vec::new();
    let blocks = page.blocks.iter().filter(|block| block.language != "console");
    let texts = blocks.map(|block| (block.line, block.text.replace("\\\n", " "), false));
    let words = page.words.iter().map(|words| (words.line, words.text.replace('\n', " "), true));
    for (line, text, is_prose) in texts.chain(words) {
        let commands =
            text.lines().filter_map(|line| line.trim_start().strip_prefix("tribosweep "));
        for command in commands {
            if let Some(fault) = fault(command, is_prose) {
                findings.push(format!("{}: {command}\n{fault}", page.place(line)));
            }
        }
    }
    findings
}

/// Returns what is wrong with a command, given without the program's name.
///
/// It is parsed whole, with the arguments that it requires. Not covered are values in capitals,
/// which are to be filled in, what a command says of its arguments after they are parsed, and
/// scripts with variables. The line of usage of the reference, with `[OPTIONS]` and `<STUDY>`, and
/// words of a text that only name a command are held against the names of commands alone.
fn fault(command: &str, is_prose: bool) -> Option<String> {
    // What stands behind two blanks or a sharp is a remark.
    let command = command.split("  ").next().unwrap();
    let command = command.split(" # ").next().unwrap();
    let Some(words) = shlex::split(command) else { return Some("a quote is not closed".into()) };
    // What a script's variables stand for is not known here.
    if words.iter().any(|word| word.contains('$')) {
        return None;
    }
    // The shell keeps what stands behind these for itself and for other programs.
    let is_of_program = |word: &&str| ![">", "|", "&&", "||", "&", ";", "2>&1"].contains(word);
    let words: Vec<&str> = words.iter().map(String::as_str).take_while(is_of_program).collect();
    let is_missing = |file: &&&str| file.starts_with("sweeps/") && !in_repository(file);
    if let Some(file) = words.iter().find(is_missing) {
        return Some(format!("{file} is not there"));
    }
    let rest = arguments(&words);
    let is_form = rest.first().is_some_and(|word| word.starts_with(['[', '<']));
    if is_form || is_prose && rest.is_empty() && !words.is_empty() {
        return None;
    }
    let parsed = tribosweep::usage().try_get_matches_from([&["tribosweep"], &words[..]].concat());
    let error = parsed.err()?;
    let is_to_be_filled_in = |value: &str| {
        value.starts_with(|c: char| c.is_ascii_uppercase())
            && value
                .chars()
                .all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || "_-".contains(c))
    };
    let value = error.get(ContextKind::InvalidValue).map(ToString::to_string);
    let is_excused = match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => true,
        ErrorKind::InvalidValue | ErrorKind::ValueValidation => {
            value.is_some_and(|value| is_to_be_filled_in(&value))
        }
        _ => false,
    };
    (!is_excused).then(|| error.to_string())
}

/// Returns the words behind the names of commands.
fn arguments<'words, 'text>(words: &'words [&'text str]) -> &'words [&'text str] {
    let usage = tribosweep::usage();
    let mut command = &usage;
    for (index, word) in words.iter().enumerate() {
        match command.find_subcommand(word) {
            Some(below) => command = below,
            None => return &words[index..],
        }
    }
    &[]
}

fn in_repository(file: &str) -> bool {
    Path::new(ROOT).join(file).is_file()
}

#[test]
fn a_command_that_lacks_something_is_found() {
    for (command, part) in [
        ("query", "required"),
        ("submit STUDY.toml", "--shards"),
        ("submit STUDY.toml --shards many", "many"),
        ("run STUDY.toml --untill 5m", "--untill"),
        ("runs STUDY.toml", "runs"),
        ("run [STUDY]", ""),
        ("store verifi", "verifi"),
        ("run sweeps/nothing.toml", "is not there"),
    ] {
        let fault = fault(command, false);
        match part {
            "" => assert_eq!(fault, None),
            part => {
                assert!(fault.as_ref().is_some_and(|it| it.contains(part)), "{command} {fault:?}")
            }
        }
    }
    assert_eq!(fault("submit STUDY.toml --shards N", false), None);
    assert_eq!(fault("query NAME --format csv > NAME.csv", false), None);
    assert_eq!(fault("query", true), None);
    assert!(fault("querry", true).is_some());
}
