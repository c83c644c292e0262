//! The inputs from which others are made, and their readers.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use answers::{Performed, perform};
use contact::Operators;
use contact::punch::ProfileKind;
use store::{ExportHeader, ExportWriter, ShardName, Store};
use study::job::PHYSICS_VERSION;
use study::surface::{self, MapReading, MissingRule};
use study::{Provenance, Record, Study, profile};

use crate::mutation::{Dice, changed};
use crate::{filters, studies};

/// An input for a reader.
pub(crate) struct Input {
    pub(crate) kind: InputKind,
    pub(crate) bytes: Vec<u8>,
}

/// The kind of an input, which says who reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum InputKind {
    Study,
    Map,
    Profile,
    Filter,
    Record,
    Message,
    Export,
}

impl InputKind {
    /// The kinds, each as often as its share of the inputs.
    pub(crate) const SHARES: [InputKind; 11] = [
        InputKind::Study,
        InputKind::Study,
        InputKind::Study,
        InputKind::Map,
        InputKind::Map,
        InputKind::Profile,
        InputKind::Filter,
        InputKind::Filter,
        InputKind::Record,
        InputKind::Message,
        InputKind::Export,
    ];
}

/// Inputs that are right, by their kind; those of texts stand with their readers.
pub(crate) struct Corpus {
    inputs: BTreeMap<InputKind, Vec<Vec<u8>>>,
}

/// A study whose result is a record of the corpus.
const SOLVED: &str = "name = \"solved\"
[scene]
foundation.base = { shear_modulus = \"80 GPa\", poisson = 0.3 }
punch = { shape = \"sphere\", radius = \"10 mm\" }
friction.mu = 0.3
loading.steps = [{ approach = \"1 um\" }, { shift_x = \"0.2 um\" }]
[numerics]
mesh = 6
";

const MAPS: [&str; 8] = [
    "0.0 1.0 2.0\n0.5 0.25 -1.5\n",
    "# Width: 1.0 mm\n# Height: 1.0 mm\n# Value units: m\n1e-6\t2e-6\n3e-6\t4e-6\n",
    "0;0,5;1\n1;1,5;-9999\n",
    "0 0 1.5\n0 1 2.5\n1 0 3.5\n1 1 4.5\n",
    "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 0.5\nNODATA_value -9999\n1 2\n3 -9999\n",
    "1.0D-6,2.0d-6,\n3.0D-6,nan,\n",
    "\u{feff}% x\n1 2 // y\n3 4 ; z\n",
    "bad 1 2\n--- 3 4\n1e38 5 6\n",
];

const PROFILES: [&str; 2] = [
    "0.0 0.0\n1.0 0.1\n2.0 0.4\n3.0 0.9\n4.0 1.6\n",
    "ColumnDef=X,Y\nXYPOINTS=3\n\n-1.0 0.0\n0.0 1.0\n1.0 0.0\n",
];

impl Corpus {
    /// Gathers the inputs from the repository and from one job.
    pub(crate) fn new() -> Result<Self, Box<dyn Error>> {
        let profiles = Path::new(env!("CARGO_MANIFEST_DIR")).join("sweeps/profiles");
        let mut inputs: BTreeMap<InputKind, Vec<Vec<u8>>> = BTreeMap::new();
        for (kind, texts) in [(InputKind::Map, &MAPS[..]), (InputKind::Profile, &PROFILES[..])] {
            inputs.insert(kind, texts.iter().map(|text| text.as_bytes().to_vec()).collect());
        }
        for name in ["MBench_S1002_v3.prw", "MBench_UIC60_v3.prr"] {
            inputs.entry(InputKind::Profile).or_default().push(std::fs::read(profiles.join(name))?);
        }
        inputs.entry(InputKind::Map).or_default().extend([npy("<f8", 8), npy(">f4", 4)]);
        inputs.insert(InputKind::Record, vec![record()?]);
        inputs.insert(InputKind::Message, messages());
        inputs.insert(InputKind::Export, vec![export(&record()?)?]);
        if !inputs[&InputKind::Export].iter().all(|bytes| is_export(bytes)) {
            return Err("the export of the corpus is none".into());
        }
        // What is refused before it is changed would try nothing.
        let is_read = |message: &Vec<u8>| runner::is_message(message) || store::is_message(message);
        if !inputs[&InputKind::Message].iter().all(is_read) {
            return Err("a message of the corpus is none".into());
        }
        Ok(Self { inputs })
    }

    /// Makes the input with a number; the same seed and number give the same input.
    pub(crate) fn input(&self, seed: u64, number: u64) -> Input {
        let seed = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ number;
        let mut dice = Dice::new(seed);
        let kind = dice.pick(&InputKind::SHARES);
        let bytes = match kind {
            InputKind::Study => studies::text(&mut dice).into_bytes(),
            InputKind::Filter => filters::text(&mut dice).into_bytes(),
            InputKind::Map
            | InputKind::Profile
            | InputKind::Record
            | InputKind::Message
            | InputKind::Export => changed(&self.inputs[&kind], &mut dice),
        };
        Input { kind, bytes }
    }

    /// Reads an input as the program does, and returns whether it was accepted.
    pub(crate) fn read(Input { kind, bytes }: &Input) -> bool {
        match kind {
            InputKind::Study => studies::read(&String::from_utf8_lossy(bytes)),
            InputKind::Map => {
                let mut is_accepted = surface::decode_surface(bytes).is_ok();
                for missing in [MissingRule::Fill, MissingRule::Exclude, MissingRule::Refuse] {
                    let reading = MapReading { unit: Some("um"), missing, ..MapReading::default() };
                    if let Ok(map) = surface::read(bytes, &reading) {
                        let stored = surface::encode_surface(&map.surface);
                        surface::decode_surface(&stored).expect("a map reads its own bytes");
                        is_accepted = true;
                    }
                }
                is_accepted
            }
            InputKind::Profile => {
                let mut is_accepted = profile::decode_profile(bytes).is_ok();
                for kind in [ProfileKind::Rail, ProfileKind::Wheel] {
                    if let Ok(read) = profile::read(bytes, kind) {
                        let stored = profile::encode_profile(&read.profile);
                        profile::decode_profile(&stored).expect("a profile reads its own bytes");
                        is_accepted = true;
                    }
                }
                is_accepted
            }
            InputKind::Filter => filters::read(&String::from_utf8_lossy(bytes)),
            InputKind::Record => Record::decode(bytes).is_ok_and(|record| {
                let _ = (record.key(), record.parse_job(), record.encode());
                true
            }),
            InputKind::Message => runner::is_message(bytes) || store::is_message(bytes),
            InputKind::Export => is_export(bytes),
        }
    }
}

/// Returns an NPY file of 2 × 3 numbers of a type.
fn npy(descr: &str, size: usize) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (2, 3), }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(std::iter::repeat_n(0x3f, 6 * size));
    bytes
}

/// Returns the bytes of the record of a small job.
fn record() -> Result<Vec<u8>, Box<dyn Error>> {
    let study = Study::parse(SOLVED, "solved.toml", &mut |_| Err("there are none".to_owned()))?;
    let job = study.point(0).ok_or("the study has no point")?.job;
    let Performed { ending, times, .. } =
        perform(&job, study.surfaces(), &mut Operators::default())?;
    let provenance = Provenance::timed("fuzz", 1.0, times);
    let (physics, job) = (PHYSICS_VERSION, job.canonical());
    Ok(Record { physics, job, ending, fields: None, provenance }.encode())
}

/// Returns an export with a study, a record and a file of fields.
fn export(record: &[u8]) -> Result<Vec<u8>, Box<dyn Error>> {
    let directory = tempfile::tempdir()?;
    let (file, store) =
        (directory.path().join("corpus.tribosweep"), directory.path().join("store"));
    let shard = Some(ShardName { study: "solved".to_owned(), index: 1, count: 2 });
    let mut writer =
        ExportWriter::open(&file, &ExportHeader { program: "0.1.0".to_owned(), shard })?;
    writer.put_study("solved", SOLVED.as_bytes())?;
    let store = Store::open(&store)?;
    let fields = store.blobs().put(&[7; 1000])?;
    writer.append(&Record::decode(record)?.key(), record, store.blobs(), [fields])?;
    writer.note(br#"{"done": 1, "finished": true}"#);
    writer.close()?;
    Ok(std::fs::read(&file)?)
}

/// Reads an export whole, from a file that has no name, and returns whether it is sound.
fn is_export(bytes: &[u8]) -> bool {
    let file = rustix::fs::memfd_create("export", rustix::fs::MemfdFlags::CLOEXEC)
        .map(std::fs::File::from)
        .expect("a file in memory can be made");
    std::io::Write::write_all(&mut &file, bytes).expect("a file in memory takes what is small");
    let path = format!("/proc/self/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&file));
    let Ok(reader) = Store::read(Path::new(&path)) else { return false };
    let _ = (reader.study_names(), reader.exports());
    reader.verify(|_, _| Vec::new()).is_ok_and(|found| found.is_sound())
}

/// Returns what a worker, a coordinator and a reader say, without the format versions before it.
fn messages() -> Vec<Vec<u8>> {
    // A result in the message, one in a file, and a failure; the worker has nothing left.
    let mut request = vec![3];
    request.extend([7, 0, 0, 0, 0, 0, 0, 0xe0, 0x3f, 0, 0, 2, 1, 2]);
    request.extend([251, 0x2c, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]);
    request.extend([9; 32]);
    request.extend([5, 8, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, b'n', b'o', 1]);
    let jobs = vec![0, 1, 1, 0, 1, 4];
    let keys = vec![0, 0];
    let records = [vec![2, 2], vec![9; 64]].concat();
    vec![request, jobs, keys, records]
}
