//! A directory to run the command in.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use serde_json::Value;
use store::{OpenError, Store};
use tempfile::TempDir;

pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_tribosweep");

/// Says on standard error that a test is skipped, past what a test's output is kept for.
pub(crate) fn skip(reason: &str) {
    let test = std::thread::current().name().unwrap_or_default().to_owned();
    let _ = writeln!(std::io::stderr(), "{test} is skipped: {reason}");
}

/// A directory with study files.
pub(crate) struct Place(TempDir);

/// The end of a command.
pub(crate) struct Said {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Place {
    pub(crate) fn with(files: &[(&str, &str)]) -> Self {
        let place = Self(TempDir::new().unwrap());
        fs::create_dir(place.path("tmp")).unwrap();
        for (file, text) in files {
            fs::write(place.path(file), text).unwrap();
        }
        place
    }

    pub(crate) fn path(&self, file: &str) -> PathBuf {
        self.0.path().join(file)
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
        let mut command = Command::new(program);
        command.current_dir(self.0.path()).stdin(Stdio::null());
        command.env("TMPDIR", self.path("tmp"));
        for variable in ["TRIBOSWEEP_STORE", "RUST_BACKTRACE"] {
            command.env_remove(variable);
        }
        command
    }

    /// Runs the command with words separated by blanks.
    pub(crate) fn call(&self, line: &str) -> Said {
        let output = self.program(PROGRAM).args(line.split_whitespace()).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Said {
            code: output.status.code().expect("ended by itself"),
            out: text(&output.stdout),
            err: text(&output.stderr),
        }
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
        match Store::read(&self.path(export)) {
            Ok(reader) => reader
                .records()
                .unwrap()
                .map(|(key, bytes)| (key.to_string(), bytes.unwrap()))
                .collect(),
            Err(OpenError::Missing { .. }) => BTreeMap::new(),
            Err(error) => panic!("{export} cannot be read: {error}"),
        }
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
