//! Links the program, and tells it from which commit it is built.

#[path = "build/linking.rs"]
mod linking;
#[path = "build/packed_commit.rs"]
mod packed_commit;

use std::path::{Path, PathBuf};
use std::process::Command;

/// The files from which the program is built. Cargo runs this script again when one of them
/// changes, so that what is said of them is never older than the program.
const SOURCES: [&str; 8] = [
    "Cargo.toml",
    "Cargo.lock",
    "build",
    "build.rs",
    "src",
    "crates",
    ":!crates/*/tests",
    ":!crates/*/benches",
];

fn main() {
    link_at_a_fixed_address();
    tell_the_commit();
}

/// Links the program at a fixed address where the linker is known to take the option. A program
/// that can be loaded anywhere has 42 000 addresses to correct before it starts. This takes 0.7 ms:
/// `tribosweep --version` takes 2.1 ms with them and 1.4 ms without, where a small solve takes 5
/// ms. Distributions that want it the other way set `TRIBOSWEEP_PIE=1` (docs/book/src/packaging.md).
fn link_at_a_fixed_address() {
    println!("cargo::rerun-if-env-changed={}", linking::VARIABLE);
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let target = ["ARCH", "OS", "ENV"].map(|part| variable(&format!("CARGO_CFG_TARGET_{part}")));
    let target = target.each_ref().map(String::as_str);
    if let Some(argument) = linking::linker_argument(target, &variable(linking::VARIABLE)) {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}

/// Tells the program its commit, and whether a file from which it is built differs from that or is
/// not in it. In a package of Cargo that is what Cargo noted. Both are empty where there is neither
/// that nor a repository with git, as in a tarball of the sources.
fn tell_the_commit() {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    watch_sources(&root);
    let (mut commit, mut dirty) = (String::new(), "");
    if is_own_repository(&root)
        && let Some(head) = git(&root, &["rev-parse", "HEAD"])
    {
        commit = head;
        // A lock on the index would be in the way of whoever is working there.
        let status =
            ["--no-optional-locks", "status", "--porcelain", "--untracked-files=all", "--"];
        dirty = match git(&root, &[&status[..], &SOURCES[..]].concat()) {
            Some(changes) if changes.is_empty() => "false",
            Some(_) => "true",
            None => "",
        };
        watch_head(&root);
    } else if let Ok(note) = std::fs::read_to_string(root.join(".cargo_vcs_info.json"))
        && let Some(noted) = packed_commit::packed_commit(&note)
    {
        (commit, dirty) = noted;
    }
    println!("cargo::rustc-env=TRIBOSWEEP_COMMIT={commit}");
    println!("cargo::rustc-env=TRIBOSWEEP_DIRTY={dirty}");
}

/// Lets Cargo run this script again when a source changes, but not when a test does: then nothing
/// of the program is built again either.
fn watch_sources(root: &Path) {
    let mut watched: Vec<PathBuf> = ["Cargo.toml", "Cargo.lock", "build", "build.rs", "src"]
        .map(|name| root.join(name))
        .to_vec();
    let crates = std::fs::read_dir(root.join("crates")).into_iter().flatten().flatten();
    for entry in crates.flat_map(|entry| std::fs::read_dir(entry.path())).flatten().flatten() {
        let name = entry.file_name();
        if name != "tests" && name != "benches" {
            watched.push(entry.path());
        }
    }
    watched.sort();
    watch(watched);
}

/// Lets Cargo run this script again when another commit is checked out or made. The index is not
/// watched: every look at the state of the tree may write it, and what it says follows from files
/// and commits.
fn watch_head(root: &Path) {
    let branch = git(root, &["symbolic-ref", "-q", "HEAD"]);
    let names = ["HEAD", "logs/HEAD", "packed-refs"].into_iter().chain(branch.as_deref());
    let path = |name: &str| Some(root.join(git(root, &["rev-parse", "--git-path", name])?));
    watch(names.filter_map(path));
}

/// Names files to Cargo. One that is not there would let it run this script every time.
fn watch(paths: impl IntoIterator<Item = PathBuf>) {
    for path in paths.into_iter().filter(|path| path.exists()) {
        println!("cargo::rerun-if-changed={}", path.display());
    }
}

/// Returns true if a directory is the root of a repository, and does not just lie in one, as a
/// tarball that was unpacked somewhere may.
fn is_own_repository(root: &Path) -> bool {
    let top = git(root, &["rev-parse", "--show-toplevel"]).map(PathBuf::from);
    let same = |top: PathBuf| Some(top.canonicalize().ok()? == root.canonicalize().ok()?);
    top.and_then(same).unwrap_or(false)
}

/// Returns what git says in a directory, if it says something without a failure.
fn git(root: &Path, arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("git");
    // A build that a hook of another repository starts inherits that one's variables.
    for variable in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX"] {
        command.env_remove(variable);
    }
    let done = command.args(arguments).current_dir(root).output().ok()?;
    let text = String::from_utf8(done.stdout).ok()?;
    done.status.success().then(|| text.trim_end().to_owned())
}
