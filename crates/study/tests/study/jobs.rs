//! Jobs of every kind that follows a path, made at random, and the files that they name.

use std::sync::OnceLock;

use proptest::prelude::*;

use contact::model::{
    Base, Domain, Effect, Foundation, Friction, InteriorQuestion, Layer, Loading, Material, Mesh,
    Method, Numerics, Projection, Punch, Rolling, RollingDirection, RollingHistory, Scene, Shape,
    Side, Step, Wear, WheelRail, WheelsetMotion,
};
use contact::punch::ProfileKind;
use study::surface::MapReading;
use study::{Case, Job, NamedFile, Study};

prop_compose! {
    fn material()(shear_modulus in 1e-3..1e15f64, poisson in 0.0..=0.5f64) -> Material {
        Material { shear_modulus, poisson }
    }
}

fn length() -> impl Strategy<Value = f64> {
    (1e-12..1e3f64).prop_union(1e-9..1e-3f64).boxed()
}

fn shape() -> impl Strategy<Value = Shape> {
    prop_oneof![
        length().prop_map(|radius| Shape::Sphere { radius }),
        length().prop_map(|radius| Shape::FlatDisk { radius }),
        (length(), length())
            .prop_map(|(radius_x, radius_y)| Shape::Ellipsoid { radius_x, radius_y }),
        (length(), length())
            .prop_map(|(width_x, width_y)| Shape::FlatRectangle { width_x, width_y }),
        (1e-6..1.5f64).prop_map(|angle| Shape::Cone { angle }),
        (length(), length()).prop_map(|(width_x, width_y)| Shape::HeightMap {
            surface: stored().0,
            width_x,
            width_y
        }),
        wheel_on_rail().prop_map(Shape::WheelOnRail),
    ]
}

prop_compose! {
    fn wheel_on_rail()(
        left: bool,
        lengths in prop::array::uniform5(length()),
        [lateral, yaw, roll] in prop::array::uniform3(-0.1..0.1f64),
    ) -> WheelRail {
        let [wheel, rail] = [&profiles()[0], &profiles()[1]].map(|(name, _)| name.clone());
        let [rolling_radius, gauge, gauge_depth, flange_back_distance, flange_back_to_origin] = lengths;
        let side = if left { Side::Left } else { Side::Right };
        WheelRail { wheel, rail, side, rolling_radius, gauge, gauge_depth, flange_back_distance, flange_back_to_origin, lateral, yaw, roll, motion: None }
    }
}

pub(crate) const WHEEL: &[u8] = include_bytes!("../../../../sweeps/profiles/MBench_S1002_v3.prw");
pub(crate) const RAIL: &[u8] = include_bytes!("../../../../sweeps/profiles/MBench_UIC60_v3.prr");

/// Returns the names and the bytes of a wheel's and a rail's profile.
pub(crate) fn profiles() -> &'static [(String, Vec<u8>); 2] {
    static PROFILES: OnceLock<[(String, Vec<u8>); 2]> = OnceLock::new();
    PROFILES.get_or_init(|| {
        [(WHEEL, ProfileKind::Wheel), (RAIL, ProfileKind::Rail)].map(|(file, kind)| {
            let profile = study::profile::read(file, kind).unwrap().profile;
            (study::profile::name(&profile), study::profile::encode_profile(&profile))
        })
    })
}

/// Gives out what is stored here.
pub(crate) fn from_store(name: &str) -> Result<NamedFile, String> {
    let found = profiles().iter().cloned().chain([stored()]).find(|(stored, _)| stored == name);
    named(found.map(|(_, bytes)| bytes).ok_or_else(|| format!("{name}: no such file"))?)
}

/// Gives out a file of which messages may repeat something.
pub(crate) fn named(bytes: Vec<u8>) -> Result<NamedFile, String> {
    Ok(NamedFile { bytes, may_quote: true })
}

/// Returns the name and the bytes of a surface.
pub(crate) fn stored() -> (String, Vec<u8>) {
    let reading = MapReading { unit: Some("nm"), ..MapReading::default() };
    let surface = study::surface::read(b"0 1\n2 3", &reading).unwrap().surface;
    (study::surface::name(&surface), study::surface::encode_surface(&surface))
}

prop_compose! {
    fn layer()(material in material(), thickness in length()) -> Layer {
        Layer { shear_modulus: material.shear_modulus, poisson: material.poisson, thickness }
    }
}

prop_compose! {
    fn foundation()(layers in prop::collection::vec(layer(), 0..5), material in material(), rigid: bool) -> Foundation {
        let base = if rigid && !layers.is_empty() { Base::Rigid } else { Base::Elastic(material) };
        Foundation { layers, base }
    }
}

/// Makes a degree of freedom of a step: left alone, moved, or governed by its force.
fn control() -> impl Strategy<Value = [Option<f64>; 2]> {
    prop_oneof![
        2 => Just([None, None]),
        1 => (-1e-3..1e-3f64).prop_map(|motion| [Some(motion), None]),
        1 => (-1e6..1e6f64).prop_map(|force| [None, Some(force)]),
    ]
}

prop_compose! {
    fn step()(normal in control(), shift in prop::array::uniform2(control()), turn in prop::array::uniform3(control()), increments in 1u32..20) -> Step {
        let [approach, normal_force] = normal;
        let [[shift_x, force_x], [shift_y, force_y]] = shift;
        let [[tilt_x, moment_x], [tilt_y, moment_y], [twist, moment_z]] = turn;
        let normal_force = normal_force.map(|force: f64| force.abs() + 1e-3);
        Step { approach, normal_force, shift_x, force_x, shift_y, force_y, tilt_x, moment_x, tilt_y, moment_y, twist, moment_z, increments, rolling: None }
    }
}

prop_compose! {
    fn loading()(
        first in prop_oneof![(-1e-3..1e-3f64).prop_map(|x| [Some(x), None]), (1e-3..1e6f64).prop_map(|x| [None, Some(x)])],
        mut steps in prop::collection::vec(step(), 1..12),
        from in prop::option::of(any::<prop::sample::Index>()),
        cycles in 1u32..4,
    ) -> Loading {
        [steps[0].approach, steps[0].normal_force] = first;
        let cycle_from = from.map(|from| from.index(steps.len()) as u32);
        Loading { steps, cycle_from, cycles: if cycle_from.is_some() { cycles } else { 1 } }
    }
}

prop_compose! {
    fn domain()(width_x in length(), width_y in length(), center_x in -1.0..1.0f64, center_y in prop_oneof![Just(0.0), -1.0..1.0f64]) -> Domain {
        Domain { width_x, width_y, center_x, center_y }
    }
}

prop_compose! {
    fn numerics()(
        mesh in prop_oneof![(1u32..4096).prop_map(Mesh::Across), [1u32..4096, 1u32..4096].prop_map(Mesh::Exact)],
        projection in prop_oneof![Just(Projection::Average), Just(Projection::Midpoint)],
        epsilon in prop_oneof![Just(0.0), 0.0..1.0f64],
        ceiling in prop::option::of(1.0..1e12f64),
        method in prop_oneof![Just(Method::Auto), Just(Method::Seidel), Just(Method::Newton)],
        tolerance in 1e-15..0.9f64,
        max_iterations in 1u32..,
        simulate in prop::sample::subsequence(Effect::OPTIONAL.to_vec(), 0..=Effect::OPTIONAL.len()),
    ) -> Numerics {
        Numerics { mesh, projection, epsilon, ceiling, method, tolerance, max_iterations, simulate }
    }
}

prop_compose! {
    /// Depths are in parts of that of a rigid base.
    fn interior()(
        maximum: bool,
        depths in prop::collection::vec(0.0..1.0f64, 0..3),
        points in prop::collection::vec([-1.0..1.0f64, -1.0..1.0f64, 0.0..1.0f64], 0..3),
    ) -> InteriorQuestion {
        InteriorQuestion { maximum: maximum || depths.is_empty(), depths, points }.normalised()
    }
}

prop_compose! {
    /// Makes a rolling, and the increments of its step.
    fn rolling()(
        creepages in prop::array::uniform3(prop::option::of(prop_oneof![Just(0.0), -1e-2..1e-2f64])),
        center in prop_oneof![Just(0.0), -1e-2..1e-2f64],
        is_backward: bool,
        distance in 1e-6..10.0f64,
        dq in prop::option::of(1e-6..1.0f64),
        (history, is_divided) in prop_oneof![
            Just((RollingHistory::Steady, false)),
            Just((RollingHistory::Transient, false)),
            Just((RollingHistory::Transient, true)),
        ],
        increments in 1u32..20,
    ) -> (Rolling, u32) {
        let [creepage_x, creepage_y, spin] = creepages;
        let parts = if is_divided { increments } else { 1 };
        let (dq, distance) = match history {
            RollingHistory::Steady => (dq, None),
            RollingHistory::Transient if is_divided => (Some(distance / f64::from(parts)), None),
            RollingHistory::Transient => (None, Some(distance)),
        };
        let direction = if is_backward { RollingDirection::Backward } else { RollingDirection::Forward };
        let spin_center = if spin.is_some() { center } else { 0.0 };
        let imposed = Default::default();
        (Rolling { creepage_x, creepage_y, spin, spin_center, direction, dq, distance, history, imposed }, parts)
    }
}

prop_compose! {
    fn motion()(speed in 1.0..100.0f64, angular_speed in prop::option::of(1.0..200.0f64), rates in prop::array::uniform3(0.1..1.0f64)) -> WheelsetMotion {
        let [lateral_velocity, yaw_rate, roll_rate] = rates;
        WheelsetMotion { speed, angular_speed, lateral_velocity, yaw_rate, roll_rate }
    }
}

/// Lets a step roll, at creepages that no force governs and that no wheelset imposes.
fn roll(step: &mut Step, (rolling, increments): (Rolling, u32), is_imposed: bool) {
    let keep = |creepage: Option<f64>, force: Option<f64>| {
        creepage.filter(|_| force.is_none() && !is_imposed)
    };
    let spin = keep(rolling.spin, step.moment_z);
    step.rolling = Some(Rolling {
        creepage_x: keep(rolling.creepage_x, step.force_x),
        creepage_y: keep(rolling.creepage_y, step.force_y),
        spin,
        spin_center: if spin.is_some() { rolling.spin_center } else { 0.0 },
        ..rolling
    });
    (step.shift_x, step.shift_y, step.twist, step.increments) = (None, None, None, increments);
}

prop_compose! {
    /// Makes a job that also has what rolls, moves and wears.
    pub(crate) fn solved_job()(
        job in plain_job(),
        rolling in prop::collection::vec(prop::option::of(rolling()), 12),
        motion in prop::option::of(motion()),
    ) -> Job {
        let Job::Solve(mut case) = job else { unreachable!("a plain job solves a scene") };
        let Scene { loading, punch, wear, .. } = &mut case.scene;
        // What has an edge or a tip does not roll.
        let is_round = !matches!(
            punch.shape,
            Shape::FlatRectangle { .. } | Shape::FlatDisk { .. } | Shape::Cone { .. }
        );
        let rolling: Vec<_> = rolling.into_iter().filter(|_| is_round).collect();
        let rolls = rolling.iter().zip(&loading.steps).any(|(rolling, _)| rolling.is_some());
        let is_turned = loading.steps.iter().any(|step| step.moment_z.is_some());
        let motion = motion.filter(|_| rolls && !is_turned);
        let mut is_imposed = false;
        if let Shape::WheelOnRail(wheel) = &mut punch.shape {
            let is_pulled = loading.steps.iter().any(|step| step.force_x.is_some());
            let is_pulled_aside = loading.steps.iter().any(|step| step.force_y.is_some());
            let aside = |velocity: f64| if is_pulled_aside { 0.0 } else { velocity };
            wheel.motion = motion.map(|motion| WheelsetMotion {
                angular_speed: motion.angular_speed.filter(|_| !is_pulled),
                lateral_velocity: aside(motion.lateral_velocity),
                roll_rate: aside(motion.roll_rate),
                ..motion
            });
            is_imposed = motion.is_some();
        }
        for (step, rolling) in loading.steps.iter_mut().zip(rolling) {
            rolling.into_iter().for_each(|rolling| roll(step, rolling, is_imposed));
        }
        if rolls {
            *wear = wear.map(|wear| Wear { update: false, repeat: 1, ..wear });
            case.numerics.epsilon = 0.0;
            case.numerics.method = Method::Auto;
        }
        Job::Solve(case)
    }
}

/// Makes a job of any kind that follows a path.
pub(crate) fn job() -> impl Strategy<Value = Job> {
    prop_oneof![
        3 => solved_job(),
        1 => (solved_job(), 1u32..1000, 1u32..64).prop_map(|(job, repeat, threads)| {
            Job::Cost { case: job.case().unwrap().clone(), repeat, threads }
        }),
    ]
}

prop_compose! {
    /// Makes a job without rolling.
    pub(crate) fn plain_job()(
        foundation in foundation(),
        shape in shape(),
        material in prop::option::of(material()),
        mu in 0.0..10.0f64,
        domain in prop::option::of(domain()),
        loading in loading(),
        interior in prop::option::of(interior()),
        numerics in numerics(),
        wear in prop::option::of((0.0..1e-9f64, any::<bool>(), 1u32..1000)),
    ) -> Job {
        let mut interior = interior;
        if let Some(InteriorQuestion { depths, points, .. }) = &mut interior {
            let deepest = foundation.depth().unwrap_or(1.0);
            let below = depths.iter_mut().chain(points.iter_mut().map(|point| &mut point[2]));
            below.for_each(|depth| *depth *= deepest);
        }
        let scene = Scene {
            foundation,
            punch: Punch { shape, material },
            friction: Friction { mu: if wear.is_some() { mu + 0.1 } else { mu } },
            wear: wear.map(|(coefficient, update, repeat)| Wear {
                coefficient,
                update,
                repeat: if loading.cycle_from.is_some() { repeat } else { 1 },
            }),
            domain,
            loading,
            interior,
        };
        Job::Solve(Case { scene, numerics })
    }
}

/// Returns the only job of a study, or the first of several.
pub(crate) fn read_job(text: &str) -> Job {
    let text = format!("name = \"job\"\n{text}");
    let study = Study::parse(&text, "job.toml", &mut from_store);
    study.unwrap_or_else(|error| panic!("{text}\n{error}")).points()[0].job.clone()
}
