//! The plane on which a field lies.

/// A plane in the foundation, whose z points down from its surface \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CutPlane {
    /// A section x = const; the field lies on y and z.
    X(f64),
    /// A section y = const; the field lies on x and z.
    Y(f64),
    /// A plane z = const; the field lies on x and y.
    Z(f64),
}

impl CutPlane {
    /// Returns whether it goes down from the surface.
    pub(super) fn is_section(self) -> bool {
        !matches!(self, Self::Z(_))
    }

    /// Returns the names of the two coordinates on it.
    pub(super) fn names(self) -> [&'static str; 2] {
        match self {
            Self::X(_) => ["y", "z"],
            Self::Y(_) => ["x", "z"],
            Self::Z(_) => ["x", "y"],
        }
    }

    /// Returns the coordinate that all of it shares.
    pub(super) fn place(self) -> f64 {
        let (Self::X(place) | Self::Y(place) | Self::Z(place)) = self;
        place
    }

    /// Returns what belongs to its two coordinates in the order of x, y and z, with `other` across
    /// it.
    pub(super) fn spread<T>(self, [a, b]: [T; 2], other: T) -> [T; 3] {
        match self {
            Self::X(_) => [other, a, b],
            Self::Y(_) => [a, other, b],
            Self::Z(_) => [a, b, other],
        }
    }
}
