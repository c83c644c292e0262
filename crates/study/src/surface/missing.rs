//! Pixels that a file marks as missing: by a word, by an empty field, by NaN, or by a number that
//! no height can be.

use std::collections::BTreeMap;

use super::heights::HeightMatrix;
use crate::file_fault::FileFaults;
use crate::units::LengthUnit;

/// The treatment of missing pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MissingRule {
    /// They are refused.
    #[default]
    Refuse,
    /// They are filled from their neighbours.
    Fill,
    /// They are no part of the sole.
    Exclude,
    /// There are none: a number that elsewhere marks a missing pixel is a height.
    Keep,
}

/// Words that mark a missing value, in lower case.
const WORDS: &[&str] = &[
    "nan",
    "+nan",
    "-nan",
    "nan(ind)",
    "-nan(ind)",
    "na",
    "n/a",
    "#n/a",
    "#num!",
    "#value!",
    "#div/0!",
    "#ref!",
    "nd",
    "inf",
    "+inf",
    "-inf",
    "infinity",
    "-infinity",
    "+infinity",
    "bad",
    "invalid",
    "void",
    "null",
    "none",
    "nodata",
    "no_data",
    "no-data",
    "missing",
    "undefined",
    "masked",
    "empty",
    "nil",
    "<na>",
    "n.a.",
    "n.d.",
    "no",
    "no data",
    "bad pixel",
    "no value",
    "off",
    "over",
    "overflow",
    "err",
    "error",
    "dropout",
];

/// Returns whether a word marks a missing value; an empty one does.
pub(super) fn is_mark(word: &str) -> bool {
    let is_of = |signs: &[char]| word.chars().all(|c| signs.contains(&c));
    is_of(&['-'])
        || is_of(&['*'])
        || is_of(&['?'])
        || is_of(&['_'])
        || is_of(&['.'])
        // `1.#QNAN` and `-1.#IND00e+000` are what older Windows writes for NaN.
        || word.trim_start_matches(['+', '-']).starts_with("1.#")
        || WORDS.contains(&word.to_lowercase().as_str())
}

/// Marks of two words, in lower case.
const PAIRS: &[(&str, &str)] = &[("no", "data"), ("bad", "pixel"), ("no", "value")];

/// Returns whether a word is the second one of a mark whose first one stands before it.
pub(super) fn is_second_word(before: &str, word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_alphabetic())
        && PAIRS.iter().any(|(first, second)| {
            before.eq_ignore_ascii_case(first) && word.eq_ignore_ascii_case(second)
        })
}

/// The marks of missing values that a file has, with how often each stands there.
#[derive(Clone, Debug, Default)]
pub(super) struct Marks(BTreeMap<String, usize>);

impl Marks {
    /// Counts a mark, and returns the height of a missing pixel.
    pub(super) fn count(&mut self, mark: &str) -> f64 {
        // A file may be full of marks, but not of different ones.
        let is_full = self.0.len() >= 8;
        if let Some(count) = self.0.get_mut(mark) {
            *count += 1;
        } else {
            let name = if is_full { "others".to_owned() } else { mark.chars().take(20).collect() };
            *self.0.entry(name).or_default() += 1;
        }
        f64::NAN
    }

    /// Returns the marks in words: `` `nan` (12 times) ``.
    pub(super) fn words(&self) -> String {
        let shown = self.0.iter().map(|(mark, count)| match mark.as_str() {
            "" => format!("an empty field ({count} times)"),
            mark => format!("`{}` ({count} times)", mark.escape_debug()),
        });
        shown.collect::<Vec<_>>().join(", ").replace("(1 times)", "(once)")
    }
}

/// Numbers that mark missing pixels, whatever the unit. Instruments take what their numbers cannot
/// otherwise be: all nines, the ends of whole numbers, or more than any length.
fn is_marking(number: f64) -> bool {
    let size = number.abs();
    let nines = [999.0, 9999.0, 99999.0, 999999.0, 9999999.0, 99999999.0, 999999999.0];
    let ends = [32767.0, 32768.0, 65535.0, 8388607.0, 8388608.0, 16777215.0];
    let near = |mark: &f64| {
        // Nines may go on behind the point, 9999.9.
        [0.0, 0.9].iter().any(|more| (size - mark - more).abs() <= 1e-6 * mark)
    };
    size >= 1e9 || nines.iter().any(near) || ends.iter().any(near)
}

/// The number of ranges of all other heights by which a round number lies apart that is taken for
/// a mark, of whatever size it is.
const FAR_APART: f64 = 20.0;

/// Returns whether a number is a whole one other than 0.
fn is_round(number: f64) -> bool {
    number.abs() > 0.5 && (number - number.round()).abs() <= 1e-9 * number.abs()
}

impl HeightMatrix {
    /// Takes numbers that mark missing pixels for what they are: the one that is `stated`, in
    /// `unit`, and those that lie apart from all other heights and mark missing pixels elsewhere.
    pub(super) fn recognise_marks(
        &mut self,
        stated: Option<f64>,
        rule: MissingRule,
        unit: LengthUnit,
        marks: &mut Marks,
    ) {
        let raw = |height: f64| height / unit.metres_of(1.0);
        let mut take = |heights: &mut [f64], mark: f64| {
            // The mark was a height in metres; its last digits are those of the division.
            let tidy: f64 = format!("{mark:.9e}").parse().unwrap_or(mark);
            let name = format!("{}", crate::units::Compact(tidy));
            for height in heights.iter_mut() {
                if (raw(*height) - mark).abs() <= 1e-6 * mark.abs() {
                    *height = marks.count(&name);
                }
            }
        };
        if let Some(stated) = stated {
            take(&mut self.heights, stated);
        }
        if rule == MissingRule::Keep {
            return;
        }
        // At most a few numbers mark what is missing, above, below or on both sides.
        for _ in 0..4 {
            let Some(ends) = Ends::of(&self.heights) else { return };
            let inner = ends.next_highest - ends.next_lowest;
            let below = ends.next_lowest - ends.lowest;
            let above = ends.highest - ends.next_highest;
            let is_apart = |distance: f64, rest: f64| distance > 0.0 && distance > rest.max(0.0);
            // Of a pattern with few heights each may be meant.
            let is_pattern = !has_more_than_four(&self.heights);
            let marks_missing = |height: f64, distance: f64, rest: f64| {
                let is_far = rest > 0.0 && distance > FAR_APART * rest;
                is_apart(distance, rest)
                    && (is_marking(raw(height)) || is_far && !is_pattern && is_round(raw(height)))
            };
            if marks_missing(ends.lowest, below, ends.highest - ends.next_lowest) {
                take(&mut self.heights, raw(ends.lowest));
            } else if marks_missing(ends.highest, above, ends.next_highest - ends.lowest) {
                take(&mut self.heights, raw(ends.highest));
            } else if is_marking(raw(ends.lowest))
                && is_marking(raw(ends.highest))
                && is_apart(below.min(above), inner)
            {
                take(&mut self.heights, raw(ends.lowest));
                take(&mut self.heights, raw(ends.highest));
            } else {
                return;
            }
        }
    }

    /// Fills the missing pixels from their edges inwards, each with the mean of its neighbours that
    /// have heights by then, and returns which ones they were; empty if none is missing.
    pub(super) fn fill(&mut self) -> Vec<bool> {
        let absent: Vec<bool> = self.heights.iter().map(|height| height.is_nan()).collect();
        let (columns, rows) = (self.columns, self.rows);
        let around = |pixel: usize| {
            let (i, j) = (pixel % columns, pixel / columns);
            let span = |k: usize, count: usize| k.saturating_sub(1)..=(k + 1).min(count - 1);
            span(j, rows).flat_map(move |b| span(i, columns).map(move |a| b * columns + a))
        };
        let mut front: Vec<usize> = (0..absent.len()).filter(|pixel| absent[*pixel]).collect();
        if front.is_empty() || front.len() == absent.len() {
            return if front.is_empty() { Vec::new() } else { absent };
        }
        let has_height = |heights: &[f64], pixel: usize| {
            around(pixel).any(|neighbour| !heights[neighbour].is_nan())
        };
        front.retain(|pixel| has_height(&self.heights, *pixel));
        while !front.is_empty() {
            let filled: Vec<f64> = front
                .iter()
                .map(|pixel| {
                    let known = around(*pixel).map(|k| self.heights[k]).filter(|h| !h.is_nan());
                    let (mut sum, mut count) = (0.0, 0.0);
                    known.for_each(|height| {
                        sum += height;
                        count += 1.0;
                    });
                    sum / count
                })
                .collect();
            for (pixel, height) in front.iter().zip(filled) {
                self.heights[*pixel] = height;
            }
            let mut next: Vec<usize> = front
                .iter()
                .flat_map(|pixel| around(*pixel))
                .filter(|pixel| self.heights[*pixel].is_nan())
                .collect();
            next.sort_unstable();
            next.dedup();
            front = next;
        }
        absent
    }

    /// Refuses missing pixels about which the study says nothing.
    pub(super) fn refuse_missing(&self, marks: &Marks, faults: &mut FileFaults) {
        let missing = self.heights.iter().filter(|height| height.is_nan()).count();
        if missing > 0 && faults.is_empty() {
            let first = self.heights.iter().position(|height| height.is_nan()).unwrap_or(0);
            faults.add(None, "", || {
                format!(
                    "{missing} of {} pixels are missing, marked by {}, the first one in row {} and \
                     column {} (counted from 1 at the lowest x and y); say missing = \"fill\" to \
                     fill them from their neighbours, \"exclude\" to take them out of the sole, or \
                     \"none\" if such numbers are heights",
                    self.heights.len(),
                    marks.words(),
                    first / self.columns.max(1) + 1,
                    first % self.columns.max(1) + 1,
                )
            });
        }
    }
}

/// Returns whether there are more than four different heights.
fn has_more_than_four(heights: &[f64]) -> bool {
    let mut found: Vec<f64> = Vec::with_capacity(5);
    for height in heights.iter().filter(|height| !height.is_nan()) {
        if found.contains(height) {
            continue;
        }
        found.push(*height);
        if found.len() > 4 {
            return true;
        }
    }
    false
}

/// The two lowest and the two highest different heights.
struct Ends {
    lowest: f64,
    next_lowest: f64,
    next_highest: f64,
    highest: f64,
}

impl Ends {
    /// Finds them; `None` if there are fewer than two different heights.
    fn of(heights: &[f64]) -> Option<Self> {
        let known = || heights.iter().copied().filter(|height| !height.is_nan());
        let lowest = known().reduce(f64::min)?;
        let highest = known().reduce(f64::max)?;
        let next_lowest = known().filter(|height| *height > lowest).reduce(f64::min)?;
        let next_highest = known().filter(|height| *height < highest).reduce(f64::max)?;
        Some(Self { lowest, next_lowest, next_highest, highest })
    }
}
