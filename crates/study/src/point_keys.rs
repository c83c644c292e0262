//! The canonical texts and the keys of the points of a study, one after the other, at a fraction of
//! what it takes to assemble their jobs.
//!
//! The text of a job that solves a scene falls into parts, each made by keys of its own
//! ([`TextPart`]), so a part depends only on the steps of those axes that set its keys, or keys
//! from which these are derived. Each text of a part is taken once from an assembled job and
//! looked up from then on. What stands before the first part that varies is hashed once.

use std::sync::OnceLock;

use identity::{JobKey, JobKeyHasher};

use crate::axis::{self, Group, Target};
use crate::job::{Job, PHYSICS_VERSION, TextPart};
use crate::kind::Kind;
use crate::study::Study;

/// The most texts of parts that are kept, each of some hundred bytes.
const MOST_TEXTS: usize = 65_536;

/// The texts and keys of the points of a study.
pub struct PointKeys<'s> {
    study: &'s Study,
    /// The parts of the texts; `None` if the jobs are assembled one by one.
    parts: Option<PartTexts>,
}

/// The parts of the texts of all points.
struct PartTexts {
    /// The parts in their order.
    parts: Vec<PartText>,
    /// The hash of what no axis changes at the beginning, once it is known.
    beginning: OnceLock<JobKeyHasher>,
    /// The number of parts at the beginning that no axis changes.
    constant: usize,
}

/// The texts of one part.
struct PartText {
    /// The groups of axes on whose steps the text depends.
    groups: Vec<usize>,
    /// The text for each combination of their steps, the last group fastest.
    texts: Vec<OnceLock<Box<str>>>,
}

impl PartText {
    /// Returns the index of the text at a point with some steps.
    fn index(&self, study: &Study, steps: &[usize]) -> usize {
        let groups = self.groups.iter();
        groups.fold(0, |index, group| index * study.groups[*group].length + steps[*group])
    }
}

impl PartTexts {
    /// Finds on which groups each part depends; `None` if that would not make anything faster.
    fn of(study: &Study) -> Option<PartTexts> {
        if !matches!(study.kind, Kind::Solve | Kind::Convergence | Kind::Sensitivity) {
            return None;
        }
        let mut depends = [const { Vec::new() }; TextPart::COUNT];
        for (index, group) in study.groups.iter().enumerate() {
            for part in parts_of(study, group) {
                let groups: &mut Vec<usize> = &mut depends[part as usize];
                if !groups.contains(&index) {
                    groups.push(index);
                }
            }
        }
        let mut kept = 0;
        let mut parts = Vec::with_capacity(TextPart::COUNT);
        for groups in depends {
            let lengths = groups.iter().map(|group| study.groups[*group].length);
            let count = lengths.fold(1, usize::saturating_mul);
            kept = count.checked_add(kept).filter(|kept| *kept <= MOST_TEXTS)?;
            let texts = std::iter::repeat_with(OnceLock::new).take(count).collect();
            parts.push(PartText { groups, texts });
        }
        let constant = parts.iter().take_while(|part| part.groups.is_empty()).count();
        (kept < study.points).then(|| PartTexts { parts, beginning: OnceLock::new(), constant })
    }
}

/// Returns the parts of a text that change with the steps of a group of axes.
fn parts_of(study: &Study, group: &Group) -> Vec<TextPart> {
    let keys = || axis::keys(&[], std::slice::from_ref(group));
    let targets = group.axes.iter().map(|axis| match axis.target {
        Target::Key(key) => key.pattern(),
        Target::Table(table) => table.pattern,
    });
    let set = targets.chain(keys().map(|key| key.pattern()));
    let derived = study.derivation.keys().filter(|derived| {
        let of_axes = group.axes.iter().filter_map(|axis| axis.key());
        of_axes.chain(keys()).any(|key| study.derivation.follows(*derived, key))
    });
    let patterns = set.chain(derived.map(|key| key.pattern()));
    let mut parts = Vec::new();
    for part in patterns.flat_map(TextPart::of_pattern) {
        if !parts.contains(part) {
            parts.push(*part);
        }
    }
    parts
}

impl<'s> PointKeys<'s> {
    /// Prepares the texts and keys of a study's points. They are as cheap as they can be if the
    /// study [was checked](Study::is_checked) point by point.
    pub fn of(study: &'s Study) -> PointKeys<'s> {
        let parts = study.is_checked().then(|| PartTexts::of(study)).flatten();
        PointKeys { study, parts }
    }

    /// Returns the canonical text of the job at the `index`-th point; `None` if there is none.
    pub fn text(&self, index: usize) -> Option<String> {
        match &self.parts {
            None => Some(self.job(index)?.canonical()),
            Some(parts) => {
                let mut text = String::with_capacity(512);
                self.visit(parts, 0, index, |part| text.push_str(part))?;
                Some(text)
            }
        }
    }

    /// Returns the key of the job at the `index`-th point; `None` if there is none.
    pub fn key(&self, index: usize) -> Option<JobKey> {
        let Some(parts) = &self.parts else { return Some(self.job(index)?.key()) };
        let mut hasher = match parts.beginning.get() {
            Some(beginning) => beginning.clone(),
            None => {
                let mut beginning = JobKeyHasher::new(PHYSICS_VERSION);
                let mut count = 0;
                self.visit(parts, 0, index, |part| {
                    if count < parts.constant {
                        beginning.update(part);
                    }
                    count += 1;
                })?;
                parts.beginning.get_or_init(|| beginning).clone()
            }
        };
        self.visit(parts, parts.constant, index, |part| hasher.update(part))?;
        Some(hasher.key())
    }

    fn job(&self, index: usize) -> Option<Job> {
        let steps = (index < self.study.points).then(|| axis::steps(&self.study.groups, index))?;
        self.study.job(&steps).ok()
    }

    /// Visits the parts of the text at a point from the `first` one on.
    fn visit<'p>(
        &self,
        parts: &'p PartTexts,
        first: usize,
        index: usize,
        mut visitor: impl FnMut(&'p str),
    ) -> Option<()> {
        let steps = (index < self.study.points).then(|| axis::steps(&self.study.groups, index))?;
        let cells = || parts.parts.iter().map(|part| &part.texts[part.index(self.study, &steps)]);
        if cells().any(|cell| cell.get().is_none()) {
            let made = self.study.job(&steps).ok()?.text_parts()?;
            for (cell, text) in cells().zip(made) {
                cell.get_or_init(|| text.into_boxed_str());
            }
        }
        cells().skip(first).filter_map(OnceLock::get).for_each(|text| visitor(text));
        Some(())
    }
}
