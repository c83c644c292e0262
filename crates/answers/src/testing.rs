//! Studies for tests.

use study::Study;

/// A sphere of 50 mm, pressed 20 µm into a half-space.
pub(crate) const SPHERE: &str = r#"
name = "sphere"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch = { shape = "sphere", radius = "50 mm" }
friction.mu = 0.3
loading.steps = [{ approach = "20 um" }]
[numerics]
mesh = 8
"#;

/// Returns the study of a sphere with more tables at its end.
pub(crate) fn study(tables: &str) -> Study {
    let text = format!("{SPHERE}{tables}");
    Study::parse(&text, "sphere.toml", &mut |file| Err(format!("no file {file}")))
        .unwrap_or_else(|error| panic!("{}", error.render(false)))
}
