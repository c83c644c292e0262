//! The set of frictions for which the contact problem has at most one solution, whatever the loads:
//! US(A) and its end μ*.
//!
//! # Definition
//! A. I. Alexandrov, "The solution of elastic contact problems with the use of nonlinear integral
//! equations": 𝔅_μ is the class of operators B that act at each point of Ω as a 3×3 matrix with
//!
//! ```text
//! b₁₁ = c₁, b₂₁ = c₁a, b₃₁ = c₁b, b₁₂ = b₁₃ = 0, tangential block T(φ) diag(c₂, c₃) T(φ)ᵀ,
//! 0 ≤ c₁, c₂, c₃ ≤ 1, √(a² + b²) ≤ μ, c₃ (a² + b²) = 0,
//! US(A) = { μ > 0 : for some E > 0, Ker(B(I − EA) − I) = {0} for every B in 𝔅_μ }.
//! ```
//!
//! Two solutions of p = G_μ(p − E(Ap − f)) differ by an x with x = B(I − EA)x, B in 𝔅_μ: for μ in
//! US(A) there is at most one, for every f. Here A is the discrete operator εI + A on the 3k
//! tractions of k elements, symmetric; it has no loads, no punch shape and no friction in it, so μ*
//! depends on the elastic bodies, Ω and its mesh alone.
//!
//! # A form without B and without E
//! Let y = Ax and z = x − Ey. At one element x = Bz says
//! - x₁ = c₁z₁ for some 0 ≤ c₁ ≤ 1, that is x₁y₁ ≤ 0;
//! - x_t = x₁(a, b) + Tz_t. The vectors Tz_t are those d with |d|² ≤ d·z_t (T is firmly
//!   nonexpansive), the disk with diameter \[0, z_t\]; one of rank one, c₃ = 0, reaches all of
//!   them, which is why c₃(a² + b²) = 0 takes nothing away. So x_t is at most μ|x₁| away from that
//!   disk: |x_t − z_t/2| ≤ |z_t|/2 + μ|x₁|, or |x_t + Ey_t| − |x_t − Ey_t| ≤ 2μ|x₁|.
//!
//! The left side is 4 x_t·y_t / (|x_t/E + y_t| + |x_t/E − y_t|). It has the sign of x_t·y_t, and
//! where that is positive it grows with E, to 2 x_t·y_t/|y_t|. Hence, with the least μ that an x
//! needs,
//!
//! ```text
//! F(x) = max over elements with x_t·y_t > 0 of x_t·y_t / (|x₁| |y_t|)   (∞ where x₁ = 0 there, 0 without such elements),
//! μ* = min { F(x) : x ≠ 0, x₁y₁ ≤ 0 at every element }.
//! ```
//!
//! Points that the derivation has to mind, all of them checked:
//! - For finite E the least μ of an x is *smaller* than F(x), F_E(x) ↑ F(x). So an x with F(x) = μ
//!   has a B in 𝔅_μ for *every* E > 0, which is what it takes to show μ ∉ US(A); a B for one E
//!   alone shows nothing, since US(A) asks for some E only.
//! - F_E is lower semicontinuous on the compact set of admissible unit x, and so is their supremum
//!   F: the minimum is attained (or +∞), and min F_E ↑ min F. US(A) is the open interval (0, μ*):
//!   μ* itself does not belong to it. For the operator on L₂ the minimum is an infimum only.
//! - y_t = 0 (stick) imposes nothing, and F jumps there: near it x_t·y_t/|y_t| takes any value up
//!   to |x_t|. What is computed in floating point must stay on the side x_t·y_t < 0.
//! - x₁ = 0 leaves no term μ|x₁|: such an element needs x_t·y_t ≤ 0, whatever μ.
//! - Where A is positive definite (always in the average projection, or for ε > 0 large enough)
//!   F(x) = 0 is impossible: it would make xᵀAx ≤ 0. So μ* > 0.
//! - Without normal–tangential coupling x₁ᵀA₁₁x₁ ≤ 0 forces x₁ = 0, hence x_tᵀA_tt x_t ≤ 0 and x =
//!   0: no admissible x at all, μ* = ∞ exactly ([`Bracket::Unbounded`]).
//!
//! # Both sides
//! - Below, [`lower`]: if for weights α, β, τ > 0 per element the matrix sym(αΠ₁A) + sym(βΠ_tA) −
//!   (μ/2)(βτΠ₁ + AᵀΠ_t(β/τ)A) is positive definite, then μ < μ*: its form is at most Σ α x₁y₁ +
//!   β(x_t·y_t − μ|x₁||y_t|), and x ≠ 0 with F(x) ≤ μ would make that ≤ 0. This is the S-procedure;
//!   it is not lossless, so a gap may remain.
//! - Above, [`upper`]: an x with F(x) = μ. It is exact in itself, and turned into an explicit B for
//!   an explicit E. The best ones known are stripes.
//!
//! # Fields and units
//! Fields have three blocks n | x | y, each with one number per element *of Ω*, ascending; masked
//! elements have none. Everything is dimensionless as in [`crate::problem`]: lengths in ℓ,
//! compliances in c, so E is in units of 1/cℓ and μ* has no unit.

use faer::Mat;
use serde::{Deserialize, Serialize};

use self::lower::LowerBound;
use self::witness::Witness;
use crate::grid::Grid;
use crate::influence::{Dense, Entry, Influence, InfluenceTable, Scratch, Toeplitz};
use crate::model::{
    Foundation, Friction, Loading, Material, Mesh, Method, Numerics, Projection, Punch, Scene,
    SceneError, Shape, Step,
};
use crate::problem::Problem;
use crate::punch::Surfaces;

mod barrier;
mod descent;
mod lbfgs;
pub mod lower;
mod newton;
mod ratio;
mod symmetry;
pub mod upper;
pub mod witness;

/// What μ* depends on, in SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Question {
    /// The body below the plane of contact.
    pub foundation: Foundation,
    /// Elastic half-space material of the body above it; `None` is a rigid one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub punch: Option<Material>,
    /// Ω, where the two can touch.
    pub sole: Sole,
    /// Elements that Ω is cut into.
    pub mesh: Mesh,
    /// How A becomes a matrix.
    #[serde(default)]
    pub projection: Projection,
    /// Regularisation ε ≥ 0 \[1\]: the operator gets ε·c·ℓ·I.
    #[serde(default)]
    pub epsilon: f64,
}

impl Question {
    /// Refuses what has no meaning.
    pub fn validate(&self) -> Result<(), SceneError> {
        let (scene, numerics) = self.flat_punch();
        scene.validate()?;
        numerics.validate()
    }

    /// The contact problem of a flat punch with this sole, whose operator it is.
    pub(crate) fn flat_punch(&self) -> (Scene, Numerics) {
        let shape = match self.sole {
            Sole::Rectangle { width_x, width_y } => Shape::FlatRectangle { width_x, width_y },
            Sole::Disk { radius } => Shape::FlatDisk { radius },
        };
        let scene = Scene {
            foundation: self.foundation.clone(),
            punch: Punch { shape, material: self.punch },
            friction: Friction { mu: 0.0 },
            domain: None,
            loading: Loading::path(vec![Step { approach: Some(0.0), ..Step::default() }]),
        };
        let numerics = Numerics {
            mesh: self.mesh,
            projection: self.projection,
            epsilon: self.epsilon,
            ceiling: None,
            method: Method::Auto,
            tolerance: Numerics::default_tolerance(),
            max_iterations: Numerics::default_max_iterations(),
            simulate: Vec::new(),
        };
        (scene, numerics)
    }
}

/// Where the bodies can touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Sole {
    /// A rectangle.
    Rectangle {
        /// Extent along x > 0 \[m\].
        width_x: f64,
        /// Extent along y > 0 \[m\].
        width_y: f64,
    },
    /// A disk: the elements with their centre inside it, sized so that their areas add up to its
    /// area where the mesh is square.
    Disk {
        /// Radius > 0 \[m\].
        radius: f64,
    },
}

/// Where μ* is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Bracket {
    /// μ* = ∞, exactly: pressures move nothing sideways.
    Unbounded,
    /// Between the two.
    Bounded {
        /// Below: US(A) holds its μ, if it is [verified](LowerBound::verified).
        lower: LowerBound,
        /// Above: US(A) does not hold its μ.
        upper: Witness,
    },
}

/// How long to look for a bracket.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Effort {
    /// The search for a witness.
    #[serde(default)]
    pub search: upper::Search,
}

/// Why there is no bracket.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BracketError {
    /// The question has no meaning.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// No certificate.
    #[error("no lower bound: {0}")]
    Lower(#[from] lower::LowerError),
    /// No witness.
    #[error("no upper bound: {0}")]
    Upper(#[from] upper::UpperError),
}

/// The most elements of which every orbit gets weights of its own; beyond, they are carried over
/// from a coarser mesh.
const DENSE_ELEMENTS: usize = 256;

/// Brackets μ*: a certificate with weights below, and a witness above. Either side is checked on
/// its own, by [`lower::verify`] and [`Witness::verify`]; a certificate with more than
/// [`lower::FACTORED_ROWS`] rows to factor is not, and proves nothing ([`LowerBound::verified`]).
pub fn bracket(question: &Question, effort: &Effort) -> Result<Bracket, BracketError> {
    let system = System::new(question)?;
    match (lower_side(question, &system)?, upper::upper(question, &effort.search)?) {
        (lower::Lower::Bound(lower), upper::Upper::Bound(upper)) => {
            Ok(Bracket::Bounded { lower, upper })
        }
        _ => Ok(Bracket::Unbounded),
    }
}

fn lower_side(question: &Question, system: &System) -> Result<lower::Lower, BracketError> {
    let mut elements = [system.grid().nx(), system.grid().ny()];
    if system.elements() <= DENSE_ELEMENTS {
        return Ok(lower::lower(system, lower::Freedom::PerOrbit)?);
    }
    while elements[0] * elements[1] > DENSE_ELEMENTS {
        elements = elements.map(|n| n.div_ceil(2));
    }
    let coarse = System::new(&Question {
        mesh: Mesh::Exact(elements.map(|n| n as u32)),
        ..question.clone()
    })?;
    match lower::lower(&coarse, lower::Freedom::PerOrbit)? {
        lower::Lower::Unbounded => Ok(lower::Lower::Unbounded),
        lower::Lower::Bound(bound) => {
            Ok(lower::lower_from(system, &coarse, &bound, lower::FACTORED_ROWS)?)
        }
    }
}

/// The operator εI + A on the elements of Ω.
#[derive(Clone, Debug)]
pub struct System {
    table: InfluenceTable,
    toeplitz: Toeplitz,
    epsilon: f64,
}

impl System {
    /// The operator of a question: that of the contact problem of a flat punch with this sole.
    /// Refuses what [`Scene::validate`] and [`Numerics::validate`] refuse.
    pub fn new(question: &Question) -> Result<Self, SceneError> {
        let (scene, numerics) = question.flat_punch();
        let problem = Problem::new(&scene, &numerics, &Surfaces::default())?;
        let table = InfluenceTable::new(&problem.grid, problem.elasticity, problem.projection);
        let toeplitz = Toeplitz::new(&table);
        Ok(Self { table, toeplitz, epsilon: problem.epsilon })
    }

    /// The elements, in units of ℓ.
    pub fn grid(&self) -> &Grid {
        self.table.grid()
    }

    /// The influence coefficients of A, without ε.
    pub fn table(&self) -> &InfluenceTable {
        &self.table
    }

    /// ε.
    pub fn epsilon(&self) -> f64 {
        self.epsilon
    }

    /// k, the number of elements of Ω; a field has 3k numbers.
    pub fn elements(&self) -> usize {
        self.grid().active_len()
    }

    /// The largest diagonal entry of εI + A.
    pub fn largest_diagonal(&self) -> f64 {
        self.epsilon + self.table.largest_diagonal()
    }

    /// Whether pressures move any element sideways, to the last bit: without that μ* = ∞.
    pub fn is_coupled(&self) -> bool {
        let (nx, ny) = (self.grid().nx() as i64, self.grid().ny() as i64);
        let some =
            |entry: Entry, dj: i64| self.table.row(entry, dj).iter().any(|&value| value != 0.0);
        self.elements() > 1
            && nx * ny > 1
            && (1 - ny..ny).any(|dj| some(Entry::Nx, dj) || some(Entry::Ny, dj))
    }

    /// εI + A as a 3k × 3k matrix; 72 k² bytes.
    pub fn matrix(&self) -> Mat<f64> {
        let mut matrix = Dense::new(&self.table).matrix().to_owned();
        for at in 0..matrix.nrows() {
            matrix[(at, at)] += self.epsilon;
        }
        matrix
    }

    /// Memory for applications.
    pub fn scratch(&self) -> Scratch {
        Scratch::new(&self.toeplitz)
    }

    /// y = (εI + A) x by FFT.
    ///
    /// # Panics
    /// Unless both have 3k numbers.
    pub fn apply(&self, y: &mut [f64], x: &[f64], scratch: &mut Scratch) {
        let (k, n) = (self.elements(), self.grid().len());
        assert_eq!((y.len(), x.len()), (3 * k, 3 * k), "fields on another grid");
        if k == n {
            self.toeplitz.apply(y, x, scratch);
        } else {
            let (mut from, mut to) = (vec![0.0; 3 * n], vec![0.0; 3 * n]);
            self.onto_grid(&mut from, x);
            self.toeplitz.apply(&mut to, &from, scratch);
            self.off_grid(y, &to);
        }
        for (y, x) in y.iter_mut().zip(x) {
            *y += self.epsilon * x;
        }
    }

    /// A field on Ω as one on the whole grid, whose other elements keep what they have.
    fn onto_grid(&self, whole: &mut [f64], field: &[f64]) {
        let (k, n) = (self.elements(), self.grid().len());
        for block in 0..3 {
            for (at, e) in self.grid().active().enumerate() {
                whole[block * n + e] = field[block * k + at];
            }
        }
    }

    /// The reverse of [`onto_grid`](Self::onto_grid).
    fn off_grid(&self, field: &mut [f64], whole: &[f64]) {
        let (k, n) = (self.elements(), self.grid().len());
        for block in 0..3 {
            for (at, e) in self.grid().active().enumerate() {
                field[block * k + at] = whole[block * n + e];
            }
        }
    }
}

/// Σ aᵢbᵢ.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
