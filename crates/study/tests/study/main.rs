//! Tests of studies: files that are accepted, and files that are refused in clear words.

mod accepted;
mod edited;
mod interior;
mod kinds;
mod limits;
mod materials;
mod points;
mod refused;
mod rolling;
mod sample;
mod sensitivity;
mod simulate;
mod sphere;
mod wear;
mod wheelset;
