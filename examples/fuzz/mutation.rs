//! Mutations of text, which follow from a seed alone.

/// A sequence of numbers that follows from a seed (SplitMix64, DOI 10.1145/2714064.2660195).
pub(crate) struct Dice(u64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number below `end`, or 0.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    /// Returns one of several texts.
    pub(crate) fn pick<'t>(&mut self, texts: &[&'t str]) -> &'t str {
        texts[self.below(texts.len())]
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
