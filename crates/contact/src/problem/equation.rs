//! A scene that is bound to a grid: equation (3), p = Gᵘ_μ(p − E(εp + Ap − f)), for one increment
//! of the loading path.
//!
//! A problem is dimensionless: lengths are in units of ℓ (half the diameter of Ω) and tractions in
//! units of 1/c (c = Σ(1−ν)/G), so that a solver can feel neither the unit of length nor the
//! moduli. Jobs that differ only in moduli of equal ratio, loads or sizes therefore share their
//! operator.
//!
//! Along a path f₁ = δ + tilt terms − g₀ and f_t = (rigid motion since the increment before) +
//! (εp + Ap)_t of that increment, so that w_t is the slip increment. A punch that is held still
//! therefore keeps its tractions, for ε > 0 as well.
//!
//! A contact that rolls goes on along x while the material passes through it. What an element slips
//! is the difference between its displacement and that which the material had before, when it was a
//! rolled distance ahead in the contact. On a path that displacement is known and part of f_t;
//! where the rolling is [steady](Problem::steady) it is that of the same tractions, and part of the
//! operator.

use std::ops::Range;

use rayon::prelude::*;

use super::friction::g_mu;
use super::layout::{self, Layout};
use super::scale::{self, Scale};
use crate::common::parallel;
use crate::foundation::{Bodies, relative_bodies};
use crate::grid::{Grid, GridError};
use crate::influence::{Components, Diagonals, Direction, Mirror, MirrorError, weighted_images};
use crate::model::{
    Dof, Numerics, PerDof, Projection, Scene, SceneError, rigid_displacement, rigid_modes,
};
use crate::punch::{Gap, Surfaces, domain_under};

/// Equation (3) on a grid, dimensionless. The fields of a problem are blocks of
/// [components](Problem::components) \[n | x | y\], each as long as the grid.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The components of the problem: all three, unless it is a reduced one.
    pub components: Components,
    /// The given p₁ of every element in units of 1/c, if n is not among the components.
    pub pressure: Option<Vec<f64>>,
    /// The mirror planes, to the positive sides of which the grid lies.
    pub mirror: Mirror,
    /// The grid with the other sides of the mirror planes, if there are any.
    whole: Option<Grid>,
    /// The elements, in units of ℓ; those without a sole above them are masked.
    pub grid: Grid,
    /// The bodies' summed compliances, in units of c.
    pub elasticity: Bodies,
    /// The rule by which A is discretised.
    pub projection: Projection,
    /// The friction coefficient μ \[1\].
    pub mu: f64,
    /// The regularisation ε \[1\]; the operator of equation (3) is εI + A.
    pub epsilon: f64,
    /// The ceiling u in units of 1/c; it is infinite if there is none.
    pub ceiling: f64,
    /// The right-hand side f, in units of ℓ, for the motion last [placed](Problem::place).
    pub f: Vec<f64>,
    /// The part of f without rigid motion: −g₀, and tangentially the displacement that the
    /// increment before left behind.
    rest: Vec<f64>,
    /// The distance along x, with its sign, by which the contact goes on in an increment that rolls
    /// steadily, in units of ℓ. The tangential rows of its operator are those of A minus the same
    /// so far ahead. `None` for every other increment, of which the past is a part of f.
    pub steady: Option<f64>,
    /// The size of the tangential displacements from which the increment starts, in units of ℓ, in
    /// a scene that rolls. Tangential tractions are then measured in their own size, or in this one
    /// if it is larger, and not in that of the pressure only. `None` for a scene that does not
    /// roll.
    pub(crate) past: Option<f64>,
    /// The fact that the punch goes on beyond Ω, so that contact at its edge is cut off.
    pub open_edge: bool,
    /// The units of the problem.
    pub scale: Scale,
}

/// The range in which a sum of squares is free of overflow and underflow.
const SQUARES: std::ops::Range<f64> = 1e-250..1e250;

/// The data that determine a problem's operator. Problems with equal keys share an operator.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OperatorKey {
    elements: [usize; 2],
    element: [f64; 2],
    mask: Option<Vec<bool>>,
    elasticity: Bodies,
    projection: Projection,
    components: Components,
    mirror: Mirror,
    steady: Option<f64>,
}

impl OperatorKey {
    /// Returns whether operators of both can be made of one table, if it has their components.
    pub(crate) fn shares_table(&self, other: &Self) -> bool {
        let Self { components, mirror, steady, .. } = *other;
        Self { components, mirror, steady, ..self.clone() } == *other
    }

    /// Returns the distance by which a contact goes on that rolls steadily.
    pub(crate) fn steady(&self) -> Option<f64> {
        self.steady
    }
}

impl Problem {
    /// Binds a scene to a grid.
    ///
    /// # Errors
    /// A [`SceneError`] reports a scene or settings that [`Scene::validate`] or
    /// [`Numerics::validate`] refuses, a domain that cannot be derived, a grid on which the punch
    /// has no sole, and sizes, moduli or loads beyond the range of double precision.
    pub fn new(
        scene: &Scene,
        numerics: &Numerics,
        surfaces: &Surfaces,
    ) -> Result<Self, SceneError> {
        scene.validate()?;
        numerics.validate()?;
        let problem = Self::under(scene, numerics, &Gap::new(scene, surfaces)?)?;
        problem.check_distances(scene)?;
        Ok(problem)
    }

    /// Refuses steps that roll steadily by distances that the mesh does not resolve, and places
    /// below the surface so far away, or so near to it, that doubles do not.
    pub(crate) fn check_distances(&self, scene: &Scene) -> Result<(), SceneError> {
        let grid = &self.grid;
        let element = [grid.hx(), grid.hy()].map(|side| side * self.scale.length);
        layout::check_distances(scene, element[0])?;
        let Some(question) = &scene.interior else { return Ok(()) };
        let elements = [grid.nx(), grid.ny()].map(|n| n as f64);
        let first = grid.center(0);
        let middle =
            [0, 1].map(|i| first[i] * self.scale.length + 0.5 * (elements[i] - 1.0) * element[i]);
        let size = [0, 1].map(|i| elements[i] * element[i]);
        question.check_places(middle, size, element[0].min(element[1]))
    }

    /// Binds a scene that is known to be valid, and whose `gap` is at hand, to a grid.
    ///
    /// # Errors
    /// A [`SceneError`] reports what [`Problem::new`] does, except for a scene, settings or
    /// surfaces without a meaning, and for distances that the grid does not resolve.
    pub(crate) fn under(
        scene: &Scene,
        numerics: &Numerics,
        gap: &Gap<'_>,
    ) -> Result<Self, SceneError> {
        let domain = domain_under(scene, gap)?;
        let layout = Layout::new(scene, numerics, &domain);
        let (nx, ny) = (layout.nx, layout.ny);

        let bodies = relative_bodies(scene, layout.half_diameter);
        let scale = layout.scale(scene, &bodies)?;
        let length = scale.length;
        let [hx, hy] = layout.element;
        let center = [domain.center_x / length, domain.center_y / length];
        let origin =
            [center[0] - 0.5 * (nx - 1) as f64 * hx, center[1] - 0.5 * (ny - 1) as f64 * hy];
        let grid_error = |error: GridError| SceneError {
            key: "mesh".to_owned(),
            value: format!("{nx} × {ny}"),
            expected: error.to_string(),
        };
        let grid = Grid::new(nx, ny, hx, hy, origin).map_err(grid_error)?;
        let xs: Vec<f64> = (0..nx).map(|i| grid.center(i)[0] * length).collect();
        let row = |j: usize| -> Vec<Option<f64>> {
            let [_, y] = grid.center(j * nx);
            match layout.disk {
                Some(reach) => (0..nx)
                    .map(|i| {
                        let [x, _] = grid.center(i);
                        (x.hypot(y) <= hx * reach * (1.0 + 1e-12)).then_some(0.0)
                    })
                    .collect(),
                None => gap.row(numerics.projection, &xs, y * length, [hx * length, hy * length]),
            }
        };
        let gaps: Vec<Option<f64>> = (0..ny).into_par_iter().flat_map_iter(row).collect();
        let grid =
            grid.with_mask(gaps.iter().map(Option::is_some).collect()).map_err(grid_error)?;
        if grid.active_len() == 0 {
            return Err(SceneError {
                key: "domain".to_owned(),
                value: format!(
                    "{:e} m × {:e} m around ({:e} m, {:e} m)",
                    domain.width_x, domain.width_y, domain.center_x, domain.center_y
                ),
                expected: "must hold the centre of at least one element under the punch's sole"
                    .to_owned(),
            });
        }

        let k = grid.len();
        let mut rest = vec![0.0; 3 * k];
        parallel::rows(&mut rest[..k], nx, |j, rest| {
            rest.iter_mut()
                .zip(&gaps[j * nx..])
                .for_each(|(rest, gap)| *rest = -gap.unwrap_or(0.0) / length);
        });
        if let Some(value) = rest[..k].iter().find(|value| !value.is_finite()) {
            return Err(scale::out_of_range("punch.shape", *value));
        }
        numerics.suit(&scene.loading)?;
        layout.check_reach(scene)?;
        scale::check_operator(&bodies, &grid, numerics.projection)?;
        scale::check_loads(scene, numerics, &scale, &grid, &rest)?;
        // A clone would touch the zeros too.
        let mut f = vec![0.0; 3 * k];
        f[..k].copy_from_slice(&rest[..k]);
        Ok(Self {
            components: Components::ALL,
            pressure: None,
            mirror: Mirror::NONE,
            whole: None,
            grid,
            elasticity: bodies.scaled(1.0 / bodies.reference_compliance()),
            projection: numerics.projection,
            mu: scene.friction.mu,
            epsilon: numerics.epsilon,
            ceiling: numerics.ceiling.map_or(f64::INFINITY, |u| u * scale.compliance),
            f,
            rest,
            steady: None,
            past: scene.loading.rolls().then_some(0.0),
            open_edge: layout.open_edge,
            scale,
        })
    }

    /// Returns this problem for some of its components, on the positive sides of mirror planes,
    /// under a given `pressure` (of the whole grid, in units of 1/c) if n is left out. It has the
    /// motion last placed and the same past. The caller has to know that the reduced problem has
    /// the same solution ([`Effects`](super::Effects)).
    ///
    /// # Errors
    /// A [`MirrorError`] reports that the grid has no such planes.
    pub(crate) fn reduced(
        &self,
        components: Components,
        mirror: Mirror,
        pressure: Option<&[f64]>,
    ) -> Result<Self, MirrorError> {
        let grid = mirror.part(&self.grid)?;
        Ok(Self {
            f: self.part(components, mirror, &self.f),
            rest: self.part(components, mirror, &self.rest),
            pressure: pressure.map(|pressure| mirror.restrict(&self.grid, pressure)),
            components,
            mirror,
            whole: (mirror != Mirror::NONE).then(|| self.grid.clone()),
            grid,
            elasticity: self.elasticity.clone(),
            projection: self.projection,
            mu: self.mu,
            epsilon: self.epsilon,
            ceiling: self.ceiling,
            steady: self.steady,
            past: self.past,
            open_edge: self.open_edge,
            scale: self.scale,
        })
    }

    /// Returns some components of a field of all three, on the positive sides of mirror planes.
    pub(crate) fn part(&self, components: Components, mirror: Mirror, field: &[f64]) -> Vec<f64> {
        let k = self.grid.len();
        if components == Components::ALL {
            return mirror.restrict(&self.grid, field);
        }
        let blocks = components
            .directions()
            .map(|direction| mirror.restrict(&self.grid, &field[direction as usize * k..][..k]));
        blocks.collect::<Vec<_>>().concat()
    }

    /// Writes a field of a problem that is [reduced](Problem::reduced) from this one into a field
    /// of all three components.
    pub(crate) fn extend(&self, reduced: &Problem, field: &[f64], into: &mut [f64]) {
        let k = self.grid.len();
        let all = reduced.mirror.extend(&self.grid, reduced.components, field);
        for (block, direction) in all.chunks_exact(k).zip(reduced.components.directions()) {
            into[direction as usize * k..][..k].copy_from_slice(block);
        }
    }

    /// Returns the grid with its images.
    pub(crate) fn whole_grid(&self) -> &Grid {
        self.whole.as_ref().unwrap_or(&self.grid)
    }

    /// Lists the blocks of a field with the components that they hold, n = 0, x = 1, y = 2.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        self.components.directions().map(|direction| direction as usize).enumerate()
    }

    /// Returns whether a rigid degree of freedom has a resultant among the problem's components
    /// that the mirror planes do not cancel.
    pub(crate) fn moves(&self, dof: Dof) -> bool {
        let modes = rigid_modes(1.0, 1.0);
        let has = |direction: Direction| {
            modes[direction as usize][dof] != 0.0
                && weighted_images(&self.mirror, direction)[dof] != 0.0
        };
        self.components.directions().any(has)
    }

    /// Moves the punch: sets f to that of the rigid motion `motion`, in the problem's units.
    pub fn place(&mut self, motion: &PerDof<f64>) {
        let (k, nx) = (self.grid.len(), self.grid.nx());
        for (block, c) in
            self.components.directions().map(|direction| direction as usize).enumerate()
        {
            let (f, rest) = (&mut self.f[block * k..][..k], &self.rest[block * k..][..k]);
            parallel::rows(f, nx, |j, f| {
                for (i, (f, rest)) in f.iter_mut().zip(&rest[j * nx..]).enumerate() {
                    if self.grid.is_active(j * nx + i) {
                        let [x, y] = self.grid.center_of(i, j);
                        *f = rest + rigid_displacement(x, y, motion)[c];
                    }
                }
            });
        }
    }

    /// Returns f₁ of an element without rigid motion, −g₀, in units of ℓ.
    pub(crate) fn unmoved(&self, element: usize) -> f64 {
        self.rest[element]
    }

    /// Makes the displacements `left` = (εI + A) p at `motion` those from which the next increment
    /// starts. The function leaves f as it is.
    pub fn remember(&mut self, left: &[f64], motion: &PerDof<f64>) {
        let (k, nx, grid) = (self.grid.len(), self.grid.nx(), &self.grid);
        self.past = self.past.map(|_| {
            let square = |row: usize| left[row] * left[row];
            let tangential = self.blocks().filter(|(_, c)| *c > 0);
            let squares =
                tangential.flat_map(|(block, _)| grid.active().map(move |e| square(block * k + e)));
            squares.sum::<f64>().sqrt()
        });
        for (block, c) in self
            .components
            .directions()
            .map(|direction| direction as usize)
            .enumerate()
            .filter(|(_, c)| *c > 0)
        {
            parallel::rows(&mut self.rest[block * k..][..k], nx, |j, rest| {
                for (i, rest) in
                    rest.iter_mut().enumerate().filter(|(i, _)| grid.is_active(j * nx + i))
                {
                    let row = block * k + j * nx + i;
                    let [x, y] = grid.center_of(i, j);
                    let moved = rigid_displacement(x, y, motion)[c];
                    *rest = left[row] - moved;
                }
            });
        }
    }

    /// Widens the gap by what is worn away at each element \[m\]. The function leaves f as it is.
    pub(crate) fn wear_off(&mut self, worn: &[f64]) {
        let length = self.scale.length;
        for e in (0..self.grid.len()).filter(|e| self.grid.is_active(*e)) {
            self.rest[e] -= worn[e] / length;
        }
    }

    /// Returns the forces and moments of the punch on the foundation, in the problem's units. Those
    /// of a reduced problem are the ones of its components, with their images.
    pub(crate) fn resultants(&self, p: &[f64]) -> PerDof<f64> {
        let (k, nx) = (self.grid.len(), self.grid.nx());
        let mut sums = PerDof::all(0.0);
        for (block, direction) in self.components.directions().enumerate() {
            // The sums of p, x p and y p, row by row.
            let mut moments = vec![[0.0; 3]; self.grid.ny()];
            let p = &p[block * k..][..k];
            parallel::each(
                k,
                moments.iter_mut().zip(p.chunks_exact(nx)).enumerate().collect(),
                |(j, (moments, row))| {
                    let [x0, y] = self.grid.center(j * nx);
                    let (mut all, mut by_column) = (0.0, 0.0);
                    for (i, p) in
                        row.iter().enumerate().filter(|(i, _)| self.grid.is_active(j * nx + i))
                    {
                        all += p;
                        by_column += i as f64 * p;
                    }
                    *moments = [all, x0 * all + self.grid.hx() * by_column, y * all];
                },
            );
            let [total, first_x, first_y] =
                [0, 1, 2].map(|moment| moments.iter().map(|row| row[moment]).sum::<f64>());
            // Each mode is 1, x or y of the place, up to a sign.
            let [constant, unit_x, unit_y] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
                .map(|[x, y]| rigid_modes(x, y)[direction as usize]);
            let images = weighted_images(&self.mirror, direction);
            for dof in Dof::ALL {
                let [one, x, y] =
                    [constant[dof], unit_x[dof] - constant[dof], unit_y[dof] - constant[dof]];
                sums[dof] += images[dof] * (one * total + x * first_x + y * first_y);
            }
        }
        sums.map(|sum| sum * self.grid.element_area())
    }

    /// Returns the tractions (n, x, y) of an element: those of `p`, the given pressure if there is
    /// one, and zeros for other components that the problem does not have.
    pub(crate) fn traction(&self, p: &[f64], element: usize) -> [f64; 3] {
        let mut traction = self.gather(p, element);
        if let Some(pressure) = &self.pressure {
            traction[0] = pressure[element];
        }
        traction
    }

    /// Returns the components (n, x, y) of a field at an element, with zeros for those that the
    /// problem does not have.
    pub(crate) fn gather(&self, field: &[f64], element: usize) -> [f64; 3] {
        let mut vector = [0.0; 3];
        for (block, c) in self.blocks() {
            vector[c] = field[block * self.grid.len() + element];
        }
        vector
    }

    /// Returns the data on which the problem's operator depends.
    pub(crate) fn operator_key(&self) -> OperatorKey {
        OperatorKey {
            elements: [self.whole_grid().nx(), self.whole_grid().ny()],
            element: [self.grid.hx(), self.grid.hy()],
            components: self.components,
            mirror: self.mirror,
            mask: self.whole_grid().mask().map(<[bool]>::to_vec),
            elasticity: self.elasticity.clone(),
            projection: self.projection,
            // The normal rows are those of A.
            steady: self.steady.filter(|_| self.components != Components::NORMAL),
        }
    }

    /// Returns the relative natural-map residual ‖p − Gᵘ_μ(p − E v)‖ / ‖p‖ \[1\] with v = εp + w
    /// and E = 1/(ε + `diagonal`), one for each direction; `w` = A p − f. It is 0 if p = 0 solves
    /// the problem, and infinite if p = 0 does not. In a scene that rolls it is not less
    /// than that of the tangential components alone, over their own size, which is the largest of
    /// ‖p_t‖, that of their images and what is [past](Problem::past). Masked elements do not count.
    pub(crate) fn residual(&self, p: &[f64], w: &[f64], diagonal: impl Into<Diagonals>) -> f64 {
        let diagonal = diagonal.into();
        let is_normal = self.components == Components::NORMAL;
        // The pairs are p and its image at each element, where one of them is not zero.
        let pairs = |band: Range<usize>| {
            self.grid.active_in(band).filter_map(|e| {
                let (traction, w) = (self.traction(p, e), self.gather(w, e));
                let mut x = self.trial(traction, w, diagonal);
                if self.pressure.is_some() {
                    x[0] = traction[0]; // The pressure was solved before.
                } else if is_normal {
                    [x[1], x[2]] = [0.0; 2];
                }
                let is_open = x[0] <= 0.0 && traction == [0.0; 3];
                (!is_open).then(|| (traction, g_mu(x, self.mu, self.ceiling)))
            })
        };
        let past = self.past.filter(|_| !is_normal);
        // The sums of squares are those of the defect, of the tractions and of their images: of all
        // components, and of the tangential ones if they are measured for themselves.
        let sums = |unit: f64| {
            let bands = parallel::bands(self.grid.len(), |band| {
                let mut sums = [[0.0; 3]; 2];
                for (traction, mapped) in pairs(band) {
                    for c in 0..3 {
                        let squares = [traction[c] - mapped[c], traction[c], mapped[c]]
                            .map(|value| (value / unit).powi(2));
                        let of_c = if past.is_some() && c > 0 { 2 } else { 1 };
                        for sums in &mut sums[..of_c] {
                            sums.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
                        }
                    }
                }
                sums
            });
            bands.into_iter().fold([[0.0; 3]; 2], |sums, band| {
                [0, 1].map(|part| [0, 1, 2].map(|i| sums[part][i] + band[part][i]))
            })
        };
        // Squares that may have left the range of doubles say nothing.
        let plain = sums(1.0);
        let in_range = |first: usize| {
            let squares = plain[first];
            if squares[..2].iter().all(|square| SQUARES.contains(square)) {
                return (squares, 1.0);
            }
            let largest = pairs(0..self.grid.len())
                .flat_map(|(traction, mapped)| {
                    traction.into_iter().skip(first).chain(mapped.into_iter().skip(first))
                })
                .fold(0.0, |a: f64, b| a.max(b.abs()));
            if largest > 0.0 && largest.is_finite() {
                (sums(largest)[first], largest)
            } else {
                (squares, 1.0)
            }
        };
        let ([defect, size, _], _) = in_range(0);
        let residual = if defect == 0.0 { 0.0 } else { (defect / size).sqrt() };
        let Some(past) = past else { return residual };
        let ([defect, size, image], unit) = in_range(1);
        let tangential = if defect == 0.0 {
            0.0
        } else {
            (defect / size.max(image).max((past / unit).powi(2))).sqrt()
        };
        // The function `max` would pass over what is not a number.
        if residual.is_nan() { residual } else { residual.max(tangential) }
    }

    /// Returns x = p − E v of an element with the `traction` p, with v = εp + w and E = 1/(ε +
    /// `diagonal`); vectors are in the order (n, x, y).
    pub(crate) fn trial(&self, traction: [f64; 3], w: [f64; 3], diagonal: Diagonals) -> [f64; 3] {
        let [normal, tangential] =
            [diagonal.normal, diagonal.tangential].map(|entry| entry + self.epsilon);
        let moved =
            |c: usize, entry: f64| traction[c] - (self.epsilon * traction[c] + w[c]) / entry;
        [moved(0, normal), moved(1, tangential), moved(2, tangential)]
    }

    /// Returns the largest tension (−p₁)₊ or excess of traction (|p_t| − μp₁)₊, over the largest
    /// pressure \[1\]. These conditions hold element by element, and the residual as a mean over
    /// all elements does not bound them well.
    pub(crate) fn violation(&self, p: &[f64]) -> f64 {
        let bands = parallel::bands(self.grid.len(), |band| {
            let (mut worst, mut peak) = (0.0_f64, 0.0_f64);
            for [normal, x, y] in self.grid.active_in(band).map(|e| self.traction(p, e)) {
                peak = peak.max(normal.abs());
                worst = worst.max(-normal).max(x.hypot(y) - self.mu * normal);
            }
            (worst, peak)
        });
        let (worst, peak) = bands
            .into_iter()
            .fold((0.0_f64, 0.0_f64), |most, band| (most.0.max(band.0), most.1.max(band.1)));
        if worst == 0.0 { 0.0 } else { worst / peak }
    }
}
