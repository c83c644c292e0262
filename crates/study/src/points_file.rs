//! Points that a file lists: a table as CSV, whose heads are keys.
//!
//! ```toml
//! [points]
//! file = "points.csv"             # beside the study; a copy of it is kept with the study
//! columns = ["mu", "radius"]      # these alone; without, all columns that are keys
//! ```
//!
//! A head is the path of a key or the name of its column, with a unit or without:
//! `punch.radius`, `radius`, `radius [mm]`. A value without a unit is in SI units, or has one of
//! its own: `5 mm`. The columns are axes that advance together; `[sweep]` may have others beside
//! them.
//! What `query --format csv` writes can be read: columns of results and of the labels of tables are
//! left out, which is said.

use std::collections::HashMap;

use toml::de::DeValue;

use contact::model::Mesh;

use crate::axis::{Choice, ChoiceIdentity, Group, MAX_AXES, MAX_POINTS, SweepAxis, Target};
use crate::bounds::{ANY, from};
use crate::error::{Mistake, Span};
use crate::fallback::Fallback::{Follows, Needed};
use crate::file_fault::{FileFaults, FilePlace};
use crate::file_text::decode_text;
use crate::key::{Key, Table};
use crate::quantity::Quantity;
use crate::read::{self, Node};
use crate::sheet::Setting;
use crate::study_files::{ReadFile, StudyFiles};
use crate::suggestion::nearest_path;
use crate::table_key::{KeyTable, TEXT, TableValue, table_key};
use crate::table_text::{TextRow, read_rows};
use crate::units::{Dimension, LengthUnit, leading_number, quantity, unit_value};

/// The table.
pub(crate) const TABLE: KeyTable = KeyTable {
    path: "points",
    is_list: false,
    meaning: "points that a file lists: a table as CSV, whose heads are keys",
    keys: &[
        table_key("file", TEXT, ANY, Needed, "\"points.csv\"", "file, beside the study"),
        table_key(
            "columns",
            TableValue::Other("a list of heads"),
            from(1.0),
            Follows("all that are keys"),
            "[\"mu\"]",
            "columns of the file that count",
        ),
    ],
};

/// The largest number of values that a file of points may give.
const MAX_VALUES: usize = 2_000_000;

/// The points of a file.
pub(crate) struct FilePoints {
    /// The axes that advance together.
    pub(crate) group: Group,
    /// The words about what was left out, if anything was.
    pub(crate) remarks: Vec<String>,
}

/// A column of the file that gives a key.
struct PointColumn {
    key: Key,
    /// The symbol of the unit in its head, if it has one.
    unit: Option<String>,
    /// The index in the file.
    index: usize,
    choices: Vec<Choice>,
}

/// The columns of a file by what they are for.
#[derive(Default)]
struct PointHeads {
    columns: Vec<PointColumn>,
    /// The heads of results.
    results: Vec<String>,
    /// The heads of the labels of tables.
    labels: Vec<String>,
}

/// Reads `[points]` and the file that it names, which is kept among the files of the study.
/// `is_result` says whether a name is that of a column of results.
pub(crate) fn read_points(
    node: &Node<'_>,
    kept: &mut StudyFiles,
    files: &mut ReadFile<'_>,
    is_result: &dyn Fn(&str) -> bool,
    mistakes: &mut Vec<Mistake>,
) -> Option<FilePoints> {
    let DeValue::Table(table) = node.get_ref() else {
        mistakes.push(read::mistyped("points", node, "a table with file = \"points.csv\""));
        return None;
    };
    let before = mistakes.len();
    read::refuse_unknown(table, "`[points]`", &TABLE.names(), mistakes);
    let wanted = table.get("columns").map(|node| match node.get_ref() {
        DeValue::Array(names) if !names.is_empty() => {
            names.iter().map(|name| read::text("points.columns", name)).collect()
        }
        _ => Err(read::mistyped("points.columns", node, "a list of heads like [\"mu\"]")),
    });
    let wanted: Option<Vec<String>> =
        wanted.transpose().map_err(|mistake| mistakes.push(mistake)).unwrap_or_default();
    let Some(file) = table.get("file") else {
        let mistake = Mistake::new(node.span(), "`points.file` is missing", "needs file = \"…\"");
        mistakes.push(mistake);
        return None;
    };
    let name = read::text("points.file", file).map_err(|mistake| mistakes.push(mistake)).ok()?;
    if mistakes.len() > before {
        return None;
    }
    let span = file.span();
    let read = kept.load(&name, files).and_then(|()| {
        let reading = PointsReading { file: &name, span: &span, wanted, is_result };
        reading.points(kept.loaded(&name)).map_err(|faults| kept.words(&name, &faults))
    });
    read.map_err(|reason| {
        let expected = "must be a table as CSV, whose heads are keys";
        mistakes.push(Mistake::new(
            span.clone(),
            format!("cannot use these points: {reason}"),
            expected,
        ));
    })
    .ok()
}

/// The knowledge of a file of points before it is read.
struct PointsReading<'a> {
    file: &'a str,
    span: &'a Span,
    /// The heads that are wanted; `None` for all that are keys.
    wanted: Option<Vec<String>>,
    is_result: &'a dyn Fn(&str) -> bool,
}

impl PointsReading<'_> {
    /// Reads the points, or returns every fault of the file.
    fn points(&self, bytes: &[u8]) -> Result<FilePoints, FileFaults> {
        let text = decode_text(bytes).ok_or_else(|| FileFaults::whole("it is not text"))?;
        let mut rows = read_rows(&text);
        let not_csv = |error: csv::Error| FileFaults::whole(format!("it is no CSV: {error}"));
        let heads = match rows.next() {
            Some(heads) => heads.map_err(not_csv)?,
            None => return Err(FileFaults::whole("it is empty")),
        };
        let mut faults = FileFaults::default();
        let PointHeads { mut columns, results, labels } = self.columns(&heads, &mut faults);
        if faults.is_empty() && columns.is_empty() {
            faults.append(FileFaults::whole("no head is a key of the scene or the numerics"));
        }
        let mut seen: HashMap<Vec<ChoiceIdentity>, usize> = HashMap::new();
        let mut repeated = 0;
        for (row, record) in rows.enumerate() {
            let TextRow { line, cells: record } = record.map_err(not_csv)?;
            if (row + 1).saturating_mul(columns.len().max(1)) > MAX_VALUES || row == MAX_POINTS {
                let most = MAX_POINTS.min(MAX_VALUES / columns.len().max(1));
                let message = format!("it has more than {most} points");
                faults.append(FileFaults::whole(message));
                break;
            }
            if record.len() != heads.cells.len() {
                let (found, all) = (record.len(), heads.cells.len());
                faults.add(Some(FilePlace::line(line)), "", || {
                    format!("{found} values, but {all} heads")
                });
                continue;
            }
            let mut choices = Vec::new();
            for column in &columns {
                let text = record.get(column.index).unwrap_or_default();
                match value(column.key, column.unit.as_deref(), text) {
                    Ok(setting) => {
                        choices.push(Choice::of_key(
                            column.key,
                            setting,
                            self.span.clone(),
                            Some(row + 1),
                        ));
                    }
                    Err(reason) => {
                        let place = FilePlace { line, value: column.index + 1 };
                        faults.add(Some(place), text, || reason);
                    }
                }
            }
            if choices.len() < columns.len() {
                continue;
            }
            if seen.insert(choices.iter().map(Choice::identity).collect(), row).is_some() {
                repeated += 1;
                continue;
            }
            columns
                .iter_mut()
                .zip(choices)
                .for_each(|(column, choice)| column.choices.push(choice));
        }
        if faults.is_empty() && columns.iter().all(|column| column.choices.is_empty()) {
            faults.append(FileFaults::whole("it has heads and no points"));
        }
        faults.or(())?;
        let length = columns.first().map_or(0, |column| column.choices.len());
        let axes = columns.into_iter().map(|PointColumn { key, choices, .. }| SweepAxis {
            target: Target::Key(key),
            choices,
            log: false,
            distribution: None,
            span: self.span.clone(),
        });
        let group = Group::listed(axes.collect(), length);
        Ok(FilePoints { group, remarks: self.remarks(&results, &labels, repeated) })
    }

    /// Tells the columns apart.
    fn columns(
        &self,
        TextRow { line, cells: heads }: &TextRow,
        faults: &mut FileFaults,
    ) -> PointHeads {
        let mut found = PointHeads::default();
        let PointHeads { columns, results, labels } = &mut found;
        if heads.len() > MAX_AXES {
            faults.append(FileFaults::whole(format!("it has more than {MAX_AXES} columns")));
            return found;
        }
        let mut missing: Vec<&String> = self.wanted.iter().flatten().collect();
        for (index, head) in heads.iter().enumerate() {
            let (name, unit) = parts(head);
            missing.retain(|wanted| *wanted != name && *wanted != head);
            let is_wanted = |wanted: &Vec<String>| wanted.iter().any(|w| w == name || w == head);
            if !self.wanted.as_ref().is_none_or(is_wanted) {
                continue;
            }
            let place = Some(FilePlace { line: *line, value: index + 1 });
            let key = Key::find(name).or_else(|| Key::of_column(name));
            if key.is_none() && (self.is_result)(name) {
                results.push(name.to_owned());
                continue;
            }
            if self.wanted.is_none() && is_label(name, key, heads) {
                labels.push(name.to_owned());
                continue;
            }
            match column_of(key, name, unit) {
                Err(reason) => faults.add(place, head, || reason),
                Ok(key) if columns.iter().any(|column| column.key == key) => {
                    faults.add(place, head, || "is given by another column as well".to_owned());
                }
                Ok(key) => {
                    let unit = unit.map(str::to_owned);
                    columns.push(PointColumn { key, unit, index, choices: Vec::new() });
                }
            }
        }
        for name in missing {
            faults.append(FileFaults::whole(format!("it has no column `{name}`")));
        }
        found
    }

    fn remarks(&self, results: &[String], labels: &[String], repeated: usize) -> Vec<String> {
        let file = wording::excerpt(self.file, 60);
        let mut remarks = Vec::new();
        let reasons = [
            (results, "they are results"),
            (labels, "they name tables whose keys stand beside them"),
        ];
        for (names, reason) in reasons.into_iter().filter(|(names, _)| !names.is_empty()) {
            remarks.push(format!(
                "points {file}: left out, since {reason}: {}",
                wording::excerpt(&names.join(", "), 300)
            ));
        }
        if repeated > 0 {
            let verb = if repeated == 1 {
                "line repeats an earlier one and adds no point"
            } else {
                "lines repeat earlier ones and add no points"
            };
            remarks.push(format!("points {file}: {repeated} {verb}"));
        }
        remarks
    }
}

/// Splits a head into the name and the unit: `radius [mm]`.
fn parts(head: &str) -> (&str, Option<&str>) {
    let split = head.strip_suffix(']').and_then(|head| head.rsplit_once('['));
    match split {
        // An index of a list ends with a bracket too.
        Some((name, unit))
            if !unit.bytes().all(|byte| byte.is_ascii_digit()) || name.ends_with(' ') =>
        {
            (name.trim(), Some(unit.trim()).filter(|unit| !unit.is_empty()))
        }
        _ => (head, None),
    }
}

/// Returns whether a column has the labels of a table of which keys stand in other columns.
fn is_label(name: &str, key: Option<Key>, heads: &csv::StringRecord) -> bool {
    let is_key = key.is_some_and(|key| !matches!(key.quantity(), Quantity::List(_)));
    let table = Table::find(name).or_else(|| Table::of_column(name)).filter(|_| !is_key);
    let is_beside = |table: Table| {
        let others = heads.iter().map(|head| parts(head).0).filter(|other| *other != name);
        let mut keys =
            others.filter_map(|other| Key::find(other).or_else(|| Key::of_column(other)));
        keys.any(|key| key.is_under(&table))
    };
    table.is_some_and(is_beside)
}

/// Returns the key of a head, or why it gives none.
fn column_of(key: Option<Key>, name: &str, unit: Option<&str>) -> Result<Key, String> {
    let Some(key) = key else {
        if name.is_empty() {
            return Err("a column has no head".to_owned());
        }
        if Table::find(name).is_some() {
            return Err("is a table: its keys need columns of their own".to_owned());
        }
        return Err(match nearest_path(name) {
            Some(near) => format!("is no key; did you mean `{near}`?"),
            None => "is no key of the scene or the numerics".to_owned(),
        });
    };
    let dimension = match key.quantity() {
        Quantity::List(_) | Quantity::Effects | Quantity::Lengths | Quantity::Places => {
            return Err("is a list, which no column can give".to_owned());
        }
        Quantity::Number(dimension) => dimension,
        _ => Dimension::Pure,
    };
    match unit {
        None | Some("1") if dimension == Dimension::Pure => Ok(key),
        None => Ok(key),
        Some(unit) => match unit_value("1", unit) {
            Some((_, found)) if found == dimension => Ok(key),
            Some((_, found)) => {
                Err(format!("has a unit of {}, and is {}", found.noun(), dimension.noun()))
            }
            None if dimension == Dimension::Pure => {
                Err("has a unit, and is a pure number".to_owned())
            }
            None => {
                let units: Vec<&str> = dimension.units().collect();
                Err(format!("has an unknown unit; there are {}", units.join(", ")))
            }
        },
    }
}

/// Returns the setting that a text gives to a key, in the unit of the head if it has one; or why it
/// gives none.
fn value(key: Key, unit: Option<&str>, text: &str) -> Result<Setting, String> {
    if text.is_empty() {
        return Err("a value is missing".to_owned());
    }
    let must = || format!("must be {}", key.quantity().expected());
    let pair = || "must be a whole number like 64, or a pair like 64x32".to_owned();
    match key.quantity() {
        Quantity::Number(dimension) => number(dimension, unit, text).map(Setting::Number),
        Quantity::Count => text.parse().map(Setting::Count).map_err(|_| must()),
        Quantity::Mesh => match text.split_once('x') {
            None => text.parse().map(|n| Setting::Mesh(Mesh::Across(n))).map_err(|_| pair()),
            Some((x, y)) => match (x.trim().parse(), y.trim().parse()) {
                (Ok(x), Ok(y)) => Ok(Setting::Mesh(Mesh::Exact([x, y]))),
                _ => Err(pair()),
            },
        },
        Quantity::Flag => match text {
            "true" | "True" => Ok(Setting::Flag(true)),
            "false" | "False" => Ok(Setting::Flag(false)),
            _ => Err(must()),
        },
        Quantity::Choice(words) if !words.contains(&text) => Err(must()),
        Quantity::LengthUnit if LengthUnit::find(text).is_none() => Err(must()),
        _ => Ok(Setting::Word(text.to_owned())),
    }
}

fn number(dimension: Dimension, unit: Option<&str>, text: &str) -> Result<f64, String> {
    let is_bare = leading_number(text) == Some(text);
    let value = match unit.filter(|unit| *unit != "1") {
        Some(unit) if is_bare => unit_value(text, unit).map(|(value, _)| value),
        Some(_) => return Err("is no number in the unit of its head".to_owned()),
        None if is_bare => text.parse().ok(),
        None => {
            let must = |_| format!("must be {}", Quantity::Number(dimension).expected());
            return quantity(text, dimension).map_err(must);
        }
    };
    // −0 becomes 0, so that the two are one job.
    let finite = value.filter(|value: &f64| value.is_finite()).map(|value| value + 0.0);
    finite.ok_or_else(|| "is no finite number".to_owned())
}
