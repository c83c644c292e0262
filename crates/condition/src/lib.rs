//! Conditions over named values: `mu > 0.3 && mesh == 64 && status == "certified"`.
//!
//! The grammar is that of the Common Expression Language (CEL, <https://cel.dev>), as far as it
//! has a meaning here. The crates that read all of CEL bring their interpreter and a machine for
//! grammars, which took a tenth of the time that the program takes to build. The meaning is our own
//! too, because a table of measurements needs another one in four points: integers and numbers mix
//! in arithmetic, a name may be dotted (`friction.mu`, `foundation.layers[0].thickness`), comparing
//! a number with text is refused instead of being false, and a missing value makes a comparison
//! unknown.
//!
//! The values may be the cells of a row of a table or the keys of a point of a study: a condition
//! knows names and values, and nothing of where they come from.
//!
//! ```
//! use condition::{Condition, ConditionNames, FilterValue, UnknownColumn, ValueKind};
//!
//! struct Friction;
//!
//! impl ConditionNames for Friction {
//!     fn find(&self, name: &str) -> Result<usize, UnknownColumn> {
//!         if name == "mu" { Ok(0) } else { Err(UnknownColumn::default()) }
//!     }
//!     fn kind(&self, _: usize) -> ValueKind {
//!         ValueKind::Number
//!     }
//! }
//!
//! let condition = Condition::new("mu > 0.3", &Friction)?;
//! assert_eq!(condition.truth(&|_| FilterValue::Number(0.5)), Ok(Some(true)));
//! assert_eq!(condition.truth(&|_| FilterValue::Missing), Ok(None));
//! # Ok::<(), condition::FilterError>(())
//! ```
#![forbid(unsafe_code)]

mod compile;
mod error;
mod evaluate;
mod grammar;
mod quoted;
mod syntax;
mod token;
mod tree;

pub use compile::ConditionNames;
pub use error::{FilterError, UnknownColumn};
pub use evaluate::compare_exactly;
pub use tree::{FilterValue, ValueKind};

use tree::Expression;

/// A condition whose names are known and whose kinds of values fit.
#[derive(Clone, Debug)]
pub struct Condition {
    expression: Expression,
}

impl Condition {
    /// The length of the longest condition, in bytes.
    pub const LONGEST: usize = error::LONGEST;

    /// Reads a condition over names.
    ///
    /// # Errors
    /// [`FilterError`], if the text does not follow the grammar, uses an unknown name, or joins
    /// values of kinds that do not fit. A comparison of a number with text, which could never
    /// hold, is such an error.
    pub fn new(text: &str, names: &dyn ConditionNames) -> Result<Condition, FilterError> {
        Ok(Condition { expression: compile::compile(text, names)? })
    }

    /// Returns the truth of the condition for the values of the names, by their indices; `None` if
    /// it is unknown because a value is missing.
    ///
    /// # Errors
    /// A message if values of kinds meet that do not fit, which only the values tell.
    pub fn truth<'a>(
        &'a self,
        value: &dyn Fn(usize) -> FilterValue<'a>,
    ) -> Result<Option<bool>, String> {
        evaluate::truth(&self.expression, value)
    }

    /// Returns the texts of which the name with an index has one wherever the condition holds;
    /// `None` if it may hold for other values as well.
    pub fn texts_of(&self, index: usize) -> Option<Vec<&str>> {
        self.expression.texts_of(index)
    }

    /// Returns whether the condition uses the name with an index.
    pub fn uses(&self, index: usize) -> bool {
        self.expression.uses(index)
    }
}
