//! The manual pages that follow from the command line.

use std::io;

use clap::Command;
use clap_mangen::Man;
use clap_mangen::roff::{Roff, bold, roman};

/// The blanks between a command in an example and what is said of it.
const GAP: &str = "     ";

/// A page of the manual.
pub(crate) struct Page {
    /// The name of its file: that of the command with a section.
    pub(crate) file: String,
    /// Its text in the language of `man`.
    pub(crate) text: Vec<u8>,
}

/// Writes a page for a command and one for each command below it, of those that are shown.
pub(crate) fn pages(command: Command) -> io::Result<Vec<Page>> {
    let version = command.get_version().unwrap_or_default().to_owned();
    let mut command = command.disable_help_subcommand(true);
    command.build();
    let mut written = Vec::new();
    write_pages(&command, &format!("tribosweep {version}"), &mut written)?;
    Ok(written)
}

fn write_pages(command: &Command, source: &str, written: &mut Vec<Page>) -> io::Result<()> {
    let shown = command.get_subcommands().filter(|below| !below.is_hide_set());
    for below in shown {
        write_pages(below, source, written)?;
    }
    let man = Man::new(command.clone()).source(source).manual("tribosweep");
    let mut text = Vec::new();
    man.render_title(&mut text)?;
    man.render_name_section(&mut text)?;
    man.render_synopsis_section(&mut text)?;
    man.render_description_section(&mut text)?;
    man.render_options_section(&mut text)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut text)?;
    }
    if let Some(words) = command.get_after_help() {
        after_help(&words.to_string()).to_writer(&mut text)?;
    }
    see_also(command).to_writer(&mut text)?;
    written.push(Page { file: man.get_filename(), text });
    Ok(())
}

/// Renders what stands below the help of a command: sections of examples, whose lines are indented
/// below a heading, and notes.
fn after_help(words: &str) -> Roff {
    let (mut examples, mut notes) = (Roff::default(), Roff::default());
    for paragraph in words.split("\n\n") {
        match paragraph.split_once(":\n") {
            Some((heading, lines)) => {
                examples.control("SH", [heading.to_uppercase().as_str()]);
                lines.lines().for_each(|line| example(&mut examples, line.trim()));
            }
            None => {
                notes.control("PP", []);
                notes.text([roman(paragraph)]);
            }
        }
    }
    if !notes.to_roff().is_empty() {
        examples.control("SH", ["NOTES"]);
    }
    examples.extend([notes]);
    examples
}

/// Renders a command as it is typed, and below it what is said of it.
fn example(roff: &mut Roff, line: &str) {
    let (command, said) = line.split_once(GAP).unwrap_or((line, ""));
    roff.control("PP", []);
    roff.control("nf", []);
    roff.text([bold(command)]);
    roff.control("fi", []);
    if !said.is_empty() {
        roff.control("RS", ["4"]);
        roff.text([roman(said.trim())]);
        roff.control("RE", []);
    }
}

/// Renders the names of the pages next to that of a command.
fn see_also(command: &Command) -> Roff {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name());
    let above = name.rsplit_once('-').map(|(above, _)| format!("{above}(1), "));
    let mut roff = Roff::default();
    roff.control("SH", ["SEE ALSO"]);
    roff.text([roman(format!("{}{}", above.unwrap_or_default(), env!("CARGO_PKG_REPOSITORY")))]);
    roff
}
