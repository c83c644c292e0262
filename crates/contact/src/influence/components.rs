//! The components of traction and displacement on which an operator acts.

use crate::foundation::Coefficient;

/// A component of a vector: the one normal to the plane of contact or one of the two in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Direction {
    /// The normal direction, into the foundation.
    N,
    /// The direction along x.
    X,
    /// The direction along y.
    Y,
}

impl Direction {
    /// All three directions, in the order of the blocks of a field.
    pub(crate) const ALL: [Self; 3] = [Self::N, Self::X, Self::Y];
}

/// A set of directions, and whether the normal one couples with the tangential ones. A field of
/// these components has one block for each, in the order n, x, y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Components {
    /// One flag for each of n, x, y.
    members: [bool; 3],
    /// True if n couples with x or y.
    coupled: bool,
}

impl Components {
    /// The directions n, x and y, coupled: the full problem.
    pub const ALL: Self = Self { members: [true; 3], coupled: true };
    /// The direction n alone.
    pub const NORMAL: Self = Self::of([true, false, false]);
    /// The directions x and y.
    pub const TANGENTIAL: Self = Self::of([false, true, true]);
    /// The direction x alone.
    pub const X: Self = Self::of([false, true, false]);
    /// The direction y alone.
    #[cfg(test)]
    pub(crate) const Y: Self = Self::of([false, false, true]);

    /// Makes the set of those of n, x, y that are true, with n coupled with the others.
    ///
    /// # Panics
    /// If none is true.
    pub(crate) const fn of(members: [bool; 3]) -> Self {
        let [n, x, y] = members;
        assert!(n || x || y, "an operator on no component");
        Self { members, coupled: n && (x || y) }
    }

    /// Returns the same set without coupling of n with x and y.
    pub(crate) const fn uncoupled(self) -> Self {
        Self { coupled: false, ..self }
    }

    /// Returns whether n couples with x or y; true only if n is a member together with one of them.
    #[cfg(test)]
    pub(crate) fn coupled(self) -> bool {
        self.coupled
    }

    /// Returns whether a direction is a member.
    pub(crate) fn contains(self, direction: Direction) -> bool {
        self.members[direction as usize]
    }

    /// Returns whether this set holds all members of the other set, and couples if that one does.
    pub(crate) fn includes(self, other: Self) -> bool {
        other.directions().all(|direction| self.contains(direction))
            && (self.coupled || !other.coupled)
    }

    /// Returns the number of directions, 1 to 3.
    #[allow(clippy::len_without_is_empty)] // There is no empty set.
    pub fn len(self) -> usize {
        self.directions().count()
    }

    /// Returns the members in the order n, x, y.
    pub(crate) fn directions(self) -> impl Iterator<Item = Direction> {
        Direction::ALL.into_iter().filter(move |&direction| self.contains(direction))
    }

    /// Returns the different entries of a coefficient that an operator on these components is made
    /// of.
    pub(crate) fn entries(self) -> impl Iterator<Item = Entry> {
        Entry::ALL.into_iter().filter(move |entry| {
            let [row, column] = entry.directions();
            let couples = row == Direction::N && column != Direction::N;
            self.contains(row) && self.contains(column) && (self.coupled || !couples)
        })
    }

    /// Returns the groups of directions with no entry between them, in the order of the blocks.
    pub(crate) fn groups(self) -> impl Iterator<Item = Vec<Direction>> {
        let (normal, tangential): (Vec<_>, Vec<_>) =
            self.directions().partition(|&direction| !self.coupled && direction == Direction::N);
        [normal, tangential].into_iter().filter(|group| !group.is_empty())
    }
}

/// One of the six different entries of a coefficient; xn = −nx, yn = −ny, yx = xy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Entry {
    /// The normal displacement under pressure; even in Δi and in Δj.
    Nn,
    /// The displacement along x under traction along x; even in both.
    Xx,
    /// The displacement along y under traction along y; even in both.
    Yy,
    /// The displacement along x under traction along y; odd in both.
    Xy,
    /// The normal displacement under traction along x; odd in Δi, even in Δj.
    Nx,
    /// The normal displacement under traction along y; even in Δi, odd in Δj.
    Ny,
}

impl Entry {
    /// All six entries, in the order of their declaration.
    pub(crate) const ALL: [Self; 6] = [Self::Nn, Self::Xx, Self::Yy, Self::Xy, Self::Nx, Self::Ny];

    /// Returns whether the entry changes sign with Δi.
    pub(crate) fn odd_in_x(self) -> bool {
        matches!(self, Self::Xy | Self::Nx)
    }

    /// Returns whether the entry changes sign with Δj.
    pub(crate) fn odd_in_y(self) -> bool {
        matches!(self, Self::Xy | Self::Ny)
    }

    /// Returns the directions of displacement and traction, in the order n, x, y.
    pub(crate) fn directions(self) -> [Direction; 2] {
        use Direction::{N, X, Y};
        match self {
            Self::Nn => [N, N],
            Self::Xx => [X, X],
            Self::Yy => [Y, Y],
            Self::Xy => [X, Y],
            Self::Nx => [N, X],
            Self::Ny => [N, Y],
        }
    }

    /// Returns the entry that this one becomes if x and y are exchanged.
    pub(super) fn exchanged(self) -> Self {
        match self {
            Self::Xx => Self::Yy,
            Self::Yy => Self::Xx,
            Self::Nx => Self::Ny,
            Self::Ny => Self::Nx,
            Self::Nn | Self::Xy => self,
        }
    }

    /// Returns the entry that relates two directions.
    pub(crate) fn between(a: Direction, b: Direction) -> Self {
        use Direction::{N, X, Y};
        match (a.min(b), a.max(b)) {
            (N, N) => Self::Nn,
            (X, X) => Self::Xx,
            (Y, Y) => Self::Yy,
            (X, _) => Self::Xy,
            (N, X) => Self::Nx,
            (N, Y) | (Y, _) => Self::Ny,
        }
    }

    /// Returns the value of the entry in a coefficient.
    pub(super) fn value(self, c: &Coefficient) -> f64 {
        match self {
            Self::Nn => c.nn,
            Self::Xx => c.xx,
            Self::Yy => c.yy,
            Self::Xy => c.xy,
            Self::Nx => c.nx,
            Self::Ny => c.ny,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_know_their_entries_and_groups() {
        use Direction::{N, X, Y};
        let entries = |set: Components| set.entries().collect::<Vec<_>>();
        let groups = |set: Components| set.groups().collect::<Vec<_>>();
        assert_eq!(entries(Components::ALL), Entry::ALL);
        assert_eq!(
            entries(Components::ALL.uncoupled()),
            [Entry::Nn, Entry::Xx, Entry::Yy, Entry::Xy]
        );
        assert_eq!(entries(Components::NORMAL), [Entry::Nn]);
        assert_eq!(entries(Components::X), [Entry::Xx]);
        assert_eq!(entries(Components::TANGENTIAL), [Entry::Xx, Entry::Yy, Entry::Xy]);
        assert_eq!(entries(Components::of([true, false, true])), [Entry::Nn, Entry::Yy, Entry::Ny]);
        assert_eq!(groups(Components::ALL), [vec![N, X, Y]]);
        assert_eq!(groups(Components::ALL.uncoupled()), [vec![N], vec![X, Y]]);
        assert_eq!(groups(Components::TANGENTIAL), [vec![X, Y]]);
        assert_eq!(Components::NORMAL.uncoupled(), Components::NORMAL);
        assert!(!Components::TANGENTIAL.coupled() && Components::of([true, true, false]).coupled());
        assert!(
            Components::ALL.includes(Components::ALL.uncoupled())
                && !Components::ALL.uncoupled().includes(Components::ALL)
        );
        assert!(
            Components::TANGENTIAL.includes(Components::X)
                && !Components::X.includes(Components::TANGENTIAL)
        );
    }
}
