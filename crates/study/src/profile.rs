//! Profiles of wheels and rails, which are read from text files and kept as blobs under the hash
//! of their content.

use contact::punch::{LineFaults, Profile, ProfileError, ProfileKind, ReadProfile};

use crate::encoding::{DecodeError, VERSION, decode, encode};
use crate::file_fault::{FileFaults, FilePlace};
use crate::file_text::{decode_text, known_format};

/// The longest profile that is believed \[bytes\]; a corrupt length must not allocate.
const LIMIT: usize = 16 << 20;

/// Reads a profile of `kind` from the text of SIMPACK, of MiniProf or of a list, or from the bytes
/// that [`encode_profile`] wrote; no text begins like those.
///
/// # Errors
///
/// Returns every fault of the file.
pub fn read(bytes: &[u8], kind: ProfileKind) -> Result<ReadProfile, FileFaults> {
    if bytes.first() == Some(&VERSION) {
        let profile =
            decode_profile(bytes).map_err(|error| FileFaults::whole(error.to_string()))?;
        return Ok(ReadProfile { profile, note: "as it was stored".to_owned() });
    }
    let text = match known_format(bytes) {
        Some(format) => {
            let message = format!("it is {format}; a profile is a text of SIMPACK or MiniProf");
            return Err(FileFaults::whole(message));
        }
        None => decode_text(bytes),
    };
    let not_text = || {
        FileFaults::whole("it is not text: it must be a profile of SIMPACK or MiniProf, or a list")
    };
    let read = Profile::read(&text.ok_or_else(not_text)?, kind).map_err(|error| match error {
        ProfileError::Lines(lines) => faults_of(&lines),
        error => FileFaults::whole(error.to_string()),
    })?;
    match (kind, read.profile.kind()) {
        (ProfileKind::Wheel, ProfileKind::Rail) => Err(FileFaults::whole("it is a rail's")),
        (ProfileKind::Rail, ProfileKind::Wheel) => Err(FileFaults::whole("it is a wheel's")),
        _ => Ok(read),
    }
}

fn faults_of(lines: &LineFaults) -> FileFaults {
    let mut faults = FileFaults::default();
    for fault in lines.shown() {
        faults.add(Some(FilePlace::line(fault.line)), &fault.found, || {
            format!("is refused: {}", fault.expected)
        });
    }
    faults.leave_out(lines.count() - lines.shown().len());
    faults
}

/// Returns the name of a profile in jobs and stores: the BLAKE3 hash of its bytes, in hexadecimal.
pub fn name(profile: &Profile) -> String {
    blake3::hash(&encode_profile(profile)).to_hex().to_string()
}

/// Returns the bytes of a profile.
pub fn encode_profile(profile: &Profile) -> Vec<u8> {
    encode(&(profile.kind() == ProfileKind::Wheel, profile.curve().points()))
}

/// Reads the bytes that [`encode_profile`] wrote.
///
/// # Errors
///
/// Returns an error if the bytes do not decode, or if their points are no profile.
pub fn decode_profile(bytes: &[u8]) -> Result<Profile, DecodeError> {
    const ITEM: &str = "the profile";
    let (is_wheel, points) = decode::<(bool, Vec<[f64; 2]>), LIMIT>(ITEM, bytes)?;
    let kind = if is_wheel { ProfileKind::Wheel } else { ProfileKind::Rail };
    Profile::from_points(kind, points)
        .map_err(|error| DecodeError::Malformed { item: ITEM, reason: error.to_string() })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const WHEEL: &[u8] = include_bytes!("../../../sweeps/profiles/MBench_S1002_v3.prw");

    fn wheel(bytes: &[u8]) -> Result<ReadProfile, String> {
        read(bytes, ProfileKind::Wheel).map_err(|faults| faults.to_string())
    }

    #[test]
    fn stored_profiles_are_those_of_the_file() {
        let profile = wheel(WHEEL).unwrap().profile;
        assert_eq!(profile.kind(), ProfileKind::Wheel);
        let stored = wheel(&encode_profile(&profile)).unwrap().profile;
        assert_eq!((name(&stored), &stored), (name(&profile), &profile));
        let text = String::from_utf8(WHEEL.to_vec()).unwrap();
        let remarked = [b"! a remark about a pr\xfcfung\n", WHEEL].concat();
        let upper = text.replace("header.begin", "HEADER.BEGIN").replace("mirror.y", "Mirror.Y");
        let utf16: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        for other in [&remarked[..], upper.as_bytes(), &utf16] {
            assert_eq!(wheel(other).map(|read| name(&read.profile)), Ok(name(&profile)));
        }
        assert!(wheel(b"\xff\xfe\0").unwrap_err().contains("not text"));
        assert!(wheel(b"").is_err());
        assert_eq!(read(WHEEL, ProfileKind::Rail).unwrap_err().to_string(), "it is a wheel's");
        assert!(decode_profile(&encode(&(true, vec![[0.0, f64::NAN]; 4]))).is_err());
    }

    #[test]
    fn all_lines_at_fault_are_named() {
        let text = String::from_utf8(WHEEL.to_vec()).unwrap();
        let bad = text.replace("shift.z ", "shift.q ").replace("mirror.z ", "mirror.q ");
        let said = wheel(bad.as_bytes()).unwrap_err();
        let places: Vec<&str> = said.split("; line ").collect();
        assert_eq!(places.len(), 2, "{said}");
        let hidden = read(bad.as_bytes(), ProfileKind::Wheel).unwrap_err().words(false);
        assert!(!hidden.contains("shift") && hidden.starts_with("line "), "{hidden}");
    }

    const RAIL: &[u8] = include_bytes!("../../../sweeps/profiles/MBench_UIC60_v3.prr");

    /// Writes the points of a profile \[mm\] as a text, y and z times a sign each.
    fn points(profile: &Profile, signs: [f64; 2], separator: &str) -> String {
        let number = |x: f64| format!("{}", (x * 1e9).round() / 1e6);
        let line = |[y, z]: &[f64; 2]| {
            format!("{}{separator}{}\n", number(signs[0] * y), number(signs[1] * z))
        };
        profile.curve().points().iter().map(line).collect()
    }

    /// Returns whether two profiles have the same points, up to the digits of a text.
    fn are_near(a: &Profile, b: &Profile) -> bool {
        let (a, b) = (a.curve().points(), b.curve().points());
        let near = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]) < 2e-7;
        a.len() == b.len() && a.iter().zip(b).all(near)
    }

    #[test]
    fn lists_and_files_of_miniprof_are_read_whichever_way_they_point() {
        for (file, kind) in [(WHEEL, ProfileKind::Wheel), (RAIL, ProfileKind::Rail)] {
            let exact = read(file, kind).unwrap().profile;
            let miniprof = format!(
                "ProgramName=MiniProf\r\nDate=01-02-2003\r\nColumnDef=X,Y,*\r\nXOffset=0.5\r\n\r\n{}",
                points(&exact, [1.0, -1.0], "\t")
            );
            let moved = read(miniprof.as_bytes(), kind).unwrap();
            assert!(moved.note.contains("2 lines of its header read past"), "{}", moved.note);
            assert!(
                moved.note.ends_with("moved by its offsets, z turned to point down"),
                "{}",
                moved.note
            );
            let shift = moved.profile.extents()[0][0] - exact.extents()[0][0];
            assert!((shift - 0.5e-3).abs() < 2e-7, "{shift}");
            for (signs, separator) in [([1.0, 1.0], " "), ([1.0, -1.0], ","), ([1.0, 1.0], ";")] {
                let text = format!("# a profile\n{}", points(&exact, signs, separator));
                let listed = read(text.as_bytes(), kind).unwrap();
                assert!(are_near(&listed.profile, &exact), "{}", listed.note);
                assert_eq!(listed.note.contains("z turned"), signs[1] < 0.0);
            }
        }
        // The flange of a wheel lies at negative y.
        let wheel = wheel(WHEEL).unwrap().profile;
        let left = read(points(&wheel, [-1.0, 1.0], " ").as_bytes(), ProfileKind::Wheel).unwrap();
        assert!(
            left.note.ends_with("mirrored in y, for its flange lies at positive y"),
            "{}",
            left.note
        );
        assert!(are_near(&left.profile, &wheel));
    }

    #[test]
    fn lists_that_show_no_profile_are_refused() {
        let flat: String = (0..50).map(|k| format!("{k} 0\n")).collect();
        let far: String = (0..50).map(|k| format!("{} {}\n", k * 100, k * k)).collect();
        let zigzag: String = (0..50).map(|k| format!("{} {}\n", k * 37 % 50, k)).collect();
        for (text, says) in [
            (flat.as_str(), "do not show which way z points"),
            (&far, "their unit is not clear"),
            (&zigzag, "do not follow one another"),
            ("1 2\n3 x\n4\n", "line 2: `3 x` is refused: must be y and z"),
            ("y z\n", "a profile needs at least 3"),
            ("root:x:0\n", "line 1: `root:x:0` is refused"),
        ] {
            let said = read(text.as_bytes(), ProfileKind::Rail).unwrap_err().to_string();
            assert!(said.contains(says), "{text}: {said}");
        }
    }

    /// Smoothing moves points by less than the sum that it may reach.
    #[test]
    fn smoothing_is_done() {
        let text = String::from_utf8(WHEEL.to_vec()).unwrap();
        let smooth = text.replacen("approx.smooth  = +0.0000", "approx.smooth = 1e-6 ! ", 1);
        let (plain, smooth) = (wheel(WHEEL).unwrap().profile, wheel(smooth.as_bytes()).unwrap());
        assert!(smooth.note.contains("sum to approx.smooth = 1e-6"), "{}", smooth.note);
        let (a, b) = (plain.curve().points(), smooth.profile.curve().points());
        let sum: f64 =
            a.iter().zip(b).map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sum();
        assert!((sum / 1e-12 - 1.0).abs() < 1e-3, "{sum:e}");
    }

    proptest! {
        #[test]
        fn arbitrary_lists_never_panic(text in "(-?[0-9]{1,3}(\\.[0-9])?| |\n|,|;|=|X|ColumnDef=X,Y\n|!){0,80}") {
            for kind in [ProfileKind::Wheel, ProfileKind::Rail] {
                let _ = read(text.as_bytes(), kind);
            }
        }

        #[test]
        fn damaged_profiles_never_panic(
            at in any::<prop::sample::Index>(),
            byte: u8,
            cut in any::<prop::sample::Index>(),
        ) {
            for mut bytes in [WHEEL.to_vec(), encode_profile(&wheel(WHEEL).unwrap().profile)] {
                let at = at.index(bytes.len());
                bytes[at] = byte;
                let _ = wheel(&bytes);
                bytes.truncate(cut.index(bytes.len()));
                let _ = wheel(&bytes);
            }
        }
    }
}
