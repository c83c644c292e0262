//! The columns of stresses below the surface.

use contact::model::{Interior, Outcome};

use crate::columns::column::{Column, ColumnSource};
use crate::columns::result_columns::result_columns;
use crate::value::Value;

/// The columns of the largest stresses, of the shallowest plane and of the first point.
pub(crate) const INTERIOR: &[Column] = result_columns! {
    Observable "von_mises_max" ("largest von Mises stress") Pressure
        "largest von Mises stress, on the surface or below it"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.von_mises?.overall().stress)));
    Observable "von_mises_x" ("x of the largest von Mises stress") Length
        "x of the largest von Mises stress"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.von_mises?.overall().place[0])));
    Observable "von_mises_y" ("y of the largest von Mises stress") Length
        "y of the largest von Mises stress"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.von_mises?.overall().place[1])));
    Observable "von_mises_z" ("z of the largest von Mises stress") Length
        "z of the largest von Mises stress"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.von_mises?.overall().place[2])));
    Observable "von_mises_below" ("largest von Mises stress below the surface") Pressure
        "largest local maximum of the von Mises stress below the surface"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.von_mises?.below?.stress)));
    Observable "von_mises_below_depth" ("depth of the largest von Mises stress") Length
        "depth of the largest local maximum of the von Mises stress below the surface"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.von_mises?.below?.place[2])));
    Observable "von_mises_surface" ("largest von Mises stress on the surface") Pressure
        "largest von Mises stress at the elements' centres on the surface"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.von_mises?.surface.stress)));
    Observable "von_mises_max_over_pressure" ("largest von Mises stress over peak pressure") Pure
        "largest von Mises stress over the largest pressure"
        ColumnSource::Outcome(|o| over_pressure(o, |i| Some(i.von_mises?.overall().stress)));
    Observable "von_mises_below_over_pressure"
        ("largest von Mises stress below the surface over peak pressure") Pure
        "largest von Mises stress below the surface over the largest pressure"
        ColumnSource::Outcome(|o| over_pressure(o, |i| Some(i.von_mises?.below?.stress)));
    Observable "plane_von_mises" ("von Mises stress on the plane") Pressure
        "largest von Mises stress at the elements' centres on the shallowest plane that is asked for"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.planes.first()?.von_mises.stress)));
    Observable "tresca_max" ("largest Tresca stress") Pressure
        "largest Tresca stress, on the surface or below it"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.tresca?.overall().stress)));
    Observable "tresca_x" ("x of the largest Tresca stress") Length
        "x of the largest Tresca stress"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.tresca?.overall().place[0])));
    Observable "tresca_y" ("y of the largest Tresca stress") Length
        "y of the largest Tresca stress"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.tresca?.overall().place[1])));
    Observable "tresca_z" ("z of the largest Tresca stress") Length
        "z of the largest Tresca stress"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.tresca?.overall().place[2])));
    Observable "tresca_below" ("largest Tresca stress below the surface") Pressure
        "largest local maximum of the Tresca stress below the surface"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.tresca?.below?.stress)));
    Observable "tresca_below_depth" ("depth of the largest Tresca stress") Length
        "depth of the largest local maximum of the Tresca stress below the surface"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.tresca?.below?.place[2])));
    Observable "tresca_surface" ("largest Tresca stress on the surface") Pressure
        "largest Tresca stress at the elements' centres on the surface"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.tresca?.surface.stress)));
    Observable "tresca_max_over_pressure" ("largest Tresca stress over peak pressure") Pure
        "largest Tresca stress over the largest pressure"
        ColumnSource::Outcome(|o| over_pressure(o, |i| Some(i.tresca?.overall().stress)));
    Observable "tresca_below_over_pressure"
        ("largest Tresca stress below the surface over peak pressure") Pure
        "largest Tresca stress below the surface over the largest pressure"
        ColumnSource::Outcome(|o| over_pressure(o, |i| Some(i.tresca?.below?.stress)));
    Observable "plane_tresca" ("Tresca stress on the plane") Pressure
        "largest Tresca stress at the elements' centres on the shallowest plane that is asked for"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.planes.first()?.tresca.stress)));
    Observable "stress_xx" ("stress xx") Pressure
        "stress xx at the first point that is asked for, tension positive"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.points.first()?.stress.xx)));
    Observable "stress_yy" ("stress yy") Pressure
        "stress yy at the first point that is asked for, tension positive"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.points.first()?.stress.yy)));
    Observable "stress_zz" ("stress zz") Pressure
        "stress zz at the first point that is asked for, tension positive"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.points.first()?.stress.zz)));
    Observable "stress_xy" ("stress xy") Pressure
        "stress xy at the first point that is asked for, tension positive"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.points.first()?.stress.xy)));
    Observable "stress_yz" ("stress yz") Pressure
        "stress yz at the first point that is asked for, tension positive"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.points.first()?.stress.yz)));
    Observable "stress_xz" ("stress xz") Pressure
        "stress xz at the first point that is asked for, tension positive"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.points.first()?.stress.xz)));
    Observable "stress_first" ("largest principal stress") Pressure
        "largest principal stress at the first point that is asked for"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.points.first()?.stress.principal()[0])));
    Observable "stress_second" ("middle principal stress") Pressure
        "middle principal stress at the first point that is asked for"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.points.first()?.stress.principal()[1])));
    Observable "stress_third" ("smallest principal stress") Pressure
        "smallest principal stress at the first point that is asked for"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.points.first()?.stress.principal()[2])));
    Observable "stress_von_mises" ("von Mises stress at the point") Pressure
        "von Mises stress at the first point that is asked for"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.points.first()?.stress.von_mises())));
    Observable "stress_tresca" ("Tresca stress at the point") Pressure
        "Tresca stress at the first point that is asked for"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.points.first()?.stress.tresca())));
    Observable "interior_from" ("depth where the search for maxima begins") Length
        "depth below which local maxima of stresses were sought; the mesh is felt above"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.searched?[0])));
    Observable "interior_to" ("depth where the search for maxima ends") Length
        "depth down to which local maxima of stresses were sought"
        ColumnSource::Outcome(|o| interior(o, |i| Some(i.searched?[1])));
};

/// The residual of all of them.
pub(crate) const INTERIOR_RESIDUAL: &[Column] = result_columns! {
    Certificate "interior_residual" ("residual of the stresses below the surface") Pure
        "largest difference of stresses below the surface between two ways to them, relative"
        ColumnSource::Outcome(|o| interior(o, |i| i.residual));
};

fn interior(outcome: &Outcome, read: fn(&Interior) -> Option<f64>) -> Value {
    outcome.further.interior.as_ref().and_then(read).map_or(Value::Missing, Value::Number)
}

fn over_pressure(outcome: &Outcome, read: fn(&Interior) -> Option<f64>) -> Value {
    let pressure = outcome.last().map_or(0.0, |end| end.observables.peak_pressure);
    let stress = outcome.further.interior.as_ref().and_then(read);
    stress.map_or(Value::Missing, |stress| Value::ratio(stress, pressure))
}
