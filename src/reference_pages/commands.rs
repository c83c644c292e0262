//! The commands, as the parser of the command line knows them.

use clap::{Arg, Command, CommandFactory};

use super::markdown::{WRITTEN, code, head, row, sentence};
use crate::cli::Cli;

/// Writes the page of the commands.
pub(crate) fn commands_page() -> String {
    let mut program = Cli::command();
    program.build();
    let mut page = format!("{WRITTEN}# Commands\n\n");
    page += &about(&program);
    page += &after(&program);
    page += "\nEvery command has `--help`.\n";
    for command in program.get_subcommands().filter(|command| !command.is_hide_set()) {
        page += &section(&["tribosweep"], command);
    }
    page
}

/// Writes the section of a command, and those of the commands below it.
fn section(above: &[&str], command: &Command) -> String {
    let path = [above, &[command.get_name()]].concat();
    let mut text = format!("\n## `{}`\n\n{}", path.join(" "), about(command));
    if command.has_subcommands() {
        let below = command.get_subcommands().filter(|below| below.get_name() != "help");
        return below.fold(text, |text, below| text + &section(&path, below));
    }
    let usage = command.clone().render_usage().to_string();
    text += &format!("```text\n{}\n```\n\n", usage.trim_start_matches("Usage: ").trim());
    let is_shown = |arg: &&Arg| !arg.is_hide_set() && arg.get_id() != "help";
    let arguments: Vec<&Arg> = command.get_arguments().filter(is_shown).collect();
    if !arguments.is_empty() {
        text += &head(&["argument", "default", "meaning"]);
        for argument in arguments {
            text += &argument_row(argument);
        }
        text += "\n";
    }
    text + &after(command)
}

/// Writes the row of an argument.
fn argument_row(argument: &Arg) -> String {
    let values = argument.get_value_names().unwrap_or_default();
    let values: Vec<&str> = values.iter().map(|name| name.as_str()).collect();
    let name = match argument.get_long() {
        Some(long) if argument.get_action().takes_values() => {
            format!("--{long} {}", values.join(" "))
        }
        Some(long) => format!("--{long}"),
        None => values.join(" "),
    };
    let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
    // A default that is no value stands in the help.
    let (mut help, mut default) = match help.split_once(" [default: ") {
        Some((help, default)) => (help.to_owned(), default.trim_end_matches(']').to_owned()),
        None => (help, String::new()),
    };
    let written: Vec<&str> =
        argument.get_default_values().iter().filter_map(|value| value.to_str()).collect();
    if argument.get_action().takes_values() && !written.is_empty() {
        default = code(&written.join(" "));
    }
    if default.is_empty() && argument.is_required_set() {
        default = "must be given".to_owned();
    }
    help = sentence(&help);
    let choices: Vec<String> = argument
        .get_possible_values()
        .iter()
        .filter(|value| !value.is_hide_set() && argument.get_action().takes_values())
        .map(|value| match value.get_help() {
            Some(meaning) => {
                format!("{} ({})", code(value.get_name()), lower(&meaning.to_string()))
            }
            None => code(value.get_name()),
        })
        .collect();
    if !choices.is_empty() {
        help += &format!(" One of {}.", choices.join(", "));
    }
    if let Some(variable) = argument.get_env().and_then(|name| name.to_str()) {
        help += &format!(" The variable `{variable}` of the environment stands for it.");
    }
    row(&[&code(&name), &default, &help])
}

/// Writes what a command does.
fn about(command: &Command) -> String {
    let about = command.get_about().map(ToString::to_string).unwrap_or_default();
    format!("{}\n\n", sentence(&about))
}

/// Writes what stands below the help of a command: examples as code, and the rest as it is.
fn after(command: &Command) -> String {
    let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let mut written = String::new();
    for paragraph in text.split("\n\n").filter(|paragraph| !paragraph.is_empty()) {
        match paragraph.split_once('\n') {
            Some((title, examples)) if title.ends_with(':') => {
                let examples: Vec<&str> = examples.lines().map(str::trim_start).collect();
                written += &format!("{title}\n\n```sh\n{}\n```\n\n", commented(&examples));
            }
            _ => written += &format!("{paragraph}\n\n"),
        }
    }
    written.trim_end().to_owned() + "\n"
}

/// Writes examples with what is said of them as comments.
fn commented(examples: &[&str]) -> String {
    let line = |example: &&str| match example.split_once("     ") {
        Some((command, remark)) => format!("{}  # {}", command.trim_end(), remark.trim()),
        None => (*example).to_owned(),
    };
    examples.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Begins a sentence in the middle of another.
fn lower(sentence: &str) -> String {
    let mut letters = sentence.chars();
    let first = letters.next();
    match (first, letters.clone().next()) {
        // An abbreviation keeps its capitals.
        (Some(first), Some(second)) if !second.is_uppercase() => {
            format!("{}{}", first.to_lowercase(), letters.as_str())
        }
        _ => sentence.to_owned(),
    }
}
