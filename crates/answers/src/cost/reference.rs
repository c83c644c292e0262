//! The reference for the errors of a scene's rungs.

use contact::assess::{ClosedForm, Errors, closed_form};
use contact::model::{Control, Dof, FigureErrors, PerDof, Scene, StepOutcome};
use contact::theory::richardson;

use super::rung::{CostRung, tightest};
use crate::error::AnswerError;
use crate::evidence::Evidence;

/// A scalar that is extrapolated where a scene has no closed form.
pub(super) struct Scalar {
    pub(super) name: &'static str,
    read: fn(&StepOutcome) -> f64,
}

/// Every scalar that is extrapolated.
pub(super) const SCALARS: [Scalar; 6] = [
    Scalar { name: "load", read: |end| end.observables.load },
    Scalar { name: "tangential_force", read: |end| end.observables.tangential_force() },
    Scalar { name: "approach", read: |end| end.motion.approach },
    Scalar { name: "peak_pressure", read: |end| end.observables.peak_pressure },
    Scalar { name: "contact_area", read: |end| end.observables.contact_area },
    Scalar { name: "stick_area", read: |end| end.observables.stick_area },
];

/// The extrapolated value of a scalar.
#[derive(Clone, Copy)]
struct ScalarLimit {
    value: f64,
    uncertainty: f64,
}

/// The limit of each of [`SCALARS`]; `None` for a scalar without one.
pub(super) struct ScalarLimits([Option<ScalarLimit>; 6]);

/// The reference for the errors of a scene's rungs.
pub(super) enum CostReference {
    /// The closed form of the scene.
    Exact(Box<ClosedForm>),
    /// The limits of the tightest rungs.
    Limit {
        limits: ScalarLimits,
        /// The relative uncertainty of the figure that counts.
        uncertainty: f64,
    },
}

impl CostReference {
    /// Returns the closed form of a scene, or else what its rungs extrapolate to, if the figure
    /// `on` that counts has a limit.
    pub(super) fn of(
        evidence: &Evidence<'_>,
        scene: &Scene,
        rungs: &[CostRung<'_>],
        on: &str,
    ) -> Option<Self> {
        if let Some(exact) = closed_form(scene) {
            return Some(Self::Exact(Box::new(exact)));
        }
        let limits = ScalarLimits::of(&tightest(evidence, rungs))?;
        let uncertainty = limits.uncertainty(on)?;
        Some(Self::Limit { limits, uncertainty })
    }

    /// Returns the relative uncertainty of the figure that counts.
    pub(super) fn uncertainty(&self) -> f64 {
        match self {
            Self::Exact(_) => 0.0,
            Self::Limit { uncertainty, .. } => *uncertainty,
        }
    }

    /// Returns a short name.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Exact(exact) => exact.name,
            Self::Limit { .. } => "extrapolated",
        }
    }

    /// Returns the name by which a point's row has it, with its source.
    pub(super) fn full_name(&self) -> String {
        match self {
            Self::Exact(exact) => format!("{} ({})", exact.name, exact.source),
            Self::Limit { .. } => "the limit of the finest meshes".to_owned(),
        }
    }

    /// Returns the relative errors of a rung, where `target` is what the end of the path gives.
    pub(super) fn errors(
        &self,
        evidence: &Evidence<'_>,
        rung: &CostRung<'_>,
        target: &PerDof<Control>,
    ) -> Result<Option<Errors>, AnswerError> {
        Ok(match self {
            Self::Exact(exact) => {
                let Some(record) = evidence.certified(rung.point) else { return Ok(None) };
                Errors::against_closed_form(rung.end, &evidence.fields(record)?, exact)
            }
            Self::Limit { limits, .. } => Some(limits.errors(rung.end, target)),
        })
    }
}

impl ScalarLimits {
    /// Extrapolates the scalars of at least three rungs.
    fn of(rungs: &[&CostRung<'_>]) -> Option<Self> {
        let mut rungs = rungs.to_vec();
        rungs.sort_by(|a, b| b.h.total_cmp(&a.h));
        let limit = |scalar: &Scalar| {
            let ladder: Vec<(f64, f64)> =
                rungs.iter().map(|rung| (rung.h, (scalar.read)(rung.end))).collect();
            let limit = richardson(&ladder).ok()?;
            Some(ScalarLimit { value: limit.value, uncertainty: limit.uncertainty })
        };
        (rungs.len() >= 3).then(|| Self(SCALARS.each_ref().map(limit)))
    }

    fn limit(&self, name: &str) -> Option<ScalarLimit> {
        self.0[SCALARS.iter().position(|scalar| scalar.name == name)?]
    }

    /// Returns what an error of a scalar is relative to: the scalar itself, but the contact area
    /// for the stick area.
    fn unit(&self, name: &str) -> Option<f64> {
        let limit = self.limit(if name == "stick_area" { "contact_area" } else { name })?;
        (limit.value != 0.0).then_some(limit.value.abs())
    }

    /// Returns the relative uncertainty of a scalar's limit.
    fn uncertainty(&self, name: &str) -> Option<f64> {
        Some(self.limit(name)?.uncertainty / self.unit(name)?)
    }

    fn errors(&self, end: &StepOutcome, target: &PerDof<Control>) -> Errors {
        let error = |name: &str| {
            let scalar = SCALARS.iter().find(|scalar| scalar.name == name)?;
            Some(((scalar.read)(end) - self.limit(name)?.value).abs() / self.unit(name)?)
        };
        let is_given = |dof: Dof| matches!(target[dof], Control::Force(_));
        let is_load_given = is_given(Dof::Approach);
        let is_pull_given = Dof::SHIFTS.into_iter().all(is_given);
        let figures = FigureErrors {
            load: error("load").filter(|_| !is_load_given),
            approach: error("approach").filter(|_| is_load_given),
            tangential_force: error("tangential_force").filter(|_| !is_pull_given),
            peak_pressure: error("peak_pressure"),
            contact_area: error("contact_area"),
            stick_area: error("stick_area"),
            ..FigureErrors::default()
        };
        Errors { figures, ..Errors::default() }
    }
}
