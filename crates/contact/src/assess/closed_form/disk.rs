//! The exact answers under a flat disk whose sole sticks everywhere or has no friction.

use std::f64::consts::PI;

use super::bodies::modulus;
use super::exact::{ClosedForm, Pressure, Traction};
use crate::foundation::HalfSpace;
use crate::model::{Control, Dof, Motion, PerDof, Scene};
use crate::theory::{flat_disk, shifted_disk, tilted_disk, twisted_disk};

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
pub(super) fn disk(scene: &Scene, radius: f64, bodies: &HalfSpace) -> Option<ClosedForm> {
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
