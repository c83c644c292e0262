//! `solve`: one scene, in this process; nothing is stored.

use std::ffi::OsStr;

use anyhow::{Context, Result, bail};
use contact::Operators;
use study::edit::with_settings;
use study::{Adaptive, Kind, Study};

use crate::account::study_file;
use crate::cli::SolveArgs;
use crate::increments::PathJob;
use crate::one_result::UsedFiles;
use crate::output::{Finish, layout};
use crate::series::write_series;
use crate::solving::{SolvedScene, solve_scene};
use crate::study_file::{edit_study, parse_study, read_text};
use crate::threads::share_among;
use crate::{fields, one_result, output};

/// Solves the only scene of a study file and shows the result.
pub(crate) fn solve(args: &SolveArgs) -> Result<Finish> {
    share_among(0)?;
    let text = read_text(&args.scene)?;
    let study = single_scene(args, &text)?;
    fields::check_field(args.field.as_deref(), args.output.as_deref())?;
    if study.kind() != Kind::Multiplicity {
        fields::only_of_a_search(args.solution)?;
    }
    let mut operators = Operators::default();
    let file = Some(study_file(&args.scene, &text));
    let solution = solve_scene(&study, file, &mut operators)?;
    let is_good = solution.record.is_certified() && !solution.is_missed();
    show(args, &study, &solution)?;
    say_doubts(args, &study, &solution);
    // The process ends, and with it its memory: to hand back a gigabyte first would take a
    // hundredth of the time to solve for it.
    std::mem::forget(operators);
    Ok(if is_good { Finish::AllDone } else { Finish::SomeFailed })
}

/// Reads the study with its keys set, and refuses one of several points.
fn single_scene(args: &SolveArgs, text: &str) -> Result<Study> {
    let study = if args.set.is_empty() {
        parse_study(text, &args.scene)?
    } else {
        let edited = edit_study(with_settings, text, &args.scene, &args.set)?;
        parse_study(&edited, &args.scene)?
    };
    if study.len() != 1 {
        bail!(
            "{} describes {} points; fix its axes with --set KEY=VALUE ({}), or run them all with \
             `{}`",
            args.scene.display(),
            study.len(),
            study.axes().map(|axis| axis.path()).collect::<Vec<_>>().join(", "),
            run_command(args)
        );
    }
    Ok(study)
}

/// Returns the command that runs the study instead.
fn run_command(args: &SolveArgs) -> String {
    wording::command([OsStr::new("run"), &wording::file_argument(&args.scene)])
}

/// Shows the result in the form that the arguments ask for.
fn show(args: &SolveArgs, study: &Study, solution: &SolvedScene) -> Result<()> {
    let SolvedScene { record, fields, account, .. } = solution;
    let files = UsedFiles::of(study, &record.parse_job()?);
    if args.field.is_some() || args.output.is_some() {
        let (name, file) = (args.field.as_deref(), args.output.as_deref());
        if let Some(file) = file.filter(|_| fields::is_series(file)) {
            let (job, surfaces) = (record.parse_job()?, study.surfaces());
            write_series(&PathJob { job, surfaces, record: Some(record) }, name, file)?;
            return Ok(());
        }
        let of_search = record
            .multiplicity()
            .map(|found| fields::solution_fields(found, args.solution))
            .transpose()?;
        let fields = of_search.as_ref().or(fields.as_ref()).context("it has no fields")?;
        fields::show_field(fields, name, file)?;
    } else if args.json {
        output::print_json(&one_result::json(record, fields.as_ref(), &files, Some(account))?)?;
    } else {
        let mut text = one_result::words(record, fields.as_ref(), &files, Some(account))?;
        if record.outcome().is_some_and(|outcome| outcome.steps.len() > 1) {
            text += &format!("path\n{}", one_result::path(record)?.terminal(&layout()));
        }
        output::print(&text)?;
    }
    Ok(())
}

/// Says on standard error what is to be doubted in the result.
fn say_doubts(args: &SolveArgs, study: &Study, solution: &SolvedScene) {
    solution.doubts().iter().for_each(|doubt| output::say(doubt));
    let (state, rest) = match study.adaptive() {
        Some(Adaptive::Refine { .. }) => ("solved on the study's first mesh", "refines it"),
        Some(Adaptive::Branch { .. }) => ("bracketed by weights alone", "narrows the bracket"),
        _ => return,
    };
    output::say(&format!("{state}; `{}` {rest}", run_command(args)));
}
