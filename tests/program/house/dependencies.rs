//! The program is built from few packages.

use std::collections::BTreeSet;
use std::process::Command;

use super::source::root;

/// The number of packages, its own included, from which the program is built on Linux must stay
/// below this. docs/book/src/measured/building.md says what each of the large ones is for.
const PACKAGES: usize = 220;

/// Asks cargo what `cargo build` compiles, for programs and for build scripts, without the network.
#[test]
fn the_program_is_built_from_few_packages() {
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let output = Command::new(cargo)
        .current_dir(root())
        .args(["tree", "--offline", "--locked", "--edges", "normal,build", "--prefix", "none"])
        .args(["--target", "x86_64-unknown-linux-gnu", "--package", "tribosweep"])
        .output()
        .expect("cargo can be called");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8(output.stdout).expect("cargo writes text");
    // A package that stands in the list again is marked as such.
    let packages: BTreeSet<&str> =
        lines.lines().map(|line| line.trim_end_matches(" (*)")).collect();
    assert!(packages.len() > 50, "cargo lists the packages: {lines}");
    assert!(
        packages.len() < PACKAGES,
        "the program is built from {} packages, and fewer than {PACKAGES} are wanted; is there a \
         lighter way, or a feature that can be off (docs/book/src/measured/building.md)?",
        packages.len()
    );
}
