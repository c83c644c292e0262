//! The six rigid degrees of freedom of the punch: its motion, the control of each degree of
//! freedom, and the displacement of a point of its surface.

use std::ops::{Index, IndexMut};

use serde::{Deserialize, Serialize};

/// A rigid degree of freedom of the punch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Dof {
    /// The approach along z, with the normal force.
    Approach,
    /// The shift along x, with the force along x.
    ShiftX,
    /// The shift along y, with the force along y.
    ShiftY,
    /// The tilt about the x axis, with the moment about it.
    TiltX,
    /// The tilt about the y axis, with the moment about it.
    TiltY,
    /// The twist about the z axis, with the moment about it.
    Twist,
}

impl Dof {
    /// Every degree of freedom, in the order of [`PerDof`].
    pub const ALL: [Dof; 6] =
        [Dof::Approach, Dof::ShiftX, Dof::ShiftY, Dof::TiltX, Dof::TiltY, Dof::Twist];

    /// The shifts along x and y.
    pub const SHIFTS: [Dof; 2] = [Dof::ShiftX, Dof::ShiftY];

    /// The tilts about x and y.
    pub(crate) const TILTS: [Dof; 2] = [Dof::TiltX, Dof::TiltY];

    /// The rotations, whose resultants are moments.
    pub const ROTATIONS: [Dof; 3] = [Dof::TiltX, Dof::TiltY, Dof::Twist];

    /// The motions within the plane of contact, which friction resists.
    pub(crate) const TANGENTIAL: [Dof; 3] = [Dof::ShiftX, Dof::ShiftY, Dof::Twist];

    /// Returns the tilt about an axis (0: x, 1: y). It lifts what lies beside that axis.
    pub(crate) fn tilt_about(axis: usize) -> Self {
        Self::TILTS[axis]
    }

    /// Returns whether it is a rotation, whose resultant is a moment.
    pub(crate) fn is_rotation(self) -> bool {
        Self::ROTATIONS.contains(&self)
    }
}

/// A value for each rigid degree of freedom.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PerDof<T>([T; 6]);

impl<T> PerDof<T> {
    /// Takes the values in the order of [`Dof::ALL`].
    pub const fn new(values: [T; 6]) -> Self {
        Self(values)
    }

    /// Asks `value` for each degree of freedom, in the order of [`Dof::ALL`].
    pub fn from_fn(value: impl FnMut(Dof) -> T) -> Self {
        Self(Dof::ALL.map(value))
    }

    /// Returns the values in the order of [`Dof::ALL`].
    pub fn to_array(self) -> [T; 6] {
        self.0
    }

    /// Applies `change` to every value.
    pub fn map<U>(self, change: impl FnMut(T) -> U) -> PerDof<U> {
        PerDof(self.0.map(change))
    }

    /// Goes through the values in the order of [`Dof::ALL`].
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.0.iter()
    }

    /// Goes through the values in the order of [`Dof::ALL`], to change them.
    pub(crate) fn iter_mut(&mut self) -> std::slice::IterMut<'_, T> {
        self.0.iter_mut()
    }
}

impl<T: Copy> PerDof<T> {
    /// Gives every degree of freedom the same value.
    pub const fn all(value: T) -> Self {
        Self([value; 6])
    }
}

impl PerDof<f64> {
    /// Returns the sum of the products with `other`.
    pub(crate) fn dot(&self, other: &Self) -> f64 {
        self.iter().zip(other).map(|(a, b)| a * b).sum()
    }
}

impl<T> Index<Dof> for PerDof<T> {
    type Output = T;

    fn index(&self, dof: Dof) -> &T {
        &self.0[dof as usize]
    }
}

impl<T> IndexMut<Dof> for PerDof<T> {
    fn index_mut(&mut self, dof: Dof) -> &mut T {
        &mut self.0[dof as usize]
    }
}

impl<T> IntoIterator for PerDof<T> {
    type Item = T;
    type IntoIter = std::array::IntoIter<T, 6>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a, T> IntoIterator for &'a PerDof<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// The position of the punch, measured from where it just touches at the origin, with the signs of
/// [`Step`](super::loading::Step).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// The approach δ \[m\].
    pub approach: f64,
    /// The shift along x \[m\].
    pub shift_x: f64,
    /// The shift along y \[m\].
    pub shift_y: f64,
    /// The tilt about the x axis \[rad\].
    pub tilt_x: f64,
    /// The tilt about the y axis \[rad\].
    pub tilt_y: f64,
    /// The twist φ about the z axis \[rad\].
    pub twist: f64,
}

impl Motion {
    /// Returns the motion of each degree of freedom.
    pub fn per_dof(self) -> PerDof<f64> {
        PerDof([self.approach, self.shift_x, self.shift_y, self.tilt_x, self.tilt_y, self.twist])
    }

    /// Makes a motion of the motion of each degree of freedom.
    pub(crate) fn from_per_dof(motion: PerDof<f64>) -> Self {
        let [approach, shift_x, shift_y, tilt_x, tilt_y, twist] = motion.0;
        Self { approach, shift_x, shift_y, tilt_x, tilt_y, twist }
    }
}

/// The control of a rigid degree of freedom of the punch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// The position that is prescribed \[m or rad\].
    Motion(f64),
    /// The force or moment that is prescribed \[N or N m\].
    Force(f64),
}

/// Returns the displacement of the punch at (x, y) under unit motion of each degree of freedom, by
/// component (n, x, y) and degree of freedom. The transpose sums tractions to resultants.
pub(crate) fn rigid_modes(x: f64, y: f64) -> [PerDof<f64>; 3] {
    [
        PerDof([1.0, 0.0, 0.0, y, -x, 0.0]),
        PerDof([0.0, 1.0, 0.0, 0.0, 0.0, -y]),
        PerDof([0.0, 0.0, 1.0, 0.0, 0.0, x]),
    ]
}

/// Returns the displacement (n, x, y) of the punch at (x, y) under a rigid motion, in the units of
/// the motion.
pub(crate) fn rigid_displacement(x: f64, y: f64, motion: &PerDof<f64>) -> [f64; 3] {
    rigid_modes(x, y).map(|modes| modes.dot(motion))
}
