//! The shares that runs have in the results of a report.

use std::collections::{BTreeSet, HashMap, HashSet};

use answers::{ComputingRun, Results};
use report::Cell;
use study::account::run_name;

use crate::words::time_words;

/// The results of one run, by all versions of the program.
#[derive(Default)]
pub(super) struct RunShare {
    pub(super) jobs: usize,
    pub(super) workers: HashSet<i64>,
    pub(super) programs: BTreeSet<String>,
    /// The times of the first and the last result, UTC, in the order of time as in that of texts.
    pub(super) finished: Option<[String; 2]>,
}

impl RunShare {
    /// Adds the result of a row with the cells of the worker, the program and the time.
    fn add(&mut self, [worker, program, finished]: [&Cell; 3]) {
        self.jobs += 1;
        if let Cell::Integer(worker) = worker {
            self.workers.insert(*worker);
        }
        if let Cell::Text(program) = program
            && !self.programs.contains(program)
        {
            self.programs.insert(program.clone());
        }
        if let Cell::Text(time) = finished {
            match &mut self.finished {
                Some([first, _]) if time < first => first.clone_from(time),
                Some([_, last]) if time > last => last.clone_from(time),
                Some(_) => {}
                None => self.finished = Some([time.clone(), time.clone()]),
            }
        }
    }
}

/// The results by the runs that computed them.
pub(super) struct RunShares {
    /// The digests of the runs by their names.
    digests: HashMap<String, [u8; 32]>,
    shares: HashMap<Option<[u8; 32]>, RunShare>,
}

impl RunShares {
    /// The columns of a row that tell of them.
    pub(super) const COLUMNS: [&str; 4] = ["run", "worker", "program", "finished"];

    /// Returns those of no result.
    pub(super) fn of_none(results: &Results<'_>) -> Self {
        let accounts = results.accounts().listed();
        let digests = accounts.into_iter().map(|(digest, _)| (run_name(digest), *digest)).collect();
        Self { digests, shares: HashMap::new() }
    }

    /// Adds a result by its cells in the [columns](RunShares::COLUMNS).
    pub(super) fn add(&mut self, cells: [&Cell; 4]) {
        let [run, rest @ ..] = cells;
        let run = if let Cell::Text(run) = run { self.digests.get(run).copied() } else { None };
        self.shares.entry(run).or_default().add(rest);
    }

    /// Returns the share of a run.
    pub(super) fn of_run(&self, run: Option<[u8; 32]>) -> Option<&RunShare> {
        self.shares.get(&run)
    }

    /// Lists the runs, each with the number of its results.
    pub(super) fn runs<'a>(&self, results: &'a Results<'_>) -> Vec<ComputingRun<'a>> {
        results.accounts().counted(self.shares.iter().map(|(run, share)| (*run, share.jobs)))
    }

    /// Returns the time of the last result of a run, or of all, in words.
    pub(super) fn last_finished(&self, run: Option<&[u8; 32]>) -> String {
        let of_run =
            self.shares.iter().filter(|(digest, _)| run.is_none() || digest.as_ref() == run);
        let last = of_run.filter_map(|(_, share)| share.finished.as_ref().map(|[_, last]| last));
        last.max().cloned().unwrap_or_else(|| time_words(0))
    }
}
