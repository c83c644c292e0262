//! A field that is drawn with characters.

use std::fmt::Write;

use wording::one_line;

use super::color::{NOTHING, Shade, colors, state_color};
use super::quantity::{Field, Values};
use crate::axis::drawable;
use crate::number::significant;
use crate::unit::PrefixedUnit;

/// The means to draw a field in [`Field::terminal`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TerminalInk {
    /// Two coloured pixels per character, by 24-bit ANSI escape sequences. For a terminal.
    Color,
    /// Characters of growing weight. For a file, a pipe, or a terminal without colours.
    Ascii,
}

/// The characters of numbers, from the lowest to the highest.
const RAMP: &[u8] = b".:-=+*#%@";
/// The characters of states; the first state, the ground, is blank.
const STATES: &[u8] = b" .#o+x*%&=";
/// The escape sequence that ends all colours.
const RESET: &str = "\u{1b}[0m";

impl Field {
    /// Draws the field as text at most `width` characters wide, y upwards (z downwards), followed
    /// by lines that give the scale.
    ///
    /// A pixel averages the elements that it covers, or shows their most frequent state. Without
    /// colours, numbers are drawn with `.:-=+*#%@` from the lowest to the highest, and an element
    /// without a value is blank.
    pub fn terminal(&self, width: usize, ink: TerminalInk) -> String {
        if self.cut.is_section() {
            return self.upside_down().terminal(width, ink);
        }
        let width = width.clamp(8, 400);
        let [length, breadth] = self.grid.lengths();
        // A character is about twice as high as wide, so a pixel is half a character high. Its side
        // is at least a quarter of the shorter side of an element, and there are never so many
        // pixels that the drawing leaves a screen.
        let most_rows = 2 * width.min(60);
        let pixel = (length / width as f64)
            .max(breadth / most_rows as f64)
            .max(self.grid.element[0].min(self.grid.element[1]) / 4.0);
        let count =
            |extent: f64, most: usize| ((extent / pixel).round().clamp(1.0, most as f64)) as usize;
        let across = count(length, width);
        let rows = count(breadth, most_rows).div_ceil(2);
        let mut out = format!("{}\n", one_line(&self.title()));
        out += &match ink {
            TerminalInk::Color => self.in_color(across, rows),
            TerminalInk::Ascii => self.in_ascii(across, rows),
        };
        out += &self.scale_lines(ink);
        out
    }

    /// Draws the field with two coloured pixels per character.
    fn in_color(&self, across: usize, rows: usize) -> String {
        let mut out = String::new();
        let picture = self.sampled(across, 2 * rows, &colors(&self.values));
        for row in (0..rows).rev() {
            let mut before = None;
            for column in 0..across {
                let pair =
                    (picture[(2 * row + 1) * across + column], picture[2 * row * across + column]);
                if before != Some(pair) {
                    let ([r, g, b], [s, h, c]) = pair;
                    // Writing to a string does not fail.
                    let _ = write!(out, "\u{1b}[38;2;{r};{g};{b};48;2;{s};{h};{c}m");
                    before = Some(pair);
                }
                out.push('▀');
            }
            out += RESET;
            out.push('\n');
        }
        out
    }

    /// Draws the field with characters alone.
    fn in_ascii(&self, across: usize, rows: usize) -> String {
        let marks: Vec<u8> = match &self.values {
            Values::Number(values) => {
                let shade = Shade::for_values(values);
                let mark = |x: &Option<f64>| x.map_or(b' ', |x| RAMP[step(shade.fraction(x))]);
                self.averaged(across, rows, values).iter().map(mark).collect()
            }
            Values::Category { states, .. } => {
                let pixels = self.most_frequent(across, rows, states);
                pixels.iter().map(|&s| STATES[usize::from(s) % STATES.len()]).collect()
            }
        };
        let mut out = String::new();
        for row in marks.chunks_exact(across).rev() {
            let line: String = row.iter().map(|&c| char::from(c)).collect();
            let _ = writeln!(out, "{}", line.trim_end());
        }
        out
    }

    /// Returns the colour of each pixel, from the average of the values or the most frequent state.
    fn sampled(&self, across: usize, down: usize, colors: &[[u8; 3]]) -> Vec<[u8; 3]> {
        match &self.values {
            _ if across == self.grid.nx && down == self.grid.ny => colors.to_vec(),
            Values::Number(values) => {
                let shade = Shade::for_values(values);
                let color = |x: &Option<f64>| x.map_or(NOTHING, |x| shade.color(shade.fraction(x)));
                self.averaged(across, down, values).iter().map(color).collect()
            }
            Values::Category { states, .. } => self
                .most_frequent(across, down, states)
                .iter()
                .map(|&s| state_color(usize::from(s)))
                .collect(),
        }
    }

    /// Iterates over the pixels, from the lowest row upwards, and for each over the elements that
    /// it covers.
    fn covered(
        &self,
        across: usize,
        down: usize,
    ) -> impl Iterator<Item = impl Iterator<Item = usize>> {
        let (nx, ny) = (self.grid.nx, self.grid.ny);
        let range = |pixel: usize, pixels: usize, elements: usize| {
            let first = pixel * elements / pixels;
            first..((pixel + 1) * elements).div_ceil(pixels).max(first + 1).min(elements)
        };
        (0..down).flat_map(move |row| {
            (0..across).map(move |column| {
                let columns = range(column, across, nx);
                range(row, down, ny).flat_map(move |j| columns.clone().map(move |i| j * nx + i))
            })
        })
    }

    /// Returns the average value in each pixel, `None` for a pixel without values.
    fn averaged(&self, across: usize, down: usize, values: &[f64]) -> Vec<Option<f64>> {
        let average = |elements: &mut dyn Iterator<Item = usize>| {
            let (sum, count) = elements
                .map(|e| values[e])
                .filter(|x| drawable(*x, false))
                .fold((0.0, 0usize), |(sum, count), x| (sum + x, count + 1));
            (count > 0).then(|| sum / count as f64)
        };
        self.covered(across, down).map(|mut elements| average(&mut elements)).collect()
    }

    /// Returns the most frequent state in each pixel.
    fn most_frequent(&self, across: usize, down: usize, states: &[u8]) -> Vec<u8> {
        let winner = |elements: &mut dyn Iterator<Item = usize>| {
            let mut votes = [0usize; 256];
            elements.for_each(|e| votes[usize::from(states[e])] += 1);
            let most = votes.iter().copied().max().unwrap_or(0);
            votes.iter().position(|&v| v == most).and_then(|s| u8::try_from(s).ok()).unwrap_or(0)
        };
        self.covered(across, down).map(|mut elements| winner(&mut elements)).collect()
    }

    /// Returns the lines below the drawing: the range of the values or the names of the states, and
    /// the size of the grid.
    fn scale_lines(&self, ink: TerminalInk) -> String {
        let line = match &self.values {
            Values::Number(values) => self.range_line(values, ink),
            Values::Category { states, names } => states_line(states, names, ink),
        };
        let [length, breadth] = self.grid.lengths();
        let unit = PrefixedUnit::fitting("m", length.max(breadth));
        let extent = |x: f64| significant(unit.of_si(x), 4);
        format!("{}\n{} × {} {}\n", line.trim_end(), extent(length), extent(breadth), unit.name)
    }

    /// Returns the range of the values with its colours or characters.
    fn range_line(&self, values: &[f64], ink: TerminalInk) -> String {
        if !values.iter().any(|x| drawable(*x, false)) {
            return "no values".to_owned();
        }
        let shade = Shade::for_values(values);
        let unit = PrefixedUnit::fitting(&self.unit, shade.low.abs().max(shade.high.abs()));
        let mut line = significant(unit.of_si(shade.low), 4);
        line.push(' ');
        for i in 0..27 {
            let fraction = f64::from(i) / 26.0;
            match ink {
                TerminalInk::Color => {
                    let [r, g, b] = shade.color(fraction);
                    // Writing to a string does not fail.
                    let _ = write!(line, "\u{1b}[48;2;{r};{g};{b}m ");
                }
                TerminalInk::Ascii => line.push(char::from(RAMP[step(fraction)])),
            }
        }
        if ink == TerminalInk::Color {
            line += RESET;
        }
        let high = significant(unit.of_si(shade.high), 4);
        let _ = write!(line, " {high} {}", one_line(&unit.name));
        line
    }
}

/// Returns the states that occur, each with its colour or character.
fn states_line(states: &[u8], names: &[String], ink: TerminalInk) -> String {
    let mut line = String::new();
    let occurs = |state: usize| states.iter().any(|&drawn| usize::from(drawn) == state);
    for (state, name) in names.iter().enumerate().filter(|(state, _)| occurs(*state)) {
        let name = one_line(name);
        let _ = match ink {
            TerminalInk::Color => {
                let [r, g, b] = state_color(state);
                write!(line, "\u{1b}[48;2;{r};{g};{b}m  {RESET} {name}  ")
            }
            TerminalInk::Ascii => {
                write!(line, "[{}] {name}  ", char::from(STATES[state % STATES.len()]))
            }
        };
    }
    line
}

/// Returns the index in [`RAMP`] of a position between the limits.
fn step(fraction: f64) -> usize {
    ((fraction * RAMP.len() as f64) as usize).min(RAMP.len() - 1)
}
