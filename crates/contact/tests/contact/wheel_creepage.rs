//! The creepages that follow from the motion of a wheelset meet CONTACT
//! (tests/reference/wheel_rail_creepages.csv), and so do the creep forces.

use crate::common::*;
use crate::wheel_rail::{STEEL, fine_mesh, profiles};
use contact::model::*;
use contact::problem::Effects;
use contact::punch::{WheelCreepages, domain, wheel_creepages};

/// A row of the reference, with the numbers by the names of their columns.
struct Row {
    head: Vec<String>,
    fields: Vec<String>,
}

impl Row {
    fn text(&self, name: &str) -> &str {
        &self.fields[self.head.iter().position(|column| column == name).unwrap()]
    }

    fn number(&self, name: &str) -> f64 {
        self.text(name).parse().unwrap()
    }

    fn name(&self) -> String {
        format!("{} {}", self.text("wheel"), self.text("case"))
    }

    /// Returns the case as a scene that rolls steadily, with CONTACT's load along the normal. The
    /// spin turns about a point a sixth of an element behind, as CONTACT has it.
    fn scene(&self) -> Scene {
        let motion = WheelsetMotion {
            speed: 2.0,
            angular_speed: Some(-self.number("vpitch_rad_s")),
            lateral_velocity: 0.0,
            yaw_rate: 0.0,
            roll_rate: 0.0,
        };
        let wheel = WheelRail {
            wheel: "wheel".to_owned(),
            rail: "rail".to_owned(),
            side: if self.text("wheel") == "left" { Side::Left } else { Side::Right },
            rolling_radius: 0.46,
            gauge: WheelRail::GAUGE,
            gauge_depth: WheelRail::GAUGE_DEPTH,
            flange_back_distance: WheelRail::FLANGE_BACK_DISTANCE,
            flange_back_to_origin: WheelRail::FLANGE_BACK_TO_ORIGIN,
            lateral: self.number("wheelset_y_mm") * 1e-3,
            yaw: self.number("yaw_rad"),
            roll: self.number("roll_rad"),
            motion: Some(motion),
        };
        let rolling = Rolling {
            creepage_x: None,
            creepage_y: None,
            spin: None,
            spin_center: -0.2e-3 / 6.0,
            direction: RollingDirection::Forward,
            dq: Some(0.2e-3),
            distance: None,
            history: RollingHistory::Steady,
            imposed: ImposedCreepages::default(),
        };
        let step = Step {
            normal_force: Some(self.number("FN_N")),
            rolling: Some(rolling),
            ..Step::default()
        };
        let shape = Shape::WheelOnRail(wheel);
        let mut scene = scene(shape, STEEL.shear_modulus, STEEL.poisson, 0.3, step);
        scene.punch.material = Some(STEEL);
        scene
    }
}

fn rows() -> Vec<Row> {
    let text = reference("wheel_rail_creepages.csv");
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect());
    let head: Vec<String> = lines.next().unwrap();
    lines.map(|fields| Row { head: head.clone(), fields }).collect()
}

fn row(name: &str) -> Row {
    rows().into_iter().find(|row| row.name() == name).unwrap()
}

/// CONTACT prints four digits of the creepages, and its contact angle is ours to 0.06 mrad, which
/// are 1.3e-4 rad/m of spin. Where two regions share the plane (right 11), the wheel does not touch
/// at the reference point, and CONTACT takes it there as deep as where it is deepest. Where the
/// overlap is long and uneven (right 2), the depth that is estimated for the load leaves the
/// reference point 0.2 mm off: the creepage there belongs to the same motion, and differs by the spin
/// times that.
#[test]
fn creepages_of_the_benchmark_meet_contact() {
    let surfaces = profiles();
    println!("case          ξ   CONTACT        η   CONTACT  spin in 1/m   CONTACT");
    for row in rows() {
        let found = wheel_creepages(&row.scene(), &surfaces).unwrap().unwrap();
        let ImposedCreepages { creepage_x, creepage_y, spin } = found.creepages;
        let (cksi, ceta, cphi) =
            (row.number("cksi"), row.number("ceta"), row.number("cphi_rad_mm") * 1e3);
        println!(
            "{:9} {creepage_x:11.4e} {cksi:11.4e} {creepage_y:11.4e} {ceta:11.4e} {spin:11.4e} \
             {cphi:11.4e}",
            row.name()
        );
        let [of_creepage, of_spin] = match &*row.name() {
            "right 2" | "right 11" => [3e-5, 1e-3],
            _ => [3e-6, 2e-4],
        };
        assert!((creepage_x - cksi).abs() < of_creepage + 1e-3 * cksi.abs(), "{}", row.name());
        assert!((creepage_y - ceta).abs() < 1e-6 + 1e-3 * ceta.abs(), "{}", row.name());
        assert!((spin - cphi).abs() < of_spin + 1e-3 * cphi.abs(), "{}", row.name());
        assert_eq!(found.vertical_velocity, 0.0, "{}: nothing moves across the track", row.name());
    }
}

/// Returns the outcome on elements that are not larger than CONTACT's.
fn solved(scene: &Scene) -> Outcome {
    let surfaces = profiles();
    let mesh = fine_mesh(&domain(scene, &surfaces).unwrap());
    let numerics = numerics(mesh, Projection::Midpoint, 1e-6);
    let (outcome, _) =
        contact::solve(scene, &numerics, &surfaces, &mut contact::Operators::default()).unwrap();
    assert_eq!(outcome.status, Status::Certified);
    outcome
}

/// Spin alone with the largest part sticking, creepage on the border of full slip, and a flange.
#[test]
fn creep_forces_of_the_benchmark_meet_contact() {
    println!("case      forces and moment, then those of CONTACT, in N and N mm");
    for name in ["right 1", "right 2", "left 2", "right 13", "right 17", "left 21"] {
        let row = row(name);
        let outcome = solved(&row.scene());
        let end = outcome.last().unwrap();
        let found = end.observables;
        let track = outcome.rail.unwrap().track_force(&found);
        let ours = [found.force_x, found.force_y, found.moment_z * 1e3, track[1], track[2]];
        let theirs = ["FX_N", "FS_N", "MN_Nmm", "FY_track_N", "FZ_track_N"].map(|n| row.number(n));
        println!("{name:9} {ours:9.1?} {theirs:9.1?}");
        let limit = 0.3 * found.load;
        for (ours, theirs) in ours.iter().zip(theirs).take(2) {
            assert!((ours - theirs).abs() < 0.01 * limit, "{name}: {ours} {theirs}");
        }
        // The lever of the moment is the size of the contact.
        let lever = found.contact_area.sqrt() * 1e3;
        assert!((ours[2] - theirs[2]).abs() < 0.02 * limit * lever, "{name}: {ours:?}");
        assert!((ours[3] - theirs[3]).abs() < 0.005 * found.load, "{name}: {ours:?}");
        assert!((ours[4] - theirs[4]).abs() < 0.005 * found.load, "{name}: {ours:?}");
        // What the motion of the punch says are the creepages of the wheelset.
        let imposed = wheel_creepages(&row.scene(), &profiles()).unwrap().unwrap().creepages;
        let center = imposed.spin * -0.2e-3 / 6.0;
        for (motion, creepage) in [
            (end.motion.shift_x, imposed.creepage_x),
            (end.motion.shift_y, imposed.creepage_y - center),
            (end.motion.twist, imposed.spin),
        ] {
            assert!((motion / -0.2e-3 - creepage).abs() < 1e-9 * creepage.abs() + 1e-15, "{name}");
        }
    }
}

fn motion(scene: &mut Scene) -> &mut WheelsetMotion {
    match &mut scene.punch.shape {
        Shape::WheelOnRail(WheelRail { motion: Some(motion), .. }) => motion,
        other => panic!("{other:?}"),
    }
}

fn rolling(scene: &mut Scene) -> &mut Rolling {
    scene.loading.steps[0].rolling.as_mut().unwrap()
}

/// A force governs a creepage in the place of the motion, and the others stay.
#[test]
fn a_force_governs_what_the_motion_leaves_free() {
    let mut scene = row("right 2").scene();
    motion(&mut scene).angular_speed = None;
    scene.loading.steps[0].force_x = Some(0.0);
    let surfaces = profiles();
    let imposed = wheel_creepages(&scene, &surfaces).unwrap().unwrap().creepages;
    let numerics = numerics(Mesh::Across(24), Projection::Midpoint, 1e-7);
    let (outcome, _) =
        contact::solve(&scene, &numerics, &surfaces, &mut contact::Operators::default()).unwrap();
    let end = outcome.last().unwrap();
    assert!(end.observables.force_x.abs() < 1e-3 && end.observables.force_y < -1e3, "{end:?}");
    assert!((end.motion.twist / -0.2e-3 / imposed.spin - 1.0).abs() < 1e-9, "{end:?}");
    let free = -end.motion.shift_x / 0.2e-3;
    assert!((free - imposed.creepage_x).abs() > 1e-4, "{free} {imposed:?}");
}

/// A wheelset that runs backwards is the image of one that runs forwards, in a plane across the
/// track.
#[test]
fn a_wheelset_that_runs_backwards_has_the_forces_of_the_image() {
    let forward = row("right 2").scene();
    let mut backward = forward.clone();
    let Shape::WheelOnRail(wheel) = &mut backward.punch.shape else { unreachable!() };
    wheel.yaw = -wheel.yaw;
    let WheelsetMotion { speed, angular_speed, .. } = motion(&mut backward);
    (*speed, *angular_speed) = (-*speed, angular_speed.map(|speed| -speed));
    rolling(&mut backward).direction = RollingDirection::Backward;
    rolling(&mut backward).spin_center *= -1.0;
    let numerics = numerics(Mesh::Across(24), Projection::Midpoint, 1e-8);
    let [there, back] = [&forward, &backward].map(|scene| {
        let (outcome, _) =
            contact::solve(scene, &numerics, &profiles(), &mut contact::Operators::default())
                .unwrap();
        assert_eq!(outcome.status, Status::Certified);
        outcome.last().unwrap().observables
    });
    let lever = there.contact_area.sqrt();
    let off = [
        there.force_x + back.force_x,
        there.force_y - back.force_y,
        there.load - back.load,
        (there.moment_z + back.moment_z) / lever,
    ];
    assert!(off.iter().all(|off| off.abs() < 1e-8 * there.load), "{there:?} {back:?}");
}

#[test]
fn motions_at_the_limits_have_creepages_or_are_refused_in_words() {
    let surfaces = profiles();
    let refused = |change: &dyn Fn(&mut Scene)| -> SceneError {
        let mut scene = row("right 17").scene();
        change(&mut scene);
        let numerics = numerics(Mesh::Across(8), Projection::Average, 1e-6);
        contact::solve(&scene, &numerics, &surfaces, &mut contact::Operators::default())
            .expect_err("a refusal")
    };
    let step = "loading.steps[0].";
    for (key, words, error) in [
        ("punch.speed", "must not be 0", refused(&|scene| motion(scene).speed = 0.0)),
        (
            &*format!("{step}direction"),
            "must be \"backward\"",
            refused(&|scene| motion(scene).speed = -2.0),
        ),
        ("punch.yaw_rate", "finite", refused(&|scene| motion(scene).yaw_rate = f64::INFINITY)),
        (
            "punch.speed",
            "double precision",
            refused(&|scene| motion(scene).lateral_velocity = 1.7e308),
        ),
        // On the right, 0.72 m from the middle, this wheelset goes backwards.
        (
            &*format!("{step}direction"),
            "must be \"backward\"",
            refused(&|scene| motion(scene).yaw_rate = 10.0),
        ),
        (
            &*format!("{step}creepage_x"),
            "beside `punch.speed`",
            refused(&|scene| rolling(scene).creepage_x = Some(0.0)),
        ),
        (
            "punch.angular_speed",
            "`force_x` governs",
            refused(&|scene| scene.loading.steps[0].force_x = Some(0.0)),
        ),
        (
            "punch.lateral_velocity",
            "`force_y` governs the creepage across the rail",
            refused(&|scene| {
                motion(scene).angular_speed = None;
                motion(scene).lateral_velocity = 0.01;
                scene.loading.steps[0].force_y = Some(0.0);
            }),
        ),
        (
            "punch.roll_rate",
            "`force_y` governs the creepage across the rail",
            refused(&|scene| {
                motion(scene).roll_rate = 0.01;
                scene.loading.steps[0].force_y = Some(0.0);
            }),
        ),
        (
            "punch.speed",
            "`moment_z` governs the spin",
            refused(&|scene| {
                motion(scene).angular_speed = None;
                scene.loading.steps[0].moment_z = Some(0.0);
            }),
        ),
        (
            "punch.speed",
            "without a step that rolls",
            refused(&|scene| scene.loading.steps[0].rolling = None),
        ),
    ] {
        println!("{error}");
        assert!(error.key == key && error.expected.contains(words), "{error}");
    }
    for (angular_speed, lateral_velocity, yaw_rate) in [
        (0.0, 0.0, 0.0),
        (1e6, 0.0, 0.0),
        (4.3, 1e3, 0.0),
        (4.3, 1e300, 0.0),
        (4.3, -1e-12, 2.0),
        (-4.3, 0.1, -50.0),
    ] {
        let mut scene = row("right 17").scene();
        rolling(&mut scene).dq = None;
        let of = motion(&mut scene);
        (of.angular_speed, of.lateral_velocity, of.yaw_rate) =
            (Some(angular_speed), lateral_velocity, yaw_rate);
        let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-6);
        let (outcome, _) =
            contact::solve(&scene, &numerics, &surfaces, &mut contact::Operators::default())
                .unwrap();
        assert_eq!(outcome.status, Status::Certified, "{angular_speed} {lateral_velocity}");
        let WheelCreepages { creepages, rolling_speed, .. } =
            wheel_creepages(&scene, &surfaces).unwrap().unwrap();
        assert!(rolling_speed > 0.0 && creepages.creepage_x.abs() <= 2.0 + 1e-9, "{creepages:?}");
        // All of the contact slips.
        let found = outcome.last().unwrap().observables;
        let force = found.force_x.hypot(found.force_y);
        assert!(force < 0.3 * found.load * (1.0 + 1e-6), "{found:?}");
    }
}

/// A wheel that is locked or turns back slips in all of its contact, and the material that passes
/// makes no difference beside the strains: its forces are those of the wheel that is dragged.
#[test]
fn a_locked_wheel_has_the_forces_of_one_that_is_dragged() {
    let surfaces = profiles();
    let solved = |scene: &Scene| {
        let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-8);
        let (outcome, _) =
            contact::solve(scene, &numerics, &surfaces, &mut contact::Operators::default())
                .unwrap();
        assert_eq!(outcome.status, Status::Certified);
        outcome.last().unwrap().observables
    };
    for angular_speed in [0.0, -4.3] {
        let mut locked = row("right 17").scene();
        motion(&mut locked).angular_speed = Some(angular_speed);
        let ImposedCreepages { creepage_x, creepage_y, spin } =
            wheel_creepages(&locked, &surfaces).unwrap().unwrap().creepages;
        let mut dragged = locked.clone();
        let Shape::WheelOnRail(wheel) = &mut dragged.punch.shape else { unreachable!() };
        wheel.motion = None;
        let step = dragged.loading.steps[0];
        let distance = 0.1;
        dragged.loading.steps[0] = Step {
            rolling: None,
            shift_x: Some(-distance * creepage_x),
            shift_y: Some(-distance * creepage_y),
            twist: Some(-distance * spin),
            ..step
        };
        let [there, here] = [&locked, &dragged].map(solved);
        let limit = 0.3 * there.load;
        let apart = (there.force_x - here.force_x).hypot(there.force_y - here.force_y);
        assert!(there.force_x > 0.9 * limit && there.stick_elements == 0, "{there:?}");
        assert!(apart < 1e-4 * limit, "{there:?} {here:?}");
    }
}

/// Between the tread and the flange a light wheel stands on both, in planes of their own.
#[test]
fn planes_of_their_own_have_no_common_creepages() {
    let surfaces = profiles();
    let mut scene = row("right 11").scene();
    scene.loading.steps[0].normal_force = Some(500.0);
    let mut said = Vec::new();
    for i in 0..=60 {
        let Shape::WheelOnRail(wheel) = &mut scene.punch.shape else { unreachable!() };
        wheel.lateral = 4.85e-3 + 5e-6 * f64::from(i);
        said.extend(wheel_creepages(&scene, &surfaces).err());
    }
    println!("{said:?}");
    assert!((1..60).contains(&said.len()), "{said:?}");
    for error in said {
        assert_eq!((&*error.key, &error.value[..2]), ("punch.speed", "2 "), "{error}");
        assert!(error.expected.contains("they differ from plane to plane"), "{error}");
    }
}

#[test]
fn the_plan_says_where_the_creepages_are_from() {
    let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-6);
    let effects = Effects::of(&row("right 2").scene(), &numerics, [16, 16], &profiles()).unwrap();
    let rolling =
        effects.decisions().iter().find(|decision| decision.effect == Effect::Rolling).unwrap();
    assert_eq!(
        rolling.reason,
        "the steady state of rolling is asked for; the creepages are those of the wheelset's motion"
    );
    assert!(effects.has(Effect::Friction));
}
