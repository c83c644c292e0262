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
