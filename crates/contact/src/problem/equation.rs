//! A scene bound to a grid: equation (3), p = Gᵘ_μ(p − E(εp + Ap − f)), for one increment of the
//! loading path.
//!
//! A problem is dimensionless: lengths in units of ℓ (half the diameter of Ω), tractions in units
//! of 1/c (c = Σ(1−ν)/G), so that neither the unit of length nor the moduli can be felt by a
//! solver. Jobs that differ only in moduli of equal ratio, loads or sizes therefore share their
//! operator.
//!
//! Along a path f₁ = δ + tilt terms − g₀ and f_t = (rigid motion since the increment before) +
//! (εp + Ap)_t of that increment, so that w_t is the slip increment: what is held still stays as it
//! is, for ε > 0 as well.

use std::ops::Range;

use rayon::prelude::*;

use super::friction::g_mu;
use super::layout::Layout;
use super::scale::{self, Scale};
use crate::common::parallel;
use crate::foundation::{Bodies, relative_bodies};
use crate::grid::{Grid, GridError};
use crate::influence::{Components, Diagonals, Direction, Mirror, MirrorError, weighted_images};
use crate::model::{Dof, Numerics, PerDof, Projection, Scene, SceneError, rigid_modes};
use crate::punch::{Gap, Surfaces, domain};

/// Equation (3) on a grid, dimensionless. Fields are blocks of [components](Problem::components)
/// \[n | x | y\], each as long as the grid.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The components that there are; all three unless the problem is [reduced](Problem::reduced).
    pub components: Components,
    /// p₁ where n is not among them.
    pub pressure: Option<Vec<f64>>,
    /// The planes to one side of which the grid lies.
    pub mirror: Mirror,
    /// The grid with its other sides, where there are any.
    whole: Option<Grid>,
    /// Elements, in units of ℓ; masked where the punch has no sole.
    pub grid: Grid,
    /// The bodies' summed compliances, in units of c.
    pub elasticity: Bodies,
    /// How A is discretised.
    pub projection: Projection,
    /// μ.
    pub mu: f64,
    /// ε; the operator of equation (3) is εI + A.
    pub epsilon: f64,
    /// The ceiling u, infinite for none.
    pub ceiling: f64,
    /// f, in units of ℓ, for the motion last [placed](Problem::place).
    pub f: Vec<f64>,
    /// f without rigid motion: −g₀, and tangentially what the increment before left behind.
    rest: Vec<f64>,
    /// Elements at whose side away from the grid's middle the punch goes on beyond Ω.
    pub open_edge: bool,
    /// Units.
    pub scale: Scale,
}

/// Sums of squares that no square has left for being too large or too small.
const SQUARES: std::ops::Range<f64> = 1e-250..1e250;

/// The operator that a problem needs, up to everything that does not change it; equal keys share an
/// operator.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatorKey {
    elements: [usize; 2],
    element: [f64; 2],
    mask: Option<Vec<bool>>,
    elasticity: Bodies,
    projection: Projection,
    components: Components,
    mirror: Mirror,
}

impl OperatorKey {
    /// Whether operators of both can be made of one table, as far as it has the components.
    pub(crate) fn shares_table(&self, other: &Self) -> bool {
        Self { components: other.components, mirror: other.mirror, ..self.clone() } == *other
    }
}

impl Problem {
    /// Binds a scene to a grid. Refuses what [`Scene::validate`] and [`Numerics::validate`] refuse,
    /// a domain that cannot be derived, and a grid on which the punch has no sole.
    pub fn new(
        scene: &Scene,
        numerics: &Numerics,
        surfaces: &Surfaces,
    ) -> Result<Self, SceneError> {
        scene.validate()?;
        numerics.validate()?;
        let gap = Gap::new(scene, surfaces)?;
        let domain = domain(scene, surfaces)?;
        let layout = Layout::new(scene, numerics, &domain)?;
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
        let gaps: Vec<Option<f64>> = (0..grid.len())
            .into_par_iter()
            .map(|e| {
                let [x, y] = grid.center(e);
                if let Some(reach) = layout.disk {
                    return (x.hypot(y) <= hx * reach * (1.0 + 1e-12)).then_some(0.0);
                }
                match numerics.projection {
                    Projection::Average => {
                        gap.mean(x * length, y * length, hx * length, hy * length)
                    }
                    Projection::Midpoint => gap.at(x * length, y * length),
                }
            })
            .collect();
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
        scale::check_operator(&bodies, &grid, numerics.projection)?;
        scale::check_loads(scene, numerics, &scale, &grid, &rest)?;
        // a clone would touch the zeros too
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
            open_edge: layout.open_edge,
            scale,
        })
    }

    /// The same problem for some of its components, on the positive sides of mirror planes, under a
    /// given pressure where n is left out. Whether that is the same problem is for the caller to
    /// know ([`Effects`](super::reduction::Effects)); it has the motion last placed and the same
    /// past. Fails where the grid has no such planes.
    pub fn reduced(
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
            open_edge: self.open_edge,
            scale: self.scale,
        })
    }

    /// What a field of all three components is of these, on the positive sides of mirror planes.
    pub fn part(&self, components: Components, mirror: Mirror, field: &[f64]) -> Vec<f64> {
        let k = self.grid.len();
        if components == Components::ALL {
            return mirror.restrict(&self.grid, field);
        }
        let blocks = components
            .directions()
            .map(|direction| mirror.restrict(&self.grid, &field[direction as usize * k..][..k]));
        blocks.collect::<Vec<_>>().concat()
    }

    /// Writes a field of a problem [reduced](Problem::reduced) from this one into one of all three
    /// components.
    pub fn extend(&self, reduced: &Problem, field: &[f64], into: &mut [f64]) {
        let k = self.grid.len();
        let all = reduced.mirror.extend(&self.grid, reduced.components, field);
        for (block, direction) in all.chunks_exact(k).zip(reduced.components.directions()) {
            into[direction as usize * k..][..k].copy_from_slice(block);
        }
    }

    /// The grid with its images.
    pub fn whole_grid(&self) -> &Grid {
        self.whole.as_ref().unwrap_or(&self.grid)
    }

    /// Blocks of a field and the components they hold, n = 0, x = 1, y = 2.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        self.components.directions().map(|direction| direction as usize).enumerate()
    }

    /// Whether a rigid degree of freedom has a resultant among the problem's components, and
    /// symmetric ones.
    pub(crate) fn moves(&self, dof: Dof) -> bool {
        let modes = rigid_modes(1.0, 1.0);
        let has = |direction: Direction| {
            modes[direction as usize][dof] != 0.0
                && weighted_images(&self.mirror, direction)[dof] != 0.0
        };
        self.components.directions().any(has)
    }

    /// Moves the punch: f for the rigid motion `motion`, in the problem's units.
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
                        *f = rest + rigid_modes(x, y)[c].dot(motion);
                    }
                }
            });
        }
    }

    /// f₁ of an element without rigid motion, −g₀.
    pub(crate) fn unmoved(&self, element: usize) -> f64 {
        self.rest[element]
    }

    /// Makes the tractions `p` at `motion`, with `w` = A p − f, the state from which the next
    /// increment starts. Leaves f as it is.
    pub fn remember(&mut self, p: &[f64], w: &[f64], motion: &PerDof<f64>) {
        let (k, nx, grid) = (self.grid.len(), self.grid.nx(), &self.grid);
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
                    let at = block * k + j * nx + i;
                    let [x, y] = grid.center_of(i, j);
                    let moved = rigid_modes(x, y)[c].dot(motion);
                    *rest = self.epsilon * p[at] + w[at] + self.f[at] - moved;
                }
            });
        }
    }

    /// Forces and moments of the punch on the foundation, in the problem's units; of a reduced
    /// problem those of its components, with their images.
    pub fn resultants(&self, p: &[f64]) -> PerDof<f64> {
        let (k, nx) = (self.grid.len(), self.grid.nx());
        let mut sums = PerDof::all(0.0);
        for (block, direction) in self.components.directions().enumerate() {
            // of p, x p and y p, row by row
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
            let [all, of_x, of_y] =
                [0, 1, 2].map(|moment| moments.iter().map(|row| row[moment]).sum::<f64>());
            // each mode is 1, x or y of the place, up to a sign
            let [constant, at_x, at_y] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
                .map(|[x, y]| rigid_modes(x, y)[direction as usize]);
            let images = weighted_images(&self.mirror, direction);
            for dof in Dof::ALL {
                let [one, x, y] =
                    [constant[dof], at_x[dof] - constant[dof], at_y[dof] - constant[dof]];
                sums[dof] += images[dof] * (one * all + x * of_x + y * of_y);
            }
        }
        sums.map(|sum| sum * self.grid.element_area())
    }

    /// The tractions of an element, with zeros for the components that the problem has not and the
    /// given pressure.
    pub(crate) fn traction(&self, p: &[f64], element: usize) -> [f64; 3] {
        let mut own = self.gather(p, element);
        if let Some(pressure) = &self.pressure {
            own[0] = pressure[element];
        }
        own
    }

    /// The components of a field at an element, with zeros for those that the problem has not.
    pub(crate) fn gather(&self, field: &[f64], element: usize) -> [f64; 3] {
        let mut own = [0.0; 3];
        for (block, c) in self.blocks() {
            own[c] = field[block * self.grid.len() + element];
        }
        own
    }

    /// What its operator depends on.
    pub fn operator_key(&self) -> OperatorKey {
        OperatorKey {
            elements: [self.whole_grid().nx(), self.whole_grid().ny()],
            element: [self.grid.hx(), self.grid.hy()],
            components: self.components,
            mirror: self.mirror,
            mask: self.whole_grid().mask().map(<[bool]>::to_vec),
            elasticity: self.elasticity.clone(),
            projection: self.projection,
        }
    }

    /// Relative natural-map residual ‖p − Gᵘ_μ(p − E v)‖ / ‖p‖ with v = εp + w, E = 1/(ε +
    /// `diagonal`), for each direction its own; 0 when p = 0 solves the problem, infinite when p =
    /// 0 does not. `w` = A p − f. Masked elements do not count.
    pub fn residual(&self, p: &[f64], w: &[f64], diagonal: impl Into<Diagonals>) -> f64 {
        let diagonal = diagonal.into();
        // p and its image at each element
        let pairs = |band: Range<usize>| {
            self.grid.active_in(band).map(|e| {
                let (own, w) = (self.traction(p, e), self.gather(w, e));
                let mut x = self.trial(own, w, diagonal);
                if self.pressure.is_some() {
                    x[0] = own[0]; // solved before
                } else if self.components == Components::NORMAL {
                    [x[1], x[2]] = [0.0; 2];
                }
                (own, g_mu(x, self.mu, self.ceiling))
            })
        };
        let sums = |unit: f64| {
            let bands = parallel::bands(self.grid.len(), |band| {
                let (mut defect, mut size) = (0.0, 0.0);
                for (own, mapped) in pairs(band) {
                    for c in 0..3 {
                        defect += ((own[c] - mapped[c]) / unit).powi(2);
                        size += (own[c] / unit).powi(2);
                    }
                }
                (defect, size)
            });
            bands.into_iter().fold((0.0, 0.0), |sum, band| (sum.0 + band.0, sum.1 + band.1))
        };
        let (mut defect, mut size) = sums(1.0);
        // squares that may have left the range of doubles say nothing
        if !(SQUARES.contains(&defect) && SQUARES.contains(&size)) {
            let largest = pairs(0..self.grid.len())
                .flat_map(|(own, mapped)| [own, mapped])
                .flatten()
                .fold(0.0, |a: f64, b| a.max(b.abs()));
            if largest > 0.0 && largest.is_finite() {
                (defect, size) = sums(largest);
            }
        }
        if defect == 0.0 { 0.0 } else { (defect / size).sqrt() }
    }

    /// x = p − E v of an element, with v = εp + w and E = 1/(ε + `diagonal`).
    pub(crate) fn trial(&self, own: [f64; 3], w: [f64; 3], diagonal: Diagonals) -> [f64; 3] {
        let [normal, tangential] =
            [diagonal.normal, diagonal.tangential].map(|entry| entry + self.epsilon);
        let moved = |c: usize, entry: f64| own[c] - (self.epsilon * own[c] + w[c]) / entry;
        [moved(0, normal), moved(1, tangential), moved(2, tangential)]
    }

    /// The largest tension (−p₁)₊ or excess of traction (|p_t| − μp₁)₊, over the largest pressure:
    /// the conditions that hold element by element, which the residual as a mean over all elements
    /// does not bound well.
    pub fn violation(&self, p: &[f64]) -> f64 {
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
