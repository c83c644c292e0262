//! The process that reads inputs.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::corpus::{Corpus, InputKind};

/// The memory that reading an input may take \[bytes\].
const MEMORY: u64 = 1 << 30;

/// The time that reading an input may take. Readers that are not optimised take ten times as long.
pub(crate) const PATIENCE: Duration =
    Duration::from_secs(if cfg!(debug_assertions) { 50 } else { 5 });

/// Reads inputs one after the other and leaves the number of each in the file `progress` first.
pub(crate) fn read(
    corpus: &Corpus,
    seed: u64,
    inputs: impl Iterator<Item = u64>,
    progress: &Path,
) -> Result<(), Box<dyn Error>> {
    let maximum = getrlimit(Resource::As).maximum;
    setrlimit(Resource::As, Rlimit { current: Some(address_space()? + MEMORY), maximum })?;
    let progress = File::create(progress)?;
    // The parent says which input it was.
    std::panic::set_hook(Box::new(|_| ()));
    let mut accepted: BTreeMap<InputKind, u64> = BTreeMap::new();
    for number in inputs {
        progress.write_all_at(&number.to_le_bytes(), 0)?;
        let input = corpus.input(seed, number);
        let start = Instant::now();
        let end = catch_unwind(AssertUnwindSafe(|| Corpus::read(&input)));
        match end {
            Ok(is_accepted) => *accepted.entry(input.kind).or_default() += u64::from(is_accepted),
            Err(panic) => {
                let words = panic.downcast_ref::<String>().map(String::as_str);
                let words = words.or(panic.downcast_ref::<&str>().copied()).unwrap_or_default();
                println!("FAULT input {number}, {:?}: panic: {words}", input.kind);
            }
        }
        if start.elapsed() > PATIENCE {
            let seconds = start.elapsed().as_secs_f64();
            println!("FAULT input {number}, {:?}: {seconds:.1} s", input.kind);
        }
    }
    for (kind, count) in accepted {
        println!("accepted {count} {kind:?}");
    }
    Ok(())
}

/// Returns the size of this process's address space \[bytes\].
fn address_space() -> Result<u64, Box<dyn Error>> {
    let pages = std::fs::read_to_string("/proc/self/statm")?;
    let pages: u64 = pages.split(' ').next().unwrap_or_default().parse()?;
    Ok(pages * rustix::param::page_size() as u64)
}
