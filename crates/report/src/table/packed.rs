//! Cells of a column as bytes that take little room and give back the same cells.
//!
//! ```text
//! 0, tag, value          every cell is this one
//! 1, tag, values         every cell has this tag
//! 2, tags, values        the tag of each cell, then the values of those that have one
//! ```
//!
//! Numbers and whole numbers are 8 bytes, little-endian, flags one byte, and texts their lengths as
//! 4 bytes each, followed by all their bytes. Whoever reads them knows how many there are.

use super::cell::Cell;

const NUMBER: u8 = 0;
const INTEGER: u8 = 1;
const FLAG: u8 = 2;
const TEXT: u8 = 3;
const MISSING: u8 = 4;

const REPEATED: u8 = 0;
const UNIFORM: u8 = 1;
const MIXED: u8 = 2;

fn tag(cell: &Cell) -> u8 {
    match cell {
        Cell::Number(_) => NUMBER,
        Cell::Integer(_) => INTEGER,
        Cell::Flag(_) => FLAG,
        Cell::Text(_) => TEXT,
        Cell::Missing => MISSING,
    }
}

/// Returns whether two cells have the same bytes: NaN is like itself, and 0 is unlike −0.
fn is_alike(a: &Cell, b: &Cell) -> bool {
    match (a, b) {
        (Cell::Number(a), Cell::Number(b)) => a.to_bits() == b.to_bits(),
        (Cell::Number(_), _) | (_, Cell::Number(_)) => false,
        (a, b) => a == b,
    }
}

/// Writes cells as bytes; `None` if a text is longer than 4 GiB.
pub fn packed_cells<'c>(cells: impl Iterator<Item = &'c Cell> + Clone) -> Option<Vec<u8>> {
    let Some(first) = cells.clone().next() else { return Some(Vec::new()) };
    let mut bytes = Vec::new();
    if cells.clone().all(|cell| is_alike(cell, first)) {
        bytes.extend([REPEATED, tag(first)]);
        add_values(&mut bytes, std::iter::once(first))?;
    } else if cells.clone().all(|cell| tag(cell) == tag(first)) {
        bytes.extend([UNIFORM, tag(first)]);
        add_values(&mut bytes, cells)?;
    } else {
        bytes.push(MIXED);
        bytes.extend(cells.clone().map(tag));
        add_values(&mut bytes, cells)?;
    }
    Some(bytes)
}

/// Adds the values of cells, and the bytes of their texts at the end.
fn add_values<'c>(
    bytes: &mut Vec<u8>,
    cells: impl Iterator<Item = &'c Cell> + Clone,
) -> Option<()> {
    for cell in cells.clone() {
        match cell {
            Cell::Number(x) => bytes.extend(x.to_bits().to_le_bytes()),
            Cell::Integer(i) => bytes.extend(i.to_le_bytes()),
            Cell::Flag(yes) => bytes.push(u8::from(*yes)),
            Cell::Text(text) => bytes.extend(u32::try_from(text.len()).ok()?.to_le_bytes()),
            Cell::Missing => {}
        }
    }
    for cell in cells {
        if let Cell::Text(text) = cell {
            bytes.extend_from_slice(text.as_bytes());
        }
    }
    Some(())
}

/// Reads so many cells from bytes that [`packed_cells`] wrote; `None` if these hold others, or
/// fewer or more. What is not there takes no memory.
pub fn unpacked_cells(bytes: &[u8], count: usize) -> Option<Vec<Cell>> {
    let all: Vec<usize> = match count <= bytes.len() || bytes.first() == Some(&REPEATED) {
        true => (0..count).collect(),
        false => return None,
    };
    picked_cells(bytes, count, &all)
}

/// Reads those of so many cells whose numbers are given in ascending order, like
/// [`unpacked_cells`]. Texts that are not picked are not copied.
pub fn picked_cells(bytes: &[u8], count: usize, picked: &[usize]) -> Option<Vec<Cell>> {
    if picked.last().is_some_and(|last| *last >= count) {
        return None;
    }
    if count == 0 {
        return bytes.is_empty().then(Vec::new);
    }
    let (form, rest) = bytes.split_first()?;
    match *form {
        REPEATED => {
            let (tags, values) = rest.split_at_checked(1)?;
            let cell = cells_of(tags, values, &[0])?.pop()?;
            Some(vec![cell; picked.len()])
        }
        UNIFORM => {
            let (tag, values) = rest.split_first()?;
            let least = match *tag {
                NUMBER | INTEGER => 8,
                FLAG => 1,
                TEXT => 4,
                // Cells of which every one is missing are repeated.
                _ => return None,
            };
            if values.len() / least < count {
                return None;
            }
            cells_of(&vec![*tag; count], values, picked)
        }
        MIXED => {
            let (tags, values) = rest.split_at_checked(count)?;
            cells_of(tags, values, picked)
        }
        _ => None,
    }
}

/// Reads some of the cells with these tags, by their numbers, from the values of all.
fn cells_of(tags: &[u8], values: &[u8], picked: &[usize]) -> Option<Vec<Cell>> {
    let length = |tag: &u8| match *tag {
        NUMBER | INTEGER => Some(8),
        FLAG => Some(1),
        TEXT => Some(4),
        MISSING => Some(0),
        _ => None,
    };
    let fixed: usize = tags.iter().map(length).sum::<Option<usize>>()?;
    let (mut values, texts) = values.split_at_checked(fixed)?;
    let mut texts = std::str::from_utf8(texts).ok()?;
    let mut cells = Vec::with_capacity(picked.len());
    let mut wanted = picked.iter().copied().peekable();
    for (number, tag) in tags.iter().enumerate() {
        let is_picked = wanted.next_if_eq(&number).is_some();
        let cell = match *tag {
            NUMBER => Cell::Number(f64::from_bits(u64::from_le_bytes(taken(&mut values)?))),
            INTEGER => Cell::Integer(i64::from_le_bytes(taken(&mut values)?)),
            FLAG => match taken(&mut values)? {
                [0] => Cell::Flag(false),
                [1] => Cell::Flag(true),
                _ => return None,
            },
            TEXT => {
                let length = u32::from_le_bytes(taken(&mut values)?) as usize;
                let (text, rest) = texts.split_at_checked(length)?;
                texts = rest;
                if is_picked { Cell::Text(text.to_owned()) } else { Cell::Missing }
            }
            _ => Cell::Missing,
        };
        if is_picked {
            cells.push(cell);
        }
    }
    texts.is_empty().then_some(cells)
}

/// Takes bytes from the front of others.
fn taken<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*first)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn cell() -> impl Strategy<Value = Cell> {
        prop_oneof![
            any::<u64>().prop_map(|bits| Cell::Number(f64::from_bits(bits))),
            prop_oneof![Just(0.0), Just(-0.0), Just(f64::NAN), Just(0.3)].prop_map(Cell::Number),
            any::<i64>().prop_map(Cell::Integer),
            any::<bool>().prop_map(Cell::Flag),
            ".{0,6}".prop_map(Cell::Text),
            Just(Cell::Missing),
        ]
    }

    fn cells() -> impl Strategy<Value = Vec<Cell>> {
        let repeated = (cell(), 0..50usize).prop_map(|(cell, count)| vec![cell; count]);
        let numbers = proptest::collection::vec(any::<f64>().prop_map(Cell::Number), 0..50);
        let texts = proptest::collection::vec("[ab]{0,2}".prop_map(Cell::Text), 0..50);
        prop_oneof![repeated, numbers, texts, proptest::collection::vec(cell(), 0..50)]
    }

    fn are_alike(a: &[Cell], b: &[Cell]) -> bool {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_alike(a, b))
    }

    proptest! {
        #[test]
        fn cells_are_read_as_they_were_written(cells in cells()) {
            let bytes = packed_cells(cells.iter()).unwrap();
            let read = unpacked_cells(&bytes, cells.len()).unwrap();
            prop_assert!(are_alike(&read, &cells), "{read:?} {cells:?}");
            let odd: Vec<usize> = (0..cells.len()).filter(|number| number % 2 == 1).collect();
            let expected: Vec<Cell> = odd.iter().map(|number| cells[*number].clone()).collect();
            let picked = picked_cells(&bytes, cells.len(), &odd).unwrap();
            prop_assert!(are_alike(&picked, &expected), "{picked:?} {cells:?}");
            prop_assert!(picked_cells(&bytes, cells.len(), &[cells.len()]).is_none());
            for cut in 0..bytes.len() {
                let read = unpacked_cells(&bytes[..cut], cells.len());
                prop_assert!(read.is_none(), "cut to {}: {:?}", cut, read);
            }
        }

        #[test]
        fn other_bytes_are_no_danger(
            bytes in proptest::collection::vec(0..6u8, 0..60), count in 0..70usize,
        ) {
            if let Some(read) = unpacked_cells(&bytes, count) {
                prop_assert_eq!(read.len(), count);
            }
            prop_assert!(unpacked_cells(&[1, 0, 0], 1 << 40).is_none());
        }
    }

    #[test]
    fn a_cell_that_is_repeated_takes_no_room() {
        let cells = vec![Cell::from("certified"); 1000];
        assert_eq!(packed_cells(cells.iter()).unwrap().len(), 2 + 4 + 9);
    }
}
