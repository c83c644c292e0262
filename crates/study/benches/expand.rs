//! Measures the way from a study's text to the keys of 100 000 jobs.

use criterion::{Criterion, criterion_group, criterion_main};

use study::Study;

const STUDY: &str = r#"
name = "large"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
loading.steps = [{ approach = "1 um" }]
[numerics]
mesh = 16
[sweep]
friction.mu = { from = 0, to = 1, count = 100 }
foundation.base.poisson = { from = 0, to = 0.5, count = 100 }
"loading.steps[0].approach" = { log = true, from = "1 nm", to = "1 um", count = 10 }
"#;

fn read(text: &str) -> Study {
    Study::parse(text, "large.toml", &mut |_| Err(String::new()))
        .unwrap_or_else(|error| panic!("{error}"))
}

fn expand(c: &mut Criterion) {
    c.bench_function("read and check 100 000 points", |b| b.iter(|| read(STUDY)));
    let study = read(STUDY);
    assert_eq!(study.len(), 100_000);
    c.bench_function("expand 100 000 points with keys", |b| b.iter(|| study.points()));
    let record = study::Record {
        physics: 1,
        job: study.points()[0].job.canonical(),
        ending: study::Ending::Quarantined { reason: "killed".to_owned(), attempts: 3 },
        fields: None,
        provenance: study::Provenance::default(),
    };
    let bytes = record.encode();
    c.bench_function("decode a record", |b| b.iter(|| study::Record::decode(&bytes)));
}

criterion_group!(benches, expand);
criterion_main!(benches);
