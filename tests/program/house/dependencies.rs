//! The program is built from few packages, and what the tests compile serves the module for Python.

use std::collections::BTreeSet;
use std::process::Command;

use super::source::root;

/// The number of packages, its own included, from which the program is built on Linux must stay
/// below this. docs/book/src/measured/building.md says what each of the large ones is for.
const PACKAGES: usize = 220;

/// Asks cargo what it compiles for the packages and edges in the arguments, without the network.
/// Returns a line for each package.
fn packages(arguments: &[&str]) -> BTreeSet<String> {
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let output = Command::new(cargo)
        .current_dir(root())
        .args(["tree", "--offline", "--locked", "--prefix", "none"])
        .args(["--target", "x86_64-unknown-linux-gnu"])
        .args(arguments)
        .output()
        .expect("cargo can be called");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8(output.stdout).expect("cargo writes text");
    // A package that stands in the list again is marked as such.
    let packages: BTreeSet<String> =
        lines.lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect();
    assert!(packages.len() > 50, "cargo lists the packages: {lines}");
    packages
}

#[test]
fn the_program_is_built_from_few_packages() {
    let packages = packages(&["--edges", "normal,build", "--package", "tribosweep"]);
    assert!(
        packages.len() < PACKAGES,
        "the program is built from {} packages, and fewer than {PACKAGES} are wanted; is there a \
         lighter way, or a feature that can be off (docs/book/src/measured/building.md)?",
        packages.len()
    );
}

/// With other features everything would be compiled once more for the module.
#[test]
fn the_module_for_python_has_its_dependencies_as_the_tests_have_them() {
    let features = ["--format", "{p} [{f}]", "--edges"];
    let of_tests = packages(&[&features[..], &["normal,build,dev", "--workspace"]].concat());
    let of_module =
        packages(&[&features[..], &["normal,build", "--package", "tribosweep-python"]].concat());
    let others: Vec<&String> = of_module.difference(&of_tests).collect();
    assert!(
        others.is_empty(),
        "these have other features in the tests of the workspace; python/Cargo.toml can ask for \
         them too: {others:?}"
    );
}
