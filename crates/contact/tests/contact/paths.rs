//! Loading paths meet theory: many small steps, given forces, loops, torsion, and paths that cannot
//! be followed.

use crate::common::*;
use contact::model::*;
use contact::punch::Surfaces;
use contact::{Operators, solve, theory};
use std::f64::consts::PI;

fn radius(area: f64) -> f64 {
    (area / PI).sqrt()
}

fn newton(mesh: u32) -> Numerics {
    numerics(Mesh::Across(mesh), Projection::Average, 1e-8)
}

/// Returns the least-squares slope of −ln error over ln n.
fn order(counts: &[u32], errors: &[f64]) -> f64 {
    let (x, y): (Vec<f64>, Vec<f64>) =
        counts.iter().zip(errors).map(|(n, e)| (f64::from(*n).ln(), -e.ln())).unzip();
    let (mx, my) = (x.iter().sum::<f64>() / x.len() as f64, y.iter().sum::<f64>() / y.len() as f64);
    let (xy, xx) = x
        .iter()
        .zip(&y)
        .fold((0.0, 0.0), |(xy, xx), (x, y)| (xy + (x - mx) * (y - my), xx + (x - mx).powi(2)));
    xy / xx
}

/// A sphere is pressed in more and more steps on finer and finer grids: the load and the stick
/// radius go to those of Spence's problem.
#[test]
fn many_small_steps_lead_to_spence() {
    for (poisson, mu) in
        [("0.0", "0.3"), ("0.0", "1.0"), ("0.3", "0.2"), ("0.3", "0.3"), ("0.4", "0.1")]
    {
        let file = reference("spence_incremental.csv");
        let row = file
            .lines()
            .find(|line| line.starts_with(&format!("{poisson},{mu},")))
            .expect("a row of this ν and μ");
        let row: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let (stick, ratio) = (row[4], row[7]);
        let hertz = theory::hertz_sphere(2.0 / (1.0 - row[0]), 1.0, 1.0);
        let meshes = [12, 24, 48];
        let mut errors = Vec::new();
        for mesh in meshes {
            let step = Step { approach: Some(1.0), increments: mesh / 2, ..Step::default() };
            let scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, row[0], row[1], step);
            let (path, _) = certified_path(&scene, &newton(mesh));
            assert_eq!(path.len(), mesh as usize / 2);
            let o = path.last().unwrap().observables;
            errors.push((o.load / hertz.load / ratio - 1.0).abs());
            let off = (radius(o.stick_area) - stick * radius(o.contact_area)) / o.element_x;
            assert!(
                off.abs() < 0.75,
                "ν {poisson} μ {mu}, {mesh}: stick radius off by {off:.2} elements"
            );
        }
        let order = order(&meshes, &errors);
        eprintln!("ν {poisson} μ {mu}: load {errors:?}, order {order:.2}");
        assert!(
            order > 0.9 && errors[2] < 1.5e-3,
            "ν {poisson} μ {mu}: {errors:?}, order {order:.2}"
        );
    }
}

/// The pressure and the traction of the same sphere along a radius meet Spence's, for μ = 0.3 and ν
/// = 0. The root mean square difference falls with the elements and the steps; that of the traction
/// is largest at its kink, where stick ends.
#[test]
fn many_small_steps_give_spences_profiles() {
    let row = |name: &str, start: &str| -> Vec<Vec<f64>> {
        let file = reference(name);
        file.lines()
            .filter(|line| line.starts_with(start))
            .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
            .collect()
    };
    // The loads over Hertz's at the same a and at the same δ give a³ over δ^{3/2}.
    let loads = &row("spence_incremental.csv", "0.0,0.3,")[0];
    let contact = (loads[7] / loads[6]).cbrt();
    // Hertz's peak at the same a is 2E*a/πR, with E* = 2G/(1−ν).
    let peak = 2.0 / PI * 2.0 * contact;
    let profile = row("spence_sphere_profiles.csv", "0.0,0.3,");
    assert_eq!(profile.len(), 12);
    let meshes = [24, 48, 96];
    let mut errors = Vec::new();
    for n in meshes {
        let step = Step { approach: Some(1.0), increments: n / 3, ..Step::default() };
        let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.0, 0.3, step);
        scene.domain = square(2.4);
        let (_, fields) = certified_path(&scene, &newton(n));
        let h = fields.element[0];
        let along: Vec<[f64; 3]> = (n / 2..n)
            .map(|i| {
                let (e, x, y) =
                    ((n / 2 * n + i) as usize, (f64::from(i - n / 2) + 0.5) * h, 0.5 * h);
                // The surface is drawn inwards, and the punch holds it back.
                let outwards = (fields.traction_x[e] * x + fields.traction_y[e] * y) / x.hypot(y);
                [x.hypot(y), fields.pressure[e], outwards]
            })
            .collect();
        let interpolated = |r: f64, c: usize| {
            let next = along.iter().position(|point| point[0] > r).unwrap().max(1);
            let (a, b) = (along[next - 1], along[next]);
            a[c] + (r - a[0]) / (b[0] - a[0]) * (b[c] - a[c])
        };
        // The last point lies within an element of the edge.
        let points = &profile[..11];
        errors.push([1, 2].map(|c| {
            let off = points
                .iter()
                .map(|point| (interpolated(point[3] * contact, c) / peak - point[3 + c]).powi(2));
            (off.sum::<f64>() / points.len() as f64).sqrt()
        }));
    }
    let orders =
        [0, 1].map(|c| order(&meshes, &errors.iter().map(|errors| errors[c]).collect::<Vec<_>>()));
    eprintln!("pressure and traction off by, over p₀: {errors:?}, orders {orders:.2?}");
    assert!(
        errors[2][0] < 5e-3 && errors[2][1] < 1e-2 && orders.iter().all(|order| *order > 0.7),
        "{errors:?}, orders {orders:?}"
    );
}

/// One step is not many: the stick zone of the same sphere pressed at once is far smaller, and that
/// of a flat punch is the same.
#[test]
fn the_path_matters_to_a_sphere_and_not_to_a_flat_punch() {
    let end = |shape: Shape, approach: f64, increments: u32| {
        let step = Step { approach: Some(approach), increments, ..Step::default() };
        *certified_path(&scene(shape, 1.0, 0.3, 0.3, step), &newton(32)).0.last().unwrap()
    };
    let stick =
        |end: StepOutcome| (end.observables.stick_area / end.observables.contact_area).sqrt();
    let sphere = Shape::Sphere { radius: 1.0 };
    assert!((stick(end(sphere.clone(), 1.0, 1)) - 0.52).abs() < 0.03);
    assert!((stick(end(sphere, 1.0, 32)) - 0.90).abs() < 0.03);
    let disk = Shape::FlatDisk { radius: 1.0 };
    let (once, often) = (end(disk.clone(), 0.01, 1), end(disk, 0.01, 8));
    assert_eq!(once.observables.stick_elements, often.observables.stick_elements);
    assert!((once.observables.load / often.observables.load - 1.0).abs() < 1e-7);
}

/// Returns a scene of like spheres with ν = 0, where Cattaneo's and Mindlin's theory is exact; μ =
/// 0.4 and a = δ = R = 1.
fn like_spheres(steps: Vec<Step>) -> Scene {
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 2.0, 0.0, 0.4, Step::default());
    scene.punch.material = Some(Material { shear_modulus: 2.0, poisson: 0.0 });
    scene.loading = Loading::path(steps);
    scene.domain = square(3.0);
    scene
}

/// The shear compliance S = Σ(2−ν)/G of these spheres.
const SHEAR_COMPLIANCE: f64 = 2.0;

#[test]
fn a_prescribed_tangential_force_meets_cattaneo_and_mindlin() {
    let hertz = theory::hertz_sphere(2.0, 1.0, 1.0);
    let limit = 0.4 * hertz.load;
    for fraction in [0.2, 0.5, 0.8, 0.95] {
        let press = Step { normal_force: Some(hertz.load), ..Step::default() };
        let pull = Step { force_x: Some(fraction * limit), ..Step::default() };
        let shift = theory::cattaneo_shift(fraction * limit, limit, 1.0, SHEAR_COMPLIANCE);
        let stick = theory::cattaneo_stick_ratio(fraction * limit, limit);
        let meshes = [12, 24, 48, 96];
        let (mut shifts, mut approaches) = (Vec::new(), Vec::new());
        for mesh in meshes {
            let (path, _) = certified_path(&like_spheres(vec![press, pull]), &newton(mesh));
            let end = path[1];
            assert!(
                (end.observables.force_x / (fraction * limit) - 1.0).abs() < 1e-7
                    && (end.observables.load / hertz.load - 1.0).abs() < 1e-7
            );
            shifts.push((end.motion.shift_x / shift - 1.0).abs());
            approaches.push((end.motion.approach - 1.0).abs());
            let off = (radius(end.observables.stick_area) - stick) / end.observables.element_x;
            assert!(
                off.abs() < 0.75,
                "Q/μP = {fraction}, {mesh}: stick radius off by {off:.2} elements"
            );
        }
        let orders = [order(&meshes, &shifts), order(&meshes, &approaches)];
        eprintln!(
            "Q/μP = {fraction}: shift {shifts:?}, approach {approaches:?}, orders {orders:.2?}"
        );
        assert!(
            orders[0] > 1.2 && orders[1] > 1.2 && shifts[3] < 1e-3,
            "Q/μP = {fraction}: {shifts:?} {approaches:?}"
        );
    }
}

/// The hysteresis loop under ±Q* has the loss of theory. The loss per cycle needs no small steps,
/// since tractions stay as they are where an element slips to one side only. The work of the force,
/// the mean of the forces before and after times the displacement, does need them.
#[test]
fn a_loop_of_the_tangential_force_meets_mindlin_and_deresiewicz() {
    let hertz = theory::hertz_sphere(2.0, 1.0, 1.0);
    let limit = 0.4 * hertz.load;
    let amplitude = 0.7 * limit;
    let expected = theory::mindlin_deresiewicz_loss(amplitude, limit, 1.0, SHEAR_COMPLIANCE);
    let pulled_to =
        |force: f64, increments: u32| Step { force_x: Some(force), increments, ..Step::default() };
    let cycled = |mesh: u32, increments: u32| {
        let mut scene = like_spheres(vec![
            Step { normal_force: Some(hertz.load), ..Step::default() },
            pulled_to(amplitude, 1),
            pulled_to(-amplitude, increments),
            pulled_to(amplitude, increments),
        ]);
        (scene.loading.cycle_from, scene.loading.cycles) = (Some(2), 2);
        let (outcome, _) =
            solve(&scene, &newton(mesh), &Surfaces::new(), &mut Operators::default()).unwrap();
        assert_eq!(outcome.status, Status::Certified);
        outcome
    };
    let meshes = [12, 24, 48];
    let mut errors = Vec::new();
    for mesh in meshes {
        let outcome = cycled(mesh, 2);
        let lost = outcome.cycle_dissipation().unwrap();
        let first: f64 = outcome
            .steps
            .iter()
            .filter(|step| step.cycle == 1)
            .map(|step| step.observables.dissipation)
            .sum();
        assert!((first / lost - 1.0).abs() < 1e-5, "the second loop is the first");
        let energies =
            [outcome.steps[1], *outcome.last().unwrap()].map(|step| step.observables.energy);
        assert!((energies[0] / energies[1] - 1.0).abs() < 1e-6, "{energies:?}");
        errors.push((lost / expected - 1.0).abs());
    }
    let counts = [4, 8, 16];
    let balances = counts.map(|increments| {
        // The elastic energy comes back after a cycle, so friction takes all that the force puts
        // in.
        let outcome = cycled(24, increments);
        let work: f64 = outcome
            .steps
            .iter()
            .filter(|step| step.cycle == 2)
            .map(|step| step.observables.external_work)
            .sum();
        (work / outcome.cycle_dissipation().unwrap() - 1.0).abs()
    });
    let orders = [order(&meshes, &errors), order(&counts, &balances)];
    eprintln!("loss {errors:?}, work against dissipation {balances:?}, orders {orders:.2?}");
    assert!(orders[0] > 1.0 && errors[2] < 2e-3, "{errors:?}");
    assert!(orders[1] > 1.5 && balances[2] < 1e-2, "{balances:?}");
}

/// A sphere under torsion is Reissner's and Sagoci's disk while it sticks, and as the twist grows
/// the moment goes to that of sliding, (3π/16) μPa (Lubkin, J. Appl. Mech. 18 (1951) 183–187).
#[test]
fn torsion_from_stick_to_sliding() {
    // With ν = ½ and G = 1 normal and tangential contact are uncoupled.
    let hertz = theory::hertz_sphere(4.0, 1.0, 1.0);
    let twisted = |mu: f64, twist: f64, mesh: u32| {
        let steps = vec![
            Step { approach: Some(1.0), ..Step::default() },
            Step { twist: Some(twist), ..Step::default() },
        ];
        let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.5, mu, Step::default());
        (scene.loading, scene.domain) = (Loading::path(steps), square(3.0));
        certified_path(&scene, &newton(mesh)).0[1].observables
    };
    let meshes = [12, 24, 48, 96];
    let stuck: Vec<f64> = meshes
        .iter()
        .map(|&n| {
            (twisted(1e3, 0.01, n).moment_z / theory::twisted_disk(1.0, 1.0, 0.01) - 1.0).abs()
        })
        .collect();
    let slid: Vec<f64> = meshes
        .iter()
        .map(|&n| {
            (twisted(0.1, 3.0, n).moment_z / (3.0 * PI / 16.0 * 0.1 * hertz.load) - 1.0).abs()
        })
        .collect();
    eprintln!(
        "stuck {stuck:?}, order {:.2}; slid {slid:?}, order {:.2}",
        order(&meshes, &stuck),
        order(&meshes, &slid)
    );
    assert!(order(&meshes, &stuck) > 0.8 && stuck[3] < 1e-2, "{stuck:?}");
    assert!(order(&meshes, &slid) > 1.0 && slid[3] < 2e-3, "{slid:?}");
    let between = twisted(0.1, 0.2, 48);
    assert!(
        between.stick_elements > 0
            && between.slip_elements > 0
            && between.moment_z < 3.0 * PI / 16.0 * 0.1 * hertz.load
    );
}

/// A flat sole that sticks has the stiffness of theory against each motion, when the forces are
/// prescribed. There is no coupling at ν = ½.
#[test]
fn a_sticking_disk_is_as_stiff_as_theory_says() {
    let meshes = [12, 24, 48];
    let forces = Step {
        normal_force: Some(1.0),
        force_x: Some(0.1),
        moment_y: Some(0.05),
        moment_z: Some(0.1),
        ..Step::default()
    };
    let scene = scene(Shape::FlatDisk { radius: 1.0 }, 1.0, 0.5, 1e3, forces);
    let expected = [
        1.0 / theory::flat_disk(4.0, 1.0, 1.0).load,
        0.1 / theory::shifted_disk(1.5, 1.0, 1.0),
        0.05 / theory::tilted_disk(4.0, 1.0, 1.0),
        0.1 / theory::twisted_disk(1.0, 1.0, 1.0),
    ];
    let errors = meshes.map(|mesh| {
        let end = certified_path(&scene, &newton(mesh)).0[0];
        assert_eq!(end.observables.stick_area, end.observables.sole_area);
        let motion = [end.motion.approach, end.motion.shift_x, end.motion.tilt_y, end.motion.twist];
        [0, 1, 2, 3].map(|dof| (motion[dof] / expected[dof] - 1.0).abs())
    });
    for dof in 0..4 {
        let errors = errors.map(|errors| errors[dof]);
        assert!(order(&meshes, &errors) > 0.8 && errors[2] < 0.02, "{dof}: {errors:?}");
    }
}

/// The controls that govern the punch may change from step to step: prescribing a value that is
/// there already changes nothing.
#[test]
fn changing_what_governs_the_punch_changes_nothing() {
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.3, 0.3, Step::default());
    scene.domain = square(3.2);
    let start = [
        Step { normal_force: Some(3.0), shift_x: Some(0.05), increments: 3, ..Step::default() },
        Step { force_y: Some(0.2), moment_z: Some(0.05), increments: 2, ..Step::default() },
    ];
    scene.loading = Loading::path(start.to_vec());
    let (path, _) = certified_path(&scene, &numerics(Mesh::Across(20), Projection::Average, 1e-10));
    let (o, motion) = (path.last().unwrap().observables, path.last().unwrap().motion);
    let by_motion = Step {
        approach: Some(motion.approach),
        shift_y: Some(motion.shift_y),
        twist: Some(motion.twist),
        ..Step::default()
    };
    let by_force = Step {
        force_x: Some(o.force_x),
        moment_x: Some(o.moment_x),
        moment_y: Some(o.moment_y),
        normal_force: Some(o.load),
        ..Step::default()
    };
    scene.loading.steps.extend([
        by_motion,
        by_force,
        Step { approach: Some(motion.approach), ..Step::default() },
    ]);
    let (path, _) = certified_path(&scene, &numerics(Mesh::Across(20), Projection::Average, 1e-10));
    assert_eq!(path.len(), 8);
    for later in &path[5..] {
        for (a, b) in later.observables.resultants().iter().zip(o.resultants()) {
            assert!((a - b).abs() < 1e-8 * o.load, "{:?} {:?}", later.observables, o);
        }
        for (a, b) in later.motion.per_dof().iter().zip(motion.per_dof()) {
            assert!((a - b).abs() < 1e-8, "{:?} {motion:?}", later.motion);
        }
        assert_eq!(
            later.observables.stick_elements + later.observables.slip_elements,
            o.contact_elements
        );
        assert!(later.observables.dissipation.abs() < 1e-9 * o.energy);
    }
}

/// A force that is more than friction carries, or a load beside the sole, is an outcome that says
/// so and names the step. Everything before it is kept.
#[test]
fn a_path_that_cannot_be_followed_says_where_it_ends() {
    let press = Step { normal_force: Some(1.0), ..Step::default() };
    let fails = |steps: Vec<Step>| -> (Outcome, String) {
        let outcome =
            solve(&like_spheres(steps), &newton(16), &Surfaces::new(), &mut Operators::default())
                .unwrap()
                .0;
        let Status::Failed { reason } = outcome.status.clone() else { panic!("{outcome:?}") };
        (outcome, reason)
    };
    let (outcome, reason) = fails(vec![
        press,
        Step { force_x: Some(0.3), ..Step::default() },
        Step { force_x: Some(0.66), increments: 3, ..Step::default() },
    ]);
    assert!(
        reason.starts_with(
            "loading.steps[2], increment 1 of 3: gross sliding: \
             the contact cannot carry force_x = 4.200000e-1"
        ),
        "{reason}"
    );
    assert_eq!(outcome.steps.len(), 3);
    assert!((outcome.steps[1].observables.force_x - 0.3).abs() < 1e-7);
    // A force of exactly μP is sliding, one that is a little less is not.
    assert!(
        fails(vec![Step { force_y: Some(0.4), ..press }])
            .1
            .starts_with("gross sliding: the contact cannot carry force_y")
    );
    let (path, _) = certified_path(
        &like_spheres(vec![Step { force_y: Some(0.4 * 0.999_999), ..press }]),
        &newton(16),
    );
    assert!(path[0].observables.slip_elements > 0);
    // The load follows from the approach; the sliding shows only when the step is solved.
    let hertz = theory::hertz_sphere(2.0, 1.0, 1.0);
    let given = Step { approach: Some(1.0), ..Step::default() };
    let (outcome, reason) =
        fails(vec![given, Step { force_x: Some(0.5 * hertz.load), ..Step::default() }]);
    assert!(reason.starts_with("loading.steps[1]: gross sliding"), "{reason}");
    assert_eq!(outcome.steps.len(), 2);
    let (_, reason) =
        fails(vec![given, Step { moment_z: Some(0.5 * hertz.load), ..Step::default() }]);
    assert!(
        reason.starts_with("loading.steps[1]: gross sliding: the contact cannot carry moment_z"),
        "{reason}"
    );
    let mut flat = like_spheres(vec![Step { moment_y: Some(1.1), ..press }]);
    (flat.punch.shape, flat.domain) = (Shape::FlatDisk { radius: 1.0 }, None);
    let outcome = solve(&flat, &newton(16), &Surfaces::new(), &mut Operators::default()).unwrap().0;
    assert!(
        matches!(&outcome.status, Status::Failed { reason }
            if reason.starts_with("no pressure under the sole has moment_y = 1.1")),
        "{outcome:?}"
    );
}

/// In a closed cycle of the motion in both directions, friction takes all that the forces put in
/// over a cycle, the more exactly the smaller the steps. Each increment loses energy or none.
#[test]
fn a_closed_cycle_loses_what_is_put_in() {
    let corner = |x: f64, y: f64, increments: u32| Step {
        shift_x: Some(x),
        shift_y: Some(y),
        increments,
        ..Step::default()
    };
    let counts = [2, 4, 8];
    let mut balances = Vec::new();
    for increments in counts {
        let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.3, 0.3, Step::default());
        let lead = Step { approach: Some(1.0), ..Step::default() };
        let corners = [
            corner(0.15, 0.0, increments),
            corner(0.15, 0.15, increments),
            corner(0.0, 0.15, increments),
            corner(0.0, 0.0, increments),
        ];
        scene.loading = Loading {
            steps: [vec![lead], corners.to_vec()].concat(),
            cycle_from: Some(1),
            cycles: 2,
        };
        let (outcome, _) =
            solve(&scene, &newton(24), &Surfaces::new(), &mut Operators::default()).unwrap();
        assert_eq!(outcome.status, Status::Certified);
        let energy_before =
            outcome.steps.iter().rfind(|step| step.cycle == 1).unwrap().observables.energy;
        let (mut work, mut lost) = (0.0, 0.0);
        for step in outcome.steps.iter().filter(|step| step.cycle == 2) {
            assert!(step.observables.dissipation >= -1e-9 * step.observables.energy);
            (work, lost) =
                (work + step.observables.external_work, lost + step.observables.dissipation);
        }
        let stored = outcome.last().unwrap().observables.energy - energy_before;
        balances.push(((work - stored) / lost - 1.0).abs());
    }
    eprintln!(
        "(work − stored)/dissipation − 1: {balances:?}, order {:.2}",
        order(&counts, &balances)
    );
    assert!(order(&counts, &balances) > 1.5 && balances[2] < 0.02, "{balances:?}");
}
