//! What solving a scene leaves: observables, a certificate, the work done, the fields, and whether
//! it counts as solved.
//!
//! Everything here must stay encodable by formats that do not describe themselves (no flattened,
//! tagged or skipped fields).

use serde::{Deserialize, Serialize};

use super::rigid::{Motion, PerDof};

/// How a solve ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Status {
    /// The certificate meets the requested tolerance.
    Certified,
    /// It does not; the figures of the last iterate are kept, but it is not a solution.
    Failed {
        /// What went wrong, in words with figures.
        reason: String,
    },
}

/// The deterministic result of one job: same scene and numerics, same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Whether it counts as solved, all the way to the end of the path.
    pub status: Status,
    /// The coarser grids on which the start of the first increment was found, or the path followed
    /// for an estimate of the error, from coarse to fine.
    pub levels: Vec<Level>,
    /// Every increment of the path that was solved, in order. Of a path that could not be followed
    /// the last one is the increment at which it failed; those before it are solutions.
    pub steps: Vec<StepOutcome>,
    /// What Hertz's theory makes of the load at the end of the path, for smooth punches on a
    /// homogeneous foundation.
    pub hertz: Option<Hertz>,
    /// Where a wheel meets its rail, at the end of the path.
    pub rail: Option<RailContact>,
    /// How far the end of the path is from what ever finer meshes would give; `None` where nothing
    /// tells it: for a path that could not be followed or ends without contact, on fewer than
    /// four elements along a side, and where the grid of half as
    /// many elements each way is refused or the method fails on it.
    pub estimate: Option<Estimate>,
}

impl Outcome {
    /// The end of the path, or the increment at which it failed.
    pub fn last(&self) -> Option<&StepOutcome> {
        self.steps.last()
    }

    /// What the whole path took: iterations on all grids, and operator applications on the grid
    /// itself, since those on the coarser [levels](Outcome::levels) cost a fraction.
    pub fn work(&self) -> WorkDone {
        let coarse: u64 = self.levels.iter().map(|level| level.work.iterations).sum();
        let sum = |part: fn(&WorkDone) -> u64| {
            self.steps.iter().map(|step| part(&step.work)).sum::<u64>()
        };
        WorkDone {
            iterations: coarse + sum(|work| work.iterations),
            operator_applications: sum(|work| work.operator_applications),
        }
    }

    /// The last resort that any increment needed.
    pub fn way(&self) -> Option<Way> {
        self.steps.iter().map(|step| step.way).max()
    }

    /// Energy lost to friction along the path \[J\].
    pub fn dissipation(&self) -> f64 {
        self.steps.iter().map(|step| step.observables.dissipation).sum()
    }

    /// Energy lost to friction in the last cycle \[J\], `None` for a path without cycles.
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
    /// The smaller one \[m\].
    pub semi_axis_b: f64,
    /// Its area \[m²\].
    pub area: f64,
    /// Largest pressure \[Pa\].
    pub peak_pressure: f64,
    /// Approach \[m\].
    pub approach: f64,
}

/// A contact in track coordinates: x along the track, y to the right, z down, origin midway between
/// the rails at the height of their tops.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RailContact {
    /// Contact reference point \[m\]: the centre of the undeformed bodies' overlap around the point
    /// of first touch, weighted with the square of the interpenetration, as CONTACT has it.
    pub track: [f64; 3],
    /// Its (y, z) in the rail profile's coordinates, y to the right \[m\].
    pub rail: [f64; 2],
    /// Contact angle \[rad\]: mean inclination of the rail there with the same weight, from y
    /// towards z.
    pub angle: f64,
    /// Centre of pressure, on the rail \[m\]; the reference point without a load.
    pub pressure_center: [f64; 3],
    /// Height of the wheelset below the position in which the wheel's rolling radius reaches the
    /// rails' tops \[m\].
    pub wheelset_height: f64,
}

/// One increment of a loading path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepOutcome {
    /// Index of its step in [`Loading::steps`](super::loading::Loading::steps).
    pub step: u32,
    /// Which time the cycle is run through, counted from 1; 0 before the cycle or without one.
    pub cycle: u32,
    /// Where the punch is.
    pub motion: Motion,
    /// Quantities in SI units.
    pub observables: Observables,
    /// Solver-independent residuals.
    pub certificate: Certificate,
    /// What it took.
    pub work: WorkDone,
    /// How it was solved.
    pub way: Way,
}

/// The way to a solution: a method, or what it fell back on. Each of the later ones is tried where
/// the one before it fails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Way {
    /// Newton's method, with the motions that forces govern among its unknowns.
    #[default]
    Newton,
    /// Newton's method for prescribed motions within one for the forces.
    NewtonWithinForces,
    /// The same, with Seidel sweeps where Newton's method does not converge.
    NewtonAndSeidel,
    /// Seidel's iteration, within a Newton iteration for the forces where there are any.
    Seidel,
}

impl Way {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Way::Newton => "newton",
            Way::NewtonWithinForces => "newton within forces",
            Way::NewtonAndSeidel => "newton and seidel",
            Way::Seidel => "seidel",
        }
    }
}

/// Integral quantities of a solution. Forces and moments are those of the punch on the foundation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Observables {
    /// Normal force P = Σ p₁ |e| \[N\].
    pub load: f64,
    /// Tangential force along x, Σ p₂ |e| \[N\].
    pub force_x: f64,
    /// Tangential force along y, Σ p₃ |e| \[N\].
    pub force_y: f64,
    /// Moment about x, Σ y p₁ |e| \[N m\], work-conjugate to tilt_x.
    pub moment_x: f64,
    /// Moment about y, −Σ x p₁ |e| \[N m\], work-conjugate to tilt_y.
    pub moment_y: f64,
    /// Moment about z, Σ (x p₃ − y p₂) |e| \[N m\], work-conjugate to twist.
    pub moment_z: f64,
    /// Area with p₁ > 0 \[m²\].
    pub contact_area: f64,
    /// Area in contact that sticks \[m²\].
    pub stick_area: f64,
    /// Area in contact that slips \[m²\].
    pub slip_area: f64,
    /// Elements in contact.
    pub contact_elements: u64,
    /// Elements that stick.
    pub stick_elements: u64,
    /// Elements that slip.
    pub slip_elements: u64,
    /// Regions in contact that do not touch each other, elements that share a corner taken for one.
    pub patches: u64,
    /// Area that could be in contact: Ω as far as the punch has a sole \[m²\].
    pub sole_area: f64,
    /// Largest gap on it \[m\].
    pub largest_gap: f64,
    /// Largest p₁ \[Pa\].
    pub peak_pressure: f64,
    /// Largest |p_t| \[Pa\].
    pub peak_traction: f64,
    /// Elastic energy ½ Σ p·(A p) |e| \[J\].
    pub energy: f64,
    /// Energy lost to friction in this increment, −Σ p_t·w_t |e| ≥ 0 \[J\].
    pub dissipation: f64,
    /// Work that the punch's motion did in this increment, the mean of the forces before and after
    /// times the way \[J\].
    pub external_work: f64,
    /// Elements at which the ceiling u is active; above 0 the result solves equation (3) but not
    /// (1).
    pub ceiling_elements: u64,
    /// Elements in contact at the edge of Ω although the punch goes on beyond it; above 0, Ω is too
    /// small.
    pub edge_elements: u64,
    /// Elements along x and y.
    pub mesh_x: u64,
    /// Elements along y.
    pub mesh_y: u64,
    /// Element size along x \[m\].
    pub element_x: f64,
    /// Element size along y \[m\].
    pub element_y: f64,
}

impl Observables {
    /// Forces and moments in the order of [`Step::NAMES`](super::loading::Step::NAMES).
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
}

/// Residuals of a claimed solution, computed by code that shares nothing with the solvers
/// ([`certify`](crate::assess::certify)). All are relative and dimensionless, 0 for an exact
/// solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// ‖p − Gᵘ_μ(p − E(εp + Ap − f))‖ / ‖p‖, E = 1/(ε + diagonal entry of A), one for the normal
    /// and one (the larger) for the tangential direction.
    pub residual: f64,
    /// −min(p₁, 0) / max |p₁|: tension, 0 when there is none.
    pub tension: f64,
    /// Largest penetration −min(w₁, 0) over max |(A p)₁|.
    pub penetration: f64,
    /// Largest gap under pressure, max (w₁ p₁)/(max p₁ · max|(Ap)₁|).
    pub gap_under_pressure: f64,
    /// Largest (|p_t| − μ p₁)₊ / max p₁.
    pub cone_violation: f64,
    /// Largest angle between slip and −traction \[rad\] over elements whose slip is well above
    /// rounding.
    pub slip_angle: f64,
    /// Largest difference between a claimed resultant (P, Qx, Qy), or one that was asked for, and
    /// the same summed anew, over Σ |p| |e|; for moments over Σ |p| |e| times ℓ.
    pub force_imbalance: f64,
}

/// What a solve took; deterministic, unlike seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkDone {
    /// Iterations of the method (for Seidel, sweeps).
    pub iterations: u64,
    /// Operator applications, counting a full Seidel sweep over the contact as one.
    pub operator_applications: u64,
}

/// A coarser grid on which a start was sought, or the path followed for an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Level {
    /// Elements along x and y.
    pub elements: [u32; 2],
    /// What it took.
    pub work: WorkDone,
}

/// Fields on the grid in SI units, row-major with x fastest, masked elements zero.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fields {
    /// Elements along x and y.
    pub shape: [u32; 2],
    /// Centre of element (0, 0) \[m\].
    pub origin: [f64; 2],
    /// Element size \[m\].
    pub element: [f64; 2],
    /// p₁ \[Pa\].
    pub pressure: Vec<f64>,
    /// p₂ \[Pa\], of the punch on the foundation.
    pub traction_x: Vec<f64>,
    /// p₃ \[Pa\].
    pub traction_y: Vec<f64>,
    /// w₁ \[m\].
    pub gap: Vec<f64>,
    /// w₂ \[m\], the foundation's surface relative to the punch since the increment before; 0 where
    /// the scene has no tangential tractions, for then it is not computed.
    pub slip_x: Vec<f64>,
    /// w₃ \[m\].
    pub slip_y: Vec<f64>,
    /// 0 outside the sole, 1 open, 2 stick, 3 slip.
    pub state: Vec<u8>,
}

impl Fields {
    /// The largest difference of two solutions' tractions over this one's largest pressure \[1\];
    /// `None` where there is no pressure or they are not on the same number of elements.
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

/// Estimates of the relative errors at the end of a path \[1\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Of the figures. `None` where there is no figure (nothing sticks to a punch without contact),
    /// where the scene prescribes it, where it is less than 1e-6 of its kind, and where it has no
    /// limit. Without one are the tractions in L₂ where the contact reaches the edge of the sole or
    /// of Ω, at which the pressure is unbounded and not in L₂, unless ε is large enough for the
    /// grid to resolve what it makes of it, or the ceiling is active; and the largest pressure
    /// there and under a cone, whose tip has an unbounded one.
    pub figures: FigureErrors,
    /// Of all tractions together in L₂, because the solver stopped before its residual was 0; not
    /// part of the others. 4 times the larger of the certificate's residual and its imbalance of
    /// forces, summed over the increments, each of which starts from the one before.
    pub solver: f64,
}

/// Relative errors of the figures of a solution \[1\]; whoever makes them says where there are
/// none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FigureErrors {
    /// Of P.
    pub load: Option<f64>,
    /// Of δ.
    pub approach: Option<f64>,
    /// Of the vector (Qx, Qy).
    pub tangential_force: Option<f64>,
    /// Of the vector of both shifts.
    pub shift: Option<f64>,
    /// Of the vector of moments.
    pub moment: Option<f64>,
    /// Of the vector of rotations.
    pub rotation: Option<f64>,
    /// Of the largest pressure.
    pub peak_pressure: Option<f64>,
    /// Of the area in contact, counted in whole elements.
    pub contact_area: Option<f64>,
    /// Of the area that sticks, over the area in contact.
    pub stick_area: Option<f64>,
    /// ‖p₁ − p₁*‖ / ‖p₁*‖ in L₂.
    pub pressure: Option<f64>,
    /// ‖p_t − p_t*‖ / ‖p_t*‖ in L₂.
    pub traction: Option<f64>,
}

impl FigureErrors {
    /// With their names, which are those of the fields.
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

/// What an element does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum State {
    /// No part of Ω.
    Outside = 0,
    /// p₁ = 0.
    Open = 1,
    /// In contact, |p_t| < μ p₁ or no more than it takes.
    Stick = 2,
    /// In contact and sliding against the traction.
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
