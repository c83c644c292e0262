//! The effects of a single job.

use std::ops::Add;

use contact::model::{ChosenMethod, Effect, Method, Numerics, Shape};
use contact::problem::Effects;
use contact::punch::Surfaces;
use contact::uniqueness::branch::Branch;
use contact::uniqueness::{Question, WitnessSearch};
use contact::{Forecast, forecast, forecast_bracket, forecast_branch};
use serde::Serialize;
use study::{Case, Job};

use crate::error::AnswerError;

/// A prediction of what solving takes; for several jobs, the sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Prediction {
    /// The number of unknowns.
    pub unknowns: usize,
    /// The time \[s\].
    pub seconds: f64,
}

impl From<Forecast> for Prediction {
    fn from(forecast: Forecast) -> Self {
        Self { unknowns: forecast.unknowns, seconds: forecast.seconds }
    }
}

impl Add for Prediction {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { unknowns: self.unknowns + other.unknowns, seconds: self.seconds + other.seconds }
    }
}

/// An effect of one or several jobs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectLine {
    /// The effect.
    pub effect: Effect,
    /// The effect is simulated, and not left out.
    pub simulated: bool,
    /// The reason; that of the first job if they differ.
    pub reason: String,
    /// The number of different reasons.
    pub reasons: usize,
    /// The prediction with the effect, if it is left out and could be asked for.
    pub with: Option<Prediction>,
}

/// The method by which a job finds its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum JobMethod {
    /// Newton's method solves a scene.
    Newton,
    /// Seidel's method solves a scene.
    Seidel,
    /// The lower end of a bracket is shown by weights for all fields at once.
    Weights,
    /// The lower end is shown by weights for each of several cases.
    Cases,
    /// The lower end is shown by cases whose fields are cut into cones.
    Cones,
    /// Both ends are shown by the determinants of all cases of a strip.
    Determinants,
}

impl JobMethod {
    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Newton => "newton",
            Self::Seidel => "seidel",
            Self::Weights => "weights",
            Self::Cases => "cases",
            Self::Cones => "cones",
            Self::Determinants => "determinants",
        }
    }
}

/// The method that solves, and the reason for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct SolverChoice {
    /// The method.
    pub method: JobMethod,
    /// The reason, in words.
    pub reason: &'static str,
}

/// The effects of one job.
#[derive(Clone, Debug, PartialEq)]
pub struct JobEffects {
    /// The method by which the job finds its result.
    pub solver: Option<SolverChoice>,
    /// The prediction with the effects as they are.
    pub cost: Prediction,
    /// Every effect.
    pub lines: Vec<EffectLine>,
}

/// Lists the effects of a case.
///
/// # Errors
/// The scene has no meaning, or its surfaces are missing.
pub fn effects(case: &Case, surfaces: &Surfaces) -> Result<JobEffects, AnswerError> {
    let numerics = &case.numerics;
    let with = |simulate: Vec<Effect>| {
        forecast(&case.scene, &Numerics { simulate, ..numerics.clone() }, surfaces)
    };
    let decided = with(numerics.simulate.clone())?;
    let decisions = Effects::of(&case.scene, numerics, decided.elements, surfaces)?;
    let ChosenMethod { method, reason } =
        numerics.method.chosen(&case.scene.loading, decided.elements);
    let mut lines = Vec::new();
    for decision in decisions.decisions() {
        let is_optional = !decision.on && Effect::OPTIONAL.contains(&decision.effect);
        let simulate = [&numerics.simulate[..], &[decision.effect]].concat();
        lines.push(EffectLine {
            effect: decision.effect,
            simulated: decision.on,
            reason: decision.reason.clone(),
            reasons: 1,
            with: if is_optional { Some(with(simulate)?.into()) } else { None },
        });
    }
    let method = match method {
        Method::Seidel => JobMethod::Seidel,
        Method::Newton | Method::Auto => JobMethod::Newton,
    };
    let solver = Some(SolverChoice { method, reason });
    Ok(JobEffects { solver, cost: decided.into(), lines })
}

/// Lists the effects of a job; `None` for one that simulates every effect whatever its scene. The
/// result is an error if the scene has no meaning, or if its surfaces are missing.
pub fn effects_of_job(job: &Job, surfaces: &Surfaces) -> Option<Result<JobEffects, AnswerError>> {
    match job {
        Job::Uniqueness { question, search } => Some(bracket_effects(question, *search)),
        Job::Branch { question, branch } => Some(branch_effects(question, branch)),
        Job::Solve(case) | Job::Cost { case, .. } => Some(effects(case, surfaces)),
        Job::Multiplicity { .. } => None,
    }
}

/// Lists the effects that a bracket may leave out: the tractions across the plane of a strip.
fn bracket_effects(question: &Question, search: WitnessSearch) -> Result<JobEffects, AnswerError> {
    let reason = if question.plane {
        "`search.plane` asks for tractions in the plane of x and z alone"
    } else {
        "the search is of tractions in every direction"
    };
    let across = EffectLine {
        effect: Effect::TractionY,
        simulated: !question.plane,
        reason: reason.to_owned(),
        reasons: 1,
        with: None,
    };
    let cost = forecast_bracket(question, &search)?.into();
    let solver = Some(bracket_method(question, search));
    Ok(JobEffects { solver, cost, lines: vec![across] })
}

/// Lists the effects of a part of the fields of a bracket, which leaves out none.
fn branch_effects(question: &Question, branch: &Branch) -> Result<JobEffects, AnswerError> {
    let across = EffectLine {
        effect: Effect::TractionY,
        simulated: true,
        reason: "the search is of tractions in every direction".to_owned(),
        reasons: 1,
        with: None,
    };
    let reason = "`[branch]` asks for cones, a few to each job";
    Ok(JobEffects {
        solver: Some(SolverChoice { method: JobMethod::Cones, reason }),
        cost: forecast_branch(question, branch)?.into(),
        lines: vec![across],
    })
}

/// Returns the method that shows the lower end of a bracket, and why it is that one.
fn bracket_method(question: &Question, search: WitnessSearch) -> SolverChoice {
    let (method, reason) = if question.plane {
        (JobMethod::Determinants, "in a plane every element has five states alone")
    } else if search.width.is_some() {
        (JobMethod::Cones, "`search.width` says how narrow the bracket is to be")
    } else if search.cases {
        (JobMethod::Cases, "`search.cases` asks for them; `search.width` would narrow the bracket")
    } else {
        (
            JobMethod::Weights,
            "`[branch]` or `search.cases` would narrow the bracket on up to 16 elements",
        )
    };
    SolverChoice { method, reason }
}

/// Returns the sets of effects whose simulation is worth measuring: none that could be left out,
/// then each of those alone, then all of them.
///
/// # Errors
/// The scene has no meaning, or its surfaces are missing.
pub fn variants(case: &Case, surfaces: &Surfaces) -> Result<Vec<Vec<Effect>>, AnswerError> {
    let bare = Numerics { simulate: Vec::new(), ..case.numerics.clone() };
    let elements = forecast(&case.scene, &bare, surfaces)?.elements;
    let effects = Effects::of(&case.scene, &bare, elements, surfaces)?;
    let left_out: Vec<Effect> =
        Effect::OPTIONAL.into_iter().filter(|effect| !effects.has(*effect)).collect();
    // Without tangential tractions, these would do nothing.
    let of_friction = [Effect::Coupling, Effect::TractionX, Effect::TractionY];
    let does_something =
        |effect: &&Effect| effects.has(Effect::Friction) || !of_friction.contains(effect);
    let mut variants = vec![Vec::new()];
    variants.extend(left_out.iter().filter(does_something).map(|effect| vec![*effect]));
    if left_out.len() > 1 {
        variants.push(left_out);
    }
    Ok(variants)
}

/// Names the height map or the profile that a scene needs and `surfaces` does not hold; `None` if
/// nothing is missing.
pub fn missing_surface(job: &Job, surfaces: &Surfaces) -> Option<String> {
    match &job.case()?.scene.punch.shape {
        Shape::HeightMap { surface, .. } if surfaces.get(surface).is_none() => {
            Some(format!("the height map {surface}"))
        }
        Shape::WheelOnRail(wheel) => {
            let names = [&wheel.wheel, &wheel.rail];
            let name = names.into_iter().find(|name| surfaces.profile(name).is_none())?;
            Some(format!("the profile {name}"))
        }
        _ => None,
    }
}
