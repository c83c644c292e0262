//! The cut of Ω into elements, and the unit of length that goes with it.

use std::borrow::Cow;

use super::scale::{self, Scale};
use crate::foundation::{Bodies, surface};
use crate::model::{Domain, Numerics, Scene, SceneError, Shape};
use crate::punch::{Surfaces, domain, with_creepages};

/// The cut of Ω into elements.
pub(crate) struct Layout {
    /// The number of elements along x.
    pub(crate) nx: usize,
    /// The number of elements along y.
    pub(crate) ny: usize,
    /// The size of an element along x and y, in units of ℓ.
    pub(crate) element: [f64; 2],
    /// The unit of length ℓ, half the diameter of Ω \[m\].
    pub(crate) half_diameter: f64,
    /// The fact that the punch goes on beyond Ω.
    pub(super) open_edge: bool,
    /// The radius that decides which elements belong to the sole, in elements, for a disk that
    /// chooses Ω.
    pub(super) disk: Option<f64>,
}

impl Layout {
    /// Cuts a domain as the numerics ask for.
    pub(crate) fn new(scene: &Scene, numerics: &Numerics, domain: &Domain) -> Self {
        let aspect = domain.width_y / domain.width_x;
        let [nx, ny] = numerics.mesh.sides().map(|n| n as usize);
        let element = [
            2.0 / (nx as f64 * 1f64.hypot(aspect)),
            2.0 * aspect / (ny as f64 * 1f64.hypot(aspect)),
        ];
        let layout = Self {
            nx,
            ny,
            element,
            half_diameter: 0.5 * domain.width_x.hypot(domain.width_y),
            open_edge: false,
            disk: None,
        };
        match scene.punch.shape {
            Shape::FlatDisk { radius } if scene.domain.is_none() && nx == ny => {
                // The staircase of elements whose centre lies inside the disk does not have the
                // disk's area, and load and stiffness follow the area. Elements that are sized so
                // that the areas agree make the error smaller and its decrease smooth (the tests
                // `closed_forms` hold it to first order).
                let reach = 0.5 * nx as f64;
                let along = |i: usize| i as f64 + 0.5 - reach;
                let count =
                    (0..nx * ny).filter(|&s| along(s % nx).hypot(along(s / nx)) <= reach).count();
                let side = (std::f64::consts::PI / count as f64).sqrt();
                Self { element: [side; 2], half_diameter: radius, disk: Some(reach), ..layout }
            }
            Shape::FlatDisk { radius } => Self {
                open_edge: domain.width_x.min(domain.width_y) < 2.0 * radius * (1.0 - 1e-12),
                ..layout
            },
            Shape::FlatRectangle { width_x, width_y }
            | Shape::HeightMap { width_x, width_y, .. } => Self {
                open_edge: domain.width_x < width_x * (1.0 - 1e-12)
                    || domain.width_y < width_y * (1.0 - 1e-12),
                ..layout
            },
            Shape::Sphere { .. }
            | Shape::Ellipsoid { .. }
            | Shape::Cone { .. }
            | Shape::WheelOnRail(_) => Self { open_edge: true, ..layout },
        }
    }

    /// Returns the units of the problem. Refuses sizes and moduli that lead beyond the range of
    /// doubles.
    pub(crate) fn scale(&self, scene: &Scene, bodies: &Bodies) -> Result<Scale, SceneError> {
        let modulus = surface(scene).shear_modulus;
        let scale = Scale {
            length: self.half_diameter,
            compliance: bodies.reference_compliance() / modulus,
        };
        scale::check_units(modulus, bodies, &scale, self.element)?;
        Ok(scale)
    }

    /// Refuses steps that roll in an increment by distances next to which Ω is nothing.
    pub(crate) fn check_reach(&self, scene: &Scene) -> Result<(), SceneError> {
        let most = FARTHEST * self.nx as f64 * self.element[0] * self.half_diameter;
        for (i, step) in scene.loading.steps.iter().enumerate() {
            if let Some(distance) = step.rolling.and_then(|rolling| rolling.dq)
                && distance > most
            {
                return Err(SceneError {
                    key: format!("loading.steps[{i}].dq"),
                    value: format!("{distance:e}"),
                    expected: format!(
                        "must be at most a thousand lengths of Ω, {most:e} m, in an increment: \
                         after one of them nothing is left of what was in contact before"
                    ),
                });
            }
        }
        Ok(())
    }
}

/// Returns a scene as it is on its grid: with the creepages that the motion of its wheelset
/// imposes, and with the increments that the elements make of the distances that it rolls.
///
/// # Errors
/// A [`SceneError`] reports a domain or creepages that cannot be derived, or too many increments.
pub(crate) fn on_grid<'a>(
    scene: &'a Scene,
    numerics: &Numerics,
    surfaces: &Surfaces,
) -> Result<Cow<'a, Scene>, SceneError> {
    let mut scene = with_creepages(scene, surfaces)?;
    if scene.loading.is_divided_by_elements() {
        let layout = Layout::new(&scene, numerics, &domain(&scene, surfaces)?);
        let loading = scene.loading.divided(layout.element[0] * layout.half_diameter)?;
        scene.to_mut().loading = loading;
    }
    Ok(scene)
}

/// The lengths of Ω that a contact may go on in an increment. What is farther away than some
/// lengths of a contact is out of its reach, and the tables of layers end somewhere.
const FARTHEST: f64 = 1e3;

/// The smallest part of an element that a contact goes on in steady rolling. From nearer, the mesh
/// does not see a difference of displacements: with a hundredth Newton's method fails.
pub(crate) const LEAST_DISTANCE: f64 = 0.1;

/// Refuses steps that roll steadily by distances that elements of this length along x \[m\] do not
/// resolve.
pub(crate) fn check_distances(scene: &Scene, element: f64) -> Result<(), SceneError> {
    let least = LEAST_DISTANCE * element;
    for leg in scene.loading.legs().iter().filter(|leg| leg.is_steady()) {
        if let Some(distance) = leg.rolling.and_then(|rolling| rolling.dq)
            && distance < least * (1.0 - 1e-9)
        {
            return Err(SceneError {
                key: format!("loading.steps[{}].dq", leg.step),
                value: format!("{distance:e}"),
                expected: format!(
                    "must be at least a tenth of an element, {least:e} m, in steady rolling: from \
                     nearer the mesh does not see a difference"
                ),
            });
        }
    }
    Ok(())
}
