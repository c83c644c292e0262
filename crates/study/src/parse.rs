//! Reads a study's text and checks every point of it.

use rayon::prelude::*;
use toml::de::{DeTable, DeValue};

use crate::adaptive::{self, Adaptive};
use crate::assemble::HEIGHT_MAP;
use crate::axis::{self, Group, MAX_POINTS, MAX_RUN_POINTS, MAX_SHARDED_POINTS};
use crate::bounds::{ANY, inside};
use crate::columns;
use crate::derivation::{self, Derivation};
use crate::error::{Mistake, StudyError, are_enough};
use crate::exclusion::{self, Exclusion};
use crate::fallback::Fallback::{self, Follows, Needed};
use crate::figure;
use crate::job::Job;
use crate::key::{Key, Table};
use crate::kind::convergence::Ladder;
use crate::kind::cost::is_rung;
use crate::kind::{Kind, KindTable};
use crate::points_file::{self, FilePoints};
use crate::quantity::one_of;
use crate::read::{self, Reader, entries};
use crate::sample::ReadColumn;
use crate::sheet::{Given, TablePlaces};
use crate::study::{Study, of_sample};
use crate::study_files::{ReadFile, StudyFiles};
use crate::suggestion::{nearest, standing_elsewhere};
use crate::sweep::JoinedBlocks;
use crate::table_key::{KeyTable, NAME, PART, TEXT, TableValue, table_key};
use crate::units::Dimension;
use crate::{accuracy, sample, sweep};

/// The keys at the top of a study that are no tables.
pub(crate) const TOP: KeyTable = KeyTable {
    path: "",
    is_list: false,
    meaning: "the top of the file",
    keys: &[
        table_key("name", NAME, ANY, Needed, "\"stick-zone\"", "name under which results are kept"),
        table_key(
            "question",
            TEXT,
            ANY,
            Follows("no question"),
            "\"How large is the zone that sticks?\"",
            "question that the study answers, the title of its figures",
        ),
        table_key(
            "kind",
            TableValue::Word(Kind::NAMES),
            ANY,
            Fallback::Word(Kind::NAMES[0]),
            "\"uniqueness\"",
            "what is asked about each point",
        ),
        table_key(
            "accuracy",
            PART,
            inside(0.0, 1.0),
            Follows("`numerics.mesh` must be given"),
            "\"0.1%\"",
            "accuracy that each point is to have, in place of a mesh; as a table `[accuracy]` with \
             more to say",
        ),
    ],
};

/// Returns the tables of a study file beside those of the scene and its numerics. Those at the top
/// of the file are in the order in which messages list them.
pub(crate) fn tables() -> Vec<KeyTable> {
    let before_kinds = [
        accuracy::TABLE,
        points_file::TABLE,
        sweep::TABLE,
        sweep::ZIP,
        sweep::RANGE,
        sample::TABLE,
        sample::DRAWN,
        sample::DISTRIBUTION,
        derivation::TABLE,
    ];
    let rules = adaptive::TABLES.into_iter().copied();
    let tables = before_kinds.into_iter().chain(exclusion::TABLES).chain(rules);
    tables.chain(Kind::tables()).chain([figure::table::TABLE]).collect()
}

/// Returns the names that may stand at the top of a study.
fn names() -> Vec<&'static str> {
    let mut names = TOP.names();
    let of_scene = Table::ALL.iter().map(|table| table.pattern);
    for path in of_scene.chain(tables().into_iter().map(|table| table.path)) {
        if !path.contains('.') && !names.contains(&path) {
            names.push(path);
        }
    }
    names
}

/// A question whether all points of a study were found to make sense before.
pub type IsKnown<'a> = &'a mut dyn FnMut(&Study) -> bool;

impl Study {
    /// Reads a study's text. `path` is for messages. `files` reads a file that the study names (a
    /// height map), with the name as the study writes it, or a stored surface by its hash.
    ///
    /// # Errors
    ///
    /// Returns every mistake in the text, with its place.
    pub fn parse(text: &str, path: &str, files: &mut ReadFile<'_>) -> Result<Study, StudyError> {
        Study::parse_known(text, path, files, &mut |_| false)
    }

    /// Reads a study's text like [`parse`](Study::parse), but assembles no job to check it if the
    /// study `is_known`: this version of the program has found before that all its points make
    /// sense. What is asked about the study may be its name and its definition.
    ///
    /// # Errors
    ///
    /// Returns every mistake in the text, with its place.
    pub fn parse_known(
        text: &str,
        path: &str,
        files: &mut ReadFile<'_>,
        is_known: IsKnown<'_>,
    ) -> Result<Study, StudyError> {
        parse(text, path, files, false, is_known)
            .map_err(|mistakes| StudyError::new(path, text, mistakes))
    }

    /// Reads the text of a study that is run in shards, like [`parse`](Study::parse). It may have
    /// more points than one run takes; then only those along each axis are checked here, and those
    /// of a shard by [`restricted`](Study::restricted).
    ///
    /// # Errors
    ///
    /// Returns every mistake in the text, with its place.
    pub fn parse_sharded(
        text: &str,
        path: &str,
        files: &mut ReadFile<'_>,
    ) -> Result<Study, StudyError> {
        parse(text, path, files, true, &mut |_| false)
            .map_err(|mistakes| StudyError::new(path, text, mistakes))
    }

    /// Reads the text of a study like [`parse_sharded`](Study::parse_sharded). This version of the
    /// program has found before that all its points make sense.
    pub(crate) fn parse_found_sound(
        text: &str,
        path: &str,
        files: &mut ReadFile<'_>,
    ) -> Result<Study, StudyError> {
        parse(text, path, files, true, &mut |_| true)
            .map_err(|mistakes| StudyError::new(path, text, mistakes))
    }

    /// Reads the height maps and profiles that any point needs, each once.
    fn read_surfaces(&mut self, files: &mut ReadFile<'_>) -> Vec<Mistake> {
        let names_files = |key: Key| {
            matches!(key, Key::Shape | Key::File | Key::Surface | Key::Wheel | Key::Rail)
                || HEIGHT_MAP.contains(&key)
        };
        // Only these groups decide which files are needed; the others stay at their first step.
        let deciding: Vec<bool> = self
            .groups
            .iter()
            .map(|group| axis::keys(&[], std::slice::from_ref(group)).any(names_files))
            .collect();
        let combinations = self
            .groups
            .iter()
            .zip(&deciding)
            .filter(|(_, deciding)| **deciding)
            .try_fold(1usize, |product, (group, _)| product.checked_mul(group.length));
        if combinations.is_none_or(|combinations| combinations > MAX_POINTS) {
            let span = self.axes().next().map_or(0..0, |axis| axis.span.clone());
            let message = format!("the axes combine files in more than {MAX_POINTS} ways");
            return vec![Mistake::new(span, message, "needs fewer values on the axes over files")];
        }
        let mut steps = vec![0; self.groups.len()];
        let mut mistakes = Vec::new();
        loop {
            // The files are read into the study, from which a sheet borrows. One bad file is one
            // mistake, however many points use it.
            let needed = self.sheet(&steps).needed_files();
            mistakes
                .extend(needed.into_iter().filter_map(|file| self.files.read(file, files).err()));
            let counted = self.groups.iter().zip(&deciding).zip(&mut steps).rev();
            let mut is_further = false;
            for ((group, _), step) in counted.filter(|((_, deciding), _)| **deciding) {
                *step = (*step + 1) % group.length;
                if *step > 0 {
                    is_further = true;
                    break;
                }
            }
            if !is_further || are_enough(&mistakes) {
                return mistakes;
            }
        }
    }

    /// Returns jobs along each axis with the others at their first value, some of each axis.
    fn samples(&self) -> Vec<Job> {
        /// Scenes that prescribe one thing here and another there are told by a few.
        const PER_AXIS: usize = 64;
        let mut jobs = Vec::new();
        let mut steps = vec![0; self.groups.len()];
        let job = |steps: &[usize]| self.job(steps).ok().filter(|_| self.has(steps));
        jobs.extend(job(&steps));
        for (varied, group) in self.groups.iter().enumerate() {
            let count = group.length.min(PER_AXIS);
            for sample in 1..count {
                steps[varied] = sample * (group.length - 1) / (count - 1);
                jobs.extend(job(&steps));
            }
            steps[varied] = 0;
        }
        jobs
    }

    /// Refuses a distribution that reaches values without meaning: each drawn key is taken as far
    /// as any point can be, with the others at their medians and the axes at the first values that
    /// the conditions keep there. What they leave out further out need not make sense.
    fn check_reach(&self) -> Result<(), Vec<Mistake>> {
        /// The least part that a design draws.
        const LEAST: f64 = 1.0 / (1_u64 << 53) as f64;
        let Some(group) = self.sample() else { return Ok(()) };
        let middle = vec![0.5; group.axes.len()];
        let combinations = (0..self.points).step_by(group.length).take(TRIED_POINTS);
        let mut kept = combinations.map(|index| axis::steps(&self.groups, index));
        let found = kept.find_map(|steps| Some((self.mistakes_drawn(&steps, &middle)?, steps)));
        let Some((at_middle, steps)) = found else { return Ok(()) };
        if !at_middle.is_empty() {
            // What is wrong there as well is no fault of a distribution's ends.
            return Ok(());
        }
        let mut mistakes = Vec::new();
        for (index, axis) in group.axes.iter().enumerate() {
            for part in [LEAST, 1.0 - LEAST] {
                let mut parts = middle.clone();
                parts[index] = part;
                let wrong = self.mistakes_drawn(&steps, &parts).unwrap_or_default();
                mistakes.extend(wrong.into_iter().map(|mistake| axis.beyond(part, mistake)));
            }
        }
        if mistakes.is_empty() { Ok(()) } else { Err(mistakes) }
    }

    /// Assembles every point of a study that is taken as a `whole`. If one cannot be assembled, it
    /// goes along each axis with the others at their first value, which reports each bad value
    /// once.
    fn check(&self, whole: bool) -> Result<(), Vec<Mistake>> {
        let check = |index| self.job(&axis::steps(&self.groups, index)).err();
        let first = match whole {
            true => self.indices().collect::<Vec<_>>().into_par_iter().find_map_first(check),
            false => None,
        };
        if whole && first.is_none() {
            return Ok(());
        }
        let mut mistakes = Vec::new();
        for (varied, group) in self.groups.iter().enumerate().filter(|(_, group)| group.length > 1)
        {
            let mut steps = vec![0; self.groups.len()];
            // A plan or a shard checks its own points of a sample that cannot be listed.
            let length = match group.design {
                Some(_) if !self.is_listed() => group.length.min(TRIED_POINTS),
                _ => group.length,
            };
            for step in 0..length {
                steps[varied] = step;
                if !self.has(&steps) {
                    continue;
                }
                // What is wrong with a formula is told of the first point alone.
                let is_known = |wrong: &Mistake| {
                    let mut known = mistakes.iter();
                    known.any(|known: &Mistake| {
                        known.span == wrong.span && known.message == wrong.message
                    })
                };
                let mut wrong = self.job(&steps).err().unwrap_or_default();
                wrong.retain(|wrong| !is_known(wrong));
                let known = mistakes.len();
                match group.design {
                    Some(_) => {
                        mistakes.extend(wrong.into_iter().map(|mistake| of_sample(mistake, step)));
                    }
                    None => mistakes.extend(wrong),
                }
                // What is wrong with one point of a sample is wrong with many.
                if are_enough(&mistakes) || group.design.is_some() && mistakes.len() > known {
                    break;
                }
            }
        }
        match first {
            _ if !mistakes.is_empty() => Err(mistakes),
            Some(first) => Err(first),
            None => Ok(()),
        }
    }
}

fn parse(
    text: &str,
    path: &str,
    files: &mut ReadFile<'_>,
    shards: bool,
    is_known: IsKnown<'_>,
) -> Result<Study, Vec<Mistake>> {
    // Only the first error is asked for: what follows is mostly its echo, and may be very much.
    let root = DeTable::parse(text).map_err(|error| {
        let expected =
            if error.message() == "duplicate key" { "may be given only once" } else { "" };
        vec![Mistake::new(
            error.span().unwrap_or(0..0),
            format!("not valid TOML: {}", error.message()),
            expected,
        )]
    })?;
    let root = root.into_inner();
    let mut mistakes = Vec::new();
    refuse_unknown(&root, &mut mistakes);
    let name = read_name(&root, &mut mistakes);
    let question = read_text(&root, "question", &mut mistakes).unwrap_or_default();
    let kind = read_kind(&root, &mut mistakes);
    let (mut base, places) = read_base(text, &root, &mut mistakes);
    let mut read_files = StudyFiles::default();
    let points = root.get("points").and_then(|node| {
        let results = kind.columns([], []);
        let is_result = |name: &str| columns::find(&results, name).is_some();
        points_file::read_points(node, &mut read_files, files, &is_result, &mut mistakes)
    });
    let (of_file, mut remarks) = match points {
        Some(FilePoints { group, remarks }) => (Some(group), remarks),
        None => (None, Vec::new()),
    };
    let mut column = |name: &str, column: &str, dimension: Dimension| {
        read_files.read_column(name, column, dimension, files)
    };
    let JoinedBlocks { group: of_blocks, remarks: of_joining } =
        match root.get("sweep").map(|node| node.get_ref()) {
            Some(DeValue::Array(blocks)) => {
                sweep::read_blocks(text, blocks.iter(), &base, &mut mistakes).unwrap_or_default()
            }
            _ => JoinedBlocks::default(),
        };
    remarks.extend(of_joining);
    let listed: Vec<Group> = of_file.into_iter().chain(of_blocks).collect();
    let mut groups = read_groups(text, &root, listed, shards, &mut column, &mut mistakes);
    let accuracy = root
        .get("accuracy")
        .and_then(|node| accuracy::read(node, kind, &base, &groups, &mut mistakes));
    let chosen = accuracy.iter().map(accuracy::Accuracy::first_mesh);
    let first_chosen = base.len();
    base.extend(chosen);
    let mut kind_table = kind.read_table(&root, &groups, &mut mistakes);
    if mistakes.is_empty() {
        kind.arrange(&root, &adaptive::RULES, &kind_table, &mut groups, &mut mistakes);
        mistakes.extend(sweep::too_many_points(&groups, most_points(&groups, shards)));
    }
    let before = mistakes.len();
    sweep::refuse_absent(&groups, &base, &mut mistakes);
    sweep::refuse_alternatives(&groups, &base, &mut mistakes);
    // Those of a shard are counted when it is taken.
    let known = axis::count(&groups).filter(|points| *points <= MAX_RUN_POINTS).unwrap_or(0);
    let points = if shards { 1 } else { known };
    mistakes.extend(sweep::too_many_entries(&groups, &base, points));
    if mistakes.len() > before {
        // Entries have columns, and an index that is far off would make thousands of millions of
        // them.
        return Err(mistakes);
    }
    let derivation = root
        .get("derive")
        .map(|node| {
            let (given, chosen) = base.split_at(first_chosen);
            let chosen: Vec<Key> = chosen.iter().map(|(key, _)| *key).collect();
            derivation::read(node, given, &chosen, &groups, &mut mistakes)
        })
        .unwrap_or_default();
    let keys = || axis::keys(&base, &groups).chain(derivation.keys());
    let columns = kind.columns(groups.iter().flat_map(Group::axes), keys());
    kind.read_columns(&root, &columns, &mut kind_table, &mut mistakes);
    let figures = root
        .get("figure")
        .map(|node| figure::table::read_figures(node, &groups, &columns, &mut mistakes));
    let adaptive = adaptive::read(&root, kind, &base, &groups, &columns, &mut mistakes);
    let adaptive = adaptive.or(accuracy.map(Adaptive::Accuracy));
    let exclusion = exclusion::read(&root, &base, &groups, keys(), &columns, &mut mistakes);
    if let (Some(exclusion), Kind::Sensitivity) = (&exclusion, kind) {
        let message = "a study of sensitivity needs every point of its design";
        let mistake = Mistake::new(exclusion.place(), message, "leave this out");
        mistakes.push(mistake.help("narrow the ranges of `[sample]` to what makes sense"));
    }
    if let (Some(exclusion), Some(adaptive)) = (&exclusion, &adaptive) {
        mistakes.extend(refuse_chosen(exclusion, adaptive, &groups, &derivation));
    }
    if let Some(exclusion) = &exclusion {
        mistakes.extend(refuse_rungs(exclusion, kind, &kind_table, &groups, &derivation));
    }
    mistakes.extend(adaptive.as_ref().and_then(|rule| refuse_derived_mesh(rule, &derivation)));
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    let mut study = Study {
        adaptive,
        kind_table,
        name,
        question,
        kind,
        figures: Vec::new(),
        suggestions: Vec::new(),
        points: axis::count(&groups).unwrap_or(0),
        part: None,
        exclusion,
        excluded: 0,
        remarks,
        is_checked: false,
        groups,
        base,
        derivation,
        places,
        files: read_files,
        path: path.to_owned(),
        text: text.to_owned(),
    };
    if !shards && !study.is_one_run() {
        // What the study draws, chooses, leaves out or compares is known now.
        let most = study.most_points();
        return Err(sweep::too_many_points(&study.groups, most).into_iter().collect());
    }
    let unreadable = study.read_surfaces(files);
    if !unreadable.is_empty() {
        return Err(unreadable);
    }
    study.leave_out().map_err(|mistake| vec![mistake])?;
    study.check_reach()?;
    let is_whole = study.is_listed() || !shards;
    if !is_known(&study) {
        study.check(is_whole)?;
    }
    study.is_checked = is_whole;
    study.suggestions = match &figures {
        Some(_) => Vec::new(),
        // Its columns have the bracket that weights alone show, and not what branches make of it.
        None if matches!(study.adaptive, Some(Adaptive::Branch { .. })) => Vec::new(),
        None => {
            let of_rule = study.adaptive.as_ref().and_then(|rule| rule.figure(&study.groups));
            let of_kind = kind.suggestions(&study.kind_table, &study.groups, &study.samples());
            of_rule.into_iter().chain(of_kind).collect()
        }
    };
    study.figures =
        figures.unwrap_or_else(|| study.suggestions.first().cloned().into_iter().collect());
    Ok(study)
}

/// The number of points of a sample that are checked when a study is read that cannot be listed.
const TRIED_POINTS: usize = 1000;

/// Reads `[sweep]` and `[sample]`, whose points are the fastest group, and brings the groups into
/// the order of the file, with those of a file of points and of `[[sweep]]`, which are `listed`,
/// among them.
fn read_groups(
    text: &str,
    root: &DeTable<'_>,
    listed: Vec<Group>,
    shards: bool,
    column: &mut ReadColumn<'_>,
    mistakes: &mut Vec<Mistake>,
) -> Vec<Group> {
    let before = mistakes.len();
    let table = root.get("sweep").filter(|node| !matches!(node.get_ref(), DeValue::Array(_)));
    let sweep = table.map(|node| sweep::read_sweep(text, node, mistakes));
    let sample = root.get("sample").and_then(|node| sample::read_sample(node, column, mistakes));
    let mut groups: Vec<Group> = sweep.into_iter().flatten().chain(listed).collect();
    // Keys that are written with dots arrive gathered by their tables, but their places count.
    groups.sort_by_key(|group| group.axes.first().map(|axis| axis.span.start));
    groups.extend(sample);
    sweep::refuse_overlaps(&groups, mistakes);
    if mistakes.len() == before {
        mistakes.extend(sweep::too_many_points(&groups, most_points(&groups, shards)));
    }
    groups
}

/// Returns the largest number of points that groups may make, as far as they say. One that is run
/// in `shards` may have more than one run takes.
fn most_points(groups: &[Group], shards: bool) -> usize {
    match groups.iter().any(|group| group.design.is_some()) {
        _ if shards => MAX_SHARDED_POINTS,
        true => MAX_POINTS,
        false => MAX_RUN_POINTS,
    }
}

/// Refuses a condition over a key whose values the study chooses by its results: what it leaves out
/// is decided before.
fn refuse_chosen(
    exclusion: &Exclusion,
    adaptive: &Adaptive,
    groups: &[Group],
    derivation: &Derivation,
) -> Option<Mistake> {
    let axes: Vec<&axis::SweepAxis> = groups.iter().flat_map(Group::axes).collect();
    let mut chosen: Vec<Key> =
        adaptive.axes().iter().filter_map(|axis| axes[*axis].key()).collect();
    if matches!(adaptive, Adaptive::Accuracy(_) | Adaptive::Refine { .. }) {
        chosen.push(Key::Mesh);
    }
    let found = chosen.into_iter().find_map(|chosen| {
        let depends = |key| key == chosen || derivation.follows(key, chosen);
        Some((exclusion.using(depends)?, chosen))
    });
    let (span, chosen) = found?;
    let message = format!("the study chooses values of `{}` as it goes", chosen.short());
    Some(Mistake::new(span, message, "cannot depend on it"))
}

/// Refuses a condition over a key that tells the rungs of a ladder apart: limits and fronts are
/// made of whole ladders.
fn refuse_rungs(
    exclusion: &Exclusion,
    kind: Kind,
    table: &KindTable,
    groups: &[Group],
    derivation: &Derivation,
) -> Option<Mistake> {
    let ladder = Ladder::of(table, groups).filter(|_| kind == Kind::Convergence);
    let makes_rungs = |index: usize| match kind {
        Kind::Cost => is_rung(&groups[index]),
        _ => ladder.is_some_and(|ladder| ladder.group == index),
    };
    let of_rungs = (0..groups.len()).filter(|index| makes_rungs(*index));
    let mut keys = of_rungs.flat_map(|index| axis::keys(&[], std::slice::from_ref(&groups[index])));
    let found = keys.find_map(|rung| {
        let depends = |key| key == rung || derivation.follows(key, rung);
        Some((exclusion.using(depends)?, rung))
    });
    let (span, rung) = found?;
    let message =
        format!("a study of kind \"{}\" needs every rung along `{}`", kind.name(), rung.short());
    let mistake = Mistake::new(span, message, "cannot depend on it");
    Some(mistake.help("leave values out of the axis itself"))
}

/// Refuses to derive the mesh in a study that chooses meshes.
fn refuse_derived_mesh(rule: &Adaptive, derivation: &Derivation) -> Option<Mistake> {
    let span = derivation.place(Key::Mesh)?;
    match rule {
        Adaptive::Accuracy(accuracy) => {
            let message = "a study has either a mesh or an accuracy";
            let mistake = Mistake::new(span, message, "leave one of the two out");
            Some(mistake.context(accuracy.place(), "which chooses the mesh"))
        }
        Adaptive::Refine { .. } => {
            let message = "`mesh` cannot be derived in a study that refines";
            let mistake = Mistake::new(span, message, "must be given by the scene");
            Some(mistake.help("[refine] chooses meshes from numerics.mesh on"))
        }
        _ => None,
    }
}

/// Notes the names at the top of a study that mean nothing there.
fn refuse_unknown(root: &DeTable<'_>, mistakes: &mut Vec<Mistake>) {
    let known = names();
    let is_unknown = |name: &read::Name<'_>| !known.contains(&name.get_ref().as_ref());
    for (name, _) in entries(root).into_iter().filter(|(name, _)| is_unknown(name)) {
        if are_enough(mistakes) {
            return;
        }
        let mistake = read::unknown(name.get_ref(), name.span(), "the study", &known);
        mistakes.push(match standing_elsewhere(name.get_ref(), "") {
            Some(path) if mistake.help.is_empty() => mistake.instead(&path),
            _ => mistake,
        });
    }
}

fn read_base(
    text: &str,
    root: &DeTable<'_>,
    mistakes: &mut Vec<Mistake>,
) -> (Vec<(Key, Given)>, TablePlaces) {
    let mut reader = Reader::new(text, mistakes);
    for (name, node) in entries(root) {
        match (
            Table::find(name.get_ref()).filter(|table| table.path() == name.get_ref().as_ref()),
            node.get_ref(),
        ) {
            (Some(table), DeValue::Table(below)) => {
                reader.table(table, node.span(), entries(below))
            }
            (Some(table), _) => {
                reader.mistakes.push(read::mistyped(&table.path(), node, &table.expected()));
            }
            (None, _) => {}
        }
    }
    (reader.given, reader.places)
}

fn read_text(root: &DeTable<'_>, name: &str, mistakes: &mut Vec<Mistake>) -> Option<String> {
    read::text(name, root.get(name)?).map_err(|mistake| mistakes.push(mistake)).ok()
}

fn read_name(root: &DeTable<'_>, mistakes: &mut Vec<Mistake>) -> String {
    let Some(node) = root.get("name") else {
        mistakes.push(Mistake::new(
            0..0,
            "the study has no name",
            "needs name = \"…\", under which its results are kept",
        ));
        return String::new();
    };
    let name = read_text(root, "name", mistakes).unwrap_or_default();
    if matches!(node.get_ref(), DeValue::String(_)) {
        mistakes.extend(read::refuse_file_name(&name, "a study", node));
    }
    name
}

fn read_kind(root: &DeTable<'_>, mistakes: &mut Vec<Mistake>) -> Kind {
    let (Some(name), Some(node)) = (read_text(root, "kind", mistakes), root.get("kind")) else {
        return Kind::default();
    };
    Kind::find(&name).unwrap_or_else(|| {
        let mistake = |expected: &str| {
            Mistake::new(node.span(), format!("unknown kind of study `{name}`"), expected)
        };
        let listed = format!("must be {}", one_of(Kind::NAMES));
        mistakes.push(match nearest(&name, Kind::NAMES.iter().copied()) {
            Some(suggestion) => mistake(&format!("did you mean \"{suggestion}\"?")).help(listed),
            None => mistake(&listed),
        });
        Kind::default()
    })
}
