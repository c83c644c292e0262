//! A study with what its jobs have left: rows of tables, and the answers beyond them.

use std::cell::OnceCell;

use report::DataTable;
use serde::Serialize;
use study::columns::{Role, Row, along_path};
use study::{Figure, Record, Standing, Study, StudyPoint};

use crate::choice::{self, Discovery, Finding, Gathered, PointChoice, gather};
use crate::comparison::{AnswerTable, Comparison};
use crate::error::AnswerError;
use crate::evidence::Evidence;
use crate::kind::answers_of;
use crate::path::path_columns;
use crate::records::{RecordMap, Records};
use crate::rows::{heads, increments, row};

/// The points of a study, with the records that their jobs have left.
pub struct Results<'r> {
    study: Study,
    points: Vec<StudyPoint>,
    records: RecordMap,
    findings: Vec<Finding>,
    source: &'r dyn Records,
    /// The comparison of the points, made when it is first asked for: it reads the fields of many
    /// records.
    comparison: OnceCell<Comparison>,
}

/// The progress of a study, in numbers of points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Progress {
    /// The points that the study has so far.
    pub points: usize,
    /// The points that are solved.
    pub done: usize,
    /// The points whose job has ended without a solution.
    pub failed: usize,
    /// The points without a result.
    pub left: usize,
}

impl Progress {
    /// Reads how far a study is.
    ///
    /// # Errors
    /// A record cannot be read, or a condition cannot be evaluated.
    pub fn read(study: &Study, source: &dyn Records) -> Result<Self, AnswerError> {
        let Gathered { choice, records } = gather(study, source)?;
        Ok(Self::of(&choice.points, &records))
    }

    fn of(points: &[StudyPoint], records: &RecordMap) -> Self {
        let mut progress = Self { points: points.len(), ..Self::default() };
        for point in points {
            match records.get(&point.key).map(Record::standing) {
                None => progress.left += 1,
                Some(Standing::Certified) => progress.done += 1,
                Some(Standing::Failed | Standing::Quarantined) => progress.failed += 1,
            }
        }
        progress
    }
}

impl<'r> Results<'r> {
    /// Reads what a study's jobs have left. Points are not compared until that is asked for.
    ///
    /// # Errors
    /// A record cannot be read, or a condition cannot be evaluated.
    pub fn read(study: Study, source: &'r dyn Records) -> Result<Self, AnswerError> {
        let Gathered { choice: PointChoice { points, findings }, records } =
            gather(&study, source)?;
        Ok(Self { study, points, records, findings, source, comparison: OnceCell::new() })
    }

    /// Returns the study.
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// Returns the points of the study as far as its results determine them.
    pub fn points(&self) -> &[StudyPoint] {
        &self.points
    }

    /// Returns the record of a point, if its job has left one.
    pub fn record(&self, point: &StudyPoint) -> Option<&Record> {
        self.records.get(&point.key)
    }

    /// Returns how far the study is.
    pub fn progress(&self) -> Progress {
        Progress::of(&self.points, &self.records)
    }

    /// Returns the number of points whose accuracy was asked for and not reached.
    pub fn inaccurate(&self) -> usize {
        let is_missed = |finding: &&Finding| matches!(finding.discovery, Discovery::Beyond { .. });
        self.findings.iter().filter(is_missed).count()
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
    /// Columns that come from comparing points have values only if the name of such a column occurs
    /// in one of `mentions`, which are names of columns, filters and the like; otherwise they may
    /// be empty, for comparing takes the fields of many records.
    ///
    /// # Errors
    /// The fields of a record that is compared cannot be read.
    pub fn table<S: AsRef<str>>(&self, mentions: &[S]) -> Result<DataTable, AnswerError> {
        let columns = self.study.columns();
        let is_mentioned =
            |name: &str| mentions.iter().any(|mention| mention.as_ref().contains(name));
        let takes_comparison = columns
            .iter()
            .any(|column| column.unknown_in_choosing().is_some() && is_mentioned(&column.name));
        let compared = if takes_comparison { &self.comparison()?.compared[..] } else { &[] };
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
    /// their increments. The increment at which a path has failed is no solution and not among
    /// them.
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
            let columns = [x].into_iter().chain(y).chain(series).chain(panels).chain(names);
            let columns = columns.chain(band.iter().flatten()).map(String::as_str);
            self.table(&columns.chain(filter).collect::<Vec<_>>())?
        };
        Ok(match filter {
            Some(expression) => table.filter(expression)?,
            None => table,
        })
    }

    /// Returns the columns that answer the question at a glance, of the points or of their
    /// increments (`steps`): the axes, those of the figures, the usual observables, and how it
    /// ended.
    pub fn usual_columns(&self, steps: bool) -> Vec<String> {
        let columns = self.study.columns();
        let axes = columns.iter().filter(|column| column.role == Role::Axis);
        let mut names: Vec<String> = axes.map(|column| column.name.to_string()).collect();
        let figures = self.study.figures().iter().filter(|figure| steps || !figure.steps);
        let of_figures: Vec<String> = figures
            .flat_map(|figure| {
                [&figure.x].into_iter().chain(&figure.y).chain(figure.band.iter().flatten())
            })
            .cloned()
            .collect();
        let names_after = if steps {
            // The place on the path comes first.
            [path_columns(&self.points), of_figures]
        } else {
            let usual = self.study.kind().usual_columns().iter();
            [of_figures, usual.map(|name| (*name).to_owned()).collect()]
        };
        for name in names_after.into_iter().flatten() {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
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
        let kind = answers_of(study.kind());
        let evidence = Evidence { study, points, records, source: *source };
        let mut comparison = (kind.compare)(&evidence)?;
        if kind.tells_choice && !findings.is_empty() {
            let table = choice::table(study, findings)?;
            comparison.answers.insert(0, AnswerTable { title: "found", table });
        }
        Ok(comparison)
    }
}
