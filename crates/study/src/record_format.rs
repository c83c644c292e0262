//! The bytes of records and of fields.
//!
//! A record is `[version, deterministic part, provenance]`. The same job gives the same
//! deterministic part on any number of workers ([`Record::result_bytes`]). The provenance names the
//! worker, the time and the speed of the computation. What a scene has further asked for
//! ([`Further`]) stands between the two, in a format of its own: the bytes of other records and
//! fields are those of the program before.

use serde::Deserialize;

use contact::model::{Fields, Further, FurtherFields};
use identity::KeptFields;

use crate::encoding::{BLOB_LIMIT, DecodeError, VERSION, decode, decode_as, encode, encode_as};
use crate::job::PHYSICS_VERSION;
use crate::provenance::{OlderProvenance, Provenance};
use crate::record::{Ending, Record};

/// The format of records. Format 1 held a single load step, 2 no levels, 3 the digests of fields
/// only, 4 no account of the run.
const RECORD_VERSION: u8 = 5;

/// The format of records with further results, which is otherwise the same.
const WITH_FURTHER: u8 = 6;

/// The format before, which is read as well. The deterministic part has not changed since.
const WITHOUT_RUN: u8 = 4;

/// The format before that, which is read as well.
const ONLY_DIGESTS: u8 = 3;

/// The formats of records that are read.
const RECORD_VERSIONS: &[u8] = &[ONLY_DIGESTS, WITHOUT_RUN, RECORD_VERSION, WITH_FURTHER];

/// The format of fields with further ones beside them.
const FIELDS_WITH_FURTHER: u8 = 2;

/// The formats of fields that are read.
const FIELDS_VERSIONS: &[u8] = &[VERSION, FIELDS_WITH_FURTHER];

/// The longest text or list in a record that is believed \[bytes\]; a corrupt length must not
/// allocate.
const RECORD_LIMIT: usize = 16 << 20;

/// The deterministic part of a record as it is stored.
#[derive(Deserialize)]
struct StoredResult<Fields> {
    physics: u32,
    job: String,
    ending: Ending,
    fields: Option<Fields>,
}

impl Record {
    /// Returns the bytes of the deterministic part, which are equal for the same job whoever
    /// computed it. They begin with the format since which they have not changed.
    pub fn result_bytes(&self) -> Vec<u8> {
        let result = (self.physics, &self.job, &self.ending, &self.fields);
        let further = self.ending.further();
        if further.is_empty() {
            encode_as(WITHOUT_RUN, &result)
        } else {
            encode_as(WITH_FURTHER, &(result, further))
        }
    }

    /// Returns the bytes of the record: the format, what follows it in
    /// [`result_bytes`](Record::result_bytes), then the provenance.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = self.result_bytes();
        bytes[0] = bytes[0].max(RECORD_VERSION);
        bytes.extend_from_slice(encode(&self.provenance).get(1..).unwrap_or_default());
        bytes
    }

    /// Reads the bytes that [`encode`](Record::encode) wrote, or those of the formats before.
    ///
    /// # Errors
    ///
    /// Returns an error if the bytes do not decode, or if the fields of a solution do not fit its
    /// grid.
    pub fn decode(bytes: &[u8]) -> Result<Record, DecodeError> {
        const ITEM: &str = "the record";
        let mut further = Further::default();
        let (result, provenance) = match bytes.first() {
            Some(&ONLY_DIGESTS) => {
                let (result, older) = decode_as::<
                    (StoredResult<[u8; 32]>, OlderProvenance),
                    RECORD_LIMIT,
                >(RECORD_VERSIONS, ITEM, bytes)?;
                let StoredResult { physics, job, ending, fields } = result;
                let fields = fields.map(KeptFields::Blob);
                (StoredResult { physics, job, ending, fields }, Provenance::from(older))
            }
            Some(&WITHOUT_RUN) => {
                let (result, older) =
                    decode_as::<(_, OlderProvenance), RECORD_LIMIT>(RECORD_VERSIONS, ITEM, bytes)?;
                (result, Provenance::from(older))
            }
            Some(&WITH_FURTHER) => {
                let (result, found, provenance) =
                    decode_as::<_, RECORD_LIMIT>(RECORD_VERSIONS, ITEM, bytes)?;
                further = found;
                (result, provenance)
            }
            _ => decode_as::<_, RECORD_LIMIT>(RECORD_VERSIONS, ITEM, bytes)?,
        };
        let StoredResult { physics, job, mut ending, fields } = result;
        ending.take_further(further);
        if let Ending::Searched(found) = &ending {
            let count = found.solutions.len();
            for solution in &found.solutions {
                let distances = solution.distances.len();
                let misfit = (distances != count)
                    .then(|| format!("{distances} distances of a solution to {count}"));
                if let Some(reason) = misfit.or_else(|| misfit_of(&solution.fields)) {
                    return Err(DecodeError::Malformed { item: ITEM, reason });
                }
            }
        }
        Ok(Record { physics, job, ending, fields, provenance })
    }
}

/// Returns the text of the job in the bytes of a record without reading the rest; `None` unless
/// this program's physics computed it.
pub fn job_text(bytes: &[u8]) -> Option<&str> {
    let body = RECORD_VERSIONS.iter().find_map(|version| bytes.strip_prefix(&[*version]))?;
    let config = bincode::config::standard().with_limit::<RECORD_LIMIT>();
    let ((physics, job), _): ((u32, &str), usize) =
        bincode::serde::borrow_decode_from_slice(body, config).ok()?;
    (physics == PHYSICS_VERSION).then_some(job)
}

/// Returns the bytes of an ending with all that its outcome has.
pub fn encode_ending(ending: &Ending) -> Vec<u8> {
    encode(&(ending, ending.further()))
}

/// Reads the bytes that [`encode_ending`] wrote.
///
/// # Errors
///
/// Returns an error if the bytes do not decode.
pub fn decode_ending(bytes: &[u8]) -> Result<Ending, DecodeError> {
    let (mut ending, further): (Ending, Further) =
        decode::<_, BLOB_LIMIT>("the ending of a job", bytes)?;
    ending.take_further(further);
    Ok(ending)
}

/// Returns the bytes of fields.
pub fn encode_fields(fields: &Fields) -> Vec<u8> {
    if fields.further.is_empty() {
        encode(fields)
    } else {
        encode_as(FIELDS_WITH_FURTHER, &(fields, &fields.further))
    }
}

/// Reads the bytes that [`encode_fields`] wrote.
///
/// # Errors
///
/// Returns an error if the bytes do not decode, or if a list has not one value for each element.
pub fn decode_fields(bytes: &[u8]) -> Result<Fields, DecodeError> {
    const ITEM: &str = "the field file";
    let fields: Fields = if bytes.first() == Some(&FIELDS_WITH_FURTHER) {
        let (fields, further): (Fields, FurtherFields) =
            decode_as::<_, BLOB_LIMIT>(FIELDS_VERSIONS, ITEM, bytes)?;
        Fields { further, ..fields }
    } else {
        decode_as::<_, BLOB_LIMIT>(FIELDS_VERSIONS, ITEM, bytes)?
    };
    match misfit_of(&fields) {
        Some(reason) => Err(DecodeError::Malformed { item: ITEM, reason }),
        None => Ok(fields),
    }
}

/// Describes the fault of fields that have not one value for each element; `None` if they have.
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
    let further = [&fields.further.wear_depth].into_iter().filter(|list| !list.is_empty());
    let lengths = lists.into_iter().chain(further).map(|list| list.len());
    let lengths = lengths.chain([fields.state.len()]);
    let length = lengths.into_iter().find(|length| *length as u64 != nx.saturating_mul(ny))?;
    Some(format!("{length} values on {nx} × {ny} elements"))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use contact::model::{
        Foundation, ImposedCreepages, Interior, InteriorQuestion, LargestStress, Layer, Loading,
        PlanePeaks, PointStress, Rolling, RollingDirection, RollingHistory, Scene, Step, Stress,
        StressPeak, Wear, Worn,
    };
    use contact::multiplicity::{Multiplicity, Solution};
    use identity::STORED_LIMIT;

    use super::*;
    use crate::job::Job;
    use crate::record::tests::{failed, fields, quarantined, searched, solved};

    #[test]
    fn round_trip() {
        for record in [solved(), failed(), quarantined(), searched(), worn()] {
            assert_eq!(Record::decode(&record.encode()), Ok(record.clone()));
            assert_eq!(record.key(), record.parse_job().unwrap().key());
        }
        for fields in [fields(), worn_fields()] {
            assert_eq!(decode_fields(&encode_fields(&fields)), Ok(fields));
        }
        assert_eq!(decode_ending(&encode_ending(&worn().ending)), Ok(worn().ending));
    }

    /// Returns a record with results that only some scenes ask for.
    fn worn() -> Record {
        let mut record = solved();
        let wear = vec![Worn { depth: 91.0, volume: 92.0 }];
        let leading_edges = vec![Some(93.0), None];
        record.ending.take_further(Further { wear, leading_edges, interior: Some(interior()) });
        record
    }

    fn interior() -> Interior {
        let peak = StressPeak { stress: 94.0, place: [95.0, 96.0, 97.0] };
        let largest = LargestStress { surface: peak, below: Some(peak) };
        Interior {
            von_mises: Some(largest),
            tresca: Some(LargestStress { below: None, ..largest }),
            searched: Some([98.0, 99.0]),
            planes: vec![PlanePeaks { depth: 100.0, von_mises: peak, tresca: peak }],
            points: vec![PointStress { place: [101.0; 3], stress: Stress::default() }],
            residual: Some(102.0),
        }
    }

    fn worn_fields() -> Fields {
        Fields { further: FurtherFields { wear_depth: vec![7.0; 6] }, ..fields() }
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
    fn the_formats_before_are_read() {
        for mut record in [solved(), Record { fields: None, ..failed() }] {
            record.provenance.run = None;
            let Provenance { program, seconds, times, worker, attempt, finished, .. } =
                &record.provenance;
            let provenance = encode(&(program, seconds, times, worker, attempt, finished));
            let digest = record.fields.as_ref().map(|_| [7_u8; 32]);
            let before =
                encode_as(ONLY_DIGESTS, &(record.physics, &record.job, &record.ending, &digest));
            for mut bytes in [before, record.result_bytes()] {
                bytes.extend_from_slice(&provenance[1..]);
                assert_eq!(Record::decode(&bytes).as_ref(), Ok(&record));
                assert_eq!(job_text(&bytes), Some(&*record.job));
            }
        }
    }

    /// This is a record of format 4 as a program of that time wrote it.
    #[test]
    fn a_record_without_the_account_of_its_run_is_read() {
        let text: String = RECORD_OF_FORMAT_4.split_whitespace().collect();
        let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16);
        let bytes: Vec<u8> = text.as_bytes().chunks(2).map(|pair| byte(pair).unwrap()).collect();
        let mut expected = solved();
        expected.provenance.run = None;
        let record = Record::decode(&bytes).unwrap();
        assert_eq!(record, expected);
        // The deterministic part is the same to the last byte.
        assert!(bytes.starts_with(&record.result_bytes()));
    }

    const RECORD_OF_FORMAT_4: &str = include_str!("record_format/format_4.hex");

    /// The longest path with everything that a scene can ask for fits into a store, with room for
    /// the names of its surfaces.
    #[test]
    fn the_largest_record_of_a_path_is_kept() {
        const LONG: f64 = -1.234_567_890_123_456_7e-300;
        let rolling = Rolling {
            creepage_x: Some(LONG),
            creepage_y: Some(LONG),
            spin: Some(LONG),
            spin_center: LONG,
            direction: RollingDirection::Backward,
            dq: Some(LONG),
            distance: None,
            history: RollingHistory::Transient,
            imposed: ImposedCreepages::default(),
        };
        let step = Step {
            normal_force: Some(LONG),
            moment_x: Some(LONG),
            moment_y: Some(LONG),
            rolling: Some(rolling),
            ..Step::default()
        };
        let Job::Solve(mut case) = crate::job::tests::job() else { panic!("a solve") };
        let layer = Layer { shear_modulus: LONG, poisson: LONG, thickness: LONG };
        let question = InteriorQuestion {
            maximum: true,
            depths: vec![LONG; InteriorQuestion::MOST_DEPTHS],
            points: vec![[LONG; 3]; InteriorQuestion::MOST_POINTS],
        };
        case.scene = Scene {
            foundation: Foundation {
                layers: vec![layer; Foundation::MAX_LAYERS],
                ..case.scene.foundation
            },
            wear: Some(Wear { coefficient: LONG, update: true, repeat: 1_000_000 }),
            loading: Loading {
                steps: vec![step; Loading::MAX_INCREMENTS as usize],
                cycle_from: Some(0),
                cycles: 1,
            },
            interior: Some(question),
            ..case.scene
        };
        let mut record = solved();
        record.job = Job::Solve(case).canonical();
        record.fields = Some(KeptFields::Inside(vec![0; 16 << 10]));
        let Ending::Finished(outcome) = &mut record.ending else { panic!("a path") };
        let mut end = *outcome.last().unwrap();
        let counts = [
            &mut end.observables.contact_elements,
            &mut end.observables.stick_elements,
            &mut end.observables.slip_elements,
            &mut end.observables.patches,
            &mut end.observables.ceiling_elements,
            &mut end.observables.edge_elements,
            &mut end.observables.mesh_x,
            &mut end.observables.mesh_y,
            &mut end.work.iterations,
            &mut end.work.operator_applications,
        ];
        counts.into_iter().for_each(|count| *count = u64::MAX);
        (end.step, end.cycle) = (u32::MAX, u32::MAX);
        let increments = Loading::MAX_INCREMENTS as usize;
        outcome.steps = vec![end; increments];
        let (below, peak) = (Some(StressPeak::default()), PlanePeaks::default());
        let largest = Some(LargestStress { below, ..LargestStress::default() });
        outcome.further = Further {
            wear: vec![Worn::default(); increments],
            leading_edges: vec![Some(LONG); increments],
            interior: Some(Interior {
                von_mises: largest,
                tresca: largest,
                searched: Some([0.0; 2]),
                planes: vec![peak; InteriorQuestion::MOST_DEPTHS],
                points: vec![PointStress::default(); InteriorQuestion::MOST_POINTS],
                residual: Some(0.0),
            }),
        };
        let bytes = record.encode().len();
        assert!(
            bytes + (16 << 10) <= STORED_LIMIT,
            "{bytes} bytes, {} of the job",
            record.job.len()
        );
        assert_eq!(Record::decode(&record.encode()), Ok(record));
    }

    /// A change of these bytes is a change of the format: it needs a new version and a reader of
    /// the old one.
    #[test]
    fn golden_bytes() {
        insta::assert_snapshot!("record", hexadecimal(&solved().encode()));
        insta::assert_snapshot!("record_failed", hexadecimal(&failed().encode()));
        insta::assert_snapshot!("record_quarantined", hexadecimal(&quarantined().encode()));
        insta::assert_snapshot!("record_searched", hexadecimal(&searched().encode()));
        insta::assert_snapshot!("fields", hexadecimal(&encode_fields(&fields())));
        insta::assert_snapshot!("record_worn", hexadecimal(&worn().encode()));
        insta::assert_snapshot!("fields_worn", hexadecimal(&encode_fields(&worn_fields())));
    }

    fn hexadecimal(bytes: &[u8]) -> String {
        let line = |line: &[u8]| line.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        bytes.chunks(32).map(line).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn what_is_malformed_says_so() {
        let message = |bytes: &[u8]| Record::decode(bytes).unwrap_err().to_string();
        assert_eq!(message(&[]), "the record is empty");
        assert_eq!(
            message(&[9, 1]),
            "the record has format 9, this program reads formats 3, 4, 5 and 6"
        );
        assert_eq!(
            message(&[1, 1]),
            "the record has format 1, this program reads formats 3, 4, 5 and 6"
        );
        let mut long = solved().encode();
        long.push(0);
        assert_eq!(message(&long), "the record does not decode: 1 bytes too many");
        // This is the length of a text of 2⁶⁴ − 1 bytes.
        let huge = [&[RECORD_VERSION, 1, 253], &[0xff; 8][..]].concat();
        assert!(message(&huge).starts_with("the record does not decode"));
        let mut short = fields();
        short.gap.pop();
        assert_eq!(
            decode_fields(&encode_fields(&short)).unwrap_err().to_string(),
            "the field file does not decode: 5 values on 3 × 2 elements"
        );
        let mut half_worn = worn_fields();
        half_worn.further.wear_depth.pop();
        assert!(decode_fields(&encode_fields(&half_worn)).is_err());
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
        for bytes in [solved().encode(), worn().encode()] {
            assert!((0..bytes.len()).all(|length| Record::decode(&bytes[..length]).is_err()));
        }
        for bytes in [encode_fields(&fields()), encode_fields(&worn_fields())] {
            assert!((0..bytes.len()).all(|length| decode_fields(&bytes[..length]).is_err()));
        }
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_never_panic(
            mut bytes in proptest::collection::vec(any::<u8>(), 0..400),
            version in prop::sample::select(vec![None, Some(0), Some(1)]),
        ) {
            if let (Some(first), Some(version)) = (bytes.first_mut(), version) {
                *first = [RECORD_VERSION, WITH_FURTHER][version];
            }
            let _ = (Record::decode(&bytes), decode_ending(&bytes));
            if let (Some(first), Some(version)) = (bytes.first_mut(), version) {
                *first = [VERSION, FIELDS_WITH_FURTHER][version];
            }
            let _ = decode_fields(&bytes);
        }

        #[test]
        fn flipped_bits_never_panic(
            at in any::<prop::sample::Index>(),
            bit in 0u8..8,
            which in 0usize..5,
        ) {
            let mut bytes =
                [solved(), failed(), quarantined(), searched(), worn()][which].encode();
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
