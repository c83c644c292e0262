//! Accounts of runs: this run's, and their words.

use std::ffi::OsStr;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use store::Digest;
use study::account::{CommandWord, HashedFile, ProgramBuild, RunAccount, StudyOrigin, run_name};
use study::{Record, Study};

use crate::machine::{command_line, this_machine, this_program};
use crate::words::time_words;

/// Returns the account of the run of a study in this process, from a file or from a store alone.
pub(crate) fn this_run(study: &Study, file: Option<HashedFile>) -> RunAccount {
    let definition = study.definition();
    let content = Study::definition_content(&definition).unwrap_or(definition);
    RunAccount {
        program: this_program(),
        machine: this_machine(),
        command: command_line(),
        started: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
        study: StudyOrigin {
            name: study.name().to_owned(),
            file,
            definition: Digest::of(&content).to_string(),
            files: study.named_files().map(|(name, bytes)| HashedFile::of(name, bytes)).collect(),
        },
    }
}

/// Returns a study file with the digest of its text.
pub(crate) fn study_file(path: &Path, text: &str) -> HashedFile {
    HashedFile::of(&path.display().to_string(), text.as_bytes())
}

/// Returns the program in a few words: its version, and its commit if that is known.
pub(crate) fn program_words(program: &ProgramBuild) -> String {
    match program.short_commit() {
        Some(commit) => format!("{} (commit {commit})", program.version),
        None => format!("{} (commit unknown)", program.version),
    }
}

/// Returns a command line that can be pasted into a shell.
pub(crate) fn command_words(command: &[CommandWord]) -> String {
    let words: Vec<String> = command
        .iter()
        .map(|word| match word {
            CommandWord::Text(text) => wording::shell_word(text),
            CommandWord::Bytes(bytes) => wording::shell_word(os_word(bytes)),
        })
        .collect();
    words.join(" ")
}

fn os_word(bytes: &[u8]) -> &OsStr {
    use std::os::unix::ffi::OsStrExt;
    OsStr::from_bytes(bytes)
}

/// Returns what an account says beside the columns of a table, as names and values.
pub(crate) fn account_lines(account: &RunAccount) -> Vec<[String; 2]> {
    let RunAccount { program, machine, command, started, study } = account;
    let dirty = match (&program.commit, program.dirty) {
        (None, _) => "unknown",
        (Some(_), Some(true)) => "differed from the commit when the program was built",
        (Some(_), Some(false)) => "as in the commit",
        (Some(_), None) => "not known to be as in the commit",
    };
    let file = match &study.file {
        Some(file) => file_words(file),
        None => "none; the study's text came from elsewhere".to_owned(),
    };
    let mut lines = [
        ("source", dirty.to_owned()),
        ("cores", machine.cores.to_string()),
        ("system", machine.system.clone()),
        ("command", command_words(command)),
        ("started", time_words(*started)),
        ("study_file", file),
        ("definition", format!("blake3 {}", study.definition)),
    ]
    .map(|(name, value)| [name.to_owned(), wording::one_line(&value).into_owned()])
    .to_vec();
    lines.extend(study.files.iter().map(|file| ["file".to_owned(), file_words(file)]));
    lines
}

/// Returns a file in words, with its digest.
pub(crate) fn file_words(file: &HashedFile) -> String {
    let HashedFile { name, blake3, bytes } = file;
    format!("{}, {bytes} B, blake3 {blake3}", wording::one_line(name))
}

/// Says why nothing more is known of the origin of a record than what it holds itself.
pub(crate) fn unknown_account(record: &Record) -> String {
    match &record.provenance.run {
        Some(run) => {
            format!("the account of its run, file {}, is lost or damaged", Digest(*run))
        }
        None => "unknown: the record names no run, as those of earlier versions do not".to_owned(),
    }
}

/// Returns the account of a run as JSON, under the digest by which records name it.
pub(crate) fn account_json(run: &[u8; 32], account: Option<&RunAccount>) -> serde_json::Value {
    serde_json::json!({
        "run": run_name(run),
        "digest": Digest(*run).to_string(),
        "account": account,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_line_that_holds_anything_is_shown_on_one_line() {
        let command = [
            CommandWord::Text("tribosweep".to_owned()),
            CommandWord::Text("a b\u{1b}[2J\n".to_owned()),
            CommandWord::Bytes(vec![b'x', 0xff]),
        ];
        assert_eq!(command_words(&command), r"tribosweep $'a b\033[2J\012' $'x\377'");
        let account = RunAccount { command: command.to_vec(), ..RunAccount::default() };
        let lines = account_lines(&account);
        assert!(lines.iter().flatten().all(|text| wording::one_line(text) == *text), "{lines:?}");
    }

    #[test]
    fn a_program_says_its_commit_or_that_it_is_unknown() {
        let mut program = ProgramBuild { version: "0.1.0".to_owned(), ..ProgramBuild::default() };
        assert_eq!(program_words(&program), "0.1.0 (commit unknown)");
        program.commit = Some("0123456789abcdef".to_owned());
        program.dirty = Some(true);
        assert_eq!(program_words(&program), "0.1.0 (commit 0123456789ab-dirty)");
    }
}
