//! The header of a text, which may say of the matrix below it the pixels, their size, units and the
//! mark of missing ones. Profilometers, Gwyddion and programs for maps write such headers, with or
//! without a comment sign.

use super::titles::{TitleUnit, height_unit, unit_of};
use super::topics::{TOPICS, Topic};
use crate::file_fault::{FileFaults, FilePlace};
use crate::units::LengthUnit;

/// A fact of a header, and the line that says it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fact<T> {
    pub(super) value: T,
    pub(super) line: usize,
}

/// A length that a header gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StatedLength {
    /// The number as it stands there.
    number: f64,
    /// Half a unit of its last digit.
    half_digit: f64,
    unit: Option<LengthUnit>,
}

/// The facts of a header.
#[derive(Clone, Debug, Default)]
pub(super) struct HeaderFacts {
    /// The number of pixels along x and y.
    pub(super) counts: [Option<Fact<usize>>; 2],
    /// The extent along x and y.
    widths: [Option<Fact<StatedLength>>; 2],
    /// The distance of pixels along x and y.
    steps: [Option<Fact<StatedLength>>; 2],
    /// The unit of heights.
    pub(super) height_unit: Option<Fact<LengthUnit>>,
    /// The unit of coordinates.
    pub(super) lateral_unit: Option<Fact<LengthUnit>>,
    /// The number that marks a missing pixel.
    pub(super) missing: Option<Fact<f64>>,
    /// The first line is the northernmost one, as in the ASCII grids of maps.
    pub(super) is_north_first: bool,
    /// The header is that of an ASCII grid, whose lines may be broken anywhere.
    pub(super) is_grid: bool,
}

impl HeaderFacts {
    /// Notes the unit that the title of heights gives; returns whether a line is their title.
    pub(super) fn note_title(&mut self, line: usize, body: &str, faults: &mut FileFaults) -> bool {
        match height_unit(body) {
            Some(TitleUnit::Length(unit)) => {
                self.height_unit = Some(Fact { value: unit, line });
                true
            }
            Some(TitleUnit::Unknown) => {
                faults.add(Some(FilePlace::line(line)), body.trim(), || {
                    "gives heights in what is no unit of length known here".to_owned()
                });
                true
            }
            None => false,
        }
    }

    /// Notes what a line of a header says; returns whether it says something that is known. A line
    /// that gives a known thing wrongly is a fault.
    pub(super) fn note(&mut self, line: usize, body: &str, faults: &mut FileFaults) -> bool {
        let Some(NamedValue { name, value }) = split_fact(body) else { return false };
        let value = value.as_str();
        let topic = TOPICS.iter().find(|(_, names)| names.contains(&name.as_str()));
        let Some((topic, _)) = topic else { return false };
        let mut refuse = |reason: &str| {
            faults.add(Some(FilePlace::line(line)), body.trim(), || reason.to_owned());
            true
        };
        self.is_grid |= matches!(name.as_str(), "ncols" | "nrows");
        self.is_north_first |= matches!(name.as_str(), "ncols" | "nrows");
        match topic {
            Topic::Count(axis) => match value.parse::<usize>() {
                Ok(count) => self.counts[*axis] = Some(Fact { value: count, line }),
                // A resolution may be a distance of pixels as well.
                Err(_) => match StatedLength::read(value).filter(|read| read.stated.unit.is_some())
                {
                    Some(ReadLength { stated, .. }) if name.ends_with("resolution") => {
                        self.steps[*axis] = Some(Fact { value: stated, line });
                    }
                    _ => return refuse("does not give a whole number of pixels"),
                },
            },
            Topic::Width(axis) => {
                // "Height" may also head the heights, without a number.
                let Some(length) = StatedLength::read(value) else { return true };
                let unit = length.unit_word.to_lowercase();
                if matches!(unit.as_str(), "px" | "pixel" | "pixels" | "pts" | "points") {
                    let count = length.stated.number;
                    self.counts[*axis] = Some(Fact { value: count as usize, line });
                } else if !length.unit_word.is_empty() && length.stated.unit.is_none() {
                    return refuse("gives a width in what is no unit of length known here");
                } else {
                    self.widths[*axis] = Some(Fact { value: length.stated, line });
                }
            }
            Topic::Step(axes) => {
                let Some(length) = StatedLength::read(value) else { return true };
                if !length.unit_word.is_empty() && length.stated.unit.is_none() {
                    return refuse("gives a distance in what is no unit of length known here");
                }
                axes.iter().for_each(|axis| {
                    self.steps[*axis] = Some(Fact { value: length.stated, line });
                });
            }
            Topic::HeightUnit => match unit_of(value) {
                Some(unit) => self.height_unit = Some(Fact { value: unit, line }),
                None => return refuse("names what is no unit of length known here"),
            },
            Topic::LateralUnit => match unit_of(value) {
                Some(unit) => self.lateral_unit = Some(Fact { value: unit, line }),
                None => return refuse("names what is no unit of length known here"),
            },
            Topic::Missing => match value.replace(',', ".").parse::<f64>() {
                Ok(number) if number.is_finite() => {
                    self.missing = Some(Fact { value: number, line });
                }
                _ if value.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
                    return refuse("gives no plain number, in the unit of the heights");
                }
                // A word marks missing pixels by itself.
                _ => {}
            },
            // Of a unit a program may say how many nanometres it has.
            Topic::Factor if name == "bit2nm" && value.replace(',', ".").parse() == Ok(1.0) => {
                self.height_unit = LengthUnit::find("nm").map(|value| Fact { value, line });
            }
            Topic::Size => self.note_size(line, value),
            Topic::Shape => {
                let sizes: Vec<Option<usize>> = value
                    .split(|c: char| !c.is_ascii_digit())
                    .filter(|digits| !digits.is_empty())
                    .map(|digits| digits.parse().ok())
                    .collect();
                if let [Some(rows), Some(columns)] = sizes[..] {
                    self.counts =
                        [Some(Fact { value: columns, line }), Some(Fact { value: rows, line })];
                }
            }
            Topic::Factor => match StatedLength::read(value) {
                Some(length) if length.stated.number != 1.0 => {
                    return refuse(
                        "gives a factor of the heights, which is not applied here; apply it \
                         before, and remove this line",
                    );
                }
                _ => {}
            },
            Topic::Position => {}
        }
        true
    }

    /// Notes sizes along x and y: `512 x 512 pixels`, `60 µm x 80 µm`, `20 µm/px`. What is none of
    /// these is a comment.
    fn note_size(&mut self, line: usize, value: &str) {
        // The x of pixels separates nothing.
        let value = value.to_lowercase().replace(" by ", " x ");
        let value = value.replace("pixel", "pt").replace("px", "pt");
        // A comma without a blank is decimal.
        for group in value.replace(", ", ";").split([';', '(']) {
            let group = group.trim_matches([' ', ')']);
            let parts: Vec<&str> = group.split(['x', '×', '*']).map(str::trim).collect();
            let pair = match parts[..] {
                [one] => [one, one],
                [x, y] => [x, y],
                _ => continue,
            };
            let [Some(x), Some(y)] = pair.map(StatedLength::read) else { continue };
            let is_pixels = matches!(y.unit_word, "pt" | "pts" | "points");
            let is_step = ["/pt", "/point", "per pt"].iter().any(|end| y.unit_word.ends_with(end));
            for (axis, read) in [&x, &y].into_iter().enumerate() {
                let unit = read.stated.unit.or(y.stated.unit);
                let fact = Fact { value: StatedLength { unit, ..read.stated }, line };
                if is_pixels && parts.len() == 2 {
                    let count = read.stated.number as usize;
                    self.counts[axis] = Some(Fact { value: count, line });
                } else if is_step && unit.is_some() {
                    self.steps[axis] = Some(fact);
                } else if unit.is_some() {
                    self.widths[axis] = Some(fact);
                }
            }
        }
    }

    /// Notes where the header gives a width and a distance of pixels that do not agree for the
    /// pixels that there are.
    pub(super) fn compare_lengths(
        &mut self,
        counts: [usize; 2],
        unit: LengthUnit,
        faults: &mut FileFaults,
    ) {
        for (axis, count) in counts.into_iter().enumerate() {
            let Some(width) = self.widths[axis] else { continue };
            let is_bare = width.value.unit.is_none();
            let is_count = is_bare && width.value.number == count as f64;
            let Some(step) = self.steps[axis] else {
                // A bare size may be a length or a number of pixels.
                if is_count && self.lateral_unit.is_none() {
                    self.widths[axis] = None;
                }
                continue;
            };
            let metres = |fact: &Fact<StatedLength>, times: f64| self.stated(fact, times, unit);
            let (across, along) = (metres(&width, 1.0), metres(&step, count as f64));
            let between = metres(&step, count as f64 - 1.0);
            let agrees = |of: &StatedWidth| {
                (across.width - of.width).abs()
                    <= across.tolerance.max(of.tolerance) * of.width.abs()
            };
            if agrees(&along) {
                continue;
            }
            // Some count from the first centre to the last one; then the distance tells the width.
            if agrees(&between) || is_count {
                self.widths[axis] = None;
                continue;
            }
            let shown = crate::units::lengths(&[across.width, along.width]);
            faults.add(Some(FilePlace::line(width.line)), "", || {
                format!(
                    "the header gives a width of {}, but the distance of pixels on line {} makes {} of {count} pixels",
                    shown[0], step.line, shown[1]
                )
            });
        }
    }

    /// Returns a stated length times a number \[m\]. Lengths without a unit are in `unit`.
    fn stated(&self, fact: &Fact<StatedLength>, times: f64, unit: LengthUnit) -> StatedWidth {
        let StatedLength { number, half_digit, unit: named } = fact.value;
        let unit = named.or(self.lateral_unit.map(|fact| fact.value)).unwrap_or(unit);
        StatedWidth {
            // By its digits, so that it has the bits of the same width in a study.
            width: unit
                .metres(&format!("{:.11e}", number * times))
                .unwrap_or_else(|| unit.metres_of(number * times)),
            tolerance: (1e-3 * number.abs()).max(half_digit) / number.abs(),
            line: fact.line,
            has_unit: named.is_some(),
        }
    }

    /// Returns the width along x (0) or y (1) that the header states \[m\], with its tolerance, for
    /// `count` pixels. Lengths without a unit are in `unit`.
    pub(super) fn width(&self, axis: usize, count: usize, unit: LengthUnit) -> Option<StatedWidth> {
        let stated = |fact: &Fact<StatedLength>, times: f64| self.stated(fact, times, unit);
        let by_width = self.widths[axis].as_ref().map(|fact| stated(fact, 1.0));
        let by_step = || self.steps[axis].as_ref().map(|fact| stated(fact, count as f64));
        by_width.or_else(by_step).filter(|stated| stated.width > 0.0)
    }
}

/// The width of a map as its file states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StatedWidth {
    /// The width \[m\].
    pub(super) width: f64,
    /// The part of it by which it may be off, for its digits are few.
    pub(super) tolerance: f64,
    /// The line that states it.
    pub(super) line: usize,
    /// The line names its unit.
    pub(super) has_unit: bool,
}

/// A length with the word behind its number.
struct ReadLength<'a> {
    stated: StatedLength,
    unit_word: &'a str,
}

impl StatedLength {
    /// Reads `10.00 µm`; `None` if there is no number in front.
    fn read(value: &str) -> Option<ReadLength<'_>> {
        let end = value
            .find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | ',' | '+' | '-' | 'e' | 'E')))
            .unwrap_or(value.len());
        let digits = value[..end].replace(',', ".");
        let number: f64 = digits.parse().ok().filter(|number: &f64| number.is_finite())?;
        let (mantissa, exponent) = digits.split_once(['e', 'E']).unwrap_or((&digits, "0"));
        let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let exponent = exponent.parse::<i32>().unwrap_or(0).saturating_sub(decimals as i32);
        let half_digit = if decimals > 0 { 0.5 * 10f64.powi(exponent) } else { 0.0 };
        let unit_word = value[end..].trim();
        let bare = ["/px", "/pixel", "/pt", "/point", "per pixel", "per pt"]
            .iter()
            .find_map(|end| unit_word.strip_suffix(end))
            .unwrap_or(unit_word);
        let unit = unit_of(bare);
        Some(ReadLength { stated: StatedLength { number, half_digit, unit }, unit_word })
    }
}

/// Splits `Name: value`, `name = value` or `NAME value` into the name in lower case and the value.
fn split_fact(body: &str) -> Option<NamedValue> {
    let body = body.trim();
    let (name, value) = match body.split_once(['=', ':', '：']) {
        Some((name, value)) => (name, value),
        None => body.split_once(char::is_whitespace)?,
    };
    let value = value.trim().trim_matches(['=', ':']).trim();
    // A unit may stand behind the name: `Width [mm] = 2`.
    let (bare, unit) = match name.split_once(['[', '(']) {
        Some((bare, unit)) if value.parse::<f64>().is_ok() => {
            (bare, unit.trim_end_matches([']', ')']))
        }
        Some((bare, _)) => (bare, ""),
        None => (name, ""),
    };
    let name = bare.to_lowercase().replace(['_', '-'], " ");
    let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
    Some(NamedValue { name, value: format!("{value} {unit}").trim().to_owned() })
}

/// A name in lower case, and the value that a header gives for it.
struct NamedValue {
    name: String,
    value: String,
}
