//! Coulomb friction as a projection: the pointwise maps of Alexandrov's equation (1) and its
//! regularisation (3).

/// Returns h(t) = max(t, 0).
pub(crate) fn h(t: f64) -> f64 {
    t.max(0.0)
}

/// Returns h_u(t), which is t clamped to \[0, u\], with u ≥ 0 the ceiling on the pressure (infinite
/// for none).
pub(crate) fn h_u(t: f64, u: f64) -> f64 {
    h(t).min(u)
}

/// Returns q(x, y, z), the projection of (x, y) onto the disk of radius z ≥ 0.
pub(crate) fn q(x: f64, y: f64, z: f64) -> [f64; 2] {
    let length = x.hypot(y);
    if length <= z { [x, y] } else { [z * (x / length), z * (y / length)] }
}

/// Returns y = Gᵘ_μ(x): y₁ = h_u(x₁), and (y₂, y₃) is (x₂, x₃) projected onto the disk of radius
/// μ y₁. With u infinite this is the G_μ of equation (1). Components are in the order (n, x, y).
pub(crate) fn g_mu(x: [f64; 3], mu: f64, u: f64) -> [f64; 3] {
    let pressure = h_u(x[0], u);
    let [traction_x, traction_y] = q(x[1], x[2], mu * pressure);
    [pressure, traction_x, traction_y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn h_and_h_u_clamp() {
        assert_eq!([h(-1.0), h(0.0), h(2.0)], [0.0, 0.0, 2.0]);
        assert_eq!(
            [h_u(-1.0, 3.0), h_u(2.0, 3.0), h_u(4.0, 3.0), h_u(4.0, f64::INFINITY)],
            [0.0, 2.0, 3.0, 4.0]
        );
    }

    #[test]
    fn no_friction_and_no_pressure_leave_no_traction() {
        assert_eq!(g_mu([1.0, 5.0, -7.0], 0.0, f64::INFINITY), [1.0, 0.0, 0.0]);
        assert_eq!(g_mu([-1.0, 5.0, -7.0], 0.3, f64::INFINITY)[0], 0.0);
        assert_eq!(g_mu([-1.0, 5.0, -7.0], 0.3, f64::INFINITY)[1].abs(), 0.0);
    }

    #[test]
    fn projection_survives_the_extremes_of_doubles() {
        let [x, y] = q(3e300, 4e300, 1e300);
        assert!((x / 0.6e300 - 1.0).abs() < 1e-15 && (y / 0.8e300 - 1.0).abs() < 1e-15);
        let [x, y] = q(3e-310, 4e-310, 1e-310);
        assert!((x.hypot(y) / 1e-310 - 1.0).abs() < 1e-10);
    }

    proptest! {
        #[test]
        fn g_mu_projects_into_the_cone_and_is_idempotent(
            x in prop::array::uniform3(-1e3..1e3f64), mu in 0.0..3.0f64, u in 0.0..1e3f64,
        ) {
            let y = g_mu(x, mu, u);
            prop_assert!(y[0] >= 0.0 && y[0] <= u);
            prop_assert!(y[1].hypot(y[2]) <= mu * y[0] * (1.0 + 4.0 * f64::EPSILON));
            let z = g_mu(y, mu, u);
            for c in 0..3 {
                prop_assert!((z[c] - y[c]).abs() <= 1e-12 * (1.0 + y[c].abs()));
            }
            // A vector that the disk cuts off keeps its direction.
            prop_assert!((y[1] * x[2] - y[2] * x[1]).abs() <= 1e-9);
            prop_assert!(y[1] * x[1] + y[2] * x[2] >= 0.0);
        }
    }
}
