//! Fields as files for other programs: NPY, VTK and CSV.

use std::fmt::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use thiserror::Error;

use super::quantity::{Field, FieldGrid, Values};
use crate::delimited::write;
use crate::number::exact;
use crate::text::escape;

/// A reason why fields cannot be written to one file.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum VtiError {
    /// There is no field.
    #[error("there is no field to write")]
    Empty,
    /// Two fields lie on different grids.
    #[error("fields `{first}` and `{other}` lie on different grids and cannot share a file")]
    Grids {
        /// The first field.
        first: String,
        /// The field that differs.
        other: String,
    },
    /// Two fields have the same name.
    #[error("field `{0}` occurs twice; every field needs a name of its own")]
    Duplicate(String),
}

/// Returns the grid that all fields share.
///
/// # Errors
/// [`VtiError`], if there is none or if two fields share a name.
fn shared_grid<'a>(fields: &[&'a Field]) -> Result<&'a FieldGrid, VtiError> {
    let Some(first) = fields.first() else { return Err(VtiError::Empty) };
    for (i, field) in fields.iter().enumerate() {
        if field.grid != first.grid || field.cut != first.cut {
            return Err(VtiError::Grids { first: first.name.clone(), other: field.name.clone() });
        }
        if fields[..i].iter().any(|earlier| earlier.name == field.name) {
            return Err(VtiError::Duplicate(field.name.clone()));
        }
    }
    Ok(&first.grid)
}

impl Field {
    /// Writes the values as NPY (NumPy), version 1: shape (ny, nx), C order, little-endian `f8`, or
    /// `u1` for states.
    ///
    /// `numpy.load(f)[j, i]` is element (i, j).
    ///
    /// Source: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.
    pub fn npy(&self) -> Vec<u8> {
        let (kind, values): (&str, Vec<u8>) = match &self.values {
            Values::Number(values) => {
                ("<f8", values.iter().flat_map(|x| x.to_le_bytes()).collect())
            }
            Values::Category { states, .. } => ("|u1", states.clone()),
        };
        let (rows, columns) = (self.grid.ny, self.grid.nx);
        let mut header = format!(
            "{{'descr': '{kind}', 'fortran_order': False, 'shape': ({rows}, {columns}, ), }}"
        );
        // The values begin at a multiple of 64 bytes; the header's ten first bytes are no text.
        let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
        header += &" ".repeat(length - 1 - header.len());
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((length as u16).to_le_bytes());
        bytes.extend(header.bytes());
        bytes.push(b'\n');
        bytes.extend(values);
        bytes
    }
}

/// Writes fields on one grid as a VTK image (`.vti`), for ParaView and PyVista.
///
/// Every field is cell data on a flat image in its plane; the data are binary, little-endian
/// and not compressed. States are bytes. Units stand in VTK's own `UNITS_LABEL`.
///
/// # Errors
/// [`VtiError`], if there is no field, if two fields lie on different grids, or if they share a
/// name.
///
/// Source: VTK file formats, <https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html>.
pub fn vti(fields: &[&Field]) -> Result<String, VtiError> {
    let grid = shared_grid(fields)?;
    let cut = fields[0].cut;
    let place = match cut.place() {
        0.0 => "0".to_owned(),
        place => exact(place),
    };
    let extent = cut.spread([grid.nx, grid.ny], 0).map(|n| format!("0 {n}")).join(" ");
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n",
    );
    // Writing to a string does not fail.
    let _ = writeln!(
        out,
        "<ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\">",
        cut.spread(grid.origin.map(exact), place).join(" "),
        cut.spread(grid.element.map(exact), "1".to_owned()).join(" ")
    );
    let _ = writeln!(
        out,
        "<Piece Extent=\"{extent}\">\n<CellData Scalars=\"{}\">",
        escape(&fields[0].name)
    );
    for field in fields {
        let (kind, values): (&str, Vec<u8>) = match &field.values {
            Values::Number(values) => {
                ("Float64", values.iter().flat_map(|x| x.to_le_bytes()).collect())
            }
            Values::Category { states, .. } => ("UInt8", states.clone()),
        };
        // The length in bytes and the values are encoded as one block.
        let mut block = (values.len() as u64).to_le_bytes().to_vec();
        block.extend_from_slice(&values);
        let _ = writeln!(
            out,
            "<DataArray type=\"{kind}\" Name=\"{}\" format=\"binary\">\n{}",
            escape(&field.name),
            BASE64_STANDARD.encode(block)
        );
        if !field.unit.is_empty() {
            let unit = escape(&field.unit);
            let _ = writeln!(
                out,
                "<InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">{unit}</InformationKey>"
            );
        }
        out += "</DataArray>\n";
    }
    out += "</CellData>\n</Piece>\n</ImageData>\n</VTKFile>\n";
    Ok(out)
}

/// A file of a series and the place that it has there.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesFile {
    /// The place, in which VTK sees a time.
    pub time: f64,
    /// The path of the file, relative to that of the series.
    pub path: String,
}

/// Writes the index of a series of VTK files (`.pvd`), which ParaView and PyVista open as one.
///
/// Source: <https://docs.paraview.org/en/latest/UsersGuide/dataIngestion.html>.
pub fn pvd(files: &[SeriesFile]) -> String {
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<Collection>\n",
    );
    for SeriesFile { time, path } in files {
        // Writing to a string does not fail.
        let _ = writeln!(
            out,
            "<DataSet timestep=\"{}\" group=\"\" part=\"0\" file=\"{}\"/>",
            exact(*time),
            escape(path)
        );
    }
    out += "</Collection>\n</VTKFile>\n";
    out
}

/// Writes fields on one grid as CSV: the columns `x,y`, or those of the section, of the centre of
/// each element in metres, then a column for each field.
///
/// Numbers are written as in [`DataTable::csv`](crate::DataTable::csv). A missing value is an empty
/// field, and states are written by name.
///
/// # Errors
/// [`VtiError`], if there is no field, if two fields lie on different grids, or if they share a
/// name.
pub fn field_csv(fields: &[&Field]) -> Result<String, VtiError> {
    let grid = shared_grid(fields)?;
    let cut = fields[0].cut;
    let header = cut
        .names()
        .into_iter()
        .chain(fields.iter().map(|f| f.name.as_str()))
        .map(str::to_owned)
        .collect();
    let rows = (0..grid.elements()).map(|e| {
        let mut row: Vec<String> =
            grid.centre(e % grid.nx, e / grid.nx).into_iter().map(exact).collect();
        row.extend(fields.iter().map(|field| match &field.values {
            Values::Number(values) if values[e].is_nan() => String::new(),
            Values::Number(values) => exact(values[e]),
            Values::Category { states, names } => {
                names.get(usize::from(states[e])).cloned().unwrap_or_default()
            }
        }));
        row
    });
    Ok(write(std::iter::once(header).chain(rows)))
}
