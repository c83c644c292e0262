//! The punch's geometry: initial gap g₀, its mean over an element, the sole, and the Ω that a shape calls for.

mod surface;

pub use surface::{Surface, SurfaceError, Surfaces};

use crate::scene::{Domain, Scene, SceneError, Shape, Step};

/// A shape ready to be sampled: the scene's, with the height map it names.
pub struct Gap<'a> {
    shape: &'a Shape,
    surface: Option<&'a Surface>,
}

impl<'a> Gap<'a> {
    /// The gap under `scene`'s punch. Fails when the scene names a surface that `surfaces` has not.
    pub fn new(scene: &'a Scene, surfaces: &'a Surfaces) -> Result<Self, SceneError> {
        let shape = &scene.punch.shape;
        let surface = match shape {
            Shape::HeightMap { surface, .. } => Some(surfaces.get(surface).ok_or_else(|| SceneError {
                key: "punch.surface".to_owned(),
                value: surface.clone(),
                expected: "names a height map that was not supplied".to_owned(),
            })?),
            _ => None,
        };
        Ok(Self { shape, surface: surface.map(std::convert::AsRef::as_ref) })
    }

    /// Initial gap g₀ ≥ 0 \[m\] at (x, y) \[m\].
    pub fn at(&self, x: f64, y: f64) -> f64 {
        match (self.shape, self.surface) {
            (Shape::Sphere { radius }, _) => (x * x + y * y) / (2.0 * radius),
            (Shape::Ellipsoid { radius_x, radius_y }, _) => x * x / (2.0 * radius_x) + y * y / (2.0 * radius_y),
            (Shape::FlatRectangle { .. } | Shape::FlatDisk { .. }, _) => 0.0,
            (Shape::Cone { angle }, _) => x.hypot(y) * angle.tan(),
            (Shape::HeightMap { width_x, width_y, .. }, Some(surface)) => surface.gap_at(x / width_x + 0.5, y / width_y + 0.5),
            (Shape::HeightMap { .. }, None) => unreachable!("Gap::new supplies the surface"),
        }
    }

    /// Mean of g₀ \[m\] over the element hx × hy \[m\] centred at (x, y) \[m\].
    pub fn mean(&self, x: f64, y: f64, hx: f64, hy: f64) -> f64 {
        match (self.shape, self.surface) {
            // ⟨x²⟩ over an element is x² + hx²/12
            (Shape::Sphere { radius }, _) => (x * x + y * y + (hx * hx + hy * hy) / 12.0) / (2.0 * radius),
            (Shape::Ellipsoid { radius_x, radius_y }, _) => {
                (x * x + hx * hx / 12.0) / (2.0 * radius_x) + (y * y + hy * hy / 12.0) / (2.0 * radius_y)
            }
            (Shape::FlatRectangle { .. } | Shape::FlatDisk { .. }, _) => 0.0,
            (Shape::Cone { angle }, _) => mean_distance(x, y, hx, hy) * angle.tan(),
            (Shape::HeightMap { width_x, width_y, .. }, Some(surface)) => surface.mean_gap(
                [(x - hx / 2.0) / width_x + 0.5, (x + hx / 2.0) / width_x + 0.5],
                [(y - hy / 2.0) / width_y + 0.5, (y + hy / 2.0) / width_y + 0.5],
            ),
            (Shape::HeightMap { .. }, None) => unreachable!("Gap::new supplies the surface"),
        }
    }

    /// Whether the punch has a sole at (x, y) \[m\], that is, can touch there at all.
    pub fn has_sole(&self, x: f64, y: f64) -> bool {
        // an element's centre lies on a sole's edge only by rounding; such an element belongs to it
        let slack = 1.0 + 1e-12;
        match self.shape {
            Shape::Sphere { .. } | Shape::Ellipsoid { .. } | Shape::Cone { .. } => true,
            Shape::FlatRectangle { width_x, width_y } | Shape::HeightMap { width_x, width_y, .. } => {
                x.abs() <= 0.5 * width_x * slack && y.abs() <= 0.5 * width_y * slack
            }
            Shape::FlatDisk { radius } => x.hypot(y) <= radius * slack,
        }
    }
}

/// Mean distance from the origin over the rectangle hx × hy centred at (x, y): the second difference of an F with
/// F_xy = r, F = x y r/3 + (x³ asinh(y/|x|) + y³ asinh(x/|y|))/6, where cancellation leaves it exact, else a
/// fourth-order Taylor expansion about the centre.
fn mean_distance(x: f64, y: f64, hx: f64, hy: f64) -> f64 {
    let r = x.hypot(y);
    if r > 200.0 * hx.max(hy) {
        // r + (hx² r_xx + hy² r_yy)/24; the next term is below (h/r)⁴/500
        return r + (hx * hx * y * y + hy * hy * x * x) / (24.0 * r * r * r);
    }
    let cube_asinh = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a.powi(3) * (b / a.abs()).asinh() };
    let f = |x: f64, y: f64| x * y * x.hypot(y) / 3.0 + (cube_asinh(x, y) + cube_asinh(y, x)) / 6.0;
    let (x0, x1, y0, y1) = (x - hx / 2.0, x + hx / 2.0, y - hy / 2.0, y + hy / 2.0);
    (f(x1, y1) - f(x0, y1) - f(x1, y0) + f(x0, y0)) / (hx * hy)
}

/// The Ω of a scene: the one it gives, else the one its punch calls for.
///
/// Under a smooth punch the contact lies inside the region where the rigid shapes would overlap (for a normal
/// compliance that is nowhere negative); Ω is that region with a margin, which for a sphere is 3a × 3a with a
/// Hertz's contact radius. Under a flat sole or a height map Ω is the sole's bounding box.
pub fn domain(scene: &Scene) -> Result<Domain, SceneError> {
    if let Some(domain) = scene.domain {
        return Ok(domain);
    }
    let step = scene.loading.steps.first().copied().unwrap_or_default();
    let centred = |width_x, width_y| Domain { width_x, width_y, center_x: 0.0, center_y: 0.0 };
    Ok(match scene.punch.shape {
        Shape::Sphere { radius } => paraboloid_domain(radius, radius, &step),
        Shape::Ellipsoid { radius_x, radius_y } => paraboloid_domain(radius_x, radius_y, &step),
        Shape::FlatRectangle { width_x, width_y } | Shape::HeightMap { width_x, width_y, .. } => centred(width_x, width_y),
        Shape::FlatDisk { radius } => centred(2.0 * radius, 2.0 * radius),
        Shape::Cone { angle } => {
            let slope = angle.tan() - step.tilt_x.hypot(step.tilt_y);
            if slope <= 0.0 {
                return Err(SceneError {
                    key: "domain".to_owned(),
                    value: "not given".to_owned(),
                    expected: "must be given when the tilt is as steep as the cone".to_owned(),
                });
            }
            // overlap radius δ/slope; a punch that does not reach has an empty contact on any Ω
            let width = 2.0 * if step.approach == 0.0 { 1e-3 } else { step.approach.abs() } / slope;
            centred(width, width)
        }
    })
}

/// A tilted paraboloid is the same paraboloid moved to its new lowest point, with a larger approach.
fn paraboloid_domain(radius_x: f64, radius_y: f64, step: &Step) -> Domain {
    let (slope_x, slope_y) = (-step.tilt_y, step.tilt_x);
    let approach = step.approach + (slope_x * slope_x * radius_x + slope_y * slope_y * radius_y) / 2.0;
    let approach = if approach == 0.0 { 1e-6 * radius_x.min(radius_y) } else { approach.abs() };
    Domain {
        width_x: 3.0 * (radius_x * approach).sqrt(),
        width_y: 3.0 * (radius_y * approach).sqrt(),
        center_x: slope_x * radius_x,
        center_y: slope_y * radius_y,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_distance_matches_quadrature_and_its_own_far_form() {
        // 400 × 400 midpoint rule; away from the kink it is good to 1e-7
        let numeric = |x: f64, y: f64, hx: f64, hy: f64| {
            let n = 400;
            let at = |i: usize, h: f64| ((i as f64 + 0.5) / n as f64 - 0.5) * h;
            let sum: f64 = (0..n * n).map(|s| (x + at(s % n, hx)).hypot(y + at(s / n, hy))).sum();
            sum / (n * n) as f64
        };
        for (x, y, hx, hy) in [(0.0, 0.0, 1.0, 1.0), (0.5, 0.5, 1.0, 1.0), (3.0, -2.0, 1.0, 0.2), (0.0, 5.0, 0.3, 2.0)] {
            let exact = mean_distance(x, y, hx, hy);
            assert!((exact / numeric(x, y, hx, hy) - 1.0).abs() < 3e-6, "{x} {y}: {exact}");
        }
        let (x, y): (f64, f64) = (160.0, -130.0);
        let far = x.hypot(y) + (0.09 * y * y + 1.0 * x * x) / (24.0 * x.hypot(y).powi(3));
        assert!((mean_distance(x, y, 0.3, 1.0) / far - 1.0).abs() < 1e-10);
    }

    #[test]
    fn means_of_smooth_shapes_match_quadrature() {
        let surfaces = Surfaces::default();
        let scene = crate::scene::tests::sphere_on_half_space();
        let mut scene =
            Scene { punch: crate::scene::Punch { shape: Shape::Ellipsoid { radius_x: 2.0, radius_y: 0.7 }, material: None }, ..scene };
        for shape in [Shape::Ellipsoid { radius_x: 2.0, radius_y: 0.7 }, Shape::Sphere { radius: 1.3 }] {
            scene.punch.shape = shape;
            let gap = Gap::new(&scene, &surfaces).unwrap();
            // two-point Gauss is exact for a quadratic
            let g = 0.5 / 3f64.sqrt();
            let (x, y, hx, hy) = (0.3, -0.8, 0.2, 0.5);
            let gauss: f64 = [(-g, -g), (g, -g), (-g, g), (g, g)].iter().map(|(s, t)| gap.at(x + s * hx, y + t * hy) / 4.0).sum();
            assert!((gap.mean(x, y, hx, hy) / gauss - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn a_tilted_sphere_gets_its_domain_where_it_touches() {
        let mut scene = crate::scene::tests::sphere_on_half_space();
        scene.loading.steps[0].tilt_x = 0.01;
        let Shape::Sphere { radius } = scene.punch.shape else { panic!() };
        let domain = domain(&scene).unwrap();
        // f₁ = δ + tilt_x y − y²/2R has its maximum at y = R tilt_x
        assert!((domain.center_y / (0.01 * radius) - 1.0).abs() < 1e-14);
        assert_eq!(domain.center_x, 0.0);
    }
}
