//! Stresses below the surface of scenes at the limits: they are numbers, and their residual is
//! small.

use super::*;

/// Solves a scene and returns what is below its surface.
fn below(name: &str, scene: &Scene, mesh: Mesh) -> Interior {
    let numerics = numerics(mesh, Projection::Average, 1e-8);
    let solved = solve(scene, &numerics, &Surfaces::new(), &mut Operators::default());
    let (outcome, _) = solved.unwrap_or_else(|error| panic!("{name}: {error}"));
    assert_eq!(outcome.status, Status::Certified, "{name}");
    outcome.further.interior.unwrap_or_else(|| panic!("{name}: nothing below"))
}

fn sphere(radius: f64, shear_modulus: f64, poisson: f64, mu: f64) -> Scene {
    let press =
        Step { approach: Some(0.01 * radius), shift_x: Some(0.002 * radius), ..Step::default() };
    let mut scene = scene(Shape::Sphere { radius }, shear_modulus, poisson, mu, press);
    scene.interior = Some(InteriorQuestion {
        maximum: true,
        depths: vec![0.0, 1e-12 * radius, 0.05 * radius],
        points: vec![[0.0, 0.0, 1e-9 * radius], [1e6 * radius, 0.0, 0.0]],
    });
    scene
}

#[test]
fn stresses_at_the_limits_are_numbers() {
    let layer = |shear_modulus: f64, poisson: f64, thickness: f64| Layer {
        shear_modulus,
        poisson,
        thickness,
    };
    let coated = |layers: Vec<Layer>| {
        let mut scene = sphere(1.0, 1.0, 0.3, 0.3);
        scene.foundation.layers = layers;
        scene
    };
    let mut rigid = coated(vec![layer(1.0, 0.5, 0.06)]);
    rigid.foundation.base = Base::Rigid;
    let mut slender = sphere(1.0, 1.0, 0.3, 0.3);
    slender.punch.shape = Shape::Ellipsoid { radius_x: 1.0, radius_y: 1e6 };
    let mut faults = Vec::new();
    for (name, scene, mesh) in [
        ("incompressible", sphere(1.0, 1.0, 0.5, 0.3), Mesh::Across(16)),
        ("slippery", sphere(1.0, 1.0, 0.0, 1e-12), Mesh::Across(16)),
        ("rough", sphere(1.0, 1.0, 0.3, 1.0), Mesh::Across(16)),
        ("soft", sphere(1.0, 1e-300, 0.3, 0.3), Mesh::Across(16)),
        ("stiff", sphere(1.0, 1e300, 0.3, 0.0), Mesh::Across(16)),
        ("tiny", sphere(1e-100, 1.0, 0.3, 0.3), Mesh::Across(16)),
        ("huge", sphere(1e100, 1.0, 0.3, 0.3), Mesh::Across(16)),
        ("slender", slender, Mesh::Across(16)),
        ("one element", sphere(1.0, 1.0, 0.3, 0.3), Mesh::Across(1)),
        ("a row of elements", sphere(1.0, 1.0, 0.3, 0.3), Mesh::Exact([1, 9])),
        ("stiff coating", coated(vec![layer(1e6, 0.3, 0.05)]), Mesh::Across(16)),
        ("soft coating", coated(vec![layer(1e-3, 0.5, 0.05)]), Mesh::Across(16)),
        ("thin coating", coated(vec![layer(10.0, 0.2, 1e-6)]), Mesh::Across(16)),
        ("thick coating", coated(vec![layer(10.0, 0.2, 1e6)]), Mesh::Across(16)),
        ("equal layers", coated(vec![layer(1.0, 0.3, 0.05); 3]), Mesh::Across(16)),
        ("rigid base", rigid, Mesh::Across(16)),
        (
            "many layers",
            coated((0..6).map(|i| layer(1.0 + f64::from(i % 3), 0.3, 0.01)).collect()),
            Mesh::Across(16),
        ),
    ] {
        let answer = below(name, &scene, mesh);
        let largest = answer.von_mises.unwrap().overall().stress;
        assert!(largest.is_finite() && largest > 0.0, "{name}: {answer:?}");
        let numbers = answer.points.iter().flat_map(|point| point.stress.components());
        assert!(numbers.into_iter().all(f64::is_finite), "{name}: {:?}", answer.points);
        let planes =
            answer.planes.iter().flat_map(|plane| [plane.von_mises.stress, plane.tresca.stress]);
        assert!(planes.into_iter().all(f64::is_finite), "{name}: {:?}", answer.planes);
        // A coating 1e6 times as stiff spreads the load over a hundred thicknesses.
        let allowed = if name == "stiff coating" { 1e-3 } else { 1e-7 };
        let residual = answer.residual.unwrap();
        if residual >= allowed {
            faults.push(format!("{name}: a residual of {residual:e}"));
        }
    }
    assert!(faults.is_empty(), "{faults:?}");
}

/// Prints what planes, points and searches take, beside one application of the operator.
#[test]
#[ignore = "it measures times"]
fn times_of_planes_points_and_searches() {
    for layered in [false, true] {
        for n in [64_u32, 128, 256] {
            let mut foundation = half_space(0.3);
            if layered {
                foundation.layers =
                    vec![Layer { shear_modulus: 3.0, poisson: 0.3, thickness: 0.3 }];
            }
            let fields = spread(n, [1.2; 2], [1.0, 0.3, 0.0], hertz([1.0; 2]));
            let below = Subsurface::new(&foundation, &fields);
            let timed = |work: &dyn Fn()| {
                let start = std::time::Instant::now();
                work();
                start.elapsed().as_secs_f64()
            };
            let plane = timed(&|| assert!(below.plane(0.2).is_some()));
            let point = timed(&|| assert!(below.at([0.1, 0.0, 0.2]).is_some()));
            let question = InteriorQuestion { maximum: true, ..InteriorQuestion::default() };
            let search = timed(&|| {
                let cancellation = Cancellation::default();
                assert!(examine(&foundation, &question, &fields, &cancellation).is_some());
            });
            println!(
                "layers {layered} {n}: plane {plane:.4} point {point:.5} search {search:.3} s"
            );
        }
    }
}
