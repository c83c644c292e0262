//! The recipes of images are read, not built: what they install has a package in Debian, what they
//! copy is in the tree, and their bases are named by tags.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::place::skip;

fn root() -> PathBuf {
    env!("CARGO_MANIFEST_DIR").into()
}

fn read(file: &str) -> String {
    std::fs::read_to_string(root().join(file)).unwrap()
}

/// What a recipe takes from elsewhere.
#[derive(Debug, Default)]
struct Recipe {
    /// The images that it begins with.
    bases: Vec<String>,
    /// The packages of Debian that it installs.
    packages: Vec<String>,
    /// The paths of the tree that it copies.
    copied: Vec<String>,
    /// The paths of the tree that it copies by way of the directory in which it builds.
    handed_on: Vec<String>,
}

/// The directory in which both recipes build.
const SOURCE: &str = "/source/";

/// Returns the packages that a line of shell installs.
fn installed(line: &str) -> Vec<String> {
    let parts = line.split("&&").filter_map(|part| part.split_once("apt-get install "));
    let words = parts.flat_map(|(_, words)| words.split_whitespace());
    words.filter(|word| !word.starts_with('-')).map(str::to_owned).collect()
}

/// Reads a Dockerfile.
fn dockerfile(text: &str) -> Recipe {
    let mut recipe = Recipe::default();
    let text: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    let mut stages = Vec::new();
    for line in text.join("\n").replace("\\\n", " ").lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["FROM", base, "AS", stage] => {
                recipe.bases.push(base.to_owned());
                stages.push(stage);
            }
            ["FROM", base] => recipe.bases.push(base.to_owned()),
            ["RUN", ..] => recipe.packages.extend(installed(line)),
            ["COPY", first, ref rest @ .., _] => match first.strip_prefix("--from=") {
                Some(stage) => {
                    assert!(stages.contains(&stage), "no stage is called {stage}");
                    recipe.handed_on.extend(rest.iter().map(|&path| path.to_owned()));
                }
                None => {
                    recipe.copied.push(first.to_owned());
                    recipe.copied.extend(rest.iter().map(|&path| path.to_owned()));
                }
            },
            [] | ["WORKDIR" | "ENTRYPOINT" | "CMD" | "ENV" | "LABEL", ..] => {}
            _ => panic!("`{line}` is no instruction that this test knows"),
        }
    }
    recipe
}

/// Reads a recipe of Apptainer.
fn definition(text: &str) -> Recipe {
    let mut recipe = Recipe::default();
    let mut section = "";
    for line in text.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty()) {
        if line.starts_with('%') {
            section = line;
        } else if let Some((key, value)) = line.split_once(": ").filter(|_| !line.starts_with(' '))
        {
            section = "";
            match key {
                "From" => recipe.bases.push(value.to_owned()),
                "Bootstrap" => assert_eq!(value, "docker"),
                "Stage" => {}
                _ => panic!("`{line}` is no head that this test knows"),
            }
        } else {
            let words: Vec<&str> = line.split_whitespace().collect();
            match section {
                "%files" => recipe.copied.push(words[0].to_owned()),
                "%files from build" => recipe.handed_on.push(words[0].to_owned()),
                "%post" => recipe.packages.extend(installed(line)),
                "%runscript" | "%labels" | "%environment" => {}
                _ => panic!("`{line}` stands in no section that this test knows"),
            }
        }
    }
    recipe
}

fn recipes() -> [(&'static str, Recipe); 2] {
    [
        ("containers/Dockerfile", dockerfile(&read("containers/Dockerfile"))),
        ("containers/tribosweep.def", definition(&read("containers/tribosweep.def"))),
    ]
}

#[test]
fn bases_are_named_by_tags_and_have_the_oldest_toolchain_that_builds() {
    let toolchain = read("Cargo.toml");
    let oldest = toolchain.lines().find_map(|line| line.strip_prefix("rust-version = ")).unwrap();
    let rust = format!("rust:{}-slim-bookworm", oldest.trim_matches('"'));
    for (file, recipe) in recipes() {
        // The C library of the image that runs must not be older than that of the one that builds.
        assert_eq!(recipe.bases, [rust.as_str(), "debian:bookworm-slim"], "{file}");
    }
}

/// Tells whether a line of `.dockerignore` leaves out a path or the directories in which it stands.
fn leaves_out(line: &str, path: &str) -> bool {
    assert!(!line.starts_with('!'), "`{line}` takes something back, which is not known here");
    let line = line.trim_matches('/');
    let (is_anywhere, parts) = match line.strip_prefix("**/") {
        Some(rest) => (true, rest.split('/')),
        None => (false, line.split('/')),
    };
    let pattern: Vec<&str> = parts.collect();
    assert!(pattern.iter().all(|part| *part != "**"), "`{line}` is not known here");
    let names: Vec<&str> = path.split('/').collect();
    let mut begins = if is_anywhere { 0..names.len() } else { 0..1 };
    begins.any(|from| {
        let rest = &names[from..];
        rest.len() >= pattern.len()
            && pattern.iter().zip(rest).all(|(part, name)| is_like(part, name))
    })
}

/// Tells whether a name is that of a pattern in which `*` stands for anything.
fn is_like(pattern: &str, name: &str) -> bool {
    assert!(!pattern.contains(['?', '[', '\\']), "`{pattern}` is not known here");
    match pattern.split_once('*') {
        None => pattern == name,
        Some((begin, rest)) => name.strip_prefix(begin).is_some_and(|name| {
            (0..=name.len()).any(|from| name.get(from..).is_some_and(|end| is_like(rest, end)))
        }),
    }
}

#[test]
fn a_line_of_dockerignore_leaves_out_what_it_names_and_what_is_below() {
    for (line, path, is_out) in [
        ("target", "target", true),
        ("target", "src", false),
        ("target", "src/target", false),
        ("/python", "python/src", true),
        ("src/*.rs", "src/lib.rs", true),
        ("src/*.rs", "src/lib.py", false),
        ("src/lib.rs", "src", false),
        ("*", "Cargo.lock", true),
        ("*.lock", "Cargo.lock", true),
        ("**/wheel-data", "python/wheel-data/a", true),
        ("**/wheel", "python/wheel-data", false),
    ] {
        assert_eq!(leaves_out(line, path), is_out, "{line} {path}");
    }
}

#[test]
fn what_a_recipe_copies_is_in_the_tree() {
    let ignored = read(".dockerignore");
    let ignored = ignored.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    let ignored: Vec<&str> = ignored.collect();
    for (file, recipe) in recipes() {
        assert!(recipe.copied.len() > 3 && !recipe.handed_on.is_empty(), "{file}: {recipe:?}");
        for path in &recipe.copied {
            assert!(root().join(path).exists(), "{file} copies {path}, which is not there");
        }
        for path in &recipe.handed_on {
            let path = path.strip_prefix(SOURCE).unwrap_or_else(|| panic!("{file}: {path}"));
            // What is built is there after the build, and the rest was copied before.
            let is_built = path == "target/release/tribosweep";
            let is_copied = recipe.copied.iter().any(|copied| copied == "." || copied == path);
            assert!(is_built || is_copied && root().join(path).exists(), "{file}: {path}");
        }
        // Cargo looks for every member of the workspace, and for every path that it names.
        let manifest = read("Cargo.toml");
        let paths = manifest.split("path = \"").skip(1).map(|rest| rest.split('"').next().unwrap());
        let handed_on = recipe.handed_on.iter().filter_map(|path| path.strip_prefix(SOURCE));
        let handed_on = handed_on.filter(|path| *path != "target/release/tribosweep");
        let needed = ["Cargo.toml", "Cargo.lock", "build.rs", "build", "python", "src"];
        let needed = needed.into_iter().chain(handed_on);
        for needed in needed.chain(paths.filter(|path| *path != ".")) {
            let is_copied = |path: &String| path == "." || Path::new(needed).starts_with(path);
            let is_there = recipe.copied.iter().any(is_copied);
            assert!(is_there, "{file} builds without {needed}");
            let path = needed.strip_prefix("./").unwrap_or(needed);
            for line in &ignored {
                assert!(!leaves_out(line, path), ".dockerignore leaves out {path}: {line}");
            }
        }
    }
}

#[test]
fn what_a_recipe_installs_has_a_package_in_debian() {
    for (file, recipe) in recipes() {
        assert_eq!(recipe.packages, ["gcc", "libc6-dev"], "{file}");
    }
    let Ok(known) = Command::new("apt-cache").arg("pkgnames").output() else {
        return skip("there is no apt-cache, which knows the packages of Debian");
    };
    let known = String::from_utf8_lossy(&known.stdout);
    if known.lines().count() < 10_000 {
        return skip("apt-cache has no list of the packages of Debian");
    }
    for (file, recipe) in recipes() {
        for package in &recipe.packages {
            assert!(known.lines().any(|name| name == package), "{file}: no package {package}");
        }
    }
}
