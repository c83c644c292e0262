//! Derives the settings that describe a job.

use std::borrow::Cow;

use contact::model::{
    Base, Domain, Effect, Foundation, InteriorQuestion, Loading, Material, Mesh, Method, Numerics,
    Projection, RollingDirection, RollingHistory, Shape, Side, Step, Wear, WheelsetMotion,
};
use contact::multiplicity::Search;
use contact::uniqueness::{Question, Sole};

use crate::job::{Case, Job};
use crate::key::Key;
use crate::sheet::Setting;

/// The parts that jobs of all kinds may have; a part is `None` if a job does not have it.
struct JobParts<'a> {
    foundation: &'a Foundation,
    shape: Option<Cow<'a, Shape>>,
    material: Option<&'a Material>,
    mu: Option<f64>,
    wear: Option<&'a Wear>,
    domain: Option<&'a Domain>,
    loading: Option<&'a Loading>,
    interior: Option<&'a InteriorQuestion>,
    mesh: Mesh,
    projection: Projection,
    epsilon: f64,
    numerics: Option<&'a Numerics>,
    /// The method; a search tries every one.
    method: Option<Method>,
    /// The effects that are simulated in any case; a search simulates every one.
    simulate: &'a [Effect],
    starts: Option<u32>,
    seed: Option<u64>,
    /// True if a lower end is shown by cases.
    cases: bool,
    /// The relative width that a bracket is to have.
    width: Option<f64>,
    /// True if the search is of tractions in a plane.
    plane: bool,
}

impl<'a> JobParts<'a> {
    fn of(job: &'a Job) -> Self {
        match job {
            Job::Solve(case) | Job::Cost { case, .. } => Self::of_case(case),
            Job::Multiplicity { case, search: Search { starts, seed } } => JobParts {
                method: None,
                simulate: &[],
                starts: Some(*starts),
                seed: Some(*seed),
                ..Self::of_case(case)
            },
            Job::Uniqueness { question, search } => JobParts {
                // Nothing is left to chance in a plane.
                starts: (!question.plane).then_some(search.starts),
                seed: (!question.plane).then_some(search.seed),
                cases: search.cases,
                width: search.width,
                ..Self::of_question(question)
            },
            Job::Branch { question, .. } => Self::of_question(question),
        }
    }

    /// Returns the parts of the bodies and the sole on which a uniqueness set depends.
    fn of_question(question: &'a Question) -> Self {
        JobParts {
            foundation: &question.foundation,
            shape: Some(Cow::Owned(match question.sole {
                Sole::Rectangle { width_x, width_y } => Shape::FlatRectangle { width_x, width_y },
                Sole::Disk { radius } => Shape::FlatDisk { radius },
            })),
            material: question.punch.as_ref(),
            mu: None,
            wear: None,
            domain: None,
            loading: None,
            interior: None,
            mesh: question.mesh,
            projection: question.projection,
            epsilon: question.epsilon,
            numerics: None,
            method: None,
            simulate: &[],
            starts: None,
            seed: None,
            cases: false,
            width: None,
            plane: question.plane,
        }
    }

    /// Returns the parts of a case that is solved.
    fn of_case(Case { scene, numerics }: &'a Case) -> Self {
        JobParts {
            foundation: &scene.foundation,
            shape: Some(Cow::Borrowed(&scene.punch.shape)),
            material: scene.punch.material.as_ref(),
            mu: Some(scene.friction.mu),
            wear: scene.wear.as_ref(),
            domain: scene.domain.as_ref(),
            loading: Some(&scene.loading),
            interior: scene.interior.as_ref(),
            mesh: numerics.mesh,
            projection: numerics.projection,
            epsilon: numerics.epsilon,
            numerics: Some(numerics),
            method: Some(numerics.method),
            simulate: &numerics.simulate,
            starts: None,
            seed: None,
            cases: false,
            width: None,
            plane: false,
        }
    }
}

/// Returns the length of [`Key::Layers`] or [`Key::Steps`] in a job.
pub(crate) fn length(job: &Job, list: Key) -> u32 {
    let parts = JobParts::of(job);
    match list {
        Key::Layers => count(parts.foundation.layers.len()),
        _ => parts.loading.map_or(0, |loading| count(loading.steps.len())),
    }
}

/// Returns every key that a job has, with its value: the opposite of assembling the job. Keys whose
/// values follow from others are not among them.
pub(crate) fn settings(job: &Job) -> Vec<(Key, Setting)> {
    Key::all(|list| length(job, list))
        .into_iter()
        .filter(|key| !key.is_derived())
        .filter_map(|key| Some((key, setting(job, key)?)))
        .collect()
}

/// Returns the value that a job has for a key; `None` if it has none.
pub(crate) fn setting(job: &Job, key: Key) -> Option<Setting> {
    let parts = JobParts::of(job);
    match key {
        Key::Layers
        | Key::LayerShearModulus(_)
        | Key::LayerYoungsModulus(_)
        | Key::LayerPoisson(_)
        | Key::LayerThickness(_)
        | Key::Base
        | Key::ShearModulus
        | Key::YoungsModulus
        | Key::Poisson => of_foundation(parts.foundation, key),
        Key::Shape
        | Key::Radius
        | Key::RadiusX
        | Key::RadiusY
        | Key::WidthX
        | Key::WidthY
        | Key::ConeAngle
        | Key::Surface
        | Key::Wheel
        | Key::Rail
        | Key::Side
        | Key::RollingRadius
        | Key::Gauge
        | Key::GaugeDepth
        | Key::FlangeBackDistance
        | Key::FlangeBackToOrigin
        | Key::Lateral
        | Key::Speed
        | Key::AngularSpeed
        | Key::LateralVelocity
        | Key::YawRate
        | Key::RollRate
        | Key::Yaw
        | Key::Roll => of_shape(parts.shape.as_deref()?, key),
        // A job names its surface by content.
        Key::File | Key::HeightUnit | Key::LateralUnit | Key::Missing | Key::MissingValue => None,
        Key::PunchShearModulus => number(parts.material?.shear_modulus),
        Key::PunchYoungsModulus => number(youngs_modulus_of(parts.material?)),
        Key::PunchPoisson => number(parts.material?.poisson),
        Key::Mu => number(parts.mu?),
        Key::WearCoefficient => number(parts.wear?.coefficient),
        Key::WearUpdate => Some(Setting::Flag(parts.wear?.update)),
        Key::WearRepeat => Some(Setting::Count(parts.wear?.repeat)),
        Key::DomainWidthX => number(parts.domain?.width_x),
        Key::DomainWidthY => number(parts.domain?.width_y),
        Key::DomainCenterX => number(parts.domain?.center_x),
        Key::DomainCenterY => number(parts.domain?.center_y),
        Key::Steps
        | Key::Approach(_)
        | Key::NormalForce(_)
        | Key::ShiftX(_)
        | Key::ForceX(_)
        | Key::ShiftY(_)
        | Key::ForceY(_)
        | Key::TiltX(_)
        | Key::MomentX(_)
        | Key::TiltY(_)
        | Key::MomentY(_)
        | Key::Twist(_)
        | Key::MomentZ(_)
        | Key::Increments(_)
        | Key::CreepageX(_)
        | Key::CreepageY(_)
        | Key::Spin(_)
        | Key::SpinCenter(_)
        | Key::Direction(_)
        | Key::Distance(_)
        | Key::Dq(_)
        | Key::Steady(_)
        | Key::CycleFrom
        | Key::Cycles => of_loading(parts.loading?, key),
        Key::InteriorMaximum | Key::InteriorDepth | Key::InteriorDepths | Key::InteriorPoints => {
            of_interior(parts.interior?, key)
        }
        Key::Mesh
        | Key::Projection
        | Key::Epsilon
        | Key::Ceiling
        | Key::Method
        | Key::Tolerance
        | Key::MaxIterations
        | Key::Simulate
        | Key::Starts
        | Key::Seed
        | Key::Cases
        | Key::Width
        | Key::Plane => of_numerics(&parts, key),
    }
}

fn of_foundation(Foundation { layers, base }: &Foundation, key: Key) -> Option<Setting> {
    let layer = |index: u32| layers.get(index as usize);
    match (key, base) {
        (Key::Layers, _) => Some(Setting::Count(count(layers.len()))),
        (Key::LayerShearModulus(index), _) => number(layer(index)?.shear_modulus),
        (Key::LayerYoungsModulus(index), _) => number(youngs_modulus_of(&layer(index)?.material())),
        (Key::LayerPoisson(index), _) => number(layer(index)?.poisson),
        (Key::LayerThickness(index), _) => number(layer(index)?.thickness),
        (Key::Base, Base::Rigid) => word("rigid"),
        (Key::ShearModulus, Base::Elastic(material)) => number(material.shear_modulus),
        (Key::YoungsModulus, Base::Elastic(material)) => number(youngs_modulus_of(material)),
        (Key::Poisson, Base::Elastic(material)) => number(material.poisson),
        _ => None,
    }
}

/// Returns Young's modulus E = 2G(1+ν): of the numbers that give the material's G, the one with the
/// fewest digits, so that it is the number that a study gave.
fn youngs_modulus_of(material: &Material) -> f64 {
    let Material { shear_modulus, poisson } = *material;
    let near = 2.0 * shear_modulus * (1.0 + poisson);
    let mut rounded = (0..17).filter_map(|digits| format!("{near:.digits$e}").parse::<f64>().ok());
    rounded
        .find(|modulus| Material::with_youngs_modulus(*modulus, poisson) == *material)
        .unwrap_or(near)
}

fn of_shape(shape: &Shape, key: Key) -> Option<Setting> {
    match (key, shape) {
        (Key::Shape, _) => word(match shape {
            Shape::Sphere { .. } => "sphere",
            Shape::Ellipsoid { .. } => "ellipsoid",
            Shape::FlatRectangle { .. } => "flat-rectangle",
            Shape::FlatDisk { .. } => "flat-disk",
            Shape::Cone { .. } => "cone",
            Shape::HeightMap { .. } => "height-map",
            Shape::WheelOnRail(_) => "wheel-on-rail",
        }),
        (Key::Radius, Shape::Sphere { radius } | Shape::FlatDisk { radius }) => number(*radius),
        (Key::RadiusX, Shape::Ellipsoid { radius_x, .. }) => number(*radius_x),
        (Key::RadiusY, Shape::Ellipsoid { radius_y, .. }) => number(*radius_y),
        (Key::WidthX, Shape::FlatRectangle { width_x, .. } | Shape::HeightMap { width_x, .. }) => {
            number(*width_x)
        }
        (Key::WidthY, Shape::FlatRectangle { width_y, .. } | Shape::HeightMap { width_y, .. }) => {
            number(*width_y)
        }
        (Key::ConeAngle, Shape::Cone { angle }) => number(*angle),
        (Key::Surface, Shape::HeightMap { surface, .. }) => word(surface),
        (Key::Wheel, Shape::WheelOnRail(wheel)) => word(&wheel.wheel),
        (Key::Rail, Shape::WheelOnRail(wheel)) => word(&wheel.rail),
        (Key::Side, Shape::WheelOnRail(wheel)) => word(match wheel.side {
            Side::Left => "left",
            Side::Right => "right",
        }),
        (Key::RollingRadius, Shape::WheelOnRail(wheel)) => number(wheel.rolling_radius),
        (Key::Gauge, Shape::WheelOnRail(wheel)) => number(wheel.gauge),
        (Key::GaugeDepth, Shape::WheelOnRail(wheel)) => number(wheel.gauge_depth),
        (Key::FlangeBackDistance, Shape::WheelOnRail(wheel)) => number(wheel.flange_back_distance),
        (Key::FlangeBackToOrigin, Shape::WheelOnRail(wheel)) => number(wheel.flange_back_to_origin),
        (Key::Lateral, Shape::WheelOnRail(wheel)) => number(wheel.lateral),
        (Key::Yaw, Shape::WheelOnRail(wheel)) => number(wheel.yaw),
        (Key::Roll, Shape::WheelOnRail(wheel)) => number(wheel.roll),
        (_, Shape::WheelOnRail(wheel)) => of_motion(wheel.motion.as_ref()?, key),
        _ => None,
    }
}

fn of_motion(motion: &WheelsetMotion, key: Key) -> Option<Setting> {
    match key {
        Key::Speed => number(motion.speed),
        Key::AngularSpeed => number(motion.angular_speed?),
        Key::LateralVelocity => number(motion.lateral_velocity),
        Key::YawRate => number(motion.yaw_rate),
        Key::RollRate => number(motion.roll_rate),
        _ => None,
    }
}

fn of_loading(loading: &Loading, key: Key) -> Option<Setting> {
    let step = |index: u32, field: fn(&Step) -> Option<f64>| {
        loading.steps.get(index as usize).and_then(field).map(Setting::Number)
    };
    match key {
        Key::Steps => Some(Setting::Count(count(loading.steps.len()))),
        Key::Approach(index) => step(index, |step| step.approach),
        Key::NormalForce(index) => step(index, |step| step.normal_force),
        Key::ShiftX(index) => step(index, |step| step.shift_x),
        Key::ForceX(index) => step(index, |step| step.force_x),
        Key::ShiftY(index) => step(index, |step| step.shift_y),
        Key::ForceY(index) => step(index, |step| step.force_y),
        Key::TiltX(index) => step(index, |step| step.tilt_x),
        Key::MomentX(index) => step(index, |step| step.moment_x),
        Key::TiltY(index) => step(index, |step| step.tilt_y),
        Key::MomentY(index) => step(index, |step| step.moment_y),
        Key::Twist(index) => step(index, |step| step.twist),
        Key::MomentZ(index) => step(index, |step| step.moment_z),
        Key::Increments(index) => {
            let step = loading.steps.get(index as usize)?;
            let is_divided_by_elements = step.rolling.is_some_and(|roll| roll.distance.is_some());
            (!is_divided_by_elements).then_some(Setting::Count(step.increments))
        }
        Key::CreepageX(index)
        | Key::CreepageY(index)
        | Key::Spin(index)
        | Key::SpinCenter(index)
        | Key::Direction(index)
        | Key::Distance(index)
        | Key::Dq(index)
        | Key::Steady(index) => of_rolling(loading.steps.get(index as usize)?, key),
        Key::CycleFrom => Some(Setting::Count(loading.cycle_from?)),
        Key::Cycles => Some(Setting::Count(loading.cycles)),
        _ => None,
    }
}

fn of_rolling(step: &Step, key: Key) -> Option<Setting> {
    let rolling = step.rolling.as_ref()?;
    let is_steady = rolling.history == RollingHistory::Steady;
    match key {
        Key::CreepageX(_) => number(rolling.creepage_x?),
        Key::CreepageY(_) => number(rolling.creepage_y?),
        Key::Spin(_) => number(rolling.spin?),
        Key::SpinCenter(_) => number(rolling.spin_center),
        Key::Direction(_) => word(match rolling.direction {
            RollingDirection::Forward => "forward",
            RollingDirection::Backward => "backward",
        }),
        Key::Distance(_) if is_steady => None,
        Key::Distance(_) => match (rolling.distance, rolling.dq) {
            (Some(distance), _) => number(distance),
            (None, dq) => number(distance_of(dq?, step.increments)),
        },
        Key::Dq(_) => number(rolling.dq?),
        Key::Steady(_) => Some(Setting::Flag(is_steady)),
        _ => None,
    }
}

/// Returns the distance of which each of `increments` is `dq`: of the numbers that are divided so,
/// the one with the fewest digits, so that it is the number that a study gave.
fn distance_of(dq: f64, increments: u32) -> f64 {
    let near = dq * f64::from(increments);
    let rounded = (0..17).filter_map(|digits| format!("{near:.digits$e}").parse::<f64>().ok());
    let (below, above) = (near.next_down(), near.next_up());
    let mut candidates = rounded.chain([near, below, above, below.next_down(), above.next_up()]);
    candidates.find(|distance| distance / f64::from(increments) == dq).unwrap_or(near)
}

/// Returns what is asked of the stresses below the surface. One depth is a number, which may be an
/// axis, and a list too.
fn of_interior(question: &InteriorQuestion, key: Key) -> Option<Setting> {
    let InteriorQuestion { maximum, depths, points } = question;
    match (key, &depths[..]) {
        (Key::InteriorMaximum, _) => maximum.then_some(Setting::Flag(true)),
        (Key::InteriorDepth, [depth]) => number(*depth),
        (Key::InteriorDepths, [_, ..]) => Some(Setting::Lengths(depths.clone())),
        (Key::InteriorPoints, _) => (!points.is_empty()).then(|| Setting::Places(points.clone())),
        _ => None,
    }
}

fn of_numerics(parts: &JobParts<'_>, key: Key) -> Option<Setting> {
    match key {
        Key::Mesh => Some(Setting::Mesh(parts.mesh)),
        Key::Projection => word(match parts.projection {
            Projection::Average => "average",
            Projection::Midpoint => "midpoint",
        }),
        Key::Epsilon => number(parts.epsilon),
        Key::Ceiling => number(parts.numerics?.ceiling?),
        Key::Method => word(match parts.method? {
            Method::Seidel => "seidel",
            Method::Newton => "newton",
            Method::Auto => "auto",
        }),
        Key::Tolerance => number(parts.numerics?.tolerance),
        Key::MaxIterations => Some(Setting::Count(parts.numerics?.max_iterations)),
        Key::Simulate => {
            (!parts.simulate.is_empty()).then(|| Setting::Effects(parts.simulate.to_vec()))
        }
        Key::Starts => Some(Setting::Count(parts.starts?)),
        Key::Seed => Some(Setting::Count(u32::try_from(parts.seed?).unwrap_or(u32::MAX))),
        Key::Cases => parts.cases.then_some(Setting::Flag(true)),
        Key::Width => number(parts.width?),
        Key::Plane => parts.plane.then_some(Setting::Flag(true)),
        _ => None,
    }
}

fn number(x: f64) -> Option<Setting> {
    Some(Setting::Number(x))
}

fn word(text: &str) -> Option<Setting> {
    Some(Setting::Word(text.to_owned()))
}

fn count(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}
