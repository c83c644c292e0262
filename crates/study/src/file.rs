//! A study: one TOML file that reads like the question.
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
//! [figure]                    # see `figure`; also [[figure]], several times; without it a study has one of its own
//! x = "mu"
//! y = "stick_fraction"
//! ```
//! Numbers are SI or texts with a unit. Everything that could be wrong is refused here, with its
//! place, before anything runs.

use std::collections::BTreeMap;
use std::sync::Arc;

use contact::model::{Mesh, SceneError};
use contact::punch::{ProfileKind, Surfaces};
use rayon::prelude::*;
use toml::de::{DeTable, DeValue};

use crate::accuracy;
use crate::adaptive::{self, Adaptive};
use crate::assemble::{assemble, locate};
use crate::axis::{self, Axis, Group};
use crate::columns::{self, Column, Value};
use crate::cost::{self, Cost};
use crate::error::{Problem, Span, StudyError};
use crate::figure::{self, Figure};
use crate::job::{Job, JobError, JobKey};
use crate::key::{Key, Table, nearest, one_of};
use crate::kind::Kind;
use crate::ladder::{self, Ladder};
use crate::read::{self, Reader, entries};
use crate::record::{BLOB_LIMIT, DecodeError, Record, decode, encode};
use crate::sheet::{Given, Setting, Sheet, Source, SurfaceNames, TablePlaces};
use crate::{profile, surface, sweep};

/// A study whose every point makes sense.
#[derive(Clone, Debug)]
pub struct Study {
    name: String,
    question: String,
    kind: Kind,
    figures: Vec<Figure>,
    groups: Vec<Group>,
    adaptive: Option<Adaptive>,
    ladder: Option<Ladder>,
    cost: Option<Cost>,
    base: Vec<(Key, Given)>,
    places: TablePlaces,
    points: usize,
    surfaces: Surfaces,
    surface_names: SurfaceNames,
    files: BTreeMap<String, Vec<u8>>,
    path: String,
    text: String,
}

/// One point of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The value of each axis, in the order of [`Study::axes`], in SI units.
    pub values: Vec<Value>,
    /// What is to be computed.
    pub job: Job,
    /// Its identity; points whose jobs coincide share it, and the result.
    pub key: JobKey,
}

impl Point {
    /// The point of a record by itself, without a study.
    pub fn of_record(record: &Record) -> Result<Point, JobError> {
        Ok(Point { values: Vec::new(), job: record.parse_job()?, key: record.key() })
    }
}

/// Reads a file that a study names.
pub type ReadFile<'f> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'f;

const KEYS: &[&str] = &[
    "name",
    "question",
    "kind",
    "accuracy",
    "scene",
    "numerics",
    "search",
    "sweep",
    "refine",
    "bisect",
    "convergence",
    "cost",
    "figure",
];

impl Study {
    /// Reads a study's text. `path` is for messages; `files` reads a file that the study names (a
    /// height map), with the name as the study writes it, or a stored surface by its hash.
    pub fn parse(text: &str, path: &str, files: &mut ReadFile<'_>) -> Result<Study, StudyError> {
        parse(text, path, files).map_err(|problems| StudyError::new(path, text, problems))
    }

    /// The name, fit for a file or a directory.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The question, or nothing.
    pub fn question(&self) -> &str {
        &self.question
    }

    /// What is done with the points.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The figures that answer the question: the file's, else one that its axes suggest, if they
    /// do.
    pub fn figures(&self) -> &[Figure] {
        &self.figures
    }

    /// The groups of axes, the last one fastest.
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// The axes of all groups, in order.
    pub fn axes(&self) -> impl Iterator<Item = &Axis> {
        self.groups.iter().flat_map(Group::axes)
    }

    /// How it chooses points beyond those of its axes, if it does.
    pub fn adaptive(&self) -> Option<&Adaptive> {
        self.adaptive.as_ref()
    }

    /// The ladder of a convergence study.
    pub fn ladder(&self) -> Option<&Ladder> {
        self.ladder.as_ref()
    }

    /// What a study of cost measures.
    pub fn cost(&self) -> Option<&Cost> {
        self.cost.as_ref()
    }

    /// Every column of the study's results.
    pub fn columns(&self) -> Vec<Column> {
        columns::columns(self.kind, self.axes(), keys(&self.base, &self.groups))
    }

    /// The surfaces that its jobs name.
    pub fn surfaces(&self) -> &Surfaces {
        &self.surfaces
    }

    /// The text of the file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Where the text came from.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The number of points; at least one, for a study without axes is its base.
    #[expect(clippy::len_without_is_empty, reason = "a study is never empty")]
    pub fn len(&self) -> usize {
        self.points
    }

    /// The `index`-th point, `None` from [`len`](Study::len) on. Points are in the order of the
    /// axes, the last group fastest.
    pub fn point(&self, index: usize) -> Option<Point> {
        let steps = (index < self.points).then(|| axis::steps(&self.groups, index))?;
        let job = self.job(&steps).ok()?;
        let values = self.groups.iter().zip(&steps).flat_map(|(group, step)| {
            group.axes.iter().map(|axis| axis.choices[*step].shown.clone())
        });
        Some(Point { values: values.collect(), key: job.key(), job })
    }

    /// The `index`-th point with another mesh; `None` where that is no job.
    pub fn point_on_mesh(&self, index: usize, mesh: Mesh) -> Option<Point> {
        self.point_with(index, &[(Key::Mesh, Setting::Mesh(mesh))], |_| {})
    }

    /// The same, solved to a tolerance, unless the study gives one.
    pub fn point_as_exact(&self, index: usize, mesh: Mesh, tolerance: f64) -> Option<Point> {
        let steps = (index < self.points).then(|| axis::steps(&self.groups, index))?;
        let settings =
            [(Key::Mesh, Setting::Mesh(mesh)), (Key::Tolerance, Setting::Number(tolerance))];
        let is_given = self.sheet(&steps).get(Key::Tolerance).is_some();
        self.point_with(index, if is_given { &settings[..1] } else { &settings }, |_| {})
    }

    /// The `index`-th point with another value of the axis with index `axis`, which must be one of
    /// numbers; `None` where that is no job.
    pub fn point_at(&self, index: usize, axis: usize, value: f64) -> Option<Point> {
        let key = self.axes().nth(axis)?.key()?;
        self.point_with(index, &[(key, Setting::Number(value))], |values| {
            values.get_mut(axis).into_iter().for_each(|shown| *shown = Value::Number(value));
        })
    }

    fn point_with(
        &self,
        index: usize,
        settings: &[(Key, Setting)],
        show: impl FnOnce(&mut Vec<Value>),
    ) -> Option<Point> {
        let Point { mut values, .. } = self.point(index)?;
        let given: Vec<(Key, Given)> = settings
            .iter()
            .map(|(key, setting)| (*key, Given { setting: setting.clone(), span: 0..0, nth: None }))
            .collect();
        let mut sheet = self.sheet(&axis::steps(&self.groups, index));
        given.iter().for_each(|(key, given)| sheet.set(*key, given));
        let job =
            assemble(self.kind, self.cost.as_ref(), &sheet, &self.surface_names, &self.places)
                .ok()?;
        show(&mut values);
        Some(Point { values, key: job.key(), job })
    }

    /// What is wrong with the scene of the `index`-th point, at its place in the file.
    pub fn refuse(&self, index: usize, error: &SceneError) -> StudyError {
        let sheet = self.sheet(&axis::steps(&self.groups, index.min(self.points - 1)));
        let mut problem = locate(error, &sheet, &self.places);
        let values = self.point(index).map(|point| point.values).unwrap_or_default();
        let at: Vec<String> = self
            .axes()
            .zip(&values)
            .map(|(axis, value)| format!("{} = {value}", axis.column()))
            .collect();
        if !at.is_empty() {
            problem.help = format!("it is so at {}", at.join(", "));
        }
        StudyError::new(&self.path, &self.text, vec![problem])
    }

    /// What is wrong with the condition of `[bisect]`, at its place in the file; lines of
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
            vec![Problem::new(span, message, expected).help(help)],
        )
    }

    /// Every point of the axes, in order. Points whose jobs coincide are all there.
    pub fn points(&self) -> Vec<Point> {
        (0..self.points).into_par_iter().filter_map(|index| self.point(index)).collect()
    }

    /// Everything that is needed to read the study again when its files are gone: text, path and
    /// the files it names.
    pub fn definition(&self) -> Vec<u8> {
        encode(&(&self.path, &self.text, &self.files))
    }

    /// Reads a [`definition`](Study::definition).
    pub fn from_definition(bytes: &[u8]) -> Result<Study, DefinitionError> {
        let (path, text, files) = decode::<(String, String, BTreeMap<String, Vec<u8>>), BLOB_LIMIT>(
            "the study's definition",
            bytes,
        )?;
        let mut read = |name: &str| {
            files.get(name).cloned().ok_or_else(|| "it is not in the study's definition".to_owned())
        };
        Ok(Study::parse(&text, &path, &mut read)?)
    }

    fn sheet(&self, steps: &[usize]) -> Sheet<'_> {
        let mut sheet = Sheet::new(self.base.iter().map(|(key, given)| (*key, given)));
        for (group, step) in self.groups.iter().zip(steps) {
            group.axes.iter().for_each(|axis| axis.apply(*step, &mut sheet));
        }
        sheet
    }

    fn job(&self, steps: &[usize]) -> Result<Job, Vec<Problem>> {
        let job = assemble(
            self.kind,
            self.cost.as_ref(),
            &self.sheet(steps),
            &self.surface_names,
            &self.places,
        )?;
        if let Some(Adaptive::Accuracy(accuracy)) = &self.adaptive {
            accuracy.check(&job).map_err(|problem| vec![problem])?;
        }
        Ok(job)
    }

    /// Reads the height maps and profiles that any point needs, each once.
    fn read_surfaces(&mut self, files: &mut ReadFile<'_>) -> Vec<Problem> {
        let names_files = |key| matches!(key, Key::File | Key::Surface | Key::Wheel | Key::Rail);
        if !keys(&self.base, &self.groups).any(names_files) {
            return Vec::new();
        }
        for index in 0..self.points {
            let steps = axis::steps(&self.groups, index);
            // what is read goes into the study, from which a sheet borrows
            let wanted: Vec<(Key, Span, Wanted)> = {
                let sheet = self.sheet(&steps);
                let sources = sheet.sources().into_iter();
                sources
                    .map(|(key, source)| {
                        (
                            key,
                            sheet.get(key).map_or(0..0, |given| given.span.clone()),
                            Wanted::of(source),
                        )
                    })
                    .collect()
            };
            for (key, span, wanted) in wanted {
                let read = match wanted {
                    Wanted::Map(file, unit) => self.read_height_map((file, unit), files),
                    Wanted::StoredMap(name) => self.read_stored_surface(name, files),
                    Wanted::Profile(file) => self.read_profile(key, file, files),
                };
                if let Err(why) = read {
                    let (what, expected) = match key {
                        Key::File => ("height map", "must be an NPY file or a matrix of text"),
                        Key::Surface => ("height map", "must be the hash of a stored surface"),
                        Key::Wheel => {
                            ("profile", "must be a wheel's profile in SIMPACK's format (.prw)")
                        }
                        _ => ("profile", "must be a rail's profile in SIMPACK's format (.prr)"),
                    };
                    // one bad file is one problem, however many points use it
                    return vec![Problem::new(
                        span,
                        format!("cannot use this {what}: {why}"),
                        expected,
                    )];
                }
            }
        }
        Vec::new()
    }

    /// The bytes of a file that the study names, read once.
    fn file(&mut self, name: &str, files: &mut ReadFile<'_>) -> Result<&[u8], String> {
        if !self.files.contains_key(name) {
            self.files.insert(name.to_owned(), files(name)?);
        }
        Ok(self.files.get(name).map_or(&[], Vec::as_slice))
    }

    fn read_height_map(
        &mut self,
        (file, unit): (String, String),
        files: &mut ReadFile<'_>,
    ) -> Result<(), String> {
        if self.surface_names.maps.contains_key(&(file.clone(), unit.clone())) {
            return Ok(());
        }
        let surface =
            surface::read(self.file(&file, files)?, &unit).map_err(|error| error.to_string())?;
        let name = surface::name(&surface);
        self.surfaces.insert(name.clone(), Arc::new(surface));
        self.surface_names.maps.insert((file, unit), name);
        Ok(())
    }

    fn read_stored_surface(
        &mut self,
        name: String,
        files: &mut ReadFile<'_>,
    ) -> Result<(), String> {
        if self.surfaces.get(&name).is_some() {
            return Ok(());
        }
        let surface =
            surface::decode_surface(self.file(&name, files)?).map_err(|error| error.to_string())?;
        if surface::name(&surface) != name {
            return Err("its content does not have this hash".to_owned());
        }
        self.surfaces.insert(name, Arc::new(surface));
        Ok(())
    }

    fn read_profile(
        &mut self,
        key: Key,
        file: String,
        files: &mut ReadFile<'_>,
    ) -> Result<(), String> {
        if !self.surface_names.profiles.contains_key(&file) {
            let profile =
                profile::read(self.file(&file, files)?).map_err(|error| error.to_string())?;
            let name = profile::name(&profile);
            self.surfaces.insert_profile(name.clone(), Arc::new(profile));
            self.surface_names.profiles.insert(file.clone(), name);
        }
        let profile =
            self.surface_names.profiles.get(&file).and_then(|name| self.surfaces.profile(name));
        match (key, profile.map(|profile| profile.kind())) {
            (Key::Wheel, Some(ProfileKind::Rail)) => Err("it is a rail's".to_owned()),
            (Key::Rail, Some(ProfileKind::Wheel)) => Err("it is a wheel's".to_owned()),
            _ => Ok(()),
        }
    }

    /// Assembles every point: first along each axis with the others at their first value, which
    /// reports each bad value once; then, if those are good, all of them.
    fn check(&self) -> Result<(), Vec<Problem>> {
        let mut problems = Vec::new();
        for (which, group) in self.groups.iter().enumerate().filter(|(_, group)| group.length > 1) {
            let mut steps = vec![0; self.groups.len()];
            for step in 0..group.length {
                steps[which] = step;
                problems.extend(self.job(&steps).err().into_iter().flatten());
                if problems.len() > 1000 {
                    break;
                }
            }
        }
        if problems.is_empty() {
            let check = |index| self.job(&axis::steps(&self.groups, index)).err();
            problems = (0..self.points).into_par_iter().find_map_first(check).unwrap_or_default();
        }
        if problems.is_empty() { Ok(()) } else { Err(problems) }
    }
}

/// A [`Source`] that borrows nothing.
enum Wanted {
    Map(String, String),
    StoredMap(String),
    Profile(String),
}

impl Wanted {
    fn of(source: Source<'_>) -> Self {
        match source {
            Source::Map(file, unit) => Wanted::Map(file.to_owned(), unit.to_owned()),
            Source::StoredMap(name) => Wanted::StoredMap(name.to_owned()),
            Source::Profile(file) => Wanted::Profile(file.to_owned()),
        }
    }
}

/// Why a stored definition is no study.
#[derive(Debug, thiserror::Error)]
pub enum DefinitionError {
    /// The bytes do not decode.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The text in it is refused, by a newer version of the program.
    #[error(transparent)]
    Study(#[from] StudyError),
}

fn parse(text: &str, path: &str, files: &mut ReadFile<'_>) -> Result<Study, Vec<Problem>> {
    let (root, errors) = DeTable::parse_recoverable(text);
    // what follows the first error is mostly its echo
    if let Some(error) = errors.first() {
        let expected =
            if error.message() == "duplicate key" { "may be given only once" } else { "" };
        return Err(vec![Problem::new(
            error.span().unwrap_or(0..0),
            format!("not valid TOML: {}", error.message()),
            expected,
        )]);
    }
    let root = root.into_inner();
    let mut problems = Vec::new();
    for (name, _) in
        entries(&root).into_iter().filter(|(name, _)| !KEYS.contains(&name.get_ref().as_ref()))
    {
        problems.push(read::unknown(name.get_ref(), name.span(), "the study", KEYS));
    }
    let name = read_name(&root, &mut problems);
    let question = read_text(&root, "question", &mut problems).unwrap_or_default();
    let kind = read_kind(&root, &mut problems);
    let (mut base, places) = read_base(text, &root, &mut problems);
    let groups = root
        .get("sweep")
        .map(|node| sweep::read_sweep(text, node, &mut problems))
        .unwrap_or_default();
    let accuracy = root
        .get("accuracy")
        .and_then(|node| accuracy::read(node, kind, &base, &groups, &mut problems));
    base.extend(accuracy.iter().map(accuracy::Accuracy::first_mesh));
    let ladder = match (kind, root.get("convergence")) {
        (Kind::Convergence, node) => ladder::read(node, &groups, &mut problems),
        (_, Some(node)) => {
            let problem = Problem::new(
                node.span(),
                "only a study of kind \"convergence\" has `[convergence]`",
                "leave this out",
            );
            problems.push(problem.help("or say kind = \"convergence\" at the top"));
            None
        }
        (_, None) => None,
    };
    let cost = match (kind, root.get("cost")) {
        (Kind::Cost, node) => cost::read(node, &groups, &mut problems),
        (_, Some(node)) => {
            problems.push(Problem::new(
                node.span(),
                "only a study of kind \"cost\" has `[cost]`",
                "leave this out",
            ));
            None
        }
        (_, None) => None,
    };
    let before = problems.len();
    sweep::refuse_absent(&groups, &base, &mut problems);
    if problems.len() > before {
        // entries have columns, and an index that is far off would make thousands of millions
        return Err(problems);
    }
    let columns = columns::columns(kind, groups.iter().flat_map(Group::axes), keys(&base, &groups));
    let figures = match root.get("figure") {
        Some(node) => figure::read_figures(node, &groups, &columns, &mut problems),
        None => {
            figure::default(kind, ladder.as_ref(), cost.as_ref(), &groups).into_iter().collect()
        }
    };
    let adaptive = adaptive::read(
        root.get("accuracy"),
        root.get("refine"),
        root.get("bisect"),
        &base,
        &groups,
        &columns,
        &mut problems,
    );
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut study = Study {
        adaptive: adaptive.or(accuracy.map(Adaptive::Accuracy)),
        ladder,
        cost,
        name,
        question,
        kind,
        figures,
        points: axis::count(&groups).unwrap_or(0),
        groups,
        base,
        places,
        surfaces: Surfaces::new(),
        surface_names: SurfaceNames::default(),
        files: BTreeMap::new(),
        path: path.to_owned(),
        text: text.to_owned(),
    };
    let unreadable = study.read_surfaces(files);
    if !unreadable.is_empty() {
        return Err(unreadable);
    }
    study.check()?;
    Ok(study)
}

/// Every key that a base or an axis gives, some more than once.
fn keys<'a>(base: &'a [(Key, Given)], groups: &'a [Group]) -> impl Iterator<Item = Key> + 'a {
    let choices = groups.iter().flat_map(Group::axes).flat_map(|axis| &axis.choices);
    base.iter().chain(choices.flat_map(|choice| &choice.given)).map(|(key, _)| *key)
}

fn read_base(
    text: &str,
    root: &DeTable<'_>,
    problems: &mut Vec<Problem>,
) -> (Vec<(Key, Given)>, TablePlaces) {
    let mut reader = Reader::new(text, problems);
    for (name, node) in entries(root) {
        match (
            Table::find(name.get_ref()).filter(|table| table.path() == name.get_ref().as_ref()),
            node.get_ref(),
        ) {
            (Some(table), DeValue::Table(below)) => {
                reader.table(table, node.span(), entries(below))
            }
            (Some(table), _) => {
                reader.problems.push(read::mistyped(&table.path(), node, &table.expected()));
            }
            (None, _) => {}
        }
    }
    (reader.given, reader.places)
}

fn read_text(root: &DeTable<'_>, name: &str, problems: &mut Vec<Problem>) -> Option<String> {
    read::text(name, root.get(name)?).map_err(|problem| problems.push(problem)).ok()
}

fn read_name(root: &DeTable<'_>, problems: &mut Vec<Problem>) -> String {
    let Some(node) = root.get("name") else {
        problems.push(Problem::new(
            0..0,
            "the study has no name",
            "needs name = \"…\", under which its results are kept",
        ));
        return String::new();
    };
    let name = read_text(root, "name", problems).unwrap_or_default();
    if matches!(node.get_ref(), DeValue::String(_)) {
        problems.extend(refuse_file_name(&name, "a study", node));
    }
    name
}

/// The problem of a name that is not fit for a file, if it is not; `what` it names with its
/// article.
pub(crate) fn refuse_file_name(name: &str, what: &str, node: &read::Node<'_>) -> Option<Problem> {
    let legal = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    let is_name = name.starts_with(|c: char| c.is_ascii_alphanumeric())
        && name.chars().all(legal)
        && name.len() <= 64;
    let expected =
        "must be 1 to 64 letters, digits, `-`, `_` or `.`, the first a letter or a digit";
    (!is_name).then(|| Problem::new(node.span(), format!("`{name}` cannot name {what}"), expected))
}

fn read_kind(root: &DeTable<'_>, problems: &mut Vec<Problem>) -> Kind {
    let (Some(name), Some(node)) = (read_text(root, "kind", problems), root.get("kind")) else {
        return Kind::default();
    };
    Kind::find(&name).unwrap_or_else(|| {
        let names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
        let problem = |expected: &str| {
            Problem::new(node.span(), format!("unknown kind of study `{name}`"), expected)
        };
        let listed = format!("must be {}", one_of(&names));
        problems.push(match nearest(&name, names.iter().copied()) {
            Some(meant) => problem(&format!("did you mean \"{meant}\"?")).help(listed),
            None => problem(&listed),
        });
        Kind::default()
    })
}
