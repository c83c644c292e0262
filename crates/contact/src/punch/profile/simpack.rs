//! The profile files of SIMPACK (.prr, .prw).

use super::kind::{ProfileError, ProfileKind, ReadPoints};
use super::smooth::smoothed;
use super::words::{LineFaults, finite, numbered_lines, per_metre};

/// Keys that say where the data came from or what was measured on them. They cannot change the
/// curve.
const HARMLESS: &[&str] = &[
    "file",
    "file.mtime",
    "comment",
    "name",
    "title",
    "description",
    "date",
    "time",
    "author",
    "creator",
    "id",
];

/// Returns whether a text has the blocks of SIMPACK's format.
pub(super) fn is_simpack(text: &str) -> bool {
    numbered_lines(text).any(|(_, line)| {
        let line = without_comment(line).trim().to_lowercase();
        matches!(line.as_str(), "header.begin" | "spline.begin")
    })
}

/// Reads a profile.
pub(super) fn read(text: &str) -> Result<ReadPoints, ProfileError> {
    let simpack = Simpack::read(text)?;
    let kind = simpack.kind.ok_or(ProfileError::Missing {
        missing: "profile type",
        expected: "the header must say `type = 0` (rail) or 1 (wheel)",
    })?;
    let note = simpack.note();
    Ok(ReadPoints { kind, points: simpack.processed()?, note })
}

/// A SIMPACK profile as it stands in the file, in the user's units.
struct Simpack {
    kind: Option<ProfileKind>,
    /// The numbers of the user's units of length per metre and of angle per radian.
    units: [Option<f64>; 2],
    /// The number of units of length per metre by the unit's name.
    named_unit: Option<f64>,
    smoothing: f64,
    least_distance: f64,
    shift: [f64; 2],
    rotation: f64,
    /// The lower and upper bounds of y and of z. There is no bound where the lower one is not below
    /// the upper one.
    bounds: [[f64; 2]; 2],
    mirrored: [bool; 2],
    inverted: bool,
    points: Vec<WeightedPoint>,
    /// The keys that were read past, in their order.
    read_past: Vec<String>,
}

/// A point with its weight in smoothing.
#[derive(Clone, Copy)]
struct WeightedPoint {
    place: [f64; 2],
    weight: f64,
}

/// The block of the file that a line stands in.
#[derive(Clone, Copy, PartialEq)]
enum Section {
    Outside,
    Header,
    Spline,
    Points,
}

impl Simpack {
    fn read(text: &str) -> Result<Self, ProfileError> {
        let mut profile = Self {
            kind: None,
            units: [None, Some(1.0)],
            named_unit: None,
            smoothing: 0.0,
            least_distance: 0.0,
            shift: [0.0; 2],
            rotation: 0.0,
            bounds: [[1.0, 0.0]; 2],
            mirrored: [false; 2],
            inverted: false,
            points: Vec::new(),
            read_past: Vec::new(),
        };
        let mut section = Section::Outside;
        let mut faults = LineFaults::default();
        for (line, text) in numbered_lines(text) {
            let body = without_comment(text).trim();
            if body.is_empty() {
                continue;
            }
            section = match (section, body.to_lowercase().as_str()) {
                (Section::Outside, "header.begin") => Section::Header,
                (Section::Header, "header.end") => Section::Outside,
                (Section::Outside, "spline.begin") => Section::Spline,
                (Section::Spline, "spline.end") => Section::Outside,
                (Section::Spline, "point.begin") => Section::Points,
                (Section::Points, "point.end") => Section::Spline,
                (Section::Points, _) => {
                    match point(body) {
                        Ok(point) => profile.points.push(point),
                        Err(expected) => faults.add(line, body, expected),
                    }
                    section
                }
                (Section::Header | Section::Spline, _) => {
                    let setting = match body.split_once('=') {
                        Some((key, value)) => {
                            let key = key.trim().to_lowercase();
                            let setting = ProfileSetting { key: &key, value: value.trim() };
                            match section {
                                Section::Header => profile.header(&setting),
                                _ => profile.processing(&setting),
                            }
                        }
                        None => Err("must be `key = value`"),
                    };
                    if let Err(expected) = setting {
                        faults.add(line, body, expected);
                    }
                    section
                }
                (Section::Outside, _) => {
                    faults.add(
                        line,
                        body,
                        "must be `header.begin` or `spline.begin`: nothing else stands outside the two",
                    );
                    section
                }
            };
        }
        if !faults.is_empty() {
            return Err(ProfileError::Lines(faults));
        }
        if section != Section::Outside {
            return Err(ProfileError::Missing {
                missing: "end of the last block",
                expected: "every `.begin` must have its `.end`",
            });
        }
        Ok(profile)
    }

    fn header(&mut self, setting: &ProfileSetting) -> Result<(), &'static str> {
        match setting.key {
            "version" if finite(setting.value) == Some(1.0) => {}
            "version" => return Err("this is the version of the format; only 1 is known"),
            "type" => {
                self.kind = Some(match setting.value {
                    "0" => ProfileKind::Rail,
                    "1" => ProfileKind::Wheel,
                    _ => return Err("must be 0 (rail) or 1 (wheel)"),
                });
            }
            key => self.read_past(key)?,
        }
        Ok(())
    }

    fn processing(&mut self, setting: &ProfileSetting) -> Result<(), &'static str> {
        match setting.key {
            "approx.smooth" => {
                self.smoothing = setting.number()?;
                if self.smoothing < 0.0 {
                    return Err("must not be below 0");
                }
            }
            "point.dist.min" => self.least_distance = setting.number()?.max(0.0),
            "shift.y" => self.shift[0] = setting.number()?,
            "shift.z" => self.shift[1] = setting.number()?,
            "rotate" => self.rotation = setting.number()?,
            "bound.y.min" => self.bounds[0][0] = setting.number()?,
            "bound.y.max" => self.bounds[0][1] = setting.number()?,
            "bound.z.min" => self.bounds[1][0] = setting.number()?,
            "bound.z.max" => self.bounds[1][1] = setting.number()?,
            "mirror.y" => self.mirrored[0] = setting.flag()?,
            "mirror.z" => self.mirrored[1] = setting.flag()?,
            "inversion" => self.inverted = setting.flag()?,
            "units.len.f" => self.units[0] = Some(setting.unit()?),
            "units.ang.f" => self.units[1] = Some(setting.unit()?),
            "units.len" => self.named_unit = per_metre(setting.value),
            // These keys name the type of the original file and the unit of angles.
            "type" | "units.ang" => {}
            key => self.read_past(key)?,
        }
        Ok(())
    }

    /// Notes a key that cannot change the curve, and refuses any other.
    fn read_past(&mut self, key: &str) -> Result<(), &'static str> {
        if key.starts_with("meas.") {
            self.read_past.push(key.to_owned());
        } else if !HARMLESS.contains(&key) {
            return Err(
                "this key is not known; it may change the curve, so remove it or say what \
                        it means with a known one",
            );
        }
        Ok(())
    }

    /// Says what is done to the points.
    fn note(&self) -> String {
        let mut note = "in SIMPACK's format".to_owned();
        for (mirrored, axis) in self.mirrored.iter().zip(["y", "z"]) {
            if *mirrored {
                note += &format!(", mirrored in {axis}");
            }
        }
        if self.shift != [0.0; 2] || self.rotation != 0.0 {
            note += ", shifted or turned as the file says";
        }
        if self.bounds.iter().any(|[low, high]| low < high) {
            note += ", cut at the bounds of the file";
        }
        if self.smoothing > 0.0 {
            note += &format!(
                ", smoothed until the squared distances of the points sum to approx.smooth = {:e}",
                self.smoothing
            );
        }
        if !self.read_past.is_empty() {
            note += &format!("; read past {}", self.read_past.join(", "));
        }
        note
    }

    /// Returns the points in use (y, z) \[m\].
    fn processed(self) -> Result<Vec<[f64; 2]>, ProfileError> {
        let missing = ProfileError::Missing {
            missing: "unit of length",
            expected: "`units.len.f` must say how many units make a metre: 1000 for millimetres",
        };
        let length = match (self.units[0], self.named_unit) {
            (Some(factor), Some(named)) if (factor / named - 1.0).abs() > 1e-6 => {
                return Err(ProfileError::Unclear(
                    "`units.len.f` and `units.len` name different units of length",
                ));
            }
            (factor, named) => factor.or(named).ok_or(missing)?,
        };
        let angle = self.units[1].unwrap_or(1.0);
        let mut kept: Vec<WeightedPoint> = Vec::with_capacity(self.points.len());
        for point in self.points {
            let [y, z] = point.place;
            if kept.last().is_none_or(|last| {
                (y - last.place[0]).hypot(z - last.place[1]) >= self.least_distance
            }) {
                kept.push(point);
            }
        }
        let (sin, cos) = (self.rotation / angle).sin_cos();
        for WeightedPoint { place: [y, z], .. } in &mut kept {
            let shifted = [*y + self.shift[0], *z + self.shift[1]];
            [*y, *z] = [cos * shifted[0] - sin * shifted[1], sin * shifted[0] + cos * shifted[1]];
        }
        let inside = |v: f64, [low, high]: [f64; 2]| low >= high || (low..=high).contains(&v);
        kept.retain(|point| {
            inside(point.place[0], self.bounds[0]) && inside(point.place[1], self.bounds[1])
        });
        for point in &mut kept {
            for (v, mirrored) in point.place.iter_mut().zip(self.mirrored) {
                *v = if mirrored { -*v } else { *v };
            }
        }
        if self.inverted {
            kept.reverse();
        }
        let mut points: Vec<[f64; 2]> = kept.iter().map(|point| point.place).collect();
        if self.smoothing > 0.0 {
            kept.dedup_by(|next, kept| next.place == kept.place);
            points = kept.iter().map(|point| point.place).collect();
            let weights: Vec<f64> = kept.iter().map(|point| point.weight).collect();
            points = smoothed(&points, &weights, self.smoothing).ok_or(ProfileError::Unclear(
                "`approx.smooth` is so large that smoothing leaves a straight line, or there are \
                 fewer than three points",
            ))?;
        }
        Ok(points.into_iter().map(|place| place.map(|v| v / length)).collect())
    }
}

/// A setting `key = value`, the key in small letters.
struct ProfileSetting<'a> {
    key: &'a str,
    value: &'a str,
}

impl ProfileSetting<'_> {
    fn number(&self) -> Result<f64, &'static str> {
        finite(self.value).ok_or("must be a finite number")
    }

    fn unit(&self) -> Result<f64, &'static str> {
        Some(self.number()?).filter(|unit| unit.is_normal() && *unit > 0.0).ok_or("must be above 0")
    }

    fn flag(&self) -> Result<bool, &'static str> {
        match finite(self.value) {
            Some(0.0) => Ok(false),
            Some(1.0) => Ok(true),
            _ => Err("must be 0 (no) or 1 (yes)"),
        }
    }
}

/// Reads the coordinates y and z, and the weight that may follow. A weight of 0 is none.
fn point(body: &str) -> Result<WeightedPoint, &'static str> {
    let numbers: Option<Vec<f64>> = body.split_whitespace().map(finite).collect();
    match numbers.as_deref() {
        Some([y, z]) => Ok(WeightedPoint { place: [*y, *z], weight: 1.0 }),
        Some([_, _, weight]) if *weight > 0.0 && !(1e-6..=1e6).contains(weight) => {
            Err("must have a weight between 1e-6 and 1e6, or 0 for the usual one")
        }
        Some([y, z, weight]) => {
            let weight = if *weight > 0.0 { *weight } else { 1.0 };
            Ok(WeightedPoint { place: [*y, *z], weight })
        }
        _ => Err("must be y and z, perhaps with a weight, as finite numbers"),
    }
}

/// Returns a line up to its comment, which a `!` outside of quotes begins.
fn without_comment(line: &str) -> &str {
    let mut quoted = false;
    for (index, c) in line.char_indices() {
        match c {
            '\'' => quoted = !quoted,
            '!' if !quoted => return &line[..index],
            _ => {}
        }
    }
    line
}
