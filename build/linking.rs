//! The decision how the program is linked.

/// The variable by which a packager leaves the choice of addresses to the linker.
pub(crate) const VARIABLE: &str = "TRIBOSWEEP_PIE";

/// Returns the argument for the linker that lets the program be loaded at a fixed address, for
/// targets whose linkers are known to take it, unless the variable has a value other than 0. The
/// target is its architecture, system and environment.
pub(crate) fn linker_argument(target: [&str; 3], variable: &str) -> Option<&'static str> {
    let is_left_alone = !["", "0"].contains(&variable);
    (target == ["x86_64", "linux", "gnu"] && !is_left_alone).then_some("-no-pie")
}
