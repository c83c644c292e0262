//! Solutions meet the closed forms and tabulated solutions of the continuous problem, in value and
//! in the observed order of convergence.
//!
//! Areas are counted in whole elements, so the error of a counted radius jumps about; only its
//! bound, a fraction of an element, falls in order. Where a smooth measure of the same radius
//! exists (a moment of the pressure), its order is asserted.

use std::f64::consts::PI;

use crate::common::*;
use contact::model::*;
use contact::theory;

/// Returns the composite modulus E* of a rigid punch on a half-space with G = 1.
fn modulus(poisson: f64) -> f64 {
    2.0 / (1.0 - poisson)
}

/// Returns the least-squares slope of the log of the error against the log of the mesh, with its
/// sign changed: the order over the whole ladder.
fn order(meshes: &[u32], errors: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> =
        meshes.iter().zip(errors).map(|(&n, e)| (f64::from(n).ln(), e.ln())).collect();
    let mean =
        |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    -points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>()
        / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

/// The errors of one figure over a ladder of meshes.
struct Ladder {
    name: String,
    meshes: Vec<u32>,
    errors: Vec<f64>,
}

impl Ladder {
    /// Asserts that the order over the whole ladder is at least `least`, and that the finest error
    /// is at most `finest`.
    fn assert(&self, least: f64, finest: f64) {
        let order = order(&self.meshes, &self.errors);
        let shown: Vec<String> = self.errors.iter().map(|e| format!("{e:.1e}")).collect();
        eprintln!("{}: {shown:?}, order {order:.2}", self.name);
        assert!(order >= least, "{}: order {order:.2} below {least} ({shown:?})", self.name);
        assert!(
            *self.errors.last().unwrap() <= finest,
            "{}: {shown:?} does not reach {finest:e}",
            self.name
        );
    }

    /// Asserts that every error is at most `fraction` of an element, where Ω is 2·`half_width`
    /// across.
    fn assert_within_elements(&self, fraction: f64, half_width: f64) {
        for (&n, error) in self.meshes.iter().zip(&self.errors) {
            let element = 2.0 * half_width / f64::from(n);
            assert!(
                *error <= fraction * element,
                "{} at {n}: {:.2} elements",
                self.name,
                error / element
            );
        }
    }
}

/// A figure of a solution, less its exact value.
type Measure<'a> = &'a dyn Fn(&Observables, &Fields) -> f64;

/// Solves the scene on every mesh and measures the errors.
fn ladders(
    name: &str,
    scene: &Scene,
    projection: Projection,
    meshes: &[u32],
    measures: &[(&str, Measure<'_>)],
) -> Vec<Ladder> {
    let mut ladders: Vec<Ladder> = measures
        .iter()
        .map(|(figure, _)| Ladder {
            name: format!("{name}: {figure}"),
            meshes: meshes.to_vec(),
            errors: Vec::new(),
        })
        .collect();
    for &n in meshes {
        let (outcome, fields) = certified(scene, &numerics(Mesh::Across(n), projection, 1e-8));
        for (ladder, (_, measure)) in ladders.iter_mut().zip(measures) {
            ladder.errors.push(measure(&outcome.observables, &fields).abs());
        }
    }
    ladders
}

/// Returns the contact radius of a Hertzian pressure from its second moment, ⟨r²⟩ = 2a²/5.
fn radius_by_moment(fields: &Fields) -> f64 {
    let [nx, _] = fields.shape;
    let (mut moment, mut load) = (0.0, 0.0);
    for (e, p) in fields.pressure.iter().enumerate() {
        let [x, y] = [e as u32 % nx, e as u32 / nx].map(f64::from);
        let (x, y) =
            (fields.origin[0] + x * fields.element[0], fields.origin[1] + y * fields.element[1]);
        moment += p * (x * x + y * y);
        load += p;
    }
    (2.5 * moment / load).sqrt()
}

fn counted_radius(area: f64) -> f64 {
    (area / PI).sqrt()
}

fn hertz(projection: Projection) {
    let hertz = theory::hertz_sphere(modulus(0.3), 1.0, 1.0);
    let scene = scene(
        Shape::Sphere { radius: 1.0 },
        1.0,
        0.3,
        0.0,
        Step { approach: Some(1.0), ..Step::default() },
    );
    let measured = ladders(
        &format!("Hertz {projection:?}"),
        &scene,
        projection,
        &[12, 24, 48, 96],
        &[
            ("load", &|o, _| o.load / hertz.load - 1.0),
            ("peak pressure", &|o, _| o.peak_pressure / hertz.peak_pressure - 1.0),
            ("radius by moment", &|_, f| radius_by_moment(f) - hertz.radius),
            ("counted radius", &|o, _| counted_radius(o.contact_area) - hertz.radius),
        ],
    );
    let [load, peak, by_moment, counted] = &measured[..] else { unreachable!() };
    load.assert(1.5, 1e-4);
    peak.assert(1.8, 5e-4);
    by_moment.assert(1.2, 5e-4);
    counted.assert_within_elements(0.5, 1.5);
}

#[test]
fn hertz_converges_by_averaging() {
    hertz(Projection::Average);
}

#[test]
fn hertz_converges_by_collocation() {
    hertz(Projection::Midpoint);
}

#[test]
fn elliptic_hertz_meets_its_table() {
    // The first column is A/B of the gap A x² + B y² with B = ½. The others are the semi-axes, the
    // peak and the approach for E* = 1 and F = 1.
    let table = reference("hertz_elliptic.csv");
    let row: Vec<f64> = table
        .lines()
        .find(|line| line.starts_with("0.1,"))
        .unwrap()
        .split(',')
        .map(|x| x.parse().unwrap())
        .collect();
    let [ratio, a, b, _, peak, approach] = row[..] else { panic!() };
    // The shear modulus is G = (1−ν)E*/2.
    let mut scene = scene(
        Shape::Ellipsoid { radius_x: 1.0 / ratio, radius_y: 1.0 },
        0.35,
        0.3,
        0.0,
        Step { approach: Some(approach), ..Step::default() },
    );
    scene.domain =
        Some(Domain { width_x: 3.0 * a, width_y: 3.0 * b, center_x: 0.0, center_y: 0.0 });
    let meshes = [12, 24, 48];
    let mut ladders = ["load", "peak", "area"].map(|figure| Ladder {
        name: format!("elliptic Hertz: {figure}"),
        meshes: meshes.to_vec(),
        errors: Vec::new(),
    });
    for n in meshes {
        let (outcome, _) =
            certified(&scene, &numerics(Mesh::Exact([n, n]), Projection::Average, 1e-8));
        let o = outcome.observables;
        ladders[0].errors.push((o.load - 1.0).abs());
        ladders[1].errors.push((o.peak_pressure / peak - 1.0).abs());
        ladders[2].errors.push((o.contact_area / (PI * a * b) - 1.0).abs());
    }
    let [load, peak, area] = ladders;
    load.assert(1.5, 1e-3);
    peak.assert(1.5, 3e-3);
    area.assert(0.5, 3e-2);
}

#[test]
fn cone_meets_sneddon() {
    let angle = 0.3;
    let exact = theory::cone(modulus(0.3), angle, 1.0);
    let scene = scene(
        Shape::Cone { angle },
        1.0,
        0.3,
        0.0,
        Step { approach: Some(1.0), ..Step::default() },
    );
    let measured = ladders(
        "cone",
        &scene,
        Projection::Average,
        &[12, 24, 48],
        &[
            ("load", &|o, _| o.load / exact.load - 1.0),
            ("counted radius", &|o, _| counted_radius(o.contact_area) / exact.radius - 1.0),
        ],
    );
    measured[0].assert(1.0, 2e-3);
    measured[1].assert_within_elements(0.5, PI / 2.0);
}

/// Returns a row of a reference table whose first two columns are ν and μ.
fn row(file: &str, poisson: f64, mu: f64) -> Vec<f64> {
    let text = reference(file);
    let parse = |line: &str| -> Vec<f64> {
        line.split(',').map(|x| x.parse().unwrap_or(f64::NAN)).collect()
    };
    text.lines()
        .skip(1)
        .map(parse)
        .find(|r| r[0] == poisson && r[1] == mu)
        .expect("a row for that ν and μ")
}

fn spence_flat(poisson: f64, mu: f64) {
    let row = row("spence_incremental.csv", poisson, mu);
    let (stick, ratio) = (row[4], row[5]);
    let scene = scene(
        Shape::FlatDisk { radius: 1.0 },
        1.0,
        poisson,
        mu,
        Step { approach: Some(1.0), ..Step::default() },
    );
    let load = theory::flat_disk(modulus(poisson), 1.0, 1.0).load * ratio;
    let measured = ladders(
        &format!("flat disk ν {poisson} μ {mu}"),
        &scene,
        Projection::Average,
        &[12, 24, 48],
        &[
            ("load", &|o, _| o.load / load - 1.0),
            ("stick radius", &|o, _| counted_radius(o.stick_area) - stick),
        ],
    );
    // The square-root singularity at the edge limits piecewise constants to first order.
    measured[0].assert(0.85, 2.5e-3);
    measured[1].assert_within_elements(0.5, 1.0);
}

#[test]
fn flat_disk_meets_spence_compressible() {
    spence_flat(0.0, 0.3);
}

#[test]
fn flat_disk_meets_spence_steel() {
    spence_flat(0.3, 0.2);
}

#[test]
fn flat_disk_meets_spence_small_stick() {
    spence_flat(0.25, 0.2);
}

/// Every row of the table is held on one mesh: the load within the first-order error that the
/// ladders above show on that mesh, the stick radius within an element.
#[test]
fn flat_disk_meets_every_row_of_spence() {
    let mut rows = 0;
    for line in reference("spence_incremental.csv").lines().skip(1) {
        let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap_or(f64::NAN)).collect();
        let (poisson, mu, stick, ratio) = (row[0], row[1], row[4], row[5]);
        // The rows of full stick to all digits have no numbers.
        if ratio.is_nan() {
            continue;
        }
        let scene = scene(
            Shape::FlatDisk { radius: 1.0 },
            1.0,
            poisson,
            mu,
            Step { approach: Some(1.0), ..Step::default() },
        );
        let (outcome, _) =
            certified(&scene, &numerics(Mesh::Across(24), Projection::Average, 1e-8));
        let o = outcome.observables;
        let load = o.load / (theory::flat_disk(modulus(poisson), 1.0, 1.0).load * ratio) - 1.0;
        let radius = counted_radius(o.stick_area) - stick;
        assert!(load.abs() < 6e-3, "ν {poisson} μ {mu}: load {load:e}");
        assert!(radius.abs() < 1.0 / 12.0, "ν {poisson} μ {mu}: stick radius {radius:e}");
        rows += 1;
    }
    assert!(rows > 35, "{rows}");
}

#[test]
fn flat_disk_in_full_stick_meets_mossakovskii() {
    for poisson in [0.0, 0.3] {
        let load = theory::flat_disk(modulus(poisson), 1.0, 1.0).load
            * theory::full_stick_load_ratio(poisson);
        let scene = scene(
            Shape::FlatDisk { radius: 1.0 },
            1.0,
            poisson,
            10.0,
            Step { approach: Some(1.0), ..Step::default() },
        );
        let measured = ladders(
            &format!("full stick ν {poisson}"),
            &scene,
            Projection::Average,
            &[12, 24, 48],
            &[("load", &|o, _| o.load / load - 1.0), ("slip", &|o, _| o.slip_elements as f64)],
        );
        measured[0].assert(0.85, 3e-3);
        assert_eq!(measured[1].errors, [0.0; 3]);
    }
}

fn sphere_one_step(poisson: f64, mu: f64) {
    // The table is normalised by δ = χ a²/R with a = R = 1, and Φ = 3F(1−ν)R/(8Ga³).
    let row = row("sphere_one_step.csv", poisson, mu);
    let (stick, chi, phi) = (row[2], row[3], row[4]);
    let scene = scene(
        Shape::Sphere { radius: 1.0 },
        1.0,
        poisson,
        mu,
        Step { approach: Some(chi), ..Step::default() },
    );
    let load = phi * 8.0 / (3.0 * (1.0 - poisson));
    let measured = ladders(
        &format!("sphere in one step ν {poisson} μ {mu}"),
        &scene,
        Projection::Average,
        &[12, 24, 48],
        &[
            ("load", &|o, _| o.load / load - 1.0),
            ("contact radius", &|o, _| counted_radius(o.contact_area) - 1.0),
            ("stick radius", &|o, _| counted_radius(o.stick_area) - stick),
        ],
    );
    let half_width = 1.5 * chi.sqrt();
    measured[0].assert(1.0, 1e-3);
    measured[1].assert_within_elements(0.5, half_width);
    measured[2].assert_within_elements(0.75, half_width);
}

#[test]
fn sphere_in_one_step_steel_slippery() {
    sphere_one_step(0.3, 0.15);
}

#[test]
fn sphere_in_one_step_steel() {
    sphere_one_step(0.3, 0.2);
}

#[test]
fn sphere_in_one_step_steel_rough() {
    sphere_one_step(0.3, 0.5);
}

#[test]
fn sphere_in_one_step_compressible() {
    sphere_one_step(0.0, 0.2986);
}

#[test]
fn sphere_in_one_step_compressible_rough() {
    sphere_one_step(0.0, 1.0);
}

#[test]
fn sphere_in_one_step_glass() {
    sphere_one_step(0.2, 0.3);
}

#[test]
fn sphere_in_one_step_nearly_incompressible() {
    sphere_one_step(0.4, 0.1);
}

#[test]
fn every_sphere_in_one_step_has_its_test() {
    assert_eq!(reference("sphere_one_step.csv").lines().skip(1).count(), 7);
}

/// The coupling of two like elastic bodies cancels, so normal contact is Hertz's and a shift gives
/// Cattaneo's and Mindlin's annulus of slip. The theory is exact for ν = 0.
#[test]
fn like_bodies_under_a_shift_meet_cattaneo_and_mindlin() {
    let material = Material { shear_modulus: 2.0, poisson: 0.0 };
    let mu = 0.4;
    // E* of the pair is 1/(2·(1−ν)/2G).
    let hertz = theory::hertz_sphere(2.0, 1.0, 1.0);
    let limit = mu * hertz.load;
    for fraction in [0.3, 0.7] {
        let shift = theory::cattaneo_shift(
            fraction * limit,
            limit,
            hertz.radius,
            2.0 * 2.0 / material.shear_modulus,
        );
        let mut scene = scene(
            Shape::Sphere { radius: 1.0 },
            2.0,
            0.0,
            mu,
            Step { approach: Some(1.0), shift_x: Some(shift), ..Step::default() },
        );
        scene.punch.material = Some(material);
        let stick = theory::cattaneo_stick_ratio(fraction * limit, limit);
        let measured = ladders(
            &format!("Cattaneo Q/μP = {fraction}"),
            &scene,
            Projection::Average,
            &[12, 24, 48],
            &[
                ("load", &|o, _| o.load / hertz.load - 1.0),
                ("tangential force", &|o, _| o.force_x / (fraction * limit) - 1.0),
                ("stick radius", &|o, _| counted_radius(o.stick_area) - stick),
                ("force across", &|o, _| o.force_y / limit),
            ],
        );
        measured[0].assert(1.0, 1e-3);
        measured[1].assert(1.0, 2e-3);
        measured[2].assert_within_elements(0.5, 1.5);
        assert!(measured[3].errors.iter().all(|e| *e < 1e-7));
    }
}

/// Unlike elastic bodies have sums and differences of compliances. A rigid punch on a foundation is
/// the limit of a stiff one.
#[test]
fn a_stiff_punch_is_a_rigid_punch() {
    let step = Step { approach: Some(1.0), shift_x: Some(0.05), ..Step::default() };
    let rigid = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.2, 0.3, step);
    let mut stiff = rigid.clone();
    stiff.punch.material = Some(Material { shear_modulus: 1e12, poisson: 0.3 });
    let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-10);
    let (a, b) =
        (certified(&rigid, &numerics).0.observables, certified(&stiff, &numerics).0.observables);
    assert!((a.load / b.load - 1.0).abs() < 1e-9 && (a.force_x / b.force_x - 1.0).abs() < 1e-8);
    assert_eq!(a.stick_elements, b.stick_elements);
}
