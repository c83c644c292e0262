//! Prints a line for each result in a store: the key of its job, the digest of the bytes that must
//! be the same whoever computed it, and the job's canonical text. `scripts/compare-builds` holds
//! the lines of two stores against each other.
//!
//! ```text
//! cargo run --release --example result-digests -- .tribosweep
//! ```

use std::error::Error;
use std::path::PathBuf;

use store::{Digest, Store};
use study::Record;

fn main() -> Result<(), Box<dyn Error>> {
    let directory = std::env::args_os()
        .nth(1)
        .map(PathBuf::from)
        .ok_or("the directory of a store is missing")?;
    let reader = Store::read(&directory)?;
    let keys = reader.keys()?;
    for (key, bytes) in reader.select(keys) {
        let record = Record::decode(&bytes?)?;
        println!("{key} {} {}", Digest::of(&record.result_bytes()), record.job);
    }
    Ok(())
}
