//! Prints a line of JSON for each job in a store: the time that was forecast for it, with and
//! without the operator that it may share with others, and the time that it took.
//! `scripts/bench-runner` holds them against each other.
//!
//! ```text
//! cargo run --release --example forecasts -- .tribosweep
//! ```

use std::collections::HashSet;
use std::error::Error;
use std::path::PathBuf;

use answers::forecast;
use store::Store;
use study::{Job, Record, Study};

fn main() -> Result<(), Box<dyn Error>> {
    let directory = std::env::args_os()
        .nth(1)
        .map(PathBuf::from)
        .ok_or("the directory of a store is missing")?;
    let reader = Store::read(&directory)?;
    let mut seen = HashSet::new();
    for name in reader.study_names()? {
        let definition = reader.study(&name)?.ok_or("a study is missing")?;
        let study = Study::from_large_definition(&definition)?;
        for (key, bytes) in reader.select(reader.keys()?) {
            let record = Record::decode(&bytes?)?;
            let job = Job::parse(&record.job)?;
            // A store holds the jobs of several studies; a job whose surface another one brought
            // cannot be forecast with those of this one.
            let Ok(forecast) = forecast(&job, study.surfaces()) else { continue };
            if !seen.insert(key) {
                continue;
            }
            let times = &record.provenance.times;
            let seconds = match times.is_empty() {
                true => record.provenance.seconds,
                false => times.iter().sum(),
            };
            println!(
                "{}",
                serde_json::json!({
                    "study": name, "key": key.to_string(), "forecast": forecast.seconds,
                    "assembly": forecast.assembly, "operator": forecast.operator.to_string(),
                    "elements": forecast.elements, "increments": forecast.increments,
                    "certified": record.is_certified(), "seconds": seconds,
                })
            );
        }
    }
    Ok(())
}
