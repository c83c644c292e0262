//! The one list of columns. A name means the same in a study file's `[figure]`, in a query, in an export and in a plot.
//!
//! A column is named by an identifier: for a key of the scene or the numerics the one that [`Key::column`] gives,
//! whatever else the study varies. An axis over a whole table has the table's column and shows the labels.
//!
//! Results are those at the end of the loading path, except where a column's meaning says that it is of the whole path. In a
//! table of increments ([`along_path`], [`Record::along_path`]) each row is what the result would be if the path ended there.

use std::borrow::Cow;
use std::collections::HashSet;
use std::fmt;
use std::time::{Duration, SystemTime};

use contact::estimate::Estimate;
use contact::multiplicity::{Multiplicity, Solution};
use contact::numerics::Mesh;
use contact::outcome::{Hertz, Observables, Outcome, RailContact, StepOutcome};
use contact::reference::Errors;
use contact::uniqueness::Bracket;
use contact::uniqueness::lower::LowerBound;
use contact::uniqueness::witness::Witness;

use crate::axis::Axis;
use crate::file::Point;
use crate::key::Key;
use crate::kind::Kind;
use crate::record::{Bracketed, Record};
use crate::settings;
use crate::sheet::Setting;
use crate::units::{Compact, Dimension};

/// A cell of a table, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A whole number.
    Integer(u64),
    /// A text.
    Text(String),
    /// Nothing: the job has no such key, or it left no such figure.
    Missing,
}

impl Value {
    /// The number, whole or not; `None` for texts and where it is missing.
    pub fn as_f64(&self) -> Option<f64> {
        match self {
            Value::Number(x) => Some(*x),
            Value::Integer(n) => Some(*n as f64),
            Value::Text(_) | Value::Missing => None,
        }
    }
}

/// Numbers in their shortest exact form; nothing for what is missing.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Number(x) => write!(f, "{}", Compact(*x)),
            Value::Integer(n) => write!(f, "{n}"),
            Value::Text(text) => f.write_str(text),
            Value::Missing => Ok(()),
        }
    }
}

impl From<&Setting> for Value {
    fn from(setting: &Setting) -> Self {
        match setting {
            Setting::Number(x) => Value::Number(*x),
            Setting::Count(n) | Setting::Mesh(Mesh::Across(n)) => Value::Integer(u64::from(*n)),
            Setting::Mesh(Mesh::Exact([x, y])) => Value::Text(format!("{x}x{y}")),
            Setting::Word(word) => Value::Text(word.clone()),
            Setting::Effects(effects) if effects.is_empty() => Value::Missing,
            Setting::Effects(effects) => Value::Text(effects.iter().map(|effect| effect.name()).collect::<Vec<_>>().join(" ")),
        }
    }
}

/// Where a column's values come from, which is also how tables group them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// An axis of the study.
    Axis,
    /// A key of the scene or the numerics that the study does not vary.
    Key,
    /// Whether and how the job ended.
    Status,
    /// Where on its loading path an increment stands; only tables of increments have it.
    Place,
    /// A quantity of the solution.
    Observable,
    /// A residual of the solution.
    Certificate,
    /// How far it is from what it is compared with.
    Error,
    /// What solving took, in deterministic counts.
    Work,
    /// Who computed it, when and how fast; differs from run to run.
    Provenance,
}

/// A column.
#[derive(Clone, Debug)]
pub struct Column {
    /// Its name, an identifier.
    pub name: Cow<'static, str>,
    /// What it measures; the values are in [`Dimension::unit`].
    pub dimension: Dimension,
    /// Where its values come from.
    pub role: Role,
    /// What it means, in words.
    pub meaning: &'static str,
    source: Source,
}

/// What a row of a table is made of.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// The point.
    pub point: &'a Point,
    /// What its job left, if it left something yet.
    pub record: Option<&'a Record>,
    /// How far that is from what it is compared with.
    pub compared: Option<&'a Compared>,
}

/// How far a solution is from what it is compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// Relative errors.
    pub errors: Errors,
    /// What they are measured against, in words.
    pub reference: String,
    /// Of a study of cost, the relative error that can be relied on.
    pub claim: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
enum Source {
    Axis { index: usize, is_numeric: bool },
    Key(Key),
    JobKey,
    Record(fn(&Record) -> Value),
    Outcome(fn(&Outcome) -> Value),
    End(fn(&StepOutcome) -> Value),
    Observed(fn(&Observables) -> Value),
    Multiplicity(fn(&Multiplicity) -> Value),
    Bracketed(fn(&Bracketed) -> Value),
    Error(usize),
    Claim,
    Reference,
}

impl Column {
    /// Symbol of the SI unit of its values; empty for pure numbers and texts.
    pub fn unit(&self) -> &'static str {
        self.dimension.unit()
    }

    /// Its value for a point and the record that the point's job left, if it left one yet.
    pub fn value(&self, point: &Point, record: Option<&Record>) -> Value {
        self.value_of(&Row { point, record, compared: None })
    }

    /// Its value for a row.
    pub fn value_of(&self, Row { point, record, compared }: &Row<'_>) -> Value {
        let record = *record;
        let end = || record.and_then(Record::outcome).and_then(Outcome::last);
        match self.source {
            Source::Axis { index, .. } => point.values.get(index).cloned().unwrap_or(Value::Missing),
            Source::Key(key) => settings::setting(&point.job, key).map_or(Value::Missing, |setting| Value::from(&setting)),
            Source::JobKey => Value::Text(point.key.to_string()),
            Source::Record(read) => record.map_or(Value::Missing, read),
            Source::Outcome(read) => record.and_then(Record::outcome).map_or(Value::Missing, read),
            Source::End(read) => end().map_or(Value::Missing, read),
            Source::Observed(read) => end().map_or(Value::Missing, |end| read(&end.observables)),
            Source::Error(which) => compared.and_then(|compared| compared.errors.to_array()[which]).map_or(Value::Missing, Value::Number),
            Source::Claim => compared.and_then(|compared| compared.claim).map_or(Value::Missing, Value::Number),
            Source::Reference => compared.map_or(Value::Missing, |compared| Value::Text(compared.reference.clone())),
            Source::Bracketed(read) => record.and_then(Record::bracketed).map_or(Value::Missing, read),
            Source::Multiplicity(read) => record.and_then(Record::multiplicity).map_or(Value::Missing, read),
        }
    }

    /// Whether its values are numbers, apart from missing ones.
    pub fn is_numeric(&self) -> bool {
        match self.source {
            Source::Key(key) => key.quantity().is_numeric(),
            Source::Axis { is_numeric, .. } => is_numeric,
            Source::JobKey | Source::Reference => false,
            Source::Error(_) | Source::Claim => true,
            Source::Record(_)
            | Source::Outcome(_)
            | Source::End(_)
            | Source::Observed(_)
            | Source::Multiplicity(_)
            | Source::Bracketed(_) => !TEXTS.contains(&self.name.as_ref()),
        }
    }
}

/// The columns of a study of this kind with these axes, in order: the axes, the other keys, then what the records hold.
/// Without axes and keys, the columns of any record. `keys` are those that the study gives; those of the numerics, which have
/// defaults, have columns anyway.
pub fn columns<'a>(kind: Kind, axes: impl IntoIterator<Item = &'a Axis>, keys: impl IntoIterator<Item = Key>) -> Vec<Column> {
    let mut columns: Vec<Column> = Vec::new();
    for (index, axis) in axes.into_iter().enumerate() {
        let (dimension, meaning) = axis.key().map_or((Dimension::Pure, "label of the table"), |key| (key.dimension(), key.meaning()));
        let is_numeric = axis.key().is_some_and(|key| key.quantity().is_numeric());
        columns.push(Column { name: axis.column(), dimension, role: Role::Axis, meaning, source: Source::Axis { index, is_numeric } });
    }
    let listed: HashSet<Key> = keys.into_iter().collect();
    let length = |list| listed.iter().filter(|key| key.list() == Some(list)).filter_map(|key| Some(key.index()? + 1)).max().unwrap_or(0);
    for key in Key::all(length) {
        // a height map is given as a file, a job has its hash
        let is_given = listed.contains(&key) || key == Key::Surface && listed.contains(&Key::File);
        let has_default = ["numerics.", "search."].iter().any(|table| key.path().starts_with(table));
        let is_there = (is_given || has_default) && kind.refuses(key).is_none();
        let is_input = matches!(key, Key::File | Key::HeightUnit);
        if is_there && !is_input && !columns.iter().any(|column| column.name == key.column()) {
            let (name, dimension, meaning) = (key.column(), key.dimension(), key.meaning());
            columns.push(Column { name, dimension, role: Role::Key, meaning, source: Source::Key(key) });
        }
    }
    columns.extend_from_slice(ENDING);
    columns.extend_from_slice(match kind {
        Kind::Solve | Kind::Convergence | Kind::Cost => SOLUTION,
        Kind::Multiplicity => SEARCH,
        Kind::Uniqueness => BRACKET,
    });
    if matches!(kind, Kind::Convergence | Kind::Cost) {
        columns.extend_from_slice(ERRORS);
    }
    if kind == Kind::Cost {
        columns.extend_from_slice(CLAIM);
    }
    columns.extend_from_slice(PROVENANCE);
    columns
}

/// The columns of a table of increments, one row for each ([`Record::along_path`]): the axes, where on the path it stands, and the rest.
pub fn along_path(columns: Vec<Column>) -> Vec<Column> {
    let (axes, mut rest): (Vec<Column>, Vec<Column>) = columns.into_iter().partition(|column| column.role == Role::Axis);
    // here a number of increments is the number of the increment
    rest.retain(|column| column.name != "increments");
    axes.into_iter().chain(PLACE.iter().cloned()).chain(rest).collect()
}

/// The column of this name, or of the key with this path, short or from the top.
pub fn find<'a>(columns: &'a [Column], name: &str) -> Option<&'a Column> {
    let of_path = Key::find(name).map(Key::column);
    columns.iter().find(|column| column.name == name).or_else(|| columns.iter().find(|column| Some(&column.name) == of_path.as_ref()))
}

/// The columns of results whose values are texts.
const TEXTS: &[&str] = &["status", "reason", "way", "program", "unbounded", "finished"];

macro_rules! results {
    ($($role:ident $name:literal $dimension:ident $meaning:literal $source:expr;)*) => {
        &[$(Column {
            name: Cow::Borrowed($name),
            dimension: Dimension::$dimension,
            role: Role::$role,
            meaning: $meaning,
            source: $source,
        },)*]
    };
}

macro_rules! number {
    ($($part:ident).+) => {
        Source::End(|end| Value::Number(end.$($part).+))
    };
}

macro_rules! integer {
    ($($part:ident).+) => {
        Source::End(|end| Value::Integer(end.$($part).+ as u64))
    };
}

/// The columns that only tables of increments have.
const PLACE: &[Column] = results! {
    Place "step" Pure "index of the load step" integer!(step);
    Place "cycle" Pure "which time the cycle is run through, counted from 1; 0 outside of one" integer!(cycle);
    Place "increment" Pure "number of the increment along the path, counted from 1" Source::Outcome(increments);
};

/// The columns that every record has, first.
const ENDING: &[Column] = results! {
    Status "key" Pure "identity of the job" Source::JobKey;
    Status "status" Pure "certified, failed or quarantined" Source::Record(|record| Value::Text(record.status().to_owned()));
    Status "reason" Pure "why it failed" Source::Record(reason);
};

/// The columns of solutions.
const SOLUTION: &[Column] = results! {
    Status "increments" Pure "increments of the loading path that were solved" Source::Outcome(increments);
    Observable "at_approach" Length "approach that was reached" number!(motion.approach);
    Observable "at_shift_x" Length "shift along x that was reached" number!(motion.shift_x);
    Observable "at_shift_y" Length "shift along y that was reached" number!(motion.shift_y);
    Observable "at_tilt_x" Angle "tilt about x that was reached" number!(motion.tilt_x);
    Observable "at_tilt_y" Angle "tilt about y that was reached" number!(motion.tilt_y);
    Observable "at_twist" Angle "twist that was reached" number!(motion.twist);
    Observable "load" Force "normal force" number!(observables.load);
    Observable "force_x" Force "tangential force along x" number!(observables.force_x);
    Observable "force_y" Force "tangential force along y" number!(observables.force_y);
    Observable "moment_x" Moment "moment about x" number!(observables.moment_x);
    Observable "moment_y" Moment "moment about y" number!(observables.moment_y);
    Observable "moment_z" Moment "moment about z" number!(observables.moment_z);
    Observable "contact_x" Length "x of the centre of pressure" Source::Observed(|o| ratio(-o.moment_y, o.load));
    Observable "contact_y" Length "y of the centre of pressure" Source::Observed(|o| ratio(o.moment_x, o.load));
    Observable "contact_area" Area "area in contact" number!(observables.contact_area);
    Observable "stick_area" Area "area in contact that sticks" number!(observables.stick_area);
    Observable "slip_area" Area "area in contact that slips" number!(observables.slip_area);
    Observable "stick_fraction" Pure "stick area over contact area" Source::Observed(|o| ratio(o.stick_area, o.contact_area));
    Observable "contact_radius" Length "radius of the disk of the contact area" Source::Observed(|o| Value::Number((o.contact_area / std::f64::consts::PI).sqrt()));
    Observable "patches" Pure "separate regions in contact" integer!(observables.patches);
    Observable "sole_area" Area "area that could be in contact" number!(observables.sole_area);
    Observable "separated_area" Area "area that could be in contact and is not" Source::Observed(|o| Value::Number(o.sole_area - o.contact_area));
    Observable "separated_fraction" Pure "separated area over the area that could be in contact" Source::Observed(|o| ratio(o.sole_area - o.contact_area, o.sole_area));
    Observable "largest_gap" Length "largest gap where contact could be" number!(observables.largest_gap);
    Observable "contact_elements" Pure "elements in contact" integer!(observables.contact_elements);
    Observable "stick_elements" Pure "elements that stick" integer!(observables.stick_elements);
    Observable "slip_elements" Pure "elements that slip" integer!(observables.slip_elements);
    Observable "peak_pressure" Pressure "largest pressure" number!(observables.peak_pressure);
    Observable "peak_traction" Pressure "largest tangential traction" number!(observables.peak_traction);
    Observable "energy" Energy "elastic energy" number!(observables.energy);
    Observable "dissipation" Energy "energy lost to friction in the last increment" number!(observables.dissipation);
    Observable "total_dissipation" Energy "energy lost to friction along the whole path" Source::Outcome(|outcome| Value::Number(outcome.dissipation()));
    Observable "cycle_dissipation" Energy "energy lost to friction in the last cycle" Source::Outcome(cycle_dissipation);
    Observable "external_work" Energy "work of the punch's motion in the last increment" number!(observables.external_work);
    Observable "total_work" Energy "work of the punch's motion along the whole path" Source::Outcome(total_work);
    Observable "hertz_a" Length "larger semi-axis of Hertz's ellipse under the same load" Source::Outcome(|o| hertz(o, |h| h.semi_axis_a));
    Observable "hertz_b" Length "smaller semi-axis of Hertz's ellipse under the same load" Source::Outcome(|o| hertz(o, |h| h.semi_axis_b));
    Observable "hertz_area" Area "area of Hertz's ellipse under the same load" Source::Outcome(|o| hertz(o, |h| h.area));
    Observable "hertz_peak_pressure" Pressure "largest pressure of Hertz's theory under the same load" Source::Outcome(|o| hertz(o, |h| h.peak_pressure));
    Observable "hertz_approach" Length "approach of Hertz's theory under the same load" Source::Outcome(|o| hertz(o, |h| h.approach));
    Observable "track_x" Length "x of the contact of wheel and rail along the track" Source::Outcome(|o| rail(o, |r| r.track[0]));
    Observable "track_y" Length "y of the contact, from the middle of the track to the right" Source::Outcome(|o| rail(o, |r| r.track[1]));
    Observable "track_z" Length "z of the contact, from the tops of the rails down" Source::Outcome(|o| rail(o, |r| r.track[2]));
    Observable "rail_y" Length "y of the contact in the rail's profile" Source::Outcome(|o| rail(o, |r| r.rail[0]));
    Observable "rail_z" Length "z of the contact in the rail's profile" Source::Outcome(|o| rail(o, |r| r.rail[1]));
    Observable "contact_angle" Angle "inclination of the rail at the contact" Source::Outcome(|o| rail(o, |r| r.angle));
    Observable "track_pressure_x" Length "x of the centre of pressure along the track" Source::Outcome(|o| rail(o, |r| r.pressure_center[0]));
    Observable "track_pressure_y" Length "y of the centre of pressure in the track" Source::Outcome(|o| rail(o, |r| r.pressure_center[1]));
    Observable "track_pressure_z" Length "z of the centre of pressure in the track" Source::Outcome(|o| rail(o, |r| r.pressure_center[2]));
    Observable "wheelset_height" Length "height of the wheelset below where its rolling radius reaches the rails' tops" Source::Outcome(|o| rail(o, |r| r.wheelset_height));
    Observable "ceiling_elements" Pure "elements at the pressure ceiling" integer!(observables.ceiling_elements);
    Observable "edge_elements" Pure "elements in contact at the edge of Ω; above 0, Ω is too small" integer!(observables.edge_elements);
    Observable "mesh_x" Pure "elements along x" integer!(observables.mesh_x);
    Observable "mesh_y" Pure "elements along y" integer!(observables.mesh_y);
    Observable "element_x" Length "element size along x" number!(observables.element_x);
    Observable "element_y" Length "element size along y" number!(observables.element_y);
    Error "estimate_load" Pure "estimated relative error of the normal force" Source::Outcome(|o| estimate(o, |e| e.load));
    Error "estimate_approach" Pure "estimated relative error of the approach" Source::Outcome(|o| estimate(o, |e| e.approach));
    Error "estimate_tangential_force" Pure "estimated relative error of the tangential force" Source::Outcome(|o| estimate(o, |e| e.tangential_force));
    Error "estimate_shift" Pure "estimated relative error of the shift" Source::Outcome(|o| estimate(o, |e| e.shift));
    Error "estimate_moment" Pure "estimated relative error of the moments" Source::Outcome(|o| estimate(o, |e| e.moment));
    Error "estimate_rotation" Pure "estimated relative error of the rotations" Source::Outcome(|o| estimate(o, |e| e.rotation));
    Error "estimate_peak_pressure" Pure "estimated relative error of the largest pressure" Source::Outcome(|o| estimate(o, |e| e.peak_pressure));
    Error "estimate_contact_area" Pure "estimated relative error of the area in contact" Source::Outcome(|o| estimate(o, |e| e.contact_area));
    Error "estimate_stick_area" Pure "estimated relative error of the area that sticks, over the area in contact" Source::Outcome(|o| estimate(o, |e| e.stick_area));
    Error "estimate_pressure" Pure "estimated relative error of the pressure in L2" Source::Outcome(|o| estimate(o, |e| e.pressure));
    Error "estimate_traction" Pure "estimated relative error of the tangential traction in L2" Source::Outcome(|o| estimate(o, |e| e.traction));
    Error "estimate_solver" Pure "estimated relative error in L2 that the solver left" Source::Outcome(|o| estimate(o, |e| Some(e.solver)));
    Certificate "residual" Pure "relative natural-map residual" number!(certificate.residual);
    Certificate "tension" Pure "largest tension over the largest pressure" number!(certificate.tension);
    Certificate "penetration" Pure "largest penetration over the largest displacement" number!(certificate.penetration);
    Certificate "gap_under_pressure" Pure "largest gap under pressure, relative" number!(certificate.gap_under_pressure);
    Certificate "cone_violation" Pure "largest excess of traction over friction, relative" number!(certificate.cone_violation);
    Certificate "slip_angle" Angle "largest angle between slip and opposite traction" number!(certificate.slip_angle);
    Certificate "force_imbalance" Pure "imbalance of forces over the load" number!(certificate.force_imbalance);
    Work "iterations" Pure "iterations of the solver along the whole path" Source::Outcome(|outcome| Value::Integer(outcome.work().iterations));
    Work "operator_applications" Pure "applications of the operator along the whole path" Source::Outcome(|outcome| Value::Integer(outcome.work().operator_applications));
    Work "way" Pure "method that solved it, the last resort along the path" Source::Outcome(|outcome| outcome.way().map_or(Value::Missing, |way| Value::Text(way.words().to_owned())));
};

/// The columns of errors, in the order of [`Errors::NAMES`], and what they are measured against.
const ERRORS: &[Column] = results! {
    Error "error_load" Pure "relative error of the normal force" Source::Error(0);
    Error "error_approach" Pure "relative error of the approach" Source::Error(1);
    Error "error_tangential_force" Pure "relative error of the tangential force" Source::Error(2);
    Error "error_shift" Pure "relative error of the shift" Source::Error(3);
    Error "error_moment" Pure "relative error of the moments" Source::Error(4);
    Error "error_rotation" Pure "relative error of the rotations" Source::Error(5);
    Error "error_peak_pressure" Pure "relative error of the largest pressure" Source::Error(6);
    Error "error_contact_area" Pure "relative error of the area in contact" Source::Error(7);
    Error "error_stick_area" Pure "error of the area that sticks over the area in contact" Source::Error(8);
    Error "error_pressure" Pure "relative error of the pressure in L2" Source::Error(9);
    Error "error_traction" Pure "relative error of the tangential traction in L2" Source::Error(10);
    Error "error_local_pressure" Pure "relative error of the local means of the pressure, a weak measure" Source::Error(11);
    Error "error_local_traction" Pure "relative error of the local means of the traction, a weak measure" Source::Error(12);
    Error "reference" Pure "what the errors are measured against" Source::Reference;
};

/// The column that only studies of cost have.
const CLAIM: &[Column] = results! {
    Error "claimed_error" Pure "the error that counts, as rungs as fine or finer confirm it, with the reference's uncertainty" Source::Claim;
};

/// The columns of searches for every solution.
const SEARCH: &[Column] = results! {
    Observable "solutions" Pure "distinct certified solutions that were found" Source::Multiplicity(|found| Value::Integer(found.solutions.len() as u64));
    Observable "index_sum" Pure "sum of the solutions' indices; anything but 1 says that one was missed" Source::Multiplicity(|found| found.index_sum.map_or(Value::Missing, |sum| Value::Number(sum as f64)));
    Observable "largest_distance" Pure "largest relative L2 distance between two solutions" Source::Multiplicity(|found| found.furthest().map_or(Value::Missing, |[i, j]| Value::Number(found.solutions[i].distances[j])));
    Observable "smallest_load" Force "smallest normal force among the solutions" Source::Multiplicity(|found| extreme(found, |o| o.load, f64::min));
    Observable "largest_load" Force "largest normal force among the solutions" Source::Multiplicity(|found| extreme(found, |o| o.load, f64::max));
    Observable "smallest_stick_area" Area "smallest stick area among the solutions" Source::Multiplicity(|found| extreme(found, |o| o.stick_area, f64::min));
    Observable "largest_stick_area" Area "largest stick area among the solutions" Source::Multiplicity(|found| extreme(found, |o| o.stick_area, f64::max));
    Certificate "residual" Pure "largest relative natural-map residual of a solution" Source::Multiplicity(|found| largest(found, |solution| solution.certificate.residual));
    Certificate "error" Pure "largest distance of a solution from the exact one, relative, to first order" Source::Multiplicity(|found| largest(found, |solution| solution.error));
    Work "tried" Pure "starts tried, one for each method" Source::Multiplicity(|found| Value::Integer(found.starts));
    Work "failed_starts" Pure "starts that led to no certified solution" Source::Multiplicity(|found| Value::Integer(found.failed));
    Work "beyond" Pure "starts that led to solutions beyond the ones kept" Source::Multiplicity(|found| Value::Integer(found.beyond));
    Work "iterations" Pure "iterations of all solvers" Source::Multiplicity(|found| Value::Integer(found.work.iterations));
    Work "operator_applications" Pure "applications of the operator by all solvers" Source::Multiplicity(|found| Value::Integer(found.work.operator_applications));
    Work "factorisations" Pure "dense matrices factored" Source::Multiplicity(|found| Value::Integer(found.factorisations));
};

/// The columns of brackets of uniqueness sets.
const BRACKET: &[Column] = results! {
    Observable "mu_low" Pure "below this, every load has one solution at most: lower end of the bracket of μ*" Source::Bracketed(|found| side(found, |low, _| low.mu));
    Observable "mu_high" Pure "from this on, the condition for uniqueness fails: upper end of the bracket of μ*" Source::Bracketed(|found| side(found, |_, high| high.mu));
    Observable "bracket_width" Pure "length of the bracket over its upper end" Source::Bracketed(|found| side(found, |low, high| (high.mu - low.mu) / high.mu));
    Observable "unbounded" Pure "yes, if there is one solution at most whatever the friction" Source::Bracketed(|found| match &found.bracket {
        Some(Bracket::Unbounded) => Value::Text("yes".to_owned()),
        Some(Bracket::Bounded { .. }) => Value::Text("no".to_owned()),
        None => Value::Missing,
    });
    Certificate "witness_residual" Pure "|B(I - EA)x - x| / |x| of the witness above" Source::Bracketed(|found| found.shown.map_or(Value::Missing, |shown| Value::Number(shown.residual)));
    Certificate "singular_value" Pure "smallest singular value of B(I - EA) - I over its norm, for few elements" Source::Bracketed(|found| {
        found.shown.and_then(|shown| Some(shown.singular_value? / shown.norm)).map_or(Value::Missing, Value::Number)
    });
};

/// The columns that every record has, last.
const PROVENANCE: &[Column] = results! {
    Provenance "seconds" Time "time that solving took; of several times, the median" Source::Record(|record| Value::Number(record.provenance.seconds));
    Provenance "spread" Pure "of a job that is solved several times, the range of its times over their median" Source::Record(spread);
    Provenance "attempt" Pure "attempt that succeeded, counted from 1" Source::Record(|record| of_run(record, record.provenance.attempt));
    Provenance "worker" Pure "worker that computed it" Source::Record(|record| of_run(record, record.provenance.worker));
    Provenance "finished" Pure "when it was finished, UTC" Source::Record(finished);
    Provenance "program" Pure "version of the program" Source::Record(|record| Value::Text(record.provenance.program.clone()));
};

/// The smallest or largest of a quantity of the solutions.
fn extreme(found: &Multiplicity, read: fn(&Observables) -> f64, of: fn(f64, f64) -> f64) -> Value {
    found.solutions.iter().map(|solution| read(&solution.observables)).reduce(of).map_or(Value::Missing, Value::Number)
}

fn largest(found: &Multiplicity, read: fn(&Solution) -> f64) -> Value {
    found.solutions.iter().map(read).reduce(f64::max).map_or(Value::Missing, Value::Number)
}

/// A count that only jobs of a run have.
fn of_run(record: &Record, count: u32) -> Value {
    if record.provenance.attempt == 0 { Value::Missing } else { Value::Integer(u64::from(count)) }
}

fn finished(record: &Record) -> Value {
    // the last second of the year 9999 is the last that can be written
    let seconds = record.provenance.finished.min(253_402_300_799);
    let time = SystemTime::UNIX_EPOCH.checked_add(Duration::from_secs(seconds)).filter(|_| seconds > 0);
    time.map_or(Value::Missing, |time| Value::Text(humantime::format_rfc3339_seconds(time).to_string()))
}

fn spread(record: &Record) -> Value {
    let times = &record.provenance.times;
    let extreme = |of: fn(f64, f64) -> f64| times.iter().copied().reduce(of);
    match (extreme(f64::min), extreme(f64::max)) {
        (Some(least), Some(most)) if record.provenance.seconds > 0.0 => Value::Number((most - least) / record.provenance.seconds),
        _ => Value::Missing,
    }
}

/// A figure of both sides of a bracket.
fn side(found: &Bracketed, read: fn(&LowerBound, &Witness) -> f64) -> Value {
    match &found.bracket {
        Some(Bracket::Bounded { lower, upper }) => Value::Number(read(lower, upper)),
        _ => Value::Missing,
    }
}

/// `a`/`b`, where there is a `b`.
fn ratio(a: f64, b: f64) -> Value {
    // no −0
    if b > 0.0 { Value::Number(a / b + 0.0) } else { Value::Missing }
}

fn reason(record: &Record) -> Value {
    record.ending.reason().map_or(Value::Missing, |reason| Value::Text(reason.to_owned()))
}

fn hertz(outcome: &Outcome, read: fn(&Hertz) -> f64) -> Value {
    outcome.hertz.as_ref().map_or(Value::Missing, |hertz| Value::Number(read(hertz)))
}

fn rail(outcome: &Outcome, read: fn(&RailContact) -> f64) -> Value {
    outcome.rail.as_ref().map_or(Value::Missing, |rail| Value::Number(read(rail)))
}

fn estimate(outcome: &Outcome, read: fn(&Estimate) -> Option<f64>) -> Value {
    outcome.estimate.as_ref().and_then(read).map_or(Value::Missing, Value::Number)
}

fn increments(outcome: &Outcome) -> Value {
    Value::Integer(outcome.steps.len() as u64)
}

fn cycle_dissipation(outcome: &Outcome) -> Value {
    outcome.cycle_dissipation().map_or(Value::Missing, Value::Number)
}

fn total_work(outcome: &Outcome) -> Value {
    Value::Number(outcome.steps.iter().map(|step| step.observables.external_work).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::{failed, quarantined, solved};

    #[test]
    fn names_are_identifiers_and_unique() {
        let of = |kind: &Kind| columns(*kind, [], Key::all(|_| 12));
        let paths = along_path(of(&Kind::Solve));
        for columns in Kind::ALL.iter().map(of).chain([paths]) {
            let mut seen = HashSet::new();
            for column in &columns {
                assert!(seen.insert(column.name.clone()), "{}", column.name);
                assert!(column.name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_'), "{}", column.name);
            }
            // an axis over a table hides no other column
            for table in crate::key::Table::ALL {
                let key = Key::find(&table.path());
                assert!(!seen.contains(&table.column()) || key.is_some_and(|key| key.column() == table.column()), "{table:?}");
            }
        }
    }

    #[test]
    fn every_figure_of_an_outcome_has_its_column() {
        let record = solved();
        let outcome = record.outcome().unwrap();
        let point = Point::of_record(&record).unwrap();
        let columns = along_path(columns(Kind::Solve, [], []));
        let value = |name: &str| {
            let column = find(&columns, name).unwrap_or_else(|| panic!("no column {name}"));
            column.value(&point, Some(&record)).as_f64()
        };
        let end = serde_json::to_value(outcome.last().unwrap()).unwrap();
        for part in ["observables", "certificate"] {
            for (name, figure) in end[part].as_object().unwrap() {
                assert_eq!(value(name), figure.as_f64(), "{name}");
            }
        }
        for (name, figure) in end["motion"].as_object().unwrap() {
            assert_eq!(value(&format!("at_{name}")), figure.as_f64(), "{name}");
        }
        for (name, figure) in serde_json::to_value(outcome.estimate).unwrap().as_object().unwrap() {
            assert_eq!(value(&format!("estimate_{name}")), figure.as_f64(), "{name}");
        }
        for (name, figure) in serde_json::to_value(outcome.work()).unwrap().as_object().unwrap() {
            assert_eq!(value(name), figure.as_f64(), "{name}");
        }
        let whole = serde_json::to_value(outcome).unwrap();
        for (name, figure) in whole["hertz"].as_object().unwrap() {
            assert_eq!(value(&format!("hertz_{}", name.trim_start_matches("semi_axis_"))), figure.as_f64(), "{name}");
        }
        let names = [
            "track_x",
            "track_y",
            "track_z",
            "rail_y",
            "rail_z",
            "contact_angle",
            "track_pressure_x",
            "track_pressure_y",
            "track_pressure_z",
            "wheelset_height",
        ];
        assert_eq!(names.map(|name| value(name).unwrap()), [51.0, 52.0, 53.0, 54.0, 55.0, 56.0, 57.0, 58.0, 59.0, 60.0]);
        assert_eq!((value("step"), value("cycle")), (end["step"].as_f64(), end["cycle"].as_f64()));
    }

    #[test]
    fn an_increment_is_what_the_path_would_be_if_it_ended_there() {
        let record = failed();
        let point = Point::of_record(&record).unwrap();
        let columns = along_path(columns(Kind::Solve, [], []));
        let mut rows = Vec::new();
        record.along_path(|partial| {
            let names =
                ["step", "cycle", "increment", "status", "load", "dissipation", "total_dissipation", "cycle_dissipation", "iterations"];
            rows.push(names.map(|name| find(&columns, name).unwrap().value(&point, Some(partial)).to_string()).join(" "));
        });
        assert_eq!(rows, ["0 0 1 certified 0.5 0.25 0.25  7", "1 2 2 failed 1 15 15.25 15 29"]);
        let mut increments = 0;
        quarantined().along_path(|_| increments += 1);
        assert_eq!(increments, 0);
    }

    #[test]
    fn every_column_is_of_the_type_it_claims() {
        let record = solved();
        let point = Point::of_record(&record).unwrap();
        for column in columns(Kind::Solve, [], []) {
            let value = column.value(&point, Some(&record));
            if value != Value::Missing {
                assert_eq!(value.as_f64().is_some(), column.is_numeric(), "{}", column.name);
            }
        }
    }

    #[test]
    fn what_is_not_there_is_missing() {
        let columns = columns(Kind::Solve, [], [Key::Approach(0), Key::Mu, Key::PunchPoisson]);
        let value = |record: &Record, name: &str| find(&columns, name).unwrap().value(&Point::of_record(record).unwrap(), Some(record));
        assert_eq!(value(&quarantined(), "load"), Value::Missing);
        assert_eq!(value(&quarantined(), "status"), Value::Text("quarantined".into()));
        assert_eq!(value(&quarantined(), "reason"), Value::Text("killed by SIGKILL".into()));
        assert_eq!(value(&failed(), "status"), Value::Text("failed".into()));
        assert_eq!(value(&solved(), "reason"), Value::Missing);
        assert_eq!(value(&solved(), "friction.mu"), Value::Number(0.3));
        assert_eq!(value(&solved(), "punch_poisson"), Value::Missing);
        assert_eq!(value(&solved(), "stick_fraction"), Value::Number(0.25));
        assert_eq!(value(&solved(), "loading.steps[0].approach"), Value::Number(2e-5));
        assert_eq!((value(&solved(), "contact_x"), value(&solved(), "contact_y")), (Value::Number(-5.0), Value::Number(4.0)));
        assert_eq!((value(&solved(), "separated_area"), value(&solved(), "separated_fraction")), (Value::Number(2.0), Value::Number(0.2)));
        assert!(find(&columns, "colour").is_none());
    }

    #[test]
    fn who_computed_a_record_is_told_of_runs_only() {
        let columns = columns(Kind::Solve, [], []);
        let values = |record: &Record| {
            let point = Point::of_record(record).unwrap();
            ["attempt", "worker", "finished"].map(|name| find(&columns, name).unwrap().value(&point, Some(record)).to_string())
        };
        assert_eq!(values(&solved()), ["1", "1", "2023-11-14T22:13:20Z"]);
        let mut alone = solved();
        (alone.provenance.attempt, alone.provenance.worker, alone.provenance.finished) = (0, 0, 0);
        assert_eq!(values(&alone), ["", "", ""]);
        alone.provenance.finished = u64::MAX;
        assert_eq!(values(&alone)[2], "9999-12-31T23:59:59Z", "whatever a damaged record says");
    }
}
