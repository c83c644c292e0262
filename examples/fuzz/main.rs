//! Reads mutated study files or filters in this process, and says what came of them: how many were
//! accepted, which one took longest. A panic, or one that takes more than five seconds, ends with
//! its seed, which makes the same text again. Memory is limited to a gibibyte.
//!
//! ```text
//! cargo run --release --example fuzz -- studies 100000 1     # kind, number, first seed
//! cargo run --release --example fuzz -- filters 100000 1
//! cargo run --release --example fuzz -- studies 1 17 show    # prints the text of seed 17
//! ```

use std::error::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use rustix::process::{Resource, Rlimit, setrlimit};

mod filters;
mod mutation;
mod studies;

/// The longest time that a text may take.
const PATIENCE: Duration = Duration::from_secs(5);

/// The memory that the process may have \[bytes\].
const MEMORY: u64 = 1 << 30;

/// A kind of text that is mutated.
struct Subject {
    /// Makes the text of a seed.
    text: fn(u64) -> String,
    /// Reads it, and returns whether it was accepted.
    read: fn(&str) -> bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let subject = match arguments.next().as_deref() {
        Some("studies") => Subject { text: studies::text, read: studies::read },
        Some("filters") => Subject { text: filters::text, read: filters::read },
        _ => return Err("the kind is missing: studies or filters".into()),
    };
    let count: u64 = arguments.next().ok_or("the number is missing")?.parse()?;
    let first: u64 = arguments.next().ok_or("the first seed is missing")?.parse()?;
    if arguments.next().is_some() {
        println!("{}", (subject.text)(first));
        return Ok(());
    }
    setrlimit(Resource::As, Rlimit { current: Some(MEMORY), maximum: Some(MEMORY) })?;
    let (mut accepted, mut faults) = (0, 0);
    let mut slowest = (Duration::ZERO, first);
    for seed in first..first.saturating_add(count) {
        let text = (subject.text)(seed);
        let start = Instant::now();
        match catch_unwind(AssertUnwindSafe(|| (subject.read)(&text))) {
            Ok(is_accepted) => accepted += u64::from(is_accepted),
            Err(_) => {
                eprintln!("seed {seed}: panic");
                faults += 1;
            }
        }
        let took = start.elapsed();
        if took > PATIENCE {
            eprintln!("seed {seed}: took {took:?}");
            faults += 1;
        }
        slowest = slowest.max((took, seed));
    }
    println!(
        "{count} read, {accepted} accepted, {faults} faults; seed {} took longest, {:.1} ms",
        slowest.1,
        slowest.0.as_secs_f64() * 1e3
    );
    if faults > 0 { Err(format!("{faults} faults").into()) } else { Ok(()) }
}
