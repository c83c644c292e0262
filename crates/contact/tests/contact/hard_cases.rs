//! Scenes at the limits end certified, or say in words what is difficult about them.
//! `sweeps/hard-cases.toml` has such a list for the program. Here is the table; `limits` compares
//! known answers, and `random` looks for more cases.

mod limits;
mod random;

use std::sync::Arc;

use crate::common::{difference, numerics, scene, square};
use contact::model::*;
use contact::problem::Problem;
use contact::punch::{Surface, Surfaces};
use contact::{Operators, solve};

/// The end that a case comes to.
#[derive(Clone, Copy)]
enum End {
    /// A solution with a good certificate.
    Certified,
    /// No solution, for a reason with these words.
    Failed(&'static str),
    /// No problem at all, for a reason with these words.
    Refused(&'static str),
}
use End::{Certified, Failed, Refused};

struct Case {
    name: String,
    scene: Scene,
    numerics: Numerics,
    surfaces: Surfaces,
    end: End,
}

/// Returns a scene of a sphere of radius 1 on a half-space with G = 1, ν = 0.3, μ = 0.3, pressed by
/// 0.01; its contact radius is 0.1.
fn sphere() -> Scene {
    scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.3, 0.3, pressed(0.01))
}

fn pressed(approach: f64) -> Step {
    Step { approach: Some(approach), ..Step::default() }
}

fn loaded(force: f64) -> Step {
    Step { normal_force: Some(force), ..Step::default() }
}

fn pulled(force: f64) -> Step {
    Step { force_x: Some(force), ..Step::default() }
}

fn settings() -> Numerics {
    Numerics { method: Method::Auto, ..numerics(Mesh::Across(16), Projection::Average, 1e-8) }
}

fn half_space(shear_modulus: f64, poisson: f64) -> Foundation {
    Foundation::half_space(Material { shear_modulus, poisson })
}

fn layer(shear_modulus: f64, thickness: f64) -> Layer {
    Layer { shear_modulus, poisson: 0.3, thickness }
}

fn rectangle(width_x: f64, width_y: f64) -> Shape {
    Shape::FlatRectangle { width_x, width_y }
}

/// Builds a case of the sphere with a change.
fn case(name: impl Into<String>, end: End, change: impl FnOnce(&mut Scene, &mut Numerics)) -> Case {
    let (mut scene, mut numerics) = (sphere(), settings());
    change(&mut scene, &mut numerics);
    Case { name: name.into(), scene, numerics, surfaces: Surfaces::new(), end }
}

fn stiffness() -> Vec<Case> {
    let mut all = Vec::new();
    for g in [1e-12, 1e12] {
        for (thickness, name) in [(0.1, "layer"), (1e-3, "thin layer")] {
            all.push(case(
                format!("{name} {g:e} times as stiff as its base"),
                Certified,
                |s, _| {
                    s.foundation.layers = vec![layer(g, thickness)];
                },
            ));
            all.push(case(
                format!("{name} {g:e} times as stiff as its base, by load"),
                Certified,
                |s, _| {
                    s.foundation.layers = vec![layer(g, thickness)];
                    s.loading.steps = vec![loaded(g.min(1.0) * 1e-3)];
                },
            ));
        }
        all.push(case(
            format!("punch {g:e} times as stiff as the foundation"),
            Certified,
            |s, _| {
                s.punch.material = Some(Material { shear_modulus: g, poisson: 0.3 });
            },
        ));
    }
    for thickness in [1e-6, 1e6] {
        for g in [0.1, 10.0] {
            all.push(case(
                format!("layer {g} times as stiff, {thickness:e} elements thick"),
                Certified,
                |s, _| {
                    s.domain = square(0.32);
                    s.foundation.layers = vec![layer(g, 0.02 * thickness)];
                },
            ));
        }
        for poisson in [0.3, 0.5] {
            all.push(case(
                format!("layer with ν = {poisson} on a rigid base, {thickness:e} elements thick"),
                Certified,
                |s, _| {
                    s.domain = square(0.32);
                    s.foundation = Foundation {
                        layers: vec![Layer { poisson, ..layer(1.0, 0.02 * thickness) }],
                        base: Base::Rigid,
                    };
                },
            ));
        }
    }
    for thickness in [1e-6, 1e-2] {
        let end = Refused("double precision knows no less");
        all.push(case(
            format!(
                "layer with ν = 0.5 on a rigid base, {thickness:e} elements thick, at midpoints"
            ),
            end,
            |s, n| {
                s.domain = square(0.32);
                n.projection = Projection::Midpoint;
                s.foundation = Foundation {
                    layers: vec![Layer { poisson: 0.5, ..layer(1.0, 0.02 * thickness) }],
                    base: Base::Rigid,
                };
            },
        ));
    }
    for g in [1e-300, 1e-16, 1e16, 1e300] {
        all.push(case(
            format!("layer {g:e} times as stiff as its base"),
            Refused("double precision loses the softer"),
            |s, _| {
                s.foundation.layers = vec![layer(g, 0.1)];
            },
        ));
    }
    for poisson in [0.0, 0.499_999_9, 0.5] {
        all.push(case(format!("ν = {poisson}"), Certified, |s, _| {
            s.foundation = half_space(1.0, poisson)
        }));
    }
    for (modulus, end) in [
        (1e-308, Refused("range of double precision")),
        (1e-300, Certified),
        (1e-150, Certified),
        (1e150, Certified),
        (1e300, Certified),
        (1e308, Refused("range of double precision")),
    ] {
        all.push(case(format!("G = {modulus:e} Pa"), end, |s, _| {
            s.foundation = half_space(modulus, 0.3)
        }));
        all.push(case(format!("G = {modulus:e} Pa, by load"), end, |s, _| {
            s.foundation = half_space(modulus, 0.3);
            s.loading.steps = vec![loaded(modulus * 0.003)];
        }));
    }
    for (size, end) in [
        (1e-300, Refused("range of double precision")),
        (1e-150, Refused("range of double precision")),
        (1e-100, Certified),
        (1e100, Certified),
        (1e150, Refused("range of double precision")),
        (1e300, Refused("range of double precision")),
    ] {
        all.push(case(format!("radius {size:e} m"), end, |s, _| {
            s.punch.shape = Shape::Sphere { radius: size };
            s.loading.steps = vec![pressed(0.01 * size)];
        }));
    }
    all
}

fn friction() -> Vec<Case> {
    let mut all = Vec::new();
    for mu in [0.0, 1e-12, 10.0, 1e3, 1e300] {
        all.push(case(format!("μ = {mu:e}"), Certified, |s, _| s.friction.mu = mu));
        all.push(case(format!("μ = {mu:e}, shifted"), Certified, |s, _| {
            s.friction.mu = mu;
            s.loading.steps[0].shift_x = Some(0.003);
        }));
        let end = if mu < 1.0 { Failed("gross sliding") } else { Certified };
        all.push(case(format!("μ = {mu:e}, loaded and pulled"), end, |s, _| {
            s.friction.mu = mu;
            s.loading.steps = vec![loaded(0.003), pulled(0.00045)];
        }));
        all.push(case(format!("μ = {mu:e}, a disk on its edge"), Certified, |s, _| {
            s.friction.mu = mu;
            s.foundation = half_space(1.0, 0.0);
            s.punch.shape = Shape::FlatDisk { radius: 1.0 };
            s.loading.steps[0].tilt_x = Some(0.03);
        }));
    }
    for share in [0.999_999, 0.999_999_999, 1.0, 1.000_001, 100.0] {
        let end = if share < 1.0 { Certified } else { Failed("gross sliding") };
        for poisson in [0.0, 0.3] {
            all.push(case(format!("pulled by {share} μP, ν = {poisson}"), end, |s, _| {
                s.foundation = half_space(1.0, poisson);
                s.loading.steps = vec![loaded(0.003), pulled(share * 0.3 * 0.003)];
            }));
        }
    }
    all.push(case(
        "pulled by 100 μP under a prescribed approach",
        Failed("gross sliding"),
        |s, _| {
            s.loading.steps = vec![pressed(0.01), pulled(0.11)];
        },
    ));
    all.push(case("twisted by more than friction carries", Failed("gross sliding"), |s, _| {
        s.loading.steps = vec![loaded(0.003), Step { moment_z: Some(0.001), ..Step::default() }];
    }));
    all.push(case(
        "tilted by a moment where nothing touches",
        Failed("nothing carries moment_y = 1.000000e-3 N m"),
        |s, _| {
            s.loading.steps = vec![Step { moment_y: Some(1e-3), ..pressed(-0.01) }];
        },
    ));
    for (motion, end) in
        [(1.0, Certified), (1e6, Certified), (1e300, Refused("squared in double precision"))]
    {
        all.push(case(format!("shifted by {motion:e} m"), end, |s, _| {
            s.loading.steps[0].shift_x = Some(motion)
        }));
        all.push(case(format!("twisted by {motion:e} rad"), end, |s, _| {
            s.loading.steps[0].twist = Some(motion)
        }));
    }
    all.push(case("cycle of 200 steps", Certified, |s, _| s.loading = two_hundred_steps()));
    all
}

/// Returns a path that presses once and then pulls to and fro a hundred times.
fn two_hundred_steps() -> Loading {
    Loading {
        steps: vec![loaded(0.003), pulled(0.0006), pulled(-0.0006)],
        cycle_from: Some(1),
        cycles: 100,
    }
}

fn regularisation_and_ceiling() -> Vec<Case> {
    let mut all = Vec::new();
    for epsilon in [1e-16, 1e-8, 1e-4, 1.0, 10.0, 1e6, 1e300] {
        let end = if epsilon < 1e120 { Certified } else { Refused("squared in double precision") };
        all.push(case(format!("ε = {epsilon:e}"), end, |_, n| n.epsilon = epsilon));
        all.push(case(format!("ε = {epsilon:e}, by load"), end, |s, n| {
            n.epsilon = epsilon;
            s.loading.steps = vec![loaded(0.003)];
        }));
    }
    let too_small = Refused("squared in double precision");
    let too_low = Refused("ceiling lets the whole sole carry");
    struct Ends {
        ceiling: f64,
        by_motion: End,
        by_load: End,
    }
    for Ends { ceiling, by_motion, by_load } in [
        Ends { ceiling: 1e-300, by_motion: too_small, by_load: too_small },
        Ends { ceiling: 1e-12, by_motion: Certified, by_load: too_low },
        Ends { ceiling: 0.01, by_motion: Certified, by_load: too_low },
        Ends { ceiling: 1e3, by_motion: Certified, by_load: Certified },
        Ends { ceiling: 1e300, by_motion: Certified, by_load: Certified },
    ] {
        all.push(case(format!("ceiling {ceiling:e} Pa"), by_motion, |_, n| {
            n.ceiling = Some(ceiling)
        }));
        all.push(case(format!("ceiling {ceiling:e} Pa, by load"), by_load, |s, n| {
            n.ceiling = Some(ceiling);
            s.loading.steps = vec![loaded(0.003)];
        }));
    }
    for share in [0.5, 0.99, 0.999_999] {
        all.push(case(
            format!("load {share} of what the ceiling lets a flat punch carry"),
            Certified,
            |s, n| {
                n.ceiling = Some(1e-2);
                s.punch.shape = rectangle(1.0, 1.0);
                s.loading.steps = vec![loaded(share * 1e-2)];
            },
        ));
    }
    all
}

fn loads() -> Vec<Case> {
    let mut all = Vec::new();
    for n in [15, 16] {
        for (contact, approach) in [
            ("never touches", -0.01),
            ("just touches", 0.0),
            ("full contact", 1.0),
            ("full contact", 1e6),
        ] {
            all.push(case(
                format!("{contact}, approach {approach} m, {n} elements"),
                Certified,
                |s, numerics| {
                    numerics.mesh = Mesh::Across(n);
                    s.domain = square(0.3);
                    s.loading.steps = vec![pressed(approach)];
                },
            ));
        }
        let too_small = Refused("last digit of an approach");
        let beyond = Refused("squared in double precision");
        for (force, end) in [
            (1e-300, beyond),
            (1e-30, too_small),
            (1e-12, Certified),
            (1e12, Certified),
            (1e100, Certified),
            (1e300, beyond),
        ] {
            all.push(case(format!("load {force:e} N, {n} elements"), end, |s, numerics| {
                numerics.mesh = Mesh::Across(n);
                s.domain = square(0.3);
                s.loading.steps = vec![loaded(force)];
            }));
        }
    }
    for (force, end) in [
        (1e-100, Certified),
        (1e-12, Certified),
        (1e12, Certified),
        (1e100, Certified),
        (1e300, Refused("squared in double precision")),
    ] {
        all.push(case(format!("load {force:e} N on its own Ω"), end, |s, _| {
            s.loading.steps = vec![loaded(force)]
        }));
    }
    let away = |pull: f64| {
        vec![loaded(0.003), Step { force_x: Some(pull), force_y: Some(0.0), ..pressed(-0.01) }]
    };
    all.push(case("lifted off, and pulled by nothing", Certified, |s, _| {
        s.loading.steps = away(0.0)
    }));
    all.push(case("lifted off, and pulled", Failed("gross sliding"), |s, _| {
        s.loading.steps = away(1e-6)
    }));
    all.push(case("lifted off, and tipped by nothing", Certified, |s, _| {
        s.punch.shape = rectangle(1.0, 1.0);
        s.loading.steps = vec![
            loaded(0.003),
            Step { moment_x: Some(0.0), moment_z: Some(0.0), ..pressed(-0.01) },
        ];
    }));
    all.push(case("load beside the sole", Failed("line of action passes the sole by"), |s, _| {
        s.punch.shape = rectangle(2.0, 1.0);
        s.loading.steps = vec![Step { moment_x: Some(0.006), ..loaded(0.01) }];
    }));
    all.push(case("load near the corner", Certified, |s, _| {
        s.punch.shape = rectangle(2.0, 1.0);
        s.loading.steps =
            vec![Step { moment_x: Some(0.0043), moment_y: Some(0.009), ..loaded(0.01) }];
    }));
    struct Tilted {
        name: &'static str,
        approach: f64,
        tilt: [f64; 2],
    }
    for Tilted { name, approach, tilt } in [
        Tilted { name: "one corner", approach: -0.028, tilt: [0.03, -0.03] },
        Tilted { name: "one edge", approach: -0.012, tilt: [0.03, 0.0] },
        Tilted { name: "a half", approach: 0.0, tilt: [0.02, 0.01] },
    ] {
        all.push(case(format!("tilt that leaves {name}"), Certified, |s, _| {
            s.punch.shape = rectangle(2.0, 1.0);
            s.loading.steps =
                vec![Step { tilt_x: Some(tilt[0]), tilt_y: Some(tilt[1]), ..pressed(approach) }];
        }));
    }
    all
}

fn shapes() -> Vec<Case> {
    let mut all = Vec::new();
    for mesh in [[1, 1], [1, 20], [20, 1], [2, 1], [200, 1]] {
        all.push(case(format!("{mesh:?} elements, shifted"), Certified, |s, n| {
            n.mesh = Mesh::Exact(mesh);
            s.loading.steps[0].shift_x = Some(0.001);
        }));
        all.push(case(format!("{mesh:?} elements, by load"), Certified, |s, n| {
            n.mesh = Mesh::Exact(mesh);
            s.loading.steps = vec![Step { force_y: Some(1e-4), ..loaded(0.003) }];
        }));
        all.push(case(
            format!("{mesh:?} elements that cannot carry a moment"),
            Failed("line of action passes the sole by"),
            |s, n| {
                n.mesh = Mesh::Exact(mesh);
                s.punch.shape = rectangle(1.0, 2.0);
                s.loading.steps =
                    vec![Step { moment_x: Some(1e-5), moment_y: Some(1e-5), ..loaded(0.01) }];
            },
        ));
        if mesh.contains(&1) && mesh != [1, 1] {
            all.push(case(
                format!("{mesh:?} elements that a moment is to tilt"),
                Failed("a single row of elements: prescribe tilt_"),
                |s, n| {
                    n.mesh = Mesh::Exact(mesh);
                    s.punch.shape = rectangle(1.0, 2.0);
                    let [moment_x, moment_y] =
                        if mesh[0] == 1 { [None, Some(0.0)] } else { [Some(0.0), None] };
                    s.loading.steps = vec![Step { moment_x, moment_y, ..loaded(0.01) }];
                },
            ));
        }
    }
    for ratio in [1e-3, 1e3, 1e6] {
        all.push(case(format!("elements 1 : {ratio:e} of a flat punch"), Certified, |s, n| {
            n.mesh = Mesh::Exact([16, 16]);
            s.punch.shape = rectangle(1.0, ratio);
            s.loading.steps[0].shift_x = Some(0.001);
        }));
        all.push(case(format!("elements 1 : {ratio:e} of a sphere"), Certified, |s, n| {
            n.mesh = Mesh::Exact([16, 16]);
            s.domain =
                Some(Domain { width_x: 0.3, width_y: 0.3 * ratio, center_x: 0.0, center_y: 0.0 });
            s.loading.steps[0].shift_y = Some(0.001);
        }));
    }
    for (shape, name) in
        [(Shape::FlatDisk { radius: 1.0 }, "disk"), (rectangle(1.0, 1.0), "square")]
    {
        for n in [15, 64] {
            all.push(case(
                format!("sharp edges of a {name}, {n} elements"),
                Certified,
                |s, numerics| {
                    numerics.mesh = Mesh::Across(n);
                    s.punch.shape = shape.clone();
                },
            ));
        }
    }
    for radius in [1e3, 1e6, 1e12, 1e100] {
        for step in [pressed(0.01), loaded(1e-6)] {
            all.push(case(format!("conforming, R = {radius:e} m, {step:?}"), Certified, |s, _| {
                s.domain = square(0.3);
                s.punch.shape = Shape::Sphere { radius };
                s.loading.steps = vec![step];
            }));
        }
    }
    all.push(case("ellipsoid 1 : 1e6", Certified, |s, _| {
        s.punch.shape = Shape::Ellipsoid { radius_x: 1.0, radius_y: 1e12 };
    }));
    for angle in [1e-12, 1.5, 1.569] {
        for step in [pressed(0.01), loaded(1e-3)] {
            all.push(case(format!("cone of {angle} rad, {step:?}"), Certified, |s, _| {
                s.punch.shape = Shape::Cone { angle };
                s.loading.steps = vec![step];
            }));
        }
    }
    all.push(spots());
    all.push(with_map(
        "height map beyond the range of doubles",
        Refused("range of double precision"),
        2,
        vec![1.7e308, -1.7e308, 0.0, 0.0],
    ));
    all
}

/// Builds a case of a square that is flat but for this map, pressed by a fifth of a millimetre.
fn with_map(name: &str, end: End, pixels: usize, heights: Vec<f64>) -> Case {
    let mut surfaces = Surfaces::new();
    surfaces.insert("map".to_owned(), Arc::new(Surface::new(pixels, pixels, heights).unwrap()));
    let rough = case(name, end, |s, n| {
        n.mesh = Mesh::Across(pixels as u32);
        s.punch.shape = Shape::HeightMap { surface: "map".to_owned(), width_x: 1.0, width_y: 1.0 };
        s.loading.steps = vec![pressed(2e-4)];
    });
    Case { surfaces, ..rough }
}

/// Builds a case of 7 × 7 bumps that differ in height.
fn spots() -> Case {
    let n = 84;
    let bump =
        |pixel: usize| ((pixel as f64 + 0.5) / n as f64 * 7.0 * std::f64::consts::PI).sin().powi(2);
    let height = |e: usize| {
        let (i, j) = (e % n, e / n);
        let level = ((i / 12 * 7 + j / 12) * 29 % 49) as f64 / 49.0;
        1e-3 * (bump(i) * bump(j) + 0.05 * level)
    };
    with_map("49 separate spots", Certified, n, (0..n * n).map(height).collect())
}

fn run(case: &Case, method: Method) -> Result<(Outcome, Fields), SceneError> {
    let numerics = Numerics { method, ..case.numerics.clone() };
    solve(&case.scene, &numerics, &case.surfaces, &mut Operators::default())
}

/// Returns the end of a case's path, which must be certified.
fn solved(case: &Case) -> (StepOutcome, Fields) {
    let (outcome, fields) =
        run(case, Method::Auto).unwrap_or_else(|error| panic!("{}: {error}", case.name));
    assert_eq!(outcome.status, Status::Certified, "{}", case.name);
    (*outcome.last().unwrap(), fields)
}

/// Checks that all figures of a solution are finite numbers.
fn all_finite(outcome: &Outcome, fields: &Fields) -> Result<(), String> {
    let text = format!("{:?} {:?} {:?}", outcome.steps, outcome.hertz, outcome.rail);
    // Debug writes infinities and NaN by these words, and no field has them in its name.
    if text.contains("NaN") || text.contains(": inf") || text.contains("-inf") {
        return Err(text);
    }
    let blocks = [
        &fields.pressure,
        &fields.traction_x,
        &fields.traction_y,
        &fields.gap,
        &fields.slip_x,
        &fields.slip_y,
    ];
    if blocks.into_iter().flatten().all(|x| x.is_finite()) {
        Ok(())
    } else {
        Err("a field has an entry that is no number".to_owned())
    }
}

/// Computes the residual of a solution of one increment anew from its fields alone: displacements
/// are summed column by column, and the conditions of contact are spelled out once more. The second
/// entry is the share of it that may be rounding: of the largest coefficient, and of the motion,
/// which has been turned into SI units, in units of the smallest diagonal.
fn residual_anew(case: &Case, end: &StepOutcome, fields: &Fields) -> [f64; 2] {
    let mut problem = Problem::new(&case.scene, &case.numerics, &case.surfaces).unwrap();
    let units = problem.scale.motions();
    let motion = end.motion.per_dof();
    problem.place(&PerDof::from_fn(|dof| motion[dof] / units[dof]));
    let table = Operators::default().of(&problem).table;
    let k = problem.grid.len();
    let p: Vec<f64> = [&fields.pressure, &fields.traction_x, &fields.traction_y]
        .into_iter()
        .flat_map(|block| block.iter().map(|p| p / problem.scale.traction()))
        .collect();
    let mut w: Vec<f64> = problem.f.iter().map(|f| -f).collect();
    for e in problem.grid.active().filter(|e| p[*e] != 0.0) {
        table.add_column(e, [p[e], p[k + e], p[2 * k + e]], &mut w);
    }
    let peak = p.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let diagonal = table.coefficient(0, 0);
    let stiff = [diagonal.nn, diagonal.xx.max(diagonal.yy), diagonal.xx.max(diagonal.yy)]
        .map(|entry| problem.epsilon + entry);
    let frictionless = case.scene.friction.mu == 0.0;
    let (mut defect, mut size) = (0.0, 0.0);
    for e in problem.grid.active() {
        let traction = [p[e], p[k + e], p[2 * k + e]];
        let x = [0, 1, 2]
            .map(|c| traction[c] - (problem.epsilon * traction[c] + w[c * k + e]) / stiff[c]);
        let normal = x[0].clamp(0.0, problem.ceiling);
        let share = (problem.mu * normal / x[1].hypot(x[2])).min(1.0);
        let tangential =
            if frictionless || share.is_nan() { [0.0; 2] } else { [share * x[1], share * x[2]] };
        for (value, image) in traction.into_iter().zip([normal, tangential[0], tangential[1]]) {
            defect += if value == image { 0.0 } else { ((value - image) / peak).powi(2) };
            size += if value == 0.0 { 0.0 } else { (value / peak).powi(2) };
        }
    }
    let smallest = stiff.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    let travel: f64 = motion.iter().zip(units).map(|(motion, unit)| (motion / unit).abs()).sum();
    let rounding = 1e-14 * stiff.iter().fold(0.0, |a: f64, b| a.max(*b)) / smallest;
    let rounding = rounding
        + if travel == 0.0 { 0.0 } else { 16.0 * f64::EPSILON * travel / (smallest * peak) };
    [if defect == 0.0 { 0.0 } else { (defect / size).sqrt() }, rounding]
}

/// Finds a flaw of a certified outcome, if it has one.
fn flaw(case: &Case, outcome: &Outcome, fields: &Fields) -> Option<String> {
    if let Err(text) = all_finite(outcome, fields) {
        return Some(text);
    }
    if let Some(step) =
        outcome.steps.iter().find(|step| !step.certificate.meets(case.numerics.tolerance))
    {
        return Some(format!(
            "a certificate that does not meet the tolerance: {:?}",
            step.certificate
        ));
    }
    let increments: u32 = case.scene.loading.legs().iter().map(|leg| leg.increments).sum();
    let end = outcome.last()?;
    // Column by column, a million elements would take hours.
    if increments == 1 && fields.pressure.len() < 100_000 {
        let [residual, rounding] = residual_anew(case, end, fields);
        // The motions and tractions are in SI units, and so have been rounded once more.
        if residual.is_nan() || residual > 2.0 * case.numerics.tolerance + rounding {
            return Some(format!("residual {residual:e}"));
        }
    }
    for (e, p) in fields.pressure.iter().enumerate() {
        let traction = fields.traction_x[e].hypot(fields.traction_y[e]);
        let slack = 2.0 * case.numerics.tolerance * end.observables.peak_pressure;
        if *p < -slack || traction > case.scene.friction.mu * p + slack {
            return Some(format!("p = {p:e}, |p_t| = {traction:e}"));
        }
    }
    None
}

fn check(cases: Vec<Case>) {
    for case in &cases {
        let name = &case.name;
        match (run(case, Method::Auto), case.end) {
            (Ok((outcome, fields)), Certified) => {
                assert_eq!(outcome.status, Status::Certified, "{name}");
                assert_eq!(flaw(case, &outcome, &fields), None, "{name}");
                by_the_reference(case, &fields);
            }
            (Ok((Outcome { status: Status::Failed { reason }, .. }, _)), Failed(words)) => {
                assert!(reason.contains(words), "{name}: {reason}")
            }
            (Err(error), Refused(words)) => {
                assert!(error.to_string().contains(words), "{name}: {error}")
            }
            (end, _) => panic!("{name}: {:?}", end.map(|(outcome, _)| outcome.status)),
        }
    }
}

/// Checks that Seidel's iteration comes to the same solution, or says that it does not converge.
fn by_the_reference(case: &Case, fields: &Fields) {
    let short = Numerics { max_iterations: 1000, ..case.numerics.clone() };
    if fields.pressure.len() > 400 || case.scene.loading.steps.len() > 1 {
        return;
    }
    let case = Case {
        name: case.name.clone(),
        scene: case.scene.clone(),
        numerics: short,
        surfaces: case.surfaces.clone(),
        end: case.end,
    };
    let (outcome, other) = run(&case, Method::Seidel).unwrap();
    match outcome.status {
        Status::Certified => {
            assert_eq!(flaw(&case, &outcome, &other), None, "{}", case.name);
            // With large friction there may be more than one solution.
            if case.scene.friction.mu < 1.0 {
                assert!(
                    difference(&other, fields) < 1e-4,
                    "{}: {:e}",
                    case.name,
                    difference(&other, fields)
                );
            }
        }
        Status::Failed { reason } => {
            assert!(
                reason.contains("not converged in") || reason.contains("stalled after"),
                "{}: {reason}",
                case.name
            )
        }
    }
}

#[test]
fn stiffnesses_from_one_end_to_the_other() {
    check(stiffness());
}

#[test]
fn friction_from_none_to_all() {
    check(friction());
}

#[test]
fn regularisations_and_ceilings() {
    check(regularisation_and_ceiling());
}

#[test]
fn loads_from_none_to_all() {
    check(loads());
}

#[test]
fn shapes_and_meshes() {
    check(shapes());
}

/// The mesh has more than a million elements.
#[test]
#[ignore = "some seconds on all cores, and gigabytes"]
fn a_million_elements() {
    check(vec![case("1024 × 1024 elements", Certified, |_, n| {
        n.mesh = Mesh::Exact([1024, 1024])
    })]);
}
