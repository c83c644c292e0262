//! The stresses on all planes and at all points that a scene asks for, as tables.

use contact::model::{Interior, PlanePeaks, PointStress};
use report::{Cell, DataTable, TableColumn};

use crate::comparison::AnswerTable;
use crate::error::AnswerError;

/// Returns a table with a row for each plane, and one with a row for each point, if there are any.
pub(crate) fn tables(found: &Interior) -> Result<Vec<AnswerTable>, AnswerError> {
    let mut tables = Vec::new();
    if !found.planes.is_empty() {
        tables.push(table("planes", &PLANE, found.planes.iter().map(plane))?);
    }
    if !found.points.is_empty() {
        tables.push(table("points", &POINT, found.points.iter().map(point))?);
    }
    Ok(tables)
}

fn table(
    title: &'static str,
    heads: &[(&str, &str)],
    rows: impl Iterator<Item = Vec<f64>>,
) -> Result<AnswerTable, AnswerError> {
    let heads = heads.iter().map(|(name, unit)| TableColumn::new(*name, *unit)).collect();
    let rows = rows.map(|row| row.into_iter().map(Cell::Number).collect()).collect();
    Ok(AnswerTable { title: title.into(), table: DataTable::new(heads, rows)? })
}

const PLANE: [(&str, &str); 7] = [
    ("depth", "m"),
    ("von_mises", "Pa"),
    ("von_mises_x", "m"),
    ("von_mises_y", "m"),
    ("tresca", "Pa"),
    ("tresca_x", "m"),
    ("tresca_y", "m"),
];

fn plane(PlanePeaks { depth, von_mises, tresca }: &PlanePeaks) -> Vec<f64> {
    let mut row = vec![*depth];
    for peak in [von_mises, tresca] {
        row.extend([peak.stress, peak.place[0], peak.place[1]]);
    }
    row
}

const POINT: [(&str, &str); 14] = [
    ("x", "m"),
    ("y", "m"),
    ("z", "m"),
    ("xx", "Pa"),
    ("yy", "Pa"),
    ("zz", "Pa"),
    ("xy", "Pa"),
    ("yz", "Pa"),
    ("xz", "Pa"),
    ("first", "Pa"),
    ("second", "Pa"),
    ("third", "Pa"),
    ("von_mises", "Pa"),
    ("tresca", "Pa"),
];

fn point(PointStress { place, stress }: &PointStress) -> Vec<f64> {
    let mut row = place.to_vec();
    row.extend(stress.components());
    row.extend(stress.principal());
    row.extend([stress.von_mises(), stress.tresca()]);
    row
}
