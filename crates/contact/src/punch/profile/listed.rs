//! The profile files of MiniProf (.ban, .whl) and plain lists of y and z.
//!
//! Neither says which way its axes point; the points do. The body of a rail lies within the bow of
//! its curve, and the flange of a wheel sticks out. So z is turned to point down, and the flange of
//! a wheel to negative y.

use super::kind::{ProfileError, ProfileKind, ReadPoints};
use super::words::{LineFaults, finite, numbered_lines, per_metre};

/// The extent of a profile along y \[m\] that is believed without a word.
const WIDTH: std::ops::RangeInclusive<f64> = 0.02..=0.6;

/// Reads a profile of `kind`.
pub(super) fn read(text: &str, kind: ProfileKind) -> Result<ReadPoints, ProfileError> {
    let listed = Listed::read(text)?;
    let mut note = match listed.is_miniprof {
        true => format!("in MiniProf's format, {} lines of its header read past", listed.read_past),
        false => "a list of y and z".to_owned(),
    };
    let per_metre = listed.per_metre()?;
    note += match per_metre {
        1.0 => " in m",
        1e2 => " in cm",
        1e3 => " in mm",
        1e6 => " in um",
        _ => " in in",
    };
    let mut points: Vec<[f64; 2]> = listed
        .points
        .iter()
        .map(|[y, z]| [(y + listed.offset[0]) / per_metre, (z + listed.offset[1]) / per_metre])
        .collect();
    if listed.offset != [0.0; 2] {
        note += ", moved by its offsets";
    }
    if turns(&points) > 3 + points.len() / 8 {
        return Err(ProfileError::Unclear(
            "the points of this list do not follow one another along a curve",
        ));
    }
    let is_upward = match kind {
        ProfileKind::Rail => is_rail_upward(&points),
        ProfileKind::Wheel => is_wheel_upward(&points),
    };
    if is_upward.ok_or(ProfileError::Unclear(
        "the points of this list do not show which way z points; give a profile in SIMPACK's format",
    ))? {
        points.iter_mut().for_each(|point| point[1] = -point[1]);
        note += ", z turned to point down";
    }
    if kind == ProfileKind::Wheel && is_flange_right(&points) {
        points.iter_mut().for_each(|point| point[0] = -point[0]);
        note += ", mirrored in y, for its flange lies at positive y";
    }
    Ok(ReadPoints { kind, points, note })
}

/// The content of a list.
struct Listed {
    is_miniprof: bool,
    /// The number of lines of the header that say nothing about the curve.
    read_past: usize,
    /// The number of units of length in a metre, if the file says it.
    stated_unit: Option<f64>,
    offset: [f64; 2],
    points: Vec<[f64; 2]>,
}

impl Listed {
    fn read(text: &str) -> Result<Self, ProfileError> {
        let mut listed = Self {
            is_miniprof: false,
            read_past: 0,
            stated_unit: None,
            offset: [0.0; 2],
            points: Vec::new(),
        };
        let mut columns = [0, 1];
        let mut faults = LineFaults::default();
        for (line, text) in numbered_lines(text) {
            let body = text.trim();
            let body = match body.find(['!', '#', '%']) {
                Some(end) => body[..end].trim(),
                None => body,
            };
            if body.is_empty() || body.starts_with("//") || body.starts_with(['*', '"']) {
                continue;
            }
            let is_above = listed.points.is_empty();
            if let (true, Some((key, value))) = (is_above, body.split_once('=')) {
                listed.is_miniprof = true;
                match listed.header(key.trim(), value.trim(), &mut columns) {
                    Ok(()) => {}
                    Err(expected) => faults.add(line, body, expected),
                }
                continue;
            }
            let has_semicolons = body.contains(';');
            let separators = |c: char| c.is_whitespace() || c == ';' || c == ',' && !has_semicolons;
            let words: Vec<&str> = body.split(separators).filter(|word| !word.is_empty()).collect();
            if is_above && words.iter().all(is_title) {
                // Titles of columns may name the unit.
                let unit =
                    body.split(['[', '(']).nth(1).and_then(|rest| rest.split([']', ')']).next());
                listed.stated_unit = listed.stated_unit.or(unit.and_then(per_metre));
                continue;
            }
            let number = |column: usize| finite(&words.get(column)?.replace(',', "."));
            match [number(columns[0]), number(columns[1])] {
                [Some(y), Some(z)] if listed.is_miniprof || words.len() <= 3 => {
                    listed.points.push([y, z]);
                }
                _ => faults.add(
                    line,
                    body,
                    "must be y and z, perhaps with a weight, as finite numbers",
                ),
            }
        }
        if faults.is_empty() { Ok(listed) } else { Err(ProfileError::Lines(faults)) }
    }

    /// Reads a line of MiniProf's header. Its other keys say who measured what, where and when.
    fn header(
        &mut self,
        key: &str,
        value: &str,
        columns: &mut [usize; 2],
    ) -> Result<(), &'static str> {
        let number = || finite(value).ok_or("must be a finite number");
        match key.to_lowercase().as_str() {
            "columndef" => {
                let names: Vec<String> =
                    value.split(',').map(|name| name.trim().to_uppercase()).collect();
                let column = |name: &str| names.iter().position(|other| other == name);
                *columns = match (column("X"), column("Y")) {
                    (Some(x), Some(y)) => [x, y],
                    _ => return Err("must name the columns X and Y"),
                };
            }
            "xoffset" => self.offset[0] = number()?,
            "yoffset" => self.offset[1] = number()?,
            _ => self.read_past += 1,
        }
        Ok(())
    }

    /// Returns the number of units of length in a metre: MiniProf's is the millimetre, that of a
    /// list is told by its width.
    fn per_metre(&self) -> Result<f64, ProfileError> {
        if let Some(stated) = self.stated_unit {
            return Ok(stated);
        }
        if self.is_miniprof {
            return Ok(1e3);
        }
        let y = || self.points.iter().map(|point| point[0]);
        let width = y().fold(f64::NEG_INFINITY, f64::max) - y().fold(f64::INFINITY, f64::min);
        if self.points.len() < 3 {
            return Err(ProfileError::Points {
                count: self.points.len(),
                expected: "no two neighbours coincide",
            });
        }
        [1.0, 1e3].into_iter().find(|unit| WIDTH.contains(&(width / unit))).ok_or(
            ProfileError::Unclear(
                "the points of this list span neither 20 to 600 mm nor 0.02 to 0.6 m in y, so that \
                 their unit is not clear; give them in mm",
            ),
        )
    }
}

/// Returns whether a word is the title of a column or its unit.
fn is_title(word: &&str) -> bool {
    const TITLES: &[&str] = &[
        "",
        "x",
        "y",
        "z",
        "w",
        "weight",
        "lateral",
        "vertical",
        "horizontal",
        "height",
        "width",
        "profile",
        "rail",
        "wheel",
    ];
    let name = word.to_lowercase();
    let name = name.split(['[', '(', '/', '_', ':']).next().unwrap_or_default();
    TITLES.contains(&name) || per_metre(word).is_some()
}

/// Returns how often a curve turns back in y.
fn turns(points: &[[f64; 2]]) -> usize {
    let steps: Vec<f64> =
        points.windows(2).map(|p| p[1][0] - p[0][0]).filter(|step| step.abs() > 1e-9).collect();
    steps.windows(2).filter(|pair| (pair[0] < 0.0) != (pair[1] < 0.0)).count()
}

/// Returns whether z points up in a rail's points: whether they bow upwards from the line between
/// the ends. It is `None` if they hardly bow at all.
fn is_rail_upward(points: &[[f64; 2]]) -> Option<bool> {
    let (first, last) = (points.first()?, points.last()?);
    let chord = |y: f64| {
        let width = last[0] - first[0];
        if width == 0.0 {
            first[1]
        } else {
            first[1] + (y - first[0]) / width * (last[1] - first[1])
        }
    };
    let mut bow = 0.0;
    let mut length = 0.0;
    for pair in points.windows(2) {
        let step = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        let middle = [0.5 * (pair[0][0] + pair[1][0]), 0.5 * (pair[0][1] + pair[1][1])];
        bow += step * (middle[1] - chord(middle[0]));
        length += step;
    }
    (bow.abs() > 3e-3 * length * length).then_some(bow > 0.0)
}

/// Returns whether z points up in a wheel's points: whether the flange sticks out to negative z. It
/// is `None` if none sticks out.
fn is_wheel_upward(points: &[[f64; 2]]) -> Option<bool> {
    let tread = tread(points)?;
    let z = || points.iter().map(|point| point[1]);
    let (below, above) =
        (z().fold(f64::NEG_INFINITY, f64::max) - tread, tread - z().fold(f64::INFINITY, f64::min));
    (below.max(above) > 1.5 * below.min(above)).then_some(above > below)
}

/// Returns whether the flange of a wheel, whose z points down, lies at positive y.
fn is_flange_right(points: &[[f64; 2]]) -> bool {
    let y = || points.iter().map(|point| point[0]);
    let middle = 0.5 * (y().fold(f64::INFINITY, f64::min) + y().fold(f64::NEG_INFINITY, f64::max));
    let tip = points.iter().max_by(|a, b| a[1].total_cmp(&b[1]));
    tip.is_some_and(|tip| tip[0] > middle)
}

/// Returns the median of z over the width of a profile.
fn tread(points: &[[f64; 2]]) -> Option<f64> {
    let mut pieces: Vec<[f64; 2]> = points
        .windows(2)
        .map(|pair| [0.5 * (pair[0][1] + pair[1][1]), (pair[1][0] - pair[0][0]).abs()])
        .collect();
    pieces.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let half: f64 = 0.5 * pieces.iter().map(|piece| piece[1]).sum::<f64>();
    let mut passed = 0.0;
    pieces.iter().find_map(|[z, width]| {
        passed += width;
        (passed >= half).then_some(*z)
    })
}
