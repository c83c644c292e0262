//! What travels between coordinator and worker, and between `effects` and the process that solves
//! for it.

use anyhow::{Context, Result};
use contact::model::{Outcome, Shape};
use contact::punch::Surfaces;
use serde::{Deserialize, Serialize};
use study::profile::{decode_profile, encode_profile};
use study::surface::{decode_surface, encode_surface};
use study::{Ending, Job};

/// A job on its way to a worker: its canonical text and what it names.
#[derive(Serialize, Deserialize)]
struct Order {
    job: String,
    height_maps: Vec<(String, Vec<u8>)>,
    profiles: Vec<(String, Vec<u8>)>,
}

/// What a worker sends back.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Answer {
    /// What came of it, the bytes of the fields if it has some of its own, and how long each time
    /// took if that is asked.
    Ended { ending: Box<Ending>, fields: Option<Vec<u8>>, times: Vec<f64> },
    /// The scene cannot be bound to its grid.
    Refused(String),
}

/// What the process that solves says.
#[derive(Serialize, Deserialize)]
pub(crate) struct Measurement {
    pub(crate) seconds: Vec<f64>,
    pub(crate) bytes: Option<u64>,
    pub(crate) outcome: Outcome,
    pub(crate) fields: Vec<u8>,
}

/// Encodes a job for a worker.
pub(crate) fn order(job: &Job, canonical: String, surfaces: &Surfaces) -> Result<Vec<u8>> {
    let map = |name: &String| Some((name.clone(), encode_surface(surfaces.get(name)?)));
    let profile = |name: &String| Some((name.clone(), encode_profile(surfaces.profile(name)?)));
    let (height_maps, profiles) = match job.case().map(|case| &case.scene.punch.shape) {
        Some(Shape::HeightMap { surface, .. }) => (map(surface).into_iter().collect(), Vec::new()),
        Some(Shape::WheelOnRail(wheel)) => {
            (Vec::new(), [&wheel.wheel, &wheel.rail].into_iter().filter_map(profile).collect())
        }
        _ => (Vec::new(), Vec::new()),
    };
    encode(&Order { job: canonical, height_maps, profiles })
}

/// Decodes an [`order`].
pub(crate) fn ordered(payload: &[u8]) -> Result<(Job, Surfaces)> {
    let (order, _): (Order, usize) =
        bincode::serde::decode_from_slice(payload, bincode::config::standard())?;
    let job = Job::parse(&order.job)?;
    let mut surfaces = Surfaces::new();
    for (name, bytes) in order.height_maps {
        surfaces.insert(name, decode_surface(&bytes)?.into());
    }
    for (name, bytes) in order.profiles {
        surfaces.insert_profile(name, decode_profile(&bytes)?.into());
    }
    Ok((job, surfaces))
}

/// Decodes what a worker sent.
pub(crate) fn answer(bytes: &[u8]) -> Result<Answer> {
    let (answer, _) = bincode::serde::decode_from_slice(bytes, bincode::config::standard())
        .context("a worker's answer does not decode")?;
    Ok(answer)
}

pub(crate) fn encode(value: &impl Serialize) -> Result<Vec<u8>> {
    Ok(bincode::serde::encode_to_vec(value, bincode::config::standard())?)
}
