//! Height maps, which are read from NPY or text and kept as blobs under the hash of their content.
//!
//! An NPY header is read here rather than by a crate: the one at hand multiplies the shape
//! unchecked and recurses on nested Python literals, so that a damaged file could take the process
//! down.

use contact::punch::{Surface, SurfaceError};

use crate::encoding::{DecodeError, decode, encode};
use crate::units::metres;

/// The largest number of heights of one map, a bound for files whose header is damaged.
const MAX_HEIGHTS: usize = 1 << 27;

/// The reason why a file holds no height map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceFileError {
    /// The heights are no surface.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The NPY file cannot be read.
    #[error("it is an NPY file that {0}")]
    Npy(String),
    /// The file is neither NPY nor text.
    #[error("it is neither an NPY file nor text")]
    NotText,
    /// Something in the text is not a number.
    #[error("line {line}: `{text}` is not a finite number")]
    NotANumber {
        /// The line, counted from 1.
        line: usize,
        /// The text that stands there.
        text: String,
    },
    /// The lines are of different length.
    #[error("line {line} is not as long as those before it: {found} against {expected} numbers")]
    Ragged {
        /// The line, counted from 1.
        line: usize,
        /// The count of numbers on it.
        found: usize,
        /// The count of numbers on the lines before.
        expected: usize,
    },
    /// The unit is no unit of length.
    #[error("`{0}` is not a unit of length")]
    Unit(String),
}

/// Reads a matrix of heights in `unit`. The file is an NPY file of two dimensions, or text with a
/// row on each line and numbers separated by commas, semicolons or blanks, in which `#` begins a
/// comment. Rows run along y, the first one at the lowest y; columns run along x.
///
/// # Errors
///
/// Returns an error if the unit is no length, or if the bytes are no such matrix.
pub fn read(bytes: &[u8], unit: &str) -> Result<Surface, SurfaceFileError> {
    let to_metres = metres(unit).ok_or_else(|| SurfaceFileError::Unit(unit.to_owned()))?;
    let HeightMatrix { rows, columns, mut heights } =
        if bytes.starts_with(NPY_MAGIC) { read_npy(bytes)? } else { read_text(bytes)? };
    // −0 becomes 0, so that equal heights have one name.
    heights.iter_mut().for_each(|height| *height = to_metres(*height) + 0.0);
    Ok(Surface::new(columns, rows, heights)?)
}

/// Returns the name of a surface in jobs and stores: the BLAKE3 hash of its bytes, in hexadecimal.
pub fn name(surface: &Surface) -> String {
    blake3::hash(&encode_surface(surface)).to_hex().to_string()
}

/// Returns the bytes of a surface.
pub fn encode_surface(surface: &Surface) -> Vec<u8> {
    encode(&(surface.columns() as u64, surface.rows() as u64, surface.heights()))
}

/// Reads the bytes that [`encode_surface`] wrote.
///
/// # Errors
///
/// Returns an error if the bytes do not decode, or if their heights are no surface.
pub fn decode_surface(bytes: &[u8]) -> Result<Surface, DecodeError> {
    const ITEM: &str = "the surface";
    let (columns, rows, heights) =
        decode::<(u64, u64, Vec<f64>), { MAX_HEIGHTS * 8 + 64 }>(ITEM, bytes)?;
    let size = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    Surface::new(size(columns), size(rows), heights)
        .map_err(|error| DecodeError::Malformed { item: ITEM, reason: error.to_string() })
}

/// The heights of a file, row after row.
struct HeightMatrix {
    rows: usize,
    columns: usize,
    heights: Vec<f64>,
}

fn read_text(bytes: &[u8]) -> Result<HeightMatrix, SurfaceFileError> {
    let text = std::str::from_utf8(bytes).map_err(|_| SurfaceFileError::NotText)?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (mut rows, mut columns, mut heights) = (0, 0, Vec::new());
    for (index, line) in text.lines().enumerate() {
        let content = line.split('#').next().unwrap_or_default().trim();
        if content.is_empty() {
            continue;
        }
        let separator = [',', ';'].into_iter().find(|separator| content.contains(*separator));
        let before = heights.len();
        let mut push = |word: &str| -> Result<(), SurfaceFileError> {
            let number = word.trim().parse::<f64>().ok().filter(|x| x.is_finite());
            heights.push(number.ok_or_else(|| SurfaceFileError::NotANumber {
                line: index + 1,
                text: word.trim().to_owned(),
            })?);
            Ok(())
        };
        match separator {
            Some(separator) => content.split(separator).try_for_each(&mut push)?,
            None => content.split_whitespace().try_for_each(&mut push)?,
        }
        let found = heights.len() - before;
        if rows > 0 && found != columns {
            return Err(SurfaceFileError::Ragged { line: index + 1, found, expected: columns });
        }
        (rows, columns) = (rows + 1, found);
    }
    Ok(HeightMatrix { rows, columns, heights })
}

const NPY_MAGIC: &[u8] = b"\x93NUMPY";

/// Reads an NPY file: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.
fn read_npy(bytes: &[u8]) -> Result<HeightMatrix, SurfaceFileError> {
    let bad = |fault: &str| SurfaceFileError::Npy(fault.to_owned());
    let truncated = || bad("ends before its header does");
    let (start, length) = match bytes.get(6) {
        Some(1) => match bytes.get(8..10) {
            Some(&[a, b]) => (10, usize::from(u16::from_le_bytes([a, b]))),
            _ => return Err(truncated()),
        },
        Some(2 | 3) => match bytes.get(8..12) {
            Some(&[a, b, c, d]) => (12, u32::from_le_bytes([a, b, c, d]) as usize),
            _ => return Err(truncated()),
        },
        _ => return Err(bad("has an unknown version")),
    };
    let end = start + length;
    let header = bytes.get(start..end).ok_or_else(truncated)?;
    let header = std::str::from_utf8(header).map_err(|_| bad("has a damaged header"))?;
    let after =
        |key: &str| header.split_once(&format!("'{key}':")).map(|(_, rest)| rest.trim_start());
    let descr = after("descr")
        .and_then(|rest| rest.strip_prefix('\''))
        .and_then(|rest| rest.split('\'').next());
    let descr = descr.ok_or_else(|| bad("does not hold plain numbers"))?;
    let by_columns = match after("fortran_order") {
        Some(rest) if rest.starts_with("True") => true,
        Some(rest) if rest.starts_with("False") => false,
        _ => return Err(bad("has a damaged header")),
    };
    let shape = after("shape")
        .and_then(|rest| rest.strip_prefix('('))
        .and_then(|rest| rest.split(')').next());
    let shape = shape.ok_or_else(|| bad("has a damaged header"))?;
    let sizes: Vec<&str> =
        shape.split(',').map(str::trim).filter(|size| !size.is_empty()).collect();
    let [rows, columns] = sizes[..] else {
        return Err(SurfaceFileError::Npy(format!("has {} dimensions, not 2", sizes.len())));
    };
    let size = |text: &str| text.parse::<usize>().ok();
    let count = size(rows)
        .zip(size(columns))
        .and_then(|(rows, columns)| Some((rows, columns, rows.checked_mul(columns)?)));
    let Some((rows, columns, count)) = count.filter(|(_, _, count)| *count <= MAX_HEIGHTS) else {
        return Err(SurfaceFileError::Npy(format!(
            "is too large: {rows} × {columns} heights, more than {MAX_HEIGHTS}"
        )));
    };
    let heights = numbers(descr, bytes.get(end..).unwrap_or_default(), count)?;
    if !by_columns {
        return Ok(HeightMatrix { rows, columns, heights });
    }
    let transposed = (0..rows).flat_map(|row| (0..columns).map(move |column| column * rows + row));
    let heights = transposed.filter_map(|index| heights.get(index).copied()).collect();
    Ok(HeightMatrix { rows, columns, heights })
}

fn numbers(descr: &str, body: &[u8], count: usize) -> Result<Vec<f64>, SurfaceFileError> {
    macro_rules! read {
        ($type:ty, $big:expr) => {{
            const SIZE: usize = size_of::<$type>();
            if body.len() != count * SIZE {
                let message = format!(
                    "has {} bytes of heights where its header says {}",
                    body.len(),
                    count * SIZE
                );
                return Err(SurfaceFileError::Npy(message));
            }
            let (chunks, _) = body.as_chunks::<SIZE>();
            // At most 53 bits matter in a height.
            let read = |bytes: &[u8; SIZE]| {
                if $big { <$type>::from_be_bytes(*bytes) } else { <$type>::from_le_bytes(*bytes) }
            };
            Ok(chunks.iter().map(|bytes| read(bytes) as f64).collect())
        }};
    }
    let big = descr.starts_with('>');
    match descr.trim_start_matches(['<', '>', '|', '=']) {
        "f8" => read!(f64, big),
        "f4" => read!(f32, big),
        "i8" => read!(i64, big),
        "i4" => read!(i32, big),
        "i2" => read!(i16, big),
        "i1" => read!(i8, big),
        "u8" => read!(u64, big),
        "u4" => read!(u32, big),
        "u2" => read!(u16, big),
        "u1" => read!(u8, big),
        _ => Err(SurfaceFileError::Npy(format!(
            "holds `{descr}`, neither floating-point nor whole numbers"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn npy(descr: &str, fortran: &str, shape: &str, body: &[u8]) -> Vec<u8> {
        let mut header =
            format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}");
        while (10 + header.len() + 1) % 64 != 0 {
            header.push(' ');
        }
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(body);
        bytes
    }

    #[test]
    fn text_and_npy_agree() {
        let surface = read(b"# um\n1, 2, 3\n4, 5, 6 # last\n", "um").unwrap();
        assert_eq!((surface.columns(), surface.rows()), (3, 2));
        assert_eq!(surface.heights(), [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6]);
        assert_eq!(read(b"1;2;3\r\n4;5;6", "um").unwrap(), surface);
        assert_eq!(read(b"\xef\xbb\xbf1 2\t3\n\n  4 5 6\n", "um").unwrap(), surface);
        let doubles: Vec<u8> = (1..=6).flat_map(|x| f64::from(x).to_le_bytes()).collect();
        assert_eq!(read(&npy("<f8", "False", "(2, 3)", &doubles), "um").unwrap(), surface);
        let by_columns: Vec<u8> =
            [1, 4, 2, 5, 3, 6].iter().flat_map(|x| i16::to_be_bytes(*x)).collect();
        assert_eq!(read(&npy(">i2", "True", "(2, 3)", &by_columns), "um").unwrap(), surface);
        assert_eq!(name(&surface), name(&read(b"1e-6 2e-6 3e-6\n4e-6 5e-6 6e-6", "m").unwrap()));
        assert_ne!(name(&surface), name(&read(b"1 2\n3 4\n5 6", "um").unwrap()));
    }

    #[test]
    fn the_bytes_and_the_name_are_fixed() {
        let surface = read(b"1 2\n3 4\n0 -0\n", "m").unwrap();
        insta::assert_snapshot!(name(&surface), @"bf3de6e0509f95f2996d7e0e6a2c6cfff94ac546ded61b5277b27200a61da07b");
        assert_eq!(decode_surface(&encode_surface(&surface)), Ok(surface));
        assert!(decode_surface(&encode(&(2u64, 2u64, vec![0.0; 3]))).is_err());
        assert!(decode_surface(&encode(&(u64::MAX, u64::MAX, vec![0.0; 1]))).is_err());
        assert!(decode_surface(&encode(&(1u64, 1u64, vec![f64::NAN]))).is_err());
    }

    #[test]
    fn what_is_no_height_map_says_why() {
        let message = |bytes: &[u8]| read(bytes, "um").unwrap_err().to_string();
        assert_eq!(
            message(b"1 2\n3"),
            "line 2 is not as long as those before it: 1 against 2 numbers"
        );
        assert_eq!(message(b"1 2\n3 x"), "line 2: `x` is not a finite number");
        assert_eq!(message(b"0,5;0,6"), "line 1: `5;0` is not a finite number");
        assert_eq!(message(b"1 nan"), "line 1: `nan` is not a finite number");
        assert_eq!(
            message(b""),
            "0 heights do not fill 0 columns × 0 rows; it must be a full rectangle of at least 1 × 1"
        );
        assert_eq!(message(&[0xff, 0xfe]), "it is neither an NPY file nor text");
        assert_eq!(
            message(&npy("<f8", "False", "(2,)", &[])),
            "it is an NPY file that has 1 dimensions, not 2"
        );
        assert_eq!(
            message(&npy("<f8", "False", "(1, 1)", &[0; 7])),
            "it is an NPY file that has 7 bytes of heights where its header says 8"
        );
        assert_eq!(
            message(&npy("<c16", "False", "(1, 1)", &[])),
            "it is an NPY file that holds `<c16`, neither floating-point nor whole numbers"
        );
        assert!(
            message(&npy("<f8", "False", "(99999999999, 99999999999)", &[])).contains("too large")
        );
        assert!(message(b"\x93NUMPY\x02\x00\xff\xff\xff\xff").contains("ends before"));
        assert!(
            message(&npy("<f8", "False", "(1, 1)", &f64::NAN.to_le_bytes()))
                .contains("not a finite number")
        );
        assert_eq!(read(b"1", "GPa").unwrap_err().to_string(), "`GPa` is not a unit of length");
    }

    proptest! {
        #[test]
        fn damaged_files_never_panic(
            at in any::<prop::sample::Index>(),
            byte: u8,
            cut in any::<prop::sample::Index>(),
        ) {
            let mut bytes = npy("<f8", "False", "(2, 3)", &[0; 48]);
            let at = at.index(bytes.len());
            bytes[at] = byte;
            let _ = read(&bytes, "m");
            bytes.truncate(cut.index(bytes.len()));
            let _ = read(&bytes, "m");
            let _ = decode_surface(&bytes);
        }

        #[test]
        fn arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = read(&bytes, "m");
            let _ = read(&[NPY_MAGIC, &bytes].concat(), "m");
            let _ = decode_surface(&[&[1], &bytes[..]].concat());
        }
    }
}
