//! What a study is: its file, its axes, its jobs and the record that a job leaves.
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
//! let approach = columns::find(&study.columns(), "approach").unwrap().value(&study.point(1).unwrap(), None);
//! assert_eq!(approach, columns::Value::Number(1e-5));
//! # Ok::<(), study::StudyError>(())
//! ```
#![forbid(unsafe_code)]

pub mod accuracy;
pub mod adaptive;
mod assemble;
pub mod axis;
pub mod columns;
pub mod cost;
pub mod error;
pub mod figure;
pub mod file;
pub mod job;
pub mod key;
pub mod kind;
pub mod label;
pub mod ladder;
pub mod profile;
mod read;
pub mod record;
mod settings;
mod sheet;
pub mod surface;
mod sweep;
pub mod units;

pub use accuracy::Accuracy;
pub use adaptive::Adaptive;
pub use columns::{Column, Value};
pub use error::StudyError;
pub use figure::Figure;
pub use file::{Point, Study};
pub use job::{Case, Job};
pub use kind::Kind;
pub use ladder::Ladder;
pub use record::{Ending, Provenance, Record};
