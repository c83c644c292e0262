//! The words that a store keeps about a study: how far it is, and what a run would say of it. They
//! stand in for the records as long as nothing has changed.

use std::path::{Path, PathBuf};

use answers::{AnswerError, AnswerTable, Progress, Results, Warning};
use report::DataTable;
use serde::{Deserialize, Serialize};
use store::{Digest, Glance, KeptWords, Store};
use study::job::PHYSICS_VERSION;
use study::{Adaptive, Study};

use crate::machine::build_words;

/// The version of the form of the words.
const FORM: u32 = 1;

/// The words about a study.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(crate) struct KeptStudy {
    form: u32,
    /// The build of the program that wrote the words. Another one may say something else.
    program: String,
    physics: u32,
    /// The digest of the definition of the study.
    definition: [u8; 32],
    question: String,
    /// The numbers of points: all, solved, failed, left, and left out by conditions.
    points: [usize; 5],
    inaccurate: usize,
    /// The facts that a run tells which finds nothing to do; `None` of a study that every run has
    /// to examine.
    facts: Option<SummaryFacts>,
}

/// The facts that are told of a study at the end of a run.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(crate) struct SummaryFacts {
    pub(crate) study: String,
    pub(crate) is_adaptive: bool,
    /// The number of distinct jobs.
    pub(crate) jobs: usize,
    points: [usize; 5],
    pub(crate) inaccurate: usize,
    /// The first rows.
    pub(crate) rows: DataTable,
    /// The number of further rows.
    pub(crate) more_rows: usize,
    pub(crate) answers: Vec<AnswerTable>,
    /// The figures, or why each was not drawn.
    pub(crate) figures: Vec<Result<DrawnFigure, String>>,
    pub(crate) warnings: Vec<Warning>,
    /// The jobs that have ended without a solution; of very many the first.
    pub(crate) failures: Vec<ShownFailure>,
    /// The number of all these.
    pub(crate) failed_jobs: usize,
}

/// A figure that was drawn.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(crate) struct DrawnFigure {
    /// The names of its files in the folder of figures, each with the digest of its content.
    pub(crate) files: Vec<(PathBuf, [u8; 32])>,
    /// The sentence about points that are missing, if some are.
    pub(crate) missing: Option<String>,
}

/// A job that has ended without a solution, as it is shown.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(crate) struct ShownFailure {
    pub(crate) key: String,
    pub(crate) status: String,
    /// The reason, if it left one.
    pub(crate) reason: Option<String>,
}

fn counts(progress: &Progress) -> [usize; 5] {
    let Progress { points, done, failed, left, excluded } = *progress;
    [points, done, failed, left, excluded]
}

fn progress([points, done, failed, left, excluded]: [usize; 5]) -> Progress {
    Progress { points, done, failed, left, excluded }
}

impl SummaryFacts {
    /// Returns the facts of a study beside those of its rows, answers and figures.
    pub(crate) fn of(
        results: &Results<'_>,
        jobs: usize,
        rows: DataTable,
        more_rows: usize,
    ) -> Result<Self, AnswerError> {
        let failures = results.failures()?;
        let shown = failures.listed.into_iter().map(|failure| ShownFailure {
            key: failure.key.to_string(),
            status: failure.standing.to_string(),
            reason: failure.reason,
        });
        Ok(SummaryFacts {
            study: results.study().name().to_owned(),
            is_adaptive: results.study().adaptive().is_some(),
            jobs,
            points: counts(&results.progress()),
            inaccurate: results.inaccurate(),
            rows,
            more_rows,
            answers: Vec::new(),
            figures: Vec::new(),
            warnings: results.warnings(),
            failures: shown.collect(),
            failed_jobs: failures.count,
        })
    }

    /// Returns how far the study is.
    pub(crate) fn progress(&self) -> Progress {
        progress(self.points)
    }

    /// Returns whether the figures stand in a folder as they were drawn.
    fn has_figures(&self, folder: &Path) -> bool {
        let mut files = self.figures.iter().flatten().flat_map(|figure| &figure.files);
        files.all(|(name, digest)| {
            std::fs::read(folder.join(name)).is_ok_and(|bytes| Digest::of(&bytes).0 == *digest)
        })
    }
}

impl KeptStudy {
    /// Returns the words about a study with these results, of which `facts` are to be said.
    pub(crate) fn of(results: &Results<'_>, facts: SummaryFacts) -> Self {
        let study = results.study();
        // What is in files is read and verified by every run.
        let is_known = facts.progress().left == 0 && !results.has_files();
        KeptStudy {
            form: FORM,
            program: build_words(),
            physics: PHYSICS_VERSION,
            definition: Digest::of(&study.definition()).0,
            question: study.question().to_owned(),
            points: facts.points,
            inaccurate: facts.inaccurate,
            facts: is_known.then_some(facts),
        }
    }

    /// Keeps the words in a store.
    pub(crate) fn keep(&self, store: &Store, study: &Study) {
        // Any study may leave what teaches one that chooses its meshes.
        let is_taught = matches!(study.adaptive(), Some(Adaptive::Accuracy(_)));
        let is_final = self.progress().left == 0 && !is_taught;
        if let Ok(words) = bincode::serde::encode_to_vec(self, bincode::config::standard()) {
            store.keep_words(study.name(), KeptWords { words, is_final });
        }
    }

    /// Returns the words about the study with a name, if they hold and this program wrote them.
    pub(crate) fn at_a_glance(glance: &Glance, name: &str) -> Option<KeptStudy> {
        let words = glance.words(name)?;
        let (kept, _): (KeptStudy, usize) =
            bincode::serde::decode_from_slice(words, bincode::config::standard()).ok()?;
        let is_meant = kept.form == FORM
            && kept.program == build_words()
            && kept.physics == PHYSICS_VERSION
            && glance.definition(name)?.0 == kept.definition;
        is_meant.then_some(kept)
    }

    /// Returns whether the words are about this very study, with the files that it names.
    pub(crate) fn is_about(&self, study: &Study) -> bool {
        Digest::of(&study.definition()).0 == self.definition
    }

    /// Returns how far the study is.
    pub(crate) fn progress(&self) -> Progress {
        progress(self.points)
    }

    /// Returns the number of points whose accuracy was asked for and not reached.
    pub(crate) fn inaccurate(&self) -> usize {
        self.inaccurate
    }

    /// Returns the question of the study.
    pub(crate) fn question(&self) -> &str {
        &self.question
    }

    /// Returns what is to be said by a run that finds nothing to do, if its figures are still as
    /// they were drawn.
    pub(crate) fn into_facts(self, figures: &Path) -> Option<SummaryFacts> {
        self.facts.filter(|facts| facts.has_figures(figures))
    }
}
