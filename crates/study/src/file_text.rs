//! The text of a file in whatever encoding an instrument wrote it, its lines, and its numbers.

use std::borrow::Cow;

use crate::units::LengthUnit;

/// The beginnings of files that are no text, with what they are.
const FORMATS: &[(&[u8], &str)] = &[
    (b"PK\x03\x04", "a ZIP archive, as NPZ and spreadsheets are"),
    (b"\x89HDF", "an HDF5 file"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"GIF8", "a GIF picture"),
    (b"BM", "a BMP picture"),
    (b"\x1f\x8b", "compressed by gzip"),
    (b"BZh", "compressed by bzip2"),
    (b"\xfd7zXZ", "compressed by xz"),
    (b"\x28\xb5\x2f\xfd", "compressed by zstd"),
    (b"MATLAB 5.0", "a MATLAB file"),
    (b"GWYP", "a Gwyddion file"),
    (b"GWYO", "a Gwyddion file"),
    (b"DIGITAL SURF", "a Digital Surf file"),
    (b"DSCOMPRESSED", "a Digital Surf file"),
    (b"\x88\x1b\x03\x6f", "a Zygo MetroPro file"),
    (b"\x88\x1b\x03\x70", "a Zygo MetroPro file"),
    (b"\x88\x1b\x03\x71", "a Zygo MetroPro file"),
    (b"%PDF", "a PDF document"),
    (b"\x7fELF", "a program"),
];

/// Returns what a file is by its beginning, if it is known and no text.
pub(crate) fn known_format(bytes: &[u8]) -> Option<&'static str> {
    let control = |byte: &u8| *byte < b' ' && !matches!(byte, b'\t' | b'\n' | b'\r' | 0x0c | 0x1a);
    // A text may begin with letters that a format begins with.
    let is_binary = || bytes.iter().take(4096).any(|byte| control(byte) || *byte >= 0x80);
    let (_, noun) = FORMATS.iter().find(|(magic, _)| bytes.starts_with(magic))?;
    is_binary().then_some(noun)
}

/// Decodes a text in UTF-8, UTF-16 with or without a mark of its byte order, or Latin-1; `None` if
/// it is none of these.
pub(crate) fn decode_text(bytes: &[u8]) -> Option<Cow<'_, str>> {
    let utf16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let (pairs, rest) = bytes.as_chunks::<2>();
        let units = pairs.iter().map(|pair| unit(*pair));
        let text: Option<String> = char::decode_utf16(units).map(Result::ok).collect();
        text.filter(|text| rest.is_empty() && is_plain(text)).map(Cow::Owned)
    };
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => {
            return std::str::from_utf8(rest).ok().filter(|text| is_plain(text)).map(Cow::Borrowed);
        }
        [0xff, 0xfe, rest @ ..] => return utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => return utf16(rest, u16::from_be_bytes),
        _ => {}
    }
    // Half of the bytes of digits in UTF-16 are 0.
    let beginning = &bytes[..bytes.len().min(1024)];
    let zeros = |from: usize| beginning.iter().skip(from).step_by(2).filter(|byte| **byte == 0);
    let (even, odd) = (zeros(0).count(), zeros(1).count());
    if odd > beginning.len() / 3 && even == 0 {
        return utf16(bytes, u16::from_le_bytes);
    }
    if even > beginning.len() / 3 && odd == 0 {
        return utf16(bytes, u16::from_be_bytes);
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => is_plain(text).then_some(Cow::Borrowed(text)),
        Err(_) => {
            let text: String = bytes.iter().map(|byte| char::from(*byte)).collect();
            let is_printed = |c: char| !('\u{7f}'..'\u{a0}').contains(&c);
            (is_plain(&text) && text.chars().all(is_printed)).then_some(Cow::Owned(text))
        }
    }
}

/// Returns whether a text has no control characters but those that move the carriage or end a file.
fn is_plain(text: &str) -> bool {
    text.bytes().all(|byte| byte >= b' ' || matches!(byte, b'\t' | b'\n' | b'\r' | 0x0c | 0x1a))
}

/// Returns the lines of a text with their numbers, counted from 1, whatever ends them: `\n`,
/// `\r\n` or `\r`.
pub(crate) fn numbered_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let text = text.trim_end_matches(['\u{1a}', '\0']);
    // Only the old Macintosh ends lines with `\r` alone.
    let end = if text.contains('\n') { '\n' } else { '\r' };
    let lines = text.split(end).map(|line| line.trim_matches(['\r', '\u{feff}']));
    lines.enumerate().map(|(index, line)| (index + 1, line))
}

/// A reader of numbers in a unit of length, which keeps its memory.
pub(crate) struct NumberReader {
    unit: LengthUnit,
    has_decimal_comma: bool,
    text: String,
}

impl NumberReader {
    /// Creates a reader of numbers in `unit`.
    pub(crate) fn new(unit: LengthUnit, has_decimal_comma: bool) -> Self {
        Self { unit, has_decimal_comma, text: String::new() }
    }

    /// Returns the metres that a word says, correctly rounded; `None` if it is no finite number. An
    /// exponent may be written with an `e` or, as in Fortran, a `d`.
    pub(crate) fn read(&mut self, word: &str) -> Option<f64> {
        let has_point = !self.has_decimal_comma;
        if let Some(value) = self.unit.metres_at_once(word).filter(|_| has_point) {
            return Some(value);
        }
        let is_plain = |byte: u8| match byte {
            b'.' => has_point,
            _ => matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'e' | b'E'),
        };
        let word = if word.bytes().all(is_plain) {
            word
        } else {
            self.text.clear();
            for c in word.chars() {
                self.text.push(match c {
                    ',' if self.has_decimal_comma => '.',
                    // A point cannot group digits beside a comma that divides them.
                    '.' if self.has_decimal_comma => return None,
                    'd' | 'D' => 'e',
                    '\u{2212}' => '-',
                    _ => c,
                });
            }
            &self.text
        };
        // Words such as `inf` are no digits.
        if word.bytes().any(|byte| byte.is_ascii_alphabetic() && !matches!(byte, b'e' | b'E')) {
            return None;
        }
        self.unit.metres(word).filter(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn texts_are_read_in_the_encodings_of_instruments() {
        let text = "Höhe [µm]\r\n1,5\t2\n";
        let utf16 = |order: fn(u16) -> [u8; 2]| -> Vec<u8> {
            text.encode_utf16().flat_map(order).collect()
        };
        let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
        for bytes in [
            text.as_bytes().to_vec(),
            [b"\xef\xbb\xbf", text.as_bytes()].concat(),
            latin,
            utf16(u16::to_le_bytes),
            utf16(u16::to_be_bytes),
            [vec![0xff, 0xfe], utf16(u16::to_le_bytes)].concat(),
            [vec![0xfe, 0xff], utf16(u16::to_be_bytes)].concat(),
        ] {
            assert_eq!(decode_text(&bytes).as_deref(), Some(text), "{bytes:?}");
        }
        for bytes in [&b"\x01\x02"[..], b"a\0b", b"\xff\xfe\x00", b"\x80\x81\x82"] {
            assert_eq!(decode_text(bytes), None, "{bytes:?}");
        }
        assert_eq!(
            known_format(b"PK\x03\x04\0\0"),
            Some("a ZIP archive, as NPZ and spreadsheets are")
        );
        assert_eq!(known_format(b"BM a text"), None);
    }

    #[test]
    fn lines_end_in_three_ways() {
        for text in ["a\nb\n", "a\r\nb\r\n", "a\rb\r", "a\nb\n\u{1a}"] {
            let lines: Vec<(usize, &str)> = numbered_lines(text).collect();
            assert_eq!(lines[..2], [(1, "a"), (2, "b")], "{text:?}");
        }
    }

    #[test]
    fn numbers_are_rounded_once() {
        let read = |unit: &str, comma: bool, word: &str| {
            NumberReader::new(LengthUnit::find(unit).unwrap(), comma).read(word)
        };
        assert_eq!(read("um", false, "1.0D-6"), Some(1e-12));
        assert_eq!(read("um", true, "-0,3"), Some(-3e-7));
        assert_eq!(read("mm", false, "\u{2212}5."), Some(-5e-3));
        assert_eq!(read("um", false, "0.3"), read("mm", false, "0.0003"));
        assert_eq!(read("in", false, "2"), read("mm", false, "50.8"));
        for (comma, word) in [
            (true, "1.5"),
            (false, "1,5"),
            (false, "inf"),
            (false, "nan"),
            (false, ""),
            (false, "1e999"),
            (false, "1e"),
            (false, "e5"),
            (false, "0x10"),
            (false, "1 2"),
        ] {
            assert_eq!(read("um", comma, word), None, "{word}");
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_text_or_none(bytes in proptest::collection::vec(any::<u8>(), 0..100)) {
            if let Some(text) = decode_text(&bytes) {
                let lines = numbered_lines(&text).count();
                prop_assert!(lines > 0);
            }
            let _ = known_format(&bytes);
        }

        #[test]
        fn any_word_is_a_number_or_none(word in "\\PC{0,20}") {
            let mut reader = NumberReader::new(LengthUnit::find("in").unwrap(), false);
            prop_assert!(reader.read(&word).is_none_or(f64::is_finite));
        }
    }
}
