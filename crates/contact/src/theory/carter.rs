//! Carter's solution of rolling in a line contact.

/// A line contact that rolls steadily towards +x, after F. W. Carter, Proc. R. Soc. A 112 (1926)
/// 151–157, doi:10.1098/rspa.1926.0100 (Johnson, Contact Mechanics, 1985, section 8.3). The
/// pressure is p₀ √(1 − x²/a²), and nothing couples it and the traction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carter {
    /// The half-width of the contact, a \[m\].
    pub half_width: f64,
    /// The half-width of the zone that sticks, d \[m\], which begins at the leading edge.
    pub stick_half_width: f64,
    /// The sign of the tangential force on the foundation, against that of the creepage.
    sign: f64,
}

impl Carter {
    /// Returns the solution for a creepage ξ (of the foundation against the punch, over the rolling
    /// speed), a punch of the radius R \[m\] (with the gap x²/2R), and friction μ: d = a − |ξ|R/μ,
    /// and everything slips from |ξ| = μa/R on.
    pub fn of_creepage(creepage: f64, radius: f64, half_width: f64, mu: f64) -> Self {
        let slip = if creepage == 0.0 { 0.0 } else { creepage.abs() * radius / mu };
        Self {
            half_width,
            stick_half_width: (half_width - slip).max(0.0),
            sign: -creepage.signum(),
        }
    }

    /// Returns the solution for a tangential force per μP, Q/μP: d = a √(1 − |Q|/μP).
    pub fn of_force(force_ratio: f64, half_width: f64) -> Self {
        let stick = (1.0 - force_ratio.abs()).max(0.0).sqrt();
        Self { half_width, stick_half_width: half_width * stick, sign: force_ratio.signum() }
    }

    /// Returns the tangential force over μP, Q/μP = ±(1 − d²/a²).
    pub fn force_ratio(&self) -> f64 {
        self.sign * (1.0 - (self.stick_half_width / self.half_width).powi(2))
    }

    /// Returns the creepage, for a punch of the radius R \[m\] and friction μ. Where everything slips
    /// it is the least one.
    pub fn creepage(&self, radius: f64, mu: f64) -> f64 {
        -self.sign * mu * (self.half_width - self.stick_half_width) / radius
    }

    /// Returns the traction at x \[m\] over μp₀.
    pub fn traction(&self, x: f64) -> f64 {
        let ellipse = |x: f64, half_width: f64| {
            if half_width > 0.0 { (1.0 - (x / half_width).powi(2)).max(0.0).sqrt() } else { 0.0 }
        };
        let (a, d) = (self.half_width, self.stick_half_width);
        self.sign * (ellipse(x, a) - d / a * ellipse(x - (a - d), d))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_is_the_integral_of_the_traction() {
        for creepage in [-1e-5, 2.4e-4, -5.9e-4, 1.0] {
            let carter = Carter::of_creepage(creepage, 500.0, 1.0, 0.3);
            // The pressure p₀√(1 − x²) has the force π/2 p₀.
            let n = 200_000;
            let sum: f64 = (0..n)
                .map(|i| carter.traction((f64::from(i) + 0.5) / f64::from(n) * 2.0 - 1.0))
                .sum();
            let force = sum * 2.0 / f64::from(n) / std::f64::consts::FRAC_PI_2;
            assert!((force - carter.force_ratio()).abs() < 1e-7, "{creepage}: {force}");
        }
    }

    #[test]
    fn forces_and_creepages_are_inverse() {
        // The example of the reference: R = 500, a = 1, μ = 0.3, ξ = −0.00024.
        let carter = Carter::of_creepage(-0.00024, 500.0, 1.0, 0.3);
        assert!((carter.stick_half_width - 0.6).abs() < 1e-15);
        assert!((carter.force_ratio() - 0.64).abs() < 1e-15);
        for ratio in [-0.9, -1e-9, 0.0, 0.3, 0.999] {
            let carter = Carter::of_force(ratio, 2.0);
            assert!((carter.force_ratio() - ratio).abs() < 1e-15);
            let back = Carter::of_creepage(carter.creepage(30.0, 0.2), 30.0, 2.0, 0.2);
            assert!((back.stick_half_width - carter.stick_half_width).abs() < 1e-14);
            assert!((back.force_ratio() - ratio).abs() < 1e-14, "{ratio}");
        }
    }

    #[test]
    fn without_friction_everything_slips() {
        assert_eq!(Carter::of_creepage(1e-9, 1.0, 1.0, 0.0).stick_half_width, 0.0);
        assert_eq!(Carter::of_creepage(0.0, 1.0, 1.0, 0.0).force_ratio(), 0.0);
    }
}
