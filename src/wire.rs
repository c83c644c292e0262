//! Messages between coordinator and worker, and between `effects` and the process that solves for
//! it.

use anyhow::{Context, Result};
use contact::model::{Outcome, Shape};
use contact::punch::Surfaces;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_bytes::ByteBuf;
use study::Job;
use study::profile::{decode_profile, encode_profile};
use study::surface::{decode_surface, encode_surface};

/// The limit of the size of a message \[bytes\]: the fields of the largest grid, and room to spare.
const LARGEST: usize = 3 << 30;

/// A job on its way to a worker: its canonical text and the surfaces that it names, encoded.
#[derive(Serialize, Deserialize)]
struct Order {
    job: String,
    height_maps: Vec<(String, ByteBuf)>,
    profiles: Vec<(String, ByteBuf)>,
}

/// A job as it arrives.
pub(crate) struct OrderedJob {
    pub(crate) job: Job,
    /// The surfaces that the job names.
    pub(crate) surfaces: Surfaces,
}

/// The reply of a worker.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum JobReply {
    /// The job has ended.
    Ended {
        /// The bytes of the ending.
        #[serde(with = "serde_bytes")]
        ending: Vec<u8>,
        /// The bytes of the fields, if the job leaves some beside its ending.
        #[serde(with = "serde_bytes")]
        fields: Option<Vec<u8>>,
        /// The time that each repetition took, for a job that is timed \[s\].
        times: Vec<f64>,
    },
    /// The scene cannot be bound to its grid, for this reason.
    Refused(String),
}

/// The reply of the process that solves a job several times.
#[derive(Serialize, Deserialize)]
pub(crate) struct Measurement {
    /// The time that each solve took \[s\].
    pub(crate) seconds: Vec<f64>,
    /// The memory that solving took \[bytes\], where the system says it.
    pub(crate) bytes: Option<u64>,
    pub(crate) outcome: Outcome,
    /// The bytes of the fields.
    #[serde(with = "serde_bytes")]
    pub(crate) fields: Vec<u8>,
}

/// Encodes the canonical text of a job for a worker, with the surfaces that the job names, if it
/// may name some.
pub(crate) fn order(job: Option<&Job>, canonical: String, surfaces: &Surfaces) -> Result<Vec<u8>> {
    let map =
        |name: &String| Some((name.clone(), ByteBuf::from(encode_surface(surfaces.get(name)?))));
    let profile = |name: &String| {
        Some((name.clone(), ByteBuf::from(encode_profile(surfaces.profile(name)?))))
    };
    let (height_maps, profiles) = match job.and_then(Job::case).map(|case| &case.scene.punch.shape)
    {
        Some(Shape::HeightMap { surface, .. }) => (map(surface).into_iter().collect(), Vec::new()),
        Some(Shape::WheelOnRail(wheel)) => {
            (Vec::new(), [&wheel.wheel, &wheel.rail].into_iter().filter_map(profile).collect())
        }
        _ => (Vec::new(), Vec::new()),
    };
    encode(&Order { job: canonical, height_maps, profiles })
}

/// Decodes an [`order`].
pub(crate) fn decode_order(payload: &[u8]) -> Result<OrderedJob> {
    let order: Order = decode(payload)?;
    let job = Job::parse(&order.job)?;
    let mut surfaces = Surfaces::new();
    for (name, bytes) in order.height_maps {
        surfaces.insert(name, decode_surface(&bytes)?.into());
    }
    for (name, bytes) in order.profiles {
        surfaces.insert_profile(name, decode_profile(&bytes)?.into());
    }
    Ok(OrderedJob { job, surfaces })
}

/// Decodes the reply of a worker.
pub(crate) fn decode_reply(bytes: &[u8]) -> Result<JobReply> {
    decode(bytes).context("a worker's answer does not decode")
}

/// Decodes the reply of the process that solves a job several times.
pub(crate) fn decode_measurement(bytes: &[u8]) -> Result<Measurement> {
    decode(bytes)
}

/// Encodes a message.
pub(crate) fn encode(message: &impl Serialize) -> Result<Vec<u8>> {
    Ok(bincode::serde::encode_to_vec(message, bincode::config::standard())?)
}

/// Decodes a message. A length in garbage is missed before so much is asked of the memory.
fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T> {
    let layout = bincode::config::standard().with_limit::<LARGEST>();
    Ok(bincode::serde::decode_from_slice(bytes, layout)?.0)
}
