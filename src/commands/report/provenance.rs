//! The origin of the results of a report: the runs, their machines, their command lines.

use answers::{ComputingRun, Results};
use anyhow::Result;
use report::{Cell, DataTable, PageBlock, PageSection, TableColumn};
use study::account::{HashedFile, RunAccount, run_name};
use study::job::PHYSICS_VERSION;

use super::rows::JobRows;
use super::run_shares::{RunShare, RunShares};
use crate::account::{command_words, file_words};
use crate::words::{count, time_words};

/// The most runs whose command lines a page has; a study of many shards, each started several
/// times, has hundreds.
const MOST_COMMANDS: usize = 24;

/// Says which runs computed the results, where, when and by which commands, as far as the records
/// name them.
pub(super) fn section(results: &Results<'_>, rows: &JobRows<'_>) -> Result<PageSection> {
    let shares = &rows.standings.shares;
    let runs = shares.runs(results);
    let mut blocks = Vec::new();
    if runs.is_empty() {
        blocks.push(PageBlock::Words("There is no result yet.".to_owned()));
    } else {
        blocks.push(PageBlock::Table(table(&runs, shares)?));
        blocks.push(PageBlock::Words(
            "A run is called by the first digits of its account's digest. Versions, workers and \
             times are those that the records hold; times are UTC. A commit that ends in -dirty had \
             changes when the program was built. The run, the worker and the time of each job are \
             columns of the table of jobs."
                .to_owned(),
        ));
        blocks.extend(commands(&runs));
        blocks.extend(files(&runs));
    }
    Ok(PageSection { id: "provenance", title: "Provenance", blocks })
}

fn table(runs: &[ComputingRun<'_>], shares: &RunShares) -> Result<DataTable> {
    let names = [
        "run",
        "jobs",
        "program",
        "commit",
        "physics",
        "host",
        "processor",
        "cores",
        "system",
        "workers",
        "first finished",
        "last finished",
    ];
    let listed = |parts: Vec<String>| parts.join(", ");
    let none = RunShare::default();
    let line = |run: &ComputingRun<'_>| -> Vec<Cell> {
        let share = shares.of_run(run.digest).unwrap_or(&none);
        let machine = run.account.map(|account| &account.machine);
        let commit = run.account.and_then(|account| account.program.short_commit());
        let unknown = || "unknown".to_owned();
        let of_machine = |text: fn(&RunAccount) -> String| run.account.map_or_else(unknown, text);
        let [first, last] = share.finished.clone().unwrap_or_default();
        let texts = [
            run.digest.as_ref().map_or_else(|| "not named".to_owned(), run_name),
            share.jobs.to_string(),
            listed(share.programs.iter().cloned().collect()),
            commit.unwrap_or_else(unknown),
            // The keys of the jobs are those of this physics.
            PHYSICS_VERSION.to_string(),
            of_machine(|account| account.machine.host.clone()),
            of_machine(|account| account.machine.processor.clone()),
            machine.map_or_else(unknown, |machine| machine.cores.to_string()),
            of_machine(|account| account.machine.system.clone()),
            share.workers.len().to_string(),
            first,
            last,
        ];
        texts.into_iter().map(Cell::Text).collect()
    };
    let lines = runs.iter().map(line).collect();
    Ok(DataTable::new(names.map(|name| TableColumn::new(name, "")).to_vec(), lines)?)
}

/// Lists the command lines of the runs, and says of how many there are none.
fn commands(runs: &[ComputingRun<'_>]) -> Vec<PageBlock> {
    let mut blocks = Vec::new();
    let known = || runs.iter().filter_map(|run| Some((run, run.account?)));
    for (run, account) in known().take(MOST_COMMANDS) {
        let name = run.digest.as_ref().map_or_else(String::new, run_name);
        let jobs = count(run.records, "job", "jobs");
        let began = time_words(account.started);
        blocks.push(PageBlock::Words(format!("Run {name}, {jobs}, began at {began}:")));
        blocks.push(PageBlock::Command(command_words(&account.command)));
    }
    let left_out = known().count().saturating_sub(MOST_COMMANDS);
    if left_out > 0 {
        blocks.push(PageBlock::Words(format!("{left_out} more runs are left out here.")));
    }
    let unknown: usize =
        runs.iter().filter(|run| run.account.is_none()).map(|run| run.records).sum();
    if unknown > 0 {
        blocks.push(PageBlock::Words(format!(
            "Of {} the run is not known: an earlier version of the program computed them, or the \
             file with the account of the run is lost.",
            count(unknown, "job", "jobs")
        )));
    }
    blocks
}

/// Lists the files that the runs have read, with their digests.
fn files(runs: &[ComputingRun<'_>]) -> Vec<PageBlock> {
    let mut lines: Vec<String> = Vec::new();
    let mut add = |line: String| {
        if !lines.contains(&line) {
            lines.push(line);
        }
    };
    for account in runs.iter().filter_map(|run| run.account) {
        let study = &account.study;
        let read: Vec<&HashedFile> = study.file.iter().chain(&study.files).collect();
        read.into_iter().for_each(|file| add(file_words(file)));
        add(format!("definition of the study {}, blake3 {}", study.name, study.definition));
    }
    if lines.is_empty() {
        return Vec::new();
    }
    vec![
        PageBlock::Heading("What the runs have read".to_owned()),
        PageBlock::Source(lines.join("\n")),
    ]
}
