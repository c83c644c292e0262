//! The six different entries of a 3 × 3 block of surface kernels or of their integrals.

/// The displacement of one element under unit traction on another: the six different entries of the
/// 3 × 3 block; xn = −nx, yn = −ny, yx = xy. The first letter is the displacement's direction, the
/// second the traction's.
///
/// With the same symmetries, the type also holds a kernel at a point (x, y), receiver minus source,
/// and the integrals of kernels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficient {
    /// The normal displacement under pressure.
    pub nn: f64,
    /// The displacement along x under traction along x.
    pub xx: f64,
    /// The displacement along y under traction along y.
    pub yy: f64,
    /// The displacement along x under traction along y, and the reverse.
    pub xy: f64,
    /// The normal displacement (into the foundation) under traction along x.
    pub nx: f64,
    /// The normal displacement (into the foundation) under traction along y.
    pub ny: f64,
}

impl Coefficient {
    /// Returns the block \[displacement\]\[traction\] in the order n, x, y.
    pub(crate) fn block(&self) -> [[f64; 3]; 3] {
        [[self.nn, self.nx, self.ny], [-self.nx, self.xx, self.xy], [-self.ny, self.xy, self.yy]]
    }

    /// Adds `factor` times `other`.
    #[inline]
    pub(super) fn add(&mut self, other: &Self, factor: f64) {
        self.add_mirrored(other, factor, [1.0; 2]);
    }

    /// Adds `factor` times `other`, each entry with its sign under x → sx·x, y → sy·y.
    #[inline]
    pub(super) fn add_mirrored(&mut self, other: &Self, factor: f64, [sx, sy]: [f64; 2]) {
        self.nn += factor * other.nn;
        self.xx += factor * other.xx;
        self.yy += factor * other.yy;
        self.xy += factor * sx * sy * other.xy;
        self.nx += factor * sx * other.nx;
        self.ny += factor * sy * other.ny;
    }

    /// Returns `factor` times the entries.
    pub(super) fn scaled(self, factor: f64) -> Self {
        let mut out = Self::default();
        out.add(&self, factor);
        out
    }

    /// Returns the entries with x and y exchanged.
    pub(super) fn transposed(self) -> Self {
        Self { xx: self.yy, yy: self.xx, nx: self.ny, ny: self.nx, ..self }
    }
}
