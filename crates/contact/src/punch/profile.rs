//! Profiles of rails and wheels, and the text formats in which they come.
//!
//! In a profile's own coordinates y points to the field side and z down, as for a rail and a wheel
//! on the right of a track. The gauge face of a rail and the flange of a wheel lie at negative y.
//!
//! In reading order:
//! - `words`: lines, numbers and faults of a text;
//! - `kind`: the body, the points of a text, and the reasons why it gives none;
//! - `smooth`: the smoothing spline;
//! - `simpack`: SIMPACK's files (.prr, .prw);
//! - `listed`: MiniProf's files (.ban, .whl) and plain lists of y and z.

mod kind;
mod listed;
mod simpack;
mod smooth;
mod words;

use super::curve::Curve;
use kind::ReadPoints;
pub use kind::{ProfileError, ProfileKind};
pub use words::LineFaults;

/// A cross-section of a rail or a wheel. Its curve runs in the order of rising y along the running
/// surface, with the body below it (a rail) or above it (a wheel).
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    kind: ProfileKind,
    curve: Curve,
}

/// A profile as it was read from a text.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadProfile {
    /// The profile.
    pub profile: Profile,
    /// The format and what was done to the points, in words.
    pub note: String,
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

    /// Reads a profile of `kind` in SIMPACK's format, in MiniProf's, or as a list of y and z.
    ///
    /// # Errors
    /// A [`ProfileError`] reports every line that cannot be read, or why the points are no profile
    /// of this kind.
    pub fn read(text: &str, kind: ProfileKind) -> Result<ReadProfile, ProfileError> {
        let ReadPoints { kind, points, note } = match simpack::is_simpack(text) {
            true => simpack::read(text)?,
            false => listed::read(text, kind)?,
        };
        Ok(ReadProfile { profile: Self::from_points(kind, points)?, note })
    }

    /// Reads the profile text of SIMPACK. The steps that the processing data ask for are carried
    /// out in their order: minimum distance of points, shift, rotation, bounds, mirroring,
    /// inversion, unit, smoothing.
    ///
    /// # Errors
    /// A [`ProfileError`] reports the lines that cannot be read, an assignment that is missing, or
    /// points that are refused by [`from_points`](Self::from_points).
    pub fn from_simpack(text: &str) -> Result<Self, ProfileError> {
        let read = simpack::read(text)?;
        Self::from_points(read.kind, read.points)
    }

    /// Returns the body that the profile belongs to.
    pub fn kind(&self) -> ProfileKind {
        self.kind
    }

    /// Returns the curve, with y and z in metres.
    pub fn curve(&self) -> &Curve {
        &self.curve
    }

    /// Returns the lowest and the highest y and z of the points \[m\].
    pub fn extents(&self) -> [[f64; 2]; 2] {
        let range = |axis: usize| {
            let values = || self.curve.points().iter().map(|point| point[axis]);
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
        };
        [range(0), range(1)]
    }
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
            ("approx.smooth", "-5", "line 19: `approx.smooth = -5`: must not be below 0"),
            ("approx.smooth", "1e9", "smoothing leaves a straight line"),
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
