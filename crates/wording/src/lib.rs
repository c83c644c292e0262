//! Foreign text in what the program says.
//!
//! Names, questions, labels, paths and filters come from files and arguments that somebody else may
//! have written. On a terminal their control characters would be obeyed, so [`visible`] and
//! [`one_line`] show them, and [`excerpt`] cuts what is long. In a command that is proposed,
//! [`command`] quotes them, so that it can be pasted.
//!
//! ```
//! use wording::{command, excerpt, one_line};
//!
//! assert_eq!(one_line("\u{1b}]0;title\u{7}"), r"\u{1b}]0;title\u{7}");
//! assert_eq!(excerpt("a long name", 7), "a long…");
//! assert_eq!(command(["run", "my study.toml"]), "tribosweep run 'my study.toml'");
//! ```
#![forbid(unsafe_code)]

mod shell;
mod shown;

pub use shell::{command, file_argument, shell_word};
pub use shown::{escaped_json, excerpt, one_line, visible};
