//! The points of a study, their sheets and their jobs.

use std::borrow::Cow;

use rayon::prelude::*;

use contact::model::{Mesh, SceneError};

use super::{Study, of_sample};
use crate::adaptive::{Adaptive, check_branched};
use crate::assemble::locate;
use crate::axis::{self, Group, SweepAxis};
use crate::error::{Mistake, StudyError};
use crate::job::Job;
use crate::key::Key;
use crate::point::StudyPoint;
use crate::sheet::{Given, Setting, Sheet};
use crate::value::Value;

impl Study {
    /// Returns the `index`-th point; `None` from [`len`](Study::len) on. Points are in the order of
    /// the axes, the last group fastest.
    pub fn point(&self, index: usize) -> Option<StudyPoint> {
        let steps = (index < self.points).then(|| axis::steps(&self.groups, index))?;
        let job = self.job(&steps).ok()?;
        let values =
            self.groups.iter().zip(&steps).flat_map(|(group, step)| {
                group.choices(*step).map(|choice| choice.into_owned().shown)
            });
        Some(StudyPoint { values: values.collect(), key: job.key(), job })
    }

    /// Returns the `index`-th point with another mesh; `None` if that is no job.
    pub fn point_on_mesh(&self, index: usize, mesh: Mesh) -> Option<StudyPoint> {
        self.point_with(index, &[(Key::Mesh, Setting::Mesh(mesh))], |_| {})
    }

    /// Returns the `index`-th point with another mesh, solved to a tolerance unless the study gives
    /// one; `None` if that is no job.
    pub fn point_as_exact(&self, index: usize, mesh: Mesh, tolerance: f64) -> Option<StudyPoint> {
        let steps = (index < self.points).then(|| axis::steps(&self.groups, index))?;
        let settings =
            [(Key::Mesh, Setting::Mesh(mesh)), (Key::Tolerance, Setting::Number(tolerance))];
        let is_given = self.sheet(&steps).get(Key::Tolerance).is_some();
        self.point_with(index, if is_given { &settings[..1] } else { &settings }, |_| {})
    }

    /// Returns the `index`-th point with other values of some axes, each given by its index, which
    /// must be axes of numbers; `None` if that is no job.
    pub fn point_at(&self, index: usize, values: &[(usize, f64)]) -> Option<StudyPoint> {
        let setting = |(axis, value): &(usize, f64)| {
            Some((self.axes().nth(*axis)?.key()?, Setting::Number(*value)))
        };
        let settings: Vec<(Key, Setting)> = values.iter().map(setting).collect::<Option<_>>()?;
        self.point_with(index, &settings, |shown| {
            for (axis, value) in values {
                shown.get_mut(*axis).into_iter().for_each(|cell| *cell = Value::Number(*value));
            }
        })
    }

    /// Returns the `index`-th point with other values of the keys that the sample draws: those at
    /// some parts of their distributions, each above 0 and below 1. `None` if that is no job, or if
    /// the study has no sample.
    pub fn point_drawn(&self, index: usize, parts: &[f64]) -> Option<StudyPoint> {
        let steps = (index < self.points).then(|| axis::steps(&self.groups, index))?;
        let sample = self.groups.iter().position(|group| group.design.is_some())?;
        let (sheet, mistakes) = self.filled(&steps, Some(parts), &[]);
        if !mistakes.is_empty() {
            return None;
        }
        let job = self.assembled(&sheet).ok()?;
        let mut values = self.point(index)?.values;
        let before: usize = self.groups[..sample].iter().map(|group| group.axes.len()).sum();
        let drawn = self.groups[sample].drawn_values(parts);
        values.splice(before..before + drawn.len(), drawn);
        Some(StudyPoint { values, key: job.key(), job })
    }

    fn point_with(
        &self,
        index: usize,
        settings: &[(Key, Setting)],
        show: impl FnOnce(&mut Vec<Value>),
    ) -> Option<StudyPoint> {
        let StudyPoint { mut values, .. } = self.point(index)?;
        let (sheet, mistakes) = self.filled(&axis::steps(&self.groups, index), None, settings);
        if !mistakes.is_empty() {
            return None;
        }
        let job =
            self.kind.assemble(&self.kind_table, &sheet, &self.files.names, &self.places).ok()?;
        show(&mut values);
        Some(StudyPoint { values, key: job.key(), job })
    }

    /// Returns the error of the scene of the `index`-th point, at its place in the file.
    pub fn refuse(&self, index: usize, error: &SceneError) -> StudyError {
        let sheet = self.sheet(&axis::steps(&self.groups, index.min(self.points - 1)));
        let mut mistake = locate(error, &sheet, &self.places);
        let coordinates = self.coordinates(&axis::steps(&self.groups, index.min(self.points - 1)));
        if !coordinates.is_empty() {
            mistake.help = format!("it is so at {coordinates}");
        }
        StudyError::new(&self.path, &self.text, vec![mistake])
    }

    /// Returns the value of each axis at a point, in words.
    fn coordinates(&self, steps: &[usize]) -> String {
        let of_group = |(group, step): (&Group, &usize)| {
            let values = group.axes.iter().map(SweepAxis::column).zip(group.choices(*step));
            let words = values.map(|(column, choice)| format!("{column} = {}", choice.shown));
            words.collect::<Vec<_>>().join(", ")
        };
        self.groups.iter().zip(steps).map(of_group).collect::<Vec<_>>().join(", ")
    }

    /// Returns the job of the `index`-th point, without the values of its axes.
    ///
    /// # Errors
    /// The point makes no sense, at its place in the file.
    pub fn job_at(&self, index: usize) -> Result<Job, StudyError> {
        let steps = axis::steps(&self.groups, index.min(self.points - 1));
        self.job(&steps).map_err(|mistakes| {
            let sample = self.groups.iter().zip(&steps).find(|(group, _)| group.design.is_some());
            let located = mistakes.into_iter().map(|mistake| match sample {
                Some((_, step)) => of_sample(mistake, *step),
                None => mistake,
            });
            StudyError::new(&self.path, &self.text, located.collect())
        })
    }

    /// Returns what is wrong with a point whose sample is drawn at some parts of its distributions;
    /// `None` where the conditions leave it out.
    pub(crate) fn mistakes_drawn(&self, steps: &[usize], parts: &[f64]) -> Option<Vec<Mistake>> {
        let (sheet, mistakes) = self.filled(steps, Some(parts), &[]);
        if let Some(exclusion) = &self.exclusion
            && !exclusion
                .excludes(&self.groups, steps, &sheet)
                .is_ok_and(|decision| !decision.is_excluded)
        {
            return None;
        }
        match mistakes.is_empty() {
            true => Some(self.assembled(&sheet).err().unwrap_or_default()),
            false => Some(mistakes),
        }
    }

    /// Returns every point of the axes, or of this part of them, in order. Points whose jobs
    /// coincide are all there.
    pub fn points(&self) -> Vec<StudyPoint> {
        self.points_of(self.indices().collect())
    }

    /// Iterates over the points that [`points`](Study::points) returns, in blocks of at most so
    /// many, and of one at least. Only one block is in memory at a time.
    pub fn point_blocks(&self, at_once: usize) -> impl Iterator<Item = Vec<StudyPoint>> + '_ {
        let mut indices = self.indices();
        std::iter::from_fn(move || {
            let block: Vec<usize> = indices.by_ref().take(at_once.max(1)).collect();
            (!block.is_empty()).then(|| self.points_of(block))
        })
    }

    /// Makes the points with some indices.
    fn points_of(&self, indices: Vec<usize>) -> Vec<StudyPoint> {
        indices.into_par_iter().filter_map(|index| self.point(index)).collect()
    }

    /// Returns the sheet of a point, without what cannot be derived there.
    pub(crate) fn sheet(&self, steps: &[usize]) -> Sheet<'_> {
        self.filled(steps, None, &[]).0
    }

    /// Returns the sheet of a point and why keys cannot be derived there. The sample may be drawn
    /// at some `parts` of its distributions in place of those of its step, and some `settings`
    /// stand in place of the point's own. Keys are derived from all of these.
    pub(crate) fn filled(
        &self,
        steps: &[usize],
        parts: Option<&[f64]>,
        settings: &[(Key, Setting)],
    ) -> (Sheet<'_>, Vec<Mistake>) {
        let mut sheet = Sheet::new(self.base.iter().map(|(key, given)| (*key, given)));
        for (group, step) in self.groups.iter().zip(steps) {
            match parts {
                Some(parts) if group.design.is_some() => group.draw(parts, &mut sheet),
                _ => group.apply(*step, &mut sheet),
            }
        }
        for (key, setting) in settings {
            let given = Given { setting: setting.clone(), span: 0..0, nth: None };
            sheet.set(*key, Cow::Owned(given));
        }
        let is_set = |key: Key| settings.iter().any(|(other, _)| *other == key);
        let mistakes = self.derivation.apply(&mut sheet, is_set);
        (sheet, mistakes)
    }

    pub(crate) fn job(&self, steps: &[usize]) -> Result<Job, Vec<Mistake>> {
        let (sheet, mut mistakes) = self.filled(steps, None, &[]);
        if mistakes.is_empty() {
            match self.assembled(&sheet) {
                Ok(job) => return Ok(job),
                Err(found) => mistakes = found,
            }
        }
        let coordinates = self.coordinates(steps);
        let place = match coordinates.is_empty() {
            true => String::new(),
            false => format!("it is so at {coordinates}\n"),
        };
        let help = format!("{place}[[exclude]] leaves out points at which a formula means nothing");
        let located = mistakes.into_iter().map(|mistake| {
            match mistake.help.is_empty() && self.derivation.has_place(&mistake.span) {
                true => mistake.help(help.clone()),
                false => mistake,
            }
        });
        Err(located.collect())
    }

    /// Assembles the job of a sheet, which must suit the study's choice of points as well.
    pub(crate) fn assembled(&self, sheet: &Sheet<'_>) -> Result<Job, Vec<Mistake>> {
        let job = self.kind.assemble(&self.kind_table, sheet, &self.files.names, &self.places)?;
        if let Some(Adaptive::Accuracy(accuracy)) = &self.adaptive {
            accuracy.check(&job).map_err(|mistake| vec![mistake])?;
        }
        if let Some(Adaptive::Branch { .. }) = &self.adaptive {
            let located = |error| vec![locate(&error, sheet, &self.places)];
            check_branched(&job).map_err(located)?;
        }
        Ok(job)
    }
}
