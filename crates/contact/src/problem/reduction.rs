//! The effects that a scene calls for, the reasons, and the stages of a solve that follow from
//! them. An effect that a scene does not call for is not simulated, and leaving it out is exact:
//! the solution has none of it.
//!
//! Every decision is made from the scene before it is solved, and can be overruled
//! ([`Numerics::simulate`]). A test holds the solution with an effect left out against the one with
//! it.

use serde::Serialize;

use crate::foundation::relative_bodies;
use crate::influence::{Components, Mirror, Symmetry};
use crate::model::{Control, Dof, Effect, Numerics, Scene, SceneError, Shape};
use crate::punch::{Surfaces, domain};

/// The decision whether an effect is simulated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Decision {
    /// The effect.
    pub effect: Effect,
    /// The decision: true if the effect is simulated.
    pub on: bool,
    /// The reason, in words.
    pub reason: String,
}

/// The effects that a scene calls for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Effects(Vec<Decision>);

impl Effects {
    /// Returns the decision on every effect, in the order of [`Effect::ALL`].
    pub fn decisions(&self) -> &[Decision] {
        &self.0
    }

    /// Returns whether an effect is simulated.
    pub fn has(&self, effect: Effect) -> bool {
        self.0.iter().any(|decision| decision.effect == effect && decision.on)
    }

    /// Decides for a scene on a grid with so many `elements` along x and y.
    ///
    /// # Errors
    /// A [`SceneError`] reports a domain that cannot be derived, as
    /// [`Problem::new`](super::Problem::new) would.
    pub fn of(
        scene: &Scene,
        numerics: &Numerics,
        elements: [usize; 2],
        surfaces: &Surfaces,
    ) -> Result<Self, SceneError> {
        let mut effects = Effects(Vec::with_capacity(Effect::ALL.len()));
        for effect in Effect::ALL {
            let (on, reason) = match effect {
                Effect::Friction => friction(scene),
                Effect::Coupling => coupling(scene, &effects),
                Effect::TractionX | Effect::TractionY => direction(scene, &effects, effect),
                Effect::AsymmetryX => asymmetry(scene, &effects, 0, elements, surfaces)?,
                Effect::AsymmetryY => asymmetry(scene, &effects, 1, elements, surfaces)?,
                Effect::Layers => layers(scene),
                Effect::Regularisation if numerics.epsilon > 0.0 => {
                    (true, format!("epsilon = {:e}", numerics.epsilon))
                }
                Effect::Regularisation => (false, "epsilon = 0".to_owned()),
                Effect::Ceiling => match numerics.ceiling {
                    Some(ceiling) => (true, format!("ceiling = {ceiling:e} Pa")),
                    None => (false, "no ceiling is given".to_owned()),
                },
                Effect::History => history(scene),
                Effect::LoadControl => load_control(scene),
            };
            let forced = !on && numerics.simulate.contains(&effect);
            let reason =
                if forced { format!("asked for by `simulate`, although {reason}") } else { reason };
            effects.0.push(Decision { effect, on: on || forced, reason });
        }
        Ok(effects)
    }
}

/// Returns whether a path has tangential loads along x, along y, and about z.
fn tangential_loads(scene: &Scene) -> [bool; 3] {
    Dof::TANGENTIAL.map(|dof| scene.loading.legs().iter().any(|leg| !is_nothing(leg.target[dof])))
}

/// Returns whether a control leaves a degree of freedom where a symmetric solution leaves it
/// anyway.
fn is_nothing(control: Control) -> bool {
    matches!(control, Control::Motion(0.0) | Control::Force(0.0))
}

/// Returns whether the surfaces' normal and tangential displacements are independent, and why.
fn uncoupled(scene: &Scene) -> (bool, &'static str) {
    let bodies = relative_bodies(scene, 1.0);
    if bodies.layers.is_some() {
        (false, "layers couple normal and tangential displacements")
    } else if bodies.surface.coupling == 0.0 {
        (
            true,
            if scene.punch.material.is_some() {
                "the bodies' couplings cancel"
            } else {
                "the foundation is incompressible"
            },
        )
    } else {
        (false, "normal and tangential displacements depend on each other")
    }
}

fn friction(scene: &Scene) -> (bool, String) {
    let (uncoupled, why) = uncoupled(scene);
    let loads = tangential_loads(scene);
    if scene.friction.mu == 0.0 {
        (false, "friction.mu = 0".to_owned())
    } else if uncoupled && loads == [false; 3] {
        (false, format!("{why} and nothing moves the punch sideways"))
    } else if loads == [false; 3] {
        (true, format!("friction.mu > 0 and {why}"))
    } else {
        (true, "friction.mu > 0 and the punch is moved or pulled sideways".to_owned())
    }
}

fn coupling(scene: &Scene, effects: &Effects) -> (bool, String) {
    let (uncoupled, why) = uncoupled(scene);
    if !effects.has(Effect::Friction) {
        (false, "no tangential tractions".to_owned())
    } else {
        (!uncoupled, why.to_owned())
    }
}

/// Decides on the tractions along x or y. Without coupling and without ν/G the two directions are
/// independent, and only the loaded one has tractions.
fn direction(scene: &Scene, effects: &Effects, effect: Effect) -> (bool, String) {
    let own = if effect == Effect::TractionX { 0 } else { 1 };
    let loads = tangential_loads(scene);
    let bodies = relative_bodies(scene, 1.0);
    if !effects.has(Effect::Friction) {
        (false, "no tangential tractions".to_owned())
    } else if effects.has(Effect::Coupling) {
        (true, "the coupling moves the surface in every direction".to_owned())
    } else if bodies.layers.is_some() || bodies.surface.cross != 0.0 {
        (
            true,
            "tractions along one direction move the surface along the other too (ν > 0)".to_owned(),
        )
    } else if loads[2] {
        (true, "the punch is twisted".to_owned())
    } else if loads[own] {
        (true, "the punch is moved or pulled this way".to_owned())
    } else if loads == [false; 3] {
        (true, "tangential tractions are asked for by `simulate`".to_owned())
    } else {
        (false, "ν = 0, no coupling, and nothing moves the punch this way".to_owned())
    }
}

fn layers(scene: &Scene) -> (bool, String) {
    match relative_bodies(scene, 1.0).layers {
        Some(layered) => (true, format!("{} of different materials", layered.layers().len())),
        None if scene.foundation.layers.is_empty() => {
            (false, "a homogeneous half-space".to_owned())
        }
        None => (false, "all layers are of the base's material".to_owned()),
    }
}

fn history(scene: &Scene) -> (bool, String) {
    let increments: u32 = scene.loading.legs().iter().map(|leg| leg.increments).sum();
    if increments > 1 {
        (true, format!("{increments} increments"))
    } else {
        (false, "a single increment from zero traction".to_owned())
    }
}

fn load_control(scene: &Scene) -> (bool, String) {
    let governed = scene
        .loading
        .legs()
        .iter()
        .any(|leg| leg.target.iter().any(|control| matches!(control, Control::Force(_))));
    (
        governed,
        if governed { "a force or a moment is prescribed" } else { "all motion is prescribed" }
            .to_owned(),
    )
}

/// The unknowns that are solved at once: some components, on the positive sides of mirror planes.
/// Without coupling the pressure comes first and the tangential tractions after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// The components.
    pub components: Components,
    /// The mirror planes.
    pub mirror: Mirror,
}

impl Stage {
    /// Returns the number of unknowns of a problem on so many `elements` along x and y.
    pub fn unknowns(&self, elements: [usize; 2]) -> usize {
        let half = |n: usize, plane: Option<Symmetry>| if plane.is_some() { n / 2 } else { n };
        self.components.len() * half(elements[0], self.mirror.x) * half(elements[1], self.mirror.y)
    }
}

impl Effects {
    /// Returns the stages in which the scene is solved.
    pub fn stages(&self, scene: &Scene) -> Vec<Stage> {
        let plane = |axis: usize, effect: Effect, tangential: bool| {
            let behaviour =
                if tangential { image(scene, self, axis) } else { Some(Symmetry::Symmetric) };
            behaviour.filter(|_| !self.has(effect))
        };
        let mirror = |tangential: bool| Mirror {
            x: plane(0, Effect::AsymmetryX, tangential),
            y: plane(1, Effect::AsymmetryY, tangential),
        };
        let members = [self.has(Effect::TractionX), self.has(Effect::TractionY)];
        if !self.has(Effect::Friction) {
            vec![Stage { components: Components::NORMAL, mirror: mirror(false) }]
        } else if self.has(Effect::Coupling) {
            vec![Stage {
                components: Components::of([true, members[0], members[1]]),
                mirror: mirror(true),
            }]
        } else {
            vec![
                Stage { components: Components::NORMAL, mirror: mirror(false) },
                Stage {
                    components: Components::of([false, members[0], members[1]]),
                    mirror: mirror(true),
                },
            ]
        }
    }
}

/// Returns the symmetry of the tangential tractions of a scene that is mirror-symmetric in
/// direction `axis` (0: x, 1: y). Under coupling they behave like the surface displacements of a
/// symmetric pressure, and without it like the tangential load. The result is `None` if they do
/// neither.
fn image(scene: &Scene, effects: &Effects, axis: usize) -> Option<Symmetry> {
    let [x, y, twist] = tangential_loads(scene);
    let (along, across) = if axis == 0 { (x, y) } else { (y, x) };
    match (along || twist, across) {
        (false, _) => Some(Symmetry::Symmetric),
        (true, false) if !effects.has(Effect::Coupling) => Some(Symmetry::Antisymmetric),
        (true, _) => None,
    }
}

fn asymmetry(
    scene: &Scene,
    effects: &Effects,
    axis: usize,
    elements: [usize; 2],
    surfaces: &Surfaces,
) -> Result<(bool, String), SceneError> {
    let name = ["x", "y"][axis];
    let domain = domain(scene, surfaces)?;
    let center = [domain.center_x, domain.center_y][axis];
    // A tilt about y lifts one side in x.
    let tilt = Dof::tilt_about(1 - axis);
    let legs = scene.loading.legs();
    Ok(if !has_mirror(&scene.punch.shape, axis, surfaces) {
        (true, format!("the punch's shape is not known to be its own image in {name}"))
    } else if center != 0.0 {
        (true, format!("Ω is not centred in {name}"))
    } else if !elements[axis].is_multiple_of(2) {
        (true, format!("the number of elements along {name} is odd"))
    } else if legs.iter().any(|leg| !is_nothing(leg.target[tilt])) {
        (true, format!("the punch is tilted or loaded eccentrically in {name}"))
    } else if effects.has(Effect::Friction) && image(scene, effects, axis).is_none() {
        (true, format!("the tangential load has no image in {name}"))
    } else {
        (false, format!("shape, load and Ω are their own images in {name}"))
    })
}

/// Returns whether a shape is its own mirror image in x (0) or y (1), exactly.
fn has_mirror(shape: &Shape, axis: usize, surfaces: &Surfaces) -> bool {
    match shape {
        Shape::Sphere { .. }
        | Shape::Ellipsoid { .. }
        | Shape::FlatRectangle { .. }
        | Shape::FlatDisk { .. }
        | Shape::Cone { .. } => true,
        Shape::HeightMap { surface, .. } => surfaces.get(surface).is_some_and(|map| {
            let (columns, rows, heights) = (map.columns(), map.rows(), map.heights());
            let image = |at: usize| match (axis, at % columns, at / columns) {
                (0, i, j) => j * columns + columns - 1 - i,
                (_, i, j) => (rows - 1 - j) * columns + i,
            };
            (0..heights.len()).all(|at| heights[at] == heights[image(at)])
        }),
        Shape::WheelOnRail(_) => false,
    }
}
