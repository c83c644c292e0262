//! The units that make a problem dimensionless, and the range of double precision in them. Sizes,
//! moduli and loads beyond that range are refused, in words, before anything is solved.

use crate::foundation::Bodies;
use crate::grid::Grid;
use crate::model::{Base, Dof, Numerics, PerDof, Projection, Rolling, Scene, SceneError, Step};

/// The units in which a [`Problem`](super::Problem) is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The unit of length ℓ \[m\].
    pub length: f64,
    /// The unit of compliance c = Σ(1−ν)/G \[1/Pa\].
    pub compliance: f64,
}

impl Scale {
    /// Returns the unit of traction, 1/c \[Pa\].
    pub fn traction(&self) -> f64 {
        1.0 / self.compliance
    }

    /// Returns the units of the six rigid degrees of freedom \[m or rad\].
    pub fn motions(&self) -> PerDof<f64> {
        let l = self.length;
        PerDof::new([l, l, l, 1.0, 1.0, 1.0])
    }

    /// Returns the units of their forces and moments \[N or N m\].
    pub(crate) fn forces(&self) -> PerDof<f64> {
        let force = self.traction() * self.length * self.length;
        let moment = force * self.length;
        PerDof::new([force, force, force, moment, moment, moment])
    }
}

/// Refuses sizes or moduli that double precision cannot hold once they are put in relation.
pub(crate) fn out_of_range(key: &str, value: f64) -> SceneError {
    SceneError {
        key: key.to_owned(),
        value: format!("{value:e}"),
        expected: "leads beyond the range of double precision; choose sizes and moduli nearer to 1 in SI units".to_owned(),
    }
}

/// The range of a problem's numbers in its units, in which their squares and the squares of their
/// results are doubles.
const SQUARABLE: std::ops::RangeInclusive<f64> = 1e-120..=1e120;

/// The range of the moduli below the surface in units of that at the surface. The coefficients are
/// good to some 1e-14 of the largest of them, and on a stiff plate the normal ones grow as the
/// contrast to the power of ⅔ against the others. A base that is stiffer than the range is rigid.
const CONTRAST: std::ops::RangeInclusive<f64> = 1e-15..=1e15;

/// Refuses a modulus outside of [`CONTRAST`].
fn too_unlike(key: &str, contrast: f64) -> SceneError {
    SceneError {
        key: key.to_owned(),
        value: format!("{contrast:e} times as stiff as the surface"),
        expected:
            "must be between 1e-15 and 1e15, beyond which double precision loses the softer or the stiffer one; a base can be \"rigid\""
                .to_owned(),
    }
}

/// Refuses moduli and sizes whose units are no doubles, and layers or a base that differ from the
/// surface by more than can be squared. `bodies` have moduli in units of `modulus`, that of the
/// surface \[Pa\], and lengths in units of ℓ, in which `element` is given too.
pub(crate) fn check_units(
    modulus: f64,
    bodies: &Bodies,
    scale: &Scale,
    element: [f64; 2],
) -> Result<(), SceneError> {
    if !(scale.compliance.is_normal() && scale.traction().is_normal()) {
        return Err(out_of_range("foundation.base.shear_modulus", modulus));
    }
    if let Some(layered) = &bodies.layers {
        for layer in layered.layers() {
            if !SQUARABLE.contains(&layer.thickness) {
                return Err(out_of_range("foundation.layers", layer.thickness * scale.length));
            }
            if !CONTRAST.contains(&layer.shear_modulus) {
                return Err(too_unlike("foundation.layers", layer.shear_modulus));
            }
        }
        match layered.base() {
            Base::Elastic(base) if !CONTRAST.contains(&base.shear_modulus) => {
                return Err(too_unlike("foundation.base", base.shear_modulus));
            }
            Base::Elastic(_) | Base::Rigid => {}
        }
    }
    let units_hold = scale.length.is_normal() && scale.forces().iter().all(|unit| unit.is_normal());
    if !(units_hold && element.iter().all(|side| side.is_normal())) {
        return Err(out_of_range("domain.width_x", 2.0 * scale.length));
    }
    Ok(())
}

/// The smallest normal coefficient of an element, in units of its tangential ones, that is more
/// than their rounding.
const NORMAL: f64 = 1e-9;

/// Refuses layers that pressure cannot move. A nearly incompressible layer on a rigid base that is
/// much thinner than the elements gives way at the edges of a loaded element only. The element's
/// mean displacement is then a small part of the numbers from which the coefficients are computed,
/// and at its centre there is none. `bodies` have lengths in the grid's unit.
pub(crate) fn check_operator(
    bodies: &Bodies,
    grid: &Grid,
    projection: Projection,
) -> Result<(), SceneError> {
    let (hx, hy) = (grid.hx(), grid.hy());
    let Some(layered) = &bodies.layers else { return Ok(()) };
    let long = layered.compliance(1.0 / hx.max(hy));
    if long.nn > 1e-3 * long.ll {
        return Ok(()); // The layers are far from this case.
    }
    let diagonal = bodies.kernels(hx.hypot(hy)).influence([0.0; 2], hx, hy, projection);
    let tangential = diagonal.xx.max(diagonal.yy);
    if diagonal.nn > NORMAL * tangential {
        return Ok(());
    }
    Err(SceneError {
        key: "foundation.layers".to_owned(),
        value: format!(
            "a pressed element goes down by {:.1e} of what it gives sideways",
            (diagonal.nn / tangential).max(0.0)
        ),
        expected: format!(
            "must be at least {NORMAL:e}: double precision knows no less; take a thicker or more compressible layer, smaller elements, or \
             `projection = \"average\"`"
        ),
    })
}

/// Refuses loads that no double can answer for: loads whose size cannot be squared, loads beyond
/// those that the ceiling carries, and loads so small that an approach rounded to a double is too
/// coarse for them. `rest` is −g₀ in units of ℓ.
pub(crate) fn check_loads(
    scene: &Scene,
    numerics: &Numerics,
    scale: &Scale,
    grid: &Grid,
    rest: &[f64],
) -> Result<(), SceneError> {
    let refuse = |key: &str, value: f64, expected: String| {
        Err(SceneError { key: key.to_owned(), value: format!("{value:e}"), expected })
    };
    if numerics.epsilon > *SQUARABLE.end() {
        let end = SQUARABLE.end();
        return refuse(
            "epsilon",
            numerics.epsilon,
            format!(
                "leads to tractions too small to be squared in double precision; at most {end:e}"
            ),
        );
    }
    if let Some(ceiling) = numerics.ceiling
        && ceiling * scale.compliance < *SQUARABLE.start()
    {
        let least = SQUARABLE.start() * scale.traction();
        return refuse(
            "ceiling",
            ceiling,
            format!(
                "is too small to be squared in double precision next to the moduli; at least {least:e}"
            ),
        );
    }
    let (motions, forces) = (scale.motions(), scale.forces());
    let area = grid.element_area();
    let top = grid.active().map(|e| rest[e]).fold(f64::NEG_INFINITY, f64::max);
    for (i, step) in scene.loading.steps.iter().enumerate() {
        let squarable = |name: &str, value: f64, unit: f64| {
            let relative = (value / unit).abs();
            // The last unit is that of energy too.
            if value == 0.0
                || SQUARABLE.contains(&relative)
                    && (relative * relative * forces[Dof::Twist]).is_finite()
            {
                return Ok(());
            }
            let most = SQUARABLE.end().min((f64::MAX / forces[Dof::Twist]).sqrt());
            let [low, high] = [*SQUARABLE.start(), most].map(|end| end * unit);
            let expected = format!(
                "cannot be squared in double precision next to sizes and moduli; 0, or between {low:e} and {high:e}"
            );
            refuse(&format!("loading.steps[{i}].{name}"), value, expected)
        };
        for dof in Dof::ALL {
            let ([motion, force], [motion_name, force_name]) =
                (step.given()[dof], Step::NAMES[dof]);
            squarable(motion_name, motion.unwrap_or(0.0), motions[dof])?;
            squarable(force_name, force.unwrap_or(0.0), forces[dof])?;
        }
        if let Some(rolling) = &step.rolling {
            let distance = rolling.dq.unwrap_or(grid.hx() * scale.length);
            let unit = motions.map(|motion| motion / distance);
            let Rolling { creepage_x, creepage_y, spin, spin_center, .. } = *rolling;
            squarable("creepage_x", creepage_x.unwrap_or(0.0), unit[Dof::ShiftX])?;
            squarable("creepage_y", creepage_y.unwrap_or(0.0), unit[Dof::ShiftY])?;
            squarable("spin", spin.unwrap_or(0.0), unit[Dof::Twist])?;
            if let Some(spin) = spin.filter(|spin| *spin != 0.0) {
                squarable("spin_center", spin_center, unit[Dof::ShiftY] / spin.abs())?;
            }
        }
        let Some(force) = step.normal_force else { continue };
        let key = format!("loading.steps[{i}].normal_force");
        let most = numerics.ceiling.map_or(f64::INFINITY, |ceiling| {
            ceiling * grid.active_len() as f64 * area * scale.length * scale.length
        });
        if force >= most {
            let expected = format!(
                "is no less than the ceiling lets the whole sole carry, {most:e} N; raise the ceiling or lower the load"
            );
            return refuse(&key, force, expected);
        }
        // The stiffness is that of one element alone, taken for a disk. The approach is the sum of
        // its indentation and its gap, and the gap decides the approach's last digit.
        let stiffness = 4.0 * (area / std::f64::consts::PI).sqrt();
        let coarse = 0.5 * f64::EPSILON * top.abs() * stiffness;
        if numerics.tolerance * force / forces[Dof::Approach] < coarse {
            let least = coarse * forces[Dof::Approach] / numerics.tolerance;
            let expected = format!(
                "is too small to be met to the tolerance: one element gets about {least:e} N from the last digit of an approach that the gap of \
                 {:e} m is part of; make Ω or the elements smaller",
                top.abs() * scale.length
            );
            return refuse(&key, force, expected);
        }
    }
    Ok(())
}
