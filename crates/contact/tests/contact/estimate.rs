//! The estimates of the discretisation error are compared with the true errors.

use std::f64::consts::PI;

use crate::common::*;
use contact::assess::norms::{distance, norm};
use contact::assess::{Errors, closed_form};
use contact::model::*;
use contact::punch::Surfaces;
use contact::theory::flat_disk;
use contact::{Operators, solve};

/// Returns a scene of two like spheres with ν = 0, for which Cattaneo's and Mindlin's theory is
/// exact.
fn like_spheres(steps: Vec<Step>) -> Scene {
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 2.0, 0.0, 0.4, Step::default());
    scene.punch.material = Some(Material { shear_modulus: 2.0, poisson: 0.0 });
    scene.loading = Loading::path(steps);
    scene
}

fn with_closed_forms() -> Vec<(&'static str, Scene)> {
    let (sphere, disk) = (Shape::Sphere { radius: 1.0 }, Shape::FlatDisk { radius: 1.0 });
    let pressed = Step { approach: Some(1.0), ..Step::default() };
    let mut off = scene(sphere.clone(), 1.0, 0.3, 0.0, pressed);
    off.domain = Some(Domain { width_x: 3.3, width_y: 2.9, center_x: 0.21, center_y: -0.13 });
    let mut disk_off = scene(disk.clone(), 1.0, 0.3, 0.0, pressed);
    disk_off.domain = Some(Domain { width_x: 2.4, width_y: 2.2, center_x: 0.05, center_y: -0.03 });
    vec![
        ("Hertz sphere", scene(sphere.clone(), 1.0, 0.3, 0.0, pressed)),
        (
            "Hertz sphere by load",
            scene(
                sphere.clone(),
                1.0,
                0.3,
                0.0,
                Step { normal_force: Some(3.0), ..Step::default() },
            ),
        ),
        ("Hertz sphere off the grid's middle", off),
        (
            "Hertz ellipsoid",
            scene(Shape::Ellipsoid { radius_x: 1.0, radius_y: 0.2 }, 1.0, 0.3, 0.0, pressed),
        ),
        ("cone", scene(Shape::Cone { angle: 0.3 }, 1.0, 0.3, 0.0, pressed)),
        ("flat disk", scene(disk.clone(), 1.0, 0.3, 0.0, pressed)),
        ("flat disk off the grid's middle", disk_off),
        (
            "flat disk tilted",
            scene(disk.clone(), 1.0, 0.3, 0.0, Step { tilt_x: Some(0.2), ..pressed }),
        ),
        (
            "flat disk under an eccentric load",
            scene(
                disk.clone(),
                1.0,
                0.3,
                0.0,
                Step { normal_force: Some(1.0), moment_y: Some(0.1), ..Step::default() },
            ),
        ),
        (
            "flat disk shifted",
            scene(disk.clone(), 1.0, 0.5, 5.0, Step { shift_x: Some(0.3), ..pressed }),
        ),
        ("flat disk twisted", scene(disk, 1.0, 0.5, 5.0, Step { twist: Some(0.3), ..pressed })),
        (
            "Cattaneo and Mindlin by shift",
            like_spheres(vec![Step { shift_x: Some(0.2), ..pressed }]),
        ),
        (
            "Cattaneo and Mindlin by shift in steps",
            like_spheres(vec![
                pressed,
                Step { shift_x: Some(0.1), shift_y: Some(0.05), increments: 3, ..Step::default() },
            ]),
        ),
        (
            "Cattaneo and Mindlin by force",
            like_spheres(vec![
                Step { normal_force: Some(2.5), ..Step::default() },
                Step { force_x: Some(0.7), ..Step::default() },
            ]),
        ),
        ("like ellipsoids, partial slip", {
            let mut scene =
                like_spheres(vec![pressed, Step { shift_y: Some(0.15), ..Step::default() }]);
            scene.punch.shape = Shape::Ellipsoid { radius_x: 1.0, radius_y: 0.4 };
            scene
        }),
    ]
}

const MESHES: [u32; 11] = [12, 13, 15, 19, 24, 31, 32, 45, 64, 77, 96];

/// A layered or frictional scene with its load (over E* of the surface alone) and, where the source
/// has them, its areas in contact and sticking. Lengths are in units of the contact radius, and G
/// of the surface is 1.
struct Tabulated {
    name: String,
    scene: Scene,
    load: Option<f64>,
    contact_area: Option<f64>,
    stick_area: Option<f64>,
}

fn with_tables() -> Vec<Tabulated> {
    let rows = |file: &str| -> Vec<Vec<String>> {
        reference(file)
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(str::to_owned).collect())
            .collect()
    };
    let number = |row: &[String], column: usize| row[column].parse::<f64>().unwrap();
    let mut scenes = Vec::new();
    for row in rows("sphere_one_step.csv") {
        let [poisson, mu, stick, chi, phi] = [0, 1, 2, 3, 4].map(|column| number(&row, column));
        let scene = scene(
            Shape::Sphere { radius: 1.0 },
            1.0,
            poisson,
            mu,
            Step { approach: Some(chi), ..Step::default() },
        );
        scenes.push(Tabulated {
            name: format!("sphere in one step, ν {poisson}, μ {mu}"),
            scene,
            load: Some(phi * 8.0 / (3.0 * (1.0 - poisson))),
            contact_area: Some(PI),
            stick_area: Some(PI * stick * stick),
        });
    }
    for row in rows("spence_incremental.csv")
        .iter()
        .filter(|row| row[5].parse::<f64>().is_ok_and(f64::is_finite))
        .step_by(13)
    {
        let [poisson, mu, stick, ratio] = [0, 1, 4, 5].map(|column| number(row, column));
        let scene = scene(
            Shape::FlatDisk { radius: 1.0 },
            1.0,
            poisson,
            mu,
            Step { approach: Some(1.0), ..Step::default() },
        );
        let load = flat_disk(2.0 / (1.0 - poisson), 1.0, 1.0).load * ratio;
        scenes.push(Tabulated {
            name: format!("flat disk with friction, ν {poisson}, μ {mu}"),
            scene,
            load: Some(load),
            contact_area: None,
            stick_area: Some(PI * stick * stick),
        });
    }
    for row in rows("rigid_base_layer.csv").iter().filter(|row| row[2] == "bonded").step_by(9) {
        let [poisson, size, kappa, chi, phi] = [0, 1, 3, 4, 5].map(|column| number(row, column));
        let layers = vec![Layer { shear_modulus: 1.0, poisson, thickness: 1.0 / size }];
        for (shape, approach, load, area) in [
            (Shape::Sphere { radius: 1.0 }, chi, phi * 8.0 / (3.0 * (1.0 - poisson)), Some(PI)),
            (Shape::FlatDisk { radius: 1.0 }, 1.0, kappa * 4.0 / (1.0 - poisson), None),
        ] {
            let name = format!(
                "{} on a layer, ν {poisson}, a/h {size}",
                if area.is_some() { "sphere" } else { "flat disk" }
            );
            let mut scene = scene(
                shape,
                1.0,
                poisson,
                0.0,
                Step { approach: Some(approach), ..Step::default() },
            );
            scene.foundation = Foundation { layers: layers.clone(), base: Base::Rigid };
            // Ω follows Hertz's approach without the layer.
            scene.domain = if area.is_some() { square(3.0) } else { None };
            scenes.push(Tabulated {
                name,
                scene,
                load: Some(load),
                contact_area: area,
                stick_area: None,
            });
        }
    }
    scenes
}

/// An estimate and the true error.
struct Case {
    scene: String,
    mesh: u32,
    figure: &'static str,
    estimate: f64,
    error: f64,
}

/// A figure of a solution that its table knows, and the unit of its error.
struct Known {
    figure: &'static str,
    estimate: Option<f64>,
    found: f64,
    exact: Option<f64>,
    unit: Option<f64>,
}

fn solved(scene: &Scene, numerics: &Numerics) -> (Outcome, Fields) {
    let (outcome, fields) = solve(scene, numerics, &Surfaces::new(), &mut Operators::default())
        .expect("a scene with a meaning");
    assert_eq!(outcome.status, Status::Certified);
    (outcome, fields)
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, scene) in with_closed_forms() {
        let exact = closed_form(&scene).expect(name);
        for mesh in MESHES {
            let (outcome, fields) =
                solved(&scene, &numerics(Mesh::Across(mesh), Projection::Average, 1e-8));
            let errors =
                Errors::against_closed_form(outcome.last().unwrap(), &fields, &exact).unwrap();
            let estimate = outcome.estimate.expect(name);
            for ((figure, estimate), (_, error)) in
                estimate.figures.named().into_iter().zip(errors.figures.named())
            {
                // A figure that is 0 in truth is wrong by all of its value.
                let vanishes = |figure: &str| {
                    matches!(figure, "tangential_force" | "shift" | "moment" | "rotation")
                };
                let error =
                    error.or_else(|| (estimate.is_some() && vanishes(figure)).then_some(1.0));
                assert_eq!(
                    estimate.is_some(),
                    error.is_some(),
                    "{name}, {mesh}, {figure}: {estimate:?} for {error:?}"
                );
                if let (Some(estimate), Some(error)) = (estimate, error) {
                    cases.push(Case { scene: name.to_owned(), mesh, figure, estimate, error });
                }
            }
        }
    }
    for Tabulated { name, scene, load, contact_area: area, stick_area: stick } in with_tables() {
        for mesh in [12, 15, 24, 45, 64] {
            let (outcome, _) =
                solved(&scene, &numerics(Mesh::Across(mesh), Projection::Average, 1e-8));
            let (o, estimate) =
                (outcome.last().unwrap().observables, outcome.estimate.expect(&name).figures);
            let area_unit = area.unwrap_or(o.contact_area);
            for Known { figure, estimate, found, exact, unit } in [
                Known {
                    figure: "load",
                    estimate: estimate.load,
                    found: o.load,
                    exact: load,
                    unit: load,
                },
                Known {
                    figure: "contact_area",
                    estimate: estimate.contact_area,
                    found: o.contact_area,
                    exact: area,
                    unit: area,
                },
                Known {
                    figure: "stick_area",
                    estimate: estimate.stick_area,
                    found: o.stick_area,
                    exact: stick,
                    unit: Some(area_unit),
                },
            ] {
                if let (Some(exact), Some(unit)) = (exact, unit) {
                    let error = (found - exact).abs() / unit;
                    cases.push(Case {
                        scene: name.clone(),
                        mesh,
                        figure,
                        estimate: estimate.expect(figure),
                        error,
                    });
                }
            }
        }
    }
    cases
}

/// The summary of a table of cases: their number, the per cent that are covered, and the median and
/// the ninth decile of estimate over error.
#[derive(Clone, Copy, Debug)]
struct Summary {
    count: usize,
    covered: f64,
    median: f64,
    decile: f64,
}

fn summary(cases: &[&Case]) -> Summary {
    // An area that is exact has no ratio.
    let mut ratios: Vec<f64> = cases
        .iter()
        .filter(|case| case.error > 1e-9)
        .map(|case| case.estimate / case.error)
        .collect();
    ratios.sort_by(f64::total_cmp);
    let quantile = |share: f64| {
        ratios.get((share * ratios.len() as f64) as usize).copied().unwrap_or(f64::NAN)
    };
    let covered = cases
        .iter()
        .filter(|case| case.estimate >= case.error * (1.0 - 1e-9) || case.error <= 1e-9)
        .count();
    Summary {
        count: cases.len(),
        covered: 100.0 * covered as f64 / cases.len() as f64,
        median: quantile(0.5),
        decile: quantile(0.9),
    }
}

/// In nearly all cases the estimate is above the true error, and not far above it.
#[test]
fn estimates_cover_the_true_errors() {
    let cases = cases();
    for case in cases.iter().filter(|case| case.estimate < case.error) {
        println!(
            "missed: {}, {}: {} {:.2e} for {:.2e}",
            case.scene, case.mesh, case.figure, case.estimate, case.error
        );
    }
    let mut scenes: Vec<&str> = cases.iter().map(|case| case.scene.as_str()).collect();
    scenes.dedup();
    println!("{:45} {:>6} {:>8} {:>7} {:>7}", "", "cases", "covered", "median", "9/10");
    let print = |name: &str, Summary { count, covered, median, decile }: Summary| {
        println!("{name:45} {count:6} {covered:7.1}% {median:7.1} {decile:7.1}");
    };
    for scene in &scenes {
        print(
            scene,
            summary(&cases.iter().filter(|case| case.scene == *scene).collect::<Vec<_>>()),
        );
    }
    for (figure, _) in FigureErrors::default().named() {
        let of_figure =
            summary(&cases.iter().filter(|case| case.figure == figure).collect::<Vec<_>>());
        print(figure, of_figure);
        let Summary { count, covered, median, .. } = of_figure;
        assert!(count >= 11, "{figure}: {count} cases");
        assert!(covered >= 90.0 && median < 10.0, "{figure}: {covered} % covered, median {median}");
    }
    let all = summary(&cases.iter().collect::<Vec<_>>());
    print("all", all);
    assert!(scenes.len() >= 20 && all.covered >= 95.0 && all.median < 5.0, "{all:?}");
}

/// The solver's part of the estimate covers the difference between a solution at a loose tolerance
/// and one at a tight tolerance.
#[test]
fn the_solvers_part_covers_what_is_left_of_its_residual() {
    let mut ratios = Vec::new();
    for (name, scene) in with_closed_forms() {
        for mesh in [12, 32, 64] {
            let solved_to = |tolerance: f64, method: Method| {
                solved(
                    &scene,
                    &Numerics {
                        method,
                        ..numerics(Mesh::Across(mesh), Projection::Average, tolerance)
                    },
                )
            };
            let (_, exact) = solved_to(1e-11, Method::Newton);
            for (tolerance, method) in
                [(1e-2, Method::Newton), (1e-4, Method::Newton), (1e-3, Method::Seidel)]
            {
                if method == Method::Seidel && mesh > 32 {
                    continue;
                }
                let (outcome, fields) = solved_to(tolerance, method);
                let (off, size) = (distance(&fields, &exact).unwrap(), norm(&exact).unwrap());
                let error = off.pressure.hypot(off.traction) / size.pressure.hypot(size.traction);
                let estimate = outcome.estimate.expect(name).solver;
                if error > 1e-9 {
                    if estimate < error {
                        println!(
                            "missed: {name}, {mesh}, {tolerance:e} {method:?}: \
                             {estimate:.2e} for {error:.2e}"
                        );
                    }
                    ratios.push(estimate / error);
                }
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    let covered = ratios.iter().filter(|ratio| **ratio >= 1.0).count();
    println!(
        "{covered} of {}, median {:.1}, least {:.2}",
        ratios.len(),
        ratios[ratios.len() / 2],
        ratios[0]
    );
    assert!(covered * 100 >= ratios.len() * 90 && ratios[ratios.len() / 2] < 10.0);
}

/// Estimates come with every method, at the end of every path, and from the same coarser grid.
#[test]
fn estimates_do_not_depend_on_the_method() {
    for (name, scene) in with_closed_forms() {
        let [seidel, newton] = [Method::Seidel, Method::Newton].map(|method| {
            let (outcome, _) = solved(
                &scene,
                &Numerics { method, ..numerics(Mesh::Across(17), Projection::Average, 1e-9) },
            );
            assert!(
                outcome.levels.iter().any(|level| level.elements[0] == 9),
                "{name}: {:?}",
                outcome.levels
            );
            outcome.estimate.expect(name).figures.named()
        });
        for ((figure, one), (_, other)) in seidel.into_iter().zip(newton) {
            let off = one.zip(other).map(|(one, other)| (one - other).abs());
            assert!(
                one.is_some() == other.is_some() && off.is_none_or(|off| off < 1e-5),
                "{name}, {figure}: {one:?} {other:?}"
            );
        }
    }
}

#[test]
fn without_a_coarser_grid_or_a_contact_there_is_no_estimate() {
    let pressed = |approach: f64| {
        scene(
            Shape::Sphere { radius: 1.0 },
            1.0,
            0.3,
            0.3,
            Step { approach: Some(approach), ..Step::default() },
        )
    };
    let estimate = |scene: &Scene, mesh: Mesh| {
        solved(scene, &numerics(mesh, Projection::Average, 1e-8)).0.estimate
    };
    assert_eq!(estimate(&pressed(1.0), Mesh::Exact([3, 40])), None);
    assert!(estimate(&pressed(1.0), Mesh::Exact([4, 40])).is_some());
    assert_eq!(estimate(&pressed(-1.0), Mesh::Across(12)), None);
    // The force is more than friction carries.
    let mut sliding = pressed(1.0);
    sliding.loading.steps[0].force_x = Some(100.0);
    let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-8);
    let (outcome, _) =
        solve(&sliding, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap();
    assert!(outcome.status != Status::Certified && outcome.estimate.is_none());
}

/// A large ε makes the pressure at the edge of a sole square integrable, and a ceiling makes it
/// bounded; a small ε does not, as far as a grid can see.
#[test]
fn what_is_unbounded_has_no_estimate() {
    let disk = scene(
        Shape::FlatDisk { radius: 1.0 },
        1.0,
        0.3,
        0.0,
        Step { approach: Some(1.0), ..Step::default() },
    );
    let figures = |epsilon: f64, ceiling: Option<f64>| {
        let numerics =
            Numerics { epsilon, ceiling, ..numerics(Mesh::Across(32), Projection::Average, 1e-8) };
        solved(&disk, &numerics).0.estimate.unwrap().figures
    };
    for (epsilon, ceiling, is_bounded) in
        [(0.0, None, false), (1e-6, None, false), (0.3, None, true), (0.0, Some(1.0), true)]
    {
        let estimate = figures(epsilon, ceiling);
        assert!(estimate.load.is_some_and(|load| load < 0.1), "{epsilon}: {estimate:?}");
        assert_eq!(
            [estimate.peak_pressure, estimate.pressure].map(|figure| figure.is_some()),
            [is_bounded; 2],
            "{epsilon}: {estimate:?}"
        );
    }
}
