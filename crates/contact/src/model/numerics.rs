//! The discretisation of a scene and the way in which it is solved. Nothing in here changes the
//! question, only the exactness of the answer.

use serde::{Deserialize, Serialize};

use super::effect::Effect;
use super::error::{SceneError, is_zero, positive, refuse};
use super::loading::{Leg, Loading};
use super::rigid::Control;

/// The discretisation of a scene and the way in which it is solved. Nothing in here changes the
/// question, only the exactness of the answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Numerics {
    /// The numbers of elements of the grid.
    pub mesh: Mesh,
    /// The rule by which the continuous operator becomes a matrix.
    #[serde(default)]
    pub projection: Projection,
    /// The regularisation ε ≥ 0 of equation (3) \[1\]. The operator gets ε·c·ℓ·I, with c the
    /// bodies' summed (1−ν)/G and ℓ half the diameter of Ω.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub epsilon: f64,
    /// The ceiling u > 0 on the pressure \[Pa\] in equation (3), which is known a priori; `None` is
    /// no ceiling, equation (1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ceiling: Option<f64>,
    /// The solver.
    #[serde(default)]
    pub method: Method,
    /// The largest relative natural-map residual that counts as solved, 0 < tolerance < 1 \[1\].
    #[serde(default = "Numerics::default_tolerance")]
    pub tolerance: f64,
    /// The number of iterations of one increment, on the grid itself, after which the solver gives
    /// up.
    #[serde(default = "Numerics::default_max_iterations")]
    pub max_iterations: u32,
    /// The effects that are simulated although the scene does not call for them
    /// ([`Effect::OPTIONAL`]).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub simulate: Vec<Effect>,
}

impl Numerics {
    /// Returns the default relative residual, 1e-8 \[1\].
    pub fn default_tolerance() -> f64 {
        1e-8
    }
    /// Returns the default limit on iterations.
    pub fn default_max_iterations() -> u32 {
        20_000
    }
}

/// The numbers of elements along x and y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Mesh {
    /// The number of elements along x and along y alike: an element is as long as Ω is. Per
    /// unknown this has the smallest error of what was measured, on domains of any aspect
    /// (the book, accuracy.md), and x and y play the same part.
    Across(u32),
    /// The numbers of elements along x and along y.
    Exact([u32; 2]),
}

/// The rule by which the continuous operator becomes a matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// The mean displacement over the receiving element (Alexandrov's averaging, equation 4;
    /// Galerkin).
    #[default]
    Average,
    /// The displacement at the receiving element's centre (collocation; CONTACT and most of the
    /// field).
    Midpoint,
}

/// The solvers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The method that suits the scene ([`Method::chosen`]).
    #[default]
    Auto,
    /// Alexandrov's nonlinear Seidel iteration, the reference.
    Seidel,
    /// Semismooth Newton from coarse grids to fine ones, with Seidel sweeps where it does not
    /// converge.
    Newton,
}

/// The method that solves a problem, and the reason for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChosenMethod {
    /// The method, which is not [`Method::Auto`].
    pub method: Method,
    /// The reason, in words.
    pub reason: &'static str,
}

impl Method {
    /// Returns the method that solves a problem of `elements` elements along x and y under these
    /// loads, and the reason. It is the method itself, unless the choice is left to the scene.
    pub fn chosen(self, loading: &Loading, elements: [usize; 2]) -> ChosenMethod {
        let legs = loading.legs();
        let prescribed = || {
            legs.iter()
                .flat_map(|leg| leg.target)
                .all(|control| matches!(control, Control::Motion(_)))
        };
        let (method, reason) = match self {
            Method::Auto if legs.iter().any(Leg::is_steady) => {
                (Method::Newton, "the sweeps of Seidel's iteration know no steady rolling")
            }
            Method::Auto if elements[0] * elements[1] <= 36 && prescribed() => (
                Method::Seidel,
                "so few elements are swept through faster than a linear system is set up",
            ),
            Method::Auto if prescribed() => {
                (Method::Newton, "its time grows little faster than the number of elements")
            }
            Method::Auto => (Method::Newton, "it has the forces' motions among its unknowns"),
            Method::Seidel | Method::Newton => (self, "asked for"),
        };
        ChosenMethod { method, reason }
    }
}

impl Mesh {
    /// The largest number of elements along one side.
    pub const MAX_SIDE: u32 = 4096;

    /// Returns the numbers of elements along x and y.
    pub fn sides(self) -> [u32; 2] {
        match self {
            Mesh::Across(n) => [n, n],
            Mesh::Exact(sides) => sides,
        }
    }
}

impl Numerics {
    /// Refuses settings under which a path cannot be followed, although each has a meaning.
    ///
    /// # Errors
    /// A [`SceneError`] reports a setting under which a contact cannot roll.
    pub fn suit(&self, loading: &Loading) -> Result<(), SceneError> {
        let legs = loading.legs();
        if self.epsilon > 0.0 && legs.iter().any(|leg| leg.rolling.is_some()) {
            return Err(refuse(
                "epsilon",
                self.epsilon,
                "must be 0 in a scene that rolls: the regularisation knows no places between \
                 elements",
            ));
        }
        if self.method == Method::Seidel && legs.iter().any(Leg::is_steady) {
            return Err(refuse(
                "method",
                "seidel",
                "must be \"newton\" in a scene that rolls steadily, which the sweeps do not know",
            ));
        }
        Ok(())
    }

    /// Refuses settings that cannot work.
    ///
    /// # Errors
    /// A [`SceneError`] reports the first offence in the order of the fields.
    pub fn validate(&self) -> Result<(), SceneError> {
        let shown = match self.mesh {
            Mesh::Across(n) => n.to_string(),
            Mesh::Exact([nx, ny]) => format!("[{nx}, {ny}]"),
        };
        if self.mesh.sides().iter().any(|n| !(1..=Mesh::MAX_SIDE).contains(n)) {
            return Err(refuse("mesh", shown, "must be 1 to 4096 elements along each side"));
        }
        if !(self.epsilon.is_finite() && self.epsilon >= 0.0) {
            return Err(refuse("epsilon", self.epsilon, "must be a finite number, 0 or above"));
        }
        if let Some(ceiling) = self.ceiling {
            positive("ceiling", ceiling)?;
        }
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            return Err(refuse(
                "tolerance",
                self.tolerance,
                "must lie between 0 and 1, for example 1e-8",
            ));
        }
        if self.max_iterations == 0 {
            return Err(refuse("max_iterations", 0, "must be at least 1"));
        }
        if let Some(effect) = self.simulate.iter().find(|effect| !Effect::OPTIONAL.contains(effect))
        {
            return Err(refuse(
                "simulate",
                effect.name(),
                "is simulated when the scene's own keys ask for it",
            ));
        }
        Ok(())
    }
}
