//! Mutations of text and of bytes, which follow from a seed alone.

/// A sequence of random numbers that follows from a seed.
pub(crate) struct Dice(fastrand::Rng);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    /// Returns a number below `end`, or 0.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        self.0.usize(..end.max(1))
    }

    /// Returns one of several texts or the like.
    pub(crate) fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }
}

/// Returns a text with up to eight mutations. `dictionary` has pieces to put in, and `others` are
/// texts to take pieces from.
pub(crate) fn mutated(text: &str, dictionary: &[&str], others: &[&str], dice: &mut Dice) -> String {
    let mut text = text.to_owned();
    for _ in 0..=dice.below(8) {
        text = once(&text, dictionary, others, dice);
        if text.len() > 1 << 16 {
            break;
        }
    }
    text
}

fn once(text: &str, dictionary: &[&str], others: &[&str], dice: &mut Dice) -> String {
    let (start, end) = range(text, dice);
    let (before, chosen, after) = (&text[..start], &text[start..end], &text[end..]);
    match dice.below(12) {
        0 => format!("{before}{after}"),
        1 => format!("{before}{chosen}{chosen}{after}"),
        2 => format!("{before}{}{chosen}{after}", dice.pick(dictionary)),
        3 => format!("{before}{}{after}", dice.pick(dictionary)),
        4 | 5 => token(text, dice).map_or_else(String::new, |(start, end)| {
            format!("{}{}{}", &text[..start], dice.pick(dictionary), &text[end..])
        }),
        6 => {
            let other = dice.pick(others);
            let (start, end) = range(other, dice);
            format!("{before}{}{after}", &other[start..end])
        }
        7 => swapped_lines(text, dice),
        8 => {
            let line = line(text, dice).to_owned();
            format!("{before}\n{line}\n{after}")
        }
        9 => {
            let depth = 1_usize << dice.below(10);
            let [open, close] =
                [["[", "]"], ["{ a = ", " }"], ["(", ")"], ["!", ""]][dice.below(4)];
            format!("{before}{}{chosen}{}{after}", open.repeat(depth), close.repeat(depth))
        }
        10 => format!("{before}{}{after}", chosen.repeat(1 + dice.below(64))),
        _ => {
            let odd = char::from_u32(dice.below(0x2100) as u32).unwrap_or('\u{fffd}');
            format!("{before}{odd}{after}")
        }
    }
}

/// Returns a short range between boundaries of characters.
fn range(text: &str, dice: &mut Dice) -> (usize, usize) {
    let floor = |mut at: usize| {
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let start = floor(dice.below(text.len() + 1));
    let longest = 1 << dice.below(8);
    let end = (start + dice.below(longest)).min(text.len());
    (start, floor(end).max(start))
}

/// Returns the range of a word or a number.
fn token(text: &str, dice: &mut Dice) -> Option<(usize, usize)> {
    let is_part = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '-');
    let mut tokens = Vec::new();
    let mut start = None;
    for (at, c) in text.char_indices().chain([(text.len(), ' ')]) {
        match (start, is_part(c)) {
            (None, true) => start = Some(at),
            (Some(from), false) => {
                tokens.push((from, at));
                start = None;
            }
            _ => {}
        }
    }
    (!tokens.is_empty()).then(|| tokens[dice.below(tokens.len())])
}

fn line<'t>(text: &'t str, dice: &mut Dice) -> &'t str {
    let lines: Vec<&str> = text.lines().collect();
    if lines.is_empty() { "" } else { lines[dice.below(lines.len())] }
}

fn swapped_lines(text: &str, dice: &mut Dice) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    if !lines.is_empty() {
        let (a, b) = (dice.below(lines.len()), dice.below(lines.len()));
        lines.swap(a, b);
    }
    lines.join("\n")
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

/// Returns one of the `inputs` with one to four changes.
pub(crate) fn changed(inputs: &[Vec<u8>], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = inputs[dice.below(inputs.len())].clone();
    // One change in a place is refused soonest; many at once seldom reach the depths.
    for _ in 0..1 + dice.below(6).saturating_sub(2) {
        let other = &inputs[dice.below(inputs.len())];
        change(&mut bytes, other, dice);
        bytes.truncate(LARGEST);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, other: &[u8], dice: &mut Dice) {
    let at = dice.below(bytes.len() + 1);
    let end = at + dice.below((bytes.len() - at).min(64) + 1);
    match dice.below(10) {
        0 if at < bytes.len() => bytes[at] ^= 1 << dice.below(8),
        1 if at < bytes.len() => bytes[at] = dice.below(256) as u8,
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..end)),
        4 | 5 => insert(bytes, at, dice.pick(&WORDS)),
        6 => {
            // A number or a word gives way to one at the edge.
            let (start, end) = word_around(bytes, at);
            let word = dice.pick(&WORDS);
            bytes.splice(start..end, word.iter().copied());
        }
        7 => {
            let part = bytes[at..end].to_vec();
            let times = if dice.below(20) == 0 { 20_000 } else { 1 + dice.below(40) };
            let times = times.min(LARGEST / part.len().max(1));
            insert(bytes, at, &part.repeat(times));
        }
        8 => {
            let from = dice.below(other.len() + 1);
            let to = from + dice.below(other.len() - from + 1);
            insert(bytes, at, &other[from..to]);
        }
        _ => {
            // Two lines change places.
            let mut lines: Vec<&[u8]> = bytes.split(|byte| *byte == b'\n').collect();
            let (a, b) = (dice.below(lines.len()), dice.below(lines.len()));
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
