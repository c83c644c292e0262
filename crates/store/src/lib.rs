//! Durable results: records in sled, fields in content-addressed files.
