//! The exact answer of a scene: its motion, resultants and tractions.

use std::f64::consts::PI;

use crate::assess::quadrature::Kinks;
use crate::model::{Control, Motion, PerDof};

/// The exact answer at the end of a scene's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedForm {
    /// The name of the theory.
    pub name: &'static str,
    /// The source where it is found.
    pub source: &'static str,
    /// The controls that the last step prescribes.
    pub(crate) controls: PerDof<Control>,
    /// The motion of the punch; 0 for a motion that is not determined (sideways, without friction
    /// or load).
    pub motion: Motion,
    /// The forces and moments of the punch on the foundation \[N, N m\].
    pub(crate) resultants: PerDof<f64>,
    /// The semi-axes of the contact along x and y \[m\], an ellipse around the origin.
    pub(crate) semi_axes: [f64; 2],
    /// The semi-axes of the part of it that sticks \[m\]; 0 where nothing does, as without
    /// friction.
    pub(crate) stick_semi_axes: [f64; 2],
    /// The largest pressure \[Pa\]; `None` where it is unbounded: at the edge of a flat sole, at
    /// the tip of a cone.
    pub(crate) peak_pressure: Option<f64>,
    /// The pressure p₁.
    pub(crate) pressure: Pressure,
    /// The tangential traction (p₂, p₃).
    pub(crate) traction: Traction,
}

/// A pressure on an ellipse around the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Pressure {
    /// Hertz's pressure p₀ √(1 − x²/a² − y²/b²).
    Hertz {
        /// The pressure p₀ in the middle \[Pa\].
        peak: f64,
        /// The semi-axes a and b \[m\].
        semi_axes: [f64; 2],
    },
    /// The pressure p₀ acosh(a/r) under a cone: unbounded at the tip, and in L₂.
    Cone {
        /// The pressure p₀, the mean over the contact \[Pa\].
        scale: f64,
        /// The radius a of the contact \[m\].
        radius: f64,
    },
    /// The pressure (p₀ + g·(x, y)) / √(1 − r²/a²) under a disk: not in L₂.
    Disk {
        /// The pressure p₀ in the middle \[Pa\].
        center: f64,
        /// The gradient g of the numerator along x and y \[Pa/m\].
        gradient: [f64; 2],
        /// The radius a of the contact \[m\].
        radius: f64,
    },
}

/// A tangential traction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Traction {
    /// No traction.
    Zero,
    /// The traction μ (p − p*) along a direction, with the contact's pressure p and that of a
    /// smaller approach p*, which spreads over the part that sticks.
    PartialSlip {
        /// The friction coefficient μ times the direction \[1\].
        friction: [f64; 2],
        /// The pressure p*; `None` where everything slides.
        sticking: Option<Pressure>,
    },
    /// The traction (q + t·(−y, x)) / √(1 − r²/a²) under a disk: not in L₂.
    Disk {
        /// The traction q in the middle \[Pa\].
        center: [f64; 2],
        /// The gradient t of the turn \[Pa/m\].
        turn: f64,
        /// The radius a of the contact \[m\].
        radius: f64,
    },
}

impl Pressure {
    /// Returns the pressure at (x, y) \[m\], 0 outside the contact \[Pa\].
    pub(crate) fn at(&self, x: f64, y: f64) -> f64 {
        match *self {
            Pressure::Hertz { peak, semi_axes: [a, b] } => {
                let r = (x / a).hypot(y / b);
                peak * ((1.0 - r) * (1.0 + r)).max(0.0).sqrt()
            }
            Pressure::Cone { scale, radius } => {
                let r = x.hypot(y);
                if r < radius { scale * (radius / r).acosh() } else { 0.0 }
            }
            Pressure::Disk { center, gradient, radius } => {
                (center + gradient[0] * x + gradient[1] * y) * inverse_root(x, y, radius)
            }
        }
    }

    /// Returns the semi-axes along x and y of the ellipse on which it acts \[m\].
    pub(crate) fn semi_axes(&self) -> [f64; 2] {
        match *self {
            Pressure::Hertz { semi_axes, .. } => semi_axes,
            Pressure::Cone { radius, .. } | Pressure::Disk { radius, .. } => [radius; 2],
        }
    }
}

/// Returns 1/√(1 − r²/a²), 0 from the edge on.
fn inverse_root(x: f64, y: f64, radius: f64) -> f64 {
    let r = x.hypot(y) / radius;
    if r < 1.0 { 1.0 / ((1.0 - r) * (1.0 + r)).sqrt() } else { 0.0 }
}

impl ClosedForm {
    /// Returns the tractions (p₁, p₂, p₃) at (x, y) \[m\], 0 outside the contact \[Pa\].
    pub(crate) fn tractions_at(&self, x: f64, y: f64) -> [f64; 3] {
        let pressure = self.pressure.at(x, y);
        let [along_x, along_y] = match self.traction {
            Traction::Zero => [0.0; 2],
            Traction::PartialSlip { friction, sticking } => friction.map(|friction| {
                friction * (pressure - sticking.map_or(0.0, |inner| inner.at(x, y)))
            }),
            Traction::Disk { center: [qx, qy], turn, radius } => {
                [qx - turn * y, qy + turn * x].map(|traction| traction * inverse_root(x, y, radius))
            }
        };
        [pressure, along_x, along_y]
    }

    /// Returns whether the tractions lie in L₂. If they do not, only resultants and local means can
    /// be compared.
    pub(crate) fn is_square_integrable(&self) -> bool {
        !matches!(self.pressure, Pressure::Disk { .. })
    }

    /// Returns the area of the contact \[m²\].
    pub(crate) fn contact_area(&self) -> f64 {
        PI * self.semi_axes[0] * self.semi_axes[1]
    }

    /// Returns the area of the part that sticks \[m²\].
    pub(crate) fn stick_area(&self) -> f64 {
        PI * self.stick_semi_axes[0] * self.stick_semi_axes[1]
    }

    /// Returns the places where the tractions are not smooth.
    pub(crate) fn kinks(&self) -> Kinks {
        let sticking = match self.traction {
            Traction::PartialSlip { sticking, .. } => sticking.map(|inner| inner.semi_axes()),
            Traction::Zero | Traction::Disk { .. } => None,
        };
        Kinks {
            ellipses: [Some(self.semi_axes), sticking].into_iter().flatten().collect(),
            center: matches!(self.pressure, Pressure::Cone { .. }),
        }
    }
}
