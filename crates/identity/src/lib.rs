//! The names of jobs and of their stored fields.
//!
//! This crate stands below the store, the runner and the studies, so that the first two know
//! nothing of the physics. A [`JobKey`] names a job, a [`KeptFields`] says where the fields of its
//! record are, and [`STORED_LIMIT`] bounds the record.
//!
//! ```
//! use identity::JobKey;
//!
//! let key = JobKey::of(3, r#"{"kind":"solve"}"#);
//! assert_eq!(key.to_string().parse(), Ok(key));
//! ```
#![forbid(unsafe_code)]

mod kept;
mod key;

pub use kept::{KeptFields, STORED_LIMIT};
pub use key::{JobKey, JobKeyHasher, ParseKeyError};
