//! The initial gap g₀ under a punch, and its mean over an element.

use std::sync::Arc;

use super::placement::PlacedWheel;
use super::surface::{Surface, Surfaces};
use crate::model::{Projection, Scene, SceneError, Shape};

/// A shape that is ready to be sampled: the shape of a scene with the height map or the profiles
/// that it names.
pub(crate) struct Gap<'a> {
    shape: &'a Shape,
    sampled: Sampled<'a>,
}

enum Sampled<'a> {
    Not,
    Map(&'a Surface),
    Plane(Arc<PlacedWheel>),
}

impl<'a> Gap<'a> {
    /// Prepares the gap under the punch of `scene`.
    ///
    /// # Errors
    /// A [`SceneError`] names a surface of the scene that `surfaces` does not hold, or says why a
    /// wheel does not meet its rail.
    pub(crate) fn new(scene: &'a Scene, surfaces: &'a Surfaces) -> Result<Self, SceneError> {
        let shape = &scene.punch.shape;
        let missing = |key: &str, name: &str, what: &str| SceneError {
            key: key.to_owned(),
            value: name.to_owned(),
            expected: format!("names {what} that was not supplied"),
        };
        let sampled = match shape {
            Shape::HeightMap { surface, .. } => Sampled::Map(
                surfaces
                    .get(surface)
                    .ok_or_else(|| missing("punch.surface", surface, "a height map"))?,
            ),
            Shape::WheelOnRail(rail) => {
                let profile = |key: &str, name: &str| {
                    surfaces
                        .profile(name)
                        .ok_or_else(|| missing(&format!("punch.{key}"), name, "a profile"))
                };
                let profiles = [profile("wheel", &rail.wheel)?, profile("rail", &rail.rail)?];
                Sampled::Plane(surfaces.placed().place(scene, rail, profiles)?)
            }
            _ => Sampled::Not,
        };
        Ok(Self { shape, sampled })
    }

    /// Returns the initial gap g₀ ≥ 0 \[m\] at (x, y) \[m\]. It is `None` where the punch has no
    /// sole, that is, where it cannot touch at all.
    pub(crate) fn at(&self, x: f64, y: f64) -> Option<f64> {
        if !self.has_sole(x, y) {
            return None;
        }
        match (self.shape, &self.sampled) {
            (Shape::Sphere { radius }, _) => Some((x * x + y * y) / (2.0 * radius)),
            (Shape::Ellipsoid { radius_x, radius_y }, _) => {
                Some(x * x / (2.0 * radius_x) + y * y / (2.0 * radius_y))
            }
            (Shape::FlatRectangle { .. } | Shape::FlatDisk { .. }, _) => Some(0.0),
            (Shape::Cone { angle }, _) => Some(x.hypot(y) * angle.tan()),
            (Shape::HeightMap { width_x, width_y, .. }, Sampled::Map(surface)) => {
                Some(surface.gap_at(x / width_x + 0.5, y / width_y + 0.5))
            }
            (Shape::WheelOnRail(_), Sampled::Plane(wheel)) => wheel.plane.gap(x, y),
            (Shape::HeightMap { .. } | Shape::WheelOnRail(_), _) => {
                unreachable!("Gap::new supplies the surface")
            }
        }
    }

    /// Returns the mean of g₀ \[m\] over the element hx × hy \[m\] centred at (x, y) \[m\], or
    /// `None` where the punch has no sole.
    pub(crate) fn mean(&self, x: f64, y: f64, hx: f64, hy: f64) -> Option<f64> {
        if !self.has_sole(x, y) {
            return None;
        }
        match (self.shape, &self.sampled) {
            // The mean ⟨x²⟩ over an element is x² + hx²/12.
            (Shape::Sphere { radius }, _) => {
                Some((x * x + y * y + (hx * hx + hy * hy) / 12.0) / (2.0 * radius))
            }
            (Shape::Ellipsoid { radius_x, radius_y }, _) => Some(
                (x * x + hx * hx / 12.0) / (2.0 * radius_x)
                    + (y * y + hy * hy / 12.0) / (2.0 * radius_y),
            ),
            (Shape::FlatRectangle { .. } | Shape::FlatDisk { .. }, _) => Some(0.0),
            (Shape::Cone { angle }, _) => Some(mean_distance(x, y, hx, hy) * angle.tan()),
            (Shape::HeightMap { width_x, width_y, .. }, Sampled::Map(surface)) => {
                Some(surface.mean_gap(
                    [(x - hx / 2.0) / width_x + 0.5, (x + hx / 2.0) / width_x + 0.5],
                    [(y - hy / 2.0) / width_y + 0.5, (y + hy / 2.0) / width_y + 0.5],
                ))
            }
            (Shape::WheelOnRail(_), Sampled::Plane(wheel)) => wheel.plane.mean_gap(x, y, hx, hy),
            (Shape::HeightMap { .. } | Shape::WheelOnRail(_), _) => {
                unreachable!("Gap::new supplies the surface")
            }
        }
    }

    fn has_sole(&self, x: f64, y: f64) -> bool {
        // Only rounding decides if the centre of an element lies on the edge of a sole. Such an
        // element belongs to the sole.
        let slack = 1.0 + 1e-12;
        match self.shape {
            // The gap itself is `None` where a wheel is not above its rail.
            Shape::Sphere { .. }
            | Shape::Ellipsoid { .. }
            | Shape::Cone { .. }
            | Shape::WheelOnRail(_) => true,
            Shape::FlatRectangle { width_x, width_y }
            | Shape::HeightMap { width_x, width_y, .. } => {
                let is_inside =
                    x.abs() <= 0.5 * width_x * slack && y.abs() <= 0.5 * width_y * slack;
                let has_pixel =
                    |surface: &Surface| surface.has_sole(x / width_x + 0.5, y / width_y + 0.5);
                is_inside
                    && match &self.sampled {
                        Sampled::Map(surface) => has_pixel(surface),
                        Sampled::Not | Sampled::Plane(..) => true,
                    }
            }
            Shape::FlatDisk { radius } => x.hypot(y) <= radius * slack,
        }
    }

    /// Returns a row of gaps \[m\]: for each of the ascending `xs` \[m\] the [gap](Gap::at) at (x,
    /// y) or the [mean](Gap::mean) over the element hx × hy \[m\] there. A row costs less than its
    /// elements one by one.
    pub(crate) fn row(
        &self,
        projection: Projection,
        xs: &[f64],
        y: f64,
        [hx, hy]: [f64; 2],
    ) -> Vec<Option<f64>> {
        match (&self.sampled, projection) {
            (Sampled::Plane(wheel), Projection::Average) => wheel.plane.mean_gaps(xs, y, hx, hy),
            (_, Projection::Average) => xs.iter().map(|x| self.mean(*x, y, hx, hy)).collect(),
            (_, Projection::Midpoint) => xs.iter().map(|x| self.at(*x, y)).collect(),
        }
    }

    /// Returns the wheel on its rail, if the punch is a wheel.
    pub(crate) fn wheel_on_rail(&self) -> Option<&PlacedWheel> {
        match &self.sampled {
            Sampled::Plane(wheel) => Some(wheel),
            Sampled::Not | Sampled::Map(_) => None,
        }
    }

    /// Returns the principal curvatures \[1/m\] of a smooth gap where it is smallest, the smaller
    /// one first. It is `None` where Hertz's theory does not apply.
    pub(crate) fn curvatures(&self) -> Option<[f64; 2]> {
        let curvatures = match (self.shape, &self.sampled) {
            (Shape::Sphere { radius }, _) => [1.0 / radius; 2],
            (Shape::Ellipsoid { radius_x, radius_y }, _) => {
                [1.0 / radius_x.max(*radius_y), 1.0 / radius_x.min(*radius_y)]
            }
            (_, Sampled::Plane(wheel)) => wheel.pair.curvatures().principal().0,
            _ => return None,
        };
        (curvatures[0] > 0.0).then_some(curvatures)
    }
}

/// Returns the mean distance from the origin over the rectangle hx × hy centred at (x, y). Where
/// cancellation leaves it exact, it is the second difference of an F with F_xy = r, F = x y r/3 +
/// (x³ asinh(y/|x|) + y³ asinh(x/|y|))/6; elsewhere it is a fourth-order Taylor expansion about the
/// centre.
fn mean_distance(x: f64, y: f64, hx: f64, hy: f64) -> f64 {
    let r = x.hypot(y);
    if r > 200.0 * hx.max(hy) {
        // The expansion is r + (hx² r_xx + hy² r_yy)/24; the next term is below (h/r)⁴/500.
        return r + (hx * hx * y * y + hy * hy * x * x) / (24.0 * r * r * r);
    }
    let cube_asinh =
        |a: f64, b: f64| if a == 0.0 { 0.0 } else { a.powi(3) * (b / a.abs()).asinh() };
    let f = |x: f64, y: f64| x * y * x.hypot(y) / 3.0 + (cube_asinh(x, y) + cube_asinh(y, x)) / 6.0;
    let (x0, x1, y0, y1) = (x - hx / 2.0, x + hx / 2.0, y - hy / 2.0, y + hy / 2.0);
    (f(x1, y1) - f(x0, y1) - f(x1, y0) + f(x0, y0)) / (hx * hy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_distance_matches_quadrature_and_its_own_far_form() {
        // The reference is a midpoint rule with 400 × 400 points, which is good to 1e-7 away from
        // the kink.
        let numeric = |x: f64, y: f64, hx: f64, hy: f64| {
            let n = 400;
            let offset = |i: usize, h: f64| ((i as f64 + 0.5) / n as f64 - 0.5) * h;
            let sum: f64 =
                (0..n * n).map(|s| (x + offset(s % n, hx)).hypot(y + offset(s / n, hy))).sum();
            sum / (n * n) as f64
        };
        for (x, y, hx, hy) in [
            (0.0, 0.0, 1.0, 1.0),
            (0.5, 0.5, 1.0, 1.0),
            (3.0, -2.0, 1.0, 0.2),
            (0.0, 5.0, 0.3, 2.0),
        ] {
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
        let scene = crate::model::sphere_on_half_space();
        let mut scene = Scene {
            punch: crate::model::Punch {
                shape: Shape::Ellipsoid { radius_x: 2.0, radius_y: 0.7 },
                material: None,
            },
            ..scene
        };
        for shape in
            [Shape::Ellipsoid { radius_x: 2.0, radius_y: 0.7 }, Shape::Sphere { radius: 1.3 }]
        {
            scene.punch.shape = shape;
            let gap = Gap::new(&scene, &surfaces).unwrap();
            // The two-point Gauss rule is exact for a quadratic.
            let g = 0.5 / 3f64.sqrt();
            let (x, y, hx, hy) = (0.3, -0.8, 0.2, 0.5);
            let gauss: f64 = [(-g, -g), (g, -g), (-g, g), (g, g)]
                .iter()
                .map(|(s, t)| gap.at(x + s * hx, y + t * hy).unwrap() / 4.0)
                .sum();
            assert!((gap.mean(x, y, hx, hy).unwrap() / gauss - 1.0).abs() < 1e-14);
        }
    }
}
