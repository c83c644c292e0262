//! The effects that a scene calls for, the reasons, and the stages of a solve that follow from
//! them. An effect that a scene does not call for is not simulated, and leaving it out is exact:
//! the solution has none of it.
//!
//! Every decision is made from the scene before it is solved, and can be overruled
//! ([`Numerics::simulate`]). A test holds the solution with an effect left out against the one with
//! it.

use serde::Serialize;

use super::layout::on_grid;
use crate::foundation::relative_bodies;
use crate::influence::{Components, Mirror, Symmetry};
use crate::model::{
    Control, Dof, Effect, InteriorQuestion, Leg, Numerics, Scene, SceneError, Shape, Wear,
    WheelRail,
};
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

/// The need that a scene has of an effect, before settings overrule it.
struct Ruling {
    /// The need: true if the solution without the effect would be another one.
    on: bool,
    /// The reason, in words.
    reason: String,
}

impl Ruling {
    /// Rules that the effect is needed.
    fn on(reason: impl Into<String>) -> Self {
        Self { on: true, reason: reason.into() }
    }

    /// Rules that the effect is not needed.
    fn off(reason: impl Into<String>) -> Self {
        Self { on: false, reason: reason.into() }
    }
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
        let scene = &*on_grid(scene, numerics, surfaces)?;
        let mut effects = Effects(Vec::with_capacity(Effect::ALL.len()));
        for effect in Effect::ALL {
            let Ruling { on, reason } = match effect {
                Effect::Friction => friction(scene),
                Effect::Coupling => coupling(scene, &effects),
                Effect::TractionX | Effect::TractionY => direction(scene, &effects, effect),
                Effect::AsymmetryX => asymmetry(scene, &effects, 0, elements, surfaces)?,
                Effect::AsymmetryY => asymmetry(scene, &effects, 1, elements, surfaces)?,
                Effect::Layers => layers(scene),
                Effect::Regularisation if numerics.epsilon > 0.0 => {
                    Ruling::on(format!("epsilon = {:e}", numerics.epsilon))
                }
                Effect::Regularisation => Ruling::off("epsilon = 0"),
                Effect::Ceiling => match numerics.ceiling {
                    Some(ceiling) => Ruling::on(format!("ceiling = {ceiling:e} Pa")),
                    None => Ruling::off("no ceiling is given"),
                },
                Effect::History => history(scene),
                Effect::LoadControl => load_control(scene),
                Effect::Rolling => rolling(scene, &effects),
                Effect::Wear => wear(scene, &effects),
                Effect::Interior => interior(scene),
            };
            let forced = !on && numerics.simulate.contains(&effect);
            let reason =
                if forced { format!("asked for by `simulate`, although {reason}") } else { reason };
            effects.0.push(Decision { effect, on: on || forced, reason });
        }
        Ok(effects)
    }
}

/// Rules on the stresses below the surface.
fn interior(scene: &Scene) -> Ruling {
    let Some(InteriorQuestion { maximum, depths, points }) = &scene.interior else {
        return Ruling::off(
            "the study has no `[interior]`: no stress below the surface is computed",
        );
    };
    let counted = |count: usize, one: &str| match count {
        0 => None,
        1 => Some(format!("one {one}")),
        _ => Some(format!("{count} {one}s")),
    };
    let wanted = [
        maximum.then(|| "the largest stresses".to_owned()),
        counted(depths.len(), "plane"),
        counted(points.len(), "point"),
    ];
    let wanted: Vec<String> = wanted.into_iter().flatten().collect();
    Ruling::on(format!("`[interior]` asks for {}", wanted.join(" and ")))
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

/// Rules whether the surfaces' normal and tangential displacements depend on each other.
fn coupled_surfaces(scene: &Scene) -> Ruling {
    let bodies = relative_bodies(scene, 1.0);
    if bodies.layers.is_some() {
        Ruling::on("layers couple normal and tangential displacements")
    } else if bodies.surface.coupling != 0.0 {
        Ruling::on("normal and tangential displacements depend on each other")
    } else if scene.punch.material.is_some() {
        Ruling::off("the bodies' couplings cancel")
    } else {
        Ruling::off("the foundation is incompressible")
    }
}

/// Rules on the tangential tractions.
fn friction(scene: &Scene) -> Ruling {
    let coupled = coupled_surfaces(scene);
    let loads = tangential_loads(scene);
    if scene.friction.mu == 0.0 {
        Ruling::off("friction.mu = 0, as in every scene that gives none")
    } else if !coupled.on && loads == [false; 3] {
        Ruling::off(format!("{} and nothing moves the punch sideways", coupled.reason))
    } else if loads == [false; 3] {
        Ruling::on(format!("friction.mu > 0 and {}", coupled.reason))
    } else {
        Ruling::on("friction.mu > 0 and the punch is moved or pulled sideways")
    }
}

/// Rules on the coupling of normal and tangential displacements.
fn coupling(scene: &Scene, effects: &Effects) -> Ruling {
    if effects.has(Effect::Friction) {
        coupled_surfaces(scene)
    } else {
        Ruling::off("no tangential tractions")
    }
}

/// Rules on the tractions along x or y. Without coupling and without ν/G the two directions are
/// independent, and only the loaded one has tractions.
fn direction(scene: &Scene, effects: &Effects, effect: Effect) -> Ruling {
    let axis = if effect == Effect::TractionX { 0 } else { 1 };
    let loads = tangential_loads(scene);
    let bodies = relative_bodies(scene, 1.0);
    if !effects.has(Effect::Friction) {
        Ruling::off("no tangential tractions")
    } else if effects.has(Effect::Coupling) {
        Ruling::on("the coupling moves the surface in every direction")
    } else if bodies.layers.is_some() || bodies.surface.cross != 0.0 {
        Ruling::on("tractions along one direction move the surface along the other too (ν > 0)")
    } else if loads[2] {
        Ruling::on("the punch is twisted")
    } else if loads[axis] {
        Ruling::on("the punch is moved or pulled this way")
    } else if loads == [false; 3] {
        Ruling::on("tangential tractions are asked for by `simulate`")
    } else {
        Ruling::off("ν = 0, no coupling, and nothing moves the punch this way")
    }
}

/// Rules on the layers.
fn layers(scene: &Scene) -> Ruling {
    match relative_bodies(scene, 1.0).layers {
        Some(layered) => Ruling::on(format!("{} of different materials", layered.layers().len())),
        None if scene.foundation.layers.is_empty() => Ruling::off("a homogeneous half-space"),
        None => Ruling::off("all layers are of the base's material"),
    }
}

/// Rules on the history of the path.
fn history(scene: &Scene) -> Ruling {
    let increments = scene.loading.increments();
    if increments > 1 {
        Ruling::on(format!("{increments} increments"))
    } else if scene.loading.legs().iter().any(Leg::is_steady) {
        Ruling::off("what rolls steadily has forgotten its past")
    } else {
        Ruling::off("a single increment from zero traction")
    }
}

/// Rules on the material that passes through the contact. Without tangential tractions it makes no
/// difference where the material has been.
fn rolling(scene: &Scene, effects: &Effects) -> Ruling {
    let legs = scene.loading.legs();
    let rolling: Vec<&Leg> = legs.iter().filter(|leg| leg.rolling.is_some()).collect();
    if rolling.is_empty() {
        return Ruling::off("no step rolls");
    }
    if !effects.has(Effect::Friction) {
        return Ruling::off("no tangential tractions");
    }
    let passing: u32 =
        rolling.iter().filter(|leg| !leg.is_steady()).map(|leg| leg.increments).sum();
    let rolls = match (passing, rolling.iter().any(|leg| leg.is_steady())) {
        (0, _) => "the steady state of rolling is asked for".to_owned(),
        (1, false) => "the contact rolls in an increment".to_owned(),
        (passing, false) => format!("the contact rolls in {passing} increments"),
        (_, true) => "the contact rolls along the path, and into its steady state".to_owned(),
    };
    Ruling::on(match &scene.punch.shape {
        Shape::WheelOnRail(WheelRail { motion: Some(_), .. }) => {
            format!("{rolls}; the creepages are those of the wheelset's motion")
        }
        Shape::HeightMap { .. } => {
            format!("{rolls}; the height map is an envelope that moves along with the contact")
        }
        _ => rolls,
    })
}

/// Rules on wear. It changes the contact only where the shape is updated.
fn wear(scene: &Scene, effects: &Effects) -> Ruling {
    let Some(Wear { coefficient, update, repeat }) = scene.wear else {
        return Ruling::off("no wear coefficient is given");
    };
    if coefficient == 0.0 {
        return Ruling::off("wear.coefficient = 0");
    }
    if !effects.has(Effect::Friction) {
        return Ruling::off("no tangential tractions, and so no slip");
    }
    let given = match repeat {
        1 => format!("wear.coefficient = {coefficient:e} 1/Pa"),
        cycles => format!("wear.coefficient = {coefficient:e} 1/Pa, {cycles} cycles in each"),
    };
    Ruling::on(match update {
        true => format!("{given}; the shape is updated after each increment"),
        false => format!("{given}, on the undeformed shape"),
    })
}

/// Rules on motions that are governed by forces.
fn load_control(scene: &Scene) -> Ruling {
    let governed = scene
        .loading
        .legs()
        .iter()
        .any(|leg| leg.target.iter().any(|control| matches!(control, Control::Force(_))));
    if governed {
        Ruling::on("a force or a moment is prescribed")
    } else {
        Ruling::off("all motion is prescribed")
    }
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
    pub(crate) fn unknowns(&self, elements: [usize; 2]) -> usize {
        let half = |n: usize, plane: Option<Symmetry>| if plane.is_some() { n / 2 } else { n };
        self.components.len() * half(elements[0], self.mirror.x) * half(elements[1], self.mirror.y)
    }
}

impl Effects {
    /// Returns the stages in which the scene is solved.
    pub(crate) fn stages(&self, scene: &Scene) -> Vec<Stage> {
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
    if axis == 0 && scene.loading.legs().iter().any(|leg| leg.rolling.is_some()) {
        return None; // The leading edge is no image of the trailing one.
    }
    let [x, y, twist] = tangential_loads(scene);
    let (along, across) = if axis == 0 { (x, y) } else { (y, x) };
    match (along || twist, across) {
        (false, _) => Some(Symmetry::Symmetric),
        (true, false) if !effects.has(Effect::Coupling) => Some(Symmetry::Antisymmetric),
        (true, _) => None,
    }
}

/// Rules whether the two sides of Ω in direction `axis` (0: x, 1: y) are no mirror images.
fn asymmetry(
    scene: &Scene,
    effects: &Effects,
    axis: usize,
    elements: [usize; 2],
    surfaces: &Surfaces,
) -> Result<Ruling, SceneError> {
    let name = ["x", "y"][axis];
    if !has_mirror(&scene.punch.shape, axis, surfaces) {
        let reason = format!("the punch's shape is not known to be its own image in {name}");
        return Ok(Ruling::on(reason));
    }
    let domain = domain(scene, surfaces)?;
    let center = [domain.center_x, domain.center_y][axis];
    // A tilt about y lifts one side in x.
    let tilt = Dof::tilt_about(1 - axis);
    let legs = scene.loading.legs();
    Ok(if center != 0.0 {
        Ruling::on(format!("Ω is not centred in {name}"))
    } else if !elements[axis].is_multiple_of(2) {
        Ruling::on(format!("the number of elements along {name} is odd"))
    } else if legs.iter().any(|leg| !is_nothing(leg.target[tilt])) {
        Ruling::on(format!("the punch is tilted or loaded eccentrically in {name}"))
    } else if effects.has(Effect::Friction) && image(scene, effects, axis).is_none() {
        Ruling::on(format!("the tangential load has no image in {name}"))
    } else {
        Ruling::off(format!("shape, load and Ω are their own images in {name}"))
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
            let image = |node: usize| match (axis, node % columns, node / columns) {
                (0, i, j) => j * columns + columns - 1 - i,
                (_, i, j) => (rows - 1 - j) * columns + i,
            };
            let absent = |node: usize| map.absent().get(node);
            (0..heights.len()).all(|node| {
                let image = image(node);
                heights[node] == heights[image] && absent(node) == absent(image)
            })
        }),
        Shape::WheelOnRail(_) => false,
    }
}
