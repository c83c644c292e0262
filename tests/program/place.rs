//! A directory to run the command in, and the output of a run.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;
use store::{OpenError, Store};
use tempfile::TempDir;

pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_tribosweep");
/// Six points in two axes, each a matter of milliseconds.
pub(crate) const SMALL: &str = include_str!("studies/small.toml");
/// One point whose punch is a height map in a file.
pub(crate) const ONE: &str = include_str!("studies/one.toml");

/// Two jobs of 13 increments each: a sphere is pressed, and shifted to and fro twice.
pub(crate) const PATH: &str = include_str!("studies/path.toml");

/// Says on standard error that a test is skipped, past what a test's output is kept for.
pub(crate) fn skip(reason: &str) {
    let test = std::thread::current().name().unwrap_or_default().to_owned();
    let _ = writeln!(std::io::stderr(), "{test} is skipped: {reason}");
}

/// A directory for the command, with a study file or none.
pub(crate) struct Place(TempDir);

/// The end of a command.
pub(crate) struct Said {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Place {
    pub(crate) fn empty() -> Self {
        Self(TempDir::new().unwrap())
    }

    pub(crate) fn with(file: &str, text: impl AsRef<[u8]>) -> Self {
        let place = Self::empty();
        place.write(file, text);
        place
    }

    /// Returns a directory in which the small study has run.
    pub(crate) fn run() -> Self {
        let place = Self::with("small.toml", SMALL);
        assert_eq!(place.call("run small.toml --workers 2").code, 0);
        place
    }

    pub(crate) fn path(&self, file: &str) -> PathBuf {
        self.0.path().join(file)
    }

    pub(crate) fn write(&self, file: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path(file), text).unwrap();
    }

    /// Puts the profiles of a wheel and a rail here, as `w.prw` and `r.prr`.
    pub(crate) fn add_profiles(&self) {
        let profiles = concat!(env!("CARGO_MANIFEST_DIR"), "/sweeps/profiles/");
        for (file, from) in [("w.prw", "MBench_S1002_v3.prw"), ("r.prr", "MBench_UIC60_v3.prr")] {
            std::fs::copy(format!("{profiles}{from}"), self.path(file)).unwrap();
        }
    }

    pub(crate) fn command(&self, words: &[&str]) -> Command {
        let mut command = self.clean(PROGRAM);
        command.args(words);
        command
    }

    /// Returns a shell that runs a line here, with the command on its path and one stream for all
    /// that is said, as a terminal has it.
    pub(crate) fn shell(&self, line: &str) -> Command {
        let mut command = self.clean("sh");
        let programs = Path::new(PROGRAM).parent().unwrap().display();
        command.env("PATH", format!("{programs}:{}", std::env::var("PATH").unwrap()));
        command.args(["-c", &format!("exec 2>&1\n{line}")]);
        command
    }

    /// Returns a program that is to run here, without what another user of this machine has set.
    fn clean(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.current_dir(self.0.path()).stdin(Stdio::null());
        for variable in
            ["TRIBOSWEEP_STORE", "COLUMNS", "NO_COLOR", "CLICOLOR_FORCE", "RUST_BACKTRACE"]
        {
            command.env_remove(variable);
        }
        command
    }

    pub(crate) fn words(&self, words: &[&str]) -> Said {
        self.said(&mut self.command(words))
    }

    /// Runs a command of this place.
    pub(crate) fn said(&self, command: &mut Command) -> Said {
        let output = command.output().unwrap();
        let clean = |bytes: &[u8]| {
            let text = std::str::from_utf8(bytes).unwrap();
            text.replace(PROGRAM, "tribosweep")
                .replace(self.0.path().to_str().unwrap(), "[directory]")
        };
        Said {
            code: output.status.code().expect("ended by itself"),
            out: clean(&output.stdout),
            err: clean(&output.stderr),
        }
    }

    /// Runs the command with words separated by blanks.
    pub(crate) fn call(&self, line: &str) -> Said {
        self.words(&line.split_whitespace().collect::<Vec<_>>())
    }

    pub(crate) fn json(&self, line: &str) -> Value {
        let said = self.call(line);
        serde_json::from_str(&said.out)
            .unwrap_or_else(|error| panic!("{line}: {error}\n{}{}", said.out, said.err))
    }

    /// Returns the output of several commands as a transcript.
    pub(crate) fn transcript(&self, lines: &[&[&str]]) -> String {
        lines
            .iter()
            .map(|words| {
                format!("$ tribosweep {}\n{}\n", words.join(" "), self.words(words).transcript())
            })
            .collect()
    }

    /// Returns the keys of the small study in the order of its points.
    pub(crate) fn keys(&self) -> Vec<String> {
        self.call("query small --select key --format csv")
            .out
            .lines()
            .skip(1)
            .map(str::to_owned)
            .collect()
    }

    /// Returns every file below the directory with its bytes.
    pub(crate) fn files(&self) -> Vec<(PathBuf, Vec<u8>)> {
        fn walk(directory: &Path, files: &mut Vec<(PathBuf, Vec<u8>)>) {
            for entry in fs::read_dir(directory).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    walk(&path, files)
                } else {
                    files.push((path.clone(), fs::read(&path).unwrap()))
                }
            }
        }
        let mut files = Vec::new();
        walk(self.0.path(), &mut files);
        files.sort();
        files
    }

    /// Returns the files with the accounts of the runs that the records of the store name.
    pub(crate) fn accounts(&self) -> Vec<PathBuf> {
        self.accounts_in(".tribosweep")
    }

    /// Returns the files with the accounts of the runs that the records of a store name.
    pub(crate) fn accounts_in(&self, store: &str) -> Vec<PathBuf> {
        let reader = Store::read(&self.path(store)).unwrap();
        let runs: BTreeSet<[u8; 32]> = reader
            .records()
            .unwrap()
            .filter_map(|(_, bytes)| study::Record::decode(&bytes.ok()?).ok()?.provenance.run)
            .collect();
        runs.into_iter().map(|run| reader.blobs().path(&store::Digest(run))).collect()
    }

    /// Returns the files with the fields of results and with the study's definition.
    pub(crate) fn blobs(&self) -> (Vec<PathBuf>, PathBuf) {
        let manifest = fs::read_to_string(self.path(".tribosweep/manifest.json")).unwrap();
        let accounts = self.accounts();
        let digest = |path: &Path| {
            let stem = path.file_stem().unwrap().to_str().unwrap();
            format!("{}{stem}", path.parent().unwrap().file_name().unwrap().to_str().unwrap())
        };
        let blobs = self.files().into_iter().map(|(path, _)| path).filter(|path| {
            path.extension().is_some_and(|e| e == "zst") && !accounts.contains(path)
        });
        let (mut studies, fields): (Vec<_>, Vec<_>) =
            blobs.partition(|path| manifest.contains(&digest(path)));
        assert_eq!(studies.len(), 1);
        (fields, studies.remove(0))
    }

    pub(crate) fn with_files(files: &[(&str, &str)]) -> Self {
        let place = Self::empty();
        for (file, text) in files {
            place.write(file, text);
        }
        place
    }

    pub(crate) fn has(&self, file: &str) -> bool {
        self.path(file).exists()
    }

    pub(crate) fn remove(&self, file: &str) {
        let path = self.path(file);
        if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) }.unwrap();
    }

    /// Returns a program that is to run here, with its temporary files, and without what speaks for
    /// another store.
    pub(crate) fn program(&self, program: &str) -> Command {
        fs::create_dir_all(self.path("tmp")).unwrap();
        let mut command = Command::new(program);
        command.current_dir(self.0.path()).stdin(Stdio::null());
        command.env("TMPDIR", self.path("tmp"));
        for variable in ["TRIBOSWEEP_STORE", "RUST_BACKTRACE"] {
            command.env_remove(variable);
        }
        command
    }

    pub(crate) fn succeed(&self, line: &str) -> String {
        let said = self.call(line);
        assert_eq!(said.code, 0, "{line}\n{}{}", said.out, said.err);
        said.out
    }

    /// Asserts that every column of a study's results that does not say who computed them is byte
    /// for byte the same in two stores, and so is the study's answer.
    pub(crate) fn assert_same(&self, study: &str, store: &str, other: &str) {
        let said = |line: &str, store: &str| {
            // Commands that are proposed name the store.
            self.succeed(&format!("{line} --store {store}")).replace(store, "[store]")
        };
        let columns: Value =
            serde_json::from_str(&said(&format!("query {study} --columns --json"), store)).unwrap();
        let rows = columns["rows"].as_array().unwrap().iter();
        let reproducible: Vec<&str> = rows
            .filter(|row| row["kind"] != "provenance")
            .map(|row| row["column"].as_str().unwrap())
            .collect();
        assert!(reproducible.len() > 10);
        let query = format!("query {study} --format csv --select {}", reproducible.join(","));
        for line in [query, format!("answer {study}")] {
            let (one, other) = (said(&line, store), said(&line, other));
            assert!(one.lines().count() > 1 || line.starts_with("answer"));
            assert!(one == other, "{line}\n{one}\n--\n{other}");
        }
    }

    /// Asserts that an export still has some records, byte for byte. A record says when and where
    /// it was computed, so that none of these jobs was computed again.
    pub(crate) fn assert_kept(&self, records: &BTreeMap<String, Vec<u8>>, export: &str) {
        let present = self.records(export);
        for (key, record) in records {
            assert_eq!(present.get(key), Some(record), "job {key} was computed again");
        }
    }

    /// Returns every record of an export with its key, whole; none if there is no export yet.
    pub(crate) fn records(&self, export: &str) -> BTreeMap<String, Vec<u8>> {
        records_in(&self.path(export))
    }

    /// Returns what the jobs of a submission have said.
    pub(crate) fn logs(&self, directory: &str) -> String {
        let Ok(files) = fs::read_dir(self.path(directory).join("log")) else {
            return String::new();
        };
        let mut paths: Vec<PathBuf> = files.map(|file| file.unwrap().path()).collect();
        paths.sort();
        let read =
            |path: &PathBuf| format!("{}\n{}", path.display(), fs::read_to_string(path).unwrap());
        paths.iter().map(read).collect()
    }
}

/// Returns every record of a store or an export with its key, whole; none if there is none yet.
pub(crate) fn records_in(path: &Path) -> BTreeMap<String, Vec<u8>> {
    match Store::read(path) {
        Ok(reader) => reader
            .records()
            .unwrap()
            .map(|(key, bytes)| (key.to_string(), bytes.unwrap()))
            .collect(),
        Err(OpenError::Missing { .. }) => BTreeMap::new(),
        Err(error) => panic!("{} cannot be read: {error}", path.display()),
    }
}

impl Said {
    pub(crate) fn transcript(&self) -> String {
        let err: String = self.err.lines().map(|line| format!("! {line}\n")).collect();
        redacted(&format!("{}{err}= {}\n", self.out, self.code))
    }
}

/// Returns a text without everything that differs from run to run: times and shares of times,
/// sizes of files, processes, hashes of floating-point fields, the version.
pub(crate) fn redacted(text: &str) -> String {
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
                () if number
                    && next == "%"
                    && words.get(at + 4).is_some_and(|word| word.starts_with("time")) =>
                {
                    "[part]"
                }
                () if number && before == "process" => "[pid]",
                // The account of a run names the host, whose name has any length.
                () if number && ["file", "files"].contains(&before.as_str()) => "[size]",
                () if word == env!("CARGO_PKG_VERSION") => "[version]",
                () => continue,
            };
            words[at] = words[at].replace(&word, new);
            if ["[time]", "[size]"].contains(&new) {
                // The unit goes too; the text after it stays.
                let rest = words[at + 1].replacen(&next, "", 1);
                words[at] += &rest;
                words[at + 1].clear();
            }
        }
        lines.push(
            words
                .join(" ")
                .replace("[time]  ", "[time] ")
                .replace("[time],  ", "[time], ")
                .replace("[size]),  ", "[size]), ")
                .trim_end()
                .to_owned()
                + "\n",
        );
    }
    lines.concat()
}

/// Returns the text without hashes of floating-point fields, and without the folder that begins
/// with one.
pub(crate) fn without_hashes(text: &str) -> String {
    let is_hash = |word: &str| {
        [62, 64].contains(&word.len()) && word.bytes().all(|byte| byte.is_ascii_hexdigit())
    };
    let words = text.split_inclusive(|c: char| !c.is_ascii_alphanumeric()).map(|word| {
        let bare = word.trim_end_matches(|c: char| !c.is_ascii_alphanumeric());
        if is_hash(bare) { word.replace(bare, "[hash]") } else { word.to_owned() }
    });
    let text: String = words.collect();
    let (first, rest) = text.split_once("/blobs/").unwrap_or((&text, ""));
    rest.split("/blobs/").fold(first.to_owned(), |said, part| {
        said + if part.is_empty() { "" } else { "/blobs/[hash]/" } + part.get(3..).unwrap_or(part)
    })
}
