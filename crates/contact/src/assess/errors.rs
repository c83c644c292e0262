//! The errors of a solution against a closed form, or against a solution on a finer mesh.

use super::closed_form::ClosedForm;
use super::norms::{self, Norm, Relative};
use super::quadrature::{Kinks, Rectangle};
use crate::grid::Grid;
use crate::model::{Control, Dof, Fields, FigureErrors, Leg, PerDof, StepOutcome};

/// Relative errors of a solution's figures \[1\]. `None` means that the error is not defined: the
/// scene prescribes the figure; or the reference does not have it (an unbounded peak, a traction
/// outside L₂); or it is less than 1e-6 of its kind in the reference, of which a tolerance of 1e-8
/// leaves no more than two digits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// The errors of the figures.
    pub figures: FigureErrors,
    /// The errors of the local means of the tractions on 8 × 8 parts, in L₂: a weak measure.
    pub local: Relative,
}

/// The number of parts each way over which local means are taken.
const PARTS: usize = 8;

/// The share of its kind below which a figure is nothing.
const NEGLIGIBLE: f64 = 1e-6;

impl Errors {
    /// Returns the errors with their names.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, Option<f64>)> {
        self.figures.named().into_iter().chain([
            ("local_pressure", self.local.pressure),
            ("local_traction", self.local.traction),
        ])
    }

    /// Returns the error of this name; `None` also if there is no such name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.named().find(|(figure, _)| *figure == name)?.1
    }

    /// Compares the end of a path with the closed form of its scene. Local means are taken on the
    /// box around the contact and half as much again, whatever the solution's mesh is. `None` if a
    /// field does not have one value per element.
    pub fn against_closed_form(
        end: &StepOutcome,
        fields: &Fields,
        exact: &ClosedForm,
    ) -> Option<Self> {
        norms::norm(fields)?;
        let areas = [exact.contact_area(), exact.stick_area()];
        let reference = Figures {
            motion: exact.motion.per_dof(),
            resultants: exact.resultants,
            peak: exact.peak_pressure,
            areas,
        };
        let strong = if exact.is_square_integrable() {
            significant(distance(fields, exact))
        } else {
            Relative::default()
        };
        let local = significant(local_distance(fields, exact)?);
        Some(Self::of(&Figures::of(end), &reference, &exact.controls, strong, local))
    }

    /// Compares the end of a path with that of the same path on another mesh or with other
    /// numerics, taken for exact. `leg` is the last of
    /// [`Loading::legs`](crate::model::Loading::legs): it has the controls, and where it rolls by
    /// an element of each mesh the motions are compared over the same distance. Local means are
    /// taken on 8 × 8 parts of the reference's Ω. `None` if a field does not have one value per
    /// element.
    pub fn against_solution(
        end: &StepOutcome,
        fields: &Fields,
        reference: &StepOutcome,
        reference_fields: &Fields,
        leg: &Leg,
    ) -> Option<Self> {
        let share = leg.rolling.map_or(1.0, |rolling| {
            let travelled = |end: &StepOutcome| rolling.travelled(end.observables.element_x);
            travelled(reference) / travelled(end)
        });
        Self::at_share(end, fields, reference, reference_fields, &leg.target, share)
    }

    /// Compares the ends of paths like [`Errors::against_solution`], where the reference has
    /// travelled `share` times as far in its last increment.
    pub(crate) fn at_share(
        end: &StepOutcome,
        fields: &Fields,
        reference: &StepOutcome,
        reference_fields: &Fields,
        controls: &PerDof<Control>,
        share: f64,
    ) -> Option<Self> {
        let mut computed = Figures::of(end);
        Dof::TANGENTIAL.iter().for_each(|dof| computed.motion[*dof] *= share);
        let strong = significant([
            norms::distance(fields, reference_fields)?,
            norms::norm(reference_fields)?,
        ]);
        let parts = norms::parts(reference_fields, [PARTS; 2])?;
        let [means, exact_means] =
            [norms::local_means(fields, &parts)?, norms::local_means(reference_fields, &parts)?];
        let local =
            significant([norms::distance(&means, &exact_means)?, norms::norm(&exact_means)?]);
        Some(Self::of(&computed, &Figures::of(reference), controls, strong, local))
    }

    fn of(
        computed: &Figures,
        reference: &Figures,
        controls: &PerDof<Control>,
        strong: Relative,
        local: Relative,
    ) -> Self {
        let length = reference.areas[0].sqrt();
        // Moments are measured against the load at the size of the contact, rotations against the
        // approach there.
        let (load, approach) =
            (reference.resultants[Dof::Approach].abs(), reference.motion[Dof::Approach].abs());
        let is_given =
            |dof: Dof, as_force: bool| matches!(controls[dof], Control::Force(_)) == as_force;
        let vector = |as_force: bool, dofs: &[Dof], kind: f64| {
            let values =
                |figures: &Figures| if as_force { figures.resultants } else { figures.motion };
            let (computed, exact) = (values(computed), values(reference));
            let size = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::hypot);
            let (all, difference) = (
                size(&mut dofs.iter().map(|dof| exact[*dof])),
                size(&mut dofs.iter().map(|dof| computed[*dof] - exact[*dof])),
            );
            (all > NEGLIGIBLE * kind && !dofs.iter().all(|dof| is_given(*dof, as_force)))
                .then(|| difference / all)
        };
        let relative = |computed: f64, exact: f64, unit: f64| {
            (unit > 0.0).then(|| (computed - exact).abs() / unit)
        };
        let figures = FigureErrors {
            load: vector(true, &[Dof::Approach], 0.0),
            approach: vector(false, &[Dof::Approach], 0.0),
            tangential_force: vector(true, &Dof::SHIFTS, load),
            shift: vector(false, &Dof::SHIFTS, approach),
            moment: vector(true, &Dof::ROTATIONS, load * length),
            rotation: vector(false, &Dof::ROTATIONS, approach / length),
            peak_pressure: computed
                .peak
                .zip(reference.peak)
                .and_then(|(computed, exact)| relative(computed, exact, exact)),
            contact_area: relative(computed.areas[0], reference.areas[0], reference.areas[0]),
            stick_area: relative(computed.areas[1], reference.areas[1], reference.areas[0]),
            pressure: strong.pressure,
            traction: strong.traction,
        };
        Self { figures, local }
    }
}

/// The figures that are compared besides the fields, in SI units.
struct Figures {
    motion: PerDof<f64>,
    resultants: PerDof<f64>,
    /// The largest pressure.
    peak: Option<f64>,
    /// The areas in contact, and of that sticking.
    areas: [f64; 2],
}

impl Figures {
    fn of(end: &StepOutcome) -> Self {
        let observables = &end.observables;
        Self {
            motion: end.motion.per_dof(),
            resultants: observables.resultants(),
            peak: Some(observables.peak_pressure),
            areas: [observables.contact_area, observables.stick_area],
        }
    }
}

/// Returns distances over norms. The one of the traction is defined where the reference has a
/// traction worth the name.
fn significant([distance, reference]: [Norm; 2]) -> Relative {
    let relative = distance.over(reference);
    Relative {
        traction: relative
            .traction
            .filter(|_| reference.traction > NEGLIGIBLE * reference.pressure),
        ..relative
    }
}

/// Returns the distance of fields from a closed form in L₂, and the closed form's norm. The
/// relative error of the integrals is below 1e-9.
fn distance(fields: &Fields, exact: &ClosedForm) -> [Norm; 2] {
    let kinks = exact.kinks();
    let cells = [0, 1].map(|axis| cells(fields, axis, exact.semi_axes[axis]));
    let unit = unit(exact);
    let mut squares = [0.0; 4];
    for (y, j) in &cells[1] {
        for (x, i) in &cells[0] {
            let element = i.zip(*j).map(|(i, j)| j * fields.shape[0] as usize + i);
            let traction = element
                .map_or([0.0; 3], |e| {
                    [fields.pressure[e], fields.traction_x[e], fields.traction_y[e]]
                })
                .map(|p| p / unit);
            let rectangle = Rectangle { x: *x, y: *y };
            let integrals = if is_outside(rectangle, exact.semi_axes) {
                let area = (x[1] - x[0]) * (y[1] - y[0]);
                let densities = [
                    traction[0] * traction[0],
                    traction[1] * traction[1] + traction[2] * traction[2],
                ];
                [densities[0] * area, densities[1] * area, 0.0, 0.0]
            } else {
                kinks.integrate(rectangle, &|x, y| {
                    let p = exact.tractions_at(x, y).map(|p| p / unit);
                    let difference = [0, 1, 2].map(|c| traction[c] - p[c]);
                    [
                        difference[0] * difference[0],
                        difference[1] * difference[1] + difference[2] * difference[2],
                        p[0] * p[0],
                        p[1] * p[1] + p[2] * p[2],
                    ]
                })
            };
            squares.iter_mut().zip(integrals).for_each(|(sum, integral)| *sum += integral);
        }
    }
    let [pressure, traction, exact_pressure, exact_traction] =
        squares.map(|square| unit * square.sqrt());
    [Norm { pressure, traction }, Norm { pressure: exact_pressure, traction: exact_traction }]
}

/// Returns a traction of the closed form's size, so that squares stay within the range of doubles:
/// its mean pressure.
fn unit(exact: &ClosedForm) -> f64 {
    exact.resultants[Dof::Approach] / exact.contact_area()
}

/// Returns whether a rectangle lies outside an ellipse around the origin.
fn is_outside(rectangle: Rectangle, [a, b]: [f64; 2]) -> bool {
    let nearest = |[low, high]: [f64; 2]| low.max(-high).max(0.0);
    (nearest(rectangle.x) / a).hypot(nearest(rectangle.y) / b) >= 1.0
}

/// Returns the columns or rows of elements as intervals with their indices, and the parts of ±
/// `reach` that lie beyond them.
fn cells(fields: &Fields, axis: usize, reach: f64) -> Vec<([f64; 2], Option<usize>)> {
    let n = fields.shape[axis] as usize;
    let edge = |i: usize| fields.origin[axis] + (i as f64 - 0.5) * fields.element[axis];
    let mut cells: Vec<_> = (0..n).map(|i| ([edge(i), edge(i + 1)], Some(i))).collect();
    if n == 0 {
        return vec![([-reach, reach], None)];
    }
    if -reach < edge(0) {
        cells.push(([-reach, edge(0).min(reach)], None));
    }
    if reach > edge(n) {
        cells.push(([edge(n).max(-reach), reach], None));
    }
    cells
}

/// Returns the distance of the local means of fields from those of a closed form, and the norm of
/// those. The parts cover the box around the contact and half as much again. The relative error of
/// their means is below 1e-9, and below 1e-6 for a flat sole.
fn local_distance(fields: &Fields, exact: &ClosedForm) -> Option<[Norm; 2]> {
    let [hx, hy] = exact.semi_axes.map(|semi_axis| 3.0 * semi_axis / PARTS as f64);
    let first = 0.5 * (1.0 - PARTS as f64);
    let parts = Grid::new(PARTS, PARTS, hx, hy, [first * hx, first * hy]).ok()?;
    let means = means(exact, &exact.kinks(), &parts);
    let computed = norms::local_means(fields, &parts)?;
    Some([norms::distance(&computed, &means)?, norms::norm(&means)?])
}

/// Returns the means of a closed form's tractions over the elements of a grid.
fn means(exact: &ClosedForm, kinks: &Kinks, grid: &Grid) -> Fields {
    let half = [0.5 * grid.hx(), 0.5 * grid.hy()];
    let of_element = |e: usize| {
        let [x, y] = grid.center(e);
        let rectangle = Rectangle { x: [x - half[0], x + half[0]], y: [y - half[1], y + half[1]] };
        if is_outside(rectangle, exact.semi_axes) {
            [0.0; 3]
        } else {
            kinks.integrate(rectangle, &|x, y| exact.tractions_at(x, y))
        }
    };
    let means: Vec<[f64; 3]> =
        (0..grid.len()).map(|e| of_element(e).map(|p| p / grid.element_area())).collect();
    let [pressure, traction_x, traction_y] =
        [0, 1, 2].map(|c| means.iter().map(|mean| mean[c]).collect());
    Fields {
        shape: [grid.nx() as u32, grid.ny() as u32],
        origin: grid.center(0),
        element: [grid.hx(), grid.hy()],
        pressure,
        traction_x,
        traction_y,
        ..Fields::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assess::closed_form::closed_form;
    use crate::model::{Base, Foundation, Scene, Shape, sphere_on_half_space};

    /// Returns a field of this value of pressure on each of n × n elements around the origin.
    fn constant(pressure: f64, n: u32, width: f64) -> Fields {
        let (element, k) = (width / f64::from(n), (n * n) as usize);
        Fields {
            shape: [n; 2],
            origin: [0.5 * (element - width); 2],
            element: [element; 2],
            pressure: vec![pressure; k],
            traction_x: vec![0.0; k],
            traction_y: vec![0.0; k],
            ..Fields::default()
        }
    }

    /// The integral ∫ (c − p)² over a square of width 3a is 9a²c² − 2cP + ½p₀²πa² for Hertz's
    /// pressure, however the square is cut.
    #[test]
    fn distances_from_hertz_are_exact_on_every_grid() {
        let exact = closed_form(&Scene {
            friction: crate::model::Friction { mu: 0.0 },
            ..sphere_on_half_space()
        })
        .unwrap();
        let (a, peak) = (exact.semi_axes[0], exact.peak_pressure.unwrap());
        let c = 0.3 * peak;
        let norm = (0.5 * std::f64::consts::PI).sqrt() * a * peak;
        let square = 9.0 * a * a * c * c - 2.0 * c * exact.resultants[Dof::Approach] + norm * norm;
        for n in [1, 2, 7, 10, 33, 64] {
            let [off, own] = distance(&constant(c, n, 3.0 * a), &exact);
            assert!(
                (off.pressure / square.sqrt() - 1.0).abs() < 1e-9
                    && (own.pressure / norm - 1.0).abs() < 1e-9,
                "{n}: {off:?} {own:?}"
            );
        }
        // The part that lies beyond the grid counts in full.
        let [off, own] = distance(&constant(0.0, 5, 0.7 * a), &exact);
        assert!(
            (off.pressure / norm - 1.0).abs() < 1e-9 && (own.pressure / norm - 1.0).abs() < 1e-9
        );
        assert!((distance(&Fields::default(), &exact)[0].pressure / norm - 1.0).abs() < 1e-9);
    }

    #[test]
    fn errors_do_not_feel_the_units() {
        let errors = |modulus: f64| {
            let mut scene = sphere_on_half_space();
            (scene.friction.mu, scene.punch.shape) = (0.0, Shape::Cone { angle: 0.2 });
            let Base::Elastic(material) = scene.foundation.base else { panic!() };
            scene.foundation = Foundation::half_space(crate::model::Material {
                shear_modulus: modulus,
                ..material
            });
            let exact = closed_form(&scene).unwrap();
            Errors::against_closed_form(
                &StepOutcome::default(),
                &constant(modulus * 1e-3, 12, 3.0 * exact.semi_axes[0]),
                &exact,
            )
            .unwrap()
        };
        let usual = errors(1.0);
        assert_eq!(
            ["load", "peak_pressure", "approach"].map(|name| usual.get(name)),
            [Some(1.0), None, None]
        );
        for modulus in [1e-280, 1e280] {
            for ((name, one), (_, other)) in usual.named().zip(errors(modulus).named()) {
                let apart = one
                    .zip(other)
                    .map_or(0.0, |(one, other)| (one - other).abs() / one.max(1e-300));
                assert!(
                    one.is_some() == other.is_some() && apart < 1e-10,
                    "{name}: {one:?} {other:?}"
                );
            }
        }
    }

    #[test]
    fn names_are_those_of_the_fields() {
        let mut left = serde_json::to_value(FigureErrors::default()).unwrap();
        for (index, (name, _)) in FigureErrors::default().named().into_iter().enumerate() {
            left[name] = index.into();
        }
        let errors: FigureErrors = serde_json::from_value(left).unwrap();
        assert_eq!(
            errors.named().map(|(_, error)| error),
            std::array::from_fn(|index| Some(index as f64))
        );
    }
}
