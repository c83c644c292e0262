//! The results of a large study whose points are compared with nothing, read in blocks, of which
//! one is in memory at a time.

use identity::KeptFields;
use report::DataTable;
use study::columns::Role;
use study::{Column, Figure, Record, Study};

use crate::block::visit;
use crate::error::AnswerError;
use crate::progress::{Failures, Progress};
use crate::records::Records;
use crate::rows::heads;
use crate::variation::noise;
use crate::warnings::{
    ElementDoubts, EstimateDoubts, InteriorDoubts, RequiredError, Subject, Warning,
};

/// The number of points whose results are read at a time where they are read in blocks: those of
/// 4096 take some 20 MiB.
pub(crate) const POINTS_AT_ONCE: usize = 4096;

/// The number of rows that are kept of a study that is too large for a figure.
const FIRST_ROWS: usize = 1000;

/// The number of failed jobs that are kept where results are read in blocks.
const MOST_FAILURES: usize = 10_000;

/// The knowledge of the results of a study that passed by once.
pub(crate) struct Survey {
    pub(crate) progress: Progress,
    pub(crate) elements: ElementDoubts,
    pub(crate) interiors: InteriorDoubts,
    pub(crate) estimates: EstimateDoubts,
    /// The relative change below which a quantity counts as constant.
    pub(crate) noise: f64,
    /// The columns that the jobs ask for.
    pub(crate) requests: Vec<&'static str>,
    pub(crate) failures: Failures,
    /// Some record has its fields in a file.
    pub(crate) has_files: bool,
    /// The columns that figures and summaries show, of all points or of the first.
    pub(crate) table: DataTable,
}

/// Returns whether a record has its fields in a file.
pub(crate) fn has_file(record: &Record) -> bool {
    matches!(record.fields, Some(KeptFields::Blob(_)))
}

impl Survey {
    /// Reads the results of a study block by block.
    pub(crate) fn of(study: &Study, source: &dyn Records) -> Result<Survey, AnswerError> {
        let mut columns = study.columns();
        columns.retain(|column| is_shown(study, column));
        let required = RequiredError::LARGE;
        let mut survey = Survey {
            progress: Progress { excluded: study.excluded(), ..Progress::default() },
            elements: ElementDoubts::new(Subject::Points),
            interiors: InteriorDoubts::new(Subject::Points),
            estimates: EstimateDoubts::new(Subject::Points, required),
            noise: 0.0,
            requests: Vec::new(),
            failures: Failures::default(),
            has_files: false,
            table: DataTable::new(heads(&columns), Vec::new())?,
        };
        let most = if study.is_listed() { usize::MAX } else { FIRST_ROWS };
        let mut rows = Vec::new();
        visit(study, source, POINTS_AT_ONCE, &mut |block| {
            survey.noise = survey.noise.max(noise(block.points));
            for point in block.points {
                let record = block.records.get(&point.key);
                survey.progress.add(record);
                for name in point.job.asked_columns() {
                    if !survey.requests.contains(&name) {
                        survey.requests.push(name);
                    }
                }
                let Some(record) = record else { continue };
                survey.elements.add(record);
                survey.interiors.add(record);
                survey.estimates.add(record);
                survey.failures.add(record, MOST_FAILURES);
                survey.has_files |= has_file(record);
            }
            if rows.len() < most {
                rows.extend(block.rows(&columns));
                rows.truncate(most);
            }
            Ok::<bool, AnswerError>(true)
        })?;
        survey.table = DataTable::new(heads(&columns), rows)?;
        Ok(survey)
    }

    /// Returns the doubts about the certified results.
    pub(crate) fn warnings(&self) -> Vec<Warning> {
        let mut warnings = self.elements.warnings();
        warnings.extend(self.interiors.warning());
        warnings.extend(self.estimates.warnings());
        warnings
    }

    /// Returns the rows of a study with some columns: those that were kept, else they are read
    /// again. Of a study that makes no figure there are the first rows.
    pub(crate) fn table(
        &self,
        study: &Study,
        source: &dyn Records,
        columns: Vec<Column>,
    ) -> Result<DataTable, AnswerError> {
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_ref()).collect();
        if names.iter().all(|name| self.table.column(name).is_ok()) {
            return Ok(self.table.select(&names)?);
        }
        let mut rows = Vec::new();
        visit(study, source, POINTS_AT_ONCE, &mut |block| {
            rows.extend(block.rows(&columns));
            Ok::<bool, AnswerError>(true)
        })?;
        Ok(DataTable::new(heads(&columns), rows)?)
    }
}

/// Returns whether a column is kept for summaries and figures.
fn is_shown(study: &Study, column: &Column) -> bool {
    let name = column.name.as_ref();
    let figures = study.figures().iter().chain(study.suggestions());
    let is_drawn = |figure: &Figure| {
        let apart = figure.series.iter().chain(&figure.panels).chain(&figure.names);
        let filter = figure.filtered(None);
        let mut names = apart.chain([&figure.x]).chain(figure.shown());
        names.any(|shown| shown == name) || filter.is_some_and(|filter| filter.contains(name))
    };
    column.role == Role::Axis
        || name == "status"
        || study.kind().usual_columns().contains(&name)
        || figures.clone().any(is_drawn)
}
