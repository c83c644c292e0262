//! The program as a whole: as a user meets it, killed, on a cluster, in a container, in a browser,
//! and as its book says. One binary has all of it, so that its libraries are linked once; `cargo
//! test --test program cli::` runs a part.

mod book;
mod cli;
mod cluster;
mod container;
mod house;
mod kills;
mod page;
mod place;
