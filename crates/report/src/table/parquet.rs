//! A table as Parquet, written block by block.

use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type as SchemaType;
use serde::{Deserialize, Serialize};
use serde_json::{Map, json};
use thiserror::Error;

use super::cell::Cell;
use super::rows::{DataTable, TableColumn};

/// A column of a Parquet file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TypedColumn {
    /// The name and the unit.
    pub head: TableColumn,
    /// The meaning in words, which may be empty.
    pub meaning: String,
    /// The type of every cell.
    pub cells: CellType,
}

/// The type of the cells of a column. Flags and numbers together are texts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CellType {
    /// True or false.
    Flag,
    /// Whole numbers of 64 bits.
    Integer,
    /// Numbers of double precision.
    Number,
    /// Texts.
    Text,
}

impl CellType {
    /// Returns the narrowest type that has room for the cells of two types.
    fn wider(self, other: Self) -> Self {
        match (self, other) {
            (Self::Flag, Self::Flag) => Self::Flag,
            (Self::Integer, Self::Integer) => Self::Integer,
            (Self::Integer | Self::Number, Self::Integer | Self::Number) => Self::Number,
            _ => Self::Text,
        }
    }
}

/// Why a table was not written as Parquet.
#[derive(Debug, Error)]
pub enum ParquetFault {
    /// A cell does not fit into its column; the file has to be written anew with a wider one.
    #[error("the column `{}` holds what is wider than its type", .0.name)]
    Wider(WiderCell),
    /// The columns of a block are not those of the file.
    #[error("the columns of a block are not those of the file")]
    Columns,
    /// The bytes cannot be written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The library refuses the table.
    #[error("Parquet: {0}")]
    Refused(String),
}

/// The column of a cell that does not fit, and the type that it takes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WiderCell {
    /// The name of the column.
    pub name: String,
    /// The type that it takes.
    pub cells: CellType,
}

impl From<ParquetError> for ParquetFault {
    fn from(error: ParquetError) -> Self {
        match error {
            ParquetError::External(source) => match source.downcast::<io::Error>() {
                Ok(error) => ParquetFault::Io(*error),
                Err(other) => ParquetFault::Refused(other.to_string()),
            },
            other => ParquetFault::Refused(other.to_string()),
        }
    }
}

/// A Parquet file that is being written.
///
/// Each block of rows becomes a row group, and nothing but its figures stays in memory. Numbers are
/// `DOUBLE`, whole numbers `INT64`, flags `BOOLEAN`, texts UTF-8; every column
/// may have nulls, and NaN is no null.
/// The metadata of the file have, as JSON, `tribosweep.columns`, a list of the columns with `name`,
/// `unit` and `meaning`, and `PANDAS_ATTRS`, from which pandas takes `attrs["units"]` and
/// `attrs["meanings"]`. Compression is Snappy's, which every reader of Parquet knows.
pub struct ParquetFile<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    columns: Vec<TypedColumn>,
}

impl<W: Write + Send> ParquetFile<W> {
    /// Begins a file with these columns.
    ///
    /// # Errors
    /// The beginning cannot be written, or two columns share a name.
    pub fn new(sink: W, columns: Vec<TypedColumn>) -> Result<Self, ParquetFault> {
        let mut fields = Vec::with_capacity(columns.len());
        for column in &columns {
            let (physical, logical) = match column.cells {
                CellType::Flag => (Physical::BOOLEAN, None),
                CellType::Integer => (Physical::INT64, None),
                CellType::Number => (Physical::DOUBLE, None),
                CellType::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            };
            let field = SchemaType::primitive_type_builder(&column.head.name, physical)
                .with_repetition(Repetition::OPTIONAL)
                .with_logical_type(logical);
            fields.push(Arc::new(field.build()?));
        }
        let schema = SchemaType::group_type_builder("rows").with_fields(fields).build()?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(format!("tribosweep {}", env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata(Some(metadata(&columns)))
            .build();
        let writer = SerializedFileWriter::new(sink, Arc::new(schema), Arc::new(properties))?;
        Ok(ParquetFile { writer, columns })
    }

    /// Adds a text to the metadata of the file, under a name.
    pub fn say(&mut self, name: &str, text: String) {
        self.writer.append_key_value_metadata(KeyValue::new(name.to_owned(), text));
    }

    /// Writes a block of rows, which has the columns of the file.
    ///
    /// # Errors
    /// [`ParquetFault::Wider`] if a cell does not fit into its column, before anything of the block
    /// is written; otherwise the bytes cannot be written.
    pub fn write(&mut self, block: &DataTable) -> Result<(), ParquetFault> {
        if !block.columns().iter().eq(self.columns.iter().map(|column| &column.head)) {
            return Err(ParquetFault::Columns);
        }
        if block.rows().is_empty() {
            return Ok(());
        }
        for (index, column) in self.columns.iter().enumerate() {
            let widest = block.widest(index).map(|cells| cells.wider(column.cells));
            if let Some(cells) = widest.filter(|cells| *cells != column.cells) {
                let name = column.head.name.clone();
                return Err(ParquetFault::Wider(WiderCell { name, cells }));
            }
        }
        let mut group = self.writer.next_row_group()?;
        for (index, column) in self.columns.iter().enumerate() {
            let Some(mut writer) = group.next_column()? else { return Err(ParquetFault::Columns) };
            let cells = block.cells(index);
            let levels: Vec<i16> =
                cells.clone().map(|cell| i16::from(*cell != Cell::Missing)).collect();
            let levels = Some(&levels[..]);
            match column.cells {
                CellType::Flag => {
                    let values: Vec<bool> = cells
                        .filter_map(|cell| match cell {
                            Cell::Flag(value) => Some(*value),
                            _ => None,
                        })
                        .collect();
                    writer.typed::<BoolType>().write_batch(&values, levels, None)?;
                }
                CellType::Integer => {
                    let values: Vec<i64> = cells
                        .filter_map(|cell| match cell {
                            Cell::Integer(value) => Some(*value),
                            _ => None,
                        })
                        .collect();
                    writer.typed::<Int64Type>().write_batch(&values, levels, None)?;
                }
                CellType::Number => {
                    let values: Vec<f64> = cells
                        .filter_map(|cell| match cell {
                            Cell::Number(value) => Some(*value),
                            Cell::Integer(value) => Some(*value as f64),
                            _ => None,
                        })
                        .collect();
                    writer.typed::<DoubleType>().write_batch(&values, levels, None)?;
                }
                CellType::Text => {
                    let values: Vec<ByteArray> = cells
                        .filter_map(|cell| Some(ByteArray::from(cell.exact()?.as_ref())))
                        .collect();
                    writer.typed::<ByteArrayType>().write_batch(&values, levels, None)?;
                }
            }
            writer.close()?;
        }
        group.close()?;
        Ok(())
    }

    /// Ends the file and returns the number of its rows.
    ///
    /// # Errors
    /// The end cannot be written.
    pub fn close(self) -> Result<u64, ParquetFault> {
        let metadata = self.writer.close()?;
        Ok(u64::try_from(metadata.file_metadata().num_rows()).unwrap_or(0))
    }
}

impl DataTable {
    /// Returns the widest type among the cells of a column; `None` if all are missing.
    pub fn widest(&self, column: usize) -> Option<CellType> {
        self.cells(column).filter_map(Cell::cell_type).reduce(CellType::wider)
    }
}

impl Cell {
    /// Returns the type of the cell; `None` if it is missing.
    pub fn cell_type(&self) -> Option<CellType> {
        match self {
            Cell::Integer(_) => Some(CellType::Integer),
            Cell::Number(_) => Some(CellType::Number),
            Cell::Flag(_) => Some(CellType::Flag),
            Cell::Text(_) => Some(CellType::Text),
            Cell::Missing => None,
        }
    }
}

/// Returns what the file says about its columns.
fn metadata(columns: &[TypedColumn]) -> Vec<KeyValue> {
    let listed: Vec<_> = columns
        .iter()
        .map(|TypedColumn { head: TableColumn { name, unit }, meaning, .. }| {
            json!({ "name": name, "unit": unit, "meaning": meaning })
        })
        .collect();
    let by_name = |value: fn(&TypedColumn) -> &str| -> Map<_, _> {
        columns.iter().map(|column| (column.head.name.clone(), value(column).into())).collect()
    };
    let attributes = json!({
        "units": by_name(|column| &column.head.unit),
        "meanings": by_name(|column| &column.meaning),
    });
    vec![
        KeyValue::new("tribosweep.columns".to_owned(), json!(listed).to_string()),
        KeyValue::new("PANDAS_ATTRS".to_owned(), attributes.to_string()),
    ]
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    use super::*;

    fn typed(name: &str, unit: &str, cells: CellType) -> TypedColumn {
        TypedColumn { head: TableColumn::new(name, unit), meaning: format!("the {name}"), cells }
    }

    fn columns() -> Vec<TypedColumn> {
        vec![
            typed("mu", "1", CellType::Number),
            typed("mesh", "", CellType::Integer),
            typed("status", "", CellType::Text),
        ]
    }

    fn block(rows: Vec<Vec<Cell>>) -> DataTable {
        DataTable::new(columns().into_iter().map(|column| column.head).collect(), rows).unwrap()
    }

    #[test]
    fn what_is_written_in_blocks_reads_back_exactly() {
        let mut bytes = Vec::new();
        let mut file = ParquetFile::new(&mut bytes, columns()).unwrap();
        file.write(&block(vec![vec![0.1.into(), 64.into(), "certified".into()]])).unwrap();
        file.write(&block(Vec::new())).unwrap();
        file.write(&block(vec![
            vec![Cell::Missing, Cell::Missing, Cell::Missing],
            vec![f64::NAN.into(), i64::MIN.into(), "µ \"".into()],
            vec![7.into(), (-1).into(), "".into()],
        ]))
        .unwrap();
        file.say("tribosweep.test", "said at the end".to_owned());
        assert_eq!(file.close().unwrap(), 4);
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        assert_eq!(reader.metadata().num_row_groups(), 2);
        let rows: Vec<Vec<Field>> = reader
            .get_row_iter(None)
            .unwrap()
            .map(|row| row.unwrap().get_column_iter().map(|(_, field)| field.clone()).collect())
            .collect();
        let text = |text: &str| Field::Str(text.to_owned());
        assert_eq!(rows[0], [Field::Double(0.1), Field::Long(64), text("certified")]);
        assert_eq!(rows[1], [Field::Null, Field::Null, Field::Null]);
        assert!(matches!(rows[2][0], Field::Double(x) if x.is_nan()));
        assert_eq!(rows[2][1..], [Field::Long(i64::MIN), text("µ \"")]);
        assert_eq!(rows[3], [Field::Double(7.0), Field::Long(-1), text("")]);
        let said = reader.metadata().file_metadata().key_value_metadata().unwrap();
        assert!(said[0].value.as_ref().unwrap().contains(r#""meaning":"the mesh""#));
        assert!(said[1].value.as_ref().unwrap().contains(r#""units":{"#));
        assert_eq!(said[2].value.as_deref(), Some("said at the end"));
    }

    #[test]
    fn a_cell_that_does_not_fit_is_named() {
        let mut bytes = Vec::new();
        let mut file = ParquetFile::new(&mut bytes, columns()).unwrap();
        let fault = file.write(&block(vec![vec![0.1.into(), "64x32".into(), "".into()]]));
        let Err(ParquetFault::Wider(wider)) = fault else { panic!("{fault:?}") };
        assert_eq!(wider, WiderCell { name: "mesh".to_owned(), cells: CellType::Text });
    }

    #[test]
    fn flags_are_booleans() {
        let columns = vec![typed("steady", "", CellType::Flag)];
        let block = |cells: Vec<Cell>| {
            let rows = cells.into_iter().map(|cell| vec![cell]).collect();
            DataTable::new(vec![columns[0].head.clone()], rows).unwrap()
        };
        let mut bytes = Vec::new();
        let mut file = ParquetFile::new(&mut bytes, columns.clone()).unwrap();
        file.write(&block(vec![true.into(), Cell::Missing, false.into()])).unwrap();
        let Err(ParquetFault::Wider(wider)) = file.write(&block(vec![1.into()])) else { panic!() };
        assert_eq!(wider.cells, CellType::Text);
        file.close().unwrap();
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        let rows: Vec<Field> = reader
            .get_row_iter(None)
            .unwrap()
            .map(|row| row.unwrap().get_column_iter().next().unwrap().1.clone())
            .collect();
        assert_eq!(rows, [Field::Bool(true), Field::Null, Field::Bool(false)]);
    }
}
