//! The one list of the keys of a scene and its numerics: the place of each in a study file, what it
//! measures and the column that it fills. The reader, the axes, the columns and the messages all go
//! by this list.
//!
//! Layers and load steps are lists, and a key of one of them carries its index, counted from 0:
//! `foundation.layers[1].thickness` fills the column `layer1_thickness`, and
//! `loading.steps[2].shift_x` the column `step2_shift_x`. Most studies have one step, and its keys
//! do without the index: the motions, the normal force and the rolling of `steps[0]` fill
//! `approach`, `normal_force`, `shift_x`, `creepage_x` … Its tangential forces and moments do not,
//! because `force_x` is a result.

use std::borrow::Cow;

use contact::model::{Foundation, Loading};

use crate::quantity::Quantity;
use crate::units::Dimension;

macro_rules! keys {
    ($(
        $name:ident $(($index:ident: $type:ty))?, $path:literal, $column:literal,
        $quantity:expr, $meaning:literal;
    )*) => {
        /// A key of a scene or of its numerics; the key of a layer or a step carries the index of
        /// it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Key {
            $(#[doc = $meaning] $name $(($type))?,)*
        }

        impl Key {
            /// Every key, in the order of the scene's and the numerics' fields; keys of lists have
            /// index 0.
            pub(crate) const ALL: &'static [Key] = &[$(Key::$name $((<$type>::MIN))?),*];

            /// Returns the key of another layer or step.
            pub(crate) fn with_index(self, index: u32) -> Key {
                match self {
                    $(Key::$name { .. } => Key::$name $(({
                        let $index: $type = index;
                        $index
                    }))?,)*
                }
            }

            /// Returns the index of its layer or step.
            pub(crate) fn index(self) -> Option<u32> {
                match self { $(Key::$name $(($index))? => None $(.or(Some($index)))?,)* }
            }

            /// Returns its path in a study file, with `i` for an index.
            pub(crate) fn pattern(self) -> &'static str {
                match self { $(Key::$name { .. } => $path,)* }
            }

            fn column_pattern(self) -> &'static str {
                match self { $(Key::$name { .. } => $column,)* }
            }

            /// Returns the values that may stand behind it.
            pub(crate) fn quantity(self) -> Quantity {
                match self { $(Key::$name { .. } => $quantity,)* }
            }

            /// Returns its meaning in words.
            pub(crate) fn meaning(self) -> &'static str {
                match self { $(Key::$name { .. } => $meaning,)* }
            }
        }
    };
}

use Dimension::{
    Angle, AnglePerLength, AngularVelocity, Force, Length, Moment, PerPressure, Pressure, Pure,
    Velocity,
};
use Quantity::{Choice, Count, Effects, Flag, LengthUnit, Lengths, List, Number, Places, Text};

/// Examples of a layer and a load step.
const LAYER: &str = "{ youngs_modulus = \"210 GPa\", poisson = 0.3, thickness = \"0.5 mm\" }";
const STEP: &str = "{ approach = \"1 um\" }";

keys! {
    Layers, "scene.foundation.layers", "layers", List(LAYER), "number of layers of the foundation";
    LayerShearModulus(i: u32), "scene.foundation.layers[i].shear_modulus", "layer[i]_shear_modulus",
        Number(Pressure), "shear modulus G of a layer";
    LayerYoungsModulus(i: u32), "scene.foundation.layers[i].youngs_modulus",
        "layer[i]_youngs_modulus", Number(Pressure), "Young's modulus E of a layer";
    LayerPoisson(i: u32), "scene.foundation.layers[i].poisson", "layer[i]_poisson",
        Number(Pure), "Poisson's ratio ν of a layer";
    LayerThickness(i: u32), "scene.foundation.layers[i].thickness", "layer[i]_thickness",
        Number(Length), "thickness of a layer";
    Base, "scene.foundation.base", "base",
        Choice(&["rigid"]), "what the layers rest on, if it is not elastic";
    ShearModulus, "scene.foundation.base.shear_modulus", "shear_modulus",
        Number(Pressure), "shear modulus G of the foundation's base";
    YoungsModulus, "scene.foundation.base.youngs_modulus", "youngs_modulus",
        Number(Pressure), "Young's modulus E of the foundation's base";
    Poisson, "scene.foundation.base.poisson", "poisson",
        Number(Pure), "Poisson's ratio ν of the foundation's base";
    Shape, "scene.punch.shape", "shape",
        Choice(&[
            "sphere", "ellipsoid", "flat-rectangle", "flat-disk", "cone", "height-map",
            "wheel-on-rail",
        ]), "shape of the punch";
    Radius, "scene.punch.radius", "radius", Number(Length), "radius of a sphere or a flat disk";
    RadiusX, "scene.punch.radius_x", "radius_x",
        Number(Length), "radius of curvature of an ellipsoid in the x–z plane";
    RadiusY, "scene.punch.radius_y", "radius_y",
        Number(Length), "radius of curvature of an ellipsoid in the y–z plane";
    WidthX, "scene.punch.width_x", "width_x", Number(Length), "extent of the punch along x";
    WidthY, "scene.punch.width_y", "width_y", Number(Length), "extent of the punch along y";
    ConeAngle, "scene.punch.angle", "angle",
        Number(Angle), "angle between a cone and the plane of contact";
    File, "scene.punch.file", "file",
        Text, "file with the heights of a height map: NPY, or a matrix or a list of x, y and z as text";
    HeightUnit, "scene.punch.unit", "unit",
        LengthUnit, "unit of the heights in the file, that of its header or m unless given";
    LateralUnit, "scene.punch.lateral_unit", "lateral_unit",
        LengthUnit, "unit of x and y in the file, that of its header or of the heights unless given";
    Missing, "scene.punch.missing", "missing",
        Choice(&["fill", "exclude", "none"]), "what becomes of missing pixels: they are filled from \
        their neighbours, they are no part of the sole, or there are none";
    MissingValue, "scene.punch.missing_value", "missing_value",
        Number(Pure), "height in the file, in its unit, that marks a missing pixel";
    Surface, "scene.punch.surface", "surface",
        Text, "name of a stored surface, the hash of its heights";
    Wheel, "scene.punch.wheel", "wheel",
        Text, "file with the wheel's profile, of SIMPACK, of MiniProf or a list; in a stored job, its hash";
    Rail, "scene.punch.rail", "rail",
        Text, "file with the rail's profile, of SIMPACK, of MiniProf or a list; in a stored job, its hash";
    Side, "scene.punch.side", "side", Choice(&["left", "right"]), "which wheel of the wheelset";
    RollingRadius, "scene.punch.rolling_radius", "rolling_radius",
        Number(Length), "radius of the wheel at its profile's z = 0";
    Gauge, "scene.punch.gauge", "gauge", Number(Length), "distance between the rails' gauge faces";
    GaugeDepth, "scene.punch.gauge_depth", "gauge_depth",
        Number(Length), "depth below the rails' tops at which the gauge is measured";
    FlangeBackDistance, "scene.punch.flange_back_distance", "flange_back_distance",
        Number(Length), "distance between the backs of the flanges";
    FlangeBackToOrigin, "scene.punch.flange_back_to_origin", "flange_back_to_origin",
        Number(Length), "from the back of a flange to its profile's y = 0";
    Lateral, "scene.punch.lateral", "lateral",
        Number(Length), "lateral displacement of the wheelset, positive to the right";
    Yaw, "scene.punch.yaw", "yaw",
        Number(Angle), "yaw of the wheelset about z, positive turns x towards y";
    Roll, "scene.punch.roll", "roll",
        Number(Angle), "roll of the wheelset about x, positive lowers the right wheel";
    Speed, "scene.punch.speed", "speed",
        Number(Velocity), "velocity of the wheelset along the track; steps that roll then take \
        their creepages from its motion";
    AngularSpeed, "scene.punch.angular_speed", "angular_speed",
        Number(AngularVelocity), "angular speed of the wheelset about its axle, speed over \
        rolling_radius unless given";
    LateralVelocity, "scene.punch.lateral_velocity", "lateral_velocity",
        Number(Velocity), "velocity of the wheelset along y, positive to the right";
    YawRate, "scene.punch.yaw_rate", "yaw_rate",
        Number(AngularVelocity), "rate of the wheelset's yaw, against rails that rest";
    RollRate, "scene.punch.roll_rate", "roll_rate",
        Number(AngularVelocity), "rate of the wheelset's roll";
    PunchShearModulus, "scene.punch.material.shear_modulus", "punch_shear_modulus",
        Number(Pressure), "shear modulus G of an elastic punch";
    PunchYoungsModulus, "scene.punch.material.youngs_modulus", "punch_youngs_modulus",
        Number(Pressure), "Young's modulus E of an elastic punch";
    PunchPoisson, "scene.punch.material.poisson", "punch_poisson",
        Number(Pure), "Poisson's ratio ν of an elastic punch";
    Mu, "scene.friction.mu", "mu", Number(Pure), "coefficient of friction μ";
    WearCoefficient, "scene.wear.coefficient", "wear_coefficient", Number(PerPressure),
        "wear coefficient k of both surfaces together: depth over pressure and sliding distance";
    WearUpdate, "scene.wear.update", "wear_update", Flag,
        "whether each increment meets the shape that the wear before it has left";
    WearRepeat, "scene.wear.repeat", "wear_repeat", Count,
        "cycles that each cycle of the path stands for: it wears so many times as much";
    DomainWidthX, "scene.domain.width_x", "domain_width_x", Number(Length), "extent of Ω along x";
    DomainWidthY, "scene.domain.width_y", "domain_width_y", Number(Length), "extent of Ω along y";
    DomainCenterX, "scene.domain.center_x", "domain_center_x",
        Number(Length), "x of the centre of Ω";
    DomainCenterY, "scene.domain.center_y", "domain_center_y",
        Number(Length), "y of the centre of Ω";
    Steps, "scene.loading.steps", "steps", List(STEP), "number of load steps";
    Approach(i: u32), "scene.loading.steps[i].approach", "step[i]_approach",
        Number(Length), "approach δ of the punch, positive into the foundation";
    NormalForce(i: u32), "scene.loading.steps[i].normal_force", "step[i]_normal_force",
        Number(Force), "normal force that is prescribed instead of the approach";
    ShiftX(i: u32), "scene.loading.steps[i].shift_x", "step[i]_shift_x",
        Number(Length), "shift of the punch along x";
    ForceX(i: u32), "scene.loading.steps[i].force_x", "step[i]_force_x",
        Number(Force), "tangential force along x that is prescribed instead of the shift";
    ShiftY(i: u32), "scene.loading.steps[i].shift_y", "step[i]_shift_y",
        Number(Length), "shift of the punch along y";
    ForceY(i: u32), "scene.loading.steps[i].force_y", "step[i]_force_y",
        Number(Force), "tangential force along y that is prescribed instead of the shift";
    TiltX(i: u32), "scene.loading.steps[i].tilt_x", "step[i]_tilt_x",
        Number(Angle), "tilt of the punch about the x axis";
    MomentX(i: u32), "scene.loading.steps[i].moment_x", "step[i]_moment_x",
        Number(Moment), "moment about x that is prescribed instead of the tilt";
    TiltY(i: u32), "scene.loading.steps[i].tilt_y", "step[i]_tilt_y",
        Number(Angle), "tilt of the punch about the y axis";
    MomentY(i: u32), "scene.loading.steps[i].moment_y", "step[i]_moment_y",
        Number(Moment), "moment about y that is prescribed instead of the tilt";
    Twist(i: u32), "scene.loading.steps[i].twist", "step[i]_twist",
        Number(Angle), "twist of the punch about the z axis";
    MomentZ(i: u32), "scene.loading.steps[i].moment_z", "step[i]_moment_z",
        Number(Moment), "moment about z that is prescribed instead of the twist";
    Increments(i: u32), "scene.loading.steps[i].increments", "step[i]_increments",
        Count, "equal parts in which the step is taken";
    CreepageX(i: u32), "scene.loading.steps[i].creepage_x", "step[i]_creepage_x",
        Number(Pure), "longitudinal creepage ξ of a step that rolls, of the foundation against the punch";
    CreepageY(i: u32), "scene.loading.steps[i].creepage_y", "step[i]_creepage_y",
        Number(Pure), "lateral creepage η of a step that rolls, of the foundation against the punch";
    Spin(i: u32), "scene.loading.steps[i].spin", "step[i]_spin",
        Number(AnglePerLength), "spin φ of a step that rolls, of the foundation against the punch";
    SpinCenter(i: u32), "scene.loading.steps[i].spin_center", "step[i]_spin_center",
        Number(Length), "x about which the spin turns";
    Direction(i: u32), "scene.loading.steps[i].direction", "step[i]_direction",
        Choice(&["forward", "backward"]), "way that a contact rolls, towards +x or −x";
    Distance(i: u32), "scene.loading.steps[i].distance", "step[i]_distance",
        Number(Length), "distance that a step rolls from the state before it";
    Dq(i: u32), "scene.loading.steps[i].dq", "step[i]_dq",
        Number(Length), "distance that the contact rolls in an increment; beside a distance the longest one, while `increment_distance` is what an increment has rolled";
    Steady(i: u32), "scene.loading.steps[i].steady", "step[i]_steady",
        Flag, "whether a step is the steady state of rolling";
    CycleFrom, "scene.loading.cycle_from", "cycle_from",
        Count, "index of the step with which a cycle begins";
    Cycles, "scene.loading.cycles", "cycles", Count, "how often the cycle is run through";
    InteriorMaximum, "interior.maximum", "interior_maximum",
        Flag, "whether the largest von Mises and Tresca stresses below the surface are sought";
    InteriorDepth, "interior.depth", "interior_depth",
        Number(Length), "depth of a plane below the surface on which stresses are computed";
    InteriorDepths, "interior.depths", "interior_depths",
        Lengths, "depths of planes below the surface on which stresses are computed";
    InteriorPoints, "interior.points", "interior_points",
        Places, "points below the surface at which the stress is computed";
    Mesh, "numerics.mesh", "mesh", Quantity::Mesh, "elements across Ω";
    Projection, "numerics.projection", "projection",
        Choice(&["average", "midpoint"]), "how the continuous operator becomes a matrix";
    Epsilon, "numerics.epsilon", "epsilon", Number(Pure), "regularisation ε of equation (3)";
    Ceiling, "numerics.ceiling", "ceiling",
        Number(Pressure), "a-priori ceiling u on the pressure in equation (3)";
    Method, "numerics.method", "method", Choice(&["auto", "newton", "seidel"]), "solver";
    Tolerance, "numerics.tolerance", "tolerance",
        Number(Pure), "largest relative residual that counts as solved";
    MaxIterations, "numerics.max_iterations", "max_iterations",
        Count, "iterations after which the solver gives up";
    Simulate, "numerics.simulate", "simulate",
        Effects, "effects that are simulated although the scene does not call for them";
    Starts, "search.starts", "starts", Count, "random starts of a search";
    Seed, "search.seed", "seed", Count, "seed of the random starts";
}

impl Key {
    /// Returns every key of a scene, in the order of the fields. `length` gives the lengths of its
    /// lists, [`Key::Layers`] and [`Key::Steps`].
    pub fn all(length: impl Fn(Key) -> u32) -> Vec<Key> {
        Key::of_entries(|list| 0..length(list))
    }

    /// Returns every key of a scene of whose lists only the entries with these indices count.
    pub(crate) fn of_entries<Indices: IntoIterator<Item = u32>>(
        indices: impl Fn(Key) -> Indices,
    ) -> Vec<Key> {
        let mut keys = Vec::new();
        for run in Key::ALL.chunk_by(|a, b| a.list() == b.list()) {
            match run.first().and_then(|key| key.list()) {
                None => keys.extend_from_slice(run),
                Some(list) => keys.extend(
                    indices(list)
                        .into_iter()
                        .flat_map(|index| run.iter().map(move |key| key.with_index(index))),
                ),
            }
        }
        keys
    }

    /// Returns the key that may be given in its place: a material has a shear modulus or Young's
    /// modulus.
    pub(crate) fn alternative(self) -> Option<Key> {
        Some(match self {
            Key::ShearModulus => Key::YoungsModulus,
            Key::YoungsModulus => Key::ShearModulus,
            Key::LayerShearModulus(index) => Key::LayerYoungsModulus(index),
            Key::LayerYoungsModulus(index) => Key::LayerShearModulus(index),
            Key::PunchShearModulus => Key::PunchYoungsModulus,
            Key::PunchYoungsModulus => Key::PunchShearModulus,
            _ => return None,
        })
    }

    /// Returns whether a job has its value only by way of another key: a job keeps shear moduli.
    pub(crate) fn is_derived(self) -> bool {
        matches!(self, Key::YoungsModulus | Key::LayerYoungsModulus(_) | Key::PunchYoungsModulus)
    }

    /// Returns whether it says how a step rolls.
    pub(crate) fn is_of_rolling(self) -> bool {
        matches!(
            self,
            Key::CreepageX(_)
                | Key::CreepageY(_)
                | Key::Spin(_)
                | Key::SpinCenter(_)
                | Key::Direction(_)
                | Key::Distance(_)
                | Key::Dq(_)
                | Key::Steady(_)
        )
    }

    /// Returns whether it asks for something of the wear.
    pub(crate) fn is_of_wear(self) -> bool {
        self.pattern().starts_with("scene.wear.")
    }

    /// Returns whether it asks for stresses below the surface.
    pub(crate) fn is_of_interior(self) -> bool {
        self.pattern().starts_with("interior.")
    }

    /// Returns the largest number of entries of the list that it is.
    pub(crate) fn longest(self) -> u32 {
        match self {
            Key::Layers => Foundation::MAX_LAYERS as u32,
            // Each step has an increment at least.
            _ => Loading::MAX_INCREMENTS,
        }
    }

    /// Returns the list in which it stands.
    pub(crate) fn list(self) -> Option<Key> {
        match self.pattern().split_once("[i]")?.0 {
            "scene.foundation.layers" => Some(Key::Layers),
            _ => Some(Key::Steps),
        }
    }

    /// Returns its path in a study file, from the top: `scene.friction.mu`.
    pub fn path(self) -> Cow<'static, str> {
        indexed(self.pattern(), self.index())
    }

    /// Returns the path without `scene.`, `numerics.` or `search.`, as axes and messages write it.
    pub fn short(self) -> Cow<'static, str> {
        indexed(short(self.pattern()), self.index())
    }

    /// Returns the last segment of the path.
    pub(crate) fn name(self) -> &'static str {
        self.pattern().rsplit('.').next().unwrap_or_default()
    }

    /// Returns the column that it fills, an identifier that is unique among all columns.
    pub fn column(self) -> Cow<'static, str> {
        match self {
            Key::Approach(0)
            | Key::NormalForce(0)
            | Key::ShiftX(0)
            | Key::ShiftY(0)
            | Key::TiltX(0)
            | Key::TiltY(0)
            | Key::Twist(0)
            | Key::CreepageX(0)
            | Key::CreepageY(0)
            | Key::Spin(0)
            | Key::SpinCenter(0)
            | Key::Direction(0)
            | Key::Distance(0)
            | Key::Dq(0)
            | Key::Steady(0) => Cow::Borrowed(self.name()),
            _ => match self.index() {
                Some(index) => Cow::Owned(self.column_pattern().replace("[i]", &index.to_string())),
                None => Cow::Borrowed(self.column_pattern()),
            },
        }
    }

    /// Describes the values that may stand behind it, for messages.
    pub(crate) fn expected(self) -> String {
        match Table::find(self.pattern()) {
            Some(table) => table.expected(),
            None => self.quantity().expected(),
        }
    }

    /// Returns the dimension of its values.
    pub(crate) fn dimension(self) -> Dimension {
        match self.quantity() {
            Quantity::Number(dimension) => dimension,
            _ => Dimension::Pure,
        }
    }

    /// Returns the key with this path, short or from the top.
    pub(crate) fn find(path: &str) -> Option<Key> {
        let (pattern, index) = pattern_of(path)?;
        let key = Key::ALL
            .iter()
            .find(|key| key.pattern() == pattern || short(key.pattern()) == pattern)?;
        Some(key.with_index(index))
    }

    /// Returns the key that fills this column.
    pub(crate) fn of_column(column: &str) -> Option<Key> {
        let index = column
            .trim_start_matches(|c: char| c.is_ascii_lowercase())
            .split('_')
            .next()
            .and_then(|digits| digits.parse().ok());
        let candidates = Key::ALL.iter().flat_map(|key| [*key, key.with_index(index.unwrap_or(0))]);
        candidates.into_iter().find(|key| key.column() == column)
    }

    /// Returns whether the table holds the key, or is what the key says in a word or a number.
    pub(crate) fn is_under(self, table: &Table) -> bool {
        is_inside(self.pattern(), table.pattern)
            && (!table.has_index() || self.index() == Some(table.index))
    }
}

/// A table of a study file whose keys are [`Key`]s, or a list of such tables; an axis may replace
/// it as a whole. Lists and the base of a foundation are keys as well: what these say fits into a
/// number or a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Table {
    pub(crate) pattern: &'static str,
    column: &'static str,
    index: u32,
}

const fn table(pattern: &'static str, column: &'static str) -> Table {
    Table { pattern, column, index: 0 }
}

impl Table {
    /// Every such table, the outer ones first; tables of lists have index 0.
    pub(crate) const ALL: &'static [Table] = &[
        table("scene", "scene"),
        table("scene.foundation", "foundation"),
        table("scene.foundation.layers", "layers"),
        table("scene.foundation.layers[i]", "layer[i]"),
        table("scene.foundation.base", "base"),
        table("scene.punch", "punch"),
        table("scene.punch.material", "punch_material"),
        table("scene.friction", "friction"),
        table("scene.wear", "wear"),
        table("scene.domain", "domain"),
        table("scene.loading", "loading"),
        table("scene.loading.steps", "steps"),
        table("scene.loading.steps[i]", "step[i]"),
        table("interior", "interior"),
        table("numerics", "numerics"),
        table("search", "search"),
    ];

    fn has_index(&self) -> bool {
        self.pattern.ends_with(']')
    }

    /// Returns its index if it stands in a list.
    pub(crate) fn index(&self) -> Option<u32> {
        self.has_index().then_some(self.index)
    }

    /// Returns the list that it is or in which it stands: [`Key::Layers`] or [`Key::Steps`].
    pub(crate) fn list(&self) -> Option<Key> {
        [Key::Layers, Key::Steps]
            .into_iter()
            .find(|list| self.pattern.split('[').next() == Some(list.pattern()))
    }

    /// Returns whether it is a list of tables.
    pub(crate) fn is_list(&self) -> bool {
        self.list().is_some() && !self.has_index()
    }

    /// Returns the table with an index in a list, [`Key::Layers`] or [`Key::Steps`].
    pub(crate) fn entry(list: Key, index: u32) -> Option<Table> {
        let entry =
            Table::ALL.iter().find(|table| table.has_index() && table.list() == Some(list))?;
        Some(Table { index, ..*entry })
    }

    /// Returns its path, from the top.
    pub(crate) fn path(&self) -> Cow<'static, str> {
        indexed(self.pattern, self.index())
    }

    /// Returns the path without `scene.`, as axes and messages write it.
    pub(crate) fn short(&self) -> Cow<'static, str> {
        indexed(short(self.pattern), self.index())
    }

    /// Returns the last segment of the path.
    pub(crate) fn name(&self) -> &'static str {
        self.pattern.rsplit('.').next().unwrap_or_default()
    }

    /// Returns the column that an axis over it fills.
    pub(crate) fn column(&self) -> Cow<'static, str> {
        match self.has_index() {
            true => Cow::Owned(self.column.replace("[i]", &self.index.to_string())),
            false => Cow::Borrowed(self.column),
        }
    }

    /// Returns the table with this path, short or from the top.
    pub(crate) fn find(path: &str) -> Option<Table> {
        let (pattern, index) = pattern_of(path)?;
        let table = Table::ALL
            .iter()
            .find(|table| table.pattern == pattern || short(table.pattern) == pattern)?;
        Some(Table { index, ..*table })
    }

    /// Returns the table whose labels fill this column.
    pub(crate) fn of_column(column: &str) -> Option<Table> {
        let digits = column.trim_start_matches(|c: char| !c.is_ascii_digit());
        let index = digits.split('_').next().and_then(|digits| digits.parse().ok()).unwrap_or(0);
        let mut tables = Table::ALL.iter().map(|table| Table { index, ..*table });
        tables.find(|table| table.column() == column)
    }

    /// Returns whether the other table holds it or is the same.
    pub(crate) fn is_under(&self, other: &Table) -> bool {
        is_inside(self.pattern, other.pattern)
            && (!other.has_index() || self.index() == Some(other.index))
    }

    /// Returns the names that may stand directly in it.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let mut names = Vec::new();
        for key in Key::ALL {
            let inner =
                key.pattern().strip_prefix(self.pattern).and_then(|rest| rest.strip_prefix('.'));
            let name = inner.and_then(|inner| inner.split(['.', '[']).next());
            names.extend(name.filter(|name| !names.contains(name)));
        }
        names
    }

    /// Describes what may stand in its place, for messages.
    pub(crate) fn expected(&self) -> String {
        let key = Key::find(self.pattern).map(|key| key.quantity());
        let names = self.names().join("`, `");
        match key {
            Some(quantity @ List(_)) => quantity.expected(),
            Some(quantity) => format!("{} or a table with the keys `{names}`", quantity.expected()),
            None => format!("a table with the keys `{names}`"),
        }
    }
}

/// Returns whether the path `inner` leads to something inside `outer`.
fn is_inside(inner: &str, outer: &str) -> bool {
    inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

pub(crate) fn short(path: &str) -> &str {
    ["scene.", "numerics.", "search."]
        .iter()
        .find_map(|table| path.strip_prefix(table))
        .unwrap_or(path)
}

fn indexed(pattern: &'static str, index: Option<u32>) -> Cow<'static, str> {
    match index {
        Some(index) => Cow::Owned(pattern.replace("[i]", &format!("[{index}]"))),
        None => Cow::Borrowed(pattern),
    }
}

/// Replaces the index in a path by `[i]`, and returns the index as well; `None` if the index is not
/// written as a number.
pub(crate) fn pattern_of(path: &str) -> Option<(Cow<'_, str>, u32)> {
    let Some((list, rest)) = path.split_once('[') else { return Some((Cow::Borrowed(path), 0)) };
    let (digits, rest) = rest.split_once(']')?;
    let index: u32 = digits.parse().ok().filter(|index: &u32| index.to_string() == digits)?;
    Some((Cow::Owned(format!("{list}[i]{rest}")), index))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_and_columns_are_unique() {
        let mut seen = std::collections::HashSet::new();
        let mut columns = std::collections::HashSet::new();
        let all = Key::all(|_| 12);
        assert_eq!(all.len(), Key::ALL.len() + 11 * (4 + 21));
        for key in &all {
            // A key that stands outside of the scene has no shorter name.
            let is_new = key.short() == key.path() || seen.insert(key.short());
            assert!(seen.insert(key.path()) && is_new, "{key:?}");
            assert_eq!(Key::find(&key.path()), Some(*key));
            assert_eq!(Key::find(&key.short()), Some(*key));
            assert!(columns.insert(key.column()), "{key:?}");
            assert_eq!(Key::of_column(&key.column()), Some(*key));
        }
        for table in
            (0..3).flat_map(|index| Table::ALL.iter().map(move |table| Table { index, ..*table }))
        {
            assert_eq!(Table::find(&table.path()).map(|found| found.path()), Some(table.path()));
            // A list and the base are keys too, under the same name.
            let is_key = Key::find(&table.path()).is_some_and(|key| key.column() == table.column());
            assert!(
                columns.insert(table.column()) || is_key || table.index > 0 && !table.has_index(),
                "{table:?}"
            );
        }
    }

    #[test]
    fn columns_of_steps_and_layers() {
        let column = |path: &str| Key::find(path).unwrap().column();
        assert_eq!(column("loading.steps[0].shift_x"), "shift_x");
        assert_eq!(column("loading.steps[0].force_x"), "step0_force_x");
        assert_eq!(column("loading.steps[12].shift_x"), "step12_shift_x");
        assert_eq!(column("foundation.layers[0].poisson"), "layer0_poisson");
        assert_eq!(Key::of_column("step0_shift_x"), None);
        for path in [
            "loading.steps[i].twist",
            "loading.steps[01].twist",
            "loading.steps[-1].twist",
            "loading.steps[].twist",
            "loading.steps.twist",
        ] {
            assert_eq!(Key::find(path), None, "{path}");
        }
    }

    #[test]
    fn every_table_holds_keys() {
        for table in Table::ALL.iter().filter(|table| !table.is_list()) {
            assert!(!table.names().is_empty(), "{table:?}");
        }
        assert_eq!(
            Table::find("loading").map(|t| t.names()),
            Some(vec!["steps", "cycle_from", "cycles"])
        );
        assert_eq!(Table::find("foundation").map(|t| t.names()), Some(vec!["layers", "base"]));
        assert_eq!(Table::find("loading.steps[3]").map(|t| t.names().len()), Some(21));
        let inside =
            |key: &str, table: &str| Key::find(key).unwrap().is_under(&Table::find(table).unwrap());
        assert!(
            inside("loading.steps[3].twist", "loading.steps[3]")
                && inside("loading.steps[3].twist", "loading.steps")
        );
        assert!(
            !inside("loading.steps[3].twist", "loading.steps[2]")
                && !inside("loading.steps", "loading.steps[0]")
        );
        assert!(
            inside("foundation.base", "foundation.base")
                && inside("foundation.layers", "foundation")
        );
    }
}
