//! Profiles of rails and wheels, and the text format of SIMPACK for them (.prr, .prw).
//!
//! In a profile's own coordinates y points to the field side and z down, as for a rail and a wheel
//! on the right of a track. The gauge face of a rail and the flange of a wheel lie at negative y.

use super::curve::Curve;

/// The body that a profile belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileKind {
    /// The cross-section of a rail.
    Rail,
    /// The cross-section of a wheel in a plane through its axis.
    Wheel,
}

/// A cross-section of a rail or a wheel. Its curve runs in the order of rising y along the running
/// surface, with the body below it (a rail) or above it (a wheel).
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    kind: ProfileKind,
    curve: Curve,
}

/// The reason why a text or a list of points is no profile.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// A line cannot be read in this format.
    #[error("line {line}: `{found}`: {expected}")]
    Line {
        /// The number of the line, counted from 1.
        line: usize,
        /// The text of the line.
        found: String,
        /// The text that would be right.
        expected: String,
    },
    /// Something that must be there is missing.
    #[error("there is no {missing}; {expected}")]
    Missing {
        /// The name of what is missing.
        missing: &'static str,
        /// The text that would be right.
        expected: &'static str,
    },
    /// The points make no curve.
    #[error("{count} different points are left; a profile needs at least 3, of which {expected}")]
    Points {
        /// The number of points in use.
        count: usize,
        /// The condition that the points must meet.
        expected: &'static str,
    },
    /// A point lies nowhere near a wheel or a rail.
    #[error(
        "point {index} (counted from 1) lies at ({y:e} m, {z:e} m); a profile lies within 10 m of its origin, check the unit of length"
    )]
    Far {
        /// The number of the point, counted from 1, in the order in use.
        index: usize,
        /// The coordinate y \[m\].
        y: f64,
        /// The coordinate z \[m\].
        z: f64,
    },
}

/// The distance \[m\] below which two points are one. It is below what any file resolves, and a
/// spline cannot turn on it.
const SAME_POINT: f64 = 1e-12;

impl Profile {
    /// Creates a profile through `points` (y, z) \[m\], given along the curve in either order.
    ///
    /// # Errors
    /// A [`ProfileError`] reports a point that is not finite or more than 10 m from the origin, or
    /// points that make no curve.
    pub fn from_points(kind: ProfileKind, mut points: Vec<[f64; 2]>) -> Result<Self, ProfileError> {
        if let Some(first) = points.iter().position(|p| !p.iter().all(|v| v.abs() <= 10.0)) {
            let [y, z] = points[first];
            return Err(ProfileError::Far { index: first + 1, y, z });
        }
        points.dedup_by(|next, kept| (next[0] - kept[0]).hypot(next[1] - kept[1]) <= SAME_POINT);
        let count = points.len();
        if let (Some(first), Some(last)) = (points.first(), points.last())
            && first[0] > last[0]
        {
            points.reverse();
        }
        let curve = Curve::through(points)
            .ok_or(ProfileError::Points { count, expected: "no two neighbours coincide" })?;
        Ok(Self { kind, curve })
    }

    /// Reads the profile text of SIMPACK. The steps that the processing data ask for are carried
    /// out in their order: minimum distance of points, shift, rotation, bounds, mirroring,
    /// inversion, unit. Smoothing is refused, for the curve passes through the points. Their
    /// weights have no effect, since only smoothing would use them.
    ///
    /// # Errors
    /// A [`ProfileError`] reports a line that cannot be read, an assignment that is missing, or
    /// points that are refused by [`from_points`](Self::from_points).
    pub fn from_simpack(text: &str) -> Result<Self, ProfileError> {
        let simpack = Simpack::read(text)?;
        let kind = simpack.kind.ok_or(ProfileError::Missing {
            missing: "profile type",
            expected: "the header must say `type = 0` (rail) or 1 (wheel)",
        })?;
        Self::from_points(kind, simpack.processed()?)
    }

    /// Returns the body that the profile belongs to.
    pub fn kind(&self) -> ProfileKind {
        self.kind
    }

    /// Returns the curve, with y and z in metres.
    pub fn curve(&self) -> &Curve {
        &self.curve
    }
}

/// A SIMPACK profile as it stands in the file, in the user's units.
struct Simpack {
    kind: Option<ProfileKind>,
    /// The numbers of the user's units of length per metre and of angle per radian.
    units: Option<[f64; 2]>,
    least_distance: f64,
    shift: [f64; 2],
    rotation: f64,
    /// The lower and upper bounds of y and of z. There is no bound where the lower one is not below
    /// the upper one.
    bounds: [[f64; 2]; 2],
    mirrored: [bool; 2],
    inverted: bool,
    points: Vec<[f64; 2]>,
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
            units: None,
            least_distance: 0.0,
            shift: [0.0; 2],
            rotation: 0.0,
            bounds: [[1.0, 0.0]; 2],
            mirrored: [false; 2],
            inverted: false,
            points: Vec::new(),
        };
        let mut section = Section::Outside;
        let mut units = [None, Some(1.0)];
        for (index, line) in text.lines().enumerate() {
            let (line, body) = (index + 1, without_comment(line).trim());
            if body.is_empty() {
                continue;
            }
            section = match (section, body) {
                (Section::Outside, "header.begin") => Section::Header,
                (Section::Header, "header.end") => Section::Outside,
                (Section::Outside, "spline.begin") => Section::Spline,
                (Section::Spline, "spline.end") => Section::Outside,
                (Section::Spline, "point.begin") => Section::Points,
                (Section::Points, "point.end") => Section::Spline,
                (Section::Points, _) => {
                    profile.points.push(point(line, body)?);
                    section
                }
                (Section::Header | Section::Spline, _) => {
                    let (key, value) = body
                        .split_once('=')
                        .ok_or_else(|| wrong(line, body, "must be `key = value`"))?;
                    let assignment = ProfileSetting { line, key: key.trim(), value: value.trim() };
                    if section == Section::Header {
                        profile.header(&assignment)?
                    } else {
                        profile.processing(&assignment, &mut units)?
                    }
                    section
                }
                (Section::Outside, _) => {
                    return Err(wrong(
                        line,
                        body,
                        "must be `header.begin` or `spline.begin`: nothing else stands outside the two",
                    ));
                }
            };
        }
        if section != Section::Outside {
            return Err(ProfileError::Missing {
                missing: "end of the last block",
                expected: "every `.begin` must have its `.end`",
            });
        }
        if let [Some(length), Some(angle)] = units {
            profile.units = Some([length, angle]);
        }
        Ok(profile)
    }

    fn header(&mut self, assignment: &ProfileSetting) -> Result<(), ProfileError> {
        match assignment.key {
            "version" if assignment.value == "1" => {}
            "version" => {
                return Err(assignment.wrong("this is the version of the format; only 1 is known"));
            }
            "type" => {
                self.kind = Some(match assignment.value {
                    "0" => ProfileKind::Rail,
                    "1" => ProfileKind::Wheel,
                    _ => return Err(assignment.wrong("must be 0 (rail) or 1 (wheel)")),
                });
            }
            _ => return Err(assignment.wrong("the header holds `version` and `type` only")),
        }
        Ok(())
    }

    fn processing(
        &mut self,
        assignment: &ProfileSetting,
        units: &mut [Option<f64>; 2],
    ) -> Result<(), ProfileError> {
        match assignment.key {
            // These keys say where the data came from.
            "file" | "file.mtime" | "comment" | "type" => {}
            "approx.smooth" => {
                if assignment.number()? != 0.0 {
                    return Err(assignment
                        .wrong("smoothing is not done here; smooth the points before and set 0"));
                }
            }
            "point.dist.min" => self.least_distance = assignment.number()?.max(0.0),
            "shift.y" => self.shift[0] = assignment.number()?,
            "shift.z" => self.shift[1] = assignment.number()?,
            "rotate" => self.rotation = assignment.number()?,
            "bound.y.min" => self.bounds[0][0] = assignment.number()?,
            "bound.y.max" => self.bounds[0][1] = assignment.number()?,
            "bound.z.min" => self.bounds[1][0] = assignment.number()?,
            "bound.z.max" => self.bounds[1][1] = assignment.number()?,
            "mirror.y" => self.mirrored[0] = assignment.flag()?,
            "mirror.z" => self.mirrored[1] = assignment.flag()?,
            "inversion" => self.inverted = assignment.flag()?,
            "units.len.f" => units[0] = Some(assignment.unit()?),
            "units.ang.f" => units[1] = Some(assignment.unit()?),
            // These keys name the two units.
            "units.len" | "units.ang" => {}
            _ => {
                return Err(assignment.wrong(
                    "this key is not known; remove it or say what it means with a known one",
                ));
            }
        }
        Ok(())
    }

    /// Returns the points in use (y, z) \[m\].
    fn processed(self) -> Result<Vec<[f64; 2]>, ProfileError> {
        let [length, angle] = self.units.ok_or(ProfileError::Missing {
            missing: "unit of length",
            expected: "`units.len.f` must say how many units make a metre: 1000 for millimetres",
        })?;
        let mut kept: Vec<[f64; 2]> = Vec::with_capacity(self.points.len());
        for point in self.points {
            if kept.last().is_none_or(|last| {
                (point[0] - last[0]).hypot(point[1] - last[1]) >= self.least_distance
            }) {
                kept.push(point);
            }
        }
        let (sin, cos) = (self.rotation / angle).sin_cos();
        for [y, z] in &mut kept {
            let shifted = [*y + self.shift[0], *z + self.shift[1]];
            [*y, *z] = [cos * shifted[0] - sin * shifted[1], sin * shifted[0] + cos * shifted[1]];
        }
        let inside = |v: f64, [low, high]: [f64; 2]| low >= high || (low..=high).contains(&v);
        kept.retain(|&[y, z]| inside(y, self.bounds[0]) && inside(z, self.bounds[1]));
        for point in &mut kept {
            for (v, mirrored) in point.iter_mut().zip(self.mirrored) {
                *v = if mirrored { -*v } else { *v } / length;
            }
        }
        if self.inverted {
            kept.reverse();
        }
        Ok(kept)
    }
}

/// A setting `key = value` with the number of its line.
struct ProfileSetting<'a> {
    line: usize,
    key: &'a str,
    value: &'a str,
}

impl ProfileSetting<'_> {
    fn wrong(&self, expected: &str) -> ProfileError {
        wrong(self.line, &format!("{} = {}", self.key, self.value), expected)
    }

    fn number(&self) -> Result<f64, ProfileError> {
        finite(self.value).ok_or_else(|| self.wrong("must be a finite number"))
    }

    fn unit(&self) -> Result<f64, ProfileError> {
        Some(self.number()?)
            .filter(|unit| unit.is_normal() && *unit > 0.0)
            .ok_or_else(|| self.wrong("must be above 0"))
    }

    fn flag(&self) -> Result<bool, ProfileError> {
        match self.value {
            "0" => Ok(false),
            "1" => Ok(true),
            _ => Err(self.wrong("must be 0 (no) or 1 (yes)")),
        }
    }
}

fn wrong(line: usize, found: &str, expected: &str) -> ProfileError {
    ProfileError::Line {
        line,
        found: found.chars().take(80).collect(),
        expected: expected.to_owned(),
    }
}

/// Reads a finite number; an exponent of Fortran's is accepted.
fn finite(text: &str) -> Option<f64> {
    text.replace(['d', 'D'], "e").parse().ok().filter(|v: &f64| v.is_finite())
}

/// Reads the coordinates y and z, and skips the weight that may follow.
fn point(line: usize, body: &str) -> Result<[f64; 2], ProfileError> {
    let numbers: Option<Vec<f64>> = body.split_whitespace().map(finite).collect();
    match numbers.as_deref() {
        Some([y, z] | [y, z, _]) => Ok([*y, *z]),
        _ => Err(wrong(line, body, "must be y and z, perhaps with a weight, as finite numbers")),
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WHEEL: &str = include_str!("../../../../sweeps/profiles/MBench_S1002_v3.prw");
    const RAIL: &str = include_str!("../../../../sweeps/profiles/MBench_UIC60_v3.prr");

    #[test]
    fn reads_the_benchmarks_wheel_and_rail() {
        let wheel = Profile::from_simpack(WHEEL).unwrap();
        assert_eq!((wheel.kind(), wheel.curve().points().len()), (ProfileKind::Wheel, 399));
        // The profile is mirrored: the flange, its lowest part, lies at negative y, and the field
        // side ends the curve.
        assert_eq!(wheel.curve().points()[0], [-6.9612628e1 / 1e3, 1.3485642e1 / 1e3]);
        assert_eq!(*wheel.curve().points().last().unwrap(), [6e1 / 1e3, -2.6356764 / 1e3]);
        let rail = Profile::from_simpack(RAIL).unwrap();
        assert_eq!((rail.kind(), rail.curve().points().len()), (ProfileKind::Rail, 495));
        assert_eq!(rail.curve().points()[0], [-4.3704898e1 / 1e3, 3.8510726e1 / 1e3]);
        // The crown of the rail is an arc of 300 mm.
        let crown = rail
            .curve()
            .samples(1)
            .into_iter()
            .map(|t| rail.curve().at(t))
            .find(|p| p.position[0] > -0.005)
            .unwrap();
        assert!((crown.curvature() * 0.3 - 1.0).abs() < 1e-3, "{}", crown.curvature());
    }

    fn with(key: &str, value: &str) -> Result<Profile, ProfileError> {
        let line = RAIL.lines().find(|line| line.trim_start().starts_with(key)).unwrap();
        Profile::from_simpack(&RAIL.replace(line, &format!("{key} = {value} ! changed")))
    }

    #[test]
    fn does_what_the_processing_data_say() {
        let plain = Profile::from_simpack(RAIL).unwrap().curve().points().to_vec();
        let near = |found: Result<Profile, ProfileError>, expected: Vec<[f64; 2]>| {
            let found = found.unwrap().curve().points().to_vec();
            assert_eq!(found.len(), expected.len());
            for (a, b) in found.iter().zip(&expected) {
                assert!((a[0] - b[0]).abs() < 1e-15 && (a[1] - b[1]).abs() < 1e-15, "{a:?} {b:?}");
            }
        };
        near(with("shift.y", "1.5"), plain.iter().map(|p| [p[0] + 1.5e-3, p[1]]).collect());
        near(with("shift.z", "-2.5D0"), plain.iter().map(|p| [p[0], p[1] - 2.5e-3]).collect());
        near(with("mirror.y", "1"), plain.iter().rev().map(|p| [-p[0], p[1]]).collect());
        near(with("mirror.z", "1"), plain.iter().map(|p| [p[0], -p[1]]).collect());
        // A profile does not depend on the order of the points.
        near(with("inversion", "1"), plain.clone());
        let (sin, cos) = 0.025f64.sin_cos();
        near(
            with("rotate", "0.025"),
            plain.iter().map(|p| [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1]]).collect(),
        );
        near(with("bound.z.max", "0.9"), plain.clone());
        let text = RAIL
            .replace("bound.z.min    = +1.0", "bound.z.min = -1.0")
            .replace("bound.z.max    = +0.0", "bound.z.max = +2.0");
        near(
            Profile::from_simpack(&text),
            plain.iter().copied().filter(|p| p[1] <= 2e-3).collect(),
        );
        let sparse = with("point.dist.min", "0.9").unwrap().curve().points().to_vec();
        assert!(sparse.len() < plain.len() / 2);
        assert!(
            sparse
                .windows(2)
                .all(|p| (p[0][0] - p[1][0]).hypot(p[0][1] - p[1][1]) >= 0.9e-3 * (1.0 - 1e-9))
        );
    }

    /// Returns the message of the refusal, which must name the line and what would be right.
    fn refusal(found: Result<Profile, ProfileError>) -> String {
        found.unwrap_err().to_string()
    }

    #[test]
    fn refusals_say_where_and_what_would_be_right() {
        for (key, value, says) in [
            ("approx.smooth", "5", "line 19: `approx.smooth = 5`: smoothing is not done here"),
            ("version", "2", "only 1 is known"),
            ("type", "2", "must be 0 (rail) or 1 (wheel)"),
            ("shift.y", "nan", "must be a finite number"),
            ("mirror.y", "2", "must be 0 (no) or 1 (yes)"),
            ("units.len.f", "0", "must be above 0"),
            ("units.len.f", "1e-3", "check the unit of length"),
        ] {
            let message = refusal(with(key, value));
            assert!(message.contains(says), "{key} = {value}: {message}");
        }
        for (from, to, says) in [
            ("    units.len.f", "!", "there is no unit of length"),
            ("    type          =  0", "!", "there is no profile type"),
            ("    point.end", "!", "line 539: `spline.end`: must be y and z"),
            ("  spline.end", "!", "there is no end of the last block"),
            ("    shift.z", "    shift.x", "this key is not known"),
            (
                "-4.3704898E+01",
                "-4.37048.98",
                "line 43: `-4.37048.98\t3.8510726E+01`: must be y and z",
            ),
            ("  header.begin", "  footer.begin", "line 10: `footer.begin`: must be `header.begin`"),
        ] {
            let message = refusal(Profile::from_simpack(&RAIL.replacen(from, to, 1)));
            assert!(message.contains(says), "{message}");
        }
        assert!(refusal(Profile::from_simpack("")).contains("profile type"));
        let short =
            Profile::from_points(ProfileKind::Rail, vec![[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]]);
        assert!(refusal(short).starts_with("2 different points are left"));
    }

    proptest! {
        #[test]
        fn no_text_is_too_odd(text in "(\\PC|[ \n=!'.0-9+-]|point\\.begin|point\\.end|spline\\.begin|spline\\.end|header\\.begin|type = 0\n){0,200}") {
            let _ = Profile::from_simpack(&text);
        }

        #[test]
        fn no_damage_is_too_bad(edits in prop::collection::vec((0usize..17_000, prop_oneof![Just(' '), Just('e'), Just('9'), Just('-'), Just('\n'), Just('!'), any::<char>()]), 1..20)) {
            let mut text: Vec<char> = RAIL.chars().collect();
            for (index, c) in edits {
                let last = text.len() - 1;
                text[index.min(last)] = c;
            }
            if let Ok(profile) = Profile::from_simpack(&text.into_iter().collect::<String>()) {
                prop_assert!(profile.curve().points().len() >= 3);
                let middle = profile.curve().at(0.5 * profile.curve().length());
                prop_assert!(middle.position.iter().chain(&middle.tangent).all(|v| v.is_finite()));
            }
        }
    }
}
