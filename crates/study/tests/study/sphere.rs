//! The study of a sphere to which most tests add lines.

/// A sphere that is pressed by 1 µm, without an axis. Lines that follow belong to `[numerics]`.
pub(crate) const SPHERE: &str = r#"name = "base"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "10 mm" }
friction.mu = 0.3
loading.steps = [{ approach = "1 um" }]
[numerics]
mesh = 16
"#;

/// Returns the study with lines before its tables and lines after them.
pub(crate) fn sphere(before: &str, after: &str) -> String {
    let tables = SPHERE.replacen("[scene]", &format!("{before}[scene]"), 1);
    format!("{tables}{after}")
}
