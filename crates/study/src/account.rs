//! The account of a run: everything that its records share about their origin.
//!
//! It is kept once for each run, as JSON in a file of its own, and records name it by its digest
//! ([`Provenance::run`](crate::Provenance::run)). A result is whole without it.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

/// The largest account that is read \[bytes\]. A command line has at most 2 MiB, and its bytes may
/// be written as numbers.
pub const ACCOUNT_LIMIT: u64 = 32 << 20;

/// The number of digits by which runs and commits are called in tables.
const SHORT: usize = 12;

/// The account of a run.
///
/// A field that an earlier version of the program did not write is empty, and one that a later
/// version adds is passed over.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct RunAccount {
    /// The program that ran.
    pub program: ProgramBuild,
    /// The machine on which it ran.
    pub machine: MachineAccount,
    /// The words of the command line, the first of which is the name of the program.
    pub command: Vec<CommandWord>,
    /// The time at which the run began [s since 1970-01-01 UTC].
    pub started: u64,
    /// The study that was run.
    pub study: StudyOrigin,
}

/// The source from which the program was built.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct ProgramBuild {
    /// The version.
    pub version: String,
    /// The commit of its source in full; `None` if it was not built from a repository.
    pub commit: Option<String>,
    /// True if a file from which it is built differed from the commit, or was not in it.
    pub dirty: Option<bool>,
}

/// The machine on which a run took place, as its system says.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct MachineAccount {
    /// The name of the host.
    pub host: String,
    /// The model of the processor.
    pub processor: String,
    /// The processors that the run was allowed to use.
    pub cores: u64,
    /// The operating system with its version, the kernel and the architecture.
    pub system: String,
}

/// A word of a command line, which need not be text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum CommandWord {
    /// A text.
    Text(String),
    /// The bytes of a word that is no text in UTF-8.
    Bytes(Vec<u8>),
}

/// The origin of a study.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct StudyOrigin {
    /// The name.
    pub name: String,
    /// The study file; `None` for a study that came from the store alone.
    pub file: Option<HashedFile>,
    /// The BLAKE3 digest of the study's text and of the files that it names, whatever their paths.
    pub definition: String,
    /// The files that the study names, by the names that it gives them.
    pub files: Vec<HashedFile>,
}

/// A file and what stood in it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct HashedFile {
    /// The path as it was given.
    pub name: String,
    /// The BLAKE3 digest of the bytes, in hexadecimal digits.
    pub blake3: String,
    /// The size \[bytes\].
    pub bytes: u64,
}

impl HashedFile {
    /// Returns a file with the digest of its bytes.
    pub fn of(name: &str, bytes: &[u8]) -> Self {
        let blake3 = blake3::hash(bytes).to_hex().to_string();
        Self { name: name.to_owned(), blake3, bytes: bytes.len() as u64 }
    }
}

impl ProgramBuild {
    /// Returns the beginning of the commit, with `-dirty` if the source differed from it; `None`
    /// if the commit is not known.
    pub fn short_commit(&self) -> Option<String> {
        let commit = self.commit.as_deref()?;
        let end = commit.char_indices().nth(SHORT).map_or(commit.len(), |(end, _)| end);
        let dirty = if self.dirty == Some(true) { "-dirty" } else { "" };
        Some(format!("{}{dirty}", &commit[..end]))
    }
}

impl RunAccount {
    /// Returns the bytes that are kept. Equal accounts have equal bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        serde_json::to_vec(self).expect("an account is plain data")
    }

    /// Reads the bytes of an account; `None` if they are none.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        serde_json::from_slice(bytes).ok()
    }
}

/// Returns the digits by which a run is called, given its digest: the first of those by which its
/// file is named.
pub fn run_name(digest: &[u8; 32]) -> String {
    digest.iter().take(SHORT / 2).fold(String::new(), |mut name, byte| {
        // Writing to a string does not fail.
        let _ = write!(name, "{byte:02x}");
        name
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn account() -> RunAccount {
        RunAccount {
            program: ProgramBuild {
                version: "0.1.0".into(),
                commit: Some("0123456789abcdef".into()),
                dirty: Some(true),
            },
            machine: MachineAccount {
                host: "node7".into(),
                processor: "A Processor".into(),
                cores: 8,
                system: "Linux".into(),
            },
            command: vec![
                CommandWord::Text("tribosweep".into()),
                CommandWord::Text("a\u{1b}\n\"".into()),
                CommandWord::Bytes(vec![b'a', 0xff]),
            ],
            started: 1_700_000_000,
            study: StudyOrigin {
                name: "small".into(),
                file: Some(HashedFile::of("small.toml", b"name")),
                definition: "d".into(),
                files: vec![HashedFile::of("map.npy", b"")],
            },
        }
    }

    #[test]
    fn an_account_is_read_back_whatever_its_command_line_holds() {
        assert_eq!(RunAccount::parse(&account().to_bytes()), Some(account()));
        assert_eq!(account().to_bytes(), account().to_bytes());
    }

    /// A change of these bytes is a change of what earlier versions of the program have written.
    #[test]
    fn golden_account() {
        insta::assert_snapshot!(String::from_utf8(account().to_bytes()).unwrap());
    }

    #[test]
    fn what_other_versions_write_is_read() {
        let read = |text: &str| RunAccount::parse(text.as_bytes());
        assert_eq!(read("{}"), Some(RunAccount::default()));
        let later = read(r#"{"later": [1], "machine": {"host": "h", "gpu": "g"}}"#).unwrap();
        assert_eq!(later.machine.host, "h");
        assert_eq!((read("[1, 2]"), read("rubbish"), read("")), (None, None, None));
    }

    #[test]
    fn commits_and_runs_have_short_names() {
        assert_eq!(account().program.short_commit().unwrap(), "0123456789ab-dirty");
        let odd = ProgramBuild { commit: Some("µ".into()), ..ProgramBuild::default() };
        assert_eq!(odd.short_commit().as_deref(), Some("µ"));
        assert_eq!(ProgramBuild::default().short_commit(), None);
        assert_eq!(run_name(&[0xab; 32]), "abababababab");
        let empty = "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262";
        assert_eq!(HashedFile::of("a", b"").blake3, empty);
    }
}
