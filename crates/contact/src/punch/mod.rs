//! The punch's geometry: initial gap g₀, its mean over an element, the sole, and the Ω that a shape calls for.

mod contact_plane;
mod curve;
mod profile;
mod surface;
mod wheel_rail;

pub use contact_plane::{ContactPlane, Extent, Frame};
pub use curve::{Curve, CurvePoint};
pub use profile::{Profile, ProfileError, ProfileKind};
pub use surface::{Surface, SurfaceError, Surfaces};
pub use wheel_rail::{Curvatures, Position, Side, Touch, Track, WheelOnRail, WheelRailError, Wheelset};

use crate::loading::Control;
use crate::scene::{Base, Domain, Layer, Material, Scene, SceneError, Shape};

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

/// The Ω of a scene: the one it gives, else the one its punch and its path call for.
///
/// Under a smooth punch the contact lies inside the region where the rigid shapes would overlap (for a normal
/// compliance that is nowhere negative); Ω is that region with a margin, which for a sphere is 3a × 3a with a
/// Hertz's contact radius, over all steps of the path. Where the normal force is prescribed the approach is Hertz's for
/// the softest of the materials. Under a flat sole or a height map Ω is the sole's bounding box.
pub fn domain(scene: &Scene) -> Result<Domain, SceneError> {
    if let Some(domain) = scene.domain {
        return Ok(domain);
    }
    let centred = |width_x, width_y| Domain { width_x, width_y, center_x: 0.0, center_y: 0.0 };
    let compliance = softest(scene);
    let paraboloid = |radius_x: f64, radius_y: f64| {
        let radius = (radius_x * radius_y).sqrt();
        // Hertz with E* = 2/c: a³ = 3PRc/8, δ = a²/R
        let pressed = |force: f64| (0.375 * force * radius * compliance).cbrt().powi(2) / radius;
        cover(scene.loading.legs().iter().map(|leg| paraboloid_domain(radius_x, radius_y, &Pose::of(&leg.target, pressed))))
    };
    Ok(match scene.punch.shape {
        Shape::Sphere { radius } => paraboloid(radius, radius),
        Shape::Ellipsoid { radius_x, radius_y } => paraboloid(radius_x, radius_y),
        Shape::FlatRectangle { width_x, width_y } | Shape::HeightMap { width_x, width_y, .. } => centred(width_x, width_y),
        Shape::FlatDisk { radius } => centred(2.0 * radius, 2.0 * radius),
        Shape::Cone { angle } => {
            // Sneddon: P = 2E*δ²/(π tan β)
            let pressed = |force: f64| (0.25 * std::f64::consts::PI * force * angle.tan() * compliance).sqrt();
            let mut width = 0.0_f64;
            for leg in scene.loading.legs() {
                let pose = Pose::of(&leg.target, pressed);
                let slope = angle.tan() - pose.slope_x.hypot(pose.slope_y);
                if slope <= 0.0 {
                    return Err(SceneError {
                        key: "domain".to_owned(),
                        value: "not given".to_owned(),
                        expected: "must be given when the tilt is as steep as the cone".to_owned(),
                    });
                }
                // overlap radius δ/slope; a punch that does not reach has an empty contact on any Ω
                width = width.max(2.0 * if pose.approach == 0.0 { 1e-3 } else { pose.approach.abs() } / slope);
            }
            centred(width, width)
        }
    })
}

/// What a step says about where the punch is.
struct Pose {
    approach: f64,
    /// ∂f₁/∂x and ∂f₁/∂y.
    slope_x: f64,
    slope_y: f64,
    /// Centre of pressure that a prescribed force and moment ask for, 0 where they do not.
    center: [f64; 2],
}

impl Pose {
    /// The pose of these controls, with the approach that `pressed` makes of a normal force.
    fn of(target: &[Control; 6], pressed: impl Fn(f64) -> f64) -> Self {
        let motion = |which: usize| match target[which] {
            Control::Motion(value) => value,
            Control::Force(_) => 0.0,
        };
        let center = |which: usize| match (target[0], target[which]) {
            (Control::Force(force), Control::Force(moment)) => moment / force,
            _ => 0.0,
        };
        let approach = match target[0] {
            Control::Motion(approach) => approach,
            Control::Force(force) => pressed(force),
        };
        Self { approach, slope_x: -motion(4), slope_y: motion(3), center: [-center(4), center(3)] }
    }
}

/// Σ(1−ν)/G with the softest of the foundation's materials: no contact under a given load is larger than with it alone.
fn softest(scene: &Scene) -> f64 {
    let base = match scene.foundation.base {
        Base::Elastic(material) => Some(material),
        Base::Rigid => None,
    };
    let compliance = |material: Material| (1.0 - material.poisson) / material.shear_modulus;
    let layers = scene.foundation.layers.iter().map(Layer::material).chain(base);
    layers.map(compliance).fold(0.0, f64::max) + scene.punch.material.map_or(0.0, compliance)
}

/// The smallest rectangle that holds them all; of the same shape as one of them alone.
fn cover(domains: impl Iterator<Item = Domain>) -> Domain {
    let mut all: Option<Domain> = None;
    for next in domains {
        all = Some(match all {
            None => next,
            Some(all) if all == next => all,
            Some(all) => {
                let span = |center: f64, width: f64, other: f64, other_width: f64| {
                    let low = (center - 0.5 * width).min(other - 0.5 * other_width);
                    let high = (center + 0.5 * width).max(other + 0.5 * other_width);
                    (0.5 * (low + high), high - low)
                };
                let (center_x, width_x) = span(all.center_x, all.width_x, next.center_x, next.width_x);
                let (center_y, width_y) = span(all.center_y, all.width_y, next.center_y, next.width_y);
                Domain { width_x, width_y, center_x, center_y }
            }
        });
    }
    all.unwrap_or(Domain { width_x: 1.0, width_y: 1.0, center_x: 0.0, center_y: 0.0 })
}

/// A tilted paraboloid is the same paraboloid moved to its new lowest point, with a larger approach.
fn paraboloid_domain(radius_x: f64, radius_y: f64, pose: &Pose) -> Domain {
    let (slope_x, slope_y) = (pose.slope_x, pose.slope_y);
    let approach = pose.approach + (slope_x * slope_x * radius_x + slope_y * slope_y * radius_y) / 2.0;
    let approach = if approach == 0.0 { 1e-6 * radius_x.min(radius_y) } else { approach.abs() };
    Domain {
        width_x: 3.0 * (radius_x * approach).sqrt(),
        width_y: 3.0 * (radius_y * approach).sqrt(),
        center_x: slope_x * radius_x + pose.center[0],
        center_y: slope_y * radius_y + pose.center[1],
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
        scene.loading.steps[0].tilt_x = Some(0.01);
        let Shape::Sphere { radius } = scene.punch.shape else { panic!() };
        let domain = domain(&scene).unwrap();
        // f₁ = δ + tilt_x y − y²/2R has its maximum at y = R tilt_x
        assert!((domain.center_y / (0.01 * radius) - 1.0).abs() < 1e-14);
        assert_eq!(domain.center_x, 0.0);
    }
}
