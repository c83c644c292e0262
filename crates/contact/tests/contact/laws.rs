//! These laws hold of every solution on any scene: Coulomb's law on elongated elements, scaling,
//! mirrors and rotations, regularisation and ceiling. A certificate notices every kind of wrong
//! answer.

use crate::common::*;
use contact::assess::{certify, observables, states};
use contact::influence::{Dense, Influence, InfluenceTable, Scratch};
use contact::model::*;
use contact::problem::Problem;
use contact::punch::Surfaces;
use contact::solver::{Stop, StopRule, seidel};
use contact::theory::hertz_ellipse;
use contact::{Operators, solve};
use proptest::prelude::*;

fn shifted_sphere(mu: f64) -> Scene {
    scene(
        Shape::Sphere { radius: 1.0 },
        1.0,
        0.3,
        mu,
        Step { approach: Some(1.0), shift_x: Some(0.1), shift_y: Some(0.04), ..Step::default() },
    )
}

#[test]
fn on_elements_three_times_as_long_as_wide_slip_opposes_traction() {
    for projection in [Projection::Average, Projection::Midpoint] {
        for mesh in [[12, 36], [36, 12]] {
            let (outcome, fields) =
                certified(&shifted_sphere(0.3), &numerics(Mesh::Exact(mesh), projection, 1e-11));
            assert!(outcome.observables.slip_elements > 50, "{:?}", outcome.observables);
            assert!(
                outcome.certificate.slip_angle < 1e-6,
                "{mesh:?}: {:e} rad",
                outcome.certificate.slip_angle
            );
            // The angle is checked once more, directly, on every element that slips.
            let largest = fields
                .slip_x
                .iter()
                .zip(&fields.slip_y)
                .zip(&fields.pressure)
                .filter(|(_, p)| **p > 0.0)
                .map(|((x, y), _)| x.hypot(*y));
            let largest = largest.fold(0.0, f64::max);
            for e in (0..fields.state.len()).filter(|&e| fields.state[e] == 3) {
                let (sx, sy, tx, ty) = (
                    fields.slip_x[e],
                    fields.slip_y[e],
                    fields.traction_x[e],
                    fields.traction_y[e],
                );
                let misfit = (sx * ty - sy * tx).abs() / tx.hypot(ty);
                assert!(
                    misfit < 1e-7 * largest && sx * tx + sy * ty <= 1e-7 * largest * tx.hypot(ty)
                );
            }
        }
    }
}

/// Returns the dimensionless figures, which no unit may change.
fn figures(o: &Observables, modulus: f64, length: f64) -> Vec<f64> {
    let force = modulus * length * length;
    let counts = [o.contact_elements, o.stick_elements, o.slip_elements].map(|count| count as f64);
    let mut figures = counts.to_vec();
    figures.extend([o.load / force, o.force_x / force, o.force_y / force]);
    figures.extend(
        [o.moment_x, o.moment_y, o.moment_z, o.energy, o.dissipation].map(|m| m / force / length),
    );
    figures.extend([
        o.peak_pressure / modulus,
        o.peak_traction / modulus,
        o.contact_area / length / length,
    ]);
    figures
}

#[test]
fn neither_moduli_nor_lengths_change_the_dimensionless_result() {
    let scaled = |modulus: f64, length: f64| {
        let step = Step {
            approach: Some(0.9 * length),
            shift_x: Some(0.1 * length),
            shift_y: Some(0.03 * length),
            twist: Some(0.02),
            tilt_x: Some(0.05),
            tilt_y: Some(-0.01),
            ..Step::default()
        };
        let mut scene = scene(Shape::Sphere { radius: length }, modulus, 0.3, 0.3, step);
        scene.domain = Some(Domain {
            width_x: 3.0 * length,
            width_y: 2.8 * length,
            center_x: 0.0,
            center_y: 0.05 * length,
        });
        scene.punch.material = Some(Material { shear_modulus: 3.0 * modulus, poisson: 0.2 });
        let mut numerics = numerics(Mesh::Exact([20, 18]), Projection::Average, 1e-9);
        numerics.epsilon = 1e-4;
        numerics.ceiling = Some(1.5 * modulus);
        figures(&certified(&scene, &numerics).0.observables, modulus, length)
    };
    let unit = scaled(1.0, 1.0);
    for (modulus, length) in
        [(1e12, 1.0), (1.0, 1e-9), (1e12, 1e-9), (1e-200, 1e150), (1e200, 1e-100)]
    {
        for (i, (a, b)) in unit.iter().zip(scaled(modulus, length)).enumerate() {
            assert!(
                (a - b).abs() <= 1e-12 * a.abs().max(1e-3),
                "figure {i} at G {modulus:e}, ℓ {length:e}: {a:e} and {b:e}"
            );
        }
    }
}

#[test]
fn which_side_is_the_long_one_makes_no_difference() {
    let pressed = Step { approach: Some(0.01), ..Step::default() };
    let loaded = Step { normal_force: Some(0.01), ..Step::default() };
    let turned = |shape: [Shape; 2], step: &Step| {
        shape.map(|shape| {
            let scene = scene(shape, 1.0, 0.3, 0.0, *step);
            let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-9);
            certified(&scene, &numerics).0.observables
        })
    };
    let rectangle = |width_x, width_y| Shape::FlatRectangle { width_x, width_y };
    let [wide, tall] = turned([rectangle(40.0, 1.0), rectangle(1.0, 40.0)], &pressed);
    assert!((wide.load / tall.load - 1.0).abs() < 1e-7, "{} and {}", wide.load, tall.load);
    let ellipsoid = |radius_x, radius_y| Shape::Ellipsoid { radius_x, radius_y };
    let [wide, tall] = turned([ellipsoid(100.0, 1.0), ellipsoid(1.0, 100.0)], &loaded);
    assert!((wide.peak_pressure / tall.peak_pressure - 1.0).abs() < 1e-7);
    // By theory the same peak is known: hertz_ellipse, after Johnson 1985.
    let hertz = hertz_ellipse(2.0 / 0.7, 0.005, 0.5, 0.01).peak_pressure;
    assert!((wide.peak_pressure / hertz - 1.0).abs() < 0.02, "{} for {hertz}", wide.peak_pressure);
}

#[test]
fn a_mirror_and_a_quarter_turn_move_the_solution_and_change_nothing_else() {
    let numerics = numerics(Mesh::Across(14), Projection::Average, 1e-12);
    let base = scene(
        Shape::Ellipsoid { radius_x: 1.0, radius_y: 1.0 },
        1.0,
        0.25,
        0.3,
        Step {
            approach: Some(1.0),
            shift_x: Some(0.12),
            shift_y: Some(0.05),
            tilt_x: Some(0.04),
            tilt_y: Some(0.01),
            twist: Some(0.03),
            ..Step::default()
        },
    );
    let with = |step: Step| {
        let mut scene = base.clone();
        scene.domain = square(3.4);
        scene.loading.steps[0] = step;
        certified(&scene, &numerics).1
    };
    let s = base.loading.steps[0];
    let plain = with(s);
    // Under x ↦ −x, shifts along x and rotations about y and z change sign.
    let minus = |x: Option<f64>| x.map(|x| -x);
    let mirrored = with(Step {
        shift_x: minus(s.shift_x),
        tilt_y: minus(s.tilt_y),
        twist: minus(s.twist),
        ..s
    });
    // A quarter turn about z maps (x, y) ↦ (−y, x).
    let turned = with(Step {
        shift_x: minus(s.shift_y),
        shift_y: s.shift_x,
        tilt_x: minus(s.tilt_y),
        tilt_y: s.tilt_x,
        ..s
    });
    let n = 14;
    let peak = plain.pressure.iter().copied().fold(0.0, f64::max);
    for j in 0..n {
        for i in 0..n {
            let e = j * n + i;
            let m = j * n + (n - 1 - i);
            let t = i * n + (n - 1 - j);
            for (a, b) in [
                (plain.pressure[e], mirrored.pressure[m]),
                (plain.traction_x[e], -mirrored.traction_x[m]),
                (plain.traction_y[e], mirrored.traction_y[m]),
                (plain.pressure[e], turned.pressure[t]),
                (plain.traction_x[e], turned.traction_y[t]),
                (plain.traction_y[e], -turned.traction_x[t]),
            ] {
                assert!((a - b).abs() < 1e-9 * peak, "({i}, {j}): {a} and {b}");
            }
        }
    }
}

#[test]
fn the_ceiling_bounds_the_pressure_and_is_reported() {
    let mut numerics = numerics(Mesh::Across(16), Projection::Average, 1e-9);
    numerics.ceiling = Some(1.0);
    let (outcome, fields) = certified(&shifted_sphere(0.3), &numerics);
    assert!(outcome.observables.ceiling_elements > 10);
    assert!(fields.pressure.iter().all(|p| *p <= 1.0 + 1e-12));
    numerics.ceiling = Some(100.0);
    let (free, _) = certified(&shifted_sphere(0.3), &numerics);
    assert_eq!(free.observables.ceiling_elements, 0);
    numerics.ceiling = None;
    assert_eq!(free, certified(&shifted_sphere(0.3), &numerics).0);
}

#[test]
fn regularisation_softens_and_vanishes_with_epsilon() {
    let load = |epsilon: f64| {
        let mut numerics = numerics(Mesh::Across(16), Projection::Average, 1e-10);
        numerics.epsilon = epsilon;
        certified(&shifted_sphere(0.3), &numerics).0.observables.load
    };
    let limit = load(0.0);
    let drop: Vec<f64> =
        [1e-2, 1e-3, 1e-4].iter().map(|&epsilon| 1.0 - load(epsilon) / limit).collect();
    assert!(drop.iter().all(|d| *d > 0.0), "{drop:?}");
    // To first order the drop is proportional to ε.
    assert!((drop[1] / drop[2] - 10.0).abs() < 1.0, "{drop:?}");
}

#[test]
fn a_punch_that_does_not_reach_leaves_nothing() {
    let mut scene = shifted_sphere(0.3);
    scene.loading.steps[0].approach = Some(-0.5);
    let (outcome, fields) =
        certified(&scene, &numerics(Mesh::Across(8), Projection::Average, 1e-10));
    assert_eq!((outcome.observables.load, outcome.observables.contact_elements), (0.0, 0));
    assert!(fields.gap.iter().all(|gap| *gap > 0.0));
}

#[test]
fn an_omega_that_is_too_small_is_noticed() {
    let mut scene = shifted_sphere(0.0);
    scene.domain = square(1.0);
    let (outcome, _) = certified(&scene, &numerics(Mesh::Across(8), Projection::Average, 1e-10));
    assert_eq!(outcome.observables.edge_elements, 28);
    scene.domain = None;
    assert_eq!(
        certified(&scene, &numerics(Mesh::Across(8), Projection::Average, 1e-10))
            .0
            .observables
            .edge_elements,
        0
    );
}

#[test]
fn running_out_of_iterations_is_an_outcome_with_figures() {
    for (method, limit) in [(Method::Seidel, 5), (Method::Newton, 2)] {
        let numerics = Numerics {
            method,
            max_iterations: limit,
            ..numerics(Mesh::Across(16), Projection::Average, 1e-10)
        };
        let (outcome, _) =
            solve(&shifted_sphere(0.3), &numerics, &Surfaces::new(), &mut Operators::default())
                .unwrap();
        let Status::Failed { reason } = &outcome.status else { panic!("{outcome:?}") };
        assert!(
            reason.starts_with(&format!("not converged in {limit} iterations (residual ")),
            "{reason}"
        );
        assert!(outcome.last().unwrap().certificate.residual > 1e-10);
    }
}

#[test]
fn a_tolerance_below_rounding_stalls_and_says_so() {
    for method in [Method::Seidel, Method::Newton] {
        let numerics =
            Numerics { method, ..numerics(Mesh::Across(12), Projection::Average, 1e-18) };
        let (outcome, _) =
            solve(&shifted_sphere(0.3), &numerics, &Surfaces::new(), &mut Operators::default())
                .unwrap();
        let Status::Failed { reason } = &outcome.status else { panic!("{outcome:?}") };
        assert!(reason.starts_with("stalled after "), "{reason}");
        assert!(outcome.last().unwrap().certificate.residual < 1e-14);
    }
}

/// A solved problem, and all that is needed to certify it anew.
struct Solved {
    problem: Problem,
    operator: Dense,
    diagonal: f64,
    p: Vec<f64>,
    controls: PerDof<Control>,
}

impl Solved {
    fn new() -> Self {
        let scene = shifted_sphere(0.3);
        let mut problem = Problem::new(
            &scene,
            &numerics(Mesh::Across(16), Projection::Average, 1e-10),
            &Surfaces::new(),
        )
        .unwrap();
        let controls = scene.loading.legs()[0].target;
        let units = problem.scale.motions();
        problem.place(&PerDof::from_fn(|dof| match controls[dof] {
            Control::Motion(value) => value / units[dof],
            Control::Force(_) => unreachable!("all of the punch's motion is prescribed"),
        }));
        let table = InfluenceTable::new(&problem.grid, &problem.elasticity, problem.projection);
        let start = vec![0.0; problem.f.len()];
        let iterate = seidel::solve(
            &problem,
            &table,
            start,
            &StopRule { tolerance: 1e-12, max_iterations: 2000, cancellation: None },
        );
        assert_eq!(iterate.stop, Stop::Converged);
        Self {
            operator: Dense::new(&table),
            diagonal: table.largest_diagonal(),
            problem,
            p: iterate.p,
            controls,
        }
    }

    fn certify(&self, p: &[f64], tamper: &dyn Fn(&mut Observables)) -> Certificate {
        let mut displacement = vec![0.0; p.len()];
        self.operator.apply(&mut displacement, p, &mut Scratch::new(&self.operator));
        let w: Vec<f64> = displacement.iter().zip(&self.problem.f).map(|(u, f)| u - f).collect();
        let states = states(&self.problem, p, &w, self.diagonal);
        let mut claimed = observables(&self.problem, p, &w, &states);
        tamper(&mut claimed);
        certify(&self.problem, p, &displacement, self.diagonal, &claimed, &self.controls)
    }
}

#[test]
fn the_certificate_notices_every_kind_of_wrong_answer() {
    let solved = Solved::new();
    let (k, tolerance) = (solved.problem.grid.len(), 1e-10);
    let peak = solved.p[..k].iter().copied().fold(0.0, f64::max);
    let right = solved.certify(&solved.p, &|_| ());
    assert!(right.meets(tolerance), "{right:?}");
    assert!(
        right.penetration < 1e-10 && right.gap_under_pressure < 1e-10 && right.slip_angle < 1e-6,
        "{right:?}"
    );

    // The three elements are the one pressed hardest, one that is in contact and slips, and one
    // outside the contact.
    let inside = (0..k).max_by(|a, b| solved.p[*a].total_cmp(&solved.p[*b])).unwrap();
    let slipping = (0..k)
        .filter(|&e| {
            solved.p[e] > 0.2 * peak
                && solved.p[k + e].hypot(solved.p[2 * k + e]) > 0.999 * 0.3 * solved.p[e]
        })
        .max_by(|a, b| solved.p[*a].total_cmp(&solved.p[*b]))
        .unwrap();
    let outside = (0..k).find(|&e| solved.p[e] == 0.0).unwrap();
    let wrong = |change: &dyn Fn(&mut Vec<f64>)| {
        let mut p = solved.p.clone();
        change(&mut p);
        let certificate = solved.certify(&p, &|_| ());
        assert!(!certificate.meets(tolerance), "{certificate:?}");
        assert!(certificate.residual > 1e-4, "{certificate:?}");
        certificate
    };
    assert!(wrong(&|p| p[outside] = -0.01 * peak).tension > 5e-3);
    assert!(wrong(&|p| p[inside] = 0.0).penetration > 1e-3);
    assert!(wrong(&|p| p[outside] = 0.05 * peak).gap_under_pressure > 1e-3);
    assert!(wrong(&|p| p[k + inside] += 0.5 * peak).cone_violation > 1e-2);
    // The traction of a slipping element is turned by a right angle, still on the cone.
    assert!(
        wrong(&|p| (p[k + slipping], p[2 * k + slipping]) = (-p[2 * k + slipping], p[k + slipping]))
            .slip_angle > 0.5
    );
    // Everything is scaled: the law holds, the equation does not.
    assert!(wrong(&|p| p.iter_mut().for_each(|x| *x *= 1.01)).residual > 1e-3);
    // There is no pressure at all where there should be contact.
    assert_eq!(wrong(&|p| p.fill(0.0)).residual, f64::INFINITY);
    assert_eq!(wrong(&|p| p[inside] = f64::NAN).residual, f64::INFINITY);

    for tamper in [
        (|o: &mut Observables| o.load *= 1.001) as fn(&mut _),
        |o| o.force_x *= 1.001,
        |o| o.force_y += 1e-3 * o.load,
    ] {
        let certificate = solved.certify(&solved.p, &tamper);
        assert!(
            certificate.force_imbalance > 1e-5 && !certificate.meets(tolerance),
            "{certificate:?}"
        );
    }
}

#[test]
fn operators_are_shared_between_jobs_that_differ_in_scale_only() {
    let mut operators = Operators::default();
    let numerics = numerics(Mesh::Across(8), Projection::Average, 1e-8);
    let mut operator = |radius: f64, shear_modulus: f64, mu: f64| {
        let scene = scene(
            Shape::FlatDisk { radius },
            shear_modulus,
            0.3,
            mu,
            Step { approach: Some(1e-3 * radius), ..Step::default() },
        );
        operators.of(&Problem::new(&scene, &numerics, &Surfaces::new()).unwrap())
    };
    let first = operator(1.0, 1.0, 0.3);
    assert!(std::sync::Arc::ptr_eq(&first.table, &operator(0.37, 77e9, 0.9).table));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Any scene ends certified or as a failure that says why. None panics, and none is stored as a
    /// solution that is not one.
    #[test]
    fn every_scene_ends_honestly(
        poisson in 0.0..=0.5f64,
        mu in prop_oneof![Just(0.0), 0.0..2.0f64],
        approach in -0.1..1.0f64,
        shift in prop::array::uniform2(-0.3..0.3f64),
        rotation in prop::array::uniform3(-0.2..0.2f64),
        shape in 0usize..5,
        mesh in prop::array::uniform2(1u32..12),
        epsilon in prop_oneof![Just(0.0), 1e-6..1.0f64],
        midpoint: bool,
    ) {
        let shape = match shape {
            0 => Shape::Sphere { radius: 1.0 },
            1 => Shape::Ellipsoid { radius_x: 1.0, radius_y: 0.3 },
            2 => Shape::FlatRectangle { width_x: 2.0, width_y: 1.0 },
            3 => Shape::FlatDisk { radius: 1.0 },
            _ => Shape::Cone { angle: 0.4 },
        };
        let step = Step {
            approach: Some(approach),
            shift_x: Some(shift[0]),
            shift_y: Some(shift[1]),
            tilt_x: Some(rotation[0]),
            tilt_y: Some(rotation[1]),
            twist: Some(rotation[2]),
            ..Step::default()
        };
        let scene = scene(shape, 1.0, poisson, mu, step);
        let projection = if midpoint { Projection::Midpoint } else { Projection::Average };
        let mut numerics = numerics(Mesh::Exact(mesh), projection, 1e-9);
        numerics.epsilon = epsilon;
        numerics.max_iterations = 3000;
        let (outcome, fields) =
            solve(&scene, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap();
        match outcome.status {
            Status::Certified => {
                let end = outcome.last().unwrap();
                prop_assert!(end.certificate.residual <= 1e-9);
                prop_assert!(fields.pressure.iter().all(|p| *p >= 0.0));
                prop_assert!(end.observables.dissipation >= -1e-9 * end.observables.energy);
                for e in 0..fields.pressure.len() {
                    let t = fields.traction_x[e].hypot(fields.traction_y[e]);
                    prop_assert!(t <= mu * fields.pressure[e] * (1.0 + 1e-9));
                }
            }
            Status::Failed { reason } => prop_assert!(reason.contains("residual"), "{}", reason),
        }
    }
}

#[test]
fn what_doubles_cannot_hold_is_refused_before_it_runs() {
    let numerics = numerics(Mesh::Across(4), Projection::Average, 1e-8);
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut scene = shifted_sphere(0.3);
        change(&mut scene);
        let forecast = contact::forecast(&scene, &numerics, &Surfaces::new()).unwrap_err();
        assert_eq!(Problem::new(&scene, &numerics, &Surfaces::new()).unwrap_err(), forecast);
        assert!(forecast.expected.contains("double precision"), "{forecast}");
        forecast.key
    };
    assert_eq!(
        refused(&|scene| scene.foundation =
            Foundation::half_space(Material { shear_modulus: 1e-310, poisson: 0.3 })),
        "foundation.base.shear_modulus"
    );
    assert_eq!(
        refused(
            &|scene| scene.punch.material = Some(Material { shear_modulus: 1e-310, poisson: 0.3 })
        ),
        "foundation.base.shear_modulus"
    );
    assert_eq!(refused(&|scene| scene.domain = square(1e-320)), "domain.width_x");
}
