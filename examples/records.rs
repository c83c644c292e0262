//! Makes exports of records that look like results, for `scripts/scale`: one scene is solved, and
//! its result stands under the jobs of many others.
//!
//! ```text
//! cargo run --release --example records -- DIRECTORY RECORDS FILES
//! ```

use std::error::Error;
use std::path::{Path, PathBuf};

use answers::perform;
use contact::Operators;
use identity::KeptFields;
use store::{ExportHeader, ExportWriter, ShardName, Store};
use study::job::PHYSICS_VERSION;
use study::{Provenance, Record, Study};

/// The size of the fields of a small scene when they are compressed \[bytes\].
const FIELDS: usize = 2000;

/// A study of 10⁶ points, each a matter of a millisecond.
const STUDY: &str = r#"
name = "many"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "50 mm" }
[numerics]
mesh = 8
[sweep]
"friction.mu" = { from = 0.01, to = 0.9, count = 1000 }
"loading.steps[0].approach" = { from = "1 um", to = "20 um", count = 1000 }
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [directory, records, files] = &words[..] else {
        return Err("give a directory and the numbers of records and files".into());
    };
    let (directory, records, files) =
        (PathBuf::from(directory), records.parse::<usize>()?, files.parse::<u32>()?);
    let study = Study::parse_sharded(STUDY, "many.toml", &mut |_| Err("none".to_owned()))?;
    let point = study.point(0).ok_or("there is no point")?;
    let performed = perform(&point.job, study.surfaces(), &mut Operators::default())?;
    let scratch = tempfile::tempdir()?;
    let store = Store::open(scratch.path())?;
    let model = Record {
        physics: PHYSICS_VERSION,
        job: String::new(),
        ending: performed.ending,
        fields: None,
        provenance: Provenance::timed(env!("CARGO_PKG_VERSION"), 1e-3, performed.times),
    };
    for index in 1..=files {
        let shard = ShardName { study: study.name().to_owned(), index, count: files };
        write(&directory, shard, &study, &store, &model, records)?;
    }
    Ok(())
}

/// Writes the export of a shard.
fn write(
    directory: &Path,
    shard: ShardName,
    study: &Study,
    store: &Store,
    model: &Record,
    records: usize,
) -> Result<(), Box<dyn Error>> {
    let ShardName { study: name, index, count } = &shard;
    let path = directory.join(format!("{name}.{index}-of-{count}.tribosweep"));
    let (first, last) = (u64::from(*index - 1), u64::from(*index));
    let part = |end: u64| (records as u64 * end / u64::from(*count)) as usize;
    let header =
        ExportHeader { program: env!("CARGO_PKG_VERSION").to_owned(), shard: Some(shard.clone()) };
    let mut writer = ExportWriter::open(&path, &header)?;
    writer.put_study(name, &study.definition())?;
    let mut random = fastrand::Rng::with_seed(u64::from(*index));
    let mut dice = std::iter::repeat_with(|| random.u8(..));
    for number in part(first)..part(last) {
        let job = study.point(number).ok_or("a point is missing")?.job.canonical();
        // Results of different scenes do not compress into each other.
        let fields = Some(KeptFields::Inside(dice.by_ref().take(FIELDS).collect()));
        let record = Record { job, fields, ..model.clone() };
        writer.append(&record.key(), &record.encode(), store.blobs(), [])?;
    }
    writer.note(br#"{"finished": true}"#);
    Ok(writer.flush()?)
}
