//! Closed forms that solutions are held against.
//!
//! All are for a half-space with composite modulus E* = 1/Σ((1−ν)/2G) \[Pa\].

use std::f64::consts::PI;

/// Load, contact radius and peak pressure of an axisymmetric frictionless contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indentation {
    /// Normal force \[N\].
    pub load: f64,
    /// Contact radius \[m\].
    pub radius: f64,
    /// Largest pressure \[Pa\]; infinite where the theory has a singularity.
    pub peak_pressure: f64,
}

/// Hertz: a paraboloid r²/2R pressed by δ. a = √(Rδ), P = 4/3 E* √R δ^{3/2}, p₀ = 3P/2πa² (Johnson, Contact Mechanics, 1985, eq. 4.22–4.24).
pub fn hertz_sphere(modulus: f64, radius: f64, approach: f64) -> Indentation {
    let contact = (radius * approach).sqrt();
    let load = 4.0 / 3.0 * modulus * contact * approach;
    Indentation { load, radius: contact, peak_pressure: 1.5 * load / (PI * contact * contact) }
}

/// A flat disk of radius a pressed by δ without friction: P = 2E*aδ (Sneddon 1965, doi:10.1016/0020-7225(65)90019-4).
pub fn flat_disk(modulus: f64, radius: f64, approach: f64) -> Indentation {
    Indentation { load: 2.0 * modulus * radius * approach, radius, peak_pressure: f64::INFINITY }
}

/// A cone r tan β pressed by δ without friction: a = 2δ/(π tan β), P = 2E*δ²/(π tan β) (Sneddon 1965, doi:10.1016/0020-7225(65)90019-4).
pub fn cone(modulus: f64, angle: f64, approach: f64) -> Indentation {
    let radius = 2.0 * approach / (PI * angle.tan());
    Indentation { load: modulus * radius * approach, radius, peak_pressure: f64::INFINITY }
}

/// Mossakovskii: load of an axisymmetric flat punch in full stick over the frictionless load at the same approach,
/// (1−ν) ln(3−4ν)/(1−2ν), 1 at ν = ½ (Mossakovskii, J. Appl. Math. Mech. 27 (1963) 418–427).
pub fn full_stick_load_ratio(poisson: f64) -> f64 {
    let x = 1.0 - 2.0 * poisson;
    (1.0 - poisson) * if x == 0.0 { 2.0 } else { (2.0 * x).ln_1p() / x }
}

/// Cattaneo–Mindlin: stick radius over contact radius, (1 − Q/μP)^{1/3}, for 0 ≤ Q ≤ μP
/// (Mindlin, J. Appl. Mech. 16 (1949) 259–268, doi:10.1115/1.4009973); exact for like bodies with ν = 0.
pub fn cattaneo_stick_ratio(tangential: f64, friction_limit: f64) -> f64 {
    (1.0 - tangential / friction_limit).max(0.0).cbrt()
}

/// Cattaneo–Mindlin: rigid shift s of like bodies under a tangential force Q,
/// s = (3μP/16a) S (1 − (1 − Q/μP)^{2/3}) with S = Σ(2−ν)/G \[m\] (Johnson, Contact Mechanics, 1985, eq. 7.42).
pub fn cattaneo_shift(tangential: f64, friction_limit: f64, contact_radius: f64, shear_compliance: f64) -> f64 {
    let rest = (1.0 - tangential / friction_limit).max(0.0).cbrt();
    3.0 * friction_limit / (16.0 * contact_radius) * shear_compliance * (1.0 - rest * rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_stick_ratio_is_smooth_up_to_incompressible() {
        // (1−ν) ln(3−4ν)/(1−2ν) at ν = 0 is ln 3
        assert!((full_stick_load_ratio(0.0) - 3f64.ln()).abs() < 1e-15);
        assert_eq!(full_stick_load_ratio(0.5), 1.0);
        assert!((full_stick_load_ratio(0.5 - 1e-9) - 1.0).abs() < 1e-8);
    }

    #[test]
    fn hertz_is_consistent_with_its_own_pressure() {
        // ∫ p₀√(1−r²/a²) = 2/3 p₀ π a²
        let hertz = hertz_sphere(2.0, 3.0, 0.5);
        assert!((2.0 / 3.0 * hertz.peak_pressure * PI * hertz.radius.powi(2) / hertz.load - 1.0).abs() < 1e-15);
        // dP/dδ = 2E*a
        let d = 1e-6;
        let slope = (hertz_sphere(2.0, 3.0, 0.5 + d).load - hertz_sphere(2.0, 3.0, 0.5 - d).load) / (2.0 * d);
        assert!((slope / (4.0 * hertz.radius) - 1.0).abs() < 1e-9);
    }
}
