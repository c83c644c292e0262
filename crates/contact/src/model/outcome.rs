//! The result of a solve: observables, a certificate, the work done, the fields, and the status.
//!
//! Everything here must stay encodable by formats that do not describe themselves (no flattened,
//! tagged or skipped fields), but for what is further asked for, which is encoded apart from the
//! rest.

use serde::{Deserialize, Serialize};

use super::further::{Further, FurtherFields};
use super::rigid::{Motion, PerDof};
use super::rolling::RollingDirection;

/// The end of a solve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Status {
    /// The certificate meets the requested tolerance.
    Certified,
    /// The certificate does not meet the tolerance. The figures of the last iterate are kept, but
    /// it is no solution.
    Failed {
        /// The reason, in words with figures.
        reason: String,
    },
}

/// The deterministic result of one job: equal scenes and numerics have results of the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The status of the whole path: it is certified if every increment is.
    pub status: Status,
    /// The coarser grids on which the start of the first increment was found, or the path followed
    /// for an estimate of the error, from coarse to fine.
    pub levels: Vec<Level>,
    /// Every increment of the path that was solved, in order. Of a path that could not be followed
    /// the last one is the increment at which it failed; those before it are solutions.
    pub steps: Vec<StepOutcome>,
    /// Hertz's contact under the load at the end of the path, for smooth punches on a homogeneous
    /// foundation.
    pub hertz: Option<Hertz>,
    /// The place at which a wheel meets its rail, at the end of the path.
    pub rail: Option<RailContact>,
    /// The estimated distance of the end of the path from the limit of ever finer meshes. `None` if
    /// nothing tells it: for a path that could not be followed or ends without contact, on fewer
    /// than four elements along a side, and if the grid of half as many elements along x and y is
    /// refused or the method fails on it.
    pub estimate: Option<Estimate>,
    /// The results that only this scene asks for; they are stored apart.
    #[serde(skip)]
    pub further: Further,
}

impl Outcome {
    /// Returns the end of the path, or the increment at which it failed.
    pub fn last(&self) -> Option<&StepOutcome> {
        self.steps.last()
    }

    /// Returns the work for the whole path: iterations on all grids, and operator applications on
    /// the grid itself, since those on the coarser [levels](Outcome::levels) cost a fraction.
    pub fn work(&self) -> WorkDone {
        let coarse: u64 = self.levels.iter().map(|level| level.work.iterations).sum();
        let sum = |count: fn(&WorkDone) -> u64| {
            self.steps.iter().map(|step| count(&step.work)).sum::<u64>()
        };
        WorkDone {
            iterations: coarse + sum(|work| work.iterations),
            operator_applications: sum(|work| work.operator_applications),
        }
    }

    /// Returns the last resort that any increment needed.
    pub fn route(&self) -> Option<Route> {
        self.steps.iter().map(|step| step.route).max()
    }

    /// Returns the energy that is lost to friction along the path \[J\].
    pub fn dissipation(&self) -> f64 {
        self.steps.iter().map(|step| step.observables.dissipation).sum()
    }

    /// Returns the energy that is lost to friction in the last cycle \[J\], or `None` for a path
    /// without cycles.
    pub fn cycle_dissipation(&self) -> Option<f64> {
        let cycle = self.last()?.cycle;
        (cycle > 0).then(|| {
            self.steps
                .iter()
                .filter(|step| step.cycle == cycle)
                .map(|step| step.observables.dissipation)
                .sum()
        })
    }
}

/// The Hertzian contact with the gap's curvatures where it is smallest, under the same load.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hertz {
    /// The larger semi-axis of the ellipse \[m\].
    pub semi_axis_a: f64,
    /// The smaller semi-axis of the ellipse \[m\].
    pub semi_axis_b: f64,
    /// The area of the ellipse \[m²\].
    pub area: f64,
    /// The largest pressure \[Pa\].
    pub peak_pressure: f64,
    /// The approach \[m\].
    pub approach: f64,
}

/// A contact in track coordinates. x goes along the track, y to the right and z down; the origin is
/// midway between the rails at the height of their tops.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RailContact {
    /// The contact reference point \[m\]: the centre of the undeformed bodies' overlap, weighted
    /// with the square of the interpenetration, as CONTACT has it. Where patches have planes of
    /// their own, it is that of the one with the largest weight.
    pub track: [f64; 3],
    /// The (y, z) of the reference point in the rail profile's coordinates, with y to the right
    /// \[m\].
    pub rail: [f64; 2],
    /// The contact angle \[rad\]: the mean inclination of the rail there with the same weight, from
    /// y towards z.
    pub angle: f64,
    /// The centre of pressure on the rail \[m\]; without a load it is the reference point.
    pub pressure_center: [f64; 3],
    /// The distance of the wheelset below the position in which the wheel's rolling radius reaches
    /// the rails' tops \[m\].
    pub wheelset_height: f64,
}

impl Hertz {
    /// Returns the contact of the same bodies under so many times the load.
    pub fn under(&self, share: f64) -> Self {
        let length = share.cbrt();
        Self {
            semi_axis_a: self.semi_axis_a * length,
            semi_axis_b: self.semi_axis_b * length,
            area: self.area * length * length,
            peak_pressure: self.peak_pressure * length,
            approach: self.approach * length * length,
        }
    }
}

impl RailContact {
    /// Returns the force on the rail \[N\] in the axes of the track: the normal force and the
    /// tangential ones of `observables`, turned by the contact angle.
    pub fn track_force(&self, observables: &Observables) -> [f64; 3] {
        let (sin, cos) = self.angle.sin_cos();
        let Observables { load, force_x, force_y, .. } = *observables;
        [force_x, cos * force_y - sin * load, sin * force_y + cos * load]
    }
}

/// One increment of a loading path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepOutcome {
    /// The index of its step in [`Loading::steps`](super::loading::Loading::steps).
    pub step: u32,
    /// The number of the cycle, counted from 1; it is 0 before the cycle or without one.
    pub cycle: u32,
    /// The position of the punch.
    pub motion: Motion,
    /// The integral quantities in SI units.
    pub observables: Observables,
    /// The residuals, which are independent of the solver.
    pub certificate: Certificate,
    /// The work for the increment.
    pub work: WorkDone,
    /// The way to the solution; it is stored under the name `way`.
    #[serde(rename = "way")]
    pub route: Route,
}

/// The way to a solution: a method, or the one that it fell back on. Each of the later ones is
/// tried if the one before it fails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Route {
    /// Newton's method, with the motions that forces govern among its unknowns.
    #[default]
    Newton,
    /// Newton's method for prescribed motions within one for the forces, or from solutions with
    /// more friction.
    NewtonWithinForces,
    /// Newton's method within one for the forces, with Seidel sweeps where it does not converge.
    NewtonAndSeidel,
    /// Seidel's iteration, within a Newton iteration for the forces where there are any.
    Seidel,
    /// Newton's method within one for the forces, with a path that rolls where it does not converge
    /// to the steady state.
    NewtonAndRolling,
}

impl Route {
    /// Returns the way in words, as the column `way` has it.
    pub fn words(self) -> &'static str {
        match self {
            Route::Newton => "newton",
            Route::NewtonWithinForces => "newton within forces",
            Route::NewtonAndSeidel => "newton and seidel",
            Route::Seidel => "seidel",
            Route::NewtonAndRolling => "newton and rolling",
        }
    }
}

/// Integral quantities of a solution. Forces and moments are those of the punch on the foundation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Observables {
    /// The normal force P = Σ p₁ |e| \[N\].
    pub load: f64,
    /// The tangential force along x, Σ p₂ |e| \[N\].
    pub force_x: f64,
    /// The tangential force along y, Σ p₃ |e| \[N\].
    pub force_y: f64,
    /// The moment about x, Σ y p₁ |e| \[N m\], work-conjugate to tilt_x.
    pub moment_x: f64,
    /// The moment about y, −Σ x p₁ |e| \[N m\], work-conjugate to tilt_y.
    pub moment_y: f64,
    /// The moment about z, Σ (x p₃ − y p₂) |e| \[N m\], work-conjugate to twist.
    pub moment_z: f64,
    /// The area with p₁ > 0 \[m²\].
    pub contact_area: f64,
    /// The area in contact that sticks \[m²\].
    pub stick_area: f64,
    /// The area in contact that slips \[m²\].
    pub slip_area: f64,
    /// The number of elements in contact.
    pub contact_elements: u64,
    /// The number of elements that stick.
    pub stick_elements: u64,
    /// The number of elements that slip.
    pub slip_elements: u64,
    /// The number of separate contact regions; elements that share a corner belong to the same
    /// region.
    pub patches: u64,
    /// The area that could be in contact: Ω as far as the punch has a sole \[m²\].
    pub sole_area: f64,
    /// The largest gap on the sole \[m\].
    pub largest_gap: f64,
    /// The largest p₁ \[Pa\].
    pub peak_pressure: f64,
    /// The largest |p_t| \[Pa\].
    pub peak_traction: f64,
    /// The elastic energy ½ Σ p·(A p) |e| \[J\].
    pub energy: f64,
    /// The energy that is lost to friction in this increment, −Σ p_t·w_t |e| ≥ 0 \[J\].
    pub dissipation: f64,
    /// The work that the punch's motion did in this increment, the mean of the forces before and
    /// after times the change of the motion \[J\].
    pub external_work: f64,
    /// The number of elements at which the ceiling u is active; above 0 the result solves equation
    /// (3) but not (1).
    pub ceiling_elements: u64,
    /// The number of elements in contact at the edge of Ω although the punch goes on beyond it;
    /// above 0, Ω is too small.
    pub edge_elements: u64,
    /// The number of elements along x.
    pub mesh_x: u64,
    /// The number of elements along y.
    pub mesh_y: u64,
    /// The size of an element along x \[m\].
    pub element_x: f64,
    /// The size of an element along y \[m\].
    pub element_y: f64,
}

impl Observables {
    /// Returns the force or moment of each degree of freedom
    /// ([`Step::NAMES`](super::loading::Step::NAMES)).
    pub fn resultants(&self) -> PerDof<f64> {
        PerDof::new([
            self.load,
            self.force_x,
            self.force_y,
            self.moment_x,
            self.moment_y,
            self.moment_z,
        ])
    }

    /// Returns the size of the tangential force \[N\], or 0 where it is less than a millionth of
    /// the largest traction on all of the contact, and so the rounding of tractions that balance.
    pub fn tangential_force(&self) -> f64 {
        let force = self.force_x.hypot(self.force_y);
        if force > 1e-6 * self.peak_traction * self.contact_area { force } else { 0.0 }
    }
}

/// The residuals of a claimed solution, computed by code that shares nothing with the solvers
/// ([`certify`](crate::assess::certify)). All are relative and dimensionless, and 0 for an exact
/// solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// The natural-map residual ‖p − Gᵘ_μ(p − E(εp + Ap − f))‖ / ‖p‖ with E = 1/(ε + diagonal entry
    /// of A). One E is for the normal direction and one, from the larger entry, for the tangential
    /// ones; in steady rolling the latter is from the largest tangential coefficient of its
    /// operator. In a scene that rolls the tangential components are measured for themselves too,
    /// ‖p_t − G_t‖ over the largest of ‖p_t‖, ‖G_t‖ and, after other increments, the norm of the
    /// displacements \[ℓ\] that they left; the larger of the two figures counts. So are the
    /// displacements by the transform.
    pub residual: f64,
    /// The tension −min(p₁, 0) / max |p₁|, which is 0 if there is none.
    pub tension: f64,
    /// The largest penetration −min(w₁, 0) over max |(A p)₁|.
    pub penetration: f64,
    /// The largest gap under pressure, max (w₁ p₁)/(max p₁ · max|(Ap)₁|).
    pub gap_under_pressure: f64,
    /// The largest violation of the friction cone, (|p_t| − μ p₁)₊ / max p₁.
    pub cone_violation: f64,
    /// The largest angle between slip and −traction \[rad\] over elements whose slip is well above
    /// rounding.
    pub slip_angle: f64,
    /// The largest difference between a resultant (P, Qx, Qy) that is claimed or prescribed and the
    /// one that is summed anew, over Σ |p| |e|; for moments it is over Σ |p| |e| times ℓ. In a
    /// scene that rolls the tangential ones are over Σ |p_t| |e|, or what earlier increments left.
    pub force_imbalance: f64,
}

/// The work for a solve. It is deterministic, unlike seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkDone {
    /// The number of iterations of the method (for Seidel, of sweeps).
    pub iterations: u64,
    /// The number of operator applications; a full Seidel sweep over the contact counts as one.
    pub operator_applications: u64,
}

/// A coarser grid on which a start was sought, or on which the path was followed for an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Level {
    /// The numbers of elements along x and y.
    pub elements: [u32; 2],
    /// The work on this grid.
    pub work: WorkDone,
}

/// The fields on the grid in SI units, row-major with x fastest. Masked elements have zeros.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fields {
    /// The numbers of elements along x and y.
    pub shape: [u32; 2],
    /// The centre of element (0, 0) \[m\].
    pub origin: [f64; 2],
    /// The size of an element along x and y \[m\].
    pub element: [f64; 2],
    /// The pressure p₁ ≥ 0 \[Pa\].
    pub pressure: Vec<f64>,
    /// The traction p₂ along x, of the punch on the foundation \[Pa\].
    pub traction_x: Vec<f64>,
    /// The traction p₃ along y, of the punch on the foundation \[Pa\].
    pub traction_y: Vec<f64>,
    /// The gap w₁ \[m\].
    pub gap: Vec<f64>,
    /// The slip w₂ along x \[m\], of the foundation's surface relative to the punch since the
    /// increment before. It is 0 if the scene has no tangential tractions, for then it is not
    /// computed.
    pub slip_x: Vec<f64>,
    /// The slip w₃ along y \[m\], likewise.
    pub slip_y: Vec<f64>,
    /// The [`State`] of each element: 0 outside the sole, 1 open, 2 stick, 3 slip.
    #[serde(with = "serde_bytes")]
    pub state: Vec<u8>,
    /// The fields that only this scene asks for; they are stored apart.
    #[serde(skip)]
    pub further: FurtherFields,
}

impl Fields {
    /// Returns the x of the edge of the contact that leads in a direction of rolling \[m\]: the
    /// outer side of the foremost element in contact; `None` without contact.
    pub fn leading_edge(&self, direction: RollingDirection) -> Option<f64> {
        let nx = self.shape[0] as usize;
        let touches = |state: &u8| [State::Stick as u8, State::Slip as u8].contains(state);
        let columns = self.state.iter().enumerate().filter(|(_, state)| touches(state));
        let columns = columns.map(|(index, _)| index % nx);
        let (foremost, side) = match direction {
            RollingDirection::Forward => (columns.max()?, 0.5),
            RollingDirection::Backward => (columns.min()?, -0.5),
        };
        Some(self.origin[0] + (foremost as f64 + side) * self.element[0])
    }

    /// Returns the energy that friction takes from each element in the increment, over its area
    /// \[J/m²\].
    pub fn friction_work(&self) -> Vec<f64> {
        let along_x = self.traction_x.iter().zip(&self.slip_x);
        let along_y = self.traction_y.iter().zip(&self.slip_y);
        // A zero is to be a positive one.
        along_x.zip(along_y).map(|((p, s), (q, r))| 0.0 - (p * s + q * r)).collect()
    }

    /// Returns the largest difference of two solutions' tractions over this one's largest pressure
    /// \[1\], or `None` if there is no pressure or they are not on the same number of elements.
    pub fn difference(&self, other: &Self) -> Option<f64> {
        let peak = self.pressure.iter().copied().fold(0.0, f64::max);
        let pairs = [
            (&self.pressure, &other.pressure),
            (&self.traction_x, &other.traction_x),
            (&self.traction_y, &other.traction_y),
        ];
        if peak == 0.0 || pairs.iter().any(|(a, b)| a.len() != b.len()) {
            return None;
        }
        Some(
            pairs
                .iter()
                .flat_map(|(a, b)| a.iter().zip(*b))
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
                / peak,
        )
    }
}

/// The estimates of the relative errors at the end of a path \[1\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The errors of the figures. An error is `None` if there is no such figure (nothing sticks to
    /// a punch without contact), if the scene prescribes it, if it is less than 1e-6 of its kind,
    /// and if it has no limit. The tractions in L₂ have none if the contact reaches the edge of the
    /// sole or of Ω, at which the pressure is unbounded and not in L₂, unless ε is so large that
    /// the grid resolves the regularised pressure there, or the ceiling is active. The largest
    /// pressure has none there, and none under a cone, whose tip has an unbounded one.
    pub figures: FigureErrors,
    /// The error of all tractions together in L₂ that is left because the solver stopped before its
    /// residual was 0; it is not part of the others. It is 4 times the larger of the certificate's
    /// residual and its imbalance of forces, summed over the increments, each of which starts from
    /// the one before.
    pub solver: f64,
}

/// The relative errors of a solution's figures \[1\]. `None` means that the error is not defined;
/// the function that builds the struct documents when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FigureErrors {
    /// The error of P.
    pub load: Option<f64>,
    /// The error of δ.
    pub approach: Option<f64>,
    /// The error of the vector (Qx, Qy).
    pub tangential_force: Option<f64>,
    /// The error of the vector of both shifts.
    pub shift: Option<f64>,
    /// The error of the vector of moments.
    pub moment: Option<f64>,
    /// The error of the vector of rotations.
    pub rotation: Option<f64>,
    /// The error of the largest pressure.
    pub peak_pressure: Option<f64>,
    /// The error of the area in contact, which is counted in whole elements.
    pub contact_area: Option<f64>,
    /// The error of the area that sticks, over the area in contact.
    pub stick_area: Option<f64>,
    /// The error of the pressure, ‖p₁ − p₁*‖ / ‖p₁*‖ in L₂.
    pub pressure: Option<f64>,
    /// The error of the tangential traction, ‖p_t − p_t*‖ / ‖p_t*‖ in L₂.
    pub traction: Option<f64>,
}

impl FigureErrors {
    /// Returns the errors with their names, which are those of the fields.
    pub fn named(&self) -> [(&'static str, Option<f64>); 11] {
        [
            ("load", self.load),
            ("approach", self.approach),
            ("tangential_force", self.tangential_force),
            ("shift", self.shift),
            ("moment", self.moment),
            ("rotation", self.rotation),
            ("peak_pressure", self.peak_pressure),
            ("contact_area", self.contact_area),
            ("stick_area", self.stick_area),
            ("pressure", self.pressure),
            ("traction", self.traction),
        ]
    }
}

/// The state of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum State {
    /// The element lies outside the punch's sole.
    Outside = 0,
    /// The element has no pressure, p₁ = 0.
    Open = 1,
    /// The element is in contact and holds: |p_t| < μ p₁, or |p_t| is no more than it takes.
    Stick = 2,
    /// The element is in contact and slides against the traction.
    Slip = 3,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_of_all_tractions_over_the_largest_pressure() {
        let first = Fields {
            pressure: vec![1.0, 4.0],
            traction_x: vec![0.0, 1.0],
            traction_y: vec![0.0; 2],
            ..Fields::default()
        };
        let second =
            Fields { pressure: vec![1.0, 4.5], traction_y: vec![-1.0, 0.0], ..first.clone() };
        assert_eq!(first.difference(&second), Some(0.25));
        assert_eq!(first.difference(&first), Some(0.0));
        assert_eq!(Fields::default().difference(&first), None);
    }
}
