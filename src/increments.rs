//! The path of a job, increment by increment. A record keeps the fields of the last increment, and
//! those of the others are found by solving the path again.

use std::ops::ControlFlow;

use answers::forecast;
use anyhow::{Context, Result, bail};
use contact::model::StepOutcome;
use contact::punch::Surfaces;
use contact::{Cancellation, Operators, SolvedIncrement, solve_watched};
use study::job::PHYSICS_VERSION;
use study::{Case, Job, Record};

use crate::solving::{require_memory, require_wanted};

/// A job whose path is solved.
pub(crate) struct PathJob<'a> {
    pub(crate) job: Job,
    pub(crate) surfaces: &'a Surfaces,
    /// The record that the path leads to, if the job is solved again.
    pub(crate) record: Option<&'a Record>,
}

impl PathJob<'_> {
    /// Returns the scene and its numerics.
    fn case(&self) -> Result<&Case> {
        match &self.job {
            Job::Solve(case) | Job::Cost { case, .. } => Ok(case),
            Job::Multiplicity { .. } => bail!(
                "a search for several solutions keeps the fields of its last increment only; solve \
                 its scene by a study of another kind"
            ),
            Job::Uniqueness { .. } | Job::Branch { .. } => {
                bail!("a study of uniqueness sets follows no loading path")
            }
        }
    }

    /// Returns the number of increments.
    ///
    /// # Errors
    /// The job follows no path, or its scene cannot be laid out on a grid.
    pub(crate) fn increments(&self) -> Result<u64> {
        self.case()?;
        Ok(forecast(&self.job, self.surfaces)?.increments)
    }

    /// Solves the path and shows its increments to `visit` one after the other, until it wants no
    /// more. Each is held against the record: its motion, observables and certificate are the same
    /// to the last digit.
    ///
    /// # Errors
    /// The job follows no path, it takes more memory than there is, the scene has no meaning, its
    /// record is of another physics, the visitor fails, or `cancellation` was requested.
    pub(crate) fn follow(
        &self,
        cancellation: &Cancellation,
        visit: &mut (dyn FnMut(&SolvedIncrement<'_>) -> Result<ControlFlow<()>> + Send),
    ) -> Result<()> {
        let Case { scene, numerics } = self.case()?;
        if let Some(record) = self.record.filter(|record| record.physics != PHYSICS_VERSION) {
            bail!(
                "the record is of version {} of the physics, and this program has version \
                 {PHYSICS_VERSION}: run its study again",
                record.physics
            );
        }
        require_memory(&self.job, self.surfaces)?;
        let mut seen = Ok(());
        let mut watch = |increment: &SolvedIncrement<'_>| match self
            .compare(increment)
            .and_then(|()| visit(increment))
        {
            Ok(whether) => whether,
            Err(error) => {
                seen = Err(error);
                ControlFlow::Break(())
            }
        };
        let mut operators = Operators::cancelled_by(cancellation);
        solve_watched(scene, numerics, self.surfaces, &mut operators, &mut watch)?;
        require_wanted(cancellation)?;
        seen
    }

    /// Refuses an increment that is another one in the record.
    fn compare(&self, increment: &SolvedIncrement<'_>) -> Result<()> {
        let Some(record) = self.record else { return Ok(()) };
        let outcome = record.outcome().context("the record has no path")?;
        let figures = |step: &StepOutcome| (step.motion, step.observables, step.certificate);
        let kept = outcome.steps.get(increment.number as usize - 1);
        if kept.map(figures) != Some(figures(increment.outcome)) {
            bail!(
                "increment {} is not the one that the record has: the path was solved by another \
                 build of the program or on another kind of processor; run its study again",
                increment.number
            );
        }
        Ok(())
    }
}
