//! μ* falls from a domain to a larger one, against which brackets are held.
//!
//! Let Ω be part of Ω′, with elements of the same size and the same bodies. A field on Ω is one on
//! Ω′ with zeros on the other elements. There x₁y₁ = 0 and x_t·y_t = 0, so they ask for no
//! friction, and at the elements of Ω the displacements are what they were. So every field of Ω
//! needs the same friction on Ω′, and μ*(Ω′) ≤ μ*(Ω). A bracket on Ω′ that begins above the end of
//! one on Ω contradicts it: one of the two is wrong.

use super::question::{Question, Sole};
use crate::model::Base;

/// The relative difference of lengths and moduli that counts as none.
const ALIKE: f64 = 1e-9;

/// Two brackets that cannot both be right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contradiction {
    /// The index of the bracket on the smaller domain, which ends too early.
    pub smaller: usize,
    /// The index of the bracket on the larger domain, which begins too late.
    pub larger: usize,
}

/// Says if the elements of a rectangular Ω can be laid on those of another, with the same operator.
/// The operator of half-spaces has no length, so there the elements need only be similar.
fn is_part_of(part: &Question, whole: &Question) -> bool {
    let (Some(small), Some(large)) = (elements(part), elements(whole)) else { return false };
    let near = |a: f64, b: f64| (a - b).abs() <= ALIKE * a.abs().max(b.abs());
    let has_no_length =
        part.foundation.layers.is_empty() && matches!(part.foundation.base, Base::Elastic(_));
    let same_elements = if has_no_length {
        near(small.size[0] * large.size[1], small.size[1] * large.size[0])
    } else {
        near(small.size[0], large.size[0]) && near(small.size[1], large.size[1])
    };
    // ε is in units of the diameter of Ω.
    let same_operator = part.epsilon == 0.0
        && whole.epsilon == 0.0
        && part.foundation == whole.foundation
        && part.punch == whole.punch
        && part.projection == whole.projection
        && part.plane == whole.plane;
    let fits = small.count.iter().zip(large.count).all(|(few, many)| *few <= many);
    same_operator && same_elements && fits
}

/// The elements of a rectangular Ω.
struct Elements {
    /// The numbers along x and y.
    count: [u32; 2],
    /// The lengths along x and y \[m\].
    size: [f64; 2],
}

fn elements(question: &Question) -> Option<Elements> {
    let Sole::Rectangle { width_x, width_y } = question.sole else { return None };
    let count = question.mesh.sides();
    let size = [width_x / f64::from(count[0]), width_y / f64::from(count[1])];
    Some(Elements { count, size })
}

/// Finds the brackets, of questions with a lower and an upper end, that contradict one on a part of
/// their domain.
pub fn contradictions(brackets: &[(Question, [f64; 2])]) -> Vec<Contradiction> {
    let mut found = Vec::new();
    for (larger, (whole, [low, _])) in brackets.iter().enumerate() {
        for (smaller, (part, [_, high])) in brackets.iter().enumerate() {
            if high < low && is_part_of(part, whole) {
                found.push(Contradiction { smaller, larger });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Foundation, Layer, Material, Mesh, Projection};

    fn question(count: [u32; 2], size: f64) -> Question {
        let [width_x, width_y] = count.map(|n| f64::from(n) * size);
        Question {
            foundation: Foundation::half_space(Material { shear_modulus: 1.0, poisson: 0.3 }),
            punch: None,
            sole: Sole::Rectangle { width_x, width_y },
            mesh: Mesh::Exact(count),
            projection: Projection::Average,
            epsilon: 0.0,
            plane: false,
        }
    }

    #[test]
    fn a_bracket_that_begins_above_the_end_of_a_smaller_domain_is_found() {
        let layered = |count: [u32; 2], size: f64| {
            let layers = vec![Layer { shear_modulus: 0.1, poisson: 0.3, thickness: 0.1 }];
            let of_base = question(count, size);
            Question { foundation: Foundation { layers, ..of_base.foundation.clone() }, ..of_base }
        };
        let one = [Contradiction { smaller: 0, larger: 1 }];
        let cases: [(Question, Question, &[Contradiction]); 8] = [
            (question([2, 2], 1.0), question([3, 3], 1.0), &one),
            (question([2, 1], 1.0), question([4, 4], 1.0), &one),
            // Half-spaces have no length, and layers have.
            (question([2, 2], 1.0), question([3, 3], 0.4), &one),
            (layered([2, 2], 1.0), layered([3, 3], 0.4), &[]),
            (layered([2, 2], 0.4), layered([3, 3], 0.4), &one),
            (question([2, 3], 1.0), question([3, 2], 1.0), &[]),
            (question([3, 3], 1.0), question([2, 2], 1.0), &[]),
            (question([2, 2], 1.0), Question { epsilon: 0.1, ..question([3, 3], 1.0) }, &[]),
        ];
        for (smaller, larger, expected) in cases {
            let wrong = [(smaller.clone(), [1.0, 2.0]), (larger.clone(), [2.5, 3.0])];
            assert_eq!(contradictions(&wrong), expected, "{smaller:?} {larger:?}");
            let right = [(smaller, [1.0, 2.0]), (larger, [1.5, 3.0])];
            assert_eq!(contradictions(&right), []);
        }
    }
}
