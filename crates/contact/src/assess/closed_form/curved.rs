//! The exact answers under paraboloids and cones, frictionless or with the partial slip of Cattaneo
//! and Mindlin.

use std::f64::consts::PI;

use super::bodies::{is_nothing, modulus};
use super::exact::{ClosedForm, Pressure, Traction};
use crate::foundation::HalfSpace;
use crate::model::{Control, Dof, Leg, Motion, PerDof, Scene};
use crate::theory::{cone, hertz_ellipse};

/// A punch whose contacts under any approach are similar.
pub(super) enum Indenter {
    /// A paraboloid, with δ = `approach`·(P/E*)^⅔.
    Paraboloid {
        modulus: f64,
        curvatures: [f64; 2],
        approach: f64,
    },
    Cone {
        modulus: f64,
        angle: f64,
    },
}

/// A frictionless contact: its load \[N\] and its pressure.
pub(super) struct Normal {
    load: f64,
    pressure: Pressure,
}

impl Indenter {
    pub(super) fn paraboloid(bodies: &HalfSpace, radius_x: f64, radius_y: f64) -> Self {
        let curvatures = [0.5 / radius_x, 0.5 / radius_y];
        let approach = hertz_ellipse(1.0, curvatures[0], curvatures[1], 1.0).approach;
        Indenter::Paraboloid { modulus: modulus(bodies), curvatures, approach }
    }

    /// Returns the approach under a load.
    pub(super) fn approach(&self, load: f64) -> f64 {
        match *self {
            Indenter::Paraboloid { modulus, approach, .. } => {
                approach * (load / modulus).cbrt().powi(2)
            }
            // The load goes as the square of the approach.
            Indenter::Cone { modulus, angle } => (load / cone(modulus, angle, 1.0).load).sqrt(),
        }
    }

    /// Returns the contact at an approach > 0.
    pub(super) fn pressed(&self, approach: f64) -> Normal {
        match *self {
            Indenter::Paraboloid { modulus, curvatures, approach: unit } => {
                let load = modulus * (approach / unit).powf(1.5);
                let ellipse = hertz_ellipse(modulus, curvatures[0], curvatures[1], load);
                let semi_axes = [ellipse.semi_axis_x, ellipse.semi_axis_y];
                Normal {
                    load,
                    pressure: Pressure::Hertz { peak: ellipse.peak_pressure, semi_axes },
                }
            }
            Indenter::Cone { modulus, angle } => {
                let sneddon = cone(modulus, angle, approach);
                // The mean pressure over the contact is p₀.
                let scale = sneddon.load / (PI * sneddon.radius * sneddon.radius);
                Normal {
                    load: sneddon.load,
                    pressure: Pressure::Cone { scale, radius: sneddon.radius },
                }
            }
        }
    }

    /// Returns the name and source of the frictionless theory, and of that of partial slip.
    fn theories(&self) -> [[&'static str; 2]; 2] {
        let cattaneo = [
            "Cattaneo and Mindlin",
            "Mindlin, J. Appl. Mech. 16 (1949) 259–268, doi:10.1115/1.4009973",
        ];
        let any = [
            "Ciavarella",
            "Ciavarella, J. Appl. Mech. 65 (1998) 998–1003: a contact of any shape, ν = 0",
        ];
        match self {
            Indenter::Paraboloid { curvatures: [a, b], .. } if a == b => {
                [["Hertz", "Johnson, Contact Mechanics, 1985, eq. 4.22–4.24"], cattaneo]
            }
            Indenter::Paraboloid { .. } => {
                [["Hertz", "Johnson, Contact Mechanics, 1985, eq. 4.25–4.30"], any]
            }
            Indenter::Cone { .. } => {
                [["Sneddon's cone", "Sneddon 1965, doi:10.1016/0020-7225(65)90019-4"], any]
            }
        }
    }
}

/// Returns the answer for a curved punch, whose contact grows with the load.
pub(super) fn curved(scene: &Scene, indenter: &Indenter, bodies: &HalfSpace) -> Option<ClosedForm> {
    let legs = scene.loading.legs();
    let (last, before) = legs.split_last()?;
    let mu = scene.friction.mu;
    if legs.iter().any(|leg| Dof::TILTS.iter().any(|tilt| !is_nothing(leg.target[*tilt]))) {
        return None;
    }
    let approach = match last.target[Dof::Approach] {
        Control::Motion(approach) => approach,
        Control::Force(load) => indenter.approach(load),
    };
    if approach <= 0.0 {
        return None;
    }
    let normal = indenter.pressed(approach);
    let semi_axes = normal.pressure.semi_axes();
    let [frictionless, partial_slip] = indenter.theories();
    let mut exact = ClosedForm {
        name: frictionless[0],
        source: frictionless[1],
        controls: last.target,
        motion: Motion { approach, ..Motion::default() },
        resultants: PerDof::new([normal.load, 0.0, 0.0, 0.0, 0.0, 0.0]),
        semi_axes,
        stick_semi_axes: if mu > 0.0 { semi_axes } else { [0.0; 2] },
        peak_pressure: match normal.pressure {
            Pressure::Hertz { peak, .. } => Some(peak),
            Pressure::Cone { .. } | Pressure::Disk { .. } => None,
        },
        pressure: normal.pressure,
        traction: Traction::Zero,
    };
    let sideways = |control: &Control| !is_nothing(*control);
    let shifts = |leg: &Leg| Dof::SHIFTS.iter().any(|dof| sideways(&leg.target[*dof]));
    if mu == 0.0 {
        // Without friction a motion sideways meets no force, and a force no equilibrium.
        let pulled = |control: &Control| matches!(control, Control::Force(force) if *force != 0.0);
        if legs.iter().any(|leg| Dof::TANGENTIAL.iter().any(|dof| pulled(&leg.target[*dof]))) {
            return None;
        }
        let moved =
            |dof: Dof| if let Control::Motion(moved) = last.target[dof] { moved } else { 0.0 };
        (exact.motion.shift_x, exact.motion.shift_y, exact.motion.twist) =
            (moved(Dof::ShiftX), moved(Dof::ShiftY), moved(Dof::Twist));
        return Some(exact);
    }
    if legs.iter().any(|leg| sideways(&leg.target[Dof::Twist])) || before.iter().any(shifts) {
        return None;
    }
    if !shifts(last) {
        return Some(exact);
    }
    let load_stays = before.last().map_or(last.increments == 1, |leg| {
        leg.target[Dof::Approach] == last.target[Dof::Approach]
    });
    if bodies.cross != 0.0 || !load_stays {
        return None;
    }
    // With ν = 0 and no coupling each tangential direction has the operator of the normal one, so
    // that μ times the change of pressure with approach moves the surface by μ times the change of
    // approach wherever both contacts have been.
    let Pull { amount, direction, is_force } =
        pull(last.target[Dof::ShiftX], last.target[Dof::ShiftY])?;
    let limit = mu * normal.load;
    let remaining = if is_force {
        if amount >= limit {
            return None;
        }
        indenter.approach(normal.load - amount / mu)
    } else {
        (approach - amount / mu).max(0.0)
    };
    let sticking = (remaining > 0.0).then(|| indenter.pressed(remaining));
    let force = limit - mu * sticking.as_ref().map_or(0.0, |inner| inner.load);
    let shift = if is_force { mu * (approach - remaining) } else { amount };
    [exact.resultants[Dof::ShiftX], exact.resultants[Dof::ShiftY]] =
        direction.map(|along| along * force);
    [exact.motion.shift_x, exact.motion.shift_y] = direction.map(|along| along * shift);
    exact.stick_semi_axes = sticking.as_ref().map_or([0.0; 2], |inner| inner.pressure.semi_axes());
    exact.traction = Traction::PartialSlip {
        friction: direction.map(|along| along * mu),
        sticking: sticking.map(|inner| inner.pressure),
    };
    [exact.name, exact.source] = partial_slip;
    Some(exact)
}

/// A motion or a force sideways, in one direction.
struct Pull {
    /// The size of the motion \[m\] or force \[N\].
    amount: f64,
    /// The unit vector along it.
    direction: [f64; 2],
    /// True if it is a force.
    is_force: bool,
}

/// Returns the pull of two components; `None` when one is given a motion and the other a force that
/// together have no direction of their own.
fn pull(x: Control, y: Control) -> Option<Pull> {
    let (components, is_force) = match (x, y) {
        (Control::Motion(x), Control::Motion(y)) => ([x, y], false),
        (Control::Force(x), Control::Force(y)) => ([x, y], true),
        (Control::Motion(x), Control::Force(0.0)) => ([x, 0.0], false),
        (Control::Force(0.0), Control::Motion(y)) => ([0.0, y], false),
        (Control::Force(x), Control::Motion(0.0)) => ([x, 0.0], true),
        (Control::Motion(0.0), Control::Force(y)) => ([0.0, y], true),
        _ => return None,
    };
    let amount = components[0].hypot(components[1]);
    Some(Pull { amount, direction: components.map(|component| component / amount), is_force })
}
