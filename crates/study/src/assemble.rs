//! Assembles the scene and the numerics that a sheet describes.

mod interior;
mod rolling;
mod wheelset;

use contact::model::{
    Base, Domain, Foundation, Friction, Layer, Loading, Material, Mesh, Method, Numerics,
    Projection, Punch, Scene, SceneError, Shape, Side, Step, Wear, WheelRail,
};

use crate::error::Mistake;
use crate::job::Case;
use crate::key::{Key, Table};
use crate::quantity::Quantity;
use crate::sheet::{
    FileContent, NamedMap, NeededFile, ProfileFile, Setting, Sheet, SurfaceNames, TablePlaces,
};
use crate::surface::MapExtent;
use crate::units::{Compact, LengthUnit};
use rolling::{RollingWay, rolling};

/// Returns the keys that a shape needs beyond `shape`; `file` stands for `file` or `surface`.
fn needed(shape: &str) -> &'static [Key] {
    match shape {
        "sphere" | "flat-disk" => &[Key::Radius],
        "ellipsoid" => &[Key::RadiusX, Key::RadiusY],
        "flat-rectangle" => &[Key::WidthX, Key::WidthY],
        "cone" => &[Key::ConeAngle],
        "wheel-on-rail" => &[Key::Wheel, Key::Rail, Key::Side, Key::RollingRadius],
        _ => &[Key::File, Key::WidthX, Key::WidthY],
    }
}

/// The keys of a wheel on a rail that have a default.
const WHEEL_ON_RAIL: &[Key] = &[
    Key::Gauge,
    Key::GaugeDepth,
    Key::FlangeBackDistance,
    Key::FlangeBackToOrigin,
    Key::Lateral,
    Key::Yaw,
    Key::Roll,
];

/// The keys of a wheelset's motion.
const WHEELSET_MOTION: &[Key] =
    &[Key::Speed, Key::AngularSpeed, Key::LateralVelocity, Key::YawRate, Key::RollRate];

/// The keys of a height map that say how its file is read.
pub(crate) const HEIGHT_MAP: &[Key] =
    &[Key::HeightUnit, Key::LateralUnit, Key::Missing, Key::MissingValue];

/// The number of widths over which the heights of a map may range before they are doubted.
const STEEPEST: f64 = 10.0;

/// Returns the keys that a shape may have beyond those that it needs.
fn optional(shape: &str) -> impl Iterator<Item = Key> {
    let is_wheel = shape == "wheel-on-rail";
    let of_wheels = if is_wheel { WHEEL_ON_RAIL } else { &[] };
    let of_motions = if is_wheel { WHEELSET_MOTION } else { &[] };
    let of_maps = if shape == "height-map" { HEIGHT_MAP } else { &[] };
    let further = of_motions.iter().chain(of_maps).copied();
    of_wheels.iter().copied().chain(further)
}

/// Returns the shapes that have a key of the punch, and whether each needs it.
pub(crate) fn shapes_of(key: Key) -> Vec<(&'static str, bool)> {
    let Quantity::Choice(shapes) = Key::Shape.quantity() else { return Vec::new() };
    let of = |shape: &&'static str| {
        let is_needed = needed(shape).contains(&key);
        // A map is a file, or a surface that is stored.
        let is_stored = key == Key::Surface && *shape == "height-map";
        let has_it = is_needed || is_stored || optional(shape).any(|optional| optional == key);
        has_it.then_some((*shape, is_needed))
    };
    shapes.iter().filter_map(of).collect()
}

/// Puts the indefinite article before a word.
pub(crate) fn with_article(word: &str) -> String {
    let article = if word.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    format!("{article} {word}")
}

/// Returns whether a key belongs to the shape of the punch.
fn is_of_shape(key: Key) -> bool {
    let of_punch = key.pattern().strip_prefix("scene.punch.");
    of_punch.is_some_and(|rest| !rest.starts_with("material.")) && key != Key::Shape
}

/// Assembles scenes and numerics from a sheet, and notes what is missing or out of place.
pub(crate) struct Assembler<'a> {
    sheet: &'a Sheet<'a>,
    surfaces: &'a SurfaceNames,
    places: &'a TablePlaces,
    mistakes: Vec<Mistake>,
}

impl<'a> Assembler<'a> {
    pub(crate) fn new(
        sheet: &'a Sheet<'a>,
        surfaces: &'a SurfaceNames,
        places: &'a TablePlaces,
    ) -> Self {
        Assembler { sheet, surfaces, places, mistakes: Vec::new() }
    }

    pub(crate) fn sheet(&self) -> &'a Sheet<'a> {
        self.sheet
    }

    /// Notes a mistake.
    pub(crate) fn note(&mut self, mistake: Mistake) {
        self.mistakes.push(mistake);
    }

    /// Returns the mistakes that were noted.
    pub(crate) fn into_mistakes(self) -> Vec<Mistake> {
        self.mistakes
    }

    pub(crate) fn projection(&self) -> Projection {
        match self.sheet.word(Key::Projection) {
            Some("midpoint") => Projection::Midpoint,
            Some("average") => Projection::Average,
            _ => Projection::default(),
        }
    }

    /// Assembles the case. If something is missing, a mistake is noted, and the case must not be
    /// used.
    pub(crate) fn case(&mut self) -> Case {
        let scene = Scene {
            foundation: self.foundation(),
            punch: Punch { shape: self.shape(), material: self.material() },
            friction: Friction { mu: self.mu() },
            wear: self.wear(),
            domain: self.domain(),
            loading: self.loading(),
            interior: self.interior(),
        };
        let numerics = Numerics {
            mesh: self.mesh(),
            projection: self.projection(),
            epsilon: self.number_or_default(Key::Epsilon),
            ceiling: self.sheet.number(Key::Ceiling),
            method: match self.sheet.word(Key::Method) {
                Some("seidel") => Method::Seidel,
                Some("newton") => Method::Newton,
                Some("auto") => Method::Auto,
                _ => Method::default(),
            },
            tolerance: self.number_or_default(Key::Tolerance),
            max_iterations: self.count_or_default(Key::MaxIterations),
            simulate: match self.sheet.get(Key::Simulate).map(|given| &given.setting) {
                Some(Setting::Effects(effects)) => effects.clone(),
                _ => Vec::new(),
            },
        };
        Case { scene, numerics }
    }

    /// Returns the coefficient of friction. A scene that says nothing of friction has none; a table
    /// that was begun and holds nothing has lost something.
    fn mu(&mut self) -> f64 {
        let is_begun =
            |table| Table::find(table).is_some_and(|table: Table| self.places.has(&table));
        let (has_friction, wears) = (is_begun("friction"), self.wears());
        if wears && !has_friction && self.sheet.get(Key::Mu).is_none() {
            self.miss(Key::Mu, ": a scene that wears needs it");
            return f64::NAN;
        }
        if has_friction { self.number(Key::Mu) } else { self.number_or_default(Key::Mu) }
    }

    pub(crate) fn foundation(&mut self) -> Foundation {
        let layers = (0..self.sheet.length(Key::Layers)).map(|i| {
            let Material { shear_modulus, poisson } =
                self.constants(Key::LayerShearModulus(i), Key::LayerPoisson(i));
            Layer { shear_modulus, poisson, thickness: self.number(Key::LayerThickness(i)) }
        });
        let layers = layers.collect();
        let of_material = [Key::ShearModulus, Key::YoungsModulus, Key::Poisson];
        let Some(rigid) = self.sheet.get(Key::Base) else {
            if of_material.iter().all(|key| self.sheet.get(*key).is_none()) {
                self.miss(Key::Base, "");
                return Foundation { layers, base: Base::Rigid };
            }
            let material = self.constants(Key::ShearModulus, Key::Poisson);
            return Foundation { layers, base: Base::Elastic(material) };
        };
        for key in of_material {
            if let Some(given) = self.sheet.get(key) {
                let message = format!("a rigid base has no `{}`", key.name());
                let mistake = Mistake::new(
                    given.span.clone(),
                    message,
                    "leave this out, or give the base as a table",
                );
                self.mistakes.push(mistake.context(rigid.span.clone(), "the base is rigid"));
            }
        }
        Foundation { layers, base: Base::Rigid }
    }

    fn loading(&mut self) -> Loading {
        let steps: Vec<Step> = (0..self.sheet.length(Key::Steps)).map(|i| self.step(i)).collect();
        if steps.is_empty() && self.sheet.get(Key::Steps).is_none() {
            self.miss(Key::Steps, "");
        }
        Loading {
            steps,
            cycle_from: self.sheet.count(Key::CycleFrom),
            cycles: self.count_or_default(Key::Cycles),
        }
    }

    fn step(&mut self, i: u32) -> Step {
        let RollingWay { rolling, increments } = rolling(self.sheet, i, &mut self.mistakes);
        let number = |key| self.sheet.number(key);
        let step = Step {
            approach: number(Key::Approach(i)),
            normal_force: number(Key::NormalForce(i)),
            shift_x: number(Key::ShiftX(i)),
            force_x: number(Key::ForceX(i)),
            shift_y: number(Key::ShiftY(i)),
            force_y: number(Key::ForceY(i)),
            tilt_x: number(Key::TiltX(i)),
            moment_x: number(Key::MomentX(i)),
            tilt_y: number(Key::TiltY(i)),
            moment_y: number(Key::MomentY(i)),
            twist: number(Key::Twist(i)),
            moment_z: number(Key::MomentZ(i)),
            increments,
            rolling,
        };
        if i == 0 && step.approach.is_none() && step.normal_force.is_none() {
            let mistake = Mistake::new(
                self.places.around(Key::Approach(0)),
                format!("`{}` is missing", Key::Approach(0).short()),
                format!(
                    "the first step needs `approach`, {}, or `normal_force`",
                    Key::Approach(0).quantity().expected()
                ),
            );
            self.mistakes.push(mistake.help(format!("`approach`: {}", Key::Approach(0).meaning())));
        }
        step
    }

    fn miss(&mut self, key: Key, why: &str) {
        let span = match self.sheet.get(Key::Shape) {
            Some(shape) if is_of_shape(key) => shape.span.clone(),
            _ => self.places.around(key),
        };
        let message = format!("`{}` is missing{why}", key.short());
        let (alternative, meaning) = match key.alternative() {
            Some(other) => (
                format!(" or `{}`", other.name()),
                format!("; `{}`: {}", other.name(), other.meaning()),
            ),
            None => (String::new(), String::new()),
        };
        let expected = format!("needs `{}`{alternative}: {}", key.name(), key.expected());
        self.mistakes.push(Mistake::new(span, message, expected).help(format!(
            "`{}`: {}{meaning}",
            key.name(),
            key.meaning()
        )));
    }

    fn number(&mut self, key: Key) -> f64 {
        self.sheet.number(key).unwrap_or_else(|| {
            self.miss(key, "");
            f64::NAN
        })
    }

    /// Returns a number that is given, or the default of its key. If there is neither, a mistake is
    /// noted.
    pub(crate) fn number_or_default(&mut self, key: Key) -> f64 {
        match key.fallback().number() {
            Some(default) => self.sheet.number(key).unwrap_or(default),
            None => self.number(key),
        }
    }

    /// Returns a whole number that is given, or the default of its key in every kind of study. If
    /// there is neither, a mistake is noted.
    fn count_or_default(&mut self, key: Key) -> u32 {
        self.sheet.count(key).or(key.fallback().count()).unwrap_or_else(|| {
            self.miss(key, "");
            0
        })
    }

    pub(crate) fn mesh(&mut self) -> Mesh {
        match self.sheet.get(Key::Mesh).map(|given| &given.setting) {
            Some(Setting::Mesh(mesh)) => *mesh,
            _ => {
                self.miss(Key::Mesh, "");
                Mesh::Across(0)
            }
        }
    }

    pub(crate) fn material(&mut self) -> Option<Material> {
        let keys = [Key::PunchShearModulus, Key::PunchYoungsModulus, Key::PunchPoisson];
        let any = keys.iter().any(|key| self.sheet.get(*key).is_some());
        any.then(|| self.constants(Key::PunchShearModulus, Key::PunchPoisson))
    }

    /// Returns the material whose shear modulus or Young's modulus is given, and its Poisson's
    /// ratio.
    fn constants(&mut self, shear_modulus: Key, poisson: Key) -> Material {
        let ratio = self.number(poisson);
        let of_young =
            shear_modulus.alternative().and_then(|key| Some((key, self.sheet.get(key)?)));
        let modulus = match (self.sheet.get(shear_modulus), of_young) {
            (Some(given), Some((key, of_young))) => {
                // The one that stands later in the file is the one too many.
                let (first, second) = if given.span.start <= of_young.span.start {
                    ((shear_modulus, given), (key, of_young))
                } else {
                    ((key, of_young), (shear_modulus, given))
                };
                let message = format!(
                    "`{}` cannot stand beside `{}`: each follows from the other",
                    second.0.short(),
                    first.0.name()
                );
                let mistake = Mistake::new(second.1.span.clone(), message, "give one of the two");
                self.mistakes.push(mistake.context(first.1.span.clone(), "the other is here"));
                f64::NAN
            }
            (None, Some((key, _))) => {
                return Material::with_youngs_modulus(self.number(key), ratio);
            }
            (Some(_), None) => self.number(shear_modulus),
            (None, None) => {
                self.miss(shear_modulus, "");
                f64::NAN
            }
        };
        Material { shear_modulus: modulus, poisson: ratio }
    }

    /// Returns whether the scene says something of wear.
    fn wears(&self) -> bool {
        let keys = [Key::WearCoefficient, Key::WearUpdate, Key::WearRepeat];
        let is_begun = Table::find("wear").is_some_and(|wear| self.places.has(&wear));
        is_begun || keys.iter().any(|key| self.sheet.get(*key).is_some())
    }

    fn wear(&mut self) -> Option<Wear> {
        self.wears().then(|| Wear {
            coefficient: self.number(Key::WearCoefficient),
            update: self.sheet.flag(Key::WearUpdate).unwrap_or(false),
            repeat: self.count_or_default(Key::WearRepeat),
        })
    }

    fn domain(&mut self) -> Option<Domain> {
        let keys = [Key::DomainWidthX, Key::DomainWidthY, Key::DomainCenterX, Key::DomainCenterY];
        let any = keys.iter().any(|key| self.sheet.get(*key).is_some());
        any.then(|| Domain {
            width_x: self.number(keys[0]),
            width_y: self.number(keys[1]),
            center_x: self.number_or_default(keys[2]),
            center_y: self.number_or_default(keys[3]),
        })
    }

    pub(crate) fn shape(&mut self) -> Shape {
        let none = Shape::Sphere { radius: f64::NAN };
        let Some(shape) = self.sheet.word(Key::Shape) else {
            self.miss(Key::Shape, "");
            return none;
        };
        self.refuse_foreign(shape);
        for key in needed(shape) {
            if matches!(key, Key::WidthX | Key::WidthY) && shape == "height-map" {
                // A file may state its extents.
                continue;
            }
            let given = self
                .sheet
                .get(*key)
                .or_else(|| (*key == Key::File).then(|| self.sheet.get(Key::Surface)).flatten());
            if given.is_none() {
                self.miss(*key, &format!(": {} needs it", with_article(shape)));
            }
        }
        let number = |key| self.sheet.number(key).unwrap_or(f64::NAN);
        match shape {
            "sphere" => Shape::Sphere { radius: number(Key::Radius) },
            "flat-disk" => Shape::FlatDisk { radius: number(Key::Radius) },
            "ellipsoid" => {
                Shape::Ellipsoid { radius_x: number(Key::RadiusX), radius_y: number(Key::RadiusY) }
            }
            "flat-rectangle" => {
                Shape::FlatRectangle { width_x: number(Key::WidthX), width_y: number(Key::WidthY) }
            }
            "cone" => Shape::Cone { angle: number(Key::ConeAngle) },
            "height-map" => self.height_map(),
            "wheel-on-rail" => Shape::WheelOnRail(self.wheel_on_rail()),
            // The reader lets only the words of `Key::Shape` through.
            _ => none,
        }
    }

    fn wheel_on_rail(&mut self) -> WheelRail {
        let motion = self.motion();
        let profile = |key| {
            let file = self.sheet.word(key).unwrap_or_default().to_owned();
            let named = ProfileFile { file, is_wheel: key == Key::Wheel };
            self.surfaces.profiles.get(&named).cloned().unwrap_or_default()
        };
        let (wheel, rail) = (profile(Key::Wheel), profile(Key::Rail));
        let side =
            if self.sheet.word(Key::Side) == Some("left") { Side::Left } else { Side::Right };
        // The shape has noted before if it is missing.
        let rolling_radius = self.sheet.number(Key::RollingRadius).unwrap_or(f64::NAN);
        let mut number = |key| self.number_or_default(key);
        WheelRail {
            wheel,
            rail,
            side,
            rolling_radius,
            gauge: number(Key::Gauge),
            gauge_depth: number(Key::GaugeDepth),
            flange_back_distance: number(Key::FlangeBackDistance),
            flange_back_to_origin: number(Key::FlangeBackToOrigin),
            lateral: number(Key::Lateral),
            yaw: number(Key::Yaw),
            roll: number(Key::Roll),
            motion,
        }
    }

    fn height_map(&mut self) -> Shape {
        let needed = self.sheet.needed_files().into_iter().next();
        let none = NamedMap { name: String::new(), extents: [None; 2], relief: 0.0 };
        let map = match needed.map(|NeededFile { content, .. }| content) {
            Some(FileContent::Map(file)) => self.surfaces.maps.get(&file).cloned().unwrap_or(none),
            Some(FileContent::StoredMap(name)) => NamedMap { name, ..none },
            _ => none,
        };
        let [width_x, width_y] = self.widths(&map.extents);
        let width = width_x.max(width_y);
        if map.relief > STEEPEST * width
            && let Some(file) = self.sheet.get(Key::File)
        {
            let message = format!(
                "the heights in this file range over {} m, on a map {} m wide",
                Compact(map.relief),
                Compact(width)
            );
            let unit = self.sheet.get(Key::HeightUnit);
            let mistake = Mistake::new(
                unit.unwrap_or(file).span.clone(),
                message,
                "check `unit`, the widths, and whether numbers mark missing pixels",
            );
            self.mistakes.push(mistake.help(
                "`missing_value` names a number that marks missing pixels; missing = \"none\" says \
                 that all numbers are heights",
            ));
        }
        Shape::HeightMap { surface: map.name, width_x, width_y }
    }

    /// Returns the extents of a height map \[m\]: those that are given, which must agree with those
    /// that the file states, else these.
    fn widths(&mut self, extents: &[Option<MapExtent>; 2]) -> [f64; 2] {
        let keys = [Key::WidthX, Key::WidthY];
        let given = keys.map(|key| self.sheet.number(key));
        // Coordinates whose unit nobody names may be in any, which the widths tell.
        let ratio = LengthUnit::ratios().find(|ratio| {
            let agrees = |axis: usize| match (given[axis], extents[axis]) {
                (Some(width), Some(extent)) => extent.agrees(width / ratio),
                _ => true,
            };
            (*ratio == 1.0 || extents.iter().flatten().all(|extent| extent.is_unit_free))
                && agrees(0)
                && agrees(1)
        });
        let mut widths = [f64::NAN; 2];
        for (axis, key) in keys.into_iter().enumerate() {
            widths[axis] = match (given[axis], extents[axis]) {
                (Some(width), Some(extent)) if ratio.is_none() && !extent.agrees(width) => {
                    self.refuse_width(key, width, &extent);
                    width
                }
                (Some(width), _) => width,
                (None, Some(extent)) => extent.width * ratio.unwrap_or(1.0),
                (None, None) => {
                    self.miss(key, ": a height-map needs it");
                    f64::NAN
                }
            };
        }
        widths
    }

    fn refuse_width(&mut self, key: Key, width: f64, extent: &MapExtent) {
        let Some(given) = self.sheet.get(key) else { return };
        let place = match extent.line {
            Some(line) => format!("line {line} of the file says"),
            None => "the points of the file span, with half a step on either side,".to_owned(),
        };
        let mistake = Mistake::new(
            given.span.clone(),
            format!(
                "`{}` cannot be {}: {place} {} m",
                key.short(),
                Compact(width),
                Compact(extent.width)
            ),
            "must agree with the file, or be left out",
        );
        self.mistakes.push(match extent.is_unit_free {
            true => {
                mistake.help("if x and y are in another unit than the heights, say `lateral_unit`")
            }
            false => mistake,
        });
    }

    /// Notes every key that is given for the punch although its shape does not have it.
    fn refuse_foreign(&mut self, shape: &str) {
        let is_map = shape == "height-map";
        let has = |key: Key| {
            needed(shape).contains(&key) || optional(shape).any(|optional| optional == key)
        };
        let is_foreign = |key: Key| !has(key) || is_map && HEIGHT_MAP.contains(&key);
        for key in Key::ALL {
            // Few keys are those of a shape, and to look for one takes longer than to see that.
            let given = is_of_shape(*key).then(|| self.sheet.get(*key)).flatten();
            let Some(given) = given.filter(|_| is_foreign(*key)) else { continue };
            let span = given.span.clone();
            let mistake = match key {
                Key::Surface if is_map => match self.sheet.get(Key::File) {
                    Some(file) => Mistake::new(
                        span,
                        "a height map is a `file` or a stored `surface`, not both",
                        "leave this out",
                    )
                    .context(file.span.clone(), "given here"),
                    None => continue,
                },
                key if is_map && HEIGHT_MAP.contains(key) => match self.sheet.get(Key::Surface) {
                    Some(_) if self.sheet.get(Key::File).is_none() => Mistake::new(
                        span,
                        format!(
                            "a stored surface has no `{}`: its heights are in metres, and none is \
                             missing",
                            key.name()
                        ),
                        "leave this out",
                    ),
                    _ => continue,
                },
                _ => {
                    let names = needed(shape)
                        .iter()
                        .copied()
                        .chain(optional(shape))
                        .map(|key| format!("`{}`", key.name()));
                    let names = names.collect::<Vec<_>>().join(", ");
                    let mistake = Mistake::new(
                        span,
                        format!("{} has no `{}`", with_article(shape), key.name()),
                        format!("{} has {names}", with_article(shape)),
                    );
                    match self.sheet.get(Key::Shape) {
                        Some(place) if place.span != given.span => {
                            mistake.context(place.span.clone(), "the shape is given here")
                        }
                        _ => mistake,
                    }
                }
            };
            self.mistakes.push(mistake);
        }
    }
}

/// Turns an error that the scene itself found into a mistake at the place that gave the value.
pub(crate) fn locate(error: &SceneError, sheet: &Sheet<'_>, places: &TablePlaces) -> Mistake {
    // A shear modulus that follows from Young's modulus is not in the file.
    let named = Key::find(&error.key);
    let of_young = named.and_then(Key::alternative).filter(|key| {
        sheet.get(*key).is_some() && named.is_none_or(|key| sheet.get(key).is_none())
    });
    // One depth may be given by a key of its own.
    let as_one = named == Some(Key::InteriorDepths)
        && sheet.get(Key::InteriorDepths).is_none()
        && sheet.get(Key::InteriorDepth).is_some();
    let of_young = of_young.or(as_one.then_some(Key::InteriorDepth));
    let key = of_young.or(named);
    let path = of_young.map_or_else(|| error.key.clone(), |key| key.short().into_owned());
    let message = |value: &str| match key.map(Key::quantity) {
        // The message about a list says what is wrong with it; it does not repeat the list.
        Some(Quantity::List(_)) => format!("`{path}` has {value}"),
        Some(Quantity::Lengths | Quantity::Places) => format!("`{path}` cannot have {value}"),
        Some(Quantity::Effects) => format!("`{path}` cannot name `{value}`"),
        _ => format!("`{path}` cannot be {value}"),
    };
    match key.and_then(|key| Some((key, sheet.get(key)?))) {
        Some((key, given)) => {
            let value = match key.quantity() {
                Quantity::List(_) | Quantity::Effects | Quantity::Lengths | Quantity::Places => {
                    error.value.clone()
                }
                _ => given.setting.to_string(),
            };
            // If there are too many increments, the step with most of them is at fault.
            let steps = 0..if key == Key::Steps { sheet.length(key) } else { 0 };
            let most = steps.filter_map(|i| Some((sheet.count(Key::Increments(i))?, i))).max();
            let given = most.and_then(|(_, i)| sheet.get(Key::Increments(i))).unwrap_or(given);
            let mistake = Mistake::new(given.span.clone(), message(&value), error.expected.clone());
            match given.nth {
                Some(nth) => mistake.help(format!("it is value {nth} of this axis")),
                None => mistake,
            }
        }
        None => {
            let inside = Key::ALL
                .iter()
                .find(|key| key.short().starts_with(&error.key))
                .or(Key::ALL.first());
            let span = key.or(inside.copied()).map_or(0..0, |key| places.around(key));
            Mistake::new(span, message(&error.value), error.expected.clone())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A key that has no default of its own is missing where it is left out, whatever asks for its
    /// default: nothing is computed with a value that nobody chose.
    #[test]
    fn a_default_that_is_none_is_missing() {
        let (sheet, surfaces, places) =
            (Sheet::default(), SurfaceNames::default(), TablePlaces::default());
        let mut assembler = Assembler::new(&sheet, &surfaces, &places);
        for (key, default) in [(Key::Mu, 0.0), (Key::DomainCenterX, 0.0), (Key::Tolerance, 1e-8)] {
            assert_eq!(assembler.number_or_default(key), default);
        }
        assert_eq!(assembler.count_or_default(Key::MaxIterations), 20_000);
        assert!(assembler.mistakes.is_empty());
        assert!(assembler.number_or_default(Key::Radius).is_nan());
        assert!(assembler.number_or_default(Key::AngularSpeed).is_nan());
        assert_eq!(assembler.count_or_default(Key::Starts), 0);
        let messages: Vec<&str> =
            assembler.mistakes.iter().map(|mistake| mistake.message.as_str()).collect();
        assert_eq!(
            messages,
            [
                "`punch.radius` is missing",
                "`punch.angular_speed` is missing",
                "`starts` is missing"
            ]
        );
    }
}
