//! `measured`: solves a job several times for `effects`, in a process of its own.

use std::io::{Read, Write};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use contact::Operators;
use study::Job;
use study::record_format::encode_fields;

use crate::output::Finish;
use crate::threads::share_among;
use crate::wire::{Measurement, OrderedJob, decode_order, encode};

/// Solves the job on standard input `repeat` times, and replies on standard output.
pub(crate) fn measured(repeat: u32) -> Result<Finish> {
    share_among(1)?;
    let mut payload = Vec::new();
    std::io::stdin().read_to_end(&mut payload)?;
    let OrderedJob { job: Job::Solve(case), surfaces } = decode_order(&payload)? else {
        bail!("only scenes that are solved are measured")
    };
    let before = peak_memory();
    let mut seconds = Vec::new();
    let mut solved = None;
    for _ in 0..repeat.max(1) {
        drop(solved.take());
        let start = Instant::now();
        let mut operators = Operators::default();
        solved = Some(contact::solve(&case.scene, &case.numerics, &surfaces, &mut operators)?);
        seconds.push(start.elapsed().as_secs_f64());
    }
    let bytes = peak_memory().zip(before).map(|(after, before)| after.saturating_sub(before));
    let (outcome, fields) = solved.context("nothing was solved")?;
    let measurement = Measurement { seconds, bytes, outcome, fields: encode_fields(&fields) };
    std::io::stdout().write_all(&encode(&measurement)?)?;
    Ok(Finish::AllDone)
}

/// Returns the most memory that this process has had so far \[bytes\], where the system says it.
fn peak_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}
