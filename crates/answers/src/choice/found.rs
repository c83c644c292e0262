//! The findings of a study that chooses points, and their table.

use report::{Cell, DataTable, TableColumn};
use study::{Adaptive, RootSearch, Study, StudyPoint};

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
    /// The largest number of points that may follow when these have results; `None` if it is not
    /// known.
    pub more: Option<usize>,
}

impl PointChoice {
    /// Returns a choice without points, to which others whose number is known can be added.
    pub(super) fn bounded() -> Self {
        PointChoice { more: Some(0), ..PointChoice::default() }
    }

    /// Adds the points and the findings of another part of the study.
    pub(super) fn extend(&mut self, other: PointChoice) {
        self.points.extend(other.points);
        self.findings.extend(other.findings);
        self.more = self.more.zip(other.more).map(|(these, those)| these + those);
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
    /// The result crosses the value that is looked for.
    Root {
        /// The root of the straight line through the ends of the bracket, in SI units as all here.
        root: f64,
        /// The lower end of the bracket.
        from: f64,
        /// The upper end.
        to: f64,
        /// The result at the lower end and at the upper one.
        values: [f64; 2],
        /// True if it rises through the value, false if it falls.
        rises: bool,
        /// True if it jumps: the change in the bracket is most of that between given values.
        jumps: bool,
    },
    /// The result is just the value that is looked for.
    Met {
        /// The lowest value of the axis at which it is.
        from: f64,
        /// The highest one in a row.
        to: f64,
        /// The way in which it comes and goes.
        passage: Passage,
    },
    /// The result at a job between two values of the axis is not known.
    Open {
        /// The lower value; `None` from the lower end of the axis on.
        from: Option<f64>,
        /// The upper value; `None` up to the upper end of the axis.
        to: Option<f64>,
        /// The result at both, if that tells something.
        values: [Option<f64>; 2],
        /// The reason, and what is known all the same, in words.
        reason: &'static str,
    },
    /// The result is never the value that is looked for at the values of the axis, and always on
    /// one side of it.
    Apart {
        /// The value of the axis at which it comes nearest.
        nearest: f64,
        /// The result there.
        value: f64,
        /// True if the result is above the value that is looked for, false if it is below.
        is_above: bool,
    },
    /// No further point is added to a curve or a map.
    Filled {
        /// The number of points that were added.
        added: usize,
        /// The largest distance between the result and what is interpolated, by estimate, relative
        /// to the range of the column; `None` if it has none.
        deviation: Option<f64>,
        /// The reason, in words.
        reason: &'static str,
    },
    /// The bracket of a uniqueness set is as narrow as it gets.
    Branched {
        /// Both ends; `None` if μ* is infinite.
        ends: Option<[f64; 2]>,
        /// The number of jobs that looked at parts of the fields.
        jobs: usize,
        /// The number of cones that they looked at.
        cones: usize,
        /// The state of the bracket, in words.
        reason: &'static str,
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

/// The way in which a result passes the value that is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passage {
    /// It rises through it.
    Rises,
    /// It falls through it.
    Falls,
    /// It comes back to the side from which it came.
    Touches,
    /// It is known on one side only.
    Meets,
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
        Some(Adaptive::Find(RootSearch { axis, column, .. })) => {
            let axis = study.axes().nth(*axis).map(|axis| axis.column()).unwrap_or_default();
            let (axis, unit) = (axis.as_ref(), unit_of(&columns, &axis));
            let of_axis =
                ["", "_from", "_to"].map(|end| TableColumn::new(format!("{axis}{end}"), unit));
            let unit = unit_of(&columns, column);
            let of_column =
                ["_from", "_to"].map(|end| TableColumn::new(format!("{column}{end}"), unit));
            of_axis.into_iter().chain(of_column).collect()
        }
        Some(Adaptive::Fill(_)) => {
            vec![TableColumn::new("added", ""), TableColumn::new("deviation", "1")]
        }
        Some(Adaptive::Branch { .. }) => {
            let of_ends =
                ["mu_low", "mu_high", "bracket_width"].map(|end| TableColumn::new(end, "1"));
            let counts = ["jobs", "cones"].map(|count| TableColumn::new(count, ""));
            of_ends.into_iter().chain(counts).collect()
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
            Discovery::Root { root, from, to, values, .. } => {
                [root, from, to].into_iter().chain(values).map(Cell::Number).collect()
            }
            Discovery::Met { from, to, .. } if from == to => vec![Cell::Number(from); 3],
            Discovery::Met { from, to, .. } => {
                vec![Cell::Missing, Cell::Number(from), Cell::Number(to)]
            }
            Discovery::Open { from, to, values: [at_from, at_to], .. } => {
                let cells = [None, from, to, at_from, at_to];
                cells.map(|value| value.map_or(Cell::Missing, Cell::Number)).to_vec()
            }
            Discovery::Apart { nearest, value, .. } => {
                let number = Cell::Number;
                vec![Cell::Missing, number(nearest), number(nearest), number(value), number(value)]
            }
            Discovery::Filled { added, deviation, .. } => {
                vec![Cell::Integer(added as i64), rounded(deviation, 1)]
            }
            Discovery::Branched { ends, jobs, cones, .. } => {
                let width = ends.map(|[low, high]| (high - low) / high);
                let [low, high] = [0, 1].map(|end| ends.map(|ends| ends[end]));
                let ends = [low, high].map(|end| end.map_or(Cell::Missing, Cell::Number));
                let counts = [jobs, cones].map(|count| Cell::Integer(count as i64));
                ends.into_iter().chain([rounded(width, 2)]).chain(counts).collect()
            }
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
            Discovery::Root { rises: true, jumps: false, .. } => "rises through it",
            Discovery::Root { rises: false, jumps: false, .. } => "falls through it",
            Discovery::Root { rises: true, jumps: true, .. } => "jumps over it, upwards",
            Discovery::Root { rises: false, jumps: true, .. } => "jumps over it, downwards",
            Discovery::Met { passage, .. } => match passage {
                Passage::Rises => "is just it and rises through it",
                Passage::Falls => "is just it and falls through it",
                Passage::Touches => "is just it and does not cross",
                Passage::Meets => "is just it; not known on both sides",
            },
            Discovery::Open { reason, .. } => reason,
            Discovery::Apart { is_above: true, .. } => "above it at all given values, nearest here",
            Discovery::Apart { is_above: false, .. } => {
                "below it at all given values, nearest here"
            }
            Discovery::Filled { reason, .. } | Discovery::Branched { reason, .. } => reason,
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
