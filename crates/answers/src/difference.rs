//! The difference between the results of two studies, or of one study from two places.
//!
//! Points are matched by the values of their axes. An axis of one study may be a key of the other.

use std::collections::{BTreeMap, HashMap};

use report::{Cell, DataTable, TableColumn, TableError, quantity_words};
use study::Column;
use study::columns::{Role, find};

use crate::error::AnswerError;
use crate::results::Results;
use crate::variation::{DIMENSIONLESS, NOISE};

/// The column that tells apart points of a study that chooses meshes.
const MESH: &str = "mesh";

/// The difference between the results of two studies.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The number of points that both have.
    pub common: usize,
    /// The number of these that have no result in either.
    pub open: usize,
    /// The number of pairs of values that were compared.
    pub compared: usize,
    /// The part of the largest value of its unit at a point below which a value was taken for
    /// noise; 0 if every digit counts.
    pub noise: f64,
    /// A row for each column that was compared: at how many points it was, at how many it differs,
    /// and where by how much at most.
    pub columns: DataTable,
    /// A row for each value that differs, with the values of the axes.
    pub values: DataTable,
    /// The points that only the first study has.
    pub only_first: DataTable,
    /// The points that only the second study has.
    pub only_second: DataTable,
}

/// The columns of one study that are compared.
struct ComparedSide {
    /// The columns by which points are matched, those that are compared, and those whose values say
    /// what is large at a point.
    table: DataTable,
    /// The number of columns by which points are matched.
    axes: usize,
    /// The number of columns that are compared.
    compared: usize,
    /// The columns whose values say what is large at a point, whichever are compared.
    scaling: Vec<usize>,
    /// A row's point has a result where this is true.
    is_solved: Vec<bool>,
}

/// A column as it was compared.
struct ComparedColumn<'a> {
    head: &'a TableColumn,
    compared: i64,
    differing: i64,
    /// The largest relative difference, with the place of its point.
    largest: Option<(f64, String)>,
}

impl Difference {
    /// Compares `columns` of two studies; where none is named, the quantities of the solutions, and
    /// how jobs ended. Numbers differ if they do by more than a part `tolerance` of the larger one.
    /// Those below 1e-9 of the largest quantity of their unit at their point are none, unless
    /// the tolerance is 0 or they have no unit.
    ///
    /// # Errors
    /// A column is not in both studies, or the fields of a record that is compared cannot be read.
    pub fn of(
        first: &Results<'_>,
        second: &Results<'_>,
        columns: &[String],
        tolerance: f64,
    ) -> Result<Self, AnswerError> {
        let (listed, others) = (first.study().columns(), second.study().columns());
        let mut axes: Vec<String> = Vec::new();
        for column in listed.iter().chain(&others) {
            if column.role == Role::Axis && !axes.contains(&column.name.to_string()) {
                axes.push(column.name.to_string());
            }
        }
        let chooses_meshes = |results: &Results<'_>| {
            let values: Vec<_> = results.points().iter().map(|point| &point.values).collect();
            values.windows(2).any(|pair| pair[0] == pair[1])
        };
        let is_known = |name: &str| [&listed, &others].iter().all(|all| find(all, name).is_some());
        if !axes.iter().any(|name| name == MESH)
            && is_known(MESH)
            && (chooses_meshes(first) || chooses_meshes(second))
        {
            axes.push(MESH.to_owned());
        }
        let usual = usual(&listed, &others);
        let names = if columns.is_empty() { &usual[..] } else { columns };
        let first = ComparedSide::of(first, &axes, names, &usual)?;
        let second = ComparedSide::of(second, &axes, names, &usual)?;
        compare(&first, &second, tolerance)
    }

    /// Returns whether nothing differs because nothing could be compared.
    pub fn is_void(&self) -> bool {
        self.is_none() && self.compared == 0
    }

    /// Returns whether both studies have the same points with the same results.
    pub fn is_none(&self) -> bool {
        self.is_none_at_common_points()
            && self.only_first.rows().is_empty()
            && self.only_second.rows().is_empty()
    }

    /// Returns whether the points that both studies have, have the same results.
    pub fn is_none_at_common_points(&self) -> bool {
        self.values.rows().is_empty()
    }
}

/// Returns the names of the columns that are compared where none is named.
fn usual(listed: &[Column], others: &[Column]) -> Vec<String> {
    let is_usual = |column: &&Column| match column.role {
        Role::Observable => true,
        Role::Status => !["key", "reason"].contains(&column.name.as_ref()),
        _ => false,
    };
    let is_common = |column: &&Column| others.iter().any(|other| other.name == column.name);
    let usual = listed.iter().filter(is_usual).filter(is_common);
    usual.map(|column| column.name.to_string()).collect()
}

impl ComparedSide {
    fn of(
        results: &Results<'_>,
        axes: &[String],
        names: &[String],
        usual: &[String],
    ) -> Result<Self, AnswerError> {
        let columns = results.study().columns();
        if let Some(missing) = axes.iter().find(|name| find(&columns, name).is_none()) {
            return Err(AnswerError::NotMatched {
                column: missing.clone(),
                study: results.study().name().to_owned(),
            });
        }
        let mut all = axes.to_vec();
        all.extend(names.iter().filter(|name| !axes.contains(name)).cloned());
        let compared = all.len() - axes.len();
        let more: Vec<String> = usual.iter().filter(|name| !all.contains(name)).cloned().collect();
        all.extend(more);
        let is_scaling = |(index, name): (usize, &String)| usual.contains(name).then_some(index);
        let scaling = all.iter().enumerate().filter_map(is_scaling).collect();
        let is_solved = results.points().iter().map(|point| results.record(point).is_some());
        Ok(ComparedSide {
            table: results.table(&all)?.select(&all)?,
            axes: axes.len(),
            compared,
            scaling,
            is_solved: is_solved.collect(),
        })
    }

    /// Returns the rows of the points, by what they are matched by. Points that are not told apart
    /// follow each other.
    fn places(&self) -> BTreeMap<Vec<String>, Vec<usize>> {
        let mut places: BTreeMap<Vec<String>, Vec<usize>> = BTreeMap::new();
        for row in 0..self.table.rows().len() {
            places.entry(self.place(row)).or_default().push(row);
        }
        places
    }

    /// Returns what a point is matched by. Numbers are rounded, because those of a range may differ
    /// in their last digits from the same ones in a list.
    fn place(&self, row: usize) -> Vec<String> {
        let text = |cell: &Cell| match cell.number() {
            Some(x) => format!("{:.11e}", x + 0.0),
            None => cell.exact().unwrap_or_default().into_owned(),
        };
        self.table.rows()[row][..self.axes].iter().map(text).collect()
    }

    /// Names the place of a point, to be read.
    fn words(&self, row: usize) -> String {
        let named = self.table.columns()[..self.axes].iter().zip(&self.table.rows()[row]);
        let words = named.map(|(head, cell)| match cell.number() {
            Some(x) => format!("{} = {}", head.name, quantity_words(x, &head.unit)),
            None => format!("{} = {}", head.name, cell.exact().unwrap_or_default()),
        });
        words.collect::<Vec<_>>().join(", ")
    }

    /// Returns a table of the places of some points.
    fn listed(&self, rows: impl Iterator<Item = usize>) -> Result<DataTable, TableError> {
        let mut rows: Vec<usize> = rows.collect();
        rows.sort_unstable();
        let heads = self.table.columns()[..self.axes].to_vec();
        let cells = rows.into_iter().map(|row| self.table.rows()[row][..self.axes].to_vec());
        DataTable::new(heads, cells.collect())
    }

    /// Returns the largest quantity of each unit at a point, whose rows on both sides are given.
    fn scales(&self, rows: [&[Cell]; 2]) -> HashMap<&str, f64> {
        let mut scales: HashMap<&str, f64> = HashMap::new();
        for index in &self.scaling {
            let unit = self.table.columns()[*index].unit.as_str();
            if DIMENSIONLESS.contains(&unit) {
                continue;
            }
            let sizes = rows.iter().filter_map(|row| row[*index].number()).map(f64::abs);
            let largest = sizes.filter(|size| size.is_finite()).fold(0.0, f64::max);
            let scale = scales.entry(unit).or_default();
            *scale = scale.max(largest);
        }
        scales
    }
}

fn compare(
    first: &ComparedSide,
    second: &ComparedSide,
    tolerance: f64,
) -> Result<Difference, AnswerError> {
    let (places, others) = (first.places(), second.places());
    let none = Vec::new();
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    let (mut only_first, mut only_second) = (Vec::new(), Vec::new());
    for (place, rows) in &places {
        let there = others.get(place).unwrap_or(&none);
        pairs.extend(rows.iter().zip(there).map(|(one, other)| [*one, *other]));
        only_first.extend(rows.iter().skip(there.len()).copied());
    }
    for (place, rows) in &others {
        let here = places.get(place).unwrap_or(&none);
        only_second.extend(rows.iter().skip(here.len()).copied());
    }
    pairs.sort_unstable();
    let axes = first.axes;
    let all = axes + first.compared;
    let heads = &first.table.columns()[axes..all];
    let noise = if tolerance > 0.0 { NOISE } else { 0.0 };
    let mut open = 0;
    let mut compared: Vec<ComparedColumn<'_>> = heads
        .iter()
        .map(|head| ComparedColumn { head, compared: 0, differing: 0, largest: None })
        .collect();
    let mut values = Vec::new();
    for [one, other] in &pairs {
        if !first.is_solved[*one] && !second.is_solved[*other] {
            open += 1;
            continue;
        }
        let rows = [&first.table.rows()[*one][..], &second.table.rows()[*other][..]];
        let scales = first.scales(rows);
        for (index, column) in compared.iter_mut().enumerate() {
            let [here, there] = rows.map(|row| &row[axes + index]);
            if here.is_missing() && there.is_missing() {
                continue;
            }
            let noise = noise * scales.get(column.head.unit.as_str()).copied().unwrap_or(0.0);
            column.compared += 1;
            let Some(difference) = difference(here, there, noise, tolerance) else { continue };
            column.differing += 1;
            let size = difference.number().unwrap_or(f64::INFINITY);
            if column.largest.as_ref().is_none_or(|(largest, _)| size > *largest) {
                column.largest = Some((size, first.words(*one)));
            }
            let mut row = first.table.rows()[*one][..axes].to_vec();
            let head = column.head;
            row.extend([Cell::from(head.name.as_str()), Cell::from(head.unit.as_str())]);
            row.extend([here.clone(), there.clone(), difference]);
            values.push(row);
        }
    }
    let mut value_heads = first.table.columns()[..axes].to_vec();
    let names = ["column", "unit", "first", "second", "difference"];
    value_heads.extend(names.map(|name| TableColumn::new(name, "")));
    let compared_values = compared.iter().map(|column| column.compared as usize).sum();
    let rows = compared.into_iter().map(|column| {
        let (size, place) =
            column.largest.map_or((Cell::Missing, Cell::Missing), |(size, place)| {
                let size = if size.is_finite() { Cell::Number(size) } else { Cell::Missing };
                (size, Cell::Text(place))
            });
        let name = Cell::from(column.head.name.as_str());
        vec![name, Cell::Integer(column.compared), Cell::Integer(column.differing), size, place]
    });
    let names = ["column", "points", "differing", "largest", "at"];
    let column_heads = names.map(|name| TableColumn::new(name, "")).to_vec();
    Ok(Difference {
        common: pairs.len(),
        open,
        compared: compared_values,
        noise,
        columns: DataTable::new(column_heads, rows.collect())?,
        values: DataTable::new(value_heads, values)?,
        only_first: first.listed(only_first.into_iter())?,
        only_second: second.listed(only_second.into_iter())?,
    })
}

/// Returns the relative difference of two cells, [`Cell::Missing`] where it has no number; `None`
/// if they do not differ.
fn difference(first: &Cell, second: &Cell, noise: f64, tolerance: f64) -> Option<Cell> {
    match (first.number(), second.number()) {
        (Some(a), Some(b)) => {
            let larger = a.abs().max(b.abs());
            if a == b || larger <= noise {
                return None;
            }
            let relative = (a - b).abs() / larger;
            match relative.is_finite() {
                true => (relative > tolerance).then_some(Cell::Number(relative)),
                false => Some(Cell::Missing),
            }
        }
        _ if first.is_missing() && second.is_missing() => None,
        _ => (first != second).then_some(Cell::Missing),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(rows: &[[Cell; 4]]) -> ComparedSide {
        let heads = [("mu", "1"), ("load", "N"), ("force_y", "N"), ("status", "")];
        let heads = heads.map(|(name, unit)| TableColumn::new(name, unit)).to_vec();
        let rows: Vec<_> = rows.iter().map(|row| row.to_vec()).collect();
        let is_solved = vec![true; rows.len()];
        let table = DataTable::new(heads, rows).unwrap();
        ComparedSide { table, axes: 1, compared: 3, scaling: vec![1, 2, 3], is_solved }
    }

    fn row(mu: f64, load: f64, force: f64, status: &str) -> [Cell; 4] {
        [mu.into(), load.into(), force.into(), status.into()]
    }

    fn differing(found: &Difference) -> Vec<(String, Option<f64>)> {
        let rows = found.values.rows().iter();
        rows.map(|row| (row[1].exact().unwrap().into_owned(), row[5].number())).collect()
    }

    #[test]
    fn numbers_are_held_against_the_tolerance_and_noise_is_none() {
        let first = side(&[row(0.1, 4.0, 1e-12, "certified"), row(0.2, 5.0, 0.5, "certified")]);
        // 0.1 + 0.2 is another number than 0.3, and the same place.
        let second = side(&[row(0.2, 5.0, 0.5, "failed"), row(0.1, 4.004, -3e-12, "certified")]);
        let found = compare(&first, &second, 1e-6).unwrap();
        assert_eq!(found.common, 2);
        let [(load, size), (status, none)] = &differing(&found)[..] else { panic!("{found:?}") };
        assert_eq!((load.as_str(), status.as_str(), none), ("load", "status", &None));
        assert!((size.unwrap() - 0.004 / 4.004).abs() < 1e-12);
        assert!(!found.is_none() && !found.is_none_at_common_points());
        assert_eq!(found.columns.rows()[0][4], Cell::Text("mu = 0.1".to_owned()));
        let coarse = compare(&first, &second, 0.01).unwrap();
        assert_eq!(differing(&coarse), [("status".to_owned(), None)]);
        assert!(compare(&first, &first, 0.0).unwrap().is_none());
    }

    #[test]
    fn every_digit_counts_at_a_tolerance_of_nothing() {
        let first = side(&[row(0.1, 4.0, 1e-12, "certified")]);
        let second = side(&[row(0.1, 4.0, 2e-12, "certified")]);
        assert_eq!(differing(&compare(&first, &second, 0.0).unwrap()).len(), 1);
        let found = compare(&first, &second, 1e-15).unwrap();
        assert!(found.is_none() && found.noise == NOISE);
    }

    #[test]
    fn noise_is_the_same_whichever_columns_are_compared() {
        let alone = |force: f64| {
            let columns = side(&[row(0.1, 4.0, force, "certified")]).table;
            let table = columns.select(&["mu", "force_y", "load"]).unwrap();
            ComparedSide { table, axes: 1, compared: 1, scaling: vec![1, 2], is_solved: vec![true] }
        };
        let found = compare(&alone(1e-12), &alone(2e-12), 1e-6).unwrap();
        assert!(found.is_none() && found.compared == 1, "{found:?}");
    }

    #[test]
    fn numbers_without_a_unit_are_no_noise_of_others() {
        let heads = ["mu", "elements", "fraction"].map(|name| TableColumn::new(name, ""));
        let side = |fraction: f64| ComparedSide {
            table: DataTable::new(
                heads.to_vec(),
                vec![vec![0.1.into(), 4e6.into(), fraction.into()]],
            )
            .unwrap(),
            axes: 1,
            compared: 2,
            scaling: vec![1, 2],
            is_solved: vec![true],
        };
        let found = compare(&side(1e-4), &side(2e-4), 1e-6).unwrap();
        assert_eq!(differing(&found).len(), 1);
    }

    #[test]
    fn points_without_a_result_are_not_compared() {
        let open = || {
            let gone = [0.1.into(), Cell::Missing, Cell::Missing, Cell::Missing];
            ComparedSide { is_solved: vec![false], ..side(&[gone]) }
        };
        let found = compare(&open(), &open(), 1e-6).unwrap();
        assert_eq!((found.common, found.open, found.compared), (1, 1, 0));
        assert!(found.is_void());
        let solved = side(&[row(0.1, 4.0, 1.0, "certified")]);
        let found = compare(&solved, &open(), 1e-6).unwrap();
        assert_eq!((found.open, found.compared, found.values.rows().len()), (0, 3, 3));
        assert!(!found.is_void() && !compare(&solved, &solved, 0.0).unwrap().is_void());
    }

    #[test]
    fn points_are_matched_by_their_places() {
        let range = side(&[row(0.1 + 0.2, 1.0, 0.0, "a"), row(0.4, 1.0, 0.0, "a")]);
        let list =
            side(&[row(0.3, 1.0, 0.0, "a"), row(0.5, 1.0, 0.0, "a"), row(0.3, 2.0, 0.0, "a")]);
        let found = compare(&range, &list, 0.0).unwrap();
        assert_eq!((found.common, found.values.rows().len()), (1, 0));
        assert_eq!(found.only_first.rows(), [vec![Cell::Number(0.4)]]);
        assert_eq!(found.only_second.rows(), [vec![Cell::Number(0.5)], vec![Cell::Number(0.3)]]);
        assert!(found.is_none_at_common_points() && !found.is_none());
    }

    #[test]
    fn what_is_missing_on_one_side_differs() {
        let gone = [0.1.into(), Cell::Missing, Cell::Missing, Cell::Missing];
        let first = side(&[row(0.1, 4.0, f64::INFINITY, "certified")]);
        let found = compare(&first, &side(std::slice::from_ref(&gone)), 1.0).unwrap();
        assert_eq!(found.values.rows().len(), 3);
        assert!(
            compare(&side(std::slice::from_ref(&gone)), &side(&[gone]), 0.0).unwrap().is_none()
        );
        let other = side(&[row(0.1, 4.0, 1.0, "certified")]);
        assert_eq!(differing(&compare(&first, &other, 0.1).unwrap()).len(), 1);
    }
}
