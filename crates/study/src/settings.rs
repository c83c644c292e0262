//! From a job to the settings that describe it.

use std::borrow::Cow;

use contact::model::{
    Base, Domain, Effect, Foundation, Loading, Material, Mesh, Method, Numerics, Projection, Shape,
    Side, Step,
};
use contact::multiplicity::Search;
use contact::uniqueness::Sole;

use crate::job::{Case, Job};
use crate::key::Key;
use crate::sheet::Setting;

/// What a job says, whatever its kind.
struct Parts<'a> {
    foundation: &'a Foundation,
    shape: Option<Cow<'a, Shape>>,
    material: Option<&'a Material>,
    mu: Option<f64>,
    domain: Option<&'a Domain>,
    loading: Option<&'a Loading>,
    mesh: Mesh,
    projection: Projection,
    epsilon: f64,
    numerics: Option<&'a Numerics>,
    /// What a search does not leave to the numerics.
    method: Option<Method>,
    simulate: &'a [Effect],
    /// Starts and seed.
    search: Option<(u32, u64)>,
}

impl<'a> Parts<'a> {
    fn of(job: &'a Job) -> Self {
        let is_search = matches!(job, Job::Multiplicity { .. });
        match job {
            Job::Solve(Case { scene, numerics })
            | Job::Cost { case: Case { scene, numerics }, .. }
            | Job::Multiplicity { case: Case { scene, numerics }, .. } => Parts {
                foundation: &scene.foundation,
                shape: Some(Cow::Borrowed(&scene.punch.shape)),
                material: scene.punch.material.as_ref(),
                mu: Some(scene.friction.mu),
                domain: scene.domain.as_ref(),
                loading: Some(&scene.loading),
                mesh: numerics.mesh,
                projection: numerics.projection,
                epsilon: numerics.epsilon,
                numerics: Some(numerics),
                method: (!is_search).then_some(numerics.method),
                simulate: if is_search { &[] } else { &numerics.simulate },
                search: match job {
                    Job::Multiplicity { search: Search { starts, seed }, .. } => {
                        Some((*starts, *seed))
                    }
                    Job::Solve(_) | Job::Cost { .. } | Job::Uniqueness { .. } => None,
                },
            },
            Job::Uniqueness { question, search } => Parts {
                foundation: &question.foundation,
                shape: Some(Cow::Owned(match question.sole {
                    Sole::Rectangle { width_x, width_y } => {
                        Shape::FlatRectangle { width_x, width_y }
                    }
                    Sole::Disk { radius } => Shape::FlatDisk { radius },
                })),
                material: question.punch.as_ref(),
                mu: None,
                domain: None,
                loading: None,
                mesh: question.mesh,
                projection: question.projection,
                epsilon: question.epsilon,
                numerics: None,
                method: None,
                simulate: &[],
                search: Some((search.starts, search.seed)),
            },
        }
    }
}

/// The length that [`Key::Layers`] or [`Key::Steps`] has in a job.
pub(crate) fn length(job: &Job, list: Key) -> u32 {
    let parts = Parts::of(job);
    let length = match list {
        Key::Layers => parts.foundation.layers.len(),
        _ => parts.loading.map_or(0, |loading| loading.steps.len()),
    };
    u32::try_from(length).unwrap_or(u32::MAX)
}

/// Every key that a job has, with its value: the opposite of assembling it.
pub(crate) fn settings(job: &Job) -> Vec<(Key, Setting)> {
    Key::all(|list| length(job, list))
        .into_iter()
        .filter_map(|key| Some((key, setting(job, key)?)))
        .collect()
}

/// The value that a job has for a key; `None` where it has none.
pub(crate) fn setting(job: &Job, key: Key) -> Option<Setting> {
    let number = |x: f64| Some(Setting::Number(x));
    let word = |text: &str| Some(Setting::Word(text.to_owned()));
    let Parts {
        foundation: Foundation { layers, base },
        shape,
        material,
        mu,
        domain,
        loading,
        mesh,
        projection,
        epsilon,
        numerics,
        method,
        simulate,
        search,
    } = Parts::of(job);
    let shape = shape.as_deref();
    let wheel = || match shape? {
        Shape::WheelOnRail(wheel) => Some(wheel),
        _ => None,
    };
    let layer = |i: u32| layers.get(i as usize);
    let step = |i: u32, part: fn(&Step) -> Option<f64>| {
        loading?.steps.get(i as usize).and_then(part).map(Setting::Number)
    };
    match key {
        Key::Layers => Some(Setting::Count(length(job, key))),
        Key::Steps => loading.map(|_| Setting::Count(length(job, key))),
        Key::LayerShearModulus(i) => number(layer(i)?.shear_modulus),
        Key::LayerPoisson(i) => number(layer(i)?.poisson),
        Key::LayerThickness(i) => number(layer(i)?.thickness),
        Key::Base => match base {
            Base::Rigid => word("rigid"),
            Base::Elastic(_) => None,
        },
        Key::ShearModulus | Key::Poisson => match base {
            Base::Elastic(material) => {
                number(if key == Key::Poisson { material.poisson } else { material.shear_modulus })
            }
            Base::Rigid => None,
        },
        Key::Shape => word(match shape? {
            Shape::Sphere { .. } => "sphere",
            Shape::Ellipsoid { .. } => "ellipsoid",
            Shape::FlatRectangle { .. } => "flat-rectangle",
            Shape::FlatDisk { .. } => "flat-disk",
            Shape::Cone { .. } => "cone",
            Shape::HeightMap { .. } => "height-map",
            Shape::WheelOnRail(_) => "wheel-on-rail",
        }),
        Key::Radius => match shape? {
            Shape::Sphere { radius } | Shape::FlatDisk { radius } => number(*radius),
            _ => None,
        },
        Key::RadiusX | Key::RadiusY => match shape? {
            Shape::Ellipsoid { radius_x, radius_y } => {
                number(if key == Key::RadiusX { *radius_x } else { *radius_y })
            }
            _ => None,
        },
        Key::WidthX | Key::WidthY => match shape? {
            Shape::FlatRectangle { width_x, width_y }
            | Shape::HeightMap { width_x, width_y, .. } => {
                number(if key == Key::WidthX { *width_x } else { *width_y })
            }
            _ => None,
        },
        Key::ConeAngle => match shape? {
            Shape::Cone { angle } => number(*angle),
            _ => None,
        },
        Key::Surface => match shape? {
            Shape::HeightMap { surface, .. } => word(surface),
            _ => None,
        },
        Key::Wheel => word(&wheel()?.wheel),
        Key::Rail => word(&wheel()?.rail),
        Key::Side => word(match wheel()?.side {
            Side::Left => "left",
            Side::Right => "right",
        }),
        Key::RollingRadius => number(wheel()?.rolling_radius),
        Key::Gauge => number(wheel()?.gauge),
        Key::GaugeDepth => number(wheel()?.gauge_depth),
        Key::FlangeBackDistance => number(wheel()?.flange_back_distance),
        Key::FlangeBackToOrigin => number(wheel()?.flange_back_to_origin),
        Key::Lateral => number(wheel()?.lateral),
        Key::Yaw => number(wheel()?.yaw),
        Key::Roll => number(wheel()?.roll),
        // a job names its surface by content
        Key::File | Key::HeightUnit => None,
        Key::PunchShearModulus => number(material?.shear_modulus),
        Key::PunchPoisson => number(material?.poisson),
        Key::Mu => number(mu?),
        Key::DomainWidthX => number(domain?.width_x),
        Key::DomainWidthY => number(domain?.width_y),
        Key::DomainCenterX => number(domain?.center_x),
        Key::DomainCenterY => number(domain?.center_y),
        Key::Approach(i) => step(i, |step| step.approach),
        Key::NormalForce(i) => step(i, |step| step.normal_force),
        Key::ShiftX(i) => step(i, |step| step.shift_x),
        Key::ForceX(i) => step(i, |step| step.force_x),
        Key::ShiftY(i) => step(i, |step| step.shift_y),
        Key::ForceY(i) => step(i, |step| step.force_y),
        Key::TiltX(i) => step(i, |step| step.tilt_x),
        Key::MomentX(i) => step(i, |step| step.moment_x),
        Key::TiltY(i) => step(i, |step| step.tilt_y),
        Key::MomentY(i) => step(i, |step| step.moment_y),
        Key::Twist(i) => step(i, |step| step.twist),
        Key::MomentZ(i) => step(i, |step| step.moment_z),
        Key::Increments(i) => Some(Setting::Count(loading?.steps.get(i as usize)?.increments)),
        Key::CycleFrom => Some(Setting::Count(loading?.cycle_from?)),
        Key::Cycles => Some(Setting::Count(loading?.cycles)),
        Key::Mesh => Some(Setting::Mesh(mesh)),
        Key::Projection => word(match projection {
            Projection::Average => "average",
            Projection::Midpoint => "midpoint",
        }),
        Key::Epsilon => number(epsilon),
        Key::Ceiling => number(numerics?.ceiling?),
        Key::Method => word(match method? {
            Method::Seidel => "seidel",
            Method::Newton => "newton",
            Method::Auto => "auto",
        }),
        Key::Tolerance => number(numerics?.tolerance),
        Key::MaxIterations => Some(Setting::Count(numerics?.max_iterations)),
        Key::Starts => Some(Setting::Count(search?.0)),
        Key::Seed => Some(Setting::Count(u32::try_from(search?.1).unwrap_or(u32::MAX))),
        Key::Simulate => (!simulate.is_empty()).then(|| Setting::Effects(simulate.to_vec())),
    }
}
