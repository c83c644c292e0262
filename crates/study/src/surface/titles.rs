//! Titles of columns and of heights, with the units that they name: `X [mm]; Y [mm]; Z [µm]`,
//! `x_um,y_um,z_um`, `Height (nm)`.

use crate::file_fault::{FileFaults, FilePlace};
use crate::units::LengthUnit;

/// Names of heights in titles, in lower case.
const HEIGHTS: &[&str] = &[
    "z",
    "h",
    "height",
    "heights",
    "depth",
    "elevation",
    "topography",
    "höhe",
    "hauteur",
    "altezza",
    "altura",
];

/// The title of a column: its name in lower case and the word of its unit, without brackets.
struct Title<'a> {
    name: String,
    unit: Option<&'a str>,
}

/// The unit that a title gives for heights.
pub(super) enum TitleUnit {
    /// A unit of length.
    Length(LengthUnit),
    /// A word that is none.
    Unknown,
}

impl<'a> Title<'a> {
    /// Reads `Z [µm]`, `z(um)`, `X/mm`, `height_um`, `x in mm` or `x`.
    fn read(text: &'a str) -> Self {
        let text = text.trim().trim_matches(['"', '\'']).trim();
        let (name, unit) = if let Some((name, unit)) = text.split_once(['[', '(']) {
            (name, unit.split([']', ')']).next())
        } else if let Some((name, unit)) = text.split_once('/') {
            (name, Some(unit))
        } else if let Some((name, unit)) = text.split_once(" in ") {
            (name, Some(unit))
        } else {
            // Behind a blank or a `_` stands a unit or more of the name.
            match text.rsplit_once(['_', ' ']).filter(|(_, unit)| unit_of(unit).is_some()) {
                Some((name, unit)) => (name, Some(unit)),
                None => (text, None),
            }
        };
        let name = name.to_lowercase();
        let name = name.split(['_', ' ']).find(|part| !part.is_empty()).unwrap_or_default();
        Title { name: name.to_owned(), unit: unit.map(str::trim).filter(|unit| !unit.is_empty()) }
    }

    fn is_of_heights(&self) -> bool {
        HEIGHTS.contains(&self.name.as_str())
    }
}

/// Returns the units of x, y and z if a line has their titles. What a title gives in place of a
/// unit of length is a fault.
pub(super) fn list_titles(
    line: usize,
    text: &str,
    faults: &mut FileFaults,
) -> Option<[Option<LengthUnit>; 3]> {
    // No titles are as long as this.
    if text.len() > 200 {
        return None;
    }
    let parts: Vec<&str> = match text.contains([',', ';', '\t']) {
        true => {
            text.split([',', ';', '\t']).map(str::trim).filter(|part| !part.is_empty()).collect()
        }
        false => text.split_whitespace().filter(|part| !part.starts_with(['[', '('])).collect(),
    };
    let mut titles: Vec<Title<'_>> = parts.iter().map(|part| Title::read(part)).collect();
    let [x, y, z] = &mut titles[..] else { return None };
    if x.name != "x" || y.name != "y" || !z.is_of_heights() {
        return None;
    }
    if [&*x, y, z].iter().all(|title| title.unit.is_none()) {
        // `x [mm] y [mm] z [um]` and `x y z [mm]` have their units apart.
        let units: Vec<&str> = text
            .split(['[', '('])
            .skip(1)
            .filter_map(|rest| rest.split([']', ')']).next())
            .collect();
        match units[..] {
            [a, b, c] => (x.unit, y.unit, z.unit) = (Some(a), Some(b), Some(c)),
            [one] => (x.unit, y.unit, z.unit) = (Some(one), Some(one), Some(one)),
            _ => {}
        }
    } else if x.unit.is_none()
        && y.unit.is_none()
        && parts.len() == 3
        && !text.contains([',', ';', '\t'])
    {
        // A unit behind the last of titles that are separated by blanks holds for all of them.
        (x.unit, y.unit) = (z.unit, z.unit);
    }
    let mut unit = |word: Option<&str>| {
        let word = word?;
        let unit = unit_of(word);
        if unit.is_none() {
            faults.add(Some(FilePlace::line(line)), word, || {
                "stands where a unit is due and is no unit of length known here".to_owned()
            });
        }
        unit
    };
    Some([unit(x.unit), unit(y.unit), unit(z.unit)])
}

/// Returns the unit that a line gives for heights if it is their title: `Height Sensor(nm)`.
pub(super) fn height_unit(text: &str) -> Option<TitleUnit> {
    if text.len() > 200 || text.contains([',', ';', '\t', ':', '=']) {
        return None;
    }
    let title = Title::read(text);
    let word = title.unit.filter(|_| title.is_of_heights())?;
    match unit_of(word) {
        Some(unit) => Some(TitleUnit::Length(unit)),
        // Other brackets may hold a remark.
        None => (word.chars().count() <= 4 && !word.contains(' ')).then_some(TitleUnit::Unknown),
    }
}

/// Returns the unit of length that a word means: `µm`, `[mm]`, `micrometers`.
pub(super) fn unit_of(word: &str) -> Option<LengthUnit> {
    let word = word.trim().trim_matches(['[', ']', '(', ')', '"', '\'', '.']).trim();
    let symbol = match word.to_lowercase().as_str() {
        "meter" | "meters" | "metre" | "metres" => "m",
        "millimeter" | "millimeters" | "millimetre" | "millimetres" => "mm",
        "micrometer" | "micrometers" | "micrometre" | "micrometres" | "micron" | "microns" => "um",
        "nanometer" | "nanometers" | "nanometre" | "nanometres" => "nm",
        "inch" | "inches" => "in",
        _ => word,
    };
    LengthUnit::find(symbol)
}
