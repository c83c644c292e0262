//! Times the assembly of the influence coefficients and the application of the operators made of
//! them.

use contact::foundation::{Bodies, HalfSpace};
use contact::grid::Grid;
use contact::influence::{
    Circulant, Components, Dense, Influence, InfluenceTable, Mirror, Scratch, Symmetry, Toeplitz,
};
use contact::model::{Base, Layer, Material, Projection};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::hint::black_box;

const SIDES: [usize; 5] = [32, 64, 128, 256, 512];

fn grid(n: usize) -> Grid {
    Grid::new(n, n, 2.0 / n as f64, 2.0 / n as f64, [1.0 / n as f64 - 1.0; 2]).expect("a square")
}

fn bodies() -> HalfSpace {
    HalfSpace::new(&Material { shear_modulus: 1.0, poisson: 0.3 }, None)
}

fn table(n: usize) -> InfluenceTable {
    InfluenceTable::new(&grid(n), &bodies(), Projection::Average)
}

fn field(n: usize) -> Vec<f64> {
    (0..3 * n * n).map(|e| (e as f64 * 0.7).sin()).collect()
}

fn coefficients(c: &mut Criterion) {
    let mut group = c.benchmark_group("coefficients");
    group.sample_size(10);
    for projection in [Projection::Average, Projection::Midpoint] {
        for n in SIDES {
            let grid = grid(n);
            let id = BenchmarkId::new(format!("{projection:?}"), n);
            group.bench_function(id, |b| {
                b.iter(|| InfluenceTable::new(black_box(&grid), &bodies(), projection))
            });
        }
    }
    let long = Grid::new(512, 512, 1e-3, 1.0, [0.0; 2]).expect("a rectangle");
    group.bench_function("elements of 1 × 1000, 512", |b| {
        b.iter(|| InfluenceTable::new(black_box(&long), &bodies(), Projection::Average));
    });
    group.finish();
}

/// Times assembly for layered foundations beside that for a half-space, on one thread and on two.
fn layered(c: &mut Criterion) {
    let mut group = c.benchmark_group("layered");
    group.sample_size(10);
    let layer = |shear_modulus, thickness| Layer { shear_modulus, poisson: 0.3, thickness };
    let base = Base::Elastic(Material { shear_modulus: 1.0, poisson: 0.35 });
    let cases = [
        ("half-space", Bodies::from(&bodies())),
        ("coating", Bodies::new(&[layer(10.0, 0.5)], &base, None)),
        (
            "five layers",
            Bodies::new(&[5.0, 0.5, 2.0, 0.1, 3.0].map(|g| layer(g, 0.1)), &base, None),
        ),
        ("film of 1e-6", Bodies::new(&[layer(0.1, 1e-6)], &base, None)),
        ("layer on rigid base", Bodies::new(&[layer(1.0, 0.2)], &Base::Rigid, None)),
    ];
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        for (name, bodies) in &cases {
            for n in [64, 128, 256] {
                let grid = grid(n);
                let id = BenchmarkId::new(format!("{name}, {threads} threads"), n);
                group.bench_function(id, |b| {
                    b.iter(|| {
                        pool.install(|| {
                            InfluenceTable::new(black_box(&grid), bodies, Projection::Average)
                        })
                    });
                });
            }
        }
        group.bench_function(format!("kernels alone, coating, {threads} threads"), |b| {
            b.iter(|| pool.install(|| black_box(&cases[1].1).kernels(3.0)));
        });
    }
    group.finish();
}

fn application(c: &mut Criterion) {
    let mut group = c.benchmark_group("application");
    group.sample_size(20);
    let mut run = |name: &str, n: usize, operator: &dyn Influence, threads: usize| {
        let (p, mut out) = (field(n), vec![0.0; 3 * n * n]);
        let mut scratch = Scratch::with_threads(operator, threads);
        group.bench_function(BenchmarkId::new(name, n), |b| {
            b.iter(|| operator.apply(&mut out, black_box(&p), &mut scratch))
        });
    };
    for n in [32, 48] {
        run("dense", n, &Dense::new(&table(n)), 1);
    }
    for n in SIDES {
        let toeplitz = Toeplitz::new(&table(n));
        run("fft, 1 thread", n, &toeplitz, 1);
        run("fft, 2 threads", n, &toeplitz, 2);
    }
    group.finish();

    let mut group = c.benchmark_group("preparation");
    group.sample_size(10);
    for n in SIDES {
        let table = table(n);
        group.bench_function(BenchmarkId::new("symbols", n), |b| {
            b.iter(|| Toeplitz::new(black_box(&table)))
        });
    }
    group.finish();
}

/// Times operators on fewer components, and on halves and quarters of the grid, on one thread; the
/// preconditioner likewise.
fn reduced(c: &mut Criterion) {
    let sets = [
        ("n, x, y", Components::ALL),
        ("n", Components::NORMAL),
        ("x, y", Components::TANGENTIAL),
        ("x", Components::X),
    ];
    let plane = Some(Symmetry::Symmetric);
    let mirrors = [
        ("whole", Mirror::NONE),
        ("x > 0", Mirror { x: plane, y: None }),
        ("y > 0", Mirror { x: None, y: plane }),
        ("quarter", Mirror { x: plane, y: plane }),
    ];
    let mut group = c.benchmark_group("reduced");
    group.sample_size(20);
    for n in [64, 256, 512] {
        let table = table(n);
        for (set, components) in sets {
            for (region, mirror) in mirrors {
                let operator = Toeplitz::of(&table, components, mirror);
                let p: Vec<f64> = field(n)[..components.len() * operator.grid().len()].to_vec();
                let mut out = vec![0.0; p.len()];
                let mut scratch = Scratch::with_threads(&operator, 1);
                let id = BenchmarkId::new(format!("operator, {set}, {region}"), n);
                group.bench_function(id, |b| {
                    b.iter(|| operator.apply(&mut out, black_box(&p), &mut scratch))
                });
                let circulant = Circulant::of(&table, components, mirror);
                let id = BenchmarkId::new(format!("circulant, {set}, {region}"), n);
                group.bench_function(id, |b| {
                    b.iter(|| circulant.invert(&mut out, black_box(&p), 0.1, &mut scratch));
                });
            }
        }
    }
    group.finish();
}

fn column(c: &mut Criterion) {
    let mut group = c.benchmark_group("column");
    for n in [32, 64, 128, 256] {
        let (table, mut displacement) = (table(n), vec![0.0; 3 * n * n]);
        group.bench_function(BenchmarkId::new("add", n), |b| {
            b.iter(|| table.add_column(black_box(n * n / 3), [1.0, 0.5, -0.5], &mut displacement));
        });
    }
    group.finish();
}

criterion_group!(benches, coefficients, layered, application, reduced, column);
criterion_main!(benches);
