//! Tests of studies: files that are accepted, and files that are refused in clear words.

mod accepted;
mod edited;
mod interior;
mod jobs;
mod kinds;
mod limits;
mod materials;
mod point_keys;
mod points;
mod reference;
mod refused;
mod rolling;
mod round_trip;
mod sample;
mod scaffold;
mod sensitivity;
mod simulate;
mod sphere;
mod wear;
mod wheelset;
