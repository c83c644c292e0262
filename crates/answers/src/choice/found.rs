//! What a study that chooses points found.

use report::{Cell, DataTable, TableColumn};
use serde::Serialize;
use study::{Adaptive, Study, StudyPoint};

use crate::error::AnswerError;
use crate::rows::{cell, digits};

/// What is known of the points of a study.
pub struct Chosen {
    /// In order; what has no record yet is wanted.
    pub points: Vec<StudyPoint>,
    /// Of a study that chooses points, what it found so far at each combination of its axes.
    pub findings: Vec<Finding>,
}

/// What a study that chooses points found at one combination of its axes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The values of the axes, without the one that is halved.
    #[serde(skip)]
    pub at: Vec<(String, study::Value)>,
    /// How far the choice has come there.
    pub found: Found,
}

/// How far the choice of points has come.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Found {
    /// Jobs are left.
    Pending,
    /// A job that the choice depends on was not solved.
    Unsolved,
    /// The result holds still.
    Still {
        /// Elements along x and y of the finest mesh.
        mesh: [u32; 2],
        /// The result on that mesh, in SI units.
        value: f64,
        /// The relative change from the mesh before.
        change: f64,
    },
    /// The finest mesh that is allowed came before the result held still.
    NotStill {
        /// Elements along x and y of the finest mesh.
        mesh: [u32; 2],
        /// The result on that mesh, in SI units.
        value: f64,
        /// The relative change from the mesh before; `None` for the only one.
        change: Option<f64>,
    },
    /// The condition changes between two values of the axis, in SI units.
    Changes {
        /// The lower value.
        from: f64,
        /// The upper value.
        to: f64,
        /// The condition holds at the upper value, and not at the lower one; else the reverse.
        becomes: bool,
    },
    /// The condition is the same at every value that was tried.
    Everywhere {
        /// It holds.
        holds: bool,
    },
    /// These settings are to be tried next.
    Next {
        /// Elements along x and y.
        mesh: [u32; 2],
        /// The solver's tolerance.
        tolerance: f64,
    },
    /// These settings are accurate enough.
    Within {
        /// Elements along x and y.
        mesh: [u32; 2],
        /// The solver's tolerance.
        tolerance: f64,
        /// The estimated relative error.
        error: f64,
    },
    /// No settings were accurate enough; these came closest.
    Beyond {
        /// Elements along x and y.
        mesh: [u32; 2],
        /// The solver's tolerance.
        tolerance: f64,
        /// The estimated relative error, if there is an estimate.
        error: Option<f64>,
        /// The reason, in words.
        why: &'static str,
    },
}

/// What was found as a table.
pub fn table(study: &Study, findings: &[Finding]) -> Result<DataTable, AnswerError> {
    let axes = findings.first().map(|finding| finding.at.clone()).unwrap_or_default();
    let columns = study.columns();
    let unit = |name: &str| study::columns::find(&columns, name).map_or("", study::Column::unit);
    let mut heads: Vec<TableColumn> =
        axes.iter().map(|(name, _)| TableColumn::new(name.as_str(), unit(name))).collect();
    let own: Vec<(String, String)> = match study.adaptive() {
        Some(Adaptive::Refine { on, .. }) => {
            vec![
                ("mesh".into(), String::new()),
                (on.clone(), unit(on).into()),
                ("change".into(), "1".into()),
            ]
        }
        Some(Adaptive::Bisect { axis, .. }) => {
            let name =
                study.axes().nth(*axis).map(|axis| axis.column().into_owned()).unwrap_or_default();
            ["from", "to"].map(|end| (format!("{name}_{end}"), unit(&name).to_owned())).to_vec()
        }
        Some(Adaptive::Accuracy(_)) => ["mesh", "tolerance", "estimated error"]
            .map(|name| (name.to_owned(), String::new()))
            .to_vec(),
        None => Vec::new(),
    };
    heads.extend(own.iter().map(|(name, unit)| TableColumn::new(name.as_str(), unit.as_str())));
    heads.push(TableColumn::new("found", ""));
    let rows = findings.iter().map(|Finding { at, found }| {
        let mesh =
            |[x, y]: [u32; 2]| Cell::Text(if x == y { x.to_string() } else { format!("{x}x{y}") });
        let (cells, words) = match *found {
            Found::Pending => (Vec::new(), "jobs are left"),
            Found::Unsolved => (Vec::new(), "a job was not solved"),
            Found::Still { mesh: sides, value, change } => (
                vec![mesh(sides), Cell::Number(value), Cell::Number(digits(change, 1))],
                "holds still",
            ),
            Found::NotStill { mesh: sides, value, change } => {
                let change = change.map_or(Cell::Missing, |change| Cell::Number(digits(change, 1)));
                (
                    vec![mesh(sides), Cell::Number(value), change],
                    "still changes on the finest mesh allowed",
                )
            }
            Found::Changes { from, to, becomes } => (
                vec![Cell::Number(from), Cell::Number(to)],
                if becomes { "begins to hold" } else { "ceases to hold" },
            ),
            Found::Everywhere { holds } => {
                (Vec::new(), if holds { "holds everywhere" } else { "holds nowhere" })
            }
            Found::Next { mesh: sides, tolerance } => {
                (vec![mesh(sides), Cell::Number(tolerance)], "to be tried next")
            }
            Found::Within { mesh: sides, tolerance, error } => (
                vec![mesh(sides), Cell::Number(tolerance), Cell::Number(digits(error, 1))],
                "accurate enough",
            ),
            Found::Beyond { mesh: sides, tolerance, error, why } => {
                let error = error.map_or(Cell::Missing, |error| Cell::Number(digits(error, 1)));
                (vec![mesh(sides), Cell::Number(tolerance), error], why)
            }
        };
        let missing = own.len() - cells.len();
        let axes = at.iter().map(|(_, value)| cell(value.clone()));
        axes.chain(cells)
            .chain(std::iter::repeat_n(Cell::Missing, missing))
            .chain([Cell::Text(words.to_owned())])
            .collect()
    });
    Ok(DataTable::new(heads, rows.collect())?)
}
