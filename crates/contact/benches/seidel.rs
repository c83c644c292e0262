//! Times Seidel sweeps of a sphere with full coupling, ten sweeps from zero traction, and whole
//! solves to 1e-8.

use contact::model::{Numerics, Scene};
use contact::problem::Problem;
use contact::punch::Surfaces;
use contact::solver::{StopRule, seidel};
use contact::{Operators, solve};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

fn sphere(n: u32) -> (Scene, Numerics) {
    let scene = serde_json::from_str(
        r#"{"foundation": {"base": {"shear_modulus": 1, "poisson": 0.3}},
            "punch": {"shape": "sphere", "radius": 1},
            "friction": {"mu": 0.3}, "loading": {"steps": [{"approach": 1}]}}"#,
    );
    let numerics = serde_json::from_str(&format!(r#"{{"mesh": {n}, "tolerance": 1e-8}}"#));
    (scene.expect("a scene"), numerics.expect("numerics"))
}

fn benches(criterion: &mut Criterion) {
    let mut sweeps = criterion.benchmark_group("ten Seidel sweeps, sphere, nu = mu = 0.3");
    sweeps.sample_size(10);
    for n in [16, 32, 64] {
        let (scene, numerics) = sphere(n);
        let problem = Problem::new(&scene, &numerics, &Surfaces::new()).expect("a problem");
        let operator = Operators::default().of(&problem);
        let rule = StopRule { tolerance: 1e-15, max_iterations: 10, cancellation: None };
        sweeps.throughput(Throughput::Elements(10 * u64::from(n * n)));
        sweeps.bench_function(BenchmarkId::from_parameter(n), |bencher| {
            bencher.iter(|| {
                seidel::solve(&problem, &operator.table, vec![0.0; problem.f.len()], &rule)
            });
        });
    }
    sweeps.finish();

    let mut solves = criterion.benchmark_group("solve to 1e-8, operator kept");
    solves.sample_size(10);
    for n in [16, 32, 48] {
        let (scene, numerics) = sphere(n);
        let mut operators = Operators::default();
        solves.bench_function(BenchmarkId::from_parameter(n), |bencher| {
            bencher.iter(|| {
                solve(&scene, &numerics, &Surfaces::new(), &mut operators).expect("an outcome")
            });
        });
    }
    solves.finish();
}

criterion_group!(seidel_benches, benches);
criterion_main!(seidel_benches);
