//! Studies: their files, their axes, their jobs and the records that jobs leave.
//!
//! ```
//! use study::{Study, columns};
//!
//! let text = r#"
//!     name = "load-over-approach"
//!     [scene]
//!     foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
//!     punch = { shape = "sphere", radius = "50 mm" }
//!     friction.mu = 0.3
//!     loading.steps = [{ approach = "20 um" }]
//!     [numerics]
//!     mesh = 16
//!     [sweep]
//!     "loading.steps[0].approach" = { log = true, from = "1 um", to = "100 um", count = 3 }
//! "#;
//! let study = Study::parse(text, "load.toml", &mut |file| Err(format!("no file {file}")))?;
//! let columns = study.columns();
//! let approach = columns::find(&columns, "approach").unwrap();
//! let value = approach.value(&study.point(1).unwrap(), None);
//! assert_eq!(value, study::Value::Number(1e-5));
//! # Ok::<(), study::StudyError>(())
//! ```
#![forbid(unsafe_code)]

pub mod account;
pub mod accuracy;
pub mod adaptive;
mod assemble;
pub mod axis;
mod bounds;
mod column_file;
mod column_name;
pub mod columns;
mod definition;
mod derivation;
pub mod design;
pub mod distribution;
pub mod edit;
pub mod encoding;
mod error;
mod exclusion;
mod fallback;
pub mod figure;
mod file_fault;
mod file_text;
mod file_words;
mod formula;
pub mod job;
pub mod key;
pub mod kind;
pub mod label;
mod parse;
mod point;
mod point_keys;
mod points_file;
pub mod profile;
pub mod provenance;
mod quantity;
mod read;
pub mod record;
pub mod record_format;
pub mod reference;
pub mod sample;
mod scaling;
mod settings;
mod sheet;
mod study;
mod study_files;
mod suggestion;
pub mod surface;
mod sweep;
mod table_key;
mod table_text;
pub mod units;
mod value;
mod write;

pub use account::RunAccount;
pub use accuracy::Accuracy;
pub use adaptive::{Adaptive, Filling, RootSearch};
pub use axis::PointLevels;
pub use columns::Column;
pub use definition::DefinitionError;
pub use design::{Design, SamplingMethod};
pub use distribution::Distribution;
pub use error::{Mistake, Span, StudyError};
pub use exclusion::{HoldingCounts, PointDecision};
pub use figure::Figure;
pub use file_fault::FileFaults;
pub use job::{Case, Job};
pub use kind::Kind;
pub use kind::convergence::Ladder;
pub use kind::cost::Cost;
pub use parse::IsKnown;
pub use point::StudyPoint;
pub use point_keys::PointKeys;
pub use provenance::Provenance;
pub use record::{Ending, Record, Standing};
pub use study::{MOST_POINTS, MOST_RUN_POINTS, MOST_SHARDS, Study};
pub use study_files::{NamedFile, ReadFile};
pub use value::{Value, ValueType};
