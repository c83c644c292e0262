//! A study with what its jobs have left: rows of tables, and the answers beyond them.

use std::cell::OnceCell;
use std::collections::HashSet;

use report::{Cell, DataTable, TableColumn, TableError};
use study::columns::{Compared, Role, Row, along_path, find};
use study::{Adaptive, Column, Figure, Kind, Record, Study, StudyPoint};

use crate::accounts::{Accounts, ComputingRun};
use crate::block::{POINTS_AT_ONCE, ResultBlock, visit};
use crate::choice::{self, Discovery, Finding, Gathered, PointChoice, gather};
use crate::comparison::{AnswerTable, Comparison};
use crate::error::AnswerError;
use crate::evidence::Evidence;
use crate::kind::answers_of;
use crate::path::path_columns;
use crate::progress::{Failures, Progress};
use crate::records::{RecordMap, Records};
use crate::rows::{heads, increments, row};
use crate::survey::{Survey, Surveyor, has_file, usual_names};
use crate::tabled::{RowKeeper, SurveyNotes, TabledRows, tabled_columns};
use crate::undrawn::{IS_CERTIFIED, Undrawn, only_certified};
use crate::variation::{FigureRanges, answering_figures, columns_of, first_varying, noise};
use crate::warnings::{RequiredError, Subject, Warning, of_elements, of_estimates, of_interiors};

mod parts;

/// The number of points above which the results of a plain study are read in blocks.
pub const POINTS_IN_MEMORY: usize = 16_384;

/// The points of a study, with the records that their jobs have left.
pub struct Results<'r> {
    study: Study,
    held: HeldResults<'r>,
    findings: Vec<Finding>,
    source: &'r dyn Records,
    /// The comparison of the points, made when it is first asked for: it reads the fields of many
    /// records.
    comparison: OnceCell<Comparison>,
    /// The figures, chosen when they are first asked for.
    figures: OnceCell<Vec<Figure>>,
    /// The accounts of the runs, read when they are first asked for.
    accounts: OnceCell<Accounts>,
}

/// The points and records of a study as far as they are in memory.
enum HeldResults<'r> {
    /// All of them.
    Whole { points: Vec<StudyPoint>, records: RecordMap },
    /// None of them: they were surveyed, block by block.
    Survey(Box<Survey<'r>>),
}

/// The rows that a figure is drawn from, and the points that are missing among them.
pub struct FigureRows {
    /// The rows; where a point has no certified result, the columns along y are empty.
    pub table: DataTable,
    /// The points that are not drawn.
    pub undrawn: Undrawn,
}

impl<'r> Results<'r> {
    /// Reads what a study's jobs have left. Points are not compared until that is asked for.
    ///
    /// # Errors
    /// A record cannot be read, or a condition cannot be evaluated.
    pub fn read(study: Study, source: &'r dyn Records) -> Result<Self, AnswerError> {
        let Gathered { choice: PointChoice { points, findings, .. }, records } =
            gather(&study, source)?;
        let held = HeldResults::Whole { points, records };
        Ok(Self::holding(study, held, findings, source))
    }

    /// Reads what a study's jobs have left like [`read`](Results::read), but keeps neither points
    /// nor records of a large study whose points are compared with nothing: these are read in
    /// blocks, of which one is in memory at a time.
    ///
    /// # Errors
    /// Those of [`read`](Results::read).
    pub fn in_blocks(study: Study, source: &'r dyn Records) -> Result<Self, AnswerError> {
        Self::in_blocks_above(POINTS_IN_MEMORY, study, source)
    }

    /// Reads results like [`in_blocks`](Results::in_blocks), with another number of points above
    /// which they are read in blocks.
    ///
    /// # Errors
    /// Those of [`read`](Results::read).
    pub fn in_blocks_above(
        most: usize,
        study: Study,
        source: &'r dyn Records,
    ) -> Result<Self, AnswerError> {
        if !study.has_independent_points() || study.point_count() <= most {
            return Self::read(study, source);
        }
        let survey = Box::new(Survey::of(&study, source)?);
        Ok(Self::holding(study, HeldResults::Survey(survey), Vec::new(), source))
    }

    /// Takes a table of a study whose points are compared with nothing for its results, with what
    /// was noted of them when it was made. What the table does not have is read from `source`.
    pub fn of_table(
        study: Study,
        notes: SurveyNotes,
        table: &'r dyn TabledRows,
        source: &'r dyn Records,
    ) -> Self {
        let survey = Box::new(Survey::of_table(notes, table));
        Self::holding(study, HeldResults::Survey(survey), Vec::new(), source)
    }

    fn holding(
        study: Study,
        held: HeldResults<'r>,
        findings: Vec<Finding>,
        source: &'r dyn Records,
    ) -> Self {
        Self {
            study,
            held,
            findings,
            source,
            comparison: OnceCell::new(),
            figures: OnceCell::new(),
            accounts: OnceCell::new(),
        }
    }

    /// Returns the study.
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// Returns the points of the study as far as its results determine them; none of a study that
    /// was read [in blocks](Results::in_blocks).
    pub fn points(&self) -> &[StudyPoint] {
        match &self.held {
            HeldResults::Whole { points, .. } => points,
            HeldResults::Survey(_) => &[],
        }
    }

    /// Returns the record of a point, if its job has left one; none of a study that was read [in
    /// blocks](Results::in_blocks).
    pub fn record(&self, point: &StudyPoint) -> Option<&Record> {
        self.records()?.get(&point.key)
    }

    fn records(&self) -> Option<&RecordMap> {
        match &self.held {
            HeldResults::Whole { records, .. } => Some(records),
            HeldResults::Survey(_) => None,
        }
    }

    /// Returns whether the fields of some record are in a file beside the records.
    pub fn has_files(&self) -> bool {
        match &self.held {
            HeldResults::Whole { .. } => self.of_points().any(has_file),
            HeldResults::Survey(survey) => survey.notes.has_files,
        }
    }

    /// Returns the jobs that have ended without a solution.
    ///
    /// # Errors
    /// They are not known yet, and a record cannot be read.
    pub fn failures(&self) -> Result<Failures, AnswerError> {
        if let HeldResults::Survey(survey) = &self.held {
            return survey.failures(&self.study, self.source);
        }
        let mut failures = Failures::default();
        self.of_points().for_each(|record| failures.add(record, usize::MAX));
        Ok(failures)
    }

    /// Returns the accounts of the runs that computed the results.
    pub fn accounts(&self) -> &Accounts {
        self.accounts.get_or_init(|| {
            if let HeldResults::Survey(survey) = &self.held {
                return survey.accounts();
            }
            let mut accounts = Accounts::default();
            accounts.read(self.records().into_iter().flat_map(RecordMap::values), self.source);
            accounts
        })
    }

    /// Lists the runs that computed the results, each with the number of its results.
    pub fn runs(&self) -> Vec<ComputingRun<'_>> {
        self.accounts().runs(self.of_points())
    }

    /// Iterates over the records of the points; one that several points share comes once.
    fn of_points(&self) -> impl Iterator<Item = &Record> {
        let mut seen = HashSet::new();
        let points = self.points().iter().filter(move |point| seen.insert(point.key));
        points.filter_map(|point| self.record(point))
    }

    /// Returns the input from which the row of a point is made.
    fn input<'a>(&'a self, point: &'a StudyPoint, compared: Option<&'a Compared>) -> Row<'a> {
        let record = self.record(point);
        let account = record.and_then(|record| self.accounts().of(record));
        Row { point, record, compared, account }
    }

    /// Returns how far the study is.
    pub fn progress(&self) -> Progress {
        match &self.held {
            HeldResults::Whole { points, records } => Progress::of(&self.study, points, records),
            HeldResults::Survey(survey) => survey.notes.progress(&self.study),
        }
    }

    /// Returns the number of points whose accuracy was asked for and not reached.
    pub fn inaccurate(&self) -> usize {
        let is_missed = |finding: &&Finding| matches!(finding.discovery, Discovery::Beyond { .. });
        self.findings.iter().filter(is_missed).count()
    }

    /// Returns the doubts about the certified results: counts of elements that should be 0, and
    /// errors of the mesh that are not estimated or large beside what the study asks. Studies that
    /// compare meshes have coarse ones on purpose, and their errors are in the answers.
    pub fn warnings(&self) -> Vec<Warning> {
        if let HeldResults::Survey(survey) = &self.held {
            return survey.notes.warnings.clone();
        }
        let of = |points: &[&StudyPoint]| {
            points.iter().filter_map(|point| self.record(point)).collect::<Vec<&Record>>()
        };
        let all: Vec<&StudyPoint> = self.points().iter().collect();
        let mut warnings = of_elements(&of(&all), Subject::Points);
        warnings.extend(of_interiors(&of(&all), Subject::Points));
        if !matches!(self.study.kind(), Kind::Solve | Kind::Sensitivity) {
            return warnings;
        }
        // Coarser meshes of a scene are steps on the way to the last.
        let is_last =
            |pair: &[&StudyPoint]| pair.get(1).is_none_or(|next| next.values != pair[0].values);
        let ends = match self.study.adaptive() {
            Some(Adaptive::Refine { on, until, .. }) => {
                let last = (0..all.len()).filter(|index| is_last(&all[*index..]));
                let ends: Vec<&StudyPoint> = last.map(|index| all[index]).collect();
                if let Some(limit) = RequiredError::of_column(on, *until) {
                    warnings.extend(of_estimates(&of(&ends), Subject::Points, &limit));
                }
                ends
            }
            Some(
                Adaptive::Accuracy(_)
                | Adaptive::Bisect { .. }
                | Adaptive::Find(_)
                | Adaptive::Fill(_)
                | Adaptive::Branch { .. },
            )
            | None => all,
        };
        let others = of_estimates(&of(&ends), Subject::Points, &RequiredError::LARGE);
        warnings.extend(
            others.into_iter().filter(|other| !warnings.contains(other)).collect::<Vec<_>>(),
        );
        warnings
    }

    /// Returns what the study says beyond its rows.
    ///
    /// # Errors
    /// The fields of a record that is compared cannot be read.
    pub fn answers(&self) -> Result<&[AnswerTable], AnswerError> {
        Ok(&self.comparison()?.answers)
    }

    /// Returns what the points of a sample say of some columns, by name.
    ///
    /// # Errors
    /// The study has no sample, or compares its points in another way; or there is no such column
    /// of numbers.
    pub fn about<S: AsRef<str>>(&self, names: &[S]) -> Result<Vec<AnswerTable>, AnswerError> {
        let kind = answers_of(self.study.kind());
        let about = kind.about.filter(|_| self.study.sample().is_some()).ok_or_else(|| {
            AnswerError::Refused(format!(
                "columns are described by the points of a sample, and the study `{}` {}",
                self.study.name(),
                match self.study.sample() {
                    None => "has no [sample]",
                    Some(_) => "compares its points in another way",
                }
            ))
        })?;
        let all = self.study.columns();
        let table = DataTable::new(heads(&all), Vec::new())?;
        let mut columns = Vec::new();
        for name in names {
            let column = &all[table.column(name.as_ref()).map_err(TableError::from)?];
            if !column.is_numeric() || column.unknown_in_choosing().is_some() {
                let message = format!("`{}` must be a number that each job leaves", column.name);
                return Err(AnswerError::Refused(message));
            }
            columns.push(column.clone());
        }
        self.evidence().map_or(Ok(Vec::new()), |evidence| about(&evidence, &columns))
    }

    /// Returns the influence of each key on the results of a figure that shows it: the name of each
    /// result with its table.
    ///
    /// # Errors
    /// The study is none of sensitivity, or there is no such column of numbers.
    pub fn influence(&self, figure: &Figure) -> Result<Vec<(String, DataTable)>, AnswerError> {
        let title = |name: &String| format!("sensitivity of {name}");
        let mut tables = Vec::new();
        for name in &figure.y {
            let is_table = |answer: &&AnswerTable| answer.title == title(name);
            let known = self.answers()?.iter().find(is_table).cloned();
            let found = match known {
                Some(known) => Some(known),
                None => self.about(&[name])?.iter().find(is_table).cloned(),
            };
            tables.extend(found.map(|answer| (name.clone(), answer.table)));
        }
        Ok(tables)
    }

    /// Returns the columns that the study of a sample is about: results of its figures, else the
    /// usual ones.
    fn columns_of_interest(&self) -> Result<Vec<Column>, AnswerError> {
        let all = self.study.columns();
        let named = |names: Vec<String>| -> Vec<Column> {
            let columns = names.iter().filter_map(|name| find(&all, name).cloned());
            columns.filter(Column::is_numeric).collect()
        };
        if self.study.sensitivity().is_some() {
            return Ok(named(self.study.results_of_interest()));
        }
        let of_figures =
            self.figures()?.iter().flat_map(|figure| figure.y.iter().chain([&figure.x]));
        let mut columns: Vec<Column> = Vec::new();
        for column in named(of_figures.cloned().collect()) {
            let is_known = columns.iter().any(|known| known.name == column.name);
            if column.role == Role::Observable && !is_known {
                columns.push(column);
            }
        }
        if columns.is_empty() {
            let usual = self.study.kind().usual_columns().iter();
            columns = named(usual.map(|name| (*name).to_owned()).collect());
        }
        Ok(columns)
    }

    /// Returns the points and records that are compared. Those of a study that is read in blocks
    /// are not.
    fn evidence(&self) -> Option<Evidence<'_>> {
        let HeldResults::Whole { points, records } = &self.held else { return None };
        Some(Evidence { study: &self.study, points, records, source: self.source })
    }

    /// Compares the points, or does without a comparison if it cannot be made, and returns why:
    /// what comes of it is missing from then on, and everything else can be had.
    pub fn forgone_comparison(&self) -> Option<AnswerError> {
        let error = self.comparison().err()?;
        self.comparison.get_or_init(Comparison::default);
        Some(error)
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
        self.first_rows(mentions, usize::MAX)
    }

    /// Returns the first `most` rows of the [table](Results::table).
    fn first_rows<S: AsRef<str>>(
        &self,
        mentions: &[S],
        most: usize,
    ) -> Result<DataTable, AnswerError> {
        let columns = self.study.columns();
        let is_mentioned =
            |name: &str| mentions.iter().any(|mention| mention.as_ref().contains(name));
        let takes_comparison =
            columns.iter().any(|column| column.is_compared() && is_mentioned(&column.name));
        let compared = if takes_comparison { &self.comparison()?.compared[..] } else { &[] };
        if let HeldResults::Survey(survey) = &self.held {
            // A name stands for itself, and a condition for all the names that occur in it.
            let is_name = |mention: &str| columns.iter().any(|column| column.name == mention);
            let is_meant = |column: &&Column| {
                mentions.iter().map(AsRef::as_ref).any(|mention| {
                    column.name == mention || !is_name(mention) && mention.contains(&*column.name)
                })
            };
            let meant = columns.iter().filter(is_meant).cloned().collect();
            return survey.table(&self.study, self.source, meant, most);
        }
        let rows = self.points().iter().take(most).enumerate().map(|(index, point)| {
            let compared = compared.get(index).and_then(Option::as_ref);
            row(&columns, &self.input(point, compared))
        });
        Ok(DataTable::new(heads(&columns), rows.collect())?)
    }

    /// Returns every column of every increment that was computed.
    ///
    /// # Errors
    /// Two columns share a name.
    pub fn increments(&self) -> Result<DataTable, AnswerError> {
        let columns = along_path(self.study.columns());
        if let HeldResults::Survey(_) = &self.held {
            let table = DataTable::new(heads(&columns), Vec::new())?;
            let mut blocks = Vec::new();
            visit(&self.study, self.source, POINTS_AT_ONCE, &mut |block| {
                blocks.push(increments(&columns, block.accounts, block.computed())?);
                Ok::<bool, AnswerError>(true)
            })?;
            return Ok(blocks.into_iter().fold(table, DataTable::followed_by));
        }
        let computed = self.points().iter().filter_map(|point| Some((point, self.record(point)?)));
        increments(&columns, self.accounts(), computed)
    }

    /// Gives the rows of all points to a keeper, unless they were read [in
    /// blocks](Results::in_blocks).
    pub fn keep_rows(&self, keeper: &dyn RowKeeper) {
        let HeldResults::Whole { points, records } = &self.held else { return };
        let (columns, accounts) = (tabled_columns(&self.study), self.accounts());
        keeper.begin(&columns);
        let block = ResultBlock { points, records, accounts };
        block.keep(&columns, keeper);
        let notes = Surveyor::of(&self.study).and_then(|mut surveyor| {
            surveyor.add(&block).ok()?;
            surveyor.notes().ok()
        });
        keeper.end(accounts, notes.as_ref());
    }

    /// Returns the usual columns of the first `most` points.
    ///
    /// # Errors
    /// The fields of a record that is compared cannot be read.
    pub fn usual_table(&self, most: usize) -> Result<DataTable, AnswerError> {
        let names = self.usual_columns(false)?;
        Ok(self.first_rows(&names, most)?.select(&names)?)
    }

    /// Returns the figures that answer the study's question: those of its file, else the first of
    /// the suggested ones that shows something that varies along its abscissa. There is none if
    /// nothing does, or if there are too many points.
    ///
    /// # Errors
    /// The fields of a record that is compared cannot be read.
    pub fn figures(&self) -> Result<&[Figure], AnswerError> {
        if let Some(figures) = self.figures.get() {
            return Ok(figures);
        }
        if let HeldResults::Survey(survey) = &self.held {
            match &survey.figures {
                _ if !self.study.is_listed() => return Ok(&[]),
                Some(figures) => return Ok(figures),
                None => {}
            }
        }
        let figures = answering_figures(&self.study, |suggestions| self.varying(suggestions))?;
        Ok(self.figures.get_or_init(|| figures))
    }

    /// Returns the first of some figures that shows something that varies, without columns that do
    /// not; the first of all as long as no curve has two points.
    fn varying(&self, suggestions: &[Figure]) -> Result<Option<Figure>, AnswerError> {
        let table = self.table(&columns_of(suggestions))?.filter(IS_CERTIFIED)?;
        let noise = match &self.held {
            HeldResults::Whole { points, .. } => noise(points),
            HeldResults::Survey(survey) => survey.notes.noise,
        };
        let mut ranges: Vec<FigureRanges<'_>> = suggestions.iter().map(FigureRanges::of).collect();
        ranges.iter_mut().try_for_each(|ranges| ranges.add(&table))?;
        Ok(first_varying(&ranges, noise))
    }

    /// Returns the rows that a figure is drawn from, those for which `filter` holds: the points, or
    /// their increments. A point without a certified result is no point of a curve: its columns
    /// along y are empty. The increment at which a path has failed is not among the rows.
    ///
    /// # Errors
    /// The filter cannot be evaluated, or the fields of a record that is compared cannot be read.
    pub fn figure_rows(
        &self,
        figure: &Figure,
        filter: Option<&str>,
    ) -> Result<FigureRows, AnswerError> {
        let undrawn = self.undrawn(figure, filter)?;
        let filter = figure.filtered(filter);
        let filter = filter.as_deref();
        let Figure { x, series, panels, names, .. } = figure;
        let drawn = || figure.shown();
        let table = if figure.steps {
            self.increments()?.filter(IS_CERTIFIED)?
        } else {
            if let HeldResults::Survey(_) = &self.held {
                // Of these rows only some columns are made, and all are told from.
                let all = DataTable::new(heads(&self.study.columns()), Vec::new())?;
                let apart = series.iter().chain(panels).chain(names);
                for name in [x].into_iter().chain(drawn()).chain(apart).filter(|n| !n.is_empty()) {
                    all.column(name).map_err(TableError::from)?;
                }
            }
            let columns = [x].into_iter().chain(series).chain(panels).chain(names);
            let columns = columns.chain(drawn()).map(String::as_str).chain(["status"]);
            self.table(&columns.chain(filter).collect::<Vec<_>>())?
        };
        let table = match filter {
            Some(expression) => table.filter(expression)?,
            None => table,
        };
        Ok(FigureRows { table: only_certified(&table, drawn())?, undrawn })
    }

    /// Counts the points without a certified result that a figure of the rows for which `filter`
    /// holds would show. Where the filter asks for a result, it may hold.
    ///
    /// # Errors
    /// The filter cannot be evaluated.
    pub fn undrawn(&self, figure: &Figure, filter: Option<&str>) -> Result<Undrawn, AnswerError> {
        let filter = figure.filtered(filter);
        let Some(expression) = filter.as_deref() else {
            let Progress { points, failed, left, .. } = self.progress();
            return Ok(Undrawn { points, failed, left, steps: figure.steps });
        };
        let mut columns = self.study.columns();
        if figure.steps {
            columns = along_path(columns);
        }
        let table = match &self.held {
            HeldResults::Whole { points, .. } => {
                let rows = points.iter().map(|point| row(&columns, &self.input(point, None)));
                DataTable::new(heads(&columns), rows.collect())?
            }
            HeldResults::Survey(survey) => {
                // The names in the condition are checked against all columns.
                DataTable::new(heads(&columns), Vec::new())?.filter(expression)?;
                columns.retain(|column| {
                    column.name == "status" || expression.contains(column.name.as_ref())
                });
                survey.table(&self.study, self.source, columns, usize::MAX)?
            }
        };
        let table = table.filter_possible(expression)?;
        let count = |condition: &str| Ok::<_, AnswerError>(table.filter(condition)?.rows().len());
        Ok(Undrawn {
            points: table.rows().len(),
            failed: count("status == \"failed\" || status == \"quarantined\"")?,
            left: count("status == null")?,
            steps: figure.steps,
        })
    }

    /// Returns the columns that answer the question at a glance, of the points or of their
    /// increments (`steps`): the axes, those of the figures, the usual observables, and how it
    /// ended.
    ///
    /// # Errors
    /// The fields of a record that is compared cannot be read.
    pub fn usual_columns(&self, steps: bool) -> Result<Vec<String>, AnswerError> {
        let points = match &self.held {
            HeldResults::Whole { points, .. } => points,
            HeldResults::Survey(survey) => return Ok(survey.notes.usual_columns(steps).to_vec()),
        };
        let path = steps.then(|| path_columns(points));
        let requests: Vec<&str> =
            points.iter().flat_map(|point| point.job.asked_columns()).collect();
        Ok(usual_names(&self.study, self.figures()?, path, &requests))
    }

    fn comparison(&self) -> Result<&Comparison, AnswerError> {
        if let Some(comparison) = self.comparison.get() {
            return Ok(comparison);
        }
        let comparison = self.compare()?;
        Ok(self.comparison.get_or_init(|| comparison))
    }

    /// Says how many points a comparison leaves out since they have no certified result; nothing
    /// if all have, or if nothing is compared yet.
    fn missing(&self, comparison: &Comparison) -> Result<Option<AnswerTable>, AnswerError> {
        let Progress { points, failed, left, .. } = self.progress();
        if comparison.answers.is_empty() || failed + left == 0 || left == points {
            return Ok(None);
        }
        let sentence = format!(
            "this leaves out {} of {points} points: {failed} failed, {left} have no result yet",
            failed + left
        );
        let heads = vec![TableColumn::new("answer", "")];
        let table = DataTable::new(heads, vec![vec![Cell::Text(sentence)]])?;
        Ok(Some(AnswerTable { title: "missing".into(), table }))
    }

    fn compare(&self) -> Result<Comparison, AnswerError> {
        let Self { study, findings, .. } = self;
        let kind = answers_of(study.kind());
        let Some(evidence) = self.evidence() else { return Ok(Comparison::default()) };
        let mut comparison = (kind.compare)(&evidence)?;
        if let (Some(about), Some(_)) = (kind.about, study.sample()) {
            comparison.answers.extend(about(&evidence, &self.columns_of_interest()?)?);
        }
        comparison.answers.extend(self.missing(&comparison)?);
        if kind.tells_choice && !findings.is_empty() {
            let table = choice::table(study, findings)?;
            comparison.answers.insert(0, AnswerTable { title: "found".into(), table });
        }
        Ok(comparison)
    }
}
