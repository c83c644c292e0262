//! A height map is one smooth surface for every mesh and projection: on meshes finer than its
//! pixels, results converge to those of the shape that was sampled.

use std::sync::Arc;

use contact::model::{Domain, Mesh, Projection, Shape, Step, StepOutcome};
use contact::punch::{Surface, Surfaces};

use crate::common::{certified_with, numerics, scene};

/// Presses a map of `pixels` × `pixels` heights onto steel, by an approach \[m\], on a square of
/// 1 mm.
fn pressed(
    pixels: usize,
    heights: Vec<f64>,
    approach: f64,
    mesh: u32,
    projection: Projection,
) -> StepOutcome {
    let mut surfaces = Surfaces::new();
    let surface = Surface::new(pixels, pixels, heights).expect("a surface");
    surfaces.insert("map".to_owned(), Arc::new(surface));
    let width = 1e-3;
    let shape = Shape::HeightMap { surface: "map".to_owned(), width_x: width, width_y: width };
    let step = Step { approach: Some(approach), ..Step::default() };
    let mut scene = scene(shape, 80e9, 0.3, 0.0, step);
    scene.domain = Some(Domain { width_x: width, width_y: width, center_x: 0.0, center_y: 0.0 });
    certified_with(&scene, &numerics(Mesh::Across(mesh), projection, 1e-7), &surfaces).0
}

/// A sphere of 10 mm radius, sampled at 32 × 32 pixels of 31.25 µm, meets Hertz: load 340.7 N, peak
/// pressure 3.25 GPa.
#[test]
fn a_sampled_sphere_is_a_sphere_on_every_mesh() {
    let (n, radius, approach) = (32, 10e-3, 5e-6);
    let place = |k: usize| ((k as f64 + 0.5) / n as f64 - 0.5) * 1e-3;
    let heights: Vec<f64> = (0..n * n)
        .map(|s| -(place(s % n).powi(2) + place(s / n).powi(2)) / (2.0 * radius))
        .collect();
    let modulus = 2.0 * 80e9 / (1.0 - 0.3);
    let (load, peak) = (
        4.0 / 3.0 * modulus * radius.sqrt() * f64::powf(approach, 1.5),
        2.0 * modulus / std::f64::consts::PI * (approach / radius).sqrt(),
    );
    for projection in [Projection::Average, Projection::Midpoint] {
        for (mesh, within_load, within_peak) in
            [(16, 0.03, 0.05), (32, 0.02, 0.05), (64, 6e-3, 0.02), (128, 3e-3, 0.01)]
        {
            let found = pressed(n, heights.clone(), approach, mesh, projection).observables;
            let errors = [found.load / load - 1.0, found.peak_pressure / peak - 1.0];
            println!(
                "{projection:?}, mesh {mesh}: load {:+.4} %, peak {:+.4} %",
                100.0 * errors[0],
                100.0 * errors[1]
            );
            assert!(errors[0].abs() < within_load, "{projection:?} {mesh}: {errors:?}");
            assert!(errors[1].abs() < within_peak, "{projection:?} {mesh}: {errors:?}");
        }
    }
}

/// Both projections of a rough map have one limit.
#[test]
fn a_rough_map_has_one_limit() {
    let n = 16;
    let waves =
        [(1.0, 2.0, 0.3, 1.0), (2.0, -1.0, 1.1, 0.8), (3.0, 2.0, 2.0, 0.4), (-4.0, 5.0, 0.7, 0.2)];
    let height = |s: usize| -> f64 {
        let (x, y) = ((s % n) as f64 / n as f64, (s / n) as f64 / n as f64);
        let wave = |(a, b, phase, size): &(f64, f64, f64, f64)| {
            size * (2.0 * std::f64::consts::PI * (a * x + b * y) + phase).cos()
        };
        // The edges lie too deep to touch: under a sharp edge, pressures have no limit.
        let bow = (2.0 * x - 1.0).powi(2) + (2.0 * y - 1.0).powi(2);
        1e-6 * (waves.iter().map(wave).sum::<f64>() - 12.0 * bow)
    };
    let heights: Vec<f64> = (0..n * n).map(height).collect();
    let figures = |mesh: u32, projection: Projection| {
        let found = pressed(n, heights.clone(), 1e-6, mesh, projection).observables;
        println!(
            "{projection:?}, mesh {mesh}: load {:.3} N, peak {:.4e} Pa",
            found.load, found.peak_pressure
        );
        [found.load, found.peak_pressure]
    };
    let [coarse, fine] = [64, 128].map(|mesh| {
        let (average, midpoint) =
            (figures(mesh, Projection::Average), figures(mesh, Projection::Midpoint));
        [average[0] / midpoint[0] - 1.0, average[1] / midpoint[1] - 1.0].map(f64::abs)
    });
    assert!(fine[0] < 5e-3 && fine[1] < 0.02, "{coarse:?} {fine:?}");
    assert!(fine[0] < coarse[0] && fine[1] < coarse[1], "{coarse:?} {fine:?}");
}

/// An excluded pixel cannot touch, whatever its height.
#[test]
fn excluded_pixels_bear_nothing() {
    let mut surfaces = Surfaces::new();
    let absent = (0..64).map(|s| s % 8 < 4).collect();
    let surface = Surface::new(8, 8, vec![0.0; 64]).unwrap().excluding(absent).unwrap();
    surfaces.insert("map".to_owned(), Arc::new(surface));
    let shape = Shape::HeightMap { surface: "map".to_owned(), width_x: 1e-3, width_y: 1e-3 };
    let step = Step { approach: Some(1e-6), ..Step::default() };
    let scene = scene(shape, 80e9, 0.3, 0.0, step);
    let (outcome, fields) =
        certified_with(&scene, &numerics(Mesh::Across(16), Projection::Average, 1e-7), &surfaces);
    assert_eq!(outcome.observables.contact_elements, 8 * 16);
    assert!((0..256).all(|e| (fields.pressure[e] > 0.0) == (e % 16 >= 8)));
}
