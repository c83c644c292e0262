//! Classical solutions of contact on a half-space with the composite modulus E* = 1/Σ((1−ν)/2G)
//! \[Pa\].

use std::f64::consts::PI;

/// The load, contact radius and peak pressure of an axisymmetric frictionless contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indentation {
    /// The normal force \[N\].
    pub load: f64,
    /// The contact radius \[m\].
    pub radius: f64,
    /// The largest pressure \[Pa\]; it is infinite where the theory has a singularity.
    pub peak_pressure: f64,
}

/// Returns Hertz's solution for a paraboloid r²/2R that is pressed in by δ: a = √(Rδ), P = 4/3 E*
/// √R δ^{3/2}, p₀ = 3P/2πa² (Johnson, Contact Mechanics, 1985, eq. 4.22–4.24).
///
/// The arguments are E* \[Pa\], R \[m\] and δ \[m\].
pub fn hertz_sphere(modulus: f64, radius: f64, approach: f64) -> Indentation {
    let contact = (radius * approach).sqrt();
    let load = 4.0 / 3.0 * modulus * contact * approach;
    Indentation { load, radius: contact, peak_pressure: 1.5 * load / (PI * contact * contact) }
}

/// Returns the frictionless solution for a flat disk of radius a that is pressed in by δ: P = 2E*aδ
/// (Sneddon 1965, doi:10.1016/0020-7225(65)90019-4).
///
/// The arguments are E* \[Pa\], a \[m\] and δ \[m\].
pub fn flat_disk(modulus: f64, radius: f64, approach: f64) -> Indentation {
    Indentation { load: 2.0 * modulus * radius * approach, radius, peak_pressure: f64::INFINITY }
}

/// Returns the frictionless solution for a cone r tan β that is pressed in by δ: a = 2δ/(π tan β),
/// P = 2E*δ²/(π tan β) (Sneddon 1965, doi:10.1016/0020-7225(65)90019-4).
///
/// The arguments are E* \[Pa\], β \[rad\] and δ \[m\].
pub fn cone(modulus: f64, angle: f64, approach: f64) -> Indentation {
    let radius = 2.0 * approach / (PI * angle.tan());
    Indentation { load: modulus * radius * approach, radius, peak_pressure: f64::INFINITY }
}

/// Returns the load of an axisymmetric flat punch in full stick over the frictionless load at the
/// same approach, (1−ν) ln(3−4ν)/(1−2ν), which is 1 at ν = ½ (Mossakovskii, J. Appl. Math. Mech. 27
/// (1963) 418–427).
pub fn full_stick_load_ratio(poisson: f64) -> f64 {
    let x = 1.0 - 2.0 * poisson;
    (1.0 - poisson) * if x == 0.0 { 2.0 } else { (2.0 * x).ln_1p() / x }
}

/// Returns the stick radius over the contact radius after Cattaneo and Mindlin, (1 − Q/μP)^{1/3},
/// for 0 ≤ Q ≤ μP (Mindlin, J. Appl. Mech. 16 (1949) 259–268, doi:10.1115/1.4009973). It is exact
/// for like bodies with ν = 0.
///
/// The arguments are Q \[N\] and μP \[N\].
pub fn cattaneo_stick_ratio(tangential: f64, friction_limit: f64) -> f64 {
    (1.0 - tangential / friction_limit).max(0.0).cbrt()
}

/// Returns the rigid shift s \[m\] of like bodies under a tangential force Q after Cattaneo and
/// Mindlin, s = (3μP/16a) S (1 − (1 − Q/μP)^{2/3}) with S = Σ(2−ν)/G (Johnson, Contact Mechanics,
/// 1985, eq. 7.42).
///
/// The arguments are Q \[N\], μP \[N\], a \[m\] and S \[1/Pa\].
pub fn cattaneo_shift(
    tangential: f64,
    friction_limit: f64,
    contact_radius: f64,
    shear_compliance: f64,
) -> f64 {
    let stick_ratio = cattaneo_stick_ratio(tangential, friction_limit);
    3.0 * friction_limit / (16.0 * contact_radius)
        * shear_compliance
        * (1.0 - stick_ratio * stick_ratio)
}

/// An elliptic contact after Hertz's theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzEllipse {
    /// The semi-axis along x \[m\].
    pub semi_axis_x: f64,
    /// The semi-axis along y \[m\].
    pub semi_axis_y: f64,
    /// The largest pressure \[Pa\].
    pub peak_pressure: f64,
    /// The approach δ \[m\].
    pub approach: f64,
}

/// Returns Hertz's solution for a paraboloid with the gap A x² + B y² (A, B > 0 \[1/m\]) that is
/// pressed by the force P \[N\]; `modulus` is E* \[Pa\].
///
/// The formulas are those of Johnson, Contact Mechanics, 1985, eq. 4.25–4.30, with Carlson's
/// symmetric integrals in place of K and E, so that neither the circle nor the needle loses digits
/// and either axis may be the longer one: with κ = b/a, B/A = R_D(0,1,κ²)/R_D(0,κ²,1), a³ = P
/// R_D(0,κ²,1)/(2πE*A), p₀ = 3P/2πab, δ = 3P R_F(0,κ²,1)/(2πE*a).
pub fn hertz_ellipse(modulus: f64, curvature_x: f64, curvature_y: f64, load: f64) -> HertzEllipse {
    let target = (curvature_y / curvature_x).ln();
    // As a function of ln κ, ln(B/A) is nearly a straight line, which the secant method follows in
    // a few steps.
    let excess = |t: f64| {
        let m = (2.0 * t).exp();
        (carlson_rd(1.0, m) / carlson_rd(m, 1.0)).ln() - target
    };
    let (mut previous, mut t) = (0.0, -2.0 / 3.0 * target);
    let mut f_previous = excess(previous);
    for _ in 0..60 {
        let f = excess(t);
        if f == 0.0 || f == f_previous || t == previous {
            break;
        }
        let next = t - f * (t - previous) / (f - f_previous);
        (previous, f_previous) = (t, f);
        if (next - t).abs() <= 1e-16 * next.abs() {
            t = next;
            break;
        }
        t = next;
    }
    let ratio = t.exp();
    let m = ratio * ratio;
    let semi_axis_x = (load * carlson_rd(m, 1.0) / (2.0 * PI * modulus * curvature_x)).cbrt();
    let semi_axis_y = ratio * semi_axis_x;
    HertzEllipse {
        semi_axis_x,
        semi_axis_y,
        peak_pressure: 1.5 * load / (PI * semi_axis_x * semi_axis_y),
        approach: 1.5 * load * carlson_rf(m) / (PI * modulus * semi_axis_x),
    }
}

/// Returns the A and B \[1/m\] of the gap A x² + B y² under which [`hertz_ellipse`] has these
/// semi-axes along x and y \[m\], with E* = `modulus` \[Pa\] and the load P \[N\].
pub fn hertz_curvatures(modulus: f64, [a, b]: [f64; 2], load: f64) -> [f64; 2] {
    let unit = load / (2.0 * PI * modulus);
    let of = |a: f64, b: f64| unit * carlson_rd((b / a).powi(2), 1.0) / a.powi(3);
    [of(a, b), of(b, a)]
}

/// Returns Carlson's R_F(0, m, 1), the complete elliptic integral of the first kind, by the
/// arithmetic–geometric mean (NIST Digital Library of Mathematical Functions, 19.22.8).
fn carlson_rf(m: f64) -> f64 {
    let (mut a, mut g) = (1.0, m.sqrt());
    // The convergence is quadratic: a relative distance of 1e-8 becomes 1e-17 in the next mean.
    while (a - g).abs() > 1e-8 * a {
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
    }
    PI / (a + g)
}

/// Returns Carlson's R_D(0, y, z) for y, z > 0 by duplication (DLMF 19.26.20 and the series
/// 19.36.2).
fn carlson_rd(y: f64, z: f64) -> f64 {
    let (mut x, mut y, mut z) = (0.0_f64, y, z);
    let (mut sum, mut factor) = (0.0, 1.0);
    loop {
        let mean = 0.2 * (x + y + 3.0 * z);
        let [dx, dy, dz] = [x, y, z].map(|v| 1.0 - v / mean);
        if dx.abs().max(dy.abs()).max(dz.abs()) < 2e-3 {
            let (xy, zz) = (dx * dy, dz * dz);
            let e2 = xy - 6.0 * zz;
            let e3 = (3.0 * xy - 8.0 * zz) * dz;
            let e4 = 3.0 * (xy - zz) * zz;
            let e5 = xy * zz * dz;
            let series = 1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0
                - 3.0 * e4 / 22.0
                - 9.0 * e2 * e3 / 52.0
                + 3.0 * e5 / 26.0;
            return 3.0 * sum + factor * series / (mean * mean.sqrt());
        }
        let [rx, ry, rz] = [x, y, z].map(f64::sqrt);
        let lambda = rx * ry + ry * rz + rz * rx;
        sum += factor / (rz * (z + lambda));
        factor *= 0.25;
        [x, y, z] = [x, y, z].map(|v| 0.25 * (v + lambda));
    }
}

/// Returns the energy \[J\] that like spheres lose in a cycle of a tangential force between ±Q* at
/// constant load after Mindlin and Deresiewicz, ΔW = (9μ²P²S/10a) {1 − (1−q)^{5/3} − (5q/6)[1 +
/// (1−q)^{2/3}]}, q = Q*/μP (J. Appl. Mech. 20 (1953) 327–344, doi:10.1115/1.4010702).
///
/// S = Σ(2−ν)/G is that of [`cattaneo_shift`], and ΔW is the area of the loop that its shift
/// describes. The arguments are Q* \[N\], μP \[N\], a \[m\] and S \[1/Pa\].
pub fn mindlin_deresiewicz_loss(
    amplitude: f64,
    friction_limit: f64,
    contact_radius: f64,
    shear_compliance: f64,
) -> f64 {
    let q = (amplitude / friction_limit).clamp(0.0, 1.0);
    let rest = 1.0 - q;
    let bracket = 1.0 - rest.powf(5.0 / 3.0) - 5.0 * q / 6.0 * (1.0 + rest.powf(2.0 / 3.0));
    9.0 * friction_limit * friction_limit * shear_compliance / (10.0 * contact_radius) * bracket
}

/// Returns the moment \[N·m\] that tilts a flat disk of radius a by θ on a half-space, without
/// friction or without coupling and without lifting off: (8/3)θa³G/(1−ν) with E* = 2G/(1−ν)
/// (Johnson, Contact Mechanics, 1985, section 3.4).
///
/// The arguments are E* \[Pa\], a \[m\] and θ \[rad\].
pub fn tilted_disk(modulus: f64, radius: f64, tilt: f64) -> f64 {
    4.0 / 3.0 * modulus * radius.powi(3) * tilt
}

/// Returns the tangential force \[N\] that shifts a sticking, uncoupled disk of radius a by s after
/// Mindlin, 8as/S with S = Σ(2−ν)/G. [`cattaneo_shift`] gives the same law if nothing slips.
///
/// The arguments are S \[1/Pa\], a \[m\] and s \[m\].
pub fn shifted_disk(shear_compliance: f64, radius: f64, shift: f64) -> f64 {
    8.0 * radius * shift / shear_compliance
}

/// Returns the moment \[N·m\] that twists a sticking disk of radius a by φ after Reissner and
/// Sagoci, (16/3)φa³/Σ(1/G) (J. Appl. Phys. 15 (1944) 652, doi:10.1063/1.1707489).
///
/// The arguments are Σ(1/G) \[1/Pa\], a \[m\] and φ \[rad\].
pub fn twisted_disk(compliance: f64, radius: f64, twist: f64) -> f64 {
    16.0 / 3.0 * twist * radius.powi(3) / compliance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_stick_ratio_is_smooth_up_to_incompressible() {
        // At ν = 0 the ratio (1−ν) ln(3−4ν)/(1−2ν) is ln 3.
        assert!((full_stick_load_ratio(0.0) - 3f64.ln()).abs() < 1e-15);
        assert_eq!(full_stick_load_ratio(0.5), 1.0);
        assert!((full_stick_load_ratio(0.5 - 1e-9) - 1.0).abs() < 1e-8);
    }

    #[test]
    fn hertz_is_consistent_with_its_own_pressure() {
        // The load is the integral of the pressure: ∫ p₀√(1−r²/a²) = 2/3 p₀ π a².
        let hertz = hertz_sphere(2.0, 3.0, 0.5);
        assert!(
            (2.0 / 3.0 * hertz.peak_pressure * PI * hertz.radius.powi(2) / hertz.load - 1.0).abs()
                < 1e-15
        );
        // The stiffness is dP/dδ = 2E*a.
        let d = 1e-6;
        let slope = (hertz_sphere(2.0, 3.0, 0.5 + d).load - hertz_sphere(2.0, 3.0, 0.5 - d).load)
            / (2.0 * d);
        assert!((slope / (4.0 * hertz.radius) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_hertz_ellipse_meets_the_tabulated_one() {
        let text = include_str!("../../tests/reference/hertz_elliptic.csv");
        let mut rows = 0;
        // The head of the first column holds commas between its quotes.
        for line in text.lines().skip(1) {
            let row: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
            let [ratio, a, b, _, peak, approach] = row[..] else { panic!("{line}") };
            let ellipse = hertz_ellipse(1.0, 0.5 * ratio, 0.5, 1.0);
            let turned = hertz_ellipse(1.0, 0.5, 0.5 * ratio, 1.0);
            let found =
                [ellipse.semi_axis_x, ellipse.semi_axis_y, ellipse.peak_pressure, ellipse.approach];
            let other =
                [turned.semi_axis_y, turned.semi_axis_x, turned.peak_pressure, turned.approach];
            let [along, across] = hertz_curvatures(1.0, [found[0], found[1]], 1.0);
            assert!((along / (0.5 * ratio) - 1.0).abs() < 1e-12, "{along} {ratio}");
            assert!((across / 0.5 - 1.0).abs() < 1e-12, "{across}");
            for (value, expected) in
                found.iter().chain(&other).zip([a, b, peak, approach].iter().cycle())
            {
                assert!(
                    (value / expected - 1.0).abs() < 2e-14,
                    "A/B = {ratio}: {value} for {expected}"
                );
            }
            rows += 1;
        }
        assert!(rows >= 3, "{rows} rows");
    }

    #[test]
    fn the_hertz_ellipse_of_a_sphere_is_its_circle() {
        let (modulus, radius) = (3.0, 0.7);
        let circle = hertz_sphere(modulus, radius, 1e-3);
        let ellipse = hertz_ellipse(modulus, 0.5 / radius, 0.5 / radius, circle.load);
        for (value, expected) in [
            (ellipse.semi_axis_x, circle.radius),
            (ellipse.semi_axis_y, circle.radius),
            (ellipse.peak_pressure, circle.peak_pressure),
            (ellipse.approach, 1e-3),
        ] {
            assert!((value / expected - 1.0).abs() < 1e-14, "{value} for {expected}");
        }
    }

    #[test]
    fn long_hertz_ellipses_approach_the_line_contact() {
        // Far from its ends a long ellipse is a line contact of the load p' = 3P/4b' per length: a²
        // = 2p'/(πE*A) (Johnson eq. 4.43 with 1/2R = A), up to 1/ln of the aspect ratio.
        let ellipse = hertz_ellipse(1.0, 0.5, 0.5e-12, 1.0);
        let per_length = 0.75 / ellipse.semi_axis_y;
        let line = (2.0 * per_length / (PI * 0.5)).sqrt();
        assert!((ellipse.semi_axis_x / line - 1.0).abs() < 1e-6, "{} {line}", ellipse.semi_axis_x);
    }
}
