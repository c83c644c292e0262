//! The findings of a study that chooses points, and their table.

use report::{Cell, DataTable, TableColumn};
use study::{Adaptive, Study, StudyPoint};

use crate::error::AnswerError;
use crate::place::{StudyPlace, unit_of};
use crate::rows::rounded;

/// The points of a study, as far as they are determined.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointChoice {
    /// The points, in order; a point without a record is wanted.
    pub points: Vec<StudyPoint>,
    /// The findings so far at each combination of the axes, for a study that chooses points.
    pub findings: Vec<Finding>,
}

impl PointChoice {
    /// Adds the points and the findings of another part of the study.
    pub(super) fn extend(&mut self, other: PointChoice) {
        self.points.extend(other.points);
        self.findings.extend(other.findings);
    }
}

/// The finding of a study that chooses points at one combination of its axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The values of the axes, without the one that is halved.
    pub place: StudyPlace,
    /// The state of the choice there.
    pub discovery: Discovery,
}

/// The state of a choice of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Discovery {
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
        /// True if it holds everywhere, false if nowhere.
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
        reason: &'static str,
    },
}

/// Returns what was found as a table: a row for each finding.
///
/// # Errors
/// An axis has the name of another column.
pub fn table(study: &Study, findings: &[Finding]) -> Result<DataTable, AnswerError> {
    let mut heads = findings.first().map(|finding| finding.place.heads(study)).unwrap_or_default();
    let figures = figure_heads(study);
    let count = figures.len();
    heads.extend(figures);
    heads.push(TableColumn::new("found", ""));
    let rows = findings.iter().map(|Finding { place, discovery }| {
        let mut row = place.cells();
        let mut figures = discovery.figures();
        figures.resize(count, Cell::Missing);
        row.extend(figures);
        row.push(Cell::Text(discovery.words().to_owned()));
        row
    });
    Ok(DataTable::new(heads, rows.collect())?)
}

/// Returns the heads of the figures that a rule finds.
fn figure_heads(study: &Study) -> Vec<TableColumn> {
    let columns = study.columns();
    match study.adaptive() {
        Some(Adaptive::Refine { on, .. }) => vec![
            TableColumn::new("mesh", ""),
            TableColumn::new(on.as_str(), unit_of(&columns, on)),
            TableColumn::new("change", "1"),
        ],
        Some(Adaptive::Bisect { axis, .. }) => {
            let name = study.axes().nth(*axis).map(|axis| axis.column()).unwrap_or_default();
            let head = |end| TableColumn::new(format!("{name}_{end}"), unit_of(&columns, &name));
            ["from", "to"].map(head).to_vec()
        }
        Some(Adaptive::Accuracy(_)) => {
            ["mesh", "tolerance", "estimated error"].map(|name| TableColumn::new(name, "")).to_vec()
        }
        None => Vec::new(),
    }
}

impl Discovery {
    /// Returns the cells of its figures; there may be fewer of them than columns.
    fn figures(&self) -> Vec<Cell> {
        match *self {
            Discovery::Pending | Discovery::Unsolved | Discovery::Everywhere { .. } => Vec::new(),
            Discovery::Still { mesh, value, change } => {
                vec![mesh_cell(mesh), Cell::Number(value), rounded(Some(change), 1)]
            }
            Discovery::NotStill { mesh, value, change } => {
                vec![mesh_cell(mesh), Cell::Number(value), rounded(change, 1)]
            }
            Discovery::Changes { from, to, .. } => vec![Cell::Number(from), Cell::Number(to)],
            Discovery::Next { mesh, tolerance } => vec![mesh_cell(mesh), Cell::Number(tolerance)],
            Discovery::Within { mesh, tolerance, error } => {
                vec![mesh_cell(mesh), Cell::Number(tolerance), rounded(Some(error), 1)]
            }
            Discovery::Beyond { mesh, tolerance, error, .. } => {
                vec![mesh_cell(mesh), Cell::Number(tolerance), rounded(error, 1)]
            }
        }
    }

    fn words(&self) -> &'static str {
        match self {
            Discovery::Pending => "jobs are left",
            Discovery::Unsolved => "a job was not solved",
            Discovery::Still { .. } => "holds still",
            Discovery::NotStill { .. } => "still changes on the finest mesh allowed",
            Discovery::Changes { becomes: true, .. } => "begins to hold",
            Discovery::Changes { becomes: false, .. } => "ceases to hold",
            Discovery::Everywhere { holds: true } => "holds everywhere",
            Discovery::Everywhere { holds: false } => "holds nowhere",
            Discovery::Next { .. } => "to be tried next",
            Discovery::Within { .. } => "accurate enough",
            Discovery::Beyond { reason, .. } => reason,
        }
    }
}

/// Returns the elements along x and y as a cell, one number if they are equal.
fn mesh_cell([x, y]: [u32; 2]) -> Cell {
    Cell::Text(if x == y { x.to_string() } else { format!("{x}x{y}") })
}
