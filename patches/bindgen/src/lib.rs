//! Stands in for bindgen in builds of this repository.
//!
//! The build scripts of `iceoryx2-pal-posix` and `iceoryx2-pal-os-api` 0.10 call bindgen under
//! `#[cfg(target_os = "nto")]` alone, and name it as a dependency for all systems: fourteen crates
//! and 200 000 lines that are compiled and never used. A build on QNX would miss it and say so. The
//! stand-in goes once iceoryx2 names bindgen for QNX alone; a build by `cargo install` from a
//! registry does not see it and takes the real one.
#![forbid(unsafe_code)]
