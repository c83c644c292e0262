//! Inputs that are made from those of the corpus by a few random changes.

use fastrand::Rng;

use crate::corpus::{Corpus, InputKind};

/// An input for a reader.
pub(crate) struct Input {
    pub(crate) kind: InputKind,
    pub(crate) bytes: Vec<u8>,
}

/// Words that are at the edge of what some reader takes.
const WORDS: [&[u8]; 40] = [
    b"0",
    b"-1",
    b"1e308",
    b"-1e400",
    b"nan",
    b"inf",
    b"1e-320",
    b"9223372036854775807",
    b"18446744073709551616",
    b"0x7fffffff",
    b"1_000",
    b"\"",
    b"'''",
    b"\"\"\"",
    b"[",
    b"]",
    b"{",
    b"}",
    b"[[",
    b"=",
    b",",
    b".",
    b"#",
    b"\n",
    b"\r\n",
    b"\0",
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"\xc2\xb5m",
    b"\x1b]0;x\x07",
    b"\xe2\x80\xae",
    b" GPa",
    b" N/mm^2",
    b"{ from = 0, to = 1, count = 1000000000 }",
    b"{ from = 1, to = 1e300, factor = 1.0000001 }",
    b"file = \"/etc/shadow\"",
    b"true",
    b"1979-05-27T07:32:00Z",
    b"[[sweep.zip]]",
    b"[sweep]\n",
];

/// The largest input \[bytes\]. Files are bounded before they are read; what is below the bound
/// must be read in time.
const LARGEST: usize = 1 << 20;

/// Makes the input with a number; the same seed and number give the same input.
pub(crate) fn input(corpus: &Corpus, seed: u64, number: u64) -> Input {
    let mut rng = Rng::with_seed(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ number);
    let kind = InputKind::SHARES[rng.usize(..InputKind::SHARES.len())];
    let inputs = &corpus.inputs[&kind];
    let mut bytes = inputs[rng.usize(..inputs.len())].clone();
    // One change in a place is refused soonest; many at once seldom reach the depths.
    let changes = 1 + rng.usize(..6).saturating_sub(2);
    for _ in 0..changes {
        let other = &inputs[rng.usize(..inputs.len())];
        change(&mut bytes, other, &mut rng);
        bytes.truncate(LARGEST);
    }
    Input { kind, bytes }
}

fn change(bytes: &mut Vec<u8>, other: &[u8], rng: &mut Rng) {
    let at = rng.usize(..=bytes.len());
    let end = at + rng.usize(..=(bytes.len() - at).min(64));
    match rng.u8(..10) {
        0 if at < bytes.len() => bytes[at] ^= 1 << rng.u8(..8),
        1 if at < bytes.len() => bytes[at] = rng.u8(..),
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..end)),
        4 | 5 => insert(bytes, at, rng.choice(WORDS).unwrap_or_default()),
        6 => {
            // A number or a word gives way to one at the edge.
            let (start, end) = word_around(bytes, at);
            let word = rng.choice(WORDS).unwrap_or_default();
            bytes.splice(start..end, word.iter().copied());
        }
        7 => {
            let part = bytes[at..end].to_vec();
            let times = if rng.u8(..20) == 0 { 20_000 } else { rng.usize(1..40) };
            let times = times.min(LARGEST / part.len().max(1));
            insert(bytes, at, &part.repeat(times));
        }
        8 => {
            let from = rng.usize(..=other.len());
            let to = from + rng.usize(..=other.len() - from);
            insert(bytes, at, &other[from..to]);
        }
        _ => {
            // Two lines change places.
            let lines: Vec<&[u8]> = bytes.split(|byte| *byte == b'\n').collect();
            let (a, b) = (rng.usize(..lines.len()), rng.usize(..lines.len()));
            let mut lines = lines;
            lines.swap(a, b);
            *bytes = lines.join(&b'\n');
        }
    }
}

fn insert(bytes: &mut Vec<u8>, at: usize, part: &[u8]) {
    bytes.splice(at..at, part.iter().copied());
}

/// Returns the ends of the word or number around a place.
fn word_around(bytes: &[u8], at: usize) -> (usize, usize) {
    let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || b"._-+".contains(byte);
    let before = bytes[..at].iter().rev().take_while(|byte| is_part(byte)).count();
    let after = bytes[at..].iter().take_while(|byte| is_part(byte)).count();
    (at - before, at + after)
}
