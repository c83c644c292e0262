//! Counts of elements that should be 0.

use contact::model::Observables;
use study::Record;

/// A count of elements that should be 0.
pub struct Warning {
    /// The column of the count.
    pub column: &'static str,
    /// The meaning of another count, after the word "elements".
    pub words: &'static str,
    count: fn(&Observables) -> u64,
}

/// Every warning.
pub const WARNINGS: [Warning; 2] = [
    Warning {
        column: "edge_elements",
        words: "touch the edge of Ω although the punch goes on beyond it; give a larger `domain`",
        count: |observables| observables.edge_elements,
    },
    Warning {
        column: "ceiling_elements",
        words: "reach the pressure ceiling and so solve the regularised equation only; \
                raise `ceiling`",
        count: |observables| observables.ceiling_elements,
    },
];

impl Warning {
    /// Tells whether some increment of a result has such elements.
    pub fn concerns(&self, record: &Record) -> bool {
        record.outcome().is_some_and(|outcome| {
            outcome.steps.iter().any(|step| (self.count)(&step.observables) > 0)
        })
    }
}
