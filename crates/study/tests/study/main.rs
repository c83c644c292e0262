//! What is a study and what is none: files that are accepted, and files that are refused in clear
//! words.

mod accepted;
mod kinds;
mod refused;
mod simulate;
