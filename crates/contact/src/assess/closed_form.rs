//! The scenes that have an exact answer in closed form, and that answer.
//!
//! The answer is that of the continuous problem, equation (1), on homogeneous half-spaces: mesh,
//! projection, ε, the ceiling and the method are ways to approximate it and do not enter. A scene
//! has one only where every condition of the theory holds exactly.

use std::f64::consts::PI;

use super::quadrature::Kinks;
use crate::foundation::{HalfSpace, relative_bodies};
use crate::model::{Control, Dof, Leg, Motion, PerDof, Scene, Shape};
use crate::punch::{Surfaces, domain};
use crate::theory::{cone, flat_disk, hertz_ellipse, shifted_disk, tilted_disk, twisted_disk};

/// The exact answer at the end of a scene's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedForm {
    /// The name of the theory.
    pub name: &'static str,
    /// The source where it is found.
    pub source: &'static str,
    /// The controls that the last step prescribes.
    pub(crate) controls: PerDof<Control>,
    /// The motion of the punch; 0 for a motion that is not determined (sideways, without friction
    /// or load).
    pub motion: Motion,
    /// The forces and moments of the punch on the foundation \[N, N m\].
    pub(crate) resultants: PerDof<f64>,
    /// The semi-axes of the contact along x and y \[m\], an ellipse around the origin.
    pub(crate) semi_axes: [f64; 2],
    /// The semi-axes of the part of it that sticks \[m\]; 0 where nothing does, as without
    /// friction.
    pub(crate) stick_semi_axes: [f64; 2],
    /// The largest pressure \[Pa\]; `None` where it is unbounded: at the edge of a flat sole, at
    /// the tip of a cone.
    pub(crate) peak_pressure: Option<f64>,
    /// The pressure p₁.
    pub(crate) pressure: Pressure,
    /// The tangential traction (p₂, p₃).
    pub(crate) traction: Traction,
}

/// A pressure on an ellipse around the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Pressure {
    /// Hertz's pressure p₀ √(1 − x²/a² − y²/b²).
    Hertz {
        /// The pressure p₀ in the middle \[Pa\].
        peak: f64,
        /// The semi-axes a and b \[m\].
        semi_axes: [f64; 2],
    },
    /// The pressure p₀ acosh(a/r) under a cone: unbounded at the tip, and in L₂.
    Cone {
        /// The pressure p₀, the mean over the contact \[Pa\].
        scale: f64,
        /// The radius a of the contact \[m\].
        radius: f64,
    },
    /// The pressure (p₀ + g·(x, y)) / √(1 − r²/a²) under a disk: not in L₂.
    Disk {
        /// The pressure p₀ in the middle \[Pa\].
        center: f64,
        /// The gradient g of the numerator along x and y \[Pa/m\].
        gradient: [f64; 2],
        /// The radius a of the contact \[m\].
        radius: f64,
    },
}

/// A tangential traction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Traction {
    /// No traction.
    Zero,
    /// The traction μ (p − p*) along a direction, with the contact's pressure p and that of a
    /// smaller approach p*, which spreads over the part that sticks.
    PartialSlip {
        /// The friction coefficient μ times the direction \[1\].
        friction: [f64; 2],
        /// The pressure p*; `None` where everything slides.
        sticking: Option<Pressure>,
    },
    /// The traction (q + t·(−y, x)) / √(1 − r²/a²) under a disk: not in L₂.
    Disk {
        /// The traction q in the middle \[Pa\].
        center: [f64; 2],
        /// The gradient t of the turn \[Pa/m\].
        turn: f64,
        /// The radius a of the contact \[m\].
        radius: f64,
    },
}

impl Pressure {
    /// Returns the pressure at (x, y) \[m\], 0 outside the contact \[Pa\].
    pub(crate) fn at(&self, x: f64, y: f64) -> f64 {
        match *self {
            Pressure::Hertz { peak, semi_axes: [a, b] } => {
                let r = (x / a).hypot(y / b);
                peak * ((1.0 - r) * (1.0 + r)).max(0.0).sqrt()
            }
            Pressure::Cone { scale, radius } => {
                let r = x.hypot(y);
                if r < radius { scale * (radius / r).acosh() } else { 0.0 }
            }
            Pressure::Disk { center, gradient, radius } => {
                (center + gradient[0] * x + gradient[1] * y) * inverse_root(x, y, radius)
            }
        }
    }

    /// Returns the semi-axes along x and y of the ellipse on which it acts \[m\].
    pub(crate) fn semi_axes(&self) -> [f64; 2] {
        match *self {
            Pressure::Hertz { semi_axes, .. } => semi_axes,
            Pressure::Cone { radius, .. } | Pressure::Disk { radius, .. } => [radius; 2],
        }
    }
}

/// Returns 1/√(1 − r²/a²), 0 from the edge on.
fn inverse_root(x: f64, y: f64, radius: f64) -> f64 {
    let r = x.hypot(y) / radius;
    if r < 1.0 { 1.0 / ((1.0 - r) * (1.0 + r)).sqrt() } else { 0.0 }
}

impl ClosedForm {
    /// Returns the tractions (p₁, p₂, p₃) at (x, y) \[m\], 0 outside the contact \[Pa\].
    pub(crate) fn tractions_at(&self, x: f64, y: f64) -> [f64; 3] {
        let pressure = self.pressure.at(x, y);
        let [along_x, along_y] = match self.traction {
            Traction::Zero => [0.0; 2],
            Traction::PartialSlip { friction, sticking } => friction.map(|friction| {
                friction * (pressure - sticking.map_or(0.0, |inner| inner.at(x, y)))
            }),
            Traction::Disk { center: [qx, qy], turn, radius } => {
                [qx - turn * y, qy + turn * x].map(|traction| traction * inverse_root(x, y, radius))
            }
        };
        [pressure, along_x, along_y]
    }

    /// Returns whether the tractions lie in L₂. If they do not, only resultants and local means can
    /// be compared.
    pub(crate) fn is_square_integrable(&self) -> bool {
        !matches!(self.pressure, Pressure::Disk { .. })
    }

    /// Returns the area of the contact \[m²\].
    pub(crate) fn contact_area(&self) -> f64 {
        PI * self.semi_axes[0] * self.semi_axes[1]
    }

    /// Returns the area of the part that sticks \[m²\].
    pub(crate) fn stick_area(&self) -> f64 {
        PI * self.stick_semi_axes[0] * self.stick_semi_axes[1]
    }

    /// Returns the places where the tractions are not smooth.
    pub(super) fn kinks(&self) -> Kinks {
        let sticking = match self.traction {
            Traction::PartialSlip { sticking, .. } => sticking.map(|inner| inner.semi_axes()),
            Traction::Zero | Traction::Disk { .. } => None,
        };
        Kinks {
            ellipses: [Some(self.semi_axes), sticking].into_iter().flatten().collect(),
            center: matches!(self.pressure, Pressure::Cone { .. }),
        }
    }
}

/// Returns the exact answer of a scene, if there is one:
/// - for a sphere, ellipsoid or cone without tangential tractions (no friction, or neither coupling
///   nor tangential load), on any path;
/// - for the same with friction, moved or pulled in one direction, if there is neither coupling nor
///   ν (Σν/G = 0): the load comes first and stays as it is, or both come in one increment;
/// - for a flat disk without coupling that nowhere lifts off and, with friction, nowhere slips:
///   pressed, tilted, shifted and twisted.
///
/// `None` for everything else, such as layers, height maps, a coupling with friction (Spence's
/// problem has no closed form), a Cattaneo–Mindlin contact with ν > 0 (the theory leaves out the
/// slip across), or an Ω that cuts the contact.
pub fn closed_form(scene: &Scene) -> Option<ClosedForm> {
    scene.validate().ok()?;
    let relative = relative_bodies(scene, 1.0);
    if relative.layers.is_some() {
        return None;
    }
    // The effects decide it in the same way: a coupling that cancels there is left out of the
    // solution.
    let coupled = relative.surface.coupling != 0.0;
    if coupled && scene.friction.mu > 0.0 {
        return None;
    }
    let bodies = HalfSpace::new(&scene.foundation.surface()?, scene.punch.material.as_ref());
    let exact = match scene.punch.shape {
        Shape::Sphere { radius } => {
            curved(scene, &Indenter::paraboloid(&bodies, radius, radius), &bodies)?
        }
        Shape::Ellipsoid { radius_x, radius_y } => {
            curved(scene, &Indenter::paraboloid(&bodies, radius_x, radius_y), &bodies)?
        }
        Shape::Cone { angle } => {
            curved(scene, &Indenter::Cone { modulus: modulus(&bodies), angle }, &bodies)?
        }
        Shape::FlatDisk { radius } => disk(scene, radius, &bodies)?,
        Shape::FlatRectangle { .. } | Shape::HeightMap { .. } | Shape::WheelOnRail(_) => {
            return None;
        }
    };
    let domain = domain(scene, &Surfaces::new()).ok()?;
    let reach = [(domain.center_x, domain.width_x), (domain.center_y, domain.width_y)]
        .map(|(center, width)| 0.5 * width - center.abs());
    let holds = reach
        .iter()
        .zip(exact.semi_axes)
        .all(|(reach, semi_axis)| semi_axis <= reach * (1.0 + 1e-12));
    let figures = exact.resultants.iter().chain(&exact.semi_axes);
    (holds && figures.copied().all(f64::is_finite) && exact.resultants[Dof::Approach] > 0.0)
        .then_some(exact)
}

/// Returns E* = 2/Σ((1−ν)/G) \[Pa\].
fn modulus(bodies: &HalfSpace) -> f64 {
    2.0 / bodies.direct
}

/// Returns whether a control prescribes no motion and no force.
fn is_nothing(control: Control) -> bool {
    matches!(control, Control::Motion(0.0) | Control::Force(0.0))
}

/// A punch whose contacts under any approach are similar.
enum Indenter {
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
struct Normal {
    load: f64,
    pressure: Pressure,
}

impl Indenter {
    fn paraboloid(bodies: &HalfSpace, radius_x: f64, radius_y: f64) -> Self {
        let curvatures = [0.5 / radius_x, 0.5 / radius_y];
        let approach = hertz_ellipse(1.0, curvatures[0], curvatures[1], 1.0).approach;
        Indenter::Paraboloid { modulus: modulus(bodies), curvatures, approach }
    }

    /// Returns the approach under a load.
    fn approach(&self, load: f64) -> f64 {
        match *self {
            Indenter::Paraboloid { modulus, approach, .. } => {
                approach * (load / modulus).cbrt().powi(2)
            }
            // The load goes as the square of the approach.
            Indenter::Cone { modulus, angle } => (load / cone(modulus, angle, 1.0).load).sqrt(),
        }
    }

    /// Returns the contact at an approach > 0.
    fn pressed(&self, approach: f64) -> Normal {
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
fn curved(scene: &Scene, indenter: &Indenter, bodies: &HalfSpace) -> Option<ClosedForm> {
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

/// The exact answer at the end of a leg under a flat disk.
struct DiskEnd {
    controls: PerDof<Control>,
    motion: PerDof<f64>,
    resultants: PerDof<f64>,
    pressure: Pressure,
    traction: Traction,
}

/// Returns the answer for a flat disk, whose contact is its sole: everything is proportional to the
/// motions, whatever the path.
fn disk(scene: &Scene, radius: f64, bodies: &HalfSpace) -> Option<ClosedForm> {
    let mu = scene.friction.mu;
    let e = modulus(bodies);
    let (tilt, shear) = (
        tilted_disk(e, radius, 1.0),
        shifted_disk(2.0 * bodies.direct + bodies.cross, radius, 1.0),
    );
    let tangential = if mu > 0.0 { 1.0 } else { 0.0 };
    let stiffness = PerDof::new([
        flat_disk(e, radius, 1.0).load,
        tangential * shear,
        tangential * shear,
        tilt,
        tilt,
        tangential * twisted_disk(bodies.direct + bodies.cross, radius, 1.0),
    ]);
    let legs = scene.loading.legs();
    let mut end = None;
    for leg in &legs {
        let (mut motion, mut resultants) = (PerDof::all(0.0), PerDof::all(0.0));
        for dof in Dof::ALL {
            (motion[dof], resultants[dof]) = match leg.target[dof] {
                Control::Motion(moved) => (moved, moved * stiffness[dof]),
                Control::Force(force) if stiffness[dof] > 0.0 => (force / stiffness[dof], force),
                Control::Force(0.0) => (0.0, 0.0),
                Control::Force(_) => return None,
            };
        }
        let [load, force_x, force_y, moment_x, moment_y, moment_z] = resultants.to_array();
        // The integrals over the disk are ∫ 1/√(1−r²/a²) = 2πa² and ∫ x²/√(1−r²/a²) = ⅔πa⁴.
        let (mean, first) = (2.0 * PI * radius * radius, 2.0 / 3.0 * PI * radius.powi(4));
        let pressure = Pressure::Disk {
            center: load / mean,
            gradient: [-moment_y / first, moment_x / first],
            radius,
        };
        let (center, turn) = ([force_x / mean, force_y / mean], 0.5 * moment_z / first);
        let least = load / mean - moment_x.hypot(moment_y) / first * radius;
        // Tractions and the pressure have the same root, so that what holds for the numerators at
        // the edge holds everywhere. Between the ends of two steps motions and forces are means of
        // theirs.
        let most = center[0].hypot(center[1]) + turn.abs() * radius;
        if least <= 0.0 || (mu > 0.0 && most >= mu * least) {
            return None;
        }
        let traction =
            if most > 0.0 { Traction::Disk { center, turn, radius } } else { Traction::Zero };
        end = Some(DiskEnd { controls: leg.target, motion, resultants, pressure, traction });
    }
    let DiskEnd { controls, motion, resultants, pressure, traction } = end?;
    let moves = |dofs: &[Dof]| dofs.iter().any(|dof| resultants[*dof] != 0.0);
    let (name, source) = match (moves(&Dof::SHIFTS), moves(&[Dof::Twist]), moves(&Dof::TILTS)) {
        (true, true, _) => (
            "Mindlin's and Reissner and Sagoci's disk",
            "Mindlin 1949, doi:10.1115/1.4009973; Reissner and Sagoci 1944, doi:10.1063/1.1707489",
        ),
        (true, false, _) => {
            ("Mindlin's disk", "Mindlin, J. Appl. Mech. 16 (1949) 259–268, doi:10.1115/1.4009973")
        }
        (false, true, _) => (
            "Reissner and Sagoci's disk",
            "Reissner and Sagoci, J. Appl. Phys. 15 (1944) 652, doi:10.1063/1.1707489",
        ),
        (false, false, true) => {
            ("Boussinesq's disk, tilted", "Johnson, Contact Mechanics, 1985, section 3.4")
        }
        (false, false, false) => {
            ("Boussinesq's disk", "Sneddon 1965, doi:10.1016/0020-7225(65)90019-4")
        }
    };
    Some(ClosedForm {
        name,
        source,
        controls,
        motion: Motion::from_per_dof(motion),
        resultants,
        semi_axes: [radius; 2],
        stick_semi_axes: if mu > 0.0 { [radius; 2] } else { [0.0; 2] },
        peak_pressure: None,
        pressure,
        traction,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assess::quadrature::Rectangle;
    use crate::model::{Foundation, Friction, Loading, Material, Punch, Step, rigid_modes};
    use crate::theory::{cattaneo_shift, cattaneo_stick_ratio, hertz_sphere};

    fn scene(shape: Shape, poisson: f64, mu: f64, steps: &[Step]) -> Scene {
        Scene {
            foundation: Foundation::half_space(Material { shear_modulus: 3.0, poisson }),
            punch: Punch {
                shape,
                material: (poisson != 0.5).then_some(Material { shear_modulus: 3.0, poisson }),
            },
            friction: Friction { mu },
            domain: None,
            loading: Loading::path(steps.to_vec()),
        }
    }

    /// Returns the resultants by integration over the box around the contact.
    fn integrated(exact: &ClosedForm) -> PerDof<f64> {
        let [a, b] = exact.semi_axes;
        let sums = exact.kinks().integrate(Rectangle { x: [-a, a], y: [-b, b] }, &|x, y| {
            let (tractions, modes) = (exact.tractions_at(x, y), rigid_modes(x, y));
            Dof::ALL.map(|dof| (0..3).map(|c| modes[c][dof] * tractions[c]).sum())
        });
        PerDof::new(sums)
    }

    #[test]
    fn tractions_have_the_resultants() {
        let press = Step { approach: Some(0.01), ..Step::default() };
        let pull = Step { shift_x: Some(0.0008), shift_y: Some(-0.0004), ..Step::default() };
        let sole = Step {
            normal_force: Some(1.0),
            shift_x: Some(0.002),
            tilt_x: Some(0.01),
            moment_y: Some(0.1),
            ..pull
        };
        let curved = [
            Shape::Sphere { radius: 0.7 },
            Shape::Ellipsoid { radius_x: 0.3, radius_y: 2.0 },
            Shape::Cone { angle: 0.2 },
        ];
        let mut scenes: Vec<Scene> =
            curved.iter().map(|shape| scene(shape.clone(), 0.3, 0.0, &[press])).collect();
        scenes.extend(curved.iter().map(|shape| scene(shape.clone(), 0.0, 0.2, &[press, pull])));
        scenes.push(scene(
            Shape::FlatDisk { radius: 0.4 },
            0.5,
            0.9,
            &[Step { twist: Some(0.01), ..sole }],
        ));
        scenes.push(scene(
            Shape::FlatDisk { radius: 0.4 },
            0.3,
            0.9,
            &[Step { twist: Some(0.01), ..sole }],
        ));
        for scene in &scenes {
            let exact = closed_form(scene).unwrap_or_else(|| panic!("{scene:?}"));
            for (sum, resultant) in integrated(&exact).iter().zip(exact.resultants) {
                assert!(
                    (sum - resultant).abs() < 1e-6 * exact.resultants[Dof::Approach],
                    "{}: {sum} {resultant}",
                    exact.name
                );
            }
        }
    }

    #[test]
    fn partial_slip_of_a_sphere_is_that_of_cattaneo_and_mindlin() {
        let (approach, mu) = (0.01, 0.2);
        // Together the two bodies have E* = 2G.
        let hertz = hertz_sphere(3.0, 0.7, approach);
        let limit = mu * hertz.load;
        let press = Step { normal_force: Some(hertz.load), ..Step::default() };
        for part in [1e-3, 0.3, 0.9, 0.9999] {
            let pull = Step { force_y: Some(-part * limit), ..Step::default() };
            let exact = closed_form(&scene(Shape::Sphere { radius: 0.7 }, 0.0, mu, &[press, pull]))
                .unwrap();
            let shift = cattaneo_shift(part * limit, limit, hertz.radius, 4.0 / 3.0);
            assert!((exact.motion.shift_y / -shift - 1.0).abs() < 1e-10, "{part}: {exact:?}");
            let stick = cattaneo_stick_ratio(part * limit, limit);
            assert!((exact.stick_semi_axes[0] / (stick * hertz.radius) - 1.0).abs() < 1e-10);
            assert!((exact.motion.approach / approach - 1.0).abs() < 1e-12);
            // The shift, prescribed in turn, gives the force back.
            let move_it = Step { shift_y: Some(-shift), ..Step::default() };
            let back =
                closed_form(&scene(Shape::Sphere { radius: 0.7 }, 0.0, mu, &[press, move_it]))
                    .unwrap();
            assert!((back.resultants[Dof::ShiftY] / (-part * limit) - 1.0).abs() < 1e-10);
        }
        let slide = Step { shift_x: Some(1.0), ..Step::default() };
        let sliding =
            closed_form(&scene(Shape::Sphere { radius: 0.7 }, 0.0, mu, &[press, slide])).unwrap();
        assert!(
            (sliding.resultants[Dof::ShiftX] / limit - 1.0).abs() < 1e-12
                && sliding.stick_area() == 0.0
        );
    }

    #[test]
    fn loads_and_approaches_are_each_others_inverse() {
        for shape in [
            Shape::Sphere { radius: 0.7 },
            Shape::Ellipsoid { radius_x: 0.3, radius_y: 2.0 },
            Shape::Cone { angle: 0.2 },
        ] {
            let press = Step { approach: Some(0.01), ..Step::default() };
            let exact = closed_form(&scene(shape.clone(), 0.3, 0.0, &[press])).unwrap();
            let load =
                Step { normal_force: Some(exact.resultants[Dof::Approach]), ..Step::default() };
            let back = closed_form(&scene(shape, 0.3, 0.0, &[load])).unwrap();
            assert!(
                (back.motion.approach / 0.01 - 1.0).abs() < 1e-13
                    && (back.semi_axes[0] / exact.semi_axes[0] - 1.0).abs() < 1e-13
            );
        }
    }
}
