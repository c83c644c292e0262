//! Height maps, which are read from NPY or text and kept as blobs under the hash of their content.
//!
//! In reading order:
//! - `heights`: the matrix of heights;
//! - `npy`: matrices in NPY files;
//! - `header`: what the header of a text says about its matrix;
//! - `matrix`: matrices and lists as text;
//! - `titles`: titles of columns and of heights, with their units;
//! - `points`: lists of x, y and z whose points lie on a grid;
//! - `missing`: pixels that a file marks as missing.

mod header;
mod heights;
mod matrix;
mod missing;
mod npy;
mod points;
#[cfg(test)]
mod tests;
mod titles;
mod topics;

use contact::punch::Surface;

use self::header::StatedWidth;
use self::heights::HeightMatrix;
use self::matrix::{ListUnits, MatrixText, compare_counts};
use self::missing::Marks;
pub use self::missing::MissingRule;
use self::npy::{NPY_MAGIC, read_npy};
use self::points::{PointGrid, PointList};
use crate::encoding::{DecodeError, VERSION, decode_as, encode, encode_as};
use crate::file_fault::{FileFaults, FilePlace};
use crate::file_text::{decode_text, known_format};
use crate::units::{Compact, LengthUnit};

/// The number of columns up to which a text may be a list of points: to read one as points before
/// it is read as heights takes the time twice.
const MOST_LIST_COLUMNS: usize = 8;

/// The largest number of heights of a stored map, a bound for damaged bytes.
const MAX_STORED: usize = 1 << 27;

/// The number of lines beyond which up to three columns, or rows, of text are taken for a list
/// rather than a map.
const LONGEST_STRIP: usize = 12;

/// The number of lines beyond which three columns, or rows, of an NPY file are taken for a list.
const LONGEST_NPY_STRIP: usize = 100;

/// The format of a map of which some pixels are no part of the sole.
const VERSION_WITH_ABSENT: u8 = 2;

/// The way in which a study wants a file of heights to be read.
#[derive(Clone, Copy, Debug, Default)]
pub struct MapReading<'a> {
    /// The unit of the heights; without it that of the file's header, else the metre.
    pub unit: Option<&'a str>,
    /// The unit of coordinates in the file; without it that of its header, else that of the
    /// heights.
    pub lateral_unit: Option<&'a str>,
    /// The treatment of missing pixels.
    pub missing: MissingRule,
    /// A number that marks a missing pixel, in the unit of the heights.
    pub missing_value: Option<f64>,
}

/// A height map as it was read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    /// The surface.
    pub surface: Surface,
    /// The extents along x and y that the file states, if it does.
    pub extents: [Option<MapExtent>; 2],
    /// The layout of the file, its unit and what was done, in words.
    pub note: String,
}

/// An extent of a map as its file states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapExtent {
    /// The extent \[m\].
    pub width: f64,
    /// The part of it by which it may be off, for its digits are few.
    pub tolerance: f64,
    /// The line that states it, counted from 1; `None` if all points of a list do.
    pub line: Option<usize>,
    /// The fact that neither the file nor the study names the unit of coordinates. It is taken to
    /// be that of the heights unless the study's widths tell otherwise.
    pub is_unit_free: bool,
}

impl MapExtent {
    /// Returns whether a width \[m\] agrees with the extent.
    pub(crate) fn agrees(&self, width: f64) -> bool {
        (width - self.width).abs() <= self.tolerance * self.width
    }
}

/// Reads a matrix of heights, or a list of points with x, y and z. The file is an NPY file of two
/// dimensions, or text. In a matrix rows run along y, the first one at the lowest y; columns run
/// along x. The book says which headers, marks and comments a text may have.
///
/// # Errors
///
/// Returns every fault of the file.
pub fn read(bytes: &[u8], reading: &MapReading<'_>) -> Result<HeightMap, FileFaults> {
    let unit = |symbol: Option<&str>| match symbol {
        None => Ok(None),
        Some(symbol) => LengthUnit::find(symbol)
            .map(Some)
            .ok_or_else(|| FileFaults::whole(format!("`{symbol}` is not a unit of length"))),
    };
    let units = StatedUnits { heights: unit(reading.unit)?, lateral: unit(reading.lateral_unit)? };
    let mut marks = Marks::default();
    let mut faults = FileFaults::default();
    let raw = if bytes.starts_with(NPY_MAGIC) {
        RawMap::of_npy(bytes, units, &mut marks, &mut faults)?
    } else {
        let text = match known_format(bytes) {
            Some(format) => {
                let message = format!("it is {format}; save the heights as text or NPY");
                return Err(FileFaults::whole(message));
            }
            None => decode_text(bytes)
                .ok_or_else(|| FileFaults::whole("it is neither an NPY file nor text"))?,
        };
        RawMap::of_text(&text, units, &mut marks, &mut faults)
    };
    raw.finish(reading, marks, faults)
}

/// The units that a study states.
#[derive(Clone, Copy)]
struct StatedUnits {
    heights: Option<LengthUnit>,
    lateral: Option<LengthUnit>,
}

impl StatedUnits {
    fn heights(self) -> LengthUnit {
        self.heights.unwrap_or(LengthUnit::METRE)
    }

    fn lateral(self) -> LengthUnit {
        self.lateral.unwrap_or(self.heights())
    }
}

/// A map before its missing pixels are dealt with.
struct RawMap {
    matrix: HeightMatrix,
    unit: LengthUnit,
    extents: [Option<MapExtent>; 2],
    /// The number that the file's header says to mark missing pixels.
    missing: Option<f64>,
    layout: String,
}

impl RawMap {
    fn of_npy(
        bytes: &[u8],
        units: StatedUnits,
        marks: &mut Marks,
        faults: &mut FileFaults,
    ) -> Result<Self, FileFaults> {
        let unit = units.heights();
        let matrix = read_npy(bytes, unit)?;
        if matrix.heights.is_empty() {
            faults.add(None, "", || "there are no heights in it".to_owned());
        }
        let none = RawMap {
            matrix,
            unit,
            extents: [None; 2],
            missing: None,
            layout: "a matrix in NPY, its first row at the lowest y".to_owned(),
        };
        (0..none.matrix.heights.iter().filter(|height| height.is_nan()).count()).for_each(|_| {
            marks.count("nan");
        });
        let HeightMatrix { rows, columns, .. } = none.matrix;
        let is_grid_on_its_side = || {
            let heights = &none.matrix.heights;
            let points =
                (0..columns).flat_map(|point| (0..3).map(move |row| row * columns + point));
            let points = points.filter_map(|place| heights.get(place).copied()).collect();
            let list = HeightMatrix { rows: columns, columns: 3, heights: points };
            matches!(PointList::of(&list, false), PointList::Grid(_))
        };
        if rows == 3 && columns > 3 && (columns > LONGEST_NPY_STRIP || is_grid_on_its_side()) {
            faults.add(None, "", || {
                format!(
                    "it has 3 rows of {columns} numbers, as lists of x, of y and of z have; save a \
                     list with one point in a row, and a map with a fourth row"
                )
            });
        }
        if columns != 3 {
            return Ok(none);
        }
        // A matrix of NPY states its shape, so that a short one is a list only if it is a grid.
        let list = match PointList::of(&none.matrix, false) {
            PointList::Grid(mut grid) => {
                if units.lateral() != unit {
                    let ratio = units.lateral().metres_of(1.0) / unit.metres_of(1.0);
                    for length in grid.widths.iter_mut().chain(&mut grid.centre) {
                        *length *= ratio;
                    }
                }
                (0..grid.vacant).for_each(|_| {
                    marks.count("no point");
                });
                Self::of_points(grid, unit, units.lateral.is_none())
            }
            PointList::Unusable(reason) => {
                faults.add(None, "", || reason);
                none
            }
            PointList::None => {
                if rows > LONGEST_NPY_STRIP {
                    faults.add(None, "", || {
                        format!(
                            "it has 3 columns and {rows} rows, but is no list of x, y and z whose \
                             points lie on a grid; sample the points on a grid, and save a map \
                             with a fourth column"
                        )
                    });
                }
                none
            }
        };
        Ok(list)
    }

    fn of_points(grid: PointGrid, unit: LengthUnit, is_unit_free: bool) -> Self {
        let PointGrid { matrix, widths, centre, vacant } = grid;
        let extents = widths.map(|width| {
            let extent = MapExtent { width, tolerance: 1e-3, line: None, is_unit_free };
            (width > 0.0).then_some(extent)
        });
        let mut layout = format!(
            "a list of x, y and z, whose middle at ({} m, {} m) becomes the origin",
            Compact(centre[0]),
            Compact(centre[1])
        );
        if vacant > 0 {
            layout += &format!(", {vacant} places of its grid without a point");
        }
        Self { matrix, unit, extents, missing: None, layout }
    }

    fn of_text(text: &str, units: StatedUnits, marks: &mut Marks, faults: &mut FileFaults) -> Self {
        let mut text = MatrixText::new(text, faults);
        let [title_x, title_y, title_z] = text.titles.unwrap_or_default();
        let said = text.facts.height_unit.map(|fact| fact.value).or(title_z);
        if let (Some(unit), Some(said)) = (units.heights, said)
            && unit != said
        {
            let place = text.facts.height_unit.map(|fact| FilePlace::line(fact.line));
            faults.add(place, "", || {
                format!(
                    "the header says that the heights are in {}, the study says {}",
                    said.symbol(),
                    unit.symbol()
                )
            });
        }
        let unit = units.heights.or(said).unwrap_or(LengthUnit::METRE);
        let lateral_said = text.facts.lateral_unit.map(|fact| fact.value).or(title_x).or(title_y);
        if let (Some(unit), Some(said)) = (units.lateral, lateral_said)
            && unit != said
        {
            faults.add(None, "", || {
                format!(
                    "its header says that x and y are in {}, the study says {}",
                    said.symbol(),
                    unit.symbol()
                )
            });
        }
        let stated = units.lateral.or(lateral_said);
        let lateral = stated.unwrap_or(unit);
        let list_units = ListUnits { lateral, heights: unit, is_free: stated.is_none() };
        if (3..=MOST_LIST_COLUMNS).contains(&text.columns())
            && let Some(list) = Self::of_list(&text, list_units, marks, faults)
        {
            return list;
        }
        let matrix = text.heights(unit, marks, faults);
        if let Some(list) =
            strip(&matrix).filter(|_| faults.is_empty() && text.facts.counts[0].is_none())
        {
            faults.add(None, "", || {
                let HeightMatrix { rows, columns, .. } = matrix;
                format!(
                    "it has {columns} {} and {rows} {}: {list}? If it is a matrix, save it as NPY",
                    if columns == 1 { "column" } else { "columns" },
                    if rows == 1 { "row" } else { "rows" },
                )
            });
        }
        compare_counts(&text.facts, &matrix, faults);
        text.facts.compare_lengths([matrix.columns, matrix.rows], lateral, faults);
        if faults.is_empty()
            && let Some(lines) = coordinates(&matrix)
        {
            faults.add(None, "", || {
                format!(
                    "{lines} evenly spaced and the others are not: they look like coordinates or \
                     numbers of lines; remove them, or save the matrix as NPY if they are heights"
                )
            });
        }
        let extent = |axis: usize, count: usize| {
            let StatedWidth { width, tolerance, line, has_unit } =
                text.facts.width(axis, count, lateral)?;
            let is_unit_free = stated.is_none() && !has_unit;
            Some(MapExtent { width, tolerance, line: Some(line), is_unit_free })
        };
        let first = if text.facts.is_north_first { "highest" } else { "lowest" };
        RawMap {
            extents: [extent(0, matrix.columns), extent(1, matrix.rows)],
            matrix,
            unit,
            missing: text.facts.missing.map(|fact| fact.value),
            layout: format!("a matrix of text, its first line at the {first} y"),
        }
    }

    /// Reads three columns as a list of points; `None` if they are none.
    fn of_list(
        text: &MatrixText<'_>,
        units: ListUnits,
        marks: &mut Marks,
        faults: &mut FileFaults,
    ) -> Option<Self> {
        let (mut own_marks, mut own_faults) = (Marks::default(), FileFaults::default());
        let numbers = text.points(units, &mut own_marks, &mut own_faults);
        let is_titled = text.titles.is_some();
        if !own_faults.is_empty() {
            if is_titled {
                faults.append(own_faults);
                let matrix = HeightMatrix { rows: 0, columns: 0, heights: Vec::new() };
                let empty = PointGrid { matrix, widths: [0.0; 2], centre: [0.0; 2], vacant: 0 };
                return Some(Self::of_points(empty, units.heights, false));
            }
            return None;
        }
        match PointList::of(&numbers, is_titled) {
            PointList::None => None,
            PointList::Unusable(reason) => {
                faults.add(None, "", || reason);
                None
            }
            PointList::Grid(_) if numbers.columns > 3 => {
                faults.add(None, "", || {
                    "it looks like a list of x, y and z with more columns; leave out those behind z"
                        .to_owned()
                });
                None
            }
            PointList::Grid(grid) => {
                (0..grid.vacant).for_each(|_| {
                    own_marks.count("no point");
                });
                *marks = own_marks;
                let facts = &text.facts;
                let points = grid.matrix.rows * grid.matrix.columns;
                let is_count = |count: usize| count == numbers.rows || count == points;
                // `rows` of a list may count its points.
                if !facts.counts.iter().flatten().any(|fact| is_count(fact.value)) {
                    compare_counts(facts, &grid.matrix, faults);
                }
                let missing = facts.missing.map(|fact| fact.value);
                Some(Self { missing, ..Self::of_points(grid, units.heights, units.is_free) })
            }
        }
    }

    /// Deals with missing pixels and makes the surface.
    fn finish(
        mut self,
        reading: &MapReading<'_>,
        mut marks: Marks,
        mut faults: FileFaults,
    ) -> Result<HeightMap, FileFaults> {
        if !faults.is_empty() {
            return Err(faults);
        }
        let matrix = &mut self.matrix;
        for height in matrix.heights.iter_mut().filter(|height| height.is_infinite()) {
            *height = marks.count("inf");
        }
        // Whoever says that all numbers are heights overrules the file's header.
        let of_header = self.missing.filter(|_| reading.missing != MissingRule::Keep);
        let stated = reading.missing_value.or(of_header);
        matrix.recognise_marks(stated, reading.missing, self.unit, &mut marks);
        if matches!(reading.missing, MissingRule::Refuse | MissingRule::Keep) {
            matrix.refuse_missing(&marks, &mut faults);
        }
        faults.or(())?;
        let absent = matrix.fill();
        let missing = absent.iter().filter(|absent| **absent).count();
        if missing == matrix.heights.len() {
            return Err(FileFaults::whole("every pixel is missing"));
        }
        // −0 becomes 0, so that equal heights have one name.
        matrix.heights.iter_mut().for_each(|height| *height += 0.0);
        let heights = std::mem::take(&mut matrix.heights);
        let whole = |error: contact::punch::SurfaceError| FileFaults::whole(error.to_string());
        let mut surface = Surface::new(matrix.columns, matrix.rows, heights).map_err(whole)?;
        let mut note = format!("{}; heights in {}", self.layout, self.unit.symbol());
        if missing > 0 {
            let pixels = if missing == 1 { "missing pixel" } else { "missing pixels" };
            note += &format!("; {missing} {pixels} ({})", marks.words());
            note += match reading.missing {
                MissingRule::Exclude => " excluded from the sole",
                _ => " filled from their edges inwards with the mean of their neighbours",
            };
        }
        if missing > 0 && reading.missing == MissingRule::Exclude {
            surface = surface.excluding(absent).map_err(whole)?;
        }
        Ok(HeightMap { surface, extents: self.extents, note })
    }
}

/// Returns what a long matrix of few columns or rows may be in place of a map.
fn strip(HeightMatrix { rows, columns, .. }: &HeightMatrix) -> Option<&'static str> {
    match (*rows).min(*columns) {
        _ if (*rows).max(*columns) <= LONGEST_STRIP => None,
        1 => Some("the heights of a map one after the other"),
        2 => Some("a list of x and z"),
        3 => Some("a list of x, y and z whose points lie on no grid"),
        _ => None,
    }
}

/// Returns which of the first row and the first column look like coordinates of the others, or like
/// their numbers.
fn coordinates(HeightMatrix { rows, columns, heights }: &HeightMatrix) -> Option<&'static str> {
    let (rows, columns) = (*rows, *columns);
    if rows < 4 || columns < 4 {
        return None;
    }
    // The corner may be anything.
    let is_even = |value: &dyn Fn(usize) -> f64, count: usize| {
        let step = (value(count - 1) - value(1)) / (count - 2) as f64;
        let off = |k: usize| (value(k) - value(1) - (k - 1) as f64 * step).abs();
        step != 0.0 && (1..count).all(|k| off(k) <= 1e-3 * step.abs())
    };
    let row = |j: usize| move |k: usize| heights[j * columns + k];
    let column = |i: usize| move |k: usize| heights[k * columns + i];
    let is_first = |first: bool, others: [bool; 2]| first && others == [false; 2];
    let middle = [rows / 2, columns / 2];
    let is_row = is_first(
        is_even(&row(0), columns),
        [is_even(&row(1), columns), is_even(&row(middle[0]), columns)],
    );
    let is_column = is_first(
        is_even(&column(0), rows),
        [is_even(&column(1), rows), is_even(&column(middle[1]), rows)],
    );
    match (is_row, is_column) {
        (true, true) => Some("its first row and its first column are"),
        // Few heights may be evenly spaced by chance.
        (true, false) if columns > 5 => Some("its first row is"),
        (false, true) if rows > 5 => Some("its first column is"),
        _ => None,
    }
}

/// Returns the name of a surface in jobs and stores: the BLAKE3 hash of its bytes, in hexadecimal.
pub fn name(surface: &Surface) -> String {
    blake3::hash(&encode_surface(surface)).to_hex().to_string()
}

/// Returns the bytes of a surface.
pub fn encode_surface(surface: &Surface) -> Vec<u8> {
    let sizes = (surface.columns() as u64, surface.rows() as u64);
    match surface.absent() {
        [] => encode(&(sizes.0, sizes.1, surface.heights())),
        absent => {
            let content = (sizes.0, sizes.1, surface.heights(), absent);
            encode_as(VERSION_WITH_ABSENT, &content)
        }
    }
}

/// Reads the bytes that [`encode_surface`] wrote.
///
/// # Errors
///
/// Returns an error if the bytes do not decode, or if their heights are no surface.
pub fn decode_surface(bytes: &[u8]) -> Result<Surface, DecodeError> {
    const ITEM: &str = "the surface";
    const LIMIT: usize = MAX_STORED * 9 + 64;
    const KNOWN: &[u8] = &[VERSION, VERSION_WITH_ABSENT];
    let size = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    let surface = if bytes.first() == Some(&VERSION_WITH_ABSENT) {
        type Content = (u64, u64, Vec<f64>, Vec<bool>);
        let (columns, rows, heights, absent) = decode_as::<Content, LIMIT>(KNOWN, ITEM, bytes)?;
        let surface = Surface::new(size(columns), size(rows), heights);
        surface.and_then(|surface| surface.excluding(absent))
    } else {
        type Content = (u64, u64, Vec<f64>);
        let (columns, rows, heights) = decode_as::<Content, LIMIT>(KNOWN, ITEM, bytes)?;
        Surface::new(size(columns), size(rows), heights)
    };
    surface.map_err(|error| DecodeError::Malformed { item: ITEM, reason: error.to_string() })
}
