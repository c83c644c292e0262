//! The kinds of studies.
//!
//! Each kind has a file below this one that says everything about it. [`Kind`] names the kinds, and
//! `Kind::spec` registers them. The files use everything that lies below them, from the keys to
//! the figures, but not this face.

pub mod convergence;
pub mod cost;
mod freedom;
mod interior;
mod multiplicity;
mod rolling;
mod rolling_theory;
pub mod sensitivity;
mod solve;
mod spec;
mod uniqueness;
mod wear;

use toml::de::DeTable;

use crate::assemble::{Assembler, locate};
use crate::axis::{Group, SweepAxis};
use crate::columns::{self, Column};
use crate::error::Mistake;
use crate::figure::Figure;
use crate::job::Job;
use crate::key::Key;
use crate::sheet::{Sheet, SurfaceNames, TablePlaces};
use crate::table_key::KeyTable;

use spec::KindSpec;
pub(crate) use spec::KindTable;

/// The question that a study asks about its points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Every point is solved.
    #[default]
    Solve,
    /// Every point is solved, and compared with the limit of a ladder of points.
    Convergence,
    /// Every point is solved several times over, and its error is compared with its time.
    Cost,
    /// Every point is searched for all of its solutions.
    Multiplicity,
    /// Every point of a design is solved, and rows of them tell how much each key moves a result.
    Sensitivity,
    /// The end μ* of the uniqueness set is bracketed at every point.
    Uniqueness,
}

impl Kind {
    /// Every kind.
    pub const ALL: &'static [Kind] = &[
        Kind::Solve,
        Kind::Convergence,
        Kind::Cost,
        Kind::Multiplicity,
        Kind::Sensitivity,
        Kind::Uniqueness,
    ];

    /// The names by which a study file calls them.
    pub(crate) const NAMES: &'static [&'static str] = &[
        solve::SPEC.name,
        convergence::SPEC.name,
        cost::SPEC.name,
        multiplicity::SPEC.name,
        sensitivity::SPEC.name,
        uniqueness::SPEC.name,
    ];

    /// Returns everything that is known of the kind.
    fn spec(self) -> &'static KindSpec {
        match self {
            Kind::Solve => &solve::SPEC,
            Kind::Convergence => &convergence::SPEC,
            Kind::Cost => &cost::SPEC,
            Kind::Multiplicity => &multiplicity::SPEC,
            Kind::Sensitivity => &sensitivity::SPEC,
            Kind::Uniqueness => &uniqueness::SPEC,
        }
    }

    /// Returns the name by which a study file calls it.
    pub fn name(self) -> &'static str {
        self.spec().name
    }

    /// Returns the kind of this name.
    pub(crate) fn find(name: &str) -> Option<Kind> {
        Kind::ALL.iter().copied().find(|kind| kind.name() == name)
    }

    /// Returns every column of a study of this kind with these axes, in order: the axes, the other
    /// keys, then the results. Without axes and keys, these are the columns of any record. `keys`
    /// are the keys that the study gives. The keys of the numerics, which have defaults, have
    /// columns anyway.
    pub fn columns<'a>(
        self,
        axes: impl IntoIterator<Item = &'a SweepAxis>,
        keys: impl IntoIterator<Item = Key>,
    ) -> Vec<Column> {
        let KindSpec { refuses, columns, further_columns, .. } = self.spec();
        let results = [*columns, *further_columns].concat();
        columns::columns(axes, keys, |key| refuses(key).is_some(), &results)
    }

    /// Returns the names of the columns of results that a query shows if none are named.
    pub fn usual_columns(self) -> &'static [&'static str] {
        self.spec().usual_columns
    }

    /// Returns whether meshes may be chosen by the accuracy of the results.
    pub(crate) fn has_accuracy(self) -> bool {
        self.spec().has_accuracy
    }

    /// Returns the tables that only some kinds have.
    pub(crate) fn tables() -> impl Iterator<Item = KeyTable> {
        Kind::ALL.iter().filter_map(|kind| Some(kind.spec().table.as_ref()?.table))
    }

    /// Tells why the jobs of this kind have no use for a key; `None` if they have.
    pub(crate) fn refusal(self, key: Key) -> Option<&'static str> {
        (self.spec().refuses)(key)
    }

    /// Reads the table of this kind from the `root` of a study, and refuses those of other kinds.
    pub(crate) fn read_table(
        self,
        root: &DeTable<'_>,
        groups: &[Group],
        mistakes: &mut Vec<Mistake>,
    ) -> KindTable {
        let mut read = KindTable::default();
        for kind in Kind::ALL {
            let Some(table) = &kind.spec().table else { continue };
            let node = root.get(table.table.path);
            if *kind == self {
                read = table.read(node, groups, mistakes);
            } else if let Some(node) = node {
                let (name, kind) = (table.table.path, kind.name());
                let message = format!("only a study of kind \"{kind}\" has `[{name}]`");
                let mistake = Mistake::new(node.span(), message, "leave this out");
                mistakes.push(mistake.help(table.advice));
            }
        }
        read
    }

    /// Reads the columns that the table of this kind names.
    pub(crate) fn read_columns(
        self,
        root: &DeTable<'_>,
        columns: &[Column],
        table: &mut KindTable,
        mistakes: &mut Vec<Mistake>,
    ) {
        if let Some(spec) = &self.spec().table {
            spec.read_columns(root.get(spec.table.path), columns, table, mistakes);
        }
    }

    /// Puts rows in place of the points of a sample, if this kind compares the points of rows.
    /// Then none of the `rules`, which stand at the `root` of the study, may choose others.
    pub(crate) fn arrange(
        self,
        root: &DeTable<'_>,
        rules: &[&str],
        table: &KindTable,
        groups: &mut [Group],
        mistakes: &mut Vec<Mistake>,
    ) {
        let Some(arrange) = self.spec().arrange else { return };
        for (name, node) in rules.iter().filter_map(|name| root.get_key_value(*name)) {
            let message = format!(
                "a study of kind \"{}\" compares the points of its design, and `[{}]` chooses others",
                self.name(),
                name.get_ref()
            );
            mistakes.push(Mistake::new(node.span(), message, "leave this out"));
        }
        for group in groups {
            let Some(design) = &group.design else { continue };
            let rows = design.arranged(arrange(table));
            match rows.points() {
                Some(points) => {
                    group.length = points as usize;
                    group.design = Some(rows);
                }
                None => {
                    let message =
                        format!("{} rows of {} points", design.count(), rows.row_length());
                    let place = group.count.clone();
                    mistakes.push(Mistake::new(place, message, "needs a smaller `count`"));
                }
            }
        }
    }

    /// Makes the figures that may answer a study that asks for none, the preferred one first; none
    /// without an axis to draw over. `jobs` are some of the study's, along each axis.
    pub(crate) fn suggestions(
        self,
        table: &KindTable,
        groups: &[Group],
        jobs: &[Job],
    ) -> Vec<Figure> {
        (self.spec().suggestions)(table, groups, jobs)
    }

    /// Assembles the job that a sheet describes.
    ///
    /// # Errors
    ///
    /// Returns everything that is missing, out of place or without meaning, at the place that
    /// caused it.
    pub(crate) fn assemble(
        self,
        table: &KindTable,
        sheet: &Sheet<'_>,
        surfaces: &SurfaceNames,
        places: &TablePlaces,
    ) -> Result<Job, Vec<Mistake>> {
        let spec = self.spec();
        let mut assembler = Assembler::new(sheet, surfaces, places);
        for key in sheet.keys(|key| (spec.refuses)(key).is_some()) {
            if let (Some(why), Some(given)) = ((spec.refuses)(key), sheet.get(key)) {
                let (name, key) = (spec.name, key.short());
                let message = format!("a study of kind \"{name}\" has no `{key}`: {why}");
                assembler.note(Mistake::new(given.span.clone(), message, "leave this out"));
            }
        }
        let job = (spec.assemble)(&mut assembler, table);
        let mistakes = assembler.into_mistakes();
        if !mistakes.is_empty() {
            return Err(mistakes);
        }
        job.validate()
            .and_then(|()| (spec.check)(&job))
            .map_err(|error| vec![locate(&error, sheet, places)])?;
        Ok(job)
    }

    /// Writes the line that names the kind, if it is not the default, and the keys that only this
    /// kind has, as a study file gives them for a job.
    pub(crate) fn to_toml(self, job: &Job) -> String {
        let spec = self.spec();
        let kind = match self == Kind::default() {
            true => String::new(),
            false => format!("kind = \"{}\"\n", spec.name),
        };
        kind + &(spec.to_toml)(job)
    }
}

impl Job {
    /// Returns the simplest kind of study that asks for such jobs.
    pub fn kind(&self) -> Kind {
        match self {
            Job::Solve(_) => Kind::Solve,
            Job::Cost { .. } => Kind::Cost,
            Job::Multiplicity { .. } => Kind::Multiplicity,
            Job::Uniqueness { .. } | Job::Branch { .. } => Kind::Uniqueness,
        }
    }

    /// Returns the columns of the results that the scene asks for beyond those of every scene.
    pub fn asked_columns(&self) -> Vec<&'static str> {
        freedom::asked_of(self)
    }
}

#[cfg(test)]
mod tests;
