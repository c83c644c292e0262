//! The kinds of studies: what is done with their points, and which keys that takes.

use crate::key::Key;

/// What is done with the points of a study.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Every point is solved.
    #[default]
    Solve,
    /// Every point is solved, and compared with the limit of a ladder of them.
    Convergence,
    /// Every point is solved several times over, and its error held against its time.
    Cost,
    /// Every point is searched for all of its solutions.
    Multiplicity,
    /// The end μ* of the uniqueness set is bracketed at every point.
    Uniqueness,
}

impl Kind {
    /// Every kind.
    pub const ALL: &'static [Kind] =
        &[Kind::Solve, Kind::Convergence, Kind::Cost, Kind::Multiplicity, Kind::Uniqueness];

    /// How a study file calls it.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Solve => "solve",
            Kind::Convergence => "convergence",
            Kind::Cost => "cost",
            Kind::Multiplicity => "multiplicity",
            Kind::Uniqueness => "uniqueness",
        }
    }

    /// The kind of this name.
    pub fn find(name: &str) -> Option<Kind> {
        Kind::ALL.iter().copied().find(|kind| kind.name() == name)
    }

    /// Why its jobs have no use for a key; `None` where they have.
    pub(crate) fn refuses(self, key: Key) -> Option<&'static str> {
        let is_of_search = matches!(key, Key::Starts | Key::Seed);
        match self {
            Kind::Solve | Kind::Convergence | Kind::Cost => {
                is_of_search.then_some("a scene is solved from one start")
            }
            Kind::Multiplicity => match key {
                Key::Simulate => Some("a search simulates every effect"),
                Key::Method => Some("a search tries every method"),
                _ => None,
            },
            Kind::Uniqueness => match key {
                Key::Mu => Some("it asks for the friction"),
                Key::Steps | Key::CycleFrom | Key::Cycles => {
                    Some("uniqueness does not depend on the loading")
                }
                Key::DomainWidthX | Key::DomainWidthY | Key::DomainCenterX | Key::DomainCenterY => {
                    Some("the flat sole of its punch is Ω")
                }
                Key::Ceiling
                | Key::Method
                | Key::Tolerance
                | Key::MaxIterations
                | Key::Simulate => Some("no scene is solved"),
                _ if key.list() == Some(Key::Steps) => {
                    Some("uniqueness does not depend on the loading")
                }
                _ => None,
            },
        }
    }
}
