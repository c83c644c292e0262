//! A study, which is one TOML file that reads like the question.
//!
//! ```toml
//! name = "stick-zone"
//! question = "How does the stick zone grow with friction?"
//!
//! [scene.foundation]
//! base = { shear_modulus = "80 GPa", poisson = 0.3 }
//! [scene.punch]
//! shape = "flat-disk"
//! radius = "1 mm"
//! [scene.friction]
//! mu = 0.3
//! [scene.loading]
//! steps = [{ approach = "1 um" }]
//!
//! [numerics]
//! mesh = 64
//!
//! [sweep]                     # see `axis`
//! "friction.mu" = { from = 0.05, to = 0.8, count = 16 }
//!
//! [figure]                    # see `figure`; also [[figure]], several times; without it a study
//!                             # has one of its own
//! x = "mu"
//! y = "stick_fraction"
//! ```
//!
//! Numbers are in SI units or texts with a unit. Everything that could be wrong is refused with its
//! place before anything runs.

use std::sync::Arc;

use rayon::prelude::*;

use contact::punch::Surfaces;

use crate::adaptive::Adaptive;
use crate::axis;
use crate::axis::{Group, MAX_POINTS, MAX_RUN_POINTS, MAX_SHARDS, PointLevels, SweepAxis};
use crate::columns::Column;
use crate::derivation::Derivation;
use crate::design::SamplingMethod;
use crate::error::{Mistake, StudyError};
use crate::exclusion::{Exclusion, HoldingCounts, PointDecision};
use crate::figure::Figure;
use crate::key::Key;
use crate::kind::convergence::Ladder;
use crate::kind::cost::{Cost, is_rung};
use crate::kind::sensitivity::{SensitivityMethod, named_results};
use crate::kind::{Kind, KindTable};
use crate::sheet::{Given, TablePlaces};
use crate::study_files::StudyFiles;
use crate::sweep::{self, too_many_entries};

mod points;

/// The largest number of points that are listed at a time.
pub const MOST_POINTS: usize = MAX_POINTS;

/// The largest number of points of one run.
pub const MOST_RUN_POINTS: usize = MAX_RUN_POINTS;

/// The largest number of shards in which a study is run.
pub const MOST_SHARDS: u32 = MAX_SHARDS;

/// A study of which every point makes sense.
#[derive(Clone, Debug)]
pub struct Study {
    pub(crate) name: String,
    pub(crate) question: String,
    pub(crate) kind: Kind,
    pub(crate) figures: Vec<Figure>,
    pub(crate) suggestions: Vec<Figure>,
    pub(crate) groups: Vec<Group>,
    pub(crate) adaptive: Option<Adaptive>,
    pub(crate) kind_table: KindTable,
    pub(crate) base: Vec<(Key, Given)>,
    pub(crate) derivation: Derivation,
    pub(crate) places: TablePlaces,
    pub(crate) points: usize,
    /// The indices of the points that this part of the study has, in ascending order; `None` for
    /// all that the axes make.
    pub(crate) part: Option<Arc<[usize]>>,
    /// The conditions by which points of the axes are left out.
    pub(crate) exclusion: Option<Exclusion>,
    /// The number of points that they leave out, of this part if it is one.
    pub(crate) excluded: usize,
    /// The remarks on what the file says without effect.
    pub(crate) remarks: Vec<String>,
    /// Every point is known to make sense.
    pub(crate) is_checked: bool,
    pub(crate) files: StudyFiles,
    pub(crate) path: String,
    pub(crate) text: String,
}

impl Study {
    /// Returns the name, which is fit for a file or a directory.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the question, which may be empty.
    pub fn question(&self) -> &str {
        &self.question
    }

    /// Returns the question that the study asks about its points.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Returns the figures that answer the question: those of the file, else the first of those
    /// that the axes suggest, if they do.
    pub fn figures(&self) -> &[Figure] {
        &self.figures
    }

    /// Returns the figures that the axes suggest for a study whose file has none, the preferred one
    /// first: each shows something that the scenes leave free. Only results tell what varies.
    pub fn suggestions(&self) -> &[Figure] {
        &self.suggestions
    }

    /// Returns the groups of axes, the fastest one last.
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Returns the axes of all groups, in order.
    pub fn axes(&self) -> impl Iterator<Item = &SweepAxis> {
        self.groups.iter().flat_map(Group::axes)
    }

    /// Returns the rule by which the study chooses points beyond those of its axes, if it does.
    pub fn adaptive(&self) -> Option<&Adaptive> {
        self.adaptive.as_ref()
    }

    /// Returns the ladder of a convergence study.
    pub fn ladder(&self) -> Option<Ladder> {
        (self.kind == Kind::Convergence).then(|| Ladder::of(&self.kind_table, &self.groups))?
    }

    /// Returns the measurement of a study of cost.
    pub fn cost(&self) -> Option<Cost> {
        (self.kind == Kind::Cost).then(|| Cost::of(&self.kind_table))
    }

    /// Returns the method of a study of sensitivity.
    pub fn sensitivity(&self) -> Option<SensitivityMethod> {
        (self.kind == Kind::Sensitivity).then(|| SensitivityMethod::of(&self.kind_table))
    }

    /// Returns the columns of the results that a study of sensitivity is about: those that it
    /// names, else those of its figures.
    pub fn results_of_interest(&self) -> Vec<String> {
        let named = named_results(&self.kind_table);
        let of_figures = self.figures.iter().flat_map(|figure| &figure.y);
        let mut results: Vec<String> = Vec::new();
        for name in named.iter().chain(of_figures.filter(|_| named.is_empty())) {
            if !results.contains(name) {
                results.push(name.clone());
            }
        }
        results
    }

    /// Returns the step of the sample at the point with an index; `None` without a sample.
    pub fn step_of_sample(&self, index: usize) -> Option<usize> {
        let sample = self.groups.iter().position(|group| group.design.is_some())?;
        axis::steps(&self.groups, index).get(sample).copied()
    }

    /// Returns every column of the study's results.
    pub fn columns(&self) -> Vec<Column> {
        self.kind.columns(
            self.axes(),
            axis::keys(&self.base, &self.groups).chain(self.derivation.keys()),
        )
    }

    /// Returns the surfaces that its jobs name.
    pub fn surfaces(&self) -> &Surfaces {
        &self.files.surfaces
    }

    /// Returns the names and bytes of the files that it has read.
    pub fn read_files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.files.bytes.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
    }

    /// Returns the text of the file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the path from which the text came.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Returns the number of points that the axes make, of which this may be a part. There is at
    /// least one, for a study without axes is its base.
    #[expect(clippy::len_without_is_empty, reason = "a study is never empty")]
    pub fn len(&self) -> usize {
        self.points
    }

    /// Returns the number of points that the conditions of the study leave out, of this part of it
    /// if it is one. It is 0 for a study that is too large to be listed, of which the parts tell.
    pub fn excluded(&self) -> usize {
        self.excluded
    }

    /// Returns whether the study has conditions that leave points out.
    pub fn has_conditions(&self) -> bool {
        self.exclusion.is_some()
    }

    /// Returns remarks on what the file says without effect, in sentences.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Returns the group whose axes a sample draws, if there is one.
    pub fn sample(&self) -> Option<&Group> {
        self.groups.iter().find(|group| group.design.is_some())
    }

    /// Refuses a sample that loses the points of the `former` study of the same name, from which it
    /// differs in its number of points: only some hypercubes keep the points of others.
    ///
    /// # Errors
    /// The points would be lost, at the place of their number in the file.
    pub fn require_kept_points(&self, former: &Study) -> Result<(), StudyError> {
        let (Some(sample), Some(other)) = (self.sample(), former.sample()) else { return Ok(()) };
        let (Some(design), Some(before)) = (&sample.design, &other.design) else { return Ok(()) };
        let drawn = |group: &Group| -> Vec<_> {
            group.axes.iter().map(|axis| (axis.key(), axis.distribution.clone())).collect()
        };
        let is_other = (design.method(), design.seed()) != (before.method(), before.seed())
            || design.arrangement() != before.arrangement()
            || drawn(sample) != drawn(other);
        if is_other || design.is_kept_by(before) || before.is_kept_by(design) {
            return Ok(());
        }
        let count = before.count();
        let message = format!(
            "{} of {} {} keeps none of the {count} that `{}` has in the store",
            design.method().noun(),
            design.count(),
            design.arrangement().noun(),
            self.name
        );
        let doubled = [2, 4].map(|factor| u64::from(count) * factor);
        let expected = format!("must be {}, {} and so on, to keep them", doubled[0], doubled[1]);
        let mistake = Mistake::new(sample.count.clone(), message, expected);
        let help = "a sample by another method grows by any number; a new sample needs another \
                    `name`, or another `seed`";
        Err(StudyError::new(&self.path, &self.text, vec![mistake.help(help)]))
    }

    /// Returns what is worth knowing about its sample, in words.
    pub fn sample_note(&self) -> Option<String> {
        let design = self.sample()?.design.as_ref()?;
        let count = design.count();
        let is_uneven = design.method() == SamplingMethod::Sobol && !count.is_power_of_two();
        is_uneven.then(|| {
            let below = 1_u32 << count.ilog2();
            let what = design.arrangement().noun();
            format!(
                "the {count} {what} of the sample are no power of two, where Sobol' points are \
                 most even: {below} or {}",
                2 * u64::from(below)
            )
        })
    }

    /// Returns the error of the condition of `[bisect]`, at its place in the file. The lines of
    /// `expected` after the first are advice.
    pub fn refuse_condition(&self, message: impl Into<String>, expected: &str) -> StudyError {
        let span = match &self.adaptive {
            Some(Adaptive::Bisect { span, .. }) => span.clone(),
            _ => 0..0,
        };
        let (expected, help) = expected.split_once('\n').unwrap_or((expected, ""));
        StudyError::new(
            &self.path,
            &self.text,
            vec![Mistake::new(span, message, expected).help(help)],
        )
    }

    /// Returns true if the study is not too large for its points to be listed.
    pub fn is_listed(&self) -> bool {
        self.points <= MAX_POINTS
    }

    /// Returns true if the study is no larger than one run takes.
    pub fn is_one_run(&self) -> bool {
        self.points <= self.most_points()
    }

    /// Returns whether each point depends on nothing but the axes: no result is compared with
    /// another, and none says which points there are.
    pub fn is_plain(&self) -> bool {
        self.has_independent_points() && self.exclusion.is_none()
    }

    /// Returns whether no result is compared with another, and none says which points there are.
    /// Conditions may leave points out.
    pub fn has_independent_points(&self) -> bool {
        self.kind == Kind::Solve && self.adaptive.is_none() && self.sample().is_none()
    }

    /// Returns the largest number of points that the study may have in one run.
    pub(crate) fn most_points(&self) -> usize {
        if self.is_plain() { MAX_RUN_POINTS } else { MAX_POINTS }
    }

    /// Returns whether every point is known to make sense. Of a study that is larger than one run
    /// takes, those of a part are.
    pub fn is_checked(&self) -> bool {
        self.is_checked
    }

    /// Returns the number of the points of this part of the study, or of all.
    pub fn point_count(&self) -> usize {
        self.part.as_ref().map_or(self.points, |part| part.len())
    }

    /// Returns the indices of the points of this part of the study, or of all.
    pub fn indices(&self) -> impl Iterator<Item = usize> + '_ {
        let all = if self.part.is_none() { 0..self.points } else { 0..0 };
        all.chain(self.part.iter().flat_map(|part| part.iter().copied()))
    }

    /// Returns the index of the point at a position among those of this part.
    pub fn index(&self, position: usize) -> Option<usize> {
        match &self.part {
            Some(part) => part.get(position).copied(),
            None => (position < self.points).then_some(position),
        }
    }

    /// Returns the levels of the points: a run that takes low ones first has answers early.
    pub fn levels(&self) -> PointLevels<'_> {
        PointLevels::of(&self.groups)
    }

    /// Refuses a part of the study that has more points than one run takes.
    ///
    /// # Errors
    /// The part is too large, at the place of the axes in the file.
    pub fn require_possible(&self, points: u64) -> Result<(), StudyError> {
        if points <= MAX_POINTS as u64 {
            return Ok(());
        }
        let span = self.axes().next().map_or(0..0, |axis| axis.span.clone());
        let message = format!("the shard has {points} points, more than {MAX_POINTS}");
        let sequence: usize = (0..self.groups.len())
            .filter(|group| self.is_sequence(*group))
            .map(|group| self.groups[group].length)
            .product();
        let expected = match sequence > MAX_POINTS {
            true => "needs fewer values on the axes along which points belong together",
            false => "needs more shards, or fewer values",
        };
        Err(StudyError::new(&self.path, &self.text, vec![Mistake::new(span, message, expected)]))
    }

    /// Refuses a study that one run does not take as a whole.
    ///
    /// # Errors
    /// Too many points, or points with too many load steps and layers, at the place of an axis.
    pub fn require_listed(&self) -> Result<(), StudyError> {
        let mistake = sweep::too_many_points(&self.groups, self.most_points())
            .or_else(|| too_many_entries(&self.groups, &self.base, self.points));
        let refused = |mistake| StudyError::new(&self.path, &self.text, vec![mistake]);
        mistake.map_or(Ok(()), |mistake| Err(refused(mistake)))
    }

    /// Returns the part of the study that has only the points with some indices.
    ///
    /// # Errors
    /// Too many points for one run, or one that makes no sense, at its place in the file.
    pub fn restricted(&self, mut indices: Vec<usize>) -> Result<Study, StudyError> {
        indices.sort_unstable();
        indices.dedup();
        let refused = |mistakes| StudyError::new(&self.path, &self.text, mistakes);
        self.require_possible(indices.len() as u64)?;
        // A study that can be listed has left them out already.
        let listed = indices.len();
        if !self.is_listed() && self.exclusion.is_some() {
            let kept = |index: usize| match self.decided(index) {
                Ok(decision) => (!decision.is_excluded).then_some(Ok(index)),
                Err(mistake) => Some(Err(mistake)),
            };
            let kept: Result<Vec<usize>, Mistake> =
                indices.into_par_iter().filter_map(kept).collect();
            indices = kept.map_err(|mistake| refused(vec![mistake]))?;
        }
        let excluded = listed - indices.len();
        if let Some(mistake) = too_many_entries(&self.groups, &self.base, indices.len()) {
            return Err(refused(vec![mistake]));
        }
        let check = |index: &usize| self.job(&axis::steps(&self.groups, *index)).err();
        // All the points of a study that can be listed were checked when it was read.
        if !self.is_listed()
            && let Some(mistakes) = indices.par_iter().find_map_first(check)
        {
            return Err(refused(mistakes));
        }
        Ok(Study { part: Some(indices.into()), excluded, is_checked: true, ..self.clone() })
    }

    /// Returns what the conditions decide about the point with an index.
    ///
    /// # Errors
    ///
    /// Returns the mistake of a condition that has no meaning at the point, at its place.
    pub fn decision(&self, index: usize) -> Result<PointDecision, StudyError> {
        self.decided(index)
            .map_err(|mistake| StudyError::new(&self.path, &self.text, vec![mistake]))
    }

    fn decided(&self, index: usize) -> Result<PointDecision, Mistake> {
        let Some(exclusion) = &self.exclusion else { return Ok(PointDecision::default()) };
        let steps = axis::steps(&self.groups, index);
        exclusion.excludes(&self.groups, &steps, &self.sheet(&steps))
    }

    /// Returns the remarks on conditions that change nothing at all the points of the study, of
    /// which some are `excluded`.
    ///
    /// # Errors
    ///
    /// Returns an error, at the place of the first condition, if they leave no point.
    pub fn idle_conditions(
        &self,
        excluded: usize,
        holding: &HoldingCounts,
    ) -> Result<Vec<String>, StudyError> {
        match &self.exclusion {
            None => Ok(Vec::new()),
            Some(exclusion) if excluded == self.points => {
                let mistake = exclusion.leaves_none(self.points);
                Err(StudyError::new(&self.path, &self.text, vec![mistake]))
            }
            Some(exclusion) => Ok(exclusion.idle(self.points, holding)),
        }
    }

    /// Leaves out the points for which the conditions say so, in a study that can be listed.
    pub(crate) fn leave_out(&mut self) -> Result<(), Mistake> {
        let Some(exclusion) = self.exclusion.as_ref().filter(|_| self.is_listed()) else {
            return Ok(());
        };
        let decided: Vec<PointDecision> = (0..self.points)
            .into_par_iter()
            .map(|index| self.decided(index))
            .collect::<Result<_, _>>()?;
        let kept =
            |(index, decision): (usize, &PointDecision)| (!decision.is_excluded).then_some(index);
        let part: Vec<usize> = decided.iter().enumerate().filter_map(kept).collect();
        if part.is_empty() {
            return Err(exclusion.leaves_none(self.points));
        }
        let holding = decided.into_iter().map(|decision| decision.holding);
        let holding = holding.fold(HoldingCounts::default(), HoldingCounts::with);
        self.remarks.extend(exclusion.idle(self.points, &holding));
        self.excluded = self.points - part.len();
        self.part = (self.excluded > 0).then(|| part.into());
        Ok(())
    }

    /// Returns whether the study has a point with some steps: false only where the conditions leave
    /// it out.
    pub(crate) fn has(&self, steps: &[usize]) -> bool {
        self.exclusion.as_ref().is_none_or(|exclusion| {
            let decided = exclusion.excludes(&self.groups, steps, &self.sheet(steps));
            decided.is_ok_and(|decision| !decision.is_excluded)
        })
    }

    /// Returns whether the points that differ only in the steps of a group of axes belong together:
    /// the results at some say which others there are, or they are compared with each other.
    pub fn is_sequence(&self, group: usize) -> bool {
        let has_axis = |wanted: usize| {
            let before: usize = self.groups[..group].iter().map(|group| group.axes.len()).sum();
            (before..before + self.groups[group].axes.len()).contains(&wanted)
        };
        let is_ladder = || self.ladder().is_some_and(|ladder| ladder.group == group);
        match &self.adaptive {
            Some(Adaptive::Accuracy(_)) => is_rung(&self.groups[group]),
            Some(rule) => rule.axes().iter().any(|axis| has_axis(*axis)),
            None if self.kind == Kind::Cost => is_rung(&self.groups[group]),
            None => is_ladder(),
        }
    }
}

/// Says of which point of a sample a mistake is.
pub(crate) fn of_sample(mistake: Mistake, step: usize) -> Mistake {
    match mistake.help.is_empty() {
        true => mistake.help(format!("it is so at point {} of the sample", step + 1)),
        false => mistake,
    }
}
