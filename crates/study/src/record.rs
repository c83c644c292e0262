//! The record that a job leaves, and the bytes of everything a store keeps.
//!
//! A record is `[version, deterministic part, provenance]`: the same job gives the same
//! deterministic part on any number of workers ([`Record::result_bytes`]); provenance says who
//! computed it, when and how fast. Every format begins with a version byte and is bincode's
//! standard configuration after it.

use contact::model::{Fields, Outcome, Status};
use contact::multiplicity::Multiplicity;
use contact::uniqueness::Bracket;
use contact::uniqueness::witness::Shown;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::job::{Job, JobError, JobKey, PHYSICS_VERSION};

/// How a job ended.
#[expect(clippy::large_enum_variant, reason = "nearly every record is of the large one")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Ending {
    /// It was computed; whether it counts as solved is in [`Outcome::status`].
    Finished(Outcome),
    /// It was searched for solutions; whether any was found is in [`Multiplicity::status`].
    Searched(Multiplicity),
    /// The end of its uniqueness set was looked for.
    Bracketed(Box<Bracketed>),
    /// It killed or outlived its workers and was set aside.
    Quarantined {
        /// What happened: a signal, a deadline, memory.
        reason: String,
        /// How often it was tried.
        attempts: u32,
    },
}

impl Ending {
    /// Whether it holds a solution; `None` for what was set aside.
    pub fn status(&self) -> Option<&Status> {
        match self {
            Ending::Finished(outcome) => Some(&outcome.status),
            Ending::Searched(found) => Some(&found.status),
            Ending::Bracketed(found) => Some(&found.status),
            Ending::Quarantined { .. } => None,
        }
    }

    /// Why it holds none.
    pub fn reason(&self) -> Option<&str> {
        match (self, self.status()) {
            (Ending::Quarantined { reason, .. }, _) | (_, Some(Status::Failed { reason })) => {
                Some(reason)
            }
            _ => None,
        }
    }
}

/// What came of looking for the end μ* of a uniqueness set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bracketed {
    /// Certified if both sides were verified by code of their own.
    pub status: Status,
    /// Both sides, with what it takes to verify them again.
    pub bracket: Option<Bracket>,
    /// What verifying the witness above has shown.
    pub shown: Option<Shown>,
}

/// Who computed a record, when and how fast. Nothing in here is reproducible.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of the program.
    pub program: String,
    /// Time that solving took \[s\]; of several times, the median.
    pub seconds: f64,
    /// Each time by itself, of a job that is solved several times \[s\].
    pub times: Vec<f64>,
    /// Number of the worker in its run.
    pub worker: u32,
    /// The attempt that gave this record, counted from 1.
    pub attempt: u32,
    /// When it was finished [s since 1970-01-01 UTC].
    pub finished: u64,
}

/// Where the bytes of a record's fields are.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kept {
    /// In a blob, whose name is their BLAKE3 digest.
    Blob([u8; 32]),
    /// In the record itself, compressed.
    Inside(Vec<u8>),
}

/// What a job leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Version of the physics that computed it; part of the job's key.
    pub physics: u32,
    /// The job's canonical text ([`Job::canonical`]).
    pub job: String,
    /// How it ended.
    pub ending: Ending,
    /// The bytes of its fields ([`encode_fields`]), if it left some.
    pub fields: Option<Kept>,
    /// Who computed it.
    pub provenance: Provenance,
}

/// Why bytes are not what they should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// There are no bytes.
    #[error("{what} is empty")]
    Empty {
        /// What was read.
        what: &'static str,
    },
    /// Another version of the program wrote it.
    #[error("{what} has format {found}, this program reads {}", formats(known))]
    Version {
        /// What was read.
        what: &'static str,
        /// The version found.
        found: u8,
        /// The versions known.
        known: &'static [u8],
    },
    /// The bytes do not decode.
    #[error("{what} does not decode: {reason}")]
    Malformed {
        /// What was read.
        what: &'static str,
        /// What is wrong.
        reason: String,
    },
}

/// Versions in words.
fn formats(known: &[u8]) -> String {
    let numbers: Vec<String> = known.iter().map(u8::to_string).collect();
    format!("{} {}", if known.len() == 1 { "format" } else { "formats" }, numbers.join(" and "))
}

/// Format of fields, surfaces and definitions of studies.
const VERSION: u8 = 1;

/// Format of records. 1 held a single load step, 2 no levels, 3 the digests of fields only.
const RECORD_VERSION: u8 = 4;

/// The last format before, which is read as well.
const OLDER_VERSION: u8 = 3;

/// The formats of records that are read.
const RECORD_VERSIONS: &[u8] = &[OLDER_VERSION, RECORD_VERSION];

/// Most bytes of a record that a store keeps: room for the 1000 increments that a loading path may
/// have.
pub const STORED_LIMIT: usize = 1 << 20;

/// Longest text or list in a record that is believed \[bytes\]; a corrupt length must not allocate.
const RECORD_LIMIT: usize = 16 << 20;

/// The same for fields and definitions of studies: six doubles for each element of the largest
/// grid, and room to spare.
pub(crate) const BLOB_LIMIT: usize = 2 << 30;

impl Record {
    /// The identity of the job that left it.
    pub fn key(&self) -> JobKey {
        JobKey::of(self.physics, &self.job)
    }

    /// The job that left it.
    pub fn parse_job(&self) -> Result<Job, JobError> {
        Job::parse(&self.job)
    }

    /// `certified`, `failed` or `quarantined`.
    pub fn status(&self) -> &'static str {
        match self.ending.status() {
            Some(Status::Certified) => "certified",
            Some(Status::Failed { .. }) => "failed",
            None => "quarantined",
        }
    }

    /// Whether it holds a solution.
    pub fn is_certified(&self) -> bool {
        self.ending.status() == Some(&Status::Certified)
    }

    /// What was computed, solved or not.
    pub fn outcome(&self) -> Option<&Outcome> {
        match &self.ending {
            Ending::Finished(outcome) => Some(outcome),
            Ending::Searched(_) | Ending::Bracketed(_) | Ending::Quarantined { .. } => None,
        }
    }

    /// What a search for solutions found.
    pub fn multiplicity(&self) -> Option<&Multiplicity> {
        match &self.ending {
            Ending::Searched(found) => Some(found),
            Ending::Finished(_) | Ending::Bracketed(_) | Ending::Quarantined { .. } => None,
        }
    }

    /// What came of looking for the end of a uniqueness set.
    pub fn bracketed(&self) -> Option<&Bracketed> {
        match &self.ending {
            Ending::Bracketed(found) => Some(found),
            Ending::Finished(_) | Ending::Searched(_) | Ending::Quarantined { .. } => None,
        }
    }

    /// Visits what the record would be if the path had ended after its first increment, its second
    /// and so on; the last visit sees the record itself. Increments before the one at which a path
    /// failed are certified.
    pub fn along_path(&self, mut visit: impl FnMut(&Record)) {
        let Some(outcome) = self.outcome() else { return };
        let (physics, fields, provenance) =
            (self.physics, self.fields.clone(), self.provenance.clone());
        let steps = Vec::with_capacity(outcome.steps.len());
        let path = Outcome {
            status: Status::Certified,
            levels: outcome.levels.clone(),
            steps,
            estimate: None,
            hertz: None,
            rail: None,
        };
        let mut partial = Record {
            physics,
            job: self.job.clone(),
            ending: Ending::Finished(path),
            fields,
            provenance,
        };
        for (at, step) in outcome.steps.iter().enumerate() {
            let Ending::Finished(path) = &mut partial.ending else { return };
            path.steps.push(*step);
            if at + 1 == outcome.steps.len() {
                (path.status, path.estimate, path.hertz, path.rail) =
                    (outcome.status.clone(), outcome.estimate, outcome.hertz, outcome.rail);
            }
            visit(&partial);
        }
    }

    /// Whether it was computed by the physics of this program.
    pub fn is_current(&self) -> bool {
        self.physics == PHYSICS_VERSION
    }

    /// The bytes of the deterministic part: equal for the same job, whoever computed it.
    pub fn result_bytes(&self) -> Vec<u8> {
        encode_as(RECORD_VERSION, &(self.physics, &self.job, &self.ending, &self.fields))
    }

    /// The bytes of the record: [`result_bytes`](Record::result_bytes), then the provenance.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = self.result_bytes();
        bytes.extend_from_slice(encode(&self.provenance).get(1..).unwrap_or_default());
        bytes
    }

    /// Reads what [`encode`](Record::encode) wrote.
    pub fn decode(bytes: &[u8]) -> Result<Record, DecodeError> {
        const WHAT: &str = "the record";
        type Parts<Fields> = ((u32, String, Ending, Option<Fields>), Provenance);
        let ((physics, job, ending, fields), provenance) = match bytes.first() {
            Some(&OLDER_VERSION) => {
                let ((physics, job, ending, digest), provenance) =
                    decode_as::<Parts<[u8; 32]>, RECORD_LIMIT>(RECORD_VERSIONS, WHAT, bytes)?;
                ((physics, job, ending, digest.map(Kept::Blob)), provenance)
            }
            _ => decode_as::<Parts<Kept>, RECORD_LIMIT>(RECORD_VERSIONS, WHAT, bytes)?,
        };
        if let Ending::Searched(found) = &ending {
            let count = found.solutions.len();
            for solution in &found.solutions {
                let distances = solution.distances.len();
                let misfit = (distances != count)
                    .then(|| format!("{distances} distances of a solution to {count}"));
                if let Some(reason) = misfit.or_else(|| misfit_of(&solution.fields)) {
                    return Err(DecodeError::Malformed { what: WHAT, reason });
                }
            }
        }
        Ok(Record { physics, job, ending, fields, provenance })
    }
}

/// The text of the job in the bytes of a record, without reading the rest; `None` unless this
/// program's physics computed it.
pub fn job_text(bytes: &[u8]) -> Option<&str> {
    let body = RECORD_VERSIONS.iter().find_map(|version| bytes.strip_prefix(&[*version]))?;
    let config = bincode::config::standard().with_limit::<RECORD_LIMIT>();
    let ((physics, job), _): ((u32, &str), usize) =
        bincode::serde::borrow_decode_from_slice(body, config).ok()?;
    (physics == PHYSICS_VERSION).then_some(job)
}

/// The bytes of fields.
pub fn encode_fields(fields: &Fields) -> Vec<u8> {
    encode(fields)
}

/// Reads what [`encode_fields`] wrote; every list has one value per element.
pub fn decode_fields(bytes: &[u8]) -> Result<Fields, DecodeError> {
    const WHAT: &str = "the field file";
    let fields: Fields = decode::<_, BLOB_LIMIT>(WHAT, bytes)?;
    match misfit_of(&fields) {
        Some(reason) => Err(DecodeError::Malformed { what: WHAT, reason }),
        None => Ok(fields),
    }
}

/// What is wrong with fields that have not one value per element.
fn misfit_of(fields: &Fields) -> Option<String> {
    let [nx, ny] = fields.shape.map(u64::from);
    let lists = [
        &fields.pressure,
        &fields.traction_x,
        &fields.traction_y,
        &fields.gap,
        &fields.slip_x,
        &fields.slip_y,
    ];
    let lengths = lists.iter().map(|list| list.len()).chain([fields.state.len()]);
    let length = lengths.into_iter().find(|length| *length as u64 != nx.saturating_mul(ny))?;
    Some(format!("{length} values on {nx} × {ny} elements"))
}

pub(crate) fn encode(value: &impl Serialize) -> Vec<u8> {
    encode_as(VERSION, value)
}

fn encode_as(version: u8, value: &impl Serialize) -> Vec<u8> {
    let mut bytes = vec![version];
    let body = bincode::serde::encode_to_vec(value, bincode::config::standard());
    bytes.extend(body.expect("plain data without skipped or borrowed parts always encodes"));
    bytes
}

pub(crate) fn decode<T: DeserializeOwned, const LIMIT: usize>(
    what: &'static str,
    bytes: &[u8],
) -> Result<T, DecodeError> {
    decode_as::<T, LIMIT>(&[VERSION], what, bytes)
}

fn decode_as<T: DeserializeOwned, const LIMIT: usize>(
    known: &'static [u8],
    what: &'static str,
    bytes: &[u8],
) -> Result<T, DecodeError> {
    let (version, body) = bytes.split_first().ok_or(DecodeError::Empty { what })?;
    if !known.contains(version) {
        return Err(DecodeError::Version { what, found: *version, known });
    }
    let malformed = |reason: String| DecodeError::Malformed { what, reason };
    let config = bincode::config::standard().with_limit::<LIMIT>();
    let (value, read) = bincode::serde::decode_from_slice(body, config)
        .map_err(|error| malformed(error.to_string()))?;
    match body.len() - read {
        0 => Ok(value),
        rest => Err(malformed(format!("{rest} bytes too many"))),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use contact::model::{
        Certificate, Hertz, Level, Method, Motion, Observables, RailContact, StepOutcome, WorkDone,
    };
    use contact::multiplicity::{Origin, Solution};
    use proptest::prelude::*;

    fn record(ending: Ending) -> Record {
        let provenance = Provenance {
            program: "0.1.0".into(),
            seconds: 0.25,
            times: vec![0.25, 0.5],
            worker: 1,
            attempt: 1,
            finished: 1_700_000_000,
        };
        Record {
            physics: PHYSICS_VERSION,
            job: crate::job::tests::job().canonical(),
            ending,
            fields: Some(Kept::Blob([7; 32])),
            provenance,
        }
    }

    /// Every figure of the last increment differs from every other, so that no two columns can be
    /// mistaken for each other.
    fn outcome(status: Status) -> Outcome {
        let first = StepOutcome {
            observables: Observables { load: 0.5, dissipation: 0.25, ..Observables::default() },
            work: WorkDone { iterations: 7, operator_applications: 8 },
            ..StepOutcome::default()
        };
        let last = StepOutcome {
            step: 1,
            cycle: 2,
            motion: Motion {
                approach: 31.0,
                shift_x: 32.0,
                shift_y: 33.0,
                tilt_x: 34.0,
                tilt_y: 35.0,
                twist: 36.0,
            },
            observables: Observables {
                load: 1.0,
                force_x: 2.0,
                force_y: 3.0,
                moment_x: 4.0,
                moment_y: 5.0,
                moment_z: 6.0,
                contact_area: 8.0,
                stick_area: 2.0,
                slip_area: 7.5,
                contact_elements: 9,
                stick_elements: 10,
                slip_elements: 11,
                patches: 24,
                sole_area: 10.0,
                largest_gap: 25.0,
                peak_pressure: 12.0,
                peak_traction: 13.0,
                energy: 14.0,
                dissipation: 15.0,
                external_work: 26.0,
                ceiling_elements: 16,
                edge_elements: 17,
                mesh_x: 18,
                mesh_y: 19,
                element_x: 20.0,
                element_y: 21.0,
            },
            certificate: Certificate {
                residual: 0.1,
                tension: 0.2,
                penetration: 0.3,
                gap_under_pressure: 0.4,
                cone_violation: 0.5,
                slip_angle: 0.6,
                force_imbalance: 0.7,
            },
            work: WorkDone { iterations: 22, operator_applications: 23 },
            route: contact::model::Way::NewtonAndSeidel,
        };
        let hertz = Hertz {
            semi_axis_a: 41.0,
            semi_axis_b: 42.0,
            area: 43.0,
            peak_pressure: 44.0,
            approach: 45.0,
        };
        let rail = RailContact {
            track: [51.0, 52.0, 53.0],
            rail: [54.0, 55.0],
            angle: 56.0,
            pressure_center: [57.0, 58.0, 59.0],
            wheelset_height: 60.0,
        };
        let coarse =
            Level { elements: [9, 10], work: WorkDone { iterations: 0, operator_applications: 5 } };
        let figures = contact::model::FigureErrors {
            load: Some(71.0),
            approach: Some(72.0),
            tangential_force: Some(73.0),
            shift: Some(74.0),
            moment: Some(75.0),
            rotation: Some(76.0),
            peak_pressure: Some(77.0),
            contact_area: Some(78.0),
            stick_area: Some(79.0),
            pressure: Some(80.0),
            traction: Some(81.0),
        };
        let estimate = contact::model::Estimate { figures, solver: 90.0 };
        Outcome {
            status,
            levels: vec![coarse],
            steps: vec![first, last],
            estimate: Some(estimate),
            hertz: Some(hertz),
            rail: Some(rail),
        }
    }

    pub(crate) fn solved() -> Record {
        record(Ending::Finished(outcome(Status::Certified)))
    }

    pub(crate) fn failed() -> Record {
        record(Ending::Finished(outcome(Status::Failed {
            reason: "residual 0.1 after 22 iterations".into(),
        })))
    }

    pub(crate) fn quarantined() -> Record {
        record(Ending::Quarantined { reason: "killed by SIGKILL".into(), attempts: 3 })
    }

    /// Two solutions.
    fn searched() -> Record {
        let solution = |distances: [f64; 2], origin: Origin| Solution {
            motion: Motion { approach: 1.0, ..Motion::default() },
            observables: Observables { load: 2.0, ..Observables::default() },
            certificate: Certificate { residual: 3.0, ..Certificate::default() },
            origin,
            method: Method::Newton,
            reached: 4,
            error: 5.0,
            index: Some(-1),
            distances: distances.to_vec(),
            fields: fields(),
        };
        record(Ending::Searched(Multiplicity {
            status: Status::Certified,
            before: vec![StepOutcome::default()],
            solutions: vec![
                solution([0.0, 6.0], Origin::Hertz),
                solution([6.0, 0.0], Origin::Between([0, 1])),
            ],
            starts: 7,
            failed: 8,
            beyond: 9,
            index_sum: Some(-2),
            work: WorkDone { iterations: 10, operator_applications: 11 },
            factorisations: 12,
        }))
    }

    fn fields() -> Fields {
        let list = |x: f64| vec![x; 6];
        Fields {
            shape: [3, 2],
            origin: [-1.0, -2.0],
            element: [0.5, 0.25],
            pressure: list(1.0),
            traction_x: list(2.0),
            traction_y: list(3.0),
            gap: list(4.0),
            slip_x: list(5.0),
            slip_y: list(6.0),
            state: vec![0, 1, 2, 3, 1, 0],
        }
    }

    #[test]
    fn round_trip() {
        for record in [solved(), failed(), quarantined(), searched()] {
            assert_eq!(Record::decode(&record.encode()), Ok(record.clone()));
            assert_eq!(record.key(), record.parse_job().unwrap().key());
        }
        assert_eq!(decode_fields(&encode_fields(&fields())), Ok(fields()));
    }

    #[test]
    fn provenance_leaves_the_result_alone() {
        let one = solved();
        let mut other = solved();
        other.provenance =
            Provenance { seconds: 9.0, worker: 7, attempt: 2, ..Provenance::default() };
        assert_eq!(one.result_bytes(), other.result_bytes());
        assert_ne!(one.encode(), other.encode());
        other.fields = None;
        assert_ne!(one.result_bytes(), other.result_bytes());
    }

    #[test]
    fn the_format_before_is_read() {
        for record in [solved(), Record { fields: None, ..failed() }] {
            let digest = record.fields.as_ref().map(|_| [7_u8; 32]);
            let mut bytes =
                encode_as(OLDER_VERSION, &(record.physics, &record.job, &record.ending, &digest));
            bytes.extend_from_slice(&encode(&record.provenance)[1..]);
            assert_eq!(Record::decode(&bytes).as_ref(), Ok(&record));
            assert_eq!(job_text(&bytes), Some(&*record.job));
        }
    }

    /// A change of these bytes is a change of the format: it needs a new version and a way to read
    /// the old one.
    #[test]
    fn golden_bytes() {
        insta::assert_snapshot!("record", hexadecimal(&solved().encode()));
        insta::assert_snapshot!("record_failed", hexadecimal(&failed().encode()));
        insta::assert_snapshot!("record_quarantined", hexadecimal(&quarantined().encode()));
        insta::assert_snapshot!("record_searched", hexadecimal(&searched().encode()));
        insta::assert_snapshot!("fields", hexadecimal(&encode_fields(&fields())));
    }

    fn hexadecimal(bytes: &[u8]) -> String {
        let line = |line: &[u8]| line.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        bytes.chunks(32).map(line).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn what_is_malformed_says_so() {
        let message = |bytes: &[u8]| Record::decode(bytes).unwrap_err().to_string();
        assert_eq!(message(&[]), "the record is empty");
        assert_eq!(message(&[9, 1]), "the record has format 9, this program reads formats 3 and 4");
        assert_eq!(message(&[1, 1]), "the record has format 1, this program reads formats 3 and 4");
        let mut long = solved().encode();
        long.push(0);
        assert_eq!(message(&long), "the record does not decode: 1 bytes too many");
        // a text of 2⁶⁴ − 1 bytes
        let huge = [&[RECORD_VERSION, 1, 253], &[0xff; 8][..]].concat();
        assert!(message(&huge).starts_with("the record does not decode"));
        let mut short = fields();
        short.gap.pop();
        assert_eq!(
            decode_fields(&encode_fields(&short)).unwrap_err().to_string(),
            "the field file does not decode: 5 values on 3 × 2 elements"
        );
        short.shape = [u32::MAX; 2];
        assert!(decode_fields(&encode_fields(&short)).is_err());
        let ragged = |change: fn(&mut Solution)| {
            let mut record = searched();
            let Ending::Searched(found) = &mut record.ending else { panic!() };
            change(&mut found.solutions[1]);
            message(&record.encode())
        };
        assert_eq!(
            ragged(|solution| solution.distances.truncate(1)),
            "the record does not decode: 1 distances of a solution to 2"
        );
        assert_eq!(
            ragged(|solution| solution.fields.gap.truncate(5)),
            "the record does not decode: 5 values on 3 × 2 elements"
        );
    }

    #[test]
    fn every_shorter_record_is_refused() {
        let bytes = solved().encode();
        assert!((0..bytes.len()).all(|length| Record::decode(&bytes[..length]).is_err()));
        let bytes = encode_fields(&fields());
        assert!((0..bytes.len()).all(|length| decode_fields(&bytes[..length]).is_err()));
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_never_panic(mut bytes in proptest::collection::vec(any::<u8>(), 0..400), versioned: bool) {
            if let (Some(first), true) = (bytes.first_mut(), versioned) {
                *first = RECORD_VERSION;
            }
            let _ = Record::decode(&bytes);
            if let (Some(first), true) = (bytes.first_mut(), versioned) {
                *first = VERSION;
            }
            let _ = decode_fields(&bytes);
        }

        #[test]
        fn flipped_bits_never_panic(at in any::<prop::sample::Index>(), bit in 0u8..8, which in 0usize..4) {
            let mut bytes = [solved(), failed(), quarantined(), searched()][which].encode();
            let at = at.index(bytes.len());
            bytes[at] ^= 1 << bit;
            if let Ok(record) = Record::decode(&bytes) {
                let _ = (record.parse_job(), record.multiplicity().map(Multiplicity::furthest));
            }
            let mut bytes = encode_fields(&fields());
            let at = at % bytes.len();
            bytes[at] ^= 1 << bit;
            let _ = decode_fields(&bytes);
        }
    }
}
