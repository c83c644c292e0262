//! The columns of what jobs leave.

use std::borrow::Cow;
use std::time::{Duration, SystemTime};

use contact::model::{Estimate, Hertz, Observables, Outcome, RailContact};
use contact::multiplicity::{Multiplicity, Solution};
use contact::uniqueness::Bracket;
use contact::uniqueness::lower::LowerBound;
use contact::uniqueness::witness::Witness;

use super::{Column, Role, Source, Value};
use crate::record::{Bracketed, Record};
use crate::units::Dimension;

/// The columns of results whose values are texts.
pub(super) const TEXTS: &[&str] = &["status", "reason", "way", "program", "unbounded", "finished"];

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
pub(super) const PLACE: &[Column] = results! {
    Place "step" Pure "index of the load step" integer!(step);
    Place "cycle" Pure "which time the cycle is run through, counted from 1; 0 outside of one" integer!(cycle);
    Place "increment" Pure "number of the increment along the path, counted from 1" Source::Outcome(increments);
};

/// The columns that every record has, first.
pub(super) const ENDING: &[Column] = results! {
    Status "key" Pure "identity of the job" Source::JobKey;
    Status "status" Pure "certified, failed or quarantined" Source::Record(|record| Value::Text(record.status().to_owned()));
    Status "reason" Pure "why it failed" Source::Record(reason);
};

/// The columns of solutions.
pub(super) const SOLUTION: &[Column] = results! {
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
    Error "estimate_load" Pure "estimated relative error of the normal force" Source::Outcome(|o| estimate(o, |e| e.figures.load));
    Error "estimate_approach" Pure "estimated relative error of the approach" Source::Outcome(|o| estimate(o, |e| e.figures.approach));
    Error "estimate_tangential_force" Pure "estimated relative error of the tangential force" Source::Outcome(|o| estimate(o, |e| e.figures.tangential_force));
    Error "estimate_shift" Pure "estimated relative error of the shift" Source::Outcome(|o| estimate(o, |e| e.figures.shift));
    Error "estimate_moment" Pure "estimated relative error of the moments" Source::Outcome(|o| estimate(o, |e| e.figures.moment));
    Error "estimate_rotation" Pure "estimated relative error of the rotations" Source::Outcome(|o| estimate(o, |e| e.figures.rotation));
    Error "estimate_peak_pressure" Pure "estimated relative error of the largest pressure" Source::Outcome(|o| estimate(o, |e| e.figures.peak_pressure));
    Error "estimate_contact_area" Pure "estimated relative error of the area in contact" Source::Outcome(|o| estimate(o, |e| e.figures.contact_area));
    Error "estimate_stick_area" Pure "estimated relative error of the area that sticks, over the area in contact" Source::Outcome(|o| estimate(o, |e| e.figures.stick_area));
    Error "estimate_pressure" Pure "estimated relative error of the pressure in L2" Source::Outcome(|o| estimate(o, |e| e.figures.pressure));
    Error "estimate_traction" Pure "estimated relative error of the tangential traction in L2" Source::Outcome(|o| estimate(o, |e| e.figures.traction));
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

/// The columns of errors, and what they are measured against.
pub(super) const ERRORS: &[Column] = results! {
    Error "error_load" Pure "relative error of the normal force" Source::Error(|e| e.figures.load);
    Error "error_approach" Pure "relative error of the approach" Source::Error(|e| e.figures.approach);
    Error "error_tangential_force" Pure "relative error of the tangential force" Source::Error(|e| e.figures.tangential_force);
    Error "error_shift" Pure "relative error of the shift" Source::Error(|e| e.figures.shift);
    Error "error_moment" Pure "relative error of the moments" Source::Error(|e| e.figures.moment);
    Error "error_rotation" Pure "relative error of the rotations" Source::Error(|e| e.figures.rotation);
    Error "error_peak_pressure" Pure "relative error of the largest pressure" Source::Error(|e| e.figures.peak_pressure);
    Error "error_contact_area" Pure "relative error of the area in contact" Source::Error(|e| e.figures.contact_area);
    Error "error_stick_area" Pure "error of the area that sticks over the area in contact" Source::Error(|e| e.figures.stick_area);
    Error "error_pressure" Pure "relative error of the pressure in L2" Source::Error(|e| e.figures.pressure);
    Error "error_traction" Pure "relative error of the tangential traction in L2" Source::Error(|e| e.figures.traction);
    Error "error_local_pressure" Pure "relative error of the local means of the pressure, a weak measure" Source::Error(|e| e.local.pressure);
    Error "error_local_traction" Pure "relative error of the local means of the traction, a weak measure" Source::Error(|e| e.local.traction);
    Error "reference" Pure "what the errors are measured against" Source::Reference;
};

/// The column that only studies of cost have.
pub(super) const CLAIM: &[Column] = results! {
    Error "claimed_error" Pure "the error that counts, as rungs as fine or finer confirm it, with the reference's uncertainty" Source::Claim;
};

/// The columns of searches for every solution.
pub(super) const SEARCH: &[Column] = results! {
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
pub(super) const BRACKET: &[Column] = results! {
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
pub(super) const PROVENANCE: &[Column] = results! {
    Provenance "seconds" Time "time that solving took; of several times, the median" Source::Record(|record| Value::Number(record.provenance.seconds));
    Provenance "spread" Pure "of a job that is solved several times, the range of its times over their median" Source::Record(spread);
    Provenance "attempt" Pure "attempt that succeeded, counted from 1" Source::Record(|record| of_run(record, record.provenance.attempt));
    Provenance "worker" Pure "worker that computed it" Source::Record(|record| of_run(record, record.provenance.worker));
    Provenance "finished" Pure "when it was finished, UTC" Source::Record(finished);
    Provenance "program" Pure "version of the program" Source::Record(|record| Value::Text(record.provenance.program.clone()));
};

/// The smallest or largest of a quantity of the solutions.
fn extreme(found: &Multiplicity, read: fn(&Observables) -> f64, of: fn(f64, f64) -> f64) -> Value {
    found
        .solutions
        .iter()
        .map(|solution| read(&solution.observables))
        .reduce(of)
        .map_or(Value::Missing, Value::Number)
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
    let time =
        SystemTime::UNIX_EPOCH.checked_add(Duration::from_secs(seconds)).filter(|_| seconds > 0);
    time.map_or(Value::Missing, |time| {
        Value::Text(humantime::format_rfc3339_seconds(time).to_string())
    })
}

fn spread(record: &Record) -> Value {
    let times = &record.provenance.times;
    let extreme = |of: fn(f64, f64) -> f64| times.iter().copied().reduce(of);
    match (extreme(f64::min), extreme(f64::max)) {
        (Some(least), Some(most)) if record.provenance.seconds > 0.0 => {
            Value::Number((most - least) / record.provenance.seconds)
        }
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
