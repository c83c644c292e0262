//! Results that are read in blocks say what results in memory say.

use std::cell::RefCell;

use answers::{
    Accounts, AnswerError, RecordsError, Results, RowKeeper, RowSource, Selection, SurveyNotes,
    TabledColumn, TabledRows, survey, tabled_columns,
};
use identity::JobKey;
use report::{Cell, CellType};
use study::{Column, Figure, Study};

use crate::shelf::Shelf;
use crate::{SPHERES, parse};

/// Returns a study of 18 points.
fn study() -> Study {
    parse(&format!(
        "name = \"test\"\n{SPHERES}loading.steps = [{{ approach = \"1 um\" }}]\n\
         [numerics]\nmesh = 8\n[sweep]\nfriction.mu = [0.1, 0.2, 0.4]\n\
         \"loading.steps[0].approach\" = [\"1 um\", \"5 um\", \"20 um\"]\nmesh = [2, 6]\n"
    ))
}

/// Returns the records of a study, of which one failed, one was set aside, and one is older.
fn mixed_shelf(study: &Study) -> Shelf {
    let mut shelf = Shelf::default();
    let points = shelf.run(study).points;
    shelf.fail(&points[4].key);
    shelf.set_aside(&points[7].key);
    shelf.make_older(&points[9].key);
    shelf
}

#[test]
fn results_in_blocks_are_those_in_memory() {
    let study = study();
    let shelf = mixed_shelf(&study);
    let whole = Results::read(study.clone(), &shelf).unwrap();
    let blocks = Results::in_blocks_above(1, study.clone(), &shelf).unwrap();
    assert!(blocks.points().is_empty(), "its points are not in memory");
    assert_alike(&blocks, &whole);
}

/// The results that a table has are those of the records, also where it is damaged.
#[test]
fn results_of_a_table_are_those_in_memory() {
    let study = study();
    let shelf = mixed_shelf(&study);
    let whole = Results::read(study.clone(), &shelf).unwrap();
    let keeper = MemoryKeeper::default();
    let notes = survey(&study, &shelf, Some(&keeper)).unwrap();
    let mut table = keeper.0.take();
    assert_eq!(table.notes.as_ref(), Some(&notes));
    let other = MemoryKeeper::default();
    whole.keep_rows(&other);
    assert_eq!(other.0.take().notes.as_ref(), Some(&notes));
    let no_records = Shelf::default();
    let of_table = Results::of_table(study.clone(), notes.clone(), &table, &no_records);
    assert_eq!(of_table.usual_table(usize::MAX).unwrap(), whole.usual_table(usize::MAX).unwrap());
    assert_alike(&Results::of_table(study.clone(), notes.clone(), &table, &shelf), &whole);
    assert!(!table.read.take().is_empty());
    table.is_damaged = true;
    assert_alike(&Results::of_table(study, notes, &table, &shelf), &whole);
}

/// Asserts that results that are not in memory say what those do that are.
fn assert_alike(blocks: &Results<'_>, whole: &Results<'_>) {
    assert_eq!(blocks.progress(), whole.progress());
    assert_eq!(blocks.warnings(), whole.warnings());
    assert!(!whole.warnings().is_empty());
    assert_eq!(blocks.failures().unwrap(), whole.failures().unwrap());
    assert_eq!(whole.failures().unwrap().count, 2);
    assert_eq!(blocks.inaccurate(), whole.inaccurate());
    assert_eq!(blocks.answers().unwrap(), whole.answers().unwrap());
    assert_eq!(blocks.figures().unwrap(), whole.figures().unwrap());
    assert_eq!(blocks.usual_columns(false).unwrap(), whole.usual_columns(false).unwrap());
    assert_eq!(blocks.usual_columns(true).unwrap(), whole.usual_columns(true).unwrap());
    assert_eq!(blocks.usual_table(usize::MAX).unwrap(), whole.usual_table(usize::MAX).unwrap());
    assert_eq!(blocks.increments().unwrap(), whole.increments().unwrap());
    let drawn = Figure::new("mu".to_owned(), vec!["load".to_owned(), "dissipation".to_owned()]);
    for figure in whole.figures().unwrap().iter().chain([&drawn]) {
        for filter in [None, Some("mesh == 6 && hertz_peak_pressure > 0"), Some("load > 1")] {
            let names: Vec<&String> = figure.shown().chain([&figure.x]).collect();
            let rows = |results: &Results<'_>| {
                let rows = results.figure_rows(figure, filter).unwrap();
                (rows.table.select(&names).unwrap(), rows.undrawn)
            };
            assert_eq!(rows(blocks), rows(whole), "{filter:?}");
        }
        assert!(blocks.figure_rows(figure, Some("mush > 1")).is_err());
    }
}

#[test]
fn rows_are_gathered_as_they_are_chosen_in_memory() {
    let study = study();
    let mut shelf = Shelf::default();
    shelf.run(&study);
    let results = Results::read(study.clone(), &shelf).unwrap();
    let source = RowSource::Records { records: &shelf, keeper: None };
    for (filter, sort) in [
        (None, vec![]),
        (Some("mesh == 6"), vec!["-load", "mu"]),
        (Some("load > 1e300"), vec!["approach"]),
    ] {
        let selection = Selection {
            filter: filter.map(str::to_owned),
            sort: sort.iter().map(|name: &&str| (*name).to_owned()).collect(),
            columns: ["stick_fraction", "mu"].map(str::to_owned).to_vec(),
            steps: false,
        };
        let (gathered, _) = selection.gathered(&study, source, 18).unwrap().unwrap();
        assert_eq!(gathered, selection.of(&results).unwrap(), "{filter:?}");
    }
    let all = Selection { columns: vec!["mu".to_owned()], ..Selection::default() };
    assert!(all.gathered(&study, source, 17).unwrap().is_none(), "there are 18 rows");
}

/// Rows that pass by in blocks are those in memory, whatever they are made of, and so are those that
/// are asked for by their numbers.
#[test]
fn rows_of_a_study_are_the_same_wherever_they_come_from() {
    let study = study();
    let shelf = mixed_shelf(&study);
    let keeper = MemoryKeeper::default();
    let notes = survey(&study, &shelf, Some(&keeper)).unwrap();
    let table = keeper.0.take();
    let whole = Results::read(study.clone(), &shelf).unwrap();
    let blocks = Results::in_blocks_above(1, study.clone(), &shelf).unwrap();
    let of_table = Results::of_table(study, notes, &table, &shelf);
    let names = ["mu", "key", "load", "status", "reason"];
    for filter in [None, Some("mesh == 6 && mu < 0.3"), Some("load > 1"), Some("mu > 7")] {
        let expected = whole.rows(filter).unwrap();
        let all = expected.at(&names, &(0..18).collect::<Vec<_>>()).unwrap();
        assert_eq!(all.rows().len(), expected.count());
        for (results, points) in [(&whole, 18), (&blocks, 1), (&blocks, 5), (&of_table, 5)] {
            let rows = results.rows(filter).unwrap().in_blocks_of(points);
            assert_eq!(rows.count(), expected.count(), "{filter:?}");
            let mut visited = Vec::new();
            rows.visit(&names, &mut |first, block| {
                assert_eq!(first, visited.len());
                visited.extend_from_slice(block.rows());
                Ok::<bool, AnswerError>(true)
            })
            .unwrap();
            assert_eq!(visited, all.rows(), "{filter:?}, {points} points at once");
            let some: Vec<usize> = (0..expected.count()).step_by(3).collect();
            assert_eq!(rows.at(&names, &some).unwrap(), expected.at(&names, &some).unwrap());
            let mut blocks = 0;
            rows.visit(&["mu"], &mut |_, _| {
                blocks += 1;
                Ok::<bool, AnswerError>(false)
            })
            .unwrap();
            assert!(blocks <= 1, "the visitor has seen enough");
            assert!(rows.at(&["mush"], &[0]).is_err());
        }
    }
    for wrong in ["mush > 1", "mu > \"x\"", "mu >"] {
        for results in [&whole, &blocks, &of_table] {
            assert!(results.rows(Some(wrong)).is_err(), "{wrong}");
        }
    }
    for results in [&whole, &blocks, &of_table] {
        let mut keys = Vec::new();
        results
            .visit_points(&mut |points| {
                keys.extend(points.iter().map(|point| point.key));
                Ok::<(), AnswerError>(())
            })
            .unwrap();
        assert_eq!(keys, table.keys);
        assert_eq!(results.records_of(&keys).unwrap().len(), 17, "one is older");
        assert_eq!(results.have_fields(&keys).unwrap(), whole.have_fields(&keys).unwrap());
        assert!(!results.have_paths() && !results.all_have_fields());
    }
}

/// A table in memory.
#[derive(Default)]
struct MemoryTable {
    columns: Vec<TabledColumn>,
    keys: Vec<JobKey>,
    rows: Vec<Vec<Cell>>,
    is_whole: bool,
    notes: Option<SurveyNotes>,
    /// The rows cannot be read.
    is_damaged: bool,
    /// The numbers of the rows that were read.
    read: RefCell<Vec<usize>>,
}

#[derive(Default)]
struct MemoryKeeper(RefCell<MemoryTable>);

impl RowKeeper for MemoryKeeper {
    fn begin(&self, columns: &[Column]) {
        let column = |column: &Column| TabledColumn { name: column.name.to_string(), cells: None };
        let columns = columns.iter().map(column).collect();
        self.0.replace(MemoryTable { columns, ..MemoryTable::default() });
    }

    fn is_keeping(&self) -> bool {
        true
    }

    fn keep(&self, keys: &[JobKey], rows: &[Vec<Cell>]) {
        let mut table = self.0.borrow_mut();
        table.keys.extend(keys);
        table.rows.extend(rows.iter().cloned());
    }

    fn end(&self, _: &Accounts, notes: Option<&SurveyNotes>) {
        let mut table = self.0.borrow_mut();
        table.is_whole = true;
        table.notes = notes.cloned();
        for index in 0..table.columns.len() {
            let mut types: Vec<CellType> =
                table.rows.iter().filter_map(|row| row[index].cell_type()).collect();
            types.dedup();
            table.columns[index].cells = types.first().copied().filter(|_| types.len() == 1);
        }
    }
}

impl TabledRows for MemoryTable {
    fn row_count(&self) -> usize {
        self.rows.len()
    }

    fn columns(&self) -> &[TabledColumn] {
        &self.columns
    }

    fn rows(&self, columns: &[usize], rows: &[usize]) -> Result<Vec<Vec<Cell>>, RecordsError> {
        if self.is_damaged {
            return Err("the table is damaged".into());
        }
        self.read.borrow_mut().extend(rows);
        let row = |row: &usize| columns.iter().map(|c| self.rows[*row][*c].clone()).collect();
        Ok(rows.iter().map(row).collect())
    }

    fn rows_of(&self, key: &JobKey) -> Result<Vec<usize>, RecordsError> {
        Ok((0..self.keys.len()).filter(|row| self.keys[*row] == *key).collect())
    }

    fn accounts(&self) -> Accounts {
        Accounts::default()
    }
}

/// Returns what is chosen of rows that come one block after the other, or why nothing is.
fn visited(selection: &Selection, study: &Study, source: RowSource<'_>) -> Result<String, String> {
    let mut text = String::new();
    let visited = selection.visit(study, source, |block| {
        text += &block.csv();
        Ok::<(), AnswerError>(())
    });
    visited.map(|_| text).map_err(|error| error.to_string())
}

#[test]
fn rows_of_a_table_are_chosen_as_those_of_the_records_are() {
    let study = study();
    let shelf = mixed_shelf(&study);
    let points = study.points();
    let keeper = MemoryKeeper::default();
    let records = RowSource::Records { records: &shelf, keeper: Some(&keeper) };
    visited(&Selection::default(), &study, records).unwrap();
    let table = keeper.0.take();
    assert!(table.is_whole && table.rows.len() == 18);
    let results = Results::read(study.clone(), &shelf).unwrap();
    let other = MemoryKeeper::default();
    results.keep_rows(&other);
    let other = other.0.take();
    assert_eq!((&other.rows, &other.columns), (&table.rows, &table.columns));
    assert!(other.keys == table.keys && other.is_whole);
    assert_eq!(tabled_columns(&study).len(), table.columns.len());

    let key = |index: usize| points[index].key.to_string();
    let filters = [
        String::new(),
        "mesh == 6".to_owned(),
        "load > 1".to_owned(),
        "load == null || status == \"failed\"".to_owned(),
        "status.startsWith(\"c\") && mu < 0.3".to_owned(),
        format!("key == \"{}\"", key(3)),
        format!("key in [\"{}\", \"{}\", \"{}\"] && mu < 0.3", key(17), key(4), key(9)),
        format!("key == \"{}\"", key(3).to_uppercase()),
        format!("key == \"{}\" || mu > 0.3", key(3)),
        format!("key == \"{}\" && mu > \"x\"", key(3)),
        "key == \"nothing\"".to_owned(),
        "mu > \"x\"".to_owned(),
        "mush > 1".to_owned(),
        "mu >".to_owned(),
    ];
    let choices: [&[&str]; 4] =
        [&["mu", "load"], &["stick_fraction", "key", "reason"], &["status"], &["lode"]];
    for filter in filters {
        for columns in choices {
            for sort in [&[][..], &["-load", "mu"], &["reason"]] {
                let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
                let selection = Selection {
                    filter: Some(filter.clone()).filter(|filter| !filter.is_empty()),
                    sort: words(sort),
                    columns: words(columns),
                    steps: false,
                };
                let name = format!("{selection:?}");
                assert!(selection.is_in_table(&study, &table));
                let records = RowSource::Records { records: &shelf, keeper: None };
                let rows = RowSource::Table(&table);
                let gathered = |source| {
                    let gathered = selection.gathered(&study, source, 18);
                    gathered.map(|found| found.unwrap().0).map_err(|error| error.to_string())
                };
                assert_eq!(gathered(rows), gathered(records), "{name}");
                let whole = selection.of(&results).ok();
                assert_eq!(selection.of_table(&study, &table).ok(), whole, "{name}");
                let streamed = Selection { sort: Vec::new(), ..selection.clone() };
                let (one, other) =
                    (visited(&streamed, &study, rows), visited(&streamed, &study, records));
                assert_eq!(one, other, "{name}");
            }
        }
    }
    // A condition that names jobs reads their rows alone.
    let filter = Some(format!("mu < 5 && key in [\"{}\", \"{}\"]", key(12), key(3)));
    let selection = Selection { filter, columns: vec!["mu".to_owned()], ..Selection::default() };
    table.read.take();
    assert_eq!(selection.of_table(&study, &table).unwrap().rows().len(), 2);
    assert_eq!(table.read.take(), [3, 12]);
    let steps = Selection { steps: true, ..selection };
    assert!(!steps.is_in_table(&study, &table), "a table has no increments");
}

/// A table has no column whose values depend on more than a point and its record.
#[test]
fn a_table_lacks_what_is_compared_and_who_computed_it() {
    let study = crate::convergence();
    let names: Vec<String> =
        tabled_columns(&study).iter().map(|column| column.name.to_string()).collect();
    let has = |name: &str| names.iter().any(|has| has == name);
    assert!(has("key") && has("load") && has("seconds") && has("run"));
    assert!(!has("host") && !has("commit") && !has("processor"));
    let compared = study.columns().into_iter().filter(Column::is_compared);
    let compared: Vec<_> = compared.map(|column| column.name).collect();
    assert!(!compared.is_empty() && compared.iter().all(|name| !has(name)));
}
