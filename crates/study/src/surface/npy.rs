//! Matrices in NPY files.
//!
//! The header is read here rather than by a crate: the one at hand multiplies the shape unchecked
//! and recurses on nested Python literals, so that a damaged file could take the process down.

use super::heights::{HeightMatrix, MAX_HEIGHTS};
use crate::file_fault::FileFaults;
use crate::units::LengthUnit;

/// The bytes with which every NPY file begins.
pub(super) const NPY_MAGIC: &[u8] = b"\x93NUMPY";

/// The longest header that is believed \[bytes\]; those of plain arrays have some hundred.
const MAX_HEADER: usize = 1 << 16;

/// Reads an NPY file: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.
pub(super) fn read_npy(bytes: &[u8], unit: LengthUnit) -> Result<HeightMatrix, FileFaults> {
    let header = Header::read(bytes)?;
    let Header { rows, columns, .. } = header;
    let mut heights = header.numbers(&bytes[header.end..])?;
    if header.by_columns {
        let transposed =
            (0..rows).flat_map(|row| (0..columns).map(move |column| column * rows + row));
        heights = transposed.filter_map(|index| heights.get(index).copied()).collect();
    }
    heights.iter_mut().for_each(|height| *height = unit.metres_of(*height));
    Ok(HeightMatrix { rows, columns, heights })
}

fn bad(fault: impl AsRef<str>) -> FileFaults {
    FileFaults::whole(format!("it is an NPY file that {}", fault.as_ref()))
}

/// The header of an NPY file.
struct Header<'a> {
    /// The type of the numbers, as NumPy writes it.
    descr: &'a str,
    by_columns: bool,
    rows: usize,
    columns: usize,
    /// The index of the first byte of the numbers.
    end: usize,
}

impl<'a> Header<'a> {
    fn read(bytes: &'a [u8]) -> Result<Self, FileFaults> {
        let truncated = || bad("ends before its header does");
        let damaged = || bad("has a damaged header");
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
        if length > MAX_HEADER {
            return Err(bad(format!(
                "has a header of {length} bytes; that of a plain array has at most {MAX_HEADER}"
            )));
        }
        let end = start + length;
        let header = bytes.get(start..end).ok_or_else(truncated)?;
        let header = std::str::from_utf8(header).map_err(|_| damaged())?;
        let after = |key: &str| {
            ['\'', '"'].iter().find_map(|quote| {
                let (_, rest) = header.split_once(&format!("{quote}{key}{quote}:"))?;
                Some(rest.trim_start())
            })
        };
        let descr = after("descr").ok_or_else(damaged)?;
        if descr.starts_with('[') {
            return Err(bad("holds records with named fields; save one field as a plain array"));
        }
        let quote = descr.chars().next().filter(|c| matches!(c, '\'' | '"'));
        let descr = quote.and_then(|quote| descr[1..].split(quote).next()).ok_or_else(damaged)?;
        let by_columns = match after("fortran_order") {
            Some(rest) if rest.starts_with("True") => true,
            Some(rest) if rest.starts_with("False") => false,
            _ => return Err(damaged()),
        };
        let shape = after("shape").and_then(|rest| rest.strip_prefix('('));
        let shape = shape.and_then(|rest| rest.split(')').next()).ok_or_else(damaged)?;
        let sizes: Vec<&str> =
            shape.split(',').map(str::trim).filter(|size| !size.is_empty()).collect();
        let [rows, columns] = sizes[..] else {
            let dimensions = if sizes.len() == 1 { "dimension" } else { "dimensions" };
            return Err(bad(format!("has {} {dimensions}, not 2", sizes.len())));
        };
        let size = |text: &str| text.trim_end_matches('L').parse::<u64>().map_err(|_| damaged());
        let (rows, columns) = (size(rows)?, size(columns)?);
        if rows.checked_mul(columns).is_none_or(|count| count > MAX_HEIGHTS as u64) {
            return Err(bad(format!(
                "is too large: {rows} × {columns} heights, more than {MAX_HEIGHTS}"
            )));
        }
        Ok(Self { descr, by_columns, rows: rows as usize, columns: columns as usize, end })
    }

    /// Returns the numbers in the order of the file.
    fn numbers(&self, body: &[u8]) -> Result<Vec<f64>, FileFaults> {
        let count = self.rows * self.columns;
        macro_rules! read {
            ($type:ty) => {{
                let chunks = self.values::<{ size_of::<$type>() }>(body, count)?;
                // At most 53 bits matter in a height.
                let read: fn([u8; size_of::<$type>()]) -> $type = match self.descr.as_bytes() {
                    [b'>', ..] => <$type>::from_be_bytes,
                    _ => <$type>::from_le_bytes,
                };
                Ok(chunks.iter().map(|bytes| read(*bytes) as f64).collect())
            }};
        }
        let what = match self.descr.trim_start_matches(['<', '>', '|', '=']) {
            "f8" => return read!(f64),
            "f4" => return read!(f32),
            "f2" => {
                let is_big = self.descr.starts_with('>');
                let read = |bytes: &[u8; 2]| match is_big {
                    true => half(u16::from_be_bytes(*bytes)),
                    false => half(u16::from_le_bytes(*bytes)),
                };
                return Ok(self.values::<2>(body, count)?.iter().map(read).collect());
            }
            "i8" => return read!(i64),
            "i4" => return read!(i32),
            "i2" => return read!(i16),
            "i1" => return read!(i8),
            "u8" => return read!(u64),
            "u4" => return read!(u32),
            "u2" => return read!(u16),
            "u1" => return read!(u8),
            "b1" => "truth values, which are no heights",
            "O" => "Python objects; save the numbers as a plain array, of a masked one its data",
            descr if descr.starts_with(['f', 'g']) => "numbers of extended precision; save float64",
            descr if descr.starts_with('c') => "complex numbers; save their real parts",
            descr if descr.starts_with(['U', 'S', 'a']) => "texts; save numbers",
            descr if descr.starts_with(['M', 'm']) => "dates or times, which are no heights",
            _ => "neither floating-point nor whole numbers",
        };
        Err(bad(format!("holds {what}")))
    }

    fn values<'b, const SIZE: usize>(
        &self,
        body: &'b [u8],
        count: usize,
    ) -> Result<&'b [[u8; SIZE]], FileFaults> {
        if body.len() != count * SIZE {
            return Err(bad(format!(
                "has {} bytes of heights where its header says {}",
                body.len(),
                count * SIZE
            )));
        }
        Ok(body.as_chunks::<SIZE>().0)
    }
}

/// Returns the value of a number in half precision (IEEE 754 binary16).
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff) / 1024.0);
    sign * match exponent {
        0 => fraction * 2f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2f64.powi(exponent - 15),
    }
}
