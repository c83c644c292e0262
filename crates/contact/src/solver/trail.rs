//! The tractions of a contact that rolls, from the difference of each to the one ahead.
//!
//! In steady rolling an element gains the displacement A (p − p′), where p′ are the tractions a
//! rolled distance ahead. Once p − p′ is known, the tractions follow from the leading edge
//! backwards, because there is nothing ahead of it. Between two elements p′ is taken linear.

use super::free::{ContactElement, ContactState, Free};

/// The way from each element to what is ahead of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ahead {
    /// The whole elements on the way to the nearer one of the two between which it lies.
    whole: usize,
    /// The share of the farther one.
    share: f64,
    /// The leading edge lies at the last column if true, at the first one if not.
    is_forward: bool,
}

impl Ahead {
    /// Takes the distance in elements, with its sign along x.
    pub(super) fn new(elements: f64) -> Self {
        let size = elements.abs();
        let whole = size.floor();
        Self { whole: whole as usize, share: size - whole, is_forward: elements > 0.0 }
    }

    /// Returns the part of an element's traction that its own difference has.
    fn own_share(&self) -> f64 {
        if self.whole == 0 { self.share } else { 1.0 }
    }

    /// Sums `differences`, a field on the window around the contact, to tractions from the leading
    /// edge backwards; writes the tangential ones of each place of the window to `sums`. On a
    /// slipping element the traction along its direction is `mu` times the normal one, and
    /// the one across gives way by `yielding`(σ) beside its own difference.
    pub(super) fn sum(
        &self,
        free: &Free,
        mu: f64,
        differences: &[f64],
        yielding: impl Fn(f64) -> f64,
        sums: &mut Vec<[f64; 2]>,
    ) {
        let window = *free.window();
        sums.clear();
        sums.resize(window.len(), [0.0; 2]);
        let own_share = self.own_share();
        let mut add = |(element, place): (&ContactElement, usize)| {
            let column = place % window.size[0];
            let [normal, x, y] = free.at(differences, place);
            let ahead = |steps: usize| {
                if self.is_forward {
                    (column + steps < window.size[0]).then(|| sums[place + steps])
                } else {
                    (steps <= column).then(|| sums[place - steps])
                }
                .unwrap_or_default()
            };
            let near = if self.whole == 0 { [0.0; 2] } else { ahead(self.whole) };
            let far = if self.share == 0.0 { [0.0; 2] } else { ahead(self.whole + 1) };
            let [x, y] = [(x, near[0], far[0]), (y, near[1], far[1])]
                .map(|(gain, near, far)| gain + (1.0 - self.share) * near + self.share * far);
            sums[place] = match element.state {
                ContactState::Stick => [x / own_share, y / own_share],
                ContactState::Slip { n, sigma } => {
                    let along = if element.pressed { mu * normal } else { 0.0 };
                    let across = if sigma.is_finite() {
                        (y * n[0] - x * n[1]) / (own_share + yielding(sigma))
                    } else {
                        0.0
                    };
                    [along * n[0] - across * n[1], along * n[1] + across * n[0]]
                }
            };
        };
        if self.is_forward {
            free.elements().rev().for_each(&mut add);
        } else {
            free.elements().for_each(&mut add);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::influence::Window;
    use crate::model::{Mesh, Numerics, sphere_on_half_space};
    use crate::problem::Problem;
    use crate::punch::Surfaces;

    /// Sums of the differences to what is ahead are the tractions again, and a slipping element
    /// has along its direction what its pressure gives.
    #[test]
    fn sums_undo_differences() {
        let numerics: Numerics = serde_json::from_str(r#"{"mesh": 8}"#).unwrap();
        let numerics = Numerics { mesh: Mesh::Exact([9, 5]), ..numerics };
        let problem = Problem::new(&sphere_on_half_space(), &numerics, &Surfaces::new()).unwrap();
        let window = Window::whole(&problem.grid);
        let touches = |place: usize| place % 9 > place / 9 && place % 7 != 3;
        let slips = ContactState::Slip { n: [0.6, 0.8], sigma: f64::INFINITY };
        let elements: Vec<ContactElement> = (0..45)
            .filter(|place| touches(*place))
            .map(|place| ContactElement {
                i: (place % 9) as u32,
                j: (place / 9) as u32,
                pressed: true,
                state: if place == 25 { slips } else { ContactState::Stick },
            })
            .collect();
        let free = Free::new(&problem, window, &elements);
        let (mu, pressure) = (0.3, 2.0);
        let traction = |place: usize| match place {
            25 => [mu * pressure * 0.6, mu * pressure * 0.8],
            _ if touches(place) => [(place as f64).sin(), (place as f64).cos()],
            _ => [0.0; 2],
        };
        for elements in [1.0_f64, -1.0, 2.0, -3.0, 0.3, -0.1, 1.7, -2.25, 20.0] {
            let mut differences = vec![pressure; 3 * 45];
            for place in 0..45 {
                let (whole, share) = (elements.abs().floor(), elements.abs().fract());
                let ahead = |steps: f64| {
                    let column = (place % 9) as f64 + steps * elements.signum();
                    let is_inside = (0.0..9.0).contains(&column);
                    if is_inside { traction(place / 9 * 9 + column as usize) } else { [0.0; 2] }
                };
                let (near, far) = (ahead(whole), ahead(whole + 1.0));
                for c in 0..2 {
                    let between = (1.0 - share) * near[c] + share * far[c];
                    differences[(c + 1) * 45 + place] = traction(place)[c] - between;
                }
            }
            let mut sums = Vec::new();
            Ahead::new(elements).sum(&free, mu, &differences, |_| 0.0, &mut sums);
            for (place, sum) in sums.into_iter().enumerate() {
                for (got, exact) in sum.into_iter().zip(traction(place)) {
                    assert!((got - exact).abs() < 1e-9, "{elements} {place}: {got} {exact}");
                }
            }
        }
    }
}
