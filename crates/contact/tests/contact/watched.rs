//! A path that is watched: its increments are those of the outcome, each has a discrete friction
//! problem that its solution solves, and it ends when nobody wants more.

use std::ops::ControlFlow;

use crate::common::*;
use contact::model::*;
use contact::punch::Surfaces;
use contact::{Cancellation, FrictionProblem, Operators, solve, solve_watched};

/// A sphere that is pressed and then pulled in two increments, so that a part of it slips.
fn pulled(mu: f64) -> Scene {
    let press = Step { approach: Some(1.0), ..Step::default() };
    let pull = Step { shift_x: Some(0.2), shift_y: Some(0.05), increments: 2, ..press };
    let scene = scene(Shape::Sphere { radius: 1.0 }, 2.0, 0.3, mu, press);
    Scene { loading: Loading::path(vec![press, pull]), ..scene }
}

fn problems(scene: &Scene, numerics: &Numerics) -> Vec<FrictionProblem> {
    let mut problems = Vec::new();
    let mut watch = |increment: &contact::SolvedIncrement<'_>| {
        problems.push(increment.friction_problem().unwrap());
        ControlFlow::Continue(())
    };
    let surfaces = Surfaces::new();
    solve_watched(scene, numerics, &surfaces, &mut Operators::default(), &mut watch).unwrap();
    problems
}

#[test]
fn every_increment_solves_its_discrete_friction_problem() {
    let mesh = Mesh::Exact([10, 12]);
    for (projection, epsilon) in
        [(Projection::Average, 0.0), (Projection::Midpoint, 0.0), (Projection::Average, 1e-2)]
    {
        let numerics = Numerics { epsilon, ..numerics(mesh, projection, 1e-12) };
        let found = problems(&pulled(0.3), &numerics);
        assert_eq!(found.len(), 3);
        for problem in &found {
            let FrictionProblem { elements, compliance, free, mu, forces, displacements } = problem;
            let rows = 3 * elements.len();
            assert_eq!((elements.len(), compliance.len(), *mu), (120, rows * rows, 0.3));
            let size = |vector: &[f64]| vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let (force, length) = (size(forces), size(displacements));
            for row in 0..rows {
                let entries = &compliance[row * rows..][..rows];
                let sum: f64 = entries.iter().zip(forces).map(|(w, r)| w * r).sum();
                assert!((sum + free[row] - displacements[row]).abs() < 1e-13 * length);
                for column in 0..row {
                    let other = compliance[column * rows + row];
                    assert!((entries[column] - other).abs() < 1e-13 * entries[row]);
                }
            }
            let mut slipping = 0;
            for (r, u) in forces.chunks(3).zip(displacements.chunks(3)) {
                assert!(r[0] >= 0.0 && u[0] > -1e-10 * length, "{r:?} {u:?}");
                assert!(r[0] * u[0] < 1e-10 * force * length, "{r:?} {u:?}");
                let (traction, slip) = (r[1].hypot(r[2]), u[1].hypot(u[2]));
                assert!(traction <= mu * r[0] + 1e-10 * force);
                if r[0] > 0.0 && slip > 1e-6 * length {
                    slipping += 1;
                    let against = r[1] * u[1] + r[2] * u[2];
                    assert!((against + mu * r[0] * slip).abs() < 1e-9 * force * length);
                }
            }
            assert!(slipping > 0);
        }
    }
}

#[test]
fn a_problem_has_the_fields_of_its_increment() {
    let numerics = numerics(Mesh::Exact([10, 12]), Projection::Average, 1e-12);
    let scene = pulled(0.3);
    let mut number = 0;
    let mut watch = |increment: &contact::SolvedIncrement<'_>| {
        number += 1;
        assert!(increment.number == number && increment.is_certified);
        let problem = increment.friction_problem().unwrap();
        let fields = increment.fields;
        let area = fields.element[0] * fields.element[1];
        let most = |field: &[f64]| field.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let pairs = [
            [&fields.pressure, &fields.gap],
            [&fields.traction_x, &fields.slip_x],
            [&fields.traction_y, &fields.slip_y],
        ];
        for (c, [tractions, moved]) in pairs.into_iter().enumerate() {
            for (place, &e) in problem.elements.iter().enumerate() {
                let (force, displacement) =
                    (problem.forces[3 * place + c], problem.displacements[3 * place + c]);
                assert!(
                    (force - tractions[e] * area).abs() <= 1e-12 * most(&fields.pressure) * area
                );
                assert!((displacement - moved[e]).abs() <= 1e-12 * most(&fields.gap));
            }
        }
        ControlFlow::Continue(())
    };
    let surfaces = Surfaces::new();
    let watched =
        solve_watched(&scene, &numerics, &surfaces, &mut Operators::default(), &mut watch);
    assert_eq!(number, 3);
    let unwatched = solve(&scene, &numerics, &surfaces, &mut Operators::default());
    assert_eq!(watched, unwatched);
}

#[test]
fn a_path_ends_when_nobody_wants_more_of_it() {
    let numerics = numerics(Mesh::Exact([8, 8]), Projection::Average, 1e-8);
    let cancellation = Cancellation::default();
    let run = |scene: &Scene, wanted: u64, by_request: bool| {
        let mut seen = 0;
        let mut watch = |increment: &contact::SolvedIncrement<'_>| {
            seen = increment.number;
            if seen < wanted {
                ControlFlow::Continue(())
            } else if by_request {
                cancellation.request();
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        };
        let mut operators = Operators::cancelled_by(&cancellation);
        let solved =
            solve_watched(scene, &numerics, &Surfaces::new(), &mut operators, &mut watch).unwrap();
        (seen, solved.0)
    };
    for by_request in [false, true] {
        let (seen, outcome) = run(&pulled(0.3), 2, by_request);
        assert_eq!(seen, 2);
        assert!(matches!(outcome.status, Status::Failed { .. }), "{:?}", outcome.status);
        assert!(outcome.estimate.is_none());
    }
    // A solver that is asked beforehand does nothing to speak of, whatever its method.
    for method in [Method::Newton, Method::Seidel] {
        let numerics = Numerics { method, ..numerics.clone() };
        let mut operators = Operators::cancelled_by(&cancellation);
        let (outcome, _) =
            solve(&pulled(0.3), &numerics, &Surfaces::new(), &mut operators).unwrap();
        assert!(matches!(outcome.status, Status::Failed { .. }));
        assert!(outcome.steps[0].work.operator_applications <= 2, "{:?}", outcome.steps[0].work);
    }
}

#[test]
fn what_is_no_problem_of_friction_says_why() {
    let capped =
        Numerics { ceiling: Some(0.5), ..numerics(Mesh::Exact([8, 8]), Projection::Average, 1e-8) };
    let mut said = Vec::new();
    let mut watch = |increment: &contact::SolvedIncrement<'_>| {
        said.push(increment.friction_problem().map(|_| ()));
        ControlFlow::Continue(())
    };
    let surfaces = Surfaces::new();
    solve_watched(&pulled(0.3), &capped, &surfaces, &mut Operators::default(), &mut watch).unwrap();
    let error = said[0].clone().unwrap_err().to_string();
    assert!(error.contains("the ceiling on the pressure is active at"), "{error}");
}
