//! Studies that solve every point.

use contact::model::{Estimate, Hertz, Outcome, RailContact, Shape};

use super::freedom::ScenesFreedom;
use super::interior::{INTERIOR, INTERIOR_RESIDUAL};
use super::rolling::ROLLING;
use super::rolling_theory::ROLLING_THEORY;
use super::spec::{KindSpec, KindTable};
use super::wear::WEAR;
use crate::axis::Group;
use crate::columns::column::{Column, ColumnSource};
use crate::columns::common::increments;
use crate::columns::result_columns::{integer, result_columns};
use crate::figure::Figure;
use crate::job::{Case, Job};
use crate::key::Key;
use crate::value::Value;

/// The description of the kind.
pub(crate) const SPEC: KindSpec = KindSpec {
    name: "solve",
    table: None,
    has_accuracy: true,
    arrange: None,
    refuses,
    assemble: |assembler, _| Job::Solve(assembler.case()),
    check: |_| Ok(()),
    to_toml: |_| String::new(),
    columns: &[
        SOLUTION,
        INTERIOR,
        ACCURACY,
        INTERIOR_RESIDUAL,
        WORK,
        ROLLING,
        ROLLING_THEORY,
        WEAR,
    ],
    further_columns: &[],
    usual_columns: &["load", "contact_radius", "stick_fraction", "peak_pressure", "status"],
    suggestions,
};

/// Tells why a job that solves a scene has no use for a key; `None` if it has.
pub(crate) fn refuses(key: Key) -> Option<&'static str> {
    match key {
        Key::Starts | Key::Seed => Some("a scene is solved from one start"),
        Key::Cases | Key::Width => {
            Some("cases and widths are of searches for the end of a uniqueness set")
        }
        Key::Plane => Some("a plane is of searches for the end of a uniqueness set"),
        _ => None,
    }
}

/// Makes a figure of each quantity that the scenes leave free over each axis; of a sample, first
/// histograms, then scatters over each key that it draws.
fn suggestions(_: &KindTable, groups: &[Group], jobs: &[Job]) -> Vec<Figure> {
    let freedom = ScenesFreedom::of(jobs);
    if groups.iter().any(|group| group.design().is_some()) {
        let histogram = |name: &String| Figure::histogram(name.clone()).telling_apart(groups);
        let histograms: Vec<Figure> = freedom.quantities("").iter().map(histogram).collect();
        let scatters = Figure::over_drawn(groups).into_iter().flat_map(|over| {
            let quantities = freedom.quantities(&over.x);
            quantities.into_iter().map(move |y| Figure { y: vec![y], ..over.clone() })
        });
        return histograms.into_iter().chain(scatters).collect();
    }
    let of_axis = |over: Figure| {
        let quantities = freedom.quantities(&over.x);
        quantities.into_iter().map(move |y| Figure { y: vec![y.to_owned()], ..over.clone() })
    };
    Figure::over_axes(groups).into_iter().flat_map(of_axis).collect()
}

/// Reads a number from the outcome of the last increment.
macro_rules! number {
    ($($field:ident).+) => {
        ColumnSource::End(|end| Value::Number(end.$($field).+))
    };
}

/// The columns of solutions: motion, forces and contact.
pub(crate) const SOLUTION: &[Column] = result_columns! {
    Status "increments" Count
        "increments of the loading path that were followed; where it failed, it failed at the last"
        ColumnSource::Outcome(increments);
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
    Observable "contact_x" ("x of the centre of pressure") Length "x of the centre of pressure"
        ColumnSource::Observed(|o| Value::ratio(-o.moment_y, o.load));
    Observable "contact_y" ("y of the centre of pressure") Length "y of the centre of pressure"
        ColumnSource::Observed(|o| Value::ratio(o.moment_x, o.load));
    Observable "contact_area" Area "area in contact" number!(observables.contact_area);
    Observable "stick_area" Area "area in contact that sticks" number!(observables.stick_area);
    Observable "slip_area" Area "area in contact that slips" number!(observables.slip_area);
    Observable "stick_fraction" Pure "stick area over contact area"
        ColumnSource::Observed(|o| Value::ratio(o.stick_area, o.contact_area));
    Observable "contact_radius" Length "radius of the disk of the contact area"
        ColumnSource::Observed(|o| Value::Number((o.contact_area / std::f64::consts::PI).sqrt()));
    Observable "patches" ("number of patches") Count "separate regions in contact"
        integer!(observables.patches);
    Observable "sole_area" ("area of the sole") Area "area that could be in contact"
        number!(observables.sole_area);
    Observable "separated_area" Area "area that could be in contact and is not"
        ColumnSource::Observed(|o| Value::Number(o.sole_area - o.contact_area));
    Observable "separated_fraction" Pure "separated area over the area that could be in contact"
        ColumnSource::Observed(|o| Value::ratio(o.sole_area - o.contact_area, o.sole_area));
    Observable "largest_gap" Length "largest gap where contact could be"
        number!(observables.largest_gap);
    Observable "contact_elements" Count "elements in contact" integer!(observables.contact_elements);
    Observable "stick_elements" Count "elements that stick" integer!(observables.stick_elements);
    Observable "slip_elements" Count "elements that slip" integer!(observables.slip_elements);
    Observable "peak_pressure" Pressure "largest pressure" number!(observables.peak_pressure);
    Observable "peak_traction" Pressure "largest tangential traction"
        number!(observables.peak_traction);
    Observable "energy" ("elastic energy") Energy "elastic energy" number!(observables.energy);
    Observable "dissipation" ("energy lost to friction in the increment") Energy
        "energy lost to friction in the last increment; of steady rolling, over the distance `dq`"
        number!(observables.dissipation);
    Observable "total_dissipation" ("energy lost to friction") Energy
        "energy lost to friction along the whole path; of steady rolling, over the distance `dq`"
        ColumnSource::Outcome(|outcome| Value::Number(outcome.dissipation()));
    Observable "cycle_dissipation" ("energy lost per cycle") Energy
        "energy lost to friction in the last cycle"
        ColumnSource::Outcome(cycle_dissipation);
    Observable "external_work" ("work in the increment") Energy
        "work of the punch's motion in the last increment"
        number!(observables.external_work);
    Observable "total_work" Energy "work of the punch's motion along the whole path"
        ColumnSource::Outcome(total_work);
    Observable "hertz_a" ("Hertz's larger semi-axis") Length
        "larger semi-axis of Hertz's ellipse under the same load"
        ColumnSource::Outcome(|o| hertz(o, |h| h.semi_axis_a));
    Observable "hertz_b" ("Hertz's smaller semi-axis") Length
        "smaller semi-axis of Hertz's ellipse under the same load"
        ColumnSource::Outcome(|o| hertz(o, |h| h.semi_axis_b));
    Observable "hertz_area" ("Hertz's contact area") Area
        "area of Hertz's ellipse under the same load"
        ColumnSource::Outcome(|o| hertz(o, |h| h.area));
    Observable "hertz_peak_pressure" ("Hertz's peak pressure") Pressure
        "largest pressure of Hertz's theory under the same load"
        ColumnSource::Outcome(|o| hertz(o, |h| h.peak_pressure));
    Observable "hertz_approach" ("Hertz's approach") Length
        "approach of Hertz's theory under the same load"
        ColumnSource::Outcome(|o| hertz(o, |h| h.approach));
    Observable "track_x" ("x of the contact in the track") Length
        "x of the contact of wheel and rail along the track"
        ColumnSource::Outcome(|o| rail(o, |r| r.track[0]));
    Observable "track_y" ("y of the contact in the track") Length
        "y of the contact, from the middle of the track to the right"
        ColumnSource::Outcome(|o| rail(o, |r| r.track[1]));
    Observable "track_z" ("z of the contact in the track") Length
        "z of the contact, from the tops of the rails down"
        ColumnSource::Outcome(|o| rail(o, |r| r.track[2]));
    Observable "rail_y" ("y of the contact on the rail") Length
        "y of the contact in the rail's profile"
        ColumnSource::Outcome(|o| rail(o, |r| r.rail[0]));
    Observable "rail_z" ("z of the contact on the rail") Length
        "z of the contact in the rail's profile"
        ColumnSource::Outcome(|o| rail(o, |r| r.rail[1]));
    Observable "contact_angle" Angle "inclination of the rail at the contact"
        ColumnSource::Outcome(|o| rail(o, |r| r.angle));
    Observable "track_pressure_x" ("x of the centre of pressure in the track") Length
        "x of the centre of pressure along the track"
        ColumnSource::Outcome(|o| rail(o, |r| r.pressure_center[0]));
    Observable "track_pressure_y" ("y of the centre of pressure in the track") Length
        "y of the centre of pressure in the track"
        ColumnSource::Outcome(|o| rail(o, |r| r.pressure_center[1]));
    Observable "track_pressure_z" ("z of the centre of pressure in the track") Length
        "z of the centre of pressure in the track"
        ColumnSource::Outcome(|o| rail(o, |r| r.pressure_center[2]));
    Observable "wheelset_height" Length
        "height of the wheelset below where its rolling radius reaches the rails' tops"
        ColumnSource::Outcome(|o| rail(o, |r| r.wheelset_height));
    Observable "track_force_y" ("lateral force on the rail") Force
        "force of a wheel on its rail along the track's y, to the right, at the end of the path; of one \
         plane of contact"
        ColumnSource::Solved(|case, outcome| track_force(case, outcome, 1));
    Observable "track_force_z" ("vertical force on the rail") Force
        "force of a wheel on its rail along the track's z, downwards, at the end of the path; of one \
         plane of contact"
        ColumnSource::Solved(|case, outcome| track_force(case, outcome, 2));
};

/// The columns of how well solutions are known.
pub(crate) const ACCURACY: &[Column] = result_columns! {
    Observable "ceiling_elements" Count "elements at the pressure ceiling"
        integer!(observables.ceiling_elements);
    Observable "edge_elements" Count "elements in contact at the edge of Ω; above 0, Ω is too small"
        integer!(observables.edge_elements);
    Observable "mesh_x" ("elements along x") Count "elements along x" integer!(observables.mesh_x);
    Observable "mesh_y" ("elements along y") Count "elements along y" integer!(observables.mesh_y);
    Observable "element_x" ("element size along x") Length "element size along x"
        number!(observables.element_x);
    Observable "element_y" ("element size along y") Length "element size along y"
        number!(observables.element_y);
    Error "estimate_load" Pure "estimated relative error of the normal force"
        ColumnSource::Outcome(|o| estimate(o, |e| e.figures.load));
    Error "estimate_approach" Pure "estimated relative error of the approach"
        ColumnSource::Outcome(|o| estimate(o, |e| e.figures.approach));
    Error "estimate_tangential_force" Pure "estimated relative error of the tangential force"
        ColumnSource::Outcome(|o| estimate(o, |e| e.figures.tangential_force));
    Error "estimate_shift" Pure "estimated relative error of the shift"
        ColumnSource::Outcome(|o| estimate(o, |e| e.figures.shift));
    Error "estimate_moment" Pure "estimated relative error of the moments"
        ColumnSource::Outcome(|o| estimate(o, |e| e.figures.moment));
    Error "estimate_rotation" Pure "estimated relative error of the rotations"
        ColumnSource::Outcome(|o| estimate(o, |e| e.figures.rotation));
    Error "estimate_peak_pressure" Pure "estimated relative error of the largest pressure"
        ColumnSource::Outcome(|o| estimate(o, |e| e.figures.peak_pressure));
    Error "estimate_contact_area" Pure "estimated relative error of the area in contact"
        ColumnSource::Outcome(|o| estimate(o, |e| e.figures.contact_area));
    Error "estimate_stick_area" Pure
        "estimated relative error of the area that sticks, over the area in contact"
        ColumnSource::Outcome(|o| estimate(o, |e| e.figures.stick_area));
    Error "estimate_pressure" Pure "estimated relative error of the pressure in L2"
        ColumnSource::Outcome(|o| estimate(o, |e| e.figures.pressure));
    Error "estimate_traction" Pure "estimated relative error of the tangential traction in L2"
        ColumnSource::Outcome(|o| estimate(o, |e| e.figures.traction));
    Error "estimate_solver" ("estimated error that the solver left") Pure
        "estimated relative error in L2 that the solver left"
        ColumnSource::Outcome(|o| estimate(o, |e| Some(e.solver)));
    Certificate "residual" Pure "relative natural-map residual" number!(certificate.residual);
    Certificate "tension" ("largest tension, relative") Pure
        "largest tension over the largest pressure"
        number!(certificate.tension);
    Certificate "penetration" ("largest penetration, relative") Pure
        "largest penetration over the largest displacement"
        number!(certificate.penetration);
    Certificate "gap_under_pressure" Pure "largest gap under pressure, relative"
        number!(certificate.gap_under_pressure);
    Certificate "cone_violation" Pure "largest excess of traction over friction, relative"
        number!(certificate.cone_violation);
    Certificate "slip_angle" Angle "largest angle between slip and opposite traction"
        number!(certificate.slip_angle);
    Certificate "force_imbalance" Pure "imbalance of forces over the load"
        number!(certificate.force_imbalance);
};

/// The columns of the work that solutions took.
pub(crate) const WORK: &[Column] = result_columns! {
    Work "iterations" Count "iterations of the solver along the whole path"
        ColumnSource::Outcome(|outcome| Value::Integer(outcome.work().iterations));
    Work "operator_applications" Count "applications of the operator along the whole path"
        ColumnSource::Outcome(|outcome| Value::Integer(outcome.work().operator_applications));
    Work "way" Text "method that solved it, or was tried last: the last resort along the path"
        ColumnSource::Outcome(|outcome| {
            outcome.route().map_or(Value::Missing, |route| Value::Text(route.words().to_owned()))
        });
};

fn hertz(outcome: &Outcome, read: fn(&Hertz) -> f64) -> Value {
    outcome.hertz.as_ref().map_or(Value::Missing, |hertz| Value::Number(read(hertz)))
}

/// Returns a component of the force on a rail. Patches may have planes of their own, of which the
/// outcome knows but one; a wheelset that moves has a single one.
fn track_force(case: &Case, outcome: &Outcome, component: usize) -> Value {
    let moves = matches!(
        &case.scene.punch.shape,
        Shape::WheelOnRail(wheel) if wheel.motion.is_some()
    );
    match (&outcome.rail, outcome.last()) {
        (Some(rail), Some(end)) if moves || end.observables.patches == 1 => {
            Value::Number(rail.track_force(&end.observables)[component])
        }
        _ => Value::Missing,
    }
}

fn rail(outcome: &Outcome, read: fn(&RailContact) -> f64) -> Value {
    outcome.rail.as_ref().map_or(Value::Missing, |rail| Value::Number(read(rail)))
}

fn estimate(outcome: &Outcome, read: fn(&Estimate) -> Option<f64>) -> Value {
    outcome.estimate.as_ref().and_then(read).map_or(Value::Missing, Value::Number)
}

fn cycle_dissipation(outcome: &Outcome) -> Value {
    outcome.cycle_dissipation().map_or(Value::Missing, Value::Number)
}

fn total_work(outcome: &Outcome) -> Value {
    Value::Number(outcome.steps.iter().map(|step| step.observables.external_work).sum())
}
