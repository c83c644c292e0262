//! A study with what its jobs left: rows of tables, and the answers beyond them.

use std::cell::OnceCell;

use contact::model::{Dof, Observables, Step};
use report::DataTable;
use serde::Serialize;
use study::columns::{Role, Row, along_path};
use study::{Figure, Record, Study, StudyPoint};

use crate::choice::{Chosen, Finding, Found, Gathered, gather};
use crate::comparison::{AnswerTable, Comparison};
use crate::error::AnswerError;
use crate::records::{RecordMap, Records};
use crate::rows::{heads, increments, row};
use crate::{choice, convergence, cost};

/// Rows of a study: every point, with the record of its job if there is one.
pub struct Results<'r> {
    study: Study,
    points: Vec<StudyPoint>,
    records: RecordMap,
    findings: Vec<Finding>,
    source: &'r dyn Records,
    /// Made when it is first asked for: it reads the fields of many records.
    comparison: OnceCell<Comparison>,
}

/// How far a study is; counts are of points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Progress {
    /// Points that the study has so far.
    pub points: usize,
    /// Points that were solved.
    pub done: usize,
    /// Points whose job ended without a solution.
    pub failed: usize,
    /// Points without a result.
    pub left: usize,
}

impl Progress {
    /// Reads how far a study is.
    ///
    /// # Errors
    /// A record cannot be read, or a condition cannot be evaluated.
    pub fn read(study: &Study, source: &dyn Records) -> Result<Self, AnswerError> {
        let Gathered { chosen: Chosen { points, .. }, records } = gather(study, source)?;
        Ok(Self::of(&points, &records))
    }

    fn of(points: &[StudyPoint], records: &RecordMap) -> Self {
        let mut progress = Self { points: points.len(), ..Self::default() };
        for point in points {
            match records.get(&point.key) {
                None => progress.left += 1,
                Some(record) if record.is_certified() => progress.done += 1,
                Some(_) => progress.failed += 1,
            }
        }
        progress
    }
}

impl<'r> Results<'r> {
    /// Reads what a study's jobs have left; points are not compared until that is asked for.
    ///
    /// # Errors
    /// A record cannot be read, or a condition cannot be evaluated.
    pub fn read(study: Study, source: &'r dyn Records) -> Result<Self, AnswerError> {
        let Gathered { chosen: Chosen { points, findings }, records } = gather(&study, source)?;
        Ok(Self { study, points, records, findings, source, comparison: OnceCell::new() })
    }

    /// The study.
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// The points of the study as far as its results determine them.
    pub fn points(&self) -> &[StudyPoint] {
        &self.points
    }

    /// The record of a point, if its job has left one.
    pub fn record(&self, point: &StudyPoint) -> Option<&Record> {
        self.records.get(&point.key)
    }

    /// How far the study is.
    pub fn progress(&self) -> Progress {
        Progress::of(&self.points, &self.records)
    }

    /// The number of points whose accuracy was asked for and not reached.
    pub fn inaccurate(&self) -> usize {
        let missed = |finding: &&Finding| matches!(finding.found, Found::Beyond { .. });
        self.findings.iter().filter(missed).count()
    }

    /// Returns what the study says beyond its rows.
    ///
    /// # Errors
    /// The fields of a record that is compared cannot be read.
    pub fn answers(&self) -> Result<&[AnswerTable], AnswerError> {
        Ok(&self.comparison()?.answers)
    }

    /// Returns every column of every point.
    ///
    /// Columns that come of comparing points have values if their name occurs in one of `mentions`,
    /// which are names of columns, filters and the like, and may be empty otherwise: to compare
    /// takes the fields of many records.
    ///
    /// # Errors
    /// The fields of a record that is compared cannot be read.
    pub fn table<S: AsRef<str>>(&self, mentions: &[S]) -> Result<DataTable, AnswerError> {
        let columns = self.study.columns();
        let is_mentioned =
            |name: &str| mentions.iter().any(|mention| mention.as_ref().contains(name));
        let is_compared = columns
            .iter()
            .any(|column| column.unknown_in_choosing().is_some() && is_mentioned(&column.name));
        let compared = if is_compared { &self.comparison()?.compared[..] } else { &[] };
        let rows = self.points.iter().enumerate().map(|(index, point)| {
            let compared = compared.get(index).and_then(Option::as_ref);
            row(&columns, &Row { point, record: self.record(point), compared })
        });
        Ok(DataTable::new(heads(&columns), rows.collect())?)
    }

    /// Returns every column of every increment that was computed.
    ///
    /// # Errors
    /// Two columns share a name.
    pub fn increments(&self) -> Result<DataTable, AnswerError> {
        let computed = self.points.iter().filter_map(|point| Some((point, self.record(point)?)));
        increments(&along_path(self.study.columns()), computed)
    }

    /// Returns the usual columns of every point.
    ///
    /// # Errors
    /// The fields of a record that is compared cannot be read.
    pub fn usual_table(&self) -> Result<DataTable, AnswerError> {
        let names = self.usual_columns(false);
        Ok(self.table(&names)?.select(&names)?)
    }

    /// Returns the rows that a figure is drawn from, those for which `filter` holds: the points, or
    /// their increments; one at which a path failed is no solution.
    ///
    /// # Errors
    /// The filter cannot be evaluated, or the fields of a record that is compared cannot be read.
    pub fn figure_table(
        &self,
        figure: &Figure,
        filter: Option<&str>,
    ) -> Result<DataTable, AnswerError> {
        let table = if figure.steps {
            self.increments()?.filter("status == \"certified\"")?
        } else {
            let Figure { x, y, series, panels, band, names, .. } = figure;
            let columns = [x].into_iter().chain(y).chain(series).chain(panels);
            let columns = columns.chain(band.iter().flatten()).chain(names).map(String::as_str);
            self.table(&columns.chain(filter).collect::<Vec<_>>())?
        };
        Ok(match filter {
            Some(expression) => table.filter(expression)?,
            None => table,
        })
    }

    fn comparison(&self) -> Result<&Comparison, AnswerError> {
        if let Some(comparison) = self.comparison.get() {
            return Ok(comparison);
        }
        let comparison = self.compare()?;
        Ok(self.comparison.get_or_init(|| comparison))
    }

    fn compare(&self) -> Result<Comparison, AnswerError> {
        let Self { study, points, records, findings, source, .. } = self;
        let mut answers = Vec::new();
        if !findings.is_empty() {
            let table = choice::table(study, findings)?;
            answers.push(AnswerTable { title: "found", table });
        }
        let mut comparison = Comparison { compared: Vec::new(), answers };
        if let Some(ladder) = &study.ladder() {
            let found = convergence::compare(study, ladder, points, records, *source)?;
            comparison.compared = found.compared;
            comparison.answers.extend(found.answers);
        }
        if let Some(cost) = &study.cost() {
            comparison = cost::compare(study, cost, points, records, *source)?;
        }
        Ok(comparison)
    }

    /// The columns that answer the question at a glance: the axes, the figures', the usual
    /// observables, and how it ended.
    pub fn usual_columns(&self, steps: bool) -> Vec<String> {
        let columns = self.study.columns();
        let mut names: Vec<String> = columns
            .iter()
            .filter(|column| column.role == Role::Axis)
            .map(|column| column.name.to_string())
            .collect();
        let figures = self.study.figures().iter().filter(|figure| steps || !figure.steps);
        let usual = match steps {
            true => path_columns(&self.points),
            false => {
                self.study.kind().usual_columns().iter().map(|name| (*name).to_owned()).collect()
            }
        };
        let own: Vec<String> = figures
            .flat_map(|figure| {
                std::iter::once(&figure.x).chain(&figure.y).chain(figure.band.iter().flatten())
            })
            .cloned()
            .collect();
        // on a path it comes first where one is
        let (first, then) = if steps { (usual, own) } else { (own, usual) };
        for name in first.into_iter().chain(then) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }
}

/// The columns that show loading paths at a glance: the place, the motions and forces that some
/// step mentions, what they do, and how it ended.
pub fn path_columns(points: &[StudyPoint]) -> Vec<String> {
    let paths = || points.iter().filter_map(|point| Some(&point.job.case()?.scene.loading));
    let cycle = paths().any(|path| path.cycle_from.is_some()).then_some("cycle");
    let mut names: Vec<String> =
        ["step"].into_iter().chain(cycle).chain(["increment"]).map(str::to_owned).collect();
    for dof in Dof::ALL {
        let [motion, force] = Step::NAMES[dof];
        if dof == Dof::Approach
            || paths().flat_map(|path| &path.steps).any(|step| step.given()[dof] != [None, None])
        {
            names.extend([
                format!("at_{motion}"),
                if force == "normal_force" { "load".to_owned() } else { force.to_owned() },
            ]);
        }
    }
    names.extend(["contact_radius", "stick_fraction", "dissipation", "status"].map(str::to_owned));
    names
}

/// A count that should be 0, and what it means when it is not.
pub struct Warning {
    /// The column of the count.
    pub column: &'static str,
    /// What it means, after "elements".
    pub words: &'static str,
    count: fn(&Observables) -> u64,
}

/// Every warning.
pub const WARNINGS: [Warning; 2] = [
    Warning {
        column: "edge_elements",
        words: "touch the edge of Ω although the punch goes on beyond it; give a larger `domain`",
        count: |observables| observables.edge_elements,
    },
    Warning {
        column: "ceiling_elements",
        words: "reach the pressure ceiling and so solve the regularised equation only; raise `ceiling`",
        count: |observables| observables.ceiling_elements,
    },
];

impl Warning {
    /// Whether some increment of a result has such elements.
    pub fn concerns(&self, record: &Record) -> bool {
        record.outcome().is_some_and(|outcome| {
            outcome.steps.iter().any(|step| (self.count)(&step.observables) > 0)
        })
    }
}
